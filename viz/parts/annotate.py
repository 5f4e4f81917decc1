"""Dimension lines, frames and labels laid over a picture at the pixels of points in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from beveloid_geom.arrays import FloatArray, Mask

from ..stage import theme
from ..stage.scene import Camera, Item, Picture, Scene, render

Offset = tuple[float, float]
"""To the right and up, in points of the page."""
HALO, RIM = 3.0, 1.0
"""Points of white around words, twice, and on either side of lines."""
CENTRE_LINE: dict[str, Any] = {"linewidth": 1.3, "dashes": (12, 3, 2, 3)}
SIDEWAYS = 0.5
"""Sine of the slope from upright beyond which words stand beside an arrow, not over it."""
END_ON = 0.12
"""Share of its length below which an axis is seen end on."""
HEADS = 13.0
"""Points of the page for the two heads of a dimension line."""
GAP, SLASH = 2.0, (2.5, 6.0)
"""Points half across the gap of a break, and how far each of its strokes goes along and across the line."""
CLEAR, NEAR = 3.0, 9.0
"""Points left free around words, and at the end of the line that leads to their place."""
REACHES, TURNS = (1.0, 1.5, 2.2), (0.0, 0.6, -0.6)
"""How far off a place words are looked for, in their usual distance, and turned by how much, rad."""


def text(axes: Axes, pixel: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
    """Write words at a pixel, with a white rim so that they stay readable on metal."""
    settings = {"fontsize": theme.LABEL, "ha": "center", "va": "center", "color": theme.INK, **style}
    halo = [withStroke(linewidth=HALO, foreground="white")]
    theme.beside(axes, pixel, words, offset, path_effects=halo, zorder=5, **settings)


def rim(width: float) -> list[withStroke]:
    """Give a line of a `width` (points) a white rim, so that it is told from metal without colours, too."""
    return [withStroke(linewidth=width + 2.0 * RIM, foreground="white")]


def note(axes: Axes, pixel: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
    """Write words beside a pixel, with a thin line that leads to it."""
    line = {"arrowstyle": "-", "color": style.get("color", theme.INK), "linewidth": 1.0}
    text(axes, pixel, words, offset, arrowprops={**line, "shrinkA": 2, "shrinkB": 1}, **style)


def arrow(
    axes: Axes, tail: ArrayLike, head: ArrayLike, colour: str, width: float = 1.8, ends: str = "-|>"
) -> None:
    """Draw an arrow between two pixels."""
    look = {"arrowstyle": ends, "color": colour, "linewidth": width, "mutation_scale": 7.0 + 5.0 * width}
    look |= {"shrinkA": 0.0, "shrinkB": 0.0, "path_effects": rim(width)}
    start, end = (tuple(np.asarray(pixel, dtype=float)) for pixel in (tail, head))
    axes.annotate("", end, start, annotation_clip=False, zorder=4, arrowprops=look)


def dimension(
    axes: Axes, start: ArrayLike, end: ArrayLike, words: str, offset: Offset, at: float = 0.5, **style: Any
) -> None:
    """Draw a dimension line between two places in the axes with its words beside it, `at` a share of it; its
    arrows stand outside where there is no room for them between."""
    colour = style.get("color", theme.INK)
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(np.subtract(*axes.transData.transform((a, b)))))
    least = HEADS * axes.figure.dpi / 72.0
    if length > least:
        arrow(axes, a, b, colour, 1.2, "<|-|>")
    elif length > 0.0:
        out = 1.5 * least * (b - a) / length
        arrow(axes, a - out, a, colour, 1.2)
        arrow(axes, b + out, b, colour, 1.2)
    text(axes, a + at * (b - a), words, offset, **style)


def arc(centre: ArrayLike, first: ArrayLike, second: ArrayLike, radius: float, count: int = 33) -> FloatArray:
    """Give points (count, 3) of the circle about `centre` from the unit vector `first` to `second`, mm."""
    u, v = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    angle = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
    across = v - (u @ v) * u
    size = np.linalg.norm(across)
    across = across / size if size > 0.0 else across
    turn = np.linspace(0.0, angle, count)[:, None]
    return np.asarray(np.asarray(centre) + radius * (np.cos(turn) * u + np.sin(turn) * across))


@dataclass(frozen=True, eq=False)
class Overlay:
    """What is laid over a picture: axes whose coordinates are its pixels. Points are (3,) in space, mm."""

    axes: Axes
    picture: Picture

    @classmethod
    def drawn(cls, page: theme.Page, box: theme.Box, items: Sequence[Item], camera: Camera) -> Overlay:
        """Draw a scene into a box of the page."""
        picture = render(Scene(items, camera), box.size)
        return cls(theme.show(page, box, picture), picture)

    def label(self, point: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
        """Write words beside a point."""
        text(self.axes, self.picture.project(point), words, offset, **style)

    def note(self, point: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
        """Write words beside a point, with a thin line that leads to it."""
        note(self.axes, self.picture.project(point), words, offset, **style)

    def line(self, *points: ArrayLike, **style: Any) -> None:
        """Draw a polyline over everything else: points (3,), or one array (n, 3) of them."""
        settings = {"color": theme.GREY, "linewidth": 1.2, "zorder": 3, **style}
        pixels = self.picture.project(np.reshape(np.stack([np.asarray(p) for p in points]), (-1, 3)))
        self.axes.plot(*pixels.T, **settings)

    def axis(self, start: ArrayLike, end: ArrayLike, colour: str, at: ArrayLike | None = None) -> None:
        """Draw a centre line, dash-dotted, if need be broken `at` a point."""
        self.line(*(point for point in (start, at, end) if point is not None), color=colour, **CENTRE_LINE)
        if at is not None:
            self.broken(at, end, colour)

    def broken(self, point: ArrayLike, towards: ArrayLike, colour: str) -> None:
        """Mark the line from a point `towards` another as broken there: two strokes across a gap."""
        middle, other = self.picture.project(np.stack([np.asarray(point), np.asarray(towards)]))
        along = (other - middle) / np.linalg.norm(other - middle) * self.axes.figure.dpi / 72.0
        across = along[::-1] * (1.0, -1.0)
        gap = middle + np.array([[-GAP], [GAP]]) * along
        self.axes.plot(*gap.T, color="white", linewidth=2.0 * SLASH[1], solid_capstyle="butt", zorder=4)
        stroke = np.array([[-1.0], [1.0]]) * (SLASH[0] * along + SLASH[1] * across)
        for end in gap:
            self.axes.plot(*(end + stroke).T, color=colour, linewidth=1.2, zorder=4)

    def arrow(self, tail: ArrayLike, head: ArrayLike, colour: str, width: float = 1.8) -> None:
        """Draw an arrow between two points."""
        arrow(self.axes, self.picture.project(tail), self.picture.project(head), colour, width)

    def dimension(self, start: ArrayLike, end: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
        """Draw a dimension line between two points, with words and style as `dimension` takes them."""
        dimension(self.axes, self.picture.project(start), self.picture.project(end), words, offset, **style)

    def angle(
        self,
        foot: ArrayLike,
        first: ArrayLike,
        second: ArrayLike,
        radius: float,
        words: str,
        reach: tuple[float, float],
        offset: Offset,
    ) -> None:
        """Draw the angle at `foot` from the direction `first` (3,) to `second`: an arrow on a circle of a
        radius (mm), and a dashed line along `first`. It ends, and has the words, at the shares `reach` of
        the radius."""
        start, end, beside = np.asarray(foot), *(share * radius * np.asarray(first) for share in reach)
        self.line(start, start + end, color=theme.RED, linestyle="--")
        self.arrow_along(arc(start, first, second, radius), theme.RED)
        style: dict[str, Any] = {"color": theme.RED, "fontsize": theme.HEADING, "ha": "right", "va": "bottom"}
        self.label(start + beside, words, offset, **style)

    def arrow_along(self, points: FloatArray, colour: str, width: float = 1.5) -> None:
        """Draw a curve (n, 3) with an arrow head at its end."""
        self.line(points, color=colour, linewidth=width)
        self.arrow(points[-3], points[-1], colour, width)

    def triad(
        self,
        origin: ArrayLike,
        vectors: ArrayLike,
        length: float,
        names: Sequence[str],
        colour: str,
        title: str = "",
        offset: Offset = (-14.0, -12.0),
    ) -> None:
        """Draw a frame: arrows `length` mm long from `origin` along the rows of `vectors`, with the `names`
        of its axes in mathematical type; one with an empty name is left out. `title` names the frame
        beside its origin, moved by `offset`."""
        start = self.picture.project(origin)
        full = length * self.picture.px_per_mm
        for name, vector in zip(names, np.asarray(vectors, dtype=float), strict=True):
            if not name:
                continue
            tip = self.picture.project(np.asarray(origin) + length * vector)
            way = tip - start
            seen = float(np.linalg.norm(way))
            if seen < END_ON * full:
                away = float(vector @ self.picture.camera.axes[2]) < 0.0
                self.axes.plot(*start, "o", ms=9, mfc="white", mec=colour, mew=1.6, zorder=4)
                self.axes.plot(*start, "x" if away else ".", ms=5, color=colour, mew=1.2, zorder=5)
                text(self.axes, start, f"${name}$", (-13.0, 11.0), color=colour)
                continue
            arrow(self.axes, start, tip, colour, 1.8)
            shift = way / seen * (1.0, -1.0)
            side = "left" if shift[0] > SIDEWAYS else "right" if shift[0] < -SIDEWAYS else "center"
            reach = 5.0 if side != "center" else 12.0
            text(self.axes, tip, f"${name}$", (reach * shift[0], 11.0 * shift[1]), color=colour, ha=side)
        if title:
            bold: dict[str, Any] = {"fontweight": "bold", "fontsize": theme.HEADING}
            text(self.axes, start, f"${title}$", offset, color=colour, **bold)


class Room:
    """Where words stand clear of all that a page shows, and of words put there before."""

    def __init__(self, axes: Axes) -> None:
        """See what is on the page of these axes by now."""
        self.axes, self.point = axes, axes.figure.dpi / 72.0
        canvas: Any = axes.figure.canvas
        canvas.draw()
        self.free: Mask = (np.asarray(canvas.buffer_rgba())[::-1, :, :3] == 255).all(axis=-1)

    def note(self, pixels: FloatArray, middle: ArrayLike, words: str, offset: Offset) -> None:
        """Write words beside one of some pixels (n, 2) of the axes, with a line that leads to it: where both
        are clear, or hide least, near the first of them. There they stand off by an `offset`, elsewhere by
        one turned with the pixel about `middle`."""
        away = (pixels - np.asarray(middle)) * (1.0, -1.0)
        way = away[:, 0] + 1j * away[:, 1]
        usual = complex(*offset) * way / np.abs(way) * abs(way[0]) / way[0]
        number, reach, turn = (
            grid.ravel() for grid in np.meshgrid(np.arange(len(pixels)), REACHES, TURNS, indexing="ij")
        )
        shifts = (usual[number] * reach * np.exp(1j * turn))[:, None].view(float)
        probe = theme.beside(self.axes, pixels[0], words, (0.0, 0.0), fontsize=theme.LABEL)
        half = 0.5 * np.array(probe.get_window_extent().size) / self.point
        probe.remove()
        shifts += half * shifts / np.linalg.norm(shifts, axis=1, keepdims=True)
        ends = self.axes.transData.transform(pixels)[number]
        middles, half = ends + self.point * shifts, self.point * (half + CLEAR)
        hidden = [
            self.hides(_box(at, half)) + int((~self.free[self._line(end, at)]).sum())
            for end, at in zip(ends, middles, strict=True)
        ]
        away_from_first = number / len(pixels) + reach + 0.5 * np.abs(turn)
        best = int(np.argmin(np.array(hidden) + 0.1 * away_from_first))
        self.take(_box(middles[best], half))
        self.free[self._line(ends[best], middles[best])] = False
        right, up = shifts[best].tolist()
        note(self.axes, pixels[number[best]], words, (right, up), multialignment="left")

    def take(self, box: theme.Box) -> None:
        """Keep a box of the page from now on."""
        self._seen(box)[:] = False

    def hides(self, box: theme.Box) -> int:
        """Count the pixels of a box that are not free, or beyond the page."""
        return box.width * box.height - int(self._seen(box).sum())

    def _seen(self, box: theme.Box) -> Mask:
        """Give what of a box is on the page."""
        left, bottom, right, top = (
            max(end, 0) for end in (box.left, box.bottom, box.left + box.width, box.bottom + box.height)
        )
        return self.free[bottom:top, left:right]

    def _line(self, end: FloatArray, start: FloatArray) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Give rows and columns of the pixels of a line, but near its end."""
        length = float(np.linalg.norm(end - start))
        share = np.arange(self.point * NEAR, length, 1.0)[:, None] / length
        column, row = np.rint(end + share * (start - end)).astype(int).T
        height, width = self.free.shape
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)


def _box(middle: FloatArray, half: FloatArray) -> theme.Box:
    """Give a box about a pixel of the page, `half` as wide and high."""
    low, high = (np.rint(middle + side * half).astype(int).tolist() for side in (-1.0, 1.0))
    return theme.Box(low[0], low[1], high[0] - low[0], high[1] - low[1])
