"""Starting points for the search of the minimum clearance, from a scan.

On the flanks, the clearance is convex along the profile and nearly convex along the face, so that the local
minima of the scan lines lead to the true minima. Fillets are concave: close to a tangency on the flank, there
can be a second minimum where a tip edge touches the fillet of the mate, closer than the distance of scanned
points. Where a tip edge may touch a fillet, searches therefore start on the edge and next to it at every
station along the face. Nearly parallel flanks have a narrow valley of the clearance, and searches start at
both of its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.tooth_side import cut_at
from ...status import Limit
from ...support.array_records import joined
from .clearance_scan import Grid, Scan, Single
from .local_clearance import clearance_at, limits_at, local_at
from .search_task import Task

TIP_START_MODULES = 0.01
"""Clearance above the smallest one, in modules, up to which tip edges are starts."""
TIPS, INWARDS = np.array((Limit.GEAR_TIP, Limit.PINION_TIP)), np.array((1.0, -1.0))
"""Limits at the tips, and the sense along the pinion's profile that leads from these edges onto the flank."""
TIP_STEP_CELLS = 0.05, 0.25
"""First step along the profile from a tip edge on a fillet, and from the point next to it. Larger steps could
pass over the minimum."""
NEAR_FILLET_CELLS = 2.0
"""Distance, in cells along the profile, up to which a place counts as near a fillet or near a tip. Only
within this distance can a tip edge that lies on a fillet be less than one cell away."""


@dataclass(frozen=True, eq=False)
class SearchStarts:
    """Starting points of searches (n,).

    Attributes
    ----------
    row : ndarray of int, shape (n,)
        Index of the tooth pair in the task.
    periods : ndarray of int, shape (n,)
        Number of periods by which the reference roll of the gear is moved on (`Task.later`).
    place, box : ndarray, shape (2, n)
        s1 and z1, and half-widths of the first trust box, mm.
    """

    row: Integers
    periods: Integers
    place: FloatArray
    box: FloatArray

    def pick(self, index: Integers) -> SearchStarts:
        """Return the searches `index`."""
        return SearchStarts(*(value.take(index, axis=-1) for value in vars(self).values()))


def starts_of(task: Task, scan: Scan, grid: Grid, least: FloatArray, module: float) -> SearchStarts:
    """Select the starting points of a scan.

    Parameters
    ----------
    task : Task
    scan : Scan
        Of the tasks.
    grid : Grid
    least : ndarray, shape (tasks,)
        Smallest known clearance with which the starts of each tooth pair are compared, mm: that of all tooth
        pairs at the same position, or that of this tooth pair if each pair is solved alone. Minus infinity
        for no starts.
    module : float
        Normal module, mm.

    Returns
    -------
    SearchStarts
        Minima of scan lines, tip edges on fillets, and ends of valleys.
    """
    # Clearance above the smallest one, in modules, up to which scanned points are starts.
    start_modules = 0.05
    row, point = _line_starts(scan.f, grid.shape, least + start_modules * module)
    cell = np.array(grid.cell)[:, None]
    place = np.array((grid.s[point], grid.z[point]))
    periods = scan.periods[row, point].astype(np.int64)
    parts = [SearchStarts(row, periods, place, np.broadcast_to(cell, place.shape))]
    bound = least + start_modules * module, least + TIP_START_MODULES * module
    row, periods, place, inwards = _edge_starts(task, scan, grid, bound)
    for step, inside in zip(TIP_STEP_CELLS, (0.0, 1.0), strict=True):
        box = np.broadcast_to(cell * np.array(((step,), (1.0,))), place.shape)
        moved = np.array((inside * grid.cell[0] * inwards, 0.0 * inwards))
        parts.append(SearchStarts(row, periods, place + moved, box))
    parts.append(_valley_ends(task, scan, grid, bound[1], module))
    return joined(parts)


