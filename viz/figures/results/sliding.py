"""Sliding speed and specific sliding along the path of contact, on both flanks."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Design
from beveloid_geom.report.columns import header_of
from beveloid_geom.report.sliding import MEMBERS, SlidingReport, sliding_report
from beveloid_geom.status import Status

from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import REASONS, limit_name
from ...stage import theme
from ...stage.scene import Size

FLANKS = ("right", "left")
CASES: tuple[tuple[str, tuple[float, float] | None, str], ...] = (
    ("as designed", None, "-"),
    ("$a_1$ = \u2212$a_2$ = 0.001 mm$^{-1}$", (0.001, -0.001), "--"),
)
"""Name, parabola coefficients and line style of each case."""
COLOURS = dict(zip(MEMBERS, (theme.BLUE, theme.RED), strict=True))
POINTS = 201
LOWEST, HIGHEST = -5.0, 1.0
"""Specific sliding at which a curve is cut off: at the base circle it is infinite, and beyond it, on an
undercut flank, above 1."""
ON_WHITE: dict[str, Any] = {"frameon": True, "edgecolor": "none", "framealpha": 1.0, "borderpad": 0.2}
"""Look of a legend that lines run behind."""
NOTE = (
    "Speeds are per unit of the pinion's speed: times rad/s they are in mm/s. Thin lines, as designed: the"
    " sizes of its components along the pinion's tooth trace and square to it. Dots: least speed. Specific"
    " sliding is the sliding square to the tooth trace over the same component of the speed of the member's"
    " transverse profile, on parallel axes that of DIN 3960 and ISO 21771. The flanks of crossed gears slide"
    " along the trace everywhere: the least speed is not zero, and need not be at the pitch point. The path"
    " enters on the left. Pitch point: where the path as designed comes nearest to it."
)


@dataclass(frozen=True, eq=False)
class Curve:
    """One case on one flank: its name, line style, and what was found."""

    name: str
    style: str
    report: SlidingReport

    @property
    def found(self) -> bool:
        """Whether there is a path to draw."""
        return self.report.reason is None


def compute(design: Design) -> dict[str, tuple[Curve, ...]]:
    """Sliding of every case on either flank."""
    changed = [design if case[1] is None else design.with_parabola(*case[1]) for case in CASES]
    return {
        flank: tuple(
            Curve(name, style, sliding_report("", one, flank, POINTS))
            for (name, _, style), one in zip(CASES, changed, strict=True)
        )
        for flank in FLANKS
    }


def draw(data: dict[str, tuple[Curve, ...]], size: Size) -> Drawing:
    """A column for each flank: speed above, specific sliding below."""
    page = theme.new_page(
        size,
        "Sliding along the path of contact",
        "Sliding speed of the flanks, and specific sliding of pinion and gear; the pinion drives",
    )
    low = theme.caption(page, NOTE) + theme.inches(page, 0.6)
    gap, high = theme.inches(page, 0.65), theme.top(page) - theme.inches(page, 0.4)
    height, width = (high - low - gap) / 2.0, 0.42
    columns = []
    for column, flank in enumerate(FLANKS):
        left = 0.065 + 0.5 * column
        speed = page.add_axes((left, high - height, width, height))
        specific = page.add_axes((left, low, width, height), sharex=speed)
        for axes, title in ((speed, f"({'ab'[column]})  {flank.capitalize()} flanks"), (specific, "")):
            axes.set_title(title, loc="left", pad=8.0)
            axes.grid(any(curve.found for curve in data[flank]))
        _speeds(speed, data[flank])
        _specific(specific, data[flank])
        _roll_axis(specific, data[flank])
        columns.append((speed, specific))
    for row, words in enumerate(("sliding speed (mm/rad)", "specific sliding")):
        columns[0][row].set_ylabel(words)
        _same_height([pair[row] for pair in columns])
    return Drawing(page, {})


def _degrees(curve: Curve) -> FloatArray:
    return np.degrees(curve.report.path.pinion_roll)


def _speeds(axes: Axes, curves: tuple[Curve, ...]) -> None:
    """Sliding speed of all cases, and the components of the first that is found."""
    _say_missing(axes, curves)
    found = [curve for curve in curves if curve.found]
    for curve in found[:1]:
        for name, words, side in (("lengthwise", "along the trace", -4), ("profile", "square to it", 4)):
            values = np.abs(curve.report.columns[f"pinion_{name}"])
            axes.plot(_degrees(curve), values, color=theme.GREY, linewidth=1.2)
            place = (_degrees(curve)[POINTS // 5], values[POINTS // 5])
            va = "top" if side < 0 else "bottom"
            _label(axes, words, place, (4, side), va=va, fontsize=theme.SMALL, color=theme.GREY)
    for curve in curves:
        path = curve.report.path
        if not curve.found:
            status = REASONS.get(Status(int(path.ends.status)), "no path")
            axes.plot([], [], curve.style, color=theme.INK, label=f"{curve.name}: {status}")
            continue
        enter, leave = limit_name(path.ends.enter), limit_name(path.ends.leave)
        label = f"{curve.name}: enters at the {enter}, leaves at the {leave}"
        axes.plot(_degrees(curve), curve.report.columns["speed"], curve.style, color=theme.INK, label=label)
        least = (float(np.degrees(curve.report.least_roll)), curve.report.least_speed)
        axes.plot(*least, "o", color=theme.INK, markersize=7.0)
        if curve is found[0]:
            _label(axes, f"least {least[1]:.4g} mm/rad", least, (0, 10), ha="center")
    if found:
        axes.set_ylim(0.0, 1.3 * max(curve.report.ranges["speed"][1] for curve in found))
        axes.legend(loc="upper left", fontsize=theme.SMALL, **ON_WHITE)


def _label(axes: Axes, text: str, place: tuple[float, float], by: tuple[float, float], **style: Any) -> None:
    """Text beside a place, `by` so many points, legible over lines."""
    words = axes.annotate(text, place, xytext=by, textcoords="offset points", **style)
    words.set_path_effects([withStroke(linewidth=3.0, foreground="white")])


def _specific(axes: Axes, curves: tuple[Curve, ...]) -> None:
    """Specific sliding of both members in all cases."""
    _say_missing(axes, curves)
    for curve in curves:
        for j, member in enumerate(MEMBERS):
            values = curve.report.sliding.specific[:, j]
            shown = np.where((values < LOWEST) | (values > HIGHEST), np.nan, values)
            label = member if curve is next((c for c in curves if c.found), None) else None
            axes.plot(_degrees(curve), shown, curve.style, color=COLOURS[member], label=label)
    if any(curve.found for curve in curves):
        axes.axhline(0.0, color=theme.GREY, linewidth=1.0, zorder=1.8)
        axes.legend(loc="lower center", ncols=2, **ON_WHITE)


def _roll_axis(axes: Axes, curves: tuple[Curve, ...]) -> None:
    """Pinion roll in the sense in which the pinion drives, and the pitch point in both panels."""
    axes.set_xlabel("pinion roll (deg)")
    found = [curve for curve in curves if curve.found]
    if not found:
        axes.set_xticks([])
        return
    rolls = np.concatenate([_degrees(curve) for curve in found])
    room = 0.03 * float(np.ptp(rolls))
    low, high = float(rolls.min()) - room, float(rolls.max()) + room
    axes.set_xlim(*((low, high) if found[0].report.path.flank == "right" else (high, low)))
    pitch = float(np.degrees(found[0].report.pitch_roll))
    if np.isfinite(pitch):
        for panel in (axes, *axes.get_shared_x_axes().get_siblings(axes)):
            panel.axvline(pitch, color=theme.GREY, linewidth=1.2, linestyle=":")
        style: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "ha": "center", "color": theme.GREY}
        _label(axes, "pitch point", (pitch, 1.0), (0, 4), fontsize=theme.SMALL, **style)


def _say_missing(axes: Axes, curves: tuple[Curve, ...]) -> None:
    """Why there is nothing in a panel."""
    if not any(curve.found for curve in curves):
        axes.set_yticks([])
        text = textwrap.fill(f"no contact: {curves[0].report.reason}", 46)
        axes.text(0.5, 0.6, text, transform=axes.transAxes, ha="center", va="center")


def _same_height(panels: list[Axes]) -> None:
    """One scale for both flanks."""
    drawn = [panel for panel in panels if panel.get_legend()]
    limits = np.array([panel.get_ylim() for panel in drawn])
    for panel in drawn:
        panel.set_ylim(limits[:, 0].min(), limits[:, 1].max())


def rows(data: dict[str, tuple[Curve, ...]]) -> Table:
    """Every position of every case; a case without contact in one row that says so."""
    names = tuple(next(iter(data.values()))[0].report.columns)
    header = ("case", "flank", *(header_of(name) for name in names), "reason")

    def body() -> Iterator[list[object]]:
        for flank, curves in data.items():
            for curve in curves:
                case = curve.name.replace("$", "")
                if not curve.found:
                    yield [case, flank, *[""] * len(names), curve.report.reason]
                columns = curve.report.columns.values()
                for values in zip(*(column.tolist() for column in columns), strict=True):
                    yield [case, flank, *values, ""]

    return header, body()


RECIPES = {"sliding": Recipe(compute, draw, rows)}
