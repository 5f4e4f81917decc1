"""Scans of the clearance over a tooth of the pinion, and where to start a search for its least.

The clearance (`least_clearance`) is convex along the profile of ordinary flanks and nearly so along the
face, so that the local least values of a scan's lines lead to the true ones. Fillets are concave:
beside a tangency on the flank there may be another least at the edge of a tip on the other's
fillet, closer by than any scan tells apart. Where a tip's edge may touch a fillet, searches start
on the edge and beside it at every station along the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..design.model import Member
from ..gear.flank import tip_parameter
from ..gear.tooth_side import Surface, angle_of, cut_at
from ..status import Limit
from .least_clearance import Task, limits_at, local_at
from .separation import BLOCK, met_by, seen_by_other

STARTS, STATIONS = 3, 8
"""Local least values that are followed of each scan line, along the face and along the profile; stations
along the face for each of them, if that is more: a tooth that winds round its axis is met on every turn."""
SPARE, TIP_SPARE = 0.05, 0.01
"""Modules by which a scanned point, and an edge on a fillet, may stand further off than the nearest
scanned and still be a start."""
TIPS = ((Limit.GEAR_TIP, 1.0), (Limit.PINION_TIP, -1.0))
"""Tips, and which way along the pinion's profile leads from their edges onto the flank."""
FILLET_STEPS = 1.8
"""Points on a fillet for each cell of its length."""
EDGE_PASSES = 3
TIP_SLOPE = 0.03
"""A tip's edge is no start where the clearance falls faster than this from it along the profile."""
FURTHEST = 2.0
"""Cells from a fillet, or below a tip, from where on no edge on a fillet is less than a cell away."""
TIP_REACH, TIP_STEPS = 0.05, (0.05, 0.25)
"""Shares of a cell: how far from a fillet a tip's edge still counts as on it, and how far a step may
go along the profile from such an edge and from beside it, lest it leap over what is looked for."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Points of the pinion's surface for a scan, (n,): coordinates s, z, radius, angle; `shape`
    (profile, face); `cell`: steps along s and z, mm."""

    s: FloatArray
    z: FloatArray
    radius: FloatArray
    angle: FloatArray
    shape: tuple[int, int]
    cell: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Scan:
    """Scanned tooth pairs (n,): `f` (n, points), mm, infinite further outside than half a cell;
    `at_tips` (n, 2, points): distance, mm, from the gear's and the pinion's tip edge, finite where
    it is near the other's fillet; the least f `within` the limits; whether a tip and a `bottom` land meet.
    `periods` (n, points): how many periods of the task after its start f is counted from."""

    f: FloatArray
    periods: Integers
    at_tips: FloatArray
    within: FloatArray
    bottom: Mask


@dataclass(frozen=True, eq=False)
class Starts:
    """Searches (n,): the number of the tooth pair, `periods` of its task to count from, the `place`
    (2, n): s1 and z1, and the `box` (2, n) for the first step, mm."""

    row: Integers
    periods: Integers
    place: FloatArray
    box: FloatArray


def grid_of(own: Surface, member: Member, flank: str, points: tuple[int, int, int]) -> Grid:
    """Give fillet and flank of the pinion with `points` on the fillet, on the flank and along the face; more
    on the fillet, up to as many as on the flank, where a step of them would rise by more than a cell."""
    fillet, profile, face = points
    cell = ((own.highest - own.joint) / (profile - 1), 2.0 * own.half_width / (face - 1))
    fillet = max(fillet, int(min(np.nan_to_num(FILLET_STEPS * (own.joint - own.bottom) / cell[0]), profile)))
    z = own.half_width * np.linspace(-1.0, 1.0, face)
    top = np.fmin(tip_parameter(member, flank, z), own.highest + 0.0 * z)
    below = np.linspace(1.0, 0.0, fillet + 1)[:-1, None] ** 2  # a fillet is steepest beside the flank
    low = own.joint - (own.joint - own.bottom) * below
    high = own.joint + (top - own.joint) * np.linspace(0.0, 1.0, profile)[:, None]
    s = np.concatenate((low + 0.0 * z, high))
    z = np.broadcast_to(z, s.shape)
    cut = cut_at(own, s, z)
    s, z, radius, angle = (x.reshape(-1) for x in (s, z, np.sqrt(cut.square), angle_of(cut)))
    return Grid(s, z, radius, angle, shape=(fillet + profile, face), cell=cell)