def _valley_ends(task: Task, scan: Scan, grid: Grid, bound: FloatArray, module: float) -> SearchStarts:
    """Return starts at both ends of the valley through the smallest scanned f of each tooth pair.

    A valley is used if f is within the `bound` (tasks,), and falls towards the ends or rises by less than
    1e-6 modules, so that the quadratic model is not certain of the minimum in between. Flanks that nearly
    touch along a line have such a valley from one edge to another. If f decreases towards both ends, the
    other starts can all lead to the same end."""
    point = scan.f.argmin(axis=1)
    least = scan.f[np.arange(point.size), point]
    row = np.flatnonzero(np.isfinite(least) & (least <= bound))
    point = point[row]
    periods = scan.periods[row, point].astype(np.int64)
    chosen, place = task.pick(row).later(periods), np.array((grid.s[point], grid.z[point]))
    # The valley runs along the smaller curvature of f. A Newton step across it leads to its bottom.
    here = local_at(chosen, *place)
    a, b, c = here.bend
    apart = np.hypot(0.5 * (a - c), b)
    lesser, greater = 0.5 * (a + c) - apart, 0.5 * (a + c) + apart
    along = np.where(np.abs(lesser - a) > np.abs(lesser - c), (b, lesser - a), (lesser - c, b))
    along = along / np.hypot(*along)
    across = np.array((-along[1], along[0]))
    fall = (here.slope * across).sum(axis=0)
    step = -fall / greater * across
    bottom = place + step
    # From there, it is nearly straight up to the nearest limit in both senses.
    margin, rate = here.margin + (here.rate * step).sum(axis=1), (here.rate * along).sum(axis=1)
    senses = np.array(((1.0,), (-1.0,)))
    falls = senses[:, None] * rate
    # f along the valley is quadratic: compare its rise over half of the length with 1e-6 modules.
    length = np.where(falls < 0.0, margin / -falls, np.inf).min(axis=1)
    extent = length.sum(axis=0)
    level = (greater > 0.0) & (lesser * extent**2 <= 8.0 * 1e-6 * module)
    known = np.flatnonzero(level & np.isfinite(extent) & (extent > 0.02 * grid.cell[0]))
    ends = bottom[:, None, known] + (senses * length[:, known]) * along[:, None, known]
    each, ends = np.tile(known, 2), ends.reshape(2, -1)
    cell = np.array(grid.cell)[:, None]
    box = np.clip(0.25 * np.abs(ends - bottom[:, each]), 0.02 * cell, 0.25 * cell)
    return SearchStarts(row[each], periods[each], ends, box)


