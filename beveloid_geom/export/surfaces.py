"""Triangle surfaces with fields, and the writers of .stl, .ply, .obj and .3mf. `vtk_files` has those of VTK.

Lengths are mm. An .stl file holds coordinates in single precision, with a rounding error of 6e-8 of the
largest coordinate. An .obj file holds nine decimals, all other formats double precision."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import MEMBERS, FloatArray
from ..contact.mesh_position import Frame
from ..export import SURFACE_FORMATS, writer_of
from ..pair.frames import normals_to_fixed, to_fixed
from ..shapes.sheet import Faces

Fields: TypeAlias = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """Triangles with fields, ready to be written.

    Parameters
    ----------
    points : array (n, 3)
        Coordinates, mm.
    faces : array (m, 3)
        Point indices of the triangles, counterclockwise seen from outside.
    point_fields, cell_fields : mapping of str to array
        Values on points (n,) or (n, 3) and on triangles (m,) or (m, 3). The point field 'normals' holds unit
        normals, which point out of the metal and are exact except on cut sides.
    part_names : tuple of str
        Names of the values 0, 1, ... of the cell field 'part'.
    """

    points: FloatArray
    faces: Faces
    point_fields: Fields
    cell_fields: Fields
    part_names: tuple[str, ...] = ()


def in_fixed(surface: SurfaceMesh, frame: Frame) -> SurfaceMesh:
    """Return a surface, given in the frame of its gear, in the fixed frame S_f, with its normals."""
    fields = dict(surface.point_fields)
    if "normals" in fields:
        fields["normals"] = normals_to_fixed(frame, fields["normals"])
    return replace(surface, points=to_fixed(frame, surface.points), point_fields=fields)


def moved(surface: SurfaceMesh, distance: FloatArray) -> SurfaceMesh:
    """Return a surface that is moved by a distance (3,), mm."""
    return replace(surface, points=surface.points + distance)


def joined_surfaces(surfaces: Sequence[SurfaceMesh]) -> SurfaceMesh:
    """Return several surfaces as one, with the fields that all of them have."""
    starts = np.cumsum([0, *(len(surface.points) for surface in surfaces[:-1])])

    def joined_fields(fields: Sequence[Fields]) -> Fields:
        names = [name for name in fields[0] if all(name in other for other in fields)]
        return {name: np.concatenate([one[name] for one in fields]) for name in names}

    return SurfaceMesh(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([one.faces + start for one, start in zip(surfaces, starts, strict=True)]),
        joined_fields([surface.point_fields for surface in surfaces]),
        joined_fields([surface.cell_fields for surface in surfaces]),
        surfaces[0].part_names,
    )


def write_surface(surface: SurfaceMesh, path: Path | str, suffix: str | None = None, title: str = "") -> None:
    """Write triangles to a file in the format of a suffix.

    Parameters
    ----------
    surface : SurfaceMesh
        In a .obj file the members of a pair are groups, in a .3mf file objects. The formats .ply and .obj
        hold the normals, too, .stl and .3mf only the triangles; the VTK formats hold all fields.
    path : Path or str
        File to write.
    suffix : str, optional
        Format, a key of SURFACE_FORMATS. By default, the suffix of `path`.
    title : str
        Text for the header of .stl, .ply, .obj and .vtk, and name of the object in .3mf. Line breaks become
        spaces.

    Raises
    ------
    ValueError
        If there is no writer for the suffix.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    writer = writer_of(SURFACE_FORMATS, path.suffix.lower() if suffix is None else suffix)
    writer(surface, path, " ".join(f"beveloid-geom {title}".split()))


def write_stl(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a binary STL file with the title in its header."""
    data = bytearray(_trimesh(surface.points, surface.faces, None).export(file_type="stl"))
    header = title.encode("ascii", "replace")[:80]  # bytes of the header
    data[: len(header)] = header
    path.write_bytes(data)


def write_ply(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a binary PLY file in double precision, with the normals if there are any.

    The title replaces the comment of meshio, which holds the present time."""
    import meshio

    normals = surface.point_fields.get("normals")
    data = {} if normals is None else {f"n{axis}": normals[:, k] for k, axis in enumerate("xyz")}
    faces = surface.faces.astype(np.int32)  # PLY has no longer integers
    meshio.write(path, meshio.Mesh(surface.points, [("triangle", faces)], data), file_format="ply")
    content = path.read_bytes()
    path.write_bytes(re.sub(rb"(?m)^comment .*$", b"comment " + title.encode(), content, count=1))


def write_obj(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write an OBJ file: a text of points and triangles, with the normals if there are any.

    The members of a pair are groups and objects; they have no normals."""
    from trimesh.exchange import obj

    export: Any = obj.export_obj
    normals = surface.point_fields.get("normals")
    if "member" in surface.cell_fields:
        text = str(export(_scene(surface, title), include_normals=False, digits=9, header=title))
        text = re.sub(r"^o (.+)$", r"o \1\ng \1", text, flags=re.MULTILINE)
    else:
        mesh = _trimesh(surface.points, surface.faces, normals)
        text = str(export(mesh, include_normals=normals is not None, digits=9, header=title))
    path.write_text(text, encoding="utf-8")


def write_3mf(surface: SurfaceMesh, path: Path, title: str) -> None:
    """Write a 3MF file in mm, with one object for each member of a pair.

    The random identifiers and the extensions that trimesh adds are removed: the identifiers are not valid
    3MF, and with them the file would differ from run to run."""
    data = io.BytesIO(_scene(surface, title).export(file_type="3mf"))
    with zipfile.ZipFile(data) as source, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name in source.namelist():
            content = re.sub(rb' (p:UUID|xmlns:\w+|(?<=item )xmlns)="[^"]*"', b"", source.read(name))
            target.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)


def _trimesh(points: FloatArray, faces: Faces, normals: NDArray[Any] | None) -> Any:
    """Return a trimesh.Trimesh of exactly these points and triangles, without merging or dropping any."""
    import trimesh

    return trimesh.Trimesh(points, faces, vertex_normals=normals, process=False)


def _scene(surface: SurfaceMesh, title: str) -> Any:
    """Return a trimesh.Scene with one geometry for each member of a pair, or one for a single surface."""
    import trimesh

    scene, members = trimesh.Scene(), surface.cell_fields.get("member")
    if members is None:
        scene.add_geometry(_trimesh(surface.points, surface.faces, None), geom_name=title, node_name=title)
        return scene
    for number, name in enumerate(MEMBERS):
        # The points of a member follow each other, because `joined_surfaces` puts one member after the other.
        faces = surface.faces[members == number]
        first = faces.min()
        mesh = _trimesh(surface.points[first : faces.max() + 1], faces - first, None)
        mesh.metadata["name"] = name
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    return scene
