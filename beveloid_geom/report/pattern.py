"""A contact pattern as text: table, JSON and CSV."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..design.model import Design
from ..operation.pattern import AREA_ERROR, ContactPattern, MemberPattern, contact_pattern
from ..pair.mounting import Mounting, mounting_of
from ..status import PatternStatus
from .backlash import backlash_report
from .path import (
    backlash_lines,
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    parabola_line,
)

FINE = 15
"""Points of a pattern to a module: some pixels apart where a flank is drawn."""
FIELDS = (("l", "_mm"), ("z", "_mm"), ("least", "_mm"), ("pinion_roll", "_rad"))
"""Numbers of a point, with the units in a CSV's header."""
SIZES = {"area": "area_mm2", "area_share": "area_share", "area_error": "area_error"}
"""Numbers of a member's pattern, with their headers in a CSV; the same in all its rows."""


@dataclass(frozen=True, eq=False)
class PatternReport:
    """The contact `pattern` of one flank pair of a single design, at points about every `resolution`, mm;
    its areas were to be right to the share `area_error`."""

    name: str
    design: Design
    mounting: Mounting
    pattern: ContactPattern
    resolution: float
    area_error: float

    @property
    def sides(self) -> dict[str, MemberPattern]:
        """The patterns on both flanks by member."""
        return {"pinion": self.pattern.pinion, "gear": self.pattern.gear}


def pattern_report(
    name: str,
    design: Design,
    flank: str,
    separation: float,
    resolution: float | None = None,
    area_error: float = AREA_ERROR,
) -> PatternReport:
    """The pattern of a single design; lengths in mm, the resolution a FINE part of the module unless told.
    Arguments and ValueError as of `contact_pattern`."""
    resolution = float(design.pinion.tool.normal_module) / FINE if resolution is None else resolution
    pattern = contact_pattern(design, flank, separation, resolution=resolution, area_error=area_error)
    return PatternReport(name, design, mounting_of(design), pattern, resolution, area_error)


def marked_face(side: MemberPattern) -> tuple[float, float]:
    """Least and greatest z (mm) of the marked points, NaN without any."""
    z = side.z[side.marked]
    return (float(z.min()), float(z.max())) if z.size else (math.nan, math.nan)


def pattern_json(report: PatternReport) -> str:
    """Strict JSON of the sizes of a pattern, mm and rad."""
    pattern, design = report.pattern, report.design
    data: dict[str, Any] = {
        "design": report.name,
        "flank": pattern.flank,
        **layout_data(design, report.mounting),
        "parabola": {"pinion": design.pinion.tool.parabola, "gear": design.gear.tool.parabola},
        "separation": pattern.separation,
        "resolution": report.resolution,
        "roll_range": pattern.roll_range,
    }
    for member, side in report.sides.items():
        sizes = {name: getattr(side, name) for name in SIZES}
        data[member] = {**sizes, "z_range": marked_face(side)}
    return json_text(data)


def pattern_csv(report: PatternReport) -> str:
    """CSV of the points of both flanks and the sizes of their patterns, mm and rad, units in the header."""
    header = ["member", *(name + unit for name, unit in FIELDS), "marked", "status", *SIZES.values()]
    header.append("mounted_backlash_mm")
    backlash = backlash_report(report.design).normal
    columns: list[list[Any]] = [[] for _ in header]
    for member, side in report.sides.items():
        status = [PatternStatus(int(code)).name.lower() for code in side.status.ravel()]
        numbers = (getattr(side, name).ravel().tolist() for name, _ in FIELDS)
        marked = side.marked.ravel().astype(int).tolist()
        sizes = ([getattr(side, name)] * len(status) for name in SIZES)
        values = ([member] * len(status), *numbers, marked, status, *sizes, [backlash] * len(status))
        for column, added in zip(columns, values, strict=True):
            column += added
    return csv_text(header, columns)


def _bound(side: MemberPattern, asked: float) -> str:
    """What is known of the error of an area."""
    words = f"right to {100.0 * side.area_error:.2g} % of the area"
    return words if side.area_error <= asked else f"{words}, not to the {100.0 * asked:g} % asked for"


def pattern_table(report: PatternReport) -> str:
    """Readable account, at most 100 characters wide."""
    pattern, design = report.pattern, report.design
    text = f"Contact pattern of {report.name}, {pattern.flank} flanks\n"
    text += layout_line(design, report.mounting) + error_line(design.errors) + parabola_line(design)
    text += backlash_lines(design)
    text += line("marking compound", f"{1e3 * pattern.separation:g} um thick")
    rolls = " to ".join(f"{math.degrees(roll):.4f}" for roll in pattern.roll_range)
    text += line("pinion rolls", f"{rolls} deg, one tooth pair through the mesh")
    for member, side in report.sides.items():
        low, high = marked_face(side)
        words = f"{side.area:.1f} mm^2 marked, {100.0 * side.area_share:.1f} % of the active flank"
        text += line(member, words if math.isnan(low) else f"{words}, z {low:.2f} to {high:.2f} mm")
        text += line("", _bound(side, report.area_error))
        least = side.least[np.isfinite(side.least)]
        text += line(
            "", f"least separation {1e3 * least.min():z.4f} um" if least.size else "no foot anywhere"
        )
    return text
