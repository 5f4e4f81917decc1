"""The command `beveloid-geom mesh`: its files, what it refuses, and what it leaves when it fails."""

from __future__ import annotations

import os
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista as pv
from click.testing import Result

from beveloid_geom import Member
from beveloid_geom.design.file import builtin_text
from tests.cli import running
from tests.cli.running import imported_by


def run(*arguments: str | Path) -> Result:
    return running.run("mesh", *arguments)


def installed(*arguments: str | Path) -> list[str]:
    return running.installed("mesh", *arguments)


COARSE = "--tolerance", "0.05"
NARROW = builtin_text().replace("face_width = 50.0", "face_width = 10.0")


def refused(*arguments: str | Path) -> str:
    """The one line that a refusal is."""
    result = run(*arguments)
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    assert result.stderr.startswith("Error: ")
    assert result.stderr.count("\n") == 1, result.stderr
    return result.stderr


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


@pytest.mark.parametrize(
    ("part", "suffix"),
    [
        ("pinion", ".STL"),
        ("gear", ".ply"),
        ("pair", ".vtp"),
        ("pinion-flank", ".obj"),
        ("gear-flank", ".vtk"),
        ("pinion-tooth", ".stl"),
        ("gear-tooth", ".vtp"),
    ],
)
def test_every_part_as_a_surface(tmp_path: Path, part: str, suffix: str) -> None:
    path = tmp_path / f"part{suffix}"
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
    assert "module / 600, hexahedra module / 120" in " ".join(run("--help").stdout.split())


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
        (["--part", "gear"], (45, None, None, "gear")),
        (["--part", "pinion-tooth", "--teeth", "3", "--bore-radius", "50"], (29, [0, 1, 2], 50.0, "pinion")),
    ],
)
def test_a_solid_for_cad(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], given: tuple[object, ...]
) -> None:
    """What `write_step` is given; its own tests look at what it writes."""
    asked = []

    def step(
        member: Member, path: Path, teeth: Sequence[int] | None, bore_radius: float | None, name: str
    ) -> None:
        asked.append((int(member.teeth), None if teeth is None else list(teeth), bore_radius, name))
        path.write_text("ISO-10303-21;")

    monkeypatch.setattr("beveloid_geom.export.step.write_step", step)
    path = tmp_path / "a.step"
    result = run(*options, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert asked == [given]
    assert path.read_text() == "ISO-10303-21;"
    count = given[0] if given[1] is None else 3
    assert result.stdout == f"{path}: a solid with {count} teeth\n"


def test_a_solid_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OCP", None)
    line = refused("--part", "pinion", "--out", tmp_path / "a.step")
    assert "pip install 'beveloid-geom[step]'" in line
    assert not list(tmp_path.iterdir())


# What it refuses


MOUNTED = "is for the pair, a flank with --field, and a tooth as .inp"
BORE = "Error: --bore-radius must be between 1.76387 and 87.5934 mm, got "
REFUSED = {
    "pinion .stl": {
        **{
            f"--tolerance {value}": f"--tolerance must be a finite number above 0 mm, got {value}"
            for value in ("0", "-0.01", "nan", "inf")
        },
        "--tolerance 1e-9": "tolerance 1e-09 mm is too fine: it takes about",
        "--tolerance 1e-320": "--tolerance must be at least 1e-09 mm, got",
        "--bore-radius 0": "--bore-radius must be a finite number above 0 mm, got 0",
        "--bore-radius 500": f"{BORE}500",
        "--load 10": "--load is for pinion-tooth and gear-tooth as .inp, not pinion as .stl",
        "--teeth 2": "--teeth is for pinion-tooth and gear-tooth, not pinion as .stl",
        "--flank left": "--flank is for flanks, the pair, and a tooth as .inp, not pinion as .stl",
        "--element C3D8": "--element is for pinion-tooth and gear-tooth as .inp",
        "--field pattern": "--field is for pinion-flank and gear-flank as .vtk, .vtp, .vtu",
        "--parabola-pinion 1": "--parabola-pinion must be",
        "--parabola-gear 0.001": "--parabola-gear is for the gear, the pair, a flank with --field",
        "--offset-error 1": f"--offset-error {MOUNTED}",
        "--shaft-angle-error-deg 1": f"--shaft-angle-error-deg {MOUNTED}",
        "--pinion-axial-error 1": f"--pinion-axial-error {MOUNTED}",
    },
    "gear .step": {"--tolerance 0.1": "--tolerance is for surfaces and hexahedra, not gear as .step\n"},
    "gear-flank .vtu": {"--gear-axial-error 0.1": f"--gear-axial-error {MOUNTED}"},
    **{
        f"pinion-tooth {suffix}": {
            "--teeth 30": "Error: --teeth must be between 1 and 29, got 30\n",
            **(
                {} if suffix == ".step" else {"--bore-radius 88.193": f"{BORE}88", "--bore-radius 1e-9": BORE}
            ),
        }
        for suffix in (".stl", ".vtp", ".msh", ".step")
    },
    "pinion-tooth .inp": {
        **{
            f"--load {value}": f"--load must be a finite number above 0 N, got {value}"
            for value in ("0", "-5", "nan")
        },
        "--tolerance 1e-320": "--tolerance must be at least 1e-09 mm",
        "--tolerance 1e-9": "nodes for 1 tooth, the limit is 5e+06",
    },
    **{
        f"{part} {suffix}": {"": f"--out: a {part} cannot be written as {suffix}: give one of "}
        for part, suffix in (
            ("pinion", ".inp"),
            ("pair", ".msh"),
            ("gear-flank", ".bdf"),
            ("pair", ".step"),
            ("pinion-flank", ".stp"),
        )
    },
    "pinion .xyz": {"": "Error: --out: .xyz is no known format: give one of .inp, .msh"},
    "pair ": {"": "a name without a suffix is no known format"},
}
"""One line by part and format, and options."""


@pytest.mark.parametrize(
    ("what", "options", "told"),
    [(what, options, told) for what, cases in REFUSED.items() for options, told in cases.items()],
)
def test_what_cannot_be_meant(tmp_path: Path, what: str, options: str, told: str) -> None:
    part, suffix = what.split(" ")
    assert told in refused("--part", part, *options.split(), "--out", tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())


def test_limits_of_the_bore_of_a_solid(tmp_path: Path) -> None:
    pytest.importorskip("OCP", exc_type=ImportError)
    for bore in ("88.193", "1e-9"):
        line = refused("--part", "pinion-tooth", "--bore-radius", bore, "--out", tmp_path / "a.step")
        assert line.startswith(f"{BORE}{bore[:2]}")


def test_missing_folder_and_folder_for_a_file(tmp_path: Path) -> None:
    missing = tmp_path / "none" / "a.stl"
    line = refused("--part", "pinion", "--out", missing)
    assert line == f"Error: --out: the folder {missing.parent} does not exist: make it first\n"
    (tmp_path / "b.stl").mkdir()
    assert "b.stl is a folder: name a file in it" in refused("--part", "pair", "--out", tmp_path / "b.stl")


def test_errors_of_the_layout_do_not_change_a_flank_alone(tmp_path: Path) -> None:
    given = "--part", "gear-flank", "--gear-axial-error", "0.1", "--out", tmp_path / "a.vtu"
    assert "--gear-axial-error is for the pair" in refused(*given)
    result = run(*given, *COARSE, "--field", "separation")
    assert (result.exit_code, result.stderr) == (0, "")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("profile_shift = 0.17", "profile_shift = -1.5", "Warning: the right flank is undercut "),
        ("tip_radius = 0.38", "tip_radius = 0.7", "Warning: tip_radius 0.7 is too large: the tool's rounds"),
    ],
)
def test_a_flank_that_the_tool_does_not_leave_whole(tmp_path: Path, old: str, new: str, told: str) -> None:
    design = tmp_path / "design.toml"
    assert old in builtin_text()
    design.write_text(builtin_text().replace(old, new))
    result = run(design, "--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
    assert result.exit_code == 0
    assert result.stderr.startswith(told)
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("Singular matrix"), TypeError("a bug")])
def test_bugs_are_no_faults_of_the_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def broken(*_: object) -> None:
        raise error

    monkeypatch.setattr("beveloid_geom.export.parts.gear_surface", broken)
    assert run("--part", "pinion", "--out", tmp_path / "a.stl").exception is error
    assert not list(tmp_path.iterdir())


