"""Segments of a mesh cycle and the sampled first contacts from which they are computed.

The curve of first contacts over a pitch consists of smooth segments. On each of them, the contact is of one
kind: one tooth pair, with the same edges, on flank or fillet. A segment is stored as Chebyshev polynomials of
the pinion roll."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import Limit
from ...support.array_records import joined
from ...support.chebyshev import evaluate, greatest, polynomials
from ..engagement import Engagement
from ..search.earliest_contact import Found

SAMPLES_PER_PITCH = 24
"""Pinion rolls per pitch at which first contacts are searched."""
SEGMENT_DEGREE = 20
"""Degree of the polynomials."""
EXTRAPOLATION_HALF_LENGTHS = 1.2
"""Half-lengths from its middle up to which the polynomials of a segment are evaluated."""
QUANTITY_COUNT = 5
"""Quantities of a segment, mm: clearance f from the conjugate gear roll; profile coordinate s and distance z
from mid-face of the contact on the pinion (s1, z1) and on the gear (s2, z2)."""


@dataclass(frozen=True, eq=False)
class CycleSegments:
    """Segments (n,), in order of case and roll.

    Attributes
    ----------
    case : ndarray of int, shape (n,)
        Number of the design in the batch.
    low, high : ndarray, shape (n,)
        First and last pinion roll, rad.
    coefficients : ndarray, shape (5, n, SEGMENT_DEGREE + 1)
        Chebyshev coefficients of f, s1, z1, s2, z2, mm.
    pair : ndarray of int, shape (n,)
    limit : ndarray of int, shape (2, n)
    on_fillet : ndarray of bool, shape (2, n)
        Tooth pair, edges and fillets as in `FirstContact`.
    reliefs : ndarray of int, shape (n,)
        Reliefs on which the contact lies, as bits in the order of `Engagement.past_reliefs`.
    """

    case: Integers
    low: FloatArray
    high: FloatArray
    coefficients: FloatArray
    pair: Integers
    limit: Codes
    on_fillet: Mask
    reliefs: Integers

    def pick(self, index: Integers | Mask) -> CycleSegments:
        """Return the segments `index`."""
        rows = (x[:, index] if x.ndim > 1 else x[index] for x in vars(self).values())
        return CycleSegments(*rows)

    def number(self, engagement: Engagement, case: Integers, roll: FloatArray) -> Integers:
        """Return the numbers of the segments that contain the rolls (n,), rad, of the cases (n,)."""
        begins = order_of(engagement, self.case, self.low)
        return np.maximum(np.searchsorted(begins, order_of(engagement, case, roll), side="right") - 1, 0)

    def rolls(self, places: FloatArray) -> FloatArray:
        """Return rolls (n, k), rad, at `places` (k,) between -1, the first roll of a segment, and 1, the
        last."""
        return rolls_between(self.low, self.high, places)

    def values(self, index: Integers | slice, roll: FloatArray) -> FloatArray:
        """Return all quantities (rows, n, k) of the segments `index` (n,) at rolls (n, k), rad."""
        with np.errstate(invalid="ignore", divide="ignore"):
            place = _places(self.low[index, None], self.high[index, None], roll)
        return evaluate(self.coefficients[:, index], np.where(np.isnan(place), 0.0, place))

    def values_at(self, index: Integers, roll: FloatArray, rows: int | None = None) -> FloatArray:
        """Return the first `rows` quantities (rows, n), or all, of the segments `index` (n,) at rolls
        (n,), rad."""
        powers = polynomials(_places(self.low[index], self.high[index], roll), SEGMENT_DEGREE)
        return np.array([(row.T[:, index] * powers).sum(axis=0) for row in self.coefficients[:rows]])


def _places(low: FloatArray, high: FloatArray, roll: FloatArray) -> FloatArray:
    """Return the places of rolls, -1 at `low` and 1 at `high`, limited to the range of the polynomials."""
    place = np.maximum((2.0 * roll - (low + high)) / (high - low), -EXTRAPOLATION_HALF_LENGTHS)
    return np.minimum(place, EXTRAPOLATION_HALF_LENGTHS)


@dataclass(frozen=True, eq=False)
class Samples:
    """First contacts (n,) of the cases at pinion rolls (rad), in order of case and roll.

    `cut`: whether a new segment begins at the sample even if the kind of contact is the same."""

    case: Integers
    roll: FloatArray
    cut: Mask
    contacts: Found

    def pick(self, index: Integers | Mask) -> Samples:
        """Return the samples `index`."""
        return Samples(self.case[index], self.roll[index], self.cut[index], self.contacts.pick(index))

    def ends(self, case: Integers) -> tuple[FloatArray, FloatArray]:
        """Return the first and last sampled rolls (n,), rad, of the cases (n,)."""
        first, after = np.searchsorted(self.case, case), np.searchsorted(self.case, case, side="right")
        return self.roll[first], self.roll[after - 1]

    def and_also(self, more: Samples) -> Samples:
        """Return both sets of samples, in order of case and roll."""
        both = Samples(
            np.append(self.case, more.case),
            np.append(self.roll, more.roll),
            np.append(self.cut, more.cut),
            joined((self.contacts, more.contacts)),
        )
        return both.pick(np.lexsort((both.roll, both.case)))


def samples_of(case: Integers, roll: FloatArray, contacts: Found) -> Samples:
    """Return first contacts as samples at which no segment is cut.

    Parameters
    ----------
    case : ndarray of int, shape (n,)
    roll : ndarray, shape (n,)
        rad.
    contacts : Found
        First contacts (n,).

    Returns
    -------
    Samples
    """
    return Samples(case, roll, np.zeros(case.size, dtype=bool), contacts)


def holding(limit: Codes) -> Mask:
    """Return which limits are active.

    Parameters
    ----------
    limit : ndarray of int, shape (2, n)
        Codes of `Limit`, -1 for none.

    Returns
    -------
    ndarray of bool, shape (8, n)
    """
    return np.asarray((np.arange(len(Limit))[:, None, None] == limit).any(axis=1))


def concatenated(parts: list[CycleSegments]) -> CycleSegments:
    """Concatenate segments.

    Parameters
    ----------
    parts : list of CycleSegments

    Returns
    -------
    CycleSegments
    """
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return CycleSegments(*(np.concatenate(column, axis=min(1, column[0].ndim - 1)) for column in columns))


def tails_of(segments: CycleSegments) -> FloatArray:
    """Return the sizes of the trailing coefficients.

    Parameters
    ----------
    segments : CycleSegments

    Returns
    -------
    ndarray, shape (QUANTITY_COUNT, n)
        mm.
    """
    # Number of trailing coefficients by which convergence is judged.
    tail_coefficients = 4
    return np.asarray(np.abs(segments.coefficients[:QUANTITY_COUNT, :, -tail_coefficients:]).max(axis=2))


def rolls_between(low: FloatArray, high: FloatArray, nodes: FloatArray) -> FloatArray:
    """Return rolls at relative places of intervals.

    Parameters
    ----------
    low, high : ndarray, shape (n,)
        rad.
    nodes : ndarray, shape (k,)
        Places from -1 to 1.

    Returns
    -------
    ndarray, shape (n, k)
        rad.
    """
    return np.asarray(0.5 * ((low + high)[:, None] + (high - low)[:, None] * nodes))


def order_of(engagement: Engagement, case: Integers, roll: FloatArray) -> FloatArray:
    """Return numbers that increase with case and roll.

    Parameters
    ----------
    engagement : Engagement
        Beginning and span of each case.
    case : ndarray of int, shape (n,)
    roll : ndarray, shape (n,)
        rad.

    Returns
    -------
    ndarray, shape (n,)
    """
    turned = (roll - engagement.roll[case]) / (engagement.span * engagement.pitch[0])
    return np.asarray(case + 0.5 * np.clip(turned, 0.0, 1.0))


def extremes(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute maxima and minima of Chebyshev series on [-1, 1].

    Parameters
    ----------
    series : ndarray, shape (1, n, SEGMENT_DEGREE + 1)

    Returns
    -------
    most, least : ndarray, shape (n,)
    """
    both = np.concatenate((series, -series), axis=1)
    end = np.ones((both.shape[1], 1))
    most, least = evaluate(both, greatest(both[0], -end, end))[0, :, 0].reshape(2, -1)
    return most, -least


