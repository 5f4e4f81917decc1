"""Cone and helix angles near, at and through 0."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Pair,
    Status,
    gear_solid,
    sample_flank,
    zero_backlash_layout,
)
from beveloid_geom.contact.path import path_ends
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.pair.mounting import mounting_of
from tests.oracle.table1 import table1

from .answers import (
    FLANKS,
    changed,
    closed,
    held,
    solved_path,
)

PINION, GEAR = table1().members
PLAIN = held(closed(changed(PINION, cone_angle=0.0), changed(GEAR, cone_angle=0.0)))
"""Table 1 without cone angles: crossed helical gears."""
TINY = [sign * size for size in (1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-16) for sign in (1.0, -1.0)]
"""deg"""


def with_cones(design: Design, pinion: float, gear: float) -> Design:
    """Return the design with cone angles in deg."""
    return replace(
        design,
        pinion=changed(design.pinion, cone_angle=radians(pinion)),
        gear=changed(design.gear, cone_angle=radians(gear)),
    )


def assert_near(path: ContactPath, zero: ContactPath, angle: float, slope: float) -> None:
    """Check that points lie within `slope` (mm/rad) times `angle` (deg) of those at 0, plus rounding."""
    bound = slope * abs(radians(angle)) + 2e-11
    assert np.abs(path.point - zero.point).max() < bound
    assert np.abs(path.gear_roll - zero.gear_roll).max() < bound / 50.0
    assert abs(path.ends.contact_ratio - zero.ends.contact_ratio) < bound / 50.0
    assert path.ends.enter == zero.ends.enter
    assert path.ends.leave == zero.ends.leave


@pytest.mark.parametrize("ratio", [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (1.0, -1.0)])
def test_cone_angles_through_zero_are_continuous(ratio: tuple[float, float], flank: str) -> None:
    zero = solved_path(PLAIN, flank)
    for angle in TINY:
        path = solved_path(with_cones(PLAIN, ratio[0] * angle, ratio[1] * angle), flank)
        assert_near(path, zero, angle, 3e4)


def test_mounting_distances_vanish_with_the_cone_angles() -> None:
    """Mounting distances are proportional to the cone angles, with the relative accuracy of the helix angles:
    no term divides by a cone angle."""
    per_degree = mounting_of(closed(*with_cones(PLAIN, 1e-4, 1e-4).members)).distance / 1e-4
    for angle in TINY:
        pair = replace(PLAIN.pair, pinion_mounting=None, gear_mounting=None)
        design = replace(with_cones(PLAIN, angle, angle), pair=pair)
        np.testing.assert_allclose(mounting_of(design).distance, per_degree * angle, rtol=1e-3, atol=1e-10)
        assert abs(zero_backlash_layout(design).offset - PLAIN.pair.offset) < abs(angle) * 10.0 + 1e-10


def test_samples_and_solids_are_continuous_at_zero() -> None:
    zero = sample_flank(PLAIN.pinion, "right", 0.01)
    solid = gear_solid(PLAIN.pinion, 0.1, teeth=1)
    for angle in (1e-16, -1e-13):
        tilted = changed(PLAIN.pinion, cone_angle=radians(angle))
        np.testing.assert_allclose(
            sample_flank(tilted, "right", 0.01).points, zero.points, rtol=0.0, atol=1e-11
        )
        points = gear_solid(tilted, 0.1, teeth=1).points
        np.testing.assert_allclose(points, solid.points, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("helix", [0.0, 25.0])
@pytest.mark.parametrize("cones", [(0.0, 0.0), (3.0, 0.8)])
def test_helix_angles_that_cancel_do_not_cross_at_a_distance(
    cones: tuple[float, float], helix: float
) -> None:
    """Members whose helix angles cancel have no contact on axes with a shaft angle and an offset, and the
    remarks begin with two errors. Without backlash their axes meet or are parallel."""
    pair = with_cones(table1(), *cones)
    pinion, gear = (
        changed(member, helix_angle=side * radians(helix))
        for member, side in zip(pair.members, (1.0, -1.0), strict=True)
    )
    design = replace(pair, pinion=pinion, gear=gear)
    for flank in FLANKS:
        assert path_ends(design, flank).status in (Status.UNDEFINED, Status.OFF_FLANK)
    assert [remark.level for remark in remarks_on(design)][:2] == ["error", "error"]
    if cones == (0.0, 0.0):
        assert float(zero_backlash_layout(design).shaft_angle) == 0.0
    else:
        assert abs(float(zero_backlash_layout(design).offset)) < 2.0


@pytest.mark.parametrize("rounding", [0.0, 0.01, 1.0, 5.0])
@pytest.mark.parametrize("cones", [(0.0, 1.0), (1.0, 0.0), (1.0, -1.0)])
def test_small_cones_do_not_take_the_false_pitch_point(rounding: float, cones: tuple[float, float]) -> None:
    """The correct pitch point is used for small cones, although lines of action with opposite n_x are then
    nearly parallel and pass each other closely."""
    offset = float(PLAIN.pair.offset) + rounding
    free = replace(PLAIN, pair=Pair(offset, PLAIN.pair.shaft_angle))
    for size in (1e-14, 1e-13, 1e-9, 1e-5, 1e-4, 5e-3, 0.02, 0.1):
        mounting = mounting_of(with_cones(free, *(size * cone for cone in cones)))
        assert np.abs(mounting.distance).max() < 1e-10 + 70.0 * size
        assert mounting.branch.tolist() == [1.0, 1.0]
        assert float(mounting.normal_backlash) == pytest.approx(0.727 * rounding, abs=1e-3 + 0.06 * size)
