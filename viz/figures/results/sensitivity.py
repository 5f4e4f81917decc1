"""Sensitivity to the four assembly errors: exact derivatives on both flanks, two sets of coefficients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom.analysis.sensitivity import Sensitivity, path_sensitivity
from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Design
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.sensitivity import STEPS
from beveloid_geom.status import Status

from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import REASONS
from ...stage import theme
from ...stage.scene import Size
from ...stage.theme import Page

MODIFIED = (0.001, -0.001)
"""Parabola coefficients of pinion and gear in the second case, 1/mm."""
FLANKS = {"right": theme.BLUE, "left": theme.RED}
MEMBERS = {"pinion": "o", "gear": "D"}
MIDDLE = 1  # of the places of a path
ROWS = tuple((flank, member) for flank in FLANKS for member in MEMBERS)
LEFT, RIGHT = 0.17, 0.995  # shares of the page's width
ZERO = 1e-9
"""Values below this share of the panel's greatest are rounding."""
DECADES = 2.0
"""Decades under that of the greatest value that are drawn in logarithm; the rest is linear."""
STEP_SIZES = np.array([np.radians(size) if unit == "deg" else size for _, size, unit in STEPS])
NOTE = (
    "Exact derivatives at the design's own errors, times the errors named. The shift is that of the middle"
    " of the path: along the face, of z at equal flank parameter l; square, on the flank at right angles to"
    " the path; both positive towards the heel. The contact ratio is Eq. 16; the transmission error is"
    " that of one tooth pair over its path, peak to peak, and 0 without modification under every error."
    " Scales are linear about 0 and logarithmic beyond the first marked value to either side."
)


class Quantity(NamedTuple):
    """A column of panels: title, name and unit of the numbers, of both members or of the pair."""

    title: str
    name: str
    unit: str
    scale: float
    members: bool


QUANTITIES = (
    Quantity("shift along the face (mm)", "face_shift", "mm", 1.0, True),
    Quantity("shift square to the path (mm)", "square_shift", "mm", 1.0, True),
    Quantity("contact ratio (10$^{\u22123}$)", "contact_ratio", "1e-3", 1e3, False),
    Quantity("transmission error (arcsec)", "peak_to_peak", "arcsec", ARCSEC, False),
)


@dataclass(frozen=True, eq=False)
class Case:
    """One set of coefficients: the sensitivity of each flank."""

    name: str
    found: dict[str, Sensitivity]

    def values(self, quantity: Quantity) -> dict[tuple[str, ...], FloatArray]:
        """Changes (4 errors,) by flank and member, or by flank; NaN where not known."""
        found: dict[tuple[str, ...], FloatArray] = {}
        for flank, rates in self.found.items():
            by = quantity.scale * getattr(rates, f"{quantity.name}_by") * STEP_SIZES
            if quantity.members:
                found |= {(flank, member): by[MIDDLE, j] for j, member in enumerate(MEMBERS)}
            else:
                found[(flank,)] = by
        return found

    @property
    def remarks(self) -> str:
        """What is missing, and why."""
        words = []
        for flank, rates in self.found.items():
            status = Status(int(rates.status))
            if status != Status.SOLVED:
                reason = REASONS.get(status, "nothing to solve")
                words.append(f"{flank} flanks: no path of contact, {reason}")
            elif np.isnan(rates.face_shift_by[MIDDLE]).any():
                words.append(f"{flank} flanks: no middle, the roll turns back along the path")
        return "; ".join(words)


def compute(design: Design) -> tuple[Case, ...]:
    """Both cases, both flanks."""
    a1, a2 = (f"{a:g}".replace("-", "\u2212") for a in MODIFIED)
    cases = (
        ("as designed", design),
        (f"$a_1$ = {a1}, $a_2$ = {a2} mm$^{{\u22121}}$", design.with_parabola(*MODIFIED)),
    )
    return tuple(Case(name, {flank: path_sensitivity(one, flank) for flank in FLANKS}) for name, one in cases)


def draw(data: tuple[Case, ...], size: Size) -> Drawing:
    """A row of panels for each case, a column for each quantity."""
    page = theme.new_page(
        size,
        "Sensitivity of the path of contact to assembly errors",
        "Changes under the errors named on the left, from exact derivatives",
    )
    low = theme.caption(page, NOTE) + theme.inches(page, 0.45)
    high, gap = theme.top(page) - theme.inches(page, 0.75), theme.inches(page, 1.1)
    height = (high - low - gap * (len(data) - 1)) / len(data)
    step = (RIGHT - LEFT) / len(QUANTITIES)
    limits = [_greatest(data, quantity) for quantity in QUANTITIES]
    for row, case in enumerate(data):
        bottom = high - height - row * (height + gap)
        y = bottom + height + theme.inches(page, 0.42)
        page.text(0.025, y, f"({'ab'[row]})  {case.name}", fontsize=theme.HEADING, va="bottom")
        page.text(RIGHT, y, case.remarks, fontsize=theme.SMALL, va="bottom", ha="right")
        for column, quantity in enumerate(QUANTITIES):
            axes = page.add_axes((LEFT + column * step, bottom, 0.9 * step, height))
            _panel(axes, quantity, case.values(quantity), limits[column])
            if column == 0:
                _row_labels(axes)
    _legend(page)
    return Drawing(page, {})


def _greatest(data: tuple[Case, ...], quantity: Quantity) -> float:
    """Greatest value of a column of panels; 0 if there is none."""
    values = np.abs([row for case in data for row in case.values(quantity).values()])
    return float(values[np.isfinite(values)].max(initial=0.0))


