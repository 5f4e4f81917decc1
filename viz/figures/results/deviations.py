"""Deviations of measured points on both flanks of a tooth: nominal and measured grid."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.design.ends import end_names
from beveloid_geom.report.columns import header_of
from beveloid_geom.report.workshop.grid import SHAPE_LABELS, DeviationReport

from ...components.figure_steps import Drawing, Recipe, Table, rows_of_cases
from ...rendering import theme
from ...rendering.layout import PanelRows

MOST_COLUMNS, MOST_ROWS = 11, 5
"""Largest numbers of columns and rows for which every point has a label. Otherwise, and in print, the
corners, the minimum and the maximum have one."""


def compute(report: DeviationReport) -> DeviationReport:
    """Return the report, which is computed when the file is read."""
    return report


def draw(report: DeviationReport, layout: theme.PageLayout) -> Drawing:
    """Draw a panel for each flank."""
    cells = PanelRows(left=0.5, right=0.5, across=0.4, down=1.3, most=2, least=5.5)
    deviations, named = report.result, report.named
    thickness, teeth = theme.signed(1e3 * deviations.thickness, 1), int(deviations.grid.member.teeth)
    page, low, high = theme.new_page(
        layout,
        "Deviations of measured points from the flanks",
        f"{named.member.capitalize()}, {teeth} teeth; mean deviation of the normal thickness"
        f" {thickness} \u00b5m",
        (
            "Grey: nominal grid, tip at the back, \u2212z on the left. Deviation along the normal, drawn"
            " upwards: blue for excess, orange for missing metal, \u00b5m. One scale for both flanks. Below:"
            " fitted surface of second order, with face and profile of the measured grid from \u22121 to 1,"
            " and the root mean square of the residual."
        ),
        below=1.15,
        above=0.4,
        tall=cells.tall(layout, len(FLANK_SIGN), 4.6),
    )
    greatest = max(1e3 * float(np.abs(deviations.deviation).max()), 1e-3)
    panels = theme.panels(page, cells, len(FLANK_SIGN), low, high)
    for letter, axes, flank, values in zip("ab", panels, FLANK_SIGN, deviations.deviation, strict=True):
        axes.set_axis_off()
        axes.set_title(f"({letter})  {flank.capitalize()} flank", loc="left")
        _grid(axes, 1e3 * values, end_names(deviations.grid.member), greatest, not layout.printed)
        sizes = {name: theme.signed(1e3 * mm, 1) for name, mm in vars(report.second_order[flank]).items()}
        sizes["rest"] = sizes["rest"].lstrip("+")
        lines = [f"{words} {sizes[name]}" for name, words in SHAPE_LABELS.items()]
        words = "\n".join(", ".join(lines[k : k + 2]) for k in range(0, len(lines), 2))
        axes.text(0.0, -0.03, words, transform=axes.transAxes, va="top", fontsize=theme.SMALL)
    limits = np.array([axes.get_ylim() for axes in panels])
    for axes in panels:
        axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())  # one scale for both flanks
    return Drawing(page, {})


def _grid(axes: Axes, values: FloatArray, ends: tuple[str, str], greatest: float, every: bool) -> None:
    """Draw deviations (rows, columns), um, over the nominal plane, and label the `ends` of the face.

    `greatest` is the largest deviation of both flanks. With `every`, all points are labelled if there are
    few."""
    # Lengths in half face widths: displacement of the tip to the right of the root and above it, and
    # height of the largest deviation of both flanks, which leaves space for its number below the next row.
    tip_shift, tip_height = 0.35, 1.0
    rows, columns = values.shape
    largest_height = 0.45 if rows > MOST_ROWS else min(0.45, 1.2 * tip_height / (rows - 1))
    face, profile = np.meshgrid(np.linspace(-1.0, 1.0, columns), np.linspace(-1.0, 1.0, rows))
    plane = np.stack((face + tip_shift * profile, tip_height * profile), axis=-1)
    surface = plane + np.stack((np.zeros_like(values), largest_height / greatest * values), axis=-1)
    for points, colour, width in ((plane, theme.GREY, 0.8), (surface, theme.BLUE, 1.6)):
        for line in (*points, *np.moveaxis(points, 1, 0)):
            axes.plot(*line.T, color=colour, linewidth=width, zorder=2.0 if points is surface else 1.0)
    for foot, top, value in zip(plane.reshape(-1, 2), surface.reshape(-1, 2), values.ravel(), strict=True):
        colour = theme.BLUE if value > 0.0 else theme.VERMILLION
        axes.plot(*np.array((foot, top)).T, color=colour, linewidth=2.4, zorder=3.0, solid_capstyle="butt")
    _numbers(axes, values, surface, every)
    length, right = theme.round_length(greatest), 1.0 + tip_shift + 0.25
    low = min(float(surface[..., 1].min()), -tip_height)
    high = max(float(surface[..., 1].max()), tip_height)
    bar = [-tip_height, -tip_height + largest_height * length / greatest]
    axes.plot([right, right], bar, color=theme.INK, linewidth=3.0)
    style: dict[str, Any] = {"ha": "center", "fontsize": theme.SMALL}
    theme.label_point(axes, (right, -tip_height), f"{length:g} \u00b5m", (0.0, -4.0), va="top", **style)
    sides = (
        (ends[0], (-1.47, 0.0)),
        (ends[1], (1.47, 0.0)),
        ("root", (-tip_shift, low - 0.3)),
        ("tip", (tip_shift, high + 0.3)),
    )
    for word, at in sides:
        axes.text(*at, word, va="center", color=theme.GREY, **style)
    axes.set(xlim=(-1.6, 1.85), ylim=(low - 0.4, high + 0.4))


def _numbers(axes: Axes, values: FloatArray, ends: FloatArray, every: bool) -> None:
    """Write deviations next to their points: with `every` at all points, or in every second column if the
    numbers are long; else at corners, minimum and maximum."""
    every = every and values.shape[1] <= MOST_COLUMNS and len(values) <= MOST_ROWS
    longest = max(len(theme.signed(float(value), 1)) for value in values.ravel())
    shown = np.zeros(values.shape, dtype=bool)
    shown[:, :: 2 if longest * values.shape[1] > 40 else 1] = every
    shown[:: len(values) - 1, :: values.shape[1] - 1] = True
    written = values.round(1)  # of equal numbers, the first is the minimum or maximum
    shown.ravel()[[written.argmin(), written.argmax()]] = True
    for row, column in np.argwhere(shown):
        value = float(values[row, column])
        side, away = ("bottom", 2.0) if value >= 0.0 else ("top", -2.0)
        style: dict[str, Any] = {"ha": "center", "va": side, "fontsize": theme.SMALL, "zorder": 5.0}
        style["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}  # hides lines of the grid
        theme.label_point(axes, ends[row, column], theme.signed(value, 1), (0.0, away), **style)


def rows(report: DeviationReport) -> Table:
    """List the points with their deviations."""
    columns = report.rows()
    return [header_of(name) for name in columns], rows_of_cases([list(columns.values())])


RECIPES = {"deviations": Recipe(compute, draw, rows)}
