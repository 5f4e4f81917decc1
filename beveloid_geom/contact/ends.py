"""Where a path of contact enters and leaves the flanks, and the way between shared out in roll.

`find_ends` finds where the first of the eight limits (root, tip, toe, heel of either member) is
met, `at_shares` the positions that share out the pinion's roll between the ends. Both work on
the polynomials of a series, whatever its parameter is.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..status import Limit, Status
from ..support.chebyshev import evaluate, inverted, polynomials, real_roots, with_derivative
from .equation import Pairing, meet, relative_margins
from .path_polynomial import HEIGHT, LARGEST, ROLL, PathSeries

SCAN = np.linspace(-1.0, 1.0, 65)
SCAN_VALUES = polynomials(SCAN, LARGEST)
STEP = 2.0 * (SCAN[1] - SCAN[0])
SHARES, CLOSE = np.linspace(0.0, 1.0, 17), np.linspace(0.0, 1.0, 65)
PASSES, NEWTON_LAST = 30, 1e-8
"""Newton on the polynomials ends with a step below NEWTON_LAST, whose square is rounding."""
BESIDE, SPARE = 0.25, 0.1
"""Flank depths, or face widths, by which rough positions are taken for ones that may be on the flanks; share
of a range of l2 that is added at both ends."""
ENDING = 1e-12
"""Share of l1 by which a position asked for may miss the end of a path."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the path enters and leaves the flanks, (cases, 2); NaN and -1 without a path.

    `x` is the parameter of the series, `limit` holds `Limit` codes. Per case: `span`, greatest
    less least pinion roll of the path (rad); `turning`, whether the roll turns back on the way; `pieces`,
    in how many the path lies on the flanks, of which the one with the greatest span is taken;
    `status`."""

    x: FloatArray
    l: FloatArray
    roll: FloatArray
    limit: NDArray[np.int8]
    span: FloatArray
    turning: NDArray[np.bool_]
    pieces: NDArray[np.int_]
    status: NDArray[np.int8]

    def cases(self, index: NDArray[np.int_]) -> Ends:
        """Give the ends of the cases `index`."""
        picked = {
            name: value[:, index] if name == "l" else value[index] for name, value in vars(self).items()
        }
        return Ends(**picked)


def longest_run(
    inside: NDArray[np.bool_],
) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
    """Give the first and the last index of the longest run of True along the last axis, and the number of
    runs; last < first where there is none."""
    index = np.arange(inside.shape[-1])
    before = np.maximum.accumulate(np.where(inside, -1, index), axis=-1)
    length = np.where(inside, index - before, 0)
    last = np.argmax(length, axis=-1)
    runs = inside[..., 0] + (inside[..., 1:] & ~inside[..., :-1]).sum(axis=-1)
    return last - length.max(axis=-1) + 1, last, runs


def find_ends(pairing: Pairing, series: PathSeries) -> Ends:
    """Give ends of the path within the window of its series; none where there is no series."""
    solved = np.flatnonzero(series.status == Status.SOLVED)
    if solved.size == series.status.size:
        return _ends(pairing, series)
    ends = no_ends(series.status)
    if solved.size:
        for name, value in vars(_ends(pairing.cases(solved), series.cases(solved))).items():
            getattr(ends, name)[(slice(None), solved) if name == "l" else solved] = value
    return ends


def no_ends(status: NDArray[np.int8]) -> Ends:
    """Give the ends of cases without a path, for the reasons `status`."""
    void = np.full((len(status), 2), np.nan)
    return Ends(
        x=void,
        l=np.array((void, void)),
        roll=void.copy(),
        limit=np.full(void.shape, np.int8(-1)),
        span=void[:, 0].copy(),
        turning=np.zeros(len(status), dtype=bool),
        pieces=np.zeros(len(status), dtype=int),
        status=status.copy(),
    )


def _ends(pairing: Pairing, series: PathSeries) -> Ends:
    """Give ends of solved paths.

    Of the margins that shrink towards the outside, the one whose zero lies furthest inside
    ends the path; Newton on that maximum changes limits by itself when another one turns
    out to be met first. The pinion drives, with rising roll on right flanks and falling roll on
    left ones: that says which end is entered."""
    x, pieces = _rough_ends(series)
    sought = pieces > 0
    inward = np.array([1.0, -1.0])
    both = with_derivative(series.coefficients[HEIGHT:])
    for _ in range(PASSES):
        values = evaluate(both, x)
        rates = values[len(Limit) :] * inward
        moves = np.where(rates > 0.0, -values[: len(Limit)] / rates, -np.inf)
        limit, move = moves.argmax(axis=0), inward * moves.max(axis=0)
        before, x = x, np.minimum(np.maximum(x + move, -1.0), 1.0)
        if not (np.abs(x - before)[sought] > NEWTON_LAST).any():
            break
    missed = ~(np.abs(move) <= NEWTON_LAST).all(axis=-1)
    status = np.where(missed, np.int8(Status.NOT_CONVERGED), np.int8(Status.SOLVED))
    status = np.where(pieces == 0, np.int8(Status.OFF_FLANK), status)
    away = status != Status.SOLVED
    x, limit = np.where(away[:, None], np.nan, x), np.where(away[:, None], -1, limit).astype(np.int8)
    values = evaluate(series.coefficients[[0, 1, ROLL]], x)
    backwards = pairing.rack.sigma * (values[2, :, 1] - values[2, :, 0]) < 0.0
    x[backwards], limit[backwards] = x[backwards, ::-1], limit[backwards, ::-1]
    values[:, backwards] = values[:, backwards, ::-1]
    span, turning = _roll_span(series, x, values[2])
    pieces = np.where(away, 0, pieces)
    return Ends(x, values[:2], values[2], limit, span, turning, pieces, status)


def _rough_ends(series: PathSeries) -> tuple[FloatArray, NDArray[np.int_]]:
    """Give starting values (cases, 2) for the ends of the path, and the number of its pieces.

    A scan of the least margin does where it crosses zero twice. Where it has several runs
    inside, or an extremum so near to zero that a crossing may hide between closer samples, too, the
    roots of all margins are taken."""
    depth = (series.coefficients[HEIGHT:] @ SCAN_VALUES[: series.coefficients.shape[-1]]).min(axis=0)
    first, last, pieces = longest_run(depth > 0.0)
    scan = np.broadcast_to(SCAN, depth.shape)
    x = np.stack((_crossing(scan, depth, first, -1), _crossing(scan, depth, last, 1)), axis=-1)
    steps = depth[:, 1:] - depth[:, :-1]
    before, after, middle = steps[:, :-1], steps[:, 1:], depth[:, 1:-1]
    near = np.abs(middle) <= np.maximum(np.abs(before), np.abs(after))
    hidden = near & np.where(middle > 0.0, (before < 0.0) & (after > 0.0), (before > 0.0) & (after < 0.0))
    row, place = np.nonzero(hidden)
    if row.size:
        fine = evaluate(series.coefficients[HEIGHT:, row], SCAN[place, None] + STEP * CLOSE).min(axis=0)
        away = np.abs(fine).min(axis=-1) > np.abs(np.diff(fine)).max(axis=-1)
        hidden[row[away], place[away]] = False
    for case in np.flatnonzero(hidden.any(axis=-1) | (pieces > 1)):
        x[case], pieces[case] = _exact_run(series.coefficients[:, case])
    return x, pieces


def _exact_run(coefficients: FloatArray) -> tuple[FloatArray, int]:
    """Give ends of the piece on the flanks with the greatest span of roll, and the number of pieces."""
    cuts = np.concatenate([real_roots(margin, -1.0, 1.0) for margin in coefficients[HEIGHT:]])
    cuts = np.concatenate(([-1.0], np.sort(cuts), [1.0]))
    between = 0.5 * (cuts[1:] + cuts[:-1])
    inside = evaluate(coefficients[HEIGHT:, None], between)[:, 0].min(axis=0) > 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0]))))
    if edges.size == 0:
        return np.zeros(2), 0
    runs, roll = cuts[edges].reshape(-1, 2), coefficients[ROLL : ROLL + 1]
    turns = real_roots(with_derivative(roll[:, None])[1, 0], -1.0, 1.0)
    spans = []
    for first, last in runs:
        reached = np.concatenate(([first], turns[(turns > first) & (turns < last)], [last]))
        spans.append(np.ptp(evaluate(roll[:, None], reached)))
    return runs[int(np.argmax(spans))], len(runs)


def _crossing(x: FloatArray, depth: FloatArray, edge: NDArray[np.int_], outward: int) -> FloatArray:
    """Say at which x (cases, samples) the depth crosses zero beside the sample `edge`, by a straight line."""
    case = np.arange(len(edge))
    beyond = np.minimum(np.maximum(edge + outward, 0), x.shape[-1] - 1)
    inside, outside = depth[case, edge], depth[case, beyond]
    share = np.where(outside < inside, inside / (inside - outside), 0.0)
    return np.asarray(x[case, edge] + share * (x[case, beyond] - x[case, edge]))


def rough_window(pairing: Pairing, l: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give bounds of l1 and l2 (2, cases, 1), mm, of contacts roughly at l (2, cases, positions), along which
    l1 rises, that seem to lie on the flanks or less than BESIDE beyond, with SPARE in l2; NaN where none
    does."""
    room = np.nan_to_num(relative_margins(pairing, l, meet(pairing, l)).min(axis=0) + BESIDE, nan=-BESIDE)
    near = room > 0.0
    first, last = near.argmax(axis=-1), near.shape[-1] - 1 - near[:, ::-1].argmax(axis=-1)
    ends = np.array([[_crossing(x, room, edge, way) for x in l] for edge, way in ((first, -1), (last, 1))])
    ends[..., ~near.any(axis=-1)] = np.nan
    low, high = np.sort(ends, axis=0)[..., None]
    spare = SPARE * (high[1] - low[1])
    low[1], high[1] = low[1] - spare, high[1] + spare
    return low, high


