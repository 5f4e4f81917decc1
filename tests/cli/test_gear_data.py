"""Output of `gear-data`: rolls, spans, datum faces, missing balls."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from beveloid_geom.design.file import builtin_text
from tests.cli.running import rows_of, run, strict_json

CYLINDRICAL = {"cone_angle_deg = 3.0": "cone_angle_deg = 0.0", "cone_angle_deg = 0.8": "cone_angle_deg = 0.0"}
SMALL = {
    "normal_module = 6.0": "normal_module = 0.05",
    "face_width = 50.0": "face_width = 0.4",
    "face_width = 60.0": "face_width = 0.5",
    "offset = 229.0": "offset = 1.908333",
}
JAMMED = {"offset = 229.0": "offset = 226.5"}


@pytest.fixture
def written(tmp_path: Path) -> Callable[[Mapping[str, str]], Path]:
    """Return a function that writes the built-in design with pieces of text replaced."""

    def write(changes: Mapping[str, str]) -> Path:
        text, path = builtin_text(), tmp_path / "pair.toml"
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new, 1)
        path.write_text(text)
        return path

    return write


def test_cylindrical_gears_have_rolls_and_a_span(written: Callable[[Mapping[str, str]], Path]) -> None:
    """For an odd number of teeth the dimension over rolls exceeds that over balls by d_K (1 - cos(pi /
    2N))."""
    path = written(CYLINDRICAL)
    arguments = ("gear-data", path, "--pinion-allowances", "-0.05", "-0.1", "--gear-span", "6")
    data = strict_json(run(*arguments, "--json").stdout)
    pinion, gear = data["pinion"], data["gear"]
    over_rolls, over_balls = pinion["roll_dimension"]["nominal"][1], pinion["ball_dimension"]["nominal"][1]
    across = over_rolls - pinion["ball_diameter"]
    assert over_rolls - over_balls == pytest.approx(across * (1.0 - math.cos(0.5 * math.pi / 29.0)), rel=1e-9)
    lower = pinion["span"]["nominal"] - pinion["span"]["lower"]
    assert lower == pytest.approx(0.1 * math.cos(math.radians(20.0)), rel=1e-9)
    assert (gear["span_teeth"], gear["span_status"]["nominal"]) == (6, "measured")
    text = " ".join(run(*arguments).stdout.split())
    assert f"over {pinion['span_teeth']} teeth {pinion['span']['nominal']:.4f} mm, upper" in text
    assert "over rolls of" in text
    row = rows_of(run(*arguments, "--csv"))[3]
    assert float(row["span_mm"]) == gear["span"]["nominal"]
    assert float(row["roll_dimension_mm"]) == gear["roll_dimension"]["nominal"][0]
    refused = run("gear-data", path, "--pinion-span", "29")
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "--pinion-span must be between 1 and 28, got 29" in refused.stderr


def test_reasons_for_missing_rolls_and_spans(written: Callable[[Mapping[str, str]], Path]) -> None:
    text = " ".join(run("gear-data").stdout.split())
    assert "span not defined on a cone: the base helix angles of right and left flanks differ" in text
    assert "rolls not defined on a cone" in text
    assert strict_json(run("gear-data", "--json").stdout)["gear"]["span_status"]["nominal"] == "cone"
    bent = " ".join(run("gear-data", written(CYLINDRICAL), "--parabola-gear", "0.001").stdout.split())
    assert "span not defined on flanks with a parabola" in bent


def test_axial_distances() -> None:
    """Axial distances are the mounting distances of Table 1, 211.594669 and 210.211869 mm, plus or minus half
    the face width, and the distance of a given datum face."""
    data = strict_json(run("gear-data", "--pinion-datum", "-40", "--json").stdout)
    assert data["pinion"]["axial_distance"] == pytest.approx([186.594669, 211.594669, 236.594669], abs=1e-6)
    assert data["gear"]["axial_distance"] == pytest.approx([180.211869, 210.211869, 240.211869], abs=1e-6)
    assert data["pinion"]["datum"] == pytest.approx({"z": -40.0, "axial_distance": 171.594669}, abs=1e-6)
    assert "datum" not in data["gear"]
    text = run("gear-data", "--pinion-datum", "-40").stdout
    assert "datum face         at z = -40.0000 mm: 171.5947 mm from the common perpendicular" in text
    rows = rows_of(run("gear-data", "--pinion-datum", "-40", "--csv"))
    assert [row["datum_z_mm"] for row in rows] == ["-40.0"] * 3 + [""] * 3


def test_gear_data_without_a_usual_ball(written: Callable[[Mapping[str, str]], Path]) -> None:
    """At module 0.05 the smallest usual ball, 0.17 mm, is too large: the message asks for a diameter, and
    other data are printed."""
    path = written(SMALL)
    result = run("gear-data", path)
    assert result.exit_code == 0, result.stderr
    text = " ".join(result.stdout.split())
    assert "give a diameter with --pinion-ball" in text
    assert "give a diameter with --gear-ball" in text
    assert "chordal thickness" in text
    assert "nan" not in text
    data = strict_json(run("gear-data", path, "--json").stdout)
    assert data["pinion"]["ball_diameter"] is None
    assert data["pinion"]["chordal_thickness"]["nominal"][1] == pytest.approx(9.4832 * 0.05 / 6.0, rel=1e-3)
    given = strict_json(run("gear-data", path, "--pinion-ball", "0.0875", "--json").stdout)
    assert given["pinion"]["ball_status"]["nominal"] == ["measured"] * 3
    assert len(rows_of(run("gear-data", path, "--pinion-ball", "0.0875", "--csv"))) == 6


def test_unknown_backlash(written: Callable[[Mapping[str, str]], Path]) -> None:
    """If a tip reaches the bottom land of the mate, there is no first contact, and the backlash is printed as
    not known."""
    text = " ".join(run("gear-data", written(JAMMED)).stdout.split())
    assert "as mounted not known: " in text
    assert "nan" not in text
