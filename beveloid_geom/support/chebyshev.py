"""Smooth curves through exact solutions: Chebyshev interpolation.

A path of contact is analytic wherever its common normal turns smoothly, so a polynomial
through a few dozen exact solutions gives it to rounding. Whether it does is read from the
coefficients: they fall to rounding level, or the curve counts as not resolved.

Values are arrays (quantities, cases, nodes), coefficients (quantities, cases, degree + 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ..arrays import FloatArray, Mask
from .read_only import kept

NOISE, CUT = 2e-14, 3e-15
"""Relative to the quantities' scale: level to which the last coefficients must have fallen for a
curve to count as resolved, and level below which trailing coefficients are not needed."""
SMALL = 1500
"""Operations below which polynomials come from a cosine."""
HALVINGS, LEAST_STEP = 60, 1e-15
"""Passes of an inversion at most, and the step that ends it."""
SHARES, PASSES = np.linspace(0.0, 1.0, 65), 12
"""Shares of the way at which the greatest value is looked for, and passes of Newton that refine its place."""
HIGHEST = 100
"""Degree of a fine fit."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Chebyshev points of one degree, ends included, and the matrix that fits values there."""

    nodes: FloatArray
    fit: FloatArray

    def coefficients(self, values: FloatArray) -> FloatArray:
        """Find coefficients of the polynomial with these values at `nodes`."""
        return values @ self.fit


def basis_of(degree: int) -> Basis:
    """Give the basis of an even degree, whose middle node is 0.

    The polynomials at the nodes are nodes again, cos(pi m / degree) with m an integer: taken from
    there they are exact to rounding, which they are not by recursion."""
    order = np.arange(degree + 1)
    nodes = np.sin(0.5 * np.pi / degree * (2 * order - degree))
    turn = np.outer(order[::-1], order) % (2 * degree)
    weights = np.where(order % degree == 0, 0.5, 1.0)
    fit = -2.0 / degree * np.outer(weights, weights) * nodes[np.minimum(turn, 2 * degree - turn)]
    return Basis(nodes, fit)


@kept(32)
def _derivation(size: int) -> FloatArray:
    """Give the matrix (size, size) by which coefficients become those of the derivative."""
    matrix = np.zeros((size, size))
    matrix[:, :-1] = chebyshev.chebder(np.eye(size), axis=0).T
    return matrix


def with_derivative(coefficients: FloatArray) -> FloatArray:
    """Give the coefficients, and behind them those of the derivatives by the curve parameter."""
    return np.concatenate((coefficients, coefficients @ _derivation(coefficients.shape[-1])))


def real_roots(coefficients: FloatArray, low: float, high: float) -> FloatArray:
    """Find the real roots in (low, high) of one polynomial (degree + 1), in order.

    Its sign is sampled at four points an extremum, and at the extrema between them, so that two roots
    near each other are not missed."""
    sizes = np.abs(coefficients)
    if not sizes[0] <= sizes[1:].sum() or not sizes.max() > 0.0:
        return np.empty(0)
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 4 * len(coefficients) + 1))
    x = low + share * (high - low)
    both = with_derivative(coefficients[None, None])
    value, rate = evaluate(both, x)[:, 0]
    turns = (rate[:-1] * rate[1:] < 0.0) & (value[:-1] * value[1:] > 0.0)
    extrema = inverted(both[1, 0], np.zeros(int(turns.sum())), x[:-1][turns], x[1:][turns])
    x = np.sort(np.concatenate((x, extrema)))
    value = evaluate(both[:1], x)[0, 0]
    change = np.flatnonzero(np.signbit(value[:-1]) != np.signbit(value[1:]))
    roots = inverted(coefficients, np.zeros(change.size), x[change], x[change + 1])
    return roots[(roots > low) & (roots < high)]


