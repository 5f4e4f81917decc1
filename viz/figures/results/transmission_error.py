"""Transmission error of the pair in operation, with its amplitudes at the mesh frequency's multiples."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Design
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.report.operation import OperationReport, operation_report

from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.scene import Size

FLANK = "right"
CASES: tuple[tuple[str, tuple[float, float] | None], ...] = (
    ("as designed", None),
    ("$a_1$ = \u2212$a_2$ = 0.001 mm$^{-1}$", (0.001, -0.001)),
    ("$a_1$ = $a_2$ = 0.0002 mm$^{-1}$", (0.0002, 0.0002)),
)
POINTS = 361
"""Rolls of one mesh cycle."""
PITCHES = 3
HARMONICS = 10
FILM = 0.00635
"""mm: thickness of marking compound."""
ARCSEC = 3600.0 * 180.0 / np.pi
SMALLEST = 1e-6
"""arcsec: below it a curve counts as zero."""
NOTE = (
    "Rigid teeth without load: at each position the first of all teeth touches, with its flank or an edge"
    " (tip, toe, heel). The error is gear roll plus N1/N2 pinion roll, less that of the unmodified pair"
    " without errors and less its mean; it repeats with the pinion's pitch. Dots: another tooth pair takes"
    " over. The operating contact ratio is the roll over which one pair touches, over the pitch, and in"
    f" brackets that over which it is within {1e3 * FILM:g} \u00b5m of touching; Eq. 16 knows the limits of"
    " one tooth pair only."
)


@dataclass(frozen=True, eq=False)
class Case:
    """One case by its name: its mesh cycle, None with the `reason` where that is not known."""

    name: str
    report: OperationReport | None
    reason: str = ""


def compute(design: Design) -> tuple[Case, ...]:
    """The mesh cycle of every case."""
    cases = []
    for name, parabola in CASES:
        changed = design if parabola is None else design.with_parabola(*parabola)
        fault = first_contact_fault(changed)
        if fault:
            cases.append(Case(name, None, fault))
            continue
        report = operation_report("", changed, FLANK, POINTS, HARMONICS, FILM)
        cases.append(Case(name, None if report.reason else report, report.reason or ""))
    return tuple(cases)


def draw(data: tuple[Case, ...], size: Size) -> Drawing:
    """A row for each case: the curve, and its amplitudes."""
    page = theme.new_page(
        size,
        "Transmission error in operation, hand-over between tooth pairs included",
        f"{FLANK.capitalize()} flanks, the pinion drives; {PITCHES} mesh cycles, and the amplitudes at"
        " multiples of the mesh frequency",
    )
    low = theme.caption(page, NOTE) + theme.inches(page, 0.65)
    gap = theme.inches(page, 0.95)
    high = theme.top(page) - theme.inches(page, 0.4)
    height = (high - low - gap * (len(data) - 1)) / len(data)
    for row, case in enumerate(data):
        bottom = high - height - row * (height + gap)
        curve = page.add_axes((0.075, bottom, 0.555, height))
        bars = page.add_axes((0.72, bottom, 0.265, height))
        _curve(curve, case, row)
        _bars(bars, case)
        if row == len(data) - 1:
            curve.set_xlabel("pinion roll from the pitch point (pitches)")
            bars.set_xlabel("multiple of the mesh frequency")
    return Drawing(page, {})


def _curve(axes: Axes, case: Case, row: int) -> None:
    axes.set_title(f"({'abc'[row]})  {case.name}", loc="left", pad=8.0)
    axes.set_ylabel("error (arcsec)")
    axes.grid(True)
    axes.set_xlim(0.0, PITCHES)
    report = case.report
    if report is None:
        text = textwrap.fill(case.reason, 60)
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center")
        return
    ratios = f"operating {report.operating:.3f} ({report.within_film:.3f})"
    summary = f"contact ratio by Eq. 16 {report.eq16:.3f}, {ratios}"
    axes.set_title(summary, loc="right", pad=8.0, fontsize=theme.SMALL)
    cycle, edge = report.cycle, np.tile(report.first.limit[:, 0] >= 0, PITCHES)
    error = np.tile(ARCSEC * (report.first.transmission_error - float(cycle.mean)), PITCHES)
    share = np.concatenate([np.linspace(0.0, 1.0, POINTS) + pitch for pitch in range(PITCHES)])
    axes.plot(share, np.where(edge, np.nan, error), color=theme.BLUE, label="flank on flank")
    axes.plot(share, np.where(edge, error, np.nan), color=theme.RED, label="edge contact")
    changes = (cycle.changes[cycle.hand_over] - float(cycle.start)) / cycle.pitch
    at = np.concatenate([changes + pitch for pitch in range(PITCHES)])
    axes.plot(at, np.interp(at, share, error), "o", color=theme.INK, ms=6.0, label="hand-over")
    _say_swing(axes, report, error)
    if row == 0:
        axes.legend(loc="upper right", ncols=3)


def _say_swing(axes: Axes, report: OperationReport, error: FloatArray) -> None:
    """How far the curve swings and what edges carry, with room for these words below it."""
    swing = ARCSEC * float(report.cycle.peak_to_peak)
    if swing < SMALLEST:
        axes.set_ylim(-1.0, 1.0)
        text = f"peak to peak under {SMALLEST:g} arcsec: zero but for rounding"
        axes.text(1.5, 0.25, text, ha="center", va="center")
        return
    axes.set_ylim(float(error.min()) - 0.32 * swing, float(error.max()) + 0.12 * swing)
    edges = list(dict.fromkeys(name for name in report.carriers if not name.startswith("flanks")))
    words = f" ({', '.join(edges)})" if edges else ""
    share = f"edges carry {100.0 * float(report.cycle.edge_share):.3g} % of the cycle{words}"
    text = f"peak to peak {swing:.3g} arcsec; {share}"
    axes.text(0.01, 0.03, text, transform=axes.transAxes, fontsize=theme.SMALL, va="bottom")


def _bars(axes: Axes, case: Case) -> None:
    axes.set_ylabel("amplitude (arcsec)")
    axes.set_xticks(np.arange(1, HARMONICS + 1))
    axes.set_axisbelow(True)
    axes.grid(True, axis="y")
    if case.report is None:
        return
    amplitude = ARCSEC * np.abs(case.report.cycle.harmonics)
    axes.bar(np.arange(1, HARMONICS + 1), amplitude, width=0.6, color=theme.BLUE)
    if amplitude.max() < SMALLEST:
        axes.set_ylim(0.0, 1.0)
        axes.text(0.5, 0.5, "all zero", transform=axes.transAxes, ha="center", va="center")


def rows(data: tuple[Case, ...]) -> Table:
    """The curve over one cycle, then the amplitudes."""
    header = ("case", "kind", "pitches_or_multiple", "error_or_amplitude_rad", "carried_by", "tooth_pair")

    def body() -> Iterator[list[object]]:
        for case in data:
            name, report = case.name.replace("$", ""), case.report
            if report is None:
                yield [name, case.reason, "", "", "", ""]
                continue
            first, share = report.first, np.linspace(0.0, 1.0, POINTS).tolist()
            columns = (share, first.transmission_error.tolist(), report.carriers, first.pair.tolist())
            for values in zip(*columns, strict=True):
                yield [name, "error", *values]
            for order, amplitude in enumerate(np.abs(report.cycle.harmonics).tolist(), start=1):
                yield [name, "amplitude", order, amplitude, "", ""]

    return header, body()


RECIPES = {"transmission-error": Recipe(compute, draw, rows)}
