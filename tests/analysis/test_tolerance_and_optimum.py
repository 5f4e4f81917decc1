"""Tolerance studies, derivatives and the optimiser where a slip would not show in ordinary use."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from beveloid_geom.analysis.optimise import Aim, optimise_parabola, paths_of
from beveloid_geom.analysis.sensitivity import CASES_PER_BLOCK, _extreme, path_sensitivity
from beveloid_geom.analysis.tolerance import UNIT, Tolerances, drawn_errors, swing_of, tolerance_study
from beveloid_geom.contact.path import path_of_contact
from beveloid_geom.design.model import Errors
from beveloid_geom.status import Status
from beveloid_geom.support.chebyshev import basis_of

from ..oracle.table1 import table1

GIVEN = Tolerances(0.05, math.radians(0.01), 0.1, 0.1)
MODIFIED = (0.001, -0.001)


def test_no_task_repeats_the_errors_of_another() -> None:
    """Several units a task, several tasks."""
    cases = 3 * UNIT + 5
    found = tolerance_study(table1(), GIVEN, cases=cases, seed=2, units_per_task=2).mountings.errors
    each = [drawn_errors(GIVEN, 2, unit, min(UNIT, cases - unit * UNIT)) for unit in range(4)]
    np.testing.assert_array_equal(found, np.concatenate(each))
    assert np.unique(found[:, 0]).size == cases


def test_an_error_without_tolerance_is_plain_zero() -> None:
    drawn = drawn_errors(replace(GIVEN, offset=0.0), 0, 0, 50)
    assert not np.signbit(drawn[:, 0]).any()
    assert drawn[:, 1:].all()


def test_quantiles_leave_out_the_contact_ratio_0_of_lost_paths() -> None:
    study = tolerance_study(table1(), Tolerances(offset=2.0, distribution="uniform"), cases=200)
    solved = study.mountings.solved
    assert 0 < np.count_nonzero(solved) < 200
    least = study.quantiles((0.0,))["contact_ratio"][0]
    assert least == study.mountings.contact_ratio[solved].min() > 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("place", [0.03, 0.47, 0.99])
def test_swing_of_a_parabola_with_its_extreme_between_values(sign: float, place: float) -> None:
    x = np.linspace(0.0, 1.0, 17)
    values = sign * (x - place) ** 2
    expected = max(place, 1.0 - place) ** 2
    assert swing_of(values) == pytest.approx(expected, rel=1e-14)
    np.testing.assert_allclose(swing_of(np.stack([values, 3.0 * values])), [expected, 3.0 * expected])


def test_swing_of_a_monotone_curve_is_between_its_ends() -> None:
    for curve in (np.exp, lambda x: -np.exp(x), lambda x: np.exp(-x), np.sqrt):
        values = curve(np.linspace(0.0, 1.0, 17))
        assert swing_of(values) == pytest.approx(np.ptp(values), rel=1e-14)


@pytest.mark.parametrize("units", [0, -1])
def test_units_of_no_size_are_refused(units: int) -> None:
    with pytest.raises(ValueError, match=f"must be at least 1, got 10 and {units}"):
        tolerance_study(table1(), GIVEN, cases=10, units_per_task=units)


def test_endless_sigmas_are_refused() -> None:
    with pytest.raises(ValueError, match="sigmas must be positive and finite, got inf"):
        tolerance_study(table1(), replace(GIVEN, sigmas=math.inf), cases=1)


def test_derivatives_of_more_cases_than_a_block_holds() -> None:
    offset = np.linspace(-0.4, 0.4, CASES_PER_BLOCK + 3)
    batch = path_sensitivity(table1(MODIFIED, Errors(offset)), "right")
    for k in (0, CASES_PER_BLOCK - 1, CASES_PER_BLOCK, CASES_PER_BLOCK + 2):
        single = path_sensitivity(table1(MODIFIED, Errors(float(offset[k]))), "right")
        for name in ("z_by", "contact_ratio", "peak_to_peak_by"):
            ours, expected = getattr(batch, name)[k], getattr(single, name)
            np.testing.assert_allclose(ours, expected, rtol=1e-8, atol=1e-10 * np.abs(expected).max())
        assert (batch.limit[k] == single.limit).all()


@pytest.mark.parametrize("parabola", [(0.0005, 0.0), (0.0, -0.0005)])
def test_one_modified_member_is_enough_for_a_transmission_error(parabola: tuple[float, float]) -> None:
    found = path_sensitivity(table1(parabola), "left")
    error = path_of_contact(table1(parabola), "left", 401).transmission_error
    assert found.peak_to_peak == pytest.approx(np.ptp(error), rel=1e-4)
    assert found.peak_to_peak_by.all()


def test_lost_paths_of_unmodified_flanks_have_no_transmission_error() -> None:
    found = path_sensitivity(table1(errors=Errors(offset=np.array([0.0, 40.0]))), "right")
    assert found.status.tolist() == [Status.SOLVED, Status.OFF_FLANK]
    assert found.peak_to_peak[0] == 0.0
    assert np.isnan(found.peak_to_peak[1])
    assert np.isnan(found.peak_to_peak_by[1]).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("ends", [(-0.95, 0.9), (0.9, -0.95)])
def test_the_greatest_of_several_extremes_counts(sign: float, ends: tuple[float, float]) -> None:
    basis = basis_of(60)
    track: Any = SimpleNamespace(coefficients=basis.coefficients(wave(basis.nodes))[None, None])
    found = float(_extreme(track, np.array([ends]), 0, sign)[0, 0])
    dense = np.linspace(-0.95, 0.9, 20_001)
    assert found == pytest.approx(dense[(sign * wave(dense)).argmax()], abs=1e-4)
    assert abs(wave(found + 1e-6) - wave(found - 1e-6)) < 1e-11


def wave(x: Any) -> Any:
    return np.sin(11.0 * x) + 0.2 * x


def test_coefficients_hollow_against_each_other_are_left_out() -> None:
    """With a positive sum the path would shift less, and the way there goes downhill."""
    aim = Aim(
        Errors(offset=0.05),
        contact_ratio=1.0,
        off_centre=5.0,
        pinion_parabola=(-0.00101, -0.0009),
        gear_parabola=(0.00099, 0.0011),
    )
    found = optimise_parabola(table1(), aim)
    assert found.pinion_parabola + found.gear_parabola <= 1e-9
    sums = np.array([0.0, 0.00005, 0.0001])
    hollow = paths_of(table1(), "right", aim, -0.001 + sums, np.full(3, 0.001))
    assert (hollow.margins(aim) > 0.0).all()
    assert (np.diff(hollow.shift) < 0.0).all()
    assert hollow.shift[-1] < 0.65 * found.found.shift


def test_an_aim_that_one_corner_alone_meets() -> None:
    """All that is near misses it by less than a hundredth, and shifts less."""
    bounds = (-0.0005, -0.00049)
    aim = Aim(Errors(offset=0.05), 1.0, 5.0, math.inf, bounds, bounds)
    corner = paths_of(table1(), "left", aim, np.array(bounds[1]), np.array(bounds[1]))
    swing = 1.0005 * float(corner.peak_to_peak)
    found = optimise_parabola(table1(), replace(aim, peak_to_peak=swing), "left")
    assert found.found.peak_to_peak <= swing * (1.0 + 1e-5)
    assert found.found.shift <= corner.shift


def test_what_the_optimum_is_compared_with_is_the_design_given() -> None:
    aim = Aim(Errors(offset=0.05), 1.7, 5.0, math.inf, (-0.0005, 0.0), (-0.0005, 0.0))
    found = optimise_parabola(table1((-0.0002, -0.0001)), aim, "left")
    given = paths_of(table1(), "left", aim, np.array(-0.0002), np.array(-0.0001))
    for name in ("shift", "contact_ratio", "centre", "peak_to_peak"):
        assert getattr(found.given, name) == pytest.approx(float(getattr(given, name)), rel=1e-9)
    assert found.design.pair == table1().pair
    assert found.found.shift < found.given.shift


def test_the_greatest_ratio_tried_is_said() -> None:
    bounds = (-0.0002, 0.0)
    aim = Aim(Errors(offset=0.05), 1.9, 5.0, math.inf, bounds, bounds)
    greatest = paths_of(table1(), "left", aim, np.array(-0.0002), np.array(-0.0002)).contact_ratio
    with pytest.raises(ValueError, match=f"the greatest ratio tried is {greatest:.3f}: ask for less"):
        optimise_parabola(table1(), aim, "left")


def test_bounds_whose_only_sum_is_0_are_refused() -> None:
    aim = Aim(Errors(offset=0.05), pinion_parabola=(0.001, 0.002), gear_parabola=(-0.001, 0.0))
    with pytest.raises(ValueError, match="leave no sum of both coefficients below 0"):
        optimise_parabola(table1(), aim)


def test_the_best_of_several_valleys_is_found() -> None:
    """Within the default bounds there are two, and the best coefficients of the grid lie in the worse."""
    aim = Aim(Errors(offset=0.05))
    gear = np.linspace(-0.002, 0.002, 33)
    others = paths_of(table1(), "right", aim, np.full(33, -0.002), gear)
    least = others.shift[(others.margins(aim) >= 0.0).all(axis=0)].min()
    assert optimise_parabola(table1(), aim).found.shift < least < 0.1
