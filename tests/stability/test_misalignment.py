"""Misalignment that moves the path off the face: of both members, of one only, and in segments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Status,
    contact_ratio,
    mesh_cycle,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.contact.flank_pair import pairing_of
from beveloid_geom.contact.path import path_ends
from beveloid_geom.status import Limit
from tests.contact.test_path import five_equation_residual
from tests.oracle.table1 import table1
from tests.stability.five_residuals import margins

from .named_designs import SPLIT, Named

OFF = (
    Errors(offset=20.0),
    Errors(offset=1.3),
    Errors(offset=-1.3),
    Errors(shaft_angle=np.radians(0.05)),
    Errors(shaft_angle=np.radians(-0.05)),
    Errors(pinion_axial=60.0),
    Errors(gear_axial=-70.0),
)


@pytest.mark.parametrize("errors", OFF)
def test_off_the_face(errors: Errors) -> None:
    """There is no path, the status is OFF_FLANK, and the contact ratio is 0. Single contacts satisfy the
    equations and have the same status; contacts that are further away than the depth of a flank have no
    values."""
    design = table1(errors=errors)
    path = path_of_contact(design)
    assert path.ends.status == Status.OFF_FLANK
    assert path.ends.contact_ratio == contact_ratio(design) == 0.0
    assert path.ends.pieces == 0
    assert path.l1.size == path.point.size == 0
    assert (path.ends.limit == -1).all()
    assert np.isnan((*path.ends.l1, *path.ends.l2, *path.ends.pinion_roll)).all()
    at = path_of_contact(design, l1=np.linspace(-6.0, 6.0, 13))
    assert (at.status == Status.OFF_FLANK).all()
    found = np.isfinite(at.l2)
    assert found.sum() > 9
    assert np.isnan(at.point[~found]).all()
    at = path_of_contact(design, l1=at.l1[found])
    assert five_equation_residual(design, at) < 1e-9
    assert margins(design, at).min(axis=0).max() < 0.0
    assert path_certificate(path).verdict.size == 0


def test_the_cycle_without_a_path() -> None:
    cycle = mesh_cycle(table1(errors=Errors(offset=1.3)), "right", 3)
    assert not cycle.lost
    assert cycle.edge_share == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("where", ["pinion", "gear"])
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_off_one_member_only(flank: str, way: float, where: str) -> None:
    """A member is moved along its axis: the path keeps its place and leaves the face of this member only,
    first at the named end, then completely."""
    amount = {"pinion": {"pinion_axial": 1.0}, "gear": {"gear_axial": 1.0}}[where]
    end = "toe" if way > 0.0 else "heel"
    named = Limit[f"{where}_{end}".upper()]
    partly, wholly = (
        table1(errors=Errors(**dict.fromkeys(amount, way * mm)))
        for mm in (24.0 if where == "pinion" else 29.0, 60.0)
    )
    ends = path_ends(partly, flank)
    assert ends.status == Status.SOLVED
    assert named in (ends.enter, ends.leave)
    assert 0.0 < ends.contact_ratio < contact_ratio(table1(), flank)
    assert path_ends(wholly, flank).status == Status.OFF_FLANK
    at = path_of_contact(wholly, flank, l1=np.linspace(-4.0, 4.0, 9))
    inside = margins(wholly, at)
    assert (inside.argmin(axis=0) == named).all()
    others = [limit for limit in Limit if limit.member != where and limit.limit in ("toe", "heel")]
    assert (inside[others] > 0.0).all()


def test_the_ratio_falls_to_zero_without_a_step() -> None:
    """The contact ratio decreases to zero without a step over the last 0.04 mm of offset, until the path
    reaches the corner of heel and tip of the pinion."""
    offset = np.array([*np.linspace(1.2, 1.239, 40), 1.2399, 1.2402])
    ends = path_ends(table1(errors=Errors(offset=offset)))
    ratio = ends.contact_ratio
    assert (np.diff(ratio) <= 0.0).all()
    assert np.abs(np.diff(ratio)).max() < 0.01
    assert ratio[0] > 0.1
    assert ratio[-1] == 0.0 < ratio[-2] < 1e-3
    assert (ends.status[:-1] == Status.SOLVED).all()
    assert ends.status[-1] == Status.OFF_FLANK
    assert (ends.limit[:-1] == (Limit.PINION_HEEL, Limit.PINION_TIP)).all()


def runs_on_flanks(design: Design, flank: str) -> list[tuple[float, float]]:
    """Return the segments from counted samples: first and last l1 of each, and all positions solved one by
    one."""
    pairing = pairing_of(design, flank)
    l1 = np.linspace(float(pairing.lowest[0, 0, 0]), float(pairing.highest[0, 0, 0]), 4001)
    path = path_of_contact(design, flank, l1=l1)
    inside = (path.status == Status.SOLVED) & (margins(design, path).min(axis=0) >= 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0]))))
    return [(float(l1[i]), float(l1[j - 1])) for i, j in edges.reshape(-1, 2)]


@pytest.mark.parametrize("case", SPLIT, ids=lambda case: "-".join(str(end) for end in case.ends))
def test_two_segments(case: Named) -> None:
    """The number of segments equals that of the samples; the one with the largest range of roll is used,
    to its exact ends."""
    design = case.design
    ends = path_ends(design, case.flank)
    assert ends.status == Status.SOLVED
    assert ends.pieces == 2
    assert {ends.enter, ends.leave} == set(case.ends)
    path = path_of_contact(design, case.flank, 2001)
    assert (path.status == Status.SOLVED).all()
    assert five_equation_residual(design, path) < 1e-9
    inside = margins(design, path)
    assert inside.min() > -1e-9
    assert np.abs(inside.min(axis=0)[[0, -1]]).max() < 1e-9
    sampled = runs_on_flanks(design, case.flank)
    step = float(np.ptp([*sampled[0], *sampled[-1]])) / 1000.0
    taken = np.sort(ends.l1)
    if len(sampled) == 2:
        ways = (np.linspace(first, last, 201) for first, last in sampled)
        spans = [float(np.ptp(path_of_contact(design, case.flank, l1=way).pinion_roll)) for way in ways]
        longest = sampled[int(np.argmax(spans))]
        assert np.abs(np.array(longest) - taken).max() < 20.0 * step
    else:  # they are closer to each other than the samples, or one is shorter than their distance
        assert sampled[0][0] - step < taken[0] < taken[1] < sampled[-1][1] + step


def test_the_longest_segment_changes_continuously() -> None:
    """As the face of the first case becomes narrower, one segment becomes two. The ratio of the longest
    segment may have a step there, from the complete path to the larger part, and nowhere else."""
    faces = np.linspace(4.36, 4.38, 41)
    design = table1((-0.003, 0.005))
    design = replace(design, pinion=replace(design.pinion, face_width=faces))
    ends = path_ends(design, "left")
    assert (ends.status == Status.SOLVED).all()
    assert set(ends.pieces.tolist()) == {1, 2}
    steps = np.abs(np.diff(ends.contact_ratio))
    change = np.diff(ends.pieces) != 0
    assert change.sum() == 1
    assert steps[~change].max() < 0.02
    assert steps[change].min() > 0.05


def test_statuses_in_a_batch() -> None:
    """A batch with cases on the face, off the face and without a common normal has the status of each, and
    NaN where there is no result."""
    angle = np.radians([0.0, 0.05, -1.0])
    path = path_of_contact(table1((0.001, -0.001), Errors(shaft_angle=angle)), points=5)
    assert path.ends.status.tolist() == [Status.SOLVED, Status.OFF_FLANK, Status.NO_COMMON_NORMAL]
    assert path.ends.contact_ratio[0] > 1.0
    assert (path.ends.contact_ratio[1:] == 0.0).all()
    assert np.isnan(path.point[1:]).all()
    assert (path.status[1:] == path.ends.status[1:, None]).all()
