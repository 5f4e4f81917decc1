"""All commands on a pair with parallel axes."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Load, builtin_design, path_of_contact, path_pressure
from beveloid_geom.contact.parallel.lines import contact_lines

from .running import csv_of, json_of, refused, run, words_of

NAME = "anti-backlash"
PARABOLA = ("--parabola-pinion", "-0.002", "--parabola-gear", "-0.001")
COMMANDS: dict[str, tuple[str, ...]] = {
    "tca": ("--points", "3", "--force", "1000"),
    "operation": ("--points", "3"),
    "pattern": ("--resolution", "3", "--area-error", "0.2"),
    "ease-off": ("--grid", "3", "3"),
    "sliding": (),
    "sensitivity": (),
}
SLOW = ("pattern", "operation")


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[pytest.mark.slow] if c in SLOW else []) for c in COMMANDS]
)
@pytest.mark.parametrize("parabola", [(), PARABOLA])
def test_every_command_runs(command: str, parabola: tuple[str, ...]) -> None:
    result = run(command, NAME, *COMMANDS[command], *parabola)
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert "shaft angle = 0 deg" in result.stdout
    assert "nan" not in result.stdout
    assert ("no derivatives" in result.stdout) == (command == "sensitivity")


def test_check_has_no_warnings() -> None:
    found = run("check", NAME).stdout
    assert "No warnings." in found
    assert "line contact, so that an error of the shaft angle" in " ".join(found.split())


@pytest.mark.parametrize("error", ["0.0", "0.01"])
def test_check_prints_that_generators_are_parallel(error: str) -> None:
    found = run("check", NAME, "--shaft-angle-error-deg", error).stdout
    assert "crossing angle     0: the generators of the flanks are parallel" in found
    assert "nan" not in found


def test_the_five_equations_cannot_solve_line_contact() -> None:
    result = run("tca", NAME, "--method", "five-equation")
    reason = "because line contact has an infinite number of contacts at each roll"
    line = f"Error: the five equations are singular, {reason}: use the one-equation method\n"
    assert (result.exit_code, result.stderr) == (4, line)
    assert "cannot solve line contact" in " ".join(run("tca", "--help").stdout.split())


def test_load_on_lines_of_contact() -> None:
    """The note states the load distribution; text, JSON and CSV have pressure and total length."""
    arguments = "tca", NAME, "--points", "3", "--torque", "100"
    design = builtin_design(NAME)
    found = path_pressure(path_of_contact(design, "right", 3), Load(torque_nm=100.0))
    text = words_of(*arguments)
    assert "the load is distributed evenly over all lines in contact" in text
    assert f"to {found.pressure.max():.2f} MPa along the path, all lines of contact together under" in text
    data = json_of(*arguments)["hertz"]
    np.testing.assert_array_equal(data["pressure"], found.pressure)
    np.testing.assert_array_equal(data["total_length"], found.total_length)
    assert set(data["ellipse"]) == {"line_contact"}
    rows = csv_of(*arguments)
    assert [float(row["pressure_MPa"]) for row in rows] == found.pressure.tolist()


def test_flanks_limit_the_backlash() -> None:
    """The ends of a line of contact are not reported as edges."""
    assert "flanks touch at" not in run("tca", NAME, "--points", "3").stdout
    data = json_of("check", NAME)["mounted_backlash"]
    assert data["right"]["edges"] == data["left"]["edges"] == []


def test_sensitivity_of_line_contact() -> None:
    """An axial shift changes the backlash by 2 sin(alpha_n) sin(cone) = 0.0358 mm per mm. The text has the
    change for 0.1 mm."""
    text = run("sensitivity", NAME).stdout
    rows = [line for line in text.splitlines() if " mm  " in line and "backlash" in line]
    assert len(rows) == 1
    assert rows[0].split()[-4:] == ["0.068310", "-", "0.003580", "-0.003580"]
    assert "no derivatives     of the path: line contact" in text
    for row in csv.DictReader(io.StringIO(run("sensitivity", NAME, "--csv").stdout)):
        assert any(row[name] for name in row if name not in ("quantity", "place", "member"))


@pytest.mark.parametrize("errors_at", ["perpendicular", "mesh"])
def test_no_derivative_where_both_signs_of_an_error_have_the_same_effect(errors_at: str) -> None:
    """With one parabola the path runs along the face at a transmission error of 0. Shaft-angle errors of
    +-1e-5 deg increase the transmission error by 0.01003 arcsec and change the backlash by -1.77e-6 mm."""
    given = ("sensitivity", NAME, "--parabola-pinion", "-0.001", "--errors-at", errors_at)
    text, data = run(*given).stdout, json_of(*given)
    for key in ("peak_to_peak_by", "mounted_backlash_by"):
        assert data[key][1] is None
        assert None not in (data[key][0], *data[key][-2:])
    assert data["contact_ratio_by"][1] == pytest.approx(-26.56, abs=0.01)
    words = " ".join(text.split())
    assert "of the transmission error: it is 0, and errors of both signs increase it" in words
    assert "of the backlash: it is smallest at several rolls, at which its derivatives differ" in words


def test_lines_in_text_json_and_csv() -> None:
    design = builtin_design(NAME)
    lines = contact_lines(path_of_contact(design, "left", 5))
    arguments = "tca", NAME, "--flank", "left", "--points", "5"
    text = words_of(*arguments)
    assert f"transverse {float(lines.transverse_ratio):.6f} at mid-face" in text
    assert f"total {float(lines.total_ratio):.6f}" in text
    data = json_of(*arguments)["contact_lines"]
    np.testing.assert_array_equal(data["length"], lines.length)
    np.testing.assert_array_equal(data["point"], lines.point)
    assert data["overlap_ratio"] == float(lines.overlap_ratio)
    limits = {limit for row in data["limit"] for limit in row}
    assert limits <= {"gear_toe", "gear_heel", "gear_tip", "pinion_tip"}
    rows = csv_of(*arguments)
    assert [float(row["line_length_mm"]) for row in rows] == lines.length.tolist()
    assert [row["line_first_limit"] for row in rows] == [row[0] for row in data["limit"]]
    assert "contact_lines" not in json_of("tca", NAME, *PARABOLA, "--points", "5")


def test_operation_of_line_contact() -> None:
    data = json_of("operation", NAME, "--points", "3")
    assert set(data["positions"]["carried_by"]) == {"a line"}
    assert data["edge_share"] == 0.0
    assert data["operating_contact_ratio"] == data["contact_ratio"]


@pytest.mark.parametrize("part", ["pinion-tooth", "gear-tooth"])
def test_a_loaded_tooth_is_written(part: str, tmp_path: Path) -> None:
    """The nodal forces add up to 62.5 N at module 1.5. The load is a strip as long as the line of contact,
    about 15 mm."""
    out = tmp_path / "tooth.inp"
    result = run("mesh", NAME, "--part", part, "--out", out, "--tolerance", "0.1")
    assert result.exit_code == 0, result.output
    assert "Hertz's pressure on a strip of 15 by 0.03" in result.stdout
    loads = [line.split(",") for line in out.read_text().split("*CLOAD\n")[1].split("*")[0].splitlines()]
    forces = np.zeros(3)
    for _, axis, force in loads:
        forces[int(axis) - 1] += float(force)
    assert np.linalg.norm(forces) == pytest.approx(62.5, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("place",), "so that its middle cannot be moved: give the pair a shaft angle"),
        (("place", *PARABOLA), "runs along the complete face, also with parabolas"),
        (("tolerance",), "; give only the other tolerances, or add parabolas or helix crowning"),
        (("tolerance",), "--shaft-angle-tolerance-deg must be 0 if the flanks touch along lines, got "),
    ],
)
def test_commands_that_need_point_contact(arguments: tuple[str, ...], words: str) -> None:
    command, *rest = arguments
    assert words in refused(command, NAME, *rest)


def test_hands_that_are_not_opposite(design_file: Callable[..., Path]) -> None:
    path = design_file({"helix_angle_deg = 0.0": "helix_angle_deg = 10.0"}, name=NAME)
    message = "helix_angle_deg must be -10.0 deg, opposite to that of [pinion], got 0.0: on parallel axes"
    assert message in refused("check", path)


def test_lines_with_a_tip_relief() -> None:
    """The path of contact leaves the last line on the relief: there the contact is an ellipse."""
    relief = ("--pinion-modification", "tip_relief=20,tip_relief_length=1.0")
    arguments = ("tca", NAME, *relief, "--torque", "100", "--points", "7")
    text, data = run(*arguments).stdout, json_of(*arguments)
    rows = [line.split() for line in text.splitlines() if line.endswith(("  line contact", "  ellipse"))]
    assert [row[-1] for row in rows] == ["contact"] * 6 + ["ellipse"]
    assert "no line" in text
    assert "overlap 0.060634 without modification" in " ".join(text.split())
    lines = data["contact_lines"]
    assert lines["total_ratio"] is None
    assert lines["limit"][0] == ["gear_toe", "gear_tip"]
    assert lines["limit"][-1] == [None, None]
    assert data["hertz"]["total_length"][-1] is None
