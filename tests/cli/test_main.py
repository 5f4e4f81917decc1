"""The command `beveloid-geom`: installed command, output of `tca`, `check` and `design`, imports."""

from __future__ import annotations

import csv
import io
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Errors, Status, builtin_design, path_of_contact
from beveloid_geom.cli.main import main
from beveloid_geom.design.file import BUILTINS, builtin_text, parse_design
from beveloid_geom.report.path import contact_report
from beveloid_geom.report.result import csv_text, json_text
from tests.cli.result_cases import MODIFIED
from tests.cli.running import call, csv_of, imported_by, json_of, refused, run, strict_json, tca, words_of

PATH_FIELDS = {
    *("l1", "u1", "l2", "u2", "pinion_roll", "gear_roll", "point", "normal"),
    *("pinion_z", "pinion_r", "gear_z", "gear_r", "transmission_error", "status"),
}


# The installed command.


def test_installed_command_prints_a_table() -> None:
    done = call("tca", "--points", "5")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert "dw1 = 211.594669 mm" in done.stdout
    assert "as mounted         backlash 0.041589 mm with errors and modifications, smallest at" in done.stdout
    path = path_of_contact(builtin_design(), "right", 5)
    assert [float(word) for word in lines[10].split()[:3]] == pytest.approx(
        [math.degrees(path.pinion_roll[-1]), math.degrees(path.gear_roll[-1]), path.pinion_z[-1]], abs=5e-5
    )
    assert sum(line.startswith("  note ") for line in lines) == 1


def test_commands_do_not_need_docstrings() -> None:
    """Without docstrings (`python -OO`), the help has the same titles and all commands."""
    commands = ["--help"], ["tca", "--points", "5"], ["mesh", "--help"]
    optimised = [sys.executable, "-OO", "-m", "beveloid_geom"]
    plain = [run(*arguments).stdout for arguments in commands]
    bare = [
        subprocess.run([*optimised, *arguments], capture_output=True, text=True, check=True).stdout
        for arguments in commands
    ]
    assert plain[1] == bare[1]
    assert [line for line in bare[0].splitlines() if line.endswith(":")] == [
        line for line in plain[0].splitlines() if line.endswith(":")
    ]
    assert set(main.commands) <= set(bare[0].split())
    assert "None" not in bare[2]


# tca


def test_options_change_the_design() -> None:
    given = (
        "--offset-error=-0.01 --shaft-angle-error-deg 0.002 --pinion-axial-error 0.3 --gear-axial-error -0.4"
    )
    data = tca(*given.split(), *MODIFIED, "--flank", "left")
    errors = data["layout"]["errors"]
    assert errors["shaft_angle"] == pytest.approx(math.radians(0.002))
    assert [errors[name] for name in ("offset", "pinion_axial", "gear_axial")] == [-0.01, 0.3, -0.4]
    design = builtin_design().with_errors(Errors(-0.01, math.radians(0.002), 0.3, -0.4))
    path = path_of_contact(design.with_parabola(0.001, -0.001), "left")
    assert data["flank"] == "left"
    np.testing.assert_allclose(data["path"]["pinion_z"], path.pinion_z, rtol=0, atol=1e-9)


def test_design_file_and_built_in_name_agree(design_file: Callable[..., Path]) -> None:
    from_file, built_in = tca(design_file()), tca("ni-2017")
    assert from_file.pop("design") != built_in.pop("design")
    assert from_file == built_in == {k: v for k, v in tca().items() if k != "design"}


