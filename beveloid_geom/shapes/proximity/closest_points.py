"""Closest points on a triangle mesh by the cell locator of VTK.

Libraries were compared on sampled flanks, whose triangles are slender, about 1 : 10
(tests/benchmarks/test_closest_libraries.py). VTK answers 0.08 to 0.4 million queries per second, exact to
rounding. trimesh, which also needs rtree, is three to six times slower. It treats squared distances within
1e-8 mm^2 as equal, which causes errors of 1e-6 mm close to a flank. libigl is as exact as VTK and three to
eight times faster, which saves milliseconds per flank, but it is an additional package. A k-d tree of the
vertices has to extend its search by the longest edge, and is eight to twenty times slower. embreex casts rays
only.

VTK is imported only when a function of this module is called.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray, Indices


def closest_on_mesh(
    points: ArrayLike, faces: ArrayLike, queries: ArrayLike
) -> tuple[FloatArray, Indices, FloatArray]:
    """Return the closest points of a triangle mesh.

    Parameters
    ----------
    points : array (p, 3)
        Vertices of the mesh, mm.
    faces : array (m, 3)
        Triangles: indices of vertices.
    queries : array (n, 3)
        mm.

    Returns
    -------
    closest : array (n, 3)
        Closest points on the mesh, mm.
    index : array (n,)
        Triangle that contains the closest point.
    weights : array (n, 3)
        Barycentric coordinates of the closest point in this triangle.

    Raises
    ------
    ValueError
        For a mesh without triangles, a triangle without area, and numbers that are not finite.
    """
    vertices = np.ascontiguousarray(points, dtype=float)
    triangles, targets = np.asarray(faces, dtype=np.int64), np.asarray(queries, dtype=float)
    if not len(triangles):
        raise ValueError("the mesh has no triangles: there is no closest point on it")
    if not (np.isfinite(vertices).all() and np.isfinite(targets).all()):
        raise ValueError("the mesh and the queries must contain finite numbers")
    corners = vertices[triangles]
    closest, index = _located(vertices, triangles, targets)
    return closest, index, _barycentric(corners[index], closest)


def _located(vertices: FloatArray, triangles: Indices, queries: FloatArray) -> tuple[FloatArray, Indices]:
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonCore import mutable, vtkPoints
    from vtkmodules.vtkCommonDataModel import (
        vtkCellArray,
        vtkGenericCell,
        vtkPolyData,
        vtkStaticCellLocator,
    )

    support: Any = numpy_support  # has no type hints
    coordinates, cells, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
    coordinates.SetData(support.numpy_to_vtk(vertices, deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    connected = np.ascontiguousarray(triangles).ravel()
    cells.SetData(*(support.numpy_to_vtkIdTypeArray(ids, deep=True) for ids in (offsets, connected)))
    mesh.SetPoints(coordinates)
    mesh.SetPolys(cells)
    locator: Any = vtkStaticCellLocator()  # its type hints lack mutable numbers
    cell = vtkGenericCell()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    face, part, square, closest = mutable(0), mutable(0), mutable(0.0), [0.0, 0.0, 0.0]
    points, index = np.empty((len(queries), 3)), np.empty(len(queries), dtype=np.int64)
    for i, query in enumerate(queries.tolist()):
        locator.FindClosestPoint(query, closest, cell, face, part, square)
        points[i], index[i] = closest, int(face)
    return points, index


def _barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Return barycentric coordinates (n, 3) of points (n, 3) in triangles (n, 3, 3)."""
    sides = corners[:, 1:] - corners[:, :1]
    area = np.cross(sides[:, 0], sides[:, 1])
    square = np.einsum("ni,ni->n", area, area)
    if not (square > 0.0).all():
        raise ValueError("the closest triangle has no area: the mesh contains repeated points")
    offset = points - corners[:, 0]
    second = np.einsum("ni,ni->n", np.cross(offset, sides[:, 1]), area) / square
    third = np.einsum("ni,ni->n", np.cross(sides[:, 0], offset), area) / square
    return np.stack((1.0 - second - third, second, third), axis=-1)
