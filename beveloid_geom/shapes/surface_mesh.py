"""Triangles of teeth for pictures, with normals.

The surfaces are those of the solid (`tooth_body.tooth_surface`). Surfaces do not share points, so that
edges are sharp. The normals are those of the exact surfaces, except on cut sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Indices, Mask
from ..design.member import Member
from ..support.array_repr import short_repr
from .sheet import Faces
from .solid import NAMES, rotated_copies, teeth_with
from .tooth_body import tooth_surface


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles of a gear.

    Attributes
    ----------
    points : array (n, 3)
        mm. Surfaces do not share points, so that edges are sharp.
    normals : array (n, 3)
        Outward unit normals of the exact surfaces; on cut sides computed from differences of the points.
    faces : array (m, 3)
        Indices of points, counter-clockwise seen from outside.
    part : array (m,)
        Index of the surface in `names` to which each face belongs.
    names : tuple of str
        Names of the surfaces.
    """

    __repr__ = short_repr

    points: FloatArray
    normals: FloatArray
    faces: Faces
    part: Indices
    names: tuple[str, ...]

    def of(self, *names: str) -> TriangleMesh:
        """Return the faces of the named surfaces."""
        return self.where(self.is_of(*names))

    def is_of(self, *names: str) -> Mask:
        """Return which faces (m,) belong to the named surfaces."""
        return np.isin(self.part, [self.names.index(name) for name in names])

    def where(self, mask: Mask) -> TriangleMesh:
        """Return the faces selected by a mask (m,), with the points that they use."""
        used, faces = np.unique(self.faces[mask], return_inverse=True)
        return TriangleMesh(
            self.points[used], self.normals[used], faces.reshape(-1, 3), self.part[mask], self.names
        )


def gear_mesh(
    member: Member,
    tolerance: float,
    tooth_numbers: Sequence[int] | None = None,
    bore_radius: float | None = None,
) -> TriangleMesh:
    """Return triangles of a gear, or of some adjacent teeth, in the frame of the gear.

    Parameters
    ----------
    member : Member
        A single member.
    tolerance : float
        Largest distance of the triangles from the exact surfaces, mm.
    tooth_numbers : sequence of int, optional
        Adjacent teeth; tooth 0 is at angle 0. All teeth by default.
    bore_radius : float, optional
        As in `gear_solid`, mm.

    Returns
    -------
    TriangleMesh

    Raises
    ------
    ValueError
        As `tooth_surface`.
    """
    numbers = np.arange(int(member.teeth)) if tooth_numbers is None else np.asarray(tooth_numbers)
    surface = tooth_surface(member, tolerance, bore_radius, len(numbers))
    closed = len(numbers) == int(member.teeth)
    angles = np.asarray(2.0 * np.pi / float(member.teeth) * numbers, dtype=float)
    points, normals, faces, part, start = [], [], [], [], 0
    for piece in surface.pieces:
        at = angles[teeth_with(piece.name, len(numbers), closed)]
        points.append(rotated_copies(piece.points, at).reshape(-1, 3))
        normals.append(rotated_copies(piece.normals, at).reshape(-1, 3))
        first = start + len(piece.points) * np.arange(len(at))
        faces.append((first[:, None, None] + piece.faces).reshape(-1, 3))
        part.append(np.full(len(faces[-1]), NAMES.index(piece.name)))
        start += len(points[-1])
    return TriangleMesh(
        np.concatenate(points), np.concatenate(normals), np.concatenate(faces), np.concatenate(part), NAMES
    )
