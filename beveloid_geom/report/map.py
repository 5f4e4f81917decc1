"""A map of a design over two of its values."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.maps import FIGURES, IN_OPERATION, UNITS, DesignMap, own_values
from ..arrays import Mask
from ..design.model import Design
from ..status import Status
from .columns import column, label, scaled
from .result import Rows
from .words import WIDTH, error_words, head_data, head_lines, line, status_name, status_words

ALIKE = 1e-9
"""In the unit of the text: figures no further apart are the same everywhere."""
AS_GOOD = 1e-9
"""Share by which a contact ratio may miss what is asked for: that of the design itself is met by its cell."""
WORDS = {
    "parabola": "parabola coefficients",
    "mounting": "changes of the mounting distances",
    "shift": "profile shift coefficients",
}
SIDES = {
    "parabola": ("parabola_pinion", "parabola_gear"),
    "mounting": ("pinion_mounting_change", "gear_mounting_change"),
    "shift": ("profile_shift_pinion", "profile_shift_gear"),
}
"""Columns of the values."""


@dataclass(frozen=True, eq=False)
class MapReport:
    """The map `found` of a single design."""

    name: str
    found: DesignMap

    @property
    def reason(self) -> str | None:
        """Why there is nothing to be seen, None if some cell has a path."""
        none = f"no cell of the map has a path on the {self.found.flank} flanks"
        return None if self.found.solved.any() else none

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give the map, in it a row for each value of the pinion."""
        found = self.found
        data = {
            **head_data(self.name, found.design, found.flank),
            "over": found.over,
            "errors": dict(vars(found.errors)),
            "pinion": found.pinion,
            "gear": found.gear,
            "map": {
                "status": [[status_name(code) for code in row] for row in found.status.tolist()],
                **{mask: getattr(found, mask) for mask in ("hollow", "interferes", "jammed")},
                **{figure: getattr(found, figure) for figure in figures_of(found)},
            },
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the cells."""
        return map_rows(self.found)

    def summary(self) -> str:
        """Write the extremes of the figures and where they are."""
        found, unit = self.found, UNITS[self.found.over]
        shape = f"{found.pinion.size} x {found.gear.size} cells"
        text = f"Map of {self.name} over the {WORDS[found.over]}, {found.flank} flanks: {shape}\n"
        text += head_lines(found.design) + line("errors for shift", error_words(found.errors))
        sides = (
            f"{member} {values[0]:.6g} to {values[-1]:.6g} {unit}".rstrip()
            for member, values in (("pinion", found.pinion), ("gear", found.gear))
        )
        text += line("values", ", ".join(sides)) + line("cells", cell_words(found))
        if self.reason:
            return text
        sound = bool(found.sound.any())
        cells = found.sound if sound else found.solved
        which = "neither hollow nor with negative backlash" if sound else "with a path, none of it sound"
        where = f"values of the members in {unit}" if unit else "values of the members have no unit"
        text += f"\nOf the {np.count_nonzero(cells)} cells {which}, {where}:\n"
        return text + _extreme_lines(found, cells) + _quadrant_lines(found)


def map_rows(found: DesignMap) -> Rows:
    """Give the cells of a map as columns."""
    sides = np.meshgrid(found.pinion, found.gear, indexing="ij")
    masks = ("hollow", "interferes", "jammed")
    return {
        **{name: side.ravel() for name, side in zip(SIDES[found.over], sides, strict=True)},
        "status": [status_name(code) for code in found.status.ravel().tolist()],
        **{name: getattr(found, name).astype(int).ravel() for name in masks},
        **{figure: getattr(found, figure).ravel() for figure in figures_of(found)},
    }


def figures_of(found: DesignMap) -> tuple[str, ...]:
    """Give the names of what a map holds: what it has of the operation only if some cell does."""
    return (*FIGURES, *(name for name in IN_OPERATION if np.isfinite(getattr(found, name)).any()))


def cell_words(found: DesignMap) -> str:
    """Say how many cells have a path, how many have none by status, and how many no pair can run in."""
    counts = {status_words(status): found.status == status for status in Status}
    words = [f"{count} {name}" for name, mask in counts.items() if (count := int(np.count_nonzero(mask)))]
    for mask, text in (
        (found.solved & np.isnan(found.shift), "an error of the shift carries the path off the flanks"),
        (found.hollow, "the flanks are hollow against each other"),
        (found.interferes, "the backlash is negative"),
        (found.jammed, "the pair cannot be assembled"),
    ):
        if count := int(np.count_nonzero(mask)):
            words.append(f"in {count} {text}")
    return ", ".join(words)


def _extreme_lines(found: DesignMap, cells: Mask) -> str:
    """Write least and greatest of each figure over some cells, and where; of the angle its magnitude."""
    lines = [f"{'':<27}{'least':>10}{'pinion':>11}{'gear':>11}{'greatest':>12}{'pinion':>11}{'gear':>11}"]
    for figure in figures_of(found):
        values = np.where(cells, scaled(figure, getattr(found, figure)), np.nan)
        values = np.abs(values) if figure == "angle" else values
        if np.isnan(values).all():
            continue
        text, digits = f"{label(figure):<27}", column(figure).digits
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
    """Count in each of the paper's quadrants of a map of coefficients, C1 to C4, the sound cells that reach a
    contact `ratio`, and find the least shift (mm) of those and where it is; NaN without any."""
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
    """Give the contact ratio of the design as it is, NaN if that is not known."""
    from ..contact.path import contact_ratio

    return float(contact_ratio(design, flank))


def _quadrant_lines(found: DesignMap) -> str:
    """Compare the paper's cases at a contact ratio no lower than as given."""
    if found.over != "parabola":
        return ""
    ratio = ratio_as_given(found.design, found.flank)
    if not ratio > 0.0:
        return "\nThe design itself has no contact ratio to be kept: the cases are not compared.\n"
    own = "pinion {:g}, gear {:g}".format(*own_values(found.design, found.over))
    least = f"Least shift where the contact ratio is at least {ratio:.4f}, that of the design ({own}):"
    text = f"\n{textwrap.fill(least, WIDTH)}\n"
    for name, (count, shift, where) in quadrant_bests(found, ratio).items():
        if math.isnan(shift):
            text += f"{name:<20}no such cell\n"
        else:
            at = "pinion {:.4g}, gear {:.4g}".format(*where)
            text += f"{name:<20}{shift:10.4f} mm at {at}; such cells: {count}\n"
    return text
