"""The CSV of commands that judge a design: units in the headers, the numbers of the JSON."""

from __future__ import annotations

import csv
import io
import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

from beveloid_geom.analysis.sensitivity import ERRORS, path_sensitivity
from beveloid_geom.design.file import builtin_design
from beveloid_geom.studies.statement_readings import readings_of
from beveloid_geom.studies.statements import paper_statements

COMMAND = Path(sys.executable).with_name("beveloid-geom")
MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")
OPTIMISE = ("optimise", "--offset", "0.05", "--pinion-bounds", "0", "0.0005", "--gear-bounds", "-0.0005", "0")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False, timeout=120)


def rows_of(*arguments: str) -> list[dict[str, str]]:
    done = run(*arguments, "--csv")
    assert (done.returncode, done.stderr) == (0, "")
    return list(csv.DictReader(io.StringIO(done.stdout)))


@pytest.mark.parametrize(
    "command", [("sensitivity",), ("statements",), ("statements", "--readings"), ("check",), OPTIMISE]
)
def test_one_format_at_a_time(command: tuple[str, ...]) -> None:
    done = run(*command, "--csv", "--json")
    assert (done.returncode, done.stdout) == (2, "")
    assert "--json and --csv exclude each other" in done.stderr


def test_sensitivity() -> None:
    found = path_sensitivity(builtin_design().with_parabola(0.001, -0.001), "left")
    rows = rows_of("sensitivity", "--flank", "left", *MODIFIED)
    assert len(rows) == 5 * 6 + 3 + 3
    units = ("mm", "rad", "mm", "mm")
    heads = [f"by_{error}_per_{unit}" for error, unit in zip(ERRORS, units, strict=True)]
    by = {(row["quantity"], row["place"], row["member"]): row for row in rows}
    for key, expected in (
        (("z_mm", "leave", "gear"), found.z_by[2, 1]),
        (("square_shift_mm", "middle", "pinion"), found.square_shift_by[1, 0]),
        (("pinion_roll_rad", "enter", "pinion"), found.pinion_roll_by[0]),
        (("peak_to_peak_rad", "", ""), found.peak_to_peak_by),
    ):
        assert [float(by[key][head]) for head in heads] == expected.tolist()
    assert float(by["z_mm", "leave", "gear"]["value"]) == found.z[2, 1]
    assert by["face_shift_mm", "middle", "gear"]["value"] == ""
    backlash = by["mounted_backlash_mm", "", ""]
    assert float(backlash["value"]) == pytest.approx(0.03956, abs=1e-5)
    assert 0.7 < float(backlash["by_offset_per_mm"]) < 0.75


def test_sensitivity_without_a_path() -> None:
    done = run("sensitivity", "--offset-error", "20", "--csv")
    assert done.returncode == 1
    assert done.stdout.splitlines() == [done.stdout.strip()]
    assert "off flank" in done.stderr


def test_statements() -> None:
    rows, data = rows_of("statements", "--flank", "right"), json.loads(run("statements", "--json").stdout)
    for one in data[:16]:
        own = [row for row in rows if row["id"] == one["id"]]
        assert {row["verdict"] for row in own} == {one["verdict"]}
        assert {row["measure"] for row in own} == {one["measure"]}
        for claim, values in one["values"].items():
            ours = [row for row in own if row["claim"] == claim]
            numbers = [float(row["value"]) for row in ours if row["kind"] == "number"]
            assert numbers == [value for row in values["numbers"].values() for value in row]
            answers = {row["way"]: row["value"] for row in ours if row["kind"] == "holds"}
            assert answers == {
                way: {True: "yes", False: "no"}[holds] for way, holds in values["holds"].items()
            }


@pytest.mark.slow
def test_readings() -> None:
    rows = rows_of("statements", "--readings", "--flank", "left")
    readings = readings_of(builtin_design())
    assert [row["reading"] for row in rows] == [one.name for one in readings]
    for row, one in list(zip(rows, readings, strict=True))[:2]:
        judged = paper_statements(one.design, "left", sign=one.sign)
        found = {statement.id: statement.verdict.value for statement in judged}
        assert row == {"flank": "left", "reading": one.name, **found}


def test_optimum() -> None:
    found, given = rows_of(*OPTIMISE)
    data = json.loads(run(*OPTIMISE, "--json").stdout)
    for row, name in ((found, "found"), (given, "given")):
        assert row["design"] == name
        assert float(row["shift_mm"]) == pytest.approx(data[name]["shift"], rel=1e-9)
        assert float(row["peak_to_peak_rad"]) == pytest.approx(
            data[name]["peak_to_peak"], rel=1e-9, abs=1e-14
        )
    assert float(found["parabola_gear_per_mm"]) == data["parabola"]["gear"]
    assert float(given["parabola_gear_per_mm"]) == 0.0


def test_check() -> None:
    rows = {(row["group"], row["quantity"]): row for row in rows_of("check")}
    data = json.loads(run("check", "--json").stdout)
    assert float(rows["closing", "offset"]["value"]) == data["closing"]["offset"]
    assert float(rows["design", "dw2"]["value"]) == data["mounting"]["dw2"]
    ideal = data["zero_backlash"]
    assert float(rows["zero_backlash", "gear_mounting"]["value"]) == ideal["mounting"][1]
    assert rows["zero_backlash", "shaft_angle"]["unit"] == "rad"
    assert math.degrees(float(rows["design", "shaft_angle"]["value"])) == pytest.approx(15.0)
    assert ("remark", "warning") not in rows


def test_check_has_its_warnings() -> None:
    warned = [row for row in rows_of("check", "--parabola-pinion=-0.01") if row["group"] == "remark"]
    assert any("undercut" in row["value"] and row["quantity"] == "warning" for row in warned)
