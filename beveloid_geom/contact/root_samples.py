"""Samples of F over l2 for given l1, and the brackets of its roots between them.

F changes sign between two samples, or between a sample and a pole at n_x = 0, where F diverges with a known
sign. Where an extremum of F is nearly zero, `with_extremum` adds samples that separate two roots next to it.
The roots are computed in `roots`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..support.frozen_arrays import cached
from .equation import gap_of, guarded_gap
from .flank_pair import FlankPair, MemberTerms, terms_of_one

SAMPLE_POSITIONS = np.linspace(0.0, 1.0, 7)[:, None, None]
"""Relative positions of the samples in a range of l2."""


@dataclass(frozen=True, eq=False)
class RootSamples:
    """Samples of F over l2.

    `pinion` terms; `l2` and F (`values`) in mm; `real`: which samples have a common normal, each (samples,
    cases, positions); `change`: between which samples F changes sign, (samples - 1, cases, positions).
    """

    pinion: MemberTerms
    l2: FloatArray
    values: FloatArray
    real: Mask
    change: Mask

    def cases(self, index: Integers) -> RootSamples:
        """Return the samples of the cases `index`."""
        pinion = self.pinion.pick(index, slice(None))
        l2, values, real, change = self.l2, self.values, self.real, self.change
        return RootSamples(pinion, l2[:, index], values[:, index], real[:, index], change[:, index])

    def first(self) -> Bracket:
        """Return the bracket of the first change of sign of each position; undefined where there is none."""
        return self.between(self.change.argmax(axis=0))

    def of_main_direction(self) -> RootSamples:
        """Keep the changes in which F increases, or those in which it decreases: for each case the direction
        that more of its positions have, since along one curve the direction is constant.
        """
        rising = self.change & np.signbit(self.values[:-1])
        falling = self.change & ~rising
        # Direction of most changes of each case.
        rises = rising.any(axis=0).sum(axis=-1) >= falling.any(axis=0).sum(axis=-1)
        main_changes = np.where(rises[:, None], rising, falling)
        return self if (main_changes == self.change).all() else replace(self, change=main_changes)

    def preferring(self, low: FloatArray, high: FloatArray) -> RootSamples:
        """Keep the changes between `low` and `high` (cases, 1) in l2, mm, at positions that have such
        changes.
        """
        if (self.change.sum(axis=0) < 2).all():
            return self
        within = self.change & (self.l2[1:] > low) & (self.l2[:-1] < high)
        return replace(self, change=np.where(within.any(axis=0), within, self.change))

    def rough(self) -> FloatArray:
        """Return l2 (cases, positions), mm, near the first change, NaN without one."""
        return np.where(self.change.any(axis=0), self.first().start, np.nan)

    def between(self, place: Integers, column: Integers | None = None) -> Bracket:
        """Return the brackets from the samples `place` to the next.

        Without `column`, `place` is (cases, positions). Otherwise `place` may have any shape, and `column`
        has the number case * positions + position of each bracket.
        """
        if column is None:
            column = np.arange(place.size).reshape(place.shape)
        index = _four_samples(len(self.values))[:, place] * self.values[0].size + column
        return bracket_of(self.l2.take(index), self.values.take(index))


@cached(32)
def _four_samples(count: int) -> Integers:
    """Return the numbers of four samples (4, count - 1) for each interval between `count` samples: both ends
    of the interval and two neighbours.
    """
    rows = []
    for place in range(count - 1):
        first = min(max(place - 1, 0), count - 4)
        others = [k for k in range(first, first + 4) if k not in (place, place + 1)]
        rows.append([place, place + 1, *others])
    return np.array(rows).T


@dataclass(frozen=True, eq=False)
class Bracket:
    """Intervals [low, high] of l2, mm, with different signs of F at their ends; (cases, positions).

    `rising`: whether F increases; `start`: estimate of the root; `points`: four samples of l2, mm;
    `differences`: F at the first sample, and the divided differences of F over the first two, three and four.
    """

    low: FloatArray
    high: FloatArray
    rising: Mask
    start: FloatArray
    points: list[FloatArray]
    differences: list[FloatArray]


def bracket_of(x: FloatArray, f: FloatArray) -> Bracket:
    """Return the bracket [x_0, x_1] of four samples of F, (4, cases, positions).

    The estimate is the root of the cubic through the samples, by two Newton steps from the root of the chord.
    Next to a pole, where the cubic fails, it is the root of the chord or the middle.
    """
    low, high, third, _ = x
    # Divided differences of the cubic.
    first = (f[1:] - f[:-1]) / (x[1:] - x[:-1])
    second = (first[1:] - first[:-1]) / (x[2:] - x[:-2])
    cubic = (second[1] - second[0]) / (x[3] - low)
    chord = start = low - f[0] / first[0]
    for _ in range(2):
        a, b = start - low, start - high
        bend = second[0] + (start - third) * cubic
        rise = first[0] + b * bend
        start = start - (f[0] + a * rise) / (rise + a * (bend + b * cubic))
    for other in (chord, 0.5 * (low + high)):
        within = (start >= low) & (start <= high)
        if within.all():
            break
        start = np.where(within, start, other)
    return Bracket(low, high, f[1] > f[0], start, list(x), [f[0], first[0], second[0], cubic])


def root_samples(pairing: FlankPair, l1: FloatArray, bounds: FloatArray, shares: FloatArray) -> RootSamples:
    """Return samples of F at every l1 and at relative positions between two bounds of l2.

    Parameters
    ----------
    pairing : FlankPair
        Pairs of flanks (cases).
    l1 : ndarray, shape (cases, positions)
        Pinion flank parameters, mm.
    bounds : ndarray, shape (2, cases, 1)
        Bounds of l2, mm.
    shares : ndarray
        Relative positions between the bounds, from 0 to 1.

    Returns
    -------
    RootSamples
    """
    return equation_samples(
        pairing, terms_of_one(pairing, l1, 0), bounds[0] + shares * (bounds[1] - bounds[0])
    )


def equation_samples(
    pairing: FlankPair, pinion: MemberTerms, l2: FloatArray, gear: MemberTerms | None = None
) -> RootSamples:
    """Return samples of F at l2 (mm) from the terms of the pinion, and of the gear if they are known."""
    met = gap_of(pairing, pinion, terms_of_one(pairing, l2, 1) if gear is None else gear)
    values, real = guarded_gap(pairing, met), ~np.isnan(met.gap)
    return RootSamples(pinion, np.broadcast_to(l2, values.shape), values, real, _changes(values, real))


def _changes(values: FloatArray, real: Mask) -> Mask:
    """Return between which samples F changes sign and is real on at least one side."""
    below = np.signbit(values)
    return np.asarray((below[:-1] != below[1:]) & (real[:-1] | real[1:]))


def with_extremum(pairing: FlankPair, samples: RootSamples) -> RootSamples:
    """Return the samples with a few more near the extremum of F that is closest to zero without crossing it:
    two roots may be hidden between its neighbouring samples.
    """
    # Number of samples added next to an extremum of F near zero.
    extremum_samples = 6
    pinion, l2, values, real = samples.pinion, samples.l2, samples.values, samples.real
    for turn in range(extremum_samples):
        left, middle, right = values[:-2], values[1:-1], values[2:]
        # Samples nearest to zero without a change of sign to either side.
        towards = (np.abs(middle) <= np.minimum(np.abs(left), np.abs(right))) & (left * middle > 0.0)
        towards &= (middle * right > 0.0) & real[1:-1]
        if not towards.any():
            break
        best = np.where(towards, np.abs(middle), np.inf).argmin(axis=0)[None] + 1
        x0, x1, x2 = (np.take_along_axis(l2, best + k, axis=0)[0] for k in (-1, 0, 1))
        f0, f1, f2 = (np.take_along_axis(values, best + k, axis=0)[0] for k in (-1, 0, 1))
        rise, fall = (f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1)
        vertex = 0.5 * (x0 + x1) - 0.5 * rise * (x2 - x0) / (fall - rise)
        # Next to a pole the parabola fails: bisect, first towards the pole.
        pole = np.isinf(f0) | np.isinf(f2)
        halfway = 0.5 * (x1 + np.where(np.isinf(f2) == (turn % 2 == 0), x2, x0))
        usable = (vertex > x0) & (vertex < x2) & (vertex != x1) & ~pole
        vertex = np.where(usable, vertex, halfway)
        met = gap_of(pairing, pinion, terms_of_one(pairing, vertex, 1))
        new = (vertex, guarded_gap(pairing, met), ~np.isnan(met.gap))
        # Insert the new sample.
        order = np.argsort(np.concatenate((l2, vertex[None])), axis=0, kind="stable")
        l2, values, real = (
            np.take_along_axis(np.concatenate((known, added[None])), order, axis=0)
            for known, added in zip((l2, values, real), new, strict=True)
        )
    return RootSamples(pinion, l2, values, real, _changes(values, real))
