"""One look for all figures: colours, sizes, the page, and where pictures stand on it.

A page measures 16 x 12 inches at 1600 x 1200 pixels and is scaled as a whole at any other
size, so that a small page has the layout of a large one; in print it is laid out anew (`layout`).
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from numpy.typing import ArrayLike

from .layout import ROOM, Cells as Cells, Layout as Layout
from .scene import Picture, Size

# Okabe and Ito's palette: told apart by colour-blind readers and by lightness in print.
BLACK = "#1a1a1a"
ORANGE = "#e69f00"
SKY = "#56b4e9"
GREEN = "#009e73"
BLUE = "#0072b2"
RED = "#d55e00"
GREY = "#6b6b6b"
PALE = "#d9d9d9"

STEEL = "#b9c4cf"
"""The pinion's metal."""
BRONZE = "#d3c3a6"
"""The gear's metal."""
METALS = (STEEL, BRONZE)
INK = BLACK
PATH = RED
MINUS, ZERO, PLUS = BLUE, BLACK, RED
"""An error at its negative value, at zero, and at its positive value."""

# Text sizes in points on a page 16 inches wide.
TITLE = 22.0
SUBTITLE = 15.0
HEADING = 15.0
LABEL = 13.0
SMALL = 11.5

GREEK = {"alpha": "\u03b1", "beta": "\u03b2", "gamma": "\u03b3", "delta": "\u03b4"}
GREEK |= {"varphi": "\u03c6", "pi": "\u03c0"}
RAISED = str.maketrans("\u2212123", "\u207b\u00b9\u00b2\u00b3")
"""Letters of formulas where these are spelled in words."""
MARGIN, WORDS = 0.4, 0.85  # inches: around a page, and what title and subtitle take
AROUND = 1.0
"""Inches over and under a page whose height is not known yet; what is left of them is cut off."""
STYLE = {
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.labelsize": LABEL,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": HEADING,
    "font.family": "DejaVu Sans",
    "font.size": LABEL,
    "grid.color": PALE,
    "grid.linewidth": 0.8,
    "legend.fontsize": LABEL,
    "legend.frameon": False,
    "lines.linewidth": 2.5,
    "mathtext.default": "regular",
    "mathtext.fontset": "dejavusans",
    "pdf.fonttype": 42,  # TrueType: journals refuse Type 3
    "text.color": INK,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "xtick.labelsize": LABEL,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
    "ytick.labelsize": LABEL,
}


def style() -> AbstractContextManager[None]:
    """Hold matplotlib's settings for our figures, whatever the user's own are; use it in a `with`."""
    settings: dict[str, Any] = {str(name): value for name, value in mpl.rcParamsDefault.items()}
    del settings["backend"]
    return mpl.rc_context(cast("Any", {**settings, **STYLE}))


@dataclass(frozen=True)
class Box:
    """A rectangle of whole pixels on a page: left, bottom, width, height."""

    left: int
    bottom: int
    width: int
    height: int

    @property
    def size(self) -> Size:
        """Width and height in pixels, for `scene.render`."""
        return self.width, self.height


class Entries(NamedTuple):
    """A legend of a page: its entries, and how many columns and which look it has where it has room."""

    handles: Sequence[Artist]
    columns: int
    style: dict[str, Any]


class Page(Figure):
    """Matplotlib's figure, with its `layout`, what is said of it, and in print the legends to come."""

    def __init__(self, layout: Layout, height: float, title: str, subtitle: str, note: str) -> None:
        """Make a white page so many inches high, with nothing on it."""
        super().__init__(figsize=(layout.width, height), dpi=layout.dpi, facecolor="white")
        FigureCanvasAgg(self)
        self.layout, self.title, self.subtitle, self.note = layout, title, subtitle, note
        self.legend_entries: list[Entries] = []


