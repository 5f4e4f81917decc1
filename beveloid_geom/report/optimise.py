"""Coefficients found for an aim as text: table, JSON and CSV."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from ..analysis.optimise import Aim, Optimum
from ..design.model import Design
from ..findings.remarks import remarks_data
from ..pair.mounting import mounting_of
from ..status import Verdict
from .backlash import backlash_data
from .path import (
    contact_report,
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    remark_lines,
)

ARCSEC = math.degrees(3600.0)
POINTS = 21
"""Positions of the path that are certified."""
SHOWN = (
    ("shift", "shift, mm", 1.0, 4),
    ("contact_ratio", "contact ratio", 1.0, 6),
    ("centre", "pinion z middle, mm", 1.0, 4),
    ("peak_to_peak", "tr. error, arcsec", ARCSEC, 4),
)
"""Rows of the table: figure, label, scale, digits."""


def optimum_json(name: str, design: Design, aim: Aim, flank: str, optimum: Optimum) -> str:
    """Strict JSON of the coefficients found, mm and rad; null for a condition that was not asked for."""
    report = contact_report(name, optimum.design, flank, POINTS, "one-equation")
    data: dict[str, Any] = {
        "design": name,
        "flank": flank,
        **layout_data(design, mounting_of(design)),
        "aim": asdict(aim),
        "parabola": {"pinion": optimum.pinion_parabola, "gear": optimum.gear_parabola},
        "found": dict(vars(optimum.found)),
        "given": dict(vars(optimum.given)),
        **backlash_data(optimum.design),
        **remarks_data(report.remarks),
    }
    if report.certificate is not None:
        first = np.count_nonzero(report.certificate.verdict == Verdict.FIRST_CONTACT)
        data["certified"] = {"first_contact": first, "positions": POINTS}
    return json_text(data)


def optimum_csv(design: Design, optimum: Optimum) -> str:
    """CSV, a row for the coefficients found and one for those given, mm and rad, units in the header."""
    header = ["design", "parabola_pinion_per_mm", "parabola_gear_per_mm"]
    header += ["shift_mm", "contact_ratio", "pinion_z_middle_mm", "peak_to_peak_rad"]
    given = (float(member.tool.parabola) for member in design.members)
    rows: list[list[object]] = []
    for name, parabola, paths in (
        ("found", (optimum.pinion_parabola, optimum.gear_parabola), optimum.found),
        ("given", given, optimum.given),
    ):
        rows.append([name, *parabola, *(float(getattr(paths, figure)) for figure, *_ in SHOWN)])
    return csv_text(header, list(zip(*rows, strict=True)))


def optimum_table(name: str, design: Design, aim: Aim, flank: str, optimum: Optimum) -> str:
    """Readable account of the coefficients found, at most 100 characters wide."""
    report = contact_report(name, optimum.design, flank, POINTS, "one-equation")
    text = f"Parabola coefficients for {name}, {flank} flanks: least shift of the path under errors\n"
    text += layout_line(design, mounting_of(design)) + error_line(design.errors)
    text += line("aim", _aim_words(aim))
    text += line("errors of the aim", " ".join(error_line(aim.errors).split()[1:]))
    found = optimum.pinion_parabola, optimum.gear_parabola
    text += line("coefficients", "pinion {:.6g} 1/mm, gear {:.6g} 1/mm".format(*found))
    if report.certificate is not None:
        first = np.count_nonzero(report.certificate.verdict == Verdict.FIRST_CONTACT)
        text += line("certified", f"{first} of {POINTS} positions: nothing on this side touches earlier")
    text += line("as mounted", f"backlash {report.backlash.line}")
    text += remark_lines(report.remarks)
    text += f"\n{'':<22}{'found':>14}{'as given':>14}\n"
    for figure, label, scale, digits in SHOWN:
        both = (scale * float(getattr(paths, figure)) for paths in (optimum.found, optimum.given))
        text += f"{label:<22}" + "".join(f"{value:z14.{digits}f}" for value in both) + "\n"
    return text


def _aim_words(aim: Aim) -> str:
    words = f"contact ratio at least {aim.contact_ratio:g}, middle within {aim.off_centre:g} mm of mid-face"
    if math.isfinite(aim.peak_to_peak):
        words += f", transmission error at most {ARCSEC * aim.peak_to_peak:g} arcsec peak to peak"
    bounds = "; pinion {:g} to {:g}, gear {:g} to {:g} 1/mm".format(*aim.pinion_parabola, *aim.gear_parabola)
    return words + bounds
