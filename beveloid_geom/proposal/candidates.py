"""Candidates for a request: unknown quantities, starts of the search, solutions.

Every equation determines one quantity of the pair. The working pressure angle is always unknown. The next
unknowns, if they are free, are the helix angle of the gear, the cone angles, the helix angle of the pinion
and the shifts. Further free quantities keep the rounded values at which the search starts: points spread
evenly over the limits. If these have no solution, all free quantities are changed by the shortest steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Mask, flank_sign
from ..support.array_records import joined
from .closure_equations import STEP_SCALE, ClosureStarts, Variable, Wanted, pair_at, roots
from .request import Bounds, Request

STARTS_FOR_EACH = 24
"""Number of starts for each of several requests."""
LIMIT_TOLERANCE = 1e-9
"""Rounding error allowed beyond a limit, rad and modules."""


def given_of(request: Request) -> dict[int, float]:
    """Return the given values by `Variable`."""
    given: dict[int, float] = {}
    if request.cone_angles is not None:
        given |= dict(zip((Variable.PINION_CONE, Variable.GEAR_CONE), request.cone_angles, strict=True))
    if request.helix_angle is not None:
        given[Variable.PINION_HELIX] = request.helix_angle
    if request.shifts is not None:
        given |= dict(zip((Variable.PINION_SHIFT, Variable.GEAR_SHIFT), request.shifts, strict=True))
    if request.gear is not None:
        gear = request.gear
        values = (gear.cone_angle, gear.helix_angle, gear.profile_shift)
        given |= dict(
            zip(
                (Variable.GEAR_CONE, Variable.GEAR_HELIX, Variable.GEAR_SHIFT),
                map(float, values),
                strict=True,
            )
        )
    return given


def wanted_of(request: Request, cone_ratio_given: bool = False) -> Wanted:
    """Return the requirements of a request."""
    module = float(request.members[0].tool.normal_module)
    offset = None if request.offset is None else request.offset / module
    return Wanted(
        request.shaft_angle,
        request.backlash / module,
        offset,
        request.crossing,
        request.flank,
        cone_ratio_given,
    )


def free_of(request: Request) -> list[int]:
    """Return each `Variable` that is not given and can be unknown, in the order in which they become unknown
    after the working pressure angle; on parallel axes only shifts."""
    angles = (Variable.GEAR_HELIX, Variable.GEAR_CONE, Variable.PINION_CONE, Variable.PINION_HELIX)
    order = (*(angles if request.shaft_angle > 0.0 else ()), Variable.GEAR_SHIFT, Variable.PINION_SHIFT)
    given = given_of(request)
    return [variable for variable in order if variable not in given]


def unknown_of(request: Request, cone_ratio_given: bool = False) -> tuple[int, ...] | None:
    """Return each `Variable` that is determined by the equations, None if too few quantities are free."""
    count, free = wanted_of(request, cone_ratio_given).count, free_of(request)
    if request.offset == 0.0:
        # Intersecting axes: the working helix angles cancel, and the sum of the working cone angles is the
        # shaft angle. With given cones, the shifts are unknown. Only the helix angle changes the angle of the
        # generators.
        last = Variable.PINION_CONE if request.crossing is not None else Variable.PINION_HELIX
        all_free = request.gear is not None or cone_ratio_given
        free = [v for v in free if all_free or v != last or (v == Variable.PINION_CONE and cone_ratio_given)]
    return None if len(free) < count - 1 else (Variable.PRESSURE, *free[: count - 1])


def candidates_of(request: Request) -> FloatArray:
    """Return pairs that meet the requirements, with rounded free quantities.

    Parameters
    ----------
    request : Request

    Returns
    -------
    ndarray, shape (7, n)
        Values of the pairs, within the limits of the request or not.
    """
    if not request.least_cones:
        return _solved_pairs(request, unknown_of(request))
    # Least cones: try cylindrical gears first.
    cylindrical = replace(request, least_cones=False, cone_angles=(0.0, 0.0))
    if request.offset != 0.0:
        pairs = _solved_pairs(cylindrical, unknown_of(cylindrical))
        if request.offset is None or request.shaft_angle == 0.0 or within(request, pairs).any():
            return pairs
    return _solved_pairs(request, unknown_of(request, cone_ratio_given=True), cone_ratio_given=True)


def other_pairs(request: Request) -> FloatArray:
    """Return pairs that meet the requirements without rounded quantities.

    If few of them are within the limits, the search is repeated around the pairs that are nearest to the
    limits."""
    # Number of searches around the pairs nearest to the limits, if few pairs are within the limits.
    repetitions = 3
    if unknown_of(request) is None:
        return np.empty((7, 0))
    return _solved_pairs(request, (Variable.PRESSURE, *free_of(request)), rounds=repetitions)


def found_for_each(requests: Sequence[Request]) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return pairs for several requests, and the number of the request of each pair.

    All requests give the same quantities, with different values."""
    starts = [_starts(request, STARTS_FOR_EACH, False, number) for number, request in enumerate(requests)]
    every = joined(starts)
    wanted = [vars(wanted_of(request)) for request in requests]
    each: dict[str, Any] = {
        name: np.array([values[name] for values in wanted])[every.owner]
        for name in ("shaft_angle", "backlash", "offset", "crossing")
        if wanted[0][name] is not None
    }
    first = requests[0]
    solutions = roots(
        first.members, replace(wanted_of(first), **each), every, (Variable.PRESSURE, *free_of(first))
    )
    solutions = solutions.take(_valid(first, solutions))
    return solutions.values, solutions.owner


