"""Roots of the one equation F(l1, l2) = 0 in l2, for given l1.

`solve_gear_parameter` samples F over l2 (`Samples`), brackets every sign change, and runs Newton with the
exact slope inside the bracket, halving it whenever a step leaves it. Where n_x vanishes F runs
off to an infinity of known sign, so that a root between the last sample and that pole is
bracketed too; where an extremum of F comes near zero more samples look for two roots beside it.
Of several roots the one on the flanks is taken; if two are, the position is marked.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..status import Status
from .equation import (
    Pairing,
    Terms,
    axial_and_radius,
    facing,
    gap_and_slope,
    gap_tolerance,
    guarded_gap,
    limit_margins,
    meet,
    terms_of_one,
)

SHARES = np.linspace(0.0, 1.0, 7)[:, None, None]
NEAR = 1.2 * SHARES - 0.1
FAR = np.linspace(-1.0, 2.0, 25)[:, None, None]
"""Where F is sampled in l2: shares of the gear flank's depth from its root, first near the
active flank, and over three flank depths where nothing was found there."""
EXTREMA, NEWTON_LIMIT = 6, 60
"""Samples added beside an extremum of F near zero; passes of Newton, most of which only halve."""
SHORT = 2
"""Passes of Newton after which the positions that are left, if they are fewer than half, go on alone."""
LAST_STEP = 1e-6
"""Share of the flank's depth below which a Newton step is the last: it leaves an error of its
square. The callers judge F afterwards."""


@dataclass(frozen=True, eq=False)
class Roots:
    """Roots l2 (mm), the slope dF/dl2 there, and the Status, each (cases, positions)."""

    l2: FloatArray
    slope: FloatArray
    status: NDArray[np.int8]

    def where(self, kept: NDArray[np.bool_], other: Roots) -> Roots:
        """Give these roots where `kept`, elsewhere the other ones."""
        return Roots(
            np.where(kept, self.l2, other.l2),
            np.where(kept, self.slope, other.slope),
            np.where(kept, self.status, other.status),
        )


@dataclass(frozen=True, eq=False)
class Samples:
    """F sampled over l2: the pinion's terms, points `l2` and F (`values`) there, mm, and which of them have a
    common normal (`real`), (samples, cases, positions); and between which of them F changes its sign
    (`change`), (samples - 1, cases, positions)."""

    pinion: Terms
    l2: FloatArray
    values: FloatArray
    real: NDArray[np.bool_]
    change: NDArray[np.bool_]

    def cases(self, index: NDArray[np.int_]) -> Samples:
        """Give the samples of the cases `index`."""
        pinion = Terms(*(value[..., index, :] for value in vars(self.pinion).values()))
        l2, values, real, change = self.l2, self.values, self.real, self.change
        return Samples(pinion, l2[:, index], values[:, index], real[:, index], change[:, index])

    def one_way(self) -> Samples:
        """Leave those changes in which F rises, or those in which it falls: of each case the ones that more
        of its positions have, since along one curve it is either."""
        rising = self.change & np.signbit(self.values[:-1])
        falling = self.change & ~rising
        rises = rising.any(axis=0).sum(axis=-1) >= falling.any(axis=0).sum(axis=-1)
        return replace(self, change=np.where(rises[:, None], rising, falling))

    def rough(self) -> FloatArray:
        """Give l2 (cases, positions), mm, near the first change, NaN without such."""
        return np.where(self.change.any(axis=0), self.between(self.change.argmax(axis=0))[2], np.nan)

    def between(
        self, place: NDArray[np.int_]
    ) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
        """Give brackets of l2, mm, from the samples `place` (cases, positions) to the next, where a parabola
        through both ends and a third sample crosses zero in them, and whether F rises there."""
        low, high = self.at(place), self.at(place + 1)
        third = self.at(np.where(place > 0, place - 1, np.minimum(place + 2, len(self.l2) - 1)))
        rise = (high[1] - low[1]) / (high[0] - low[0])
        bend = ((third[1] - high[1]) / (third[0] - high[0]) - rise) / (third[0] - low[0])
        chord = low[0] - low[1] / rise
        start = chord - bend * (chord - low[0]) * (chord - high[0]) / rise
        for other in (chord, 0.5 * (low[0] + high[0])):  # beside a pole
            start = np.where((start >= low[0]) & (start <= high[0]), start, other)
        return low[0], high[0], start, high[1] > low[1]

    def at(self, place: NDArray[np.int_]) -> tuple[FloatArray, FloatArray]:
        """Give l2 and F of the samples `place` (cases, positions)."""
        index = place * place.size + np.arange(place.size).reshape(place.shape)
        return self.l2.take(index), self.values.take(index)


def samples_of(pairing: Pairing, l1: FloatArray, bounds: FloatArray, shares: FloatArray) -> Samples:
    """Sample F at every `l1` (cases, positions) at `shares` of the way between `bounds` of l2 (2, cases, 1),
    mm."""
    return _sampled(pairing, terms_of_one(pairing, l1, 0), bounds[0] + shares * (bounds[1] - bounds[0]))


def _sampled(pairing: Pairing, pinion: Terms, l2: FloatArray) -> Samples:
    met = facing(pairing, pinion, terms_of_one(pairing, l2, 1))
    values, real = guarded_gap(pairing, met), ~np.isnan(met.gap)
    return Samples(pinion, np.broadcast_to(l2, values.shape), values, real, _changes(values, real))


def _changes(values: FloatArray, real: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Say between which samples F changes its sign where it is real on one side at least."""
    below = np.signbit(values)
    return np.asarray((below[:-1] != below[1:]) & (real[:-1] | real[1:]))


