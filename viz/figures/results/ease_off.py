"""Ease-off of both flanks of the pinion before and after modification: wire surfaces and contour lines."""

from __future__ import annotations

import math
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
from beveloid_geom.design.ends import end_names
from beveloid_geom.findings.path import reason_of
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.flank_limits import tip_parameter

from ...components import annotate
from ...components.charts import ZERO_EASE_OFF_UM
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.map_panel import HALO, LEVEL, thin_out
from ...components.paths_table import FLANKS, coefficients, paper_modified, parabolas
from ...rendering import theme
from ...rendering.layout import PanelRows


@dataclass(frozen=True, eq=False)
class EaseOffPanel:
    """Ease-off of one flank in one case, and its values (n,), mm, along the path; or the reason why there is
    none."""

    flank: str
    case: str
    result: EaseOff | None
    path: ContactPath
    along: FloatArray
    reason: str = ""

    @property
    def places(self) -> tuple[FloatArray, FloatArray]:
        """Positions (n,) of the path along face and profile, from -1 to 1."""
        member = self.path.design.pinion
        z = self.path.pinion_z
        root, tip = active_start(member, self.flank, z), tip_parameter(member, self.flank, z)
        return 2.0 * z / float(member.face_width), 2.0 * (self.path.l1 - root) / (tip - root) - 1.0


def compute(design: Design) -> tuple[EaseOffPanel, ...]:
    """Compute the ease-off of both flanks, unmodified and as designed. If the design has no parabolas and no
    modifications, the second case has the parabolas of the paper."""
    plain = design.unmodified()
    after = design if plain != design else paper_modified(design)
    only_parabolas = after.without_modifications() == after
    cases = ("unmodified", plain), (coefficients(after) if only_parabolas else "as designed", after)
    return tuple(_panel(flank, case, one) for flank in FLANKS for case, one in cases)


def _panel(flank: str, case: str, design: Design) -> EaseOffPanel:
    path_points, grid_shape = 41, (29, 41)  # points along profile and face
    path = path_of_contact(design, flank, path_points)
    try:
        if reason := reason_of(path):
            raise ValueError(reason)
        along = ease_off_at(design, flank, path.l1, path.pinion_z)
        return EaseOffPanel(flank, case, ease_off(design, flank, grid_shape), path, along)
    except ValueError as error:
        return EaseOffPanel(flank, case, None, path, np.zeros(0), str(error))


def draw(data: tuple[EaseOffPanel, ...], layout: theme.PageLayout) -> Drawing:
    """Draw a column for each flank and case: wire surface above, contour lines below."""
    cells = PanelRows(left=0.72, right=0.464, across=0.672, down=2.3, most=4, least=1.6)
    if layout.printed:
        cells = replace(cells, left=0.85, across=0.85)
    page, low, high = theme.new_page(
        layout,
        "Ease-off of the pinion",
        "Right (drive) and left (coast) flanks: distance from flanks conjugate to the gear, \u00b5m",
        (
            "Deviation of the pinion flank from the conjugate of the gear flank along the normal, zero at"
            " mid-roll of the path; positive (up) where the flanks separate. Orange: path of contact."
            " Dash-dotted: lines of contact of conjugate flanks. Below: coefficients of the second-order"
            " surface (slope, crowning: face, profile), and root mean square of the residual."
        ),
        below=1.75,
        above=0.6,
        tall=cells.tall(layout, len(data), 4.6),
    )
    for column, (panel, box) in enumerate(
        zip(data, theme.panels(page, cells, len(data), low, high), strict=True)
    ):
        surface, levels = _axes(box)
        surface.set_axis_off()
        surface.set_title(f"({'abcd'[column]})  {panel.flank.capitalize()} flanks\n{panel.case}", loc="left")
        if panel.result is None:
            theme.message(surface, f"no ease-off: {panel.reason}", 30)
            levels.set_axis_off()
            continue
        same = [one.result.deviation for one in data if one.flank == panel.flank and one.result is not None]
        span = 1e3 * np.array((np.nanmin(same), np.nanmax(same)))
        _wires(surface, panel, panel.result, span, layout.printed)
        _levels(levels, panel, panel.result)
        words = _second_order_words(panel.result)
        style: dict[str, Any] = {"xycoords": "axes fraction", "va": "top", "fontsize": theme.SMALL}
        theme.label_point(levels, (0.0, 0.0), words, (0.0, -42.0), **style)
    return Drawing(page, {})


def _axes(box: Axes) -> tuple[Axes, Axes]:
    """Replace a panel by axes for a wire surface and, below, axes for contour lines."""
    page, at = cast("theme.Page", box.figure), box.get_position()
    box.remove()
    (upper, lower), height = theme.split_rows(at.y0, at.y1, 2, theme.inches(page, 0.35))
    left, wider = 0.32 / page.layout.width, 0.56 / page.layout.width  # inches for labels at the corners
    surface = page.add_axes((at.x0 - left, upper, at.width + wider, height))
    return surface, page.add_axes((at.x0, lower, at.width, 0.92 * height))


