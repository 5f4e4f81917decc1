"""Following a path of contact: exact solutions at a few points, polynomials between them.

`track_of` solves F(l1, l2) = 0 safely at the Chebyshev points of a window in l1 that covers the
pinion flank, and fits every quantity asked for by a polynomial. If the coefficients fall to
rounding the track is resolved: its values anywhere in the window are solutions to rounding.
Where the window is not smooth (n_x vanishes in it, or an l1 has several contacts) it is narrowed
to the part on the flanks; what still is not resolved carries the status that says why.

`find_ends` finds where the first of the eight limits (root, tip, toe, heel of either member) is
met, `at_shares` the positions that share out the pinion's roll between the ends.

Arrays have one axis of cases in place of the batch shape. The rows of a track are those of
`ROWS`, then the eight limit margins in the order of `Limit`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .contact import (
    Limit,
    Meeting,
    Pairing,
    axial_and_radius,
    contact_normal,
    contact_point,
    gap_tolerance,
    limit_margins,
    meet,
    roll_angles,
    trace_parameters,
)
from .curve import (
    HIGHEST,
    Basis,
    basis_of,
    evaluate,
    polynomials,
    real_roots,
    resolved_degree,
    with_derivative,
)
from .inputs import FloatArray
from .solve import Status, solve_gear_parameter

ROWS = {
    "l1": 0,
    "l2": 1,
    "u1": 2,
    "u2": 3,
    "pinion_z": 4,
    "gear_z": 5,
    "pinion_r": 6,
    "gear_r": 7,
    "pinion_roll": 11,
    "gear_roll": 12,
    "transmission_error": 13,
}
POINT, NORMAL, LENGTHS = slice(8, 11), slice(14, 17), slice(0, 11)
ROLL, PHASE, HEIGHT = 11, 13, 17
WIDTH = HEIGHT + len(Limit)
"""Rows of quantities, and with the margins."""

COARSE, FINE = basis_of(20), basis_of(HIGHEST)
SCAN = np.linspace(-1.0, 1.0, 65)
SCAN_VALUES = polynomials(SCAN, HIGHEST)
SHARES = np.linspace(0.0, 1.0, 17)
WINDOW_MARGIN = 0.02
"""Share of the flank depth by which the window of l1 reaches beyond root and tip."""
SEARCH, HALVINGS = 129, 40
"""Positions at which a window that is not smooth is searched for the part on the flanks, and
halvings of l1 by which the contacts are followed to where they end."""
STEEP = 128.0
"""Gap tolerances (1e-10 mm on Table 1) up to which a position near n_x = 0 still counts as solved."""
PASSES, NEWTON_LAST = 30, 1e-8
"""Newton on the polynomials ends with a step below NEWTON_LAST, whose square is rounding."""


@dataclass(frozen=True, eq=False)
class Track:
    """A path over a window of l1, as polynomials of x in [-1, 1], l1 = middle + half x.

    `middle`, `half` (cases, 1), mm. `coefficients` (WIDTH, cases, degree + 1). `status`
    (cases): SOLVED, or why there is no track. `elsewhere` (cases): pieces of the path on the
    flanks that a narrowed window leaves out."""

    middle: FloatArray
    half: FloatArray
    coefficients: FloatArray
    status: NDArray[np.int8]
    elsewhere: NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the path enters and leaves the flanks, (cases, 2); NaN and -1 without a path.

    `x` is the parameter of the track, `limit` holds `Limit` codes. Per case: `span`, the pinion
    roll (rad) that the path covers; `turning`, whether the roll turns back on the way; `pieces`,
    in how many the path lies on the flanks, of which the one with the greatest span is taken;
    `status`."""

    x: FloatArray
    l: FloatArray
    roll: FloatArray
    limit: NDArray[np.int8]
    span: FloatArray
    turning: NDArray[np.bool_]
    pieces: NDArray[np.int_]
    status: NDArray[np.int8]


