"""Speed of sampled flanks, closed solids and hexahedra, as ratios in one run.

    OPENBLAS_NUM_THREADS=1 python -m pytest tests/benchmarks/test_shapes_speed.py -m benchmark -s

A call of `sample_flank` computes limits of the flank, its shape, the number of cells, the distance of the
triangles from the flank, points and normals. The reference is the exact formula for points and normals
alone, at the same flank parameters and stations. The reference for solids is the smallest possible work
for the same points: the exact formulas at all points of the outlines of all teeth, and the solid of one
tooth (the others are copies). The references for hexahedra are an iteration of Winslow's equations at
every station, instead of three stations with interpolation; and hexahedra with half the nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from beveloid_geom import gear_solid, sample_flank, tooth_hexahedra
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_geom.shapes.sampling import flank_sheet
from beveloid_geom.shapes.section import section_of
from beveloid_geom.shapes.surface_mesh import gear_mesh
from beveloid_geom.shapes.tooth_boundary import cut_sheets, outline_grids
from tests.benchmarks.timing import timed
from tests.oracle.table1 import table1
from tests.shapes.test_section import outline_of

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [0.0, 0.001, -0.01])
def test_sampling_against_the_exact_formula(parabola: float) -> None:
    pinion = table1().pinion
    pinion = replace(pinion, tool=replace(pinion.tool, parabola=parabola))
    place = flank_sheet(pinion, "right").place
    ratios = {}
    for name, tolerance, repeat in (("1e5 points", 3e-6, 20), ("1e6 points", 3e-7, 7)):
        grid = sample_flank(pinion, "right", tolerance)
        l, z = grid.l, np.ascontiguousarray(np.broadcast_to(grid.z, grid.l.shape))
        found = timed(
            f"a = {parabola}, {tolerance:g} mm",
            {
                "sampled": (partial(sample_flank, pinion, "right", tolerance), repeat, l.size),
                "exact formula": (partial(place, l, z), repeat, l.size),
            },
        )
        ratios[name] = found["exact formula"] / found["sampled"]
    assert ratios["1e5 points"] > 1.0
    assert ratios["1e6 points"] > 3.0


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
    exact, one, whole, _ = timed(f"{tolerance:g} mm, times over the points of the solid", works).values()
    assert whole < 12.0 * exact
    assert whole < 4.0 * one


PINION = table1().pinion


def test_three_stations_are_sufficient() -> None:
    outline = outline_of(PINION, 2, 10, 16, 12, nz=101)
    singles = [{name: curve[:, i : i + 1] for name, curve in outline.items()} for i in range(101)]
    nodes = section_of(outline, 60.0).points.size // 3
    works: dict[str, tuple[Callable[[], object], int, int]] = {
        "101 stations together": (lambda: section_of(outline, 60.0), 3, nodes),
        "each by itself": (lambda: [section_of(single, 60.0) for single in singles], 1, nodes),
    }
    together, apart = timed("nodes of a section", works).values()
    assert apart > 5.0 * together


def test_cost_grows_with_the_nodes() -> None:
    works = {}
    for face in (50, 100):
        work = partial(tooth_hexahedra, PINION, cells=Cells(bottom=1, fillet=8, flank=12, tip=10, face=face))
        works[f"face of {face} elements"] = (work, 3, len(work().points))
    short, long = timed("nodes with C3D20", works).values()
    assert long < 1.5 * short
