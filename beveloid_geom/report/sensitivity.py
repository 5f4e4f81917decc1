"""Sensitivity of a path of contact to the assembly errors as text: table, JSON and CSV."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..analysis.sensitivity import ERRORS, PLACES, Sensitivity, path_sensitivity
from ..arrays import FloatArray
from ..design.model import Design
from ..findings.path import first_contact_fault
from ..operation.backlash import backlash_by_errors
from ..pair.mounting import mounting_of
from ..status import Limit
from .backlash import backlash_report
from .path import (
    backlash_lines,
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    parabola_line,
    status_name,
)

ARCSEC = math.degrees(3600.0)
STEPS = (
    ("offset", 0.1, "mm"),
    ("shaft angle", 0.01, "deg"),
    ("pinion axial", 0.1, "mm"),
    ("gear axial", 0.1, "mm"),
)
"""What a table's columns are for, in the order of ERRORS."""


@dataclass(frozen=True, eq=False)
class SensitivityReport:
    """The `found` sensitivity of one flank of a single design, and the derivatives (4,) of its least
    normal backlash, NaN where that is not known."""

    name: str
    design: Design
    found: Sensitivity
    backlash_by: FloatArray

    @property
    def reason(self) -> str | None:
        """Why there is none, None if there is."""
        status = status_name(int(self.found.status)).replace("_", " ")
        return (
            None if status == "solved" else f"no path of contact on the {self.found.flank} flanks: {status}"
        )


def sensitivity_report(name: str, design: Design, flank: str) -> SensitivityReport:
    """Report of a single design."""
    backlash = np.full(len(ERRORS), np.nan) if first_contact_fault(design) else backlash_by_errors(design)
    return SensitivityReport(name, design, path_sensitivity(design, flank), backlash)


def sensitivity_json(report: SensitivityReport) -> str:
    """Strict JSON, mm and rad: values, and derivatives with the errors on their last axis."""
    values = {
        name: value for name, value in vars(report.found).items() if name not in ("flank", "status", "limit")
    }
    limits = [str(Limit(int(code))) if code >= 0 else None for code in report.found.limit]
    return json_text(
        {
            "design": report.name,
            "flank": report.found.flank,
            "status": status_name(int(report.found.status)),
            **layout_data(report.design, mounting_of(report.design)),
            "errors_of_derivatives": ERRORS,
            "places": PLACES,
            "members": ("pinion", "gear"),
            "limits": limits,
            **values,
            "mounted_backlash_by": report.backlash_by,
        }
    )


def sensitivity_csv(report: SensitivityReport) -> str:
    """CSV, a row for each quantity with its derivatives; rows name units of quantities, the header those
    of errors. Without a path there are no rows."""
    units = ("rad" if name == "shaft_angle" else "mm" for name in ERRORS)
    header = ["quantity", "place", "member", "value"]
    header += [f"by_{name}_per_{unit}" for name, unit in zip(ERRORS, units, strict=True)]
    rows = [] if report.reason else list(_csv_rows(report))
    return csv_text(header, list(zip(*rows, strict=True)))


def _csv_rows(report: SensitivityReport) -> Iterator[list[object]]:
    found = report.found
    nothing = np.full(found.z.shape, np.nan)
    for name, values, rates in (
        ("l_mm", found.l, found.l_by),
        ("z_mm", found.z, found.z_by),
        ("r_mm", found.r, found.r_by),
        ("face_shift_mm", nothing, found.face_shift_by),
        ("square_shift_mm", nothing, found.square_shift_by),
    ):
        for k, j in np.ndindex(values.shape):
            yield [name, PLACES[k], ("pinion", "gear")[j], float(values[k, j]), *rates[k, j].tolist()]
    for k, place in enumerate(PLACES):
        roll = float(found.pinion_roll[k])
        yield ["pinion_roll_rad", place, "pinion", roll, *found.pinion_roll_by[k].tolist()]
    yield ["contact_ratio", "", "", float(found.contact_ratio), *found.contact_ratio_by.tolist()]
    yield ["peak_to_peak_rad", "", "", float(found.peak_to_peak), *found.peak_to_peak_by.tolist()]
    backlash = backlash_report(report.design).normal
    yield ["mounted_backlash_mm", "", "", backlash, *report.backlash_by.tolist()]


def sensitivity_table(report: SensitivityReport) -> str:
    """Readable account, at most 100 characters wide."""
    found, design = report.found, report.design
    text = f"Sensitivity of {report.name}, {found.flank} flanks: exact derivatives, for the errors named\n"
    text += layout_line(design, mounting_of(design)) + error_line(design.errors) + parabola_line(design)
    text += backlash_lines(design)
    if report.reason:
        return text
    swing = ARCSEC * float(found.peak_to_peak)
    text += line("contact ratio", f"{float(found.contact_ratio):.6f} by Eq. 16")
    text += line("transmission error", f"{swing:z.4f} arcsec peak to peak over the path")
    head = "".join(f"{f'{size:g} {unit}':>16}" for _, size, unit in STEPS)
    text += f"\n{'':<36}" + "".join(f"{name:>16}" for name, _, _ in STEPS) + f"\n{'':<36}{head}\n"
    rows = [*_rows(found), ("least normal backlash, mm", report.backlash_by)]
    for label, rates in rows:
        text += f"  {label:<34}" + "".join(f"{value:z16.6f}" for value in rates * _sizes()) + "\n"
    return text


def _sizes() -> FloatArray:
    return np.array([math.radians(size) if unit == "deg" else size for _, size, unit in STEPS])


def _rows(found: Sensitivity) -> list[tuple[str, FloatArray]]:
    """Labels and derivatives (4,) of a table's rows."""
    rows = [
        (f"{member}, {words}, mm", rates[1, j])
        for words, rates in (
            ("along the face", found.face_shift_by),
            ("square to the path", found.square_shift_by),
            ("z of the middle", found.z_by),
        )
        for j, member in enumerate(("pinion", "gear"))
    ]
    return [
        *rows,
        ("contact ratio", found.contact_ratio_by),
        ("transmission error, arcsec", ARCSEC * found.peak_to_peak_by),
    ]
