"""Speed of closed solids, as ratios in one run.

    python -m pytest tests/benchmarks -m benchmark -s

The references are the least that the same points can cost: the exact formulas of flank, fillet
and lands at all points of the outlines of all teeth, and the solid of one tooth (the others
are copies of it).
"""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import gear_solid
from beveloid_geom.shapes.outline import cut_sheets, outline_grids
from beveloid_geom.shapes.surface_mesh import gear_mesh
from tests.benchmarks.timing import best
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("tolerance", [0.01, 0.001])
def test_whole_gear_against_its_exact_points(tolerance: float) -> None:
    member = table1().pinion
    sheets = cut_sheets(member)
    grids = outline_grids(sheets, tolerance)

    def exact_points() -> None:
        for name, grid in grids.items():
            z = np.broadcast_to(grid.z, grid.parameter.shape)
            for _ in range(int(member.teeth)):
                sheets[name].place(grid.parameter, z)

    rows = {
        "exact formulas at the outlines' points": best(exact_points, 5),
        "solid of one tooth": best(lambda: gear_solid(member, tolerance, 1), 5),
        "solid of 29 teeth": best(lambda: gear_solid(member, tolerance), 5),
        "29 teeth to look at": best(lambda: gear_mesh(member, tolerance), 5),
    }
    points = len(gear_solid(member, tolerance).points)
    print(f"\n{tolerance:g} mm, {points:,} points")
    for name, seconds in rows.items():
        print(f"  {name:40s} {1e3 * seconds:9.2f} ms {1e6 * seconds / points:8.3f} us a point of the solid")
    exact, one, whole, _ = rows.values()
    print(f"  solid to exact formulas {whole / exact:.2f}, 29 teeth to one {whole / one:.2f}")
    assert whole < 12.0 * exact
    assert whole < 4.0 * one
