"""Contact ratio in operation: mean number of tooth pairs in contact, edges and fillets included.

A tooth pair is in contact where it is the first of all to touch, or where its clearance is within a given
thickness of the first, for instance of a lubricant film or marking compound. The contact ratio is the length
of roll over which one pair is in contact, divided by the pitch. For zero thickness, unmodified pairs have the
contact ratio of Eq. 16, and rigid modified flanks, which touch in one point at a time, have the ratio 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers
from ..contact.path import contact_ratio
from ..design.arguments import require_design, require_integers
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import RatioStatus
from ..support.array_repr import short_repr
from .mesh_cycle import MeshCycle, cycle_and_pairs
from .one_pair import (
    PairCurve,
    contacts_from_segments,
    first_contacts_at,
    samples_of_one_pair,
    searched_contacts,
    segments_of_one_pair,
)
from .search.earliest_contact import SAME_ROLL_RAD
from .search.search_task import OVERLAP_PERIODS

Contacts: TypeAlias = Callable[[Integers, FloatArray], PairCurve]
"""Function of cases (n,) and rolls (n, rolls), rad: contacts of tooth pair 0."""
Label: TypeAlias = Callable[[Integers, FloatArray], Integers]
"""Function of cases (n,) and rolls (n, rolls), rad: 1 where tooth pair 0 is in contact, else 0."""


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
        The fields of the members must not be arrays; pair and errors may be arrays.
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
        If a field of a member is an array, or for a negative thickness.
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
        The fields of the members must not be arrays; pair and errors may be arrays.
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
        If a field of a member is an array, for a negative thickness, or for fewer than one harmonic.

    References
    ----------
    Method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> ratios = bg.operating_ratios(bg.builtin_design("ni-2017"), "right", (0.0, 0.006))
    >>> ratios.ratio.round(3)
    array([1.651, 2.283])
    """
    # Rolls at which a single tooth pair is compared with the first contact.
    rolls_per_pitch = 96
    require_design(design)
    require_integers(harmonics=harmonics)
    for thickness in float64_of("thicknesses", thicknesses).tolist():
        if not thickness >= 0.0:
            raise ValueError(f"thickness must be at least 0 mm, got {thickness}")
    cycle, grids, samples, each = cycle_and_pairs(design, flank, harmonics)
    shape, alone = design.batch_shape, samples_of_one_pair(cycle.engagement, samples, *each)
    lost, engagement = cycle.lost.reshape(-1), cycle.engagement
    ratio = np.full((len(thicknesses), lost.size), np.nan)
    status = np.full(ratio.shape, RatioStatus.NO_FIRST_CONTACT, dtype=np.int8)
    lines = np.flatnonzero(cycle.along_lines.reshape(-1) & ~lost)
    eq16 = contact_ratio(design, flank).reshape(-1) if lines.size else np.empty(0)
    useful = [size for size in thicknesses if size < engagement.period * engagement.lever]
    segments, followed = segments_of_one_pair(cycle, grids, alone, np.array(useful or [0.0]))
    steps = engagement.reach * rolls_per_pitch
    share = np.arange(-steps, steps + 1) / rolls_per_pitch
    evaluations = (
        (partial(contacts_from_segments, cycle, segments), 64),
        (partial(searched_contacts, cycle, grids), 4),
    )
    # First from the segments of single pairs, then by search.
    for contacts, parts in evaluations:
        known = np.flatnonzero(followed & ~lost)
        if known.size:
            roll = engagement.roll[known, None] + engagement.pitch[0] * share
            curves = first_contacts_at(cycle, known, roll), contacts(known, roll)
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


Intervals: TypeAlias = tuple[Integers, FloatArray, FloatArray]
"""Cases (n,), and first and last roll (n,), rad, of intervals."""


def _divided(
    case: Integers, roll: FloatArray, labels: Integers, label: Label, least: float, parts: int
) -> Intervals:
    """Return the intervals between rolls (n, rolls) of the cases in which the labels change, divided into
    equal `parts` until narrower than `least`."""
    share = np.linspace(0.0, 1.0, parts + 1)
    case, low, high = _with_change(case, roll, labels)
    limit = 64 * max(1, np.unique(case).size)
    while 0 < case.size <= limit and float((high - low).max()) > least:
        roll = low[:, None] + (high - low)[:, None] * share
        case, low, high = _with_change(case, roll, label(case, roll))
    return case, low, high


def _with_change(case: Integers, roll: FloatArray, labels: Integers) -> Intervals:
    """Return the intervals between rolls (n, rolls) at whose ends the labels differ."""
    row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
    return case[row], roll[row, column], roll[row, column + 1]


def _ratio(
    cycle: MeshCycle,
    evaluation: tuple[Contacts, int],
    case: Integers,
    roll: FloatArray,
    curves: tuple[PairCurve, PairCurve],
    thickness: float,
) -> tuple[FloatArray, Integers]:
    """Return ratios and status (cases,), from the `curves` of all pairs and of pair 0 alone at rolls
    (cases, rolls). `evaluation`: the function that returns the latter at other rolls, and the `parts` of
    `_divided`."""
    # Width to which the intervals with a change of contact are divided.
    change_width_pitches = 1e-10
    engagement, cases, (alone, parts) = cycle.engagement, cycle.engagement.roll.size, evaluation

    def touching(first: PairCurve, single: PairCurve) -> Integers:
        # An edge does not touch if a tangency of another pair is earlier, even by rounding only.
        spare = engagement.lever * np.where(single.edge & ~first.edge, -SAME_ROLL_RAD, SAME_ROLL_RAD)
        return np.asarray(single.f - first.f <= thickness + spare).astype(int)

    def touches(cases: Integers, rolls: FloatArray) -> Integers:
        return touching(first_contacts_at(cycle, cases, rolls), alone(cases, rolls))

    # Beyond this clearance, the same teeth are counted on another turn.
    most = (1.0 - OVERLAP_PERIODS) * engagement.period * engagement.lever
    most = most - np.maximum(curves[0].f, 0.0).max(axis=1)
    if (thickness >= most).all():
        return np.full(case.size, np.nan), np.full(case.size, RatioStatus.TOO_THICK)
    inside, width = touching(*curves), change_width_pitches * engagement.pitch[0]
    changed, low, high = _divided(case, roll, inside, touches, width, parts)
    ratio, balance, wide = np.zeros(cases), np.zeros(cases), np.zeros(cases, dtype=bool)
    leaves = touches(changed, low[:, None])[:, 0] if changed.size else np.zeros(0)
    sign = np.where(leaves, 1.0, -1.0)
    middle = 0.5 * (low + high) - engagement.roll[changed]
    np.add.at(ratio, changed, sign * middle / engagement.pitch[0])
    np.add.at(balance, changed, sign)
    wide[changed[high - low > width]] = True
    ratio, balance, wide = ratio[case], balance[case], wide[case]
    beyond = (inside[:, [0, -1]] != 0).any(axis=1) | (thickness >= most)
    faults = (
        (curves[1].doubt.any(axis=1), RatioStatus.NOT_CONVERGED),
        (beyond, RatioStatus.TOO_THICK),
        (wide | (balance != 0.0) | ~(ratio >= 1.0 - 1e-6), RatioStatus.UNSTEADY),
    )
    status = np.select([where for where, _ in faults], [code for _, code in faults], RatioStatus.KNOWN)
    return ratio, status
