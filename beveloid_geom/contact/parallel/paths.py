"""Paths of contact on parallel axes, as series like those of crossed axes.

`equation` determines whether a pair has contact lines, or a point that moves along the rack line.

- A point contact has constant l1 and l2. Its path is the straight line over w1, ended by the limits.
- The path of a line contact is a straight line in the coordinates (l1, w1) of the surface of action, across
  all contact lines: from the point where the first line enters the flanks to the point where the last line
  leaves. The range of its roll is the range in which the flanks are tangent, as required for Eq. 16.

On the line of constant l1, eta_j = A_j + B_j w_j, the limits are explicit in w1 (`interval`): root limits do
not depend on w1, toe and heel are linear, and tip cones quadratic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask, Quantity
from ...design.model import NORMAL_MATCH_TOLERANCE
from ...status import Status
from ...support.chebyshev import basis_of
from ..equation import ContactTerms, gap_tolerance, roll_angles
from ..flank_pair import FlankPair, terms_of
from ..path_polynomial import FULL_ROW_COUNT, ROW_COUNT, PathSeries, fitted_series, not_over_l1, rows_of
from .equation import along_axes, at_mid_face, mate_parameter, meet_on_parallel, one_rack

NEGLIGIBLE_RATE = 1e-14
"""Relative rate that is dominated by rounding and treated as zero."""
SERIES_BASES = tuple(basis_of(degree) for degree in (20, 40, 100, 200))
Lines: TypeAlias = Callable[[FloatArray], tuple[FloatArray, ContactTerms]]
"""Result of `on_lines`."""


def interval(
    pairing: FlankPair, l: FloatArray, met: ContactTerms, spare: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the range of w1 (cases, positions), mm, within all limits on the lines of constant l.

    `l` (2, cases, positions) in mm; `met` is one contact of each line. The range is (inf, -inf) on lines
    beyond the root, and its lower bound exceeds the upper one where no part of the line is within the limits.
    With `spare`, l may be beyond the root by this fraction of the tip radius. If the radius is constant along
    the line, its square may exceed the square of the tip radius by this fraction.
    """
    v, square, slope = met.normal[2], met.square, met.slope
    c = pairing.position
    # z, and the coordinate q along the plane of action in a transverse section, are linear in w1. Each is
    # given by its value at w1 = 0 and its rate.
    z = v * met.along + square * met.across - c, v * slope + square
    q = square * met.along - v * met.across, square * slope - v
    w = met.across[0]
    z, q = ((value - rate * w, rate) for value, rate in (z, q))
    # Toe and heel of both members.
    ends = [((sense * edge - z[0]) / z[1]) for edge in (pairing.half_width,) for sense in (-1.0, 1.0)]
    low, high = np.minimum(*ends).max(axis=0), np.maximum(*ends).min(axis=0)
    # Tip cones of both members.
    tips = _under_tip(pairing.tip + pairing.taper * z[0], pairing.taper * z[1], q, met.moment / square, spare)
    low, high = np.maximum(low, tips[0].max(axis=0)), np.minimum(high, tips[1].min(axis=0))
    if pairing.edges:
        edges = _above_edges(pairing, l, z)
        low, high = np.maximum(low, edges[0]), np.minimum(high, edges[1])
    inside = ((l >= pairing.lowest - spare * pairing.tip) & np.isfinite(met.along)).all(axis=0)
    return np.where(inside, low, np.inf), np.where(inside, high, -np.inf)


