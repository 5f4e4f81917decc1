"""Scans of the clearance over a tooth of the pinion, and where to start a search for its least.

A scan takes the clearance of a point from the angle between it and the gear's surface at its radius and
height. A chart holds the angles of that surface at nodes over radius and height; between them they are
interpolated, which takes no equation to be solved. Scans reckon in single precision. The error of a chart is
measured in the middle of its meshes, and every point that may be the least within SAFE times that, and
what single precision leaves, is evaluated in double: the least is exact.

The clearance (`least_clearance`) is convex along the profile of ordinary flanks and nearly so along the
face, so that the local least values of a scan's lines lead to the true ones. Fillets are concave:
beside a tangency on the flank there may be another least at the edge of a tip on the other's
fillet, closer by than any scan tells apart. Where a tip's edge may touch a fillet, searches start
on the edge and beside it at every station along the face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Integers, Mask
from ..design.model import Member
from ..gear.flank import tip_parameter
from ..gear.tooth_side import Surface, angle_of, cut_at, profile_at, surface_of
from ..status import Limit
from ..support.read_only import kept
from .least_clearance import Task, clearance_at, limits_at
from .separation import met_by

STARTS, STATIONS = 3, 8
"""Local least values that are followed of each scan line, along the face and along the profile; stations
along the face for each of them, if that is more: a tooth that winds round its axis is met on every turn."""
SPARE, TIP_SPARE = 0.05, 0.01
"""Modules by which a scanned point, and an edge on a fillet, may stand further off than the nearest
scanned and still be a start."""
TIPS, INWARDS = np.array((Limit.GEAR_TIP, Limit.PINION_TIP)), np.array((1.0, -1.0))
"""Tips, and which way along the pinion's profile leads from their edges onto the flank."""
EDGE_PASSES = 2
TIP_SLOPE = 0.03
"""A tip's edge is no start where the clearance falls faster than this from it along the profile."""
FURTHEST = 2.0
"""Cells from a fillet, or below a tip, from where on no edge on a fillet is less than a cell away."""
TIP_STEPS = 0.05, 0.25
"""Shares of a cell: how far a step may go along the profile from a tip's edge on a fillet and from beside it,
lest it leap over what is looked for."""
FILLET_STEPS = 1.8
"""Points on a fillet for each cell of its length."""
TIP_REACH = 0.05
"""Share of a cell: how far from a fillet a tip's edge still counts as on it."""
NODES = 128, 12
"""Nodes of a chart, by radius and along the face."""
SAFE = 2.0
"""Times the error seen in the middle of a chart's meshes that it may have anywhere."""
BLOCK = 24576
"""Points taken at a time, so that the arrays stay in the cache."""
LARGE = 1e30
"""Less than infinite."""
ROUNDING = 1e-6
"""What single precision, with which scans reckon, leaves of an angle, rad, and of places, over their size."""
Single: TypeAlias = NDArray[np.float32]
Angles = TypeVar("Angles", Single, FloatArray)


@dataclass(frozen=True, eq=False)
class Grid:
    """Points of the pinion's surface for a scan: `points` (4, n): x, y, z in the own frame at roll 0, and 1,
    and `about` the same in single precision; their profile coordinate `s` and `z` (n,); `shape` (profile,
    face); `cell`: steps along s and z, mm. Of the lines along the face only the first ones, `low` in number,
    have points less than half a cell above the joint or below it."""

    points: FloatArray
    about: Single
    s: FloatArray
    z: FloatArray
    shape: tuple[int, int]
    cell: tuple[float, float]
    low: int


@dataclass(frozen=True, eq=False)
class Chart:
    """Angles (rad) of a surface about its axis, in single precision, over meshes between NODES at equal steps
    of the root of the height above its root cone from 0 on and of z from `start` (mm) on; nodes a `rate` of
    these. `parts` (4, meshes): the angle at the first node, and how it grows along either side of the mesh
    and, beyond that, towards the last node. `error` (rad)."""

    parts: Single
    start: float
    rate: tuple[float, float]
    error: float

    def at(self, above: Single, z: Single) -> Single:
        """Give angles (rad) of points by their height `above` the root cone and z, mm."""
        across, along = np.sqrt(above) * self.rate[0], (z - self.start) * self.rate[1]
        first = np.minimum(np.floor(across), NODES[0] - 2)
        second = np.minimum(np.floor(along), NODES[1] - 2)
        across -= first
        along -= second
        first *= NODES[1] - 1
        first += second
        mesh = first.astype(np.intp)
        angle, on, out, both = (part.take(mesh, mode="clip") for part in self.parts)
        on *= along
        angle += on
        both *= along
        out += both
        out *= across
        angle += out
        return np.asarray(angle)