def exact_rows(pairing: Pairing, l1: FloatArray) -> tuple[FloatArray, NDArray[np.int8]]:
    """Solve at every l1 (cases, positions), mm: the rows (WIDTH, cases, positions), NaN
    where not solved, and the Status of each position."""
    roots = solve_gear_parameter(pairing, l1)
    l = np.array((l1, roots.l2))
    met = meet(pairing, l)
    tolerance = gap_tolerance(pairing)
    for _ in range(2):
        if (np.abs(met.gap) <= 2.0 * tolerance).all():
            break
        l[1] -= met.gap / roots.slope
        met = meet(pairing, l)
    # n_x^2 is a difference of terms near 1: near n_x = 0 its rounding reaches F through B w.
    rounding = np.finfo(float).eps * np.abs(met.slope * met.across).sum(axis=0) / met.normal_x**2
    good = np.abs(met.gap) <= np.minimum(8.0 * (tolerance + rounding), STEEP * tolerance)
    status = np.where((roots.status == Status.SOLVED) & ~good, np.int8(Status.NOT_CONVERGED), roots.status)
    rows = _rows(pairing, l, met)
    if (status != Status.SOLVED).any():
        rows[:, status != Status.SOLVED] = np.nan
    return rows, status


def _rows(pairing: Pairing, l: FloatArray, met: Meeting) -> FloatArray:
    z, radius = axial_and_radius(pairing, met)
    roll = roll_angles(pairing, met)
    rows = np.empty((WIDTH, *l.shape[1:]))
    rows[0:2], rows[2:4], rows[4:6], rows[6:8] = l, trace_parameters(pairing, met, z), z, radius
    rows[POINT], rows[NORMAL] = contact_point(met), contact_normal(met)
    rows[ROLL : ROLL + 2] = roll
    rows[PHASE] = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    rows[HEIGHT:] = limit_margins(pairing, l, z, radius)
    return rows


def resolving_degree(pairing: Pairing, coefficients: FloatArray) -> int | None:
    """Degree that gives all rows to rounding, None if these coefficients do not."""
    scale = np.ones(len(coefficients))
    scale[LENGTHS] = scale[HEIGHT:] = pairing.scale.max()
    return resolved_degree(coefficients, scale)


def _follow(pairing: Pairing, middle: FloatArray, half: FloatArray, basis: Basis) -> Track:
    rows, found = exact_rows(pairing, middle + half * basis.nodes)
    coefficients, status = basis.coefficients(rows), found.max(axis=-1)
    degree = resolving_degree(pairing, coefficients)
    if degree is not None:
        coefficients = coefficients[..., : degree + 1]
    else:
        for case in np.flatnonzero(status == Status.SOLVED):
            one = slice(case, case + 1)
            if resolving_degree(pairing.cases(one), coefficients[:, one]) is None:
                status[case] = Status.NOT_CONVERGED
    return Track(middle, half, coefficients, status, np.zeros(status.shape, dtype=int))


def track_of(pairing: Pairing) -> Track:
    """The track over the pinion's flank, or over the part of it around the path."""
    low, high = pairing.lowest[0], pairing.highest[0]
    middle, half = 0.5 * (low + high), (0.5 + WINDOW_MARGIN) * (high - low)
    track = _follow(pairing, middle, half, COARSE)
    bad = np.flatnonzero(track.status != Status.SOLVED)
    if bad.size == 0:
        return track
    finer = _narrowed(pairing.cases(bad), middle[bad], half[bad])
    sizes = track.coefficients.shape[-1], finer.coefficients.shape[-1]
    merged = np.zeros((WIDTH, len(middle), max(sizes)))
    merged[..., : sizes[0]] = track.coefficients
    merged[:, bad] = 0.0
    merged[:, bad, : sizes[1]] = finer.coefficients
    track.status[bad], middle[bad], half[bad] = finer.status, finer.middle, finer.half
    track.elsewhere[bad] = finer.elsewhere
    return Track(middle, half, merged, track.status, track.elsewhere)


