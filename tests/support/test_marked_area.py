"""Areas of regions against closed forms: large, small and narrow ones, with corners, kinks and jumps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from beveloid_geom.arrays import FloatArray
from beveloid_geom.support.marked_area import marked_area

Field = Callable[[FloatArray, FloatArray], FloatArray]
DEPTH, FACE = 12.0, 50.0


def ellipse(x0: float, y0: float, a: float, b: float) -> Field:
    return lambda x, y: np.hypot((x - x0) / a, (y - y0) / b) - 1.0


def box(a: float, b: float) -> Field:
    return lambda x, y: np.maximum(np.abs(x - 6.1) / a, np.abs(y - 25.2) / b) - 1.0


def ring(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(np.abs(np.hypot(x - 6.03, 0.25 * (y - 24.7)) - 3.0) - 0.05)


def diagonal(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(np.abs(x - 0.2 * y - 1.0) - 0.02)


def steep_beyond_a_kink(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a function that is flat within 0.5 of a line and thirty times as steep beyond, as at the edge of
    a mating flank."""
    away = np.abs(x - 6.1) + 0.0 * y
    return np.where(away < 0.5, 0.6 * away - 0.4, 18.0 * (away - 0.5) - 0.1)


def without_values(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a function without values beyond an inclined line, as where there is no mating flank."""
    return np.where((x > 4.1) & (x - 0.1 * y < 7.3), -0.5, np.inf)


def gap(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a function that is negative on two strips with a narrow gap between them."""
    return np.asarray(np.maximum(0.1 - np.abs(x - 5.03), np.abs(x - 5.03) - 0.6) + 0.0 * y)


CASES: dict[str, tuple[Field, float]] = {
    "large": (ellipse(6.0, 25.0, 4.0, 15.0), 60.0 * np.pi),
    "small": (ellipse(6.2, 25.3, 0.6, 1.8), 1.08 * np.pi),
    "between all lines": (ellipse(6.22, 25.73, 0.2, 0.4), 0.08 * np.pi),
    "hundredths": (ellipse(6.22, 25.73, 0.02, 0.04), 8e-4 * np.pi),
    "on a corner": (ellipse(0.0, 0.0, 2.0, 9.0), 4.5 * np.pi),
    "tiny on a corner": (ellipse(12.0, 50.0, 0.2, 0.9), 0.045 * np.pi),
    "cut by an edge": (ellipse(12.0, 25.0, 0.3, 20.0), 3.0 * np.pi),
    "box": (box(3.03, 11.07), 4.0 * 3.03 * 11.07),
    "narrow box": (box(0.13, 11.07), 4.0 * 0.13 * 11.07),
    "hair": (box(0.013, 11.07), 4.0 * 0.013 * 11.07),
    "ring": (ring, 4.0 * np.pi * (3.05**2 - 2.95**2)),
    "diagonal": (diagonal, 2.0),
    "kink": (steep_beyond_a_kink, 100.0 * (0.5 + 0.1 / 18.0)),
    "without values": (without_values, 160.0 + 125.0 - 0.45),
    "gap": (gap, 50.0),
    "all": (lambda x, y: 0.0 * x - 1.0, 600.0),
}


def measured(field: Field, shape: tuple[int, int], bound: float) -> tuple[float, float]:
    """Return area and error from a grid on a plane."""
    x, y = np.meshgrid(np.linspace(0.0, DEPTH, shape[0]), np.linspace(0.0, FACE, shape[1]), indexing="ij")
    points = np.stack((x, y, 0.0 * x), axis=-1)
    found = marked_area(lambda at: field(*(at * (DEPTH, FACE)).T), field(x, y), points, bound)
    assert found.total == pytest.approx(600.0, rel=1e-12)
    assert sum(map(enclosed, found.border)) == pytest.approx(found.area, abs=1e-9)
    return found.area, found.error


def enclosed(polygon: FloatArray) -> float:
    """Return the area inside a polygon of the unit square on the plane; negative for a hole."""
    (x, y), (after_x, after_y) = polygon.T * 600.0**0.5, np.roll(polygon, -1, axis=0).T * 600.0**0.5
    return float(0.5 * (x @ after_y - y @ after_x))


@pytest.mark.parametrize("bound", [0.01, 0.001])
@pytest.mark.parametrize("name", CASES)
def test_the_error_is_within_the_bound(name: str, bound: float) -> None:
    field, exact = CASES[name]
    area, error = measured(field, (25, 33), bound)
    assert error <= bound
    assert abs(area / exact - 1.0) <= max(error, 1e-9)


def test_the_area_does_not_depend_on_the_grid() -> None:
    field, exact = CASES["kink"]
    for shape in ((25, 33), (28, 37), (60, 45)):
        assert measured(field, shape, 0.01)[0] == pytest.approx(exact, rel=0.01)


def test_a_curved_surface() -> None:
    """Part of a sphere of radius 10 mm between two latitudes; the region has half of its longitudes."""
    grid = np.meshgrid(np.linspace(0.2, 1.0, 25), np.linspace(0.0, 1.5, 33), indexing="ij")
    points = 10.0 * np.stack(
        (np.cos(grid[0]) * np.cos(grid[1]), np.cos(grid[0]) * np.sin(grid[1]), np.sin(grid[0])), axis=-1
    )
    area, error, total, _ = marked_area(lambda at: at[:, 1] - 0.5, grid[1] / 1.5 - 0.5, points, 0.001)
    assert total == pytest.approx(150.0 * (np.sin(1.0) - np.sin(0.2)), rel=1e-3)
    assert area == pytest.approx(0.5 * total, rel=1e-4)
    assert error <= 0.001


def test_an_empty_region_has_no_area() -> None:
    assert measured(lambda x, y: 0.0 * x + 1.0, (25, 33), 0.01) == (0.0, 0.0)
    assert measured(lambda x, y: 0.0 * x + np.inf, (25, 33), 0.01) == (0.0, 0.0)


def test_an_exceeded_bound_is_reported() -> None:
    """The border is nowhere smooth, so that the error remains larger than the bound."""

    def rough(x: FloatArray, y: FloatArray) -> FloatArray:
        waves = sum(3.0 ** (-0.3 * k) * np.sin(3.0**k * y) for k in range(12))
        return np.asarray(x - 6.0 - waves)

    area, error = measured(rough, (25, 33), 0.001)
    assert error > 0.001
    assert abs(area / 300.0 - 1.0) <= error
