"""Exclusion of roots: cells of (l1, l2) that contain no contact near the faces.

F(l1, l2) of `equation` and the axial coordinates z_j of the contact diverge where n_x vanishes, for both
signs of n_x. With n = |n_x|, the sign s of n_x and R_j = n_x w_j,

    n F   = s (P - E n^2) + (A_1 + A_2) n,      P = B_1 R_1 + B_2 R_2,
    n z_j = s (S_j + v_j B_j) R_j - (c_j - v_j A_j) n

do not diverge, and n^2 as well as all factors of n and of s are smooth in l1 and l2. A cell in which n F
keeps its sign contains no contact. A cell contains no contact near the faces if no n lets both members touch
near their faces, or if F is zero for none of these n. Bounds in a cell are the values at its four corners,
extended by half of their second differences: a smooth function deviates from its corner values by an eighth
of these, and the square root n by half at most. If n_x^2 vanishes within a cell, n F is not smooth there and
its sign is not used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.rack import rack_normal
from ...pair.frames import common_normal
from ...pair.mounting import across_action
from ..flank_pair import FlankPair, terms_of

GRID_LINES = 9
"""Default number of grid lines of each member."""


@dataclass(frozen=True, eq=False)
class Box:
    """Remaining part of a window in l1 and l2, by case.

    `low`, `high` (2, cases, 1), mm, bound the cells that remain for either sign of n_x. Masks (cases):
    `none`, no cell remains; `alone`, all remaining cells have the sign of n_x of the pair; `clear`, n_x does
    not vanish in these; `one`, both hold and each l1 has at most one contact, so that there is at most one
    curve; `missing`, somewhere in the window there is no common normal; `curve`, the window contains a curve
    of contact, near the faces or not.

    For the sign of the pair: `left` (cases, nodes - 1, nodes - 1) are the remaining cells, and `gap` (cases,
    nodes, nodes) is n F on the grid `lines` (2, cases, nodes), mm.
    """

    low: FloatArray
    high: FloatArray
    none: Mask
    alone: Mask
    clear: Mask
    one: Mask
    missing: Mask
    curve: Mask
    left: Mask
    gap: FloatArray
    lines: FloatArray

    CASE_AXES: ClassVar = {"low": 1, "high": 1, "lines": 1}
    """Axes of cases that are not the first."""

    def cases(self, index: Integers) -> Box:
        """Return the results of the cases `index`."""
        return Box(**{name: x.take(index, Box.CASE_AXES.get(name, 0)) for name, x in vars(self).items()})


def window_of(pairing: FlankPair) -> tuple[FloatArray, FloatArray]:
    """Return bounds (2, cases, 1) of the window in l1 and l2, mm."""
    # Margin of the window of l1 and l2 beyond root and tip, in flank depths.
    window_margin_depths = 0.05
    slack = window_margin_depths * (pairing.highest - pairing.lowest)
    shape = (2, *pairing.branch.shape)
    low, high = pairing.lowest - slack, pairing.highest + slack
    return np.broadcast_to(low, shape), np.broadcast_to(high, shape)


def vanishing(pairing: FlankPair) -> Mask:
    """Return whether n_x is 0 to rounding in the entire window: the flanks then touch along lines, or
    nowhere.
    """
    # Upper bound of n_x^2 that may be rounding only.
    vanishing_x_squared = 1e-13
    low, high = window_of(pairing)
    l = np.concatenate((low, high, 0.5 * (low + high)), axis=-1)
    x_squared = common_normal(pairing.layout, rack_normal(pairing.rack, l)[2]).x_squared
    return np.asarray((np.abs(x_squared) < vanishing_x_squared).all(axis=-1))


def box_of(
    pairing: FlankPair, low: FloatArray, high: FloatArray, both: bool = True, nodes: int = GRID_LINES
) -> Box:
    """Return the cells that signs on the grid do not exclude in the window from `low` to `high` (2, cases,
    1), mm.

    `both`: for both signs of n_x, else for that of the pair; `nodes`: grid lines along l1 and l2.
    """
    # Number of cases whose arrays stay in the cache.
    cases_per_block = 128
    size = max(1, cases_per_block * GRID_LINES**2 // nodes**2)
    parts = [slice(start, start + size) for start in range(0, max(1, low.shape[1]), size)]
    result = [_box(pairing.cases(part), low[:, part], high[:, part], both, nodes) for part in parts]
    columns = {name: [getattr(box, name) for box in result] for name in vars(result[0])}
    return Box(**{name: np.concatenate(x, axis=Box.CASE_AXES.get(name, 0)) for name, x in columns.items()})


def _box(pairing: FlankPair, low: FloatArray, high: FloatArray, both: bool, nodes: int) -> Box:
    """Return the result of `box_of` for a block. Grids and cells have the cases on their last axis, along
    which NumPy iterates.
    """
    l = low + np.linspace(0.0, 1.0, nodes) * (high - low)
    values = _values(pairing, l)
    # Bounds in each cell, and the cells that they do not exclude, for both signs of n_x.
    least, most = _bounds(values)
    same_sign, clear = _left(pairing, False, least, most)
    other = _left(pairing, True, least, most)[0] if both else np.zeros_like(same_sign)
    alone, clear = np.asarray(~other.any(axis=(0, 1))), np.asarray((clear | ~same_sign).all(axis=(0, 1)))
    real, either = values[0] > 0.0, np.asarray(same_sign | other)
    return Box(
        *_around(l, either),
        none=np.asarray(~either.any(axis=(0, 1))),
        alone=alone,
        clear=clear,
        one=alone & clear & _single(same_sign, values[1]),
        missing=(values[0] < 0.0).any(axis=(0, 1)),
        curve=_changes(values[1], real) | _changes(values[2], real),
        left=np.moveaxis(same_sign, -1, 0),
        gap=np.moveaxis(values[1], -1, 0),
        lines=l,
    )


def _left(pairing: FlankPair, other: bool, least: FloatArray, most: FloatArray) -> tuple[Mask, Mask]:
    """Return which cells remain for the sign of n_x of the pair, or for the `other`, and in which n is not 0.

    Axial coordinates within the faces bound n: (D - face) n <= T <= (D + face) n for both members, with
    T = s (S + v B) n_x w and D = c - v A. Within these bounds F = A_1 + A_2 + s (P / n - E n) must reach
    zero, and n F as well.
    """
    # Rows of `_values` with T and D of the pinion, s P, and A_1 + A_2.
    rise_row, depth_row, pole_row, level_row = 3, 5, 7, 8
    # Half face widths within which contacts are near the faces.
    near_half_widths = 1.5
    sign = -pairing.branch[:, 0] if other else pairing.branch[:, 0]
    # Bounds of n from n^2.
    low, high = np.sqrt(np.maximum(least[0], 0.0)), np.sqrt(np.maximum(most[0], 0.0))
    bounds = (-most, -least) if other else (least, most)
    # Narrow the bounds by the axial coordinates of both members.
    for member in range(2):
        face = near_half_widths * pairing.half_width[member, :, 0]
        far, near = most[depth_row + member] + face, least[depth_row + member] - face
        for rise, rate in ((bounds[0][rise_row + member], far), (-bounds[1][rise_row + member], -near)):
            at = rise / rate
            low = np.where((rate > 0.0) & (at > low), at, low)
            high = np.where((rate < 0.0) & (at < high), at, high)
    # Interval of F over the remaining range of n.
    pole, offset = (bound[pole_row] for bound in bounds), sign * np.asarray(pairing.layout.offset)[:, 0]
    first, last = pole
    closing = np.minimum(-offset * low, -offset * high), np.maximum(-offset * low, -offset * high)
    lowest = least[level_row] + closing[0] + first / np.where(first < 0.0, low, high)
    highest = most[level_row] + closing[1] + last / np.where(last > 0.0, low, high)
    # Exclude cells without n, or in which n F or F keeps its sign.
    gap = 1 + int(other)
    vanishes = least[0] <= 0.0
    left = (most[0] > 0.0) & (low <= high) & (vanishes | ((least[gap] <= 0.0) & (most[gap] >= 0.0)))
    return left & ~(lowest > 0.0) & ~(highest < 0.0), low > 0.0


def _values(pairing: FlankPair, l: FloatArray) -> FloatArray:
    """Return the values at grid lines l (2, cases, nodes), mm: (9, nodes, nodes, cases).

    They are n_x^2, n F for the sign of n_x of the pair and for the other sign, T = s (S + v B) n_x w and
    D = c - v A of both members, s P, and A_1 + A_2. The sign s of T and s P is the sign of the pair.
    """
    terms, nodes = terms_of(pairing, l), l.shape[-1]
    # Terms of both members at all nodes of the grid.
    first, second = np.divmod(np.arange(nodes**2), nodes)
    v, square, moment, level, slope = (
        np.array((x[0][:, first], x[1][:, second]))
        for x in (terms.normal[2], terms.square, terms.moment, terms.level, terms.slope)
    )
    normal = common_normal(pairing.layout, v)
    reach = across_action(pairing.layout, v, square, normal, moment)
    # n F = odd + even for the sign of the pair, even - odd for the other.
    n_squared = np.maximum(normal.x_squared, 0.0)
    n = np.sqrt(n_squared)
    pole = pairing.branch * (slope[0] * reach[0] + slope[1] * reach[1])
    odd, level_sum = pole - pairing.branch * pairing.layout.offset * n_squared, level[0] + level[1]
    even = level_sum * n
    rise = pairing.branch * (square + v * slope) * reach
    depth = pairing.position - v * level
    rows = (normal.x_squared, even + odd, even - odd, *rise, *depth, pole, level_sum)
    return np.array([row.T for row in rows]).reshape(9, nodes, nodes, len(n))


def _bounds(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and largest values in cells (rows, nodes - 1, nodes - 1, cases) of functions (rows,
    nodes, nodes, cases).
    """
    near, far = values[:, 1:], values[:, :-1]
    least, most = np.minimum(near, far), np.maximum(near, far)
    slack = _bend(values)
    slack += _bend(values.swapaxes(1, 2)).swapaxes(1, 2)
    slack *= 0.5
    return (
        np.minimum(least[:, :, 1:], least[:, :, :-1]) - slack,
        np.maximum(most[:, :, 1:], most[:, :, :-1]) + slack,
    )


