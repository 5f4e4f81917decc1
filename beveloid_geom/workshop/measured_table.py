"""Tables of points as measuring programs and spreadsheets write them.

A line contains one point, in the order of the grid: x, y and z in mm. The number of the point, and flank,
row and column may precede them. Anything may follow, for example the normal of the nominal file. A line of
names, as in CSV files, may state which columns are x, y and z. Titles before the first point, empty lines and
lines that begin with # are ignored.
"""

from __future__ import annotations

import csv
import math
import re
from typing import NamedTuple, TypeAlias

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from .grid import MeasuringGrid

Place: TypeAlias = tuple[str, int, int]
"""Flank, and row and column from 1 on."""

_COORDINATE_NAME = re.compile(r"([xyz])(?:[_\s/]+(?:in\s+)?(\w+))?")
"""Name of a column of coordinates, and its unit."""


class MeasuredError(ValueError):
    """A file of measured points that does not fit the grid."""


class _Row(NamedTuple):
    """A line with a point: its number in the file and its cells."""

    number: int
    cells: list[str]


def points_of(text: str, grid: MeasuringGrid) -> FloatArray:
    """Return the points of a table in the order of a grid.

    Parameters
    ----------
    text : str
        Table with one point per line.
    grid : MeasuringGrid
        Nominal points.

    Returns
    -------
    ndarray, shape (2, rows, columns, 3)
        mm.

    Raises
    ------
    MeasuredError
        For a table that has other points. The message names the line, except for a wrong number of points.
    """
    rows, columns = grid.shape
    places = [(flank, i + 1, j + 1) for flank in FLANK_SIGN for i in range(rows) for j in range(columns)]
    lines, names = _table(text)
    points = []
    for number, row in enumerate(lines):
        place, point = _point(row, names)
        if place is not None and number < len(places) and place != places[number]:
            cause = "a point is missing, or the order is different"
            raise MeasuredError(
                f"line {row.number} is ({words_of(place)}), expected ({words_of(places[number])}): {cause}"
            )
        points.append(point)
    if len(points) != len(places):
        size = f"{len(places)} of both flanks with {rows} rows and {columns} columns"
        cure = "a point is missing" if len(points) < len(places) else "were they measured on another grid?"
        raise MeasuredError(f"has {len(points)} points, must have {size}: {cure}")
    return np.array(points).reshape(2, rows, columns, 3)


def words_of(place: Place) -> str:
    """Return a position in the grid in words."""
    return "{}, row {}, column {}".format(*place)


def _table(text: str) -> tuple[list[_Row], list[str]]:
    """Return the rows of a table, and the names of its columns, given or recognised."""
    rows: list[_Row] = []
    titles: list[_Row] = []
    names: list[str] | None = None
    mark: str | None = None
    # Minus signs and dashes that text programs write instead of the hyphen.
    minus_signs = dict.fromkeys(map(ord, "\u2212\u2010\u2011\u2012\u2013\u2014\ufe63\uff0d"), "-")
    # The unit in x(mm) or X [mm].
    bracketed_unit = re.compile(r"\s*[\[(]\s*(\w+)\s*[\])]")
    for number, raw in enumerate(text.translate(minus_signs).splitlines(), 1):
        if not raw.strip() or raw.lstrip().startswith("#"):
            continue
        if not rows and (match := re.fullmatch(r'\s*"?sep=(.)"?\s*', raw, re.IGNORECASE)):
            mark = match[1]  # written for Excel
            continue
        if not rows and names is None:
            heading = _cells(bracketed_unit.sub(r"_\1", raw), mark)
            if len({cell[0].lower() for cell in heading if _COORDINATE_NAME.fullmatch(cell.lower())}) > 1:
                names = _named(heading, number)
                continue
        row = _Row(number, _cells(raw, mark))
        (titles if not rows and names is None and _is_title(row.cells) else rows).append(row)
    # A file without any point is refused for its first line.
    rows = rows or titles[:1]
    return rows, _names_without_header(rows) if names is None else names


