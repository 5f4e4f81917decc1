"""Series of traced curves of contact along guides.

The parameter of such a series is no true length: a polynomial through the traced points is its guide,
and the point with parameter x is where the curve crosses the plane square to the guide at x. That is
as smooth as the curve, and needs no integral.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..status import Status
from ..support.chebyshev import basis_of
from .curve_equations import meet_on_curve, onto_curve, units_of
from .curve_tracing import LONGEST, Part
from .equation import Pairing
from .path_polynomial import LARGEST, LOOSENED, WIDTH, PathSeries, by_length, fitted, rows_of

GUIDE = 12
"""Highest degree of a guide."""
TURN_ROOM = 0.1
"""rad of turn that take as much room along a guide as the longest step."""
BASES = tuple(basis_of(degree) for degree in (40, 100, 200, LARGEST))
PASSES = 8


def series_along(pairing: Pairing, parts: list[Part]) -> Iterator[tuple[NDArray[np.int_], PathSeries]]:
    """Give series of the parts of traced curves, one case each: which of them, basis by basis."""
    units = units_of(pairing)
    guides = np.stack([_guide(part.points) for part in parts])
    pending = np.arange(len(parts))
    for loosened, basis in product((1.0, LOOSENED), BASES):
        some, lines = pairing.cases(pending), [parts[k].points for k in pending]
        z, good = _on_guides(some, units[pending], guides[pending], lines, basis.nodes)
        y = np.ascontiguousarray(np.moveaxis(z * units[pending], -1, 0))
        rows = rows_of(some, y[:2], meet_on_curve(some, y)[1])
        coefficients, resolved = fitted(some, rows, basis, loosened)
        resolved &= good
        if resolved.any():
            solved = np.zeros(int(resolved.sum()), dtype=np.int8)
            yield pending[resolved], by_length(coefficients[:, resolved], solved)
        pending = pending[~resolved]
        if pending.size == 0:
            return
    lost = np.full(pending.size, np.int8(Status.NOT_CONVERGED))
    yield pending, by_length(np.full((WIDTH, pending.size, 2), np.nan), lost)


def _guide(points: FloatArray) -> FloatArray:
    """Give coefficients (4, GUIDE + 1) of a guide along points (points, 4)."""
    guide, degree = np.zeros((GUIDE + 1, 4)), min(GUIDE, max(1, len(points) // 2))
    guide[: degree + 1] = chebyshev.chebfit(_share(points), points, degree)
    return guide.T


def _share(points: FloatArray) -> FloatArray:
    """Say how far along points (points, 4), from -1 to 1: by length, and by turns, which need as much
    room."""
    sides = np.diff(points, axis=0)
    length = np.linalg.norm(sides, axis=-1)
    turns = np.linalg.norm(np.diff(sides / length[:, None], axis=0), axis=-1)
    room = length / LONGEST
    room[1:] += 0.5 * turns / TURN_ROOM
    room[:-1] += 0.5 * turns / TURN_ROOM
    way = np.concatenate(([0.0], np.cumsum(room)))
    return np.asarray(2.0 * way / way[-1] - 1.0)


def _between(points: FloatArray, nodes: FloatArray) -> FloatArray:
    """Give the line through points (points, 4) at `nodes` of its way."""
    share = _share(points)
    return np.stack([np.interp(nodes, share, values) for values in points.T], axis=-1)


def _on_guides(
    pairing: Pairing, units: FloatArray, guides: FloatArray, lines: list[FloatArray], nodes: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give points z (parts, nodes, 4) where the curves cross the planes of their guides at `nodes`, and for
    which parts all of them lie on the part itself."""
    values = chebyshev.chebvander(nodes, GUIDE)
    rates = chebyshev.chebder(np.eye(GUIDE + 1), axis=0).T
    point = np.einsum("nd,pcd->pnc", values, guides)
    normal = np.einsum("nd,pcd->pnc", values[:, :-1], guides @ rates)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    traced = np.array([_between(line, nodes) for line in lines])
    off = np.einsum("...i,...i", point - traced, normal)
    start = traced + off[..., None] * normal
    z, solved = onto_curve(pairing, start, normal, units, PASSES)
    near = np.linalg.norm(z - start, axis=-1) < LONGEST
    return z, (solved & near).all(axis=-1)
