"""Paths of contact on parallel axes, as series like those of crossed axes.

What a pair touches along is given by `equation`: lines, or points that run along the rack line.

- A point contact has constant l1 and l2. Its path is the straight line over w1 that they give, cut off by the
  limits.
- Of a line contact the path is a straight line in the coordinates (l1, w1) of the surface of action,
  across all contact lines: from where the first of them enters the flanks to where the last one leaves. So
  its greatest less its least roll is all over which the flanks are tangent, as Eq. 16 asks.

On the line of fixed l1, eta_j = A_j + B_j w_j, the limits are explicit in w1 (`interval`): root limits
none, toe and heel linear, tip cones quadratic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...design.model import MATCH
from ...status import Status
from ...support.chebyshev import basis_of
from ..equation import Meeting, Pairing, gap_tolerance, roll_angles, terms_of
from ..path_polynomial import WIDTH, PathSeries, by_length, fitted, rows_of
from .equation import (
    along_axes,
    at_mid_face,
    mate_parameter,
    meet_on_parallel,
    one_rack,
)

SAMPLES, ROUNDS, NARROWED = (129, 49), 13, 1.5
"""Lines looked at in the first and in every other round of the search for the first and the last one; half
the window of the next round, in their distances."""
FLAT = 1e-14
"""Share of rounding in a rate that counts as zero."""
SCAN, HALVINGS = 65, 60
"""Samples between which a single root lies, and how often its interval is halved."""
BEYOND = 0.02
"""Share of its length by which a series reaches beyond what is on the flanks."""
BASES = tuple(basis_of(degree) for degree in (20, 40, 100, 200))
LINE, POINT, NONE = 0, 1, 2
"""How flanks touch."""
Lines: TypeAlias = Callable[[FloatArray], tuple[FloatArray, Meeting]]
"""As of `on_lines`."""


def interval(
    pairing: Pairing, l: FloatArray, met: Meeting, spare: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Give the range of w1 (cases, positions), mm, within all limits on the lines of fixed l (2, cases,
    positions), of which `met` is one contact: first > last where none is. A line may lie beyond the root by
    a share `spare` of the tip radius, and a radius that is the same all along beyond the tip by that of its
    square."""
    v, square, slope = met.own[2], met.square, met.slope
    c = pairing.position
    # z and the way q along the plane in a section, both linear: value at w1 = 0 and rate.
    z = v * met.along + square * met.across - c, v * slope + square
    q = square * met.along - v * met.across, square * slope - v
    w = met.across[0]
    z, q = ((value - rate * w, rate) for value, rate in (z, q))
    ends = [((way * edge - z[0]) / z[1]) for edge in (pairing.half_width,) for way in (-1.0, 1.0)]
    low, high = np.minimum(*ends).max(axis=0), np.maximum(*ends).min(axis=0)
    tips = _under_tip(pairing.tip + pairing.taper * z[0], pairing.taper * z[1], q, met.moment / square, spare)
    low, high = np.maximum(low, tips[0].max(axis=0)), np.minimum(high, tips[1].min(axis=0))
    inside = ((l >= pairing.lowest - spare * pairing.tip) & np.isfinite(met.along)).all(axis=0)
    return np.where(inside, low, np.inf), np.where(inside, high, -np.inf)


def _under_tip(
    tip: FloatArray,
    taper: FloatArray,
    q: tuple[FloatArray, FloatArray],
    arm: FloatArray,
    spare: float,
) -> tuple[FloatArray, FloatArray]:
    """Give the range of w in which sqrt((q0 + q1 w)^2 + arm^2) <= tip + taper w: one interval, as the left
    side is convex. Empty ones come out as (inf, -inf)."""
    a, b = taper * taper - q[1] * q[1], taper * tip - q[0] * q[1]
    c = tip * tip - q[0] * q[0] - arm * arm
    a, b = np.where(np.abs(a) <= FLAT, 0.0, a), np.where(np.abs(b) <= FLAT * tip, 0.0, b)
    root = np.sqrt(b * b - a * c)
    far = -(b + np.copysign(root, b))
    lower, upper = np.sort(np.array((far / a, c / far)), axis=0)
    # a < 0: between the roots; else, a cone steeper than the path, beyond one of them.
    steep, up = a >= 0.0, np.where(a == 0.0, b > 0.0, taper > 0.0)
    low = np.where(steep, np.where(up, upper, -np.inf), lower)
    high = np.where(steep & up, np.inf, np.where(steep, lower, upper))
    level = (a == 0.0) & (b == 0.0)
    empty = np.isnan(root) | (level & (c < -spare * tip * tip))
    low, high = np.where(level, -np.inf, low), np.where(level, np.inf, high)
    return np.where(empty, np.inf, low), np.where(empty, -np.inf, high)


