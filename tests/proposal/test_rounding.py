"""Rounded proposals: tolerances of layout and backlash, no new warnings, few digits."""

from __future__ import annotations

from math import degrees, radians

import pytest

from beveloid_geom import Design, path_of_contact
from beveloid_geom.design.field_limits import DesignError
from beveloid_geom.findings.diagnostics import quiet
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.proposal.candidates import given_of
from beveloid_geom.proposal.closure_equations import Variable
from beveloid_geom.proposal.propose import Refused, propose
from beveloid_geom.proposal.request import Request
from beveloid_geom.proposal.rounding import rounded_design
from tests.proposal.requests import random_requests


def numbers_of(design: Design) -> dict[str, float]:
    """Return the quantities of a pair by name, deg and modules."""
    found = {}
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        found[f"{name}_cone"] = degrees(member.cone_angle)
        found[f"{name}_helix"] = degrees(member.helix_angle)
        found[f"{name}_shift"] = float(member.profile_shift)
    return found


def test_rounded_proposals() -> None:
    checked = 0
    for request in random_requests(21, 5):
        try:
            (proposal, *_) = propose(request, 1)
        except (DesignError, Refused):
            continue
        design = rounded_design(request, proposal.design)
        exact, closing = layout_deviation(proposal.design), layout_deviation(design)
        face = min(float(member.face_width) for member in design.members)
        assert closing.gap <= 0.005 * face
        assert closing.normal_backlash == pytest.approx(exact.normal_backlash, abs=0.002 * request.module)
        assert quiet(remarks_on(design))
        for flank in ("right", "left"):
            given_ends, ends = (path_of_contact(one, flank, 2).ends for one in (proposal.design, design))
            if request.shaft_angle > 0.0:  # in line contact, a corner belongs to two limits
                assert (ends.enter, ends.leave) == (given_ends.enter, given_ends.leave)
            assert float(ends.contact_ratio) == pytest.approx(float(given_ends.contact_ratio), abs=0.02)
        given, before, after = given_of(request), numbers_of(proposal.design), numbers_of(design)
        for number, name in enumerate(variable.name.lower() for variable in list(Variable)[:6]):
            if number in given or (not request.shaft_angle and name[-5:] != "shift"):
                assert abs(after[name] - before[name]) < 1e-3
            else:
                assert after[name] == pytest.approx(round(after[name], 9), abs=1e-12)
        assert design.pair.shaft_angle == proposal.design.pair.shaft_angle
        assert request.offset in (None, float(design.pair.offset))
        checked += 1
    assert checked > 8


def test_a_pair_without_backlash_is_not_rounded_to_one_that_jams() -> None:
    request = Request(4.0, (25, 31), (40.0, 40.0), radians(10.0), 0.0, least_cones=True)
    for proposal in propose(request, 4):
        backlash = float(layout_deviation(rounded_design(request, proposal.design)).normal_backlash)
        assert -1e-9 < backlash < 0.002 * 4.0
