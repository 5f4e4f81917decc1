"""First contact of teeth, edges and fillets, compared with simple independent searches."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Tool,
    first_contact,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.status import FirstStatus, Limit
from tests.oracle.table1 import table1

BOTH = ["right", "left"]


def pitches(design: Design) -> tuple[float, float]:
    return 2.0 * np.pi / float(design.pinion.teeth), 2.0 * np.pi / float(design.gear.teeth)


def cycle(design: Design, flank: str, count: int) -> FloatArray:
    """Return pinion rolls over one pitch."""
    return float(pitch_point_roll(design, flank)) + pitches(design)[0] * (np.arange(count) + 0.3) / count


@pytest.mark.parametrize("errors", [Errors(), Errors(0.03, radians(0.003), 0.2, -0.1)])
def test_unmodified_flanks_touch_along_the_path(flank: str, errors: Errors) -> None:
    design = table1(errors=errors)
    path = path_of_contact(design, flank, 41)
    first = first_contact(design, flank, path.pinion_roll[1:-1])
    assert (first.status == FirstStatus.SOLVED).all()
    assert (first.limit == -1).all()
    assert not first.on_fillet.any()
    assert np.abs(first.gear_roll - path.gear_roll[1:-1]).max() < 1e-12
    # Two pairs touch at once in part of the cycle; compare where the first contact is of this pair.
    mine = first.pair == 0
    assert mine.sum() > 15
    for name, other in (("l1", "l1"), ("z1", "pinion_z"), ("l2", "l2"), ("z2", "gear_z"), ("point", "point")):
        assert np.abs(getattr(first, name) - getattr(path, other)[1:-1])[mine].max() < 1e-9
    assert np.ptp(first.transmission_error) < 1e-13


EDGES = {
    "tips, both concave": table1((0.0002, 0.0002)),
    "tips, more so": table1((0.0006, 0.0006)),
    "pinion heel": table1((0.0005, -0.0005), Errors(1.0)),
    "ends": table1((0.0005, -0.0005), Errors(shaft_angle=radians(0.1))),
    "other ends": table1((0.0005, -0.0005), Errors(shaft_angle=radians(-0.1))),
}


def test_expected_edges() -> None:
    """The expected edges of Table 1 touch: tips if both flanks are concave, ends of the face under
    misalignment."""
    limits = {
        name: {int(x) for x in first_contact(design, "right", cycle(design, "right", 8)).limit.ravel()}
        for name, design in EDGES.items()
    }
    assert limits["pinion heel"] >= {Limit.PINION_HEEL}
    assert limits["tips, both concave"] >= {Limit.PINION_TIP, Limit.GEAR_TIP}
    assert limits["tips, more so"] == {Limit.PINION_TIP, Limit.GEAR_TIP, -1}
    ends = {Limit.PINION_TOE, Limit.GEAR_TOE, Limit.PINION_HEEL, Limit.GEAR_HEEL}
    assert limits["ends"] & ends
    assert limits["other ends"] & ends
    assert not limits["ends"] & limits["other ends"] & ends


def test_selected_tooth_pairs() -> None:
    """A single pair touches no earlier than the first contact, and one of the pairs equals it."""
    design = table1((0.001, -0.001))
    roll = cycle(design, "right", 9)
    first = first_contact(design, "right", roll)
    alone = [first_contact(design, "right", roll, pairs=[pair]) for pair in (-2, -1, 0, 1)]
    rolls = np.array([np.where(one.status == FirstStatus.SOLVED, one.gear_roll, np.inf) for one in alone])
    assert np.abs(rolls.min(axis=0) - first.gear_roll).max() < 1e-12


def test_arrays_of_layouts() -> None:
    roll = cycle(table1(), "right", 4)
    layouts = replace(table1(), pair=Pair(np.array([229.0, 229.05]), radians(15.0)))
    both = first_contact(layouts, "right", roll)
    assert np.abs(both.gear_roll[0] - first_contact(table1(), "right", roll).gear_roll).max() < 1e-13


@pytest.mark.parametrize(
    ("parabola", "offset", "share", "limits"),
    [
        ((0.0, 0.0), -1.2, 37 / 39, (Limit.GEAR_TIP, -1)),
        ((0.003, -0.003), -0.9, 36 / 39, (Limit.PINION_HEEL, Limit.GEAR_TIP)),
        ((0.005, 0.003), -0.9, 30 / 39, (Limit.PINION_TOE, Limit.GEAR_TIP)),
    ],
)
def test_a_tip_on_a_fillet(
    parabola: tuple[float, float], offset: float, share: float, limits: tuple[int, int]
) -> None:
    """A gear mounted too close: its tips touch the fillets of the pinion, next to tangencies of the flanks
    that are nearly as early."""
    design = table1(parabola, Errors(offset))
    roll = float(pitch_point_roll(design, "right")) + pitches(design)[0] * share
    first = first_contact(design, "right", roll)
    assert tuple(first.limit[0]) == limits
    assert first.on_fillet[0].tolist() == [True, False]
    assert first.l1[0] < surface_of(design.pinion, "right").joint


def test_status_of_positions_without_contact() -> None:
    apart = first_contact(table1(errors=Errors(gear_axial=400.0)), "right", [0.1, 0.2])
    assert (apart.status == FirstStatus.NO_CONTACT).all()
    deep = first_contact(table1(errors=Errors(offset=-4.0)), "right", [0.1, 0.2])
    assert (deep.status == FirstStatus.MEETS_BOTTOM).all()
    tool = Tool(6.0, radians(20.0))
    small = Member(tool, 8, radians(20.0), radians(20.0), -0.5, 60.0)
    mounted = replace(table1().pair, pinion_mounting=211.6, gear_mounting=210.2)
    undercut = first_contact(replace(table1(), pinion=small, pair=mounted), "right", [0.1])
    assert undercut.status[0] == FirstStatus.UNDERCUT
    for first in (apart, deep, undercut):
        assert np.isnan(first.gear_roll).all()
        assert np.isnan(first.point).all()
        assert (first.limit == -1).all()
