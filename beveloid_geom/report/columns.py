"""The columns of all results: name, unit in JSON and CSV, and how a text shows it.

A name that is not here is looked up without its first word, and so on: pinion_z is a z. Names that are
found nowhere have no unit.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np


class Column(NamedTuple):
    """`unit` in JSON and CSV; a text has `digits` after the point in the unit `shown`, under a `heading`
    if the name itself is none."""

    unit: str = ""
    shown: str = ""
    digits: int = 4
    heading: str = ""


ARCSEC = math.degrees(3600.0)
SCALES = {"deg": math.degrees(1.0), "arcsec": ARCSEC, "um": 1e3}
"""From rad and mm to the units of a text."""
MM, ANGLE, SWING, SPEED = Column("mm"), Column("rad", "deg"), Column("rad", "arcsec"), Column("mm/rad")
PLACES = ("enter", "middle", "leave")
COLUMNS: dict[str, Column] = {
    **dict.fromkeys(
        (
            *("l", "l1", "l2", "u1", "u2", "x", "y", "z", "r"),
            *("point", "least", "separation", "backlash", "length"),
        ),
        MM,
    ),
    **{f"{name}_{place}": Column("mm", digits=3) for name in ("z", "r") for place in PLACES},
    "z1": Column("mm", heading="pinion z"),
    "z2": Column("mm", heading="gear z"),
    **dict.fromkeys(("offset", "offset_difference", "gap", "shift", "mounting", "mounting_change"), MM),
    **dict.fromkeys(
        ("dw1", "dw2", "rw1", "rw2", "working_radius", "offset_error", "axial_error", "axial"), MM
    ),
    "centre_distance_error": MM,
    "centre": Column("mm", digits=3, heading="pinion z middle"),
    "roll": Column("rad", "deg", 6),
    **dict.fromkeys(("angle", "shaft_angle_error", "shaft_angle_difference", "plane_error"), ANGLE),
    "transmission_error": SWING,
    "peak_to_peak": SWING._replace(heading="transmission error"),
    "cycle_peak_to_peak": SWING._replace(heading="the same of all teeth"),
    "greatest_cycle_peak_to_peak": SWING._replace(heading="greatest under errors"),
    "edge_share": Column(digits=4, heading="share carried by edges"),
    "film_ratio": Column(heading="contact ratio in a film"),
    **dict.fromkeys(("speed", "profile", "lengthwise", "sliding"), SPEED),
    **dict.fromkeys(("specific", "specific_total"), Column(digits=3)),
    **dict.fromkeys(("contact_ratio", "ratio"), Column(digits=6)),
    "area": Column("mm^2"),
    **dict.fromkeys(("major", "minor", "off_centre"), MM),
    **dict.fromkeys(("diameter", "thickness", "height", "dimension", "beside"), MM),
    "swivel": ANGLE,
    "pair": Column(digits=0),
    "deviation": Column("mm", "um", 3),
    "profile_shift": Column(),
    "tip_clearance": MM,
    "undercut_margin": Column(digits=3),
    "reserve": Column(digits=2),
    "n_x": Column(),  # of a unit normal
    "force": Column("N", digits=2),
    "curvature": Column("1/mm", digits=7),
    "semi_axis": MM,
    "pressure": Column("MPa", digits=2),
    **dict.fromkeys(("parabola_pinion", "parabola_gear"), Column("1/mm")),
    **dict.fromkeys(("by_offset", "by_centre_distance", "by_pinion_axial", "by_gear_axial"), Column("1/mm")),
    **dict.fromkeys(("by_shaft_angle", "by_in_plane", "by_out_of_plane"), Column("1/rad")),
}


def column(name: str) -> Column:
    """Give the column of that name, or of the longest tail of it that is known."""
    words = name.split("_")
    tails = ("_".join(words[start:]) for start in range(len(words)))
    return next((COLUMNS[tail] for tail in tails if tail in COLUMNS), Column())


def header_of(name: str, axis: str = "") -> str:
    """Give the header in CSV: the name, the `axis` of a vector, the unit, as in least_mm, point_x_mm."""
    unit = column(name).unit.removeprefix("1").replace("/", "_per_").replace("^", "")
    return "_".join(part for part in (name, axis, unit.strip("_")) if part)


def heading(name: str) -> str:
    """Give the words for a column in a text."""
    return column(name).heading or name.replace("_", " ")


def unit_shown(name: str) -> str:
    """Give the unit of a column in a text."""
    return column(name).shown or column(name).unit


def label(name: str) -> str:
    """Give words and unit for a row of a text, as in 'pinion z, mm'."""
    return ", ".join(part for part in (heading(name), unit_shown(name)) if part)


def scaled(name: str, values: Any) -> Any:
    """Give values of a column in the unit of a text."""
    return SCALES.get(column(name).shown, 1.0) * np.asarray(values)


def number(name: str, value: Any, width: int = 0) -> str:
    """Write a value of a column as a text has it."""
    return f"{scaled(name, value):z{width or ''}.{column(name).digits}f}"


def table_lines(
    columns: Mapping[str, Any], status: Sequence[str], words: Mapping[str, Sequence[str]] | None = None
) -> str:
    """Write a table of columns (n,), a row for each position that is solved, the name of its `status` for
    every other; columns of `words` end a row."""
    rows, widths = [""] * len(status), []
    heads: list[list[str]] = []
    for name, values in columns.items():
        width = max(6 + column(name).digits, 1 + max(map(len, heading(name).split())))
        heads.append([*textwrap.wrap(heading(name), width - 1), unit_shown(name)])
        widths.append(width)
        rows = [row + number(name, value, width) for row, value in zip(rows, values, strict=True)]
    rows = [row if state == "solved" else f"{state:>24}" for row, state in zip(rows, status, strict=True)]
    depth = max(map(len, heads))
    filled = ([""] * (depth - len(head)) + head for head in heads)
    tops = [
        "".join(f"{word:>{width}}" for word, width in zip(row, widths, strict=True))
        for row in zip(*filled, strict=True)
    ]
    for name, listed in (words or {}).items():
        tops[-2] += f"  {name}"
        rows = [f"{row}  {word}" for row, word in zip(rows, listed, strict=True)]
    return "\n".join([*(top.rstrip() for top in tops), *rows]) + "\n"
