"""Bound that proves that flanks on nearly parallel axes have no contact, without tracing a curve.

At a given w1 two flanks have a common normal along one curve in (l1, l2): v_1 + v_2 = -n_y sin d except for
terms of order sin^2 d, with n_y from the moments about both axes (`small_angle_equations`). The difference of
both sides must be monotone in l1 and in l2; otherwise the case is not decided. The curve is then nearly
straight and perpendicular to the mean gradient of this difference. F is evaluated along this curve, at both
ends of the common face and between them. If F keeps its sign over a part of the curve, with second
differences as a safety margin, there is no contact in this part. This is the usual case for conjugate racks,
whose line contact becomes edge contact under a shaft-angle error, and avoids tracing curves far beyond the
face.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import COMPLEX_STEP, FloatArray, Mask
from ..curves.root_exclusion import window_of
from ..flank_pair import FlankPair, terms_of
from .small_angle_equations import meet_regular, normal_y_at
from .small_angle_paths import window_over_faces

CURVE_POINTS = 17
"""Number of points along a curve."""


def clear_of_flanks(pairing: FlankPair) -> Mask:
    """Return which cases (cases) of flanks with parabolas on nearly parallel axes certainly have no contact
    on the flanks, for both signs of n_x. The caller silences NumPy's warnings.
    """
    low, high = window_of(pairing)
    sides = terms_of(pairing, low + (high - low) * np.linspace(0.0, 1.0, CURVE_POINTS))
    # The condition of the common normal must be monotone in both l_j.
    steps = np.diff(sides.normal[2] + pairing.layout.sin_angle / pairing.layout.offset * sides.moment)
    same = (steps > 0.0).all(axis=-1) | (steps < 0.0).all(axis=-1) | (steps == 0.0).all(axis=-1)
    gradient = steps.mean(axis=-1, keepdims=True) / (high - low)
    clear = np.asarray(same.all(axis=0) & (gradient != 0.0).any(axis=(0, 2)))
    # Exclude both signs of n_x.
    for sheet in (1.0, -1.0):
        at = np.flatnonzero(clear)
        part = replace(pairing.cases(at), branch=np.full((at.size, 1), sheet))
        clear[at] = _without_zero(part, gradient[:, at], low[:, at], high[:, at])
    return clear


def _without_zero(pairing: FlankPair, gradient: FloatArray, low: FloatArray, high: FloatArray) -> Mask:
    """Return for which cases F has no zero on the curve perpendicular to a `gradient` (2, cases, 1) between
    `low` and `high` (2, cases, 1), mm.
    """
    # Sample the curve across the window, perpendicular to the gradient.
    uphill = gradient / np.hypot(*gradient)
    reach = np.hypot(*np.maximum(np.abs(low), np.abs(high)))
    level = np.array((-uphill[1], uphill[0])) * reach * np.linspace(-1.0, 1.0, CURVE_POINTS)
    y, _ = _on_curve(pairing, level, uphill, np.zeros(level.shape[1:]))
    first, last = window_over_faces(pairing, y)
    gap, places, normals = [], [], []
    for share in (0.0, 0.5, 1.0):
        y, settled = _on_curve(pairing, y[:2], uphill, first + share * (last - first))
        gap.append(meet_regular(pairing, y)[1].gap)
        places.append(y[:2])
        normals.append(settled)
    l, value = np.array(places), np.array(gap)
    good = np.asarray(np.array(normals).all(axis=0))
    # Bound the deviation between samples by second differences along the curve and across the face.
    bend = np.abs(np.diff(value, 2, axis=-1))
    bend = np.concatenate((bend[..., :1], bend, bend[..., -1:]), axis=-1)
    # Multiple of the second differences by which a smooth function may deviate from its end values, as in
    # `root_exclusion`.
    second_difference_factor = 0.5
    slack = second_difference_factor * (
        np.maximum(bend[..., 1:], bend[..., :-1]) + np.abs(np.diff(value, 2, axis=0))[..., 1:]
    )
    # F relative to the size of its terms that is treated as zero.
    relative_gap_floor = 1e-9
    slack = slack.max(axis=0) + relative_gap_floor * pairing.scale
    least, most = (extreme(value[..., 1:], value[..., :-1]) for extreme in (np.minimum, np.maximum))
    keeps_sign = (least.min(axis=0) > slack) | (most.max(axis=0) < -slack)
    # Parts outside the window of l1 or l2 need no bound.
    beyond = np.asarray(((l < low).all(axis=0), (l > high).all(axis=0)))
    off = (beyond[..., 1:] & beyond[..., :-1]).any(axis=(0, 1))
    return np.asarray((off | (keeps_sign & good[:, 1:] & good[:, :-1])).all(axis=-1))


def _on_curve(
    pairing: FlankPair, l: FloatArray, uphill: FloatArray, w: FloatArray
) -> tuple[FloatArray, Mask]:
    """Return points y (5, cases, positions) that satisfy the `small_angle_equations` other than F = 0, and
    which of them have a common normal.

    The search starts at l (2, cases, positions), mm, in the direction `uphill` (2, cases, 1), at w1 (cases,
    positions), mm.
    """
    n_x = 0.0 * w
    for _ in range(8):
        moved = l + COMPLEX_STEP * 1j * uphill
        terms = terms_of(pairing, moved)
        n_y = normal_y_at(pairing, terms, n_x, w)
        v = terms.normal[2]
        off = n_y * pairing.layout.sin_angle + v[0] + v[1] - pairing.layout.versed_angle * v[0]
        n_x = pairing.branch * np.sqrt(1.0 - (v[0] * v[0] + n_y * n_y).real)
        l = l - uphill * (COMPLEX_STEP * off.real / off.imag)
    y = np.array((*l, n_x, n_y.real, w))
    # Residual of a common normal that is treated as zero.
    residual_tolerance = 1e-12
    return y, np.asarray(np.abs(meet_regular(pairing, y)[0][:3]).max(axis=0) < residual_tolerance)
