"""Closest points on a triangle mesh: one thin wrapper around VTK's cell locator.

VTK was chosen by measurement on sampled flanks, whose triangles are slender, about 1 : 10
(tests/benchmarks/test_closest_libraries.py): 0.08 to 0.4 million queries a second, exact to
rounding. trimesh, which needs rtree too, is three to six times slower and takes squared distances
within 1e-8 mm^2 for equal, which puts it off by 1e-6 mm close to a flank. libigl is as exact as
VTK and three to eight times faster, milliseconds on a flank, for one package more. A k-d tree on
the vertices must widen its search by the longest edge to be sure of the closest triangle, and is
eight to twenty times slower. embreex casts rays only.

This is the one module of the library that imports VTK, and only when it is called.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, Indices


def closest_on_mesh(
    points: ArrayLike, faces: ArrayLike, queries: ArrayLike
) -> tuple[FloatArray, Indices, FloatArray]:
    """Find the closest points of a mesh with vertices `points` (p, 3), mm, and triangles `faces` (m, 3).

    For `queries` (n, 3), mm: the closest points (n, 3), mm, the index of a triangle that holds
    each (n,), and its barycentric coordinates there (n, 3). Raises ValueError for a mesh
    without triangles, a triangle without area, or a number that is not finite."""
    vertices = np.ascontiguousarray(points, dtype=float)
    triangles, asked = np.asarray(faces, dtype=np.int64), np.asarray(queries, dtype=float)
    if not len(triangles):
        raise ValueError("the mesh has no triangles: there is no closest point on it")
    if not (np.isfinite(vertices).all() and np.isfinite(asked).all()):
        raise ValueError("the mesh and the queries must hold finite numbers")
    corners = vertices[triangles]
    found, index = _located(vertices, triangles, asked)
    return found, index, _barycentric(corners[index], found)


def _located(vertices: FloatArray, triangles: Indices, asked: FloatArray) -> tuple[FloatArray, Indices]:
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonCore import mutable, vtkPoints
    from vtkmodules.vtkCommonDataModel import (
        vtkCellArray,
        vtkGenericCell,
        vtkPolyData,
        vtkStaticCellLocator,
    )

    support: Any = numpy_support  # without types
    coordinates, cells, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
    coordinates.SetData(support.numpy_to_vtk(vertices, deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    connected = np.ascontiguousarray(triangles).ravel()
    cells.SetData(*(support.numpy_to_vtkIdTypeArray(ids, deep=True) for ids in (offsets, connected)))
    mesh.SetPoints(coordinates)
    mesh.SetPolys(cells)
    locator: Any = vtkStaticCellLocator()  # its types know no mutable numbers
    cell = vtkGenericCell()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    face, part, square, closest = mutable(0), mutable(0), mutable(0.0), [0.0, 0.0, 0.0]
    found, index = np.empty((len(asked), 3)), np.empty(len(asked), dtype=np.int64)
    for i, query in enumerate(asked.tolist()):
        locator.FindClosestPoint(query, closest, cell, face, part, square)
        found[i], index[i] = closest, int(face)
    return found, index


def _barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Find coordinates (n, 3) of points (n, 3) in triangles (n, 3, 3)."""
    sides = corners[:, 1:] - corners[:, :1]
    area = np.cross(sides[:, 0], sides[:, 1])
    square = np.einsum("ni,ni->n", area, area)
    if not (square > 0.0).all():
        raise ValueError("the closest triangle has no area: the mesh holds repeated points")
    offset = points - corners[:, 0]
    second = np.einsum("ni,ni->n", np.cross(offset, sides[:, 1]), area) / square
    third = np.einsum("ni,ni->n", np.cross(sides[:, 0], offset), area) / square
    return np.stack((1.0 - second - third, second, third), axis=-1)
