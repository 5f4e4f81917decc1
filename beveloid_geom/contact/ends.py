"""Where a path of contact enters and leaves the flanks.

`find_ends` computes where the path meets the first of the eight limits (root, tip, toe, heel of both
members), from the polynomials of a series with any parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..status import Limit, Status
from ..support.chebyshev import evaluate, inverted, polynomials, real_roots, with_derivative
from ..support.products import product
from .equation import edge_margins, meet, relative_margins
from .flank_pair import FlankPair
from .path_polynomial import MAX_DEGREE, ROLL, ROW_COUNT, PathSeries

SCAN_POSITIONS = np.linspace(-1.0, 1.0, 65)
SCAN_VALUES = polynomials(SCAN_POSITIONS, MAX_DEGREE)
FINE_POSITIONS = np.linspace(0.0, 1.0, 65)
HALLEY_MAX_STEPS, LAST_HALLEY_STEP = 30, 1e-6
"""Maximum steps of Halley's method on the polynomials, and the step that ends it: its cube is below rounding.
"""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the path enters and leaves the flanks, (cases, 2); NaN and -1 without a path.

    `x` is the parameter of the series, `l` (2, cases, 2) are l1 and l2 (mm), `roll` is the pinion roll (rad),
    and `limit` has codes of `Limit`. Per case: `span`, the range of pinion roll of the path (rad); `turning`,
    whether the roll turns back; `pieces`, the number of segments on the flanks, of which the one with the
    largest span is used; `status`.
    """

    x: FloatArray
    l: FloatArray
    roll: FloatArray
    limit: Codes
    span: FloatArray
    turning: Mask
    pieces: Integers
    status: Codes

    def cases(self, index: Integers) -> Ends:
        """Return the ends of the cases `index`."""
        picked = {
            name: value[:, index] if name == "l" else value[index] for name, value in vars(self).items()
        }
        return Ends(**picked)

    def put(self, index: Integers, ends: Ends) -> None:
        """Overwrite the ends of the cases `index`."""
        for name, value in vars(ends).items():
            getattr(self, name)[(slice(None), index) if name == "l" else index] = value


def find_ends(pairing: FlankPair, series: PathSeries) -> Ends:
    """Return the ends of the path within the window of its series; none if there is no series."""
    solved = np.flatnonzero(series.status == Status.SOLVED)
    if solved.size == series.status.size:
        return _trimmed_ends(pairing, series)
    ends = no_ends(series.status)
    if solved.size:
        ends.put(solved, _trimmed_ends(pairing.cases(solved), series.cases(solved)))
    return ends


def no_ends(status: Codes) -> Ends:
    """Return the ends of cases without a path, with the reasons `status`."""
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


def _trimmed_ends(pairing: FlankPair, series: PathSeries) -> Ends:
    """Return the ends of solved paths, also where undercut ends the flanks."""
    ends = _ends(pairing, series, *_rough_ends(series))
    if pairing.edges:
        several = np.flatnonzero(ends.pieces > 1)
        ends = _before_edges(pairing, series, ends)
        # Undercut can shorten the segment with the largest range of roll below that of another segment.
        for case in several:
            one = np.array([case])
            part, single = pairing.cases(one), series.cases(one)
            runs, _ = _exact_runs(single.coefficients[:, 0])
            for run in runs:
                other = _before_edges(part, single, _ends(part, single, run[None], np.array([len(runs)])))
                if other.span[0] > np.nan_to_num(ends.span[case]):
                    ends.put(one, other)
        endless = np.flatnonzero((np.abs(ends.x) == 1.0).any(axis=-1))  # no limit within the series
        ends.put(endless, no_ends(np.full(endless.size, Status.NOT_CONVERGED, dtype=np.int8)))
    return ends


def _longest_run(inside: Mask) -> tuple[Integers, Integers, Integers]:
    """Return the first and the last index of the longest run of True in each row, and the number of runs."""
    index = np.arange(inside.shape[-1])
    before = np.maximum.accumulate(np.where(inside, -1, index), axis=-1)
    length = np.where(inside, index - before, 0)
    last = np.argmax(length, axis=-1)
    runs = inside[..., 0] + (inside[..., 1:] & ~inside[..., :-1]).sum(axis=-1)
    return last - length.max(axis=-1) + 1, last, runs


