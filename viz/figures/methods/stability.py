"""Where methods fail: near the smallest shaft angle with a common normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beveloid_geom import Design, Status
from beveloid_geom.arrays import Integers
from beveloid_geom.report.result import status_name
from beveloid_geom.validation import near_singular
from beveloid_geom.validation.near_singular import METHODS, MethodErrors, StatusMap

from ...components import annotate, paths_table
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.free_space import Labels
from ...components.map_panel import HALO
from ...rendering import theme
from ...rendering.layout import PanelRows
from .curves import curve, log_axes
from .speed_accuracy import LOOKS

ABOVE_DEG = 10.0 ** np.arange(-10.0, 0.1, 1.0)
"""Distances from the smallest shaft angle."""
COMPARED_CELLS = 12
"""Number of cells of each status at which the five equations are solved."""


@dataclass(frozen=True, eq=False)
class Stability:
    """Errors and map of one flank pair, or the `reason` for their absence; smallest shaft angle, rad."""

    design: Design
    flank: str
    smallest: float
    errors: MethodErrors | None = None
    answers: StatusMap | None = None
    reason: str = ""


def compute(design: Design, flank: str = "right") -> Stability:
    """Compute the errors of the methods, and the map about the offsets without backlash."""
    # Distances of shaft angles from the smallest one, as fractions of the distance of the design's shaft
    # angle from it. The first and the last are the ends of the map. The map covers the offsets without
    # backlash of the last three.
    shares = np.array((-0.25, 0.05, 1.0, 3.0))
    map_cells = 131  # along each axis, so that a column has the smallest shaft angle
    smallest = near_singular.smallest_shaft_angle(design, flank)
    above = float(design.pair.shaft_angle) - smallest
    try:
        if above <= 0.0:
            raise ValueError("the shaft angle is the smallest with a common normal")
        errors = near_singular.errors_above_smallest_shaft_angle(design, flank, np.radians(ABOVE_DEG))
        if np.isnan(errors.error).all():
            raise ValueError("without backlash, these flanks do not touch near the smallest shaft angle")
        angles = smallest + above * shares[1:]
        changed = (near_singular.at_shaft_angle(design, angle) for angle in angles.tolist())
        offsets = [float(one.pair.offset) for one in changed]
    except (ValueError, ImportError) as error:
        return Stability(design, flank, smallest, reason=str(error))
    margin = 0.15 * float(np.ptp(offsets))
    angles = smallest + above * np.linspace(shares[0], shares[-1], map_cells)
    rows = np.linspace(min(offsets) - margin, max(offsets) + margin, map_cells)
    answers = near_singular.status_map(design, flank, angles, rows, COMPARED_CELLS)
    return Stability(design, flank, smallest, errors, answers)


def draw(data: Stability, layout: theme.PageLayout) -> Drawing:
    """Draw the errors and the map."""
    cells = PanelRows(left=1.25, right=0.5, across=1.5, down=1.5, most=2, least=3.6)
    page, low, high = theme.new_page(
        layout,
        finding(data),
        f"{data.flank.capitalize()} flanks, unmodified. Smallest shaft angle with a common normal:"
        f" {np.degrees(data.smallest):.4f} deg",
        (
            "Five equations: Eq. 15 of the paper; one equation: reduced from these. (a) Largest error of five"
            " positions against 60 digits; meshes sampled to 0.01 mm. Crosses: no answer. Dotted: error bound"
            " that meshes state. (b) Axial positions fixed. Rings: five equations give the same answer."
            " Crosses: another or none."
        )
        if data.errors
        else "",
        below=0.75,
        above=1.15,
        tall=cells.tall(layout, 2, 4.0) if data.errors else 2.0,
    )
    if data.errors is None or data.answers is None:
        axes = page.add_axes((0.05, low, 0.9, high - low))
        axes.set_axis_off()
        theme.message(axes, data.reason)
        return Drawing(page, {})
    first, second = theme.panels(page, cells, 2, low, high)
    first.set_title("(a)  Error of four methods", loc="left", pad=10.0)
    second.set_title("(b)  Answer of the one equation", loc="left", pad=10.0)
    lines = _errors(first, data.errors, wrong_mm(data.design))
    patches = _map(second, data, data.answers)
    theme.legend(page, [*lines, *patches], 4, left=0.02, below=1.35)
    return Drawing(page, {})


def _errors(axes: Axes, data: MethodErrors, limit: float) -> list[Line2D]:
    """Draw error against distance; return the entries of the legend. Errors above `limit`, mm, are wrong."""
    no_answer_mm = 1e3
    log_axes(axes)
    above, rows = np.degrees(data.above), iter(range(len(METHODS)))
    axes.set(xlim=(0.3 * above[0], 3.0 * above[-1]), ylim=(1e-13, 1e7))
    axes.set(xlabel="shaft angle above the smallest (deg)", ylabel="error of the contact point (mm)")
    lines = []
    for number, name in enumerate(METHODS):
        look, error = LOOKS[name], data.error[number]
        known = np.isfinite(error)
        curve(axes, look, list(zip(above, error, strict=True)), number)  # with gaps
        stated = np.isfinite(data.stated[number])
        axes.plot(above[stated], data.stated[number][stated], ":", color=look.colour, linewidth=1.2)
        # Methods without an answer where another one has one: a row of crosses above the curves.
        lost = ~known & np.isfinite(data.error).any(axis=0)
        if lost.any():
            height = no_answer_mm * 20.0 ** next(rows)
            axes.plot(above[lost], np.full(lost.sum(), height), "x", color=look.colour, ms=7.0, mew=1.8)
            style = {"fontsize": theme.SMALL, "color": look.colour, "ha": "left", "va": "center"}
            theme.label_point(axes, (above[lost].max(), height), "no answer", (10.0, 0.0), **style)
        if (at := wrong(data, number, limit)).size:
            worst = at[np.argmax(error[at])]
            up_to = "up to " if at.size > 1 else ""
            leader = {"arrowstyle": "-", "color": look.colour, "linewidth": 1.0}
            style = {"fontsize": theme.SMALL, "color": look.colour, "arrowprops": leader}
            words, place = f"wrong by {up_to}{error[worst]:.2g} mm", (above[worst], error[worst])
            theme.label_point(axes, place, words, (62.0, -48.0), **style)
        lines.append(look.line())
    return lines


def wrong_mm(design: Design) -> float:
    """Return the error (mm) of a point without a stated error bound that counts as wrong, in proportion to
    the module."""
    return 1e-2 * paths_table.as_large(design)


def wrong(data: MethodErrors, number: int, limit: float) -> Integers:
    """Return the indices at which a method gives a wrong point: its error exceeds `limit`, mm, and the bound
    that the method states."""
    error, stated = data.error[number], data.stated[number]
    return np.flatnonzero((error > limit) & ~(stated >= error))


def _map(axes: Axes, data: Stability, answers: StatusMap) -> list[Patch]:
    """Draw the status over shaft angle and offset; return the entries of the legend."""
    looks = {
        Status.SOLVED: ("contact on the flanks", theme.GREEN),
        Status.OFF_FLANK: ("contact misses the flanks", theme.PALE),
        Status.NO_COMMON_NORMAL: ("no common normal", "white"),
        Status.NOT_CONVERGED: ("not known", theme.ORANGE),
    }
    codes, colour = list(looks), [hue for _, hue in looks.values()]
    other = ~np.isin(answers.status, codes)
    index = np.where(other, codes.index(Status.NOT_CONVERGED), 0)
    for number, code in enumerate(codes):
        index[answers.status == code] = number
    x, y = np.degrees(answers.shaft_angle), answers.offset
    norm = BoundaryNorm(np.arange(len(codes) + 1) - 0.5, len(codes))
    axes.pcolormesh(x, y, index, cmap=ListedColormap(colour), norm=norm, shading="nearest", rasterized=True)
    axes.axvline(float(np.degrees(data.smallest)), color=theme.INK, linewidth=1.2, linestyle="--")
    rows, columns = answers.compared.T
    same = answers.five_equations == answers.status[rows, columns]
    for mask, marker in ((same, "o"), (~same, "x")):
        place = x[columns[mask]], y[rows[mask]]
        axes.plot(*place, marker, color=theme.INK, mfc="none", ms=5.0, mew=1.2)
    here = float(np.degrees(float(data.design.pair.shaft_angle))), float(data.design.pair.offset)
    axes.plot(*here, "s", color=theme.VERMILLION, ms=7.0, mec="white")
    shifts = ((-14.0, 8.0, "right"), (14.0, -16.0, "left"), (14.0, 8.0, "left"), (-14.0, -16.0, "right"))
    if not Labels(axes).put("the design", here, shifts, theme.VERMILLION, path_effects=HALO, zorder=5.0):
        annotate.text(axes, here, "the design", (44.0, -12.0), fontsize=theme.SMALL, color=theme.VERMILLION)
    axes.set(xlabel="shaft angle (deg)", ylabel="offset (mm)")
    shown = [number for number in range(len(codes)) if (index == number).any()]
    return [
        Patch(facecolor=colour[k], edgecolor=theme.GREY, linewidth=0.8, label=looks[codes[k]][0])
        for k in shown
    ]


def finding(data: Stability) -> str:
    """Return the title: the finding if the one equation is right at more distances than each other method."""
    if data.errors is not None:
        *others, last = range(len(METHODS))
        limit = wrong_mm(data.design)
        right = [np.delete(data.errors.error[k], wrong(data.errors, k, limit)) for k in (*others, last)]
        *counts, most = (int((one < limit).sum()) for one in right)
        if most > max(counts):
            return "Close to the smallest shaft angle, the one equation alone finds the contact"
    return "Error of four methods near the smallest shaft angle"


def rows(data: Stability) -> Table:
    """List the errors, then the cells at which both methods were compared."""
    header = ("flank", "status", "method", "shaft_angle_deg", "offset_mm", "error_mm", "stated_error_mm")
    if data.errors is None or data.answers is None:
        return header, [(data.flank, data.reason, "", *4 * [float("nan")])]
    body: list[tuple[object, ...]] = []
    for number, name in enumerate(METHODS):
        for k, above in enumerate(data.errors.above.tolist()):
            angle = float(np.degrees(data.smallest + above))
            status = data.errors.reason[number][k] or "solved"
            numbers = data.errors.offset[k], data.errors.error[number, k], data.errors.stated[number, k]
            body.append((data.flank, status, name, angle, *map(float, numbers)))
    nothing = float("nan"), float("nan")
    for (row, column), five in zip(data.answers.compared, data.answers.five_equations.tolist(), strict=True):
        place = float(np.degrees(data.answers.shaft_angle[column])), float(data.answers.offset[row])
        statuses = {"one equation": int(data.answers.status[row, column]), "five equations": five}
        for name, code in statuses.items():
            status = status_name(Status(code)) if code >= 0 else "refused"
            body.append((data.flank, status, f"{name}, map", *place, *nothing))
    return header, body


RECIPES = {"stability": Recipe(compute, draw, rows)}
