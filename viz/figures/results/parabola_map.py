"""Map of a design over the sum and the difference of its parabola coefficients.

Flanks with a1 + a2 > 0 have a negative relative curvature. The contact ratio has a narrow ridge just below a
sum of 0, so the sums are spaced quadratically from 0. The extremes given in the subtitle are not cells of the
map; `map_extremes` computes them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from beveloid_geom import Design, Errors, MeshErrors, contact_ratio, mesh_cycle
from beveloid_geom.analysis.maps import usual_bounds, usual_errors
from beveloid_geom.analysis.optimise import Aim, objectives_of
from beveloid_geom.analysis.path_measures import measures_of
from beveloid_geom.arrays import Codes, FloatArray, Mask
from beveloid_geom.contact.path import path_ends
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.result import status_name
from beveloid_geom.report.text import error_words, status_words
from beveloid_geom.status import Status

from ...components import map_panel, paths_table
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.map_extremes import Extreme, least_shift, most_ratio
from ...rendering import theme
from ...rendering.layout import PanelRows

INTERVAL_COUNT = 20
"""Intervals of the difference. The sum has 24 intervals, of equal size in its square root."""
HALF_TURN_DEG = 180.0
"""Period of the angle of a path."""
HATCHES = {"hollow": "//", "no path": "xxx", "not known": "...."}
"""Hatches of cells: flanks hollow against each other, no path, value not known."""


@dataclass(frozen=True)
class MapQuantity:
    """Heading with the unit, factor to this unit, colour map and kind of scale of a mapped quantity."""

    heading: str
    factor: float
    colours: str
    scale: str = "linear"


QUANTITIES = {
    "contact_ratio": MapQuantity("contact ratio, Eq. 16", 1.0, "viridis"),
    "angle": MapQuantity("angle of the path (deg)", math.degrees(1.0), "twilight", "cyclic"),
    "shift": MapQuantity("shift under errors (mm)", 1.0, "cividis", "log"),
    "cycle_peak_to_peak": MapQuantity("transmission error (arcsec)", ARCSEC, "magma"),
    "centre": MapQuantity("middle, pinion z (mm)", 1.0, "viridis"),
    "edge_share": MapQuantity("edge contact (%)", 100.0, "viridis", "share"),
}


@dataclass(frozen=True, eq=False)
class ParabolaMap:
    """Quantities (differences, sums) by name over `difference` a1 - a2 and `total` a1 + a2, 1/mm.

    `status`: codes of `Status` of the paths. `least_shift`: with a contact ratio not below `ratio`, the
    contact ratio of the design as given."""

    design: Design
    flank: str
    errors: Errors | MeshErrors
    difference: FloatArray
    total: FloatArray
    status: Codes
    quantities: dict[str, FloatArray]
    ratio: float
    most_ratio: Extreme
    least_shift: Extreme

    @property
    def solved(self) -> Mask:
        """Cells with a path on the flanks."""
        return np.asarray(self.status == Status.SOLVED)

    @property
    def coefficients(self) -> tuple[FloatArray, FloatArray]:
        """Coefficients a1 and a2 of the cells, 1/mm."""
        difference, total = np.meshgrid(self.difference, self.total, indexing="ij")
        return 0.5 * (total + difference), 0.5 * (total - difference)

    def shows(self, extreme: Extreme) -> bool:
        """Return True if the map covers the coefficients of an extreme."""
        limits = (self.difference, extreme.pinion - extreme.gear), (self.total, extreme.pinion + extreme.gear)
        slack = [1e-9 * np.ptp(values) for values, _ in limits]
        return all(
            float(values.min() - slack_size) <= at <= float(values.max() + slack_size)
            for (values, at), slack_size in zip(limits, slack, strict=True)
        )


def compute(design: Design, flank: str = "right") -> ParabolaMap:
    """Compute the map and its extremes.

    With the usual largest coefficient c, differences reach from -2 c to 2 c, and sums from -0.5 c to 0.18 c.
    This includes the paper's Figs. 7 to 10."""
    largest = min(high for _, high in usual_bounds(design, "parabola"))
    difference = 2.0 * largest * np.linspace(-1.0, 1.0, INTERVAL_COUNT + 1)
    root = np.linspace(-1.0, 1.0, 3 * INTERVAL_COUNT // 2 + 1)
    root = root[root < 0.65]
    total = 0.5 * largest * root * np.abs(root)
    second, first = np.meshgrid(total, difference)
    pinion, gear = (0.5 * (second + sign * first).ravel() for sign in (1.0, -1.0))
    errors, cells = usual_errors(design), design.with_parabola(pinion, gear)
    with np.errstate(invalid="ignore"):  # a path of a single point has no direction
        measures = measures_of(cells, flank)
        shown = objectives_of(design, flank, Aim(errors), pinion, gear)
    status, lost = np.full(pinion.size, Status.SOLVED, dtype=np.int8), measures.limit[:, 0] < 0
    if lost.any():
        status[lost] = path_ends(design.with_parabola(pinion[lost], gear[lost]), flank).status
    swing, edges = np.array([_in_operation(design, flank, *at) for at in zip(pinion, gear, strict=True)]).T
    quantities = {
        "contact_ratio": np.where(lost, np.nan, measures.contact_ratio),
        "angle": np.radians(measures.angle["chord"][0]),
        "shift": shown.shift,
        "cycle_peak_to_peak": swing,
        "centre": shown.centre,
        "edge_share": edges,
    }
    shaped = {name: values.reshape(first.shape) for name, values in quantities.items()}
    ratio = float(contact_ratio(design, flank))
    most = most_ratio(design, flank, largest)
    least = least_shift(design, flank, errors, ratio, most.value, largest)
    codes = status.reshape(first.shape)
    return ParabolaMap(design, flank, errors, difference, total, codes, shaped, ratio, most, least)


def _in_operation(design: Design, flank: str, pinion: float, gear: float) -> tuple[float, float]:
    """Return transmission error (rad, peak to peak) and share on edges of a mesh cycle; NaN if not known."""
    try:
        cycle = mesh_cycle(design.with_parabola(float(pinion), float(gear)), flank, 1)
    except ValueError:  # the rounds of a tool overlap: there are no fillets
        return math.nan, math.nan
    return float(cycle.peak_to_peak), float(cycle.edge_share)


def draw(data: ParabolaMap, layout: theme.PageLayout) -> Drawing:
    """Draw six maps of one design."""
    note = (
        "Angle: chord to axial direction (pinion, r over z). Shift: perpendicular to the path at mid-roll,"
        " root of the sum of squares under {errors}. Transmission error, edge contact: all teeth."
        " Sum: square-root scale. Interpolated between {cells} cells. Pointed ends of bars: values beyond."
    )
    cells = PanelRows(left=1.2, right=1.0, across=1.16, down=0.65, most=3, least=1.0)
    errors = error_words(data.errors).replace("+", "\u00b1") + paths_table.at_the_mesh(data.design)
    count, columns = len(QUANTITIES), cells.columns(layout, len(QUANTITIES))
    if layout.printed:
        cells = replace(cells, down=0.8)
    tall = cells.tall(layout, count, min(1.15 * cells.width(layout, count), 2.3))
    cells_of = f"{data.difference.size} \u00d7 {data.total.size}"
    page, low, high = theme.new_page(
        layout, *finding(data), note.format(errors=errors, cells=cells_of), below=1.25, above=0.4, tall=tall
    )
    panels = zip(QUANTITIES.items(), theme.panels(page, cells, count, low, high), strict=True)
    for index, ((name, quantity), axes) in enumerate(panels):
        heading = f"({'abcdef'[index]})  {quantity.heading}"
        axes.set_title(heading, loc="left", pad=8.0, fontsize=theme.SMALL if layout.printed else theme.LABEL)
        _set_axes(axes, data)
        _colours(page, axes, data, name)
        places = _marks(axes, data, named=index == 0)
        lowest, leftmost = index >= count - columns, index % columns == 0
        axes.set_xlabel("$a_1 - a_2$ (10$^{-3}$/mm)" if lowest else "")
        axes.set_ylabel("$a_1 + a_2$ (10$^{-3}$/mm)" if leftmost else "")
        axes.tick_params(labelbottom=lowest, labelleft=leftmost)
        map_panel.thin_out(axes, places)
    _legend(page, data, low - theme.inches(page, 0.95))
    return Drawing(page, {})


def finding(data: ParabolaMap) -> tuple[str, str]:
    """Return title and subtitle with the extremes."""
    most, least = data.most_ratio.value, data.least_shift.value
    words = [] if math.isnan(most) else [f"contact ratio up to {most:.2f} in the map"]
    if not math.isnan(least):
        at = "" if data.shows(data.least_shift) else ", outside the map"
        words.append(f"smallest shift at a ratio of {data.ratio:.2f} or more: {least:.3g} mm{at}")
    subtitle = f"{data.flank.capitalize()} flanks" + (f": {', '.join(words)}" if words else "")
    return "Contact over sum and difference of the parabola coefficients", subtitle


def _set_axes(axes: Axes, data: ParabolaMap) -> None:
    """Set limits in 1e-3/mm and a square-root scale of the sum."""
    x, y = 1e3 * data.difference, 1e3 * data.total
    root = (lambda v: np.sign(v) * np.sqrt(np.abs(v)), lambda v: np.sign(v) * np.square(v))
    axes.set_yscale("function", functions=root)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    step = 10.0 ** math.floor(math.log10(abs(y[0])))
    ticks = [value * step for value in (-5.0, -2.0, -1.0, -0.5, -0.1, 0.0, 0.1, 0.2, 0.5, 1.0, 2.0)]
    axes.set_yticks([value for value in ticks if y[0] <= value <= y[-1]])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: _plain(value))
    axes.minorticks_off()


