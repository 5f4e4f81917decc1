"""Sliding against closed forms, 60 digits, differences along the path, and symmetry."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest

from beveloid_geom import ContactPath, Design, Errors, Status, path_of_contact, path_sliding
from beveloid_geom.analysis.sliding import Sliding, least_along, least_sliding
from beveloid_geom.gear.flank import base_cylinder, flank_patch
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.sliding import columns_of, sliding_report
from beveloid_geom.validation.five_equations_mp import MP, solve_mp

from ..contact.test_path_search import TURNING
from ..oracle.sixty_digits import numbers_of
from ..oracle.table1 import table1
from ..stability.named_designs import CROSSING
from ..symmetry import exchanged, mirrored
from ..validation.test_crossed_helical import Shifted, closed_form

MODIFIED = (0.001, -0.001)
CASES = {
    "as designed": table1(),
    "modified": table1(MODIFIED),
    "both positive": table1((0.0002, 0.0002)),
    "misaligned": table1(MODIFIED, Errors(0.1, 1e-4, 0.2, -0.1)),
}
cases = pytest.mark.parametrize("design", CASES.values(), ids=CASES)
INVARIANT = ("gear_rate", "speed", "specific", "specific_total")
STEP = MP.mpf(10) ** -18


def along(design: Design, flank: str = "right", points: int = 9) -> tuple[ContactPath, Sliding]:
    path = path_of_contact(design, flank, points)
    return path, path_sliding(path)


@pytest.mark.parametrize("design", [*CASES.values(), *CROSSING.values(), *TURNING.values()])
def test_the_equation_of_meshing_is_satisfied(design: Design) -> None:
    path, found = along(design)
    assert (path.status == Status.SOLVED).all()
    size = np.abs(found.contact_velocity).max() + np.abs(found.pinion_velocity).max()
    assert np.abs(np.einsum("ki,ki->k", path.normal, found.sliding)).max() < 1e-13 * size
    assert np.abs(np.einsum("ki,kji->kj", path.normal, found.rolling)).max() < 1e-11 * size
    between = found.rolling[:, 1] - found.rolling[:, 0]
    np.testing.assert_allclose(between, found.sliding, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(
        np.hypot(found.profile, found.lengthwise).T - found.speed, 0.0, atol=1e-12 * size
    )
    slid = found.speed[:, None] / np.linalg.norm(found.rolling, axis=-1)
    np.testing.assert_allclose(found.specific_total, slid, rtol=1e-14)


@pytest.mark.parametrize("design", [*CASES.values(), *CROSSING.values()])
def test_against_differences_at_60_digits(design: Design) -> None:
    path, found = along(design, points=5)
    dw1, dw2 = (MP.mpf(float(value)) for value in mounting_of(design).distance)
    for k in (0, 2, 4):
        guess = numbers_of(path, k)
        near = [
            solve_mp(design, "right", guess, ("phi1", MP.mpf(guess[4]) + step), (dw1, dw2))
            for step in (-STEP, STEP)
        ]
        velocity = [float((b - a) / (2 * STEP)) for a, b in zip(*(x.point for x in near), strict=True)]
        assert found.contact_velocity[k] == pytest.approx(velocity, rel=1e-9, abs=1e-9)
        assert found.gear_rate[k] == pytest.approx(
            float((near[1].phi2 - near[0].phi2) / (2 * STEP)), abs=1e-12
        )


HELICAL = [
    ((29, 45), (25.0, -10.57)),
    ((15, 24), (20.0, 30.0)),
    ((20, 20), (45.0, 45.0)),
    ((40, 23), (-30.0, 12.0)),
]


def crossed_helical(teeth: tuple[int, int], helix: tuple[float, float]) -> Design:
    """Return cylindrical gears without profile shift at their reference pitch point (r_1, 0, 0)."""
    offset, _ = closed_form(teeth, helix)
    return Shifted(6.0, radians(20.0), teeth, helix, (0.0, 0.0)).design(offset, abs(sum(helix)))


@pytest.mark.parametrize(("teeth", "helix_deg"), HELICAL)
def test_crossed_helical_gears_in_closed_form(
    teeth: tuple[int, int], helix_deg: tuple[float, float], flank: str
) -> None:
    """At the pitch point the sliding velocity is r_1 sin(d)/cos(beta_2), along the tooth trace t. At the
    distance s from it along the normal, s (w_1 - w_2) x n is added, with components along t, along the
    normal of the pitch plane and across t."""
    b1, b2 = (radians(helix) for helix in helix_deg)
    design = crossed_helical(teeth, (b1, b2))
    path, found = along(design, flank, 21)
    first = 3.0 * teeth[0] / cos(b1) * sin(b1 + b2) / cos(b2)
    ratio, alpha = teeth[0] / teeth[1], radians(20.0)
    across, parallel = ratio * sin(b2) - sin(b1), cos(b1) + ratio * cos(b2)
    point = (3.0 * teeth[0] / cos(b1), 0.0, 0.0)
    s = (path.point - point) @ path.normal[0]
    speed = np.hypot(first - s * across * sin(alpha), s * parallel)
    np.testing.assert_allclose(found.speed, speed, rtol=1e-11)
    both = np.hypot(across * sin(alpha), parallel)
    roll, least = least_sliding(found)
    assert least == pytest.approx(abs(first) * parallel / both, rel=1e-10)
    nearest, _ = least_along(path.pinion_roll, s**2)  # the pitch point
    base = 3.0 * teeth[0] * cos(alpha) * (1.0 if flank == "right" else -1.0)
    assert roll - nearest == pytest.approx(first * across * sin(alpha) / both**2 / base, abs=1e-9)
    away = np.abs(s) > 1e-6  # nothing slides along the profile at the pitch point, and only there
    above = np.sign(path.pinion_r - point[0])[:, None]
    assert (np.sign(found.specific) == above * (1.0, -1.0))[away].all()


def test_profile_speed_is_that_of_the_involute(flank: str) -> None:
    """v_j.e_j is the angular speed of the member times its transverse radius of curvature: specific
    sliding is infinite only at the base circle. e_j.q_j is k_j.t_j divided by the cosine of the base helix
    angle."""
    path, found = along(table1(), flank, 21)
    for j, (member, radius) in enumerate(zip(table1().members, (path.pinion_r, path.gear_r), strict=True)):
        curvature = np.sqrt(radius**2 - base_cylinder(member, flank).radius ** 2)
        rate = 1.0 if j == 0 else found.gear_rate
        sign = -1.0 if (flank == "right") == (j == 0) else 1.0
        l, u = ((path.l1, path.u1), (path.l2, path.u2))[j]
        trace = flank_patch(member, flank, l, u).tangent_u
        steep = (
            trace[:, 2] / np.linalg.norm(trace, axis=-1) / np.cos(base_cylinder(member, flank).helix_angle)
        )
        moved = sign * rate * curvature * steep
        np.testing.assert_allclose(found.profile[:, j], found.specific[:, j] * moved, atol=1e-10)
        sense = np.sign(found.specific[-1, j] - found.specific[0, j])
        assert (sense * np.diff(found.specific[:, j]) > 0.0).all()


@pytest.mark.parametrize(("helix_deg", "order", "error"), [(0.0, 2, 1.2e-4), (20.0, 1, 9e-3)])
def test_parallel_axes_are_the_limit(helix_deg: float, order: int, error: float) -> None:
    """Specific sliding tends to 1 - (rho_2/rho_1)(N1/N2), and to the corresponding limit for the gear. The
    difference is of second order in the shaft angle for spur gears, and of first order for helical gears."""
    missing = []
    for angle in (2.0, 1.0, 0.5):
        design = crossed_helical((25, 40), (radians(helix_deg + angle), -radians(helix_deg)))
        path, found = along(design, points=11)
        pinion, gear = (
            np.sqrt(radius**2 - base_cylinder(member, "right").radius ** 2)
            for radius, member in zip((path.pinion_r, path.gear_r), design.members, strict=True)
        )
        classical = np.stack((1.0 - gear / pinion * 25.0 / 40.0, 1.0 - pinion / gear * 40.0 / 25.0), axis=-1)
        missing.append(np.abs(found.specific - classical).max())
        assert found.specific[0, 0] < -1.0 < 0.4 < found.specific[0, 1]
    assert missing[2] < error
    assert missing[0] / missing[1] == pytest.approx(2.0**order, rel=0.02)
    assert missing[1] / missing[2] == pytest.approx(2.0**order, rel=0.02)


@cases
def test_mirror_image_has_the_same_sliding(design: Design, flank: str) -> None:
    _, found = along(design, flank)
    _, other = along(mirrored(design), "left" if flank == "right" else "right")
    for name in INVARIANT:
        np.testing.assert_allclose(getattr(other, name), getattr(found, name), rtol=1e-9, atol=1e-9)
    for name in ("profile", "lengthwise"):
        np.testing.assert_allclose(getattr(other, name), -getattr(found, name), rtol=0, atol=1e-8)
    np.testing.assert_allclose(other.sliding, -found.sliding * (1.0, -1.0, 1.0), rtol=0, atol=1e-8)


@cases
def test_members_exchanged(design: Design, flank: str) -> None:
    path, found = along(design, flank)
    swapped = exchanged(design)
    other = path_sliding(path_of_contact(swapped, flank, l1=path.l2))
    rate = -found.gear_rate
    np.testing.assert_allclose(other.gear_rate, 1.0 / found.gear_rate, rtol=1e-10)
    np.testing.assert_allclose(other.speed * rate, found.speed, rtol=1e-9)
    np.testing.assert_allclose(other.specific[:, ::-1], found.specific, rtol=0, atol=1e-8)
    np.testing.assert_allclose(other.specific_total[:, ::-1], found.specific_total, rtol=1e-7)


def test_pitch_point_beyond_the_ends_of_a_path_has_no_roll() -> None:
    """If both members are moved along their faces so that the path ends before the pitch point, at its first
    or last end, the roll of the pitch point is NaN."""
    for axial, beyond in ((25.0, True), (-27.0, True), (15.0, False), (-15.0, False)):
        moved = table1(errors=Errors(pinion_axial=axial, gear_axial=axial))
        report = sliding_report("", moved, "right", 3)
        assert report.path.l1.size == 3
        assert np.isnan(report.pitch_roll) == beyond


def test_columns_are_those_of_their_member() -> None:
    path, found = along(CASES["modified"], "left")
    columns = columns_of(path, found)
    for j, member in enumerate(("pinion", "gear")):
        speed = np.sqrt((found.rolling[:, j] ** 2).sum(axis=-1))
        np.testing.assert_allclose(columns[f"{member}_rolling_speed"], speed, rtol=1e-12)
        for name in ("profile", "lengthwise", "specific", "specific_total"):
            np.testing.assert_array_equal(columns[f"{member}_{name}"], getattr(found, name)[:, j])


def test_least_sliding() -> None:
    _, dense = along(table1(MODIFIED), points=40001)
    best = dense.speed.argmin()
    for points, error in ((41, 2e-4), (401, 2e-6)):
        roll, speed = least_sliding(along(table1(MODIFIED), points=points)[1])
        assert roll == pytest.approx(dense.pinion_roll[best], abs=max(error, 1e-5))
        assert speed == pytest.approx(dense.speed[best], abs=error)
    exact = [least_sliding(along(table1(), points=points)[1]) for points in (3, 1001)]
    np.testing.assert_allclose(exact[0], exact[1], rtol=1e-10)
    # At an end, with two positions or one, and with gaps.
    ends = (
        *(np.arange(5.0) ** 2, (np.arange(5.0) - 9.0) ** 2),
        *(np.sqrt(np.arange(4.0)), np.sqrt(np.arange(4.0))[::-1]),
        *(np.array([7.0, 3.0]), np.array([7.0])),
    )
    found = [
        [float(x) for x in least_along(np.arange(1.0, 1.0 + values.size, dtype=float), values)]
        for values in ends
    ]
    assert found == [[1.0, 0.0], [5.0, 25.0], [1.0, 0.0], [4.0, 0.0], [2.0, 3.0], [1.0, 7.0]]
    assert np.isnan(least_along(np.arange(5.0), np.full(5, np.nan))).all()
