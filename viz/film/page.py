"""The pages of a film: all that stands still is drawn once, and what moves over it in every frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from beveloid_geom.report.columns import ARCSEC

from ..parts import annotate, charts, panels, viewpoint
from ..parts.panels import Panel, Trace
from ..parts.solved import MEMBERS
from ..stage import theme
from ..stage.layout import of_size
from ..stage.scene import Picture, Size
from ..stage.theme import Box, Page
from . import zone
from .motion import FILM, Film, Motion

Image = NDArray[np.uint8]
PAGE_INCHES = (10.5, 7.875)
"""So that the smallest letters are 14 pixels high where the page is 960 wide."""
SIDE, END = 0.6, 0.965
"""Shares of the page's width at which flanks and curve begin and end."""
FLANKS = 0.53
"""Share of the page's height at which the flanks begin."""
LONGEST = 40
"""Characters of a design's name; of a longer one the middle is left out."""
BALL = theme.BLUE
NOTE = (
    "The gear stands where the first of all teeth, edges included, stops it on the driving side: rigid, no"
    " load. Seen from the {end}s, the gear as if of glass; flanks square on, {how}, twice as large across as"
    " along. Lines: paths of contact. Full balls: contacts; hollow: within {film:g} \u00b5m."
)
EDGES = " Red in the curve: an edge carries."
LINES = " Black lines: of those along which flanks touch; a ball is at an end of one."
ROWS = ("pinion roll", "transmission error", "pairs in contact", "carried by")
COLUMNS = 118
"""Characters in a line of the note."""


