"""Quadratic programs in two unknowns, against a fine grid of the box."""

from __future__ import annotations

import numpy as np

from beveloid_geom.arrays import FloatArray
from beveloid_geom.support.qp2 import USUAL_CONSTRAINTS, quadratic_step

CONSTRAINTS = 8
BOX = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))[..., None]


def test_steps_are_minima_under_the_constraints() -> None:
    """400 programs, convex or not, with no, few or many constraints that intersect the box.

    No point of a grid of 201 x 201 is lower. The step satisfies all constraints, lies on the active ones, and
    the multipliers balance the gradient."""
    rng, n = np.random.default_rng(4), 400
    slope, bend, size = rng.normal(size=(2, n)), rng.normal(size=(3, n)), rng.uniform(0.5, 2.0, (2, n))
    bend[::2] += 1.0
    rate = rng.normal(size=(CONSTRAINTS, 2, n))
    far = rng.random((CONSTRAINTS, n)) < rng.choice([0.3, 0.8, 1.0], n)
    margin = np.where(far, 10.0, rng.uniform(0.0, 1.0, (CONSTRAINTS, n)))
    lines = np.concatenate((rate, BOX.repeat(n, axis=2))), np.concatenate((margin, size, size))
    with np.errstate(invalid="ignore", divide="ignore"):
        step, active, multiplier = quadratic_step(slope, bend, *lines, size, 1e-10)

    def value(x: FloatArray, y: FloatArray) -> FloatArray:
        a, b, c = bend
        both: FloatArray = slope[0] * x + slope[1] * y + 0.5 * (a * x * x + c * y * y) + b * x * y
        return both

    slack = (lines[0] * step).sum(axis=1) + lines[1]
    assert slack.min() > -1e-9
    share = np.linspace(-1.0, 1.0, 201)
    x, y = share[:, None, None] * size[0], share[:, None] * size[1]
    within = np.ones((201, 201, n), dtype=bool)
    for (p, q), m in zip(rate, margin, strict=True):
        within &= p * x + q * y + m >= 0.0
    lowest = np.where(within, value(x, y), np.inf).min(axis=(0, 1))
    minimum = value(*step)
    assert (minimum <= lowest + 1e-9).all()
    assert (minimum > lowest - 0.1).all()
    each = np.arange(n)
    for code in active:
        assert np.abs(slack[code, each][code >= 0]).max() < 1e-9
    gradient = slope + np.array(
        (bend[0] * step[0] + bend[1] * step[1], bend[1] * step[0] + bend[2] * step[1])
    )
    assert np.abs(gradient - (multiplier[:, None] * lines[0]).sum(axis=0)).max() < 1e-8
    assert multiplier.min() > -1e-9
    reach = (margin < (np.abs(rate) * size).sum(axis=1)).sum(axis=0)
    for case in (
        reach == 0,
        reach > USUAL_CONSTRAINTS,
        (reach > 0) & (reach <= USUAL_CONSTRAINTS),
        active[1] >= 0,
        active[0] < 0,
    ):
        assert case.any()
