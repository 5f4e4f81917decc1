"""Error against time per position of five methods that find the contact.

"Five equations": Eq. 15 of the paper, solved by `fsolve` of SciPy to its relative tolerance xtol. "One
equation": `path_of_contact`, which reduces them to one equation. "Mesh": smallest distance of two triangle
meshes, alone or polished by Newton's method on the exact flanks. "First contact": `first_contact` of all
teeth. See `validation.comparison`.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from beveloid_geom import Design
from beveloid_geom.validation.comparison import METHODS, Measurement, compare

from ...components.figure_steps import Drawing, Recipe, Table
from ...components.free_space import Labels
from ...components.paths_table import coefficients, paper_modified
from ...rendering import theme
from ...rendering.layout import PanelRows
from .curves import MethodStyle, curve, log_axes

RUN_COUNT = 5
LOOKS = {
    "mesh alone": MethodStyle("mesh alone", theme.VERMILLION, "o", True, 7.0),
    "mesh, polished": MethodStyle("mesh, polished", theme.VERMILLION, "o", size=7.0),
    "five equations": MethodStyle("five equations", theme.BLUE, "s", size=7.0),
    "one equation": MethodStyle("one equation", theme.GREEN, "D", size=7.0),
    "first contact": MethodStyle("first contact of all teeth", theme.INK, "^", size=8.0),
}
LABELS = (
    ("mesh alone", 0.1, "0.1 mm", ((0, 11, "center"), (11, -4, "left"), (-11, -4, "right"))),
    ("mesh alone", 0.0003, "0.0003 mm", ((6, 11, "center"), (0, -22, "center"))),
    ("five equations", 0.1, "xtol 0.1", ((0, 11, "center"), (-11, -4, "right"), (11, -4, "left"))),
    ("five equations", 1e-14, "10$^{\u221214}$", ((4, -22, "left"), (8, 9, "left"))),
    ("one equation", 1, "1 position", ((0, -22, "left"), (0, 11, "left"))),
    ("one equation", 101, "101", ((0, -22, "center"), (0, 11, "center"))),
    ("one equation", 100_001, "100,001 positions", ((0, -22, "left"), (0, 11, "left"))),
    ("first contact", 1, "1 position", ((0, 11, "center"), (0, -22, "center"))),
    ("first contact", 1_001, "1,001", ((0, 11, "center"), (0, -22, "center"))),
)
"""Settings written next to their marks: method, value, text and places in points, best first."""


@dataclass(frozen=True, eq=False)
class SpeedAccuracy:
    """Measurements of all methods on one flank pair; the `reason` if there are none."""

    design: Design
    flank: str
    measurements: tuple[Measurement, ...]
    reason: str = ""

    def of(self, method: str) -> list[Measurement]:
        """Return the measurements of a method that solved all positions."""
        return [one for one in self.measurements if one.method == method and one.status == "solved"]


def compute(design: Design, flank: str = "right") -> SpeedAccuracy:
    """Measure all methods on the pair with the paper's modification."""
    changed = paper_modified(design)
    try:
        return SpeedAccuracy(changed, flank, compare(changed, flank, METHODS, RUN_COUNT))
    except (ValueError, ImportError) as error:
        return SpeedAccuracy(changed, flank, (), str(error))


def draw(data: SpeedAccuracy, layout: theme.PageLayout) -> Drawing:
    """Draw error against time. No text outside the axes depends on a measured time."""
    note = (
        "Five equations: Eq. 15 of the paper; one equation: reduced from these. Time: median and range of"
        " {runs} runs, without meshing and, except for paths, pair constants. Error: largest of five"
        " positions, against five equations at 60 digits (first contact: against polynomials of the mesh"
        " cycle). Along curves: mesh tolerance, xtol, positions per call. Meshes find no edge contact."
    )
    cells = PanelRows(left=1.25, right=0.4, across=0.0, down=0.0, most=1, least=4.0)
    # Places of the comparison of times that are tried: upper left corner, as fractions of the axes.
    corners = ((0.03, 0.93), (0.03, 0.6), (0.6, 0.75), (0.6, 0.45), (0.52, 0.75), (0.52, 0.6))
    solved = {method: look for method, look in LOOKS.items() if data.of(method)}
    lost = unanswered(data)
    page, low, high = theme.new_page(
        layout,
        title(data),
        f"{data.flank.capitalize()} flanks, {coefficients(data.design)}. Left is faster, down is more exact.",
        note.format(runs=RUN_COUNT) + (f" Without an answer: {'; '.join(lost)}." if solved and lost else ""),
        below=0.75,
        above=0.6,
        tall=cells.tall(layout, 1, 5.2),
    )
    (axes,) = theme.panels(page, cells, 1, low, high)
    log_axes(axes)
    axes.set(xlabel="processor time per position (s)", ylabel="error of the contact point (mm)")
    if data.reason:
        theme.message(axes, data.reason)
        return Drawing(page, {})
    for order, (method, look) in enumerate(solved.items()):
        curve(axes, look, [(one.seconds[1], one.error_mm) for one in data.of(method)], order)
        for one in data.of(method):
            axes.hlines(one.error_mm, one.seconds[0], one.seconds[2], look.colour, linewidth=1.2)
    _set_limits(axes, data)
    labels, lines = Labels(axes), finding(data)
    if not layout.wide:  # so that the block fits next to the five equations
        lines = [line.replace(" times ", " \u00d7 ").replace(" against", "\nagainst") for line in lines]
    labels.block("\n".join(lines), corners, linespacing=1.4, fontsize=theme.SMALL)
    marks = {(one.method, one.value): one for one in data.measurements if one.status == "solved"}
    for method, value, label, places in LABELS:
        if mark := marks.get((method, value)):
            labels.put(label, (mark.seconds[1], mark.error_mm), places, LOOKS[method].colour)
    theme.legend(page, [look.line() for look in solved.values()], 5, left=0.02, below=1.35)
    return Drawing(page, {})


