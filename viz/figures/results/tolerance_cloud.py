"""Paths of contact under random assembly errors, and distributions of contact ratio, transmission error and
position."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beveloid_geom import Design, Status, path_of_contact, tolerance_study
from beveloid_geom.analysis.tolerance import USUAL_AT, ToleranceStudy, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.contact.path import path_ends
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.pair.misalignment import errors_below, mounted
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.result import table_of
from beveloid_geom.report.tolerance import ToleranceReport, edges_carry, pattern_counts, size_words

from ...components import charts, panels, paths_table, viewpoint
from ...components.figure_steps import Drawing, Recipe, Rows, Table, stacked
from ...components.panels import Panel
from ...components.paths_table import FLANKS, SolvedPath, coefficients, modified
from ...rendering import theme
from ...rendering.scene import Picture
from .tolerance_layout import Section, print_height, sections_of

MOUNTINGS, PATHS_DRAWN, SEED = 1024, 300, 0
"""Number of mountings of a study, number of them drawn, and seed."""
CYCLE_MOUNTINGS = 64
"""Number of mountings for which the operation is computed."""
POINTS = 33
TOLERANCE_FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0)
"""Multiples of the tolerances in the last panels."""
SMALLEST_FRACTION = 0.02
QUANTITIES = (
    ("contact_ratio", 1.0, "contact ratio"),
    ("peak_to_peak", ARCSEC, "error (arcsec)"),
    ("pinion_z_middle", 1.0, "middle z (mm)"),
)
"""Name, factor and label of the quantities of a study that are shown."""
MESSAGE_STYLE: dict[str, Any] = {"fontsize": theme.SMALL, "backgroundcolor": "white"}
LINE_CONTACT_NOTE = ", shaft-angle errors leave edges"
CLOUDS = ((5.0, "white", 0.12), (1.0, theme.BLUE, 0.08))
"""Multiples of the tolerances, colour and opacity of the paths drawn, the lowest first."""
NOTE = (
    "{drawn} of {all} mountings of the design {which}; black: without errors. Tolerances ({spread}): {sizes}."
    " Curves: cumulative distribution; dots: without errors. Transmission error: one tooth pair, peak to"
    " peak. Middle z: pinion, mid-roll."
)


@dataclass(frozen=True, eq=False)
class CaseStudy:
    """A case with name, colour and line width.

    `study` is None with a `reason`. `shares` (2, factors): for each of TOLERANCE_FACTORS the fractions of
    mountings with a path that ends at another limit, and without a path; NaN if not known."""

    name: str
    design: Design
    colour: str
    width: float
    study: ToleranceStudy | None
    shares: FloatArray
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Side:
    """One flank: nominal path, paths under errors and studies.

    `clouds`: points (mountings, POINTS, 3) on pinion and gear in their frames, one pair for each of
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


def compute(design: Design) -> tuple[Side, ...]:
    """Compute paths and studies of both flanks, as designed and with the paper's modification."""
    bent = modified(design)
    shown = bent if touches_along_lines(design).any() else design
    cases = ("as designed", design, theme.BLUE, 3.2), (_plain(coefficients(bent)), bent, theme.RED, 1.6)
    return tuple(
        Side(
            flank,
            paths_table.solve(shown, flank),
            tuple(_cloud_of(shown, flank, factor) for factor, *_ in CLOUDS),
            tuple(_case(flank, *case) for case in cases),
        )
        for flank in FLANKS
    )


def _plain(words: str) -> str:
    """Return coefficients without superscripts and subscripts, which increase the line spacing."""
    return theme.spelled(words).replace(" mm\u207b\u00b9", "/mm")


def _case(flank: str, name: str, design: Design, colour: str, width: float) -> CaseStudy:
    """Compute the study of a case on a flank with the tolerances and with TOLERANCE_FACTORS times the
    tolerances."""
    shares, usual = np.full((2, len(TOLERANCE_FACTORS)), np.nan), USUAL_AT[design.errors_at]
    try:
        known = 0 if first_contact_fault(design) else min(CYCLE_MOUNTINGS, MOUNTINGS)
        study = tolerance_study(design, usual, flank, MOUNTINGS, seed=SEED, operation=known)
    except ValueError as error:
        return CaseStudy(name, design, colour, width, None, shares, str(error))
    if not study.mountings.solved.any():
        return CaseStudy(name, design, colour, width, study, shares)
    for k, factor in enumerate(TOLERANCE_FACTORS):
        if _too_large(design, factor):
            break
        ends = path_ends(_mountings(design, factor, MOUNTINGS), flank)
        found = ends.status == Status.SOLVED
        changed = (ends.limit != study.nominal.limit).any(axis=1)
        shares[:, k] = np.mean(found & changed), np.mean(~found)
    return CaseStudy(name, design, colour, width, study, shares)


def _too_large(design: Design, factor: float) -> bool:
    """Return whether a multiple of the tolerances is too large for the layout."""
    usual = USUAL_AT[design.errors_at]
    return any(factor * getattr(usual, name) >= most for name, most in errors_below(design).items())


