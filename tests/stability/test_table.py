"""The table on the page is the result of its run, and the trusted methods are checked."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import path_of_contact
from tests.oracle.table1 import table1

from .outcomes import METHODS, WRONG, Case, attempted, in_a_cell, of_five, of_meshes, of_path
from .situations import SITUATIONS
from .table import HEADINGS, line, markdown, row as run, trusted

PAGE = (Path(__file__).parent / "README.md").read_text(encoding="utf-8")
TABLE = [text for text in PAGE.splitlines() if text.startswith("|")]
STATUS = re.compile(r"`[A-Z_]+`|refused")
ROUNDING = 2e-13
"""rad"""
QUICK = ("parabola that folds the rack", "tooth pointed at the heel", "mesh 10 m from the origin")
names = [situation.name for situation in SITUATIONS]
every = pytest.mark.parametrize("number", range(len(SITUATIONS)), ids=names)


def cells_of_page(number: int) -> dict[str, str]:
    return dict(zip(HEADINGS, TABLE[2 + number][2:-2].split(" | "), strict=True))


def test_the_page_has_every_situation() -> None:
    assert len(TABLE) == 2 + len(SITUATIONS)
    assert TABLE[:2] == [text for _, text in zip("12", markdown(), strict=False)]
    assert f"{len(SITUATIONS)} situations" in " ".join(PAGE.split())


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(number, id=name, marks=() if name in QUICK else pytest.mark.slow)
        for number, name in enumerate(names)
    ],
)
def test_the_page_contains_the_run(number: int) -> None:
    assert TABLE[2 + number] == line(number)


@every
def test_trusted_methods_are_exact_or_have_a_status(number: int) -> None:
    """The table on the page is checked. Where the status is trusted, only the facets, which cannot detect a
    tangency, give values. No method is wrong: facets and polished contacts are within their error estimates,
    and no overlap belongs to another tooth."""
    situation, cells = SITUATIONS[number], cells_of_page(number)
    words = {method: cells[method].split(", ") for method in METHODS}
    assert cells["trusted"] == trusted(situation)
    assert cells["message to the user"] == (f'"{situation.message}"' if situation.message else "nothing")
    assert situation.trusted
    for method in situation.trusted:
        if method == "status":
            for other in ("one equation", "five equations", "polished"):
                assert all(STATUS.fullmatch(word) for word in words[other]), other
        elif method == "first contact":
            assert all(STATUS.fullmatch(word) for word in words[method])
        else:
            assert words[method] == ["exact"]
    for method in METHODS:
        assert not {WRONG, "partly lost", "another piece"} & set(words[method])


@pytest.mark.slow
@every
def test_outcomes_do_not_depend_on_rounding(number: int) -> None:
    """Poses of a path differ by 1e-13 rad between releases of NumPy; the outcomes must be equal."""
    row = run(number)
    for method, polish in (("facets", False), ("polished", True)):
        for turned in (-ROUNDING, ROUNDING):
            found = []
            for case in row.situation.cases():
                with row.situation.disturbed():
                    found.append(attempted(lambda: of_meshes(case, polish, row.situation.moved, turned)))  # noqa: B023
            assert in_a_cell(found) == row.cells[METHODS.index(method)], (method, turned)


def test_cells_fit_a_table() -> None:
    assert len(set(names)) == len(names)
    for text in TABLE:
        cells = text[2:-2].split(" | ")
        assert len(cells) == len(HEADINGS)
        assert max(map(len, cells)) < 75


def test_a_wrong_path_is_detected() -> None:
    """Wrong results are detected: positions displaced by a micrometre or a microradian, positions off the
    face, another segment, and a lost position."""
    design = table1((0.001, -0.001))
    path = path_of_contact(design, points=5)
    assert of_path(design, path) == "exact"
    for name, shift in (("u1", 1e-6), ("l2", 1e-6), ("gear_roll", 1e-6)):
        assert of_path(design, replace(path, **{name: getattr(path, name) + shift})) == WRONG
    beyond = path_of_contact(design, l1=path.l1 + 0.01)
    assert of_path(design, replace(beyond, status=path.status)) == WRONG
    half = path_of_contact(design, l1=path.l1[1:4])
    part = replace(half, ends=replace(path.ends, l1=path.l1[[1, 3]]))
    assert of_five(design, path, part) == "another piece"
    lost = replace(path, status=np.where(np.arange(5) == 2, 2, path.status).astype(np.int8))
    assert of_path(design, lost) == "partly lost"


def test_displaced_meshes_are_detected() -> None:
    """A displacement of the pair by a micrometre, which the expected position does not contain, is
    detected."""
    case = Case(table1((0.001, -0.001)), "left")
    assert of_meshes(case, True, (0.0, 0.0, 0.0)) == "exact"
    assert of_meshes(case, True, (0.0, 1e-3, 0.0)) == WRONG
    assert of_meshes(case, False, (0.0, 100.0, 0.0)) == WRONG
