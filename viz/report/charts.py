"""The charts of one flank pair: flanks laid flat, transmission error, sensitivity."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import ContactPath
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.operation.pattern import MemberPattern
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.report.sensitivity import STEPS, SensitivityReport
from beveloid_geom.report.sliding import SlidingReport, span_of
from beveloid_geom.status import FirstStatus, Status

from ..stage import theme
from .data import FlankResults
from .flat import FlatFlank, flat_flank
from .svg import SMALL, WIDTH, new_chart

MEMBERS = ("pinion", "gear")
METALS = (theme.STEEL, theme.BRONZE)
ARCSEC = 3600.0 * 180.0 / np.pi
SMALLEST = 1e-6
"""arcsec: below it a curve counts as zero."""
PITCHES = 2
BANDS = (0.25, 0.5, 1.0)
"""Shares of the pattern's separation at which it is shaded."""
EVERY = 8
"""Of the rolls of a mesh cycle, those whose contact points are drawn."""
LEAST_SPECIFIC = -6.0
"""Specific sliding below which a curve leaves its chart: it falls without bound at a base cylinder."""
SIDE, ABOVE, BELOW, GREATEST = 44.0, 40.0, 40.0, 150.0
"""Pixels beside, above and below a flank, and its greatest height."""
SMALL_BY = 2.0
"""Factor by which a flank may be drawn smaller than there is room for, to be to the other's scale."""


def flank_chart(results: FlankResults, cloud: bool = False) -> Figure | None:
    """Pinion flank over gear flank with the path of contact; over the pattern and with the points of first
    contact, or with the `cloud` of paths under drawn errors. None without flanks."""
    members = results.contact.design.members
    flats = [flat_flank(member, results.flank) for member in members]
    known = [flat for flat in flats if flat is not None]
    if not known:
        return None
    scales = _scales(known)
    heights = [ABOVE + BELOW + (scales[flat] * flat.span[1] if flat else GREATEST / 4.0) for flat in flats]
    chart = Figure(figsize=(WIDTH / 72.0, sum(heights) / 72.0), dpi=72.0)
    top = 1.0
    for number, (flat, height) in enumerate(zip(flats, heights, strict=True)):
        share = height / sum(heights)
        box = (0.0, top - share + BELOW / sum(heights), 1.0, share - (ABOVE + BELOW) / sum(heights))
        axes = chart.add_axes(box)
        top -= share
        axes.set_title(MEMBERS[number].capitalize(), x=0.0, pad=22.0)
        if flat is None:
            axes.set_axis_off()
            axes.text(SIDE / WIDTH, 0.5, "no flank: it ends short of its tip", transform=axes.transAxes)
            continue
        _frame(axes, flat, scales[flat], METALS[number])
        if cloud and results.cloud is not None:
            _cloud(axes, flat, results.cloud, number)
        if not cloud and results.pattern is not None:
            _pattern(
                axes, flat, list(results.pattern.sides.values())[number], results.pattern.pattern.separation
            )
        if results.contact.reason is None:
            _path(axes, flat, results.contact.path, number, 1.6 if cloud else 2.2)
        if not cloud and results.operation is not None:
            _contacts(axes, flat, results.operation, number)
    return chart


def _scales(flats: list[FlatFlank]) -> dict[FlatFlank, float]:
    """Pixels a mm of each flank: the same, unless one would be small."""
    room = np.array([WIDTH - 2.0 * SIDE, GREATEST])
    own = np.array([(room / flat.span).min() for flat in flats])
    return dict(zip(flats, np.where(own > SMALL_BY * own.min(), own, own.min()).tolist(), strict=True))


