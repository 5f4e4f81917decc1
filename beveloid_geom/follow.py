"""Tracks of paths that no single flank parameter describes, followed by their length.

`track_of` gives the polynomials over l1 wherever they resolve the path. For the rest, paths that
cross n_x = 0, on which l1 turns back, or that leave the window where no common normal is left, all
curves of contact in the window are walked (`walk`), their parts near the flanks fitted by
polynomials, and the part on the flanks that covers most roll is the path.

The parameter of such a part is no true length: a polynomial through the walked points is its guide,
and the point with parameter x is where the curve crosses the plane square to the guide at x. That is
as smooth as the curve, and needs no integral.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from .contact import Pairing, axial_and_radius, limit_margins
from .curve import basis_of
from .ends import find_ends
from .inputs import FloatArray
from .solve import Status
from .track import LARGEST, WIDTH, Track, fitted, rows_of, track_over_l1
from .unfolded import meet_on_curve, onto_curve, units_of
from .walk import LONGEST, Walked, curves_of

GUIDE = 12
"""Highest degree of a guide."""
BASES = tuple(basis_of(degree) for degree in (40, 100, 200, LARGEST))
PASSES = 8
OUTSIDE = 0.5
"""Half face widths beyond toe and heel to which a part reaches."""
SPARE = 0.1
"""Depths, or face widths, by which a limit must be missed all along for a part to count as off."""


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a walked curve near the flanks: its case, z (points, 4), and whether it closes on
    itself without meeting a limit."""

    case: int
    points: FloatArray
    endless: bool


def track_of(pairing: Pairing) -> Track:
    """The track of every case; of several paths on the flanks the one that covers most roll."""
    track = track_over_l1(pairing)
    lost = np.flatnonzero(track.status)  # SOLVED is 0
    return track if lost.size == 0 else track.merged(_followed(pairing.cases(lost)), lost)


def _followed(pairing: Pairing) -> Track:
    """Tracks by length. OFF_FLANK and NO_COMMON_NORMAL are said for certain, as all curves are
    known; NOT_CONVERGED is a curve lost near the flanks or not resolved there."""
    curves, missing = curves_of(pairing)
    cases = len(missing)
    status = np.where(missing, np.int8(Status.NO_COMMON_NORMAL), np.int8(Status.OFF_FLANK))
    status[[curve.case for curve in curves]] = Status.OFF_FLANK
    parts = _near_flanks(pairing, [curve for curve in curves if not curve.lost])
    status[[part.case for part in parts if part.endless]] = Status.ENDLESS
    lost = [curve for curve in curves if curve.lost]
    status[[part.case for part in _near_flanks(pairing, lost)]] = Status.NOT_CONVERGED
    void = np.full((cases, 1), np.nan)
    track = Track(np.full((WIDTH, cases, 1), np.nan), void, void, status, np.zeros(cases, dtype=int))
    parts = [part for part in parts if status[part.case] == Status.OFF_FLANK]
    return track.merged(*_best_of(pairing, parts)) if parts else track


def _best_of(pairing: Pairing, parts: list[_Part]) -> tuple[Track, NDArray[np.int_]]:
    """One track for each case that has parts, and the cases."""
    case = np.array([part.case for part in parts])
    pairing = pairing.cases(case)
    fit = _fitted(pairing, parts)
    ends = find_ends(pairing, fit)
    owners, owner = np.unique(case, return_inverse=True)
    span = np.where(ends.status == Status.SOLVED, ends.span, -1.0)
    best = np.array([np.flatnonzero(owner == k)[span[owner == k].argmax()] for k in range(len(owners))])
    elsewhere = np.bincount(owner, ends.pieces).astype(int) - ends.pieces[best]
    status = fit.status[best]
    status = np.where(ends.status[best] == Status.OFF_FLANK, np.int8(Status.OFF_FLANK), status)
    doubtful = (ends.status != Status.SOLVED) & (ends.status != Status.OFF_FLANK)
    status[owner[doubtful]] = Status.NOT_CONVERGED
    return Track(fit.coefficients[:, best], fit.middle[best], fit.half[best], status, elsewhere), owners


