"""Surfaces of one tooth: fillets against the sweep of the tool, lands, section; triangles for pictures."""

from __future__ import annotations

from math import pi, radians, tan

import numpy as np
import pytest

from beveloid_geom import Member, gear_solid
from beveloid_geom.gear.fillet import root_radius, tool_round
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.shapes.section import SIDES
from beveloid_geom.shapes.sheet import SheetGrid
from beveloid_geom.shapes.surface_mesh import gear_mesh
from beveloid_geom.shapes.tooth_boundary import (
    bottom_sheet,
    cut_sheets,
    fillet_sheet,
    outline_grids,
)
from tests.members import OTHERS as MEMBERS, PINION
from tests.oracle.tool_sweep import clearance_of_round

all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)


def grids_of(member: Member) -> dict[str, SheetGrid]:
    return outline_grids(cut_sheets(member), 0.02)


@all_members
def test_fillet_joins_flank_and_bottom_land_smoothly(member: Member, flank: str) -> None:
    grids = grids_of(member)
    flat, fillet, side = (grids[f"{flank} {name}"] for name in ("bottom", "fillet", "flank"))
    for lower, upper in ((flat, fillet), (fillet, side)):
        np.testing.assert_allclose(lower.points[-1], upper.points[0], atol=1e-10)
        np.testing.assert_allclose(lower.normals[-1], upper.normals[0], atol=1e-11)
        np.testing.assert_array_equal(lower.z, upper.z)
    edge = grids["tip"].points[-1 if flank == "right" else 0]
    np.testing.assert_allclose(side.points[-1], edge, atol=1e-10)


@all_members
def test_fillet_is_as_deep_as_the_round_sweeps(member: Member, flank: str) -> None:
    p = np.linspace(0.5 * pi, tool_round(member.tool, flank).angle, 7)
    for z in (-20.0, 0.0, 15.0):
        points, _ = fillet_sheet(member, flank).place(p, np.full(7, z))
        np.testing.assert_allclose(clearance_of_round(member, flank, points), 0.0, atol=1e-6)


@all_members
def test_bottom_lands_are_cones(member: Member) -> None:
    root, module = grids_of(member)["left bottom"].points[0], float(member.tool.normal_module)
    pitch = float(reference_radius(member)) + float(member.profile_shift) * module
    cone = float(member.cone_angle)
    expected = pitch - 1.25 * module / np.cos(cone) + root[..., 2] * tan(cone)
    np.testing.assert_allclose(np.hypot(root[..., 0], root[..., 1]), expected, rtol=1e-12)
    np.testing.assert_allclose(root_radius(member, root[..., 2]), expected, rtol=1e-14)


def test_a_narrow_bottom_land_includes_the_end_of_the_fillet() -> None:
    member = MEMBERS["narrow"]
    assert 0.0 < 0.5 * pi * 6.0 - tool_round(member.tool, "right").centre[1] < 0.02
    sheet, fillet = bottom_sheet(member, "right"), fillet_sheet(member, "right")
    width = float(sheet.upper(np.zeros(1))[0] - sheet.lower(np.zeros(1))[0])
    assert width == pytest.approx(0.02 * 6.0)
    assert float(fillet.lower(np.zeros(1))[0]) < 0.5 * pi - 0.04


@pytest.mark.parametrize("name", ["gear", "spur"])
@pytest.mark.parametrize("teeth", [None, range(2)])
def test_pictures_show_the_solid(name: str, teeth: range | None) -> None:
    """Pictures have the triangles of the solid, but surfaces do not share points."""
    member = MEMBERS[name]
    mesh = gear_mesh(member, 0.05, teeth)
    solid = gear_solid(member, 0.05, None if teeth is None else len(teeth))
    shown, true = (
        np.sort(np.round(surface.points[surface.faces].sum(axis=1), 7), axis=0) for surface in (mesh, solid)
    )
    np.testing.assert_allclose(shown, true, atol=1e-6)
    assert np.array_equal(np.bincount(mesh.part), np.bincount(solid.part))


@all_members
def test_normals_are_those_of_the_surfaces(member: Member) -> None:
    """Triangles face along the normals of the surfaces, which are exact on cones, planes and cylinders."""
    mesh, gamma = gear_mesh(member, 0.05, range(-1, 1)), float(member.cone_angle)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-12)
    a, b, c = mesh.points[mesh.faces.T]
    normal = np.cross(b - a, c - a)
    facing = np.einsum("ni,nki->nk", normal, mesh.normals[mesh.faces]) / np.linalg.norm(
        normal, axis=1, keepdims=True
    )
    assert facing.min() > 0.9
    for name, axial in (("toe", -1.0), ("heel", 1.0), ("bore", 0.0), ("tip", -np.sin(gamma))):
        np.testing.assert_allclose(mesh.of(name).normals[:, 2], axial, atol=1e-12)
    for name in SIDES:
        angle = np.arctan2(*mesh.of(name).points[:, 1::-1].T)
        assert (angle < 0.0).all() if name == SIDES[0] else (angle > -0.25).all()


def test_normals_of_cut_sides_do_not_depend_on_the_mesh() -> None:
    """At the corners of the side, coarse and fine meshes have the same points. Differences over the uneven
    stations along z give the direction of the root there."""
    corners = []
    for tolerance in (0.05, 0.0005):
        mesh = gear_mesh(PINION, tolerance, [0])
        side = mesh.where(mesh.is_of("first side"))
        order = np.lexsort((np.hypot(*side.points[:, :2].T), side.points[:, 2]))[[0, -1]]
        corners.append((side.points[order], side.normals[order]))
    (coarse, normals), (fine, exact) = corners
    np.testing.assert_allclose(coarse, fine, atol=1e-9)
    assert np.linalg.norm(normals - exact, axis=-1).max() < radians(0.02)
