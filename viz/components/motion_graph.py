"""Motion graph: transmission error of each tooth pair alone, and of the pair in contact.

Positive: gear ahead. The tooth pair with the gear furthest ahead is in contact, so that the transmission
error in operation is the upper envelope of all curves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import first_contact
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.operation.cycle.cycle_segments import SAMPLES_PER_PITCH
from beveloid_geom.operation.one_pair import contacts_of_one_pair
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.status import FirstStatus

from ..rendering import theme
from .charts import ZERO_ERROR_ARCSEC
from .paths_table import as_large, ratio_words

REACH_PITCHES = 3
"""Number of pitches to either side over which a tooth pair is followed."""
SHOWN_PITCHES = 2
"""Number of pitches drawn."""
EDGE_LINE_PT = 4.5
"""Line width of edge contact, points; visible without colours."""


@dataclass(frozen=True, eq=False)
class MotionGraph:
    """Transmission error of one tooth pair. All pairs have the same curve, whole pitches apart.

    Attributes
    ----------
    report : OperationReport
        Mesh cycle of all tooth pairs.
    pitches : ndarray, shape (n,)
        Pinion roll from the pitch point, in pitches.
    alone : ndarray, shape (n,)
        Transmission error of one tooth pair, rad; NaN where the pair cannot touch.
    edge : ndarray of bool, shape (n,)
        Mask of edge contact of this pair.
    """

    report: OperationReport
    pitches: FloatArray
    alone: FloatArray
    edge: Mask

    @property
    def mean(self) -> float:
        """Mean transmission error in operation, rad, which is subtracted from all curves."""
        return float(self.report.cycle.mean)

    @property
    def pitch_radius(self) -> float:
        """Working pitch radius of the gear, mm."""
        return float(mounting_of(self.report.design).working_radius[1])

    @property
    def limits(self) -> tuple[float, float]:
        """Lower and upper limit of the chart, rad.

        Curves of separated tooth pairs are below the curve in operation. Therefore the chart extends below it
        by the larger of two angles: 1.2 times the peak-to-peak value, and the thickness of the marking
        compound (scaled with the module from that of Table 1) at the pitch circle of the gear. Above, it
        extends by 0.12 times this angle.
        """
        runs = self.report.first.transmission_error - self.mean
        low, high = float(runs.min()), float(runs.max())
        compound = MARKING_SEPARATION_MM * as_large(self.report.design)
        deep = max(compound / self.pitch_radius, 1.2 * (high - low))
        return low - deep, high + 0.12 * deep


def motion_graph(report: OperationReport, steps: int | None = 64) -> MotionGraph:
    """Compute the curve of one tooth pair of a design with a known mesh cycle.

    Parameters
    ----------
    report : OperationReport
        Report with the mesh cycle.
    steps : int or None
        Rolls per pitch. If None, the rolls are those from which the mesh cycle was computed, which takes no
        time.

    Returns
    -------
    MotionGraph
    """
    cycle, each = report.cycle, steps or SAMPLES_PER_PITCH
    share = np.linspace(-REACH_PITCHES, REACH_PITCHES, 2 * REACH_PITCHES * each + 1)
    alone, edge = np.full(share.size, np.nan), np.zeros(share.size, dtype=bool)
    if steps is None:
        contact = contacts_of_one_pair(report.design, report.flank)
        place = np.rint(
            ((contact.pinion_roll - float(cycle.start)) / cycle.pitch + REACH_PITCHES) * each
        ).astype(int)
    else:
        roll, place = float(cycle.start) + cycle.pitch * share, np.arange(share.size)
        contact = first_contact(report.design, report.flank, roll, pairs=[0])
    known = (contact.status == FirstStatus.SOLVED) & (place >= 0) & (place < share.size)
    alone[place[known]] = contact.transmission_error[known]
    edge[place[known]] = contact.limit[known, 0] >= 0
    if report.along_lines:  # the ends of lines of contact are not edge contact
        edge &= ~(np.abs(alone - float(cycle.mean)) < ZERO_ERROR_ARCSEC / ARCSEC)
    return MotionGraph(report, share, alone, edge)


def draw_graph(axes: Axes, graph: MotionGraph) -> None:
    """Draw all tooth pairs over some pitches (edges dotted), and in front the pair in contact, with edge
    contact as wider orange lines and with the points of hand-over. The left axis is in arcsec, the right in
    um at the pitch circle of the gear."""
    report, mean = graph.report, graph.mean
    edges = (
        np.convolve(graph.edge, np.ones(3), "same") > 0.0
    )  # up to the first roll without edge contact, so that the lines meet
    for mask, style in ((~graph.edge, "-"), (edges, ":")):
        shown = ARCSEC * np.where(mask, graph.alone - mean, np.nan)
        for pair in range(-REACH_PITCHES, REACH_PITCHES + SHOWN_PITCHES + 1):
            axes.plot(graph.pitches + pair, shown, style, color=theme.GREY, linewidth=1.2, zorder=2.0)
    first, cycle = report.first, report.cycle
    runs, edge = ARCSEC * (first.transmission_error - mean), first.limit[:, 0] >= 0
    on_edge = np.where(edge & (not report.along_lines), runs, np.nan)
    share = np.linspace(0.0, 1.0, runs.size)
    changes = cycle.changes[cycle.hand_over]
    at, there = (changes - float(cycle.start)) / cycle.pitch, cycle.at(changes).transmission_error - mean
    for pitch in range(SHOWN_PITCHES):
        axes.plot(share + pitch, runs, color=theme.BLUE, zorder=3.0)
        axes.plot(share + pitch, on_edge, color=theme.VERMILLION, linewidth=EDGE_LINE_PT, zorder=3.1)
        axes.plot(at + pitch, ARCSEC * there, "o", color=theme.INK, ms=5.5, zorder=3.2)
    low, high = (ARCSEC * limit for limit in graph.limits)
    axes.set(xlim=(0.0, SHOWN_PITCHES), ylim=(low, high))
    axes.set(xlabel="pinion roll from the pitch point (pitches)", ylabel="ahead (arcsec)")
    axes.grid(True)
    at_pitch_circle, per = axes.twinx(), 1e3 * graph.pitch_radius / ARCSEC  # um per arcsec
    at_pitch_circle.set(ylim=(per * low, per * high), ylabel="ahead (\u00b5m)")


def legend_entries() -> list[Line2D]:
    """Return the legend entries."""
    grey: dict[str, Any] = {"color": theme.GREY, "linewidth": 1.2}
    return [
        Line2D([], [], color=theme.BLUE, label="in operation, flank contact"),
        Line2D([], [], color=theme.VERMILLION, lw=EDGE_LINE_PT, label="in operation, edge contact"),
        Line2D([], [], color=theme.INK, ls="", marker="o", ms=5.5, label="hand-over"),
        Line2D([], [], **grey, label="one tooth pair alone"),
        Line2D([], [], ls=":", **grey, label="one pair, edge contact"),
    ]


def graph_text(graph: MotionGraph) -> str:
    """Return peak to peak value, share of edge contact, and contact ratios as text."""
    report, swing = graph.report, float(graph.report.cycle.peak_to_peak)
    if ARCSEC * swing < ZERO_ERROR_ARCSEC:
        text = "peak to peak zero within rounding"
    else:
        text = f"peak to peak {ARCSEC * swing:.3g} arcsec = {1e3 * swing * graph.pitch_radius:.3g} \u00b5m"
    edges = f"edge contact {100.0 * float(report.cycle.edge_share):.3g} %"
    share = "contact along lines" if report.along_lines else edges
    return f"{text}\n{share}; {ratio_words(report.eq16, report.operating)}"
