"""Flanks on nearly parallel axes that touch nowhere, told without following a curve.

At a given w1 two flanks have a common normal along one curve in (l1, l2): v_1 + v_2 = -n_y sin d but for a
share of sin^2 d, with n_y of the moments about both axes (`regular`). Both sides change steadily with either
l_j, so that the curve runs square to their gradient, nearly straight. F is looked at along it, at both ends
of the common face and between them: where it keeps its sign over a part of the curve, second differences
allowed for, nothing touches there. On conjugate racks, of whose lines an error of the shaft angle makes edge
contacts, that is the usual case, and no curve of contact need be traced far beyond the face.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import COMPLEX_STEP, FloatArray
from ..cells import window_of
from ..equation import Pairing, terms_of
from .nearly import window_over_faces
from .regular import meet_regular, normal_y_at

NODES, SLACK, ROUNDS = 17, 0.5, 8
"""Places along a curve; share of second differences by which a smooth function strays from its values at both
ends of a part, as in `cells`; rounds to a common normal."""
SETTLED, FLOOR = 1e-12, 1e-9
"""Residuals of a common normal, and F as a share of the size of its terms, that count as zero."""
ACROSS = np.array((0.0, 0.5, 1.0))
"""Shares of the common face at which F is looked at."""


def clear_of_flanks(pairing: Pairing) -> NDArray[np.bool_]:
    """Say which cases (cases) of modified flanks on nearly parallel axes are sure to have no contact on them,
    of neither sign of n_x. The caller silences NumPy's warnings."""
    low, high = window_of(pairing)
    sides = terms_of(pairing, low + (high - low) * np.linspace(0.0, 1.0, NODES))
    steps = np.diff(sides.own[2] + pairing.layout.sin_angle / pairing.layout.offset * sides.moment)
    same = (steps > 0.0).all(axis=-1) | (steps < 0.0).all(axis=-1) | (steps == 0.0).all(axis=-1)
    gradient = steps.mean(axis=-1, keepdims=True) / (high - low)
    clear = np.asarray(same.all(axis=0) & (gradient != 0.0).any(axis=(0, 2)))
    for sheet in (1.0, -1.0):
        at = np.flatnonzero(clear)
        part = replace(pairing.cases(at), branch=np.full((at.size, 1), sheet))
        clear[at] = _without_zero(part, gradient[:, at], low[:, at], high[:, at])
    return clear


def _without_zero(
    pairing: Pairing, gradient: FloatArray, low: FloatArray, high: FloatArray
) -> NDArray[np.bool_]:
    """Say of which cases F has no zero on the curve square to a `gradient` (2, cases, 1) between `low` and
    `high` (2, cases, 1), mm."""
    uphill = gradient / np.hypot(*gradient)
    reach = np.hypot(*np.maximum(np.abs(low), np.abs(high)))
    level = np.array((-uphill[1], uphill[0])) * reach * np.linspace(-1.0, 1.0, NODES)
    y, _ = _on_curve(pairing, level, uphill, np.zeros(level.shape[1:]))
    first, last = window_over_faces(pairing, y)
    gap, places, normals = [], [], []
    for share in ACROSS:
        y, settled = _on_curve(pairing, y[:2], uphill, first + share * (last - first))
        gap.append(meet_regular(pairing, y)[1].gap)
        places.append(y[:2])
        normals.append(settled)
    l, value = np.array(places), np.array(gap)
    good = np.asarray(np.array(normals).all(axis=0))
    bend = np.abs(np.diff(value, 2, axis=-1))
    bend = np.concatenate((bend[..., :1], bend, bend[..., -1:]), axis=-1)
    slack = SLACK * (np.maximum(bend[..., 1:], bend[..., :-1]) + np.abs(np.diff(value, 2, axis=0))[..., 1:])
    slack = slack.max(axis=0) + FLOOR * pairing.scale
    least, most = (way(value[..., 1:], value[..., :-1]) for way in (np.minimum, np.maximum))
    kept = (least.min(axis=0) > slack) | (most.max(axis=0) < -slack)
    beyond = np.asarray(((l < low).all(axis=0), (l > high).all(axis=0)))
    off = (beyond[..., 1:] & beyond[..., :-1]).any(axis=(0, 1))
    return np.asarray((off | (kept & good[:, 1:] & good[:, :-1])).all(axis=-1))


def _on_curve(
    pairing: Pairing, l: FloatArray, uphill: FloatArray, w: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give y (5, cases, positions) of `regular`, F apart, from l (2, cases, positions), mm, on along `uphill`
    (2, cases, 1), at w1 (cases, positions), mm; and where the normal is common."""
    n_x = 0.0 * w
    for _ in range(ROUNDS):
        moved = l + COMPLEX_STEP * 1j * uphill
        terms = terms_of(pairing, moved)
        n_y = normal_y_at(pairing, terms, n_x, w)
        v = terms.own[2]
        off = n_y * pairing.layout.sin_angle + v[0] + v[1] - pairing.layout.versed_angle * v[0]
        n_x = pairing.branch * np.sqrt(1.0 - (v[0] * v[0] + n_y * n_y).real)
        l = l - uphill * (COMPLEX_STEP * off.real / off.imag)
    y = np.array((*l, n_x, n_y.real, w))
    return y, np.asarray(np.abs(meet_regular(pairing, y)[0][:3]).max(axis=0) < SETTLED)
