"""Curves of contact by samples: approximate values between them, and their segments on the flanks.

A curve is given by solved contacts at increasing parameters x. Rows are the state (s1, z1, roll, s2) and the
eight margins of `limits`, each with its derivative by x. Cubic Hermite interpolation between neighbours gives
starting values for exact solutions, and shows where the curve crosses the limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from .limits import Problem, margins_at, on_plane
from .tangency import Contacts, contacts_at, given_row, meshing_start, solve

NODE_COUNT, WINDOW_MARGIN = 11, 0.02
"""Number of positions in s1 at which a curve is solved first, and fraction of the flank depth by which they
reach beyond root and tip of the pinion.
"""
PARTS = 4
"""Number of interpolated values per interval between two samples."""
STATE, MARGINS, WIDTH = slice(0, 4), slice(4, 12), 12


@dataclass(frozen=True, eq=False)
class Curve:
    """Samples of one curve for each case: `x` (cases, samples), `value` and `rate` (WIDTH, cases, samples).

    NaN where not solved. `by_s1` states whether x is s1 (mm); otherwise, x is the length of the curve in the
    units of `Problem.scale`.
    """

    x: FloatArray
    value: FloatArray
    rate: FloatArray
    by_s1: bool

    def cases(self, index: Integers) -> Curve:
        """Return the curves of the cases `index`."""
        return Curve(self.x[index], self.value[:, index], self.rate[:, index], self.by_s1)


def sampled(problem: Problem, x: FloatArray, met: Contacts, directions: FloatArray | None) -> Curve:
    """Return the curve through contacts (cases * samples) at `x` (cases, samples).

    `directions` (3, cases * samples) orient the tangents if x is the length; without them x is s1.
    """
    margins, by = margins_at(problem, met)
    tangent = met.tangent
    if directions is None:
        tangent = tangent / tangent[0]
    else:
        scaled = tangent / problem.scale[:, None]
        along = (scaled * directions).sum(axis=0)
        tangent = tangent * np.sign(along) / np.sqrt((scaled * scaled).sum(axis=0))
    value = np.concatenate((met.state, margins))
    rate = np.concatenate((met.along(tangent), (by * tangent).sum(axis=1)))
    lost = np.isnan(met.state).any(axis=0)
    value[:, lost], rate[:, lost] = np.nan, np.nan
    shape = (WIDTH, *x.shape)
    return Curve(x, value.reshape(shape), rate.reshape(shape), directions is None)


def curve_over_s1(problem: Problem) -> Curve:
    """Return the contacts of every case at evenly spaced s1 over the flank of the pinion.

    The first starting values are in the middle of the face. Positions that are not solved from there are
    started again from the tangents of solved neighbours.
    """
    # Number of times that unsolved positions are started again from their solved neighbours.
    sweeps = 6
    low, high = problem.lowest[0], problem.highest[0]
    spare = WINDOW_MARGIN * (high - low)
    nodes, cases = np.linspace(low - spare, high + spare, NODE_COUNT), problem.placed.offset.size
    s1 = np.tile(nodes, cases)
    case = np.repeat(np.arange(cases), NODE_COUNT)
    placed = problem.placed.take(case)
    met, _ = solve(
        problem.surfaces,
        placed,
        meshing_start(problem.surfaces, placed, s1, np.zeros(s1.size)),
        given_row(0, s1),
    )
    curve = sampled(problem, s1.reshape(cases, -1), met, None)
    for _ in range(sweeps):
        start = _from_neighbours(problem, curve)
        again = np.flatnonzero(np.isfinite(start).all(axis=0).ravel())
        if not again.size:
            break
        met, good = solve(
            problem.surfaces, placed.take(again), start.reshape(4, -1)[:, again], given_row(0, s1[again])
        )
        if not good.any():
            break
        state = curve.value[STATE].reshape(4, -1).copy()
        state[:, again[good]] = met.state[:, good]
        curve = sampled(problem, curve.x, contacts_at(problem.surfaces, placed, state), None)
    return curve


def _from_neighbours(problem: Problem, curve: Curve) -> FloatArray:
    """Return starting values (4, cases, samples) of unsolved samples with a solved neighbour that is at most
    half a face width off the flanks; NaN elsewhere.
    """
    state, rate, x = curve.value[STATE], curve.rate[STATE], curve.x
    near = curve.value[MARGINS].min(axis=0) > -problem.half_width[0]
    start = np.full(state.shape, np.nan)
    for new, old in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
        step = x[:, new] - x[:, old]
        guess = state[..., old] + rate[..., old] * step
        wanted = np.isnan(state[0][:, new]) & near[:, old]
        start[..., new] = np.where(wanted, guess, start[..., new])
    return start


def closer(problem: Problem, curve: Curve) -> Curve:
    """Return a curve over s1 with a contact in the middle of each interval that is not smooth, as next to the
    beginning of a relief, and of each interval in which the curve leaves the flanks.

    The middle is that of the chord, in the plane across it, or of s1 if an end of the interval is unknown."""
    inside = curve.value[MARGINS].min(axis=0) >= 0.0
    after = np.flatnonzero((broken(problem, curve) | (inside[:, 1:] != inside[:, :-1])).any(axis=0))
    scale = problem.scale[:, None, None]
    ends = [curve.value[STATE][..., after + k] for k in (0, 1)]
    chord = (ends[1] - ends[0])[:3] / scale
    known = np.isfinite(chord).all(axis=0)
    across = np.where(known, chord / np.linalg.norm(chord, axis=0), np.eye(3)[0][:, None, None])
    x = 0.5 * (curve.x[:, after] + curve.x[:, after + 1])
    middle = np.where(known, 0.5 * (ends[0] + ends[1]), x)  # only s1 matters if an end is unknown
    placed = problem.placed.take(np.repeat(np.arange(len(x)), after.size))
    # The tangent at one of the ends leads to the middle, unless there are several kinks.
    starts = []
    for k, end in enumerate(ends):
        rate = curve.rate[STATE][..., after + k]
        step = ((middle - end)[:3] / scale * across).sum(axis=0) / (rate[:3] / scale * across).sum(axis=0)
        starts.append(contacts_at(problem.surfaces, placed, (end + step * rate).reshape(4, -1)))
    error = [np.nan_to_num(start.error, nan=np.inf) for start in starts]
    state = np.where(error[0] < error[1], starts[0].state, starts[1].state)
    plane = on_plane(problem, middle.reshape(4, -1), across.reshape(3, -1))
    met, _ = solve(problem.surfaces, placed, state, plane)
    s1 = met.state[0].reshape(x.shape)
    between = (curve.x[:, after] < s1) & (s1 < curve.x[:, after + 1])
    met.state[:, ~between.ravel()] = np.nan
    added = sampled(problem, np.where(between, s1, x), met, None)
    pairs = (curve.x, added.x), (curve.value, added.value), (curve.rate, added.rate)
    return Curve(*(np.insert(old, after + 1, new, axis=-1) for old, new in pairs), by_s1=True)


def dense(curve: Curve) -> tuple[FloatArray, FloatArray]:
    """Return x (cases, m) and rows (WIDTH, cases, m) of a curve and of PARTS - 1 interpolated places in each
    interval; NaN next to samples that are not solved.
    """
    t = np.arange(PARTS) / PARTS
    step = np.diff(curve.x)[..., None]
    low, high = curve.value[..., :-1, None], curve.value[..., 1:, None]
    first, last = curve.rate[..., :-1, None] * step, curve.rate[..., 1:, None] * step
    change = high - low
    between = low + t * (
        first + t * ((3.0 * change - 2.0 * first - last) + t * (first + last - 2.0 * change))
    )
    between[..., 0] = curve.value[..., :-1]
    cases = len(curve.x)
    x = np.concatenate(((curve.x[:, :-1, None] + t * step).reshape(cases, -1), curve.x[:, -1:]), axis=-1)
    rows = np.concatenate((between.reshape(WIDTH, cases, -1), curve.value[..., -1:]), axis=-1)
    return x, rows


def broken(problem: Problem, curve: Curve) -> Mask:
    """Return between which samples (cases, samples - 1) the curve is not smooth: they may belong to different
    curves.
    """
    # Difference between a chord and the mean of the tangents at its ends, relative to the size of the
    # flank, above which two samples may belong to different curves.
    max_angle_misfit = 0.15
    step = np.diff(curve.x)
    change = np.diff(curve.value[:3]) / problem.scale[:, None, None]
    mean = 0.5 * (curve.rate[:3, :, 1:] + curve.rate[:3, :, :-1]) * step / problem.scale[:, None, None]
    misfit = np.abs(change - mean).max(axis=0)
    return np.asarray(misfit > max_angle_misfit + 0.5 * np.abs(change).max(axis=0))
