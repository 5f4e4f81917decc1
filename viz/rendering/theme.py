"""Common style of all figures: colours, text sizes, pages, and axes over pictures.

A page of 1600 x 1200 pixels measures 16 x 12 inches. Pages of other sizes are scaled, so that all sizes have
the same layout. Pages for print are laid out for their width (`layout`).
"""

from __future__ import annotations

import math
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
from matplotlib.font_manager import findfont, get_font
from matplotlib.text import Annotation, Text
from numpy.typing import ArrayLike

from .layout import MAX_HEIGHT_IN, PageLayout as PageLayout, PanelRows as PanelRows
from .scene import Picture, Size

# Palette of Okabe and Ito: can be distinguished by colour-blind readers and by lightness in print.
INK = "#1a1a1a"
ORANGE = "#e69f00"
GREEN = "#009e73"
BLUE = "#0072b2"
VERMILLION = "#d55e00"  # "orange" in captions
GREY = "#6b6b6b"
PALE = "#d9d9d9"

METALS = ("#b9c4cf", "#d3c3a6")
"""Colours of pinion and gear."""

# Text sizes, points, on a page 16 inches wide.
TITLE = 22.0
HEADING = 15.0
LABEL = 13.0
SMALL = 11.5

MARGIN_IN, TITLE_HEIGHT_IN = 0.4, 0.85  # margin of a page, and height of title and subtitle
UNUSED_SPACE_IN = 1.0
"""Inches above and below a page of unknown height; the unused part is cut off."""
FONT = "DejaVu Sans"
"""Font of all pages; supplied with Matplotlib."""


def style() -> AbstractContextManager[None]:
    """Return a context in which Matplotlib has our settings, independent of those of the user."""
    settings: dict[str, Any] = {str(name): value for name, value in mpl.rcParamsDefault.items()}
    del settings["backend"]
    settings |= {
        "axes.edgecolor": GREY,
        "axes.labelcolor": INK,
        "axes.labelsize": LABEL,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlesize": HEADING,
        "font.family": FONT,
        "font.size": LABEL,
        "grid.color": PALE,
        "grid.linewidth": 0.8,
        "legend.fontsize": LABEL,
        "legend.frameon": False,
        "lines.linewidth": 2.5,
        "mathtext.default": "regular",
        "mathtext.fontset": "dejavusans",
        "pdf.fonttype": 42,  # TrueType, because journals reject Type 3 fonts
        "text.color": INK,
        "xtick.color": GREY,
        "xtick.labelcolor": INK,
        "xtick.labelsize": LABEL,
        "ytick.color": GREY,
        "ytick.labelcolor": INK,
        "ytick.labelsize": LABEL,
    }
    return mpl.rc_context(cast("Any", settings))


@dataclass(frozen=True)
class PageBox:
    """Rectangle of whole pixels on a page."""

    left: int
    bottom: int
    width: int
    height: int

    @property
    def size(self) -> Size:
        """Width and height, pixels, for `scene.render`."""
        return self.width, self.height


class Entries(NamedTuple):
    """Legend of a page: entries, largest number of columns, and style."""

    handles: Sequence[Artist]
    columns: int
    style: dict[str, Any]


class Page(Figure):
    """Matplotlib figure with layout, title, subtitle and note; in print also the legends to be placed."""

    def __init__(self, layout: PageLayout, height: float, title: str, subtitle: str, note: str) -> None:
        """Create an empty white page of a height in inches."""
        super().__init__(figsize=(layout.width, height), dpi=layout.dpi, facecolor="white")
        FigureCanvasAgg(self)
        self.layout, self.title, self.subtitle, self.note = layout, title, subtitle, note
        self.legend_entries: list[Entries] = []


def new_page(
    layout: PageLayout,
    title: str,
    subtitle: str,
    note: str,
    below: float = 0.0,
    above: float = 0.0,
    characters: int = 158,
    tall: float = 8.0,
) -> tuple[Page, float, float]:
    """Return a white page with title, subtitle and note, and the limits of the space between them.

    Parameters
    ----------
    layout : PageLayout
        Size of the page.
    title, subtitle, note : str
        Text above and below the figure.
    below, above : float
        Additional space below and above the figure, inches.
    characters : int
        Characters per line of the note.
    tall : float
        Height of the figure, inches, for a page in print. There, `typeset.finish_page` adds the text later.

    Returns
    -------
    page : Page
        Page with its text.
    low, high : float
        Lower and upper limit of the space for the figure, as fractions of the page height.
    """
    if layout.height is None:
        pixels = round((below + tall + above + 2.0 * UNUSED_SPACE_IN) * layout.dpi)
        page = Page(layout, (pixels + 1e-6) / layout.dpi, title, subtitle, note)
        return page, inches(page, below + UNUSED_SPACE_IN), 1.0 - inches(page, above + UNUSED_SPACE_IN)
    page = Page(layout, layout.height, title, subtitle, note)
    if not layout.plain:
        x, y = MARGIN_IN / page.get_figwidth(), 1.0 - MARGIN_IN / page.get_figheight()
        heading = page.text(x, y, title, fontsize=TITLE, fontweight="bold", va="top", ha="left")
        width = layout.width * layout.dpi
        heading.set_fontsize(TITLE * min(1.0, (1.0 - 2.0 * x) * width / heading.get_window_extent().width))
        y -= 0.42 / page.get_figheight()
        page.text(x, y, subtitle, fontsize=15.0, color=GREY, va="top", ha="left", linespacing=1.35)
    low = caption(page, note, characters) + inches(page, below)
    return page, low, top(page) - inches(page, above)


