"""Sensitivity to the four assembly errors: exact derivatives on both flanks, two sets of coefficients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from beveloid_geom import Design, Status, path_sensitivity
from beveloid_geom.analysis.sensitivity import Sensitivity
from beveloid_geom.report.sensitivity import STEPS

from ...parts.charts import (
    MIDDLE,
    QUANTITIES,
    STEP_SIZES,
    Changes,
    Quantity,
    changes_of,
    changes_under_errors,
    greatest_of,
    marks_of_changes,
)
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import REASONS
from ...stage import theme
from ...stage.scene import Size

FLANKS = ("right", "left")
MODIFIED = (0.001, -0.001)
"""Parabola coefficients of pinion and gear in the second case, 1/mm."""
LEFT, RIGHT = 0.1, 0.995  # shares of the page's width
NOTE = (
    "Exact derivatives at the design's own errors, times the errors named. The shift is that of the middle"
    " of the path: along the face, of z at equal flank parameter l; square, on the flank at right angles to"
    " the path; both positive towards the heel. The contact ratio is Eq. 16; the transmission error is"
    " that of one tooth pair over its path, peak to peak, and 0 without modification under every error."
    " Scales are linear about 0 and logarithmic beyond the first marked value to either side."
)


@dataclass(frozen=True, eq=False)
class Case:
    """One set of coefficients: the sensitivity of each flank."""

    name: str
    found: tuple[Sensitivity, ...]

    def values(self, quantity: Quantity) -> Changes:
        """Give the changes (4 errors,) by flank and member, or by flank and ""; NaN where not known."""
        return changes_of(self.found, quantity)

    @property
    def remarks(self) -> str:
        """Say what is missing, and why."""
        words = []
        for rates in self.found:
            status = Status(int(rates.status))
            if status != Status.SOLVED:
                reason = REASONS.get(status, "nothing to solve")
                words.append(f"{rates.flank} flanks: no path of contact, {reason}")
            elif np.isnan(rates.face_shift_by[MIDDLE]).any():
                words.append(f"{rates.flank} flanks: no middle, the roll turns back along the path")
        return "; ".join(words)


def compute(design: Design) -> tuple[Case, ...]:
    """Find both cases, both flanks."""
    a1, a2 = (f"{a:g}".replace("-", "\u2212") for a in MODIFIED)
    modified = f"$a_1$ = {a1}, $a_2$ = {a2} mm$^{{\u22121}}$"
    cases = {"as designed": design, modified: design.with_parabola(*MODIFIED)}
    return tuple(Case(name, tuple(path_sensitivity(one, f) for f in FLANKS)) for name, one in cases.items())


def draw(data: tuple[Case, ...], size: Size) -> Drawing:
    """Draw a row of panels for each case, a column for each quantity."""
    page = theme.new_page(
        size,
        "Sensitivity of the path of contact to assembly errors",
        "Changes under the errors named on the left, from exact derivatives",
    )
    low = theme.caption(page, NOTE) + theme.inches(page, 0.45)
    high, gap = theme.top(page) - theme.inches(page, 0.75), theme.inches(page, 1.1)
    height = (high - low - gap * (len(data) - 1)) / len(data)
    step = (RIGHT - LEFT) / len(QUANTITIES)
    for row, case in enumerate(data):
        bottom = high - height - row * (height + gap)
        y = bottom + height + theme.inches(page, 0.42)
        page.text(0.025, y, f"({'ab'[row]})  {case.name}", fontsize=theme.HEADING, va="bottom")
        page.text(RIGHT, y, case.remarks, fontsize=theme.SMALL, va="bottom", ha="right")
        for column, quantity in enumerate(QUANTITIES):
            axes = page.add_axes((LEFT + column * step, bottom, 0.9 * step, height))
            greatest = greatest_of(one.values(quantity) for one in data)
            changes_under_errors(axes, quantity, case.values(quantity), greatest)
            axes.tick_params(labelleft=column == 0)
    theme.legend(page, marks_of_changes(FLANKS), 5)
    return Drawing(page, {})


def rows(data: tuple[Case, ...]) -> Table:
    """List every value, and its derivative by mm or rad."""
    header = ("case", "flank", "quantity", "member", "error", "step", "step_unit", "change", "unit")

    def body() -> Iterator[list[object]]:
        for case in data:
            name = case.name.replace("$", "")
            for quantity in QUANTITIES:
                for (flank, member), row in case.values(quantity).items():
                    for step, true, value in zip(STEPS, STEP_SIZES.tolist(), row.tolist(), strict=True):
                        rate = value / true / quantity.scale
                        yield [name, flank, quantity.name, member, *step, value, quantity.unit, rate]

    return (*header, "derivative_per_mm_or_rad"), body()


RECIPES = {"sensitivity": Recipe(compute, draw, rows)}
