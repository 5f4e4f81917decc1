"""Every command on pairs whose axes intersect, and what it refuses there."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.validation.test_intersecting_axes import FILE

from .running import refused, run

PAIRS = {
    "24/61": {"module": 6.0, "teeth": (24, 61), "helix": (15.0, -15.0), "cone": (2.0, 5.0), "face": 60.0},
    "straight": {"module": 3.0, "teeth": (37, 37), "helix": (0.0, 0.0), "cone": (0.0, 4.0), "face": 30.0},
}
TOLERANCES = ("--offset-tolerance", "0.02", "--shaft-angle-tolerance-deg", "0.002")
COMMANDS: dict[str, tuple[str, ...]] = {
    "check": (),
    "tca": ("--force", "1000", "--offset-error", "0.02"),
    "operation": ("--points", "3", "--offset-error", "-0.02"),
    "pattern": ("--resolution", "3", "--area-error", "0.2"),
    "ease-off": ("--grid", "3", "3"),
    "sliding": (),
    "sensitivity": (),
    "statements": (),
    "tolerance": (*TOLERANCES, "--cases", "40"),
    "map": ("--steps", "2"),
    "optimise": (*TOLERANCES, "--pinion-bounds", "-0.001", "0.001"),
}
SLOW = ("optimise", "statements", "check", "pattern")


def written(folder: Path, name: str, offset: str = "0", more: str = "") -> Path:
    values = PAIRS[name]
    cone = values["cone"]
    assert isinstance(cone, tuple)
    path = folder / "pair.toml"
    text = FILE.format(**values, shaft=sum(cone)).replace("offset = 0", f"offset = {offset}")
    path.write_text(text + more, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[pytest.mark.slow] if c in SLOW else []) for c in COMMANDS]
)
@pytest.mark.parametrize("name", PAIRS)
def test_every_command_runs(name: str, command: str, tmp_path: Path) -> None:
    result = run(command, written(tmp_path, name), *COMMANDS[command])
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert "E = 0 mm" in result.stdout
    assert "nan" not in result.stdout


def test_check_says_which_pivot_is_meant(tmp_path: Path) -> None:
    straight = written(tmp_path, "straight", more='[errors]\nat = "mesh"\nin_plane_deg = 0.02\n')
    found = " ".join(run("check", straight).stdout.split())
    assert "shaft angle +0.02 deg, pinion axial -" in found
    assert "about the common perpendicular, 1" in found
    assert "same at the mesh in plane +0.02 deg closes" in found
    plain = " ".join(run("check", written(tmp_path, "straight")).stdout.split())
    assert "errors of the shaft angle turn about the common perpendicular, 1" in plain


def test_a_place_of_errors_that_is_none_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "straight", more='[errors]\nat = "apex"\n')
    assert '[errors] at must be "perpendicular" or "mesh", got \'apex\'' in refused("check", path)


def test_meshes_are_written(tmp_path: Path) -> None:
    out = tmp_path / "tooth.vtu"
    result = run("mesh", written(tmp_path, "24/61"), "--part", "pair", "--out", out, "--tolerance", "0.2")
    assert result.exit_code == 0, result.output
    assert out.stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("tca", "--offset-error", "61"),
            "--offset-error must be between -60 and 60 mm, 10 modules, got 61.0",
        ),
        (("tca", "--shaft-angle-error-deg", "-4"), "must be at least -3.5 deg"),
        (
            ("tolerance", "--offset-tolerance", "60"),
            "tolerance of offset must be less than 60 mm on this pair",
        ),
        (("map", "--offset-error", "-70"), "--offset-error must be between -60 and 60 mm"),
    ],
)
def test_errors_too_large_are_refused(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    path = written(tmp_path, "24/61")
    path.write_text(path.read_text().replace("shaft_angle_deg = 7.0", "shaft_angle_deg = 4.0"))
    assert words in refused(arguments[0], path, *arguments[1:])


@pytest.mark.parametrize(
    ("offset", "more", "words"),
    [
        ("-0.1", "", "[pair] offset must be between 0 and 100000 mm, got -0.1: give the distance of the"),
        ("0", "\n[errors]\noffset = -61\n", "[errors] offset must be between -60 and 60 mm, 10 modules"),
    ],
)  # fmt: skip
def test_files_that_are_refused(offset: str, more: str, words: str, tmp_path: Path) -> None:
    assert words in refused("tca", written(tmp_path, "24/61", offset, more))
