"""Abaqus and CalculiX input (.inp): mesh, named sets and surfaces, one static load case.

Keywords and their parameters are those that both programs read: Abaqus Keywords Reference Guide,
CalculiX CrunchiX User's Manual 2.20. Every set is written out with each number once: CalculiX keeps
what nested sets hold twice and then adds reactions twice. Numbers have at most 12 significant digits,
which all of CalculiX's fields of 20 characters can hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...arrays import FloatArray, Indices
from ...export import identifier
from ...shapes.elements import VolumeMesh
from ...shapes.hexahedra import ELEMENTS
from .load import ContactLoad
from .material import DENSITY, POISSON, YOUNG

FIXED_SETS = ("bore", "first side", "last side")
"""Where the body is cut from its shaft and from the rest of the gear: all held."""
PER_LINE = 12
STEEL = (
    f"*MATERIAL, NAME=steel\n*ELASTIC\n{YOUNG:g}, {POISSON:g}\n*DENSITY\n{DENSITY:g}\n"
    "*SOLID SECTION, ELSET=body, MATERIAL=steel\n"
)
"""Of all elements."""


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A static load case: `load`, the node sets held in all directions, and the node `observer`
    (index of a point) whose displacement is printed."""

    load: ContactLoad
    observer: int
    fixed: tuple[str, ...] = FIXED_SETS


def nearest_node(mesh: VolumeMesh, point: FloatArray) -> int:
    """Find the index of the mesh point nearest to `point` (3,), mm."""
    return int(np.argmin(((mesh.points - point) ** 2).sum(axis=-1)))


def fixed_nodes(mesh: VolumeMesh, case: LoadCase) -> Indices:
    """Find the sorted unique indices of all points that are held.

    Raises ValueError if the load acts on one of them: its reaction would not be seen."""
    held = np.unique(np.concatenate([mesh.node_sets[name] for name in case.fixed]))
    if np.isin(case.load.nodes, held).any():
        raise ValueError("the loaded face touches what is held: take a smaller bore or a finer mesh")
    return held


def write_deck(
    path: Path, mesh: VolumeMesh, element: str, case: LoadCase | None = None, comment: Sequence[str] = ()
) -> None:
    """Write a mesh with its sets, and with a `case` a deck that CalculiX runs as it is; see `write_model`."""
    write_model(path, mesh, element, () if case is None else _static(mesh, case), comment)


def write_model(
    path: Path, mesh: VolumeMesh, element: str, history: Iterable[str], comment: Sequence[str]
) -> None:
    """Write a mesh with its sets, and the lines that follow: material, supports, steps.

    `element` is one of `hexahedra.ELEMENTS`; each line of `comment` goes into the header. Raises
    ValueError if the element has another number of nodes than the mesh."""
    if ELEMENTS.get(element) != mesh.hexahedra.shape[1]:
        raise ValueError(f"a mesh with {mesh.hexahedra.shape[1]} nodes an element is not one of {element}")
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
    """Write numbers with commas between; a line that goes on ends with one."""
    rows = [numbers[start : start + PER_LINE] for start in range(0, len(numbers), PER_LINE)]
    return ",\n".join(", ".join(map(str, row)) for row in rows) + "\n"


def _listed(keyword: str, name: str, indices: Indices) -> str:
    return f"*{keyword}, {keyword}={identifier(name)}\n{_lines((np.unique(indices) + 1).tolist())}"


def _sets(mesh: VolumeMesh) -> Iterator[str]:
    for keyword, sets in (("NSET", mesh.node_sets), ("ELSET", mesh.element_sets)):
        yield from (_listed(keyword, name, indices) for name, indices in sets.items() if len(indices))
    for name, faces in mesh.surfaces.items():
        if len(faces):
            yield f"*SURFACE, NAME={identifier(name)}, TYPE=ELEMENT\n"
            yield from (f"{cell + 1}, S{face + 1}\n" for cell, face in np.unique(faces, axis=0).tolist())


def _static(mesh: VolumeMesh, case: LoadCase) -> Iterator[str]:
    load = case.load
    force, point, seen = (
        ", ".join(f"{x:.6g}" for x in vector)
        for vector in (load.total, load.point, mesh.points[case.observer])
    )
    yield _listed("NSET", "fixed", fixed_nodes(mesh, case))
    yield _listed("NSET", "loaded", load.nodes)
    yield f"** The displacement of the node at ({seen}) mm is printed.\n"
    yield _listed("NSET", "observer", np.array([case.observer]))
    yield f"{STEEL}*STEP\n*STATIC\n*BOUNDARY\nfixed, 1, 3\n"
    yield f"** The force ({force}) N at ({point}) mm,\n** {load.told},\n"
    yield "** as equivalent nodal forces. Stresses there are not those of the contact.\n*CLOAD\n"
    for node, components in zip(load.nodes.tolist(), load.forces.tolist(), strict=True):
        yield from (f"{node + 1}, {axis}, {value:.12g}\n" for axis, value in enumerate(components, 1))
    # Reactions of the whole first: the sets that make it up share their edges.
    for name in ("fixed", *case.fixed):
        yield f"*NODE PRINT, NSET={identifier(name)}, TOTALS=YES\nRF\n"
    yield "*NODE PRINT, NSET=observer\nU\n*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n"
