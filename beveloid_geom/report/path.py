"""A path of contact, with all that it is to be read with."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..findings.advice import Advice, advice_on
from ..findings.layout import layout_remarks
from ..findings.path import path_remarks, reason_of
from ..findings.remarks import NOTE, Remark, in_order, remarks_data
from ..operation.certificate import Certificate, certify
from ..pair.mounting import mounting_of
from ..status import Verdict
from .backlash import BacklashReport, backlash_report
from .columns import number, table_lines
from .result import Rows
from .words import (
    advice_data,
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


@dataclass(frozen=True, eq=False)
class ContactReport:
    """A path of contact with all that it is to be read with.

    `certificate` says at which positions nothing of the teeth touches earlier, None if that was not
    asked for or the pair cannot be put together (`backlash`); `reason` why there is no contact on the
    flanks, None if there is; `remarks` on layout and path, what matters most first; `advice` what to change
    about a layout without contact."""

    name: str
    design: Design
    method: str
    path: ContactPath
    backlash: BacklashReport
    certificate: Certificate | None
    reason: str | None
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]

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
        if self.reason:
            data |= {"reason": self.reason, "advice": advice_data(self.advice)}
        return data

    def rows(self) -> Rows:
        """Give the positions."""
        backlash = np.full(self.path.status.size, self.backlash.normal)
        return {**self.positions, "mounted_backlash": backlash, **self.certified}

    def summary(self) -> str:
        """Write the positions, then what they come to, notes last."""
        path = self.path
        text = f"Path of contact of {self.name}, {path.flank} flanks, {self.method} method\n"
        if not self.reason:
            rows = self.rows()
            text += "\n" + table_lines({name: rows[name] for name in SHOWN}, rows["status"]) + "\n"
        text += head_lines(self.design)
        ratio = self.contact_ratio
        text += line("contact ratio", "not known" if math.isnan(ratio) else number("contact_ratio", ratio))
        if not self.reason:
            text += line("path", end_words(path.ends))
        if self.certificate is not None:
            count = f"at {self.certified_count} of {path.status.size} positions"
            text += line("certified", f"{count} nothing on this side touches earlier")
        backlash = float(mounting_of(self.design).normal_backlash)
        if not math.isnan(backlash):
            text += line("normal backlash", f"{backlash:.6f} mm without errors and parabolas")
        text += line("as mounted", f"backlash {self.backlash.line}")
        return text + remark_lines(self.remarks, self.advice)


def contact_report(
    name: str, design: Design, flank: str, points: int, method: str = "one-equation", certified: bool = True
) -> ContactReport:
    """Find the path of contact of a single design by `method`, 'one-equation' or 'five-equation',
    `certified` or not: that takes most of the time."""
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
        *path_remarks(path, certificate),
    ]
    if backlash.fault and certified and not reason:
        remarks.append(Remark(NOTE, f"whether something touches earlier is not known: {backlash.fault}"))
    advice = advice_on(design) if reason else ()
    return ContactReport(name, design, method, path, backlash, certificate, reason, in_order(remarks), advice)