def kinds_of(pairing: Pairing) -> tuple[NDArray[np.int_], FloatArray]:
    """Say how the flanks of each case touch, LINE, POINT or NONE; s of `on_racks` of a point (cases), mm."""
    a = np.broadcast_to(pairing.rack.parabola, (2, *pairing.branch.shape))[..., 0]
    plain, square = (a == 0.0).all(axis=0), along_axes(pairing)
    terms = terms_of(pairing, np.zeros((2, *pairing.branch.shape)))
    # Rack lines that cross let l2 change along w1: cones cut by racks of different pressure angles.
    matched = (np.abs(terms.own[2].sum(axis=0)) <= MATCH) & (np.abs(terms.slope.sum(axis=0)) <= MATCH)
    matched = matched[:, 0]
    kind = np.where((plain & matched) | square, LINE, NONE)
    racks = np.flatnonzero(~plain & ~square & one_rack(pairing))
    s = np.full(kind.size, np.nan)
    if racks.size:
        s[racks], conjugate = single_contact(pairing.cases(racks))
        kind[racks] = np.where(conjugate, LINE, POINT)
    return kind, s


def on_racks(pairing: Pairing, s: FloatArray) -> FloatArray:
    """Give l (2, cases, positions), mm, at which both racks have one normal: a_1 l1 = a_2 l2, the greater of
    both s."""
    a = np.broadcast_to(pairing.rack.parabola, (2, *pairing.branch.shape))
    return np.asarray(s * a[::-1] / np.abs(a).max(axis=0))


def single_contact(pairing: Pairing) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Find s (cases), mm, of the contact nearest to the middle of both flanks, NaN without one on them,
    and where all s are contacts."""
    reach = np.maximum(np.abs(pairing.lowest), np.abs(pairing.highest)).max(axis=0)

    def gap(s: FloatArray) -> FloatArray:
        l = on_racks(pairing, s)
        return np.asarray(meet_on_parallel(pairing, l, at_mid_face(pairing, l)).gap)

    s = reach * np.linspace(-1.0, 1.0, SCAN)
    values = gap(s)
    conjugate = np.asarray((np.abs(values) <= 8.0 * gap_tolerance(pairing)).all(axis=-1))
    change = np.signbit(values[:, :-1]) != np.signbit(values[:, 1:])
    change &= np.isfinite(values[:, :-1]) & np.isfinite(values[:, 1:])
    place = np.where(change, np.abs(s[:, :-1]), np.inf).argmin(axis=-1)
    case = np.arange(place.size)
    low, high, below = (
        x[:, None] for x in (s[case, place], s[case, place + 1], np.signbit(values[case, place]))
    )
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = np.signbit(gap(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.where(change.any(axis=-1), 0.5 * (low + high)[:, 0], np.nan), conjugate


def greatest_at(
    value: Callable[[FloatArray], FloatArray], first: FloatArray, last: FloatArray, way: float = 1.0
) -> FloatArray:
    """Find l1 (..., 1), mm, at which `value` (..., positions) times `way` is greatest between two, NaN where
    it is nowhere known: on lines ever closer to each other, so that a corner is found like a summit."""
    low, high = first, last
    for count in range(ROUNDS):
        l1 = low + (high - low) * np.linspace(0.0, 1.0, SAMPLES[min(count, 1)])
        values = way * value(l1)
        lost = np.isnan(values).all(axis=-1, keepdims=True)
        best = np.where(np.isnan(values), -np.inf, values).argmax(axis=-1)[..., None]
        found, step = np.take_along_axis(l1, best, axis=-1), NARROWED * (l1[..., 1:2] - l1[..., :1])
        ends = np.sort(np.array((found - step, found + step)), axis=0)
        least, most = np.minimum(first, last), np.maximum(first, last)
        low, high = np.maximum(ends[0], least), np.minimum(ends[1], most)
    return np.where(lost, np.nan, found)


def _ends_of_lines(pairing: Pairing) -> FloatArray:
    """Find l1 and w1 (2, cases, 2), mm, of the contacts at which the pinion's roll is least and greatest
    on the flanks; NaN where none lies on them.

    At a fixed l1 the roll is linear in w1, so that an end of its `interval` has it."""
    found, lines = np.empty((2, len(pairing.branch), 2)), on_lines(pairing)
    for end, way in enumerate((-1.0, 1.0)):
        roll = partial(_extreme_roll, pairing, lines, way)
        l1 = greatest_at(roll, pairing.lowest[0], pairing.highest[0], way)
        found[0, :, end], found[1, :, end] = l1[:, 0], _extreme_on(pairing, lines, way, l1)[0][:, 0]
    return found


def on_lines(pairing: Pairing) -> Lines:
    """Give the function that gives l (2, cases, positions), mm, and terms at w1 = 0 of the lines of contact
    of fixed l1 (cases, positions), mm. Without parabolas two of them tell all: l2, eta and the point of the
    rack are linear in l1, everything else stands still."""

    def solved(l1: FloatArray) -> tuple[FloatArray, Meeting]:
        """Solve at each l1."""
        l = np.array((l1, mate_parameter(pairing, l1, np.zeros(l1.shape))))
        return l, meet_on_parallel(pairing, l, np.zeros(l1.shape))

    if np.any(pairing.rack.parabola):
        return solved
    apart = np.broadcast_to(pairing.rack.pitch_radius, (2, *pairing.branch.shape))[0]
    (l, met), (far, other) = solved(0.0 * apart), solved(apart)

    def between(l1: FloatArray) -> tuple[FloatArray, Meeting]:
        """Give what lies on the line through both that are solved."""
        share = l1 / apart
        l2, along, start = (
            near + share * (end - near)
            for near, end in ((l[1], far[1]), (met.along, other.along), (met.start, other.start))
        )
        return np.array((l1, l2)), replace(met, along=along, start=start)

    return between


def _extreme_roll(pairing: Pairing, lines: Lines, way: float, l1: FloatArray) -> FloatArray:
    return _extreme_on(pairing, lines, way, l1)[1]


def _extreme_on(pairing: Pairing, lines: Lines, way: float, l1: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give w1 at which the roll times `way` is greatest on the `lines` of l1 (cases, positions), mm, the
    middle of the line where it is the same all along, and that roll; NaN beyond the limits."""
    l, met = lines(l1)
    first, last = interval(pairing, l, met)
    rate = way * met.slope[0] / met.moment[0]
    lost = ~(first <= last)
    w = np.where(rate > 0.0, last, first)
    w = np.where(np.abs(rate) * (last - first) <= FLAT, 0.5 * (first + last), w)
    w = np.where(lost, np.nan, w)
    return w, np.where(lost, np.nan, roll_angles(pairing, met)[0] + way * rate * w)


