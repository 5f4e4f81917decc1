"""Figs. 7 to 10: paths of contact for the four combinations of signs of the coefficients."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

from beveloid_geom import Design

from ...parts import panels, solved, viewpoint
from ...parts.panels import Cell, Trace
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import SolvedPath
from ...stage import theme
from ...stage.scene import Picture

COLUMNS = 5
TEXT = 0.35, 0.85  # inches: a line under a pinion's flank, three under a gear's
ANGLES = (
    "Under a flank stand length and angle of the path in the side view, z along the axis against the radius:"
    " the angle that of the chord to the axial direction, positive if z rises with the radius."
    f" {panels.WHAT_TOUCHES.format(edges='solid blue lines')}"
)


def coefficient_text(value: float) -> str:
    """Give a coefficient without exponent, as in the paper."""
    return theme.signed(value, 6).rstrip("0").rstrip(".") if value else "0"


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
        sizes = [self.greatest * column / (COLUMNS - 1) for column in range(COLUMNS)]
        return [(self.pinion * size + 0.0, self.gear * size + 0.0) for size in sizes]

    def at(self, design: Design) -> SignCase:
        """Give the case at the module of a design."""
        return replace(self, greatest=solved.two_digits(self.greatest / solved.as_large(design)))

    def heading(self, column: int) -> str:
        """Give the pinion's coefficient of a column."""
        return f"$a_1$ = {coefficient_text(self.coefficients[column][0])}"


CASES = (
    SignCase(7, 1.0, 1.0, 0.0002, "Paths of contact: both coefficients positive"),
    SignCase(8, -1.0, -1.0, 0.0002, "Paths of contact: both coefficients negative"),
    SignCase(9, 1.0, -1.0, 0.002, "Paths of contact: pinion coefficient positive, gear negative"),
    SignCase(10, -1.0, 1.0, 0.002, "Paths of contact: pinion coefficient negative, gear positive"),
)


@dataclass(frozen=True, eq=False)
class PathFigure:
    """The paths of one sign case, a column each, of one flank."""

    case: SignCase
    flank: str
    paths: tuple[SolvedPath, ...]


def compute(case: SignCase, design: Design, flank: str = "right") -> PathFigure:
    """Solve the path of contact for every column."""
    case = case.at(design)
    designs = [design.with_parabola(a1, a2) for a1, a2 in case.coefficients]
    return PathFigure(case, flank, tuple(solved.solve(changed, flank, touching=True) for changed in designs))


def draw(data: PathFigure, layout: theme.Layout) -> Drawing:
    """Draw a row of pinion flanks over a row of gear flanks, one column for each coefficient."""
    case, flank = data.case, data.flank
    sign = "" if case.pinion == case.gear else "\u2212"
    text = panels.texts(layout, COLUMNS, TEXT)
    page, low, high = theme.new_page(
        layout,
        f"Fig. {case.number}   {case.title}",
        f"{flank.capitalize()} flanks of pinion (top) and gear (bottom), the pinion drives;"
        f" parabola coefficients $a_1$ of the pinion, $a_2$ = {sign}$a_1$ of the gear, mm$^{{\u22121}}$",
        f"{panels.how_drawn(flank, panels.STRETCH)}{ANGLES}{panels.lines_drawn(data.paths)}",
        columns=viewpoint.COLUMNS,
        tall=panels.flanks_tall(layout, COLUMNS, text),
    )

    def panel(cell: Cell) -> Picture | None:
        """Draw one flank, with words under it."""
        path, row = data.paths[cell.column], cell.row
        traces = [Trace(path.points[row], first=path.first), *panels.edge_traces(path, row)]
        where = page, cell.box, path.design, row, flank, cell.view
        drawn = panels.draw_flank(*where, traces, cell.px_per_mm, cell.limits)
        if drawn is None:
            return None
        panels.draw_lines(drawn, path, row)
        cell.say(page, _under(path, row))
        return drawn.picture

    columns = [(case.heading(k), path.design, flank) for k, path in enumerate(data.paths)]
    return Drawing(page, panels.flank_rows(page, columns, low, high, text, panel))


def _under(path: SolvedPath, row: int) -> str:
    """Say length and angle of a path on a flank; under the gear's also what is the pair's."""
    if not path.found:
        return f"no path on the flanks:\n{path.reason}" if row else "no path"
    own = f"{path.length(row):.1f} mm, {theme.signed(path.angle(row), 1)}\u00b0"
    return "\n".join(
        (own, " \u2192 ".join(path.ends), "ratio {}, running {}".format(*panels.ratios(path)))
        if row
        else (own,)
    )


def rows(data: PathFigure) -> Table:
    """List every position of every path on both members."""
    return solved.table(("a1_per_mm", "a2_per_mm"), zip(data.case.coefficients, data.paths, strict=True))


RECIPES = {f"fig-{case.number:02d}": Recipe(partial(compute, case), draw, rows) for case in CASES}
