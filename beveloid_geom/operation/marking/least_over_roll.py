"""The least separation of points of one member from the mating flank, over the roll of the pair.

Seen from the mate, a point Q moves as the pair rolls, and its distance f to the flank along the normal n
changes with

    df/droll = n.dQ/droll = r' V.n - R' r_P n_y

as the foot itself moves square to n: V is the velocity of Q by a turn of its own member, r_P n_y the moment
of n about the mate's axis, r' and R' are the rates at which the two members turn. The least f is where this
slope is zero, or where the foot reaches an edge of the mating flank, its `margin` being zero; whichever comes
first on the way down from a sample that is lower than those beside it. Secants lead there, of both at a time.
Near a corner of the mating flank the foot may be on it between samples only: where these allow it, its
greatest margin is looked for, one more place to go down from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...design.model import Design
from ...gear.perpendicular import EDGE, Sheet, foot_on, sheet_of
from ...status import PatternStatus
from ...support.read_only import read_only
from ..separation import Pose, pose_of, seen_by_other
from .operating_rolls import STEP, Operation

POSES_PER_PITCH = 10
"""Poses at which the separation is sampled before it is refined."""
BESIDE = 1
"""Samples looked at on either side of where the least may be."""
PASSES, STAND, REACHED, HALVED = 60, 1e-4, 1e-7, 1e-11
"""Evaluations of a way down at most. Shares of the step between samples: the steps with which a standstill
and an edge are found, as what a secant leaves is far less; and what halving goes down to."""
CLOSER, ROUNDS = 10, 4
"""Rolls at a time, and times, by which a foot on the mating flank is looked for between samples: one that is
there for a hundredth of the step between them is found."""
LAST_STEP = 1e-4
"""Modules below which a step towards a foot is the last: it leaves an error of its square over a radius,
and of the distance, which is least at the foot, of that squared: 1e-9 mm."""
BLOCK = 4096
"""Points taken at a time, so that the arrays stay in the cache."""
ROUNDING = 1e-12
"""Relative: what counts as whole."""
DISTANCE, MARGIN, OWN, MATE = range(4)
"""Rows of what is known of a point at a pose: its distance from the mating flank and how far the foot lies
within that, mm; by what the distance changes with the rolls of the own member and of the mate, mm/rad."""


@dataclass(frozen=True, eq=False)
class Mating:
    """Points of `member` (0 pinion, 1 gear) in `operation`, opposite the mate's flank `sheet`, sampled at the
    pinion rolls `rolls` (k,), rad, between which all is smooth."""

    member: int
    sheet: Sheet
    pose: Pose
    operation: Operation
    rolls: FloatArray

    def at(self, points: FloatArray, turned: FloatArray) -> FloatArray:
        """Give the rows (4, n) of points (n, 3), own frame, at poses `turned` (4, n)."""
        rows = np.empty((4, len(points)))
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            for first in range(0, len(points), BLOCK):
                part = slice(first, first + BLOCK)
                rows[:, part] = self._rows(points[part].T.copy(), turned[:, part])
        return rows

    def valid(self, rows: FloatArray) -> FloatArray:
        """Give the distances (n,) of rows (4, n), infinite while the foot is not on the mating flank."""
        return np.where(rows[MARGIN] >= 0.0, rows[DISTANCE], np.inf)

    def turned(self, roll: FloatArray, gear_roll: FloatArray) -> FloatArray:
        """Give the poses at rolls of pinion and gear (n,), rad: cosine and sine of the own and of the mate's
        roll (4, n)."""
        both = roll, gear_roll
        own, mate = both[self.member], both[1 - self.member]
        return np.array((np.cos(own), np.sin(own), np.cos(mate), np.sin(mate)))

    @cached_property
    def poses(self) -> FloatArray:
        """Give the poses at the rolls sampled, (4, k)."""
        return read_only(self.turned(self.rolls, self.operation.gear_roll(self.rolls)))

    def _rows(self, points: FloatArray, turned: FloatArray) -> tuple[FloatArray, ...]:
        (x, y, z), (cos, sin, mate_cos, mate_sin), pose = points, turned, self.pose
        x, y = cos * x - sin * y, sin * x + cos * y
        seen, moves = seen_by_other(pose, self.member, x, y, z), (y, -pose.cos * x, pose.sin * x)
        (x, y, z), (u, v, w) = (
            (mate_cos * a + mate_sin * b, mate_cos * b - mate_sin * a, c) for a, b, c in (seen, moves)
        )
        foot = foot_on(self.sheet, (x, y, z), last_step=LAST_STEP)
        (nx, ny, nz), margin = foot.normal, foot.margin + EDGE * np.asarray(self.sheet.module)
        return foot.distance, margin, u * nx + v * ny + w * nz, -foot.moment

    def slope(self, rows: FloatArray, gear_rate: FloatArray) -> FloatArray:
        """Give df/droll (n,), mm/rad of the pinion's roll, from rows (4, n) and the gear's rate."""
        own, mate = (1.0, gear_rate) if self.member == 0 else (gear_rate, 1.0)
        return np.asarray(own * rows[OWN] + mate * rows[MATE])


def mating_of(design: Design, flank: str, member: int, operation: Operation) -> Mating:
    """Give points of `member` (0 pinion, 1 gear) in operation opposite the mating flank."""
    sheet = sheet_of(design.members[1 - member], flank)
    return Mating(member, sheet, pose_of(design), operation, sampled_rolls(design, operation))


def sampled_rolls(design: Design, operation: Operation) -> FloatArray:
    """Give pinion rolls (n,), rad, at which the separation is sampled over the cycle, its kinks among
    them."""
    pitches = (operation.span[1] - operation.span[0]) * float(design.pinion.teeth) / (2.0 * np.pi)
    even = np.linspace(*operation.span, max(whole(POSES_PER_PITCH * pitches) + 1, 3))
    return np.union1d(even, operation.kinks)


def whole(number: float) -> int:
    """Give the number rounded up; rounding of a whole one must not make it one more."""
    return int(np.ceil(number - ROUNDING * number))


@dataclass(frozen=True, eq=False)
class Samples:
    """Distances `table` (k, n), mm, of points at the rolls of a mating, infinite where there is none or none
    was asked for; all `rows` (4, m) that were, of which `place` (k, n) has the numbers, -1 for none, and
    `sample` and `point` (m) have the places. `room` (mm): by how much a foot may miss the mating flank at a
    sample and yet be on it close by."""

    table: FloatArray
    rows: FloatArray
    place: Integers
    sample: Integers
    point: Integers
    room: float

    @property
    def low(self) -> Integers:
        """Give the numbers (l) of rows that are not above those beside them."""
        on = self.rows[MARGIN] >= 0.0
        return self._least(np.where(on, self.rows[DISTANCE], np.inf), on)

    @property
    def passing(self) -> Integers:
        """Give the numbers (l) of rows at which the foot comes nearest to the mating flank, not on it."""
        beyond = -np.nan_to_num(self.rows[MARGIN], nan=-np.inf)
        return self._least(beyond, (beyond > 0.0) & (beyond < self.room))

    def _least(self, values: FloatArray, those: Mask) -> Integers:
        """Give the numbers (l) of rows, of `those` (m), whose values (m) are not above those beside them, if
        these were asked for."""
        row = np.flatnonzero(those)
        return row[(values[row] <= np.append(values, -np.inf)[self._three(row)]).all(axis=0)]

    def _three(self, row: Integers) -> Integers:
        """Give the numbers (3, l) of rows before, at and after others (l), at an end these themselves."""
        three = np.clip(self.sample[row] + np.array(((-1,), (0,), (1,))), 0, len(self.table) - 1)
        return np.asarray(self.place[three, self.point[row]])

    def beside(self, row: Integers, rolls: FloatArray) -> tuple[Integers, FloatArray]:
        """Give the points (l) of rows, and their rolls and rows (5, 3, l) before, there and after."""
        three = self._three(row)
        known = rolls[None, self.sample[three]], self.rows.take(three, axis=1)
        return self.point[row], np.concatenate(known)

    @property
    def near(self) -> Mask:
        """Say near which samples (k, n) the least may be: all, if there is none, else the `low` ones, those
        from which the separation falls while the foot leaves the mating flank, and those `passing`. Next to
        samples that were not asked for there is none."""
        low, passing, found = self.low, self.passing, np.zeros(self.table.shape, dtype=bool)
        found[self.sample[low], self.point[low]] = True
        alone, on = ~found.any(axis=0), np.isfinite(self.table)
        found[self.sample[passing], self.point[passing]] = True
        apart, off = np.append(self.rows[DISTANCE], np.nan)[self.place], (self.place >= 0) & ~on
        falls = off[1:] & on[:-1] & ~(apart[1:] >= apart[:-1]), off[:-1] & on[1:] & ~(apart[:-1] >= apart[1:])
        found[:-1] |= falls[0]
        found[1:] |= falls[1]
        near = found | alone
        for k in range(1, BESIDE + 1):
            near[k:] |= found[:-k]
            near[:-k] |= found[k:]
        return near


@dataclass(frozen=True, eq=False)
class LeastSeparation:
    """Of points (n,): the `least` separation, mm, the pinion's `roll` at which it occurs, rad, and `status`,
    codes of `PatternStatus`."""

    least: FloatArray
    roll: FloatArray
    status: Codes


def sampled(mating: Mating, points: FloatArray, near: Mask | None = None) -> Samples:
    """Sample points (n, 3) at all rolls, or at those that are `near` (k, n); at all too if the least of these
    is not between others."""
    count, n = len(mating.rolls), len(points)
    table, place = np.full((count, n), np.inf), np.full((count, n), -1)
    parts, numbers, done = [np.empty((4, 0))], [np.empty(0, dtype=np.int64)], 0
    asked = np.ones((count, n), dtype=bool) if near is None else near
    while asked.any():
        numbers.append(np.flatnonzero(asked))
        at, column = np.divmod(numbers[-1], n)
        parts.append(mating.at(points.take(column, axis=0), mating.poses.take(at, axis=1)))
        table.reshape(-1)[numbers[-1]] = mating.valid(parts[-1])
        place.reshape(-1)[numbers[-1]] = done + np.arange(at.size)
        done += at.size
        best, each = table.argmin(axis=0), np.arange(n)
        beside = np.clip(best + np.array([[-1], [1]]), 0, count - 1)
        alone = (place[beside, each] < 0).any(axis=0) | np.isinf(table[best, each])
        asked = (place < 0) & alone
    sample, point = np.divmod(np.concatenate(numbers), n)
    room = float(mating.sheet.module)
    return Samples(table, np.concatenate(parts, axis=1), place, sample, point, room)


def least_separation(mating: Mating, points: FloatArray, near: Mask | None = None) -> LeastSeparation:
    """Give the least separation of points (n, 3) over the cycle; `near` (k, n), if known: the samples near
    which it may be. It is the least of the ways down from all low samples and all feet between samples."""
    samples = sampled(mating, points, near)
    low, between = samples.beside(samples.low, mating.rolls), _between(mating, points, samples)
    point, three = (np.concatenate(both, axis=-1) for both in zip(low, between, strict=True))
    at, beside, rows, way = three[0, 1], three[0, ::2], three[1:], np.array(((-1,), (1,)))
    begin, inner = rows[:, 1], beside != at
    _, rate = mating.operation.motion(np.tile(at, 2), np.where(inner, beside, beside[::-1]).ravel())
    slope = mating.slope(begin, rate.reshape(inner.shape))
    fall, leaves = -way * slope, ~(rows[MARGIN, ::2] >= 0.0)
    to_edge, side, down = np.nonzero(inner & (fall > 0.0, leaves))
    span, end = np.array((at[down], beside[side, down])), rows[:, 2 * side, down]
    slopes = slope[side, down], mating.slope(end, mating.operation.motion(*span[::-1])[1])
    falls = (span[0] - span[1]) * slopes
    ends = begin[:2, down], end[:2]
    found, roll, reached = _way_down(mating, points[point[down]], span, ends, falls, to_edge > 0)
    cut = ((fall > 0.0) & ~inner).any(axis=0)
    code = np.append(
        np.where(reached, PatternStatus.MATE_EDGE, PatternStatus.STANDSTILL),
        np.where(cut, PatternStatus.END_OF_ROLL, PatternStatus.STANDSTILL),
    )
    found, roll, point = np.append(found, begin[DISTANCE]), np.append(roll, at), np.append(point[down], point)
    order = np.argsort(-found, kind="stable")  # of a point the lowest comes last
    order = order[np.isfinite(found[order])]
    least, at = np.full((2, len(points)), np.nan)
    status = np.full(len(points), PatternStatus.NO_MATE, dtype=np.int8)
    point = point[order]
    least[point], at[point], status[point] = found[order], roll[order], code[order]
    return LeastSeparation(least, at, status)


def _between(mating: Mating, points: FloatArray, samples: Samples) -> tuple[Integers, FloatArray]:
    """Give the numbers of points whose foot is on the mating flank between samples, with rolls and rows
    (5, 3, n) where it is, and before and after.

    The margin, the least of several that change evenly, bends down: on either side of the middle it is below
    the line through the middle and the other end. It is followed to its greatest while these leave any."""
    point, three = samples.beside(samples.passing, mating.rolls)
    found, share = [(point[:0], three[..., :0])], np.linspace(0.0, 1.0, CLOSER)[:, None]
    for count in range(ROUNDS + 1):
        margin, length = _known_margin(three, samples.room), np.diff(three[0], axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            most = margin[1] + ((margin[1] - margin[::2]) / length)[::-1] * length
        most = np.where(np.isnan(most), np.inf, most)  # at the first and the last roll nothing bounds it
        on, going = margin[1] >= 0.0, (margin[1] < 0.0) & (most.max(axis=0) >= 0.0)
        found.append((point[on], three[..., on]))
        point, three = point[going], three[..., going]
        if not point.size or count == ROUNDS:
            break
        roll = (three[0, 0] + share * (three[0, 2] - three[0, 0])).ravel()
        gear_roll, _ = mating.operation.motion(roll, roll + STEP)
        rows = mating.at(np.tile(points[point], (CLOSER, 1)), mating.turned(roll, gear_roll))
        closer = np.concatenate((roll[None], rows)).reshape(5, CLOSER, point.size)
        margin = _known_margin(closer, samples.room)
        best = np.clip(margin.argmax(axis=0), 1, CLOSER - 2)
        away = np.where(margin.max(axis=0) >= 0.0, CLOSER, 1)  # once on the flank, as far as it surely is off
        three = np.clip(best + away * np.array([[-1], [0], [1]]), 0, CLOSER - 1)
        three = np.take_along_axis(closer, three[None], axis=1)
    return np.concatenate([own for own, _ in found]), np.concatenate([own for _, own in found], axis=-1)


def _known_margin(known: FloatArray, room: float) -> FloatArray:
    """Give margins of rolls and rows (5, ...), a `room` beyond the flank where there is no foot."""
    return np.asarray(np.nan_to_num(known[1 + MARGIN], nan=-room))


def _way_down(
    mating: Mating,
    points: FloatArray,
    span: FloatArray,
    ends: tuple[FloatArray, FloatArray],
    falls: FloatArray,
    to_edge: Mask,
) -> tuple[FloatArray, FloatArray, Mask]:
    """Give the least separation, its roll and whether an edge is reached there, (n,), on the way from the
    first to the second roll of `span` (2, n), given distances and margins (2, n) at both `ends` and by how
    much the separation `falls` (2, n) there, mm for the whole way.

    Shares t of the way are looked for: `low` and beyond that the least is, not beyond `high`."""
    n, (begin, whole) = len(points), (span[0], span[1] - span[0])
    length, found, reached, going = whole, np.empty((2, n)), np.zeros(n, dtype=bool), np.arange(n)
    f, t, low, high = ends[0][DISTANCE], *np.zeros((2, n)), np.ones(n)
    left = np.array((ends[0][MARGIN], falls[0]))  # margin and fall: whichever ends first
    by_t = np.array((ends[1][MARGIN] - left[0], np.empty(n)))
    by_t[1], bent = _parabola(falls, f - ends[1][DISTANCE], ends[1][MARGIN] >= 0.0)
    for count in range(PASSES):
        with np.errstate(invalid="ignore", divide="ignore"):
            stops = np.where(by_t < 0.0, t - left / by_t, np.inf)
        stops[1, to_edge] = np.inf
        new, edge = np.minimum(*stops), stops[0] < stops[1]
        halved = ~((new >= low) & (new <= high)) | (count % 8 == 7)
        new = np.where(halved, 0.5 * (low + high), new)
        step = new - t
        small = np.abs(step) <= np.where(edge, REACHED, STAND)
        ended = ~halved & small & (count > 0) | (high - low <= HALVED)
        if ended.any() or count == PASSES - 1:
            f = np.where(ended, f - step * (left[1] + 0.5 * step * np.nan_to_num(by_t[1])), f)
            found[:, going], reached[going] = (f, np.where(ended, new, t)), edge
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
    return found[0], begin + found[1] * whole, reached


def _parabola(falls: FloatArray, lower: FloatArray, known: Mask) -> tuple[FloatArray, FloatArray]:
    """Give the rate (n,) that leads from the start of a way straight to where the parabola is zero that is
    `falls` (2, n) at its ends and `lower` in all, and half its second derivative; those of a straight line
    where the end is not `known`, or there is no such place."""
    bent = 3.0 * (falls[0] + falls[1]) - 6.0 * lower
    rate = falls[1] - falls[0] - bent
    square = rate * rate - 4.0 * bent * falls[0]
    known = known & (square >= 0.0)
    straight = 2.0 * (lower - falls[0])
    bent = np.where(known, bent, 0.0)
    return np.where(known, 0.5 * (rate - np.sqrt(np.maximum(square, 0.0))), straight), bent
