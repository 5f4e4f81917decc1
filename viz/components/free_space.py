"""Placement of labels in the free space of pictures and charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from beveloid_geom.arrays import FloatArray, Mask

from ..rendering import theme
from .annotate import Offset, note

Shift: TypeAlias = tuple[float, float, str]
"""Offset to the right and upwards in points, and horizontal alignment."""


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
        # Distances that are tried, relative to the usual one, and rotations about the point, rad.
        reaches, turns = (1.0, 1.5, 2.2), (0.0, 0.6, -0.6)
        # Free space around a label.
        space_pt = 3.0
        away = (pixels - np.asarray(middle)) * (1.0, -1.0)
        direction = away[:, 0] + 1j * away[:, 1]
        usual = complex(*offset) * direction / np.abs(direction) * abs(direction[0]) / direction[0]
        number, reach, turn = (
            grid.ravel() for grid in np.meshgrid(np.arange(len(pixels)), reaches, turns, indexing="ij")
        )
        shifts = (usual[number] * reach * np.exp(1j * turn))[:, None].view(float)
        probe = theme.label_point(self.axes, pixels[0], words, (0.0, 0.0), fontsize=theme.LABEL)
        half = 0.5 * np.array(probe.get_window_extent().size) / self.point
        probe.remove()
        shifts += half * shifts / np.linalg.norm(shifts, axis=1, keepdims=True)
        ends = self.axes.transData.transform(pixels)[number]
        middles, half = ends + self.point * shifts, self.point * (half + space_pt)
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

    def take(self, box: theme.PageBox) -> None:
        """Mark a box of the page as occupied."""
        self._seen(box)[:] = False

    def hides(self, box: theme.PageBox) -> int:
        """Return the number of pixels of a box that are occupied or outside the page."""
        return box.width * box.height - int(self._seen(box).sum())

    def _seen(self, box: theme.PageBox) -> Mask:
        """Return the part of a box that is on the page."""
        left, bottom, right, top = (
            max(end, 0) for end in (box.left, box.bottom, box.left + box.width, box.bottom + box.height)
        )
        return self.free[bottom:top, left:right]

    def _line(self, end: FloatArray, start: FloatArray) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Return rows and columns of the pixels of a line, without the part close to its end."""
        # Part of the leader at the point that is not checked for overlap.
        near_pt = 9.0
        length = float(np.linalg.norm(end - start))
        share = np.arange(self.point * near_pt, length, 1.0)[:, None] / length
        column, row = np.rint(end + share * (start - end)).astype(int).T
        height, width = self.free.shape
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)


def _box(middle: FloatArray, half: FloatArray) -> theme.PageBox:
    """Return a box with a centre and half its width and height, pixels."""
    low, high = (np.rint(middle + side * half).astype(int).tolist() for side in (-1.0, 1.0))
    return theme.PageBox(low[0], low[1], high[0] - low[0], high[1] - low[1])


class Labels:
    """Labels of points that cover neither each other nor a curve."""

    def __init__(self, axes: Axes, *others: Axes) -> None:
        """Read the curves of the axes, and of other axes at the same place. Curves and limits must be
        complete."""
        self.axes = axes
        self.taken: list[Bbox] = []
        curves = [line for one in (axes, *others) for line in one.lines]
        drawn = [(line.get_transform().transform_path(line.get_path()), line) for line in curves]
        self.lines = [path for path, line in drawn if line.get_linestyle() != "None"]
        marked = [path.vertices for path, line in drawn if line.get_marker() != "None"]
        self.marks = np.concatenate([np.empty((0, 2)), *marked])

    def put(
        self, text: str, at: tuple[float, float], shifts: Sequence[Shift], colour: str, **style: Any
    ) -> bool:
        """Write a label at the first offset that is free. Returns False, and writes nothing, if none is
        free."""
        for x, y, side in shifts:
            look = {"ha": side, "fontsize": theme.SMALL, "color": colour, **style}
            label = theme.label_point(self.axes, at, text, (x, y), **look)
            box = label.get_window_extent()
            if self._free(box):
                self.taken.append(box)
                return True
            label.remove()
        return False

    def block(self, text: str, corners: Sequence[tuple[float, float]], **style: Any) -> None:
        """Write a block of text with its upper left corner at the first free one of the places `corners`,
        fractions of the axes, or at the first place if none is free."""
        block = self.axes.text(*corners[0], text, transform=self.axes.transAxes, va="top", **style)
        for corner in (*corners, corners[0]):
            block.set_position(corner)
            if self._free(block.get_window_extent()):
                break
        self.taken.append(block.get_window_extent())

    def _free(self, box: Bbox) -> bool:
        """Return True if a box, pixels, is within the axes and clear of all labels, markers and curves."""
        curve_gap_pt, marker_gap_pt = 1.5, 3.0
        frame, point = self.axes.get_window_extent(), self.axes.figure.dpi / 72.0
        if box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1:
            return False
        if any(box.overlaps(other) for other in self.taken):
            return False
        low, high = box.padded(marker_gap_pt * point).get_points()
        if ((low < self.marks) & (self.marks < high)).all(axis=-1).any():
            return False
        near = box.padded(curve_gap_pt * point)
        return not any(line.intersects_bbox(near, filled=False) for line in self.lines)
