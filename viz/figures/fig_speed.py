"""Speed against accuracy of every way to find the contact."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.comparison import SOLVED, Row, Settings, compare
from beveloid_geom.inputs import Design

from .. import theme
from ..recipe import Drawing, Recipe, Table
from ..theme import Page, Size
from .curves import Look, curve, duration, log_axes, say

FLANKS = ("right", "left")
MODIFIED = (0.001, -0.001)
SETTINGS = Settings()
COST = "processor time of a position (s)"
EXACT = 1e-9
"""mm: an error under it counts as exact in the text."""
FLOOR = 1e-14
"""mm: what is nearer to the truth than this is drawn there."""
LOOKS = {
    "mesh alone": Look("mesh alone (tolerance)", theme.RED, "o", True),
    "mesh, polished": Look("mesh, then polish (tolerance)", theme.RED, "o"),
    "five equations, NumPy, cold": Look("five equations, NumPy, cold (xtol)", theme.ORANGE, "^", True),
    "five equations, NumPy, warm": Look("five equations, NumPy, warm (xtol)", theme.ORANGE, "^"),
    "five equations, math, cold": Look("five equations, math, cold (xtol)", theme.BLUE, "s", True),
    "five equations, math, warm": Look("five equations, math, warm (xtol)", theme.BLUE, "s"),
    "Newton on F, single precision": Look("one equation, Newton in single (steps)", theme.BLACK, "v", True),
    "Newton on F": Look("one equation, Newton (steps)", theme.BLACK, "v"),
    "one equation, given l1": Look("one equation, $l_1$ given (batch)", theme.GREEN, "D", True, 8.5),
    "one equation, path": Look("one equation, path with ends (batch)", theme.GREEN, "D"),
}
"""Methods in the order of the legend, each with what varies along its curve."""
LABELS = (
    ("mesh alone", 0, "{:g} mm", (-2, 9), "right"),
    ("mesh alone", -1, "{:g} mm", (6, -17), "right"),
    ("five equations, NumPy, cold", 0, "xtol {:g}", (0, 9), "center"),
    ("five equations, NumPy, warm", -1, "{:g}", (8, 3), "left"),
    ("Newton on F", 0, "0 steps", (9, 0), "left"),
    ("Newton on F", 1, "{:g}", (9, -1), "left"),
    ("Newton on F", 2, "{:g}", (9, 1), "left"),
    ("Newton on F", 3, "{:g}", (9, -3), "left"),
    ("one equation, given l1", 0, "batch 1", (8, -20), "center"),
    ("one equation, path", -1, "{:,.0f}", (-6, -20), "left"),
)
"""Settings written beside their marks: method, which of its rows, text, shift in points, alignment."""
NOTE = (
    "Errors are the largest of five positions of the path, against the five equations at 60 digits. Times are"
    " processor times of a call over its positions; what is kept between calls (mounting, meshes, the flanks'"
    " constants) is listed apart, as setup. Meshes turn the gear until the flanks touch, from 1e-4 rad off. A"
    " cold start is the pitch point, a warm one the position before. Newton starts in the middle of the"
    " gear's flank, in batches of 1,000; without parabola one step is exact, and the point does not depend on"
    " it. {finding}"
)


@dataclass(frozen=True, eq=False)
class SpeedCase:
    """One flank pair of one design: rows, or the `reason` why there are none."""

    flank: str
    parabola: tuple[float, float]
    rows: tuple[Row, ...]
    reason: str = ""

    @property
    def title(self) -> str:
        """Flanks and parabola coefficients."""
        pinion, gear = self.parabola
        values = f"$a_1$ = {pinion:g}, $a_2$ = {gear:g}"
        if pinion == -gear:
            values = f"$a_1$ = \u2212$a_2$ = {pinion:g}" if pinion else "unmodified"
        return f"{self.flank} flanks, {values}".replace("-", "\u2212")

    def curve(self, method: str) -> list[Row]:
        """The rows of a method in the chart of accuracy: Newton's over its steps, without its batches."""
        own = [row for row in self.rows if row.method == method]
        return [row for row in own if row.kind == "iterations"] or own

    @property
    def failures(self) -> list[str]:
        """Methods that failed, with at how many of their settings."""
        methods = dict.fromkeys(row.method for row in self.rows)
        lost = {
            method: [row.status != SOLVED for row in self.rows if row.method == method] for method in methods
        }
        return [f"{method} ({sum(bad)}\u00a0of\u00a0{len(bad)})" for method, bad in lost.items() if any(bad)]


