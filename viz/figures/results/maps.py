"""Maps of a design over its parabola coefficients and its mounting distances."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beveloid_geom import Design, map_of
from beveloid_geom.analysis.maps import FIGURES, QUADRANTS, DesignMap, Over, own_values
from beveloid_geom.report.map import map_rows, quadrant_bests, ratio_as_given
from beveloid_geom.report.result import table_of
from beveloid_geom.report.words import error_words

from ...parts import solved
from ...parts.map_panel import ASTRAY, HOLLOW, LOOKS, LOST, NARROW, UNKNOWN, panel, statuses, thin_out
from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.layout import Cells
from ..paper.fig_07_to_10_paths import CASES, coefficient_text

STEPS, STEPS_IN_OPERATION = 33, 21
"""Values of a member; of a map with what all teeth do in operation, which takes longest."""
CELLS = Cells(left=1.06, right=1.0, across=1.06, down=0.65, most=3, least=1.0)
BAR = 0.096, 0.144
"""Inches between a map and its bar of colours, and width of the bar."""
COLUMNS_OF_TEXT = 172
ROW_OF_TEXT = 125
"""Characters that the entries of a legend may have in one row."""
DOT: dict[str, Any] = {"ls": "", "marker": "o", "ms": 8.0, "mfc": "white", "mec": theme.INK}
"""How the design is marked."""
DEFINED = (
    "Angle: to the axial direction, of the chord in the pinion's side view (z, r), positive if z rises with"
    " r; \u00b190\u00b0 are one. Shift: of the path, at mid-roll on the pinion's flank, square to the path,"
    " under {errors}, each alone and both ways (root of the sum of squares). Transmission error: peak to"
    " peak, of one tooth pair over its path. Middle: of the path, positive to the heel. Colours cover what is"
    " not hatched; lines at negative levels are dashed, those at zero thick. "
)


class Words(NamedTuple):
    """What a map is called, what stands along its axes for pinion and gear, and what is to be known of it."""

    title: str
    pinion: str
    gear: str
    note: str


WORDS = {
    "parabola": Words(
        "Map over the parabola coefficients",
        "$a_1$, pinion (10$^{\u22123}$/mm)",
        "$a_2$, gear (10$^{\u22123}$/mm)",
        "Where a1 + a2 > 0 the flanks are hollow against each other: edges take over, and the path"
        " mapped there is not where a pair runs; (f) is the share of a mesh cycle that edges carry. ",
    ),
    "mounting": Words(
        "Map over the mounting distances",
        "pinion to its heel (mm)",
        "gear to its heel (mm)",
        "Both members are moved along their axes: lines of action stay, flanks move under them. ",
    ),
}


@dataclass(frozen=True, eq=False)
class MapFigure:
    """A map, and whether the design was modified for it."""

    found: DesignMap
    modified: bool

    @property
    def panels(self) -> list[str]:
        """What is mapped in each panel."""
        last = "edge_share" if self.found.over == "parabola" else "normal_backlash"
        return [*(name for name in FIGURES if "backlash" not in name), last]


def compute(over: Over, design: Design, flank: str = "right") -> MapFigure:
    """Find the map; of mounting distances with the paper's modification where the design has no parabolas, as
    without them neither transmission error nor shift would depend on anything."""
    if over == "parabola":
        return MapFigure(map_of(design, over, flank, steps=STEPS_IN_OPERATION, operation=True), False)
    modified = not any(float(member.tool.parabola) for member in design.members)
    if modified:
        design = solved.modified(design)
    return MapFigure(map_of(design, over, flank, steps=STEPS), modified)


def draw(data: MapFigure, layout: theme.Layout) -> Drawing:
    """Draw six maps of one design."""
    found, words = data.found, WORDS[data.found.over]
    sizes = error_words(found.errors).replace("+", "\u00b1")
    note = DEFINED.format(errors=sizes + solved.at_the_mesh(found.design))
    note += words.note + finding(found)
    count, columns = len(data.panels), CELLS.columns(layout, len(data.panels))
    cells = replace(CELLS, down=0.8) if layout.printed else CELLS
    tall = cells.tall(layout, count, min(1.15 * cells.width(layout, count), 2.3))
    title = words.title, _subtitle(data), note
    page, low, high = theme.new_page(layout, *title, 1.25, 0.4, COLUMNS_OF_TEXT, tall)
    for index, (name, axes) in enumerate(
        zip(data.panels, theme.panels(page, cells, count, low, high), strict=True)
    ):
        box = axes.get_position()
        gap, width = (length / layout.width for length in BAR)
        bar = page.add_axes((box.x1 + gap, box.y0, width, box.height))
        heading = f"({'abcdef'[index]})  {LOOKS[name].heading}"
        axes.set_title(heading, loc="left", pad=8.0, fontsize=theme.SMALL if layout.printed else theme.LABEL)
        panel(axes, bar, name, found)
        lowest, first = index >= count - columns, index % columns == 0
        axes.set(xlabel=words.pinion if lowest else "", ylabel=words.gear if first else "")
        axes.tick_params(labelbottom=lowest, labelleft=first)
        if found.over == "parabola":
            _cases(axes, found, named=index == 0 and cells.width(layout, count) > NARROW)
        axes.plot(*own_values(found.design, found.over), **DOT, zorder=6.0)
        thin_out(axes)
    _legend(page, data, low - theme.inches(page, 0.95))
    return Drawing(page, {})


def _subtitle(data: MapFigure) -> str:
    text = f"{data.found.flank.capitalize()} flanks, as mounted"
    if data.modified:
        text += f", with {solved.modification(data.found.design)} {solved.coefficients(data.found.design)}"
    return text


def finding(found: DesignMap) -> str:
    """Say what the map says of the paper's cases."""
    if found.over != "parabola" or not found.sound.any():
        return ""
    ratio = ratio_as_given(found.design, found.flank)
    bests = quadrant_bests(found, ratio) if ratio > 0.0 else {}
    words = [f"{best[1]:.2f} mm in {name}" for name, best in bests.items() if not math.isnan(best[1])]
    text = f"With a contact ratio of at least {ratio:.3f}, that of the design as given, the least shift is "
    text = f"{text}{', '.join(words)}. " if words else ""
    ratios = np.where(found.sound, found.contact_ratio, np.nan)
    i, j = np.unravel_index(np.nanargmax(ratios), ratios.shape)
    at = [coefficient_text(float(value)) for value in (found.pinion[i], found.gear[j])]
    where = f"a1 = {at[0]}, a2 = {at[1]} 1/mm"
    return f"{text}The greatest contact ratio is {ratios[i, j]:.2f} at {where}."


