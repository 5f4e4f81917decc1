"""Quadratic programs in two unknowns: minimum of a quadratic function under linear constraints and a box.

The interior, all edges and all corners are tested, so that the result is the minimum for any sign of the
curvatures. The last four constraints are the sides of the box.

Each of n programs minimises slope.d + d.bend.d / 2 with rate.d + margin >= 0 for each constraint.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from .frozen_arrays import cached

USUAL_CONSTRAINTS = 2
"""Number of constraints, apart from the sides of the box, that are tested first. More of them rarely
intersect the box."""


def quadratic_step(
    slope: FloatArray, bend: FloatArray, rate: FloatArray, margin: FloatArray, size: FloatArray, slack: float
) -> tuple[FloatArray, Integers, FloatArray]:
    """Return the solutions of quadratic programs in two unknowns.

    Parameters
    ----------
    slope : array (2, n)
        Gradient at d = 0.
    bend : array (3, n)
        Second derivatives: xx, xy, yy.
    rate, margin : array (constraints, 2, n) and (constraints, n)
        Gradients and values of the constraints. The last four are the sides of the box.
    size : array (2, n)
        Half-widths of the box.
    slack : float
        Largest accepted violation of a constraint.

    Returns
    -------
    step : array (2, n)
        Solutions d.
    active : array (2, n) of int
        Constraints on which they lie, -1 for none.
    multiplier : array (constraints, n)
        Lagrange multipliers.
    """
    a, b, c = bend
    g, h = slope
    det = a * c - b * b
    step = np.array((b * h - c * g, b * g - a * h)) / det
    active = np.full(step.shape, -1)
    # The stationary point is the solution if the function is convex and no constraint is violated.
    free = (det > 0.0) & (a > 0.0) & ((rate * step).sum(axis=1) + margin >= 0.0).all(axis=0)
    bound = np.flatnonzero(~free)
    multiplier = np.zeros(margin.shape)
    if bound.size:
        slope, bend, rate, margin, size = (x.take(bound, axis=-1) for x in (slope, bend, rate, margin, size))
        step[:, bound], active[:, bound] = _bounded_step(slope, bend, rate, margin, size, slack)
        (a, b, c), (x, y) = bend, step[:, bound]
        gradient = slope + np.array((a * x + b * y, b * x + c * y))
        multiplier[:, bound] = _multipliers(gradient, rate, active[:, bound])
    return step, active, multiplier


def _bounded_step(
    slope: FloatArray, bend: FloatArray, rate: FloatArray, margin: FloatArray, size: FloatArray, slack: float
) -> tuple[FloatArray, Integers]:
    """Return step and active constraints of programs whose solution is on a constraint.

    Constraints that do not intersect the box are omitted. All of them are used for programs with more than
    USUAL_CONSTRAINTS that do, and for programs without a feasible point."""
    count, each = len(rate) - 4, np.arange(slope.shape[1])
    constraints = slice(count)
    far = margin[constraints] > (np.abs(rate[constraints]) * size).sum(axis=1) + slack
    reaching = count - far.sum(axis=0)
    lines = np.argsort(far, axis=0, kind="stable")[: min(USUAL_CONSTRAINTS, int(reaching.max()))]
    sides = np.arange(count, len(rate))[:, None]
    lines = np.concatenate((lines, sides.repeat(each.size, axis=1)))
    rates = rate[lines, 0, each], rate[lines, 1, each]
    step, active, inside = _boundary_minimum(slope, bend, rates, margin[lines, each], slack)
    active = np.where(active >= 0, lines[active, each], -1)
    again = np.flatnonzero(~inside | (reaching > USUAL_CONSTRAINTS))
    if again.size:
        rates = rate[:, 0, again], rate[:, 1, again]
        step[:, again], active[:, again], _ = _boundary_minimum(
            slope[:, again], bend[:, again], rates, margin[:, again], slack
        )
    return step, active


def _boundary_minimum(
    slope: FloatArray,
    bend: FloatArray,
    rates: tuple[FloatArray, FloatArray],
    margin: FloatArray,
    slack: float,
) -> tuple[FloatArray, Integers, Mask]:
    """Return the minimum on the constraints, the active ones, and whether it satisfies all others.

    The minimum on each line and all corners are compared. `rates` are the components (k, n) of the
    gradients."""
    (a, b, c), (g, h), (p, q) = bend, slope, rates
    # Minimum on each line: foot of the perpendicular from d = 0, plus a share of the direction (q, -p).
    foot = -margin / (p * p + q * q)
    foot_x, foot_y = foot * p, foot * q
    along_x, along_y = b * p - a * q, c * p - b * q
    stiffness = p * along_y - q * along_x
    share = (p * h - q * g + along_x * foot_x + along_y * foot_y) / np.where(
        stiffness > 0.0, stiffness, np.nan
    )
    # Corners: intersections of all pairs of lines.
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
    # Without a feasible point, the candidate with the smallest violation is used.
    none = np.flatnonzero(~inside.any(axis=0))
    best[none] = np.where(np.isfinite(value[:, none]), low[:, none], -np.inf).argmax(axis=0)
    return np.array((x[best, each], y[best, each])), codes[:, best], np.asarray(inside[best, each])


@cached(16)
def _candidates(lines: int) -> tuple[Integers, Integers]:
    """Return the pairs (2, m) of a number of lines, and the lines (2, lines + m) of each candidate.

    The candidates are the lines, with -1 as second line, and the corners of the pairs."""
    pairs = np.array([(i, j) for i in range(lines) for j in range(i)]).T
    return pairs, np.concatenate((np.stack((np.arange(lines), np.full(lines, -1))), pairs), axis=1)


def _multipliers(gradient: FloatArray, rate: FloatArray, active: Integers) -> FloatArray:
    """Return multipliers (constraints, n) that balance the gradient (2, n) at the solution."""
    each, on = np.arange(active.shape[1]), active >= 0
    first, second = (rate[code, :, each].T for code in active)
    # With one active constraint, the gradient has a component along it that is not balanced.
    second = np.where(on[1], second, np.array((-first[1], first[0])))
    cross = first[0] * second[1] - first[1] * second[0]
    parts = (
        gradient[0] * second[1] - gradient[1] * second[0],
        first[0] * gradient[1] - first[1] * gradient[0],
    )
    values = np.zeros((len(rate), active.shape[1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        for code, used, part in zip(active, on, np.array(parts) / cross, strict=True):
            values[code[used], each[used]] = np.where(np.isfinite(part[used]), part[used], 0.0)
    return values
