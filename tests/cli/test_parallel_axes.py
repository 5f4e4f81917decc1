"""Every command on pairs whose axes are parallel, and what it refuses there."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.contact.parallel.lines import contact_lines
from beveloid_geom.design.file import builtin_text

from .running import refused, run

NAME = "anti-backlash"
PARABOLA = ("--parabola-pinion", "-0.002", "--parabola-gear", "-0.001")
COMMANDS: dict[str, tuple[str, ...]] = {
    "tca": ("--points", "3", "--force", "1000"),
    "operation": ("--points", "3"),
    "pattern": ("--resolution", "3", "--area-error", "0.2"),
    "ease-off": ("--grid", "3", "3"),
    "sliding": (),
    "sensitivity": (),
}
SLOW = ("pattern", "operation")


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[pytest.mark.slow] if c in SLOW else []) for c in COMMANDS]
)
@pytest.mark.parametrize("parabola", [(), PARABOLA])
def test_every_command_runs(command: str, parabola: tuple[str, ...]) -> None:
    result = run(command, NAME, *COMMANDS[command], *parabola)
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert "shaft angle = 0 deg" in result.stdout
    known = command == "sensitivity"  # says that lines have no derivatives, and a path no shift along itself
    assert ("nan" in result.stdout) == known


def test_check_has_no_warnings() -> None:
    found = run("check", NAME).stdout
    assert "No warnings." in found
    assert "touch along lines" in " ".join(found.split())


@pytest.mark.parametrize("error", ["0.0", "0.01"])
def test_check_says_in_words_that_generators_are_parallel(error: str, tmp_path: Path) -> None:
    path, (layout, errors) = tmp_path / "pair.toml", builtin_text(NAME).split("[errors]")
    tilted = errors.replace("shaft_angle_deg = 0.0", f"shaft_angle_deg = {error}")
    path.write_text(f"{layout}[errors]{tilted}")
    found = run("check", path).stdout
    assert "parallel on both flanks without errors: line contact" in found
    assert "nan" not in found


def test_lines_without_an_ellipse_are_a_note() -> None:
    found = run("tca", NAME, "--points", "3", "--force", "1000").stdout
    assert "flanks that touch along lines have no ellipse" in found
    assert "warning" not in found.lower().replace("no warnings", "")


def test_lines_in_text_json_and_csv() -> None:
    design = builtin_design(NAME)
    lines = contact_lines(path_of_contact(design, "left", 5))
    arguments = "tca", NAME, "--flank", "left", "--points", "5"
    text = " ".join(run(*arguments).stdout.split())
    assert f"transverse {float(lines.transverse_ratio):.6f} at mid-face" in text
    assert f"total {float(lines.total_ratio):.6f}" in text
    data = json.loads(run(*arguments, "--json").stdout)["contact_lines"]
    np.testing.assert_array_equal(data["length"], lines.length)
    np.testing.assert_array_equal(data["point"], lines.point)
    assert data["overlap_ratio"] == float(lines.overlap_ratio)
    limits = {limit for row in data["limit"] for limit in row}
    assert limits <= {"gear_toe", "gear_heel", "gear_tip", "pinion_tip"}
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--csv").stdout)))
    assert [float(row["line_length_mm"]) for row in rows] == lines.length.tolist()
    assert [row["line_first_limit"] for row in rows] == [row[0] for row in data["limit"]]
    assert "contact_lines" not in json.loads(run("tca", NAME, *PARABOLA, "--points", "5", "--json").stdout)


def test_operation_names_lines_and_not_their_ends() -> None:
    data = json.loads(run("operation", NAME, "--points", "3", "--json").stdout)
    assert set(data["positions"]["carried_by"]) == {"a line"}
    assert data["edge_share"] == 0.0
    assert data["operating_contact_ratio"] == data["contact_ratio"]


def test_meshes_are_written(tmp_path: Path) -> None:
    out = tmp_path / "pair.vtu"
    result = run("mesh", NAME, "--part", "pair", "--out", out, "--tolerance", "0.2")
    assert result.exit_code == 0, result.output
    assert out.stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("place",), "so that it has no middle to place: give the pair a shaft angle"),
        (("place", *PARABOLA), "runs along the whole face, with parabolas too"),
        (("tolerance", "--shaft-angle-tolerance-deg", "0.01"), "every error of it puts the contact on an"),
    ],
)
def test_what_has_no_meaning_is_refused_in_a_line(arguments: tuple[str, ...], words: str) -> None:
    command, *rest = arguments
    assert words in refused(command, NAME, *rest)


def test_equal_hands_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(builtin_text(NAME).replace("helix_angle_deg = 0.0", "helix_angle_deg = 10.0"))
    said = "helix_angle_deg must be -10.0 deg, opposite to that of [pinion], got 10.0: teeth of equal hands"
    assert said in refused("check", path)
