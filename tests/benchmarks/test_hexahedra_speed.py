"""Speed of the section and of hexahedra, as ratios in one run.

    python -m pytest tests/benchmarks/test_hexahedra_speed.py -m benchmark -s

Two references: Winslow's equations iterated at every station by itself, in place of three with a
blend; and hexahedra of half the nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest

from beveloid_geom import tooth_hexahedra
from beveloid_geom.shapes.hexahedra import Cells
from beveloid_geom.shapes.section import section_of
from tests.benchmarks.timing import told
from tests.oracle.table1 import table1
from tests.shapes.test_section import outline_of

pytestmark = pytest.mark.benchmark
PINION = table1().pinion


def test_three_stations_serve_all() -> None:
    outline = outline_of(PINION, 2, 10, 16, 12, nz=101)
    singles = [{name: curve[:, i : i + 1] for name, curve in outline.items()} for i in range(101)]
    nodes = section_of(outline, 60.0).points.size // 3
    works: dict[str, tuple[Callable[[], object], int, int]] = {
        "101 stations together": (lambda: section_of(outline, 60.0), 3, nodes),
        "each by itself": (lambda: [section_of(single, 60.0) for single in singles], 1, nodes),
    }
    together, apart = told("nodes of a section", works).values()
    assert apart > 5.0 * together


def test_cost_grows_with_the_nodes() -> None:
    works = {}
    for face in (50, 100):
        work = partial(tooth_hexahedra, PINION, cells=Cells(bottom=1, fillet=8, flank=12, tip=10, face=face))
        works[f"face of {face} elements"] = (work, 3, len(work().points))
    short, long = told("nodes with C3D20", works).values()
    assert long < 1.5 * short
