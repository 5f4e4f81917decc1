"""The command `beveloid-geom mesh`: its files, what it says of them, and its progress."""

from __future__ import annotations

import os
import pty
import re
import shutil
import subprocess
import termios
from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista as pv
from click.testing import Result

from beveloid_geom import Design, Member
from beveloid_geom.contact.placing import Frame
from beveloid_geom.design.file import builtin_text
from beveloid_geom.export import FIXED_FRAME, OWN_FRAME
from tests.cli import running


def run(*arguments: str | Path) -> Result:
    return running.run("mesh", *arguments)


def installed(*arguments: str | Path) -> list[str]:
    return running.installed("mesh", *arguments)


COARSE = "--tolerance", "0.05"
NARROW = builtin_text().replace("face_width = 50.0", "face_width = 10.0")


@pytest.fixture
def narrow(tmp_path: Path) -> Path:
    """A design whose pinion takes few elements."""
    path = tmp_path / "narrow.toml"
    path.write_text(NARROW, encoding="utf-8")
    return path


# What it writes


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


@pytest.mark.parametrize("suffix", [".inp", ".msh", ".bdf", ".vtu"])
def test_a_tooth_as_hexahedra(tmp_path: Path, narrow: Path, suffix: str) -> None:
    path = tmp_path / f"tooth{suffix}"
    result = run(narrow, "--part", "pinion-tooth", *COARSE, "--element", "C3D8I", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    count = sum(len(cells.data) for cells in meshio.read(path).cells if cells.type == "hexahedron")
    assert f"{count:,} hexahedra C3D8I" in result.stdout


def test_the_pair_in_contact_over_a_pitch(tmp_path: Path) -> None:
    """A deck for each roll, about the middle of the path, with the torque for 20 kN."""
    (tmp_path / "narrow.toml").write_text(builtin_text().replace("face_width = 50.0", "face_width = 12.0"))
    result = run(tmp_path / "narrow.toml", "--part", "pair", "--rolls", "2", "--out", tmp_path / "p.inp")
    assert (result.exit_code, result.stderr) == (0, "")
    first, second = result.stdout.splitlines()
    rolls = []
    for line, name in ((first, "p-1.inp"), (second, "p-2.inp")):
        match = re.match(r"(\S+): [\d,]+ hexahedra C3D20, [\d,]+ nodes; (\S+) N m on the pinion at", line)
        assert match is not None
        assert match[1] == str(tmp_path / name)
        assert float(match[2]) == pytest.approx(20.0 * 3.0 * 29 * np.cos(np.radians(20.0)), rel=1e-5)
        rolls.append(float(line.split("at a roll of ")[1].split()[0]))
        assert ", right flanks; 4 elements across the ellipse of contact of 2e+04 N; run: cd" in line
        assert line.endswith(f" && ccx -i {name[:-4]}")
        text = (tmp_path / name).read_text(encoding="ascii")
        assert f"at a roll of {rolls[-1]:.4f} deg" in text
        assert text.count("*CONTACT PAIR") == 3
        assert '"decks": 2' in text
    assert rolls[1] - rolls[0] == pytest.approx(0.5 * 360.0 / 29.0, abs=2e-4)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["narrow.toml", "p-1.inp", "p-2.inp"]


@pytest.mark.parametrize("module", [6.0, 1.5])
def test_defaults_go_with_the_module(tmp_path: Path, module: float) -> None:
    """At 6 mm 0.01 and 0.05 mm and 1000 N, lengths with the module, the load with its square: the same mesh
    and stresses for a pair of another size."""
    scale = module / 6.0
    keys = "normal_module", "face_width", "offset"
    lines = [line.partition(" = ") for line in NARROW.splitlines()]
    scaled = [
        f"{key} = {float(rest.split('#')[0]) * scale!r}" if key in keys else key + middle + rest
        for key, middle, rest in lines
    ]
    (tmp_path / "own.toml").write_text("\n".join(scaled))
    told = []
    for part, suffix in (("gear-flank", ".ply"), ("pinion-tooth", ".inp")):
        for source in ("own.toml", "narrow.toml"):
            (tmp_path / "narrow.toml").write_text(NARROW)
            result = run(tmp_path / source, "--part", part, "--out", tmp_path / f"a{suffix}")
            assert (result.exit_code, result.stderr) == (0, ""), result.stderr
            told.append(result.stdout.split(": ", 1)[1])
    assert told[0] == told[1]
    assert told[2].split(";")[0] == told[3].split(";")[0]
    assert f"; {1000 * scale**2:g} N on the right flank" in told[2]
    assert "1000 N on" in told[3]
    text = (tmp_path / "a.inp").read_text(encoding="ascii")
    assert "edges within 0.05 mm" in text
    assert "module / 600, to look at module / 200, hexahedra module / 120" in " ".join(
        run("--help").stdout.split()
    )


@pytest.mark.parametrize("suffix", [".stl", ".inp"])
def test_all_teeth_are_the_whole_gear(tmp_path: Path, narrow: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    options = "--teeth", "29", "--tolerance", "0.5", *(["--element", "C3D8"] if suffix == ".inp" else [])
    result = run(narrow, "--part", "pinion-tooth", *options, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "take --teeth 3" not in result.stdout
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
def test_the_command_that_is_told_runs(tmp_path: Path, narrow: Path, name: str) -> None:
    (tmp_path / "sub").mkdir()
    options = "--part", "pinion-tooth", "--tolerance", "0.5", "--element", "C3D8", "--out", name
    done = subprocess.run(
        installed(narrow, *options), capture_output=True, text=True, check=True, cwd=tmp_path, timeout=120
    )
    command = done.stdout.rstrip("\n").rpartition("; run: ")[2]
    ran = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert ran.returncode == 0, ran.stdout[-500:]
    assert "ERROR" not in ran.stdout
    [results] = (tmp_path / name).parent.glob("*.dat")  # of 'a b' CalculiX makes a.dat
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


def test_one_loaded_tooth_is_said_to_be_held_at_its_sides(tmp_path: Path, narrow: Path) -> None:
    path = tmp_path / "a b.inp"
    result = run(narrow, "--part", "pinion-tooth", *COARSE, "--out", path)
    told = "; held at its cut sides: take --teeth 3 for stresses; run: "
    assert result.stdout.endswith(f"{told}cd {tmp_path} && ccx -i 'a b'\n")
    text = path.read_text(encoding="ascii")
    assert "** The loaded tooth is held at its cut sides: take --teeth 3 for stresses.\n" in text
    assert ", 1 tooth, " in text
    assert "*ELEMENT, TYPE=C3D20, " in text
    assert "take 3 for stresses" in " ".join(run("--help").stdout.split())
    assert "** stresses at the contact are not resolved, those of the fillet are.\n" in text


def test_a_link_stays_and_its_target_is_written(tmp_path: Path) -> None:
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
        (["--part", "gear"], (45, None, None, "gear", False)),
        (["--part", "gear", "--placed"], (45, None, None, "gear", True)),
        (
            ["--part", "pinion-tooth", "--teeth", "3", "--bore-radius", "50"],
            (29, [0, 1, 2], 50.0, "pinion", False),
        ),
    ],
)
def test_a_solid_for_cad(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], given: tuple[object, ...]
) -> None:
    """What `write_step` is given; its own tests look at what it writes."""
    asked = []

    def step(
        member: Member,
        path: Path,
        teeth: Sequence[int] | None,
        bore_radius: float | None,
        name: str,
        frame: Frame | None,
    ) -> None:
        numbers = None if teeth is None else list(teeth)
        asked.append((int(member.teeth), numbers, bore_radius, name, frame is not None))
        path.write_text("ISO-10303-21;")

    monkeypatch.setattr("beveloid_geom.export.step.write_step", step)
    path = tmp_path / "a.step"
    result = run(*options, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert asked == [given]
    assert path.read_text() == "ISO-10303-21;"
    count = given[0] if given[1] is None else 3
    assert result.stdout == f"{path}: a solid with {count} teeth\n"


def test_the_pair_as_an_assembly_and_as_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def step(design: Design, path: Path, frames: Sequence[Frame]) -> None:
        asked.append([origin[2] for _, origin in frames])
        path.write_text("ISO-10303-21;")

    monkeypatch.setattr("beveloid_geom.export.step.write_step_pair", step)
    path = tmp_path / "a.step"
    result = run("--part", "pair", "--out", path)
    assert (result.exit_code, result.stdout) == (0, f"{path}: an assembly of pinion and gear\n")
    assert asked == [[pytest.approx(211.594669224), pytest.approx(203.049073436)]]
    path = tmp_path / "a.glb"
    result = run("--part", "pair", *COARSE, "--out", path)
    assert result.exit_code == 0
    assert (
        "triangles in m, y up: pinion, path of contact on pinion, pattern on pinion, gear," in result.stdout
    )
    assert path.read_bytes().startswith(b"glTF")


def test_frames_place_a_part_as_it_is_placed(tmp_path: Path) -> None:
    """What is printed carries a part in its own frame to where --placed has it, rows to 15 digits."""
    own, placed = tmp_path / "own.vtu", tmp_path / "placed.vtu"
    run("--part", "gear-flank", *COARSE, "--out", own)
    for options, frame in (((), OWN_FRAME), (("--placed",), FIXED_FRAME)):
        run("--part", "pinion-tooth", *options, "--element", "C3D8", *COARSE, "--out", tmp_path / "a.bdf")
        written = (tmp_path / "a.bdf").read_text(encoding="ascii").replace("\n$ ", " ")
        assert frame in written
    both = run("--part", "gear-flank", *COARSE, "--placed", "--frames", "--out", placed)
    alone = run("--frames")
    assert (alone.exit_code, both.stdout) == (0, alone.stdout + both.stdout.splitlines()[-1] + "\n")
    rows = [line.split() for line in alone.stdout.splitlines()[6:]]
    assert alone.stdout.splitlines()[5] == "gear, from its own frame to S_f, mm:"
    matrix = np.array(rows, dtype=float)
    points = pv.read(own).points @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(pv.read(placed).points, points, rtol=0, atol=1e-11)


def test_what_is_missing_is_said() -> None:
    for given, missing in ((["--part", "pair"], "--out"), (["--out", "a.stl"], "--part")):
        result = run(*given)
        assert result.exit_code == 2
        assert f"Missing option '{missing}'" in result.stderr


def test_progress_is_for_terminals(tmp_path: Path) -> None:
    terminal, side = pty.openpty()
    termios.tcsetwinsize(side, (24, 100))
    os.set_blocking(terminal, False)  # nothing to read is to fail, not to wait
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
