"""Derivatives of the paths of modified flanks by the assembly errors."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Integers
from ...pair.misalignment import ERROR_NAMES
from ...status import Status
from .error_rates import COUNT, PHASE, ROLLS, ErrorRates, error_rates, limit_rates
from .paths import SurfacePaths
from .positions import positions_on
from .tangency import given_row, solve


def surface_rates(path: SurfacePaths, sense: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of the paths of modified flanks.

    Parameters
    ----------
    path : SurfacePaths
    sense : ndarray, shape (cases,)
        Sign with which a shaft-angle error is added.

    Returns
    -------
    places : ndarray, shape (COUNT, 6, cases, 3)
        Quantities at enter, middle and leave, their derivatives by the errors, and their derivatives along
        the path, which have an arbitrary common factor at each of the three places. The middle is NaN if the
        roll turns back.
    spans : ndarray, shape (2, cases, 5)
        Ranges of the roll and of the phase (gear roll plus N1/N2 pinion roll) along the path, rad, and their
        derivatives by the errors. The derivatives of the range of the roll are NaN if the roll turns back.
    """
    segment, count = path.segment, path.cases.size
    cases = np.arange(count)
    met, _ = positions_on(path.problem, segment, np.array((0.5,)))
    middle = np.where(segment.turning, np.nan, met.state)
    states = segment.state[:, :, 0], middle, segment.state[:, :, 1]
    rates = [error_rates(path, cases, state, sense) for state in states]
    # The ends stay at their limits, and the middle at the mean of their rolls.
    ends = []
    for k, end in ((0, rates[0]), (1, rates[2])):
        limit = np.maximum(segment.limit[:, k], 0).astype(np.intp)
        ends.append(end.fixed_by(*limit_rates(path, end, limit)))
    by_roll = np.broadcast_to(np.eye(3)[2][:, None], (3, count))
    goal = 0.5 * (ends[0][ROLLS] + ends[1][ROLLS])
    moved = ends[0], rates[1].fixed_by(by_roll, -goal), ends[1]
    places = np.empty((COUNT, len(ERROR_NAMES) + 2, count, 3))
    for k, (one, by) in enumerate(zip(rates, moved, strict=True)):
        places[:, 0, :, k], places[:, 1:-1, :, k] = one.value, by
        places[:, -1, :, k] = (one.by_state * one.tangent).sum(axis=1)
    spans = np.empty((2, count, len(ERROR_NAMES) + 1))
    sign = np.sign(segment.state[2, :, 1] - segment.state[2, :, 0])
    spans[0, :, 0] = segment.span
    spans[0, :, 1:] = np.where(segment.turning, np.nan, sign * (ends[1][ROLLS] - ends[0][ROLLS])).T
    highest, lowest = (_extreme(path, sense, rates, ends, sense_of) for sense_of in (1.0, -1.0))
    spans[1] = highest - lowest
    return places, spans


def _extreme(
    path: SurfacePaths, sense: FloatArray, rates: list[ErrorRates], ends: list[FloatArray], sign: float
) -> FloatArray:
    """Return the largest (`sign` 1) or smallest (-1) phase of each path and its derivatives, (cases, 5)."""
    problem, segment, count = path.problem, path.segment, path.cases.size
    # Positions along a path at which extrema of the transmission error are sought; steps to refine one.
    samples, secant_steps = 65, 5
    met, _ = positions_on(problem, segment, np.linspace(0.0, 1.0, samples))
    index, state = np.repeat(np.arange(count), samples), met.state.reshape(4, count, samples)
    dense = error_rates(path, index, met.state, sense[index]).value[PHASE].reshape(count, samples)
    known = np.isfinite(dense)
    place = np.where(known, sign * dense, -np.inf).argmax(axis=-1)
    result = np.empty((count, len(ERROR_NAMES) + 1))
    for at_end, k in ((place == 0, 0), (place == samples - 1, 1)):
        result[at_end, 0] = rates[2 * k].value[PHASE, at_end]
        result[at_end, 1:] = ends[k][PHASE][:, at_end].T
    inside = np.flatnonzero((place > 0) & (place < samples - 1))
    if inside.size:
        # Secants for the roll at which the phase is stationary along the path.
        last = place[inside]
        roll, next_roll = (state[2, inside, last + k] for k in (0, 1))
        rolls = [roll, roll + 0.3 * (next_roll - roll)]
        start, slopes = state[:, inside, last], []
        for k in range(2 + secant_steps):
            start, one = _at_roll(path, inside, start, rolls[k], sense)
            direction = one.tangent / one.tangent[2]
            slopes.append((one.by_state[PHASE] * direction).sum(axis=0))
            if k:
                change = slopes[k] - slopes[k - 1]
                step = np.where(change != 0.0, slopes[k] * (rolls[k] - rolls[k - 1]) / change, 0.0)
                rolls.append(rolls[k] - step)
        unit = np.broadcast_to(np.eye(3)[2][:, None], (3, inside.size))
        by = one.fixed_by(unit, np.zeros((len(ERROR_NAMES), inside.size)))
        result[inside, 0], result[inside, 1:] = one.value[PHASE], by[PHASE].T
    result[segment.status != Status.SOLVED] = np.nan
    return result


def _at_roll(
    path: SurfacePaths, cases: Integers, start: FloatArray, roll: FloatArray, sense: FloatArray
) -> tuple[FloatArray, ErrorRates]:
    """Return the contacts (4, n) of cases at pinion rolls (n,), and their derivatives."""
    problem = path.problem
    met, _ = solve(problem.surfaces, problem.placed.of_cases(cases), start, given_row(2, roll))
    return met.state, error_rates(path, cases, met.state, sense[cases])
