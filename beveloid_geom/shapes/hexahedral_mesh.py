"""A mesh of hexahedra with named sets for finite element programs.

Elements have the order of nodes of Abaqus, CalculiX and VTK: the lower face 0-1-2-3 counter-clockwise seen
from inside the element, and above it 4-5-6-7. With 20 nodes, mid-side nodes 8-11 are on the edges of the
lower face, 12-15 on those of the upper face and 16-19 between them. The faces S1 ... S6 of Abaqus are 0 ...
5 here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Indices
from ..support.array_repr import short_repr

EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Corners at the ends of the edges of the mid-side nodes 8 ... 19 of an element."""
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

ELEMENT_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
"""Corner nodes of the faces S1 ... S6, clockwise seen from outside."""


@dataclass(frozen=True, eq=False)
class VolumeMesh:
    """Hexahedra of some teeth of a gear, in the frame of the gear.

    Names of surfaces and sets are 'right flank', 'left flank', 'right fillet', 'left fillet', 'tip',
    'bottom', 'toe', 'heel', 'bore', 'first side' and 'last side' (a complete gear has no sides). If there are
    several teeth, these sets contain all of them, and sets such as 'right flank 1' contain a single tooth.

    Attributes
    ----------
    points : array (n, 3)
        mm.
    hexahedra : array (m, 8) or (m, 20)
        Indices of points.
    surfaces : dict
        Arrays (k, 2) of element index and face number 0 ... 5 by name.
    node_sets, element_sets : dict
        Sorted unique indices of points and of elements by name.
    """

    __repr__ = short_repr

    points: FloatArray
    hexahedra: Indices
    surfaces: dict[str, Indices]
    node_sets: dict[str, Indices]
    element_sets: dict[str, Indices]


def face_nodes(mesh: VolumeMesh, faces: Indices) -> Indices:
    """Return the nodes (k, 4) or (k, 8) of faces (k, 2): corners in order, then the mid-side nodes after
    them."""
    size = mesh.hexahedra.shape[1]
    columns = []
    for corners in ELEMENT_FACES:
        around = [{corner, corners[(i + 1) % 4]} for i, corner in enumerate(corners)]
        middles = [8 + next(e for e, ends in enumerate(EDGES) if set(ends) == pair) for pair in around]
        columns.append((*corners, *middles) if size == 20 else corners)
    return np.asarray(mesh.hexahedra[faces[:, :1], np.array(columns)[faces[:, 1]]])


def shape_functions(size: int, parameter: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape functions and their derivatives.

    They are linear, or serendipity functions with mid-side nodes (Zienkiewicz, Taylor, Zhu, The Finite
    Element Method, ch. 4).

    Parameters
    ----------
    size : int
        Number of nodes: 8 or 20 of an element, 4 or 8 of a face.
    parameter : array (..., 3) or (..., 2)
        Isoparametric coordinates in an element or in a face.

    Returns
    -------
    values : array (..., size)
    derivatives : array (..., size, 3) or (..., size, 2)
        By the isoparametric coordinates.
    """
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
        # Corners have the additional factor (x x_k + y y_k + z z_k - 2), or (x x_k + y y_k - 1) in a face.
        corner_factor = np.where(middle.any(axis=1), 1.0, (nodes * at).sum(axis=-1) - (axes - 1.0))
        corner_slope = np.where(middle.any(axis=1)[:, None], 0.0, nodes)
        derivatives = derivatives * corner_factor[..., None] + values[..., None] * corner_slope
        values = values * corner_factor
    return np.asarray(values * scale), np.asarray(derivatives * scale[:, None])


def _jacobians(mesh: VolumeMesh, at: FloatArray) -> Iterator[FloatArray]:
    """Return, for blocks of elements, the derivatives (m, g, 3, 3) of the position (mm; columns) by the
    isoparametric coordinates (rows) at points `at` (g, 3)."""
    _, derivatives = shape_functions(mesh.hexahedra.shape[1], at)
    # Number of elements for which arrays are computed at once.
    block = 20_000
    for start in range(0, len(mesh.hexahedra), block):
        x = mesh.points[mesh.hexahedra[start : start + block]]
        yield np.asarray(np.einsum("gka,mkc->mgac", derivatives, x, optimize=True))


def gauss_points(order: int) -> tuple[FloatArray, FloatArray]:
    """Return the Gauss points (order^3, 3) of an element and their weights."""
    place, weight = np.polynomial.legendre.leggauss(order)
    at = np.stack(np.meshgrid(place, place, place, indexing="ij"), axis=-1).reshape(-1, 3)
    return at, np.multiply.outer(np.multiply.outer(weight, weight), weight).ravel()


def determinants(mesh: VolumeMesh, order: int = 3) -> tuple[FloatArray, FloatArray]:
    """Return the determinants (m, g), mm^3, of the Jacobian at Gauss points, `order` along each axis, and the
    weights (g,). Sums of their products are volumes. Determinants of valid elements are positive."""
    at, weights = gauss_points(order)
    return np.concatenate([np.linalg.det(block) for block in _jacobians(mesh, at)]), weights


def rounded_down(quality: float) -> str:
    """Return a quality with two decimals that is not above its value, as text."""
    return f"{math.floor(100.0 * quality) / 100.0:.2f}"


def element_shapes(mesh: VolumeMesh) -> tuple[FloatArray, FloatArray]:
    """Return two measures of the shape of elements. Both are 1 for a box, and 0 or less for inverted
    elements.

    Elements with 8 nodes are evaluated at their corners and their centre (Knupp et al., The Verdict Geometric
    Quality Library, 2007). Elements with 20 nodes are evaluated with their curved edges, at all nodes, the
    centre and the integration points.

    Parameters
    ----------
    mesh : VolumeMesh

    Returns
    -------
    scaled : array (m,)
        Scaled Jacobian: smallest determinant of the unit vectors along the isoparametric lines.
    ratio : array (m,)
        Smallest determinant of the Jacobian over the largest one.
    """
    at = np.concatenate((CORNERS, np.zeros((1, 3))))
    if mesh.hexahedra.shape[1] == 20:
        at = np.concatenate((at, NODES[3][8:], gauss_points(3)[0]))
    scaled, ratio = [], []
    for rows in _jacobians(mesh, at):
        values, sizes = np.linalg.det(rows), np.linalg.norm(rows, axis=-1).prod(axis=-1)
        scaled.append((values / sizes).min(axis=1))
        ratio.append(values.min(axis=1) / values.max(axis=1))
    return np.concatenate(scaled), np.concatenate(ratio)
