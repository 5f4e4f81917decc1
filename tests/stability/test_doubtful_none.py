"""Contacts on the flanks whose path is lost: that must not be called "no contact".

Found by a search that compared paths with positions asked for one by one.
"""

from __future__ import annotations

import pytest

from beveloid_geom.inputs import Design, Errors, Member, Pair, Tool
from beveloid_geom.path import path_ends, path_of_contact
from beveloid_geom.solve import Status
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


@pytest.mark.parametrize(
    ("design", "l1"), [(ACROSS_A_NARROW_FACE, 2.15928085), (LOST_OUTSIDE, -3.15)], ids=["narrow", "lost"]
)
def test_a_lost_path_is_not_called_none(design: Design, l1: float) -> None:
    assert path_of_contact(design, "left", l1=[l1]).status[0] == Status.SOLVED
    for pair in (design, exchanged(design)):
        assert path_ends(pair, "left").status in (Status.NOT_CONVERGED, Status.SOLVED)
