"""What single commands print besides what all of them have in common."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import (
    Status,
    builtin_design,
    contact_pattern,
    path_of_contact,
    path_sensitivity,
)
from beveloid_geom.analysis.pressure import Load, pressure_along
from beveloid_geom.design.file import builtin_text
from beveloid_geom.status import Limit
from tests.cli.running import rows_of, run, strict_json
from tests.cli.test_results import MODIFIED, OFFSET, printed, studied


def test_what_matters_most_stands_last() -> None:
    """The positions of `tca` do not scroll its summary away."""
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


def test_a_path_under_a_load_has_its_ellipses() -> None:
    """The library's numbers in JSON, those in CSV, the same in the text; without a load nothing of them."""
    path = path_of_contact(builtin_design().with_parabola(0.001, -0.001), "right", 9)
    found = pressure_along(path, Load(torque_nm=800.0, young=210000.0))
    hertz = strict_json(run(*PRESSED, "--json").stdout)["hertz"]
    np.testing.assert_allclose(hertz["major_semi_axis"], found.semi_axes[:, 0], rtol=1e-12)
    for name in ("force", "pressure"):
        np.testing.assert_allclose(hertz[name], getattr(found, name), rtol=1e-12)
    assert (hertz["youngs_modulus_mpa"], hertz["poisson"], hertz["ellipse"]) == (
        210000.0,
        0.3,
        ["ellipse"] * 9,
    )
    rows, text = rows_of(run(*PRESSED, "--csv")), run(*PRESSED).stdout
    for header, name in (
        ("pressure_MPa", "pressure"),
        ("force_N", "force"),
        ("least_curvature_per_mm", "least_curvature"),
        ("ellipse_angle_rad", "ellipse_angle"),
        ("reaches", "reaches"),
    ):
        assert [row[header] for row in rows] == list(map(str, hertz[name]))
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


def test_flanks_that_cut_each_other_have_no_pressure() -> None:
    given = (
        "tca",
        "--parabola-pinion",
        "0.002",
        "--parabola-gear",
        "0.002",
        "--points",
        "3",
        "--force",
        "10",
    )
    rows, data = rows_of(run(*given, "--csv")), strict_json(run(*given, "--json").stdout)["hertz"]
    assert [(row["pressure_MPa"], row["reaches"], row["ellipse"]) for row in rows] == [
        ("", "", "interference")
    ] * 3
    assert data["pressure"] == data["reaches"] == [None] * 3
    words = " ".join(run(*given).stdout.split())
    assert "3 of 3 positions the flanks cut each other beside the contact: no ellipse, no pressure" in words
    lost = run(*given, "--offset-error", "30")
    assert (lost.exit_code, "ellipse" in lost.stdout) == (1, False)


EASE_OFF = ("ease-off", *MODIFIED, "--grid", "4", "5")


def test_csv_of_an_ease_off_has_its_points() -> None:
    rows, data = rows_of(run(*EASE_OFF, "--csv")), strict_json(run(*EASE_OFF, "--json").stdout)
    assert len(rows) == 4 * 4 * 5
    for flank in ("right", "left"):
        for state in ("as_given", "without_parabola"):
            own = [row for row in rows if (row["flank"], row["parabola"]) == (flank, state)]
            found = data[flank][state]
            for header, name in (
                ("deviation_mm", "deviation"),
                ("pinion_roll_rad", "pinion_roll"),
                ("z_mm", "z"),
            ):
                assert [float(row[header]) for row in own] == np.ravel(found[name]).tolist()
            assert {row["status"] for row in own} == {"solved"}
            places = found["profile_place"][1], found["face_place"][2]
            assert (float(own[7]["profile_place"]), float(own[7]["face_place"])) == places
            assert found["corners"]["tip_toe"] == found["deviation"][-1][0]


def test_text_of_an_ease_off_is_in_um() -> None:
    text, data = run(*EASE_OFF).stdout, strict_json(run(*EASE_OFF, "--json").stdout)
    for words, group, name in (
        ("root, heel", "corners", "root_heel"),
        ("twist", "second_order", "twist"),
        ("rms of the rest", "second_order", "rest"),
    ):
        (line,) = (line for line in text.splitlines() if line.strip().startswith(words))
        wanted = [
            data[f][s][group][name] for f in ("right", "left") for s in ("as_given", "without_parabola")
        ]
        found = [float(word) for word in line.split(words)[1].split()]
        assert found == pytest.approx(1e3 * np.array(wanted), abs=5.1e-4)
    assert "without parabola" not in run("ease-off", "--grid", "3", "3").stdout


