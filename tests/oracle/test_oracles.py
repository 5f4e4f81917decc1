"""The independent solutions compared with each other, with Table 1's checked numbers, and with general
properties."""

from __future__ import annotations

from functools import cache
from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors
from beveloid_geom.validation.five_equations_math import solve_math
from beveloid_geom.validation.five_equations_mp import (
    MP,
    ContactMp,
    pitch_radius_mp,
    solve_mp,
    zero_shift,
)
from beveloid_geom.validation.pitch_region import Guess, pitch_guess
from tests.stability.answers import changed, closed

from .pitch_point_mp import MountingMp, mounting_mp
from .table1 import table1

MISALIGNED = Errors(offset=-0.3, shaft_angle=radians(0.01), pinion_axial=0.4, gear_axial=-0.7)
CASES = [
    ((0.0, 0.0), Errors()),
    ((0.0, 0.0), MISALIGNED),
    ((0.001, -0.001), Errors()),
    ((0.001, -0.001), MISALIGNED),
    ((0.0002, 0.0002), Errors()),
    ((-0.0002, -0.0002), Errors(offset=0.5)),
    ((-0.002, 0.002), Errors()),
]


@cache
def table1_mounting() -> MountingMp:
    return mounting_mp(table1())


def table1_distances() -> tuple[float, float]:
    return float(table1_mounting().dw1), float(table1_mounting().dw2)


def six(contact: ContactMp) -> Guess:
    l1, u1, l2, u2, phi1, phi2 = (
        float(getattr(contact, name)) for name in ("l1", "u1", "l2", "u2", "phi1", "phi2")
    )
    return l1, u1, l2, u2, phi1, phi2


def along_the_path(design: Design, flank: str, count: int) -> tuple[np.ndarray, Guess]:
    """Return pinion rolls from l1 = -4 to 4, and the contact at the first as a starting value."""
    mounting, guess = table1_distances(), pitch_guess(design, flank)
    first, last = (solve_mp(design, flank, guess, ("l1", l1), mounting) for l1 in (-4.0, 4.0))
    return np.linspace(float(first.phi1), float(last.phi1), count), six(first)


@pytest.mark.parametrize(("parabola", "errors"), CASES)
def test_scalar_math_agrees_with_60_digits(flank: str, parabola: tuple[float, float], errors: Errors) -> None:
    design, mounting = table1(parabola, errors), table1_distances()
    rolls, guess = along_the_path(design, flank, 9)
    contacts = solve_math(design, flank, rolls, guess, mounting)
    for i in range(0, rolls.size, 2):
        start = [getattr(contacts, name)[i] for name in ("l1", "u1", "l2", "u2", "phi1", "phi2")]
        exact = solve_mp(design, flank, start, ("phi1", float(rolls[i])), mounting)
        assert exact.residual < MP.mpf(10) ** -40
        assert max(abs(float(x - y)) for x, y in zip(exact.point, contacts.point[i], strict=True)) < 1e-10
        assert max(abs(float(x - y)) for x, y in zip(exact.normal, contacts.normal[i], strict=True)) < 1e-13
        assert max(abs(x - y) for x, y in zip(six(exact)[:4], start[:4], strict=True)) < 1e-10
        assert abs(float(exact.phi2) - start[5]) < 1e-12


def test_table1_mounting() -> None:
    mounting, (pinion, gear) = table1_mounting(), table1().members
    assert float(mounting.dw1) == pytest.approx(211.594669, abs=1e-6)
    assert float(mounting.dw2) == pytest.approx(210.211869, abs=1e-6)
    assert float(mounting.rw1) == pytest.approx(96.890503, abs=1e-6)
    assert float(mounting.rw2) == pytest.approx(138.747433, abs=1e-6)
    assert float(mounting.gap) == pytest.approx(2.21, abs=5e-3)
    assert float(zero_shift(pinion).height) == pytest.approx(19.462759, abs=1e-6)
    assert float(zero_shift(gear).height) == pytest.approx(93.715481, abs=1e-6)
    assert float(pitch_radius_mp(pinion)) == pytest.approx(95.993879, abs=1e-6)
    assert float(pitch_radius_mp(gear)) == pytest.approx(137.330285, abs=1e-6)
    # The lines do not depend on where they are cut, nor on errors and parabolas.
    assert mounting_mp(table1((0.001, -0.001), MISALIGNED)) == mounting


@pytest.mark.parametrize(
    ("helix_deg", "cone_deg", "signs"),
    [
        ((25.0, -10.57), (3.0, 0.8), (1, 1)),
        ((25.0, -10.57), (0.0, 0.0), (1, 1)),
        ((25.0, -10.57), (6.0, 6.0), (-1, 1)),
        ((-25.0, 10.57), (6.0, 4.0), (1, -1)),
        ((20.0, 15.0), (3.0, 0.8), (1, 1)),
        ((10.0, 8.0), (7.0, 8.0), (-1, 1)),
    ],
)
def test_lines_of_a_closing_design_meet(
    helix_deg: tuple[float, float], cone_deg: tuple[float, float], signs: tuple[int, int]
) -> None:
    angles = zip(table1().members, helix_deg, cone_deg, strict=True)
    design = closed(*(changed(m, helix_angle=radians(b), cone_angle=radians(c)) for m, b, c in angles))
    mounting = mounting_mp(design)
    assert mounting.gap < 1e-9  # the inputs are rounded to doubles
    distances = float(mounting.dw1), float(mounting.dw2)
    for flank, sign in zip(("right", "left"), signs, strict=True):
        exact = solve_mp(design, flank, pitch_guess(design, flank), ("l1", 0.5), distances)
        assert exact.normal[0] * sign > 0
        scalar = solve_math(design, flank, [float(exact.phi1)], six(exact), distances)
        assert max(abs(x - y) for x, y in zip(exact.point, scalar.point[0].tolist(), strict=True)) < 1e-10


def test_no_common_normal_is_an_error_in_each() -> None:
    # v1^2 + v2^2 + 2 v1 v2 cos(d) > sin(d)^2 on the right flank.
    design, mounting = table1(errors=Errors(shaft_angle=radians(-1.0))), table1_distances()
    guess = pitch_guess(design, "right")
    with pytest.raises(ArithmeticError, match="no contact found at l1"):
        solve_mp(design, "right", guess, ("l1", 0.0), mounting)
    with pytest.raises(ArithmeticError, match="no contact found at phi1"):
        solve_math(design, "right", [guess[4]], guess, mounting)
