"""Fig. 11: contact ratio against the parabola coefficient, for the four combinations of signs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray, Integers
from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.contact.path import PathEnds, path_ends
from beveloid_geom.design.ends import limit_words
from beveloid_geom.operation.operating_ratio import operating_ratios

from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.free_space import Labels
from ...components.paths_table import FLANKS
from ...components.touching import limit_code
from ...rendering import theme
from ...rendering.layout import PanelRows
from .fig_07_to_10_paths import CASES, SignCase, coefficient_texts

CYCLE_POINTS = slice(None, None, 16)
"""Coefficients for which the mesh cycle is computed."""
LOOKS = {"right": (theme.BLUE, 3.5, "-", "^"), "left": (theme.ORANGE, 1.6, "--", "v")}
"""Colour, line width and dashes by flank, and marker of edge contact."""


@dataclass(frozen=True, eq=False)
class RatioFigure:
    """Contact ratios of a `design` over its coefficients.

    `size` (4, points), 1/mm: magnitudes. `ends`: ends of the paths on each flank. `ratio` and `edges`:
    contact ratio of all teeth and fraction of the cycle with edge contact at every CYCLE_POINTS-th
    coefficient. `lines`: whether unmodified flanks touch along lines."""

    design: Design
    size: FloatArray
    ends: dict[str, tuple[PathEnds, ...]]
    ratio: dict[str, FloatArray]
    edges: dict[str, FloatArray]
    lines: bool


def compute(design: Design) -> RatioFigure:
    """Compute the ends of all paths, one call for each flank and sign case, and the mesh cycles."""
    size = np.stack([np.linspace(0.0, case.at(design).greatest, 161) for case in CASES])
    designs = [case.changed(design, a) for case, a in zip(CASES, size, strict=True)]
    ends = {flank: tuple(path_ends(one, flank) for one in designs) for flank in FLANKS}
    cases = list(zip(CASES, size[:, CYCLE_POINTS], strict=True))
    running = {flank: np.stack([_running(design, flank, *case) for case in cases]) for flank in FLANKS}
    ratio, edges = ({flank: values[..., k] for flank, values in running.items()} for k in (0, 1))
    return RatioFigure(design, size, ends, ratio, edges, bool(touches_along_lines(design.unmodified())))


def _running(design: Design, flank: str, case: SignCase, size: FloatArray) -> FloatArray:
    """Return contact ratio of all teeth and fraction of edge contact (n, 2) for the magnitudes `size`."""
    ratios = [operating_ratios(case.changed(design, a), flank, (0.0,)) for a in size.tolist()]
    return np.array([(float(one.ratio[0]), float(one.cycle.edge_share)) for one in ratios])


def draw(data: RatioFigure, layout: theme.PageLayout) -> Drawing:
    """Draw four panels, as in the paper."""
    note = (
        "Lines: Eq. 16, the contact ratio of one tooth pair. Circles: contact ratio of all"
        " teeth in operation, without load, edges included. Triangles: fraction of the mesh cycle"
        " with edge contact (right scale)."
    )
    cells = PanelRows(left=0.96, right=0.96, across=1.76, down=1.35, most=2, least=3.4)
    kinks_note = " Labelled dots: from here on, the path of the right flank runs between the edges named."
    unknown_note = " Without circle: contact ratio of all teeth unknown."
    along_lines = " Unmodified flanks touch along lines."
    labelled = np.concatenate([ends.contact_ratio[_kinks(ends)] for ends in data.ends["right"]])
    missing = any(np.isnan(ratio).any() for ratio in data.ratio.values())
    notes = (note, True), (kinks_note, labelled.size), (along_lines, data.lines), (unknown_note, missing)
    page, low, high = theme.new_page(
        layout,
        f"Fig. 11   {finding(data)}",
        "Contact ratio against the parabola coefficients $a_1$ of the pinion, $a_2$ of the gear",
        "".join(text for text, shown in notes if shown),
        below=0.55,
        above=0.55,
        tall=cells.tall(layout, len(CASES), 0.6 * cells.width(layout, len(CASES))),
    )
    paths = [ends.contact_ratio for flank in FLANKS for ends in data.ends[flank]]
    values = np.concatenate([*paths, *(data.ratio[flank].ravel() for flank in FLANKS)])
    limits = _limits(values[np.isfinite(values)], labelled[:0] if layout.wide else labelled)
    for index, (case, axes) in enumerate(
        zip(CASES, theme.panels(page, cells, len(CASES), low, high), strict=True)
    ):
        axes.set_ylim(*limits)
        lines = _panel(axes, data, index, case)
    theme.legend(page, lines, 3, 0.72, handlelength=2.6, columnspacing=1.4)
    return Drawing(page, {})


def finding(data: RatioFigure) -> str:
    """Return the title: contact ratios of the modified flanks by Eq. 16 and of all teeth."""
    path = np.stack([ends.contact_ratio for flank in FLANKS for ends in data.ends[flank]])[:, 1:]
    running = np.concatenate([data.ratio[flank][:, 1:] for flank in FLANKS])
    if not np.isfinite(path).any() or not np.isfinite(running).any():
        return "Contact ratio against the parabola coefficient"
    low, high = np.nanmin(running), np.nanmax(running)
    teeth = f"{low:.2f}" if high - low < 0.005 else f"{low:.2f} to {high:.2f}"
    return f"Modified flanks: contact ratio up to {np.nanmax(path):.2f} by Eq. 16, {teeth} in operation"


def _limits(values: FloatArray, labelled: FloatArray) -> tuple[float, float]:
    """Return the limits of the contact ratio, with space above the values if a label is close to the
    largest."""
    if not values.size:
        return 0.0, 1.0
    span = max(float(np.ptp(values)), 0.5)
    above = 0.35 if np.any(labelled > values.max() - 0.25 * span) else 0.12
    return float(values.min()) - 0.06 * span, float(values.max()) + above * span


def _panel(axes: Axes, data: RatioFigure, index: int, case: SignCase) -> list[Line2D]:
    """Draw contact ratios of both flanks and edge contact over the pinion coefficient; return the lines by
    flank."""
    a = case.pinion * data.size[index]
    lines = []
    for flank in reversed(FLANKS):
        colour, width, style, _ = LOOKS[flank]
        ratio = data.ends[flank][index].contact_ratio
        look: dict[str, Any] = {"color": colour, "linewidth": width, "zorder": 2.5 - 0.1 * width}
        lines += axes.plot(a, ratio, style, label=f"{flank} flanks, Eq. 16", **look)
        if not np.isfinite(ratio).any():
            axes.text(0.5, 0.5, "the path could not be followed", transform=axes.transAxes, ha="center")
    edge_axes = axes.twinx()
    edge_axes.set(ylim=(-5.0, 105.0), ylabel="edges (%)")
    for flank in reversed(FLANKS):
        (colour, width, _, edge_marker), every = LOOKS[flank], a[CYCLE_POINTS]
        running: dict[str, Any] = {"color": colour, "linestyle": "", "clip_on": False}
        running["markersize"] = 4.5 if width > 2.0 else 8.5
        ratio, edges = data.ratio[flank][index], 100.0 * data.edges[flank][index]
        lines += axes.plot(every, ratio, marker="o", label=f"{flank}, all teeth", **running)
        running |= {"markersize": 4.5, "markerfacecolor": "white", "linestyle": ":", "linewidth": 1.0}
        lines += edge_axes.plot(every, edges, marker=edge_marker, label=f"{flank}, edges", **running)
    axes.set_title(f"({'abcd'[index]})  {_name(case)}", loc="left", pad=10.0)
    axes.set_ylabel("contact ratio")
    other = "$a_2$" if case.pinion == case.gear else "\u2212$a_2$"
    axes.set_xlabel(f"$a_1$ = {other}  (mm$^{{\u22121}}$)")
    axes.set_xlim(min(a[0], a[-1]), max(a[0], a[-1]))
    if case.pinion < 0.0:
        axes.invert_xaxis()
    ticks = case.pinion * np.linspace(0.0, data.size[index, -1], 5) + 0.0
    axes.set_xticks(ticks, coefficient_texts(ticks.tolist()))
    axes.grid(True)
    axes.axhline(1.0, color=theme.GREY, linewidth=1.0)
    _mark_kinks(axes, edge_axes, a, data.design, data.ends["right"][index])
    return lines


def _kinks(ends: PathEnds) -> Integers:
    """Return the indices at which the limits of a path change; of changes close together only the last."""
    changed = np.any(ends.limit[1:] != ends.limit[:-1], axis=-1) & (ends.limit[1:] >= 0).all(axis=-1)
    kinks = np.nonzero(changed)[0] + 1
    points = len(ends.limit)
    return kinks[np.diff(kinks, append=2 * points) > points // 10]


def _mark_kinks(axes: Axes, edge_axes: Axes, a: FloatArray, design: Design, ends: PathEnds) -> None:
    """Mark and label the changes of the limits of the path on the right flank. Labels are where they cover no
    curve, if possible."""
    # Labels of points closer than this fraction to an end of the axis are aligned inwards.
    label_margin_fraction = 0.25
    # Heights of labels above their points that are tried, in this order.
    label_heights_pt = (8.0, -18.0, 22.0, -32.0, 36.0, -46.0, 50.0, 64.0)
    kinks = _kinks(ends)
    places = [(float(a[at]), float(ends.contact_ratio[at])) for at in kinks]
    for place in places:
        axes.plot(*place, "o", color=theme.BLUE, markersize=7.0)
    labels = Labels(axes, edge_axes)
    for at, place in zip(kinks, places, strict=True):
        text = " \u2192 ".join(limit_words(design, code) for code in ends.limit[at].tolist())
        along = float(axes.transAxes.inverted().transform(axes.transData.transform(place))[0])
        side, aside = "center", 0.0
        if along < label_margin_fraction:
            side, aside = "left", 24.0
        elif along > 1.0 - label_margin_fraction:
            side, aside = "right", -24.0
        shifts = [(across, up, side) for across in (0.0, aside) for up in label_heights_pt]
        if not labels.put(text, place, shifts, theme.INK):
            theme.label_point(axes, place, text, (0, 8), ha=side, fontsize=theme.SMALL)


def _name(case: SignCase) -> str:
    pinion, gear = ("positive" if sign > 0.0 else "negative" for sign in (case.pinion, case.gear))
    return f"both coefficients {pinion}" if pinion == gear else f"pinion {pinion}, gear {gear}"


def rows(data: RatioFigure) -> Table:
    """List contact ratio and limits of the path at every coefficient, and the values of all teeth if
    known."""
    path = ("contact_ratio", "enters_at", "leaves_at")
    header = ("a1_per_mm", "a2_per_mm", "flank", *path, "operating_contact_ratio", "edge_share")

    def cases() -> Rows:
        """Yield the columns of every flank and sign case."""
        for (index, case), flank in product(enumerate(CASES), FLANKS):
            ends, a = data.ends[flank][index], data.size[index]
            names = [[limit_code(code) for code in codes] for codes in ends.limit.T.tolist()]
            running = np.full((2, a.size), np.nan)
            running[:, CYCLE_POINTS] = data.ratio[flank][index], data.edges[flank][index]
            yield case.pinion * a + 0.0, case.gear * a + 0.0, flank, ends.contact_ratio, *names, *running

    return header, rows_of_cases(cases())


RECIPES = {"fig-11": Recipe(compute, draw, rows)}
