"""Matplotlib charts as SVG elements of the page, with its colours, fonts and unique ids."""

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

from ..rendering import theme

WIDTH_PX = 352
"""Width of a chart, pixels; one pixel is one point of Matplotlib. A page of 390 pixels less margins has this
width, so that text is not reduced."""


@contextmanager
def chart_style() -> Iterator[None]:
    """Set our Matplotlib settings for charts, independent of those of the user."""
    text_px, small_px = 12.0, 11.0
    settings: Any = {
        "axes.labelsize": text_px,
        "axes.labelcolor": theme.GREY,
        "axes.linewidth": 0.8,
        "axes.titlelocation": "left",
        "axes.titlesize": text_px,
        "axes.axisbelow": True,
        "font.size": 13.2,  # corresponds to "small" of Matplotlib
        "grid.linewidth": 0.6,
        "legend.fontsize": small_px,
        "lines.linewidth": 1.8,
        "path.simplify_threshold": 0.1,
        "svg.fonttype": "none",
        "svg.hashsalt": "page",
        "text.parse_math": False,
        "xtick.labelsize": small_px,
        "xtick.labelcolor": theme.GREY,
        "ytick.labelsize": small_px,
        "ytick.labelcolor": theme.GREY,
    }
    with theme.style(), mpl.rc_context(settings):
        yield


def new_chart(height: float) -> Figure:
    """Return an empty chart of a height in pixels, with constrained layout."""
    layout = ConstrainedLayoutEngine(h_pad=4.0 / 72.0, w_pad=4.0 / 72.0)
    return Figure(figsize=(WIDTH_PX / 72.0, height / 72.0), dpi=72.0, layout=layout)


def svg_of(chart: Figure, name: str, title: str) -> str:
    """Return a chart as an SVG element. `name` makes its ids unique, `title` is its text for screen
    readers."""
    # CSS variables of the page that replace the colours of charts.
    variables = {
        "#ffffff": "paper",
        theme.INK: "ink",
        theme.GREY: "muted",
        theme.PALE: "line",
        theme.BLUE: "accent",
        theme.VERMILLION: "path",
        theme.METALS[0]: "pinion",
        theme.METALS[1]: "gear",
    }
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
    body = re.sub(r'href="#|url\(#', lambda match: f"{match[0]}{name}-", body)
    for colour, variable in variables.items():
        body = body.replace(colour, f"var(--{variable})")
    body = re.sub(r"font: ((?:\w+ )*)([\d.]+px) [^;\"]*", _font, body)
    body = re.sub(r'="[^"]*"', lambda match: re.sub(r"-?\d+\.\d{3,}", _short, match[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    label = f'role="img" aria-labelledby="{name}-title"><title id="{name}-title">{escape(title)}</title>'
    return f'<svg class="drawing" {box[0]} {label}{body}'.strip()


def _short(match: re.Match[str]) -> str:
    return f"{float(match[0]):.2f}".rstrip("0").rstrip(".")


def _font(match: re.Match[str]) -> str:
    """Return size and weight of a text for the font of the page."""
    weight = "; font-weight: bold" if "bold" in match[1] or "700" in match[1] else ""
    return f"font-size: {match[2]}{weight}"
