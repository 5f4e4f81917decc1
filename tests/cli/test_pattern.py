"""The command `beveloid-geom pattern`: its numbers are the library's, its refusals say what to do."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner, Result

from beveloid_geom.cli.main import main
from beveloid_geom.design.file import builtin_design
from beveloid_geom.operation.pattern import contact_pattern

MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001", "--resolution", "2")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["pattern", *arguments])


def test_json_and_csv_hold_the_result_of_the_library() -> None:
    design = builtin_design().with_parabola(0.001, -0.001)
    pattern = contact_pattern(design, "left", 0.01, resolution=2.0)
    arguments = (*MODIFIED, "--flank", "left", "--separation", "0.01")
    data = json.loads(run(*arguments, "--json").stdout)
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--csv").stdout)))
    assert (data["separation"], data["roll_range"]) == (0.01, list(pattern.roll_range))
    for member, side in (("pinion", pattern.pinion), ("gear", pattern.gear)):
        z = side.z[side.marked]
        sizes = {"area": side.area, "area_share": side.area_share, "area_error": side.area_error}
        assert data[member] == {**sizes, "z_range": [z.min(), z.max()]}
        own = [row for row in rows if row["member"] == member]
        least = np.array([float(row["least_mm"] or "nan") for row in own])
        np.testing.assert_array_equal(least, side.least.ravel())
        assert [row["marked"] == "1" for row in own] == side.marked.ravel().tolist()
        assert {float(row["area_mm2"]) for row in own} == {side.area}
        assert {float(row["area_error"]) for row in own} == {side.area_error}


def test_table_of_table_1() -> None:
    """The unmodified right flanks are in approximate line contact: compound covers nearly all."""
    text = run("--resolution", "0.4").stdout
    assert "621.8 mm^2 marked, 94.6 % of the active flank" in text
    assert "right to 0.27 % of the area" in text
    assert all(len(line) <= 100 for line in text.splitlines())


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--resolution", "0.01"), 2, "resolution 0.01 mm is too fine"),
        (("--separation", "0"), 2, "--separation"),
        (("--json", "--csv"), 2, "exclude each other"),
        (("--parabola-pinion", "-0.01"), 1, "no pattern: the first contact of the right flanks is not known"),
        (("--parabola-pinion", "0.01"), 1, "no pattern: "),
    ],
)
def test_what_cannot_be_had_is_one_line(arguments: tuple[str, ...], code: int, words: str) -> None:
    result = run(*arguments)
    assert (result.exit_code, result.stdout) == (code, "")
    assert words in result.stderr
    assert result.stderr.count("Error: ") == 1
