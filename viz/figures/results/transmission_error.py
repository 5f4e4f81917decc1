"""Motion graph: transmission error of every tooth pair, of the pair in contact, and its amplitudes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import operation_report

from ...components import motion_graph
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.motion_graph import MotionGraph
from ...components.paths_table import PARABOLAS, as_large, coefficients, paper_modified, parabolas, two_digits
from ...rendering import theme
from ...rendering.layout import PanelRows

LOOKS = ((theme.GREEN, "..."), (theme.BLUE, ""), (theme.ORANGE, "///"))
"""Colours and hatches of the cases."""
HARMONICS = 10


@dataclass(frozen=True, eq=False)
class CycleCase:
    """One case of one flank with name and colour: its motion graph, None with the `reason` if it is not
    known."""

    name: str
    colour: str
    flank: str
    design: Design
    graph: MotionGraph | None
    reason: str = ""


def compute(design: Design, flank: str = "right") -> tuple[CycleCase, ...]:
    """Compute the motion graph as designed, with the paper's modification, and with hollow flanks."""
    # Both coefficients of the last case at the module of Table 1, 1/mm.
    hollow_per_mm = 0.0002
    hollow = two_digits(hollow_per_mm / as_large(design))
    changes = paper_modified(design), design.with_parabola(hollow, hollow)
    named = ("as designed", design), *((coefficients(changed), changed) for changed in changes)
    cases, rolls = [], 361
    for (name, changed), (colour, _) in zip(named, LOOKS, strict=True):
        graph, reason = None, first_contact_fault(changed)
        if not reason:
            report = operation_report("", changed, flank, rolls, HARMONICS, MARKING_SEPARATION_MM)
            reason = report.reason
            graph = None if reason else motion_graph.motion_graph(report)
        cases.append(CycleCase(name, colour, flank, changed, graph, reason or ""))
    return tuple(cases)


def draw(data: tuple[CycleCase, ...], layout: theme.PageLayout) -> Drawing:
    """Draw a panel for each case and a panel of all amplitudes."""
    cells = PanelRows(left=1.05, right=1.0, across=2.1, down=1.45, most=2, least=3.3)
    # Factor of the scale of amplitudes in print, which leaves space for the legend.
    print_scale_factor = 1.4
    # Height of the text above a panel, points.
    text_height_pt = 42.0
    count, known = len(data) + 1, any(case.graph for case in data)
    page, low, high = theme.new_page(
        layout,
        "Motion graph: transmission error of every tooth pair, and of the pair in contact",
        f"{data[0].flank.capitalize()} flanks, the pinion drives; {motion_graph.SHOWN_PITCHES} mesh cycles",
        (
            "Rigid teeth without load. Grey: single tooth pair, dotted on an edge. Thick: pair in"
            " contact, with the gear furthest ahead. Positive: gear ahead of its mean position over"
            " the mesh cycle. Above: peak to peak, fraction of edge contact,"
            " contact ratio by Eq. 16, and in operation."
        )
        if known
        else "",
        below=0.65,
        above=1.45,
        tall=cells.tall(layout, count, 2.9),
    )
    *graphs, bars = theme.panels(page, cells, count, low, high)
    for index, (case, axes) in enumerate(zip(data, graphs, strict=True)):
        axes.set_title(f"({'abc'[index]})  {case.name}", loc="left", pad=text_height_pt, fontsize=theme.LABEL)
        if case.graph is None:
            axes.set_axis_off()
            theme.message(axes, case.reason, 36)
            continue
        motion_graph.draw_graph(axes, case.graph)
        axes.yaxis.labelpad = 0.5  # space for a label of two lines on a narrow page
        style: dict[str, Any] = {"xycoords": "axes fraction", "va": "bottom", "fontsize": theme.SMALL}
        theme.label_point(axes, (0.0, 1.0), motion_graph.graph_text(case.graph), (0.0, 6.0), **style)
    bars.set_title("(d)  amplitudes of all teeth", loc="left", pad=8.0, fontsize=theme.LABEL)
    if not known:
        bars.set_axis_off()
        return Drawing(page, {})
    _amplitudes(bars, data)
    if layout.printed:  # space for the legend above the bars
        bars.set_ylim(top=print_scale_factor * bars.get_ylim()[1])
    theme.legend(page, motion_graph.legend_entries(), 5, 1.15, handlelength=2.2, columnspacing=1.2)
    return Drawing(page, {})


def _amplitudes(axes: Axes, data: tuple[CycleCase, ...]) -> None:
    """Draw the amplitudes (arcsec) at multiples of the mesh frequency, the cases next to each other."""
    known = [case for case in data if case.graph is not None]
    orders, width = np.arange(1, HARMONICS + 1), 0.8 / len(known)
    for place, case in enumerate(known):
        assert case.graph is not None
        values = ARCSEC * np.abs(case.graph.report.cycle.harmonics)
        at = orders + (place - 0.5 * (len(known) - 1)) * width
        name = f"({'abc'[data.index(case)]})"
        look: dict[str, Any] = {"color": case.colour, "edgecolor": "white", "linewidth": 0.0}
        axes.bar(at, values, 0.9 * width, hatch=LOOKS[data.index(case)][1], label=name, **look)
    axes.set_xticks(orders)
    axes.set_xlim(0.4, HARMONICS + 0.6)
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1e-6))
    axes.set(xlabel="multiple of the mesh frequency", ylabel="amplitude (arcsec)")
    axes.set_axisbelow(True)
    axes.grid(True, axis="y")
    axes.legend(loc="upper right", ncols=3)


def rows(data: tuple[CycleCase, ...]) -> Table:
    """List the transmission error of all teeth over one cycle, of a single tooth pair, and the amplitudes."""
    curves = "kind", "pitches", "multiple", "error_rad", "amplitude_rad", "pitch_radius_mm"
    of_cycle = "peak_to_peak_rad", "edge_share", "contact_ratio", "operating_contact_ratio"
    header = (*PARABOLAS, *curves, "carried_by", "tooth_pair", *of_cycle)

    def cases() -> Rows:
        """Yield the columns of every case."""
        for case in data:
            who, graph = parabolas(case.design, case.flank), case.graph
            if graph is None:
                yield *who, case.reason, *[""] * (len(header) - len(PARABOLAS) - 1)
                continue
            report, radius = graph.report, graph.pitch_radius
            cycle, first = report.cycle, report.first
            of_case = float(cycle.peak_to_peak), float(cycle.edge_share), report.eq16, report.operating
            runs = first.transmission_error - graph.mean
            share = np.linspace(0.0, 1.0, runs.size)
            yield *who, "runs", share, "", runs, "", radius, report.carriers, first.pair, *of_case
            edges = ["edge" if edge else "flanks" for edge in graph.edge.tolist()]
            yield *who, "alone", graph.pitches, "", graph.alone - graph.mean, "", radius, edges, 0, *of_case
            amplitudes = np.abs(cycle.harmonics)
            multiples = 1 + np.arange(amplitudes.size)
            yield *who, "amplitude", "", multiples, "", amplitudes, radius, "", "", *of_case

    return header, rows_of_cases(cases())


RECIPES = {"transmission-error": Recipe(compute, draw, rows)}
