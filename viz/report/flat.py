"""Flanks laid flat for charts: along the face to the right, towards the tip upwards, in mm.

Right flanks are then seen from outside, left ones through the tooth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Member
from beveloid_geom.gear.flank import flank_point, root_parameter, tip_parameter, trace_parameter

from ..parts.panels import FlankView, flank_view

FACE, DEPTH = 25, 9
"""Points along the sides of an outline."""


@dataclass(frozen=True, eq=False)
class FlatFlank:
    """One active flank of `member`, with its outline (n, 2) in the plane square on to its middle: x from
    mid-face towards the heel, y from the root at mid-face towards the tip, mm."""

    member: Member
    flank: str
    view: FlankView
    outline: FloatArray

    def place(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) of the member's own frame in the chart (..., 2)."""
        flat = self.view.place(points)[..., 1::-1]
        return np.asarray(flat - self.view.frame[0, 1, 1::-1] * (0.0, 1.0))

    def at(self, l: FloatArray, z: FloatArray) -> FloatArray:
        """Places (..., 2) of flank parameters l in the planes z, mm."""
        return self.place(
            flank_point(self.member, self.flank, l, trace_parameter(self.member, self.flank, l, z))
        )

    @property
    def span(self) -> FloatArray:
        """Width and height, mm."""
        return np.asarray(np.ptp(self.outline, axis=0))


def flat_flank(member: Member, flank: str) -> FlatFlank | None:
    """The flank laid flat; None if it does not reach its tip."""
    view = flank_view(member, flank)
    if view is None:
        return None
    half, root = 0.5 * float(member.face_width), root_parameter(member)
    along, up = half * np.linspace(-1.0, 1.0, FACE), np.linspace(0.0, 1.0, DEPTH)
    tip = tip_parameter(member, flank, along)
    l = [root + 0.0 * along, root + up * (tip[-1] - root), tip[::-1], root + up[::-1] * (tip[0] - root)]
    z = [along, half + 0.0 * up, along[::-1], -half + 0.0 * up]
    flat = FlatFlank(member, flank, view, np.zeros((0, 2)))
    outline = flat.at(np.concatenate(l), np.concatenate(z))
    return FlatFlank(member, flank, view, outline) if np.isfinite(outline).all() else None
