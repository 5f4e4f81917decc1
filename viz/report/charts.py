"""The page's charts of one flank pair: those of `parts`, laid out for its width.

Charts of right and left flanks stand side by side, and have flanks at one scale and equal axes, unless one
would be small.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from beveloid_geom import Design, EaseOff, Status
from beveloid_geom.analysis.pressure import WHOLE
from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.report.ease_off import GIVEN, PLAIN, EaseOffReport
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.report.path import ContactReport
from beveloid_geom.report.sensitivity import SensitivityReport, steps_of
from beveloid_geom.report.sliding import MEMBERS, SlidingReport

from ..parts import charts, flat, motion_graph
from ..parts.charts import Quantity
from ..parts.flat import FlatFlank
from ..parts.motion_graph import MotionGraph
from ..parts.solved import FLANKS, points_on
from ..stage import theme
from .data import FlankResults
from .svg import WIDTH, new_chart

PITCHES = 2
SIDE, ABOVE, BELOW, GREATEST = 44.0, 40.0, 40.0, 130.0
"""Pixels beside, above and below a flank, and its greatest height."""
SMALL_BY = 2.0
"""A flank that would be smaller than the other by more than this has a scale of its own."""
FLAT_BY = 5.0
"""Curves that would be lower than those of the other flank by more than this have axes of their own."""
LEVELS, EDGE = 8, 0.88
"""Level lines of an ease-off, at most, and the share of half a flank beyond which they are not labelled."""
LEGEND: dict[str, Any] = {"handlelength": 1.5, "columnspacing": 1.0, "handletextpad": 0.5}
CASES = {GIVEN: "as given", PLAIN: "without parabolas"}


@dataclass(frozen=True, eq=False)
class Flats:
    """Active flanks laid flat, of pinion and gear by flank, None where one ends short of its tip; their
    scales, pixels a mm; and the heights of both members' drawings, pixels, that of the larger flank."""

    flanks: dict[str, tuple[FlatFlank | None, ...]]
    scales: dict[FlatFlank, float]
    heights: tuple[float, ...]


def flats_of(design: Design) -> Flats:
    """Lay all flanks of a design flat."""
    flanks = {flank: tuple(flat.flat_flank(member, flank) for member in design.members) for flank in FLANKS}
    known = [one for both in flanks.values() for one in both if one is not None]
    scales = _scales(known) if known else {}
    sizes = [
        [scales[one] * one.span[1] for one in both if one] for both in zip(*flanks.values(), strict=True)
    ]
    return Flats(flanks, scales, tuple(float(max(size, default=GREATEST / 4.0)) for size in sizes))


def flank_chart(results: FlankResults, flats: Flats, cloud: bool = False) -> Figure | None:
    """Draw the pinion's flank over the gear's with the path of contact; over the pattern and with the points
    of first contact, or with the `cloud` of paths under drawn errors. None without flanks."""
    both = flats.flanks[results.flank]
    if not any(both):
        return None
    heights = [ABOVE + BELOW + height for height in flats.heights]
    chart = Figure(figsize=(WIDTH / 72.0, sum(heights) / 72.0), dpi=72.0)
    top = 1.0
    for number, (one, height) in enumerate(zip(both, heights, strict=True)):
        share = height / sum(heights)
        box = (0.0, top - share + BELOW / sum(heights), 1.0, share - (ABOVE + BELOW) / sum(heights))
        axes = chart.add_axes(box)
        top -= share
        axes.set_title(MEMBERS[number].capitalize(), x=0.0, pad=22.0)
        if one is None:
            axes.set_axis_off()
            axes.text(SIDE / WIDTH, 0.5, "no flank: it ends short of its tip", transform=axes.transAxes)
            continue
        flat.outline(axes, one, flats.scales[one], theme.METALS[number], WIDTH)
        if cloud and results.cloud is not None:
            charts.cloud(axes, one.place, points_on(results.cloud, number), theme.BLUE, 0.28)
        if not cloud and results.pattern is not None:
            side = (results.pattern.pattern.pinion, results.pattern.pattern.gear)[number]
            flat.pattern(axes, one, side, results.pattern.pattern.separation)
        if results.contact.reason is None:
            flat.path(axes, one, results.contact.path, number, 1.6 if cloud else 2.2)
        if not cloud and results.contact.lines is not None:
            flat.lines(axes, one, results.contact.lines, number)
        elif not cloud and results.operation is not None:
            flat.contacts(axes, one, results.operation, number)
    return chart


