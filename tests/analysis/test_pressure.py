"""Hertzian pressure along a path: lever of a torque, crossed cylinders, lines of contact, edges of flanks."""

from __future__ import annotations

from dataclasses import replace
from math import cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Member, Pair, Tool, builtin_design, path_of_contact
from beveloid_geom.analysis.pressure import NO_LIMIT_REACHED, Load, path_pressure
from beveloid_geom.contact.ellipse import relative_curvature
from beveloid_geom.contact.hertz import contact_modulus
from beveloid_geom.contact.parallel.lines import contact_lines
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.pair.frames import layout_of, member_frame, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import EllipseStatus, Limit
from tests.oracle.table1 import table1
from tests.stability.answers import closed
from tests.stability.parallel_pairs import pair_of

LOAD = Load(force=1e4, young=210000.0)


@pytest.mark.parametrize(("flank", "pressure"), [("right", 647.0), ("left", 1068.0)])
def test_table_1_in_the_middle_of_its_path(flank: str, pressure: float) -> None:
    """Pressures under 10 kN with steel of 210 GPa. With 206 GPa they are lower by the factor
    (206/210)^(2/3)."""
    path = path_of_contact(table1(), flank, 3)
    found = path_pressure(path, LOAD)
    assert found.pressure[1] == pytest.approx(pressure, abs=0.5)
    steel = path_pressure(path, Load(force=1e4)).pressure
    assert steel == pytest.approx(found.pressure * (206.0 / 210.0) ** (2.0 / 3.0), rel=1e-13)
    assert found.curvature == pytest.approx(relative_curvature(path).curvature)


def test_a_torque_acts_on_the_lever_of_the_common_normal(flank: str) -> None:
    """Without parabola the lever is m_n N cos(alpha) / 2; with a parabola it follows from the velocity of
    a rotating pinion."""
    found = path_pressure(path_of_contact(table1(), flank, 5), Load(torque_nm=1000.0))
    assert found.force == pytest.approx(1e6 / (3.0 * 29.0 * cos(radians(20.0))), rel=1e-12)
    path = path_of_contact(table1((0.001, -0.001)), flank, 5)
    found = path_pressure(path, Load(torque_nm=1000.0))
    turning = np.cross((0.0, 0.0, 1.0), path.point)
    lever = np.abs(np.einsum("ni,ni->n", path.normal, turning))
    assert np.ptp(lever) > 1e-3
    assert found.force * lever == pytest.approx(1e6, rel=1e-12)


def spur(shaft_angle: float, parabola: float = 0.0) -> Design:
    """Return two gears (module 4, 20 deg, 23 and 37 teeth). Each has half the shaft angle (rad) as its helix
    angle."""
    tool = Tool(4.0, radians(20.0), parabola=parabola)
    pinion, gear = (Member(tool, n, shaft_angle / 2.0, 0.0, 0.0, 30.0) for n in (23, 37))
    offset = sum(2.0 * n for n in (23, 37)) / cos(shaft_angle / 2.0)
    return Design(pinion, gear, Pair(offset, shaft_angle, 0.0, 0.0))


def test_crossed_cylinders() -> None:
    """At the pitch point, involute helicoids have the curvature of cylinders with the radii r sin(alpha_t)
    / cos(beta_b). Their generators cross at the angle chi, cos(chi) = (cos(Sigma) + sin^2(beta_b)) /
    cos^2(beta_b) for equal helix angles (Johnson 4.3)."""
    angle = radians(30.0)
    found = path_pressure(path_of_contact(spur(angle), "right", l1=[0.0]), LOAD)
    transverse = np.arctan(np.tan(radians(20.0)) / cos(angle / 2.0))
    base = np.arcsin(sin(angle / 2.0) * cos(radians(20.0)))
    first, second = (cos(base) * cos(angle / 2.0) / (2.0 * n * sin(transverse)) for n in (23, 37))
    cosine = (cos(angle) + sin(base) ** 2) / cos(base) ** 2
    difference = sqrt(first**2 + second**2 + 2.0 * first * second * (2.0 * cosine**2 - 1.0))
    assert found.curvature[0].sum() == pytest.approx(first + second, rel=1e-9)
    assert np.ptp(found.curvature[0]) == pytest.approx(difference, rel=1e-9)


def test_the_strip_of_two_cylinders() -> None:
    """Spur gears on nearly parallel axes have a long ellipse with p0 = E* b / (2 R) across it. The force
    per length is that of a strip, p0 = 2 q / (pi b), with q = 3 F / (4 a) in the middle. The ellipse exceeds
    the end of the face that is nearest."""
    found = path_pressure(path_of_contact(spur(1e-3), "right", 5), LOAD)
    assert (found.status == EllipseStatus.ELLIPSE).all()
    modulus, (a, b) = contact_modulus(210000.0, 0.3), found.semi_axes.T
    assert (b / a < 1e-3).all()
    radius = 1.0 / found.curvature[:, 1]
    assert found.pressure == pytest.approx(modulus * b / (2.0 * radius), rel=1e-4)
    assert found.pressure == pytest.approx(2.0 / (pi * b) * 0.75 * 1e4 / a, rel=1e-12)
    for axial, end in ((5.0, Limit.PINION_TOE), (-5.0, Limit.PINION_HEEL)):
        moved = spur(1e-3).with_errors(Errors(pinion_axial=axial))
        assert (path_pressure(path_of_contact(moved, "right", 5), LOAD).reaches == end).all()


