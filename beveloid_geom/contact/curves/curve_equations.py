"""The curve of contact in l1, l2, n_x and w1: regular where one flank parameter is not sufficient.

F(l1, l2) = 0 (`equation`) holds for one sign of n_x, the x component of the common normal. Where n_x
vanishes, both solution branches join and F has a pole. Where l1 turns back along the path, one l1 has two l2.
With n_x and w1 as additional unknowns, square root and pole disappear:

    n_x^2 = 1 - v_1^2 - n_y^2,
    n_x w_1 = W_1,
    A_1 + B_1 w_1 + A_2 + B_2 w_2 = E n_x,

where v, n_y, A, B and W_1 (`Gap.reach`) are explicit in l1 and l2. w_2 follows from the axial
coordinate of the point at w_1 on the line of action, without a division by n_x:

    w_2 = [(cos d + v_1 v_2) w_1 / S_1 - n_x (E v_2 + g_1 sin d / S_1^2)] / S_2.

Three equations in four unknowns define a curve. It is smooth wherever their Jacobian has full rank: also in
approximate line contact, and whether or not n_x, l1 or the roll angles are monotone along it.

Derivatives by l1 and l2 are analytic; a complex step gives the same to rounding, at four times the cost.

Points of the curve are z = y / unit, arrays (cases, positions, 4), with y = (l1, l2, n_x, w1). The units are
the flank depths, NORMAL_UNIT, and the narrower face width, so that all components of z have similar sizes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ...arrays import FloatArray, Mask
from ...gear.rack import Numbers, Rack, rack_tangent, turn_rate
from ...pair.frames import Layout, common_normal
from ...pair.mounting import across_action
from ..equation import ContactTerms, meeting_at
from ..flank_pair import FlankPair, MemberTerms, terms_of

NORMAL_UNIT = 0.1
"""Unit of n_x, which changes by some hundredths along a path."""
LAST_STEP = 1e-8
"""Newton step in z below which the iteration ends: its square is rounding."""


def units_of(pairing: FlankPair) -> FloatArray:
    """Return units (cases, 1, 4) of l1, l2 (mm), n_x and w1 (mm)."""
    depth = pairing.highest - pairing.lowest
    face = 2.0 * pairing.half_width.min(axis=0)
    units = np.empty((*pairing.branch.shape, 4))
    units[..., 0], units[..., 1], units[..., 2], units[..., 3] = depth[0], depth[1], NORMAL_UNIT, face
    return units


def meet_on_curve(pairing: FlankPair, y: Numbers) -> tuple[Numbers, ContactTerms]:
    """Return residuals (3, cases, positions) of the equations, relative to the sizes of their terms, and the
    terms, at y (4, cases, positions).
    """
    layout, (nx, w) = pairing.layout, y[2:]
    terms = terms_of(pairing, y[:2])
    v = terms.normal[2]
    normal = common_normal(layout, v)
    reach = across_action(layout, v, terms.square, normal, terms.moment)
    met, size = meeting_at(pairing, terms, w, nx, normal.y), pairing.scale
    residual = np.array((nx * nx - normal.x_squared, (nx * w - reach[0]) / size, met.gap / size))
    return residual, met


def term_rates(rack: Rack, position: FloatArray, l: FloatArray, terms: MemberTerms) -> MemberTerms:
    """Return the derivatives of the `terms` of members by their flank parameters, of the same shapes."""
    # Derivatives of the normal, then of S, xi, B (slope) and A (level) by the product rule.
    tangent = rack_tangent(rack, l)
    normal_by = tangent * turn_rate(rack, l)
    turn = 2.0 * rack.parabola * rack.normal
    (nx, ny, v), (nx_by, ny_by, v_by) = terms.normal, normal_by
    square_by = -v * v_by / terms.square
    ratio = terms.square / nx
    ratio_by = (square_by - ratio * nx_by) / nx
    xi = rack.pitch_radius / ratio + terms.start[0] * ratio
    xi_by = (terms.start[0] - rack.pitch_radius / (ratio * ratio)) * ratio_by + tangent[0] * ratio
    flat_by = square_by * tangent[1] + terms.square * turn[1]
    slope_by = ny_by * tangent[2] + ny * turn[2] - terms.slope * flat_by
    slope_by = slope_by / (terms.square * tangent[1])
    z, z_by = terms.start[2] + position, tangent[2]
    level_by = square_by * xi + terms.square * xi_by + v_by * z + v * z_by
    level_by += slope_by * (v * xi - terms.square * z)
    level_by += terms.slope * (v_by * xi + v * xi_by - square_by * z - terms.square * z_by)
    return MemberTerms(normal_by, tangent, square_by, rack.pitch_radius * ny_by, level_by, slope_by)


@dataclass(frozen=True, eq=False)
class ActionRates:
    """Terms of w_2, and derivatives by the flank parameter of one member.

    `x_squared_by` and `first_by` are the derivatives of n_x^2 and of n_x w_1. `shared_by` and `side_by` are
    the derivatives of `shared` and `side`, from which w_2 follows:

        S_2 w_2 = shared w_1 - n_x side,
        shared = (cos d + v_1 v_2) / S_1,   side = E v_2 + g_1 sin d / S_1^2

    (`pair.mounting.across_action`).
    """

    x_squared_by: FloatArray
    first_by: FloatArray
    shared: FloatArray
    shared_by: FloatArray
    side: FloatArray
    side_by: FloatArray


def action_rates(layout: Layout, met: ContactTerms, rate: MemberTerms, member: int) -> ActionRates:
    """Return derivatives by the l of `member`, whose terms have the derivatives `rate`."""
    (v_1, v_2), v_by, normal_y = met.normal[2], rate.normal[2], met.normal_y
    square, moment, sin = met.square[0], met.moment[0], layout.sin_angle
    # n_y of both members by this l.
    y_by = [-v_by / sin * (layout.cos_angle if k == member else 1.0) for k in range(2)]
    shared, shared_by = layout.cos_angle + v_1 * v_2, (v_1 if member else v_2) * v_by
    x_squared_by = -2.0 * normal_y[0] * y_by[0]
    first_by = -layout.offset * square * y_by[1] + moment / square * shared_by
    ratio, ratio_by = shared / square, shared_by / square
    # Other terms: l2 changes g_2 and v_2; l1 changes S_1, g_1 and v_1.
    if member:
        first_by = first_by + square * rate.moment
        side_by = layout.offset * v_by
    else:
        seen = met.moment[1] - layout.offset * normal_y[1]
        arm_by = (rate.moment - moment * rate.square / square) / square
        x_squared_by = x_squared_by - 2.0 * v_1 * v_by
        first_by = first_by + rate.square * seen + arm_by * shared
        ratio_by = ratio_by - ratio * rate.square / square
        side_by = (arm_by - moment * rate.square / (square * square)) * sin / square
    side = layout.offset * v_2 + moment / (square * square) * sin
    return ActionRates(x_squared_by, -first_by / sin, ratio, ratio_by, side, side_by)


def linearised(pairing: FlankPair, z: FloatArray, units: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals (cases, positions, 3) and their derivatives (cases, positions, 3, 4) by z."""
    # Contiguous: arrays with another memory order take several times as long below.
    y = np.ascontiguousarray(np.moveaxis(z * units, -1, 0))
    (nx, w), layout, size = y[2:], pairing.layout, pairing.scale
    residual, met = meet_on_curve(pairing, y)
    rates = term_rates(pairing.rack, pairing.position, y[:2], met)
    # The positions of each entry are contiguous in memory.
    jacobian = np.zeros((3, 4, *z.shape[:-1]))
    # Columns of l1 and l2: derivatives of the three residuals.
    for member in range(2):
        rate = rates.of(member)
        by = action_rates(layout, met, rate, member)
        gear_by = by.shared_by * w - nx * by.side_by
        if member:
            gear_by = gear_by - met.across[1] * rate.square
        gear_by = met.slope[1] * gear_by / met.square[1]
        jacobian[0, member] = -by.x_squared_by
        jacobian[1, member] = -by.first_by / size
        jacobian[2, member] = (rate.level + rate.slope * met.across[member] + gear_by) / size
    # Columns of n_x and w1.
    lever = met.slope[1] / met.square[1]
    jacobian[0, 2] = 2.0 * nx
    jacobian[1, 2], jacobian[1, 3] = w / size, nx / size
    jacobian[2, 2] = -(lever * by.side + layout.offset) / size
    jacobian[2, 3] = (met.slope[0] + lever * by.shared) / size
    jacobian *= np.moveaxis(units, -1, 0)
    return np.moveaxis(residual, 0, -1), np.moveaxis(jacobian, (0, 1), (-2, -1))


