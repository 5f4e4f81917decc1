"""A map of a design as text: table, JSON and CSV."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..analysis.maps import FIGURES, UNITS, DesignMap, Mask, own_values
from ..design.model import Design
from ..pair.mounting import mounting_of
from ..status import Status
from .path import (
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    parabola_line,
    status_name,
)

SHOWN = {
    "contact_ratio": ("contact ratio", 1.0, 4),
    "angle": ("angle, deg", math.degrees(1.0), 3),
    "shift": ("shift, mm", 1.0, 4),
    "peak_to_peak": ("tr. error, arcsec", math.degrees(3600.0), 3),
    "centre": ("pinion z middle, mm", 1.0, 3),
    "normal_backlash": ("backlash, mm", 1.0, 4),
    "mounted_backlash": ("as mounted, mm", 1.0, 4),
    "flank_share": ("flanks first, share", 1.0, 3),
}
"""Rows of the table: figure, label, scale, digits; of the angle its magnitude."""
ALIKE = 1e-9
"""In the unit of the table: figures no further apart are the same everywhere."""
AS_GOOD = 1e-9
"""Share by which a contact ratio may miss what is asked for: that of the design itself is met by its cell."""
SUFFIXES = {
    "angle": "_rad",
    "shift": "_mm",
    "peak_to_peak": "_rad",
    "centre": "_mm",
    "normal_backlash": "_mm",
    "mounted_backlash": "_mm",
}
WORDS = {
    "parabola": "parabola coefficients",
    "mounting": "changes of the mounting distances",
    "shift": "profile shift coefficients",
}
COLUMNS = {
    "parabola": ("parabola_pinion_per_mm", "parabola_gear_per_mm"),
    "mounting": ("pinion_mounting_change_mm", "gear_mounting_change_mm"),
    "shift": ("profile_shift_pinion", "profile_shift_gear"),
}
"""Names of the values in CSV."""


def map_json(name: str, found: DesignMap) -> str:
    """Strict JSON of a map, mm and rad: in `map` a row for each value of the pinion."""
    design = found.design
    data: dict[str, Any] = {
        "design": name,
        "flank": found.flank,
        **layout_data(design, mounting_of(design)),
        "parabola": {"pinion": design.pinion.tool.parabola, "gear": design.gear.tool.parabola},
        "over": found.over,
        "errors": dict(vars(found.errors)),
        "pinion": found.pinion,
        "gear": found.gear,
        "map": {
            "status": [[status_name(code) for code in row] for row in found.status.tolist()],
            "hollow": found.hollow,
            "interferes": found.interferes,
            "jammed": found.jammed,
            **{figure: getattr(found, figure) for figure in FIGURES},
        },
    }
    return json_text(data)


def map_csv(found: DesignMap) -> str:
    """CSV of a map, one cell a row, mm and rad, units in the header."""
    return csv_text(*map_columns(found))


def map_columns(found: DesignMap) -> tuple[list[str], list[list[Any]]]:
    """Names with units, and values by cells, of the columns of a map."""
    header = [*COLUMNS[found.over], "status", "hollow", "interferes", "jammed"]
    header += [f"{figure}{SUFFIXES.get(figure, '')}" for figure in FIGURES]
    sides = np.meshgrid(found.pinion, found.gear, indexing="ij")
    columns: list[list[Any]] = [side.ravel().tolist() for side in sides]
    columns.append([status_name(code) for code in found.status.ravel().tolist()])
    columns += [mask.astype(int).ravel().tolist() for mask in (found.hollow, found.interferes, found.jammed)]
    columns += [getattr(found, figure).ravel().tolist() for figure in FIGURES]
    return header, columns


def map_table(name: str, found: DesignMap) -> str:
    """Readable summary of a map, at most 100 characters wide, in mm, deg and arc seconds."""
    design, unit = found.design, UNITS[found.over]
    shape = f"{found.pinion.size} x {found.gear.size} cells"
    text = f"Map of {name} over the {WORDS[found.over]}, {found.flank} flanks: {shape}\n"
    text += layout_line(design, mounting_of(design)) + error_line(design.errors) + parabola_line(design)
    text += line("errors for shift", " ".join(error_line(found.errors).split()[1:]))
    sides = (
        f"{member} {values[0]:.6g} to {values[-1]:.6g} {unit}".rstrip()
        for member, values in (("pinion", found.pinion), ("gear", found.gear))
    )
    text += line("values", ", ".join(sides)) + line("cells", cell_words(found))
    if not found.solved.any():
        return text
    cells = found.sound if found.sound.any() else found.solved
    which = (
        "neither hollow nor with negative backlash" if found.sound.any() else "with a path, none of it sound"
    )
    where = f"values of the members in {unit}" if unit else "values of the members have no unit"
    text += f"\nOf the {np.count_nonzero(cells)} cells {which}, {where}:\n"
    return text + _extreme_lines(found, cells) + _quadrant_lines(found)


def cell_words(found: DesignMap) -> str:
    """How many cells have a path, which have none by status, and of which nothing is to be hoped."""
    words = []
    for status in Status:
        count = int(np.count_nonzero(found.status == status))
        if count:
            words.append(f"{count} {status_name(status).replace('_', ' ')}")
    lost = int(np.count_nonzero(found.solved & np.isnan(found.shift)))
    for count, text in (
        (lost, "an error of the shift carries the path off the flanks"),
        (int(np.count_nonzero(found.hollow)), "the flanks are hollow against each other"),
        (int(np.count_nonzero(found.interferes)), "the backlash is negative"),
        (int(np.count_nonzero(found.jammed)), "the pair cannot be assembled"),
    ):
        if count:
            words.append(f"in {count} {text}")
    return ", ".join(words)


def _extreme_lines(found: DesignMap, cells: Mask) -> str:
    """Least and greatest of each figure over some cells, and where."""
    lines = [f"{'':<20}{'least':>10}{'pinion':>11}{'gear':>11}{'greatest':>12}{'pinion':>11}{'gear':>11}"]
    for figure, (label, scale, digits) in SHOWN.items():
        values = scale * np.where(cells, getattr(found, figure), np.nan)
        values = np.abs(values) if figure == "angle" else values
        if np.isnan(values).all():
            continue
        text = f"{label:<20}"
        if np.nanmax(values) - np.nanmin(values) < ALIKE:
            lines.append(f"{text}{np.nanmin(values):z10.{digits}f}  in all of them")
            continue
        for width, pick in ((10, np.nanargmin), (12, np.nanargmax)):
            i, j = np.unravel_index(pick(values), values.shape)
            at = found.pinion[i], found.gear[j]
            text += f"{values[i, j]:z{width}.{digits}f}" + "".join(f"{v + 0.0:11.4g}" for v in at)
        lines.append(text)
    return "\n".join(lines) + "\n"


def quadrant_bests(found: DesignMap, ratio: float) -> dict[str, tuple[int, float, tuple[float, float]]]:
    """Of each of the paper's quadrants of a map of coefficients, C1 to C4: how many of its sound cells
    reach a contact ratio, and of those the least shift (mm) and where; NaN without any."""
    bests = {}
    for name, cells in found.quadrants().items():
        with np.errstate(invalid="ignore"):
            good = cells & found.sound & (found.contact_ratio >= (1.0 - AS_GOOD) * ratio)
        shift = np.where(good, found.shift, np.nan)
        if np.isnan(shift).all():
            bests[name] = (int(np.count_nonzero(good)), math.nan, (math.nan, math.nan))
            continue
        i, j = np.unravel_index(np.nanargmin(shift), shift.shape)
        where = float(found.pinion[i]), float(found.gear[j])
        bests[name] = (int(np.count_nonzero(good)), float(shift[i, j]), where)
    return bests


def ratio_as_given(design: Design, flank: str) -> float:
    """Contact ratio of the design as it is, NaN if that is not known."""
    from ..contact.path import contact_ratio

    return float(contact_ratio(design, flank))


def _quadrant_lines(found: DesignMap) -> str:
    """The paper's cases against each other at a contact ratio no lower than as given."""
    if found.over != "parabola":
        return ""
    ratio = ratio_as_given(found.design, found.flank)
    if not ratio > 0.0:
        return "\nThe design itself has no contact ratio to be kept: the cases are not compared.\n"
    own = "pinion {:g}, gear {:g}".format(*own_values(found.design, found.over))
    text = f"\nLeast shift where the contact ratio is at least {ratio:.4f}, that of the design ({own}):\n"
    for name, (count, shift, where) in quadrant_bests(found, ratio).items():
        if math.isnan(shift):
            text += f"{name:<20}no such cell\n"
        else:
            at = "pinion {:.4g}, gear {:.4g}".format(*where)
            text += f"{name:<20}{shift:10.4f} mm at {at}; such cells: {count}\n"
    return text
