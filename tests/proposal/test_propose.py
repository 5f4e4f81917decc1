"""Proposals as an engineer asks for them, and requests that cannot be met."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from beveloid_geom import DesignError, Status, builtin_design, path_of_contact
from beveloid_geom.findings.advice import findings_on
from beveloid_geom.findings.backlash import backlash_report
from beveloid_geom.findings.remarks import quiet
from beveloid_geom.pair.closing import closing_of
from beveloid_geom.pair.crossing import crossing_as_mounted
from beveloid_geom.proposal.candidates import candidates_of
from beveloid_geom.proposal.propose import MOST, Proposal, Refused, propose, works
from beveloid_geom.proposal.request import Bounds, Request, faults_of
from beveloid_geom.proposal.words import command_of, refusal, requests_like
from tests.proposal.grid_search import grid_search_solves
from tests.proposal.requests import random_requests
from tests.proposal.test_conditions import REQUESTS, TABLE1

FIRST = Request(
    module=4.0,
    teeth=(25, 31),
    face_widths=(40.0, 40.0),
    shaft_angle=radians(20.0),
    backlash=0.05,
    cone_angles=(radians(3.0), radians(5.0)),
)
GEAR = builtin_design("marine-gearbox").gear
MARINE = Request(
    module=6.0,
    teeth=(24, 61),
    face_widths=(60.0, 60.0),
    shaft_angle=radians(7.0),
    backlash=0.243,
    gear=GEAR,
)


def assert_sound(request: Request, proposals: tuple[Proposal, ...]) -> None:
    """Each closes as required, and `check` and `tca` have no warning."""
    assert proposals
    for one in proposals:
        design, closing = one.design, closing_of(one.design)
        assert quiet(findings_on(design, closing, backlash_report(design).jam))
        assert abs(closing.offset_difference) < 1e-9
        assert abs(closing.shaft_angle_difference) < 1e-12
        assert closing.normal_backlash == pytest.approx(request.backlash, abs=1e-9)


def test_a_first_pair_in_one_try() -> None:
    proposals = propose(FIRST)
    assert len(proposals) == MOST
    assert_sound(FIRST, proposals)
    for one in proposals:
        assert [degrees(member.cone_angle) for member in one.design.members] == pytest.approx([3.0, 5.0])
    reserves = [float(one.figures.reserve[0]) for one in proposals]
    assert reserves == sorted(reserves, reverse=True)


def test_table_1_is_proposed_first() -> None:
    proposals = propose(TABLE1)
    assert_sound(TABLE1, proposals)
    pinion, gear = proposals[0].design.members
    assert degrees(pinion.cone_angle) == pytest.approx(2.8793, abs=1e-4)
    assert degrees(gear.cone_angle) == pytest.approx(0.8974, abs=1e-4)
    assert degrees(gear.helix_angle) == pytest.approx(-10.5610, abs=1e-4)
    assert degrees(crossing_as_mounted(proposals[0].design, "right")) == pytest.approx(2.2957, abs=1e-9)


def test_a_degree_less_takes_a_negative_cone() -> None:
    request = replace(TABLE1, shaft_angle=radians(14.0))
    proposals = propose(request)
    assert_sound(request, proposals)
    pinion, gear = proposals[0].design.members
    assert degrees(pinion.cone_angle) == pytest.approx(-1.56, abs=0.1)
    assert degrees(gear.cone_angle) == pytest.approx(5.2, abs=0.1)
    assert degrees(gear.helix_angle) == pytest.approx(-11.54, abs=0.05)


def test_two_pinions_on_one_gear() -> None:
    """The coupled set of a marine gearbox: the axis of one pinion meets the gear's at 7 deg, that of the
    other crosses it at 7 deg, 180 mm away."""
    for offset in (0.0, 180.0):
        request = replace(MARINE, offset=offset)
        proposals = propose(request)
        assert_sound(request, proposals)
        for one in proposals:
            assert one.design.gear == GEAR
            assert float(one.design.pair.offset) == offset
            assert float(one.design.pair.shaft_angle) == radians(7.0)


def test_a_gear_with_a_parabola_is_looked_at_whole() -> None:
    """A concave one lets edges touch earlier, which figures of unmodified flanks do not tell; a convex one
    does not."""
    held = [replace(GEAR, tool=replace(GEAR.tool, parabola=parabola)) for parabola in (0.001, -0.001)]
    assert not works(replace(MARINE, offset=180.0, gear=held[0]))
    request = replace(MARINE, offset=180.0, gear=held[1])
    assert_sound(request, propose(request, 1))


TIPS = {
    "steep": Request(
        module=1.0,
        teeth=(38, 83),
        face_widths=(36.4, 36.4),
        shaft_angle=radians(71.66),
        backlash=0.0136,
        helix_angle=radians(-44.0),
        least_cones=True,
        pressure_angle=radians(22.5),
        shift_limits=Bounds(-0.6, 0.8),
    ),
    "past the mesh": Request(
        module=1.0,
        teeth=(16, 53),
        face_widths=(26.58, 55.37),
        shaft_angle=radians(10.558),
        backlash=0.01814,
        offset=35.8694,
        helix_angle=radians(-13.4524),
        least_cones=True,
        pressure_angle=radians(14.5),
        shift_limits=Bounds(-0.6, 0.8),
    ),
}


def test_tips_that_cut_are_not_proposed() -> None:
    """Tips are deepest within a few modules of wide faces on steep axes; beyond the mesh they meet fillets
    where a hundredth of a module of flank is left, as each pair of the second request does."""
    assert_sound(TIPS["steep"], propose(TIPS["steep"]))
    assert not works(TIPS["past the mesh"])


def test_rounds_of_a_large_pressure_angle_fit_the_tool() -> None:
    request = replace(FIRST, pressure_angle=radians(25.0))
    proposals = propose(request, 1)
    assert_sound(request, proposals)
    assert proposals[0].design.pinion.tool.tip_radius == 0.31
    assert FIRST.members[0].tool.tip_radius == 0.38


def test_least_cones_are_least() -> None:
    """The larger of the two is least where they are equal: for Table 1's helix angle and layout 1.8916 deg,
    where the sum of the working cones is that of the shaft angle and the crossing helices."""
    request = replace(TABLE1, crossing=None, least_cones=True)
    first = propose(request, 1)[0].design
    least = max(abs(float(member.cone_angle)) for member in first.members)
    assert degrees(least) == pytest.approx(1.8916, abs=1e-3)
    assert np.isclose(first.pinion.cone_angle, first.gear.cone_angle, atol=1e-9)
    pairs = candidates_of(request)
    assert np.abs(pairs.values[:2]).max(axis=0).min() > least - 1e-9


def test_a_figure_is_what_it_is_called() -> None:
    one = propose(TABLE1, 1)[0]
    for k, flank in enumerate(("right", "left")):
        path = path_of_contact(one.design, flank, 3)
        assert path.ends.status == Status.SOLVED
        assert one.figures.contact_ratio[k, 0] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
        assert one.figures.normal_x[k, 0] == pytest.approx(path.normal[1, 0], abs=1e-9)
        crossing = float(crossing_as_mounted(one.design, flank))
        assert one.figures.crossing[k, 0] == pytest.approx(crossing, abs=1e-9)


def test_limits_are_kept() -> None:
    most = radians(35.0)
    request = replace(FIRST, helix_limits=Bounds(-most, most), shift_limits=Bounds(0.3, 0.7))
    for one in propose(request, 1):
        for member in one.design.members:
            assert abs(float(member.helix_angle)) <= most + 1e-9
            assert 0.3 - 1e-9 <= float(member.profile_shift) <= 0.7 + 1e-9


def test_what_runs_off_is_refused_with_the_nearest_that_works() -> None:
    request = replace(TABLE1, crossing=radians(4.0))
    with pytest.raises(Refused) as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest is not None
    assert_sound(nearest, propose(nearest))
    line = refusal(request, refused.value.reason, nearest)
    assert line.count("\n") == 0
    assert "the nearest that works: --crossing-deg 3.9" in line


@pytest.mark.parametrize("flank", ["right", "left"])
def test_line_contact_beyond_the_limits_is_refused_with_the_nearest_crossing(flank: str) -> None:
    """On Table 1's layout generators of flanks that touch along lines take cones of 22 and 14 deg."""
    request = replace(TABLE1, flank=flank, crossing=0.0)
    with pytest.raises(Refused, match=r"it would take cone angles of -?22.1 and -?1\d") as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest is not None
    assert nearest == replace(request, crossing=nearest.crossing)
    assert radians(1.0) < (nearest.crossing or 0.0) < radians(2.2957)
    assert_sound(nearest, propose(nearest, 1))