def _mountings(design: Design, factor: float, count: int) -> Design:
    """Return a design under the first `count` random errors with a multiple of the tolerances."""
    usual = USUAL_AT[design.errors_at]
    return mounted(design, factor * drawn_errors(usual, SEED, 0, count), usual.names)


def _cloud_of(design: Design, flank: str, factor: float) -> tuple[FloatArray, FloatArray]:
    """Return points of the paths on pinion and gear; NaN without a path.

    The arrays are empty if the errors are too large for the layout."""
    if _too_large(design, factor):
        return np.empty((0, POINTS, 3)), np.empty((0, POINTS, 3))
    with np.errstate(invalid="ignore"):
        path = path_of_contact(_mountings(design, factor, PATHS_DRAWN), flank, POINTS)
        return paths_table.points_on(path, 0), paths_table.points_on(path, 1)


def draw(data: tuple[Side, ...], layout: theme.Layout) -> Drawing:
    """Draw for each flank the clouds on pinion and gear, the distributions, and the effect of larger
    tolerances."""
    page, low, high = theme.new_page(
        layout,
        "Paths of contact under random assembly errors",
        "Paths, and distributions of contact ratio, transmission error and position",
        _note(data[0]) + _in_operation(data),
        below=0.3,
        above=0.3,
        columns=viewpoint.COLUMNS,
        tall=print_height(layout, len(data)),
    )
    sections = sections_of(page, low, high, len(data))
    looks = [(side.nominal.design, side.flank, panels.STRETCH) for side in data]
    views = [viewpoint.flank_views(*look, outside=True) for look in looks]
    _, _, width, height = sections[0].clouds[0]
    px_per_mm = panels.shared_scale(page, views, width, height - theme.inches(page, 0.1))
    pictures: dict[str, Picture] = {}
    for row, (side, section) in enumerate(zip(data, sections, strict=True)):
        words = f"{side.flank.capitalize()} flanks"
        style: dict[str, Any] = {"rotation": 90, "va": "center"} if section.upright else {"va": "bottom"}
        page.text(*section.name, words, fontsize=theme.HEADING, **style)
        for column, (member, (left, bottom, width, height)) in enumerate(
            zip(paths_table.MEMBERS, section.clouds, strict=True)
        ):
            box = theme.place(page, left, bottom, width, height)
            design, view = side.nominal.design, views[row][column]
            drawn = panels.draw_flank(page, box, design, column, side.flank, view, (), px_per_mm)
            if drawn is not None:
                _cloud(drawn, side, column)
                pictures[f"{member}-{side.flank}"] = drawn.picture
            y = bottom + height + theme.inches(page, 0.08)
            page.text(left + 0.5 * width, y, member.capitalize(), ha="center", fontsize=theme.LABEL)
        _charts(page, side, section)
    _legend(page, data)
    return Drawing(page, pictures)


def _note(side: Side) -> str:
    """Return the note with the mountings drawn and the tolerances."""
    design, shown = side.cases[0].design, side.nominal.design
    drawn = "as it is" if shown is design else f"with {_plain(coefficients(shown))}"
    usual = USUAL_AT[design.errors_at]
    sizes = size_words(usual) + paths_table.at_the_mesh(design)
    spread = f"{usual.distribution}, {usual.sigmas:g} standard deviations"
    return NOTE.format(drawn=PATHS_DRAWN, which=drawn, all=MOUNTINGS, spread=spread, sizes=sizes)


def _in_operation(data: tuple[Side, ...]) -> str:
    """Return the sentence on the operation of the first mountings; empty if it is not known."""
    studies = [[case.study for case in side.cases] for side in data]
    known = [[study.running for study in row if study and study.running] for row in studies]
    if not all(len(row) == len(side.cases) for row, side in zip(known, data, strict=True)):
        return ""
    ends, edges = (
        " and ".join(
            f"{', '.join(str(count(running)) for running in row)} on {side.flank} flanks"
            for row, side in zip(known, data, strict=True)
        )
        for count in (lambda running: pattern_counts(running)["toe_or_heel"], edges_carry)
    )
    return (
        f" In operation (as designed, modified): edge contact in {edges} of the first"
        f" {known[0][0].status.size} mountings; of the {pattern_counts(known[0][0])['known']} with the"
        f" largest shift, patterns reach an end of a face in {ends}."
    )


def _cloud(drawn: Panel, side: Side, number: int) -> None:
    """Draw the paths under random errors, and the nominal path on top."""
    for cloud, (_, hue, alpha) in zip(side.clouds, CLOUDS, strict=True):
        charts.cloud(drawn.axes, drawn.place, cloud[number], hue, alpha)
    if side.nominal.found:
        seen = drawn.place(side.nominal.points[number])
        drawn.axes.plot(*seen.T, color=theme.INK, linewidth=1.3, solid_capstyle="round")
    else:
        reason = f"no path as designed: {side.nominal.reason}"
        theme.message(drawn.axes, reason, 12, fontsize=theme.SMALL)


