"""Motion graph: the transmission error of every tooth pair, the one that runs, and its amplitudes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.report.operation import operation_report

from ...parts import motion_graph
from ...parts.motion_graph import MICRO, MotionGraph
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import PARABOLAS, as_large, coefficients, modified, parabolas, two_digits
from ...stage import theme
from ...stage.layout import Cells

COLOURS = (theme.GREEN, theme.BLUE, theme.ORANGE)
HATCHES = ("...", "", "///")
"""Of the cases."""
HOLLOW = 0.0002
"""1/mm: both coefficients of the last case, at Table 1's module."""
POINTS = 361
"""Rolls of one mesh cycle."""
HARMONICS = 10
CELLS = Cells(left=1.05, right=1.0, across=2.1, down=1.45, most=2, least=3.3)
LEGEND = 1.4
"""By what the scale of amplitudes is longer in print, for the legend."""
WORDS = 42.0
"""Points over a panel for what is said of it."""
NOTE = (
    "Rigid teeth without load. Grey: where each tooth pair would touch if it were alone, dotted with an edge"
    " (tip, toe, heel); thick: the first of all teeth, which runs. The error is gear roll plus N1/N2 pinion"
    " roll, less that of the unmodified pair without errors and less the mean of what runs; in \u00b5m it is"
    " at the gear's working pitch circle. Scales reach beside what runs as far as marking compound is thick"
    f" ({1e3 * MARKING_SEPARATION:g} \u00b5m), or further. Over each: its swing, the share of the"
    " cycle that edges carry, the contact ratio of one tooth pair by Eq. 16, and running, of all teeth."
)


@dataclass(frozen=True, eq=False)
class Case:
    """One case by its name and colour, of one flank: its motion graph, None with the `reason` where that is
    not known."""

    name: str
    colour: str
    flank: str
    design: Design
    graph: MotionGraph | None
    reason: str = ""


def compute(design: Design, flank: str = "right") -> tuple[Case, ...]:
    """Find the motion graph as designed, with the paper's modification, and with both flanks hollow."""
    hollow = two_digits(HOLLOW / as_large(design))
    changes = modified(design), design.with_parabola(hollow, hollow)
    named = ("as designed", design), *((coefficients(changed), changed) for changed in changes)
    cases = []
    for (name, changed), colour in zip(named, COLOURS, strict=True):
        graph, reason = None, first_contact_fault(changed)
        if not reason:
            report = operation_report("", changed, flank, POINTS, HARMONICS, MARKING_SEPARATION)
            reason = report.reason
            graph = None if reason else motion_graph.motion_graph(report)
        cases.append(Case(name, colour, flank, changed, graph, reason or ""))
    return tuple(cases)


def draw(data: tuple[Case, ...], layout: theme.Layout) -> Drawing:
    """Draw a panel for each case, and one of all amplitudes."""
    count = len(data) + 1
    page, low, high = theme.new_page(
        layout,
        "Motion graph: transmission error of every tooth pair, and of the one that runs",
        f"{data[0].flank.capitalize()} flanks, the pinion drives; {motion_graph.SHOWN} mesh cycles",
        NOTE,
        below=0.65,
        above=1.1,
        tall=CELLS.tall(layout, count, 2.9),
    )
    *graphs, bars = theme.panels(page, CELLS, count, low, high)
    for index, (case, axes) in enumerate(zip(data, graphs, strict=True)):
        axes.set_title(f"({'abc'[index]})  {case.name}", loc="left", pad=WORDS, fontsize=theme.LABEL)
        if case.graph is None:
            theme.say(axes, case.reason, 36)
            continue
        motion_graph.draw(axes, case.graph)
        if index + CELLS.columns(layout, count) < len(graphs):
            axes.set_xlabel("")  # it stands under the panel below
        style: dict[str, Any] = {"xycoords": "axes fraction", "va": "bottom", "fontsize": theme.SMALL}
        theme.beside(axes, (0.0, 1.0), motion_graph.words(case.graph), (0.0, 6.0), **style)
    _amplitudes(bars, data)
    if layout.printed:  # the legend stands over the bars
        bars.set_ylim(top=LEGEND * bars.get_ylim()[1])
    bars.set_title("(d)  amplitudes of what runs", loc="left", pad=8.0, fontsize=theme.LABEL)
    theme.legend(page, motion_graph.legend(), 5, 0.78, handlelength=2.2, columnspacing=1.2)
    return Drawing(page, {})


def _amplitudes(axes: Axes, data: tuple[Case, ...]) -> None:
    """Draw the amplitudes (urad) at multiples of the mesh frequency, the cases side by side."""
    known = [case for case in data if case.graph is not None]
    orders, width = np.arange(1, HARMONICS + 1), 0.8 / max(len(known), 1)
    for place, case in enumerate(known):
        assert case.graph is not None
        values = MICRO * np.abs(case.graph.report.cycle.harmonics)
        at = orders + (place - 0.5 * (len(known) - 1)) * width
        name = f"({'abc'[data.index(case)]})"
        look: dict[str, Any] = {"color": case.colour, "edgecolor": "white", "linewidth": 0.0}
        axes.bar(at, values, 0.9 * width, hatch=HATCHES[data.index(case)], label=name, **look)
    axes.set_xticks(orders)
    axes.set_xlim(0.4, HARMONICS + 0.6)
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1e-6))
    axes.set(xlabel="multiple of the mesh frequency", ylabel="amplitude (\u00b5rad)")
    axes.set_axisbelow(True)
    axes.grid(True, axis="y")
    if known:
        axes.legend(loc="upper right", ncols=3)


def rows(data: tuple[Case, ...]) -> Table:
    """List what runs over one cycle, a tooth pair alone, and the amplitudes."""
    curves = "kind", "pitches", "multiple", "error_rad", "amplitude_rad", "pitch_radius_mm"
    of_cycle = "peak_to_peak_rad", "edge_share", "contact_ratio", "operating_contact_ratio"
    header = (*PARABOLAS, *curves, "carried_by", "tooth_pair", *of_cycle)

    def cases() -> Rows:
        """Give the columns of every case."""
        for case in data:
            who, graph = parabolas(case.design), case.graph
            if graph is None:
                yield *who, case.reason, *[""] * (len(header) - len(PARABOLAS) - 1)
                continue
            report, share, radius = graph.report, np.linspace(0.0, 1.0, POINTS), graph.pitch_radius
            cycle, first = report.cycle, report.first
            said = float(cycle.peak_to_peak), float(cycle.edge_share), report.eq16, report.operating
            runs = first.transmission_error - graph.mean
            yield *who, "runs", share, "", runs, "", radius, report.carriers, first.pair, *said
            edges = ["edge" if edge else "flanks" for edge in graph.edge.tolist()]
            yield *who, "alone", graph.pitches, "", graph.alone - graph.mean, "", radius, edges, 0, *said
            amplitudes = np.abs(cycle.harmonics)
            yield *who, "amplitude", "", 1 + np.arange(amplitudes.size), "", amplitudes, radius, "", "", *said

    return header, stacked(cases())


RECIPES = {"transmission-error": Recipe(compute, draw, rows)}
