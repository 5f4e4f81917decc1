"""What finer meshes cost the pictures of the figures, and where they stop being seen.

Here drawing is what is measured. So `compute` draws: scenes of other figures, at fixed sizes and a row
of mesh tolerances, each compared with the picture of a much finer mesh (module `density`). `draw`
charts what was found and shows the pictures' worst places; it renders nothing.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator

from beveloid_geom.design.model import Design

from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.scene import Size
from ...stage.theme import Page
from . import picture_differences as density
from .picture_differences import NOTICEABLE, Series, Shot

COLOURS = (theme.BLUE, theme.RED, theme.GREEN)
DRAWN = "drawn"
FLOOR = 1e-6
"""Share of pixels drawn in place of none."""
SHORT = 2.0
"""Decades up to which an axis is short."""
NOTE = (
    f"A difference is just noticeable at {NOTICEABLE} of 255 levels. (a) is its mean over the pixels on"
    f" outlines, or over those beside them, in the worst window of {density.WINDOW} \u00d7 {density.WINDOW}"
    " pixels; single pixels on an outline change whenever one sample of the anti-aliasing changes sides, by"
    " up to {single:.0f} levels at the finest tolerance in (a). A tolerance suffices if (a) stays below what"
    " is noticed from there on. Triangles are those of all that is drawn, shafts and the path included. "
)


def compute(design: Design) -> tuple[Series, ...]:
    """Every picture at every tolerance, compared with the finest."""
    found = []
    for name, (view_of, size) in density.VIEWS.items():
        try:
            found.append(density.measure(name, view_of(design, size)))
        except ValueError as error:
            found.append(Series(name, reason=str(error)))
    return tuple(found)


def draw(data: tuple[Series, ...], size: Size) -> Drawing:
    """Three charts over the tolerance, and below them the worst place of each picture."""
    width, height = density.PAGE
    page = theme.new_page(
        size,
        "Where a finer mesh stops being seen",
        f"Pictures as on a page of {width} \u00d7 {height} pixels, against those of the finest mesh,"
        f" {1.0 / density.FINER:g} times as fine as the next; stars: the figures' defaults",
    )
    found = [(series, colour) for series, colour in zip(data, COLOURS, strict=True) if series.shots]
    single = max((series.shots[-2].difference.greatest for series, _ in found), default=0.0)
    text = NOTE.format(single=single) + " ".join(finding(series) for series, _ in found)
    low = theme.caption(page, text if found else "No picture could be drawn.", 184)
    crops = theme.inches(page, 2.6)
    _crops(page, data, low + theme.inches(page, 0.75), crops)
    bottom = low + crops + theme.inches(page, 0.75 + 1.2)
    high = theme.top(page) - theme.inches(page, 0.45) - bottom
    charts = (_worst, _shares, _seconds)
    for column, chart in enumerate(charts):
        axes = page.add_axes((0.06 + 0.325 * column, bottom, 0.26, high))
        axes.set(xscale="log", yscale="log", xlabel="tolerance (pixels), finer to the right")
        chart(axes, found)
        _ticks(axes)
        axes.invert_xaxis()
        axes.grid(True)
    return Drawing(page, {})


def _ticks(axes: Axes) -> None:
    """Plain numbers at powers of ten; on a short axis at twice and five times these, too."""
    axes.minorticks_off()
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        steps = (1.0,) if abs(np.log10(high / low)) > SHORT else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=steps, numticks=20))
        axis.set_major_formatter(
            FuncFormatter(lambda value, _: np.format_float_positional(value, 6, trim="-"))
        )


def _curve(axes: Axes, series: Series, colour: str, values: list[float], style: str = "-") -> None:
    """Values of all shots but the finest, with the figure's own tolerance marked."""
    pixels = [shot.pixels for shot in series.shots[: len(values)]]
    axes.plot(pixels, values, style, color=colour, marker="o", ms=5.0)
    own = series.default
    axes.plot(pixels[own], values[own], "*", color=colour, ms=20.0, mec="white", mew=1.2, zorder=5)


def _worst(axes: Axes, found: list[tuple[Series, str]]) -> None:
    axes.set_title("(a)  difference in the worst place", loc="left", pad=10.0)
    axes.set_ylabel("mean difference (levels of 255)")
    for series, colour in found:
        _curve(axes, series, colour, [shot.difference.worst_place for shot in series.shots[:-1]])
    axes.set_ylim(bottom=min(axes.get_ylim()[0], NOTICEABLE / 6.0))  # room for the legend
    handles = [Line2D([], [], color=colour, label=series.name.split(" (")[0]) for series, colour in found]
    axes.legend(handles=handles, loc="lower left", fontsize=theme.SMALL)
    axes.axhline(NOTICEABLE, color=theme.GREY, linewidth=1.5, linestyle="--")
    style: dict[str, Any] = {"fontsize": theme.SMALL, "color": theme.GREY, "ha": "left", "va": "top"}
    axes.text(0.02, NOTICEABLE * 0.95, "just noticeable", transform=axes.get_yaxis_transform(), **style)


