"""Ease-off of both flanks of the pinion, before and after modification: wire surfaces and level lines."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MaxNLocator

from beveloid_geom import ContactPath, Design, EaseOff, ease_off, path_of_contact
from beveloid_geom.analysis.ease_off import ease_off_at
from beveloid_geom.arrays import FloatArray
from beveloid_geom.findings.path import reason_of
from beveloid_geom.gear.flank import root_parameter, tip_parameter

from ...parts.charts import LEAST_EASE_OFF
from ...parts.map_panel import HALO, LEVEL, thin_out
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, coefficients, modified
from ...stage import theme
from ...stage.layout import Cells

CELLS = Cells(left=0.72, right=0.464, across=0.672, down=2.3, most=4, least=1.6)
POINTS = 41
"""Positions of a path."""
SHEAR, RISE, HIGH = 0.42, 0.46, 1.25
"""Of a wire surface, in half faces: how far the tip is drawn to the right of the root and above it, and how
high the greatest ease-off of a flank."""
BAR = 2.0
"""Half faces from the middle of a wire surface to the bar of its scale."""
BAR_IN_PRINT = 1.8, -0.05
"""The same in print, to the right and up: between the words at the heel, which reach as far as BAR."""
SHAPE, EVERY = (29, 41), 2
"""Points along profile and face, and of these what stand on a wire."""
LINES = 3
"""Lines of contact drawn, at even steps of the path's roll."""
EDGE = 0.9
"""Share of half a flank beyond which level lines are not labelled."""
NOTE = (
    "Deviation of the pinion's flank along its normal from the conjugate of the gear's flank, which has no"
    " tips and edges here, turns at the constant ratio, and touches at mid-roll of the path: positive (up)"
    " where the flanks part. Orange: path of contact, from the dot to the arrow head. Grey: zero;"
    " dash-dotted: where conjugate flanks would touch at three rolls. Heights of a flank have one scale, its"
    " bar. Level lines: over the face, z from toe to heel, and the profile, l1 from root to tip. Below:"
    " mean, twist, slopes and crownings along face and profile of the nearest surface of second order over"
    " both from \u22121 to 1, and the root mean square of the rest."
)


@dataclass(frozen=True, eq=False)
class Panel:
    """One flank in one case: what was found on the pinion, the path, and the ease-off (n,), mm, along it; or
    the reason why there is nothing."""

    flank: str
    case: str
    found: EaseOff | None
    path: ContactPath
    along: FloatArray
    reason: str = ""

    @property
    def places(self) -> tuple[FloatArray, FloatArray]:
        """Places (n,) of the path along face and profile, from -1 to 1."""
        member = self.path.design.pinion
        root, tip = root_parameter(member), tip_parameter(member, self.flank, self.path.pinion_z)
        face = 2.0 * self.path.pinion_z / float(member.face_width)
        return face, 2.0 * (self.path.l1 - root) / (tip - root) - 1.0


def compute(design: Design) -> tuple[Panel, ...]:
    """Find the ease-off of right and left flanks, without parabolas and with those of the design, or with the
    usual ones if it has none."""
    bent = any(float(member.tool.parabola) for member in design.members)
    after = design if bent else modified(design)
    cases = ("without parabolas", design.with_parabola(0.0, 0.0)), (coefficients(after), after)
    return tuple(_panel(flank, case, one) for flank in FLANKS for case, one in cases)


def _panel(flank: str, case: str, design: Design) -> Panel:
    path = path_of_contact(design, flank, POINTS)
    try:
        if reason := reason_of(path):
            raise ValueError(reason)
        along = ease_off_at(design, flank, path.l1, path.pinion_z)
        return Panel(flank, case, ease_off(design, flank, SHAPE), path, along)
    except ValueError as error:
        return Panel(flank, case, None, path, np.zeros(0), str(error))


def draw(data: tuple[Panel, ...], layout: theme.Layout) -> Drawing:
    """Draw a column for each flank and case: the wire surface above, level lines below."""
    cells = replace(CELLS, left=0.85, across=0.85) if layout.printed else CELLS
    page, low, high = theme.new_page(
        layout,
        "Ease-off of the pinion",
        "Right and left flanks, drive and coast, against the conjugate of the untrimmed gear, \u00b5m",
        NOTE,
        below=1.75,
        above=0.45,
        tall=cells.tall(layout, len(data), 4.6),
    )
    for column, (panel, box) in enumerate(
        zip(data, theme.panels(page, cells, len(data), low, high), strict=True)
    ):
        surface, levels = _axes(box)
        surface.set_axis_off()
        surface.set_title(f"({'abcd'[column]})  {panel.flank.capitalize()} flanks\n{panel.case}", loc="left")
        if panel.found is None:
            theme.say(surface, f"no ease-off: {panel.reason}", 30)
            levels.set_axis_off()
            continue
        same = [one.found.deviation for one in data if one.flank == panel.flank and one.found is not None]
        _wires(
            surface,
            panel,
            panel.found,
            1e3 * np.array((np.nanmin(same), np.nanmax(same))),
            layout.printed,
        )
        _levels(levels, panel, panel.found)
        words = _second_order_words(panel.found)
        style: dict[str, Any] = {"xycoords": "axes fraction", "va": "top", "fontsize": theme.SMALL}
        theme.beside(levels, (0.0, 0.0), words, (0.0, -42.0), **style)
    return Drawing(page, {})


