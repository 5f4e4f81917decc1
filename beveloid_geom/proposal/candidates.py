"""The pairs that close as a request asks for: what is unknown, from where it is searched, what is found.

Every condition fixes one number of the pair. The working pressure angle always is one of those that are
found; after it come, as far as they are free, the gear's helix angle, the cone angles, the pinion's helix
angle and the shifts. What is free beyond that keeps the round values at which the search starts: points
spread evenly over the limits. Where round values give nothing all that is free moves, the shortest way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Mask, flank_sign
from .conditions import (
    GEAR_CONE,
    GEAR_HELIX,
    GEAR_SHIFT,
    PINION_CONE,
    PINION_HELIX,
    PINION_SHIFT,
    PRESSURE,
    UNITS,
    Starts,
    Wanted,
    pair_at,
    roots,
)
from .request import Bounds, Request

ORDER = (GEAR_HELIX, GEAR_CONE, PINION_CONE, PINION_HELIX, GEAR_SHIFT, PINION_SHIFT)
"""What follows from conditions first, after the working pressure angle."""
ROUND = np.array([*np.radians([1.0, 1.0, 5.0, 5.0]), 0.1, 0.1])[:, None]
"""Of what the values tried are multiples, cones, helix angles and shifts; and the TURNS."""
TURN = math.radians(15.0)
"""Of what directions of the two cone angles are. The larger is least where they are equal, at 45 deg, or
opposite."""
SPREAD, FEW, ROUNDS = 192, 24, 3
"""Starts on one request, and on each of many; how often it is searched about the nearest where few are
found."""
NEAR = np.array([*np.radians([4.0, 4.0, 10.0, 10.0]), 0.4, 0.4])[:, None]
"""How wide, in cones, helix angles and shifts."""
ON_LIMIT = 1e-9
"""Rounding (rad, modules) beyond a limit that still keeps it."""
GOLDEN = 1.0757660660868371
"""Root of x^10 = x + 1: multiples of its powers without their whole parts are spread evenly, in 9
dimensions. SciPy's sequences take longer to import than a search takes."""
SAME = 1e-5
"""Difference (rad, modules) below which two pairs are one."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Pairs (7, n) that close as required, by conditions.VARIABLES."""

    values: FloatArray

    def take(self, rows: Mask | NDArray[np.intp]) -> Candidates:
        """Give some of them."""
        return Candidates(self.values[:, rows])


def given_of(request: Request) -> dict[int, float]:
    """Give what is given of VARIABLES."""
    given: dict[int, float] = {}
    if request.cone_angles is not None:
        given |= dict(zip((PINION_CONE, GEAR_CONE), request.cone_angles, strict=True))
    if request.helix_angle is not None:
        given[PINION_HELIX] = request.helix_angle
    if request.shifts is not None:
        given |= dict(zip((PINION_SHIFT, GEAR_SHIFT), request.shifts, strict=True))
    if request.gear is not None:
        held = request.gear
        values = (held.cone_angle, held.helix_angle, held.profile_shift)
        given |= dict(zip((GEAR_CONE, GEAR_HELIX, GEAR_SHIFT), map(float, values), strict=True))
    return given


def wanted_of(request: Request, along: bool = False) -> Wanted:
    """Give the conditions of a request."""
    module = float(request.members[0].tool.normal_module)
    offset = None if request.offset is None else request.offset / module
    return Wanted(
        request.shaft_angle, request.backlash / module, offset, request.crossing, request.flank, along
    )


def free_of(request: Request) -> list[int]:
    """Give what of VARIABLES is not given and can follow from conditions; on parallel axes the shifts."""
    given, order = given_of(request), ORDER if request.shaft_angle > 0.0 else ORDER[-2:]
    return [variable for variable in order if variable not in given]


