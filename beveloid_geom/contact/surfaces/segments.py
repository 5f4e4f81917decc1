"""The part of a curve of contact that is on both flanks, and its exact ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import Status
from .curve import MARGINS, STATE, Curve, broken, dense
from .limits import Problem, least_limit, least_margin, on_plane
from .tangency import Contacts, solve

SAME_CURVE = 0.02
"""Distance in the units of `Problem.scale` within which a contact is on the curve of its starting values."""


@dataclass(frozen=True, eq=False)
class Segment:
    """The segment with the largest range of roll, for each case; NaN and -1 without one.

    `state` (4, cases, 2): s1, z1, pinion roll and s2 at enter and leave; `limit` (cases, 2); `span` (cases,):
    range of roll, rad; `turning`: whether the roll turns back; `pieces`: number of segments on the flanks;
    `status`. `knots` (4, cases, m) are approximate states from enter to leave at the parameters `x` (cases,
    m) of the curve; the first and the last are repeated.
    """

    state: FloatArray
    limit: Codes
    span: FloatArray
    turning: Mask
    pieces: Integers
    status: Codes
    x: FloatArray
    knots: FloatArray


def _runs(inside: Mask, known: Mask) -> tuple[Integers, Integers, Mask]:
    """Return the first and last index of each run of samples of one case that are `inside` the limits, and
    whether the neighbours of the run are `known`."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0])).astype(int)))
    first, last = edges[::2], edges[1::2] - 1
    size = inside.size
    closed = (first > 0) & (last < size - 1)
    closed &= known[np.maximum(first - 1, 0)] & known[np.minimum(last + 1, size - 1)]
    return first, last, closed


