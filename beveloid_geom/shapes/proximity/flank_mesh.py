"""A sampled flank as triangles, with the normals that give the sign of a distance from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, Mask
from ...design.member import Member
from ...support.frozen_arrays import cached
from ..sampling import FlankGrid, sample_flank
from ..sheet import Faces, grid_faces


@dataclass(frozen=True, eq=False)
class FlankMesh:
    """A sampled flank as triangles.

    Attributes
    ----------
    grid : FlankGrid
        Points of the triangles.
    faces : array (m, 3)
        Indices of the points of the grid in row-major order.
    rim : array (m, 3)
        Whether the edge opposite to each corner of a triangle is on the rim of the mesh.
    border : array (points,)
        Whether a point is on the rim.
    normals : array (m, 7, 3)
        Normals that give the sign of a distance, for a closest point inside the triangle, on the edge
        opposite to each corner, and at each corner: sums of the unit normals of all triangles that meet
        there, weighted by their angles at corners (Baerentzen and Aanaes 2005). The sign is therefore the
        same for all triangles that contain the closest point, also along the sharp edge of undercut.
    """

    grid: FlankGrid
    faces: Faces
    rim: Mask
    border: Mask
    normals: FloatArray


@cached(16)
def flank_mesh(member: Member, flank: str, tolerance: float) -> FlankMesh:
    """Return a flank of a single member as triangles.

    Parameters
    ----------
    member : Member
        A single member.
    flank : {'right', 'left'}
    tolerance : float
        Largest distance of the triangles from the flank, mm.

    Returns
    -------
    FlankMesh

    Raises
    ------
    ValueError
        As in `sample_flank`.
    """
    grid = sample_flank(member, flank, tolerance)
    faces = grid_faces(grid.points, grid.normals)
    edges = np.sort(np.stack((faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]), axis=1), axis=-1)
    code = edges[..., 0] * grid.l.size + edges[..., 1]
    _, back, count = np.unique(code, return_inverse=True, return_counts=True)
    border = np.pad(np.zeros(np.subtract(grid.l.shape, 2), dtype=bool), 1, constant_values=True).reshape(-1)
    normals = _normals(grid.points.reshape(-1, 3)[faces], back.reshape(code.shape), faces)
    return FlankMesh(grid, faces, (count == 1)[back].reshape(code.shape), border, normals)


def _normals(corners: FloatArray, edges: NDArray[np.intp], faces: Faces) -> FloatArray:
    """Return the normals (m, 7, 3) of a FlankMesh. `corners` (m, 3, 3), mm, of the triangles; `edges` (m, 3):
    numbers of the edges opposite to each corner; `faces` (m, 3): numbers of the corners."""
    sides = _unit(np.roll(corners, -1, axis=1) - corners)  # from each corner to the next
    face_normals = _unit(np.cross(sides[:, 0], sides[:, 1]))
    angles = np.arccos(np.clip(-np.einsum("mki,mki->mk", sides, np.roll(sides, 1, axis=1)), -1.0, 1.0))
    normals = [face_normals[:, None]]
    for number, weight in ((edges, np.ones_like(angles)), (faces, angles)):
        total = np.zeros((number.max() + 1, 3))
        np.add.at(total, number, weight[..., None] * face_normals[:, None])
        normals.append(total[number])
    return _unit(np.concatenate(normals, axis=1))


def _unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) scaled to length 1; zero vectors are not changed."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
