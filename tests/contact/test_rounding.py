"""The estimated effect of rounding on a contact, compared with solutions at 60 digits."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Design, Errors, path_of_contact
from beveloid_geom.contact.rounding import rounding_error
from tests.oracle.sixty_digits import exact_at
from tests.oracle.table1 import table1
from tests.stability.named_designs import CROSSING
from tests.stability.test_shaft_angles import folding


def true_error(design: Design, flank: str = "right") -> float:
    """Return the largest distance (mm) of three positions of the path from the solution at their rolls."""
    path = path_of_contact(design, flank, 5)
    exact = [np.array(exact_at(path, k).point, dtype=float) for k in (1, 2, 3)]
    away = np.linalg.norm(path.point[1:4] - exact, axis=-1)
    return float(away.max())


@pytest.mark.parametrize("degrees", [0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6])
def test_near_the_fold_the_estimate_increases_with_the_error(degrees: float) -> None:
    design = folding(degrees)
    estimate = rounding_error(path_of_contact(design, points=5)).max()
    assert 0.05 * estimate < true_error(design) < 20.0 * estimate
    assert estimate == pytest.approx(2.27e-13 / degrees, rel=0.3)


@pytest.mark.parametrize("design", [table1(), table1((0.001, -0.001)), *CROSSING.values()])
def test_paths_that_cross_n_x_0_lose_no_digits(design: Design) -> None:
    estimate = rounding_error(path_of_contact(design, points=5)).max()
    assert estimate < 1e-11
    assert true_error(design) < 20.0 * estimate


def test_batches_and_no_path() -> None:
    batch = table1((0.001, -0.001), Errors(offset=np.array([0.0, 0.1, 500.0])))
    path = path_of_contact(batch, points=4)
    moved = rounding_error(path)
    assert moved.shape == (3, 4)
    assert np.isnan(moved[2]).all()
    single = table1((0.001, -0.001), Errors(offset=0.1))
    np.testing.assert_allclose(moved[1], rounding_error(path_of_contact(single, points=4)), rtol=1e-3)
    none = table1(errors=Errors(offset=500.0))
    assert rounding_error(path_of_contact(none, points=4)).size == 0