def helical(helix: float, widths: tuple[float, float], shifts: tuple[float, float]) -> Design:
    """Return a pair on parallel axes, module 3, 25 and 40 teeth, with a centre distance 0.5 mm larger than
    that of the reference circles."""
    return pair_of(3.0, (25, 40), degrees(helix), 1.5 * 65 / cos(helix) + 0.5, shifts, widths)


@pytest.mark.parametrize("helix", [0.0, 0.15, -0.45])
@pytest.mark.parametrize("widths", [(30.0, 30.0), (8.0, 12.0)])
@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.3, -0.1)])
def test_lines_share_the_load_by_their_length(
    helix: float, widths: tuple[float, float], shifts: tuple[float, float], flank: str
) -> None:
    """ISO 21771: in the plane of action, the lines have the base helix angle and a distance of p_bt, in a
    rectangle of the length of action g and the face width b. In the normal section F = T / (r_b
    cos(beta_b)) and kappa = cos(beta_b) (1 / rho_1 + 1 / rho_2), largest at an end of the line; p0^2 = q
    E* kappa / pi."""
    design, torque, points = helical(helix, widths, shifts), 100.0, 17
    found = path_pressure(path_of_contact(design, flank, points), Load(torque_nm=torque))
    transverse, base_helix = (
        np.arctan(np.tan(radians(20.0)) / cos(helix)),
        np.arcsin(sin(helix) * cos(radians(20.0))),
    )
    reference = np.array([1.5 * n / cos(helix) for n in (25, 40)])
    base, tip = reference * cos(transverse), reference + 3.0 * (1.0 + np.array(shifts))
    offset, width = float(design.pair.offset), min(widths)
    tangents = offset * sin(np.arccos(base.sum() / offset))  # between the feet on the base circles
    first = tangents - sqrt(tip[1] ** 2 - base[1] ** 2)  # rho_1 where the gear's tip enters
    action = sqrt(tip[0] ** 2 - base[0] ** 2) - first
    pitch, lean = 2.0 * pi * base[0] / 25, abs(np.tan(base_helix))
    places = np.linspace(-0.5 * width * lean, action + 0.5 * width * lean, points)
    length, greatest = np.zeros(points), np.zeros(points)
    for pair in range(-9, 10):
        # z between which the line is inside the length of action: x + z lean from 0 to g
        x = places + pair * pitch
        ends = np.clip([-x, action - x], -0.5 * width * lean, 0.5 * width * lean)
        on = (x >= -0.5 * width * lean - 1e-9) & (x <= action + 0.5 * width * lean + 1e-9)
        length += np.where(on, np.ptp(ends, axis=0) / lean if lean else width, 0.0) / cos(base_helix)
        if pair == 0:
            rho = first + x + (ends if lean else 0.0 * ends)
            greatest = cos(base_helix) * (1.0 / rho + 1.0 / (tangents - rho)).max(axis=0)
    assert found.total_length == pytest.approx(length, rel=1e-9)
    assert found.curvature[:, 1] == pytest.approx(greatest, rel=1e-9)
    load = 1e3 * torque / (base[0] * cos(base_helix)) / length
    modulus = contact_modulus(206000.0, 0.3)
    assert found.pressure == pytest.approx(np.sqrt(load * modulus * greatest / pi), rel=1e-9)
    assert found.semi_axes[:, 1] == pytest.approx(2.0 * load / (pi * found.pressure), rel=1e-9)
    assert (found.status == EllipseStatus.LINE_CONTACT).all()
    assert (found.reaches == NO_LIMIT_REACHED).all()


def counterparts() -> Design:
    """Return a pair with parabolas of opposite sign on reference cylinders that touch: one rack generates
    both members, so that they touch along lines."""
    design = helical(0.2, (30.0, 25.0), (0.0, 0.0)).with_parabola(0.002, -0.002)
    return replace(design, pair=replace(design.pair, offset=1.5 * 65 / cos(0.2)))


@pytest.mark.parametrize("design", [builtin_design("anti-backlash"), counterparts()])
def test_lines_of_beveloids_and_counterparts_add_up(design: Design) -> None:
    """The total length equals the sum of the lengths of single lines, interpolated at distances of one
    pitch on a fine path."""
    path = path_of_contact(design, "right", 81)
    found = path_pressure(path, Load(force=1.0))
    own, pitch = contact_lines(path), 2.0 * pi / int(design.pinion.teeth)
    total = sum(
        np.interp(path.pinion_roll + k * pitch, own.pinion_roll, own.length, 0.0, 0.0) for k in range(-3, 4)
    )
    assert np.isfinite(found.pressure).all()
    assert np.median(np.abs(found.total_length - total)) < 0.01
    assert found.total_length == pytest.approx(total, abs=1.0)


