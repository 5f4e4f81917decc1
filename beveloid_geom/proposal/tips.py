"""How far tips stay from the fillets of the mate: what is left of the mate's flank below them.

Unmodified flanks that are in contact touch the plane of their common normal from either side: an involute
helicoid lies, as far as a tooth has it, on its own side of each of its tangent planes. Nothing of one flank
then reaches into the other; only a fillet, hollow as it is, crosses that plane, where the tip of the mate goes
deeper than the flank does. A point of the tip edge comes nearest to the mate's flank where it is in mesh, where

    N.(k_j x X) = -(N_j / N_m) N.(k_m x (X - C)),

that of the conjugate flank which the tip would cut on a mate that turns at the constant ratio. With the own
normal N and moment M = P x n of the point, turned by phi about the own axis, this is A cos(phi) + B sin(phi)
= D: of both rolls that one is meant at which N is nearer to the common normal. If the flank of the mate goes
deeper than all these points, no tip meets a fillet; if not it still may pass, by the flanks' parting beside
their path.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..design.model import Design, Member
from ..gear.flank import flank_patch, flank_point, root_parameter, tip_parameter, trace_parameter
from ..gear.rack import rack_of
from ..pair.closing import ClosedLayout
from ..pair.frames import Layout, layout_at, normal_of_unmodified

PLACES = np.linspace(-0.5, 0.5, 7)[:, None]
"""Of a tip edge, over the narrower face."""


def left_below_tips(design: Design, closed: ClosedLayout, flank: str, normal_x: FloatArray) -> FloatArray:
    """Find how much deeper than the mate's tip edge the active flanks of pinion and gear go.

    Parameters
    ----------
    design : Design
        n pairs that close, unmodified, in their `closed` layout.
    flank : {'right', 'left'}
    normal_x : ndarray, shape (n)
        x component of the common normal.

    Returns
    -------
    ndarray, shape (2, n)
        Of pinion and gear, radially, mm, where it is least; negative where a tip goes deeper. NaN where a
        flank does not reach its tip, -inf where a tip is nowhere in mesh.
    """
    layout, members = (
        layout_at(closed.offset, design.sense * closed.shaft_angle, design.sense),
        design.members,
    )
    racks = [rack_of(member, flank) for member in members]
    axial = np.array([rack.normal[2] for rack in racks])
    moment = np.array([rack.pitch_radius * rack.normal[1] for rack in racks])
    normal_y = normal_of_unmodified(layout, axial, moment).y
    width = np.minimum(*(np.asarray(member.face_width, dtype=float) for member in members))
    found = []
    for j, (mate, member) in enumerate(zip(members, members[::-1], strict=True)):
        position = closed.mounting[::-1] if j == 0 else closed.mounting
        azimuth = np.arctan2(normal_y[1 - j], normal_x)
        found.append(_left(layout, member, mate, position, flank, azimuth, PLACES * width).min(axis=0))
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
    """Give what is left (places, n) of the mate's flank below the tip edge of a member in planes z. All is in
    the member's own fixed frame, in which the axis of the mate goes through (E, 0, 0) along (0, sin d, cos d);
    `position` (2, n): of member and mate along their axes, mm; `azimuth`: of its own outward normal there."""
    l = tip_parameter(member, flank, z)
    tip = flank_patch(member, flank, l, trace_parameter(member, flank, l, z))
    (nx, ny, nz), (mx, my, mz) = (
        np.moveaxis(v, -1, 0) for v in (tip.normal, np.cross(tip.point, tip.normal))
    )
    offset, sin_d, cos_d = layout.offset, layout.sin_angle, layout.cos_angle
    cos = sin_d * (my + position[0] * nx) - offset * cos_d * ny
    sin = sin_d * (mx - position[0] * ny) - offset * cos_d * nx
    rest = -(np.asarray(mate.teeth) / member.teeth + cos_d) * mz - offset * sin_d * nz
    share = rest / np.hypot(cos, sin)
    turn = np.arccos(np.clip(share, -1.0, 1.0))
    both = np.arctan2(sin, cos) + np.stack((turn, -turn))
    near = np.cos(both - azimuth + np.arctan2(ny, nx))
    roll = np.where(near[0] > near[1], *both)
    x, y, z_own = np.moveaxis(tip.point, -1, 0)
    x, y, z_own = (
        np.cos(roll) * x - np.sin(roll) * y - offset,
        np.sin(roll) * x + np.cos(roll) * y,
        z_own + position[0],
    )
    along, across = sin_d * y + cos_d * z_own, cos_d * y - sin_d * z_own
    root = root_parameter(mate)
    start = flank_point(mate, flank, root, trace_parameter(mate, flank, root, along - position[1]))
    left = np.hypot(x, across) - np.hypot(start[..., 0], start[..., 1])
    return np.where(np.abs(share) > 1.0, -np.inf, left)
