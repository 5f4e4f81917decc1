"""Mountings in operation: mesh cycles of a tolerance study, compared with single mesh cycles."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from beveloid_geom import Errors, Tolerances, mesh_cycle, tolerance_study
from beveloid_geom.analysis.cycle_statistics import CycleStatistics, cycle_statistics
from beveloid_geom.analysis.tolerance import CYCLE_COST_PATHS, USUAL, ToleranceStudy
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.report.tolerance import ToleranceReport, edge_contact_count, pattern_counts
from beveloid_geom.status import FirstStatus, Limit
from tests.oracle.table1 import table1

MODIFIED = table1((0.001, -0.001))
CASES, OPERATION, SEED = 90, 70, 3
PATTERNS = 24
"""Number of mountings whose contact patterns are computed."""


@pytest.fixture(scope="module")
def study() -> ToleranceStudy:
    return tolerance_study(MODIFIED, USUAL, "right", CASES, seed=SEED, operation=OPERATION)


def in_operation(study: ToleranceStudy) -> CycleStatistics:
    assert study.cycles is not None
    return study.cycles


@pytest.mark.parametrize("number", [0, 64, OPERATION - 1])
def test_each_mounting_equals_the_single_design(study: ToleranceStudy, number: int) -> None:
    errors = study.mountings.errors[number]
    alone = MODIFIED.with_errors(Errors(*errors))
    cycle, found = mesh_cycle(alone), in_operation(study)
    assert found.cycle_peak_to_peak[number] == pytest.approx(float(cycle.peak_to_peak), abs=1e-10)
    assert found.edge_share[number] == pytest.approx(float(cycle.edge_share), abs=1e-9)
    alone_ratio = float(operating_ratio(alone, "right", MARKING_SEPARATION_MM))
    assert found.film_ratio[number] == pytest.approx(alone_ratio, abs=1e-8)


def test_threads_do_not_change_the_result(study: ToleranceStudy) -> None:
    done: list[int] = []
    with ThreadPoolExecutor(2) as executor:
        again = tolerance_study(
            MODIFIED,
            USUAL,
            "right",
            CASES,
            seed=SEED,
            operation=OPERATION,
            executor=executor,
            progress=done.append,
        )
    for name, values in in_operation(study).quantities().items():
        np.testing.assert_array_equal(values, getattr(in_operation(again), name))
    assert sum(done) == CASES + CYCLE_COST_PATHS * OPERATION


def test_results_that_are_not_requested_are_missing() -> None:
    few = tolerance_study(MODIFIED, USUAL, "right", 3)
    assert few.cycles is None
    assert few.nominal_cycles is None
    report = ToleranceReport("Table 1", MODIFIED, few)
    assert "operation" not in report.data()
    assert "operation_status" not in report.rows()
    assert "in operation" not in report.summary()


def test_reports_contain_the_values_of_the_study(study: ToleranceStudy) -> None:
    report, found = ToleranceReport("Table 1", MODIFIED, study), in_operation(study)
    data, rows = report.data(), report.rows()
    assert data["operation"]["cases"] == OPERATION
    assert data["operation"]["edges_carry"] == edge_contact_count(found) == OPERATION
    assert data["operation"]["status"]["solved"] == OPERATION
    nominal = float(mesh_cycle(MODIFIED).edge_share)
    assert data["operation"]["nominal"]["edge_share"] == pytest.approx(nominal, abs=1e-9)
    np.testing.assert_array_equal(rows["edge_share"][:OPERATION], found.edge_share)
    assert np.isnan(rows["edge_share"][OPERATION:]).all()
    assert rows["operation_status"][OPERATION:] == [""] * (CASES - OPERATION)
    assert f"in 100 % of the first {OPERATION} mountings" in " ".join(report.summary().split())
    assert study.quantiles((0.5,))["film_ratio"] == pytest.approx(np.median(found.film_ratio))


def test_text_json_and_csv_agree_on_patterns() -> None:
    """Text, JSON and CSV name the same edges of the patterns. At eight times the usual tolerances, some
    patterns reach an end of the face."""
    offset, angle, pinion, gear = (8.0 * USUAL.values()).tolist()
    wide, count = Tolerances(offset, angle, pinion, gear), PATTERNS + 6
    study = tolerance_study(table1((-0.0005, -0.0005)), wide, "right", count + 5, seed=1, operation=count)
    report, found = ToleranceReport("Table 1", table1(), study), in_operation(study)
    column, data = report.rows()["pattern_ends_at"], report.data()["operation"]["pattern"]
    ends = found.pattern_ends[found.pattern_known]
    assert [bool(text) for text in column] == [*found.pattern_known.tolist(), *5 * [False]]
    listed = np.array([[name in text.split("+") for name in data["ends_at"]] for text in column if text])
    np.testing.assert_array_equal(listed[:, : len(Limit)], ends)
    assert list(data["ends_at"].values()) == ends.sum(axis=0).tolist()
    assert 0 < data["ends_at"]["pinion_toe"] < data["known"] == PATTERNS
    toe = data["ends_at"]["pinion_toe"]
    assert f"pinion toe {100.0 * toe / PATTERNS:.0f} %" in " ".join(report.summary().split())


def test_patterns_are_those_of_the_mountings_that_move_the_path_furthest(study: ToleranceStudy) -> None:
    known = in_operation(study).pattern_known
    moved = np.abs(study.mountings.pinion_z[:OPERATION, 1] - study.nominal.pinion_z[0, 1])
    assert np.count_nonzero(known) == PATTERNS
    assert moved[known].min() > moved[~known].max()


def test_a_mounting_without_first_contact_is_named() -> None:
    """A mounting in which the pinion is moved far along its axis has no first contact: its values are NaN,
    with a status."""
    errors = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 400.0, 0.0]])
    found = cycle_statistics(mounted(MODIFIED, errors), "right")
    assert found.status.tolist()[0] == FirstStatus.SOLVED
    assert found.status.tolist()[1] != FirstStatus.SOLVED
    assert np.isnan([found.cycle_peak_to_peak[1], found.edge_share[1], found.film_ratio[1]]).all()
    assert pattern_counts(found)["known"] == 0
