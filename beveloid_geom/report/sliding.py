"""Sliding along a path of contact as text: table, JSON and CSV."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.sliding import Sliding, least_along, least_sliding, sliding_of
from ..arrays import FloatArray
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..findings.path import reason_of
from ..pair.mounting import Mounting, mounting_of
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

MEMBERS = ("pinion", "gear")
DENSE = 201
"""Positions from which ranges and the least sliding are taken."""
RANGED = ("speed", *(f"{m}_{name}" for name in ("specific", "specific_total") for m in MEMBERS))
UNITS = {
    "pinion_roll": "rad",
    "gear_roll": "rad",
    "speed": "mm/rad",
    "profile": "mm/rad",
    "lengthwise": "mm/rad",
    "rolling_speed": "mm/rad",
    "z": "mm",
    "r": "mm",
}
"""Units of the columns, those of a member by their name without it; none for the others."""
SHOWN = (
    ("pinion_roll", "pinion roll", "deg", 12, 6),
    ("pinion_r", "pinion r", "mm", 10, 4),
    ("gear_r", "gear r", "mm", 10, 4),
    ("speed", "sliding", "mm/rad", 10, 4),
    ("pinion_profile", "profile", "mm/rad", 10, 4),
    ("pinion_lengthwise", "length", "mm/rad", 10, 4),
    ("pinion_specific", "pinion", "specific", 10, 4),
    ("gear_specific", "gear", "specific", 10, 4),
    ("pinion_specific_total", "pinion", "total", 9, 4),
    ("gear_specific_total", "gear", "total", 9, 4),
)
"""Columns of the table: column, heading, unit, width, digits after the point."""


@dataclass(frozen=True, eq=False)
class SlidingReport:
    """Sliding along the path of one flank pair of a single design.

    `least_roll` (rad) and `least_speed` (mm/rad): of the least sliding; `pitch_roll` (rad): where the
    path comes nearest to the pitch point, NaN where that is at its end; `ranges`: least and greatest of
    `speed` and of the specific slidings, by their names in `columns`. They are those of the whole path,
    however many positions are asked for. `reason` says why there is no contact on the flanks, None if
    there is; all arrays are empty then."""

    name: str
    design: Design
    mounting: Mounting
    path: ContactPath
    sliding: Sliding
    least_roll: float
    least_speed: float
    pitch_roll: float
    ranges: dict[str, tuple[float, float]]
    reason: str | None

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Numbers of the positions, each (positions,), by their names in JSON and CSV: rad, mm, mm/rad."""
        return columns_of(self.path, self.sliding)


def columns_of(path: ContactPath, found: Sliding) -> dict[str, FloatArray]:
    """Numbers (positions,) of a single path by their names in files."""
    columns = {"pinion_roll": path.pinion_roll, "gear_roll": path.gear_roll}
    columns |= {name: getattr(path, name) for name in ("pinion_z", "pinion_r", "gear_z", "gear_r")}
    columns |= {"gear_rate": found.gear_rate, "speed": found.speed}
    both = {
        "profile": found.profile,
        "lengthwise": found.lengthwise,
        "rolling_speed": np.linalg.norm(found.rolling, axis=-1),
        "specific": found.specific,
        "specific_total": found.specific_total,
    }
    for name, values in both.items():
        columns |= {f"{member}_{name}": values[..., j] for j, member in enumerate(MEMBERS)}
    return columns


def sliding_report(name: str, design: Design, flank: str, points: int) -> SlidingReport:
    """Sliding of a single design at `points` positions of its path."""
    path, mounting = path_of_contact(design, flank, points), mounting_of(design)
    whole = path_of_contact(design, flank, DENSE)
    dense = sliding_of(whole)
    roll, speed = least_sliding(dense)
    away = ((whole.point - mounting.pitch_point) ** 2).sum(axis=-1)
    nearest = float(least_along(whole.pinion_roll, away)[0])
    at_end = np.isclose(nearest, whole.pinion_roll[[0, -1]], rtol=0.0, atol=1e-12) if away.size else True
    ranges = {name: span_of(v) for name, v in columns_of(whole, dense).items() if name in RANGED}
    ranges["speed"] = (float(speed), ranges["speed"][1])
    return SlidingReport(
        name=name,
        design=design,
        mounting=mounting,
        path=path,
        sliding=sliding_of(path),
        least_roll=float(roll),
        least_speed=float(speed),
        pitch_roll=math.nan if np.any(at_end) else nearest,
        ranges=ranges,
        reason=reason_of(path),
    )


