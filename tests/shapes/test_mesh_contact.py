"""Contact by meshes: closest points against brute force, separations and contacts against the exact flanks,
and errors without refinement."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
import pytest

from beveloid_geom import ContactPath, Design, Errors, Status, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.flank_pair import pairing_of
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.operation.angular_clearance import angular_clearance, surface_of
from beveloid_geom.pair.frames import layout_of, member_frame
from beveloid_geom.shapes.proximity.closest_points import closest_on_mesh
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.shapes.proximity.mesh_convergence import convergence
from beveloid_geom.shapes.proximity.mesh_separation import mesh_separation
from beveloid_geom.shapes.sheet import Faces
from tests.oracle.table1 import table1


def on_triangle(points: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return squared distances (n, m) of points (n, 3) from triangles with corners (m, 3) or (n, m, 3)."""
    p = points[:, None]
    normal = np.cross(b - a, c - a)
    height = dots(p - a, normal) ** 2 / dots(normal, normal)
    inside = np.ones(height.shape, dtype=bool)
    edges = []
    for start, stop in ((a, b), (b, c), (c, a)):
        side = stop - start
        inside &= dots(p - start, np.cross(normal, side)) >= 0.0
        share = np.clip(dots(p - start, side) / dots(side, side), 0.0, 1.0)
        edges.append(((p - start - share[..., None] * side) ** 2).sum(axis=-1))
    return np.asarray(np.where(inside, height, np.min(edges, axis=0)))


