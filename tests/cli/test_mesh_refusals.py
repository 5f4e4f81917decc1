"""Command `beveloid-geom mesh`: rejected input, and files after a failure."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from beveloid_geom.cli.mesh_parts import WRITERS
from tests.cli import running


def refused(*arguments: str | Path) -> str:
    return running.refused("mesh", *arguments)


def run(*arguments: str | Path) -> Result:
    return running.run("mesh", *arguments)


COARSE = "--tolerance", "0.05"


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
    result = run(design_file(old, new), "--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
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
    design = design_file("profile_shift = 0.17", "profile_shift = -2.0")
    assert "and removed completely" in refused(design, "--part", "pinion", "--out", tmp_path / "a.stl")
    assert "cannot be read" in refused("none.toml", "--part", "pinion", "--out", tmp_path / "a.stl")
    assert list(tmp_path.iterdir()) == [design]


@pytest.mark.parametrize("part", ["pair", "pinion-flank"])
def test_missing_contact_is_one_line(tmp_path: Path, part: str) -> None:
    options = ["--field", "separation"] if part.endswith("flank") else []
    result = run("--part", part, *options, "--offset-error", "6", "--out", tmp_path / "a.vtu")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("Error: no contact: the path of contact does not meet the right flanks")
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("errors", "line"),
    [
        (
            "--offset-error 6",
            "Error: no contact: the path of contact does not meet the right flanks: at mid-depth",
        ),
        ("--offset-error -0.5", "Error: Jammed: the pair cannot be assembled: the flanks of one side"),
    ],
)
def test_a_pair_that_cannot_be_in_contact(tmp_path: Path, errors: str, line: str) -> None:
    result = run("--part", "pair", *errors.split(), "--rolls", "2", "--out", tmp_path / "a.inp")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith(line)
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_unknown_first_contacts_are_one_line(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    design = design_file("addendum = 1.0", "addendum = 1.3")  # tips reach the bottom lands
    given = "--part", "pinion-flank", "--field", "pattern", "--tolerance", "0.2"
    result = run(design, *given, "--out", tmp_path / "a.vtu")
    assert (result.exit_code, result.stdout) == (1, "")
    line = result.stderr.splitlines()[-1]
    assert line.startswith("Error: no pattern: the first contact of the right flanks is not known")
    assert "give" not in line
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
