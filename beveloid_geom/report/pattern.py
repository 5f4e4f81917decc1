"""A contact pattern: what marking compound leaves on both flanks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.marked_ellipse import marked_ellipse
from ..design.model import Design
from ..findings.backlash import backlash_report
from ..operation.pattern import AREA_ERROR, ContactPattern, MemberPattern, contact_pattern
from ..status import PatternStatus
from .result import Rows
from .words import failure_of, head_data, line, mounted_lines, name_in_files

FINE = 15
"""Points of a pattern to a module: some pixels apart where a flank is drawn."""
FIELDS = ("l", "z", "least", "pinion_roll")
"""Numbers of a point."""
SIZES = ("area", "area_share", "area_error")
"""Numbers of a member's pattern, the same in all its rows of a CSV."""


@dataclass(frozen=True, eq=False)
class PatternReport:
    """The contact `pattern` of one flank pair of a single design, at points about every `resolution`, mm;
    its areas were to be right to the share `area_error`."""

    name: str
    design: Design
    pattern: ContactPattern
    resolution: float
    area_error: float

    @property
    def sides(self) -> dict[str, MemberPattern]:
        """The patterns on both flanks by member."""
        return {"pinion": self.pattern.pinion, "gear": self.pattern.gear}

    @property
    def failure(self) -> str | None:
        """Why the pair cannot be assembled."""
        return failure_of(None, self.design)

    def data(self) -> dict[str, Any]:
        """Give the sizes of the pattern."""
        members = {
            member: {
                **{name: getattr(side, name) for name in SIZES},
                "z_range": marked_face(side),
                "ellipse": vars(marked_ellipse(side, self.pattern.separation)),
            }
            for member, side in self.sides.items()
        }
        return {
            **head_data(self.name, self.design, self.pattern.flank),
            "separation": self.pattern.separation,
            "resolution": self.resolution,
            "roll_range": self.pattern.roll_range,
            **members,
        }

    def rows(self) -> Rows:
        """Give the points of both flanks, and the sizes of their patterns."""
        backlash = backlash_report(self.design).normal
        sides = [_points(member, side, backlash) for member, side in self.sides.items()]
        return {name: np.concatenate([side[name] for side in sides]) for name in sides[0]}

    def summary(self) -> str:
        """Write the sizes of the pattern."""
        text = f"Contact pattern of {self.name}, {self.pattern.flank} flanks\n" + mounted_lines(self.design)
        text += line("marking compound", f"{1e3 * self.pattern.separation:g} um thick")
        rolls = " to ".join(f"{math.degrees(roll):.4f}" for roll in self.pattern.roll_range)
        text += line("pinion rolls", f"{rolls} deg, one tooth pair through the mesh")
        return text + "".join(
            _side_lines(member, side, self.area_error, self.pattern.separation)
            for member, side in self.sides.items()
        )


def pattern_report(
    name: str,
    design: Design,
    flank: str,
    separation: float,
    resolution: float | None = None,
    area_error: float = AREA_ERROR,
) -> PatternReport:
    """Find the pattern of a single design; lengths in mm, the resolution a FINE part of the module unless
    told. Arguments and ValueError as of `contact_pattern`."""
    resolution = float(design.pinion.tool.normal_module) / FINE if resolution is None else resolution
    pattern = contact_pattern(design, flank, separation, resolution=resolution, area_error=area_error)
    return PatternReport(name, design, pattern, resolution, area_error)


def marked_face(side: MemberPattern) -> tuple[float, float]:
    """Give least and greatest z (mm) of the marked points, NaN without any."""
    z = side.z[side.marked]
    return (float(z.min()), float(z.max())) if z.size else (math.nan, math.nan)


def _points(member: str, side: MemberPattern, backlash: float) -> dict[str, Any]:
    """Give the points of one flank; what is the same for all of them in each."""
    status = np.array([name_in_files(PatternStatus(int(code))) for code in side.status.ravel()])
    same = {name: np.full(status.shape, getattr(side, name)) for name in SIZES}
    return {
        "member": np.full(status.shape, member),
        **{name: getattr(side, name).ravel() for name in FIELDS},
        "marked": side.marked.astype(int).ravel(),
        "status": status,
        **same,
        "mounted_backlash": np.full(status.shape, backlash),
    }


def _side_lines(member: str, side: MemberPattern, asked: float, separation: float) -> str:
    """Write size, extent, ellipse and bound of the error of one member's pattern; `asked` is the share
    allowed."""
    low, high = marked_face(side)
    words = f"{side.area:.1f} mm^2 marked, {100.0 * side.area_share:.1f} % of the active flank"
    text = line(member, words if math.isnan(low) else f"{words}, z {low:.2f} to {high:.2f} mm")
    bound = f"right to {100.0 * side.area_error:.2g} % of the area"
    missed = "" if side.area_error <= asked else f", not to the {100.0 * asked:g} % asked for"
    least = side.least[np.isfinite(side.least)]
    nearest = f"least separation {1e3 * least.min():z.4f} um" if least.size else "nowhere opposite a flank"
    text += line("", bound + missed)
    if not math.isnan(low):
        one = marked_ellipse(side, separation)
        text += line(
            "",
            f"ellipse about z {one.z:z.2f}, r {one.r:.2f} mm: half axes {one.major:.2f} and {one.minor:.2f}"
            f" mm, {math.degrees(one.angle):z.1f} deg to the axial direction",
        )
    return text + line("", nearest)
