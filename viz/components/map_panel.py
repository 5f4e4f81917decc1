"""Contour labels and hatches of maps."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.patheffects import AbstractPathEffect, withStroke

from beveloid_geom.arrays import FloatArray, Mask

from ..rendering import theme

HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.5, foreground="white")]
LEVEL = "level"
"""Identifier (gid) of the labels of contour lines."""


def thin_out(axes: Axes) -> None:
    """Remove labels of contour lines that overlap other text."""
    taken = [text.get_window_extent() for text in axes.texts if text.get_gid() != LEVEL and text.get_text()]
    for label in [text for text in axes.texts if text.get_gid() == LEVEL]:
        box = label.get_window_extent()
        if any(box.overlaps(other) for other in taken):
            label.remove()
        else:
            taken.append(box)


def hatch(axes: Axes, x: FloatArray, y: FloatArray, cells: Mask, pattern: str) -> None:
    """Hatch the cells (x, y) of a mask: dark on light lines, which are visible on any colour."""
    if not cells.any():
        return
    for colour, width in (("white", 2.4), (theme.INK, 0.7)):
        with mpl.rc_context({"hatch.linewidth": width}):
            drawn: ContourSet = axes.contourf(
                x, y, cells.T.astype(float), [0.5, 2.0], colors="none", hatches=[pattern], zorder=2.0
            )
        drawn.set_edgecolor(colour)
        drawn.set_linewidth(0.0)