def _shares(axes: Axes, found: list[tuple[Series, str]]) -> None:
    axes.set_title("(b)  pixels that differ", loc="left", pad=10.0)
    axes.set_ylabel("share of the picture (%)")
    for series, colour in found:
        shots = series.shots[:-1]
        _curve(axes, series, colour, _percent([shot.difference.noticeable_share for shot in shots]))
        _curve(axes, series, colour, _percent([shot.difference.differing_share for shot in shots]), ":")
    _lines(axes, ("at all", ":"), ("noticeably", "-"))


def _percent(shares: list[float]) -> list[float]:
    return [100.0 * max(share, FLOOR) for share in shares]


def _seconds(axes: Axes, found: list[tuple[Series, str]]) -> None:
    axes.set_title("(c)  time", loc="left", pad=10.0)
    axes.set_ylabel("seconds")
    for series, colour in found:
        _curve(axes, series, colour, [shot.rendering for shot in series.shots])
        _curve(axes, series, colour, [shot.sampling for shot in series.shots], ":")
    _lines(axes, ("to render", "-"), ("to sample", ":"))


def _lines(axes: Axes, *named: tuple[str, Any]) -> None:
    """What solid and dotted lines are, below all curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(low * (low / high) ** 0.2, high)
    handles = [Line2D([], [], color=theme.GREY, linestyle=style, label=name) for name, style in named]
    axes.legend(handles=handles, loc="lower left", fontsize=theme.SMALL)


def _crops(page: Page, data: tuple[Series, ...], bottom: float, height: float) -> None:
    """For every picture its worst place: coarsest, at its own tolerance, finest; or the reason."""
    for column, (series, colour) in enumerate(zip(data, COLOURS, strict=True)):
        left = 0.03 + 0.325 * column
        heading = bottom + height + theme.inches(page, 0.12)
        page.text(left, heading, series.name, color=colour, fontsize=theme.HEADING, fontweight="bold")
        if not series.shots:
            words = textwrap.fill(f"not drawn: {series.reason}", 44)
            page.text(left, bottom + height, words, va="top", fontsize=theme.LABEL)
            continue
        shown = (series.shots[0], series.shots[series.default], series.shots[-1])
        for place, (shot, what) in enumerate(zip(shown, ("coarsest", "default", "finest"), strict=True)):
            rows, columns = shot.crop.shape[:2]
            width = height * columns / rows * page.get_figheight() / page.get_figwidth()
            axes = page.add_axes((left + place * 0.1, bottom, min(width, 0.095), height), anchor="NW")
            axes.imshow(shot.crop, interpolation="nearest")
            axes.set(xticks=[], yticks=[])
            for spine in axes.spines.values():
                spine.set(visible=True, color=theme.PALE)
            words = f"{what}, {shot.pixels:.2g} px\n{shot.tolerance:.2g} mm\n{shot.triangles:,} triangles"
            axes.text(
                0.0, -0.03, words, transform=axes.transAxes, va="top", fontsize=theme.SMALL, linespacing=1.3
            )


def unseen_from(series: Series) -> Shot | None:
    """The coarsest shot from which on no place differs noticeably; None if even the last does."""
    for number, shot in enumerate(series.shots[:-1]):
        if all(later.difference.worst_place <= NOTICEABLE for later in series.shots[number:]):
            return shot
    return None


def finding(series: Series) -> str:
    """What the charts show of one picture, in numbers of this run."""
    own, limit = series.shots[series.default], unseen_from(series)
    coarse, own_time, fine = (shot.seconds for shot in (series.shots[0], own, series.shots[-1]))
    found = own.difference
    text = (
        f"{series.name[0].upper()}{series.name[1:]}: at the default, {own.pixels:.2g} pixels, the worst"
        f" window differs by {found.worst_place:.1f} levels, {found.noticeable_share:.2%} of the pixels"
        f" noticeably, in {own_time:.2f}\u00a0s (coarsest {coarse:.2f}\u00a0s, finest {fine:.2f}\u00a0s); "
    )
    if limit is None:
        return text + "no tolerance in (a) suffices."
    if limit is own:
        return text + "it suffices, and no coarser one in (a) does."
    if limit.pixels > own.pixels:
        return text + f"it suffices, as does {limit.pixels:.2g} pixels."
    return text + f"it is too coarse, {limit.pixels:.2g} pixels suffice ({limit.seconds:.2f}\u00a0s)."


def rows(data: tuple[Series, ...]) -> Table:
    """Every picture at every tolerance; the last of each is the one compared with. A picture that could
    not be drawn has one row, with the reason as its status."""
    size = ("picture", "tolerance_mm", "tolerance_px", "triangles", "sampling_seconds", "render_seconds")
    difference = ("differing_share", "greatest_difference", "mean_difference")
    header = (*size, *difference, "noticeable_share", "worst_place_difference", "status")

    def body() -> Iterator[list[object]]:
        for series in data:
            if not series.shots:
                yield [series.name, *[float("nan")] * (len(header) - 2), series.reason]
            for shot in series.shots:
                seconds = [shot.sampling, shot.rendering]
                found = shot.difference
                values = [found.differing_share, found.greatest, found.mean]
                more = [found.noticeable_share, found.worst_place]
                yield [
                    series.name,
                    shot.tolerance,
                    shot.pixels,
                    shot.triangles,
                    *seconds,
                    *values,
                    *more,
                    DRAWN,
                ]

    return header, body()


RECIPES = {"picture-density": Recipe(compute, draw, rows)}
