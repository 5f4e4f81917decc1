"""Series of the single curve of contact through the cells that remain (`root_exclusion`).

Consider cells in which n_x does not vanish and n F, with n = |n_x|, is monotone along l1 or along l2. If all
corners of such a cell have one sign, it contains no curve. If they have both signs, one curve enters and
leaves. The sides of cells that the curve crosses give its points. A crossed side that belongs to one
remaining cell only is an end. Suppose that there are exactly two ends, that the points are sorted along the
chord between them, and that each point has a cell in common with the next one. Then there is one curve, and
this is the order of its points (`chains_of`).

Its part near the flanks is solved at Chebyshev points, starting from these points: where the curve crosses
planes perpendicular to the l1 axis or to the chord of this part (`chain_series`). The chord is in the space
of l1, l2, n_x and w_1. The degrees 10, 20, 40 and 80 are tried in this order. Along the chord, 20 or 40
resolves most curves that no degree over l1 does. Nodes of a degree are every second node of twice this
degree, so that none is solved twice.

Curves that had to be traced have a guide in place of the chord: a polynomial through the traced points
(`series_along`). The point with parameter x is where the curve crosses the plane perpendicular to the guide
at x. This parameter is as smooth as the curve and needs no integral of its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.polynomial import chebyshev

from ...arrays import COMPLEX_STEP, FloatArray, Integers, Mask
from ...status import Status
from ...support.chebyshev import basis_of, evaluate
from ..equation import meet, relative_margins
from ..flank_pair import FlankPair
from ..path_polynomial import (
    FULL_ROW_COUNT,
    MAX_DEGREE,
    PathSeries,
    between,
    fitted_series,
    not_over_l1,
    rows_of,
)
from .curve_equations import meet_on_curve, onto_curve, units_of
from .curve_tracing import LONGEST_STEP, OFF_FLANK_MARGIN, CurvePart
from .root_exclusion import Box

GUIDE_BASES = tuple(basis_of(degree) for degree in (40, 100, 200, MAX_DEGREE))
"""Bases of series along guides, in the order in which they are tried."""
CELL_NEWTON_STEPS = 4
"""Newton steps to points on the sides of cells, and to points in planes across a chord."""
LOOSENED_ROUNDING_FACTOR = 16.0
"""Factor on the rounding tolerance if no basis reaches it: the curve has a sharp bend, or a member has a very
small base circle.
"""


@dataclass(frozen=True, eq=False)
class Chains:
    """Points of one curve for each case, in order along the curve.

    `z` (cases, points, 4); `margins` (cases, points, 8) from the limits, in flank depths and face widths. The
    first `count` (cases) points of a case are known, the others are NaN. `count` is 0 if the cells do not
    prove that there is one curve.
    """

    z: FloatArray
    margins: FloatArray
    count: Integers

    def cases(self, index: Integers) -> Chains:
        """Return the chains of the cases `index`."""
        return Chains(self.z[index], self.margins[index], self.count[index])


def chains_of(pairing: FlankPair, box: Box) -> Chains:
    """Return the curves through the cells of a box, for the sign of n_x of the pair only."""
    cases, left, gap = len(box.left), box.left, box.gap
    # Signs of n F at the nodes, and whether it increases along l1 and l2.
    below, steps = np.signbit(gap), [np.diff(gap, axis=axis) > 0.0 for axis in (1, 2)]
    cut = below[:, 1:] != below[:, :-1], below[:, :, 1:] != below[:, :, :-1]
    # Number of cut sides of each cell. A curve crosses a cell with two; four would be two curves.
    turns = cut[0][:, :, 1:].astype(np.int8) + cut[0][:, :, :-1] + cut[1][:, 1:] + cut[1][:, :-1]
    even = (steps[0][:, :, 1:] == steps[0][:, :, :-1]) | (steps[1][:, 1:] == steps[1][:, :-1])
    good = box.clear & (~left | (even & (turns != 4))).all(axis=(1, 2))
    # Include neighbours that the curve enters through a corner.
    left = left | (_entered_neighbours(left, cut) & even & (turns == 2))
    # Solve the points between cells; the cells left must have exactly two ends, and all points be solved.
    case, before, after, l, side = _crossings(box, left, cut, good)
    part, units = pairing.cases(case), units_of(pairing)
    y, solved = _between_cells(part, l, side)
    z = (y / units[case, 0].T).T
    ends = (before < 0) != (after < 0)
    good &= np.bincount(case[ends], minlength=cases) == 2
    good &= np.bincount(case[~solved], minlength=cases) == 0
    valid = good[case]
    case, before, after, z, ends = case[valid], before[valid], after[valid], z[valid], ends[valid]
    # Sort the points along the chord between both ends.
    corner = np.zeros((2, cases, 4))
    order = np.flatnonzero(ends)[np.argsort(case[ends], kind="stable")].reshape(-1, 2)
    corner[:, case[order[:, 0]]] = z[order.T]
    position = np.einsum("ij,ij->i", z - corner[0, case], (corner[1] - corner[0])[case])
    order = np.lexsort((position, case))
    case, before, after, z, position = case[order], before[order], after[order], z[order], position[order]
    # Consecutive points must advance along the chord and have a cell in common.
    same = case[1:] == case[:-1]
    joined = (position[1:] > position[:-1]) & (
        ((before[1:] >= 0) & ((before[1:] == before[:-1]) | (before[1:] == after[:-1])))
        | ((after[1:] >= 0) & ((after[1:] == before[:-1]) | (after[1:] == after[:-1])))
    )
    good &= np.bincount(case[1:][same & ~joined], minlength=cases) == 0
    # Collect the points by case.
    count = np.bincount(case, minlength=cases)
    place = np.arange(case.size) - (np.cumsum(count) - count)[case]
    points, inside = (np.full((cases, int(count.max(initial=2)), size), np.nan) for size in (4, 8))
    points[case, place], inside[case, place] = z, _margins(pairing.cases(case), z * units[case, 0])
    return Chains(points, inside, np.where(good, count, 0))


def _crossings(
    box: Box, left: Mask, cut: tuple[Mask, Mask], good: Mask
) -> tuple[Integers, Integers, Integers, FloatArray, FloatArray]:
    """Return where sides of the cells `left` of `good` cases are `cut`.

    The results are the case, the numbers of the cells before and behind the side (-1 for an excluded cell), a
    point near the curve and the side (2, sides), mm.
    """
    # Numbers of the remaining cells, -1 for others; sides along l2 first, then along l1.
    number = np.where(left, np.arange(left.shape[1] ** 2).reshape(left.shape[1:]), -1)
    edges = []
    for axis, cuts in enumerate(cut):
        outside = np.full_like(number.take([0], axis=2 - axis), -1)
        before, after = (
            np.concatenate(parts, axis=2 - axis) for parts in ((outside, number), (number, outside))
        )
        case, i, j = np.nonzero(cuts & ((before >= 0) | (after >= 0)) & good[:, None, None])
        other = (i + 1, j) if axis == 0 else (i, j + 1)
        # The point on the side where n F is zero by linear interpolation.
        near, far = box.gap[case, i, j], box.gap[case, *other]
        l = np.stack((box.lines[0, case, i], box.lines[1, case, j]))
        side = np.zeros_like(l)
        side[axis] = box.lines[axis, case, other[axis]] - l[axis]
        edges.append((case, before[case, i, j], after[case, i, j], l + near / (near - far) * side, side))
    case, before, after, l, side = (np.concatenate(parts, axis=-1) for parts in zip(*edges, strict=True))
    return case, before, after, l, side


def _margins(pairing: FlankPair, y: FloatArray) -> FloatArray:
    """Return margins (points, 8) from the limits at points y (points, 4), in flank depths and face widths."""
    y = np.ascontiguousarray(y[:, None].transpose(2, 0, 1))
    return np.asarray(relative_margins(pairing, y[:2], meet_on_curve(pairing, y)[1])[..., 0].T)


def _entered_neighbours(left: Mask, cut: tuple[Mask, Mask]) -> Mask:
    """Return cells that a curve enters from the remaining cells. Where the curve only cuts the corner of a
    cell, the bounds may have excluded this cell.
    """
    across, along = cut[0][:, :, 1:-1], cut[1][:, 1:-1]
    neighbours = np.zeros_like(left)
    neighbours[:, :, 1:] |= left[:, :, :-1] & across
    neighbours[:, :, :-1] |= left[:, :, 1:] & across
    neighbours[:, 1:] |= left[:, :-1] & along
    neighbours[:, :-1] |= left[:, 1:] & along
    return neighbours


def _between_cells(pairing: FlankPair, l: FloatArray, side: FloatArray) -> tuple[FloatArray, Mask]:
    """Return contacts y (4, points) on the `side`s of cells, from `l` on these (2, points), and which were
    found.
    """
    l = l[..., None].copy()
    # Largest last Newton step, in sides of a cell.
    last_cell_step = 1e-3
    for _ in range(CELL_NEWTON_STEPS):
        # Newton step along the side, limited to half of it.
        gap = meet(pairing, l + COMPLEX_STEP * 1j * side[..., None]).gap
        move = np.clip(-gap.real * COMPLEX_STEP / gap.imag, -0.5, 0.5)
        l += move * side[..., None]
        if not (np.abs(move) > last_cell_step).any():
            break
    met = meet(pairing, l)
    y = np.array((*l, met.normal_x, met.across[0]))[..., 0]
    return y, (np.abs(move[:, 0]) <= last_cell_step) & np.isfinite(y).all(axis=0)


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Part of the chains that is solved.

    Points z (cases, most, 4), the last one repeated; their position along the unit `axis` (cases, 1, 4), from
    -1 to 1, with `middle` and `half` (cases, 1) in units of z.
    """

    z: FloatArray
    axis: FloatArray
    x: FloatArray
    middle: FloatArray
    half: FloatArray
    good: Mask

    def at(self, nodes: FloatArray) -> FloatArray:
        """Return points (cases, nodes, 4) on straight lines between those of the chains."""
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
    """Return the parts of chains whose points are not clearly off the flanks, with one more point at both
    ends.
    """
    place = np.arange(chains.z.shape[1])
    near = (np.nan_to_num(chains.margins, nan=-np.inf) > -OFF_FLANK_MARGIN).all(axis=-1)
    # If no point is near the flanks, the entire chain is used.
    near |= ~near.any(axis=-1, keepdims=True) & (place < chains.count[:, None])
    first = np.maximum(near.argmax(axis=-1) - 1, 0)
    last = np.minimum(near.shape[1] - near[:, ::-1].argmax(axis=-1), chains.count - 1)
    case = np.arange(len(first))
    # Along l1, the chain must start at the smaller l1.
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
    # The position along the axis must increase monotonically.
    position = np.einsum("pki,pi->pk", z, axis)
    good = ((np.diff(position, axis=-1) > 0.0) | (place[1:] > (last - first)[:, None])).all(axis=-1)
    middle, half = 0.5 * (position[:, :1] + position[:, -1:]), 0.5 * (position[:, -1:] - position[:, :1])
    return _Stretch(z, axis[:, None], (position - middle) / half, middle, half, good & (last > first))


