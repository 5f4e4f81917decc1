"""Fit of the segments of a mesh cycle to sampled first contacts.

A contact solves two equations in (s1, z1), which contain its active limits. The equations are smooth in the
pinion roll, also past the ends of the segment:

    no limit      grad f = 0
    one limit     c = 0 and t.grad f = 0, with t along c = 0
    two limits    c1 = c2 = 0

with f and the limits c of `search.local_clearance`. A segment ends where its contact passes the beginning of
a relief. Each segment is fitted on the surface with or without the relief, which is smooth past this point.

The samples give the kinds of contact. Newton's method gives the contacts of each kind at Chebyshev nodes of
the roll. The polynomials through them give the roll at which the next contact takes over: its f is smaller,
or it comes within its limits. Fit and ends are iterated.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import Limit
from ...support.chebyshev import basis_of, evaluate
from ..engagement import Engagement
from ..search.earliest_contact import SAME_ROLL_RAD
from ..search.local_clearance import Local, hessian, local_at
from ..search.search_task import Task
from .cycle_segments import (
    EXTRAPOLATION_HALF_LENGTHS,
    QUANTITY_COUNT,
    SEGMENT_DEGREE,
    CycleSegments,
    Samples,
    concatenated,
    converged,
    holding,
    order_of,
    rolls_between,
    tails_of,
)

END_TOLERANCE_PITCHES = 1e-12
"""Movement of the ends of segments at which the fits end."""


def fitted(engagement: Engagement, samples: Samples) -> CycleSegments:
    """Fit segments to the samples of each case.

    Parameters
    ----------
    engagement : Engagement
        One position for each case: the first roll of the curve.
    samples : Samples

    Returns
    -------
    CycleSegments
        Each ends where the next takes over.
    """
    max_fits = 12
    segments, runs, limits = _runs_of(engagement, samples)
    number, done, former = np.arange(segments.case.size), [], None
    ends = limits[0]
    for count in range(max_fits):
        starts = _starts(engagement, samples, segments, runs, former)
        fit = replace(segments, coefficients=_coefficients(engagement, segments, starts))
        joined = np.flatnonzero(segments.case[1:] == segments.case[:-1])
        end_rolls = _ends(engagement, fit, joined, limits[:, joined])
        low, high = segments.low.copy(), segments.high.copy()
        low[joined + 1], high[joined] = end_rolls, end_rolls
        segments = replace(fit, low=low, high=high)
        # Cases are complete when their ends are stationary, or known from exact polynomials.
        steady = np.ones(segments.case.size, dtype=bool)
        steady[joined] = np.abs(end_rolls - ends[joined]) <= END_TOLERANCE_PITCHES * engagement.pitch[0]
        slack = 1e-3 * (fit.high - fit.low)  # extrapolation beyond this amplifies rounding
        known = (low >= fit.low - slack) & (high <= fit.high + slack) & _resolved(engagement, fit)
        steady, known = (_of_complete_cases(mask, segments.case) for mask in (steady, known))
        ready = steady | known | (count == max_fits - 1)
        moved = np.flatnonzero(ready & ~steady)  # refit between the new ends
        values = fit.values(moved, segments.pick(moved).rolls(basis_of(SEGMENT_DEGREE).nodes))
        segments.coefficients[:, moved] = basis_of(SEGMENT_DEGREE).coefficients(values)
        ended, on = np.flatnonzero(ready), np.flatnonzero(~ready)
        done.append((number[ended], segments.pick(ended)))
        if not on.size:
            break
        # Allow the ends to move past their samples, as far as the polynomials can be extrapolated.
        ends, length = high, high - low
        reach = 0.5 * (EXTRAPOLATION_HALF_LENGTHS - 1.0) * np.minimum(length[:-1], length[1:])
        limits[0, :-1] = np.maximum(limits[0, :-1], ends[:-1] - reach)
        limits[1, :-1] = np.minimum(limits[1, :-1], ends[:-1] + reach)
        number, segments, former = number[on], segments.pick(on), fit.pick(on)
        runs, limits, ends = runs[:, on], limits[:, on], ends[on]
    order = np.concatenate([numbers for numbers, _ in done]).argsort()
    return _without_short(engagement, concatenated([part for _, part in done]).pick(order), samples)


def _runs_of(engagement: Engagement, samples: Samples) -> tuple[CycleSegments, Integers, FloatArray]:
    """Return segments without coefficients, each over all rolls at which its contact can be the first; the
    first and last sample of each, (2, n); and the rolls (2, n), rad, between which the next segment of the
    same case takes over."""
    contacts, case = samples.contacts, samples.case
    on_fillet = engagement.on_fillets(contacts.place, contacts.meeting)
    past = engagement.past_reliefs(contacts.place, contacts.meeting)
    reliefs = np.left_shift(past > 0.0, np.arange(len(past))[:, None]).sum(axis=0)
    label = np.array((case, contacts.pair, *contacts.limit, *on_fillet, reliefs))
    if engagement.measured:
        label = np.array((*label, _branches(engagement, samples, on_fillet, reliefs, label)))
    begins = np.append(True, (label[:, 1:] != label[:, :-1]).any(axis=0) | samples.cut[1:])
    first = np.flatnonzero(begins)
    last = np.append(first[1:], case.size) - 1
    joined = np.flatnonzero(case[first[1:]] == case[last[:-1]])
    low, high = samples.roll[first], samples.roll[last]
    same = (label[:, first[joined]] == label[:, first[joined + 1]]).all(axis=0)  # cut
    limits = np.stack((high, high))
    limits[0, joined] = samples.roll[np.where(same, first[joined + 1], last[joined])]
    limits[1, joined] = samples.roll[first[joined + 1]]
    low[joined + 1], high[joined] = limits[:, joined]
    coefficients = np.empty((0, first.size, 0))
    rows = contacts.pair[first], contacts.limit[:, first], on_fillet[:, first], reliefs[first]
    return CycleSegments(case[first], low, high, coefficients, *rows), np.stack((first, last)), limits


def _branches(
    engagement: Engagement, samples: Samples, on_fillet: Mask, reliefs: Integers, label: Integers
) -> Integers:
    """Return numbers (n,) that change between neighbouring samples of the same kind at different minima.

    Each contact is followed to the roll of the next sample and of the previous one. If neither follows the
    other, one tooth pair touches at two places between them."""
    # Distance, relative to the tooth depth, within which contacts are the same.
    same_place_depths = 1e-6
    contacts, here = samples.contacts, np.arange(samples.case.size)
    size, reached = engagement.pinion.tip - engagement.pinion.root, np.zeros(here.size, dtype=bool)
    for away in (1, -1):
        # The contacts of `row`, at the rolls of the neighbours `to`.
        row, to = (here[:-1], here[1:]) if away > 0 else (here[1:], here[:-1])
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            task = engagement.at(samples.case[row], samples.roll[to]).task(
                np.arange(row.size), contacts.pair[row], on_fillet[:, row]
            )
            values = held_to(_on_reliefs(task, reliefs[row]), contacts.place[:, row], contacts.limit[:, row])
            reached[1:] |= np.abs(values[1:3] - contacts.place[:, to]).max(axis=0) <= same_place_depths * size
    same = (label[:, 1:] == label[:, :-1]).all(axis=0)
    return np.append(0, np.cumsum(same & ~reached[1:]))


def _of_complete_cases(mask: Mask, case: Integers) -> Mask:
    """Return for each segment whether all segments of its case are marked."""
    return np.asarray(~np.isin(case, case[~mask]))


def _resolved(engagement: Engagement, segments: CycleSegments) -> Mask:
    """Return whether all polynomials of a segment are exact to rounding on their range: the contact does
    not cross a joint of flank and fillet, where it is not smooth, and the trailing coefficients are
    rounding."""
    s = evaluate(segments.coefficients[[1, 3]], np.linspace(-1.0, 1.0, SEGMENT_DEGREE + 1))
    z = evaluate(segments.coefficients[[2, 4]], np.linspace(-1.0, 1.0, SEGMENT_DEGREE + 1))
    below = engagement.on_fillets((s[0], z[0]), (s[1], z[1]))
    smooth = (below == segments.on_fillet[..., None]).all(axis=(0, 2))
    # Trailing coefficients that are rounding: of f relative to the lever, of the positions relative to the
    # tooth depth. Such polynomials are valid on every part of their range.
    rounding_tails = np.array((1e-15, 1e-11, 1e-11, 1e-11, 1e-11))
    return np.asarray(smooth & converged(engagement, segments, rounding_tails))


def _without_short(engagement: Engagement, segments: CycleSegments, samples: Samples) -> CycleSegments:
    """Return the segments that are longer than the minimum length. Each begins at the end of the one
    before, so that they cover the samples of their case."""
    # Shorter segments are removed: rounding may exchange two contacts at a change.
    shortest_pitches = 1e-9
    long = segments.high - segments.low > shortest_pitches * engagement.pitch[0]
    segments = replace(segments.pick(long), coefficients=segments.coefficients[:QUANTITY_COUNT, long])
    same = segments.case[1:] == segments.case[:-1]
    low, high = segments.low.copy(), segments.high.copy()
    start, stop = samples.ends(segments.case)
    low[1:] = np.where(same, high[:-1], start[1:])
    low[:1] = start[:1]
    ends = np.append(~same, True)
    high[ends] = stop[ends]
    return replace(segments, low=low, high=high)


def _starts(
    engagement: Engagement,
    samples: Samples,
    segments: CycleSegments,
    runs: Integers,
    former: CycleSegments | None,
) -> FloatArray:
    """Return starting points (2, n * (SEGMENT_DEGREE + 1)) of Newton's method at the nodes: from a `former`
    fit where it is accurate, otherwise by linear interpolation between the samples of the segment, from the
    first to the last of its `runs` (2, n)."""
    roll = segments.rolls(basis_of(SEGMENT_DEGREE).nodes)
    order = order_of(engagement, samples.case, samples.roll)
    after = np.searchsorted(order, order_of(engagement, segments.case.repeat(roll.shape[1]), roll.ravel()))
    first, last = (run.repeat(roll.shape[1]) for run in runs)
    before = np.maximum(np.minimum(after, last) - 1, first)
    after = np.minimum(before + 1, last)
    step = samples.roll[after] - samples.roll[before]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        share = np.clip(np.where(step > 0.0, (roll.ravel() - samples.roll[before]) / step, 0.0), -1.0, 2.0)
    place = samples.contacts.place[:, before]
    place = place + share * (samples.contacts.place[:, after] - place)
    if former is None:
        return np.asarray(place)
    known = (tails_of(former)[1:3] <= 1e-6 * (engagement.pinion.tip - engagement.pinion.root)).all(axis=0)
    fit = former.values(np.arange(known.size), roll)[1:3]
    return np.where(known.repeat(roll.shape[1]), fit.reshape(2, -1), place)


def _coefficients(engagement: Engagement, segments: CycleSegments, starts: FloatArray) -> FloatArray:
    """Return Chebyshev coefficients (13, n, SEGMENT_DEGREE + 1) of f, positions and limits; NaN where a
    contact is not found."""
    basis = basis_of(SEGMENT_DEGREE)
    roll = segments.rolls(basis.nodes)
    case = segments.case.repeat(roll.shape[1])
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        here = engagement.at(case, roll.ravel())
        fillet = segments.on_fillet.repeat(roll.shape[1], axis=1)
        task = here.task(np.arange(case.size), segments.pair.repeat(roll.shape[1]), fillet)
        task = _on_reliefs(task, segments.reliefs.repeat(roll.shape[1]))
        values = held_to(task, starts, segments.limit.repeat(roll.shape[1], axis=1))
        return basis.coefficients(values.reshape(-1, *roll.shape))


def _on_reliefs(task: Task, reliefs: Integers) -> Task:
    """Return tasks (n,) to which the `reliefs` (n,) apply, also beyond their beginning, so that the surfaces
    are smooth."""
    first, second = (
        0 if surface.modification is None else len(surface.modification.reliefs)
        for surface in (task.pinion, task.gear)
    )
    if not first + second:
        return task
    on = _bits(reliefs, first + second)
    return replace(task, reliefs=(on[:first], on[first:]))


def _bits(numbers: Integers, count: int) -> Mask:
    """Return the lowest `count` bits of numbers (n,), as (count, n)."""
    return np.asarray((numbers >> np.arange(count)[:, None]) & 1 == 1)


def held_to(task: Task, place: FloatArray, limit: Codes, most: int = 12) -> FloatArray:
    """Compute contacts with given active limits by Newton's method.

    Parameters
    ----------
    task : Task
        Tooth pairs (n,).
    place : ndarray, shape (2, n)
        Starting points (s1, z1), mm.
    limit : ndarray of int, shape (2, n)
        Codes of the active limits, -1 for none.
    most : int
        Maximum number of steps.

    Returns
    -------
    ndarray, shape (13, n)
        f, s1, z1, s2, z2 and the eight limits, mm; NaN where the iteration does not converge.
    """
    # Largest Newton step, in tooth depths, after which the iteration ends. The remaining error of the place
    # is of the order of its square. The error of the Taylor series after this step is of the order of its
    # cube for f and the limits, and of its square for s2 and z2.
    last_step_depths = 1e-7
    # Change of f by a step along the flanks, mm, that is rounding. On flanks that nearly touch along a line,
    # such steps remain longer, because the place along the line is uncertain.
    smallest_change_mm = 1e-18
    largest = np.array(((task.depth,), (task.pinion.half_width,)))  # step along profile and face, mm
    contacts = np.full((QUANTITY_COUNT + len(Limit), limit.shape[1]), np.nan)
    going = np.arange(limit.shape[1])
    for _ in range(most):
        here = local_at(task, *place)
        step = _newton_step(here, limit)
        if task.line is not None:
            step = _onto_lines(task, place, here, limit, step)
        size = np.abs(step).max(axis=0) / task.depth
        if (size > 1.0).any():  # along a flat valley of the clearance, steps may lead far beyond the faces
            step = step / np.maximum(np.abs(step / largest).max(axis=0), 1.0)
        ended = size <= last_step_depths
        if not ended.all():
            ended |= (limit[0] < 0) & (np.abs((here.slope * step).sum(axis=0)) <= smallest_change_mm)
        last, place = np.flatnonzero(ended), place + step
        if last.size:
            there = here.after(step)
            rows = np.concatenate((there.f[None], place, there.meeting, there.margin))
            contacts[:, going[last]] = rows.take(last, axis=1)
        stays = np.flatnonzero(~ended & (size < np.inf))
        if not stays.size:
            break
        place, limit, going, task = place[:, stays], limit[:, stays], going[stays], task.pick(stays)
    return contacts


def _onto_lines(task: Task, place: FloatArray, here: Local, limit: Codes, step: FloatArray) -> FloatArray:
    """Return the steps (2, n), with those of flanks that touch along lines replaced by steps to the path
    of contact across the lines: all points of a line are stationary."""
    assert task.line is not None
    joints, slack = (task.pinion.joint, task.gear.joint), 1e-9 * task.depth
    on = (limit[0] < 0) & np.isfinite(task.line[0])
    on &= (place[0] >= joints[0] - slack) & ~(here.meeting[0] < joints[1] - slack)
    return np.where(on, task.line[1:3] - place, step)


def _newton_step(here: Local, limit: Codes) -> FloatArray:
    """Return the Newton step (2, n) towards the contact with the active limits (2, n): the solution of the
    linearised equations of the module docstring."""
    each, (one, two) = np.arange(limit.shape[1]), limit >= 0
    (first, second), (on_first, on_second) = (
        [row[code, ..., each].T for code in limit] for row in (here.rate, here.margin)
    )
    # Second derivatives of the Lagrange function on one limit.
    pull = np.where(one, (here.slope * first).sum(axis=0) / (first * first).sum(axis=0), 0.0)
    bend = hessian(here.bend - pull * here.curve[limit[0], :, each].T)
    # Without a limit, both components of grad f are zero, otherwise its component along the first limit.
    along = np.where(one, np.array((-first[1], first[0])), ((0.0,), (1.0,)))
    level = (here.slope * along).sum(axis=0), (bend * along).sum(axis=1)
    values = np.where(one, on_first, here.slope[0]), np.where(two, on_second, level[0])
    return -_solved(np.where(one, first, bend[0]), np.where(two, second, level[1]), np.array(values))


def _solved(first: FloatArray, second: FloatArray, right: FloatArray) -> FloatArray:
    """Return solutions (2, n) of two linear equations with rows (2, n)."""
    rows = right[0] * second[1] - right[1] * first[1], first[0] * right[1] - second[0] * right[0]
    return np.asarray(np.array(rows) / (first[0] * second[1] - first[1] * second[0]))


def _ends(
    engagement: Engagement, segments: CycleSegments, before: Integers, limits: FloatArray
) -> FloatArray:
    """Return the rolls (k,), rad, between the `limits` (2, k) at which the segments `before` (k,) end and
    the next take over."""
    low, high = limits
    row, both = np.arange(before.size), segments.pick(np.append(before, before + 1))
    # Divide the interval that contains the change, first into 128 parts, then six times into 64.
    for parts in (128, *[64] * 6) if before.size else ():
        roll = rolls_between(low, high, 2.0 * np.arange(parts + 1) / parts - 1.0)
        taken = _taken_over(engagement, both, roll)
        taken[:, -1] = True
        part = np.maximum(taken.argmax(axis=1), 1)
        low, high = (np.where(taken[:, 0], low, roll[row, part - k]) for k in (1, 0))
    return np.asarray(high)


def _taken_over(engagement: Engagement, segments: CycleSegments, roll: FloatArray) -> Mask:
    """Return whether at rolls (k, m) the second half of the segments (2 k) are the first contact instead of
    the first half: within their limits and with smaller f. At equal f, tangencies come before edges, then
    the pair that came into mesh last."""
    shape = 2, *roll.shape
    values = segments.values(slice(None), np.concatenate((roll, roll)))
    f, outside = values[0].reshape(shape), _outside(engagement, segments, values).reshape(shape)
    together = np.abs(f[1] - f[0]) <= SAME_ROLL_RAD * engagement.lever
    sooner = f[1] < f[0]
    if together.any():
        edge, pair = (
            segments.limit[0].reshape(2, -1) >= 0,
            engagement.pinion.sigma * segments.pair.reshape(2, -1),
        )
        prior = np.where(edge[0] == edge[1], pair[1] < pair[0], edge[0])[:, None]
        sooner = np.where(together, prior, sooner)
    return np.asarray(np.where(outside[0] == outside[1], sooner, outside[1] < outside[0]))


def _outside(engagement: Engagement, segments: CycleSegments, values: FloatArray) -> FloatArray:
    """Return by how much (mm) contacts of segments with the `values` (13, n, m) violate limits that are not
    active, or lie beyond a joint with the fillet or the beginning of a relief; infinite where there is no
    contact."""
    margin = np.where(holding(segments.limit)[..., None], np.inf, values[QUANTITY_COUNT:]).min(axis=0)
    for j, surface in enumerate((engagement.pinion, engagement.gear)):
        (s, z), fillet = values[1 + 2 * j : 3 + 2 * j], segments.on_fillet[j]
        # On undercut flanks, the root limit decides whether a contact lies beyond the end.
        joined = s - (surface.joint if surface.crossing is None else np.minimum(surface.fillet_end(z), s))
        margin = np.minimum(margin, np.where(fillet, -1.0, 1.0)[:, None] * joined)
    past = engagement.past_reliefs(values[1:3], values[3:5])
    if len(past):
        on = _bits(segments.reliefs, len(past))[..., None]
        margin = np.minimum(margin, np.where(on, past, -past).min(axis=0))
    return np.where(np.isnan(margin), np.inf, np.maximum(-margin, 0.0))
