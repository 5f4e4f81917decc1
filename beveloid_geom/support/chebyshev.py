"""Chebyshev interpolation of smooth curves through exact solutions.

A path of contact is analytic if its common normal turns smoothly. A polynomial through a few dozen exact
solutions then represents it to rounding error. The coefficients show whether it does: they decrease to the
level of rounding, or the curve counts as not resolved.

Values are arrays (quantities, cases, nodes), coefficients (quantities, cases, degree + 1). Parameters are in
[-1, 1]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ..arrays import FloatArray, Mask
from .frozen_arrays import cached
from .products import product

RELATIVE_NOISE = 2e-14
"""Level, relative to the scale of a quantity, below which the last coefficients of a resolved curve are."""
SMALLEST_STEP = 1e-15
"""Step of the parameter that ends an iteration."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Chebyshev points of one degree, including the ends, and the matrix that fits values there."""

    nodes: FloatArray
    fit: FloatArray

    def coefficients(self, values: FloatArray) -> FloatArray:
        """Return the coefficients of the polynomials with these values at `nodes`."""
        return product(values, self.fit)


@cached(32)
def basis_of(degree: int) -> Basis:
    """Return the basis of an even degree, whose middle node is 0.

    The values of the polynomials at the nodes are cos(pi m / degree) with an integer m, which are nodes
    again. Values taken from the nodes are exact to rounding; a recursion would not be."""
    order = np.arange(degree + 1)
    nodes = np.sin(0.5 * np.pi / degree * (2 * order - degree))
    turn = np.outer(order[::-1], order) % (2 * degree)
    weights = np.where(order % degree == 0, 0.5, 1.0)
    fit = -2.0 / degree * np.outer(weights, weights) * nodes[np.minimum(turn, 2 * degree - turn)]
    return Basis(nodes, fit)


@cached(32)
def _derivation(size: int) -> FloatArray:
    """Return the matrix (size, size) from coefficients to those of the derivative."""
    matrix = np.zeros((size, size))
    matrix[:, :-1] = chebyshev.chebder(np.eye(size), axis=0).T
    return matrix


def with_derivative(coefficients: FloatArray, orders: int = 1) -> FloatArray:
    """Return `coefficients` (quantities, ...), followed along the first axis by those of their derivatives up
    to `orders`: (quantities (1 + orders), ...)."""
    parts, matrix = [coefficients], _derivation(coefficients.shape[-1])
    for _ in range(orders):
        parts.append(product(parts[-1], matrix))
    return np.concatenate(parts)


def real_roots(coefficients: FloatArray, low: float, high: float) -> FloatArray:
    """Return the real roots in (low, high) of one polynomial (degree + 1), in increasing order.

    The sign is sampled at four points per possible extremum. A pair of roots between two samples is detected
    by the extremum between them."""
    # Without a constant term that the other terms can cancel there is no root.
    sizes = np.abs(coefficients)
    if not sizes[0] <= sizes[1:].sum() or not sizes.max() > 0.0:
        return np.empty(0)
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 4 * len(coefficients) + 1))
    x = low + share * (high - low)
    both = with_derivative(coefficients[None, None])
    value, rate = evaluate(both, x)[:, 0]
    # Add the extrema between samples of equal sign.
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
    """Return the parameters at which polynomials have given values.

    Newton's method is used; a step that leaves the bracket is replaced by a bisection.

    Parameters
    ----------
    coefficients : array (cases, degree + 1) or (degree + 1)
        Polynomials.
    values : array (cases, positions) or (positions)
        Values, between those of the polynomials at `low` and `high`.
    low, high : array or float
        Brackets of the parameters.

    Returns
    -------
    array, shape of `values`
    """
    if coefficients.ndim == 1:
        return np.asarray(inverted(coefficients[None], values[None], low, high)[0])
    both = with_derivative(coefficients[None])
    left, right = np.broadcast_to(low, values.shape), np.broadcast_to(high, values.shape)
    rising = evaluate(both[:1], right)[0] > evaluate(both[:1], left)[0]
    x = 0.5 * (left + right)
    # Largest number of steps of an inversion.
    max_iterations = 60
    for _ in range(max_iterations):
        value, rate = evaluate(both, x)
        above = (value > values) == rising
        left, right = np.where(above, left, x), np.where(above, x, right)
        with np.errstate(divide="ignore", invalid="ignore"):
            following = x + (values - value) / rate
        within = (following >= left) & (following <= right)
        following = np.where(within, following, 0.5 * (left + right))
        x, step = following, np.abs(following - x).max(initial=0.0)
        if step <= SMALLEST_STEP:
            break
    return np.asarray(x)


