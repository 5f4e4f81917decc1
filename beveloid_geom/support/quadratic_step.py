"""Least values of quadratic functions of two unknowns within limits and a box.

In two unknowns such a program is solved outright, by trying its interior, edges and corners, whatever the
sign of the curvatures. The limits are lines, of which the last are the sides of the box.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from .read_only import kept

BOX_SIDES = 4
FEW = 2
"""Limits that reach into a box at once, but for rare cases."""


def quadratic_step(
    slope: FloatArray, bend: FloatArray, rate: FloatArray, margin: FloatArray, size: FloatArray, slack: float
) -> tuple[FloatArray, Integers, FloatArray]:
    """Give the least of slope.d + d.bend.d / 2 with rate.d + margin >= 0, given `slope` (2, n), `bend` (3, n)
    by twice x, both and twice y, `rate` (lines, 2, n) and `margin` (lines, n), of which the last BOX_SIDES
    are the sides of a box of `size` (2, n): d (2, n), the lines it lies on (2, n), -1 for none, and their
    multipliers (lines, n). `slack`: by how much d may be outside."""
    a, b, c = bend
    g, h = slope
    det = a * c - b * b
    step = np.array((b * h - c * g, b * g - a * h)) / det
    active = np.full(step.shape, -1)
    free = (det > 0.0) & (a > 0.0) & ((rate * step).sum(axis=1) + margin >= 0.0).all(axis=0)
    bound = np.flatnonzero(~free)
    multiplier = np.zeros(margin.shape)
    if bound.size:
        slope, bend, rate, margin, size = (x.take(bound, axis=-1) for x in (slope, bend, rate, margin, size))
        step[:, bound], active[:, bound] = _bounded_step(slope, bend, rate, margin, size, slack)
        (a, b, c), (x, y) = bend, step[:, bound]
        pull = slope + np.array((a * x + b * y, b * x + c * y))
        multiplier[:, bound] = _multipliers(pull, rate, active[:, bound])
    return step, active, multiplier


def _bounded_step(
    slope: FloatArray, bend: FloatArray, rate: FloatArray, margin: FloatArray, size: FloatArray, slack: float
) -> tuple[FloatArray, Integers]:
    """Give the same where the least lies on a limit. Limits that do not reach into the box need not be
    tried, unless those that do leave nothing inside it."""
    count, each = len(rate) - BOX_SIDES, np.arange(slope.shape[1])
    limits = slice(count)
    far = margin[limits] > (np.abs(rate[limits]) * size).sum(axis=1) + slack
    reaching = count - far.sum(axis=0)
    lines = np.argsort(far, axis=0, kind="stable")[: min(FEW, int(reaching.max()))]
    sides = np.arange(count, len(rate))[:, None]
    lines = np.concatenate((lines, sides.repeat(each.size, axis=1)))
    rates = rate[lines, 0, each], rate[lines, 1, each]
    step, active, inside = _tried(slope, bend, rates, margin[lines, each], slack)
    active = np.where(active >= 0, lines[active, each], -1)
    every = np.flatnonzero(~inside | (reaching > FEW))
    if every.size:
        rates = rate[:, 0, every], rate[:, 1, every]
        step[:, every], active[:, every], _ = _tried(
            slope[:, every], bend[:, every], rates, margin[:, every], slack
        )
    return step, active


def _tried(
    slope: FloatArray,
    bend: FloatArray,
    rates: tuple[FloatArray, FloatArray],
    margin: FloatArray,
    slack: float,
) -> tuple[FloatArray, Integers, Mask]:
    """Give the least of a quadratic program that lies on a limit, the limits and whether it is inside all
    others, by trying all edges and corners; by components of the rates, (k, n) each."""
    (a, b, c), (g, h), (p, q) = bend, slope, rates
    foot = -margin / (p * p + q * q)
    foot_x, foot_y = foot * p, foot * q
    onto_x, onto_y = b * p - a * q, c * p - b * q
    stiff = p * onto_y - q * onto_x
    share = (p * h - q * g + onto_x * foot_x + onto_y * foot_y) / np.where(stiff > 0.0, stiff, np.nan)
    (i, j), codes = _candidates(len(p))
    cross = p[i] * q[j] - q[i] * p[j]
    x = np.concatenate((foot_x + share * q, (margin[j] * q[i] - margin[i] * q[j]) / cross))
    y = np.concatenate((foot_y - share * p, (margin[i] * p[j] - margin[j] * p[i]) / cross))
    low = x * p[0] + y * q[0] + margin[0]
    for line in zip(p[1:], q[1:], margin[1:], strict=True):
        low = np.minimum(low, x * line[0] + y * line[1] + line[2])
    value = x * (g + 0.5 * a * x + b * y) + y * (h + 0.5 * c * y)
    inside, each = low >= -slack, np.arange(x.shape[1])
    best = np.where(inside & np.isfinite(value), value, np.inf).argmin(axis=0)
    # Where the limits leave nothing inside the box, the corner least outside is next best.
    none = np.flatnonzero(~inside.any(axis=0))
    best[none] = np.where(np.isfinite(value[:, none]), low[:, none], -np.inf).argmax(axis=0)
    return np.array((x[best, each], y[best, each])), codes[:, best], np.asarray(inside[best, each])


@kept(16)
def _candidates(lines: int) -> tuple[Integers, Integers]:
    """Give the pairs (2, m) of so many lines; and which lines meet (2, lines + m) on each line, where the
    second is -1, and at each corner."""
    pairs = np.array([(i, j) for i in range(lines) for j in range(i)]).T
    return pairs, np.concatenate((np.stack((np.arange(lines), np.full(lines, -1))), pairs), axis=1)


def _multipliers(pull: FloatArray, rate: FloatArray, active: Integers) -> FloatArray:
    """Give multipliers (lines, n) that balance the slope `pull` (2, n) at the end of a step."""
    each = np.arange(active.shape[1])
    first, second = (rate[code, :, each].T for code in active)
    cross = first[0] * second[1] - first[1] * second[0]
    two, one = active[1] >= 0, (active[0] >= 0) & (active[1] < 0)
    values = np.zeros((len(rate), active.shape[1]))
    single = (pull * first).sum(axis=0) / np.maximum((first * first).sum(axis=0), 1e-300)
    with np.errstate(divide="ignore", invalid="ignore"):
        both = (
            (pull[0] * second[1] - pull[1] * second[0]) / cross,
            (first[0] * pull[1] - first[1] * pull[0]) / cross,
        )
    values[active[0][one], each[one]] = single[one]
    for code, part in zip(active, both, strict=True):
        values[code[two], each[two]] = np.where(np.isfinite(part[two]), part[two], 0.0)
    return values
