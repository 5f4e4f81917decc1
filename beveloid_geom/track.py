"""Following a path of contact: exact solutions at a few points, polynomials between them.

`track_of` solves F(l1, l2) = 0 safely at the Chebyshev points of a window in l1 that covers the
pinion flank, and fits every quantity asked for by a polynomial. If the coefficients fall to
rounding the track is resolved: its values anywhere in the window are solutions to rounding.
Where the window is not smooth (n_x vanishes in it, or an l1 has several contacts) it is narrowed
to the part on the flanks; what still is not resolved carries the status that says why.

`find_ends` finds where the first of the eight limits (root, tip, toe, heel of either member) is
met; `by_roll` expands a track anew in the pinion's roll between its ends.

Arrays have one axis of cases in place of the batch shape. The rows of a track are those of
`ROWS`, then the eight limit margins in the order of `Limit`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .contact import (
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
from .curve import Basis, basis_of, evaluate, polynomials, resolved_degree
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

COARSE, FINE = basis_of(20), basis_of(100)
SCAN = np.linspace(-1.0, 1.0, 65)
SCAN_VALUES = {basis.nodes.size: polynomials(SCAN, basis.nodes.size - 1) for basis in (COARSE, FINE)}
WINDOW_MARGIN = 0.02
"""Share of the flank depth by which the window of l1 reaches beyond root and tip."""
SEARCH = 129
"""Positions at which a window that is not smooth is searched for the part on the flanks."""
PASSES, NEWTON_LAST = 30, 1e-8
"""Newton on the polynomials ends with a step below NEWTON_LAST, whose square is rounding."""


@dataclass(frozen=True, eq=False)
class Track:
    """A path over a window of l1, as polynomials of x in [-1, 1], l1 = middle + half x.

    `middle`, `half` (cases, 1), mm. `coefficients` (HEIGHT + 8, cases, degree + 1). `status`
    (cases): SOLVED, or why there is no track."""

    middle: FloatArray
    half: FloatArray
    coefficients: FloatArray
    status: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the path enters and leaves the flanks, (cases, 2); NaN and -1 without a path.

    `x` is the parameter of the track, `limit` holds `Limit` codes, `pieces` (cases) counts the
    pieces in which the path lies on the flanks: the longest is taken. `status` (cases)."""

    x: FloatArray
    l: FloatArray
    roll: FloatArray
    limit: NDArray[np.int8]
    pieces: NDArray[np.int_]
    status: NDArray[np.int8]


def exact_rows(pairing: Pairing, l1: FloatArray) -> tuple[FloatArray, NDArray[np.int8]]:
    """Solve at every l1 (cases, positions), mm: the rows (HEIGHT + 8, cases, positions), NaN
    where not solved, and the Status of each position."""
    roots = solve_gear_parameter(pairing, l1)
    l = np.array((l1, roots.l2))
    met = meet(pairing, l)
    for _ in range(2):
        if (np.abs(met.gap) <= gap_tolerance(pairing)).all():
            break
        l[1] -= met.gap / roots.slope
        met = meet(pairing, l)
    missed = (roots.status == Status.SOLVED) & ~(np.abs(met.gap) <= 8.0 * gap_tolerance(pairing))
    status = np.where(missed, np.int8(Status.NOT_CONVERGED), roots.status)
    rows = _rows(pairing, l, met)
    if (status != Status.SOLVED).any():
        rows[:, status != Status.SOLVED] = np.nan
    return rows, status


def _rows(pairing: Pairing, l: FloatArray, met: Meeting) -> FloatArray:
    z, radius = axial_and_radius(pairing, met)
    roll = roll_angles(pairing, met)
    rows = np.empty((HEIGHT + 8, *l.shape[1:]))
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
    if resolving_degree(pairing, coefficients) is None:
        for case in np.flatnonzero(status == Status.SOLVED):
            one = slice(case, case + 1)
            if resolving_degree(pairing.cases(one), coefficients[:, one]) is None:
                status[case] = Status.NOT_CONVERGED
    return Track(middle, half, coefficients, status)


def track_of(pairing: Pairing) -> Track:
    """The track over the pinion's flank, or over the part of it around the path."""
    low, high = pairing.lowest[0], pairing.highest[0]
    middle, half = 0.5 * (low + high), (0.5 + WINDOW_MARGIN) * (high - low)
    track = _follow(pairing, middle, half, COARSE)
    bad = np.flatnonzero(track.status != Status.SOLVED)
    if bad.size == 0:
        return track
    finer = _narrowed(pairing.cases(bad), middle[bad], half[bad])
    merged = np.zeros((HEIGHT + 8, len(middle), FINE.nodes.size))
    merged[..., : COARSE.nodes.size] = track.coefficients
    merged[:, bad] = finer.coefficients
    track.status[bad], middle[bad], half[bad] = finer.status, finer.middle, finer.half
    return Track(middle, half, merged, track.status)


