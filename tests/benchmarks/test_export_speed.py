"""Speed and memory of exports, as ratios in one run on the same work.

    OPENBLAS_NUM_THREADS=1 python -m pytest tests/benchmarks/test_export_speed.py -m benchmark -s

The pair as .stl is compared with the start of an interpreter that imports numpy and trimesh, which every
program needs that writes an STL file with trimesh. Our writers are compared with those of the most similar
library: VTK for .vtp, which compresses; meshio for .inp and .bdf, which leaves out surfaces and load. The
Nastran writer of meshio accepts no negative coordinates with twelve digits, so that it gets rounded
coordinates.

The solid for CAD is the pinion of Table 1 with 29 teeth. Making faces and solid from the control points
of the surfaces takes less time than sewing ready faces by the kernel (Open CASCADE). The complete way
from the member to the file takes less than four times as long as the writing of a ready solid by the
kernel."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista as pv

from beveloid_geom import tooth_hexahedra
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export import parts
from beveloid_geom.export.fea.volumes import write_volume
from beveloid_geom.export.step import write_step
from beveloid_geom.export.strips import gear_loops
from beveloid_geom.export.surfaces import write_surface
from tests.benchmarks.timing import best, timed
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark


MEMORY = 500.0
"""MB that the command may take for the pair at 0.01 mm."""


def process(*arguments: str) -> tuple[float, float]:
    """Wall time (s) and peak memory (MB) of an interpreter."""
    start = time.perf_counter()
    child = subprocess.Popen([sys.executable, *arguments], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0
    return time.perf_counter() - start, usage.ru_maxrss / 1024.0


def test_the_pair_against_the_start_of_the_library(tmp_path: Path) -> None:
    command = "from beveloid_geom.cli.main import main; main()"
    given = "mesh", "--part", "pair", "--tolerance", "0.01", "--out", str(tmp_path / "pair.stl")
    whole = [process("-c", command, *given) for _ in range(5)]
    start = [process("-c", "import numpy, trimesh") for _ in range(5)]
    seconds, least = min(time for time, _ in whole), min(time for time, _ in start)
    memory = max(size for _, size in whole)
    print(f"\npair.stl at 0.01 mm    {seconds:.2f} s  {memory:.0f} MB")
    print(f"numpy, trimesh alone   {least:.2f} s")
    print(f"ratio                  {seconds / least:.2f}")
    assert seconds < 4.0 * least
    assert memory < MEMORY


def test_own_writers_against_those_of_libraries(tmp_path: Path) -> None:
    design = table1()
    surface = parts.gear_surface(design.pinion, ".vtp", 0.005)
    poly = pv.PolyData.from_regular_faces(surface.points, surface.faces.astype(int))
    poly.point_data["normals"] = surface.point_fields["normals"]
    poly.cell_data["part"] = surface.cell_fields["part"]
    vtp, other = tmp_path / "a.vtp", tmp_path / "b.vtp"
    works = {"own": (lambda: write_surface(surface, vtp), 5, 1), "VTK's": (lambda: poly.save(other), 5, 1)}
    ours, theirs = timed("vtp", works).values()
    assert ours < theirs
    mesh = tooth_hexahedra(design.pinion, 1, "C3D20R", 0.02)
    case = parts.contact_case(mesh, design, meshing_pair(design), 0, 1000.0)
    rounded = replace(mesh, points=np.round(mesh.points, 7))
    plain = meshio.Mesh(rounded.points, [("hexahedron20", mesh.hexahedra)])
    for suffix, kind in ((".inp", "abaqus"), (".bdf", "nastran")):
        own = partial(write_volume, mesh, tmp_path / f"a{suffix}", "C3D20R", case=case)
        meshios = partial(plain.write, tmp_path / f"b{suffix}", file_format=kind)
        ours, theirs = timed(suffix[1:], {"own": (own, 3, 1), "meshio's": (meshios, 3, 1)}).values()
        assert ours < 1.5 * theirs


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
