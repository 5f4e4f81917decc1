"""A path of contact, with all that it is to be read with."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..analysis.pressure import WHOLE, Load, PathPressure, pressure_along
from ..contact.parallel.lines import ContactLines, contact_lines, touches_along_lines
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..findings.advice import Advice, advice_on
from ..findings.backlash import BacklashReport, backlash_report
from ..findings.layout import layout_remarks
from ..findings.path import certificate_remarks, path_remarks, pressure_remarks, reason_of
from ..findings.remarks import NOTE, Remark, in_order, remarks_data
from ..operation.certificate import Certificate, certify
from ..pair.mounting import mounting_of
from ..status import EllipseStatus, Limit, Verdict
from .columns import number, table_lines
from .result import Rows
from .words import (
    advice_data,
    advice_lines,
    end_words,
    ends_data,
    failure_of,
    head_data,
    head_lines,
    line,
    name_in_files,
    remark_lines,
    status_name,
)

NOT_POSITIONS = ("design", "flank", "ends")
PATH_FIELDS = tuple(field.name for field in fields(ContactPath) if field.name not in NOT_POSITIONS)
SHOWN = (
    *("pinion_roll", "gear_roll", "pinion_z", "pinion_r", "gear_z", "gear_r", "l1", "l2"),
    "transmission_error",
)
"""Columns of the text."""
PRESSED = (
    *("pinion_roll", "least_curvature", "greatest_curvature", "major_semi_axis", "minor_semi_axis"),
    *("ellipse_angle", "pressure"),
)
"""Columns of the text under a load."""

OF_LINE_ENDS = ("l1", "l2", "pinion_z", "pinion_r", "gear_z", "gear_r", "point")
LINE_RATIOS = ("transverse_ratio", "overlap_ratio", "total_ratio")
LINE_ENDS = ("first", "last")
LINES_SHOWN = ("pinion_z", "pinion_r", "gear_r")
"""Of both ends, in the text."""


@dataclass(frozen=True, eq=False)
class ContactReport:
    """A path of contact with all that it is to be read with.

    `certificate` says at which positions nothing of the teeth touches earlier, None if that was not
    asked for or the pair cannot be put together (`backlash`); `reason` why there is no contact on the
    flanks, None if there is; `remarks` on layout and path, what matters most first; `advice` what to change
    about a layout without contact. `pressed`: ellipses and pressures under a load, None without one. `lines`:
    those along which flanks on parallel axes touch, None where they touch in points."""

    name: str
    design: Design
    method: str
    path: ContactPath
    backlash: BacklashReport
    certificate: Certificate | None
    reason: str | None
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]
    pressed: PathPressure | None = None
    lines: ContactLines | None = None

    @property
    def contact_ratio(self) -> float:
        """Contact ratio: 0 without contact on the flanks, NaN where that is not known."""
        return float(self.path.ends.contact_ratio)

    @property
    def failure(self) -> str | None:
        """Why there is no contact, or why the pair cannot be assembled."""
        return failure_of(self.reason, self.design)

    @property
    def positions(self) -> dict[str, Any]:
        """Numbers of the positions by their names in JSON and CSV."""
        numbers = {name: getattr(self.path, name) for name in PATH_FIELDS}
        return numbers | {"status": [status_name(code) for code in self.path.status]}

    @property
    def certified(self) -> dict[str, Any]:
        """The certificate by its names in JSON and CSV, nothing without one."""
        if self.certificate is None:
            return {}
        verdicts = [name_in_files(Verdict(int(code))) for code in self.certificate.verdict]
        return {"separation": self.certificate.separation, "verdict": verdicts}

    @property
    def certified_count(self) -> int:
        """At how many positions nothing touches earlier."""
        return int(self.certified.get("verdict", []).count("first_contact"))

    @property
    def pressures(self) -> dict[str, Any]:
        """Ellipses and pressures by their names in JSON and CSV, nothing without a load."""
        found = self.pressed
        if found is None:
            return {}
        least, greatest = found.curvature.T
        major, minor = found.semi_axes.T
        ellipses = [name_in_files(EllipseStatus(int(code))) for code in found.status]
        limits = ["none" if code == WHOLE else name_in_files(Limit(int(code))) for code in found.reaches]
        return {
            "force": found.force,
            "least_curvature": least,
            "greatest_curvature": greatest,
            "major_semi_axis": major,
            "minor_semi_axis": minor,
            "major_direction": found.direction[:, 0],
            "ellipse_angle": found.angle,
            "pressure": found.pressure,
            "reaches": [n if known == "ellipse" else None for n, known in zip(limits, ellipses, strict=True)],
            "ellipse": ellipses,
        }

    def data(self) -> dict[str, Any]:
        """Give the path, its ends, what was found of it."""
        ends = self.path.ends
        data = {
            **head_data(self.name, self.design, self.path.flank),
            "method": self.method,
            "status": status_name(int(ends.status)),
            "contact_ratio": self.contact_ratio,
            "ends": ends_data(self.path.ends),
            "path": self.positions,
            **remarks_data(self.remarks),
        }
        if self.certificate is not None:
            data["certificate"] = self.certified
        if self.pressed is not None:
            material = {"youngs_modulus_mpa": self.pressed.load.young, "poisson": self.pressed.load.poisson}
            data["hertz"] = material | self.pressures
        if self.lines is not None:
            data["contact_lines"] = lines_data(self.lines)
        if self.reason:
            data |= {"reason": self.reason, "advice": advice_data(self.advice)}
        return data

    def rows(self) -> Rows:
        """Give the positions."""
        backlash = np.full(self.path.status.size, self.backlash.normal)
        lines = {} if self.lines is None else lines_rows(self.lines)
        return {**self.positions, "mounted_backlash": backlash, **self.certified, **self.pressures, **lines}

    @property
    def lost_ellipses(self) -> list[str]:
        """Give 'solved' for each position with an ellipse, for others why there is none."""
        names, path = self.pressures["ellipse"], self.positions["status"]
        known = ["solved" if name == "ellipse" else name for name in names]
        return [state if state != "solved" else own for state, own in zip(path, known, strict=True)]

    def pressure_words(self, found: PathPressure) -> str:
        """Say the range of pressures along the path, and under what load."""
        load, known = found.load, found.pressure[np.isfinite(found.pressure)]
        force = f"{load.force:.6g} N" if load.force else f"{load.torque_nm:.6g} N m on the pinion"
        material = f"E {load.young:.6g} MPa, Poisson's ratio {load.poisson:.3g}"
        span = f"{known.min():.2f} to {known.max():.2f} MPa" if known.size else "not known"
        return f"{span} along the path, one tooth pair under {force}; {material}"

    def summary(self) -> str:
        """Write the positions, then what they come to, notes last."""
        path = self.path
        text = f"Path of contact of {self.name}, {path.flank} flanks, {self.method} method\n"
        if not self.reason:
            rows = self.rows()
            text += "\n" + table_lines({name: rows[name] for name in SHOWN}, rows["status"]) + "\n"
            if self.lines is not None:
                text += lines_table(self.lines) + "\n"
            if self.pressed is not None:
                words = {"reaches": [(name or "").replace("_", " ") for name in rows["reaches"]]}
                pressed = {name: rows[name] for name in PRESSED}
                text += table_lines(pressed, self.lost_ellipses, words) + "\n"
        text += head_lines(self.design)
        ratio = self.contact_ratio
        text += line("contact ratio", "not known" if math.isnan(ratio) else number("contact_ratio", ratio))
        if not self.reason:
            text += line("path", end_words(path.ends))
        if self.lines is not None:
            text += ratio_lines(self.lines)
        if self.pressed is not None and not self.reason:
            text += line("greatest pressure", self.pressure_words(self.pressed))
        if self.certificate is not None:
            count = f"at {self.certified_count} of {path.status.size} positions"
            text += line("certified", f"{count} nothing on this side touches earlier")
        backlash = float(mounting_of(self.design).normal_backlash)
        if not math.isnan(backlash):
            text += line("normal backlash", f"{backlash:z.6f} mm without errors and parabolas")
        text += line("as mounted", f"backlash {self.backlash.line}")
        return text + remark_lines(self.remarks) + advice_lines(self.advice)


def contact_report(
    name: str,
    design: Design,
    flank: str,
    points: int,
    method: str = "one-equation",
    certified: bool = True,
    load: Load | None = None,
) -> ContactReport:
    """Find the path of contact of a single design by `method`, 'one-equation' or 'five-equation',
    `certified` or not: that takes most of the time; pressed together under a `load`, if there is one."""
    if method == "five-equation":
        from ..reference.five_equations import path_of_contact_five_equations

        path = path_of_contact_five_equations(design, flank, points)
    else:
        path = path_of_contact(design, flank, points)
    reason, backlash = reason_of(path), backlash_report(design)
    certifiable = certified and not (reason or backlash.fault or backlash.jam)
    certificate = certify(path) if certifiable else None
    remarks = [
        *layout_remarks(design, flanks=(flank,), jam=backlash.jam),
        *path_remarks(path),
        *(certificate_remarks(path, certificate) if certificate else ()),
    ]
    if backlash.fault and certified and not reason:
        remarks.append(Remark(NOTE, f"whether something touches earlier is not known: {backlash.fault}"))
    advice = advice_on(design) if reason else ()
    pressed = None if load is None else pressure_along(path, load)
    remarks += [] if pressed is None else pressure_remarks(pressed)
    lines = contact_lines(path) if not reason and touches_along_lines(design, flank) else None
    return ContactReport(
        name, design, method, path, backlash, certificate, reason, in_order(remarks), advice, pressed, lines
    )


def _limits(lines: ContactLines, words: bool) -> list[list[str]]:
    """Give the limit of both ends of each line, in words or as files have it."""
    return [
        [str(limit) if words else name_in_files(limit) for limit in map(Limit, map(int, row))]
        for row in lines.limit
    ]


def lines_data(lines: ContactLines) -> dict[str, Any]:
    """Give JSON: ratios, and of each line roll, length, both ends and the limits there; mm and rad."""
    values = {
        name: getattr(lines, name)
        for name in (*LINE_RATIOS, "pinion_roll", "gear_roll", "length", *OF_LINE_ENDS)
    }
    return {**values, "limit": _limits(lines, words=False)}


def lines_rows(lines: ContactLines) -> Rows:
    """Give columns of CSV, one row for each line: length, and both ends of it."""
    ends = {
        f"line_{end}_{name}": getattr(lines, name)[:, k]
        for k, end in enumerate(LINE_ENDS)
        for name in OF_LINE_ENDS
    }
    limits = _limits(lines, words=False)
    return {
        "line_length": lines.length,
        **ends,
        **{f"line_{end}_limit": [row[k] for row in limits] for k, end in enumerate(LINE_ENDS)},
    }


def lines_table(lines: ContactLines) -> str:
    """Write a table of the lines, the end nearer to the pinion's toe first."""
    columns = {"pinion_roll": lines.pinion_roll, "length": lines.length}
    columns |= {
        f"{end}_{name}": getattr(lines, name)[:, k] for k, end in enumerate(LINE_ENDS) for name in LINES_SHOWN
    }
    words = {"from, to": [" to ".join(row) for row in _limits(lines, words=True)]}
    return table_lines(columns, ["solved"] * lines.length.size, words)


def ratio_lines(lines: ContactLines) -> str:
    """Write the contact ratios of ISO 21771."""
    transverse, overlap, total = (number("contact_ratio", getattr(lines, name)) for name in LINE_RATIOS)
    text = f"transverse {transverse} at mid-face, overlap {overlap}, total {total}"
    return line("contact lines", f"the flanks touch along lines: contact ratios {text}")
