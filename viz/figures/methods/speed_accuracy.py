"""Speed against accuracy of every way to find the contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design
from beveloid_geom.studies.comparison import (
    EXACT as EXACT_FIRST,
    FIRST,
    GRID,
    SOLVED,
    Row,
    Settings,
    compare,
    compare_first,
)

from ...parts.curves import Labels, Look, curve, duration, log_axes, whole_decades
from ...parts.recipe import Drawing, Recipe, Rows, Table
from ...parts.solved import FLANKS, modified
from ...stage import theme
from ...stage.layout import Cells

CELLS, PANELS = Cells(left=0.95, right=0.3, across=1.0, down=1.45, most=3, least=1.7), 7
FEWER = 4
"""Panels on a page that has no room for three columns."""
COLUMNS = 176
"""Characters in a line of the caption."""
FIVE = "five equations, warm"
BATCHES = (0.6, 3e5)
"""Limits of panel (e)."""
SETTINGS = Settings()
COST, COST_IN_PRINT = "processor time of a position (s)", "processor time (s)"
EXACT, EXACT_TURN = 1e-9, 1e-4
"""mm, and arcsec of transmission error: errors under them count as exact in the text."""
FLOOR, FLOOR_TURN = 1e-14, 1e-12
"""mm, arcsec: what is nearer to the truth than this is drawn there."""
USUAL = (1.2e-8, 0.4), (0.3 * FLOOR, 3e3)
"""Limits of the times (s) and errors (mm) of a panel; what is beyond widens them."""
LOOKS = {
    "mesh alone": Look("mesh alone", theme.RED, "o", True),
    "mesh, polished": Look("mesh, then polish", theme.RED, "o"),
    "five equations, cold": Look("five equations, cold", theme.BLUE, "s", True),
    "five equations, warm": Look("five equations, warm", theme.BLUE, "s"),
    "Newton on F": Look("one equation, Newton", theme.BLACK, "v"),
    "one equation, given l1": Look("one equation, l1 given", theme.GREEN, "D", True, 8.5),
    "one equation, path": Look("one equation, path with ends", theme.GREEN, "D"),
}
FIRST_LOOKS = {
    "mesh alone" + FIRST: LOOKS["mesh alone"],
    "mesh, polished" + FIRST: LOOKS["mesh, polished"],
    GRID: Look("grid search", theme.GREY, "P", True, 7.0),
    EXACT_FIRST: Look("first contact", theme.BLACK, "^", size=7.0),
}
"""Ways to find what touches first of all teeth; methods are in the order of the legend."""
LABELS = (
    ("Newton on F", 0, "0 steps", ((9, 0, "left"), (-9, 0, "right"))),
    ("Newton on F", 1, "{:g}", ((9, -1, "left"), (-9, -1, "right"))),
    ("Newton on F", 2, "{:g}", ((9, 1, "left"), (-9, 1, "right"))),
    ("Newton on F", 3, "{:g}", ((9, -3, "left"), (-9, -3, "right"))),
    ("one equation, path", -1, "{:,.0f}", ((-6, -20, "left"), (-6, 10, "left"))),
    ("one equation, given l1", 0, "batch 1", ((8, 10, "center"), (8, -20, "center"))),
    ("mesh alone", 0, "{:g} mm", ((-2, 9, "right"), (-2, 9, "left"), (9, 6, "left"), (9, -4, "left"))),
    ("mesh alone", -1, "{:g} mm", ((6, -17, "right"), (6, 9, "center"), (-9, -17, "left"))),
    ("five equations, cold", 0, "xtol {:g}", ((0, 9, "center"), (9, 6, "left"), (-9, 0, "right"))),
    ("five equations, warm", -1, "{:g}", ((8, 3, "left"), (8, -16, "left"), (-8, 3, "right"))),
)
"""Settings written beside their marks: method, which of its rows, text, and where, best first; what has
no room at any of them is left out."""
NOTE = (
    "Along a curve varies of meshes the tolerance, of five equations xtol, of Newton the steps, and else"
    " the batch. Errors are the largest of five positions of the path, against the five equations at 60"
    " digits. Times are processor times of a call over its positions; what is kept between calls"
    " (mounting, meshes, the flanks' constants) is listed apart, as setup. Meshes turn the gear until the"
    " flanks touch, from 1e-4 rad off. A cold start is the pitch point, a warm one the position before."
    " Newton starts in the middle of the gear's flank, in batches of 1,000; without parabola one step is"
    " exact, and the point does not depend on it."
)
FIRST_NOTE = (
    " (f), (g): where the teeth touch first, edges included, in five positions of a mesh cycle, against its"
    " exact pieces, of a grid over its points; the polish knows no contact on an edge. "
)
MORE = " What a batch costs, and how first contacts are found, is shown on wider pages."


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
        """Give the rows of a method in the chart of accuracy: Newton's over its steps, without its
        batches."""
        own = [row for row in self.rows if row.method == method]
        return [row for row in own if row.kind == "iterations"] or own

    @property
    def failures(self) -> list[str]:
        """Methods that failed, with at how many of their settings."""
        words = []
        for method in dict.fromkeys(row.method for row in self.rows):
            lost = [row.status != SOLVED for row in self.rows if row.method == method]
            count = "all" if all(lost) else f"{sum(lost)} of {len(lost)}"
            name = (LOOKS | FIRST_LOOKS)[method].label + (FIRST if FIRST in method else "")
            words += [f"{name} ({count})".replace(" ", "\u00a0")] if any(lost) else []
        return words


def compute(design: Design) -> tuple[SpeedCase, ...]:
    """Measure both flanks of the design as given, and with opposite parabola coefficients; first contacts of
    the right flanks with these."""
    cases = []
    for changed in (design, modified(design)):
        parabola = float(changed.pinion.tool.parabola), float(changed.gear.tool.parabola)
        for flank in FLANKS:
            try:
                rows = compare(changed, flank, SETTINGS)
                if changed is not design and flank == FLANKS[0]:
                    rows += compare_first(changed, flank, SETTINGS)
                cases.append(SpeedCase(flank, parabola, rows))
            except (ValueError, ImportError) as error:
                cases.append(SpeedCase(flank, parabola, (), str(error)))
    return tuple(cases)


def draw(data: tuple[SpeedCase, ...], layout: theme.Layout) -> Drawing:
    """Draw a chart for each case; beside them the cost of a batch, and first contacts of all teeth."""
    count = FEWER if layout.printed and CELLS.columns(layout, PANELS) < 3 else PANELS
    more = FIRST_NOTE + finding(data) if count == PANELS else MORE
    page, low, high = theme.new_page(
        layout,
        "Speed against accuracy of every way to find the contact",
        "Processor time of a position against the true error of the contact point: further left is faster,"
        " further down more exact",
        NOTE + more + failures(data),
        below=0.75,
        above=1.25,
        columns=COLUMNS,
        tall=CELLS.tall(layout, count, 1.9),
    )
    four, three = _axes(page, count, low, high)
    shown = next((number for number in (2, 3, 0, 1) if data[number].rows), None)
    for number, (case, axes) in enumerate(zip(data, four, strict=True)):
        row, column = divmod(number, len(FLANKS))
        axes.set_title(f"({'abcd'[number]})  {case.title}", loc="left", pad=8.0)
        _panel(axes, case, limits(data), number == shown)
        if column == 0 or layout.printed:
            axes.set_ylabel("error (mm)" if layout.printed else "error of the contact point (mm)")
        if row == 1 or layout.printed:
            axes.set_xlabel(COST_IN_PRINT if layout.printed else COST)
    _legend(page, high, LOOKS if count == FEWER else LOOKS | FIRST_LOOKS)
    if not three:
        return Drawing(page, {})
    _batches(three[0], data, shown)
    found = [row for case in data for row in case.rows if row.method in FIRST_LOOKS]
    _first(three[1], found, "(f)  first contact of all teeth, as (c)", "mm", "error_mm", FLOOR)
    _first(three[2], found, "(g)  its transmission error", "arcsec", "transmission_error_arcsec", FLOOR_TURN)
    return Drawing(page, {})


def _axes(page: theme.Page, count: int, low: float, high: float) -> tuple[list[Axes], list[Axes]]:
    """Make axes for the four cases, and the three of batches and first contacts beside or after them, where
    `count` has room for these."""
    if page.layout.printed:
        found = theme.panels(page, CELLS, count, low, high)
        return found[:4], found[4:]
    bottoms, height = theme.rows(low, high, 2, theme.inches(page, 0.95))
    four = [page.add_axes((x, bottom, 0.265, height)) for bottom in bottoms for x in (0.065, 0.39)]
    bottoms, height = theme.rows(low, high, 3, theme.inches(page, 0.95))
    return four, [page.add_axes((0.75, bottom, 0.235, height)) for bottom in bottoms]


def limits(data: Sequence[SpeedCase]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Find the limits of times (s) and of errors (mm), alike in all panels: the usual ones,
    widened to hold every mark."""
    found = [at for case in data for row in case.rows if (at := place(row))]
    times, errors = np.reshape(found, (-1, 2)).T
    (fast, slow), (low, high) = USUAL
    return (
        (0.5 * times.min(initial=2.0 * fast), 2.0 * times.max(initial=0.5 * slow)),
        (low, 10.0 * errors.max(initial=0.1 * high)),
    )


