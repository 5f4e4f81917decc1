"""Edges at which patterns end: against finer patterns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design, contact_pattern
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.status import Limit
from tests.oracle.table1 import table1

CASES = [  # design, flank, and errors as multiples of the usual tolerances
    (table1((-0.0005, -0.0005)), "right", 4.0),
    (table1((0.001, -0.001)), "left", 8.0),
    (builtin_design("awd-transfer").with_parabola(0.0, -0.0005), "right", 3.0),
]


def drawn(times: float, seed: int) -> FloatArray:
    offset, angle, pinion, gear = (times * USUAL.values()).tolist()
    wide = replace(USUAL, offset=offset, shaft_angle=angle, pinion_axial=pinion, gear_axial=gear)
    return np.asarray(drawn_errors(wide, seed, 0, 1)[0])


@pytest.mark.parametrize(("design", "flank", "times"), CASES)
@pytest.mark.parametrize("seed", [1, 2])
def test_ends_equal_those_of_a_finer_pattern(design: Design, flank: str, times: float, seed: int) -> None:
    mounting = mounted(design, drawn(times, seed))
    fine = contact_pattern(mounting, flank, resolution=0.5)
    rims = [
        [side.least[0], side.least[-1], side.least[:, 0], side.least[:, -1]]
        for side in (fine.pinion, fine.gear)
    ]
    expected = np.array([[(rim <= fine.separation).any() for rim in of_member] for of_member in rims])
    np.testing.assert_array_equal(contact_pattern(mounting, flank).ends, expected.T.ravel())
    assert 0 < np.count_nonzero(expected) < 8


def test_thick_compound_ends_at_all_tips_and_ends_of_faces() -> None:
    """The pattern of 1 mm of compound ends at both tips and at both ends of the pinion face. The pattern of
    0.1 um ends only where the path ends, at both tips."""
    tips = [Limit.PINION_TIP, Limit.GEAR_TIP]
    assert contact_pattern(table1(), "right", 1.0).ends[[*tips, Limit.PINION_TOE, Limit.PINION_HEEL]].all()
    assert np.flatnonzero(contact_pattern(table1(), "left", 1e-4).ends).tolist() == tips