def _before_edges(pairing: FlankPair, series: PathSeries, ends: Ends) -> Ends:
    """Return the ends of paths, shortened where undercut ends them earlier.

    The part above the edges of both flanks with the largest range of roll is used. The edges are not
    polynomials of the path, so that crossings are sampled and then bisected.
    """
    low, high = np.sort(ends.x, axis=-1).T[..., None]
    x = low + (high - low) * FINE_POSITIONS
    depth = _edge_depths(pairing, series.coefficients, x).min(axis=0)
    cut = np.flatnonzero(((depth < 0.0).any(axis=-1)) & (ends.status == Status.SOLVED))
    if not cut.size:
        return ends
    # Longest run of samples above both edges. If there are several, their ranges of roll are compared.
    above = depth[cut] >= 0.0
    first, last, pieces = _longest_run(above)
    shortened = _cut_to_run(pairing.cases(cut), series.cases(cut), ends.cases(cut), x[cut], first, last)
    for place in np.flatnonzero(pieces > 1):
        one = cut[place, None]
        case = pairing.cases(one), series.cases(one), ends.cases(one), x[one]
        changes = np.flatnonzero(np.diff(above[place], prepend=False, append=False))
        runs = changes.reshape(-1, 2, 1)
        for start, stop in runs[runs[:, 0, 0] != first[place]]:
            part = _cut_to_run(*case, start, stop - 1)
            if part.span[0] > shortened.span[place]:
                shortened.put(np.array([place]), part)
    shortened.pieces[:] += pieces - 1
    gone = np.flatnonzero(pieces == 0)
    shortened.put(gone, no_ends(np.full(gone.size, np.int8(Status.OFF_FLANK))))
    ends.put(cut, shortened)
    return ends


def _edge_depths(pairing: FlankPair, coefficients: FloatArray, x: FloatArray) -> FloatArray:
    """Return the distance (2, cases, positions), mm, of contacts at x above the edges of both flanks."""
    # Rows of a series from which z of a contact on both members follows.
    toe_rows = ROW_COUNT + Limit.PINION_TOE, ROW_COUNT + Limit.GEAR_TOE
    values = evaluate(coefficients[[0, 1, *toe_rows]], x)
    return edge_margins(pairing, values[:2], values[2:] - pairing.half_width)


def _cut_to_run(
    pairing: FlankPair, series: PathSeries, ends: Ends, x: FloatArray, first: Integers, last: Integers
) -> Ends:
    """Return the ends of the parts of paths in which the samples x (cases, samples) from `first` to `last`
    (cases) are above the edges of undercut, refined by bisection; NaN if `first` exceeds `last`.
    """
    # Bisection steps for the point at which a path meets an edge of undercut.
    edge_bisections = 55
    row, limit = np.arange(len(x)), ends.limit.copy()
    result = np.empty((len(x), 2))
    swapped = ends.x[:, 0] > ends.x[:, 1]
    for end, (place, sense) in enumerate(((first, -1), (last, 1))):
        beyond = np.clip(place + sense, 0, FINE_POSITIONS.size - 1)
        good, bad = x[row, place], x[row, beyond]
        for _ in range(edge_bisections):
            middle = 0.5 * (good + bad)
            margins = _edge_depths(pairing, series.coefficients, middle[:, None])[..., 0]
            holds = margins.min(axis=0) >= 0.0
            good, bad = np.where(holds, middle, good), np.where(holds, bad, middle)
        result[:, end] = good
        side = np.where(swapped, 1 - end, end)
        moved = beyond != place
        limit[row[moved], side[moved]] = margins.argmin(axis=0)[moved]
    # Restore the order of entering and leaving.
    result[swapped] = result[swapped, ::-1]
    result[first > last] = np.nan
    l1, l2, roll = evaluate(series.coefficients[[0, 1, ROLL]], result)
    span, turning = _roll_span(series, result, roll)
    return Ends(
        result, np.array((l1, l2)), roll, limit, span, turning, ends.pieces.copy(), ends.status.copy()
    )


def _ends(pairing: FlankPair, series: PathSeries, x: FloatArray, pieces: Integers) -> Ends:
    """Return the ends of solved paths near the starting values x (cases, 2), and their numbers of `pieces`.

    Among the margins that decrease towards the outside, the one whose zero is furthest inside ends the path.
    This margin is selected again in each step of Halley's method, so that the limit changes if another one is
    met first. The pinion drives, with
    increasing roll on right flanks and decreasing roll on left flanks; this decides which end is entered.
    """
    inward = np.array([1.0, -1.0])
    margins = with_derivative(series.coefficients[ROW_COUNT:], 2)
    for _ in range(HALLEY_MAX_STEPS):
        value, rate, bend = evaluate(margins, x).reshape(3, len(Limit), *x.shape)
        # Step to the zero of each margin; the largest inward step belongs to the limiting one.
        moves = halley_step(value, rate, bend) * inward
        moves[~(rate * inward > 0.0)] = -np.inf
        limit, move = moves.argmax(axis=0), inward * moves.max(axis=0)
        before, x = x, np.minimum(np.maximum(x + move, -1.0), 1.0)
        far = np.abs(x - before) > LAST_HALLEY_STEP
        if not far.any() or not far[pieces > 0].any():
            break
    status = np.zeros(len(x), dtype=np.int8)
    settled = np.abs(move) <= LAST_HALLEY_STEP
    if pairing.edges:  # undercut may end the path within the series, before any of these limits
        settled |= (np.abs(x) == 1.0) & (evaluate(margins[: len(Limit)], x).min(axis=0) > 0.0)
    status[~settled.all(axis=-1)] = Status.NOT_CONVERGED
    status[pieces == 0] = Status.OFF_FLANK
    limit = limit.astype(np.int8)
    if status.any():
        away = status.astype(bool)
        x[away], limit[away], pieces[away] = np.nan, -1, 0
    l1, l2, roll = evaluate(series.coefficients[[0, 1, ROLL]], x)
    # Exchange the ends if the driving sense enters at the other one.
    backwards = pairing.rack.sigma * (roll[:, 1] - roll[:, 0]) < 0.0
    if backwards.any():
        for ends in (x, limit, l1, l2, roll):
            ends[backwards] = ends[backwards, ::-1]
    span, turning = _roll_span(series, x, roll)
    return Ends(x, np.array((l1, l2)), roll, limit, span, turning, pieces, status)