def _narrowed(pairing: Pairing, middle: FloatArray, half: FloatArray) -> Track:
    """Tracks over the part of the window around the flanks.

    The window is searched at many l1. If on both sides of the longest part on the flanks the
    next position is a contact off them, the path is sound up to there; else it is lost on the
    flanks, where its common normal vanishes or l1 turns back."""
    l1 = middle + half * np.linspace(-1.0, 1.0, SEARCH)
    rows, status = exact_rows(pairing, l1)
    first, last, _ = longest_run(rows[HEIGHT:].min(axis=0) > 0.0)
    sides = np.stack((np.maximum(first - 1, 0), np.minimum(last + 1, SEARCH - 1)), axis=-1)
    beyond = np.take_along_axis(status, sides, axis=-1)
    found = last >= first
    whole = found & (beyond == Status.SOLVED).all(axis=-1)
    l_side = np.take_along_axis(l1, sides, axis=-1)
    middle = np.where(whole, 0.5 * l_side.sum(axis=-1), middle[:, 0])[:, None]
    half = np.where(whole, 0.5 * (l_side[:, 1] - l_side[:, 0]), half[:, 0])[:, None]
    track = _follow(pairing, middle, half, FINE)
    several = (beyond == Status.SEVERAL_CONTACTS).any(axis=-1)
    lost = np.where(several, np.int8(Status.SEVERAL_CONTACTS), np.int8(Status.NOT_CONVERGED))
    nowhere = np.where((status == Status.SOLVED).any(axis=-1), np.int8(Status.OFF_FLANK), status.min(axis=-1))
    absent = np.where(found, lost, nowhere)
    return Track(middle, half, track.coefficients, np.where(whole, track.status, absent))


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
    margins = track.coefficients[HEIGHT:]
    size = margins.shape[-1]
    depth = (margins @ SCAN_VALUES[size]).min(axis=0)
    scan = np.broadcast_to(SCAN, depth.shape)
    missed = np.flatnonzero((depth.max(axis=-1) <= 0.0) & (track.status == Status.SOLVED))
    if missed.size:  # the path may still touch the flanks between two samples
        scan = scan.copy()
        scan[missed] = _closer(SCAN[depth[missed].argmax(axis=-1)])
        depth[missed] = evaluate(margins[:, missed], scan[missed]).min(axis=0)
    first, last, pieces = longest_run(depth > 0.0)
    x = np.stack((_crossing(scan, depth, first, -1), _crossing(scan, depth, last, 1)), axis=-1)
    inward = np.array([1.0, -1.0])
    both = np.concatenate((margins, margins @ (COARSE if size == COARSE.nodes.size else FINE).slope))
    for _ in range(PASSES):
        values = evaluate(both, x)
        rates = values[8:] * inward
        moves = np.where(rates > 0.0, -values[:8] / rates, -np.inf)
        limit, move = moves.argmax(axis=0), inward * moves.max(axis=0)
        x = np.minimum(np.maximum(x + move, -1.0), 1.0)
        if not (np.abs(move) > NEWTON_LAST).any():
            break
    lost = ~(np.abs(move) <= NEWTON_LAST).all(axis=-1)
    status = np.where(lost, np.int8(Status.NOT_CONVERGED), np.int8(Status.SOLVED))
    status = np.where(pieces == 0, np.int8(Status.OFF_FLANK), status)
    status = np.where(track.status != Status.SOLVED, track.status, status)
    away = (status != Status.SOLVED)[:, None]
    x = np.where(away, np.nan, x)
    limit = np.where(away, -1, limit).astype(np.int8)
    roll = evaluate(track.coefficients[ROLL : ROLL + 1], x)[0]
    against = pairing.rack.sigma * (roll[:, 1] - roll[:, 0]) < 0.0
    x[against], limit[against] = x[against, ::-1], limit[against, ::-1]
    l1, l2, roll = evaluate(track.coefficients[[0, 1, ROLL]], x)
    return Ends(x, np.stack((l1, l2)), roll, limit, np.where(away[:, 0], 0, pieces), status)


def _closer(x: FloatArray) -> FloatArray:
    """A scan (cases, samples) of the two cells around the sample at `x`."""
    return np.asarray(np.minimum(np.maximum(x[:, None] + (SCAN[1] - SCAN[0]) * SCAN, -1.0), 1.0))


def _crossing(scan: FloatArray, depth: FloatArray, edge: NDArray[np.int_], outward: int) -> FloatArray:
    """Parameter at which the depth crosses zero beside the sample `edge`, by a straight line."""
    case = np.arange(len(edge))
    beyond = np.clip(edge + outward, 0, SCAN.size - 1)
    inside, outside = depth[case, edge], depth[case, beyond]
    share = np.where(outside < inside, inside / (inside - outside), 0.0)
    return np.asarray(scan[case, edge] + share * (scan[case, beyond] - scan[case, edge]))


def at_shares(track: Track, ends: Ends, share: FloatArray) -> FloatArray:
    """Track parameters x (cases, positions) at `share` in [-1, 1] of the way from enter to leave.

    The way is measured in pinion roll, inverted by Newton; on a path along which the roll
    turns back it is measured in l1."""
    enter, leave, first, last = ends.x[:, :1], ends.x[:, 1:], ends.roll[:, :1], ends.roll[:, 1:]
    goal = 0.5 * ((first + last) + (last - first) * share)
    low, high = np.minimum(enter, leave), np.maximum(enter, leave)
    straight = x = 0.5 * ((enter + leave) + (leave - enter) * share)
    roll = track.coefficients[ROLL : ROLL + 1]
    slope = (COARSE if roll.shape[-1] == COARSE.nodes.size else FINE).slope
    both = np.concatenate((roll, roll @ slope))
    for _ in range(PASSES):
        value, rate = evaluate(both, x)
        move = (goal - value) / rate
        x = np.minimum(np.maximum(x + move, low), high)
        if not (np.abs(move) > NEWTON_LAST).any():
            break
    turning = ~((np.abs(move) <= NEWTON_LAST) & (rate * rate[:, :1] > 0.0)).all(axis=-1, keepdims=True)
    return np.where(turning, straight, x)
