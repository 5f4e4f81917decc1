"""First contact by bisection, with flanks and fillets computed from the section of the tool."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    first_contact,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.operation.certificate import OVERLAP_TOLERANCE_MODULES
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.status import FirstStatus, Limit, Verdict
from tests.operation.test_first_contact import EDGES
from tests.oracle.table1 import table1
from tests.oracle.tooth import Tooth, clearance
from tests.stability.answers import changed, closed
from tests.stability.five_residuals import cases_of
from tests.stability.named_designs import HARD, Named
from tests.stability.random_designs import random_designs

BOTH = ("right", "left")
CLOSE = {(0.0, 0.0): -1.2, (0.003, -0.003): -0.9, (0.005, 0.003): -0.9}
"""Parabolas and offset errors for which tips touch fillets."""


def coordinate(tooth: Tooth, flank: str, s: FloatArray) -> FloatArray:
    """Return w of a profile coordinate of the package."""
    surface = surface_of(tooth.member, flank)
    below = (s - surface.bottom) / (surface.joint - surface.bottom)
    return np.where(s < surface.joint, below, 1.0 + s - surface.joint)


def deep_design() -> Design:
    """Return Table 1 with teeth so high that tips reach into fillets."""
    return closed(*(changed(member, addendum=1.2) for member in table1().members))


CASES = {
    "unmodified": table1(),
    "its toe": table1((0.0, 0.0), Errors(shaft_angle=radians(0.1))),
    "offset": table1((0.001, -0.001), Errors(0.3)),
    "nearer": table1((0.001, -0.001), Errors(-0.3, pinion_axial=1.0)),
    "concave": table1((0.0002, 0.0002)),
    "concave, turned": table1((0.0002, 0.0002), Errors(shaft_angle=radians(-0.1))),
    "convex": table1((-0.0005, -0.0005), Errors(gear_axial=-1.0)),
    "deep": deep_design(),
    **EDGES,
    **{f"tip on a fillet, {a}": table1(a, Errors(e)) for a, e in CLOSE.items()},
}


def off_edge(tooth: Tooth, flank: str, limit: Limit, l: FloatArray, z: FloatArray) -> float:
    """Return the distance (mm) of a flank point from the reported edge."""
    if limit.limit == "tip":
        return float(abs(tooth.radius(coordinate(tooth, flank, l), z) - tooth.tip(z))[0])
    half = 0.5 * float(tooth.member.face_width)
    return abs(float(z[0]) - (half if limit.limit == "heel" else -half))


def assert_first(design: Design, flank: str, roll: FloatArray, rows: tuple[int, int, int]) -> float:
    """Check that the contact touches, on the reported edges, and that no point of the pinion touches earlier,
    on a grid with `rows` points along fillet, flank and face. Return the largest minimum clearance."""
    first = first_contact(design, flank, roll)
    assert (first.status == FirstStatus.SOLVED).all()
    pinion, gear = (Tooth(member, 1.0 if flank == "right" else -1.0) for member in design.members)
    places = (first.l1, first.z1), (first.l2, first.z2)
    pitch = [2.0 * np.pi / float(member.teeth) for member in design.members]
    z = 0.5 * float(design.pinion.face_width) * np.linspace(-1.0, 1.0, rows[2])
    top = pinion.profile(pinion.tip(z), z)
    low, share = np.linspace(0.02, 0.999, rows[0])[:, None] + 0.0 * z, np.linspace(0.0, 1.0, rows[1])[:, None]
    w = np.concatenate((low, 1.0 + share * (top - 1.0)))
    least = []
    for k, at in enumerate(first.pair.tolist()):
        own = coordinate(pinion, flank, first.l1[k : k + 1])
        turned = [
            (float(roll[k]) + pair * pitch[0], float(first.gear_roll[k]) - pair * pitch[1])
            for pair in range(at - 1, at + 2)
        ]
        assert abs(float(clearance(design, flank, own, first.z1[k : k + 1], turned[1])[0])) < 1e-11
        for limit in [Limit(code) for code in first.limit[k].tolist() if code >= 0]:
            l, z_edge = (values[k : k + 1] for values in places[limit % 2])
            assert off_edge((pinion, gear)[limit % 2], flank, limit, l, z_edge) < 1e-8
        least.append(min(clearance(design, flank, w, z + 0.0 * w, rolls).min() for rolls in turned))
    assert min(least) > -1e-12
    return float(max(least))


@pytest.mark.parametrize("name", CASES)
def test_first_contact_by_bisection(name: str, flank: str) -> None:
    design, rng = CASES[name], np.random.default_rng(len(name))
    roll = 2.0 * np.pi / float(design.pinion.teeth) * rng.uniform(0.0, 1.0, 2)
    assert assert_first(design, flank, pitch_point_roll(design, flank) + roll, (8, 30, 25)) < 3e-3


@pytest.mark.parametrize("case", HARD.values(), ids=HARD)
def test_contacts_between_coarse_scan_points(case: Named) -> None:
    assert_first(case.design, case.flank, np.array([case.roll]), (60, 80, 41))


def test_slight_overlap_is_not_certified() -> None:
    """Nearly unmodified flanks are not certified where the next pair is earlier by less than a micrometre."""
    design = table1((-1e-5, -1e-5))
    proof = path_certificate(path_of_contact(design, "left", 31))
    slight = (proof.separation < -OVERLAP_TOLERANCE_MODULES) & (proof.separation > -6e-4)
    assert slight.sum() > 10
    assert (proof.verdict[slight] == Verdict.NEXT_PAIR).all()


def test_last_entering_pair_is_reported(flank: str) -> None:
    """The pinion drives: the entering pair touches at the root of the pinion, the other one at its tip."""
    design, pitch = table1(), 2.0 * np.pi / 29.0
    path = path_of_contact(design, flank, 41)
    sign = 1.0 if flank == "right" else -1.0
    since = np.abs(path.pinion_roll - path.pinion_roll[0]) / pitch
    together = since > 1.05
    first = first_contact(design, flank, path.pinion_roll)
    assert together.sum() > 10
    assert (first.pair[together] == -sign).all()
    assert (first.l1[together] < path.l1[together] - 3.0).all()
    assert (first.pair[(since > 0.01) & (since < 0.95)] == 0).all()


@pytest.mark.slow
def test_random_pairs_by_bisection() -> None:
    """Random usual pairs, on both members. Undercut members are tested in
    `test_first_contact_of_undercut_teeth`, since the teeth here are not cut at the intersection of
    flank and fillet."""
    designs, counts = random_designs("usual", 100, seed=2017), dict.fromkeys(FirstStatus, 0)
    for number in range(100):
        design: Design = cases_of(designs, number)
        flank, share = BOTH[number % 2], np.random.default_rng(number).uniform(-0.5, 0.5, 1)
        try:
            roll = pitch_point_roll(design, flank) + 2.0 * np.pi / float(design.pinion.teeth) * share
        except ValueError:  # the tool's rounds overlap: no fillet
            continue
        first = first_contact(design, flank, roll)
        counts[FirstStatus(int(first.status[0]))] += 1
        sound = all(surface_of(member, flank).crossing is None for member in design.members)
        if sound and first.status[0] == FirstStatus.SOLVED:
            assert_first(design, flank, roll, (8, 30, 25))
            met = angular_clearance(design, flank, 0, first.l1, first.z1, roll, first.gear_roll, first.pair)
            assert met.inside.all()
            assert abs(float(met.other_l[0] - first.l2[0])) < 1e-7
    print(counts)
    assert counts[FirstStatus.SOLVED] > 50
    assert counts[FirstStatus.NOT_CONVERGED] == counts[FirstStatus.NO_CONTACT] == 0
