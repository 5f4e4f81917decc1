"""The names at the top level: exports, subpackages, messages for a wrong design, dictionaries and CSV."""

from __future__ import annotations

import csv
import inspect
import io
import subprocess
import sys
import typing
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

    kinds = {kind.__name__ for kind in IntEnum.__subclasses__() if kind.__module__ == status.__name__}
    assert kinds
    assert kinds <= set(bg.__all__)


def test_subpackages_are_imported_when_used() -> None:
    code = "import sys, beveloid_geom as bg; assert 'contact' in dir(bg); assert 'numpy' not in sys.modules; "
    code += "print(bg.contact.__name__, bg.analysis.maps.__name__ if hasattr(bg.analysis, 'maps') else '')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("beveloid_geom.contact")


WRONG: dict[type, tuple[object, str]] = {
    bg.Design: (
        "mine.toml",
        r"design must be a Design, got 'mine.toml': read it with read_design\('mine.toml'\)",
    ),
    bg.Member: (DESIGN, "member must be a Member, got a Design: pass design.pinion or design.gear"),
    bg.ContactPath: (
        None,
        r"path must be a ContactPath, got None: pass the result of path_of_contact\(design\)",
    ),
}
"""Wrong first arguments by the class that a function takes, and the message."""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_wrong_first_argument(name: str) -> None:
    function = getattr(bg, name)
    needed = [one for one in inspect.signature(function).parameters.values() if one.default is one.empty]
    kind = typing.get_type_hints(function)[needed[0].name] if needed else None
    if kind not in WRONG:
        return
    value, message = WRONG[kind]
    with pytest.raises(TypeError, match=f"^{message}$"):
        function(value, *[None for one in needed[1:] if one.kind is not one.KEYWORD_ONLY])


RESULTS = [
    *(PATH, bg.path_certificate(PATH), bg.path_sliding(PATH), bg.path_pressure(PATH, bg.Load(force=100.0))),
    *(bg.first_contact(DESIGN, "right", [0.1, 0.2]), bg.path_sensitivity(DESIGN), bg.mesh_cycle(DESIGN)),
    *(bg.ease_off(DESIGN, "right", (3, 3)), bg.span_measurement(DESIGN.pinion), bg.tooth_data(DESIGN.pinion)),
]


@pytest.mark.parametrize("result", RESULTS, ids=lambda result: type(result).__name__)
def test_results_as_dictionary_and_csv(result: Any) -> None:
    """`to_dict` and `to_csv` contain the numbers of each result, and names in place of codes."""
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


def rows_of(result: Any) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(bg.to_csv(result))))


def test_csv_of_grids_and_tooth_data() -> None:
    """The tables contain the points of grids, and the tooth thickness in each plane for each change."""
    grid = bg.sample_flank(DESIGN.pinion, "right", 0.1)
    rows = rows_of(grid)
    points = [[float(row[f"point_{axis}_mm"]) for axis in "xyz"] for row in rows]
    assert np.array_equal(points, grid.points.reshape(-1, 3))
    assert [float(row["z_mm"]) for row in rows[: grid.z.size]] == grid.z.tolist()
    pattern = bg.contact_pattern(DESIGN, resolution=3.0)
    rows = rows_of(pattern)
    least = np.concatenate([pattern.pinion.least.ravel(), pattern.gear.least.ravel()])
    assert np.array_equal([float(row["least_mm"] or "nan") for row in rows], least, equal_nan=True)
    assert {row["member"] for row in rows} == {"pinion", "gear"}
    data = bg.tooth_data(DESIGN.pinion, [0.0, -0.1])
    thickness = [float(row["normal_thickness_mm"]) for row in rows_of(data)]
    assert thickness == data.normal_thickness.ravel().tolist()
    with pytest.raises(ValueError, match=r"^Solid is no table: use write\(result, path\), or to_dict"):
        bg.to_csv(bg.gear_solid(DESIGN.pinion, 0.5, teeth=1))
