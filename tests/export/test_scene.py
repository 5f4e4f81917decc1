"""Scene of the pair: geometry read back by trimesh, height of the pattern, first contacts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, contact_pattern, path_certificate, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.scene import METRES_Y_UP, SceneItem, pair_scene, write_glb
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.status import Verdict
from tests.oracle.table1 import table1

MODULE = 6.0
MODIFIED = table1((0.001, -0.001))
TOLERANCE = 0.05


def scene_of(design: Design, flank: str) -> dict[str, SceneItem]:
    position = meshing_pair(design, flank)
    return {item.name: item for item in pair_scene(design, position, position.frames, TOLERANCE)}


def in_own_frame(design: Design, flank: str, member: int, points: FloatArray) -> FloatArray:
    rotation, origin = meshing_pair(design, flank).frames[member]
    return np.asarray((points - origin) @ rotation)


def test_scenes_are_read_back(tmp_path: Path) -> None:
    """Coordinates are in metres with y up, to 1e-6 m; paths and patterns are children of their gear."""
    import trimesh

    pieces = scene_of(MODIFIED, "left")
    write_glb(list(pieces.values()), tmp_path / "a.glb")
    scene: Any = trimesh.load(tmp_path / "a.glb")
    assert set(scene.geometry) == set(pieces)
    assert scene.units in (None, "meters")
    parents = scene.graph.transforms.parents
    for name, piece in pieces.items():
        mesh = scene.geometry[name]
        points = piece.surface.points @ METRES_Y_UP.T
        np.testing.assert_allclose(mesh.vertices, points, rtol=0, atol=1e-6)
        np.testing.assert_array_equal(mesh.faces, piece.surface.faces)
        assert parents[name] == (piece.parent or "world")
    np.testing.assert_allclose(METRES_Y_UP @ (0.0, 0.0, 1000.0), (0.0, 1.0, 0.0))
    assert np.linalg.det(1e3 * METRES_Y_UP) == pytest.approx(1.0)


@pytest.mark.parametrize("member", [0, 1])
def test_pattern_is_raised_from_the_flank_and_has_the_area_of_the_pattern(member: int) -> None:
    name = ("pinion", "gear")[member]
    piece = scene_of(MODIFIED, "left")[f"pattern on {name}"]
    points = in_own_frame(MODIFIED, "left", member, piece.surface.points)
    height = feet(MODIFIED.members[member], "left", points).distance
    np.testing.assert_allclose(height, MODULE / 300.0, rtol=0.01)
    corners = piece.surface.points[piece.surface.faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    pattern = contact_pattern(MODIFIED, "left")
    assert area.sum() == pytest.approx((pattern.pinion, pattern.gear)[member].area, rel=0.02)


def test_only_first_contacts_are_shown_as_contact(flank: str) -> None:
    """The thick tube covers the steps of the path between first contacts."""
    pieces = scene_of(MODIFIED, flank)
    path = path_of_contact(MODIFIED, flank, 33)
    first = path_certificate(path).verdict == Verdict.FIRST_CONTACT
    assert 0 < first.sum() < len(first)
    points = flank_point(MODIFIED.pinion, flank, path.l1, path.u1)
    tubes = (pieces[f"path of contact on pinion{end}"].surface for end in ("", ", not the first contact"))
    contact, later = (
        in_own_frame(MODIFIED, flank, 0, tube.points[tube.faces].mean(axis=1)) for tube in tubes
    )
    for step, shown in zip(np.stack((points[:-1], points[1:]), axis=1), first[1:] & first[:-1], strict=True):
        middle, way = step.mean(axis=0), 0.5 * (step[1] - step[0])
        near = [np.abs((tube - middle) @ way).min() / (way @ way) for tube in (contact, later)]
        assert [share < 0.7 for share in near] == [shown, not shown]