def dots(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def check_against_all(points: FloatArray, faces: Faces, queries: FloatArray) -> None:
    found, index, weights = closest_on_mesh(points, faces, queries)
    distance = np.linalg.norm(queries - found, axis=-1)
    exact = np.sqrt(on_triangle(queries, *np.moveaxis(points[faces], 1, 0)))
    assert np.abs(distance - exact.min(axis=1)).max() < 1e-12
    assert np.abs(np.take_along_axis(exact, index[:, None], axis=1)[:, 0] - distance).max() < 1e-12
    assert np.abs(np.einsum("nk,nki->ni", weights, points[faces[index]]) - found).max() < 1e-11
    assert weights.min() > -1e-9
    assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-12


@pytest.mark.parametrize("spread", [0.05, 2.0, 60.0])
@pytest.mark.parametrize("tolerance", [0.05, 0.002])
def test_closest_points_on_flanks_are_exact(spread: float, tolerance: float) -> None:
    mesh = flank_mesh(table1().gear, "right", tolerance)
    points = mesh.grid.points.reshape(-1, 3)
    random = np.random.default_rng(3)
    queries = points[random.integers(0, len(points), 150)] + random.normal(0.0, spread, (150, 3))
    check_against_all(points, mesh.faces, np.concatenate((queries, points[:5])))


def test_invalid_meshes_are_rejected() -> None:
    points, one = np.eye(3), np.array([[0, 1, 2]])
    with pytest.raises(ValueError, match="no triangles"):
        closest_on_mesh(points, one[:0], points)
    with pytest.raises(ValueError, match="finite"):
        closest_on_mesh(points, one, points * np.nan)
    with pytest.raises(ValueError, match="no area"):
        closest_on_mesh(points, np.array([[0, 0, 1]]), points)


def test_the_rim_is_the_border_of_the_grid() -> None:
    mesh = flank_mesh(table1().pinion, "left", 0.01)
    rows, columns = mesh.grid.l.shape
    assert mesh.rim.sum() == 2 * (rows - 1 + columns - 1)


def test_normals_of_triangles_edges_and_corners_point_out_of_the_tooth() -> None:
    """Otherwise the sign would be wrong for points closest to an edge or a corner."""
    mesh = flank_mesh(table1().gear, "right", 0.01)
    exact = mesh.grid.normals.reshape(-1, 3)[mesh.faces]
    assert dots(mesh.normals[:, 4:], exact).min() > 0.999
    assert dots(mesh.normals, exact.mean(axis=1)[:, None]).min() > 0.99


class Pose(TypedDict):
    pinion_roll: float
    gear_roll: float


def pose_at(path: ContactPath, k: int) -> Pose:
    return {"pinion_roll": float(path.pinion_roll[k]), "gear_roll": float(path.gear_roll[k])}


@pytest.mark.parametrize("member", [0, 1])
@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_agreement_with_angular_clearance(flank: str, member: int, parabola: tuple[float, float]) -> None:
    """Angular clearance is exact without parabola, otherwise up to the square of the gap. Points are
    compared only if angular clearance also starts and ends on flanks and not on fillets: the round of the
    tool begins 0.0002 mm inside the active profile."""
    design = table1(parabola)
    path = path_of_contact(design, flank, 5)
    own, other = (surface_of(design.members[j], flank).joint for j in (member, 1 - member))
    for k in (0, 2, 4):
        pose = pose_at(path, k)
        found = mesh_separation(design, flank, member, 0.0003, **pose)
        turned = angular_clearance(design, flank, member, found.l, found.z, **pose)
        solved = (found.status == Status.SOLVED) & (turned.other_l >= other) & (found.l >= own)
        assert solved.sum() > 0.6 * solved.size
        error = np.abs(found.separation - turned.distance)[solved]
        if parabola == (0.0, 0.0):
            assert error.max() < 1e-11
        else:
            near = np.abs(turned.distance[solved]) < 0.02
            assert near.sum() > 10
            assert error[near].max() < 1e-7


def test_overlap_is_negative() -> None:
    """The gear is rotated into the pinion by 0.1 mm along the normal."""
    design = table1()
    pose = pose_at(path_of_contact(design, "right", 3), 1)
    lever = 0.5 * 6.0 * 45.0 * np.cos(np.radians(20.0))
    apart = mesh_separation(design, "right", 0, 0.001, **pose)
    pose["gear_roll"] += 0.1 / lever
    for polish in (False, True):
        found = mesh_separation(design, "right", 0, 0.001, **pose, polish=polish)
        shift = (found.separation - apart.separation)[found.status == Status.SOLVED]
        assert np.nanmax(np.abs(shift + 0.1)) < (1e-11 if polish else 1.1e-3)
        assert np.nanmin(found.separation) < -0.09


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_refined_contact_is_on_the_path(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola, Errors(offset=0.05, shaft_angle=0.0002))
    path = path_of_contact(design, flank, 7)
    for k in (1, 3, 5):
        for tolerance in (0.1, 0.004):
            found = mesh_contact(design, flank, tolerance, **pose_at(path, k))
            assert found.status == Status.SOLVED
            assert abs(found.separation) < 1e-12
            assert np.abs(found.point - path.point[k]).max() < 1e-7
            assert np.abs(found.l - (path.l1[k], path.l2[k])).max() < 1e-7
            assert np.abs(found.z - (path.pinion_z[k], path.gear_z[k])).max() < 1e-7


def test_contact_of_flanks_with_a_gap(flank: str) -> None:
    """The smallest distance of two involute helicoids grows linearly with the rotation."""
    design = table1()
    pose = pose_at(path_of_contact(design, flank, 3), 1)
    lever = {"right": -1.0, "left": 1.0}[flank] * 0.5 * 6.0 * 45.0 * np.cos(np.radians(20.0))
    position = pairing_of(design, flank).position[:, 0, 0]
    for gap in (0.5, -0.2):
        roll = pose["gear_roll"] + gap / lever
        found = mesh_contact(design, flank, 0.01, pinion_roll=pose["pinion_roll"], gear_roll=roll)
        assert found.status == Status.SOLVED
        assert abs(found.separation - gap) < 1e-11
        for j, member in enumerate(design.members):
            frame = member_frame(layout_of(design), j, (pose["pinion_roll"], roll)[j], position[j])
            seen = feet(member, flank, (found.point - frame[1]) @ frame[0])
            assert abs(seen.distance - 0.5 * gap) < 1e-11
            assert abs(seen.l - found.l[j]) < 1e-6
            assert abs(seen.z - found.z[j]) < 1e-6


def test_contact_of_triangles_is_on_both_flanks(flank: str) -> None:
    """The contact point is on both flanks, whichever member has the nearest vertex."""
    design = table1((0.001, -0.001))
    pose = pose_at(path_of_contact(design, flank, 3), 1)
    position = pairing_of(design, flank).position[:, 0, 0]
    for tolerance in (0.03, 0.02, 0.01, 0.005, 0.002, 0.001):
        found = mesh_contact(design, flank, tolerance, **pose, polish=False)
        for j, member in enumerate(design.members):
            frame = member_frame(
                layout_of(design), j, (pose["pinion_roll"], pose["gear_roll"])[j], position[j]
            )
            seen = feet(member, flank, (found.point - frame[1]) @ frame[0])
            assert abs(seen.distance) < 2.0 * tolerance
            assert np.hypot(seen.l - found.l[j], seen.z - found.z[j]) < 0.1


def test_convergence(flank: str) -> None:
    """Separations converge with the tolerance. Contact points converge irregularly, and in approximate line
    contact, on the right flank, they are wrong by millimetres."""
    sizes = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003]
    rough, fine = (convergence(table1(), flank, sizes, polish=polish) for polish in (False, True))
    rate = np.polyfit(np.log(sizes), np.log(rough.separation_error), 1)[0]
    assert 0.9 < rate < 1.1
    assert (rough.separation_error <= sizes).all()
    assert fine.separation_error.max() < 1e-12
    assert fine.point_error.max() < 1e-8
    assert (np.diff(rough.faces) > 0).all()
    assert rough.point_error.max() > 5.0
    assert not (np.diff(rough.point_error) < 0.0).all()
    along = convergence(table1(), flank, [0.003], share=0.2)
    assert along.point_error[0] < 1e-8


def test_batches_are_rejected() -> None:
    design: Design = table1((0.0, 0.0), Errors(offset=np.zeros(2)))
    with pytest.raises(ValueError, match="design must be a single design, got arrays of shape"):
        mesh_contact(design, "right", pinion_roll=0.0, gear_roll=0.0)
    with pytest.raises(ValueError, match="no contact: the contact of meshes cannot be compared"):
        convergence(table1((0.0, 0.0), Errors(offset=30.0)), "right", [0.01])