def _narrowed(pairing: Pairing, middle: FloatArray, half: FloatArray) -> Track:
    """Tracks over the part of the window around the flanks.

    The window is searched at many l1. If all contacts from the first on the flanks to the last
    are solved, and one off the flanks on either side, the path is sound between these; else if
    that holds for the longest part on the flanks, the path is sound there. Otherwise it is lost
    on the flanks, where its common normal vanishes or l1 turns back."""
    l1 = middle + half * np.linspace(-1.0, 1.0, SEARCH)
    rows, status = exact_rows(pairing, l1)
    inside = rows[HEIGHT:].min(axis=0) > 0.0
    first, last, runs = longest_run(inside)
    edges = (
        np.where(inside.any(axis=-1), inside.argmax(axis=-1), 1),
        SEARCH - 1 - inside[:, ::-1].argmax(axis=-1),
    )
    all_sound = _sound(status, *edges)
    first, last = np.where(all_sound, edges[0], first), np.where(all_sound, edges[1], last)
    whole = inside.any(axis=-1) & _sound(status, first, last)
    sides = np.stack((np.maximum(first - 1, 0), np.minimum(last + 1, SEARCH - 1)), axis=-1)
    l_side = np.take_along_axis(l1, sides, axis=-1)
    middle = np.where(whole, 0.5 * l_side.sum(axis=-1), middle[:, 0])[:, None]
    half = np.where(whole, 0.5 * (l_side[:, 1] - l_side[:, 0]), half[:, 0])[:, None]
    track = _follow(pairing, middle, half, FINE)
    several = (np.take_along_axis(status, sides, axis=-1) == Status.SEVERAL_CONTACTS).any(axis=-1)
    lost = np.where(several, np.int8(Status.SEVERAL_CONTACTS), np.int8(Status.NOT_CONVERGED))
    absent = np.where(inside.any(axis=-1), lost, _why_absent(pairing, l1, rows, status))
    elsewhere = np.where(whole & ~all_sound, runs - 1, 0)
    return Track(middle, half, track.coefficients, np.where(whole, track.status, absent), elsewhere)


def _sound(status: NDArray[np.int8], first: NDArray[np.int_], last: NDArray[np.int_]) -> NDArray[np.bool_]:
    """Whether all samples from the one before `first` to the one after `last` are solved."""
    index = np.arange(status.shape[-1])
    within = (index >= first[:, None] - 1) & (index <= last[:, None] + 1)
    return np.asarray(((status == Status.SOLVED) | ~within).all(axis=-1) & (last >= first))


def _why_absent(
    pairing: Pairing, l1: FloatArray, rows: FloatArray, status: NDArray[np.int8]
) -> NDArray[np.int8]:
    """Why none of the sampled contacts (cases, positions) lies on the flanks.

    Off the flanks for certain only if neighbouring contacts violate a limit in common, and
    go on to violate it up to where contact ends; otherwise the path may cross the flanks
    unseen, and is said to be lost."""
    solved = status == Status.SOLVED
    out = rows[HEIGHT:] < 0.0
    apart = solved[:, 1:] & solved[:, :-1] & ~(out[..., 1:] & out[..., :-1]).any(axis=0)
    doubtful = apart.any(axis=-1) | (status == Status.NOT_CONVERGED).any(axis=-1)
    doubtful |= (status == Status.SEVERAL_CONTACTS).any(axis=-1)
    case, sample = np.nonzero(solved[:, 1:] != solved[:, :-1])
    if case.size:
        part, ahead = pairing.cases(case), solved[case, sample + 1]
        good = np.where(ahead, l1[case, sample + 1], l1[case, sample])[:, None]
        bad = np.where(ahead, l1[case, sample], l1[case, sample + 1])[:, None]
        common = out[:, case, np.where(ahead, sample + 1, sample)]
        for _ in range(HALVINGS):
            between = 0.5 * (good + bad)
            found, known = exact_rows(part, between)
            here = known == Status.SOLVED
            common = common & ((found[HEIGHT:, :, 0] < 0.0) | ~here[:, 0])
            good, bad = np.where(here, between, good), np.where(here, bad, between)
        doubtful[case[~common.any(axis=0)]] = True
    certain = np.where(solved.any(axis=-1), np.int8(Status.OFF_FLANK), status.min(axis=-1))
    return np.where(doubtful, np.int8(Status.NOT_CONVERGED), certain)


