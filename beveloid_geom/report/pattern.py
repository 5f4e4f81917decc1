"""Reports of `pattern`: a contact pattern on both flanks, and a matrix of patterns under two errors."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..analysis.pattern_ellipse import marked_ellipse
from ..analysis.pattern_matrix import PatternCell, PatternMatrix
from ..arrays import MEMBERS
from ..design.model import Design
from ..findings.backlash import backlash_report
from ..operation.contact_pattern.pattern import (
    RELATIVE_AREA_ERROR,
    ContactPattern,
    MemberPattern,
    contact_pattern,
)
from ..status import FirstStatus, NotComputed
from .columns import aligned, number, scaled
from .result import ResultReport, Rows, flattened, picked, plain, stacked_rows
from .text import ERROR_SYMBOLS, SYMBOLS, line, mounted_lines, symbol_words, unit_of

POINTS_PER_MODULE = 15
"""Points of a pattern per module."""
SIZES = ("area", "area_share", "area_error")
"""Quantities of the pattern on one member."""


@dataclass(frozen=True, eq=False)
class PatternReport(ResultReport[ContactPattern]):
    """Contact pattern of one flank pair of a single design.

    Attributes
    ----------
    resolution : float
        Distance of the points, mm.
    area_error : float
        Requested limit of the relative error of the areas.
    """

    needs_assembly = True
    resolution: float
    area_error: float

    @property
    def sides(self) -> dict[str, MemberPattern]:
        """Patterns on both flanks by member."""
        return {"pinion": self.result.pinion, "gear": self.result.gear}

    @cached_property
    def nominal(self) -> PatternReport | None:
        """Report of the flanks without their measured deviations; None if no flank has such deviations, or if
        the pattern without them is not known."""
        asked = self.result.separation, self.resolution, self.area_error
        with suppress(ValueError):
            if self.design.measured:
                return pattern_report(self.name, self.design.nominal(), self.flank, *asked)
        return None

    def values(self) -> dict[str, Any]:
        """Return sizes and ellipses of the pattern by member."""
        members = {
            member: {
                **picked(side, *SIZES),
                "z_range": marked_face(side),
                "ellipse": marked_ellipse(side, self.result.separation),
            }
            for member, side in self.sides.items()
        }
        values = {
            "separation": self.result.separation,
            "resolution": self.resolution,
            "roll_range": self.result.roll_range,
            **members,
        }
        if self.nominal is not None:
            values["nominal"] = {name: picked(side, *SIZES) for name, side in self.nominal.sides.items()}
        return values

    def rows(self) -> Rows:
        """Return the points of both flanks and the sizes of their patterns."""
        backlash = backlash_report(self.design).normal
        return stacked_rows([_points(member, side, backlash) for member, side in self.sides.items()])

    def summary(self) -> str:
        """Return the sizes of the pattern."""
        text = f"Contact pattern of {self.name}, {self.result.flank} flanks\n" + mounted_lines(self.design)
        text += line("marking compound", f"{1e3 * self.result.separation:g} um thick")
        rolls = " to ".join(f"{math.degrees(roll):z.4f}" for roll in self.result.roll_range)
        text += line("pinion rolls", f"{rolls} deg, one tooth pair from before its contact until after it")
        text += "".join(
            _side_lines(member, side, self.area_error, self.result.separation)
            for member, side in self.sides.items()
        )
        if self.nominal is not None:
            shares = (f"{name} {100.0 * side.area_share:.1f} %" for name, side in self.nominal.sides.items())
            text += line("nominal flanks", f"{', '.join(shares)} of the active flank without deviations")
        return text


def pattern_report(
    name: str,
    design: Design,
    flank: str,
    separation: float,
    resolution: float | None = None,
    area_error: float = RELATIVE_AREA_ERROR,
) -> PatternReport:
    """Return the pattern of a single design.

    The default `resolution` is 1/15 of the module. Arguments and ValueError as in `contact_pattern`."""
    if resolution is None:
        resolution = float(design.pinion.tool.normal_module) / POINTS_PER_MODULE
    pattern = contact_pattern(design, flank, separation, resolution=resolution, area_error=area_error)
    return PatternReport(name, design, pattern, resolution, area_error)


def marked_face(side: MemberPattern) -> tuple[float, float]:
    """Return the smallest and the largest z of the marked area, mm, from its border; NaN without any."""
    z = np.concatenate([polygon[:, 2] for polygon in (*side.border, np.empty((0, 3)))])
    return (float(z.min()), float(z.max())) if z.size else (math.nan, math.nan)


def _points(member: str, side: MemberPattern, backlash: float) -> dict[str, Any]:
    """Return the columns of one flank; sizes and backlash are repeated for each point."""
    # Quantities of a point.
    fields = ("l", "z", "least", "pinion_roll")
    points = flattened(picked(side, *fields, "marked", "status"))
    return {"member": member, **points, **picked(side, *SIZES), "mounted_backlash": backlash}


def _side_lines(member: str, side: MemberPattern, requested: float, separation: float) -> str:
    """Return the lines on size, extent, ellipse and error bound of the pattern on one member.

    `requested` is the limit of the relative error of the area."""
    low, high = marked_face(side)
    words = f"{side.area:.1f} mm^2 marked, {100.0 * side.area_share:.1f} % of the active flank"
    text = line(member, words if math.isnan(low) else f"{words}, z {low:z.2f} to {high:z.2f} mm")
    bound = f"error of the area at most {100.0 * side.area_error:.2g} %"
    missed = "" if side.area_error <= requested else f", above the requested {100.0 * requested:g} %"
    least = side.least[np.isfinite(side.least)]
    nearest = (
        f"smallest separation {1e3 * least.min():z.4f} um" if least.size else "no point is opposite a flank"
    )
    text += line("", bound + missed)
    ellipse = marked_ellipse(side, separation)
    if not math.isnan(ellipse.major):  # NaN if the grid does not resolve the pattern
        text += line(
            "",
            f"ellipse with its centre at z {ellipse.z:z.2f}, r {ellipse.r:.2f} mm: semi-axes"
            f" {ellipse.major:.2f} and {ellipse.minor:.2f} mm,"
            f" {math.degrees(ellipse.angle):z.1f} deg to the axial direction",
        )
    return text + line("", nearest)


ELLIPSE = ("z", "r", "major", "minor", "angle")
"""Quantities of an ellipse."""
FIGURES = ("normal_backlash", "cycle_peak_to_peak", "edge_share")
"""Quantities of a cell."""
COLUMN_WIDTHS = (10, 12, 12, 10, 9, 9, 16, 12, 10)
"""Characters of the columns of the text."""


@dataclass(frozen=True, eq=False)
class PatternMatrixReport(ResultReport[PatternMatrix]):
    """Matrix of contact patterns of a single design under two errors."""

    @property
    def reason(self) -> str | None:
        """Reason why no cell has a pattern, None if one has."""
        if any(self.result.cells):
            return None
        words = sorted({word.replace("_", " ") for word in status_of(self.result)})
        text = f"no cell of the matrix has a pattern on the {self.flank} flanks: {', '.join(words)}"
        # A failed calculation does not prove that there is no pattern.
        codes = self.result.status[~self.result.jammed & (self.result.status != FirstStatus.SOLVED)]
        failed = any(FirstStatus(code).reason_type is NotComputed for code in codes.tolist())
        return NotComputed(text) if failed else text

    @property
    def _records(self) -> list[dict[str, Any]]:
        """Errors, status and quantities of each cell."""
        matrix, status = self.result, status_of(self.result)
        return [
            {f"{name}_error": value for name, value in zip(matrix.over, errors, strict=True)}
            | {"status": status[k]}
            | {name: float(getattr(matrix, name).ravel()[k]) for name in FIGURES}
            for k, errors in enumerate(matrix.added.tolist())
        ]

    def values(self) -> dict[str, Any]:
        """Return the cells, row by row; mm and rad."""
        matrix = self.result
        cells = [
            record | {m: None if cell is None else member_data(cell, j) for j, m in enumerate(MEMBERS)}
            for cell, record in zip(matrix.cells, self._records, strict=True)
        ]
        symbols = [SYMBOLS.get(name) for name in matrix.over]
        values = picked(matrix, "separation", "first", "second")
        return {"over": matrix.over, "trade": symbols, **values, "cells": cells}

    def rows(self) -> Rows:
        """Return one row for each flank of each cell."""
        unknown = dict.fromkeys((*SIZES, *ELLIPSE), np.nan)
        return stacked_rows(
            [
                record | {"member": member} | (unknown if cell is None else flat_data(cell, j))
                for cell, record in zip(self.result.cells, self._records, strict=True)
                for j, member in enumerate(MEMBERS)
            ]
        )

    def summary(self) -> str:
        """Return the cells with the pattern on the pinion, and the definitions of the columns."""
        matrix = self.result
        text = f"Contact patterns of {self.name} under two errors, {self.flank} flanks, on the pinion\n\n"
        headings = [*(f"{ERROR_SYMBOLS[name]}, {unit_of(name)}" for name in matrix.over)]
        headings += ["TE, arcsec", "edges, %", "z, mm", "r, mm", "semi-axes, mm", "angle, deg", "marked, %"]
        text += aligned(headings, COLUMN_WIDTHS) + "\n"
        for cell, record in zip(matrix.cells, self._records, strict=True):
            errors = (scaled(key, record[key]) for key in (f"{name}_error" for name in matrix.over))
            text += aligned((f"{value:z.4g}" for value in errors), COLUMN_WIDTHS[:2])
            if cell is None:
                text += f"  {record['status'].replace('_', ' ')}\n"
                continue
            ellipse, side = cell.ellipses[0], cell.pattern.pinion
            cells = (
                number("cycle_peak_to_peak", record["cycle_peak_to_peak"]),
                *(f"{100.0 * record['edge_share']:.1f}", f"{ellipse.z:z.2f}", f"{ellipse.r:.2f}"),
                f"{ellipse.major:.2f} x {ellipse.minor:.2f}",
                *(f"{np.degrees(ellipse.angle):z.1f}", f"{100.0 * side.area_share:.1f}"),
            )
            text += aligned(cells, COLUMN_WIDTHS[2:]) + "\n"
        text += "\n" + mounted_lines(self.design)
        text += line("errors added", ", ".join(symbol_words(name) for name in matrix.over))
        text += line("marking compound", f"{1e3 * matrix.separation:g} um thick")
        text += line(
            "TE, edges",
            "transmission error of all teeth over a mesh cycle, share of the cycle with edge contact",
        )
        text += line(
            "z to angle",
            "ellipse with the centre and the second moments of the marked area; z along the axis towards +z,"
            " r from the axis, angle of the major axis to the axial direction",
        )
        jams = np.count_nonzero(matrix.jammed)
        note = f"jammed: {jams} of {matrix.jammed.size} mountings cannot be assembled"
        return text + (line("note", note) if jams else "")


def status_of(matrix: PatternMatrix) -> list[str]:
    """Return the status of each cell as in files: 'jammed', or the status of its mesh cycle."""
    names = plain(matrix.status.ravel(), FirstStatus)
    return ["jammed" if jam else name for name, jam in zip(names, matrix.jammed.ravel(), strict=True)]


def member_data(cell: PatternCell, member: int) -> dict[str, Any]:
    """Return sizes and ellipse of the pattern on pinion (0) or gear (1)."""
    side = (cell.pattern.pinion, cell.pattern.gear)[member]
    return picked(side, *SIZES) | {"ellipse": plain(cell.ellipses[member])}


def flat_data(cell: PatternCell, member: int) -> dict[str, Any]:
    """Return sizes and ellipse of the pattern on pinion (0) or gear (1) in one dictionary."""
    sizes = member_data(cell, member)
    ellipse: dict[str, Any] = sizes.pop("ellipse")
    return sizes | ellipse
