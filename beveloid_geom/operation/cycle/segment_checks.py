"""Checks of the segments of a mesh cycle: against first contacts, for convergence, and against limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import Integers
from ..engagement import Engagement
from ..search.local_clearance import limits_at
from .cycle_segments import QUANTITY_COUNT, CycleSegments, Samples, converged, holding
from .missed_contacts import LATE_ROLL_RAD, followed_contacts


def checked_segments(
    engagement: Engagement, segments: CycleSegments, segment: Integers, checks: Samples, strict: bool
) -> tuple[Samples, Integers]:
    """Compare segments with first contacts at the same rolls.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments
    segment : ndarray of int, shape (n,)
        Segments at the samples.
    checks : Samples
        First contacts (n,).
    strict : bool
        Whether the polynomials must have converged.

    Returns
    -------
    samples : Samples
        The first contacts, with cuts where the segment is later. If the segment is earlier and its contact is
        within all limits, the search missed this contact, and the sample is omitted. If its contact violates
        a limit, the segment is cut as well.
    bad : ndarray of int
        Segments that are cut or have not converged.
    """
    values, bound = segments.values_at(segment, checks.roll), LATE_ROLL_RAD * engagement.lever
    behind = values[0] - checks.contacts.f
    good, earlier = np.abs(behind) <= bound, np.asarray(behind < -bound)
    if earlier.any():
        row = np.flatnonzero(earlier)
        carriers = segments.limit[:, segment[row]], segments.pair[segment[row]]
        there, _, within = followed_contacts(
            engagement, checks.case[row], checks.roll[row], values[1:3, row], *carriers
        )
        earlier[row] = within & (np.abs(values[0, row] - there[0]) <= bound)
    # Convergence limits for the trailing Chebyshev coefficients of f (relative to the lever) and of the
    # positions (relative to the tooth depth).
    tail_tolerances = np.array((1e-14, 1e-11, 1e-11, 1e-11, 1e-11))
    bad = ~converged(engagement, segments, tail_tolerances if strict else np.full(QUANTITY_COUNT, np.inf))
    bad[segment[~good & ~earlier]] = True
    checks = replace(checks, cut=checks.cut | ~good)
    return checks.pick(~earlier), np.flatnonzero(bad)


def halved(engagement: Engagement, segments: CycleSegments, samples: Samples, bad: Integers) -> Samples:
    """Cut segments without convergence next to their middle.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments
    samples : Samples
        First contacts.
    bad : ndarray of int
        Segments that disagree with a sample or have not converged.

    Returns
    -------
    Samples
        The samples. A segment of `bad` is cut at the sample nearest to its middle if this sample is in its
        middle half and no later sample of the segment than the first has a cut.
    """
    segment, cut = segments.number(engagement, samples.case, samples.roll), samples.cut.copy()
    for k in bad:
        inside = np.flatnonzero(segment == k)
        away = np.abs(samples.roll[inside] - 0.5 * (segments.low[k] + segments.high[k]))
        middle = away.min(initial=np.inf) < 0.25 * (segments.high[k] - segments.low[k])
        if middle and not cut[inside[1:]].any():
            cut[inside[away.argmin()]] = True
    return replace(samples, cut=cut)


def beyond_limits(engagement: Engagement, segments: CycleSegments) -> Integers:
    """Return the segments whose contacts violate limits that are not active.

    Parameters
    ----------
    engagement : Engagement
    segments : CycleSegments

    Returns
    -------
    ndarray of int
        Numbers of the segments.
    """
    places = np.array((-1.0, -0.5, 0.0, 0.5, 1.0))
    every, roll = np.arange(segments.case.size), segments.rolls(places)
    segment, place = every.repeat(places.size), segments.values(every, roll)[1:3].reshape(2, -1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        task = engagement.at(segments.case[segment], roll.ravel()).task(
            np.arange(segment.size), segments.pair[segment]
        )
        margin = np.where(holding(segments.limit[:, segment]), 0.0, limits_at(task, *place)[0]).min(axis=0)
    return np.unique(segment[~(margin >= -1e-6 * task.depth)])
