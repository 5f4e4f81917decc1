"""Measured points read back: how far they lie off the flank, along its normal.

A file has one point a line, in the order of the grid, mm: x, y, z, before them perhaps flank, row and column,
after them whatever else, as the normal of the nominal file. A first line of names, as in CSV, says which
columns these are. Lines that begin with # say nothing. What does not fit the grid is refused: a point left
out, another order, another unit, another gear.

The deviation is the distance of a point from its foot on the exact flank, positive where there is too much
metal: not along the nominal normal, from which it differs by the square of what the probe was beside its
place.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..analysis.ease_off import SecondOrder, second_order_of
from ..arrays import FLANK_SIGN, FloatArray, Indices
from ..gear.perpendicular import feet
from ..support.few_lines import few_lines
from .grid import MeasuringGrid

FAR = 0.5
"""Modules from its place beyond which a point is not one of the grid."""
UNITS = ((1000.0, "um"), (1.0 / 25.4, "inches"), (0.1, "cm"), (0.001, "m"))
"""By how much coordinates in other units than mm are greater, and those."""
ALIKE = 0.05
"""Share by which radii may differ from those of the grid in such a unit."""


class MeasuredError(ValueError):
    """A file of measured points that does not fit the grid."""


@dataclass(frozen=True, eq=False)
class Deviations:
    """Measured `point` (2, rows, columns, 3) of a `grid`, mm, and their `deviation` (2, rows, columns), mm,
    along the normal, positive out of the tooth; `beside` (2, rows, columns), mm, how far a point's foot lies
    from the place where it was to be taken."""

    __repr__ = few_lines

    grid: MeasuringGrid
    point: FloatArray
    deviation: FloatArray
    beside: FloatArray

    @property
    def second_order(self) -> tuple[SecondOrder, ...]:
        """The surface of second order nearest to the deviations of right and left flank, over the grid from
        its first row and column to its last."""
        profile, face = (np.linspace(-1.0, 1.0, count) for count in self.grid.shape)
        return tuple(second_order_of(profile, face, values) for values in self.deviation)

    @property
    def thickness(self) -> float:
        """By how much the normal thickness is greater than nominal in the mean, mm."""
        return float(
            self.deviation.mean(axis=(1, 2)).sum() / np.cos(self.grid.member.tool.normal_pressure_angle)
        )

    @property
    def turn(self) -> float:
        """By how much the tooth stands turned about the axis in the mean, rad, positive from x to y."""
        tool = self.grid.member.tool
        lever = 0.5 * tool.normal_module * np.cos(tool.normal_pressure_angle) * self.grid.member.teeth
        right, left = self.deviation.mean(axis=(1, 2))
        return float(0.5 * (right - left) / lever)


class _Line(NamedTuple):
    """A point in a file: which line, the place it names or none, and its coordinates."""

    number: int
    place: tuple[str, int, int] | None
    point: tuple[float, ...]


def read_deviations(path: Path, grid: MeasuringGrid) -> Deviations:
    """Read the measured points of a grid from a file. Raises OSError, and MeasuredError with the line."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise MeasuredError("is no text: give the table of points as CSV or as text") from None
    return deviations_of(grid, _points(text, grid))


def deviations_of(grid: MeasuringGrid, point: FloatArray) -> Deviations:
    """Find the deviations of measured points (2, rows, columns, 3), mm, in the order of the grid.

    Raises MeasuredError for points that are those of another order, unit or gear."""
    _require_places(grid, point)
    deviation, beside = np.empty(point.shape[:-1]), np.empty(point.shape[:-1])
    for side, flank in enumerate(FLANK_SIGN):
        found = feet(grid.member, flank, point[side], (grid.l[side], grid.u[side]))
        deviation[side] = found.distance
        foot = point[side] - found.distance[..., None] * found.normal
        beside[side] = np.linalg.norm(foot - grid.point[side], axis=-1)
    return Deviations(grid, point, deviation, beside)


def _points(text: str, grid: MeasuringGrid) -> FloatArray:
    """Give the points (2, rows, columns, 3) of a file's text."""
    rows, columns = grid.shape
    wanted = [(flank, i + 1, j + 1) for flank in FLANK_SIGN for i in range(rows) for j in range(columns)]
    lines = _lines(text)
    for line, place in zip(lines, wanted, strict=False):
        if line.place is not None and line.place != place:
            after = "a point is missing, or the order is another one"
            raise MeasuredError(
                f"line {line.number} is {_words(line.place)} where {_words(place)} is due: {after}"
            )
    if len(lines) != len(wanted):
        size = f"{len(wanted)} of both flanks with {rows} rows and {columns} columns"
        cure = "a point is missing" if len(lines) < len(wanted) else "were they taken on another grid?"
        raise MeasuredError(f"has {len(lines)} points in place of {size}: {cure}")
    return np.array([line.point for line in lines]).reshape(2, rows, columns, 3)


