"""Triangulation of a plane polygon without slivers.

1. The Delaunay triangulation of the corners (SciPy) is restricted to the inside of the polygon.
2. Triangles with an angle below a limit are treated in the order of their smallest angle. A point is added:
   the circumcentre, or a point closer to the shortest side ("off-center", Uengoer, Computational Geometry 42
   (2009) 109-118). The triangles whose circumcircle contains the point are replaced by triangles from the
   point to the edges around them (Bowyer and Watson, Computer Journal 24 (1981)). The sides of the polygon
   remain edges of the triangulation.

A point is added only if it increases the smallest angle of the triangles that it replaces, so that step 2
ends. Triangles may grow quickly away from a finely divided side: few points are added.
"""

from __future__ import annotations

import heapq
from math import asin, tan
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray, Indices

Edge: TypeAlias = tuple[int, int]
Triangle: TypeAlias = tuple[int, int, int]


def triangulate_polygon(corners: FloatArray, smallest_angle: float) -> tuple[FloatArray, Indices]:
    """Return a triangulation of a simple polygon.

    Parameters
    ----------
    corners : array (n, 2)
        Corners in counter-clockwise order, mm.
    smallest_angle : float
        Target for the smallest angle of the triangles, rad. Angles between sides of the polygon, and of
        triangles between close sides, may be smaller.

    Returns
    -------
    points : array (p, 2)
        The corners, followed by the points added inside, mm.
    triangles : array (m, 3)
        Indices of points, counter-clockwise.

    Raises
    ------
    ValueError
        If a side of the polygon is not an edge of the Delaunay triangulation of the corners, for example
        because the polygon intersects itself.
    """
    mesh = _Triangulation(corners)
    slivers = [(mesh.angle(one), one) for one in mesh.triangles()]
    slivers = [one for one in slivers if one[0] < smallest_angle]
    heapq.heapify(slivers)
    while slivers:
        before, triangle = heapq.heappop(slivers)
        if mesh.third.get(triangle[:2]) != triangle[2]:
            continue  # replaced after a point was added
        for point in mesh.candidates(triangle, smallest_angle):
            new = mesh.insert(point, triangle, before)
            if new:
                angles = [(mesh.angle(one), one) for one in new]
                for one in angles:
                    if one[0] < smallest_angle:
                        heapq.heappush(slivers, one)
                break
    points = np.array(mesh.points)
    return np.stack((points.real, points.imag), axis=-1), np.array(mesh.triangles())