def split_rows(low: float, high: float, count: int, gap: float = 0.0) -> tuple[list[float], float]:
    """Divide the space between two heights into `count` rows. Returns the lower ends, upper row first, and
    the row height. All values are fractions of the page height."""
    height = (high - low - gap * (count - 1)) / count
    return [high - height - row * (height + gap) for row in range(count)], height


def panels(page: Page, cells: PanelRows, count: int, low: float, high: float) -> list[Axes]:
    """Return axes for panels between two heights of the page, row by row.

    Parameters
    ----------
    page : Page
    cells : PanelRows
        Arrangement of the panels.
    count : int
        Number of panels.
    low, high : float
        Lower and upper limit of the panels, as fractions of the page height.

    Returns
    -------
    list of Axes
    """
    boxes = cells.boxes(page.layout, count, page.get_figheight(), low, high)
    return [page.add_axes(box) for box in boxes]


def stacked_height(layout: PageLayout, tall: float) -> float:
    """Return the height of two panels in print, inches; `tall` is their height if placed side by side."""
    return tall if layout.wide else min(2.0 * tall, MAX_HEIGHT_IN)


def pair_of_boxes(
    page: Page, low: float, high: float, places: Sequence[tuple[float, float]], over: float
) -> list[tuple[float, float, float, float]]:
    """Return left, bottom, width and height of two panels, as fractions of the page.

    Parameters
    ----------
    page : Page
        Page. If it is not wide, the panels are placed one above the other.
    low, high : float
        Limits of the space for the panels, as fractions of the page height.
    places : sequence of tuple
        Left end and width of each panel if placed side by side, as fractions of the page width.
    over : float
        Space for the title of each panel, inches.
    """
    if page.layout.wide:
        return [(left, low, width, high - low) for left, width in places]
    bottoms, height = split_rows(low, high, 2, inches(page, over))
    return [(0.01, bottom, 0.98, height) for bottom in bottoms]


def top(page: Page) -> float:
    """Return the height below title and subtitle, as a fraction of the page height."""
    return float(1.0 - (MARGIN_IN + (0.0 if page.layout.plain else TITLE_HEIGHT_IN)) / page.get_figheight())


def inches(page: Page, length: float) -> float:
    """Return a length in inches as a fraction of the page height."""
    return float(length / page.get_figheight())


def caption(page: Page, text: str, characters: int = 158) -> float:
    """Write the note at the foot of the page; return the height above the note, as a fraction of the page.
    Plain pages have no note, and in print the note is written later."""
    page.note = text
    if page.layout.plain or page.layout.printed:
        return inches(page, 0.6 * MARGIN_IN)
    lines = textwrap.wrap(text, characters)
    x, y = MARGIN_IN / page.get_figwidth(), inches(page, 0.6 * MARGIN_IN)
    page.text(x, y, "\n".join(lines), fontsize=SMALL, color=GREY, va="bottom", ha="left", linespacing=1.35)
    return inches(page, 0.6 * MARGIN_IN + 0.22 * len(lines) + 0.15)


def wrap_text(text: Text, words: str, width: float) -> None:
    """Set the text of an artist, with line breaks so that it is at most `width` pixels wide. Existing line
    breaks are kept."""
    text.set_text(words)
    seen = text.get_window_extent().width
    if seen <= width:
        return
    longest = max(len(line) for line in words.splitlines())
    for characters in range(min(longest, int(1.3 * longest * width / seen) + 1), 6, -1):
        lines = (textwrap.fill(line, characters, break_long_words=False) for line in words.splitlines())
        text.set_text("\n".join(lines))
        if text.get_window_extent().width <= width:
            return


def message(axes: Axes, words: str, characters: int = 36, height: float = 0.5, **style: Any) -> None:
    """Write a message in the middle of axes that have nothing to show.

    Parameters
    ----------
    axes : Axes
        Axes for the message.
    words : str
        Message.
    characters : int
        Largest number of characters per line; fewer if the axes are narrow.
    height : float
        Vertical position, as a fraction of the axes.
    **style
        Properties of the text.
    """
    settings = {"ha": "center", "va": "center", "transform": axes.transAxes, **style}
    text = axes.text(0.5, height, textwrap.fill(words, characters), **settings)
    width = 0.98 * axes.get_window_extent().width
    if text.get_window_extent().width > width:
        wrap_text(text, words, width)


