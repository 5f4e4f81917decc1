"""Results as text: tables to read, JSON and CSV to go on with.

JSON and CSV hold mm and rad, tables degrees and arc seconds. JSON is strict: null stands for
what is not known, NaN inside. CSV leaves the cell empty.
"""

from __future__ import annotations

import csv
import io
import json
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design, Errors
from ..findings.advice import Advice, advice_on
from ..findings.layout import layout_remarks
from ..findings.path import path_remarks, reason_of
from ..findings.remarks import NOTE, Remark, in_order, remarks_data
from ..operation.certificate import Certificate, certify
from ..pair.mounting import Mounting, mounting_of
from ..status import Limit, Status, Verdict
from .backlash import BacklashReport, backlash_data, backlash_report

UNITS = {"pinion_roll": "rad", "gear_roll": "rad", "transmission_error": "rad", "normal": "", "status": ""}
"""Units of the fields of a path where they are not mm."""
NOT_POSITIONS = ("design", "flank", "ends")
PATH_FIELDS = tuple(field.name for field in fields(ContactPath) if field.name not in NOT_POSITIONS)

COLUMNS = (
    ("pinion_roll", "pinion roll", "deg", 12, 6),
    ("gear_roll", "gear roll", "deg", 12, 6),
    ("pinion_z", "pinion z", "mm", 10, 4),
    ("pinion_r", "pinion r", "mm", 10, 4),
    ("gear_z", "gear z", "mm", 10, 4),
    ("gear_r", "gear r", "mm", 10, 4),
    ("l1", "l1", "mm", 10, 4),
    ("l2", "l2", "mm", 10, 4),
    ("transmission_error", "tr. error", "arcsec", 11, 4),
)
"""Columns of the table: field, heading, unit, width, digits after the point."""
TABLE_SCALES = {"deg": math.degrees(1.0), "arcsec": math.degrees(3600.0), "mm": 1.0}


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
    mounting: Mounting
    backlash: BacklashReport
    certificate: Certificate | None
    reason: str | None
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]

    @property
    def contact_ratio(self) -> float:
        """Contact ratio: 0 without contact on the flanks, NaN where that is not known."""
        return float(self.path.ends.contact_ratio)


def contact_report(
    name: str, design: Design, flank: str, points: int, method: str, certified: bool = True
) -> ContactReport:
    """Path of contact of a single design by `method`, 'one-equation' or 'five-equation', `certified`
    or not: that takes most of the time."""
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
    return ContactReport(
        name=name,
        design=design,
        method=method,
        path=path,
        mounting=mounting_of(design),
        backlash=backlash,
        certificate=certificate,
        reason=reason,
        remarks=in_order(remarks),
        advice=advice_on(design) if reason else (),
    )


def verdict_name(verdict: int) -> str:
    """Name of a verdict in files: lower case with underscores."""
    return Verdict(int(verdict)).name.lower()


def status_name(status: int) -> str:
    """Name of a status in files: lower case with underscores."""
    return Status(int(status)).name.lower()


