"""Sliding speed and specific sliding along the path of contact, on both flanks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design, Status
from beveloid_geom.report.columns import header_of
from beveloid_geom.report.sliding import SlidingReport, sliding_report

from ...components import charts
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.paths_table import FLANKS, PARABOLAS, REASONS, coefficients, paper_modified, parabolas
from ...rendering import theme
from ...rendering.layout import PanelRows


@dataclass(frozen=True, eq=False)
class SlidingCurve:
    """One case on one flank: name, line style and result."""

    name: str
    style: str
    report: SlidingReport

    @property
    def has_path(self) -> bool:
        """Whether there is a path to draw."""
        return self.report.reason is None


def compute(design: Design) -> dict[str, tuple[SlidingCurve, ...]]:
    """Compute the sliding of every case on both flanks."""
    # Line styles of the design and of the design with the paper's modification.
    line_styles = ("-", "--")
    bent = paper_modified(design)
    changed = list(zip(("as designed", coefficients(bent)), line_styles, (design, bent), strict=True))
    return {
        side: tuple(
            SlidingCurve(name, style, sliding_report("", one, side, 201)) for name, style, one in changed
        )
        for side in FLANKS
    }


def draw(data: dict[str, tuple[SlidingCurve, ...]], layout: theme.PageLayout) -> Drawing:
    """Draw a column for each flank: speed above, specific sliding below."""
    note = (
        "Speeds times the pinion speed in rad/s are in mm/s. Thin lines: components"
        " along the tooth trace of the pinion and perpendicular to it, as designed. Dots: minimum."
        " Specific sliding perpendicular to the trace; on parallel axes as in ISO 21771. The path"
        " enters on the left. Dotted: closest to the"
    )
    cells = PanelRows(left=1.04, right=0.24, across=1.28, down=0.65, most=2, least=3.6)
    if layout.printed:
        cells = replace(cells, down=1.0)
    page, low, high = theme.new_page(
        layout,
        "Sliding along the path of contact",
        "Sliding speed of the flanks, and specific sliding of pinion and gear; the pinion drives",
        f"{note} {data[FLANKS[0]][0].report.pitch_name}.",
        below=0.6,
        above=0.75,
        tall=cells.tall(layout, 4, 3.1),
    )
    panels = theme.panels(page, cells, 4, low, high)
    side_by_side = cells.columns(layout, 4) == 2
    columns = []
    for column, (flank, curves) in enumerate(data.items()):
        speed, specific = panels[column::2] if side_by_side else panels[2 * column : 2 * column + 2]
        specific.sharex(speed)
        speed.set_title(f"({'ab'[column]})  {flank.capitalize()} flanks", loc="left", pad=8.0)
        specific.set_xlabel("pinion roll (deg)")
        if any(curve.has_path for curve in curves):
            _panels(speed, specific, curves)
            columns.append((speed, specific))
        else:
            for axes in (speed, specific):
                theme.message(axes, f"no path on the flanks: {curves[0].report.reason}", 46)
    for row in range(2 if columns else 0):
        limits = np.array([pair[row].get_ylim() for pair in columns])
        for pair in columns:
            pair[row].set_ylim(limits[:, 0].min(), limits[:, 1].max())  # one scale for both flanks
    size: dict[str, Any] = {} if layout.printed else {"fontsize": theme.SMALL}
    theme.legend(page, _legend(columns), 6, 1.15, **size)
    return Drawing(page, {})


def _legend(columns: list[tuple[Axes, Axes]]) -> list[Line2D]:
    """Return the lines of the legend, each name once."""
    named = {str(line.get_label()): line for pair in columns for axes in pair for line in axes.lines}
    return [line for name, line in named.items() if not name.startswith("_")]


def _panels(speed: Axes, specific: Axes, curves: tuple[SlidingCurve, ...]) -> None:
    """Draw all cases of a flank, and the components of the speed of the first case with a path."""
    # Upper limit of the scales as a multiple of the largest speed.
    scale_limit_factor = 1.1
    first = next(curve for curve in curves if curve.has_path)
    for curve in curves:
        ends = curve.report.path.ends
        if not curve.has_path:
            reason = REASONS.get(Status(int(ends.status)), "no path")
            speed.plot([], [], curve.style, color=theme.INK, label=f"{curve.name}: {reason}")
            continue
        charts.sliding_speed(speed, curve.report, curve.name, curve.style, curve is first)
        charts.specific_sliding(specific, curve.report, curve.style, curve is first)
    speed.set_ylim(
        0.0, scale_limit_factor * max(curve.report.ranges["speed"][1] for curve in curves if curve.has_path)
    )


def rows(data: dict[str, tuple[SlidingCurve, ...]]) -> Table:
    """List every position of every case; a case without contact has one row with the reason."""
    names = tuple(next(iter(data.values()))[0].report.columns)
    header = (*PARABOLAS, "flank", *(header_of(name) for name in names), "reason")

    def cases() -> Rows:
        """Yield the columns of every curve."""
        for curve in chain(*data.values()):
            path = curve.report.path
            case = *parabolas(path.design, path.flank), path.flank
            if not curve.has_path:
                yield *case, *[""] * len(names), curve.report.reason
            yield *case, *curve.report.columns.values(), ""

    return header, rows_of_cases(cases())


RECIPES = {"sliding": Recipe(compute, draw, rows)}
