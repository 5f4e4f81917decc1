"""Minimum separation of points of one member from the mating flank over the roll of the pair.

Seen from the mate, a point Q moves as the pair rolls. Its distance f to the flank along the normal n changes
with

    df/droll = n.dQ/droll = r' V.n - R' r_P n_y,

since the foot of the perpendicular moves perpendicular to n. V is the velocity of Q per rad of its member,
r_P n_y the moment of n about the mate's axis, and r', R' are the rates at which both members rotate. The
minimum of f is where this slope is zero, or where the foot reaches an edge of the mating flank (its `margin`
is zero), whichever comes first on the descent from a sample that is lower than its neighbours. Both
conditions are solved together by the secant method.

Near a corner of the mating flank, the foot may be on the flank between two samples only. Where the samples
allow this, the maximum of the margin is searched as an additional start of a descent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import PatternStatus
from .mating import DISTANCE, MARGIN, Mating
from .motion import ROLL_DIFFERENCE_RAD


@dataclass(frozen=True, eq=False)
class SeparationSamples:
    """Sampled distances of points.

    Attributes
    ----------
    table : ndarray, shape (k, n)
        Distances at the rolls of a mating, mm; infinite where the foot is not on the flank or was not
        computed.
    rows : ndarray, shape (4, m)
        Computed states of points: distance, margin and two derivatives (`mating.DISTANCE`). Each of the m
        columns is the state of one point at one sample; below, its index is the "number of the row".
    place : ndarray of int, shape (k, n)
        Numbers of the rows, -1 where not computed.
    sample, point : ndarray of int, shape (m,)
        Sample and point of each row.
    max_miss : float
        Distance (mm) by which a foot may miss the mating flank at a sample and still be on it between
        samples.
    """

    table: FloatArray
    rows: FloatArray
    place: Integers
    sample: Integers
    point: Integers
    max_miss: float

    @property
    def low(self) -> Integers:
        """Return the numbers (l) of rows that are not above their neighbours."""
        on = self.rows[MARGIN] >= 0.0
        return self._least(np.where(on, self.rows[DISTANCE], np.inf), on)

    @property
    def passing(self) -> Integers:
        """Return the numbers (l) of rows at which the foot is closest to the mating flank without being on
        it."""
        beyond = -np.nan_to_num(self.rows[MARGIN], nan=-np.inf)
        return self._least(beyond, (beyond > 0.0) & (beyond < self.max_miss))

    def _least(self, values: FloatArray, candidates: Mask) -> Integers:
        """Return the numbers (l) of rows, among `candidates` (m), whose values (m) are not above their
        neighbours. Rows next to a sample that was not computed are left out."""
        row = np.flatnonzero(candidates)
        return row[(values[row] <= np.append(values, -np.inf)[self._three(row)]).all(axis=0)]

    def _three(self, row: Integers) -> Integers:
        """Return the numbers (3, l) of the rows before, at and after rows (l); at an end, the row itself."""
        three = np.clip(self.sample[row] + np.array(((-1,), (0,), (1,))), 0, len(self.table) - 1)
        return np.asarray(self.place[three, self.point[row]])

    def with_neighbours(self, row: Integers, rolls: FloatArray) -> tuple[Integers, FloatArray]:
        """Return the points (l) of rows, and the rolls and rows (5, 3, l) before, at and after them."""
        three = self._three(row)
        known = rolls[None, self.sample[three]], self.rows.take(three, axis=1)
        return self.point[row], np.concatenate(known)

    @property
    def near(self) -> Mask:
        """Return the samples (k, n) next to which the minimum may be, as a mask.

        Marked are: the `low` samples, or all samples of a point that has none; the samples from which the
        separation decreases while the foot leaves the mating flank; the `passing` samples; and the neighbours
        of all these. A low or passing sample is marked only if its neighbours were computed."""
        low, passing, results = self.low, self.passing, np.zeros(self.table.shape, dtype=bool)
        results[self.sample[low], self.point[low]] = True
        alone, on = ~results.any(axis=0), np.isfinite(self.table)
        results[self.sample[passing], self.point[passing]] = True
        apart, off = np.append(self.rows[DISTANCE], np.nan)[self.place], (self.place >= 0) & ~on
        falls = off[1:] & on[:-1] & ~(apart[1:] >= apart[:-1]), off[:-1] & on[1:] & ~(apart[:-1] >= apart[1:])
        results[:-1] |= falls[0]
        results[1:] |= falls[1]
        near = results | alone
        near[1:] |= results[:-1]
        near[:-1] |= results[1:]
        return near


@dataclass(frozen=True, eq=False)
class MinimumSeparation:
    """Minimum separation (mm) of points (n,), the pinion `roll` at which it occurs (rad), and `status`,
    codes of `PatternStatus`."""

    least: FloatArray
    roll: FloatArray
    status: Codes


def separation_samples(mating: Mating, points: FloatArray, near: Mask | None = None) -> SeparationSamples:
    """Sample the separation of points.

    Parameters
    ----------
    mating : Mating
    points : ndarray, shape (n, 3)
        In the frame that rotates with the member, mm.
    near : ndarray of bool, shape (k, n), optional
        Samples that are computed first. The other samples of a point are computed as well if a neighbour of
        the smallest of these is missing, or if the foot is on the flank at none of these.

    Returns
    -------
    SeparationSamples
    """
    count, n = len(mating.rolls), len(points)
    table, place = np.full((count, n), np.inf), np.full((count, n), -1)
    parts, numbers, done = [np.empty((4, 0))], [np.empty(0, dtype=np.int64)], 0
    asked = np.ones((count, n), dtype=bool) if near is None else near
    while asked.any():
        numbers.append(np.flatnonzero(asked))
        at, column = np.divmod(numbers[-1], n)
        parts.append(mating.at(points.take(column, axis=0), mating.poses.take(at, axis=1)))
        table.reshape(-1)[numbers[-1]] = mating.distance_on_flank(parts[-1])
        place.reshape(-1)[numbers[-1]] = done + np.arange(at.size)
        done += at.size
        best, each = table.argmin(axis=0), np.arange(n)
        neighbours = np.clip(best + np.array([[-1], [1]]), 0, count - 1)
        alone = (place[neighbours, each] < 0).any(axis=0) | np.isinf(table[best, each])
        asked = (place < 0) & alone
    sample, point = np.divmod(np.concatenate(numbers), n)
    max_miss = float(mating.sheet.module)
    return SeparationSamples(table, np.concatenate(parts, axis=1), place, sample, point, max_miss)


def minimum_separation(
    mating: Mating, points: FloatArray, samples: SeparationSamples | None = None
) -> MinimumSeparation:
    """Compute the minimum separation of points over the roll.

    Parameters
    ----------
    mating : Mating
    points : ndarray, shape (n, 3)
        In the frame that rotates with the member, mm.
    samples : SeparationSamples, optional
        `separation_samples` of these points, if known.

    Returns
    -------
    MinimumSeparation
        The smallest result of the descents from all low samples and all feet between samples.
    """
    samples = separation_samples(mating, points) if samples is None else samples
    low, between = samples.with_neighbours(samples.low, mating.rolls), _between(mating, points, samples)
    point, three = (np.concatenate(both, axis=-1) for both in zip(low, between, strict=True))
    at, neighbours, rows, direction = three[0, 1], three[0, ::2], three[1:], np.array(((-1,), (1,)))
    begin, inner = rows[:, 1], neighbours != at
    _, rate = mating.operation.motion(np.tile(at, 2), np.where(inner, neighbours, neighbours[::-1]).ravel())
    slope = mating.slope(begin, rate.reshape(inner.shape))
    fall, leaves = -direction * slope, ~(rows[MARGIN, ::2] >= 0.0)
    to_edge, side, down = np.nonzero(inner & (fall > 0.0, leaves))
    span, end = np.array((at[down], neighbours[side, down])), rows[:, 2 * side, down]
    slopes = slope[side, down], mating.slope(end, mating.operation.motion(*span[::-1])[1])
    falls = (span[0] - span[1]) * slopes
    ends = begin[:2, down], end[:2]
    results, roll, reached = _descents(mating, points[point[down]], span, ends, falls, to_edge > 0)
    cut = ((fall > 0.0) & ~inner).any(axis=0)
    code = np.append(
        np.where(reached, PatternStatus.MATE_EDGE, PatternStatus.STANDSTILL),
        np.where(cut, PatternStatus.END_OF_ROLL, PatternStatus.STANDSTILL),
    )
    results, roll, point = (
        np.append(*both) for both in ((results, begin[DISTANCE]), (roll, at), (point[down], point))
    )
    order = np.argsort(-results, kind="stable")  # the smallest of each point is written last
    order = order[np.isfinite(results[order])]
    least, at = np.full((2, len(points)), np.nan)
    status = np.full(len(points), PatternStatus.NO_MATE, dtype=np.int8)
    point = point[order]
    least[point], at[point], status[point] = results[order], roll[order], code[order]
    return MinimumSeparation(least, at, status)


def _between(mating: Mating, points: FloatArray, samples: SeparationSamples) -> tuple[Integers, FloatArray]:
    """Return the points whose foot is on the mating flank between samples, with rolls and rows (5, 3, n)
    there, before and after.

    The margin, the minimum of several nearly linear functions, is concave: on either side of the middle,
    it is below the line through the middle and the other end. Its maximum is refined while this bound
    allows a positive value."""
    point, three = samples.with_neighbours(samples.passing, mating.rolls)
    # Rolls per round, and rounds, of the search for a foot between samples. A foot that is on the mating
    # flank for a hundredth of the step is found.
    closer_rolls, max_rounds = 10, 4
    results, share = [(point[:0], three[..., :0])], np.linspace(0.0, 1.0, closer_rolls)[:, None]
    for count in range(max_rounds + 1):
        margin, length = _known_margin(three, samples.max_miss), np.diff(three[0], axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            most = margin[1] + ((margin[1] - margin[::2]) / length)[::-1] * length
        most = np.where(np.isnan(most), np.inf, most)  # no bound at the first and last roll
        on, going = margin[1] >= 0.0, (margin[1] < 0.0) & (most.max(axis=0) >= 0.0)
        results.append((point[on], three[..., on]))
        point, three = point[going], three[..., going]
        if not point.size or count == max_rounds:
            break
        roll = (three[0, 0] + share * (three[0, 2] - three[0, 0])).ravel()
        gear_roll, _ = mating.operation.motion(roll, roll + ROLL_DIFFERENCE_RAD)
        rows = mating.at(np.tile(points[point], (closer_rolls, 1)), mating.turned(roll, gear_roll))
        closer = np.concatenate((roll[None], rows)).reshape(5, closer_rolls, point.size)
        margin = _known_margin(closer, samples.max_miss)
        best = np.clip(margin.argmax(axis=0), 1, closer_rolls - 2)
        # Once on the flank, keep the complete interval.
        away = np.where(margin.max(axis=0) >= 0.0, closer_rolls, 1)
        three = np.clip(best + away * np.array([[-1], [0], [1]]), 0, closer_rolls - 1)
        three = np.take_along_axis(closer, three[None], axis=1)
    points_between, known = zip(*results, strict=True)
    return np.concatenate(points_between), np.concatenate(known, axis=-1)


def _known_margin(known: FloatArray, max_miss: float) -> FloatArray:
    """Return margins of rolls and rows (5, ...), replaced by -`max_miss` where there is no foot."""
    return np.asarray(np.nan_to_num(known[1 + MARGIN], nan=-max_miss))


def _descents(
    mating: Mating,
    points: FloatArray,
    span: FloatArray,
    ends: tuple[FloatArray, FloatArray],
    falls: FloatArray,
    to_edge: Mask,
) -> tuple[FloatArray, FloatArray, Mask]:
    """Return the minimum separation, its roll and whether an edge was reached, (n,), by descents from the
    first to the second roll of `span` (2, n).

    Distances and margins (2, n) at both `ends`, and the decrease of the separation `falls` (2, n) there
    for the complete span (mm), are known. The unknown is the fraction t of the span. The minimum is at or
    beyond `low`, and not beyond `high`."""
    # Maximum number of evaluations of a descent.
    max_evaluations = 60
    n, (begin, full_length) = len(points), (span[0], span[1] - span[0])
    length, results, reached, going = full_length, np.empty((2, n)), np.zeros(n, dtype=bool), np.arange(n)
    f, t, low, high = ends[0][DISTANCE], *np.zeros((2, n)), np.ones(n)
    left = np.array((ends[0][MARGIN], falls[0]))  # margin and fall: the first to become zero ends the descent
    by_t = np.array((ends[1][MARGIN] - left[0], np.empty(n)))
    by_t[1], bent = _parabola(falls, f - ends[1][DISTANCE], ends[1][MARGIN] >= 0.0)
    for count in range(max_evaluations):
        with np.errstate(invalid="ignore", divide="ignore"):
            stops = np.where(by_t < 0.0, t - left / by_t, np.inf)
        stops[1, to_edge] = np.inf
        new, edge = np.minimum(*stops), stops[0] < stops[1]
        # Bisect if the secant leaves the interval, and every eighth time.
        halved = ~((new >= low) & (new <= high)) | (count % 8 == 7)
        new = np.where(halved, 0.5 * (low + high), new)
        step = new - t
        small = np.abs(step) <= np.where(edge, 1e-7, 1e-4)  # edges more closely
        ended = ~halved & small & (count > 0) | (high - low <= 1e-11)
        if ended.any() or count == max_evaluations - 1:
            f = np.where(ended, f - step * (left[1] + 0.5 * step * np.nan_to_num(by_t[1])), f)
            results[:, going], reached[going] = (f, np.where(ended, new, t)), edge
            stays = np.flatnonzero(~ended)
            if not stays.size:
                break
            points, going, to_edge = points[stays], going[stays], to_edge[stays]
            rows = np.array((f, t, new, length, low, high, bent)).take(stays, axis=1)
            f, t, new, length, low, high, bent = rows
            span, left, by_t = (row.take(stays, axis=1) for row in (span, left, by_t))
        roll, towards = span[0] + new * length, np.where(new < 0.5, span[1], span[0])
        gear_roll, rate = mating.operation.motion(roll, towards)
        rows = mating.at(points, mating.turned(roll, gear_roll))
        after = np.array((rows[MARGIN], -length * mating.slope(rows, rate)))
        lost = np.isnan(rows[DISTANCE])
        inside = (after[0] >= 0.0) & ((after[1] >= 0.0) | to_edge)
        high = np.where(inside, high, np.where(lost, low + 0.999 * (new - low), new))
        low = np.where(inside, new, low)
        chord = (after - left) / (new - t)
        chord[1] += bent * (new - t)
        by_t = np.where(lost, by_t, chord)
        t, f, left = np.where(lost, t, new), np.where(lost, f, rows[DISTANCE]), np.where(lost, left, after)
    return results[0], begin + results[1] * full_length, reached


def _parabola(falls: FloatArray, lower: FloatArray, known: Mask) -> tuple[FloatArray, FloatArray]:
    """Return the initial rate (n,) of a descent, and half of the second derivative of the fall: the chord
    leads to the zero of the parabola with the values `falls` (2, n) at both ends and the integral
    `lower`. Where the end is not `known`, or there is no zero, they are those of a straight line."""
    bent = 3.0 * (falls[0] + falls[1]) - 6.0 * lower
    rate = falls[1] - falls[0] - bent
    square = rate * rate - 4.0 * bent * falls[0]
    known = known & (square >= 0.0)
    straight = 2.0 * (lower - falls[0])
    bent = np.where(known, bent, 0.0)
    return np.where(known, 0.5 * (rate - np.sqrt(np.maximum(square, 0.0))), straight), bent
