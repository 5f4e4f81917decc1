"""Tolerance studies: seeds, executors, single designs, closed forms, and the command."""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Modification,
    Pair,
    Status,
    Tolerances,
    Tool,
    mounted_backlash,
    path_of_contact,
    tolerance_study,
)
from beveloid_geom.analysis.mountings import PLACES, Mountings, swing_of
from beveloid_geom.analysis.tolerance import (
    MOUNTINGS_PER_BLOCK,
    USUAL,
    ToleranceStudy,
    drawn_errors,
    tolerance_studies,
)
from beveloid_geom.gear.flank_limits import root_parameter
from beveloid_geom.operation.backlash_by_tangency import Tangency
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.report.tolerance import ToleranceReport, jam_counts
from beveloid_geom.status import Limit
from tests.cli.running import refused, run
from tests.oracle.table1 import table1

GIVEN = Tolerances(0.05, math.radians(0.01), 0.1, 0.1)
MODIFIED = table1((0.001, -0.001))
CASES = MOUNTINGS_PER_BLOCK + 100
SEED = 7


def same(first: Mountings, second: Mountings) -> bool:
    """Return whether two sets of mountings are equal bit for bit."""
    pairs = ((getattr(first, field.name), getattr(second, field.name)) for field in fields(Mountings))
    return all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in pairs)


@pytest.fixture(scope="module")
def study() -> ToleranceStudy:
    return tolerance_study(MODIFIED, GIVEN, "right", CASES, seed=SEED)


def repeated(executor: Executor | None, blocks_per_task: int, cases: int = CASES) -> Mountings:
    return tolerance_study(
        MODIFIED, GIVEN, "right", cases, seed=SEED, executor=executor, blocks_per_task=blocks_per_task
    ).mountings


@pytest.mark.parametrize("blocks_per_task", [1, 2, 50])
def test_the_size_of_tasks_does_not_change_the_result(study: ToleranceStudy, blocks_per_task: int) -> None:
    assert same(repeated(None, blocks_per_task), study.mountings)


