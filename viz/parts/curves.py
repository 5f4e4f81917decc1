"""Curves of methods on logarithmic axes: one look for each, hollow and dashed for its variant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from ..stage import theme

GAP, MARK = 1.5, 3.0
"""Points between a label and any curve, and any point that has a mark."""
Shift: TypeAlias = tuple[float, float, str]
"""Right and up in points, and how the text is aligned there."""


@dataclass(frozen=True)
class Look:
    """How a method is drawn; a variant has the colour and marker of what it varies."""

    label: str
    colour: str
    marker: str
    variant: bool = False
    size: float = 6.0

    def line(self, points: Sequence[tuple[float, float]] = ()) -> Line2D:
        """Make the curve through points, or without points its line for a legend."""
        dashes, face = ("--", "white") if self.variant else ("-", self.colour)
        mark: dict[str, Any] = {"marker": self.marker, "ms": self.size, "mfc": face, "mew": 1.2}
        x, y = np.reshape(points, (-1, 2)).T
        return Line2D(x, y, color=self.colour, ls=dashes, lw=1.6, label=self.label, **mark)


def curve(axes: Axes, look: Look, points: Sequence[tuple[float, float]], order: int) -> None:
    """Draw a curve through points; those of higher order lie on top."""
    line = look.line(points)
    line.set_zorder(2.0 + 0.01 * order)
    axes.add_line(line)


def log_axes(axes: Axes) -> None:
    """Set logarithmic axes with a grid below the curves."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    axes.set_axisbelow(True)


def whole_decades(axes: Axes) -> None:
    """Widen the vertical axis to powers of ten, so that two at least are written."""
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))


class Labels:
    """Words beside points, where they hide neither each other nor a curve."""

    def __init__(self, axes: Axes) -> None:
        """Curves of the axes and their limits must be there before the first label."""
        self.axes = axes
        self.taken: list[Bbox] = []
        self.lines = [line.get_transform().transform_path(line.get_path()) for line in axes.lines]
        drawn = zip(self.lines, axes.lines, strict=True)
        marked = [path.vertices for path, line in drawn if line.get_marker() != "None"]
        self.marks = np.concatenate([np.empty((0, 2)), *marked])

    def put(self, text: str, at: tuple[float, float], shifts: Sequence[Shift], colour: str) -> bool:
        """Write the text at the first shift where it is free; not at all, and False, if at none."""
        for x, y, side in shifts:
            style = {"ha": side, "fontsize": theme.SMALL, "color": colour}
            label = theme.beside(self.axes, at, text, (x, y), **style)
            box = label.get_window_extent()
            if self._free(box):
                self.taken.append(box)
                return True
            label.remove()
        return False

    def _free(self, box: Bbox) -> bool:
        """Say whether a box, pixels, lies in the axes and off all labels, marks and curves."""
        room, point = self.axes.get_window_extent(), self.axes.figure.dpi / 72.0
        if box.x0 < room.x0 or box.x1 > room.x1 or box.y0 < room.y0 or box.y1 > room.y1:
            return False
        if any(box.overlaps(other) for other in self.taken):
            return False
        low, high = box.padded(MARK * point).get_points()
        if ((low < self.marks) & (self.marks < high)).all(axis=-1).any():
            return False
        near = box.padded(GAP * point)
        return not any(line.intersects_bbox(near, filled=False) for line in self.lines)


def duration(seconds: float) -> str:
    """Give a time in s, ms or microseconds, to three digits, or two of what is under a microsecond."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("\u00b5s", 1e6)):
        if seconds * factor >= 0.9995:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.2g} \u00b5s"
