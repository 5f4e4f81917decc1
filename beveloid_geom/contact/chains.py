"""Series of the one curve of contact that runs through the cells that signs leave (`cells`).

In cells in which n_x does not vanish and n F rises or falls along l1 or along l2, corners of one sign mean
no curve, and corners of both that one curve enters and leaves. Where there are two ways in or out of the
cells left, and the points at which the curve goes from cell to cell, sorted along the chord between these
two, have one cell in common with the next, it is one curve, and this their order (`chains_of`).

Its part near the flanks is then solved at Chebyshev points, starting from these points: where planes square
to an axis, that of l1, or to the chord of that part cross it (`series_of`). Along the chord, which is one of
l1, l2, n_x and w_1, degree 16 resolves most that no degree over l1 does. Nodes of a degree are every other
one of twice that degree, so that none is solved twice.

Curves that had to be traced have a guide in place of the chord, a polynomial through the traced points
(`series_along`): the point with parameter x is where the curve crosses the plane square to the guide at x.
That is as smooth as the curve, and needs no integral of its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ..arrays import COMPLEX_STEP, FloatArray
from ..status import Status
from ..support.chebyshev import basis_of, evaluate
from .cells import Box
from .curve_equations import meet_on_curve, onto_curve, units_of
from .curve_tracing import LONGEST, Part
from .equation import Pairing, meet, relative_margins
from .path_polynomial import LARGEST, LOOSENED, WIDTH, PathSeries, between, by_length, fitted, rows_of

Mask = NDArray[np.bool_]
PASSES, CLOSE = 4, 1e-3
"""Steps of Newton to points between cells, the last of them below CLOSE of a cell's side."""
NESTED = tuple(basis_of(degree) for degree in (10, 20, 40, 80))
HOPELESS = 1e-11
"""Coefficients, in units of z, that the highest degree must bring down to: those of a lower one say whether
it can."""
SPARE = 0.1
"""Depths, or face widths, by which a limit must be missed for a point to count as off."""

GUIDE, GUIDE_PASSES = 12, 8
"""Highest degree of a guide; steps of Newton onto the planes square to it."""
TURN_ROOM = 0.1
"""rad of turn that take as much room along a guide as the longest step."""
BASES = tuple(basis_of(degree) for degree in (40, 100, 200, LARGEST))


@dataclass(frozen=True, eq=False)
class Chains:
    """Points of the curves of cases, in order, the first `count` (cases) of the second axis: z (cases, most,
    4), and `margins` (cases, most, 8) within the limits, in flank depths and face widths. `count` is 0 where
    the cells do not say that they hold one curve."""

    z: FloatArray
    margins: FloatArray
    count: NDArray[np.int_]

    def cases(self, index: NDArray[np.int_]) -> Chains:
        """Give the chains of the cases `index`."""
        return Chains(self.z[index], self.margins[index], self.count[index])


def chains_of(pairing: Pairing, box: Box) -> Chains:
    """Give the curves through the cells of a box, of the pairing's sign of n_x alone."""
    cases, left, gap = len(box.left), box.left, box.gap
    below, steps = np.signbit(gap), [np.diff(gap, axis=axis) > 0.0 for axis in (1, 2)]
    cut = below[:, 1:] != below[:, :-1], below[:, :, 1:] != below[:, :, :-1]
    turns = cut[0][:, :, 1:].astype(np.int8) + cut[0][:, :, :-1] + cut[1][:, 1:] + cut[1][:, :-1]
    even = (steps[0][:, :, 1:] == steps[0][:, :, :-1]) | (steps[1][:, 1:] == steps[1][:, :-1])
    good = box.clear & (~left | (even & (turns != 4))).all(axis=(1, 2))
    left = left | (_beside(left, cut) & even & (turns == 2))
    case, before, after, l, side = _crossings(box, left, cut, good)
    part, units = pairing.cases(case), units_of(pairing)
    y, solved = _between_cells(part, l, side)
    z = (y / units[case, 0].T).T
    ends = (before < 0) != (after < 0)
    good &= np.bincount(case[ends], minlength=cases) == 2
    good &= np.bincount(case[~solved], minlength=cases) == 0
    kept = good[case]
    case, before, after, z, ends = case[kept], before[kept], after[kept], z[kept], ends[kept]
    corner = np.zeros((2, cases, 4))
    order = np.flatnonzero(ends)[np.argsort(case[ends], kind="stable")].reshape(-1, 2)
    corner[:, case[order[:, 0]]] = z[order.T]
    way = np.einsum("ij,ij->i", z - corner[0, case], (corner[1] - corner[0])[case])
    order = np.lexsort((way, case))
    case, before, after, z, way = case[order], before[order], after[order], z[order], way[order]
    same = case[1:] == case[:-1]
    joined = (way[1:] > way[:-1]) & (
        ((before[1:] >= 0) & ((before[1:] == before[:-1]) | (before[1:] == after[:-1])))
        | ((after[1:] >= 0) & ((after[1:] == before[:-1]) | (after[1:] == after[:-1])))
    )
    good &= np.bincount(case[1:][same & ~joined], minlength=cases) == 0
    count = np.bincount(case, minlength=cases)
    place = np.arange(case.size) - (np.cumsum(count) - count)[case]
    points, inside = (np.full((cases, int(count.max(initial=2)), size), np.nan) for size in (4, 8))
    points[case, place], inside[case, place] = z, _margins(pairing.cases(case), z * units[case, 0])
    return Chains(points, inside, np.where(good, count, 0))


