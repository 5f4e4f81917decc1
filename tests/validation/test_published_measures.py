"""Published thicknesses, balls, rolls and spans of cylindrical gears, within the last printed digit.

STplus: listings of STplus 11.1F, the cylindrical gear program of the FVA (FZG, TU Munich), in the public
repository tkuhn39/semesterthesis; the inputs are those of its cases. DIN 21773: literals of a public test of
that standard. AGMA: reference value quoted in the public repository bfoster59/MOP.
"""

from __future__ import annotations

from math import acos, atan, cos, pi, radians, tan
from typing import NamedTuple

import numpy as np
import pytest

from beveloid_geom import Member, Tool
from beveloid_geom.status import BallStatus
from beveloid_geom.workshop.balls import ball_dimensions
from beveloid_geom.workshop.span import span_measurement
from beveloid_geom.workshop.tooth_data import tooth_data

ALPHA = radians(20.0)


class Case(NamedTuple):
    """One gear of a listing: its inputs and the values printed to `digits`; mm.

    The contact diameter of the balls is that at the generating profile shift. The addendum gives the listed
    tip diameter, except for the last gear: its addendum is shorter, because otherwise the ball would not
    stand out of the teeth."""

    module: float
    helix_deg: float
    teeth: int
    shift: float
    generating_shift: float
    addendum: float
    ball: float
    thickness: float
    over_balls: float
    contact_diameter: float
    allowances: tuple[float, float]
    changes: tuple[float, float]
    digits: int


LISTED = {
    "helix30, 25": Case(
        *(3.0, 30.0, 25, 0.3, 0.26108, 1.0, 6.5, 5.36754, 99.57186, 90.2648),
        *((-0.085, -0.125), (-0.1752, -0.25796), 5),
    ),
    "helix30, 40": Case(
        *(3.0, -30.0, 40, -0.1, -0.15266, 1.0, 6.0, 4.49401, 148.29507, 139.78296),
        *((-0.115, -0.165), (-0.27899, -0.40103), 5),
    ),
    "FZG C, 16": Case(
        *(4.5, 0.0, 16, 0.1818, 0.1559, 0.979, 8.0, 7.664, 84.66, 73.101),
        *((-0.085, -0.125), (-0.171, -0.251), 3),
    ),
    "FZG C, 24": Case(
        *(4.5, 0.0, 24, 0.1714, 0.1454, 0.979, 7.5, 7.63, 119.135, 108.559),
        *((-0.085, -0.125), (-0.193, -0.284), 3),
    ),
    "undercut, 12": Case(
        *(2.0, 0.0, 12, 0.0, -0.0446, 1.0, 4.0, 3.142, 30.379, 24.454),
        *((-0.065, -0.095), (-0.118, -0.174), 3),
    ),
    "undercut, 40": Case(
        *(2.0, 0.0, 40, 0.0, -0.0584, 1.0, 3.5, 3.142, 85.002, 80.027),
        *((-0.085, -0.125), (-0.208, -0.307), 3),
    ),
    "shift -0.8, 17": Case(
        *(4.0, 0.0, 17, -0.8, -0.8292, 1.0, 8.0, 3.954, 75.434, 65.348),
        *((-0.085, -0.125), (-0.244, -0.361), 3),
    ),
    "shift 0.6, 60": Case(
        *(4.0, 0.0, 60, 0.6, 0.5605, 0.5, 5.5, 8.03, 248.941, 241.151),
        *((-0.115, -0.165), (-0.288, -0.414), 3),
    ),
}


@pytest.mark.parametrize("name", LISTED)
def test_thickness_and_balls_of_stplus(name: str) -> None:
    """Nominal values, and changes of the dimension over balls for the allowances of the thickness."""
    case = LISTED[name]
    tool = Tool(case.module, ALPHA, case.addendum, 1.39 if case.module == 4.5 else 1.25, 0.25)
    member = Member(tool, case.teeth, radians(case.helix_deg), 0.0, case.shift, 20.0)
    # Dimensions over balls with five digits are off by up to 1.2e-5 mm from DIN 21773 in double precision.
    within = {3: 5.1e-4, 5: 1.3e-5}[case.digits]
    assert tooth_data(member).normal_thickness[0, 1] == pytest.approx(case.thickness, abs=within)
    generated = 2.0 * (case.generating_shift - case.shift) * case.module * tan(ALPHA)
    found = ball_dimensions(member, case.ball, 0.0, (0.0, *case.allowances, generated))
    assert found.status[0, 0] in (BallStatus.MEASURED, BallStatus.OFF_FLANK)  # the latter where undercut ends
    across = 2.0 * found.radius[:, 0] * (cos(0.5 * pi / case.teeth) if case.teeth % 2 else 1.0) + case.ball
    assert across[0] == pytest.approx(case.over_balls, abs=within)
    # The generating profile shift is itself rounded, to four digits where three are printed.
    rounded = within + 5e-5 * 2.0 * case.module if case.digits == 3 else within
    assert 2.0 * found.contact_radius[:, 3, 0] == pytest.approx(case.contact_diameter, abs=rounded)
    assert across[1:3] - across[0] == pytest.approx(case.changes, abs=2.0 * within)
    measured = found.status[:, 0] == BallStatus.MEASURED
    assert found.dimension[measured, 0] == pytest.approx(across[measured], abs=1e-12)


@pytest.mark.parametrize(("teeth", "published"), [(25, 58.0771), (40, 90.1508)])
def test_balls_of_din_21773(teeth: int, published: float) -> None:
    member = Member(Tool(2.0, ALPHA), teeth, radians(20.0), 0.0, 0.0, 20.0)
    assert ball_dimensions(member, 3.5, 0.0).dimension[0, 0] == pytest.approx(published, abs=5.1e-5)


def test_rolls_and_balls_of_an_odd_helical_gear() -> None:
    """AGMA: 127 teeth, diametral pitch 12, helix 10.5 deg, pin 0.144 in."""
    member = Member(Tool(25.4 / 12.0, ALPHA), 127, radians(10.5), 0.0, 0.0, 30.0)
    found = ball_dimensions(member, 0.144 * 25.4, 0.0)
    assert found.over_rolls[0, 0] / 25.4 == pytest.approx(10.967749, abs=5.1e-7)
    assert found.dimension[0, 0] / 25.4 == pytest.approx(10.966921, abs=5.1e-7)


@pytest.mark.parametrize(("teeth", "number", "published"), [(25, 5, 69.368), (65, 10, 145.895)])
def test_spans_of_stplus(teeth: int, number: int, published: float) -> None:
    """Module 5, helix 20 deg, x1 0.25; x2 follows from the centre distance of 241 mm without backlash."""
    helix, distance = radians(20.0), 241.0
    transverse = atan(tan(ALPHA) / cos(helix))
    working = acos(5.0 * 45.0 / cos(helix) * cos(transverse) / distance)
    involutes = tan(working) - working - tan(transverse) + transverse
    shift = {25: 0.25, 65: 45.0 * involutes / tan(ALPHA) - 0.25}[teeth]
    member = Member(Tool(5.0, ALPHA, 1.0, 1.25, 0.3), teeth, helix, 0.0, shift, 50.0)
    found = span_measurement(member, number)
    assert found.dimension[0] == pytest.approx(published, abs=5.1e-4)
    assert np.isfinite(span_measurement(member).dimension).all()
