"""Hexahedra of teeth: nodes on the surfaces, exact volumes, shapes, sets, joints."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from math import pi, radians

import numpy as np
import pytest

from beveloid_geom import Member, tooth_hexahedra
from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.gear.fillet import root_radius
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.gear.tooth_side import angle_of, cut_at, profile_at, surface_of
from beveloid_geom.gear.undercut import undercut_of
from beveloid_geom.shapes.element_sizes import Cells, cells_of
from beveloid_geom.shapes.hexahedral_mesh import (
    EDGES,
    ELEMENT_FACES,
    VolumeMesh,
    determinants,
    element_shapes,
    face_nodes,
    rounded_down,
)
from beveloid_geom.shapes.solid import NAMES
from tests.members import GEAR, MEMBERS, PINION
from tests.oracle.tooth_volume import exact_volume

all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)
SOME = {name: MEMBERS[name] for name in ("pinion", "gear", "cone 20", "concave")}
some_members = pytest.mark.parametrize("member", SOME.values(), ids=SOME)
both_orders = pytest.mark.parametrize("element", ["C3D8", "C3D20"])
FEW = Cells(bottom=1, fillet=4, flank=4, tip=4, face=4)


@cache
def few(member: Member, element: str, teeth: int | None = 1) -> VolumeMesh:
    return tooth_hexahedra(member, teeth, element, cells=FEW, bore_radius=bore_of(member))


def bore_of(member: Member) -> float:
    return 0.8 * float(root_radius(member, -0.5 * float(member.face_width)))


def volume(mesh: VolumeMesh) -> float:
    values, weights = determinants(mesh)
    return float((values @ weights).sum())


def polar(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])


# Nodes


@some_members
@pytest.mark.parametrize("part", ["flank", "fillet"])
def test_nodes_are_on_flank_and_fillet(member: Member, flank: str, part: str) -> None:
    """The angle of each node equals the angle of the surface at its radius and in its plane."""
    mesh, surface = few(member, "C3D20"), surface_of(member, flank)
    points = mesh.points[mesh.node_sets[f"{flank} {part}"]]
    radius, angle = polar(points)
    with np.errstate(invalid="ignore"):
        s = profile_at(surface, radius**2, points[:, 2])
    floor = surface.bottom + 0.1 * (surface.joint - surface.bottom)
    inner = s > floor  # below, the fillet is nearly parallel to the root cone: a radius gives no point
    assert inner.sum() > 0.7 * len(s)
    exact = angle_of(cut_at(surface, s[inner], points[inner, 2]))
    apart = radius[inner] * np.abs(np.remainder(exact - angle[inner] + pi, 2.0 * pi) - pi)
    assert apart.max() < 1e-9
    if part == "flank":
        assert (s[inner] > surface.joint - 1e-9).all()
    else:
        assert (s[inner] < surface.joint + 1e-9).all()


@some_members
def test_nodes_are_on_the_other_surfaces(member: Member) -> None:
    mesh, half = few(member, "C3D20"), 0.5 * float(member.face_width)
    on = {name: mesh.points[mesh.node_sets[name]] for name in NAMES}
    for name, expected in (("tip", tip_radius), ("bottom", root_radius)):
        radius = polar(on[name])[0]
        np.testing.assert_allclose(radius, expected(member, on[name][:, 2]), rtol=1e-12)
    np.testing.assert_allclose(polar(on["bore"])[0], bore_of(member), rtol=1e-13)
    assert (on["toe"][:, 2] == -half).all()
    assert (on["heel"][:, 2] == half).all()
    first, last = (
        points[np.lexsort(np.round((polar(points)[0], points[:, 2]), 8))]
        for points in (on["first side"], on["last side"])
    )
    turn = np.exp(2.0j * pi / float(member.teeth))
    np.testing.assert_allclose((first[:, :2] @ (1.0, 1.0j)) * turn, last[:, :2] @ (1.0, 1.0j), atol=1e-10)


def test_elements_with_8_and_20_nodes_share_their_corners() -> None:
    small, large = few(PINION, "C3D8"), few(PINION, "C3D20")
    np.testing.assert_array_equal(small.points[small.hexahedra], large.points[large.hexahedra[:, :8]])


@both_orders
def test_every_node_is_used_and_unique(element: str) -> None:
    mesh = few(PINION, element, 3)
    assert np.array_equal(np.unique(mesh.hexahedra), np.arange(len(mesh.points)))
    assert len(np.unique(np.round(mesh.points, 6), axis=0)) == len(mesh.points)


# Volumes


@some_members
@pytest.mark.parametrize(("element", "order", "error"), [("C3D8", 2, 5e-4), ("C3D20", 4, 2e-6)])
def test_volume_converges_to_the_exact_one(member: Member, element: str, order: int, error: float) -> None:
    bore = bore_of(member)
    exact = exact_volume(member, 1, bore)
    off = [
        abs(volume(tooth_hexahedra(member, 1, element, bore_radius=bore, cells=cells)) / exact - 1.0)
        for cells in (Cells(1, 4, 5, 4, 4), Cells(2, 8, 10, 8, 8))
    ]
    assert off[0] < 4.0 * error
    assert off[0] / off[1] == pytest.approx(2.0**order, rel=0.35)


# Shapes


@all_members
@pytest.mark.parametrize("share", [0.4, 0.95])
def test_elements_are_well_shaped(member: Member, share: float) -> None:
    mesh = tooth_hexahedra(member, tolerance=0.1, bore_radius=share / 0.8 * bore_of(member))
    assert element_shapes(mesh)[0].min() > 0.5
    values, _ = determinants(mesh)
    assert (values.min(axis=1) / values.max(axis=1)).min() > 0.25
    x = mesh.points[mesh.hexahedra]
    a, b = (x[:, [ends[k] for ends in EDGES]] for k in (0, 1))
    off = np.linalg.norm(x[:, 8:] - 0.5 * (a + b), axis=-1) / np.linalg.norm(b - a, axis=-1)
    assert off.max() < 0.1


UNDERCUT = {
    # teeth, helix and cone angle (deg), profile shift, face width (modules); drawn at random
    "thin tip at the heel": (19, -8.642, 7.220, 0.3469, 13.358),
    "undercut deeply": (17, 5.017, 7.722, 0.0855, 13.720),
    "onset in the face": (18, -20.137, 8.735, 0.2328, 13.330),
}


@pytest.mark.parametrize("values", UNDERCUT.values(), ids=UNDERCUT)
def test_undercut_members_are_meshed(values: tuple[int, float, float, float, float]) -> None:
    """Undercut members are meshed with good shapes and the exact volume. Elements taper to a thin tip, and
    the flank starts at its base circle where undercut begins."""
    teeth, helix, cone, shift, width = values
    member = Member(PINION.tool, teeth, radians(helix), radians(cone), shift, 6.0 * width)
    assert any(undercut_of(member, flank).undercut for flank in FLANK_SIGN)
    mesh = tooth_hexahedra(member)
    assert min(quality.min() for quality in element_shapes(mesh)) > 0.25
    exact = exact_volume(member, 1, bore_of(member))
    assert volume(tooth_hexahedra(member, bore_radius=bore_of(member))) == pytest.approx(exact, rel=5e-5)


@pytest.mark.parametrize("name", ["pinion", "gear", "spur", "12 teeth"])
def test_sizes_do_not_jump_along_the_profile(name: str, flank: str) -> None:
    mesh = tooth_hexahedra(MEMBERS[name], 1, "C3D8")
    nodes = np.union1d(mesh.node_sets[f"{flank} flank"], mesh.node_sets[f"{flank} fillet"])
    points = mesh.points[np.intersect1d(nodes, mesh.node_sets["heel"])]
    points = points[np.argsort(polar(points)[0])]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    jump = steps[1:] / steps[:-1]
    assert jump.min() > 0.55
    assert jump.max() < 1.7


@pytest.mark.parametrize(("member", "least"), [(PINION, "0.72"), (GEAR, "0.80")], ids=["pinion", "gear"])
def test_scaled_jacobians_of_the_documentation(member: Member, least: str) -> None:
    """The smallest scaled Jacobians of the default mesh are those of the documentation, rounded down (0.8083
    for the gear). Corners alone would give 0.76 and 0.87."""
    mesh = tooth_hexahedra(member)
    quality = float(element_shapes(mesh)[0].min())
    assert rounded_down(quality) == least
    assert float(least) <= quality
    assert 5_000 < len(mesh.points) < 30_000


# Sets


@both_orders
@pytest.mark.parametrize("teeth", [1, 3])
def test_each_free_face_is_in_one_surface(element: str, teeth: int) -> None:
    mesh = few(PINION, element, teeth)
    every = np.indices((len(mesh.hexahedra), 6)).reshape(2, -1).T
    keys = np.sort(mesh.hexahedra[every[:, :1], np.array(ELEMENT_FACES)[every[:, 1]]], axis=1)
    _, place, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    free = every[counts[place.ravel()] == 1]
    assert counts.max() == 2
    assert set(NAMES) <= set(mesh.surfaces)
    named = np.concatenate([mesh.surfaces[name] for name in NAMES])
    assert len(named) == len(free)
    np.testing.assert_array_equal(np.unique(named, axis=0), np.unique(free, axis=0))


@both_orders
@pytest.mark.parametrize("teeth", [1, 3, None])
def test_sets_are_sorted_and_of_all_teeth(element: str, teeth: int | None) -> None:
    member = MEMBERS["12 teeth"]
    mesh = few(member, element, teeth)
    count = int(member.teeth) if teeth is None else teeth
    names = set(NAMES) if teeth else set(NAMES) - {"first side", "last side"}
    plain = {name for name in mesh.surfaces if not re.search(r" \d+$", name)}
    assert plain == names
    assert set(mesh.surfaces) == set(mesh.node_sets) == set(mesh.element_sets)
    for name, faces in mesh.surfaces.items():
        np.testing.assert_array_equal(mesh.node_sets[name], np.unique(face_nodes(mesh, faces)))
        np.testing.assert_array_equal(mesh.element_sets[name], np.unique(faces[:, 0]))
        each = [mesh.surfaces.get(f"{name} {number}") for number in range(1, count + 1)]
        if name in plain and count > 1 and "side" not in name:
            np.testing.assert_array_equal(np.concatenate([own for own in each if own is not None]), faces)


# Teeth


@both_orders
def test_teeth_join(element: str) -> None:
    one, three = few(PINION, element), few(PINION, element, 3)
    shared = len(one.node_sets["first side"])
    assert len(three.points) == 3 * len(one.points) - 2 * shared
    assert volume(three) == pytest.approx(3.0 * volume(one), rel=1e-12)
    for name in ("right flank", "tip"):
        angle = [polar(three.points[three.node_sets[f"{name} {number}"]])[1] for number in (1, 2, 3)]
        np.testing.assert_allclose(angle[1].mean() - angle[0].mean(), 2.0 * pi / 29.0, rtol=1e-9)
        np.testing.assert_allclose(angle[2].mean() - angle[1].mean(), 2.0 * pi / 29.0, rtol=1e-9)


@both_orders
def test_teeth_with_different_flank_cells_join(element: str) -> None:
    """The mesh consists of the fine and the coarse teeth, and no node exists twice."""
    cells = FEW, replace(FEW, flank=11), FEW
    mesh = tooth_hexahedra(PINION, 3, element, cells=cells, bore_radius=bore_of(PINION))
    coarse = few(PINION, element)
    fine = tooth_hexahedra(PINION, 1, element, cells=cells[1], bore_radius=bore_of(PINION))
    shared = len(coarse.node_sets["first side"])
    assert len(mesh.points) == 2 * len(coarse.points) + len(fine.points) - 2 * shared
    assert len(np.unique(np.round(mesh.points, 6), axis=0)) == len(mesh.points)
    assert volume(mesh) == pytest.approx(2.0 * volume(coarse) + volume(fine), rel=1e-12)
    assert [len(mesh.surfaces[f"left flank {k}"]) for k in (1, 2, 3)] == [16, 44, 16]


@both_orders
@pytest.mark.parametrize("teeth", [None, 12])
def test_a_complete_gear_is_closed(element: str, teeth: int | None) -> None:
    member = MEMBERS["12 teeth"]
    one, whole = few(member, element), few(member, element, teeth)
    assert len(np.unique(np.round(whole.points, 6), axis=0)) == len(whole.points)
    assert not any("side" in name for name in (*whole.surfaces, *whole.node_sets))
    assert len(whole.points) == 12 * (len(one.points) - len(one.node_sets["first side"]))
    assert volume(whole) == pytest.approx(12.0 * volume(one), rel=1e-12)


# Sizes


def distance_from_flanks(member: Member, mesh: VolumeMesh) -> float:
    """Return the largest distance of the middles of the flank faces with 4 nodes."""
    worst = 0.0
    for flank in ("left", "right"):
        surface, nodes = surface_of(member, flank), face_nodes(mesh, mesh.surfaces[f"{flank} flank"])
        middle = mesh.points[nodes].mean(axis=1)
        radius, angle = polar(middle)
        cut = cut_at(surface, s := profile_at(surface, radius**2, middle[:, 2]), middle[:, 2])
        assert np.isfinite(s).all()
        apart = (angle_of(cut) - angle) * (cut.x * cut.ny - cut.y * cut.nx)
        worst = max(worst, float(np.abs(apart).max()))
    return worst


@some_members
@pytest.mark.parametrize("tolerance", [0.05, 0.005])
def test_elements_with_8_nodes_stay_near_the_flank(member: Member, tolerance: float) -> None:
    mesh = tooth_hexahedra(member, 1, "C3D8", tolerance)
    assert distance_from_flanks(member, mesh) < tolerance


def test_fine_elements_of_a_bent_flank_stay_near_it() -> None:
    """Fine elements keep the tolerance near the base cylinder, where deviations decrease more slowly at first
    than with the square of the number of elements."""
    member = replace(MEMBERS["12 teeth"], face_width=70.0, helix_angle=-0.33)
    cells = replace(cells_of(member, 0.0006), tip=6)
    mesh = tooth_hexahedra(member, 1, "C3D8", cells=cells, bore_radius=1.2 * bore_of(member))
    assert 0.0002 < distance_from_flanks(member, mesh) < 0.0006


def test_smaller_tolerances_take_more_elements() -> None:
    cells = [cells_of(PINION, tolerance) for tolerance in (0.1, 0.02, 0.004)]
    for name in ("fillet", "flank", "tip", "face"):
        numbers = [getattr(own, name) for own in cells]
        assert numbers == sorted(numbers)
        assert numbers[0] < numbers[-1]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"teeth": None, "cells": Cells(9, 20, 50, 50, 90)}, "the mesh needs about .* nodes for 29 teeth"),
        ({"cells": Cells(1, 1, 4, 4, 4)}, "a fillet must have at least 2 cells, got 1"),
        ({"cells": Cells(1, 4, 0, 4, 4)}, "cells must be 1 or more, got flank=0"),
        ({"teeth": 2, "cells": [FEW]}, "cells must be given for 2 teeth and may differ only in `flank`, got"),
        ({"teeth": 2, "cells": [FEW, replace(FEW, tip=5)]}, "cells must be given for 2 teeth"),
    ],
)
def test_invalid_arguments_are_rejected(values: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        tooth_hexahedra(PINION, **values)  # type: ignore[arg-type]


def test_default_tolerance_scales_with_the_module() -> None:
    """The mesh of a gear of one tenth of the size has the same elements."""
    tool = replace(PINION.tool, normal_module=0.1 * PINION.tool.normal_module)
    small = replace(PINION, tool=tool, face_width=0.1 * PINION.face_width)
    counts = [len(tooth_hexahedra(member, 1, "C3D8").hexahedra) for member in (PINION, small)]
    assert counts[0] == counts[1]