def _crossings(
    box: Box, left: Mask, cut: tuple[Mask, Mask], good: Mask
) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_], FloatArray, FloatArray]:
    """Say where sides of the cells `left` of `good` cases are `cut`: the case, the numbers of the cells
    before and behind the side, -1 for one not left, a point near the curve and the side itself (2, sides),
    mm."""
    number = np.where(left, np.arange(left.shape[1] ** 2).reshape(left.shape[1:]), -1)
    edges = []
    for axis, cuts in enumerate(cut):
        pad = ((0, 0), (0, 0), (1, 1)) if axis == 0 else ((0, 0), (1, 1), (0, 0))
        beside = np.pad(number, pad, constant_values=-1)
        before, after = (
            (beside[:, :, :-1], beside[:, :, 1:]) if axis == 0 else (beside[:, :-1], beside[:, 1:])
        )
        case, i, j = np.nonzero(cuts & ((before >= 0) | (after >= 0)) & good[:, None, None])
        other = (i + 1, j) if axis == 0 else (i, j + 1)
        near, far = box.gap[case, i, j], box.gap[case, *other]
        l = np.stack((box.lines[0, case, i], box.lines[1, case, j]))
        side = np.zeros_like(l)
        side[axis] = box.lines[axis, case, other[axis]] - l[axis]
        edges.append((case, before[case, i, j], after[case, i, j], l + near / (near - far) * side, side))
    case, before, after, l, side = (np.concatenate(parts, axis=-1) for parts in zip(*edges, strict=True))
    return case, before, after, l, side


def _margins(pairing: Pairing, y: FloatArray) -> FloatArray:
    """Give margins (points, 8) within the limits at points y (points, 4), in flank depths and face widths."""
    y = np.ascontiguousarray(y[:, None].transpose(2, 0, 1))
    return np.asarray(relative_margins(pairing, y[:2], meet_on_curve(pairing, y)[1])[..., 0].T)


def _beside(left: Mask, cut: tuple[Mask, Mask]) -> Mask:
    """Give cells into which a curve runs from those left: where it cuts a corner, bounds may part it."""
    across, along = cut[0][:, :, 1:-1], cut[1][:, 1:-1]
    beside = np.zeros_like(left)
    beside[:, :, 1:] |= left[:, :, :-1] & across
    beside[:, :, :-1] |= left[:, :, 1:] & across
    beside[:, 1:] |= left[:, :-1] & along
    beside[:, :-1] |= left[:, 1:] & along
    return beside


def _between_cells(pairing: Pairing, l: FloatArray, side: FloatArray) -> tuple[FloatArray, Mask]:
    """Give contacts y (4, points) on the `side`s of cells, from `l` on these (2, points), and which were
    found."""
    l = l[..., None].copy()
    for _ in range(PASSES):
        gap = meet(pairing, l + COMPLEX_STEP * 1j * side[..., None]).gap
        move = np.clip(-gap.real * COMPLEX_STEP / gap.imag, -0.5, 0.5)
        l += move * side[..., None]
        if not (np.abs(move) > CLOSE).any():
            break
    met = meet(pairing, l)
    y = np.array((*l, met.normal_x, met.across[0]))[..., 0]
    return y, (np.abs(move[:, 0]) <= CLOSE) & np.isfinite(y).all(axis=0)