def direction_of(jacobian: FloatArray) -> FloatArray:
    """Return unit tangents (..., 4) of the curve, in either direction, by the cofactors of the Jacobian."""
    a, b, c = jacobian[..., 0, :], jacobian[..., 1, :], jacobian[..., 2, :]
    tangent = np.empty(a.shape)
    for k in range(4):
        i, j, m = (n for n in range(4) if n != k)
        minor = (
            a[..., i] * (b[..., j] * c[..., m] - b[..., m] * c[..., j])
            - a[..., j] * (b[..., i] * c[..., m] - b[..., m] * c[..., i])
            + a[..., m] * (b[..., i] * c[..., j] - b[..., j] * c[..., i])
        )
        tangent[..., k] = -minor if k % 2 else minor
    return np.asarray(tangent / np.linalg.norm(tangent, axis=-1, keepdims=True))


def onto_curve(
    pairing: FlankPair, start: FloatArray, normal: FloatArray, units: FloatArray, passes: int
) -> tuple[FloatArray, Mask]:
    """Return where the curve crosses planes, and which points are solved to rounding.

    At most `passes` steps of Newton's method from `start` (cases, positions, 4), in the planes through it
    that are perpendicular to `normal`.
    """
    z, last, names = start.copy(), np.full(start.shape[:-1], np.inf), np.arange(len(start))
    for _ in range(passes):
        residual, jacobian = linearised(pairing, z[names], units)
        across = normal[names]
        out = np.einsum("...i,...i", across, z[names] - start[names])
        rows = [*np.moveaxis(jacobian, -2, 0), across]
        step = _solved(rows, [*np.moveaxis(residual, -1, 0), out])
        z[names] -= step
        last[names] = np.abs(step).max(axis=-1)
        # Continue with the unsolved cases only.
        left = np.flatnonzero((last[names] > LAST_STEP).any(axis=-1))
        if left.size == 0:
            break
        if left.size < names.size:
            pairing, units, names = pairing.cases(left), units[left], names[left]
    return z, last <= LAST_STEP


