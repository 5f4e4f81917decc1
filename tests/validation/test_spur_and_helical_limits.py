"""Flanks where cone angle or helix angle vanish.

Flanks. In the plane z a flank cut without parabola is the involute of its base circle,

    theta = sigma [(pi/2 + 2 x cos(b) tan(a_t)) / N + inv(a_t) - inv(a(r))] + z tan(b_f) / r_P,

with r cos(a(r)) = r_P cos(a_t). The plane rack flank of the pressure angle a_n, turned by the helix
angle b and tilted by the cone angle g, meets the transverse plane and the pitch cylinder under

    tan(a_t) = tan(a_n) cos(g) / cos(b) - sigma tan(b) sin(g)
    tan(b_f) = tan(b) cos(g) + sigma tan(a_n) sin(g) / cos(b),

the formulas usual for conical involute gears, different on the right (sigma = 1) and the left flank.
Without a cone angle they are those of helical gears, with neither those of spur gears.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, pi, radians, sin, tan

import numpy as np
import pytest

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import (
    base_cylinder,
    flank_point,
    half_thickness_angle,
    root_parameter,
    tip_parameter,
    trace_parameter,
)

MODULE, ALPHA = 4.0, radians(20.0)
TOOL = Tool(MODULE, ALPHA)
MEMBERS = {
    "spur": Member(TOOL, 24, 0.0, 0.0, 0.0, 40.0),
    "shifted spur": Member(TOOL, 17, 0.0, 0.0, 0.35, 40.0),
    "helical": Member(TOOL, 31, radians(28.0), 0.0, -0.1, 40.0),
    "left hand": Member(
        replace(TOOL, normal_pressure_angle=radians(24.0)), 19, radians(-41.0), 0.0, 0.3, 30.0
    ),
    "straight beveloid": Member(TOOL, 40, 0.0, radians(8.0), 0.1, 30.0),
    "beveloid": Member(TOOL, 35, radians(22.0), radians(5.0), 0.2, 30.0),
    "beveloid, left hand": Member(TOOL, 45, radians(-10.57), radians(12.0), -0.1, 25.0),
}
FLANKS = {"right": 1.0, "left": -1.0}


def involute(cosine: FloatArray | float) -> FloatArray:
    """inv(a) of cos(a)."""
    tangent = np.sqrt(1.0 / np.asarray(cosine) ** 2 - 1.0)
    return np.asarray(tangent - np.arctan(tangent))


def angles(member: Member, flank: str) -> tuple[float, float, float]:
    """tan(a_t), tan(b_f) and the pitch radius."""
    alpha, beta = float(member.tool.normal_pressure_angle), float(member.helix_angle)
    gamma, side = float(member.cone_angle), FLANKS[flank]
    transverse = tan(alpha) * cos(gamma) / cos(beta) - side * tan(beta) * sin(gamma)
    helix = tan(beta) * cos(gamma) + side * tan(alpha) * sin(gamma) / cos(beta)
    return transverse, helix, float(member.tool.normal_module) * float(member.teeth) / (2 * cos(beta))


def active_points(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Flank parameters l and z (13, 7) all over the active flank."""
    z = np.linspace(-0.5, 0.5, 7) * member.face_width
    low, high = root_parameter(member), tip_parameter(member, flank, z)
    return low + (high - low) * np.linspace(0.0, 1.0, 13)[:, None], np.broadcast_to(z, (13, 7))


@pytest.mark.parametrize("name", MEMBERS)
def test_flanks_are_involute_helicoids(name: str, flank: str) -> None:
    member = MEMBERS[name]
    transverse, helix, pitch = angles(member, flank)
    cosine = cos(atan(transverse))
    l, z = active_points(member, flank)
    point = flank_point(member, flank, l, trace_parameter(member, flank, l, z))
    np.testing.assert_allclose(point[..., 2], z, atol=1e-13)
    radius = np.hypot(point[..., 0], point[..., 1])
    base = pitch * cosine
    shift = 2.0 * float(member.profile_shift) * cos(float(member.helix_angle)) * transverse
    half = (0.5 * pi + shift) / float(member.teeth) + involute(cosine) - involute(base / radius)
    expected = FLANKS[flank] * half + z * helix / pitch
    off = radius * (np.arctan2(point[..., 1], point[..., 0]) - expected)
    assert np.abs(off).max() < 1e-12 * pitch
    np.testing.assert_allclose(
        radius * half_thickness_angle(member, flank, l, z),
        radius * (half + FLANKS[flank] * z * helix / pitch),
        atol=1e-12 * pitch,
    )


@pytest.mark.parametrize("name", MEMBERS)
def test_base_cylinders(name: str, flank: str) -> None:
    """r_b = r_P cos(a_t), tan(b_b) = tan(b_f) cos(a_t); right hand positive, unlike the axial component
    of the normal on the right flank."""
    member = MEMBERS[name]
    transverse, helix, pitch = angles(member, flank)
    cosine, found = cos(atan(transverse)), base_cylinder(member, flank)
    assert float(found.radius) == pytest.approx(pitch * cosine, rel=1e-14)
    assert -FLANKS[flank] * float(found.helix_angle) == pytest.approx(atan(helix * cosine), abs=1e-15)
    lever = MODULE * float(member.teeth) * cos(float(member.tool.normal_pressure_angle)) / 2
    assert float(found.radius) * cos(float(found.helix_angle)) == pytest.approx(lever, rel=1e-14)
