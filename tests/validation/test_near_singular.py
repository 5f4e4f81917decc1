"""Four methods near the smallest shaft angle at which two flanks have a common normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, Status, builtin_design, path_of_contact
from beveloid_geom.validation.near_singular import (
    METHODS,
    at_shaft_angle,
    errors_above_smallest_shaft_angle,
    smallest_shaft_angle,
    status_map,
)

from ..stability.answers import held
from ..symmetry import mirrored

TABLE = builtin_design()
NAMES = list(METHODS)


@pytest.mark.parametrize("design", [TABLE, mirrored(TABLE)], ids=["table1", "mirrored"])
def test_contact_begins_at_the_smallest_shaft_angle(design: Design) -> None:
    flank = "right" if design is TABLE else "left"
    smallest = smallest_shaft_angle(design, flank)
    above = held(at_shaft_angle(design, smallest + 1e-8))
    below = replace(above, pair=replace(above.pair, shaft_angle=smallest - 1e-8))
    assert path_of_contact(above, flank, 3).ends.status == Status.SOLVED
    assert path_of_contact(below, flank, 3).ends.status == Status.NO_COMMON_NORMAL


def test_errors_grow_towards_the_smallest_shaft_angle() -> None:
    """0.1 deg above the smallest shaft angle, all methods are exact except the mesh without polishing. 1e-6
    deg above it, polished mesh and five equations have no result and a reason."""
    found = errors_above_smallest_shaft_angle(TABLE, "right", np.radians([1e-6, 0.1]))
    error = dict(zip(NAMES, found.error, strict=True))
    for name in NAMES[1:]:
        assert error[name][1] < 1e-10
    assert error["mesh alone"][1] < found.stated[NAMES.index("mesh alone"), 1]
    assert error["one equation"][0] < 1e-5
    for name in ("mesh, polished", "five equations"):
        assert np.isnan(error[name][0])
        assert found.reason[NAMES.index(name)][0]


def test_layouts_without_contact_have_a_reason() -> None:
    found = errors_above_smallest_shaft_angle(TABLE, "right", [np.radians(1.0)])
    assert np.isnan(found.error).all()
    assert all("no contact" in reason for (reason,) in found.reason)


def test_both_equations_have_the_same_results() -> None:
    """Both methods have the same status at shaft angles below and above the smallest one. At the smallest
    one, neither has a result."""
    smallest = smallest_shaft_angle(TABLE, "right")
    angles, offsets = smallest + np.array((-1e-3, 0.0, 2.8e-3, 4e-3)), np.array((222.0, 229.0, 234.0))
    found = status_map(TABLE, "right", angles, offsets, 2)
    rows, columns = found.compared.T
    codes = found.status[rows, columns]
    known = codes != Status.NOT_CONVERGED
    assert {Status.SOLVED, Status.NO_COMMON_NORMAL, Status.OFF_FLANK} <= set(codes[known].tolist())
    assert (found.five_equations[known] == codes[known]).all()
    assert (columns[~known] == 1).all()
    assert (found.five_equations[~known] == -1).all()
