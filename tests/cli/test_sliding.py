"""The command `beveloid-geom sliding` and its figure: their numbers are the library's."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner, Result

from beveloid_geom.analysis.sliding import sliding_of
from beveloid_geom.cli.main import main
from beveloid_geom.contact.path import path_of_contact
from beveloid_geom.design.file import builtin_design
from beveloid_geom.design.model import Errors
from beveloid_geom.report.sliding import sliding_report
from beveloid_viz.figures.results.sliding import RECIPES
from beveloid_viz.stage import theme


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["sliding", *arguments])


def test_json_and_csv_hold_the_result_of_the_library() -> None:
    result = run("--json", "--points", "5", "--flank", "left", "--parabola-pinion", "0.001")
    assert (result.exit_code, result.stderr) == (0, "")
    data = json.loads(result.stdout)
    design = builtin_design().with_parabola(pinion=0.001)
    found = sliding_of(path_of_contact(design, "left", 5))
    positions = data["positions"]
    assert positions["speed"] == found.speed.tolist()
    assert positions["gear_specific"] == found.specific[:, 1].tolist()
    assert positions["sliding"] == found.sliding.tolist()
    assert positions["status"] == ["solved"] * 5
    assert data["layout"]["offset"] == 229.0
    assert data["least_sliding"]["speed"] == data["range"]["speed"][0] < min(positions["speed"])
    assert data["range"]["pinion_specific"] == pytest.approx([found.specific[0, 0], found.specific[-1, 0]])
    assert data["ends"]["enter"] == {"member": "gear", "limit": "tip"}
    same = run("--csv", "--points", "5", "--flank", "left", "--parabola-pinion", "0.001")
    rows = list(csv.DictReader(io.StringIO(same.stdout)))
    assert [float(row["speed_mm_per_rad"]) for row in rows] == positions["speed"]
    assert [float(row["pinion_specific"]) for row in rows] == positions["pinion_specific"]
    assert [float(row["sliding_z_mm_per_rad"]) for row in rows] == found.sliding[:, 2].tolist()
    assert {"gear_roll_rad", "pinion_z_mm", "gear_rate", "status"} <= set(rows[0])


def test_ranges_do_not_depend_on_the_positions_asked_for() -> None:
    few, many = (sliding_report("", builtin_design(), "right", points) for points in (2, 301))
    assert few.ranges == many.ranges
    assert (few.least_roll, few.pitch_roll) == (many.least_roll, many.pitch_roll)
    assert few.columns["speed"].shape == (2,)


def test_table_says_it_in_words() -> None:
    text = run("--points", "3").stdout
    assert "24.7209 to 34.9430 mm/rad, least at 9.4857 deg of pinion roll" in text
    assert "pinion -0.9495 to 0.4300, gear -0.9408 to 0.5551" in text
    assert "enters at the gear's tip, leaves at the pinion's tip" in text
    assert max(len(line) for line in text.splitlines()) <= 100


def test_no_contact_says_why() -> None:
    result = run("--offset-error", "50")
    assert result.exit_code == 1
    assert result.stderr == "No contact: the path of contact does not meet the right flanks\n"
    result = run("--offset-error", "50", "--json")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["positions"]["speed"], data["range"]["speed"]) == (1, [], [None, None])
    assert data["reason"] == "the path of contact does not meet the right flanks"
    assert run("--offset-error", "50", "--csv").stdout.count("\n") == 1


@pytest.mark.parametrize(
    "arguments", [["--json", "--csv"], ["--points", "1"], ["--flank", "both"]], ids=" ".join
)
def test_wrong_command_line(arguments: list[str]) -> None:
    result = run(*arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1


@pytest.mark.parametrize(("offset", "lost"), [(0.0, 0), (1.6, 1), (50.0, 2)])
def test_figure_has_the_numbers_or_the_reason(offset: float, lost: int) -> None:
    recipe, design = RECIPES["sliding"], builtin_design().with_errors(Errors(offset=offset))
    data = recipe.compute(design)
    with theme.style():
        page = recipe.draw(data, (400, 300)).page
    words = [" ".join(text.get_text().split()) for axes in page.axes for text in axes.texts]
    assert sum(text.startswith("no contact: the path of contact does not meet") for text in words) == 2 * lost
    assert sum(text == "pitch point" for text in words) == 2 - lost
    header, body = recipe.rows(data)
    rows = [dict(zip(header, row, strict=True)) for row in body]
    drawn = [row for row in rows if not row["reason"]]
    assert len(rows) - len(drawn) == 2 * lost
    if offset == 0.0:
        found = sliding_of(path_of_contact(design, "right", 201))
        shown = [row["pinion_specific"] for row in drawn if row["flank"] == "right"][:201]
        np.testing.assert_array_equal(shown, found.specific[:, 0])