def unknown_of(request: Request, along: bool = False) -> tuple[int, ...] | None:
    """Give what of VARIABLES is found from the conditions where no more than these fix is, None where less is
    free."""
    count, free = wanted_of(request, along).count, free_of(request)
    if request.offset == 0.0:
        # The working helix angles cancel and the working cone angles make the shaft angle: given cones
        # leave it to the shifts, and the helix angle alone changes the crossing.
        last = PINION_CONE if request.crossing is not None else PINION_HELIX
        kept = request.gear is not None or along
        free = [v for v in free if kept or v != last or (v == PINION_CONE and along)]
    return None if len(free) < count - 1 else (PRESSURE, *free[: count - 1])


def candidates_of(request: Request) -> Candidates:
    """Find pairs that close as required, within the limits of the request or not, round values of what is
    free."""
    if not request.least_cones:
        return _found(request, unknown_of(request))
    level = replace(request, least_cones=False, cone_angles=(0.0, 0.0))
    if request.offset != 0.0:
        found = _found(level, unknown_of(level))
        if request.offset is None or request.shaft_angle == 0.0 or within(request, found).any():
            return found
    return _found(request, unknown_of(request, along=True), along=True)


def others_found(request: Request) -> Candidates:
    """Find pairs that close as required anywhere between, within the limits of the request or not; where few
    are within, again about those that are nearest to it."""
    if unknown_of(request) is None:
        return Candidates(np.empty((7, 0)))
    return _found(request, (PRESSURE, *free_of(request)), rounds=ROUNDS)


def found_for_each(requests: Sequence[Request]) -> tuple[Candidates, NDArray[np.intp]]:
    """Find pairs that close as any of several requests require, which give the same, with other numbers; and
    which of them each is for."""
    starts = [_starts(request, FEW, False, number) for number, request in enumerate(requests)]
    joined = _joined(starts)
    wanted = [vars(wanted_of(request)) for request in requests]
    each: dict[str, Any] = {
        name: np.array([one[name] for one in wanted])[joined.owner]
        for name in ("shaft_angle", "backlash", "offset", "crossing")
        if wanted[0][name] is not None
    }
    first = requests[0]
    found = roots(first.members, replace(wanted_of(first), **each), joined, (PRESSURE, *free_of(first)))
    found = found.take(_sound(first, found))
    return Candidates(found.values), found.owner


def limits_of(request: Request) -> tuple[Bounds, ...]:
    """Give the limits of cone angles, helix angles and shifts, each of pinion and gear."""
    return (request.cone_limits,) * 2 + (request.helix_limits,) * 2 + (request.shift_limits,) * 2


def within(request: Request, found: Candidates) -> Mask:
    """Tell which pairs keep the limits of the request."""
    return np.asarray((np.abs(_put_back(request, found.values) - found.values) <= ON_LIMIT).all(axis=0))


def _put_back(request: Request, values: FloatArray) -> FloatArray:
    """Give pairs (7, n) with what is beyond the limits on them."""
    found, given = values.copy(), given_of(request)
    for variable, (low, high) in enumerate(limits_of(request)):
        if variable not in given:
            found[variable] = np.clip(values[variable], low, high)
    return found


def _found(
    request: Request, unknown: tuple[int, ...] | None, along: bool = False, rounds: int = 0
) -> Candidates:
    if unknown is None:
        return Candidates(np.empty((7, 0)))
    wanted, starts = wanted_of(request, along), _starts(request, SPREAD, not rounds, along=along)
    found = roots(request.members, wanted, starts, unknown)
    found = found.take(_sound(request, found))
    about = np.zeros(starts.values.shape)
    about[:6] = NEAR * (_spread(SPREAD)[:6] - 0.5)
    for _ in range(rounds):
        found = found.take(_first_of_each(found.values))
        past = (np.abs(_put_back(request, found.values) - found.values) / UNITS[:, None]).sum(axis=0)
        if not past.size or np.count_nonzero(past < ON_LIMIT) > FEW:
            break
        again = found.take(np.resize(np.argsort(past, kind="stable")[:FEW], SPREAD))
        moved = again.values.copy()
        moved[list(unknown)] += about[list(unknown)]
        again = roots(request.members, wanted, replace(again, values=_put_back(request, moved)), unknown)
        found = _joined((found, again.take(_sound(request, again))))
    return Candidates(found.values[:, _first_of_each(found.values)])


