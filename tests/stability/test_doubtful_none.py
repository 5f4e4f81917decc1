"""Contacts on the flanks whose path is lost: that must not be called "no contact".

Found by a search that compared paths with positions asked for one by one.
"""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom.contact.path import path_ends, path_of_contact
from beveloid_geom.design.model import Design, Errors, Member, Pair, Tool
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Status
from tests.contact.test_path import five_equation_residual, margins
from tests.oracle.table1 import table1
from tests.symmetry import exchanged

ACROSS_A_NARROW_FACE = Design(
    pinion=Member(
        Tool(4.331395567241497, 0.3490658503988659, 1.0, 1.25, 0.38, -5.944122192824696e-05),
        20,
        0.935078759057453,
        0.00018892611677776184,
        -0.26762045511232246,
        0.4420226679104775,
    ),
    gear=Member(
        Tool(4.331395567241497, 0.3490658503988659, 1.0, 1.25, 0.38, 4.796984707356788e-05),
        72,
        -1.1295956828975349,
        0.05390145235493951,
        -0.0882738643210349,
        6.271113508074621,
    ),
    pair=Pair(356.9592454507762, 0.1916519621611691, 1308.538542816286, 1291.716624353172),
    errors=Errors(pinion_axial=1.8280577309024066),
)
"""0.44 mm wide, crossed in 0.12 mm of l1 while w1 hardly changes: the walk once stepped over it."""

LOST_OUTSIDE = Design(
    pinion=Member(
        Tool(4.884691321353124, 0.46574162265650904, 1.0, 1.3350854562186305, 0.38, -3.846745616824553e-12),
        40,
        0.8698364207301114,
        0.0,
        0.30695367316197475,
        21.426233634466534,
    ),
    gear=Member(
        Tool(4.884691321353124, 0.46574162265650904, 1.0, 1.25, 0.036674760572171, 0.0),
        49,
        -1.1248854881808585,
        -0.0013689163071937923,
        0.0,
        5.849145172341486,
    ),
    pair=Pair(293.60102781434375, 0.1863563138539416, 1637.806037659169, 1622.7240869712734),
    errors=Errors(6.325966297902376, -0.0014494675736841994, -0.07141024370491182, 0.3019586103906958),
)
"""n_x is 1e-5 all along: rounding ends every walk, outside the face."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "l1"), [(ACROSS_A_NARROW_FACE, 2.15928085), (LOST_OUTSIDE, -3.15)], ids=["narrow", "lost"]
)
def test_a_lost_path_is_not_called_none(design: Design, l1: float) -> None:
    assert path_of_contact(design, "left", l1=[l1]).status[0] == Status.SOLVED
    for pair in (design, exchanged(design)):
        assert path_ends(pair, "left").status in (Status.NOT_CONVERGED, Status.SOLVED)


OTHER_SIGN = Design(
    pinion=Member(
        Tool(3.776326202958474, 0.2701060241725195, 1.0, 1.25, 0.38, 3.566090294048594e-05),
        46,
        -0.47476820732753666,
        -0.00021077912552686497,
        0.4991035992061802,
        4.26505233427858,
    ),
    gear=Member(
        Tool(3.776326202958474, 0.2701060241725195, 1.0, 1.25, 0.38, -0.013192383179400247),
        59,
        0.14053928966167356,
        -0.04805037752065541,
        0.0724782030031903,
        80.30193916247295,
    ),
    pair=Pair(207.800545203316, 0.3381777832748763, -200.09045366434586, -220.63145435943807),
    errors=Errors(-9.632972699926475, -0.0008026435088840315, -0.0010531542205619335),
)
"""Held where the sign of n_x that belongs to its pitch point misses the flanks, and the other does not."""


def test_the_other_sign_of_n_x_is_looked_for() -> None:
    path = path_of_contact(OTHER_SIGN, points=5)
    assert path.ends.status == Status.SOLVED
    assert (np.sign(path.normal[:, 0]) == -mounting_of(OTHER_SIGN).branch[0]).all()
    assert five_equation_residual(OTHER_SIGN, path) < 1e-9
    assert margins(OTHER_SIGN, path).min() > -1e-9


def test_positions_stand_where_they_were_asked_for() -> None:
    l1 = np.linspace(-5.0, 5.0, 37)
    for design in (table1((0.001, -0.001)), table1((-0.01, 0.01))):
        assert path_of_contact(design, l1=l1).l1.tolist() == l1.tolist()