def _cells(raw: str, mark: str | None) -> list[str]:
    """Return the cells of a line. They are separated by `mark`; without it, by semicolons, tabs, commas or
    blanks. Cells may be quoted."""
    raw = raw.strip(" \r\n")
    bare = re.sub(r'"[^"]*"', '""', raw)
    if mark is None:
        # A comma next to a tab is no decimal comma; a comma between digits is one if blanks separate.
        tab = "\t" in bare and not re.search(r",\s*\t", bare)
        decimal = len(bare.split()) > 2 and not re.search(r"(?<!\d),|,(?!\d)", bare)
        mark = ";" if ";" in bare else "\t" if tab else "," if "," in bare and not decimal else None
    try:
        cells = next(csv.reader([raw], delimiter=mark, skipinitialspace=True), []) if mark else raw.split()
    except csv.Error as error:
        raise MeasuredError(f"has a line that cannot be read as a row of a table ({error})") from None
    return [cell.strip().strip('"').strip() for cell in cells]


def _named(cells: list[str], number: int) -> list[str]:
    """Return the names of columns in lower case. Names of coordinates lose their unit, which must be mm."""
    names = []
    for cell in cells:
        match = _COORDINATE_NAME.fullmatch(cell.lower())
        if match and match[2] not in (None, "mm"):
            raise MeasuredError(f"line {number}: {cell} must be in mm: convert it and name it {cell[0]}_mm")
        names.append(match[1] if match else cell.lower())
    if missing := [name for name in "xyz" if name not in names]:
        raise MeasuredError(f"line {number} has no column {missing[0]}: give x, y and z in mm")
    return names


def _is_title(cells: list[str]) -> bool:
    """Return whether a line before the first point is a title: it has words, and neither a position in the
    grid nor three coordinates."""
    words = any(
        re.search(r"[^\W\d_]{2,}", cell) and cell.lower() not in (*FLANK_SIGN, "nan", "inf") for cell in cells
    )
    placed = len(cells) > 1 and cells[0].lower() in FLANK_SIGN and cells[1].isdigit()
    starts = range(min(2, len(cells) - 2))
    points = (all(math.isfinite(_number(cell)) for cell in cells[start : start + 3]) for start in starts)
    return words and not placed and not any(points)


def _names_without_header(rows: list[_Row]) -> list[str]:
    """Return the names of columns from their contents: x, y and z may follow the number of the point, and its
    flank, row and column."""
    first = rows[0].cells if rows else []
    labels = [row.cells[0] for row in rows]
    # Numbers of points are whole and differ; x of all points is neither.
    number = re.compile(r"(?:[^\W\d_]+[-_ ]?)?\d+[.:)]?")  # for example 7, P7 or 7:
    numbered = len(first) > 3 and len(set(labels)) == len(rows) > 1 and all(map(number.fullmatch, labels))
    placed = first[numbered : numbered + 1]
    labelled = bool(placed) and placed[0].lower() in FLANK_SIGN
    return ["number"] * numbered + ["flank", "row", "column"] * labelled + list("xyz")


def _number(cell: str) -> float:
    """Return the number in a cell, NaN if there is none. Decimal commas and Fortran exponents are read."""
    cell = re.sub(r"(?<=[\d.,])[dD](?=[-+]?\d+$)", "e", cell)
    try:
        return float(cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell)
    except ValueError:
        return math.nan


def _point(row: _Row, names: list[str]) -> tuple[Place | None, tuple[float, ...]]:
    """Return the position in the grid that a row names, if any, and its point. Raises MeasuredError."""
    given = dict(zip(names, row.cells, strict=False))
    values = row.cells[names.index("x") :]
    # 91,96,-2,78,-20,0: commas both as decimal and between the numbers.
    halves = len(values) > max(4, len(names) - names.index("x")) and all(
        re.fullmatch(r"[-+]?\d+(?:[eE][-+]?\d+)?", value) for value in values
    )
    comma = "do the numbers have decimal commas? write decimal points, or separate columns by semicolons"
    if halves:
        raise MeasuredError(f"line {row.number} has only whole numbers: {comma}")
    point, place = tuple(_number(given.get(name, "")) for name in "xyz"), None
    complete = all(map(math.isfinite, point))
    try:
        if {"flank", "row", "column"} <= given.keys():
            place = given["flank"].lower(), int(given["row"]), int(given["column"])
    except ValueError:
        complete = False
    if not complete:
        commas = any("," in given.get(name, "") for name in "xyz")
        cure = comma if commas else "measure each point of the grid"
        raise MeasuredError(f"line {row.number} has no point (x, y and z in mm): {cure}")
    return place, point
