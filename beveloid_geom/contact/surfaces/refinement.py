"""More samples of a curve of contact where it has kinks or leaves the flanks.

The second derivatives of a flank jump where a relief begins, so that the curve has a kink there. The tangents
at the ends of an interval with one kink intersect near it. Contacts just before and after it, together with
the ends, show that the curve is one.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from .curve import MARGINS, NEAR_STEPS, STATE, Curve, broken, sampled
from .limits import Problem, on_plane
from .tangency import Contacts, solve


def with_more_samples(problem: Problem, curve: Curve) -> Curve:
    """Return a curve over s1 with two more contacts in each interval that is not smooth or in which the curve
    leaves the flanks.

    They are just before and after the kink of an interval that is not smooth. Otherwise they divide the
    interval into thirds."""
    gaps, inside = broken(problem, curve), curve.value[MARGINS].min(axis=0) >= 0.0
    after = np.flatnonzero((gaps | (inside[:, 1:] != inside[:, :-1])).any(axis=0))
    with np.errstate(invalid="ignore", divide="ignore"):
        start, place, across = _targets(problem, curve, after, gaps[:, after])
    plane = on_plane(problem, place.reshape(3, -1), across.reshape(3, -1))
    placed = problem.placed.of_cases(np.repeat(np.arange(len(curve.x)), 2 * after.size))
    met, _ = solve(problem.surfaces, placed, start.reshape(4, -1), plane, max_steps=NEAR_STEPS)
    return _inserted(problem, curve, after, met)


def _targets(
    problem: Problem, curve: Curve, after: Integers, gaps: Mask
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where contacts are wanted in the intervals `after`; `gaps` (cases, intervals) are not smooth.

    Returns
    -------
    start : ndarray, shape (4, cases, intervals, 2)
        Starting values, on the tangent at the nearer end that is known.
    place, across : ndarray, shape (3, cases, intervals, 2)
        Plane in which the contact is wanted, as for `on_plane`: across the tangent before or after a kink,
        across the chord, or at a given s1 if an end is unknown. `place` is in mm and rad, `across` in the
        units of `Problem.scale`.
    """
    # Distance from a kink in the units of `Problem.scale`.
    next_to_kink = 5e-4
    scale, s1_axis = problem.scale[:, None, None], np.eye(3)[0][:, None, None]
    ends, rates = ([rows[STATE][..., after + k] for k in (0, 1)] for rows in (curve.value, curve.rate))
    known = [np.isfinite(end).all(axis=0) for end in ends]
    both = known[0] & known[1]
    chord = (ends[1] - ends[0])[:3] / scale
    length = np.linalg.norm(chord, axis=0)
    tangents = [rate[:3] / scale / np.linalg.norm(rate[:3] / scale, axis=0) for rate in rates]
    to_kink = [kink_distance(chord, tangents[k], tangents[1 - k]) for k in (0, 1)]
    kinked = gaps & np.all([(each > 0.0) & (each < 2.0 * length) for each in to_kink], axis=0)
    low, high = curve.x[:, after], curve.x[:, after + 1]
    targets = []
    for k, sense in ((0, 1.0), (1, -1.0)):
        share = (1 + k) / 3.0
        on_chord = ends[0][:3] / scale + share * chord
        place = np.where(both, on_chord, (low + share * (high - low)) / problem.scale[0] * s1_axis)
        across = np.where(both, chord / length, s1_axis)
        away = np.maximum(to_kink[k] - next_to_kink, 0.5 * to_kink[k])
        place = np.where(kinked, ends[k][:3] / scale + sense * away * tangents[k], place)
        across = np.where(kinked, tangents[k], across)
        end, rate = (np.where(known[k], rows[k], rows[1 - k]) for rows in (ends, rates))
        step = ((place - end[:3] / scale) * across).sum(axis=0) / (rate[:3] / scale * across).sum(axis=0)
        targets.append((end + step * rate, place * scale, across))
    start, place, across = (np.stack(rows, axis=-1) for rows in zip(*targets, strict=True))
    return start, place, across


def _inserted(problem: Problem, curve: Curve, after: Integers, met: Contacts) -> Curve:
    """Return a curve over s1 with contacts (cases * intervals * 2) in the intervals `after`. Those that are
    not in their interval, or not in this order, are not known."""
    low, high = curve.x[:, after], curve.x[:, after + 1]
    first, second = np.moveaxis(met.state[0].reshape(*low.shape, 2), -1, 0)
    good = (low < first) & (first < high), (low < second) & (second < high) & ~(first >= second)
    first = np.where(good[0], first, 0.5 * (low + np.where(good[1], second, high)))
    second = np.where(good[1], second, 0.5 * (first + high))
    met.state[:, ~np.stack(good, axis=-1).ravel()] = np.nan
    added = sampled(problem, np.stack((first, second), axis=-1).reshape(len(low), -1), met, None)
    places = np.repeat(after + 1, 2)
    x, value, rate = (
        np.insert(old, places, new, axis=-1)
        for old, new in ((curve.x, added.x), (curve.value, added.value), (curve.rate, added.rate))
    )
    return Curve(x, value, rate, by_s1=True)


def kink_distance(chord: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the distance (...) from an end of a chord to the place where the unit tangents `before` at this
    end and `after` at the other one, (3, ...), are closest to each other."""
    cos = (before * after).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((chord * (before - cos * after)).sum(axis=0) / (1.0 - cos * cos))