@dataclass(frozen=True, eq=False)
class _Stretch:
    """What of chains is solved: points z (cases, most, 4), the last repeated, how far along the unit `axis`
    (cases, 1, 4) these lie, from -1 to 1, and `middle` and `half` (cases, 1) of that in units of z."""

    z: FloatArray
    axis: FloatArray
    x: FloatArray
    middle: FloatArray
    half: FloatArray
    good: Mask

    def at(self, nodes: FloatArray) -> FloatArray:
        """Give points (cases, nodes, 4) on straight lines between those of the chains."""
        index = (self.x[:, None] <= nodes[:, None]).sum(axis=-1)
        index = np.minimum(np.maximum(index, 1), self.z.shape[1] - 1)
        (far, near), (x_far, x_near) = (
            [np.take_along_axis(values, place, axis=1) for place in (index[..., None], index[..., None] - 1)]
            for values in (self.z, self.x[..., None])
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(x_far > x_near, (nodes[:, None] - x_near) / (x_far - x_near), 1.0)
        return np.asarray(near + share * (far - near))


def _stretch(chains: Chains, over_l1: bool) -> _Stretch:
    """Give the parts of chains whose points are not clearly off the flanks, with one point more at both
    ends."""
    place = np.arange(chains.z.shape[1])
    near = (np.nan_to_num(chains.margins, nan=-np.inf) > -SPARE).all(axis=-1)
    near |= ~near.any(axis=-1, keepdims=True) & (place < chains.count[:, None])
    first = np.maximum(near.argmax(axis=-1) - 1, 0)
    last = np.minimum(near.shape[1] - near[:, ::-1].argmax(axis=-1), chains.count - 1)
    case = np.arange(len(first))
    chord = chains.z[case, last] - chains.z[case, first]
    back = over_l1 & (chord[:, 0] < 0.0)
    order = np.where(
        back[:, None],
        np.maximum(last[:, None] - place, first[:, None]),
        np.minimum(first[:, None] + place, last[:, None]),
    )
    z = chains.z[case[:, None], order]
    axis = np.broadcast_to(np.eye(4)[0], chord.shape) if over_l1 else chord
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    way = np.einsum("pki,pi->pk", z, axis)
    good = ((np.diff(way, axis=-1) > 0.0) | (place[1:] > (last - first)[:, None])).all(axis=-1)
    middle, half = 0.5 * (way[:, :1] + way[:, -1:]), 0.5 * (way[:, -1:] - way[:, :1])
    return _Stretch(z, axis[:, None], (way - middle) / half, middle, half, good & (last > first))


def missed(chains: Chains) -> Mask:
    """Say which chains (cases) miss one and the same limit clearly in all points."""
    with np.errstate(invalid="ignore"):
        most = np.nan_to_num(chains.margins, nan=-np.inf).max(axis=1)
    return np.asarray((most <= -SPARE).any(axis=-1))


def series_of(
    pairing: Pairing, chains: Chains, over_l1: bool
) -> Iterator[tuple[NDArray[np.int_], PathSeries]]:
    """Give, degree by degree, the cases that are resolved and their series: over l1, or along the chords, of
    those parts of the chains that are not clearly off the flanks."""
    stretch, units = _stretch(chains, over_l1), units_of(pairing)
    side = np.linalg.norm(np.diff(stretch.z, axis=1), axis=-1).max(axis=-1)
    pending = np.flatnonzero(stretch.good)
    z, bends, rows = np.empty((pending.size, 0, 4)), np.empty(0), np.empty((WIDTH, pending.size, 0))
    for turn, basis in enumerate(NESTED):
        part, unit = pairing.cases(pending), units[pending]
        if turn == 0:
            start = _Stretch(*(x[pending] for x in vars(stretch).values())).at(basis.nodes)
        else:
            start = evaluate(bends, basis.nodes[1::2]).transpose(1, 2, 0)
        normal = np.broadcast_to(stretch.axis[pending], start.shape)
        found, solved = onto_curve(part, start, normal, unit, PASSES)
        solved &= np.linalg.norm(found - start, axis=-1) <= side[pending, None]
        solved &= found[..., 2] * part.branch > 0.0
        y = np.ascontiguousarray(np.moveaxis(found * unit, -1, 0))
        rows = between(rows, rows_of(part, y[:2], meet_on_curve(part, y)[1]))
        z = between(z.transpose(2, 0, 1), found.transpose(2, 0, 1)).transpose(1, 2, 0)
        coefficients, good = fitted(part, rows, basis, LOOSENED if basis is NESTED[-1] else 1.0)
        good &= solved.all(axis=-1)
        if good.any():
            done = pending[good]
            middle, half = (np.full((done.size, 1), np.nan) for _ in range(2))
            if over_l1:
                middle, half = (x[done] * units[done, :, 0] for x in (stretch.middle, stretch.half))
            yield done, PathSeries(coefficients[:, good], middle, half, np.zeros(done.size, dtype=np.int8))
        bends = basis.coefficients(z.transpose(2, 0, 1))
        tail = np.abs(bends[..., -3:]).max(axis=(0, 2))
        left = ~good & solved.all(axis=-1) & (tail < HOPELESS ** (len(basis.nodes) / len(NESTED[-1].nodes)))
        pending, z, rows, bends = pending[left], z[left], rows[:, left], bends[:, left]
        if pending.size == 0:
            return


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
    z, solved = onto_curve(pairing, start, normal, units, GUIDE_PASSES)
    near = np.linalg.norm(z - start, axis=-1) < LONGEST
    return z, (solved & near).all(axis=-1)
