"""The motion graph: the transmission error of every tooth pair alone, and that of the pair that runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import first_contact
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.status import FirstStatus

from ..stage import theme
from .charts import SMALLEST
from .solved import ratio_words

REACH, STEPS = 3, 64
"""Pitches to either side over which a tooth pair is followed, and rolls of a pitch."""
SHOWN = 2
"""Pitches drawn."""
WIDE = 4.5
"""Points of a line where an edge runs: wider, so as to be told without colours, too."""
MICRO = 1e6


@dataclass(frozen=True, eq=False)
class MotionGraph:
    """The transmission error (n,), rad, of one tooth pair `alone` over `pitches` (n,) of pinion roll from the
    pitch point, NaN where it touches nothing; whether an edge touches (n,); and that of all, in `report`. All
    tooth pairs are alike: another has the same curve whole pitches on."""

    report: OperationReport
    pitches: FloatArray
    alone: FloatArray
    edge: Mask

    @property
    def mean(self) -> float:
        """Mean of what runs, rad, from which errors are counted."""
        return float(self.report.cycle.mean)

    @property
    def pitch_radius(self) -> float:
        """Working pitch radius of the gear, mm."""
        return float(mounting_of(self.report.design).working_radius[1])

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest error drawn, rad: what runs, and as much beside it as marking compound is thick,
        or as it swings if that is more, on the side where tooth pairs stand off."""
        runs = self.report.first.transmission_error - self.mean
        low, high = float(runs.min()), float(runs.max())
        deep = max(MARKING_SEPARATION / self.pitch_radius, 1.2 * (high - low))
        known = self.alone[np.isfinite(self.alone)] - self.mean
        above = known.max() - high > low - known.min()
        spare = 0.12 * deep
        return (low - spare, high + deep) if above else (low - deep, high + spare)


def motion_graph(report: OperationReport) -> MotionGraph:
    """Follow one tooth pair of a design whose mesh cycle is known."""
    cycle = report.cycle
    share = np.linspace(-REACH, REACH, 2 * REACH * STEPS + 1)
    found = first_contact(report.design, report.flank, float(cycle.start) + cycle.pitch * share, pairs=[0])
    alone = np.where(found.status == FirstStatus.SOLVED, found.transmission_error, np.nan)
    edge = found.limit[:, 0] >= 0
    if report.along_lines:  # whose ends are no edges that run before flanks do
        edge &= ~(np.abs(alone - float(cycle.mean)) < SMALLEST / ARCSEC)
    return MotionGraph(report, share, alone, edge)


def draw(axes: Axes, graph: MotionGraph) -> None:
    """Draw the curves of all tooth pairs over SHOWN pitches, edges dotted, and over them what runs, edges
    red, with the hand-overs; in urad on the left, in um at the gear's pitch circle on the right."""
    report, mean = graph.report, graph.mean
    edges = (
        np.convolve(graph.edge, np.ones(3), "same") > 0.0
    )  # to the first roll without, so as not to end short
    for own, style in ((~graph.edge, "-"), (edges, ":")):
        shown = MICRO * np.where(own, graph.alone - mean, np.nan)
        for pair in range(-REACH, REACH + SHOWN + 1):
            axes.plot(graph.pitches + pair, shown, style, color=theme.GREY, linewidth=1.2, zorder=2.0)
    first, cycle = report.first, report.cycle
    runs, edge = MICRO * (first.transmission_error - mean), first.limit[:, 0] >= 0
    edge &= not report.along_lines
    share = np.linspace(0.0, 1.0, runs.size)
    changes = cycle.changes[cycle.hand_over]
    at, there = (changes - float(cycle.start)) / cycle.pitch, cycle.at(changes).transmission_error - mean
    for pitch in range(SHOWN):
        axes.plot(share + pitch, runs, color=theme.BLUE, zorder=3.0)
        axes.plot(share + pitch, np.where(edge, runs, np.nan), color=theme.RED, linewidth=WIDE, zorder=3.1)
        axes.plot(at + pitch, MICRO * there, "o", color=theme.INK, ms=5.5, zorder=3.2)
    low, high = (MICRO * limit for limit in graph.limits)
    axes.set(xlim=(0.0, SHOWN), ylim=(low, high))
    axes.set(xlabel="pinion roll from the pitch point (pitches)", ylabel="error (\u00b5rad)")
    axes.grid(True)
    beside, per = axes.twinx(), 1e-3 * graph.pitch_radius  # um for a urad
    beside.set(ylim=(per * low, per * high), ylabel="error (\u00b5m)")


def legend() -> list[Line2D]:
    """Name the curves."""
    grey: dict[str, Any] = {"color": theme.GREY, "linewidth": 1.2}
    return [
        Line2D([], [], color=theme.BLUE, label="runs, flank on flank"),
        Line2D([], [], color=theme.RED, lw=WIDE, label="runs on an edge"),
        Line2D([], [], color=theme.INK, ls="", marker="o", ms=5.5, label="hand-over"),
        Line2D([], [], **grey, label="a pair alone"),
        Line2D([], [], ls=":", **grey, label="its edges"),
    ]


def words(graph: MotionGraph) -> str:
    """Say how far what runs swings, what edges carry, and the contact ratios."""
    report, swing = graph.report, float(graph.report.cycle.peak_to_peak)
    if ARCSEC * swing < SMALLEST:
        text = "peak to peak zero but for rounding"
    else:
        text = f"peak to peak {MICRO * swing:.3g} \u00b5rad = {1e3 * swing * graph.pitch_radius:.3g} \u00b5m"
    share = f"edges carry {100.0 * float(report.cycle.edge_share):.3g} %"
    if report.along_lines:
        share = "lines of contact carry"
    return f"{text}\n{share}; {ratio_words(report.eq16, report.operating)}"
