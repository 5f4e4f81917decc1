"""Small pictures of the paper's statements: the numbers on which the verdict on each rests.

Each has a function that finds its lines and one that draws them. Paths are the pinion's in the side view.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from beveloid_geom import Design, Errors, path_of_contact
from beveloid_geom.analysis.path_measures import POINTS, STEPS, added_metal, near_ends
from beveloid_geom.gear.flank import flank_point, root_parameter, tip_radius, trace_parameter
from beveloid_geom.studies.claims import (
    ANGLE_ERROR,
    DRAWN,
    LITTLE,
    MODIFIED,
    NOTICEABLE,
    OFFSET_ERROR,
    SWEEPS,
    Case,
)
from beveloid_geom.studies.statement_verdicts import Statement

from ..stage import theme
from .map_panel import HALO
from .solved import MEMBERS

SHOWN = np.linspace(0, STEPS - 1, 5).astype(int)
"""Of the coefficients of a sweep, those whose paths are drawn."""
BORDER = 31
"""Points of the lines of root and tip."""
TURNED = ("C1", "C4", "C2", "C3")
TURNS = {"in all": "turn over the range", "by a": "turn by coefficient"}
"""Sweeps in the order of the numbers of D1; words for the ways in which they are measured."""
MARKERS = {"along the face": "o", "square": "s", "at mid-roll": "^"}
"""By how the name of a way to measure a shift begins."""
PATH, RATIO = "path", "ratio"
LIMITS = {PATH: NOTICEABLE, RATIO: LITTLE}
"""Shares under which M6 holds."""
RAMP = ("0.75", "0.6", "0.45")
"""Greys of the coefficients between none and the greatest."""
SIDE = 0.6
"""Share of half the face from which a label stands on the inner side of its place."""
LETTER = 0.6
"""Width of a letter over its size, about."""
NOTHING = "no path of contact on the flanks"


@dataclass(frozen=True, eq=False)
class Line:
    """A line, or a mark, of a picture by its `kind`: what is drawn by the columns of the table, each a
    number, a word, or an array (n,); a `label` stands at its end."""

    kind: str
    columns: Mapping[str, Any]
    label: str = ""

    def __getitem__(self, name: str) -> Any:
        """Give a column."""
        return self.columns[name]


Lines: TypeAlias = tuple[Line, ...]


@dataclass(frozen=True)
class Picture:
    """How the lines of a statement's picture are found, and how they are drawn."""

    find: Callable[[Case, Statement], Lines]
    draw: Callable[[Axes, Lines], None]


def number(value: float) -> str:
    """Give a number with a true minus."""
    return f"{value:g}".replace("-", "\u2212")


def _coefficients(pinion: float, gear: float) -> dict[str, float]:
    return {"parabola_pinion_per_mm": pinion + 0.0, "parabola_gear_per_mm": gear + 0.0}


def _side_view(case: Case, design: Design, told: Sequence[tuple[str, Mapping[str, float]]]) -> Lines:
    """Find the flank and the paths of a design with one batch axis, `told` apart by labels and columns."""
    path, roll = path_of_contact(design, case.flank, POINTS), np.linspace(0.0, 1.0, POINTS)
    member = case.design.pinion
    z = 0.5 * float(member.face_width) * np.linspace(-1.0, 1.0, BORDER)
    l = root_parameter(member)
    point = flank_point(member, case.flank, l, trace_parameter(member, case.flank, l, z))
    borders = {"root": np.hypot(point[:, 0], point[:, 1]), "tip": tip_radius(member, z)}
    return (
        *(Line(name, {"z_mm": z, "r_mm": r}) for name, r in borders.items()),
        *(
            Line("path", {**own, "roll_share": roll, "z_mm": along, "r_mm": up}, label)
            for (label, own), along, up in zip(told, path.pinion_z, path.pinion_r, strict=True)
        ),
    )


def _swept(case: Case, statement: Statement) -> Lines:
    """Find paths under coefficients of a sweep."""
    pinion, gear, greatest = SWEEPS[statement.id]
    size = np.linspace(0.0, greatest, STEPS)[SHOWN]
    told = [
        (number(pinion * a) if a == greatest else "", _coefficients(pinion * a, gear * a))
        for a in size.tolist()
    ]
    return _side_view(case, case.design.with_parabola(pinion * size, gear * size), told)


def _misaligned(field: str, size: float, column: str, unit: str, case: Case, _: Statement) -> Lines:
    """Find the paths of the design without modification under an error of -size, 0 and +size."""
    errors = size * np.array([-1.0, 0.0, 1.0])
    shown = np.degrees(errors) if unit == "\u00b0" else errors
    told = [
        (f"{'+' if at > 0.0 else ''}{number(at)}{unit}" if at else "", {column: error})
        for error, at in zip(errors.tolist(), shown.tolist(), strict=True)
    ]
    return _side_view(case, case.design.with_errors(Errors(**{field: errors})), told)


