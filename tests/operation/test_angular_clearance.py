"""Angular clearance compared with true distances to the mating flank."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from scipy.optimize import root

from beveloid_geom import Design, Errors, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_patch, flank_point, trace_parameter
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.gear.tooth_side import (
    cut_at,
    profile_at,
    surface_of,
)
from beveloid_geom.operation.angular_clearance import AngularClearance, angular_clearance
from beveloid_geom.pair.frames import layout_of, member_frame
from beveloid_geom.pair.mounting import mounting_of
from tests.oracle.table1 import table1

PARABOLAS = [(0.0, 0.0), (0.001, -0.001), (-0.004, 0.004)]


def frames(design: Design, rolls: tuple[float, float]) -> list[tuple[FloatArray, FloatArray]]:
    layout, distance = layout_of(design), mounting_of(design).distance
    axial = (design.errors.pinion_axial, design.errors.gear_axial)
    return [member_frame(layout, j, rolls[j], distance[j] + axial[j]) for j in (0, 1)]


def foot_distance(
    design: Design, flank: str, member: int, place: tuple[float, ...], rolls: tuple[float, ...]
) -> float:
    """Return the distance (mm) of a flank point from the mate's flank, positive outside: at the foot, the
    difference is perpendicular to both tangents."""
    own, other = design.members[member], design.members[1 - member]
    (l, z, start_l, start_z), pose = place, frames(design, (rolls[0], rolls[1]))
    point = pose[member][0] @ flank_point(own, flank, l, z=z) + pose[member][1]
    point = pose[1 - member][0].T @ (point - pose[1 - member][1])

    def residual(x: FloatArray) -> list[float]:
        patch = flank_patch(other, flank, x[0], x[1])
        apart = point - patch.point
        return [float(apart @ patch.tangent_l), float(apart @ patch.tangent_u)]

    start = (start_l, float(trace_parameter(other, flank, start_l, start_z)))
    foot = root(residual, start, tol=1e-12).x
    patch = flank_patch(other, flank, foot[0], foot[1])
    return float((point - patch.point) @ patch.normal)


def places(design: Design, flank: str, member: int, count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Draw random flank points of a member in the middle of its face."""
    rng, own = np.random.default_rng(seed), surface_of(design.members[member], flank)
    return rng.uniform(0.7 * own.joint, 0.7 * own.highest, count), rng.uniform(
        -0.7, 0.7, count
    ) * own.half_width


@pytest.mark.parametrize("parabola", PARABOLAS)
def test_path_of_contact_has_no_gap(parabola: tuple[float, float], flank: str) -> None:
    design = table1(parabola, Errors(0.02, radians(0.002), 0.1, -0.1))
    path = path_of_contact(design, flank, 31)
    sides = ((path.l1, path.pinion_z), (path.l2, path.gear_z))
    for member in (0, 1):
        met = angular_clearance(design, flank, member, *sides[member], path.pinion_roll, path.gear_roll)
        assert np.abs(met.angle).max() < 1e-13
        other_l, other_z = sides[1 - member]
        assert np.abs(met.other_l - other_l).max() < 1e-10
        assert np.abs(met.other_z - other_z).max() < 1e-10
        assert met.inside.all()


@pytest.mark.parametrize("member", [0, 1])
def test_distance_is_exact_without_parabola(flank: str, member: int) -> None:
    """The distance agrees with the foot point, also for gaps of a third of a millimetre and for overlap."""
    design = table1((0.0, 0.0), Errors(0.05, radians(0.01), 0.1, 0.2))
    path = path_of_contact(table1(), flank, 3)
    l, z = places(design, flank, member, 12, seed=4)
    for shift in (0.0, 2e-3, -2e-3):
        rolls = float(path.pinion_roll[1]), float(path.gear_roll[1]) + shift
        met = angular_clearance(design, flank, member, l, z, *rolls)
        seen = np.flatnonzero(met.other_l > surface_of(design.members[1 - member], flank).joint + 0.5)
        assert seen.size > 5
        for k in seen:
            near = (l[k], z[k], met.other_l[k], met.other_z[k])
            assert abs(foot_distance(design, flank, member, near, rolls) - met.distance[k]) < 1e-9
    assert np.abs(met.distance[seen]).max() > 0.2


@pytest.mark.parametrize("member", [0, 1])
def test_distance_with_parabola_is_right_to_first_order(member: int) -> None:
    """The error decreases with the square of the gap."""
    design, flank = table1((0.002, -0.002)), "right"
    path = path_of_contact(design, flank, 3)
    l, z = float((path.l1, path.l2)[member][1]), float((path.pinion_z, path.gear_z)[member][1])
    errors = []
    for shift in (4e-4, 2e-4, 1e-4):
        rolls = float(path.pinion_roll[1]), float(path.gear_roll[1]) + shift
        met = angular_clearance(design, flank, member, l, z, *rolls)
        place = (l, z, float(met.other_l), float(met.other_z))
        errors.append(abs(foot_distance(design, flank, member, place, rolls) - float(met.distance)))
    assert errors[0] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def turned_to_touch(
    design: Design, flank: str, met: AngularClearance, rolls: tuple[float, float]
) -> AngularClearance:
    """Return the clearance, from the pinion, of the touched points of the gear after the gear has rotated
    until they touch."""
    gear_roll = rolls[1] + surface_of(design.gear, flank).sigma * met.angle
    return angular_clearance(design, flank, 1, met.other_l, met.other_z, rolls[0], gear_roll)