def compute(design: Design) -> tuple[SpeedCase, ...]:
    """Both flanks of the design as given, and with opposite parabola coefficients."""
    cases = []
    for changed in (design, design.with_parabola(*MODIFIED)):
        parabola = float(changed.pinion.tool.parabola), float(changed.gear.tool.parabola)
        for flank in FLANKS:
            try:
                cases.append(SpeedCase(flank, parabola, compare(changed, flank, SETTINGS)))
            except ValueError as error:
                cases.append(SpeedCase(flank, parabola, (), str(error)))
    return tuple(cases)


def draw(data: tuple[SpeedCase, ...], size: Size) -> Drawing:
    """A chart for each case; the legend and the cost of a batch beside them."""
    page = theme.new_page(
        size,
        "Speed against accuracy of every way to find the contact",
        "Processor time of a position against the true error of the contact point: further left is faster,"
        " further down more exact",
    )
    low = theme.caption(page, NOTE.format(finding=finding(data))) + theme.inches(page, 0.75)
    gap = theme.inches(page, 0.95)
    height = (theme.top(page) - theme.inches(page, 0.4) - low - gap) / 2.0
    shown = next((number for number in (2, 3, 0, 1) if data[number].rows), None)
    for number, case in enumerate(data):
        row, column = divmod(number, len(FLANKS))
        axes = page.add_axes((0.065 + 0.325 * column, low + (1 - row) * (height + gap), 0.265, height))
        axes.set_title(f"({'abcd'[number]})  {case.title}", loc="left", pad=8.0)
        _panel(axes, case, number == shown)
        if column == 0:
            axes.set_ylabel("error of the contact point (mm)")
        if row == 1:
            axes.set_xlabel(COST)
    _legend(page, low + 2.0 * height + gap)
    axes = page.add_axes((0.75, low, 0.235, height))
    _batches(axes, data, shown)
    return Drawing(page, {})


def _panel(axes: Axes, case: SpeedCase, labelled: bool) -> None:
    log_axes(axes)
    axes.set_xlim(1.2e-8, 0.4)
    axes.set_ylim(0.3 * FLOOR, 3e3)
    axes.set_xticks(10.0 ** np.arange(-7, 0))
    axes.set_yticks(10.0 ** np.arange(-14, 4, 2))
    axes.minorticks_off()
    if case.reason:
        say(axes, case.reason)
    for order, (method, look) in enumerate(LOOKS.items()):
        rows = [row for row in case.curve(method) if np.isfinite(row.error_mm)]
        x, y = [row.seconds_per_position for row in rows], [max(FLOOR, row.error_mm) for row in rows]
        curve(axes, look, x, y, order)
    if case.failures:
        text = "\n".join(("not found:", *(textwrap.fill(failure, 15) for failure in case.failures)))
        axes.text(0.99, 0.47, text, transform=axes.transAxes, ha="right", va="center", fontsize=theme.SMALL)
    for method, index, text, shift, side in LABELS if labelled else ():
        rows = case.curve(method)
        if rows and np.isfinite(rows[index].error_mm):
            at = (rows[index].seconds_per_position, max(FLOOR, rows[index].error_mm))
            _beside(axes, text.format(rows[index].value), at, (shift, side), LOOKS[method].colour)


def _beside(
    axes: Axes, text: str, at: tuple[float, float], where: tuple[tuple[int, int], str], colour: str
) -> None:
    shift, side = where
    axes.annotate(
        text, at, xytext=shift, textcoords="offset points", ha=side, fontsize=theme.SMALL, color=colour
    )


def _legend(page: Page, top: float) -> None:
    page.legend(
        handles=[look.line() for look in LOOKS.values()],
        title="method (what varies along its curve)",
        title_fontsize=theme.SMALL,
        alignment="left",
        loc="upper left",
        bbox_to_anchor=(0.7, top + theme.inches(page, 0.4)),
        fontsize=theme.SMALL,
        labelspacing=0.6,
        handlelength=3.2,
    )