PARALLEL = replace(FIRST, shaft_angle=0.0, cone_angles=(radians(3.0), radians(-3.0)))


@pytest.mark.parametrize(
    "request_",
    [
        PARALLEL,
        replace(PARALLEL, offset=118.0, flank="left"),
        replace(PARALLEL, cone_angles=None, least_cones=True, helix_angle=radians(-12.0)),
        replace(MARINE, shaft_angle=0.0, offset=265.0),
    ],
    ids=["cones", "offset", "least cones", "gear held"],
)
def test_pairs_on_parallel_axes(request_: Request) -> None:
    proposals = propose(request_, 2)
    assert len(proposals) == (2 if request_.gear is None else 1)
    assert_sound(request_, proposals)
    for one in proposals:
        assert float(one.design.pair.shaft_angle) == request_.shaft_angle
        assert request_.offset in (None, float(one.design.pair.offset))
        if request_.least_cones:
            assert [float(member.cone_angle) for member in one.design.members] == [0.0, 0.0]


def test_of_equals_that_of_least_helix_is_first() -> None:
    """On parallel axes nothing crosses, and of many pairs nothing is left to be said."""
    proposals = propose(replace(PARALLEL, cone_angles=None, least_cones=True))
    assert [round(float(one.figures.reserve[0]), 2) for one in proposals] == [1.0] * MOST
    helices = [abs(float(one.design.pinion.helix_angle)) for one in proposals]
    assert helices == sorted(helices)
    assert degrees(helices[0]) < 6.0