def test_a_single_line_carries_the_load_with_a_transmission_error_and_batches_equal_single_designs() -> None:
    design = spur(0.0, parabola=-0.002)
    found = path_pressure(path_of_contact(design, "left", 5), Load(force=1e3))
    assert found.total_length == pytest.approx(30.0, rel=1e-9)
    offsets, angles = np.array([0.0, 0.0, 0.2]), np.array([0.0, 0.05, 0.0])
    batch = replace(spur(0.0), errors=Errors(offset=offsets, shaft_angle=angles))
    together = path_pressure(path_of_contact(batch, "right", 5), LOAD)
    assert np.isnan(together.total_length[1]).all()
    for k in (0, 2):
        errors = Errors(offset=offsets[k], shaft_angle=angles[k])
        alone = path_pressure(path_of_contact(replace(spur(0.0), errors=errors), "right", 5), LOAD)
        for name in ("force", "pressure", "semi_axes", "total_length", "status"):
            np.testing.assert_allclose(getattr(together, name)[k], getattr(alone, name), rtol=1e-7)


def test_line_contact_and_intersecting_flanks_have_no_pressure() -> None:
    found = path_pressure(path_of_contact(spur(1e-8), "right", 3), LOAD)
    assert (found.status == EllipseStatus.LINE_CONTACT).all()
    assert np.isnan(found.pressure).all()
    assert np.isfinite(found.force).all()
    design = table1((0.002, 0.002))
    cut = path_pressure(path_of_contact(design, "right", 3), LOAD)
    assert (cut.status == EllipseStatus.INTERFERENCE).all()
    assert np.isnan(cut.pressure).all()


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.002)])
def test_vertices_are_on_the_named_flanks(flank: str, parabola: tuple[float, float]) -> None:
    """An ellipse is reported as complete exactly if its vertices are on both flanks. The exact feet of
    perpendiculars from the vertices are the reference."""
    design = table1(parabola)
    path = path_of_contact(design, flank, 41)
    found = path_pressure(path, Load(force=3000.0))
    axes = found.semi_axes[..., None] * found.direction
    ends = path.point[:, None] + np.concatenate((axes, -axes), axis=1)
    layout, margin = layout_of(design), []
    for j, (member, roll) in enumerate(zip(design.members, (path.pinion_roll, path.gear_roll), strict=True)):
        rotation, origin = member_frame(layout, j, roll, mounting_of(design).distance[j])
        own = np.einsum("nji,nkj->nki", rotation, ends - origin[:, None])
        margin.append(feet(member, flank, own).margin)
    least = np.min(margin, axis=(0, 2))
    clear = np.abs(least) > 0.02
    assert clear.sum() > 30
    assert np.array_equal(found.reaches[clear] == NO_LIMIT_REACHED, least[clear] > 0.0)
    assert 0 < np.count_nonzero(found.reaches == NO_LIMIT_REACHED) < 41 or flank == "right"


@pytest.mark.parametrize("cone_deg", [0.0, 3.0])
def test_ellipses_have_the_limits_of_their_path(cone_deg: float, flank: str) -> None:
    """On a path that undercut does not limit, small ellipses below the edge of undercut exceed no limit."""
    tool = Tool(2.0, radians(20.0))
    pinion = Member(tool, 10, radians(12.0), radians(cone_deg), 0.0, 20.0)
    gear = Member(tool, 30, radians(12.0), 0.0, 0.0, 20.0)
    design = closed(pinion, gear)
    path = path_of_contact(design, flank, 21, undercut=False)
    found = path_pressure(path, Load(force=0.01))
    below = path.l1 < path_of_contact(design, flank, 2).l1.min()
    assert np.count_nonzero(below & (found.status == EllipseStatus.ELLIPSE)) > 0
    assert (found.reaches[1:-1] == NO_LIMIT_REACHED).all()


def test_the_angle_is_measured_from_the_tooth_trace(flank: str) -> None:
    """A small step along the major axis has the component cos(angle) along the tooth trace, which follows
    from differences of the flank."""
    design = table1((0.001, -0.001))
    path = path_of_contact(design, flank, 5)
    found = path_pressure(path, LOAD)
    frame = member_frame(layout_of(design), 0, path.pinion_roll, mounting_of(design).distance[0])
    here, along, up = (
        to_fixed(frame, flank_point(design.pinion, flank, path.l1 + l, path.u1 + u))
        for l, u in ((0.0, 0.0), (0.0, 1e-4), (1e-4, 0.0))
    )
    trace = (along - here) / np.linalg.norm(along - here, axis=-1, keepdims=True)
    major = found.direction[:, 0]
    cosine, rise = (np.einsum("ni,ni->n", major, x) for x in (trace, up - here))
    assert np.cos(found.angle) == pytest.approx(np.abs(cosine), abs=1e-6)
    across = np.einsum("ni,ni->n", up - here, trace)
    assert np.array_equal(np.sign((rise - cosine * across) * np.sign(cosine)), np.sign(found.angle))