@dataclass(frozen=True, eq=False)
class Scan:
    """Scanned tooth pairs (n,): `f` (n, points), mm, in single precision, infinite further outside than half
    a cell; distance, mm, from tips' edges where these are near the other's fillet, or infinite: of the
    gear's, `gear_tip` (n, low points), and of the pinion's, 0 on its edge, `pinion_tip` (n, face); the least
    f `within` the limits; whether a tip and a `bottom` land meet. `periods` (n, points): how many periods of
    the task after its start f is counted from."""

    f: Single
    periods: Integers
    gear_tip: Single
    pinion_tip: Single
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


@kept(64)
def grid_of(member: Member, flank: str, points: tuple[int, int, int]) -> Grid:
    """Give fillet and flank of the pinion with `points` on the fillet, on the flank and along the face; more
    on the fillet, up to as many as on the flank, where a step of them would rise by more than a cell."""
    own, (fillet, profile, face) = surface_of(member, flank), points
    cell = ((own.highest - own.joint) / (profile - 1), 2.0 * own.half_width / (face - 1))
    fillet = max(fillet, int(min(np.nan_to_num(FILLET_STEPS * (own.joint - own.bottom) / cell[0]), profile)))
    z = own.half_width * np.linspace(-1.0, 1.0, face)
    top = np.fmin(tip_parameter(member, flank, z), own.highest + 0.0 * z)
    below = np.linspace(1.0, 0.0, fillet + 1)[:-1, None] ** 2  # a fillet is steepest beside the flank
    low = own.joint - (own.joint - own.bottom) * below
    high = own.joint + (top - own.joint) * np.linspace(0.0, 1.0, profile)[:, None]
    s = np.concatenate((low + 0.0 * z, high))
    deep = (s < own.joint + (0.5 + TIP_REACH) * cell[0]).any(axis=1)
    shape, s, z = s.shape, s.ravel(), np.broadcast_to(z, s.shape).ravel()
    cut = cut_at(own, s, z)
    cos, sin = np.cos(cut.phi), np.sin(cut.phi)
    place = np.stack((cos * cut.x - sin * cut.y, sin * cut.x + cos * cut.y, z, np.ones(z.shape)))
    return Grid(
        place, place.astype(np.float32), s, z, shape, cell, int(np.flatnonzero(deep).max(initial=0)) + 1
    )


@kept(64)
def chart_of(surface: Surface, above: float, beyond: float) -> Chart:
    """Make the chart of a surface from its root up to `above` (mm) its tip, and `beyond` (mm) its toe and
    heel; NaN where it has no points."""
    half = surface.half_width + beyond
    depth = surface.tip - surface.root + abs(surface.taper - surface.root_taper) * half + above
    root, z = np.linspace(0.0, np.sqrt(depth), NODES[0])[:, None], half * np.linspace(-1.0, 1.0, NODES[1])

    def angles(root: FloatArray, z: FloatArray) -> FloatArray:
        """Solve for the angles at roots of the depth over the root cone and heights z."""
        root, z = np.broadcast_arrays(root, z)
        square = (surface.root + surface.root_taper * z + root * root) ** 2
        s = profile_at(surface, square.ravel(), z.ravel())
        return angle_of(cut_at(surface, s, z.ravel())).reshape(z.shape)

    angle = np.concatenate(
        (angle_of(cut_at(surface, surface.bottom + 0.0 * z, z))[None], angles(root[1:], z))
    )
    middle = 0.25 * (angle[1:, 1:] + angle[1:, :-1] + angle[:-1, 1:] + angle[:-1, :-1])
    missed = np.abs(middle - angles(0.5 * (root[1:] + root[:-1]), 0.5 * (z[1:] + z[:-1])))
    rate = (NODES[0] - 1) / float(np.sqrt(depth)), (NODES[1] - 1) / (2.0 * half)
    out, on = np.diff(angle, axis=0), np.diff(angle, axis=1)
    parts = np.array((angle[:-1, :-1], on[:-1], out[:, :-1], np.diff(on, axis=0))).reshape(4, -1)
    return Chart(parts.astype(np.float32), -half, rate, SAFE * float(np.nan_to_num(missed).max()))


