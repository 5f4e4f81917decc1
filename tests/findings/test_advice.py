"""Remarks and advice of `check` on layouts without contact; the advice is applied by the fields of its
JSON."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies

from beveloid_geom import Design, Pair, Status, builtin_design, path_of_contact, zero_backlash_layout
from beveloid_geom.design.file import parse_design
from beveloid_geom.findings.advice import design_remarks
from beveloid_geom.findings.diagnostics import in_order, quiet
from beveloid_geom.findings.layout import INTERFERENCE_TOLERANCE_MODULES, lines_meet, remarks_on
from beveloid_geom.findings.reach import reach_of
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.report.check import check_report
from beveloid_geom.report.result import strict
from tests.validation.test_intersecting_axes import FILE

TABLE1 = builtin_design()
FLANKS = ("right", "left")


def laid_out(offset: float = 229.0, shaft_angle_deg: float = 15.0, gear_helix_deg: float = -10.57) -> Design:
    gear = replace(TABLE1.gear, helix_angle=radians(gear_helix_deg))
    return replace(TABLE1, gear=gear, pair=Pair(offset, radians(shaft_angle_deg)))


TRIAL = {
    **{f"{angle} deg": laid_out(shaft_angle_deg=angle) for angle in (14.0, 16.0, 20.0, 30.0, 45.0)},
    "gear of the other hand": laid_out(gear_helix_deg=10.57),
    "offset halved": laid_out(offset=114.5),
    "offset doubled": laid_out(offset=458.0),
    "offset 0.3 mm less": laid_out(offset=228.7),
}


def checked(design: Design) -> Any:
    return strict(check_report("trial", design).data())


def followed(design: Design, advice: dict[str, Any]) -> Design:
    """Return the design with the fields of a piece of advice."""
    pinion = replace(design.pinion, helix_angle=advice["pinion_helix_angle"])
    gear = replace(design.gear, helix_angle=advice["gear_helix_angle"])
    return replace(design, pinion=pinion, gear=gear, pair=Pair(advice["offset"], advice["shaft_angle"]))


def assert_sound(design: Design) -> None:
    """Check that the lines of action meet, the gears reach each other, both flanks have contact, and
    nothing interferes."""
    deviation, module = layout_deviation(design), float(design.pinion.tool.normal_module)
    assert lines_meet(design, deviation)
    assert deviation.normal_backlash > -INTERFERENCE_TOLERANCE_MODULES * module
    reach = reach_of(design)
    assert reach.bottoming < float(design.pair.offset) < reach.touching
    for flank in FLANKS:
        path = path_of_contact(design, flank, 11)
        assert path.ends.status == Status.SOLVED
        assert path.ends.contact_ratio > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", TRIAL)
def test_advice_leads_to_a_pair_without_warnings(name: str) -> None:
    design = TRIAL[name]
    data = checked(design)
    assert data["errors"] or data["warnings"]
    assert 1 <= len(data["advice"]) <= 3
    for advice in data["advice"]:
        changed = followed(design, advice)
        assert_sound(changed)
        again = checked(changed)
        assert again["errors"] == again["warnings"] == again["advice"] == []


@pytest.mark.slow
@pytest.mark.parametrize("angle", [16.0, 20.0, 30.0, 45.0])
def test_shaft_angle_that_does_not_fit_the_helix_angles(angle: float) -> None:
    """The first advice changes a helix angle and keeps the shaft angle."""
    advice = checked(TRIAL[f"{angle} deg"])["advice"][0]
    assert advice["change"] == "helix angle of the gear"
    assert degrees(advice["shaft_angle"]) == pytest.approx(angle, abs=1e-9)
    assert degrees(advice["pinion_helix_angle"]) == pytest.approx(25.0)
    layout = zero_backlash_layout(followed(TABLE1, advice))
    assert degrees(float(layout.shaft_angle)) == pytest.approx(angle, abs=1e-4)
    assert float(layout.offset) == pytest.approx(advice["offset"], abs=1e-3)


def test_wrong_offset() -> None:
    for name in ("offset halved", "offset doubled"):
        advice = checked(TRIAL[name])["advice"][0]
        assert advice["change"] == "offset"
        assert advice["offset"] == pytest.approx(229.0751, abs=5e-5)


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_wrong_mounting_distance(member: str) -> None:
    pair = replace(TABLE1.pair, **{f"{member}_mounting": 320.0})
    advice = checked(replace(TABLE1, pair=pair))["advice"][0]
    assert advice["change"] == "mounting distances to those of the pitch point"


def test_offsets_out_of_reach() -> None:
    """The tips of crossed cylinders meet at an offset equal to the sum of their radii."""
    plain = replace(
        TABLE1,
        pinion=replace(TABLE1.pinion, cone_angle=0.0),
        gear=replace(TABLE1.gear, cone_angle=0.0),
    )
    reference = [6.0 * m.teeth / (2.0 * np.cos(m.helix_angle)) + 6.0 * m.profile_shift for m in plain.members]
    tips = float(sum(reference)) + 12.0
    assert reach_of(plain).touching == pytest.approx(tips, abs=1e-9)
    assert reach_of(plain).bottoming == pytest.approx(tips - 13.5, abs=1e-9)
    deep = replace(plain, pinion=replace(plain.pinion, tool=replace(plain.pinion.tool, dedendum=1.6)))
    assert reach_of(deep).bottoming == pytest.approx(tips - 13.5, abs=1e-9)  # set by the root of the gear
    far = remarks_on(replace(plain, pair=Pair(tips + 110.0, radians(15.0))))
    assert far[0].text == "there is no contact on the right and left flanks"
    assert far[1].text.startswith("the gears are too far apart by 110 mm")
    near = remarks_on(replace(plain, pair=Pair(tips - 13.5 - 8.0, radians(15.0))))
    assert near[1].text.startswith("the gears overlap by 8 mm")


def test_sum_of_helix_angles_that_fits() -> None:
    errors = checked(TRIAL["30.0 deg"])["errors"]
    words = next(text for text in errors if "follows from the helix angles" in text)
    assert "+25 and -10.57 deg, working helix angles 14.57 deg in total, give 14.99 deg" in words
    assert words.endswith("for 30 deg their sum must be 29.80 deg")


def test_remarks_are_sorted_by_level() -> None:
    found = design_remarks(TRIAL["offset doubled"].with_parabola(-0.01, 0.0))
    levels = [remark.level for remark in found]
    assert levels == sorted(levels, key=("error", "unknown", "warning", "note").index)
    assert found[0].text.startswith("there is no contact")
    assert [remark.level for remark in in_order([*found[::-1], *found])] == levels


@settings(max_examples=40, deadline=None)
@given(
    offset=strategies.floats(20.0, 900.0),
    shaft_angle=strategies.floats(1.0, 89.0),
    helix=strategies.floats(-40.0, 40.0),
    closed=strategies.booleans(),
)
def test_layouts_without_contact_or_with_overlap_have_remarks(
    offset: float, shaft_angle: float, helix: float, closed: bool
) -> None:
    """Random layouts; half of them at the offset at which the lines of action meet."""
    design = laid_out(offset, shaft_angle, helix)
    meeting = layout_deviation(design).offset
    if closed and np.isfinite(meeting) and meeting > 0.0:
        design = replace(design, pair=Pair(meeting, radians(shaft_angle)))
    contact = all(path_of_contact(design, flank, 2).ends.status == Status.SOLVED for flank in FLANKS)
    backlash = float(mounting_of(design).normal_backlash)
    if not contact or backlash < -INTERFERENCE_TOLERANCE_MODULES * 6.0:
        assert not quiet(remarks_on(design))


def test_lines_of_action_that_meet_out_of_reach() -> None:
    """At 30 deg the lines of action meet at 493.8941 mm, where the gears do not reach each other."""
    design = TRIAL["30.0 deg"]
    meeting = replace(design, pair=replace(design.pair, offset=layout_deviation(design).offset))
    assert layout_deviation(meeting).gap < 1e-9
    assert mounting_of(meeting).normal_backlash > 0.0
    texts = [remark.text for remark in remarks_on(meeting)]
    assert any(text.startswith("the gears are too far apart by 248.") for text in texts), texts


MEETING = parse_design(
    FILE.format(module=6.0, teeth=(24, 61), helix=(15.0, -15.0), cone=(2.0, 5.0), face=60.0, shaft=7.0)
)


def meeting(
    offset: float = 0.0, shaft_angle_deg: float = 7.0, gear_helix_deg: float = -15.0, shift: float = 0.0
) -> Design:
    gear = replace(MEETING.gear, helix_angle=radians(gear_helix_deg), profile_shift=shift)
    return replace(MEETING, gear=gear, pair=Pair(offset, radians(shaft_angle_deg)))


NO_CONTACT = {
    "offset 20 mm": (meeting(offset=20.0), "the gears are too far apart by 20 mm"),
    "15 deg": (meeting(shaft_angle_deg=15.0), "2 and 5 deg give 7 deg, not 15 deg"),
    "1 deg": (meeting(shaft_angle_deg=1.0), "2 and 5 deg give 7 deg, not 1 deg"),
    "same hand": (meeting(gear_helix_deg=5.0), "helix angles that nearly cancel, +15 and +5 deg do not"),
    "profile shift": (meeting(shift=0.3), "the pair cannot be assembled"),
    "0.1 deg of helix": (meeting(gear_helix_deg=-15.1), "the pair cannot be assembled"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NO_CONTACT)
def test_advice_for_intersecting_axes(name: str) -> None:
    design, reason = NO_CONTACT[name]
    data = checked(design)
    assert reason in " ".join((*data["errors"], *data["warnings"]))
    assert any(advice["offset"] == 0.0 for advice in data["advice"])
    layouts = [{key: advice[key] for key in advice if key != "change"} for advice in data["advice"]]
    assert all(layouts[k] not in layouts[:k] for k in range(len(layouts)))
    for advice in data["advice"]:
        again = checked(followed(design, advice))
        assert again["errors"] == again["warnings"] == again["advice"] == []


def test_pair_on_intersecting_axes_without_advice() -> None:
    assert checked(MEETING)["advice"] == checked(MEETING)["errors"] == checked(MEETING)["warnings"] == []
