"""Conversion of meshes to PyVista, for scripts and notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beveloid_geom.shapes.hexahedral_mesh import VolumeMesh
from beveloid_geom.shapes.sampling import FlankGrid
from beveloid_geom.shapes.sheet import grid_faces
from beveloid_geom.shapes.solid import Solid
from beveloid_geom.shapes.surface_mesh import TriangleMesh

if TYPE_CHECKING:
    import pyvista as pv


def to_pyvista(shape: FlankGrid | TriangleMesh | Solid | VolumeMesh) -> pv.PolyData | pv.UnstructuredGrid:
    """Convert a mesh of the library to a PyVista mesh.

    Parameters
    ----------
    shape : FlankGrid, TriangleMesh, Solid or VolumeMesh
        Result of `sample_flank`, `gear_mesh`, `gear_solid` or `tooth_hexahedra`.

    Returns
    -------
    pyvista.PolyData or pyvista.UnstructuredGrid
        The same points in the same order (row by row for a flank), mm, with exact normals if available.
        Hexahedra become an UnstructuredGrid.
    """
    import pyvista as pv  # takes half a second to import

    if isinstance(shape, VolumeMesh):
        kind = {8: pv.CellType.HEXAHEDRON, 20: pv.CellType.QUADRATIC_HEXAHEDRON}[shape.hexahedra.shape[1]]
        return pv.UnstructuredGrid({kind: shape.hexahedra}, shape.points)
    faces: Any = grid_faces(shape.points, shape.normals) if isinstance(shape, FlankGrid) else shape.faces
    mesh: pv.PolyData = pv.PolyData.from_regular_faces(shape.points.reshape(-1, 3), faces)
    if not isinstance(shape, Solid):
        mesh.point_data.active_normals = np.reshape(shape.normals, (-1, 3))
    return mesh
