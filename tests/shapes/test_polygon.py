"""Triangulation of polygons: area, sides, smallest angle, number of points."""

from __future__ import annotations

from math import pi, radians
from typing import Any

import numpy as np
import pytest
import trimesh

from beveloid_geom.arrays import FloatArray, Indices
from beveloid_geom.shapes.polygon import triangulate_polygon

angles: Any = trimesh.triangles.angles


def circle(count: int, radius: float = 1.0) -> FloatArray:
    angle = 2.0 * pi / count * np.arange(count)
    return radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def stripe() -> FloatArray:
    """Return a rectangle of 50 x 10 mm. One long side is divided by 0.2 mm, the other one by 10 mm."""
    fine = np.stack((np.linspace(50.0, 0.0, 251), np.full(251, 10.0)), axis=-1)
    coarse = np.stack((np.linspace(0.0, 50.0, 6), np.zeros(6)), axis=-1)
    ends = [np.column_stack((np.full(3, x), (1.0, 3.0, 6.0))) for x in (0.0, 50.0)]
    return np.concatenate((coarse, ends[1], fine, ends[0][::-1]))


POLYGONS = {
    "square": np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float),
    "circle": circle(40),
    "stripe": stripe(),
    "ring segment": np.concatenate((circle(36, 10.0)[:12], circle(144, 4.0)[44::-1])),
}


def sides(polygon: Indices) -> set[tuple[int, int]]:
    return set(zip(polygon.tolist(), np.roll(polygon, -1).tolist(), strict=True))


@pytest.mark.parametrize("name", POLYGONS)
@pytest.mark.parametrize("smallest_deg", [0.0, 3.0, 8.0])
def test_triangles_fill_the_polygon_without_slivers(name: str, smallest_deg: float) -> None:
    corners = POLYGONS[name]
    points, triangles = triangulate_polygon(corners, radians(smallest_deg))
    np.testing.assert_array_equal(points[: len(corners)], corners)
    np.testing.assert_array_equal(np.unique(triangles), np.arange(len(points)))
    a, b, c = points[triangles.T]
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    x, y = corners.T
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum(), rel=1e-12)
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).tolist()
    directed = {(a, b) for a, b in edges}
    assert len(directed) == len(edges)
    assert {(a, b) for a, b in directed if (b, a) not in directed} == sides(np.arange(len(corners)))
    assert len(triangles) == 2 * len(points) - len(corners) - 2
    assert np.degrees(angles(np.pad(points, ((0, 0), (0, 1)))[triangles]).min()) > 0.7 * smallest_deg
    assert len(points) - len(corners) <= {0.0: 0.0, 3.0: 0.15, 8.0: 0.3}[smallest_deg] * len(corners)


def test_a_polygon_that_intersects_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="is not an edge of its Delaunay triangulation"):
        triangulate_polygon(POLYGONS["square"][[0, 2, 1, 3]], 0.1)
