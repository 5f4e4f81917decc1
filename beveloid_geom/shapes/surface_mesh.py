"""Whole teeth to look at: surfaces with exact normals.

The surfaces are those of the solid (`solid.tooth_surface`), but each part has points of its own
there, so that edges stay sharp and normals are those of the true surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Indices, Mask
from ..design.model import Member
from ..support.few_lines import few_lines
from .sampling import Faces
from .solid import NAMES, teeth_with, tooth_surface, turned


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of a gear: `points` (mm) and unit `normals` (n, 3), `faces` (m, 3) winding
    outwards, `part` (m,): which of `names` each face belongs to. Parts do not share points, so
    that edges stay sharp."""

    __repr__ = few_lines

    points: FloatArray
    normals: FloatArray
    faces: Faces
    part: Indices
    names: tuple[str, ...]

    def of(self, *names: str) -> Mesh:
        """Keep only the faces of the named parts."""
        return self.where(self.is_of(*names))

    def is_of(self, *names: str) -> Mask:
        """Find which faces (m,) belong to the named parts."""
        return np.isin(self.part, [self.names.index(name) for name in names])

    def where(self, wanted: Mask) -> Mesh:
        """Keep only the faces `wanted` (m,), with the points they use."""
        used, faces = np.unique(self.faces[wanted], return_inverse=True)
        return Mesh(
            self.points[used], self.normals[used], faces.reshape(-1, 3), self.part[wanted], self.names
        )


def gear_mesh(
    member: Member,
    tolerance: float,
    tooth_numbers: Sequence[int] | None = None,
    bore_radius: float | None = None,
) -> Mesh:
    """Mesh the whole gear, or the neighbouring teeth of the `tooth_numbers` (0 is at angle 0), in the own
    frame, within `tolerance` (mm) of its surfaces; `bore_radius` (mm) as in `gear_solid`. All teeth are the
    whole gear.

    Raises ValueError as `tooth_surface` does."""
    numbers = np.arange(int(member.teeth)) if tooth_numbers is None else np.asarray(tooth_numbers)
    surface = tooth_surface(member, tolerance, bore_radius, len(numbers))
    whole = len(numbers) == int(member.teeth)
    angles = np.asarray(2.0 * np.pi / float(member.teeth) * numbers, dtype=float)
    points, normals, faces, part, start = [], [], [], [], 0
    for piece in surface.pieces:
        at = angles[teeth_with(piece.name, len(numbers), whole)]
        points.append(turned(piece.points, at).reshape(-1, 3))
        normals.append(turned(piece.normals, at).reshape(-1, 3))
        first = start + len(piece.points) * np.arange(len(at))
        faces.append((first[:, None, None] + piece.faces).reshape(-1, 3))
        part.append(np.full(len(faces[-1]), NAMES.index(piece.name)))
        start += len(points[-1])
    return Mesh(
        np.concatenate(points), np.concatenate(normals), np.concatenate(faces), np.concatenate(part), NAMES
    )