def _frame(axes: Axes, flat: FlatFlank, scale: float, colour: str) -> None:
    """The flank's outline, its four sides named, at `scale` pixels a mm."""
    low, high = flat.outline.min(axis=0), flat.outline.max(axis=0)
    middle = 0.5 * (low[0] + high[0])
    axes.set_xlim(middle - 0.5 * WIDTH / scale, middle + 0.5 * WIDTH / scale)
    axes.set_ylim(low[1], high[1])
    axes.add_patch(Polygon(flat.outline, facecolor=colour, alpha=0.22, edgecolor="none", clip_on=False))
    axes.add_patch(Polygon(flat.outline, fill=False, edgecolor=theme.GREY, linewidth=1.0, clip_on=False))
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_position(("outward", 17.0))
    step = theme.round_length(0.26 * (high[0] - low[0]))
    ticks = np.arange(np.ceil(low[0] / step), np.floor(high[0] / step) + 1.0) * step
    axes.set_xticks(ticks, [f"{tick + 0.0:g}".replace("-", "\u2212") for tick in ticks])
    axes.spines["bottom"].set_bounds(ticks[0], ticks[-1])
    axes.set_yticks([])
    axes.tick_params(length=3.0, pad=2.0)
    root, _, tip = flat.view.frame[:, 1]
    sides = (
        ("toe", (low[0], 0.5 * (low[1] + high[1])), (-7.0, 0.0), "right", "center"),
        ("heel", (high[0], 0.5 * (low[1] + high[1])), (7.0, 0.0), "left", "center"),
        ("tip", (tip[1], tip[0] - root[0]), (0.0, 4.0), "center", "bottom"),
        ("root", (root[1], 0.0), (0.0, -3.0), "center", "top"),
        ("mm", (ticks[-1], low[1]), (14.0, -17.0), "left", "top"),
    )
    for word, at, away, ha, va in sides:
        axes.annotate(
            word,
            at,
            away,
            textcoords="offset points",
            ha=ha,
            va=va,
            fontsize=SMALL,
            color=theme.GREY,
            annotation_clip=False,
        )


def _path(axes: Axes, flat: FlatFlank, path: ContactPath, number: int, width: float) -> None:
    """The path from its dot to its arrow head."""
    good = path.status == Status.SOLVED
    points = path_points(flat, path, number)[good]
    if len(points) < 2:
        return
    axes.plot(*points.T, color=theme.RED, linewidth=width, clip_on=False, solid_capstyle="butt", zorder=4)
    axes.plot(*points[0], "o", color=theme.RED, markersize=2.7 * width, clip_on=False, zorder=4)
    arrow = {"arrowstyle": "-|>,head_width=0.3,head_length=0.6", "color": theme.RED, "linewidth": width}
    arrow |= {"shrinkA": 0.0, "shrinkB": 0.0}
    start = points[max(len(points) - 8, 0)]
    axes.annotate("", tuple(points[-1]), tuple(start), arrowprops=arrow, annotation_clip=False, zorder=4)


def path_points(flat: FlatFlank, path: ContactPath, number: int) -> FloatArray:
    """Places (..., 2) of a path's positions on the flank of pinion (0) or gear (1)."""
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[number]
    return flat.place(flank_point(flat.member, flat.flank, l, u))


def _contacts(axes: Axes, flat: FlatFlank, report: OperationReport, number: int) -> None:
    """Points of first contact, of all teeth, over one mesh cycle: on flanks full, on edges hollow."""
    first = report.first
    good = (first.status == FirstStatus.SOLVED) & ~first.on_fillet[:, number]
    good &= np.arange(good.size) % EVERY == 0
    edge = first.limit[:, 0] >= 0
    l, z = ((first.l1, first.z1), (first.l2, first.z2))[number]
    for chosen, face, size in ((good & ~edge, theme.BLUE, 4.0), (good & edge, "none", 4.6)):
        if chosen.any():
            style: dict[str, Any] = {
                "markeredgecolor": theme.BLUE,
                "markerfacecolor": face,
                "markeredgewidth": 1.2,
            }
            points = flat.at(l[chosen], z[chosen])
            axes.plot(*points.T, "o", markersize=size, clip_on=False, zorder=5, **style)


