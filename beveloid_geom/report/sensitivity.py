"""Sensitivity of a path of contact to the assembly errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..analysis.sensitivity import PLACES, Sensitivity, path_sensitivity
from ..arrays import FloatArray
from ..contact.parallel.lines import touches_along_lines
from ..design.model import Design, ErrorsAt
from ..findings.backlash import backlash_report
from ..findings.path import ALONG_LINES, first_contact_fault
from ..operation.backlash import backlash_by_errors
from ..pair.errors import ANGLES, place_of
from ..pair.mesh_errors import by_mesh_errors
from ..status import Limit, Status
from .columns import header_of, label, number, scaled
from .result import Rows, by_columns
from .words import failure_of, head_data, line, mounted_lines, place_words, status_name, status_words

MEMBERS = ("pinion", "gear")
NOT_VALUES = ("flank", "errors", "status", "limit")


class Step(NamedTuple):
    """An error for which changes are shown: its name in words, its size in a unit, and that in mm or rad."""

    name: str
    shown: float
    unit: str
    size: float


def steps_of(errors: Sequence[str]) -> list[Step]:
    """Give the steps of errors by their names: 0.1 mm and 0.01 deg."""
    return [
        Step(
            name.replace("_", " "),
            *((0.01, "deg", math.radians(0.01)) if name in ANGLES else (0.1, "mm", 0.1)),
        )
        for name in errors
    ]


@dataclass(frozen=True, eq=False)
class SensitivityReport:
    """The `found` sensitivity of one flank of a single design, and the derivatives of its least normal
    backlash by the same errors, NaN where that is not known; whether the flanks touch along lines
    (`along_lines`), which have none."""

    name: str
    design: Design
    found: Sensitivity
    backlash_by: FloatArray
    along_lines: bool = False

    @property
    def reason(self) -> str | None:
        """Why there is none, None if there is."""
        status = int(self.found.status)
        none = f"no path of contact on the {self.found.flank} flanks: {status_words(status)}"
        return None if status == Status.SOLVED else none

    @property
    def failure(self) -> str | None:
        """Why there is no path, or why the pair cannot be assembled."""
        return failure_of(self.reason, self.design)

    def data(self) -> dict[str, Any]:
        """Give values, and derivatives with the errors on their last axis."""
        return {
            **head_data(self.name, self.design, self.found.flank),
            "status": status_name(int(self.found.status)),
            "errors_of_derivatives": self.found.errors,
            "places": PLACES,
            "members": MEMBERS,
            "limits": [str(Limit(int(code))) if code >= 0 else None for code in self.found.limit],
            **{name: value for name, value in vars(self.found).items() if name not in NOT_VALUES},
            "mounted_backlash_by": self.backlash_by,
        }

    def rows(self) -> Rows:
        """Give each quantity, whose name has its unit, with its derivatives; nothing without a path."""
        names = ("quantity", "place", "member", "value", *(f"by_{name}" for name in self.found.errors))
        return by_columns(names, [] if self.reason else list(self._quantities()))

    def _quantities(self) -> Iterator[tuple[Any, ...]]:
        found, nothing = self.found, np.full(self.found.z.shape, np.nan)
        for name, values, rates in (
            ("l", found.l, found.l_by),
            ("z", found.z, found.z_by),
            ("r", found.r, found.r_by),
            ("face_shift", nothing, found.face_shift_by),
            ("square_shift", nothing, found.square_shift_by),
        ):
            for k, j in np.ndindex(values.shape):
                yield header_of(name), PLACES[k], MEMBERS[j], float(values[k, j]), *rates[k, j].tolist()
        for place, roll, by in zip(PLACES, found.pinion_roll.tolist(), found.pinion_roll_by, strict=True):
            yield header_of("pinion_roll"), place, "pinion", roll, *by.tolist()
        for name, value, by in (
            ("contact_ratio", found.contact_ratio, found.contact_ratio_by),
            ("peak_to_peak", found.peak_to_peak, found.peak_to_peak_by),
            ("mounted_backlash", backlash_report(self.design).normal, self.backlash_by),
        ):
            yield header_of(name), "", "", float(value), *by.tolist()

    def summary(self) -> str:
        """Write what errors of usual size do by the derivatives."""
        found = self.found
        text = (
            f"Sensitivity of {self.name}, {found.flank} flanks: exact derivatives, times the errors named\n"
        )
        text += mounted_lines(self.design)
        text += line("derivatives", f"by errors {place_words(self.design, place_of(found.errors))}")
        if self.reason:
            return text
        text += line("contact ratio", f"{number('contact_ratio', found.contact_ratio)} by Eq. 16")
        swing = number("peak_to_peak", found.peak_to_peak)
        text += line("transmission error", f"{swing} arcsec peak to peak over the path")
        steps = steps_of(found.errors)
        heads = [step.name for step in steps], [f"{step.shown:g} {step.unit}" for step in steps]
        sizes = np.array([step.size for step in steps])
        text += "\n" + "".join(" " * 36 + "".join(f"{word:>16}" for word in head) + "\n" for head in heads)
        shifts = (
            ("along the face", found.face_shift_by),
            ("square to the path", found.square_shift_by),
            ("z of the middle", found.z_by),
        )
        rows = [
            (f"{member}, {what}, mm", rates[1, j])
            for what, rates in shifts
            for j, member in enumerate(MEMBERS)
        ]
        rows.append(("contact ratio", found.contact_ratio_by))
        rows.append((label("peak_to_peak"), scaled("peak_to_peak", found.peak_to_peak_by)))
        rows.append(("least normal backlash, mm", self.backlash_by))
        for words, rates in rows:
            text += f"  {words:<34}" + "".join(f"{value:z16.6f}" for value in rates * sizes) + "\n"
        return text + (line("no derivatives", ALONG_LINES) if self.along_lines else "")


def sensitivity_report(
    name: str, design: Design, flank: str, errors_at: ErrorsAt | None = None
) -> SensitivityReport:
    """Find the sensitivity of one flank of a single design, to errors where it has its own measured, unless
    told."""
    at = design.errors_at if errors_at is None else errors_at
    found, lines = path_sensitivity(design, flank, at), bool(touches_along_lines(design, flank))
    if first_contact_fault(design):
        return SensitivityReport(name, design, found, np.full(len(found.errors), np.nan), lines)
    backlash = backlash_by_errors(design)
    backlash = by_mesh_errors(design, backlash) if at == "mesh" else backlash
    if lines:  # either sense of a shaft angle takes backlash
        backlash = np.where([error in ANGLES for error in found.errors], np.nan, backlash)
    return SensitivityReport(name, design, found, backlash, lines)
