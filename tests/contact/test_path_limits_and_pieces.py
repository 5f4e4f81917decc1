"""Details of paths: named limits, segments, batches, rolls that turn back, several contacts.

Each test detects a fault that was once inserted into the code and not found by other tests.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Status,
    Tool,
    contact_ratio,
    path_of_contact,
)
from beveloid_geom.contact.path import PathEnds, path_ends
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.gear.rack import parameter_at_height, section_point
from beveloid_geom.gear.undercut import undercut_margin
from beveloid_geom.pair.frames import layout_of
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import zero_backlash_layout
from beveloid_geom.status import Limit
from tests.contact.test_path import NUMBERS, five_equation_residual
from tests.oracle.table1 import table1
from tests.stability.answers import closed
from tests.stability.five_residuals import margins
from tests.symmetry import exchanged, mirrored


def wide(design: Design, width: float = 120.0) -> Design:
    return replace(
        design,
        pinion=replace(design.pinion, face_width=width),
        gear=replace(design.gear, face_width=width),
    )


def with_addenda(pinion: float, gear: float) -> Design:
    d = table1()
    return replace(
        d,
        pinion=replace(d.pinion, tool=replace(d.pinion.tool, addendum=pinion)),
        gear=replace(d.gear, tool=replace(d.gear.tool, addendum=gear)),
    )


NAMES_OF_LIMITS = [f"{m} {limit}" for limit in ("root", "tip", "toe", "heel") for m in ("pinion", "gear")]
ENDS = [
    (table1(), "right", "GEAR_TIP", "PINION_TIP"),
    (with_addenda(1.0, 1.4), "right", "PINION_ROOT", "PINION_TIP"),
    (with_addenda(1.4, 1.0), "left", "GEAR_TIP", "GEAR_ROOT"),
    (table1((0.001, 0.001)), "right", "PINION_HEEL", "PINION_TOE"),
    (table1((0.001, 0.001), Errors(offset=0.02)), "right", None, None),
    (table1((0.001, -0.001), Errors(pinion_axial=9.0)), "right", None, None),
    (table1((0.001, -0.001), Errors(gear_axial=9.0)), "right", None, None),
    (table1((0.0, 0.0), Errors(offset=0.5)), "right", None, None),
    (table1((0.0, 0.0), Errors(offset=-0.5)), "right", None, None),
]


@pytest.mark.parametrize(("design", "flank", "enter", "leave"), ENDS)
def test_the_named_limit_is_the_one_that_is_met(
    design: Design, flank: str, enter: str | None, leave: str | None
) -> None:
    path = path_of_contact(design, flank, 3)
    assert path.ends.status == Status.SOLVED
    for end, at, name in ((path.ends.enter, 0, enter), (path.ends.leave, -1, leave)):
        assert end is not None
        room = dict(zip(NAMES_OF_LIMITS, margins(design, path)[:, at], strict=True))
        assert room[f"{end.member} {end.limit}"] == pytest.approx(0.0, abs=1e-10)
        assert name is None or end.name == name


@pytest.mark.parametrize("parabola", [0.02, -0.02])
def test_root_of_a_parabolic_flank_is_at_the_working_depth(parabola: float) -> None:
    tool = Tool(6.0, radians(20.0), parabola=parabola)
    root = root_parameter(replace(table1().pinion, tool=tool), "right")
    assert section_point(tool, "right", root)[0] == pytest.approx(-6.0, rel=1e-14)
    assert np.isnan(parameter_at_height(replace(tool, parabola=0.2), "right", -6.0))


def test_error_of_the_shaft_angle_opens_it_for_either_hand() -> None:
    design = table1((0.001, -0.001), Errors(shaft_angle=2e-4))
    right, left = path_of_contact(design, "right", 5), path_of_contact(mirrored(design), "left", 5)
    np.testing.assert_allclose(left.pinion_z, right.pinion_z, atol=1e-10)
    assert abs(layout_of(mirrored(design)).shaft_angle) == pytest.approx(radians(15.0) + 2e-4, rel=1e-15)


def test_layout_keeps_its_digits_at_small_shaft_angles() -> None:
    layout = layout_of(replace(table1(), pair=Pair(229.0, 1e-7)))
    assert layout.versed_angle == pytest.approx(0.5e-14, rel=1e-14, abs=0.0)  # 1 - cos d = d^2/2 - ...


def test_steep_cones_have_a_negative_n_x_on_one_flank_only() -> None:
    """8 and 6 deg: the pitch point is so far away that the right normal has n_x < 0."""
    pinion, gear = (
        replace(m, cone_angle=radians(cone)) for m, cone in zip(table1().members, (8.0, 6.0), strict=True)
    )
    pair = Pair(178.679, 0.33843)
    design = Design(replace(pinion, profile_shift=0.3), replace(gear, profile_shift=0.3), pair)
    assert mounting_of(design).branch.tolist() == [-1.0, 1.0]
    for flank, sign in (("right", -1.0), ("left", 1.0)):
        path = path_of_contact(design, flank, 11)
        assert (sign * path.normal[:, 0] > 0.2).all()
        assert five_equation_residual(design, path) < 1e-11
        assert path.ends.contact_ratio > 1.5


def test_two_contacts_on_the_flanks_are_marked() -> None:
    """Two contacts with one l1 and different l2 are marked. If the members are exchanged, l2 is the given
    parameter and distinguishes them."""
    design = wide(table1((-0.002, -0.002), Errors(offset=-6.0, shaft_angle=radians(-0.08))))
    asked = np.linspace(-4.21, -4.16, 9)
    path = path_of_contact(design, "right", l1=asked)
    assert (path.status == Status.SEVERAL_CONTACTS).all()
    assert np.isnan(path.l2).all()
    assert np.isnan(path.point).all()
    whole = path_of_contact(design, "right")
    assert whole.ends.status == Status.SOLVED
    assert five_equation_residual(design, whole) < 1e-10
    other = path_of_contact(exchanged(design), "right", l1=np.linspace(-6.0, 6.0, 2401))
    l1 = np.where(other.status == Status.SOLVED, other.l2, np.nan)  # l1 for each l2
    for value in asked:
        below = l1 < value
        known = ~np.isnan(l1[:-1]) & ~np.isnan(l1[1:])
        assert (known & (below[:-1] != below[1:])).sum() == 2


def test_given_parameters_broadcast_against_a_batch_and_its_blocks() -> None:
    offsets = np.linspace(-0.3, 0.3, 601)
    l1 = np.linspace(-2.0, 2.0, 601)[:, None] + np.array([0.0, 0.5])
    coefficients = np.linspace(0.0, 0.001, 601)
    design = table1(errors=Errors(offset=offsets)).with_parabola(coefficients, -coefficients)
    batch, ends = path_of_contact(design, l1=l1), path_ends(design)
    for k in (0, 1, 255, 256, 300, 600):
        one = table1((float(coefficients[k]), -float(coefficients[k])), Errors(offset=float(offsets[k])))
        single = path_of_contact(one, l1=l1[k])
        for name in NUMBERS:
            np.testing.assert_allclose(getattr(batch, name)[k], getattr(single, name), atol=1e-10)
        assert ends.contact_ratio[k] == pytest.approx(contact_ratio(one), abs=1e-11)
        np.testing.assert_allclose(ends.l1[k], single.ends.l1, atol=1e-10)


@pytest.mark.parametrize("inward", [1.0, 0.1, 0.01])
def test_a_path_that_leaves_the_face_and_returns_has_two_pieces(inward: float) -> None:
    """A path has two segments if its z on the pinion rises to 2.185374 mm and falls again, and half the face
    width is smaller."""
    design = table1((-0.003, 0.005))
    whole = path_of_contact(design, "left", 2001)
    top = whole.pinion_z.max()
    assert whole.ends.pieces == 1
    assert 0 < whole.pinion_z.argmax() < 2000
    face = 2.0 * (float(top) - inward)
    path = path_of_contact(replace(design, pinion=replace(design.pinion, face_width=face)), "left", 401)
    inside = (np.abs(whole.pinion_z) < 0.5 * face).astype(int)
    assert path.ends.pieces == np.sum(np.diff(np.r_[0, inside]) > 0)
    assert margins(replace(design, pinion=replace(design.pinion, face_width=face)), path).min() > -1e-10


def test_limits_count_as_met_within_rounding_and_no_further(flank: str) -> None:
    design = table1((0.001, -0.001))
    ends = path_ends(design, flank).l1
    inward = np.sign(ends[::-1] - ends)
    asked = np.concatenate((ends, ends - 1e-9 * inward, ends + 1e-9 * inward))
    path = path_of_contact(design, flank, l1=asked)
    assert path.status.tolist() == [Status.SOLVED] * 2 + [Status.OFF_FLANK] * 2 + [Status.SOLVED] * 2


def test_status_distinguishes_no_normal_from_off_flank() -> None:
    """At 14.8 deg there is no common normal anywhere. The status states this, although the margins to the
    limits are NaN."""
    design = table1((-0.002, -0.002), Errors(offset=-6.0, shaft_angle=radians(-0.08)))
    path = path_of_contact(design, l1=[-6.0, -5.0, -4.3, -4.0, -3.0])
    assert path.status.tolist() == [Status.NO_COMMON_NORMAL] * 3 + [Status.OFF_FLANK] * 2


def test_transmission_error_without_a_path_is_relative_to_the_middle_of_the_given_l1() -> None:
    design = table1((0.0002, -0.0002), Errors(offset=2.0))
    path = path_of_contact(design, l1=[-2.0, 0.0, 2.0])
    assert path.ends.status == Status.OFF_FLANK
    assert np.isfinite(path.transmission_error).all()
    assert abs(path.transmission_error[1]) < 1e-13


def test_path_beyond_the_coarse_window_is_the_same_at_given_l1() -> None:
    """With strong parabolas, a path and the contacts at its l1 are equal and satisfy the five equations, also
    at l1 that the coarse window does not resolve."""
    tried = twice = 0
    for a in (0.003, 0.005, 0.01, 0.02):
        for flank in ("right", "left"):
            design = table1((-a, a))
            path = path_of_contact(design, flank, 21)
            if path.l1.size == 0:
                continue
            at = path_of_contact(design, flank, l1=path.l1)
            tried += 1
            assert five_equation_residual(design, path) < 1e-9
            assert five_equation_residual(design, at) < 1e-9
            known = at.status == Status.SOLVED
            twice += int((at.status == Status.SEVERAL_CONTACTS).sum())
            assert (known | (at.status == Status.SEVERAL_CONTACTS)).all()
            for name in NUMBERS[:-1]:
                found, right = getattr(at, name)[known], getattr(path, name)[known]
                np.testing.assert_allclose(found, right, atol=1e-9, err_msg=name)
    assert tried == 8
    assert 0 < twice < 30


def test_positions_near_the_pole_are_solved_with_n_x_as_an_unknown() -> None:
    """In the layout without backlash at 14.84 deg, n_x falls to 0.002. Rounding of l2 alone would move the
    contact too far, so that n_x is an unknown."""
    design = replace(table1((0.0001, 0.0001)), pair=Pair(218.9033, radians(14.84)))
    path = path_of_contact(design, l1=np.linspace(-5.0, 5.0, 401))
    assert np.isin(path.status, (Status.SOLVED, Status.OFF_FLANK)).all()
    assert np.abs(path.normal[:, 0]).min() < 0.003
    assert five_equation_residual(design, path) < 1e-9


def test_newton_stays_in_its_bracket() -> None:
    """Newton's method stays in its bracket. Without the bracket it converges to the other root and reports
    two contacts in place of one."""
    design = table1((0.0089, -0.0091), Errors(offset=-0.4, shaft_angle=radians(-0.07)))
    path = path_of_contact(design, l1=np.linspace(-6.0, 5.9, 61)[:25])
    assert (path.status == Status.SOLVED).all()
    assert np.abs(np.diff(path.l2, 2)).max() < 1e-2
    assert five_equation_residual(design, path) < 1e-9


def test_tip_and_undercut_are_searched_along_the_entire_face() -> None:
    never = replace(table1().pinion, tool=replace(table1().pinion.tool, parabola=-0.5))
    with np.errstate(all="ignore"):
        assert np.isnan(tip_parameter(never, "right", 0.0))
    member = Member(Tool(2.0, radians(20.0)), 22, radians(20.0), radians(5.0), 0.0, 30.0)
    narrow = replace(member, face_width=1.0)
    assert undercut_margin(member, "right") < 0.0 < undercut_margin(narrow, "right")


@pytest.mark.parametrize("teeth", [(9, 23), (11, 30), (12, 44)])
def test_undercut_cones_on_parallel_axes_keep_their_path_at_a_corner(
    teeth: tuple[int, int], flank: str
) -> None:
    """The path is continuous in the cone angle.

    At a corner of the flank, where the edge of undercut meets the end of the face, the contact line is one
    point. Rounding must not lose the path there.
    """

    def ends(cone: float) -> PathEnds:
        pinion, gear = (
            Member(Tool(2.0, radians(20.0)), number, 0.0, sense * cone, 0.0, 20.0)
            for number, sense in zip(teeth, (1.0, -1.0), strict=True)
        )
        return path_ends(Design(pinion, gear, Pair(float(sum(teeth)), 0.0)), flank)

    for cone in np.radians(np.linspace(1.5, 6.0, 10)):
        here, near = ends(float(cone)), ends(float(cone) + 1e-9)
        assert here.status == near.status == Status.SOLVED
        assert here.contact_ratio == pytest.approx(float(near.contact_ratio), abs=1e-6)


def test_ends_of_a_few_given_l1_without_limits_by_undercut(flank: str) -> None:
    """Ends and transmission error at up to 16 given l1, which are computed when they are first read, equal
    those of a call with more l1, whether or not undercut limits the flanks."""
    tool = Tool(2.0, radians(20.0))
    pinion = Member(replace(tool, parabola=2e-4), 12, radians(10.0), radians(4.0), 0.0, 20.0)
    gear = Member(tool, 40, radians(-3.0), radians(2.0), 0.1, 24.0)
    design = closed(pinion, gear)
    ratios = []
    for undercut in (True, False):
        ends = path_of_contact(design, flank, 5, undercut=undercut).ends
        l1 = np.linspace(ends.l1[0], ends.l1[1], 17)
        few, many = (path_of_contact(design, flank, l1=part, undercut=undercut) for part in (l1[4:12], l1))
        assert "ends" not in vars(few)
        np.testing.assert_allclose(few.transmission_error, many.transmission_error[4:12], atol=1e-14)
        for name, value in vars(ends).items():
            np.testing.assert_allclose(getattr(few.ends, name), value, atol=1e-12)
        ratios.append(float(few.contact_ratio))
    assert ratios[1] > ratios[0] + 0.1


@pytest.mark.parametrize("shaft_angle_deg", [0.0, 8.0])
def test_members_in_a_batch_are_limited_by_their_undercut(shaft_angle_deg: float, flank: str) -> None:
    """Each case of a batch equals the single design. The batch has an undercut cone, an undercut cylinder, a
    sound pinion and a parabola."""
    teeth, cone = np.array((12, 13, 30, 12)), np.radians((4.0, 0.0, 3.0, 4.0))
    helix = radians(10.0 if shaft_angle_deg else 0.0)
    tool = Tool(2.0, radians(20.0))

    def pair(teeth: Any, cone: Any, parabola: Any, offset: Any, shaft_angle: Any) -> Design:
        pinion = Member(replace(tool, parabola=parabola), teeth, helix, cone, 0.0, 20.0)
        gear = Member(tool, 40, -0.3 * helix, -cone if not shaft_angle_deg else radians(2.0), 0.1, 24.0)
        return Design(pinion, gear, Pair(offset, shaft_angle))

    parabola, layouts = np.array((0.0, 0.0, 0.0, 2e-4)), []
    for k in range(4):
        layout = zero_backlash_layout(
            pair(int(teeth[k]), cone[k], 0.0, 52.0, 0.1 if shaft_angle_deg else 0.0)
        )
        layouts.append((float(layout.offset), float(layout.shaft_angle)))
    offset, shaft_angle = np.array(layouts).T
    batch = path_of_contact(pair(teeth, cone, parabola, offset, shaft_angle), flank, 5)
    for k in range(4):
        alone = path_of_contact(
            pair(int(teeth[k]), cone[k], parabola[k], offset[k], shaft_angle[k]), flank, 5
        )
        assert batch.ends.limit[k].tolist() == alone.ends.limit.tolist()
        assert batch.ends.contact_ratio[k] == pytest.approx(float(alone.ends.contact_ratio), abs=1e-12)
        np.testing.assert_allclose(batch.point[k], alone.point, atol=1e-10)
    assert np.isin(batch.ends.limit, (Limit.PINION_ROOT, Limit.GEAR_ROOT)).any()
