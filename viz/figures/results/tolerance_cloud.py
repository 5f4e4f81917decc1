"""Paths of contact of one flank under random assembly errors, and distributions of their position and of the
transmission error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beveloid_geom import Design, path_of_contact, tolerance_study
from beveloid_geom.analysis.tolerance import USUAL_AT, ToleranceStudy, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.pair.misalignment import errors_below, mounted
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.result import table_of
from beveloid_geom.report.tolerance import (
    ToleranceReport,
    edge_contact_count,
    pattern_counts,
    tolerance_words,
)

from ...components import charts, panels, paths_table, viewpoint
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.panels import Panel
from ...components.paths_table import SolvedPath, coefficients, paper_modified
from ...rendering import theme
from ...rendering.layout import PanelRows
from ...rendering.scene import Picture

MOUNTINGS, CYCLE_MOUNTINGS, PATHS_DRAWN, SEED = 1024, 64, 300, 0
"""Number of mountings of a study (a mounting: the pair with one set of random errors), number of those whose
mesh cycle is computed, number of those whose path is drawn, and seed."""
CLOUDS = ((5.0, "white", 0.4), (1.0, theme.BLUE, 0.12))
"""Multiples of the tolerances, colour and opacity of the paths, in the order of drawing (bottom first)."""


@dataclass(frozen=True, eq=False)
class CaseStudy:
    """A case with name, colour and line width; `study` is None with a `reason`."""

    name: str
    design: Design
    colour: str
    width: float
    study: ToleranceStudy | None
    reason: str = ""

    @property
    def solved(self) -> ToleranceStudy | None:
        """The study if some mounting has a path."""
        return self.study if self.study is not None and self.study.mountings.solved.any() else None


@dataclass(frozen=True, eq=False)
class CloudFigure:
    """Nominal path, paths under errors and studies of one flank.

    `clouds`: points (mountings, n, 3) on pinion and gear in their frames, one pair for each of
    CLOUDS."""

    flank: str
    nominal: SolvedPath
    clouds: tuple[tuple[FloatArray, FloatArray], ...]
    cases: tuple[CaseStudy, ...]

    @property
    def reason(self) -> str:
        """Reason why there is nothing to show."""
        none = "no mounting has a path on the flanks"
        return next((case.reason for case in self.cases if case.reason), none)

    @property
    def drawn(self) -> bool:
        """True if some mounting has a path to draw."""
        return any(np.isfinite(points).any() for cloud in self.clouds for points in cloud)

    @property
    def moved(self) -> float:
        """Distance between the 1 % and 99 % quantiles of z at the middle of the path on the pinion, mm, for
        the design whose paths are drawn; NaN if unknown."""
        study = next((case.solved for case in self.cases if case.design is self.nominal.design), None)
        if study is None:
            return float("nan")
        middle = study.mountings.quantities()["pinion_z_middle"][study.mountings.solved]
        return float(np.ptp(np.percentile(middle, (1.0, 99.0))))


def compute(design: Design, flank: str = "right") -> CloudFigure:
    """Compute paths and studies, as designed and with the paper's modification."""
    bent = paper_modified(design)
    shown = bent if is_line_contact(design).any() else design
    cases = ("as designed", design, theme.BLUE, 3.2), (coefficients(bent), bent, theme.VERMILLION, 1.6)
    return CloudFigure(
        flank,
        paths_table.solved_case(shown, flank),
        tuple(_cloud_of(shown, flank, factor) for factor, *_ in CLOUDS),
        tuple(case_study(flank, *case) for case in cases),
    )


def case_study(flank: str, name: str, design: Design, colour: str, width: float) -> CaseStudy:
    """Compute the study of a case on a flank."""
    try:
        known = 0 if first_contact_fault(design) else min(CYCLE_MOUNTINGS, MOUNTINGS)
        usual = USUAL_AT[design.errors_at]
        study = tolerance_study(design, usual, flank, MOUNTINGS, seed=SEED, operation=known)
    except ValueError as error:
        lines = is_line_contact(design).all()
        reason = "not studied, shaft-angle errors leave contact on edges only" if lines else str(error)
        return CaseStudy(name, design, colour, width, None, reason)
    return CaseStudy(name, design, colour, width, study)