def _above_edges(
    pairing: FlankPair, l: FloatArray, z: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return the range of w in which contacts at l (2, cases, positions) are above the edges of undercut.

    z is given by its value at w = 0 and its rate. At a constant l the edge is a limit of z, because it rises
    from one end of the face to the other.
    """
    low, high = np.full(l.shape[1:], -np.inf), np.full(l.shape[1:], np.inf)
    for j, edges in enumerate(pairing.edges):
        for curve, at in edges.by_curve() if edges else ():
            half = float(pairing.half_width[j, at].flat[0])
            ends = curve.start(np.array((-half, half)))
            at_toe = bool(ends[0] > ends[1])
            # If the edge is below l at all z, it limits nothing. If it is above l at all z, nothing remains.
            # Otherwise one plane bounds z.
            open_end = -np.inf if at_toe else np.inf
            here = l[j, at]
            bound = np.where(here >= ends.max(), open_end, -open_end)
            crossed = (here >= ends.min()) & (here < ends.max())
            if crossed.any():
                bound[crossed] = curve.plane(here[crossed], half)
            rate = np.broadcast_to(z[1][j], l.shape[1:])[at]
            w, first = (bound - z[0][j, at]) / rate, at_toe == (rate > 0.0)
            low[at] = np.where(first, np.maximum(low[at], w), low[at])
            high[at] = np.where(first, high[at], np.minimum(high[at], w))
    return low, high


def _under_tip(
    tip: FloatArray, taper: FloatArray, q: tuple[FloatArray, FloatArray], arm: FloatArray, spare: float
) -> tuple[FloatArray, FloatArray]:
    """Return the range of w in which sqrt((q0 + q1 w)^2 + arm^2) <= tip + taper w.

    It is one interval, because the left side is convex. Empty ranges are (inf, -inf).
    """
    a, b = taper * taper - q[1] * q[1], taper * tip - q[0] * q[1]
    c = tip * tip - q[0] * q[0] - arm * arm
    a = np.where(np.abs(a) <= NEGLIGIBLE_RATE, 0.0, a)
    b = np.where(np.abs(b) <= NEGLIGIBLE_RATE * tip, 0.0, b)
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


def contact_types(pairing: FlankPair) -> tuple[Mask, Mask, FloatArray]:
    """Return which cases have line contact, which have point contact, and s of `on_racks` of a point (cases),
    mm.
    """
    linear, spur = pairing.without_parabola, along_axes(pairing)
    terms = terms_of(pairing, np.zeros((2, *pairing.branch.shape)))
    # If the rack lines of both members cross, l2 changes along w1, and there is no line contact. This occurs
    # on cones cut by racks of different pressure angles.
    matched = (np.abs(terms.normal[2].sum(axis=0)) <= NORMAL_MATCH_TOLERANCE) & (
        np.abs(terms.slope.sum(axis=0)) <= NORMAL_MATCH_TOLERANCE
    )
    matched = matched[:, 0]
    lines = (linear & matched) | spur
    racks = np.flatnonzero(~linear & ~spur & one_rack(pairing))
    points, s = np.zeros(lines.size, dtype=bool), np.full(lines.size, np.nan)
    if racks.size:
        s[racks], lines[racks] = single_contact(pairing.cases(racks))
        points[racks] = ~lines[racks]
    return lines, points, s


def along_lines(pairing: FlankPair) -> Mask:
    """Return whether the generated flanks of each case touch along lines.

    The caller silences NumPy's warnings.

    Parameters
    ----------
    pairing : FlankPair
        Pairs of flanks (cases).

    Returns
    -------
    ndarray of bool, shape (cases,)
    """
    result = pairing.parallel & ~pairing.undefined
    at = np.flatnonzero(result)
    if at.size:
        result[at] = contact_types(pairing.cases(at))[0]
    return result


def on_racks(pairing: FlankPair, s: FloatArray) -> FloatArray:
    """Return l (2, cases, positions), mm, at which both racks have the same normal: a_1 l1 = a_2 l2.

    (l1, l2) = s (a_2, a_1) / max(|a_1|, |a_2|), with s in mm.
    """
    a = np.broadcast_to(pairing.rack.parabola, (2, *pairing.branch.shape))
    return np.asarray(s * a[::-1] / np.abs(a).max(axis=0))


def single_contact(pairing: FlankPair) -> tuple[FloatArray, Mask]:
    """Return s (cases), mm, of the contact with the smallest |s|, and whether all s are contacts.

    Contacts on both flanks are preferred. s is NaN if F has no zero up to the largest |l| of the flanks.
    """
    reach = np.maximum(np.abs(pairing.lowest), np.abs(pairing.highest)).max(axis=0)

    def gap(s: FloatArray) -> FloatArray:
        l = on_racks(pairing, s)
        return np.asarray(meet_on_parallel(pairing, l, at_mid_face(pairing, l)).gap)

    # Number of samples between which a single root lies, and of bisection steps.
    scan_samples, bisections = 65, 60
    s = reach * np.linspace(-1.0, 1.0, scan_samples)
    values = gap(s)
    conjugate = np.asarray((np.abs(values) <= 8.0 * gap_tolerance(pairing)).all(axis=-1))
    change = np.signbit(values[:, :-1]) != np.signbit(values[:, 1:])
    # The change of sign nearest to s = 0, refined by bisection.
    change &= np.isfinite(values[:, :-1]) & np.isfinite(values[:, 1:])
    l = on_racks(pairing, s)
    beyond = np.asarray(((l < pairing.lowest) | (l > pairing.highest)).any(axis=0))
    # Contacts on both flanks are preferred.
    off = np.abs(s[:, :-1]) + np.where(beyond[:, :-1], 2.0 * reach, 0.0)
    place = np.where(change, off, np.inf).argmin(axis=-1)
    case = np.arange(place.size)
    low, high, below = (
        x[:, None] for x in (s[case, place], s[case, place + 1], np.signbit(values[case, place]))
    )
    for _ in range(bisections):
        middle = 0.5 * (low + high)
        same = np.signbit(gap(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.where(change.any(axis=-1), 0.5 * (low + high)[:, 0], np.nan), conjugate


def greatest_at(
    value: Callable[[FloatArray], FloatArray], first: FloatArray, last: FloatArray, sense: Quantity = 1.0
) -> FloatArray:
    """Return l1 (..., 1), mm, between `first` and `last` at which `value` (..., positions) times `sense` is
    largest.

    NaN if the value is nowhere known. The search uses lines at decreasing distances, so that a corner is
    found like a smooth maximum.
    """
    low, high = first, last
    # Lines in the first and in the other rounds of the search for the first and the last line; number of
    # rounds; half the window of the next round, in distances of the lines.
    lines_by_round, rounds, next_half_window = (129, 49), 13, 1.5
    for count in range(rounds):
        l1 = low + (high - low) * np.linspace(0.0, 1.0, lines_by_round[min(count, 1)])
        values = sense * value(l1)
        lost = np.isnan(values).all(axis=-1, keepdims=True)
        best = np.where(np.isnan(values), -np.inf, values).argmax(axis=-1)[..., None]
        result, step = np.take_along_axis(l1, best, axis=-1), next_half_window * (l1[..., 1:2] - l1[..., :1])
        ends = np.sort(np.array((result - step, result + step)), axis=0)
        least, most = np.minimum(first, last), np.maximum(first, last)
        low, high = np.maximum(ends[0], least), np.minimum(ends[1], most)
    return np.where(lost, np.nan, result)


def _ends_of_lines(pairing: FlankPair) -> FloatArray:
    """Return l1 and w1 (2, cases, 2), mm, of the contacts with the least and the largest pinion roll on the
    flanks; NaN if there are none.

    At a constant l1 the roll is linear in w1, so that the extremum is at an end of its `interval`.
    """
    # Every case twice: for the least roll, and for the largest one.
    cases = len(pairing.branch)
    twice = pairing.cases(np.tile(np.arange(cases), 2))
    lines, sense = on_lines(twice), np.array((-1.0, 1.0)).repeat(cases)[:, None]
    l1 = greatest_at(
        lambda l1: _extreme_on(twice, lines, sense, l1)[1], twice.lowest[0], twice.highest[0], sense
    )
    w = _extreme_on(twice, lines, sense, l1)[0]
    return np.array((l1, w)).reshape(2, 2, cases).swapaxes(1, 2)


def on_lines(pairing: FlankPair) -> Lines:
    """Return the function that computes l (2, cases, positions), mm, and terms at w1 = 0 of the contact lines
    of constant l1 (cases, positions), mm.

    Without parabolas two lines are sufficient: l2, eta and the rack point are linear in l1, and all else is
    constant.
    """

    def solved(l1: FloatArray) -> tuple[FloatArray, ContactTerms]:
        """Return the lines, solved at each l1."""
        l = np.array((l1, mate_parameter(pairing, l1, np.zeros(l1.shape))))
        return l, meet_on_parallel(pairing, l, np.zeros(l1.shape))

    if not pairing.without_parabola.all():
        return solved
    apart = np.broadcast_to(pairing.rack.pitch_radius, (2, *pairing.branch.shape))[0]
    (l, met), (far, other) = solved(0.0 * apart), solved(apart)

    def between(l1: FloatArray) -> tuple[FloatArray, ContactTerms]:
        """Return the lines by linear interpolation between the two solved ones."""
        share = l1 / apart
        l2, along, start = (
            near + share * (end - near)
            for near, end in ((l[1], far[1]), (met.along, other.along), (met.start, other.start))
        )
        return np.array((l1, l2)), replace(met, along=along, start=start)

    return between


def _extreme_on(
    pairing: FlankPair, lines: Lines, sense: FloatArray, l1: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return w1 (mm) at which the roll times `sense` (cases, 1) is largest on the `lines` of l1 (cases,
    positions), mm, and this roll (rad), NaN if no part of the line is on the flanks.

    If the roll is constant, w1 is the middle of the line. At a corner of the flanks the line is one point,
    and rounding may exchange its ends: w1 is one of them then.
    """
    l, met = lines(l1)
    first, last = interval(pairing, l, met)
    rate = sense * met.slope[0] / met.moment[0]
    lost = ~(first <= last)
    w = np.where(rate > 0.0, last, first)
    w = np.where(np.abs(rate) * (last - first) <= NEGLIGIBLE_RATE, 0.5 * (first + last), w)
    return w, np.where(lost, np.nan, roll_angles(pairing, met)[0] + sense * rate * w)


def parallel_series(pairing: FlankPair) -> PathSeries:
    """Return series of the paths on parallel axes, slightly extended beyond the flanks.

    The status is OFF_FLANK if there is no contact on the flanks, and NO_COMMON_NORMAL if the flanks have
    neither the line contact nor the point contact of `contact_types`.
    """
    *kinds, s = contact_types(pairing)
    status = np.where(np.any(kinds, axis=0), np.int8(Status.OFF_FLANK), np.int8(Status.NO_COMMON_NORMAL))
    status[pairing.undefined] = Status.UNDEFINED
    guide = np.full((2, s.size, 2), np.nan)  # l1 and w1 at both ends
    lines, points = (np.flatnonzero(kind & ~pairing.undefined) for kind in kinds)
    l2 = np.full((s.size, 1), np.nan)
    if lines.size:
        guide[:, lines] = _ends_of_lines(pairing.cases(lines))
    if points.size:
        part = pairing.cases(points)
        l = on_racks(part, s[points, None])
        first, last = interval(part, l, meet_on_parallel(part, l, np.zeros(l.shape[1:])))
        guide[0, points], l2[points] = l[0], l[1]
        guide[1, points] = np.where(first < last, np.concatenate((first, last), axis=-1), np.nan)
    result = np.flatnonzero(np.isfinite(guide).all(axis=(0, 2)))
    return _along(pairing, guide, l2, result, status)


def _along(
    pairing: FlankPair, guide: FloatArray, l2: FloatArray, cases: Integers, status: Codes
) -> PathSeries:
    """Return the series of the `cases` along straight lines of l1 and w1, with l2 where it is known."""
    # Distance, relative to the size of a pair, by which a path may be beyond limits along which it
    # runs.
    along_face_tolerance = 1e-12
    # Fraction of its length by which a series reaches beyond the flanks.
    series_margin = 0.02
    part, (l1, w) = pairing.cases(cases), guide[:, cases]
    coefficients = np.full((FULL_ROW_COUNT, status.size, 2), np.nan)
    if cases.size == 0:
        return not_over_l1(coefficients, status)
    # Increase the degree until the series along the straight line is resolved.
    for basis in SERIES_BASES:
        share = 0.5 * (1.0 + (1.0 + 2.0 * series_margin) * basis.nodes)
        at = [x[:, :1] + (x[:, 1:] - x[:, :1]) * share for x in (l1, w)]
        mate = np.where(np.isnan(l2[cases]), mate_parameter(part, *at), l2[cases])
        l = np.array((at[0], mate))
        values, good = fitted_series(part, rows_of(part, l, meet_on_parallel(part, l, at[1])), basis)
        if good.all():
            break
    coefficients = np.full((FULL_ROW_COUNT, status.size, values.shape[-1]), np.nan)
    coefficients[:, cases] = values
    status[cases] = np.where(good, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
    # Both ends of a path above an edge can be corners at one end of the face, along which it then runs.
    coefficients[ROW_COUNT:, :, 0] += np.where(pairing.edged, along_face_tolerance * pairing.scale[:, 0], 0.0)
    middle, half = (np.full((status.size, 1), np.nan) for _ in range(2))
    middle[cases], half[cases] = l1.mean(axis=-1, keepdims=True), (0.5 + series_margin) * np.diff(l1)
    half[np.abs(half) <= NEGLIGIBLE_RATE * pairing.scale] = np.nan
    return PathSeries(coefficients, middle, half, status)
