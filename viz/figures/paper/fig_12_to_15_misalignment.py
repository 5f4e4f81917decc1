"""Figs. 12 to 15: paths of contact under each assembly error, without and with modification."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.lines import Line2D

from beveloid_geom import Design
from beveloid_geom.pair.errors import mounted
from beveloid_geom.studies.claims import ANGLE_ERROR, AXIAL_ERROR, OFFSET_ERROR
from beveloid_geom.studies.statements import is_papers

from ...parts import panels, solved, viewpoint
from ...parts.panels import Cell, Trace
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import SolvedPath
from ...stage import theme
from ...stage.scene import Picture

STRETCH, NARROW_STRETCH = 4.0, 3.0
"""How many times as large across as along flanks are drawn, and on a narrow page."""
SIGNS = (-1.0, 0.0, 1.0)


class Look(NamedTuple):
    """How a path is drawn: colour, dashes, width, lift of `panels.Trace`, legend line, width on edges."""

    colour: str
    dashes: tuple[float, ...]
    width: float
    lift: float
    legend: tuple[float, ...]
    edge: float

    @property
    def on_edge(self) -> Trace:
        """How edges are drawn that touch instead; the wider ones lower, so that all are seen."""
        return Trace(np.empty((0, 3)), self.colour, width=self.edge, lift=2.0 / self.edge**2)


LOOKS = (
    Look(theme.MINUS, panels.DASHED, 0.85, 0.5, (2.5, 1.5), 0.65),
    Look(theme.ZERO, panels.SOLID, 1.0, 0.0, (1.0, 0.0), 1.1),
    Look(theme.PLUS, panels.DOTTED, 0.85, 1.0, (0.8, 1.2), 0.35),
)
ROW, TABLE, ENDS = 0.21, 2.45, (0.22, 0.48, 0.71, 1.0)
"""Inches from line to line of the table of a flank, and its width; shares of it at which columns end."""
FLANK_SHARE = 0.6
"""Of the width of a column, that of the widest flank where a table stands beside it."""
NOTE = (
    "Shift (mm): of the middle of a path, at mid-roll, along the face, positive to the heel. Members"
    f" stay mounted as without errors. {panels.WHAT_TOUCHES.format(edges='solid lines along the edges')}"
)
CHOSEN = (
    " The paper does not give its shaft-angle error; this one was chosen so that the paths fill the face."
)


@dataclass(frozen=True)
class ErrorCase:
    """An assembly error: its name, its size, mm or rad, the unit it is written in."""

    number: int
    field: str
    size: float
    unit: str
    name: str
    note: str = ""

    @property
    def shown(self) -> float:
        """Size in the unit."""
        return round(float(np.degrees(self.size)), 12) if self.unit == "deg" else self.size

    def at(self, design: Design) -> ErrorCase:
        """Give the error at the module of a design, angles stay; of one with its errors at the mesh that of
        the same kind there. What the note says holds for the paper's pair alone."""
        times = solved.as_large(design) if self.unit == "mm" else 1.0
        size = solved.two_digits(self.size * times) if times != 1.0 else self.size
        own = self.field, self.name
        field, name = AT_MESH.get(self.field, own) if design.errors_at == "mesh" else own
        note = self.note if is_papers(design) else ""
        return replace(self, size=size, field=field, name=name, note=note)

    def label(self, sign: float) -> str:
        """Give the error with its sign and unit."""
        digits = f"{self.shown:g}".partition(".")[2]
        return f"{theme.signed(sign * self.shown, len(digits)) if sign else '0'}\u00a0{self.unit}"


CASES = (
    ErrorCase(12, "offset", OFFSET_ERROR, "mm", "offset error"),
    ErrorCase(13, "shaft_angle", ANGLE_ERROR, "deg", "shaft-angle error", CHOSEN),
    ErrorCase(14, "pinion_axial", AXIAL_ERROR, "mm", "axial position error of the pinion"),
    ErrorCase(15, "gear_axial", AXIAL_ERROR, "mm", "axial position error of the gear"),
)


AT_MESH = {
    "offset": ("centre_distance", "centre-distance error at the mesh"),
    "shaft_angle": ("in_plane", "shaft-angle error at the mesh"),
}
"""Field and name at the mesh of errors about the common perpendicular; axial ones are the same."""


@dataclass(frozen=True, eq=False)
class MisalignmentFigure:
    """Paths of a flank under one error, at minus, zero and plus: without modification, then with it."""

    case: ErrorCase
    flank: str
    paths: tuple[tuple[SolvedPath, ...], tuple[SolvedPath, ...]]

    @property
    def without_error(self) -> list[SolvedPath]:
        """The paths without the error, whose lines are drawn where flanks touch along lines."""
        return [paths[1] for paths in self.paths]


def compute(case: ErrorCase, design: Design, flank: str = "right") -> MisalignmentFigure:
    """Solve the six paths; errors are added to those that the design has."""

    def paths(base: Design) -> tuple[SolvedPath, ...]:
        sizes = (np.array([sign * case.size]) for sign in SIGNS)
        return tuple(solved.solve(mounted(base, size, (case.field,)), flank, touching=True) for size in sizes)

    case = case.at(design)
    plain, modified = design.with_parabola(0.0, 0.0), solved.modified(design)
    return MisalignmentFigure(case, flank, (paths(plain), paths(modified)))


