"""Contact patterns under two errors: a matrix of the pinion flanks, right flanks above left flanks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, Polygon

from beveloid_geom import Design
from beveloid_geom.analysis.pattern_matrix import PatternCell, PatternMatrix, pattern_matrix
from beveloid_geom.analysis.tolerance import USUAL_AT
from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.ends import end_names
from beveloid_geom.design.model import ErrorsAt
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.pair.misalignment import NAMES
from beveloid_geom.report.columns import ARCSEC, header_of
from beveloid_geom.report.pattern import FIGURES, POINTS_PER_MODULE, flat_data, status_of

from ...components import paths_table, posed
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.flattened_flank import side_view
from ...components.paths_table import FLANKS, coefficients, paper_modified, parabolas
from ...rendering import theme


@dataclass(frozen=True, eq=False)
class Block:
    """The matrix of one flank, or the reason why there is none."""

    flank: str
    design: Design
    matrix: PatternMatrix | None
    reason: str = ""


def compute(design: Design) -> tuple[Block, ...]:
    """Compute patterns of both flanks with the parabolas of the design, or with the paper's if it has
    none."""
    design = design if design.has_parabola else paper_modified(design)
    right = _block(design, FLANKS[0], None)
    return right, _block(design, FLANKS[1], right.matrix)


def _block(design: Design, flank: str, like: PatternMatrix | None) -> Block:
    """Compute the matrix of a flank; `like` is that of the other flank, with the same backlash."""
    try:
        if fault := first_contact_fault(design):
            raise ValueError(fault)
        resolution = float(design.pinion.tool.normal_module) / POINTS_PER_MODULE  # as in the command pattern
        over, sizes = _errors(design)
        matrix = pattern_matrix(design, over, flank, sizes=sizes, resolution=resolution, like=like)
        return Block(flank, design, matrix)
    except ValueError as error:
        return Block(flank, design, None, str(getattr(error, "reason", error)))


def _at(design: Design) -> ErrorsAt:
    """Return where the errors are: at the mesh if the common perpendicular is far away, because small errors
    about it separate or jam the teeth."""
    return "mesh" if posed.placed(design, np.zeros(2)).remote else design.errors_at


def _errors(design: Design) -> tuple[tuple[str, str], tuple[float, float]]:
    """Return names and sizes (mm, rad) of the errors of distance and angle of the axes, in proportion to the
    module."""
    first, second, *_ = NAMES[_at(design)]
    usual = USUAL_AT[_at(design)]
    distance = paths_table.two_digits(getattr(usual, first) * paths_table.as_large(design))
    return (first, second), (distance, getattr(usual, second))


def draw(data: tuple[Block, ...], layout: theme.PageLayout) -> Drawing:
    """Draw a row for each distance error and a column for each angle error, right flanks first."""
    note = (
        "Pinion flank in r over z, {face:.4g} mm wide, {ends[0]} left, {ends[1]} right. Shaded: separation"
        " below a quarter, half and all of {film:g} \u00b5m. Orange: ellipse of the pattern's centre and"
        " second moments. {meant} TE: peak-to-peak transmission error; edges: share of edge contact"
    )
    # Part of the note that is left out on narrow pages.
    ellipse_note = "; below: centre and semi-axes (mm), angle to the axial direction"
    errors_note = {
        "perpendicular": "E: offset error, \u03a3: shaft-angle error.",
        "mesh": "E: centre-distance, \u03a3: in-plane shaft-angle error at the mesh.",
    }
    film = next((1e3 * block.matrix.separation for block in data if block.matrix), np.nan)
    count = max((block.matrix.first.size for block in data if block.matrix), default=1)
    row = 0.3 * _columns(layout, count)[1] + _under(layout)
    page, low, high = theme.new_page(
        layout,
        "Contact pattern under two errors",
        f"Right (top) and left flanks (bottom) of the pinion, {coefficients(data[0].design)}",
        note.format(
            film=film,
            face=float(data[0].design.pinion.face_width),
            ends=end_names(data[0].design.pinion),
            meant=errors_note[_at(data[0].design)],
        )
        + (ellipse_note if layout.wide else "")
        + ".",
        below=0.05,
        above=0.3,
        tall=len(data) * (count * row + 0.1),
    )
    halves, half = theme.split_rows(low, high, len(data), theme.inches(page, 0.1))
    limits = _face_limits([block.matrix for block in data if block.matrix])
    for block, bottom in zip(data, halves, strict=True):
        style: dict[str, Any] = {"rotation": 90, "va": "center", "fontsize": theme.HEADING}
        page.text(0.012, bottom + 0.5 * half, block.flank.capitalize(), **style)
        if block.matrix is None:
            box = theme.place(page, 0.05, bottom, 0.9, half)
            theme.message(theme.overlay(page, box), f"no pattern: {block.reason}", 60)
            continue
        _matrix(page, block.matrix, limits, bottom, half, high)
    return Drawing(page, {})


def _columns(layout: theme.PageLayout, count: int) -> tuple[float, float]:
    """Return the left end and the width of the columns of a matrix, inches."""
    left, right_margin = 1.44, 0.1
    return left, (layout.width - left - right_margin) / count


def _under(layout: theme.PageLayout) -> float:
    """Return the height of the two lines of text below a flank, inches."""
    return 0.44 if layout.wide else 0.52


def _matrix(
    page: theme.Page,
    matrix: PatternMatrix,
    limits: tuple[float, float],
    bottom: float,
    half: float,
    high: float,
) -> None:
    """Draw the cells of one flank, z between limits, in the height `half` above `bottom`, with the headings
    of the columns."""
    count, status = matrix.first.size, status_of(matrix)
    lines, height = theme.split_rows(bottom, bottom + half, count)
    under = theme.inches(page, _under(page.layout))
    start, width = (part / page.layout.width for part in _columns(page.layout, count))
    for k, (cell, added) in enumerate(zip(matrix.cells, matrix.added, strict=True)):
        row, column = divmod(k, count)
        left, cell_width = start + width * column, 0.96 * width
        axes = page.add_axes((left, lines[row] + under, cell_width, height - 1.05 * under))
        axes.set_axis_off()
        if row == 0 and bottom + half > high - 1e-9:
            words = f"\u03a3 {theme.signed(np.degrees(added[1]), 4)}\u00b0"
            axes.set_title(words, fontsize=theme.HEADING, pad=6.0)
        if column == 0:
            words = f"E (mm)\n{theme.signed(added[0], 2 + paths_table.digits_mm(matrix.design))}"
            at = left - 0.128 / page.layout.width, lines[row] + 0.5 * (height + under)
            page.text(*at, words, ha="right", va="center", fontsize=theme.LABEL)
        if cell is None:
            theme.message(axes, status[k].replace("_", " "))
            continue
        _cell(axes, cell, matrix.separation, limits)
        at = left + 0.5 * cell_width, lines[row] + 0.95 * under
        text = page.text(*at, "", ha="center", va="top", fontsize=theme.SMALL, linespacing=1.2)
        words = _words(matrix, k, cell, page.layout.wide)
        theme.wrap_text(text, words, cell_width * page.layout.width * page.dpi)


def _face_limits(matrices: Sequence[PatternMatrix]) -> tuple[float, float]:
    """Return the smallest and largest z, mm, of the flanks and ellipses of all matrices, with a margin."""
    ends: list[float] = []
    for cell in chain.from_iterable(matrix.cells for matrix in matrices):
        if cell is not None:
            one, z = cell.ellipses[0], _drawn(cell)[0]
            reach = float(np.hypot(one.major * np.cos(one.angle), one.minor * np.sin(one.angle)))
            ends += [float(z.min()), float(z.max()), *np.add(one.z, (-reach, reach)).tolist()]
    low, high = min(ends, default=0.0), max(ends, default=1.0)
    margin = 0.02 * (high - low)
    return low - margin, high + margin


def _cell(axes: Axes, cell: PatternCell, separation: float, limits: tuple[float, float]) -> None:
    """Draw pattern and ellipse over the pinion flank, z between limits and r."""
    one, (z, r, least) = cell.ellipses[0], _drawn(cell)
    boundary = side_view(axes, z, r, least, separation)
    shape = (one.z, one.r), 2.0 * one.major, 2.0 * one.minor
    for width, within in ((0.7, False), (2.0, True)):
        look: dict[str, Any] = {"fill": False, "edgecolor": theme.VERMILLION, "clip_on": within}
        ring = Ellipse(*shape, angle=np.degrees(one.angle), linewidth=width, **look)
        axes.add_patch(ring)
        if within:
            ring.set_clip_path(Polygon(boundary, transform=axes.transData))
    axes.plot(one.z, one.r, "+", color=theme.VERMILLION, markersize=9.0, markeredgewidth=1.6)
    axes.set_aspect("equal", anchor="N")
    margin = 0.03 * np.ptp(z)
    axes.set(xlim=limits, ylim=(r.min() - margin, r.max() + margin))


def _drawn(cell: PatternCell) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return z, r and smallest separation, mm, of the points of the pinion pattern that are drawn."""
    # About one of this number of grid points along profile and face is drawn.
    grid_step = 2
    side = cell.pattern.pinion
    every = np.ix_(*(np.linspace(0, n - 1, n // grid_step + 1).round().astype(int) for n in side.least.shape))
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    return side.z[every], r[every], side.least[every]


def _words(matrix: PatternMatrix, k: int, cell: PatternCell, wide: bool) -> str:
    """Return transmission error, edge contact and, on a wide page, the ellipse of a cell as text."""
    one = cell.ellipses[0]
    swing, edges = ARCSEC * matrix.cycle_peak_to_peak.flat[k], 100.0 * matrix.edge_share.flat[k]
    digits = paths_table.digits_mm(matrix.design)
    shape = f"z {theme.signed(one.z, digits)}, r {one.r:.{digits}f};"
    shape += f" {one.major:.{digits}f} \u00d7 {one.minor:.{digits}f},"
    shape += f" {theme.signed(np.degrees(one.angle), 1)}\u00b0"
    main = f"TE {swing:.2f}\u2033", f"edges {edges:.0f} %"
    return "\n".join((", ".join(main), shape) if wide else main)


def rows(data: tuple[Block, ...]) -> Table:
    """List the points of every pattern with the numbers of its cell; a cell without pattern has one row."""
    names = (
        *("normal_backlash_mm", "cycle_peak_to_peak_rad", "edge_share"),
        *("area_mm2", "area_share", "area_error"),
        *("ellipse_z_mm", "ellipse_r_mm", "major_mm", "minor_mm", "angle_rad"),
    )
    errors = [header_of(f"{name}_error") for name in _errors(data[0].design)[0]]
    header = (
        *("flank", "parabola_pinion_per_mm", "parabola_gear_per_mm", "marking_compound_mm"),
        *(*errors, "status", *names, "z_mm", "r_mm", "least_mm", "reason"),
    )

    def cases() -> Rows:
        """Yield the columns of every cell."""
        for block in data:
            matrix = block.matrix
            case: list[Any] = [block.flank, *parabolas(block.design, block.flank)]
            if matrix is None:
                yield *case, *[""] * (len(header) - len(case) - 1), block.reason
                continue
            for k, (cell, added) in enumerate(zip(matrix.cells, matrix.added.tolist(), strict=True)):
                figures = [float(getattr(matrix, name).flat[k]) for name in FIGURES]
                cell_values = [*case, matrix.separation, *added, status_of(matrix)[k], *figures]
                if cell is None:
                    yield *cell_values, *[""] * (len(header) - len(cell_values))
                    continue
                points = (values.ravel() for values in _drawn(cell))
                yield *cell_values, *flat_data(cell, 0).values(), *points, ""

    return header, chain(rows_of_cases(cases()))


RECIPES = {"pattern-errors": Recipe(compute, draw, rows)}
