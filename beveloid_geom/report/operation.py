"""A pair in operation as text: table, JSON and CSV of one mesh cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..contact.path import contact_ratio
from ..design.model import Design
from ..operation.first_contact import FirstContact
from ..operation.mesh_cycle import Cycle, mesh_cycle
from ..operation.operating_ratio import operating_ratios
from ..pair.mounting import Mounting, mounting_of
from ..status import FirstStatus, Limit, RatioStatus
from .backlash import backlash_report
from .path import (
    backlash_lines,
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    parabola_line,
)

ARCSEC = math.degrees(3600.0)
FIELDS = (
    ("pinion_roll", "_rad"),
    ("gear_roll", "_rad"),
    ("transmission_error", "_rad"),
    ("pair", ""),
    ("l1", "_mm"),
    ("z1", "_mm"),
    ("l2", "_mm"),
    ("z2", "_mm"),
)
"""Numbers of a position, with the units in a CSV's header."""
RATIOS = ("operating_contact_ratio", "operating_contact_ratio_within_film")
SHOWN = 12
"""Intervals of the cycle between the positions of a table."""


@dataclass(frozen=True, eq=False)
class OperationReport:
    """One mesh cycle of a flank pair: its `cycle`, first contacts at even rolls, and the contact
    ratios by Eq. 16, in operation, and within `film` (mm) of touching. `reason` says why the
    cycle is not known, None if it is; `doubts` the same of the last two ratios."""

    name: str
    design: Design
    flank: str
    mounting: Mounting
    cycle: Cycle
    first: FirstContact
    eq16: float
    operating: float
    film: float
    within_film: float
    reason: str | None
    doubts: tuple[str | None, str | None]

    @property
    def carriers(self) -> list[str]:
        """What carries at each position: 'flanks', or edges as 'gear tip'; with 'on fillet'."""
        words = []
        for codes, on_fillet, status in zip(
            self.first.limit, self.first.on_fillet, self.first.status, strict=True
        ):
            edges = " and ".join(str(Limit(int(code))) for code in codes if code >= 0)
            text = (edges or "flanks") + (" on fillet" if on_fillet.any() else "")
            words.append(text if status == FirstStatus.SOLVED else first_status_name(status))
        return words


def first_status_name(status: int) -> str:
    """Name of a status of a first contact in files."""
    return FirstStatus(int(status)).name.lower()


def operation_report(
    name: str, design: Design, flank: str, points: int, harmonics: int, film: float
) -> OperationReport:
    """The mesh cycle of a single design at `points` positions; `film` in mm."""
    cycle = mesh_cycle(design, flank, harmonics)
    share: FloatArray = np.linspace(0.0, 1.0, points)
    first = cycle.at(float(cycle.start) + cycle.pitch * share)
    ratios = [math.nan, math.nan]
    doubts: tuple[str | None, str | None] = (None, None)
    if not cycle.lost:
        found = operating_ratios(design, flank, (0.0, film))
        ratios, doubts = found.ratio.tolist(), (_doubt(found.status[0]), _doubt(found.status[1]))
    return OperationReport(
        name=name,
        design=design,
        flank=flank,
        mounting=mounting_of(design),
        cycle=cycle,
        first=first,
        eq16=float(contact_ratio(design, flank)),
        operating=ratios[0],
        film=film,
        within_film=ratios[1],
        reason=_reason(flank, int(cycle.status)) if cycle.lost else None,
        doubts=doubts,
    )


def _doubt(code: int) -> str | None:
    """Why an operating contact ratio is not known, if it is not."""
    words = {
        RatioStatus.NO_FIRST_CONTACT: "at some rolls there is no first contact",
        RatioStatus.NOT_CONVERGED: "the clearance of a tooth pair did not converge",
        RatioStatus.TOO_THICK: "the film reaches beyond the tooth pairs looked at, take a thinner one",
        RatioStatus.UNSTEADY: "the rolls at which a tooth pair touches cannot be told apart",
    }
    return words.get(RatioStatus(int(code)))


def _reason(flank: str, status: int) -> str:
    """Why the cycle is not known."""
    words = {
        FirstStatus.NO_CONTACT: "at some rolls no tooth reaches the other member",
        FirstStatus.MEETS_BOTTOM: "a tip reaches the other member's bottom land",
        FirstStatus.UNDERCUT: "a member is undercut",
        FirstStatus.OUT_OF_STEP: "the teeth are too far out of step to tell which of them meet",
        FirstStatus.UNDEFINED: "the inputs leave nothing to search",
    }
    why = words.get(FirstStatus(status), "a position did not converge")
    return f"no first contact of the {flank} teeth: {why}"