def _both_paths(case: Case, statement: Statement) -> Lines:
    """Find the path without modification and with it, and how long they are."""
    lengths = statement.claims[0].numbers["pinion, side view"].tolist()
    both = np.array([(0.0, 0.0), MODIFIED])
    told = [
        (f"{length:.4g}" if np.isfinite(length) else "", {**_coefficients(*own), "length_mm": length})
        for length, own in zip(lengths, both.tolist(), strict=True)
    ]
    return _side_view(case, case.design.with_parabola(*both.T), told)


def _metal(case: Case, _: Statement) -> Lines:
    """Find the metal that coefficients leave on the pinion's profile, and that near root and tip."""
    lines = []
    for a in (DRAWN, -DRAWN):
        r, added = added_metal(case.design.pinion, case.flank, case.sign * a)
        label, own = f"a = {'+' if a > 0.0 else ''}{number(a)}", {"parabola_pinion_per_mm": a}
        near = near_ends(r.size)
        few = np.unique([*range(0, r.size, 20), r.size - 1])
        lines += [
            Line("profile", {**own, "r_mm": r[few], "added_metal_mm": added[few]}, label),
            Line("near root and tip", {**own, "r_mm": r[near], "added_metal_mm": added[near]}),
        ]
    return tuple(lines)


def _ratios(sweep: str, case: Case, statement: Statement) -> Lines:
    """Take the contact ratios of a sweep, with toe and heel and without."""
    pinion, gear, greatest = SWEEPS[sweep]
    size = np.linspace(0.0, greatest, STEPS)
    both = {"parabola_pinion_per_mm": pinion * size + 0.0, "parabola_gear_per_mm": gear * size + 0.0}
    ways = statement.claims[0].numbers
    return tuple(Line(way, {**both, "contact_ratio": ratio}) for way, ratio in ways.items())


def _turns(case: Case, statement: Statement) -> Lines:
    """Take by how much the pinion's path turns in each sweep, as shares of the most."""
    columns = dict(zip(TURNS, ("turn_deg", "turn_by_coefficient_deg_mm"), strict=True))
    return tuple(
        Line(
            words,
            {"sweep": list(TURNED), columns[words]: turns, "share_of_most": turns / np.fmax.reduce(turns)},
        )
        for words, way in TURNS.items()
        for turns in [statement.claims[0].numbers[f"pinion, {way}"]]
    )


def _smaller(case: Case, statement: Statement) -> Lines:
    """Take the shifts with modification over those without, of both members in all ways."""
    ways = statement.claims[0].numbers
    return tuple(
        Line(way.partition(", ")[0], {"way": way, "modified_over_unmodified": row[1] / row[0]})
        for way, row in ways.items()
    )


def _axial(case: Case, statement: Statement) -> Lines:
    """Take the greater change under -/+ an axial error, in all ways."""
    return tuple(
        Line(kind, {"way": way, "change_share": np.max(row), "limit_share": LIMITS[kind]})
        for kind, claim in zip(LIMITS, statement.claims, strict=True)
        for way, row in claim.numbers.items()
    )


def _draw_view(looks: Sequence[Mapping[str, Any]], axes: Axes, lines: Lines) -> None:
    """Draw flank and paths, a dot in the middle of each path's roll, as long across as along."""
    paths = tuple(line for line in lines if line.kind == "path")
    borders = [line for line in lines if line.kind != "path"]
    for line in borders:
        axes.plot(line["z_mm"], line["r_mm"], color=theme.GREY, linewidth=1.2)
    for end in (0, -1):
        axes.plot(
            *([line[name][end] for line in borders] for name in ("z_mm", "r_mm")), color=theme.GREY, lw=1.2
        )
    for line, look in zip(paths, looks, strict=True):
        z, r = line["z_mm"], line["r_mm"]
        axes.plot(z, r, **look)
        middle = line["roll_share"] == 0.5
        axes.plot(z[middle], r[middle], "o", color=look["color"], ms=4.0)
    _label_paths(axes, paths, looks, borders[-1])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.03)
    axes.set_xlabel("toe    z (mm)    heel", fontsize=theme.SMALL)
    axes.set_ylabel("r (mm)", fontsize=theme.SMALL)
    if not any(np.isfinite(line["z_mm"]).any() for line in paths):
        theme.say(axes, NOTHING, 24, fontsize=theme.SMALL)