def _line_starts(f: Single, shape: tuple[int, int], bound: FloatArray) -> tuple[Integers, Integers]:
    """Return tooth pairs and point numbers of the smallest local minima on the scan lines."""
    values, points = [], []
    f = f.reshape(-1, *shape)
    for axis in (1, 2):
        best = f.argmin(axis=axis)
        line = np.take_along_axis(f, np.expand_dims(best, axis), axis).squeeze(axis)  # faster than f.min
        low = np.ones(line.shape, dtype=bool)
        low[:, 1:] = line[:, 1:] <= line[:, :-1]
        low[:, :-1] &= line[:, :-1] <= line[:, 1:]
        line = np.where(low, line, np.inf)
        # Three minima per direction, more on wide faces: a tooth that winds round its axis has one a turn.
        chosen = line.argsort(axis=1)[:, : max(3, shape[1] // 8)]
        crossing = np.take_along_axis(best, chosen, axis=1)
        points.append(crossing * shape[1] + chosen if axis == 1 else chosen * shape[1] + crossing)
        values.append(np.take_along_axis(line, chosen, axis=1))
    value, point = np.concatenate(values, axis=1), np.concatenate(points, axis=1)
    # Remove points that are a minimum of both of their lines once.
    for k in range(1, point.shape[1]):
        again = (point[:, k : k + 1] == point[:, :k]).any(axis=1)
        value[again, k] = np.inf
    row, column = np.nonzero(np.isfinite(value) & (value <= bound[:, None]))
    return row, point[row, column]


def _edge_starts(
    task: Task, scan: Scan, grid: Grid, bound: tuple[FloatArray, FloatArray]
) -> tuple[Integers, Integers, FloatArray, FloatArray]:
    """Return starts on tip edges near the fillet of the mate, at every station along the face: tooth
    pairs, periods, places (2, n), and the sense that leads onto the flank. The scanned point closest to
    the edge must be within the first bound (tasks,), the point on the edge within the second."""
    rows, points, tips = [], [], []
    for number, (away, first) in enumerate(((scan.gear_tip, 0), (scan.pinion_tip, grid.shape[0] - 1))):
        lines = away.reshape(len(away), away.shape[1] // grid.shape[1], grid.shape[1])
        row, station = np.nonzero(np.isfinite(lines.min(axis=1)))
        point = (lines[row, :, station].argmin(axis=1) + first) * grid.shape[1] + station
        near = np.isfinite(scan.f[row, point]) & (scan.f[row, point] <= bound[0][row])
        rows.append(row[near])
        points.append(point[near])
        tips.append(np.full(rows[-1].size, number))
    row, point, tip = (np.concatenate(parts) for parts in (rows, points, tips))
    periods = scan.periods[row, point].astype(np.int64)
    place, chosen = np.array((grid.s[point], grid.z[point])), task.pick(row).later(periods)
    if not row.size:
        return row, periods, place, np.zeros(0)
    place = _on_edge(chosen, place, tip)
    f, slope, _ = clearance_at(chosen, *place)
    # The edge is no minimum if f decreases clearly from it onto the flank.
    close = (f <= bound[1][row]) & (-INWARDS[tip] * slope[0] < 0.03)
    return row[close], periods[close], place[:, close], INWARDS[tip[close]]


def _on_edge(task: Task, place: FloatArray, tip: Integers) -> FloatArray:
    """Return places (2, n) moved along the profile by Newton's method to the edges of the TIPS with the
    numbers `tip` (n,), and to within the gear's toe and heel."""
    # Step, in tooth depths, after which the next one is expected below a thousandth.
    last_step_depths = 0.03
    place, limit, each = place.copy(), TIPS[tip], np.arange(tip.size)
    for _ in range(4):  # two steps, and two more across a joint
        before = place.copy()
        margin, rate = limits_at(task, *place)
        s = place[0] - _or_nothing(margin[limit, each] / rate[limit, 0, each])
        # The rate along the profile jumps at the joint: a step that would cross it ends just beyond it.
        joint, below = task.pinion.joint, task.pinion.joint - 1e-9 * task.depth
        on_flank = place[0] >= joint
        place[0] = np.where(on_flank, np.where(s < joint, np.maximum(s, below), s), np.minimum(s, joint))
        for end in (Limit.GEAR_TOE, Limit.GEAR_HEEL):
            place[1] -= _or_nothing(np.minimum(margin[end], 0.0) / rate[end, 1])
        small = np.abs(place - before) <= last_step_depths * task.depth
        if (small.all(axis=0) & (place[0] == s)).all():
            break
    return place


def _or_nothing(steps: FloatArray) -> FloatArray:
    """Return steps, with 0 for steps that are not finite."""
    return np.where(np.isfinite(steps), steps, 0.0)


def near_fillets(task: Task, starts: SearchStarts, grid: Grid) -> Mask:
    """Return which searches start on or near a fillet.

    Parameters
    ----------
    task : Task
    starts : SearchStarts
        Searches (n,).
    grid : Grid

    Returns
    -------
    ndarray of bool, shape (n,)
        Whether the start is on a fillet of either member, or less than NEAR_FILLET_CELLS away.
    """
    chosen, spare = task.pick(starts.row), NEAR_FILLET_CELLS * grid.cell[0]
    met = clearance_at(chosen, *starts.place)[2]
    start = task.pinion.flank_start(starts.place[1])
    return np.asarray((starts.place[0] < start + spare) | ~(met >= task.gear.joint + spare))


def tip_edge_starts(task: Task, place: FloatArray, grid: Grid) -> SearchStarts:
    """Return additional starts next to minima that were computed.

    Parameters
    ----------
    task : Task
        Of the minima (n,).
    place : ndarray, shape (2, n)
        s1 and z1 of the minima, mm.
    grid : Grid

    Returns
    -------
    SearchStarts
        If a tip edge at the same position along the face is on a fillet and less than a cell away: one start
        on this edge, and one half a cell from it towards the flank. `row` is the index of the minimum.
    """
    pinion, cell = task.pinion, np.array(grid.cell)[:, None]
    # Only minima near a fillet can have an edge on it within a cell.
    above = place[0] - pinion.flank_start(place[1])
    below_tip = pinion.tip + pinion.taper * place[1] - np.sqrt(cut_at(pinion, *place).square)
    to_limits = np.stack((above, below_tip))
    tip, close = np.nonzero(to_limits < NEAR_FILLET_CELLS * grid.cell[0])
    edge, gap = place[:, close], np.full(close.size, np.inf)
    if close.size:
        near = task.pick(close)
        edge = _on_edge(near, edge, tip)
        met = clearance_at(near, *edge)[2]
        # On an undercut tooth, the fillet extends up to the undercut edge.
        gap = np.where(tip == 0, edge[0] - pinion.flank_start(edge[1]), met - task.gear.joint)
    away, parts = np.abs(edge[0] - place[0, close]), []
    for step, inside, least in zip(TIP_STEP_CELLS, (0.0, 0.5), (1e-6 * cell[0, 0], 0.0), strict=True):
        row = np.flatnonzero((away >= least) & (away < grid.cell[0]) & (gap < 0.0))
        moved = edge[:, row] + np.array((inside * grid.cell[0] * INWARDS[tip[row]], np.zeros(row.size)))
        box = np.broadcast_to(cell * np.array(((step,), (1.0,))), moved.shape)
        parts.append(SearchStarts(close[row], np.zeros_like(row), moved, box))
    return joined(parts)
