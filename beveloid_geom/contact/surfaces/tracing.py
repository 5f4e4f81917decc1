"""Search for curves of contact without an approximate position, and curves traced by their length.

At a flank point (s1, z1) of the pinion, the roll can be chosen such that the profiles are tangent, G.P_s = 0.
The remaining equation g = G.P_z is then a function over the flank, and its zeros are the contacts. g is
computed on a grid. Every change of sign is a starting point; a curve is traced in both directions until it
leaves the flanks.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Mask
from .curve import Curve, sampled
from .limits import Problem, margins_at
from .segments import on_plane
from .tangency import Contacts, contacts_at, given_row, meshing_start, solve

GRID_S, GRID_Z = 17, 13
"""Number of grid lines along profile and face."""
FIRST_STEP, LARGEST_STEP, LEAST_STEP, MAX_STEPS = 0.06, 0.12, 1e-4, 400
"""Steps along a curve in the units of `Problem.scale`, and their number."""


def grid_function(problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Return states (4, GRID_S, GRID_Z) with tangent profiles over the flank of the pinion of a single case,
    and g there, relative to the lengths of the vectors; NaN where the profiles cannot be tangent.
    """
    s = np.linspace(problem.lowest[0], problem.highest[0], GRID_S)
    z = problem.half_width[0] * np.linspace(-1.0, 1.0, GRID_Z)
    s1, z1 = (values.ravel() for values in np.meshgrid(s, z, indexing="ij"))
    placed = problem.placed.take(np.zeros(s1.size, dtype=int))
    state = meshing_start(problem.surfaces, placed, s1, z1)
    # Newton steps to tangent profiles, and angle (rad) that counts as tangent.
    profile_steps, profile_tolerance = 14, 1e-10
    for _ in range(profile_steps):
        met = contacts_at(problem.surfaces, placed, state)
        turn = np.clip(-met.residual[0] / met.gradient[0, 2], -0.3, 0.3)
        state = state.copy()
        state[2] += turn
        state[3] += met.follow[0] + met.follow[3] * turn
        if not (np.abs(turn) > profile_tolerance).any():
            break
    met = contacts_at(problem.surfaces, placed, state)
    turn = np.abs(met.residual[0] / met.gradient[0, 2])
    # g as the step of the roll that would make it vanish has no natural scale; its sign suffices.
    g = np.where((turn <= 1e3 * profile_tolerance) & met.opposed, met.residual[1], np.nan)
    return state.reshape(4, GRID_S, GRID_Z), g.reshape(GRID_S, GRID_Z)


def seeds_of(problem: Problem) -> tuple[FloatArray, bool]:
    """Return contacts (4, n) near the flank of the pinion of a single case, and whether all of g is known."""
    state, g = grid_function(problem)
    starts, rows = [], []
    for axis in (0, 1):
        low, high = (np.take(g, range(k, g.shape[axis] - 1 + k), axis=axis) for k in (0, 1))
        share = low / (low - high)
        first, second = (np.take(state, range(k, g.shape[axis] - 1 + k), axis=1 + axis) for k in (0, 1))
        crossing = low * high <= 0.0
        starts.append((first + share * (second - first))[:, crossing])
        rows.append(np.full(crossing.sum(), 1 - axis))
    # Without a change of sign: places where g is small in comparison with its variation.
    spread = np.abs(np.gradient(g, axis=0)) + np.abs(np.gradient(g, axis=1))
    close = np.abs(g) <= spread
    starts.append(state[:, close])
    rows.append(np.zeros(close.sum(), dtype=int))
    start, row = np.concatenate(starts, axis=1), np.concatenate(rows)
    found = []
    for held in (0, 1):
        part = start[:, row == held]
        placed = problem.placed.take(np.zeros(part.shape[1], dtype=int))
        result, good = solve(problem.surfaces, placed, part, given_row(held, part[held]))
        found.append(result.state[:, good])
    seeds = np.concatenate(found, axis=1)
    return seeds, bool(np.isfinite(g).all())


def _room(problem: Problem, met: Contacts) -> FloatArray:
    """Return the least margin (n,) in flank depths and face widths."""
    values, _ = margins_at(problem, met)
    depth, face = problem.highest - problem.lowest, 2.0 * problem.half_width
    return np.asarray((values / np.concatenate((depth, depth, face, face))[:, None]).min(axis=0))


