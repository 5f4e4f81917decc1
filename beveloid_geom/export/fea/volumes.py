"""Meshes of hexahedra with their sets, written as .inp, .msh, .bdf or .vtu."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Indices
from ...export import OWN_FRAME, UNITS, VOLUME_FORMATS, identifier, writer_of
from ...shapes.elements import VolumeMesh, face_nodes
from .abaqus import LoadCase

if TYPE_CHECKING:
    import meshio

CELLS = {4: "quad", 8: "quad8"}
HEXAHEDRA = {8: "hexahedron", 20: "hexahedron20"}
BODY = "body"


def write_volume(
    mesh: VolumeMesh,
    path: Path,
    element: str,
    *,
    case: LoadCase | None = None,
    comment: Sequence[str] = (),
    suffix: str | None = None,
    frame: str = OWN_FRAME,
) -> None:
    """Write hexahedra into `path` in the format that `suffix` names, that of `path` if None.

    `element` is 'C3D20', 'C3D20R', 'C3D8I' or 'C3D8'; a load `case` goes into .inp, lines of `comment` and
    the words for the `frame` of the points into .inp and .bdf. Raises ValueError for a suffix that is none of
    VOLUME_FORMATS, OSError where the file cannot be written."""
    writer = writer_of(VOLUME_FORMATS, path.suffix.lower() if suffix is None else suffix)
    writer(path, mesh, element, case, (*comment, frame, UNITS))


def write_msh(path: Path, mesh: VolumeMesh, *_: object) -> None:
    """Write Gmsh's format 4.1, in binary: in ASCII meshio writes what numpy 2 calls its numbers."""
    _gmsh_mesh(mesh).write(path, file_format="gmsh", binary=True)


def write_vtu(path: Path, mesh: VolumeMesh, *_: object) -> None:
    """Write VTK's XML format, with a field of 0 and 1 for each set."""
    _vtu_mesh(mesh).write(path, file_format="vtu")


def _members(size: int, sets: Mapping[str, Indices]) -> dict[str, NDArray[Any]]:
    """For each set an array (size,) that is 1 on its members."""
    fields = {}
    for name, indices in sets.items():
        field = np.zeros(size, dtype=np.int32)
        field[indices] = 1
        fields[identifier(name)] = field
    return fields


def _vtu_mesh(mesh: VolumeMesh) -> meshio.Mesh:
    import meshio

    cells = [(HEXAHEDRA[mesh.hexahedra.shape[1]], mesh.hexahedra)]
    points = _members(len(mesh.points), mesh.node_sets)
    elements = _members(len(mesh.hexahedra), mesh.element_sets)
    return meshio.Mesh(mesh.points, cells, points, {name: [field] for name, field in elements.items()})


def plain_surfaces(mesh: VolumeMesh) -> dict[str, Indices]:
    """Give the surfaces that share no face: where those of each tooth are there ('right flank 1'),
    the one that holds them all is left out."""
    whole = {re.sub(r" \d+$", "", name) for name in mesh.surfaces if re.search(r" \d+$", name)}
    return {name: faces for name, faces in mesh.surfaces.items() if name not in whole and len(faces)}


def _gmsh_mesh(mesh: VolumeMesh) -> meshio.Mesh:
    """Write hexahedra as one physical volume, and the faces of each surface as a physical surface.

    Gmsh's format 4.1 gives an entity its physical group, and meshio writes only entities that own
    nodes. So each owns at least one of its nodes, the volume those on no surface besides."""
    import meshio

    surfaces = plain_surfaces(mesh)
    quads = [face_nodes(mesh, faces) for faces in surfaces.values()]
    names = [*(identifier(name) for name in surfaces), BODY]
    dimensions = [2] * len(quads) + [3]
    blocks = [(CELLS[nodes.shape[1]], nodes) for nodes in quads]
    blocks.append((HEXAHEDRA[mesh.hexahedra.shape[1]], mesh.hexahedra))
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
    """Find the dimension and tag (count, 2) of the entity that owns each node, the volume's tag last. Raises
    ValueError where one finds all of its nodes taken, which takes a mesh of next to no elements."""
    owner = np.zeros(count, dtype=np.int64)
    nodes = [*(np.unique(block) for block in quads), np.arange(count)]
    for tag in sorted(range(1, len(nodes) + 1), key=lambda tag: len(nodes[tag - 1])):
        free = nodes[tag - 1][owner[nodes[tag - 1]] == 0]
        if not len(free):
            raise ValueError("the mesh is too coarse for .msh: a surface has no node of its own")
        owner[free[len(free) // 2]] = tag
    for tag, own in enumerate(nodes, 1):
        owner[own[owner[own] == 0]] = tag
    return np.stack((np.where(owner == len(nodes), 3, 2), owner), axis=-1)