def _colours(page: theme.Page, axes: Axes, data: ParabolaMap, name: str) -> None:
    """Draw a quantity with colour bar, contours and hatches, or the reason why nothing is drawn."""
    # Angles of a path have a period of 180 deg. If an interval at least this wide contains no angle, the
    # colour scale begins and ends in it; otherwise the colours are cyclic.
    least_gap_deg = 10.0
    quantity, values = QUANTITIES[name], QUANTITIES[name].factor * data.quantities[name]
    # Values below this are zero, in the units of the headings.
    rounding = 1e-9
    # Rounding errors of zero are set to one value, so that they have no contour lines.
    values = np.where(np.abs(values) < rounding, rounding, values)
    x, y = 1e3 * data.difference, 1e3 * data.total
    map_panel.hatch(axes, x, y, ~data.solved, HATCHES["no path"])
    if not np.isfinite(values).any():
        codes = np.unique(data.status[~data.solved]).tolist()
        reasons = ", ".join(status_words(code) for code in codes)
        theme.message(
            axes, "not known in any cell" if data.solved.any() else f"no cell has a path: {reasons}"
        )
        return
    cyclic = quantity.scale == "cyclic"
    fine_x, fine_y, fine = _finer(x, y, values, HALF_TURN_DEG if cyclic else math.inf)
    # Values change suddenly within two cells of a cell without a value: the colours do not cover the range
    # of these cells, and there are no contour lines.
    border = map_panel.next_to_unknown(values, 2)
    # The colours cover the range of the cells that a pair can use.
    usable = values[~border & (y <= 0.0)] if (~border & (y <= 0.0)).any() else values[:, y <= 0.0]
    usable = usable[np.isfinite(usable)] if np.isfinite(usable).any() else values[np.isfinite(values)]
    colours = quantity.colours
    if cyclic:
        start, gap = map_panel.widest_gap(usable, HALF_TURN_DEG)
        cyclic = gap < least_gap_deg
        colours = colours if cyclic else "viridis"
        start = -0.5 * HALF_TURN_DEG if cyclic else start - HALF_TURN_DEG
        usable, fine = (start + (angles - start) % HALF_TURN_DEG for angles in (usable, fine))
    if quantity.scale == "cyclic" and not cyclic:  # hollow pairs may have any angle
        fine = np.where(fine_y <= 1e-9, fine, np.nan)
        white = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        look: dict[str, Any] = {"fontsize": theme.SMALL, "zorder": 7.0, "bbox": white}
        theme.message(axes, "in CSV only", height=0.8, **look)
    norm, levels = _scale(quantity, usable, cyclic)
    mesh = axes.pcolormesh(
        fine_x, fine_y, fine.T, cmap=colours, norm=norm, shading="nearest", rasterized=True, zorder=0.0
    )
    box, width = axes.get_position(), page.layout.width
    bar = page.add_axes((box.x1 + 0.096 / width, box.y0, 0.144 / width, box.height))
    least, most = mesh.get_clim()
    below, above = int(np.nanmin(fine) < least), int(np.nanmax(fine) > most)
    extend = ("neither", "max", "min", "both")[2 * below + above]
    scale = page.colorbar(mesh, cax=bar, ticks=levels, extend=extend)
    scale.ax.minorticks_off()
    words = _angle if quantity.scale == "cyclic" else _plain
    scale.ax.set_yticklabels([words(level) for level in levels], fontsize=theme.SMALL)
    fine = np.where(map_panel.between_cells((border | ~data.solved).astype(float)) > 0.5, np.nan, fine)
    if cyclic:
        for level in levels[:-1]:
            turns = 2.0 * np.pi * (fine - level) / HALF_TURN_DEG
            crossed = np.where(np.cos(turns) > 0.0, np.sin(turns), np.nan)
            map_panel.contours(axes, fine_x, fine_y, crossed, np.zeros(1), [words(level)])
    elif quantity.scale != "share":
        shown = np.where(fine_y <= 1e-9, fine, np.nan)
        map_panel.contours(axes, fine_x, fine_y, shown, levels, [words(level) for level in levels])
    map_panel.hatch(axes, x, y, np.broadcast_to(y > 1e-9, values.shape), HATCHES["hollow"])
    map_panel.hatch(axes, x, y, np.isnan(values) & data.solved, HATCHES["not known"])