def _batches(axes: Axes, data: Sequence[SpeedCase], shown: int | None) -> None:
    """Time of a position over the batch, with that of the five equations, which have none, as a level."""
    axes.set_xlabel("positions in a call (batch)")
    axes.set_ylabel(COST)
    log_axes(axes)
    if shown is None:
        axes.set_title("(e)  time over the batch", loc="left", pad=8.0)
        say(axes, "no case with a contact")
        return
    axes.set_title(f"(e)  time over the batch, as ({'abcd'[shown]})", loc="left", pad=8.0)
    for order, (method, look) in enumerate(LOOKS.items()):
        rows = [row for row in data[shown].rows if row.method == method and row.kind == "batch"]
        rows = [row for row in rows if np.isfinite(row.seconds_per_position)]
        curve(axes, look, [row.value for row in rows], [row.seconds_per_position for row in rows], order)
    axes.autoscale_view()
    for method in ("five equations, math, warm", "five equations, NumPy, warm"):
        row, colour = fastest(data[shown].rows, method), LOOKS[method].colour
        if row:
            axes.axhline(row.seconds_per_position, color=colour, linewidth=1.6, zorder=1.5)
            at = (3e5, row.seconds_per_position)
            _beside(axes, f"five equations, {method.split(', ')[1]}", at, ((0, 5), "right"), colour)
    axes.set_xlim(0.6, 3e5)
    axes.set_xticks(10.0 ** np.arange(6))
    axes.minorticks_off()


def fastest(rows: Sequence[Row], method: str) -> Row | None:
    """The fastest row of a method whose error is under EXACT."""
    own = [row for row in rows if row.method == method and row.error_mm < EXACT]
    return min(own, key=lambda row: row.seconds_per_position, default=None)


def finding(data: Sequence[SpeedCase]) -> str:
    """What the chart shows, in numbers of this run: of the last case of each flank."""
    last = {case.flank: case for case in data if case.rows}
    texts = []
    for case in last.values():
        title = case.title.replace("$", "").replace("_", "").replace(" = ", "\u00a0=\u00a0")
        texts.append(f"{title[:1].upper()}{title[1:]}: {'; '.join(_parts(case.rows))}.")
    return " ".join(texts)


def _parts(rows: Sequence[Row]) -> Iterator[str]:
    meshes = [row for row in rows if row.method == "mesh alone" and np.isfinite(row.error_mm)]
    if meshes:
        last = meshes[-1]
        took = duration(last.seconds_per_position)
        yield f"a mesh to {last.value:g} mm alone is {last.error_mm:.2g} mm off after {took}"
    names = {
        "mesh, polished": "a polished mesh",
        "five equations, NumPy, warm": "the five equations in NumPy",
        "five equations, math, warm": "in math",
        "one equation, path": "one equation",
    }
    best = {name: fastest(rows, method) for method, name in names.items()}
    found = [f"{name} {duration(row.seconds_per_position)}" for name, row in best.items() if row]
    one, five = best["one equation"], best["in math"]
    if found:
        times = f"{five.seconds_per_position / one.seconds_per_position:,.0f} times" if one and five else ""
        yield f"under 1e-9 mm takes {', '.join(found)}" + (f" ({times} as fast)" if times else "")
    steps = [row for row in rows if row.method == "Newton on F" and row.kind == "iterations"]
    enough = next((row for row in steps if row.error_mm < EXACT), None)
    single = [row.error_mm for row in rows if row.method == "Newton on F, single precision"]
    if enough and np.isfinite(single).any():
        yield f"{enough.value:.0f} Newton steps do, and single precision stays {np.nanmin(single):.0e} mm off"


def rows(data: tuple[SpeedCase, ...]) -> Table:
    """Every method at every setting; the status says why an error is missing."""
    where = ("flank", "a1_per_mm", "a2_per_mm", "status")
    setting = ("method", "setting", "error_mm", "transmission_error_arcsec")
    header = (*where, *setting, "seconds_per_position", "setup_seconds")

    def body() -> Iterator[list[object]]:
        nothing = float("nan")
        for case in data:
            if case.reason:
                yield [case.flank, *case.parabola, case.reason, "", "", nothing, nothing, nothing, nothing]
            for row in case.rows:
                errors = (row.error_mm, row.transmission_error_arcsec)
                cost = (row.seconds_per_position, row.setup_seconds)
                yield [case.flank, *case.parabola, row.status, row.method, row.setting, *errors, *cost]

    return header, body()


RECIPES = {"speed-accuracy": Recipe(compute, draw, rows)}
