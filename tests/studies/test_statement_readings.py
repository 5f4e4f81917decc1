"""The paper's statements under other readings: each changes one thing, and says what that does; and what the
page of studies says of statements and readings is what their run gives.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom import Errors, builtin_design, contact_ratio
from beveloid_geom.cli.commands.errors.statements import statements as command
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.statements import ReadingsReport
from beveloid_geom.studies import statement_readings
from beveloid_geom.studies.statement_readings import readings_of
from beveloid_geom.studies.statement_verdicts import Verdict
from beveloid_geom.studies.statements import paper_statements

from ..cli.running import rows_of
from ..oracle.table1 import table1
from ..validation.statements_page import AS_GIVEN, FLANKS, cell, found, markdown, ratios, readings, verdicts


def test_readings_change_one_thing_each() -> None:
    design = table1(errors=Errors(0.1))
    readings = readings_of(design)
    assert readings[0].design == table1()
    assert [one.sign for one in readings].count(-1) == 1
    for one in readings[2:]:
        assert one.design != table1()
        assert one.design.errors == Errors()
        changed = [
            vars(one.design.pair)[name] != value
            for name, value in vars(table1().pair).items()
            if name != "errors"
        ]
        assert any(changed) != (one.design.pinion != table1().pinion), one.name
    for word, sign in (("heels", 1.0), ("toes", -1.0)):
        for step, pair in zip((10.0, 22.5), (r.design.pair for r in readings if word in r.name), strict=True):
            assert pair.pinion_mounting == pytest.approx(211.594669 + sign * step, abs=1e-6)
            assert pair.gear_mounting == pytest.approx(210.211869 + sign * step, abs=1e-6)
    offset, angle, ideal = (one.design.pair for one in readings[-3:])
    assert (offset.offset, offset.shaft_angle) == pytest.approx((229.0751, math.radians(15.0)), abs=1e-4)
    assert (angle.offset, angle.shaft_angle) == pytest.approx((229.0, math.radians(14.9979)), abs=1e-6)
    assert (ideal.offset, ideal.shaft_angle) == pytest.approx((228.8373, math.radians(14.9934)), abs=1e-4)
    assert (ideal.pinion_mounting, ideal.gear_mounting) == pytest.approx((213.305, 211.939), abs=1e-3)
    backlash = mounting_of(readings[-1].design).normal_backlash
    assert float(backlash) == pytest.approx(0.0, abs=1e-9)


def test_layouts_that_do_not_close_are_left_out() -> None:
    """Too thin for a layout without backlash."""
    thin = replace(table1(), pinion=replace(table1().pinion, profile_shift=-3.0))
    assert not any("backlash" in one.name for one in readings_of(thin))
    assert any("backlash" in one.name for one in readings_of(table1()))


def test_a_path_that_toe_or_heel_cut_off_is_what_brings_r1_back() -> None:
    """Mounted so that the path runs off the face a small coefficient turns it back onto it."""
    heels = next(one for one in readings_of(table1()) if one.name == "mounted 22.5 mm to the heels")
    one = {s.id: s for s in paper_statements(heels.design, "right")}["R1"]
    assert one.verdict == Verdict.DEPENDS
    claim = one.claims[0]
    assert claim.holds == {"Eq. 16": True, "Eq. 16 without toe and heel": False}
    row = claim.numbers["Eq. 16"]
    expected = contact_ratio(heels.design.with_parabola(*[np.linspace(0.0, 0.0002, 21)] * 2))
    np.testing.assert_allclose(row, expected, rtol=0.0, atol=1e-12)
    assert row.max() > 1.3 * row[0]
    assert row[-1] < 0.5 * row[0]


def test_readings_of_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three readings: all of them are run for the page of studies."""
    monkeypatch.setattr(statement_readings, "readings_of", lambda design: readings_of(design)[:3])
    result = CliRunner().invoke(command, ["--readings", "--json", "--flank", "right"])
    assert (result.exit_code, result.stderr) == (0, "")
    data = json.loads(result.stdout)
    assert {one["flank"] for one in data} == {"right"}
    assert [one["reading"] for one in data] == [one.name for one in readings_of(builtin_design())[:3]]
    given = {one.id: one.verdict for one in paper_statements(table1(), "right")}
    assert data[0]["verdicts"] == {name: verdict.value for name, verdict in given.items()}
    rows = rows_of(CliRunner().invoke(command, ["--readings", "--csv", "--flank", "right"]))
    assert rows == [{"flank": one["flank"], "reading": one["reading"], **one["verdicts"]} for one in data]
    wide = next(one["verdicts"] for one in data if "wide" in one["reading"])
    assert wide["C2"] == "does not hold"
    table = ReadingsReport("x", {"right": {"as given": given}}).summary()
    assert max(len(row) for row in table.splitlines()) <= 100
    assert table.splitlines()[-1].split()[2:] == list("ymmmy--yymyyymyy")


