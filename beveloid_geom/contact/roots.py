"""Roots of the one equation F(l1, l2) = 0 in l2, for given l1.

`solve_gear_parameter` samples F over l2, brackets every sign change, and runs Newton with the
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
EXTREMA, NEWTON_LIMIT, FEW = 6, 60, 5
"""Samples added beside an extremum of F near zero; passes of Newton, most of which only halve; those
that do for positions of a smooth series."""
SHORT = 3
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


def _sampled(
    pairing: Pairing, pinion: Terms, l2: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Give sample points in l2, F at them, and which of them have a common normal; samples first."""
    met = facing(pairing, pinion, terms_of_one(pairing, l2, 1))
    return np.broadcast_to(l2, met.gap.shape), guarded_gap(pairing, met), ~np.isnan(met.gap)


def _with_extremum(
    pairing: Pairing, pinion: Terms, l2: FloatArray, values: FloatArray, real: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Give the samples with a few more, near that extremum of F which comes closest to zero without crossing
    it: two roots may hide between the samples around it."""
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
    return l2, values, real


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


def solve_gear_parameter(
    pairing: Pairing, l1: FloatArray, within: tuple[FloatArray, FloatArray] | None = None
) -> Roots:
    """Solve F(l1, l2) = 0 for l2 at every `l1` (cases, positions), mm, safely.

    Roots off the flanks are found up to one flank depth beyond the gear's flank and are reported as solved;
    nothing is clipped here. With bounds `within` (cases, 1), mm, only simple roots between these are."""
    low, high = pairing.lowest[1], pairing.highest[1]
    if within is not None:
        return _search(pairing, l1, within[0] + SHARES * (within[1] - within[0]), within=True)
    roots = _search(pairing, l1, low + NEAR * (high - low))
    lost = np.flatnonzero((roots.status != Status.SOLVED).any(axis=-1))
    if lost.size:
        l2 = (low + FAR * (high - low))[:, lost]
        far = _search(pairing.cases(lost), l1[lost], l2, extrema=True)
        near = Roots(roots.l2[lost], roots.slope[lost], roots.status[lost])
        both = near.where(near.status == Status.SOLVED, far)
        roots.l2[lost], roots.slope[lost], roots.status[lost] = both.l2, both.slope, both.status
    return roots


def _search(
    pairing: Pairing,
    l1: FloatArray,
    l2: FloatArray,
    extrema: bool = False,
    within: bool = False,
) -> Roots:
    """Give the root on the flanks among all that samples `l2` (samples, cases, 1) bracket, else the one least
    far off."""
    pinion = terms_of_one(pairing, l1, 0)
    l2, values, real = _sampled(pairing, pinion, l2)
    if extrema:
        l2, values, real = _with_extremum(pairing, pinion, l2, values, real)
    change = (np.signbit(values[:-1]) != np.signbit(values[1:])) & (real[:-1] | real[1:])
    rank = np.cumsum(change, axis=0, dtype=np.int8)
    count = rank[-1]
    if within:
        count = np.where((count > 0).all(axis=-1, keepdims=True), count, np.int8(0))
    best = Roots(*(np.full(l1.shape, fill) for fill in (np.nan, np.nan, np.int8(Status.OFF_FLANK))))
    column = np.arange(l1.size).reshape(l1.shape)
    margin, hits = np.full(l1.shape, -np.inf), np.zeros(l1.shape, dtype=int)
    for k in range(1, int(count.max(initial=0)) + 1):
        has = count >= k
        cell = np.minimum((rank < k).sum(axis=0), len(change) - 1) * l1.size + column
        low, high, f_low, f_high = (part.take(cell + side) for part in (l2, values) for side in (0, l1.size))
        start = low - f_low * (high - low) / (f_high - f_low)
        start = np.where(np.isfinite(start), start, 0.5 * (low + high))
        sought = _Search(low, high, f_high > f_low, start, np.ones(l1.shape), ~has)
        found = _newton(pairing, pinion, sought, FEW if within else NEWTON_LIMIT)
        lost = np.where(found.done, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
        root = Roots(found.l2, found.slope, lost)
        if count.max() > 1:
            l = np.array((l1, root.l2))
            margins = limit_margins(pairing, l, *axial_and_radius(pairing, meet(pairing, l)))
            depth = np.where(has, margins.min(axis=0), -np.inf)
            hits += depth >= 0.0
            has = has & ((depth > margin) | (k == 1))
            margin = np.where(has, depth, margin)
        best = root.where(has, best)
    status = np.where(hits > 1, np.int8(Status.SEVERAL_CONTACTS), best.status)
    status = np.where((count == 0) & ~real.all(axis=0), np.int8(Status.NO_COMMON_NORMAL), status)
    known = status == Status.SOLVED
    return Roots(np.where(known, best.l2, np.nan), np.where(known, best.slope, np.nan), status)
