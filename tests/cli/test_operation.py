"""The command `beveloid-geom operation`: its numbers are the library's, its words are right."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from beveloid_geom.cli.main import main
from beveloid_geom.design.file import builtin_design
from beveloid_geom.operation.mesh_cycle import mesh_cycle
from beveloid_geom.operation.operating_ratio import operating_ratio

MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["operation", *arguments])


@pytest.fixture(scope="module")
def data() -> Any:
    result = run("--json", "--points", "25", "--harmonics", "6", "--film", "0.01", *MODIFIED)
    assert (result.exit_code, result.stderr) == (0, "")
    return json.loads(result.stdout)


def test_json_holds_the_result_of_the_library(data: Any) -> None:
    design = builtin_design().with_parabola(0.001, -0.001)
    cycle = mesh_cycle(design, "right", 6)
    assert data["contact_ratio"] == pytest.approx(1.816308, abs=5e-7)
    assert data["operating_contact_ratio"] == pytest.approx(1.0, abs=1e-8)
    film = data["operating_contact_ratio_within_film"]
    assert film == pytest.approx(float(operating_ratio(design, "right", 0.01)), abs=1e-12)
    assert data["peak_to_peak"] == float(cycle.peak_to_peak)
    np.testing.assert_array_equal(data["amplitudes"], np.abs(cycle.harmonics))
    assert data["layout"]["offset"] == 229.0


def test_positions_cover_one_cycle(data: Any) -> None:
    positions = data["positions"]
    roll, error = (np.array(positions[name]) for name in ("pinion_roll", "transmission_error"))
    assert roll[-1] - roll[0] == pytest.approx(2.0 * math.pi / 29, abs=1e-12)
    assert error[-1] == pytest.approx(error[0], abs=1e-12)
    assert positions["pair"][-1] == positions["pair"][0] - 1
    assert set(positions["carried_by"]) == {"flanks", "gear tip"}
    assert set(positions["status"]) == {"solved"}


def test_csv_has_units_and_a_row_for_each_position(data: Any) -> None:
    result = run("--csv", "--points", "25", *MODIFIED)
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    assert [float(row["transmission_error_rad"]) for row in rows] == data["positions"]["transmission_error"]
    assert [row["carried_by"] for row in rows] == data["positions"]["carried_by"]


def test_table_says_it_in_words() -> None:
    text = run("--points", "25", *MODIFIED).stdout
    assert "1.816308 by Eq. 16; in operation 1.000000, 2.299395 within 6.35 um" in text
    assert "1.8107 arcsec peak to peak" in text
    assert "carry 18.1 % of the cycle" in text
    assert text.rstrip().endswith("gear tip")
    assert max(len(line) for line in text.splitlines()) <= 100


def test_a_cycle_that_is_not_known_says_why() -> None:
    result = run("--parabola-pinion", "-0.01")
    assert result.exit_code == 1
    assert result.stderr == "No contact: no first contact of the right teeth: a member is undercut\n"
    reason = json.loads(run("--json", "--parabola-pinion", "-0.01").stdout)["reason"]
    assert reason in result.stderr


def test_a_tool_without_a_fitting_round_is_named() -> None:
    result = run("--parabola-pinion", "0.01")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("Error: no first contact: pinion: tip_radius 0.38 is too large")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["--json", "--csv"],
        ["--film", "-1"],
        ["--film", "thick"],
        ["--harmonics", "0"],
        ["--points", "1"],
        ["--flank", "both"],
    ],
    ids=" ".join,
)
def test_wrong_command_line(arguments: list[str]) -> None:
    result = run(*arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1
