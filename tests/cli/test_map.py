"""The command `beveloid-geom map`, as installed: its numbers are the library's, its words are right."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom.analysis.maps import FIGURES, map_of
from beveloid_geom.cli.main import main
from beveloid_geom.design.file import builtin_design, builtin_text
from beveloid_geom.design.model import Errors

COMMAND = Path(sys.executable).with_name("beveloid-geom")
SMALL = ("--steps", "3", "--offset", "0.05")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, "map", *arguments], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def data() -> Any:
    result = run("--json", *SMALL)
    assert (result.returncode, result.stderr) == (0, "")
    return json.loads(result.stdout)


def test_json_holds_the_map_of_the_library(data: Any) -> None:
    found = map_of(builtin_design(), "parabola", steps=3, errors=Errors(offset=0.05))
    assert data["over"] == "parabola"
    assert data["errors"] == vars(Errors(offset=0.05))
    assert data["pinion"] == found.pinion.tolist()
    for name in FIGURES:
        values = np.array(data["map"][name], dtype=float)
        np.testing.assert_allclose(values, getattr(found, name), rtol=1e-9, atol=1e-12)
    assert data["map"]["hollow"][2] == [False, True, True]
    assert data["map"]["status"] == [["solved"] * 3] * 3
    assert data["map"]["contact_ratio"][2][0] == pytest.approx(1.816308, abs=5e-7)
    assert data["layout"]["offset"] == 229.0
    assert data["normal_backlash"] == pytest.approx(0.041589, abs=1e-6)


def test_csv_has_units_and_a_row_for_each_cell(data: Any) -> None:
    result = run("--csv", *SMALL)
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    assert len(rows) == 9
    assert list(rows[0])[:3] == ["parabola_pinion_per_mm", "parabola_gear_per_mm", "status"]
    shift = [float(row["shift_mm"]) for row in rows]
    np.testing.assert_allclose(shift, np.ravel(data["map"]["shift"]), rtol=1e-9)
    assert (rows[6]["parabola_pinion_per_mm"], rows[6]["parabola_gear_per_mm"]) == ("0.001", "-0.001")
    assert {row["flank_share"] for row in rows} == {""}


def test_what_is_lost_is_empty_in_csv_and_null_in_json() -> None:
    arguments = ("--over", "mounting", "--pinion-bounds", "0", "60", "--gear-bounds", "0", "1", *SMALL[2:])
    rows = list(csv.DictReader(io.StringIO(run("--csv", "--steps", "2", *arguments).stdout)))
    assert [row["status"] for row in rows] == ["solved", "solved", "off_flank", "off_flank"]
    assert rows[2]["contact_ratio"] == ""
    assert float(rows[2]["normal_backlash_mm"]) > 0.0
    shown = json.loads(run("--json", "--steps", "2", *arguments).stdout)["map"]
    assert shown["contact_ratio"][1] == [None, None]


def test_table_says_it_in_words() -> None:
    result = run("--steps", "5", "--offset", "0.05", "--shaft-angle-deg", "0.01")
    words = " ".join(result.stdout.split())
    assert "Map of ni-2017 over the parabola coefficients, right flanks: 5 x 5 cells" in words
    assert "errors for shift offset +0.05 mm, shaft angle +0.01 deg values pinion -0.001 to 0.001" in words
    assert "25 solved, in 10 the flanks are hollow against each other" in words
    assert "Of the 15 cells neither hollow nor with negative backlash" in words
    assert "at least 1.6510, that of the design (pinion 0, gear 0): C1 no such cell" in words
    assert "backlash, mm 0.0416 in all of them" in words
    assert max(len(line) for line in result.stdout.splitlines()) <= 100


def test_a_design_without_contact_sets_no_contact_ratio(tmp_path: Path) -> None:
    source = tmp_path / "thin.toml"
    text = builtin_text().replace("face_width = 50.0", "face_width = 0.1")
    source.write_text(text.replace("face_width = 60.0", "face_width = 0.1"), encoding="utf-8")
    result = run(str(source), "--steps", "4")
    assert result.returncode == 0
    assert "The design itself has no contact ratio to be kept" in result.stdout
    assert "Least shift" not in result.stdout


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_a_parabola_is_not_ignored_where_the_map_is_over_it(member: str) -> None:
    done = CliRunner().invoke(main, ["map", "--steps", "2", f"--parabola-{member}", "0.001"])
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr == (
        f"Error: --parabola-{member}: the map itself is over the parabola coefficients: "
        f"give --{member}-bounds, or another --over\n"
    )


@pytest.mark.parametrize("over", ["mounting", "shift"])
def test_tables_of_other_maps(over: str) -> None:
    result = run("--over", over, "--steps", "4", "--parabola-pinion", "0.001", "--parabola-gear", "-0.001")
    assert result.returncode == 0
    assert "the backlash is negative" in " ".join(result.stdout.split())
    assert "C3" not in result.stdout
    assert "errors for shift   offset +0.05 mm, shaft angle +0.01 deg, pinion axial +0.1 mm" in result.stdout
    assert max(len(line) for line in result.stdout.splitlines()) <= 100


def test_first_contacts_are_asked_for() -> None:
    bounds = ("--pinion-bounds", "-0.0005", "0.0005", "--gear-bounds", "-0.0005", "0")
    result = run("--first-contacts", "--steps", "2", "--json", *bounds, "--offset", "0.05")
    shares = np.array(json.loads(result.stdout)["map"]["flank_share"])
    assert shares[0, 0] == 1.0
    assert ((shares >= 0.0) & (shares <= 1.0)).all()


def test_no_contact_is_said_and_is_status_1() -> None:
    result = run("--offset-error", "30", *SMALL)
    assert result.returncode == 1
    assert result.stderr == "No contact: no cell of the map has a path on the right flanks\n"
    assert "9 off flank" in result.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["--json", "--csv"],
        ["--over", "colour"],
        ["--steps", "1"],
        ["--pinion-bounds", "0"],
        ["--pinion-bounds", "1", "0"],
        ["--gear-bounds", "-0.1", "0.1"],
        ["--gear-bounds", "nan", "0.1"],
        ["--over", "shift", "--gear-bounds", "0", "4"],
        ["--offset", "300"],
        ["--flank", "both"],
        ["missing.toml"],
    ],
    ids=" ".join,
)
def test_wrong_command_line(arguments: list[str]) -> None:
    result = CliRunner().invoke(main, ["map", *arguments])
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1
