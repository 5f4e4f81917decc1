"""Deviation of designs from closed layouts.

The oracles are the lines of action of the mounting, solved by another method, independently computed numbers,
and the parallel-axis formulas of handbooks.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from beveloid_geom import Design, Errors, Member, Pair, Tool, builtin_design, zero_backlash_layout
from beveloid_geom.arrays import FloatArray, Quantity
from beveloid_geom.findings.diagnostics import tip_clearances
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.gear.fillet import root_radius
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.pair.frames import layout_of, member_frame, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import (
    LayoutDeviation,
    ZeroBacklashLayout,
    closed_layout,
    layout_deviation,
)
from tests.oracle.table1 import table1
from tests.symmetry import scaled

TABLE1 = builtin_design()


def made(
    helix: tuple[float, float],
    cone: tuple[float, float] = (0.0, 0.0),
    teeth: tuple[int, int] = (29, 45),
    shift: tuple[float, float] = (0.17, 0.2181),
    alpha: tuple[float, float] = (20.0, 20.0),
) -> Design:
    """Return a pair whose layout is arbitrary; angles in degrees. Its tools have the same base pitch."""
    members = []
    for j in range(2):
        angle = math.radians(alpha[j])
        tool = Tool(6.0 * math.cos(math.radians(alpha[0])) / math.cos(angle), angle)
        turned = math.radians(helix[j]), math.radians(cone[j])
        members.append(Member(tool, teeth[j], *turned, shift[j], 40.0))
    return Design(members[0], members[1], Pair(200.0, 0.3))


DESIGNS = {
    "table 1": TABLE1,
    "left hand": made((-25.0, 10.57), (3.0, 0.8)),
    "steep cones": made((25.0, -10.57), (9.0, 6.0)),
    "same hand": made((30.0, 20.0), (4.0, 2.0)),
    "cylindrical": made((25.0, -10.57)),
    "one cylindrical": made((25.0, -10.57), (3.0, 0.0)),
    "thin end outside": made((25.0, -10.57), (-3.0, 5.0)),
    "right angle": made((50.0, 40.0), (2.0, 1.0), (8, 30)),
    "two tools": made((25.0, -10.57), (3.0, 0.8), alpha=(20.0, 22.5)),
}


def laid_out(design: Design, offset: Quantity, shaft_angle: Quantity) -> Design:
    return replace(design, pair=Pair(offset, shaft_angle))


def without_backlash(design: Design) -> tuple[ZeroBacklashLayout, Design]:
    layout = zero_backlash_layout(design)
    return layout, laid_out(design, float(layout.offset), float(layout.shaft_angle))


@pytest.mark.parametrize("name", DESIGNS)
def test_layout_without_backlash_is_one(name: str) -> None:
    layout, design = without_backlash(DESIGNS[name])
    mounting = mounting_of(design)
    assert abs(mounting.gap) < 1e-8
    assert abs(mounting.normal_backlash) < 1e-10
    assert abs(layout.normal_backlash) < 1e-11
    np.testing.assert_allclose(layout.working_radius, mounting.working_radius, rtol=0, atol=1e-8)
    np.testing.assert_allclose(layout.mounting, mounting.distance, rtol=0, atol=1e-8)
    closing = layout_deviation(design)
    assert closing.reasons == ()
    assert closing.gap < 1e-8
    assert abs(closing.offset_difference) < 1e-9
    assert abs(closing.shaft_angle_difference) < 1e-10


@pytest.mark.parametrize("name", DESIGNS)
def test_layouts_with_backlash_close_too(name: str) -> None:
    """The lines of action also meet in layouts with backlash: with 0.5 deg more working pressure angle, the
    teeth have clearance."""
    base = zero_backlash_layout(DESIGNS[name])
    wider = closed_layout(DESIGNS[name], base.pressure_angle + math.radians(0.5))
    mounting = mounting_of(laid_out(DESIGNS[name], float(wider.offset), float(wider.shaft_angle)))
    assert abs(mounting.gap) < 1e-8
    assert wider.normal_backlash > 0.05
    assert mounting.normal_backlash == pytest.approx(float(wider.normal_backlash), abs=1e-9)


def test_cylindrical_gears_close_at_any_axial_position() -> None:
    layout, design = without_backlash(DESIGNS["cylindrical"])
    np.testing.assert_array_equal(layout.mounting, 0.0)
    moved = replace(design, pair=replace(design.pair, pinion_mounting=12.5, gear_mounting=-30.0))
    assert abs(mounting_of(moved).normal_backlash) < 1e-10


def test_table_1_nearly_closes() -> None:
    closing = layout_deviation(TABLE1)
    assert closing.gap == pytest.approx(2.21, abs=0.005)
    assert closing.offset == pytest.approx(229.0751, abs=5e-5)
    assert closing.offset_difference == pytest.approx(0.0751, abs=5e-5)
    assert math.degrees(closing.shaft_angle_difference) == pytest.approx(-0.0021, abs=5e-5)
    assert closing.normal_backlash == pytest.approx(0.0416, abs=5e-5)


@pytest.mark.parametrize("shaft_angle_deg", [14.9, 14.95, 15.0, 15.2])
def test_closing_is_where_the_gap_changes_sign(shaft_angle_deg: float) -> None:
    """The offset and the shaft angle at which the lines meet are roots of the signed gap of the two lines of
    action, which is linear in the offset."""

    def gap(offset: float, shaft_angle: Quantity) -> float:
        return float(mounting_of(laid_out(TABLE1, offset, shaft_angle)).gap)

    design = laid_out(TABLE1, 229.0, math.radians(shaft_angle_deg))
    closing = layout_deviation(design)
    assert closing.gap == pytest.approx(abs(gap(229.0, design.pair.shaft_angle)))
    offset = brentq(gap, 215.0, 240.0, args=(design.pair.shaft_angle,), xtol=1e-13)
    assert closing.offset == pytest.approx(offset, abs=1e-9)
    angle = brentq(lambda d: gap(229.0, d), math.radians(14.9), math.radians(15.2), xtol=1e-15)
    assert closing.shaft_angle == pytest.approx(angle, abs=1e-11)


def test_errors_and_parabolas_change_nothing() -> None:
    changed = TABLE1.with_errors(Errors(offset=0.5, shaft_angle=0.01, gear_axial=1.0)).with_parabola(
        1e-3, 2e-3
    )
    assert layout_deviation(changed) == layout_deviation(TABLE1)
    np.testing.assert_array_equal(zero_backlash_layout(changed).offset, zero_backlash_layout(TABLE1).offset)


def test_no_common_normal_has_a_reason() -> None:
    closing = layout_deviation(laid_out(TABLE1, 229.0, math.radians(14.0)))
    assert math.isnan(closing.gap)
    assert math.isnan(closing.offset)
    assert "no common normal at a shaft angle of 14 deg" in closing.reasons[0]
    assert math.degrees(closing.shaft_angle) == pytest.approx(14.9979, abs=5e-5)


def test_offset_that_no_shaft_angle_closes_has_a_reason() -> None:
    closing = layout_deviation(laid_out(TABLE1, 20.0, math.radians(15.0)))
    assert math.isnan(closing.shaft_angle)
    assert closing.reasons == ("the lines of action meet at no shaft angle with an offset of 20 mm",)


def test_teeth_too_thin_for_any_layout() -> None:
    thin = made((25.0, -10.57), (3.0, 0.8), shift=(-1.0, -1.0))
    with pytest.raises(ValueError, match="no layout without backlash"):
        zero_backlash_layout(thin)


def warnings_on(design: Design) -> list[str]:
    return [remark.text for remark in remarks_on(design) if remark.level != "note"]


@pytest.mark.parametrize(
    ("off", "turned_deg", "noted"),
    [(0.0, 0.0, False), (0.09, 0.009, False), (0.11, 0.0, True), (0.0, 0.011, True), (-0.11, -0.011, True)],
)
def test_lines_apart_are_noted_past_a_tenth_or_a_hundredth(
    off: float, turned_deg: float, noted: bool
) -> None:
    closing = LayoutDeviation(0.5, 0.0, 229.0 + off, off, 0.26, math.radians(turned_deg))
    found = remarks_on(TABLE1, closing)
    assert bool(found) is noted
    assert all(remark.level == "note" for remark in found)
    assert not noted or "the lines of action pass each other at 0.5 mm" in found[0].text


def test_interference_gives_a_warning() -> None:
    layout, design = without_backlash(TABLE1)
    tight = replace(design.pinion, profile_shift=design.pinion.profile_shift + 0.01)
    assert "interfere by" in " ".join(warnings_on(replace(design, pinion=tight)))
    assert warnings_on(design) == []
    assert layout.normal_backlash == pytest.approx(0.0, abs=1e-11)


def with_pinion(teeth: int, profile_shift: float, helix: float = 25.0, cone: float = 3.0) -> Design:
    turned = math.radians(helix), math.radians(cone)
    return replace(TABLE1, pinion=Member(TABLE1.pinion.tool, teeth, *turned, profile_shift, 50.0))


def test_pointed_and_thin_teeth_have_different_warnings() -> None:
    """Profile shift thins the tip; a cone thins it further towards the heel."""
    pointed = remarks_on(with_pinion(11, 1.2))
    found = [remark for remark in pointed if "tooth" in remark.text]
    assert [remark.level for remark in found] == ["warning", "warning"]  # 0.03 modules are a warning, too
    assert found[0].text.startswith("the tooth of the pinion is pointed at the heel, from -21.36 mm on")
    assert found[1].text == "the tooth tip of the pinion is thin: 0.188 mm, 0.031 modules, at the toe"


def test_undercut_remark_names_place_and_amount() -> None:
    convex = [text for text in warnings_on(TABLE1.with_parabola(-0.01, 0.0)) if "undercut" in text]
    where = "the right flank of the pinion is undercut from z = -25 to 19.91 mm"
    assert convex[0].startswith(f"{where}, it loses up to 2.15 mm of its length along the profile")
    assert convex[1].startswith("the left flank of the pinion is undercut from z = -25 to -7.137 mm")
    assert len(convex) == 2


@pytest.mark.parametrize(
    ("module", "teeth", "shifts", "tool", "words"),
    [
        (4.5, (16, 24), (0.1818, 0.1714), (0.979, 1.39), "ends before it reaches the undercut of the pinion"),
        (2.0, (12, 40), (0.0, 0.0), (1.0, 1.25), "ends at the undercut of the pinion"),
    ],
)
def test_undercut_that_ends_a_path_has_its_note(
    module: float, teeth: tuple[int, int], shifts: tuple[float, float], tool: tuple[float, float], words: str
) -> None:
    cutter = Tool(module, math.radians(20.0), *tool, tip_radius=0.25)
    members = [Member(cutter, n, 0.0, 0.0, x, 14.0) for n, x in zip(teeth, shifts, strict=True)]
    offset = 0.5 * module * sum(teeth) + module * sum(shifts)
    design = Design(members[0], members[1], Pair(offset, 0.0))
    found = [remark for remark in remarks_on(design) if "undercut" in remark.text]
    assert [remark.level for remark in found] == ["warning", "warning", "note", "note"]
    assert "along the complete face, it loses up to" in found[0].text
    assert found[2].text == f"the path of contact of the right flanks {words}"


def test_tip_clearance_of_cylindrical_gears() -> None:
    """On crossed cylindrical gears, the tip clearance is the part of the offset that tip radius and root
    radius leave on the common perpendicular."""
    _, design = without_backlash(DESIGNS["cylindrical"])
    radii = [6.0 * m.teeth / (2.0 * math.cos(m.helix_angle)) + 6.0 * m.profile_shift for m in design.members]
    expected = float(design.pair.offset) - sum(radii) - 6.0 + 7.5
    np.testing.assert_allclose(tip_clearances(design), expected, atol=2e-3)
    assert (tip_clearances(design) >= expected - 1e-9).all()


@pytest.mark.parametrize("first", [0, 1])
def test_tip_clearance_is_the_distance_of_two_cones(first: int) -> None:
    """The tip clearance equals the smallest distance of a point of one cone from the other, by a general
    minimiser."""
    layout, stands = layout_of(TABLE1), mounting_of(TABLE1).distance
    frames = [member_frame(layout, j, 0.0, stands[j]) for j in (0, 1)]
    radius_of = (tip_radius, root_radius) if first == 0 else (root_radius, tip_radius)

    def points(at: FloatArray) -> list[FloatArray]:
        found = []
        for j, member in enumerate(TABLE1.members):
            z, turn = at[2 * j : 2 * j + 2]
            radius = float(radius_of[j](member, z))
            found.append(to_fixed(frames[j], np.array([radius * np.cos(turn), radius * np.sin(turn), z])))
        return found

    def distance(at: FloatArray) -> float:
        one, other = points(at)
        return float(np.linalg.norm(one - other))

    bounds = [(-25.0, 25.0), (-0.5, 0.5)] * 2
    least = minimize(distance, np.zeros(4), bounds=bounds, method="L-BFGS-B", options={"ftol": 1e-15}).fun
    assert tip_clearances(TABLE1)[first] == pytest.approx(least, abs=2e-3)


def test_small_clearance_is_a_note_and_a_negative_one_a_warning() -> None:
    for dedendum, level, text in (
        (1.1, "note", "the tip clearance of the gear is small: 0.5"),
        (0.95, "warning", "the tips of the gear overlap the bottom lands of the pinion by 0.3"),
    ):
        tool = replace(TABLE1.pinion.tool, dedendum=dedendum, tip_radius=0.2)
        found = [
            r
            for r in remarks_on(replace(TABLE1, pinion=replace(TABLE1.pinion, tool=tool)))
            if "tip clearance" in r.text or "bottom lands" in r.text
        ]
        assert [(remark.level, remark.text.startswith(text)) for remark in found] == [(level, True)]


@pytest.mark.parametrize("size", [0.01, 100.0])
def test_remarks_do_not_depend_on_size(size: float) -> None:
    for difference in (0.09, 0.11):
        design = replace(table1(), pair=Pair(229.075 + difference, math.radians(15.0)))
        told, also = ([r.level for r in remarks_on(each)] for each in (design, scaled(design, size)))
        assert told == also
