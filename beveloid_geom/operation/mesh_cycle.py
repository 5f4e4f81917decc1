"""Mesh cycle: transmission error, hand-overs and edge contacts of a pair in operation.

`first_contact` gives the gear roll for each pinion roll, whichever tooth, flank or edge touches. This curve
is periodic with the pinion's pitch. It consists of smooth segments, each a polynomial of the pinion roll
(`cycle.cycle_segments`), so that it is known at every roll. Mean, extremes and Fourier coefficients are
computed from the segments and are not affected by kinks.

1. Search first contacts at SAMPLES_PER_PITCH + 1 rolls, and fit segments through them (`cycle.segment_fit`).
2. Compare the segments with first contacts at other rolls, with their neighbours, and with contacts that are
   followed between the samples (`cycle.missed_contacts`).
3. Where the comparison fails, search first contacts at more rolls, divide the segments, and repeat from the
   fit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Integers, Mask
from ..design.arguments import require_design, require_integers
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import FirstStatus
from ..support.array_repr import html_table, short_repr
from ..support.chebyshev import evaluate, polynomials, with_derivative
from ..support.frozen_arrays import cached
from .cycle.cycle_segments import CycleSegments, Samples, changes_of, extremes, samples_of
from .cycle.segment_search import first_contact_segments, pitch_rolls
from .engagement import Engagement, engagement_of, pitch_point_roll
from .first_contact import FirstContact, first_contact, result_of
from .search.earliest_contact import Found, Grids, Numbered, found_with_others, grids_of, in_step

Waves: TypeAlias = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class MeshCycle:
    """One mesh cycle of a design, from the pinion roll `start` over one pitch; batch axes lead.

    Attributes
    ----------
    design : Design
    flank : {'right', 'left'}
    start : ndarray
        First pinion roll, rad.
    pitch : float
        Angular pitch of the pinion, rad.
    changes : ndarray, shape (..., k)
        Rolls inside the cycle at which the tooth pair, the touching edges, or the members that touch with
        their fillet change; rad, ascending, padded with NaN. `segments` has further ends, at which all these
        remain the same. On measured flanks, the first derivative of the transmission error jumps at such an
        end if the contact moves to another place of the same flanks. The second derivative jumps if the
        contact passes the beginning of a relief.
    hand_over : ndarray of bool, shape (..., k)
        Whether another tooth pair comes into contact at these rolls; False where several pairs are in contact
        at the same time (`along_lines`).
    mean, peak_to_peak : ndarray
        Mean and peak-to-peak value of the transmission error, rad, positive where the gear is ahead.
    harmonics : ndarray of complex, shape (..., n)
        Fourier coefficients at 1 ... n times the mesh frequency. Their absolute values are the amplitudes,
        rad:

            error(roll) = mean + Re sum_k harmonics_k exp(2 pi i k (roll - start) / pitch).
    edge_share : ndarray
        Share of the cycle in which edges touch.
    lost : ndarray of bool
        Whether a position of the cycle has no first contact, or the position of the unmodified pair (the
        conjugate phase) is unknown. Then the results are NaN and there are no changes.
    status : ndarray of int
        Codes of `FirstStatus`: the reason why a cycle is lost.
    segments : CycleSegments
        The curve.
    engagement : Engagement
        One position for each case: the beginning of its cycle.
    phase : ndarray, shape (cases,)
        Gear roll plus N1/N2 pinion roll of the unmodified pair (conjugate phase), rad.
    """

    __repr__ = short_repr
    _repr_html_ = html_table

    design: Design = field(repr=False)
    flank: str
    start: FloatArray
    pitch: float
    changes: FloatArray
    hand_over: Mask
    mean: FloatArray
    peak_to_peak: FloatArray
    harmonics: Waves
    edge_share: FloatArray
    lost: Mask
    status: Integers
    segments: CycleSegments = field(repr=False)
    engagement: Engagement = field(repr=False)
    phase: FloatArray = field(repr=False)

    @property
    def along_lines(self) -> Mask:
        """Return whether unmodified flanks touch along lines over the complete cycle.

        Several tooth pairs are then in contact at once. First contacts are the points at which the path of
        contact crosses the lines of the pair that came into mesh last."""
        if self.engagement.lines is None:
            return np.zeros(self.start.shape, dtype=bool)
        known = np.isfinite(self.engagement.lines[0, 0]).reshape(self.start.shape)
        return np.asarray(known & (self.peak_to_peak < 1e-12))

    def at(self, pinion_roll: ArrayLike) -> FirstContact:
        """Return first contacts at any pinion rolls.

        Parameters
        ----------
        pinion_roll : array_like, shape (batch, ...)
            rad. Rolls outside the cycle are shifted by full pitches.

        Returns
        -------
        FirstContact
            Results in the shape of `pinion_roll`, computed from the segments, or by a search if a `status` is
            not SOLVED.

        Raises
        ------
        ValueError
            For rolls that are not finite or of another shape.
        """
        roll = float64_of("pinion_roll", pinion_roll)
        shape = self.start.shape
        if roll.shape[: len(shape)] != shape:
            raise ValueError(f"pinion_roll must have a shape that begins with {shape}, got {roll.shape}")
        if not np.isfinite(roll).all():
            raise ValueError("pinion_roll must contain finite numbers")
        if (self.status != FirstStatus.SOLVED).any():
            first = first_contact(self.design, self.flank, roll.reshape(*shape, -1))
            return first.shaped(*roll.shape)
        case = np.arange(self.start.size).repeat(roll.size // max(1, self.start.size))
        segment, turns, values = self.located(case, roll.ravel())
        contacts = Found(
            f=values[0],
            place=values[1:3],
            meeting=values[3:5],
            limit=self.segments.limit[:, segment],
            pair=self.segments.pair[segment] - turns,
            status=np.full(case.size, FirstStatus.SOLVED, dtype=np.int8),
        )
        return result_of(self.engagement.at(case, roll.ravel()), self.phase[case], contacts, roll.shape)

    def gear_roll(self, pinion_roll: FloatArray, case: int = 0) -> FloatArray:
        """Return the gear rolls (rad) of one case at pinion rolls (rad) of any shape."""
        if self.status.flat[case] != FirstStatus.SOLVED:
            return self.at(pinion_roll).gear_roll
        roll = np.ravel(pinion_roll)
        return np.asarray(self.motion(case)(roll, roll)[0].reshape(np.shape(pinion_roll)))

    def motion(self, case: int = 0) -> Callable[[FloatArray, FloatArray], FloatArray]:
        """Return a function that computes gear roll (rad) and rate over the pinion roll, (2, n), of a
        SOLVED case at pinion rolls (n,), rad. Its second argument, rolls (n,), selects the side at
        changes of the contact."""
        segment = np.flatnonzero(self.segments.case == case)
        start, pitch = self.engagement.roll[case], self.pitch
        low, high = self.segments.low[segment] - start, self.segments.high[segment] - start
        series, ratio = self.phase_series()[segment], self.engagement.pitch[1] / self.engagement.pitch[0]
        last = max(1, np.flatnonzero((np.abs(series) > 2e-16).any(axis=0))[-1])
        both = with_derivative(series[None, :, : last + 1]).transpose(2, 0, 1).copy()

        def at(roll: FloatArray, towards: FloatArray) -> FloatArray:
            """Return gear roll and rate."""
            aside = np.clip(0.25 * (towards - roll), -1e-7, 1e-7)
            turned = np.remainder(roll + aside - start, pitch)
            index = np.maximum(low.searchsorted(turned, side="right") - 1, 0)
            length = (high - low)[index]
            powers = polynomials(2.0 * (turned - aside - low[index]) / length - 1.0, len(both) - 1)
            phase, rate = (both.take(index, axis=2) * powers[:, None]).sum(axis=0)
            return np.array((phase - ratio * roll, 2.0 * rate / length - ratio))

        return at

    def phase_series(self) -> FloatArray:
        """Return Chebyshev coefficients (segments, degree + 1) of gear roll plus N1/N2 pinion roll, rad."""
        engagement = self.engagement
        series: FloatArray = engagement.gear.sigma / engagement.lever * self.segments.coefficients[0]
        series[:, 0] += self.engagement.phase[self.segments.case]
        return series

    def located(
        self, case: Integers, roll: FloatArray, rows: int | None = None
    ) -> tuple[Integers, Integers, FloatArray]:
        """Return the segments (n,) at rolls (n,), rad, of the cases (n,), the pitches by which the rolls
        are outside the cycle, and the values of `CycleSegments.values_at`, (rows, n)."""
        turns = np.floor((roll - self.engagement.roll[case]) / self.pitch).astype(np.int64)
        segment = self.segments.number(self.engagement, case, roll - turns * self.pitch)
        return segment, turns, self.segments.values_at(segment, roll - turns * self.pitch, rows)


def mesh_cycle(design: Design, flank: str = "right", harmonics: int = 10) -> MeshCycle:
    """Compute the transmission error of one mesh cycle, with hand-overs and edge contacts.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.
    flank : {'right', 'left'}
    harmonics : int
        Number of Fourier coefficients.

    Returns
    -------
    MeshCycle
        Evaluated at any roll by `MeshCycle.at`.

    Raises
    ------
    ValueError
        If a field of a member is an array, or for fewer than one harmonic.

    References
    ----------
    Method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> cycle = bg.mesh_cycle(bg.builtin_design("ni-2017").with_parabola(0.001, -0.001))
    >>> bool(cycle.lost)
    False
    >>> print(f"{cycle.peak_to_peak:.3e} rad")
    8.779e-06 rad
    """
    require_design(design)
    require_integers(harmonics=harmonics)
    return cycle_and_pairs(design, flank, harmonics, False)[0]


def cycle_and_pairs(
    design: Design, flank: str, harmonics: int, each: bool = True
) -> tuple[MeshCycle, Grids, Samples, Numbered]:
    """Compute the mesh cycle and the contacts of single tooth pairs.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}
    harmonics : int
    each : bool
        Whether the contacts of single tooth pairs are computed. For a single design, they always are.

    Returns
    -------
    cycle : MeshCycle
    grids : Grids
        Scan points.
    samples : Samples
        First contacts from which the cycle was computed.
    alone : Numbered
        First contact of each single tooth pair whose smallest scanned clearance is at most 0.25 modules above
        that of the first pair, with the numbers of their samples.
    """
    if harmonics < 1:
        raise ValueError(f"harmonics must be at least 1, got {harmonics}")
    find = _solved if design.batch_shape else _cached_solution
    solution = find(design, flank, each or not design.batch_shape)
    start, phase, status = solution.start, solution.phase, solution.status
    engagement, segments, shape = solution.engagement, solution.segments, start.shape
    lost = (status != FirstStatus.SOLVED) | np.isnan(phase)
    waves, swing, edges = _sums(engagement, segments, harmonics)
    waves[lost], swing[lost], edges[lost] = np.nan, np.nan, np.nan
    changes, hand_over = changes_of(segments, start.size)
    cycle = MeshCycle(
        design=design,
        flank=flank,
        start=start,
        pitch=engagement.pitch[0],
        changes=changes.reshape(*shape, -1),
        hand_over=hand_over.reshape(*shape, -1),
        mean=waves[:, 0].real.reshape(shape),
        peak_to_peak=swing.reshape(shape),
        harmonics=(2.0 * waves[:, 1:]).astype(np.complex128).reshape(*shape, harmonics),
        edge_share=edges.reshape(shape),
        lost=lost.reshape(shape),
        status=status.reshape(shape),
        segments=segments,
        engagement=engagement,
        phase=phase,
    )
    cycle = replace(cycle, hand_over=cycle.hand_over & ~cycle.along_lines[..., None])
    return cycle, solution.grids, solution.samples, solution.alone


@dataclass(frozen=True, eq=False)
class _Solution:
    """Segments and `status` of mesh cycles that begin at the rolls `start` (rad); the `engagement` and the
    conjugate `phase`; and scan points, samples and contacts of single tooth pairs as in `cycle_and_pairs`."""

    start: FloatArray
    engagement: Engagement
    phase: FloatArray
    segments: CycleSegments
    status: Integers
    grids: Grids
    samples: Samples
    alone: Numbered


def _solved(design: Design, flank: str, each: bool) -> _Solution:
    start = np.broadcast_to(pitch_point_roll(design, flank), design.batch_shape)
    engagement, phase = engagement_of(design, flank, start[..., None], start)
    grids = grids_of(engagement, design, flank)
    if np.isnan(phase).any():
        engagement = in_step(engagement, np.isnan(phase)[:, None], grids)
    case, roll = pitch_rolls(engagement)
    first, near, alone = found_with_others(engagement.at(case, roll), grids, each=each)
    samples = samples_of(case, roll, first)
    near_samples = samples_of(case[near[0]], roll[near[0]], near[1])
    segments, status = first_contact_segments(engagement, grids, samples, near_samples)
    return _Solution(start, engagement, phase, segments, status, grids, samples, alone)


_cached_solution = cached(16)(_solved)
"""Solutions of single designs: transmission error, contact ratio and backlash need the same ones."""


@cached(1)
def _gauss_points() -> tuple[FloatArray, FloatArray]:
    return leggauss(96)


def _sums(
    engagement: Engagement, segments: CycleSegments, harmonics: int
) -> tuple[Waves, FloatArray, FloatArray]:
    """Return for each case the Fourier coefficients (cases, harmonics + 1) of the transmission error, its
    peak-to-peak value (rad), and the share of edge contacts."""
    # A positive clearance means that the gear is behind.
    cases, errors = engagement.roll.size, -segments.coefficients[:1] / engagement.lever
    points, weights = _gauss_points()
    length = (segments.high - segments.low) / engagement.pitch[0]
    share = (segments.rolls(points) - engagement.roll[segments.case, None]) / engagement.pitch[0]
    turns = np.ones((harmonics + 1, *share.shape), dtype=np.complex128)
    np.cumprod(np.broadcast_to(np.exp(-2.0j * np.pi * share), turns[1:].shape), axis=0, out=turns[1:])
    waves = np.zeros((cases, harmonics + 1), dtype=np.complex128)
    # einsum instead of BLAS, which would start threads for a complex product.
    sums = np.einsum("...k,k", turns * evaluate(errors, points)[0], weights)
    np.add.at(waves, segments.case, (0.5 * length * sums).T)
    high, low, edges = np.full(cases, -np.inf), np.full(cases, np.inf), np.zeros(cases)
    for extreme, best, ends in zip((np.maximum, np.minimum), (high, low), extremes(errors), strict=True):
        extreme.at(best, segments.case, ends)
    np.add.at(edges, segments.case, np.where(segments.limit[0] >= 0, length, 0.0))
    return waves, high - low, np.minimum(edges, 1.0)
