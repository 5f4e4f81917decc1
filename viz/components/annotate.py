"""Dimension lines, coordinate frames and labels over pictures and charts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from beveloid_geom.arrays import FloatArray, Mask

from ..rendering import theme
from ..rendering.scene import Camera, Item, Picture, Scene, render

Offset = tuple[float, float]
"""Offset to the right and upwards, points."""
HALO, RIM = 3.0, 1.0
"""Points: width of the white outline of text (both sides together), and of lines on each side."""
CENTRE_LINE: dict[str, Any] = {"linewidth": 1.3, "dashes": (12, 3, 2, 3)}
GAP, SLASH = 2.0, (2.5, 6.0)
"""Points: half the gap of a break, and extent of its strokes along and across the line."""
CLEAR, NEAR = 3.0, 9.0
"""Points: free space around a label, and part of its leader at the point that is not checked for overlap."""
CURVE_GAP, MARKER_GAP = 1.5, 3.0
"""Smallest distance of a label from a curve and from a marker, points."""
Shift: TypeAlias = tuple[float, float, str]
"""Offset to the right and upwards in points, and horizontal alignment."""
REACHES, TURNS = (1.0, 1.5, 2.2), (0.0, 0.6, -0.6)
"""Distances of a label that are tried, relative to the usual one, and rotations about its point, rad."""


def text(axes: Axes, pixel: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
    """Write text at a pixel, with a white outline so that it is legible on metal."""
    settings = {"fontsize": theme.LABEL, "ha": "center", "va": "center", "color": theme.INK, **style}
    halo = [withStroke(linewidth=HALO, foreground="white")]
    theme.label_point(axes, pixel, words, offset, path_effects=halo, zorder=5, **settings)


def power_of_ten(value: float) -> str:
    """Return a positive number with one digit and a power of ten as a formula."""
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}\u00b710$^{{{int(exponent)}}}$".replace("-", "\u2212")


def rim(width: float) -> list[withStroke]:
    """Return the path effect of a white outline for a line of `width` points: visible on metal without
    colours."""
    return [withStroke(linewidth=width + 2.0 * RIM, foreground="white")]


def note(axes: Axes, pixel: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
    """Write text next to a pixel, with a leader line."""
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
    def drawn(cls, page: theme.Page, box: theme.Box, items: Sequence[Item], camera: Camera) -> Overlay:
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
        start, end, label_position = (
            np.asarray(foot),
            *(share * radius * np.asarray(first) for share in reach),
        )
        self.line(start, start + end, color=theme.RED, linestyle="--")
        curve = arc(start, first, second, radius)
        self.arrow_along(curve, theme.RED)
        (x1, y1), (x2, y2) = np.diff(self.picture.project(np.stack((start, curve[0], curve[-1]))), axis=0)
        above = x1 * y2 - y1 * x2 > 0.0  # pixels point down: the second side is below the first
        sides, way = (("right", "bottom"), 1.0) if above else (("left", "top"), -1.0)
        style: dict[str, Any] = {"color": theme.RED, "fontsize": theme.HEADING}
        style |= dict(zip(("ha", "va"), sides, strict=True))
        self.label(start + label_position, words, (way * offset[0], way * offset[1]), **style)

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
            Names of the axes as TeX formulas; an axis with an empty name is left out.
        colour : str
            Colour.
        title : str
            Name of the frame, written next to the origin.
        offset : tuple of float
            Offset of the name, points.
        """
        # Sine of the angle from the vertical above which the label of an arrow is placed to its
        # side.
        sideways = 0.5
        # Visible fraction of its length below which an axis is drawn as seen from its end.
        end_on = 0.12
        start = self.picture.project(origin)
        full = length * self.picture.px_per_mm
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
            shift = direction / seen * (1.0, -1.0)
            side = "left" if shift[0] > sideways else "right" if shift[0] < -sideways else "center"
            reach = 5.0 if side != "center" else 12.0
            text(self.axes, tip, f"${name}$", (reach * shift[0], 11.0 * shift[1]), color=colour, ha=side)
        if title:
            bold: dict[str, Any] = {"fontweight": "bold", "fontsize": theme.HEADING}
            text(self.axes, start, f"${title}$", offset, color=colour, **bold)


