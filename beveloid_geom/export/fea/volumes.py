"""Hexahedral meshes with their sets, written as .inp, .msh, .bdf or .vtu."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Indices
from ...export import GEAR_FRAME, UNITS, VOLUME_FORMATS, identifier, writer_of
from ...shapes.hexahedral_mesh import VolumeMesh, face_nodes
from .abaqus import LoadCase

if TYPE_CHECKING:
    import meshio

ELEMENT_TYPES = {8: "hexahedron", 20: "hexahedron20"}
"""Names of the element types in meshio, by number of nodes."""


def write_volume(
    mesh: VolumeMesh,
    path: Path | str,
    element: str,
    *,
    case: LoadCase | None = None,
    comment: Sequence[str] = (),
    suffix: str | None = None,
    frame: str = GEAR_FRAME,
) -> None:
    """Write hexahedra to a file in the format of a suffix.

    Parameters
    ----------
    mesh : VolumeMesh
        Hexahedra; coordinates in mm.
    path : Path or str
        File to write.
    element : {'C3D20', 'C3D20R', 'C3D8I', 'C3D8'}
        Element type.
    case : LoadCase, optional
        Load and supports; only .inp holds them.
    comment : sequence of str
        Lines for the header of .inp and .bdf.
    suffix : str, optional
        Format, a key of VOLUME_FORMATS. By default, the suffix of `path`.
    frame : str
        Description of the coordinate frame for the header.

    Raises
    ------
    ValueError
        If there is no writer for the suffix.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    writer = writer_of(VOLUME_FORMATS, path.suffix.lower() if suffix is None else suffix)
    writer(path, mesh, element, case, (*comment, frame, UNITS))


def write_msh(path: Path, mesh: VolumeMesh, *_: object) -> None:
    """Write Gmsh's format 4.1 in binary. In ASCII, meshio would write the names of NumPy's types."""
    _gmsh_mesh(mesh).write(path, file_format="gmsh", binary=True)


def write_hexahedra_vtu(path: Path, mesh: VolumeMesh, *_: object) -> None:
    """Write VTK's XML format, with a field of 0 and 1 for each set."""
    _vtu_mesh(mesh).write(path, file_format="vtu")


def _set_fields(size: int, sets: Mapping[str, Indices]) -> dict[str, NDArray[Any]]:
    """Return an array (size,) for each set, which is 1 on its members and 0 elsewhere."""
    fields = {}
    for name, indices in sets.items():
        field = np.zeros(size, dtype=np.int32)
        field[indices] = 1
        fields[identifier(name)] = field
    return fields


def _vtu_mesh(mesh: VolumeMesh) -> meshio.Mesh:
    import meshio

    cells = [(ELEMENT_TYPES[mesh.hexahedra.shape[1]], mesh.hexahedra)]
    points = _set_fields(len(mesh.points), mesh.node_sets)
    elements = _set_fields(len(mesh.hexahedra), mesh.element_sets)
    return meshio.Mesh(mesh.points, cells, points, {name: [field] for name, field in elements.items()})


def disjoint_surfaces(mesh: VolumeMesh) -> dict[str, Indices]:
    """Return surfaces that share no face: a surface that is the union of numbered ones is left out."""
    unions = {re.sub(r" \d+$", "", name) for name in mesh.surfaces if re.search(r" \d+$", name)}
    return {name: faces for name, faces in mesh.surfaces.items() if name not in unions and len(faces)}


def _gmsh_mesh(mesh: VolumeMesh) -> meshio.Mesh:
    """Return hexahedra as one physical volume, with the faces of each surface as a physical surface.

    In Gmsh's format 4.1 an entity has a physical group, and meshio writes only entities that own nodes.
    Therefore each surface owns at least one of its nodes, and the volume those on no surface."""
    face_types = {4: "quad", 8: "quad8"}
    import meshio

    surfaces = disjoint_surfaces(mesh)
    quads = [face_nodes(mesh, faces) for faces in surfaces.values()]
    names = [*(identifier(name) for name in surfaces), "body"]
    dimensions = [2] * len(quads) + [3]
    blocks = [(face_types[nodes.shape[1]], nodes) for nodes in quads]
    blocks.append((ELEMENT_TYPES[mesh.hexahedra.shape[1]], mesh.hexahedra))
    tags = [np.full(len(nodes), tag) for tag, (_, nodes) in enumerate(blocks, 1)]
    return meshio.Mesh(
        mesh.points,
        blocks,
        point_data={"gmsh:dim_tags": _owners(len(mesh.points), quads)},
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={
            name: np.array([tag, dimension])
            for tag, (name, dimension) in enumerate(zip(names, dimensions, strict=True), 1)
        },
    )


def _owners(count: int, quads: Sequence[Indices]) -> Indices:
    """Return dimension and tag (count, 2) of the entity that owns each node; the volume has the last tag.

    Raises ValueError if no node is left for a surface, as in a mesh of very few elements."""
    owner = np.zeros(count, dtype=np.int64)
    nodes = [*(np.unique(block) for block in quads), np.arange(count)]
    # Small entities choose first, as they have few nodes.
    for tag in sorted(range(1, len(nodes) + 1), key=lambda tag: len(nodes[tag - 1])):
        free = nodes[tag - 1][owner[nodes[tag - 1]] == 0]
        if not len(free):
            raise ValueError("the mesh is too coarse for .msh, as a surface has no separate node: refine it")
        owner[free[len(free) // 2]] = tag
    for tag, indices in enumerate(nodes, 1):
        owner[indices[owner[indices] == 0]] = tag
    return np.stack((np.where(owner == len(nodes), 3, 2), owner), axis=-1)
