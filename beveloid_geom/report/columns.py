"""Columns of all results: unit in JSON and CSV, unit, digits and heading in a text.

A name that is not listed is looked up without its first word, then without the first two words, and so on:
pinion_z has the column of z. Other names have no unit.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..analysis.mountings import PLACES


class Column(NamedTuple):
    """Column of a table.

    `unit` is the unit in JSON and CSV. A text has the unit `shown`, with `digits` after the decimal point,
    under the `heading`, or under the name of the column if the heading is empty."""

    unit: str = ""
    shown: str = ""
    digits: int = 4
    heading: str = ""


ARCSEC = math.degrees(3600.0)
"""Seconds of arc in a radian."""
COLUMNS = {
    name: column
    for column, names in (
        (
            Column("mm"),
            "l l1 l2 u1 u2 x y z r point least separation backlash length offset offset_difference"
            " offset_error gap shift mounting mounting_change dw1 dw2 rw1 rw2 working_radius axial"
            " axial_error axial_distance centre_distance_error tip_clearance semi_axis major minor"
            " off_centre diameter thickness height dimension beside foot_distance span",
        ),
        (Column("mm", digits=3), " ".join(f"{name}_{place}" for name in "zr" for place in PLACES)),
        (Column("mm", heading="pinion z"), "z1"),
        (Column("mm", heading="gear z"), "z2"),
        (Column("mm", digits=3, heading="pinion z middle"), "centre"),
        (Column("mm", heading="major semi-axis"), "major_semi_axis"),
        (Column("mm", heading="minor semi-axis"), "minor_semi_axis"),
        (Column("mm", "um", 3), "deviation"),
        (Column("rad", "deg"), "angle shaft_angle_error shaft_angle_difference plane_error swivel"),
        (Column("rad", "deg", 6), "roll"),
        (Column("rad", "arcsec", heading="transmission error, gear ahead"), "transmission_error"),
        (Column("rad", "arcsec", heading="transmission error"), "peak_to_peak"),
        (Column("rad", "arcsec", heading="transmission error, all teeth"), "cycle_peak_to_peak"),
        (Column("rad", "arcsec", heading="transmission error, under errors"), "greatest_cycle_peak_to_peak"),
        (Column(heading="share of edge contact"), "edge_share"),
        (Column(heading="contact ratio in a film"), "film_ratio"),
        (Column("mm/rad"), "speed profile lengthwise sliding"),
        (Column(digits=6), "contact_ratio ratio"),
        (Column(digits=3), "specific specific_total undercut_margin"),
        (Column(), "profile_shift n_x"),
        (Column(digits=2), "reserve"),
        (Column(digits=0), "pair"),
        (Column("mm^2"), "area"),
        (Column("N", digits=2), "force"),
        (Column("MPa", digits=2), "pressure"),
        (Column("1/mm", digits=7, heading="smallest relative curvature"), "least_curvature"),
        (Column("1/mm", digits=7, heading="largest relative curvature"), "greatest_curvature"),
        (Column("1/mm"), "parabola_pinion parabola_gear"),
        (Column("1/mm"), "by_offset by_centre_distance by_pinion_axial by_gear_axial"),
        (Column("1/rad"), "by_shaft_angle by_in_plane by_out_of_plane"),
    )
    for name in names.split()
}


def column(name: str) -> Column:
    """Return the column of a name, or of its longest part that is listed."""
    words = name.split("_")
    tails = ("_".join(words[start:]) for start in range(len(words)))
    return next((COLUMNS[tail] for tail in tails if tail in COLUMNS), Column())


def header_of(name: str, axis: str = "") -> str:
    """Return the header in CSV: name, axis of a vector and unit, such as least_mm or point_x_mm."""
    unit = column(name).unit.removeprefix("1").replace("/", "_per_").replace("^", "")
    return "_".join(part for part in (name, axis, unit.strip("_")) if part)


def heading(name: str) -> str:
    """Return the heading of a column in a text."""
    # The symbol n_x keeps its underscore.
    return column(name).heading or name.replace("_", " ").replace("n x", "n_x")


def unit_shown(name: str) -> str:
    """Return the unit of a column in a text."""
    return column(name).shown or column(name).unit


def label(name: str) -> str:
    """Return heading and unit for a row of a text, such as 'pinion z, mm'."""
    return ", ".join(part for part in (heading(name), unit_shown(name)) if part)


def scaled(name: str, values: Any) -> Any:
    """Return values of a column in the unit of a text."""
    # Factors from rad and mm to the units of a text.
    scales = {"deg": math.degrees(1.0), "arcsec": ARCSEC, "um": 1e3}
    return scales.get(column(name).shown, 1.0) * np.asarray(values)


def number(name: str, value: Any) -> str:
    """Return a value of a column as in a text."""
    return f"{scaled(name, value):z.{column(name).digits}f}"


def known_number(name: str, value: Any) -> str:
    """Return a value of a column as in a text, '-' for NaN."""
    return "-" if math.isnan(value) else number(name, value)


def labelled_lines(rows: Iterable[tuple[str, Iterable[str]]], label_width: int, cell_width: int) -> str:
    """Return rows of a table as text: a label, and right-aligned cells of equal width."""
    lines = (
        f"{label:<{label_width}}" + "".join(f"{x:>{cell_width}}" for x in cells) for label, cells in rows
    )
    return "\n".join(lines) + "\n"


def aligned(cells: Iterable[str], widths: Iterable[int]) -> str:
    """Return right-aligned cells of the given widths."""
    return "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))


def table_lines(
    columns: Mapping[str, Any], status: Sequence[str], words: Mapping[str, Sequence[str]] | None = None
) -> str:
    """Return a table as text, one row for each position.

    Parameters
    ----------
    columns : mapping
        Numbers (n,) by name of the column.
    status : sequence of str
        'solved', or the text that replaces the numbers of the row.
    words : mapping, optional
        Texts (n,) at the end of each row, by heading.
    """
    rows, widths = [""] * len(status), []
    headings: list[list[str]] = []
    for name, values in columns.items():
        cells = [number(name, value) for value in values]
        longest = max(map(len, (*heading(name).split(), *cells)))
        width = max(6 + column(name).digits, 1 + longest)
        headings.append([*textwrap.wrap(heading(name), width - 1), unit_shown(name)])
        widths.append(width)
        rows = [row + f"{cell:>{width}}" for row, cell in zip(rows, cells, strict=True)]
    rows = [row if state == "solved" else f"{state:>24}" for row, state in zip(rows, status, strict=True)]
    # Headings of different heights are aligned at the unit, their last line.
    depth = max(map(len, headings))
    same_height = ([""] * (depth - len(lines)) + lines for lines in headings)
    top = [aligned(row, widths) for row in zip(*same_height, strict=True)]
    for name, texts in (words or {}).items():
        top[-2] += f"  {name}"
        rows = [f"{row}  {text}" for row, text in zip(rows, texts, strict=True)]
    return "\n".join([*(row.rstrip() for row in top), *rows]) + "\n"
