"""Abaqus and CalculiX input (.inp): mesh, named sets and surfaces, and one static load case.

All keywords and their parameters are common to both programs: Abaqus Keywords Reference Guide, CalculiX
CrunchiX User's Manual 2.20. Sets are not nested, and have each number once: CalculiX would keep a number
twice, and add its reaction twice. Numbers have at most 12 significant digits, which fit into CalculiX's
fields of 20 characters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...arrays import FloatArray, Indices
from ...export import identifier
from ...shapes.hexahedra import ELEMENTS
from ...shapes.hexahedral_mesh import VolumeMesh
from .load import ContactLoad
from .material import DENSITY_T_PER_MM3, POISSON_RATIO, YOUNG_MPA

FIXED_SETS = ("bore", "first side", "last side")
"""Surfaces at which a body is cut from its shaft and from the rest of the gear. They are held."""
STEEL = (
    f"*MATERIAL, NAME=steel\n*ELASTIC\n{YOUNG_MPA:g}, {POISSON_RATIO:g}\n*DENSITY\n{DENSITY_T_PER_MM3:g}\n"
    "*SOLID SECTION, ELSET=body, MATERIAL=steel\n"
)
"""Material of all elements."""


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A static load case.

    Attributes
    ----------
    load : ContactLoad
        Nodal forces.
    observer : int
        Index of the point whose displacement is printed.
    fixed : tuple of str
        Node sets that are held in all directions.
    """

    load: ContactLoad
    observer: int
    fixed: tuple[str, ...] = FIXED_SETS


def nearest_node(mesh: VolumeMesh, point: FloatArray) -> int:
    """Return the index of the mesh point nearest to `point` (3,), mm."""
    return int(np.argmin(((mesh.points - point) ** 2).sum(axis=-1)))


def fixed_nodes(mesh: VolumeMesh, case: LoadCase) -> Indices:
    """Return the sorted indices of all points that are held.

    Raises ValueError if the load acts on one of them, because its reaction would not be part of the
    result."""
    fixed = np.unique(np.concatenate([mesh.node_sets[name] for name in case.fixed]))
    if np.isin(case.load.nodes, fixed).any():
        raise ValueError("the load acts on nodes that are held: use a smaller bore or a finer mesh")
    return fixed


def write_deck(
    path: Path, mesh: VolumeMesh, element: str, case: LoadCase | None = None, comment: Sequence[str] = ()
) -> None:
    """Write a mesh with its sets. With a load case, CalculiX runs the file as it is.

    Parameters
    ----------
    path, mesh, element, comment
        See `write_model`.
    case : LoadCase, optional
        Load and supports.
    """
    write_model(path, mesh, element, () if case is None else _static(mesh, case), comment)


def write_model(
    path: Path, mesh: VolumeMesh, element: str, history: Iterable[str], comment: Sequence[str]
) -> None:
    """Write a mesh with its sets, and the lines that follow it.

    Parameters
    ----------
    path : Path
        File to write.
    mesh : VolumeMesh
        Hexahedra; coordinates in mm.
    element : str
        Element type, a key of `hexahedra.ELEMENTS`.
    history : iterable of str
        Lines after the mesh: material, supports, steps.
    comment : sequence of str
        Lines for the header.

    Raises
    ------
    ValueError
        If the element has another number of nodes than those of the mesh.
    """
    if ELEMENTS.get(element) != mesh.hexahedra.shape[1]:
        raise ValueError(
            f"a mesh of elements with {mesh.hexahedra.shape[1]} nodes cannot be written as {element}"
        )
    with open(path, "w", encoding="ascii", errors="replace", newline="\n") as file:
        for part in (_header(comment), _mesh(mesh, element), _sets(mesh), history):
            file.writelines(part)


def _header(comment: Sequence[str]) -> Iterator[str]:
    yield "*HEADING\nbeveloid-geom\n"
    yield from (f"** {' '.join(line.split())}\n" for line in comment)


def _mesh(mesh: VolumeMesh, element: str) -> Iterator[str]:
    yield "*NODE\n"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        yield f"{number}, {x:.12g}, {y:.12g}, {z:.12g}\n"
    yield f"*ELEMENT, TYPE={element}, ELSET=body\n"
    for number, nodes in enumerate((mesh.hexahedra + 1).tolist(), 1):
        yield _lines([number, *nodes])


def _lines(numbers: Sequence[int]) -> str:
    """Return numbers separated by commas; a line that is continued ends with a comma."""
    rows = (numbers[start : start + 12] for start in range(0, len(numbers), 12))
    return ",\n".join(", ".join(map(str, row)) for row in rows) + "\n"


def _set(keyword: str, name: str, indices: Indices) -> str:
    return f"*{keyword}, {keyword}={identifier(name)}\n{_lines((np.unique(indices) + 1).tolist())}"


def _sets(mesh: VolumeMesh) -> Iterator[str]:
    for keyword, sets in (("NSET", mesh.node_sets), ("ELSET", mesh.element_sets)):
        yield from (_set(keyword, name, indices) for name, indices in sets.items() if len(indices))
    for name, faces in mesh.surfaces.items():
        if len(faces):
            yield f"*SURFACE, NAME={identifier(name)}, TYPE=ELEMENT\n"
            yield from (f"{cell + 1}, S{face + 1}\n" for cell, face in np.unique(faces, axis=0).tolist())


def _static(mesh: VolumeMesh, case: LoadCase) -> Iterator[str]:
    """Yield material, supports, nodal forces and output requests of a load case."""
    load = case.load
    force, point, observer = (
        ", ".join(f"{x:.6g}" for x in vector)
        for vector in (load.total, load.point, mesh.points[case.observer])
    )
    yield _set("NSET", "fixed", fixed_nodes(mesh, case))
    yield _set("NSET", "loaded", load.nodes)
    yield f"** The displacement of the node at ({observer}) mm is printed.\n"
    yield _set("NSET", "observer", np.array([case.observer]))
    yield f"{STEEL}*STEP\n*STATIC\n*BOUNDARY\nfixed, 1, 3\n"
    yield f"** The force ({force}) N at ({point}) mm,\n** {load.description},\n"
    yield "** as equivalent nodal forces. Stresses at the contact are not resolved.\n*CLOAD\n"
    for node, components in zip(load.nodes.tolist(), load.forces.tolist(), strict=True):
        yield from (f"{node + 1}, {axis}, {value:.12g}\n" for axis, value in enumerate(components, 1))
    # Reactions of all held nodes come first, because the sets that follow share the nodes of their edges.
    for name in ("fixed", *case.fixed):
        yield f"*NODE PRINT, NSET={identifier(name)}, TOTALS=YES\nRF\n"
    yield "*NODE PRINT, NSET=observer\nU\n*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n"
