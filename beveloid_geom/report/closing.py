"""Pairs that close: how well a design does, with all that is to be known of its layout, and proposed ones."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from ..design.model import Design
from ..design.text import design_text
from ..findings.advice import Advice, advice_on, findings_on
from ..findings.backlash import backlash_report
from ..findings.layout import bare, closes, meshes
from ..findings.remarks import Remark, quiet, remarks_data, tip_clearances
from ..pair.closing import ClosedLayout, Closing, closing_of, zero_backlash_layout
from ..pair.crossing import crossing_as_mounted
from ..pair.mesh_errors import pivot_distance
from ..pair.mounting import mounting_of
from ..proposal.figures import FLANKS
from ..proposal.propose import Proposal, works
from ..proposal.request import Request
from ..proposal.words import command_of, requests_like
from .columns import column, label, number
from .result import Rows, by_columns
from .words import (
    advice_data,
    advice_lines,
    error_lines,
    head_lines,
    layout_data,
    line,
    place_words,
    remark_lines,
    typed,
)

WIDTH, CELL = 34, 12
"""Characters of the names and of a number in a text."""
RESERVE = (
    "how far the pair is from the nearest warning of `check`, over how far is ample, the least of contact"
    " ratio, tip thickness and clearance, undercut, depth of tips, shift of the path under errors"
)
MEASURE = f"the greatest reserve first: {RESERVE}"
LEAST = f"the least cones first, of those alike the greatest reserve: {RESERVE}"


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
            text += line("lines of action", f"of right and left flanks are {closing.gap:z.4f} mm apart")
            text += line("generators", _crossing_words(self.crossing))
            text += line("normal backlash", f"{closing.normal_backlash:z.4f} mm")
            text += line("as mounted", f"backlash {backlash_report(self.design).line}")
            text += error_lines(self.design) or line("errors", _pivot_words(self.design))
            if not math.isnan(closing.offset):
                at = f"E = {closing.offset:.4f} mm ({closing.offset_difference:+z.4f}) at this shaft angle"
                text += line("closes at", at)
            if not math.isnan(closing.shaft_angle):
                angle, less = (math.degrees(a) for a in (closing.shaft_angle, closing.shaft_angle_difference))
                text += line("closes at", f"shaft angle = {angle:.4f} deg ({less:+z.4f}) at this offset")
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


def _crossing_words(crossing: dict[str, float]) -> str:
    """Say at which angles (rad) by flank generators cross."""
    if not any(crossing.values()):
        return "parallel on both flanks without errors: line contact"
    angles = (f"{flank} {math.degrees(angle):.4f} deg" for flank, angle in crossing.items())
    return f"cross at {', '.join(angles)}; 0 is line contact"


def _pivot_words(design: Design) -> str:
    """Say about what errors of the shaft angle turn."""
    if design.errors_at == "mesh":
        far = float(pivot_distance(design))
        return f"of the shaft angle turn about the mesh point, {far:.2f} mm from the common perpendicular"
    what = place_words(design, "perpendicular")
    return f'of the shaft angle turn {what}; with at = "mesh" in [errors] about that'


def _by_member(ideal: ClosedLayout) -> list[tuple[str, float]]:
    """Give the entries of a layout, those of both members apart."""
    return [
        (f"{member}_{key}".lstrip("_"), float(number))
        for key, value in vars(ideal).items()
        for member, number in (zip(("pinion", "gear"), value, strict=True) if value.shape else [("", value)])
    ]


@dataclass(frozen=True, eq=False)
class ProposalReport:
    """The proposals on a `request`, whose gear, if one is given, is in the file `gear`."""

    request: Request
    proposals: tuple[Proposal, ...]
    gear: str = ""
    failure: str | None = None

    @property
    def command(self) -> str:
        """The command line that asks for them."""
        return command_of(self.request, self.gear)

    @property
    def measure(self) -> str:
        """What is best."""
        return LEAST if self.request.least_cones else MEASURE

    def text_of(self, k: int) -> str:
        """Write the design of that number, from 1, as a file."""
        return design_text(self.proposals[k - 1].design, f"Proposal {k} of: {self.command}")

    def data(self) -> dict[str, Any]:
        """Give the request and the designs, the best first, each with its figures and as a design file."""
        request = {name: value for name, value in vars(self.request).items() if name != "members"}
        request["gear"] = None if self.request.gear is None else asdict(self.request.gear)
        numbered = enumerate(self._numbers(), 1)
        designs = [{**numbers, "toml": self.text_of(k)} for k, numbers in numbered]
        return {"request": request, "command": self.command, "measure": self.measure, "designs": designs}

    def rows(self) -> Rows:
        """Give the designs, the best first."""
        numbers = self._numbers()
        return {name: [one[name] for one in numbers] for name in numbers[0]}

    def summary(self) -> str:
        """Write a column for each design."""
        text = f"Pairs that close\n  {typed(self.command)}\n\n{'':<{WIDTH}}"
        text += "".join(f"{k:>{CELL}}" for k in range(1, 1 + len(self.proposals))) + "\n"
        numbers = self._numbers()
        for name in numbers[0]:
            cells = "".join(number(name, one[name], CELL) for one in numbers)
            text += f"{label(name):<{WIDTH}}{cells}\n"
        text += "\n" + line("order", self.measure)
        sides = f"drive: the {self.request.flank} flanks, coast: the others"
        return text + line("flanks", sides) + line("checked", "no warnings; --out FILE writes the first")

    def _numbers(self) -> list[dict[str, float]]:
        """Give the numbers of each design by name, mm and rad."""
        return [dict(_numbers(self.request.flank, proposal)) for proposal in self.proposals]


def _numbers(drive: str, proposal: Proposal) -> dict[str, float]:
    """Give the numbers of a proposal."""
    design, figures = proposal.design, proposal.figures
    found = {"offset": float(design.pair.offset), "shaft_angle": float(design.pair.shaft_angle)}
    members = dict(zip(("pinion", "gear"), design.members, strict=True))
    for name in ("cone_angle", "helix_angle", "profile_shift"):
        found |= {f"{member}_{name}": float(getattr(own, name)) for member, own in members.items()}
    by_flank = {
        "contact_ratio": figures.contact_ratio,
        "crossing_angle": figures.crossing,
        "n_x": figures.normal_x,
    }
    sides = {"drive": FLANKS.index(drive), "coast": 1 - FLANKS.index(drive)}
    for name, values in by_flank.items():
        found |= {f"{side}_{name}": float(values[k, 0]) for side, k in sides.items()}
    for member, clearance in zip(members, tip_clearances(design), strict=True):
        found[f"{member}_tip_clearance"] = float(clearance)
    for member, margin in zip(members, figures.margin[:, 0], strict=True):
        found[f"{member}_undercut_margin"] = float(margin)
    return found | {"reserve": float(figures.reserve[0])}
