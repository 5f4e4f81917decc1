"""Derivatives of contacts of flanks given as surfaces, by the assembly errors.

The equations of `tangency` contain the errors through the position P of the pinion's point in the fixed frame
of the gear: the offset moves it along X2, the shaft angle rotates it about X2, and axial errors move it along
the axis of a member. With the gradients h_i of both equations and their derivatives r_i by an error, a
contact that is fixed by a condition c = 0 moves by d with h_i.d = -r_i and w.d = -c_e, where w and c_e are
the derivatives of c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, Integers
from ...gear.crossing_curve import START
from ...gear.rack import rack_point, rack_tangent
from ...status import Limit
from .paths import SurfacePaths
from .tangency import contacts_at, cross, normals_of, turned_about_gear

L, U, Z, R, ROLLS, PHASE, COUNT = 0, 2, 4, 6, 8, 10, 11
"""Rows of the quantities: l, u, z and r (mm) and rolls (rad) of both members, and the phase (rad): gear
roll plus N1/N2 pinion roll."""
ERRORS = 4


@dataclass(frozen=True, eq=False)
class ErrorRates:
    """Quantities at contacts and their derivatives.

    `value` (COUNT, n); `by_state` (COUNT, 3, n), by s1, z1 and the pinion roll; `by_error` (COUNT, 4, n), by
    the errors at constant s1, z1 and pinion roll, with s2 from the equation of equal radii. `gradient` (2, 3,
    n) and `change` (2, 4, n) are the same derivatives of the two equations G.P_s = 0 and G.P_z = 0.
    """

    value: FloatArray
    by_state: FloatArray
    by_error: FloatArray
    gradient: FloatArray
    change: FloatArray

    @property
    def tangent(self) -> FloatArray:
        """Direction (3, n) of the path in s1, z1 and the pinion roll."""
        return cross(self.gradient[0], self.gradient[1])

    def fixed_by(self, condition_by_state: FloatArray, condition_by_error: FloatArray) -> FloatArray:
        """Return the derivatives (COUNT, 4, n) by the errors of contacts that keep a condition with the
        derivatives `condition_by_state` (3, n) by the state and `condition_by_error` (4, n) by the errors.
        """
        h1, h2 = self.gradient
        across, other, along = cross(h2, condition_by_state), cross(condition_by_state, h1), cross(h1, h2)
        scale = -1.0 / (h1 * across).sum(axis=0)
        moves = (
            self.change[0] * across[:, None]
            + self.change[1] * other[:, None]
            + condition_by_error * along[:, None]
        ) * scale
        return np.asarray((self.by_state[:, :, None] * moves).sum(axis=1) + self.by_error)


def error_rates(path: SurfacePaths, cases: Integers, state: FloatArray, sense: FloatArray) -> ErrorRates:
    """Return quantities and derivatives at contacts.

    Parameters
    ----------
    path : SurfacePaths
        Paths of modified flanks.
    cases : ndarray of int, shape (n,)
        Case of each contact.
    state : ndarray, shape (4, n)
        Contacts.
    sense : ndarray, shape (n,)
        Sign with which a shaft-angle error is added.

    Returns
    -------
    ErrorRates
        Derivatives with respect to the errors in the order of `Errors`.
    """
    problem, placed = path.problem, path.problem.placed.take(cases)
    met = contacts_at(problem.surfaces, placed, state)
    (pinion_jet, gear_jet), count = met.jets, state.shape[1]
    (x, y), (px, py) = met.point[:2], gear_jet.plane[0]
    (sx, sy), (zx, zy) = gear_jet.plane[1:3]
    square = x * x + y * y
    half_square_s, half_square_z = px * sx + py * sy, px * zx + py * zy
    turn_s, turn_z = (px * sy - py * sx) / square, (px * zy - py * zx) / square
    # Derivatives of P, P_s and P_z by the errors (3, 4, n), and of z2.
    moved = np.zeros((3, 3, ERRORS, count))
    for row, vector in enumerate((met.point, met.moves[:, 0], met.moves[:, 1])):
        moved[row, 1, 1], moved[row, 2, 1] = sense * vector[2], -sense * vector[1]
    moved[0, 0, 0], moved[0, 1, 2], moved[0, 2, 2] = 1.0, placed.sin, placed.cos
    high = moved[0, 2].copy()
    high[3] -= 1.0
    # The touched point of the gear, its normal and its roll.
    follow = (x * moved[0, 0] + y * moved[0, 1] - half_square_z * high) / half_square_s
    spin = (x * moved[0, 1] - y * moved[0, 0]) / square - turn_z * high
    normal, by_s, by_z = turned_about_gear(normals_of(gear_jet), met.turn).swapaxes(0, 1)
    side = np.array((-normal[1], normal[0], np.zeros(count)))
    first = met.moves[:, :2]
    change = by_z[:, None] * high + side[:, None] * spin
    rate_by_s2 = (first * (by_s - side * turn_s)[:, None]).sum(axis=0)
    equations = np.stack(
        [
            (change * first[:, k, None]).sum(axis=0)
            + (normal[:, None] * moved[1 + k]).sum(axis=0)
            + rate_by_s2[k] * follow
            for k in (0, 1)
        ]
    )
    # Quantities and their derivatives by the state.
    value, by_state, by_error = (np.zeros((COUNT, *shape, count)) for shape in ((), (3,), (ERRORS,)))
    value[L], value[L + 1], value[Z], value[Z + 1] = state[0], state[3], state[1], met.z2
    by_state[L, 0] = by_state[Z, 1] = by_state[ROLLS, 2] = 1.0
    by_state[L + 1], by_error[L + 1] = met.follow[1:], follow
    by_state[Z + 1], by_error[Z + 1] = met.moves[2], high
    radii = np.hypot(*pinion_jet.plane[0]), np.sqrt(square)
    value[R], value[R + 1] = radii
    by_state[R, :2] = (pinion_jet.plane[0] * pinion_jet.plane[1:3]).sum(axis=1) / radii[0]
    by_state[R + 1] = (x * met.moves[0] + y * met.moves[1]) / radii[1]
    by_error[R + 1] = (x * moved[0, 0] + y * moved[0, 1]) / radii[1]
    for j, rack in enumerate(path.racks):
        rise, steep = rack_tangent(rack, value[L + j])[2], rack.trace[2]
        value[U + j] = (value[Z + j] - rack_point(rack, value[L + j])[2]) / steep
        for by in (by_state, by_error):
            by[U + j] = (by[Z + j] - rise * by[L + j]) / steep
    value[ROLLS], value[ROLLS + 1] = state[2], np.arctan2(*met.turn[::-1]) - gear_jet.phi
    angle_by = (x * met.moves[1] - y * met.moves[0]) / square
    by_state[ROLLS + 1] = angle_by - turn_s * by_state[L + 1] - turn_z * by_state[Z + 1]
    by_error[ROLLS + 1] = spin - turn_s * follow
    for rows in (value, by_state, by_error):
        rows[PHASE] = rows[ROLLS + 1] + problem.surfaces.ratio * rows[ROLLS]
    return ErrorRates(value, by_state, by_error, met.gradient, equations)


def limit_rates(path: SurfacePaths, rates: ErrorRates, limit: Integers) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of the margins of `limit` (n,) by the state (3, n) and by the errors (4, n)."""
    problem, result = path.problem, []
    for by in (rates.by_state, rates.by_error):
        rows = np.empty((len(Limit), *by.shape[1:]))
        for j, edge in enumerate(problem.edges):
            root = by[L + j]
            if edge is not None:
                start, slope = edge.rows(rates.value[Z + j])[START, :2]
                root = root - np.where(start > problem.lowest[j], slope, 0.0) * by[Z + j]
            rows[j::2] = root, problem.taper[j] * by[Z + j] - by[R + j], by[Z + j], -by[Z + j]
        result.append(np.take_along_axis(rows, limit[None, None], axis=0)[0])
    return result[0], result[1]
