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

from .inputs import FloatArray

NOISE, CUT = 2e-14, 3e-15
"""Relative to the quantities' scale: level to which the last coefficients must have fallen for a
curve to count as resolved, and level below which trailing coefficients are not needed."""
SMALL = 4000


@dataclass(frozen=True, eq=False)
class Basis:
    """Chebyshev points of one degree, ends included, and the matrix that fits values there."""

    nodes: FloatArray
    fit: FloatArray

    def coefficients(self, values: FloatArray) -> FloatArray:
        """Coefficients of the polynomial with these values at `nodes`."""
        return values @ self.fit


def basis_of(degree: int) -> Basis:
    """The basis of an even degree, whose middle node is 0."""
    nodes = -np.cos(np.pi * np.arange(degree + 1) / degree)
    nodes[degree // 2] = 0.0
    weights = np.ones(degree + 1)
    weights[[0, -1]] = 0.5
    fit = 2.0 / degree * weights[:, None] * chebyshev.chebvander(nodes, degree) * weights
    return Basis(nodes, fit)


HIGHEST = 100
_SLOPE = np.zeros((HIGHEST + 1, HIGHEST + 1))
_SLOPE[:, :-1] = chebyshev.chebder(np.eye(HIGHEST + 1), axis=0).T


def with_derivative(coefficients: FloatArray) -> FloatArray:
    """The coefficients, and behind them those of the derivatives by the curve parameter."""
    size = coefficients.shape[-1]
    return np.concatenate((coefficients, coefficients @ _SLOPE[:size, :size]))


def real_roots(coefficients: FloatArray, low: float, high: float) -> FloatArray:
    """Real roots in (low, high) of one polynomial (degree + 1)."""
    size = np.abs(coefficients).max()
    if not size > 0.0:
        return np.empty(0)
    needed = np.flatnonzero(np.abs(coefficients) > 1e-15 * size)[-1]
    roots = chebyshev.chebroots(coefficients[: needed + 1])
    real = roots.real[np.abs(roots.imag) < 1e-7]
    return np.sort(real[(real > low) & (real < high)])


def polynomials(parameter: FloatArray, degree: int) -> FloatArray:
    """Chebyshev polynomials (degree + 1, ...) at parameters in [-1, 1]."""
    orders = np.arange(degree + 1.0).reshape(-1, *[1] * parameter.ndim)
    if parameter.size * degree < SMALL:  # fewer calls beat fewer operations
        angle = np.arccos(np.minimum(np.maximum(parameter, -1.0), 1.0))
        return np.asarray(np.cos(orders * angle))
    values = np.empty((degree + 1, *parameter.shape))
    values[0] = 1.0
    values[1] = parameter
    double = 2.0 * parameter
    for order in range(2, degree + 1):
        np.multiply(double, values[order - 1], out=values[order])
        values[order] -= values[order - 2]
    return values


def evaluate(coefficients: FloatArray, parameter: FloatArray) -> FloatArray:
    """Values (quantities, cases, positions) at parameters (positions) or (cases, positions)."""
    values = polynomials(parameter, coefficients.shape[-1] - 1)
    if parameter.ndim == 1:
        flat = coefficients.reshape(-1, coefficients.shape[-1]) @ values
        return flat.reshape(*coefficients.shape[:2], -1)
    return (coefficients.transpose(1, 0, 2) @ values.transpose(1, 0, 2)).transpose(1, 0, 2)


def resolved_degree(coefficients: FloatArray, scale: FloatArray) -> int | None:
    """Degree (at least 1) that gives the curves to rounding, or None if they are not resolved.

    `scale` (quantities) is the size to which the rounding of each quantity relates."""
    size = (np.abs(coefficients) / scale[:, None, None]).max(axis=(0, 1), initial=0.0)
    if not (size[-max(3, size.size // 8) :] <= NOISE).all():
        return None
    needed = np.flatnonzero(size > CUT)
    return max(1, int(needed[-1])) if needed.size else 1
