"""All commands on pairs with intersecting axes; errors about the common perpendicular and at the mesh."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.validation.test_intersecting_axes import FILE

from .running import json_of, refused, run, words_of

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
    "modify": ("--transmission-error-arcsec", "10", "--length", "10"),
    "place": ("--at", "45"),
}
SLOW = ("optimise", "modify", "statements", "check", "pattern", "place")
OVER = ("pattern", "--resolution", "5", "--area-error", "0.5", "--over")
AT_MESH = ("--in-plane-tolerance-deg", "0.01", "--centre-distance-tolerance", "0.02")
WORDS_AT_MESH = {
    ("sensitivity", "--errors-at", "mesh"): "derivatives with respect to errors at the mesh",
    (
        "sensitivity",
        "--errors-at",
        "perpendicular",
    ): "with respect to errors about the common perpendicular, 15",
    (
        "tolerance",
        *AT_MESH,
        "--cases",
        "40",
    ): "centre distance 0.02 mm, in plane 0.01 deg, out of plane 0 deg",
    ("map", *AT_MESH, "--steps", "2"): "errors for shift centre distance +/-0.02 mm, in plane +/-0.01 deg",
    ("optimise", *AT_MESH): "errors centre distance +/-0.02 mm, in plane +/-0.01 deg; each alone",
    (*OVER, "centre-distance,in-plane"): "errors added a: centre distance, in: in plane",
    (*OVER, "E,Sigma"): "errors added E: offset, Sigma: shaft angle",
    ("place", "--at", "45", "--by", "in-plane,centre-distance"): "by in plane and centre distance",
}
"""Commands with errors of both kinds, and parts of their texts."""


def written(folder: Path, name: str, more: str = "") -> Path:
    values = PAIRS[name]
    cone = values["cone"]
    assert isinstance(cone, tuple)
    path = folder / "pair.toml"
    path.write_text(FILE.format(**values, shaft=sum(cone)) + more, encoding="utf-8")
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


def test_check_prints_the_pivot(tmp_path: Path) -> None:
    straight = written(tmp_path, "straight", more='[errors]\nat = "mesh"\nin_plane_deg = 0.02\n')
    words = words_of("check", straight, status=1)  # it jams by 0.1 um
    assert "shaft angle +0.02 deg, pinion axial -" in words
    assert "about the common perpendicular, 1" in words
    assert "same at the mesh in plane +0.02 deg lines meet at" in words
    plain = words_of("check", written(tmp_path, "straight"))
    assert "shaft-angle errors turn the gear about the common perpendicular, 1" in plain
    assert "-0.0000 " not in plain  # rounding of the backlash


@pytest.mark.parametrize(
    "arguments",
    [pytest.param(a, marks=[pytest.mark.slow] if a[0] in SLOW else []) for a in WORDS_AT_MESH],
)
def test_errors_of_both_kinds(arguments: tuple[str, ...], tmp_path: Path) -> None:
    assert WORDS_AT_MESH[arguments] in words_of(*arguments, written(tmp_path, "straight"))


def test_file_with_errors_at_the_mesh(tmp_path: Path) -> None:
    """The file sets the default kind of errors; JSON contains it."""
    path = written(tmp_path, "straight", more='[errors]\nat = "mesh"\n')
    assert "derivatives with respect to errors at the mesh" in words_of("sensitivity", path)
    words = "centre distance +/-0.05 mm, in plane +/-0.01 deg, out of plane +/-0.01 deg, pinion axial"
    assert words in words_of("map", path, "--steps", "2")
    assert "turn the gear about the pitch point, 15" in words_of("check", path)
    data = json_of("sensitivity", path)
    assert data["layout"]["errors_at"] == "mesh"
    assert data["errors_of_derivatives"][:3] == ["centre_distance", "in_plane", "out_of_plane"]
    rows = run("sensitivity", path, "--csv").stdout.splitlines()
    assert "by_centre_distance_per_mm,by_in_plane_per_rad,by_out_of_plane_per_rad" in rows[0]
    drawn = run("tolerance", path, *AT_MESH, "--cases", "3", "--csv").stdout.splitlines()
    assert drawn[0].startswith("centre_distance_error_mm,in_plane_error_rad,out_of_plane_error_rad,pinion_")


def test_option_for_the_other_kind_of_errors(tmp_path: Path) -> None:
    """A file with an error at the mesh rejects an option for an error about the common perpendicular: the
    option would keep the axial errors that belong to the error at the mesh, 8 mm on this pair."""
    turned = written(tmp_path, "straight", more='[errors]\nat = "mesh"\nin_plane_deg = 0.02\n')
    for option in ("--shaft-angle-error-deg", "--pinion-axial-error"):
        assert f"{option} is about the common perpendicular" in refused("tca", turned, option, "0.01")
    plain = written(tmp_path, "straight", more='[errors]\nat = "mesh"\n')
    assert run("tca", plain, "--offset-error", "0.01", "--no-certify").exit_code == 0
    assert run("tca", turned, "--parabola-pinion", "-0.0001", "--no-certify").exit_code == 0


BOTH_KINDS = {
    "tolerance --in-plane-tolerance-deg 1 --offset-tolerance 1": (
        "--offset-tolerance is about the common perpendicular, but --in-plane-tolerance-deg is"
    ),
    "map --shaft-angle-tolerance-deg 1 --in-plane-tolerance-deg 1": (
        "--shaft-angle-tolerance-deg is about the"
    ),
    "pattern --over offset,in-plane": "--over: offset is about the common perpendicular, in_plane at",
    "place --by E,in-plane": "--by: offset is about the common perpendicular, in_plane at the mesh",
    "place --by E,apex": "pinion-axial (P), gear-axial (G), centre-distance, in-plane, out-of-plane",
    "tolerance --in-plane-tolerance-deg 4": (
        "--in-plane-tolerance-deg must be less than 0.0698132 rad (4 deg) on this pair"
    ),
    "map --centre-distance-tolerance 30": "--centre-distance-tolerance must be less than 30 mm",
    "tolerance --offset-tolerance 60": "--offset-tolerance must be less than 30 mm",
    "tolerance --out-of-plane-tolerance-deg 5.1": "5.1 is not in the range 0.0<=x<=5.0",
    "sensitivity --errors-at apex": "'apex' is not one of 'perpendicular', 'mesh'",
}


@pytest.mark.parametrize("arguments", BOTH_KINDS)
def test_kinds_of_errors_cannot_be_mixed(arguments: str, tmp_path: Path) -> None:
    assert BOTH_KINDS[arguments] in refused(*arguments.split(), written(tmp_path, "straight"))