def scan_of(task: Task, grid: Grid, chart: Chart, turns: bool = True) -> Scan:
    """Give the clearance at the points of a grid, for every tooth pair of the task, by a chart of the gear;
    with `turns` also where the same teeth meet again periods later."""
    count, lines = task.roll.size, (grid.low * grid.shape[1], grid.shape[1])
    scan = Scan(
        f=np.empty((count, grid.s.size), dtype=np.float32),
        periods=np.zeros((count, grid.s.size), dtype=np.int16),
        gear_tip=np.empty((count, lines[0]), dtype=np.float32),
        pinion_tip=np.empty((count, lines[1]), dtype=np.float32),
        within=np.full(count, np.inf),
        bottom=np.zeros(count, dtype=bool),
    )
    moves, rows = _moves(task), max(1, BLOCK // grid.s.size)
    about, start, doubt = moves.astype(np.float32), task.start.astype(np.float32), []
    for first in range(0, count, rows):
        part = slice(first, first + rows)
        here = Scan(*(value[part] for value in vars(scan).values()))
        row, point, within = _scan_rows(task, grid, chart, turns, (about[:, part], start[part]), here)
        doubt.append((row + first, point, within))
    if doubt:
        row, point, within = (np.concatenate(parts) for parts in zip(*doubt, strict=True))
        x, y, z = (moves[:, row] * grid.points[:, point].T).sum(axis=-1)
        angle, before = _counted(task, met_by(task.other, x, y, z, task.start[row])[0])
        f = np.where(np.isnan(angle) | ((before != 0.0) & (not turns)), np.inf, angle * task.lever)
        scan.f[row, point], scan.periods[row, point] = f, task.other.sigma * before
        np.minimum.at(scan.within, row[within], f[within])
    return scan


def _moves(task: Task) -> FloatArray:
    """Give what makes the gear's coordinates x, y, z of the `points` of a grid, (3, n, 4)."""
    pose, cos, sin = task.pose, np.cos(task.roll), np.sin(task.roll)
    ahead, none = pose.position[0], np.zeros(task.roll.shape)
    rows = (
        (-cos, sin, none, pose.offset + none),
        (-pose.cos * sin, -pose.cos * cos, pose.sin, pose.sin * ahead),
        (pose.sin * sin, pose.sin * cos, pose.cos, pose.cos * ahead - pose.position[1]),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows])


def _counted(task: Task, angle: Angles) -> tuple[Angles, FloatArray]:
    """Give angles (rad) of the gear in the period they are looked at, and after how many."""
    if angle.min(initial=0.0) >= task.earliest and angle.max(initial=0.0) < task.earliest + task.period:
        return angle, np.zeros((1,) * angle.ndim)
    least = -np.pi - task.earliest
    angle = angle - 2.0 * np.pi * np.floor((angle - least) / (2.0 * np.pi))
    before = np.nan_to_num(np.floor((angle - task.earliest) / task.period))
    return angle - before * task.period, before


def _scan_rows(
    task: Task, grid: Grid, chart: Chart, turns: bool, rows: tuple[Single, Single], scan: Scan
) -> tuple[Integers, Integers, Mask]:
    """Scan tooth pairs with these moves and starts of the gear, but for what is `within`; and give the pairs,
    points and whether within of what can be the least, as far as the chart tells, and of what it does not."""
    other, reach, face = task.other, TIP_REACH * grid.cell[0], grid.shape[1]
    (moves, start), lever = rows, float(task.lever)
    x, y, z = moves @ grid.about
    r = np.sqrt(x * x + y * y)
    root, above = r - other.root_taper * z - other.root, r - other.taper * z - other.tip
    outside = np.maximum(above / grid.cell[0], (np.abs(z) - other.half_width) / grid.cell[1])
    rounding = ROUNDING * (float(task.pose.offset.max()) + task.own.tip + other.tip)
    near, within = (outside <= 0.5) & (root > 0.0), outside <= -rounding / min(grid.cell)
    turn = np.arctan2(y, x) - chart.at(np.maximum(root, 0.0), z) - start[:, None]
    angle, before = _counted(task, other.sigma * turn)
    scan.f[:] = np.where(near if turns else near & (before == 0.0), lever * angle, np.inf)
    scan.periods[:] = other.sigma * before
    # Nearly a millimetre along the profile is a millimetre of the other's radius.
    low, edge = slice(0, grid.low * face), slice(-face, None)
    deep, rise = np.abs(above[:, low]), grid.s[low] + above[:, low]
    on = (deep <= 0.5 * grid.cell[0]) & (rise < task.own.joint + reach)
    scan.gear_tip[:] = np.where(on, deep, np.inf)
    # At one profile coordinate points of a surface move evenly along z.
    fillet = cut_at(other, np.array([other.joint + reach]), np.zeros(1))
    across, up = fillet.x + fillet.x_z * z[:, edge], fillet.y + fillet.y_z * z[:, edge]
    on = np.isfinite(scan.f[:, edge]) & (r[:, edge] ** 2 < across * across + up * up)
    scan.pinion_tip[:] = np.where(on, 0.0, np.inf)
    scan.bottom[:] = (within & ((root < 0.0) | (grid.s <= task.own.bottom))).any(axis=1)
    doubt = lever * (chart.error + ROUNDING + 2.0 * rounding / other.pitch_radius)
    least = np.fmin.reduce(np.where(within, scan.f, np.inf), axis=1) + 2.0 * doubt
    unknown = np.isnan(scan.f)
    row, point = np.nonzero(near & (within & (scan.f <= np.minimum(least, LARGE)[:, None]) | unknown))
    return row, point, within[row, point]