def draw(data: MisalignmentFigure, layout: theme.Layout) -> Drawing:
    """Draw a row of pinion flanks over a row of gear flanks; on the left without modification, on the right
    with it."""
    case, flank = data.case, data.flank
    stretch = STRETCH if layout.width > theme.NARROW else NARROW_STRETCH
    lost = max(sum(not path.found for path in paths) for paths in data.paths)
    text = (ROW * (len(SIGNS) + 1), ROW * (len(SIGNS) + 1 + 2 * lost)) if layout.printed else (0.0, 0.0)
    page, low, high = theme.new_page(
        layout,
        f"Fig. {case.number}   Paths of contact under {case.name}",
        f"{flank.capitalize()} flanks, the pinion drives",
        panels.how_drawn(flank, stretch) + NOTE + case.note + panels.lines_drawn(data.without_error),
        above=0.3,
        columns=viewpoint.COLUMNS,
        tall=panels.flanks_tall(layout, len(data.paths), text, stretch),
    )
    _legend(page, case)

    def panel(cell: Cell) -> Picture | None:
        """Draw one flank with its three paths, and a line under it on each."""
        paths, row = data.paths[cell.column], cell.row
        if not layout.printed:  # tables stand on the right of the flanks, not under them
            cell = replace(cell, box=replace(cell.box, width=cell.box.width - round(TABLE * page.dpi)))
        traces = [
            trace
            for path, look in zip(paths, LOOKS, strict=True)
            for trace in (
                Trace(path.points[row], look.colour, look.dashes, look.width, look.lift, path.first),
                *panels.edge_traces(path, row, look.on_edge),
            )
        ]
        where = page, cell.box, paths[1].design, row, flank, cell.view
        drawn = panels.draw_flank(*where, traces, cell.px_per_mm, cell.limits)
        if drawn is None:
            return None
        panels.draw_lines(drawn, paths[1], row)
        _table(page, cell, case, paths)
        return drawn.picture

    values = "$a_1$ = $a_2$ = 0", solved.coefficients(data.paths[1][1].design)
    names = (
        f"{word} modification, {own}".replace(" = ", "\u00a0=\u00a0").replace(" mm", "\u00a0mm")
        for word, own in zip(("Without", "With"), values, strict=True)
    )
    columns = [(name, paths[1].design, flank) for name, paths in zip(names, data.paths, strict=True)]
    share = panels.FLANK_SHARE if layout.printed else FLANK_SHARE
    return Drawing(page, panels.flank_rows(page, columns, low, high, text, panel, False, stretch, share))


def _legend(page: theme.Page, case: ErrorCase) -> None:
    handles = [
        Line2D([], [], label=case.label(sign), color=look.colour, dashes=look.legend, linewidth=4.0)
        for look, sign in zip(LOOKS, SIGNS, strict=True)
    ]
    theme.legend(page, handles, 3, 0.8, handlelength=2.8)


def _table(page: theme.Page, cell: Cell, case: ErrorCase, paths: tuple[SolvedPath, ...]) -> None:
    """Write under a flank, or beside it, how far each path is shifted, and for the gear's also the ratios,
    which are the pair's, and why there is no path."""
    (middle, y), width = cell.under, min(cell.width / page.dpi, TABLE) / page.layout.width
    left = middle - (0.5 if cell.row else 0.55 * ENDS[1]) * width
    if not page.layout.printed:
        left = (cell.box.left + cell.box.width) / (page.dpi * page.layout.width)
        y += theme.inches(page, 0.5 * cell.box.height / page.dpi + 2.0 * ROW)
    lines = [("error", "shift", *(("ratio", "running") if cell.row else ()))]
    lines += [
        _line(case.label(sign).partition("\u00a0")[0], path, paths[1], cell.row)
        for sign, path in zip(SIGNS, paths, strict=True)
    ]
    colours = theme.GREY, *(look.colour for look in LOOKS)
    for number, (line, colour) in enumerate(zip(lines, colours, strict=True)):
        for at, word in zip(ENDS, line, strict=False):
            place = left + at * width, y - theme.inches(page, ROW * number)
            page.text(*place, word, color=colour, ha="right", va="top", fontsize=theme.SMALL)
    reasons = [
        f"{case.label(sign)}: {path.reason}"
        for sign, path in zip(SIGNS, paths, strict=True)
        if not path.found
    ]
    if reasons and cell.row:
        below = left + 0.5 * width, y - theme.inches(page, ROW * len(lines))
        pixels = width * page.layout.width * page.dpi
        replace(cell, under=below, width=pixels).say(page, "\n".join(reasons))


def _line(error: str, path: SolvedPath, zero: SolvedPath, row: int) -> tuple[str, ...]:
    """Give the words on a path on pinion (0) or gear (1) in the line of its table."""
    if not path.found:
        return error, "", "no path"
    shift = _shift(path, zero, row)
    told = "" if path is zero else theme.signed(shift, 1) if np.isfinite(shift) else "unknown"
    return error, told, *(panels.ratios(path) if row else ())


def _shift(path: SolvedPath, zero: SolvedPath, member: int) -> float:
    """Give the shift (mm) along the face of the pinion (0) or gear (1), NaN unless both paths are found."""
    both = path.found and zero.found
    return float(path.middle(member)[2] - zero.middle(member)[2]) if both else np.nan


def rows(data: MisalignmentFigure) -> Table:
    """List every position of every path on both members."""
    header = "modified", f"{data.case.field}_error_{data.case.unit}", "pinion_shift_mm", "gear_shift_mm"
    paths = (
        ((modified, sign * data.case.shown + 0.0, *(_shift(path, own[1], member) for member in (0, 1))), path)
        for modified, own in zip(("no", "yes"), data.paths, strict=True)
        for sign, path in zip(SIGNS, own, strict=True)
    )
    return solved.table(header, paths)


RECIPES = {f"fig-{case.number:02d}": Recipe(partial(compute, case), draw, rows) for case in CASES}
