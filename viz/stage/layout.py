"""How a page is laid out: at a size in pixels, or anew for a width in print; and panels in rows on it.

Lengths are inches at which type and lines have their usual sizes. In print an inch of the layout is SCALE
inches of paper, so that type of 13 points becomes 8: a narrow page has less room, not smaller type.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .scene import Size

SCALE = 8.0 / 13.0
"""Inches of paper for an inch of the layout in print."""
PRINT_DPI = 300.0
"""Pixels to an inch of paper."""
USUAL = (16.0, 12.0)
ROOM = 9.28
"""Inches that a figure may take in print, so that with its words it has room on a journal's page."""


@dataclass(frozen=True)
class Layout:
    """A page `width` inches wide and `height` high, None where it is as high as its figure needs, of so many
    pixels to an inch; `plain` leaves out title, subtitle and note."""

    width: float
    height: float | None
    dpi: float
    plain: bool = False

    @property
    def printed(self) -> bool:
        """Whether the page is laid out for a width in print."""
        return self.height is None

    @property
    def scale(self) -> float:
        """Inches in the file for an inch of the layout."""
        return SCALE if self.printed else 1.0


def of_size(size_px: Size, plain: bool = False, inches: tuple[float, float] = USUAL) -> Layout:
    """Lay out for a size in pixels: the smaller the page, the larger its type in pixels."""
    width, height = size_px
    dpi = min(width / inches[0], height / inches[1])
    return Layout((width + 1e-6) / dpi, (height + 1e-6) / dpi, dpi, plain)


def of_width(mm: float, plain: bool = False) -> Layout:
    """Lay out for a width in print, mm, as high as the figure needs."""
    dpi = PRINT_DPI * SCALE
    return Layout((round(mm / 25.4 * PRINT_DPI) + 1e-6) / dpi, None, dpi, plain)


@dataclass(frozen=True)
class Cells:
    """Panels row by row: inches `left` of the first and `right` of the last of a row, `across` and `down`
    between neighbours, for the words of their axes; at `most` columns, each panel at least `least` wide."""

    left: float
    right: float
    across: float
    down: float
    most: int
    least: float

    def columns(self, layout: Layout, count: int) -> int:
        """Say into how many columns so many panels go: as few as fill as few rows as there can be."""
        room = layout.width - self.left - self.right + self.across
        most = max(1, min(self.most, count, int(room / (self.least + self.across) + 1e-9)))
        return -(-count // -(-count // most))

    def width(self, layout: Layout, count: int) -> float:
        """Give the width of a panel, inches."""
        columns = self.columns(layout, count)
        return (layout.width - self.left - self.right - (columns - 1) * self.across) / columns

    def tall(self, layout: Layout, count: int, height: float) -> float:
        """Give the inches that the rows of panels of a height, inches, or lower ones, take in ROOM."""
        rows = -(-count // self.columns(layout, count))
        return min(rows * height + (rows - 1) * self.down, ROOM)

    def boxes(
        self, layout: Layout, count: int, page_height: float, low: float, high: float
    ) -> list[tuple[float, float, float, float]]:
        """Give left, bottom, width and height of each panel, shares of a page so many inches high, between
        two heights of it, shares too."""
        columns, width = self.columns(layout, count), self.width(layout, count)
        rows = -(-count // columns)
        height = ((high - low) * page_height - (rows - 1) * self.down) / rows
        return [
            (
                (self.left + column * (width + self.across)) / layout.width,
                high - ((row + 1) * height + row * self.down) / page_height,
                width / layout.width,
                height / page_height,
            )
            for row, column in (divmod(number, columns) for number in range(count))
        ]
