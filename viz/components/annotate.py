"""Dimension lines, coordinate frames and labels over pictures and charts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike

from beveloid_geom.arrays import FloatArray

from ..rendering import theme
from ..rendering.scene import Camera, Item, Picture, Scene, render

Offset = tuple[float, float]
"""Offset to the right and upwards, points."""
UNNAMED = "unnamed"
"""Name of an axis of a frame that has no label."""
CENTRE_LINE: dict[str, Any] = {"linewidth": 1.3, "dashes": (12, 3, 2, 3)}
PATH_ARROW = {"arrowstyle": "-|>,head_width=0.3,head_length=0.6", "shrinkA": 0.0, "shrinkB": 0.0}
"""Style of the arrow head at the end of a path in a chart."""


def text(axes: Axes, pixel: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
    """Write text at a pixel, with a white outline so that it is legible on metal."""
    settings = {"fontsize": theme.LABEL, "ha": "center", "va": "center", "color": theme.INK, **style}
    halo = [withStroke(linewidth=3.0, foreground="white")]
    theme.label_point(axes, pixel, words, offset, path_effects=halo, zorder=5, **settings)


def power_of_ten(value: float) -> str:
    """Return a positive number with one digit and a power of ten as a formula."""
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}\u00b710$^{{{int(exponent)}}}$".replace("-", "\u2212")


def rim(width: float) -> list[withStroke]:
    """Return a white outline for a line, with which it is visible on metal without colours.

    Parameters
    ----------
    width : float
        Width of the line, points.

    Returns
    -------
    list of withStroke
        Path effects of Matplotlib.
    """
    return [withStroke(linewidth=width + 2.0, foreground="white")]


def note(axes: Axes, pixel: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
    """Write text next to a pixel, with a leader line."""
    line = {"arrowstyle": "-", "color": style.get("color", theme.INK), "linewidth": 1.0}
    text(axes, pixel, words, offset, arrowprops={**line, "shrinkA": 2, "shrinkB": 1}, **style)


def clear_offset(
    axes: Axes, start: ArrayLike, end: ArrayLike, side: ArrayLike, words: str, **style: Any
) -> Offset:
    """Return the offset (points) of a label that clears the line between two pixels.

    `side`: vector in pixels to the side of the line on which the label is placed."""
    along = np.subtract(end, start) / np.linalg.norm(np.subtract(end, start))
    normal = along[::-1] * (1.0, -1.0)
    normal = normal * np.copysign(1.0, normal @ np.asarray(side, dtype=float))
    probe = theme.label_point(axes, start, words, (0.0, 0.0), **style)
    half = 36.0 * np.array(probe.get_window_extent().size) / axes.figure.dpi
    probe.remove()
    # Distance of the label of a line or an arrow from it, points.
    line_gap = 3.0
    right, down = (normal * (np.abs(normal) @ half + line_gap)).tolist()
    return right, -down


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
    """Draw a dimension line with a label.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    start, end : array_like, shape (2,)
        Ends in data coordinates. Arrows are placed outside if there is no space between the ends.
    words : str
        Label.
    offset : tuple of float
        Offset of the label, points.
    at : float
        Position of the label, as a fraction of the line.
    **style
        Properties of the label.
    """
    # Length of the two heads of a dimension line, points.
    heads = 13.0
    colour = style.get("color", theme.INK)
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(np.subtract(*axes.transData.transform((a, b)))))
    least = heads * axes.figure.dpi / 72.0
    if length > least:
        arrow(axes, a, b, colour, 1.2, "<|-|>")
    elif length > 0.0:
        out = 1.5 * least * (b - a) / length
        arrow(axes, a - out, a, colour, 1.2)
        arrow(axes, b + out, b, colour, 1.2)
    text(axes, a + at * (b - a), words, offset, **style)


def arc(centre: ArrayLike, first: ArrayLike, second: ArrayLike, radius: float, count: int = 33) -> FloatArray:
    """Return points (count, 3) on the circle about `centre` from unit vector `first` to `second`, mm."""
    u, v = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    angle = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
    across = v - (u @ v) * u
    size = np.linalg.norm(across)
    across = across / size if size > 0.0 else across
    turn = np.linspace(0.0, angle, count)[:, None]
    return np.asarray(np.asarray(centre) + radius * (np.cos(turn) * u + np.sin(turn) * across))


@dataclass(frozen=True, eq=False)
class Overlay:
    """Annotations over a picture. The axes have pixels as coordinates; points (3,) are in space, mm."""

    axes: Axes
    picture: Picture

    @classmethod
    def drawn(cls, page: theme.Page, box: theme.PageBox, items: Sequence[Item], camera: Camera) -> Overlay:
        """Draw a scene into a box of the page, and return axes over the picture."""
        picture = render(Scene(items, camera), box.size)
        return cls(theme.show_picture(page, box, picture), picture)

    def label(self, point: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
        """Write text next to a point."""
        text(self.axes, self.picture.project(point), words, offset, **style)

    def note(self, point: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
        """Write text next to a point, with a leader line."""
        note(self.axes, self.picture.project(point), words, offset, **style)

    def line(self, *points: ArrayLike, **style: Any) -> None:
        """Draw a polyline in front of the picture: points (3,), or one array (n, 3) of points."""
        settings = {"color": theme.GREY, "linewidth": 1.2, "zorder": 3, **style}
        pixels = self.picture.project(np.reshape(np.stack([np.asarray(p) for p in points]), (-1, 3)))
        self.axes.plot(*pixels.T, **settings)

    def axis(self, start: ArrayLike, end: ArrayLike, colour: str, at: ArrayLike | None = None) -> None:
        """Draw a dash-dotted centre line, with a break `at` a point if given."""
        self.line(*(point for point in (start, at, end) if point is not None), color=colour, **CENTRE_LINE)
        if at is not None:
            self.broken(at, end, colour)

    def broken(self, point: ArrayLike, towards: ArrayLike, colour: str) -> None:
        """Draw the symbol of a break at a point of the line towards another point: two strokes across a
        gap."""
        # Half the gap, and extent of the strokes along and across the line.
        gap_pt, stroke_pt = 2.0, (2.5, 6.0)
        middle, other = self.picture.project(np.stack([np.asarray(point), np.asarray(towards)]))
        along = (other - middle) / np.linalg.norm(other - middle) * self.axes.figure.dpi / 72.0
        across = along[::-1] * (1.0, -1.0)
        gap = middle + np.array([[-gap_pt], [gap_pt]]) * along
        self.axes.plot(*gap.T, color="white", linewidth=2.0 * stroke_pt[1], solid_capstyle="butt", zorder=4)
        stroke = np.array([[-1.0], [1.0]]) * (stroke_pt[0] * along + stroke_pt[1] * across)
        for end in gap:
            self.axes.plot(*(end + stroke).T, color=colour, linewidth=1.2, zorder=4)

    def arrow(self, tail: ArrayLike, head: ArrayLike, colour: str, width: float = 1.8) -> None:
        """Draw an arrow between two points."""
        arrow(self.axes, self.picture.project(tail), self.picture.project(head), colour, width)

    def clear_offset(
        self, tail: ArrayLike, head: ArrayLike, side: ArrayLike, words: str, **style: Any
    ) -> Offset:
        """Return the offset of a label that clears the line between two points, on the side of a vector
        (3,)."""
        first, second, third = self.picture.project(np.stack([tail, head, np.add(tail, side)]))
        return clear_offset(self.axes, first, second, third - first, words, **style)

    def label_clear_of(
        self,
        line: tuple[ArrayLike, ArrayLike],
        words: str,
        places: Sequence[tuple[ArrayLike, Offset]],
        **style: Any,
    ) -> None:
        """Write a label at the first of several places, points (3,) with offsets (points), that is clear of a
        line between two points; if there is none, at the first."""
        # Least distance of the middle of the label from the line, points.
        least_pt = 18.0
        scale = 72.0 / self.axes.figure.dpi
        start, end = scale * self.picture.project(np.stack(line))

        def away(place: tuple[ArrayLike, Offset]) -> float:
            """Return the distance (points) of the label at a place from the line."""
            point, (right, up) = place
            at = scale * self.picture.project(point) + (right, -up)
            share = np.clip((at - start) @ (end - start) / ((end - start) @ (end - start)), 0.0, 1.0)
            return float(np.linalg.norm(at - start - share * (end - start)))

        point, offset = next((place for place in places if away(place) >= least_pt), places[0])
        self.label(point, words, offset, **style)

    def apart(self, point: ArrayLike, other: ArrayLike, along: ArrayLike) -> float:
        """Return the distance (points) in the picture of the lines through two points along a vector (3,)."""
        first, second, ahead = self.picture.project(np.stack([point, other, np.add(point, along)]))
        direction, step = ahead - first, second - first
        across = abs(direction[0] * step[1] - direction[1] * step[0]) / np.linalg.norm(direction)
        return float(72.0 * across / self.axes.figure.dpi)

    def dimension(self, start: ArrayLike, end: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
        """Draw a dimension line between two points; see `dimension`."""
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
        """Draw an angle with a label.

        Parameters
        ----------
        foot : array_like, shape (3,)
            Vertex, mm.
        first, second : array_like, shape (3,)
            Directions of the sides. The first is drawn as a dashed line.
        radius : float
            Radius of the arc, mm.
        words : str
            Label.
        reach : tuple of float
            End of the dashed line and position of the label, as fractions of the radius.
        offset : tuple of float
            Offset of the label, points, if the second side is below the first; otherwise the opposite.
        """
        start, side = np.asarray(foot), np.asarray(first)
        self.line(start, start + reach[0] * radius * side, color=theme.VERMILLION, linestyle="--")
        curve = arc(start, first, second, radius)
        self.arrow_along(curve, theme.VERMILLION)
        (x1, y1), (x2, y2) = np.diff(self.picture.project(np.stack((start, curve[0], curve[-1]))), axis=0)
        second_below = x1 * y2 - y1 * x2 > 0.0  # pixels are counted downwards
        ha, va, sign = ("right", "bottom", 1.0) if second_below else ("left", "top", -1.0)
        style: dict[str, Any] = {"color": theme.VERMILLION, "fontsize": theme.HEADING, "ha": ha, "va": va}
        at = start + reach[1] * radius * side
        self.label(at, words, (sign * offset[0], sign * offset[1]), **style)

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
        covered: ArrayLike | None = None,
    ) -> None:
        """Draw a coordinate frame.

        Parameters
        ----------
        origin : array_like, shape (3,)
            Origin, mm.
        vectors : array_like, shape (n, 3)
            Unit vectors of the axes.
        length : float
            Length of the arrows, mm.
        names : sequence of str
            Names of the axes as TeX formulas; an axis with an empty name is left out, one named UNNAMED
            has no label.
        colour : str
            Colour.
        title : str
            Name of the frame, written next to the origin.
        offset : tuple of float
            Offset of the name, points.
        covered : array_like, shape (3,), optional
            Direction of another line from the origin. The label of an axis in this direction is placed next
            to the arrow.
        """
        # Cosine of the angle to the other line above which a label would cover this line.
        covering_cosine = 0.97
        # Sine of the angle from the vertical above which the label of an arrow is placed to its
        # side.
        sideways = 0.5
        # Visible fraction of its length below which an axis is drawn as seen from its end.
        end_on = 0.12
        start = self.picture.project(origin)
        full = length * self.picture.px_per_mm
        ends = self.picture.project(np.asarray(origin) + length * np.asarray(vectors, dtype=float))
        other = np.zeros(2) if covered is None else self.picture.project(np.add(origin, covered)) - start
        for name, vector in zip(names, np.asarray(vectors, dtype=float), strict=True):
            if not name:
                continue
            tip = self.picture.project(np.asarray(origin) + length * vector)
            direction = tip - start
            seen = float(np.linalg.norm(direction))
            if seen < end_on * full:
                away = float(vector @ self.picture.camera.axes[2]) < 0.0
                self.axes.plot(*start, "o", ms=9, mfc="white", mec=colour, mew=1.6, zorder=4)
                self.axes.plot(*start, "x" if away else ".", ms=5, color=colour, mew=1.2, zorder=5)
                text(self.axes, start, f"${name}$", (-13.0, 11.0), color=colour)
                continue
            arrow(self.axes, start, tip, colour, 1.8)
            if name == UNNAMED:
                continue
            if direction @ other > covering_cosine * seen * float(np.linalg.norm(other)) > 0.0:
                away_from_axes = 3.0 * start - ends.sum(axis=0)
                place = clear_offset(self.axes, start, tip, away_from_axes, f"${name}$", fontsize=theme.LABEL)
                text(self.axes, tip, f"${name}$", place, color=colour)
                continue
            shift = direction / seen * (1.0, -1.0)
            side = "left" if shift[0] > sideways else "right" if shift[0] < -sideways else "center"
            reach = 5.0 if side != "center" else 12.0
            text(self.axes, tip, f"${name}$", (reach * shift[0], 11.0 * shift[1]), color=colour, ha=side)
        if title:
            bold: dict[str, Any] = {"fontweight": "bold", "fontsize": theme.HEADING}
            text(self.axes, start, f"${title}$", offset, color=colour, **bold)