class FreeSpace:
    """Free space on a page: places labels where they cover neither drawing nor other labels.

    adjustText and textalloc avoid points and lines of plots. Here the picture is an image, so that its pixels
    are checked.
    """

    def __init__(self, axes: Axes) -> None:
        """Read the free pixels of the page as drawn so far."""
        self.axes, self.point = axes, axes.figure.dpi / 72.0
        canvas: Any = axes.figure.canvas
        canvas.draw()
        self.free: Mask = (np.asarray(canvas.buffer_rgba())[::-1, :, :3] == 255).all(axis=-1)

    def note(self, pixels: FloatArray, middle: ArrayLike, words: str, offset: Offset) -> None:
        """Write a label with a leader to one of the pixels (n, 2) of the axes.

        The candidate that covers the fewest pixels is used, preferably near the first pixel. There, the label
        has the given offset; at other pixels the offset is rotated with the pixel about `middle`.
        """
        away = (pixels - np.asarray(middle)) * (1.0, -1.0)
        direction = away[:, 0] + 1j * away[:, 1]
        usual = complex(*offset) * direction / np.abs(direction) * abs(direction[0]) / direction[0]
        number, reach, turn = (
            grid.ravel() for grid in np.meshgrid(np.arange(len(pixels)), REACHES, TURNS, indexing="ij")
        )
        shifts = (usual[number] * reach * np.exp(1j * turn))[:, None].view(float)
        probe = theme.label_point(self.axes, pixels[0], words, (0.0, 0.0), fontsize=theme.LABEL)
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
        """Mark a box of the page as occupied."""
        self._seen(box)[:] = False

    def hides(self, box: theme.Box) -> int:
        """Return the number of pixels of a box that are occupied or outside the page."""
        return box.width * box.height - int(self._seen(box).sum())

    def _seen(self, box: theme.Box) -> Mask:
        """Return the part of a box that is on the page."""
        left, bottom, right, top = (
            max(end, 0) for end in (box.left, box.bottom, box.left + box.width, box.bottom + box.height)
        )
        return self.free[bottom:top, left:right]

    def _line(self, end: FloatArray, start: FloatArray) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Return rows and columns of the pixels of a line, without the part close to its end."""
        length = float(np.linalg.norm(end - start))
        share = np.arange(self.point * NEAR, length, 1.0)[:, None] / length
        column, row = np.rint(end + share * (start - end)).astype(int).T
        height, width = self.free.shape
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)


def _box(middle: FloatArray, half: FloatArray) -> theme.Box:
    """Return a box with a centre and half its width and height, pixels."""
    low, high = (np.rint(middle + side * half).astype(int).tolist() for side in (-1.0, 1.0))
    return theme.Box(low[0], low[1], high[0] - low[0], high[1] - low[1])


class Labels:
    """Labels of points that cover neither each other nor a curve."""

    def __init__(self, axes: Axes, *others: Axes) -> None:
        """Read the curves of the axes, and of other axes at the same place. Curves and limits must be
        complete."""
        self.axes = axes
        self.taken: list[Bbox] = []
        curves = [line for one in (axes, *others) for line in one.lines]
        self.lines = [line.get_transform().transform_path(line.get_path()) for line in curves]
        drawn = zip(self.lines, curves, strict=True)
        marked = [path.vertices for path, line in drawn if line.get_marker() != "None"]
        self.marks = np.concatenate([np.empty((0, 2)), *marked])

    def put(self, text: str, at: tuple[float, float], shifts: Sequence[Shift], colour: str) -> bool:
        """Write a label at the first offset that is free. Returns False, and writes nothing, if none is
        free."""
        for x, y, side in shifts:
            style = {"ha": side, "fontsize": theme.SMALL, "color": colour}
            label = theme.label_point(self.axes, at, text, (x, y), **style)
            box = label.get_window_extent()
            if self._free(box):
                self.taken.append(box)
                return True
            label.remove()
        return False

    def _free(self, box: Bbox) -> bool:
        """Return True if a box, pixels, is within the axes and clear of all labels, markers and curves."""
        room, point = self.axes.get_window_extent(), self.axes.figure.dpi / 72.0
        if box.x0 < room.x0 or box.x1 > room.x1 or box.y0 < room.y0 or box.y1 > room.y1:
            return False
        if any(box.overlaps(other) for other in self.taken):
            return False
        low, high = box.padded(MARKER_GAP * point).get_points()
        if ((low < self.marks) & (self.marks < high)).all(axis=-1).any():
            return False
        near = box.padded(CURVE_GAP * point)
        return not any(line.intersects_bbox(near, filled=False) for line in self.lines)
