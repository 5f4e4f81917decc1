"""At which edges of the flanks the contact patterns of many mountings end, without the patterns.

A pattern ends at an edge of its own flank where the least separation of a point of that edge, over the
mesh of one tooth pair, is within the marking compound. So only points along the four edges of either flank
are looked at, each near the one roll at which it would touch a conjugate mate,

    n.W = 0,    W = k x X + (N / N') k' x (X - O'),

with X a point of a member's fixed frame, n its outward normal, k its axis, k' and O' the axis of its mate and
a point of that, N and N' the numbers of teeth. Turned by psi this is A cos(psi) + B sin(psi) = C, with
M = P x n of the point P at psi = 0, c its mounting, E and d offset and shaft angle:

    A = sin d (M_y + c n_x) - E cos d n_y,    B = sin d (M_x - c n_y) - E cos d n_x,
    C = -(M_z N' / N + cos d M_z + E sin d n_z).

There the gear has the roll of the first contact of all teeth, and separations at three rolls, by turning
(`operation.separation`), tell where the least is, or where an edge of the mate passes before. The least may
also be where the carrier changes, as the curve of first contacts has a kink there: the next such roll is
looked at too. The roll at which a far edge of the mate passes is only estimated: under errors of a few
tolerances such an end is told as for compound a tenth too thick (at 0.01 mm) or half as thick again (above
0.02 mm), or is missed.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..contact.ellipse import MARKING_SEPARATION
from ..gear.flank import place_at, root_parameter
from ..gear.tooth_side import Cut, cut_at
from ..operation.mesh_cycle import MeshCycle
from ..operation.separation import met_by, seen_by_other, without_turns
from ..status import FirstStatus, Limit

POINTS, CLOSER = 24, 13
"""Points along an edge, and about that of them where the separation is least."""
BESIDE, MOST = 0.005, 0.2
"""Pitches beside the roll of a conjugate mate at which separations tell where the least is, and the furthest
that it is looked for."""
OFF = 0.002
"""Modules by which a roll may miss the mate's edge that was looked for."""


