"""Fig. 11: contact ratio against the parabola coefficient, for the four combinations of signs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.contact.path import PathEnds, path_ends
from beveloid_geom.operation.operating_ratio import operating_ratios

from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, limit_name
from ...stage import theme
from ...stage.layout import Cells
from .fig_07_to_10_paths import CASES, SignCase, coefficient_text

POINTS, EVERY = 161, slice(None, None, 16)
"""Coefficients at which Eq. 16 is evaluated, and those of them at which the mesh cycle is solved."""
EDGES = {"right": "^", "left": "v"}
LOOKS = {"right": (theme.BLUE, 3.5, "-"), "left": (theme.ORANGE, 1.6, "--")}
EDGE = 0.25
"""Share of an axis from its ends where words stand on the inner side of their place."""
CELLS = Cells(left=0.96, right=0.96, across=1.76, down=1.35, most=2, least=3.4)
NOTE = (
    "Contact ratio by Eq. 16: pinion roll from where the path enters to where it leaves the flanks, over"
    " a pitch (360\u00b0 over the pinion's teeth). A dot stands where other limits, named there, begin to"
    " end the right flank's path. Eq. 16 speaks of the geometry of one tooth pair. Circles: what runs, of all"
    " teeth without load: over how many pitches a tooth pair touches, tangent or on an edge. Triangles: the"
    " part of a mesh cycle in which an edge touches first (scale on the right); none where it is not known."
)

ALONG_LINES = (
    " Without coefficients these flanks touch along lines, with them in a point that runs along the face."
)


@dataclass(frozen=True, eq=False)
class RatioFigure:
    """Coefficients (4, points), 1/mm, magnitudes, and the path's ends on each flank; at EVERY so many of them
    the contact ratio of all teeth and the share of edges; whether without them flanks touch along `lines`."""

    size: FloatArray
    ends: dict[str, tuple[PathEnds, ...]]
    ratio: dict[str, FloatArray]
    edges: dict[str, FloatArray]
    lines: bool


def compute(design: Design) -> RatioFigure:
    """Find ends of all paths, one call for each flank and sign case, and what runs."""
    size = np.stack([np.linspace(0.0, case.at(design).greatest, POINTS) for case in CASES])
    ends = {
        flank: tuple(
            path_ends(design.with_parabola(case.pinion * a + 0.0, case.gear * a + 0.0), flank)
            for case, a in zip(CASES, size, strict=True)
        )
        for flank in FLANKS
    }
    cases = list(zip(CASES, size[:, EVERY], strict=True))
    running = {flank: np.stack([_running(design, flank, *case) for case in cases]) for flank in FLANKS}
    return RatioFigure(
        size,
        ends,
        {flank: found[..., 0] for flank, found in running.items()},
        {flank: found[..., 1] for flank, found in running.items()},
        bool(touches_along_lines(design.with_parabola(0.0, 0.0))),
    )


def _running(design: Design, flank: str, case: SignCase, size: FloatArray) -> FloatArray:
    """Give contact ratio and share of edges (n, 2) of all teeth at coefficients of the magnitudes `size`."""
    found = [
        operating_ratios(design.with_parabola(case.pinion * a + 0.0, case.gear * a + 0.0), flank, (0.0,))
        for a in size.tolist()
    ]
    return np.array([(float(one.ratio[0]), float(one.cycle.edge_share)) for one in found])


def draw(data: RatioFigure, layout: theme.Layout) -> Drawing:
    """Draw four panels, as in the paper."""
    page, low, high = theme.new_page(
        layout,
        "Fig. 11   Contact ratio against the parabola coefficient",
        "Parabola coefficients $a_1$ of the pinion, $a_2$ of the gear",
        NOTE + (ALONG_LINES if data.lines else ""),
        below=0.55,
        above=0.55,
        tall=CELLS.tall(layout, len(CASES), 0.6 * CELLS.width(layout, len(CASES))),
    )
    paths = [ends.contact_ratio for flank in FLANKS for ends in data.ends[flank]]
    values = np.concatenate([*paths, *(data.ratio[flank].ravel() for flank in FLANKS)])
    limits = _limits(values[np.isfinite(values)])
    for index, (case, axes) in enumerate(
        zip(CASES, theme.panels(page, CELLS, len(CASES), low, high), strict=True)
    ):
        lines = _panel(axes, data, index, case)
        axes.set_ylim(*limits)
    theme.legend(page, lines, 3, 0.72, handlelength=2.6, columnspacing=1.4)
    return Drawing(page, {})


def _limits(values: FloatArray) -> tuple[float, float]:
    if not values.size:
        return 0.0, 1.0
    room = max(float(np.ptp(values)), 0.5)
    return float(values.min()) - 0.06 * room, float(values.max()) + 0.12 * room


def _panel(axes: Axes, data: RatioFigure, index: int, case: SignCase) -> list[Line2D]:
    """Draw the contact ratios of both flanks and the share of edges over the coefficient of the pinion, 1/mm;
    give the lines by flank."""
    a = case.pinion * data.size[index]
    lines = []
    for flank in reversed(FLANKS):
        colour, width, style = LOOKS[flank]
        ratio = data.ends[flank][index].contact_ratio
        lines += axes.plot(a, ratio, style, color=colour, linewidth=width, label=f"{flank} flanks, Eq. 16")
        if not np.isfinite(ratio).any():
            axes.text(0.5, 0.5, "the path could not be followed", transform=axes.transAxes, ha="center")
    beside = axes.twinx()
    beside.set(ylim=(-5.0, 105.0), ylabel="edges (%)")
    for flank in reversed(FLANKS):
        colour, width, every = *LOOKS[flank][:2], a[EVERY]
        running: dict[str, Any] = {"color": colour, "linestyle": "", "clip_on": False}
        running["markersize"] = 4.5 if width > 2.0 else 8.5
        lines += axes.plot(every, data.ratio[flank][index], marker="o", label=f"{flank}, running", **running)
        running |= {"markersize": 4.5, "markerfacecolor": "white", "linestyle": ":", "linewidth": 1.0}
        lines += beside.plot(
            every, 100.0 * data.edges[flank][index], marker=EDGES[flank], label=f"{flank}, edges", **running
        )
    axes.set_title(f"({'abcd'[index]})  {_name(case)}", loc="left", pad=10.0)
    axes.set_ylabel("contact ratio")
    other = "$a_2$" if case.pinion == case.gear else "\u2212$a_2$"
    axes.set_xlabel(f"$a_1$ = {other}  (mm$^{{\u22121}}$)")
    axes.set_xlim(min(a[0], a[-1]), max(a[0], a[-1]))
    if case.pinion < 0.0:
        axes.invert_xaxis()
    ticks = case.pinion * np.linspace(0.0, data.size[index, -1], 5) + 0.0
    axes.set_xticks(ticks, [coefficient_text(tick) for tick in ticks])
    axes.grid(True)
    axes.axhline(1.0, color=theme.GREY, linewidth=1.0)
    _mark_kinks(axes, a, data.ends["right"][index])
    return lines


def _mark_kinks(axes: Axes, a: FloatArray, ends: PathEnds) -> None:
    """Mark where other limits begin to end the path on the right flank, and which; of changes close to each
    other the last."""
    changed = np.any(ends.limit[1:] != ends.limit[:-1], axis=-1) & (ends.limit[1:] >= 0).all(axis=-1)
    kinks = np.nonzero(changed)[0] + 1
    for at in kinks[np.diff(kinks, append=2 * POINTS) > POINTS // 10]:
        place = (a[at], ends.contact_ratio[at])
        axes.plot(*place, "o", color=theme.BLUE, markersize=7.0)
        text = " \u2192 ".join(limit_name(code) for code in ends.limit[at].tolist())
        along = float(axes.transAxes.inverted().transform(axes.transData.transform(place))[0])
        side = "left" if along < EDGE else "right" if along > 1.0 - EDGE else "center"
        theme.beside(axes, place, text, (0, 8), ha=side, fontsize=theme.SMALL)


def _name(case: SignCase) -> str:
    pinion, gear = ("positive" if sign > 0.0 else "negative" for sign in (case.pinion, case.gear))
    return f"both coefficients {pinion}" if pinion == gear else f"pinion {pinion}, gear {gear}"


def rows(data: RatioFigure) -> Table:
    """List contact ratio and limits of the path at every coefficient, and what runs where that is known."""
    path = ("contact_ratio", "enters_at", "leaves_at")
    header = ("a1_per_mm", "a2_per_mm", "flank", *path, "operating_contact_ratio", "edge_share")

    def cases() -> Rows:
        """Give the columns of every flank and sign case."""
        for (index, case), flank in product(enumerate(CASES), FLANKS):
            ends, a = data.ends[flank][index], data.size[index]
            names = [[limit_name(code) for code in codes] for codes in ends.limit.T.tolist()]
            running = np.full((2, POINTS), np.nan)
            running[:, EVERY] = data.ratio[flank][index], data.edges[flank][index]
            yield case.pinion * a + 0.0, case.gear * a + 0.0, flank, ends.contact_ratio, *names, *running

    return header, stacked(cases())


RECIPES = {"fig-11": Recipe(compute, draw, rows)}
