"""Whole teeth: fillets against the sweep of the tool, lands, section, closed surfaces."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians, tan

import numpy as np
import pytest

from beveloid_geom.fillet import tool_round
from beveloid_geom.flank import tip_radius
from beveloid_geom.inputs import FloatArray, Member
from beveloid_geom.rack import reference_radius
from beveloid_geom.tooth import (
    Mesh,
    Patch,
    fillet_sheet,
    gear_mesh,
    tooth_patches,
    transverse_section,
)
from tests.oracle.table1 import table1

PINION, GEAR = table1().members
MEMBERS = {
    "pinion": PINION,
    "gear": GEAR,
    "convex": replace(PINION, tool=replace(PINION.tool, parabola=-0.004)),
    "concave": replace(PINION, tool=replace(PINION.tool, parabola=0.002)),
    "left-hand": replace(PINION, helix_angle=radians(-25.0)),
    "cylindrical": replace(PINION, cone_angle=0.0),
    "spur": replace(PINION, cone_angle=0.0, helix_angle=0.0, profile_shift=0.0),
    "sharp-tool": replace(GEAR, tool=replace(GEAR.tool, tip_radius=0.0)),
}
all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)


def patch_of(patches: tuple[Patch, ...], name: str) -> Patch:
    return next(patch for patch in patches if patch.name == name)


@all_members
@pytest.mark.parametrize("flank", ["right", "left"])
def test_fillet_joins_flank_and_bottom_land_smoothly(member: Member, flank: str) -> None:
    patches = tooth_patches(member, 0.02)
    flat, fillet, side = (patch_of(patches, f"{flank} {name}") for name in ("bottom land", "fillet", "flank"))
    np.testing.assert_allclose(fillet.points[-1], side.points[0], atol=1e-10)
    np.testing.assert_allclose(fillet.normals[-1], side.normals[0], atol=1e-12)
    np.testing.assert_allclose(flat.points[-1], fillet.points[0], atol=1e-10)
    np.testing.assert_allclose(flat.normals[-1], fillet.normals[0], atol=1e-12)


def distance_from_round(member: Member, flank: str, point: FloatArray, roll: FloatArray) -> FloatArray:
    """Distance of a gear point from the axis of the sliding tool's tip round, over rolls; the
    rack's pose written out by hand: turned by beta about x, then tilted by gamma about y."""
    beta, gamma, radius = float(member.helix_angle), float(member.cone_angle), float(reference_radius(member))
    x = np.cos(roll) * point[0] + np.sin(roll) * point[1] - radius
    y = np.cos(roll) * point[1] - np.sin(roll) * point[0] + radius * roll
    x = x - float(member.profile_shift * member.tool.normal_module)
    height = np.cos(gamma) * x - np.sin(gamma) * point[2]
    along = np.sin(gamma) * x + np.cos(gamma) * point[2]
    across = np.cos(beta) * y - np.sin(beta) * along
    centre = tool_round(member.tool, flank).centre
    return np.asarray(np.hypot(height - centre[0], across - centre[1]))


@all_members
@pytest.mark.parametrize("flank", ["right", "left"])
def test_fillet_is_as_deep_as_the_round_sweeps(member: Member, flank: str) -> None:
    sheet, rounding = fillet_sheet(member, flank), tool_round(member.tool, flank)
    p = np.linspace(0.5 * pi, rounding.angle, 7)
    for z in (-20.0, 0.0, 15.0):
        points, _ = sheet.place(p, np.full(7, z))
        for point in points:
            roll = np.linspace(-0.6, 0.6, 20001)
            distance = distance_from_round(member, flank, point, roll)
            nearest = int(np.argmin(distance))
            close = np.linspace(roll[nearest] - 1e-4, roll[nearest] + 1e-4, 2001)
            least = distance_from_round(member, flank, point, close).min()
            assert least == pytest.approx(rounding.radius, abs=1e-6)


@all_members
def test_lands_are_cones(member: Member) -> None:
    patches = tooth_patches(member, 0.02)
    module, gamma = float(member.tool.normal_module), float(member.cone_angle)
    tip = patch_of(patches, "tip land").points
    np.testing.assert_allclose(
        np.hypot(tip[..., 0], tip[..., 1]), tip_radius(member, tip[..., 2]), rtol=1e-13
    )
    root = patch_of(patches, "left bottom land").points
    pitch = float(reference_radius(member)) + float(member.profile_shift) * module
    expected = pitch - 1.25 * module / np.cos(gamma) + root[..., 2] * tan(gamma)
    np.testing.assert_allclose(np.hypot(root[..., 0], root[..., 1]), expected, rtol=1e-12)


