"""Contacts that the samples of a mesh cycle miss.

A contact that is the first for less than the distance of two samples is one of the following. A limit is an
edge or an end of a flank or fillet (`status.Limit`); it is active if the contact lies on it.

    1. the contact of a segment, which is the first again before or after this segment
    2. a contact that is later than the first one at the samples next to the end of a segment
    3. a contact that is the first only between two samples
    4. a contact with one active limit less than a segment, as where an edge contact becomes a tangency
    5. a contact with one active limit more, where a segment violates a limit
    6. a contact between two segments that do not meet

If a flank has reliefs, contacts are first followed past the ends of the segments (`past_ends`). Kinds 1 to 4
are followed by Newton's method from known contacts. A contact of kind 2 or 3 is also followed to the corner
at which it reaches a second limit. For kinds 5 and 6, first contacts are searched.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import FirstStatus
from ...support.chebyshev import basis_of
from ..engagement import Engagement
from ..search.earliest_contact import Found
from ..search.minimum_clearance import ON_LIMIT_DEPTHS
from .cycle_segments import (
    QUANTITY_COUNT,
    SAMPLES_PER_PITCH,
    CycleSegments,
    Samples,
    holding,
    order_of,
    samples_of,
)
from .segment_fit import held_to

Followed: TypeAlias = tuple[Integers, FloatArray, FloatArray, Codes, Integers]
"""Contacts to follow: case, roll (rad), place near the contact (2, n), mm, active limits (2, n), tooth
pair."""

LATE_ROLL_RAD = 3e-11
"""Gear roll by which a segment may be later than a first contact."""
BETWEEN_SAMPLES = np.linspace(-0.5, 0.5, 5)
"""Distances from a sample, in sample steps, at which later contacts are followed."""


def past_ends(engagement: Engagement, segments: CycleSegments) -> Samples:
    """Return contacts that are earlier than the segments, past their ends.

    Where a contact passes the beginnings of two reliefs, or passes one shortly before another contact takes
    over, the samples may miss the segment in between. The contacts of both segments are followed past their
    common end, up to the distance of a sample.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments

    Returns
    -------
    Samples
    """
    # Distances from the end of a segment, in sample steps.
    steps = np.array((0.002, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7))
    inner, ends, jump = _at_ends(segments)
    passed = np.bitwise_count(segments.reliefs[inner] ^ segments.reliefs[inner + 1])
    passed[segments.pair[inner] != segments.pair[inner + 1]] = 0
    chosen = np.flatnonzero((np.abs(jump) > LATE_ROLL_RAD * engagement.lever) | (passed > 1))
    # The first segment is followed to larger rolls, the second to smaller ones.
    second, row = (index.ravel().repeat(steps.size) for index in np.meshgrid((0, 1), chosen, indexing="ij"))
    segment, away = inner[row] + second, np.tile(steps, 2 * chosen.size) * (1 - 2 * second)
    roll = segments.high[inner[row]] + engagement.pitch[0] / SAMPLES_PER_PITCH * away
    place, limit = ends[second, 1:3, row].T, segments.limit[:, segment]
    followed = segments.case[segment], roll, place, limit, segments.pair[segment]
    return _ahead(engagement, segments, followed)[2]


def _at_ends(segments: CycleSegments) -> tuple[Integers, FloatArray, FloatArray]:
    """Return the segments (k,) that are followed by another segment of the same case, the values of both at
    their common end, (2, rows, k), and the difference of f, mm: positive if the second is earlier."""
    inner = _inner(segments)
    ends = np.stack([segments.values_at(inner + k, segments.high[inner]) for k in (0, 1)])
    return inner, ends, ends[0, 0] - ends[1, 0]


def overtaken(
    engagement: Engagement, samples: Samples, segments: CycleSegments
) -> tuple[Integers, Integers, Samples]:
    """Compare neighbouring segments at their common end.

    Parameters
    ----------
    engagement : Engagement
    samples : Samples
    segments : CycleSegments

    Returns
    -------
    jumps : ndarray of int
        Segments at whose end the curve jumps, because a contact between the samples is missing.
    cases : ndarray of int
        Cases in which the search missed an earlier contact of the neighbouring kind.
    samples : Samples
        The samples, with such contacts corrected.
    """
    (inner, ends, jump), contacts = _at_ends(segments), samples.contacts
    jumps = np.flatnonzero(np.abs(jump) > LATE_ROLL_RAD * engagement.lever)
    if not jumps.size:
        return jumps, jumps, samples
    # Follow the contact of the earlier segment to the samples of the later one.
    early = (jump[jumps] > 0.0).astype(int)
    at_sample = segments.number(engagement, samples.case, samples.roll)
    which, row = np.nonzero(at_sample == (inner[jumps] + 1 - early)[:, None])
    segment, place = (inner[jumps] + early)[which], ends[early, 1:3, jumps].T[:, which]
    carriers = segments.limit[:, segment], segments.pair[segment]
    values, _, within = followed_contacts(engagement, samples.case[row], samples.roll[row], place, *carriers)
    # Of two neighbours, the earlier is written last.
    better = np.flatnonzero(within & (values[0] < contacts.f[row]))
    better = better[np.argsort(-values[0, better], kind="stable")]
    row, values, segment, which = row[better], values[:, better], segment[better], which[better]
    which = which[values[0] < contacts.f[row] - LATE_ROLL_RAD * engagement.lever]
    contacts.f[row], contacts.place[:, row], contacts.meeting[:, row] = values[0], values[1:3], values[3:]
    contacts.limit[:, row], contacts.pair[row] = segments.limit[:, segment], segments.pair[segment]
    jumps = inner[jumps]
    return np.delete(jumps, which), segments.case[jumps[which]], samples


def earlier(engagement: Engagement, segments: CycleSegments, near: Samples) -> Samples:
    """Return contacts that are earlier than the segments.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments
    near : Samples
        Local minima of the clearance at the samples, as `near` of `found_with_others`.

    Returns
    -------
    Samples
    """
    # First pass: contacts at fixed distances from the samples.
    later = _not_first(engagement, segments, near)
    parts = (
        _halfway(engagement, later),
        _extrapolated(engagement, segments),
        _near_ends(engagement, segments, near),
        _on_fewer_limits(segments),
    )
    ahead, margin, contacts = _ahead(engagement, segments, _joined(parts))
    # Second pass: at the minima and corners that the first pass shows.
    shape = later.case.size, BETWEEN_SAMPLES.size
    halfway = slice(later.case.size * BETWEEN_SAMPLES.size)
    table, margin = ahead[halfway].reshape(shape), margin[:, halfway].reshape(len(margin), *shape)
    more = _joined((_at_lowest(engagement, later, table), _at_limits(engagement, later, table, margin)))
    return contacts.and_also(_ahead(engagement, segments, more)[2]) if more[0].size else contacts


def _joined(parts: tuple[Followed, ...]) -> Followed:
    """Return the contacts of all parts."""
    case, roll, place, limit, pair = (np.concatenate(rows, axis=-1) for rows in zip(*parts, strict=True))
    return case, roll, place, limit, pair


def _ahead(
    engagement: Engagement, segments: CycleSegments, followed: Followed
) -> tuple[FloatArray, FloatArray, Samples]:
    """Return f of followed contacts minus f of the segments (n,) and their limits (8, n), mm, NaN without
    a contact; and the contacts within the limits that are earlier than the segments."""
    case, roll, place, limit, pair = followed
    values, margin, within = followed_contacts(engagement, case, roll, place, limit, pair)
    ahead = values[0] - segments.values_at(segments.number(engagement, case, roll), roll, 1)[0]
    row = np.flatnonzero(within & (ahead < -LATE_ROLL_RAD * engagement.lever))
    values, solved = values[:, row], np.full(row.size, FirstStatus.SOLVED, dtype=np.int8)
    contacts = Found(values[0], values[1:3], values[3:], limit[:, row], pair[row], solved)
    return ahead, margin, samples_of(case[row], roll[row], contacts)


def _extrapolated(engagement: Engagement, segments: CycleSegments) -> Followed:
    """Return the contacts of segments that are continued by their own length before and after their ends."""
    count = 64  # rolls of a pitch
    segment = np.arange(segments.case.size).repeat(count)
    roll = engagement.roll[segments.case[segment]] + engagement.pitch[0] * np.tile(
        np.arange(count) / count, segments.case.size
    )
    away = np.maximum(segments.low[segment] - roll, roll - segments.high[segment])
    chosen = (away > 0.0) & (away < (segments.high - segments.low)[segment])
    segment, roll, ends = segment[chosen], roll[chosen], segments.rolls(np.array((-1.0, 0.0, 1.0)))
    first, middle, last = segments.values(np.arange(segments.case.size), ends)[1:3, segment].transpose(
        2, 0, 1
    )
    sense = (roll - ends[segment, 1]) / (ends[segment, 2] - ends[segment, 1])  # extrapolate along a parabola
    place = middle + 0.5 * sense * (last - first + sense * (first - 2.0 * middle + last))
    return segments.case[segment], roll, place, segments.limit[:, segment], segments.pair[segment]


def _not_first(engagement: Engagement, segments: CycleSegments, near: Samples) -> Samples:
    """Return the contacts `near` samples that are not the first there."""
    near = near.pick(np.isin(near.case, segments.case))
    there = segments.values_at(segments.number(engagement, near.case, near.roll), near.roll, 1)[0]
    return near.pick(np.flatnonzero(near.contacts.f > there + LATE_ROLL_RAD * engagement.lever))


def _halfway(engagement: Engagement, later: Samples) -> Followed:
    """Return contacts that are not the first at samples, at rolls up to halfway to the next samples; NaN
    outside the cycle."""
    row = np.arange(later.case.size).repeat(BETWEEN_SAMPLES.size)
    turned = (
        later.roll[row]
        - engagement.roll[later.case[row]]
        + engagement.pitch[0] / SAMPLES_PER_PITCH * np.tile(BETWEEN_SAMPLES, later.case.size)
    )
    inside = (turned >= 0.0) & (turned <= engagement.pitch[0])
    return _moved(later, row, np.where(inside, engagement.roll[later.case[row]] + turned, np.nan))


def _at_lowest(engagement: Engagement, later: Samples, ahead: FloatArray) -> Followed:
    """Return contacts at the minimum of f relative to the segments, by parabolas through f `ahead` (n,
    rolls), mm, if it may be negative: only there, a tooth pair can be the first."""
    before, middle, after = ahead[:, :-2], ahead[:, 1:-1], ahead[:, 2:]
    fall, bend = after - before, before - 2.0 * middle + after
    with np.errstate(invalid="ignore", divide="ignore"):
        lowest = (middle <= before) & (middle <= after) & (middle - 0.125 * fall * fall / bend < 0.0)
        # Left out: contacts that are not later than the segments at two neighbouring rolls. Such a contact is
        # itself the first one there.
        itself = np.minimum(before, after) <= LATE_ROLL_RAD * engagement.lever
        row, column = np.nonzero(lowest & (bend > 0.0) & ~itself)
        away = BETWEEN_SAMPLES[column + 1] - 0.5 * (fall / bend)[row, column] * (
            BETWEEN_SAMPLES[1] - BETWEEN_SAMPLES[0]
        )
    return _moved(later, row, later.roll[row] + engagement.pitch[0] / SAMPLES_PER_PITCH * away)


def _at_limits(engagement: Engagement, later: Samples, ahead: FloatArray, margin: FloatArray) -> Followed:
    """Return contacts at the corner where they reach a second limit, and further on, if f relative to the
    segments, `ahead` (n, rolls), is negative beyond. `margin` (8, n, rolls), mm."""
    out = margin.argmin(axis=0)
    steps = np.array((0.0, 0.02, 0.05, 0.1, 0.2))  # from the corner on, in sample steps
    parts = []
    for sense in (1, -1):
        inside, beyond = (slice(None, -1), slice(1, None))[::sense]
        code, least = out[:, beyond], margin.min(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            leaves = (least[:, inside] >= 0.0) & (least[:, beyond] < 0.0) & (ahead[:, beyond] < 0.0)
            row, column = np.nonzero(leaves & (later.contacts.limit[1] < 0)[:, None])
            code = code[row, column]
            first, last = (margin[code, row, column + k] for k in (0, 1)[::sense])
        away = BETWEEN_SAMPLES[column + (sense < 0)] + sense * (
            BETWEEN_SAMPLES[1] - BETWEEN_SAMPLES[0]
        ) * first / (first - last)
        row, away = row.repeat(steps.size), (away[:, None] + sense * steps).ravel()
        moved = _moved(later, row, later.roll[row] + engagement.pitch[0] / SAMPLES_PER_PITCH * away)
        limit = np.sort((moved[3][0], code.astype(np.int8).repeat(steps.size)), axis=0)[::-1]
        parts.append((*moved[:3], limit, moved[4]))
    return _joined(tuple(parts))


def _moved(later: Samples, row: Integers, roll: FloatArray) -> Followed:
    """Return the contacts `row` (n,) at other rolls (n,), rad."""
    contacts = later.contacts
    return later.case[row], roll, contacts.place[:, row], contacts.limit[:, row], contacts.pair[row]


def _near_ends(engagement: Engagement, segments: CycleSegments, near: Samples) -> Followed:
    """Return contacts `near` samples at the next ends of segments before and after, up to the distance of
    a sample."""
    inner = _inner(segments)
    ends = order_of(engagement, segments.case[inner], segments.high[inner])
    after = np.searchsorted(ends, order_of(engagement, near.case, near.roll))
    row, nearest = np.tile(np.arange(near.case.size), 2), np.append(after - 1, after)
    known = (nearest >= 0) & (nearest < inner.size)
    row, end = row[known], inner[nearest[known]]
    away = np.abs(segments.high[end] - near.roll[row])
    close = (near.case[row] == segments.case[end]) & (away <= engagement.pitch[0] / SAMPLES_PER_PITCH)
    return _moved(near, row[close], segments.high[end[close]])


def _on_fewer_limits(segments: CycleSegments) -> Followed:
    """Return contacts with one active limit less along the segments."""
    nodes = basis_of(8).nodes
    every, roll = np.arange(segments.case.size), segments.rolls(nodes)
    segment, place = every.repeat(nodes.size), segments.values(every, roll)[1:3].reshape(2, -1)
    first, second = segments.limit[:, segment]
    less = np.array(((second, first), np.full((2, segment.size), -1, dtype=np.int8)))
    which, row = np.nonzero((first >= 0, second >= 0))
    segment, limit = segment[row], less[:, which, row]
    return segments.case[segment], roll.ravel()[row], place[:, row], limit, segments.pair[segment]


def _inner(segments: CycleSegments) -> Integers:
    """Return the segments that are followed by another segment of the same case."""
    return np.flatnonzero(segments.case[1:] == segments.case[:-1])


def followed_contacts(
    engagement: Engagement, case: Integers, roll: FloatArray, place: FloatArray, limit: Codes, pair: Integers
) -> tuple[FloatArray, FloatArray, Mask]:
    """Return contacts of tooth pairs (n,) near places (2, n) with the active limits (2, n): f, s1, z1, s2,
    z2 (5, n), the other limits (8, n), mm, and whether these are satisfied."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        task = engagement.at(case, roll).task(np.arange(case.size), pair).with_fillets_at(place)
        values = held_to(task, place, limit, 4)
        margin = np.where(holding(limit), 0.0, values[QUANTITY_COUNT:])
    return values[:QUANTITY_COUNT], margin, np.asarray((margin >= -ON_LIMIT_DEPTHS * task.depth).all(axis=0))
