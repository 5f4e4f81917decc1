"""Cloud of paths of contact under drawn assembly errors, and how contact ratio, error and position spread."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beveloid_geom import Design, Status, path_of_contact, tolerance_study
from beveloid_geom.analysis.tolerance import USUAL_AT, ToleranceStudy, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.contact.path import path_ends
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.pair.errors import errors_below, mounted
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.result import table_of
from beveloid_geom.report.tolerance import ToleranceReport, edges_carry, pattern_counts, size_words

from ...parts import charts, panels, solved, viewpoint
from ...parts.panels import Panel
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, SolvedPath, coefficients, modified
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import Picture

MOUNTINGS, DRAWN, SEED = 1024, 300, 0
"""Mountings of a study, and how many are drawn."""
IN_OPERATION = 64
"""Mountings, the first of them, of which is said what they do in operation."""
POINTS = 33
FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0)
"""Times the tolerances of the last panels."""
FEW = 0.02
QUANTITIES = (
    ("contact_ratio", 1.0, "contact ratio"),
    ("peak_to_peak", ARCSEC, "error (arcsec)"),
    ("pinion_z_middle", 1.0, "middle z (mm)"),
)
"""Name, scale and label of what is shown of a study."""
SAID: dict[str, Any] = {"fontsize": theme.SMALL, "backgroundcolor": "white"}
EDGES = ", shaft-angle errors leave edges"
LEFT, RIGHT = 0.05, 0.99  # shares of the page's width
CLOUD, GAP = 0.145, 0.058  # of a flank, and between charts
CHARTS = Cells(left=0.9, right=0.25, across=0.95, down=0.65, most=2, least=1.3)
CLOUDS_WIDE, CLOUD_TALL, BLOCK, COLUMN = 4.2, 1.9, 4.7, 7.65
"""Inches in print: of clouds beside charts, and over them, and of what stands on a flank where clouds are
beside charts, and over them."""
CLOUDS = ((5.0, "white", 0.12), (1.0, theme.BLUE, 0.08))
"""Times the tolerances, colour and opacity of the paths drawn, the lowest first."""
NOTE = (
    "Drawn are {drawn} mountings (seed {seed}) of the design {which}, and in black none of the errors. These"
    " are {spread}: {sizes}, on top of the design's own; members stay mounted as without them. Curves: share"
    " of the mountings with a path whose value is at most that below; dots: without errors. Contact ratio by"
    " Eq. 16; transmission error of one tooth pair over its path, peak to peak, 0 without modification;"
    " middle z of the pinion at mid-roll, positive to the heel. Last panel: {all} mountings each, by which"
    " chance moves a share by up to 3 %."
)


@dataclass(frozen=True, eq=False)
class CaseStudy:
    """A case by its name, colour and width of lines: its study, None with a `reason`; and by FACTORS the
    shares of mountings with a path that another limit ends, and of those without a path, NaN where not known
    (2, factors)."""

    name: str
    design: Design
    colour: str
    width: float
    study: ToleranceStudy | None
    shares: FloatArray
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Side:
    """One flank: the path of the design as it is, drawn paths (mountings, POINTS, 3) on pinion and gear in
    their own frames, one pair for each of CLOUDS, and the studies."""

    flank: str
    nominal: SolvedPath
    clouds: tuple[tuple[FloatArray, FloatArray], ...]
    cases: tuple[CaseStudy, ...]

    @property
    def reason(self) -> str:
        """Say why there is nothing to show."""
        none = "no mounting has a path on the flanks"
        return next((case.reason for case in self.cases if case.reason), none)


def compute(design: Design) -> tuple[Side, ...]:
    """Find drawn paths and studies of both flanks, as designed and with the paper's modification."""
    bent = modified(design)
    shown = bent if touches_along_lines(design).any() else design
    cases = ("as designed", design, theme.BLUE, 3.2), (_plain(coefficients(bent)), bent, theme.RED, 1.6)
    return tuple(
        Side(
            flank,
            solved.solve(shown, flank),
            tuple(_cloud_of(shown, flank, factor) for factor, *_ in CLOUDS),
            tuple(_case(flank, *case) for case in cases),
        )
        for flank in FLANKS
    )


def _plain(words: str) -> str:
    """Give coefficients without raised and lowered letters, which would make all type around them larger."""
    return theme.spelled(words).replace(" mm\u207b\u00b9", "/mm")


def _case(flank: str, name: str, design: Design, colour: str, width: float) -> CaseStudy:
    """Study a case on a flank, with the tolerances and with FACTORS times as much."""
    shares, usual = np.full((2, len(FACTORS)), np.nan), USUAL_AT[design.errors_at]
    try:
        known = 0 if first_contact_fault(design) else min(IN_OPERATION, MOUNTINGS)
        study = tolerance_study(design, usual, flank, MOUNTINGS, seed=SEED, operation=known)
    except ValueError as error:
        return CaseStudy(name, design, colour, width, None, shares, str(error))
    if not study.mountings.solved.any():
        return CaseStudy(name, design, colour, width, study, shares)
    for k, factor in enumerate(FACTORS):
        if _too_large(design, factor):
            break
        ends = path_ends(_mountings(design, factor, MOUNTINGS), flank)
        found = ends.status == Status.SOLVED
        changed = (ends.limit != study.nominal.limit).any(axis=1)
        shares[:, k] = np.mean(found & changed), np.mean(~found)
    return CaseStudy(name, design, colour, width, study, shares)


