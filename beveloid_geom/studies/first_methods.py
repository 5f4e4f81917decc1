"""Ways to find what touches first, each with a setting of its own, as `comparison_methods` for the tangency.

The truth is the mesh cycle's exact pieces; tests hold these to bisection and to the five equations. Grid
search and meshes look at the tooth pairs that can matter by their points: a contact of edges lies between
those, and so does a tangency.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..contact.placing import frames_at
from ..design.model import Design
from ..gear.flank import flank_patch, flank_point, root_parameter, tip_parameter, trace_parameter
from ..gear.tooth_side import surface_of
from ..operation.first_contact import first_contact
from ..operation.mesh_cycle import mesh_cycle
from ..operation.separation import pitch_shift, separation
from ..pair.frames import to_fixed
from ..shapes.mesh_contact import mesh_contact, mesh_separation
from ..status import FirstStatus, Status
from .comparison_methods import COUNT, START_TURN, TURNED, TURNED_EXACTLY, TURNS, Answer, Positions

PAIRS = np.arange(-2, 3)
"""Tooth pairs looked at."""
NEAR = 0.05
"""Modules by which a tooth pair may stand further off than the nearest, when the search by meshes starts, and
still be turned on."""


def first_positions(design: Design, flank: str) -> Positions:
    """Give the positions compared and the truth there: the middles of COUNT even parts of a mesh cycle.

    Raises ValueError where a first contact of the cycle is not known."""
    cycle = mesh_cycle(design, flank)
    if cycle.status != FirstStatus.SOLVED:
        name = FirstStatus(int(cycle.status)).name
        raise ValueError(f"not every first contact of the {flank} flanks is known ({name})")
    truth = cycle.at(cycle.start + cycle.pitch * (np.arange(COUNT) + 0.5) / COUNT)
    return Positions(design, flank, truth.pinion_roll, truth.gear_roll, truth.l1, truth.point)


def exact_answer(positions: Positions, rolls: FloatArray) -> Answer:
    """Find first contacts at pinion `rolls` (rad) of which the first are compared."""
    found = first_contact(positions.design, positions.flank, rolls)
    return found.point[:COUNT], np.stack((found.pinion_roll, found.gear_roll))[:, :COUNT]


def grid_answer(positions: Positions, count: int) -> Answer:
    """Find first contacts among `count` x `count` points of the pinion's flank, from its root to the tip cone
    and from toe to heel: the least angle by which the gear turns until it meets one of them."""
    design, flank, (pinion, _) = positions.design, positions.flank, positions.design.members
    surface, sigma = surface_of(pinion, flank), surface_of(design.gear, flank).sigma
    z = surface.half_width * np.linspace(-1.0, 1.0, count)
    low, high = root_parameter(pinion), tip_parameter(pinion, flank, z)
    l = low + (high - low) * np.linspace(0.0, 1.0, count)[:, None]
    gear_roll, place = positions.gear_roll + START_TURN, []
    for number, roll in enumerate(positions.pinion_roll):
        pairs = PAIRS[:, None, None]
        found = separation(design, flank, 0, l, z, roll, gear_roll[number], pairs)
        angle = np.where(found.inside, found.angle, np.inf)
        pair, row, column = np.unravel_index(angle.argmin(), angle.shape)
        gear_roll[number] += sigma * angle[pair, row, column]
        place.append((PAIRS[pair], l[row, column], z[column]))
    points = [_in_space(positions, k, *at) for k, at in enumerate(place)]
    return np.array(points), np.stack((positions.pinion_roll, gear_roll))


def _in_space(positions: Positions, number: int, pair: int, l: float, z: float) -> FloatArray:
    """Give a point of the pinion's flank of a tooth pair in S_f, mm, at a position."""
    pinion, shift = positions.design.pinion, pitch_shift(positions.design, pair)
    rolls = positions.pinion_roll[number] + shift[0], positions.gear_roll[number] + shift[1]
    own = flank_point(pinion, positions.flank, l, trace_parameter(pinion, positions.flank, l, z))
    return to_fixed(frames_at(positions.design, *rolls)[0], own)


def first_turned(
    positions: Positions, tolerance: float, polish: bool, pinion_roll: float, gear_roll: float
) -> tuple[FloatArray, float]:
    """Give where flanks sampled to `tolerance` (mm) touch first at a pinion roll, by proximity of points of
    either member to the other, and the gear roll to which the gear is turned until the nearest pair of teeth
    touches, rad. Raises ArithmeticError where none does."""
    limit = TURNED_EXACTLY if polish else TURNED * tolerance
    pairs = PAIRS
    for _ in range(TURNS):
        seen = [
            _nearest(positions, tolerance, polish, pinion_roll, gear_roll, pair) for pair in pairs.tolist()
        ]
        turns = np.array([turn for turn, _, _ in seen])
        best = int(turns.argmin())
        if not np.isfinite(turns[best]):
            break
        turn, least, point = seen[best]
        gear_roll += surface_of(positions.design.gear, positions.flank).sigma * turn
        if abs(least) <= limit:
            return point, gear_roll
        pairs = pairs[turns <= turns[best] + 2.0 * NEAR / positions.design.gear.teeth]
    raise ArithmeticError(f"the meshes do not touch within {TURNS} turns of the gear")


def _nearest(
    positions: Positions, tolerance: float, polish: bool, pinion_roll: float, gear_roll: float, pair: int
) -> tuple[float, float, FloatArray]:
    """Give the turn of the gear (rad) until a tooth pair touches, its least separation (mm) and where that
    is; infinite where no point of either flank stands opposite the other.

    Cascade: the points of both members, edges included; polished, the tangency if there is one."""
    design, flank = positions.design, positions.flank
    shift = pitch_shift(design, pair)
    rolls = (pinion_roll + float(shift[0]), gear_roll + float(shift[1]))
    best, point, place = np.inf, np.full(3, np.nan), (np.nan, np.nan)
    for member in range(2):
        found = mesh_separation(
            design, flank, member, tolerance, pinion_roll=rolls[0], gear_roll=rolls[1], polish=polish
        )
        value = np.where(found.status == Status.SOLVED, found.separation, np.inf)
        at = np.unravel_index(value.argmin(), value.shape)
        if value[at] < best:
            on_gear = (found.foot_l, found.foot_z) if member == 0 else (found.l, found.z)
            best, point, place = float(value[at]), found.points[at], (on_gear[0][at], on_gear[1][at])
    if not np.isfinite(best):
        return best, best, point
    if polish:
        tangent = mesh_contact(design, flank, tolerance, pinion_roll=rolls[0], gear_roll=rolls[1])
        if tangent.status == Status.SOLVED and tangent.separation <= best:
            best, point, place = tangent.separation, tangent.point, (tangent.l[1], tangent.z[1])
    own = flank_patch(design.gear, flank, place[0], trace_parameter(design.gear, flank, *place))
    arm = abs(float(own.point[0] * own.normal[1] - own.point[1] * own.normal[0]))
    return best / arm, best, point
