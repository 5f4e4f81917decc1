"""Files for other programs: surfaces of triangles, hexahedral meshes, CAD solids, scenes.

Most formats are written by trimesh, meshio, VTK and Open CASCADE. Only .inp and .bdf have separate writers:
meshio writes neither surfaces nor loads to .inp and calls the hexahedra C3D8RH, and its .bdf cannot contain
negative coordinates of twelve digits, nor elements with 20 nodes under Nastran's name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pkgutil import resolve_name
from typing import NamedTuple


class Format(NamedTuple):
    """A file format.

    Attributes
    ----------
    writer : str
        Function as 'module:function' of this package; it is imported when it is needed.
    purpose : str
        Programs that read the format.
    fields : bool
        Whether the format holds fields of numbers.
    """

    writer: str
    purpose: str
    fields: bool = False


SURFACE_FORMATS = {
    ".stl": Format("surfaces:write_stl", "CAD, printing"),
    ".ply": Format("surfaces:write_ply", "CAD, printing"),
    ".obj": Format("surfaces:write_obj", "CAD, printing"),
    ".3mf": Format("surfaces:write_3mf", "CAD, printing"),
    ".vtk": Format("vtk_files:write_legacy_vtk", "ParaView", fields=True),
    ".vtp": Format("vtk_files:write_vtp", "ParaView", fields=True),
    ".vtu": Format("vtk_files:write_triangles_vtu", "ParaView", fields=True),
}
"""Formats of triangles: writers take a `SurfaceMesh`, the path and a title."""
VOLUME_FORMATS = {
    ".inp": Format("fea.abaqus:write_deck", "CalculiX, Abaqus"),
    ".msh": Format("fea.volumes:write_msh", "Gmsh"),
    ".bdf": Format("fea.nastran:write_bulk", "Nastran"),
    ".vtu": Format("fea.volumes:write_hexahedra_vtu", "ParaView"),
}
"""Formats of hexahedra: writers take the path, a `VolumeMesh`, the element, a `LoadCase` or None,
comments."""
CONTACT_FORMATS = {".inp": Format("fea.pair_deck:write_pair_deck", "CalculiX, Abaqus")}
"""Formats of the pair in contact: writers take the path, a design, a `PairMesh`, the torque and comments."""
CAD_FORMATS = {
    ".step": Format("step:write_step", "CAD"),
    ".stp": Format("step:write_step", "CAD"),
}
"""Formats of solids: writers take a member, the path, teeth, the bore radius, a name and a frame."""
ASSEMBLY_FORMATS = {suffix: Format("step:write_step_pair", "CAD") for suffix in CAD_FORMATS}
"""Formats of the pair as solids: writers take a design, the path, frames and bore radii of its members."""
SCENE_FORMATS = {".glb": Format("scene:write_glb", "viewers, web pages")}
"""Formats of scenes: writers take a sequence of `SceneItem` and the path."""
FIELD_FORMATS = tuple(suffix for suffix, one in SURFACE_FORMATS.items() if one.fields)
"""Surface formats that hold fields."""
UNITS = "Units: N, mm, MPa, tonne, s."
GEAR_FRAME = "Own frame of the gear: z along its axis from mid-face, x through the first tooth."
FIXED_FRAME = (
    "Frame of the pair in mesh: z along the pinion's axis, x along the common perpendicular to the gear's."
)
"""Frames in the header of a mesh of hexahedra."""


def identifier(name: str) -> str:
    """Return the name of a part or set in files: 'right flank' becomes right_flank."""
    return "_".join(name.split())


def writer_of(formats: Mapping[str, Format], suffix: str) -> Callable[..., None]:
    """Return the writer of a suffix.

    Raises ValueError if the suffix is not one of the `formats`."""
    if suffix not in formats:
        known = suffix in SURFACE_FORMATS | VOLUME_FORMATS | CAD_FORMATS | SCENE_FORMATS
        fault = "does not suit this object" if known else "is not a known format"
        cure = f"give one of {', '.join(formats)}"
        if formats is CAD_FORMATS and suffix in SURFACE_FORMATS:
            cure += ", or pass gear_solid(member)"
        elif formats is SURFACE_FORMATS and suffix in CAD_FORMATS:
            cure += ", or pass the member"
        raise ValueError(f"{suffix!r} {fault}: {cure}")
    writer: Callable[..., None] = resolve_name(f"{__name__}.{formats[suffix].writer}")
    return writer


def suffixes_by_purpose(formats: Mapping[str, Format]) -> str:
    """Return the suffixes with their purpose for a help text: '.stl, .ply (CAD), .vtk (ParaView)'."""
    groups: dict[str, list[str]] = {}
    for suffix, one in formats.items():
        groups.setdefault(one.purpose, []).append(suffix)
    return ", ".join(f"{', '.join(suffixes)} ({purpose})" for purpose, suffixes in groups.items())