def place(row: Row) -> tuple[float, float] | None:
    """Say where a row is drawn: its time (s) and its error (mm), not under the FLOOR; None without an
    error."""
    return (row.seconds_per_position, max(FLOOR, row.error_mm)) if np.isfinite(row.error_mm) else None


def _panel(
    axes: Axes, case: SpeedCase, within: tuple[tuple[float, float], tuple[float, float]], labelled: bool
) -> None:
    """Draw the errors (mm) of one case over the times (s), both `within` limits; settings if `labelled`."""
    log_axes(axes)
    for axis, set_limits, ends, step in (
        (axes.xaxis, axes.set_xlim, within[0], 1),
        (axes.yaxis, axes.set_ylim, within[1], 2),
    ):
        set_limits(*ends)
        first, last = (int(f(np.log10(end))) for f, end in zip((np.ceil, np.floor), ends, strict=True))
        axis.set_ticks(10.0 ** np.arange(first + first % step, last + 1, step, dtype=float))
    axes.minorticks_off()
    if case.reason:
        theme.say(axes, case.reason)
    for order, (method, look) in enumerate(LOOKS.items()):
        curve(axes, look, [at for row in case.curve(method) if (at := place(row))], order)
    labels = Labels(axes)
    for method, index, text, shifts in LABELS if labelled else ():
        rows = case.curve(method)
        if rows and (at := place(rows[index])):
            labels.put(text.format(rows[index].value), at, shifts, LOOKS[method].colour)


