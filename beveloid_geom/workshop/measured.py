"""Deviations of measured points from the flank, along its normal.

`measured_table` describes the file. Points that do not fit the grid are rejected: a missing point, another
order, another unit, another gear.

The deviation is the distance of a point from its foot on the exact flank, positive for excess material. It
is not taken along the nominal normal. The difference between both is proportional to the square of the
lateral offset of the probe.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..analysis.ease_off import SecondOrder, second_order_of
from ..arrays import FLANK_SIGN, FloatArray, Indices
from ..design.deviations import FlankDeviations
from ..gear.closest_point import feet
from ..gear.tooth_side import angle_of, cut_at, profile_at, surface_of
from ..support.array_repr import short_repr
from ..support.text_file import TextFileError, read_text
from .grid import MeasuringGrid
from .measured_table import MeasuredError as MeasuredError, Place, points_of, words_of


@dataclass(frozen=True, eq=False)
class Deviations:
    """Deviations of measured points.

    Attributes
    ----------
    grid : MeasuringGrid
        Nominal points.
    point : array (2, rows, columns, 3)
        Measured points, mm.
    deviation : array (2, rows, columns)
        Distance from the flank along its normal, mm, positive out of the tooth.
    foot_distance : array (2, rows, columns)
        Distance of the foot of a point from its nominal position, mm.
    """

    __repr__ = short_repr

    grid: MeasuringGrid
    point: FloatArray
    deviation: FloatArray
    foot_distance: FloatArray

    @property
    def second_order(self) -> tuple[SecondOrder, ...]:
        """Surfaces of second order fitted to the deviations of right and left flank, over the range of the
        grid."""
        profile, face = (np.linspace(-1.0, 1.0, count) for count in self.grid.shape)
        return tuple(second_order_of(profile, face, values) for values in self.deviation)

    @property
    def thickness(self) -> float:
        """Mean deviation of the normal thickness, mm, positive for a thicker tooth."""
        return float(
            self.deviation.mean(axis=(1, 2)).sum() / np.cos(self.grid.member.tool.normal_pressure_angle)
        )

    @property
    def turn(self) -> float:
        """Mean rotation of the tooth about the axis, rad, positive from x to y."""
        tool = self.grid.member.tool
        lever = 0.5 * tool.normal_module * np.cos(tool.normal_pressure_angle) * self.grid.member.teeth
        right, left = self.deviation.mean(axis=(1, 2))
        return float(0.5 * (right - left) / lever)

    @property
    def on_flanks(self) -> FlankDeviations:
        """Deviations as an input of `Modification`: a flank with them passes through the measured points.

        Each point is compared with the flank point of the same radius and z. Raises MeasuredError if there is
        no such point."""
        # Deviations up to this magnitude are rounding errors of the nominal grid in a file, and
        # count as zero.
        rounding_um = 2e-6
        member, tool = self.grid.member, self.grid.member.tool
        lever = 0.5 * float(tool.normal_module * np.cos(tool.normal_pressure_angle) * member.teeth)
        l, z, amount = np.empty((3, *self.deviation.shape))
        for side, (flank, sigma) in enumerate(FLANK_SIGN.items()):
            surface = surface_of(member, flank)
            # Points of missing material at the root lie below the joint with the fillet.
            margin = surface.highest - surface.joint
            surface = replace(surface, joint=surface.joint - margin, crossing=None)
            x, y, high = (self.point[side, ..., k].ravel() for k in range(3))
            with np.errstate(invalid="ignore", divide="ignore"):
                along = profile_at(surface, x * x + y * y, high)
                turn = np.arctan2(y, x) - angle_of(cut_at(surface, along, high))
            turn -= 2.0 * np.pi * np.rint(turn / (2.0 * np.pi))
            shape = self.deviation.shape[1:]
            l[side], z[side] = along.reshape(shape), high.reshape(shape)
            amount[side] = 1e3 * sigma * lever * turn.reshape(shape)
        if not np.isfinite(amount).all():
            raise MeasuredError("has points below the base cylinder: measure the flanks at a larger radius")
        return FlankDeviations(l, z, np.where(np.abs(amount) > rounding_um, amount, 0.0))


def read_deviations(path: Path, grid: MeasuringGrid) -> Deviations:
    """Read the measured points of a grid from a text file.

    Parameters
    ----------
    path : Path
        Table of points in UTF-8, UTF-16 or Windows Latin encoding, see `measured_table`.
    grid : MeasuringGrid
        Nominal points.

    Returns
    -------
    Deviations

    Raises
    ------
    OSError
        If the file cannot be read.
    MeasuredError
        If the file does not fit the grid. If a single point is at fault, the message names its line, or its
        flank, row and column.

    References
    ----------
    Formats: beveloid_geom/workshop/README.md, Measuring.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import beveloid_geom as bg
    >>> grid = bg.measuring_grid(bg.builtin_design("ni-2017").pinion, rows=2, columns=2)
    >>> thicker = (grid.point + 0.01 * grid.normal).reshape(-1, 3).tolist()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "points.txt")
    ...     _ = file.write_text("\\n".join(f"{x} {y} {z}" for x, y, z in thicker))
    ...     deviations = bg.read_deviations(file, grid)
    >>> deviations.deviation.round(6)[0]
    array([[0.01, 0.01],
           [0.01, 0.01]])
    """
    max_bytes = 1_000_000 + 1_000 * grid.l.size  # lines of the nominal file have 150 characters
    try:
        text = read_text(path, max_bytes, fallback="cp1252")
    except TextFileError as error:
        raise MeasuredError(f"{error}: give the table of points as CSV or as text") from None
    if re.search(r"[\x00-\x08\x0e-\x1b]", text):
        raise MeasuredError("is not a text file: give the table of points as CSV or as text in UTF-8")
    return deviations_of(grid, points_of(text, grid))


def deviations_of(grid: MeasuringGrid, point: FloatArray) -> Deviations:
    """Return the deviations of measured points from the flanks.

    Parameters
    ----------
    grid : MeasuringGrid
        Nominal points.
    point : ndarray, shape (2, rows, columns, 3)
        Measured points in the order of the grid, mm.

    Returns
    -------
    Deviations

    Raises
    ------
    MeasuredError
        For points in another order or unit, or of another gear.
    """
    _require_places(grid, point)
    deviation, foot_distance = np.empty(point.shape[:-1]), np.empty(point.shape[:-1])
    for side, flank in enumerate(FLANK_SIGN):
        foot = feet(grid.member, flank, point[side], (grid.l[side], grid.u[side]))
        deviation[side] = foot.distance
        on_flank = point[side] - foot.distance[..., None] * foot.normal
        foot_distance[side] = np.linalg.norm(on_flank - grid.point[side], axis=-1)
    return Deviations(grid, point, deviation, foot_distance)


def _require_places(grid: MeasuringGrid, point: FloatArray) -> None:
    """Raise MeasuredError unless all points are near their nominal positions."""
    # Largest distance of a measured point from its nominal position.
    max_offset_modules = 0.5
    # If all coordinates are wrong by the factor of another unit within this relative difference, the message
    # names this unit.
    unit_tolerance = 0.05
    nominal, given = grid.point.reshape(-1, 3), point.reshape(-1, 3)
    away, swapped = np.linalg.norm(given - nominal, axis=-1), _swapped(nominal, given)
    far = max_offset_modules * float(grid.member.tool.normal_module)
    if away.max() <= far and not swapped.size:
        return
    scale = float(np.median(np.linalg.norm(given, axis=-1) / np.linalg.norm(nominal, axis=-1)))
    # Ratio of coordinates in other units to those in mm, and the units.
    for factor, unit in ((1000.0, "um"), (1.0 / 25.4, "inches"), (0.1, "cm"), (0.001, "m")):
        if abs(scale / factor - 1.0) < unit_tolerance:
            cure = f"give them in mm, they are probably in {unit}"
            raise MeasuredError(f"has coordinates {scale:.4g} times those of the grid: {cure}")
    first = int(swapped[0]) if swapped.size else int(away.argmax())
    nearest = int(np.linalg.norm(nominal - given[first], axis=-1).argmin())
    here = f"the point of {words_of(_place(grid, first))}"
    if nearest != first and np.linalg.norm(nominal[nearest] - given[first]) <= far:
        there = f"at the position of {words_of(_place(grid, nearest))}"
        raise MeasuredError(f"has {here} {there}: write the points in the order of the grid")
    cure = "do design, member, grid and datum belong to this file?"
    distance = f"{away[first]:.4g} mm from its nominal position, the limit is {far:g} mm"
    raise MeasuredError(f"has {here} at {distance}: {cure}")


def _swapped(nominal: FloatArray, given: FloatArray) -> Indices:
    """Return the points that are less than half as far from the nominal position of another point as from
    the position of the same index."""
    from scipy.spatial import cKDTree

    nearest, index = cKDTree(nominal).query(given)
    other = index != np.arange(len(nominal))
    return np.flatnonzero(other & (nearest < 0.5 * np.linalg.norm(given - nominal, axis=-1)))


def _place(grid: MeasuringGrid, index: int) -> Place:
    """Return flank, row and column of a point, counted from 1."""
    side, row, column = np.unravel_index(index, grid.l.shape)
    return tuple(FLANK_SIGN)[int(side)], int(row) + 1, int(column) + 1
