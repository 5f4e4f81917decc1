"""Files for other programs: surfaces of triangles, meshes of hexahedra, CAD.

Libraries write all formats but three. Without VTK none writes triangles as .vtp (pyevtk has points
and lines), so `vtp` does. meshio's .inp has neither surfaces nor loads and calls its hexahedra
C3D8RH, and its .bdf cannot hold negative coordinates of twelve digits nor name an element of 20
nodes as Nastran does: hence `fea.abaqus` and `fea.nastran`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pkgutil import resolve_name
from typing import NamedTuple


class Format(NamedTuple):
    """The `writer` of a format as 'module:function' of this room, which is imported where it is needed; its
    `purpose`, the programs that read it; whether it holds `fields` of numbers."""

    writer: str
    purpose: str
    fields: bool = False


SURFACE_FORMATS = {
    ".stl": Format("surfaces:write_stl", "CAD, printing"),
    ".ply": Format("surfaces:write_ply", "CAD, printing"),
    ".obj": Format("surfaces:write_obj", "CAD, printing"),
    ".3mf": Format("surfaces:write_3mf", "CAD, printing"),
    ".vtk": Format("surfaces:write_vtk", "ParaView", fields=True),
    ".vtp": Format("vtp:write_polydata", "ParaView", fields=True),
    ".vtu": Format("surfaces:write_vtu", "ParaView", fields=True),
}
"""Of triangles: a writer takes a `SurfaceMesh`, the path, and a title."""
VOLUME_FORMATS = {
    ".inp": Format("fea.abaqus:write_deck", "CalculiX, Abaqus"),
    ".msh": Format("fea.volumes:write_msh", "Gmsh"),
    ".bdf": Format("fea.nastran:write_bulk", "Nastran"),
    ".vtu": Format("fea.volumes:write_vtu", "ParaView"),
}
"""Of hexahedra: a writer takes the path, a `VolumeMesh`, the element, a `LoadCase` or None, and lines of
comment."""
CONTACT_FORMATS = {".inp": Format("fea.pair_deck:write_pair_deck", "CalculiX, Abaqus")}
"""Of the pair in contact: a writer takes the path, a design, a `PairMesh`, the torque, and comment."""
CAD_FORMATS = {
    ".step": Format("step:write_step", "CAD"),
    ".stp": Format("step:write_step", "CAD"),
}
"""Of solids: a writer takes a member, the path, teeth, the radius of the bore, a name, and a frame."""
ASSEMBLY_FORMATS = {suffix: Format("step:write_step_pair", "CAD") for suffix in CAD_FORMATS}
"""Of the pair as solids: a writer takes a design, the path, and the frames of its members in mesh."""
SCENE_FORMATS = {".glb": Format("scene:write_glb", "viewers, web pages")}
"""Of the pair to look at: a writer takes pieces, and the path."""
FIELD_FORMATS = tuple(suffix for suffix, one in SURFACE_FORMATS.items() if one.fields)
"""Those surface formats that hold fields."""
MEMBERS = ("pinion", "gear")
UNITS = "Units: N, mm, MPa, tonne, s."
OWN_FRAME = (
    "Own frame of the gear: z along its axis from mid-face towards the heel, x through the first tooth."
)
FIXED_FRAME = (
    "Frame of the pair in mesh: z along the pinion's axis, x along the common perpendicular to the gear's."
)
"""What the header of a mesh of hexahedra says."""


def identifier(name: str) -> str:
    """Give the name of a part or set as files have it: 'right flank' is right_flank."""
    return "_".join(name.split())


def writer_of(formats: Mapping[str, Format], suffix: str) -> Callable[..., None]:
    """Give the writer of one of the `formats`. Raises ValueError for a suffix that is not among them."""
    if suffix not in formats:
        raise ValueError(f"there is no writer of {suffix!r}: give one of {', '.join(formats)}")
    writer: Callable[..., None] = resolve_name(f"{__name__}.{formats[suffix].writer}")
    return writer


def suffixes_by_purpose(formats: Mapping[str, Format]) -> str:
    """Name the formats for a help text, as '.stl, .ply (CAD), .vtk (ParaView)'."""
    groups: dict[str, list[str]] = {}
    for suffix, one in formats.items():
        groups.setdefault(one.purpose, []).append(suffix)
    return ", ".join(f"{', '.join(suffixes)} ({purpose})" for purpose, suffixes in groups.items())
