"""Sliding speed and specific sliding along the path of contact, on both flanks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design, Status
from beveloid_geom.report.columns import header_of
from beveloid_geom.report.sliding import SlidingReport, sliding_report

from ...parts import charts
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, PARABOLAS, REASONS, coefficients, modified, parabolas
from ...stage import theme
from ...stage.layout import Cells

STYLES = ("-", "--")
"""Lines of the design as it is, and with the paper's modification."""
POINTS = 201
HEAD = 1.1
"""Times the greatest speed to which scales reach."""
CELLS = Cells(left=1.04, right=0.24, across=1.28, down=0.65, most=2, least=3.6)
NOTE = (
    "Speeds are per unit of the pinion's speed: times rad/s they are in mm/s. Thin lines, as designed: the"
    " sizes of its components along the pinion's tooth trace and square to it. Dots: least speed. Specific"
    " sliding is the sliding square to the tooth trace over the same component of the speed of the member's"
    " transverse profile, on parallel axes that of DIN 3960 and ISO 21771. The flanks of crossed gears slide"
    " along the trace everywhere: the least speed is not zero, and need not be at the pitch point. The path"
    " enters on the left. Dotted: where the path as designed comes nearest to the pitch point."
)


@dataclass(frozen=True, eq=False)
class Curve:
    """One case on one flank: its name, line style, and what was found."""

    name: str
    style: str
    report: SlidingReport

    @property
    def found(self) -> bool:
        """Whether there is a path to draw."""
        return self.report.reason is None


def compute(design: Design) -> dict[str, tuple[Curve, ...]]:
    """Find sliding of every case on either flank."""
    bent = modified(design)
    changed = list(zip(("as designed", coefficients(bent)), STYLES, (design, bent), strict=True))
    return {
        side: tuple(Curve(name, style, sliding_report("", one, side, POINTS)) for name, style, one in changed)
        for side in FLANKS
    }


def draw(data: dict[str, tuple[Curve, ...]], layout: theme.Layout) -> Drawing:
    """Draw a column for each flank: speed above, specific sliding below."""
    cells = replace(CELLS, down=1.0) if layout.printed else CELLS
    page, low, high = theme.new_page(
        layout,
        "Sliding along the path of contact",
        "Sliding speed of the flanks, and specific sliding of pinion and gear; the pinion drives",
        NOTE,
        below=0.6,
        above=0.75,
        tall=cells.tall(layout, 4, 3.1),
    )
    panels = theme.panels(page, cells, 4, low, high)
    beside = cells.columns(layout, 4) == 2
    columns = []
    for column, (flank, curves) in enumerate(data.items()):
        speed, specific = panels[column::2] if beside else panels[2 * column : 2 * column + 2]
        specific.sharex(speed)
        speed.set_title(f"({'ab'[column]})  {flank.capitalize()} flanks", loc="left", pad=8.0)
        specific.set_xlabel("pinion roll (deg)")
        if any(curve.found for curve in curves):
            _panels(speed, specific, curves)
            columns.append((speed, specific))
        else:
            for axes in (speed, specific):
                theme.say(axes, f"no path on the flanks: {curves[0].report.reason}", 46)
    for row in range(2 if columns else 0):
        limits = np.array([pair[row].get_ylim() for pair in columns])
        for pair in columns:
            pair[row].set_ylim(limits[:, 0].min(), limits[:, 1].max())  # one scale for both flanks
    theme.legend(page, _legend(columns), 6, 1.15, fontsize=theme.SMALL)
    return Drawing(page, {})


def _legend(columns: list[tuple[Axes, Axes]]) -> list[Line2D]:
    """Give the lines with a name, each name once."""
    named = {str(line.get_label()): line for pair in columns for axes in pair for line in axes.lines}
    return [line for name, line in named.items() if not name.startswith("_")]


def _panels(speed: Axes, specific: Axes, curves: tuple[Curve, ...]) -> None:
    """Draw all cases of a flank; the parts of the speed of the first that is found."""
    first = next(curve for curve in curves if curve.found)
    for curve in curves:
        ends = curve.report.path.ends
        if not curve.found:
            reason = REASONS.get(Status(int(ends.status)), "no path")
            speed.plot([], [], curve.style, color=theme.INK, label=f"{curve.name}: {reason}")
            continue
        charts.sliding_speed(speed, curve.report, curve.name, curve.style, curve is first)
        charts.specific_sliding(specific, curve.report, curve.style, curve is first)
    speed.set_ylim(0.0, HEAD * max(curve.report.ranges["speed"][1] for curve in curves if curve.found))


def rows(data: dict[str, tuple[Curve, ...]]) -> Table:
    """List every position of every case; a case without contact in one row that says so."""
    names = tuple(next(iter(data.values()))[0].report.columns)
    header = (*PARABOLAS, "flank", *(header_of(name) for name in names), "reason")

    def cases() -> Rows:
        """Give the columns of every curve."""
        for curve in chain(*data.values()):
            case = *parabolas(curve.report.path.design), curve.report.path.flank
            if not curve.found:
                yield *case, *[""] * len(names), curve.report.reason
            yield *case, *curve.report.columns.values(), ""

    return header, stacked(cases())


RECIPES = {"sliding": Recipe(compute, draw, rows)}