def longest_run(
    inside: NDArray[np.bool_],
) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
    """First and last index of the longest run of True along the last axis, and the number of
    runs; last < first where there is none."""
    index = np.arange(inside.shape[-1])
    before = np.maximum.accumulate(np.where(inside, -1, index), axis=-1)
    length = np.where(inside, index - before, 0)
    last = np.argmax(length, axis=-1)
    runs = inside[..., 0] + (inside[..., 1:] & ~inside[..., :-1]).sum(axis=-1)
    return last - length.max(axis=-1) + 1, last, runs


def find_ends(pairing: Pairing, track: Track) -> Ends:
    """Ends of the path within the window of its track.

    Of the margins that shrink towards the outside, the one whose zero lies furthest inside
    ends the path; Newton on that maximum changes limits by itself when another one turns
    out to be met first. The pinion drives, with rising roll on right flanks and falling roll on
    left ones: that says which end is entered."""
    x, pieces = _rough_ends(track)
    inward = np.array([1.0, -1.0])
    both = with_derivative(track.coefficients[HEIGHT:])
    for _ in range(PASSES):
        values = evaluate(both, x)
        rates = values[len(Limit) :] * inward
        moves = np.where(rates > 0.0, -values[: len(Limit)] / rates, -np.inf)
        limit, move = moves.argmax(axis=0), inward * moves.max(axis=0)
        x = np.minimum(np.maximum(x + move, -1.0), 1.0)
        if not (np.abs(move) > NEWTON_LAST).any():
            break
    missed = ~(np.abs(move) <= NEWTON_LAST).all(axis=-1)
    status = np.where(missed, np.int8(Status.NOT_CONVERGED), np.int8(Status.SOLVED))
    status = np.where(pieces == 0, np.int8(Status.OFF_FLANK), status)
    status = np.where(track.status != Status.SOLVED, track.status, status)
    away = status != Status.SOLVED
    x, limit = np.where(away[:, None], np.nan, x), np.where(away[:, None], -1, limit).astype(np.int8)
    values = evaluate(track.coefficients[[0, 1, ROLL]], x)
    backwards = pairing.rack.sigma * (values[2, :, 1] - values[2, :, 0]) < 0.0
    x[backwards], limit[backwards] = x[backwards, ::-1], limit[backwards, ::-1]
    values[:, backwards] = values[:, backwards, ::-1]
    span, turning = _roll_span(track, x, values[2])
    pieces = np.where(away, 0, pieces + track.elsewhere)
    return Ends(x, values[:2], values[2], limit, span, turning, pieces, status)


def _rough_ends(track: Track) -> tuple[FloatArray, NDArray[np.int_]]:
    """Starting values (cases, 2) for the ends of the path, and the number of its pieces.

    A scan of the least margin does where it crosses zero twice. Where it has several runs
    inside, or an extremum so near to zero that a crossing may hide between the samples, the
    roots of all margins are taken."""
    depth = (track.coefficients[HEIGHT:] @ SCAN_VALUES[: track.coefficients.shape[-1]]).min(axis=0)
    first, last, pieces = longest_run(depth > 0.0)
    x = np.stack((_crossing(depth, first, -1), _crossing(depth, last, 1)), axis=-1)
    steps = depth[:, 1:] - depth[:, :-1]
    before, after, middle = steps[:, :-1], steps[:, 1:], depth[:, 1:-1]
    near = np.abs(middle) <= np.maximum(np.abs(before), np.abs(after))
    hidden = near & np.where(middle > 0.0, (before < 0.0) & (after > 0.0), (before > 0.0) & (after < 0.0))
    doubtful = (track.status == Status.SOLVED) & (hidden.any(axis=-1) | (pieces > 1))
    for case in np.flatnonzero(doubtful):
        x[case], pieces[case] = _exact_run(track.coefficients[:, case])
    return x, pieces