def missed(chains: Chains) -> Mask:
    """Return which chains (cases) are clearly beyond one and the same limit in all points."""
    with np.errstate(invalid="ignore"):
        most = np.nan_to_num(chains.margins, nan=-np.inf).max(axis=1)
    return np.asarray((most <= -OFF_FLANK_MARGIN).any(axis=-1))


def chain_series(pairing: FlankPair, chains: Chains, over_l1: bool) -> Iterator[tuple[Integers, PathSeries]]:
    """Yield, degree by degree, the cases that are resolved and their series, over l1 or along the chords, of
    the parts of the chains that are not clearly off the flanks.
    """
    # Limit, in units of z, of the coefficients of the highest degree, as predicted from those of a
    # lower degree.
    predicted_coefficient_limit = 1e-11
    stretch, units = _stretch(chains, over_l1), units_of(pairing)
    side = np.linalg.norm(np.diff(stretch.z, axis=1), axis=-1).max(axis=-1)
    pending = np.flatnonzero(stretch.good)
    z, bends, rows = np.empty((pending.size, 0, 4)), np.empty(0), np.empty((FULL_ROW_COUNT, pending.size, 0))
    bases = [basis_of(degree) for degree in (10, 20, 40, 80)]
    for turn, basis in enumerate(bases):
        part, unit = pairing.cases(pending), units[pending]
        # Start from the chain, then from the series of half the degree; only the new nodes are solved.
        if turn == 0:
            start = _Stretch(*(x[pending] for x in vars(stretch).values())).at(basis.nodes)
        else:
            start = evaluate(bends, basis.nodes[1::2]).transpose(1, 2, 0)
        normal = np.broadcast_to(stretch.axis[pending], start.shape)
        result, solved = onto_curve(part, start, normal, unit, CELL_NEWTON_STEPS)
        # Reject solutions that left their neighbourhood or changed the sign of n_x.
        solved &= np.linalg.norm(result - start, axis=-1) <= side[pending, None]
        solved &= result[..., 2] * part.branch > 0.0
        y = np.ascontiguousarray(np.moveaxis(result * unit, -1, 0))
        rows = between(rows, rows_of(part, y[:2], meet_on_curve(part, y)[1]))
        z = between(z.transpose(2, 0, 1), result.transpose(2, 0, 1)).transpose(1, 2, 0)
        coefficients, good = fitted_series(
            part, rows, basis, LOOSENED_ROUNDING_FACTOR if basis is bases[-1] else 1.0
        )
        good &= solved.all(axis=-1)
        if good.any():
            done = pending[good]
            middle, half = (np.full((done.size, 1), np.nan) for _ in range(2))
            if over_l1:
                middle, half = (x[done] * units[done, :, 0] for x in (stretch.middle, stretch.half))
            yield done, PathSeries(coefficients[:, good], middle, half, np.zeros(done.size, dtype=np.int8))
        # Continue only with cases whose coefficients predict convergence at the highest degree.
        bends = basis.coefficients(z.transpose(2, 0, 1))
        tail = np.abs(bends[..., -3:]).max(axis=(0, 2))
        share = len(basis.nodes) / len(bases[-1].nodes)
        left = ~good & solved.all(axis=-1) & (tail < predicted_coefficient_limit**share)
        pending, z, rows, bends = pending[left], z[left], rows[:, left], bends[:, left]
        if pending.size == 0:
            return


