"""Triangles with fields, written as .stl, .ply, .obj, .3mf, .vtk, .vtp or .vtu.

Lengths are mm. .stl and .ply hold single precision (about 1e-5 mm on these gears), .obj nine
decimals, the VTK formats double precision.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..contact.placing import Frame
from ..export import MEMBERS, SURFACE_FORMATS, writer_of
from ..pair.frames import normals_to_fixed, to_fixed
from ..shapes.sampling import Faces

Fields: TypeAlias = Mapping[str, NDArray[Any]]
OBJ_DIGITS = 9
STL_HEADER = 80
"""Bytes at the start of a binary file; those of a text start with 'solid'."""


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
    """Place a surface of a member's own frame in S_f, its normals turned too."""
    points, cells = (
        {
            name: normals_to_fixed(frame, values) if name == "normals" else values
            for name, values in fields.items()
        }
        for fields in (surface.point_fields, surface.cell_fields)
    )
    return SurfaceMesh(to_fixed(frame, surface.points), surface.faces, points, cells)


def joined(surfaces: Sequence[SurfaceMesh]) -> SurfaceMesh:
    """Join several surfaces to one, with the fields that all of them have."""
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


def write_surface(surface: SurfaceMesh, path: Path, suffix: str | None = None, title: str = "") -> None:
    """Write triangles into `path` in the format that `suffix` names, that of `path` if None. The `title`
    goes into the header of .stl and .obj; the members of a pair are groups of an .obj.

    Raises ValueError for a suffix that is none of SURFACE_FORMATS, OSError where the file cannot
    be written. .ply and .obj hold the normals beside the points, .stl the points only."""
    writer = writer_of(SURFACE_FORMATS, path.suffix.lower() if suffix is None else suffix)
    writer(surface, path, f"beveloid-geom {title}".strip())


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """Give values as both VTK formats have them: VTK knows only the longest integers as meshio names them."""
    return values if values.dtype.kind == "f" else values.astype(np.int64)


def _write_meshio(surface: SurfaceMesh, path: Path, file_format: str) -> None:
    import meshio

    points, cells = (
        {name: _plain(values) for name, values in fields.items()}
        for fields in (surface.point_fields, surface.cell_fields)
    )
    listed = {name: [values] for name, values in cells.items()}
    mesh = meshio.Mesh(surface.points, [("triangle", surface.faces)], points, listed)
    meshio.write(path, mesh, file_format=file_format)


def write_vtk(surface: SurfaceMesh, path: Path, _: str) -> None:
    """Write VTK's old format."""
    _write_meshio(surface, path, "vtk")


def write_vtu(surface: SurfaceMesh, path: Path, _: str) -> None:
    """Write VTK's XML format of unstructured grids."""
    _write_meshio(surface, path, "vtu")


def write_stl(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a binary STL file, in its header the title."""
    _trimesh(surface.points, surface.faces, None).export(str(path), file_type="stl")
    with open(path, "r+b") as file:
        file.write(title.encode("ascii", "replace")[:STL_HEADER])


def write_ply(surface: SurfaceMesh, path: Path, _: str) -> None:
    """Write a PLY file, with the normals if there are any."""
    normals = surface.point_fields.get("normals")
    mesh = _trimesh(surface.points, surface.faces, normals)
    mesh.export(str(path), file_type="ply", vertex_normal=normals is not None)


def write_obj(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a text of points and triangles, with the normals if there are any."""
    path.write_text(_obj(surface, title), encoding="utf-8")


def _trimesh(points: FloatArray, faces: Faces, normals: NDArray[Any] | None) -> Any:
    """Make trimesh's mesh. Nothing may be merged or dropped: the triangles are those of the calculation."""
    import trimesh

    return trimesh.Trimesh(points, faces, vertex_normals=normals, process=False)


def write_3mf(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a 3MF file, mm, with an object for each member of a pair."""
    _scene(surface, title).export(str(path), file_type="3mf")


def _scene(surface: SurfaceMesh, title: str) -> Any:
    """Make trimesh's scene of a surface, with a geometry for each member of a pair."""
    import trimesh

    of = surface.cell_fields.get("member")
    scene = trimesh.Scene()
    if of is None:
        scene.add_geometry(_trimesh(surface.points, surface.faces, None), geom_name=title, node_name=title)
        return scene
    for number, name in enumerate(MEMBERS):
        faces = surface.faces[of == number]
        start = faces.min()
        mesh = _trimesh(surface.points[start : faces.max() + 1], faces - start, None)
        mesh.metadata["name"] = name
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    return scene


def _obj(surface: SurfaceMesh, title: str) -> str:
    """Write the text of an .obj file, with an object and a group for each member of a pair."""
    from trimesh.exchange import obj

    export: Any = obj.export_obj
    normals = surface.point_fields.get("normals")
    if "member" not in surface.cell_fields:
        mesh = _trimesh(surface.points, surface.faces, normals)
        return str(export(mesh, include_normals=normals is not None, digits=OBJ_DIGITS, header=title))
    text = str(export(_scene(surface, title), include_normals=False, digits=OBJ_DIGITS, header=title))
    return re.sub(r"^o (.+)$", r"o \1\ng \1", text, flags=re.MULTILINE)