def _joined(starts: Sequence[Starts]) -> Starts:
    return Starts(*(np.concatenate([vars(one)[name] for one in starts], -1) for name in vars(starts[0])))


def _spread(count: int) -> FloatArray:
    """Spread points evenly over a cube (9, count)."""
    return np.asarray(np.arange(1, count + 1) / GOLDEN ** np.arange(1, 10)[:, None] % 1.0)


def _starts(request: Request, count: int, rounded: bool, owner: int = 0, along: bool = False) -> Starts:
    """Give starts spread over the limits, of round values or not, a search each; of the mirror image of a
    request the mirror images."""
    spread = _spread(count)
    low, high = np.array(limits_of(request)).T[..., None]
    values = low + (high - low) * spread[:6]
    if rounded:
        values = np.clip(np.round(values / ROUND) * ROUND, low, high)
    given, shaft = given_of(request), request.shaft_angle
    if (given.get(PINION_HELIX) or given.get(GEAR_HELIX) or flank_sign(request.flank)) < 0.0:
        values[2:4], spread[6] = low[2:4] + high[2:4] - values[2:4], 1.0 - spread[6]
    hand, side = np.where(spread[6:8] < 0.5, -1.0, 1.0)
    turn = np.round((2.0 * spread[8] - 1.0) * math.pi / TURN) * TURN
    if along:
        values[:2] = 0.08 * np.cos(turn), 0.08 * np.sin(turn)
    elif request.offset == 0.0:
        values[GEAR_CONE] = shaft - values[PINION_CONE]
    for variable, value in given.items():
        values[variable] = value
    crossing = _crossing(request, values) if request.offset != 0.0 else 0.0 * hand
    pairs = ((PINION_HELIX, GEAR_HELIX, hand * crossing), (PINION_CONE, GEAR_CONE, 0.0))
    for own, other, total in pairs if shaft == 0.0 else pairs[:1]:
        if other not in given:
            values[other] = total - values[own]
        elif own not in given:
            values[own] = total - values[other]
    pressure = np.full((1, count), float(request.members[0].tool.normal_pressure_angle) + 0.01)
    return Starts(np.vstack((values, pressure)), hand, side, turn, np.full(count, owner))


def _crossing(request: Request, values: FloatArray) -> FloatArray:
    """Guess the sum of the working helix angles: from the offset, if it is given, and rough radii."""
    if request.offset is None or request.shaft_angle == 0.0:
        return np.full(values.shape[1], request.shaft_angle)
    module, (first, second) = float(request.members[0].tool.normal_module), request.teeth
    mate = 0.0 if request.gear is None else abs(float(request.gear.helix_angle))
    reach = 0.5 * module * (first / np.cos(values[PINION_HELIX]) + second / np.cos(mate))
    return np.asarray(np.arcsin(np.clip(request.offset * math.sin(request.shaft_angle) / reach, 0.0, 0.99)))


def _sound(request: Request, found: Starts) -> Mask:
    """Tell which of the pairs found are ones: backlash that grows as the gears part, which it does not at a
    second, false working pressure angle; axes that lean in the sense of the helix angles; cones whose apexes
    lie the same way."""
    design, layout = pair_at(request.members, found.values)
    wider = found.values.copy()
    wider[PRESSURE] += 1e-5
    rising = pair_at(request.members, wider)[1].normal_backlash > layout.normal_backlash
    if request.shaft_angle == 0.0:
        return np.asarray(rising)
    if request.offset == 0.0:
        return np.asarray(rising & (layout.cone_angle.sum(axis=0) > 0.0))
    return np.asarray(rising & (design.sense == found.sense) & (layout.offset > 0.0))


def _first_of_each(values: FloatArray) -> NDArray[np.intp]:
    """Find the first of pairs (7, n) that are alike, in their order."""
    return np.sort(np.unique(np.round(values / SAME), axis=1, return_index=True)[1])
