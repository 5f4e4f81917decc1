"""How far tips stay from the fillets of the mate: what is left of the mate's flank below them.

Unmodified flanks in contact lie on either side of the plane that touches both: a section of an involute
helicoid is an involute, which stays for half a turn on its own side of each of its tangents. (At the ends of
wide faces of steep helix the plane touches the section below its base circle, and a flank crosses it near
its root; no pair is known whose flanks cut there.) A fillet is hollow and crosses that plane: what cuts is a
tip that goes deep. A point X of the tip edge with the outward normal N is in mesh with the conjugate flank of
the mate where

    k_j.(X x N) = -(N_j / N_m) k_m.((X - C) x N),

axes k_j through the origin and k_m through C, numbers of teeth N_j and N_m of its member and the mate. Turned
by phi about the own axis this is A cos(phi) + B sin(phi) = D. Of both phi that one is meant at which N is
nearer to the common normal. Where a tip goes deeper than the flank it still may pass the fillet, as flanks
part beside the path of contact. Beyond the mesh it goes deeper yet, so that it can meet the fillet where no
more than about 0.02 modules of the flank are left.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..design.model import Design, Member
from ..gear.flank import (
    flank_patch,
    flank_point,
    root_parameter,
    tip_parameter,
    trace_parameter,
    turned,
)
from ..gear.rack import rack_of
from ..pair.closing import ClosedLayout
from ..pair.frames import Layout, layout_at, normal_of_unmodified

PLACES = 0.5 * np.linspace(-1.0, 1.0, 15) * np.abs(np.linspace(-1.0, 1.0, 15))
"""Of a tip edge, over the narrower face: closer in its middle, where on axes that cross at a large angle the
tips are deepest along a few modules."""


def left_below_tips(
    design: Design,
    closed: ClosedLayout,
    flank: str,
    normal_x: FloatArray,
    places: FloatArray = PLACES,
) -> FloatArray:
    """Find how much deeper than the tip edge of the mate the active flanks of pinion and gear go.

    Parameters
    ----------
    design : Design
        n pairs that close, unmodified, in their `closed` layout.
    flank : {'right', 'left'}
    normal_x : ndarray, shape (n)
        x component of the common normal.
    places : ndarray
        Points of the tip edge, over the narrower face.

    Returns
    -------
    ndarray, shape (2, n)
        Of pinion and gear, radially, mm, where it is least; negative where a tip goes deeper. NaN where a
        flank does not reach its tip, -inf where a tip is nowhere in mesh.
    """
    layout = layout_at(closed.offset, design.sense * closed.shaft_angle, design.sense)
    members = design.members
    racks = [rack_of(member, flank) for member in members]
    axial = np.array([rack.normal[2] for rack in racks])
    moment = np.array([rack.pitch_radius * rack.normal[1] for rack in racks])
    width = np.minimum(*(np.asarray(member.face_width, dtype=float) for member in members))
    found = []
    with np.errstate(invalid="ignore", divide="ignore"):
        normal_y = normal_of_unmodified(layout, axial, moment).y
        for j, (mate, member) in enumerate(zip(members, members[::-1], strict=True)):
            position = closed.mounting[::-1] if j == 0 else closed.mounting
            azimuth = np.arctan2(normal_y[1 - j], normal_x)
            z = places[:, None] * width
            found.append(_left(layout, member, mate, position, flank, azimuth, z).min(axis=0))
    return np.stack(found)


def _left(
    layout: Layout,
    member: Member,
    mate: Member,
    position: FloatArray,
    flank: str,
    azimuth: FloatArray,
    z: FloatArray,
) -> FloatArray:
    """Give what is left (places, n), mm, of the mate's flank below the tip edge of a member in planes z, all
    in its own fixed frame, in which the axis of the mate goes through (E, 0, 0) along (0, sin d, cos d);
    `position` (2, n): of member and mate along their axes, mm; `azimuth` of its outward normal, rad."""
    l = tip_parameter(member, flank, z)
    tip = flank_patch(member, flank, l, trace_parameter(member, flank, l, z))
    vectors = tip.point, tip.normal, np.cross(tip.point, tip.normal)
    point, (nx, ny, nz), (mx, my, mz) = (np.moveaxis(vector, -1, 0) for vector in vectors)
    offset, sin_d, cos_d = layout.offset, layout.sin_angle, layout.cos_angle
    cos = sin_d * (my + position[0] * nx) - offset * cos_d * ny
    sin = sin_d * (mx - position[0] * ny) - offset * cos_d * nx
    rest = -(np.asarray(mate.teeth) / member.teeth + cos_d) * mz - offset * sin_d * nz
    share = rest / np.hypot(cos, sin)
    turn = np.arccos(np.clip(share, -1.0, 1.0))
    both = np.arctan2(sin, cos) + np.stack((turn, -turn))
    nearness = np.cos(both + np.arctan2(ny, nx) - azimuth)
    x, y, z = np.moveaxis(turned(np.where(nearness[0] > nearness[1], *both), *point), -1, 0)
    x, z = x - offset, z + position[0]
    along, across = sin_d * y + cos_d * z, cos_d * y - sin_d * z
    root = root_parameter(mate)
    start = flank_point(mate, flank, root, trace_parameter(mate, flank, root, along - position[1]))
    left = np.hypot(x, across) - np.hypot(start[..., 0], start[..., 1])
    return np.where(np.abs(share) > 1.0, -np.inf, left)
