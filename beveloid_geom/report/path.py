"""Report of `tca`: a path of contact with certificate, pressures and remarks."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..analysis.pressure import Load, PathPressure, path_pressure
from ..contact.flank_pair import is_modified
from ..contact.parallel.lines import ContactLines, contact_lines, is_line_contact
from ..contact.path import ContactPath, path_of_contact
from ..design.ends import limit_words
from ..design.model import Design
from ..findings.advice import Advice, layout_advice
from ..findings.backlash import BacklashReport, backlash_report
from ..findings.diagnostics import UNKNOWN, Remark, in_order, remarks_data
from ..findings.layout import layout_remarks
from ..findings.path import certificate_remarks, path_remarks, pressure_remarks, reason_of
from ..findings.units import unit_remarks
from ..operation.certificate import Certificate, path_certificate
from ..pair.mounting import mounting_of
from .columns import number, table_lines
from .result import Report, Rows, advice_data, ends_data, picked
from .text import advice_lines, end_words, head_lines, line, remark_lines

LINE_END_FIELDS = ("l1", "l2", "pinion_z", "pinion_r", "gear_z", "gear_r", "point")
"""Quantities of both ends of a line of contact."""
LINE_ENDS = ("first", "last")


@dataclass(frozen=True, eq=False)
class ContactReport(Report):
    """Path of contact of one flank pair of a single design, with its evaluation.

    Attributes
    ----------
    method : str
        'one-equation' or 'five-equation'.
    path : ContactPath
    backlash : BacklashReport
        Backlash as mounted.
    certificate : Certificate or None
        Positions at which nothing touches earlier; None if it was not requested or the pair cannot be
        assembled.
    reason : str or None
        Reason for missing contact on the flanks.
    remarks : tuple of Remark
        Remarks on layout and path, the most important first.
    advice : tuple of Advice
        Changes of a layout without contact.
    pressed : PathPressure or None
        Contact ellipses and pressures under a load.
    lines : ContactLines or None
        Lines of contact of flanks on parallel axes.
    """

    needs_assembly = True
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
    def flank(self) -> str:
        """Driving flanks."""
        return self.path.flank

    @property
    def contact_ratio(self) -> float:
        """Contact ratio: 0 without contact on the flanks, NaN if unknown."""
        return float(self.path.ends.contact_ratio)

    @property
    def positions(self) -> dict[str, Any]:
        """Columns of the positions in JSON and CSV."""
        # Quantities of a position.
        path_fields = tuple(
            field.name for field in fields(ContactPath) if field.name not in ("design", "flank", "ends")
        )
        return picked(self.path, *path_fields)

    @property
    def certified(self) -> dict[str, Any]:
        """Columns of the certificate in JSON and CSV, empty without one."""
        return {} if self.certificate is None else picked(self.certificate, "separation", "verdict")

    @property
    def certified_count(self) -> int:
        """Number of positions at which nothing touches earlier."""
        return int(self.certified.get("verdict", []).count("first_contact"))

    @property
    def pressures(self) -> dict[str, Any]:
        """Columns of ellipses and pressures in JSON and CSV, empty without a load."""
        result = self.pressed
        if result is None:
            return {}
        least, greatest = result.curvature.T
        major, minor = result.semi_axes.T
        ellipses, limits = picked(result, "status", "reaches").values()
        return {
            "force": result.force,
            "least_curvature": least,
            "greatest_curvature": greatest,
            "major_semi_axis": major,
            "minor_semi_axis": minor,
            "major_direction": result.direction[:, 0],
            "ellipse_angle": result.angle,
            "pressure": result.pressure,
            "total_length": result.total_length,
            "reaches": [
                limit or "none" if known == "ellipse" else None
                for limit, known in zip(limits, ellipses, strict=True)
            ],
            "ellipse": ellipses,
        }

    def values(self) -> dict[str, Any]:
        """Return path, ends, remarks, certificate, pressures and lines of contact."""
        ends = self.path.ends
        values = {
            "method": self.method,
            **picked(ends, "status"),
            "contact_ratio": self.contact_ratio,
            "ends": ends_data(ends),
            "path": self.positions,
            **remarks_data(self.remarks),
        }
        if self.certificate is not None:
            values["certificate"] = self.certified
        if self.pressed is not None:
            material = {"youngs_modulus_mpa": self.pressed.load.young, "poisson": self.pressed.load.poisson}
            values["hertz"] = material | self.pressures
        if self.lines is not None:
            values["contact_lines"] = lines_data(self.lines)
        return values

    def data(self) -> dict[str, Any]:
        """Return the content of JSON, with advice if there is no contact."""
        data: dict[str, Any] = super().data()
        return data | ({"advice": advice_data(self.advice)} if self.reason else {})

    def rows(self) -> Rows:
        """Return the positions."""
        lines = {} if self.lines is None else lines_rows(self.lines)
        backlash = {"mounted_backlash": self.backlash.normal}
        return self.positions | backlash | self.certified | self.pressures | lines

    @property
    def lost_pressures(self) -> list[str]:
        """'solved' for each position with a pressure, otherwise the reason for the missing pressure."""
        pressures, path = self.pressures, self.positions["status"]
        finite = np.isfinite(pressures["pressure"])
        states = ["solved" if ok else name for ok, name in zip(finite, pressures["ellipse"], strict=True)]
        return [
            on_path if on_path != "solved" else state for on_path, state in zip(path, states, strict=True)
        ]

    def pressure_words(self, pressed: PathPressure) -> str:
        """Return the range of pressures along the path, and the load."""
        load, finite = pressed.load, pressed.pressure[np.isfinite(pressed.pressure)]
        force = f"{load.force:.6g} N" if load.force else f"{load.torque_nm:.6g} N m on the pinion"
        material = f"E {load.young:.6g} MPa, Poisson's ratio {load.poisson:.3g}"
        span = f"{finite.min():.2f} to {finite.max():.2f} MPa" if finite.size else "not known"
        carriers = "one tooth pair" if self.lines is None else "all lines of contact together"
        return f"{span} along the path, {carriers} under {force}; {material}"

    def summary(self) -> str:
        """Return the positions, contact ratio, limits, backlash and remarks."""
        # Columns of the text under a load for line contact.
        pressed_lines = ("pinion_roll", "total_length", "greatest_curvature", "minor_semi_axis", "pressure")
        path = self.path
        text = f"Path of contact of {self.name}, {path.flank} flanks, {self.method} method\n"
        shown_columns = (
            *("pinion_roll", "gear_roll", "pinion_z", "pinion_r", "gear_z", "gear_r", "l1", "l2"),
            "transmission_error",
        )
        pressure_columns = (
            *("pinion_roll", "least_curvature", "greatest_curvature", "major_semi_axis", "minor_semi_axis"),
            *("ellipse_angle", "pressure"),
        )
        if not self.reason:
            rows = self.rows()
            text += "\n" + table_lines({name: rows[name] for name in shown_columns}, rows["status"]) + "\n"
            if self.lines is not None:
                text += lines_table(self.design, self.lines) + "\n"
            if self.pressed is not None:
                words = {"reaches": [(name or "").replace("_", " ") for name in rows["reaches"]]}
                if self.lines is not None:  # a path may leave the lines on a relief
                    kinds = [name.replace("_", " ") for name in rows["ellipse"]]
                    words = {"contact": kinds} if "ellipse" in kinds else {}
                shown = pressure_columns if self.lines is None else pressed_lines
                pressed = {name: rows[name] for name in shown}
                text += table_lines(pressed, self.lost_pressures, words) + "\n"
        text += head_lines(self.design)
        ratio = self.contact_ratio
        text += line("contact ratio", "not known" if math.isnan(ratio) else number("contact_ratio", ratio))
        if not self.reason:
            text += line("path", end_words(self.design, path.ends))
            places = "z from mid-face and r from the axis of the member; l1 and l2 along the tool flank"
            text += line("z, r, l1, l2", f"{places} from the apex of its parabola, positive towards the tip")
        if self.lines is not None:
            text += ratio_lines(self.lines)
        if self.pressed is not None and not self.reason:
            text += line("largest pressure", self.pressure_words(self.pressed))
            if self.lines is None:
                angle = "angle of the major axis from the tooth trace of the pinion towards the tip"
                text += line("ellipse", f"{angle}; reaches: edge of a flank beyond which the ellipse extends")
        if self.certificate is not None:
            count = f"at {self.certified_count} of {path.status.size} positions"
            text += line("certified", f"{count} nothing on the driving flanks touches earlier")
        backlash = float(mounting_of(self.design).normal_backlash)
        if not math.isnan(backlash):
            text += line("normal backlash", f"{backlash:z.6f} mm without errors and modifications")
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
    """Return the path of contact of a single design with its evaluation.

    Parameters
    ----------
    name : str
        Name of the design in the report.
    design : Design
        Design of plain numbers.
    flank : {'right', 'left'}
    points : int
        Number of positions.
    method : {'one-equation', 'five-equation'}
    certified : bool
        Whether the path is certified; this takes most of the time.
    load : Load, optional
        Load for contact ellipses and pressures.

    Returns
    -------
    ContactReport
    """
    if method == "five-equation":
        from ..validation.five_equations import path_of_contact_five_equations

        path = path_of_contact_five_equations(design, flank, points)
    else:
        path = path_of_contact(design, flank, points)
    reason, backlash = reason_of(path), backlash_report(design)
    certifiable = certified and not (reason or backlash.fault or backlash.jam)
    certificate = path_certificate(path) if certifiable else None
    remarks = [
        *layout_remarks(design, flanks=(flank,), jam=backlash.jam),
        *unit_remarks(design),
        *backlash.remarks,
        *path_remarks(path),
        *(certificate_remarks(path, certificate) if certificate else ()),
    ]
    if backlash.fault and certified and not reason:
        remarks.append(Remark(UNKNOWN, f"whether something touches earlier is unknown: {backlash.fault}"))
    advice = layout_advice(design) if reason else ()
    pressed = None if load is None else path_pressure(path, load)
    remarks += [] if pressed is None else pressure_remarks(pressed)
    lines = contact_lines(path) if not reason and is_line_contact(design, flank) else None
    return ContactReport(
        name, design, method, path, backlash, certificate, reason, in_order(remarks), advice, pressed, lines
    )


def lines_data(lines: ContactLines) -> dict[str, Any]:
    """Return contact ratios, and roll angles, length, both ends and limits of each line; mm and rad."""
    ratios = ("transverse_ratio", "overlap_ratio", "total_ratio")
    return picked(lines, *ratios, "pinion_roll", "gear_roll", "length", *LINE_END_FIELDS, "limit")


def lines_rows(lines: ContactLines) -> dict[str, Any]:
    """Return columns of CSV, one row for each line: length and both ends."""
    ends = {
        f"line_{end}_{name}": getattr(lines, name)[:, k]
        for k, end in enumerate(LINE_ENDS)
        for name in LINE_END_FIELDS
    }
    limits = zip(*picked(lines, "limit")["limit"], strict=True)
    names = (f"line_{end}_limit" for end in LINE_ENDS)
    return {"line_length": lines.length, **ends, **dict(zip(names, limits, strict=True))}


def lines_table(design: Design, lines: ContactLines) -> str:
    """Return a table of the lines; the first end has the lower z of the pinion."""
    columns = {"pinion_roll": lines.pinion_roll, "length": lines.length}
    columns |= {
        f"{end}_{name}": getattr(lines, name)[:, k]
        for k, end in enumerate(LINE_ENDS)
        for name in ("pinion_z", "pinion_r", "gear_r")
    }
    lost = np.isnan(lines.length)
    words = {
        "from, to": [
            "" if none else " to ".join(limit_words(design, int(code)) for code in row)
            for none, row in zip(lost, lines.limit, strict=True)
        ]
    }
    return table_lines(columns, np.where(lost, "no line", "solved").tolist(), words)


def ratio_lines(lines: ContactLines) -> str:
    """Return the line with the contact ratios of ISO 21771."""
    ratios = lines.transverse_ratio, lines.overlap_ratio, lines.total_ratio
    transverse, overlap, total = (number("contact_ratio", ratio) for ratio in ratios)
    text = f"transverse {transverse} at mid-face, overlap {overlap}"
    text += " without modification" if is_modified(lines.design, lines.flank) else f", total {total}"
    return line("line contact", f"on parallel axes; contact ratios: {text}")
