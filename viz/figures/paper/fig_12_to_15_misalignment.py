"""Figs. 12 to 15: paths of contact under each assembly error, without and with modification."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from beveloid_geom import Design
from beveloid_geom.contact.flank_pair import is_modified
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.validation.claims import ANGLE_ERROR, AXIAL_ERROR, OFFSET_ERROR
from beveloid_geom.validation.statements import is_table1

from ...components import annotate, panels, paths_table, viewpoint
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.flank_grid import Cell, FlankArrangement, draw_grid
from ...components.panels import Trace
from ...components.paths_table import SolvedPath
from ...rendering import theme
from ...rendering.scene import Picture, Surface

SIGNS = (-1.0, 0.0, 1.0)


class PathStyle(NamedTuple):
    """Style of a path: colour, dashes, width, lift of `panels.Trace`, legend line, and two widths of edge
    contact: for paths far apart, and for paths close together."""

    colour: str
    dashes: tuple[float, ...]
    width: float
    lift: float
    legend: tuple[float, ...]
    edge: tuple[float, float]

    def on_edge(self, close: bool) -> Trace:
        """Return the style of edge contact; wider lines are lower, so that all are visible."""
        width = self.edge[close]
        return Trace(np.empty((0, 3)), self.colour, width=width, lift=2.0 / width**2)


LOOKS = (
    PathStyle(theme.BLUE, panels.DASHED, 0.85, 0.5, (2.5, 1.5), (0.65, 0.65)),
    PathStyle(theme.INK, panels.SOLID, 1.0, 0.0, (1.0, 0.0), (1.1, 1.1)),
    PathStyle(theme.VERMILLION, panels.DOTTED, 0.85, 1.0, (0.8, 1.2), (0.6, 0.35)),
)
"""Styles of a negative error, no error, and a positive error."""
ROW_HEIGHT_IN, TABLE_WIDTH_IN = 0.21, 2.9
"""Line spacing and width of the table of a flank."""
INSET_IN, SIDE_DETAIL_IN = (2.3, 1.25), (1.35, 1.25)
"""Width and height of the magnified detail below the table, and next to the flank."""


@dataclass(frozen=True)
class ErrorCase:
    """An assembly error: field, size in mm or rad, printed unit and name."""

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
        """Return the error scaled to the module of a design. If the errors of the design are at the mesh,
        return the corresponding error at the mesh (centre distance, or shaft angle in plane)."""
        # Fields and names of errors at the mesh; axial errors are the same.
        at_mesh = {
            "offset": ("centre_distance", "centre-distance error at the mesh"),
            "shaft_angle": ("in_plane", "shaft-angle error at the mesh"),
        }
        times = paths_table.as_large(design) if self.unit == "mm" else 1.0
        size = paths_table.two_digits(self.size * times) if times != 1.0 else self.size
        as_given = self.field, self.name
        field, name = at_mesh.get(self.field, as_given) if design.errors_at == "mesh" else as_given
        note = self.note if is_table1(design) else ""
        return replace(self, size=size, field=field, name=name, note=note)

    @property
    def digits(self) -> int:
        """Number of decimals of the size in the unit."""
        return len(f"{self.shown:g}".partition(".")[2])

    def label(self, sign: float) -> str:
        """Return the error with sign and unit as text."""
        return f"{theme.signed(sign * self.shown, self.digits) if sign else '0'}\u00a0{self.unit}"


CASES = (
    ErrorCase(12, "offset", OFFSET_ERROR, "mm", "offset error"),
    ErrorCase(
        number=13,
        field="shaft_angle",
        size=ANGLE_ERROR,
        unit="deg",
        name="shaft-angle error",
        note=" Shaft-angle error: chosen here, not the paper's.",
    ),
    ErrorCase(14, "pinion_axial", AXIAL_ERROR, "mm", "axial position error of the pinion"),
    ErrorCase(15, "gear_axial", AXIAL_ERROR, "mm", "axial position error of the gear"),
)


@dataclass(frozen=True, eq=False)
class MisalignmentFigure:
    """Paths of a flank under one error at minus, zero and plus, without and with modification."""

    case: ErrorCase
    flank: str
    paths: tuple[tuple[SolvedPath, ...], tuple[SolvedPath, ...]]

    @property
    def close(self) -> bool:
        """True if the paths of a case are so close together that a magnified detail is drawn."""
        # Largest shift that needs a detail, as a fraction of the face width.
        face_fraction = 0.04
        shifts = [
            _shift(path, paths[1], member) / float(path.design.members[member].face_width)
            for paths in self.paths
            for path in paths
            for member in (0, 1)
        ]
        return bool((np.abs(shifts) < face_fraction).all())


def compute(case: ErrorCase, design: Design, flank: str = "right") -> MisalignmentFigure:
    """Compute the six paths. The error is added to those of the design."""

    def paths(base: Design) -> tuple[SolvedPath, ...]:
        """Return the paths of a design under the errors."""
        sizes = (np.array([sign * case.size]) for sign in SIGNS)
        return tuple(
            paths_table.solved_case(mounted(base, size, (case.field,)), flank, touching=True)
            for size in sizes
        )

    case = case.at(design)
    plain, modified = design.unmodified(), paths_table.paper_modified(design)
    return MisalignmentFigure(case, flank, (paths(plain), paths(modified)))


def draw(data: MisalignmentFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the unmodified pair above the modified pair, as in the paper: pinion on the left, gear on the
    right. In print, the cases are in columns."""
    case, flank = data.case, data.flank
    values = "$a_1$ = $a_2$ = 0", paths_table.coefficients(data.paths[1][1].design)
    modified = is_modified(data.paths[1][1].design, flank)
    design_words = "the design's modifications and " if modified else "modification, "
    names = (
        f"{word}{value}".replace(" = ", "\u00a0=\u00a0").replace(" mm", "\u00a0mm")
        for word, value in zip(("without modification, ", f"with {design_words}"), values, strict=True)
    )
    cases = [(name, paths[1].design, flank) for name, paths in zip(names, data.paths, strict=True)]
    # Width of the widest flank as a fraction of its column if a table is next to it.
    flank_share = 0.6
    grid = FlankArrangement(cases, (0.0, 0.0), by_case=True, share=flank_share)
    # Magnification from root to tip in print, where tables are below the flanks, and on a narrow page.
    print_stretch, narrow_stretch = 4.0, 3.0
    if layout.printed:  # pinion above gear, so that flanks with a table below are large enough
        lost = max(sum(not path.has_path for path in paths) for paths in data.paths)
        below = data.close and not layout.wide
        rows = len(SIGNS) + 1 + (INSET_IN[1] / ROW_HEIGHT_IN if below else 0.0)
        text = ROW_HEIGHT_IN * rows, ROW_HEIGHT_IN * (rows + 2 * lost)
        cases = [(f"{name[0].upper()}{name[1:]}", design, flank) for name, design, _ in cases]
        grid = FlankArrangement(cases, text, print_stretch if layout.wide else narrow_stretch)
    page, low, high = theme.new_page(
        layout,
        f"Fig. {case.number}   Paths of contact under {case.name}",
        f"{flank.capitalize()} flanks, the pinion drives",
        panels.how_drawn(flank, grid.stretch)
        + "Shift: along the face at mid-roll, positive towards +z. "
        + panels.what_touches([path for paths in data.paths for path in paths])
        + case.note
        + panels.lines_drawn(paths[1] for paths in data.paths),
        above=0.3,
        characters=viewpoint.NOTE_CHARACTERS,
        tall=grid.tall(layout),
    )
    _legend(page, data)
    details: dict[str, Picture] = {}

    def panel(cell: Cell) -> Picture | None:
        """Draw one flank with its three paths and its table."""
        paths, member = data.paths[cell.case], cell.member
        detail_at_side, full = data.close and layout.printed and layout.wide, cell.box
        # Tables, or details in print, are to the right of the flanks.
        side_in = SIDE_DETAIL_IN[0] if detail_at_side else 0.0 if layout.printed else TABLE_WIDTH_IN
        cell = replace(cell, box=replace(full, width=full.width - round(side_in * page.dpi)))
        traces = []
        for path, look in zip(paths, LOOKS, strict=True):
            style = look.colour, look.dashes, look.width, look.lift
            traces.append(Trace(path.points[member], *style, path.first))
            traces += panels.edge_traces(path, member, look.on_edge(data.close))
        where = page, cell.box, paths[1].design, member, cell.view
        drawn = panels.draw_flank(*where, traces, cell.px_per_mm, cell.labels_at)
        if drawn is None:
            return None
        panels.draw_lines(drawn, paths[1], member)
        low = _table(page, cell, data, paths)
        if data.close:
            detail = _inset(drawn, paths[1], member, traces, full if detail_at_side else low)
            details[f"{paths_table.MEMBERS[member]}-{cell.case}-detail"] = detail
        return drawn.picture

    return Drawing(page, draw_grid(page, grid, low, high, panel) | details)


