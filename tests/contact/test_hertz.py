"""Hertzian contact ellipse against closed forms of circle and strip, elliptic integrals to 50 digits, and the
integral of the pressure.
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.hertz import axis_ratio, contact_modulus, hertz_ellipse

STEEL = contact_modulus(206000.0, 0.3)


def test_modulus_of_two_like_bodies() -> None:
    assert pytest.approx(206000.0 / 2.0 / (1.0 - 0.3**2), rel=1e-14) == STEEL


@pytest.mark.parametrize(("radius", "force"), [(10.0, 1000.0), (0.3, 1.0), (400.0, 2e5)])
def test_ball_on_a_plane(radius: float, force: float) -> None:
    """a^3 = 3 F R / (4 E*), p0 = 3 F / (2 pi a^2)."""
    found = hertz_ellipse(np.full(2, 1.0 / radius), force, STEEL)
    a = (0.75 * force * radius / STEEL) ** (1.0 / 3.0)
    assert found.semi_axes == pytest.approx((a, a), rel=1e-14)
    assert found.pressure == pytest.approx(1.5 * force / (np.pi * a * a), rel=1e-14)


@pytest.mark.parametrize("ratio", [1e-11, 1e-6, 3.94e-4, 0.0066, 0.3, 0.99, 1.0 - 1e-9])
def test_elliptic_integrals(ratio: float) -> None:
    """Johnson (4.26): A = p0 b (K - E) / (E* e^2 a^2), B = p0 b (E a^2/b^2 - K) / (E* e^2 a^2), 50 digits."""
    greatest = 0.044
    found = hertz_ellipse(np.array([ratio * greatest, greatest]), 1000.0, STEEL)
    with mpmath.workdps(50):
        a, b = (mpmath.mpf(float(axis)) for axis in found.semi_axes)
        parameter = 1 - (b / a) ** 2
        first, second = mpmath.ellipk(parameter), mpmath.ellipe(parameter)
        scale = float(found.pressure) * b / (STEEL * parameter * a * a)
        least = scale * (first - second)
        most = scale * (second * (a / b) ** 2 - first)
        # For a nearly circular ellipse, the difference of a and b is dominated by rounding.
        precision = 1e-12 + 1e-15 / (1.0 - ratio)
        assert abs(float(2 * least / (ratio * greatest)) - 1.0) < precision
        assert abs(float(2 * most / greatest) - 1.0) < precision
    assert found.semi_axes[0] > found.semi_axes[1]
    assert np.prod(found.semi_axes) * found.pressure * 2.0 * np.pi / 3.0 == pytest.approx(1000.0, rel=1e-14)


def test_slenderness_of_very_long_ellipses_and_near_circles() -> None:
    """b / a from 1e-11 to 1 - 1e-9, by its A / B = k^2 (K - E) / (E - k^2 K) to 50 digits."""
    wanted = np.concatenate(
        (10.0 ** np.linspace(-11.0, -0.01, 120), 1.0 - 10.0 ** np.linspace(-2.0, -9.0, 8))
    )
    ratios = []
    with mpmath.workdps(50):
        for k in wanted:
            square = mpmath.mpf(float(k)) ** 2
            first, second = mpmath.ellipk(1 - square), mpmath.ellipe(1 - square)
            ratios.append(float(square * (first - second) / (second - square * first)))
    assert np.abs(axis_ratio(ratios) / wanted - 1.0).max() < 1e-14
    assert axis_ratio([1.0, 0.0]).tolist() == pytest.approx([1.0, 1e-12], rel=1e-12)
    assert np.isnan(axis_ratio([-0.1, 1.1, np.nan])).all()


@pytest.mark.parametrize("ratio", [1.0, 0.5, 0.01, 1e-3])
def test_by_the_integral_of_the_pressure(ratio: float) -> None:
    """Boussinesq: u = 1/(pi E*) times the integral of p / r.

    In polar coordinates about a point inside the ellipse, the integrand of each chord is a half-ellipse with
    known area. The surfaces touch everywhere: u(0) - u = A x^2 + B y^2. No elliptic integral is used.
    """
    curvature = np.array([ratio, 1.0]) * 0.05
    found = hertz_ellipse(curvature, 2500.0, STEEL)
    angle = (np.arange(200_000) + 0.5) * np.pi / 200_000
    way, scale = np.stack((np.cos(angle), np.sin(angle))), found.semi_axes[:, None] ** -2.0

    def sunk(point: FloatArray) -> float:
        alpha, beta = (way * way * scale).sum(axis=0), (point[:, None] * way * scale).sum(axis=0)
        height = 1.0 - (point * point * scale[:, 0]).sum() + beta * beta / alpha
        return float(found.pressure * np.pi / (2.0 * STEEL) * (height / np.sqrt(alpha)).mean())

    for share in ((0.5, 0.0), (0.0, 0.7), (0.6, 0.6), (0.999, 0.0)):
        point = np.array(share) * found.semi_axes
        gap = 0.5 * float(curvature @ point**2)
        assert sunk(np.zeros(2)) - sunk(point) == pytest.approx(gap, rel=1e-9)


def test_a_very_long_ellipse_is_a_strip() -> None:
    """In the middle of a very long ellipse, p0 = E* b / (2 R), as for two cylinders. Line contact has the
    ratio 1e-12."""
    for least in (1e-14, 0.0):
        found = hertz_ellipse(np.array([least, 0.04]), 1000.0, STEEL)
        assert found.pressure == pytest.approx(0.5 * STEEL * found.semi_axes[1] * 0.04, rel=1e-4)
    assert found.semi_axes[1] == pytest.approx(1e-12 * found.semi_axes[0], rel=1e-12)


@pytest.mark.parametrize("curvature", [(-1e-5, 0.04), (np.nan, np.nan), (0.0, 0.0)])
def test_overlapping_flanks_have_no_ellipse(curvature: tuple[float, float]) -> None:
    found = hertz_ellipse(np.array(curvature), 1000.0, STEEL)
    assert np.isnan([*found.semi_axes, found.pressure]).all()
