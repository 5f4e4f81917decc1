"""Paths of contact of modified flanks on nearly parallel axes, as series over w1.

There a contact point runs along the face while l1 and l2 hardly change: on parallel axes not at all
(`equation`). Neither of them is a parameter of the path, and F(l1, l2) has large slopes, of the size of
1/sin d. The equations of `regular` do not know of that: at held w1 they are solved by Newton from
what the same flanks have on parallel axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...status import Limit, Status
from ..equation import Pairing
from ..path_polynomial import HEIGHT, WIDTH, PathSeries, by_length, fitted, rows_of
from .equation import at_mid_face, meet_on_parallel, one_rack
from .paths import BASES, on_racks, single_contact
from .regular import meet_regular, onto_held

NEARLY = 0.01
"""Sine of the shaft angle up to which axes are nearly parallel."""
SPARE = 0.1
"""Share of the face by which series reach beyond it."""
FACES = slice(HEIGHT + Limit.PINION_TOE, HEIGHT + len(Limit))
"""Rows of the margins of toe and heel."""


def nearly_parallel(pairing: Pairing) -> NDArray[np.bool_]:
    """Say which cases (cases) have nearly parallel axes and flanks with parabolas."""
    bent = (np.broadcast_to(pairing.rack.parabola, (2, *pairing.branch.shape)) != 0.0).any(axis=(0, 2))
    near = np.asarray(np.abs(pairing.layout.sin_angle) <= NEARLY)[:, 0]
    return np.asarray(bent & near & ~pairing.parallel & ~pairing.undefined)


def series_over_w1(pairing: Pairing) -> PathSeries:
    """Give series over w1 across the whole face: NOT_CONVERGED where there is none, or it is not resolved."""
    status = np.full(len(pairing.branch), np.int8(Status.NOT_CONVERGED))
    y, good = onto_held(pairing, _start(pairing))
    window = window_over_faces(pairing, y)
    at = np.flatnonzero(good[:, 0] & np.isfinite(window.sum(axis=0))[:, 0])
    coefficients = np.zeros((WIDTH, status.size, 2))
    for basis in BASES:
        if at.size == 0:
            break
        part, (first, last) = pairing.cases(at), window[:, at]
        nodes = np.repeat(y[:, at], basis.nodes.size, axis=-1)
        nodes[4] = first + (last - first) * 0.5 * (1.0 + basis.nodes)
        nodes, solved = onto_held(part, nodes)
        rows = rows_of(part, nodes[:2], meet_regular(part, nodes)[1])
        values, told = fitted(part, rows, basis)
        # Off the face at both ends, or the window was too narrow.
        past = (rows[FACES][..., [0, -1]].min(axis=0) < 0.0).all(axis=-1)
        status[at[told & solved.all(axis=-1) & past]] = Status.SOLVED
        more = max(0, values.shape[-1] - coefficients.shape[-1])
        coefficients = np.pad(coefficients, ((0, 0), (0, 0), (0, more)))
        coefficients[:, at, : values.shape[-1]] = values
        at = at[~told]
    return by_length(coefficients, status)


def _start(pairing: Pairing) -> FloatArray:
    """Give y (5, cases, 1) of a contact on parallel axes, at mid-face; of l = 0 where there is none."""
    s, racks = np.zeros((len(pairing.branch), 1)), np.flatnonzero(one_rack(pairing))
    if racks.size:
        s[racks, 0] = np.nan_to_num(single_contact(pairing.cases(racks))[0])
    l = on_racks(pairing, s)
    w = at_mid_face(pairing, l)
    met = meet_on_parallel(pairing, l, w)
    return np.stack((*l, met.normal_x, met.normal_y[0], w))


def window_over_faces(pairing: Pairing, y: FloatArray) -> FloatArray:
    """Give w1 (2, cases, 1), mm, at both ends of the common face of contacts with the other unknowns of y,
    with room beyond."""
    ends = []
    for step in (0.0, 1.0):
        moved = y.copy()
        moved[4] += step
        met = meet_regular(pairing, moved)[1]
        ends.append(met.own[2] * met.along + met.square * met.across - pairing.position)
    rate = ends[1] - ends[0]
    reached = np.sort([(way * pairing.half_width - ends[0]) / rate for way in (-1.0, 1.0)], axis=0)
    low, high = reached[0].max(axis=0), reached[1].min(axis=0)
    room = SPARE * (high - low)
    return np.where(high > low, y[4] + np.array((low - room, high + room)), np.nan)
