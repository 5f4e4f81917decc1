"""The page's charts of one flank pair: those of `parts`, laid out for its width."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.report.sensitivity import SensitivityReport
from beveloid_geom.report.sliding import MEMBERS, SlidingReport

from ..parts import charts, flat
from ..parts.flat import FlatFlank
from ..parts.solved import points_on
from ..stage import theme
from .data import FlankResults
from .svg import WIDTH, new_chart

PITCHES = 2
SIDE, ABOVE, BELOW, GREATEST = 44.0, 40.0, 40.0, 150.0
"""Pixels beside, above and below a flank, and its greatest height."""
SMALL_BY = 2.0
"""Factor by which a flank may be drawn smaller than there is room for, to be to the other's scale."""
LEGEND: dict[str, Any] = {"handlelength": 1.6, "columnspacing": 1.4, "borderpad": 0.0}


def flank_chart(results: FlankResults, cloud: bool = False) -> Figure | None:
    """Draw the pinion's flank over the gear's with the path of contact; over the pattern and with the points
    of first contact, or with the `cloud` of paths under drawn errors. None without flanks."""
    members = results.contact.design.members
    flats = [flat.flat_flank(member, results.flank) for member in members]
    known = [one for one in flats if one is not None]
    if not known:
        return None
    scales = _scales(known)
    heights = [ABOVE + BELOW + (scales[one] * one.span[1] if one else GREATEST / 4.0) for one in flats]
    chart = Figure(figsize=(WIDTH / 72.0, sum(heights) / 72.0), dpi=72.0)
    top = 1.0
    for number, (one, height) in enumerate(zip(flats, heights, strict=True)):
        share = height / sum(heights)
        box = (0.0, top - share + BELOW / sum(heights), 1.0, share - (ABOVE + BELOW) / sum(heights))
        axes = chart.add_axes(box)
        top -= share
        axes.set_title(MEMBERS[number].capitalize(), x=0.0, pad=22.0)
        if one is None:
            axes.set_axis_off()
            axes.text(SIDE / WIDTH, 0.5, "no flank: it ends short of its tip", transform=axes.transAxes)
            continue
        flat.outline(axes, one, scales[one], theme.METALS[number], WIDTH)
        if cloud and results.cloud is not None:
            charts.cloud(axes, one.place, points_on(results.cloud, number), theme.BLUE, 0.28)
        if not cloud and results.pattern is not None:
            side = (results.pattern.pattern.pinion, results.pattern.pattern.gear)[number]
            flat.pattern(axes, one, side, results.pattern.pattern.separation)
        if results.contact.reason is None:
            flat.path(axes, one, results.contact.path, number, 1.6 if cloud else 2.2)
        if not cloud and results.operation is not None:
            flat.contacts(axes, one, results.operation, number)
    return chart


def _scales(flats: list[FlatFlank]) -> dict[FlatFlank, float]:
    """Give pixels a mm of each flank: the same, unless one would be small."""
    room = np.array([WIDTH - 2.0 * SIDE, GREATEST])
    own = np.array([(room / one.span).min() for one in flats])
    return dict(zip(flats, np.where(own > SMALL_BY * own.min(), own, own.min()).tolist(), strict=True))


def error_chart(report: OperationReport) -> Figure:
    """Draw the transmission error over mesh cycles."""
    chart = new_chart(230.0)
    charts.error_over_rolls(chart.add_subplot(), report, PITCHES)
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
    charts.sliding_speed(speed, report, "sliding, all")
    charts.specific_sliding(specific, report)
    specific.set_xlabel("pinion roll (deg)")
    for axes in (speed, specific):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.4, **LEGEND)
    return chart


def sensitivity_chart(report: SensitivityReport) -> Figure:
    """Draw what errors of a usual size do to place, contact ratio and transmission error."""
    chart = new_chart(760.0)
    for axes, quantity in zip(chart.subplots(4, 1), charts.QUANTITIES, strict=True):
        changes = charts.changes_of([report.found], quantity)
        charts.changes_under_errors(axes, quantity, changes, charts.greatest_of([changes]))
    handles = charts.marks_of_changes([report.found.flank])
    chart.legend(handles=handles, loc="outside upper left", ncols=3, **LEGEND)
    return chart


def ratio_chart(study: ToleranceStudy) -> Figure:
    """Draw how the contact ratio spreads over the mountings that have a path."""
    chart = new_chart(180.0)
    axes = chart.add_subplot()
    charts.spread(axes, study, "contact_ratio", 1.0, theme.BLUE)
    axes.set(xlabel="contact ratio by Eq. 16", ylabel="mountings at most (%)")
    return chart