def _label_paths(axes: Axes, paths: Lines, looks: Sequence[Mapping[str, Any]], tip: Line) -> None:
    """Write labels over the ends of paths and over the tip: outwards at the outer ones, inwards near toe and
    heel; inwards and each higher than the one before it where they do not fit beside each other."""
    ends = sorted(
        (float(line["z_mm"][-1]), float(line["r_mm"][-1]), line.label, look["color"])
        for line, look in zip(paths, looks, strict=True)
        if line.label and np.isfinite(line["z_mm"][-1])
    )
    room = axes.get_window_extent().width * 72.0 / axes.figure.dpi
    stacked = LETTER * theme.SMALL * sum(len(label) for *_, label, _ in ends[1:]) > 0.5 * room
    inner = 0.0 if stacked else SIDE * tip["z_mm"][-1]
    for k, (z, r, label, colour) in enumerate(ends):
        side = "right" if k == 0 else "left" if k == len(ends) - 1 else "center"
        side = "left" if z < -inner else "right" if z > inner else side
        over = max(r, float(np.interp(z, tip["z_mm"], tip["r_mm"])))
        above = 3.0 + k * theme.SMALL if stacked else 3.0
        theme.beside(axes, (z, over), label, (0.0, above), ha=side, **_small(colour))


def _small(colour: str) -> dict[str, Any]:
    return {"fontsize": theme.SMALL, "color": colour, "va": "bottom", "path_effects": HALO}


def _draw_metal(axes: Axes, lines: Lines) -> None:
    """Draw the metal over the radius, dots near root and tip."""
    for line in lines:
        r, added = line["r_mm"], line["added_metal_mm"]
        positive = line["parabola_pinion_per_mm"] > 0.0
        look: dict[str, Any] = {"color": theme.RED if positive else theme.BLUE}
        if line.kind == "profile":
            axes.plot(r, added, lw=2.0, ls="-" if positive else "--", **look)
            at = r.size // 2
            away = (0.0, 10.0 if positive else -10.0)
            style = {**_small(look["color"]), "va": "bottom" if positive else "top", "ha": "center"}
            theme.beside(axes, (r[at], added[at]), line.label, away, **style)
        else:
            axes.plot(r, added, "o", ms=5.0, **look)
    axes.axhline(0.0, color=theme.GREY, lw=0.8)
    axes.set_xlabel("r of the pinion (mm)", fontsize=theme.SMALL)
    axes.set_ylabel("metal (mm)", fontsize=theme.SMALL)
    if not any(np.isfinite(line["added_metal_mm"]).any() for line in lines):
        theme.say(axes, "the tool cannot cut these flanks", 24, fontsize=theme.SMALL)


def _draw_ratios(axes: Axes, lines: Lines) -> None:
    """Draw the contact ratios over the pinion's coefficient, and where they start."""
    looks: tuple[dict[str, Any], ...] = (
        {"color": theme.BLUE, "lw": 2.5},
        {"color": theme.INK, "lw": 1.5, "ls": "--"},
    )
    for line, look in zip(lines, looks, strict=True):
        axes.plot(line["parabola_pinion_per_mm"], line["contact_ratio"], **look)
    first = lines[0]
    a, ratios = first["parabola_pinion_per_mm"], np.concatenate([line["contact_ratio"] for line in lines])
    axes.set_xlim(a[0], a[-1])
    axes.set_xticks(a[[0, -1]], [number(at) for at in a[[0, -1]]])
    axes.get_xticklabels()[-1].set_horizontalalignment("right")
    axes.set_xlabel("a of the pinion (1/mm)", fontsize=theme.SMALL)
    axes.set_ylabel("ratio", fontsize=theme.SMALL)
    if not np.isfinite(ratios).any():
        theme.say(axes, NOTHING, 24, fontsize=theme.SMALL)
        return
    axes.axhline(first["contact_ratio"][0], color=theme.GREY, lw=1.0, ls=":")
    room = max(0.12 * float(np.nanmax(ratios) - np.nanmin(ratios)), 0.02)
    axes.set_ylim(float(np.nanmin(ratios)) - room, float(np.nanmax(ratios)) + room)


def _draw_turns(axes: Axes, lines: Lines) -> None:
    """Draw bars of the turns, a group for each way; those that are to be greater are dark."""
    places, names = [], []
    for group, line in enumerate(lines):
        at = 5.0 * group + np.arange(len(TURNED))
        colours = [theme.BLUE, theme.BLUE, theme.PALE, theme.PALE]
        axes.bar(at, line["share_of_most"], 0.75, color=colours, edgecolor=theme.BLUE, linewidth=1.0)
        axes.text(at.mean(), 1.06, line.kind, ha="center", va="bottom", fontsize=theme.SMALL)
        places += at.tolist()
        names += [name[1:] for name in line["sweep"]]
        if not np.isfinite(line["share_of_most"]).any():
            axes.text(at.mean(), 0.5, "not known", ha="center", va="center", fontsize=theme.SMALL)
    axes.set_xticks(places, names)
    axes.tick_params(axis="x", length=0.0)
    axes.set(xlim=(-0.8, 8.8), ylim=(0.0, 1.45), yticks=[0.0, 0.5, 1.0])
    axes.set_xlabel("of C1, C4, C2, C3", fontsize=theme.SMALL)
    axes.set_ylabel("of the most", fontsize=theme.SMALL)


