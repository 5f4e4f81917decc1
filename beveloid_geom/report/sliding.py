"""Sliding along a path of contact."""

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
from ..pair.mounting import mounting_of
from .columns import number, table_lines
from .result import Rows
from .words import end_words, ends_data, head_data, head_lines, line, status_name

MEMBERS = ("pinion", "gear")
DENSE = 201
"""Positions from which ranges and the least sliding are taken."""
RANGED = ("speed", *(f"{m}_{name}" for name in ("specific", "specific_total") for m in MEMBERS))
SHOWN = (
    *("pinion_roll", "pinion_r", "gear_r", "speed", "pinion_profile", "pinion_lengthwise"),
    *("pinion_specific", "gear_specific", "pinion_specific_total", "gear_specific_total"),
)
"""Columns of the text."""


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

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give positions and ranges."""
        ends = self.path.ends
        data = {
            **head_data(self.name, self.design, self.path.flank),
            "status": status_name(int(ends.status)),
            "contact_ratio": ends.contact_ratio,
            "ends": ends_data(self.path.ends),
            "least_sliding": {"pinion_roll": self.least_roll, "speed": self.least_speed},
            "pitch_roll": self.pitch_roll,
            "range": self.ranges,
            "positions": {**self.rows(), "point": self.path.point},
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the positions."""
        status = [status_name(code) for code in self.path.status]
        return {**self.columns, "sliding": self.sliding.sliding, "status": status}

    def summary(self) -> str:
        """Write the positions, then the ranges of the whole path."""
        text = (
            f"Sliding of {self.name}, {self.path.flank} flanks: speeds in mm per rad of the pinion's roll\n"
        )
        if self.reason:
            return text + head_lines(self.design)
        rows = self.rows()
        text += "\n" + table_lines({name: rows[name] for name in SHOWN}, rows["status"]) + "\n"
        low, high = self.ranges["speed"]
        least = f"least at {math.degrees(self.least_roll):z.4f} deg of pinion roll"
        text += head_lines(self.design)
        text += line("sliding speed", f"{low:.4f} to {high:.4f} mm/rad, {least}")
        for label, name, what in (
            ("specific sliding", "specific", "along the profile"),
            (
                "total",
                "specific_total",
                "all sliding, over the distance that the contact runs over the flank",
            ),
        ):
            spans = ("{} {:z.4f} to {:z.4f}".format(m, *self.ranges[f"{m}_{name}"]) for m in MEMBERS)
            text += line(label, f"{', '.join(spans)}; {what}")
        if not math.isnan(self.pitch_roll):
            roll = number("pinion_roll", self.pitch_roll)
            text += line("pitch point", f"nearest at {roll} deg of pinion roll")
        return text + line("path", end_words(self.path.ends))


def columns_of(path: ContactPath, found: Sliding) -> dict[str, FloatArray]:
    """Give numbers (positions,) of a single path by their names in files."""
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
    """Find the sliding of a single design at `points` positions of its path."""
    path, whole = (path_of_contact(design, flank, count) for count in (points, DENSE))
    dense = sliding_of(whole)
    roll, speed = least_sliding(dense)
    away = ((whole.point - mounting_of(design).pitch_point) ** 2).sum(axis=-1)
    nearest = float(least_along(whole.pinion_roll, away)[0])
    at_end = np.isclose(nearest, whole.pinion_roll[[0, -1]], rtol=0.0, atol=1e-12) if away.size else True
    ranges = {name: span_of(v) for name, v in columns_of(whole, dense).items() if name in RANGED}
    ranges["speed"] = (float(speed), ranges["speed"][1])
    return SlidingReport(
        name=name,
        design=design,
        path=path,
        sliding=sliding_of(path),
        least_roll=float(roll),
        least_speed=float(speed),
        pitch_roll=math.nan if np.any(at_end) else nearest,
        ranges=ranges,
        reason=reason_of(path),
    )


def span_of(values: FloatArray) -> tuple[float, float]:
    """Give least and greatest of the values that are known, NaN where none is."""
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)