def variable_limits(request: Request) -> tuple[Bounds, ...]:
    """Return the limits of cone angles, helix angles and shifts, each for pinion and gear."""
    return (request.cone_limits,) * 2 + (request.helix_limits,) * 2 + (request.shift_limits,) * 2


def within(request: Request, values: FloatArray) -> Mask:
    """Return the mask of pairs within the limits of the request."""
    return np.asarray((np.abs(_clipped(request, values) - values) <= LIMIT_TOLERANCE).all(axis=0))


def _clipped(request: Request, values: FloatArray) -> FloatArray:
    """Return pairs (7, n) with free quantities clipped to their limits."""
    clipped, given = values.copy(), given_of(request)
    for variable, (low, high) in enumerate(variable_limits(request)):
        if variable not in given:
            clipped[variable] = np.clip(values[variable], low, high)
    return clipped


def _solved_pairs(
    request: Request, unknown: tuple[int, ...] | None, cone_ratio_given: bool = False, rounds: int = 0
) -> FloatArray:
    """Return the solutions for a request by changing the `unknown` quantities.

    With `rounds`, the starts are not rounded, and the search is repeated around the pairs nearest to the
    limits."""
    if unknown is None:
        return np.empty((7, 0))
    # Number of starts for one request.
    starts_for_one = 192
    wanted, starts = (
        wanted_of(request, cone_ratio_given),
        _starts(request, starts_for_one, not rounds, cone_ratio_given=cone_ratio_given),
    )
    solutions = roots(request.members, wanted, starts, unknown)
    solutions = solutions.take(_valid(request, solutions))
    offsets = np.zeros(starts.values.shape)
    # Width of these searches in cone angles, helix angles (rad) and shifts.
    neighbourhood = np.array([*np.radians([4.0, 4.0, 10.0, 10.0]), 0.4, 0.4])[:, None]
    offsets[:6] = neighbourhood * (_spread(starts_for_one)[:6] - 0.5)
    for _ in range(rounds):
        solutions = solutions.take(_first_of_each(solutions.values))
        past = (np.abs(_clipped(request, solutions.values) - solutions.values) / STEP_SCALE[:, None]).sum(
            axis=0
        )
        if not past.size or np.count_nonzero(past < LIMIT_TOLERANCE) > STARTS_FOR_EACH:
            break
        again = solutions.take(np.resize(np.argsort(past, kind="stable")[:STARTS_FOR_EACH], starts_for_one))
        moved = again.values.copy()
        moved[list(unknown)] += offsets[list(unknown)]
        again = roots(request.members, wanted, replace(again, values=_clipped(request, moved)), unknown)
        solutions = joined((solutions, again.take(_valid(request, again))))
    return np.asarray(solutions.values[:, _first_of_each(solutions.values)])


def _spread(count: int) -> FloatArray:
    """Return `count` points spread evenly over a unit cube, (9, count)."""
    # Root of x^10 = x + 1. The fractional parts of multiples of its inverse powers are spread evenly in
    # 9 dimensions. The import of SciPy's sequences takes longer than a search.
    sequence_base = 1.0757660660868371
    return np.asarray(np.arange(1, count + 1) / sequence_base ** np.arange(1, 10)[:, None] % 1.0)


