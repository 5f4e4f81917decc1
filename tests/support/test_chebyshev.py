"""Chebyshev series against mpmath, and derivatives, degrees and roots of elementary functions."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from beveloid_geom.support.chebyshev import (
    basis_of,
    evaluate,
    real_roots,
    resolved_degree,
    with_derivative,
)

ONE = np.ones(1)


@pytest.mark.parametrize("degree", [20, 100, 400])
def test_rounding_errors_do_not_grow_with_the_degree(degree: int) -> None:
    basis = basis_of(degree)
    coefficients = basis.coefficients(np.exp(basis.nodes)[None, None])
    bessel = [float(mp.besseli(k, 1) * (1 if k == 0 else 2)) for k in range(degree + 1)]
    assert np.abs(coefficients[0, 0] - bessel).max() < 1e-15
    size = resolved_degree(coefficients, ONE)
    assert size == np.flatnonzero(np.array(bessel) > 3e-15)[-1] == 13


@pytest.mark.parametrize(("degree", "rate"), [(40, 2.0), (100, 30.0), (400, 150.0)])
def test_derivative_at_any_degree(degree: int, rate: float) -> None:
    basis = basis_of(degree)
    both = with_derivative(basis.coefficients(np.sin(rate * basis.nodes)[None, None]))
    x = np.linspace(-1.0, 1.0, 2001)
    values = evaluate(both, x)[:, 0]
    assert both.shape == (2, 1, degree + 1)
    # Rounding of x causes an error of rate * eps; differentiation multiplies it by up to degree^2.
    rounding = np.finfo(float).eps * rate
    assert np.abs(values[0] - np.sin(rate * x)).max() < 8.0 * rounding
    assert np.abs(values[1] - rate * np.cos(rate * x)).max() < degree**2 * rounding


def test_resolved_degree() -> None:
    coefficients = np.zeros((2, 1, 41))
    coefficients[0, 0, 7], coefficients[1, 0, 12] = 1.0, 100.0 * 2.0 * 3e-15
    assert resolved_degree(coefficients, np.array([1.0, 100.0])) == 12
    assert resolved_degree(coefficients, np.array([1.0, 1000.0])) == 7
    assert resolved_degree(0.0 * coefficients, np.ones(2)) == 1
    for basis in (basis_of(40), basis_of(400)):
        for rough in (np.abs(basis.nodes), np.where(basis.nodes < 0.1, np.nan, 1.0)):
            assert resolved_degree(basis.coefficients(rough[None, None]), ONE) is None
    slow, fast = (np.cos(rate * basis_of(40).nodes) for rate in (1.0, 60.0))
    both = basis_of(40).coefficients(np.array([slow, fast])[:, None])
    assert resolved_degree(both[:1], ONE) is not None
    assert resolved_degree(both, np.ones(2)) is None


def test_real_roots() -> None:
    basis = basis_of(40)
    found = real_roots(basis.coefficients(np.cos(7.0 * basis.nodes)[None])[0], -1.0, 1.0)
    np.testing.assert_allclose(found, np.pi / 14.0 * np.array([-3.0, -1.0, 1.0, 3.0]), atol=1e-13)
    assert real_roots(np.zeros(5), -1.0, 1.0).size == 0
