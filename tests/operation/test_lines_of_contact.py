"""Operation on parallel axes with lines of contact, and under errors that tilt the axes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import cos, radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Tool,
    builtin_design,
    contact_pattern,
    contact_ratio,
    first_contact,
    mesh_cycle,
    mounted_backlash,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.findings.path import reason_of
from beveloid_geom.operation.operating_ratio import operating_ratios
from beveloid_geom.pair.generator_angle import generator_angle_as_mounted
from beveloid_geom.report.operation import operation_report
from beveloid_geom.status import FirstStatus, RatioStatus
from tests.operation.test_first_contact_by_bisection import assert_first
from tests.oracle.table1 import table1
from tests.stability.parallel_pairs import (
    FLANKS,
    HELICAL,
    nearly_parallel_pairs,
    pair_of,
    parallel_pairs,
    ratios_of_iso,
)

FILM, ALPHA = 0.00635, radians(20.0)
"""mm, rad"""


NAMED = {
    "helical": HELICAL,
    "helical, cones": pair_of(3.0, (25, 50), 15.0, 116.6, cone_deg=2.0),
    "wide backlash": pair_of(3.0, (28, 59), 20.0, 139.878, (0.4, -0.11)),
    "shifted": pair_of(3.0, (25, 40), 30.0, 113.37464, (0.3, -0.1)),
    "published": pair_of(3.0, (12, 60), 30.0, 125.0, (0.09809, 0.0)),
    "negative cone": pair_of(
        2.7816311444037716,
        (32, 30),
        -27.055781498536415,
        98.10349166842948,
        (-0.1573004694119586, 0.5568263418535662),
        (28.98900081975493, 25.802996244359058),
        -1.2562583234168176,
        14.5,
    ),
    "four teeth": replace(
        pair_of(
            10.06052456344726,
            (36, 4),
            18.385855914176524,
            219.75534750564933,
            (0.0025622369255559607, 0.7930279927229291),
            (58.398263679814804, 96.10750226394552),
            -0.38177540882183925,
            22.5,
        ),
        errors=Errors(-0.023200149004141222, 0.0, -0.045953141465221926, 0.0005442123389159085),
    ),
}


def assert_along_lines(designs: Iterable[Design]) -> int:
    """Check that both flanks of all designs touch along lines, at the contact ratio of ISO 21771. Return
    the number of designs with cones."""
    cones = 0
    for design in designs:
        cones += bool(design.pinion.cone_angle)
        for flank in FLANKS:
            found = operating_ratios(design, flank, (0.0, FILM))
            cycle, ratio = found.cycle, found.ratio
            assert cycle.status == FirstStatus.SOLVED
            assert bool(cycle.along_lines), (design, flank)
            assert cycle.peak_to_peak < 1e-12
            assert cycle.edge_share == 0.0
            assert not cycle.hand_over.any()
            assert (found.status == RatioStatus.KNOWN).all(), (design, flank)
            # With cones, compare with the ratio of the path, which is tested against the five equations.
            total = contact_ratio(design, flank) if design.pinion.cone_angle else sum(ratios_of_iso(design))
            assert abs(float(ratio[0]) - float(total)) < 1e-9
            assert np.isfinite(ratio[1])
            assert ratio[1] > ratio[0]
    return cones


@pytest.mark.parametrize("name", NAMED)
def test_named_pairs_run_along_lines(name: str) -> None:
    assert_along_lines([NAMED[name]])


def test_published_ratios() -> None:
    """Contact ratios in operation equal the published ratio of a pair from a gear catalogue, and the ratio of
    a helical pair by an independent program."""
    for name, ratio in (("published", 2.886210), ("helical", 2.38712243947)):
        found = operating_ratios(NAMED[name], "right", (0.0,)).ratio[0]
        assert float(found) == pytest.approx(ratio, abs=5e-7 if name == "published" else 1e-10)


def test_random_parallel_pairs_run_along_lines() -> None:
    assert assert_along_lines(parallel_pairs(12, 3)) > 1


@pytest.mark.slow
def test_many_parallel_pairs() -> None:
    assert assert_along_lines(parallel_pairs(40, 4)) > 8


@pytest.mark.parametrize("name", ["helical", "helical, cones"])
def test_first_contacts_are_points_of_the_path(name: str, flank: str) -> None:
    """First contacts are the points of the path of the pair that came into mesh last, by searches and in the
    mesh cycle. Nothing touches earlier."""
    design = NAMED[name]
    path = path_of_contact(design, flank, 41)
    roll = path.pinion_roll[1:11]  # within 0.6 pitches after the pair comes into mesh
    first, cycle = first_contact(design, flank, roll), mesh_cycle(design, flank)
    for found in (first, cycle.at(roll)):
        assert (found.status == FirstStatus.SOLVED).all()
        assert (found.limit == -1).all()
        assert (found.pair == 0).all()
        np.testing.assert_allclose(found.point, path.point[1:11], atol=1e-9)
        np.testing.assert_allclose(found.gear_roll, path.gear_roll[1:11], atol=1e-14)
    assert path_certificate(path).holds
    assert path_certificate(path_of_contact(design, flank, 7)).holds
    assert assert_first(design, flank, roll[3:5], (20, 60, 41)) < 3e-3


def test_report_and_pattern_of_lines() -> None:
    report = operation_report("helical", HELICAL, "right", 25, 5, FILM)
    assert set(report.carriers) == {"a line"}
    assert "several pairs are in contact" in report.summary()
    pattern = contact_pattern(HELICAL)
    assert pattern.pinion.area_share > 0.98
    assert np.nanmax(np.abs(pattern.pinion.least[pattern.pinion.marked])) < FILM


def deep_pair(helix_deg: float, addendum: float) -> Design:
    """Return a pair in which the tips of the gear reach into the fillets of the pinion."""
    tools = Tool(3.0, ALPHA, tip_radius=0.3), Tool(3.0, ALPHA, addendum=addendum, tip_radius=0.3)
    pinion, gear = (
        Member(tool, teeth, side * radians(helix_deg), 0.0, shift, 20.0)
        for tool, teeth, side, shift in zip(tools, (30, 60), (1.0, -1.0), (0.1, 0.0), strict=True)
    )
    return Design(pinion, gear, Pair(1.5 * 90.0 / np.cos(radians(helix_deg)) + 0.35, 0.0))


@pytest.mark.parametrize("name", ["helical", "shifted"])
def test_pattern_reaches_common_ends_of_the_face(name: str, flank: str) -> None:
    """At a common end of both faces, the pattern spans the same depth as in the middle of the face."""
    pattern = contact_pattern(NAMED[name], flank)
    for member in (pattern.pinion, pattern.gear):
        touched = np.isfinite(member.least) & (member.least < 1e-7)
        gaps = [np.diff(np.flatnonzero(touched[:, end])) for end in (0, -1)]
        assert all(len(gap) > 10 and (gap == 1).all() for gap in gaps)


@pytest.mark.parametrize(
    ("helix_deg", "addendum", "edges"), [(10.0, 1.2, 1.0), (10.0, 1.18, 0.547), (0.0, 1.2, 0.596)]
)
def test_tips_in_fillets_come_before_lines(helix_deg: float, addendum: float, edges: float) -> None:
    """Tips that reach into fillets touch before the lines, over the complete cycle or a part of it, as a
    brute-force search over both surfaces finds."""
    design = deep_pair(helix_deg, addendum)
    cycle = mesh_cycle(design, "right")
    assert cycle.status == FirstStatus.SOLVED
    assert not cycle.along_lines
    assert float(cycle.edge_share) == pytest.approx(edges, abs=1e-3)
    roll = float(cycle.start) + cycle.pitch * np.array((0.1, 0.4, 0.6, 0.8, 0.875))
    first, held = cycle.at(roll), cycle.at(roll).limit[:, 0] >= 0
    assert held.any()
    assert (first.on_fillet.any(axis=-1) == held).all()
    assert (np.abs(first.transmission_error[~held]) < 1e-15).all()  # lines are in contact there
    np.testing.assert_allclose(first.gear_roll, first_contact(design, "right", roll).gear_roll, atol=1e-11)
    assert_first(design, "right", roll[::2], (60, 20, 41))
    assert not path_certificate(path_of_contact(design, "right", 7)).holds


def test_small_tilts_continue_the_lines(flank: str) -> None:
    """The transmission error is proportional to the tilt, down to the angle below which axes are parallel."""
    swings = []
    for tilt in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        found = operating_ratios(HELICAL.with_errors(Errors(shaft_angle=tilt)), flank, (FILM,))
        assert found.cycle.status == FirstStatus.SOLVED
        assert found.cycle.edge_share == pytest.approx(1.0)
        swings.append(float(found.cycle.peak_to_peak) / tilt)
    assert swings[-1] == pytest.approx(0.02771, rel=1e-3)
    assert np.abs(np.diff(swings)).max() < 2e-4
    level = operating_ratios(HELICAL, flank, (FILM,)).ratio[0]
    assert abs(float(found.ratio[0]) - float(level)) < 2e-6


def test_a_batch_of_tilted_and_parallel_mountings() -> None:
    tilt = np.array((0.0, 1e-5, 0.0, -1e-5))
    offset = np.array((0.0, 0.0, 0.2, 0.0))
    errors = Errors(offset=offset, shaft_angle=tilt)
    found = operating_ratios(HELICAL.with_errors(errors), "right", (0.0, FILM))
    assert found.cycle.along_lines.tolist() == [True, False, True, False]
    for k in range(4):
        one = Errors(float(offset[k]), float(tilt[k]))
        alone = operating_ratios(HELICAL.with_errors(one), "right", (0.0, FILM))
        np.testing.assert_allclose(found.ratio[:, k], alone.ratio, atol=1e-7)
        assert float(found.cycle.peak_to_peak[k]) == pytest.approx(float(alone.cycle.peak_to_peak), abs=1e-12)


CONVEX = HELICAL.with_parabola(-0.0005, -0.0005)


@pytest.mark.parametrize("degrees", [0.0, 1e-10, 1e-7, 1e-5, 1e-3, 1.0, 4.0])
def test_a_tilted_layout_has_a_transmission_error(degrees: float, flank: str) -> None:
    """The transmission error of unmodified flanks without a common normal near the face is relative to the
    pair on parallel axes."""
    cycle = mesh_cycle(replace(CONVEX, pair=replace(CONVEX.pair, shaft_angle=radians(degrees))), flank)
    level = mesh_cycle(CONVEX, flank)
    assert cycle.status == FirstStatus.SOLVED
    assert not cycle.lost
    tilt = 0.3 * radians(degrees) + 1e-13  # rad of the gear, from 30 mm of face
    assert abs(float(cycle.mean) - float(level.mean)) < tilt
    assert abs(float(cycle.peak_to_peak) - float(level.peak_to_peak)) < tilt
    if degrees == 1e-3:
        assert float(cycle.peak_to_peak) == pytest.approx(6.45e-6, rel=1e-3)
        assert np.isfinite(cycle.at(cycle.start + np.linspace(0.0, 0.2, 7)).transmission_error).all()


def test_the_transmission_error_is_continuous_where_the_common_normal_is_lost() -> None:
    """The transmission error of the right flanks of Table 1 is continuous where they lose their common
    normal, at a shaft angle between 14.83 and 14.85 deg."""
    table = table1((-0.001, -0.001))

    def laid_out(degrees: float) -> Design:
        pair = replace(table.pair, shaft_angle=radians(degrees), pinion_mounting=211.59, gear_mounting=210.21)
        return replace(table, pair=pair)

    lost, shared = 14.8, 14.9
    for _ in range(40):
        middle = 0.5 * (lost + shared)
        if np.isnan(generator_angle_as_mounted(laid_out(middle), "right")):
            lost = middle
        else:
            shared = middle
    at = [first_contact(laid_out(degrees), "right", 0.02) for degrees in (lost - 1e-6, lost, shared)]
    error = np.array([float(contact.transmission_error[0]) for contact in at])
    assert [int(contact.status[0]) for contact in at] == [FirstStatus.SOLVED] * 3
    assert np.abs(np.diff(error)).max() < 1e-5


def test_backlash_of_hardly_tilted_layouts() -> None:
    level = float(mounted_backlash(CONVEX).normal)
    tilted = replace(CONVEX, pair=replace(CONVEX.pair, shaft_angle=1e-6))
    assert float(mounted_backlash(tilted).normal) == pytest.approx(level, abs=1e-4)


TILT = Errors(
    -0.001623889547543522,
    radians(-0.004315071967856513),
    *(-0.03125527509163334, -0.019994625635074773),
)
VALLEYS = {
    "tilted": (
        pair_of(
            *(2.0700928088238393, (13, 22), 30.546456425833412, 43.20562908629057),
            shift=(0.5151924639246189, 0.03632030834800826),
            face=(21.870977962142756, 18.883916182879418),
            pressure_deg=25.0,
            tip_radius=0.3,
        )
        .with_parabola(0.0, 0.0001896386078772842)
        .with_errors(TILT),
        0.24045377355675612,
    ),
    "cones": (
        pair_of(
            *(7.74847288927552, (9, 60), 32.32816753754794, 319.0603527369567),
            shift=(0.5174587921726561, -0.2120113922549709),
            face=(163.72294901158878, 232.0359794310103),
            cone_deg=1.5128063347588245,
            pressure_deg=21.08217817920544,
            tip_radius=0.3,
        ).with_parabola(0.0, 5.66441747966033e-06),
        0.7230937195177376,
    ),
}
"""Parabolas on the gear only, and rolls of the pinion."""


@pytest.mark.parametrize("name", VALLEYS)
def test_both_ends_of_a_level_valley_are_searched(name: str) -> None:
    """Near a line of contact, the clearance decreases towards two edges by less than a scan resolves."""
    design, roll = VALLEYS[name]
    cycle = mesh_cycle(design, "left")
    first = first_contact(design, "left", roll)
    assert abs(float(first.gear_roll[0] - cycle.at([roll]).gear_roll[0])) * cycle.engagement.lever < 1e-9
    assert_first(design, "left", np.array([roll]), (4, 400, 61))


def assert_searches_agree(designs: Iterable[Design], rolls: int) -> None:
    """Check that single searches and the segments of the mesh cycle agree."""
    for number, design in enumerate(designs):
        flank, rng = FLANKS[number % 2], np.random.default_rng(number)
        cycle = mesh_cycle(design, flank)
        roll = float(cycle.start) + cycle.pitch * rng.uniform(0.0, 1.0, rolls)
        first = first_contact(design, flank, roll)
        if cycle.status == FirstStatus.MEETS_BOTTOM:
            continue
        assert cycle.status == FirstStatus.SOLVED, (number, design)
        assert (first.status == FirstStatus.SOLVED).all(), (number, design)
        late = np.abs(first.gear_roll - cycle.at(roll).gear_roll).max()
        assert late < 1e-9, (number, design, late)


@pytest.mark.parametrize(
    ("helix_deg", "parabola", "offset"),
    [
        (0.0, (-0.001, 0.0), 60.5),
        (0.0, (0.0, -0.0001), 60.5),
        (0.0, (-0.001, -0.001), 60.5),
        (0.0, (0.002, -0.002), 60.0),
        (15.0, (0.002, -0.002), 60.0 / cos(radians(15.0))),
    ],
)
def test_flanks_with_parabolas_that_touch_along_lines_have_no_edge_contact(
    helix_deg: float, parabola: tuple[float, float], offset: float, flank: str
) -> None:
    """Spur teeth, and helical teeth generated by one rack with a parabola: contact is at mid-face."""
    design = pair_of(2.0, (20, 40), helix_deg, offset).with_parabola(*parabola)
    cycle = mesh_cycle(design, flank)
    assert cycle.status == FirstStatus.SOLVED
    assert cycle.edge_share == 0.0
    first = cycle.at(cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 25))
    assert (first.limit == -1).all()
    assert np.abs(first.z1).max() < 1.0
    alone = first_contact(design, flank, first.pinion_roll)
    assert np.abs(alone.gear_roll - first.gear_roll).max() * cycle.engagement.lever < 1e-9


def test_teeth_that_are_too_far_apart_touch_along_no_line() -> None:
    apart = replace(builtin_design("anti-backlash"), errors=Errors(offset=4.0))
    cycle, reason = mesh_cycle(apart, "right"), reason_of(path_of_contact(apart, "right"))
    assert cycle.status == FirstStatus.NO_CONTACT
    assert np.isnan(cycle.peak_to_peak)
    assert reason is not None
    assert reason.endswith("within the faces it lies beyond a tip or root")


def test_searches_agree_on_nearly_parallel_axes() -> None:
    assert_searches_agree(nearly_parallel_pairs(8, 1), 25)


@pytest.mark.parametrize(
    ("seed", "number", "flank", "corner"),
    [(2, 20, "right", False), (3, 29, "left", False), (6, 23, "left", True)],
)
def test_a_contact_during_a_small_part_of_a_pitch(seed: int, number: int, flank: str, corner: bool) -> None:
    """The flanks nearly touch along a line. With changes of 1 nm in the mounting, the mesh cycle of each pair
    is known and contains the contact on the flanks, or at a corner, between two edge contacts."""
    *_, design = nearly_parallel_pairs(number + 1, seed)
    for change in 1e-6 * np.arange(8):
        errors = replace(design.errors, offset=design.errors.offset + change)
        cycle = mesh_cycle(design.with_errors(errors), flank)
        assert cycle.status == FirstStatus.SOLVED
        ends = np.append(cycle.changes, cycle.start + 0.999 * cycle.pitch)
        roll = np.append(ends - 1e-4 * cycle.pitch, ends + 1e-4 * cycle.pitch)
        first = first_contact(cycle.design, flank, roll)
        assert np.abs(first.gear_roll - cycle.at(roll).gear_roll).max() < 1e-10
        assert ((first.limit[..., 1] >= 0) if corner else (first.limit[..., 0] < 0)).any()


@pytest.mark.slow
def test_searches_agree_on_many_nearly_parallel_pairs() -> None:
    assert_searches_agree(nearly_parallel_pairs(60, 2), 50)
