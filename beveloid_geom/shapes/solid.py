"""A gear, or some of its teeth, as one closed surface of triangles.

The teeth are copies of one tooth with its part of the body (`tooth_body`), rotated about the axis.
Neighbouring surfaces share the points of their common edge, so that the solid is closed by construction.

Pictures are drawn from the same surfaces (`surface_mesh.gear_mesh`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray, Indices
from ..design.arguments import require_integers, require_member, require_numbers
from ..design.member import Member
from ..support.array_repr import short_repr
from .sampling import default_tolerance
from .section import SIDES
from .sheet import Faces
from .tooth_body import tooth_surface

NAMES = (
    *("right flank", "left flank", "right fillet", "left fillet"),
    *("tip", "bottom", "toe", "heel", "bore", *SIDES),
)


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface of triangles in the frame of the gear.

    Attributes
    ----------
    points : array (n, 3)
        Different points, mm.
    faces : array (m, 3)
        Indices of points, counter-clockwise seen from outside.
    part : array (m,)
        Index of the surface in `names` to which each face belongs.
    names : tuple of str
        Names of the surfaces.
    """

    __repr__ = short_repr

    points: FloatArray
    faces: Faces
    part: Indices
    names: tuple[str, ...]

    def to_trimesh(self) -> Any:
        """Return the surface as a trimesh.Trimesh.

        Returns
        -------
        trimesh.Trimesh
            Points (mm) and triangles in the same order. The face attribute `part` is the index of the surface
            in the metadata `names`.

        Examples
        --------
        >>> from beveloid_geom import builtin_design, gear_solid
        >>> mesh = gear_solid(builtin_design().pinion, tolerance=0.05).to_trimesh()
        >>> mesh.is_watertight
        True
        """
        import trimesh  # takes longer to import than to make a solid

        return trimesh.Trimesh(
            self.points,
            self.faces,
            face_attributes={"part": self.part},
            metadata={"names": self.names},
            process=False,
        )


def gear_solid(
    member: Member,
    tolerance: float | None = None,
    teeth: int | None = None,
    bore_radius: float | None = None,
) -> Solid:
    """Return a gear, or some of its teeth, as a closed surface of triangles in the frame of the gear.

    Parameters
    ----------
    member : Member
        A single member.
    tolerance : float, optional
        Largest distance of the triangles from the exact surfaces, mm. By default 1/600 of the normal module,
        as for the command `mesh`.
    teeth : int, optional
        Number of adjacent teeth with their part of the body; all teeth (the complete gear) by default. The
        first tooth is at angle 0, the others follow counter-clockwise seen from +z.
    bore_radius : float, optional
        mm; 0.45 of the smallest root radius by default.

    Returns
    -------
    Solid

    Raises
    ------
    ValueError
        As `tooth_surface`, and for a number of teeth that is not between 1 and that of the gear.

    References
    ----------
    Points: Eq. (6) of Ni et al. 2017; triangles: beveloid_geom/shapes/README.md.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, gear_solid
    >>> solid = gear_solid(builtin_design().pinion, tolerance=0.05, teeth=1)
    >>> solid.points.shape[1], solid.names[0]
    (3, 'right flank')
    """
    require_member(member)
    require_numbers(tolerance=tolerance, bore_radius=bore_radius)
    require_integers(teeth=teeth)
    count = int(member.teeth)
    wanted = count if teeth is None else teeth
    if not 0 < wanted <= count:
        raise ValueError(f"teeth must be between 1 and {count}, got {wanted}")
    tolerance = default_tolerance(member) if tolerance is None else tolerance
    tooth = tooth_surface(member, tolerance, bore_radius, wanted)
    one = len(tooth.points), tooth.first_side, tooth.last_side
    numbers = np.stack(joined_numbers([one] * wanted, wanted == count))
    faces, part = [], []
    for piece in tooth.pieces:
        shown = numbers[teeth_with(piece.name, wanted, wanted == count)]
        triangles = shown[:, piece.nodes[piece.faces]].reshape(-1, 3)
        faces.append(triangles)
        part.append(np.full(len(triangles), NAMES.index(piece.name)))
    used = np.zeros(numbers.size, dtype=bool)
    every = np.concatenate(faces)
    used[every] = True
    angles = np.asarray(2.0 * math.pi / count * np.arange(wanted), dtype=float)
    points = rotated_copies(tooth.points, angles).reshape(-1, 3)
    return Solid(points[used], (np.cumsum(used) - 1)[every], np.concatenate(part), NAMES)


def joined_numbers(teeth: Sequence[tuple[int, Indices, Indices]], closed: bool) -> list[Indices]:
    """Return the point numbers of adjacent teeth that share the points of their sides.

    Parameters
    ----------
    teeth : sequence of (int, array, array)
        For each tooth the number of its points, and the indices of those on its first and last side.
    closed : bool
        Whether the last tooth is adjacent to the first one.

    Returns
    -------
    list of arrays
        For each tooth the new numbers of its points.
    """
    starts = np.cumsum([0, *(size for size, _, _ in teeth)])
    numbers = [np.arange(start, start + size) for start, (size, _, _) in zip(starts, teeth, strict=False)]
    ahead = [tooth_numbers[first] for tooth_numbers, (_, first, _) in zip(numbers, teeth, strict=True)]
    for k in range(len(teeth) if closed else len(teeth) - 1):
        numbers[k][teeth[k][2]] = ahead[(k + 1) % len(teeth)]
    return numbers


def teeth_with(name: str, teeth: int, closed: bool) -> slice:
    """Return which of some adjacent teeth show the surface `name`: all, except for the sides, which only the
    first and the last tooth show, and none in a `closed` gear."""
    if name not in SIDES:
        return slice(None)
    return slice(0, 0) if closed else slice(0, 1) if name == SIDES[0] else slice(teeth - 1, None)


def rotated_copies(vectors: FloatArray, angles: FloatArray) -> FloatArray:
    """Return vectors (n, 3) rotated about z by each of the angles (k,), rad: (k, n, 3)."""
    plane = np.exp(1.0j * angles)[:, None] * (vectors[:, :2] @ (1.0, 1.0j))
    return np.stack((plane.real, plane.imag, np.broadcast_to(vectors[:, 2], plane.shape)), axis=-1)