def _legend(page: theme.Page, top: float, looks: Mapping[str, Look]) -> None:
    corner = 0.025, top + theme.inches(page, 1.1)
    style: dict[str, Any] = {
        "fontsize": theme.SMALL,
        "labelspacing": 0.6,
        "handlelength": 2.8,
        "columnspacing": 1.4,
    }
    style |= {"alignment": "left", "loc": "upper left"}
    handles = [look.line() for look in dict.fromkeys(looks.values())]
    theme.legend(page, handles, 5, bbox_to_anchor=corner, **style)


def _first(axes: Axes, found: Sequence[Row], title: str, unit: str, measure: str, floor: float) -> None:
    """Draw errors of first contacts, the `measure` of rows, over their times."""
    axes.set_title(title, loc="left", pad=8.0)
    axes.set(xlabel=COST_IN_PRINT if cast("theme.Page", axes.figure).layout.printed else COST)
    axes.set_ylabel(f"error ({unit})")
    log_axes(axes)
    for order, (method, look) in enumerate(FIRST_LOOKS.items()):
        own = [(row.seconds_per_position, getattr(row, measure)) for row in found if row.method == method]
        curve(axes, look, [(time, max(floor, error)) for time, error in own if np.isfinite(error)], order)
    if not found:
        theme.say(axes, "not known for this design")
        return
    axes.autoscale_view()
    whole_decades(axes)
    axes.minorticks_off()


def _batches(axes: Axes, data: Sequence[SpeedCase], shown: int | None) -> None:
    """Draw the time of a position over the batch, with that of the five equations, which have none, as
    a level."""
    axes.set(xlabel="positions in a call (batch)", ylabel="time (s)")
    log_axes(axes)
    if shown is None:
        axes.set_title("(e)  time over the batch", loc="left", pad=8.0)
        theme.say(axes, "no case with a contact")
        return
    axes.set_title(f"(e)  time over the batch, as ({'abcd'[shown]})", loc="left", pad=8.0)
    for order, (method, look) in enumerate(LOOKS.items()):
        rows = [row for row in data[shown].rows if row.method == method and row.kind == "batch"]
        timed = [(row.value, row.seconds_per_position) for row in rows]
        curve(axes, look, [at for at in timed if np.isfinite(at[1])], order)
    axes.autoscale_view()
    exact = fastest(data[shown].rows, FIVE)
    level = exact.seconds_per_position if exact else np.nan
    if exact:
        axes.axhline(level, color=LOOKS[FIVE].colour, linewidth=1.6, zorder=1.5)
    axes.set_xlim(*BATCHES)
    whole_decades(axes)
    axes.set_xticks(10.0 ** np.arange(6))
    axes.minorticks_off()
    labels = Labels(axes)
    for end, side in ((BATCHES[1], "right"), (BATCHES[0] * 1.1, "left")) if exact else ():
        if labels.put("five equations", (end, level), ((0, 6, side), (0, -16, side)), LOOKS[FIVE].colour):
            break


