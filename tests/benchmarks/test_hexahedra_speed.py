"""Speed of the section and of hexahedra, as ratios in one run.

    python -m pytest tests/benchmarks/test_hexahedra_speed.py -m benchmark -s

Two references: Winslow's equations iterated at every station by itself, in place of three with a
blend; and hexahedra of half the nodes.
"""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.hexahedra import Cells
from beveloid_geom.shapes.outline import cut_sheets
from beveloid_geom.shapes.sampling import grid_of
from beveloid_geom.shapes.section import section_of
from tests.benchmarks.timing import best
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark
PINION = table1().pinion


def outline_of(nz: int) -> dict[str, FloatArray]:
    cells = {"bottom": 2, "fillet": 10, "flank": 16, "tip": 12}
    z, curves = np.linspace(-25.0, 25.0, nz), {}
    for name, sheet in cut_sheets(PINION).items():
        points = grid_of(sheet, np.linspace(0.0, 1.0, cells[name.split()[-1]] + 1), z).points
        curves[name] = points[::-1] if name.startswith("right") else points
    return curves


def test_three_stations_serve_all() -> None:
    outline = outline_of(101)
    singles = [{name: curve[:, i : i + 1] for name, curve in outline.items()} for i in range(101)]
    together = best(lambda: section_of(outline, 60.0))
    apart = best(lambda: [section_of(single, 60.0) for single in singles], 1)
    nodes = section_of(outline, 60.0).points.size // 3
    print(f"\n  101 stations together {1e3 * together:8.1f} ms, {1e6 * together / nodes:.2f} us a node")
    print(f"  each by itself        {1e3 * apart:8.1f} ms: {apart / together:.1f} times as long")
    assert apart > 5.0 * together


def test_cost_grows_with_the_nodes() -> None:
    rows = []
    for face in (50, 100):
        cells = Cells(bottom=1, fillet=8, flank=12, tip=10, face=face)
        nodes = len(tooth_hexahedra(PINION, cells=cells).points)
        rows.append((nodes, best(lambda cells=cells: tooth_hexahedra(PINION, cells=cells))))  # type: ignore[misc]
    print()
    for nodes, seconds in rows:
        print(f"  {nodes:7,} nodes with C3D20 {1e3 * seconds:8.1f} ms, {1e6 * seconds / nodes:.2f} us a node")
    assert rows[1][1] / rows[0][1] < 1.5 * rows[1][0] / rows[0][0]
