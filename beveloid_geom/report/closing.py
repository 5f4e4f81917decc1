"""How well a design closes, and all that is to be known of its layout."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..design.model import Design
from ..findings.advice import Advice, advice_on, findings_on
from ..findings.backlash import backlash_report
from ..findings.layout import FLANKS, bare, closes, meshes
from ..findings.remarks import Remark, quiet, remarks_data
from ..pair.closing import ClosedLayout, Closing, closing_of, zero_backlash_layout
from ..pair.crossing import crossing_as_mounted
from ..pair.mesh_errors import pivot_distance
from ..pair.mounting import mounting_of
from ..proposal.propose import works
from ..proposal.words import command_of, requests_like
from .columns import column
from .result import Rows, by_columns
from .words import advice_data, advice_lines, error_lines, head_lines, layout_data, line, remark_lines, typed


@dataclass(frozen=True, eq=False)
class ClosingReport:
    """How well a single design closes; `ideal` is the layout without backlash or why there is none,
    `remarks` all there is to know of layout, teeth and paths, what matters most first, `advice` what to
    change about the layout, `proposal` the command line that proposes a pair like it, if it has none."""

    name: str
    design: Design
    closing: Closing
    ideal: ClosedLayout | str
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]
    proposal: str | None
    failure: str | None = None

    def data(self) -> dict[str, Any]:
        """Give the layout, how well it closes, and what was found."""
        return {
            **layout_data(self.name, self.design),
            "closing": dict(vars(self.closing)),
            "zero_backlash": None if isinstance(self.ideal, str) else dict(vars(self.ideal)),
            **remarks_data(self.remarks),
            "advice": advice_data(self.advice),
            "proposal": self.proposal,
            "crossing": self.crossing,
        }

    @property
    def crossing(self) -> dict[str, float]:
        """Angles (rad) at which the generators of both flank pairs cross, as mounted."""
        return {flank: float(crossing_as_mounted(self.design, flank)) for flank in FLANKS}

    def rows(self) -> Rows:
        """Give group, quantity, unit and value; warnings, notes and advice last."""
        pair, mounting = self.design.pair, mounting_of(self.design)
        distances = zip(
            ("dw1", "dw2", "rw1", "rw2"), (*mounting.distance, *mounting.working_radius), strict=True
        )
        closing = dict(vars(self.closing))
        reasons = [("reason", reason) for reason in closing.pop("reasons")]
        ideal = [("reason", self.ideal)] if isinstance(self.ideal, str) else _by_member(self.ideal)
        groups: list[tuple[str, Any]] = [
            ("design", [("name", self.name), ("offset", pair.offset), ("shaft_angle", pair.shaft_angle)]),
            ("design", distances),
            ("closing", [*closing.items(), *reasons]),
            ("zero_backlash", ideal),
            ("mounted", [("normal_backlash", backlash_report(self.design).normal)]),
            ("mounted", [(f"{flank}_crossing_angle", angle) for flank, angle in self.crossing.items()]),
            ("remark", [(remark.level, remark.text) for remark in self.remarks]),
            *((f"advice {k}", vars(advice).items()) for k, advice in enumerate(self.advice, 1)),
            ("advice", [("proposal", self.proposal)] if self.proposal else []),
        ]
        rows = [
            (group, key, column(key).unit, value if isinstance(value, str) else float(value))
            for group, values in groups
            for key, value in values
        ]
        return by_columns(("group", "quantity", "unit", "value"), rows)

    def summary(self) -> str:
        """Write what was found, and how far the layout is from one that closes."""
        closing, ideal = self.closing, self.ideal
        text = f"How well {self.name} closes, with unmodified flanks and without errors\n"
        text += advice_lines(self.advice)
        if self.proposal:
            text += line("or" if self.advice else "advice", "have a pair proposed:")
            text += f"    {typed(self.proposal)}\n"
        text += head_lines(bare(self.design)) + remark_lines(self.remarks)
        if meshes(self.design):  # without contact there is no pitch point for them to hold at
            radii = "rw1 = {:.6f} mm, rw2 = {:.6f} mm".format(*mounting_of(self.design).working_radius)
            text += line("working radii", radii)
            text += line("lines of action", f"of right and left flanks are {closing.gap:.4f} mm apart")
            angles = (f"{flank} {math.degrees(angle):.4f} deg" for flank, angle in self.crossing.items())
            text += line("generators", f"cross at {', '.join(angles)}; 0 is line contact")
            text += line("normal backlash", f"{closing.normal_backlash:.4f} mm")
            text += line("as mounted", f"backlash {backlash_report(self.design).line}")
            far = f"the common perpendicular, {float(pivot_distance(self.design)):.2f} mm from the mesh point"
            text += error_lines(self.design) or line(
                "errors", f'of the shaft angle turn about {far}; with at = "mesh" in [errors] about that'
            )
            if not math.isnan(closing.offset):
                at = f"E = {closing.offset:.4f} mm ({closing.offset_difference:+.4f}) at this shaft angle"
                text += line("closes at", at)
            if not math.isnan(closing.shaft_angle):
                angle, less = (math.degrees(a) for a in (closing.shaft_angle, closing.shaft_angle_difference))
                text += line("closes at", f"shaft angle = {angle:.4f} deg ({less:+.4f}) at this offset")
        if not isinstance(ideal, str):
            axes = (
                f"E = {float(ideal.offset):.4f} mm, shaft angle = {math.degrees(ideal.shaft_angle):.4f} deg"
            )
            ideal = axes + ", dw1 = {:.3f} mm, dw2 = {:.3f} mm".format(*ideal.mounting)
        text += line("zero backlash", ideal)
        return text + "No warnings.\n" if quiet(self.remarks) else text


def closing_report(name: str, design: Design) -> ClosingReport:
    """Find how well a single design closes."""
    closing = closing_of(design)
    ideal: ClosedLayout | str
    try:
        ideal = zero_backlash_layout(design)
    except ValueError as error:
        ideal = str(error)
    jam = backlash_report(design).jam
    remarks, advice = findings_on(design, closing, jam), advice_on(design)
    proposal = None if meshes(design) and closes(design, closing) else proposal_like(design)
    return ClosingReport(name, design, closing, ideal, remarks, advice, proposal)


def proposal_like(design: Design) -> str | None:
    """Give the command line that proposes a pair like a single design, tried before it is given."""
    found = next((request for request in requests_like(design) if works(request)), None)
    return command_of(found) if found else None


def _by_member(ideal: ClosedLayout) -> list[tuple[str, float]]:
    """Give the entries of a layout, those of both members apart."""
    return [
        (f"{member}_{key}".lstrip("_"), float(number))
        for key, value in vars(ideal).items()
        for member, number in (zip(("pinion", "gear"), value, strict=True) if value.shape else [("", value)])
    ]