def segments_of(problem: Problem, curve: Curve) -> tuple[Segment, Mask]:
    """Return the segments of curves on the flanks, and which cases (cases,) the samples decide.

    A case is not decided if a sample next to the segment is missing, if the curve is not smooth, or if an end
    was not found where the samples show it.
    """
    x, rows = dense(problem, curve)
    cases, count = x.shape
    depth = rows[MARGINS].min(axis=0)
    known, inside = np.isfinite(depth), depth >= 0.0
    gaps = broken(problem, curve)
    # One run in each case; several runs, and cases without a run, below.
    first, last = inside.argmax(axis=-1), count - 1 - inside[:, ::-1].argmax(axis=-1)
    pieces = inside[:, 0] + (inside[:, 1:] & ~inside[:, :-1]).sum(axis=-1)
    step, row = (count - 1) // gaps.shape[1], np.arange(cases)
    decided = (pieces == 1) & (first > 0) & (last < count - 1)
    decided &= known[row, np.maximum(first - 1, 0)] & known[row, np.minimum(last + 1, count - 1)]
    broken_before = np.concatenate((np.zeros((cases, 1), dtype=int), gaps.cumsum(axis=-1)), axis=-1)
    from_gap, to_gap = np.maximum(first - 1, 0) // step, (last + step) // step
    decided &= broken_before[row, np.minimum(to_gap, gaps.shape[1])] == broken_before[row, from_gap]
    for case in np.flatnonzero(pieces != 1):
        begin, end, closed = _runs(inside[case], known[case])
        if not begin.size:
            decided[case] = known[case].all() and not gaps[case].any()
            continue
        spans = [np.ptp(rows[2, case, a : b + 1]) for a, b in zip(begin, end, strict=True)]
        best = int(np.argmax(spans))
        first[case], last[case] = begin[best], end[best]
        near = slice(max(0, (begin[best] - 1) // step), (end[best] + step) // step)
        decided[case] = bool(closed.all()) and not gaps[case, near].any()
    active_cases = np.flatnonzero(decided & (pieces > 0))
    segment = empty_segment(cases, count)
    segment.status[~decided] = Status.NOT_CONVERGED
    if active_cases.size:
        good = _with_ends(problem, (x, rows, depth), np.stack((first, last)), segment, active_cases)
        decided[active_cases[~good]] = False
        segment.pieces[active_cases] = pieces[active_cases]
    return segment, decided


def empty_segment(cases: int, count: int) -> Segment:
    """Return segments of cases without a path on the flanks, with space for knots from `count` samples."""
    return Segment(
        state=np.full((4, cases, 2), np.nan),
        limit=np.full((cases, 2), np.int8(-1)),
        span=np.full(cases, np.nan),
        turning=np.zeros(cases, dtype=bool),
        pieces=np.zeros(cases, dtype=int),
        status=np.full(cases, np.int8(Status.OFF_FLANK)),
        x=np.full((cases, count + 2), np.nan),
        knots=np.full((4, cases, count + 2), np.nan),
    )


def _with_ends(
    problem: Problem,
    samples: tuple[FloatArray, FloatArray, FloatArray],
    runs: Integers,
    segment: Segment,
    active_cases: Integers,
) -> Mask:
    """Fill a segment for the `active_cases`, and return for which of them both ends were found.

    `runs` (2, cases) are the first and last sample inside the flanks."""
    part = problem.cases(np.tile(active_cases, 2))  # the first ends of all cases, followed by the last ones
    x, rows, depth = (values[..., active_cases, :] for values in samples)
    met, where, limits, good = _ends_of(part, x, rows[STATE], depth, runs[:, active_cases])
    places, knots = _end_to_end(x, rows[STATE], runs[:, active_cases], where, met.state)
    turning = _turns(knots[2])
    # Interpolated knots next to the beginning of a relief may be off the curve.
    if (doubtful := np.flatnonzero(turning & good)).size:
        knots[:, doubtful] = _solved_knots(part.cases(doubtful), knots[:, doubtful])[0]
        turning[doubtful] = _turns(knots[2, doubtful])
    span = np.abs(knots[2, :, -1] - knots[2, :, 0])  # interpolated knots may be beyond an end
    # Direction of the roll at both ends, along the segment.
    scale = problem.scale[:, None]
    chord = (knots[:3, :, -1] - knots[:3, :, 0]) / scale
    tangent = (met.tangent / scale).reshape(3, 2, -1)
    tangent = tangent * np.sign((tangent * chord[:, None]).sum(axis=0))
    turning |= (tangent[2] * chord[2] < 0.0).any(axis=0)
    for case in np.flatnonzero(turning & good):
        span[case] = _turned_span(part.cases(np.array([case])), knots[:, case])
    # The pinion drives: the roll rises on right flanks and falls on left flanks.
    backwards = part.surfaces.pinion.sigma * (knots[2, :, -1] - knots[2, :, 0]) < 0.0
    knots[:, backwards], places[backwards] = knots[:, backwards, ::-1], places[backwards, ::-1]
    limits[backwards] = limits[backwards, ::-1]
    done = active_cases[good]
    segment.status[active_cases] = np.where(good, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
    segment.state[:, done] = knots[:, good][:, :, [0, -1]]
    segment.limit[done], segment.span[done], segment.turning[done] = limits[good], span[good], turning[good]
    segment.x[done], segment.knots[:, done] = places[good], knots[:, good]
    return good


def _ends_of(
    part: Problem, x: FloatArray, states: FloatArray, depth: FloatArray, runs: Integers
) -> tuple[Contacts, FloatArray, Codes, Mask]:
    """Solve for both ends of a run of samples inside the flanks.

    Parameters
    ----------
    part : Problem
        Of the first ends (n), followed by the last ends (n).
    x, states, depth : ndarray, shape (n, m), (4, n, m), (n, m)
        Places along the curve, states and smallest margins (mm) of the samples.
    runs : ndarray of int, shape (2, n)
        First and last sample inside.

    Returns
    -------
    met : Contacts
        Contacts at the ends (2 n).
    where : ndarray, shape (2, n)
        Estimated places of the ends.
    limits : ndarray of int, shape (n, 2)
        Limits on which they lie.
    good : ndarray of bool, shape (n)
        Whether both ends were found.
    """
    # Distance from a limit up to which a position is at this limit.
    end_tolerance_mm = 1e-9
    row, inner = np.tile(np.arange(runs.shape[1]), 2), runs.ravel()
    outer = np.concatenate((runs[0] - 1, runs[1] + 1))
    within, beyond = depth[row, inner], depth[row, outer]
    share = within / (within - beyond)
    bracket = states[:, row, outer] - states[:, row, inner]
    start = states[:, row, inner] + share * bracket
    where = x[row, inner] + share * (x[row, outer] - x[row, inner])
    met, good = solve(part.surfaces, part.placed, start, least_limit(part))
    # The end lies between the samples that show it.
    scale = part.scale[:, None]
    moved = np.linalg.norm((met.state[:3] - start[:3]) / scale, axis=0)
    good &= moved <= 2.0 * np.linalg.norm(bracket[:3] / scale, axis=0) + 1e-6
    value, _, limit = least_margin(part, met)
    good = np.asarray((good & (np.abs(value) <= end_tolerance_mm)).reshape(2, -1).all(axis=0))
    return met, where.reshape(2, -1), limit.astype(np.int8).reshape(2, -1).T, good


def _end_to_end(
    x: FloatArray, states: FloatArray, runs: Integers, where: FloatArray, ends: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return places (n, m + 2) and states (4, n, m + 2) of samples, with those outside of `runs` replaced by
    the `ends` (4, 2 n) at `where` (2, n)."""
    order = np.arange(x.shape[1] + 2)[None] - 1
    at = np.clip(order, 0, x.shape[1] - 1)
    places = np.take_along_axis(x, at, axis=1)
    knots = np.stack([np.take_along_axis(values, at, axis=1) for values in states])
    outside = (order < runs[0][:, None]), (order > runs[1][:, None])
    for which, place, state in zip(outside, where, ends.reshape(4, 2, -1).swapaxes(0, 1), strict=True):
        places = np.where(which, place[:, None], places)
        knots = np.where(which, state[:, :, None], knots)
    return places, knots


def _turns(roll: FloatArray) -> Mask:
    """Return whether the roll of knots (..., m) turns back. Knots are interpolated, so that one next to an
    end may be slightly beyond it."""
    steps = np.diff(roll)
    # Step of the roll between samples, relative to the largest, below which its sign is not significant.
    roll_misfit = 1e-2
    least = roll_misfit * np.abs(steps).max(axis=-1, keepdims=True)
    return np.asarray((steps > least).any(axis=-1) & (steps < -least).any(axis=-1))


def _solved_knots(problem: Problem, knots: FloatArray) -> tuple[FloatArray, Mask]:
    """Return exact contacts in planes across the segment, near approximate states (4, cases, m).

    The mask (cases, m) states whether each is within half an interval, and SAME_CURVE, of its approximation.

    Contacts beyond an end become this end. The ends themselves are not solved."""
    scale, (_, cases, count) = problem.scale[:, None], knots.shape
    steps = np.diff(knots[:3]) / scale[..., None]
    apart = (steps != 0.0).any(axis=0)  # the ends are repeated
    case, inner = np.nonzero(apart[:, 1:] & apart[:, :-1])
    inner += 1
    start, placed = knots[:, case, inner], problem.placed.of_cases(case)
    across = (knots[:3, case, inner + 1] - knots[:3, case, inner - 1]) / scale
    length = np.linalg.norm(across, axis=0)
    met, good = solve(problem.surfaces, placed, start, on_plane(problem, start, across / length))
    result, near = knots.copy(), np.ones((cases, count), dtype=bool)
    result[:, case[good], inner[good]] = met.state[:, good]
    away = np.linalg.norm((met.state - start)[:3] / scale, axis=0)
    near[case, inner] = good & (away <= np.minimum(0.25 * length, SAME_CURVE))
    beyond = good & (least_margin(problem, met)[0] < 0.0)
    case, inner = case[beyond], inner[beyond]
    first, last = knots[:, case, 0], knots[:, case, -1]
    to_first, to_last = (
        np.linalg.norm((start[:, beyond] - end)[:3] / scale, axis=0) for end in (first, last)
    )
    result[:, case, inner] = np.where(to_first < to_last, first, last)
    return result, near


def refined(problem: Problem, segment: Segment) -> Mask:
    """Replace the knots of segments by exact contacts, and return for which cases (cases,) these are close to
    the interpolated ones.

    Otherwise the samples may belong to several curves, as on measured flanks with scatter."""
    # Step of the roll (rad) that is rounding.
    rounding_rad = 1e-12
    result: Mask = np.asarray(segment.status != Status.SOLVED)
    solved_cases = np.flatnonzero(~result)
    if solved_cases.size:
        knots, near = _solved_knots(problem.cases(solved_cases), segment.knots[:, solved_cases])
        result[solved_cases], segment.knots[:, solved_cases] = near.all(axis=-1), knots
        steps = np.diff(knots[2])
        turns = (steps > rounding_rad).any(axis=-1) & (steps < -rounding_rad).any(axis=-1)
        for case in solved_cases[turns & ~segment.turning[solved_cases]]:
            segment.turning[case] = True
            segment.span[case] = _turned_span(problem.cases(np.array([case])), segment.knots[:, case])
    return result


def _turned_span(problem: Problem, knots: FloatArray) -> float:
    """Return the range of roll (rad) along approximate states (4, m) of a single case whose roll turns back.

    The extrema of the roll are refined by secants of its rate along the curve.
    """
    # Secant steps to a place where the roll turns back.
    turn_steps = 3
    values = [knots[2, 0], knots[2, -1]]
    for pick in (np.argmin, np.argmax):
        k = int(pick(knots[2]))
        low, high = max(k - 1, 0), min(k + 1, knots.shape[1] - 1)
        chord = (knots[:3, high] - knots[:3, low]) / problem.scale
        size = float(np.linalg.norm(chord))
        if size == 0.0:
            continue
        direction = (chord / size)[:, None]

        def rate_at(start: FloatArray, direction: FloatArray = direction) -> tuple[FloatArray, float, float]:
            """Return the contact in the plane through a state, its roll rate and its roll."""
            met, _ = solve(problem.surfaces, problem.placed, start, on_plane(problem, start, direction))
            tangent = met.tangent[:, 0] / problem.scale
            tangent *= np.sign(tangent @ direction[:, 0]) / np.linalg.norm(tangent)
            return met.state, float(tangent[2]), float(met.state[2, 0])

        shares, rates, start = [0.0, 0.25 * size], [], knots[:, k : k + 1]
        for share in shares:
            moved = start.copy()
            moved[:3, 0] += share * direction[:, 0] * problem.scale
            rates.append(rate_at(moved)[1])
        for _ in range(turn_steps):
            if rates[-1] == rates[-2]:
                break
            share = shares[-1] - rates[-1] * (shares[-1] - shares[-2]) / (rates[-1] - rates[-2])
            share = float(np.clip(share, -2.0 * size, 2.0 * size))
            moved = start.copy()
            moved[:3, 0] += share * direction[:, 0] * problem.scale
            _, rate, roll = rate_at(moved)
            shares.append(share)
            rates.append(rate)
            if np.isfinite(roll) and -1e-12 <= (share + size) / (2.0 * size) <= 1.0 + 1e-12:
                values.append(roll)
    return float(np.ptp(values))