def _legend(page: theme.Page, data: MisalignmentFigure) -> None:
    """Draw the legend of the errors and of the parts of the paths."""
    width = 4.0 * panels.half_width_pt(page) / panels.HALF_WIDTH_PT
    handles = [
        Line2D([], [], label=data.case.label(sign), color=look.colour, dashes=look.legend, linewidth=width)
        for look, sign in zip(LOOKS, SIGNS, strict=True)
    ]
    paths = [path for of_design in data.paths for path in of_design]
    parts = panels.touching_legend(page, paths, (theme.GREY, theme.GREY, theme.GREY))
    handles += [part for part in parts if part.get_label() != "first contact"]
    theme.legend(page, handles, 5, 0.8, handlelength=2.8)


def _table(
    page: theme.Page, cell: Cell, data: MisalignmentFigure, paths: tuple[SolvedPath, ...]
) -> tuple[float, float]:
    """Write the table of a flank: shift of each path, and for the gear also the ratios of the pair.

    The reason is written for cases without a path. Returns the middle of the lower edge as fractions of the
    page."""
    both = ("ratio", "all") if cell.member else ()
    lines = [(data.case.unit, "shift mm", *both)]
    lines += [
        _line(data.case, sign, path, paths[1], cell.member) for sign, path in zip(SIGNS, paths, strict=True)
    ]
    # Fractions of the width at which columns end.
    column_ends = (0.265, 0.58, 0.79, 1.0)
    (middle, y), width, case = cell.under, min(cell.width / page.dpi, TABLE_WIDTH_IN), data.case
    width /= page.layout.width
    left = middle - (0.5 if cell.member else 0.55 * column_ends[1]) * width
    if not page.layout.printed:
        left = (cell.box.left + cell.box.width) / (page.dpi * page.layout.width)
        height = len(lines) * ROW_HEIGHT_IN + (INSET_IN[1] if data.close else 0.0)
        y += theme.inches(page, 0.5 * (cell.box.height / page.dpi + height))
    colours = theme.GREY, *(look.colour for look in LOOKS)
    for number, (line, colour) in enumerate(zip(lines, colours, strict=True)):
        for at, word in zip(column_ends, line, strict=False):
            place = left + at * width, y - theme.inches(page, ROW_HEIGHT_IN * (number + 0.7))
            page.text(*place, word, color=colour, ha="right", va="baseline", fontsize=theme.SMALL)
    lost = [(sign, path) for sign, path in zip(SIGNS, paths, strict=True) if not path.has_path]
    reasons = [f"{case.label(sign)}: {path.reason}" for sign, path in lost]
    low = y - theme.inches(page, ROW_HEIGHT_IN * len(lines))
    if reasons and cell.member:
        pixels = width * page.layout.width * page.dpi
        replace(cell, under=(left + 0.5 * width, low), width=pixels).say(page, "\n".join(reasons))
    return left + 0.5 * width if cell.member or not page.layout.printed else middle, low


