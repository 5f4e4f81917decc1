"""Output of single commands that is not covered by the contract in test_results."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import (
    Load,
    Status,
    builtin_design,
    contact_pattern,
    path_of_contact,
    path_pressure,
    path_sensitivity,
)
from beveloid_geom.status import Limit
from tests.cli.result_cases import MODIFIED, OFFSET, printed, tolerance_case
from tests.cli.running import csv_of, json_of, refused, rows_of, run, strict_json, words_of

UNFIT = "the first contact could not be computed:"


def test_summary_follows_the_positions() -> None:
    """The summary of `tca` stays visible below a long table."""
    lines = run("tca", *MODIFIED, "--points", "200").stdout.splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("  layout"))
    assert start > 200
    assert lines[-1].startswith(" " * 21) or lines[-1].startswith("  note ")
    assert any(line.startswith("  contact ratio      1.816308") for line in lines[start:])


def test_csv_of_a_path_has_vectors_by_axis() -> None:
    rows, data = rows_of(printed("tca", "csv")), strict_json(printed("tca", "json").stdout)
    points = [[float(row[f"point_{axis}_mm"]) for axis in "xyz"] for row in rows]
    assert points == data["path"]["point"]
    assert {"normal_z", "separation_mm", "mounted_backlash_mm"} <= set(rows[0])


PRESSED = ("tca", *MODIFIED, "--points", "9", "--torque", "800", "--youngs-modulus-mpa", "210000")


def test_path_under_a_load() -> None:
    """JSON, CSV and text have the values of the library; without a load they are missing."""
    path = path_of_contact(builtin_design().with_parabola(0.001, -0.001), "right", 9)
    found = path_pressure(path, Load(torque_nm=800.0, young=210000.0))
    hertz = json_of(*PRESSED)["hertz"]
    np.testing.assert_allclose(hertz["major_semi_axis"], found.semi_axes[:, 0], rtol=1e-12)
    for name in ("force", "pressure"):
        np.testing.assert_allclose(hertz[name], getattr(found, name), rtol=1e-12)
    assert (hertz["youngs_modulus_mpa"], hertz["poisson"], *hertz["ellipse"]) == (
        210000.0,
        0.3,
        *["ellipse"] * 9,
    )
    rows, text = csv_of(*PRESSED), run(*PRESSED).stdout
    for name, unit in {
        "pressure": "_MPa",
        "force": "_N",
        "least_curvature": "_per_mm",
        "ellipse_angle": "_rad",
        "reaches": "",
    }.items():
        assert [row[name + unit] for row in rows] == list(map(str, hertz[name]))
    assert [float(row["major_direction_z"]) for row in rows] == [v[2] for v in hertz["major_direction"]]
    assert max(map(len, text.splitlines())) <= 100
    words = " ".join(text.split())
    assert f"{min(hertz['pressure']):.2f} to {max(hertz['pressure']):.2f} MPa along the path" in words
    assert "under 800 N m on the pinion; E 210000 MPa, Poisson's ratio 0.3" in words
    limits = ", ".join(str(Limit(code)) for code in np.unique(found.reaches[found.reaches >= 0]))
    past = np.count_nonzero(found.reaches >= 0)
    assert f"at {past} of 9 positions the ellipse ends beyond an edge of a flank ({limits})" in words
    assert "pressure_MPa" not in rows_of(printed("tca", "csv"))[0]
    assert "hertz" not in strict_json(printed("tca", "json").stdout)


@pytest.mark.parametrize(
    ("young", "words"),
    [
        ("206", "206 MPa is unusual: was it given in GPa? 206 GPa are 206000 MPa"),
        ("2.06e6", "2.06e+06 MPa is unusual: steel has about 206000 MPa"),
    ],
)
def test_unusual_modulus(young: str, words: str) -> None:
    """Usual materials, from plastics to carbides, have no warning."""
    pressed = ("tca", *MODIFIED, "--points", "2", "--torque", "100", "--youngs-modulus-mpa")
    assert f"warning the Young's modulus of {words}" in words_of(*pressed, young)
    for usual in ("500", "1e6"):
        assert "is unusual" not in words_of(*pressed, usual)


def test_columns_of_large_pressures_are_separated() -> None:
    lines = run("tca", "--points", "3", "--force", "1e12").stdout.splitlines()
    rows = [line.split() for line in lines if line.endswith(("gear heel", "gear toe"))]
    assert [row[-3].partition(".")[0] for row in rows] == ["328212", "296616", "298777"]


@pytest.mark.parametrize("film", ["0", "0.001"])
def test_operation_without_a_film_has_no_pattern(film: str) -> None:
    words = words_of("operation", "--points", "3", "--film", film)
    assert ("the contact pattern for a film" in words) == (film != "0")


def test_no_pressure_under_interference() -> None:
    given = [
        "tca",
        "--parabola-pinion",
        "0.002",
        "--parabola-gear",
        "0.002",
        "--points",
        "3",
        "--force",
        "10",
    ]
    rows, data = csv_of(*given, status=1), json_of(*given, status=1)["hertz"]
    found = [(row["pressure_MPa"], row["reaches"], row["ellipse"]) for row in rows]
    assert found == [("", "", "interference")] * 3
    assert data["pressure"] == data["reaches"] == [None] * 3
    words = words_of(*given, status=1)
    assert "3 of 3 positions the flanks interfere next to the contact: no ellipse, no pressure" in words
    lost = run(*given, "--offset-error", "30")
    assert (lost.exit_code, "ellipse" in lost.stdout) == (1, False)


def test_csv_of_a_pattern_has_its_points() -> None:
    found = contact_pattern(builtin_design().with_parabola(0.001, -0.001), "left", 0.01, resolution=2.0)
    for member, side in (("pinion", found.pinion), ("gear", found.gear)):
        own = [row for row in rows_of(printed("pattern", "csv")) if row["member"] == member]
        least = np.array([float(row["least_mm"] or "nan") for row in own])
        np.testing.assert_array_equal(least, side.least.ravel())
        assert [row["marked"] == "1" for row in own] == side.marked.ravel().tolist()
        assert {float(row["area_mm2"]) for row in own} == {side.area}


def test_csv_of_a_sensitivity_has_a_row_for_each_quantity() -> None:
    rows, data = rows_of(printed("sensitivity", "csv")), strict_json(printed("sensitivity", "json").stdout)
    assert len(rows) == 5 * 6 + 3 + 3
    heads = ("by_offset_per_mm", "by_shaft_angle_per_rad", "by_pinion_axial_per_mm", "by_gear_axial_per_mm")
    by = {(row["quantity"], row["place"], row["member"]): row for row in rows}
    for key, expected in (
        (("z_mm", "leave", "gear"), data["z_by"][2][1]),
        (("square_shift_mm", "middle", "pinion"), data["square_shift_by"][1][0]),
        (("pinion_roll_rad", "enter", "pinion"), data["pinion_roll_by"][0]),
        (("peak_to_peak_rad", "", ""), data["peak_to_peak_by"]),
        (("mounted_backlash_mm", "", ""), data["mounted_backlash_by"]),
    ):
        assert [float(by[key][head]) for head in heads] == expected
    assert float(by["z_mm", "leave", "gear"]["value"]) == data["z"][2][1]
    assert by["face_shift_mm", "middle", "gear"]["value"] == ""


def test_text_of_a_sensitivity() -> None:
    (line,) = (one for one in printed("sensitivity").stdout.splitlines() if "pinion, along the face" in one)
    found = path_sensitivity(builtin_design().with_parabola(0.001, -0.001), "left").face_shift_by[1, 0]
    expected = found * (0.1, np.radians(0.01), 0.1, 0.1)
    assert [float(value) for value in line.split("mm")[1].split()] == pytest.approx(expected, abs=1e-6)


def test_csv_of_a_tolerance_study_has_its_mountings() -> None:
    rows, found = rows_of(printed("tolerance", "csv")), tolerance_case().mountings
    np.testing.assert_array_equal([float(row["shaft_angle_error_rad"]) for row in rows], found.errors[:, 1])
    assert [row["status"] for row in rows] == [Status(code).name.lower() for code in found.status]
    lost = next(row for row in rows if row["status"] == "off_flank")
    assert (lost["enter"], lost["gear_z_leave_mm"], lost["contact_ratio"]) == ("", "", "0.0")
    for row, limit, radius in zip(rows, found.limit[:, 0], found.pinion_r[:, 1], strict=True):
        if row["status"] == "solved":
            assert row["enter"] == Limit(limit).name.lower()
            assert float(row["pinion_r_middle_mm"]) == pytest.approx(radius, rel=1e-9)


def test_text_of_a_tolerance_study_has_its_shares() -> None:
    text, study = printed("tolerance").stdout, tolerance_case()
    off = 100.0 * study.status_counts()[Status.OFF_FLANK] / 40
    assert f"off flank {off:.0f} %" in " ".join(text.split())
    (line,) = (line for line in text.splitlines() if line.startswith("pinion z middle"))
    assert float(line.split()[7]) == pytest.approx(study.quantiles((0.5,))["pinion_z_middle"][0], abs=5.1e-4)


def test_text_of_a_tolerance_study_has_the_printed_names_of_the_ends() -> None:
    """The pinion of awd-transfer is cylindrical: the end at -z, toe in JSON, is printed as its back."""
    given = ("tolerance", "awd-transfer", "--shaft-angle-tolerance-deg", "0.2", "--cases", "50")
    text, data = run(*given), run(*given, "--json")
    words = " ".join(text.stdout.split())
    pairs = [(one["enter"], one["leave"]) for one in strict_json(data.stdout)["limits"]]
    assert any("pinion_toe" in pair for pair in pairs)
    printed_ends = {"pinion_toe": "pinion back", "pinion_heel": "pinion front"}
    enter, leave = (printed_ends.get(name, name.replace("_", " ")) for name in pairs[-1])
    assert f"{enter} to {leave} " in words
    assert "pinion toe" not in words
    assert "pinion heel" not in words


def test_tolerance_study_without_a_path(design_file: Callable[..., Path]) -> None:
    source = design_file({"[errors]\noffset = 0.0": "[errors]\noffset = 4.0"})
    result = run("tolerance", source, "--offset-tolerance", "0.1", "--cases", "5", "--jobs", "2")
    assert result.exit_code == 1
    assert result.stderr == "No contact: no mounting has a path on the right flanks\n"
    assert "offset +4 mm" in result.stdout
    assert "off flank 100 %" in result.stdout


def test_csv_of_statements_has_every_number() -> None:
    rows, data = rows_of(printed("statements", "csv")), strict_json(printed("statements", "json").stdout)
    for one in data:
        own = [row for row in rows if row["id"] == one["id"]]
        assert {(row["verdict"], row["measure"]) for row in own} == {(one["verdict"], one["measure"])}
        for claim, values in one["values"].items():
            ours = [row for row in own if row["claim"] == claim]
            numbers = [float(row["value"]) for row in ours if row["kind"] == "number"]
            assert numbers == [value for row in values["numbers"].values() for value in row]
            answers = {row["way"]: row["value"] for row in ours if row["kind"] == "holds"}
            assert answers == {way: "yes" if holds else "no" for way, holds in values["holds"].items()}


def test_csv_of_an_optimum() -> None:
    data = strict_json(printed("optimise", "json").stdout)
    assert 0 < data["certified"]["first_contact"] <= data["certified"]["positions"]
    for row, name in zip(rows_of(printed("optimise", "csv")), ("found", "given"), strict=True):
        assert row["design"] == name
        assert float(row["shift_mm"]) == data[name]["shift"]
        assert float(row["pinion_z_middle_mm"]) == data[name]["centre"]
        assert float(row["edge_share"]) == data[name]["edge_share"]
        expected = data["parabola"]["gear"] if name == "found" else 0.0
        assert float(row["parabola_gear_per_mm"]) == expected


def test_optimum_without_edge_contact() -> None:
    given = ("optimise", *OFFSET, "--shaft-angle-tolerance-deg", "0.01", "--no-edges")
    bounds = ("--pinion-bounds", "0", "0.001", "--gear-bounds", "-0.001", "0")
    text = run(*given, *bounds).stdout
    assert "no edge contact with or without these errors" in " ".join(text.split())
    assert "share of edge contact" in text
    deep = ("--pinion-bounds", "-0.001", "-0.0009", "--gear-bounds", "-0.001", "-0.0009")
    line = refused(*given, "--contact-ratio", "1", "--off-centre", "5", *deep)
    assert line.startswith("Error: no coefficients were found without edge contact")


def test_csv_of_check_has_groups_and_units() -> None:
    data = strict_json(printed("check", "json").stdout)
    rows = {(row["group"], row["quantity"]): row for row in rows_of(printed("check", "csv"))}
    for key, unit, value in (
        (("closing", "offset"), "mm", data["closing"]["offset"]),
        (("closing", "shaft_angle_difference"), "rad", data["closing"]["shaft_angle_difference"]),
        (("design", "dw2"), "mm", data["mounting"]["dw2"]),
        (("zero_backlash", "gear_mounting"), "mm", data["zero_backlash"]["mounting"][1]),
        (("zero_backlash", "pinion_cone_angle"), "rad", data["zero_backlash"]["cone_angle"][0]),
        (("mounted", "normal_backlash"), "mm", data["mounted_backlash"]["normal"]),
    ):
        assert (rows[key]["unit"], float(rows[key]["value"])) == (unit, value)


@pytest.mark.parametrize(
    ("command", "option", "status", "message"),
    [
        ("operation", "--parabola-pinion=0.01", 4, f"{UNFIT} pinion: tip_radius 0.38 is too large"),
        ("pattern", "--parabola-pinion=0.01", 4, f"no pattern: {UNFIT} pinion: tip_radius 0.38 is too large"),
        # A tip on the mate's bottom land is a result, not a failed calculation.
        (
            "pattern",
            "--offset-error=-2.5",
            1,
            "no pattern: the first contact of the right flanks is not known",
        ),
    ],
)
def test_reason_for_a_missing_first_contact(command: str, option: str, status: int, message: str) -> None:
    result = run(command, option)
    assert (result.exit_code, result.stdout) == (status, "")
    assert result.stderr.startswith(f"Error: {message}")
    assert result.stderr.count("\n") == 1
    assert "give" not in result.stderr.partition("is too large")[0]


def test_ranges_of_sliding_do_not_depend_on_the_positions() -> None:
    few, many = (strict_json(run("sliding", "--json", "--points", count).stdout) for count in ("2", "301"))
    assert all(few[key] == many[key] for key in ("range", "least_sliding", "pitch_roll"))
    assert few["least_sliding"]["speed"] == few["range"]["speed"][0] < min(few["positions"]["speed"])


def test_figures_of_table_1() -> None:
    """The text has the known numbers of pattern, sliding and operation. The pattern of unmodified right
    flanks covers nearly the complete flank, because they have approximate line contact."""
    text = run("pattern", "--resolution", "0.4").stdout
    assert "621.7 mm^2 marked, 94.6 % of the active flank" in text
    assert "error of the area at most 0.31 %" in text
    text = run("sliding", "--points", "3").stdout
    assert "24.7209 to 34.9430 mm/rad, smallest at 9.4857 deg of pinion roll" in text
    assert "pinion -0.9495 to 0.4300, gear -0.9408 to 0.5551" in text
    text = run("operation", "--points", "25", *MODIFIED).stdout
    assert "1.816308 of one tooth pair (Eq. 16), 1.000000 in operation, 2.299395 with" in text
    assert "1.8107 arcsec peak to peak" in text
    assert "edge contact       during 18.1 % of the mesh cycle" in text


def test_gear_data_of_one_member_without_data(design_file: Callable[..., Path]) -> None:
    """A ball that does not fit the pinion leaves the data of the gear complete; tip rounds that overlap leave
    no data of either member."""
    assert (
        "no position of a ball between the flanks was found" in run("gear-data", "--pinion-ball", "4").stdout
    )
    rows = csv_of("gear-data", "--pinion-ball", "4")
    assert [row["ball_dimension_mm"] == "" for row in rows] == [True] * 3 + [False] * 3
    path = design_file({"tip_radius = 0.38": "tip_radius = 0.9"})
    lost = run("gear-data", path, "--json")
    assert (lost.exit_code, lost.stderr) == (1, "")
    assert "overlap" in strict_json(lost.stdout)["gear"]["reason"]
    assert run("gear-data", path).stderr.startswith("No data of the pinion: tip_radius 0.9 is too large")
    assert run("gear-data", path, "--csv").stdout == "\n"


def test_measured_points_are_read_back(tmp_path: Path) -> None:
    """Deviations of points that were moved along y are printed in three output forms; a file with a missing
    point is rejected in one line."""
    nominal = run("grid", "--member", "gear", "--rows", "3", "--columns", "4").stdout
    rows = [line.split() for line in nominal.splitlines() if not line.startswith("#")]
    moved = [[*row[:4], str(float(row[4]) + 0.001), *row[5:]] for row in rows]
    path, asked = tmp_path / "m.txt", ("grid", "--member", "gear", "--rows", "3", "--columns", "4")
    path.write_text("\n".join(" ".join(row) for row in moved), encoding="utf-8")
    data = json_of(*asked, "--measured", path)
    normal = np.array([float(row[7]) for row in rows]).reshape(2, 3, 4)
    for side, flank in enumerate(("right", "left")):
        np.testing.assert_allclose(data["deviation"][flank], 0.001 * normal[side], atol=1e-7)
    assert data["turn"] == pytest.approx(0.001 / 139.0, rel=0.03)
    table = csv_of(*asked, "--measured", path)
    assert [float(row["deviation_mm"]) for row in table[12:]] == np.ravel(data["deviation"]["left"]).tolist()
    text = words_of(*asked, "--measured", path)
    assert " ".join(["row 3", *(f"{value:.3f}" for value in normal[0, 2]), "row 2"]) in text
    assert "tip above root" in text
    assert "um of normal thickness, rotated by 1.5" in text
    path.write_text("\n".join(" ".join(row) for row in moved[1:]), encoding="utf-8")
    words = (
        "line 1 is (right, row 1, column 2), expected (right, row 1, column 1): a point is missing, or the "
        "order is different\n"
    )
    assert refused(*asked, "--measured", path).startswith(f"Error: {path}: {words}")
    assert f"cannot read {tmp_path} (Is a directory): give the path" in refused(
        "grid", "--measured", tmp_path
    )


def test_missing_shims_are_reported_with_those_for_the_backlash_alone() -> None:
    asked = ("shim", "--offset", "229.3", "--shaft-angle-deg", "14.97", "--backlash", "0.12", "--at", "50")
    text, data = run(*asked), run(*asked, "--json")
    assert (text.exit_code, data.exit_code, data.stderr) == (4, 4, "")
    assert text.stderr.startswith("No shims: no axial positions were found that satisfy the requirements")
    found = strict_json(data.stdout)
    assert (found["shim"]["status"], found["shim"]["pinion_axial"]) == ("not_found", None)
    alone = found["by_backlash_alone"]
    assert (alone["status"], alone["backlash"]) == ("reached", pytest.approx(0.12, abs=1e-9))
    assert f"{alone['pinion_axial']:+.6f} mm, to dw1 = " in text.stdout


@pytest.mark.parametrize("command", ["operation", "check"])
def test_the_backlash_ignores_pitch_deviations(command: str, design_file: Callable[..., Path]) -> None:
    """One tooth of the gear is 0.3 mm thicker on each flank, which is more than the backlash of 0.243 mm."""
    deviations = ", ".join(["0", "300", *["0"] * 59])
    table = f"\n[gear.modification]\npitch_deviations_um = [{deviations}]\n"
    source = design_file(more=table, name="marine-gearbox")
    note = "the backlash as mounted ignores pitch deviations"
    assert note in words_of(command, source)
    assert any(note in one for one in json_of(command, source)["notes"])
    assert note not in words_of(command, "marine-gearbox")
