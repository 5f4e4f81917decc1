"""Arguments that the public functions reject, by a ValueError that names argument, limit and value.

Faults of designs are tested in `tests/design`, and refusals of the commands in `tests/cli/test_refusals.py`.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import inf, nan
from typing import Any

import numpy as np
import pytest

import beveloid_geom as bg
from beveloid_geom.analysis.tolerance import USUAL
from tests.oracle.table1 import table1

TABLE_1 = table1()
BATCH = table1(errors=bg.Errors(offset=np.zeros(3)))
PINION = TABLE_1.pinion
AIM = bg.Aim(bg.Errors(offset=0.05))
TOLERANCES = bg.Tolerances(0.05)
BALL = partial(bg.ball_dimensions, PINION, z=0.0)


def optimise(**changes: Any) -> bg.Optimum:
    return bg.optimise_parabola(TABLE_1, replace(AIM, **changes))


def study(cases: int = 1, **changes: Any) -> bg.ToleranceStudy:
    names = ("seed", "operation", "blocks_per_task")
    options = {name: changes.pop(name) for name in names if name in changes}
    return bg.tolerance_study(TABLE_1, replace(TOLERANCES, **changes), cases=cases, **options)


def spur(teeth: int) -> bg.Member:
    return bg.Member(bg.Tool(2.0, 0.35), teeth, 0.0, 0.0, 0.0, 20.0)


Cases = list[tuple[Callable[..., object], dict[str, Any], str]]


def of(function: Callable[..., object], *cases: tuple[dict[str, Any], str]) -> Cases:
    return [(function, arguments, message) for arguments, message in cases]


FOLDS = "cannot be cut: .* folds the rack profile"
BOUNDS = "of the aim must be two finite bounds"
OVER = "over must be two different errors of offset, shaft_angle"
SINGLE_BORDER = "below 25 mm, half of the face's 50 mm, got 25 mm"
REFUSED: Cases = [
    *of(
        partial(bg.path_of_contact, TABLE_1),
        ({"points": 1}, "points must be a whole number of at least 2, got 1"),
        ({"points": True}, "a whole number"),
        ({"points": 2.0}, "a whole number"),
        ({"points": "7"}, "a whole number"),
        ({"l1": np.zeros((2, 3))}, "l1 must have the shape"),
        ({"l1": np.array(inf)}, "l1 must contain at least one number, and finite numbers only"),
        ({"l1": np.empty(0)}, "l1 must contain at least one number, and finite numbers only"),
    ),
    *of(
        partial(bg.first_contact, TABLE_1, "right"),
        ({"pinion_roll": [0.1, nan]}, "finite"),
        ({"pinion_roll": 0.1, "pairs": (0, 1.5)}, "pairs must contain whole numbers"),
        ({"pinion_roll": 0.1, "pairs": nan}, "pairs must contain whole numbers"),
    ),
    *of(
        partial(bg.pitch_cycle, TABLE_1),
        ({"points": 2.5}, "points must be a whole number of at least 1, got 2.5"),
        ({"points": True}, "a whole number"),
    ),
    *of(
        partial(bg.first_contact, BATCH, "right"),
        ({"pinion_roll": np.zeros((2, 4))}, "must have the shape"),
    ),
    *of(partial(bg.mesh_cycle, TABLE_1), ({"harmonics": 0}, "harmonics")),
    *of(partial(bg.operating_ratios, TABLE_1, "right"), ({"thicknesses": (-0.001,)}, "thickness")),
    *of(
        partial(bg.contact_pattern, TABLE_1),
        ({"separation": 0.0}, "separation must be a positive length"),
        ({"resolution": -1.0}, "resolution must be a positive length"),
        ({"resolution": 1e-3}, "needs more than 1,000,000 points"),
        ({"tolerance": nan}, "tolerance must be a positive length"),
        ({"resolution": 1.0, "tolerance": 1.0}, "not both"),
        ({"area_error": 1e-4}, "area_error must be at least 0.001 and below 1"),
        ({"area_error": nan}, "area_error must be at least 0.001 and below 1"),
        ({"pinion_roll": [0.0, 1.0]}, "both members"),
        ({"pinion_roll": [0.0, 1.0], "gear_roll": [0.0]}, "must have the same shape"),
        ({"pinion_roll": [0.0, 1.0, 0.5], "gear_roll": [0.0, 1.0, 2.0]}, "rise or fall"),
        ({"pinion_roll": [0.0, 1.0], "gear_roll": [0.0, nan]}, "finite"),
    ),
    *of(partial(bg.ease_off, TABLE_1), ({"shape": (2, 5)}, "at least 3 points")),
    *of(
        partial(bg.ease_off, table1(errors=bg.Errors(offset=30.0))),
        ({}, "have no path of contact"),
    ),
    *of(
        partial(bg.design_map, TABLE_1),
        ({"over": "colour"}, "over must be one of parabola, mounting, shift, or two"),
        ({"over": "parabola", "steps": 1}, "steps must be a whole number from 2 to 201, got 1"),
        ({"over": "parabola", "steps": 2.5}, "steps must be a whole number from 2 to 201, got 2.5"),
        ({"over": "mounting", "first": (-1.7e308, 1.7e308)}, "bounds of pinion_mounting_change must be two"),
        ({"over": "parabola", "first": (0.0, 0.0)}, "bounds of parabola_pinion must be two finite"),
        ({"over": "mounting", "second": (0.0, nan)}, "bounds of gear_mounting_change must be two finite"),
        ({"over": "parabola", "second": (-0.1, 0.0)}, r"\[gear\] parabola must be between"),
        ({"over": "shift", "second": (0.0, 4.0)}, "bounds of profile_shift_gear must be between -3 and 3"),
        ({"over": "shift", "errors": bg.Errors()}, "not all 0"),
        ({"over": "shift", "errors": bg.Errors(offset=300.0)}, "offset must be less than 60 mm on this pair"),
    ),
    *of(
        optimise,
        ({"errors": bg.Errors()}, "not all 0"),
        ({"contact_ratio": 0.0}, "contact_ratio of the aim must be positive"),
        ({"off_centre": inf}, "off_centre of the aim must be positive and finite, got inf"),
        ({"peak_to_peak": -1.0}, "peak_to_peak of the aim must be positive"),
        ({"shift": 0.0}, "shift of the aim must be positive"),
        ({"least": "noise"}, "least of the aim must be shift or transmission_error, got 'noise'"),
        ({"least": "transmission_error"}, "requires teeth without edge contact: set edges=False"),
        ({"pinion_parabola": (0.001, 0.001)}, f"pinion_parabola {BOUNDS}"),
        ({"gear_parabola": (0.0, nan)}, f"gear_parabola {BOUNDS}"),
        ({"pinion_parabola": (0.002, 0.003)}, "must have a negative sum, got 0 1/mm"),
        (
            {"pinion_parabola": (0.001, 0.002), "gear_parabola": (-0.001, 0.0)},
            "must have a negative sum",
        ),
    ),
    *of(
        partial(bg.place_path, TABLE_1),
        ({"at": ()}, "one or more"),
        ({"at": (0.0,)}, "above 0 and below 1"),
        ({"at": (25.0,)}, "above 0 and below 1"),
        ({"by": ("offset", "offset")}, "by must be two different errors"),
        ({"l": 9.0}, "l must be on the pinion profile"),
    ),
    *of(
        partial(bg.pattern_matrix, TABLE_1),
        ({"over": ("offset", "offset")}, OVER),
        ({"over": ("offset", "E")}, OVER),
        ({"cells": 4}, "cells must be 3 or 5, got 4"),
        ({"sizes": (0.0, 1e-4)}, "the size of the error of offset must be positive"),
        ({"sizes": (0.1, 0.3)}, "less than 0.26"),
    ),
    *of(
        bg.Load,
        ({}, "give one of them"),
        ({"force": 1.0, "torque_nm": 1.0}, "give one of them"),
        ({"force": 0.0}, "force must be a finite number above 0 N, got 0"),
        ({"torque_nm": inf}, "torque_nm must be"),
        ({"force": 1.0, "young": nan}, "young must be"),
        ({"force": 1.0, "poisson": 0.6}, "poisson must be from 0 to 0.5, got 0.6"),
    ),
    *of(
        study,
        ({"offset": -0.1}, "tolerance of offset must be finite and at least 0 mm, got -0.1"),
        ({"gear_axial": nan}, "tolerance of gear_axial must be finite and at least 0 mm, got nan"),
        ({"pinion_axial": inf}, "tolerance of pinion_axial must be finite"),
        ({"shaft_angle": 1.0}, r"tolerance of shaft_angle must be less than 0.261799 rad \(15 deg\)"),
        ({"sigmas": 0.0}, "sigmas must be positive"),
        ({"sigmas": inf}, "sigmas must be positive and finite, got inf"),
        ({"distribution": "even"}, "distribution must be 'normal' or 'uniform', got 'even'"),
        ({"cases": 0}, "at least 1, got 0 and 4"),
        ({"cases": 10, "blocks_per_task": 0}, "at least 1, got 10 and 0"),
        ({"cases": 10, "blocks_per_task": -1}, "at least 1, got 10 and -1"),
        ({"seed": -1}, "seed must be at least 0, got -1"),
        ({"cases": 5, "operation": 6}, "operation must be 0 to 5, the number of mountings, got 6"),
    ),
    *of(
        partial(bg.measuring_grid, PINION),
        ({"rows": 1}, "rows must be between 2 and 999, got 1"),
        ({"columns": 1000}, "columns must be between 2 and 999, got 1000"),
        ({"border": 0.5}, "border must be at least 0 and below 50 %, got 50 %"),
        ({"border": -0.1}, "border must be at least 0"),
        ({"border_mm": 25.0}, SINGLE_BORDER),
        ({"border_mm": 7.0}, "half of the flank's"),
        ({"border_mm": nan}, "border must be"),
    ),
    *of(
        partial(bg.shim, TABLE_1, 0.1),
        *(({"at": at}, "share of the face above 0") for at in (0.0, 1.0, nan)),
    ),
    *of(partial(bg.shim, TABLE_1), ({"backlash": nan}, "backlash must be a finite number in mm, got nan")),
    *of(
        BALL,
        *(({"diameter": ball}, "diameter of a ball must be positive") for ball in (0.0, -1.0, nan, inf)),
    ),
    *of(
        partial(bg.span_measurement, spur(24)),
        *(({"teeth": teeth}, "teeth in a span must be between 1 and 23") for teeth in (0, 24, -1)),
    ),
    *of(
        bg.tooth_data,
        ({"member": replace(PINION, profile_shift=np.array([0.0, 0.1]))}, "single numbers"),
        ({"member": replace(PINION, tool=replace(PINION.tool, tip_radius=0.9))}, "overlap"),
    ),
    *of(
        partial(bg.gear_solid, PINION),
        *(({"tolerance": 0.1, "teeth": n}, f"teeth must be between 1 and 29, got {n}") for n in (0, -1, 30)),
        *(({"tolerance": length}, "tolerance must be a positive length") for length in (0.0, -0.1, nan)),
        ({"tolerance": 1e-320}, "tolerance must be at least 1e-09 mm, got"),
        *(
            ({"bore_radius": bore}, "between 1.76387 and 87.5934 mm")
            for bore in (0.0, -1.0, 1.7638, 87.6, nan)
        ),
    ),
    *of(
        partial(bg.tooth_hexahedra, PINION),
        ({"teeth": 0}, "teeth must be between 1 and 29, got 0"),
        ({"teeth": 30}, "teeth must be between 1 and 29, got 30"),
        ({"element": "C3D10"}, "element must be one of C3D20, C3D20R, C3D8I, C3D8, got 'C3D10'"),
        ({"tolerance": 0.0}, "tolerance must be a positive length in mm, got 0"),
        ({"tolerance": 1e-320}, "tolerance must be at least 1e-09 mm, got"),
        ({"tolerance": 1e-5}, r"the mesh needs about .* nodes for 1 tooth, the limit is 5e\+06"),
        ({"bore_radius": 89.0}, "bore_radius must be between 1.76387 and 87.5934 mm, got 89"),
    ),
    *of(
        partial(bg.sample_flank, PINION, "right"),
        *(({"tolerance": length}, "tolerance must be a positive length") for length in (0.0, nan, inf)),
    ),
    *of(
        partial(bg.sample_flank, flank="right", tolerance=0.01),
        ({"member": replace(PINION, tool=replace(PINION.tool, parabola=0.3))}, FOLDS),
        ({"member": replace(PINION, tool=replace(PINION.tool, parabola=-0.12))}, FOLDS),
    ),
]


@pytest.mark.parametrize(
    ("function", "arguments", "message"), REFUSED, ids=[message[:40] for *_, message in REFUSED]
)
def test_arguments_outside_their_limits(
    function: Callable[..., object], arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        function(**arguments)


OF_ONE_DESIGN: dict[str, Callable[[bg.Design], object]] = {
    "layout_advice": bg.layout_advice,
    "layout_deviation": bg.layout_deviation,
    "contact_pattern": bg.contact_pattern,
    "design_text": bg.design_text,
    "ease_off": bg.ease_off,
    "design_remarks": bg.design_remarks,
    "design_map": partial(bg.design_map, over="parabola"),
    "optimise_parabola": partial(bg.optimise_parabola, aim=AIM),
    "optimise_amounts": partial(bg.optimise_amounts, aim=AIM, bounds={}),
    "fit_crowning": partial(bg.fit_crowning, transmission_error=1e-5, length=20.0),
    "paper_statements": bg.paper_statements,
    "pattern_matrix": bg.pattern_matrix,
    "place_path": bg.place_path,
    "shim": partial(bg.shim, backlash=0.1),
    "tolerance_study": partial(bg.tolerance_study, tolerances=USUAL),
    "zero_backlash_layout": bg.zero_backlash_layout,
}


@pytest.mark.parametrize("name", OF_ONE_DESIGN)
def test_a_batch_instead_of_a_single_design(name: str) -> None:
    with pytest.raises(ValueError, match=r"single|a batch"):
        OF_ONE_DESIGN[name](BATCH)


WITH_FLANK = [
    name
    for name in bg.__all__
    if callable(getattr(bg, name))
    and not isinstance(getattr(bg, name), type)
    and "flank" in inspect.signature(getattr(bg, name)).parameters
]
OTHERS = {"aim": AIM, "backlash": 0.1, "over": "parabola", "pinion_roll": [0.1], "thicknesses": (0.0,)}
OTHERS |= {"bounds": {}, "transmission_error": 1e-5, "length": 20.0}
OTHERS |= {"tolerances": USUAL, "design": TABLE_1, "member": PINION, "tolerance": 0.01}


@pytest.mark.parametrize("name", WITH_FLANK)
def test_unknown_flanks(name: str) -> None:
    function = getattr(bg, name)
    needed = [
        parameter.name
        for parameter in inspect.signature(function).parameters.values()
        if parameter.default is inspect.Parameter.empty and parameter.name != "flank"
    ]
    with pytest.raises(ValueError, match="flank must be 'right' or 'left', got 'upper'"):
        function(**{parameter: OTHERS[parameter] for parameter in needed}, flank="upper")


@pytest.mark.parametrize(
    "function", [bg.path_of_contact, bg.contact_ratio, bg.path_sensitivity], ids=lambda each: each.__name__
)
def test_a_batch_without_elements(function: Callable[[bg.Design], object]) -> None:
    with pytest.raises(ValueError, match="without elements"):
        function(table1(errors=bg.Errors(offset=np.empty(0))))


@pytest.mark.parametrize("function", [bg.mesh_cycle, lambda design: bg.first_contact(design, "right", [0.1])])
def test_members_of_arrays(function: Callable[[bg.Design], object]) -> None:
    with pytest.raises(ValueError, match="single numbers"):
        function(TABLE_1.with_parabola(pinion=np.zeros(2)))


REQUEST = bg.Request(2.0, (20, 30), (20.0, 20.0), 0.1, 0.1, cone_angles=(0.05, 0.05))
OTHERS |= {"request": REQUEST, "path": bg.path_of_contact(TABLE_1), "load": bg.Load(1.0)}
OTHERS |= {"diameter": 10.0, "z": 0.0, "flank": "right"}
NUMBER_TYPES = re.compile("float|int|ArrayLike|Bounds|Cells")


def request_of(**changes: Any) -> object:
    return bg.propose(replace(REQUEST, **changes))


def number_arguments() -> Iterator[tuple[str, Callable[..., object], str, str]]:
    """Yield label, function, argument and annotation of all arguments of the public functions, and of all
    fields of their inputs, that are numbers."""
    functions = [(name, getattr(bg, name), getattr(bg, name)) for name in bg.__all__]
    functions = [each for each in functions if inspect.isfunction(each[1])]
    inputs = (bg.Aim, optimise), (bg.Tolerances, study), (bg.Request, request_of), (bg.Load, bg.Load)
    functions += [(one.__name__, one, used_by) for one, used_by in inputs]
    for label, signature_of, function in functions:
        for each in inspect.signature(signature_of).parameters.values():
            if NUMBER_TYPES.search(each.annotation) and "Callable" not in each.annotation:
                yield f"{label}-{each.name}", function, each.name, each.annotation


NUMBER_ARGUMENTS = list(number_arguments())


@pytest.mark.parametrize(
    ("label", "function", "argument", "annotation"),
    NUMBER_ARGUMENTS,
    ids=[one[0] for one in NUMBER_ARGUMENTS],
)
def test_arguments_that_are_not_numbers(
    label: str, function: Callable[..., object], argument: str, annotation: str
) -> None:
    parameters = inspect.signature(function).parameters
    others = {
        name: OTHERS[name]
        for name, each in parameters.items()
        if each.default is inspect.Parameter.empty and each.kind is not inspect.Parameter.VAR_KEYWORD
    }
    if label.startswith("contact_pattern") and argument.endswith("roll"):  # both are needed
        others |= {"pinion_roll": [0.0, 1.0], "gear_roll": [0.0, 1.0]}
    for value in ["x", *([2.5] if annotation in ("int", "int | None") else [])]:
        with pytest.raises((TypeError, ValueError), match=rf"{argument} .*must .* got .*{value!r}"):
            function(**{**others, argument: value})