class _Triangulation:
    """Triangles of a polygon. `third` maps each directed edge (a, b) to the corner c of the counter-clockwise
    triangle (a, b, c), and the edge (b, a) along a side of the polygon, where no triangle is, to -1."""

    def __init__(self, corners: FloatArray) -> None:
        # Decimals of the coordinates, relative to the size of the polygon, that decide between
        # triangulations.
        relative_decimals = 9
        from scipy.spatial import Delaunay

        self.points: list[complex] = (corners @ (1.0, 1.0j)).tolist()
        count = len(corners)
        # Rounding would choose the diagonal of four corners on a circle: similar polygons get the same one.
        size = np.ptp(corners, axis=0).max()
        similar = np.round((corners - corners.mean(axis=0)) / size, relative_decimals)
        # Four distant points keep collinear sides away from the convex hull, where Qhull may drop points.
        distant = 100.0 * np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
        mesh = Delaunay(np.concatenate((similar, distant)))
        every: dict[Edge, int] = {}
        for a, b, c in mesh.simplices.tolist():
            if np.linalg.det(mesh.points[[b, c]] - mesh.points[a]) < 0.0:
                b, c = c, b
            every |= {(a, b): c, (b, c): a, (c, a): b}
        sides = [(k, (k + 1) % count) for k in range(count)]
        if any(every.get(side, count) >= count for side in sides):
            raise ValueError("a side of the polygon is not an edge of its Delaunay triangulation")
        self.third = {(b, a): -1 for a, b in sides}
        # The triangles inside are reached from the sides without crossing a side.
        while sides:
            a, b = sides.pop()
            if (a, b) not in self.third:
                c = every[a, b]
                self.third |= {(a, b): c, (b, c): a, (c, a): b}
                sides += [(c, b), (a, c)]

    def triangles(self) -> list[Triangle]:
        """Return all triangles, each once."""
        return [(a, b, c) for (a, b), c in self.third.items() if a < b and a < c]

    def angle(self, triangle: Triangle) -> float:
        """Return the smallest angle of a triangle, rad."""
        a, b, c = triangle
        return _smallest_angle(self.points[a], self.points[b], self.points[c])

    def candidates(self, triangle: Triangle, smallest_angle: float) -> list[complex]:
        """Return points to add in place of a triangle, above the middle of its shortest side: the
        circumcentre, but no higher than triangles of the smallest angle allow, and two points lower."""
        corners = [self.points[k] for k in triangle]
        p, q, r = min(
            (corners[k:] + corners[:k] for k in range(3)), key=lambda turned: abs(turned[1] - turned[0])
        )
        middle, half = 0.5 * (p + q), 0.5 * abs(q - p)
        upward = 1.0j * (q - p) / (2.0 * half)
        apex = (r - middle) / upward
        height = (abs(apex) ** 2 - half**2) / (2.0 * apex.real)
        height = min(height, 0.9 * half / tan(0.5 * smallest_angle))
        return [middle + share * height * upward for share in (1.0, 0.5, 0.25)]

    def insert(self, point: complex, start: Triangle, before: float) -> list[Triangle]:
        """Add a point; return the new triangles. Do nothing if a side of the polygon separates the point from
        the triangle `start`, or if the smallest angle would not be larger than `before` (rad)."""
        points, third = self.points, self.third
        # Walk to the triangle that contains the point, across edges that have the point on their right.
        triangle = start
        while crossed := [(a, b) for a, b in _edges(triangle) if _cross(points[a], points[b], point) < 0.0]:
            b, a = crossed[0]
            if third[a, b] < 0:
                return []
            triangle = a, b, third[a, b]
        # The triangles whose circumcircle contains the point, and the edges around them.
        edges = set(_edges(triangle))
        pending = list(edges)
        while pending:
            b, a = pending.pop()
            c = third[a, b]
            if (a, b) not in edges and c >= 0 and _in_circle(points[a], points[b], points[c], point):
                edges |= {(a, b), (b, c), (c, a)}
                pending += [(b, c), (c, a)]
        around = [(a, b) for a, b in edges if (b, a) not in edges]
        if min(_smallest_angle(points[a], points[b], point) for a, b in around) <= before:
            return []
        for edge in edges:
            del third[edge]
        number = len(points)
        points.append(point)
        for a, b in around:
            third |= {(a, b): number, (b, number): a, (number, a): b}
        return [(a, b, number) for a, b in around]


def _edges(triangle: Triangle) -> tuple[Edge, Edge, Edge]:
    a, b, c = triangle
    return (a, b), (b, c), (c, a)


def _cross(a: complex, b: complex, c: complex) -> float:
    """Return twice the area of a triangle, positive if it is counter-clockwise."""
    return float(((b - a).conjugate() * (c - a)).imag)


def _in_circle(a: complex, b: complex, c: complex, point: complex) -> bool:
    """Return whether a point lies in the circumcircle of a counter-clockwise triangle.

    It does if the angles over the side (a, b), seen from c and from the point, exceed 180 deg together."""
    return ((b - point) * (a - point).conjugate() * (a - c) * (b - c).conjugate()).imag > 0.0


def _smallest_angle(a: complex, b: complex, c: complex) -> float:
    """Return the smallest angle of a counter-clockwise triangle, rad; negative if it is clockwise."""
    _, middle, long = sorted((abs(b - a), abs(c - b), abs(a - c)))
    return asin(max(-1.0, min(1.0, _cross(a, b, c) / (middle * long))))
