"""Test case for each command that prints a result: arguments, library values, parts of the text."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from click.testing import Result

import beveloid_geom as bg
from beveloid_geom import Design
from beveloid_geom.analysis.maps import QUANTITIES
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.misalignment import ERROR_NAMES
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.workshop.balls import ball_planes
from beveloid_geom.workshop.tooth_data import backlash_change
from tests.cli.running import run

MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")
NARROW = ("--pinion-bounds", "0", "0.0005", "--gear-bounds", "-0.0005", "0")
OFFSET = ("--offset-tolerance", "0.05")
AIM = (
    *(*OFFSET, "--shaft-angle-tolerance-deg", "0.005", "--contact-ratio", "1.7"),
    *("--transmission-error-arcsec", "20", *NARROW),
)
DRAWN = (
    *("--offset-tolerance", "8", "--shaft-angle-tolerance-deg", "0.01", "--pinion-axial-tolerance", "0.1"),
    *("--gear-axial-tolerance", "0.2", "--distribution", "uniform", "--cases", "40", "--seed", "4"),
)


@dataclass(frozen=True)
class Case:
    """Test case of a command.

    `library` returns values by their place in JSON, `columns` the place in JSON by header of CSV. `words` are
    parts of the text. With the arguments `lost` there is no result, for the reason `why`."""

    arguments: tuple[str, ...]
    library: Callable[[Design], Mapping[str, Any]]
    columns: Mapping[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    why: str = ""


def tca(design: Design) -> Mapping[str, Any]:
    path = bg.path_of_contact(design, "left", 7)
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
        "certificate/separation": bg.path_certificate(path).separation,
        **{f"path/{name}": getattr(path, name) for name in names},
    }


def operation(design: Design) -> Mapping[str, Any]:
    cycle = bg.mesh_cycle(design, "left", 6)
    return {
        "contact_ratio": bg.path_of_contact(design, "left", 2).ends.contact_ratio,
        "operating_contact_ratio_within_film": operating_ratio(design, "left", 0.01),
        "peak_to_peak": cycle.peak_to_peak,
        "amplitudes": np.abs(cycle.harmonics),
        "positions/status": ["solved"] * 25,
    }


def place(design: Design) -> Mapping[str, Any]:
    found = bg.place_path(design, (0.5,), ("offset", "shaft_angle"), "left")
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
    found = bg.path_sliding(bg.path_of_contact(design, "left", 5))
    numbers = {"speed": found.speed, "gear_specific": found.specific[:, 1], "sliding": found.sliding}
    return {f"positions/{name}": values for name, values in numbers.items()}


def sensitivity(design: Design) -> Mapping[str, Any]:
    found = bg.path_sensitivity(design, "left")
    values = ("l", "z", "r", "pinion_roll", "contact_ratio", "peak_to_peak")
    names = (*values, *(f"{name}_by" for name in values), "face_shift_by", "square_shift_by")
    return {name: getattr(found, name) for name in names} | {
        "errors_of_derivatives": list(ERROR_NAMES),
        "limits": ["gear tip", "pinion tip"],
    }


def pattern(design: Design) -> Mapping[str, Any]:
    found = bg.contact_pattern(design, "left", 0.01, resolution=2.0)
    z = np.concatenate(found.gear.border)[:, 2]
    sizes = ("area", "area_share", "area_error")
    return {
        "roll_range": found.roll_range,
        "gear/z_range": [z.min(), z.max()],
        **{f"pinion/{name}": getattr(found.pinion, name) for name in sizes},
    }


def ease_off_(design: Design) -> Mapping[str, Any]:
    found, plain = bg.ease_off(design, "left", (4, 5)), bg.ease_off(bg.builtin_design(), "right", (4, 5))
    values = {
        f"left/as_given/{name}": getattr(found, name) for name in ("l", "z", "deviation", "pinion_roll")
    }
    values |= {f"left/as_given/second_order/{k}": v for k, v in vars(found.second_order).items()}
    values |= {f"right/without_parabola/corners/{k}": v for k, v in plain.corners.items()}
    return {**values, "right/without_parabola/deviation": plain.deviation, "parabola/gear": -0.001}


TOLERANCES = bg.Tolerances(8.0, math.radians(0.01), 0.1, 0.2, "uniform")


@cache
def tolerance_case() -> bg.ToleranceStudy:
    """Return a tolerance study in which some mountings have no path."""
    design = bg.builtin_design().with_parabola(0.001, -0.001)
    return bg.tolerance_study(design, TOLERANCES, "left", 40, seed=4)


def tolerance(design: Design) -> Mapping[str, Any]:
    study = tolerance_case()
    assert study.status_counts()[bg.Status.OFF_FLANK] * study.limits_changed() > 0
    return {
        "tolerances": {
            **dict(zip(TOLERANCES.names, TOLERANCES.values().tolist(), strict=True)),
            **{"distribution": "uniform", "sigmas": 3.0},
        },
        "cases": 40,
        "seed": 4,
        "flank": "left",
        "status/solved": int(study.mountings.solved.sum()),
        "status/off_flank": study.status_counts()[bg.Status.OFF_FLANK],
        "limits_changed": study.limits_changed(),
        "nominal/enter": "gear_tip",
        **{f"quantiles/{name}": values for name, values in study.quantiles().items()},
    }


def map_(design: Design) -> Mapping[str, Any]:
    found = bg.design_map(bg.builtin_design(), "parabola", "left", steps=3, errors=bg.Errors(offset=0.05))
    return {
        "over": "parabola",
        "errors/offset": 0.05,
        "pinion": found.first,
        **{f"map/{name}": getattr(found, name) for name in QUANTITIES},
        "map/hollow": found.hollow,
    }


def modify(design: Design) -> Mapping[str, Any]:
    found = bg.fit_crowning(bg.builtin_design(), math.radians(2.0 / 3600.0), 25.0)
    names = "helix_crowning_um", "profile_crowning_um", "transmission_error", "length", "edge_share"
    return {name: getattr(found, name) for name in names}


def optimise(design: Design) -> Mapping[str, Any]:
    aim = bg.Aim(
        bg.Errors(offset=0.05, shaft_angle=math.radians(0.005)),
        contact_ratio=1.7,
        peak_to_peak=math.radians(20.0 / 3600.0),
        pinion_parabola=(0.0, 0.0005),
        gear_parabola=(-0.0005, 0.0),
    )
    found = bg.optimise_parabola(bg.builtin_design(), aim)
    return {
        "aim/errors": vars(aim.errors),
        "aim/peak_to_peak": aim.peak_to_peak,
        "parabola/pinion": found.pinion_parabola,
        "parabola/gear": found.gear_parabola,
        "found/shift": found.optimum.shift,
        "given/contact_ratio": found.given.contact_ratio,
        **{f"found/{name}": value for name, value in vars(found.optimum_operation).items()},
    }


def statements(design: Design) -> Mapping[str, Any]:
    judged = bg.paper_statements(bg.builtin_design(), "left")
    return {f"{k}/verdict": one.verdict.value for k, one in enumerate(judged)} | {"0/id": judged[0].id}


def gear_data(design: Design) -> Mapping[str, Any]:
    found, plain = bg.tooth_data(design.pinion, (0.0, -0.05, -0.1)), bg.tooth_data(design.gear)
    balls = bg.ball_dimensions(design.gear, 12.0, ball_planes(design.gear, 12.0))
    least = float(bg.mounted_backlash(design).normal)
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
    found = bg.measuring_grid(design.gear, 3, 4, border_mm=2.0)
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
    found = bg.shim(design.with_errors(bg.Errors(offset=-0.1)), 0.1, None, "left")
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
    deviation, layout = bg.layout_deviation(design), bg.zero_backlash_layout(design)
    return {
        "closing/shaft_angle_difference": deviation.shaft_angle_difference,
        "zero_backlash/offset": layout.offset,
        "zero_backlash/mounting": layout.mounting,
        "closing/offset": deviation.offset,
        "closing/gap": deviation.gap,
        "normal_backlash": deviation.normal_backlash,
    }


LEFT = ("--flank", "left")
CASES = {
    "tca": Case(
        (*LEFT, *MODIFIED, "--points", "7"),
        tca,
        columns={
            "l1_mm": "path/l1",
            "transmission_error_rad": "path/transmission_error",
            "status": "path/status",
            "verdict": "certificate/verdict",
        },
        words=("E = 229 mm, shaft angle = 15 deg", "pinion 0.001 1/mm", "leaves at the pinion's tip"),
        lost=("--offset-error", "50"),
        why="the path of contact does not meet the left flanks",
    ),
    "operation": Case(
        (*LEFT, *MODIFIED, "--points", "25", "--harmonics", "6", "--film", "0.01"),
        operation,
        columns={
            "transmission_error_rad": "positions/transmission_error",
            "carried_by": "positions/carried_by",
        },
        words=("of one tooth pair (Eq. 16), ", "with clearances up to 10 um", "pitches into the cycle"),
        lost=("--gear-axial-error", "400"),
        why="no first contact of the left teeth: no tooth reaches the other member",
    ),
    "sliding": Case(
        (*LEFT, *MODIFIED, "--points", "5"),
        sliding,
        columns={"speed_mm_per_rad": "positions/speed", "pinion_specific": "positions/pinion_specific"},
        words=("deg of pinion roll", "enters at the gear's tip, leaves at the pinion's tip"),
        lost=("--offset-error", "50"),
        why="the path of contact does not meet the left flanks",
    ),
    "sensitivity": Case(
        (*LEFT, *MODIFIED),
        sensitivity,
        words=("pinion, along the face, mm", "exact derivatives times the errors below"),
        lost=("--offset-error", "20"),
        why="no path of contact on the left flanks: off flank",
    ),
    "pattern": Case(
        (*LEFT, *MODIFIED, "--resolution", "2", "--separation", "0.01"),
        pattern,
        words=("10 um thick", "mm^2 marked", "% of the active flank", "smallest separation"),
    ),
    "place": Case(
        (*LEFT, *MODIFIED, "--at", "50", "--by", "E,sigma"),
        place,
        columns={"z_mm": "places/0/z", "offset_error_mm": "places/0/offset_error"},
        words=("face, % E, mm Sigma, deg", "reached", "E: offset, Sigma: shaft angle", "centred in profile"),
    ),
    "ease-off": Case(
        (*MODIFIED, "--grid", "4", "5"),
        ease_off_,
        words=(
            "crowning along the face 5.2",
            "right flanks right flanks left flanks left flanks",
            "where the flanks are apart",
        ),
    ),
    "tolerance": Case(
        (*LEFT, *MODIFIED, *DRAWN),
        tolerance,
        words=("40 mountings, seed 4", "offset 8 mm", "gear axial 0.2 mm; uniform", "pinion z middle, mm"),
    ),
    "map": Case(
        (*LEFT, *OFFSET, "--steps", "3"),
        map_,
        columns={"contact_ratio": "map/contact_ratio", "shift_mm": "map/shift", "centre_mm": "map/centre"},
        words=(
            "3 x 3 cells",
            "errors for shift offset +/-0.05 mm; each alone, in both directions",
            "the relative curvature of the flanks is negative",
        ),
        lost=("--offset-error", "30"),
        why="no cell of the map has a path on the left flanks",
    ),
    "modify": Case(
        ("--transmission-error-arcsec", "2", "--length", "25"),
        modify,
        columns={"helix_crowning_um": "helix_crowning_um", "length_mm": "length"},
        words=(
            "helix crowning",
            "2 arcsec peak to peak",
            "25 mm along the face of the pinion",
            "edge contact none",
        ),
    ),
    "optimise": Case(
        AIM,
        optimise,
        words=(
            "contact ratio at least 1.7, middle within 1 mm of mid-face",
            "pinion 0 to 0.0005",
            "errors offset +/-0.05 mm, shaft angle +/-0.005 deg",
            "as designed",
        ),
    ),
    "gear-data": Case(
        (*MODIFIED, "--pinion-allowances", "-0.05", "-0.1", "--gear-ball", "12"),
        gear_data,
        words=("over balls of 12 mm", "lower, at -0.1 mm", "root cone 3.0000 deg", "at the upper allowances"),
    ),
    "grid": Case(
        (*MODIFIED, "--member", "gear", "--rows", "3", "--columns", "4", "--border", "2mm"),
        grid,
        columns={"flank": "points/flank", "column": "points/column", "x_mm": "points/x", "z_mm": "points/z"},
        words=(
            "gear, 45 teeth: 3 rows, 4 columns, border 2 mm",
            "toe at z = -30 mm",
            "# unit: mm",
            "left 3 4",
        ),
    ),
    "shim": Case(
        (*LEFT, *MODIFIED, "--offset", "228.9", "--backlash", "0.1"),
        shim_,
        words=(
            "for a normal backlash of 0.1 mm",
            "move the pinion +",
            "left flanks: middle of the path at z =",
        ),
    ),
    "statements": Case(LEFT, statements, words=("does not hold", "left flanks", "paper a1 > 0 > a2")),
    "check": Case(
        MODIFIED,
        check,
        words=("2.2109 mm apart", "E = 229.0751 mm (+0.0751) with this shaft angle", "E = 228.8373 mm"),
    ),
}


@cache
def printed(command: str, form: str = "") -> Result:
    """Return the output of a command in its test case, as 'json', 'csv' or text."""
    result = run(command, *CASES[command].arguments, *([f"--{form}"] if form else []))
    assert (result.exit_code, result.stderr) == (0, ""), result.stderr
    return result
