"""One map on a page: colours, labelled lines, and hatches over cells that are not to be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, Colormap, LogNorm, Normalize
from matplotlib.contour import ContourSet
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.ticker import MaxNLocator

from beveloid_geom.analysis.maps import DesignMap
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.words import status_words

from ..stage import theme

HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.5, foreground="white")]
ANGLES = np.array(
    [-90.0, -60.0, -30.0, -15.0, -10.0, -5.0, -2.0, 0.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 90.0]
)
"""Borders of the colours of angles, deg, where they differ widely."""
ISLAND = 0.06
"""Share of the cells that a line must part from the others."""
EDGE, CORNER = 0.46, 0.32
"""Shares of a map from its middle beyond which lines are not labelled: in one, and in both directions."""
LINE, ZERO_LINE = 0.8, 2.0
"""Widths of lines, in points, and of that at zero; those of negative levels are dashed."""
NARROW = 3.0
"""Inches of a map under which it has fewer ticks, in small type."""
LEVEL = "level"
"""What words are called that name a level."""
LOST, ASTRAY, UNKNOWN, HOLLOW = "xxx", "....", "++", "//"
"""Hatches of cells without a path, without a figure, and without use."""


@dataclass(frozen=True)
class Look:
    """How a figure is mapped: heading with the unit, scale, the way it runs, and colours, darker for less:
    on paper without colours they still tell which of two cells has more."""

    heading: str
    scale: float
    way: str
    colours: str


LOOKS = {
    "contact_ratio": Look("contact ratio, Eq. 16", 1.0, "linear", "viridis"),
    "angle": Look("angle of the path (deg)", math.degrees(1.0), "angle", "viridis"),
    "shift": Look("shift under errors (mm)", 1.0, "log", "cividis"),
    "peak_to_peak": Look("transmission error (arcsec)", ARCSEC, "linear", "magma"),
    "centre": Look("middle, pinion z (mm)", 1.0, "linear", "viridis"),
    "normal_backlash": Look("normal backlash (mm)", 1.0, "linear", "viridis"),
    "edge_share": Look("carried by edges (%)", 100.0, "share", "viridis"),
}


def panel(axes: Axes, bar: Axes, name: str, found: DesignMap) -> None:
    """Draw the map of a figure and its bar of colours, or say why there is nothing to draw."""
    look, x, y = LOOKS[name], found.pinion, found.gear
    per = 1e3 if found.over == "parabola" else 1.0
    values = look.scale * getattr(found, name)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    wide = axes.get_window_extent().width > NARROW * axes.figure.dpi
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5 if wide else 3, steps=[1, 2, 5, 10]))
        axis.set_tick_params(labelsize=theme.LABEL if wide else theme.SMALL)
        axis.set_major_formatter(lambda value, _: _plain(per * value))
    if not np.isfinite(values).any():
        bar.set_axis_off()
        why = "not known in any cell" if found.solved.any() else f"no cell has a path: {statuses(found)}"
        _hatch(axes, found, ~found.solved, LOST)
        _say(axes, why)
        return
    cells = found.sound if np.isfinite(values[found.sound]).any() else np.ones_like(found.solved)
    colours, norm, levels, extend = _colours(look, values[cells & np.isfinite(values)])
    look_of: dict[str, Any] = {"cmap": colours, "norm": norm, "shading": "nearest", "zorder": 0.0}
    mesh = axes.pcolormesh(x, y, values.T, rasterized=True, **look_of)
    scale = axes.figure.colorbar(mesh, cax=bar, extend=extend, ticks=levels, spacing="uniform")
    scale.ax.minorticks_off()
    scale.ax.set_yticklabels([_plain(level) for level in levels], fontsize=theme.SMALL)
    _contours(axes, x, y, values, levels, look)
    _hatch(axes, found, np.isnan(values) & found.solved, UNKNOWN if name == "edge_share" else ASTRAY)
    _hatch(axes, found, ~found.solved, LOST)
    if found.over == "parabola":
        _hatch(axes, found, np.add.outer(x, y) / np.abs(x).max(), HOLLOW, 1e-9)
    else:
        _hatch(axes, found, found.hollow, HOLLOW)
    _hatch(axes, found, -found.normal_backlash, HOLLOW, 0.0)


def _colours(look: Look, values: FloatArray) -> tuple[Colormap, Normalize, FloatArray, str]:
    """Give the colour map, norm, levels of lines and ticks, and which ends of the bar are open."""
    colours = mpl.colormaps[look.colours]
    low, high = (float(value) for value in np.percentile(values, [1.0, 99.0]))
    if look.way == "share":
        low, high = 0.0, 100.0
    elif look.way == "angle" and np.abs(values).max() > 0.5 * ANGLES[-1]:
        return colours, BoundaryNorm(ANGLES, colours.N), ANGLES, "neither"
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5
    if look.way == "log" and high > 5.0 * low > 0.0:  # two levels at least
        levels = np.array([digit * 10.0**k for k in range(-6, 7) for digit in (1.0, 2.0, 5.0)])
        norm: Normalize = LogNorm(low, high)
    else:
        levels = np.asarray(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
        norm = Normalize(low, high)
    open_ends = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}
    room = 1e-9 * (high - low)
    extend = open_ends[bool(values.min() < low - room), bool(values.max() > high + room)]
    return colours, norm, levels[(levels >= low - room) & (levels <= high + room)], extend


def _contours(
    axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, levels: FloatArray, look: Look
) -> None:
    """Draw labelled lines; none where an angle jumps by half a turn."""
    if min(values.shape) < 2 or np.nanmax(values) - np.nanmin(values) < 1e-9:
        _say(axes, f"{_plain(float(f'{round(np.nanmean(values), 9):.4g}'))} in all cells")
        return
    if look.way == "share":
        return
    shown = np.ma.masked_invalid(values)
    if look.way == "angle":
        shown = np.ma.masked_where(_jumps(values), shown)
    share = np.array([np.mean(shown.compressed() > level) for level in levels])
    levels = levels[(share > ISLAND) & (share < 1.0 - ISLAND)]
    if not levels.size:
        return
    widths = [ZERO_LINE if level == 0.0 else LINE for level in levels]
    style: dict[str, Any] = {"colors": theme.INK, "linewidths": widths, "negative_linestyles": "dashed"}
    lines = axes.contour(x, y, shown.T, levels=levels, zorder=1.0, **style)
    labels = axes.clabel(lines, fontsize=theme.SMALL, fmt=_plain, inline=False)
    for label in labels:
        label.set_path_effects(HALO)
        label.set_gid(LEVEL)
        seen = axes.transData.transform(label.get_position())
        place = np.abs(axes.transAxes.inverted().transform(seen) - 0.5)
        if place.max() > EDGE or place.min() > CORNER:
            label.remove()  # cut off, or under the name of a quadrant


def thin_out(axes: Axes) -> None:
    """Take away names of levels that stand on other words."""
    kept = [text.get_window_extent() for text in axes.texts if text.get_gid() != LEVEL and text.get_text()]
    for label in [text for text in axes.texts if text.get_gid() == LEVEL]:
        box = label.get_window_extent()
        if any(box.overlaps(other) for other in kept):
            label.remove()
        else:
            kept.append(box)


def _jumps(angle: FloatArray) -> Mask:
    """Give cells beside which an angle (deg) turns over from 90 to -90, where it is the same."""
    cells = np.zeros(angle.shape, dtype=bool)
    for values, marks in ((angle, cells), (angle.T, cells.T)):
        with np.errstate(invalid="ignore"):
            far = np.abs(np.diff(values, axis=0)) > ANGLES[-1]
        marks[1:] |= far
        marks[:-1] |= far
    return cells


def _hatch(axes: Axes, found: DesignMap, field: FloatArray | Mask, pattern: str, above: float = 0.5) -> None:
    """Hatch where a field lies above a value: dark on light lines, to be seen on any colour."""
    field = np.nan_to_num(field.astype(float), nan=above - 1.0)
    if not (field > above).any():
        return
    levels = [above, max(float(field.max()), above) + 1.0]
    for colour, width in (("white", 2.4), (theme.INK, 0.7)):
        with mpl.rc_context({"hatch.linewidth": width}):
            drawn: ContourSet = axes.contourf(
                found.pinion, found.gear, field.T, levels, colors="none", hatches=[pattern], zorder=2.0
            )
        drawn.set_edgecolor(colour)
        drawn.set_linewidth(0.0)


def _say(axes: Axes, words: str) -> None:
    """Write words on top of all marks."""
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2.0}
    axes.text(0.5, 0.68, words, transform=axes.transAxes, ha="center", bbox=box, zorder=8.0)


def _plain(value: float, _: object = None) -> str:
    """Give a number with a true minus."""
    return f"{value:.6g}".replace("-", "\u2212")


def statuses(found: DesignMap) -> str:
    """Say why cells have no path."""
    codes = np.unique(found.status[~found.solved]).tolist()
    return ", ".join(status_words(code) for code in codes)
