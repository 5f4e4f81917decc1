"""Texts, tables and exit statuses of `map`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.cli.result_cases import MODIFIED, OFFSET
from tests.cli.running import csv_of, json_of, run, strict_json, words_of


def test_cells_of_a_map_without_a_path_are_empty() -> None:
    given = [
        "map",
        "--over",
        "mounting",
        "--steps",
        "2",
        "--pinion-bounds",
        "0",
        "60",
        "--gear-bounds",
        "0",
        "1",
    ]
    rows, data = csv_of(*given), json_of(*given)
    assert [row["status"] for row in rows] == ["solved", "solved", "off_flank", "off_flank"]
    assert (rows[2]["contact_ratio"], data["map"]["contact_ratio"][1]) == ("", [None, None])
    assert float(rows[2]["normal_backlash_mm"]) > 0.0
    assert list(rows[0])[:2] == ["pinion_mounting_change_mm", "gear_mounting_change_mm"]


def test_symbols_of_the_layout() -> None:
    """E and Sigma are the offset and the shaft angle of the layout, in any order."""
    first, second = ("--pinion-bounds", "228.9", "229.1"), ("--gear-bounds", "0.261", "0.2625")
    expected = csv_of("map", "--steps", "2", "--over", "offset,shaft-angle", *first, *second)
    assert csv_of("map", "--steps", "2", "--over", "E,Sigma", *first, *second) == expected
    swapped = ("--pinion-bounds", *second[1:], "--gear-bounds", *first[1:])
    rows = csv_of("map", "--steps", "2", "--over", "sigma, e", *swapped)
    assert sorted(row["contact_ratio"] for row in rows) == sorted(row["contact_ratio"] for row in expected)


@pytest.mark.parametrize("over", ["mounting", "shift"])
def test_texts_of_other_maps(over: str) -> None:
    result = run("map", "--over", over, "--steps", "4", *MODIFIED)
    assert result.exit_code == 0
    assert "the backlash is negative" in " ".join(result.stdout.split())
    assert "C3" not in result.stdout
    assert result.stdout.startswith("Map of ni-2017 over the ")
    errors = "errors for shift   offset +/-0.05 mm, shaft angle +/-0.01 deg, pinion axial +/-0.1 mm"
    assert errors in result.stdout


def test_positions_in_a_map_have_the_digits_of_its_step() -> None:
    bounds = ("--pinion-bounds", "228.95", "229.05", "--gear-bounds", "0.26175", "0.26185")
    text = run("map", "--over", "offset,shaft_angle", *bounds, "--steps", "3").stdout
    heading, row = (
        next(line for line in text.splitlines() if word in line) for word in ("smallest", "contact ratio")
    )
    assert heading.split() == ["smallest", "offset", "shaft_angle", "largest", "offset", "shaft_angle"]
    assert row.split()[3:5] == ["229.05", "0.26175"]
    assert heading.index("offset") + len("offset") == row.index("229.05") + len("229.05")


def test_map_without_a_contact_ratio_and_map_in_operation(design_file: Callable[..., Path]) -> None:
    source = design_file({f"face_width = {width}.0": "face_width = 0.1" for width in (50, 60)})
    result = run("map", source, "--steps", "4")
    assert result.exit_code == 0
    assert "The design has no contact ratio" in result.stdout
    bounds = ("--pinion-bounds", "-0.0005", "0.0005", "--gear-bounds", "-0.0005", "0")
    found = strict_json(run("map", "--operation", "--steps", "2", "--json", *bounds, *OFFSET).stdout)
    shares = np.array(found["map"]["edge_share"])
    assert shares[0, 0] == 0.0
    assert ((shares >= 0.0) & (shares <= 1.0)).all()


def test_a_map_whose_cells_have_no_common_normal_has_no_contact() -> None:
    """`tca` has exit status 1 for the offset 230 mm and the shaft angle 0.25 rad, 14.3239448783 deg."""
    over = ("map", "--over", "offset,shaft_angle", "--pinion-bounds", "228", "230", "--steps", "3")
    result = run(*over, "--gear-bounds", "0.25", "0.27")
    assert result.exit_code == 1
    words = "no cell of the map has a path on the right flanks, in 3 the flanks have no common normal"
    assert result.stderr == f"No contact: {words}\n"


def test_a_map_names_its_backlash_and_counts_the_cells_in_which_it_is_unknown() -> None:
    """With both coefficients at 0.002 1/mm the map does not know the backlash, and `check` reports a jam."""
    given = ("map", "marine-gearbox", "--steps", "3")
    text, rows = words_of(*given), csv_of(*given)
    unknown = [row for row in rows if not row["mounted_backlash_mm"]]
    assert [(float(row["parabola_pinion_per_mm"]), row["jammed"]) for row in unknown] == [(0.002, "0")]
    assert "in 1 the mounted backlash is unknown" in text
    assert "of the flanks without edge contact, as in `tolerance`" in text
    cell = ("--parabola-pinion", "0.002", "--parabola-gear", "0.002")
    assert run("check", "marine-gearbox", *cell).stderr.startswith("Jammed: ")
    known = ("--pinion-bounds", "-0.002", "-0.001", "--gear-bounds", "-0.002", "-0.001")
    assert "unknown" not in run(*given, *known).stdout
