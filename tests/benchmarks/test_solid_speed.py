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
from tests.benchmarks.timing import told
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

    points = len(gear_solid(member, tolerance).points)
    works = {
        "exact formulas at the outlines' points": (exact_points, 5, points),
        "solid of one tooth": (lambda: gear_solid(member, tolerance, 1), 5, points),
        "solid of 29 teeth": (lambda: gear_solid(member, tolerance), 5, points),
        "29 teeth to look at": (lambda: gear_mesh(member, tolerance), 5, points),
    }
    exact, one, whole, _ = told(f"{tolerance:g} mm, times over the points of the solid", works).values()
    assert whole < 12.0 * exact
    assert whole < 4.0 * one