def test_five_equations_agree() -> None:
    options = "--points", "9", *MODIFIED
    one, five = tca(*options), tca(*options, "--method", "five-equation")
    assert five["method"] == "five-equation"
    assert five["ends"] == one["ends"]
    assert five["contact_ratio"] == pytest.approx(one["contact_ratio"], abs=1e-9)
    for name in PATH_FIELDS - {"status"}:
        np.testing.assert_allclose(five["path"][name], one["path"][name], rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("flank", "parabolas", "expected"),
    [
        ("right", "0.0 0.0", []),
        ("left", "0.0 0.0", []),
        ("right", "0.0002 0.0002", ["an edge touches earlier (pinion tip, gear tip)"]),
        ("right", "0.0007 0.0007", ["the flanks interfere"]),
        ("left", "-0.0001 -0.0001", ["the flanks of a neighbouring tooth pair"]),
        ("right", "0.001 -0.001", ["flanks of a neighbouring tooth", "edge touches earlier (gear tip)"]),
    ],
)
def test_notes_where_something_touches_earlier(flank: str, parabolas: str, expected: list[str]) -> None:
    pinion, gear = parabolas.split()
    options = "--flank", flank, "--parabola-pinion", pinion, "--parabola-gear", gear
    data = tca(*options, "--offset-error", "0.06")  # with backlash for all of them
    notes, verdicts = [*data["warnings"], *data["notes"]], data["certificate"]["verdict"]
    assert all(any(words in note for note in notes) for words in expected)
    assert any("not the operating contact ratio" in note for note in notes) is bool(expected)
    assert all(verdict == "first_contact" for verdict in verdicts) is not bool(expected)
    separation = np.array(data["certificate"]["separation"])
    np.testing.assert_array_equal(separation >= -1e-6, np.array(verdicts) == "first_contact")


def test_tool_without_a_fitting_tip_round() -> None:
    """The path is computed; first contacts, which need the fillets, are not."""
    data = tca("--parabola-pinion", "0.01")
    assert data["contact_ratio"] == pytest.approx(0.637397, abs=5e-7)
    assert "certificate" not in data
    (unknown,) = data["unknowns"]
    assert "could not be computed: pinion: tip_radius 0.38 is too large" in unknown


def test_negative_backlash(design_file: Callable[..., Path]) -> None:
    result = run("tca", "--json", design_file({"offset = 229.0": "offset = 228.7"}))
    data = strict_json(result.stdout)
    assert result.exit_code == 1
    assert "backlash is -" in data["errors"][0]
    assert "interfere" in data["errors"][0]
    assert data["jammed"] is True
    assert data["mounted_backlash"]["normal"] == pytest.approx(data["normal_backlash"], abs=1e-12)


def test_check_warns_of_a_jam(design_file: Callable[..., Path]) -> None:
    path = design_file({"[errors]\noffset = 0.0": "[errors]\noffset = -0.5"})
    result = run("check", path)
    assert result.exit_code == 1
    assert result.stderr.startswith("Jammed: the pair cannot be assembled: the flanks of one side interfere")
    assert "error the pair cannot be assembled" in " ".join(result.stdout.split())
    assert "cannot be assembled" in json_of("check", path, status=1)["errors"][0]
    assert "mounted,normal_backlash,mm,-0.3130" in run("check", path, "--csv").stdout


def test_check_takes_parabolas() -> None:
    assert "is undercut" in run("check", "--parabola-pinion=-0.01").stdout
    assert "rounds overlap by 0.184 mm" in words_of("check", "--parabola-pinion", "0.01")


def test_positions_need_not_be_certified() -> None:
    assert "certificate" not in tca("--no-certify", "--parabola-pinion", "0.0002")
    assert "certified" not in run("tca", "--no-certify").stdout
    assert {row["verdict"] for row in csv_of("tca", "--points", "3")} == {"first_contact"}


def test_note_on_displaced_paths(design_file: Callable[..., Path]) -> None:
    notes = tca(design_file({"offset = 229.0": "offset = 229.3"}))["notes"]
    assert notes[0].startswith("the paths of contact of right and left flanks are displaced along the face")
    assert "pass each other at 6.622 mm" in notes[0]


@pytest.mark.parametrize(
    ("flank", "option", "value", "reason"),
    [
        ("right", "--offset-error", "6", "does not meet the right flanks: at mid-depth of the pinion"),
        ("left", "--offset-error", "10", "does not meet the left flanks: at mid-depth of the pinion"),
        ("right", "--gear-axial-error", "400", "does not meet the right flanks"),
        ("right", "--shaft-angle-error-deg", "-3", "right flanks have no common normal in this layout"),
        ("left", "--shaft-angle-error-deg", "-5", "left flanks have no common normal in this layout"),
    ],
)
def test_no_contact(flank: str, option: str, value: str, reason: str) -> None:
    result = run("tca", "--json", "--flank", flank, option, value)
    assert (result.exit_code, result.stderr) == (1, "")
    data = strict_json(result.stdout)
    assert data["contact_ratio"] == 0
    assert data["ends"] == {"enter": None, "leave": None}
    assert set(data["path"]) == PATH_FIELDS
    assert not any(data["path"].values())
    assert reason in data["reason"]


