"""Lines of text that several reports share: layout, errors, parabolas, backlash, remarks."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FLANK_SIGN
from ..contact.path import PathEnds
from ..design.ends import limit_names
from ..design.member import Member
from ..design.model import Design, Errors, ErrorsAt, MeshErrors
from ..design.text import modification_tables
from ..findings.advice import Advice
from ..findings.backlash import backlash_report
from ..findings.diagnostics import Remark
from ..pair.misalignment_at_mesh import at_mesh, pivot_distance
from ..pair.mounting import mounting_of
from .columns import scaled, unit_shown
from .result import status_name

LINE_WIDTH = 100
"""Characters in a line of a text."""
SYMBOLS = {"offset": "E", "shaft_angle": "Sigma", "pinion_axial": "P", "gear_axial": "G"}
"""Usual symbols of the assembly errors about the common perpendicular."""
ERROR_SYMBOLS = SYMBOLS | {"centre_distance": "a", "in_plane": "in", "out_of_plane": "out"}
"""Symbols of errors in the headings of a text."""


def status_words(code: int) -> str:
    """Return the name of a `Status` in a text."""
    return status_name(code).replace("_", " ")


def line(label: str, text: str) -> str:
    """Return a line with a label and a text, which is wrapped if it is long."""
    # Characters of the label at the beginning of a line.
    label_width = 21
    start = f"  {label:<{label_width - 2}}"
    return textwrap.fill(start + text, LINE_WIDTH, subsequent_indent=" " * label_width) + "\n"


def typed(command: str) -> str:
    """Return a command line, wrapped so that it can be pasted into a shell."""
    lines = textwrap.wrap(command, LINE_WIDTH - 6, break_on_hyphens=False, break_long_words=False)
    return " \\\n    ".join(lines)


def head_lines(design: Design) -> str:
    """Return the lines with layout, and with errors and parabolas if there are any.

    `dw1` and `dw2` are the mounting distances: from the common perpendicular to mid-face."""
    distance = mounting_of(design).distance
    mounting = "mounting distances dw1 = {:z.6f} mm, dw2 = {:z.6f} mm".format(*distance)
    if np.isnan(distance).any():
        mounting = "no mounting distances: the flanks have no common normal"
    angle = math.degrees(design.pair.shaft_angle)
    text = line("layout", f"E = {design.pair.offset:.9g} mm, shaft angle = {angle:.9g} deg, {mounting}")
    text += error_lines(design)
    if design.has_parabola:
        text += line("parabola", "pinion {}, gear {}".format(*map(_parabola_words, design.members)))
    for words in modification_words(design):
        text += line("modification", words)
    return text


def modification_words(design: Design) -> Iterator[str]:
    """Yield the modifications of each member, such as 'pinion right: helix crowning 10 um'."""
    for name, member in (("pinion", design.pinion), ("gear", design.gear)):
        for table, values in modification_tables(name, vars(member)).items():
            flank = table.removeprefix(f"{name}.modification").removeprefix(".")
            words = ", ".join(_amount_words(key, value) for key, value in values.items())
            yield f"{name}{flank and ' '}{flank}: {words}"


def _parabola_words(member: Member) -> str:
    """Return the parabola coefficients of a member and the position of their apex."""
    right, left = (float(member.tool.parabola_of(flank)) for flank in FLANK_SIGN)
    words = f"{right:g} 1/mm" if right == left else f"{right:g} (right) and {left:g} (left) 1/mm"
    apex = float(member.tool.parabola_apex)
    return f"{words} with the apex at {apex:g} mm" if apex and (right or left) else words


def _amount_words(key: str, value: Any) -> str:
    """Return an amount or a length of a modification with its unit, such as 'helix crowning 10 um', or the
    file of measured deviations, or the range of pitch deviations."""
    if isinstance(value, dict):
        file = value["file"]
        files = f"{len(file)} teeth" if isinstance(file, list) else Path(file).name or "an array"
        return f"{key} of {files}, {value['rows']} x {value['columns']} points"
    name, _, unit = key.rpartition("_")
    if isinstance(value, list):
        return f"{name.replace('_', ' ')} of {len(value)} teeth from {min(value):g} to {max(value):g} {unit}"
    return f"{name.replace('_', ' ')} {value:g} {unit}"


def error_lines(design: Design) -> str:
    """Return the lines with the errors of a design, about the common perpendicular and at the mesh.

    The text is empty without errors."""
    if not (words := error_words(design.errors)):
        return ""
    if math.isnan(float(pivot_distance(design))):
        return line("errors", words)
    text = line("errors", f"{words}, {place_words(design, 'perpendicular')}")
    equivalent = at_mesh(design)
    none = "no equivalent errors, because no tilt about the pitch point gives this offset error"
    words = none if math.isnan(equivalent.in_plane) else error_words(equivalent, 1e-10)
    return text + line("same at the mesh", words)


def place_words(design: Design, errors_at: ErrorsAt | None = None) -> str:
    """Return where errors are measured, by default those of the design, and the distance to the pitch
    point."""
    if (design.errors_at if errors_at is None else errors_at) == "mesh":
        return "at the mesh"
    distance = float(pivot_distance(design))
    words = "" if math.isnan(distance) else f", {distance:.2f} mm from the pitch point"
    return f"about the common perpendicular{words}"


def error_words(errors: Errors | MeshErrors, rounding: float = 0.0) -> str:
    """Return the assembly errors whose magnitude exceeds `rounding`, in mm and deg."""
    shown = {name: float(scaled(f"{name}_error", value)) for name, value in vars(errors).items()}
    return ", ".join(
        f"{name.replace('_', ' ')} {value:+.6g} {unit_of(name)}"
        for name, value in shown.items()
        if not abs(value) <= rounding
    )


def both_signs_words(errors: Errors | MeshErrors) -> str:
    """Return assembly errors that are applied one by one in both directions."""
    return f"{error_words(errors).replace('+', '+/-')}; each alone, in both directions"


def unit_of(error: str) -> str:
    """Return the unit of an error in a text."""
    return unit_shown(f"{error}_error")


def symbol_words(error: str) -> str:
    """Return the symbol and the name of an error, such as 'E: offset'."""
    return f"{ERROR_SYMBOLS[error]}: {error.replace('_', ' ')}"


def mounted_lines(design: Design) -> str:
    """Return the lines with layout and backlash as mounted, and the reason if the pair cannot be
    assembled."""
    report = backlash_report(design)
    text = head_lines(design) + line("as mounted", f"backlash {report.line}")
    return text + line("jammed", report.jam) if report.jam else text


def remark_lines(remarks: Sequence[Remark]) -> str:
    """Return the lines with remarks, the most important first."""
    return "".join(line(remark.level, remark.text) for remark in remarks)


def advice_lines(advice: Sequence[Advice]) -> str:
    """Return the lines with proposed changes."""
    return "".join(line("advice" if k == 0 else "or", change.words()) for k, change in enumerate(advice))


def end_words(design: Design, ends: PathEnds) -> str:
    """Return the limits at which a path of a single design enters and leaves the flanks."""
    words = []
    for verb, end in {"enters": ends.enter, "leaves": ends.leave}.items():
        if end is not None:
            member, limit = limit_names(design, end)
            words.append(f"{verb} at the {member}'s {limit}")
    return ", ".join(words)
