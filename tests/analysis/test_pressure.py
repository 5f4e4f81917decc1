"""Hertz's ellipses along a path: the lever of a torque, cylinders at a spur gear's limit, edges of flanks."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Member, Pair, Tool, path_of_contact
from beveloid_geom.analysis.pressure import WHOLE, Load, pressure_along
from beveloid_geom.contact.ellipse import relative_curvature
from beveloid_geom.contact.hertz import contact_modulus
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.gear.perpendicular import feet
from beveloid_geom.pair.frames import layout_of, member_frame, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import EllipseStatus, Limit
from tests.oracle.table1 import table1
from tests.symmetry import exchanged, mirrored, scaled

LOAD = Load(force=1e4, young=210000.0)


@pytest.mark.parametrize(("flank", "pressure"), [("right", 647.0), ("left", 1068.0)])
def test_table_1_in_the_middle_of_its_path(flank: str, pressure: float) -> None:
    """10 kN, steel of 210 GPa; with 206 GPa (206/210)^(2/3) of it."""
    path = path_of_contact(table1(), flank, 3)
    found = pressure_along(path, LOAD)
    assert found.pressure[1] == pytest.approx(pressure, abs=0.5)
    steel = pressure_along(path, Load(force=1e4)).pressure
    assert steel == pytest.approx(found.pressure * (206.0 / 210.0) ** (2.0 / 3.0), rel=1e-13)
    assert found.curvature == pytest.approx(relative_curvature(path).curvature)


def test_a_torque_acts_on_the_lever_of_the_common_normal(flank: str) -> None:
    """Without parabola m_n N cos(alpha) / 2; with one moment by the velocity of a turning pinion."""
    found = pressure_along(path_of_contact(table1(), flank, 5), Load(torque_nm=1000.0))
    assert found.force == pytest.approx(1e6 / (3.0 * 29.0 * cos(radians(20.0))), rel=1e-12)
    path = path_of_contact(table1((0.001, -0.001)), flank, 5)
    found = pressure_along(path, Load(torque_nm=1000.0))
    turning = np.cross((0.0, 0.0, 1.0), path.point)
    lever = np.abs(np.einsum("ni,ni->n", path.normal, turning))
    assert np.ptp(lever) > 1e-3
    assert found.force * lever == pytest.approx(1e6, rel=1e-12)


def spur(shaft_angle: float, parabola: float = 0.0) -> Design:
    """Two spur gears (module 4, 20 deg, 23 and 37 teeth) on axes that cross by the helix angles."""
    tool = Tool(4.0, radians(20.0), parabola=parabola)
    pinion, gear = (Member(tool, n, shaft_angle / 2.0, 0.0, 0.0, 30.0) for n in (23, 37))
    offset = sum(2.0 * n for n in (23, 37)) / cos(shaft_angle / 2.0)
    return Design(pinion, gear, Pair(offset, shaft_angle, 0.0, 0.0))


def test_crossed_cylinders() -> None:
    """Involute helicoids at the pitch point are cylinders of the radii r sin(alpha_t) / cos(beta_b), whose
    generators are the axes as the common normal projects them: they cross at chi,
    cos(chi) = (cos(Sigma) + sin^2(beta_b)) / cos^2(beta_b) for like helix angles (Johnson 4.3)."""
    angle = radians(30.0)
    found = pressure_along(path_of_contact(spur(angle), "right", l1=[0.0]), LOAD)
    transverse = np.arctan(np.tan(radians(20.0)) / cos(angle / 2.0))
    base = np.arcsin(sin(angle / 2.0) * cos(radians(20.0)))
    first, second = (cos(base) * cos(angle / 2.0) / (2.0 * n * sin(transverse)) for n in (23, 37))
    cosine = (cos(angle) + sin(base) ** 2) / cos(base) ** 2
    difference = sqrt(first**2 + second**2 + 2.0 * first * second * (2.0 * cosine**2 - 1.0))
    assert found.curvature[0].sum() == pytest.approx(first + second, rel=1e-9)
    assert np.ptp(found.curvature[0]) == pytest.approx(difference, rel=1e-9)


def test_the_strip_of_two_cylinders() -> None:
    """Spur gears: nearly parallel axes leave a long ellipse, across which p0 = E* b / (2 R); the force on its
    length is that of a strip, p0 = 2 q / (pi b) with q = 3 F / (4 a) in its middle."""
    found = pressure_along(path_of_contact(spur(1e-3), "right", 5), LOAD)
    assert (found.status == EllipseStatus.ELLIPSE).all()
    modulus, (a, b) = contact_modulus(210000.0, 0.3), found.semi_axes.T
    assert (b / a < 1e-3).all()
    radius = 1.0 / found.curvature[:, 1]
    assert found.pressure == pytest.approx(modulus * b / (2.0 * radius), rel=1e-4)
    assert found.pressure == pytest.approx(2.0 / (pi * b) * 0.75 * 1e4 / a, rel=1e-12)
    assert set(found.reaches.tolist()) <= {
        Limit.PINION_TOE,
        Limit.GEAR_TOE,
        Limit.PINION_HEEL,
        Limit.GEAR_HEEL,
    }


def test_line_contact_and_flanks_that_cut_have_no_pressure() -> None:
    found = pressure_along(path_of_contact(spur(1e-8), "right", 3), LOAD)
    assert (found.status == EllipseStatus.LINE_CONTACT).all()
    assert np.isnan(found.pressure).all()
    assert np.isfinite(found.force).all()
    design = table1((0.002, 0.002))
    cut = pressure_along(path_of_contact(design, "right", 3), LOAD)
    assert (cut.status == EllipseStatus.INTERFERENCE).all()
    assert np.isnan(cut.pressure).all()


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.002)])
def test_vertices_are_on_the_flanks_where_said(flank: str, parabola: tuple[float, float]) -> None:
    """By feet of perpendiculars from the vertices, exact, on either member."""
    design = table1(parabola)
    path = path_of_contact(design, flank, 41)
    found = pressure_along(path, Load(force=3000.0))
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
    assert np.array_equal(found.reaches[clear] == WHOLE, least[clear] > 0.0)
    assert 0 < np.count_nonzero(found.reaches == WHOLE) < 41 or flank == "right"


def test_the_angle_is_from_the_tooth_trace(flank: str) -> None:
    """A step along the major axis goes by cos(angle) along the trace: by differences of the flank."""
    design = table1((0.001, -0.001))
    path = path_of_contact(design, flank, 5)
    found = pressure_along(path, LOAD)
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


def test_the_same_pair_seen_otherwise(flank: str) -> None:
    design = table1((0.001, -0.0005), Errors(0.05, 0.0001, 0.1, -0.1))
    other = {"right": "left", "left": "right"}[flank]
    path = path_of_contact(design, flank, 4)
    wanted = pressure_along(path, LOAD)
    mirror = pressure_along(path_of_contact(mirrored(design), other, 4), LOAD)
    assert mirror.pressure == pytest.approx(wanted.pressure, rel=1e-9)
    assert mirror.angle == pytest.approx(wanted.angle, abs=1e-9)
    assert np.array_equal(mirror.reaches, wanted.reaches)
    bigger = pressure_along(path_of_contact(scaled(design, 2.0), flank, 4), replace(LOAD, force=4e4))
    assert bigger.pressure == pytest.approx(wanted.pressure, rel=1e-9)
    swapped = pressure_along(path_of_contact(exchanged(design), flank, l1=path.l2), LOAD)
    assert swapped.pressure == pytest.approx(wanted.pressure, rel=1e-7)


def test_batches_are_their_cases_one_by_one(flank: str) -> None:
    offsets = np.array([0.0, 0.05, 30.0])
    found = pressure_along(path_of_contact(table1(errors=Errors(offset=offsets)), flank, 5), LOAD)
    for k, offset in enumerate(offsets[:2]):
        alone = pressure_along(path_of_contact(table1(errors=Errors(offset=offset)), flank, 5), LOAD)
        for name in ("force", "pressure", "semi_axes", "angle", "reaches", "status"):
            np.testing.assert_allclose(getattr(found, name)[k], getattr(alone, name), rtol=1e-7)
    assert (found.status[2] == EllipseStatus.NO_CONTACT).all()
    assert np.isnan(found.pressure[2]).all()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, "give one of them"),
        ({"force": 1.0, "torque_nm": 1.0}, "give one of them"),
        ({"force": 0.0}, "force must be a finite number above 0 N, got 0"),
        ({"torque_nm": np.inf}, "torque_nm must be"),
        ({"force": 1.0, "young": np.nan}, "young must be"),
        ({"force": 1.0, "poisson": 0.6}, "poisson must be from 0 to 0.5, got 0.6"),
    ],
)
def test_loads_that_cannot_be_meant(values: dict[str, float], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Load(**values)
