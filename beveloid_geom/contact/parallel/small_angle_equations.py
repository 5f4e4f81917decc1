"""The curve of contact in l1, l2, n_x, n_y and w1: regular for every shaft angle, also on parallel axes.

n_y is an additional unknown here; `curves.curve_equations` computes it by a division by sin d. The equations
are

    n_x^2 + n_y^2 = 1 - v_1^2,
    n_y sin d = 2 v_1 sin^2(d/2) - (v_1 + v_2),
    n_x w_1 sin d = -[S_1 (g_2 - E n_y2) + g_1 (cos d + v_1 v_2)/S_1],   n_y2 = n_y + tan(d/2) (v_2 - v_1),
    A_1 + B_1 w_1 + A_2 + B_2 w_2 = E n_x,

derived as in `equation` and `pair.mounting.across_action`. On parallel axes the second and the third one are
v_1 + v_2 = 0 and E n_y = g_1 + g_2. Points are y = (l1, l2, n_x, n_y, w1), arrays (5, cases, positions),
which may be complex for derivatives.
"""

from __future__ import annotations

import numpy as np

from ...arrays import COMPLEX_STEP, FloatArray, Mask
from ...gear.rack import Numbers
from ..curves.curve_equations import LAST_STEP, NORMAL_UNIT, units_of
from ..equation import ContactTerms, meeting_at
from ..flank_pair import FlankPair, MemberTerms, terms_of

UNKNOWN_COUNT = 5


def units_of_all(pairing: FlankPair) -> FloatArray:
    """Return units (5, cases, 1) of l1, l2 (mm), n_x, n_y and w1 (mm)."""
    four = np.moveaxis(units_of(pairing), -1, 0)
    return np.stack((*four[:3], np.full_like(four[0], NORMAL_UNIT), four[3]))


def meet_regular(pairing: FlankPair, y: Numbers) -> tuple[Numbers, ContactTerms]:
    """Return residuals (4, cases, positions) of the equations, relative to the sizes of their terms, and the
    terms, at y.
    """
    layout, (nx, ny, w) = pairing.layout, y[2:]
    terms, size = terms_of(pairing, y[:2]), pairing.scale
    v, square, moment = terms.normal[2], terms.square, terms.moment
    sin, cos = layout.sin_angle, layout.cos_angle
    gear_y = ny + sin / (1.0 + cos) * (v[1] - v[0])
    met = meeting_at(pairing, terms, w, nx, np.array((ny, gear_y)))
    seen = square[0] * (moment[1] - layout.offset * gear_y) + moment[0] / square[0] * (cos + v[0] * v[1])
    residual = np.array(
        (
            nx * nx + ny * ny + v[0] * v[0] - 1.0,
            ny * sin + v[0] + v[1] - layout.versed_angle * v[0],
            (nx * w * sin + seen) / size,
            met.gap / size,
        )
    )
    return residual, met


def normal_y_at(pairing: FlankPair, terms: MemberTerms, normal_x: Numbers, w: Numbers) -> Numbers:
    """Return n_y (cases, positions) from the third equation at n_x and w1 (cases, positions), mm."""
    layout, v, (s1, _), (g1, g2) = pairing.layout, terms.normal[2], terms.square, terms.moment
    reach = normal_x * w * layout.sin_angle + g1 / s1 * (layout.cos_angle + v[0] * v[1])
    gear_y = (g2 + reach / s1) / layout.offset
    return np.asarray(gear_y - layout.sin_angle / (1.0 + layout.cos_angle) * (v[1] - v[0]))


def point_on_curve(point: FloatArray, normal: FloatArray, l1: FloatArray, l2: FloatArray) -> FloatArray:
    """Return y of contacts at points (..., 3), mm, with common normals (..., 3) in S_f."""
    v = normal[..., 2]
    # w1 is the coordinate of the point along (k1 - v1 n) / S1.
    across = (point[..., 2] - v * np.einsum("...i,...i", point, normal)) / np.sqrt(1.0 - v * v)
    return np.stack((l1, l2, normal[..., 0], normal[..., 1], across))


def regular_jacobian(pairing: FlankPair, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals (cases, positions, 4) at y and their derivatives (cases, positions, 4, 5) by y in its
    units.
    """
    units, shape = units_of_all(pairing), y.shape
    steps = COMPLEX_STEP * 1j * np.eye(UNKNOWN_COUNT)[:, None, None, :]
    moved = (y[..., None] + steps * units[..., None]).reshape(UNKNOWN_COUNT, shape[1], -1)
    residual = meet_regular(pairing, moved)[0].reshape(4, *shape[1:], UNKNOWN_COUNT)
    return np.moveaxis(residual[..., 0].real, 0, -1), np.moveaxis(residual.imag, 0, -2) / COMPLEX_STEP


def tangent_of(jacobian: FloatArray, held: Mask | None = None) -> FloatArray:
    """Return unit tangents (..., 5) of the curve, in either direction, from derivatives (..., 4, 5).

    Where `held` (...), along contact lines, the tangents are those of constant w1. NaN where derivatives are
    NaN.
    """
    rows = np.zeros((*jacobian.shape[:-2], UNKNOWN_COUNT, UNKNOWN_COUNT))
    rows[..., :4, :] = jacobian
    if held is not None:
        rows[..., 4, 4] = held
    lost = np.asarray(~np.isfinite(rows).all(axis=(-1, -2)))
    rows[lost] = 0.0
    tangent = np.linalg.svd(rows)[2][..., -1, :]
    return np.where(lost[..., None], np.nan, tangent)


def onto_held(pairing: FlankPair, y: FloatArray) -> tuple[FloatArray, Mask]:
    """Return y (5, cases, positions) with l1, l2, n_x and n_y solved at constant w1 by Newton's method from
    y, and which positions (cases, positions) are solved.
    """
    units, y, last = units_of_all(pairing)[:4], y.copy(), np.full(y.shape[1:], np.inf)
    for _ in range(30):
        residual, jacobian = regular_jacobian(pairing, y)
        # Positions that are singular or NaN get the unit matrix and end as NaN.
        system = jacobian[..., :4]
        lost: Mask = np.asarray(~np.isfinite(system.sum(axis=(-1, -2)) + residual.sum(axis=-1)))
        system[lost] = np.eye(4)
        lost |= np.linalg.det(system) == 0.0
        system[lost], residual[lost] = np.eye(4), np.nan
        step = np.linalg.solve(system, residual[..., None])[..., 0]
        y[:4] -= np.moveaxis(step, -1, 0) * units
        last = np.abs(step).max(axis=-1)
        if not (last > LAST_STEP).any():
            break
    return y, last <= LAST_STEP
