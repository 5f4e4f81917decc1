"""Command `beveloid-geom mesh`: files, messages and progress."""

from __future__ import annotations

import math
import os
import pty
import re
import shutil
import subprocess
import termios
from collections.abc import Callable
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import meshio
import numpy as np
import pytest
import pyvista as pv

from beveloid_geom import Design, Member, Pair, Tool, design_text, read_design, tooth_hexahedra
from beveloid_geom.cli.mesh_parts import TEETH
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export import FIXED_FRAME, GEAR_FRAME
from beveloid_geom.shapes.hexahedral_mesh import element_shapes
from tests.cli import running
from tests.symmetry import scaled

run = partial(running.run, "mesh")
installed = partial(running.installed, "mesh")
COARSE = "--tolerance", "0.05"


@pytest.fixture
def narrow(design_file: Callable[..., Path]) -> Path:
    """Return the file of a design whose pinion needs few elements."""
    return design_file({"face_width = 50.0": "face_width = 10.0"})


def test_installed_command_writes_the_pair(tmp_path: Path) -> None:
    path = tmp_path / "pair.stl"
    done = running.call("mesh", "--part", "pair", "--tolerance", "0.02", "--out", path)
    assert (done.returncode, done.stderr) == (0, "")
    assert path.read_bytes().startswith(b"beveloid-geom pair of ni-2017, mm\0")
    match = re.fullmatch(rf"{re.escape(str(path))}: ([\d,]+) triangles, ([\d,]+) points\n", done.stdout)
    assert match is not None
    assert len(meshio.read(path).cells_dict["triangle"]) == int(match[1].replace(",", ""))
    assert list(tmp_path.iterdir()) == [path]


PARTS = "pinion.STL gear.ply pair.vtp pinion-flank.obj gear-flank.vtk pinion-tooth.stl gear-tooth.vtp"


@pytest.mark.parametrize("name", PARTS.split())
def test_every_part_as_a_surface(tmp_path: Path, name: str) -> None:
    path, part = tmp_path / name, name.partition(".")[0]
    result = run("--part", part, *COARSE, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    read = pv.read(path)
    assert f"{read.n_cells:,} triangles" in result.stdout
    half = {"pinion": 25.0, "gear": 30.0}.get(part.split("-")[0])
    if half is not None:
        assert read.bounds[4:] == pytest.approx((-half, half), abs=1e-5)


@pytest.mark.parametrize("name", ["anti-backlash", "awd-transfer"])
def test_pairs_on_parallel_and_intersecting_axes(tmp_path: Path, name: str) -> None:
    result = run(name, "--part", "pair", "--tolerance", "0.2", "--out", tmp_path / "pair.vtu")
    assert result.exit_code == 0, result.output
    assert f"{pv.read(tmp_path / 'pair.vtu').n_cells:,} triangles" in result.stdout


@pytest.mark.parametrize("suffix", [".inp", ".msh", ".bdf", ".vtu"])
def test_a_tooth_as_hexahedra(tmp_path: Path, narrow: Path, suffix: str) -> None:
    path = tmp_path / f"tooth{suffix}"
    result = run(narrow, "--part", "pinion-tooth", *COARSE, "--element", "C3D8I", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    count = sum(len(cells.data) for cells in meshio.read(path).cells if cells.type == "hexahedron")
    assert f"{count:,} hexahedra C3D8I" in result.stdout


def test_line_contact_is_on_a_strip(tmp_path: Path) -> None:
    """The outputs for a tooth and for the pair name the same shape of the contact."""
    tool = Tool(2.0, math.radians(20.0))
    pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.2, 8.0) for teeth in (20, 40))
    pair = tmp_path / "pair.toml"
    pair.write_text(design_text(Design(pinion, gear, Pair(60.9, 0.0))), encoding="utf-8")
    tooth = run(pair, "--part", "pinion-tooth", "--load", "200", "--out", tmp_path / "t.inp")
    assert "Hertz's pressure on a strip of 8 by " in tooth.stdout, tooth.stderr
    both = run(pair, "--part", "pair", "--teeth", "3", "--across", "1", "--out", tmp_path / "p.inp")
    assert re.search(r"1 across and \S+ along the strip of 2222 N", both.stdout), both.stderr


