"""Transmission error of the pair in operation, with its amplitudes at the mesh frequency's multiples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from beveloid_geom.contact import Limit
from beveloid_geom.first_contact import FirstContact, first_contact
from beveloid_geom.inputs import Design, FloatArray
from beveloid_geom.operation import Cycle, mesh_cycle, operating_ratio
from beveloid_geom.path import contact_ratio

from .. import theme
from ..recipe import Drawing, Recipe, Table
from ..theme import Page, Size

FLANK = "right"
CASES: tuple[tuple[str, tuple[float, float] | None], ...] = (
    ("as designed", None),
    ("$a_1$ = \u2212$a_2$ = 0.001 mm$^{-1}$", (0.001, -0.001)),
    ("$a_1$ = $a_2$ = 0.0002 mm$^{-1}$", (0.0002, 0.0002)),
)
POINTS = 361
"""Rolls of one mesh cycle."""
PITCHES = 3
HARMONICS = 10
FILM = 0.00635
"""mm: thickness of marking compound."""
ARCSEC = 3600.0 * 180.0 / np.pi
SMALLEST = 1e-6
"""arcsec: below it a curve counts as zero."""
NOTE = (
    "Rigid teeth without load: at each position the first of all teeth touches, with its flank or an edge"
    " (tip, toe, heel). The error is gear roll plus N1/N2 pinion roll, less that of the unmodified pair"
    " without errors and less its mean; it repeats with the pinion's pitch. Dots: another tooth pair takes"
    " over. The operating contact ratio is the roll over which one pair touches, over the pitch, and in"
    f" brackets that over which it is within {1e3 * FILM:g} \u00b5m of touching; Eq. 16 knows the limits of"
    " one tooth pair only."
)


@dataclass(frozen=True, eq=False)
class Case:
    """One case: its cycle, its first contacts at `share` of a pitch, and its three ratios."""

    name: str
    cycle: Cycle
    share: FloatArray
    first: FirstContact
    eq16: float
    operating: float
    within_film: float

    @property
    def edge(self) -> NDArray[np.bool_]:
        """Whether an edge carries, by position."""
        return np.asarray(self.first.limit[:, 0] >= 0)


def compute(design: Design) -> tuple[Case, ...]:
    """Cycle and ratios of every case."""
    cases = []
    for name, parabola in CASES:
        changed = design if parabola is None else design.with_parabola(*parabola)
        cycle = mesh_cycle(changed, FLANK, HARMONICS)
        share = np.linspace(0.0, 1.0, POINTS)
        first = first_contact(changed, FLANK, float(cycle.start) + cycle.pitch * share)
        ratios = (float(operating_ratio(changed, FLANK, film)) for film in (0.0, FILM))
        cases.append(Case(name, cycle, share, first, float(contact_ratio(changed, FLANK)), *ratios))
    return tuple(cases)


def draw(data: tuple[Case, ...], size: Size) -> Drawing:
    """A row for each case: the curve, and its amplitudes."""
    page = theme.new_page(
        size,
        "Transmission error in operation, hand-over between tooth pairs included",
        f"{FLANK.capitalize()} flanks, the pinion drives; {PITCHES} mesh cycles, and the amplitudes at"
        " multiples of the mesh frequency",
    )
    low = theme.caption(page, NOTE) + theme.inches(page, 0.65)
    gap = theme.inches(page, 0.95)
    high = theme.top(page) - theme.inches(page, 0.4)
    height = (high - low - gap * (len(data) - 1)) / len(data)
    for row, case in enumerate(data):
        bottom = high - height - row * (height + gap)
        curve = page.add_axes((0.075, bottom, 0.555, height))
        bars = page.add_axes((0.72, bottom, 0.265, height))
        _curve(page, curve, case, row)
        _bars(bars, case)
        if row == len(data) - 1:
            curve.set_xlabel("pinion roll from the pitch point (pitches)")
            bars.set_xlabel("multiple of the mesh frequency")
    return Drawing(page, {})


def _curve(page: Page, axes: Axes, case: Case, row: int) -> None:
    axes.set_title(f"({'abc'[row]})  {case.name}", loc="left", pad=8.0)
    summary = (
        f"contact ratio by Eq. 16 {case.eq16:.3f}, operating {case.operating:.3f} ({case.within_film:.3f})"
    )
    axes.set_title(summary, loc="right", pad=8.0, fontsize=theme.SMALL)
    axes.set_ylabel("error (arcsec)")
    axes.grid(True)
    axes.set_xlim(0.0, PITCHES)
    error = ARCSEC * (case.first.transmission_error - float(case.cycle.mean))
    if not np.isfinite(error).any():
        axes.text(0.5, 0.5, "no first contact was found", transform=axes.transAxes, ha="center")
        return
    share = np.concatenate([case.share + pitch for pitch in range(PITCHES)])
    error, edge = np.tile(error, PITCHES), np.tile(case.edge, PITCHES)
    axes.plot(share, np.where(edge, np.nan, error), color=theme.BLUE, label="flank on flank")
    axes.plot(share, np.where(edge, error, np.nan), color=theme.RED, label="edge contact")
    changes = case.cycle.changes[case.cycle.hand_over] - float(case.cycle.start)
    at = np.concatenate([changes / case.cycle.pitch + pitch for pitch in range(PITCHES)])
    axes.plot(at, np.interp(at, share, error), "o", color=theme.INK, ms=6.0, label="hand-over")
    swing = float(np.nanmax(error) - np.nanmin(error))
    if swing < SMALLEST:
        axes.set_ylim(-1.0, 1.0)
        text = f"peak to peak under {SMALLEST:g} arcsec: zero but for rounding"
        axes.text(1.5, 0.25, text, ha="center", va="center")
    else:
        axes.set_ylim(float(np.nanmin(error)) - 0.32 * swing, float(np.nanmax(error)) + 0.12 * swing)
        edges = 100.0 * float(case.cycle.edge_share)
        text = f"peak to peak {swing:.3g} arcsec; edges carry {edges:.0f} % of the cycle{_edges(case)}"
        axes.text(0.01, 0.03, text, transform=axes.transAxes, fontsize=theme.SMALL, va="bottom")
    if row == 0:
        axes.legend(loc="upper right", ncols=3)


def _edges(case: Case) -> str:
    """Which edges carry, in brackets."""
    codes = dict.fromkeys(int(code) for code in case.first.limit[case.edge].ravel() if code >= 0)
    return f" ({', '.join(str(Limit(code)) for code in codes)})" if codes else ""


def _bars(axes: Axes, case: Case) -> None:
    order = np.arange(1, HARMONICS + 1)
    amplitude = ARCSEC * np.abs(case.cycle.harmonics)
    axes.set_ylabel("amplitude (arcsec)")
    axes.set_xticks(order)
    axes.set_axisbelow(True)
    axes.grid(True, axis="y")
    if np.isfinite(amplitude).all():
        axes.bar(order, amplitude, width=0.6, color=theme.BLUE)
        if amplitude.max() < SMALLEST:
            axes.set_ylim(0.0, 1.0)


def rows(data: tuple[Case, ...]) -> Table:
    """The curve over one cycle, then the amplitudes."""
    header = ("case", "kind", "pitches_or_multiple", "error_or_amplitude_rad", "carried_by", "tooth_pair")

    def body() -> Iterator[list[object]]:
        for case in data:
            name = case.name.replace("$", "")
            first = case.first
            for index, share in enumerate(case.share.tolist()):
                codes = [int(code) for code in first.limit[index] if code >= 0]
                carrier = " and ".join(str(Limit(code)) for code in codes) or "flanks"
                pair = int(first.pair[index])
                yield [name, "error", share, float(first.transmission_error[index]), carrier, pair]
            for order, amplitude in enumerate(np.abs(case.cycle.harmonics).tolist(), start=1):
                yield [name, "amplitude", order, amplitude, "", ""]

    return header, body()


RECIPES = {"transmission-error": Recipe(compute, draw, rows)}