def _too_large(design: Design, factor: float) -> bool:
    """Say whether so many times the tolerances are too large for the layout."""
    usual = USUAL_AT[design.errors_at]
    return any(factor * getattr(usual, name) >= most for name, most in errors_below(design).items())


def _mountings(design: Design, factor: float, count: int) -> Design:
    """Give a design under the first so many errors drawn with so many times the tolerances."""
    usual = USUAL_AT[design.errors_at]
    return mounted(design, factor * drawn_errors(usual, SEED, 0, count), usual.names)


def _cloud_of(design: Design, flank: str, factor: float) -> tuple[FloatArray, FloatArray]:
    """Give points of the drawn paths on pinion and gear; NaN without a path. Not under errors too large for
    the layout."""
    if _too_large(design, factor):
        return np.empty((0, POINTS, 3)), np.empty((0, POINTS, 3))
    with np.errstate(invalid="ignore"):
        path = path_of_contact(_mountings(design, factor, DRAWN), flank, POINTS)
        return solved.points_on(path, 0), solved.points_on(path, 1)


@dataclass(frozen=True, eq=False)
class Section:
    """Where a flank stands on the page, shares of it: boxes (left, bottom, width, height) of its two clouds
    and four charts, the place of its name and whether that is upright, and that of the words on its studies,
    in lines of so many characters."""

    clouds: Sequence[tuple[float, float, float, float]]
    charts: Sequence[tuple[float, float, float, float]]
    name: tuple[float, float]
    upright: bool
    words: tuple[float, float]
    columns: int


def _sections(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Lay out a row for each flank: clouds on the left, charts on the right."""
    bottoms, height = theme.rows(low, high, count)
    height -= theme.inches(page, 0.5)
    start = LEFT + 2.0 * (CLOUD + 0.012) + 0.035
    width = (RIGHT - start - 3.0 * GAP) / 4.0
    over, under = theme.inches(page, 0.35), theme.inches(page, 0.6)
    return [
        Section(
            [(LEFT + column * (CLOUD + 0.012), bottom, CLOUD, height) for column in (0, 1)],
            [(start + k * (width + GAP), bottom + under, width, height - under - over) for k in range(4)],
            (0.012, bottom + 0.5 * height),
            True,
            (start, bottom + height + theme.inches(page, 0.2)),
            200,
        )
        for bottom in bottoms
    ]


def _sections_in_print(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Lay out a block for each flank: charts two by two, and clouds beside them; or, where that has no room,
    a column for each, its charts one under another and clouds over them."""
    layout, tall, wide = page.layout, page.get_figheight(), page.layout.width > theme.NARROW
    bottoms, own = theme.rows(low, high, count if wide else 1, theme.inches(page, 0.5))
    found = []
    for number in range(count):
        bottom, width = bottoms[number if wide else 0], layout.width if wide else layout.width / count
        start = 0.0 if wide else number * width
        cells = replace(CHARTS, left=CHARTS.left + CLOUDS_WIDE) if wide else replace(CHARTS, most=1, down=0.5)
        top = bottom + own - theme.inches(page, 1.0 if wide else 1.75)
        base = bottom + theme.inches(page, 0.55)
        foot = base if wide else top - theme.inches(page, CLOUD_TALL)
        room, left = CLOUDS_WIDE if wide else width - 0.3, start + 0.2
        charts_on = replace(layout, width=width)
        boxes = cells.boxes(charts_on, 4, tall, base, top if wide else foot - theme.inches(page, 0.3))
        share = width / layout.width
        found.append(
            Section(
                [
                    ((left + 0.5 * k * room) / layout.width, foot, 0.48 * room / layout.width, top - foot)
                    for k in (0, 1)
                ],
                [(start / layout.width + x * share, y, w * share, height) for x, y, w, height in boxes],
                (left / layout.width, bottom + own),
                False,
                (left / layout.width, bottom + own - theme.inches(page, 0.12)),
                int(10.0 * width),
            )
        )
    return found


def draw(data: tuple[Side, ...], layout: theme.Layout) -> Drawing:
    """Draw for each flank the clouds on pinion and gear, the spread, and what larger tolerances do."""
    wide = layout.width > theme.NARROW
    page, low, high = theme.new_page(
        layout,
        "Paths of contact under drawn assembly errors",
        "Cloud of paths, and spread of contact ratio, transmission error and position",
        _note(data[0]) + _in_operation(data),
        below=0.3,
        above=0.3,
        columns=viewpoint.COLUMNS,
        tall=len(data) * BLOCK if wide else COLUMN,
    )
    sections = (_sections_in_print if layout.printed else _sections)(page, low, high, len(data))
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
            zip(solved.MEMBERS, section.clouds, strict=True)
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
    """Say what is drawn, under which tolerances."""
    design, shown = side.cases[0].design, side.nominal.design
    drawn = "as it is" if shown is design else f"with {_plain(coefficients(shown))}"
    usual = USUAL_AT[design.errors_at]
    sizes = size_words(usual) + solved.at_the_mesh(design)
    spread = f"{usual.distribution}, the tolerances at {usual.sigmas:g} standard deviations"
    note = NOTE.format(drawn=DRAWN, which=drawn, all=MOUNTINGS, seed=SEED, spread=spread, sizes=sizes)
    how = panels.how_drawn("right and left", panels.STRETCH, outside=True)
    return how.partition(" A path enters")[0] + " " + note


def _in_operation(data: tuple[Side, ...]) -> str:
    """Say what the first mountings of the cases do in operation, flank by flank, where that is known."""
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
        f" In operation, of the first {known[0][0].status.size} mountings, as designed and modified: patterns"
        f" of {1e3 * MARKING_SEPARATION:g} \u00b5m of marking compound end at a toe or heel in {ends};"
        f" edges carry in {edges}."
    )