PAGE = (Path(__file__).parents[2] / "beveloid_geom/studies/README.md").read_text(encoding="utf-8")
HEADING = "## The paper, statement by statement"


def cells(table: str) -> list[list[str]]:
    """The cells of a table, without its head."""
    return [line[2:-2].split(" | ") for line in table.splitlines()[2:]]


@pytest.mark.slow
def test_the_page_holds_the_run() -> None:
    _, heading, rest = PAGE.partition(f"\n{HEADING}\n")
    assert heading, (
        f"the page of studies has no section {HEADING!r}: see `python -m tests.validation.statements_page`"
    )
    section = [line for line in rest.split("\n## ")[0].splitlines() if line.startswith("|")]
    assert section == [line for line in markdown().splitlines() if line]


@pytest.mark.slow
def test_every_statement_stands_with_its_verdicts() -> None:
    rows = cells(verdicts())
    for flank, column in zip(FLANKS, (2, 3), strict=True):
        judged = paper_statements(builtin_design(), flank)
        assert [row[0] for row in rows] == [one.id for one in judged]
        for row, one in zip(rows, judged, strict=True):
            assert row[1] == f"{one.source}: {one.statement.rstrip('.')}"
            assert row[column].startswith(f"**{one.verdict.value}**")
            assert one.detail.endswith(row[column].rpartition("; ")[2])
    assert "not: a small coefficient raises it" in rows[5][2]
    assert "the shift is smaller by 6 of 14 measures" in rows[13][2]


@pytest.mark.slow
def test_readings_name_the_verdicts_they_change_and_no_others() -> None:
    for name, right, left in cells(readings()):
        for flank, words in (("right", right), ("left", left)):
            named: dict[str, str] = {}
            for part in words.split("; ") if words != "nothing" else ():
                ids, _, verdict = part.partition(": ")
                named |= dict.fromkeys(ids.split(", "), verdict)
            before, after = found()[flank][AS_GIVEN], found()[flank][name]
            changed = {id_ for id_ in before if before[id_].verdict != after[id_].verdict}
            assert set(named) == changed
            assert all(after[id_].verdict.value == verdict for id_, verdict in named.items())


@pytest.mark.slow
@pytest.mark.parametrize("reading", [0, 2, 7, 8])
def test_ratios_are_those_of_the_design_of_the_reading(reading: int) -> None:
    given = readings_of(builtin_design())[reading]
    size = np.array((-0.0002, -0.0001, -0.00005, 0.0, 0.00005, 0.0001, 0.0002))
    expected = contact_ratio(given.design.with_parabola(given.sign * size, given.sign * size))
    row = cells(ratios())[reading]
    assert row == [given.name, *(f"{value:.3f}" for value in expected)]


@pytest.mark.slow
def test_cells_fit_a_table() -> None:
    assert "|" not in "".join(cell(one) for flank in FLANKS for one in found()[flank][AS_GIVEN].values())
    assert "nan" not in markdown()
