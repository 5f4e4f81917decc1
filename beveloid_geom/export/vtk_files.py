"""VTK files of triangles with fields, written by VTK: .vtp, .vtu and the legacy format .vtk.

A .vtp file holds a surface. A .vtu and a .vtk file hold an unstructured grid of triangles, which more
programs read than surfaces. All numbers are in double precision; the XML formats are compressed without loss.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..export import identifier
from .surfaces import SurfaceMesh


def write_vtp(surface: SurfaceMesh, path: Path, _: str = "") -> None:
    """Write triangles as a surface in VTK's XML format."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    _write(vtkXMLPolyDataWriter(), _poly_data(surface), path)


def write_triangles_vtu(surface: SurfaceMesh, path: Path, _: str = "") -> None:
    """Write triangles as an unstructured grid in VTK's XML format."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    _write(vtkXMLUnstructuredGridWriter(), _grid(surface), path)


def write_legacy_vtk(surface: SurfaceMesh, path: Path, title: str = "") -> None:
    """Write triangles as an unstructured grid in VTK's binary legacy format, with a title."""
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter

    writer = vtkUnstructuredGridWriter()
    writer.SetFileTypeToBinary()
    writer.SetFileVersion(42)  # version 4.2, which other programs read, too
    writer.SetHeader(title[:255])
    # meshio does not read the section of active normals in the legacy format.
    _write(writer, _grid(surface, active_normals=False), path)


def _poly_data(surface: SurfaceMesh, active_normals: bool = True) -> Any:
    """Return the vtkPolyData of a surface, with the fields and the names of its parts."""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    data, points, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    points.SetData(_array(surface.points))
    corners = surface.faces
    cells.SetData(_array(3 * np.arange(len(corners) + 1)), _array(corners.ravel()))
    data.SetPoints(points)
    data.SetPolys(cells)
    for fields, attributes in (
        (surface.point_fields, data.GetPointData()),
        (surface.cell_fields, data.GetCellData()),
    ):
        for name, values in fields.items():
            array = _array(values)
            array.SetName(name)
            attributes.AddArray(array)
        if "normals" in fields and active_normals:
            attributes.SetActiveNormals("normals")
    for number, name in enumerate(surface.part_names):
        # An array of numbers, because many readers of VTK files do not know arrays of strings.
        array = _array(np.array([number]))
        array.SetName(identifier(name))
        data.GetFieldData().AddArray(array)
    return data


def _array(values: NDArray[Any]) -> Any:
    """Return a VTK array with a copy of the values, as double precision or 64-bit integers."""
    from vtkmodules.util import numpy_support

    to_vtk: Any = numpy_support.numpy_to_vtk
    kind = np.float64 if values.dtype.kind == "f" else np.int64
    return to_vtk(np.ascontiguousarray(values, dtype=kind), deep=True)


def _grid(surface: SurfaceMesh, active_normals: bool = True) -> Any:
    """Return the vtkUnstructuredGrid of a surface."""
    from vtkmodules.vtkCommonDataModel import VTK_TRIANGLE, vtkUnstructuredGrid

    data, grid = _poly_data(surface, active_normals), vtkUnstructuredGrid()
    grid.SetPoints(data.GetPoints())
    grid.SetCells(VTK_TRIANGLE, data.GetPolys())
    grid.GetPointData().ShallowCopy(data.GetPointData())
    grid.GetCellData().ShallowCopy(data.GetCellData())
    grid.SetFieldData(data.GetFieldData())
    return grid


def _write(writer: Any, data: Any, path: Path) -> None:
    """Let VTK write into memory, so that a full disk raises OSError with its reason."""
    writer.SetInputData(data)
    writer.WriteToOutputStringOn()
    writer.Write()
    legacy = hasattr(writer, "GetOutputStdString")
    text = writer.GetOutputStdString() if legacy else writer.GetOutputString()
    path.write_bytes(text if isinstance(text, bytes) else text.encode())  # bytes if it is not UTF-8
