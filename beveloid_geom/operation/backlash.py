"""Backlash of the mounted pair: play of the gear while the pinion is held.

At a pinion roll, the first contact of the right flanks limits the gear in one sense, and the first contact of
the left flanks limits it in the other (`first_contact`: all teeth, edges and fillets). With theta = gear roll
plus N1/N2 pinion roll at either limit, the play along the normal is

    j = (theta_R - theta_L) m_n N2 cos(alpha) / 2.

Rolls alone give j only up to a multiple of a pitch. Therefore j is computed as the backlash of the layout
(`pair.mounting`) minus the transmission errors of both sides times m_n N2 cos(alpha) / 2. It may exceed half
a pitch. The minimum of j over a mesh cycle is the backlash. If it is negative, teeth in mesh would overlap at
that roll. Beyond an overlap of JAM_OVERLAP_MODULES, the pair counts as one that cannot be assembled.

Both limits are known as segments of two mesh cycles (`mesh_cycle`). Between the rolls at which a segment of
either cycle begins, j is a polynomial, whose minimum is computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FLANKS, Codes, FloatArray, Mask
from ..contact.flank_pair import is_modified
from ..design.arguments import require_design
from ..design.model import Design
from ..pair.frames import layout_of
from ..pair.mounting import within_half_pitch
from ..status import FirstStatus
from ..support.array_repr import short_repr
from ..support.chebyshev import basis_of, evaluate, greatest
from ..support.frozen_arrays import cached, restored
from .contact_normals import contact_normals, moved_by_gear, touches_undercut_edge, with_tangencies
from .cycle.cycle_segments import SEGMENT_DEGREE, rolls_between
from .engagement import conjugate_phase
from .first_contact import FirstContact, first_contact
from .mesh_cycle import MeshCycle, mesh_cycle

JAM_OVERLAP_MODULES = 2e-5
"""Overlap, modules, up to which a pair is not reported as jammed. A layout without backlash can have this
overlap if its offset (mm) and shaft angle (deg) are rounded to four decimals."""


@dataclass(frozen=True, eq=False)
class Backlash:
    """Minimum normal backlash over a mesh cycle, of the batch shape.

    Attributes
    ----------
    normal : ndarray
        mm along the normal; negative for overlap. `jammed` states whether the pair cannot be assembled.
    pinion_roll : ndarray
        Roll of the minimum, rad.
    right, left : FirstContact
        First contacts at this roll, with a last axis of one position.
    status : ndarray of int
        Codes of `FirstStatus`: the status of the mesh cycle of the right flanks if this is not SOLVED, else
        that of the left flanks. If it is not SOLVED, `normal` and `pinion_roll` are NaN, and `right` and
        `left` are the first contacts at the beginning of the cycle of the right flanks.
    jammed : ndarray of bool
        Whether the pair cannot be assembled: the play is below -JAM_OVERLAP_MODULES modules at some roll, or
        a tip reaches the bottom land of the mate. One such roll is sufficient, even if other rolls are not
        solved.
    """

    normal: FloatArray
    pinion_roll: FloatArray
    right: FirstContact
    left: FirstContact
    status: Codes
    jammed: Mask

    __repr__ = short_repr

    __setstate__ = restored


def lever_of(design: Design) -> FloatArray:
    """Return the play along the normal per rad of gear roll, m_n N2 cos(alpha) / 2.

    Parameters
    ----------
    design : Design

    Returns
    -------
    ndarray
        mm.
    """
    tool = design.gear.tool
    return np.asarray(0.5 * tool.normal_module * np.cos(tool.normal_pressure_angle) * design.gear.teeth)


def play_at(design: Design, pinion_roll: FloatArray) -> tuple[FloatArray, Codes]:
    """Compute the play at given pinion rolls.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.
    pinion_roll : ndarray, shape (positions) or (..., positions)
        rad.

    Returns
    -------
    play : ndarray, shape (..., positions)
        mm along the normal.
    status : ndarray of int, shape (..., positions)
        Codes of `FirstStatus`: the status of the right flanks if this is not SOLVED, else that of the left
        flanks.

    Raises
    ------
    ValueError
        As `first_contact`.
    """
    return _play_of(design, *(first_contact(design, flank, pinion_roll) for flank in FLANKS))


def _play_of(design: Design, right: FirstContact, left: FirstContact) -> tuple[FloatArray, Codes]:
    """Return the play between first contacts at the same rolls, and its status, as `play_at`."""
    pitch = 2.0 * np.pi / float(design.gear.teeth)
    phases = [conjugate_phase(design, flank) for flank in FLANKS]
    layout_play = within_half_pitch(phases[0] - phases[1], pitch)[..., None]
    # On either side, a gear that is ahead in the sense of driving reduces the play.
    play = lever_of(design) * (layout_play - right.transmission_error - left.transmission_error)
    lost = np.isnan(play)
    if lost.any():  # no layout or no conjugate flanks: the play within half a pitch
        turn = within_half_pitch(right.gear_roll - left.gear_roll, pitch)
        play = np.where(lost, lever_of(design) * turn, play)
    status = np.where(right.status != FirstStatus.SOLVED, right.status, left.status)
    return play, status.astype(np.int8)


def mounted_backlash(design: Design) -> Backlash:
    """Compute the minimum normal backlash over a mesh cycle, with errors, parabolas and modifications.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.

    Returns
    -------
    Backlash
        Results of single designs are cached.

    Raises
    ------
    ValueError
        If a field of a member is an array.

    References
    ----------
    Definition and method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> print(f"{bg.mounted_backlash(bg.builtin_design('ni-2017')).normal:.4f} mm")
    0.0416 mm
    """
    require_design(design)
    return _backlash(design) if design.batch_shape else _cached_backlash(design)


@cached(16)
def _cached_backlash(design: Design) -> Backlash:
    return _backlash(design)


def _backlash(design: Design) -> Backlash:
    right, left = cycles = [mesh_cycle(design, flank, 1) for flank in FLANKS]
    status = np.where(right.status != FirstStatus.SOLVED, right.status, left.status)
    status = status.reshape(design.batch_shape)
    known = status == FirstStatus.SOLVED
    roll = _roll_of_minimum(cycles, known.reshape(-1)).reshape(known.shape)
    contacts = [cycle.at(roll[..., None]) for cycle in cycles]
    play = np.where(known, _play_of(design, *contacts)[0][..., 0], np.nan)
    overlap = -JAM_OVERLAP_MODULES * float(design.pinion.tool.normal_module)
    jammed = (play < overlap) | (status == FirstStatus.MEETS_BOTTOM)
    if not known.all():  # negative play at one roll is a jam, even if other rolls are not known
        pitch = 2.0 * np.pi / int(design.pinion.teeth)
        sampled, at_sample = play_at(design, roll[..., None] + pitch * np.arange(32) / 32)
        jams = (sampled < overlap) | (at_sample == FirstStatus.MEETS_BOTTOM)
        jammed |= ~known & jams.any(axis=-1)
    return Backlash(
        normal=play,
        pinion_roll=np.where(known, roll, np.nan),
        right=with_tangencies(design, "right", contacts[0]),
        left=with_tangencies(design, "left", contacts[1]),
        status=status.astype(np.int8),
        jammed=np.asarray(jammed),
    )


def _roll_of_minimum(cycles: list[MeshCycle], known: Mask) -> FloatArray:
    """Return the rolls (cases,), rad, at which the play between two mesh cycles is smallest; the start of the
    first cycle for cases that are not `known`."""
    engagement, pitch = cycles[0].engagement, cycles[0].pitch
    start, parts = engagement.roll, [cycle.segments.pick(known[cycle.segments.case]) for cycle in cycles]
    # Divide the cycle at the beginnings of all segments. The cycles begin at different rolls.
    case = np.concatenate([part.case for part in parts])
    begins = [np.remainder(part.low - start[part.case], pitch) for part in parts]
    order = np.lexsort((np.concatenate(begins), case))
    case, low = case[order], np.concatenate(begins)[order]
    high = np.where(np.append(case[1:] == case[:-1], False), np.append(low[1:], 0.0), pitch)
    low, high, case = (row[high > low] for row in (low + start[case], high + start[case], case))
    # In each interval, add the clearances on both sides at the nodes of a polynomial.
    basis = basis_of(SEGMENT_DEGREE)
    roll = rolls_between(low, high, basis.nodes)
    clearance = np.zeros(roll.shape)
    for cycle in cycles:
        segment, turns, _ = cycle.located(case, 0.5 * (low + high), 1)
        clearance += cycle.segments.values(segment, roll - turns[:, None] * pitch)[0]
    series = basis.coefficients(clearance[None])
    end = np.ones((case.size, 1))
    places = np.concatenate((-end, greatest(-series[0], -end, end)), axis=1)
    values, places = evaluate(series, places)[0].ravel(), rolls_between(low, high, places).ravel()
    # Take the first of minima that differ by rounding only.
    least, case = np.full(start.size, np.inf), case.repeat(2)
    np.minimum.at(least, case, values)
    lowest = np.flatnonzero(values <= least[case] + 1e-11 * engagement.module)
    minimum_cases, first = np.unique(case[lowest], return_index=True)
    best = start.copy()
    best[minimum_cases] = places[lowest[first]]
    return best


def backlash_by_errors(design: Design) -> FloatArray:
    """Compute derivatives of the minimum normal backlash with respect to the assembly errors.

    Parameters
    ----------
    design : Design
        The derivatives are taken at the errors of the design.

    Returns
    -------
    ndarray, shape (..., 4)
        By offset, shaft angle, pinion and gear axial error; mm per mm and mm per rad. NaN where the backlash
        is not known, where an undercut edge touches an edge, and for errors by which the derivatives differ
        between several rolls at which the play is smallest.

    Notes
    -----
    At its minimum, the play is stationary in the roll, so that its derivative is that at a fixed roll. An
    error moves the contact point of the gear by v relative to the pinion, and the gear rotates until both
    touch again: n.(v + turn k2 x r) = 0 with the normal n. The derivatives are exact."""
    backlash = mounted_backlash(design)
    right, left = (_turn_by_errors(design, flank, getattr(backlash, flank)) for flank in FLANKS)
    known = (backlash.status == FirstStatus.SOLVED)[..., None]
    rates = np.where(known, lever_of(design) * (right - left), np.nan)[..., 0, :]
    modified = design.has_parabola or any(is_modified(design, flank) for flank in FLANKS)
    if not (modified and known.any()):
        return np.asarray(rates)  # the play of unmodified flanks is the same at all rolls under any error
    return np.where(_at_kink(design, backlash), np.nan, rates)


def _at_kink(design: Design, backlash: Backlash) -> Mask:
    """Return (..., 4) whether the play is smallest at several rolls at which its derivatives by an error
    differ."""
    rolls_per_pitch, tie_tolerance = 64, 1e-11  # the tolerance in modules, as for the smallest play
    rate_tolerance = 1e-5  # relative to the lever arms, mm per mm
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    steps = pitch * np.arange(rolls_per_pitch) / rolls_per_pitch
    start = np.where(np.isnan(backlash.pinion_roll), 0.0, backlash.pinion_roll)
    contacts = [mesh_cycle(design, flank, 1).at(start[..., None] + steps) for flank in FLANKS]
    play = _play_of(design, *contacts)[0]
    with np.errstate(invalid="ignore"):
        least = play <= backlash.normal[..., None] + tie_tolerance * float(design.pinion.tool.normal_module)
    if not least[..., 1:].any():
        return np.zeros((*backlash.normal.shape, 4), dtype=bool)
    right, left = (
        _turn_by_errors(design, flank, with_tangencies(design, flank, contact))
        for flank, contact in zip(FLANKS, contacts, strict=True)
    )
    rates = np.where(least[..., None], lever_of(design)[..., None, None] * (right - left), np.nan)
    spread = np.fmax.reduce(rates, axis=-2) - np.fmin.reduce(rates, axis=-2)
    arms = np.array((1.0, float(design.gear.tool.normal_module * design.gear.teeth), 1.0, 1.0))
    return np.asarray(spread > rate_tolerance * arms)


def _turn_by_errors(design: Design, flank: str, first: FirstContact) -> FloatArray:
    """Return the rotation of the gear (..., positions, 4), rad, by which first contacts (..., positions)
    follow each error."""
    unknown = touches_undercut_edge(first)[..., None]
    normal = np.where(unknown, np.nan, contact_normals(design, flank, first))
    turned = moved_by_gear(design, first.point)
    _, y, z = np.moveaxis(first.point, -1, 0)
    layout, zero, one = layout_of(design), np.zeros_like(z), np.ones_like(z)
    sin, cos, sense = (
        one * np.asarray(value)[..., None] for value in (layout.sin_angle, layout.cos_angle, layout.sense)
    )
    moved = ((one, zero, zero), (zero, sense * z, -sense * y), (zero, zero, -one), (zero, sin, cos))
    along = np.stack([(normal * np.stack(v, axis=-1)).sum(axis=-1) for v in moved], axis=-1)
    return np.asarray(-along / (normal * turned).sum(axis=-1, keepdims=True))