def _roll_span(series: PathSeries, x: FloatArray, roll: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give the pinion roll covered between the ends (cases), rad: greatest less least roll of the path, which
    is that between its ends unless it turns back on the way; and whether it does."""
    span = np.abs(roll[:, 1] - roll[:, 0])
    both = with_derivative(series.coefficients[ROLL : ROLL + 1])
    share = x[:, :1] + (x[:, 1:] - x[:, :1]) * SHARES
    rate = evaluate(both[1:], share)[0]
    low, high = rate.min(axis=-1), rate.max(axis=-1)
    turning = low * high <= 0.25 * np.maximum(np.abs(low), np.abs(high)) ** 2
    some = np.flatnonzero(turning)
    if some.size:
        turns, turning[some] = _turns(both[1, some], x[some])
        row, place = np.nonzero(~np.isnan(turns))
        reached = np.full((some.size, turns.shape[1] + 2), np.nan)
        reached[:, :2] = roll[some]
        reached[row, place + 2] = evaluate(both[:1, some[row]], turns[row, place, None])[0, :, 0]
        span[some] = np.nanmax(reached, axis=-1) - np.nanmin(reached, axis=-1)
    return span, turning


def _turns(rate: FloatArray, ends: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Say where polynomials (cases, degree + 1) change their sign between `ends` (cases, 2): (cases, steps),
    NaN in steps without; and which do.

    Between samples a polynomial strays from their chord by about an eighth of the second difference: where
    it may so reach zero and go back, its roots are sought one by one."""
    low, high = np.sort(ends, axis=-1).T[..., None]
    x = low + (high - low) * CLOSE
    value = evaluate(rate[None], x)[0]
    roots = np.full((len(x), CLOSE.size - 1), np.nan)
    row, step = np.nonzero(np.signbit(value[:, :-1]) != np.signbit(value[:, 1:]))
    at = inverted(rate[row], np.zeros((row.size, 1)), x[row, step, None], x[row, step + 1, None])
    roots[row, step] = at[:, 0]
    bend = np.abs(np.diff(value, 2, axis=-1))
    hidden = (np.abs(value[:, 1:-1]) <= bend) & np.isnan(roots[:, 1:]) & np.isnan(roots[:, :-1])
    for case in np.flatnonzero(hidden.any(axis=-1)):
        found = real_roots(rate[case], low[case, 0], high[case, 0])
        roots[case] = np.nan
        roots[case, : found.size] = found
    return roots, np.isfinite(roots).any(axis=-1)


def at_shares(series: PathSeries, ends: Ends, share: FloatArray) -> FloatArray:
    """Give series parameters x (cases, positions) at `share` in [-1, 1] of the way from enter to leave.

    The way is measured in pinion roll, inverted by Newton; on a path along which the roll
    turns back it is measured in x."""
    enter, leave, first, last = ends.x[:, :1], ends.x[:, 1:], ends.roll[:, :1], ends.roll[:, 1:]
    goal = 0.5 * ((first + last) + (last - first) * share)
    low, high = np.minimum(enter, leave), np.maximum(enter, leave)
    straight = x = 0.5 * ((enter + leave) + (leave - enter) * share)
    both = with_derivative(series.coefficients[ROLL : ROLL + 1])
    for _ in range(PASSES):
        value, rate = evaluate(both, x)
        move = np.where(ends.turning[:, None], 0.0, (goal - value) / rate)
        x = np.minimum(np.maximum(x + move, low), high)
        if not (np.abs(move) > NEWTON_LAST).any():
            break
    x = np.where(ends.turning[:, None], straight, x)
    lost = np.flatnonzero((np.abs(move) > NEWTON_LAST).any(axis=-1))
    if lost.size:
        x[lost] = inverted(series.coefficients[ROLL, lost], goal[lost], low[lost], high[lost])
    return x


def shares_at_l1(series: PathSeries, ends: Ends, l1: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give series parameters x (cases, positions) at `l1`, and where several contacts on the flanks have it.

    Where x is no function of l1, only the path on the flanks is searched; NaN beyond it."""
    x, several = (l1 - series.middle) / series.half, np.zeros(l1.shape, dtype=bool)
    for case in np.flatnonzero(np.isnan(series.half[:, 0]) & (ends.status == Status.SOLVED)):
        both, (low, high) = with_derivative(series.coefficients[:1, case, None]), np.sort(ends.x[case])
        cuts = np.concatenate(([low], real_roots(both[1, 0], low, high), [high]))
        at_cuts, given = evaluate(both[:1], cuts)[0, 0], l1[case]
        for end in at_cuts[[0, -1]]:  # rounding must not part an end from its path
            given = np.where(np.abs(given - end) <= ENDING * np.abs(both[0]).sum(), end, given)
        for k, (start, stop) in enumerate(pairwise(cuts)):
            least, most = np.sort(at_cuts[k : k + 2])
            here = (given >= least) & (given <= most)
            several[case, here] |= ~np.isnan(x[case, here])
            x[case, here] = inverted(both[0, 0], given[here], start, stop)
    return np.where(several, np.nan, x), several