def operation_json(report: OperationReport) -> str:
    """Strict JSON of a mesh cycle, mm and rad."""
    cycle = report.cycle
    data: dict[str, Any] = {
        "design": report.name,
        "flank": report.flank,
        "contact_ratio": report.eq16,
        RATIOS[0]: report.operating,
        "film": report.film,
        RATIOS[1]: report.within_film,
        **layout_data(report.design, report.mounting),
        "parabola": {"pinion": report.design.pinion.tool.parabola, "gear": report.design.gear.tool.parabola},
        "pitch": cycle.pitch,
        "peak_to_peak": cycle.peak_to_peak,
        "mean": cycle.mean,
        "amplitudes": np.abs(cycle.harmonics),
        "edge_share": cycle.edge_share,
        "changes": cycle.changes,
        "hand_over": cycle.hand_over,
        "positions": {
            **{name: getattr(report.first, name) for name, _ in FIELDS},
            "carried_by": report.carriers,
            "status": [first_status_name(code) for code in report.first.status],
        },
    }
    if report.reason:
        data["reason"] = report.reason
    for key, doubt in zip(RATIOS, report.doubts, strict=True):
        if doubt:
            data[f"{key}_reason"] = doubt
    return json_text(data)


def operation_csv(report: OperationReport) -> str:
    """CSV of the positions of a mesh cycle, mm and rad, units in the header."""
    header = [*(name + unit for name, unit in FIELDS), "carried_by", "status", "mounted_backlash_mm"]
    columns = [getattr(report.first, name).tolist() for name, _ in FIELDS]
    status = [first_status_name(code) for code in report.first.status]
    backlash = [backlash_report(report.design).normal] * len(status)
    return csv_text(header, [*columns, report.carriers, status, backlash])


def operation_table(report: OperationReport) -> str:
    """Readable account of a mesh cycle, at most 100 characters wide."""
    text = f"Operation of {report.name}, {report.flank} flanks: first contact of all teeth, one mesh cycle\n"
    text += layout_line(report.design, report.mounting) + error_line(report.design.errors)
    text += parabola_line(report.design) + backlash_lines(report.design)
    eq16 = "not known" if math.isnan(report.eq16) else f"{report.eq16:.6f}"
    if report.reason:
        return text + line("contact ratio", f"{eq16} by Eq. 16")
    operating, near = (
        f"not known ({doubt})" if doubt else f"{value:.6f}"
        for value, doubt in zip((report.operating, report.within_film), report.doubts, strict=True)
    )
    near += f" within {1e3 * report.film:g} um of touching"
    text += line("contact ratio", f"{eq16} by Eq. 16; in operation {operating}, {near}")
    cycle = report.cycle
    text += line("transmission error", f"{ARCSEC * float(cycle.peak_to_peak):z.4f} arcsec peak to peak")
    amplitudes = ", ".join(f"{value:z.4f}" for value in ARCSEC * np.abs(cycle.harmonics))
    text += line("amplitudes", f"{amplitudes} arcsec at the mesh frequency and its multiples")
    text += line("edges", f"carry {100.0 * float(cycle.edge_share):.1f} % of the cycle")
    changes = (cycle.changes[cycle.hand_over] - float(cycle.start)) / cycle.pitch
    text += line("hand-over", ", ".join(f"{at:.4f}" for at in changes) + " pitches into the cycle")
    return text + "\n" + _position_lines(report)


def _position_lines(report: OperationReport) -> str:
    first, pitch = report.first, report.cycle.pitch
    heading = f"{'pitches':>9}{'pinion roll':>13}{'tr. error':>11}{'pair':>6}{'pinion z':>10}{'gear z':>10}"
    units = f"{'':>9}{'deg':>13}{'arcsec':>11}{'':>6}{'mm':>10}{'mm':>10}"
    lines = [f"{heading}  carried by", units]
    for index in np.unique(np.linspace(0, first.pinion_roll.size - 1, SHOWN + 1).round().astype(int)):
        share = (first.pinion_roll[index] - float(report.cycle.start)) / pitch
        error = ARCSEC * first.transmission_error[index]
        numbers = f"{share:9.4f}{math.degrees(first.pinion_roll[index]):13.6f}{error:z11.4f}"
        places = f"{first.pair[index]:6d}{first.z1[index]:10.4f}{first.z2[index]:10.4f}"
        lines.append(f"{numbers}{places}  {report.carriers[index]}")
    return "\n".join(lines) + "\n"
