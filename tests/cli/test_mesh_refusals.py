"""Command `beveloid-geom mesh`: rejected input, and files after a failure."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom.cli.mesh_parts import WRITERS
from tests.cli import running

run = partial(running.run, "mesh")
refused = partial(running.refused, "mesh")
COARSE = "--tolerance", "0.05"


MOUNTED = "is for the pair, a part --placed, a flank with --field, and a tooth as .inp"
BORE = "Error: --bore-radius must be between 1.76387 and 87.5934 mm, got "
MESH = {
    "pinion .stl": {
        "--tolerance 0": "--tolerance must be a finite number above 0 mm, got 0",
        "--tolerance 1e-9": "tolerance 1e-09 mm needs about",
        "--tolerance 1e-320": "--tolerance must be at least 1e-09 mm, got",
        "--bore-radius 0": "--bore-radius must be a finite number above 0 mm, got 0",
        "--bore-radius 500": f"{BORE}500",
        "--load 10": "--load is for pinion-tooth and gear-tooth as .inp, not for pinion as .stl: omit it",
        "--teeth 2": "and gear-tooth, and the pair as .inp, not for pinion as .stl: omit it",
        "--torque 5": "--torque is for the pair as .inp, not for pinion as .stl: omit it",
        "--roll-deg 5": "--roll-deg is for the pair, a part --placed and --frames, not for pinion as .stl",
        "--pinion-bore-radius 5": "--pinion-bore-radius is for the pair, not for pinion as .stl: omit it",
        "--flank left": "--flank is for flanks, the pair, a part --placed, a flank with --field, and",
        "--element C3D8": "--element is for pinion-tooth and gear-tooth as .inp",
        "--field pattern": "--field is for pinion-flank and gear-flank as .vtk, .vtp, .vtu",
        "--parabola-pinion 1": "--parabola-pinion must be",
        "--parabola-gear 0.001": "--parabola-gear is for the gear, the pair, a part --placed, a flank",
        "--offset-error 1": f"--offset-error {MOUNTED}",
        "--shaft-angle-error-deg 1": f"--shaft-angle-error-deg {MOUNTED}",
        "--pinion-axial-error 1": f"--pinion-axial-error {MOUNTED}",
    },
    "gear .step": {
        "--tolerance 0.1": "--tolerance is for surfaces and hexahedra, not for gear as .step: omit it\n"
    },
    "pair .glb": {"--placed": "--placed is for pinion, gear, pinion-tooth, gear-tooth, pinion-flank"},
    "gear-flank .vtu": {"--gear-axial-error 0.1": f"--gear-axial-error {MOUNTED}"},
    **{
        f"pinion-tooth {suffix}": {
            "--teeth 30": "Error: --teeth must be between 1 and 29, got 30: 29 is the complete gear\n",
            **(
                {} if suffix == ".step" else {"--bore-radius 88.193": f"{BORE}88", "--bore-radius 1e-9": BORE}
            ),
        }
        for suffix in (".stl", ".msh", ".step")
    },
    "pinion-tooth .inp": {
        "--load 0": "--load must be a finite number above 0 N, got 0",
        "--tolerance 1e-320": "--tolerance must be at least 1e-09 mm",
        "--tolerance 1e-9": "nodes for 1 tooth, the limit is 5e+06",
    },
    "pair .inp": {
        "--torque -5": "--torque must be a finite number above 0 N m, got -5: give its",
        "--torque nan": "--torque must be a finite number above 0 N m, got nan: give its",
        "--roll-deg nan": "--roll-deg must be a finite angle in deg, got nan",
        "--roll-deg 40": "--roll-deg must be between 0.1924 and 20.6876 deg, where tooth pair 0 is",
        "--offset-error 1 --rolls 7": "--rolls must be at most 6 because tooth pair 0 is in mesh over only "
        "0.8484 pitches, got 7: or give each roll with --roll-deg\n",
        "--roll-deg 5 --rolls 3": "--roll-deg and --rolls exclude each other",
        "--roll-deg 5 --teeth 1": "--teeth must be at least 3 to include all teeth that touch at this roll",
        "--bore-radius 40 --gear-bore-radius 200": "--gear-bore-radius must be between 2.61438",
        "--teeth 4": "--teeth must be an odd number from 1 to 29 for the pair, got 4",
        "--across 0": "--across must be a finite number above 0, got 0",
        "--teeth 31": "--teeth must be between 1 and 29, got 31",
        "--bore-radius 88": f"{BORE}88",
        "--tolerance 0": "--tolerance must be a finite number above 0 mm, got 0",
        "--load 10": "--load is for pinion-tooth and gear-tooth as .inp, not for pair as .inp: omit it",
        "--element C3D8": "--element is for pinion-tooth and gear-tooth as .inp",
        "--placed": "--placed is for pinion, gear,",
    },
    **{
        f"{part} {suffix}": {"": f"--out: a {part} cannot be written as {suffix}: give one of "}
        for part, suffix in (("pair", ".msh"), ("gear-flank", ".bdf"), ("pinion", ".glb"))
    },
    "gear .inp": {"": "for hexahedra of all teeth, give --part gear-tooth --teeth 45\n"},
    "pinion .xyz": {"": "Error: --out: .xyz is not a known format: give one of .inp, .msh"},
    "pair ": {"": "a name without a suffix is not a known format"},
}
"""Expected line by part and format, and options."""


@pytest.mark.parametrize(
    ("part", "options", "words"),
    [(part, options, words) for part, cases in MESH.items() for options, words in cases.items()],
)
def test_bad_input(part: str, options: str, words: str, tmp_path: Path) -> None:
    name, suffix = part.split(" ")
    assert words in refused("--part", name, *options.split(), "--out", tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())


def test_limits_of_the_bore_of_a_solid(tmp_path: Path) -> None:
    pytest.importorskip("OCP", exc_type=ImportError)
    for bore in ("88.193", "1e-9"):
        line = refused("--part", "pinion-tooth", "--bore-radius", bore, "--out", tmp_path / "a.step")
        assert line.startswith(f"Error: --bore-radius must be between 1.76387 and 87.5934 mm, got {bore[:2]}")


def test_missing_folder_and_folder_for_a_file(tmp_path: Path) -> None:
    missing = tmp_path / "none" / "a.stl"
    line = refused("--part", "pinion", "--out", missing)
    assert line == f"Error: --out: the folder {missing.parent} does not exist: create it first\n"
    (tmp_path / "b.stl").mkdir()
    assert "b.stl is a folder: give the name of a file" in refused(
        "--part", "pair", "--out", tmp_path / "b.stl"
    )


def test_errors_of_the_layout_do_not_change_a_flank_alone(tmp_path: Path) -> None:
    given = "--part", "gear-flank", "--gear-axial-error", "0.1", "--out", tmp_path / "a.vtu"
    assert "--gear-axial-error is for the pair" in refused(*given)
    result = run(*given, *COARSE, "--field", "separation")
    assert (result.exit_code, result.stderr) == (0, "")


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("profile_shift = 0.17", "profile_shift = -1.5", "Warning: the right flank is undercut "),
        (
            "tip_radius = 0.38",
            "tip_radius = 0.7",
            "Warning: tip_radius 0.7 is too large: the tool's tip rounds",
        ),
    ],
)
def test_undercut_flanks_cause_a_warning(
    tmp_path: Path, design_file: Callable[..., Path], old: str, new: str, line: str
) -> None:
    result = run(design_file({old: new}), "--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
    assert result.exit_code == 0
    assert result.stderr.startswith(line)
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("Singular matrix"), TypeError("a bug")])
def test_internal_errors_are_not_reported_as_bad_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def broken(*_: object) -> None:
        raise error

    monkeypatch.setattr("beveloid_geom.export.parts.gear_surface", broken)
    assert run("--part", "pinion", "--out", tmp_path / "a.stl").exception is error
    assert not list(tmp_path.iterdir())


def test_a_design_without_a_tooth_is_rejected(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    design = design_file({"profile_shift = 0.17": "profile_shift = -2.0"})
    assert "and removed completely" in refused(design, "--part", "pinion", "--out", tmp_path / "a.stl")
    assert "cannot be read" in refused("none.toml", "--part", "pinion", "--out", tmp_path / "a.stl")
    assert list(tmp_path.iterdir()) == [design]


LOST = "no contact: the path of contact does not meet the right flanks"


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ("--part pair --offset-error 6 --out a.vtu", LOST),
        ("--part pinion-flank --field separation --offset-error 6 --out a.vtu", LOST),
        ("--part pair --offset-error 6 --rolls 2 --out a.inp", LOST),
        (
            "--part pair --offset-error -0.5 --out a.inp",
            "Jammed: the pair cannot be assembled: the flanks of",
        ),
    ],
)
def test_a_result_that_does_not_exist_is_one_line(
    options: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*options.split())
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith(f"Error: {line}")
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_unknown_first_contacts(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    design = design_file({"addendum = 1.0": "addendum = 1.3"})  # tips reach the bottom lands
    given = "--part", "pinion-flank", "--field", "pattern", "--tolerance", "0.2"
    result = run(design, *given, "--out", tmp_path / "a.vtu")
    assert (result.exit_code, result.stdout) == (1, "")
    line = result.stderr.splitlines()[-1]
    assert line.startswith("Error: no pattern: the first contact of the right flanks is not known")
    assert list(tmp_path.iterdir()) == [design]


# Files after a failure


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".stl", ".vtp", ".vtu", ".msh", ".step"])
def test_a_failed_write_leaves_the_old_file(tmp_path: Path, suffix: str) -> None:
    """If writing fails, here because files are limited to 4 kB as on a full disk, the old file is left and
    the message has one line."""
    if suffix == ".step":
        pytest.importorskip("OCP", exc_type=ImportError)
    path = tmp_path / f"old{suffix}"
    path.write_text("old")

    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    done = subprocess.run(
        running.installed("mesh", "--part", "pinion-tooth" if suffix != ".vtu" else "pinion", "--out", path),
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=small_files,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"Error: cannot write {path} (")
    assert ".part" not in done.stderr
    if suffix in (".msh", ".step"):  # their libraries report no reason
        assert done.stderr.endswith(", is the disk full?): choose another --out\n")
    assert done.stderr.count("\n") == 1
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_write_of_hexahedra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("beveloid_geom.export.fea.volumes.write_volume", full)
    line = refused("--part", "pinion-tooth", *COARSE, "--out", tmp_path / "a.msh")
    assert (
        line == f"Error: cannot write {tmp_path / 'a.msh'} (No space left on device): choose another --out\n"
    )
    assert not list(tmp_path.iterdir())


def test_memory_that_runs_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def much(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("beveloid_geom.export.parts.gear_surface", much)
    line = refused("--part", "pinion", "--out", tmp_path / "a.stl")
    assert line == "Error: not enough memory for --tolerance 0.01: use a larger value\n"
    monkeypatch.setattr("beveloid_geom.export.fea.pair_mesh.tooth_hexahedra", much)
    cure = "use a smaller --across or fewer --teeth"
    line = refused("--part", "pair", "--out", tmp_path / "a.inp")
    assert line == f"Error: not enough memory for the pair in contact: {cure}\n"
    monkeypatch.setitem(WRITERS, "solid", much)
    line = refused("--part", "gear", "--out", tmp_path / "a.step")
    assert line == "Error: not enough memory for gear as .step: write a smaller part, such as a tooth\n"
    assert not list(tmp_path.iterdir())


def test_the_failed_one_of_several_files_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If writing or renaming one of several files fails, the message names it, and no file is left."""
    given = "--part", "pair", "--across", "0.1", "--rolls", "2", "--out", tmp_path / "a.inp"
    line = "Error: cannot write {} (No space left on device): choose another --out\n"

    def full(*paths: object, **_: object) -> None:
        raise OSError(28, "No space left on device", *[paths[0], None, paths[1]] * isinstance(paths[1], str))

    with monkeypatch.context() as patch:
        patch.setattr("beveloid_geom.export.fea.pair_deck.write_pair_deck", full)
        assert refused(*given) == line.format(tmp_path / "a-1.inp")
    with monkeypatch.context() as patch:
        patch.setattr("beveloid_geom.support.atomic_file.os.replace", lambda a, b: full(str(a), str(b)))
        assert refused(*given) == line.format(tmp_path / "a-2.inp")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_nothing(tmp_path: Path, number: int, status: int) -> None:
    path = tmp_path / "flank.obj"
    process = subprocess.Popen(
        running.installed("mesh", "--part", "pinion-flank", "--tolerance", "1e-7", "--out", path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Shells make processes in the background ignore Ctrl-C, and children inherit it.
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


def test_a_command_does_not_change_signal_handlers(tmp_path: Path) -> None:
    """A program that calls the command from Python keeps its handlers."""
    before = signal.getsignal(signal.SIGTERM)
    run("--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_solid_without_the_kernel_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "OCP", None)
    line = refused("--part", "pinion", "--out", tmp_path / "a.step")
    assert "pip install 'beveloid-geom[step]'" in line
    assert not list(tmp_path.iterdir())
