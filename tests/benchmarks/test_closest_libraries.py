"""Build time, speed and accuracy of libraries that find closest points on flanks.

    python -m pytest tests/benchmarks/test_closest_libraries.py -m benchmark -s

Flanks of Table 1 at two tolerances, whose triangles have an aspect ratio of about 1 : 10. Queries are
0.001 mm from the mesh, as near a contact, and 2 mm, as on the remaining face. The error is the difference
from the distance of VTK, which `tests/shapes/test_mesh_contact.py` compares with all triangles. trimesh
and libigl are optional here. embreex casts rays and finds no closest points."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.proximity.closest_points import closest_on_mesh
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from beveloid_geom.shapes.sheet import Faces
from tests.benchmarks.timing import best
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark

Distances = Callable[[FloatArray], FloatArray]
QUERIES = 4000


def by_module(points: FloatArray, faces: Faces) -> Distances:
    return lambda queries: np.linalg.norm(queries - closest_on_mesh(points, faces, queries)[0], axis=-1)


def by_trimesh(points: FloatArray, faces: Faces) -> Distances:
    pytest.importorskip("rtree")
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(points, faces, process=False)
    assert mesh.triangles_tree is not None
    return lambda queries: np.asarray(trimesh.proximity.closest_point(mesh, queries)[1])


def by_igl(points: FloatArray, faces: Faces) -> Distances:
    igl = pytest.importorskip("igl")
    tree = igl.AABB()
    tree.init(points, faces)
    return lambda queries: np.sqrt(tree.squared_distance(points, faces, queries)[0])


CANDIDATES = {
    "closest_on_mesh (VTK)": by_module,
    "trimesh and rtree": by_trimesh,
    "libigl": by_igl,
}


def queries_near(points: FloatArray, faces: Faces, apart: float) -> FloatArray:
    random = np.random.default_rng(1)
    chosen = points[faces[random.integers(0, len(faces), QUERIES)]]
    spread = random.normal(size=(QUERIES, 3))
    spread *= apart / np.linalg.norm(spread, axis=-1, keepdims=True)
    return np.asarray(np.einsum("nk,nki->ni", random.dirichlet((1.0, 1.0, 1.0), QUERIES), chosen) + spread)


@pytest.mark.parametrize("tolerance", [0.01, 0.0001])
@pytest.mark.parametrize("name", list(CANDIDATES))
def test_closest_points(name: str, tolerance: float) -> None:
    mesh = flank_mesh(table1().gear, "right", tolerance)
    points = np.ascontiguousarray(mesh.grid.points.reshape(-1, 3))
    search = CANDIDATES[name](points, mesh.faces)  # and imports
    built = best(lambda: CANDIDATES[name](points, mesh.faces), 1)
    for apart in (0.001, 2.0):
        queries = queries_near(points, mesh.faces, apart)
        ours = by_module(points, mesh.faces)
        seconds, usual = (best(partial(way, queries), 2) for way in (search, ours))
        error = np.abs(search(queries) - ours(queries)).max()
        print(f"\n{name:22s} {len(mesh.faces):5d} triangles, {apart:5.3f} mm off: ", end="")
        print(f"built in {1e3 * built:6.2f} ms, {QUERIES / seconds:9.0f} queries/s, ", end="")
        print(f"{seconds / usual:7.2f} times the time of VTK, off by {error:.1e} mm", end="")