def _cloud_of(design: Design, flank: str, factor: float) -> tuple[FloatArray, FloatArray]:
    """Return points of the paths on pinion and gear; NaN without a path.

    The arrays are empty if the errors are too large for the layout."""
    points = 33
    usual = USUAL_AT[design.errors_at]
    if any(factor * getattr(usual, name) >= most for name, most in errors_below(design).items()):
        return np.empty((0, points, 3)), np.empty((0, points, 3))
    errors = factor * drawn_errors(usual, SEED, 0, PATHS_DRAWN)
    with np.errstate(invalid="ignore"):
        path = path_of_contact(mounted(design, errors, usual.names), flank, points)
        return paths_table.points_on(path, 0), paths_table.points_on(path, 1)


def draw(data: CloudFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the clouds on pinion and gear above the distributions of position and transmission error."""
    cells = PanelRows(left=0.95, right=0.3, across=1.0, down=1.1, most=2, least=1.6)
    stretch = 4.0  # magnification of the flanks from root to tip
    # Name, factor, heading and label of the axis.
    quantities = (
        ("pinion_z_middle", 1.0, "middle of the path", "pinion z (mm)"),
        ("peak_to_peak", ARCSEC, "transmission error", "peak to peak (arcsec)"),
    )
    page, low, high = theme.new_page(
        layout,
        _title(data),
        _tolerances(data),
        _note(data, stretch) + _in_operation(data),
        below=0.9,
        above=0.7,
        characters=viewpoint.NOTE_CHARACTERS,
        tall=cells.tall(layout, 4, 2.6) + 0.6,
    )
    boxes = cells.boxes(layout, 4, page.get_figheight(), low, high)
    views = viewpoint.flank_views(data.nominal.design, data.flank, stretch, outside=True)
    px_per_mm = panels.shared_scale(page, views, boxes[0][2], boxes[0][3])
    pictures: dict[str, Picture] = {}
    over = theme.inches(page, 0.12)
    for number, (member, box, view) in enumerate(zip(paths_table.MEMBERS, boxes[:2], views, strict=True)):
        left, bottom, _, height = box
        heading = f"({'ab'[number]})  {member}"
        page.text(left, bottom + height + over, heading, fontsize=theme.HEADING)
        place = page, theme.place(page, *box), data.nominal.design
        drawn = panels.draw_flank(*place, number, view, (), px_per_mm)
        if drawn is not None:
            _cloud(drawn, data, number)
            pictures[member] = drawn.picture
    for letter, box, (name, scale, heading, label) in zip("cd", boxes[2:], quantities, strict=True):
        axes = page.add_axes(box)
        axes.set_title(f"({letter})  {heading}", loc="left", fontsize=theme.HEADING)
        axes.set(xlabel=label, ylabel="mountings below (%)")
        solved = [(case, case.solved) for case in data.cases if case.solved]
        for case, study in solved:
            charts.distribution(axes, study, name, scale, case.colour, case.width)
        if not solved:
            axes.set_axis_off()
            theme.message(axes, data.reason, 30)
    _legend(page, data)
    return Drawing(page, pictures)


def _title(data: CloudFigure) -> str:
    """Return the finding as title: how far the tolerances move the path."""
    if not np.isfinite(data.moved):
        return "Paths of contact under random assembly errors"
    design = data.nominal.design
    moved, face = f"{data.moved:.{paths_table.digits_mm(design)}f} mm", float(design.pinion.face_width)
    return f"Tolerances move the path over {moved}, {100.0 * data.moved / face:.0f} % of the face"


def _tolerances(data: CloudFigure) -> str:
    """Return the subtitle with the tolerances."""
    design = data.cases[0].design
    usual = USUAL_AT[design.errors_at]
    spread = f"{usual.distribution}, {usual.sigmas:g} standard deviations"
    sizes = f"{tolerance_words(usual)}{paths_table.at_the_mesh(design)}"
    return f"{data.flank.capitalize()} flanks; {sizes} ({spread})"


def _note(data: CloudFigure, stretch: float) -> str:
    """Return the note with the mountings drawn."""
    if not data.drawn:
        return f"Flanks from outside, {stretch:g} times larger from root to tip; black: without errors."
    note = (
        "Flanks from outside, {stretch:g} times larger from root to tip: {drawn} mountings of the"
        " design{which}; black and dots: without errors. (c), (d): cumulative distributions; title: range"
        " from 1 to 99 %. Transmission error of one tooth pair."
    )
    shown = data.nominal.design
    which = "" if shown is data.cases[0].design else f" with {coefficients(shown)}"
    return note.format(drawn=PATHS_DRAWN, which=which, stretch=stretch)


def _in_operation(data: CloudFigure) -> str:
    """Return the sentence on the operation of the first mountings; empty if it is not known."""
    known = [case.study.cycles for case in data.cases if case.study and case.study.cycles]
    if len(known) < len(data.cases):
        return ""
    edges, ends = (
        " and ".join(str(count(cycles)) for cycles in known)
        for count in (edge_contact_count, lambda cycles: pattern_counts(cycles)["toe_or_heel"])
    )
    return (
        f" Edges touch in {edges} of {known[0].status.size} mountings; patterns reach a face end in {ends}"
        f" of {pattern_counts(known[0])['known']} (as designed; modified)."
    )


def _cloud(drawn: Panel, data: CloudFigure, number: int) -> None:
    """Draw the paths under random errors, and the nominal path on top."""
    for cloud, (_, hue, alpha) in zip(data.clouds, CLOUDS, strict=True):
        charts.cloud(drawn.axes, drawn.place, cloud[number], hue, alpha)
    if data.nominal.has_path:
        seen = drawn.place(data.nominal.points[number])
        drawn.axes.plot(*seen.T, color=theme.INK, linewidth=1.3, solid_capstyle="round")
    else:
        reason = f"no path as designed: {data.nominal.reason}"
        theme.message(drawn.axes, reason, 12, fontsize=theme.SMALL)


def counts(case: CaseStudy) -> str:
    """Return the name of a case, its number of mountings with a path, and that of jammed ones if not zero."""
    if case.study is None:
        lines = is_line_contact(case.design).all()
        return f"{case.name}: {case.reason if lines else 'not studied'}"
    solved = np.count_nonzero(case.study.mountings.solved)
    jammed = np.count_nonzero(case.study.mountings.jammed)
    jams = f", {jammed} jammed" if jammed else ""
    return f"{case.name}: {solved} of {case.study.cases} with a path{jams}"


def _legend(page: theme.Page, data: CloudFigure) -> None:
    """Draw the legend of clouds and cases, if there are any."""
    handles: list[Any] = [
        Patch(facecolor=hue, edgecolor=theme.GREY, linewidth=0.8, label=f"{factor:g} \u00d7 tolerances")
        for factor, hue, _ in reversed(CLOUDS if data.drawn else ())
    ]
    if any(case.study for case in data.cases):
        handles += [
            Line2D([], [], color=case.colour, lw=case.width, label=counts(case)) for case in data.cases
        ]
    if not handles:
        return
    size: dict[str, Any] = {} if page.layout.printed else {"fontsize": theme.SMALL}
    theme.legend(page, handles, 4, 1.15, **size)


def rows(data: CloudFigure) -> Table:
    """List every mounting of every study as in the command."""
    tables = [
        None if case.study is None else table_of(ToleranceReport(case.name, case.design, case.study).rows())
        for case in data.cases
    ]
    header = max((table[0] for table in tables if table), key=len, default=[])

    def each() -> Rows:
        """Yield the columns of every study."""
        for case, table in zip(data.cases, tables, strict=True):
            who = data.flank, *paths_table.parabolas(case.design, data.flank)
            if case.study is None or table is None:
                yield *who, *[""] * (1 + len(header)), case.reason
                continue
            columns = dict(zip(*table, strict=True))
            values = (columns.get(name, "") for name in header)
            yield *who, list(range(case.study.cases)), *values, ""

    return ["flank", *paths_table.PARABOLAS, "mounting", *header, "reason"], rows_of_cases(each())


RECIPES = {"tolerance-cloud": Recipe(compute, draw, rows)}