def _words(place: tuple[str, int, int]) -> str:
    return "{}, row {}, column {}".format(*place)


def _lines(text: str) -> list[_Line]:
    """Give the points of a text. Raises MeasuredError for what is none."""
    found: list[_Line] = []
    names: list[str] | None = None
    for number, raw in enumerate(text.splitlines(), 1):
        if not raw.strip() or raw.lstrip().startswith("#"):
            continue
        cells = _cells(raw)
        if not found and names is None and any(re.fullmatch(r"[xyz](_\w+)?", cell.lower()) for cell in cells):
            names = _named(cells, number)
            continue
        found.append(_line(number, cells, names))
    return found


def _cells(raw: str) -> list[str]:
    """Give the cells of a line, between semicolons, commas, tabs or blanks."""
    mark = next((mark for mark in ";,\t" if mark in raw), None)
    return [cell.strip() for cell in (raw.split(mark) if mark else raw.split())]


def _named(cells: list[str], number: int) -> list[str]:
    """Give the names of columns, without the unit mm."""
    for cell in cells:
        if (match := re.fullmatch(r"[xyz]_(\w+)", cell.lower())) and match[1] != "mm":
            raise MeasuredError(f"line {number}: {cell} must be in mm, as {cell[0]}_mm: convert it")
    names = [cell.lower().removesuffix("_mm") for cell in cells]
    if missing := [name for name in "xyz" if name not in names]:
        raise MeasuredError(f"line {number} names no column {missing[0]}: x, y and z are needed, in mm")
    return names


def _line(number: int, cells: list[str], names: list[str] | None) -> _Line:
    """Give the point of a line."""
    if names is None:
        labelled = 3 * (cells[0].lower() in FLANK_SIGN)
        names = ["flank", "row", "column"][:labelled] + list("xyz")
    given, place = dict(zip(names, cells, strict=False)), None
    try:
        point = tuple(float(given[name]) for name in "xyz")
        if {"flank", "row", "column"} <= given.keys():
            place = given["flank"].lower(), int(given["row"]), int(given["column"])
        whole = all(map(math.isfinite, point))
    except (KeyError, ValueError):
        whole = False
    if not whole:
        hole = "a hole in the grid? measure it again"
        raise MeasuredError(f"line {number} has no place, x, y and z in mm: {hole}")
    return _Line(number, place, point)


def _require_places(grid: MeasuringGrid, point: FloatArray) -> None:
    """Raise MeasuredError where points are not near the places of the grid, each near its own."""
    own, given = grid.point.reshape(-1, 3), point.reshape(-1, 3)
    away, swapped = np.linalg.norm(given - own, axis=-1), _swapped(own, given)
    far = FAR * float(grid.member.tool.normal_module)
    if away.max() <= far and not swapped.size:
        return
    scale = float(np.median(np.linalg.norm(given, axis=-1) / np.linalg.norm(own, axis=-1)))
    for factor, unit in UNITS:
        if abs(scale / factor - 1.0) < ALIKE:
            read = f"were they given in {unit}? mm are read"
            raise MeasuredError(f"has coordinates {scale:.4g} times those of the grid: {read}")
    first = int(swapped[0]) if swapped.size else int(away.argmax())
    nearest = int(np.linalg.norm(own - given[first], axis=-1).argmin())
    here = f"the point of {_words(_place(grid, first))}"
    if nearest != first and np.linalg.norm(own[nearest] - given[first]) <= far:
        there = f"at {_words(_place(grid, nearest))}"
        raise MeasuredError(f"has {here} {there}: take the points in the grid's order")
    cure = "is it this design, member, grid and datum?"
    raise MeasuredError(f"has {here} {away[first]:.4g} mm away from its place: {cure}")


def _swapped(own: FloatArray, given: FloatArray) -> Indices:
    """Give the points that lie less than half as far from the place of another as from their own."""
    from scipy.spatial import cKDTree

    nearest, index = cKDTree(own).query(given)
    other = index != np.arange(len(own))
    return np.flatnonzero(other & (nearest < 0.5 * np.linalg.norm(given - own, axis=-1)))


def _place(grid: MeasuringGrid, index: int) -> tuple[str, int, int]:
    """Give flank, row and column, from 1 on, of a point."""
    side, row, column = np.unravel_index(index, grid.l.shape)
    return tuple(FLANK_SIGN)[int(side)], int(row) + 1, int(column) + 1
