"""Texts of results in the interpreter and in notebooks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import beveloid_geom as bg
from beveloid_geom.contact.path import path_ends
from beveloid_geom.shapes.proximity.mesh_separation import mesh_separation
from beveloid_geom.support.array_repr import short_repr
from tests.oracle.table1 import table1

DESIGN = table1((0.001, -0.001))
RESULTS: dict[str, Callable[[], object]] = {
    "path": lambda: bg.path_of_contact(DESIGN, points=2001),
    "ends": lambda: path_ends(DESIGN),
    "cycle": lambda: bg.mesh_cycle(DESIGN, "right"),
    "pattern": lambda: bg.contact_pattern(DESIGN).pinion,
    "map": lambda: bg.design_map(DESIGN, "parabola", steps=2),
    "study": lambda: bg.tolerance_study(DESIGN, bg.Tolerances(0.05), cases=2000),
    "sensitivity": lambda: bg.path_sensitivity(DESIGN),
    "solid": lambda: bg.gear_solid(DESIGN.pinion, tolerance=0.1),
    "hexahedra": lambda: bg.tooth_hexahedra(DESIGN.pinion, tolerance=0.1),
    "flank": lambda: bg.sample_flank(DESIGN.pinion, "right", 0.01),
    "backlash": lambda: bg.mounted_backlash(DESIGN),
    "closing": lambda: bg.layout_deviation(DESIGN),
    "meshes": lambda: mesh_separation(DESIGN, "right", 0, 0.1, pinion_roll=0.0, gear_roll=0.0),
}


@pytest.mark.parametrize("result", RESULTS.values(), ids=RESULTS)
def test_representations_are_short(result: Callable[[], object]) -> None:
    value = result()
    lines = repr(value).splitlines()
    assert lines[0] == type(value).__name__
    assert 3 < len(lines) < 25
    assert max(map(len, lines)) <= 110
    assert "array(" not in repr(value)


def test_arrays_are_shown_by_shape_and_range() -> None:
    path = bg.path_of_contact(DESIGN, points=3)
    assert f"l1                  [3] {path.l1.min():.6g} ... {path.l1.max():.6g}" in repr(path)
    partly_nan = bg.path_of_contact(table1(), l1=[0.0, 1e3])
    assert ", 1 NaN" in next(line for line in repr(partly_nan).splitlines() if " u2 " in line)
    assert "[0]" in repr(bg.path_of_contact(table1(errors=bg.Errors(offset=9.0))))
    shown = short_repr(bg.Errors(offset=np.zeros((4, 5)))).splitlines()[1]
    assert " ".join(shown.split()[1:]) == "[4 x 5] 0 ... 0"


def test_codes_are_shown_by_name() -> None:
    """Codes of few positions are listed, those of many positions are counted."""
    ends = repr(path_ends(DESIGN))
    assert "[2] gear_tip, pinion_tip" in ends
    assert " status         solved" in ends
    assert "[3] off_flank, solved, off_flank" in repr(bg.path_of_contact(table1(), l1=[-90.0, 0.0, 90.0]))
    path = bg.path_of_contact(table1(), l1=np.linspace(-90.0, 90.0, 181))
    solved = np.count_nonzero(path.status == bg.Status.SOLVED)
    assert f"[181] solved {solved}, off_flank {181 - solved}" in repr(path)
    assert "[1 x 2] none" in repr(bg.mounted_backlash(table1()).right)
    assert "reasons                 none" in repr(bg.layout_deviation(table1()))


@pytest.mark.parametrize("name", ["path", "cycle", "design"])
def test_notebooks_show_a_small_table(name: str) -> None:
    """The table is valid XML, with names and values of the quantities in fewer than 40 rows."""
    shown: Any = DESIGN if name == "design" else RESULTS[name]()
    table = ElementTree.fromstring(shown._repr_html_())
    rows = {row.findtext("th"): row.findtext("td") for row in table.findall("tr")}
    assert table.findtext("caption") == f"{type(shown).__name__}, mm and rad"
    assert 8 < len(rows) < 40
    wanted = {
        "path": ("ends contact_ratio", str(path_ends(DESIGN).contact_ratio)),
        "cycle": ("edge_share", str(bg.mesh_cycle(DESIGN, "right").edge_share)),
        "design": ("pinion tool parabola", "0.001"),
    }[name]
    assert rows[wanted[0]] == wanted[1]


def test_inputs_are_shown_as_the_call_that_creates_them() -> None:
    """Values equal to their default are not shown; arrays are shown by shape and range."""
    pinion = DESIGN.pinion.modified(bg.Modification(helix_crowning_um=10.0))
    design = replace(DESIGN, pinion=pinion, errors=bg.Errors(offset=0.05))
    assert eval(repr(design), {name: getattr(bg, name) for name in dir(bg)}) == design
    assert "tip_alteration" not in repr(design)
    assert len(repr(design)) < 700
    assert repr(bg.Errors(gear_axial=np.zeros((4, 5)))) == "Errors(gear_axial=[4 x 5] 0 ... 0)"
    assert repr(bg.MeshErrors()) == "MeshErrors()"
