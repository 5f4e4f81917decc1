"""Comparison of methods: every method at every setting, with its error."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from beveloid_geom import Errors, Modification, builtin_design
from beveloid_geom.validation.comparison import (
    METHODS,
    POSITION_COUNT,
    Measurement,
    Method,
    compare,
    path_positions,
)

from ..oracle.table1 import table1
from .stored_positions import cases

MODIFIED = (0.001, -0.001)
VALUES = {
    "mesh alone": (0.1, 0.01),
    "mesh, polished": (0.1,),
    "five equations": (1e-2, 1e-14),
    "one equation": (1, 101),
    "first contact": (1, 11),
}
SHORT = tuple(replace(method, values=VALUES[method.name]) for method in METHODS)


@cache
def measured(flank: str) -> tuple[Measurement, ...]:
    return compare(table1(MODIFIED), flank, SHORT, 2)


def test_errors_are_those_of_the_method(flank: str) -> None:
    found = {(one.method, one.value): one for one in measured(flank)}
    assert list(found) == [(method, value) for method, values in VALUES.items() for value in values]
    for one in found.values():
        assert one.status == "solved"
        assert 0.0 < one.seconds[0] <= one.seconds[1] <= one.seconds[2]
    inexact = {("mesh alone", 0.1), ("mesh alone", 0.01), ("five equations", 1e-2)}
    for key in found.keys() - inexact:
        assert found[key].error_mm < 1e-10, key
        assert found[key].gear_roll_error_rad < 1e-13, key
    assert 1e-7 < found["five equations", 1e-2].error_mm < 1e-1
    coarse, fine = (found["mesh alone", value] for value in VALUES["mesh alone"])
    assert 1.0 < fine.error_mm < coarse.error_mm
    assert 1e-6 < fine.gear_roll_error_rad < 0.2 * coarse.gear_roll_error_rad


KINDS = {
    "crowned": (Modification(helix_crowning_um=10.0), None),
    "all": (
        Modification(profile_crowning_um=4.0, twist_um=6.0, tip_relief_um=20.0, tip_relief_length_mm=6.0),
        Modification(helix_crowning_um=8.0, helix_slope_um=3.0, profile_slope_um=-2.0),
    ),
}


@pytest.mark.parametrize(
    ("kinds", "flank"), [("crowned", "right"), pytest.param("all", "left", marks=pytest.mark.slow)]
)
def test_pairs_with_modifications(kinds: str, flank: str) -> None:
    """Surfaces, meshes with polishing and first contacts agree with the five equations at 60 digits, into
    which the modification enters as a rotation. The five equations in `math` do not support it."""
    pinion, gear = KINDS[kinds]
    design = replace(
        table1(), pinion=table1().pinion.modified(pinion), gear=table1().gear.modified(gear or Modification())
    )
    methods = [replace(method, values=method.values[:1]) for method in METHODS]
    found = {one.method: one for one in compare(design, flank, tuple(methods), 1)}
    for name in ("mesh, polished", "one equation", "first contact"):
        assert found[name].error_mm < 1e-10, name
        assert found[name].gear_roll_error_rad < 1e-13, name
    assert found["mesh alone"].error_mm > 1.0
    assert "the five equations do not support modified flanks yet" in found["five equations"].status


def test_a_wrong_answer_has_its_error() -> None:
    """The comparison reports the error of a point displaced by a 3-4-5 triangle and of a rotated gear, and
    the number of missing positions."""

    def answer_of(point: np.ndarray, roll: np.ndarray) -> Measurement:
        method = Method(
            "a method", "a", (1.0,), lambda *_: (lambda: (point, roll), POSITION_COUNT), path_positions
        )
        return compare(table1(MODIFIED), "right", (method,), 1)[0]

    exact = path_positions(table1(MODIFIED), "right")
    point, roll = exact.point.copy(), exact.gear_roll.copy()
    point[3] += (3e-6, 0.0, -4e-6)
    roll[1] += 2e-6
    one = answer_of(point, roll)
    assert (one.error_mm, one.gear_roll_error_rad) == pytest.approx((5e-6, 2e-6), rel=1e-6)
    point[2, 0] = roll[4] = np.nan
    one = answer_of(point, roll)
    assert one.status == "2 of 5 positions not solved"
    assert np.isnan(one.error_mm)


def test_a_method_that_fails_is_included_with_the_reason() -> None:
    (one,) = compare(table1(MODIFIED), "right", (replace(METHODS[0], values=(1e-15,)),), 1)
    assert "tolerance" in one.status
    assert np.isnan([one.error_mm, *one.seconds]).all()


def test_stored_positions_are_those_at_60_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    solved = cases()
    monkeypatch.setitem(sys.modules, "mpmath", None)
    monkeypatch.delitem(sys.modules, "beveloid_geom.validation.five_equations_mp", raising=False)
    for case in solved:
        stored = path_positions(builtin_design().with_parabola(*case["parabola"]), case["flank"])
        ours = np.column_stack((stored.pinion_roll, stored.gear_roll, stored.l1, stored.point))
        np.testing.assert_allclose(ours, case["positions"], rtol=0.0, atol=1e-12)
    with pytest.raises(ImportError, match=r"60 digits need mpmath: pip install mpmath$"):
        path_positions(table1((0.0005, 0.0)), "right")


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        (Errors(offset=20.0), r"right flanks have no contact, .*\(OFF_FLANK\)"),
        (Errors(offset=np.zeros(3)), r"arrays of shape \(3,\)"),
    ],
)
def test_designs_without_positions_are_refused(errors: Errors, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        compare(table1(errors=errors))