def test_an_ease_off_without_a_path_on_one_flank() -> None:
    """The other flank has it; without parabolas it is told apart from the design as given."""
    text, data, table = (
        run("ease-off", "--offset-error", "5", "--grid", "3", "3", *f) for f in ((), ("--json",), ("--csv",))
    )
    assert (text.exit_code, data.exit_code, table.exit_code, data.stderr) == (1, 1, 1, "")
    assert text.stderr == table.stderr
    assert text.stderr.startswith("No contact: the path of contact does not meet the right flanks")
    assert text.stderr.count("\n") == 1
    found = strict_json(data.stdout)
    assert (
        found["reason"]
        == found["right"]["as_given"]["reason"]
        == text.stderr.removeprefix("No contact: ")[:-1]
    )
    assert {row["flank"] for row in rows_of(table)} == {"left"}
    assert "note right flanks, as given: the path of contact does not meet" in " ".join(text.stdout.split())
    none = run("ease-off", "--offset-error", "30", "--csv")
    assert (none.exit_code, none.stdout.count("\n")) == (1, 1)
    assert none.stdout.startswith("flank,parabola,profile_place")


def test_points_of_an_ease_off_without_a_conjugate_are_empty() -> None:
    given = ("ease-off", "--parabola-pinion=-0.002", "--parabola-gear", "0.003", "--grid", "3", "5")
    lost = [row for row in rows_of(run(*given, "--csv")) if row["status"] != "solved"]
    assert [(row["status"], row["deviation_mm"], row["pinion_roll_rad"]) for row in lost] == [
        ("not_converged", "", "")
    ] * len(lost)
    words = " ".join(run(*given).stdout.split())
    assert f"right flanks, as given: the mate has no conjugate at {len(lost)} of 15 points" in words
    assert "nan" not in words


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


def test_text_of_a_sensitivity_is_for_the_errors_named() -> None:
    line = next(
        text for text in printed("sensitivity").stdout.splitlines() if "pinion, along the face" in text
    )
    found = path_sensitivity(builtin_design().with_parabola(0.001, -0.001), "left").face_shift_by[1, 0]
    expected = found * (0.1, np.radians(0.01), 0.1, 0.1)
    assert [float(value) for value in line.split("mm")[1].split()] == pytest.approx(expected, abs=1e-6)


def test_csv_of_a_tolerance_study_has_its_mountings() -> None:
    rows, found = rows_of(printed("tolerance", "csv")), studied().mountings
    np.testing.assert_array_equal([float(row["shaft_angle_error_rad"]) for row in rows], found.errors[:, 1])
    assert [row["status"] for row in rows] == [Status(code).name.lower() for code in found.status]
    lost = next(row for row in rows if row["status"] == "off_flank")
    assert (lost["enter"], lost["gear_z_leave_mm"], lost["contact_ratio"]) == ("", "", "0.0")
    for row, limit, radius in zip(rows, found.limit[:, 0], found.pinion_r[:, 1], strict=True):
        if row["status"] == "solved":
            assert row["enter"] == Limit(limit).name.lower()
            assert float(row["pinion_r_middle_mm"]) == pytest.approx(radius, rel=1e-9)


def test_text_of_a_tolerance_study_has_its_shares() -> None:
    text, study = printed("tolerance").stdout, studied()
    off = 100.0 * study.status_counts()[Status.OFF_FLANK] / 40
    assert f"off flank {off:.3f} %" in " ".join(text.split())
    (line,) = (line for line in text.splitlines() if line.startswith("pinion z middle"))
    assert float(line.split()[7]) == pytest.approx(study.quantiles((0.5,))["pinion_z_middle"][0], abs=5.1e-4)


def test_mountings_none_of_which_has_a_path(design_file: Callable[..., Path]) -> None:
    source = design_file("[errors]\noffset = 0.0", "[errors]\noffset = 4.0")
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


def test_csv_of_an_optimum_has_found_and_given() -> None:
    data = strict_json(printed("optimise", "json").stdout)
    assert 0 < data["certified"]["first_contact"] <= data["certified"]["positions"]
    for row, name in zip(rows_of(printed("optimise", "csv")), ("found", "given"), strict=True):
        assert row["design"] == name
        assert float(row["shift_mm"]) == data[name]["shift"]
        assert float(row["pinion_z_middle_mm"]) == data[name]["centre"]
        assert float(row["edge_share"]) == data[name]["edge_share"]
        expected = data["parabola"]["gear"] if name == "found" else 0.0
        assert float(row["parabola_gear_per_mm"]) == expected