def _with_extremum(pairing: Pairing, samples: Samples) -> Samples:
    """Give the samples with a few more, near that extremum of F which comes closest to zero without crossing
    it: two roots may hide between the samples around it."""
    pinion, l2, values, real, _ = vars(samples).values()
    for turn in range(EXTREMA):
        left, middle, right = values[:-2], values[1:-1], values[2:]
        towards = (np.abs(middle) <= np.minimum(np.abs(left), np.abs(right))) & (left * middle > 0.0)
        towards &= (middle * right > 0.0) & real[1:-1]
        if not towards.any():
            break
        best = np.where(towards, np.abs(middle), np.inf).argmin(axis=0)[None] + 1
        x0, x1, x2 = (np.take_along_axis(l2, best + k, axis=0)[0] for k in (-1, 0, 1))
        f0, f1, f2 = (np.take_along_axis(values, best + k, axis=0)[0] for k in (-1, 0, 1))
        rise, fall = (f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1)
        vertex = 0.5 * (x0 + x1) - 0.5 * rise * (x2 - x0) / (fall - rise)
        # Beside a pole the parabola says nothing: halve, first towards the pole.
        pole = np.isinf(f0) | np.isinf(f2)
        halfway = 0.5 * (x1 + np.where(np.isinf(f2) == (turn % 2 == 0), x2, x0))
        usable = (vertex > x0) & (vertex < x2) & (vertex != x1) & ~pole
        vertex = np.where(usable, vertex, halfway)
        met = facing(pairing, pinion, terms_of_one(pairing, vertex, 1))
        new = (vertex, guarded_gap(pairing, met), ~np.isnan(met.gap))
        order = np.argsort(np.concatenate((l2, vertex[None])), axis=0, kind="stable")
        l2, values, real = (
            np.take_along_axis(np.concatenate((known, added[None])), order, axis=0)
            for known, added in zip((l2, values, real), new, strict=True)
        )
    return Samples(pinion, l2, values, real, _changes(values, real))


@dataclass(frozen=True, eq=False)
class _Search:
    """Roots being sought: brackets [low, high] in l2 (mm), whether F is `rising` in them, where Newton
    stands, the slope there, and what is `done`; (cases, positions)."""

    low: FloatArray
    high: FloatArray
    rising: NDArray[np.bool_]
    l2: FloatArray
    slope: FloatArray
    done: NDArray[np.bool_]


def _newton(pairing: Pairing, pinion: Terms, search: _Search, passes: int) -> _Search:
    """Take Newton steps inside the brackets. After SHORT passes the positions left are solved by
    themselves."""
    low, high, l2, slope, done = search.low, search.high, search.l2, search.slope, search.done
    tolerance, enough = gap_tolerance(pairing), LAST_STEP * (pairing.highest[1] - pairing.lowest[1])
    for turn in range(passes):
        left = np.count_nonzero(~done)
        if left == 0:
            break
        if turn % SHORT == 0 and 2 * left < done.size:
            now = replace(search, low=low, high=high, l2=l2, slope=slope, done=done)
            return _newton_of_some(pairing, pinion, now, passes - turn)
        gap, slope = gap_and_slope(pairing, pinion, l2)
        if np.isnan(gap).any():
            beyond = guarded_gap(pairing, facing(pairing, pinion, terms_of_one(pairing, l2, 1)))
            gap = np.where(np.isnan(gap), beyond, gap)
        done = done | (np.abs(gap) <= tolerance)
        above = (gap > 0.0) == search.rising
        low, high = np.where(above, low, l2), np.where(above, l2, high)
        following = l2 - gap / slope
        following = np.where((following >= low) & (following <= high), following, 0.5 * (low + high))
        small = np.abs(following - l2) <= enough
        l2 = np.where(done, l2, following)
        done = done | small
    return replace(search, l2=l2, slope=slope, done=done)


