"""Undercut teeth: contours, first contacts and paths compared with independent sampling (`oracle.tooth`)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Tool,
    contact_ratio,
    first_contact,
    mesh_cycle,
    mounted_backlash,
    path_of_contact,
)
from beveloid_geom.arrays import flank_sign
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.tooth_side import angle_of, cut_at, profile_at, surface_of, undercut_edge
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.status import FirstStatus, Limit, Status
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.operation.test_first_contact_by_bisection import coordinate
from tests.oracle.tooth import CutTooth, clearance, least_turn
from tests.stability.answers import closed

ALPHA, MODULE = radians(20.0), 3.0
FACES = {
    "whole face": Member(Tool(MODULE, ALPHA), 12, 0.0, 0.0, 0.0, 20.0),
    "toe only": Member(Tool(MODULE, ALPHA), 16, 0.0, radians(5.0), 0.15, 30.0),
    "heel only": Member(Tool(MODULE, ALPHA), 16, radians(12.0), radians(-5.0), 0.15, 30.0),
    "one flank further": Member(Tool(MODULE, ALPHA), 18, radians(20.0), radians(8.0), 0.1, 30.0),
    "deep": Member(Tool(MODULE, ALPHA, dedendum=1.35, tip_radius=0.1), 9, 0.0, radians(1.0), 0.0, 15.0),
}


@pytest.mark.parametrize("member", FACES.values(), ids=FACES)
def test_contours_of_undercut_teeth(member: Member, flank: str) -> None:
    """Contours of undercut teeth agree with the simulated tool, at radii from root to tip in planes along the
    face, and close to the edge of undercut."""
    surface, tooth = surface_of(member, flank), CutTooth(member, flank_sign(flank))
    assert surface.crossing is not None
    z = surface.half_width * np.linspace(-1.0, 1.0, 9)
    edge = np.sqrt(cut_at(surface, surface.flank_start(z), z).square)
    low, tip = np.sqrt(cut_at(surface, surface.bottom + 0.01 + 0.0 * z, z).square), tooth.tip(z)
    share = np.linspace(0.0, 1.0, 40)[:, None]
    radius = np.concatenate((low + share * (tip - low), edge + np.array([[-1e-3], [-1e-6], [1e-6], [1e-3]])))
    plane = np.broadcast_to(z, radius.shape).ravel()
    with np.errstate(invalid="ignore"):
        s = profile_at(surface, radius.ravel() ** 2, plane)
        angle = angle_of(cut_at(surface, s, plane))
    exact = tooth.angle_at(radius.ravel(), plane)
    assert (np.abs(angle - exact) * radius.ravel()).max() < 1e-9


def random_pairs(
    seed: int, teeth: tuple[int, int], shift: tuple[float, float], error: float
) -> Iterator[Design]:
    """Draw pairs with a member that is undercut somewhere and keeps its flanks."""
    rng = np.random.default_rng(seed)
    while True:
        members = [
            Member(
                Tool(MODULE, ALPHA, 1.0, 1.25, 0.38 if error < 0.1 else rng.uniform(0.0, 0.38)),
                int(rng.integers(*teeth)),
                radians(rng.uniform(-25.0, 25.0)),
                radians(rng.uniform(0.0, 10.0)),
                rng.uniform(*shift),
                MODULE * rng.uniform(8.0, 14.0),
            )
            for _ in range(2)
        ]
        errors = Errors(
            rng.uniform(0.0, 0.3),
            radians(rng.uniform(-error, error)),
            *(20.0 * error * rng.uniform(-1.0, 1.0, 2)),
        )
        surfaces = [surface_of(member, flank) for member in members for flank in ("right", "left")]
        if any(s.lost for s in surfaces) or all(s.crossing is None for s in surfaces):
            continue
        try:
            design = closed(*members)
        except ValueError:
            continue
        yield design.with_errors(errors)


def assert_first(design: Design, flank: str, share: float) -> FirstStatus:
    """Check that no point touches earlier by 1e-6 mm, and that the contact touches."""
    pitches = [2.0 * np.pi / float(member.teeth) for member in design.members]
    roll = float(pitch_point_roll(design, flank)) + share * pitches[0]
    first = first_contact(design, flank, [roll])
    if first.status[0] != FirstStatus.SOLVED:
        return FirstStatus(int(first.status[0]))
    lever, pair = 0.5 * MODULE * design.gear.teeth * np.cos(ALPHA), int(first.pair[0])
    settings = [
        (roll + k * pitches[0], float(first.gear_roll[0]) - k * pitches[1])
        for k in (pair - 1, pair, pair + 1)
    ]
    turns = [least_turn(design, flank, rolls, (121, 25), CutTooth) for rolls in settings]
    assert lever * min(turns) > -1e-6
    w = coordinate(CutTooth(design.pinion, flank_sign(flank)), flank, first.l1)
    touch = clearance(design, flank, w, first.z1, settings[1], CutTooth, 1e-9)
    assert abs(lever * float(touch[0])) < 1e-8
    return FirstStatus.SOLVED


@pytest.mark.parametrize("count", [8, pytest.param(45, marks=pytest.mark.slow)])
def test_first_contacts_of_undercut_members(count: int) -> None:
    """First contacts of usual beveloid pairs agree with independent sampling. A quarter of the pairs is
    undercut somewhere."""
    rng, found = np.random.default_rng(1), []
    for design, _ in zip(random_pairs(7, (17, 46), (0.0, 0.4), 0.05), range(count), strict=False):
        found.append(assert_first(design, ("right", "left")[int(rng.integers(2))], rng.uniform(-0.5, 0.5)))
    assert found.count(FirstStatus.SOLVED) >= 0.9 * count
    assert set(found) <= {FirstStatus.SOLVED, FirstStatus.MEETS_BOTTOM}


@pytest.mark.parametrize("count", [6, pytest.param(30, marks=pytest.mark.slow)])
def test_first_contacts_of_deeply_undercut_and_misaligned_members(count: int) -> None:
    rng, found = np.random.default_rng(2), []
    for design, _ in zip(random_pairs(3, (8, 22), (-0.3, 0.3), 0.3), range(count), strict=False):
        found.append(assert_first(design, ("right", "left")[int(rng.integers(2))], rng.uniform(-0.5, 0.5)))
    assert found.count(FirstStatus.SOLVED) >= 0.6 * count


GEAR = Member(Tool(MODULE, ALPHA), 40, radians(-5.0), radians(2.0), 0.2, 34.0, 0.15)


def test_an_edge_of_undercut_touches_first(flank: str) -> None:
    """The path is shorter than a pitch. Between two paths, edges touch, among them the undercut edge of
    the pinion."""
    pinion = Member(Tool(MODULE, ALPHA), 17, radians(10.0), radians(1.0), -0.8, 20.0)
    gear = Member(Tool(MODULE, ALPHA), 60, radians(-4.0), radians(1.0), 0.6, 24.0)
    design = closed(pinion, gear)
    assert 0.5 < float(contact_ratio(design, flank)) < 1.0
    roll = pitch_point_roll(design, flank) + 2.0 * np.pi / 17.0 * np.linspace(-0.5, 0.5, 120)
    first = first_contact(design, flank, roll)
    assert (first.status == FirstStatus.SOLVED).all()
    edge = np.flatnonzero((first.limit == Limit.PINION_ROOT).any(axis=1))
    assert edge.size > 0
    start = active_start(pinion, flank, first.z1[edge])
    np.testing.assert_allclose(first.l1[edge], start, rtol=0.0, atol=1e-9)
    share = (roll[edge[0]] - pitch_point_roll(design, flank)) / (2.0 * np.pi / 17.0)
    assert assert_first(design, flank, float(share)) == FirstStatus.SOLVED
    cycle = mesh_cycle(design, flank)
    ahead = cycle.at(roll).gear_roll - first.gear_roll
    assert np.abs(ahead).max() < 1e-9


@pytest.mark.parametrize("name", ["toe only", "one flank further", "heel only"])
def test_paths_end_at_the_edge_of_the_flank(name: str, flank: str) -> None:
    """The path agrees with the five equations under errors that move it to the edge."""
    pinion = replace(FACES[name], teeth=11, profile_shift=0.1)
    design = closed(pinion, GEAR)
    path, other = path_of_contact(design, flank, 9), path_of_contact_five_equations(design, flank, 9)
    assert path.ends.status == Status.SOLVED
    assert Limit.PINION_ROOT in path.ends.limit
    np.testing.assert_allclose(path.point, other.point, rtol=0.0, atol=1e-6)
    end = 0 if path.ends.limit[0] == Limit.PINION_ROOT else -1
    assert path.l1[end] == pytest.approx(float(active_start(pinion, flank, path.pinion_z[end])), abs=1e-9)
    beyond = path_of_contact(design, flank, l1=[path.l1[end] + 0.05 * np.sign(path.l1[end] - path.l1[4])])
    assert beyond.status[0] == Status.OFF_FLANK


def test_result_is_continuous_in_the_undercut(flank: str) -> None:
    """The difference from the sound tooth tends to zero with the undercut."""
    sound = closed(Member(Tool(MODULE, ALPHA), 15, radians(15.0), radians(3.0), 0.4, 20.0), GEAR)
    low, high = 0.0, 0.4
    for _ in range(60):  # the profile shift at which the toe begins to be undercut
        middle = 0.5 * (low + high)
        edge = undercut_edge(replace(sound.pinion, profile_shift=middle), flank)
        low, high = (low, middle) if edge is None else (middle, high)
    pair = closed(replace(sound.pinion, profile_shift=high), GEAR).pair
    changes = []
    for change in (1e-2, 1e-4, 1e-6):
        both = [
            replace(sound, pinion=replace(sound.pinion, profile_shift=high + d), pair=pair)
            for d in (-change, 0.0)
        ]
        assert undercut_edge(both[0].pinion, flank) is not None
        ratio = [float(contact_ratio(design, flank)) for design in both]
        roll = pitch_point_roll(both[1], flank) + np.linspace(-0.2, 0.2, 5)
        turned = [first_contact(design, flank, roll).gear_roll for design in both]
        play = [float(mounted_backlash(design).normal) for design in both]
        lost = float(active_start(both[0].pinion, flank, -10.0) - surface_of(both[0].pinion, flank).joint)
        changes.append(
            [abs(ratio[0] - ratio[1]), np.abs(turned[0] - turned[1]).max(), abs(play[0] - play[1]), lost]
        )
        assert changes[-1][-1] > 0.0
    large, middle_, small = np.array(changes)
    assert (middle_ < 0.03 * large).all()
    assert (small < 0.03 * middle_ + 1e-8).all()
