"""What says how flanks are seen: a tooth with an eye, and scales along and across."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, Polygon

from beveloid_geom.arrays import FloatArray

from ..stage import theme
from ..stage.theme import Page

Look = tuple[str, bool]
"""A flank, right or left, and whether it is seen from outside."""

COLUMNS = 120
"""Characters of a line of the note that leave room for scales and sketch beside it."""
HALF_TIP, HALF_ROOT, DEPTH, RIM = 0.13, 0.27, 0.56, 0.14
"""Inches of the tooth drawn: half its width at tip and root, its depth, and the rim below it."""
EYE, EYE_AT = 0.15, 0.86
"""Inches: half the width of an eye, and its distance from the tooth's middle."""
MIDDLE = 0.5 * (HALF_TIP + HALF_ROOT)


def scale_bars(page: Page, px_per_mm: float, stretch: float, looks: Sequence[Look] = ()) -> None:
    """Draw the scale along and across the flanks, at the lower right of the page, and beside it from where
    they are seen."""
    width, height = page.canvas.get_width_height()
    high, inch = theme.inches(page, 1.0), theme.inches(page, 1.0) * height / width
    length = theme.round_length(1.3 * inch * width / (px_per_mm * stretch))
    across, along = length * px_per_mm * stretch, length * px_per_mm
    box = theme.place(page, 1.0 - 1.75 * inch, theme.inches(page, 0.15), 1.4 * inch, high)
    axes = theme.overlay(page, box)
    x, y = 0.0, 0.68 * box.height
    axes.plot([x, x, x + across], [y - along, y, y], color=theme.INK, linewidth=2.5, clip_on=False)
    for at, way, offset, ha, va in (
        ((x, y - 0.5 * along), "along", (-6, 0), "right", "center"),
        ((x + 0.5 * across, y), "across", (0, -5), "center", "top"),
    ):
        theme.beside(axes, at, f"{length:g} mm {way}", offset, ha=ha, va=va, fontsize=theme.SMALL)
    if looks:
        box = theme.place(page, 1.0 - 5.15 * inch, theme.inches(page, 0.15), 2.2 * inch, high)
        sketch(theme.overlay(page, box), looks, box.height)


def sketch(axes: Axes, looks: Sequence[Look], inch: float) -> None:
    """Draw a tooth in section, its tip upwards, as seen from its toe, where right flanks are on the right; an
    eye on each side from which one looks, and an arrow from it to the flank seen. Axes in pixels, from the
    top left, of which so many are an inch."""
    middle = np.array([0.5 * abs(float(np.subtract(*axes.get_xlim()))), 0.68 * inch])

    def at(points: FloatArray) -> FloatArray:
        """Give pixels (n, 2) of points (n, 2), inches to the right of the tooth's middle, over its root."""
        return np.asarray(middle + inch * points * (1.0, -1.0))

    right = np.array([[HALF_TIP, DEPTH], [MIDDLE, 0.5 * DEPTH], [HALF_ROOT, 0.0]])
    below = np.array([[2.0 * HALF_ROOT, 0.0], [2.0 * HALF_ROOT, -RIM]])
    outline = np.concatenate((right, below))
    outline = np.concatenate((outline, outline[::-1] * (-1.0, 1.0)))
    axes.add_patch(Polygon(at(outline), facecolor=theme.PALE, edgecolor="none", clip_on=False))
    top = outline[[0, 1, 2, 3, -4, -3, -2, -1, 0]]
    axes.plot(*at(top).T, color=theme.GREY, linewidth=1.0, clip_on=False)
    for flank, outside in looks:
        side = 1.0 if flank == "right" else -1.0
        axes.plot(*at(right * (side, 1.0)).T, color=theme.INK, linewidth=3.2, clip_on=False)
        eye = side if outside else -side
        start = np.array([eye * (EYE_AT - 1.3 * EYE), 0.5 * DEPTH])
        end = np.array([side * (MIDDLE + (0.04 if outside else -0.04)), 0.5 * DEPTH])
        _eye(axes, at(np.array([[eye * EYE_AT, 0.5 * DEPTH]]))[0], EYE * inch)
        line: dict[str, Any] = {"arrowstyle": "-|>", "color": theme.INK, "linewidth": 1.4}
        line |= {"shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 12.0}
        ends = at(np.stack((end, start)))
        axes.annotate("", tuple(ends[0]), tuple(ends[1]), annotation_clip=False, arrowprops=line)
    foot = at(np.array([[0.0, -RIM]]))[0]
    theme.beside(axes, foot, _words(looks), (0, -3), ha="center", va="top", fontsize=theme.SMALL)


def _eye(axes: Axes, at: FloatArray, half: float) -> None:
    """Draw an eye at a place (2,), `half` its width, all in pixels."""
    along = np.linspace(-1.0, 1.0, 31)
    lid = 0.55 * half * (1.0 - along**2)
    for side in (-1.0, 1.0):
        points = at + np.stack((half * along, side * lid), axis=-1)
        axes.plot(*points.T, color=theme.INK, linewidth=1.3, clip_on=False)
    pupil = Ellipse((float(at[0]), float(at[1])), 0.8 * half, 0.8 * half, color=theme.INK, clip_on=False)
    axes.add_patch(pupil)


def _words(looks: Sequence[Look]) -> str:
    """Say from where flanks are seen."""
    sides = {outside for _, outside in looks}
    if len(sides) > 1:
        return ", ".join(f"{flank} from {'outside' if outside else 'inside'}" for flank, outside in looks)
    flank = f"{looks[0][0]} flanks" if len(looks) == 1 else "flanks"
    return f"{flank} from {'outside' if sides.pop() else 'inside'}"
