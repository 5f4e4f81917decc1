"""Roots l2 of the one equation F(l1, l2) = 0 for given l1.

`solve_gear_parameter` samples F over l2 (`RootSamples`) and brackets all changes of sign. Some steps with the
slope of the polynomial through the last five points usually reach the root. If they do not, Newton's method
with the exact slope follows inside the bracket, which is halved whenever a step leaves it. Where n_x
vanishes, F diverges with a known sign, so that a root between the last sample and this pole is bracketed too.
Where an extremum of F is nearly zero, more samples are taken to detect two roots next to it. If there are
several roots, the one on the flanks is returned; if two are on the flanks, the position is marked.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray, Mask
from ..status import Status
from .equation import (
    ContactTerms,
    axial_and_radius,
    edge_margins,
    gap_and_slope,
    gap_of,
    gap_tolerance,
    guarded_gap,
    joined_terms,
    limit_margins,
    meet,
)
from .flank_pair import FlankPair, MemberTerms, terms_of_one
from .root_samples import Bracket, RootSamples, equation_samples, with_extremum

NEWTON_MAX_STEPS = 60
"""Maximum number of Newton steps, most of which only bisect."""
LAST_STEP_DEPTHS = 1e-6
"""Step, relative to the flank depth, below which the iteration ends: the error is about its square. The
callers check F afterwards.
"""


@dataclass(frozen=True, eq=False)
class Roots:
    """Roots l2 (mm), the slope dF/dl2 there, and the Status, each (cases, positions); and the terms of F at
    all of them, if these are known.
    """

    l2: FloatArray
    slope: FloatArray
    status: Codes
    met: ContactTerms | None = None

    def where(self, mask: Mask, other: Roots) -> Roots:
        """Return these roots where the mask is true, elsewhere the other ones."""
        return Roots(
            np.where(mask, self.l2, other.l2),
            np.where(mask, self.slope, other.slope),
            np.where(mask, self.status, other.status),
        )


@dataclass(frozen=True, eq=False)
class _Search:
    """Roots being computed, (cases, positions): brackets [low, high] in l2 (mm), whether F is `rising` in
    them, the present l2 and slope of Newton's method, and which are `done`.
    """

    low: FloatArray
    high: FloatArray
    rising: Mask
    l2: FloatArray
    slope: FloatArray
    done: Mask


def _newton(pairing: FlankPair, pinion: MemberTerms, search: _Search, passes: int) -> _Search:
    """Return the roots after Newton steps inside the brackets. Once fewer than half of the positions
    remain, they are solved separately.
    """
    low, high, l2, slope, done = search.low, search.high, search.l2, search.slope, search.done
    tolerance, enough = gap_tolerance(pairing), LAST_STEP_DEPTHS * (pairing.highest[1] - pairing.lowest[1])
    # Steps between two checks whether fewer than half of the positions remain.
    steps_together = 2
    for turn in range(passes):
        left = np.count_nonzero(~done)
        if left == 0:
            break
        if turn % steps_together == 0 and 2 * left < done.size:
            now = replace(search, low=low, high=high, l2=l2, slope=slope, done=done)
            return _newton_of_subset(pairing, pinion, now, passes - turn)
        # Evaluate, shrink the bracket, and step; bisect if the step leaves the bracket.
        gap, slope = gap_and_slope(pairing, pinion, l2)
        if np.isnan(gap).any():
            beyond = guarded_gap(pairing, gap_of(pairing, pinion, terms_of_one(pairing, l2, 1)))
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


def _newton_of_subset(pairing: FlankPair, pinion: MemberTerms, search: _Search, passes: int) -> _Search:
    """Return the roots after Newton steps for the positions that are not done, each as a separate case."""
    case, position = np.nonzero(~search.done)
    terms = pinion.pick(case, position, None)
    part = _Search(*(value[case, position, None] for value in vars(search).values()))
    result = _newton(pairing.cases(case), terms, part, passes)
    for name in ("l2", "slope", "done"):
        getattr(search, name)[case, position] = getattr(result, name)[:, 0]
    return search


def solve_gear_parameter(pairing: FlankPair, l1: FloatArray) -> Roots:
    """Return the roots l2 of F(l1, l2) = 0 at every `l1` (cases, positions), mm, with safeguards.

    Roots off the flanks are searched up to one flank depth beyond the gear flank and are reported as solved;
    nothing is clipped here.
    """
    low, high = pairing.lowest[1], pairing.highest[1]
    pinion = terms_of_one(pairing, l1, 0)
    roots = roots_in(pairing, l1, equation_samples(pairing, pinion, *pairing.near_gear))
    # Positions without a root near the flank are searched over three flank depths.
    lost = np.flatnonzero((roots.status != Status.SOLVED).any(axis=-1))
    if lost.size:
        # Samples of F in l2, in flank depths of the gear from its root.
        far_positions = np.linspace(-1.0, 2.0, 25)[:, None, None]
        part, far = pairing.cases(lost), (low + far_positions * (high - low))[:, lost]
        pinion = pinion.pick(lost, slice(None))
        far = roots_in(part, l1[lost], with_extremum(part, equation_samples(part, pinion, far)))
        near = Roots(roots.l2[lost], roots.slope[lost], roots.status[lost])
        both = near.where(near.status == Status.SOLVED, far)
        roots.l2[lost], roots.slope[lost], roots.status[lost] = both.l2, both.slope, both.status
    return roots


def sole_roots(pairing: FlankPair, l1: FloatArray) -> Roots | None:
    """Return the roots l2 at `l1` (cases, positions), mm, if each l1 has one root near the gear flank and no
    contact there with the other sign of n_x; None if this is not certain for all.
    """
    pinion, (l2, gear) = terms_of_one(pairing, l1, 0), pairing.near_gear
    values = gap_of(pairing, pinion, gear).gap
    # With the other sign of n_x, all terms except A_1 + A_2 change sign.
    other = np.signbit(2.0 * (pinion.level + gear.level) - values)
    real, below = ~np.isnan(values), np.signbit(values)
    change = below[1:] != below[:-1]
    if not real.all() or (other != other[0]).any() or (change.sum(axis=0) != 1).any():
        return None
    samples = RootSamples(pinion, np.broadcast_to(l2, values.shape), values, real, change)
    roots = _solved(pairing, pinion, samples.first(), change.any(axis=0), NEWTON_MAX_STEPS)
    return None if roots.status.any() else roots


def roots_in(
    pairing: FlankPair, l1: FloatArray, samples: RootSamples, passes: int = NEWTON_MAX_STEPS
) -> Roots:
    """Return one root l2 at every `l1` (cases, positions), mm, by at most `passes` Newton steps.

    Of all roots between the `samples`, it is the one on the flanks, or the one nearest to the flanks.
    """
    count = samples.change.sum(axis=0)
    roots = _solved(pairing, samples.pinion, samples.first(), count > 0, passes)
    if (count > 1).any():
        roots = _best_of_several(pairing, l1, samples, roots, passes)
    if roots.status.any():
        roots.status[(count == 0) & ~samples.real.all(axis=0)] = Status.NO_COMMON_NORMAL
    return roots


def _solved(pairing: FlankPair, pinion: MemberTerms, bracket: Bracket, has: Mask, passes: int) -> Roots:
    """Return the roots in the brackets of positions that `has` (cases, positions) selects; OFF_FLANK
    elsewhere.

    The slope is that of the polynomial through the last five points, the first of which are samples. Each
    step costs one evaluation of F, and two or three are sufficient where F is smooth. The remaining positions
    are solved by Newton's method.
    """
    enough = 2.0 * gap_tolerance(pairing)
    last = LAST_STEP_DEPTHS * (pairing.highest[1] - pairing.lowest[1])
    points, differences, l2 = bracket.points, bracket.differences, bracket.start
    slope, expected = differences[1], np.where(has, enough, np.inf)
    # Evaluations of F with slopes from previous points before Newton's method is used; fraction of F that may
    # remain after the last step.
    interpolation_steps, last_step_reduction = 4, 1e-3
    for turn in range(interpolation_steps):
        gear = terms_of_one(pairing, l2, 1)
        met = gap_of(pairing, pinion, gear)
        gap = met.gap
        settled = np.abs(gap) <= expected
        if turn == interpolation_steps - 1 or settled.all():
            break
        # Divided differences with the new point as the first, and the slope of their polynomial there.
        away, result = [l2 - x for x in points], [gap]
        for far, difference in zip(away, differences, strict=True):
            result.append((result[-1] - difference) / far)
        fresh = result[4]
        for far, difference in zip(away[2::-1], result[3:0:-1], strict=True):
            fresh = difference + far * fresh
        points, differences = [l2, *points[:3]], result[:4]
        slope = np.where(settled, slope, fresh)
        step = np.where(settled, 0.0, gap / slope)
        l2 = l2 - step
        # After a small step F is at rounding level, unless the slope was too steep.
        expected = np.where(
            np.abs(step) <= last, np.maximum(last_step_reduction * np.abs(gap), expected), expected
        )
    done = settled & has & (l2 >= bracket.low) & (l2 <= bracket.high)
    if done.all():
        status = np.zeros(done.shape, dtype=np.int8)
        return Roots(l2, slope, status, joined_terms(pinion, gear, met))
    start = np.where(done, l2, bracket.start)
    search = _Search(bracket.low, bracket.high, bracket.rising, start, slope.copy(), done | ~has)
    left = _newton(pairing, pinion, search, passes)
    status = np.where(left.done, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
    status = np.where(has, status, np.int8(Status.OFF_FLANK))
    known = status == Status.SOLVED
    return Roots(np.where(known, left.l2, np.nan), np.where(known, left.slope, np.nan), status)


def _best_of_several(
    pairing: FlankPair, l1: FloatArray, samples: RootSamples, roots: Roots, passes: int
) -> Roots:
    """Return the roots on the flanks, or nearest to them, where there are more than the first, `roots`.

    Each position with several brackets is treated as a separate case.
    """
    rank = np.cumsum(samples.change, axis=0, dtype=np.int8)
    case, position = np.nonzero(rank[-1] > 1)
    count, rank = rank[-1, case, position], rank[:, case, position]
    part, l1 = pairing.cases(case), l1[case, position, None]

    def depth_of(l2: FloatArray) -> FloatArray:
        """Return the distance of contacts from the nearest limit, mm, positive inside; -inf where l2 is not
        known.
        """
        l = np.array((l1, l2))
        z, radius = axial_and_radius(part, meet(part, l))
        depth = limit_margins(part, l, z, radius).min(axis=0)
        if part.edges:
            depth = np.minimum(depth, edge_margins(part, l, z).min(axis=0))
        return np.asarray(np.nan_to_num(depth, nan=-np.inf))

    pinion = samples.pinion.pick(case, position, None)
    at = case, position, None
    best = Roots(roots.l2[at], roots.slope[at], roots.status[at])
    margin = depth_of(best.l2)
    hits = (margin >= 0.0).astype(int)
    # Solve the second and further brackets and keep the root furthest inside the limits.
    for k in range(2, int(count.max()) + 1):
        has = (count >= k)[:, None]
        place = np.minimum((rank < k).sum(axis=0), len(rank) - 1)[:, None]
        bracket = samples.between(place, (case * roots.l2.shape[1] + position)[:, None])
        result = _solved(part, pinion, bracket, has, passes)
        depth = depth_of(result.l2)
        hits += depth >= 0.0
        better = depth > margin
        best, margin = result.where(better, best), np.where(better, depth, margin)
    l2, slope, status = roots.l2.copy(), roots.slope.copy(), roots.status.copy()
    solved = np.where(hits > 1, np.int8(Status.SEVERAL_CONTACTS), best.status)
    known = solved == Status.SOLVED
    l2[case, position], slope[case, position] = np.where(known, (best.l2, best.slope), np.nan)[..., 0]
    status[case, position] = solved[:, 0]
    return Roots(l2, slope, status)