def _newton_of_some(pairing: Pairing, pinion: Terms, search: _Search, passes: int) -> _Search:
    """Take Newton steps for the positions that are not done, each as a case of its own."""
    case, position = np.nonzero(~search.done)
    terms = Terms(*(value[..., case, position, None] for value in vars(pinion).values()))
    part = _Search(*(value[case, position, None] for value in vars(search).values()))
    found = _newton(pairing.cases(case), terms, part, passes)
    for name in ("l2", "slope", "done"):
        getattr(search, name)[case, position] = getattr(found, name)[:, 0]
    return search


def solve_gear_parameter(pairing: Pairing, l1: FloatArray) -> Roots:
    """Solve F(l1, l2) = 0 for l2 at every `l1` (cases, positions), mm, safely.

    Roots off the flanks are found up to one flank depth beyond the gear's flank and are reported as solved;
    nothing is clipped here."""
    low, high = pairing.lowest[1], pairing.highest[1]
    pinion = terms_of_one(pairing, l1, 0)
    roots = roots_in(pairing, l1, _sampled(pairing, pinion, low + NEAR * (high - low)))
    lost = np.flatnonzero((roots.status != Status.SOLVED).any(axis=-1))
    if lost.size:
        part, far = pairing.cases(lost), (low + FAR * (high - low))[:, lost]
        pinion = Terms(*(value[..., lost, :] for value in vars(pinion).values()))
        far = roots_in(part, l1[lost], _with_extremum(part, _sampled(part, pinion, far)))
        near = Roots(roots.l2[lost], roots.slope[lost], roots.status[lost])
        both = near.where(near.status == Status.SOLVED, far)
        roots.l2[lost], roots.slope[lost], roots.status[lost] = both.l2, both.slope, both.status
    return roots


def roots_in(pairing: Pairing, l1: FloatArray, samples: Samples, passes: int = NEWTON_LIMIT) -> Roots:
    """Give the root on the flanks among all that `samples` at `l1` (cases, positions), mm, bracket, else the
    one least far off, by so many `passes` of Newton."""
    rank = np.cumsum(samples.change, axis=0, dtype=np.int8)
    count, last = rank[-1], len(rank) - 1
    best = Roots(*(np.full(l1.shape, fill) for fill in (np.nan, np.nan, np.int8(Status.OFF_FLANK))))
    several = np.flatnonzero((count > 1).any(axis=-1))
    part = pairing.cases(several)
    margin, hits = np.full(l1.shape, -np.inf), np.zeros(l1.shape, dtype=int)
    for k in range(1, int(count.max(initial=0)) + 1):
        has = count >= k
        low, high, start, rising = samples.between(np.minimum((rank < k).sum(axis=0), last))
        sought = _Search(low, high, rising, start, np.ones(l1.shape), ~has)
        found = _newton(pairing, samples.pinion, sought, passes)
        lost = np.where(found.done, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
        root = Roots(found.l2, found.slope, lost)
        if several.size:
            l = np.array((l1, root.l2))[:, several]
            depth = np.full(l1.shape, -np.inf)
            depth[several] = limit_margins(part, l, *axial_and_radius(part, meet(part, l))).min(axis=0)
            depth[~has] = -np.inf
            hits += depth >= 0.0
            has = has & ((depth > margin) | (k == 1))
            margin = np.where(has, depth, margin)
        best = root.where(has, best)
    status = np.where(hits > 1, np.int8(Status.SEVERAL_CONTACTS), best.status)
    status = np.where((count == 0) & ~samples.real.all(axis=0), np.int8(Status.NO_COMMON_NORMAL), status)
    known = status == Status.SOLVED
    return Roots(np.where(known, best.l2, np.nan), np.where(known, best.slope, np.nan), status)
