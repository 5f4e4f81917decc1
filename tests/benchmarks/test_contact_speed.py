"""Speed of the contact solve, as ratios in one run on the same work.

    python -m pytest tests/benchmarks -m benchmark -s

The reference is the paper's five equations through `scipy.optimize.fsolve`, xtol 1e-14, each
position started from the one before, written in scalar floats with every constant
hoisted, one square root, one sine and cosine per member and evaluation (about 20 evaluations
a position). The one equation gives the full result (every field of `ContactPath`); what depends
on the members alone, the mounting too, is known from an earlier call.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from beveloid_geom import Errors, contact_ratio, path_of_contact
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.pair.errors import mounted
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.reference.five_equations_math import solve_math
from tests.benchmarks.timing import best, told
from tests.contact.test_cells import MOUNTINGS, OFF_THE_FLANKS, bent_and_strained
from tests.oracle.sixty_digits import numbers_of
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_one_equation_against_five(flank: str, parabola: tuple[float, float]) -> None:
    design, l1 = table1(parabola), np.linspace(-5.0, 5.0, 100_000)
    path, mounting = path_of_contact(design, flank, 1_001), mounting_of(design).distance
    known = numbers_of(path, 0), (float(mounting[0]), float(mounting[1]))
    five = partial(solve_math, design, flank, path.pinion_roll, *known)
    paths = {n: partial(path_of_contact, design, flank, n) for n in (101, 1_000, 100_000)}
    cost = told(
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


def test_off_the_flank_costs_what_others_cost() -> None:
    """Mountings of Table 1 against those near line contact, with strong parabolas, and of five pairs without
    backlash: where paths leave the flanks, n_x comes under 0.05, or l1 does not resolve them over the whole
    flank. Ratios are those of runs one beside the other, since the machine may have other work."""
    ordinary = mounted(table1(), drawn_errors(USUAL, 0, 0, 1024))
    ratio = {}
    for name, design in {**MOUNTINGS, "parabolas": bent_and_strained(16_384)}.items():
        ratios = []
        for _ in range(5):
            base = best(partial(path_of_contact, ordinary, "right", 17), 2) / 1024
            ratios.append(
                best(partial(path_of_contact, design, "right", 17), 1) / design.batch_shape[0] / base
            )
        ratio[name] = min(ratios)
        print(f"  {name:40s} {1e6 * base * ratio[name]:10.2f} us a case, ratio {ratio[name]:.1f}")
    assert ratio["line contact"] < 3.0
    assert ratio["line contact, ten times the errors"] < 3.0
    assert ratio["parabolas"] < 3.0
    assert all(ratio[name] < 3.0 for name in OFF_THE_FLANKS)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.0002, -0.0002)])
def test_misaligned_pairs_against_five(flank: str, parabola: tuple[float, float]) -> None:
    """Independent cases: one pair under many misalignments. The path of each from limit to limit, by the one
    equation, costs less than one position of each by the five, started from the case before."""
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

    times = told(
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
