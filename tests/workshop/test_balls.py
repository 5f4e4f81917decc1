"""Dimensions over balls: DIN 21773 for cylindrical gears, an independent search on the flanks of
beveloids."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, pi, radians, sin, tan
from typing import Any, cast

import numpy as np
import pytest
from scipy import optimize

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.gear.flank import base_cylinder, flank_patch
from beveloid_geom.gear.flank_limits import highest_parameter, root_parameter
from beveloid_geom.gear.undercut import undercut_of
from beveloid_geom.status import BallStatus
from beveloid_geom.workshop.balls import BALL_DIAMETERS_MM, ball_dimensions, ball_planes, recommended_ball
from tests.members import MEMBERS

ALPHA, MODULE = radians(20.0), 4.0
TOOL = Tool(MODULE, ALPHA)
CYLINDRICAL = [(24, 0.0, 0.0), (17, 0.0, 0.35), (31, 28.0, -0.1), (40, -12.0, 0.3), (91, 41.0, 0.0)]


def involute(angle: float) -> float:
    return tan(angle) - angle


def standard(teeth: int, beta: float, x: float, ball: float, thinner: float = 0.0) -> float:
    """Return the dimension over balls by DIN 21773 Eqs. (30), (31), (35), (36)."""
    alpha_t = atan(tan(ALPHA) / cos(beta))
    half = (pi - 4 * x * tan(ALPHA)) / (2 * teeth) - thinner / (MODULE * teeth)
    wanted = ball / (teeth * MODULE * cos(ALPHA)) - half + involute(alpha_t)
    angle = float(optimize.brentq(lambda a: involute(a) - wanted, 1e-6, 1.4, xtol=1e-15))
    centre = MODULE * teeth / cos(beta) * cos(alpha_t) / cos(angle)
    return centre * (cos(pi / (2 * teeth)) if teeth % 2 else 1.0) + ball


def ideal(teeth: int, beta: float, x: float) -> float:
    """Return the diameter of the ball that touches on the V-cylinder, by DIN 21773 Eqs. (26), (27)."""
    alpha_t, base_helix = atan(tan(ALPHA) / cos(beta)), np.arcsin(sin(beta) * cos(ALPHA))
    d = MODULE * teeth / cos(beta)
    alpha_v = np.arccos(d * cos(alpha_t) / (d + 2 * x * MODULE))
    half_base = (pi - 4 * x * tan(ALPHA)) / (2 * teeth) - involute(alpha_t)
    wanted = tan(alpha_v) + half_base * cos(base_helix) ** 2
    angle = optimize.brentq(lambda a: a + involute(a) * sin(base_helix) ** 2 - wanted, 0.0, 1.4, xtol=1e-15)
    return float(teeth * MODULE * cos(ALPHA) * (tan(angle) - tan(alpha_v)) / cos(base_helix) ** 2)


@pytest.mark.parametrize(("teeth", "helix_deg", "x"), CYLINDRICAL)
def test_cylindrical_gears_agree_with_the_standard(teeth: int, helix_deg: float, x: float) -> None:
    beta = radians(helix_deg)
    member = Member(TOOL, teeth, beta, 0.0, x, 30.0)
    ball = recommended_ball(member)
    assert ball == BALL_DIAMETERS_MM[np.searchsorted(BALL_DIAMETERS_MM, ideal(teeth, beta, x))]
    found = ball_dimensions(member, ball, ball_planes(member, ball), (0.0, -0.08))
    for row, thinner in zip(found.dimension, (0.0, -0.08), strict=True):
        np.testing.assert_allclose(row, standard(teeth, beta, x, ball, thinner), atol=1e-9)


def nearest(member: Member, flank: str, turn: float, point: FloatArray) -> float:
    """Return the distance of a point from a flank that is rotated by `turn`, by a search over l and z."""
    low, high = 1.3 * float(root_parameter(member, "right")), 1.3 * float(highest_parameter(member, "right"))
    (x, y, height), c, s = point, cos(turn), sin(turn)
    target = c * x + s * y, c * y - s * x, height

    def square(at: FloatArray) -> FloatArray:
        l, z = at[..., 0], at[..., 1]
        found = flank_patch(member, flank, l, z=z)
        away = ((found.point - target) ** 2).sum(axis=-1)
        return np.asarray(np.where(found.regularity > 0.0, away, np.inf))  # no sheet that undercut removes

    grid = np.stack(np.meshgrid(np.linspace(low, high, 81), height + np.linspace(-8, 8, 81)), axis=-1)
    start = grid.reshape(-1, 2)[square(grid.reshape(-1, 2)).argmin()]
    options, search = {"xatol": 1e-9, "fatol": 1e-14}, cast(Any, optimize.minimize)
    return float(np.sqrt(search(square, start, method="Nelder-Mead", options=options).fun))


@pytest.mark.parametrize("name", ["pinion", "gear", "concave", "convex", "cone 20"])
def test_beveloids_agree_with_a_search_on_the_flanks(name: str) -> None:
    """Radius and angle of the centre agree with a search for the centre at which both flanks are at the
    distance of the ball radius, to 1e-6 mm."""
    member = MEMBERS[name]
    ball = recommended_ball(member)
    found, pitch = ball_dimensions(member, ball, ball_planes(member, ball)), 2.0 * pi / float(member.teeth)
    assert (found.status == BallStatus.MEASURED).all()
    for k in (0, 2):

        def off(at: FloatArray, z: float = float(found.z[k])) -> list[float]:
            point = np.array((at[0] * cos(at[1]), at[0] * sin(at[1]), z))
            sides = (nearest(member, flank, turn, point) for flank, turn in (("right", 0.0), ("left", pitch)))
            return [side - 0.5 * ball for side in sides]

        start = np.array((found.radius[0, k] + 0.05, found.angle[0, k] + 0.0005))
        radius, _ = optimize.fsolve(off, start, xtol=1e-11, epsfcn=1e-8)
        across = 2.0 * radius * (cos(0.5 * pi / float(member.teeth)) if int(member.teeth) % 2 else 1.0)
        assert found.dimension[0, k] == pytest.approx(across + ball, abs=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 4, 5, 6, 7, 9, 10, 13, 14])
def test_balls_on_steep_cones_agree_with_balls_on_one_flank(seed: int) -> None:
    """A ball is placed on a point of the right flank, and its size follows from a search on the left flank.
    Seeds at which the centre is inside a base cylinder are left out, because no perpendicular to the flank
    passes through it."""
    draw = np.random.default_rng(seed)
    helix, cone, x = radians(draw.uniform(-20, 20)), radians(draw.uniform(30, 43)), draw.uniform(-0.2, 0.3)
    width = float(draw.uniform(3, 6) * MODULE)
    member = Member(TOOL, int(draw.integers(20, 60)), helix, cone, x, width)
    pitch, z = 2.0 * pi / int(member.teeth), float(draw.uniform(-0.3, 0.1) * width)
    cut = undercut_of(member, "right")
    l = float(np.interp(z, cut.z, cut.start)) + draw.uniform(0.1, 0.4) * MODULE
    patch = flank_patch(member, "right", l, z=z)

    def gap(size: float) -> float:
        return nearest(member, "left", pitch, patch.point + size * patch.normal) - size

    half = optimize.brentq(gap, 0.1 * MODULE, 4.0 * MODULE)
    centre = patch.point + half * patch.normal
    radius = float(np.hypot(*centre[:2]))
    assert radius > max(float(base_cylinder(member, flank).radius) for flank in FLANK_SIGN)
    found = ball_dimensions(member, 2.0 * half, centre[2])
    assert found.status[0, 0] != BallStatus.NOT_FOUND
    assert found.radius[0, 0] == pytest.approx(radius, abs=1e-6)
    assert found.angle[0, 0] == pytest.approx(float(np.arctan2(centre[1], centre[0])), abs=1e-8)


def test_a_ball_touches_a_beveloid_on_both_sides_of_its_plane() -> None:
    found = ball_dimensions(MEMBERS["pinion"], 10.5, 0.0)
    right, left = found.contact_z[:, 0, 0]
    assert right * left < 0.0
    assert abs(right + left) > 0.01
    assert abs(np.diff(found.contact_radius[:, 0, 0])[0]) > 0.01


@pytest.mark.parametrize(
    ("ball", "status"),
    [
        (4.0, BallStatus.NOT_FOUND),
        (6.0, BallStatus.ON_BOTTOM),
        (8.0, BallStatus.BELOW_TIP),
        (20.0, BallStatus.OFF_FLANK),
    ],
)
def test_balls_without_dimension_have_a_status(ball: float, status: BallStatus) -> None:
    found = ball_dimensions(MEMBERS["pinion"], ball, 0.0)
    assert (int(found.status[0, 0]), np.isnan(found.dimension[0, 0])) == (status, True)


def test_a_ball_that_touches_beyond_the_face_is_reported() -> None:
    """A ball with its centre at the toe of a helical member touches one flank beyond the face, which its
    status states."""
    member = MEMBERS["pinion"]
    toe = -0.5 * float(member.face_width)
    assert ball_dimensions(member, 10.5, toe).status[0, 0] == BallStatus.OFF_FLANK
    narrow = replace(member, face_width=6.0)
    assert (ball_planes(narrow, 10.5) == 0.0).all()
    assert ball_dimensions(narrow, 10.5, 0.0).status[0, 0] == BallStatus.MEASURED
