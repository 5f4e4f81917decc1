"""Proposals for usual requests."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from beveloid_geom import Status, builtin_design, path_certificate, path_of_contact
from beveloid_geom.findings.advice import design_remarks
from beveloid_geom.findings.backlash import backlash_report
from beveloid_geom.findings.diagnostics import quiet
from beveloid_geom.pair.generator_angle import generator_angle_as_mounted
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.proposal.candidates import candidates_of
from beveloid_geom.proposal.command_line import command_of, requests_like
from beveloid_geom.proposal.propose import Proposal, Refused, propose, works
from beveloid_geom.proposal.request import Bounds, Request
from tests.proposal.requests import random_requests
from tests.proposal.test_closure_equations import REQUESTS, TABLE1

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
    """Check that each proposal meets the request and that `check` and `tca` have no warning."""
    assert proposals
    for one in proposals:
        design, closing = one.design, layout_deviation(one.design)
        assert quiet(design_remarks(design, closing, backlash_report(design).jam))
        assert abs(closing.offset_difference) < 1e-9
        assert abs(closing.shaft_angle_difference) < 1e-12
        assert closing.normal_backlash == pytest.approx(request.backlash, abs=1e-9)


def test_first_pair() -> None:
    proposals = propose(FIRST)
    assert len(proposals) == 3
    assert_sound(FIRST, proposals)
    for one in proposals:
        assert [degrees(member.cone_angle) for member in one.design.members] == pytest.approx([3.0, 5.0])
    reserves = [float(one.criteria.reserve[0]) for one in proposals]
    assert reserves == sorted(reserves, reverse=True)


def test_table_1_is_proposed_first() -> None:
    proposals = propose(TABLE1)
    assert_sound(TABLE1, proposals)
    pinion, gear = proposals[0].design.members
    assert degrees(pinion.cone_angle) == pytest.approx(2.8793, abs=1e-4)
    assert degrees(gear.cone_angle) == pytest.approx(0.8974, abs=1e-4)
    assert degrees(gear.helix_angle) == pytest.approx(-10.5610, abs=1e-4)
    assert degrees(generator_angle_as_mounted(proposals[0].design, "right")) == pytest.approx(
        2.2957, abs=1e-9
    )


def test_two_pinions_on_one_gear() -> None:
    """Two pinions of a marine gearbox: one axis intersects that of the gear at 7 deg, one crosses it at 180
    mm."""
    for offset in (0.0, 180.0):
        request = replace(MARINE, offset=offset)
        proposals = propose(request)
        assert_sound(request, proposals)
        for one in proposals:
            assert one.design.gear == GEAR
            assert float(one.design.pair.offset) == offset
            assert float(one.design.pair.shaft_angle) == radians(7.0)


def test_gear_with_a_parabola_is_checked_completely() -> None:
    """Pairs with a gear that has a parabola are checked completely: edges touch earlier with a concave gear,
    which the criteria of unmodified flanks do not show, and not with a convex one."""
    gears = [replace(GEAR, tool=replace(GEAR.tool, parabola=parabola)) for parabola in (0.001, -0.001)]
    assert not works(replace(MARINE, offset=180.0, gear=gears[0]))
    request = replace(MARINE, offset=180.0, gear=gears[1])
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


def test_tips_that_interfere_are_not_proposed() -> None:
    """Tips of wide faces at large shaft angles are deepest within a few modules.

    Each pair of the second request has tips that meet fillets outside the mesh, with 0.01 modules of flank
    left."""
    assert_sound(TIPS["steep"], propose(TIPS["steep"]))
    assert not works(TIPS["past the mesh"])


def test_tip_rounds_at_a_large_pressure_angle() -> None:
    request = replace(FIRST, pressure_angle=radians(25.0))
    proposals = propose(request, 1)
    assert_sound(request, proposals)
    assert proposals[0].design.pinion.tool.tip_radius == 0.31
    assert FIRST.members[0].tool.tip_radius == 0.38


def test_least_cones() -> None:
    """The larger cone angle is smallest if both are equal: 1.8916 deg for helix angle and layout of Table
    1."""
    request = replace(TABLE1, crossing=None, least_cones=True)
    first = propose(request, 1)[0].design
    least = max(abs(float(member.cone_angle)) for member in first.members)
    assert degrees(least) == pytest.approx(1.8916, abs=1e-3)
    assert np.isclose(first.pinion.cone_angle, first.gear.cone_angle, atol=1e-9)
    pairs = candidates_of(request)
    assert np.abs(pairs[:2]).max(axis=0).min() > least - 1e-9


def test_criteria() -> None:
    one = propose(TABLE1, 1)[0]
    for k, flank in enumerate(("right", "left")):
        path = path_of_contact(one.design, flank, 3)
        assert path.ends.status == Status.SOLVED
        assert one.criteria.contact_ratio[k, 0] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
        assert one.criteria.normal_x[k, 0] == pytest.approx(path.normal[1, 0], abs=1e-9)
        crossing = float(generator_angle_as_mounted(one.design, flank))
        assert one.criteria.crossing[k, 0] == pytest.approx(crossing, abs=1e-9)


def test_limits_are_kept() -> None:
    most = radians(35.0)
    request = replace(FIRST, helix_limits=Bounds(-most, most), shift_limits=Bounds(0.3, 0.7))
    for one in propose(request, 1):
        for member in one.design.members:
            assert abs(float(member.helix_angle)) <= most + 1e-9
            assert 0.3 - 1e-9 <= float(member.profile_shift) <= 0.7 + 1e-9


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


def test_pairs_on_parallel_axes_need_no_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    """No certificate is computed for pairs on parallel axes, and all proposals satisfy it. Their tips are
    clear of the fillets; certificates close to line contact take long."""
    request = Request(
        module=2.0,
        teeth=(39, 63),
        face_widths=(16.0, 16.0),
        shaft_angle=0.0,
        backlash=0.0208417,
        offset=101.588,
        flank="left",
        cone_angles=(radians(5.60384), radians(-5.60384)),
        helix_angle=radians(7.82186),
    )
    called: list[object] = []
    monkeypatch.setattr("beveloid_geom.findings.advice.path_certificate", called.append)
    with pytest.raises(Refused, match="below the active flank") as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest is not None
    proposals = propose(nearest)
    assert called == []
    for one in proposals:
        for flank in ("right", "left"):
            assert path_certificate(path_of_contact(one.design, flank, 9)).holds


def test_smallest_helix_angle_is_first_among_equal_pairs() -> None:
    """Among pairs with equal reserves, the pair with the smallest helix angle comes first. Many pairs on
    parallel axes have line contact and the largest reserve."""
    proposals = propose(replace(PARALLEL, cone_angles=None, least_cones=True))
    assert [round(float(one.criteria.reserve[0]), 2) for one in proposals] == [1.0] * 3
    helices = [abs(float(one.design.pinion.helix_angle)) for one in proposals]
    assert helices == sorted(helices)
    assert degrees(helices[0]) < 6.0


@pytest.mark.parametrize("number", [3, 9, 32])
def test_pairs_near_the_limits_are_found(number: int) -> None:
    """The pairs of these requests without a warning lie in a corner of the limits or on a short curve."""
    request = list(random_requests(number + 1, seed=1))[number]
    assert_sound(request, propose(request, 1))


def test_nearly_parallel_axes() -> None:
    """At 0.1 deg an error of 0.01 deg moves a path by metres; the nearest request has parallel axes."""
    request = replace(PARALLEL, shaft_angle=radians(0.1), cone_angles=None, least_cones=True)
    with pytest.raises(Refused, match="sensitive to errors") as refused:
        propose(request)
    nearest = refused.value.nearest
    assert nearest == replace(request, shaft_angle=0.0)
    assert_sound(nearest, propose(nearest, 1))


def test_command_line_of_a_request() -> None:
    assert command_of(TABLE1) == (
        "beveloid-geom propose --module 6 --teeth 29 45 --face-widths 50 60 --shaft-angle-deg 15 --offset 229"
        " --backlash 0.0416 --helix-deg 25 --crossing-deg 2.2957 --shifts 0.17 0.2181"
    )
    assert command_of(replace(MARINE, offset=0.0), "my gear.toml").endswith("--gear 'my gear.toml'")


def test_requests_like_a_design_without_contact() -> None:
    astray = replace(builtin_design(), pair=replace(builtin_design().pair, shaft_angle=radians(14.0)))
    first, second = requests_like(astray)
    assert (first.least_cones, first.offset, second.offset) == (True, 229.0, None)
    assert_sound(first, propose(first, 1))
    tool = replace(astray.gear.tool, dedendum=1.3)
    assert requests_like(replace(astray, gear=replace(astray.gear, tool=tool))) == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", REQUESTS)
def test_all_kinds_of_requests(name: str) -> None:
    if name == "cones at an offset":  # its shifts leave one helix angle, which causes a warning
        with pytest.raises(Refused):
            propose(REQUESTS[name])
        return
    assert_sound(REQUESTS[name], propose(REQUESTS[name]))