def test_round_meets_the_flank_where_it_should() -> None:
    for parabola, height in ((0.0, -0.99997), (-0.001, -0.9954), (0.001, -1.0046)):
        tool = replace(PINION.tool, parabola=parabola)
        l, alpha = tool_round(tool, "right").joint, float(tool.normal_pressure_angle)
        x = l * np.cos(alpha) + parabola * l * l * np.sin(alpha)
        assert x / 6.0 == pytest.approx(height, abs=1e-4)


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_thickness_of_a_spur_gear(shift: float) -> None:
    member = replace(MEMBERS["spur"], profile_shift=shift)
    outline = transverse_section(member, 0.0, 1e-6)
    tooth = outline[: (len(outline) - 1) // 29]
    radius, angle = np.hypot(*tooth.T), np.arctan2(tooth[:, 1], tooth[:, 0])
    pitch = float(reference_radius(member))
    rising = slice(0, int(np.argmax(radius)) + 1)
    half = -np.interp(pitch, radius[rising], angle[rising])
    assert 2.0 * half * pitch == pytest.approx(6.0 * (0.5 * pi + 2.0 * shift * tan(radians(20.0))), abs=2e-6)


def test_section_has_no_point_twice_and_ends_where_it_starts() -> None:
    outline = transverse_section(GEAR, 3.0, 0.01)
    assert np.linalg.norm(np.diff(outline, axis=0), axis=1).min() > 1e-3
    np.testing.assert_array_equal(outline[0], outline[-1])


def assert_closed(mesh: Mesh) -> None:
    """Each edge is used by two faces, once in each direction."""
    _, merged = np.unique(np.round(mesh.points, 7), axis=0, return_inverse=True)
    faces = merged.reshape(-1)[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)])
    size = int(merged.max()) + 1
    ahead, counts = np.unique(edges[:, 0] * size + edges[:, 1], return_counts=True)
    assert counts.max() == 1
    assert np.array_equal(ahead, np.unique(edges[:, 1] * size + edges[:, 0]))


def volume(mesh: Mesh) -> float:
    a, b, c = mesh.points[mesh.faces.T]
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


@all_members
@pytest.mark.parametrize("teeth", [None, range(-1, 3)])
def test_gears_are_closed_and_wind_outwards(member: Member, teeth: range | None) -> None:
    mesh = gear_mesh(member, 0.05, teeth)
    assert_closed(mesh)
    a, b, c = mesh.points[mesh.faces.T]
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    flat = np.einsum("ni,ni->n", normal, mesh.normals[mesh.faces[:, 0]])
    assert (flat[size > 1e-9] > 0.0).all()
    assert volume(mesh) > 0.0


def test_volume_is_that_of_the_sections() -> None:
    bore = 40.0
    z = np.polynomial.legendre.leggauss(7)
    areas = []
    for place in 25.0 * z[0]:
        x, y = transverse_section(PINION, float(place), 1e-5).T
        areas.append(0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) - pi * bore**2)
    exact = 25.0 * float(z[1] @ areas)
    coarse, fine = (volume(gear_mesh(PINION, tolerance, bore_radius=bore)) for tolerance in (0.01, 0.001))
    assert abs(fine / exact - 1.0) < 1e-4
    assert abs(fine / exact - 1.0) < 0.2 * abs(coarse / exact - 1.0)


def test_parts_can_be_taken_out() -> None:
    mesh = gear_mesh(GEAR, 0.05, range(2))
    flank = mesh.of("right flank")
    assert 0 < len(flank.faces) < len(mesh.faces)
    assert len(flank.points) == len(np.unique(flank.faces))
    assert {"first side", "last side", "bore", "toe", "heel", "tip land"} <= set(mesh.names)


def test_a_pointed_tooth_is_refused() -> None:
    pointed = replace(PINION, teeth=9, profile_shift=0.9)
    with pytest.raises(ValueError, match=r"the tooth is pointed at z = 25 mm"):
        gear_mesh(pointed, 0.05)


def test_rounds_that_overlap_are_refused() -> None:
    concave = replace(PINION, tool=replace(PINION.tool, parabola=0.01))
    with pytest.raises(ValueError, match=r"tip_radius 0.38 is too large: the tool's rounds overlap by"):
        gear_mesh(concave, 0.05)


def test_a_bore_larger_than_the_root_is_refused() -> None:
    with pytest.raises(ValueError, match="bore_radius must be between 0 and the root radius"):
        gear_mesh(PINION, 0.05, bore_radius=95.0)
