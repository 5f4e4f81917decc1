"""Sensitivity to assembly errors: exact derivatives on both flanks for two sets of coefficients."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, Status, path_sensitivity
from beveloid_geom.analysis.sensitivity import Sensitivity
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.report.sensitivity import steps_of

from ...components import charts, paths_table
from ...components.charts import MIDDLE_INDEX, QUANTITIES, ErrorEffect, changes_under_steps
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.paths_table import FLANKS, PARABOLAS
from ...rendering import theme
from ...rendering.layout import PanelRows


@dataclass(frozen=True, eq=False)
class SensitivityCase:
    """One set of coefficients with the sensitivity of each flank."""

    name: str
    design: Design
    sensitivities: tuple[Sensitivity, ...]

    @property
    def remarks(self) -> str:
        """Text on missing values and their reasons."""
        # Movement along the profile, mm, below which a path runs along the face.
        profile_movement_mm = 1e-9
        words = []
        for rates in self.sensitivities:
            status = Status(int(rates.status))
            if status != Status.SOLVED:
                reason = paths_table.REASONS.get(status, "nothing to solve")
                words.append(f"{rates.flank} flanks: no path of contact, {reason}")
            elif bool(is_line_contact(self.design, rates.flank)):
                words.append("both flanks: line contact")
            elif np.isnan(rates.face_shift_by[MIDDLE_INDEX]).any():
                still = np.ptp(rates.l[:, 0]) < profile_movement_mm
                turned = f"{rates.flank} flanks: no mid-roll, the roll is not monotonic along the path"
                words.append("both flanks: path along the face" if still else turned)
        return "; ".join(dict.fromkeys(words))

    @property
    def known(self) -> bool:
        """True if some of the changes are known."""
        return any(self.knows(quantity) for quantity in QUANTITIES)

    def knows(self, quantity: ErrorEffect) -> bool:
        """Return True if some of the changes of a quantity are known."""
        changes = changes_under_steps(self.sensitivities, quantity).values()
        return any(np.isfinite(change).any() for change in changes)


def compute(design: Design) -> tuple[SensitivityCase, ...]:
    """Compute both cases on both flanks."""
    bent = paths_table.paper_modified(design)
    cases = {"as designed": design, paths_table.coefficients(bent): bent}
    return tuple(
        SensitivityCase(name, one, tuple(path_sensitivity(one, f, one.errors_at) for f in FLANKS))
        for name, one in cases.items()
    )


def draw(data: tuple[SensitivityCase, ...], layout: theme.PageLayout) -> Drawing:
    """Draw a row for each case and a column for each quantity; on a narrow page columns for cases and fewer
    quantities."""
    note = (
        "Derivatives at the errors of the design, times the error on the left{place}. Shift: middle of the"
        " path along the face, at equal flank parameter l{square}, positive towards +z. Contact ratio: Eq."
        " 16. Transmission error: one tooth pair, peak to peak."
    )
    cells = PanelRows(left=1.6, right=0.438, across=0.358, down=1.1, most=4, least=1.4)
    perpendicular_note = ", or perpendicular to the path"
    narrow_note = " (perpendicular to the path: see the CSV file)"
    steps, where = steps_of(data[0].sensitivities[0].errors), paths_table.at_the_mesh(data[0].design)
    left_out = [f" Unknown {case.name} ({case.remarks})." for case in data if not case.known]
    data = tuple(case for case in data if case.known) if len(left_out) < len(data) else data
    narrow = layout.printed and cells.columns(layout, len(QUANTITIES)) < len(QUANTITIES)
    quantities = [one for one in QUANTITIES if not narrow or one.name != "square_shift"]
    known = [one for one in quantities if any(case.knows(one) for case in data)] or quantities
    left_out += [f" Unknown: {one.title.partition(' (')[0]}." for one in quantities if one not in known]
    quantities, scales = known, " Scales: linear, common to (a) and (b)." if len(data) > 1 else ""
    weights = [1.7 if one.members else 1.0 for one in quantities] if narrow else [1.0 for _ in data]
    down = cells.down if not layout.printed else 1.05 if narrow else 1.5
    page, low, high = theme.new_page(
        layout,
        "Sensitivity of the path of contact to assembly errors",
        "Changes under one error each, from exact derivatives",
        note.format(place=where, square=narrow_note if narrow else perpendicular_note)
        + scales
        + "".join(left_out),
        below=0.45,
        above=0.75,
        tall=replace(cells, down=down).tall(layout, len(weights) * cells.most, 2.6 if narrow else 3.3),
    )
    across = len(data if narrow else quantities)
    panels = _panels(page, cells, weights, across, down, low, high)
    for number, case in enumerate(data):
        case_axes = [row[number] for row in panels] if narrow else panels[number]
        box, y = case_axes[0].get_position(), 0.7 if layout.printed else 0.42
        width = (box.width if narrow else 0.9) * layout.width * layout.dpi
        words = f"({'ab'[number]})  {case.name}" if len(data) > 1 else case.name, case.remarks
        for text, up, size in zip(words, (y, y - 0.25 * narrow), (theme.HEADING, theme.SMALL), strict=True):
            x = box.x0 if narrow else 0.025 if text == words[0] else 0.995
            place = x, box.y1 + theme.inches(page, up)
            ha = "left" if narrow or text == words[0] else "right"
            theme.wrap_text(page.text(*place, "", fontsize=size, va="bottom", ha=ha), text, width)
        for column, (quantity, axes) in enumerate(zip(quantities, case_axes, strict=True)):
            greatest = charts.greatest_of(changes_under_steps(one.sensitivities, quantity) for one in data)
            changes = changes_under_steps(case.sensitivities, quantity)
            charts.changes_under_errors(axes, quantity, changes, greatest, steps)
            axes.tick_params(labelleft=number == 0 if narrow else column == 0)
    theme.legend(page, charts.marks_of_changes(FLANKS, quantities), 5)
    return Drawing(page, {})


def _panels(
    page: theme.Page,
    cells: PanelRows,
    weights: list[float],
    across: int,
    down: float,
    low: float,
    high: float,
) -> list[list[Axes]]:
    """Return rows of `across` panels with heights proportional to their weights, `down` inches apart."""
    gap = theme.inches(page, down)
    unit = (high - low - gap * (len(weights) - 1)) / sum(weights)
    panels = []
    for weight in weights:
        panels.append(theme.panels(page, cells, across, high - weight * unit, high))
        high -= weight * unit + gap
    return panels


def rows(data: tuple[SensitivityCase, ...]) -> Table:
    """List every value and its derivative by mm or rad."""
    header = (*PARABOLAS, "flank", "quantity", "member", "error", "step", "step_unit", "change", "unit")

    def cases() -> Rows:
        """Yield the columns of every change."""
        for case, quantity in product(data, QUANTITIES):
            names, shown, units, sizes = zip(*steps_of(case.sensitivities[0].errors), strict=True)
            for (flank, member), row in changes_under_steps(case.sensitivities, quantity).items():
                who = *paths_table.parabolas(case.design, flank), flank, quantity.name, member
                rates = row / np.array(sizes) / quantity.scale
                yield *who, list(names), list(shown), list(units), row, quantity.unit, rates

    return (*header, "derivative_per_mm_or_rad"), rows_of_cases(cases())


RECIPES = {"sensitivity": Recipe(compute, draw, rows)}
