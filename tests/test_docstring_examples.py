"""Run the example in the docstring of each public function."""

from __future__ import annotations

import doctest
from types import FunctionType

import pytest

import beveloid_geom

FUNCTIONS = [name for name in beveloid_geom.__all__ if isinstance(getattr(beveloid_geom, name), FunctionType)]
SLOW = {"layout_advice", "fit_crowning", "optimise_amounts", "optimise_parabola", "paper_statements"}
SLOW |= {"pattern_matrix", "shim"}
"""Functions that need more than two seconds."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in FUNCTIONS]
)
def test_example(name: str) -> None:
    function = getattr(beveloid_geom, name)
    (example,) = doctest.DocTestFinder(recurse=False).find(function, name, globs={})
    assert example.examples, "add an example to the docstring"
    printed: list[str] = []
    outcome = doctest.DocTestRunner().run(example, out=printed.append)
    assert outcome.failed == 0, "".join(printed)