def _bend(values: FloatArray) -> FloatArray:
    """Return the largest second difference along the second axis of nodes near each cell."""
    bend = values[:, :, 2:] + values[:, :, :-2]
    bend -= 2.0 * values[:, :, 1:-1]
    np.abs(bend, out=bend)
    bend = np.maximum(bend[:, 1:], bend[:, :-1])
    return np.concatenate(
        (bend[:, :, :1], np.maximum(bend[:, :, 1:], bend[:, :, :-1]), bend[:, :, -1:]), axis=2
    )


def _changes(gap: FloatArray, real: Mask) -> Mask:
    """Return whether n F (nodes, nodes, cases) changes sign between nodes of which at least one is `real`."""
    below = np.signbit(gap)
    along = (below[1:] != below[:-1]) & (real[1:] | real[:-1])
    across = (below[:, 1:] != below[:, :-1]) & (real[:, 1:] | real[:, :-1])
    return np.asarray(along.any(axis=(0, 1)) | across.any(axis=(0, 1)))


def _around(l: FloatArray, left: Mask) -> tuple[FloatArray, FloatArray]:
    """Return bounds (2, cases, 1), mm, of the cells `left` (nodes - 1, nodes - 1, cases)."""
    bounds, case = [], np.arange(left.shape[-1])
    for member in range(2):
        line = np.asarray(left.any(axis=1 - member))
        ends = line.argmax(axis=0), len(line) - line[::-1].argmax(axis=0)
        bounds.append([l[member, case, end][:, None] for end in ends])
    (low, high), (other_low, other_high) = bounds
    return np.array((low, other_low)), np.array((high, other_high))


def _single(left: Mask, gap: FloatArray) -> Mask:
    """Return whether n F increases or decreases with l2 in all cells `left`, and whether these are adjacent
    for each l1.
    """
    # Monotone along l2 in all remaining cells, which are adjacent in each column.
    steps = np.diff(gap, axis=1)
    least, most = np.minimum(steps[1:], steps[:-1]), np.maximum(steps[1:], steps[:-1])
    rising, falling = ((least > 0.0) | ~left).all(axis=(0, 1)), ((most < 0.0) | ~left).all(axis=(0, 1))
    runs = left[:, 0] + (left[:, 1:] & ~left[:, :-1]).sum(axis=1)
    return np.asarray((rising | falling) & (runs <= 1).all(axis=0))