def test_an_optimum_without_edges_is_asked_for() -> None:
    given = ("optimise", *OFFSET, "--shaft-angle-tolerance-deg", "0.01", "--no-edges")
    bounds = ("--pinion-bounds", "0", "0.001", "--gear-bounds", "-0.001", "0")
    text = run(*given, *bounds).stdout
    assert "no edge carries, with these errors or without" in " ".join(text.split())
    assert "share carried by edges" in text
    deep = ("--pinion-bounds", "-0.001", "-0.0009", "--gear-bounds", "-0.001", "-0.0009")
    refused = run(*given, "--contact-ratio", "1", "--off-centre", "5", *deep)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert refused.stderr.startswith("Error: no coefficients were found with which no edge carries")
    assert refused.stderr.count("\n") == 1


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


OVER_MOUNTING = "map --over mounting --steps 2 --pinion-bounds 0 60 --gear-bounds 0 1"


def test_cells_of_a_map_that_are_lost_are_empty() -> None:
    given = OVER_MOUNTING.split()
    rows, data = rows_of(run(*given, "--csv")), strict_json(run(*given, "--json").stdout)
    assert [row["status"] for row in rows] == ["solved", "solved", "off_flank", "off_flank"]
    assert (rows[2]["contact_ratio"], data["map"]["contact_ratio"][1]) == ("", [None, None])
    assert float(rows[2]["normal_backlash_mm"]) > 0.0
    assert list(rows[0])[:2] == ["pinion_mounting_change_mm", "gear_mounting_change_mm"]


@pytest.mark.parametrize("over", ["mounting", "shift"])
def test_texts_of_other_maps(over: str) -> None:
    result = run("map", "--over", over, "--steps", "4", *MODIFIED)
    assert result.exit_code == 0
    assert "the backlash is negative" in " ".join(result.stdout.split())
    assert "C3" not in result.stdout
    assert "errors for shift   offset +0.05 mm, shaft angle +0.01 deg, pinion axial +0.1 mm" in result.stdout


def test_a_map_without_a_ratio_to_keep_and_one_in_operation(tmp_path: Path) -> None:
    source = tmp_path / "thin.toml"
    text = builtin_text().replace("face_width = 50.0", "face_width = 0.1")
    source.write_text(text.replace("face_width = 60.0", "face_width = 0.1"), encoding="utf-8")
    result = run("map", source, "--steps", "4")
    assert result.exit_code == 0
    assert "The design itself has no contact ratio to be kept" in result.stdout
    bounds = ("--pinion-bounds", "-0.0005", "0.0005", "--gear-bounds", "-0.0005", "0")
    found = strict_json(run("map", "--operation", "--steps", "2", "--json", *bounds, *OFFSET).stdout)
    shares = np.array(found["map"]["edge_share"])
    assert shares[0, 0] == 0.0
    assert ((shares >= 0.0) & (shares <= 1.0)).all()


@pytest.mark.parametrize(
    ("command", "parabola", "said"),
    [
        ("operation", "0.01", "no first contact: pinion: tip_radius 0.38 is too large"),
        ("pattern", "0.01", "no pattern: pinion: tip_radius 0.38 is too large"),
        ("pattern", "-0.01", "no pattern: the first contact of the right flanks is not known"),
    ],
)
def test_a_first_contact_that_cannot_be_found_is_status_1(command: str, parabola: str, said: str) -> None:
    result = run(command, "--parabola-pinion", parabola)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith(f"Error: {said}")
    assert result.stderr.count("\n") == 1
    assert "give" not in result.stderr.partition("is too large")[0]


def test_ranges_of_sliding_do_not_depend_on_the_positions_asked_for() -> None:
    few, many = (strict_json(run("sliding", "--json", "--points", count).stdout) for count in ("2", "301"))
    assert all(few[key] == many[key] for key in ("range", "least_sliding", "pitch_roll"))
    assert few["least_sliding"]["speed"] == few["range"]["speed"][0] < min(few["positions"]["speed"])