def _axes(box: Axes) -> tuple[Axes, Axes]:
    """Make axes for a wire surface over ones for level lines, in place of a panel that has room for both."""
    page, at = cast("theme.Page", box.figure), box.get_position()
    box.remove()
    (upper, lower), height = theme.rows(at.y0, at.y1, 2, theme.inches(page, 0.35))
    left, wider = 0.32 / page.layout.width, 0.56 / page.layout.width  # inches for words at the corners
    surface = page.add_axes((at.x0 - left, upper, at.width + wider, height))
    return surface, page.add_axes((at.x0, lower, at.width, 0.92 * height))


def _wires(axes: Axes, panel: Panel, found: EaseOff, span: FloatArray, printed: bool) -> None:
    """Draw the surface as wires over the plane of zero, tip behind, hidden lines left out. From zero or the
    least to the greatest of the `span` (2,), um, are HIGH half faces; some more are left for words."""
    lowest, greatest = min(float(span[0]), 0.0), max(float(span[1]), 0.0)
    scale = HIGH / (greatest - lowest) if greatest - lowest > LEAST_EASE_OFF else 0.0

    def seen(face: FloatArray, profile: FloatArray, height: FloatArray) -> FloatArray:
        return np.stack((face + SHEAR * profile, RISE * profile + scale * height), axis=-1)

    face, profile = np.meshgrid(found.face[::EVERY], found.profile[::EVERY])
    grid = seen(face, profile, 1e3 * found.deviation[::EVERY, ::EVERY])
    plane = seen(np.array([-1.0, 1.0, 1.0, -1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0, -1.0]), np.zeros(5))
    axes.plot(*plane.T, color=theme.GREY, linewidth=1.2, zorder=0.5)
    quads = np.stack((grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]), axis=2)[::-1]
    quads = quads.reshape(-1, 4, 2)
    shown = PolyCollection(list(quads[np.isfinite(quads).all(axis=(1, 2))]))
    shown.set(facecolor="white", edgecolor=theme.BLUE, linewidth=0.9, alpha=0.9, zorder=1.0)
    axes.add_collection(shown)
    _path(axes, seen(*panel.places, 1e3 * panel.along))
    for depth, (i, p) in {"root": (0, -1.0), "tip": (-1, 1.0)}.items():
        for end, (j, f) in {"toe": (0, -1.0), "heel": (-1, 1.0)}.items():
            height = np.array((0.0, 1e3 * found.deviation[i, j]))
            foot, top = seen(np.full(2, f), np.full(2, p), height)
            axes.plot(*np.array((foot, top)).T, color=theme.GREY, linewidth=1.0, linestyle=":", zorder=0.6)
            value = theme.signed(1e3 * found.corners[f"{depth}_{end}"], 1)
            at = top if p > 0.0 and np.isfinite(top).all() else foot
            place = {"ha": "left" if f > 0.0 else "right", "va": "bottom" if p > 0.0 else "top"}
            words = f"{depth}, {end}\n{value}" if np.isfinite(top).all() else f"{depth}, {end}\nnone"
            text = theme.beside(
                axes, at, words, (2.0 * f, 5.0 * p), fontsize=theme.SMALL, zorder=5.0, **place
            )
            text.set_path_effects(HALO)
    length, floor = (
        theme.round_length(max(0.5 * (greatest - lowest), LEAST_EASE_OFF)),
        scale * lowest - RISE - 0.4,
    )
    right, foot = BAR_IN_PRINT if printed else (BAR, floor)
    if greatest - lowest > LEAST_EASE_OFF:
        axes.plot([right, right], [foot, foot + scale * length], color=theme.INK, linewidth=3.0)
        unit, style = f"{length:g} \u00b5m", {"fontsize": theme.SMALL}
        theme.beside(axes, (right, foot), unit, (0.0, -4.0), ha="center", va="top", **style)
    across, over = ((-2.35, 2.55), 1.4) if printed else ((-2.1, 2.15), 0.9)  # room for words
    axes.set(xlim=across, ylim=(floor - 0.25, floor + 2.0 * RISE + HIGH + over))


