"""The curve of contact in l1, l2, n_x and w1: regular where one flank parameter is not enough.

F(l1, l2) = 0 (`equation`) holds for one sign of n_x, the x component of the common normal. Where
n_x vanishes both signs join, F has a pole there, and where l1 turns back along the path there are
two l2 for one l1. With n_x and w1 as unknowns of their own neither square root nor pole is left:

    n_x^2 = 1 - v_1^2 - n_y^2,
    n_x w_1 = W_1,
    A_1 + B_1 w_1 + A_2 + B_2 w_2 = E n_x,

where v, n_y, A, B and W_1 (`Meeting.reach`) are explicit in l1 and l2. The point at w_1 on the
line of action has the axial coordinate that w_2 says, which gives w_2 without a division by n_x:

    w_2 = [(cos d + v_1 v_2) w_1 / S_1 - n_x (E v_2 + g_1 sin d / S_1^2)] / S_2.

Three equations in four unknowns are a curve, smooth wherever their Jacobian has full rank: in
approximate line contact too, and whether or not n_x, l1 or the roll angles are monotone along it.

Points of it are z = y / unit, arrays (cases, positions, 4), y = (l1, l2, n_x, w1), so that lengths in z
mean the same in all directions: flank depths, NORMAL_UNIT, and the lesser face width.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..gear.rack import Numbers
from ..pair.frames import common_normal
from ..pair.mounting import across_action, across_of_gear
from .equation import COMPLEX_STEP, Meeting, Pairing, terms_of

NORMAL_UNIT = 0.1
"""n_x changes by some hundredths along a path."""
LAST_STEP = 1e-8
"""Newton ends with a step below it, in z: its square is rounding."""


def units_of(pairing: Pairing) -> FloatArray:
    """Units (cases, 1, 4) of l1, l2 (mm), n_x and w1 (mm)."""
    depth = pairing.highest - pairing.lowest
    face = 2.0 * pairing.half_width.min(axis=0)
    units = np.empty((*pairing.branch.shape, 4))
    units[..., 0], units[..., 1], units[..., 2], units[..., 3] = depth[0], depth[1], NORMAL_UNIT, face
    return units


def meet_on_curve(pairing: Pairing, y: Numbers) -> tuple[Numbers, Meeting]:
    """Residuals (3, cases, positions) of the equations, relative to the sizes of their terms, and
    the terms, at y (4, cases, positions)."""
    layout, (nx, w) = pairing.layout, y[2:]
    terms = terms_of(pairing, y[:2])
    v, square, moment = terms.own[2], terms.square, terms.moment
    normal = common_normal(layout, v)
    reach = across_action(layout, v, square, normal.y, moment)
    across = np.array((w, across_of_gear(layout, v, square, moment, w, nx)))
    along = terms.level + terms.slope * across
    gap = along[0] + along[1] - layout.offset * nx
    size = pairing.scale
    residual = np.array((nx * nx - normal.x_squared, (nx * w - reach[0]) / size, gap / size))
    met = Meeting(
        gap=gap,
        along=along,
        across=across,
        slope=terms.slope,
        reach=reach,
        normal_x=nx,
        normal_y=normal.y,
        square=square,
        moment=moment,
        own=terms.own,
        start=terms.start,
    )
    return residual, met


def linearised(pairing: Pairing, z: FloatArray, units: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (cases, positions, 3) and their derivatives (cases, positions, 3, 4) by z: those by l1 and
    l2 from a complex step, those by n_x and w1 as the equations read."""
    cases, positions, _ = z.shape
    moved = z[:, :, None] + COMPLEX_STEP * 1j * np.eye(2, 4)
    y = np.moveaxis(moved * units[:, :, None], -1, 0).reshape(4, cases, 2 * positions)
    residual, met = meet_on_curve(pairing, y)
    residual = residual.reshape(3, cases, positions, 2)
    jacobian = np.zeros((3, cases, positions, 4))
    jacobian[..., :2] = residual.imag / COMPLEX_STEP
    v, square, moment, slope = (x[..., ::2].real for x in (met.own[2], met.square, met.moment, met.slope))
    nx, w = y[2:, :, ::2].real
    by_nx, by_w = (
        across_of_gear(pairing.layout, v, square, moment, *one) for one in ((0.0, 1.0), (1.0, 0.0))
    )
    size = pairing.scale
    jacobian[0, ..., 2] = 2.0 * nx
    jacobian[1, ..., 2], jacobian[1, ..., 3] = w / size, nx / size
    jacobian[2, ..., 2] = (slope[1] * by_nx - pairing.layout.offset) / size
    jacobian[2, ..., 3] = (slope[0] + slope[1] * by_w) / size
    jacobian[..., 2:] *= units[..., 2:]
    return np.moveaxis(residual[..., 0].real, 0, -1), np.moveaxis(jacobian, 0, -2)


def direction_of(jacobian: FloatArray) -> FloatArray:
    """Unit tangents (..., 4) of the curve, of either sense, by the cofactors of the Jacobian."""
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
    pairing: Pairing, start: FloatArray, normal: FloatArray, units: FloatArray, passes: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Where the curve crosses planes: Newton from `start` (cases, positions, 4) in the planes through
    it that are square to `normal`. Returns points and which of them are solved to rounding."""
    z, last = start, np.full(start.shape[:-1], np.inf)
    for _ in range(passes):
        residual, jacobian = linearised(pairing, z, units)
        system = np.concatenate((jacobian, normal[..., None, :]), axis=-2)
        out = np.einsum("...i,...i", normal, z - start)
        right = np.concatenate((residual, out[..., None]), axis=-1)
        step = _solved(system, right)
        z, last = z - step, np.abs(step).max(axis=-1)
        if not (last > LAST_STEP).any():
            break
    return z, last <= LAST_STEP


def _solved(system: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (..., 4) of linear systems, NaN where there is none."""
    lost = ~(np.isfinite(system).all(axis=(-1, -2)) & np.isfinite(right).all(axis=-1))
    system[lost], right[lost] = np.eye(4), np.nan
    try:
        return np.asarray(np.linalg.solve(system, right[..., None])[..., 0])
    except np.linalg.LinAlgError:  # to the last digit; the others must not depend on it
        singular = np.linalg.det(system) == 0.0
        system[singular], right[singular] = np.eye(4), np.nan
        return np.asarray(np.linalg.solve(system, right[..., None])[..., 0])
