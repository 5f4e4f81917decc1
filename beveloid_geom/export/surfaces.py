"""Triangles with fields, written as .stl, .ply, .obj, .vtk, .vtp or .vtu.

Lengths are mm. .stl and .ply hold single precision (about 1e-5 mm on these gears), .obj nine
decimals, the VTK formats double precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly import normals_to_fixed, to_fixed
from ..inputs import FloatArray
from ..posing import Frame
from ..sampling import Faces
from . import FIELD_FORMATS, SURFACE_FORMATS
from .vtp import write_polydata

Fields: TypeAlias = Mapping[str, NDArray[Any]]
OBJ_DIGITS = 9


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """Triangles to be written: `points` (n, 3), mm, and `faces` (m, 3), winding outwards, with
    fields by name on points (n,) or (n, 3) and on faces (m,) or (m, 3). A point field 'normals'
    holds the exact unit normals out of the metal."""

    points: FloatArray
    faces: Faces
    point_fields: Fields
    cell_fields: Fields


def in_fixed(surface: SurfaceMesh, frame: Frame) -> SurfaceMesh:
    """A surface of a member's own frame in S_f, its normals turned too."""
    points, cells = (
        {
            name: normals_to_fixed(frame, values) if name == "normals" else values
            for name, values in fields.items()
        }
        for fields in (surface.point_fields, surface.cell_fields)
    )
    return SurfaceMesh(to_fixed(frame, surface.points), surface.faces, points, cells)


def joined(surfaces: Sequence[SurfaceMesh]) -> SurfaceMesh:
    """Several surfaces as one, with the fields that all of them have."""
    starts = np.cumsum([0, *(len(surface.points) for surface in surfaces[:-1])])
    faces = [surface.faces + start for surface, start in zip(surfaces, starts, strict=True)]

    def together(fields: Sequence[Fields]) -> Fields:
        names = [name for name in fields[0] if all(name in other for other in fields)]
        return {name: np.concatenate([one[name] for one in fields]) for name in names}

    return SurfaceMesh(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate(faces),
        together([surface.point_fields for surface in surfaces]),
        together([surface.cell_fields for surface in surfaces]),
    )


def write_surface(surface: SurfaceMesh, path: Path, suffix: str | None = None) -> None:
    """Write triangles into `path` in the format that `suffix` names, that of `path` if None.

    Raises ValueError for a suffix that is none of SURFACE_FORMATS, OSError where the file cannot
    be written. .ply and .obj hold the normals beside the points, .stl the points only."""
    suffix = path.suffix.lower() if suffix is None else suffix
    if suffix not in SURFACE_FORMATS:
        raise ValueError(f"surfaces are written as {', '.join(SURFACE_FORMATS)}, not as {suffix!r}")
    if suffix == ".vtp":
        write_polydata(path, surface.points, surface.faces, surface.point_fields, surface.cell_fields)
    elif suffix in FIELD_FORMATS:
        _write_meshio(surface, path, suffix)
    else:
        _write_trimesh(surface, path, suffix)


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """Values as both VTK formats have them: VTK knows only the longest integers as meshio names them."""
    return values if values.dtype.kind == "f" else values.astype(np.int64)


def _write_meshio(surface: SurfaceMesh, path: Path, suffix: str) -> None:
    import meshio

    points, cells = (
        {name: _plain(values) for name, values in fields.items()}
        for fields in (surface.point_fields, surface.cell_fields)
    )
    listed = {name: [values] for name, values in cells.items()}
    mesh = meshio.Mesh(surface.points, [("triangle", surface.faces)], points, listed)
    meshio.write(path, mesh, file_format={".vtk": "vtk", ".vtu": "vtu"}[suffix])


def _write_trimesh(surface: SurfaceMesh, path: Path, suffix: str) -> None:
    import trimesh

    normals = surface.point_fields.get("normals")
    # Nothing may be merged or dropped: the triangles are to be those of the calculation.
    mesh = trimesh.Trimesh(surface.points, surface.faces, vertex_normals=normals, process=False)
    options: dict[str, dict[str, Any]] = {
        ".stl": {},
        ".ply": {"vertex_normal": normals is not None},
        ".obj": {"include_normals": normals is not None, "digits": OBJ_DIGITS},
    }
    mesh.export(str(path), file_type=suffix.removeprefix("."), **options[suffix])