def _cases(axes: Axes, found: DesignMap, named: bool) -> None:
    """Draw quadrants, the recommended one in a frame, and the lines of the paper's figures."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for case, (name, (pinion, gear)) in zip(CASES, sorted(QUADRANTS.items()), strict=True):
        reach = min(right if pinion > 0 else -left, high if gear > 0 else -low)
        if reach <= 0.0:
            continue
        size = min(case.at(found.design).greatest, reach)
        for colour, width in (("white", 4.5), (theme.INK, 2.2)):
            axes.plot([0.0, pinion * size], [0.0, gear * size], color=colour, linewidth=width, zorder=3.0)
        text = f"{name} (Fig.\u00a0{case.number})" if named else name
        x, ha = (0.97, "right") if pinion > 0 else (0.03, "left")
        y, va = (0.97, "top") if gear > 0 else (0.03, "bottom")
        style: dict[str, Any] = {"fontsize": theme.SMALL, "fontweight": "bold" if name == "C3" else "normal"}
        style["bbox"] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
        axes.text(x, y, text, transform=axes.transAxes, ha=ha, va=va, zorder=7.0, **style)
    if right > 0.0 > low:
        x, y = max(left, 0.0), min(high, 0.0)
        for colour, width in (("white", 4.5), (theme.RED, 2.5)):
            corners = [x, right, right, x, x], [low, low, y, y, low]
            axes.plot(*corners, color=colour, linewidth=width, clip_on=False, zorder=4.0)


def _legend(page: theme.Page, data: MapFigure, height: float) -> None:
    """Name marks and hatches, those that are there, at a height of the page."""
    found = data.found
    unknown = found.solved & np.isnan(found.edge_share) & (found.over == "parabola")
    entries: list[Artist] = [Line2D([], [], **DOT, label="the design")]
    if found.over == "parabola":
        frame: dict[str, Any] = {"facecolor": "none", "edgecolor": theme.RED, "linewidth": 2.5}
        entries.append(Patch(**frame, label="C3, which the paper recommends"))
        line: dict[str, Any] = {"color": theme.INK, "linewidth": 2.2}
        entries.append(Line2D([], [], **line, label="coefficients of the paper's Figs. 7 to 10"))
    hatched = (
        (~found.solved, LOST, f"no path: {statuses(found)}"),
        (found.solved & np.isnan(found.shift), ASTRAY, "an error carries the path off the flanks"),
        (unknown, UNKNOWN, "not known what touches first"),
        (found.hollow, HOLLOW, "hollow against each other"),
        (found.interferes, HOLLOW, "backlash negative: other flanks interfere"),
    )
    for cells, pattern, text in hatched:
        if cells.any():
            face = theme.PALE if pattern == HOLLOW else "white"
            look: dict[str, Any] = {"facecolor": face, "edgecolor": theme.GREY, "hatch": pattern}
            entries.append(Patch(**look, linewidth=0.5, label=text))
    written = sum(len(str(entry.get_label())) for entry in entries)
    columns = min(len(entries), 5 if written < ROW_OF_TEXT else 4)
    style: dict[str, Any] = {"fontsize": theme.SMALL, "handlelength": 2.4, "columnspacing": 1.8}
    theme.legend(page, entries, columns, loc="center", bbox_to_anchor=(0.5, height), **style)


def rows(data: MapFigure) -> Table:
    """List every cell of the map."""
    header, columns = table_of(map_rows(data.found))
    return header, list(zip(*columns, strict=True))


RECIPES = {f"map-{over}": Recipe(partial(compute, over), draw, rows) for over in ("parabola", "mounting")}
