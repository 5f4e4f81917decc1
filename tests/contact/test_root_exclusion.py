"""Cells of l1 and l2: which cases need no trace, and that no contact is excluded.

The tests count traced cases, not time. The oracle is the trace of all of them.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from numpy.typing import NDArray

from beveloid_geom import Design, Errors, Pair, Status
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.contact import path_search as follow
from beveloid_geom.contact.curves.curve_series import chains_of
from beveloid_geom.contact.curves.curve_tracing import Window
from beveloid_geom.contact.curves.root_exclusion import Box, box_of, window_of
from beveloid_geom.contact.flank_pair import FlankPair, pairing_of
from beveloid_geom.contact.path import path_ends
from beveloid_geom.pair.misalignment import mounted
from tests.oracle.table1 import table1
from tests.stability.answers import changed, closed
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import random_designs


def line_contact() -> Design:
    """Return a pair whose n_x is about 0.03: its lines of action pass each other at 0.002 mm."""
    pinion, gear = (
        replace(member, tool=replace(member.tool, normal_module=4.0)) for member in table1().members
    )
    gear = replace(gear, teeth=31, cone_angle=radians(5.0), helix_angle=radians(-6.64))
    return Design(replace(pinion, teeth=25), gear, Pair(111.6066, radians(20.0)))


def modified_line_contact(size: int) -> Design:
    """Return `line_contact` with parabolas: l1 turns back along many of its paths, none crosses n_x = 0."""
    first, second = np.random.default_rng(3).uniform(-0.001, 0.001, (2, size))
    return line_contact().with_parabola(first, second)


def modified_and_misaligned(size: int, wide: float = 1.0) -> Design:
    """Return Table 1 with random parabolas up to 0.002 1/mm, and errors up to 0.5 mm and 0.02 deg times
    `wide`.
    """
    rng = np.random.default_rng(13)
    first, second = rng.uniform(-0.002, 0.002, (2, size))
    offset, pinion, gear = wide * rng.uniform(-0.5, 0.5, (3, size))
    angle = wide * radians(0.02) * rng.uniform(-1.0, 1.0, size)
    return table1((first, second), Errors(offset, angle, pinion, gear))


def closed_pair(
    module: float,
    teeth: tuple[int, int],
    cones: tuple[float, float],
    helices: tuple[float, float],
    shifts: tuple[float, float],
    face: float,
    alpha: float = 20.0,
) -> Design:
    """Return a pair in its layout without backlash; mm and deg."""
    first, second = (
        changed(
            member,
            **{"normal_module": module, "normal_pressure_angle": radians(alpha), "face_width": face},
            **{
                "teeth": z,
                "cone_angle": radians(cone),
                "helix_angle": radians(helix),
                "profile_shift": shift,
            },
        )
        for member, z, cone, helix, shift in zip(table1().members, teeth, cones, helices, shifts, strict=True)
    )
    return closed(first, second)


OFF_THE_FLANKS = {
    "small, 6.5 and 5 deg": closed_pair(2.0, (26, 40), (6.5, 5.0), (27.7, -4.7), (0.16, 0.31), 10.0),
    "wide, teeth 25 and 66": closed_pair(5.0, (25, 66), (3.3, 3.1), (8.6, 11.5), (-0.15, 0.15), 49.0),
    "pressure angle 25 deg": closed_pair(2.0, (35, 39), (6.3, 3.7), (15.2, 6.1), (0.05, 0.39), 15.0, 25.0),
    "helices opposed": closed_pair(5.0, (31, 44), (2.6, 2.8), (27.8, -16.0), (-0.02, 0.19), 31.0, 17.5),
    "nearly a spur pinion": closed_pair(6.0, (33, 63), (0.2, 7.0), (0.2, 15.9), (-0.15, 0.24), 30.0),
}
"""Pairs without backlash. At usual tolerances, a part of their mountings has paths off the flanks."""


MOUNTINGS = {
    "line contact": mounted(line_contact(), drawn_errors(USUAL, 0, 0, 512)),
    "line contact, ten times the errors": mounted(line_contact(), 10.0 * drawn_errors(USUAL, 0, 0, 512)),
    "line contact, parabolas": modified_line_contact(512),
    "parabolas": modified_and_misaligned(512),
    "parabolas, ten times the errors": modified_and_misaligned(512, 10.0),
    "usual pairs": random_designs("usual", 512, seed=11),
    "layouts that do not fit": random_designs("wild", 512, seed=11),
    **{name: mounted(design, drawn_errors(USUAL, 0, 0, 512)) for name, design in OFF_THE_FLANKS.items()},
}
TRACED_SHARES = {"line contact, parabolas": 0.03, "usual pairs": 0.005}
"""Largest fraction of the cases that may be traced, 0 if not named."""
SEARCHED_SHARE = 0.1
"""Largest fraction that may need more than series over l1 and a few cells."""
TRACED_EVERYWHERE_SHARE = 0.01
"""Largest fraction that may be traced over the entire window."""


@pytest.mark.parametrize("name", MOUNTINGS)
def test_few_are_traced(name: str, flank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    near_faces, all_over, followed = [0], [0], follow._followed

    def counted(pairing: FlankPair, near: Window | None = None) -> list[follow.Group]:
        (all_over if near is None else near_faces).append(pairing.branch.shape[0])
        return followed(pairing, near)

    monkeypatch.setattr(follow, "_followed", counted)
    path_ends(MOUNTINGS[name], flank)
    assert sum(near_faces) <= TRACED_SHARES.get(name, 0.0) * 512
    assert sum(all_over) <= TRACED_EVERYWHERE_SHARE * 512


def test_few_with_parabolas_need_more_than_series_over_l1(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few mountings with parabolas need a search of all curves: a narrower window resolves paths that the
    entire flank does not, and a few cells exclude other contacts. A search takes as long as five ordinary
    cases."""
    near_faces, sought = follow._near_faces, []

    def counted(
        pairing: FlankPair, known: NDArray[np.bool_]
    ) -> tuple[list[follow.Group], NDArray[np.int_], Window]:
        sought.append(pairing.branch.shape[0])
        return near_faces(pairing, known)

    monkeypatch.setattr(follow, "_near_faces", counted)
    path_ends(MOUNTINGS["parabolas"])
    assert 0 < sum(sought) <= SEARCHED_SHARE * 512


