"""Comparison of flanks.

Design with measured flanks: nominal and measured flanks. Modified design: flanks without and with its
modification. Unmodified design: unmodified flanks, flanks with the paper's parabolas, and flanks with helix
crowning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import ContactPath, Design, Modification, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.design.ends import end_names
from beveloid_geom.operation.contact_pattern.pattern import ContactPattern
from beveloid_geom.pair.misalignment import NAMES, mounted
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.pattern import pattern_report

from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.flattened_flank import side_view
from ...components.paths_table import PARABOLAS, as_large, coefficients, paper_modified, parabolas, two_digits
from ...rendering import theme
from ...rendering.layout import PanelRows

STYLES: tuple[tuple[str, Any, str], ...] = (
    (theme.INK, "-", "o"),
    (theme.VERMILLION, "--", "s"),
    (theme.BLUE, "-.", "D"),
)
"""Colour, dashes and marker of the cases."""


@dataclass(frozen=True, eq=False)
class ModificationCase:
    """One case of one flank: path, pattern, mesh cycle and shifts under errors; pattern and mesh cycle are
    None with the `reason` if they are not known.

    `name` is that of the CSV file, `label` that of the picture.

    `shifts` (2, n), mm: displacement of the middle of the path along the face of the pinion under each
    error of the `sizes` (2, n), mm and rad; NaN without a path."""

    name: str
    label: str
    path: ContactPath
    pattern: ContactPattern | None
    operation: OperationReport | None
    sizes: FloatArray
    shifts: FloatArray
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Comparison:
    """The cases of a figure, and its title."""

    title: str
    cases: tuple[ModificationCase, ...]


def compute(design: Design, flank: str = "right") -> Comparison:
    """Compute two or three cases."""
    title, cases = _compared(design)
    return Comparison(title, tuple(_case(*case, flank) for case in cases))


def _compared(design: Design) -> tuple[str, list[tuple[str, str, Design]]]:
    """Return the title of the comparison, and the designs with their names in the CSV file and in the
    picture."""
    if design.measured:
        cases = [("nominal", "nominal", design.nominal()), ("measured", "measured", design)]
        return "Measured and nominal flanks compared", cases
    design = design.nominal()  # deviations of pitches do not change the flanks
    plain = design.unmodified()
    unmodified = "unmodified", "without modification", plain
    if plain != design:
        cases = [unmodified, ("modified", "with modification", design)]
        return "Flanks with and without modification", cases
    # Helix crowning of the pinion in the last case, um.
    helix_crowning_um = 10.0
    bent, crowning = paper_modified(plain), Modification(helix_crowning_um=helix_crowning_um)
    crowned = replace(plain, pinion=plain.pinion.modified(crowning))
    words = f"{helix_crowning_um:g} \u00b5m of helix crowning"
    cases = [unmodified, ("parabolas", coefficients(bent), bent), ("helix_crowning", words, crowned)]
    return "Parabolas of the tool and helix crowning compared", cases


def _case(name: str, label: str, design: Design, flank: str) -> ModificationCase:
    # Largest error of the distance of the axes at the module of Table 1, and of the shaft angle.
    distance_mm, angle_rad = 0.05, np.radians(0.01)
    path = path_of_contact(design, flank)
    distance = two_digits(distance_mm * as_large(design))
    sizes = np.array((distance, angle_rad))[:, None] * np.linspace(-1.0, 1.0, 9)
    cases = zip(sizes, _errors(design), strict=True)
    shifts = np.array([_shifts(design, flank, size, error) for size, error in cases])
    rolls, harmonics = 181, 1
    try:
        operation = operation_report("", design, flank, rolls, harmonics, MARKING_SEPARATION_MM)
        if operation.reason:
            raise ValueError(operation.reason)
        pattern = pattern_report("", design, flank, MARKING_SEPARATION_MM).result
    except ValueError as error:
        reason = str(getattr(error, "reason", error))
        return ModificationCase(name, label, path, None, None, sizes, shifts, reason)
    return ModificationCase(name, label, path, pattern, operation, sizes, shifts)


def _errors(design: Design) -> tuple[str, str]:
    """Return the names of the two errors: distance and angle of the axes."""
    first, second, *_ = NAMES[design.errors_at]
    return first, second


def _shifts(design: Design, flank: str, sizes: FloatArray, error: str) -> FloatArray:
    """Return the shifts (n,) of the middle of the path under sizes (n,) of an error."""
    # Shifts below this are counted as zero.
    rounding_mm = 1e-9
    batch = mounted(design, np.append(sizes, 0.0)[:, None], (error,))
    z = path_of_contact(batch, flank, 3).pinion_z[:, 1]
    shifts = np.asarray(z[:-1] - z[-1])
    return np.where(np.abs(shifts) < rounding_mm, 0.0, shifts)


def draw(comparison: Comparison, layout: theme.PageLayout) -> Drawing:
    """Draw a pattern for each case, then transmission error and shifts of all cases."""
    note = (
        "Above: pinion flank in the side view, from {ends[0]} (left) to {ends[1]}, tip above; shaded:"
        " separation below a quarter, half and all of {film:g} \u00b5m; line: path of one tooth pair. TE:"
        " transmission error of all teeth, rigid, without load; positive: gear ahead. Shift: that of the"
        " middle of the path along the face."
    )
    cells = PanelRows(left=1.05, right=0.3, across=1.05, down=1.55, most=3, least=1.9)
    data = comparison.cases
    # Indents a second line of a title below the first word of the first.
    new_line = "\n       "
    count, first = len(data) + 3, data[0].path
    single = cells.columns(layout, count) == 1
    if single:
        cells = replace(cells, left=1.2, down=0.85)
    page, low, high = theme.new_page(
        layout,
        comparison.title,
        f"{first.flank.capitalize()} flanks, the pinion drives",
        note.format(ends=end_names(first.design.pinion), film=1e3 * MARKING_SEPARATION_MM)
        + _unknown_shifts(data),
        below=0.65,
        above=1.35,
        tall=cells.tall(layout, count, 2.0),
    )
    panels = theme.panels(page, cells, count, low, high)
    letters = iter("abcdef")
    for case, axes in zip(data, panels, strict=False):
        letter = next(letters)
        words = f"({letter})  {case.label}"
        if case.pattern is not None:
            share = f"{100.0 * case.pattern.pinion.area_share:.0f}\u00a0%\u00a0marked"
            words += f"{', ' if single else new_line}{share}"
        axes.set_title(words, loc="left", pad=8.0, fontsize=theme.LABEL)
        _pattern(axes, case)
        if single and case is not data[-1]:
            axes.set_xlabel("")  # the panel below has the label
    error, *shifts = panels[len(data) :]
    _errors_of_all_teeth(error, data, next(letters))
    for k, axes in zip((1, 0), shifts, strict=True):
        _shifted(axes, data, next(letters), k)
    theme.legend(page, _entries(data), len(data), 1.15, handlelength=3.0)
    return Drawing(page, {})


def _unknown_shifts(data: tuple[ModificationCase, ...]) -> str:
    """Return the text on cases without a path under any error of one kind."""
    words = ""
    for k in (1, 0):
        lost = [case.label for case in data if np.isnan(case.shifts[k][case.sizes[k] != 0.0]).all()]
        if lost:
            words += f" No path under the {_error_name(data[0].path.design, k)}: {', '.join(lost)}."
    return words


def _error_name(design: Design, k: int) -> str:
    """Return the printed name of error `k` (0 distance, 1 angle)."""
    return _errors(design)[k].replace("shaft_angle", "shaft-angle").replace("_", " ") + " error"


def _pattern(axes: Axes, case: ModificationCase) -> None:
    """Draw the pattern and the path over the pinion flank."""
    if case.pattern is None:
        theme.message(axes, case.reason, 30)
        return
    side = case.pattern.pinion
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    side_view(axes, side.z, r, side.least, MARKING_SEPARATION_MM)
    if case.path.l1.size:
        axes.plot(case.path.pinion_z, case.path.pinion_r, color=theme.INK, linewidth=1.8)
    axes.set(xlabel="z (mm)", ylabel="r (mm)")


def _errors_of_all_teeth(axes: Axes, data: tuple[ModificationCase, ...], letter: str) -> None:
    """Draw the transmission error (arcsec) of all teeth over two pitches, less its mean."""
    axes.set_title(f"({letter})  transmission error, TE", loc="left", pad=8.0, fontsize=theme.LABEL)
    for case, (colour, dashes, _) in zip(data, STYLES, strict=False):
        if case.operation is None:
            continue
        error = ARCSEC * (case.operation.first.transmission_error - float(case.operation.cycle.mean))
        both = np.append(error, error[1:])
        axes.plot(np.linspace(0.0, 2.0, both.size), both, dashes, color=colour, linewidth=2.0)
    axes.set(xlabel="pinion roll (pitches)", ylabel="arcsec")
    axes.set(xlim=(0.0, 2.0), xticks=(0.0, 0.5, 1.0, 1.5, 2.0))
    axes.grid(True, axis="y")


def _shifted(axes: Axes, data: tuple[ModificationCase, ...], letter: str, k: int) -> None:
    """Draw the shift of all cases under error `k` (0 distance, 1 angle)."""
    words = _error_name(data[0].path.design, k)
    axes.set_title(f"({letter})  shift under the {words}", loc="left", pad=8.0, fontsize=theme.LABEL)
    for case, (colour, dashes, marker) in zip(data, STYLES, strict=False):
        x = np.degrees(case.sizes[k]) if k else case.sizes[k]
        look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 5.0, "linewidth": 1.8}
        axes.plot(x, case.shifts[k], dashes, clip_on=False, **look)
    axes.set(xlabel=f"{words} ({'deg' if k else 'mm'})", ylabel="mm")
    axes.grid(True, axis="y")


def _entries(data: tuple[ModificationCase, ...]) -> list[Line2D]:
    """Return the legend entries of the cases."""
    return [
        Line2D([], [], color=colour, linestyle=dashes, marker=marker, linewidth=1.8, label=case.label)
        for case, (colour, dashes, marker) in zip(data, STYLES, strict=False)
    ]


def rows(comparison: Comparison) -> Table:
    """List patterns, paths, transmission errors and shifts of all cases."""
    points = "z_mm", "r_mm", "least_mm"
    curves = "pitches", "error_rad"
    shifts = "error", "size", "unit", "shift_mm"
    header = ("case", *PARABOLAS, "helix_crowning_um", "kind", *points, *curves, *shifts, "reason")

    def cases() -> Rows:
        """Yield the columns of every case."""
        for case in comparison.cases:
            path, design = case.path, case.path.design
            given = design.pinion.modification(path.flank)
            crowning = 0.0 if given is None else given.helix_crowning_um
            who = case.name, *parabolas(design, path.flank), crowning
            yield *who, "path", path.pinion_z, path.pinion_r, *[""] * 8
            if case.pattern is None or case.operation is None:
                yield *who, "pattern", *[""] * 9, case.reason
            else:
                side = case.pattern.pinion
                r = np.hypot(side.points[..., 0], side.points[..., 1])
                yield *who, "pattern", side.z.ravel(), r.ravel(), side.least.ravel(), *[""] * 7
                error = case.operation.first.transmission_error - float(case.operation.cycle.mean)
                yield *who, "cycle", *[""] * 3, np.linspace(0.0, 1.0, error.size), error, *[""] * 5
            errors = zip(_errors(design), ("mm", "rad"), case.sizes, case.shifts, strict=True)
            for name, unit, size, shift in errors:
                yield *who, "shift", *[""] * 5, name, size, unit, shift, ""

    return header, rows_of_cases(cases())


RECIPES = {"modifications": Recipe(compute, draw, rows)}