def unanswered(data: SpeedAccuracy) -> list[str]:
    """Return the methods without an answer, with the settings if other settings have one."""
    names = {(method, value): text for method, value, text, _ in LABELS}
    lost = []
    for method, look in LOOKS.items():
        failed = [one for one in data.measurements if one.method == method and one.status != "solved"]
        if not data.of(method):
            lost.append(look.label)
        elif failed:
            values = (names.get((method, one.value), f"{one.value:g}") for one in failed)
            lost.append(f"{look.label}, {', '.join(values)}")
    return lost


def _set_limits(axes: Axes, data: SpeedAccuracy) -> None:
    """Set limits outside all marks; a tick at the lowest error would touch the first tick of time."""
    solved = [one for one in data.measurements if one.status == "solved"]
    times = np.log10([one.seconds for one in solved] or [(1e-8, 1e-4, 1.0)])
    errors = np.log10([max(one.error_mm, 1e-16) for one in solved] or [1e-14, 1e2])
    for axis, set_limits, values, step in (
        (axes.xaxis, axes.set_xlim, times, 1),
        (axes.yaxis, axes.set_ylim, errors, 2),
    ):
        low, high = np.floor(values.min() - 0.5) - (step - 1), np.ceil(values.max() + 0.5)
        set_limits(10.0**low, 10.0**high)
        axis.set_major_locator(FixedLocator((10.0 ** np.arange(low + step - 1, high + 1.0, step)).tolist()))
    axes.minorticks_off()


def is_exact(one: Measurement) -> bool:
    """Return whether the error consists of rounding only."""
    return one.error_mm < 1e-9


def title(data: SpeedAccuracy) -> str:
    """Return the finding if the one equation is exact and the fastest exact method, else the subject."""
    exact = [one for one in data.measurements if is_exact(one)]
    fastest = min(exact, key=lambda one: one.seconds[1], default=None)
    if fastest is None or fastest.method != "one equation":
        return "Error and time of five methods that find the contact"
    if not any(one.method == "five equations" for one in exact):
        return "One equation is exact, and the fastest for many positions"
    return "One equation is as exact as five, and the fastest for many positions"


def finding(data: SpeedAccuracy) -> list[str]:
    """Return lines that compare the times of the one equation and of the five equations."""
    exact = [one.seconds[1] for one in data.of("five equations") if is_exact(one)]
    lines = []
    for one in data.of("one equation") if exact else ():
        if one.value in (1, 11, 101, 100_001) and is_exact(one):
            factor = min(exact) / one.seconds[1]
            rounded = float(f"{max(factor, 1.0 / factor):.2g}")
            lines.append(f"{one.value:,.0f}: {rounded:,g} times {'faster' if factor > 1.0 else 'slower'}")
    return ["one equation against five,", "by positions per call:", *lines] if lines else []


def rows(data: SpeedAccuracy) -> Table:
    """List every method at every value of its setting; the status says why an error is missing."""
    header = ("flank", "status", "method", "setting", "value", "error_mm", "gear_roll_error_rad")
    times = ("least_seconds_per_position", "seconds_per_position", "greatest_seconds_per_position")
    body: list[tuple[object, ...]] = [
        (data.flank, one.status, *astuple(one)[:5], *one.seconds) for one in data.measurements
    ]
    nothing = (data.flank, data.reason, "", "", *6 * [float("nan")])
    return (*header, *times), body or [nothing]


RECIPES = {"speed-accuracy": Recipe(compute, draw, rows)}
