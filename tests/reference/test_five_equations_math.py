"""The five equations in scalar `math`: tolerance, cold and warm starts, and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.reference.five_equations_math import Contacts, first_start, solve_math
from beveloid_geom.reference.pitch_region import pitch_guess

from ..oracle.table1 import table1

ROLLS = np.linspace(0.05, 0.35, 4)


def solved(design: Design, **options: Any) -> Contacts:
    first, second = mounting_of(design).distance
    return solve_math(
        design, "right", ROLLS, pitch_guess(design, "right"), (float(first), float(second)), **options
    )


def test_cold_and_warm_starts_agree() -> None:
    design = table1((0.001, -0.001))
    warm, cold = solved(design), solved(design, cold=True)
    assert np.abs(warm.point - cold.point).max() < 1e-10
    assert np.abs(warm.phi2 - cold.phi2).max() < 1e-12
    assert warm.converged.all()
    # A cold roll knows nothing of the others: alone it is the same to the last bit.
    guess, (first, second) = pitch_guess(design, "right"), mounting_of(design).distance
    alone = solve_math(design, "right", ROLLS[2:3], guess, (float(first), float(second)))
    assert np.array_equal(alone.point[0], cold.point[2])
    assert not np.array_equal(alone.point[0], warm.point[2])


def test_a_loose_tolerance_is_cheaper_and_worse() -> None:
    exact = solved(table1(), cold=True)
    loose = solved(table1(), cold=True, xtol=1e-2, residual_limit=1.0)
    assert loose.evaluations < exact.evaluations
    assert 1e-7 < np.abs(loose.point - exact.point).max() < 1.0
    assert loose.converged.all()
    assert loose.residual.max() > 1e-10
    with pytest.raises(ArithmeticError, match="no contact found at phi1"):
        solved(table1(), cold=True, xtol=1e-2)


def test_what_does_not_converge_is_marked() -> None:
    design = table1()
    astray = (60.0, 400.0, -60.0, 400.0, 3.0, 1.0)
    first, second = mounting_of(design).distance
    with np.errstate(all="ignore"):
        found = solve_math(
            design, "right", ROLLS, astray, (float(first), float(second)), cold=True, residual_limit=np.inf
        )
    assert not found.converged.all()
    assert found.residual[~found.converged].min() > 1e-3
    assert found.residual[found.converged].max(initial=0.0) < 1e-9  # of the flanks' far extensions


def test_the_first_start_rolls_the_gear_on() -> None:
    start = first_start(table1(), (1.0, 2.0, 3.0, 4.0, 0.5, 0.7), 0.5 + 0.45)
    assert start == pytest.approx([1.0, 2.0, 3.0, 4.0, 0.7 - 0.29], abs=1e-15)
