"""Report of `sensitivity`: derivatives of a path of contact with respect to the assembly errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..analysis.mountings import PLACES
from ..analysis.sensitivity import Sensitivity, path_sensitivity
from ..arrays import MEMBERS, FloatArray
from ..contact.parallel.lines import is_line_contact
from ..design.model import Design, ErrorsAt
from ..findings.backlash import backlash_report
from ..findings.path import ALONG_LINES, first_contact_fault
from ..operation.backlash import backlash_by_errors
from ..pair.misalignment import ANGLES, place_of
from ..pair.misalignment_at_mesh import by_mesh_errors
from ..status import Limit, NotComputed, Status
from .columns import header_of, label, labelled_lines, number, scaled
from .result import ResultReport, Rows, by_columns, picked
from .text import line, mounted_lines, place_words, status_words


class Step(NamedTuple):
    """Size of an error for which changes are printed.

    `name` is its printed name, `shown` its size in `unit`, `size` the size in mm or rad."""

    name: str
    shown: float
    unit: str
    size: float


def steps_of(errors: Sequence[str]) -> list[Step]:
    """Return the steps of errors by name: 0.1 mm and 0.01 deg."""
    return [
        Step(
            name.replace("_", " "),
            *((0.01, "deg", math.radians(0.01)) if name in ANGLES else (0.1, "mm", 0.1)),
        )
        for name in errors
    ]


@dataclass(frozen=True, eq=False)
class SensitivityReport(ResultReport[Sensitivity]):
    """Sensitivity of one flank pair of a single design.

    Attributes
    ----------
    result : Sensitivity
        Derivatives of the path of contact.
    backlash_by : ndarray
        Derivatives of the smallest normal backlash with respect to the same errors; NaN if unknown.
    along_lines : bool
        Whether the flanks have line contact, for which the derivatives do not exist.
    """

    needs_assembly = True
    backlash_by: FloatArray
    along_lines: bool = False

    @property
    def reason(self) -> str | None:
        """Reason for a missing path, None if there is one."""
        status = int(self.result.status)
        text = f"path of contact on the {self.result.flank} flanks"
        if status in (Status.OFF_FLANK, Status.NO_COMMON_NORMAL):
            return f"no {text}: {status_words(status)}"
        computed = status == Status.SOLVED
        return None if computed else NotComputed(f"the {text} could not be computed: {status_words(status)}")

    def values(self) -> dict[str, Any]:
        """Return values and derivatives; the errors are on the last axis of the derivatives."""
        # Fields of `Sensitivity` that are not entries of JSON.
        not_values = ("flank", "errors", "status", "limit")
        return {
            **picked(self.result, "status"),
            "errors_of_derivatives": self.result.errors,
            "places": PLACES,
            "members": MEMBERS,
            "limits": [str(Limit(int(code))) if code >= 0 else None for code in self.result.limit],
            **{name: value for name, value in vars(self.result).items() if name not in not_values},
            "path_peak_to_peak": self.result.peak_to_peak,
            "path_peak_to_peak_by": self.result.peak_to_peak_by,
            "mounted_backlash_by": self.backlash_by,
        }

    def data(self) -> dict[str, Any]:
        """Return the content of JSON, which has a status but no reason."""
        data: dict[str, Any] = super().data()
        data.pop("reason", None)
        return data

    def rows(self) -> Rows:
        """Return each quantity, with its unit in the name, and its derivatives; empty without a path.

        Quantities without any known derivative are omitted."""
        names = ("quantity", "place", "member", "value", *(f"by_{name}" for name in self.result.errors))
        known = [row for row in self._quantities() if not np.isnan(row[3:]).all()]
        return by_columns(names, [] if self.reason else known)

    def _quantities(self) -> Iterator[tuple[Any, ...]]:
        """Yield quantity, place, member, value and derivatives."""
        result, nothing = self.result, np.full(self.result.z.shape, np.nan)
        for name, values, rates in (
            ("l", result.l, result.l_by),
            ("z", result.z, result.z_by),
            ("r", result.r, result.r_by),
            ("face_shift", nothing, result.face_shift_by),
            ("square_shift", nothing, result.square_shift_by),
        ):
            for k, j in np.ndindex(values.shape):
                yield header_of(name), PLACES[k], MEMBERS[j], float(values[k, j]), *rates[k, j].tolist()
        for place, roll, by in zip(PLACES, result.pinion_roll.tolist(), result.pinion_roll_by, strict=True):
            yield header_of("pinion_roll"), place, "pinion", roll, *by.tolist()
        for name, value, by in (
            ("contact_ratio", result.contact_ratio, result.contact_ratio_by),
            ("peak_to_peak", result.peak_to_peak, result.peak_to_peak_by),
            ("mounted_backlash", backlash_report(self.design).normal, self.backlash_by),
        ):
            yield header_of(name), "", "", float(value), *by.tolist()

    def summary(self) -> str:
        """Return the changes under errors of usual size, computed from the derivatives."""
        result = self.result
        text = (
            f"Sensitivity of {self.name}, {result.flank} flanks: exact derivatives times the errors below\n"
        )
        text += mounted_lines(self.design)
        text += line(
            "derivatives", f"with respect to errors {place_words(self.design, place_of(result.errors))}"
        )
        if self.reason:
            return text
        text += line(
            "contact ratio", f"{number('contact_ratio', result.contact_ratio)} of one tooth pair (Eq. 16)"
        )
        amplitude = f"{number('peak_to_peak', result.peak_to_peak)} arcsec peak to peak over the path"
        text += line("transmission error", "not known" if np.isnan(result.peak_to_peak) else amplitude)
        text += line(
            "movements",
            "the middle of the path moves along the face (towards +z at constant l), and on the flank"
            " perpendicular to the path; z of the middle also changes because the position at mid-roll moves"
            " along the path",
        )
        steps = steps_of(result.errors)
        table = [("", [step.name for step in steps])]
        table += [("", [f"{step.shown:g} {step.unit}" for step in steps])]
        sizes = np.array([step.size for step in steps])
        shifts = (
            ("along the face", result.face_shift_by),
            ("perpendicular to path", result.square_shift_by),
            ("z of the middle", result.z_by),
        )
        rows = [
            (f"{member}, {quantity}, mm", rates[1, j])
            for quantity, rates in shifts
            for j, member in enumerate(MEMBERS)
        ]
        rows.append(("contact ratio", result.contact_ratio_by))
        rows.append((label("peak_to_peak"), scaled("peak_to_peak", result.peak_to_peak_by)))
        rows.append(("smallest normal backlash, mm", self.backlash_by))
        for words, rates in rows:
            if not np.isnan(rates).all():
                cells = ["-" if np.isnan(value) else f"{value:z.6f}" for value in rates * sizes]
                table.append((f"  {words}", cells))
        text += "\n" + labelled_lines(table, label_width=36, cell_width=16)
        return text + (line("no derivatives", self.missing) if self.missing else "")

    @property
    def missing(self) -> str:
        """Derivatives that do not exist, with the reason; empty if all exist."""
        result = self.result
        if self.along_lines:
            return (
                f"of the path: {ALONG_LINES}. The backlash decreases for both signs of this error; the table"
                " shows a dash"
            )
        reasons = []
        if np.isnan(result.pinion_roll_by[1]).any():
            reasons.append("of the middle of the path: the roll is not monotone along the path")
        elif np.isnan(result.face_shift_by[1]).any():
            reasons.append("of a shift along the face: the path is parallel to the face")
        if self._at_kink(result.peak_to_peak_by):
            reasons.append("of the transmission error: it is 0, and errors of both signs increase it")
        if self._at_kink(self.backlash_by):
            reasons.append(
                "of the backlash: it is smallest at several rolls, at which its derivatives differ"
            )
        elif not reasons and np.isnan(self.backlash_by).any():
            reasons.append("of the backlash: it is unknown or limited by the contact of two edges")
        return "; ".join(reasons)

    def _at_kink(self, rates: FloatArray) -> bool:
        """Return whether derivatives are missing for single errors, because both signs of them have different
        effects."""
        missing = np.isnan(rates)
        of_ratio = np.isnan(self.result.contact_ratio_by)  # also missing for a tilt of parallel axes
        return bool((missing & ~of_ratio).any() and not missing.all())


def sensitivity_report(
    name: str, design: Design, flank: str, errors_at: ErrorsAt | None = None
) -> SensitivityReport:
    """Return the sensitivity of one flank pair of a single design.

    The errors are those of the design (`errors_at`) by default."""
    at = design.errors_at if errors_at is None else errors_at
    result, lines = path_sensitivity(design, flank, at), bool(is_line_contact(design, flank))
    if first_contact_fault(design):
        return SensitivityReport(name, design, result, np.full(len(result.errors), np.nan), lines)
    backlash = backlash_by_errors(design)
    backlash = by_mesh_errors(design, backlash) if at == "mesh" else backlash
    if lines:  # shaft-angle errors of both signs reduce the backlash
        backlash = np.where([error in ANGLES for error in result.errors], np.nan, backlash)
    return SensitivityReport(name, design, result, backlash, lines)