@dataclass(frozen=True, eq=False)
class Moving:
    """What is redrawn in every frame, in this order, over the picture of the teeth: the paths on them,
    faint and strong, words, balls (full, hollow) over the teeth and over each flank, the marker on the
    curve, and the numbers."""

    paths: tuple[Line2D, Line2D]
    words: tuple[Text, ...]
    balls: tuple[tuple[Line2D, Line2D], ...]
    marker: Line2D
    numbers: tuple[Text, ...]

    @property
    def artists(self) -> Iterator[Artist]:
        """All of them."""
        return chain(self.paths, self.words, chain(*self.balls), (self.marker,), self.numbers)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The page with all that stands still, the box of the teeth, and the views and pictures of the
    flanks, None where there is none to draw."""

    page: Page
    box: Box
    flanks: list[Panel | None]
    moving: Moving


def frames(film: Film, size: Size, pitches: int = 1) -> Iterator[Image]:
    """Draw the frames (height, width, 3) of a film over some pitches; one more would be the first again.
    Raises NoFilmError for teeth that cannot be made."""
    with theme.style():
        sheet = sheet_of(film, size, pitches)
        canvas: Any = sheet.page.canvas
        canvas.draw()
        still = canvas.copy_from_bbox(sheet.page.bbox)
    pixels, box = np.asarray(canvas.buffer_rgba()), sheet.box  # a view of the canvas
    rows = slice(size[1] - box.bottom - box.height, size[1] - box.bottom)
    columns = slice(box.left, box.left + box.width)
    for pitch in range(pitches):
        for step, picture in enumerate(zone.pictures(film, sheet.box.size)):
            with theme.style():
                _move(sheet, film, picture, step, pitch)
                canvas.restore_region(still)
                pixels[rows, columns, :3] = picture.image
                for artist in sheet.moving.artists:
                    sheet.page.draw_artist(artist)
            yield pixels[..., :3].copy()


def sheet_of(film: Film, size: Size, pitches: int) -> Sheet:
    """Make everything that stands still, and the artists of what moves, none of them placed yet."""
    flank = film.motion.flank
    ratios = f"{film.path.ratio:.3f} by Eq. 16"
    if np.isfinite(film.cycle.operating):
        ratios += f", {film.cycle.operating:.3f} in operation"
    design = film.motion.design
    errors = " with errors" if any(map(float, vars(design.errors).values())) else ""
    one, other = (f"{float(member.tool.parabola):g}".replace("-", "\u2212") for member in design.members)
    bends = "No parabolas" if (one, other) == ("0", "0") else f"Parabolas {one} and {other} mm\u207b\u00b9"
    how = "through the tooth" if flank == "right" else "from outside"
    end = "heel" if zone.looks_from(film)[2] > 0.0 else "toe"
    note = NOTE.format(how=how, end=end, film=1e3 * FILM)
    page, low, high = theme.new_page(
        of_size(size, inches=PAGE_INCHES),
        f"{_name_words(film.cycle.name)}{errors}: {flank} flanks in mesh",
        f"{bends}; contact ratio {ratios}",
        note + (EDGES if film.cycle.cycle.edge_share > 0.0 else LINES if film.cycle.along_lines else ""),
        columns=COLUMNS,
    )
    box = theme.place(page, 0.03, low, SIDE - 0.06, high - low)
    axes = theme.overlay(page, box)
    flanks, balls = _flanks(page, film, high)
    marker = _curve(page, film, low, pitches)
    style: dict[str, Any] = {"color": theme.PATH, "animated": True}
    faint, strong = (axes.plot([], [], lw=lw, alpha=a, **style)[0] for lw, a in ((1.6, 0.4), (3.2, 1.0)))
    own = _balls(axes, clipped=True)
    moving = Moving((faint, strong), _words(axes, box), (own, *balls), marker, _numbers(page))
    return Sheet(page, box, flanks, moving)


def _name_words(name: str) -> str:
    """Give the name of a design as it is read, no longer than LONGEST and no formula."""
    shown = name or "design"
    if len(shown) > LONGEST:
        half = (LONGEST - 1) // 2
        shown = f"{shown[:half]}\u2026{shown[-half:]}"
    return shown.replace("$", r"\$")


def _balls(axes: Axes, clipped: bool = False) -> tuple[Line2D, Line2D]:
    """Make full and hollow balls, none yet."""
    full, hollow = (
        axes.plot([], [], "o", ms=11.0, mfc=face, mec=edge, mew=1.6, animated=True, clip_on=clipped)[0]
        for face, edge in ((BALL, "white"), ("white", BALL))
    )
    return full, hollow


def _words(axes: Axes, box: Box) -> tuple[Text, ...]:
    """Write the names of the members over their picture."""
    for name, y in (("gear", 0.05), ("pinion", 0.95)):
        annotate.text(axes, (0.5 * box.width, y * box.height), name, fontsize=theme.HEADING)
    for text in axes.texts:
        text.set_animated(True)
    return tuple(axes.texts)


def _flanks(page: Page, film: Film, high: float) -> tuple[list[Panel | None], list[tuple[Line2D, Line2D]]]:
    """Draw both flanks with their path, and the balls on them."""
    design, flank = film.motion.design, film.motion.flank
    views = viewpoint.flank_views(design, flank, panels.STRETCH)
    span = viewpoint.greatest_span(views)
    width, height = page.canvas.get_width_height()
    step, bottom = 0.5 * (END - SIDE), FLANKS + theme.inches(page, 0.35)
    top = high - theme.inches(page, 0.6)
    px_per_mm = min((top - bottom) * height / span[1], 0.74 * step * width / span[0])
    found, balls = [], []
    for row, view in enumerate(views):
        left = SIDE + row * step
        page.text(left + 0.5 * step, high, f"{MEMBERS[row]}'s flank", ha="center", va="top")
        edge = theme.inches(page, 0.3)
        box = theme.place(page, left, bottom - edge, step, top - bottom + 2.0 * edge)
        traces = [Trace(film.path.points[row], width=0.6)]
        drawn = panels.draw_flank(page, box, design, row, flank, view, traces, float(px_per_mm))
        if drawn:
            panels.draw_lines(drawn, film.path, row)
        found.append(drawn)
        balls.append(_balls(drawn.axes if drawn else theme.overlay(page, box)))
    return found, balls


def _curve(page: Page, film: Film, low: float, pitches: int) -> Line2D:
    """Draw the transmission error over all pitches, and a marker for it."""
    bottom = low + theme.inches(page, 0.6)
    top = FLANKS - theme.inches(page, 1.2)
    axes = page.add_axes((SIDE + 0.085, bottom, END - SIDE - 0.085, top - bottom))
    charts.error_over_rolls(axes, film.cycle, pitches)
    axes.tick_params(labelsize=theme.SMALL)
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_fontsize(theme.SMALL)
    return _balls(axes)[0]


def _numbers(page: Page) -> tuple[Text, ...]:
    """Write the names of the numbers, and where they are written."""
    texts = []
    for row, name in enumerate(ROWS):
        y = FLANKS - theme.inches(page, 0.1 + 0.235 * row)
        page.text(SIDE, y, name, fontsize=theme.SMALL, color=theme.GREY, va="top")
        texts.append(page.text(SIDE + 0.17, y, "", fontsize=theme.SMALL, va="top", animated=True))
    return tuple(texts)


def _move(sheet: Sheet, film: Film, picture: Picture, step: int, pitch: int) -> None:
    """Put what moves where it is at a step of the motion."""
    motion, moving = film.motion, sheet.moving
    touching, near = motion.touching[:, step], motion.near[:, step]
    paths = picture.project(zone.paths_on_teeth(film, step))
    paths = np.pad(paths, ((0, 0), (1, 0), (0, 0)), constant_values=np.nan)  # a gap before each
    for line, shown in zip(moving.paths, (~near, near), strict=True):
        line.set_data(*paths[shown].reshape(-1, 2).T)
    seen = [picture.project(motion.point[:, step])]
    for row, flank in enumerate(sheet.flanks):
        points = motion.own[row, :, step]
        seen.append(points[:, :2] * np.nan if flank is None else flank.place(points))
    for pixels, balls in zip(seen, moving.balls, strict=True):
        for ball, shown in zip(balls, (touching, near & ~touching), strict=True):
            ball.set_data(*pixels[shown].T)
    moving.marker.set_data([motion.share[step] + pitch], [ARCSEC * motion.error[step]])
    for text, words in zip(moving.numbers, _readings(motion, step, pitch), strict=True):
        text.set_text(words)


def _readings(motion: Motion, step: int, pitch: int) -> tuple[str, ...]:
    """Give the numbers of a step: roll, error, pairs in contact, and what carries."""
    share = motion.share[step] + pitch
    turn = 360.0 / float(motion.design.pinion.teeth) * share
    touching, near = int(motion.touching[:, step].sum()), int(motion.near[:, step].sum())
    return (
        f"{turn:.2f}\u00b0  ({share:.3f} pitches)",
        f"{theme.signed(ARCSEC * motion.error[step], 2)} arcsec",
        f"{touching}" + (f"  ({near} within {1e3 * FILM:g} \u00b5m)" if near > touching else ""),
        motion.carriers[step],
    )