def traced(problem: Problem, seed: FloatArray) -> tuple[Curve | None, bool]:
    """Return the curve through a contact (4,) of a single case until it leaves the flanks, and whether it is
    complete. A closed curve is not complete; no curve if it cannot be followed.
    """
    both: list[list[tuple[FloatArray, FloatArray]]] = []
    complete = True
    for sense in (-1.0, 1.0):
        way, whole = _followed(problem, seed, sense)
        complete &= whole
        both.append(way)
    ways = both[0][:0:-1] + both[1]
    if len(ways) < 2:
        return None, False
    states = np.array([state for state, _ in ways]).T
    directions = np.array([-direction for _, direction in both[0][:0:-1]] + [d for _, d in both[1]]).T
    steps = np.linalg.norm(np.diff(states[:3]) / problem.scale[:, None], axis=0)
    x = np.concatenate(([0.0], np.cumsum(steps)))
    met = contacts_at(problem.surfaces, problem.placed.take(np.zeros(x.size, dtype=int)), states)
    return sampled(problem, x[None], met, directions), complete


def _followed(
    problem: Problem, seed: FloatArray, sense: float
) -> tuple[list[tuple[FloatArray, FloatArray]], bool]:
    """Return states and directions along the curve from a contact, and whether it ends off the flanks."""
    # Angle (rad) by which a curve may turn in one step, and at the beginning of a relief, where the second
    # derivatives of the flank jump.
    max_turn, max_kink = 0.35, 1.4
    met = contacts_at(problem.surfaces, problem.placed, seed[:, None])
    state, direction = seed[:, None], _direction(problem, met, None) * sense
    way, step = [(state[:, 0], direction[:, 0])], FIRST_STEP
    # Distances from the limits, in depths and face widths, at which a curve ends, and at which it may end.
    beyond, outside = 0.1, 1e-3
    for _ in range(MAX_STEPS):
        guess = state + met.along(step * direction * problem.scale[:, None])
        following, good = solve(problem.surfaces, problem.placed, guess, on_plane(problem, guess, direction))
        ahead = _direction(problem, following, direction)
        turn = np.arccos(np.clip((ahead * direction).sum(), -1.0, 1.0))
        moved = np.linalg.norm((following.state[:3] - state[:3]) / problem.scale[:, None])
        if not good[0] or turn > max_turn or moved > 1.1 * step:
            if step > LEAST_STEP:
                step = max(0.5 * step, LEAST_STEP)
                continue
            kink = good[0] and turn < max_kink and moved * np.cos(max_kink) < step
            if not kink:  # the surface ends here, as at an edge of regression
                return way, bool(_room(problem, met)[0] < -outside)
        state, met, direction = following.state, following, ahead
        way.append((state[:, 0], direction[:, 0]))
        step = min(LARGEST_STEP, 1.5 * step if turn < 0.3 * max_turn else step)
        if _room(problem, met)[0] < -beyond:
            return way, True
        home = np.linalg.norm((state[:3, 0] - seed[:3]) / problem.scale)
        if len(way) > 4 and home < 0.5 * moved:
            return way, False
    return way, False


def _direction(problem: Problem, met: Contacts, before: FloatArray | None) -> FloatArray:
    """Return the unit direction (3, 1) of the curve, oriented as `before`."""
    tangent = met.tangent / problem.scale[:, None]
    tangent = tangent / np.linalg.norm(tangent, axis=0)
    if before is not None and (tangent * before).sum() < 0.0:
        tangent = -tangent
    return np.asarray(tangent)


def on_curve(curve: Curve, problem: Problem, seeds: FloatArray) -> Mask:
    """Return which contacts (4, n) are on a traced curve, within its spacing."""
    states = curve.value[:3, 0] / problem.scale[:, None]
    low, step = states[:, :-1], np.diff(states)
    point = (seeds[:3] / problem.scale[:, None])[:, :, None]
    share = ((point - low[:, None]) * step[:, None]).sum(axis=0) / (step * step).sum(axis=0)
    nearest = low[:, None] + np.clip(share, 0.0, 1.0) * step[:, None]
    length = np.linalg.norm(step, axis=0)
    away = np.linalg.norm(point - nearest, axis=0)
    return np.asarray((away <= 0.3 * length).any(axis=-1))
