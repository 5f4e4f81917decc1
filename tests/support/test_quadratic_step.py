"""Quadratic programs in two unknowns, against a fine grid of the box."""

from __future__ import annotations

import numpy as np

from beveloid_geom.arrays import FloatArray
from beveloid_geom.support.quadratic_step import FEW, quadratic_step

LIMITS = 8
WALLS = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))[..., None]


def test_steps_are_least_within_limits_and_box() -> None:
    """Of 400 programs, convex and not, with none to many of the limits in the box: no point of 201 x 201 is
    lower, and the step is within all lines, on those it names, balanced by their multipliers."""
    rng, n = np.random.default_rng(4), 400
    slope, bend, size = rng.normal(size=(2, n)), rng.normal(size=(3, n)), rng.uniform(0.5, 2.0, (2, n))
    bend[::2] += 1.0
    rate = rng.normal(size=(LIMITS, 2, n))
    far = rng.random((LIMITS, n)) < rng.choice([0.3, 0.8, 1.0], n)
    margin = np.where(far, 10.0, rng.uniform(0.0, 1.0, (LIMITS, n)))
    lines = np.concatenate((rate, WALLS.repeat(n, axis=2))), np.concatenate((margin, size, size))
    with np.errstate(invalid="ignore", divide="ignore"):
        step, active, multiplier = quadratic_step(slope, bend, *lines, size, 1e-10)

    def value(x: FloatArray, y: FloatArray) -> FloatArray:
        a, b, c = bend
        both: FloatArray = slope[0] * x + slope[1] * y + 0.5 * (a * x * x + c * y * y) + b * x * y
        return both

    left = (lines[0] * step).sum(axis=1) + lines[1]
    assert left.min() > -1e-9
    share = np.linspace(-1.0, 1.0, 201)
    x, y = share[:, None, None] * size[0], share[:, None] * size[1]
    within = np.ones((201, 201, n), dtype=bool)
    for (p, q), m in zip(rate, margin, strict=True):
        within &= p * x + q * y + m >= 0.0
    lowest = np.where(within, value(x, y), np.inf).min(axis=(0, 1))
    found = value(*step)
    assert (found <= lowest + 1e-9).all()
    assert (found > lowest - 0.1).all()
    each = np.arange(n)
    for code in active:
        assert np.abs(left[code, each][code >= 0]).max() < 1e-9
    pull = slope + np.array((bend[0] * step[0] + bend[1] * step[1], bend[1] * step[0] + bend[2] * step[1]))
    assert np.abs(pull - (multiplier[:, None] * lines[0]).sum(axis=0)).max() < 1e-8
    assert multiplier.min() > -1e-9
    reach = (margin < (np.abs(rate) * size).sum(axis=1)).sum(axis=0)
    for case in (reach == 0, reach > FEW, (reach > 0) & (reach <= FEW), active[1] >= 0, active[0] < 0):
        assert case.any()
