"""Figs. 12 to 15: paths of contact under each assembly error, without and with modification."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.errors import mounted
from beveloid_geom.studies.claims import ANGLE_ERROR, AXIAL_ERROR, OFFSET_ERROR

from ...parts import panels, solved, viewpoint
from ...parts.panels import Panel, Trace
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import SolvedPath
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import Picture

STRETCH = 4.0
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
CELLS = Cells(left=0.96, right=0.16, across=0.0, down=0.15, most=2, least=3.5)
NAMES = 0.3  # inches over a panel for its name, where they stand one under another
BESIDE, BROKEN = 3.1, 2.1
"""Inches of a panel for labels on the right of the flank, and for those with the ratios in two lines."""
SHORT = 18
"""Characters of a line beside a flank where there is little room."""
NOTE = (
    "The shift of a path is that at mid-roll, of its middle along the face, positive to the heel. Members"
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
        the same kind there."""
        times = solved.as_large(design) if self.unit == "mm" else 1.0
        size = solved.two_digits(self.size * times) if times != 1.0 else self.size
        own = self.field, self.name
        field, name = AT_MESH.get(self.field, own) if design.errors_at == "mesh" else own
        return replace(self, size=size, field=field, name=name)

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
    """Draw pinion flanks left, gear flanks right; without modification above, with it below."""
    case, flank = data.case, data.flank
    page, low, high = theme.new_page(
        layout,
        f"Fig. {case.number}   Paths of contact under {case.name}",
        f"{flank.capitalize()} flanks, the pinion drives; {case.name} of \u00b1{case.label(1.0)[1:]}",
        panels.how_drawn(flank, STRETCH) + NOTE + case.note + panels.lines_drawn(data.without_error),
        above=0.3,
        columns=viewpoint.COLUMNS,
        tall=CELLS.tall(layout, 4, 3.9),
    )
    one_column = CELLS.columns(layout, 4) == 1
    over = theme.inches(page, CELLS.down)
    places = CELLS.boxes(layout, 4, page.get_figheight(), low, high - over)
    views = [panels.flank_views(paths[1].design, flank, STRETCH) for paths in data.paths]
    _, _, width, own_height = places[0]
    own_height -= theme.inches(page, NAMES) * one_column
    words = BROKEN if layout.printed and not one_column else BESIDE
    share = 1.0 - words / CELLS.width(layout, 4)
    px_per_mm = panels.shared_scale(page, views, share * width, own_height)
    _legend(page, case)
    pictures: dict[str, Picture] = {}
    for row, (name, paths) in enumerate(zip(("without", "with"), data.paths, strict=True)):
        own = places[2 * row : 2 * row + 2]
        _row_heading(page, 0.5 * (own[0][1] + own_height + own[-1][1]), name, paths[1].design)
        for column, (member, (left, bottom, _, _)) in enumerate(zip(solved.MEMBERS, own, strict=True)):
            view = views[row][column]
            box = theme.place(page, left, bottom, (share + 0.12) * width, own_height)
            if row == 0 or one_column:
                x, y = left + (0.5 * share + 0.06) * width, bottom + own_height + over
                page.text(x, y, member.capitalize(), ha="center", va="bottom", fontsize=theme.HEADING)
            traces = [
                trace
                for path, look in zip(paths, LOOKS, strict=True)
                for trace in (
                    Trace(path.points[column], look.colour, look.dashes, look.width, look.lift, path.first),
                    *panels.edge_traces(path, column, look.on_edge),
                )
            ]
            design = paths[1].design
            drawn = panels.draw_flank(page, box, design, column, flank, view, traces, px_per_mm, 0.85)
            if drawn is not None:
                panels.draw_lines(drawn, paths[1], column)
                _path_labels(drawn, case, paths, column)
                pictures[f"{member}-{name}"] = drawn.picture
    return Drawing(page, pictures)