def new_page(
    layout: Layout,
    title: str,
    subtitle: str,
    note: str,
    below: float = 0.0,
    above: float = 0.0,
    columns: int = 158,
    tall: float = 8.0,
) -> tuple[Page, float, float]:
    """Make a white page with a title and a subtitle at the top left, and a note in lines of `columns`
    characters at the foot; on a smaller page all text is larger in pixels. Give with it where the room
    between them begins and ends, shares of its height, less inches `below` and `above`. Where the page is
    as high as its figure needs, that room is `tall` inches, and the words come last (`typeset.settle`)."""
    if layout.height is None:
        pixels = round((below + tall + above + 2.0 * AROUND) * layout.dpi)
        page = Page(layout, (pixels + 1e-6) / layout.dpi, title, subtitle, note)
        return page, inches(page, below + AROUND), 1.0 - inches(page, above + AROUND)
    page = Page(layout, layout.height, title, subtitle, note)
    if not layout.plain:
        x, y = MARGIN / page.get_figwidth(), 1.0 - MARGIN / page.get_figheight()
        heading = page.text(x, y, title, fontsize=TITLE, fontweight="bold", va="top", ha="left")
        width = layout.width * layout.dpi
        heading.set_fontsize(TITLE * min(1.0, (1.0 - 2.0 * x) * width / heading.get_window_extent().width))
        y -= 0.42 / page.get_figheight()
        page.text(x, y, subtitle, fontsize=SUBTITLE, color=GREY, va="top", ha="left", linespacing=1.35)
    low = caption(page, note, columns) + inches(page, below)
    return page, low, top(page) - inches(page, above)


def rows(low: float, high: float, count: int, gap: float = 0.0) -> tuple[list[float], float]:
    """Split the room between two heights of a page into rows `gap` apart: where each begins, the upper one
    first, and how high they are, all shares of the page."""
    height = (high - low - gap * (count - 1)) / count
    return [high - height - row * (height + gap) for row in range(count)], height


def panels(page: Page, cells: Cells, count: int, low: float, high: float) -> list[Axes]:
    """Make the axes of so many panels between two heights of the page, row by row."""
    boxes = cells.boxes(page.layout, count, page.get_figheight(), low, high)
    return [page.add_axes(box) for box in boxes]


NARROW = 9.0
"""Inches of a page under which panels stand one under another."""


def stacked(layout: Layout, tall: float) -> float:
    """Give the inches in print that two panels take, `tall` beside each other."""
    return tall if layout.width > NARROW else min(2.0 * tall, ROOM)


def pair_of_boxes(
    page: Page, low: float, high: float, places: Sequence[tuple[float, float]], over: float
) -> list[tuple[float, float, float, float]]:
    """Give left, bottom, width and height of two panels, shares of the page: side by side, from a share of
    its width and as wide as `places` say, or one under another where it is narrow; `over` inches over each
    are left for its name."""
    if page.layout.width > NARROW:
        return [(left, low, width, high - low) for left, width in places]
    bottoms, height = rows(low, high, 2, inches(page, over))
    return [(0.01, bottom, 0.98, height) for bottom in bottoms]


def top(page: Page) -> float:
    """Give the height, as a share of the page, below title and subtitle, if it has them."""
    return float(1.0 - (MARGIN + (0.0 if page.layout.plain else WORDS)) / page.get_figheight())


def inches(page: Page, length: float) -> float:
    """Give a length in inches of a page 12 inches high as a share of this page's height."""
    return float(length / page.get_figheight())


def caption(page: Page, text: str, columns: int = 158) -> float:
    """Write small text at the foot of the page, broken into lines of so many characters, where it is not to
    come at the end or not at all; the height, as a share of the page, above it."""
    page.note = text
    if page.layout.plain or page.layout.printed:
        return inches(page, 0.6 * MARGIN)
    lines = textwrap.wrap(text, columns)
    x, y = MARGIN / page.get_figwidth(), inches(page, 0.6 * MARGIN)
    page.text(x, y, "\n".join(lines), fontsize=SMALL, color=GREY, va="bottom", ha="left", linespacing=1.35)
    return inches(page, 0.6 * MARGIN + 0.22 * len(lines) + 0.15)


def fill(text: Text, words: str, width: float) -> None:
    """Write words broken into lines that are at most so many pixels wide; breaks that are there stay."""
    text.set_text(words)
    seen = text.get_window_extent().width
    if seen <= width:
        return
    longest = max(len(line) for line in words.splitlines())
    for columns in range(min(longest, int(1.3 * longest * width / seen) + 1), 6, -1):
        lines = (textwrap.fill(line, columns, break_long_words=False) for line in words.splitlines())
        text.set_text("\n".join(lines))
        if text.get_window_extent().width <= width:
            return


