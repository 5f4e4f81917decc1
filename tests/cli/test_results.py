"""All commands that print a result, by one contract: in JSON the numbers are the library's, in CSV the same,
in a text of 100 columns its words; what cannot be had ends with one line and its exit status."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result

from beveloid_geom import (
    Aim,
    Design,
    Errors,
    Status,
    Tolerances,
    builtin_design,
    certify,
    contact_pattern,
    map_of,
    mesh_cycle,
    optimise_parabola,
    path_of_contact,
    path_sensitivity,
    sliding_of,
    tolerance_study,
)
from beveloid_geom.analysis.maps import FIGURES
from beveloid_geom.analysis.sensitivity import ERRORS
from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.cli.main import main
from beveloid_geom.design.file import builtin_text
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.closing import closing_of
from beveloid_geom.status import Limit
from beveloid_geom.studies.statements import paper_statements
from tests.cli.running import rows_of, run, strict_json

MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")
NARROW = ("--pinion-bounds", "0", "0.0005", "--gear-bounds", "-0.0005", "0")
OFFSET = ("--offset-tolerance", "0.05")
DRAWN = (
    *("--offset-tolerance", "8", "--shaft-angle-tolerance-deg", "0.01", "--pinion-axial-tolerance", "0.1"),
    *("--gear-axial-tolerance", "0.2", "--distribution", "uniform", "--cases", "40", "--seed", "4"),
)


@dataclass(frozen=True)
class Case:
    """A command with `arguments`: the library's values by their place in JSON, the place in JSON by the
    header in CSV, words of the text; and arguments under which there is nothing, and why."""

    arguments: tuple[str, ...]
    library: Callable[[Design], Mapping[str, Any]]
    columns: Mapping[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    why: str = ""


def tca(design: Design) -> Mapping[str, Any]:
    path = path_of_contact(design, "left", 7)
    names = ("l1", "pinion_roll", "gear_z", "point", "normal", "transmission_error")
    return {
        "contact_ratio": path.ends.contact_ratio,
        "method": "one-equation",
        "ends/enter": {"member": "gear", "limit": "tip"},
        "layout/offset": 229.0,
        "layout/shaft_angle": math.radians(15.0),
        "parabola/gear": -0.001,
        "path/status": ["solved"] * 7,
        "certificate/separation": certify(path).separation,
        **{f"path/{name}": getattr(path, name) for name in names},
    }


def operation(design: Design) -> Mapping[str, Any]:
    cycle = mesh_cycle(design, "left", 6)
    return {
        "contact_ratio": path_of_contact(design, "left", 2).ends.contact_ratio,
        "operating_contact_ratio_within_film": operating_ratio(design, "left", 0.01),
        "peak_to_peak": cycle.peak_to_peak,
        "amplitudes": np.abs(cycle.harmonics),
        "positions/status": ["solved"] * 25,
    }


def sliding(design: Design) -> Mapping[str, Any]:
    found = sliding_of(path_of_contact(design, "left", 5))
    numbers = {"speed": found.speed, "gear_specific": found.specific[:, 1], "sliding": found.sliding}
    return {f"positions/{name}": values for name, values in numbers.items()}


def sensitivity(design: Design) -> Mapping[str, Any]:
    found = path_sensitivity(design, "left")
    values = ("l", "z", "r", "pinion_roll", "contact_ratio", "peak_to_peak")
    names = (*values, *(f"{name}_by" for name in values), "face_shift_by", "square_shift_by")
    return {name: getattr(found, name) for name in names} | {
        "errors_of_derivatives": list(ERRORS),
        "limits": ["gear tip", "pinion tip"],
    }


def pattern(design: Design) -> Mapping[str, Any]:
    found = contact_pattern(design, "left", 0.01, resolution=2.0)
    z = found.gear.z[found.gear.marked]
    sizes = ("area", "area_share", "area_error")
    return {
        "roll_range": found.roll_range,
        "gear/z_range": [z.min(), z.max()],
        **{f"pinion/{name}": getattr(found.pinion, name) for name in sizes},
    }


STUDIED = Tolerances(8.0, math.radians(0.01), 0.1, 0.2, "uniform")


@cache
def studied() -> ToleranceStudy:
    """Of which some mountings lose their path."""
    return tolerance_study(builtin_design().with_parabola(0.001, -0.001), STUDIED, "left", 40, seed=4)


def tolerance(design: Design) -> Mapping[str, Any]:
    study = studied()
    assert study.status_counts()[Status.OFF_FLANK] * study.limits_changed() > 0
    return {
        "tolerances": vars(STUDIED),
        "cases": 40,
        "seed": 4,
        "flank": "left",
        "status/solved": int(study.mountings.solved.sum()),
        "status/off_flank": study.status_counts()[Status.OFF_FLANK],
        "limits_changed": study.limits_changed(),
        "nominal/enter": "gear_tip",
        **{f"quantiles/{name}": values for name, values in study.quantiles().items()},
    }


def map_(design: Design) -> Mapping[str, Any]:
    found = map_of(builtin_design(), "parabola", "left", steps=3, errors=Errors(offset=0.05))
    return {
        "over": "parabola",
        "errors/offset": 0.05,
        "pinion": found.pinion,
        **{f"map/{name}": getattr(found, name) for name in FIGURES if name != "flank_share"},
        "map/hollow": found.hollow,
    }


def optimise(design: Design) -> Mapping[str, Any]:
    aim = Aim(
        Errors(offset=0.05, shaft_angle=math.radians(0.005)),
        contact_ratio=1.7,
        peak_to_peak=math.radians(20.0 / 3600.0),
        pinion_parabola=(0.0, 0.0005),
        gear_parabola=(-0.0005, 0.0),
    )
    found = optimise_parabola(builtin_design(), aim)
    return {
        "aim/errors": vars(aim.errors),
        "aim/peak_to_peak": aim.peak_to_peak,
        "parabola/pinion": found.pinion_parabola,
        "parabola/gear": found.gear_parabola,
        "found/shift": found.found.shift,
        "given/contact_ratio": found.given.contact_ratio,
        **{f"found/{name}": value for name, value in vars(found.found_operation).items()},
    }


def statements(design: Design) -> Mapping[str, Any]:
    judged = paper_statements(builtin_design(), "left")
    return {f"{k}/verdict": one.verdict.value for k, one in enumerate(judged)} | {"0/id": judged[0].id}


def check(design: Design) -> Mapping[str, Any]:
    closing = closing_of(design)
    return {
        "closing/offset": closing.offset,
        "closing/gap": closing.gap,
        "normal_backlash": closing.normal_backlash,
    }


LEFT = ("--flank", "left")
CASES = {
    "tca": Case(
        (*LEFT, *MODIFIED, "--points", "7"),
        tca,
        {
            "l1_mm": "path/l1",
            "transmission_error_rad": "path/transmission_error",
            "status": "path/status",
            "verdict": "certificate/verdict",
        },
        ("E = 229 mm, shaft angle = 15 deg", "pinion 0.001 1/mm", "leaves at the pinion's tip"),
        ("--offset-error", "50"),
        "the path of contact does not meet the left flanks",
    ),
    "operation": Case(
        (*LEFT, *MODIFIED, "--points", "25", "--harmonics", "6", "--film", "0.01"),
        operation,
        {"transmission_error_rad": "positions/transmission_error", "carried_by": "positions/carried_by"},
        ("by Eq. 16; in operation", "within 10 um of touching", "pitches into the cycle"),
        ("--parabola-pinion", "-0.01"),
        "no first contact of the left teeth: a member is undercut",
    ),
    "sliding": Case(
        (*LEFT, *MODIFIED, "--points", "5"),
        sliding,
        {"speed_mm_per_rad": "positions/speed", "pinion_specific": "positions/pinion_specific"},
        ("deg of pinion roll", "enters at the gear's tip, leaves at the pinion's tip"),
        ("--offset-error", "50"),
        "the path of contact does not meet the left flanks",
    ),
    "sensitivity": Case(
        (*LEFT, *MODIFIED),
        sensitivity,
        {},
        ("pinion, along the face, mm", "exact derivatives, times the errors named"),
        ("--offset-error", "20"),
        "no path of contact on the left flanks: off flank",
    ),
    "pattern": Case(
        (*LEFT, *MODIFIED, "--resolution", "2", "--separation", "0.01"),
        pattern,
        {},
        ("10 um thick", "mm^2 marked", "% of the active flank", "least separation"),
    ),
    "tolerance": Case(
        (*LEFT, *MODIFIED, *DRAWN),
        tolerance,
        {},
        ("40 mountings, seed 4", "offset 8 mm", "gear axial 0.2 mm; uniform", "pinion z middle, mm"),
    ),
    "map": Case(
        (*LEFT, *OFFSET, "--steps", "3"),
        map_,
        {"contact_ratio": "map/contact_ratio", "shift_mm": "map/shift", "flank_share": "map/flank_share"},
        ("3 x 3 cells", "errors for shift offset +0.05 mm", "hollow against each other"),
        ("--offset-error", "30"),
        "no cell of the map has a path on the left flanks",
    ),
    "optimise": Case(
        (
            *(*OFFSET, "--shaft-angle-tolerance-deg", "0.005", "--contact-ratio", "1.7"),
            *("--transmission-error-arcsec", "20", *NARROW),
        ),
        optimise,
        {},
        (
            "contact ratio at least 1.7, middle within 1 mm of mid-face",
            "pinion 0 to 0.0005",
            "errors of the aim offset +0.05 mm, shaft angle +0.005 deg",
            "as given",
        ),
    ),
    "statements": Case(LEFT, statements, {}, ("does not hold", "left flanks")),
    "check": Case(
        MODIFIED,
        check,
        {},
        ("2.2109 mm apart", "E = 229.0751 mm (+0.0751) at this shaft angle", "E = 228.8373 mm"),
    ),
}
BAD = {
    "tca": ("--points 1", "--points 100001", "--points ten", "--method six-equation", "--offset-error much"),
    "operation": ("--film -1", "--film nan", "--film thick", "--harmonics 0", "--points 1"),
    "sliding": ("--points 1",),
    "pattern": ("--separation 0", "--resolution 0.01"),
    "tolerance": (
        *(
            "",
            "--offset-tolerance -1",
            "--offset-tolerance nan",
            "--offset-tolerance 229",
            "--offset-tolerance 1 missing.toml",
        ),
        *(f"--offset-tolerance 1 {more}" for more in ("--sigmas 0", "--sigmas nan", "--cases 0", "--jobs 0")),
        *("--offset-tolerance 1 --seed -1", "--shaft-angle-tolerance-deg 6"),
    ),
    "map": (
        *("--over colour", "--steps 1", "--pinion-bounds 0", "--pinion-bounds 1 0", "--gear-bounds -0.1 0.1"),
        *(
            "--gear-bounds nan 0.1",
            "--over shift --gear-bounds 0 4",
            "--offset-tolerance 300",
            "missing.toml",
        ),
    ),
    "optimise": (
        *("", "--offset-tolerance nan", "--offset-tolerance wide", "--offset-tolerance 1 missing.toml"),
        *("--offset-tolerance 1 --off-centre 0", "--offset-tolerance 1 --pinion-bounds 1 0"),
        f"--offset-tolerance 1 --contact-ratio 4 {' '.join(NARROW)}",
        "--offset-tolerance 1 --no-edges yes",
    ),
    "statements": ("missing.toml",),
    "check": ("missing.toml", "--parabola-pinion nan", "ni-2017 ni-2017"),
    "sensitivity": ("--twist 1",),
}
RENAMED = {
    "--shaft-angle-error": ("tca", "--shaft-angle-error-deg"),
    "--transmission-error": ("optimise", "--transmission-error-arcsec"),
    "--offset": ("tolerance", "--offset-tolerance"),
    "--shaft-angle-deg": ("map", "--shaft-angle-tolerance-deg"),
    "--pinion-axial": ("optimise", "--pinion-axial-tolerance"),
    "--gear-axial": ("tolerance", "--gear-axial-tolerance"),
}
by_command = pytest.mark.parametrize("command", CASES)


@cache
def printed(command: str, form: str = "") -> Result:
    """What a command prints in its case, as 'json', 'csv' or text."""
    result = run(command, *CASES[command].arguments, *([f"--{form}"] if form else []))
    assert (result.exit_code, result.stderr) == (0, ""), result.stderr
    return result


def at(data: Any, place: str) -> Any:
    """The entry of JSON at a place as path/l1."""
    for key in place.split("/"):
        data = data[int(key) if isinstance(data, list) else key]
    return data


def test_no_command_is_left_out() -> None:
    assert set(CASES) == set(main.commands) - {"design", "mesh"} == set(BAD)


@by_command
def test_json_is_the_librarys(command: str) -> None:
    data = strict_json(printed(command, "json").stdout)
    expected = CASES[command].library(builtin_design().with_parabola(0.001, -0.001))
    for place, value in expected.items():
        found = at(data, place)
        if isinstance(value, str | list | dict | None):
            assert found == value, place
        else:
            np.testing.assert_allclose(np.array(found, float), value, rtol=1e-9, atol=1e-12, err_msg=place)


@by_command
def test_csv_is_the_json(command: str) -> None:
    rows, data = rows_of(printed(command, "csv")), strict_json(printed(command, "json").stdout)
    assert rows
    for header, place in CASES[command].columns.items():
        values = np.ravel(at(data, place)).tolist()
        assert [row[header] for row in rows] == ["" if v is None else str(v) for v in values], header


@by_command
def test_text_says_it_in_words(command: str) -> None:
    text = printed(command).stdout
    assert max(map(len, text.splitlines())) <= 100
    assert "nan" not in text.replace("nance", "")
    assert all(words in " ".join(text.split()) for words in CASES[command].words)


@pytest.mark.parametrize("command", [name for name, case in CASES.items() if case.lost])
def test_what_cannot_be_had_is_said_and_is_status_1(command: str) -> None:
    """In JSON as the reason, beside the other forms in a line."""
    case = CASES[command]
    text, rows, data = (
        run(command, *case.arguments, *case.lost, *form) for form in ((), ("--csv",), ("--json",))
    )
    assert (text.exit_code, rows.exit_code, data.exit_code) == (1, 1, 1)
    assert text.stderr == rows.stderr
    assert text.stderr.startswith(f"No contact: {case.why}")
    reason = {"sensitivity": case.why}.get(command) or strict_json(data.stdout)["reason"]
    assert (data.stderr, text.stderr) == ("", f"No contact: {reason}\n")
    if command != "map":
        assert strict_json(data.stdout)["contact_ratio"] in (0.0, None) or command == "operation"
    if command in ("tca", "sliding", "sensitivity"):
        assert rows.stdout.count("\n") == 1


@pytest.mark.parametrize("command", ["tca", "operation", "sensitivity", "pattern"])
def test_a_jammed_pair_is_told(command: str) -> None:
    """Errors of mounting use up the backlash of the layout: no certificate, exit status 1."""
    few = {"pattern": ("--resolution", "2"), "operation": ("--points", "3")}
    given = ("--offset-error", "-0.5", *few.get(command, ()))
    result, data, table = (run(command, *given, *form) for form in ((), ("--json",), ("--csv",)))
    words, found = " ".join(result.stdout.split()), strict_json(data.stdout)
    assert "backlash -0.313020 mm with errors and parabolas" in words
    assert "the pair cannot be assembled" in words
    assert result.stderr.startswith("Jammed: the pair cannot be assembled: the other flanks interfere")
    assert (result.exit_code, table.exit_code, data.exit_code, data.stderr) == (1, 1, 1, "")
    assert found["jammed"] is True
    assert "certificate" not in found
    assert found["normal_backlash"] == pytest.approx(0.0416, abs=5e-5)
    assert found["mounted_backlash"]["normal"] == pytest.approx(-0.3130, abs=5e-5)
    assert found["mounted_backlash"]["left"]["edges"] == []
    backlash = {row["mounted_backlash_mm"] for row in rows_of(table) if "mounted_backlash_mm" in row}
    assert {float(value) for value in backlash} <= {found["mounted_backlash"]["normal"]}


@pytest.mark.parametrize(
    ("command", "arguments"),
    [(command, one) for command, all_ in BAD.items() for one in (*all_, "--flank up", "--json --csv")],
)
def test_bad_input_is_one_line(command: str, arguments: str) -> None:
    result = run(command, *arguments.split())
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("old", RENAMED)
def test_an_old_name_of_an_option_leads_to_the_new_one(old: str) -> None:
    command, new = RENAMED[old]
    result = run(command, old, "0.01")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"Error: {old} has a new name: write {new}\n"
    assert f"{old} " not in run(command, "--help").stdout
    assert f"{new} " in run(command, "--help").stdout


def test_tolerances_that_are_missing_are_named() -> None:
    named = (
        "give --offset-tolerance, --shaft-angle-tolerance-deg, --pinion-axial-tolerance or "
        "--gear-axial-tolerance\n"
    )
    assert run("optimise").stderr == f"Error: no errors that shift the path: {named}"
    assert run("tolerance").stderr == f"Error: no tolerances: {named}"


# Single commands


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


def test_mountings_none_of_which_has_a_path(tmp_path: Path) -> None:
    source = tmp_path / "far.toml"
    source.write_text(builtin_text().replace("[errors]\noffset = 0.0", "[errors]\noffset = 4.0"))
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


@pytest.mark.slow
def test_readings_have_the_same_verdicts_in_all_forms() -> None:
    given = ("statements", "--readings", *LEFT)
    data, rows = strict_json(run(*given, "--json").stdout), rows_of(run(*given, "--csv"))
    judged = {one.id: one.verdict.value for one in paper_statements(builtin_design(), "left")}
    assert data[0]["verdicts"] == judged
    assert rows == [{"flank": one["flank"], "reading": one["reading"], **one["verdicts"]} for one in data]


def test_csv_of_an_optimum_has_found_and_given() -> None:
    data = strict_json(printed("optimise", "json").stdout)
    assert 0 < data["certified"]["first_contact"] <= data["certified"]["positions"]
    for row, name in zip(rows_of(printed("optimise", "csv")), ("found", "given"), strict=True):
        assert row["design"] == name
        assert float(row["shift_mm"]) == data[name]["shift"]
        assert float(row["pinion_z_middle_mm"]) == data[name]["centre"]
        assert float(row["edge_share"]) == data[name]["edge_share"]
        assert float(row["greatest_cycle_peak_to_peak_rad"]) == data[name]["greatest_cycle_peak_to_peak"]
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


def test_cells_of_a_map_that_are_lost_are_empty() -> None:
    given = (
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
    )
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


def test_a_map_without_a_ratio_to_keep_and_one_with_first_contacts(tmp_path: Path) -> None:
    source = tmp_path / "thin.toml"
    text = builtin_text().replace("face_width = 50.0", "face_width = 0.1")
    source.write_text(text.replace("face_width = 60.0", "face_width = 0.1"), encoding="utf-8")
    result = run("map", source, "--steps", "4")
    assert result.exit_code == 0
    assert "The design itself has no contact ratio to be kept" in result.stdout
    bounds = ("--pinion-bounds", "-0.0005", "0.0005", "--gear-bounds", "-0.0005", "0")
    found = strict_json(run("map", "--first-contacts", "--steps", "2", "--json", *bounds, *OFFSET).stdout)
    shares = np.array(found["map"]["flank_share"])
    assert shares[0, 0] == 1.0
    assert ((shares >= 0.0) & (shares <= 1.0)).all()


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_a_parabola_is_not_ignored_where_the_map_is_over_it(member: str) -> None:
    result = run("map", "--steps", "2", f"--parabola-{member}", "0.001")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == (
        f"Error: --parabola-{member}: the map itself is over the parabola coefficients: "
        f"give --{member}-bounds, or another --over\n"
    )


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
    assert "621.8 mm^2 marked, 94.6 % of the active flank" in text
    assert "right to 0.27 % of the area" in text
    text = run("sliding", "--points", "3").stdout
    assert "24.7209 to 34.9430 mm/rad, least at 9.4857 deg of pinion roll" in text
    assert "pinion -0.9495 to 0.4300, gear -0.9408 to 0.5551" in text
    text = run("operation", "--points", "25", *MODIFIED).stdout
    assert "1.816308 by Eq. 16; in operation 1.000000, 2.299395 within 6.35 um" in text
    assert "1.8107 arcsec peak to peak" in text
    assert "carry 18.1 % of the cycle" in text
