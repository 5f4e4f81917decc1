"""Nastran bulk data (.bdf): mesh, material, and sets of nodes in the case control.

A Nastran set has only a number. Its name follows in a comment, `$HMSET number 1 "name"`, which HyperMesh
writes and reads (1 means nodes). Coordinates are in large fields of 16 characters, with ten decimals below 10
m. Source: MSC Nastran Quick Reference Guide (GRID, CHEXA, PSOLID, MAT1, SET)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap

from ...export import identifier
from ...shapes.hexahedral_mesh import VolumeMesh
from .material import DENSITY_T_PER_MM3, POISSON_RATIO, YOUNG_MPA


def write_bulk(
    path: Path, mesh: VolumeMesh, _element: str, _case: object = None, comment: Sequence[str] = ()
) -> None:
    """Write a mesh of hexahedra with 8 or 20 nodes and its node sets, without a load.

    Parameters
    ----------
    path : Path
        File to write.
    mesh : VolumeMesh
        Hexahedra; coordinates in mm.
    comment : sequence of str
        Lines for the header.
    """
    with open(path, "w", encoding="ascii", errors="replace", newline="\n") as file:
        file.writelines(_case_control(mesh, comment))
        file.writelines(_bulk(mesh))


def _case_control(mesh: VolumeMesh, comment: Sequence[str]) -> Iterator[str]:
    for line in comment:
        yield from (f"$ {part}\n" for part in wrap(line, 70))  # Nastran reads 72 columns
    yield "SOL 101\nCEND\n"
    for number, (name, indices) in enumerate(mesh.node_sets.items(), 1):
        if not len(indices):
            continue
        nodes = (indices + 1).tolist()
        rows = (nodes[start : start + 7] for start in range(0, len(nodes), 7))
        yield f"SET {number} = " + ",\n".join(",".join(map(str, row)) for row in rows) + "\n"
        yield f'$HMSET {number:>8} {1:>8} "{identifier(name)}"\n'


def _real(value: float) -> str:
    """Return a coordinate with ten decimals, or as many as the 16 characters of a large field can hold."""
    decimals = 10
    while len(text := f"{value:.{decimals}f}") > 16 and decimals:
        decimals -= 1
    return text


def _bulk(mesh: VolumeMesh) -> Iterator[str]:
    yield "BEGIN BULK\n"
    yield f"MAT1,1,{YOUNG_MPA:.1f},,{POISSON_RATIO},{DENSITY_T_PER_MM3:.2E}\nPSOLID,1,1\n"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        yield f"GRID*   {number:>16}{'':16}{_real(x):>16}{_real(y):>16}\n*       {_real(z):>16}\n"
    # Order of an element's nodes in Nastran: the mid-side nodes between lower and upper face come before
    # those of the upper face.
    node_order = (*range(12), *range(16, 20), *range(12, 16))
    hexahedra = mesh.hexahedra[:, list(node_order[: mesh.hexahedra.shape[1]])] + 1
    for number, nodes in enumerate(hexahedra.tolist(), 1):
        fields = [f"{value:8d}" for value in (number, 1, *nodes)]
        rows = ("".join(fields[start : start + 8]) for start in range(0, len(fields), 8))
        yield "CHEXA   " + "+\n+       ".join(rows) + "\n"
    yield "ENDDATA\n"