def test_design_that_no_tooth_can_be_made_of(tmp_path: Path) -> None:
    design = tmp_path / "undercut.toml"
    design.write_text(builtin_text().replace("profile_shift = 0.17", "profile_shift = -1.5"))
    assert "undercut" in refused(design, "--part", "pinion", "--out", tmp_path / "a.stl")
    assert "cannot be read" in refused("none.toml", "--part", "pinion", "--out", tmp_path / "a.stl")
    assert list(tmp_path.iterdir()) == [design]


@pytest.mark.parametrize("part", ["pair", "pinion-flank"])
def test_no_contact_is_no_crash(tmp_path: Path, part: str) -> None:
    options = ["--field", "separation"] if part.endswith("flank") else []
    result = run("--part", part, *options, "--offset-error", "6", "--out", tmp_path / "a.vtu")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("Error: no contact: the path of contact does not meet the right flanks")
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    [
        ["--part", "pinion"],
        ["--out", "a.stl"],
        ["--part", "shaft", "--out", "a.stl"],
        ["--part", "pinion", "--out", "a.stl", "--tolerance", "fine"],
        ["--part", "pinion-tooth", "--out", "a.stl", "--teeth", "0"],
        ["--part", "pinion-tooth", "--out", "a.inp", "--element", "C3D4"],
        ["--part", "pinion-flank", "--out", "a.vtu", "--field", "heat"],
    ],
    ids=" ".join,
)
def test_wrong_command_line(arguments: list[str]) -> None:
    result = run(*arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1


def test_a_pattern_without_first_contacts_is_no_crash(tmp_path: Path) -> None:
    given = "--part", "pinion-flank", "--field", "pattern", "--parabola-pinion", "-0.01", "--tolerance", "0.2"
    result = run(*given, "--out", tmp_path / "a.vtu")
    assert (result.exit_code, result.stdout) == (1, "")
    told = result.stderr.splitlines()[-1]
    assert told.startswith("Error: no pattern: the first contact of the right flanks is not known")
    assert "give" not in told
    assert not list(tmp_path.iterdir())


# What it leaves when it fails


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".stl", ".vtp", ".vtu", ".msh", ".step"])
def test_a_failed_write_leaves_the_old_file(tmp_path: Path, suffix: str) -> None:
    """Files may not grow past 4 kB here, as on a full disk."""
    if suffix == ".step":
        pytest.importorskip("OCP", exc_type=ImportError)
    path = tmp_path / f"old{suffix}"
    path.write_text("old")

    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    done = subprocess.run(
        installed("--part", "pinion-tooth" if suffix != ".vtu" else "pinion", "--out", path),
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=small_files,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"Error: cannot write {path} (")
    assert ".part" not in done.stderr
    if suffix in (".msh", ".step"):  # whose libraries give no reason
        assert done.stderr.endswith(", is the disk full?): choose another --out\n")
    assert done.stderr.count("\n") == 1
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_write_of_hexahedra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("beveloid_geom.export.volumes.write_volume", full)
    line = refused("--part", "pinion-tooth", *COARSE, "--out", tmp_path / "a.msh")
    assert (
        line == f"Error: cannot write {tmp_path / 'a.msh'} (No space left on device): choose another --out\n"
    )
    assert not list(tmp_path.iterdir())


