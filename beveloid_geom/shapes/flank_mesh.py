"""A sampled flank as triangles that know inside from outside: what proximity queries are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Mask
from ..design.model import Member
from ..support.read_only import kept
from .sampling import Faces, FlankGrid, grid_faces, sample_flank


@dataclass(frozen=True, eq=False)
class FlankMesh:
    """A sampled flank: its grid and the triangles (m, 3) of the grid's points in row-major order.

    `rim` (m, 3): whether the edge opposite a triangle's corner is on the rim of the mesh; `border` (points,):
    whether a point is. `normals` (m, 7, 3): what tells inside from outside where the closest point lies in
    the triangle, on the edge opposite each corner, at each corner: the sum of the unit normals of all
    triangles that meet there, weighted by their angles at a corner (Baerentzen and Aanaes 2005). So it
    does not matter which of them is taken for the closest, even along the sharp edge of undercut."""

    grid: FlankGrid
    faces: Faces
    rim: Mask
    border: Mask
    normals: FloatArray


@kept(16)
def flank_mesh(member: Member, flank: str, tolerance: float) -> FlankMesh:
    """Mesh a flank of a single member as triangles within `tolerance` (mm) of it.

    Raises ValueError as `sample_flank` does."""
    grid = sample_flank(member, flank, tolerance)
    faces = grid_faces(grid.points, grid.normals)
    edges = np.sort(np.stack((faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]), axis=1), axis=-1)
    code = edges[..., 0] * grid.l.size + edges[..., 1]
    _, back, count = np.unique(code, return_inverse=True, return_counts=True)
    border = np.pad(np.zeros(np.subtract(grid.l.shape, 2), dtype=bool), 1, constant_values=True).reshape(-1)
    normals = _normals(grid.points.reshape(-1, 3)[faces], back.reshape(code.shape), faces)
    return FlankMesh(grid, faces, (count == 1)[back].reshape(code.shape), border, normals)


def _normals(corners: FloatArray, edges: NDArray[np.intp], faces: Faces) -> FloatArray:
    """Give the normals (m, 7, 3) of FlankMesh, of triangles with `corners` (m, 3, 3), mm, whose edges, by the
    corner opposite, and corners have the numbers `edges` and `faces` (m, 3)."""
    sides = _unit(np.roll(corners, -1, axis=1) - corners)  # from each corner to the next
    own = _unit(np.cross(sides[:, 0], sides[:, 1]))
    angles = np.arccos(np.clip(-np.einsum("mki,mki->mk", sides, np.roll(sides, 1, axis=1)), -1.0, 1.0))
    found = [own[:, None]]
    for number, weight in ((edges, np.ones_like(angles)), (faces, angles)):
        total = np.zeros((number.max() + 1, 3))
        np.add.at(total, number, weight[..., None] * own[:, None])
        found.append(total[number])
    return _unit(np.concatenate(found, axis=1))


def _unit(vectors: FloatArray) -> FloatArray:
    """Scale vectors (..., 3) to length 1; those without length stay as they are."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