def _scales(flats: list[FlatFlank]) -> dict[FlatFlank, float]:
    """Give pixels a mm of each flank: the same, unless one would be small."""
    room = np.array([WIDTH - 2.0 * SIDE, GREATEST])
    own = np.array([(room / one.span).min() for one in flats])
    return dict(zip(flats, np.where(own > SMALL_BY * own.min(), own, own.min()).tolist(), strict=True))


def same_heights(drawn: Sequence[Figure]) -> None:
    """Give the axes of charts that stand side by side the same heights, unless one's curves would be flat."""
    for row in zip(*(chart.axes for chart in drawn), strict=True):
        ranges = np.array([axes.get_ylim() for axes in row])
        low, high = ranges.min(), ranges.max()
        for axes, own in zip(row, ranges, strict=True):
            if high - low < FLAT_BY * np.ptp(own):
                axes.set_ylim(low, high)


def ease_off_chart(results: FlankResults, report: EaseOffReport) -> Figure | None:
    """Draw level lines of the pinion's ease-off with the path of contact, as given and, where there are
    parabolas, without them. None where there is none."""
    bent = any(float(member.tool.parabola) for member in report.design.members)
    found = {case: report.known.get((results.flank, case)) for case in CASES if bent or case == GIVEN}
    given = found[GIVEN]
    if given is None or not np.isfinite(given.deviation).any():
        return None
    chart = new_chart(205.0 * len(found))
    for axes, (case, one) in zip(
        chart.subplots(len(found), 1, squeeze=False)[:, 0], found.items(), strict=True
    ):
        axes.set_title(CASES[case].capitalize() if bent else "")
        if one is None or not np.isfinite(one.deviation).any():
            axes.set_axis_off()
            theme.say(axes, "no path of contact")
            continue
        _levels(axes, one)
        path = results.contact.path
        if case == GIVEN:
            points = np.stack((path.pinion_z, path.l1), axis=-1)[path.status == Status.SOLVED]
            axes.plot(*points.T, color=theme.RED, linewidth=2.0)
            axes.plot(*points[0], "o", color=theme.RED, markersize=6.0)
    return chart


def _levels(axes: Axes, found: EaseOff) -> None:
    """Draw level lines (um) over the flank, z by l."""
    values = np.ma.masked_invalid(1e3 * found.deviation)
    if float(np.abs(values).max()) < charts.LEAST_EASE_OFF:
        values[:] = 0.0
        theme.say(axes, "zero but for rounding", backgroundcolor="white")
    levels = MaxNLocator(LEVELS, steps=[1, 2, 5, 10]).tick_values(float(values.min()), float(values.max()))
    styles: dict[str, Any] = {
        "colors": [theme.BLUE if level else theme.INK for level in levels],
        "linewidths": [1.2 if level else 1.8 for level in levels],
        "linestyles": ["-" if level >= 0.0 else "--" for level in levels],
    }
    lines = axes.contour(found.z, found.l, values, levels=levels, **styles)
    names: Callable[[float], str] = partial(_level_name, step=float(np.diff(levels)[0]))
    half = np.array((np.ptp(found.z), np.ptp(found.l))) / 2.0
    middle = np.array((found.z.min(), found.l.min())) + half
    for label in axes.clabel(lines, fontsize=theme.SMALL, fmt=names, colors=theme.INK):
        if np.abs((label.get_position() - middle) / half).max() > EDGE:
            label.remove()  # cut off
    rim = [np.concatenate((g[0], g[1:, -1], g[-1, -2::-1], g[-2::-1, 0])) for g in (found.z, found.l)]
    axes.plot(*rim, color=theme.GREY, linewidth=1.2)
    axes.set(xlabel="z (mm), toe to heel", ylabel="l1 (mm), root to tip")
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def _level_name(value: float, step: float) -> str:
    digits = max(0, -int(np.floor(np.log10(step))))
    return theme.signed(value, digits)


