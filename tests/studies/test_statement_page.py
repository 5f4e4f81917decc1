"""What the page of studies says of the paper's statements is what their run gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import builtin_design, contact_ratio
from beveloid_geom.studies.statement_readings import readings_of
from beveloid_geom.studies.statements import paper_statements

from ..validation.statements_page import AS_GIVEN, FLANKS, cell, found, markdown, ratios, readings, verdicts

pytestmark = pytest.mark.slow
PAGE = (Path(__file__).parents[2] / "beveloid_geom/studies/README.md").read_text(encoding="utf-8")
HEADING = "## The paper, statement by statement"


def cells(table: str) -> list[list[str]]:
    """The cells of a table, without its head."""
    return [line[2:-2].split(" | ") for line in table.splitlines()[2:]]


def test_the_page_holds_the_run() -> None:
    _, heading, rest = PAGE.partition(f"\n{HEADING}\n")
    assert heading, (
        f"the page of studies has no section {HEADING!r}: see `python -m tests.validation.statements_page`"
    )
    section = [line for line in rest.split("\n## ")[0].splitlines() if line.startswith("|")]
    assert section == [line for line in markdown().splitlines() if line]


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


@pytest.mark.parametrize("reading", [0, 2, 7, 8])
def test_ratios_are_those_of_the_design_of_the_reading(reading: int) -> None:
    given = readings_of(builtin_design())[reading]
    size = np.array((-0.0002, -0.0001, -0.00005, 0.0, 0.00005, 0.0001, 0.0002))
    expected = contact_ratio(given.design.with_parabola(given.sign * size, given.sign * size))
    row = cells(ratios())[reading]
    assert row == [given.name, *(f"{value:.3f}" for value in expected)]


def test_cells_fit_a_table() -> None:
    assert "|" not in "".join(cell(one) for flank in FLANKS for one in found()[flank][AS_GIVEN].values())
    assert "nan" not in markdown()
