"""Output of `gear-data`: rolls, spans, datum faces, missing balls."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.running import csv_of, json_of, refused, run, words_of

CYLINDRICAL = {f"cone_angle_deg = {angle}": "cone_angle_deg = 0.0" for angle in ("3.0", "0.8")}
SMALL = {
    "normal_module = 6.0": "normal_module = 0.05",
    "face_width = 50.0": "face_width = 0.4",
    "face_width = 60.0": "face_width = 0.5",
    "offset = 229.0": "offset = 1.908333",
}
JAMMED = {"offset = 229.0": "offset = 226.5"}


def test_cylindrical_gears_have_rolls_and_a_span(design_file: Callable[..., Path]) -> None:
    """For an odd number of teeth the dimension over rolls exceeds that over balls by d_K (1 - cos(pi /
    2N))."""
    path = design_file(CYLINDRICAL)
    arguments = ("gear-data", path, "--pinion-allowances", "-0.05", "-0.1", "--gear-span", "6")
    data = json_of(*arguments)
    pinion, gear = data["pinion"], data["gear"]
    over_rolls, over_balls = pinion["roll_dimension"]["nominal"][1], pinion["ball_dimension"]["nominal"][1]
    across = over_rolls - pinion["ball_diameter"]
    assert over_rolls - over_balls == pytest.approx(across * (1.0 - math.cos(0.5 * math.pi / 29.0)), rel=1e-9)
    lower = pinion["span"]["nominal"] - pinion["span"]["lower"]
    assert lower == pytest.approx(0.1 * math.cos(math.radians(20.0)), rel=1e-9)
    assert (gear["span_teeth"], gear["span_status"]["nominal"]) == (6, "measured")
    text = words_of(*arguments)
    assert f"over {pinion['span_teeth']} teeth {pinion['span']['nominal']:.4f} mm, upper" in text
    assert "over rolls of" in text
    row = csv_of(*arguments)[3]
    assert float(row["span_mm"]) == gear["span"]["nominal"]
    assert float(row["roll_dimension_mm"]) == gear["roll_dimension"]["nominal"][0]
    assert "--pinion-span must be between 1 and 28, got 29" in refused(
        "gear-data", path, "--pinion-span", "29"
    )


def test_reasons_for_missing_rolls_and_spans(design_file: Callable[..., Path]) -> None:
    text = words_of("gear-data")
    assert "span not defined on a cone: the base helix angles of right and left flanks differ" in text
    assert "rolls not defined on a cone" in text
    assert json_of("gear-data")["gear"]["span_status"]["nominal"] == "cone"
    bent = words_of("gear-data", design_file(CYLINDRICAL), "--parabola-gear", "0.001")
    assert "span not defined on flanks with a parabola" in bent


def test_pointed_teeth_are_reported(design_file: Callable[..., Path]) -> None:
    """The flanks of a pinion with a large profile shift intersect below its tip, first at the heel."""
    part = words_of("gear-data", design_file({"profile_shift = 0.17": "profile_shift = 2.0"}))
    assert "pointed tooth the flanks intersect below the tip diameter from z = " in part
    complete = words_of("gear-data", design_file({"profile_shift = 0.17": "profile_shift = 2.2"}))
    assert "intersect below the tip diameter along the complete face" in complete
    assert "pointed" not in words_of("gear-data")


def test_axial_distances() -> None:
    """Axial distances are the mounting distances of Table 1, 211.594669 and 210.211869 mm, plus or minus half
    the face width, and the distance of a given datum face."""
    data = json_of("gear-data", "--pinion-datum", "-40")
    assert data["pinion"]["axial_distance"] == pytest.approx([186.594669, 211.594669, 236.594669], abs=1e-6)
    assert data["gear"]["axial_distance"] == pytest.approx([180.211869, 210.211869, 240.211869], abs=1e-6)
    assert data["pinion"]["datum"] == pytest.approx({"z": -40.0, "axial_distance": 171.594669}, abs=1e-6)
    assert "datum" not in data["gear"]
    text = run("gear-data", "--pinion-datum", "-40").stdout
    assert "datum face         at z = -40.0000 mm: 171.5947 mm from the common perpendicular" in text
    rows = csv_of("gear-data", "--pinion-datum", "-40")
    assert [row["datum_z_mm"] for row in rows] == ["-40.0"] * 3 + [""] * 3


def test_gear_data_without_a_usual_ball(design_file: Callable[..., Path]) -> None:
    """At module 0.05 the smallest usual ball, 0.17 mm, is too large: the message asks for a diameter, and
    other data are printed."""
    path = design_file(SMALL)
    text = words_of("gear-data", path)
    assert "give a diameter with --pinion-ball" in text
    assert "give a diameter with --gear-ball" in text
    assert "chordal thickness" in text
    assert "nan" not in text
    data = json_of("gear-data", path)
    assert data["pinion"]["ball_diameter"] is None
    assert data["pinion"]["chordal_thickness"]["nominal"][1] == pytest.approx(9.4832 * 0.05 / 6.0, rel=1e-3)
    given = json_of("gear-data", path, "--pinion-ball", "0.0875")
    assert given["pinion"]["ball_status"]["nominal"] == ["measured"] * 3
    assert len(csv_of("gear-data", path, "--pinion-ball", "0.0875")) == 6


def test_unknown_backlash(design_file: Callable[..., Path]) -> None:
    """If a tip reaches the bottom land of the mate, there is no first contact, and the backlash is printed as
    not known."""
    text = words_of("gear-data", design_file(JAMMED))
    assert "as mounted not known: " in text
    assert "nan" not in text
