"""The comparison of methods: complete, with the errors that each method has, and no failure dropped."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Errors, builtin_design, path_of_contact, studies
from beveloid_geom.reference import five_equations_math
from beveloid_geom.reference.five_equations_math import Contacts, solve_math
from beveloid_geom.studies import comparison
from beveloid_geom.studies.comparison import ARCSEC, EXACT, FIRST, GRID, Row, Settings, compare, compare_first
from beveloid_geom.studies.comparison_methods import (
    COUNT,
    Answer,
    Positions,
    along,
    batches,
    five_answer,
    given_answer,
    true_positions,
)
from beveloid_viz.figures.methods import speed_accuracy as fig_speed

from ..oracle.table1 import table1
from ..viz.pages import page_of
from .kept_positions import cases

SMALL = Settings(
    tolerances=(0.1, 0.01),
    xtols=(1e-2, 1e-6, 1e-14),
    iterations=(0, 1, 2, 3, 4),
    batches=(1, 10, 100),
    grids=(8, 64),
    batch=10,
    run=11,
    repeat=0,
)
FLANKS = ("right", "left")
PARABOLAS = ((0.0, 0.0), (0.001, -0.001))
CASES = [(flank, parabola) for parabola in PARABOLAS for flank in FLANKS]
BATCHED = ("one equation, given l1", "Newton on F")


@cache
def rows_of(flank: str, parabola: tuple[float, float]) -> tuple[Row, ...]:
    return compare(table1(parabola), flank, SMALL)


def errors(rows: tuple[Row, ...], method: str, kind: str | None = None) -> list[float]:
    return [row.error_mm for row in rows if row.method == method and kind in (None, row.kind)]


@pytest.mark.parametrize(("flank", "parabola"), CASES)
def test_every_method_has_a_row_at_every_setting(flank: str, parabola: tuple[float, float]) -> None:
    rows = rows_of(flank, parabola)
    found: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        found.setdefault((row.method, row.kind), []).append(row.value)
        assert row.status == "solved"
        assert np.isfinite([row.error_mm, row.transmission_error_arcsec]).all()
        assert row.seconds_per_position > 0.0
        assert row.setup_seconds > 0.0
    expected = {(method, "tolerance"): SMALL.tolerances for method in ("mesh alone", "mesh, polished")}
    expected |= {(f"five equations, {start}", "xtol"): SMALL.xtols for start in ("cold", "warm")}
    expected |= {(method, "batch"): SMALL.batches for method in BATCHED}
    expected |= {(method, "iterations"): SMALL.iterations for method in BATCHED[1:]}
    expected[("one equation, path", "batch")] = (11, 101)
    assert {key: tuple(values) for key, values in found.items()} == expected


@pytest.mark.parametrize(("flank", "parabola"), CASES)
def test_errors_are_those_of_the_method(flank: str, parabola: tuple[float, float]) -> None:
    rows = rows_of(flank, parabola)
    for method in ("mesh, polished", "one equation, path", "one equation, given l1"):
        assert max(errors(rows, method)) < 1e-10, method
    assert max(errors(rows, "Newton on F", "batch")) < 1e-10
    for start in ("cold", "warm"):
        loose, closer, tight = errors(rows, f"five equations, {start}")
        assert tight < 1e-10
        assert loose > 1e-6
        assert closer < 1e-2 * loose
    assert min(errors(rows, "mesh alone")) > (1.0 if flank == "right" else 0.1)


@pytest.mark.parametrize(("flank", "parabola"), CASES)
def test_transmission_errors_are_those_of_the_method(flank: str, parabola: tuple[float, float]) -> None:
    by_method: dict[str, list[float]] = {}
    for row in rows_of(flank, parabola):
        if row.kind != "iterations":
            by_method.setdefault(row.method, []).append(row.transmission_error_arcsec)
    for method in ("mesh, polished", "one equation, path", "one equation, given l1", "Newton on F"):
        assert max(by_method[method]) < 1e-7, method
    # A separation of 0.01 mm is 15 arcsec on the gear; only its change along the path counts.
    assert 1.0 < by_method["mesh alone"][1] < by_method["mesh alone"][0] < 300.0


def test_first_contacts_of_all_teeth_by_other_ways(flank: str) -> None:
    """Right, an edge carries at one of the five positions, which a polish of tangencies does not find; left,
    all are tangencies, and proximity ends at the exact ones by code that shares no search with them."""
    rows = compare_first(table1(PARABOLAS[1]), flank, SMALL)
    assert all(row.status == "solved" for row in rows)
    assert max(errors(rows, EXACT)) < 1e-10
    coarse, fine = errors(rows, GRID)
    assert 1e-3 < fine < coarse
    assert errors(rows, "mesh alone" + FIRST)[0] > 1.0
    (polished,) = errors(rows, "mesh, polished" + FIRST)
    assert polished > 1.0 if flank == "right" else polished < 1e-10
    late = [row.transmission_error_arcsec for row in rows if row.method == GRID]
    assert 0.01 < late[1] < 0.2 * late[0] < 5.0


def test_newton_converges_quadratically(flank: str) -> None:
    exact = errors(rows_of(flank, PARABOLAS[1]), "Newton on F", "iterations")
    assert exact[0] > 1.0
    for before, after in pairwise(exact[1:4]):
        assert after < before**1.5


def test_one_step_is_exact_without_parabola(flank: str) -> None:
    """F is linear then; the rolls say so, as the point does not depend on l2 at all."""
    rows = rows_of(flank, PARABOLAS[0])
    steps = [row for row in rows if row.method == "Newton on F" and row.kind == "iterations"]
    assert steps[0].transmission_error_arcsec > 100.0
    assert steps[1].transmission_error_arcsec < 1e-7


@cache
def truth() -> Positions:
    return true_positions(table1(PARABOLAS[1]), "right")


def test_the_truth_is_that_of_the_path() -> None:
    positions, path = truth(), path_of_contact(table1(PARABOLAS[1]), "right", 2 * COUNT + 1)
    assert np.abs(positions.point - path.point[1::2]).max() < 1e-10
    assert np.abs(positions.l1 - path.l1[1::2]).max() < 1e-10
    assert np.abs(positions.gear_roll - path.gear_roll[1::2]).max() < 1e-12
    for size in (2, 11, 37, 1000):
        points, picked = along(size)
        rolls = path_of_contact(table1(PARABOLAS[1]), "right", points).pinion_roll[picked]
        assert np.abs(rolls - positions.pinion_roll).max() < 1e-14
    assert [along(size)[0] for size in (1, 14, 17, 100_000)] == [11, 11, 21, 100_001]


def row_for(work: object) -> Row:
    trial = comparison._Trial(("some method", "batch", 5), work, COUNT, 0.25)  # type: ignore[arg-type]
    return comparison._row(truth(), trial, 0)


def true_answer() -> Answer:
    return truth().point.copy(), np.stack((truth().pinion_roll, truth().gear_roll))


def test_a_wrong_answer_has_its_error() -> None:
    """Against known shifts: of one point by 3-4-5, of one roll, and of all rolls, which is no error."""
    point, roll = true_answer()
    point[3] += (3e-6, 0.0, -4e-6)
    roll[1] += 0.125
    row = row_for(lambda: (point, roll))
    assert row.error_mm == pytest.approx(5e-6, rel=1e-6)
    assert row.transmission_error_arcsec < 1e-9
    roll[1, 0] += 1e-6
    row = row_for(lambda: (point, roll))
    assert row.transmission_error_arcsec == pytest.approx(1e-6 * ARCSEC, rel=1e-6)
    roll[1, 2] += 2e-6  # the middle is the level
    assert row_for(lambda: (point, roll)).transmission_error_arcsec == pytest.approx(2e-6 * ARCSEC, rel=1e-6)


def test_a_failure_has_its_row() -> None:
    def fails() -> Answer:
        raise ArithmeticError("it went astray")

    row = row_for(fails)
    assert (row.status, row.kind, row.value, row.setup_seconds) == ("it went astray", "batch", 5, 0.25)
    assert np.isnan([row.error_mm, row.transmission_error_arcsec, row.seconds_per_position]).all()
    point, roll = true_answer()
    point[1, 2] = roll[0, 4] = np.nan
    row = row_for(lambda: (point, roll))
    assert row.status == "2 of 5 positions not found"
    assert np.isnan([row.error_mm, row.transmission_error_arcsec]).all()
    assert row.seconds_per_position > 0.0


def test_a_mesh_too_coarse_has_its_row() -> None:
    """Meshes that take too many points are refused by `sample_flank`: every row says so."""
    rows = compare(
        table1(), "right", replace(SMALL, tolerances=(1e-15,), xtols=(), iterations=(), batches=())
    )
    meshes = [row for row in rows if row.kind == "tolerance"]
    assert [row.method for row in meshes] == ["mesh alone", "mesh, polished"]
    for row in meshes:
        assert np.isnan([row.error_mm, row.setup_seconds]).all()
        assert "tolerance" in row.status


def test_five_equations_that_do_not_converge_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    from beveloid_geom.reference import pitch_region

    monkeypatch.setattr(pitch_region, "pitch_guess", lambda *_: (60.0, 400.0, -60.0, 400.0, 3.0, 1.0))
    settings = replace(SMALL, tolerances=(), xtols=(1e-10,), iterations=(), batches=())
    rows = [row for row in compare(table1(), "left", settings) if row.kind == "xtol"]
    assert len(rows) == 2
    for row in rows:
        assert row.status != "solved" or row.error_mm > 1.0, row


def test_cold_starts_are_cold_and_lost_positions_are_nan(monkeypatch: pytest.MonkeyPatch) -> None:
    def found(cold: bool, picked: slice = slice(None)) -> Answer:
        return five_answer(truth(), 1e-2, truth().pinion_roll, picked, cold)

    (cold, rolls), (warm, _) = found(True), found(False)
    assert np.array_equal(cold[0], warm[0])
    assert (np.abs(cold[1:] - warm[1:]).max(axis=-1) > 0.0).all()
    assert np.array_equal(rolls[0], truth().pinion_roll)

    def unsure(*args: Any, **options: Any) -> Contacts:
        return replace(solve_math(*args, **options), converged=np.arange(COUNT) != 3)

    monkeypatch.setattr(five_equations_math, "solve_math", unsure)
    point, _ = found(True, slice(1, None))
    assert np.array_equal(np.isnan(point).all(axis=-1), [False, False, True, False])


def test_kept_positions_are_those_at_60_digits() -> None:
    kept = json.loads(
        (Path(studies.__file__).parent / "positions_of_table1.json").read_text(encoding="utf-8")
    )
    for ours, found in zip(kept, cases(), strict=True):
        assert (ours["flank"], tuple(ours["parabola"])) == (found["flank"], found["parabola"])
        np.testing.assert_allclose(ours["positions"], found["positions"], rtol=0.0, atol=1e-12)


def test_the_figure_needs_no_mpmath_but_for_other_designs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mpmath", None)
    monkeypatch.delitem(sys.modules, "beveloid_geom.reference.five_equations_mp", raising=False)
    for flank, parabola in CASES:
        assert true_positions(builtin_design().with_parabola(*parabola), flank).l1.size == COUNT
    with pytest.raises(ImportError, match=r"60 digits need mpmath: pip install mpmath$"):
        true_positions(table1((0.0005, 0.0)), "right")
    monkeypatch.setattr(fig_speed, "modified", lambda design: design.with_parabola(0.0005, 0.0))
    monkeypatch.setattr(
        fig_speed, "SETTINGS", replace(SMALL, tolerances=(), xtols=(), iterations=(), batches=())
    )
    assert ["pip install mpmath" in case.reason for case in fig_speed.compute(table1())] == [False] * 2 + [
        True
    ] * 2


def test_an_l1_without_its_contact_is_named() -> None:
    """Far off the flanks there is no common normal, and so no contact at this l1."""
    astray = replace(truth(), l1=truth().l1 + np.array([0.0, 900.0, 0.0, 0.0, 0.0]))
    with pytest.raises(ArithmeticError, match=r"1 of 5 positions not found by their l1 \([A-Z_]+\)"):
        given_answer(astray, batches(astray, 1))


def test_batches_hold_the_positions_compared_first() -> None:
    for size, calls in ((1, 5), (2, 3), (5, 1), (10, 1), (100, 1)):
        found = batches(truth(), size)
        assert len(found) == calls
        assert max(part.size for part in found) == size
        assert np.array_equal(np.concatenate(found)[:COUNT], truth().l1)


def test_without_contact_there_is_nothing_to_compare() -> None:
    with pytest.raises(ValueError, match=r"right flanks have no contact .*\(OFF_FLANK\)"):
        compare(table1(errors=Errors(offset=20.0)))
    with pytest.raises(ValueError, match=r"batch of the shape \(3,\)"):
        compare(table1(errors=Errors(offset=np.zeros(3))))


def test_the_speed_figures_words_and_numbers() -> None:
    cases = [
        fig_speed.SpeedCase(flank, parabola, rows_of(flank, parabola))
        for parabola in PARABOLAS
        for flank in FLANKS
    ]
    data = (*cases[:3], fig_speed.SpeedCase("left", PARABOLAS[1], (), "the left flanks have no contact"))
    header, lines = fig_speed.rows(data)
    assert list(header)[:4] == ["flank", "a1_per_mm", "a2_per_mm", "status"]
    measured = "error_mm transmission_error_arcsec seconds_per_position setup_seconds"
    assert list(header)[4:] == ["method", "setting", "value", *measured.split()]
    body = [list(line) for line in lines]
    assert len(body) == sum(len(case.rows) for case in cases[:3]) + 1
    assert all(len(line) == len(header) for line in body)
    assert body[0][4:7] == ["mesh alone", "tolerance", 0.1]
    assert body[-1][3] == "the left flanks have no contact"
    text = fig_speed.finding(data)
    exact = rows_of("right", PARABOLAS[1])
    mesh = next(row for row in exact if (row.method, row.value) == ("mesh alone", 0.01))
    assert f"a mesh to 0.01 mm alone is {mesh.error_mm:.2g} mm off" in text
    assert "4 Newton steps do" in text
    assert "times as fast" in text
    page = page_of(fig_speed.draw, data, (400, 300))
    words = [text.get_text().replace("\n", " ") for axes in page.axes for text in axes.texts]
    assert "the left flanks have no contact" in words
    assert "0 steps" in words
    assert "ot found" not in " ".join(text.get_text() for text in page.texts)
    failed = replace(exact[0], status="astray", error_mm=float("nan"))
    page = page_of(fig_speed.draw, (replace(cases[0], rows=(failed, *exact[1:])), *cases[1:]), (400, 300))
    below = " ".join(" ".join(text.get_text().split()) for text in page.texts)
    assert "for reasons in the table: (a) mesh alone (1 of 2)." in below
