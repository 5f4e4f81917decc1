"""Cloud of paths of contact under drawn assembly errors, and how contact ratio, error and position spread."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design, Tolerances, path_of_contact, tolerance_study
from beveloid_geom.analysis.errors import NAMES, errors_below, mounted
from beveloid_geom.analysis.tolerance import PLACES, USUAL_AT, ToleranceStudy, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.report.columns import ARCSEC, header_of
from beveloid_geom.report.tolerance import size_words
from beveloid_geom.report.words import status_name

from ...parts import charts, panels, solved, viewpoint
from ...parts.panels import Panel
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...parts.solved import FLANKS, SolvedPath, coefficients, modified
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import Picture

MOUNTINGS, DRAWN, SEED = 1024, 300, 0
"""Mountings of a study, and how many are drawn."""
POINTS = 33
FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0)
"""Times the tolerances of the last panels."""
FEW = 0.02
QUANTITIES = (
    ("contact_ratio", 1.0, "contact ratio"),
    ("peak_to_peak", ARCSEC, "transmission error (arcsec)"),
    ("pinion_z_middle", 1.0, "z of the pinion at mid-roll (mm)"),
)
"""Name, scale and label of what is shown of a study."""
SAID: dict[str, Any] = {"fontsize": theme.SMALL, "backgroundcolor": "white"}
LEFT, RIGHT = 0.05, 0.99  # shares of the page's width
CLOUD, GAP = 0.145, 0.058  # of a flank, and between charts
CHARTS = Cells(left=0.9, right=0.25, across=0.95, down=0.85, most=2, least=1.3)
WIDE, CLOUDS_WIDE, CLOUD_TALL = 9.0, 4.2, 3.4
"""Inches in print: of pages on which charts have room beside the clouds, and how much these take."""
CLOUDS = ((5.0, theme.GREEN, 0.07), (1.0, theme.BLUE, 0.08))
"""Times the tolerances, colour and opacity of the paths drawn, the lowest first."""
NOTE = (
    "Of the design as it is, {drawn} mountings (seed {seed}) are drawn, thin and translucent: blue with the"
    " tolerances, below them in green with {times:g} times the tolerances; in black without errors. Errors"
    " are {spread}: {sizes}, on top of the design's own; members stay mounted as without them. Curves: share"
    " of the mountings with a path whose value is at most that below; dots: without errors. Contact ratio by"
    " Eq. 16; transmission error of one tooth pair over its path, peak to peak, 0 without modification; z is"
    " positive towards the heel. Last panel: all tolerances times the factor, {all} mountings each, by"
    " which chance moves a share by up to 3 %."
)


@dataclass(frozen=True, eq=False)
class CaseStudy:
    """A case by its name and colour: its study, None with a `reason`; and by FACTORS the shares of mountings
    with a path that another limit ends, and of those without a path, NaN where not known (2, factors)."""

    name: str
    design: Design
    colour: str
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
    cases = ("as designed", design, theme.BLUE), (coefficients(bent), bent, theme.RED)
    return tuple(
        Side(
            flank,
            solved.solve(design, flank),
            tuple(_cloud_of(design, flank, factor) for factor, *_ in CLOUDS),
            tuple(_case(flank, *case) for case in cases),
        )
        for flank in FLANKS
    )


def _case(flank: str, name: str, design: Design, colour: str) -> CaseStudy:
    """Study a case on a flank, with the tolerances and with FACTORS times as much."""
    shares, usual = np.full((2, len(FACTORS)), np.nan), USUAL_AT[design.errors_at]
    try:
        study = tolerance_study(design, usual, flank, MOUNTINGS, seed=SEED)
    except ValueError as error:
        return CaseStudy(name, design, colour, None, shares, str(error))
    if not study.mountings.solved.any():
        return CaseStudy(name, design, colour, study, shares)
    for k, factor in enumerate(FACTORS):
        found = study
        if factor != 1.0:
            try:
                found = tolerance_study(design, _times(usual, factor), flank, MOUNTINGS, seed=SEED)
            except ValueError:
                break  # the tolerance is too large for the layout
        without = np.count_nonzero(~found.mountings.solved)
        shares[:, k] = found.limits_changed() / found.cases, without / found.cases
    return CaseStudy(name, design, colour, study, shares)


def _times(tolerances: Tolerances, factor: float) -> Tolerances:
    names = tolerances.names
    return replace(tolerances, **{name: factor * getattr(tolerances, name) for name in names})


def _cloud_of(design: Design, flank: str, factor: float) -> tuple[FloatArray, FloatArray]:
    """Give points of the drawn paths on pinion and gear; NaN without a path. Not under errors too large for
    the layout."""
    usual = USUAL_AT[design.errors_at]
    if any(factor * getattr(usual, name) >= most for name, most in errors_below(design).items()):
        return np.empty((0, POINTS, 3)), np.empty((0, POINTS, 3))
    errors = factor * drawn_errors(usual, SEED, 0, DRAWN)
    with np.errstate(invalid="ignore"):
        path = path_of_contact(mounted(design, errors, usual.names), flank, POINTS)
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


def _head(layout: theme.Layout) -> float:
    """Give the inches in print of the words over clouds and charts."""
    return 1.25 if layout.width > WIDE else 1.95


def _sections_in_print(page: theme.Page, low: float, high: float, count: int) -> list[Section]:
    """Lay out a block for each flank: charts two by two, and clouds beside them or, where that has no room,
    over them."""
    layout, height = page.layout, page.get_figheight()
    beside = layout.width > WIDE
    cells = replace(CHARTS, left=CHARTS.left + CLOUDS_WIDE) if beside else CHARTS
    bottoms, own = theme.rows(low, high, count, theme.inches(page, 0.5))
    found = []
    for bottom in bottoms:
        top = bottom + own - theme.inches(page, _head(layout))
        end = top if beside else top - theme.inches(page, CLOUD_TALL + 0.3)
        base = bottom + theme.inches(page, 0.55)
        room = (CLOUDS_WIDE if beside else layout.width - 0.4) / layout.width
        left, low_end = 0.2 / layout.width, base if beside else end + theme.inches(page, 0.3)
        found.append(
            Section(
                [(left + 0.5 * k * room, low_end, 0.48 * room, top - low_end) for k in (0, 1)],
                cells.boxes(layout, 4, height, base, end),
                (left, bottom + own),
                False,
                (left, bottom + own - theme.inches(page, 0.12)),
                int(8.0 * layout.width),
            )
        )
    return found


def draw(data: tuple[Side, ...], layout: theme.Layout) -> Drawing:
    """Draw for each flank the clouds on pinion and gear, the spread, and what larger tolerances do."""
    block = (
        CHARTS.tall(layout, 4, 1.8)
        + _head(layout)
        + 0.55
        + (0.0 if layout.width > WIDE else CLOUD_TALL + 0.3)
    )
    page, low, high = theme.new_page(
        layout,
        "Paths of contact under drawn assembly errors",
        "Cloud of paths on pinion and gear, and spread of contact ratio, transmission error and position",
        _note(data[0].cases[0].design),
        below=0.3,
        above=0.3,
        columns=viewpoint.COLUMNS,
        tall=len(data) * (block + 0.5) - 0.5,
    )
    sections = (_sections_in_print if layout.printed else _sections)(page, low, high, len(data))
    looks = [(side.nominal.design, side.flank, panels.STRETCH) for side in data]
    views = [panels.flank_views(*look, outside=True) for look in looks]
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


def _note(design: Design) -> str:
    """Say what is drawn, under which tolerances."""
    usual = USUAL_AT[design.errors_at]
    sizes = size_words(usual) + solved.at_the_mesh(design)
    spread = f"{usual.distribution}, the tolerances at {usual.sigmas:g} standard deviations"
    note = NOTE.format(drawn=DRAWN, all=MOUNTINGS, seed=SEED, spread=spread, sizes=sizes, times=CLOUDS[0][0])
    how = panels.how_drawn("right and left", panels.STRETCH, outside=True)
    return how.partition(" A path enters")[0] + " " + note


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
        one.set_xlabel(label, fontsize=theme.SMALL)
        for case in studies:
            assert case.study is not None
            charts.spread(one, case.study, name, scale, case.colour)
        if not studies:
            one.set_xticks([])
            theme.say(one, side.reason, 18, **SAID)
    axes[0].set_ylabel("share of the mountings (%)", fontsize=theme.SMALL, labelpad=2.0)
    _shares(axes[3], side)
    for one in axes:
        one.tick_params(labelsize=theme.SMALL)
        one.grid(True)


def _counts(case: CaseStudy) -> str:
    """Say how many mountings have a path, and how many another one."""
    if case.study is None:
        return f"{case.name}: not studied"
    count, every = np.count_nonzero(case.study.mountings.solved), case.study.cases
    share = f"{count} of {every}" if count < every else f"all {every}"
    changed = f"{case.study.limits_changed()} of these ended by another limit"
    return f"{case.name}: {share} mountings have a path on the flanks, {changed}"


def _shares(axes: Axes, side: Side) -> None:
    """Draw mountings that end at other limits, and those without a path, against the size of the
    tolerances."""
    axes.set_xlabel("times the tolerances", fontsize=theme.SMALL)
    axes.set_xscale("log")
    axes.set_xlim(FACTORS[0] / 1.1, 1.1 * FACTORS[-1])
    axes.set_xticks([1.0, 2.0, 5.0, 10.0], ["1", "2", "5", "10"])
    axes.minorticks_off()
    axes.set_ylim(-2.0, 102.0)
    for case in side.cases:
        for shares, dashes in zip(100.0 * case.shares, ("--", "-"), strict=True):
            axes.plot(FACTORS, shares, dashes, color=case.colour, linewidth=2.0)
    known = np.array([case.shares for case in side.cases])
    if np.isnan(known).all():
        theme.say(axes, side.reason, 18, **SAID)
    elif np.nanmax(known) < FEW:
        theme.say(axes, f"under {100.0 * FEW:g} %", 18, **SAID)


def _legend(page: theme.Page, data: tuple[Side, ...]) -> None:
    """Name the cases, what their curves show, and the clouds."""
    handles = [Line2D([], [], color=case.colour, label=case.name) for case in data[0].cases]
    black: dict[str, Any] = {"color": theme.INK, "linewidth": 2.0}
    handles.append(Line2D([], [], ls="--", label="another limit ends the path", **black))
    handles.append(Line2D([], [], label="no path on the flanks", **black))
    drawn = [
        Line2D([], [], color=hue, linewidth=6.0, alpha=0.6, label=f"{factor:g} \u00d7 tolerances")
        for factor, hue, _ in reversed(CLOUDS)
    ]
    theme.legend(page, handles, 4, 1.15, fontsize=theme.SMALL)
    theme.legend(page, drawn, 2, 1.15, 0.03, fontsize=theme.SMALL)


def rows(data: tuple[Side, ...]) -> Table:
    """List every mounting of every study: its errors, what it has; then shares under larger tolerances."""
    names = NAMES[data[0].cases[0].design.errors_at]
    errors = [header_of(f"{name}_error") for name in names]
    header = [
        "flank",
        *solved.PARABOLAS,
        "mounting",
        *errors,
        "status",
        "contact_ratio",
        "transmission_error_rad",
    ]
    header += [f"{member}_z_{place}_mm" for member in solved.MEMBERS for place in PLACES]
    shares = ("times_tolerances", "share_ended_elsewhere", "share_without_path")

    def cases() -> Rows:
        """Give the columns of every study."""
        for flank, case in ((side.flank, case) for side in data for case in side.cases):
            who = flank, *solved.parabolas(case.design)
            if case.study is None:
                yield *who, *[""] * (1 + len(names)), case.reason, *[""] * (len(header) - 2 - len(names))
                continue
            found = case.study.mountings
            status = [status_name(code) for code in found.status]
            measures = found.contact_ratio, found.peak_to_peak, *found.pinion_z.T, *found.gear_z.T
            yield *who, np.arange(len(status)), *found.errors.T, status, *measures, "", "", ""
            yield *who, *[""] * (len(header) - 3), list(FACTORS), *case.shares

    return [*header, *shares], stacked(cases())


RECIPES = {"tolerance-cloud": Recipe(compute, draw, rows)}
