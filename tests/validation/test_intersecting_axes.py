"""Intersecting axes: closed form, 60 digits, symmetry, and the limit of crossed axes.

Without parabolas, the flanks of a pair without backlash have one common normal each, n = sin(a_w) N +-
cos(a_w) b, with the normal N of the pitch plane and b in this plane, perpendicular to the tooth trace. The
path of contact is the straight line through the pitch point along n, limited by both tip cones. Its length
divided by the normal base pitch is the contact ratio. The axes intersect if the working helix angles cancel:
both axes then lie in the plane of N and the trace. `closed_form` calls no function of the library."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Tool,
    contact_ratio,
    path_certificate,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import path_ends
from beveloid_geom.design.file import parse_design
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.status import Limit, Status
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.oracle.pitch_point_mp import mounting_mp
from tests.oracle.sixty_digits import off_by
from tests.symmetry import OTHER, exchanged, mirrored

FLANKS = ("right", "left")
FILE = """
[tool]
normal_module = {module}
normal_pressure_angle_deg = 20.0
[pinion]
teeth = {teeth[0]}
helix_angle_deg = {helix[0]}
cone_angle_deg = {cone[0]}
profile_shift = 0.0
face_width = {face}
[gear]
teeth = {teeth[1]}
helix_angle_deg = {helix[1]}
cone_angle_deg = {cone[1]}
profile_shift = 0.0
face_width = {face}
[pair]
offset = 0
shaft_angle_deg = {shaft}
"""


def read(
    module: float,
    teeth: tuple[int, int],
    helix: tuple[float, float],
    cone: tuple[float, float],
    face: float,
) -> Design:
    """Return a design file without profile shift, whose working angles are the reference angles; deg."""
    shaft = abs(sum(cone))
    return parse_design(
        FILE.format(module=module, teeth=teeth, helix=helix, cone=cone, face=face, shaft=shaft)
    )


LARGE = read(6.0, (24, 61), (15.0, -15.0), (2.0, 5.0), 60.0)
EQUAL = read(3.0, (37, 37), (20.0, -20.0), (0.0, 4.0), 30.0)
STRAIGHT = read(6.0, (24, 61), (0.0, 0.0), (2.0, 5.0), 60.0)
TAPERED = read(4.0, (31, 44), (-12.0, 12.0), (-2.5, -3.5), 40.0)
OPPOSED = read(4.0, (31, 44), (-12.0, 12.0), (-2.0, 6.0), 30.0)
DESIGNS = {"24/61": LARGE, "37/37": EQUAL, "straight": STRAIGHT, "tapered": TAPERED, "opposed": OPPOSED}
ERRORS = (
    Errors(offset=0.3),
    Errors(offset=-0.3),
    Errors(shaft_angle=2e-4),
    Errors(pinion_axial=0.8),
    Errors(gear_axial=-0.8),
    Errors(-0.1, -1e-4, 0.3, 0.2),
)


def closed_form(design: Design, flank: str) -> float:
    """Return the contact ratio of a pair that closes at offset 0 with its reference cones as pitch cones:
    profile shift only moves tips and changes thicknesses."""
    alpha = float(design.pinion.tool.normal_pressure_angle)
    module = float(design.pinion.tool.normal_module)
    side = {"right": 1.0, "left": -1.0}[flank]
    return sum(_reach(member, side) for member in design.members) / (pi * module * cos(alpha))


def _reach(member: Member, side: float) -> float:
    """Return the distance (mm) along the normal, out of the tooth, from the pitch point to the tip cone of
    the member."""
    alpha, module = float(member.tool.normal_pressure_angle), float(member.tool.normal_module)
    beta, gamma = float(member.helix_angle), float(member.cone_angle)
    # Components across the trace, along it, and out of the member.
    axis = np.array([-sin(beta) * cos(gamma), cos(beta) * cos(gamma), -sin(gamma)])
    outward, across = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    radial = (outward + sin(gamma) * axis) / cos(gamma)
    side *= float(np.sign(across @ np.cross(axis, radial)))
    normal = sin(alpha) * outward + side * cos(alpha) * across
    radius = module * float(member.teeth) / (2.0 * cos(beta))
    tip = module * (float(member.tool.addendum) + float(member.profile_shift))

    def above_tip(way: float) -> float:
        z = way * float(normal @ axis)
        return float(np.linalg.norm(radius * radial + way * normal - z * axis)) - (
            radius + tip + z * tan(gamma)
        )

    return float(brentq(above_tip, 0.0, 10.0 * module, xtol=1e-14))


@pytest.mark.parametrize("name", DESIGNS)
def test_contact_ratios_in_closed_form(name: str, flank: str) -> None:
    ends = path_ends(DESIGNS[name], flank)
    assert {ends.enter, ends.leave} == {Limit.GEAR_TIP, Limit.PINION_TIP}
    assert float(ends.contact_ratio) == pytest.approx(closed_form(DESIGNS[name], flank), abs=1e-11)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_layout_without_backlash_is_that_of_the_reference_cones(name: str) -> None:
    design = DESIGNS[name]
    layout, mounting, closing = zero_backlash_layout(design), mounting_of(design), layout_deviation(design)
    assert float(layout.offset) == 0.0
    assert float(layout.shaft_angle) == pytest.approx(float(design.pair.shaft_angle), abs=1e-14)
    np.testing.assert_allclose(layout.mounting, mounting.distance, rtol=1e-11)
    np.testing.assert_allclose(mounting.working_radius, layout.working_radius, rtol=1e-12)
    assert abs(float(mounting.gap)) < 1e-11
    assert abs(float(mounting.normal_backlash)) < 1e-11
    assert mounting.branch.sum() == 0.0
    assert closing.reasons == ()
    assert abs(closing.offset_difference) < 1e-11
    assert closing.shaft_angle_difference == 0.0


@pytest.mark.parametrize("name", DESIGNS)
def test_sixty_digits(name: str, flank: str) -> None:
    """Three positions of the path agree with the five equations at 60 digits, with and without errors and
    parabolas, at the mounting distances of the library."""
    for design in (
        DESIGNS[name],
        DESIGNS[name].with_parabola(0.0008, -0.0005).with_errors(Errors(-0.05, 5e-5, 0.1, -0.1)),
    ):
        path = path_of_contact(design, flank, 3)
        assert path.ends.status == Status.SOLVED
        for k in range(3):
            apart, turned = off_by(path, k, "l1")
            assert apart < 1e-11
            assert turned < 1e-13


@pytest.mark.parametrize("name", DESIGNS)
def test_the_mounting_at_sixty_digits(name: str) -> None:
    """Mounting distances and working radii agree with 60 digits to 1e-9 mm. The apex is metres away, where
    1e-16 rad of shaft angle are 1e-11 mm."""
    exact, ours = mounting_mp(DESIGNS[name]), mounting_of(DESIGNS[name])
    for k, (distance, radius) in enumerate(((exact.dw1, exact.rw1), (exact.dw2, exact.rw2))):
        assert float(ours.distance[k]) == pytest.approx(float(distance), abs=1e-9)
        assert float(ours.working_radius[k]) == pytest.approx(float(radius), abs=1e-10)


@pytest.mark.parametrize("name", DESIGNS)
def test_unmodified_flanks_transmit_evenly_under_every_error(name: str, flank: str) -> None:
    for errors in (Errors(), *ERRORS):
        path = path_of_contact(DESIGNS[name].with_errors(errors), flank, 33)
        assert path.ends.status == Status.SOLVED
        assert np.ptp(path.transmission_error) < 1e-14


@pytest.mark.parametrize("name", DESIGNS)
def test_both_senses_of_the_shaft_angle_are_one_pair(name: str, flank: str) -> None:
    """The pair is rotated by half a turn about the pinion axis, which also reverses the sense of an offset
    error."""
    design = DESIGNS[name].with_parabola(0.0006, -0.0004)
    other = replace(design, pair=Pair(0.0, -float(design.pair.shaft_angle)))
    assert float(design.sense) == (-1.0 if name in ("tapered", "opposed") else 1.0)
    for errors in (Errors(), *ERRORS):
        turned = Errors(-errors.offset, -errors.shaft_angle, errors.pinion_axial, errors.gear_axial)
        path = path_of_contact(design.with_errors(errors), flank, 5)
        same = path_of_contact(other.with_errors(turned), flank, l1=path.l1)
        np.testing.assert_allclose(same.l2, path.l2, rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(same.transmission_error, path.transmission_error, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(same.point * (-1.0, -1.0, 1.0), path.point, rtol=0.0, atol=1e-9)
        assert (np.sign(same.normal[:, 0]) == -np.sign(path.normal[:, 0])).all()


@pytest.mark.parametrize("name", DESIGNS)
def test_mirrored_and_exchanged_pairs(name: str, flank: str) -> None:
    """The mirror image has the other sense, that of the helix angle of its pinion, and the same errors. If
    the members are exchanged, the sense follows the other member, and an offset error has the opposite
    sign."""
    design = DESIGNS[name].with_parabola(0.0006, -0.0004)
    for errors in (Errors(), *ERRORS):
        path = path_of_contact(design.with_errors(errors), flank, 5)
        ratio = float(path.ends.contact_ratio)
        turned = replace(errors, offset=-float(errors.offset))
        helical = name != "straight"
        image = mirrored(design).with_errors(errors if helical else turned)
        assert float(contact_ratio(image, OTHER[flank])) == pytest.approx(ratio, abs=1e-9)
        swapped = exchanged(design.with_errors(turned if helical else errors))
        again = path_of_contact(swapped, flank, l1=path.l2)
        np.testing.assert_allclose(again.l2, path.l1, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(again.gear_z, path.pinion_z, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("name", DESIGNS)
def test_crossed_axes_tend_to_intersecting_ones(name: str, flank: str) -> None:
    """The change is linear in the offset: 1e-3 mm has a thousand times the effect of 1e-6 mm."""
    design = DESIGNS[name].with_parabola(0.0006, -0.0004)
    l1 = path_of_contact(design, flank, 5).l1

    def places(offset: float) -> FloatArray:
        path = path_of_contact(replace(design, pair=replace(design.pair, offset=offset)), flank, l1=l1)
        stands = mounting_of(path.design).distance[0]
        return np.concatenate((path.l2, path.pinion_z, path.gear_z, path.point[:, 2] - stands))

    zero, rates = places(0.0), []
    for offset in (1e-3, 1e-6):
        rates.append((places(offset) - zero) / offset)
    assert np.abs(rates[1]).max() > 1e-2
    np.testing.assert_allclose(rates[0], rates[1], rtol=0.0, atol=2e-2 * np.abs(rates[1]).max())


@pytest.mark.parametrize("name", ["24/61", "straight", "opposed"])
def test_every_method_agrees_and_nothing_touches_earlier(name: str, flank: str) -> None:
    design = DESIGNS[name].with_errors(Errors(0.02, 2e-5, 0.05, -0.05))
    path = path_of_contact(design, flank, 9)
    assert path_certificate(path).holds
    slow = path_of_contact_five_equations(design, flank, 9)
    assert slow.ends.status == Status.SOLVED
    assert float(slow.ends.contact_ratio) == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)


@pytest.mark.parametrize("shift", [(0.2, 0.1), (-0.1, 0.25), (0.3, -0.2)])
@pytest.mark.parametrize("helix", [0.0, 15.0, -25.0])
def test_profile_shift(shift: tuple[float, float], helix: float, flank: str) -> None:
    """With profile shift the axes intersect if the working helix angles cancel, which are close to the
    reference helix angles."""
    tool = Tool(5.0, radians(20.0))
    pinion = Member(tool, 27, radians(helix), radians(2.0), shift[0], 40.0)
    gear = Member(tool, 50, 0.0, radians(4.5), shift[1], 40.0)

    def laid_out(angle: float) -> tuple[Design, float]:
        turned = replace(gear, helix_angle=angle)
        design = Design(pinion, turned, Pair(0.0, 0.1))
        return design, float(zero_backlash_layout(design).offset) * float(design.sense)

    near = -float(pinion.helix_angle)
    angle = 0.0
    if helix:
        angle = float(brentq(lambda b: laid_out(b)[1], near - 0.01, near + 0.01, xtol=1e-15, rtol=1e-15))
    design = laid_out(angle)[0]
    layout = zero_backlash_layout(design)
    assert float(layout.offset) == pytest.approx(0.0, abs=1e-10)
    assert float(layout.shaft_angle) == pytest.approx(float(layout.cone_angle.sum()), abs=1e-13)
    assert abs(float(layout.helix_angle.sum())) < 1e-12
    design = replace(design, pair=Pair(0.0, float(layout.shaft_angle)))
    mounting = mounting_of(design)
    assert abs(float(mounting.gap)) < 1e-8
    assert abs(float(mounting.normal_backlash)) < 1e-10
    np.testing.assert_allclose(mounting.distance, layout.mounting, rtol=1e-9)
    path = path_of_contact(design, flank, 5)
    assert path.ends.status == Status.SOLVED
    assert np.linalg.norm(path.point - mounting.pitch_point, axis=-1).min() < 5.0


@pytest.mark.parametrize("shaft_angle_deg", [6.0, 7.0, 7.5])
def test_straight_teeth_close_at_every_shaft_angle(shaft_angle_deg: float) -> None:
    """By symmetry both lines of action meet in the plane of the axes; only the backlash depends on the
    shaft angle."""
    design = replace(STRAIGHT, pair=Pair(0.0, radians(shaft_angle_deg)))
    closing = layout_deviation(design)
    assert closing.gap < 1e-12
    assert (closing.offset, closing.shaft_angle_difference, closing.reasons) == (0.0, 0.0, ())
    assert np.sign(round(closing.normal_backlash, 9)) == np.sign(7.0 - shaft_angle_deg)


def test_helix_angles_that_nearly_cancel_close_with_an_offset_of_either_sign() -> None:
    """If helix angles nearly cancel, the offset without backlash may have either sign. A pair with profile
    shift and its mirror image have opposite signs."""
    gear = replace(LARGE.gear, profile_shift=0.3)
    for extra, sign in ((0.01, 1.0), (0.0, 1.0), (-0.01, -1.0)):
        turned = replace(gear, helix_angle=float(gear.helix_angle) + radians(extra))
        design = replace(LARGE, gear=turned)
        offset = float(zero_backlash_layout(design).offset)
        assert offset == pytest.approx(float(zero_backlash_layout(mirrored(design)).offset), abs=1e-9)
        total = float(zero_backlash_layout(design).helix_angle.sum())
        assert np.sign(offset) == np.sign(total) * float(design.sense)
        assert sign == np.sign(total)
