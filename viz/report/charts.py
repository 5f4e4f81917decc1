"""Charts of the page for one flank pair, in the width of a column.

Charts of right and left flanks are side by side. Their flanks have the same scale and their axes the same
limits, unless one chart would become too small.
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
from beveloid_geom.analysis.pressure import NO_LIMIT_REACHED
from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.design.ends import end_names
from beveloid_geom.report.ease_off import GIVEN, PLAIN, EaseOffReport
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.report.path import ContactReport
from beveloid_geom.report.result import MEMBERS
from beveloid_geom.report.sensitivity import SensitivityReport, steps_of
from beveloid_geom.report.sliding import SlidingReport

from ..components import charts, flattened_flank, motion_graph
from ..components.charts import ErrorEffect
from ..components.flattened_flank import FlatFlank
from ..components.motion_graph import MotionGraph
from ..components.paths_table import FLANKS, points_on
from ..rendering import theme
from .data import FlankResults
from .svg import WIDTH_PX, new_chart

SIDE_PX = 44.0
"""Space at the sides of a flank."""
LEGEND: dict[str, Any] = {"handlelength": 1.5, "columnspacing": 1.0, "handletextpad": 0.5}


@dataclass(frozen=True, eq=False)
class Flats:
    """Active flanks of a design in the plane.

    Attributes
    ----------
    flanks : dict
        Flanks of pinion and gear, by 'right' and 'left'; None if a flank does not reach its tip.
    scales : dict
        Pixels per mm of each flank.
    heights : tuple of float
        Heights of the drawings of both members, pixels.
    """

    flanks: dict[str, tuple[FlatFlank | None, ...]]
    scales: dict[FlatFlank, float]
    heights: tuple[float, ...]


def flats_of(design: Design) -> Flats:
    """Return all flanks of a design in the plane, with their scales."""
    flanks = {
        flank: tuple(flattened_flank.flat_flank(member, flank) for member in design.members)
        for flank in FLANKS
    }
    known = [one for both in flanks.values() for one in both if one is not None]
    largest_height_px = 130.0
    scales = _scales(known, largest_height_px) if known else {}
    sizes = [
        [scales[one] * one.span[1] for one in both if one] for both in zip(*flanks.values(), strict=True)
    ]
    return Flats(flanks, scales, tuple(float(max(size, default=largest_height_px / 4.0)) for size in sizes))


def flank_chart(results: FlankResults, flats: Flats, cloud: bool = False) -> Figure | None:
    """Draw the pinion flank above the gear flank with the path of contact.

    Parameters
    ----------
    results : FlankResults
        Results of the flank pair.
    flats : Flats
        Flanks in the plane.
    cloud : bool
        True to draw the paths under random errors instead of pattern and first contacts.

    Returns
    -------
    Figure or None
        None without flanks.
    """
    # Space above and below a flank.
    above_px, below_px = 40.0, 40.0
    both = flats.flanks[results.flank]
    if not any(both):
        return None
    heights = [above_px + below_px + height for height in flats.heights]
    chart = Figure(figsize=(WIDTH_PX / 72.0, sum(heights) / 72.0), dpi=72.0)
    top = 1.0
    for number, (one, height) in enumerate(zip(both, heights, strict=True)):
        share = height / sum(heights)
        box = (0.0, top - share + below_px / sum(heights), 1.0, share - (above_px + below_px) / sum(heights))
        axes = chart.add_axes(box)
        top -= share
        axes.set_title(MEMBERS[number].capitalize(), x=0.0, pad=22.0)
        if one is None:
            axes.set_axis_off()
            axes.text(SIDE_PX / WIDTH_PX, 0.5, "no flank: it ends short of its tip", transform=axes.transAxes)
            continue
        flattened_flank.outline(axes, one, flats.scales[one], theme.METALS[number], WIDTH_PX)
        if cloud and results.cloud is not None:
            charts.cloud(axes, one.place, points_on(results.cloud, number), theme.BLUE, 0.28)
        if not cloud and results.pattern is not None:
            side = (results.pattern.result.pinion, results.pattern.result.gear)[number]
            flattened_flank.shade_pattern(axes, one, side, results.pattern.result.separation)
        if results.contact.reason is None:
            flattened_flank.path(axes, one, results.contact.path, number, 1.6 if cloud else 2.2)
        if not cloud and results.contact.lines is not None:
            flattened_flank.lines(axes, one, results.contact.lines, number)
        elif not cloud and results.operation is not None:
            flattened_flank.contacts(axes, one, results.operation, number)
    return chart


def _scales(flats: list[FlatFlank], largest_height_px: float) -> dict[FlatFlank, float]:
    """Return pixels per mm of each flank: equal, unless one flank would be too small."""
    # Ratio of sizes above which a flank has a separate scale.
    small_by = 2.0
    size_px = np.array([WIDTH_PX - 2.0 * SIDE_PX, largest_height_px])
    fitting = np.array([(size_px / one.span).min() for one in flats])
    return dict(
        zip(flats, np.where(fitting > small_by * fitting.min(), fitting, fitting.min()).tolist(), strict=True)
    )


def same_heights(drawn: Sequence[Figure]) -> None:
    """Set equal vertical limits for charts side by side, unless the curves of one would be flat."""
    # Ratio of ranges above which the curves of a flank have separate limits.
    flat_by = 5.0
    for row in zip(*(chart.axes for chart in drawn), strict=True):
        ranges = np.array([axes.get_ylim() for axes in row])
        low, high = ranges.min(), ranges.max()
        for axes, curve in zip(row, ranges, strict=True):
            if high - low < flat_by * np.ptp(curve):
                axes.set_ylim(low, high)


def ease_off_chart(results: FlankResults, report: EaseOffReport) -> Figure | None:
    """Draw contour lines of the ease-off of the pinion with the path of contact, as designed and unmodified
    (without parabolas and modifications). Returns None without an ease-off."""
    names = {GIVEN: "as designed", PLAIN: "unmodified"} if report.modified else {GIVEN: ""}
    cases = {case: report.known.get((results.flank, case)) for case in names}
    given = cases[GIVEN]
    if given is None or not np.isfinite(given.deviation).any():
        return None
    chart = new_chart(205.0 * len(cases))
    for axes, (case, one) in zip(
        chart.subplots(len(cases), 1, squeeze=False)[:, 0], cases.items(), strict=True
    ):
        axes.set_title(names[case].capitalize())
        if one is None or not np.isfinite(one.deviation).any():
            axes.set_axis_off()
            theme.message(axes, "no path of contact")
            continue
        _levels(axes, one)
        path = results.contact.path
        if case == GIVEN:
            points = np.stack((path.pinion_z, path.l1), axis=-1)[path.status == Status.SOLVED]
            axes.plot(*points.T, color=theme.VERMILLION, linewidth=2.0)
            axes.plot(*points[0], "o", color=theme.VERMILLION, markersize=6.0)
    return chart


def _levels(axes: Axes, ease_off: EaseOff) -> None:
    """Draw contour lines, um, over the flank."""
    values = np.ma.masked_invalid(1e3 * ease_off.deviation)
    if float(np.abs(values).max()) < charts.ZERO_EASE_OFF_UM:
        values[:] = 0.0
        theme.message(axes, "zero within rounding", backgroundcolor="white")
    levels = MaxNLocator(8, steps=[1, 2, 5, 10]).tick_values(float(values.min()), float(values.max()))
    styles: dict[str, Any] = {
        "colors": [theme.BLUE if level else theme.INK for level in levels],
        "linewidths": [1.2 if level else 1.8 for level in levels],
        "linestyles": ["-" if level >= 0.0 else "--" for level in levels],
    }
    lines = axes.contour(ease_off.z, ease_off.l, values, levels=levels, **styles)
    names: Callable[[float], str] = partial(_level_name, step=float(np.diff(levels)[0]))
    half = np.array((np.ptp(ease_off.z), np.ptp(ease_off.l))) / 2.0
    middle = np.array((ease_off.z.min(), ease_off.l.min())) + half
    for label in axes.clabel(lines, fontsize=theme.SMALL, fmt=names, colors=theme.INK):
        if np.abs((label.get_position() - middle) / half).max() > 0.88:  # it would cross the border
            label.remove()  # outside the axes
    rim = [np.concatenate((g[0], g[1:, -1], g[-1, -2::-1], g[-2::-1, 0])) for g in (ease_off.z, ease_off.l)]
    axes.plot(*rim, color=theme.GREY, linewidth=1.2)
    axes.set(
        xlabel=f"z (mm), {' to '.join(end_names(ease_off.design.pinion))}", ylabel="l1 (mm), root to tip"
    )
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def _level_name(value: float, step: float) -> str:
    digits = max(0, -int(np.floor(np.log10(step))))
    return theme.signed(value, digits)


def pressure_chart(report: ContactReport) -> Figure | None:
    """Draw the largest Hertzian pressure over the pinion roll. Positions whose ellipse crosses an edge are
    marked. Returns None without pressures."""
    pressed, path = report.pressed, report.path
    if pressed is None or not np.isfinite(pressed.pressure).any():
        return None
    chart = new_chart(210.0)
    axes = chart.add_subplot()
    roll, past = np.degrees(path.pinion_roll), pressed.reaches != NO_LIMIT_REACHED
    crossing = (
        past | np.append(past[1:], False) | np.append(False, past[:-1])
    )  # overlap by one point, so that there is no gap
    label = "ellipse on the flanks" if report.lines is None else "greatest on the line of contact"
    axes.plot(roll, np.where(past, np.nan, pressed.pressure), color=theme.BLUE, label=label)
    if past.any():
        edge = np.where(crossing, pressed.pressure, np.nan)
        axes.plot(roll, edge, "--", color=theme.VERMILLION, label="ellipse beyond an edge")
    axes.set_ylim(0.0, 1.12 * float(np.nanmax(pressed.pressure)))
    axes.margins(x=0.02)
    axes.grid(True)
    if path.flank == "left":
        axes.invert_xaxis()
    axes.set(xlabel="pinion roll (deg)", ylabel="pressure (MPa)")
    chart.legend(loc="outside upper left", ncols=2, **LEGEND)
    return chart


def motion_chart(graph: MotionGraph) -> Figure:
    """Draw the transmission error of every tooth pair alone, and in operation."""
    chart = new_chart(280.0)
    axes = chart.add_subplot()
    motion_graph.draw_graph(axes, graph)
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    chart.legend(handles=motion_graph.legend_entries(), loc="outside upper left", ncols=2, **LEGEND)
    return chart


def error_chart(report: OperationReport) -> Figure:
    """Draw the transmission error over the mesh cycles."""
    pitches = 2
    chart = new_chart(230.0)
    axes = chart.add_subplot()
    charts.error_over_rolls(axes, report, pitches)
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    chart.legend(loc="outside upper left", ncols=3, **LEGEND)
    return chart


def spectrum_chart(report: OperationReport) -> Figure:
    """Draw the amplitudes at multiples of the mesh frequency."""
    chart = new_chart(170.0)
    charts.amplitudes(chart.add_subplot(), report)
    return chart


def sliding_chart(report: SlidingReport) -> Figure:
    """Draw the sliding speed, and the specific sliding of both members, over the pinion roll."""
    chart = new_chart(360.0)
    speed, specific = chart.subplots(2, 1, sharex=True)
    charts.sliding_speed(speed, report, "all")
    charts.specific_sliding(specific, report)
    specific.set_xlabel("pinion roll (deg)")
    for axes in (speed, specific):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.4, **LEGEND)
    return chart


def sensitivity_chart(report: SensitivityReport, quantities: dict[ErrorEffect, float]) -> Figure:
    """Draw the changes of `quantities` under errors of usual size. Limits are the largest change on either
    flank."""
    chart = new_chart(20.0 + 180.0 * len(quantities))
    panels = chart.subplots(len(quantities), 1, squeeze=False)[:, 0]
    steps = steps_of(report.result.errors)
    for axes, (quantity, greatest) in zip(panels, quantities.items(), strict=True):
        changes = charts.changes_under_steps([report.result], quantity)
        charts.changes_under_errors(axes, quantity, changes, greatest, steps)
    handles = charts.marks_of_changes([report.result.flank])
    chart.legend(handles=handles, loc="outside upper left", ncols=3, **LEGEND)
    return chart


def changing(reports: Sequence[SensitivityReport]) -> dict[ErrorEffect, float]:
    """Return the quantities that change under an error, and the largest change of each."""
    greatest = {
        quantity: charts.greatest_of(charts.changes_under_steps([one.result], quantity) for one in reports)
        for quantity in charts.QUANTITIES
    }
    return {quantity: size for quantity, size in greatest.items() if size > 0.0}


def ratio_chart(study: ToleranceStudy) -> Figure:
    """Draw the distribution of the contact ratio over the mountings with a path."""
    chart = new_chart(180.0)
    axes = chart.add_subplot()
    charts.distribution(axes, study, "contact_ratio", 1.0, theme.BLUE)
    axes.set(xlabel="contact ratio by Eq. 16", ylabel="mountings at most (%)")
    return chart
