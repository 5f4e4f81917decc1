"""Matplotlib's SVG made part of a page: its colours, its fonts, ids of its own, nothing superfluous."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ..stage import theme

WIDTH = 352
"""Pixels of a chart, a pixel being a point of matplotlib's: no more than a narrow page has, 390 less its
margins, so that letters there are no smaller than here."""
VARIABLES = {
    "#ffffff": "paper",
    theme.INK: "ink",
    theme.GREY: "muted",
    theme.PALE: "line",
    theme.BLUE: "accent",
    theme.RED: "path",
    theme.STEEL: "pinion",
    theme.BRONZE: "gear",
}
"""Colours in which charts are drawn, and the page's variables that stand for them."""
TEXT, SMALL = 12.0, 11.0
LARGE = 13.2
"""Of which matplotlib's "small" is SMALL."""
PAD = 4.0 / 72.0
STYLE: Any = {
    "axes.labelsize": TEXT,
    "axes.labelcolor": theme.GREY,
    "axes.linewidth": 0.8,
    "axes.titlelocation": "left",
    "axes.titlesize": TEXT,
    "axes.axisbelow": True,
    "font.size": LARGE,
    "grid.linewidth": 0.6,
    "legend.fontsize": SMALL,
    "lines.linewidth": 1.8,
    "path.simplify_threshold": 0.1,
    "svg.fonttype": "none",
    "svg.hashsalt": "page",
    "text.parse_math": False,
    "xtick.labelsize": SMALL,
    "xtick.labelcolor": theme.GREY,
    "ytick.labelsize": SMALL,
    "ytick.labelcolor": theme.GREY,
}


@contextmanager
def style() -> Iterator[None]:
    """Hold matplotlib's settings for charts, whatever the user's own are."""
    with theme.style(), mpl.rc_context(STYLE):
        yield


def new_chart(height: float) -> Figure:
    """Make an empty chart of so many pixels, laid out by matplotlib."""
    return Figure(
        figsize=(WIDTH / 72.0, height / 72.0), dpi=72.0, layout=ConstrainedLayoutEngine(h_pad=PAD, w_pad=PAD)
    )


def svg_of(chart: Figure, name: str, title: str) -> str:
    """Give the chart as an element of a page. `name` makes its ids its own, `title` is what it is called to
    those who do not see it."""
    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    chart.savefig(file, format="svg", transparent=True, metadata=nothing)
    text = file.getvalue()
    head, _, body = text[text.index("<svg") :].partition(">")
    box = re.search(r'viewBox="[^"]*"', head)
    assert box is not None
    body = re.sub(r"<metadata>.*?</metadata>|<style[^>]*>.*?</style>|<!--.*?-->", "", body, flags=re.S)
    body = re.sub(r"; font-family: [^;\"]*", "", body).replace("xlink:href", "href")
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = re.sub(r'href="#|url\(#', lambda found: f"{found[0]}{name}-", body)
    for colour, variable in VARIABLES.items():
        body = body.replace(colour, f"var(--{variable})")
    body = re.sub(r"font: ((?:\w+ )*)([\d.]+px) [^;\"]*", _font, body)
    body = re.sub(r'="[^"]*"', lambda found: re.sub(r"-?\d+\.\d{3,}", _short, found[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    label = f'role="img" aria-labelledby="{name}-title"><title id="{name}-title">{escape(title)}</title>'
    return f'<svg class="drawing" {box[0]} {label}{body}'.strip()


def _short(found: re.Match[str]) -> str:
    return f"{float(found[0]):.2f}".rstrip("0").rstrip(".")


def _font(found: re.Match[str]) -> str:
    """Give the size, and weight if there is one, in the page's own font."""
    weight = "; font-weight: bold" if "bold" in found[1] or "700" in found[1] else ""
    return f"font-size: {found[2]}{weight}"
