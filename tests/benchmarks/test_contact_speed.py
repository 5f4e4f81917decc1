"""Speed of the path of contact, as ratios in one run on the same work.

    python -m pytest tests/benchmarks -m benchmark -s

The reference solves the five equations of the paper with `scipy.optimize.fsolve` (xtol 1e-14). Each
position starts from the one before. The reference is written in scalar floats; all constants are computed
before, and each evaluation needs one square root, one sine and one cosine for each member (about 20
evaluations per position). The one equation gives the full result (every field of `ContactPath`).
Quantities that depend only on the members, and the mounting, are known from an earlier call."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from itertools import count
from time import process_time
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Member,
    Modification,
    Pair,
    Tool,
    contact_ratio,
    path_of_contact,
)
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.validation.five_equations_math import solve_math
from tests.benchmarks.timing import best, timed
from tests.contact.test_root_exclusion import MOUNTINGS, OFF_THE_FLANKS, modified_and_misaligned
from tests.oracle.sixty_digits import numbers_of
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_one_equation_against_five(flank: str, parabola: tuple[float, float]) -> None:
    design, l1 = table1(parabola), np.linspace(-5.0, 5.0, 100_000)
    path, mounting = path_of_contact(design, flank, 1_001), mounting_of(design).distance
    known = numbers_of(path, 0), (float(mounting[0]), float(mounting[1]))
    five = partial(solve_math, design, flank, path.pinion_roll, *known)
    steps = count(1)  # an earlier path is cached

    def path_with_new_errors(points: int) -> ContactPath:
        return path_of_contact(design.with_errors(Errors(offset=1e-12 * next(steps))), flank, points)

    paths = {n: partial(path_with_new_errors, n) for n in (101, 1_000, 100_000)}
    cost = timed(
        f"{flank} flank, a = {parabola}",
        {
            **{f"path of {n:,}": (work, 50 if n < 100_000 else 7, n) for n, work in paths.items()},
            "given l1": (partial(path_of_contact, design, flank, l1=l1), 7, l1.size),
            "five equations, scalar math": (five, 5, 1_001),
        },
    )
    ratio = cost["five equations, scalar math"] / cost["path of 100,000"]
    print(f"  faster by {ratio:.0f}")
    assert np.abs(five().point - path.point).max() < 1e-10
    assert ratio > 500.0


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_small_calls_against_five(flank: str, parabola: tuple[float, float]) -> None:
    """Time for a path of 101 positions with exact ends, which an earlier call has computed ("known") or
    which are new, relative to as many positions of the five equations, each started from the one before.
    Time for a call with a single position, relative to one position of the five equations that starts from
    the position before."""
    design = table1(parabola)
    path, mounting = path_of_contact(design, flank, 101), mounting_of(design).distance
    known, errors = (numbers_of(path, 0), (float(mounting[0]), float(mounting[1]))), count(1)
    works: dict[str, Callable[[], object]] = {
        "five equations": partial(solve_math, design, flank, path.pinion_roll, *known),
        "five equations, one position": partial(solve_math, design, flank, path.pinion_roll[1:2], *known),
        "path, known": partial(path_of_contact, design, flank, 101),
        "path, new errors": lambda: path_of_contact(
            design.with_errors(Errors(offset=1e-9 * next(errors))), flank, 101
        ),
        "position": partial(path_of_contact, design, flank, l1=[1.0]),
    }
    times = dict.fromkeys(works, np.inf)
    for _ in range(10):
        for name, work in works.items():
            times[name] = min(times[name], best(work, 2 if name == "five equations" else 20, process_time))
    five = times["five equations"]
    for name, seconds in times.items():
        print(
            f"\n{flank}, a = {parabola}, {name}: {1e3 * seconds:.3f} ms, five equations {five / seconds:.1f}"
        )
    assert five / times["path, known"] > 30.0
    assert five / times["path, new errors"] > 5.0
    assert times["position"] < 5.0 * times["five equations, one position"]


DEFAULT_THREADS = """
import sys
import time
import numpy as np
from beveloid_geom import Errors, mesh_cycle, path_of_contact
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors, tolerance_study
from beveloid_geom.pair.misalignment import mounted
from tests.oracle.table1 import table1

