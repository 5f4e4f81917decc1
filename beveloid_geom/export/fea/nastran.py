"""Nastran bulk data (.bdf): mesh, material, and the sets of nodes in the case control.

A set of Nastran's has a number only. Its name stands after it in a comment, `$HMSET number 1 "name"`, as
HyperMesh writes and reads it (1: nodes). Coordinates have ten decimals, in large fields. Source: MSC
Nastran Quick Reference Guide (GRID, CHEXA, PSOLID, MAT1, SET).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap

from ...export import identifier
from ...shapes.elements import VolumeMesh
from .material import DENSITY, POISSON, YOUNG

ORDER = (*range(12), *range(16, 20), *range(12, 16))
"""Nastran's nodes of an element: the mid-side nodes between lower and upper face come before
those of the upper one."""
SET_LINE = 7
NODES = 1
"""The kind of a set in its comment."""
COLUMNS = 72
"""Of a line that Nastran reads."""
LARGEST = 1e4
"""Coordinates (mm) from here on no longer leave room for ten decimals in 16 characters."""


def write_bulk(
    path: Path, mesh: VolumeMesh, _element: str, _case: object = None, comment: Sequence[str] = ()
) -> None:
    """Write a mesh of hexahedra with 8 or 20 nodes and its node sets, without its element's name and load.
    Each line of `comment` goes into the header."""
    with open(path, "w", encoding="ascii", errors="replace", newline="\n") as file:
        file.writelines(_control(mesh, comment))
        file.writelines(_bulk(mesh))


def _control(mesh: VolumeMesh, comment: Sequence[str]) -> Iterator[str]:
    for line in comment:
        yield from (f"$ {part}\n" for part in wrap(line, COLUMNS - 2))
    yield "SOL 101\nCEND\n"
    for number, (name, indices) in enumerate(mesh.node_sets.items(), 1):
        if not len(indices):
            continue
        nodes = (indices + 1).tolist()
        rows = (nodes[start : start + SET_LINE] for start in range(0, len(nodes), SET_LINE))
        yield f"SET {number} = " + ",\n".join(",".join(map(str, row)) for row in rows) + "\n"
        yield f'$HMSET {number:>8} {NODES:>8} "{identifier(name)}"\n'


def _real(value: float) -> str:
    return f"{value:.10f}" if abs(value) < LARGEST else f"{value:.8E}"


def _bulk(mesh: VolumeMesh) -> Iterator[str]:
    yield "BEGIN BULK\n"
    yield f"MAT1,1,{YOUNG:.1f},,{POISSON},{DENSITY:.2E}\nPSOLID,1,1\n"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        yield f"GRID*   {number:>16}{'':16}{_real(x):>16}{_real(y):>16}\n*       {_real(z):>16}\n"
    hexahedra = mesh.hexahedra[:, list(ORDER[: mesh.hexahedra.shape[1]])] + 1
    for number, nodes in enumerate(hexahedra.tolist(), 1):
        fields = [f"{value:8d}" for value in (number, 1, *nodes)]
        rows = ("".join(fields[start : start + 8]) for start in range(0, len(fields), 8))
        yield "CHEXA   " + "+\n+       ".join(rows) + "\n"
    yield "ENDDATA\n"