def _starts(
    request: Request, count: int, rounded: bool, owner: int = 0, cone_ratio_given: bool = False
) -> ClosureStarts:
    """Return starts spread over the limits of a request, with rounded values or not.

    The mirror image of a request has the mirror images of the starts."""
    # Step of the direction in the plane of the two cone angles. The larger cone angle is smallest if
    # both are equal or opposite, at 45 deg.
    turn_step = math.radians(15.0)
    spread = _spread(count)
    low, high = np.array(variable_limits(request)).T[..., None]
    values = low + (high - low) * spread[:6]
    # Step of the rounded start values of cone angles, helix angles (rad) and shifts.
    start_step = np.array([*np.radians([1.0, 1.0, 5.0, 5.0]), 0.1, 0.1])[:, None]
    if rounded:
        values = np.clip(np.round(values / start_step) * start_step, low, high)
    given, shaft = given_of(request), request.shaft_angle
    if (
        given.get(Variable.PINION_HELIX) or given.get(Variable.GEAR_HELIX) or flank_sign(request.flank)
    ) < 0.0:
        values[2:4], spread[6] = low[2:4] + high[2:4] - values[2:4], 1.0 - spread[6]
    hand, side = np.where(spread[6:8] < 0.5, -1.0, 1.0)
    turn = np.round((2.0 * spread[8] - 1.0) * math.pi / turn_step) * turn_step
    if cone_ratio_given:
        values[:2] = 0.08 * np.cos(turn), 0.08 * np.sin(turn)
    elif request.offset == 0.0:
        values[Variable.GEAR_CONE] = shaft - values[Variable.PINION_CONE]
    for variable, value in given.items():
        values[variable] = value
    helix_sum = _helix_sum(request, values) if request.offset != 0.0 else 0.0 * hand
    pairs = (
        (Variable.PINION_HELIX, Variable.GEAR_HELIX, hand * helix_sum),
        (Variable.PINION_CONE, Variable.GEAR_CONE, 0.0),
    )
    for first, second, total in pairs if shaft == 0.0 else pairs[:1]:
        if second not in given:
            values[second] = total - values[first]
        elif first not in given:
            values[first] = total - values[second]
    pressure = np.full((1, count), float(request.members[0].tool.normal_pressure_angle) + 0.01)
    return ClosureStarts(np.vstack((values, pressure)), hand, side, turn, np.full(count, owner))


def _helix_sum(request: Request, values: FloatArray) -> FloatArray:
    """Return an estimate of the sum of the working helix angles: from the offset and approximate radii if the
    offset is given, otherwise the shaft angle."""
    if request.offset is None or request.shaft_angle == 0.0:
        return np.full(values.shape[1], request.shaft_angle)
    module, (first, second) = float(request.members[0].tool.normal_module), request.teeth
    mate = 0.0 if request.gear is None else abs(float(request.gear.helix_angle))
    reach = 0.5 * module * (first / np.cos(values[Variable.PINION_HELIX]) + second / np.cos(mate))
    return np.asarray(np.arcsin(np.clip(request.offset * math.sin(request.shaft_angle) / reach, 0.0, 0.99)))


def _valid(request: Request, solutions: ClosureStarts) -> Mask:
    """Return the mask of valid solutions.

    At a valid solution the backlash increases with the distance of the gears; a second, false working
    pressure angle is excluded by this. The sense of the shaft angle fits the helix angles. On intersecting
    axes the sum of the cone angles is positive."""
    design, layout = pair_at(request.members, solutions.values)
    wider = solutions.values.copy()
    wider[Variable.PRESSURE] += 1e-5
    rising = pair_at(request.members, wider)[1].normal_backlash > layout.normal_backlash
    if request.shaft_angle == 0.0:
        return np.asarray(rising)
    if request.offset == 0.0:
        return np.asarray(rising & (layout.cone_angle.sum(axis=0) > 0.0))
    return np.asarray(rising & (design.sense == solutions.sense) & (layout.offset > 0.0))


def _first_of_each(values: FloatArray) -> NDArray[np.intp]:
    """Return the indices of different pairs (7, n), in their order."""
    # Difference below which two pairs are equal, rad and modules.
    equality_tolerance = 1e-5
    return np.sort(np.unique(np.round(values / equality_tolerance), axis=1, return_index=True)[1])
