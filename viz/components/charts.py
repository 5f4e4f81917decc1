"""Charts of results, used by figures and the report page. Each is a function of axes and a result.

Sizes of text and lines follow the style in use (`theme.style`, `report.svg.chart_style`). A curve that is
zero except for rounding is replaced by a message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from beveloid_geom.analysis.sensitivity import Sensitivity
from beveloid_geom.analysis.tolerance import ToleranceStudy
from beveloid_geom.arrays import FloatArray
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.report.result import MEMBERS
from beveloid_geom.report.sensitivity import Step, steps_of
from beveloid_geom.report.sliding import SlidingReport

from ..rendering import theme

ZERO_ERROR_ARCSEC = 1e-6
"""Transmission errors below this, arcsec, are counted as zero."""
ZERO_EASE_OFF_UM = 1e-6
"""Ease-offs below this, um, are counted as zero."""
MIDDLE_INDEX = 1
"""Index of the mid-point of a path in a `Sensitivity`."""
FLANK_COLOURS = {"right": theme.BLUE, "left": theme.VERMILLION}
LEFT_DASHES = (0.0, (2.0, 1.0))
"""Dash pattern of the stems of the left flanks."""
MEMBER_MARKERS = {"pinion": ("o", 0.0), "gear": ("D", 1.0), "": ("s", 0.5)}
"""Markers of changes on the flank of a member and of changes of the pair, and the offset of their stems."""
Changes: TypeAlias = Mapping[tuple[str, str], FloatArray]
"""Changes (errors,) by flank and member; the member is "" for changes of the pair."""


class ErrorEffect(NamedTuple):
    """Quantity that changes under errors.

    `title`: of the chart, with unit. `name`: its derivatives are the attribute `<name>_by` of `Sensitivity`.
    `unit`: of the chart. `scale`: factor from mm or rad to this unit. `members`: True if pinion and gear have
    different values."""

    title: str
    name: str
    unit: str
    scale: float
    members: bool


QUANTITIES = (
    ErrorEffect("shift along the face (mm)", "face_shift", "mm", 1.0, True),
    ErrorEffect("shift perpendicular to the path (mm)", "square_shift", "mm", 1.0, True),
    ErrorEffect("contact ratio (10\u207b\u00b3)", "contact_ratio", "1e-3", 1e3, False),
    ErrorEffect("transmission error (arcsec)", "peak_to_peak", "arcsec", ARCSEC, False),
)


def error_over_rolls(axes: Axes, report: OperationReport, pitches: int) -> None:
    """Draw the transmission error over the pinion roll (rotation angle of the pinion).

    The error is in arcsec, less its mean, positive if the gear is ahead. Edge contact has another colour. A
    dot marks each hand-over: the roll at which the next tooth pair takes over the contact.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    report : OperationReport
        Mesh cycle.
    pitches : int
        Number of pitches drawn.
    """
    first, cycle = report.first, report.cycle
    edge = np.tile((first.limit[:, 0] >= 0) & (not report.along_lines), pitches)
    error = np.tile(ARCSEC * (first.transmission_error - float(cycle.mean)), pitches)
    each = np.linspace(0.0, 1.0, first.pinion_roll.size)
    share = np.concatenate([each + pitch for pitch in range(pitches)])
    axes.plot(share, error, color=theme.BLUE, label="flank on flank")
    axes.plot(share, np.where(edge, error, np.nan), color=theme.VERMILLION, label="edge contact")
    changes = cycle.changes[cycle.hand_over]
    there = np.tile(ARCSEC * (cycle.at(changes).transmission_error - float(cycle.mean)), pitches)
    at = np.concatenate([(changes - float(cycle.start)) / cycle.pitch + pitch for pitch in range(pitches)])
    axes.plot(at, there, "o", color=theme.INK, ms=5.5, label="hand-over")
    swing = ARCSEC * float(cycle.peak_to_peak)
    if swing < ZERO_ERROR_ARCSEC:
        axes.set_ylim(-1.0, 1.0)
        theme.message(
            axes, f"peak to peak under {ZERO_ERROR_ARCSEC:.6f} arcsec: zero within rounding", 34, 0.25
        )
    else:
        axes.set_ylim(float(error.min()) - 0.12 * swing, float(error.max()) + 0.12 * swing)
    axes.set_xlim(0.0, pitches)
    axes.set(xlabel="pinion roll from the pitch point (pitches)", ylabel="gear ahead (arcsec)")
    axes.grid(True)


def amplitudes(axes: Axes, report: OperationReport) -> None:
    """Draw the amplitudes of the transmission error, arcsec, at multiples of the mesh frequency."""
    values = ARCSEC * np.abs(report.cycle.harmonics)
    orders = np.arange(1, values.size + 1)
    if values.max(initial=0.0) < ZERO_ERROR_ARCSEC:
        axes.set_ylim(0.0, 1.0)
        theme.message(axes, "zero within rounding")
    else:
        axes.bar(orders, values, width=0.6, color=theme.BLUE)
    axes.set_xticks(orders)
    axes.set_xlim(0.4, orders.size + 0.6)
    axes.set(xlabel="multiple of the mesh frequency", ylabel="amplitude (arcsec)")
    axes.set_axisbelow(True)
    axes.grid(True, axis="y")


def sliding_speed(
    axes: Axes, report: SlidingReport, label: str, style: str = "-", parts: bool = True
) -> None:
    """Draw the sliding speed over the pinion roll.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    report : SlidingReport
        Sliding along the path. Units: mm per rad of pinion roll, and deg.
    label : str
        Label in the legend.
    style : str
        Line style. A dot marks the minimum.
    parts : bool
        True to draw the components along the tooth trace of the pinion and perpendicular to it as well.
    """
    roll, sliding = np.degrees(report.path.pinion_roll), report.sliding
    axes.plot(roll, sliding.speed, style, color=theme.INK, label=label)
    lowest: dict[str, Any] = {"color": theme.INK, "ms": 6.0, "clip_on": False}
    axes.plot(np.degrees(report.least_roll), report.least_speed, "o", **lowest)
    if parts:
        thin: dict[str, Any] = {"color": theme.GREY, "linewidth": 1.2}
        axes.plot(roll, np.abs(sliding.lengthwise[:, 0]), label="along the trace", **thin)
        axes.plot(roll, np.abs(sliding.profile[:, 0]), "-.", label="perpendicular to it", **thin)
    axes.set_ylabel("sliding speed (mm/rad)")
    _over_rolls(axes, report, parts)
    axes.set_ylim(bottom=0.0)


def specific_sliding(axes: Axes, report: SlidingReport, dashes: str = "-", named: bool = True) -> None:
    """Draw the specific sliding of both members over the pinion roll, deg; `named` adds them to the
    legend."""
    widths = {"pinion": 3.0, "gear": 1.5}
    roll, specific = np.degrees(report.path.pinion_roll), report.sliding.specific
    # Limits of specific sliding in a chart. It is infinite at the base circle, and above 1 beyond the base
    # circle, on undercut flanks.
    lowest, highest = -5.0, 1.0
    shown = np.where((specific < lowest) | (specific > highest), np.nan, specific)
    for values, member, colour in zip(shown.T, MEMBERS, FLANK_COLOURS.values(), strict=True):
        look: dict[str, Any] = {"color": colour, "linewidth": widths[member]}
        axes.plot(roll, values, dashes, label=member if named else None, **look)
    axes.axhline(0.0, color=theme.GREY, linewidth=0.8, zorder=1.8)
    axes.set_ylabel("specific sliding")
    _over_rolls(axes, report, named)
    if named and np.isfinite(report.pitch_roll):
        at, across = (float(np.degrees(report.pitch_roll)), 0.0), axes.get_xaxis_transform()
        style: dict[str, Any] = {"color": theme.GREY, "fontsize": "small", "annotation_clip": None}
        theme.label_point(axes, at, report.pitch_name, (4.0, 4.0), xycoords=across, **style)


def _over_rolls(axes: Axes, report: SlidingReport, marked: bool) -> None:
    """Set the axis of pinion roll in the sense of rotation, with a dotted line at the `pitch_roll`."""
    if marked and np.isfinite(report.pitch_roll):
        axes.axvline(float(np.degrees(report.pitch_roll)), color=theme.GREY, linewidth=1.0, ls=":")
    axes.grid(True)
    axes.margins(x=0.02)
    if report.path.flank == "left" and not axes.xaxis_inverted():
        axes.invert_xaxis()


def distribution(
    axes: Axes, study: ToleranceStudy, name: str, scale: float, colour: str, width: float = 2.5
) -> None:
    """Draw the cumulative distribution of a quantity.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    study : ToleranceStudy
        Results of all mountings. Mountings without a path are left out; a dot marks the design without
        errors.
    name : str
        Name of the quantity.
    scale : float
        Factor to the unit of the chart.
    colour : str
        Colour.
    width : float
        Line width, points.
    """
    mountings, nominal = (
        scale * result.quantities()[name][result.solved] for result in (study.mountings, study.nominal)
    )
    if name == "peak_to_peak":
        mountings, nominal = (np.where(v < ZERO_ERROR_ARCSEC, 0.0, v) for v in (mountings, nominal))
    axes.plot(np.sort(mountings), np.linspace(0.0, 100.0, mountings.size), color=colour, lw=width)
    for value in nominal.tolist():
        share = 50.0 if np.ptp(mountings) == 0.0 else 100.0 * float(np.mean(mountings <= value))
        axes.plot(value, share, "o", color=colour, ms=4.0 + width)
    axes.set_ylim(-2.0, 102.0)
    axes.grid(True)


def cloud(
    axes: Axes, place: Callable[[FloatArray], FloatArray], paths: FloatArray, colour: str, alpha: float
) -> None:
    """Draw paths as thin transparent lines.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    place : callable
        Converts points (..., 3), mm, to coordinates (..., 2) of the axes.
    paths : ndarray, shape (paths, points, 3)
        Paths, mm. A path with any NaN is left out completely.
    colour : str
        Colour.
    alpha : float
        Opacity.
    """
    seen = list(place(paths[np.isfinite(paths).all(axis=(1, 2))]))
    axes.add_collection(LineCollection(seen, colors=colour, linewidths=1.0, alpha=alpha, clip_on=False))


def changes_under_steps(sensitivities: Iterable[Sensitivity], quantity: ErrorEffect) -> Changes:
    """Return the changes of a quantity in its unit under one step of each error (`steps_of`); NaN if
    unknown."""
    changes: dict[tuple[str, str], FloatArray] = {}
    for rates in sensitivities:
        sizes = np.array([step.size for step in steps_of(rates.errors)])
        by = quantity.scale * getattr(rates, f"{quantity.name}_by") * sizes
        if quantity.members:
            changes |= {(rates.flank, member): by[MIDDLE_INDEX, j] for j, member in enumerate(MEMBERS)}
        else:
            changes[rates.flank, ""] = by
    return changes


def greatest_of(panels: Iterable[Changes]) -> float:
    """Return the largest change of all panels; 0 if there is none."""
    values = np.abs([row for changes in panels for row in changes.values()])
    return float(values[np.isfinite(values)].max(initial=0.0))


def changes_under_errors(
    axes: Axes, quantity: ErrorEffect, changes: Changes, greatest: float, steps: Sequence[Step]
) -> None:
    """Draw the changes of a quantity under each error as stems from zero.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    quantity : ErrorEffect
        Quantity that changes.
    changes : mapping
        Changes by flank and member. Colours and dashes distinguish flanks, markers distinguish members.
    greatest : float
        Largest change of all panels, which sets the scale.
    steps : sequence of Step
        Errors and their sizes.
    """
    zero = 1e-9  # changes below this fraction of the largest are counted as zero
    # Axes narrower than this have the values in a column on the right.
    narrow_in = 2.9
    axes.set_title(quantity.title, fontsize=theme.LABEL, pad=6.0)
    flanks = list(dict.fromkeys(flank for flank, _ in changes))
    lines = 2.0 * len(flanks) + 1.0  # lines per error; the last is empty
    blocks = lines * np.arange(float(len(steps)))
    axes.set_ylim(blocks[-1] + lines - 1.0, -1.0)
    axes.set_yticks(
        blocks + 0.5 * lines - 1.0, [f"{step.name}\n+{step.shown:g} {step.unit}" for step in steps]
    )
    axes.tick_params(axis="y", length=0.0)
    axes.spines["left"].set_visible(False)
    for low in blocks[::2] - 1.0:
        axes.axhspan(low, low + lines, color=theme.PALE, alpha=0.35, lw=0.0)
    axes.axvline(0.0, color=theme.GREY, linewidth=1.0)
    rows = np.array(list(changes.values()))
    narrow = axes.get_window_extent().width < narrow_in * axes.figure.dpi
    if not rows[np.isfinite(rows)].any():
        axes.set_xlim(-1.0, 1.0)
        axes.set_xticks([0.0], ["0"], fontsize=theme.SMALL)
        known = np.isfinite(rows).any()
        words = "0 under every error" if known else "unknown"
        theme.message(axes, words, 12 if narrow else 36, backgroundcolor="white")
        return
    low, high = (1.15, 2.6) if narrow else (1.9, 1.9)  # space for values at both ends, or on the right
    axes.set_xlim(-low * greatest, high * greatest)
    tick = _tick(greatest) if narrow else theme.round_length(greatest)
    texts = [f"{mark:g}".replace("-", "\u2212") for mark in (-tick, 0.0, tick)]
    axes.set_xticks([-tick, 0.0, tick], texts, fontsize=theme.SMALL)
    axes.minorticks_off()
    for (flank, member), row in changes.items():
        marker, line = MEMBER_MARKERS[member]
        dashes = LEFT_DASHES if flank != flanks[0] else "-"
        look: dict[str, Any] = {"color": FLANK_COLOURS[flank], "ls": dashes, "marker": marker}
        at = blocks + 2.0 * flanks.index(flank) + line
        _stems(axes, np.where(np.abs(row) > zero * greatest, row, 0.0 * row), at, look, narrow)


def _tick(greatest: float) -> float:
    """Return the tick of a narrow axis: the largest short number up to 1.15 times the greatest value, so that
    the labels of 0 and of the ticks on both sides are apart."""
    steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    decade = 10.0 ** float(np.floor(np.log10(1.15 * greatest)))
    return float(f"{max(step for step in steps if step * decade <= 1.15 * greatest) * decade:.2g}")


def _stems(axes: Axes, values: FloatArray, lines: FloatArray, look: dict[str, Any], apart: bool) -> None:
    """Draw a stem from zero on each line; the value is at its end or, with `apart`, on the right of the
    axes."""
    colour = look["color"]
    for value, y in zip(values.tolist(), lines.tolist(), strict=True):
        if np.isnan(value):
            axes.text(0.0, y, "  not known", color=colour, va="center", fontsize=theme.SMALL)
            continue
        axes.plot([0.0, value], [y, y], color=colour, linewidth=2.0, ls=look["ls"])
        axes.plot([value], [y], ms=6.5, mfc="white" if look["marker"] == "D" else colour, **look)
        away, ha = (-8.0, "right") if value < 0.0 else (8.0, "left")
        style: dict[str, Any] = {"ha": ha, "va": "center", "color": colour, "fontsize": theme.SMALL}
        if apart:
            style |= {"ha": "right", "transform": axes.get_yaxis_transform()}
            axes.text(1.0, y, _three_digits(value), **style)
            continue
        theme.label_point(axes, (value, y), _three_digits(value), (away, -0.5), **style)


def _three_digits(value: float) -> str:
    """Return a number with three digits and sign, without exponent."""
    if value == 0.0:
        return "0"
    digits = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return theme.signed(value, min(digits, 6))


def marks_of_changes(flanks: Sequence[str], quantities: Sequence[ErrorEffect] = QUANTITIES) -> list[Line2D]:
    """Return legend entries for `changes_under_errors`: flanks, if there are several, and the members or the
    pair to which the quantities belong."""
    by_member = {one.members for one in quantities}
    entries = []
    for flank in flanks if len(flanks) > 1 else ():
        dashes = LEFT_DASHES if flank != flanks[0] else "-"
        entries.append(Line2D([], [], color=FLANK_COLOURS[flank], ls=dashes, label=f"{flank} flank"))
    for member, (marker, _) in MEMBER_MARKERS.items():
        if bool(member) not in by_member:
            continue
        face, label = "white" if marker == "D" else theme.INK, member or "pair"
        look: dict[str, Any] = {"marker": marker, "ms": 6.5, "mfc": face}
        entries.append(Line2D([], [], color=theme.INK, lw=2.0, label=label, **look))
    return entries
