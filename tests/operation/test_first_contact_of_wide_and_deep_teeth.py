"""First contacts of wide helical faces and of deep teeth."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Tool,
    contact_pattern,
    contact_ratio,
    first_contact,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.operation.engagement import pitch_point_roll, spread
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Limit, PatternStatus, Verdict
from tests.oracle.table1 import table1
from tests.stability.answers import changed, closed

ALPHA = radians(20.0)


def wide(shaft_angle_error_deg: float) -> Design:
    """Return a pair in which several teeth overlap along the face."""
    pinion, gear = (
        Member(Tool(2.0, ALPHA), teeth, radians(helix), radians(cone), 0.1, 120.0)
        for teeth, helix, cone in ((87, 35.0, 1.0), (135, -28.0, 0.3))
    )
    pair = closed(pinion, gear).pair
    pair = replace(pair, offset=pair.offset + 0.05)
    return Design(pinion, gear, pair, Errors(shaft_angle=radians(shaft_angle_error_deg)))


def test_spread_is_that_of_the_trace_on_the_pitch_cylinder() -> None:
    pinion = wide(0.0).pinion
    per_mm = np.sin(pinion.helix_angle) / (np.pi * 2.0 * np.cos(pinion.cone_angle))
    mounting = mounting_of(wide(0.0))
    pitch_height = abs(float(mounting.pitch_distance[0] - mounting.distance[0]))
    assert spread(wide(0.0), "right") == pytest.approx((60.0 + pitch_height) * per_mm, rel=1e-9)
    assert spread(table1(), "right") < 1.0


@pytest.mark.parametrize("error", [-0.3, 0.1, 0.3])
def test_all_teeth_of_a_wide_face_are_searched(error: float, flank: str) -> None:
    design = wide(error)
    roll = float(pitch_point_roll(design, flank)) + 2.0 * np.pi / 87 * np.array([0.1, 0.35, 0.6, 0.85])
    found, every = first_contact(design, flank, roll), first_contact(design, flank, roll, np.arange(-10, 11))
    np.testing.assert_allclose(found.gear_roll, every.gear_roll, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.pair, every.pair)


@pytest.mark.slow
@pytest.mark.parametrize("error", [-0.15, -0.05, 0.1])
def test_unmodified_wide_faces_operate_with_the_ratio_of_eq_16(error: float) -> None:
    design = wide(error)
    assert operating_ratio(design, "left") == pytest.approx(float(contact_ratio(design, "left")), abs=1e-8)
    certificate = path_certificate(path_of_contact(design, "left", 5))
    assert certificate.holds
    np.testing.assert_allclose(certificate.separation, 0.0, atol=1e-12)


def test_the_pattern_of_a_wide_face_is_found_where_its_path_is() -> None:
    design = wide(-0.15)
    pattern = contact_pattern(design, "left", resolution=2.0)
    path = path_of_contact(design, "left", 3)
    side = pattern.pinion
    nearest = np.hypot(side.l - path.l1[1], side.z - path.pinion_z[1]).argmin()
    assert side.least.ravel()[nearest] < 0.00635
    assert side.area_share > 0.05
    # The motion covers the overlap of the face: no marked point still approaches at its ends.
    for marked in (pattern.pinion, pattern.gear):
        assert not (marked.marked & (marked.status == PatternStatus.END_OF_ROLL)).any()
    pitches = np.diff(pattern.roll_range).item() * 87 / (2.0 * np.pi)
    ratio = float(contact_ratio(design, "left"))
    assert pitches == pytest.approx(2.0 * spread(design, "left") + ratio, abs=1e-9)


def test_depth_of_a_tip_in_a_fillet(flank: str) -> None:
    """Deep tips: the verdict is interference, and the depth is measured along the normal of the fillet."""
    pinion, gear = (changed(member, addendum=1.2) for member in table1().members)
    design = replace(table1(), pinion=pinion, gear=gear)
    path = path_of_contact(design, flank, 9)
    found = path_certificate(path)
    deep = found.verdict == Verdict.INTERFERENCE
    assert deep.any()
    assert found.first.on_fillet[deep].any(axis=-1).all()
    by_gear = deep & (found.first.limit[:, 0] == Limit.GEAR_TIP) & (found.first.limit[:, 1] < 0)
    assert by_gear.any()
    first = found.first
    for k in np.flatnonzero(by_gear):
        rolls = float(path.pinion_roll[k]), float(path.gear_roll[k])
        edge = first.l2[k] + np.array([0.0]), first.z2[k] + np.linspace(-1.0, 1.0, 41)
        clear = angular_clearance(design, flank, 1, *edge, *rolls, pair=int(first.pair[k]))
        assert np.nanmin(clear.distance) == pytest.approx(found.separation[k], rel=0.15)