def inverted(
    coefficients: FloatArray, values: FloatArray, low: FloatArray | float, high: FloatArray | float
) -> FloatArray:
    """Find parameters (cases, positions) in [low, high] at which polynomials (cases, degree + 1), on
    different sides of these values at low and high, have them: Newton, which halves the bracket where it
    would leave it. One polynomial (degree + 1) takes values (positions)."""
    if coefficients.ndim == 1:
        return np.asarray(inverted(coefficients[None], values[None], low, high)[0])
    both = with_derivative(coefficients[None])
    left, right = np.broadcast_to(low, values.shape), np.broadcast_to(high, values.shape)
    rising = evaluate(both[:1], right)[0] > evaluate(both[:1], left)[0]
    x = 0.5 * (left + right)
    for _ in range(HALVINGS):
        value, rate = evaluate(both, x)
        above = (value > values) == rising
        left, right = np.where(above, left, x), np.where(above, x, right)
        with np.errstate(divide="ignore", invalid="ignore"):
            following = x + (values - value) / rate
        within = (following >= left) & (following <= right)
        following = np.where(within, following, 0.5 * (left + right))
        x, step = following, np.abs(following - x).max(initial=0.0)
        if step <= LEAST_STEP:
            break
    return np.asarray(x)


def polynomials(parameter: FloatArray, degree: int) -> FloatArray:
    """Find the Chebyshev polynomials (degree + 1, ...) at parameters, in [-1, 1] or a little beyond."""
    orders = np.arange(degree + 1.0).reshape(-1, *[1] * parameter.ndim)
    if parameter.size * degree < SMALL and np.abs(parameter).max(initial=0.0) <= 1.0:
        return np.asarray(np.cos(orders * np.arccos(parameter)))  # fewer calls beat fewer operations
    values = np.empty((degree + 1, *parameter.shape))
    values[0] = 1.0
    values[1] = parameter
    double = 2.0 * parameter
    for order in range(2, degree + 1):
        np.multiply(double, values[order - 1], out=values[order])
        values[order] -= values[order - 2]
    return values


def evaluate(coefficients: FloatArray, parameter: FloatArray) -> FloatArray:
    """Find values (quantities, cases, positions) at parameters (positions) or (cases, positions)."""
    values = polynomials(parameter, coefficients.shape[-1] - 1)
    if parameter.ndim == 1:
        flat = coefficients.reshape(-1, coefficients.shape[-1]) @ values
        return flat.reshape(*coefficients.shape[:2], parameter.size)
    return (coefficients.transpose(1, 0, 2) @ values.transpose(1, 0, 2)).transpose(1, 0, 2)


def greatest(coefficients: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Find the parameters (cases, 1), between `low` and `high` (cases, 1), at which polynomials (cases,
    degree + 1) are greatest."""
    first = with_derivative(coefficients[None])
    both = np.concatenate((first, with_derivative(first[1:])[1:]))
    samples = low + (high - low) * SHARES
    best = np.take_along_axis(samples, evaluate(both[:1], samples)[0].argmax(axis=-1)[:, None], axis=-1)
    step = (high - low) * SHARES[1]
    low, high = np.maximum(low, best - step), np.minimum(high, best + step)
    for _ in range(PASSES):
        _, rate, bend = evaluate(both, best)
        outward = np.where(rate > 0.0, high, low)
        with np.errstate(invalid="ignore", divide="ignore"):
            following = np.where(bend < 0.0, np.clip(best - rate / bend, low, high), outward)
        best, step = following, np.abs(following - best).max(initial=0.0)
        if step <= LEAST_STEP:
            break
    return best


def resolved(coefficients: FloatArray, scale: FloatArray) -> Mask:
    """For which cases the polynomials give the curves to rounding.

    `scale` (quantities), or (quantities, cases), is the size to which the rounding of each relates."""
    size = np.abs(coefficients[..., -max(3, coefficients.shape[-1] // 8) :]).max(axis=-1)
    return np.asarray((size <= NOISE * scale.reshape(len(scale), -1)).all(axis=0))


def resolved_degree(coefficients: FloatArray, scale: FloatArray) -> int | None:
    """Find the degree (at least 1) that gives the curves of all cases to rounding, None if some are not
    resolved."""
    if not resolved(coefficients, scale).all():
        return None
    size = (np.abs(coefficients) / scale.reshape(len(scale), -1, 1)).max(axis=(0, 1), initial=0.0)
    needed = np.flatnonzero(size > CUT)
    return max(1, int(needed[-1])) if needed.size else 1
