"""Figs. 7 to 10: paths of contact for the four combinations of signs of the coefficients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from beveloid_geom.design.model import Design

from ...parts import panels, solved
from ...parts.panels import FlankView, Trace
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import SolvedPath
from ...stage import theme
from ...stage.scene import Picture, Size
from ...stage.theme import Page

FLANK = "right"
STRETCH = 2.0
COLUMNS = 5
LEFT, RIGHT = 0.045, 0.99  # shares of the page's width
TEXT, LABEL = 0.85, 0.27  # inches: three lines under a panel, and one over or under a flank
ANGLES = (
    "Angles are true ones, of the path's chord to the axial direction, positive if it runs to the heel on"
    " its way to the tip. The contact ratio is Eq. 16, from the limits of one tooth pair"
)
NOT_OPERATING = (
    "; with both coefficients positive the next tooth's edge can touch first: it is then no operating ratio"
)


def coefficient_text(value: float) -> str:
    """A coefficient without exponent, as in the paper."""
    return theme.signed(value, 6).rstrip("0").rstrip(".") if value else "0"


@dataclass(frozen=True)
class SignCase:
    """Signs of both coefficients and the greatest magnitude (1/mm) shown."""

    number: int
    pinion: float
    gear: float
    greatest: float
    title: str

    @property
    def coefficients(self) -> list[tuple[float, float]]:
        """Pairs of coefficients a1, a2 (1/mm), one for each column."""
        sizes = [self.greatest * column / (COLUMNS - 1) for column in range(COLUMNS)]
        return [(self.pinion * size + 0.0, self.gear * size + 0.0) for size in sizes]

    def heading(self, column: int) -> str:
        """The coefficients of a column."""
        a1, a2 = self.coefficients[column]
        other = "$a_2$" if a1 == a2 else "\u2212$a_2$"
        return f"$a_1$ = {other} = {coefficient_text(a1)} mm$^{{\u22121}}$"


CASES = (
    SignCase(7, 1.0, 1.0, 0.0002, "Paths of contact: both coefficients positive"),
    SignCase(8, -1.0, -1.0, 0.0002, "Paths of contact: both coefficients negative"),
    SignCase(9, 1.0, -1.0, 0.002, "Paths of contact: pinion coefficient positive, gear negative"),
    SignCase(10, -1.0, 1.0, 0.002, "Paths of contact: pinion coefficient negative, gear positive"),
)


@dataclass(frozen=True, eq=False)
class PathFigure:
    """The paths of one sign case, a column each."""

    case: SignCase
    paths: tuple[SolvedPath, ...]


def compute(case: SignCase, design: Design) -> PathFigure:
    """Solve the path of contact for every column."""
    designs = [design.with_parabola(a1, a2) for a1, a2 in case.coefficients]
    return PathFigure(case, solved.solve_all(designs, FLANK))


@dataclass(frozen=True, eq=False)
class _Layout:
    """Views [row][column], pixels per mm, upper edge and height of each row as shares of the page."""

    views: list[list[FlankView | None]]
    px_per_mm: float
    tops: tuple[float, float]
    heights: tuple[float, float]


def draw(data: PathFigure, size: Size) -> Drawing:
    """A row of pinion flanks over a row of gear flanks, one column for each coefficient."""
    case = data.case
    page = theme.new_page(
        size,
        f"Fig. {case.number}   {case.title}",
        f"{FLANK.capitalize()} flanks of pinion (top) and gear (bottom), the pinion drives;"
        " parabola coefficients $a_1$ of the pinion, $a_2$ of the gear",
    )
    text = (
        panels.how_drawn(FLANK, STRETCH)
        + ANGLES
        + (NOT_OPERATING if min(case.pinion, case.gear) > 0.0 else "")
        + "."
    )
    layout = _lay_out(page, data, theme.caption(page, text))
    panels.scale_bars(page, layout.px_per_mm, STRETCH)
    pictures: dict[str, Picture] = {}
    width = (RIGHT - LEFT) / COLUMNS
    for column, path in enumerate(data.paths):
        middle, y = LEFT + (column + 0.5) * width, layout.tops[0] + theme.inches(page, 0.3)
        page.text(middle, y, case.heading(column), ha="center", va="top", fontsize=theme.HEADING - 1)
        for row, member in enumerate(solved.MEMBERS):
            picture = _panel(page, layout, path, row, column)
            if picture is not None:
                pictures[f"{member}-{column}"] = picture
    for row, member in enumerate(solved.MEMBERS):
        y = layout.tops[row] - 0.5 * (layout.heights[row] - theme.inches(page, TEXT))
        page.text(0.012, y, member.capitalize(), rotation=90, va="center", fontsize=theme.HEADING)
    return Drawing(page, pictures)


def _lay_out(page: Page, data: PathFigure, low: float) -> _Layout:
    """One scale for all flanks; each row as high as its flanks."""
    views = [
        [panels.flank_view(path.design.members[row], FLANK, STRETCH) for path in data.paths] for row in (0, 1)
    ]
    spans = np.stack([panels.greatest_span(row) for row in views])
    page_width, page_height = page.canvas.get_width_height()
    high = theme.top(page) - theme.inches(page, 0.4)
    around = theme.inches(page, TEXT + 2.0 * LABEL)
    room = (high - low - 2.0 * around) * page_height
    column = 0.72 * (RIGHT - LEFT) / COLUMNS * page_width
    px_per_mm = float(min(room / spans[:, 1].sum(), column / spans[:, 0].max()))
    spare = 0.5 * (room / page_height - px_per_mm * float(spans[:, 1].sum()) / page_height)
    pinion, gear = (around + spare + px_per_mm * float(span) / page_height for span in spans[:, 1])
    return _Layout(views, px_per_mm, (high, high - pinion), (pinion, gear))


def _panel(page: Page, layout: _Layout, path: SolvedPath, row: int, column: int) -> Picture | None:
    """One flank with its path, and three lines under it."""
    width = (RIGHT - LEFT) / COLUMNS
    x, bottom = LEFT + column * width, layout.tops[row] - layout.heights[row]
    text, view = theme.inches(page, TEXT), layout.views[row][column]
    box = theme.place(page, x + 0.1 * width, bottom + text, 0.8 * width, layout.heights[row] - text)
    colour = (theme.STEEL, theme.BRONZE)[row]
    member, traces = path.design.members[row], [Trace(path.points[row])]
    drawn = panels.draw_flank(page, box, member, FLANK, view, traces, layout.px_per_mm, colour)
    if view is None or drawn is None:
        return None
    axes, picture = drawn
    panels.label_limits(axes, picture, view)
    style: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": theme.SMALL, "linespacing": 1.3}
    page.text(x + 0.5 * width, bottom + text, _under(path, row, view), **style)
    return picture


def _under(path: SolvedPath, row: int, view: FlankView) -> str:
    if not path.found:
        return f"no contact on the flank:\n{path.reason}"
    points = path.points[row]
    length, angle = panels.path_length(points), theme.signed(panels.chord_angle(points, view), 1)
    ends = " \u2192 ".join(path.ends)
    return f"{length:.1f} mm long, at {angle}\u00b0\n{ends}\ncontact ratio {path.ratio:.3f}"


def rows(data: PathFigure) -> Table:
    """Every position of every path on both members."""
    header = ("a1_per_mm", "a2_per_mm", "member", *solved.COLUMNS)

    def body() -> Iterator[list[object]]:
        for (a1, a2), path in zip(data.case.coefficients, data.paths, strict=True):
            yield from solved.path_rows((a1, a2), path)

    return header, body()


RECIPES = {f"fig-{case.number:02d}": Recipe(partial(compute, case), draw, rows) for case in CASES}
