"""Files for other programs: surfaces of triangles, meshes of hexahedra, CAD.

Libraries write all formats but three. Without VTK none writes triangles as .vtp (pyevtk has points
and lines), so `vtp` does. meshio's .inp has neither surfaces nor loads and calls its hexahedra
C3D8RH, and its .bdf cannot hold negative coordinates of twelve digits nor name an element of 20
nodes as Nastran does: hence `abaqus` and `nastran`.
"""

from __future__ import annotations

SURFACE_FORMATS = (".stl", ".ply", ".obj", ".vtk", ".vtp", ".vtu")
FIELD_FORMATS = (".vtk", ".vtp", ".vtu")
"""Those surface formats that hold fields."""
MEMBERS = ("pinion", "gear")
VOLUME_FORMATS = (".inp", ".msh", ".bdf", ".vtu")
CAD_FORMATS = (".step", ".stp")
CONVENTIONS = (
    "Units: N, mm, MPa, tonne, s.",
    "Own frame of the gear: z along its axis from mid-face towards the heel, x through the first tooth.",
)
"""What the header of a mesh of hexahedra says."""


def identifier(name: str) -> str:
    """The name of a part or set as files have it: 'right flank' is right_flank."""
    return "_".join(name.split())
