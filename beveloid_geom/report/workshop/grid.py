"""The grid of a measuring machine, and the deviations of points measured on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...analysis.ease_off import SecondOrder
from ...arrays import FLANK_SIGN
from ...workshop.grid import MeasuringGrid
from ...workshop.measured import Deviations
from ..columns import number
from ..result import Rows
from ..words import line

FRAME = "z along the axis towards the heel, 0 at mid-face; x through tooth 0, y = z cross x"
ORDER = "right flank, then left; rows from root to tip, in each columns from toe to heel"
MOST_COLUMNS = 10
"""Columns of a grid that stand beside each other in a text."""
SHAPE = {
    "mean": "mean",
    "face_slope": "slope from toe to heel",
    "profile_slope": "slope from root to tip",
    "face_crowning": "crowning along the face",
    "profile_crowning": "crowning along the profile",
    "twist": "twist",
    "rest": "rms of the rest",
}
"""Words for the surface of second order nearest to deviations."""


@dataclass(frozen=True)
class Named:
    """Of what a grid is: the design's name, which member, and its border in words."""

    name: str
    member: str
    border: str

    def data(self, grid: MeasuringGrid) -> dict[str, Any]:
        """Give the entries that say how the points are meant."""
        rows, columns = grid.shape
        return {
            **{"design": self.name, "member": self.member, "teeth": int(grid.member.teeth)},
            **{"rows": rows, "columns": columns, "border": self.border, "frame": FRAME, "order": ORDER},
            "middle_angle": grid.middle,
        }

    def lines(self, grid: MeasuringGrid) -> list[str]:
        """Say the same, a line each."""
        rows, columns = grid.shape
        half = 0.5 * float(grid.member.face_width)
        middle = f"{math.degrees(grid.middle):z.6f} deg"
        what, teeth = f"{self.name}, {self.member}", int(grid.member.teeth)
        return [
            f"{what}, {teeth} teeth: {rows} rows, {columns} columns, border {self.border}",
            f"frame: {FRAME}",
            f"datum: toe at z = {-half:g} mm, heel at {half:g} mm",
            f"tooth: its middle on the reference cylinder at mid-face stands {middle} from x",
            f"order: {ORDER}",
        ]


@dataclass(frozen=True, eq=False)
class GridReport:
    """The nominal points of a `grid` of a design's member."""

    named: Named
    grid: MeasuringGrid
    failure: str | None = None

    def data(self) -> dict[str, Any]:
        """Give the points with their normals, in the order of the grid; mm and rad."""
        return self.named.data(self.grid) | {"points": dict(self.rows())}

    def rows(self) -> Rows:
        """Give the points."""
        x, y, z = self.grid.point.reshape(-1, 3).T
        return _places(self.grid) | {"x": x, "y": y, "z": z, "normal": self.grid.normal.reshape(-1, 3)}

    def summary(self) -> str:
        """Write the neutral table of measuring programs: what it is behind #, then a point a line."""
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
    """The deviations `found` on the grid of a design's member."""

    named: Named
    found: Deviations
    failure: str | None = None

    @property
    def second_order(self) -> dict[str, SecondOrder]:
        """The surface of second order nearest to the deviations of each flank, over the grid."""
        return dict(zip(FLANK_SIGN, self.found.second_order, strict=True))

    def data(self) -> dict[str, Any]:
        """Give the deviations, rows of rows by flank, and what they come to; mm and rad."""
        found = self.found
        return {
            **self.named.data(found.grid),
            "deviation": dict(zip(FLANK_SIGN, found.deviation, strict=True)),
            "beside": dict(zip(FLANK_SIGN, found.beside, strict=True)),
            "second_order": {flank: vars(one) for flank, one in self.second_order.items()},
            "thickness_deviation": found.thickness,
            "turn": found.turn,
        }

    def rows(self) -> Rows:
        """Give the points measured and their deviations."""
        x, y, z = self.found.point.reshape(-1, 3).T
        own = {"deviation": self.found.deviation.ravel(), "beside": self.found.beside.ravel()}
        return _places(self.found.grid) | {"x": x, "y": y, "z": z} | own

    def summary(self) -> str:
        """Write the deviations of both flanks, tip above root, and what they come to."""
        grid = self.found.grid
        text = "Deviations of measured points along the normal, um, positive where there is too much metal\n"
        for flank, values in zip(FLANK_SIGN, self.found.deviation, strict=True):
            text += f"\n{flank.capitalize()} flank, toe to heel, tip above root\n"
            if grid.shape[1] <= MOST_COLUMNS:
                rows = ("".join(number("deviation", one, 9) for one in row) for row in values[::-1])
                text += "".join(
                    f"  row {k:>3} {row}\n" for k, row in zip(range(len(values), 0, -1), rows, strict=True)
                )
            one = self.second_order[flank]
            shape = (f"{words} {number('deviation', getattr(one, name))}" for name, words in SHAPE.items())
            least, most = (number("deviation", value) for value in (values.min(), values.max()))
            text += line("extent", f"{least} to {most} um") + line("shape, um", ", ".join(shape))
        text += "\n" + "".join(line(*words.split(": ", 1)) for words in self.named.lines(grid)[1:])
        text += line("grid", self.named.lines(grid)[0])
        turn = 3600.0 * math.degrees(self.found.turn)
        words = f"{number('deviation', self.found.thickness)} um of normal thickness, turned by {turn:z.2f}"
        return text + line("both flanks", f"{words} arcsec, by the means of their deviations")


def _places(grid: MeasuringGrid) -> dict[str, Any]:
    """Give flank, row and column, from 1 on, of all points in their order."""
    side, row, column = (index.ravel() for index in np.indices(grid.l.shape))
    return {"flank": np.array(tuple(FLANK_SIGN))[side], "row": row + 1, "column": column + 1}