def json_text(data: Any) -> str:
    """One line of strict JSON, null for every number that is not finite."""

    def strict(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: strict(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [strict(item) for item in value]
        if isinstance(value, np.ndarray | np.generic):
            return strict(value.tolist())
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(strict(data), allow_nan=False) + "\n"


def layout_data(design: Design, mounting: Mounting) -> dict[str, Any]:
    """The entries that say in what layout a result was found."""
    return {
        "layout": {
            "offset": design.pair.offset,
            "shaft_angle": design.pair.shaft_angle,
            "errors": dict(vars(design.errors)),
        },
        "mounting": {
            "dw1": mounting.distance[0],
            "dw2": mounting.distance[1],
            "rw1": mounting.working_radius[0],
            "rw2": mounting.working_radius[1],
            "pitch_point": mounting.pitch_point,
        },
        "normal_backlash": mounting.normal_backlash,
        **backlash_data(design),
    }


def _end_data(limit: Limit | None) -> dict[str, str] | None:
    return None if limit is None else {"member": limit.member, "limit": limit.limit}


def contact_json(report: ContactReport) -> str:
    """Strict JSON of a path of contact, mm and rad."""
    path = report.path
    data: dict[str, Any] = {
        "design": report.name,
        "flank": path.flank,
        "method": report.method,
        "status": status_name(int(path.ends.status)),
        "contact_ratio": report.contact_ratio,
        **layout_data(report.design, report.mounting),
        "parabola": {"pinion": report.design.pinion.tool.parabola, "gear": report.design.gear.tool.parabola},
        "ends": {"enter": _end_data(path.ends.enter), "leave": _end_data(path.ends.leave)},
        "path": {name: getattr(path, name) for name in PATH_FIELDS},
        **remarks_data(report.remarks),
    }
    data["path"]["status"] = [status_name(code) for code in path.status]
    if report.certificate is not None:
        data["certificate"] = {
            "verdict": [verdict_name(code) for code in report.certificate.verdict],
            "separation": report.certificate.separation,
        }
    if report.reason:
        data["reason"] = report.reason
        data["advice"] = advice_data(report.advice)
    return json_text(data)


def advice_data(advice: Sequence[Advice]) -> list[dict[str, Any]]:
    """Entries of JSON: each change with all that it needs, mm and rad, and in words."""
    return [{**vars(one), "text": one.words()} for one in advice]


def csv_text(header: Sequence[str], columns: Sequence[Sequence[object]]) -> str:
    """CSV of columns of equal length; the cell of what is not known stays empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in zip(*columns, strict=True):
        writer.writerow("" if isinstance(value, float) and math.isnan(value) else value for value in row)
    return text.getvalue()


def contact_csv(report: ContactReport) -> str:
    """CSV of the positions, one a row, mm and rad, units in the header."""
    header: list[str] = []
    columns: list[list[float] | list[str]] = []
    for name in PATH_FIELDS:
        values, unit = getattr(report.path, name), UNITS.get(name, "mm")
        suffix = f"_{unit}" if unit else ""
        if name == "status":
            header.append(name)
            columns.append([status_name(code) for code in values])
        elif values.ndim > 1:
            header += [f"{name}_{axis}{suffix}" for axis in "xyz"]
            columns += values.T.tolist()
        else:
            header.append(f"{name}{suffix}")
            columns.append(values.tolist())
    header.append("mounted_backlash_mm")
    columns.append([report.backlash.normal] * report.path.status.size)
    if report.certificate is not None:
        header += ["separation_mm", "verdict"]
        columns.append(report.certificate.separation.tolist())
        columns.append([verdict_name(code) for code in report.certificate.verdict])
    return csv_text(header, columns)


def line(label: str, text: str) -> str:
    """A line of a table: a label, and text that is broken where it is long."""
    indent = " " * 21
    return textwrap.fill(f"{label:<19}{text}", 100, initial_indent="  ", subsequent_indent=indent) + "\n"


def remark_lines(remarks: Sequence[Remark], advice: Sequence[Advice] = ()) -> str:
    """Lines of a table: what was found, what matters most first, and what to change."""
    text = "".join(line(remark.level, remark.text) for remark in remarks)
    return text + "".join(line("advice" if k == 0 else "or", one.words()) for k, one in enumerate(advice))


def _stand_words(mounting: Mounting) -> str:
    if np.isnan(mounting.distance).any():
        return "no mounting distances: the flanks have no common normal"
    return "dw1 = {:z.6f} mm, dw2 = {:z.6f} mm".format(*mounting.distance)


def _axes_words(offset: float, shaft_angle: float) -> str:
    return f"E = {offset:.9g} mm, shaft angle = {math.degrees(shaft_angle):.9g} deg"


def layout_line(design: Design, mounting: Mounting) -> str:
    """The layout, without which a result means nothing."""
    axes = _axes_words(float(design.pair.offset), float(design.pair.shaft_angle))
    return line("layout", f"{axes}, {_stand_words(mounting)}")


def error_line(errors: Errors) -> str:
    """The assembly errors, nothing where there are none."""
    found = (
        ("offset", float(errors.offset), "mm"),
        ("shaft angle", math.degrees(float(errors.shaft_angle)), "deg"),
        ("pinion axial", float(errors.pinion_axial), "mm"),
        ("gear axial", float(errors.gear_axial), "mm"),
    )
    text = ", ".join(f"{name} {value:+.6g} {unit}" for name, value, unit in found if value != 0.0)
    return line("errors", text) if text else ""


def backlash_lines(design: Design) -> str:
    """The backlash as mounted and modified, and that the pair cannot be put together, if that is so."""
    report = backlash_report(design)
    return line("as mounted", f"backlash {report.line}") + (line("jammed", report.jam) if report.jam else "")


def parabola_line(design: Design) -> str:
    """The parabola coefficients, nothing where there are none."""
    parabolas = [float(member.tool.parabola) for member in design.members]
    return line("parabola", "pinion {:g} 1/mm, gear {:g} 1/mm".format(*parabolas)) if any(parabolas) else ""


def _end_words(ends: tuple[Limit | None, Limit | None]) -> str:
    words = (f"the {end.member}'s {end.limit}" if end is not None else "an unknown limit" for end in ends)
    return "enters at {}, leaves at {}".format(*words)


def _position_lines(path: ContactPath) -> str:
    lines = ["".join(f"{column[part]:>{column[3]}}" for column in COLUMNS) for part in (1, 2)]
    scaled = [getattr(path, column[0]) * TABLE_SCALES[column[2]] for column in COLUMNS]
    for row, values in enumerate(zip(*scaled, strict=True)):
        if path.status[row] == Status.SOLVED:
            shown = (f"{value:z{c[3]}.{c[4]}f}" for value, c in zip(values, COLUMNS, strict=True))
            lines.append("".join(shown))
        else:
            lines.append(f"{status_name(path.status[row]):>{COLUMNS[0][3] + COLUMNS[1][3]}}")
    return "\n".join(lines) + "\n"


def contact_table(report: ContactReport) -> str:
    """Readable table of a path of contact, at most 100 characters wide, in mm and deg."""
    path, mounting = report.path, report.mounting
    text = f"Path of contact of {report.name}, {path.flank} flanks, {report.method} method\n"
    text += layout_line(report.design, mounting) + error_line(report.design.errors)
    first = [remark for remark in report.remarks if remark.level != NOTE]
    text += parabola_line(report.design) + remark_lines(first, report.advice)
    ratio = report.contact_ratio
    text += line("contact ratio", "not known" if math.isnan(ratio) else f"{ratio:.6f}")
    if not report.reason:
        text += line("path", _end_words((path.ends.enter, path.ends.leave)))
    if report.certificate is not None:
        good = np.count_nonzero(report.certificate.verdict == Verdict.FIRST_CONTACT)
        text += line(
            "certified", f"at {good} of {path.status.size} positions nothing on this side touches earlier"
        )
    backlash = float(mounting.normal_backlash)
    if not math.isnan(backlash):
        text += line("normal backlash", f"{backlash:.6f} mm without errors and parabolas")
    text += line("as mounted", f"backlash {report.backlash.line}")
    text += remark_lines([remark for remark in report.remarks if remark.level == NOTE])
    return text if report.reason else f"{text}\n{_position_lines(path)}"
