"""Fig. 2: normal section of the rack cutter, straight and with an exaggerated parabola."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from beveloid_geom import Design, Tool
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.fillet import ToolRound, tool_round

from ...components import annotate, cutter
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...rendering import theme


@dataclass(frozen=True, eq=False)
class RackFigure:
    """Straight and parabolic tool with their right profiles (n, 2).

    Profiles hold (x_n, y_n), mm, upwards from the middle of the tip of the tool. `tip_round`: round of the
    straight tool."""

    tools: tuple[Tool, Tool]
    profiles: tuple[FloatArray, FloatArray]
    tip_round: ToolRound

    @property
    def module(self) -> float:
        """Normal module, mm."""
        return float(self.tools[0].normal_module)

    @property
    def alpha(self) -> float:
        """Normal pressure angle, rad."""
        return float(self.tools[0].normal_pressure_angle)

    @property
    def space(self) -> float:
        """Width of the tooth space of the tool at the pitch line, mm."""
        return float(0.5 * np.pi * self.module)


def compute(design: Design) -> RackFigure:
    """Compute the profiles of the pinion's tool, straight and with the parabola that is drawn."""
    # Parabola coefficient drawn, times the normal module.
    parabola_times_module = 0.09
    tool = design.pinion.tool.straight()
    bent = cutter.fitting(replace(tool, parabola=parabola_times_module / float(tool.normal_module)))
    straight = cutter.fitting(tool)
    profiles = cutter.half_profile(straight), cutter.half_profile(bent)
    return RackFigure((straight, bent), profiles, tool_round(straight, "right"))


