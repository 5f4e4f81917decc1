"""Fig. 11: contact ratio against the parabola coefficient, for the four combinations of signs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import PathEnds, path_ends

from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, limit_name
from ...stage import theme
from .fig_07_to_10_paths import CASES, SignCase, coefficient_text

POINTS = 161
LOOKS = {"right": (theme.BLUE, 3.5, "-"), "left": (theme.ORANGE, 1.6, "--")}
NOTE = (
    "Contact ratio by Eq. 16: pinion roll from where the path enters to where it leaves the flanks, over"
    " a pitch (360\u00b0 over the pinion's teeth). A dot stands where other limits, named there, begin to"
    " end the right flank's path. The ratio speaks of the geometry of one tooth pair: with both"
    " coefficients positive (a) the edge of the next tooth can touch first; it is then no operating ratio."
)


@dataclass(frozen=True, eq=False)
class RatioFigure:
    """Coefficients (4, points), 1/mm, magnitudes, and the path's ends on each flank."""

    size: FloatArray
    ends: dict[str, tuple[PathEnds, ...]]


def compute(design: Design) -> RatioFigure:
    """Find ends of all paths, one call for each flank and sign case."""
    size = np.stack([np.linspace(0.0, case.greatest, POINTS) for case in CASES])
    ends = {
        flank: tuple(
            path_ends(design.with_parabola(case.pinion * a + 0.0, case.gear * a + 0.0), flank)
            for case, a in zip(CASES, size, strict=True)
        )
        for flank in FLANKS
    }
    return RatioFigure(size, ends)


def draw(data: RatioFigure, size: theme.Size) -> Drawing:
    """Draw four panels, as in the paper."""
    page, low, high = theme.new_page(
        size,
        "Fig. 11   Contact ratio against the parabola coefficient",
        "Parabola coefficients $a_1$ of the pinion, $a_2$ of the gear",
        NOTE,
        below=0.55,
        above=0.55,
    )
    bottoms, height = theme.rows(low, high, 2, theme.inches(page, 1.35))
    values = np.concatenate([ends.contact_ratio for flank in FLANKS for ends in data.ends[flank]])
    limits = _limits(values[np.isfinite(values)])
    for index, case in enumerate(CASES):
        row, column = divmod(index, 2)
        axes = page.add_axes((0.065 + 0.5 * column, bottoms[row], 0.405, height))
        _panel(axes, data, index, case)
        axes.set_ylim(*limits)
    return Drawing(page, {})


def _limits(values: FloatArray) -> tuple[float, float]:
    if not values.size:
        return 0.0, 1.0
    room = max(float(np.ptp(values)), 0.5)
    return float(values.min()) - 0.06 * room, float(values.max()) + 0.12 * room


def _panel(axes: Axes, data: RatioFigure, index: int, case: SignCase) -> None:
    """Draw the contact ratio of both flanks over the coefficient of the pinion, 1/mm."""
    a = case.pinion * data.size[index]
    for flank in reversed(FLANKS):
        colour, width, style = LOOKS[flank]
        ratio = data.ends[flank][index].contact_ratio
        axes.plot(a, ratio, style, color=colour, linewidth=width, label=f"{flank} flank")
        if not np.isfinite(ratio).any():
            axes.text(0.5, 0.5, "the path could not be followed", transform=axes.transAxes, ha="center")
    _mark_kinks(axes, a, data.ends["right"][index])
    axes.set_title(f"({'abcd'[index]})  {_name(case)}", loc="left", pad=10.0)
    axes.set_ylabel("contact ratio")
    other = "$a_2$" if case.pinion == case.gear else "\u2212$a_2$"
    axes.set_xlabel(f"$a_1$ = {other}  (mm$^{{\u22121}}$)")
    axes.set_xlim(min(a[0], a[-1]), max(a[0], a[-1]))
    if case.pinion < 0.0:
        axes.invert_xaxis()
    ticks = case.pinion * np.linspace(0.0, case.greatest, 5) + 0.0
    axes.set_xticks(ticks, [coefficient_text(tick) for tick in ticks])
    axes.grid(True)
    axes.axhline(1.0, color=theme.GREY, linewidth=1.0)
    axes.legend(loc="best", reverse=True)


def _mark_kinks(axes: Axes, a: FloatArray, ends: PathEnds) -> None:
    """Mark where other limits begin to end the path on the right flank, and which; of changes close to each
    other the last."""
    changed = np.any(ends.limit[1:] != ends.limit[:-1], axis=-1) & (ends.limit[1:] >= 0).all(axis=-1)
    kinks = np.nonzero(changed)[0] + 1
    for at in kinks[np.diff(kinks, append=2 * POINTS) > POINTS // 10]:
        place = (a[at], ends.contact_ratio[at])
        axes.plot(*place, "o", color=theme.BLUE, markersize=7.0)
        text = " \u2192 ".join(limit_name(code) for code in ends.limit[at].tolist())
        theme.beside(axes, place, text, (0, 8), ha="center", fontsize=theme.SMALL)


def _name(case: SignCase) -> str:
    pinion, gear = ("positive" if sign > 0.0 else "negative" for sign in (case.pinion, case.gear))
    return f"both coefficients {pinion}" if pinion == gear else f"pinion {pinion}, gear {gear}"


def rows(data: RatioFigure) -> Table:
    """List contact ratio and limits of the path at every coefficient."""
    header = ("a1_per_mm", "a2_per_mm", "flank", "contact_ratio", "enters_at", "leaves_at")

    def cases() -> Rows:
        """Give the columns of every flank and sign case."""
        for (index, case), flank in product(enumerate(CASES), FLANKS):
            ends, a = data.ends[flank][index], data.size[index]
            names = [[limit_name(code) for code in codes] for codes in ends.limit.T.tolist()]
            yield case.pinion * a + 0.0, case.gear * a + 0.0, flank, ends.contact_ratio, *names

    return header, stacked(cases())


RECIPES = {"fig-11": Recipe(compute, draw, rows)}