def span_of(values: FloatArray) -> tuple[float, float]:
    """Least and greatest of the values that are known, NaN where none is."""
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)


def sliding_json(report: SlidingReport) -> str:
    """Strict JSON, mm, rad and mm per rad of the pinion's roll."""
    path, found, columns = report.path, report.sliding, report.columns
    data: dict[str, Any] = {
        "design": report.name,
        "flank": path.flank,
        "status": status_name(int(path.ends.status)),
        "contact_ratio": path.ends.contact_ratio,
        **layout_data(report.design, report.mounting),
        "parabola": {
            member: each.tool.parabola for member, each in zip(MEMBERS, report.design.members, strict=True)
        },
        "ends": {
            end: None if limit is None else {"member": limit.member, "limit": limit.limit}
            for end, limit in (("enter", path.ends.enter), ("leave", path.ends.leave))
        },
        "least_sliding": {"pinion_roll": report.least_roll, "speed": report.least_speed},
        "pitch_roll": report.pitch_roll,
        "range": report.ranges,
        "positions": {
            **columns,
            "point": path.point,
            "sliding": found.sliding,
            "status": [status_name(code) for code in path.status],
        },
    }
    if report.reason:
        data["reason"] = report.reason
    return json_text(data)


def header_of(column: str) -> str:
    """Name of a column with its unit, as it heads a CSV."""
    unit = UNITS.get(column, UNITS.get(column.removeprefix("pinion_").removeprefix("gear_"), ""))
    return f"{column}_{unit.replace('/', '_per_')}" if unit else column


def sliding_csv(report: SlidingReport) -> str:
    """CSV of the positions, units in the header."""
    columns = report.columns
    header = [header_of(name) for name in columns]
    header += [f"sliding_{axis}_mm_per_rad" for axis in "xyz"]
    values = [*(column.tolist() for column in columns.values()), *report.sliding.sliding.T.tolist()]
    return csv_text([*header, "status"], [*values, [status_name(code) for code in report.path.status]])


def sliding_table(report: SlidingReport) -> str:
    """Readable account, at most 100 characters wide, in mm and deg."""
    path = report.path
    text = f"Sliding of {report.name}, {path.flank} flanks: speeds in mm per rad of the pinion's roll\n"
    text += layout_line(report.design, report.mounting) + error_line(report.design.errors)
    text += parabola_line(report.design)
    if report.reason:
        return text
    low, high = report.ranges["speed"]
    least = f"least at {math.degrees(report.least_roll):z.4f} deg of pinion roll"
    text += line("sliding speed", f"{low:.4f} to {high:.4f} mm/rad, {least}")
    for label, name, what in (
        ("specific sliding", "specific", "along the profile"),
        ("total", "specific_total", "all sliding, over the distance that the contact runs over the flank"),
    ):
        spans = ("{} {:z.4f} to {:z.4f}".format(m, *report.ranges[f"{m}_{name}"]) for m in MEMBERS)
        text += line(label, f"{', '.join(spans)}; {what}")
    if not math.isnan(report.pitch_roll):
        text += line("pitch point", f"nearest at {math.degrees(report.pitch_roll):z.4f} deg of pinion roll")
    ends = ((path.ends.enter, "enters"), (path.ends.leave, "leaves"))
    text += line("path", ", ".join(f"{verb} at the {end.member}'s {end.limit}" for end, verb in ends if end))
    return f"{text}\n{_position_lines(report)}"


def _position_lines(report: SlidingReport) -> str:
    lines = ["".join(f"{column[part]:>{column[3]}}" for column in SHOWN) for part in (1, 2)]
    scale = [math.degrees(1.0) if unit == "deg" else 1.0 for _, _, unit, _, _ in SHOWN]
    shown = np.transpose([report.columns[column[0]] * by for column, by in zip(SHOWN, scale, strict=True)])
    for row, status in zip(shown, report.path.status, strict=True):
        numbers = (f"{value:z{c[3]}.{c[4]}f}" for value, c in zip(row, SHOWN, strict=True))
        lines.append("".join(numbers) if status == Status.SOLVED else f"{status_name(status):>22}")
    return "\n".join(lines) + "\n"