def _levels(axes: Axes, panel: Panel, found: EaseOff) -> None:
    """Draw level lines over the flank, z by l, with the path."""
    values = np.ma.masked_invalid(1e3 * found.deviation)
    if float(np.abs(values).max()) < LEAST_EASE_OFF:
        theme.say(axes, "zero but for rounding", 24, 0.12, backgroundcolor="white")
        values[:] = 0.0
    levels = MaxNLocator(9, steps=[1, 2, 5, 10]).tick_values(float(values.min()), float(values.max()))
    styles: dict[str, Any] = {"colors": theme.BLUE, "linewidths": 1.2, "negative_linestyles": "dashed"}
    lines = axes.contour(found.z, found.l, values, levels=levels, **styles)
    for label in axes.clabel(lines, fontsize=theme.SMALL, inline=False, colors=theme.INK):
        label.set_text(label.get_text().replace("-", "\u2212"))
        label.set_path_effects(HALO)
        label.set_gid(LEVEL)
        place = np.divide(label.get_position(), (found.z.max(), np.abs(found.l).max()))
        if np.abs(place).max() > EDGE:
            label.remove()  # cut off
    thin_out(axes)
    roll = panel.path.pinion_roll
    lines_at = np.sort(np.linspace(roll[0], roll[-1], LINES + 2)[1:-1])
    thin: dict[str, Any] = {"colors": theme.GREY, "linewidths": 1.0, "linestyles": "dashdot"}
    axes.contour(found.z, found.l, np.ma.masked_invalid(found.pinion_roll), levels=lines_at, **thin)
    rim = [np.concatenate((g[0], g[1:, -1], g[-1, -2::-1], g[-2::-1, 0])) for g in (found.z, found.l)]
    axes.plot(*rim, color=theme.GREY, linewidth=1.2)
    _path(axes, np.stack((panel.path.pinion_z, panel.path.l1), axis=-1))
    axes.set_xlabel("$z$ (mm)", labelpad=2.0)
    axes.set_ylabel("$l_1$ (mm)", labelpad=1.0)
    axes.yaxis.set_major_locator(MaxNLocator(6, integer=True))  # wider words reach into the next panel
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def _path(axes: Axes, points: FloatArray) -> None:
    """Draw a path (n, 2) from its dot to its arrow head."""
    points = points[np.isfinite(points).all(axis=1)]
    axes.plot(*points.T, color=theme.RED, linewidth=2.2, zorder=3.0)
    axes.plot(*points[:1].T, "o", color=theme.RED, markersize=6.0, zorder=3.0)
    arrow = {"arrowstyle": "-|>,head_width=0.3,head_length=0.6", "color": theme.RED, "linewidth": 2.2}
    way = tuple(points[-1]), tuple(points[-3])
    axes.annotate("", *way, arrowprops={**arrow, "shrinkA": 0.0, "shrinkB": 0.0}, zorder=3.0)


def _second_order_words(found: EaseOff) -> str:
    """Say the coefficients, um, in lines that have room under a panel."""
    own = {name: theme.signed(1e3 * value, 2) for name, value in vars(found.second_order).items()}
    return (
        "mean {mean}, twist {twist}\nslope {face_slope}, {profile_slope}\n"
        "crowning {face_crowning}, {profile_crowning}\nrest {rest}"
    ).format_map(own | {"rest": own["rest"].lstrip("+")})


def rows(data: tuple[Panel, ...]) -> Table:
    """List the points of the grids and of the paths, with the coefficients; a case without any in one row
    that says so."""
    names = ("mean", "face_slope", "profile_slope", "face_crowning", "profile_crowning", "twist", "rest")
    header = (
        *("flank", "parabola_pinion_per_mm", "parabola_gear_per_mm", "kind", "profile_place", "face_place"),
        *("l_mm", "z_mm", "pinion_roll_rad", "deviation_mm", *(f"{name}_mm" for name in names), "reason"),
    )

    def cases() -> Rows:
        """Give the columns of every grid and path."""
        for panel in data:
            case = panel.flank, *(float(member.tool.parabola) for member in panel.path.design.members)
            found = panel.found
            if found is None:
                yield *case, *[""] * (len(header) - 4), panel.reason
                continue
            profile, face = np.meshgrid(found.profile, found.face, indexing="ij")
            grid = (profile, face, found.l, found.z, found.pinion_roll, found.deviation)
            fit = [getattr(found.second_order, name) for name in names]
            yield *case, "grid", *(values.ravel() for values in grid), *fit, ""
            own = panel.path
            path = (*panel.places[::-1], own.l1, own.pinion_z, own.pinion_roll, panel.along)
            yield *case, "path", *path, *fit, ""

    return header, chain(stacked(cases()))


RECIPES = {"ease-off": Recipe(compute, draw, rows)}
