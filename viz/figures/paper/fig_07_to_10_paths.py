"""Figs. 7 to 10: paths of contact for the four combinations of signs of the coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from beveloid_geom import Design
from beveloid_geom.arrays import Quantity

from ...components import panels, paths_table, viewpoint
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.flank_grid import Cell, FlankArrangement, draw_grid, text_heights
from ...components.panels import Trace
from ...components.paths_table import SolvedPath
from ...rendering import theme
from ...rendering.scene import Picture


def coefficient_texts(values: Sequence[float]) -> list[str]:
    """Return coefficients without exponent, as in the paper; all with the same power of ten if one of them
    has more than 5 decimals."""
    power = 0
    if any(abs(value - round(value, 5)) > 1e-9 * abs(value) for value in values):
        power = int(f"{max(map(abs, values)):.1e}".partition("e")[2])
    ten = f"\u00b710$^{{{power}}}$".replace("-", "\u2212") if power else ""
    texts = (theme.signed(value / 10.0**power, 5).rstrip("0").rstrip(".") for value in values)
    return [f"{text}{ten}" if value else "0" for text, value in zip(texts, values, strict=True)]


@dataclass(frozen=True)
class SignCase:
    """Signs of both coefficients and the greatest magnitude (1/mm) shown, at Table 1's module."""

    number: int
    pinion: float
    gear: float
    greatest: float
    title: str

    @property
    def coefficients(self) -> list[tuple[float, float]]:
        """Pairs of coefficients a1, a2 (1/mm), one for each column."""
        columns = 5
        sizes = [self.greatest * column / (columns - 1) for column in range(columns)]
        return [(self.pinion * size + 0.0, self.gear * size + 0.0) for size in sizes]

    def at(self, design: Design) -> SignCase:
        """Return the case at the module of a design."""
        return replace(self, greatest=paths_table.two_digits(self.greatest / paths_table.as_large(design)))

    def changed(self, design: Design, size: Quantity) -> Design:
        """Return a design with coefficients of the magnitude `size`, 1/mm, and the signs of this case."""
        return design.with_parabola(self.pinion * size + 0.0, self.gear * size + 0.0)


CASES = (
    SignCase(7, 1.0, 1.0, 0.0002, "Case 1: paths of contact, both coefficients positive"),
    SignCase(8, -1.0, -1.0, 0.0002, "Case 2: paths of contact, both coefficients negative"),
    SignCase(9, 1.0, -1.0, 0.002, "Case 3: paths of contact, pinion coefficient positive, gear negative"),
    SignCase(10, -1.0, 1.0, 0.002, "Case 4: paths of contact, pinion coefficient negative, gear positive"),
)


@dataclass(frozen=True, eq=False)
class PathFigure:
    """Paths of one flank for one sign case, one for each column."""

    case: SignCase
    flank: str
    paths: tuple[SolvedPath, ...]


def compute(case: SignCase, design: Design, flank: str = "right") -> PathFigure:
    """Compute the path of contact of every column."""
    case = case.at(design)
    designs = [design.with_parabola(a1, a2) for a1, a2 in case.coefficients]
    return PathFigure(
        case, flank, tuple(paths_table.solved_case(changed, flank, touching=True) for changed in designs)
    )


def draw(data: PathFigure, layout: theme.PageLayout) -> Drawing:
    """Draw a row of pinion flanks over a row of gear flanks, one column for each coefficient."""
    text_heights_in = 0.35, 0.85
    case, flank = data.case, data.flank
    sign = "" if case.pinion == case.gear else "\u2212"
    names = coefficient_texts([pinion for pinion, _ in case.coefficients])
    cases = [(f"$a_1$ = {name}", path.design, flank) for name, path in zip(names, data.paths, strict=True)]
    grid = FlankArrangement(cases, text_heights(layout, len(cases), text_heights_in))
    page, low, high = theme.new_page(
        layout,
        f"Fig. {case.number}   {case.title}",
        f"{flank.capitalize()} flanks of pinion (top) and gear (bottom), the pinion drives;"
        f" $a_2$ = {sign}$a_1$, mm$^{{\u22121}}$",
        panels.how_drawn(flank, grid.stretch)
        + "Below: length, angle to axial direction (in r over z); edges at path ends, if"
        " changed. " + panels.what_touches(data.paths) + panels.lines_drawn(data.paths),
        characters=viewpoint.NOTE_CHARACTERS,
        tall=grid.tall(layout),
    )
    theme.legend(page, panels.touching_legend(page, data.paths), 3, 0.8, handlelength=3.5)

    def panel(cell: Cell) -> Picture | None:
        """Draw one flank with its text."""
        path, row = data.paths[cell.case], cell.member
        traces = [Trace(path.points[row], first=path.first), *panels.edge_traces(path, row)]
        where = page, cell.box, path.design, row, cell.view
        drawn = panels.draw_flank(*where, traces, cell.px_per_mm, cell.labels_at)
        if drawn is None:
            return None
        panels.draw_lines(drawn, path, row)
        cell.say(page, _under(path, row, data.paths[0]))
        return drawn.picture

    return Drawing(page, draw_grid(page, grid, low, high, panel))


def _under(path: SolvedPath, row: int, zero: SolvedPath) -> str:
    """Return the text below a flank: length and angle of the path; for the gear also the ratios of the pair,
    and the ends if they differ from those of the path without modification."""
    if not path.has_path:
        return path.reason if row else "no path"
    digits = paths_table.digits_mm(path.design)
    words = f"{path.length(row):.{digits}f} mm, {theme.signed(path.angle(row), 1)}\u00b0"
    if row:
        words += "\nratio {}, all teeth {}".format(*panels.ratios(path))
        changed = path is zero or path.ends != zero.ends
        words += f"\n{path.ends_in_print}" if changed else ""
    return words


def rows(data: PathFigure) -> Table:
    """List every position of every path on both members."""
    return paths_table.table(("a1_per_mm", "a2_per_mm"), zip(data.case.coefficients, data.paths, strict=True))


RECIPES = {f"fig-{case.number:02d}": Recipe(partial(compute, case), draw, rows) for case in CASES}
