"""Report of `sliding`: sliding along a path of contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.sliding import Sliding, least_along, least_sliding, path_sliding
from ..arrays import MEMBERS, FloatArray
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..findings.path import reason_of
from ..pair.frames import layout_of
from ..pair.mounting import mounting_of
from .columns import number, table_lines
from .result import Report, Rows, by_member, ends_data, picked
from .text import end_words, head_lines, line


@dataclass(frozen=True, eq=False)
class SlidingReport(Report):
    """Sliding along the path of one flank pair of a single design.

    Attributes
    ----------
    path, sliding : ContactPath, Sliding
        Positions, and the sliding at them.
    least_roll, least_speed : float
        Pinion roll angle (rad) and speed (mm/rad) of the smallest sliding.
    pitch_roll : float
        Pinion roll angle at which the path is nearest to the pitch point or, on parallel axes, crosses the
        pitch line, rad; NaN at an end of the path.
    ranges : dict
        Least and largest values of the printed quantities along the complete path.
    reason : str or None
        Reason for missing contact on the flanks; all arrays are empty then.
    """

    path: ContactPath
    sliding: Sliding
    least_roll: float
    least_speed: float
    pitch_roll: float
    ranges: dict[str, tuple[float, float]]
    reason: str | None

    @property
    def flank(self) -> str:
        """Driving flanks."""
        return self.path.flank

    @property
    def pitch_name(self) -> str:
        """Name of the place at `pitch_roll`."""
        return "pitch line" if layout_of(self.design).parallel else "pitch point"

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Numbers of the positions, each (positions,), by column: rad, mm, mm/rad."""
        return columns_of(self.path, self.sliding)

    def values(self) -> dict[str, Any]:
        """Return positions and ranges."""
        ends = self.path.ends
        return {
            **picked(ends, "status", "contact_ratio"),
            "ends": ends_data(ends),
            "least_sliding": {"pinion_roll": self.least_roll, "speed": self.least_speed},
            "pitch_roll": self.pitch_roll,
            "range": self.ranges,
            "positions": {**self.rows(), "point": self.path.point},
        }

    def rows(self) -> Rows:
        """Return the positions."""
        return self.columns | picked(self.sliding, "sliding") | picked(self.path, "status")

    def summary(self) -> str:
        """Return the positions and the ranges of the complete path."""
        title = f"Sliding of {self.name}, {self.flank} flanks: speeds in mm per rad of pinion roll\n"
        if self.reason:
            return title + head_lines(self.design)
        rows = self.rows()
        shown_columns = (
            *("pinion_roll", "pinion_r", "gear_r", "speed", "pinion_profile", "pinion_lengthwise"),
            *("pinion_specific", "gear_specific", "pinion_specific_total", "gear_specific_total"),
        )
        text = title + "\n" + table_lines({name: rows[name] for name in shown_columns}, rows["status"]) + "\n"
        low, high = self.ranges["speed"]
        least = f"smallest at {math.degrees(self.least_roll):z.4f} deg of pinion roll"
        text += head_lines(self.design)
        text += line("sliding speed", f"{low:.4f} to {high:.4f} mm/rad, {least}")
        for label, name, definition in (
            ("specific sliding", "specific", "along the profile"),
            (
                "specific total",
                "specific_total",
                "sliding in all directions, divided by the distance that the contact moves on the flank",
            ),
        ):
            spans = ("{} {:z.4f} to {:z.4f}".format(m, *self.ranges[f"{m}_{name}"]) for m in MEMBERS)
            text += line(label, f"{', '.join(spans)}; {definition}")
        if not math.isnan(self.pitch_roll):
            roll = number("pinion_roll", self.pitch_roll)
            text += line(self.pitch_name, f"nearest to the path at {roll} deg of pinion roll")
        return text + line("path", end_words(self.design, self.path.ends))


def columns_of(path: ContactPath, sliding: Sliding) -> dict[str, FloatArray]:
    """Return numbers (positions,) of a single path and its sliding by column."""
    columns = picked(path, "pinion_roll", "gear_roll", "pinion_z", "pinion_r", "gear_z", "gear_r")
    columns |= picked(sliding, "gear_rate", "speed")
    both_members = {
        **picked(sliding, "profile", "lengthwise"),
        "rolling_speed": np.linalg.norm(sliding.rolling, axis=-1),
        **picked(sliding, "specific", "specific_total"),
    }
    for name, values in both_members.items():
        columns |= by_member(name, values)
    return columns


def sliding_report(name: str, design: Design, flank: str, points: int) -> SlidingReport:
    """Return the sliding of a single design at `points` positions of its path.

    Ranges, smallest sliding and pitch point are taken from 201 positions."""
    path, dense_path = (path_of_contact(design, flank, count) for count in (points, 201))
    dense = path_sliding(dense_path)
    roll, speed = least_sliding(dense)
    squared_distance = ((dense_path.point - mounting_of(design).pitch_point) ** 2).sum(axis=-1)
    if layout_of(design).parallel:  # the flanks roll without sliding at all points of the pitch line
        squared_distance = dense.speed**2
    nearest = float(least_along(dense_path.pinion_roll, squared_distance)[0])
    ends = dense_path.pinion_roll[[0, -1]] if squared_distance.size else np.array([nearest])
    at_end = np.isclose(nearest, ends, rtol=0.0, atol=1e-12).any() or not squared_distance.size
    columns = columns_of(dense_path, dense)
    ranged = ("speed", *(f"{m}_{name}" for name in ("specific", "specific_total") for m in MEMBERS))
    ranges = {key: span_of(values) for key, values in columns.items() if key in ranged}
    ranges["speed"] = (float(speed), ranges["speed"][1])
    return SlidingReport(
        name=name,
        design=design,
        path=path,
        sliding=path_sliding(path),
        least_roll=float(roll),
        least_speed=float(speed),
        pitch_roll=math.nan if at_end else nearest,
        ranges=ranges,
        reason=reason_of(path),
    )


def span_of(values: FloatArray) -> tuple[float, float]:
    """Return the smallest and the largest finite value, NaN without any."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (math.nan, math.nan)
