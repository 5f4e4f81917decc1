"""Transmission error of the pair in operation, with its amplitudes at the mesh frequency's multiples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport, operation_report

from ...parts import charts
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import MODIFIED
from ...stage import theme

FLANK = "right"
CASES: tuple[tuple[str, tuple[float, float] | None], ...] = (
    ("as designed", None),
    ("$a_1$ = \u2212$a_2$ = 0.001 mm$^{-1}$", MODIFIED),
    ("$a_1$ = $a_2$ = 0.0002 mm$^{-1}$", (0.0002, 0.0002)),
)
POINTS = 361
"""Rolls of one mesh cycle."""
PITCHES = 3
HARMONICS = 10
NOTE = (
    "Rigid teeth without load: at each position the first of all teeth touches, with its flank or an edge"
    " (tip, toe, heel). The error is gear roll plus N1/N2 pinion roll, less that of the unmodified pair"
    " without errors and less its mean; it repeats with the pinion's pitch. Dots: another tooth pair takes"
    " over. The operating contact ratio is the roll over which one pair touches, over the pitch, and in"
    f" brackets that over which it is within {1e3 * MARKING_SEPARATION:g} \u00b5m of touching; Eq. 16"
    " knows the limits of one tooth pair only."
)


@dataclass(frozen=True, eq=False)
class Case:
    """One case by its name: its mesh cycle, None with the `reason` where that is not known."""

    name: str
    report: OperationReport | None
    reason: str = ""


def compute(design: Design) -> tuple[Case, ...]:
    """Find the mesh cycle of every case."""
    cases = []
    for name, parabola in CASES:
        changed = design.with_parabola(*parabola) if parabola else design
        report, reason = None, first_contact_fault(changed)
        if not reason:
            report = operation_report("", changed, FLANK, POINTS, HARMONICS, MARKING_SEPARATION)
            reason = report.reason
        cases.append(Case(name, None if reason else report, reason or ""))
    return tuple(cases)


def draw(data: tuple[Case, ...], layout: theme.Layout) -> Drawing:
    """Draw a row for each case: the curve, and its amplitudes."""
    page, low, high = theme.new_page(
        layout,
        "Transmission error in operation, hand-over between tooth pairs included",
        f"{FLANK.capitalize()} flanks, the pinion drives; {PITCHES} mesh cycles, and the amplitudes at"
        " multiples of the mesh frequency",
        NOTE,
        below=0.65,
        above=0.4,
    )
    bottoms, height = theme.rows(low, high, len(data), theme.inches(page, 0.95))
    for row, (case, bottom) in enumerate(zip(data, bottoms, strict=True)):
        curve = page.add_axes((0.075, bottom, 0.555, height))
        bars = page.add_axes((0.72, bottom, 0.265, height))
        curve.set_title(f"({'abc'[row]})  {case.name}", loc="left", pad=8.0)
        if case.report is None:
            theme.say(curve, case.reason, 60)
        else:
            charts.error_over_rolls(curve, case.report, PITCHES)
            _say_ratios(curve, case.report)
            charts.amplitudes(bars, case.report)
            if row == 0:
                curve.legend(loc="upper right", ncols=3)
        if row < len(data) - 1:
            curve.set_xlabel("")
            bars.set_xlabel("")
    return Drawing(page, {})


def _say_ratios(axes: Axes, report: OperationReport) -> None:
    """Say the contact ratios, how far the curve swings and what edges carry, with room for these words."""
    ratios = f"operating {report.operating:.3f} ({report.within_film:.3f})"
    summary = f"contact ratio by Eq. 16 {report.eq16:.3f}, {ratios}"
    axes.set_title(summary, loc="right", pad=8.0, fontsize=theme.SMALL)
    swing = ARCSEC * float(report.cycle.peak_to_peak)
    if swing < charts.SMALLEST:
        return
    axes.set_ylim(bottom=axes.get_ylim()[0] - 0.2 * swing)
    edges = list(dict.fromkeys(name for name in report.carriers if not name.startswith("flanks")))
    words = f" ({', '.join(edges)})" if edges else ""
    share = f"edges carry {100.0 * float(report.cycle.edge_share):.3g} % of the cycle{words}"
    text = f"peak to peak {swing:.3g} arcsec; {share}"
    axes.text(0.01, 0.03, text, transform=axes.transAxes, fontsize=theme.SMALL, va="bottom")


def rows(data: tuple[Case, ...]) -> Table:
    """List the curve over one cycle, then the amplitudes."""
    header = ("case", "kind", "pitches_or_multiple", "error_or_amplitude_rad", "carried_by", "tooth_pair")

    def cases() -> Rows:
        """Give the columns of every case."""
        for case in data:
            name, report = case.name.replace("$", ""), case.report
            if report is None:
                yield name, case.reason, "", "", "", ""
                continue
            first, share = report.first, np.linspace(0.0, 1.0, POINTS)
            yield name, "error", share, first.transmission_error, report.carriers, first.pair
            amplitudes = np.abs(report.cycle.harmonics)
            yield name, "amplitude", 1 + np.arange(amplitudes.size), amplitudes, "", ""

    return header, stacked(cases())


RECIPES = {"transmission-error": Recipe(compute, draw, rows)}