@pytest.mark.parametrize(
    ("error", "off"),
    [("offset-error=20", (1, 1)), ("pinion-axial-error=60", (1, 0)), ("gear-axial-error=-70", (0, 1))],
)
def test_position_off_the_face_is_printed_for_both_members(error: str, off: tuple[int, int]) -> None:
    message = run("tca", f"--{error}").stderr
    z = [float(message.split(f" mm on the {name}")[0].split()[-1]) for name in ("pinion", "gear")]
    assert (abs(z[0]) > 25.0, abs(z[1]) > 30.0) == off


def test_design_without_a_common_normal(design_file: Callable[..., Path]) -> None:
    path = design_file({"shaft_angle_deg = 15.0": "shaft_angle_deg = 14.0"})
    result = run("tca", "--json", path)
    assert result.exit_code == 1
    data = strict_json(result.stdout)
    assert data["mounting"] == dict.fromkeys(("dw1", "dw2", "rw1", "rw2")) | {"pitch_point": [None] * 3}
    assert "nan" not in run("tca", path).stdout


def test_unknown_positions() -> None:
    """Unknown numbers are null in JSON and empty cells in CSV, and the text shows the name of the status."""
    found = contact_report("pair", builtin_design(), "right", 3)
    missing = np.array([1.0, np.nan, 1.0])
    status = np.array([Status.SOLVED, Status.SEVERAL_CONTACTS, Status.SOLVED], dtype=np.int8)
    scaled = {name: getattr(found.path, name) * missing for name in ("pinion_roll", "l1")}
    path = replace(found.path, status=status, point=found.path.point * missing[:, None], **scaled)
    ends = replace(path.ends, contact_ratio=np.array(np.nan))
    holed = replace(found, path=replace(path, ends=ends))
    data = strict_json(json_text(holed.data()))
    assert data["contact_ratio"] is None
    assert data["path"]["l1"][1] is None
    assert data["path"]["point"][1] == [None] * 3
    assert data["path"]["status"] == ["solved", "several_contacts", "solved"]
    rows = list(csv.DictReader(io.StringIO(csv_text(holed.rows()))))
    assert (rows[1]["l1_mm"], rows[1]["point_z_mm"], rows[1]["status"]) == ("", "", "several_contacts")
    table = holed.summary()
    assert table.splitlines()[7].split() == ["several_contacts"]
    assert "contact ratio      not known" in table


# design, check, help


def test_design_prints_a_valid_file() -> None:
    printed = run("design")
    assert printed.exit_code == 0
    assert parse_design(printed.stdout) == builtin_design()
    checked = run("check")
    assert (checked.exit_code, checked.stderr) == (0, "")
    assert checked.stdout.endswith("No warnings.\n")


def test_design_lists_and_prints_by_name() -> None:
    listed = run("design", "--list").stdout.splitlines()
    assert [line.split()[0] for line in listed] == list(BUILTINS)
    for name in BUILTINS:
        assert run("design", name).stdout == builtin_text(name)
    assert run("design").stdout == builtin_text("ni-2017")
    assert "of marine-gearbox, right flanks" in run("tca", "marine-gearbox", "--points", "2").stdout


@pytest.mark.parametrize("command", ["design", "check", "tca", "mesh --part pinion --out a.stl"])
def test_unknown_design_name(command: str) -> None:
    first, *options = command.split()
    line = refused(first, "marine", *options)
    assert line.endswith(f"{', '.join(BUILTINS)}\n")
    assert "marine'" in line or line.startswith("Error: marine: cannot be read")


def test_check_as_json() -> None:
    data = json_of("check", "ni-2017")
    assert data["errors"] == data["warnings"] == data["advice"] == []
    assert [text.split(":")[0] for text in data["notes"]] == ["right flanks"]


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("face_width = 50.0", "face_width = 3.0", "the contact reaches the pinion's"),
        ("shaft_angle_deg = 15.0", "shaft_angle_deg = 14.0", "no common normal at a shaft angle of 14 deg"),
        ("profile_shift = 0.17", "profile_shift = -1.5", "the right flank of the pinion is undercut"),
        ("addendum = 1.0", "addendum = 1.6", "the tooth of the pinion is pointed at the heel"),
        ("addendum = 1.0", "addendum = 2.2", "the tooth of the pinion is pointed along the complete face"),
    ],
)
def test_check_warns(design_file: Callable[..., Path], old: str, new: str, warning: str) -> None:
    """The exit status of `check` is 0 with warnings only, 1 with an error, and 4 with a failed
    calculation."""
    path = design_file({old: new})
    result = run("check", path)
    assert "No warnings" not in result.stdout
    data = strict_json(run("check", "--json", path).stdout)
    assert any(warning in text for text in data["errors"] + data["warnings"])
    assert "nan" not in result.stdout
    expected = 1 if data["errors"] else 4 if data["unknowns"] else 0
    assert (result.exit_code, result.stderr.count("\n")) == (expected, int(expected > 0))