def series_along(pairing: FlankPair, parts: list[CurvePart]) -> Iterator[tuple[Integers, PathSeries]]:
    """Yield, basis by basis, which parts of traced curves are resolved and their series, one case each."""
    units = units_of(pairing)
    guides = np.stack([_guide(part.points) for part in parts])
    pending = np.arange(len(parts))
    # Increase the degree, then the rounding tolerance.
    for loosened, basis in product((1.0, LOOSENED_ROUNDING_FACTOR), GUIDE_BASES):
        subset, lines = pairing.cases(pending), [parts[k].points for k in pending]
        z, good = _on_guides(subset, units[pending], guides[pending], lines, basis.nodes)
        y = np.ascontiguousarray(np.moveaxis(z * units[pending], -1, 0))
        rows = rows_of(subset, y[:2], meet_on_curve(subset, y)[1])
        coefficients, resolved = fitted_series(subset, rows, basis, loosened)
        resolved &= good
        if resolved.any():
            solved = np.zeros(int(resolved.sum()), dtype=np.int8)
            yield pending[resolved], not_over_l1(coefficients[:, resolved], solved)
        pending = pending[~resolved]
        if pending.size == 0:
            return
    lost = np.full(pending.size, np.int8(Status.NOT_CONVERGED))
    yield pending, not_over_l1(np.full((FULL_ROW_COUNT, pending.size, 2), np.nan), lost)


