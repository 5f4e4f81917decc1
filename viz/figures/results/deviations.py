"""Measured points of both flanks of a tooth: the grid as it is to be, and as it was found."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.report.columns import header_of
from beveloid_geom.report.workshop.grid import SHAPE, DeviationReport

from ...parts.map_panel import HALO
from ...parts.recipe import Drawing, Recipe, Table, stacked
from ...stage import theme
from ...stage.layout import Cells

CELLS = Cells(left=0.5, right=0.5, across=0.4, down=1.3, most=2, least=5.5)
SHEAR, RISE, HIGH = 0.35, 1.0, 0.45
"""In half faces: how far the tip is drawn to the right of the root and above it, and how high the greatest
deviation of both flanks."""
FEW = 11, 5
"""Columns and rows of a flank of which all points have their number, unless in print; of more those at the
corners, the least and the greatest have one."""
NOTE = (
    "Grey: the grid as it is to be, tip behind, toe on the left. Blue: as measured, with the deviation along"
    " the normal drawn upwards where there is too much metal, at one scale for both flanks, its bar; red"
    " where there is too little. Numbers in \u00b5m. Below each flank the surface of second order nearest to"
    " its deviations, over the grid from toe to heel and from root to tip, both \u22121 to 1, and the root"
    " mean square of what it leaves."
)


def compute(report: DeviationReport) -> DeviationReport:
    """Give what was read and found already."""
    return report


def draw(report: DeviationReport, layout: theme.Layout) -> Drawing:
    """Draw a panel for each flank."""
    found, named = report.found, report.named
    thickness, teeth = theme.signed(1e3 * found.thickness, 1), int(found.grid.member.teeth)
    page, low, high = theme.new_page(
        layout,
        "Deviations of measured points from the flanks",
        f"{named.member.capitalize()}, {teeth} teeth; normal thickness {thickness} \u00b5m off in the mean",
        NOTE,
        below=1.15,
        above=0.4,
        tall=CELLS.tall(layout, len(FLANK_SIGN), 4.6),
    )
    greatest = max(1e3 * float(np.abs(found.deviation).max()), 1e-3)
    panels = theme.panels(page, CELLS, len(FLANK_SIGN), low, high)
    for letter, axes, flank, values in zip("ab", panels, FLANK_SIGN, found.deviation, strict=True):
        axes.set_axis_off()
        axes.set_title(f"({letter})  {flank.capitalize()} flank", loc="left")
        _grid(axes, 1e3 * values, greatest, not layout.printed)
        own = {name: theme.signed(1e3 * size, 1) for name, size in vars(report.second_order[flank]).items()}
        lines = [
            f"{words} {own[name].lstrip('+') if name == 'rest' else own[name]}"
            for name, words in SHAPE.items()
        ]
        words = "\n".join(", ".join(lines[k : k + 2]) for k in range(0, len(lines), 2))
        axes.text(0.0, -0.03, words, transform=axes.transAxes, va="top", fontsize=theme.SMALL)
    limits = np.array([axes.get_ylim() for axes in panels])
    for axes in panels:
        axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())  # one scale for both flanks
    return Drawing(page, {})


def _grid(axes: Axes, values: FloatArray, greatest: float, every: bool) -> None:
    """Draw deviations (rows, columns), um, over the plane of zero; `greatest` is HIGH half faces.
    `every` point has its number, if they are FEW."""
    rows, columns = values.shape
    face, profile = np.meshgrid(np.linspace(-1.0, 1.0, columns), np.linspace(-1.0, 1.0, rows))
    plane = np.stack((face + SHEAR * profile, RISE * profile), axis=-1)
    found = plane + np.stack((np.zeros_like(values), HIGH / greatest * values), axis=-1)
    for points, colour, width in ((plane, theme.GREY, 0.8), (found, theme.BLUE, 1.6)):
        for line in (*points, *np.moveaxis(points, 1, 0)):
            axes.plot(*line.T, color=colour, linewidth=width, zorder=2.0 if points is found else 1.0)
    for foot, top, value in zip(plane.reshape(-1, 2), found.reshape(-1, 2), values.ravel(), strict=True):
        colour = theme.BLUE if value > 0.0 else theme.RED
        axes.plot(*np.array((foot, top)).T, color=colour, linewidth=2.4, zorder=3.0, solid_capstyle="butt")
    _numbers(axes, values, found, every)
    length, right = theme.round_length(greatest), 1.0 + SHEAR + 0.25
    low, high = min(float(found[..., 1].min()), -RISE), max(float(found[..., 1].max()), RISE)
    axes.plot([right, right], [-RISE, -RISE + HIGH * length / greatest], color=theme.INK, linewidth=3.0)
    style: dict[str, Any] = {"ha": "center", "fontsize": theme.SMALL}
    theme.beside(axes, (right, -RISE), f"{length:g} \u00b5m", (0.0, -4.0), va="top", **style)
    sides = (
        ("toe", (-1.3, 0.0)),
        ("heel", (1.32, 0.0)),
        ("root", (-SHEAR, low - 0.3)),
        ("tip", (SHEAR, high + 0.3)),
    )
    for word, at in sides:
        axes.text(*at, word, va="center", color=theme.GREY, **style)
    axes.set(xlim=(-1.6, 1.85), ylim=(low - 0.4, high + 0.4))


def _numbers(axes: Axes, values: FloatArray, found: FloatArray, every: bool) -> None:
    """Write deviations beside their points, those of `every` one or of the corners, least and greatest."""
    shown = np.full(values.shape, every and values.shape[1] <= FEW[0] and len(values) <= FEW[1])
    shown[:: len(values) - 1, :: values.shape[1] - 1] = True
    shown.ravel()[[values.argmin(), values.argmax()]] = True
    for row, column in np.argwhere(shown):
        value = float(values[row, column])
        side, away = ("bottom", 2.0) if value >= 0.0 else ("top", -2.0)
        style: dict[str, Any] = {"ha": "center", "va": side, "fontsize": theme.SMALL, "zorder": 5.0}
        text = theme.beside(axes, found[row, column], theme.signed(value, 1), (0.0, away), **style)
        text.set_path_effects(HALO)


def rows(report: DeviationReport) -> Table:
    """List the points with their deviations."""
    columns = report.rows()
    return [header_of(name) for name in columns], stacked([list(columns.values())])


RECIPES = {"deviations": Recipe(compute, draw, rows)}
