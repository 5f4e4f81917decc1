"""How well a design closes as text: table and JSON."""

from __future__ import annotations

import math

from .closing import ClosedLayout, Closing, Remark
from .inputs import Design
from .mounting import mounting_of
from .report import json_text, layout_data, layout_line, line


def closing_json(
    name: str, design: Design, closing: Closing, ideal: ClosedLayout | str, remarks: tuple[Remark, ...]
) -> str:
    """Strict JSON of how well a design closes, mm and rad; `ideal` is the layout without backlash
    or the reason why there is none."""
    return json_text(
        {
            "design": name,
            **layout_data(design, mounting_of(design)),
            "closing": dict(vars(closing)),
            "zero_backlash": None if isinstance(ideal, str) else dict(vars(ideal)),
            "warnings": [remark.text for remark in remarks if remark.level == "warning"],
            "notes": [remark.text for remark in remarks if remark.level != "warning"],
        }
    )


def closing_table(
    name: str, design: Design, closing: Closing, ideal: ClosedLayout | str, remarks: tuple[Remark, ...]
) -> str:
    """Readable account of how well a design closes."""
    mounting = mounting_of(design)
    text = f"How well {name} closes (unmodified flanks, without errors)\n"
    text += layout_line(design, mounting)
    if not math.isnan(closing.gap):
        text += line("working radii", "rw1 = {:.6f} mm, rw2 = {:.6f} mm".format(*mounting.working_radius))
        text += line("lines of action", f"pass {closing.gap:.4f} mm apart")
        text += line("normal backlash", f"{closing.normal_backlash:.4f} mm")
    if not math.isnan(closing.offset):
        at = f"E = {closing.offset:.4f} mm ({closing.offset_difference:+.4f}) at this shaft angle"
        text += line("closes at", at)
    if not math.isnan(closing.shaft_angle):
        angle, less = (math.degrees(a) for a in (closing.shaft_angle, closing.shaft_angle_difference))
        text += line("closes at", f"shaft angle = {angle:.4f} deg ({less:+.4f}) at this offset")
    text += line("zero backlash", ideal if isinstance(ideal, str) else _ideal_words(ideal))
    text += "".join(line(remark.level, remark.text) for remark in remarks)
    return text if remarks else text + "No warnings.\n"


def _ideal_words(ideal: ClosedLayout) -> str:
    axes = f"E = {float(ideal.offset):.4f} mm, shaft angle = {math.degrees(float(ideal.shaft_angle)):.4f} deg"
    stands = "dw1 = {:.3f} mm, dw2 = {:.3f} mm".format(*ideal.mounting)
    return f"{axes}, {stands}"
