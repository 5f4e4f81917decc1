"""Surfaces through values on a grid: exact cubics, continuous second derivatives, parabolas outside."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom.arrays import FloatArray
from beveloid_geom.support.tensor_spline import spline_through

ROWS, COLUMNS = np.linspace(-1.0, 1.0, 7), np.linspace(0.0, 3.0, 9)
FIRST, SECOND = np.meshgrid(ROWS, COLUMNS, indexing="ij")


def random_values() -> FloatArray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, FIRST.shape)


def test_polynomials_are_exact() -> None:
    """Cubics are exact inside the grid, and parabolas everywhere; with two values per line, straight lines
    are exact."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1.0, 1.0, 50), rng.uniform(0.0, 3.0, 50)
    cubic = spline_through(FIRST, SECOND, FIRST**3 * SECOND**2 - SECOND**3)
    np.testing.assert_allclose(cubic.rows(x, y)[0], x**3 * y**2 - y**3, atol=1e-12)
    far_x, far_y = 4.0 * x, 4.0 * y - 4.0
    parabola = spline_through(FIRST, SECOND, FIRST**2 * SECOND - 2.0 * FIRST * SECOND**2)
    value, by_x, by_y, by_xx, by_xy, by_yy = parabola.rows(far_x, far_y)
    np.testing.assert_allclose(value, far_x**2 * far_y - 2.0 * far_x * far_y**2, atol=1e-10)
    np.testing.assert_allclose(by_x, 2.0 * far_x * far_y - 2.0 * far_y**2, atol=1e-10)
    np.testing.assert_allclose(by_y, far_x**2 - 4.0 * far_x * far_y, atol=1e-10)
    np.testing.assert_allclose(by_xx, 2.0 * far_y, atol=1e-10)
    np.testing.assert_allclose(by_xy, 2.0 * far_x - 4.0 * far_y, atol=1e-10)
    np.testing.assert_allclose(by_yy, -4.0 * far_x, atol=1e-10)
    corners = np.ix_((0, -1), (0, -1))
    plane = spline_through(FIRST[corners], SECOND[corners], FIRST[corners] * SECOND[corners])
    np.testing.assert_allclose(plane.rows(far_x, far_y)[0], far_x * far_y, atol=1e-12)


def test_values_next_to_the_nodes_are_met() -> None:
    rng = np.random.default_rng(2)
    first = FIRST + 0.05 * rng.uniform(-1.0, 1.0, FIRST.shape)
    second = SECOND + 0.05 * rng.uniform(-1.0, 1.0, FIRST.shape)
    values = random_values()
    found = spline_through(first, second, values).rows(first, second)[0]
    np.testing.assert_allclose(found, values, atol=1e-12)


def test_second_derivatives_are_continuous() -> None:
    """Second derivatives are equal on both sides of each node and of the places where the continuation
    becomes a parabola."""
    spline, step = spline_through(FIRST, SECOND, random_values()), 1e-9
    x, y = np.meshgrid((-1.0 - 1.0 / 6.0, *ROWS, 1.0 + 1.0 / 6.0), (-0.3, 1.3, 3.3))
    np.testing.assert_allclose(spline.rows(x - step, y), spline.rows(x + step, y), atol=1e-5)
    x, y = np.meshgrid(np.linspace(-1.91, 1.93, 23), np.linspace(-1.03, 4.04, 19))
    h = 1e-5
    rows = spline.rows(x, y)
    by_x = (spline.rows(x + h, y) - spline.rows(x - h, y)) / (2.0 * h)
    by_y = (spline.rows(x, y + h) - spline.rows(x, y - h)) / (2.0 * h)
    np.testing.assert_allclose(rows[[1, 3, 4]], by_x[[0, 1, 2]], atol=1e-5)
    np.testing.assert_allclose(rows[[2, 5]], by_y[[0, 2]], atol=1e-5)


def test_scatter_does_not_grow_beyond_the_grid() -> None:
    """Scattered values without their least-squares parabola along each line are continued by constants, which
    are at most 3 times as large as the values, 9 times at corners."""
    values = random_values()
    for axis, nodes in enumerate((ROWS, COLUMNS)):
        lines = np.moveaxis(values, axis, 0)
        fit = np.polynomial.Polynomial.fit
        trend = np.array([fit(nodes, line, 2)(nodes) for line in lines.T]).T
        values = np.moveaxis(lines - trend, 0, axis)
    spline = spline_through(FIRST, SECOND, values)
    largest, outside = np.abs(values).max(), (-9.0, -1.2, 1.2, 9.0)
    far = spline.rows(*np.meshgrid(outside, COLUMNS))
    assert np.abs(far[0]).max() < 3.0 * largest
    np.testing.assert_allclose(far[[1, 3]], 0.0, atol=1e-10)
    np.testing.assert_allclose(far[0, :, 0], far[0, :, 1], atol=1e-10)
    corners = spline.rows(*np.meshgrid(outside, (-9.0, -0.2, 3.2, 9.0)))
    assert np.abs(corners[0]).max() < 9.0 * largest
    np.testing.assert_allclose(corners[1:], 0.0, atol=1e-10)


@pytest.mark.parametrize("order", [np.flipud, np.fliplr])
def test_other_orders_are_rejected(order: object) -> None:
    assert callable(order)
    with pytest.raises(ValueError, match="do not increase"):
        spline_through(order(FIRST), order(SECOND), random_values())
