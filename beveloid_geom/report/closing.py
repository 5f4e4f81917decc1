"""How well a design closes as text: table, JSON and CSV."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..design.model import Design
from ..findings.advice import Advice, advice_on, findings_on
from ..findings.layout import meshes
from ..findings.remarks import Remark, quiet, remarks_data
from ..pair.closing import ClosedLayout, Closing, closing_of, zero_backlash_layout
from ..pair.mounting import mounting_of
from .backlash import backlash_report
from .path import advice_data, csv_text, json_text, layout_data, layout_line, line, remark_lines


@dataclass(frozen=True, eq=False)
class ClosingReport:
    """How well a single design closes; `ideal` is the layout without backlash or why there is none,
    `remarks` all there is to know of layout, teeth and paths, what matters most first, `advice` what to
    change about the layout."""

    name: str
    design: Design
    closing: Closing
    ideal: ClosedLayout | str
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]


def closing_report(name: str, design: Design) -> ClosingReport:
    """Report of a single design."""
    closing = closing_of(design)
    ideal: ClosedLayout | str
    try:
        ideal = zero_backlash_layout(design)
    except ValueError as error:
        ideal = str(error)
    jam = backlash_report(design).jam
    return ClosingReport(name, design, closing, ideal, findings_on(design, closing, jam), advice_on(design))


def closing_json(report: ClosingReport) -> str:
    """Strict JSON of how well a design closes, mm and rad."""
    ideal = report.ideal
    return json_text(
        {
            "design": report.name,
            **layout_data(report.design, mounting_of(report.design)),
            "closing": dict(vars(report.closing)),
            "zero_backlash": None if isinstance(ideal, str) else dict(vars(ideal)),
            **remarks_data(report.remarks),
            "advice": advice_data(report.advice),
        }
    )


def closing_csv(report: ClosingReport) -> str:
    """CSV of how well a design closes, a quantity, its unit and its value a row; warnings and notes last."""
    design, closing, ideal, mounting = report.design, report.closing, report.ideal, mounting_of(report.design)
    layout = {"offset": design.pair.offset, "shaft_angle": design.pair.shaft_angle}
    layout |= dict(zip(("dw1", "dw2"), mounting.distance, strict=True))
    layout |= dict(zip(("rw1", "rw2"), mounting.working_radius, strict=True))
    closes = {key: value for key, value in vars(closing).items() if key != "reasons"}
    groups = {"design": layout, "closing": closes}
    if not isinstance(ideal, str):
        groups["zero_backlash"] = _by_member(ideal)
    rows: list[tuple[object, ...]] = [("design", "name", "", report.name)]
    for group, values in groups.items():
        for key, value in values.items():
            rows.append((group, key, "rad" if "angle" in key else "mm", float(value)))
    rows.append(("mounted", "normal_backlash", "mm", backlash_report(design).normal))
    rows += [("closing", "reason", "", reason) for reason in closing.reasons]
    if isinstance(ideal, str):
        rows.append(("zero_backlash", "reason", "", ideal))
    rows += [("remark", remark.level, "", remark.text) for remark in report.remarks]
    for number, advice in enumerate(report.advice, 1):
        rows.append((f"advice {number}", "change", "", advice.change))
        units = ((key, value) for key, value in vars(advice).items() if key != "change")
        rows += [(f"advice {number}", key, "rad" if "angle" in key else "mm", value) for key, value in units]
    return csv_text(["group", "quantity", "unit", "value"], list(zip(*rows, strict=True)))


def _by_member(ideal: ClosedLayout) -> dict[str, Any]:
    """The entries of a layout, those of both members apart."""
    found: dict[str, Any] = {}
    for key, value in vars(ideal).items():
        pairs = zip(("pinion", "gear"), value, strict=True) if value.shape else [("", value)]
        found |= {f"{member}_{key}".lstrip("_"): number for member, number in pairs}
    return found


def closing_table(report: ClosingReport) -> str:
    """Readable account of how well a design closes."""
    closing, ideal, mounting = report.closing, report.ideal, mounting_of(report.design)
    text = f"How well {report.name} closes (unmodified flanks, without errors)\n"
    text += layout_line(report.design, mounting) + remark_lines(report.remarks, report.advice)
    if meshes(report.design):  # without contact there is no pitch point for them to hold at
        text += line("working radii", "rw1 = {:.6f} mm, rw2 = {:.6f} mm".format(*mounting.working_radius))
        text += line("lines of action", f"pass {closing.gap:.4f} mm apart")
        text += line("normal backlash", f"{closing.normal_backlash:.4f} mm")
        text += line("as mounted", f"backlash {backlash_report(report.design).line}")
        if not math.isnan(closing.offset):
            at = f"E = {closing.offset:.4f} mm ({closing.offset_difference:+.4f}) at this shaft angle"
            text += line("closes at", at)
        if not math.isnan(closing.shaft_angle):
            angle, less = (math.degrees(a) for a in (closing.shaft_angle, closing.shaft_angle_difference))
            text += line("closes at", f"shaft angle = {angle:.4f} deg ({less:+.4f}) at this offset")
    text += line("zero backlash", ideal if isinstance(ideal, str) else _ideal_words(ideal))
    return text + "No warnings.\n" if quiet(report.remarks) else text


def _ideal_words(ideal: ClosedLayout) -> str:
    axes = f"E = {float(ideal.offset):.4f} mm, shaft angle = {math.degrees(float(ideal.shaft_angle)):.4f} deg"
    stands = "dw1 = {:.3f} mm, dw2 = {:.3f} mm".format(*ideal.mounting)
    return f"{axes}, {stands}"
