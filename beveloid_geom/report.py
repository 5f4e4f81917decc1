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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from .certificate import Certificate, Verdict, certify
from .closing import INTERFERENCE_TOLERANCE, OFFSET_TOLERANCE, closing_offset
from .conditioning import rounding_error
from .contact import Limit
from .fillet import tool_round
from .first_contact import FirstStatus
from .flank import highest_parameter, root_parameter
from .inputs import Design, Errors
from .mounting import Mounting, mounting_of
from .path import ContactPath, path_of_contact
from .solve import Status

ROUNDING_TOLERANCE = 1e-9
"""mm by which rounding may move a contact without a note."""
UNITS = {"pinion_roll": "rad", "gear_roll": "rad", "transmission_error": "rad", "normal": "", "status": ""}
"""Units of the fields of a path where they are not mm."""
PATH_FIELDS = tuple(field.name for field in fields(ContactPath) if field.name not in ("flank", "ends"))

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
    asked for; `reason` why there is no contact on the flanks, None if there is; `notes` what a
    contact ratio or a path does not."""

    name: str
    design: Design
    method: str
    path: ContactPath
    mounting: Mounting
    certificate: Certificate | None
    reason: str | None
    notes: tuple[str, ...]

    @property
    def contact_ratio(self) -> float:
        """Contact ratio: 0 without contact on the flanks, NaN where the path could not be followed."""
        return float(self.path.ends.contact_ratio)


def contact_report(
    name: str, design: Design, flank: str, points: int, method: str, certified: bool = True
) -> ContactReport:
    """Path of contact of a single design by `method`, 'one-equation' or 'five-equation', `certified`
    or not: that takes most of the time."""
    if method == "five-equation":
        from .five_equations import path_of_contact_five_equations

        path = path_of_contact_five_equations(design, flank, points)
    else:
        path = path_of_contact(design, flank, points)
    reason = _reason(design, path)
    fault = first_contact_fault(design)
    certificate = certify(design, path) if certified and not reason and not fault else None
    notes = () if reason else _notes(design, path, certificate)
    if fault and certified and not reason:
        notes = (*notes, f"whether something touches earlier is not known: {fault}")
    return ContactReport(name, design, method, path, mounting_of(design), certificate, reason, notes)


def first_contact_fault(design: Design) -> str | None:
    """Why first contacts cannot be found: a tool without a round that fits has no fillets to offer."""
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        try:
            tool_round(member.tool, "right")
        except ValueError as error:
            return f"{name}: {error}"
    return None


def _reason(design: Design, path: ContactPath) -> str | None:
    """Why a path has no point on the flanks."""
    status = Status(int(path.ends.status))
    if status == Status.SOLVED:
        return None
    if status == Status.NO_COMMON_NORMAL or bool(np.isnan(mounting_of(design).gap)):
        return f"the {path.flank} flanks have no common normal in this layout: is the shaft angle right?"
    if status != Status.OFF_FLANK:
        words = status_name(status).replace("_", " ")
        return f"the path of contact on the {path.flank} flanks could not be followed: {words}"
    text = f"the path of contact does not meet the {path.flank} flanks"
    middle = 0.5 * (root_parameter(design.pinion) + highest_parameter(design.pinion))
    beyond = path_of_contact(design, path.flank, l1=[float(middle)])
    where = [
        f"{axial[0]:+.4g} mm on the {member} (half face width {0.5 * float(teeth.face_width):g} mm)"
        for member, axial, teeth in (
            ("pinion", beyond.pinion_z, design.pinion),
            ("gear", beyond.gear_z, design.gear),
        )
        if math.isfinite(axial[0])
    ]
    return f"{text}: at mid-depth of the pinion it runs at z = {' and '.join(where)}" if where else text


def _notes(design: Design, path: ContactPath, certificate: Certificate | None) -> tuple[str, ...]:
    notes = []
    difference = closing_offset(design) - float(design.pair.offset)
    module = float(design.pinion.tool.normal_module)
    if abs(difference) > OFFSET_TOLERANCE * module:
        closes = f"the lines of action would meet at an offset of {difference:+.3g} mm from the design's"
        notes.append(f"the design does not close, {closes}: see `beveloid-geom check`")
    backlash = float(mounting_of(design).normal_backlash)
    if backlash < -INTERFERENCE_TOLERANCE * module:
        notes.append(f"the normal backlash is {backlash:.4f} mm: the other flanks interfere")
    if path.ends.pieces > 1:
        pieces = f"the path lies on the flanks in {int(path.ends.pieces)} pieces"
        notes.append(f"{pieces}: this is the one that covers most roll, the contact ratio is its own")
    if 0.0 < path.ends.contact_ratio < 1.0:
        notes.append("the contact ratio is below 1: one tooth pair leaves before the next one enters")
    steps = np.diff(path.pinion_roll)
    if steps.size and steps.min() < 0.0 < steps.max():
        notes.append("the roll turns back along the path: the flanks are tangent twice at some rolls")
    if path.normal.size and path.normal[:, 0].min() < 0.0 < path.normal[:, 0].max():
        notes.append("the common normal crosses n_x = 0 on the path, which small errors move far there")
    moved = rounding_error(design, path).max(initial=0.0)
    if moved > ROUNDING_TOLERANCE:
        notes.append(
            f"rounding of the inputs alone moves the contact by about {moved:.1g} mm: mind the errors"
        )
    missing = int(np.count_nonzero(path.status != Status.SOLVED))
    if missing:
        notes.append(f"{missing} of {path.status.size} positions are not solved")
    return (*notes, *(_certificate_notes(certificate) if certificate is not None else ()))


def _certificate_notes(certificate: Certificate) -> Iterator[str]:
    """Where the tangency of the flanks is not the contact of the teeth."""
    verdict, all_positions = certificate.verdict, certificate.verdict.size
    said = {
        Verdict.NEXT_PAIR: "the flanks of a neighbouring tooth pair touch earlier",
        Verdict.EDGE_CONTACT: f"an edge touches earlier ({_edges_of(certificate)})",
        Verdict.INTERFERENCE: "the flanks cut into each other beside their tangency, or a tip into a fillet",
    }
    for code, words in said.items():
        found = verdict == code
        if found.any():
            depth = -1e3 * float(certificate.separation[found].min())
            count = f"at {np.count_nonzero(found)} of {all_positions} positions"
            yield f"{count} {words}, by up to {depth:.3g} um"
    if np.isin(verdict, tuple(said)).any():
        yield "the contact ratio, Eq. 16, is not an operating one: see `beveloid-geom operation`"
    unknown = np.unique(certificate.first.status[verdict == Verdict.NOT_SOLVED])
    for status in unknown:
        found = status == FirstStatus.SOLVED  # but not as near as the position itself
        words = "the search missed it" if found else FirstStatus(int(status)).name.lower().replace("_", " ")
        yield f"whether something touches earlier is not known at all positions: {words}"


def _edges_of(certificate: Certificate) -> str:
    """Names of the edges that touch earlier."""
    codes = certificate.first.limit[certificate.verdict == Verdict.EDGE_CONTACT]
    return ", ".join(str(Limit(int(code))) for code in np.unique(codes[codes >= 0]))


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
        "contact_ratio": report.contact_ratio,
        **layout_data(report.design, report.mounting),
        "parabola": {"pinion": report.design.pinion.tool.parabola, "gear": report.design.gear.tool.parabola},
        "ends": {"enter": _end_data(path.ends.enter), "leave": _end_data(path.ends.leave)},
        "path": {name: getattr(path, name) for name in PATH_FIELDS},
        "notes": report.notes,
    }
    data["path"]["status"] = [status_name(code) for code in path.status]
    if report.certificate is not None:
        data["certificate"] = {
            "verdict": [verdict_name(code) for code in report.certificate.verdict],
            "separation": report.certificate.separation,
        }
    if report.reason:
        data["reason"] = report.reason
    return json_text(data)


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
    if report.certificate is not None:
        header += ["separation_mm", "verdict"]
        columns.append(report.certificate.separation.tolist())
        columns.append([verdict_name(code) for code in report.certificate.verdict])
    return csv_text(header, columns)


def line(label: str, text: str) -> str:
    """A line of a table: a label, and text that is broken where it is long."""
    indent = " " * 21
    return textwrap.fill(f"{label:<19}{text}", 100, initial_indent="  ", subsequent_indent=indent) + "\n"


def _stand_words(mounting: Mounting) -> str:
    if np.isnan(mounting.distance).any():
        return "no mounting distances: the flanks have no common normal"
    return "dw1 = {:.6f} mm, dw2 = {:.6f} mm".format(*mounting.distance)


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
    text += parabola_line(report.design)
    ratio = report.contact_ratio
    text += line("contact ratio", "not known" if math.isnan(ratio) else f"{ratio:.6f}")
    if not report.reason:
        text += line("path", _end_words((path.ends.enter, path.ends.leave)))
    if report.certificate is not None:
        good = np.count_nonzero(report.certificate.verdict == Verdict.FIRST_CONTACT)
        text += line(
            "certified", f"{good} of {path.status.size} positions: nothing on this side touches earlier"
        )
    backlash = float(mounting.normal_backlash)
    if not math.isnan(backlash):
        text += line("normal backlash", f"{backlash:.6f} mm without errors and parabolas")
    text += "".join(line("note", note) for note in report.notes)
    return text if report.reason else f"{text}\n{_position_lines(path)}"
