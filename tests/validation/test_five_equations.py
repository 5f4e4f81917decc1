"""The five equations traced by arc length: turning points, n_x = 0, segments, distant starts."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Pair,
    Status,
    path_of_contact,
)
from beveloid_geom.contact.path import path_ends
from beveloid_geom.validation import five_equations
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.contact.test_path import NUMBERS, five_equation_residual
from tests.contact.test_path_search import FROM_AFAR
from tests.oracle.sixty_digits import off_by
from tests.oracle.table1 import table1
from tests.stability.five_residuals import margins
from tests.stability.named_designs import CROSSING, OTHER, SPLIT, Named
from tests.stability.test_line_contact import COEFFICIENTS
from tests.symmetry import exchanged

L1_TURNS = table1((-0.002, -0.002), Errors(offset=-6.0, shaft_angle=radians(-0.08)))


@pytest.mark.parametrize("a", COEFFICIENTS)
def test_approximate_line_contact_is_followed_where_the_roll_turns_back_too(a: float) -> None:
    design = table1((a, a))
    ours, other = path_of_contact_five_equations(design, points=7), path_of_contact(design, points=7)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(ours, name), getattr(other, name), atol=1e-10, err_msg=name)
    np.testing.assert_array_equal(ours.ends.limit, other.ends.limit)
    assert ours.ends.contact_ratio == pytest.approx(float(other.ends.contact_ratio), abs=1e-12)
    assert max(off_by(ours, k, "l1")[0] for k in (0, 3)) < 2e-11


def test_a_path_that_crosses_nx_0() -> None:
    design = CROSSING["4.11/1.98 deg"]
    path = path_of_contact_five_equations(design, points=9)
    assert (path.status == Status.SOLVED).all()
    assert path.normal[0, 0] < -0.002
    assert path.normal[-1, 0] > 0.013
    assert five_equation_residual(design, path) < 1e-12
    assert margins(design, path).min() > -1e-10
    assert path.ends.contact_ratio == pytest.approx(1.2536141506, abs=1e-9)
    assert max(off_by(path, k)[0] for k in (0, 1, 2)) < 1e-10


def test_an_l1_that_turns_back_has_two_contacts() -> None:
    path = path_of_contact_five_equations(L1_TURNS, points=101)
    turn = int(path.l1.argmin())
    assert 0 < turn < 100
    assert path.l1[turn] == pytest.approx(-4.2134, abs=1e-3)
    assert path.l1[0] > path.l1[turn] < path.l1[-1]
    steps = np.diff(path.pinion_roll)
    np.testing.assert_allclose(steps, steps.mean(), atol=1e-13)
    assert five_equation_residual(L1_TURNS, path) < 1e-12
    assert max(off_by(path, k)[0] for k in (0, turn)) < 1e-11


@pytest.mark.parametrize("case", [SPLIT[0], SPLIT[2]], ids=["first", "third"])
def test_of_two_pieces_the_longest_is_taken(case: Named) -> None:
    path = path_of_contact_five_equations(case.design, case.flank, points=3)
    assert path.ends.pieces == 2
    assert np.abs(np.sort(path.ends.l1) - np.sort(path_ends(case.design, case.flank).l1)).max() < 1e-9


def test_members_exchanged_give_the_same_path() -> None:
    path = path_of_contact_five_equations(L1_TURNS, points=3)
    other = path_of_contact_five_equations(exchanged(L1_TURNS), points=3)
    np.testing.assert_allclose(np.sort(other.ends.l1), np.sort(path.ends.l2), atol=1e-10)
    np.testing.assert_allclose(np.sort(other.ends.l2), np.sort(path.ends.l1), atol=1e-10)


@pytest.mark.parametrize(("parabola", "offset", "shaft_deg", "l1"), FROM_AFAR)
def test_starts_far_from_the_path(
    parabola: tuple[float, float], offset: float, shaft_deg: float, l1: float
) -> None:
    """The five equations find a path that contains the known contact at this l1, although they start far
    away, where the one equation has no path."""
    design = table1(parabola, Errors(offset=offset, shaft_angle=radians(shaft_deg)))
    path = path_of_contact_five_equations(design, points=5)
    assert path.l1.min() < l1 < path.l1.max()
    assert (path.status == Status.SOLVED).all()
    assert five_equation_residual(design, path) < 1e-12
    assert np.abs(margins(design, path)[path.ends.limit, [0, -1]]).max() < 1e-10


@pytest.mark.parametrize(("parabola", "face"), [((-0.003, 0.005), 4.3705), ((-0.01, 0.02), 21.41315)])
def test_a_path_that_leaves_and_comes_back_is_in_pieces(parabola: tuple[float, float], face: float) -> None:
    design = table1(parabola)
    design = replace(design, pinion=replace(design.pinion, face_width=face))
    path = path_of_contact_five_equations(design, "left", 3)
    other = path_of_contact(design, "left", 3)
    assert path.ends.pieces == other.ends.pieces == 2
    assert path.ends.contact_ratio == pytest.approx(float(other.ends.contact_ratio), abs=1e-9)


def test_nearly_parallel_axes_with_a_path_over_a_tiny_range_of_l1() -> None:
    """Shaft angle 0.24 deg: l1 changes by 0.0011 mm while the contact moves over the complete face."""
    design = OTHER["almost parallel, its path a thread of l1"].design
    path = path_of_contact_five_equations(design, "left", 3)
    assert (path.status == Status.SOLVED).all()
    assert np.ptp(path.l1) < 0.0012
    assert np.ptp(path.point[:, 2]) > 17.0
    assert five_equation_residual(design, path) < 1e-12


@pytest.mark.parametrize("design", [table1((0.001, -0.001), Errors(0.2, 1e-4, 0.3, 0.1)), L1_TURNS])
def test_the_start_does_not_rest_on_the_one_equation(design: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    known = path_of_contact_five_equations(design, points=3)

    def lost(design: Design, flank: str, points: int) -> ContactPath:
        ends = replace(known.ends, status=np.asarray(Status.NOT_CONVERGED, dtype=np.int8))
        return replace(known, ends=ends)

    monkeypatch.setattr(five_equations, "path_of_contact", lost)
    again = path_of_contact_five_equations(design, points=3)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(again, name), getattr(known, name), atol=2e-11, err_msg=name)
    with pytest.raises(ArithmeticError, match="find no contact on the flanks"):
        path_of_contact_five_equations(table1(errors=Errors(offset=3.0)))
    apart = replace(design, pair=Pair(229.0, radians(14.8)))
    with pytest.raises(ArithmeticError, match="find no contact to start from"):
        path_of_contact_five_equations(apart)


def test_points_are_checked() -> None:
    with pytest.raises(ValueError, match="points must be a whole number of at least 2, got 1"):
        path_of_contact_five_equations(table1(), points=1)
    with pytest.raises(ValueError, match="single designs"):
        path_of_contact_five_equations(table1(errors=Errors(offset=np.zeros(3))))
