"""Paths of contact of flanks with parabolas on nearly parallel axes, as series over w1.

A contact point moves along the face there while l1 and l2 hardly change; on parallel axes they are constant
(`equation`). Neither is a parameter of the path, and F(l1, l2) has large slopes, proportional to 1/sin d. The
equations of `small_angle_equations` are regular. At constant w1 they are solved by Newton's method, starting
from the contact of the same flanks on parallel axes.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Mask
from ...status import Limit, Status
from ..flank_pair import FlankPair
from ..path_polynomial import FULL_ROW_COUNT, ROW_COUNT, PathSeries, fitted_series, not_over_l1, rows_of
from .equation import at_mid_face, meet_on_parallel, one_rack
from .paths import SERIES_BASES, on_racks, single_contact
from .small_angle_equations import meet_regular, onto_held, regular_jacobian

NEARLY_PARALLEL_SINE = 0.01
"""Sine of the shaft angle up to which axes are nearly parallel."""


def nearly_parallel(pairing: FlankPair) -> Mask:
    """Return which cases (cases) have nearly parallel axes and flanks with parabolas."""
    near = np.asarray(np.abs(pairing.layout.sin_angle) <= NEARLY_PARALLEL_SINE)[:, 0]
    return np.asarray(~pairing.without_parabola & near & ~pairing.parallel & ~pairing.undefined)


def series_over_w1(pairing: FlankPair) -> PathSeries:
    """Return series over w1 across the entire face; NOT_CONVERGED if there is none, or it is not resolved."""
    # Upper bound of the rounding of series over w1, relative to the flank depth.
    max_rounding_depths = 1e-7
    status = np.full(len(pairing.branch), np.int8(Status.NOT_CONVERGED))
    # Start from the contact on parallel axes; the window in w1 covers the common face.
    y, good = onto_held(pairing, _start(pairing))
    window = window_over_faces(pairing, y)
    at = np.flatnonzero(good[:, 0] & np.isfinite(window.sum(axis=0))[:, 0])
    coefficients, loosened = np.zeros((FULL_ROW_COUNT, status.size, 2)), np.ones(status.size)
    if at.size:
        loosened[at] = _rounding_factor(pairing.cases(at), y[:, at])
    # Rows of the margins of toe and heel.
    face_limit_rows = slice(ROW_COUNT + Limit.PINION_TOE, ROW_COUNT + len(Limit))
    for basis in SERIES_BASES:
        if at.size == 0:
            break
        part, (first, last) = pairing.cases(at), window[:, at]
        nodes = np.repeat(y[:, at], basis.nodes.size, axis=-1)
        nodes[4] = first + (last - first) * 0.5 * (1.0 + basis.nodes)
        nodes, solved = onto_held(part, nodes)
        rows = rows_of(part, nodes[:2], meet_regular(part, nodes)[1])
        values, resolved = fitted_series(part, rows, basis, loosened[at], max_rounding_depths)
        # The series must leave the face at both ends; otherwise the window was too narrow.
        past = (rows[face_limit_rows][..., [0, -1]].min(axis=0) < 0.0).all(axis=-1)
        status[at[resolved & solved.all(axis=-1) & past]] = Status.SOLVED
        more = max(0, values.shape[-1] - coefficients.shape[-1])
        coefficients = np.pad(coefficients, ((0, 0), (0, 0), (0, more)))
        coefficients[:, at, : values.shape[-1]] = values
        at = at[~resolved]
    return not_over_l1(coefficients, status)


def _rounding_factor(pairing: FlankPair, y: FloatArray) -> FloatArray:
    """Return the factor (cases,), at least 1, by which rounding errors of l1 and l2 exceed those of F.

    Weak parabolas hardly fix the contact across the face: the equations at constant w1 are nearly singular,
    and their least singular value amplifies rounding.
    """
    # Rounding of series, relative to the bound by the least singular value; at most 0.034 was observed.
    rounding_per_bound = 0.1
    least = np.linalg.svd(regular_jacobian(pairing, y)[1][..., 0, :, :4], compute_uv=False)[..., -1]
    depth = (pairing.highest - pairing.lowest).max(axis=0)[:, 0]
    with np.errstate(divide="ignore"):
        return np.asarray(np.maximum(1.0, rounding_per_bound * depth / (least * pairing.scale[:, 0])))


def _start(pairing: FlankPair) -> FloatArray:
    """Return y (5, cases, 1) of a contact on parallel axes, at mid-face; with l = 0 if there is none."""
    s, racks = np.zeros((len(pairing.branch), 1)), np.flatnonzero(one_rack(pairing))
    if racks.size:
        s[racks, 0] = np.nan_to_num(single_contact(pairing.cases(racks))[0])
    l = on_racks(pairing, s)
    w = at_mid_face(pairing, l)
    met = meet_on_parallel(pairing, l, w)
    return np.stack((*l, met.normal_x, met.normal_y[0], w))


def window_over_faces(pairing: FlankPair, y: FloatArray) -> FloatArray:
    """Return w1 (2, cases, 1), mm, at both ends of the common face for contacts with the other unknowns of y,
    with a margin.
    """
    # Fraction of the face by which series reach beyond it.
    face_margin = 0.1
    ends = []
    for step in (0.0, 1.0):
        moved = y.copy()
        moved[4] += step
        met = meet_regular(pairing, moved)[1]
        ends.append(met.normal[2] * met.along + met.square * met.across - pairing.position)
    rate = ends[1] - ends[0]
    reached = np.sort([(sense * pairing.half_width - ends[0]) / rate for sense in (-1.0, 1.0)], axis=0)
    low, high = reached[0].max(axis=0), reached[1].min(axis=0)
    widening = face_margin * (high - low)
    return np.where(high > low, y[4] + np.array((low - widening, high + widening)), np.nan)