def scan_of(task: Task, grid: Grid, turns: bool = True) -> Scan:
    """Give the clearance at the points of a grid, for every tooth pair of the task; with `turns` also where
    the same teeth meet again periods later."""
    other, n, reach = task.other, grid.s.size, TIP_REACH * grid.cell[0]
    turned = grid.angle + task.roll[:, None]
    pose = task.pose.at(np.arange(len(task.roll))[:, None])
    x, y, z = seen_by_other(pose, 0, grid.radius * np.cos(turned), grid.radius * np.sin(turned), grid.z)
    r = np.hypot(x, y)
    root, above = r - other.root - other.root_taper * z, r - other.tip - other.taper * z
    outside = np.maximum(np.maximum(above, 0.0) / grid.cell[0], (np.abs(z) - other.half_width) / grid.cell[1])
    f, other_s = np.full(r.shape, np.inf), np.full(r.shape, np.inf)
    periods = np.zeros(r.shape, dtype=np.int64)
    near = np.flatnonzero((outside <= 0.5) & (root > 0.0))
    x, y, z, start = x.reshape(-1)[near], y.reshape(-1)[near], z.reshape(-1)[near], task.start[near // n]
    for first in range(0, near.size, BLOCK):
        part = slice(first, first + BLOCK)
        angle, _, met, _, _ = met_by(other, x[part], y[part], z[part], start[part])
        angle = task.counted(angle)
        before = np.nan_to_num(np.floor((angle - task.earliest) / task.period))
        angle -= before * task.period
        periods.reshape(-1)[near[part]] = other.sigma * before
        lost = np.isnan(angle) if turns else np.isnan(angle) | (before != 0.0)
        f.reshape(-1)[near[part]] = np.where(lost, np.inf, angle * task.lever)
        other_s.reshape(-1)[near[part]] = met
    # Nearly a millimetre along the profile is a millimetre of the other's radius.
    deep = (np.abs(above) <= 0.5 * grid.cell[0]) & (grid.s + above < task.own.joint + reach)
    tip = (np.arange(n) >= n - grid.shape[1]) & (other_s < other.joint + reach)
    within = outside <= 0.0
    bottom = (within & ((root < 0.0) | (grid.s <= task.own.bottom))).any(axis=1)
    return Scan(
        f=f,
        periods=periods,
        at_tips=np.stack((np.where(deep, np.abs(above), np.inf), np.where(tip, 0.0, np.inf)), axis=1),
        within=np.where(within, f, np.inf).min(axis=1),
        bottom=np.asarray(bottom),
    )


def starts_of(task: Task, scan: Scan, grid: Grid, least: FloatArray, module: float) -> Starts:
    """Say where to search, given the least f of each tooth pair's position that is known so far, (tasks,)."""
    row, point = _line_starts(scan.f, grid.shape, least + SPARE * module)
    cell = np.array(grid.cell)[:, None]
    place = np.stack((grid.s[point], grid.z[point]))
    parts = [Starts(row, scan.periods[row, point], place, np.broadcast_to(cell, place.shape))]
    bound = least + SPARE * module, least + TIP_SPARE * module
    for k, (tip, inwards) in enumerate(TIPS):
        row, periods, place = _edge_starts(task, scan, scan.at_tips[:, k], grid, bound, tip)
        for step, moved in zip(TIP_STEPS, (0.0, inwards * grid.cell[0]), strict=True):
            box = np.broadcast_to(cell * np.array(((step,), (1.0,))), place.shape)
            parts.append(Starts(row, periods, place + np.array(((moved,), (0.0,))), box))
    return Starts(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))


