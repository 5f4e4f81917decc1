"""Smooth surface through values on a grid, continued beyond the grid by a parabola.

Inside the grid, the surface is the tensor product of cubic splines (not-a-knot). Beyond its border, along
each coordinate, a spline is continued as the sum of two parts:

- the parabola that fits all values of the line best (least squares) continues unchanged;
- the rest, the difference between spline and parabola, fades to a constant within half a grid spacing.

Thus slope and crowning of the values continue, while waves and scatter do not grow. The surface has
continuous second derivatives everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np

from ..arrays import FloatArray

SPLINE_DEGREE = 4
"""Degree of the pieces; the part that fades has this degree."""


def _moved(poly: FloatArray, origin: float) -> FloatArray:
    """Return the coefficients (degree + 1, n), in rising order, of polynomials about another origin."""
    moved = np.zeros_like(poly)
    for k in range(SPLINE_DEGREE + 1):
        for j in range(k + 1):
            moved[j] += comb(k, j) * origin ** (k - j) * poly[k]
    return moved


def _basis(nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the pieces of the continued splines that are 1 at one node and 0 at the others.

    Returns
    -------
    breaks : ndarray, shape (pieces + 1,)
        The first and the last piece apply beyond their break, too.
    pieces : ndarray, shape (SPLINE_DEGREE + 1, pieces, nodes)
        Coefficients about the left break of each piece, in falling order.
    """
    from scipy.interpolate import CubicSpline

    count, unit = len(nodes), np.eye(len(nodes))
    # Parabola of least squares, about the middle of the nodes. The rest is the spline of the differences.
    middle = 0.5 * (nodes[0] + nodes[-1])
    powers = np.vander(nodes - middle, min(3, count), increasing=True)
    fit = np.zeros((SPLINE_DEGREE + 1, count))
    fit[: powers.shape[1]] = np.linalg.pinv(powers)
    remainder = CubicSpline(nodes, unit - powers @ fit[: powers.shape[1]])
    outer = []
    for end, spacing in ((nodes[0], nodes[0] - nodes[1]), (nodes[-1], nodes[-1] - nodes[-2])):
        # The first and second derivatives of the rest vanish at the signed distance `fade` from the end.
        fade = 0.5 * spacing
        value, slope, bend = (remainder(end, order) for order in range(3))
        third = -(slope + 2.0 / 3.0 * bend * fade) / fade**2
        fourth = (bend + 2.0 * slope / fade) / (4.0 * fade**2)
        fading = np.array((value, slope, 0.5 * bend, third, fourth))
        constant = np.zeros_like(fading)
        constant[0] = _moved(fading, fade)[0]
        outer.append((end, fade, fading, constant))
    (low, left, fade_left, far_left), (high, right, fade_right, far_right) = outer
    inner = np.zeros((SPLINE_DEGREE + 1, count - 1, count))
    inner[1:] = CubicSpline(nodes, unit).c
    breaks = np.array((low + 2.0 * left, low + left, *nodes, high + right, high + 2.0 * right))
    before = (
        _moved(fit, breaks[0] - middle) + far_left,
        _moved(fit, breaks[1] - middle) + _moved(fade_left, left),
    )
    after = _moved(fit, high - middle) + fade_right, _moved(fit, breaks[-2] - middle) + far_right
    ends = [np.stack(pair, axis=1)[::-1] for pair in (before, after)]
    return breaks, np.concatenate((ends[0], inner, ends[1]), axis=1)


@dataclass(frozen=True, eq=False)
class TensorSpline:
    """Surface over two coordinates; `function` is a piecewise polynomial of SciPy."""

    function: Any

    @property
    def breaks(self) -> tuple[FloatArray, ...]:
        """Coordinates of both directions across which the third derivatives jump; the first and last ones
        bound the outer pieces, which continue beyond them."""
        return tuple(np.asarray(line[1:-1]) for line in self.function.x)

    def rows(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return values and derivatives (6, ...) at coordinates of equal shape: the value, and the
        derivatives by first, second, twice by first, by both, twice by second."""
        at = np.stack((first.ravel(), second.ravel()), axis=-1)
        orders = (0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)
        return np.array([self.function(at, nu=order).reshape(first.shape) for order in orders])


def spline_through(first: FloatArray, second: FloatArray, values: FloatArray) -> TensorSpline:
    """Return the surface through values near the nodes of a rectangular grid.

    Parameters
    ----------
    first, second : ndarray, shape (rows, columns)
        Coordinates of the values. Their means over rows and columns are the nodes of the grid.
    values : ndarray, shape (rows, columns)

    Returns
    -------
    TensorSpline

    Raises
    ------
    ValueError
        If the coordinates do not increase along the grid, or are too far from a rectangular grid. The message
        begins with "has", so that the caller can put the name of a file before it.
    """
    fit_iterations = 100
    # Largest difference from the given values, relative to the largest value, at which the fit ends.
    fit_tolerance = 1e-13
    from scipy.interpolate import NdPPoly

    nodes = first.mean(axis=1), second.mean(axis=0)
    if not all((np.diff(line) > 0.0).all() for line in nodes):
        raise ValueError("has coordinates that do not increase along the grid")
    (breaks, pieces), (other_breaks, other_pieces) = map(_basis, nodes)

    def surface(given: FloatArray) -> TensorSpline:
        table = np.einsum("pai,ij,qbj->pqab", pieces, given, other_pieces, optimize=True)
        return TensorSpline(NdPPoly(table, (breaks, other_breaks), extrapolate=True))

    # The values belong to positions next to the nodes: the values at the nodes are corrected until the
    # surface passes through the given ones.
    given, at = values, np.stack((first, second), axis=-1)
    for _ in range(fit_iterations):
        spline = surface(given)
        missing = values - spline.function(at)
        if not np.abs(missing).max() > fit_tolerance * np.abs(values).max():
            return spline
        given = given + missing
    if not np.abs(missing).max() < 1e-9 * np.abs(values).max():
        raise ValueError("has points that are too far from a rectangular grid")
    return spline
