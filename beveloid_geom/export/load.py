"""A contact load on one face of a mesh of hexahedra, and where the mesh is held and observed.

A force F at the point x of a face does the work F.u(x) with u = sum N_i u_i, N_i the shape
functions of the face: its equivalent nodal forces are N_i F. They add up to F, and their
moment is that of F at x. Shape functions: bilinear with 4 nodes, serendipity with 8 (Zienkiewicz,
Taylor, Zhu, The Finite Element Method, ch. 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..inputs import FloatArray
from ..volume import Indices, VolumeMesh, face_nodes

FACE_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
"""Isoparametric coordinates of a face's corners; its mid-side nodes follow them."""
CANDIDATES = 12
INSIDE = 1e-9
"""How far beyond its edges, in isoparametric coordinates, a face still holds a point."""
MOST_APART = 0.25
"""Distance of the point from the mesh that is taken as its faceting, in lengths of the face."""


@dataclass(frozen=True, eq=False)
class ContactLoad:
    """Equivalent nodal forces of one force on a face.

    `nodes` (4,) or (8,), indices of points; `forces` (4 or 8, 3), N; `point` (3,): where the
    force acts, on the face, mm; `gap`: distance (mm) of the point asked for from there; `face`:
    element index and face number 0 ... 5; `parameter` (2,): isoparametric coordinates."""

    nodes: Indices
    forces: FloatArray
    point: FloatArray
    gap: float
    face: tuple[int, int]
    parameter: FloatArray

    @property
    def total(self) -> FloatArray:
        """Sum (3,) of the nodal forces, N."""
        return np.asarray(self.forces.sum(axis=0))


def shape_functions(size: int, parameter: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (..., size) of a face with 4 or 8 nodes and their derivatives (..., size, 2)
    at isoparametric coordinates (..., 2)."""
    x, y = parameter[..., :1], parameter[..., 1:]
    a, b = FACE_CORNERS.T
    p, q = 1.0 + a * x, 1.0 + b * y
    if size == 4:
        return 0.25 * p * q, 0.25 * np.stack((a * q, b * p), axis=-1)
    corner = 0.25 * p * q * (p + q - 3.0)
    corner_x = 0.25 * a * q * (2.0 * p + q - 3.0)
    corner_y = 0.25 * b * p * (p + 2.0 * q - 3.0)
    below, right, above, left = 1.0 - y, 1.0 + x, 1.0 + y, 1.0 - x
    bulge_x, bulge_y = 1.0 - x * x, 1.0 - y * y
    middle = (bulge_x * below, right * bulge_y, bulge_x * above, left * bulge_y)
    middle_x = (-2.0 * x * below, bulge_y, -2.0 * x * above, -bulge_y)
    middle_y = (-bulge_x, -2.0 * y * right, bulge_x, -2.0 * y * left)
    values, by_x, by_y = (0.5 * np.concatenate(part, axis=-1) for part in (middle, middle_x, middle_y))
    slopes = np.stack((np.concatenate((corner_x, by_x), -1), np.concatenate((corner_y, by_y), -1)), axis=-1)
    return np.concatenate((corner, values), axis=-1), slopes


def contact_load(mesh: VolumeMesh, surface: str, point: FloatArray, force: FloatArray) -> ContactLoad:
    """The `force` (3,), N, at the place of the named surface that is nearest to `point` (3,), mm.

    Raises ValueError where the point is not on that surface, or the force is not finite."""
    if not (np.isfinite(point).all() and np.isfinite(force).all()):
        raise ValueError(f"point and force must be finite, got {point} mm and {force} N")
    faces = mesh.surfaces[surface]
    nodes = face_nodes(mesh, faces)
    corners = mesh.points[nodes]
    reach = np.linalg.norm(corners.mean(axis=1) - point, axis=-1)
    near = np.argsort(reach, kind="stable")[:CANDIDATES]
    parameter, foot = _nearest(corners[near], point)
    gap = np.linalg.norm(foot - point, axis=-1)
    length = np.linalg.norm(corners[near][:, 2] - corners[near][:, 0], axis=-1)
    holds = (np.abs(parameter).max(axis=-1) <= 1.0 + INSIDE) & (gap <= MOST_APART * length)
    if not holds.any():
        text = f"the {surface} has no face at the contact point ({', '.join(f'{x:.4f}' for x in point)}) mm"
        raise ValueError(f"{text}: does the mesh hold the tooth in contact?")
    best = int(np.flatnonzero(holds)[np.argmin(gap[holds])])
    values, _ = shape_functions(nodes.shape[1], parameter[best])
    chosen = near[best]
    element, number = faces[chosen]
    face = (int(element), int(number))
    return ContactLoad(
        nodes[chosen],
        np.multiply.outer(values, force),
        foot[best],
        float(gap[best]),
        face,
        parameter[best],
    )


def _nearest(corners: FloatArray, point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Isoparametric coordinates (k, 2) and places (k, 3) on faces (k, size, 3) where the way to
    the point is square to the face, by Newton's method without second derivatives. The faces
    are nearly flat and the point is near them, so that these change next to nothing."""
    parameter = np.zeros((len(corners), 2))
    for _ in range(30):
        values, slopes = shape_functions(corners.shape[1], parameter)
        tangents = np.einsum("kni,knj->kij", corners, slopes)
        way = point - np.einsum("kni,kn->ki", corners, values)
        square = np.einsum("kij,kil->kjl", tangents, tangents)
        step = np.linalg.solve(square, np.einsum("kij,ki->kj", tangents, way)[..., None])[..., 0]
        # A face far from the point may lead astray: it does not hold the point in any case.
        parameter = np.clip(parameter + step, -3.0, 3.0)
        if np.abs(step).max() < 1e-14:
            break
    values, _ = shape_functions(corners.shape[1], parameter)
    return parameter, np.einsum("kni,kn->ki", corners, values)
