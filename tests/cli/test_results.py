"""All commands that print a result, by one contract: in JSON the numbers are the library's, in CSV the same,
in a text of 100 columns its words; what cannot be had ends with one line and its exit status."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
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
    ease_off,
    map_of,
    mesh_cycle,
    mounted_backlash,
    optimise_parabola,
    path_of_contact,
    path_sensitivity,
    sliding_of,
    tolerance_study,
    zero_backlash_layout,
)
from beveloid_geom.analysis.maps import FIGURES
from beveloid_geom.analysis.place import place_path
from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.cli.main import main
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.closing import closing_of
from beveloid_geom.pair.errors import ERROR_NAMES
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.studies.statements import paper_statements
from beveloid_geom.workshop.balls import ball_planes, balls_at
from beveloid_geom.workshop.grid import measuring_grid
from beveloid_geom.workshop.shim import shim
from beveloid_geom.workshop.tooth_data import backlash_change, tooth_data
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
    mounting = mounting_of(design)
    return {
        "contact_ratio": path.ends.contact_ratio,
        "method": "one-equation",
        "ends/enter": {"member": "gear", "limit": "tip"},
        "layout/offset": 229.0,
        "layout/shaft_angle": math.radians(15.0),
        "mounting/dw2": mounting.distance[1],
        "mounting/rw1": mounting.working_radius[0],
        "mounting/pitch_point": mounting.pitch_point,
        "normal_backlash": mounting.normal_backlash,
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


def place(design: Design) -> Mapping[str, Any]:
    found = place_path(design, (0.5,), ("offset", "shaft_angle"), "left")
    return {
        "by": ["offset", "shaft_angle"],
        "trade": ["E", "Sigma"],
        "wanted_l": found.wanted_l,
        "places/0/status": "reached",
        "places/0/shaft_angle_error": found.errors[0, 1],
        "places/0/contact_ratio": found.contact_ratio[0],
        "places/0/cycle_peak_to_peak": found.cycle_peak_to_peak[0],
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
        "errors_of_derivatives": list(ERROR_NAMES),
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


def ease_off_(design: Design) -> Mapping[str, Any]:
    found, plain = ease_off(design, "left", (4, 5)), ease_off(builtin_design(), "right", (4, 5))
    own = {f"left/as_given/{name}": getattr(found, name) for name in ("l", "z", "deviation", "pinion_roll")}
    own |= {f"left/as_given/second_order/{k}": v for k, v in vars(found.second_order).items()}
    own |= {f"right/without_parabola/corners/{k}": v for k, v in plain.corners.items()}
    return {**own, "right/without_parabola/deviation": plain.deviation, "parabola/gear": -0.001}


STUDIED = Tolerances(8.0, math.radians(0.01), 0.1, 0.2, "uniform")


@cache
def studied() -> ToleranceStudy:
    """Of which some mountings lose their path."""
    return tolerance_study(builtin_design().with_parabola(0.001, -0.001), STUDIED, "left", 40, seed=4)


def tolerance(design: Design) -> Mapping[str, Any]:
    study = studied()
    assert study.status_counts()[Status.OFF_FLANK] * study.limits_changed() > 0
    return {
        "tolerances": {
            **dict(zip(STUDIED.names, STUDIED.values().tolist(), strict=True)),
            **{"distribution": "uniform", "sigmas": 3.0},
        },
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
        **{f"map/{name}": getattr(found, name) for name in FIGURES},
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


def gear_data(design: Design) -> Mapping[str, Any]:
    found, plain = tooth_data(design.pinion, (0.0, -0.05, -0.1)), tooth_data(design.gear)
    balls = balls_at(design.gear, 12.0, ball_planes(design.gear, 12.0))
    least = float(mounted_backlash(design).normal)
    return {
        "backlash_by_thickness/lower": least + float(backlash_change(design, -0.1, 0.0)),
        "pinion/chordal_height/upper": found.chordal_height[1],
        "pinion/normal_thickness/lower": found.normal_thickness[2],
        "pinion/ball_diameter": 10.5,
        "gear/form_diameter/left": plain.form_diameter[1],
        "gear/swivel": plain.swivel,
        "gear/ball_dimension/nominal": balls.dimension[0],
        "gear/ball_status/nominal": ["measured"] * 3,
    }


def grid(design: Design) -> Mapping[str, Any]:
    found = measuring_grid(design.gear, 3, 4, border_mm=2.0)
    x, y, _ = found.point.reshape(-1, 3).T
    return {
        "member": "gear",
        "border": "2 mm",
        "middle_angle": found.middle,
        "points/x": x,
        "points/y": y,
        "points/row": np.tile(np.repeat([1, 2, 3], 4), 2),
        "points/normal": found.normal.reshape(-1, 3),
    }


def shim_(design: Design) -> Mapping[str, Any]:
    found = shim(design.with_errors(Errors(offset=-0.1)), 0.1, None, "left")
    return {
        "wanted_backlash": 0.1,
        "shim/status": "reached",
        "shim/pinion_axial": found.axial[0],
        "shim/gear_mounting": found.distance[1],
        "shim/z": found.z,
        "shim/contact_ratio": found.contact_ratio,
        "layout/errors/offset": -0.1,
    }


def check(design: Design) -> Mapping[str, Any]:
    closing, layout = closing_of(design), zero_backlash_layout(design)
    return {
        "closing/shaft_angle_difference": closing.shaft_angle_difference,
        "zero_backlash/offset": layout.offset,
        "zero_backlash/mounting": layout.mounting,
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
    "place": Case(
        (*LEFT, *MODIFIED, "--at", "50", "--by", "E,sigma"),
        place,
        {"z_mm": "places/0/z", "offset_error_mm": "places/0/offset_error"},
        ("face, % E, mm Sigma, deg", "reached", "E: offset, Sigma: shaft angle", "centred in profile"),
    ),
    "ease-off": Case(
        (*MODIFIED, "--grid", "4", "5"),
        ease_off_,
        {},
        (
            "crowning along the face 5.2",
            "right flanks right flanks left flanks left flanks",
            "where the flanks part",
        ),
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
        {"contact_ratio": "map/contact_ratio", "shift_mm": "map/shift", "centre_mm": "map/centre"},
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
    "gear-data": Case(
        (*MODIFIED, "--pinion-allowances", "-0.05", "-0.1", "--gear-ball", "12"),
        gear_data,
        {},
        ("over balls of 12 mm", "lower, at -0.1 mm", "root cone 3.0000 deg", "at the upper allowances"),
    ),
    "grid": Case(
        (*MODIFIED, "--member", "gear", "--rows", "3", "--columns", "4", "--border", "2mm"),
        grid,
        {"flank": "points/flank", "column": "points/column", "x_mm": "points/x", "z_mm": "points/z"},
        ("gear, 45 teeth: 3 rows, 4 columns, border 2 mm", "toe at z = -30 mm", "# unit: mm", "left 3 4"),
    ),
    "shim": Case(
        (*LEFT, *MODIFIED, "--offset", "228.9", "--backlash", "0.1"),
        shim_,
        {},
        ("for a normal backlash of 0.1 mm", "move the pinion +", "left flanks: middle of the path at z ="),
    ),
    "statements": Case(LEFT, statements, {}, ("does not hold", "left flanks", "says a1 > 0 > a2")),
    "check": Case(
        MODIFIED,
        check,
        {},
        ("2.2109 mm apart", "E = 229.0751 mm (+0.0751) at this shaft angle", "E = 228.8373 mm"),
    ),
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
    assert set(CASES) == set(main.commands) - {"design", "mesh", "propose"}


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
