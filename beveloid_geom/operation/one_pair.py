"""Contacts of one tooth pair alone, computed with the mesh cycle.

The samples of a mesh cycle contain the contacts of all tooth pairs. As all pairs have the same curve, whole
pitches apart, they give the curve of pair 0 over several pitches. Segments through these contacts represent
the curve between the samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..design.model import Design
from ..status import FirstStatus
from .cycle.cycle_segments import SAMPLES_PER_PITCH, CycleSegments, Samples, samples_of
from .cycle.missed_contacts import LATE_ROLL_RAD
from .cycle.segment_fit import fitted
from .cycle.segment_search import sorted_segments
from .engagement import Engagement
from .first_contact import FirstContact, result_of
from .mesh_cycle import MeshCycle, cycle_and_pairs
from .search.earliest_contact import SAME_ROLL_RAD, Found, Grids, found_at


@dataclass(frozen=True, eq=False)
class PairCurve:
    """Contacts (cases, rolls): clearance `f` from the conjugate gear roll (mm), infinite without contact;
    whether it is an edge contact; and whether the search has not converged."""

    f: FloatArray
    edge: Mask
    doubt: Mask


def first_contacts_at(cycle: MeshCycle, case: Integers, roll: FloatArray) -> PairCurve:
    """Return the first contacts of all tooth pairs of the cases (n,) at rolls (n, rolls)."""
    segment, _, values = cycle.located(case.repeat(roll.shape[1]), roll.ravel(), 1)
    edge = cycle.segments.limit[0, segment] >= 0
    return PairCurve(values.reshape(roll.shape), edge.reshape(roll.shape), np.zeros(roll.shape, dtype=bool))


def _whose_contact(cycle: MeshCycle, case: Integers, roll: FloatArray) -> tuple[FloatArray, Mask]:
    """Return f (mm) of the first contacts of the cases at rolls, (n,), and whether tooth pair 0 touches."""
    segment, turns, values = cycle.located(case, roll, 1)
    return values[0], np.asarray(cycle.segments.pair[segment] == turns)


def samples_of_one_pair(
    engagement: Engagement, samples: Samples, position: Integers, contacts: Found
) -> Samples:
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
        A single design.
    flank : {'right', 'left'}

    Returns
    -------
    FirstContact
        At ascending rolls, SAMPLES_PER_PITCH in each pitch, as `first_contact` with this pair. Rolls at which
        the pair does not touch, or is a quarter of a module later than the first pair, are left out.

    Raises
    ------
    ValueError
        If a field of a member is an array.
    """
    cycle, _, samples, each = cycle_and_pairs(design, flank, 1)
    alone = samples_of_one_pair(cycle.engagement, samples, *each)
    engagement = cycle.engagement.at(alone.case, alone.roll)
    return result_of(engagement, cycle.phase[alone.case], alone.contacts, alone.roll.shape)


