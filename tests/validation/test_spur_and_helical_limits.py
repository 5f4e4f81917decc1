"""Limits of the model for vanishing cone angle, helix angle or shaft angle.

Flanks. In the plane z a flank cut without parabola is the involute of its base circle,

    theta = sigma [(pi/2 + 2 x cos(b) tan(a_t)) / N + inv(a_t) - inv(a(r))] + z tan(b_f) / r_P,

with r cos(a(r)) = r_P cos(a_t). The plane rack flank of the pressure angle a_n, turned by the helix
angle b and tilted by the cone angle g, meets the transverse plane and the pitch cylinder under

    tan(a_t) = tan(a_n) cos(g) / cos(b) - sigma tan(b) sin(g)
    tan(b_f) = tan(b) cos(g) + sigma tan(a_n) sin(g) / cos(b),

the formulas usual for conical involute gears, different on the right (sigma = 1) and the left flank.
Without a cone angle they are those of helical gears, with neither those of spur gears.

Pairs. Flanks on nearly parallel axes still touch in a point, which moves along the common normal. For
spur gears the contact ratio tends to

    [sqrt(r_a1^2 - r_b1^2) + sqrt(r_a2^2 - r_b2^2) - a sin(a_w)] / (pi m cos(a)),

for helical gears to that in the transverse plane over cos^2(b_b): the normal is inclined to the transverse
plane by the base helix angle, and the normal base pitch is the shorter by its cosine. It is the
contact ratio of the virtual spur gears of ISO 6336.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, atan, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import Design, Member, Pair, Tool, zero_backlash_layout
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import path_ends
from beveloid_geom.gear.flank import base_cylinder, flank_point, half_thickness_angle
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.status import Limit

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
    """Return inv(a) from cos(a)."""
    tangent = np.sqrt(1.0 / np.asarray(cosine) ** 2 - 1.0)
    return np.asarray(tangent - np.arctan(tangent))


def angles(member: Member, flank: str) -> tuple[float, float, float]:
    """Return tan(a_t), tan(b_f) and the pitch radius."""
    alpha, beta = float(member.tool.normal_pressure_angle), float(member.helix_angle)
    gamma, side = float(member.cone_angle), FLANKS[flank]
    transverse = tan(alpha) * cos(gamma) / cos(beta) - side * tan(beta) * sin(gamma)
    helix = tan(beta) * cos(gamma) + side * tan(alpha) * sin(gamma) / cos(beta)
    return transverse, helix, float(member.tool.normal_module) * float(member.teeth) / (2 * cos(beta))


def active_points(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Return flank parameters l and z (13, 7) over the complete active flank."""
    z = np.linspace(-0.5, 0.5, 7) * member.face_width
    low, high = root_parameter(member, flank), tip_parameter(member, flank, z)
    return low + (high - low) * np.linspace(0.0, 1.0, 13)[:, None], np.broadcast_to(z, (13, 7))


@pytest.mark.parametrize("name", MEMBERS)
def test_flanks_are_involute_helicoids(name: str, flank: str) -> None:
    member = MEMBERS[name]
    transverse, helix, pitch = angles(member, flank)
    cosine = cos(atan(transverse))
    l, z = active_points(member, flank)
    point = flank_point(member, flank, l, z=z)
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


def classical(teeth: tuple[int, int], beta: float, shift: tuple[float, float]) -> tuple[float, float, float]:
    """Return centre distance, transverse working pressure angle and transverse contact ratio of helical
    gears on parallel axes without backlash, by the usual formulas (ISO 21771)."""
    alpha_t = atan(tan(ALPHA) / cos(beta))
    wanted = tan(alpha_t) - alpha_t + 2 * tan(ALPHA) * sum(shift) / sum(teeth)
    working = float(brentq(lambda angle: tan(angle) - angle - wanted, 0.05, 1.2, xtol=1e-15))
    pitch = [MODULE * n / (2 * cos(beta)) for n in teeth]
    centre = sum(pitch) * cos(alpha_t) / cos(working)
    reach = -centre * sin(working)
    for r, x in zip(pitch, shift, strict=True):
        reach += sqrt((r + (1.0 + x) * MODULE) ** 2 - (r * cos(alpha_t)) ** 2)
    return centre, working, reach * cos(beta) / (pi * MODULE * cos(alpha_t))


def crossed(
    teeth: tuple[int, int], beta: float, shift: tuple[float, float], leans: tuple[float, float]
) -> tuple[float, float, float]:
    """Return offset, normal working pressure angle and contact ratio without backlash; the helix angles
    are beta and -beta plus the small angles in `leans`."""
    helix = beta + leans[0], -beta + leans[1]
    pinion, gear = (Member(TOOL, n, b, 0.0, x, 200.0) for n, b, x in zip(teeth, helix, shift, strict=True))
    layout = zero_backlash_layout(Design(pinion, gear, Pair(1.0, 1.0)))
    pair = Pair(float(layout.offset), float(layout.shaft_angle), 0.0, 0.0)
    ends = path_ends(Design(pinion, gear, pair))
    assert {ends.enter, ends.leave} == {Limit.GEAR_TIP, Limit.PINION_TIP}
    return float(layout.offset), float(layout.pressure_angle), float(ends.contact_ratio)


def limit_of(rows: FloatArray, order: int) -> FloatArray:
    """Return the limits of rows at steps that are halved, whose error is a series in step^order."""
    for k in range(1, len(rows)):
        factor = 2.0 ** (order * k)
        rows = (factor * rows[1:] - rows[:-1]) / (factor - 1.0)
    return np.asarray(rows[0])


CASES = [
    ((24, 37), 0.0, (0.0, 0.0)),
    ((20, 33), 0.0, (0.4, 0.25)),
    ((29, 45), radians(15.0), (0.0, 0.0)),
    ((21, 60), radians(25.0), (0.3, -0.1)),
]
STEPS_DEG = (4.0, 2.0, 1.0, 0.5)


@pytest.mark.parametrize(("teeth", "beta", "shift"), CASES)
@pytest.mark.parametrize("share", [0.5, 0.0])
def test_parallel_axes(teeth: tuple[int, int], beta: float, shift: tuple[float, float], share: float) -> None:
    """Layout and contact ratio tend to those of parallel axes, at shaft angles down to the smallest allowed
    value, 0.5 deg. `share` is the share of the pinion in this angle."""
    rows = np.array([crossed(teeth, beta, shift, _leans(step, share)) for step in STEPS_DEG])
    centre, working, ratio = classical(teeth, beta, shift)
    base_helix = asin(sin(beta) * cos(ALPHA))
    normal = asin(sin(working) * cos(base_helix))
    exact = np.array([centre, normal, ratio / cos(base_helix) ** 2])
    order = 2 if beta == 0.0 else 1  # the mirror image of spur gears is inclined in the other sense
    steps = np.abs(np.diff(rows, axis=0))
    moving = steps[-1] > 1e-9 * exact
    assert moving.any()
    found = np.log2(steps[-2, moving] / steps[-1, moving])
    np.testing.assert_allclose(found, order, atol={1: 0.3, 2: 0.01}[order])
    np.testing.assert_allclose(limit_of(rows, order), exact, rtol={1: 1e-5, 2: 1e-9}[order])


def _leans(step_deg: float, share: float) -> tuple[float, float]:
    return share * radians(step_deg), (1.0 - share) * radians(step_deg)
