"""Speed of the solid for CAD, as ratios in one run on the same gear.

    python -m pytest tests/benchmarks/test_step_speed.py -m benchmark -s

The gear is the pinion of Table 1, 29 teeth. Faces and solid from the poles of their surfaces take
less than the kernel's own way from ready faces to a solid, sewing; all from the member to the
file takes less than four times the kernel's writing of a ready solid.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from beveloid_geom.export.step import write_step
from beveloid_geom.export.strips import gear_loops
from tests.benchmarks.timing import best
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark

PINION = table1((0.001, -0.001)).pinion


def test_common_edges_against_sewing(tmp_path: Path) -> None:
    pytest.importorskip("OCP", exc_type=ImportError)
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_Sewing
    from OCP.STEPControl import STEPControl_ManifoldSolidBrep, STEPControl_Writer

    from beveloid_geom.export._brep import quiet_kernel, solid_of

    loops = gear_loops(PINION)
    solid, named = solid_of(loops)
    apart = [BRepBuilderAPI_Copy(face).Shape() for _, face in named]

    def sew() -> None:
        sewing = BRepBuilderAPI_Sewing(1e-6)
        for face in apart:
            sewing.Add(face)
        sewing.Perform()
        assert sewing.NbFreeEdges() == 0

    def write() -> None:
        with quiet_kernel():
            writer = STEPControl_Writer()
            writer.Transfer(solid, STEPControl_ManifoldSolidBrep)
            writer.Write(str(tmp_path / "bare.step"))

    path = tmp_path / "gear.step"
    own, sewn = best(lambda: solid_of(loops), 9), best(sew, 9)
    whole, bare = best(lambda: write_step(PINION, path)), best(write)
    print(f"\nfaces and solid {own:.3f} s, sewing alone {sewn:.3f} s: {sewn / own:.1f} times as long")
    print(
        f"whole file {whole:.3f} s, the kernel's writing alone {bare:.3f} s: {whole / bare:.1f} times as long"
    )
    assert sewn > own
    assert whole < 4.0 * bare