def halley_step(value: FloatArray, rate: FloatArray, bend: FloatArray) -> FloatArray:
    """Return the step of Halley's method towards a zero of functions with these values and derivatives. Far
    from a zero it is at most twice the Newton step, and never in the opposite direction.
    """
    newton = value / rate
    return -newton / np.maximum(1.0 - 0.5 * newton * bend / rate, 0.5)


def _rough_ends(series: PathSeries) -> tuple[FloatArray, Integers]:
    """Return starting values (cases, 2) for the ends of the path, and the number of its segments.

    A scan of the least margin suffices if it crosses zero twice. If it has several runs inside, or an
    extremum so near to zero that finer samples may still hide a crossing, the roots of all margins are
    computed.
    """
    depth = product(series.coefficients[ROW_COUNT:], SCAN_VALUES[: series.coefficients.shape[-1]]).min(axis=0)
    # Sign changes of the least margin on the scan.
    inside = depth > 0.0
    pieces = inside[:, 0] + (inside[:, 1:] & ~inside[:, :-1]).sum(axis=-1)
    edge = np.stack(
        (inside.argmax(axis=-1), len(SCAN_POSITIONS) - 1 - inside[:, ::-1].argmax(axis=-1)), axis=-1
    )
    x = _crossing(np.broadcast_to(SCAN_POSITIONS, depth.shape), depth, edge)
    # Extrema near zero may hide a crossing between samples.
    steps = depth[:, 1:] - depth[:, :-1]
    before, after, middle = steps[:, :-1], steps[:, 1:], depth[:, 1:-1]
    hidden = (before * middle < 0.0) & (after * middle > 0.0)
    if hidden.any():
        hidden &= np.abs(middle) <= np.maximum(np.abs(before), np.abs(after))
    row, place = np.nonzero(hidden)
    fine_scan_width = 2.0 * (SCAN_POSITIONS[1] - SCAN_POSITIONS[0])
    if row.size:
        fine = evaluate(
            series.coefficients[ROW_COUNT:, row],
            SCAN_POSITIONS[place, None] + fine_scan_width * FINE_POSITIONS,
        ).min(axis=0)
        away = np.abs(fine).min(axis=-1) > np.abs(np.diff(fine)).max(axis=-1)
        hidden[row[away], place[away]] = False
    several = (pieces > 1) | hidden.any(axis=-1)
    for case in np.flatnonzero(several) if several.any() else ():
        runs, spans = _exact_runs(series.coefficients[:, case])
        x[case], pieces[case] = runs[np.argmax(spans)] if len(runs) else 0.0, len(runs)
    return x, pieces


