"""Rough starting value: the contact at the pitch point of two pitch cones that touch.

The error is about 20 mm along the axes and a degree of roll on ordinary crossed pairs. No reference result
depends on it."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from ..arrays import FLANK_SIGN
from ..design.member import Member
from ..design.model import Design

Vector = NDArray[np.float64]
Guess = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class PitchRegion:
    """Layout of the unmodified pair without errors near the pitch point, in S_f."""

    mounting: tuple[float, float]  # mounting distances of pinion and gear, mm
    plane_normal: tuple[float, float, float]  # of the common tangent plane, from pinion to gear
    # Angle of the pitch point about each axis, rad, from the x axis of the member's frame at roll 0.
    pitch_point_angle: tuple[float, float]


def hand_of_pair(design: Design) -> float:
    """Return the sign of the shaft angle: that of the sum of the helix angles; if the sum is 0, that of the
    pinion helix angle, + for straight teeth."""
    first, second = (float(member.helix_angle) for member in design.members)
    total = first + second
    return -1.0 if (first if abs(total) < 1e-9 else total) < 0.0 else 1.0


def pitch_region(design: Design) -> PitchRegion:
    """Return the layout in which the two pitch cones touch at one point.

    A pitch cone has the cone angle of the member and, at mid-face, the reference radius plus the profile
    shift.

    Parameters
    ----------
    design : Design
        A single design.

    Returns
    -------
    PitchRegion
    """
    # Rounding error of n_x squared if the axes intersect and the normal lies in the plane of both axes.
    square_rounding = 1e-12
    gamma1, gamma2 = (float(member.cone_angle) for member in design.members)
    shaft = hand_of_pair(design) * float(design.pair.shaft_angle)
    k1: Vector = np.array([0.0, 0.0, 1.0])
    k2: Vector = np.array([0.0, sin(shaft), cos(shaft)])
    # The plane touches both cones: normal . k1 = -sin(gamma1), normal . k2 = +sin(gamma2).
    normal_z = -sin(gamma1)
    normal_y = (sin(gamma2) - normal_z * cos(shaft)) / sin(shaft)
    squared = 1.0 - normal_y**2 - normal_z**2
    if squared <= -square_rounding:
        raise ArithmeticError("the pitch cones have no common tangent plane")
    normal: Vector = np.array([sqrt(max(squared, 0.0)), normal_y, normal_z])
    radial1 = (normal + sin(gamma1) * k1) / cos(gamma1)
    radial2 = (-normal + sin(gamma2) * k2) / cos(gamma2)
    closure = _mid_face_radius(design.gear) * radial2 - _mid_face_radius(design.pinion) * radial1
    mounting2 = -closure[1] / sin(shaft)
    mounting1 = closure[2] + mounting2 * cos(shaft)
    # Gear frame: X2 = -x, Y2 = k2 x X2 = (0, -cos, sin).
    angle2 = atan2(-cos(shaft) * radial2[1] + sin(shaft) * radial2[2], -radial2[0])
    return PitchRegion(
        mounting=(float(mounting1), float(mounting2)),
        plane_normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        pitch_point_angle=(atan2(radial1[1], radial1[0]), angle2),
    )


def pitch_guess(design: Design, flank: str) -> Guess:
    """Return a rough (l1, u1, l2, u2, phi1, phi2) of the contact at the pitch point.

    It is valid for a design mounted near its pitch point, with small errors."""
    region = pitch_region(design)
    roll1, roll2 = (
        # Minus half the angular thickness of the tooth at the rolling circle, s0 / (2 cos(beta) r_P).
        angle - FLANK_SIGN[flank] * pi / (2.0 * float(member.teeth))
        for angle, member in zip(region.pitch_point_angle, design.members, strict=True)
    )
    # On the reference lines of the tools; l is measured from the apex of the parabola.
    l1, l2 = (0.0 - float(member.tool.parabola_apex) for member in design.members)
    return (l1, 0.0, l2, 0.0, roll1, roll2)


def _mid_face_radius(member: Member) -> float:
    module = float(member.tool.normal_module)
    return module * (
        float(member.teeth) / (2.0 * cos(float(member.helix_angle))) + float(member.profile_shift)
    )
