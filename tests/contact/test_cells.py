"""Cells of l1 and l2: which cases they spare the walk, and that they leave nothing out.

What is counted is the cases that are walked, not time. The oracle is the walk of all of them.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Pair, Status
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors, mounted
from beveloid_geom.contact import path_search as follow
from beveloid_geom.contact.cells import box_of, window_of
from beveloid_geom.contact.curve_tracing import Window
from beveloid_geom.contact.equation import Pairing, pairing_of
from beveloid_geom.contact.path import path_ends
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import random_designs


def line_contact() -> Design:
    """A pair whose n_x is about 0.03: its lines of action pass 0.002 mm apart."""
    pinion, gear = (
        replace(member, tool=replace(member.tool, normal_module=4.0)) for member in table1().members
    )
    gear = replace(gear, teeth=31, cone_angle=radians(5.0), helix_angle=radians(-6.64))
    return Design(replace(pinion, teeth=25), gear, Pair(111.6066, radians(20.0)))


def bent_line_contact(size: int) -> Design:
    """The same with parabolas: l1 turns back along many of its paths, none crosses n_x = 0."""
    first, second = np.random.default_rng(3).uniform(-0.001, 0.001, (2, size))
    return line_contact().with_parabola(first, second)


def bent_and_strained(size: int, wide: float = 1.0) -> Design:
    """Table 1 with random parabolas up to 0.002 1/mm, and errors up to 0.5 mm and 0.02 deg times `wide`."""
    rng = np.random.default_rng(13)
    first, second = rng.uniform(-0.002, 0.002, (2, size))
    offset, pinion, gear = wide * rng.uniform(-0.5, 0.5, (3, size))
    angle = wide * radians(0.02) * rng.uniform(-1.0, 1.0, size)
    return table1((first, second), Errors(offset, angle, pinion, gear))


MOUNTINGS = {
    "line contact": mounted(line_contact(), drawn_errors(USUAL, 0, 0, 512)),
    "line contact, ten times the errors": mounted(line_contact(), 10.0 * drawn_errors(USUAL, 0, 0, 512)),
    "line contact, parabolas": bent_line_contact(512),
    "parabolas": bent_and_strained(512),
    "parabolas, ten times the errors": bent_and_strained(512, 10.0),
    "usual pairs": random_designs("usual", 512, seed=11),
    "layouts that do not fit": random_designs("wild", 512, seed=11),
}
MOST = {
    "line contact, parabolas": 0.6,
    "parabolas": 0.01,
    "parabolas, ten times the errors": 0.05,
    "usual pairs": 0.01,
}
"""Share of the cases that may be walked, 0 if not named."""
MOST_ALL_OVER = 0.01
"""Share that may be walked beyond what is near the faces."""


@pytest.mark.parametrize("flank", ["right", "left"])
@pytest.mark.parametrize("name", MOUNTINGS)
def test_few_are_walked(name: str, flank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    near_faces, all_over, followed = [0], [0], follow._followed

    def counted(pairing: Pairing, near: Window | None = None) -> list[follow.Group]:
        (all_over if near is None else near_faces).append(pairing.branch.shape[0])
        return followed(pairing, near)

    monkeypatch.setattr(follow, "_followed", counted)
    path_ends(MOUNTINGS[name], flank)
    assert sum(near_faces) <= MOST.get(name, 0.0) * 512
    assert sum(all_over) <= MOST_ALL_OVER * 512


@pytest.mark.parametrize("flank", ["right", "left"])
@pytest.mark.parametrize("name", MOUNTINGS)
def test_those_spared_are_as_walked(name: str, flank: str) -> None:
    design = cases_of(MOUNTINGS[name], slice(0, 32))
    pairing, ends = pairing_of(design, flank), path_ends(design, flank)
    with np.errstate(invalid="ignore", divide="ignore"):
        groups = follow._followed(pairing)
    for group in groups:
        for k, case in enumerate(group.cases):
            assert ends.status[case] == group.ends.status[k]
            if ends.status[case] == Status.SOLVED:
                np.testing.assert_allclose(ends.l1[case], group.ends.l[0, k], atol=1e-9)
                assert ends.limit[case].tolist() == group.ends.limit[k].tolist()


@pytest.mark.parametrize("flank", ["right", "left"])
def test_cells_hold_the_path(flank: str) -> None:
    """Laid together at random, so that most pairs touch: what is left holds their ends."""
    design = random_designs("touching", 64, seed=5, flank="right" if flank == "right" else "left")
    pairing, ends = pairing_of(design, flank), path_ends(design, flank)
    solved = np.flatnonzero(ends.status == Status.SOLVED)
    assert solved.size > 40
    with np.errstate(invalid="ignore", divide="ignore"):
        low, high = window_of(pairing)
        for _ in range(3):
            box = box_of(pairing, low, high)
            low, high = box.low, box.high
            assert not box.none[solved].any()
            for l, least, most in zip((ends.l1, ends.l2), low, high, strict=True):
                assert (l[solved] >= least[solved]).all()
                assert (l[solved] <= most[solved]).all()