def polynomials(parameter: FloatArray, degree: int) -> FloatArray:
    """Return the Chebyshev polynomials (degree + 1, ...) at parameters in [-1, 1] or slightly outside."""
    orders = np.arange(degree + 1.0).reshape(-1, *[1] * parameter.ndim)
    if parameter.size * degree < 1500 and np.abs(parameter).max(initial=0.0) <= 1.0:
        return np.asarray(np.cos(orders * np.arccos(parameter)))  # faster for small arrays
    values = np.empty((degree + 1, *parameter.shape))
    values[0] = 1.0
    values[1] = parameter
    double = 2.0 * parameter
    for order in range(2, degree + 1):
        np.multiply(double, values[order - 1], out=values[order])
        values[order] -= values[order - 2]
    return values


def evaluate(coefficients: FloatArray, parameter: FloatArray) -> FloatArray:
    """Return values (quantities, cases, positions) at parameters (positions) or (cases, positions)."""
    values = polynomials(parameter, coefficients.shape[-1] - 1)
    if parameter.ndim == 1:
        flat = product(coefficients.reshape(-1, coefficients.shape[-1]), values)
        return flat.reshape(*coefficients.shape[:2], parameter.size)
    return product(coefficients.transpose(1, 0, 2), values.transpose(1, 0, 2)).transpose(1, 0, 2)


def greatest(coefficients: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the parameters (cases, 1) of the largest values of polynomials (cases, degree + 1).

    The largest of 65 samples between `low` and `high` (cases, 1) is refined by Newton's method for the zero
    of the derivative. If the polynomial is not concave there, the step goes to the end of the interval."""
    both = with_derivative(coefficients[None], 2)
    shares = np.linspace(0.0, 1.0, 65)
    samples = low + (high - low) * shares
    best = np.take_along_axis(samples, evaluate(both[:1], samples)[0].argmax(axis=-1)[:, None], axis=-1)
    step = (high - low) * shares[1]
    low, high = np.maximum(low, best - step), np.minimum(high, best + step)
    for _ in range(12):
        _, rate, bend = evaluate(both, best)
        outward = np.where(rate > 0.0, high, low)
        with np.errstate(invalid="ignore", divide="ignore"):
            following = np.where(bend < 0.0, np.clip(best - rate / bend, low, high), outward)
        best, step = following, np.abs(following - best).max(initial=0.0)
        if step <= SMALLEST_STEP:
            break
    return best


def resolved(coefficients: FloatArray, scale: FloatArray) -> Mask:
    """Return for which cases the polynomials represent the curves to rounding error.

    The rounding error of each quantity is relative to its `scale` (quantities) or (quantities, cases)."""
    size = np.abs(coefficients[..., -max(3, coefficients.shape[-1] // 8) :]).max(axis=-1)
    return np.asarray((size <= RELATIVE_NOISE * scale.reshape(len(scale), -1)).all(axis=0))


def resolved_degree(coefficients: FloatArray, scale: FloatArray) -> int | None:
    """Return the degree (at least 1) that represents the curves of all cases to rounding error.

    None if some of them are not resolved."""
    if not resolved(coefficients, scale).all():
        return None
    size = (np.abs(coefficients) / scale.reshape(len(scale), -1, 1)).max(axis=(0, 1), initial=0.0)
    # Relative level below which trailing coefficients are not needed.
    needed = np.flatnonzero(size > 3e-15)
    return max(1, int(needed[-1])) if needed.size else 1