def legend(
    page: Page, handles: Sequence[Artist], columns: int, below: float = 0.75, left: float = 0.0, **style: Any
) -> None:
    """Add a legend to a page. In print it is placed above the figure, with as many columns as fit.

    Parameters
    ----------
    page : Page
        Page.
    handles : sequence of Artist
        Entries.
    columns : int
        Largest number of columns.
    below : float
        Distance from the upper edge of the page, inches.
    left : float
        Left end as a fraction of the page width; 0 places the legend at the right edge.
    **style
        Properties of the legend; `loc` and `bbox_to_anchor` override its position.
    """
    below -= 0.5 * TITLE_HEIGHT_IN if page.layout.plain else 0.0
    corner, loc = (left or 0.985, 1.0 - inches(page, below)), "upper left" if left else "upper right"
    style = {"loc": loc, "bbox_to_anchor": corner, "borderaxespad": 0.0, **style}
    if page.layout.printed:
        page.legend_entries.append(Entries(handles, columns, style))
    else:
        page.legend(handles=handles, ncols=columns, **style)


def spelled(words: str) -> str:
    """Return text with TeX formulas in plain characters: $a_1$ becomes a1."""
    raised = str.maketrans(
        "\u22120123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"
    )
    greek = {"alpha": "\u03b1", "beta": "\u03b2", "gamma": "\u03b3", "delta": "\u03b4"}
    greek |= {"varphi": "\u03c6", "pi": "\u03c0"}
    words = re.sub(r"\\([a-z]+)", lambda matched: greek.get(matched[1], matched[1]), words)
    words = re.sub(r"\^(\{\u2212?\d+\}|\d)", lambda matched: matched[1].strip("{}").translate(raised), words)
    return re.sub(r"[$_{}]", "", words)


def in_font(words: str) -> str:
    """Return text with ? in place of characters that are missing in FONT."""
    known = get_font(findfont(FONT)).get_charmap()
    return "".join(letter if ord(letter) in known else "?" for letter in words)


def signed(value: float, digits: int) -> str:
    """Return a number with sign and a typographic minus; without a sign if it rounds to zero."""
    sign = "+" if round(value, digits) else ""
    return f"{round(value, digits) + 0.0:{sign}.{digits}f}".replace("-", "\u2212")


def label_point(
    axes: Axes, at: ArrayLike, words: str, offset: tuple[float, float], **style: Any
) -> Annotation:
    """Write text next to a point (2,) of the axes, with an offset to the right and upwards in points."""
    place: Any = tuple(np.asarray(at, dtype=float))
    settings = {"textcoords": "offset points", "annotation_clip": False, **style}
    return axes.annotate(words, place, offset, **settings)


def place(page: Page, left: float, bottom: float, width: float, height: float) -> PageBox:
    """Return the box of whole pixels nearest to a rectangle given as fractions of the page."""
    page_width, page_height = page.canvas.get_width_height()
    x0, x1 = (round(edge * page_width) for edge in (left, left + width))
    y0, y1 = (round(edge * page_height) for edge in (bottom, bottom + height))
    return PageBox(x0, y0, max(1, x1 - x0), max(1, y1 - y0))


def show_picture(page: Page, box: PageBox, picture: Picture) -> Axes:
    """Place a picture, rendered at `box.size`, into its box, pixel by pixel.

    The returned axes have the pixels of the picture as coordinates, from the upper left corner, as
    `Picture.project` returns them.
    """
    below, axes = overlay(page, box), overlay(page, box)
    below.imshow(picture.image, interpolation="nearest", aspect="auto", extent=(0, box.width, box.height, 0))
    below.set_zorder(-1.0)  # pictures are below the text of all axes
    return axes


def overlay(page: Page, box: PageBox) -> Axes:
    """Return empty axes over a box, with its pixels as coordinates from the upper left corner."""
    page_width, page_height = page.canvas.get_width_height()
    axes = page.add_axes(
        (box.left / page_width, box.bottom / page_height, box.width / page_width, box.height / page_height)
    )
    axes.set_axis_off()
    axes.set_xlim(0, box.width)
    axes.set_ylim(box.height, 0)
    axes.patch.set_alpha(0.0)
    return axes


def scale_bar(axes: Axes, x: float, y: float, px_per_mm: float, length_mm: float) -> None:
    """Draw a scale bar `length_mm` long from pixel (x, y), with its length below."""
    end = x + length_mm * px_per_mm
    axes.plot([x, end], [y, y], color=INK, linewidth=3.0, solid_capstyle="butt", clip_on=False)
    middle = (x + end) / 2.0, y
    label_point(axes, middle, f"{length_mm:g} mm", (0, -4), ha="center", va="top", fontsize=SMALL, color=INK)


def round_length(length: float) -> float:
    """Return the length of a scale bar: the largest number 1, 2 or 5 times a power of ten that does not
    exceed `length`."""
    longest = length * (1.0 + 1e-9)  # rounding must not drop an equal length
    decade = 10.0 ** math.floor(math.log10(longest))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= longest)
