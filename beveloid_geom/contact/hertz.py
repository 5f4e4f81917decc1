"""Contact of elastic bodies by Hertz: the ellipse in which two flanks touch under a force.

Near the contact the bodies part by A x^2 + B y^2, A <= B, half the relative curvatures. They touch
in an ellipse with the semi-axes a along x and b = k a along y, with R_D Carlson's integral

    A / B = R_D(0, k^2, 1) / R_D(0, 1, k^2),    (A + B) b = E(sqrt(1 - k^2)) p0 / E*,

under the pressure p0 sqrt(1 - (x/a)^2 - (y/b)^2), p0 = 3 F / (2 pi a b). Source: K. L. Johnson, Contact
Mechanics (1985), 4.2; his (K - E) and (E - k^2 K) are written as R_D (DLMF 19.25), which loses no digits
where the ellipse is next to a circle or very long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray

SLENDEREST = 1e-12
"""Least b / a: a longer ellipse is a strip wherever there is metal."""


@dataclass(frozen=True, eq=False)
class HertzEllipse:
    """Hold where two bodies touch under `force` (N): `semi_axes` (2,), mm, along the directions of the
    smaller and the greater relative curvature, and the greatest `pressure` (MPa)."""

    force: float
    semi_axes: FloatArray
    pressure: float


def contact_modulus(young: float, poisson: float) -> float:
    """Give E* (MPa) of two bodies of one material."""
    return young / (2.0 * (1.0 - poisson**2))


def slenderness(ratio: float) -> float:
    """Give k = b / a of the ellipse for the `ratio` A / B of the curvatures, 0 to 1; SLENDEREST at least."""
    from scipy.optimize import brentq
    from scipy.special import elliprd

    def off(log_k: float) -> float:
        square = np.exp(2.0 * log_k)
        return float(np.log(ratio * elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0)))

    least = np.log(SLENDEREST)
    if ratio <= 0.0 or off(least) <= 0.0:
        return SLENDEREST
    return float(np.exp(brentq(off, least, 1e-3, xtol=1e-15))) if ratio < 1.0 else 1.0


def hertz_ellipse(curvature: FloatArray, force: float, modulus: float) -> HertzEllipse:
    """Give the ellipse of contact for the relative `curvature` (2,), 1/mm, smaller first, of two bodies
    pressed together by `force` (N), `modulus` E* in MPa.

    Raises ValueError where a curvature is negative: the bodies cut each other beside the contact."""
    from scipy.special import ellipe

    least, greatest = (float(value) for value in curvature)
    if not (least >= 0.0 and greatest > 0.0):
        text = f"the flanks cut each other beside the contact (relative curvature {least:.3g} 1/mm)"
        raise ValueError(f"{text}: there is no contact to load, take weaker parabolas")
    k = slenderness(least / greatest)
    mean = 0.5 * (least + greatest)
    major = (1.5 * force * float(ellipe(1.0 - k * k)) / (np.pi * k * k * modulus * mean)) ** (1.0 / 3.0)
    axes = np.array([major, k * major])
    return HertzEllipse(force, axes, float(1.5 * force / (np.pi * axes.prod())))
