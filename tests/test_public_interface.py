"""The names at the top level: exports, subpackages, messages for a wrong design, dictionaries and CSV."""

from __future__ import annotations

import csv
import io
import subprocess
import sys
import typing
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import pytest

import beveloid_geom as bg

DESIGN = bg.builtin_design()
PATH = bg.path_of_contact(DESIGN, points=3)
FUNCTIONS = sorted(
    name
    for name in bg.__all__
    if callable(getattr(bg, name)) and not isinstance(getattr(bg, name), type) and name != "write"
)


def classes_in(annotation: Any) -> set[type]:
    """Return the classes of the library in a type annotation."""
    found = set().union(*(classes_in(part) for part in typing.get_args(annotation)), set())
    if isinstance(annotation, type) and annotation.__module__.startswith("beveloid_geom"):
        found.add(annotation)
    return found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_returned_classes_are_exported(name: str) -> None:
    returned = classes_in(typing.get_type_hints(getattr(bg, name)).get("return"))
    assert {kind.__name__ for kind in returned} <= set(bg.__all__)


def test_enumerations_are_exported() -> None:
    from beveloid_geom import status

    kinds = {
        name for name, value in vars(status).items() if isinstance(value, type) and IntEnum in value.__bases__
    }
    assert kinds <= set(bg.__all__)


def test_subpackages_are_imported_when_used() -> None:
    code = "import sys, beveloid_geom as bg; assert 'contact' in dir(bg); assert 'numpy' not in sys.modules; "
    code += "print(bg.contact.__name__, bg.analysis.maps.__name__ if hasattr(bg.analysis, 'maps') else '')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("beveloid_geom.contact")


CALLS: dict[str, Callable[[Any], object]] = {
    **{
        name: getattr(bg, name)
        for name in ("path_of_contact", "contact_ratio", "mesh_cycle", "contact_pattern", "mounted_backlash")
    },
    **{name: getattr(bg, name) for name in ("ease_off", "path_sensitivity", "place_path")},
    **{name: getattr(bg, name) for name in ("zero_backlash_layout", "closing_of", "pattern_matrix")},
    "first_contact": lambda design: bg.first_contact(design, "right", [0.1]),
    "operating_ratios": lambda design: bg.operating_ratios(design, "right", (0.0,)),
    "tolerance_study": lambda design: bg.tolerance_study(design, bg.Tolerances(offset=0.1)),
    "optimise_parabola": lambda design: bg.optimise_parabola(design, bg.Aim(bg.Errors())),
    "optimise_amounts": lambda design: bg.optimise_amounts(design, bg.Aim(bg.Errors()), {}),
    "crowning_for": lambda design: bg.crowning_for(design, 1e-5, 20.0),
    "map_of": lambda design: bg.map_of(design, "parabola"),
    "shim": lambda design: bg.shim(design, 0.1),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_file_name_instead_of_a_design(name: str) -> None:
    message = r"^design must be a Design, got 'mine.toml': read it with read_design\('mine.toml'\)$"
    with pytest.raises(TypeError, match=message):
        CALLS[name]("mine.toml")
    with pytest.raises(TypeError, match=r"got None: make it by Design\(...\)$"):
        CALLS[name](None)


RESULTS = [
    *(PATH, bg.certify(PATH), bg.sliding_of(PATH), bg.pressure_along(PATH, bg.Load(force=100.0))),
    *(
        bg.first_contact(DESIGN, "right", [0.1, 0.2]),
        bg.path_sensitivity(DESIGN),
        bg.tooth_data(DESIGN.pinion),
    ),
    *(bg.ease_off(DESIGN, "right", (3, 3)), bg.span_over(DESIGN.pinion), bg.mesh_cycle(DESIGN)),
]


@pytest.mark.parametrize("result", RESULTS, ids=lambda result: type(result).__name__)
def test_results_as_dictionary_and_csv(result: Any) -> None:
    """Numbers are those of the result; codes are names."""
    data = bg.to_dict(result)
    assert list(data) == [field.name for field in fields(result)]
    for name, value in vars(result).items():
        if isinstance(value, np.ndarray) and value.dtype.kind == "f":
            np.testing.assert_array_equal(np.array(data[name], float), value)
        if name in ("status", "verdict"):
            assert all(isinstance(code, str) for code in np.ravel(np.array(data[name], dtype=object)))
    rows = list(csv.DictReader(io.StringIO(bg.to_csv(result))))
    assert rows
    assert all(header and None not in row for row in rows for header in row)
    assert len(repr(result)) < 3000
    assert is_dataclass(result)


def test_csv_of_a_path() -> None:
    rows = list(csv.DictReader(io.StringIO(bg.to_csv(PATH))))
    assert [float(row["point_y_mm"]) for row in rows] == PATH.point[:, 1].tolist()
    assert [row["status"] for row in rows] == ["solved"] * 3
    with pytest.raises(ValueError, match="Pair has no arrays"):
        bg.to_csv(DESIGN.pair)
