"""Curves of methods on logarithmic axes: one look for each, hollow and dashed for its variant."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

HOLLOW = "white"


@dataclass(frozen=True)
class Look:
    """How a method is drawn; a variant has the colour and marker of what it varies."""

    label: str
    colour: str
    marker: str
    variant: bool = False
    size: float = 6.0

    def line(self, x: Sequence[float] = (), y: Sequence[float] = ()) -> Line2D:
        """The curve through points, or without points its line for a legend."""
        return Line2D(
            x,
            y,
            color=self.colour,
            linestyle="--" if self.variant else "-",
            linewidth=1.6,
            marker=self.marker,
            markersize=self.size,
            markerfacecolor=HOLLOW if self.variant else self.colour,
            markeredgewidth=1.2,
            label=self.label,
        )


def curve(axes: Axes, look: Look, x: Sequence[float], y: Sequence[float], order: int = 0) -> None:
    """Draw a curve; those of higher order lie on top."""
    line = look.line(x, y)
    line.set_zorder(2.0 + 0.01 * order)
    axes.add_line(line)


def log_axes(axes: Axes) -> None:
    """Logarithmic axes with a grid below the curves."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    axes.set_axisbelow(True)


def say(axes: Axes, reason: str) -> None:
    """A reason in place of a chart."""
    axes.text(0.5, 0.5, textwrap.fill(reason, 36), transform=axes.transAxes, ha="center", va="center")


def duration(seconds: float) -> str:
    """A time in s, ms or microseconds, to three digits, or two of what is under a microsecond."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("\u00b5s", 1e6)):
        if seconds * factor >= 0.9995:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.2g} \u00b5s"