def pressure_chart(report: ContactReport) -> Figure | None:
    """Draw Hertz's greatest pressure over the pinion's roll, apart where the ellipse ends beyond an edge;
    None where there is none."""
    found, path = report.pressed, report.path
    if found is None or not np.isfinite(found.pressure).any():
        return None
    chart = new_chart(210.0)
    axes = chart.add_subplot()
    roll, past = np.degrees(path.pinion_roll), found.reaches != WHOLE
    beside = past | np.append(past[1:], False) | np.append(False, past[:-1])  # no gap between both curves
    axes.plot(roll, np.where(past, np.nan, found.pressure), color=theme.BLUE, label="ellipse on the flanks")
    if past.any():
        edge = np.where(beside, found.pressure, np.nan)
        axes.plot(roll, edge, "--", color=theme.RED, label="ellipse beyond an edge")
    axes.set_ylim(0.0, 1.12 * float(np.nanmax(found.pressure)))
    axes.margins(x=0.02)
    axes.grid(True)
    if path.flank == "left":
        axes.invert_xaxis()
    axes.set(xlabel="pinion roll (deg)", ylabel="pressure (MPa)")
    chart.legend(loc="outside upper left", ncols=2, **LEGEND)
    return chart


def motion_chart(graph: MotionGraph) -> Figure:
    """Draw the transmission error of every tooth pair alone, and of the one that runs."""
    chart = new_chart(280.0)
    axes = chart.add_subplot()
    motion_graph.draw(axes, graph)
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    chart.legend(handles=motion_graph.legend(), loc="outside upper left", ncols=2, **LEGEND)
    return chart


def error_chart(report: OperationReport) -> Figure:
    """Draw the transmission error over mesh cycles."""
    chart = new_chart(230.0)
    axes = chart.add_subplot()
    charts.error_over_rolls(axes, report, PITCHES)
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    chart.legend(loc="outside upper left", ncols=3, **LEGEND)
    return chart


def spectrum_chart(report: OperationReport) -> Figure:
    """Draw the amplitudes at the mesh frequency and its multiples."""
    chart = new_chart(170.0)
    charts.amplitudes(chart.add_subplot(), report)
    return chart


def sliding_chart(report: SlidingReport) -> Figure:
    """Draw the speed of sliding, and specific sliding of both members, over the pinion's roll."""
    chart = new_chart(360.0)
    speed, specific = chart.subplots(2, 1, sharex=True)
    charts.sliding_speed(speed, report, "all")
    charts.specific_sliding(specific, report)
    specific.set_xlabel("pinion roll (deg)")
    for axes in (speed, specific):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.4, **LEGEND)
    return chart


def sensitivity_chart(report: SensitivityReport, quantities: dict[Quantity, float]) -> Figure:
    """Draw what errors of a usual size do to `quantities`, on axes to the greatest change of each on either
    flank."""
    chart = new_chart(20.0 + 180.0 * len(quantities))
    panels = chart.subplots(len(quantities), 1, squeeze=False)[:, 0]
    steps = steps_of(report.found.errors)
    for axes, (quantity, greatest) in zip(panels, quantities.items(), strict=True):
        changes = charts.changes_of([report.found], quantity)
        charts.changes_under_errors(axes, quantity, changes, greatest, steps)
    handles = charts.marks_of_changes([report.found.flank])
    chart.legend(handles=handles, loc="outside upper left", ncols=3, **LEGEND)
    return chart


def changing(reports: Sequence[SensitivityReport]) -> dict[Quantity, float]:
    """Give the quantities that change under some error, and the greatest change of each."""
    greatest = {
        quantity: charts.greatest_of(charts.changes_of([one.found], quantity) for one in reports)
        for quantity in charts.QUANTITIES
    }
    return {quantity: size for quantity, size in greatest.items() if size > 0.0}


def ratio_chart(study: ToleranceStudy) -> Figure:
    """Draw how the contact ratio spreads over the mountings that have a path."""
    chart = new_chart(180.0)
    axes = chart.add_subplot()
    charts.spread(axes, study, "contact_ratio", 1.0, theme.BLUE)
    axes.set(xlabel="contact ratio by Eq. 16", ylabel="mountings at most (%)")
    return chart