def _guide(points: FloatArray) -> FloatArray:
    """Return coefficients (4, degree + 1) of a guide along points (points, 4)."""
    highest = 12
    guide, degree = np.zeros((highest + 1, 4)), min(highest, max(1, len(points) // 2))
    guide[: degree + 1] = chebyshev.chebfit(_share(points), points, degree)
    return guide.T


def _share(points: FloatArray) -> FloatArray:
    """Return the position of points (points, 4) along their line, from -1 to 1, by length and by rotation of
    the tangent.
    """
    # Rotation in rad that takes as much of the parameter of a guide as the longest step.
    turn_scale_rad = 0.1
    sides = np.diff(points, axis=0)
    length = np.linalg.norm(sides, axis=-1)
    # Curve parameter: length plus rotation, so that bends get more nodes.
    turns = np.linalg.norm(np.diff(sides / length[:, None], axis=0), axis=-1)
    parameter_steps = length / LONGEST_STEP
    parameter_steps[1:] += 0.5 * turns / turn_scale_rad
    parameter_steps[:-1] += 0.5 * turns / turn_scale_rad
    position = np.concatenate(([0.0], np.cumsum(parameter_steps)))
    return np.asarray(2.0 * position / position[-1] - 1.0)


def _between(points: FloatArray, nodes: FloatArray) -> FloatArray:
    """Return the line through points (points, 4) at the positions `nodes`."""
    share = _share(points)
    return np.stack([np.interp(nodes, share, values) for values in points.T], axis=-1)


def _on_guides(
    pairing: FlankPair, units: FloatArray, guides: FloatArray, lines: list[FloatArray], nodes: FloatArray
) -> tuple[FloatArray, Mask]:
    """Return points z (parts, nodes, 4) where the curves cross the planes of their guides at `nodes`, and for
    which parts all of them lie on the part.
    """
    size = guides.shape[-1]
    values = chebyshev.chebvander(nodes, size - 1)
    rates = chebyshev.chebder(np.eye(size), axis=0).T
    point = np.einsum("nd,pcd->pnc", values, guides)
    normal = np.einsum("nd,pcd->pnc", values[:, :-1], guides @ rates)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    traced = np.array([_between(line, nodes) for line in lines])
    off = np.einsum("...i,...i", point - traced, normal)
    start = traced + off[..., None] * normal
    # Newton steps to the planes perpendicular to a guide.
    z, solved = onto_curve(pairing, start, normal, units, 8)
    near = np.linalg.norm(z - start, axis=-1) < LONGEST_STEP
    return z, (solved & near).all(axis=-1)
