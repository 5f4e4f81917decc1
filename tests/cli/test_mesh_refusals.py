"""What the command `beveloid-geom mesh` refuses, and what it leaves when it fails."""

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

from tests.cli import running


def refused(*arguments: str | Path) -> str:
    return running.refused("mesh", *arguments)


def run(*arguments: str | Path) -> Result:
    return running.run("mesh", *arguments)


COARSE = "--tolerance", "0.05"


MOUNTED = "is for the pair, a part --placed, a flank with --field, and a tooth as .inp"
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
        "--teeth 2": "--teeth is for pinion-tooth and gear-tooth, and the pair as .inp, not pinion as .stl",
        "--torque 5": "--torque is for the pair as .inp, not pinion as .stl",
        "--flank left": "--flank is for flanks, the pair, a part --placed, a flank with --field, and",
        "--element C3D8": "--element is for pinion-tooth and gear-tooth as .inp",
        "--field pattern": "--field is for pinion-flank and gear-flank as .vtk, .vtp, .vtu",
        "--parabola-pinion 1": "--parabola-pinion must be",
        "--parabola-gear 0.001": "--parabola-gear is for the gear, the pair, a part --placed, a flank",
        "--offset-error 1": f"--offset-error {MOUNTED}",
        "--shaft-angle-error-deg 1": f"--shaft-angle-error-deg {MOUNTED}",
        "--pinion-axial-error 1": f"--pinion-axial-error {MOUNTED}",
    },
    "gear .step": {"--tolerance 0.1": "--tolerance is for surfaces and hexahedra, not gear as .step\n"},
    "pair .glb": {"--placed": "--placed is for pinion, gear, pinion-tooth, gear-tooth, pinion-flank"},
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
    "pair .inp": {
        **{
            f"--torque {value}": f"--torque must be a finite number above 0 N m, got {value}: it presses"
            for value in ("0", "-5", "nan", "inf")
        },
        "--roll-deg nan": "--roll-deg must be a finite number of deg, got nan",
        "--roll-deg 40": "--roll-deg must be between 0.1924 and 20.6876 deg, where tooth pair 0 is",
        "--offset-error 1 --rolls 7": "--rolls must be at most 6, as tooth pair 0 is in mesh over 0.8484 "
        "pitches only, got 7: or give each roll by --roll-deg\n",
        "--roll-deg 5 --rolls 3": "--roll-deg and --rolls exclude each other",
        "--roll-deg 5 --teeth 1": "--teeth must be at least 3 for all that touch at this roll, got 1",
        "--teeth 4": "--teeth must be an odd number from 1 to 29 for the pair, got 4",
        "--across 0": "--across must be a finite number above 0, got 0",
        "--teeth 31": "--teeth must be between 1 and 29, got 31",
        "--bore-radius 88": f"{BORE}88",
        "--tolerance 0": "--tolerance must be a finite number above 0 mm, got 0",
        "--load 10": "--load is for pinion-tooth and gear-tooth as .inp, not pair as .inp",
        "--element C3D8": "--element is for pinion-tooth and gear-tooth as .inp",
        "--placed": "--placed is for pinion, gear,",
    },
    **{
        f"{part} {suffix}": {"": f"--out: a {part} cannot be written as {suffix}: give one of "}
        for part, suffix in (
            ("pinion", ".inp"),
            ("pair", ".msh"),
            ("gear-flank", ".bdf"),
            ("pinion", ".glb"),
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
def test_a_flank_that_the_tool_does_not_leave_whole(
    tmp_path: Path, design_file: Callable[..., Path], old: str, new: str, told: str
) -> None:
    result = run(design_file(old, new), "--part", "pinion-flank", *COARSE, "--out", tmp_path / "a.stl")
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


def test_design_that_no_tooth_can_be_made_of(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    design = design_file("profile_shift = 0.17", "profile_shift = -1.5")
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
    ("errors", "told"),
    [
        (
            "--offset-error 6",
            "Error: no contact: the path of contact does not meet the right flanks: at mid-depth",
        ),
        ("--offset-error -0.5", "Error: Jammed: the pair cannot be assembled: the other flanks interfere"),
    ],
)
def test_a_pair_that_cannot_be_in_contact(tmp_path: Path, errors: str, told: str) -> None:
    result = run("--part", "pair", *errors.split(), "--rolls", "2", "--out", tmp_path / "a.inp")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith(told)
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


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
        running.installed("mesh", "--part", "pinion-tooth" if suffix != ".vtu" else "pinion", "--out", path),
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
    assert line == "Error: not enough memory for --tolerance 0.01: take a larger one\n"
    monkeypatch.setattr("beveloid_geom.export.fea.pair_mesh.tooth_hexahedra", much)
    cure = "take a smaller --across or fewer --teeth"
    line = refused("--part", "pair", "--out", tmp_path / "a.inp")
    assert line == f"Error: not enough memory for the pair in contact: {cure}\n"
    assert not list(tmp_path.iterdir())


def test_of_several_files_the_one_that_fails_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While it is written, and while it takes its place; of neither a part is left."""
    given = "--part", "pair", "--across", "0.1", "--rolls", "2", "--out", tmp_path / "a.inp"
    line = "Error: cannot write {} (No space left on device): choose another --out\n"

    def full(*paths: object, **_: object) -> None:
        raise OSError(28, "No space left on device", *[paths[0], None, paths[1]] * isinstance(paths[1], str))

    with monkeypatch.context() as patch:
        patch.setattr("beveloid_geom.export.fea.pair_deck.write_pair_deck", full)
        assert refused(*given) == line.format(tmp_path / "a-1.inp")
    with monkeypatch.context() as patch:
        patch.setattr("beveloid_geom.support.whole_file.os.replace", lambda a, b: full(str(a), str(b)))
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


def test_a_solid_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OCP", None)
    line = refused("--part", "pinion", "--out", tmp_path / "a.step")
    assert "pip install 'beveloid-geom[step]'" in line
    assert not list(tmp_path.iterdir())