def test_memory_that_runs_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def much(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("beveloid_geom.export.parts.gear_surface", much)
    line = refused("--part", "pinion", "--out", tmp_path / "a.stl")
    assert line == "Error: not enough memory for --tolerance 0.01: take a larger one\n"


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_nothing(tmp_path: Path, number: int, status: int) -> None:
    path = tmp_path / "flank.obj"
    process = subprocess.Popen(
        installed("--part", "pinion-flank", "--tolerance", "1e-7", "--out", path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Shells let what they start in the background ignore Ctrl-C, and children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    end = time.monotonic() + 30.0
    while not list(tmp_path.iterdir()) and time.monotonic() < end:
        time.sleep(0.02)
    assert [file.suffix for file in tmp_path.iterdir()] == [".part"]
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (status, "")
    assert err == f"Error: interrupted: {path} is not written\n"
    assert not list(tmp_path.iterdir())


def test_a_command_leaves_the_signals_as_they_were(tmp_path: Path) -> None:
    """Of whoever calls it from Python."""
    before = signal.getsignal(signal.SIGTERM)
    run("--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
    assert signal.getsignal(signal.SIGTERM) is before


# Start-up and progress


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


@pytest.mark.parametrize(
    ("arguments", "slow"),
    [
        (["--help"], {"numpy", "scipy", "trimesh", "meshio", "tqdm", "pyvista", "OCP"}),
        (
            ["--part", "pinion-tooth", *COARSE, "--out", "a.vtp"],
            {"trimesh", "meshio", "OCP", "pyvista", "vtkmodules"},
        ),
        (
            ["--part", "gear-tooth", *COARSE, "--out", "a.stl"],
            {"OCP", "pyvista", "vtkmodules", "beveloid_viz"},
        ),
        (
            ["--part", "gear-flank", "--out", "a.vtu"],
            {"trimesh", "OCP", "pyvista", "vtkmodules", "beveloid_viz"},
        ),
    ],
    ids=["help", "vtp", "stl", "vtu"],
)
def test_commands_import_no_more_than_they_need(tmp_path: Path, arguments: list[str], slow: set[str]) -> None:
    imported = imported_by("mesh", *arguments, folder=tmp_path)
    assert "beveloid_geom.cli.commands.mesh" in imported
    assert not imported & slow
