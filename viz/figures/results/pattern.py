"""Contact pattern over a mesh cycle, and separation of the flanks at one position."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.path import Path as Outline
from matplotlib.patheffects import AbstractPathEffect, withStroke

from beveloid_geom import Design, Status, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM, contact_ellipse
from beveloid_geom.contact.mesh_position import frames_at
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.gear.flank_limits import tip_parameter, tip_radius
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.operation.contact_pattern.pattern import ContactPattern
from beveloid_geom.report.pattern import pattern_report

from ...components import flattened_flank, panels, paths_table, viewpoint
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.flank_grid import LEFT_MARGIN_FRACTION, Cell, FlankArrangement, draw_grid, text_heights
from ...components.panels import Trace
from ...components.paths_table import SolvedPath
from ...components.viewpoint import FlankView
from ...rendering import theme
from ...rendering.scene import Item, Paint, Picture, divided

BLUES = ("#08306b", "#1f5fa6", "#4a98c9", "#8bbfdf", "#c3dbee")
HUES = ("#081d58", "#253d95", "#225ea8", "#1d91c0", "#41b6c4", "#7fcdbb", "#c7e9b4")
BARE = ("#eceff3", "#f3eee4")
"""Colours of pinion and gear beyond the last band: lighter than all bands, without lighting."""


@dataclass(frozen=True, eq=False)
class Layer:
    """Values (nl, nz), um, over the points and normals (nl, nz, 3) of a flank.

    Points are in the frame of the member, mm; `l` and `z` in mm. `trace` and `rings` are drawn on top,
    `under` is the text below, and `numbers` belong to the `measures` of the figure. `border` (2, nl, nz), if
    known: values continued beyond the mating flank, and distance from its border, mm, positive inside."""

    l: FloatArray
    z: FloatArray
    points: FloatArray
    normals: FloatArray
    values: FloatArray
    trace: Trace
    rings: tuple[FloatArray, ...]
    under: str
    numbers: tuple[float, ...]
    border: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class PatternColumn:
    """Layers of both members for one case and tooth pair, pinion first; None with a reason if there are
    none."""

    heading: str
    design: Design
    flank: str
    layers: tuple[Layer, Layer] | None
    reason: str = ""
    pair: int = 0


@dataclass(frozen=True, eq=False)
class BandFigure:
    """Columns of flanks coloured in bands of one quantity, um; `measures` are the names of the numbers of
    each flank."""

    title: str
    subtitle: str
    note: str
    quantity: str
    bands: tuple[float, ...]
    colours: tuple[str, ...]
    measures: tuple[str, ...]
    columns: tuple[PatternColumn, ...]


def compute_pattern(design: Design) -> BandFigure:
    """Compute the pattern of both flanks as designed, and of the right flank with the paper's
    modification."""
    pattern_bands = (0.0, 1.27, 2.54, 3.81, 5.08, 6.35)
    columns, bent = [], paths_table.paper_modified(design)
    for flank, changed, heading in (
        ("right", design, "right flanks, as designed"),
        ("right", bent, f"right flanks, {paths_table.coefficients(bent)}"),
        ("left", design, "left flanks, as designed"),
    ):
        try:
            pattern = pattern_report("", changed, flank, MARKING_SEPARATION_MM).result
        except ValueError as error:
            columns.append(PatternColumn(heading, changed, flank, None, str(getattr(error, "reason", error))))
            continue
        columns.append(PatternColumn(heading, changed, flank, _pattern_layers(changed, flank, pattern)))
    along_lines = [bool(is_line_contact(column.design, column.flank)) for column in columns]
    drawn = "contact ellipses of this pair"
    if any(along_lines):
        drawn = "some lines of contact" + ("" if all(along_lines) else f", or {drawn} (with parabolas)")
    return BandFigure(
        "Contact pattern under marking compound",
        f"Separation below {pattern_bands[-1]} \u00b5m during the mesh of a tooth pair; pinion (top), gear"
        " (bottom)",
        "The gear is at the first contact of all teeth, edges included. Thin, dashed: another tooth pair"
        f" or an edge touches earlier. Black: {drawn}.",
        "smallest separation over the cycle (\u00b5m)",
        pattern_bands,
        BLUES,
        ("area_mm2", "area_share"),
        tuple(columns),
    )


def _pattern_layers(design: Design, flank: str, pattern: ContactPattern) -> tuple[Layer, Layer]:
    """Return the pattern on pinion and gear with the path and its ellipses."""
    path = paths_table.solved_case(design, flank, touching=True)
    layers = []
    for number, side in enumerate((pattern.pinion, pattern.gear)):
        member, trace = design.members[number], Trace(path.points[number], first=path.first)
        normals = flank_patch(member, flank, side.l, z=side.z).normal
        digits = max(0, 2 - math.floor(math.log10(side.area))) if side.area > 0.0 else 0
        under = f"{100.0 * side.area_share:.0f}\u00a0% of the flank, {side.area:.{digits}f}\u00a0mm\u00b2"
        rings = _rings(design, path, number)
        numbers = float(side.area), float(side.area_share)
        values = 1e3 * side.least
        layers.append(Layer(side.l, side.z, side.points, normals, values, trace, rings, under, numbers))
    return layers[0], layers[1]


def _rings(design: Design, path: SolvedPath, number: int) -> tuple[FloatArray, ...]:
    """Return contact ellipses (n, 3) in the frame of a member, or lines of contact if flanks touch along
    lines. Ellipses are at positions where the pair is the first contact of all teeth."""
    # Points of a line of contact.
    line_points = 101
    # Number of contact ellipses along the part of the path where the pair is in contact.
    ellipses = 3
    if not path.has_path:
        return ()
    if len(lines := path.contact_lines(number)):
        share = np.linspace(0.0, 1.0, line_points)[:, None]
        return tuple(line[0] + share * (line[1] - line[0]) for line in lines)
    at, touching = path.path, np.flatnonzero(path.path.status == Status.SOLVED)
    if path.first is not None:
        touching = touching[path.first]
    if not touching.size:
        return ()
    shown = touching[np.linspace(0, len(touching) - 1, ellipses + 2).round().astype(int)[1:-1]]
    ellipse = contact_ellipse(at, MARKING_SEPARATION_MM)
    turn = np.linspace(0.0, 2.0 * np.pi, 721)[:, None]
    semi_axes, directions = ellipse.semi_axes[shown], ellipse.direction[shown]
    first, second = (semi_axes[:, k, None, None] * directions[:, k, None, :] for k in (0, 1))
    in_fixed = np.cos(turn) * first + np.sin(turn) * second  # (positions, 721, 3)
    rotation, _ = frames_at(design, at.pinion_roll[shown], at.gear_roll[shown])[number]
    rings = paths_table.points_on(at, number)[shown, None] + in_fixed @ rotation
    return tuple(ring for ring in rings if np.isfinite(ring).all())


def compute_separation(design: Design, flank: str = "right") -> BandFigure:
    """Compute the separation of three neighbouring tooth pairs at one position of a flank."""
    bands_um = (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
    # Tooth pairs computed. A pair is drawn if some of its separations are within the bands; all are drawn if
    # there is no such pair.
    pairs = (-1, 0, 1)
    # Position of the separation as a fraction of the path in roll, where two tooth pairs touch.
    position_fraction = 0.3
    path, under = paths_table.solved_case(design, flank), ""
    reason = first_contact_fault(design) or ("" if path.has_path else path.reason)
    layers: list[tuple[Layer, Layer] | None] = [None for _ in pairs]
    if not reason:
        roll = path.path.pinion_roll
        order = np.argsort(roll)
        l1 = np.interp(roll[0] + position_fraction * (roll[-1] - roll[0]), roll[order], path.path.l1[order])
        at = path_of_contact(design, flank, l1=[l1])
        pose = float(at.pinion_roll[0]), float(at.gear_roll[0])
        layers = [_separation_layers(path, pose, pair) for pair in pairs]
        rolls = (theme.signed(np.degrees(angle), 3) for angle in pose)
        under = ", pinion roll {}\u00b0, gear roll {}\u00b0".format(*rolls)
    near = [
        pair
        for pair, both in zip(pairs, layers, strict=True)
        if both and any(_in_bands(layer, bands_um[-1]) for layer in both)
    ]
    shown = [(pair, both) for pair, both in zip(pairs, layers, strict=True) if pair in (near or pairs)]
    return BandFigure(
        "Separation of the flanks at one position",
        f"{flank.capitalize()} flanks{under}; pinion (top) and gear (bottom)",
        "Tooth pairs with separations in these bands, along the normal of the other flank. Bare metal: larger"
        " than the last band, or outside the other flank. Orange: path of contact.",
        "separation (\u00b5m)",
        bands_um,
        HUES,
        ("pinion_roll_rad", "gear_roll_rad"),
        tuple(
            PatternColumn(
                f"tooth pair {theme.signed(pair, 0) if pair else 'in the middle'}",
                *(design, flank, both, reason, pair),
            )
            for pair, both in shown
        ),
    )


def _in_bands(layer: Layer, largest_um: float) -> bool:
    """Return True if the bands up to a separation cover a part of the flank that can be seen."""
    smallest_share = 0.01
    return bool(np.mean(layer.values < largest_um) > smallest_share)


def _separation_layers(path: SolvedPath, pose: tuple[float, float], pair: int) -> tuple[Layer, Layer]:
    """Return the separation of a tooth pair on pinion and gear at rolls (rad). The text below both flanks is
    that of the smallest distance on either of them."""
    # Distance of the nearest points drawn, um, below which flanks count as in contact.
    contact_distance_um = 0.01
    first, second = (_separation_layer(path, number, pose, pair) for number in (0, 1))
    values = np.concatenate((first.values.ravel(), second.values.ravel()))
    under = "out of reach"
    if np.isfinite(values).any():
        nearest = float(np.nanmin(values))
        near = f"{nearest:.3g} \u00b5m at the nearest point drawn"
        under = near if nearest > contact_distance_um else "in contact"
    return replace(first, under=under), replace(second, under=under)


def _separation_layer(path: SolvedPath, number: int, pose: tuple[float, float], pair: int) -> Layer:
    """Return the distance of the flank of pinion (0) or gear (1) from the other flank at rolls (rad)."""
    # Points along depth and face for a separation.
    separation_grid = (81, 161)
    design, flank = path.design, path.path.flank
    member = design.members[number]
    half = 0.5 * float(member.face_width)
    z = np.linspace(-half, half, separation_grid[1])
    low, high = active_start(member, flank, z), tip_parameter(member, flank, z)
    l = low + np.linspace(0.0, 1.0, separation_grid[0])[:, None] * (high - low)
    patch = flank_patch(member, flank, l, z=z)
    clearance = angular_clearance(design, flank, number, l, z, *pose, pair=pair)
    gap = 1e3 * np.where(clearance.inside, clearance.distance, np.nan)
    mate = design.members[1 - number]
    to_tip = tip_radius(mate, clearance.other_z) - clearance.other_r
    inside = np.minimum(0.5 * float(mate.face_width) - np.abs(clearance.other_z), to_tip)
    border = np.stack((1e3 * clearance.distance, inside))
    trace = Trace(path.points[number])
    return Layer(l, np.broadcast_to(z, l.shape), patch.point, patch.normal, gap, trace, (), "", pose, border)


def draw(data: BandFigure, layout: theme.PageLayout) -> Drawing:
    """Draw pinion flanks above gear flanks, one column for each case."""
    text_heights_in, bar_height_in = (0.4, 0.4), 0.9  # of pinion and gear flanks
    known = any(column.layers for column in data.columns)
    flanks = " and ".join(sorted({column.flank for column in data.columns}, reverse=True))
    stretch = 4.0 if layout.wide else 3.0  # magnification from root to tip
    # Width of paths relative to those of other figures, so that they hide less of the bands, and line width
    # of ellipses and lines of contact, points.
    path_width, ring_pt = (0.7, 1.3) if layout.wide else (1.0, 0.7)
    halo: list[AbstractPathEffect] = [withStroke(linewidth=2.0 * ring_pt, foreground="white")]
    note = panels.how_drawn(flanks, stretch, outside=True) + data.note if known else ""
    cases = [(column.heading, column.design, column.flank) for column in data.columns]
    grid = FlankArrangement(cases, text_heights(layout, len(cases), text_heights_in), stretch, outside=True)
    tall = grid.tall(layout) + bar_height_in
    title = data.title, data.subtitle, note
    page, low, high = theme.new_page(layout, *title, characters=viewpoint.NOTE_CHARACTERS, tall=tall)
    if known:
        _colour_bar(page, data, low)

    def panel(cell: Cell) -> Picture | None:
        """Draw one flank with its text."""
        column = data.columns[cell.case]
        if cell.view is None or column.layers is None:
            theme.message(theme.overlay(page, cell.box), column.reason or "no flank", 30)
            return None
        layer = column.layers[cell.member]
        items = _painted(data, layer, cell.view, BARE[cell.member])
        trace = replace(layer.trace, width=path_width)
        items += panels.path_items(page, [trace], cell.view, cell.px_per_mm)
        drawn = panels.show_items(page, cell.box, cell.view, items, cell.px_per_mm, cell.labels_at)
        rim = drawn.place(flattened_flank.boundary_of(layer.points))
        drawn.axes.plot(*rim.T, color=theme.GREY, linewidth=1.0)
        for ring in layer.rings:
            seen = drawn.place(ring)
            seen = np.where(Outline(rim).contains_points(seen)[:, None], seen, np.nan)
            drawn.axes.plot(*seen.T, color=theme.INK, linewidth=ring_pt, path_effects=halo)
        cell.say(page, layer.under)
        return drawn.picture

    return Drawing(page, draw_grid(page, grid, low + theme.inches(page, bar_height_in), high, panel))


def _painted(data: BandFigure, layer: Layer, view: FlankView, metal: str) -> list[Item]:
    """Return the flank in bands, and bare metal where values are missing.

    Values are counted in bands, so that bands may have different widths. An additional band of bare metal
    contains larger values."""
    # Distance from the border of the mating flank, mm, that is assumed (outside) for points without a
    # counterpart on that flank.
    no_point_mm = 0.1
    bands = np.array([*data.bands, 2.0 * data.bands[-1] - data.bands[-2]])

    def painted(values: FloatArray) -> Paint:
        """Return values as colours."""
        return Paint(
            np.interp(values, bands, np.arange(bands.size)).ravel(),
            (*data.colours, metal),
            (0.0, bands.size - 1.0),
        )

    flank = replace(panels.lit_flank(layer.points, layer.normals, view, metal), edges=False)
    bare = replace(flank, paint=painted(np.full(layer.values.shape, bands[-1])))
    if layer.border is None:
        known = np.isfinite(layer.values).ravel()[flank.faces].all(axis=1)
        parts = (~known, bare), (known, replace(flank, paint=painted(layer.values)))
        return [replace(part, faces=flank.faces[of]) for of, part in parts if of.any()]
    values, inside = layer.border
    level = np.where(np.isfinite(values + inside), inside, -no_point_mm).ravel()
    front, _ = divided(replace(flank, paint=painted(np.nan_to_num(values, nan=bands[-1]))), level)
    return [part for part in (front, divided(bare, level)[1]) if len(part.faces)]


def _colour_bar(page: theme.Page, data: BandFigure, low: float) -> None:
    """Draw the colour bar above `low`, a fraction of the page."""
    width = 0.45 if page.layout.wide else 0.85
    axes = page.add_axes(
        (LEFT_MARGIN_FRACTION, low + theme.inches(page, 0.5), width, theme.inches(page, 0.22))
    )
    colours = ListedColormap(list(data.colours))
    norm = BoundaryNorm(list(data.bands), colours.N)
    axes.imshow(np.arange(colours.N)[None], cmap=colours, aspect="auto", extent=(0, colours.N, 0, 1))
    axes.set_xticks(np.arange(norm.N), [f"{band:g}" for band in data.bands])
    axes.set_yticks([])
    axes.tick_params(length=3.0)
    axes.spines[:].set_visible(False)
    if width < 0.5:
        axes.text(1.02, 0.5, data.quantity, transform=axes.transAxes, va="center", fontsize=theme.LABEL)
    else:
        axes.set_title(data.quantity, loc="left", fontsize=theme.LABEL)


def rows(data: BandFigure) -> Table:
    """List the value at every point of every flank."""
    quantity = data.quantity.split(" (")[0].replace(" ", "_")

    def cases() -> Rows:
        """Yield the columns of every layer."""
        for column in data.columns:
            for name, layer in zip(paths_table.MEMBERS, column.layers or (), strict=False):
                values = (part.ravel() for part in (layer.l, layer.z, layer.values))
                who = *paths_table.parabolas(column.design, column.flank), column.pair, column.flank, name
                yield *who, *values, *layer.numbers

    header = *paths_table.PARABOLAS, "tooth_pair", "flank", "member", "l_mm", "z_mm", f"{quantity}_um"
    return (*header, *data.measures), rows_of_cases(cases())


RECIPES = {
    "pattern": Recipe(compute_pattern, draw, rows),
    "separation": Recipe(compute_separation, draw, rows),
}
