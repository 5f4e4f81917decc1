"""Contact by meshes under adverse conditions: very coarse, far from the origin, and between equally
near edges and teeth. Every result is correct within its stated doubt, or missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Pair,
    Status,
    first_contact,
    path_of_contact,
    sample_flank,
)
from beveloid_geom.operation.engagement import conjugate_phase, pitch_point_roll
from beveloid_geom.shapes.proximity.closest_points import closest_on_mesh
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from beveloid_geom.shapes.proximity.mesh_contact import MeshContact, mesh_contact
from beveloid_geom.shapes.proximity.mesh_separation import mesh_separation
from beveloid_geom.status import FirstStatus
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import Pose, on_triangle, pose_at
from tests.symmetry import exchanged

FLANKS = ("right", "left")


def check_both(design: Design, path: ContactPath, k: int, tolerance: float) -> MeshContact:
    """Check the contact of the facets within their error estimate, and the polished contact against the path;
    return the contact of the facets."""
    at = pose_at(path, k)
    rough = mesh_contact(design, path.flank, tolerance, **at, polish=False)
    assert np.linalg.norm(rough.point - path.point[k]) <= rough.doubt
    assert check_polished(mesh_contact(design, path.flank, tolerance, **at), path, k)
    return rough


def check_polished(found: MeshContact, path: ContactPath, k: int) -> bool:
    """Check that the result is the contact of the path within its error estimate, or missing; return whether
    a contact was found."""
    if found.status != Status.SOLVED:
        assert np.isnan((*found.point, *found.l, *found.z, found.separation, found.doubt)).all()
        return False
    assert found.doubt < 2e-7
    assert abs(found.separation) < 1e-11
    assert np.linalg.norm(found.point - path.point[k]) <= found.doubt + 1e-11
    return True


@pytest.mark.parametrize("tolerance", [5.0, 1.0, 0.1])
def test_far_too_coarse(tolerance: float, flank: str) -> None:
    """Meshes of down to a single cell: the error of the facets can be centimetres and is within their error
    estimate, and the polished contact is that of the path."""
    design = table1((0.001, -0.001), Errors(0.05, 1e-4))
    assert sample_flank(design.pinion, flank, 5.0).l.shape == (2, 2)
    path = path_of_contact(design, flank, 7)
    for k in (1, 3, 5):
        rough = check_both(design, path, k, tolerance)
        assert rough.status == Status.SOLVED
        assert np.linalg.norm(rough.point - path.point[k]) > 0.1
        assert abs(rough.separation) <= 2.0 * tolerance


def test_error_estimate_of_facets_includes_the_contact() -> None:
    """Random pairs, poses and tolerances, with gaps and overlaps of the flanks."""
    random, seen = np.random.default_rng(8), 0
    for _ in range(60):
        parabola = random.choice([0.0, 1e-4, 3e-4, 1e-3, 2e-3], 2) * random.choice([-1, 1], 2)
        design = table1(tuple(parabola), Errors(random.uniform(-0.5, 0.5), random.uniform(-2e-4, 2e-4)))
        flank = str(random.choice(FLANKS))
        path = path_of_contact(design, flank, 9)
        if not path.l1.size:
            continue
        at = pose_at(path, int(random.integers(1, 8)))
        at["gear_roll"] += random.uniform(-0.1, 0.1) / 130.0
        tolerance = float(10.0 ** random.uniform(-3.5, 0.6))
        exact = mesh_contact(design, flank, 1e-3, **at)
        rough = mesh_contact(design, flank, tolerance, **at, polish=False)
        if exact.status != Status.SOLVED or rough.status != Status.SOLVED:
            continue
        seen += 1
        assert np.linalg.norm(rough.point - exact.point) <= rough.doubt + exact.doubt
        assert abs(rough.separation - exact.separation) <= 3.0 * tolerance
    assert seen > 40


def test_no_position_is_nearer_than_a_polished_contact() -> None:
    """If edges or a saddle are nearer than the tangency, there is no contact, with a status."""
    random, seen = np.random.default_rng(5), 0
    for _ in range(40):
        a = float(random.uniform(1e-4, 8e-4))
        design = table1((a, a), Errors(random.uniform(-0.3, 0.3)))
        roll = float(pitch_point_roll(design, "right")) + random.uniform(-0.08, 0.08)
        gear = float(conjugate_phase(design, "right")) - 29.0 / 45.0 * roll + random.uniform(-1e-3, 1e-3)
        at: Pose = {"pinion_roll": roll, "gear_roll": gear}
        found = mesh_contact(design, "right", float(random.choice([1.0, 0.03, 0.003])), **at)
        if found.status == Status.SOLVED:
            seen += 1
            sides = [mesh_separation(design, "right", j, 0.001, **at).separation for j in (0, 1)]
            assert min(np.nanmin(side) for side in sides) > found.separation - 1e-10
    assert 2 < seen < 38


def test_a_corner_on_the_rim_counts_as_the_rim() -> None:
    """A point of the gear 5 mm beyond the heel of the pinion is outside. It was once reported as 5 mm of
    overlap, because only a corner of the nearest triangle was on the rim."""
    design = table1((0.0001, 0.0), Errors(0.4797332580848761, -7.711168777564407e-05))
    path = path_of_contact(design, "right", 9)
    for tolerance in (0.0011826437646076965, 0.0012, 0.002, 0.003, 0.01):
        for k in (1, 4, 7):
            rough = mesh_contact(design, "right", tolerance, **pose_at(path, k), polish=False)
            assert abs(rough.separation) < 3.0 * tolerance
        side = mesh_separation(design, "right", 1, tolerance, **pose_at(path, 1), polish=False)
        exact = mesh_separation(design, "right", 1, tolerance, **pose_at(path, 1))
        both = (side.status == Status.SOLVED) & (exact.status == Status.SOLVED)
        assert np.abs(side.separation - exact.separation)[both].max() <= tolerance


def narrow(width: float) -> tuple[Design, ContactPath]:
    """Return a pinion of the given width, moved so that its path passes through mid-face."""
    z = float(path_of_contact(table1(), "left", 3).pinion_z[1])
    design = table1(errors=Errors(pinion_axial=z))
    design = replace(design, pinion=replace(design.pinion, face_width=width))
    return design, path_of_contact(design, "left", 3)


@pytest.mark.parametrize("slender", [1.0, 1e4, 1e6, 1e8])
@pytest.mark.parametrize("shift", [0.0, 1e4])
def test_closest_points_on_slender_triangles_far_away(slender: float, shift: float) -> None:
    """Distances are exact to the rounding of the coordinates for any shape of the triangles. At 10 m the
    rounding is 2e-12 mm."""
    random = np.random.default_rng(1)
    points = random.normal(size=(90, 3)) * (100.0, 100.0 / slender, 1.0) + shift
    faces = np.arange(90).reshape(30, 3)
    queries = points[random.integers(0, 90, 100)] + random.normal(size=(100, 3)) * 5.0
    found, index, weights = closest_on_mesh(points, faces, queries)
    noise = 8.0 * np.spacing(np.abs(points).max() + 300.0)
    exact = np.sqrt(on_triangle(queries - shift, *np.moveaxis((points - shift)[faces], 1, 0)).min(axis=1))
    assert np.abs(np.linalg.norm(queries - found, axis=1) - exact).max() <= noise
    back = np.einsum("nk,nki->ni", weights, points[faces[index]])
    assert np.abs(back - found).max() <= 4.0 * noise
    assert weights.min() > -1e-9


def test_single_precision_far_away_is_refused_where_triangles_vanish() -> None:
    """At 10 m vertices are at least 0.001 mm apart. The result is that of the rounded mesh within this
    distance; smaller triangles have no area and cause an error."""
    mesh = flank_mesh(table1().gear, "right", 0.002)
    points = mesh.grid.points.reshape(-1, 3)
    queries = points[::3] + 0.4
    near, _, _ = closest_on_mesh(points, mesh.faces, queries)
    far, _, _ = closest_on_mesh((points + 1e4).astype(np.float32), mesh.faces, queries + 1e4)
    apart = np.linalg.norm(queries + 1e4 - far, axis=1) - np.linalg.norm(queries - near, axis=1)
    assert np.abs(apart).max() <= np.sqrt(3.0) * float(np.spacing(np.float32(1e4)))
    small = (points[0] + 1e-4 * (points - points[0]) / 60.0 + 1e4).astype(np.float32)
    with pytest.raises(ValueError, match="no area"):
        closest_on_mesh(small, mesh.faces, small)


def alike(parabola: float, teeth: int = 30) -> Design:
    """Return two equal gears without cones whose axes cross at 40 deg. Half a turn about the common
    perpendicular exchanges them, and the pose with teeth in contact in the middle is symmetric."""
    member = table1().pinion
    tool = replace(member.tool, parabola=parabola)
    member = replace(
        member, tool=tool, teeth=teeth, cone_angle=0.0, helix_angle=np.radians(20.0), profile_shift=0.0
    )
    offset = 6.0 * teeth / np.cos(np.radians(20.0))
    return Design(member, member, Pair(offset, np.radians(40.0)))


def test_equally_near_edges_are_no_tangency(flank: str) -> None:
    """Both flanks are concave and overlap at the pitch point, so that the tips of both are equally near.
    The polished contact is missing, with a status. The facets give a position at a tip, whose error
    estimate includes the position at the other tip."""
    design = alike(0.02)
    path = path_of_contact(design, flank, l1=[0.0])
    at = pose_at(path, 0)
    assert mesh_contact(design, flank, 0.003, **at).status in (Status.OFF_FLANK, Status.NOT_CONVERGED)
    rough = mesh_contact(design, flank, 0.003, **at, polish=False)
    if rough.status == Status.SOLVED:
        least = [mesh_separation(design, flank, j, 0.003, **at).separation for j in (0, 1)]
        assert rough.separation <= min(np.nanmin(part) for part in least) + 0.006


@pytest.mark.parametrize("parabola", [0.0, -0.001, 0.001])
def test_equally_near_teeth(parabola: float, flank: str) -> None:
    """Midway between two pitches, two tooth pairs or two edges touch at the same time. The roll is that of
    either of them. Rounding of rolls and layout does not decide which one is reported."""
    design = alike(parabola)
    pitch = 2.0 * np.pi / 30.0
    middle = path_of_contact(design, flank, l1=[0.0])
    roll = float(middle.pinion_roll[0]) + 0.5 * pitch
    for _ in range(12):  # to the symmetric pose, one tooth further
        found = first_contact(design, flank, [roll])
        ahead = float(found.gear_roll[0] - middle.gear_roll[0]) + roll - float(middle.pinion_roll[0])
        roll = float(middle.pinion_roll[0]) + 0.5 * (pitch + ahead)
    found = first_contact(design, flank, [roll])
    assert found.status[0] == FirstStatus.SOLVED
    alone = [first_contact(design, flank, [roll], [k]) for k in (0, -1)]
    clear = [float(one.gear_roll[0] - found.gear_roll[0]) for one in alone if one.status[0] == 0]
    assert len(clear) == 2
    assert np.abs(clear).max() < 1e-13
    for nudge in (-1e-15, 1e-15):
        again = first_contact(design, flank, [roll * (1.0 + nudge)])
        assert np.array_equal(again.pair, found.pair)
        assert np.array_equal(again.limit, found.limit)
    turned = first_contact(exchanged(design), flank, found.gear_roll)
    assert abs(turned.gear_roll[0] - roll) < 1e-13
