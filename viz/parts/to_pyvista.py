"""Meshes of the library as PyVista's, for one's own pictures and for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beveloid_geom.shapes.elements import VolumeMesh
from beveloid_geom.shapes.sampling import FlankGrid, grid_faces
from beveloid_geom.shapes.solid import Solid
from beveloid_geom.shapes.surface_mesh import Mesh

if TYPE_CHECKING:
    import pyvista as pv


def to_pyvista(shape: FlankGrid | Mesh | Solid | VolumeMesh) -> pv.PolyData | pv.UnstructuredGrid:
    """Convert a mesh of the library to PyVista's.

    Parameters
    ----------
    shape : FlankGrid, Mesh, Solid or VolumeMesh
        What `sample_flank`, `gear_mesh`, `gear_solid` and `tooth_hexahedra` give.

    Returns
    -------
    pyvista.PolyData or, of hexahedra, pyvista.UnstructuredGrid
        mm; the same points in the same order (of a flank row by row), with exact normals where there are any.
    """
    import pyvista as pv  # half a second, and only wanted here

    if isinstance(shape, VolumeMesh):
        kind = {8: pv.CellType.HEXAHEDRON, 20: pv.CellType.QUADRATIC_HEXAHEDRON}[shape.hexahedra.shape[1]]
        return pv.UnstructuredGrid({kind: shape.hexahedra}, shape.points)
    faces: Any = grid_faces(shape.points, shape.normals) if isinstance(shape, FlankGrid) else shape.faces
    mesh: pv.PolyData = pv.PolyData.from_regular_faces(shape.points.reshape(-1, 3), faces)
    if not isinstance(shape, Solid):
        mesh.point_data.active_normals = np.reshape(shape.normals, (-1, 3))
    return mesh