def segments_of_one_pair(
    cycle: MeshCycle, grids: Grids, samples: Samples, thicknesses: FloatArray
) -> tuple[CycleSegments, Mask]:
    """Return the segments of tooth pair 0 alone, and whether they are reliable (cases,).

    They are reliable on five conditions. The pinion has at least 2 reach + 1 teeth. All contacts that are
    searched here in addition to the samples are SOLVED. The segments agree with the samples. At the first
    and last sample of each run, the clearance is above that of the first contact by more than the largest
    of the `thicknesses` (mm). The segments meet, except for jumps that are too small to change whether the
    pair is within a thickness. Where they do not meet, they are divided."""
    engagement, lost = cycle.engagement, cycle.lost.reshape(-1)
    thickness = float(thicknesses.max())
    samples = samples.pick(np.flatnonzero(~lost[samples.case]))
    off = samples.contacts.f - first_contacts_at(cycle, samples.case, samples.roll[:, None]).f[:, 0]
    # Samples within the thickness, and one more on either side.
    near = np.pad(off <= thickness + 1e-3 * engagement.module, 1)
    chosen = np.flatnonzero(near[1:-1] | near[2:] | near[:-2])
    samples, off = samples.pick(chosen), off[chosen]
    # `many`: the pinion has at least 2 reach + 1 teeth. With fewer, all its teeth are near, and a tooth can
    # touch on several turns, which the scan does not distinguish.
    many = engagement.near.size > 2 * engagement.reach
    followed, case = (np.bincount(samples.case, minlength=lost.size) > 0) & many, samples.case
    samples, ends = _in_runs(engagement, samples)
    followed[case[ends[off[ends] <= thickness + SAME_ROLL_RAD * engagement.lever]]] = False
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
    segments = sorted_segments([replace(part, case=case[part.case]) for part in parts])
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
    (engagement, case), bound = runs, LATE_ROLL_RAD * cycle.engagement.lever
    single = segments.number(engagement, samples.case, samples.roll)
    behind = np.abs(segments.values_at(single, samples.roll, 1)[0] - samples.contacts.f)
    inner = np.flatnonzero(segments.case[1:] == segments.case[:-1])
    ends = np.array([segments.values_at(inner + k, segments.high[inner], 1)[0] for k in (0, 1)])
    run, at, jump = segments.case[inner], segments.high[inner], np.abs(ends[1] - ends[0])
    # Where the pair is the first, the cycle is exact. Elsewhere, a jump matters only near a thickness.
    first, ours = _whose_contact(cycle, case[run], at)
    to_thickness = np.abs(ends.min(axis=0) - first - thicknesses[:, None]).min(axis=0)
    apart = ~((jump <= bound) | ours | (jump < 0.1 * to_thickness))
    run, at, late = run[apart], at[apart, None], np.unique(single[~(behind <= bound)])
    same = samples.case == run[:, None]
    low = np.where(same & (samples.roll <= at), samples.roll, -np.inf).max(axis=1, initial=-np.inf)
    high = np.where(same & (samples.roll >= at), samples.roll, np.inf).min(axis=1, initial=np.inf)
    # Places between two samples, or along a segment, at which a single tooth pair is searched where its
    # segments do not meet or do not agree with the samples. At 0.45, such a segment is cut.
    search_places = np.array((0.1, 0.3, 0.45, 0.6, 0.8, 0.95))
    about = low[:, None] + (high - low)[:, None] * search_places
    more = np.append(about, segments.rolls(2.0 * search_places - 1.0)[late])
    cut = np.append(np.zeros(about.shape, dtype=bool), np.tile(search_places == 0.45, (late.size, 1)))
    return np.append(run, segments.case[late]).repeat(search_places.size), more, cut


def _in_runs(engagement: Engagement, samples: Samples) -> tuple[Samples, Integers]:
    """Return the samples numbered by the runs without gaps to which they belong, and the first and last
    sample of each run (2, runs)."""
    apart = np.diff(samples.roll) > 1.5 * engagement.pitch[0] / SAMPLES_PER_PITCH
    begins = np.append(samples.case[:1] >= 0, apart | (np.diff(samples.case) != 0))
    first = np.flatnonzero(begins)
    ends = np.stack((first, np.append(first[1:], samples.case.size)[: first.size] - 1))
    return replace(samples, case=np.cumsum(begins) - 1), ends


def contacts_from_segments(
    cycle: MeshCycle, segments: CycleSegments, case: Integers, roll: FloatArray
) -> PairCurve:
    """Return the contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), from its segments."""
    engagement, span = cycle.engagement, 4.0 * cycle.engagement.reach
    early = replace(engagement, roll=engagement.roll - 0.5 * span * engagement.pitch[0], span=span)
    case, turned = case.repeat(roll.shape[1]), roll.ravel()
    segment = segments.number(early, case, turned)
    on = (segments.low[segment] <= turned) & (turned <= segments.high[segment])
    on &= segments.case[segment] == case
    f = np.full(turned.size, np.inf)
    f[on] = segments.values_at(segment[on], turned[on], 1)[0]
    first, ours = _whose_contact(cycle, case, turned)
    f[on & ours] = first[on & ours]
    edge, doubt = on & (segments.limit[0, segment] >= 0), np.zeros(turned.size, dtype=bool)
    return PairCurve(*(row.reshape(roll.shape) for row in (f, edge, doubt)))


def searched_contacts(cycle: MeshCycle, grids: Grids, case: Integers, roll: FloatArray) -> PairCurve:
    """Return the contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), by search."""
    contacts = found_at(cycle.engagement.at(case.repeat(roll.shape[1]), roll.ravel()), grids, 0)
    f = np.where(contacts.status == FirstStatus.SOLVED, contacts.f, np.inf)
    doubt = (contacts.status != FirstStatus.SOLVED) & (contacts.status != FirstStatus.NO_CONTACT)
    return PairCurve(*(row.reshape(roll.shape) for row in (f, contacts.limit[0] >= 0, doubt)))