def parallel_series(pairing: Pairing) -> PathSeries:
    """Give series of the paths on parallel axes, a little beyond the flanks; OFF_FLANK where nothing on them
    touches, NO_COMMON_NORMAL where normals never agree."""
    kind, s = kinds_of(pairing)
    status = np.where(kind == NONE, np.int8(Status.NO_COMMON_NORMAL), np.int8(Status.OFF_FLANK))
    status[pairing.undefined] = Status.UNDEFINED
    guide = np.full((2, kind.size, 2), np.nan)  # l1 and w1 at both ends
    lines, points = (np.flatnonzero((kind == k) & (status == Status.OFF_FLANK)) for k in (LINE, POINT))
    l2 = np.full((kind.size, 1), np.nan)
    if lines.size:
        guide[:, lines] = _ends_of_lines(pairing.cases(lines))
    if points.size:
        part = pairing.cases(points)
        l = on_racks(part, s[points, None])
        first, last = interval(part, l, meet_on_parallel(part, l, np.zeros(l.shape[1:])))
        guide[0, points], l2[points] = l[0], l[1]
        guide[1, points] = np.where(first < last, np.concatenate((first, last), axis=-1), np.nan)
    found = np.flatnonzero(np.isfinite(guide).all(axis=(0, 2)))
    return _along(pairing, guide, l2, found, status)


def _along(
    pairing: Pairing, guide: FloatArray, l2: FloatArray, cases: NDArray[np.int_], status: NDArray[np.int8]
) -> PathSeries:
    """Give series along straight lines of l1 and w1, those of the `cases`; l2 where it is known."""
    part, (l1, w) = pairing.cases(cases), guide[:, cases]
    coefficients = np.full((WIDTH, status.size, 2), np.nan)
    if cases.size == 0:
        return by_length(coefficients, status)
    for basis in BASES:
        share = 0.5 * (1.0 + (1.0 + 2.0 * BEYOND) * basis.nodes)
        at = [x[:, :1] + (x[:, 1:] - x[:, :1]) * share for x in (l1, w)]
        mate = np.where(np.isnan(l2[cases]), mate_parameter(part, *at), l2[cases])
        l = np.array((at[0], mate))
        values, good = fitted(part, rows_of(part, l, meet_on_parallel(part, l, at[1])), basis)
        if good.all():
            break
    coefficients = np.full((WIDTH, status.size, values.shape[-1]), np.nan)
    coefficients[:, cases] = values
    status[cases] = np.where(good, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
    middle, half = (np.full((status.size, 1), np.nan) for _ in range(2))
    middle[cases], half[cases] = l1.mean(axis=-1, keepdims=True), (0.5 + BEYOND) * np.diff(l1)
    half[np.abs(half) <= FLAT * pairing.scale] = np.nan
    return PathSeries(coefficients, middle, half, status)
