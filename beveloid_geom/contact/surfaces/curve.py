"""Curves of contact by samples: approximate values between them, and their segments on the flanks.

A curve is given by solved contacts at increasing parameters x. Rows are the state (s1, z1, roll, s2) and the
eight margins of `limits`, each with its derivative by x. Cubic Hermite interpolation between neighbours gives
starting values for exact solutions, and shows where the curve crosses the limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from .limits import Problem, margins_at
from .tangency import Contacts, contacts_at, given_row, meshing_start, solve

NODE_COUNT, WINDOW_MARGIN = 11, 0.02
"""Number of positions in s1 at which a curve is solved first, and fraction of the flank depth by which they
reach beyond root and tip of the pinion.
"""
NEAR_STEPS = 10
"""Largest number of Newton steps from starting values on a tangent of the curve."""
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
    # Number of Newton steps from the middle of the face, and their largest length, in face widths: from the
    # middle to toe or heel. Positions that take longer are started again.
    max_steps, longest_step = 16, 0.5
    low, high = problem.lowest[0], problem.highest[0]
    spare = WINDOW_MARGIN * (high - low)
    nodes, cases = np.linspace(low - spare, high + spare, NODE_COUNT), problem.placed.offset.size
    s1 = np.tile(nodes, cases)
    case = np.repeat(np.arange(cases), NODE_COUNT)
    placed = problem.placed.of_cases(case)
    start = meshing_start(problem.surfaces, placed, s1, np.zeros(s1.size))
    reach = np.full(s1.size, longest_step)
    met, _ = solve(problem.surfaces, placed, start, given_row(0, s1), reach, max_steps)
    curve = sampled(problem, s1.reshape(cases, -1), met, None)
    for _ in range(sweeps):
        start = _from_neighbours(problem, curve)
        again = np.flatnonzero(np.isfinite(start).all(axis=0).ravel())
        if not again.size:
            break
        starts, there = start.reshape(4, -1)[:, again], given_row(0, s1[again])
        met, good = solve(problem.surfaces, placed.of_cases(again), starts, there, max_steps=NEAR_STEPS)
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


def dense(problem: Problem, curve: Curve) -> tuple[FloatArray, FloatArray]:
    """Return x (cases, m) and rows (WIDTH, cases, m) of a curve and of three interpolated places in each
    interval; NaN next to samples that are not solved.

    The interpolation is cubic. In an interval with a kink, where a relief begins, it follows both tangents up
    to their intersection, which is one of the places.
    """
    # Difference of both tangents, relative to the longer one, above which there may be a kink between.
    kink_ratio = 0.5
    step = np.diff(curve.x)[..., None]
    low, high = curve.value[..., :-1, None], curve.value[..., 1:, None]
    first, last = curve.rate[..., :-1, None] * step, curve.rate[..., 1:, None] * step
    change, scale = high - low, problem.scale[:, None, None, None]
    bends, slopes = np.abs((first - last)[:3] / scale), np.abs(np.array((first, last))[:, :3] / scale)
    kinked = bends.max(axis=0) > kink_ratio * slopes.max(axis=(0, 1))
    # The tangents intersect where the coordinate with the largest bend has the same value.
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (change - last)[:3] / (first - last)[:3]
    middle = np.take_along_axis(share, bends.argmax(axis=0)[None], axis=0)[0]
    kinked &= (middle > 0.0) & (middle < 1.0)
    middle = np.where(kinked, middle, 0.5)
    t = np.concatenate((0.0 * middle, 0.5 * middle, middle, 0.5 + 0.5 * middle), axis=-1)
    between = low + t * (
        first + t * ((3.0 * change - 2.0 * first - last) + t * (first + last - 2.0 * change))
    )
    tangents = np.where(t <= middle, low + t * first, high - (1.0 - t) * last)
    between = np.where(kinked, tangents, between)
    between[..., 0] = curve.value[..., :-1]
    cases = len(curve.x)
    x = np.concatenate(((curve.x[:, :-1, None] + t * step).reshape(cases, -1), curve.x[:, -1:]), axis=-1)
    rows = np.concatenate((between.reshape(WIDTH, cases, -1), curve.value[..., -1:]), axis=-1)
    return x, rows


def _misfit(problem: Problem, curve: Curve) -> tuple[FloatArray, FloatArray]:
    """Return the difference (cases, samples - 1) between the chord and the mean of the tangents at its ends,
    and the length of the chord, in the units of `Problem.scale`."""
    scale = problem.scale[:, None, None]
    step, change = np.diff(curve.x), np.diff(curve.value[:3]) / scale
    mean = 0.5 * (curve.rate[:3, :, 1:] + curve.rate[:3, :, :-1]) * step / scale
    return np.abs(change - mean).max(axis=0), np.abs(change).max(axis=0)


def broken(problem: Problem, curve: Curve) -> Mask:
    """Return between which samples (cases, samples - 1) the curve has a kink that is not next to one of them:
    they may belong to different curves."""
    # Misfit above which samples may belong to different curves, and distance of one end from the tangent at
    # the other one up to which both are on the same curve.
    max_misfit, max_distance = 0.15, 0.01
    misfit, size = _misfit(problem, curve)
    results = np.asarray(misfit > max_misfit + 0.5 * size)
    if results.any():
        scale = problem.scale[:, None, None]
        change = np.diff(curve.value[:3]) / scale
        for rate in (curve.rate[:3, :, :-1] / scale, curve.rate[:3, :, 1:] / scale):
            along = (change * rate).sum(axis=0) / (rate * rate).sum(axis=0)
            away = np.linalg.norm(change - along * rate, axis=0)
            results &= ~((along > 0.0) & (away <= max_distance))
    return results