def _line_starts(f: FloatArray, shape: tuple[int, int], bound: FloatArray) -> tuple[Integers, Integers]:
    """Give tooth pairs and point numbers of the least local least values of the scan lines."""
    values, points = [], []
    f = f.reshape(-1, *shape)
    for axis in (1, 2):
        best = f.argmin(axis=axis)
        line = f.min(axis=axis)
        wide = np.pad(line, ((0, 0), (1, 1)), constant_values=np.inf)
        line = np.where((line <= wide[:, :-2]) & (line <= wide[:, 2:]), line, np.inf)
        chosen = line.argsort(axis=1)[:, : max(STARTS, shape[1] // STATIONS)]
        other = np.take_along_axis(best, chosen, axis=1)
        points.append(other * shape[1] + chosen if axis == 1 else chosen * shape[1] + other)
        values.append(np.take_along_axis(line, chosen, axis=1))
    value, point = np.concatenate(values, axis=1), np.concatenate(points, axis=1)
    for k in range(1, point.shape[1]):
        again = (point[:, k : k + 1] == point[:, :k]).any(axis=1)
        value[again, k] = np.inf
    row, column = np.nonzero(np.isfinite(value) & (value <= bound[:, None]))
    return row, point[row, column]


def _edge_starts(
    task: Task, scan: Scan, away: FloatArray, grid: Grid, bound: tuple[FloatArray, FloatArray], tip: Limit
) -> tuple[Integers, Integers, FloatArray]:
    """Give tooth pairs, their periods and places (2, n) of a tip's edge near the other's fillet, at every
    station along the face: the scanned points least `away` from it (tasks, points), if f is within the first
    bound (tasks,) there, moved on to the edge, where f is within the second."""
    lines = away.reshape(-1, *grid.shape)
    row, station = np.nonzero(np.isfinite(lines.min(axis=1)))
    point = lines[row, :, station].argmin(axis=1) * grid.shape[1] + station
    near = np.isfinite(scan.f[row, point]) & (scan.f[row, point] <= bound[0][row])
    row, point = row[near], point[near]
    periods = scan.periods[row, point]
    place, chosen = np.stack((grid.s[point], grid.z[point])), task.pick(row).later(periods)
    if not row.size:
        return row, periods, place
    place = _on_edge(chosen, place, tip)
    here = local_at(chosen, *place)
    falls = here.slope[0] if tip == Limit.PINION_TIP else -here.slope[0]
    close = (here.f <= bound[1][row]) & (falls < TIP_SLOPE)
    return row[close], periods[close], place[:, close]


def _on_edge(task: Task, place: FloatArray, tip: Limit) -> FloatArray:
    """Give places (2, n) moved along the profile to a tip's edge, and between the gear's toe and heel."""
    place = place.copy()
    for _ in range(EDGE_PASSES):
        margin, rate = limits_at(task, *place)
        place[0] -= np.nan_to_num(margin[tip] / rate[tip, 0])
        for end in (Limit.GEAR_TOE, Limit.GEAR_HEEL):
            place[1] -= np.nan_to_num(np.minimum(margin[end], 0.0) / rate[end, 1])
    return place


def beside_fillets(task: Task, place: FloatArray, grid: Grid) -> Starts:
    """Give more starts from what was found: at the same station on a tip's edge if it is on a fillet less
    than a cell away, and beside that fillet. `row` counts the places (2, n) of the tasks."""
    own, cell, none = task.own, np.array(grid.cell)[:, None], np.zeros(0, dtype=np.int64)
    parts = [Starts(none, none, place[:, :0], place[:, :0])]
    for tip, inwards in TIPS:
        # From further off no edge within a cell lies on a fillet.
        room = place[0] - own.joint
        if tip == Limit.PINION_TIP:
            room = own.tip + own.taper * place[1] - np.sqrt(cut_at(own, *place).square)
        close = np.flatnonzero(room < FURTHEST * grid.cell[0])
        if not close.size:
            continue
        near = task.pick(close)
        edge = _on_edge(near, place[:, close], tip)
        meeting = local_at(near, *edge).meeting
        gap = edge[0] - own.joint if tip == Limit.GEAR_TIP else meeting[0] - task.other.joint
        away = np.abs(edge[0] - place[0, close])
        for step, inside, least in zip(TIP_STEPS, (0.0, 0.5), (1e-6 * cell[0, 0], 0.0), strict=True):
            row = np.flatnonzero((away >= least) & (away < grid.cell[0]) & (gap < 0.0))
            moved = inside * inwards * grid.cell[0]
            moved_place = edge[:, row] + np.array(((moved,), (0.0,)))
            box = np.broadcast_to(cell * np.array(((step,), (1.0,))), moved_place.shape)
            parts.append(Starts(close[row], np.zeros_like(row), moved_place, box))
    return Starts(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))