def starts_of(task: Task, scan: Scan, grid: Grid, least: FloatArray, module: float) -> Starts:
    """Say where to search, given the least f of each tooth pair's position that is known so far, (tasks,)."""
    row, point = _line_starts(scan.f, grid.shape, least + SPARE * module)
    cell = np.array(grid.cell)[:, None]
    place = np.array((grid.s[point], grid.z[point]))
    parts = [
        Starts(row, scan.periods[row, point].astype(np.int64), place, np.broadcast_to(cell, place.shape))
    ]
    bound = least + SPARE * module, least + TIP_SPARE * module
    row, periods, place, inwards = _edge_starts(task, scan, grid, bound)
    for step, inside in zip(TIP_STEPS, (0.0, 1.0), strict=True):
        box = np.broadcast_to(cell * np.array(((step,), (1.0,))), place.shape)
        moved = np.array((inside * grid.cell[0] * inwards, 0.0 * inwards))
        parts.append(Starts(row, periods, place + moved, box))
    return Starts(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))


def _line_starts(f: Single, shape: tuple[int, int], bound: FloatArray) -> tuple[Integers, Integers]:
    """Give tooth pairs and point numbers of the least local least values of the scan lines."""
    values, points = [], []
    f = f.reshape(-1, *shape)
    for axis in (1, 2):
        best = f.argmin(axis=axis)
        line = f.min(axis=axis)
        low = np.ones(line.shape, dtype=bool)
        low[:, 1:] = line[:, 1:] <= line[:, :-1]
        low[:, :-1] &= line[:, :-1] <= line[:, 1:]
        line = np.where(low, line, np.inf)
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
    task: Task, scan: Scan, grid: Grid, bound: tuple[FloatArray, FloatArray]
) -> tuple[Integers, Integers, FloatArray, FloatArray]:
    """Give tooth pairs, their periods and places (2, n) of tips' edges near the other's fillet, at every
    station along the face: the scanned points least away from them, if f is within the first bound (tasks,)
    there, moved on to the edge, where f is within the second; and which way leads onto the flank."""
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
    close = (f <= bound[1][row]) & (-INWARDS[tip] * slope[0] < TIP_SLOPE)
    return row[close], periods[close], place[:, close], INWARDS[tip[close]]


def _on_edge(task: Task, place: FloatArray, tip: Integers) -> FloatArray:
    """Give places (2, n) moved along the profile to the edges of the TIPS with the numbers `tip` (n,), and
    between the gear's toe and heel."""
    place, limit, each = place.copy(), TIPS[tip], np.arange(tip.size)
    for _ in range(EDGE_PASSES):
        margin, rate = limits_at(task, *place)
        place[0] -= _or_nothing(margin[limit, each] / rate[limit, 0, each])
        for end in (Limit.GEAR_TOE, Limit.GEAR_HEEL):
            place[1] -= _or_nothing(np.minimum(margin[end], 0.0) / rate[end, 1])
    return place


def _or_nothing(steps: FloatArray) -> FloatArray:
    """Give steps, and none where they are not known."""
    return np.where(np.isfinite(steps), steps, 0.0)


def beside_fillets(task: Task, place: FloatArray, grid: Grid) -> Starts:
    """Give more starts from what was found: at the same station on a tip's edge if it is on a fillet less
    than a cell away, and beside that fillet. `row` counts the places (2, n) of the tasks."""
    own, cell = task.own, np.array(grid.cell)[:, None]
    # From further off no edge within a cell lies on a fillet.
    room = np.stack(
        (place[0] - own.joint, own.tip + own.taper * place[1] - np.sqrt(cut_at(own, *place).square))
    )
    tip, close = np.nonzero(room < FURTHEST * grid.cell[0])
    edge, gap = place[:, close], np.full(close.size, np.inf)
    if close.size:
        near = task.pick(close)
        edge = _on_edge(near, edge, tip)
        gap = np.where(tip == 0, edge[0] - own.joint, clearance_at(near, *edge)[2] - task.other.joint)
    away, parts = np.abs(edge[0] - place[0, close]), []
    for step, inside, least in zip(TIP_STEPS, (0.0, 0.5), (1e-6 * cell[0, 0], 0.0), strict=True):
        row = np.flatnonzero((away >= least) & (away < grid.cell[0]) & (gap < 0.0))
        moved = edge[:, row] + np.array((inside * grid.cell[0] * INWARDS[tip[row]], np.zeros(row.size)))
        box = np.broadcast_to(cell * np.array(((step,), (1.0,))), moved.shape)
        parts.append(Starts(close[row], np.zeros_like(row), moved, box))
    return Starts(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))