def _charts(page: theme.Page, side: Side, section: Section) -> None:
    """Draw the distributions of three quantities of a flank, and the effect of larger tolerances."""
    y = section.words[1]
    for case in side.cases:
        words = textwrap.fill(_counts(case), section.columns)
        style: dict[str, Any] = {"fontsize": theme.SMALL, "color": case.colour}
        page.text(section.words[0], y, words, va="center" if section.upright else "top", **style)
        y -= theme.inches(page, 0.23 * (1 + words.count("\n")))
    axes = [page.add_axes(box) for box in section.charts]
    studies = [case for case in side.cases if case.study is not None and case.study.mountings.solved.any()]
    for one, (name, scale, label) in zip(axes, QUANTITIES, strict=False):
        one.set_xlabel(label, fontsize=theme.SMALL, labelpad=1.0)
        for case in studies:
            assert case.study is not None
            charts.distribution(one, case.study, name, scale, case.colour, case.width)
        if not studies:
            one.set_xticks([])
            theme.message(one, side.reason, 18, **MESSAGE_STYLE)
    axes[0].set_ylabel("share (%)", fontsize=theme.SMALL, labelpad=2.0)
    _shares(axes[3], side)
    for one in axes:
        one.tick_params(labelsize=theme.SMALL)
        one.grid(True)


def _counts(case: CaseStudy) -> str:
    """Return the numbers of mountings with a path and with another limit as text."""
    if case.study is None:
        return f"{case.name}: not studied" + (
            LINE_CONTACT_NOTE if touches_along_lines(case.design).all() else ""
        )
    count, every = np.count_nonzero(case.study.mountings.solved), case.study.cases
    share = f"{count} of {every}" if count < every else f"all {every}"
    changed = f"{case.study.limits_changed()} ended by another limit"
    return f"{case.name}: {share} mountings have a path, {changed}"


def _shares(axes: Axes, side: Side) -> None:
    """Draw the fractions of mountings that end at other limits and without a path over the size of the
    tolerances."""
    axes.set_xlabel("times tolerances", fontsize=theme.SMALL, labelpad=1.0)
    axes.set_xscale("log")
    axes.set_xlim(TOLERANCE_FACTORS[0] / 1.1, 1.1 * TOLERANCE_FACTORS[-1])
    axes.set_xticks([1.0, 2.0, 5.0, 10.0], ["1", "2", "5", "10"])
    axes.minorticks_off()
    axes.set_ylim(-2.0, 102.0)
    for case in side.cases:
        for shares, dashes in zip(100.0 * case.shares, ("--", "-"), strict=True):
            axes.plot(TOLERANCE_FACTORS, shares, dashes, color=case.colour, linewidth=case.width)
    known = np.array([case.shares for case in side.cases])
    if np.isnan(known).all():
        theme.message(axes, side.reason, 18, **MESSAGE_STYLE)
    elif np.nanmax(known) < SMALLEST_FRACTION:
        theme.message(axes, f"under {100.0 * SMALLEST_FRACTION:g} %", 18, **MESSAGE_STYLE)


def _legend(page: theme.Page, data: tuple[Side, ...]) -> None:
    """Draw the legends of cases, curves and clouds."""
    handles = [Line2D([], [], color=case.colour, lw=case.width, label=case.name) for case in data[0].cases]
    black: dict[str, Any] = {"color": theme.INK, "linewidth": 2.0}
    handles.append(Line2D([], [], ls="--", label="another limit ends the path", **black))
    handles.append(Line2D([], [], label="no path on the flanks", **black))
    drawn = [
        Patch(facecolor=hue, edgecolor=theme.GREY, linewidth=0.8, label=f"{factor:g} \u00d7 tolerances")
        for factor, hue, _ in reversed(CLOUDS)
    ]
    theme.legend(page, handles, 4, 1.15, fontsize=theme.SMALL)
    theme.legend(page, drawn, 2, 1.15, 0.03, fontsize=theme.SMALL)


def rows(data: tuple[Side, ...]) -> Table:
    """List every mounting of every study as in the command, and the fractions under larger tolerances.

    `kind` gives the meaning of a row."""
    cases = [(side.flank, case) for side in data for case in side.cases]
    tables = [
        None if case.study is None else table_of(ToleranceReport(case.name, case.design, case.study).rows())
        for _, case in cases
    ]
    header = max((table[0] for table in tables if table), key=len, default=[])
    shares = ("times_tolerances", "share_ended_elsewhere", "share_without_path")

    def each() -> Rows:
        """Yield the columns of every study."""
        for (flank, case), table in zip(cases, tables, strict=True):
            who = flank, *paths_table.parabolas(case.design, flank)
            if case.study is None or table is None:
                yield *who, case.reason, *[""] * (1 + len(header) + len(shares))
                continue
            columns = dict(zip(*table, strict=True))
            values = (columns.get(name, "") for name in header)
            yield *who, "mounting", list(range(case.study.cases)), *values, *[""] * len(shares)
            yield *who, "tolerances", *[""] * (1 + len(header)), list(TOLERANCE_FACTORS), *case.shares

    return ["flank", *paths_table.PARABOLAS, "kind", "mounting", *header, *shares], stacked(each())


RECIPES = {"tolerance-cloud": Recipe(compute, draw, rows)}
