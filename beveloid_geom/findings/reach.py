"""Offsets at which the members of a pair reach each other.

Offset and shaft angle of a pair are not independent. Pitch cones with half angles g_1, g_2 that roll on each
other touch a common plane, in which their generators enclose an angle s,

    cos(d) = cos(g_1) cos(g_2) cos(s) - sin(g_1) sin(g_2),
    E = (r_1 cos(g_2) + r_2 cos(g_1)) sin(s) / sin(d),

with the shaft angle d, the offset E and the radii r_1, r_2 of the cones at mid-face. For contact along the
tooth traces, s is the sum of the working helix angles. The same equations with the tip radii, or with one tip
and one root radius, give the offsets at which tips just meet tips, or meet bottom lands.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ..arrays import Quantity
from ..design.model import Design
from ..gear.fillet import root_radius
from ..gear.flank_limits import tip_radius


@dataclass(frozen=True)
class Reach:
    """Offsets at the shaft angle of a design, mm, with the mid-faces opposite each other.

    Below `touching` tips reach each other; below `bottoming` a tip reaches the bottom land of the mate.
    `rolling_angle` is the angle between the generators of the pitch cones, rad. All are NaN if the cones have
    no common tangent plane."""

    touching: float
    bottoming: float
    rolling_angle: float


def rolling_generator_angle(cone_angles: Iterable[Quantity], shaft_angle: float) -> float:
    """Return the angle s between the generators of rolling cones, rad.

    It is NaN if the cones have no common tangent plane."""
    # Rounding error of cos(s) on intersecting axes, where s = 0.
    cosine_rounding = 1e-12
    first, second = (float(angle) for angle in cone_angles)
    cosine = (math.cos(shaft_angle) + math.sin(first) * math.sin(second)) / (
        math.cos(first) * math.cos(second)
    )
    if abs(cosine - 1.0) < cosine_rounding:
        return 0.0
    return math.acos(cosine) if abs(cosine) <= 1.0 else math.nan


def reach_of(design: Design) -> Reach:
    """Return the offsets at which the members of a single design reach each other, without errors."""
    pinion, gear = design.members
    shaft_angle = float(design.pair.shaft_angle)
    rolling_angle = rolling_generator_angle((pinion.cone_angle, gear.cone_angle), shaft_angle)
    factor = math.sin(rolling_angle) / math.sin(shaft_angle) if shaft_angle > 0.0 else math.nan

    def offset(pinion_radius: float, gear_radius: float) -> float:
        return factor * (
            pinion_radius * math.cos(gear.cone_angle) + gear_radius * math.cos(pinion.cone_angle)
        )

    tips = [float(tip_radius(member, 0.0)) for member in design.members]
    roots = [float(root_radius(member, 0.0)) for member in design.members]
    bottoming = max(offset(tips[0], roots[1]), offset(roots[0], tips[1]))
    return Reach(offset(*tips), bottoming, rolling_angle)
