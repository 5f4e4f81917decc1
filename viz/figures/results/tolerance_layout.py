"""Layout of the figure `tolerance-cloud`: clouds of paths and charts of each flank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...rendering import theme
from ...rendering.layout import Cells

LEFT, RIGHT = 0.05, 0.99  # fractions of the page width
CLOUD_WIDTH, CHART_GAP = 0.145, 0.058  # fractions of the page width
CHARTS = Cells(left=0.9, right=0.25, across=0.95, down=0.65, most=2, least=1.3)
PRINT_CLOUDS_WIDTH_IN, PRINT_CLOUD_HEIGHT_IN, PRINT_BLOCK_HEIGHT_IN, PRINT_COLUMN_HEIGHT_IN = (
    4.2,
    1.9,
    4.7,
    7.65,
)
"""Lengths in print, inches: width of the clouds next to charts, their height above charts, and height of a
flank in both layouts."""


@dataclass(frozen=True, eq=False)
class Section:
    """Layout of a flank, fractions of the page: boxes (left, bottom, width, height) of its clouds and charts,
    positions of its name and of its text, and number of characters per line."""

    clouds: Sequence[tuple[float, float, float, float]]
    charts: Sequence[tuple[float, float, float, float]]
    name: tuple[float, float]
    upright: bool
    words: tuple[float, float]
    columns: int


def _sections_on_screen(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Return a row for each flank: clouds on the left, charts on the right."""
    bottoms, height = theme.split_rows(low, high, count)
    height -= theme.inches(page, 0.5)
    start = LEFT + 2.0 * (CLOUD_WIDTH + 0.012) + 0.035
    width = (RIGHT - start - 3.0 * CHART_GAP) / 4.0
    over, under = theme.inches(page, 0.35), theme.inches(page, 0.6)
    return [
        Section(
            [(LEFT + column * (CLOUD_WIDTH + 0.012), bottom, CLOUD_WIDTH, height) for column in (0, 1)],
            [
                (start + k * (width + CHART_GAP), bottom + under, width, height - under - over)
                for k in range(4)
            ],
            (0.012, bottom + 0.5 * height),
            True,
            (start, bottom + height + theme.inches(page, 0.2)),
            200,
        )
        for bottom in bottoms
    ]


def _sections_in_print(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Return a block for each flank with clouds next to the charts, or on a narrow page a column with clouds
    above the charts."""
    layout, tall, wide = page.layout, page.get_figheight(), page.layout.width > theme.NARROW
    bottoms, block = theme.split_rows(low, high, count if wide else 1, theme.inches(page, 0.5))
    found = []
    for number in range(count):
        bottom, width = bottoms[number if wide else 0], layout.width if wide else layout.width / count
        start = 0.0 if wide else number * width
        cells = (
            replace(CHARTS, left=CHARTS.left + PRINT_CLOUDS_WIDTH_IN)
            if wide
            else replace(CHARTS, most=1, down=0.5)
        )
        top = bottom + block - theme.inches(page, 1.0 if wide else 1.75)
        base = bottom + theme.inches(page, 0.55)
        foot = base if wide else top - theme.inches(page, PRINT_CLOUD_HEIGHT_IN)
        room, left = PRINT_CLOUDS_WIDTH_IN if wide else width - 0.3, start + 0.2
        charts_on = replace(layout, width=width)
        boxes = cells.boxes(charts_on, 4, tall, base, top if wide else foot - theme.inches(page, 0.3))
        share = width / layout.width
        found.append(
            Section(
                [
                    ((left + 0.5 * k * room) / layout.width, foot, 0.48 * room / layout.width, top - foot)
                    for k in (0, 1)
                ],
                [(start / layout.width + x * share, y, w * share, height) for x, y, w, height in boxes],
                (left / layout.width, bottom + block),
                False,
                (left / layout.width, bottom + block - theme.inches(page, 0.12)),
                int(10.0 * width),
            )
        )
    return found


def sections_of(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Return the layout of `count` flanks between two heights, fractions of the page."""
    return (_sections_in_print if page.layout.printed else _sections_on_screen)(page, low, high, count)


def print_height(layout: theme.Layout, count: int) -> float:
    """Return the height in print of `count` flanks, inches."""
    return count * PRINT_BLOCK_HEIGHT_IN if layout.width > theme.NARROW else PRINT_COLUMN_HEIGHT_IN