def test_figures_of_table_1() -> None:
    """The unmodified right flanks are in approximate line contact: compound covers nearly all."""
    text = run("pattern", "--resolution", "0.4").stdout
    assert "621.9 mm^2 marked, 94.6 % of the active flank" in text
    assert "right to 0.26 % of the area" in text
    text = run("sliding", "--points", "3").stdout
    assert "24.7209 to 34.9430 mm/rad, least at 9.4857 deg of pinion roll" in text
    assert "pinion -0.9495 to 0.4300, gear -0.9408 to 0.5551" in text
    text = run("operation", "--points", "25", *MODIFIED).stdout
    assert "1.816308 by Eq. 16; in operation 1.000000, 2.299395 within 6.35 um" in text
    assert "1.8107 arcsec peak to peak" in text
    assert "carry 18.1 % of the cycle" in text


def test_a_member_that_cannot_be_described_says_why_and_the_other_is(
    design_file: Callable[..., Path],
) -> None:
    """Rounds that leave no flank are those of both members, a ball is of one."""
    result = run("gear-data", "--pinion-ball", "4")
    assert result.exit_code == 0
    assert "a ball finds no place between the flanks" in result.stdout
    rows = rows_of(run("gear-data", "--pinion-ball", "4", "--csv"))
    assert [row["ball_dimension_mm"] == "" for row in rows] == [True] * 3 + [False] * 3
    path = design_file("tip_radius = 0.38", "tip_radius = 0.9")
    lost = run("gear-data", path, "--json")
    assert (lost.exit_code, lost.stderr) == (1, "")
    assert "overlap" in strict_json(lost.stdout)["gear"]["reason"]
    assert run("gear-data", path).stderr.startswith("No data of the pinion: tip_radius 0.9 is too large")
    assert run("gear-data", path, "--csv").stdout == "\n"


def test_measured_points_are_read_back(tmp_path: Path) -> None:
    """The neutral table with its points moved along y, in its three forms; a hole is one line."""
    nominal = run("grid", "--member", "gear", "--rows", "3", "--columns", "4").stdout
    rows = [line.split() for line in nominal.splitlines() if not line.startswith("#")]
    moved = [[*row[:4], str(float(row[4]) + 0.001), *row[5:]] for row in rows]
    path, asked = tmp_path / "m.txt", ("grid", "--member", "gear", "--rows", "3", "--columns", "4")
    path.write_text("\n".join(" ".join(row) for row in moved), encoding="utf-8")
    data = strict_json(run(*asked, "--measured", path, "--json").stdout)
    normal = np.array([float(row[7]) for row in rows]).reshape(2, 3, 4)
    for side, flank in enumerate(("right", "left")):
        np.testing.assert_allclose(data["deviation"][flank], 0.001 * normal[side], atol=1e-7)
    assert data["turn"] == pytest.approx(0.001 / 139.0, rel=0.03)
    table = rows_of(run(*asked, "--measured", path, "--csv"))
    assert [float(row["deviation_mm"]) for row in table[12:]] == np.ravel(data["deviation"]["left"]).tolist()
    text = " ".join(run(*asked, "--measured", path).stdout.split())
    assert " ".join(["row 3", *(f"{value:.3f}" for value in normal[0, 2]), "row 2"]) in text
    assert "tip above root" in text
    assert "um of normal thickness, turned by 1.5" in text
    path.write_text("\n".join(" ".join(row) for row in moved[1:]), encoding="utf-8")
    lost = run(*asked, "--measured", path)
    assert (lost.exit_code, lost.stdout) == (2, "")
    assert lost.stderr == (
        f"Error: {path}: line 1 is right, row 1, column 2 where right, row 1, column 1 is due: a point is "
        "missing, or the order is another one\n"
    )
    assert run("grid", "--measured", tmp_path).stderr == f"Error: cannot read {tmp_path} (Is a directory)\n"


def test_shims_that_there_are_not_are_told_with_those_of_the_backlash_alone() -> None:
    asked = ("shim", "--offset", "229.3", "--shaft-angle-deg", "14.97", "--backlash", "0.12", "--at", "50")
    text, data = run(*asked), run(*asked, "--json")
    assert (text.exit_code, data.exit_code, data.stderr) == (1, 1, "")
    assert text.stderr.startswith("No shims: no axial positions were found that give what is wanted")
    found = strict_json(data.stdout)
    assert (found["shim"]["status"], found["shim"]["pinion_axial"]) == ("not_found", None)
    alone = found["by_backlash_alone"]
    assert (alone["status"], alone["backlash"]) == ("reached", pytest.approx(0.12, abs=1e-9))
    assert f"{alone['pinion_axial']:+.6f} mm, to dw1 = " in text.stdout
