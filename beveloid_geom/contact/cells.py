"""Where in l1 and l2 contacts near the faces can lie: cells of a grid that signs do not rule out.

F(l1, l2) = 0 (`contact`) for either sign of n_x, and the heights z_j at which the members then touch,
run to infinity where n_x vanishes. With n = |n_x|, s its sign and R_j = n_x w_j,

    n F   = s (P - E n^2) + (A_1 + A_2) n,      P = B_1 R_1 + B_2 R_2,
    n z_j = s (S_j + v_j B_j) R_j - (c_j - v_j A_j) n

do not, and n^2 as well as all that stands before n or behind s is smooth in l1 and l2. A cell in which n F
keeps its sign holds no contact; nor does one in which no n lets both members touch near their faces, or F
stays off zero for all n that do. Bounds in a cell are those of its four corners, and SLACK of the second
differences about them: a smooth function strays from its corners by an eighth of these, the root n by
half at most. Where n_x^2 vanishes within a cell n F is no longer smooth there, and its sign is not asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..gear.rack import rack_normal
from ..pair.frames import common_normal
from ..pair.mounting import across_action
from .equation import Pairing, terms_of

NODES = 9
"""Grid lines of each member, unless more are asked for."""
RISE, DEPTH, POLE, LEVEL = 3, 5, 7, 8
"""Rows of the values at the nodes, after n_x^2 and n F for both signs of n_x."""
CASES_PER_BLOCK = 128
"""So many stay in the cache."""
FACES = 1.5
"""Half face widths within which contacts count as near."""
SLACK = 0.5
VANISHING = 1e-13
"""n_x^2 that may be but rounding."""
BEYOND = 0.05
"""How far, in flank depths, the window of l1 and l2 reaches beyond root and tip."""

Mask = NDArray[np.bool_]
AXES = {"low": 1, "high": 1, "lines": 1}
"""Axes of cases in a `Box` that are not the first."""


@dataclass(frozen=True, eq=False)
class Box:
    """What is left of a window in l1 and l2, by case.

    `low`, `high` (2, cases, 1), mm, bound the cells left for either sign of n_x. (cases): whether `none` is;
    whether they are of the pairing's own sign of n_x `alone`, and n_x does not vanish in these (`clear`);
    whether they hold contacts of `one` curve: both, and no more than one for each l1. Of the whole window:
    whether some normal is `missing`, and whether there is a `curve` of contacts, near the faces or not.

    For the own sign: which cells (cases, nodes - 1, nodes - 1) are `left`, and `gap` (cases, nodes, nodes),
    n F on `lines` (2, cases, nodes), mm."""

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

    def cases(self, index: NDArray[np.int_]) -> Box:
        """Give what is left of the cases `index`."""
        return Box(**{name: x.take(index, AXES.get(name, 0)) for name, x in vars(self).items()})


def window_of(pairing: Pairing) -> tuple[FloatArray, FloatArray]:
    """Give bounds (2, cases, 1) of the window in l1 and l2, mm."""
    slack = BEYOND * (pairing.highest - pairing.lowest)
    shape = (2, *pairing.branch.shape)
    return (
        np.broadcast_to(pairing.lowest - slack, shape),
        np.broadcast_to(pairing.highest + slack, shape),
    )


def vanishing(pairing: Pairing) -> Mask:
    """Say whether n_x is 0 to rounding all over the window: the flanks then touch along lines, or nowhere."""
    low, high = window_of(pairing)
    l = np.concatenate((low, high, 0.5 * (low + high)), axis=-1)
    x_squared = common_normal(pairing.layout, rack_normal(pairing.rack, l)[2]).x_squared
    return np.asarray((np.abs(x_squared) < VANISHING).all(axis=-1))


def box_of(pairing: Pairing, low: FloatArray, high: FloatArray, both: bool = True, nodes: int = NODES) -> Box:
    """Give what signs on the grid leave of the window from `low` to `high` (2, cases, 1), mm, for `both`
    signs of n_x or the pairing's own, by so many `nodes` along l1 and l2."""
    size = max(1, CASES_PER_BLOCK * NODES**2 // nodes**2)
    parts = [slice(start, start + size) for start in range(0, max(1, low.shape[1]), size)]
    found = [_box(pairing.cases(part), low[:, part], high[:, part], both, nodes) for part in parts]
    columns = {name: [getattr(box, name) for box in found] for name in vars(found[0])}
    return Box(**{name: np.concatenate(x, axis=AXES.get(name, 0)) for name, x in columns.items()})


def _box(pairing: Pairing, low: FloatArray, high: FloatArray, both: bool, nodes: int) -> Box:
    """Give what is left; below, grids and cells have the cases as their last axis, along which NumPy runs."""
    l = low + np.linspace(0.0, 1.0, nodes) * (high - low)
    values = _values(pairing, l)
    least, most = _bounds(values)
    own, clear = _left(pairing, False, least, most)
    other = _left(pairing, True, least, most)[0] if both else np.zeros_like(own)
    alone, clear = np.asarray(~other.any(axis=(0, 1))), np.asarray((clear | ~own).all(axis=(0, 1)))
    real, either = values[0] > 0.0, np.asarray(own | other)
    return Box(
        *_around(l, either),
        none=np.asarray(~either.any(axis=(0, 1))),
        alone=alone,
        clear=clear,
        one=alone & clear & _single(own, values[1]),
        missing=(values[0] < 0.0).any(axis=(0, 1)),
        curve=_changes(values[1], real) | _changes(values[2], real),
        left=np.moveaxis(own, -1, 0),
        gap=np.moveaxis(values[1], -1, 0),
        lines=l,
    )


def _left(pairing: Pairing, other: bool, least: FloatArray, most: FloatArray) -> tuple[Mask, Mask]:
    """Say which cells are left for the pairing's sign of n_x, or the `other`, and in which n is not 0.

    Heights within the faces bound n: (D - face) n <= s R <= (D + face) n for both members, R their rise and
    D = c - v A. Within these bounds F = A_1 + A_2 + s (P / n - E n) must reach zero, and n F as well."""
    sign = -pairing.branch[:, 0] if other else pairing.branch[:, 0]
    low, high = np.sqrt(np.maximum(least[0], 0.0)), np.sqrt(np.maximum(most[0], 0.0))
    bounds = (-most, -least) if other else (least, most)
    for member in range(2):
        face = FACES * pairing.half_width[member, :, 0]
        far, near = most[DEPTH + member] + face, least[DEPTH + member] - face
        for rise, rate in ((bounds[0][RISE + member], far), (-bounds[1][RISE + member], -near)):
            at = rise / rate
            low = np.where((rate > 0.0) & (at > low), at, low)
            high = np.where((rate < 0.0) & (at < high), at, high)
    pole, offset = (bound[POLE] for bound in bounds), sign * np.asarray(pairing.layout.offset)[:, 0]
    first, last = pole
    closing = np.minimum(-offset * low, -offset * high), np.maximum(-offset * low, -offset * high)
    lowest = least[LEVEL] + closing[0] + first / np.where(first < 0.0, low, high)
    highest = most[LEVEL] + closing[1] + last / np.where(last > 0.0, low, high)
    gap = 1 + int(other)
    vanishes = least[0] <= 0.0
    left = (most[0] > 0.0) & (low <= high) & (vanishes | ((least[gap] <= 0.0) & (most[gap] >= 0.0)))
    return left & ~(lowest > 0.0) & ~(highest < 0.0), low > 0.0


def _values(pairing: Pairing, l: FloatArray) -> FloatArray:
    """Give n_x^2, n F for the pairing's sign of n_x and the other, R and D of both members, P, and A_1 + A_2,
    what changes with the sign for the own one: (9, nodes, nodes, cases) at grid lines l (2, cases, nodes),
    mm."""
    terms, nodes = terms_of(pairing, l), l.shape[-1]
    first, second = np.divmod(np.arange(nodes**2), nodes)
    v, square, moment, level, slope = (
        np.array((x[0][:, first], x[1][:, second]))
        for x in (terms.own[2], terms.square, terms.moment, terms.level, terms.slope)
    )
    normal = common_normal(pairing.layout, v)
    reach = across_action(pairing.layout, v, square, normal.y, moment)
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
    """Give the least and greatest values in cells (rows, nodes - 1, nodes - 1, cases) of functions (rows,
    nodes, nodes, cases)."""
    near, far = values[:, 1:], values[:, :-1]
    least, most = np.minimum(near, far), np.maximum(near, far)
    slack = _bend(values)
    slack += _bend(values.swapaxes(1, 2)).swapaxes(1, 2)
    slack *= SLACK
    return (
        np.minimum(least[:, :, 1:], least[:, :, :-1]) - slack,
        np.maximum(most[:, :, 1:], most[:, :, :-1]) + slack,
    )


def _bend(values: FloatArray) -> FloatArray:
    """Give the greatest second difference along the second axis of nodes about each cell."""
    bend = values[:, :, 2:] + values[:, :, :-2]
    bend -= 2.0 * values[:, :, 1:-1]
    np.abs(bend, out=bend)
    bend = np.maximum(bend[:, 1:], bend[:, :-1])
    return np.concatenate(
        (bend[:, :, :1], np.maximum(bend[:, :, 1:], bend[:, :, :-1]), bend[:, :, -1:]), axis=2
    )


def _changes(gap: FloatArray, real: Mask) -> Mask:
    """Say whether n F (nodes, nodes, cases) changes its sign between nodes of which one is `real`."""
    below = np.signbit(gap)
    along = (below[1:] != below[:-1]) & (real[1:] | real[:-1])
    across = (below[:, 1:] != below[:, :-1]) & (real[:, 1:] | real[:, :-1])
    return np.asarray(along.any(axis=(0, 1)) | across.any(axis=(0, 1)))


def _around(l: FloatArray, left: Mask) -> tuple[FloatArray, FloatArray]:
    """Give bounds (2, cases, 1), mm, of the cells `left` (nodes - 1, nodes - 1, cases)."""
    bounds, case = [], np.arange(left.shape[-1])
    for member in range(2):
        line = np.asarray(left.any(axis=1 - member))
        ends = line.argmax(axis=0), len(line) - line[::-1].argmax(axis=0)
        bounds.append([l[member, case, end][:, None] for end in ends])
    (low, high), (other_low, other_high) = bounds
    return np.array((low, other_low)), np.array((high, other_high))


def _single(left: Mask, gap: FloatArray) -> Mask:
    """Say whether n F rises or falls with l2 all over the cells `left`, and whether these lie side by side
    for each l1."""
    steps = np.diff(gap, axis=1)
    least, most = np.minimum(steps[1:], steps[:-1]), np.maximum(steps[1:], steps[:-1])
    rising, falling = ((least > 0.0) | ~left).all(axis=(0, 1)), ((most < 0.0) | ~left).all(axis=(0, 1))
    runs = left[:, 0] + (left[:, 1:] & ~left[:, :-1]).sum(axis=1)
    return np.asarray((rising | falling) & (runs <= 1).all(axis=0))
