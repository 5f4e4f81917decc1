"""Requests without a proposal and contradictory requests: reasons and the nearest request with a proposal."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import pytest

from beveloid_geom import DesignError
from beveloid_geom.proposal.command_line import refusal
from beveloid_geom.proposal.propose import Refused, propose
from beveloid_geom.proposal.request import Bounds, Request, faults_of
from tests.proposal.grid_search import grid_search_solves
from tests.proposal.requests import random_requests
from tests.proposal.test_closure_equations import TABLE1
from tests.proposal.test_propose import FIRST, GEAR, MARINE, assert_sound


def test_refusal_names_the_nearest_request() -> None:
    request = replace(TABLE1, crossing=radians(4.0))
    with pytest.raises(Refused) as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest is not None
    assert_sound(nearest, propose(nearest))
    line = refusal(request, refused.value.reason, nearest)
    assert line.count("\n") == 0
    assert "the nearest request with a solution: --crossing-deg 3.9" in line


@pytest.mark.parametrize("flank", ["right", "left"])
def test_line_contact_beyond_the_limits(flank: str) -> None:
    """Line contact in the layout of Table 1 needs cone angles of 22 and 14 deg."""
    request = replace(TABLE1, flank=flank, crossing=0.0)
    with pytest.raises(Refused, match=r"the request needs cone angles of -?22.1 and -?1\d") as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest is not None
    assert nearest == replace(request, crossing=nearest.crossing)
    assert radians(1.0) < (nearest.crossing or 0.0) < radians(2.2957)
    assert_sound(nearest, propose(nearest, 1))


def test_exceeded_limits_are_named() -> None:
    request = replace(TABLE1, cone_limits=Bounds(0.0, radians(2.0)))
    with pytest.raises(
        Refused, match=r"the request needs cone angles of 2.88 and 0.897 deg, beyond the limits 0 to 2"
    ):
        propose(request)


BAD = {
    "internal gear": (replace(FIRST, teeth=(25, -61)), "teeth must be at least 1, got -61: internal gears"),
    "parallel axes": (
        replace(FIRST, shaft_angle=0.0),
        "cones_deg must be opposite on parallel axes, got '3 5'",
    ),
    "parallel axes that meet": (
        replace(FIRST, shaft_angle=0.0, offset=0.0, cone_angles=(0.0, 0.0)),
        "offset must be above 0 on parallel axes, got 0.0",
    ),
    "crossing of parallel axes": (
        replace(TABLE1, shaft_angle=0.0),
        "crossing_deg cannot be given with --shaft-angle-deg 0: flanks on parallel axes have line",
    ),
    "hands on parallel axes": (
        replace(MARINE, shaft_angle=0.0, helix_angle=radians(15.5)),
        "helix_deg must be 15 deg with this gear, got 15.5",
    ),
    "past parallel": (
        replace(FIRST, shaft_angle=-0.1),
        "shaft_angle_deg must be between 0 and 90 deg, got -5.72958: give its magnitude",
    ),
    "90 deg": (
        replace(FIRST, shaft_angle=radians(90.0), offset=0.0),
        "cones_deg must have a sum of about 90 deg, got '3 5': on intersecting axes",
    ),
    "steep cones": (
        replace(FIRST, cone_angles=(radians(20.0), radians(15.0))),
        "cones_deg must have a sum of at most 20 deg, got '20 15'",
    ),
    "hands": (
        replace(MARINE, offset=0.0, helix_angle=radians(-15.0)),
        "helix_deg must be about 15 deg with this gear, got -15.0: on intersecting",
    ),
    "crossed hands": (
        replace(MARINE, offset=180.0, helix_angle=radians(-15.0)),
        "helix_deg must be between 8 and 22 deg with this gear, got -15.0",
    ),
    "flat helices": (
        replace(FIRST, shaft_angle=radians(90.0), helix_limits=Bounds(radians(-30.0), radians(30.0))),
        "helix_limits_deg must reach to 44.87 deg",
    ),
    "pointed tool": (
        replace(FIRST, pressure_angle=radians(33.0)),
        "pressure_angle_deg must be between 5 and 32 deg, got 33.0: usual are 14.5 to 25; at more than 32",
    ),
    "no fillets": (
        replace(MARINE, offset=180.0, gear=replace(GEAR, tool=replace(GEAR.tool, tip_radius=0.6))),
        "gear has a tool without a fillet: tip_radius 0.6 is too large",
    ),
    "nothing given": (replace(FIRST, cone_angles=None), "no quantity of the members is given: give one of"),
    "too much": (replace(FIRST, least_cones=True), "more than one kind of quantity of the members"),
    "no offset": (replace(TABLE1, offset=None), "offset is missing: --crossing-deg"),
    "no helix": (replace(TABLE1, helix_angle=None), "helix_deg is missing"),
    "not this gear": (replace(MARINE, offset=0.0, teeth=(24, 60)), "teeth must be 61 for the gear"),
    "backlash": (replace(FIRST, backlash=5.0), "backlash must be between 0 and 4 mm, got 5.0"),
    "limits": (
        replace(FIRST, shift_limits=Bounds(0.5, 0.0)),
        "shift_limits must have the lower limit first, got 0.5 0: exchange them",
    ),
    "limits in deg": (
        replace(FIRST, cone_limits=Bounds(radians(10.0), radians(1.0))),
        "cone_limits_deg must have the lower limit first, got 10 1: exchange them",
    ),
    "module": (replace(FIRST, module=-1.0), "module must be between 0.01 and 100 mm, got -1.0"),
}


@pytest.mark.parametrize("name", BAD)
def test_contradictory_requests(name: str) -> None:
    request, words = BAD[name]
    faults = [str(fault) for fault in faults_of(request)]
    assert len(faults) == 1, faults
    assert faults[0].startswith(words), faults
    with pytest.raises(DesignError):
        propose(request)


def refused(request: Request) -> Refused | None:
    """Return the refusal of a request after checking its nearest request.

    Return None if the request has valid proposals or is contradictory."""
    try:
        proposals = propose(request)
    except DesignError:
        return None
    except Refused as error:
        refusal_error = error
    else:
        assert_sound(request, proposals)
        return None
    assert refusal_error.nearest is not None
    assert "\n" not in refusal(request, refusal_error.reason, refusal_error.nearest)
    assert_sound(refusal_error.nearest, propose(refusal_error.nearest, 1))
    return refusal_error


def test_answers_have_no_warning_and_refusals_a_request_that_works() -> None:
    outcomes = [refused(request) for request in random_requests(8, seed=4)]
    assert None in outcomes
    assert any(outcomes)


@pytest.mark.slow
def test_random_requests() -> None:
    """At most 5 % of the requests that a grid search solves are refused."""
    requests = list(random_requests(21, seed=7))
    refusals = [request for request in requests if refused(request)]
    assert len(refusals) > 5
    missed = sum(grid_search_solves(request) is not None for request in refusals)
    assert missed <= 0.05 * (len(requests) - len(refusals))