def _wires(axes: Axes, panel: EaseOffPanel, result: EaseOff, span: FloatArray, printed: bool) -> None:
    """Draw the surface as wires over the plane of zero, tip behind, without hidden lines.

    The full height of the surface corresponds to the `span` (2,), um: minimum and maximum, extended to
    contain zero."""
    # Lengths in half face widths: displacement of the tip to the right of the root and above it, and
    # height of the surface.
    tip_shift, tip_height, surface_height = 0.42, 0.46, 1.25
    # Spacing of the wires in points of the grid.
    wire_spacing = 2
    # Position of the scale bar, to the right and up, between the labels at +z, in half face widths.
    bar_position = 1.8, -0.05
    lowest, greatest = min(float(span[0]), 0.0), max(float(span[1]), 0.0)
    scale = surface_height / (greatest - lowest) if greatest - lowest > ZERO_EASE_OFF_UM else 0.0

    def seen(face: FloatArray, profile: FloatArray, height: FloatArray) -> FloatArray:
        return np.stack((face + tip_shift * profile, tip_height * profile + scale * height), axis=-1)

    face, profile = np.meshgrid(result.face[::wire_spacing], result.profile[::wire_spacing])
    grid = seen(face, profile, 1e3 * result.deviation[::wire_spacing, ::wire_spacing])
    plane = seen(np.array([-1.0, 1.0, 1.0, -1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0, -1.0]), np.zeros(5))
    axes.plot(*plane.T, color=theme.GREY, linewidth=1.2, zorder=0.5)
    quads = np.stack((grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]), axis=2)[::-1]
    quads = quads.reshape(-1, 4, 2)
    shown = PolyCollection(list(quads[np.isfinite(quads).all(axis=(1, 2))]))
    shown.set(facecolor="white", edgecolor=theme.BLUE, linewidth=0.9, alpha=0.9, zorder=1.0)
    axes.add_collection(shown)
    _path(axes, seen(*panel.places, 1e3 * panel.along))
    names = dict(zip(("toe", "heel"), end_names(result.design.pinion), strict=True))
    for depth, (i, p) in {"root": (0, -1.0), "tip": (-1, 1.0)}.items():
        for end, (j, f) in {"toe": (0, -1.0), "heel": (-1, 1.0)}.items():
            height = np.array((0.0, 1e3 * result.deviation[i, j]))
            foot, top = seen(np.full(2, f), np.full(2, p), height)
            axes.plot(*np.array((foot, top)).T, color=theme.GREY, linewidth=1.0, linestyle=":", zorder=0.6)
            value = theme.signed(1e3 * result.corners[f"{depth}_{end}"], 1 if greatest > 1.0 else 2)
            at = top if p > 0.0 and np.isfinite(top).all() else foot
            place = {"ha": "left" if f > 0.0 else "right", "va": "bottom" if p > 0.0 else "top"}
            words = f"{depth}, {names[end]}\n{value if np.isfinite(top).all() else 'none'}"
            text = theme.label_point(
                axes, at, words, (2.0 * f, 5.0 * p), fontsize=theme.SMALL, zorder=5.0, **place
            )
            text.set_path_effects(HALO)
    floor = scale * lowest - tip_height - 0.4
    if greatest - lowest > ZERO_EASE_OFF_UM:
        length = theme.round_length(max(0.5 * (greatest - lowest), ZERO_EASE_OFF_UM))
        right, foot = bar_position
        axes.plot([right, right], [foot, foot + scale * length], color=theme.INK, linewidth=3.0)
        unit, style = f"{length:g} \u00b5m", {"fontsize": theme.SMALL}
        theme.label_point(axes, (right, foot), unit, (0.0, -4.0), ha="center", va="top", **style)
    across, over = ((-2.35, 2.55), 1.4) if printed else ((-2.1, 2.15), 0.9)  # space for labels
    axes.set(xlim=across, ylim=(floor - 0.25, floor + 2.0 * tip_height + surface_height + over))


