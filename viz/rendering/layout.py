"""Page layout: at a size in pixels, or for a width in print; rows of panels on a page.

Lengths are inches of the layout, in which text and lines have their usual sizes. In print, one inch of the
layout is PAPER_INCHES_PER_INCH inches of paper: text of 13 points becomes 8 points. A narrow page has less
space, not smaller text.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .scene import Size

PAPER_INCHES_PER_INCH = 8.0 / 13.0
"""Inches of paper per inch of the layout in print."""
MAX_HEIGHT_IN = 9.28
"""Largest height of a figure in print, inches, so that the page with title and note fits on a journal
page."""


@dataclass(frozen=True)
class PageLayout:
    """Size of a page.

    Attributes
    ----------
    width : float
        Width, inches.
    height : float or None
        Height, inches; None if the height follows from the figure, as in print.
    dpi : float
        Pixels per inch.
    plain : bool
        True to leave out title, subtitle and note.
    """

    width: float
    height: float | None
    dpi: float
    plain: bool = False

    @property
    def printed(self) -> bool:
        """True if the page is laid out for a width in print."""
        return self.height is None

    @property
    def wide(self) -> bool:
        """True if two panels fit side by side; otherwise they are placed one above the other."""
        least_width_in = 9.0
        return self.width > least_width_in

    @property
    def scale(self) -> float:
        """Inches in the file per inch of the layout."""
        return PAPER_INCHES_PER_INCH if self.printed else 1.0


def of_size(size_px: Size, plain: bool = False) -> PageLayout:
    """Return the layout for a page of width and height in pixels: at least 16 x 12 inches. Text scales with
    the page."""
    width, height = size_px
    dpi = min(width / 16.0, height / 12.0)
    return PageLayout((width + 1e-6) / dpi, (height + 1e-6) / dpi, dpi, plain)


def of_width(mm: float, plain: bool = False) -> PageLayout:
    """Return the layout for a width in print, mm. The height follows from the figure."""
    # Pixels per inch of paper.
    print_dpi = 300.0
    dpi = print_dpi * PAPER_INCHES_PER_INCH
    return PageLayout((round(mm / 25.4 * print_dpi) + 1e-6) / dpi, None, dpi, plain)


@dataclass(frozen=True)
class PanelRows:
    """Rows of panels.

    Attributes
    ----------
    left, right : float
        Space to the left of the first and to the right of the last panel of a row, inches.
    across, down : float
        Space between neighbouring panels for axis labels, inches.
    most : int
        Largest number of columns.
    least : float
        Smallest width of a panel, inches.
    """

    left: float
    right: float
    across: float
    down: float
    most: int
    least: float

    def columns(self, layout: PageLayout, count: int) -> int:
        """Return the number of columns for `count` panels: the smallest number that does not need more rows
        than the largest number of columns that fits."""
        width = layout.width - self.left - self.right + self.across
        most = max(1, min(self.most, count, int(width / (self.least + self.across) + 1e-9)))
        return -(-count // -(-count // most))

    def width(self, layout: PageLayout, count: int) -> float:
        """Return the width of a panel, inches."""
        columns = self.columns(layout, count)
        return (layout.width - self.left - self.right - (columns - 1) * self.across) / columns

    def tall(self, layout: PageLayout, count: int, height: float) -> float:
        """Return the height of all rows, inches, for panels of a given height. Limited to MAX_HEIGHT_IN."""
        rows = -(-count // self.columns(layout, count))
        return min(rows * height + (rows - 1) * self.down, MAX_HEIGHT_IN)

    def boxes(
        self, layout: PageLayout, count: int, page_height: float, low: float, high: float
    ) -> list[tuple[float, float, float, float]]:
        """Return left, bottom, width and height of each panel, as fractions of the page.

        Parameters
        ----------
        layout : PageLayout
            Size of the page.
        count : int
            Number of panels.
        page_height : float
            Height of the page, inches.
        low, high : float
            Lower and upper limit of the rows, as fractions of the page height.
        """
        columns, width = self.columns(layout, count), self.width(layout, count)
        rows = -(-count // columns)
        height = ((high - low) * page_height - (rows - 1) * self.down) / rows
        boxes = []
        for number in range(count):
            row, column = divmod(number, columns)
            left = (self.left + column * (width + self.across)) / layout.width
            bottom = high - ((row + 1) * height + row * self.down) / page_height
            boxes.append((left, bottom, width / layout.width, height / page_height))
        return boxes