def _solved(rows: list[FloatArray], right: list[FloatArray]) -> FloatArray:
    """Return solutions (..., 4) of four equations, `rows` (..., 4) and `right` (...), NaN where there is
    none.

    Minors of two rows are used: exact enough for a Newton step, and much faster than a general solver.
    """
    columns = [[row[..., k] for row in rows] for k in range(4)] + [right]
    upper, lower = (
        {
            (i, j): columns[i][k] * columns[j][k + 1] - columns[j][k] * columns[i][k + 1]
            for i, j in combinations(range(5), 2)
        }
        for k in (0, 2)
    )

    def determinant(i: int, j: int, k: int, m: int) -> FloatArray:
        value = upper[i, j] * lower[k, m] - upper[i, k] * lower[j, m] + upper[i, m] * lower[j, k]
        value += upper[j, k] * lower[i, m] - upper[j, m] * lower[i, k] + upper[k, m] * lower[i, j]
        return np.asarray(value)

    total, step = determinant(0, 1, 2, 3), np.empty(rows[0].shape)
    total[total == 0.0] = np.nan
    for k in range(4):
        others = [column for column in range(5) if column != k]
        step[..., k] = (determinant(*others) if k % 2 else -determinant(*others)) / total
    step[~np.isfinite(step).all(axis=-1)] = np.nan
    return step