def _finer(
    x: FloatArray, y: FloatArray, values: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return axes and values of a map interpolated between its cells, evenly along the axes as drawn."""
    fine = map_panel.between_cells(values, period)
    root = np.sign(y) * np.sqrt(np.abs(y))
    across, up = (np.linspace(0.0, 1.0, count) for count in fine.shape)
    at = np.interp(up, np.linspace(0.0, 1.0, y.size), root)
    return x[0] + across * (x[-1] - x[0]), np.sign(at) * at**2, fine


def _angle(value: float) -> str:
    """Return an angle in degrees between -90 and 90."""
    return _plain(0.5 * HALF_TURN_DEG - (0.5 * HALF_TURN_DEG - value) % HALF_TURN_DEG)


def _scale(quantity: MapQuantity, values: FloatArray, cyclic: bool) -> tuple[Normalize, FloatArray]:
    """Return the norm of the colours and the levels of ticks and contour lines."""
    if cyclic:
        return Normalize(-90.0, 90.0), np.array([-90.0, -45.0, 0.0, 45.0, 90.0])
    low, high = (0.0, 100.0) if quantity.scale == "share" else np.percentile(values, [1.0, 99.0]).tolist()
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5
    if quantity.scale == "log" and high > 5.0 * low > 0.0:  # at least two levels
        levels = np.array([digit * 10.0**k for k in range(-6, 7) for digit in (1.0, 2.0, 5.0)])
        return LogNorm(low, high), levels[(levels >= low) & (levels <= high)]
    steps = [1.0, 1.5, 3.0, 10.0] if quantity.scale == "cyclic" else [1.0, 2.0, 2.5, 5.0, 10.0]
    levels = np.asarray(MaxNLocator(6, steps=steps).tick_values(low, high))
    return Normalize(low, high), levels[(levels >= low) & (levels <= high)]


def _marks(axes: Axes, data: ParabolaMap, named: bool) -> list[tuple[float, float]]:
    """Draw the paper's coefficients (C1 to C4, along the axes of the map), the design and the extremes.

    Returns the places of the marks in data coordinates."""
    axes.axhline(0.0, color=theme.INK, linewidth=1.0, zorder=3.0)
    axes.axvline(0.0, color=theme.INK, linewidth=1.0, zorder=3.0)
    style: dict[str, Any] = {"fontsize": theme.SMALL, "zorder": 7.0, "path_effects": map_panel.HALO}
    names = [("C1", 0.5, 0.97, "left", "top"), ("C2", 0.5, 0.03, "left", "bottom")]
    height = float(axes.transAxes.inverted().transform(axes.transData.transform((0.0, 0.0)))[1])
    names += [("C3", 0.98, height, "right", "top"), ("C4", 0.02, height, "left", "top")]
    for name, across, up, side, edge in names if named else ():
        axes.text(across, up, f" {name}", transform=axes.transAxes, ha=side, va=edge, **style)
    given = paths_table.parabolas(data.design, data.flank)
    marks = (Extreme(*given), "o"), (data.most_ratio, "^"), (data.least_shift, "s")
    places = []
    for place, marker in marks:
        if data.shows(place):
            at = 1e3 * (place.pinion - place.gear), 1e3 * (place.pinion + place.gear)
            look = _mark(marker) | ({"ms": 4.5} if at in places else {})  # inside the mark at the same place
            places.append(at)
            axes.plot(*at, **look, zorder=6.0, clip_on=False)
    return places


def _mark(marker: str) -> dict[str, Any]:
    """Return the style of a mark."""
    return {"ls": "", "marker": marker, "ms": 8.0, "mfc": "white", "mec": theme.INK}


def _legend(page: theme.Page, data: ParabolaMap, height: float) -> None:
    """Explain the marks, and the hatches that occur, at a height of the page."""
    entries: list[Artist] = [Line2D([], [], **_mark("o"), label="design")]
    if data.shows(data.most_ratio):
        entries.append(Line2D([], [], **_mark("^"), label="largest ratio"))
    if data.shows(data.least_shift):
        entries.append(Line2D([], [], **_mark("s"), label="smallest shift"))
    entries.append(Line2D([], [], color=theme.INK, linewidth=1.0, label="C1 to C4 of Figs. 7 to 10"))
    unknown = np.logical_or.reduce([np.isnan(values) for values in data.quantities.values()]) & data.solved
    hatches = [
        (np.array(True), "hollow", "negative relative curvature (sum above 0)"),
        (~data.solved, "no path", "no path"),
        (unknown, "not known", "not known"),
    ]
    for cells, kind, text in hatches:
        if cells.any():
            look: dict[str, Any] = {"facecolor": "white", "edgecolor": theme.GREY, "hatch": HATCHES[kind]}
            entries.append(Patch(**look, linewidth=0.5, label=text))
    style: dict[str, Any] = {"fontsize": theme.SMALL, "handlelength": 2.4, "columnspacing": 1.8}
    theme.legend(page, entries, len(entries), loc="center", bbox_to_anchor=(0.5, height), **style)


def _plain(value: float) -> str:
    """Return a number with a true minus."""
    return f"{value:.6g}".replace("-", "\u2212")


def rows(data: ParabolaMap) -> Table:
    """List every cell of the map, then the extremes."""
    names = ("contact_ratio", "angle_rad", "shift_mm", "cycle_peak_to_peak_rad", "centre_mm", "edge_share")
    header = ("a1_per_mm", "a2_per_mm", "status", *names, "extreme")
    pinion, gear = (values.ravel().tolist() for values in data.coefficients)
    columns = [data.quantities[name].ravel().tolist() for name in QUANTITIES]
    status = [status_name(code) for code in data.status.ravel().tolist()]
    cells: list[tuple[object, ...]] = [(*row, "") for row in zip(pinion, gear, status, *columns, strict=True)]
    solved, nan = status_name(Status.SOLVED), math.nan
    most, least = data.most_ratio, data.least_shift
    if not math.isnan(most.value):
        cells.append((most.pinion, most.gear, solved, most.value, *5 * [nan], "largest contact ratio"))
    if not math.isnan(least.value):
        cells.append((least.pinion, least.gear, solved, nan, nan, least.value, *3 * [nan], "least shift"))
    return header, cells


RECIPES = {"map-parabola": Recipe(compute, draw, rows)}
