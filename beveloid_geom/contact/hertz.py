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
from numpy.typing import ArrayLike

from ..arrays import FloatArray

YOUNG, POISSON = 206000.0, 0.3
"""Elastic modulus (MPa) and Poisson's ratio of steel."""
SLENDEREST = 1e-12
"""Least b / a: a longer ellipse is a strip wherever there is metal."""
STEPS, LAST_STEP = 30, 1e-15
"""Newton steps at most, and the step of log k below which one is the last."""


@dataclass(frozen=True, eq=False)
class HertzEllipse:
    """Hold where two bodies touch under `force` (N): `semi_axes` (..., 2), mm, along the directions of the
    smaller and the greater relative curvature, and the greatest `pressure` (...), MPa. NaN where a curvature
    is negative: the bodies cut each other beside the contact."""

    force: FloatArray
    semi_axes: FloatArray
    pressure: FloatArray


def contact_modulus(young: float, poisson: float) -> float:
    """Give E* (MPa) of two bodies of one material."""
    return young / (2.0 * (1.0 - poisson**2))


def slenderness(ratio: ArrayLike) -> FloatArray:
    """Give k = b / a (...) of ellipses for the `ratio` A / B (...) of the curvatures, 0 to 1; SLENDEREST at
    least, NaN for others. By Newton in log k: the slope of log(A / B) is 3/2 (circle) to 2 (strip)."""
    from scipy.special import elliprd

    longest = np.log(SLENDEREST)
    with np.errstate(invalid="ignore", divide="ignore"):
        wanted = np.maximum(np.log(ratio), 2.0 * longest)
        log_k = np.where(wanted <= 0.0, 0.5 * wanted, np.nan)
        for _ in range(STEPS):
            square = np.exp(2.0 * log_k)
            shape = elliprd(0.0, square, 1.0) / elliprd(0.0, 1.0, square)  # A / B of this k
            slope = 2.0 - (square / shape - shape) / (1.0 - square)  # 0 / 0 for a circle
            step = (wanted - np.log(shape)) / np.clip(np.nan_to_num(slope), 1.5, 2.0)
            before, log_k = log_k, np.clip(log_k + step, longest, 0.0)
            if not np.any(np.abs(log_k - before) > LAST_STEP):
                break
    return np.exp(log_k)


def hertz_ellipse(curvature: ArrayLike, force: ArrayLike, modulus: float) -> HertzEllipse:
    """Give ellipses of contact.

    Parameters
    ----------
    curvature : array_like, shape (..., 2)
        Principal relative curvatures, 1/mm, the smaller first.
    force : array_like, shape (...)
        Force that presses the bodies together, N.
    modulus : float
        E*, MPa, of `contact_modulus`.
    """
    from scipy.special import ellipe

    least, greatest = np.moveaxis(np.asarray(curvature, dtype=float), -1, 0)
    force = np.asarray(force, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        k = slenderness(np.where(greatest > 0.0, least / greatest, np.nan))
        mean = 0.5 * (least + greatest)  # A + B
        major = np.cbrt(1.5 * force * ellipe(1.0 - k * k) / (np.pi * k * k * (modulus * mean)))
        axes = np.stack((major, k * major), axis=-1)
        pressure = 1.5 * force / (np.pi * axes.prod(axis=-1))
    return HertzEllipse(np.broadcast_to(force, pressure.shape), axes, pressure)