def _row_heading(page: theme.Page, y: float, name: str, design: Design) -> None:
    values = "$a_1$ = $a_2$ = 0" if name == "without" else solved.coefficients(design)
    style: dict[str, Any] = {"rotation": 90, "va": "center", "ha": "center"}
    page.text(
        0.32 / page.layout.width, y, f"{name.capitalize()} modification", fontsize=theme.HEADING, **style
    )
    page.text(0.656 / page.layout.width, y, values, fontsize=theme.SMALL, color=theme.GREY, **style)


def _legend(page: theme.Page, case: ErrorCase) -> None:
    handles = [
        Line2D([], [], label=case.label(sign), color=look.colour, dashes=look.legend, linewidth=4.0)
        for look, sign in zip(LOOKS, SIGNS, strict=True)
    ]
    theme.legend(page, handles, 3, 0.8, handlelength=2.8)


def _path_labels(drawn: Panel, case: ErrorCase, paths: tuple[SolvedPath, ...], column: int) -> None:
    """Write error and shift on the right of the flank, led to the path's tip end; beside the gear's also the
    ratios, which are the pair's."""
    axes, picture, view = drawn.axes, drawn.picture, drawn.view
    x = float(picture.project([view.bounds[1, 0], 0.0, 0.0])[0])
    point = axes.figure.dpi / 72.0
    ends = [_tip_end(drawn, path.points[column]) if path.found else None for path in paths]
    found = [end[1] for end in ends if end is not None]
    spare = picture.image.shape[0] * 0.5 if not found else max(found)
    wanted = [spare if end is None else end[1] for end in ends]
    lines = (2, 4 if CELLS.columns(drawn.page.layout, 4) > 1 and drawn.page.layout.printed else 3)[column]
    gap = 6.0 + 15.0 * lines  # points
    order = np.argsort(np.array(wanted) - 1e-3 * np.array(SIGNS), kind="stable")
    lowest = picture.image.shape[0] - 44.0 * point
    heights = spread(np.array(wanted)[order], gap * point, 24.0 * point, lowest)
    for index, y in zip(order, heights, strict=True):
        text, detail = case.label(SIGNS[index]), _detail(paths[index], paths[1], column, lines)
        style: dict[str, Any] = {"color": LOOKS[index].colour, "annotation_clip": False, "ha": "left"}
        start = (x + 34.0 * point, y)
        axes.annotate(text, start, va="bottom", fontsize=theme.LABEL, fontweight="bold", **style)
        axes.annotate(detail, (start[0], y + 2.0 * point), va="top", fontsize=theme.SMALL, **style)
        end = ends[index]
        if end is not None:
            line = [end[0] + 6.0 * point, start[0] - 4.0 * point], [end[1], y]
            axes.plot(*line, color=LOOKS[index].colour, linewidth=1.0, clip_on=False)


def spread(wanted: FloatArray, gap: float, low: float, high: float) -> FloatArray:
    """Find heights nearest to those wanted (ascending) that keep `gap` between them, within limits."""
    heights = np.array(wanted, dtype=float)
    for _ in range(50):
        close = np.diff(heights) < gap - 1e-9
        for i in np.nonzero(close)[0]:
            lack = 0.5 * (gap - (heights[i + 1] - heights[i]))
            heights[i : i + 2] += (-lack, lack)
    heights += max(0.0, low - heights[0])
    heights -= max(0.0, heights[-1] - high)
    return heights


def _tip_end(drawn: Panel, points: FloatArray) -> FloatArray:
    ends = drawn.place(points[[0, -1]])
    return np.asarray(ends[np.argmax(ends[:, 0])])


def _detail(path: SolvedPath, zero: SolvedPath, column: int, lines: int) -> str:
    """Say, in so many lines with the error's own, how far a path is shifted, and of the pair its ratios."""
    if not path.found:
        reason = textwrap.fill(path.reason, SHORT) if lines > 3 else path.reason
        return f"no path:\n{reason}" if column else "no path"
    ratio = panels.ratios(path).replace(", ", ",\n" if lines > 3 else ", ") if column else ""
    if path is zero or not zero.found:
        return ratio
    return f"shift {theme.signed(_shift(path, zero, column), 1)} mm\n{ratio}".rstrip()


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