def test_check_where_no_layout_is_without_backlash(design_file: Callable[..., Path]) -> None:
    path = design_file({"profile_shift = 0.17": "profile_shift = -2.2"})
    assert "no layout without backlash" in words_of("check", path, status=1)
    assert strict_json(run("check", "--json", path).stdout)["zero_backlash"] is None


def test_help_has_complete_summaries() -> None:
    """The list of commands contains the complete first paragraph of each help text."""
    listed = run("--help").stdout
    for name, command in main.commands.items():
        shown = run(name, "--help")
        assert (shown.exit_code, shown.stdout[:6]) == (0, "Usage:")
        summary = " ".join(str(command.help).partition("\n\n")[0].split())
        assert f"{name} {summary} " in " ".join(listed.split()) + " "
        assert summary in " ".join(shown.stdout.split())
    assert "..." not in listed.partition("Options:")[2]


def test_file_name_that_is_not_text(tmp_path: Path) -> None:
    name = os.fsdecode(os.fsencode(tmp_path) + b"/\xe9.toml")
    Path(name).write_text(builtin_text(), encoding="utf-8")
    result = run("tca", "--json", name)
    assert result.exit_code == 0
    assert strict_json(result.stdout)["design"].endswith(".toml")


def test_failure_of_the_five_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: object) -> None:
        raise ArithmeticError("the five equations lose the contact at pinion roll 1.0000 deg")

    monkeypatch.setattr("beveloid_geom.validation.five_equations.follow_five_equations", lost)
    result = run("tca", "--method", "five-equation")
    assert (result.exit_code, result.stdout) == (4, "")
    assert result.stderr == "Error: the five equations lose the contact at pinion roll 1.0000 deg\n"


PICTURES = "matplotlib", "pyvista", "vtkmodules"
SURFACE = "mesh --tolerance 0.05"
SLOW: dict[str, tuple[str, ...]] = {
    "tca --help": ("numpy", "scipy", "pydantic", "beveloid_viz", *PICTURES),
    "design": ("scipy", "beveloid_viz", *PICTURES),
    "tca --points 3": ("scipy", "beveloid_viz", *PICTURES),
    "check ni-2017": ("beveloid_viz", *PICTURES),
    "mesh --help": ("numpy", "scipy", "trimesh", "meshio", "tqdm", "pyvista", "OCP"),
    f"{SURFACE} --part pinion-tooth --out a.vtp": ("trimesh", "meshio", "OCP", "pyvista", "beveloid_viz"),
    f"{SURFACE} --part gear-tooth --out a.stl": ("OCP", "pyvista", "vtkmodules", "beveloid_viz"),
    "mesh --part gear-flank --out a.vtu": ("trimesh", "meshio", "OCP", "pyvista", "beveloid_viz"),
}


@pytest.mark.parametrize("command", SLOW)
def test_imports_of_commands(tmp_path: Path, command: str) -> None:
    imported = imported_by(*command.split(), folder=tmp_path)
    assert "beveloid_geom.cli.main" in imported
    assert not imported & set(SLOW[command])


def test_operation_of_a_pair_that_jams() -> None:
    """The contact ratios in operation and the pattern are not known."""
    result = run("operation", "--offset-error", "-0.5", "--points", "3")
    assert result.exit_code == 1
    assert "not known (jammed) in operation" in " ".join(result.stdout.split())
    assert "the contact pattern" not in result.stdout
    data = strict_json(run("operation", "--offset-error", "-0.5", "--points", "3", "--json").stdout)
    for name in ("operating_contact_ratio", "operating_contact_ratio_within_film"):
        assert data[name] is None
        assert data[f"{name}_reason"] == "jammed"