def pattern_ends(cycle: MeshCycle, separation: float = MARKING_SEPARATION) -> Mask:
    """Say at which edges the patterns of a design in many mountings end, for a marking compound as thick as
    the `separation`, mm.

    Parameters
    ----------
    cycle : MeshCycle
        Of the mountings, of any batch shape.
    separation : float

    Returns
    -------
    Mask
        (mountings, 8), in the order of `Limit`; all False where the mesh cycle is not known.

    Raises
    ------
    ValueError
        Where a flank does not reach its tip cone.
    """
    known = np.flatnonzero(cycle.status.reshape(-1) == FirstStatus.SOLVED)
    ends = np.zeros((cycle.status.size, len(Limit) // 2, 2), dtype=bool)
    for member in (0, 1) if known.size else ():
        ends[known, :, member] = _least(cycle, member, known) <= separation
    return ends.reshape(-1, len(Limit))


def _least(cycle: MeshCycle, member: int, known: Integers) -> FloatArray:
    """Give the least separations (cases, 4), mm, along root, tip, toe and heel of a member (0 pinion, 1 gear)
    in the cases with the numbers `known`; infinite where the mate's flank is nowhere opposite."""
    share = np.linspace(0.0, 1.0, POINTS)
    coarse = _least_at(cycle, member, known, np.broadcast_to(share, (1, 4, POINTS)))
    near = share[coarse.argmin(axis=-1), None] + np.linspace(-1.0, 1.0, CLOSER) / (POINTS - 1)
    fine = _least_at(cycle, member, known, np.clip(near, 0.0, 1.0))
    return np.asarray(np.minimum(coarse.min(axis=-1), fine.min(axis=-1)))


def _least_at(cycle: MeshCycle, member: int, known: Integers, along: FloatArray) -> FloatArray:
    """Give the least separations (cases, 4, n), mm, at shares `along` (cases or 1, 4, n) of root and tip from
    the toe, of toe and heel from the root; infinite where the mate's flank is not opposite."""
    mesh, own = cycle.mesh, cycle.design.members[member]
    depth, face = along.copy(), along.copy()
    depth[:, :2], face[:, 2:] = [[0.0], [1.0]], [[0.0], [1.0]]
    l, z, _ = (x.reshape(len(along), -1) for x in place_at(own, cycle.flank, depth, face))
    cut = cut_at((mesh.own, mesh.other)[member], l, z)
    pitch = mesh.pitch[0]
    roll = _conjugate_roll(cycle, member, known, cut, z)
    steps = BESIDE * pitch * np.array([-1.0, 0.0, 1.0])[:, None, None]
    least, margin = _separations(cycle, member, known, cut, z, roll + steps)
    with np.errstate(invalid="ignore", divide="ignore"):
        (rate, bend), (off_rate, off_bend) = _rates(least), _rates(margin)
        step = np.where(bend > 0.0, -rate / bend, 0.0)
        beyond = margin[1] + off_rate * step + 0.5 * off_bend * step**2 < 0.0
        root = np.sqrt(np.maximum(off_rate**2 - 2.0 * margin[1] * off_bend, 0.0))
        edge = -2.0 * margin[1] / (off_rate + np.copysign(root, off_rate))  # of the mate, as it passes
        roll = roll + pitch * np.clip(np.where(beyond, edge, step), -MOST, MOST)
    rolls = np.array((roll, _nearest_change(cycle, known, roll)))
    least, margin = _separations(cycle, member, known, cut, z, rolls)
    least = np.where(margin >= -OFF * mesh.module, least, np.inf).min(axis=0)
    return np.asarray(least.reshape(known.size, *along.shape[1:]))


def _nearest_change(cycle: MeshCycle, known: Integers, roll: FloatArray) -> FloatArray:
    """Give the changes of the carrier nearest to rolls (cases, points), rad; these, if it never changes."""
    pitch, changes = cycle.pitch, cycle.changes.reshape(cycle.status.size, -1)[known]
    nearest, least = roll, np.full(roll.shape, np.inf)
    for change in changes.T[..., None]:
        away = change - roll - pitch * np.round((change - roll) / pitch)
        nearer = np.abs(away) < least
        nearest, least = np.where(nearer, roll + away, nearest), np.where(nearer, np.abs(away), least)
    return nearest


def _rates(values: FloatArray) -> FloatArray:
    """Give first and second derivatives (2, ...) by pitches, of values (3, ...) BESIDE pitches apart."""
    before, here, after = values
    return np.array((0.5 * (after - before) / BESIDE, (before - 2.0 * here + after) / BESIDE**2))


def _conjugate_roll(cycle: MeshCycle, member: int, known: Integers, cut: Cut, z: FloatArray) -> FloatArray:
    """Give the pinion rolls (cases, points), rad, at which points of a member, as the rack cuts them in the
    planes z (cases or 1, points), would touch a conjugate mate, or where they come nearest to that."""
    mesh = cycle.mesh
    pose, teeth = mesh.pose.at(known), [float(each.teeth) for each in cycle.design.members]
    offset, sin, cos = (x[:, None] for x in (pose.offset, pose.sin, pose.cos))
    mounting = pose.position[member, :, None]
    moment = np.cross((cut.x, cut.y, z), np.broadcast_arrays(cut.nx, cut.ny, cut.nz), axis=0)  # M
    by_cos = sin * (moment[1] + mounting * cut.nx) - offset * cos * cut.ny  # A
    by_sin = sin * (moment[0] - mounting * cut.ny) - offset * cos * cut.nx  # B
    ratio = teeth[1 - member] / teeth[member]
    rest = -(moment[2] * (ratio + cos) + offset * sin * cut.nz)  # C
    turn = np.arccos(np.clip(rest / np.hypot(by_cos, by_sin), -1.0, 1.0))
    both = np.arctan2(by_sin, by_cos) - cut.phi + np.stack((turn, -turn))
    start, phase = mesh.roll[known, None], mesh.phase[known, None]
    rate = -mesh.pitch[1] / mesh.pitch[0]
    middle = start if member == 0 else phase + rate * start
    away = without_turns(both - middle)
    own = middle + np.where(np.abs(away[0]) < np.abs(away[1]), away[0], away[1])
    return np.asarray(own if member == 0 else (own - phase) / rate)


def _separations(
    cycle: MeshCycle, member: int, known: Integers, cut: Cut, z: FloatArray, roll: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give separations (n, cases, points), mm, of points of a member from the mating flank at pinion rolls,
    rad, with the gear where the first of all teeth touches; and how far within that flank, mm, they meet
    it."""
    mesh, mate = cycle.mesh, cycle.design.members[1 - member]
    case = np.broadcast_to(known[:, None], roll.shape)
    ahead = cycle.located(case.reshape(-1), roll.reshape(-1), 1)[2][0].reshape(roll.shape)
    gear = mesh.phase[case] - mesh.pitch[1] / mesh.pitch[0] * roll + mesh.other.sigma * ahead / mesh.lever
    own_roll, mate_roll = (roll, gear) if member == 0 else (gear, roll)
    turned = cut.phi + own_roll
    cos, sin = np.cos(turned), np.sin(turned)
    pose, surface = mesh.pose.at(case.reshape(-1)), (mesh.other, mesh.own)[member]
    place = cos * cut.x - sin * cut.y, sin * cut.x + cos * cut.y, np.broadcast_to(z, roll.shape)
    seen = seen_by_other(pose, member, *(x.reshape(-1) for x in place))
    with np.errstate(invalid="ignore", divide="ignore"):
        _, distance, l, at, r = met_by(surface, *seen, mate_roll.reshape(-1))
        margin = np.minimum(surface.half_width - np.abs(at), surface.tip + surface.taper * at - r)
        margin = np.minimum(margin, l - root_parameter(mate))
    return distance.reshape(roll.shape), margin.reshape(roll.shape)