def _levels(axes: Axes, panel: EaseOffPanel, result: EaseOff) -> None:
    """Draw contour lines over the flank (z, l) with the path."""
    # Number of lines of contact, at equal steps of the roll of the path.
    contact_lines = 3
    # Contour lines have no label beyond this fraction of half the axes.
    label_limit_fraction = 0.9
    values = np.ma.masked_invalid(1e3 * result.deviation)
    if float(np.abs(values).max()) < ZERO_EASE_OFF_UM:
        corner: dict[str, Any] = {"ha": "right", "va": "bottom", "transform": axes.transAxes}
        axes.text(0.98, 0.04, "zero within\nrounding", fontsize=theme.SMALL, **corner)
        values[:] = 0.0
    levels = MaxNLocator(9, steps=[1, 2, 5, 10]).tick_values(float(values.min()), float(values.max()))
    styles: dict[str, Any] = {"colors": theme.BLUE, "linewidths": 1.2, "negative_linestyles": "dashed"}
    lines = axes.contour(result.z, result.l, values, levels=levels, **styles)
    for label in axes.clabel(lines, fontsize=theme.SMALL, inline=False, colors=theme.INK):
        label.set_text(label.get_text().replace("-", "\u2212"))
        label.set_path_effects(HALO)
        label.set_gid(LEVEL)
        place = axes.transAxes.inverted().transform(axes.transData.transform(label.get_position()))
        if np.abs(2.0 * place - 1.0).max() > label_limit_fraction:
            label.remove()  # cut off
    thin_out(axes)
    roll = panel.path.pinion_roll
    lines_at = np.sort(np.linspace(roll[0], roll[-1], contact_lines + 2)[1:-1])
    thin: dict[str, Any] = {"colors": theme.GREY, "linewidths": 1.0, "linestyles": "dashdot"}
    axes.contour(result.z, result.l, np.ma.masked_invalid(result.pinion_roll), levels=lines_at, **thin)
    rim = [np.concatenate((g[0], g[1:, -1], g[-1, -2::-1], g[-2::-1, 0])) for g in (result.z, result.l)]
    axes.plot(*rim, color=theme.GREY, linewidth=1.2)
    _path(axes, np.stack((panel.path.pinion_z, panel.path.l1), axis=-1))
    axes.set_xlabel("$z$ (mm)", labelpad=2.0)
    # Above the tick labels, because there is no space next to them at small modules.
    theme.label_point(axes, (0.0, 1.0), "$l_1$ (mm)", (-4.0, 8.0), ha="center", xycoords="axes fraction")
    axes.yaxis.set_major_locator(MaxNLocator(6, integer=True, steps=[1, 2, 5, 10]))
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def _path(axes: Axes, points: FloatArray) -> None:
    """Draw a path (n, 2) from its dot to its arrow head."""
    points = points[np.isfinite(points).all(axis=1)]
    axes.plot(*points.T, color=theme.VERMILLION, linewidth=2.2, zorder=3.0, path_effects=annotate.rim(2.2))
    axes.plot(*points[:1].T, "o", color=theme.VERMILLION, markersize=6.0, zorder=3.0)
    arrow = {**annotate.PATH_ARROW, "color": theme.VERMILLION, "linewidth": 2.2}
    arrow["path_effects"] = annotate.rim(2.2)
    axes.annotate("", tuple(points[-1]), tuple(points[-3]), arrowprops=arrow, zorder=3.0)


def _second_order_words(result: EaseOff) -> str:
    """Return the coefficients of the second-order surface, um, in lines that fit below a panel."""
    values = {name: 1e3 * value for name, value in vars(result.second_order).items()}
    # Two decimals; more if the largest coefficient has fewer than three digits with them.
    largest = max(map(abs, values.values()))
    digits = max(2, 2 - math.floor(math.log10(largest))) if largest > ZERO_EASE_OFF_UM else 2
    coefficients_um = {name: theme.signed(value, digits) for name, value in values.items()}
    return (
        "mean {mean}, twist {twist}\nslope {face_slope}, {profile_slope}\n"
        "crowning {face_crowning}, {profile_crowning}\nresidual {rest}"
    ).format_map(coefficients_um | {"rest": coefficients_um["rest"].lstrip("+")})


def rows(data: tuple[EaseOffPanel, ...]) -> Table:
    """List the points of grids and paths with the coefficients; a case without ease-off has one row with the
    reason."""
    names = ("mean", "face_slope", "profile_slope", "face_crowning", "profile_crowning", "twist", "rest")
    header = (
        *("flank", "parabola_pinion_per_mm", "parabola_gear_per_mm", "kind", "profile_place", "face_place"),
        *("l_mm", "z_mm", "pinion_roll_rad", "deviation_mm", *(f"{name}_mm" for name in names), "reason"),
    )

    def cases() -> Rows:
        """Yield the columns of every grid and path."""
        for panel in data:
            case = panel.flank, *parabolas(panel.path.design, panel.flank)
            result = panel.result
            if result is None:
                yield *case, *[""] * (len(header) - 4), panel.reason
                continue
            profile, face = np.meshgrid(result.profile, result.face, indexing="ij")
            grid = (profile, face, result.l, result.z, result.pinion_roll, result.deviation)
            fit = [getattr(result.second_order, name) for name in names]
            yield *case, "grid", *(values.ravel() for values in grid), *fit, ""
            solved = panel.path
            path = (*panel.places[::-1], solved.l1, solved.pinion_z, solved.pinion_roll, panel.along)
            yield *case, "path", *path, *fit, ""

    return header, chain(rows_of_cases(cases()))


RECIPES = {"ease-off": Recipe(compute, draw, rows)}
