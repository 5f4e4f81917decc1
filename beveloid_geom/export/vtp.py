"""VTK's XML format for surfaces (.vtp), arrays in raw binary.

File format: VTK User's Guide, "XML File Formats"; appended raw data, 64 bit block sizes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from .surfaces import SurfaceMesh

Array = NDArray[Any]
TYPES = {"f": "Float", "i": "Int", "u": "UInt"}


class _Appended:
    """Arrays that follow the XML, and the elements that point at them."""

    def __init__(self) -> None:
        self.arrays: list[Array] = []
        self.offset = 0

    def element(self, name: str, values: Array) -> str:
        """Give the XML element of an array (n,) or (n, components)."""
        array = np.ascontiguousarray(values)
        kind = f"{TYPES[array.dtype.kind]}{8 * array.dtype.itemsize}"
        parts = array.shape[1] if array.ndim > 1 else 1
        text = f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{parts}"'
        text += f' format="appended" offset="{self.offset}"/>\n'
        self.arrays.append(array)
        self.offset += 8 + array.nbytes
        return text


def write_polydata(surface: SurfaceMesh, path: Path, _: str = "") -> None:
    """Write triangles with their fields on points and on faces."""
    points, faces = surface.points, surface.faces
    data = _Appended()
    inner = ""
    for tag, fields in (("PointData", surface.point_fields), ("CellData", surface.cell_fields)):
        normals = ' Normals="normals"' if "normals" in fields else ""
        inner += f"<{tag}{normals}>\n"
        inner += "".join(data.element(*field) for field in fields.items()) + f"</{tag}>\n"
    inner += f"<Points>\n{data.element('points', points)}</Points>\n<Polys>\n"
    inner += data.element("connectivity", faces.ravel())
    inner += data.element("offsets", 3 * np.arange(1, len(faces) + 1)) + "</Polys>\n"
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    head = '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0"'
    head += f' byte_order="{order}" header_type="UInt64">\n<PolyData>\n'
    head += f'<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(faces)}">\n'
    tail = '</Piece>\n</PolyData>\n<AppendedData encoding="raw">\n_'
    with open(path, "wb") as file:
        file.write((head + inner + tail).encode())
        for array in data.arrays:
            file.write(np.uint64(array.nbytes).tobytes())
            file.write(array.data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
