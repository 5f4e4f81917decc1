"""Both kinds of errors in every study: each mounting equals that with the equivalent errors of the other
kind.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    MeshErrors,
    Tolerances,
    design_map,
    path_of_contact,
    path_sensitivity,
    tolerance_study,
)
from beveloid_geom.analysis.maps import usual_errors
from beveloid_geom.analysis.optimise import Aim, objectives_of
from beveloid_geom.analysis.path_placement import place_path, search_limits
from beveloid_geom.analysis.pattern_matrix import check_size, pattern_matrix
from beveloid_geom.analysis.tolerance import USUAL_AT
from beveloid_geom.arrays import FloatArray
from beveloid_geom.operation.backlash import backlash_by_errors, mounted_backlash
from beveloid_geom.pair.misalignment import NAMES, mounted, place_of
from beveloid_geom.pair.misalignment_at_mesh import at_mesh, by_mesh_errors, from_mesh
from beveloid_geom.status import PlaceStatus
from tests.oracle.table1 import table1
from tests.validation.test_intersecting_axes import EQUAL, LARGE, STRAIGHT

_ANY: Any = "apex"
OWN = MeshErrors(0.01, 2e-5, -3e-5, 0.05, -0.02)
PARABOLAS = 0.0004, -0.0004


def under(design: Design, errors: MeshErrors) -> Design:
    return design.with_errors(from_mesh(design, errors))


DESIGNS = {
    "Table 1": table1(PARABOLAS),
    "Table 1 with errors": under(table1(PARABOLAS), OWN),
    "24/61 with errors": under(LARGE.with_parabola(*PARABOLAS), OWN),
    "37/37": EQUAL.with_parabola(*PARABOLAS),
    "straight with errors": under(STRAIGHT.with_parabola(*PARABOLAS), OWN),
}


def moved(design: Design, name: str, by: float) -> Design:
    """Return the design with the given amount added to one error at the mesh."""
    own = at_mesh(design)
    return under(design, replace(own, **{name: getattr(own, name) + by}))


@pytest.mark.parametrize("name", DESIGNS)
def test_errors_at_the_mesh_are_added_there(name: str) -> None:
    design, size = DESIGNS[name], np.array((0.05, 2e-4, -1e-4, 0.1, -0.2))
    for k, error in enumerate(NAMES["mesh"]):
        one = mounted(design, size[k : k + 1], (error,)).errors
        assert vars(one) == pytest.approx(vars(moved(design, error, size[k]).errors), abs=1e-12)
    values = np.stack((0.0 * size, size, -size))
    batch = mounted(design, values, NAMES["mesh"]).errors
    for k, row in enumerate(values):
        alone = vars(mounted(design, row, NAMES["mesh"]).errors)
        assert {key: value[k] for key, value in vars(batch).items()} == pytest.approx(alone, abs=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
def test_derivatives_are_those_of_the_conversion(name: str) -> None:
    """Derivatives equal differences of the fourth order. The step is as large as the second derivative
    allows."""
    design = DESIGNS[name]
    exact = by_mesh_errors(design, np.eye(4))
    for k, error in enumerate(NAMES["mesh"]):
        step = 1e-4 if "plane" in error else 1e-2

        def errors(times: int, error: str = error, step: float = step) -> FloatArray:
            return np.array(list(vars(moved(design, error, times * step).errors).values()))

        by = (8.0 * (errors(1) - errors(-1)) - (errors(2) - errors(-2))) / (12.0 * step)
        np.testing.assert_allclose(exact[:, k], by, rtol=1e-9, atol=1e-6 if step < 1e-3 else 1e-9)


@pytest.mark.parametrize(("name", "flank"), [("Table 1 with errors", "left"), ("24/61 with errors", "right")])
def test_sensitivity_at_the_mesh(name: str, flank: str) -> None:
    """Derivatives of position, contact ratio and backlash with respect to errors at the mesh equal
    differences of paths and backlashes."""
    design = DESIGNS[name]
    found = path_sensitivity(design, flank, "mesh")
    assert found.errors == NAMES["mesh"]
    backlash = by_mesh_errors(design, backlash_by_errors(design))
    for k, error in enumerate(NAMES["mesh"]):
        step = 2e-7 if "plane" in error else 2e-4
        both = [moved(design, error, sign * step) for sign in (1.0, -1.0)]
        paths = [path_of_contact(one, flank, 3) for one in both]
        for rate, value in (
            (found.z_by[1, 0, k], [path.pinion_z[1] for path in paths]),
            (found.contact_ratio_by[k], [path.ends.contact_ratio for path in paths]),
            (backlash[k], [mounted_backlash(one).normal for one in both]),
        ):
            by = float(value[0] - value[1]) / (2.0 * step)
            assert float(rate) == pytest.approx(by, rel=2e-3, abs=1e-3 * abs(float(found.z_by[1, 0, 1])))


def test_a_study_draws_errors_at_the_mesh(flank: str) -> None:
    design, tolerances = DESIGNS["24/61 with errors"], USUAL_AT["mesh"]
    study = tolerance_study(design, tolerances, flank, 20, seed=3)
    assert tolerances.names == NAMES["mesh"]
    assert study.mountings.errors.shape == (20, 5)
    assert (np.std(study.mountings.errors, axis=0) > 0.0).all()
    own = at_mesh(design)
    for k in (0, 7, 19):
        drawn = {
            n: getattr(own, n) + v for n, v in zip(NAMES["mesh"], study.mountings.errors[k], strict=True)
        }
        path = path_of_contact(under(design, MeshErrors(**drawn)), flank, 17)
        assert study.mountings.contact_ratio[k] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
        assert study.mountings.pinion_z[k, 1] == pytest.approx(float(path.pinion_z[8]), abs=1e-7)


def test_maps_patterns_and_places() -> None:
    flank, design = "left", replace(DESIGNS["37/37"], errors_at="mesh")
    assert usual_errors(design) == MeshErrors(0.05, radians(0.01), radians(0.01), 0.1, 0.1)
    bounds = -4e-4, 4e-4
    found = design_map(design, "parabola", flank, first=bounds, second=bounds, steps=2)
    assert found.errors == usual_errors(design)
    cell = objectives_of(design, flank, Aim(usual_errors(design)), *(np.asarray(x) for x in PARABOLAS))
    assert found.shift[1, 0] == pytest.approx(float(cell.shift), rel=1e-9)
    over = "centre_distance", "in_plane"
    matrix = pattern_matrix(design, over, flank, resolution=3.0, area_error=0.2)
    assert (matrix.first[-1], matrix.second[-1]) == (0.05, radians(0.01))
    corner = mounted(design, np.array((0.05, radians(0.01))), over)
    assert matrix.normal_backlash[2, 2] == pytest.approx(float(mounted_backlash(corner).normal), abs=1e-9)
    placed = place_path(design, (0.4,), over, flank)
    path = path_of_contact(mounted(design, placed.errors[0], over), flank, 3)
    assert placed.status[0] == PlaceStatus.REACHED
    assert float(path.pinion_z[1]) == pytest.approx(-3.0, abs=1e-6)


@pytest.mark.parametrize("design", [EQUAL, LARGE, STRAIGHT])
def test_limits_of_offset_errors_on_intersecting_axes(design: Design) -> None:
    """On intersecting axes the limits of offset errors are one module, because the offset is 0."""
    check_size(design, "offset", 0.05)
    assert search_limits(design, ("offset", "centre_distance")).tolist() == 2 * [
        design.pinion.tool.normal_module
    ]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: place_of(("offset", "in_plane")),
            "offset is about the common perpendicular, in_pla",
        ),
        (lambda: place_of(("offset", "E")), "unknown error 'E': known are offset, shaft_angle, pinion"),
        (lambda: place_path(EQUAL, by=("shaft_angle", "in_plane")), "give two errors of the same kind"),
        (lambda: tolerance_study(EQUAL, Tolerances(0.1, in_plane=1e-4)), "tolerance of offset is about the"),
        (
            lambda: tolerance_study(EQUAL, Tolerances(in_plane=0.07)),
            "in_plane must be less than 0.0698132 rad",
        ),
        (lambda: tolerance_study(EQUAL, Tolerances(out_of_plane=0.09)), "must be less than 0.0872665 rad"),
        (
            lambda: design_map(EQUAL, "shift", errors=MeshErrors(in_plane=0.08)),
            "less than 0.0698132 rad",
        ),
        (
            lambda: Design(*EQUAL.members, EQUAL.pair, EQUAL.errors, _ANY),
            "errors_at must be 'perpendicular' or 'mesh', got 'apex'",
        ),
    ],
)
def test_refusals(call: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()
