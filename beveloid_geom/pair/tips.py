"""Distance of tips from the fillets of the mate: depth of the flank of the mate below the tips.

Unmodified flanks in contact lie on opposite sides of their common tangent plane: a section of an involute
helicoid is an involute, which lies for half a turn on one side of each of its tangents. (At the ends of wide
faces with a large helix angle, the generator through the point of contact extends beyond its point on the
base cylinder. In such a section the plane touches the other branch of the involute, and the flank crosses
the plane near its root. No pair is known whose flanks overlap there.) A fillet is concave and crosses this
plane: only a tip that reaches deep enough can overlap with the mate. A point X of the tip edge with the
outward normal N is in mesh with the conjugate flank of the mate if

    k_j.(X x N) = -(N_j / N_m) k_m.((X - C) x N),

with the axes k_j through the origin and k_m through C, and the numbers of teeth N_j and N_m of its member
and the mate. With X rotated by phi about its axis, this is A cos(phi) + B sin(phi) = D. The
solution whose N is nearer to the common normal is used. A tip that reaches deeper than the flank
can still pass the fillet, because the flanks separate away from the path of contact. At rolls at which the
tip point is not in mesh, the tip reaches even deeper. It can therefore meet the fillet if less than about
0.02 modules of the flank are left.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..design.member import Member
from ..design.model import Design
from ..gear.flank import flank_patch, flank_point, turned
from ..gear.flank_limits import root_parameter, tip_parameter
from .frames import Layout, layout_of
from .generator_angle import normal_x_as_mounted
from .mounting import mounting_of, normal_of_flanks

CLEAR_DEPTH_MODULES = 0.02
"""Depth of flank below the tips of the mate, in modules, that prevents contact with the fillet."""
TIP_EDGE_POSITIONS = 0.5 * np.linspace(-1.0, 1.0, 15) * np.abs(np.linspace(-1.0, 1.0, 15))
"""Points of a tip edge as fractions of the narrower face. They are denser in the middle, because on axes with
a large shaft angle the tips are deepest over only a few modules.
"""


def depth_below_tips(
    design: Design,
    layout: Layout,
    mounting: FloatArray,
    flank: str,
    normal_x: FloatArray,
    places: FloatArray = TIP_EDGE_POSITIONS,
) -> FloatArray:
    """Return by how much the active flanks of pinion and gear are deeper than the tip edge of the mate.

    Parameters
    ----------
    design : Design
        n unmodified pairs.
    layout : Layout
        Axes of the pairs, without errors.
    mounting : ndarray, shape (2, n)
        Mounting distances of pinion and gear, mm.
    flank : {'right', 'left'}
    normal_x : ndarray, shape (n)
        x component of the common normal.
    places : ndarray
        Points of the tip edge as fractions of the narrower face.

    Returns
    -------
    ndarray, shape (2, n)
        Least radial distance on pinion and gear, mm. It is negative if a tip reaches deeper than the flank,
        NaN if a flank does not reach its tip, and -inf if any point of the tip edge is in mesh at no roll.
        Points of a tip edge that meet the mate beyond the ends of its face are ignored.
    """
    members = design.members
    width = np.minimum(*(np.asarray(member.face_width, dtype=float) for member in members))
    result = []
    with np.errstate(invalid="ignore", divide="ignore"):
        normal_y = normal_of_flanks(layout, members, flank)[0].y
        # Each member in turn is the one whose flank is measured.
        for j, (mate, member) in enumerate(zip(members, members[::-1], strict=True)):
            position = mounting[::-1] if j == 0 else mounting
            azimuth = np.arctan2(normal_y[1 - j], normal_x)
            z = places[:, None] * width
            result.append(_depth_below(layout, member, mate, position, flank, azimuth, z).min(axis=0))
    return np.stack(result)


def depth_below_tips_as_mounted(design: Design, flank: str) -> FloatArray:
    """Return `depth_below_tips` of a single design in its own layout.

    Parameters
    ----------
    design : Design
        A single design without parabolas, modifications and errors (`Design.bare`). This is not checked.
    flank : {'right', 'left'}

    Returns
    -------
    ndarray, shape (2,)
        mm, for pinion and gear.
    """
    normal_x, _ = normal_x_as_mounted(design, flank)
    distance = mounting_of(design).distance[:, None]
    depth = depth_below_tips(design, layout_of(design), distance, flank, np.atleast_1d(normal_x))
    return np.asarray(depth[:, 0])


def _depth_below(
    layout: Layout,
    member: Member,
    mate: Member,
    position: FloatArray,
    flank: str,
    azimuth: FloatArray,
    z: FloatArray,
) -> FloatArray:
    """Return the depth (places, n), mm, of the flank of the mate below the tip edge of a member in planes z.

    All is computed in the fixed frame of the member, in which the axis of the mate passes through (E, 0, 0)
    along (0, sin d, cos d). `position` (2, n): positions of member and mate along their axes, mm; `azimuth`
    (rad): direction of the outward normal.
    """
    l = tip_parameter(member, flank, z)
    tip = flank_patch(member, flank, l, z=z)
    vectors = tip.point, tip.normal, np.cross(tip.point, tip.normal)
    point, (nx, ny, nz), (mx, my, mz) = (np.moveaxis(vector, -1, 0) for vector in vectors)
    offset, sin_d, cos_d = layout.offset, layout.sin_angle, layout.cos_angle
    # A cos(phi) + B sin(phi) = D with both solutions phi.
    cos = sin_d * (my + position[0] * nx) - offset * cos_d * ny
    sin = sin_d * (mx - position[0] * ny) - offset * cos_d * nx
    remaining = -(np.asarray(mate.teeth) / member.teeth + cos_d) * mz - offset * sin_d * nz
    share = remaining / np.hypot(cos, sin)
    turn = np.arccos(np.clip(share, -1.0, 1.0))
    both = np.arctan2(sin, cos) + np.stack((turn, -turn))
    nearness = np.cos(both + np.arctan2(ny, nx) - azimuth)
    x, y, z = np.moveaxis(turned(np.where(nearness[0] > nearness[1], *both), *point), -1, 0)
    x, z = x - offset, z + position[0]
    along, across = sin_d * y + cos_d * z, cos_d * y - sin_d * z
    root = root_parameter(mate, flank)
    start = flank_point(mate, flank, root, z=along - position[1])
    depth = np.hypot(x, across) - np.hypot(start[..., 0], start[..., 1])
    depth = np.where(np.abs(share) > 1.0, -np.inf, depth)
    # Beyond toe or heel of the mate there is no flank.
    return np.where(np.abs(along - position[1]) > 0.5 * np.asarray(mate.face_width), np.inf, depth)
