"""Contour labels, hatches and values between the cells of maps."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.transforms import Bbox
from scipy.ndimage import binary_dilation, map_coordinates

from beveloid_geom.arrays import FloatArray, Mask

from ..rendering import theme

HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.5, foreground="white")]
LEVEL = "level"
"""Identifier (gid) of the labels of contour lines."""


def thin_out(axes: Axes, marks: Sequence[tuple[float, float]] = ()) -> None:
    """Remove labels of contour lines that overlap other text, or marks at places in data coordinates."""
    # Size of a mark with its edge, points.
    mark_pt = 9.0
    half = 0.5 * mark_pt * axes.figure.dpi / 72.0
    taken = [text.get_window_extent() for text in axes.texts if text.get_gid() != LEVEL and text.get_text()]
    taken += [Bbox([at - half, at + half]) for at in axes.transData.transform(marks)] if marks else []
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


def contours(
    axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, levels: FloatArray, names: Sequence[str]
) -> None:
    """Draw contour lines of values (x, y) with the names of their levels, where the values are not NaN."""
    shown = np.ma.masked_invalid(values)
    if min(shown.shape) < 2 or not levels.size or not shown.count():
        return
    if not ((shown.min() < levels) & (levels < shown.max())).any():
        return
    lines = axes.contour(x, y, shown.T, levels=levels, colors=theme.INK, linewidths=0.8, zorder=1.0)
    words = dict(zip(levels.tolist(), names, strict=True))
    for label in axes.clabel(lines, fontsize=theme.SMALL, fmt=words, inline=False):
        label.set_path_effects(HALO)
        label.set_gid(LEVEL)
        box = label.get_window_extent()
        inside = box.x0 >= axes.bbox.x0 and box.x1 <= axes.bbox.x1
        if not (inside and box.y0 >= axes.bbox.y0 and box.y1 <= axes.bbox.y1):
            label.remove()  # it would be cut or cover numbers of the axis


def between_cells(values: FloatArray, period: float = np.inf) -> FloatArray:
    """Return values (m, n) interpolated linearly, (8 m - 7, 8 n - 7); NaN where the nearest cell is NaN.

    Next to cells that are NaN, the value of the nearest cell is used. `period`: period of cyclic values."""
    parts = 8
    places = np.meshgrid(
        *(np.linspace(0.0, size - 1.0, parts * (size - 1) + 1) for size in values.shape), indexing="ij"
    )
    nearest = map_coordinates(values, places, order=0, mode="nearest")
    if np.isfinite(period):
        turns = 2.0 * np.pi * values / period
        cosine, sine = (map_coordinates(f(turns), places, order=1, mode="nearest") for f in (np.cos, np.sin))
        interpolated = np.arctan2(sine, cosine) * period / (2.0 * np.pi)
    else:
        interpolated = map_coordinates(values, places, order=1, mode="nearest")
    return np.asarray(np.where(np.isnan(interpolated), nearest, interpolated))


def next_to_unknown(values: FloatArray, cells: int) -> Mask:
    """Return the cells (m, n) that are NaN or at most a number of `cells` from a cell that is NaN."""
    unknown = np.isnan(values)
    if not unknown.any():
        return unknown
    return np.asarray(binary_dilation(unknown, np.ones((3, 3), dtype=bool), iterations=cells))


def widest_gap(values: FloatArray, period: float) -> tuple[float, float]:
    """Return the middle and the width of the largest interval without any of the cyclic values."""
    seen = np.sort(values % period)
    gaps = np.diff(np.append(seen, seen[0] + period))
    widest = int(gaps.argmax())
    return float(seen[widest] + 0.5 * gaps[widest]), float(gaps[widest])
