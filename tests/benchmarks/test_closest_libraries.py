"""Which library finds closest points on flanks best: build time, speed and exactness.

    python -m pytest tests/benchmarks/test_closest_libraries.py -m benchmark -s

Flanks of Table 1 at two tolerances, whose triangles are slender, about 1 : 10; queries 0.001 mm
from the mesh, as near a contact, and 2 mm, as over the rest of the face. The error is that of the
distance against VTK's, which is held against all triangles for some of the queries. `kd-tree` is
our own code on SciPy: the triangles at the nearest vertices, and more of them until those left
out are too far off for certain. trimesh and libigl are optional here. embreex casts rays and finds no
closest points.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import cKDTree

from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.closest_points import closest_on_mesh
from beveloid_geom.shapes.flank_mesh import flank_mesh
from beveloid_geom.shapes.sampling import Faces
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import on_triangle

pytestmark = pytest.mark.benchmark

Distances = Callable[[FloatArray], FloatArray]
QUERIES, CHECKED = 4000, 200


def by_module(points: FloatArray, faces: Faces) -> Distances:
    return lambda queries: np.linalg.norm(queries - closest_on_mesh(points, faces, queries)[0], axis=-1)


def by_pyvista(points: FloatArray, faces: Faces) -> Distances:
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData(points, np.insert(faces, 0, 3, axis=1).ravel())
    mesh.find_closest_cell(points[0])
    return lambda q: np.linalg.norm(q - mesh.find_closest_cell(q, return_closest_point=True)[1], axis=-1)


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


def by_tree(points: FloatArray, faces: Faces) -> Distances:
    """Triangles at the k nearest vertices. Those left out have all their vertices beyond the k-th,
    and no point of a triangle is further than its longest edge / sqrt(3) from its nearest vertex."""
    tree, order = cKDTree(points), np.argsort(faces.ravel(), kind="stable")
    first = np.searchsorted(faces.ravel()[order], np.arange(len(points) + 1))
    longest = max(
        np.linalg.norm(points[faces[:, i]] - points[faces[:, i - 1]], axis=1).max() for i in range(3)
    )
    most = int(np.diff(first).max())
    at = np.minimum(first[:-1, None] + np.arange(most), first[1:, None] - 1)
    fans = order[at] // 3  # triangles at each vertex, the last one repeated

    def distances(queries: FloatArray) -> FloatArray:
        found, left, k = np.empty(len(queries)), np.arange(len(queries)), 8
        while left.size:
            k = min(2 * k, len(points))
            far, near = (np.asarray(part) for part in tree.query(queries[left], k))
            corners = points[faces[fans[near].reshape(len(left), -1)]]
            best = on_triangle(queries[left], *np.moveaxis(corners, 2, 0)).min(axis=1)
            found[left] = np.sqrt(best)
            certain = (found[left] <= far[:, -1] - longest / np.sqrt(3.0)) | (k == len(points))
            left = left[~certain]
        return found

    return distances


CANDIDATES = {
    "closest_on_mesh (VTK)": by_module,
    "pyvista": by_pyvista,
    "trimesh and rtree": by_trimesh,
    "libigl": by_igl,
    "kd-tree (SciPy)": by_tree,
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
    CANDIDATES[name](points, mesh.faces)  # imports
    start = time.perf_counter()
    search = CANDIDATES[name](points, mesh.faces)
    built = time.perf_counter() - start
    for apart in (0.001, 2.0):
        queries = queries_near(points, mesh.faces, apart)
        count = QUERIES if not name.startswith("kd") else CHECKED
        search(queries[:10])
        start = time.perf_counter()
        found = search(queries[:count])
        seconds = time.perf_counter() - start
        start = time.perf_counter()
        reference = by_module(points, mesh.faces)(queries[:count])
        ratio = seconds / (time.perf_counter() - start)
        parts = np.array_split(queries[:CHECKED], 20)
        corners = np.moveaxis(points[mesh.faces], 1, 0)
        exact = np.sqrt(np.concatenate([on_triangle(part, *corners).min(axis=1) for part in parts]))
        assert np.abs(reference[:CHECKED] - exact).max() < 1e-12
        error = np.abs(found - reference).max()
        print(f"\n{name:22s} {len(mesh.faces):5d} triangles, {apart:5.3f} mm off: ", end="")
        print(f"built in {1e3 * built:6.2f} ms, {count / seconds:9.0f} queries/s, ", end="")
        print(f"{ratio:7.2f} times the time of VTK, off by {error:.1e} mm", end="")
