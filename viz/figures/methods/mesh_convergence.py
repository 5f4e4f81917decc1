"""Error of the mesh method against the tolerance of its meshes, with and without the polish.

The method finds the point of one mesh with the smallest distance from the other mesh. The polish is Newton's
method on the exact flanks, started from this point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.shapes.proximity.mesh_convergence import Convergence, convergence

from ...components import annotate
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.paths_table import FLANKS
from ...rendering import theme
from ...rendering.layout import PanelRows
from .curves import log_axes

TOLERANCES_MM = np.logspace(-1.0, -4.0, 13)
PATH_FRACTIONS = (0.3, 0.4, 0.5, 0.6, 0.7)
"""Positions as fractions of the path in pinion roll."""


@dataclass(frozen=True, eq=False)
class ConvergenceFigure:
    """Errors at every position by flank and polish. `reasons`: why a flank has no result."""

    convergence: dict[tuple[str, bool], tuple[Convergence, ...]]
    reasons: dict[str, str]


def compute(design: Design) -> ConvergenceFigure:
    """Compute the errors for all tolerances and positions on both flanks."""
    results, reasons = {}, {}
    for flank in FLANKS:
        if is_line_contact(design, flank):
            reasons[flank] = "the flanks touch along lines: meshes cannot find one contact point"
            continue
        try:
            for polish in (False, True):
                results[flank, polish] = tuple(
                    convergence(design, flank, TOLERANCES_MM, polish, share=share) for share in PATH_FRACTIONS
                )
        except ValueError as error:
            reasons[flank] = str(error)
    return ConvergenceFigure(results, reasons)


def errors_of_kind(results: tuple[Convergence, ...], kind: str) -> FloatArray:
    """Return the errors (positions, tolerances) of one kind, mm."""
    return np.stack([getattr(result, f"{kind}_error") for result in results])


def draw(data: ConvergenceFigure, layout: theme.PageLayout) -> Drawing:
    """Draw a chart for each flank."""
    note = (
        "Flanks are sampled to the tolerance; the contact is the point with the smallest distance to the"
        " other mesh. The polish solves for the contact on the exact flanks from there. Lines: largest error"
        " of {poses} positions, dots: single positions."
    )
    cells = PanelRows(left=1.2, right=0.64, across=1.36, down=1.4, most=2, least=3.4)
    page, low, high = theme.new_page(
        layout,
        "Error of the mesh method against the mesh tolerance",
        finding(data),
        note.format(poses=len(PATH_FRACTIONS)) if data.convergence else "",
        below=0.75,
        above=0.5,
        tall=cells.tall(layout, len(FLANKS), 3.2),
    )
    flank_panels = zip(FLANKS, theme.panels(page, cells, len(FLANKS), low, high), strict=True)
    for column, (flank, axes) in enumerate(flank_panels):
        axes.set_title(f"({'ab'[column]})  {flank} flanks", loc="left", pad=10.0)
        if flank in data.reasons:
            axes.set_axis_off()
            theme.message(axes, data.reasons[flank], 40)
        else:
            lines = _panel(axes, data, flank)
            if (column == 0 or FLANKS[0] in data.reasons) and layout.printed:
                theme.legend(page, lines, 2)
            elif column == 0 or FLANKS[0] in data.reasons:
                axes.legend(loc="center", bbox_to_anchor=(0.5, 0.42))
    return Drawing(page, {})


def _panel(axes: Axes, data: ConvergenceFigure, flank: str) -> list[Line2D]:
    """Draw the errors (mm) of one flank at every position and their maximum; return the lines of a legend."""
    looks = {
        "point": ("contact point", theme.VERMILLION, "o"),
        "separation": ("separation", theme.BLUE, "s"),
    }
    smallest_error_mm = 1e-16
    lines = []
    for polish in (False, True):
        for kind, (name, colour, marker) in looks.items():
            errors = np.maximum(errors_of_kind(data.convergence[flank, polish], kind), smallest_error_mm)
            label = f"{name}, {'polished' if polish else 'mesh alone'}"
            face = colour if polish else "none"
            axes.plot(TOLERANCES_MM, errors.T, marker, color=colour, ms=4.0, alpha=0.45, mfc=face)
            worst = errors.max(axis=0)
            look: dict[str, Any] = {"color": colour, "marker": marker, "label": label}
            lines += axes.plot(TOLERANCES_MM, worst, "-" if polish else "--", **look)
    lines += axes.plot(
        TOLERANCES_MM, TOLERANCES_MM, color=theme.GREY, linewidth=1.2, label="the tolerance itself"
    )
    log_axes(axes)
    axes.invert_xaxis()
    axes.set_ylim(0.1 * smallest_error_mm, 1e3)
    axes.set(xlabel="tolerance of the meshes (mm)", ylabel="error (mm)")
    return lines


def finding(data: ConvergenceFigure) -> str:
    """Return the finding of the chart from the errors of each flank."""
    parts, near = [], int(np.argmin(np.abs(TOLERANCES_MM - 0.001)))
    for flank in FLANKS:
        if flank in data.reasons:
            continue
        alone, polished = (
            float(np.nanmax(errors_of_kind(data.convergence[flank, polish], "point")[:, near]))
            for polish in (False, True)
        )
        parts.append(
            f"{flank} flanks {alone:.2g}\u00a0mm off, polished {annotate.power_of_ten(polished)}\u00a0mm"
        )
    return (
        f"Contact point at a tolerance of {TOLERANCES_MM[near]:.3g} mm: {'; '.join(parts)}" if parts else ""
    )


def rows(data: ConvergenceFigure) -> Table:
    """List the errors at every tolerance and position."""
    setting = ("flank", "polished", "share_of_path", "tolerance_mm", "triangles")
    header = (*setting, "contact_point_error_mm", "separation_error_mm")

    def cases() -> Rows:
        """Yield the columns of every position."""
        for (flank, polish), results in data.convergence.items():
            for share, result in zip(PATH_FRACTIONS, results, strict=True):
                errors = result.point_error, result.separation_error
                yield flank, polish, share, result.tolerance, result.faces, *errors

    return header, rows_of_cases(cases())


RECIPES = {"mesh-convergence": Recipe(compute, draw, rows)}