def _strip(axes: Axes, rows: Sequence[str], name: str, scale: float, lines: Lines) -> None:
    """Draw marks in rows by the kind of their line, each way at a height of its own in the row."""
    height = dict.fromkeys(rows, 0.0)
    count = {kind: sum(line.kind == kind for line in lines) for kind in rows}
    for line in lines:
        y = rows.index(line.kind) + 0.7 * ((height[line.kind] + 0.5) / count[line.kind] - 0.5)
        height[line.kind] += 1.0
        marker = next((mark for words, mark in MARKERS.items() if f" {words}" in line["way"]), "D")
        axes.plot(scale * line[name], y, marker, color=theme.BLUE, ms=5.0, mfc="none", mew=1.3)
    axes.set(ylim=(len(rows) - 0.5, -0.5))
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(axis="y", length=0.0)
    axes.axhline(0.5, color=theme.PALE, lw=0.8)
    if not any(np.isfinite(line[name]) for line in lines):
        theme.say(axes, "no path", fontsize=theme.SMALL, backgroundcolor="white")


def _draw_smaller(axes: Axes, lines: Lines) -> None:
    """Draw the quotients of the shifts of both members, and where they are equal."""
    _strip(axes, MEMBERS, "modified_over_unmodified", 1.0, lines)
    axes.axvline(1.0, color=theme.INK, lw=1.2)
    values = np.array([line["modified_over_unmodified"] for line in lines])
    reach = 1.15 * float(np.abs(values[np.isfinite(values)] - 1.0).max(initial=0.2))
    axes.set_xlim(1.0 - reach, 1.0 + reach)
    axes.set_xlabel("modified / unmodified", fontsize=theme.SMALL)


def _draw_axial(axes: Axes, lines: Lines) -> None:
    """Draw the changes in percent, and the limits under which they are little."""
    _strip(axes, list(LIMITS), "change_share", 100.0, lines)
    limits = {line.kind: 100.0 * line["limit_share"] for line in lines}
    for row, limit in enumerate(limits.values()):
        axes.plot([limit, limit], [row - 0.45, row + 0.45], color=theme.INK, lw=2.0)
    values = [100.0 * line["change_share"] for line in lines]
    axes.set_xlim(-0.08, 1.15 * max(*limits.values(), *(v for v in values if np.isfinite(v))))
    axes.set_xlabel("change (%)", fontsize=theme.SMALL)


def few_ticks(axes: Axes) -> None:
    """Make ticks few and small, where they are not given."""
    axes.tick_params(labelsize=theme.SMALL, pad=2.0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.labelpad = 1.0
        if axis.get_major_formatter().__class__.__name__ == "ScalarFormatter":
            axis.set_major_locator(MaxNLocator(3 if axis is axes.yaxis else 5))


_SWEPT: tuple[dict[str, Any], ...] = (
    {"color": theme.INK, "lw": 2.0, "ls": "--"},
    *({"color": grey, "lw": 1.4} for grey in RAMP),
    {"color": theme.RED, "lw": 3.0},
)
_ERRORS: tuple[dict[str, Any], ...] = (
    {"color": theme.MINUS, "lw": 2.5, "ls": "--"},
    {"color": theme.ZERO, "lw": 2.0},
    {"color": theme.PLUS, "lw": 2.5, "ls": ":"},
)
_SWEEP = Picture(_swept, partial(_draw_view, _SWEPT))
PICTURES = {
    "F6": Picture(_metal, _draw_metal),
    **dict.fromkeys(SWEEPS, _SWEEP),
    **{f"R{k}": Picture(partial(_ratios, sweep), _draw_ratios) for k, sweep in enumerate(SWEEPS, 1)},
    "D1": Picture(_turns, _draw_turns),
    "M1": Picture(
        partial(_misaligned, "offset", OFFSET_ERROR, "offset_error_mm", " mm"), partial(_draw_view, _ERRORS)
    ),
    "M2": Picture(
        partial(_misaligned, "shaft_angle", ANGLE_ERROR, "shaft_angle_error_rad", "\u00b0"),
        partial(_draw_view, _ERRORS),
    ),
    "M3": Picture(_both_paths, partial(_draw_view, (_SWEPT[0], _SWEPT[-1]))),
    "M4": Picture(_smaller, _draw_smaller),
    "M5": Picture(_smaller, _draw_smaller),
    "M6": Picture(_axial, _draw_axial),
}
