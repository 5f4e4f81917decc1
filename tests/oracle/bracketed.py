"""Roots of many functions at once between bounds. It shares no code with the package."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEPS, EPSILON = 54, 2.0**-48
"""Largest number of steps, and relative width of a bracket at the end."""


def roots_between(f: Callable[[Array], Array], low: Array, high: Array, noise: Array) -> Array:
    """Return roots by bisection and inverse quadratic interpolation (Chandrupatla 1997), NaN where `f` is not
    negative at `low` and positive at `high`. Values up to `noise` count as zero."""
    a, b = high, low
    fa, fb, share = f(a), f(b), np.full_like(high, 0.5)
    known = (fb <= 0.0) & (fa >= 0.0)
    for _ in range(STEPS if known.any() else 0):
        at = a + share * (b - a)
        here = f(at)
        same = np.sign(here) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(same, b, a), np.where(same, fb, fa)
        a, fa = at, here
        least = EPSILON * np.maximum(np.abs(a), np.abs(b))
        if (~known | (np.abs(fa) <= noise) | (np.abs(b - a) <= 2.0 * least)).all():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            place, level = (a - b) / (c - b), (fa - fb) / (fc - fb)
            inverse = fa / (fb - fa) * fc / (fb - fc)
            inverse = inverse + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
            smooth = (level**2 < place) & ((1.0 - level) ** 2 < 1.0 - place)
            edge = np.minimum(least / np.abs(b - a), 0.5)
        share = np.clip(np.where(smooth, inverse, 0.5), edge, 1.0 - edge)
    return np.where(known, np.where(np.abs(fb) < np.abs(fa), b, a), np.nan)