def _inset(
    panel: panels.Panel,
    path: SolvedPath,
    member: int,
    traces: list[Trace],
    place: theme.PageBox | tuple[float, float],
) -> Picture:
    """Draw the middle of the paths magnified, and its frame on the flank.

    The place is the middle of the upper edge, as fractions of the page, or the box of the flank, for a detail
    at its right edge."""
    times = 5.0  # magnification
    page, scale = panel.page, panel.picture.px_per_mm
    if isinstance(place, theme.PageBox):
        wide, high = SIDE_DETAIL_IN
        left = (place.left + place.width) / page.dpi - wide
        top = (place.bottom + 0.5 * place.height) / page.dpi + 0.5 * high
    else:
        wide, high = INSET_IN
        left, top = place[0] * page.layout.width - 0.5 * wide, place[1] * page.get_figheight() - 0.1
    low, height = theme.inches(page, top - high + 0.15), theme.inches(page, high - 0.15)
    box = theme.place(page, left / page.layout.width, low, wide / page.layout.width, height)
    middle = panel.view.place(path.middle(member))[:2]
    half = 0.5 * np.array(box.size) / (times * scale)
    view = replace(panel.view, bounds=np.stack((middle - half, middle + half)))
    surface = next(item for item in panel.items if isinstance(item, Surface))
    items = [surface, *panels.path_items(page, traces, view, times * scale)]
    detail = panels.show_items(page, box, view, items, times * scale, None)
    frame = panel.picture.project(np.append(middle, 0.0))
    for axes, centre, size in (
        (panel.axes, frame, 2.0 * half * scale),
        (detail.axes, 0.5 * np.array(box.size), np.array(box.size) - 2.0),
    ):
        style: dict[str, Any] = {"fill": False, "edgecolor": theme.GREY, "linewidth": 1.0, "zorder": 4}
        axes.add_patch(Rectangle(tuple(centre - 0.5 * size), *size.tolist(), **style))
    right, down = _free_corner(detail.picture.image, page.dpi)
    corner: dict[str, Any] = {"ha": "right" if right else "left", "va": "bottom" if down else "top"}
    offset = (-4.0 if right else 4.0, 3.0 if down else -3.0)
    place = (right * box.width, down * box.height)
    words = f"\u00d7 {times:g}"
    annotate.text(detail.axes, place, words, offset, fontsize=theme.SMALL, **corner)
    return detail.picture