class Immediate(Executor):
    """Minimal executor: it runs one task at a time, when the task is submitted."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


EXECUTORS: dict[str, Callable[[], Executor]] = {
    "threads": lambda: ThreadPoolExecutor(2),
    "processes": lambda: ProcessPoolExecutor(2, multiprocessing.get_context("spawn")),
    "another": Immediate,
}


@pytest.mark.parametrize("kind", EXECUTORS)
def test_executors_do_not_change_the_result(study: ToleranceStudy, kind: str) -> None:
    with EXECUTORS[kind]() as executor:
        assert same(repeated(executor, 1), study.mountings)


@pytest.mark.slow
def test_a_cluster_does_not_change_the_result(study: ToleranceStudy) -> None:
    """Two processes of a Dask cluster give the same result as one process, as stated on the page of the
    package."""
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster) as client,
        client.get_executor() as executor,
    ):
        assert same(repeated(executor, 1), study.mountings)


def test_a_lost_process_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(*_: object, executor: Executor, **__: object) -> None:
        executor.submit(os.abort).result()

    monkeypatch.setattr("beveloid_geom.analysis.tolerance.tolerance_study", killed)
    line = "Error: a process ended unexpectedly, perhaps for lack of memory: try fewer --jobs\n"
    assert refused("tolerance", "--jobs", "2", "--cases", "5000") == line


@pytest.mark.parametrize(
    ("cases", "operation", "expected"), [(10, 0, []), (4096, 64, []), (4097, 0, [2]), (200, 130, [3])]
)
def test_no_more_processes_than_tasks(
    cases: int, operation: int, expected: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    started = []

    def workers(number: int) -> Executor:
        started.append(number)
        return Immediate()

    monkeypatch.setattr("beveloid_geom.support.process.workers", workers)
    tasks = ("--cases", str(cases), "--operation", str(operation))
    assert run("tolerance", "--jobs", "1024", *tasks).exit_code == 0
    assert started == expected


@pytest.mark.parametrize("parabolas", [(0.001, -0.001), (0.0, 0.0)])
def test_both_flanks_together_equal_single_studies(parabolas: tuple[float, float]) -> None:
    """The backlash, which is computed once, is also equal bit for bit."""
    design, done = table1(parabolas), list[int]()
    together = tolerance_studies(design, GIVEN, ("right", "left"), CASES, seed=SEED, progress=done.append)
    assert sum(done) == CASES
    for both, flank in zip(together, ("right", "left"), strict=True):
        alone = tolerance_study(design, GIVEN, flank, CASES, seed=SEED)
        assert both.flank == flank
        assert same(both.mountings, alone.mountings)
        assert same(both.nominal, alone.nominal)


def test_seeds_differ_and_longer_studies_begin_with_the_same_mountings(study: ToleranceStudy) -> None:
    errors = study.mountings.errors
    assert not np.isin(errors, drawn_errors(GIVEN, SEED + 1, 0, MOUNTINGS_PER_BLOCK)).any()
    assert np.unique(errors, axis=0).shape == errors.shape
    np.testing.assert_array_equal(repeated(None, 1, 30).errors, errors[:30])


def test_streams_are_spawned_from_the_seed(study: ToleranceStudy) -> None:
    child = np.random.default_rng(np.random.SeedSequence(SEED).spawn(2)[1])
    expected = child.standard_normal((CASES - MOUNTINGS_PER_BLOCK, 4)) * (GIVEN.values() / 3.0)
    np.testing.assert_array_equal(study.mountings.errors[MOUNTINGS_PER_BLOCK:], expected)


CROWNED = replace(table1(), pinion=table1().pinion.modified(Modification(helix_crowning_um=10.0)))


@pytest.mark.parametrize(
    ("pair", "flank", "offset"), [(MODIFIED, "right", 1.2), (MODIFIED, "left", 5.0), (CROWNED, "right", 3.0)]
)
def test_mountings_agree_with_single_solves(pair: Design, flank: str, offset: float) -> None:
    """The errors are added to those of the design, and are so large that limits change and paths are lost."""
    design = pair.with_errors(Errors(offset=0.02, pinion_axial=-0.1))
    wide = Tolerances(offset, math.radians(0.01), 2.0, 2.0, "uniform")
    study = tolerance_study(design, wide, flank, 60, seed=3)
    found = study.mountings
    assert set(found.status) == {Status.SOLVED, Status.OFF_FLANK}
    for k, drawn in enumerate(found.errors):
        own = np.array([0.02, 0.0, -0.1, 0.0]) + drawn
        path = path_of_contact(design.with_errors(Errors(*own.tolist())), flank, 401)
        assert (path.ends.status, path.ends.pieces) == (found.status[k], found.pieces[k])
        np.testing.assert_array_equal(path.ends.limit, found.limit[k])
        np.testing.assert_allclose(found.contact_ratio[k], path.ends.contact_ratio, rtol=1e-9)
        for name in ("pinion_z", "pinion_r", "gear_z", "gear_r"):
            expected = getattr(path, name)[[0, 200, 400]] if path.l1.size else np.full(3, np.nan)
            np.testing.assert_allclose(getattr(found, name)[k], expected, atol=1e-8, rtol=0.0)
        swing = np.ptp(path.transmission_error) if path.l1.size else np.nan
        np.testing.assert_allclose(found.peak_to_peak[k], swing, rtol=1e-4)
    assert study.limits_changed() == np.count_nonzero(
        (found.status == Status.SOLVED) & (found.limit != study.nominal.limit).any(axis=1)
    )


def test_without_tolerances_every_mounting_is_the_design() -> None:
    for distribution in ("normal", "uniform"):
        study = tolerance_study(MODIFIED, Tolerances(distribution=distribution), cases=5)
        path = path_of_contact(MODIFIED, "right", 17)
        assert not study.mountings.errors.any()
        assert study.limits_changed() == 0
        for name, value in study.mountings.quantities().items():
            np.testing.assert_allclose(value, study.nominal.quantities()[name][0], rtol=1e-9)
        np.testing.assert_allclose(study.nominal.contact_ratio, 1.816308, atol=5e-7)
        np.testing.assert_allclose(study.nominal.gear_z[0], path.gear_z[[0, 8, 16]], rtol=1e-12)


def test_quantiles_are_over_the_mountings_with_a_path() -> None:
    study = tolerance_study(table1(), Tolerances(offset=2.0, distribution="uniform"), cases=500)
    found, solved = study.mountings, study.mountings.solved
    assert 0 < np.count_nonzero(solved) < 500
    quantiles = study.quantiles((0.0, 0.5, 1.0))
    assert tuple(quantiles) == tuple(found.quantities())
    for place, name in enumerate(PLACES):
        values = np.sort(found.gear_z[solved, place])
        expected = values[0], np.median(values), values[-1]
        np.testing.assert_allclose(quantiles[f"gear_z_{name}"], expected, rtol=1e-14)
    assert quantiles["contact_ratio"][0] == found.contact_ratio[solved].min() > 0.0
    assert study.status_counts()[Status.OFF_FLANK] == np.count_nonzero(found.contact_ratio == 0.0)
    assert sum(study.status_counts().values()) == 500
    assert sum(study.limit_counts().values()) == np.count_nonzero(solved)
    assert next(iter(study.limit_counts())) == (Limit.GEAR_TIP, Limit.PINION_TIP)
    far = tolerance_study(table1(errors=Errors(offset=4.0)), Tolerances(offset=0.1), cases=3)
    assert np.isnan(far.quantiles()["contact_ratio"]).all()
    assert far.status_counts()[Status.OFF_FLANK] == 3


def axial_limits() -> tuple[float, float]:
    """Return the axial errors of the pinion of Table 1 between which its path is on the flanks, mm.

    The line of action of unmodified flanks is fixed in space and relative to the gear. The pinion moves
    along its axis, so that z of the path on the pinion decreases by the error. The limits of the gear
    keep their positions on the line of action. The path is lost where the toe of the pinion reaches the
    tip of the gear, or its heel the root of the gear."""
    line = path_of_contact(table1(), "right", 2)
    slope = (line.pinion_z[1] - line.pinion_z[0]) / (line.l2[1] - line.l2[0])
    root = float(np.squeeze(root_parameter(table1().gear, "right")))
    at_tip, at_root = float(line.pinion_z[0]), float(line.pinion_z[0] + slope * (root - line.l2[0]))
    half_width = 0.5 * float(table1().pinion.face_width)
    return at_root - half_width, at_tip + half_width


@pytest.mark.parametrize("distribution", ["uniform", "normal"])
def test_share_off_the_flank_in_closed_form(distribution: Any) -> None:
    low, high = axial_limits()
    given = Tolerances(pinion_axial=60.0, distribution=distribution, sigmas=2.0)
    study = tolerance_study(table1(), given, cases=4096, seed=1)
    error = study.mountings.errors[:, 2]
    off = study.mountings.status == Status.OFF_FLANK
    np.testing.assert_array_equal(off, (error < low) | (error > high))
    np.testing.assert_array_equal(study.mountings.solved, ~off)
    below, above = (math.erf(end / 30.0 / math.sqrt(2.0)) for end in (low, high))
    share = 1.0 - ((high - low) / 120.0 if distribution == "uniform" else 0.5 * (above - below))
    assert abs(off.mean() - share) < 4.0 * math.sqrt(share * (1.0 - share) / off.size)


@pytest.mark.parametrize(("distribution", "deviation"), [("normal", 0.5), ("uniform", 1.0 / math.sqrt(3.0))])
def test_mean_and_variance_of_the_errors(distribution: Any, deviation: float) -> None:
    given = replace(GIVEN, distribution=distribution, sigmas=2.0)
    shares = (
        np.concatenate([drawn_errors(given, 5, unit, MOUNTINGS_PER_BLOCK) for unit in range(100)])
        / given.values()
    )
    count = len(shares)
    assert np.abs(shares.mean(axis=0)).max() < 4.5 * deviation / math.sqrt(count)
    fourth = 3.0 if distribution == "normal" else 9.0 / 5.0  # over the variance squared
    spread = deviation**2 * math.sqrt((fourth - 1.0) / count)
    assert np.abs(shares.var(axis=0) - deviation**2).max() < 4.5 * spread
    correlation = np.corrcoef(shares.T) - np.eye(4)
    assert np.abs(correlation).max() < 4.5 / math.sqrt(count)
    assert (np.abs(shares).max() <= 1.0) == (distribution == "uniform")


def test_jammed_mountings_are_counted() -> None:
    """The share of jammed mountings is that of the normal distribution. With 0.3 mm as 3 sigma of the offset,
    Table 1 jams at offset errors below -0.0588 mm."""
    study = tolerance_study(table1(), Tolerances(offset=0.3), cases=20_000)
    share = 0.5 * math.erfc(0.0588 / 0.1 / math.sqrt(2.0))
    assert np.mean(study.mountings.jammed) == pytest.approx(share, abs=4.0 * math.sqrt(share / 20_000))
    assert (study.mountings.tangency == Tangency.TOUCHES).all()
    offset, backlash = study.mountings.errors[:, 0], study.mountings.normal_backlash
    np.testing.assert_array_equal(study.mountings.jammed, backlash < -2e-5 * 6.0)
    assert (backlash[np.argsort(offset)][1:] > backlash[np.argsort(offset)][:-1]).all()
    assert float(study.nominal.normal_backlash[0]) == pytest.approx(0.0416, abs=5e-5)


def test_an_error_without_tolerance_is_plain_zero() -> None:
    drawn = drawn_errors(replace(GIVEN, offset=0.0), 0, 0, 50)
    assert not np.signbit(drawn[:, 0]).any()
    assert drawn[:, 1:].all()


def test_ten_times_the_usual_errors_jam_two_of_five() -> None:
    """Under ten times the usual errors, 40 % of the mountings jam. At least half of these jam with certainty;
    the others have a path that leaves the faces."""
    given = Tolerances(0.5, math.radians(0.1), 1.0, 1.0)
    study = tolerance_study(table1(), given, cases=8 * MOUNTINGS_PER_BLOCK)
    counts = jam_counts(study)
    assert counts["jammed"] / study.cases == pytest.approx(0.402, abs=0.02)
    assert 0.5 * counts["jammed"] < counts["jammed_for_sure"] < counts["jammed"]
    assert counts["backlash_unknown"] == 0
    some = np.flatnonzero(study.mountings.jammed & (study.mountings.tangency == Tangency.TOUCHES))[:4]
    assert mounted_backlash(mounted(table1(), study.mountings.errors[some])).jammed.all()
    report = ToleranceReport("x", table1(), study)
    data = report.data()
    assert {name: data[name] for name in counts} == counts
    assert len(data["quantiles"]["normal_backlash"]) == len(data["quantiles"]["share"])
    assert "of the mountings cannot be assembled" in " ".join(report.summary().split())


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("place", [0.03, 0.47, 0.99])
def test_range_of_a_parabola_with_its_extremum_between_values(sign: float, place: float) -> None:
    x = np.linspace(0.0, 1.0, 17)
    values = sign * (x - place) ** 2
    expected = max(place, 1.0 - place) ** 2
    assert swing_of(values) == pytest.approx(expected, rel=1e-14)
    np.testing.assert_allclose(swing_of(np.stack([values, 3.0 * values])), [expected, 3.0 * expected])


def test_few_known_backlashes_have_no_quantiles() -> None:
    """Paths of crowned helical teeth on parallel axes end at an end of a face: their backlash is not known
    from the paths, in almost all mountings."""
    crowned = Modification(helix_crowning_um=8.0, tip_relief_um=12.0, tip_relief_length_mm=1.5)
    pinion, gear = (
        Member(Tool(3.0, np.radians(20.0)), teeth, np.radians(helix), 0.0, shift, width)
        for teeth, helix, shift, width in ((9, 18.0, 0.1, 30.0), (40, -18.0, 0.0, 28.0))
    )
    gear = gear.modified(Modification(profile_crowning_um=5.0))
    design = Design(pinion.modified(crowned), gear, Pair(77.6, 0.0))
    study = tolerance_study(design, USUAL, "right", 50)
    assert np.isfinite(study.mountings.normal_backlash).mean() < 0.5
    assert np.isnan(study.quantiles()["normal_backlash"]).all()
    assert np.isfinite(study.quantiles()["contact_ratio"]).all()
    text = ToleranceReport("x", design, study).summary()
    assert (
        "no quantiles, because the values of less than 90 % of the mountings are known: normal backlash\n"
        in text
    )
    assert "not known" in text.split("jammed")[1].split("\n")[0]
    (row,) = [line for line in text.splitlines() if line.startswith("normal backlash, mm")]
    assert row.split()[-5:] == ["-"] * 5
