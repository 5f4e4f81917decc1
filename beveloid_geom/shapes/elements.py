"""A mesh of hexahedra with named sets, as finite element programs take it.

Nodes of an element stand in the order that Abaqus, CalculiX and VTK share: the lower face 0-1-2-3
against the clock seen from inside the element, above it 4-5-6-7; with 20 nodes, mid-side
nodes 8-11 on the edges of the lower face, 12-15 of the upper one, 16-19 between the two. Faces
are numbered as Abaqus has them: its S1 ... S6 are 0 ... 5 here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Indices
from ..support.few_lines import few_lines

EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Corners beside the mid-side nodes 8 ... 19 of an element."""
CORNERS = np.array(
    [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)],
    float,
)
"""Isoparametric coordinates of an element's corners."""
NODES = {
    axes: np.concatenate((corners, [0.5 * (corners[a] + corners[b]) for a, b in edges]))
    for axes, corners, edges in ((2, CORNERS[:4, :2], EDGES[:4]), (3, CORNERS, EDGES))
}
"""Isoparametric coordinates of all nodes of a face and of an element, by the number of coordinates."""
BLOCK = 20_000
"""Elements handled at a time."""

ELEMENT_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
"""Corner nodes of the faces S1 ... S6, each seen from outside with the clock (inside: against)."""


@dataclass(frozen=True, eq=False)
class VolumeMesh:
    """Hexahedra of part of a gear, own frame.

    `points` (n, 3), mm; `hexahedra` (m, 8) or (m, 20), indices of points; `surfaces`: for each
    name an array (k, 2) of element index and face number 0 ... 5; `node_sets` and
    `element_sets`: sorted unique indices of points and of elements by name. The names are
    'right flank', 'left flank', 'right fillet', 'left fillet', 'tip', 'bottom', 'toe', 'heel',
    'bore', 'first side', 'last side' (a whole gear has no sides); with several teeth the sets hold
    those of all of them, and 'right flank 1' ... those of each tooth."""

    __repr__ = few_lines

    points: FloatArray
    hexahedra: Indices
    surfaces: dict[str, Indices]
    node_sets: dict[str, Indices]
    element_sets: dict[str, Indices]


def face_nodes(mesh: VolumeMesh, faces: Indices) -> Indices:
    """Find nodes (k, 4) or (k, 8) of faces (k, 2): corners in turn, then the mid-side nodes after them."""
    size = mesh.hexahedra.shape[1]
    columns = []
    for corners in ELEMENT_FACES:
        around = [{corner, corners[(i + 1) % 4]} for i, corner in enumerate(corners)]
        middles = [8 + next(e for e, ends in enumerate(EDGES) if set(ends) == pair) for pair in around]
        columns.append((*corners, *middles) if size == 20 else corners)
    return np.asarray(mesh.hexahedra[faces[:, :1], np.array(columns)[faces[:, 1]]])


def shape_functions(size: int, parameter: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find the shape functions (..., size) at isoparametric coordinates and their derivatives by these.

    Of an element with 8 or 20 nodes coordinates are (..., 3), derivatives (..., size, 3); of a face with 4 or
    8 nodes (..., 2) and (..., size, 2). Linear, or serendipity with mid-side nodes (Zienkiewicz, Taylor, Zhu,
    The Finite Element Method, ch. 4)."""
    axes = parameter.shape[-1]
    nodes, at = NODES[axes][:size], parameter[..., None, :]
    middle = nodes == 0.0
    factor = np.where(middle, 1.0 - at**2, 1.0 + nodes * at)
    slope = np.where(middle, -2.0 * at, nodes * np.ones_like(at))
    scale = np.where(middle.any(axis=1), 2.0, 1.0) / 2.0**axes
    values = factor.prod(axis=-1)
    others = [np.delete(factor, i, axis=-1).prod(axis=-1) for i in range(axes)]
    derivatives = slope * np.stack(others, axis=-1)
    if size > 2**axes:
        # Corners have the factor (x x_k + y y_k + z z_k - 2) besides, of a face (x x_k + y y_k - 1).
        rest = np.where(middle.any(axis=1), 1.0, (nodes * at).sum(axis=-1) - (axes - 1.0))
        own = np.where(middle.any(axis=1)[:, None], 0.0, nodes)
        derivatives = derivatives * rest[..., None] + values[..., None] * own
        values = values * rest
    return np.asarray(values * scale), np.asarray(derivatives * scale[:, None])


def _jacobians(mesh: VolumeMesh, at: FloatArray) -> Iterator[FloatArray]:
    """Block by block, rows (m, g, 3, 3) of the derivatives of the place, mm, by the isoparametric coordinates
    of `at` (g, 3)."""
    _, derivatives = shape_functions(mesh.hexahedra.shape[1], at)
    for start in range(0, len(mesh.hexahedra), BLOCK):
        x = mesh.points[mesh.hexahedra[start : start + BLOCK]]
        yield np.asarray(np.einsum("gka,mkc->mgac", derivatives, x, optimize=True))


def gauss_points(order: int) -> tuple[FloatArray, FloatArray]:
    """Find Gauss points (order^3, 3) of an element, and their weights."""
    place, weight = np.polynomial.legendre.leggauss(order)
    at = np.stack(np.meshgrid(place, place, place, indexing="ij"), axis=-1).reshape(-1, 3)
    return at, np.multiply.outer(np.multiply.outer(weight, weight), weight).ravel()


def determinants(mesh: VolumeMesh, order: int = 3) -> tuple[FloatArray, FloatArray]:
    """Find determinants (m, g) of the Jacobian at Gauss points, `order` along each axis, and the
    weights (g,): their products are the volumes, mm^3. All must be positive."""
    at, weights = gauss_points(order)
    return np.concatenate([np.linalg.det(block) for block in _jacobians(mesh, at)]), weights


def element_shapes(mesh: VolumeMesh) -> tuple[FloatArray, FloatArray]:
    """Find the scaled Jacobian (m,) of the elements, the least determinant of the unit vectors along the
    isoparametric lines, and the ratio (m,) of the least determinant of the Jacobian to the greatest. Both
    are 1 for a box, and at most 0 where an element is turned over.

    Elements with 8 nodes are looked at in their corners and in the middle (Knupp et al., The Verdict
    Geometric Quality Library, 2007), those with 20 in all nodes, with their curved edges, and in the
    integration points besides."""
    at = np.concatenate((CORNERS, np.zeros((1, 3))))
    if mesh.hexahedra.shape[1] == 20:
        at = np.concatenate((at, NODES[3][8:], gauss_points(3)[0]))
    scaled, ratio = [], []
    for rows in _jacobians(mesh, at):
        values, sizes = np.linalg.det(rows), np.linalg.norm(rows, axis=-1).prod(axis=-1)
        scaled.append((values / sizes).min(axis=1))
        ratio.append(values.min(axis=1) / values.max(axis=1))
    return np.concatenate(scaled), np.concatenate(ratio)