def _panel(
    axes: Axes, quantity: Quantity, values: dict[tuple[str, ...], FloatArray], greatest: float
) -> None:
    axes.set_title(quantity.title, fontsize=theme.LABEL, pad=6.0)
    axes.set_ylim(len(STEPS) * _block() - 1.0, -1.0)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    for k in range(0, len(STEPS), 2):
        axes.axhspan(k * _block() - 1.0, (k + 1) * _block() - 1.0, color=theme.PALE, alpha=0.35, lw=0.0)
    axes.axvline(0.0, color=theme.GREY, linewidth=1.0)
    rows = np.array(list(values.values()))
    if not rows[np.isfinite(rows)].any():
        axes.set_xlim(-1.0, 1.0)
        axes.set_xticks([0.0])
        known = np.isfinite(rows).any()
        text = "0 under every error" if known else "not known"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", backgroundcolor="white")
        return
    ticks = 10.0 ** (np.floor(np.log10(greatest)) - np.array([DECADES, 0.0]))
    axes.set_xscale("symlog", linthresh=float(ticks[0]), linscale=1.5)
    axes.set_xlim(-300.0 * greatest, 300.0 * greatest)
    marks = np.concatenate((-ticks[::-1], [0.0], ticks))
    texts = [f"{mark:g}".replace("-", "\u2212") for mark in marks]
    texts[1] = ""  # where the scale changes; with its sign it would run into its neighbours
    axes.set_xticks(marks, texts, fontsize=theme.SMALL)
    axes.minorticks_off()
    for key, row in values.items():
        _lollipops(axes, key, np.where(np.abs(row) > ZERO * greatest, row, 0.0 * row))


def _block() -> int:
    """Lines that an error takes: one for each flank and member, and one between."""
    return len(ROWS) + 1


def _lollipops(axes: Axes, key: tuple[str, ...], row: FloatArray) -> None:
    """A stem from zero and the value at its end, for each error."""
    lines = [i for i, name in enumerate(ROWS) if name[: len(key)] == key]
    colour, marker = FLANKS[key[0]], MEMBERS[key[1]] if len(key) > 1 else "s"
    for k, value in enumerate(row.tolist()):
        y = k * _block() + float(np.mean(lines))
        if np.isnan(value):
            axes.text(0.0, y, "  not known", color=colour, va="center", fontsize=theme.SMALL)
            continue
        axes.plot([0.0, value], [y, y], color=colour, linewidth=2.0)
        axes.plot([value], [y], marker, color=colour, ms=6.5, mfc=colour if marker != "D" else "white")
        side = -1.0 if value < 0.0 else 1.0
        style: dict[str, Any] = {"ha": "left" if side > 0.0 else "right", "va": "center", "color": colour}
        style |= {"xytext": (8.0 * side, -0.5), "textcoords": "offset points", "fontsize": theme.SMALL}
        axes.annotate(_shown(value), (value, y), **style)


def _shown(value: float) -> str:
    """Three digits, the sign and no exponent."""
    if value == 0.0:
        return "0"
    digits = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return theme.signed(value, min(digits, 6))


def _row_labels(axes: Axes) -> None:
    """The errors, and the rows of each."""
    style: dict[str, Any] = {"va": "center", "clip_on": False, "transform": axes.get_yaxis_transform()}
    for k, (name, size, unit) in enumerate(STEPS):
        middle = k * _block() + 0.5 * (len(ROWS) - 1)
        error = f"{name.replace(' ', chr(10))}\n+{size:g} {unit}"
        axes.text(-0.76, middle, error, ha="left", fontsize=theme.LABEL, fontweight="bold", **style)
        for i, (flank, member) in enumerate(ROWS):
            text = f"{flank}, {member}"
            axes.text(
                -0.1,
                k * _block() + i,
                text,
                ha="right",
                fontsize=theme.SMALL,
                color=FLANKS[flank],
                **style,
            )


def _legend(page: Page) -> None:
    style: dict[str, Any] = {"color": theme.INK, "linewidth": 2.0, "ms": 6.5}
    handles = [Line2D([], [], color=colour, label=f"{flank} flank") for flank, colour in FLANKS.items()]
    handles += [
        Line2D([], [], marker=marker, mfc=theme.INK if member == "pinion" else "white", label=member, **style)
        for member, marker in MEMBERS.items()
    ]
    handles.append(Line2D([], [], marker="s", label="pair", **style))
    page.legend(
        handles=handles,
        loc="upper right",
        bbox_to_anchor=(0.985, 1.0 - theme.inches(page, 0.75)),
        ncols=5,
        borderaxespad=0.0,
    )


def rows(data: tuple[Case, ...]) -> Table:
    """Every value, and its derivative by mm or rad."""
    header = ["case", "flank", "quantity", "member", "error", "step", "step_unit", "change", "unit"]
    header.append("derivative_per_mm_or_rad")

    def body() -> Iterator[list[object]]:
        for case in data:
            for quantity in QUANTITIES:
                for key, row in case.values(quantity).items():
                    member = key[1] if len(key) > 1 else ""
                    for (name, size, unit), true, value in zip(STEPS, STEP_SIZES, row.tolist(), strict=True):
                        yield [
                            case.name.replace("$", ""),
                            key[0],
                            quantity.name,
                            member,
                            name,
                            size,
                            unit,
                            value,
                            quantity.unit,
                            value / float(true) / quantity.scale,
                        ]

    return header, body()


RECIPES = {"sensitivity": Recipe(compute, draw, rows)}