def say(axes: Axes, words: str, columns: int = 36, height: float = 0.5, **style: Any) -> None:
    """Write words, broken into lines of so many characters, over the middle of axes at a share of their
    height: what is to be said in place of a drawing."""
    settings = {"ha": "center", "va": "center", "transform": axes.transAxes, **style}
    axes.text(0.5, height, textwrap.fill(words, columns), **settings)


def legend(
    page: Page, handles: Sequence[Artist], columns: int, below: float = 0.75, left: float = 0.0, **style: Any
) -> None:
    """Put a legend at the right of a page, `below` its upper edge by so many inches; or at its left, from a
    share of its width; or where the `style` says (`loc`, `bbox_to_anchor`). In print it comes over the
    figure, in as many of its columns as have room."""
    below -= 0.5 * WORDS if page.layout.plain else 0.0
    corner, loc = (left or 0.985, 1.0 - inches(page, below)), "upper left" if left else "upper right"
    style = {"loc": loc, "bbox_to_anchor": corner, "borderaxespad": 0.0, **style}
    if page.layout.printed:
        page.legend_entries.append(Entries(handles, columns, style))
    else:
        page.legend(handles=handles, ncols=columns, **style)


def spelled(words: str) -> str:
    """Give words with TeX's formulas in plain letters: $a_1$ as a1."""
    words = re.sub(r"\\([a-z]+)", lambda found: GREEK.get(found[1], found[1]), words)
    words = re.sub(r"\^\{?(\u2212?\d)\}?", lambda found: found[1].translate(RAISED), words)
    return re.sub(r"[$_{}]", "", words)


def signed(value: float, digits: int) -> str:
    """Give a number with its sign, a true minus, and none if it rounds to zero."""
    sign = "+" if round(value, digits) else ""
    return f"{round(value, digits) + 0.0:{sign}.{digits}f}".replace("-", "\u2212")


def beside(axes: Axes, at: ArrayLike, words: str, offset: tuple[float, float], **style: Any) -> Annotation:
    """Write words beside a place (2,) of the axes, moved to the right and up by points of the page."""
    place: Any = tuple(np.asarray(at, dtype=float))
    settings = {"textcoords": "offset points", "annotation_clip": False, **style}
    return axes.annotate(words, place, offset, **settings)


def place(page: Page, left: float, bottom: float, width: float, height: float) -> Box:
    """Find the box of whole pixels nearest to these shares of the page."""
    page_width, page_height = page.canvas.get_width_height()
    x0, x1 = (round(edge * page_width) for edge in (left, left + width))
    y0, y1 = (round(edge * page_height) for edge in (bottom, bottom + height))
    return Box(x0, y0, max(1, x1 - x0), max(1, y1 - y0))


def show(page: Page, box: Box, picture: Picture) -> Axes:
    """Put a picture, rendered at `box.size`, into its box.

    The axes have the picture's pixels as coordinates, from the top left, as `Picture.project`
    gives them. Pixels are copied one to one."""
    below, axes = overlay(page, box), overlay(page, box)
    below.imshow(picture.image, interpolation="nearest", aspect="auto", extent=(0, box.width, box.height, 0))
    below.set_zorder(-1.0)  # no picture covers the text of another
    return axes


def overlay(page: Page, box: Box) -> Axes:
    """Make bare axes over a box, in its pixels from the top left: for text, arrows and scale bars."""
    page_width, page_height = page.canvas.get_width_height()
    axes = page.add_axes(
        (box.left / page_width, box.bottom / page_height, box.width / page_width, box.height / page_height)
    )
    axes.set_axis_off()
    axes.set_xlim(0, box.width)
    axes.set_ylim(box.height, 0)
    axes.patch.set_alpha(0.0)
    return axes


def scale_bar(axes: Axes, x: float, y: float, px_per_mm: float, length_mm: float, colour: str = INK) -> None:
    """Draw a bar `length_mm` long, starting at pixel (x, y), with its length written below."""
    end = x + length_mm * px_per_mm
    axes.plot([x, end], [y, y], color=colour, linewidth=3.0, solid_capstyle="butt", clip_on=False)
    middle = (x + end) / 2.0, y
    beside(axes, middle, f"{length_mm:g} mm", (0, -4), ha="center", va="top", fontsize=SMALL, color=colour)


def round_length(length: float) -> float:
    """Give the largest of 1, 2, 5, 10, 20, ... that is not longer: for scale bars."""
    decade: float = 10.0 ** int(f"{length:e}".split("e")[1])
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= length * (1.0 + 1e-9))
