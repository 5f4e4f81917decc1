"""Derivatives with respect to the assembly errors: 60 digits, differences, and symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Status, path_of_contact, path_sensitivity
from beveloid_geom.arrays import FloatArray, gear_sense
from beveloid_geom.design.member import unchecked
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.pair.misalignment import ERROR_NAMES
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Limit
from beveloid_geom.support.chebyshev import basis_of, greatest
from beveloid_geom.validation.five_equations_mp import MP, solve_mp

from ..contact.test_path_search import LOST
from ..oracle.sixty_digits import numbers_of
from ..oracle.table1 import table1
from ..symmetry import mirrored

VALUES = ("l", "z", "r", "pinion_roll", "contact_ratio", "peak_to_peak")
STEP = MP.mpf(10) ** -18
"""Step of central differences at 60 digits; 20 digits remain."""
MODIFIED = (0.001, -0.001)
CASES = [
    ("right", (0.0, 0.0), Errors()),
    ("left", MODIFIED, Errors(0.1, 1e-4, 0.2, -0.1)),
    ("right", MODIFIED, Errors(offset=-0.5)),  # leaves at the pinion's toe
    ("left", (0.0002, -0.0001), Errors()),
]


class Exact:
    """Contacts and their derivatives with respect to l1 and the four errors, at 60 digits."""

    def __init__(self, design: Design, flank: str) -> None:
        self.design, self.flank = design, flank
        self.mounting = tuple(MP.mpf(float(value)) for value in mounting_of(design).distance)

    def at(self, l1: Any, guess: tuple[float, ...], errors: tuple[Any, ...]) -> Any:
        """Return (l1, l2, z1, z2, r1, r2, roll, phase) of the contact at l1 under further errors."""
        given = [MP.mpf(getattr(self.design.errors, name)) for name in ERROR_NAMES]
        total = dict(zip(ERROR_NAMES, (a + b for a, b in zip(given, errors, strict=True)), strict=True))
        design = self.design.with_errors(unchecked(Errors(), **total))
        found = solve_mp(design, self.flank, guess, ("l1", l1), self.mounting)
        x, y, z = found.point
        offset = MP.mpf(design.pair.offset) + total["offset"]
        angle = MP.mpf(design.pair.shaft_angle) + total["shaft_angle"]
        z2 = y * MP.sin(angle) + z * MP.cos(angle)
        across = -y * MP.cos(angle) + z * MP.sin(angle)
        return np.array(
            (
                found.l1,
                found.l2,
                z - self.mounting[0] - total["pinion_axial"],
                z2 - self.mounting[1] - total["gear_axial"],
                MP.sqrt(x * x + y * y),
                MP.sqrt((x - offset) ** 2 + across**2),
                found.phi1,
                found.phi2 + MP.mpf(design.pinion.teeth) / design.gear.teeth * found.phi1,
            )
        )

    def rates(self, l1: float, guess: tuple[float, ...]) -> tuple[Any, Any]:
        """Return the contact at l1, and its derivatives (5, 8) with respect to l1 and the errors."""
        zero, here = (MP.zero,) * 4, MP.mpf(l1)
        steps = [(here + STEP, zero, here - STEP, zero)]
        for k in range(4):
            plus = tuple(STEP * (j == k) for j in range(4))
            steps.append((here, plus, here, tuple(-value for value in plus)))
        pairs = [(self.at(a, guess, e), self.at(b, guess, f)) for a, e, b, f in steps]
        return self.at(here, guess, zero), np.array([(a - b) / (2 * STEP) for a, b in pairs])


def margin_rates(design: Design, limit: int, rates: Any) -> Any:
    """Return the derivatives (5) of the distance from a limit, with respect to l1 and the errors."""
    member = design.members[limit % 2]
    l, z, r = (rates[:, 2 * row + limit % 2] for row in (0, 1, 2))
    taper = MP.tan(MP.mpf(member.cone_angle))
    return {"root": l, "tip": taper * z - r, "toe": z, "heel": -z}[Limit(limit).limit]


@cache
def exact_ends(flank: str, parabola: tuple[float, float], errors: Errors) -> tuple[Any, ...]:
    """Return the sensitivity, and exact derivatives at both ends: (2, 4, 8) by the errors, with the end
    on its limit, and (2, 5, 8) by l1 and the errors, along the path and at fixed l1."""
    design = table1(parabola, errors)
    path = path_of_contact(design, flank, 2)
    exact, found = Exact(design, flank), path_sensitivity(design, flank)
    held, curve = [], []
    for k, limit in enumerate(path.ends.limit):
        _, rates = exact.rates(path.l1[k], numbers_of(path, k))
        margin = margin_rates(design, int(limit), rates)
        held.append(rates[1:] - rates[0] * (margin[1:] / margin[0])[:, None])
        curve.append(rates)
    return found, np.array(held), np.array(curve)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_ends_and_contact_ratio_against_60_digits(case: tuple[str, tuple[float, float], Errors]) -> None:
    found, held, _ = exact_ends(*case)
    exact = np.asarray(held, dtype=float)
    for name, column in (("l_by", 0), ("z_by", 2), ("r_by", 4)):
        ours = getattr(found, name)[::2]
        expected = np.moveaxis(exact[..., column : column + 2], 1, -1)
        np.testing.assert_allclose(ours, expected, rtol=1e-9, atol=1e-9, err_msg=name)
    np.testing.assert_allclose(found.pinion_roll_by[::2], exact[..., 6], rtol=1e-9, atol=1e-12)
    ratio = 29 / (2 * np.pi) * (exact[1, :, 6] - exact[0, :, 6]) * (1 if case[0] == "right" else -1)
    np.testing.assert_allclose(found.contact_ratio_by, ratio, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_shift_along_the_face_against_60_digits(case: tuple[str, tuple[float, float], Errors]) -> None:
    """The shift is the change of z at constant l of the member."""
    found, _, curve = exact_ends(*case)
    for member in (0, 1):
        l, z = curve[..., member], curve[..., 2 + member]
        shift = z[:, 1:] - l[:, 1:] * (z[:, :1] / l[:, :1])
        np.testing.assert_allclose(
            found.face_shift_by[::2, member], np.asarray(shift, dtype=float), rtol=1e-9, atol=1e-9
        )


def test_transmission_error_between_ends_against_60_digits() -> None:
    case = CASES[2]
    design = table1(case[1], case[2])
    error = path_of_contact(design, case[0], 401).transmission_error
    assert {int(error.argmin()), int(error.argmax())} == {0, 400}  # monotone: the ends determine it
    found, held, _ = exact_ends(*case)
    exact = gear_sense(case[0]) * np.asarray(held[1, :, 7] - held[0, :, 7], dtype=float)
    exact *= np.sign(error[-1] - error[0])
    np.testing.assert_allclose(found.peak_to_peak_by, exact, rtol=1e-8, atol=1e-13)


def test_transmission_error_up_to_a_smooth_extreme_against_60_digits() -> None:
    """The minimum is near the middle, where the derivative at a fixed l1 equals that of the extremum."""
    case = CASES[3]
    design = table1(case[1])
    path = path_of_contact(design, case[0], 401)
    error = path.transmission_error
    lowest, greatest = int(error.argmin()), int(error.argmax())
    assert 0 < lowest < 400
    assert greatest == 0
    exact = Exact(design, case[0])
    guess, none = numbers_of(path, lowest), (MP.zero,) * 4

    def slope(l1: Any) -> Any:
        return (exact.at(l1 + STEP, guess, none)[7] - exact.at(l1 - STEP, guess, none)[7]) / (2 * STEP)

    before, l1 = MP.mpf(path.l1[lowest - 1]), MP.mpf(path.l1[lowest])
    for _ in range(4):
        a, b = slope(before), slope(l1)
        before, l1 = l1, l1 - b * (l1 - before) / (b - a)
    _, inside = exact.rates(l1, guess)
    found, held, _ = exact_ends(*case)
    expected = np.asarray(held[0, :, 7] - inside[1:, 7], dtype=float)
    np.testing.assert_allclose(found.peak_to_peak_by, expected, rtol=1e-8, atol=1e-13)
    assert found.peak_to_peak == pytest.approx(float(np.ptp(error)), abs=1e-9)


def slopes(
    design: Design, flank: str, name: str, step: float, fields: Sequence[str]
) -> dict[str, FloatArray]:
    """Return the derivatives with respect to an error, by differences of the fourth order."""
    moved = getattr(design.errors, name) + step * np.array((-2.0, -1.0, 1.0, 2.0))
    near = path_sensitivity(design.with_errors(replace(design.errors, **{name: moved})), flank)
    rows = {field: getattr(near, field) for field in fields}
    return {field: (8.0 * (c - b) - (d - a)) / (12.0 * step) for field, (a, b, c, d) in rows.items()}


@pytest.mark.parametrize(
    "parabola", [(0.0, 0.0), MODIFIED, (0.0002, 0.0002), (-0.0002, -0.0002), (-0.001, 0.0005)]
)
def test_all_derivatives_against_differences(flank: str, parabola: tuple[float, float]) -> None:
    """All positions and the four errors, by differences of the fourth order."""
    design = table1(parabola, Errors(0.05, 2e-5, -0.3, 0.2))
    found = path_sensitivity(design, flank)
    assert found.status == Status.SOLVED
    for k, (name, step) in enumerate(zip(ERROR_NAMES, (4e-3, 2e-6, 0.04, 0.04), strict=True)):
        for field, slope in slopes(design, flank, name, step, VALUES).items():
            scale = 1e-8 if field == "peak_to_peak" else 1e-6
            np.testing.assert_allclose(
                getattr(found, field + "_by")[..., k],
                slope,
                rtol=2e-5,
                atol=scale * (1e3 if name == "shaft_angle" else 1.0),
                err_msg=f"{field} by {name}",
            )


def test_the_shift_perpendicular_to_the_path_is_a_distance_on_the_flank(flank: str) -> None:
    """The shift perpendicular to the path is the smallest distance in space from the middle to the shifted
    path, on both members."""
    design, step = table1(MODIFIED), 1e-3
    found, middle = path_sensitivity(design, flank), path_of_contact(design, flank, 3)
    shifted = design.with_errors(Errors(offset=step))
    near = path_of_contact(shifted, flank, l1=np.linspace(-0.2, 0.2, 4001) + middle.l1[1])
    for j, member in enumerate(design.members):
        before = flank_point(member, flank, (middle.l1, middle.l2)[j][1], (middle.u1, middle.u2)[j][1])
        after = flank_point(member, flank, (near.l1, near.l2)[j], (near.u1, near.u2)[j])
        distance = np.linalg.norm(after - before, axis=-1)
        assert 0 < distance.argmin() < 4000
        expected = abs(found.square_shift_by[1, j, 0]) * step
        assert distance.min() == pytest.approx(expected, rel=2e-2)
        along = abs(found.face_shift_by[1, j, 0])
        assert expected < along * step
        assert np.sign(found.square_shift_by[1, j]) == pytest.approx(np.sign(found.face_shift_by[1, j]))


def test_unmodified_flanks_have_their_lines_of_action(flank: str) -> None:
    """There is no transmission error under any error. An axial error moves the member relative to a path
    that is fixed in space, and does not move the path on the other member."""
    found = path_sensitivity(table1(), flank)
    assert found.peak_to_peak == 0.0
    assert (found.peak_to_peak_by == 0.0).all()
    own = np.stack((found.face_shift_by[:, 0, 3], found.face_shift_by[:, 1, 2]))
    assert np.abs(own).max() < 1e-12
    assert np.abs(found.square_shift_by[:, 0, 3]).max() < 1e-12
    assert (found.face_shift_by[:, 0, 2] < 0.0).all()


def test_mirror_image(flank: str) -> None:
    design, other = table1(MODIFIED, Errors(0.1, 1e-4, 0.3, 0.1)), {"right": "left", "left": "right"}[flank]
    ours, mirror = path_sensitivity(design, flank), path_sensitivity(mirrored(design), other)
    for name in ("l_by", "z_by", "r_by", "face_shift_by", "square_shift_by", "contact_ratio_by"):
        np.testing.assert_allclose(getattr(mirror, name), getattr(ours, name), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(mirror.pinion_roll_by, -ours.pinion_roll_by, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(mirror.peak_to_peak_by, ours.peak_to_peak_by, rtol=1e-8, atol=1e-13)


def test_a_path_along_which_the_roll_turns_back_has_no_middle() -> None:
    design = table1((0.0005, 0.0005))
    found = path_sensitivity(design, "right")
    roll = path_of_contact(design, "right", 401).pinion_roll
    assert np.ptp(np.sign(np.diff(roll))) == 2.0
    assert np.isnan(found.z[1]).all()
    assert np.isfinite(found.z[::2]).all()
    assert found.contact_ratio == pytest.approx(29 / (2 * np.pi) * np.ptp(roll), rel=1e-4)
    for k, (name, step) in enumerate(zip(ERROR_NAMES, (1e-4, 5e-8, 1e-3, 1e-3), strict=True)):
        slope = slopes(design, "right", name, step, ["contact_ratio"])["contact_ratio"]
        assert found.contact_ratio_by[k] == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("name", ["4.15/2.03 deg", "a -0.0022/-0.0017"])
def test_traced_paths(name: str) -> None:
    """Derivatives equal differences for a path across n_x = 0, and for a path along which l1 turns back."""
    design = LOST[name]
    found = path_sensitivity(design, "right")
    assert found.status == Status.SOLVED
    for k, (error, step) in enumerate(zip(ERROR_NAMES, (5e-5, 2e-8, 5e-4, 5e-4), strict=True)):
        fields = ("z", "r", "contact_ratio", "peak_to_peak")
        for field, expected in slopes(design, "right", error, step, fields).items():
            ours = getattr(found, field + "_by")[..., k]
            scale = max(np.abs(ours).max(), 1e-5)
            assert np.abs(ours - expected).max() <= 1e-4 * scale, f"{field} by {error}"


def test_lost_paths_of_unmodified_flanks_have_no_transmission_error() -> None:
    found = path_sensitivity(table1(errors=Errors(offset=np.array([0.0, 40.0]))), "right")
    assert found.status.tolist() == [Status.SOLVED, Status.OFF_FLANK]
    assert found.peak_to_peak[0] == 0.0
    assert np.isnan(found.peak_to_peak[1])
    assert np.isnan(found.peak_to_peak_by[1]).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_of_several_extrema_is_used(sign: float) -> None:
    basis = basis_of(60)
    series = sign * basis.coefficients(wave(basis.nodes))[None]
    found = float(greatest(series, np.array([[-0.95]]), np.array([[0.9]]))[0, 0])
    dense = np.linspace(-0.95, 0.9, 20_001)
    assert found == pytest.approx(dense[(sign * wave(dense)).argmax()], abs=1e-4)
    assert abs(wave(found + 1e-6) - wave(found - 1e-6)) < 1e-11


def wave(x: Any) -> Any:
    return np.sin(11.0 * x) + 0.2 * x