def _fitted(pairing: Pairing, parts: list[_Part]) -> Track:
    """A track for each part, one case each."""
    units = units_of(pairing)
    guides = np.zeros((len(parts), 4, GUIDE + 1))
    for k, part in enumerate(parts):
        degree = min(GUIDE, max(1, len(part.points) // 2))
        guides[k, :, : degree + 1] = chebyshev.chebfit(_share(part.points), part.points, degree).T
    status, void = np.full(len(parts), np.int8(Status.NOT_CONVERGED)), np.full((len(parts), 1), np.nan)
    none = np.zeros(len(parts), dtype=int)
    track = Track(np.full((WIDTH, len(parts), 1), np.nan), void, void, status, none)
    pending = np.arange(len(parts))
    for basis in BASES:
        some = pairing.cases(pending)
        z, good = _on_guides(
            some, units[pending], guides[pending], [parts[k].points for k in pending], basis.nodes
        )
        y = np.moveaxis(z * units[pending], -1, 0)
        rows = rows_of(some, y[:2], meet_on_curve(some, y)[1])
        coefficients, resolved = fitted(some, rows, basis)
        resolved &= good
        done = pending[resolved]
        found = Track(
            coefficients[:, resolved], void[done], void[done], np.zeros(done.size, dtype=np.int8), none[done]
        )
        track, pending = track.merged(found, done), pending[~resolved]
        if pending.size == 0:
            break
    return track


def _share(points: FloatArray) -> FloatArray:
    """Length along points (points, 4) from -1 to 1."""
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=-1))))
    return np.asarray(2.0 * length / length[-1] - 1.0)


def _on_guides(
    pairing: Pairing, units: FloatArray, guides: FloatArray, lines: list[FloatArray], nodes: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Points z (parts, nodes, 4) where the curves cross the planes of their guides at `nodes`, and for
    which parts all of them lie on the part itself."""
    values = chebyshev.chebvander(nodes, GUIDE)
    rates = chebyshev.chebder(np.eye(GUIDE + 1), axis=0).T
    point = np.einsum("nd,pcd->pnc", values, guides)
    normal = np.einsum("nd,pcd->pnc", values[:, :GUIDE], guides @ rates)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    walked = np.array(
        [np.array([np.interp(nodes, _share(line), line[:, k]) for k in range(4)]).T for line in lines]
    )
    off = np.einsum("...i,...i", point - walked, normal)
    start = walked + off[..., None] * normal
    z, solved = onto_curve(pairing, start, normal, units, PASSES)
    near = np.linalg.norm(z - start, axis=-1) < LONGEST
    return z, (solved & near).all(axis=-1)


def _near_flanks(pairing: Pairing, curves: list[Walked]) -> list[_Part]:
    """The parts of curves that may lie on the flanks, with a little more at both ends."""
    if not curves:
        return []
    case = np.concatenate([np.full(len(curve.points), curve.case) for curve in curves])
    part = pairing.cases(case)
    y = np.concatenate([curve.points for curve in curves])[:, None] * units_of(part)
    y = np.moveaxis(y, -1, 0)
    height, radius = axial_and_radius(part, meet_on_curve(part, y)[1])
    margins = limit_margins(part, y[:2], height, radius)[..., 0]
    near = np.all(np.abs(height) <= (1.0 + OUTSIDE) * part.half_width, axis=0)[:, 0]
    depth, face = (part.highest - part.lowest)[..., 0], 2.0 * part.half_width[..., 0]  # as in `Limit`
    margins /= np.concatenate((depth, depth, face, face))
    parts, start = [], 0
    for curve in curves:
        here = slice(start, start + len(curve.points))
        parts += _cut(curve, near[here], margins[:, here])
        start = here.stop
    return parts


def _cut(curve: Walked, near: NDArray[np.bool_], margins: FloatArray) -> list[_Part]:
    """The parts of one curve, from which of its points are near, and their margins (8, points)."""
    points = curve.points
    if curve.closed:  # begin where it is furthest outside
        order = np.roll(np.arange(len(points) - 1), -int(margins[:, :-1].min(axis=0).argmin()))
        order = np.append(order, order[0])
        points, near, margins = points[order], near[order], margins[:, order]
        if margins.min() > 0.0:
            return [_Part(curve.case, points, True)]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], near, [0]))))
    parts = []
    for first, last in edges.reshape(-1, 2):
        run = slice(max(first - 2, 0), last + 2)
        if (curve.lost or len(points[run]) > 1) and (margins[:, first:last].max(axis=1) > -SPARE).all():
            parts.append(_Part(curve.case, points[run], False))
    return parts