def _pattern(axes: Axes, flat: FlatFlank, side: MemberPattern, separation: float) -> None:
    """Where the flanks come close, in bands of the separation, on the root of which the area rests."""
    x, y = np.moveaxis(flat.place(side.points), -1, 0)
    root = np.ma.masked_invalid(np.sqrt(np.maximum(side.least, 0.0)))
    if root.count() == 0 or float(root.min()) > np.sqrt(separation):
        return
    for share in BANDS:
        levels = [-1.0, float(np.sqrt(share * separation))]
        axes.contourf(x, y, root, levels, colors=[theme.BLUE], alpha=0.16, antialiased=True)


def _cloud(axes: Axes, flat: FlatFlank, cloud: ContactPath, number: int) -> None:
    """Paths under drawn errors, thin."""
    good = (cloud.status == Status.SOLVED).all(axis=-1)
    paths = list(path_points(flat, cloud, number)[good])
    axes.add_collection(LineCollection(paths, colors=theme.BLUE, linewidths=0.9, alpha=0.28, clip_on=False))


def error_chart(report: OperationReport) -> Figure:
    """Transmission error over mesh cycles, with edge contact and hand-over."""
    chart = new_chart(230.0)
    axes = chart.add_subplot()
    points, cycle, first = report.first.pinion_roll.size, report.cycle, report.first
    edge = np.tile(first.limit[:, 0] >= 0, PITCHES)
    error = np.tile(ARCSEC * (first.transmission_error - float(cycle.mean)), PITCHES)
    share = np.concatenate([np.linspace(0.0, 1.0, points) + pitch for pitch in range(PITCHES)])
    axes.plot(share, error, color=theme.BLUE, label="flank on flank")
    if edge.any():
        axes.plot(share, np.where(edge, error, np.nan), color=theme.RED, label="edge contact")
    changes = (cycle.changes[cycle.hand_over] - float(cycle.start)) / cycle.pitch
    at = np.concatenate([changes + pitch for pitch in range(PITCHES)])
    axes.plot(at, np.interp(at, share, error), "o", color=theme.INK, ms=5.0, label="hand-over")
    swing = ARCSEC * float(cycle.peak_to_peak)
    if swing < SMALLEST:
        axes.set_ylim(-1.0, 1.0)
        words = f"under {SMALLEST:.6f} arcsec: zero but for rounding"
        axes.text(0.5 * PITCHES, 0.3, words, ha="center", color=theme.GREY)
    axes.set_xlim(0.0, PITCHES)
    axes.set_xlabel("pinion roll, pitches")
    axes.set_ylabel("error, arcsec")
    axes.grid(True)
    chart.legend(loc="outside upper left", ncols=3, handlelength=1.4, columnspacing=1.4, borderpad=0.0)
    return chart


def spectrum_chart(report: OperationReport) -> Figure:
    """Amplitudes at the mesh frequency and its multiples."""
    chart = new_chart(170.0)
    axes = chart.add_subplot()
    amplitude = ARCSEC * np.abs(report.cycle.harmonics)
    orders = np.arange(1, amplitude.size + 1)
    axes.set_xticks(orders)
    axes.set_xlim(0.4, amplitude.size + 0.6)
    axes.set_xlabel("multiple of the mesh frequency")
    axes.set_ylabel("amplitude, arcsec")
    axes.grid(True, axis="y")
    if amplitude.max(initial=0.0) < SMALLEST:
        axes.set_ylim(0.0, 1.0)
        axes.text(
            0.5, 0.5, "all zero but for rounding", transform=axes.transAxes, ha="center", color=theme.GREY
        )
    else:
        axes.bar(orders, amplitude, width=0.55, color=theme.BLUE)
    return chart