def _exact_run(coefficients: FloatArray) -> tuple[FloatArray, int]:
    """Ends of the piece on the flanks with the greatest span of roll, and the number of pieces."""
    cuts = np.concatenate([real_roots(margin, -1.0, 1.0) for margin in coefficients[HEIGHT:]])
    cuts = np.concatenate(([-1.0], np.sort(cuts), [1.0]))
    between = 0.5 * (cuts[1:] + cuts[:-1])
    inside = evaluate(coefficients[HEIGHT:, None], between)[:, 0].min(axis=0) > 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0]))))
    if edges.size == 0:
        return np.zeros(2), 0
    runs = cuts[edges].reshape(-1, 2)
    span = np.abs(np.diff(evaluate(coefficients[ROLL, None, None], runs.ravel())[0, 0].reshape(-1, 2)))
    return runs[int(span.argmax())], len(runs)


def _crossing(depth: FloatArray, edge: NDArray[np.int_], outward: int) -> FloatArray:
    """Parameter at which the depth crosses zero beside the sample `edge`, by a straight line."""
    case = np.arange(len(edge))
    beyond = np.minimum(np.maximum(edge + outward, 0), SCAN.size - 1)
    inside, outside = depth[case, edge], depth[case, beyond]
    share = np.where(outside < inside, inside / (inside - outside), 0.0)
    return np.asarray(SCAN[edge] + share * (SCAN[beyond] - SCAN[edge]))


def _roll_span(track: Track, x: FloatArray, roll: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Pinion roll covered between the ends (cases), rad, and whether it turns back on the way."""
    span = np.abs(roll[:, 1] - roll[:, 0])
    both = with_derivative(track.coefficients[ROLL : ROLL + 1])
    share = x[:, :1] + (x[:, 1:] - x[:, :1]) * SHARES
    rate = evaluate(both[1:], share)[0]
    low, high = rate.min(axis=-1), rate.max(axis=-1)
    turning = low * high <= 0.25 * np.maximum(np.abs(low), np.abs(high)) ** 2
    for case in np.flatnonzero(turning):
        roots = real_roots(both[1, case], *np.sort(x[case]))
        turning[case] = roots.size > 0
        reached = np.concatenate((roll[case], evaluate(both[:1, case, None], roots)[0, 0]))
        span[case] = np.ptp(reached)
    return span, turning


def at_shares(track: Track, ends: Ends, share: FloatArray) -> FloatArray:
    """Track parameters x (cases, positions) at `share` in [-1, 1] of the way from enter to leave.

    The way is measured in pinion roll, inverted by Newton; on a path along which the roll
    turns back it is measured in l1."""
    enter, leave, first, last = ends.x[:, :1], ends.x[:, 1:], ends.roll[:, :1], ends.roll[:, 1:]
    goal = 0.5 * ((first + last) + (last - first) * share)
    low, high = np.minimum(enter, leave), np.maximum(enter, leave)
    straight = x = 0.5 * ((enter + leave) + (leave - enter) * share)
    both = with_derivative(track.coefficients[ROLL : ROLL + 1])
    for _ in range(PASSES):
        value, rate = evaluate(both, x)
        move = np.where(ends.turning[:, None], 0.0, (goal - value) / rate)
        x = np.minimum(np.maximum(x + move, low), high)
        if not (np.abs(move) > NEWTON_LAST).any():
            break
    return np.where(ends.turning[:, None], straight, x)
