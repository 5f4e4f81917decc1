"""Search for curves of contact without an approximate position, and curves traced by their length.

At a flank point (s1, z1) of the pinion, the roll can be chosen such that the profiles are tangent, G.P_s = 0.
The remaining equation g = G.P_z is then a function over the flank, and its zeros are the contacts. g is
computed on a grid. Every change of sign is a starting point; a curve is traced in both directions until it
leaves the flanks.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from .curve import Curve, sampled
from .limits import Problem, margins_at, on_plane
from .refinement import kink_distance
from .tangency import Contacts, contacts_at, given_row, meshing_start, solve

GRID_S, GRID_Z = 17, 13
"""Number of grid lines along profile and face."""
FIRST_STEP, LARGEST_STEP, LEAST_STEP, MAX_STEPS = 0.06, 0.12, 1e-4, 400
"""Steps along a curve in the units of `Problem.scale`, and their number."""
MAX_TURN = 0.35
"""Angle (rad) by which a curve may turn in one step."""


def grid_function(
    problem: Problem, lines: tuple[int, int] = (GRID_S, GRID_Z)
) -> tuple[FloatArray, FloatArray]:
    """Return states (4, *lines) with tangent profiles over the flank of the pinion of a single case, and g
    there; NaN where the profiles cannot be tangent. `lines`: number of grid lines along profile and face.
    """
    s = np.linspace(problem.lowest[0], problem.highest[0], lines[0])
    z = problem.half_width[0] * np.linspace(-1.0, 1.0, lines[1])
    s1, z1 = (values.ravel() for values in np.meshgrid(s, z, indexing="ij"))
    placed = problem.placed.of_cases(np.zeros(s1.size, dtype=int))
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
    # g = G.P_z has no natural scale; its sign is sufficient.
    g = np.where((turn <= 1e3 * profile_tolerance) & met.opposed, met.residual[1], np.nan)
    return state.reshape(4, *lines), g.reshape(lines)


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
    contacts = []
    for held in (0, 1):
        part = start[:, row == held]
        placed = problem.placed.of_cases(np.zeros(part.shape[1], dtype=int))
        result, good = solve(problem.surfaces, placed, part, given_row(held, part[held]))
        contacts.append(result.state[:, good])
    seeds = np.concatenate(contacts, axis=1)
    return seeds, bool(np.isfinite(g).all())


def _relative_margin(problem: Problem, met: Contacts) -> FloatArray:
    """Return the least margin (n,) in flank depths and face widths."""
    values, _ = margins_at(problem, met)
    depth, face = problem.highest - problem.lowest, 2.0 * problem.half_width
    return np.asarray((values / np.concatenate((depth, depth, face, face))[:, None]).min(axis=0))


def traced(problem: Problem, seeds: FloatArray) -> tuple[Curve, Mask]:
    """Return for every case the curve through a contact, `seeds` (4, cases), until it leaves the flanks, and
    whether it is complete (cases,). A closed curve is not complete. Curves that cannot be followed are NaN.
    """
    cases = seeds.shape[1]
    twice = np.tile(np.arange(cases), 2)
    sense = np.repeat((-1.0, 1.0), cases)
    trails, left = _followed(problem.cases(twice), seeds[:, twice], sense, problem.line_contact)
    # On parallel axes, curves that are lost are followed again with the other kind of steps: the roll may
    # turn back, as on hollow flanks, or the curve may turn by more than a right angle.
    if problem.generated_lines and not left.all():
        again = np.flatnonzero(~left)
        others, left[again] = _followed(
            problem.cases(twice[again]), seeds[:, twice[again]], sense[again], not problem.line_contact
        )
        for place, trail in zip(again.tolist(), others, strict=True):
            if left[place]:
                trails[place] = trail
    # Join both halves of each curve at the contact, from the end of the first to the end of the second.
    polylines = [
        np.concatenate((back[:, :0:-1] * np.repeat((1.0, -1.0), (4, 3))[:, None], on), axis=1)
        for back, on in zip(trails[:cases], trails[cases:], strict=True)
    ]
    width = max(2, *(polyline.shape[1] for polyline in polylines))  # 2 also if no curve could be followed
    steps = [np.linalg.norm(np.diff(polyline[:3]) / problem.scale[:, None], axis=0) for polyline in polylines]
    x = np.stack(
        [np.cumsum(np.append(np.append(0.0, step), np.ones(width - 1 - step.size))) for step in steps]
    )
    filled = np.full((7, cases, width), np.nan)
    for case, polyline in enumerate(polylines):
        if polyline.shape[1] > 1:
            filled[:, case, : polyline.shape[1]] = polyline
    states, directions = filled.reshape(7, -1)[:4], filled.reshape(7, -1)[4:]
    met = contacts_at(problem.surfaces, problem.placed.of_cases(np.repeat(np.arange(cases), width)), states)
    return sampled(problem, x, met, directions), np.asarray(left.reshape(2, cases).all(axis=0))


def _followed(
    problem: Problem, seeds: FloatArray, sense: FloatArray, by_roll: bool
) -> tuple[list[FloatArray], Mask]:
    """Return states and directions (7, samples) along the curve from a contact, `seeds` (4, cases), for each
    case, and whether the curve was followed until it is off the flanks (cases,).

    Each step ends in the plane across its direction or, with `by_roll`, at a given roll: then the curve may
    turn by any angle, if the roll never turns back."""
    # Angle (rad) by which a curve may turn at the beginning of a relief, where the second derivatives of the
    # flank jump, and largest length of the smallest step there, relative to its size. On nearly spur teeth,
    # the contact moves along the face in a small part of a pitch.
    max_kink, longest_kink = (np.pi, 1000.0) if by_roll else (1.4, 1.0 / np.cos(1.4))
    roll_axis = np.eye(3)[:, 2:]
    # Distances from the limits, in depths and face widths, at which a curve ends, and at which it may end.
    beyond, outside = 0.1, 1e-3
    met = contacts_at(problem.surfaces, problem.placed, seeds)
    state, direction, margin = seeds.copy(), _direction(problem, met, sense), _relative_margin(problem, met)
    ahead = met.along(direction * problem.scale[:, None])
    step, count = np.full(sense.size, FIRST_STEP), np.ones(sense.size, dtype=int)
    left, active = np.zeros(sense.size, dtype=bool), np.arange(sense.size)
    control = StepControl(sense.size)
    rounds = [(active, np.concatenate((state, direction)))]
    for _ in range(MAX_STEPS):
        if not active.size:
            break
        before, size = direction[:, active], step[active]
        guess, placed = state[:, active] + size * ahead[:, active], problem.placed.of_cases(active)
        onwards = roll_axis * np.sign(before[2]) if by_roll else before
        # Where reliefs of both flanks begin next to each other, the flanks nearly touch along a line between
        # them. Newton's steps are long there, so that they are limited to the longest possible kink.
        condition, reach = on_plane(problem, guess, onwards), longest_kink * size
        met, good = solve(problem.surfaces, placed, guess, condition, reach)
        after = _direction(problem, met, onwards)
        turn = np.arccos(np.clip((after * before).sum(axis=0), -1.0, 1.0))
        chord = (met.state - state[:, active])[:3] / problem.scale[:, None]
        moved = np.linalg.norm(chord, axis=0)
        failed = ~good | (turn > MAX_TURN) | (moved > 1.1 * size)
        shorter = failed & (size > LEAST_STEP)
        # With the shortest step, the curve has a kink, or the surface ends, as at an edge of regression.
        kink = failed & ~shorter & good & (turn < max_kink) & (moved < longest_kink * size)
        reached = ~failed | kink
        to_kink = kink_distance(chord, before, after)
        step[active] = control.following(active, size, turn, failed, kink, to_kink)
        there = active[reached]
        state[:, there], direction[:, there] = met.state[:, reached], after[:, reached]
        ahead[:, there] = met.along(after * problem.scale[:, None])[:, reached]
        margin[there] = _relative_margin(problem, met)[reached]
        count[there] += 1
        rounds.append((there, np.concatenate((state, direction))[:, there]))
        home = np.linalg.norm((state - seeds)[:3, active] / problem.scale[:, None], axis=0)
        closed = reached & (count[active] > 4) & (home < 0.5 * moved)
        ended = failed & ~shorter & ~kink
        gone = np.where(ended, margin[active] < -outside, reached & (margin[active] < -beyond))
        left[active] = gone
        active = active[~(ended | gone | closed)]
    order = np.argsort(np.concatenate([index for index, _ in rounds]), kind="stable")
    rows = np.concatenate([row for _, row in rounds], axis=1)[:, order]
    return np.split(rows, np.cumsum(count)[:-1], axis=1), left


class StepControl:
    """Sizes of the steps along curves that are smooth between kinks.

    A step that turns too far is repeated, shorter. If it went past a kink, the tangents before and after it
    intersect at the kink: the next step ends just before it, and one of the smallest steps crosses it.
    """

    def __init__(self, cases: int) -> None:
        """Begin with curves of which no step has failed."""
        self._bend = np.zeros(cases)  # angle of the failed step, rad; 0 without a kink ahead
        self._repeated = np.zeros(cases, dtype=bool)

    def following(
        self,
        active: Integers,
        size: FloatArray,
        turn: FloatArray,
        failed: Mask,
        kink: Mask,
        ahead: FloatArray,
    ) -> FloatArray:
        """Return the next sizes (n,) of the curves `active` (n,).

        Parameters
        ----------
        active : ndarray of int, shape (n,)
        size, turn : ndarray, shape (n,)
            Size of this step, and angle between the tangents at its ends, rad.
        failed, kink : ndarray of bool, shape (n,)
            Whether the step turns too far or was not solved, and whether it crosses a kink.
        ahead : ndarray, shape (n,)
            Estimated distance of a kink from the beginning of the step.
        """
        bend, repeated = self._bend[active], self._repeated[active]
        known = (ahead > 0.0) & (ahead < size)  # NaN if the step was not solved
        shorter = np.maximum(np.where(known, ahead - 0.5 * LEAST_STEP, 0.5 * size), LEAST_STEP)
        # Before a kink the curve is straight in comparison with the failed step.
        approached = (turn < 0.1 * bend) & (repeated | (size < FIRST_STEP))
        # Then the smallest step, in which the kink is expected, and if it is not there, ten times as much.
        onwards = np.where(turn < 0.3 * MAX_TURN, 1.5 * size, size)
        onwards = np.where(approached, np.where(repeated, LEAST_STEP, 10.0 * size), onwards)
        onwards = np.where(kink, FIRST_STEP, np.minimum(onwards, LARGEST_STEP))
        again = failed & ~kink
        self._bend[active] = np.where(
            again, np.where(known, turn, 0.0), np.where(approached & ~kink, bend, 0.0)
        )
        self._repeated[active] = again
        return np.where(again, shorter, onwards)


def _direction(problem: Problem, met: Contacts, before: FloatArray) -> FloatArray:
    """Return the unit direction (3, n) of the curve, oriented as `before` (3, n), or by the sign (n,) on its
    tangent."""
    tangent = met.tangent / problem.scale[:, None]
    tangent = tangent / np.linalg.norm(tangent, axis=0)
    sign = before if before.ndim == 1 else (tangent * before).sum(axis=0)
    return np.asarray(np.where(sign < 0.0, -tangent, tangent))


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
