"""Reports of `check` and `propose`: layout and remarks of a design, and proposed pairs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..arrays import FLANKS, MEMBERS, FloatArray
from ..contact.path import contact_ratio
from ..design.model import Design
from ..design.text import design_text
from ..findings.advice import Advice, design_remarks, layout_advice
from ..findings.backlash import backlash_report, equal_teeth_remarks
from ..findings.diagnostics import ERROR, UNKNOWN, Remark, in_order, quiet, remarks_data, tip_clearances
from ..findings.layout import meshes
from ..gear.undercut import undercut_margin
from ..pair.generator_angle import generator_angle_as_mounted, normal_x_as_mounted
from ..pair.misalignment_at_mesh import pivot_distance
from ..pair.mounting import mounting_of
from ..pair.zero_backlash import LayoutDeviation, ZeroBacklashLayout, layout_deviation, zero_backlash_layout
from ..proposal.command_line import command_of, requests_like
from ..proposal.merit import CRITERIA, DEPTH
from ..proposal.propose import Proposal, propose, works
from ..proposal.request import Request
from ..proposal.rounding import rounded_design
from ..status import NotComputed
from .columns import column, label, labelled_lines, number
from .result import Failure, Report, Rows, advice_data, by_columns, failure_of, plain, stacked_rows
from .text import advice_lines, error_lines, head_lines, line, place_words, remark_lines, typed


@dataclass(frozen=True, eq=False)
class CheckReport(Report):
    """Report of `check` on a single design.

    Attributes
    ----------
    deviation : LayoutDeviation
        Distance of the lines of action, and the layouts in which they meet.
    ideal : ZeroBacklashLayout or str
        Layout without backlash, or the reason why there is none.
    remarks : tuple of Remark
        Remarks on layout, teeth and paths, the most important first.
    advice : tuple of Advice
        Changes of the layout.
    proposal : str or None
        Command line that proposes a similar pair; None for a design with contact.
    jam : str or None
        Reason why the pair cannot be assembled.
    """

    deviation: LayoutDeviation
    ideal: ZeroBacklashLayout | str
    remarks: tuple[Remark, ...]
    advice: tuple[Advice, ...]
    proposal: str | None
    jam: str | None = None

    @property
    def failure(self) -> Failure | None:
        """Failure if the first remark is an error, or unknown because a calculation failed."""
        first = self.remarks[0] if self.remarks else None
        if first is not None and first.level == UNKNOWN:
            return failure_of(NotComputed(first.text))
        if first is None or first.level != ERROR:
            return None
        return Failure(f"Jammed: {self.jam}") if first.text == self.jam else Failure(f"Error: {first.text}")

    def values(self) -> dict[str, Any]:
        """Return backlash, layout without backlash, remarks, advice and angles of the generators."""
        return {
            "closing": self.deviation,
            "zero_backlash": None if isinstance(self.ideal, str) else self.ideal,
            **remarks_data(self.remarks),
            "advice": advice_data(self.advice),
            "proposal": self.proposal,
            "crossing": self.crossing,
        }

    @property
    def crossing(self) -> dict[str, float]:
        """Angles between the generators of both flank pairs as mounted, rad; 0 is line contact."""
        return {flank: float(generator_angle_as_mounted(self.design, flank)) for flank in FLANKS}

    def rows(self) -> Rows:
        """Return group, quantity, unit and value; remarks and advice last."""
        pair, mounting = self.design.pair, mounting_of(self.design)
        distances = zip(
            ("dw1", "dw2", "rw1", "rw2"), (*mounting.distance, *mounting.working_radius), strict=True
        )
        deviation = plain(self.deviation)
        reasons = [("reason", reason) for reason in deviation.pop("reasons")]
        ideal = [("reason", self.ideal)] if isinstance(self.ideal, str) else _by_member(self.ideal)
        groups: list[tuple[str, Any]] = [
            ("design", [("name", self.name), ("offset", pair.offset), ("shaft_angle", pair.shaft_angle)]),
            ("design", distances),
            ("closing", [*deviation.items(), *reasons]),
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
        """Return advice, remarks, and the distance from a layout without backlash."""
        deviation, ideal = self.deviation, self.ideal
        text = f"Check of {self.name}\n"
        text += advice_lines(self.advice)
        if self.proposal:
            text += line("or" if self.advice else "advice", "propose a pair:")
            text += f"    {typed(self.proposal)}\n"
        text += head_lines(self.design.bare()) + remark_lines(self.remarks)
        if meshes(self.design):  # without contact there is no pitch point
            radii = "rw1 = {:.6f} mm, rw2 = {:.6f} mm".format(*mounting_of(self.design).working_radius)
            text += line("working radii", radii)
            text += line(
                "lines of action",
                f"{deviation.gap:z.4f} mm apart (right and left flanks); 0 if the layout fits the gears",
            )
            text += line("crossing angle", _generator_words(self.crossing))
            text += line(
                "normal backlash", f"{deviation.normal_backlash:z.4f} mm without errors and modifications"
            )
            text += line("as mounted", f"backlash {backlash_report(self.design).line}")
            text += error_lines(self.design) or line("errors", _pivot_words(self.design))
            if not math.isnan(deviation.offset):
                offset, change = deviation.offset, deviation.offset_difference
                text += line("lines meet at", f"E = {offset:z.4f} mm ({change:+z.4f}) with this shaft angle")
            if not math.isnan(deviation.shaft_angle):
                angle, change = map(math.degrees, (deviation.shaft_angle, deviation.shaft_angle_difference))
                at = f"shaft angle = {angle:.4f} deg ({change:+z.4f}) with this offset"
                text += line("lines meet at", at)
        if not isinstance(ideal, str):
            axes = (
                f"E = {float(ideal.offset):z.4f} mm, shaft angle = {math.degrees(ideal.shaft_angle):.4f} deg"
            )
            ideal = axes + ", dw1 = {:z.3f} mm, dw2 = {:z.3f} mm".format(*ideal.mounting)
        text += line("zero backlash", ideal)
        return text + "No warnings.\n" if quiet(self.remarks) else text


def check_report(name: str, design: Design) -> CheckReport:
    """Return the check of a single design."""
    deviation = layout_deviation(design)
    ideal: ZeroBacklashLayout | str
    try:
        ideal = zero_backlash_layout(design)
    except ValueError as error:
        ideal = str(error)
    backlash = backlash_report(design)
    on_backlash = (*backlash.remarks, *equal_teeth_remarks(design))
    remarks = in_order((*design_remarks(design, deviation, backlash.jam), *on_backlash))
    proposal = None if meshes(design) else proposal_like(design)
    return CheckReport(name, design, deviation, ideal, remarks, layout_advice(design), proposal, backlash.jam)


def proposal_like(design: Design) -> str | None:
    """Return a command line that proposes a pair like a single design, None if no request has a result."""
    request = next((request for request in requests_like(design) if works(request)), None)
    return command_of(request) if request else None


def _generator_words(crossing: dict[str, float]) -> str:
    """Return the angles between the generators by flank, from rad."""
    if not any(crossing.values()):
        return "0: the generators of the flanks are parallel without errors, which is line contact"
    angles = (f"{math.degrees(angle):z.4f} deg ({flank})" for flank, angle in crossing.items())
    return f"between the generators of the flanks: {', '.join(angles)}; 0 is line contact"


def _pivot_words(design: Design) -> str:
    """Return the pivot of errors of the shaft angle."""
    if design.errors_at == "mesh":
        distance = float(pivot_distance(design))
        return (
            f"shaft-angle errors turn the gear about the pitch point, {distance:.2f} mm from the common"
            " perpendicular"
        )
    pivot = place_words(design, "perpendicular")
    return (
        f'shaft-angle errors turn the gear {pivot}; with at = "mesh" in [errors], they turn it about the'
        " pitch point"
    )


def _by_member(ideal: ZeroBacklashLayout) -> list[tuple[str, float]]:
    """Return the quantities of a layout by name, those of pinion and gear separately."""
    return [
        (f"{member}_{key}".lstrip("_"), float(number))
        for key, value in vars(ideal).items()
        for member, number in (zip(MEMBERS, value, strict=True) if value.shape else [("", value)])
    ]


RESERVE = (
    "smallest distance from a warning of `check`, divided by a sufficient distance, over these criteria:"
    " contact ratio, tip thickness, tip clearance, undercut, depth of active flank that remains below the"
    " tips of the mate (depth of tips), shift of the path under errors; computed before the numbers are"
    " rounded"
)
"""Definition of the reserve."""


@dataclass(frozen=True, eq=False)
class ProposalReport:
    """Proposals for a request; `gear` is the file of a given gear."""

    request: Request
    proposals: tuple[Proposal, ...]
    gear: str = ""
    failure: Failure | None = None

    @property
    def command(self) -> str:
        """Command line of the request."""
        return command_of(self.request, self.gear)

    @property
    def order(self) -> str:
        """Order of the proposals."""
        by_reserve = (
            "pairs with a reserve above 0.25 and helix angles up to 31 deg come first, then pairs with larger"
            " helix angles, then pairs with smaller reserves; in each group, the largest reserve comes first"
        )
        if not self.request.least_cones:
            return by_reserve
        by_cones = (
            "pairs with a positive reserve come before the others, and smaller cone angles before larger"
        )
        return f"{by_cones} ones; among equal cone angles, {by_reserve}"

    def text_of(self, k: int) -> str:
        """Return design `k`, counted from 1, as the text of a design file."""
        return design_text(self.proposals[k - 1].design, f"Proposal {k} of: {self.command}")

    def words_of(self, k: int) -> str:
        """Return the main dimensions of design `k`, counted from 1."""
        design = self.proposals[k - 1].design
        members, angle = design.members, math.degrees(design.pair.shaft_angle)
        both = {
            "teeth": "/".join(str(int(member.teeth)) for member in members),
            "helix": "/".join(f"{math.degrees(member.helix_angle):z.4g}" for member in members) + " deg",
            "cones": "/".join(f"{math.degrees(member.cone_angle):z.4g}" for member in members) + " deg",
        }
        words = ", ".join(f"{name} {value}" for name, value in both.items())
        return f"module {self.request.module:g} mm, {words}, E = {design.pair.offset:.6g} mm, {angle:.6g} deg"

    def data(self) -> dict[str, Any]:
        """Return the request and the designs, the best first, with their quantities and design files."""
        request = {name: value for name, value in plain(self.request).items() if name != "members"}
        designs = [record | {"toml": self.text_of(k)} for k, record in enumerate(self._records, 1)]
        measure = f"{self.order}. Reserve: {RESERVE}"
        return {"request": request, "command": self.command, "measure": measure, "designs": designs}

    def rows(self) -> Rows:
        """Return the designs, the best first."""
        return stacked_rows(self._records)

    @property
    def _records(self) -> list[dict[str, Any]]:
        """Quantities of each design, mm and rad, and its weakest criterion."""
        numbers = (_numbers(self.request.flank, proposal) for proposal in self.proposals)
        return [values | {"weakest": weak} for values, weak in zip(numbers, self.weakest, strict=True)]

    def summary(self) -> str:
        """Return a table with a column for each design."""
        rows = [("pair", [str(k) for k in range(1, 1 + len(self.proposals))])]
        for name, values in self.rows().items():
            if name != "weakest":
                shown = (number(name, value) for value in values)
                rows.append((label(name), ["negative" if cell == "-inf" else cell for cell in shown]))
        text = f"Proposed pairs\n  {typed(self.command)}\n\n"
        text += labelled_lines(rows, label_width=34, cell_width=12)
        text += "\n" + line("order", self.order) + line("reserve", RESERVE)
        weakest = (f"{name} (pair {k})" for k, name in enumerate(self.weakest, 1))
        text += line("smallest reserve", ", ".join(weakest)) + self._tip_lines()
        coast = FLANKS[1 - FLANKS.index(self.request.flank)]
        text += line("flanks", f"{self.request.flank} flanks drive, {coast} flanks coast")
        text += line("n_x", "component of the common normal along the common perpendicular of the axes")
        text += line("crossing angle", "between the generators of the flanks; 0 is line contact")
        text += line("undercut margin", "at most 1; 0 or negative if undercut cuts into the active flank")
        return text + line("warnings", "`check` has none; --out FILE writes pair 1, with --pick another one")

    @property
    def weakest(self) -> list[str]:
        """Criterion with the smallest reserve for each design, 'none' if all reserves are sufficient."""
        criteria = (proposal.criteria for proposal in self.proposals)
        return [CRITERIA[int(each.weakest[0])] if each.reserve[0] < 1.0 else "none" for each in criteria]

    def _tip_lines(self) -> str:
        """Return lines on designs with tips below the active flank of the mate, which have a negative
        reserve."""
        text = ""
        for k, proposal in enumerate(self.proposals, 1):
            if proposal.criteria.reserves[DEPTH, 0] < 0.0:
                below = -float(proposal.criteria.depth[0])
                depth = f"reach {below:.3g} mm below the mate's active flank (form diameter)"
                if math.isinf(below):  # on axes with a large shaft angle
                    depth = "have points that are nowhere in mesh with the mate"
                where = "away from the path of contact, where they touch nothing"
                text += line("tips", f"pair {k}: the tips {depth}, {where}")
        return text


def proposal_report(request: Request, count: int, gear: str = "") -> ProposalReport:
    """Return at most `count` proposals with rounded numbers; `gear` is the file of a given gear.

    Raises as `propose`."""
    proposals = (Proposal(rounded_design(request, p.design), p.criteria) for p in propose(request, count))
    return ProposalReport(request, tuple(proposals), gear)


def _numbers(drive: str, proposal: Proposal) -> dict[str, Any]:
    """Return the quantities of a proposal by name; `drive` names the driving flanks.

    They are those of the rounded design, except the reserve, by which the search has sorted the pairs."""
    design, criteria = proposal.design, proposal.criteria
    values = {"offset": float(design.pair.offset), "shaft_angle": float(design.pair.shaft_angle)}
    members = dict(zip(MEMBERS, design.members, strict=True))
    for name in ("cone_angle", "helix_angle", "profile_shift"):
        values |= {f"{key}_{name}": float(getattr(member, name)) for key, member in members.items()}
    sides = {"drive": drive, "coast": FLANKS[1 - FLANKS.index(drive)]}
    by_flank: dict[str, Callable[[Design, str], FloatArray]] = {
        "contact_ratio": contact_ratio,
        "crossing_angle": generator_angle_as_mounted,
        "n_x": lambda design, flank: normal_x_as_mounted(design, flank)[0],
    }
    for name, value_of in by_flank.items():
        values |= {f"{side}_{name}": float(value_of(design, flank)) for side, flank in sides.items()}
    margins = [min(float(undercut_margin(m, flank)) for flank in FLANKS) for m in design.members]
    by_member: dict[str, Any] = {"tip_clearance": tip_clearances(design), "undercut_margin": margins}
    for name, both in by_member.items():
        values |= {f"{key}_{name}": float(value) for key, value in zip(members, both, strict=True)}
    return values | {"reserve": float(criteria.reserve[0])}
