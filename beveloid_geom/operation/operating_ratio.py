"""Contact ratio in operation: mean number of tooth pairs in contact, edges and fillets included.

A tooth pair is in contact where it is the first of all to touch, or where its clearance is within a given
thickness of the first, for instance of a lubricant film or marking compound. The contact ratio is the length
of roll over which one pair is in contact, divided by the pitch. Unmodified pairs have the contact ratio of
Eq. 16. Rigid modified flanks touch in one point at a time and have the ratio 1 for zero thickness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..contact.path import contact_ratio
from ..design.arguments import require_design
from ..design.model import Design
from ..status import FirstStatus, RatioStatus
from ..support.array_repr import short_repr
from .cycle.cycle_segments import SAMPLES_PER_PITCH, CycleSegments, Samples, samples_of
from .cycle.missed_contacts import LATE_RAD
from .cycle.segment_fit import fitted
from .cycle.segment_search import in_order
from .engagement import Engagement
from .first_contact import FirstContact, result_of
from .mesh_cycle import MeshCycle, cycle_and_pairs
from .search.earliest_contact import TOGETHER_RAD, Found, Grids, found_at
from .search.search_task import OVERLAP

Label: TypeAlias = Callable[[Integers, FloatArray], Integers]
"""Labels (n, rolls) of the cases with the numbers (n,) at rolls (n, rolls), rad."""

SEARCH_PLACES, CUT_PLACE = np.array((0.1, 0.3, 0.45, 0.6, 0.8, 0.95)), 0.45
"""Places between two samples, or along a segment, at which a single tooth pair is searched where its segments
do not meet or do not agree with the samples; and the place at which such a segment is cut."""


@dataclass(frozen=True, eq=False)
class OperatingRatios:
    """Contact ratios in operation.

    Attributes
    ----------
    ratio : ndarray, shape (thicknesses, ...)
        NaN where not known.
    status : ndarray of int, shape (thicknesses, ...)
        Codes of `RatioStatus`.
    cycle : MeshCycle
    """

    __repr__ = short_repr

    ratio: FloatArray
    status: Codes
    cycle: MeshCycle


def operating_ratio(design: Design, flank: str = "right", thickness: float = 0.0) -> FloatArray:
    """Compute the contact ratio in operation.

    Parameters
    ----------
    design : Design
        The members must be single; pair and errors may be arrays.
    flank : {'right', 'left'}
    thickness : float
        Clearance along the normal, in addition to that of the first contact, within which a tooth pair counts
        as in contact, mm.

    Returns
    -------
    ndarray
        Of the batch shape; NaN where it is not known. `operating_ratios` returns the reason.

    Raises
    ------
    ValueError
        For members of arrays, and for a negative thickness.
    """
    return np.asarray(operating_ratios(design, flank, (thickness,)).ratio[0])


def operating_ratios(
    design: Design, flank: str, thicknesses: tuple[float, ...], harmonics: int = 1
) -> OperatingRatios:
    """Compute the contact ratio in operation for several thicknesses of a film. Tooth pairs within this
    clearance count as in contact. Several thicknesses take little more time than one.

    Parameters
    ----------
    design : Design
        The members must be single; pair and errors may be arrays.
    flank : {'right', 'left'}
    thicknesses : tuple of float
        mm.
    harmonics : int
        Number of Fourier coefficients of the mesh cycle.

    Returns
    -------
    OperatingRatios

    Raises
    ------
    ValueError
        For members of arrays, a negative thickness, and fewer than one harmonic.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> found = bg.operating_ratios(bg.builtin_design("ni-2017"), "right", (0.0, 0.006))
    >>> found.ratio.round(3)
    array([1.651, 2.283])
    """
    # Rolls at which a single tooth pair is compared with the first contact.
    rolls_per_pitch = 96
    require_design(design)
    for thickness in thicknesses:
        if not thickness >= 0.0:
            raise ValueError(f"thickness must be at least 0 mm, got {thickness}")
    cycle, grids, samples, each = cycle_and_pairs(design, flank, harmonics)
    shape, alone = design.batch_shape, _of_one_pair(cycle.engagement, samples, *each)
    lost, engagement = cycle.lost.reshape(-1), cycle.engagement
    ratio = np.full((len(thicknesses), lost.size), np.nan)
    status = np.full(ratio.shape, RatioStatus.NO_FIRST_CONTACT, dtype=np.int8)
    lines = np.flatnonzero(cycle.along_lines.reshape(-1) & ~lost)
    eq16 = contact_ratio(design, flank).reshape(-1) if lines.size else np.empty(0)
    useful = [size for size in thicknesses if size < engagement.period * engagement.lever]
    segments, followed = _segments_alone(cycle, grids, alone, np.array(useful or [0.0]))
    share = (
        np.arange(-engagement.reach * rolls_per_pitch, engagement.reach * rolls_per_pitch + 1)
        / rolls_per_pitch
    )
    evaluations = (
        (partial(_alone, cycle, segments), 64),
        (partial(_searched, cycle, grids), 4),
    )
    # First from the segments of single pairs, then by search.
    for contacts, parts in evaluations:
        known = np.flatnonzero(followed & ~lost)
        if known.size:
            roll = engagement.roll[known, None] + engagement.pitch[0] * share
            curves = _first(cycle, known, roll), contacts(known, roll)
            for k, thickness in enumerate(thicknesses):
                ratio[k, known], status[k, known] = _ratio(
                    cycle, (contacts, parts), known, roll, curves, thickness
                )
                if thickness == 0.0 and lines.size:  # rounding decides which of the lines is first
                    ratio[k, lines], status[k, lines] = eq16[lines], RatioStatus.KNOWN
        # Second pass, by search: cases for which the segments are not reliable.
        followed = ~followed | (status == RatioStatus.UNSTEADY).any(axis=0)
    ratio[status != RatioStatus.KNOWN] = np.nan
    shape = (len(thicknesses), *shape)
    return OperatingRatios(ratio.reshape(shape), status.reshape(shape), cycle)


@dataclass(frozen=True, eq=False)
class _Curve:
    """Contacts (cases, rolls): f (mm), infinite without contact; whether it is an edge contact; and
    whether the search has not converged."""

    f: FloatArray
    edge: Mask
    doubt: Mask


Contacts: TypeAlias = Callable[[Integers, FloatArray], _Curve]
"""Contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls)."""


def _first(cycle: MeshCycle, case: Integers, roll: FloatArray) -> _Curve:
    """Return the first contacts of all tooth pairs of the cases (n,) at rolls (n, rolls)."""
    segment, _, values = cycle.located(case.repeat(roll.shape[1]), roll.ravel(), 1)
    edge = cycle.segments.limit[0, segment] >= 0
    return _Curve(values.reshape(roll.shape), edge.reshape(roll.shape), np.zeros(roll.shape, dtype=bool))


def _first_and_whose(cycle: MeshCycle, case: Integers, roll: FloatArray) -> tuple[FloatArray, Mask]:
    """Return f (mm) of the first contacts of the cases at rolls, (n,), and whether tooth pair 0 touches."""
    segment, turns, values = cycle.located(case, roll, 1)
    return values[0], np.asarray(cycle.segments.pair[segment] == turns)


def _of_one_pair(engagement: Engagement, samples: Samples, position: Integers, contacts: Found) -> Samples:
    """Return the contacts of tooth pair 0 alone, in order of case and roll, from those of all pairs at the
    samples of a cycle: pair k at a roll is pair 0 after k pitches."""
    turned = samples.roll[position] + contacts.pair * engagement.pitch[0]
    # The last roll of a cycle is the first roll of the next tooth pair.
    once = np.flatnonzero(
        (position % (SAMPLES_PER_PITCH + 1) < SAMPLES_PER_PITCH) & (contacts.status == FirstStatus.SOLVED)
    )
    order = once[np.lexsort((turned[once], samples.case[position[once]]))]
    rows = {name: value[..., order] for name, value in vars(contacts).items()}
    alone = Found(**rows | {"pair": np.zeros(order.size, dtype=np.int64)})
    return samples_of(samples.case[position[order]], turned[order], alone)


def contacts_of_one_pair(design: Design, flank: str) -> FirstContact:
    """Compute the contacts of tooth pair 0 alone at the rolls from which the mesh cycle is computed.

    Parameters
    ----------
    design : Design
        A single one.
    flank : {'right', 'left'}

    Returns
    -------
    FirstContact
        At ascending rolls, SAMPLES_PER_PITCH in each pitch, as `first_contact` with this pair. Rolls at which
        the pair does not touch, or is a quarter of a module later than the first pair, are left out.

    Raises
    ------
    ValueError
        For members of arrays.
    """
    cycle, _, samples, each = cycle_and_pairs(design, flank, 1)
    alone = _of_one_pair(cycle.engagement, samples, *each)
    engagement = cycle.engagement.at(alone.case, alone.roll)
    return result_of(engagement, cycle.phase[alone.case], alone.contacts, alone.roll.shape)


def _segments_alone(
    cycle: MeshCycle, grids: Grids, samples: Samples, thicknesses: FloatArray
) -> tuple[CycleSegments, Mask]:
    """Return the segments of tooth pair 0 alone, and the cases in which they are reliable within each of
    the `thicknesses` (mm): they agree with the samples, meet where this matters, and end beyond the
    largest thickness. Where they do not meet, they are divided."""
    engagement, lost = cycle.engagement, cycle.lost.reshape(-1)
    thickness = float(thicknesses.max())
    samples = samples.pick(np.flatnonzero(~lost[samples.case]))
    off = samples.contacts.f - _first(cycle, samples.case, samples.roll[:, None]).f[:, 0]
    # Samples within the thickness, and one more on either side.
    near = np.pad(off <= thickness + 1e-3 * engagement.module, 1)
    chosen = np.flatnonzero(near[1:-1] | near[2:] | near[:-2])
    samples, off = samples.pick(chosen), off[chosen]
    # If all teeth of the pinion are near, a tooth can touch on several turns, which the scan joins.
    many = engagement.near.size > 2 * engagement.reach
    followed, case = (np.bincount(samples.case, minlength=lost.size) > 0) & many, samples.case
    samples, ends = _in_runs(engagement, samples)
    followed[case[ends[off[ends] <= thickness + TOGETHER_RAD * engagement.lever]]] = False
    # The fit treats each run as a case.
    case, parts = case[ends[0]], [cycle.segments.pick(np.zeros(0, dtype=np.int64))]
    runs = replace(engagement.at(case, samples.roll[ends[0]]), span=2.0 * engagement.reach + 2.0)
    for count in range(5):
        samples = samples.pick(np.flatnonzero(followed[case[samples.case]]))
        if not samples.case.size:
            break
        segments = fitted(runs, samples)
        run, roll, cut = _in_doubt(cycle, (runs, case), samples, segments, thicknesses)
        failed = np.isin(np.arange(case.size), run)
        parts.append(segments.pick(np.flatnonzero(~failed[segments.case])))
        samples = samples.pick(np.flatnonzero(failed[samples.case]))
        if count == 4:
            followed[case[failed]] = False
        elif run.size:
            contacts = found_at(runs.at(run, roll), grids, 0)
            followed[case[run[contacts.status != FirstStatus.SOLVED]]] = False
            samples = samples.and_also(Samples(run, roll, cut, contacts))
    segments = in_order([replace(part, case=case[part.case]) for part in parts])
    return segments.pick(followed[segments.case]), followed


def _in_doubt(
    cycle: MeshCycle,
    runs: tuple[Engagement, Integers],
    samples: Samples,
    segments: CycleSegments,
    thicknesses: FloatArray,
) -> tuple[Integers, FloatArray, Mask]:
    """Return runs and rolls (n,), rad, at which more contacts of a single tooth pair are needed, and
    whether a segment is cut there: in segments that do not agree with the samples, and between the
    samples next to ends at which segments do not meet. `runs`: as an engagement, and the cases of the
    runs."""
    (engagement, case), bound = runs, LATE_RAD * cycle.engagement.lever
    single = segments.number(engagement, samples.case, samples.roll)
    behind = np.abs(segments.values_at(single, samples.roll, 1)[0] - samples.contacts.f)
    inner = np.flatnonzero(segments.case[1:] == segments.case[:-1])
    ends = np.array([segments.values_at(inner + k, segments.high[inner], 1)[0] for k in (0, 1)])
    run, at, jump = segments.case[inner], segments.high[inner], np.abs(ends[1] - ends[0])
    # Where the pair is the first, the cycle is exact. Elsewhere, a jump matters only near a thickness.
    first, ours = _first_and_whose(cycle, case[run], at)
    room = np.abs(ends.min(axis=0) - first - thicknesses[:, None]).min(axis=0)
    apart = ~((jump <= bound) | ours | (jump < 0.1 * room))
    run, at, late = run[apart], at[apart, None], np.unique(single[~(behind <= bound)])
    same = samples.case == run[:, None]
    low = np.where(same & (samples.roll <= at), samples.roll, -np.inf).max(axis=1, initial=-np.inf)
    high = np.where(same & (samples.roll >= at), samples.roll, np.inf).min(axis=1, initial=np.inf)
    about = low[:, None] + (high - low)[:, None] * SEARCH_PLACES
    more = np.append(about, segments.rolls(2.0 * SEARCH_PLACES - 1.0)[late])
    cut = np.append(np.zeros(about.shape, dtype=bool), np.tile(SEARCH_PLACES == CUT_PLACE, (late.size, 1)))
    return np.append(run, segments.case[late]).repeat(SEARCH_PLACES.size), more, cut


def _in_runs(engagement: Engagement, samples: Samples) -> tuple[Samples, Integers]:
    """Return the samples numbered by the runs without gaps to which they belong, and the first and last
    sample of each run (2, runs)."""
    apart = np.diff(samples.roll) > 1.5 * engagement.pitch[0] / SAMPLES_PER_PITCH
    begins = np.append(samples.case[:1] >= 0, apart | (np.diff(samples.case) != 0))
    first = np.flatnonzero(begins)
    ends = np.stack((first, np.append(first[1:], samples.case.size)[: first.size] - 1))
    return replace(samples, case=np.cumsum(begins) - 1), ends


def _alone(cycle: MeshCycle, segments: CycleSegments, case: Integers, roll: FloatArray) -> _Curve:
    """Return the contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), from its segments."""
    engagement, span = cycle.engagement, 4.0 * cycle.engagement.reach
    early = replace(engagement, roll=engagement.roll - 0.5 * span * engagement.pitch[0], span=span)
    case, turned = case.repeat(roll.shape[1]), roll.ravel()
    segment = segments.number(early, case, turned)
    on = (
        (segments.case[segment] == case)
        & (segments.low[segment] <= turned)
        & (turned <= segments.high[segment])
    )
    f = np.full(turned.size, np.inf)
    f[on] = segments.values_at(segment[on], turned[on], 1)[0]
    first, ours = _first_and_whose(cycle, case, turned)
    f[on & ours] = first[on & ours]
    edge, doubt = on & (segments.limit[0, segment] >= 0), np.zeros(turned.size, dtype=bool)
    return _Curve(*(row.reshape(roll.shape) for row in (f, edge, doubt)))


def _searched(cycle: MeshCycle, grids: Grids, case: Integers, roll: FloatArray) -> _Curve:
    """Return the contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), by search."""
    contacts = found_at(cycle.engagement.at(case.repeat(roll.shape[1]), roll.ravel()), grids, 0)
    f = np.where(contacts.status == FirstStatus.SOLVED, contacts.f, np.inf)
    doubt = (contacts.status != FirstStatus.SOLVED) & (contacts.status != FirstStatus.NO_CONTACT)
    return _Curve(*(row.reshape(roll.shape) for row in (f, contacts.limit[0] >= 0, doubt)))


def _divided(
    case: Integers, roll: FloatArray, labels: Integers, label: Label, least: float, parts: int
) -> _Intervals:
    """Return the intervals between rolls (n, rolls) of the cases in which the labels change, divided into
    equal `parts` until narrower than `least`."""
    share = np.linspace(0.0, 1.0, parts + 1)
    contacts = _with_change(case, roll, labels)
    limit = 64 * max(1, np.unique(contacts.case).size)
    while 0 < contacts.case.size <= limit and float((contacts.high - contacts.low).max()) > least:
        roll = contacts.low[:, None] + (contacts.high - contacts.low)[:, None] * share
        contacts = _with_change(contacts.case, roll, label(contacts.case, roll))
    return contacts


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals of roll (n,), rad, of the cases with these numbers."""

    case: Integers
    low: FloatArray
    high: FloatArray


