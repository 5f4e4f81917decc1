"""Flanks of pinion and gear for several cases, in rows and columns with the same scale."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, ClassVar

from beveloid_geom import Design

from ..rendering import theme
from ..rendering.layout import PanelRows
from ..rendering.scene import Picture
from ..rendering.theme import Page, PageBox
from .panels import FACE_STRETCH, LABEL_IN
from .paths_table import MEMBERS
from .viewpoint import FlankView, flank_views, greatest_span, looks_of, scale_bars

LEFT_MARGIN_FRACTION = 0.045  # fractions of the page width
CELLS = PanelRows(left=0.72, right=0.16, across=0.0, down=0.0, most=5, least=0.95)


@dataclass(frozen=True, eq=False)
class Cell:
    """Position of a flank.

    Attributes
    ----------
    case, member : int
        Number of the case, and pinion (0) or gear (1).
    box : PageBox
        Box for the picture.
    view : FlankView or None
        View.
    px_per_mm : float
        Scale.
    labels_at : float or None
        Position of the labels of root and tip, from mid-face (0) to +z (1); None for no labels.
    under : tuple of float
        Upper middle of the text below the flank, fractions of the page.
    width : float
        Largest width of this text, pixels.
    """

    case: int
    member: int
    box: PageBox
    view: FlankView | None
    px_per_mm: float
    labels_at: float | None
    under: tuple[float, float]
    width: float

    def say(self, page: Page, words: str) -> None:
        """Write text below the flank."""
        style: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": theme.SMALL, "linespacing": 1.3}
        theme.wrap_text(page.text(*self.under, "", **style), words, self.width)


@dataclass(frozen=True, eq=False)
class FlankArrangement:
    """Arrangement of the flanks of several cases.

    Attributes
    ----------
    cases : sequence of tuple
        Heading, design and flank of each case.
    text_heights_in : sequence of float
        Height of the text below the flanks of each row, inches.
    stretch : float
        Magnification from root to tip, relative to the direction of the face width.
    outside : bool
        True for views from outside; otherwise as in the paper.
    by_case : bool
        True for a row for each case, with pinion left and gear right. Otherwise pinion flanks are above gear
        flanks, with a column for each case; on a page that is too narrow, further columns follow below.
    share : float
        Width of the widest flank as a fraction of its column.
    """

    cases: Sequence[tuple[str, Design, str]]
    text_heights_in: Sequence[float]
    stretch: float = FACE_STRETCH
    outside: bool = False
    by_case: bool = False
    share: float = 0.88
    heading_in: ClassVar[float] = 0.4  # above a row of flanks with headings

    @property
    def columns(self) -> int:
        """Number of columns on a wide page."""
        return len(MEMBERS) if self.by_case else len(self.cases)

    def tall(self, layout: theme.PageLayout) -> float:
        """Return the height in print, inches."""
        rows = len(self.text_heights_in)
        headings = (rows if self.by_case else 1) * self.heading_in
        words = headings + sum(self.text_heights_in) + 2.0 * rows * LABEL_IN
        flank = min(3.0 * CELLS.width(layout, self.columns) / self.stretch, 3.6)
        return CELLS.tall(layout, self.columns, words + rows * flank)

    def rows(self, layout: theme.PageLayout) -> list[tuple[list[tuple[int, int]], float, float]]:
        """Return case and member of the flanks of each row, with the heights of heading and text, inches."""
        if self.by_case:
            both = range(len(MEMBERS))
            return [
                ([(case, member) for member in both], self.heading_in, under)
                for case, under in enumerate(self.text_heights_in)
            ]
        count, per_row = len(self.cases), CELLS.columns(layout, self.columns)
        return [
            ([(case, member) for case in range(first, min(first + per_row, count))], *heights)
            for first in range(0, count, per_row)
            for member, heights in enumerate(zip((self.heading_in, 0.0), self.text_heights_in, strict=True))
        ]

    def heading(self, case: int, member: int) -> str:
        """Return the heading of a flank, or of its column."""
        name = self.cases[case][0]
        return f"{MEMBERS[member].capitalize()} {name}" if self.by_case else name


def text_heights(layout: theme.PageLayout, count: int, text: Sequence[float]) -> tuple[float, ...]:
    """Return the height of the text below flanks, inches, larger in narrow columns, where lines are
    broken."""
    width = CELLS.width(layout, count)
    more = 1.0 if width > 2.8 else 1.35 if width > 2.2 else 1.8
    return tuple(more * height for height in text)


def draw_grid(
    page: Page, grid: FlankArrangement, low: float, high: float, draw: Callable[[Cell], Picture | None]
) -> dict[str, Picture]:
    """Draw the flanks of all cases with the same scale.

    Parameters
    ----------
    page : Page
        Page.
    grid : FlankArrangement
        Cases and arrangement.
    low, high : float
        Limits of the space, as fractions of the page height.
    draw : callable
        Draws a cell, and returns its picture.

    Returns
    -------
    dict
        Pictures by member and case.
    """
    views = [flank_views(design, flank, grid.stretch, grid.outside) for _, design, flank in grid.cases]
    rows = grid.rows(page.layout)
    spans = [greatest_span(views[case][member] for case, member in cells) for cells, _, _ in rows]
    around = sum(heading + under + 2.0 * LABEL_IN for _, heading, under in rows)
    page_width, page_height = page.canvas.get_width_height()
    width = (0.99 - LEFT_MARGIN_FRACTION) / CELLS.columns(page.layout, grid.columns)
    height_px = (high - low - theme.inches(page, around)) * page_height
    flanks = sum(span[1] for span in spans)
    widest = greatest_span(chain(*views))[0]
    px_per_mm = float(min(height_px / flanks, grid.share * width * page_width / widest))
    spare = (height_px - px_per_mm * flanks) / len(rows) / page_height
    scale_bars(page, px_per_mm, grid.stretch, looks_of(chain(*views)))
    pictures: dict[str, Picture] = {}
    top = high
    for (cells, heading, under), span in zip(rows, spans, strict=True):
        head, foot = theme.inches(page, heading), theme.inches(page, under)
        height = float(spare + theme.inches(page, 2.0 * LABEL_IN) + px_per_mm * span[1] / page_height)
        y, labelled = top - head - height, set()
        for place, (case, member) in enumerate(cells):
            x = LEFT_MARGIN_FRACTION + place * width
            middle = x + 0.5 * width, y + height
            if heading:
                _write_heading(page, grid.heading(case, member), middle, 0.9 * width * page_width)
            if place == 0 and not grid.by_case:
                style: dict[str, Any] = {"rotation": 90, "va": "center", "fontsize": theme.HEADING}
                page.text(0.012, y + 0.5 * height, MEMBERS[member].capitalize(), **style)
            box = theme.place(page, x + 0.01 * width, y, 0.98 * width, height)
            view, kind = views[case][member], (member, grid.cases[case][2])
            labels_at = None if kind in labelled else 0.0
            under_it = (x + 0.5 * width, y), 0.97 * width * page_width
            picture = draw(Cell(case, member, box, view, px_per_mm, labels_at, *under_it))
            if view is not None:
                labelled.add(kind)
            if picture is not None:
                pictures[f"{MEMBERS[member]}-{case}"] = picture
        top = y - foot
    return pictures


def _write_heading(page: Page, words: str, at: tuple[float, float], width: float) -> None:
    """Write a heading of at most a width, pixels, above the middle of a flank."""
    name = page.text(at[0], at[1] + theme.inches(page, 0.3), "", fontsize=theme.LABEL, ha="center")
    name.set_verticalalignment("top" if page.layout.height else "bottom")
    theme.wrap_text(name, words, width)