def changes_of(segments: CycleSegments, cases: int) -> tuple[FloatArray, Mask]:
    """Return the rolls at which the kind of contact changes.

    Parameters
    ----------
    segments : CycleSegments
    cases : int

    Returns
    -------
    changes : ndarray, shape (cases, k)
        rad, padded with NaN.
    hand_over : ndarray of bool, shape (cases, k)
        Whether the tooth pair changes.
    """
    label = np.stack((segments.pair, *segments.limit, *segments.on_fillet))
    changed = (label[:, 1:] != label[:, :-1]).any(axis=0)
    inner = np.flatnonzero((segments.case[1:] == segments.case[:-1]) & changed)
    case = segments.case[inner]
    count = np.bincount(case, minlength=cases)
    column = np.arange(inner.size) - (np.cumsum(count) - count)[case]
    most = int(count.max(initial=0))
    changes, hand_over = np.full((cases, most), np.nan), np.zeros((cases, most), dtype=bool)
    changes[case, column] = segments.high[inner]
    hand_over[case, column] = segments.pair[inner] != segments.pair[inner + 1]
    return changes, hand_over


def converged(engagement: Engagement, segments: CycleSegments, tolerances: FloatArray) -> Mask:
    """Return which polynomials have converged.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments
    tolerances : ndarray, shape (QUANTITY_COUNT,)
        Largest trailing coefficients: of f relative to the lever, of the positions relative to the tooth
        depth. With `engagement.line_contact`, the positions are uncertain, and their limit is at least 1e-3.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    line_tolerance = 1e-3
    most = tolerances.copy()
    if engagement.line_contact:
        most[1:] = np.maximum(most[1:], line_tolerance)
    depth = engagement.pinion.tip - engagement.pinion.root
    sizes = np.array((engagement.lever, *[depth] * (QUANTITY_COUNT - 1)))
    return np.asarray((tails_of(segments) <= (most * sizes)[:, None]).all(axis=0))