def fastest(rows: Sequence[Row], method: str) -> Row | None:
    """Find the fastest row of a method whose error is under EXACT."""
    own = [row for row in rows if row.method == method and row.error_mm < EXACT]
    return min(own, key=lambda row: row.seconds_per_position, default=None)


def finding(data: Sequence[SpeedCase]) -> str:
    """Say what the chart shows, in numbers of this run: of the last case of each flank."""
    last = {case.flank: case for case in data if case.rows}
    titles = {_plain(case.title): "; ".join(_parts(case.rows)) for case in last.values()}
    return " ".join(f"{title[:1].upper()}{title[1:]}: {words}." for title, words in titles.items())


def _plain(text: str) -> str:
    """Give a title for the caption."""
    return theme.spelled(text).replace(" = ", "\u00a0=\u00a0")


def failures(data: Sequence[SpeedCase]) -> str:
    """Say which methods did not find all positions, and where there was nothing to find."""
    lost = {letter: "; ".join(case.failures) for letter, case in zip("abcd", data, strict=True)}
    texts = ". ".join(f"({letter}) {words}" for letter, words in lost.items() if words)
    where = " Not found at some of their settings, or at all, for reasons in the table: "
    return f"{where}{texts}." if texts else ""


def _parts(rows: Sequence[Row]) -> Iterator[str]:
    """Say what the methods take, in numbers of one case."""
    meshes = [row for row in rows if row.method == "mesh alone" and np.isfinite(row.error_mm)]
    if meshes:
        last = meshes[-1]
        took = duration(last.seconds_per_position)
        yield f"a mesh to {last.value:g} mm alone is {last.error_mm:.2g} mm off after {took}"
    names = {
        "mesh, polished": "a polished mesh",
        "five equations, warm": "the five equations",
        "one equation, path": "one equation",
    }
    best = {name: fastest(rows, method) for method, name in names.items()}
    found = [f"{name} {duration(row.seconds_per_position)}" for name, row in best.items() if row]
    one, five = best["one equation"], best["the five equations"]
    if found:
        times = f"{five.seconds_per_position / one.seconds_per_position:,.0f} times" if one and five else ""
        yield f"under 1e-9 mm takes {', '.join(found)}" + (f" ({times} as fast)" if times else "")
    never = [name for name, row in best.items() if not row]
    if never:
        yield f"{', '.join(never)}: never under 1e-9 mm"
    yield from _steps(rows)


def _steps(rows: Sequence[Row]) -> Iterator[str]:
    """Say how many Newton steps give point and rolls."""
    steps = [row for row in rows if row.method == "Newton on F" and row.kind == "iterations"]
    exact = [row for row in steps if row.error_mm < EXACT and row.transmission_error_arcsec < EXACT_TURN]
    if exact and exact[0].value > 0:
        count = exact[0].value
        yield f"{count:.0f} Newton step{'s do' if count > 1 else ' does'}"
    elif steps and not exact:
        yield f"Newton does not get there in {steps[-1].value:.0f} steps"


def rows(data: tuple[SpeedCase, ...]) -> Table:
    """List every method at every setting; the status says why an error is missing."""
    where = ("flank", "a1_per_mm", "a2_per_mm", "status")
    setting = ("method", "setting", "value", "error_mm", "transmission_error_arcsec")
    header = (*where, *setting, "seconds_per_position", "setup_seconds")

    def body() -> Rows:
        """Give the rows of every case."""
        for case in data:
            if case.reason:
                yield case.flank, *case.parabola, case.reason, "", "", *5 * [float("nan")]
            for row in case.rows:
                errors = (row.error_mm, row.transmission_error_arcsec)
                cost = (row.seconds_per_position, row.setup_seconds)
                yield case.flank, *case.parabola, row.status, row.method, row.kind, row.value, *errors, *cost

    return header, body()


RECIPES = {"speed-accuracy": Recipe(compute, draw, rows)}
