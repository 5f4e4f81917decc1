"""The estimated effect of rounding on a contact, compared with solutions at 60 digits."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Design, path_of_contact
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