table, one = table1((0.001, -0.001)), iter(range(1, 1000))
many = mounted(table, drawn_errors(USUAL, 0, 0, 10_000))
works = {
    "path of 100,000": lambda: path_of_contact(table, "right", 100_000),
    "10,000 misaligned pairs": lambda: path_of_contact(many, "right", 17),
    "study of 20,000 mountings": lambda: tolerance_study(table, USUAL, "right", 20_000),
    "mesh cycle": lambda: mesh_cycle(table.with_errors(Errors(1e-6 * next(one)))),
}
for name, work in works.items():
    work()
for line in sys.stdin:
    start = time.perf_counter(), time.process_time()
    works[line.strip()]()
    print(time.perf_counter() - start[0], time.process_time() - start[1], flush=True)
"""


@pytest.mark.parametrize("busy", [False, True])
def test_default_threads_take_as_long_as_one_thread(busy: bool) -> None:
    """Default settings of BLAS and a single thread, alternately, 20 times each, also while another process
    uses a core."""
    default = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    works = "path of 100,000", "10,000 misaligned pairs", "study of 20,000 mountings", "mesh cycle"
    with ExitStack() as stack:

        def started(script: str, more: dict[str, str]) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [sys.executable, "-c", script],
                env=default | more,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            stack.enter_context(process)
            stack.callback(process.kill)
            return process

        if busy:
            started("while True: pass", {})
        both = [started(DEFAULT_THREADS, more) for more in ({}, {"OPENBLAS_NUM_THREADS": "1"})]
        for name in works:
            times = np.empty((2, 20, 2))  # of each process, run by run, wall and processor time
            for run in range(20):
                for k, process in enumerate(both):
                    assert process.stdin is not None
                    assert process.stdout is not None
                    process.stdin.write(f"{name}\n")
                    process.stdin.flush()
                    times[k, run] = [float(part) for part in process.stdout.readline().split()]
            wall, processor = np.median(times, axis=1).T
            print(f"\n{name}, busy {busy}: {1e3 * wall[0]:.1f} ms, ratio {wall[0] / wall[1]:.2f}")
            print(f"processor time {1e3 * processor[0]:.1f} ms, ratio {processor[0] / processor[1]:.2f}")
            assert processor[0] < 1.2 * processor[1], name
            assert wall[0] < 1.2 * wall[1], name


@pytest.mark.parametrize(("crowned", "relieved"), [(True, False), (True, True), (False, True)])
def test_modified_flanks_against_unmodified(crowned: bool, relieved: bool) -> None:
    """Time for Table 1 with crowning of the pinion, with crowning and reliefs of all edges of both members,
    or with these reliefs only, relative to unmodified flanks: a path of 101 positions, and contact ratios of
    1,000 mountings."""
    plain = table1()
    amounts: dict[str, Any] = {"helix_crowning_um": 10.0, "profile_crowning_um": 8.0} if crowned else {}
    if relieved:
        for edge in ("tip", "root", "heel", "toe"):
            amounts |= {f"{edge}_relief_um": 15.0, f"{edge}_relief_length_mm": 3.0}
    given = Modification(**amounts)
    gear = plain.gear.modified(given) if relieved else plain.gear
    modified = replace(plain, pinion=plain.pinion.modified(given), gear=gear)
    errors, steps = drawn_errors(USUAL, 0, 0, 1_000), count(1)

    def path(design: Design) -> ContactPath:
        """Return the path with new errors, as that of an earlier call is cached."""
        return path_of_contact(design.with_errors(Errors(offset=1e-9 * next(steps))), "right", 101)

    for name, work, repeat, most in (
        ("path of 101", path, 10, 10.0),
        ("contact ratio of 1,000", lambda design: contact_ratio(mounted(design, errors), "right"), 2, 3.0),
    ):
        works = [partial(work, design) for design in (plain, modified)]
        times = np.min([[best(work, repeat, process_time) for work in works] for _ in range(8)], axis=0)
        print(f"\n{name}: {times[1] / times[0]:.1f} times that of unmodified flanks")
        assert times[1] / times[0] < most


def test_mountings_with_short_reliefs_are_solved_together() -> None:
    """Next to short reliefs, contacts are seldom found at given positions over the pinion flank, so that more
    samples are needed. 100 mountings, solved together, take less than 20 times as long as one."""
    short = Modification(
        tip_relief_um=10.0, tip_relief_length_mm=1.0, root_relief_um=10.0, root_relief_length_mm=1.0
    )
    design = replace(table1(), pinion=table1().pinion.modified(short), gear=table1().gear.modified(short))
    batches = [mounted(design, drawn_errors(USUAL, 0, 0, number)) for number in (1, 100)]
    works = [partial(path_of_contact, batch, "right", 17) for batch in batches]
    times = np.min([[best(work, 2, process_time) for work in works] for _ in range(4)], axis=0)
    print(f"\n100 mountings with short reliefs: {times[1] / times[0]:.1f} times one")
    assert times[1] / times[0] < 20.0


def test_undercut_cones_cost_what_sound_ones_cost() -> None:
    """Paths on parallel axes, relative to those of a pair with more teeth and no undercut."""

    def pair(teeth: int) -> Design:
        pinion, gear = (
            Member(Tool(2.0, np.radians(20.0)), number, 0.0, np.radians(cone), 0.0, 20.0)
            for number, cone in ((teeth, 4.0), (40, -4.0))
        )
        return Design(pinion, gear, Pair(teeth + 40.0, 0.0))

    def work(teeth: int) -> float:
        designs = iter([pair(teeth).with_errors(Errors(1e-6 * (k + 1))) for k in range(5)])
        return best(lambda: path_of_contact(next(designs)), 5, process_time)

    work(16)
    ratio = work(16) / min(work(32), work(32))
    print(f"\nundercut over sound: {ratio:.1f}")
    assert ratio < 3.0


def test_off_the_flank_costs_what_others_cost() -> None:
    """Time of a mounting near line contact, with strong parabolas, and of five pairs without backlash,
    relative to mountings of Table 1. Some of these paths leave the flanks, some have a component n_x of
    the common normal below 0.05, and some are not resolved by series over l1 on the complete flank. Each
    ratio compares processor times of consecutive runs, because the machine may have other work."""
    ordinary = mounted(table1(), drawn_errors(USUAL, 0, 0, 1024))
    ratio = {}
    for name, design in {**MOUNTINGS, "parabolas": modified_and_misaligned(16_384)}.items():
        ratios = []
        for _ in range(5):
            base = best(partial(path_of_contact, ordinary, "right", 17), 3, process_time) / 1024
            seconds = best(partial(path_of_contact, design, "right", 17), 1, process_time)
            ratios.append(seconds / design.batch_shape[0] / base)
        ratio[name] = min(ratios)
        print(f"  {name:40s} {1e6 * base * ratio[name]:10.2f} us a case, ratio {ratio[name]:.1f}")
    assert ratio["line contact"] < 3.0
    assert ratio["line contact, ten times the errors"] < 3.0
    assert ratio["parabolas"] < 3.0
    assert all(ratio[name] < 3.0 for name in OFF_THE_FLANKS)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.0002, -0.0002)])
def test_misaligned_pairs_against_five(flank: str, parabola: tuple[float, float]) -> None:
    """One pair under many misalignments, as independent cases. The path of each case between its limits, by
    the one equation, takes less time than one position of each case by the five equations, started from the
    case before."""
    offset = np.linspace(-0.2, 0.2, 20_000)
    cases = table1(parabola, Errors(offset=offset))
    few = slice(0, 20_000, 100)
    at = path_of_contact(cases, flank, l1=[1.0])  # at 0 the differences of `fsolve` fail
    start = np.array((at.l1, at.u1, at.l2, at.u2, at.pinion_roll, at.gear_roll))[:, few, 0]
    pairs = [table1(parabola, Errors(offset=float(error))) for error in offset[few]]
    mounting = (float(mounting_of(pairs[0]).distance[0]), float(mounting_of(pairs[0]).distance[1]))

    def five() -> np.ndarray:
        guess, points = tuple(start[:, 0]), []
        for pair, roll in zip(pairs, start[4], strict=True):
            found = solve_math(pair, flank, [roll], guess, mounting)
            guess = tuple(float(x[0]) for x in (found.l1, found.u1, found.l2, found.u2, [roll], found.phi2))
            points.append(found.point[0])
        return np.array(points)

    times = timed(
        f"{flank} flank, a = {parabola}",
        {
            "one position of each": (partial(path_of_contact, cases, flank, l1=[1.0]), 2, 20_000),
            "contact ratio of each": (partial(contact_ratio, cases, flank), 2, 20_000),
            "five equations, scalar math": (five, 2, len(pairs)),
        },
    )
    ratio = times["five equations, scalar math"] / times["contact ratio of each"]
    print(f"  ratio {ratio:.1f}")
    assert np.abs(five() - at.point[few, 0]).max() < 1e-9
    assert ratio > 1.0