@pytest.mark.parametrize("parabola", PARABOLAS)
def test_both_members_agree_where_they_meet(parabola: tuple[float, float], flank: str) -> None:
    """The clearance of the touched points from the pinion is zero, also on fillets."""
    design = table1(parabola, Errors(-0.8))
    path = path_of_contact(table1(parabola), flank, 3)
    rolls = float(path.pinion_roll[1]), float(path.gear_roll[1])
    own = surface_of(design.pinion, flank)
    l, z = np.meshgrid(np.linspace(own.bottom + 0.3, own.highest, 30), np.linspace(-20.0, 20.0, 7))
    met = angular_clearance(design, flank, 0, l, z, *rolls)
    back = turned_to_touch(design, flank, met, rolls)
    seen = ~np.isnan(met.angle)
    assert seen.mean() > 0.7
    assert (met.other_l[seen] < surface_of(design.gear, flank).joint).any()
    assert np.abs(back.angle[seen]).max() < 1e-10
    assert np.abs((back.other_l - l)[seen]).max() < 1e-8
    assert np.abs((back.other_z - z)[seen]).max() < 1e-10


def test_pairs_are_turned_by_pitches() -> None:
    design = table1((0.001, -0.001))
    l, z = places(design, "right", 0, 20, seed=2)
    shifted = angular_clearance(design, "right", 0, l, z, 0.1, -0.1, pair=np.array([[-1], [0], [2]]))
    for row, pair in enumerate((-1, 0, 2)):
        turned = angular_clearance(
            design, "right", 0, l, z, 0.1 + pair * 2.0 * np.pi / 29, -0.1 - pair * 2.0 * np.pi / 45
        )
        assert np.allclose(shifted.distance[row], turned.distance, atol=1e-12, equal_nan=True)


def test_inside_ends_at_the_limits() -> None:
    """Points of the gear that are just inside its limits are recognised as inside, and points just outside as
    outside."""
    design, flank = table1(), "right"
    path = path_of_contact(design, flank, 3)
    gear, rolls = surface_of(design.gear, flank), (float(path.pinion_roll[1]), float(path.gear_roll[1]))
    z = np.array([-gear.half_width, 0.0, gear.half_width, 0.0])
    l = np.array([1.0, float(tip_parameter(design.gear, flank, 0.0)), 1.0, gear.joint - 0.5])
    for step, expected in ((1e-6, [False, False, False, True]), (-1e-6, [True, True, True, True])):
        met = angular_clearance(
            design, flank, 1, l + step * np.array([0, 1, 0, 0]), z + step * np.array([-1, 0, 1, 0]), *rolls
        )
        pinion_roll = rolls[0] + gear.sigma * met.angle
        back = angular_clearance(design, flank, 0, met.other_l, met.other_z, pinion_roll, rolls[1])
        seen = ~np.isnan(met.angle)
        assert seen.sum() >= 2
        assert np.array_equal(back.inside[seen], np.array(expected)[seen])


def test_no_point_of_the_mate() -> None:
    """A point of the pinion below the root of the gear has no point to touch: the clearance is NaN."""
    design = table1(errors=Errors(-8.0))
    surface = surface_of(design.pinion, "right")
    met = angular_clearance(design, "right", 0, surface.highest, 0.0, 0.18, -0.11)
    assert np.isnan(met.angle)
    assert not met.inside


def test_arrays_of_members_raise() -> None:
    design = table1().with_parabola(pinion=np.array([0.0, 0.001]))
    with pytest.raises(ValueError, match="members must have single numbers"):
        angular_clearance(design, "right", 0, 0.0, 0.0, 0.0, 0.0)


def test_fillet_of_a_sharp_tool() -> None:
    """The corner of the tool cuts the fillet, with a coordinate that is a tenth of a module long."""
    design = table1()
    sharp = replace(design.gear, tool=replace(design.gear.tool, tip_radius=0.0))
    surface = surface_of(sharp, "right")
    assert surface.scale == pytest.approx(0.6)
    s = np.linspace(surface.bottom, surface.joint, 30)[3:]
    square = cut_at(surface, s, 0.0 * s).square
    assert np.all(np.diff(square) > 0.0)
    assert np.abs(profile_at(surface, square, 0.0 * s) - s).max() < 1e-9