def _exact_runs(coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends (segments, 2) of all segments on the flanks, and their ranges of roll, rad."""
    # The roots of all margins divide the series into segments inside and outside.
    cuts = np.concatenate([real_roots(margin, -1.0, 1.0) for margin in coefficients[ROW_COUNT:]])
    cuts = np.concatenate(([-1.0], np.sort(cuts), [1.0]))
    between = 0.5 * (cuts[1:] + cuts[:-1])
    inside = evaluate(coefficients[ROW_COUNT:, None], between)[:, 0].min(axis=0) > 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0]))))
    runs, roll = cuts[edges].reshape(-1, 2), coefficients[ROLL : ROLL + 1]
    # Extrema of the roll inside each segment.
    turns = real_roots(with_derivative(roll[:, None])[1, 0], -1.0, 1.0) if len(runs) else np.empty(0)
    spans = []
    for first, last in runs:
        reached = np.concatenate(([first], turns[(turns > first) & (turns < last)], [last]))
        spans.append(np.ptp(evaluate(roll[:, None], reached)))
    return runs, np.array(spans)


def _crossing(x: FloatArray, depth: FloatArray, edge: Integers) -> FloatArray:
    """Return at which x (cases, samples) the depth crosses zero before the first and after the second of two
    samples `edge` (cases, 2), by linear interpolation.
    """
    case = np.arange(len(edge))[:, None]
    beyond = np.minimum(np.maximum(edge + np.array((-1, 1)), 0), x.shape[-1] - 1)
    inside, outside, start = depth[case, edge], depth[case, beyond], x[case, edge]
    share = np.where(outside < inside, inside / (inside - outside), 0.0)
    return np.asarray(start + share * (x[case, beyond] - start))


def rough_window(pairing: FlankPair, l: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return bounds of l1 and l2 (2, cases, 1), mm, of contacts near the flanks.

    The contacts are known approximately at l (2, cases, positions), along which l1 increases. Those on the
    flanks or less than `near_margin` outside are inside the bounds, with a margin in l2; NaN if there
    are none.
    """
    # Distance from the limits, in flank depths or face widths, within which approximate positions may be on
    # the flanks; fraction of the range of l2 that is added at both ends.
    near_margin, l2_margin = 0.25, 0.1
    widened_margin = np.nan_to_num(
        relative_margins(pairing, l, meet(pairing, l)).min(axis=0) + near_margin, nan=-near_margin
    )
    near = widened_margin > 0.0
    edge = np.stack((near.argmax(axis=-1), near.shape[-1] - 1 - near[:, ::-1].argmax(axis=-1)), axis=-1)
    ends = np.moveaxis(np.array([_crossing(x, widened_margin, edge) for x in l]), -1, 0)
    ends[..., ~near.any(axis=-1)] = np.nan
    low, high = np.sort(ends, axis=0)[..., None]
    spare = l2_margin * (high[1] - low[1])
    low[1], high[1] = low[1] - spare, high[1] + spare
    return low, high


def _roll_span(series: PathSeries, x: FloatArray, roll: FloatArray) -> tuple[FloatArray, Mask]:
    """Return the range of pinion roll of the path (cases), rad, and whether the roll turns back. If it does
    not, the range is the difference between the ends.
    """
    span = np.abs(roll[:, 1] - roll[:, 0])
    both = with_derivative(series.coefficients[ROLL : ROLL + 1])
    share = x[:, :1] + (x[:, 1:] - x[:, :1]) * FINE_POSITIONS[::4]
    # The roll may turn back if its rate varies strongly or changes sign.
    rate = evaluate(both[1:], share)[0]
    low, high = rate.min(axis=-1), rate.max(axis=-1)
    turning = low * high <= 0.25 * np.maximum(np.abs(low), np.abs(high)) ** 2
    subset = np.flatnonzero(turning)
    if subset.size:
        turns, turning[subset] = _turns(both[1, subset], x[subset])
        row, place = np.nonzero(~np.isnan(turns))
        reached = np.full((subset.size, turns.shape[1] + 2), np.nan)
        reached[:, :2] = roll[subset]
        reached[row, place + 2] = evaluate(both[:1, subset[row]], turns[row, place, None])[0, :, 0]
        span[subset] = np.nanmax(reached, axis=-1) - np.nanmin(reached, axis=-1)
    return span, turning


def _turns(rate: FloatArray, ends: FloatArray) -> tuple[FloatArray, Mask]:
    """Return where polynomials (cases, degree + 1) change sign between `ends` (cases, 2), as (cases, steps)
    with NaN in steps without a change; and which cases have a change.

    Between samples a polynomial deviates from their chord by about an eighth of the second difference. Where
    it may reach zero and return within this deviation, its roots are computed one by one.
    """
    low, high = np.sort(ends, axis=-1).T[..., None]
    x = low + (high - low) * FINE_POSITIONS
    value = evaluate(rate[None], x)[0]
    roots = np.full((len(x), FINE_POSITIONS.size - 1), np.nan)
    # Changes of sign between samples, then double roots between them.
    row, step = np.nonzero(np.signbit(value[:, :-1]) != np.signbit(value[:, 1:]))
    at = inverted(rate[row], np.zeros((row.size, 1)), x[row, step, None], x[row, step + 1, None])
    roots[row, step] = at[:, 0]
    bend = np.abs(np.diff(value, 2, axis=-1))
    hidden = (np.abs(value[:, 1:-1]) <= bend) & np.isnan(roots[:, 1:]) & np.isnan(roots[:, :-1])
    for case in np.flatnonzero(hidden.any(axis=-1)):
        result = real_roots(rate[case], low[case, 0], high[case, 0])
        roots[case] = np.nan
        roots[case, : result.size] = result
    return roots, np.isfinite(roots).any(axis=-1)
