"""A contact pattern, what marking compound leaves on both flanks; and a matrix of them under two errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.marked_ellipse import marked_ellipse
from ..analysis.pattern_matrix import PatternCell, PatternMatrix
from ..design.model import Design
from ..findings.backlash import backlash_report
from ..operation.marking.pattern import AREA_ERROR, ContactPattern, MemberPattern, contact_pattern
from ..status import FirstStatus, PatternStatus
from .columns import number, scaled
from .result import Rows
from .words import (
    SHORT,
    TRADE,
    failure_of,
    head_data,
    line,
    mounted_lines,
    name_in_files,
    trade_words,
    unit_of,
)

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
    one = marked_ellipse(side, separation)
    if not math.isnan(one.major):  # a mark that no cell of the grid resolves has none
        text += line(
            "",
            f"ellipse about z {one.z:z.2f}, r {one.r:.2f} mm: half axes {one.major:.2f} and {one.minor:.2f}"
            f" mm, {math.degrees(one.angle):z.1f} deg to the axial direction",
        )
    return text + line("", nearest)


MEMBERS = ("pinion", "gear")
ELLIPSE = ("z", "r", "major", "minor", "angle")
"""Numbers of an ellipse."""
FIGURES = ("normal_backlash", "cycle_peak_to_peak", "edge_share")
"""Numbers of a cell."""


@dataclass(frozen=True, eq=False)
class PatternMatrixReport:
    """The matrix `found` of a single design."""

    name: str
    found: PatternMatrix

    @property
    def reason(self) -> str | None:
        """Why there is no pattern at all, None if there is one."""
        if any(self.found.cells):
            return None
        words = sorted({word.replace("_", " ") for word in status_of(self.found)})
        return f"no cell of the matrix has a pattern on the {self.found.flank} flanks: {', '.join(words)}"

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give the cells, row by row; mm and rad."""
        found, status = self.found, status_of(self.found)
        cells = []
        for k, (cell, added) in enumerate(zip(found.cells, added_of(found).tolist(), strict=True)):
            own: dict[str, Any] = dict(zip(_error_names(found), added, strict=True)) | {"status": status[k]}
            own |= {name: getattr(found, name).ravel()[k] for name in FIGURES}
            own |= {
                member: None if cell is None else member_data(cell, j) for j, member in enumerate(MEMBERS)
            }
            cells.append(own)
        data = {
            **head_data(self.name, found.design, found.flank),
            "over": found.over,
            "trade": [TRADE.get(name) for name in found.over],
            "separation": found.separation,
            "first": found.first,
            "second": found.second,
            "cells": cells,
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the flanks of the cells, the pinion's and the gear's of each."""
        found, status = self.found, status_of(self.found)
        rows = []
        for k, (cell, added) in enumerate(zip(found.cells, added_of(found).tolist(), strict=True)):
            figures = [float(getattr(found, name).ravel()[k]) for name in FIGURES]
            for j, member in enumerate(MEMBERS):
                sizes = dict.fromkeys((*SIZES, *ELLIPSE), np.nan) if cell is None else flat_data(cell, j)
                rows.append((*added, status[k], *figures, member, *sizes.values()))
        names = (*_error_names(found), "status", *FIGURES, "member", *SIZES, *ELLIPSE)
        return dict(zip(names, zip(*rows, strict=True), strict=True))

    def summary(self) -> str:
        """Write the cells of the pinion's flank, and how they are meant."""
        found = self.found
        text = f"Contact patterns of {self.name} under two errors, {found.flank} flanks, on the pinion\n\n"
        heads = [*(f"{SHORT[name]}, {unit_of(name)}" for name in found.over)]
        heads += ["TE, arcsec", "edges, %", "z, mm", "r, mm", "half axes, mm", "angle, deg", "marked, %"]
        text += "".join(f"{head:>{width}}" for head, width in zip(heads, WIDTHS, strict=True)) + "\n"
        status, swing, edges = status_of(found), found.cycle_peak_to_peak.ravel(), found.edge_share.ravel()
        for k, (cell, added) in enumerate(zip(found.cells, added_of(found), strict=True)):
            values = (scaled(f"{name}_error", x) for name, x in zip(found.over, added, strict=True))
            text += "".join(f"{value:z{width}.4g}" for value, width in zip(values, WIDTHS[:2], strict=True))
            if cell is None:
                text += f"  {status[k].replace('_', ' ')}\n"
                continue
            one, side = cell.ellipses[0], cell.pattern.pinion
            cells = (
                number("cycle_peak_to_peak", swing[k]),
                *(f"{100.0 * edges[k]:.1f}", f"{one.z:z.2f}", f"{one.r:.2f}"),
                f"{one.major:.2f} x {one.minor:.2f}",
                *(f"{np.degrees(one.angle):z.1f}", f"{100.0 * side.area_share:.1f}"),
            )
            text += "".join(f"{c:>{width}}" for c, width in zip(cells, WIDTHS[2:], strict=True)) + "\n"
        text += "\n" + mounted_lines(found.design)
        text += line("errors added", ", ".join(trade_words(name) for name in found.over))
        text += line("marking compound", f"{1e3 * found.separation:g} um thick")
        text += line("TE, edges", "transmission error of all teeth over a mesh cycle, share of it on edges")
        text += line(
            "z to angle",
            "ellipse of the same centre and second moments as the marked area, z along the axis towards the"
            " heel, r from the axis; its major axis to the axial direction",
        )
        jams = np.count_nonzero(found.jammed)
        return text + (line("note", f"jammed: cannot be assembled, {jams} of {len(status)}") if jams else "")


WIDTHS = (10, 12, 12, 10, 9, 9, 16, 12, 10)
"""Characters of the columns of a text."""


def added_of(found: PatternMatrix) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Give the values (cells, 2) of both errors of each cell, mm or rad."""
    return np.stack(np.meshgrid(found.first, found.second, indexing="ij"), axis=-1).reshape(-1, 2)


def status_of(found: PatternMatrix) -> list[str]:
    """Give the status of each cell in words of files: jammed, or that of its mesh cycle."""
    codes = zip(found.status.ravel().tolist(), found.jammed.ravel().tolist(), strict=True)
    return ["jammed" if jam else name_in_files(FirstStatus(code)) for code, jam in codes]


def member_data(cell: PatternCell, member: int) -> dict[str, Any]:
    """Give sizes and ellipse of the pattern on pinion (0) or gear (1)."""
    side = (cell.pattern.pinion, cell.pattern.gear)[member]
    return {**{name: getattr(side, name) for name in SIZES}, "ellipse": vars(cell.ellipses[member])}


def flat_data(cell: PatternCell, member: int) -> dict[str, Any]:
    """Give the same in one piece."""
    data = member_data(cell, member)
    return {**{name: data[name] for name in SIZES}, **data["ellipse"]}


def _error_names(found: PatternMatrix) -> list[str]:
    return [f"{name}_error" for name in found.over]