def _cloud(drawn: Panel, side: Side, number: int) -> None:
    """Draw the paths under drawn errors, and that of the design on top."""
    for cloud, (_, hue, alpha) in zip(side.clouds, CLOUDS, strict=True):
        charts.cloud(drawn.axes, drawn.place, cloud[number], hue, alpha)
    if side.nominal.found:
        seen = drawn.place(side.nominal.points[number])
        drawn.axes.plot(*seen.T, color=theme.INK, linewidth=1.3, solid_capstyle="round")
    else:
        reason = f"no path as designed: {side.nominal.reason}"
        theme.say(drawn.axes, reason, 12, fontsize=theme.SMALL)


def _charts(page: theme.Page, side: Side, section: Section) -> None:
    """Draw how three quantities of a flank spread, and what larger tolerances do."""
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
            charts.spread(one, case.study, name, scale, case.colour, case.width)
        if not studies:
            one.set_xticks([])
            theme.say(one, side.reason, 18, **SAID)
    axes[0].set_ylabel("share (%)", fontsize=theme.SMALL, labelpad=2.0)
    _shares(axes[3], side)
    for one in axes:
        one.tick_params(labelsize=theme.SMALL)
        one.grid(True)


def _counts(case: CaseStudy) -> str:
    """Say how many mountings have a path, and how many another one."""
    if case.study is None:
        return f"{case.name}: not studied" + (EDGES if touches_along_lines(case.design).all() else "")
    count, every = np.count_nonzero(case.study.mountings.solved), case.study.cases
    share = f"{count} of {every}" if count < every else f"all {every}"
    changed = f"{case.study.limits_changed()} ended by another limit"
    return f"{case.name}: {share} mountings have a path, {changed}"


def _shares(axes: Axes, side: Side) -> None:
    """Draw mountings that end at other limits, and those without a path, against the size of the
    tolerances."""
    axes.set_xlabel("times tolerances", fontsize=theme.SMALL, labelpad=1.0)
    axes.set_xscale("log")
    axes.set_xlim(FACTORS[0] / 1.1, 1.1 * FACTORS[-1])
    axes.set_xticks([1.0, 2.0, 5.0, 10.0], ["1", "2", "5", "10"])
    axes.minorticks_off()
    axes.set_ylim(-2.0, 102.0)
    for case in side.cases:
        for shares, dashes in zip(100.0 * case.shares, ("--", "-"), strict=True):
            axes.plot(FACTORS, shares, dashes, color=case.colour, linewidth=case.width)
    known = np.array([case.shares for case in side.cases])
    if np.isnan(known).all():
        theme.say(axes, side.reason, 18, **SAID)
    elif np.nanmax(known) < FEW:
        theme.say(axes, f"under {100.0 * FEW:g} %", 18, **SAID)


def _legend(page: theme.Page, data: tuple[Side, ...]) -> None:
    """Name the cases, what their curves show, and the clouds."""
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
    """List every mounting of every study as the command does, and the shares under larger tolerances; the
    `kind` says what a row is of."""
    cases = [(side.flank, case) for side in data for case in side.cases]
    tables = [
        None if case.study is None else table_of(ToleranceReport(case.name, case.design, case.study).rows())
        for _, case in cases
    ]
    header = max((table[0] for table in tables if table), key=len, default=[])
    shares = ("times_tolerances", "share_ended_elsewhere", "share_without_path")

    def each() -> Rows:
        """Give the columns of every study."""
        for (flank, case), table in zip(cases, tables, strict=True):
            who = flank, *solved.parabolas(case.design)
            if case.study is None or table is None:
                yield *who, case.reason, *[""] * (1 + len(header) + len(shares))
                continue
            columns = dict(zip(*table, strict=True))
            own = (columns.get(name, "") for name in header)
            yield *who, "mounting", list(range(case.study.cases)), *own, *[""] * len(shares)
            yield *who, "tolerances", *[""] * (1 + len(header)), list(FACTORS), *case.shares

    return ["flank", *solved.PARABOLAS, "kind", "mounting", *header, *shares], stacked(each())


RECIPES = {"tolerance-cloud": Recipe(compute, draw, rows)}