@pytest.mark.parametrize("number", [3, 9, 32])
def test_pairs_near_the_limits_are_found(number: int) -> None:
    """Of these requests all pairs without warning lie in a corner of the limits, or on a short piece of a
    curve, where none of round values is."""
    request = list(random_requests(number + 1, seed=1))[number]
    assert_sound(request, propose(request, 1))


def test_nearly_parallel_axes_are_led_to_parallel_ones() -> None:
    """At 0.1 deg an error of 0.01 deg moves a path by metres."""
    request = replace(PARALLEL, shaft_angle=radians(0.1), cone_angles=None, least_cones=True)
    with pytest.raises(Refused, match="sensitive to errors") as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest == replace(request, shaft_angle=0.0)
    assert_sound(nearest, propose(nearest, 1))


def test_limits_that_leave_none_are_named() -> None:
    request = replace(TABLE1, cone_limits=Bounds(0.0, radians(2.0)))
    with pytest.raises(
        Refused, match=r"it would take cone angles of 2.88 and 0.897 deg, beyond the limits 0 to 2"
    ):
        propose(request)


BAD = {
    "internal gear": (replace(FIRST, teeth=(25, -61)), "teeth must be at least 1, got -61: internal gears"),
    "parallel axes": (
        replace(FIRST, shaft_angle=0.0),
        "cones_deg must be opposite where the axes are parallel, got '3 5'",
    ),
    "parallel axes that meet": (
        replace(FIRST, shaft_angle=0.0, offset=0.0, cone_angles=(0.0, 0.0)),
        "offset must be above 0 where the axes are parallel, got 0.0",
    ),
    "crossing of parallel axes": (
        replace(TABLE1, shaft_angle=0.0),
        "crossing_deg does not go with --shaft-angle-deg 0: flanks on parallel axes touch along lines",
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
        "cones_deg must be about 90 deg together, got '3 5': on axes that intersect",
    ),
    "steep cones": (
        replace(FIRST, cone_angles=(radians(20.0), radians(15.0))),
        "cones_deg must be at most 20 deg together, got '20 15'",
    ),
    "hands": (
        replace(MARINE, offset=0.0, helix_angle=radians(-15.0)),
        "helix_deg must be about 15 deg with this gear, got -15.0: the hands",
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
        "pressure_angle_deg must be between 5 and 32 deg, got 33.0: the usual basic rack is pointed",
    ),
    "no fillets": (
        replace(MARINE, offset=180.0, gear=replace(GEAR, tool=replace(GEAR.tool, tip_radius=0.6))),
        "gear has a tool that cuts no fillets: tip_radius 0.6 is too large",
    ),
    "nothing given": (replace(FIRST, cone_angles=None), "nothing is given of the members: give one of"),
    "too much": (replace(FIRST, least_cones=True), "too much is given of the members"),
    "no offset": (replace(TABLE1, offset=None), "offset is missing: it goes with --crossing-deg"),
    "no helix": (replace(TABLE1, helix_angle=None), "helix_deg is missing"),
    "not this gear": (replace(MARINE, offset=0.0, teeth=(24, 60)), "teeth must be 61 of the gear"),
    "backlash": (replace(FIRST, backlash=5.0), "backlash must be between 0 and 1 modules, got 1.25"),
    "limits": (replace(FIRST, shift_limits=Bounds(0.5, 0.0)), "shift_limits must be the least value first"),
    "module": (replace(FIRST, module=-1.0), "module must be between 0.01 and 100 mm, got -1.0"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_meant_is_refused_with_limit_and_cure(name: str) -> None:
    request, words = BAD[name]
    faults = [str(fault) for fault in faults_of(request)]
    assert len(faults) == 1, faults
    assert faults[0].startswith(words), faults
    with pytest.raises(DesignError):
        propose(request)


def test_a_request_is_its_command_line() -> None:
    assert command_of(TABLE1) == (
        "beveloid-geom propose --module 6 --teeth 29 45 --face-widths 50 60 --shaft-angle-deg 15 --offset 229"
        " --backlash 0.0416 --helix-deg 25 --crossing-deg 2.2957 --shifts 0.17 0.2181"
    )
    assert command_of(replace(MARINE, offset=0.0), "my gear.toml").endswith("--gear 'my gear.toml'")


def test_a_design_that_does_not_close_has_requests_like_it() -> None:
    astray = replace(builtin_design(), pair=replace(builtin_design().pair, shaft_angle=radians(14.0)))
    first, second = requests_like(astray)
    assert (first.least_cones, first.offset, second.offset) == (True, 229.0, None)
    assert_sound(first, propose(first, 1))
    tool = replace(astray.gear.tool, dedendum=1.3)
    assert requests_like(replace(astray, gear=replace(astray.gear, tool=tool))) == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", REQUESTS)
def test_every_kind_of_request_is_answered(name: str) -> None:
    if name == "cones at an offset":  # its shifts leave one helix angle, and that warns
        with pytest.raises(Refused):
            propose(REQUESTS[name])
        return
    assert_sound(REQUESTS[name], propose(REQUESTS[name]))


def refused(request: Request) -> Refused | None:
    """Why a request is refused, in a line with the nearest request that works, which does; None where its
    proposals are sound or it cannot be meant."""
    try:
        proposals = propose(request)
    except DesignError:
        return None
    except Refused as error:
        found = error
    else:
        assert_sound(request, proposals)
        return None
    assert found.nearest is not None
    assert "\n" not in refusal(request, found.reason, found.nearest)
    assert_sound(found.nearest, propose(found.nearest, 1))
    return found


def test_answers_have_no_warning_and_refusals_a_request_that_works() -> None:
    outcomes = [refused(request) for request in random_requests(8, seed=4)]
    assert None in outcomes
    assert any(outcomes)


@pytest.mark.slow
def test_random_requests() -> None:
    """What a grid search solves is solved, at least 95 of 100; `whole_run` does the same with as many as one
    likes."""
    requests = list(random_requests(42, seed=7))
    refusals = [request for request in requests if refused(request)]
    assert len(refusals) > 5
    missed = sum(grid_search_solves(request) is not None for request in refusals)
    assert missed <= 0.05 * (len(requests) - len(refusals))
