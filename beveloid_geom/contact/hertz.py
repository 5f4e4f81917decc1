"""Contact of elastic bodies by Hertz: the ellipse in which two flanks touch under a force.

Near the contact the bodies separate by A x^2 + B y^2, A <= B, half the relative curvatures. They touch in an
ellipse with the semi-axes a along x and b = k a along y, with Carlson's integral R_D, the complete elliptic
integral of the second kind E(modulus), and E* of `contact_modulus`,

    A / B = R_D(0, k^2, 1) / R_D(0, 1, k^2),    (A + B) b = E(sqrt(1 - k^2)) p0 / E*,

under the pressure p0 sqrt(1 - (x/a)^2 - (y/b)^2), p0 = 3 F / (2 pi a b). Source: K. L. Johnson, Contact
Mechanics (1985), 4.2. Johnson's (K - E) and (E - k^2 K) are written as R_D (DLMF 19.25), which loses no
digits for nearly circular and very long ellipses.

Flanks in line contact carry a load q per unit length. They touch in a strip of the half-width b under the
pressure p0 sqrt(1 - (y/b)^2), with the relative curvature kappa across the line (Johnson, 4.2(c)):

    b = sqrt(4 q / (pi E* kappa)),    p0 = sqrt(q E* kappa / pi).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray

YOUNG_MPA, POISSON_RATIO = 206000.0, 0.3
"""Elastic modulus (MPa) and Poisson's ratio of steel."""


@dataclass(frozen=True, eq=False)
class HertzEllipse:
    """Contact of two bodies under `force` (N).

    `semi_axes` (..., 2), mm, along the directions of the smaller and the larger relative curvature; maximum
    `pressure` (...), MPa. NaN where a curvature is negative: the bodies overlap next to the contact.
    """

    force: FloatArray
    semi_axes: FloatArray
    pressure: FloatArray


def contact_modulus(young: float, poisson: float) -> float:
    """Return E* (MPa) of two bodies of the same material."""
    return young / (2.0 * (1.0 - poisson**2))


def axis_ratio(ratio: ArrayLike) -> FloatArray:
    """Return k = b / a of ellipses, minor by major semi-axis.

    Parameters
    ----------
    ratio : array_like
        A / B of the curvatures, 0 to 1.

    Returns
    -------
    ndarray
        At least 1e-12; NaN for ratios outside 0 to 1.

    Notes
    -----
    Newton's method in log k: the slope of log(A / B) is between 3/2 (circle) and 2 (strip).
    """
    from scipy.special import elliprd

    longest = np.log(1e-12)  # a longer ellipse is longer than any face width
    # Maximum Newton steps, and the step of log k below which the iteration ends.
    newton_max_steps, last_log_step = 30, 1e-15
    with np.errstate(invalid="ignore", divide="ignore"):
        wanted = np.maximum(np.log(ratio), 2.0 * longest)
        log_k = np.where(wanted <= 0.0, 0.5 * wanted, np.nan)
        for _ in range(newton_max_steps):
            square = np.exp(2.0 * log_k)
            shape = elliprd(0.0, square, 1.0) / elliprd(0.0, 1.0, square)  # A / B of this k
            slope = 2.0 - (square / shape - shape) / (1.0 - square)  # 0 / 0 for a circle
            step = (wanted - np.log(shape)) / np.clip(np.nan_to_num(slope), 1.5, 2.0)
            before, log_k = log_k, np.clip(log_k + step, longest, 0.0)
            if not np.any(np.abs(log_k - before) > last_log_step):
                break
    return np.exp(log_k)


def hertz_ellipse(curvature: ArrayLike, force: ArrayLike, modulus: float) -> HertzEllipse:
    """Return contact ellipses and pressures.

    Parameters
    ----------
    curvature : array_like, shape (..., 2)
        Principal relative curvatures, 1/mm, the smaller first.
    force : array_like, shape (...)
        Force between the bodies, N.
    modulus : float
        E*, MPa, of `contact_modulus`.

    Returns
    -------
    HertzEllipse
    """
    from scipy.special import ellipe

    least, greatest = np.moveaxis(np.asarray(curvature, dtype=float), -1, 0)
    force = np.asarray(force, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        k = axis_ratio(np.where(greatest > 0.0, least / greatest, np.nan))
        mean = 0.5 * (least + greatest)  # A + B
        major = np.cbrt(1.5 * force * ellipe(1.0 - k * k) / (np.pi * k * k * (modulus * mean)))
        axes = np.stack((major, k * major), axis=-1)
        pressure = 1.5 * force / (np.pi * axes.prod(axis=-1))
    return HertzEllipse(np.broadcast_to(force, pressure.shape), axes, pressure)


def hertz_strip(curvature: ArrayLike, line_load: ArrayLike, modulus: float) -> tuple[FloatArray, FloatArray]:
    """Return half-width (mm) and maximum pressure (MPa) of strips in which two bodies touch along a line.

    Parameters
    ----------
    curvature : array_like, shape (...)
        Relative curvature across the line, 1/mm.
    line_load : array_like, shape (...)
        Force per unit length of the line, N/mm.
    modulus : float
        E*, MPa, of `contact_modulus`.

    Returns
    -------
    half_width, pressure : array, shape (...)
        NaN where the curvature is not positive or the load is not finite.
    """
    curvature, line_load = np.asarray(curvature, dtype=float), np.asarray(line_load, dtype=float)
    known = (curvature > 0.0) & np.isfinite(line_load)
    curvature, load = np.where(known, curvature, np.nan), np.where(known, line_load, np.nan)
    pressure = np.sqrt(load * modulus * curvature / np.pi)
    return 2.0 * load / (np.pi * pressure), pressure
