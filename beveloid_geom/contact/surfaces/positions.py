"""Exact contacts at positions along a segment of a curve of contact."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Mask
from .limits import Problem, on_plane
from .segments import SAME_CURVE, Segment
from .tangency import Condition, Contacts, PairPlacement, solve


def positions_on(problem: Problem, segment: Segment, share: FloatArray) -> tuple[Contacts, Mask]:
    """Return exact contacts (cases * positions) from enter (0) to leave (1), and whether they were solved,
    (cases, positions).

    `share` (positions,) are the fractions of the way. The way is measured in pinion roll. If the roll turns
    back, it is measured in the parameter x of the segment: s1, or the length of a traced curve.
    """
    cases, count = segment.span.size, share.size
    # At given rolls, or in planes across the curve: a given roll is a plane across its axis.
    by = np.where(segment.turning[:, None], segment.x, segment.knots[2])
    goal = by[:, :1] + (by[:, -1:] - by[:, :1]) * share
    start, direction = _interpolated(by, segment.knots, goal)
    roll = segment.state[2, :, :1] + (segment.state[2, :, 1:] - segment.state[2, :, :1]) * share
    start[2] = np.where(segment.turning[:, None], start[2], roll)
    across = np.where(
        segment.turning[:, None], direction / problem.scale[:, None, None], np.eye(3)[2][:, None, None]
    )
    start, across = start.reshape(4, -1), across.reshape(3, -1)
    reach = np.linalg.norm(direction / problem.scale[:, None, None], axis=0).ravel()
    placed = problem.placed.of_cases(np.repeat(np.arange(cases), count))
    condition = on_plane(problem, start, across)
    met, good = _solved_near(problem, placed, start, condition, reach)
    if not good.all():  # next to a kink, where the flanks nearly touch along a line, Newton's steps are long
        start = np.where(good, met.state, start)
        met, good = _solved_near(problem, placed, start, condition, reach, short_steps=True)
    if not good.all():  # next to a kink, the knots may be far from the curve
        again = _from_solved(met.state.reshape(4, cases, count), good.reshape(cases, count), share)
        met, good = _solved_near(problem, placed, again.reshape(4, -1), condition, reach)
    return met, good.reshape(cases, count)


def _solved_near(
    problem: Problem,
    placed: PairPlacement,
    start: FloatArray,
    condition: Condition,
    reach: FloatArray,
    short_steps: bool = False,
) -> tuple[Contacts, Mask]:
    """Return the result of `solve`. Contacts farther from their starting values than `reach` (n,), in the
    units of `Problem.scale`, are not solved: they are on another curve than the segment. With `short_steps`,
    no step of Newton's method is longer either."""
    reach = np.maximum(reach, SAME_CURVE)
    met, good = solve(problem.surfaces, placed, start, condition, reach if short_steps else None)
    moved = (met.state - start)[:3] / problem.scale[:, None]
    good &= np.linalg.norm(moved, axis=0) <= reach
    met.state[:, ~good] = np.nan
    return met, good


def _from_solved(state: FloatArray, good: Mask, share: FloatArray) -> FloatArray:
    """Return states (4, cases, positions), those that are not `good` between their solved neighbours; NaN
    where there are none."""
    result = state.copy()
    for case in np.flatnonzero(~good.all(axis=-1) & good.any(axis=-1)):
        order = np.argsort(share[good[case]])
        known = state[:, case, good[case]][:, order]
        wanted = share[~good[case]]
        result[:, case, ~good[case]] = [
            np.interp(wanted, share[good[case]][order], row, np.nan, np.nan) for row in known
        ]
    return result


def _interpolated(by: FloatArray, knots: FloatArray, goal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values (4, cases, positions) of the knots at `goal` of the monotone `by` (cases, m), by linear
    interpolation, and the direction (3, cases, positions) of the interval.
    """
    rising = np.where(by[:, -1:] >= by[:, :1], 1.0, -1.0)
    ordered, wanted = by * rising, goal * rising
    place = (ordered[:, None, :] < wanted[:, :, None]).sum(axis=-1)
    # The first and the last knot are repeated; an interval between equal knots has no direction.
    least = (ordered <= ordered[:, :1]).sum(axis=-1, keepdims=True)
    most = (ordered < ordered[:, -1:]).sum(axis=-1, keepdims=True)
    place = np.maximum(np.minimum(np.maximum(place, least), most), 1)
    low, high = (np.take_along_axis(ordered, place - k, axis=1) for k in (1, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(high > low, (wanted - low) / (high - low), 0.0)
    first, second = (
        np.stack([np.take_along_axis(values, place - k, axis=1) for values in knots]) for k in (1, 0)
    )
    return first + share * (second - first), (second - first)[:3]