def _with_change(case: Integers, roll: FloatArray, labels: Integers) -> _Intervals:
    """Return the intervals between rolls (n, rolls) at whose ends the labels differ."""
    row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
    return _Intervals(case[row], roll[row, column], roll[row, column + 1])


def _ratio(
    cycle: MeshCycle,
    evaluation: tuple[Contacts, int],
    case: Integers,
    roll: FloatArray,
    curves: tuple[_Curve, _Curve],
    thickness: float,
) -> tuple[FloatArray, Integers]:
    """Return ratios and status (cases,), from the `curves` of all pairs and of pair 0 alone at rolls
    (cases, rolls). `way`: the function that returns the latter at other rolls, and the `parts` of
    `_divided`."""
    # Width to which the intervals with a change of contact are divided.
    change_width_pitches = 1e-10
    engagement, cases, (alone, parts) = cycle.engagement, cycle.engagement.roll.size, evaluation

    def touching(first: _Curve, single: _Curve) -> Integers:
        # An edge does not touch if a tangency of another pair is earlier, even by rounding only.
        spare = engagement.lever * np.where(single.edge & ~first.edge, -TOGETHER_RAD, TOGETHER_RAD)
        return np.asarray(single.f - first.f <= thickness + spare).astype(int)

    def touches(cases: Integers, rolls: FloatArray) -> Integers:
        return touching(_first(cycle, cases, rolls), alone(cases, rolls))

    # Beyond this clearance, the same teeth are counted on another turn.
    most = (1.0 - OVERLAP) * engagement.period * engagement.lever - np.maximum(curves[0].f, 0.0).max(axis=1)
    if (thickness >= most).all():
        return np.full(case.size, np.nan), np.full(case.size, RatioStatus.TOO_THICK)
    inside, width = touching(*curves), change_width_pitches * engagement.pitch[0]
    ends = _divided(case, roll, inside, touches, width, parts)
    ratio, balance, wide = np.zeros(cases), np.zeros(cases), np.zeros(cases, dtype=bool)
    leaves = touches(ends.case, ends.low[:, None])[:, 0] if ends.case.size else np.zeros(0)
    sign = np.where(leaves, 1.0, -1.0)
    middle = 0.5 * (ends.low + ends.high) - engagement.roll[ends.case]
    np.add.at(ratio, ends.case, sign * middle / engagement.pitch[0])
    np.add.at(balance, ends.case, sign)
    wide[ends.case[ends.high - ends.low > width]] = True
    ratio, balance, wide = ratio[case], balance[case], wide[case]
    beyond = (inside[:, [0, -1]] != 0).any(axis=1) | (thickness >= most)
    faults = (
        (curves[1].doubt.any(axis=1), RatioStatus.NOT_CONVERGED),
        (beyond, RatioStatus.TOO_THICK),
        (wide | (balance != 0.0) | ~(ratio >= 1.0 - 1e-6), RatioStatus.UNSTEADY),
    )
    contacts = np.select([where for where, _ in faults], [code for _, code in faults], RatioStatus.KNOWN)
    return ratio, contacts
