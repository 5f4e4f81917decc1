"""Search for the segments of a mesh cycle: sample, fit, check, and divide the segments that fail."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Integers
from ...status import FirstStatus
from ..engagement import Engagement
from ..search.earliest_contact import Grids, found_at
from .cycle_segments import (
    QUANTITY_COUNT,
    SAMPLES_PER_PITCH,
    SEGMENT_DEGREE,
    CycleSegments,
    Samples,
    concatenated,
    samples_of,
)
from .missed_contacts import earlier, overtaken, past_ends
from .segment_checks import beyond_limits, checked_segments, halved
from .segment_fit import fitted


def _sampled(engagement: Engagement, grids: Grids, case: Integers, roll: FloatArray) -> Samples:
    return samples_of(case, roll, found_at(engagement.at(case, roll), grids))


def pitch_rolls(engagement: Engagement, number: int = SAMPLES_PER_PITCH) -> tuple[Integers, FloatArray]:
    """Return evenly spaced rolls over a pitch.

    Parameters
    ----------
    engagement : Engagement
        One position for each case: the first roll.
    number : int
        Number of steps.

    Returns
    -------
    case : ndarray of int, shape (n,)
    roll : ndarray, shape (n,)
        Pinion rolls with both ends of the pitch, rad.
    """
    share, cases = np.linspace(0.0, 1.0, number + 1), engagement.roll.size
    case = np.arange(cases).repeat(share.size)
    return case, engagement.roll[case] + np.tile(engagement.pitch[0] * share, cases)


def first_contact_segments(
    engagement: Engagement, grids: Grids, samples: Samples, near: Samples
) -> tuple[CycleSegments, Integers]:
    """Compute the segments of first contact over a pitch.

    Parameters
    ----------
    engagement : Engagement
        One position for each case: the first roll.
    grids : Grids
    samples : Samples
        First contacts at the `pitch_rolls`.
    near : Samples
        Local minima of the clearance found there, as `near` of `found_with_others`.

    Returns
    -------
    segments : CycleSegments
    status : ndarray of int, shape (cases,)
        Codes of `FirstStatus`: of the first roll that is not SOLVED, or NOT_CONVERGED. Such a case has no
        segments.
    """
    segments, status = _divided(engagement, grids, samples, near, halving=True)
    lost = status == FirstStatus.NOT_CONVERGED
    if lost.any():  # sample more densely: a contact may have been missed in all rounds
        case, roll = pitch_rolls(engagement, 64)
        samples = _sampled(engagement, grids, case[lost[case]], roll[lost[case]])
        closer, again = _divided(engagement, grids, samples, near, halving=False)
        segments, status = sorted_segments([segments, closer]), np.where(lost, again, status)
    return segments, status


def _divided(
    engagement: Engagement, grids: Grids, samples: Samples, near: Samples, halving: bool
) -> tuple[CycleSegments, Integers]:
    """Return the segments through the samples, divided until all checks pass, and the status of all cases.

    With `halving`, segments without convergence are cut next to their middle."""
    # Number of times that failing segments are divided.
    max_rounds = 8
    cases = engagement.roll.size
    status, done = np.zeros(cases, dtype=np.int64), []
    count, before = 0, b""
    while count < max_rounds:
        bad = np.flatnonzero(samples.contacts.status != FirstStatus.SOLVED)[::-1]
        status[samples.case[bad]] = samples.contacts.status[bad]
        samples = samples.pick(status[samples.case] == FirstStatus.SOLVED)
        if not 0 < samples.case.size <= 1000 * cases:
            break
        samples, segments = _fitted_past_ends(engagement, samples)
        # Compare with the samples, which also covers segments whose neighbour could not be fitted.
        segment, strict = segments.number(engagement, samples.case, samples.roll), count < max_rounds // 2
        smooth = strict and not engagement.measured
        samples, bad = checked_segments(engagement, segments, segment, samples, smooth)
        if halving and strict and bad.size:
            samples = halved(engagement, segments, samples, bad)
        checks = samples.pick(np.zeros(0, dtype=np.int64))
        if count > 0:  # in the first round there are enough samples
            places = np.array((-0.95, 0.1, 1.0))
            segment, roll = np.arange(segments.case.size).repeat(places.size), segments.rolls(places).ravel()
            checks = _sampled(engagement, grids, segments.case[segment], roll)
            checks, late = checked_segments(engagement, segments, segment, checks, smooth)
            bad = np.union1d(bad, late)
        if strict:
            bad = np.union1d(bad, beyond_limits(engagement, segments))
        # Compare neighbours at their common end, then follow contacts between the samples.
        jumps, corrected, samples = overtaken(engagement, samples, segments)
        bad = np.union1d(bad, np.append(jumps, jumps + 1))
        early = earlier(engagement, segments, near)
        failed = np.isin(np.arange(cases), np.concatenate((segments.case[bad], corrected, early.case)))
        if failed.any():
            between = _between(engagement, grids, samples, segments, bad, jumps)
            checks = checks.and_also(between).and_also(early)
        done.append(segments.pick(~failed[segments.case]))
        samples = samples.pick(failed[samples.case]).and_also(checks.pick(failed[checks.case]))
        # Where the same segments fail again, further samples would be the same: go on to the less strict
        # checks, and end if these fail too.
        ends = np.round(segments.low[failed[segments.case]] / engagement.pitch[0], 9)
        state = np.append(ends, bad).tobytes()
        count = count + 1 if state != before else max_rounds // 2 if strict else max_rounds
        before = state
    status[samples.case] = np.where(status[samples.case], status[samples.case], FirstStatus.NOT_CONVERGED)
    return sorted_segments(done), status


def _fitted_past_ends(engagement: Engagement, samples: Samples) -> tuple[Samples, CycleSegments]:
    """Return the segments through the samples and through contacts past the beginnings of reliefs that lie
    between them, and these samples."""
    segments = fitted(engagement, samples)
    if not engagement.has_reliefs:
        return samples, segments
    past = past_ends(engagement, segments)
    if past.case.size:
        samples = samples.and_also(past)
        again = fitted(engagement, samples.pick(np.isin(samples.case, past.case)))
        segments = sorted_segments([segments.pick(~np.isin(segments.case, past.case)), again])
    return samples, segments


def _between(
    engagement: Engagement,
    grids: Grids,
    samples: Samples,
    segments: CycleSegments,
    bad: Integers,
    jumps: Integers,
) -> Samples:
    """Return first contacts at more rolls in the segments `bad`, and next to the ends at which the curve
    jumps."""
    places = np.array((-0.8, -0.6, -0.4, -0.2, 0.3, 0.5, 0.7))
    aside = np.array((-1e-3, -1e-4, -1e-5, 1e-5, 1e-4, 1e-3))  # pitches
    start, stop = samples.ends(segments.case[jumps])
    next_to = np.clip(segments.high[jumps, None] + engagement.pitch[0] * aside, start[:, None], stop[:, None])
    case = np.append(segments.case[bad].repeat(places.size), segments.case[jumps].repeat(aside.size))
    return _sampled(engagement, grids, case, np.append(segments.rolls(places)[bad], next_to))


def sorted_segments(parts: list[CycleSegments]) -> CycleSegments:
    """Concatenate segments and sort them by case and roll.

    Parameters
    ----------
    parts : list of CycleSegments

    Returns
    -------
    CycleSegments
    """
    none, no, rows = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0), dtype=np.int8)
    empty = CycleSegments(
        none, no, no, np.zeros((QUANTITY_COUNT, 0, SEGMENT_DEGREE + 1)), none, rows, rows > 0, none
    )
    segments = concatenated([empty, *parts])
    return segments.pick(np.lexsort((segments.low, segments.case)))
