"""The pairs that close as a request asks for: what is unknown, from where it is searched, what is found.

Every condition fixes one number of the pair. The working pressure angle always is one of those that are
found; after it come, as far as they are free, the gear's helix angle, the cone angles, the pinion's helix
angle and the shifts. What is free beyond that is tried at a few values of use.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Mask
from .conditions import (
    GEAR_CONE,
    GEAR_HELIX,
    GEAR_SHIFT,
    PINION_CONE,
    PINION_HELIX,
    PINION_SHIFT,
    PRESSURE,
    Starts,
    Wanted,
    pair_at,
    roots,
)
from .request import Bounds, Request

ORDER = (GEAR_HELIX, GEAR_CONE, PINION_CONE, PINION_HELIX, GEAR_SHIFT, PINION_SHIFT)
"""What follows from conditions first, after the working pressure angle."""
CONE_STARTS = np.radians([-5.0, 0.0, 5.0, 11.0])
HELIX_STARTS = np.radians([-30.0, -10.0, 10.0, 30.0])
HELICES = np.radians([0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0])
STEEP = np.radians([35.0, 40.0, 45.0])
SHIFTS = -0.2, 0.0, 0.2, 0.4, 0.6, 0.8
FINE_SHIFTS = tuple(0.1 * k for k in range(-5, 9))
"""Starts of what is searched for, and values tried of what is free; the fine shifts if that is
one shift, steep helix angles only where the others give nothing."""
TURNS = np.radians(np.arange(-165.0, 181.0, 15.0))
"""Directions of the two cone angles. The larger is least where they are equal, at 45 deg, or opposite."""
MANY = 4
"""Unknowns from which the shifts tried start from what is found without shifts, as far as these have cones
of at most GENTLE, the least FEW of them."""
GENTLE, FEW = math.radians(20.0), 12
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


def unknown_of(request: Request, along: bool = False) -> tuple[int, ...] | None:
    """Give what of VARIABLES is found from the conditions, None where less is free than they fix."""
    given, count = given_of(request), wanted_of(request, along).count
    free = [variable for variable in ORDER if variable not in given]
    if request.offset == 0.0:
        # The working helix angles cancel and the working cone angles make the shaft angle: given cones
        # leave it to the shifts, and the helix angle alone changes the crossing.
        last = PINION_CONE if request.crossing is not None else PINION_HELIX
        kept = request.gear is not None or along
        free = [v for v in free if kept or v != last or (v == PINION_CONE and along)]
    return None if len(free) < count - 1 else (PRESSURE, *free[: count - 1])


def candidates_of(request: Request, steep: bool = False) -> Candidates:
    """Find the pairs that close as required, within the limits of the request or not; with `steep` helix
    angles of the pinion where these are tried."""
    if not request.least_cones:
        return _found(request, unknown_of(request), (0.0,), steep)
    level = replace(request, least_cones=False, cone_angles=(0.0, 0.0))
    if request.offset != 0.0:
        found = _found(level, unknown_of(level), (0.0,), steep)
        if request.offset is None or within(request, found).any():
            return found
    return _found(request, unknown_of(request, along=True), TURNS, steep)


def limits_of(request: Request) -> tuple[Bounds, ...]:
    """Give the limits of cone angles, helix angles and shifts, each of pinion and gear."""
    return (request.cone_limits,) * 2 + (request.helix_limits,) * 2 + (request.shift_limits,) * 2


def within(request: Request, found: Candidates) -> Mask:
    """Tell which pairs keep the limits of the request."""
    given, limits = given_of(request), limits_of(request)
    kept = np.ones(found.values.shape[1], bool)
    for variable, (low, high) in enumerate(limits):
        if variable not in given:
            kept &= (found.values[variable] >= low - 1e-9) & (found.values[variable] <= high + 1e-9)
    return kept


def _found(request: Request, unknown: tuple[int, ...] | None, turns: ArrayLike, steep: bool) -> Candidates:
    if unknown is None:
        return Candidates(np.empty((7, 0)))
    starts = _starts(request, unknown, np.asarray(turns), steep)
    wanted = wanted_of(request, np.size(turns) > 1)
    shifts = [v for v in (PINION_SHIFT, GEAR_SHIFT) if v not in (*unknown, *given_of(request))]
    if shifts and len(unknown) >= MANY:
        combinations = np.unique(starts.values[shifts], axis=1)
        middle = combinations[:, np.argmin(np.abs(combinations).sum(axis=0))]
        found = roots(
            request.members, wanted, starts.take((middle == starts.values[shifts].T).all(axis=1)), unknown
        )
        size = np.abs(found.values[:2]).max(axis=0, initial=0.0)
        found = found.take([k for k in np.argsort(size)[: 4 * FEW] if size[k] < GENTLE])
        found = found.take(_first_of_each(found.values))
        found = found.take(np.arange(min(FEW, found.sense.size)))
        starts = found.take(np.repeat(np.arange(found.sense.size), combinations.shape[1]))
        starts.values[shifts] = np.tile(combinations, found.sense.size)
    found = roots(request.members, wanted, starts, unknown)
    found = found.take(_sound(request, found))
    return Candidates(found.values[:, _first_of_each(found.values)])


def _starts(request: Request, unknown: tuple[int, ...], turns: FloatArray, steep: bool) -> Starts:
    """Give all combinations of starts and of values tried, a search each."""
    given, crossed = given_of(request), request.offset != 0.0
    limits = limits_of(request)
    share = request.teeth[0] / sum(request.teeth)
    tried: dict[int, ArrayLike] = {
        PINION_CONE: request.shaft_angle * np.array([share, 0.5, 0.0, 1.0]),
        PINION_HELIX: STEEP if steep else np.append(HELICES, 0.5 * request.shaft_angle),
        PINION_SHIFT: SHIFTS,
        GEAR_SHIFT: SHIFTS,
    }
    free = [v for v in (PINION_SHIFT, GEAR_SHIFT) if v not in given and v not in unknown]
    if len(free) == 1:
        tried[free[0]] = FINE_SHIFTS
    along = turns.size > 1
    searched: dict[int, ArrayLike] = {
        PINION_CONE: [0.0] if along else CONE_STARTS,
        GEAR_CONE: [0.0] if along else CONE_STARTS,
        PINION_HELIX: HELIX_STARTS,
        PINION_SHIFT: [0.0],
        GEAR_SHIFT: [0.0],
    }
    axes: list[ArrayLike] = []
    for variable in (PINION_CONE, GEAR_CONE, PINION_HELIX, PINION_SHIFT, GEAR_SHIFT):
        if variable in given:
            axes.append([given[variable]])
        elif variable in unknown:
            axes.append(searched[variable])
        else:
            low, high = limits[variable]
            axes.append([v for v in np.asarray(tried[variable]) if low <= v <= high] or [0.5 * (low + high)])
    hands = (1.0, -1.0) if crossed else (1.0,)
    sides = (1.0, -1.0) if request.crossing is not None else (1.0,)
    grid = np.stack([a.ravel() for a in np.meshgrid(*axes, hands, sides, turns, indexing="ij")])
    cone, mate, helix, shift, mate_shift, hand, side, turn = grid
    if along:
        cone, mate = 0.08 * np.cos(turn), 0.08 * np.sin(turn)
    crossing = _crossing(request, helix) if crossed else 0.0 * helix
    held = given.get(GEAR_HELIX)
    if held is None:
        gear_helix = hand * crossing - helix
    else:
        gear_helix = np.full(helix.shape, held)
        helix = helix if PINION_HELIX in given else hand * crossing - held
    pressure = np.full(helix.shape, float(request.members[0].tool.normal_pressure_angle) + 0.01)
    values = np.stack((cone, mate, helix, gear_helix, shift, mate_shift, pressure))
    return Starts(values, hand, side, turn)


def _crossing(request: Request, helix: FloatArray) -> FloatArray:
    """Guess the sum of the working helix angles: from the offset, if it is given, and rough radii."""
    if request.offset is None:
        return np.full(helix.shape, request.shaft_angle)
    module, (first, second) = float(request.members[0].tool.normal_module), request.teeth
    mate = 0.0 if request.gear is None else abs(float(request.gear.helix_angle))
    reach = 0.5 * module * (first / np.cos(helix) + second / np.cos(mate))
    return np.asarray(np.arcsin(np.clip(request.offset * math.sin(request.shaft_angle) / reach, 0.0, 0.99)))


def _sound(request: Request, found: Starts) -> Mask:
    """Tell which of the pairs found are ones: backlash that grows as the gears part, which it does not at a
    second, false working pressure angle; axes that lean in the sense of the helix angles; cones whose apexes
    lie the same way."""
    design, layout = pair_at(request.members, found.values)
    wider = found.values.copy()
    wider[PRESSURE] += 1e-5
    rising = pair_at(request.members, wider)[1].normal_backlash > layout.normal_backlash
    if request.offset == 0.0:
        return np.asarray(rising & (layout.cone_angle.sum(axis=0) > 0.0))
    return np.asarray(rising & (design.sense == found.sense) & (layout.offset > 0.0))


def _first_of_each(values: FloatArray) -> NDArray[np.intp]:
    """Find the first of pairs (7, n) that are alike, in their order."""
    return np.sort(np.unique(np.round(values / SAME), axis=1, return_index=True)[1])
