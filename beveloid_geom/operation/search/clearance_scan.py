"""Scan of the clearance over the pinion's tooth surface.

The clearance of a point follows from the angle between the point and the gear's surface at the same radius
and z (`angular_clearance`). A chart tabulates the angle of the gear's surface over radius and z, and is
interpolated bilinearly, so that no equation is solved for a scanned point. Scans use single precision. The
interpolation error is assumed to be at most twice the largest error in the middle of the cells of the chart.
Every point that can be the minimum with this error, plus rounding, is evaluated again in double precision.
The minimum over the scanned points is therefore exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, Integers, Mask
from ...design.member import Member
from ...gear.flank_limits import tip_parameter
from ...gear.tooth_side import Cut, ToothSurface, angle_of, cut_at, profile_at, surface_of
from ...support.frozen_arrays import cached
from ...support.products import product
from ..angular_clearance import met_by
from .search_task import Task

TIP_REACH_CELLS = 0.05
"""Distance from a fillet up to which a tip edge counts as on it."""
CHART_NODES = 128, 12
"""Nodes of a chart along radius and face."""
Single: TypeAlias = NDArray[np.float32]
Angles = TypeVar("Angles", Single, FloatArray)


@dataclass(frozen=True, eq=False)
class Grid:
    """Points of the pinion's tooth surface for a scan.

    Attributes
    ----------
    points : ndarray, shape (4, n)
        Homogeneous coordinates x, y, z, 1 in the frame of the pinion, z from mid-face, mm.
    about : ndarray of float32, shape (4, n)
        The same in single precision.
    s, z : ndarray, shape (n,)
        Profile coordinates and distances from mid-face, mm.
    shape : tuple of int
        Number of points along profile and face.
    cell : tuple of float
        Steps along profile and face, mm.
    low : int
        Number of lines along the face, counted from the root, after which all points are more than half a
        cell above the joint.
    """

    points: FloatArray
    about: Single
    s: FloatArray
    z: FloatArray
    shape: tuple[int, int]
    cell: tuple[float, float]
    low: int


@dataclass(frozen=True, eq=False)
class Chart:
    """Angles of a tooth surface about its axis, tabulated in single precision.

    The nodes are evenly spaced in z and in the square root of the height above the root cone.

    Attributes
    ----------
    parts : ndarray of float32, shape (4, cells)
        Bilinear coefficients of each cell: the angle at its first node, the differences along z and along
        radius, and the mixed difference; rad.
    start : float
        z of the first node, mm.
    rate : tuple of float
        Nodes per unit of the root of the height (mm^0.5) and of z (mm).
    error : float
        Bound on the interpolation error, rad.
    """

    parts: Single
    start: float
    rate: tuple[float, float]
    error: float

    def at(self, above: Single, z: Single) -> Single:
        """Return angles (rad) of points by their height `above` the root cone and z, mm."""
        across, along = np.sqrt(above) * self.rate[0], (z - self.start) * self.rate[1]
        first = np.minimum(np.floor(across), CHART_NODES[0] - 2)
        second = np.minimum(np.floor(along), CHART_NODES[1] - 2)
        across -= first
        along -= second
        first *= CHART_NODES[1] - 1
        first += second
        cell = first.astype(np.intp)
        angle, on, out, both = (part.take(cell, mode="clip") for part in self.parts)
        on *= along
        angle += on
        both *= along
        out += both
        out *= across
        angle += out
        return np.asarray(angle)


@dataclass(frozen=True, eq=False)
class Scan:
    """Clearance of scanned tooth pairs (n,), mm, in single precision.

    Attributes
    ----------
    f : ndarray, shape (n, points)
        Clearance; infinite more than half a cell outside the limits.
    periods : ndarray of int, shape (n, points)
        Number of periods by which the reference roll of the gear is moved on (`Task.later`): sigma times the
        number of periods that were subtracted from the clearance angle.
    gear_tip : ndarray, shape (n, low points)
        Distance from the gear's tip edge where this is near the pinion's fillet; otherwise infinite.
    pinion_tip : ndarray, shape (n, points along face)
        0 where the pinion's tip edge is on the gear's fillet; otherwise infinite.
    within : ndarray, shape (n,)
        Minimum of f within the limits, in double precision.
    bottom : ndarray of bool, shape (n,)
        Whether a tip touches a bottom land.
    """

    f: Single
    periods: Integers
    gear_tip: Single
    pinion_tip: Single
    within: FloatArray
    bottom: Mask


@cached(64)
def scan_grid(member: Member, flank: str, points: tuple[int, int, int]) -> Grid:
    """Return the scan points on fillet and flank of the pinion.

    Parameters
    ----------
    member : Member
        A single member.
    flank : {'right', 'left'}
    points : tuple of int
        Points along fillet, flank and face. Long fillets get more points, up to the number on the flank, so
        that a step rises by less than a cell.

    Returns
    -------
    Grid
    """
    # Points on a fillet for each cell of its length.
    fillet_points_per_cell = 1.8
    pinion, (fillet, profile, face) = surface_of(member, flank), points
    cell = ((pinion.highest - pinion.joint) / (profile - 1), 2.0 * pinion.half_width / (face - 1))
    wanted = np.nan_to_num(fillet_points_per_cell * (pinion.joint - pinion.bottom) / cell[0])
    fillet = max(fillet, int(min(wanted, profile)))
    z = pinion.half_width * np.linspace(-1.0, 1.0, face)
    top = np.fmin(tip_parameter(member, flank, z), pinion.highest + 0.0 * z)
    # Denser next to the flank, where a fillet is steepest.
    below = np.linspace(1.0, 0.0, fillet + 1)[:-1, None] ** 2
    start, end = pinion.flank_start(z), pinion.fillet_end(z)
    low = end - (end - pinion.bottom) * below
    high = start + (top - start) * np.linspace(0.0, 1.0, profile)[:, None]
    s = np.concatenate((low, high))
    deep = (s < pinion.joint + (0.5 + TIP_REACH_CELLS) * cell[0]).any(axis=1)
    shape, s, z = s.shape, s.ravel(), np.broadcast_to(z, s.shape).ravel()
    cut = cut_at(pinion, s, z)
    cos, sin = np.cos(cut.phi), np.sin(cut.phi)
    place = np.stack((cos * cut.x - sin * cut.y, sin * cut.x + cos * cut.y, z, np.ones(z.shape)))
    return Grid(
        place, place.astype(np.float32), s, z, shape, cell, int(np.flatnonzero(deep).max(initial=0)) + 1
    )


@cached(64)
def chart_of(surface: ToothSurface, above: float, beyond: float) -> Chart:
    """Tabulate the angles of a tooth surface.

    Parameters
    ----------
    surface : ToothSurface
    above : float
        Height above the tip up to which the chart extends, mm.
    beyond : float
        Length by which it extends past toe and heel, mm.

    Returns
    -------
    Chart
        NaN where the surface has no points.
    """
    half = surface.half_width + beyond
    depth = surface.tip - surface.root + abs(surface.taper - surface.root_taper) * half + above
    root = np.linspace(0.0, np.sqrt(depth), CHART_NODES[0])[:, None]
    z = half * np.linspace(-1.0, 1.0, CHART_NODES[1])

    def angles(root: FloatArray, z: FloatArray) -> FloatArray:
        """Return the angles at roots of the height above the root cone and at z."""
        root, z = np.broadcast_arrays(root, z)
        square = (surface.root + surface.root_taper * z + root * root) ** 2
        s = profile_at(surface, square.ravel(), z.ravel())
        return angle_of(cut_at(surface, s, z.ravel())).reshape(z.shape)

    bottom = angle_of(cut_at(surface, surface.bottom + 0.0 * z, z))
    angle = np.concatenate((bottom[None], angles(root[1:], z)))
    middle = 0.25 * (angle[1:, 1:] + angle[1:, :-1] + angle[:-1, 1:] + angle[:-1, :-1])
    missed = np.abs(middle - angles(0.5 * (root[1:] + root[:-1]), 0.5 * (z[1:] + z[:-1])))
    rate = (CHART_NODES[0] - 1) / float(np.sqrt(depth)), (CHART_NODES[1] - 1) / (2.0 * half)
    out, on = np.diff(angle, axis=0), np.diff(angle, axis=1)
    parts = np.array((angle[:-1, :-1], on[:-1], out[:, :-1], np.diff(on, axis=0))).reshape(4, -1)
    # Ratio of the assumed interpolation error of a chart to the largest error seen in the middle of its
    # cells.
    error_safety = 2.0
    return Chart(parts.astype(np.float32), -half, rate, error_safety * float(np.nan_to_num(missed).max()))


def scan_of(task: Task, grid: Grid, chart: Chart, turns: bool = True) -> Scan:
    """Scan the clearance of every tooth pair of a task.

    Parameters
    ----------
    task : Task
    grid : Grid
        Points of the pinion.
    chart : Chart
        Of the gear.
    turns : bool
        Whether contacts of the same pinion teeth in other periods, later or earlier, are included.

    Returns
    -------
    Scan
    """
    # Points of one block, so that the arrays stay in the cache.
    points_per_block = 24576
    count, lines = task.roll.size, (grid.low * grid.shape[1], grid.shape[1])
    scan = Scan(
        f=np.empty((count, grid.s.size), dtype=np.float32),
        periods=np.zeros((count, grid.s.size), dtype=np.int16),
        gear_tip=np.empty((count, lines[0]), dtype=np.float32),
        pinion_tip=np.empty((count, lines[1]), dtype=np.float32),
        within=np.full(count, np.inf),
        bottom=np.zeros(count, dtype=bool),
    )
    moves, rows = _moves(task), max(1, points_per_block // grid.s.size)
    about, start, doubt = moves.astype(np.float32), task.start.astype(np.float32), []
    for first in range(0, count, rows):
        part = slice(first, first + rows)
        here = Scan(*(value[part] for value in vars(scan).values()))
        row, point, within = _scan_rows(task, grid, chart, turns, (about[:, part], start[part]), here)
        doubt.append((row + first, point, within))
    if doubt:  # double precision for the candidates of the minimum
        row, point, within = (np.concatenate(parts) for parts in zip(*doubt, strict=True))
        x, y, z = (moves[:, row] * grid.points[:, point].T).sum(axis=-1)
        angle, before = _counted(task, met_by(task.gear, x, y, z, task.start[row])[0])
        f = np.where(np.isnan(angle) | ((before != 0.0) & (not turns)), np.inf, angle * task.lever)
        scan.f[row, point], scan.periods[row, point] = f, task.gear.sigma * before
        np.minimum.at(scan.within, row[within], f[within])
    return scan


def _moves(task: Task) -> FloatArray:
    """Return the matrices (3, n, 4) from the `points` of a grid to coordinates of the gear."""
    axes, cos, sin = task.axes, np.cos(task.roll), np.sin(task.roll)
    ahead, moves = axes.position[0], np.empty((3, cos.size, 4))
    rows = (
        (-cos, sin, 0.0, axes.offset),
        (-axes.cos * sin, -axes.cos * cos, axes.sin, axes.sin * ahead),
        (axes.sin * sin, axes.sin * cos, axes.cos, axes.cos * ahead - axes.position[1]),
    )
    for row, values in zip(moves, rows, strict=True):
        for column, value in enumerate(values):
            row[:, column] = value
    return moves


def _counted(task: Task, angle: Angles) -> tuple[Angles, FloatArray]:
    """Return clearance angles (rad) within the period that is searched, and the number of periods removed."""
    if angle.min(initial=0.0) >= task.earliest and angle.max(initial=0.0) < task.earliest + task.period:
        return angle, np.zeros((1,) * angle.ndim)
    least = -np.pi - task.earliest
    angle = angle - 2.0 * np.pi * np.floor((angle - least) / (2.0 * np.pi))
    before = np.nan_to_num(np.floor((angle - task.earliest) / task.period))
    return angle - before * task.period, before


def _scan_rows(
    task: Task, grid: Grid, chart: Chart, turns: bool, rows: tuple[Single, Single], scan: Scan
) -> tuple[Integers, Integers, Mask]:
    """Scan tooth pairs, except for `Scan.within`. Return the pairs and points that can be the minimum or
    are not known from the chart, and whether they are within the limits."""
    # Finite upper bound of the clearance in single precision.
    largest_mm = 1e30
    # Rounding error of single precision: of an angle (rad), and of coordinates relative to their size.
    single_rounding = 1e-6
    gear, reach, face = task.gear, TIP_REACH_CELLS * grid.cell[0], grid.shape[1]
    (moves, start), lever = rows, float(task.lever)
    x, y, z = product(moves, grid.about)
    r = np.sqrt(x * x + y * y)
    root, above = r - gear.root_taper * z - gear.root, r - gear.taper * z - gear.tip
    outside = np.maximum(above / grid.cell[0], (np.abs(z) - gear.half_width) / grid.cell[1])
    rounding = single_rounding * (float(task.axes.offset.max()) + task.pinion.tip + gear.tip)
    near, within = (outside <= 0.5) & (root > 0.0), outside <= -rounding / min(grid.cell)
    turn = np.arctan2(y, x) - chart.at(np.maximum(root, 0.0), z) - start[:, None]
    angle, before = _counted(task, gear.sigma * turn)
    scan.f[:] = np.where(near if turns else near & (before == 0.0), lever * angle, np.inf)
    scan.periods[:] = gear.sigma * before
    # Near the fillets, a step along the profile changes the radius on the gear by about the same length.
    low, edge = slice(0, grid.low * face), slice(-face, None)
    deep, rise = np.abs(above[:, low]), grid.s[low] + above[:, low]
    on = (deep <= 0.5 * grid.cell[0]) & (rise < task.pinion.joint + reach)
    scan.gear_tip[:] = np.where(on, deep, np.inf)
    # Radius at which the gear's fillet starts: at a fixed profile coordinate, points are linear in z.
    if gear.crossing is None:
        fillet = _mid_face_point(gear, gear.joint + reach)
        across, up = fillet.x + fillet.x_z * z[:, edge], fillet.y + fillet.y_z * z[:, edge]
        square = across * across + up * up
    else:
        height = z[:, edge].astype(float)
        square = cut_at(gear, gear.flank_start(height) + reach, height).square
    on = np.isfinite(scan.f[:, edge]) & (r[:, edge] ** 2 < square)
    scan.pinion_tip[:] = np.where(on, 0.0, np.inf)
    scan.bottom[:] = (within & ((root < 0.0) | (grid.s <= task.pinion.bottom))).any(axis=1)
    # Candidates of the minimum: within twice the error bound of the smallest clearance seen.
    doubt = lever * (chart.error + single_rounding + 2.0 * rounding / gear.pitch_radius)
    least = np.fmin.reduce(np.where(within, scan.f, np.inf), axis=1) + 2.0 * doubt
    unknown = np.isnan(scan.f)
    row, point = np.nonzero(near & (within & (scan.f <= np.minimum(least, largest_mm)[:, None]) | unknown))
    return row, point, within[row, point]


@cached(64)
def _mid_face_point(surface: ToothSurface, s: float) -> Cut:
    return cut_at(surface, np.array([s]), np.zeros(1))