def draw(data: RackFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the section with its frames and dimensions in true proportions."""
    # Space for text next to the dimensions, inches.
    text_width_in = 0.9
    module, coefficient = data.module, float(data.tools[1].parabola)
    narrow = layout.printed and not layout.wide
    # Half the width of the tool drawn, in normal modules; on a narrow page with less text.
    wide = 1.75 if narrow else 2.08
    space, angle = f" = $\\pi m_n/2$ = {data.space:.5g} mm", f" = {np.degrees(data.alpha):g}\u00b0"
    page, low, high = theme.new_page(
        layout,
        "Fig. 2   Normal section of the rack cutter, straight and parabolic",
        f"Solid: parabola $y_a = a_j l_j^2$ with $a_j$ = {coefficient:.3g} mm$^{{\u22121}}$, exaggerated;"
        " dashed: straight flank, $a_j$ = 0" + (f"; $s_0${space}, $\\alpha_n${angle}" if narrow else ""),
        "$x_n$ points from root to tip of the gear tooth. $S_{ar}$ and $S_{al}$ are at the apexes of the"
        " right and left parabola, with $x_a$ along the straight flank."
        " $a_j$ > 0 leaves metal at tip and root, so that the flank is concave. The tip round of the"
        " parabolic tool is reduced to fit.",
        tall=0.62 * layout.width,
    )
    box = theme.place(page, 0.02, low, 0.96, high - low)
    axes = theme.overlay(page, box)
    tool = data.tools[0]
    back_modules = 0.4  # thickness of the back of the tool
    ends = module * np.array(
        [-float(tool.dedendum) - 0.35, cutter.SPACE_DEPTH_ADDENDA * float(tool.addendum) + back_modules]
    )
    free_share = 1.0 - 2.0 * text_width_in * page.dpi / box.width
    half = max(
        (wide + 0.62) * module,
        (wide + 0.22) * module / free_share,
        0.5 * (ends[1] - ends[0]) * box.width / box.height,
    )
    high_half = half * box.height / box.width
    axes.set(xlim=(-half, half), ylim=(ends.mean() - high_half, ends.mean() + high_half))
    _draw_tool(axes, data, wide, ends[1], narrow)
    _draw_lines(axes, data, wide, "" if narrow else space)
    _draw_frames(axes, data)
    _draw_parameters(axes, data, "" if narrow else angle)
    return Drawing(page, {})


def _draw_tool(axes: Axes, data: RackFigure, wide: float, back: float, narrow: bool) -> None:
    """Draw the tool up to its back, and the straight profile on top."""
    tool_colour = "#e3e9ee"
    straight, parabolic = (cutter.profile(half, data.module, 3) for half in data.profiles)
    outline = np.concatenate(([[parabolic[0, 0], back]], parabolic, [[parabolic[-1, 0], back]]))
    window = Rectangle((-wide * data.module, -1e3), 2.0 * wide * data.module, 2e3, transform=axes.transData)
    for drawn in (
        *axes.fill(*outline.T, color=tool_colour, zorder=0),
        *axes.plot(*parabolic.T, color=theme.INK, linewidth=3.0, zorder=2),
        *axes.plot(*straight.T, color=theme.VERMILLION, linewidth=2.0, dashes=(5, 3), zorder=3),
    ):
        drawn.set_clip_path(window)
    height = 1.28 if narrow else 0.75  # on a narrow page above the angle alpha_n
    for side in (-1.0, 1.0):
        place = side * (wide - 0.46) * data.module, height * data.module
        annotate.text(axes, place, "tool", fontsize=theme.HEADING)
    low = -float(data.tools[0].dedendum) * data.module
    if not narrow:
        annotate.text(
            axes, (0.0, 0.86 * low), "tooth space of the tool\n= tooth of the gear", color=theme.GREY
        )


def _draw_lines(axes: Axes, data: RackFigure, wide: float, space: str) -> None:
    """Draw pitch line, addendum and dedendum lines, width of the `space`, and tip round."""
    module, tool, tip = data.module, data.tools[0], data.tip_round
    heights = (float(tool.addendum) * module, 0.0, -float(tool.dedendum) * module)
    edge, words_at = (wide + 0.37) * module, (0.2 - wide - 0.4) * module
    for height, style in zip(heights, ((4, 4), (14, 3, 2, 3), (4, 4)), strict=True):
        axes.plot([-edge, edge], [height, height], color=theme.GREY, linewidth=1.2, dashes=style, zorder=1)
    annotate.text(axes, (words_at, 0.0), "pitch line", (0.0, 9.0), color=theme.GREY)
    at = (wide + 0.22) * module
    names = (f"{float(tool.addendum):g} $m_n$", f"{float(tool.dedendum):g} $m_n$")
    for height, name in zip((heights[0], heights[2]), names, strict=True):
        annotate.dimension(axes, (at, 0.0), (at, height), name, (42.0, 0.0), fontsize=theme.HEADING)
    annotate.text(axes, (words_at, heights[0]), "addendum", (0.0, 9.0), color=theme.GREY)
    annotate.text(axes, (words_at, heights[2]), "dedendum", (0.0, -13.0), color=theme.GREY)
    half, below = 0.25 * np.pi * module, -0.5 * module
    for side in (-half, half):
        axes.plot([side, side], [0.0, 1.15 * below], color=theme.BLUE, linewidth=1.0)
    blue: dict[str, Any] = {"color": theme.BLUE, "fontsize": theme.HEADING}
    annotate.dimension(axes, (-half, below), (half, below), f"$s_0${space}", (0.0, -14.0), **blue)
    if tip.radius > 0.0:
        centre = np.array([-tip.centre[1], tip.centre[0]])
        turn = np.radians(-62.0)  # direction to the mirror image of the round
        rim = centre + tip.radius * np.array([np.cos(turn), np.sin(turn)])
        axes.plot(*centre, "+", ms=9, color=theme.VERMILLION, mew=1.5, zorder=5)
        annotate.arrow(axes, centre, rim, theme.VERMILLION, 1.2)
        words = f"tip round {float(tool.tip_radius):g} $m_n$"
        annotate.text(axes, rim, words, (0.0, -22.0), color=theme.VERMILLION)


def _draw_frames(axes: Axes, data: RackFigure) -> None:
    """Draw S_n, S_ar and S_al; the page shows y_n to the right and x_n upwards."""
    module, half = data.module, 0.25 * np.pi * data.module
    sin, cos = np.sin(data.alpha), np.cos(data.alpha)
    for place, x, y, name, colour, length, shift in (
        (0.0, (0.0, 1.0), (1.0, 0.0), "n", theme.INK, 0.5, -15.0),
        (half, (-sin, cos), (cos, sin), "ar", theme.GREEN, 0.9, 24.0),
        (-half, (sin, cos), (-cos, sin), "al", theme.GREEN, 0.9, -24.0),
    ):
        style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING}
        for letter, direction in zip("xy", np.array((x, y)), strict=True):
            tip = (place, 0.0) + length * module * direction
            below = (-9.0, -13.0) if name == "n" and letter == "y" else (0.0, 0.0)  # off l_j
            annotate.arrow(axes, (place, 0.0), tip, colour, 2.2)
            # Between the flanks, x_a is written towards the middle.
            side = {"ha": "right" if place > 0.0 else "left"} if place and letter == "x" else {}
            words = f"${letter}_{{{name}}}$"
            annotate.text(axes, tip, words, tuple(13.0 * direction + below), **style, **side)
        axes.plot(place, 0.0, "o", ms=6, color=colour, zorder=5)
        annotate.text(axes, (place, 0.0), f"$S_{{{name}}}$", (shift, -13.0), fontweight="bold", **style)


def _draw_parameters(axes: Axes, data: RackFigure, angle: str) -> None:
    """Draw the pressure `angle` on the left flank, and l_j and the deviation of the parabola on the right
    flank."""
    # Flank parameter l at which the parabola is dimensioned, in normal modules.
    dimension_l_modules = 0.82
    parabola_colour = "#a0447c"
    module, half = data.module, 0.25 * np.pi * data.module
    sin, cos = np.sin(data.alpha), np.cos(data.alpha)
    axes.plot([-half, -half], [0.0, 0.8 * module], color=theme.BLUE, linewidth=1.0)
    turn = np.linspace(0.0, data.alpha, 21)
    arc = np.stack((-half + 0.66 * module * np.sin(turn), 0.66 * module * np.cos(turn)), axis=-1)
    axes.plot(*arc.T, color=theme.BLUE, linewidth=1.5, zorder=4)
    annotate.arrow(axes, arc[-3], arc[-1], theme.BLUE, 1.5)
    blue: dict[str, Any] = {"color": theme.BLUE, "fontsize": theme.HEADING}
    annotate.text(axes, arc[0], f"$\\alpha_n${angle}", (-38.0 if angle else -16.0, 6.0), **blue)
    l = dimension_l_modules * module
    apex, along, out = np.array([half, 0.0]), np.array([-sin, cos]), np.array([cos, sin])
    foot = apex + l * along
    point = foot + float(data.tools[1].parabola) * l * l * out
    shift = -0.16 * module * out
    for end in (apex, foot):
        axes.plot(*np.stack((end, end + 1.3 * shift)).T, color=parabola_colour, linewidth=1.0)
    style: dict[str, Any] = {"color": parabola_colour, "fontsize": theme.HEADING}
    annotate.dimension(axes, apex + shift, foot + shift, "$l_j$", (-12.0, -4.0), **style)
    axes.plot(*np.stack((foot, point)).T, color=parabola_colour, linewidth=2.5, zorder=4)
    axes.plot(*point, "o", ms=6, color=parabola_colour, zorder=5)
    label_at = point + 0.55 * module * out
    annotate.text(axes, label_at, "$a_j l_j^2$", (20.0, 6.0), **style)
    annotate.arrow(axes, label_at, point + 0.05 * module * out, parabola_colour, 1.2)


def rows(data: RackFigure) -> Table:
    """List the points of both right profiles, and their tools."""
    sizes = ("addendum", "dedendum", "tip_radius")
    of_tool = ("parabola_per_mm", "normal_module_mm", "normal_pressure_angle_rad", "space_mm")
    header = ("profile", *of_tool, *(f"{size}_modules" for size in sizes), "x_n_mm", "y_n_mm")

    def cases() -> Rows:
        """Yield the columns of each profile."""
        for name, tool, points in zip(("straight", "parabolic"), data.tools, data.profiles, strict=True):
            of_profile = [float(getattr(tool, size)) for size in sizes]
            yield name, float(tool.parabola), data.module, data.alpha, data.space, *of_profile, *points.T

    return header, rows_of_cases(cases())


RECIPES = {"fig-02": Recipe(compute, draw, rows)}
