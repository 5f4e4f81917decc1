"""What all results say alike: their layout, errors and parabolas, as JSON and as lines of a text."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from ..contact.path import PathEnds
from ..design.model import Design, Errors, ErrorsAt, MeshErrors
from ..findings.advice import Advice
from ..findings.backlash import backlash_data, backlash_report
from ..findings.remarks import Remark
from ..pair.mesh_errors import at_mesh, pivot_distance
from ..pair.mounting import mounting_of
from ..status import Status
from .columns import scaled, unit_shown

WIDTH, INDENT = 100, 21
"""Characters of a line, and of the label before its text."""
TRADE = {"offset": "E", "shaft_angle": "Sigma", "pinion_axial": "P", "gear_axial": "G"}
"""The letters of the trade for the assembly errors about the common perpendicular."""
SHORT = TRADE | {"centre_distance": "a", "in_plane": "in", "out_of_plane": "out"}
"""What stands for errors over the columns of a text."""


def name_in_files(code: IntEnum) -> str:
    """Give a status or a limit as JSON and CSV have it: lower case with underscores."""
    return code.name.lower()


def status_name(code: int) -> str:
    """Give the name of a `Status` in files."""
    return name_in_files(Status(int(code)))


def status_words(code: int) -> str:
    """Give the name of a `Status` in a text."""
    return status_name(code).replace("_", " ")


def ends_data(ends: PathEnds) -> dict[str, Any]:
    """Give the limits at both ends of a path as JSON has them, None where a path has none."""
    both = {"enter": ends.enter, "leave": ends.leave}
    return {k: None if end is None else {"member": end.member, "limit": end.limit} for k, end in both.items()}


def layout_data(name: str, design: Design) -> dict[str, Any]:
    """Give the entries of JSON that say in what layout a result was found, mm and rad."""
    mounting = mounting_of(design)
    values = (*mounting.distance, *mounting.working_radius, mounting.pitch_point)
    return {
        "design": name,
        "layout": {
            "offset": design.pair.offset,
            "shaft_angle": design.pair.shaft_angle,
            "errors": dict(vars(design.errors)),
            "errors_at": design.errors_at,
            "errors_at_mesh": dict(vars(at_mesh(design))),
            "pivot_distance": pivot_distance(design),
        },
        "mounting": dict(zip(("dw1", "dw2", "rw1", "rw2", "pitch_point"), values, strict=True)),
        "normal_backlash": mounting.normal_backlash,
        **backlash_data(design),
    }


def head_data(name: str, design: Design, flank: str) -> dict[str, Any]:
    """Give the entries of JSON of all results of one flank pair."""
    parabola = {"pinion": design.pinion.tool.parabola, "gear": design.gear.tool.parabola}
    return {"flank": flank, **layout_data(name, design), "parabola": parabola}


def advice_data(advice: Sequence[Advice]) -> list[dict[str, Any]]:
    """Give each change as an entry of JSON, with all that it needs, mm and rad, and in words."""
    return [{**vars(one), "text": one.words()} for one in advice]


def line(label: str, text: str) -> str:
    """Write a line of a text: a label, and words that are broken where they are long."""
    start = f"  {label:<{INDENT - 2}}"
    return textwrap.fill(start + text, WIDTH, subsequent_indent=" " * INDENT) + "\n"


def typed(command: str) -> str:
    """Write a command line in lines that can be typed as they are."""
    lines = textwrap.wrap(command, WIDTH - 6, break_on_hyphens=False, break_long_words=False)
    return " \\\n    ".join(lines)


def head_lines(design: Design) -> str:
    """Write the layout, without which a result means nothing, and errors and parabolas, if there are any."""
    distance = mounting_of(design).distance
    stand = "dw1 = {:z.6f} mm, dw2 = {:z.6f} mm".format(*distance)
    if np.isnan(distance).any():
        stand = "no mounting distances: the flanks have no common normal"
    angle = math.degrees(design.pair.shaft_angle)
    text = line("layout", f"E = {design.pair.offset:.9g} mm, shaft angle = {angle:.9g} deg, {stand}")
    text += error_lines(design)
    parabolas = [float(member.tool.parabola) for member in design.members]
    if any(parabolas):
        text += line("parabola", "pinion {:g} 1/mm, gear {:g} 1/mm".format(*parabolas))
    return text


def error_lines(design: Design) -> str:
    """Write the errors of a design, if it has any: about the common perpendicular, how far from the mesh that
    is, and what the same errors are at the mesh."""
    if not (words := error_words(design.errors)):
        return ""
    if math.isnan(float(pivot_distance(design))):
        return line("errors", words)
    text = line("errors", f"{words}, {place_words(design, 'perpendicular')}")
    same = at_mesh(design)
    none = "none: no tilt gives this offset"
    return text + line("same at the mesh", none if math.isnan(same.in_plane) else error_words(same, 1e-10))


def place_words(design: Design, errors_at: ErrorsAt | None = None) -> str:
    """Say where errors are measured, those of a design unless told, and how far that is from the mesh."""
    if (design.errors_at if errors_at is None else errors_at) == "mesh":
        return "at the mesh"
    far = float(pivot_distance(design))
    away = "" if math.isnan(far) else f", {far:.2f} mm from the mesh point"
    return f"about the common perpendicular{away}"


def error_words(errors: Errors | MeshErrors, rounding: float = 0.0) -> str:
    """Say the assembly errors that are not 0 beside `rounding`, in mm and deg."""
    shown = {name: float(scaled(f"{name}_error", value)) for name, value in vars(errors).items()}
    return ", ".join(
        f"{name.replace('_', ' ')} {value:+.6g} {unit_of(name)}"
        for name, value in shown.items()
        if not abs(value) <= rounding
    )


def unit_of(error: str) -> str:
    """Give the unit of an error in a text."""
    return unit_shown(f"{error}_error")


def trade_words(error: str) -> str:
    """Name an error by its short name and by the project's word, as in 'E: offset'."""
    return f"{SHORT[error]}: {error.replace('_', ' ')}"


def mounted_lines(design: Design) -> str:
    """Write what all results of a pair as mounted start with: the layout, the backlash with errors and
    parabolas, and why the pair cannot be assembled, if it cannot."""
    report = backlash_report(design)
    text = head_lines(design) + line("as mounted", f"backlash {report.line}")
    return text + line("jammed", report.jam) if report.jam else text


def remark_lines(remarks: Sequence[Remark]) -> str:
    """Write what was found, what matters most first."""
    return "".join(line(remark.level, remark.text) for remark in remarks)


def advice_lines(advice: Sequence[Advice]) -> str:
    """Write what to change."""
    return "".join(line("advice" if k == 0 else "or", one.words()) for k, one in enumerate(advice))


def end_words(ends: PathEnds) -> str:
    """Say where a path enters and leaves the flanks."""
    both = {"enters": ends.enter, "leaves": ends.leave}
    return ", ".join(f"{verb} at the {end.member}'s {end.limit}" for verb, end in both.items() if end)


def failure_of(reason: str | None, design: Design) -> str | None:
    """Say why a command ends with exit status 1: no contact for a `reason`, or a pair that jams."""
    if reason:
        return f"No contact: {reason}"
    jam = backlash_report(design).jam
    return f"Jammed: {jam}" if jam else None