@pytest.mark.parametrize("name", MOUNTINGS)
def test_cases_without_a_trace_agree_with_traced_ones(name: str, flank: str) -> None:
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


@pytest.mark.parametrize("name", OFF_THE_FLANKS)
def test_a_usual_share_of_mountings_leaves_the_flanks(name: str) -> None:
    off = path_ends(MOUNTINGS[name]).status == Status.OFF_FLANK
    assert 0.05 < off.mean() < 0.5


def _chain_points(pairing: FlankPair, box: Box) -> list[int]:
    with np.errstate(invalid="ignore", divide="ignore"):
        return [int(count) for count in chains_of(pairing, box).count]


def test_one_curve_is_distinguished_from_several() -> None:
    """The cells of one connected strip count as one curve. They do not if signs split the strip, if the curve
    may end inside, or if a part of the strip is missing."""
    pairing = pairing_of(table1((0.001, -0.001)), "right")
    with np.errstate(invalid="ignore", divide="ignore"):
        box = box_of(pairing, *window_of(pairing), both=False)
    (count,) = _chain_points(pairing, box)
    assert count > 4
    saddle = box.gap.copy()
    saddle[0, 3:5, 3:5] = np.array(((1.0, -1.0), (-1.0, 1.0))) * np.abs(box.gap).max()
    assert _chain_points(pairing, replace(box, gap=saddle, left=np.ones_like(box.left))) == [0]
    assert _chain_points(pairing, replace(box, clear=np.array([False]))) == [0]
    along = np.argwhere(box.left[0])
    cut = box.left.copy()
    cut[0, along[len(along) // 2, 0] - 1 : along[len(along) // 2, 0] + 2] = False  # two pieces
    assert _chain_points(pairing, replace(box, left=cut)) == [0]


def test_cells_contain_the_path(flank: str) -> None:
    """Random layouts, in which most pairs touch: the remaining cells contain the ends of their paths."""
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


def test_a_contact_where_n_x_vanishes_is_not_excluded() -> None:
    """The contact of this pair is found. P and n_x^2 vanish next to each other, so that n F has the other
    sign only on a strip of l1 between the corners of a cell."""
    design = cases_of(random_designs("touching", 400, seed=2017), slice(211, 212))
    assert path_ends(design).status.tolist() == [Status.SOLVED]
