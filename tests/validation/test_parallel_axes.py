"""Parallel axes: ISO 21771 in closed form, five equations, symmetry, and the limit of crossed axes.

Unmodified flanks touch along lines in a plane of action. For cylindrical gears with the working transverse
pressure angle a_wt, base radii r_b, tip radii r_a, common face width b and base helix angle b_b,

    eps_alpha = [sqrt(r_a1^2 - r_b1^2) + sqrt(r_a2^2 - r_b2^2) - a sin(a_wt)] / p_bt,
    eps_beta = b tan(b_b) / p_bt,   eps_gamma = eps_alpha + eps_beta,
    j_n = m_n cos(a_n) [(z1 + z2) (inv a_wt - inv a_t) - 2 (x1 + x2) tan(a_n)].

With opposite cones an axial shift s (mm) of one member against the other changes the backlash by 2 sin(a_n)
sin(cone) s: apart from a rotation, it moves each flank of the rack by sin(a_n) sin(cone) s along its normal.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, atan, cos, radians, sin, tan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Pair,
    contact_ratio,
    path_certificate,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.arrays import FLANK_SIGN
from beveloid_geom.contact.parallel.lines import ContactLines, contact_lines, touches_along_lines
from beveloid_geom.findings.path import reason_of
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.status import Limit, Status
from tests.stability.five_residuals import flank_at, residuals
from tests.stability.parallel_pairs import involute, pair_of, ratios_of_iso
from tests.symmetry import OTHER, exchanged, mirrored

ALPHA = radians(20.0)
BACKLASH = 0.1
"""mm by which the distance of the axes exceeds that without backlash."""
UNMODIFIED, CONVEX = (0.0, 0.0), (-1e-3, -5e-4)


def pair(
    helix: float,
    cone: float,
    parabola: tuple[float, float] = UNMODIFIED,
    shift: tuple[float, float] = (0.1, -0.05),
) -> Design:
    """Return a pair of module 3 on parallel axes, deg, with opposite helix and cone angles."""
    guess = pair_of(3.0, (25, 31), helix, 100.0, shift, (30.0, 28.0), cone).with_parabola(*parabola)
    return replace(guess, pair=Pair(float(zero_backlash_layout(guess).offset) + BACKLASH, 0.0))


ANGLES = {
    "spur": (0.0, 0.0),
    "helical": (15.0, 0.0),
    "left hand": (-22.0, 0.0),
    "conical": (15.0, 3.0),
    "straight": (0.0, 5.0),
}
CYLINDRICAL = ("spur", "helical", "left hand")


def iso_21771(design: Design) -> tuple[float, float, float]:
    """Return eps_alpha, eps_beta and j_n of cylindrical gears from their numbers alone."""
    beta = abs(float(design.pinion.helix_angle))
    transverse = atan(tan(ALPHA) / cos(beta))
    teeth = sum(float(member.teeth) for member in design.members)
    reference = 1.5 * teeth / cos(beta)
    working = acos(reference * cos(transverse) / float(design.pair.offset + design.errors.offset))
    shift = sum(float(member.profile_shift) for member in design.members)
    play = teeth * (involute(working) - involute(transverse)) - 2.0 * shift * tan(ALPHA)
    return *ratios_of_iso(design), 3.0 * cos(ALPHA) * play


@pytest.mark.parametrize("name", CYLINDRICAL)
@pytest.mark.parametrize("offset_error", [0.0, 0.2])
def test_iso_21771(name: str, offset_error: float, flank: str) -> None:
    design = pair(*ANGLES[name]).with_errors(Errors(offset=offset_error))
    transverse, overlap, play = iso_21771(design)
    lines = contact_lines(path_of_contact(design, flank, 3))
    assert float(lines.transverse_ratio) == pytest.approx(transverse, abs=1e-12)
    assert float(lines.overlap_ratio) == pytest.approx(overlap, abs=1e-12)
    assert float(lines.total_ratio) == pytest.approx(transverse + overlap, abs=1e-12)
    as_designed = design.with_errors(Errors())
    assert float(mounting_of(as_designed).normal_backlash) == pytest.approx(
        iso_21771(as_designed)[2], abs=1e-12
    )
    if offset_error:
        moved = replace(as_designed, pair=Pair(design.pair.offset + offset_error, 0.0))
        assert float(mounting_of(moved).normal_backlash) == pytest.approx(play, abs=1e-12)


@pytest.mark.parametrize("name", ANGLES)
def test_backlash_over_axial_shift(name: str) -> None:
    design = pair(*ANGLES[name])
    own = float(mounting_of(design).normal_backlash)
    rate = 2.0 * sin(ALPHA) * sin(radians(ANGLES[name][1]))
    for pinion, gear in ((0.5, 0.0), (-1.5, 0.25), (1.0, 1.0)):
        mounted = replace(design, pair=Pair(design.pair.offset, 0.0, pinion, gear))
        expected = own + rate * (pinion - gear)
        assert float(mounting_of(mounted).normal_backlash) == pytest.approx(expected, abs=1e-12)


def test_zero_backlash_by_the_inverse_involute() -> None:
    design = pair(15.0, 0.0)
    transverse = atan(tan(ALPHA) / cos(radians(15.0)))
    goal = involute(transverse) + 2.0 * tan(ALPHA) * 0.05 / 56.0
    working = brentq(lambda angle: involute(angle) - goal, 0.1, 1.0, xtol=1e-15)
    offset = 3.0 * 56.0 / (2.0 * cos(radians(15.0))) * cos(transverse) / cos(working)
    layout = zero_backlash_layout(design)
    assert float(layout.offset) == pytest.approx(offset, abs=1e-11)
    assert float(layout.shaft_angle) == 0.0
    np.testing.assert_array_equal(layout.mounting, 0.0)


@pytest.mark.parametrize("name", ANGLES)
def test_layout_and_closing(name: str) -> None:
    """The pitch line divides the offset in the ratio of the teeth; the lines of action meet at every offset;
    the mid-faces are opposite each other."""
    design = pair(*ANGLES[name])
    mounting, closing = mounting_of(design), layout_deviation(design)
    offset = float(design.pair.offset)
    np.testing.assert_allclose(mounting.working_radius, (offset * 25 / 56, offset * 31 / 56), rtol=1e-14)
    np.testing.assert_array_equal(mounting.distance, 0.0)
    assert closing.gap == 0.0
    assert abs(closing.offset_difference) < 1e-12
    assert closing.shaft_angle_difference == 0.0
    shifted = mounting_of(replace(design, pair=Pair(offset, 0.0, 7.0)))
    np.testing.assert_array_equal(shifted.distance, 7.0)


def on_line(lines: ContactLines, line: int, share: float) -> SimpleNamespace:
    """Return the contact at a share of a line of unmodified flanks, along which l1, l2 and z are linear,
    as a path of one position."""
    l1, l2, z1, z2 = (
        np.array([values[line] @ (1.0 - share, share)])
        for values in (lines.l1, lines.l2, lines.pinion_z, lines.gear_z)
    )
    us = []
    for member, l, z in zip(lines.design.members, (l1, l2), (z1, z2), strict=True):
        point, _ = flank_at(member, lines.flank, l, 0.0 * l, 0.0 * l)
        along, _ = flank_at(member, lines.flank, l, 0.0 * l + 1.0, 0.0 * l)
        us.append((z - point[2]) / (along[2] - point[2]))
    rolls = {"pinion_roll": lines.pinion_roll[line : line + 1], "gear_roll": lines.gear_roll[line : line + 1]}
    return SimpleNamespace(flank=lines.flank, l1=l1, l2=l2, u1=us[0], u2=us[1], **rolls)


@pytest.mark.parametrize("name", ANGLES)
def test_whole_lines_meet_the_five_equations(name: str, flank: str) -> None:
    design = pair(*ANGLES[name]).with_errors(Errors(offset=0.05, pinion_axial=0.3, gear_axial=-0.2))
    lines = contact_lines(path_of_contact(design, flank, 9))
    assert bool(touches_along_lines(design, flank))
    for line in range(1, 8):
        for share in (0.0, 0.4, 1.0):
            one: Any = on_line(lines, line, share)
            apart, turned = residuals(design, one, mounting_of(design).distance)
            assert apart[0] < 1e-11
            assert turned[0] < 1e-13


@pytest.mark.parametrize("name", ANGLES)
def test_lines_end_at_limits(name: str, flank: str) -> None:
    """Every end of a line is at the limit that is named, and no line exceeds another limit."""
    design = pair(*ANGLES[name])
    lines = contact_lines(path_of_contact(design, flank, 21))
    for j, member in enumerate(design.members):
        z, r = (lines.pinion_z, lines.gear_z)[j], (lines.pinion_r, lines.gear_r)[j]
        half = 0.5 * float(member.face_width)
        tip = 1.5 * float(member.teeth) / cos(float(member.helix_angle)) + 3.0 * (
            1.0 + float(member.profile_shift)
        )
        inside = {"tip": tip + z * tan(float(member.cone_angle)) - r, "toe": half + z, "heel": half - z}
        for name_of, margin in inside.items():
            assert margin.min() > -1e-9
            met = lines.limit == Limit[f"{('pinion', 'gear')[j].upper()}_{name_of.upper()}"]
            assert np.abs(margin[met]).max(initial=0.0) < 1e-8
    assert lines.length[1:-1].min() > 0.0
    assert (np.diff(lines.pinion_roll) * FLANK_SIGN[flank] > 0.0).all()


@pytest.mark.parametrize("name", ANGLES)
def test_lines_along_an_edge_or_a_root(name: str, flank: str) -> None:
    """Every line of a path has two ends at every offset, also if the first or the last line coincides with a
    limit of the flank."""
    offsets = np.linspace(-0.4, 0.6, 41)
    path = path_of_contact(pair(*ANGLES[name]).with_errors(Errors(offset=offsets)), flank, 5)
    assert (path.ends.status == Status.SOLVED).all()
    lines = contact_lines(path)
    for part in (lines.point, lines.length, lines.pinion_z, lines.gear_r):
        assert np.isfinite(part).all()
    if name == "spur":
        np.testing.assert_allclose(lines.length, 28.0, atol=1e-9)
    assert lines.length.min() >= 0.0


@pytest.mark.parametrize("name", ANGLES)
def test_no_transmission_error_and_nothing_earlier(name: str, flank: str) -> None:
    design = pair(*ANGLES[name]).with_errors(Errors(offset=0.03, pinion_axial=0.2))
    path = path_of_contact(design, flank, 5)
    assert path.ends.status == Status.SOLVED
    assert np.abs(path.transmission_error).max() < 1e-14
    assert path_certificate(path).holds


@pytest.mark.parametrize("name", ["spur", pytest.param("conical", marks=pytest.mark.slow)])
def test_all_lines_are_in_contact(name: str, flank: str) -> None:
    design = pair(*ANGLES[name])
    assert float(operating_ratio(design, flank)) == float(contact_ratio(design, flank))


@pytest.mark.parametrize("name", ANGLES)
@pytest.mark.parametrize("parabola", [UNMODIFIED, CONVEX])
def test_mirrored_and_exchanged(name: str, parabola: tuple[float, float], flank: str) -> None:
    design = pair(*ANGLES[name], parabola)
    ratio = float(contact_ratio(design, flank))
    assert ratio > 0.0
    assert float(contact_ratio(mirrored(design), OTHER[flank])) == pytest.approx(ratio, abs=1e-12)
    if parabola == UNMODIFIED or name != "spur":  # whose transmission error changes the pitches of the gear
        assert float(contact_ratio(exchanged(design), flank)) == pytest.approx(ratio, abs=1e-12)


def test_flanks_that_share_no_normal() -> None:
    design = pair(15.0, 3.0)
    wrong = replace(design, gear=replace(design.gear, helix_angle=-design.gear.helix_angle))
    path = path_of_contact(wrong)
    assert path.ends.status == Status.UNDEFINED
    assert "no common normal" in str(reason_of(path))
    assert np.isnan(mounting_of(wrong).normal_backlash)
    assert not bool(touches_along_lines(wrong))
