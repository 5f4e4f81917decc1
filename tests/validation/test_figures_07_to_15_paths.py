"""Every pair of the paper's Figs. 7-15 against the five equations at 60 digits."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Errors, path_of_contact
from tests.oracle.pitch_point_mp import mounting_mp
from tests.oracle.sixty_digits import off_by
from tests.oracle.table1 import table1

BOUND = 1e-10  # mm, and rad
SMALL, LARGE = (0.0, 0.00005, 0.0001, 0.00015, 0.0002), (0.0, 0.0005, 0.001, 0.0015, 0.002)
MODIFIED = (0.001, -0.001)
SHAFT_ANGLE_ERROR = float(np.radians(0.015))

FIGURES_7_TO_10 = [
    (figure, (sign1 * a, sign2 * a))
    for figure, sign1, sign2, range_ in (
        (7, 1, 1, SMALL),
        (8, -1, -1, SMALL),
        (9, 1, -1, LARGE),
        (10, -1, 1, LARGE),
    )
    for a in range_
]
FIGURES_12_TO_15 = [
    (figure, parabola, Errors(**{field: sign * size}))
    for figure, field, size in (
        (12, "offset", 0.5),
        (13, "shaft_angle", SHAFT_ANGLE_ERROR),
        (14, "pinion_axial", 0.5),
        (15, "gear_axial", 0.5),
    )
    for parabola in ((0.0, 0.0), MODIFIED)
    for sign in (-1.0, 1.0)
]


@lru_cache(maxsize=1)
def exact_mounting() -> tuple[Any, Any]:
    mounting = mounting_mp(table1())
    return mounting.dw1, mounting.dw2


def compare(parabola: tuple[float, float], errors: Errors, flank: str) -> None:
    """Compare three positions of the path, ends included, with solutions at 60 digits at the same l1."""
    path = path_of_contact(table1(parabola, errors), flank, 3)
    assert flank == "left" or path.l1.size == 3  # no panel of the right flank is empty
    for k in range(path.l1.size):
        assert max(off_by(path, k, "l1", exact_mounting())) < BOUND


@pytest.mark.parametrize(("figure", "parabola"), FIGURES_7_TO_10)
def test_figures_7_to_10(figure: int, parabola: tuple[float, float], flank: str) -> None:
    compare(parabola, Errors(), flank)


@pytest.mark.parametrize(("figure", "parabola", "errors"), FIGURES_12_TO_15)
def test_figures_12_to_15(figure: int, parabola: tuple[float, float], errors: Errors, flank: str) -> None:
    compare(parabola, errors, flank)