def sliding_chart(report: SlidingReport) -> Figure:
    """Speed of sliding, and specific sliding of both members, over the pinion's roll."""
    chart = new_chart(360.0)
    speed, specific = chart.subplots(2, 1, sharex=True)
    roll, found = np.degrees(report.sliding.pinion_roll), report.sliding
    speed.plot(roll, found.speed, color=theme.RED, label="sliding, all")
    speed.plot(roll, np.abs(found.lengthwise[:, 0]), color=theme.GREY, ls="--", label="along the face")
    speed.plot(roll, np.abs(found.profile[:, 0]), color=theme.BLUE, ls="-.", label="along the profile")
    speed.set_ylim(bottom=0.0)
    speed.set_ylabel("speed, mm/rad")
    for number, member in enumerate(MEMBERS):
        dash = ("-", "--")[number]
        specific.plot(roll, found.specific[:, number], color=theme.BLUE, ls=dash, label=member)
    low, high = span_of(found.specific)
    if np.isfinite(low) and low < LEAST_SPECIFIC:
        specific.set_ylim(LEAST_SPECIFIC, min(max(high, 0.0), 1.0) + 0.3)
    specific.axhline(0.0, color=theme.GREY, linewidth=0.8)
    specific.set_ylabel("specific sliding")
    specific.set_xlabel("pinion roll, deg")
    for axes in (speed, specific):
        if not np.isnan(report.pitch_roll):
            axes.axvline(np.degrees(report.pitch_roll), color=theme.INK, linewidth=0.8, ls=":")
        axes.grid(True)
        axes.margins(x=0.0)
        style = {"handlelength": 1.8, "columnspacing": 1.4, "borderpad": 0.0, "borderaxespad": 0.4}
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, **style)
    return chart


def sensitivity_chart(report: SensitivityReport) -> Figure:
    """What errors of a usual size do to place, contact ratio and transmission error."""
    found = report.found
    sizes = np.array([np.radians(size) if unit == "deg" else size for _, size, unit in STEPS])
    names = [f"{name}, {size:g} {unit}" for name, size, unit in STEPS]
    panels = (
        ("Path on the pinion, along the face, mm", found.face_shift_by[1, 0] * sizes, 3),
        ("Contact ratio", found.contact_ratio_by * sizes, 4),
        ("Transmission error along the path, arcsec", ARCSEC * found.peak_to_peak_by * sizes, 3),
    )
    chart = new_chart(410.0)
    rows = chart.subplots(len(panels), 1, sharey=True)
    rows[0].set_ylim(len(names) - 0.5, -0.5)
    for axes, (title, values, digits) in zip(rows, panels, strict=True):
        axes.set_title(title, pad=6.0)
        axes.barh(names, values, height=0.55, color=theme.BLUE)
        axes.axvline(0.0, color=theme.GREY, linewidth=0.8)
        greatest = float(np.abs(values).max())
        reach = 1.7 * greatest if greatest > 0.5 * 10.0**-digits else 1.0
        axes.set_xlim(-reach, reach)
        axes.tick_params(left=False)
        axes.spines["left"].set_visible(False)
        axes.grid(True, axis="x")
        axes.xaxis.set_major_locator(MaxNLocator(5))
        for row, value in enumerate(values):
            left = value < 0.0
            text = theme.signed(float(value), digits)
            at = (min(value, 0.0) if left else max(value, 0.0), row)
            axes.annotate(
                text,
                at,
                (-4.0 if left else 4.0, 0.0),
                textcoords="offset points",
                ha="right" if left else "left",
                va="center",
                fontsize=SMALL,
            )
    return chart


def ratio_chart(results: FlankResults) -> Figure:
    """How the contact ratio spreads over the mountings that have a path."""
    assert results.study is not None
    chart = new_chart(180.0)
    axes = chart.add_subplot()
    mountings = results.study.mountings
    ratio = mountings.contact_ratio[mountings.solved]
    low, high = np.quantile(ratio, (0.001, 0.999))
    wide = max(float(high - low), 1e-6)
    share, edges = np.histogram(ratio, bins=60, range=(float(low) - 0.02 * wide, float(high) + 0.02 * wide))
    axes.stairs(100.0 * share / results.study.cases, edges, fill=True, color=theme.BLUE, alpha=0.75)
    axes.axvline(float(results.study.nominal.contact_ratio[0]), color=theme.RED, linewidth=2.0)
    axes.set_xlabel("contact ratio by Eq. 16")
    axes.set_ylabel("mountings, %")
    axes.margins(x=0.0)
    return chart
