"""Curves of methods on logarithmic axes. Variants of a method are hollow and dashed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D


@dataclass(frozen=True)
class MethodStyle:
    """Style of a method; a variant has the colour and marker of its method."""

    label: str
    colour: str
    marker: str
    variant: bool = False
    size: float = 6.0

    def line(self, points: Sequence[tuple[float, float]] = ()) -> Line2D:
        """Return the curve through points, or without points its legend entry."""
        dashes, face = ("--", "white") if self.variant else ("-", self.colour)
        mark: dict[str, Any] = {"marker": self.marker, "ms": self.size, "mfc": face, "mew": 1.2}
        x, y = np.reshape(points, (-1, 2)).T
        return Line2D(x, y, color=self.colour, ls=dashes, lw=1.6, label=self.label, **mark)


def curve(axes: Axes, look: MethodStyle, points: Sequence[tuple[float, float]], order: int) -> None:
    """Draw a curve through points; curves of higher order are in front."""
    line = look.line(points)
    line.set_zorder(2.0 + 0.01 * order)
    axes.add_line(line)


def log_axes(axes: Axes) -> None:
    """Set logarithmic axes with a grid behind the curves."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    axes.set_axisbelow(True)