def _free_corner(image: NDArray[np.uint8], dpi: float) -> tuple[bool, bool]:
    """Return the corner of a picture, right and down, for a label: the upper left one if it shows no paths,
    else the one with the most even colour."""
    # Size of the label, inches, and standard deviation of the shading of metal, of 255 levels.
    width, height = (round(inches * dpi) for inches in (0.5, 0.3))
    shading = 6.0
    corners = [(False, False), (True, False), (False, True), (True, True)]
    parts = (
        image[slice(-height, None) if down else slice(height), slice(-width, None) if right else slice(width)]
        for right, down in corners
    )
    uneven = [float(part.reshape(-1, part.shape[-1]).std(axis=0).max()) for part in parts]
    return corners[0 if uneven[0] < shading else int(np.argmin(uneven))]


def _line(case: ErrorCase, sign: float, path: SolvedPath, zero: SolvedPath, member: int) -> tuple[str, ...]:
    """Return the line of a path in the table of pinion (0) or gear (1). Shifts have at least as many decimals
    as an error in mm."""
    error = case.label(sign).partition("\u00a0")[0]
    if not path.has_path:
        return (error, "", "no path", _ratios(path)[1]) if member else (error, "no path")
    shift = _shift(path, zero, member)
    digits = max(paths_table.digits_mm(path.design), case.digits if case.unit == "mm" else 0)
    shift_text = "" if path is zero else theme.signed(shift, digits) if np.isfinite(shift) else "unknown"
    return error, shift_text, *(_ratios(path) if member else ())


def _ratios(path: SolvedPath) -> tuple[str, str]:
    """Return the columns of both contact ratios, which have no space for a number next to "jammed"."""
    return ("", "jammed") if path.jammed else panels.ratios(path)


def _shift(path: SolvedPath, zero: SolvedPath, member: int) -> float:
    """Return the shift (mm) along the face of pinion (0) or gear (1); NaN unless both paths exist."""
    both = path.has_path and zero.has_path
    return float(path.middle(member)[2] - zero.middle(member)[2]) if both else np.nan


def rows(data: MisalignmentFigure) -> Table:
    """List every position of every path on both members."""
    header = "modified", f"{data.case.field}_error_{data.case.unit}", "pinion_shift_mm", "gear_shift_mm"
    paths = []
    for modified, of_error in zip(("no", "yes"), data.paths, strict=True):
        for sign, path in zip(SIGNS, of_error, strict=True):
            shifts = (_shift(path, of_error[1], member) for member in (0, 1))
            paths.append(((modified, sign * data.case.shown + 0.0, *shifts), path))
    return paths_table.table(header, paths)


RECIPES = {f"fig-{case.number:02d}": Recipe(partial(compute, case), draw, rows) for case in CASES}
