"""The paper's sixteen statements on one page: a few words, a small picture and a verdict each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

from matplotlib.text import Text

from beveloid_geom import Design
from beveloid_geom.studies.claims import LITTLE, NOTICEABLE, Case
from beveloid_geom.studies.statement_verdicts import Claim, Statement, Verdict
from beveloid_geom.studies.statements import is_papers, paper_statements, without_its_own

from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.statement_pictures import PICTURES, Line, Lines, few_ticks
from ...stage import theme
from ...stage.layout import ROOM, Cells
from ...stage.theme import Page

FLANK = "right"
MARKS = {
    Verdict.HOLDS: ("\u2713", theme.GREEN),
    Verdict.DEPENDS: ("\u25d0", theme.BLUE),
    Verdict.DOES_NOT_HOLD: ("\u2717", theme.RED),
    Verdict.NOT_KNOWN: ("?", theme.GREY),
}
"""Mark and colour of a verdict."""
WORDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "F6": ("profile and involute", ("concave for a > 0, convex for a < 0",)),
    "C1": ("both a from 0 to 0.0002", ("angle grows, turns over", "longer")),
    "C2": ("both a from 0 to \u22120.0002", ("longer", "angle falls", "to the heel")),
    "C3": ("a1 > 0 > a2, to 0.002", ("longer", "angle falls", "but slightly", "to the toe")),
    "C4": ("a1 < 0 < a2, to 0.002", ("shorter, then longer", "angle grows, turns over")),
    "R1": ("ratio, both a > 0", ("a small one raises it", "it falls clearly")),
    "R2": ("ratio, both a < 0", ("little effect to \u22120.0001", "then it rises clearly")),
    "R3": ("ratio, a1 > 0 > a2", ("it rises clearly",)),
    "R4": ("ratio, a1 < 0 < a2", ("it falls clearly",)),
    "D1": ("turn", ("C1, C4 the most", "C2 too fine", "C3 raises ratio", "C3 root to tip")),
    "M1": ("offset error", ("\u2212 to the toe, + to the heel",)),
    "M2": ("shaft-angle error", ("+ to the toe, \u2212 to the heel",)),
    "M3": ("a1 = 0.001, a2 = \u22120.001", ("path longer than unmodified",)),
    "M4": ("so modified, offset error", ("path shifts less",)),
    "M5": ("so modified, shaft-angle error", ("path shifts less",)),
    "M6": ("axial errors of \u00b10.5 mm", ("path hardly moves", "ratio hardly changes")),
}
"""A few words for what a statement speaks of, and for each of its claims."""
CELLS = Cells(left=1.0, right=0.35, across=0.9, down=0.0, most=4, least=1.8)
NARROW = Cells(left=0.7, right=0.16, across=0.56, down=0.0, most=4, least=0.75)
"""The same on a narrow page, without names of axes."""
TO_WORDS = {"screen": 0.72, "wide": 0.72, "narrow": 0.46}
"""Inches from the left edge of the words of a cell to its picture, by the page."""
INDENT = 0.37
"""Inches from the number of a statement to its verdict."""
UNDER = {"screen": 0.53, "wide": 0.53, "narrow": 0.34}
"""Inches under a picture for its axis, by the page."""
GAP, TALLEST, SPARE = 0.14, 1.15, 0.8
"""Inches between the words of a row of cells and their pictures, the highest of these in print, and what the
page has more for them than others."""
WHOLE = 26
"""Letters of a claim up to which it stands in one line."""
NOTE = (
    "The paper's words can be measured in several ways; \u201c4 of 8\u201d says in how many a claim holds. a1"
    " and a2 are the parabola coefficients of pinion and gear, 1/mm. F6: metal against the involute over r of"
    " the pinion, mm. C1 to C4, M1 to M3: paths of the pinion in the side view, r over z, mm, toe left;"
    " the dot is in the middle of the roll; C: dashed without coefficient, thick the greatest; M1 (mm), M2"
    " (deg): solid without error; M3: dashed unmodified, lengths in mm. R: Eq. 16 over a1, dashed without toe"
    " and heel, dotted where it starts. D1: turn of the path in C1, C4, C2, C3 as a share of the most, over"
    " the range of each, and by coefficient. M4, M5: mean shift in 14 ways, modified by unmodified: circles"
    " along the face, squares square to the path, triangles at mid-roll. M6: change, %; bars stand at"
    f" {100 * NOTICEABLE:g} % of the face and {100 * LITTLE:g} % of the ratio."
)
SHORT = (
    " F6 is of Fig. 6, C1 to C4 of Figs. 7 to 10, R1 to R4 of Fig. 11, D1 of section 4.1, M1 to M6 of"
    " Figs. 12 to 15."
)
"""What narrow pages say in the caption instead of over each picture."""
OTHER = " Coefficients and errors are the paper's, whatever the pair."
LOST = " A claim is not known (?) where some of its paths are not on the flanks or have no such measure."


@dataclass(frozen=True, eq=False)
class Cell:
    """A statement as judged, and the lines of its picture."""

    statement: Statement
    lines: Lines


@dataclass(frozen=True, eq=False)
class Board:
    """All statements, and whether the pair is the one of which the paper speaks."""

    cells: tuple[Cell, ...]
    papers: bool


def compute(design: Design) -> Board:
    """Judge the statements and find what their pictures show."""
    case = Case(without_its_own(design), FLANK)
    judged = paper_statements(design, FLANK)
    return Board(tuple(Cell(one, PICTURES[one.id].find(case, one)) for one in judged), is_papers(design))


def draw(data: Board, layout: theme.Layout) -> Drawing:
    """Draw a cell for each statement."""
    count = len(data.cells)
    kind = "screen" if not layout.printed else "wide" if layout.width > theme.NARROW else "narrow"
    narrow, under, aside = kind == "narrow", UNDER[kind], TO_WORDS[kind]
    cells = NARROW if narrow else CELLS
    cells = cells if layout.printed else replace(cells, left=aside + theme.MARGIN)
    verdicts = Counter(cell.statement.verdict for cell in data.cells)
    note = NOTE + (SHORT if narrow else "") + ("" if data.papers else OTHER)
    note += LOST if Verdict.NOT_KNOWN in verdicts else ""
    page, low, high = theme.new_page(
        layout,
        "The paper's sixteen statements, judged",
        _summary(data, verdicts),
        note,
        tall=ROOM + SPARE,
    )
    page_height, columns = page.get_figheight(), cells.columns(layout, count)
    boxes = cells.boxes(layout, count, page_height, low, high)
    words = [
        _words(page, cell.statement, left - aside / layout.width, left + width, narrow)
        for cell, (left, _, width, _) in zip(data.cells, boxes, strict=True)
    ]
    over = [GAP + max(_height(page, own) for own in words[k : k + columns]) for k in range(0, count, columns)]
    height = ((high - low) * page_height - sum(over)) / len(over) - under
    height = min(height, TALLEST) if layout.printed else height
    top = high
    for number, (cell, own, (left, _, width, _)) in enumerate(zip(data.cells, words, boxes, strict=True)):
        row, place = divmod(number, columns)
        if number and not place:
            top -= (over[row - 1] + height + under) / page_height
        for text in own:
            text.set_y(text.get_position()[1] + top)
        axes = page.add_axes((left, top - (over[row] + height) / page_height, width, height / page_height))
        PICTURES[cell.statement.id].draw(axes, tuple(map(_bare, cell.lines)) if narrow else cell.lines)
        few_ticks(axes)
        if narrow:
            axes.set(xlabel="", ylabel="", aspect="auto")
            if axes.containers:  # of bars there are more than numbers have room
                axes.set_xticks([])
    return Drawing(page, {})


def _bare(line: Line) -> Line:
    """Leave of the label of a line its number."""
    return replace(line, label=line.label.removeprefix("a = ").removesuffix("\u00b0").removesuffix(" mm"))


def _summary(data: Board, verdicts: Counter[Verdict]) -> str:
    """Say of what pair, and how many statements have which verdict."""
    whose = (
        "Right flanks of the paper's pair" if data.papers else "Right flanks of this pair, not the paper's"
    )
    plural = {
        Verdict.HOLDS: "hold",
        Verdict.DEPENDS: "depend on the measure",
        Verdict.DOES_NOT_HOLD: "do not hold",
        Verdict.NOT_KNOWN: "are not known",
    }
    counts = ", ".join(
        f"{verdicts[verdict]} {words}" for verdict, words in plural.items() if verdicts[verdict]
    )
    return f"{whose}: {counts}"


def _words(page: Page, one: Statement, left: float, right: float, short: bool) -> list[Text]:
    """Write number, verdict, of what it speaks unless `short`, and claims between two shares of a page's
    width, for now under its lower edge."""
    pixels = page.get_figwidth() * page.dpi
    mark, colour = MARKS[one.verdict]
    name = page.text(left, 0.0, one.id, fontsize=theme.LABEL, fontweight="bold", va="top")
    indent = INDENT / page.get_figwidth()
    style: dict[str, Any] = {"fontsize": theme.SMALL, "va": "top", "linespacing": 1.2}
    verdict = page.text(left + indent, 0.0, "", fontweight="bold", color=colour, **style)
    verdict_words = one.verdict.value.partition(" on ")[0] if short else one.verdict.value
    theme.fill(verdict, f"{mark}\u00a0{verdict_words}", (right - left - indent) * pixels)
    lines = 1 + verdict.get_text().count("\n")
    said = page.text(left, -theme.inches(page, 0.04 + 0.19 * lines), "", **style)
    about, claims = WORDS[one.id]
    told = [
        _claim(words, claim, 0 if short else WHOLE) for words, claim in zip(claims, one.claims, strict=True)
    ]
    where = "" if short else f"{one.source[0].upper()}{one.source[1:]}, {_kept(about)}: "
    theme.fill(said, where + ("\n" if short else "  ").join(told), (right - left) * pixels)
    return [name, verdict, said]


def _height(page: Page, words: Sequence[Text]) -> float:
    """Give the inches that words under the lower edge of a page take."""
    return -min(float(text.get_window_extent().y0) for text in words) / page.dpi


def _kept(words: str) -> str:
    """Keep signs with what they belong to, in one line."""
    for sign in "<=>":
        words = words.replace(f" {sign} ", f"\u00a0{sign}\u00a0")
    return words.replace("\u2212 ", "\u2212\u00a0").replace("+ ", "+\u00a0")


def _claim(words: str, claim: Claim, whole: int) -> str:
    """Say a claim with its mark, and in how many ways it holds where they differ; in one line if it has fewer
    letters than are to be `whole`."""
    counted = " {} of {}".format(*claim.count) if claim.verdict is Verdict.DEPENDS else ""
    mark, _ = MARKS[claim.verdict]
    told = _kept(f"{mark}\u00a0{words}{counted}")
    return told.replace(" ", "\u00a0") if len(told) < whole else told


def rows(data: Board) -> Table:
    """List the claims of each statement with its verdict, and the lines of its picture."""
    claimed = ("claim", "claim_verdict", "ways_in_which_it_holds", "ways_known")
    drawn = dict.fromkeys(chain.from_iterable(line.columns for cell in data.cells for line in cell.lines))
    header = ("statement", "flank", "verdict", *claimed, "kind", *drawn)

    def cases() -> Rows:
        """Give the columns of every claim and line."""
        for cell in data.cells:
            one = cell.statement
            who = one.id, one.flank, one.verdict.value
            for claim in one.claims:
                yield *who, claim.text, claim.verdict.value, *claim.count, "claim", *[""] * len(drawn)
            for line in cell.lines:
                yield *who, *[""] * len(claimed), line.kind, *(line.columns.get(name, "") for name in drawn)

    return header, stacked(cases())


RECIPES = {"statements": Recipe(compute, draw, rows)}
