"""Reports of `grid`: points for a measuring machine, and deviations of measured points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...analysis.ease_off import SecondOrder
from ...arrays import FLANK_SIGN
from ...design.ends import end_names
from ...workshop.grid import MeasuringGrid
from ...workshop.measured import Deviations
from ..columns import number
from ..ease_off import SECOND_ORDER
from ..result import Failure, Rows, plain
from ..text import line

SHAPE_LABELS = SECOND_ORDER | {"profile_slope": "slope from root to tip"}
"""Labels of the coefficients of the quadratic surface fitted to the deviations."""


@dataclass(frozen=True)
class GridOrigin:
    """Origin of a grid: names of design and member, and the border.

    The border is the distance of the outermost points from the edges of the flank, as text such as '10%' or
    '2mm'."""

    name: str
    member: str
    border: str

    def frame_and_order(self, grid: MeasuringGrid) -> dict[str, str]:
        """Return the definitions of the frame and of the order of the points."""
        start, end = end_names(grid.member)
        return {
            "frame": f"z along the axis towards the {end}, 0 at mid-face; x through tooth 0, y = z cross x",
            "order": f"right flank, then left; rows from root to tip, columns from {start} to {end}",
        }

    def data(self, grid: MeasuringGrid) -> dict[str, Any]:
        """Return the entries of JSON that define the points."""
        rows, columns = grid.shape
        return {
            **{"design": self.name, "member": self.member, "teeth": int(grid.member.teeth)},
            **{"rows": rows, "columns": columns, "border": self.border},
            **self.frame_and_order(grid),
            "middle_angle": grid.middle,
        }

    def lines(self, grid: MeasuringGrid) -> list[str]:
        """Return the same definitions as lines."""
        rows, columns = grid.shape
        half = 0.5 * float(grid.member.face_width)
        middle = f"{math.degrees(grid.middle):z.6f} deg"
        title, teeth = f"{self.name}, {self.member}", int(grid.member.teeth)
        ends, defined = end_names(grid.member), self.frame_and_order(grid)
        return [
            f"{title}, {teeth} teeth: {rows} rows, {columns} columns, border {self.border}",
            f"frame: {defined['frame']}",
            f"datum: {ends[0]} at z = {-half:g} mm, {ends[1]} at {half:g} mm",
            f"tooth: its middle on the reference cylinder at mid-face is {middle} from x",
            f"order: {defined['order']}",
        ]


@dataclass(frozen=True, eq=False)
class GridReport:
    """Nominal points of a member of a design."""

    named: GridOrigin
    grid: MeasuringGrid
    failure: Failure | None = None

    def data(self) -> dict[str, Any]:
        """Return the points with their normals, in the order of the grid; mm and rad."""
        return self.named.data(self.grid) | {"points": dict(self.rows())}

    def rows(self) -> Rows:
        """Return the points."""
        x, y, z = self.grid.point.reshape(-1, 3).T
        return _places(self.grid) | {"x": x, "y": y, "z": z, "normal": self.grid.normal.reshape(-1, 3)}

    def summary(self) -> str:
        """Return a table for measuring programs: comments after #, then one point per line."""
        text = "".join(f"# {words}\n" for words in self.named.lines(self.grid))
        text += "# unit: mm; normals of length 1, out of the tooth\n"
        text += "# flank row column x y z nx ny nz\n"
        rows, normal = self.rows(), self.grid.normal.reshape(-1, 3)
        points = zip(*(rows[name] for name in ("flank", "row", "column", "x", "y", "z")), normal, strict=True)
        for flank, row, column, x, y, z, (nx, ny, nz) in points:
            text += f"{flank:<6}{row:>4}{column:>4}{x:z15.9f}{y:z15.9f}{z:z15.9f}"
            text += f"{nx:z13.9f}{ny:z13.9f}{nz:z13.9f}\n"
        return text


@dataclass(frozen=True, eq=False)
class DeviationReport:
    """Deviations of measured points on the grid of a member."""

    named: GridOrigin
    result: Deviations
    failure: Failure | None = None

    @property
    def second_order(self) -> dict[str, SecondOrder]:
        """Quadratic surface fitted to the deviations of each flank."""
        return dict(zip(FLANK_SIGN, self.result.second_order, strict=True))

    def data(self) -> dict[str, Any]:
        """Return the deviations by flank and row, the quadratic surfaces, thickness and rotation; mm and
        rad."""
        result = self.result
        return {
            **self.named.data(result.grid),
            "deviation": dict(zip(FLANK_SIGN, result.deviation, strict=True)),
            "beside": dict(zip(FLANK_SIGN, result.foot_distance, strict=True)),
            "second_order": plain(self.second_order),
            "thickness_deviation": result.thickness,
            "turn": result.turn,
        }

    def rows(self) -> Rows:
        """Return the measured points and their deviations."""
        x, y, z = self.result.point.reshape(-1, 3).T
        values = {"deviation": self.result.deviation.ravel(), "beside": self.result.foot_distance.ravel()}
        return _places(self.result.grid) | {"x": x, "y": y, "z": z} | values

    def summary(self) -> str:
        """Return the deviations of both flanks, with the tip above the root, and their evaluation."""
        # Largest number of columns of a grid that is printed.
        max_printed_columns = 10
        grid, ends = self.result.grid, end_names(self.result.grid.member)
        text = "Deviations of measured points along the normal, um, positive for excess material\n"
        for flank, values in zip(FLANK_SIGN, self.result.deviation, strict=True):
            text += f"\n{flank.capitalize()} flank, {ends[0]} to {ends[1]}, tip above root\n"
            if grid.shape[1] <= max_printed_columns:
                rows = ("".join(f"{number('deviation', one):>9}" for one in row) for row in values[::-1])
                text += "".join(
                    f"  row {k:>3} {row}\n" for k, row in zip(range(len(values), 0, -1), rows, strict=True)
                )
            fit = self.second_order[flank]
            shape = (
                f"{words} {number('deviation', getattr(fit, name))}" for name, words in SHAPE_LABELS.items()
            )
            least, most = (number("deviation", value) for value in (values.min(), values.max()))
            text += line("extent", f"{least} to {most} um") + line("shape, um", ", ".join(shape))
        text += "\n" + "".join(line(*words.split(": ", 1)) for words in self.named.lines(grid)[1:])
        text += line("grid", self.named.lines(grid)[0])
        turn = 3600.0 * math.degrees(self.result.turn)
        words = f"{number('deviation', self.result.thickness)} um of normal thickness, rotated by {turn:z.2f}"
        return text + line("both flanks", f"{words} arcsec, by the means of their deviations")


def _places(grid: MeasuringGrid) -> dict[str, Any]:
    """Return flank, row and column of all points in their order; rows and columns are counted from 1."""
    side, row, column = (index.ravel() for index in np.indices(grid.l.shape))
    return {"flank": np.array(tuple(FLANK_SIGN))[side], "row": row + 1, "column": column + 1}