def test_the_pair_in_contact_over_a_pitch(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    """One deck for each roll about the middle of the path. The torque is that of a normal force of 20 kN."""
    narrow = design_file({f"face_width = {width}.0": "face_width = 12.0" for width in (50, 60)})
    result = run(narrow, "--part", "pair", "--rolls", "2", "--out", tmp_path / "p.inp")
    assert (result.exit_code, result.stderr) == (0, "")
    first, second = result.stdout.splitlines()
    rolls = []
    for line, name in ((first, "p-1.inp"), (second, "p-2.inp")):
        match = re.match(r"(\S+): [\d,]+ hexahedra C3D20, [\d,]+ nodes; (\S+) N m on the pinion at", line)
        assert match is not None
        assert match[1] == str(tmp_path / name)
        assert float(match[2]) == pytest.approx(20.0 * 3.0 * 29 * np.cos(np.radians(20.0)), rel=1e-5)
        rolls.append(float(line.split("at a roll of ")[1].split()[0]))
        assert ", right flanks; elements: 4 across and 6 along the ellipse of 2e+04 N; " in line
        assert line.endswith(f" && ccx -i {name[:-4]}")
        text = (tmp_path / name).read_text(encoding="ascii")
        assert f"at a roll of {rolls[-1]:.4f} deg" in text
        assert text.count("*CONTACT PAIR") == 3
        assert '"decks": 2' in text
    assert rolls[1] - rolls[0] == pytest.approx(0.5 * 360.0 / 29.0, abs=2e-4)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p-1.inp", "p-2.inp", "pair.toml"]


def test_the_memory_of_the_solver_is_printed_for_large_decks(tmp_path: Path) -> None:
    lines = [
        run("--part", "pair", "--teeth", "1", "--across", across, "--out", tmp_path / "a.inp").stdout
        for across in ("0.2", "4")
    ]
    assert "of memory" not in lines[0]
    nodes = int(re.search(r"([\d,]+) nodes", lines[1])[1].replace(",", ""))  # type: ignore[index]
    size = float(re.search(r"; CalculiX takes about ([\d.]+) GB of memory; run: ", lines[1])[1])  # type: ignore[index]
    assert size == pytest.approx(1.2 * (nodes / 36_729) ** (4.0 / 3.0), rel=0.1)  # measured: 1.2 GB


def test_the_scaled_jacobian_is_a_lower_bound(tmp_path: Path, narrow: Path) -> None:
    for tolerance in (0.05, 0.3, 1.0):
        shape = element_shapes(tooth_hexahedra(read_design(narrow).pinion, 1, "C3D8", tolerance))[0].min()
        options = "--element", "C3D8", "--tolerance", str(tolerance), "--out", tmp_path / "a.msh"
        line = run(narrow, "--part", "pinion-tooth", *options).stdout
        printed = float(line.split("scaled Jacobian ")[1].split()[0])
        assert printed <= shape < printed + 0.01


def test_defaults_scale_with_the_module(tmp_path: Path, narrow: Path) -> None:
    """Similar pairs have the same mesh and the same stresses. At 6 mm the tolerances are 0.01 and 0.05 mm and
    the load is 1000 N. Lengths scale with the module, the load with its square."""
    small, messages = tmp_path / "small.toml", []
    small.write_text(design_text(scaled(read_design(narrow), 0.25)), encoding="utf-8")
    for part, suffix in (("gear-flank", ".ply"), ("pinion-tooth", ".inp")):
        for source in (small, narrow):
            result = run(source, "--part", part, "--out", tmp_path / f"a{suffix}")
            assert (result.exit_code, result.stderr) == (0, ""), result.stderr
            messages.append(result.stdout.split(": ", 1)[1])
    assert messages[0] == messages[1]
    assert messages[2].split(";")[0] == messages[3].split(";")[0]
    assert "; 62.5 N on the right flank" in messages[2]
    assert "1000 N on" in messages[3]
    assert "edges within 0.05 mm" in (tmp_path / "a.inp").read_text(encoding="ascii")
    defaults = "module / 600 (0.01 mm at module 6 mm); .glb: module / 200 (0.03 mm); hexahedra: module / 120"
    assert defaults in running.words_of("mesh", "--help")


@pytest.mark.parametrize("suffix", [".stl", ".inp"])
def test_all_teeth_are_the_complete_gear(tmp_path: Path, narrow: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    options = "--teeth", "29", "--tolerance", "0.5", *(["--element", "C3D8"] if suffix == ".inp" else [])
    result = run(narrow, "--part", "pinion-tooth", *options, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "use --teeth 3" not in result.stdout
    if suffix == ".stl":
        run(narrow, "--part", "pinion", "--tolerance", "0.5", "--out", tmp_path / "b.stl")
        assert path.read_bytes()[80:] == (tmp_path / "b.stl").read_bytes()[80:]
        return
    assert "tooth 15 of 29" in result.stdout
    assert "SIDE" not in path.read_text(encoding="ascii").upper()
    points = meshio.read(path).points
    assert len(np.unique(np.round(points, 6), axis=0)) == len(points)


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("ccx"), reason="CalculiX is not installed: apt-get install calculix-ccx")
@pytest.mark.parametrize("name", ["a b.inp", "A.INP", "sub/c.inp", "sub/D.Inp"])
def test_the_printed_command_runs(tmp_path: Path, narrow: Path, name: str) -> None:
    (tmp_path / "sub").mkdir()
    options = "--part", "pinion-tooth", "--tolerance", "0.5", "--element", "C3D8", "--out", name
    done = subprocess.run(
        installed(narrow, *options), capture_output=True, text=True, check=True, cwd=tmp_path, timeout=120
    )
    command = done.stdout.rstrip("\n").rpartition("; run: ")[2]
    ran = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert ran.returncode == 0, ran.stdout[-500:]
    assert "ERROR" not in ran.stdout
    [results] = (tmp_path / name).parent.glob("*.dat")  # CalculiX writes a.dat for 'a b'
    assert "total force" in results.read_text()


def test_options_of_a_loaded_tooth(tmp_path: Path, narrow: Path) -> None:
    path = tmp_path / "three.inp"
    options = "--teeth", "3", "--element", "C3D8", "--load", "250", "--bore-radius", "70", "--flank", "left"
    result = run(narrow, "--part", "pinion-tooth", *COARSE, *options, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "250 N on the left flank of tooth 2 of 3 at (" in result.stdout
    assert ", Hertz's pressure on an ellipse of " in result.stdout
    assert "; stresses at the contact are not resolved, those of the fillet are; run: " in result.stdout
    assert re.search(r" nodes, scaled Jacobian 0\.[4-9]\d or more; ", result.stdout)
    assert result.stdout.endswith(f"run: cd {tmp_path} && ccx -i three\n")
    text = path.read_text(encoding="ascii")
    assert "*ELEMENT, TYPE=C3D8, ELSET=body" in text
    loads = re.search(r"^\*CLOAD\n((?:\d.*\n)+)", text, re.MULTILINE)
    assert loads is not None
    force = np.zeros(3)
    for line in loads[1].splitlines():
        _, axis, value = line.split(",")
        force[int(axis) - 1] += float(value)
    assert np.linalg.norm(force) == pytest.approx(250.0, rel=1e-10)
    assert force[1] > 0.0  # into the metal from the left flank
    read = meshio.read(path)
    assert np.hypot(*read.points[read.point_sets["bore"], :2].T) == pytest.approx(70.0, abs=1e-9)
    loaded = read.points[read.point_sets["loaded"]].mean(axis=0)
    assert np.arctan2(loaded[1], loaded[0]) == pytest.approx(2.0 * np.pi / 29.0, abs=0.1)  # the middle tooth


def test_the_message_of_a_single_tooth_mentions_its_cut_sides(tmp_path: Path, narrow: Path) -> None:
    path = tmp_path / "a b.inp"
    result = run(narrow, "--part", "pinion-tooth", *COARSE, "--out", path)
    note = "; held at its cut sides: use --teeth 3 for stresses; run: "
    assert result.stdout.endswith(f"{note}cd {tmp_path} && ccx -i 'a b'\n")
    text = path.read_text(encoding="ascii")
    assert "** The loaded tooth is held at its cut sides: use --teeth 3 for stresses.\n" in text
    assert ", 1 tooth, " in text
    assert "*ELEMENT, TYPE=C3D20, " in text
    assert "use 3 for stresses" in running.words_of("mesh", "--help")
    assert "** stresses at the contact are not resolved, those of the fillet are.\n" in text


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    link, target = tmp_path / "a.stl", tmp_path / "far" / "b.stl"
    target.write_text("old")
    link.symlink_to(target)
    assert run("--part", "pinion-flank", *COARSE, "--out", link).exit_code == 0
    assert link.is_symlink()
    assert target.stat().st_size > 1000
    assert sorted(tmp_path.rglob("*")) == [link, tmp_path / "far", target]


@pytest.mark.parametrize("part", ["gear-tooth", "pair"])
def test_fields_of_numbers_are_explained(tmp_path: Path, part: str) -> None:
    result = run("--part", part, *COARSE, "--out", tmp_path / "a.vtp")
    assert "; part: 0 right flank, 1 left flank, 2 right fillet, " in result.stdout
    assert result.stdout.endswith(", 8 bore, 9 first side, 10 last side\n")


def test_flank_with_fields(tmp_path: Path) -> None:
    path = tmp_path / "flank.vtp"
    fields = "--field", "separation", "--field", "pattern", "--field", "separation"
    result = run("--part", "gear-flank", "--flank", "left", *COARSE, *fields, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert set(pv.read(path).point_data) == {"normals", "separation", "pattern"}


def test_options_change_the_design(tmp_path: Path) -> None:
    first, second = tmp_path / "a.vtk", tmp_path / "b.vtk"
    run("--part", "pinion-flank", *COARSE, "--out", first)
    run("--part", "pinion-flank", *COARSE, "--parabola-pinion", "-0.002", "--out", second)
    flat, convex = (pv.read(path) for path in (first, second))
    assert 1.0 < abs(flat.area - convex.area) < 50.0
    run("--part", "pair", *COARSE, "--out", first)
    run("--part", "pair", *COARSE, "--gear-axial-error", "0.5", "--flank", "left", "--out", second)
    moved = pv.read(second).points[-1] - pv.read(first).points[-1]
    assert np.linalg.norm(moved) > 0.1


@pytest.mark.parametrize(
    ("options", "given"),
    [
        ("--part gear", (45, None, None, "gear", False)),
        ("--part gear --placed", (45, None, None, "gear", True)),
        ("--part pinion-tooth --teeth 3 --bore-radius 50", (29, [0, 1, 2], 50.0, "pinion", False)),
    ],
)
def test_a_solid_for_cad(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: str, given: tuple[object, ...]
) -> None:
    """The command passes the right arguments to `write_step`. The files are tested in
    tests/export/test_step.py."""
    write = Mock(side_effect=lambda _, path, *__: path.write_text("ISO-10303-21;"))
    monkeypatch.setattr("beveloid_geom.export.step.write_step", write)
    path = tmp_path / "a.step"
    result = run(*options.split(), "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    member, _, teeth, bore_radius, name, frame = write.call_args.args
    numbers = None if teeth is None else list(teeth)
    assert (member.teeth, numbers, bore_radius, name, frame is not None) == given
    assert path.read_text() == "ISO-10303-21;"
    assert result.stdout == f"{path}: a solid with {given[0] if numbers is None else 3} teeth\n"


def test_the_pair_as_an_assembly_and_as_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = Mock(side_effect=lambda _, path, *__: path.write_text("ISO-10303-21;"))
    monkeypatch.setattr("beveloid_geom.export.step.write_step_pair", write)
    path = tmp_path / "a.step"
    result = run("--part", "pair", "--out", path)
    assert (result.exit_code, result.stdout) == (0, f"{path}: an assembly of pinion and gear\n")
    heights = [origin[2] for _, origin in write.call_args.args[2]]
    assert heights == pytest.approx([211.594669224, 203.049073436])
    path = tmp_path / "a.glb"
    result = run("--part", "pair", *COARSE, "--out", path)
    assert result.exit_code == 0
    assert "in m, y up: pinion, path of contact on pinion, pattern on pinion, gear," in result.stdout
    assert path.read_bytes().startswith(b"glTF")


def test_printed_frames_are_those_of_placed_parts(tmp_path: Path) -> None:
    """The printed matrices transform a part to its position with --placed."""
    local, placed = tmp_path / "local.vtu", tmp_path / "placed.vtu"
    run("--part", "gear-flank", *COARSE, "--out", local)
    for options, frame in (((), GEAR_FRAME), (("--placed",), FIXED_FRAME)):
        run("--part", "pinion-tooth", *options, "--element", "C3D8", *COARSE, "--out", tmp_path / "a.bdf")
        written = (tmp_path / "a.bdf").read_text(encoding="ascii").replace("\n$ ", " ")
        assert frame in written
    both = run("--part", "gear-flank", *COARSE, "--placed", "--frames", "--out", placed)
    alone = run("--frames")
    assert (alone.exit_code, both.stdout) == (0, alone.stdout + both.stdout.splitlines()[-1] + "\n")
    rows = [line.split() for line in alone.stdout.splitlines()[6:]]
    assert alone.stdout.splitlines()[5] == "gear, from its own frame to S_f, mm:"
    matrix = np.array(rows, dtype=float)
    points = pv.read(local).points @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(pv.read(placed).points, points, rtol=0, atol=1e-11)


def test_placed_teeth_of_pinion_and_gear_are_in_mesh(tmp_path: Path, narrow: Path) -> None:
    """Placed teeth of both members are loaded at the contact, and additional teeth are on the same side of
    the contact on both members."""
    contact, middles = meshing_pair(read_design(narrow)).contact, {}
    for part in TEETH:
        for teeth in (1, 2, 3):
            options = "--part", part, "--teeth", str(teeth), "--placed", "--element", "C3D8"
            result = run(narrow, *options, "--tolerance", "0.5", "--out", tmp_path / "a.inp")
            point = result.stdout.split(" at (")[1].split(") mm")[0].split(",")
            np.testing.assert_allclose(np.array(point, dtype=float), contact, atol=0.05)
            middles[part, teeth] = meshio.read(tmp_path / "a.inp").points.mean(axis=0)
    pinion, gear = ([middles[part, k] - middles[part, 1] for k in (2, 3)] for part in TEETH)
    assert pinion[0] @ gear[0] > 0.9 * np.linalg.norm(pinion[0]) * np.linalg.norm(gear[0]) > 1.0
    assert max(np.linalg.norm(pinion[1]), np.linalg.norm(gear[1])) < 2.0  # one tooth more on each side


def test_progress_is_shown_on_terminals(tmp_path: Path) -> None:
    terminal, side = pty.openpty()
    termios.tcsetwinsize(side, (24, 100))
    os.set_blocking(terminal, False)  # reading without data fails instead of waiting
    done = subprocess.run(
        installed("--part", "pinion-tooth", *COARSE, "--out", tmp_path / "a.ply"),
        stdout=subprocess.PIPE,
        stderr=side,
        text=True,
        check=True,
    )
    shown = os.read(terminal, 65536).decode()
    os.close(side)
    os.close(terminal)
    assert "pinion" in shown
    assert "write a.ply" in shown
    assert done.stdout.count("\n") == 1


def test_a_pair_that_jams_has_a_warning(tmp_path: Path) -> None:
    """The pair is written; the warning is that of the other commands."""
    out = tmp_path / "pair.stl"
    result = run("--part", "pair", "--offset-error", "-0.5", "--tolerance", "0.5", "--out", out)
    assert result.exit_code == 0
    assert result.stderr.startswith("Warning: the pair cannot be assembled: ")
    assert out.exists()
