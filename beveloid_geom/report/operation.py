"""A pair in operation: one mesh cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.path import contact_ratio
from ..design.model import Design
from ..findings.backlash import backlash_report
from ..findings.path import UNKNOWN
from ..operation.first_contact import FirstContact
from ..operation.mesh_cycle import MeshCycle
from ..operation.operating_ratio import operating_ratios
from ..status import FirstStatus, Limit, RatioStatus
from .columns import number, table_lines
from .result import Rows
from .words import failure_of, head_data, line, mounted_lines, name_in_files

FIELDS = ("pinion_roll", "gear_roll", "transmission_error", "pair", "l1", "z1", "l2", "z2")
"""Numbers of a position."""
SHOWN = ("pinion_roll", "transmission_error", "pair", "z1", "z2")
INTERVALS = 12
"""Of the cycle between the positions of a text."""
RATIOS = ("operating_contact_ratio", "operating_contact_ratio_within_film")
DOUBTS = {
    RatioStatus.NO_FIRST_CONTACT: "at some rolls there is no first contact",
    RatioStatus.NOT_CONVERGED: "the clearance of a tooth pair did not converge",
    RatioStatus.TOO_THICK: "the film reaches beyond the tooth pairs looked at, take a thinner one",
    RatioStatus.UNSTEADY: "the rolls at which a tooth pair touches cannot be told apart",
}
"""Why an operating contact ratio is not known."""


@dataclass(frozen=True, eq=False)
class OperationReport:
    """One mesh cycle of a flank pair: its `cycle`, first contacts at even rolls, and the contact
    ratios by Eq. 16, in operation, and within `film` (mm) of touching. `reason` says why the
    cycle is not known, None if it is; `doubts` the same of the last two ratios; `along_lines` whether it is
    lines of contact that carry, of which the first contacts are points."""

    name: str
    design: Design
    flank: str
    cycle: MeshCycle
    first: FirstContact
    eq16: float
    operating: float
    film: float
    within_film: float
    reason: str | None
    doubts: tuple[str | None, str | None]
    along_lines: bool

    @property
    def status(self) -> list[str]:
        """Names of the statuses of the positions."""
        return [name_in_files(FirstStatus(int(code))) for code in self.first.status]

    @property
    def carriers(self) -> list[str]:
        """What carries at each position: 'flanks', or edges as 'gear tip'; with 'on fillet'."""
        words = []
        for codes, on_fillet, status in zip(self.first.limit, self.first.on_fillet, self.status, strict=True):
            edges = " and ".join(str(Limit(int(code))) for code in codes if code >= 0)
            text = (edges or "flanks") + (" on fillet" if on_fillet.any() else "")
            text = "a line" if self.along_lines else text
            words.append(text if status == "solved" else status)
        return words

    @property
    def failure(self) -> str | None:
        """Why the cycle is not known, or why the pair cannot be assembled."""
        return failure_of(self.reason, self.design)

    @property
    def positions(self) -> dict[str, Any]:
        """Numbers and words of the positions by their names in JSON and CSV."""
        numbers = {name: getattr(self.first, name) for name in FIELDS}
        return {**numbers, "carried_by": self.carriers, "status": self.status}

    def data(self) -> dict[str, Any]:
        """Give the cycle and its positions."""
        cycle = self.cycle
        data = {
            **head_data(self.name, self.design, self.flank),
            "contact_ratio": self.eq16,
            "film": self.film,
            **dict(zip(RATIOS, (self.operating, self.within_film), strict=True)),
            "pitch": cycle.pitch,
            "peak_to_peak": cycle.peak_to_peak,
            "mean": cycle.mean,
            "amplitudes": np.abs(cycle.harmonics),
            "edge_share": cycle.edge_share,
            "changes": cycle.changes,
            "hand_over": cycle.hand_over,
            "positions": self.positions,
        }
        reasons = {"reason": self.reason}
        reasons |= {f"{key}_reason": doubt for key, doubt in zip(RATIOS, self.doubts, strict=True)}
        return data | {key: reason for key, reason in reasons.items() if reason}

    def rows(self) -> Rows:
        """Give the positions."""
        backlash = np.full(self.first.status.size, backlash_report(self.design).normal)
        return {**self.positions, "mounted_backlash": backlash}

    def summary(self) -> str:
        """Write some positions of the cycle, then what it comes to."""
        text = f"Operation of {self.name}, {self.flank} flanks: first contact of all teeth, one mesh cycle\n"
        eq16 = "not known" if math.isnan(self.eq16) else number("contact_ratio", self.eq16)
        if self.reason:
            return text + mounted_lines(self.design) + line("contact ratio", f"{eq16} by Eq. 16")
        text += "\n" + self._position_lines() + "\n" + mounted_lines(self.design)
        operating, near = (
            f"not known ({doubt})" if doubt else number("contact_ratio", value)
            for value, doubt in zip((self.operating, self.within_film), self.doubts, strict=True)
        )
        near += f" within {1e3 * self.film:g} um of touching"
        text += line("contact ratio", f"{eq16} by Eq. 16; in operation {operating}, {near}")
        cycle = self.cycle
        text += line(
            "transmission error", f"{number('peak_to_peak', cycle.peak_to_peak)} arcsec peak to peak"
        )
        amplitudes = ", ".join(number("peak_to_peak", value) for value in np.abs(cycle.harmonics))
        text += line("amplitudes", f"{amplitudes} arcsec at the mesh frequency and its multiples")
        share = f"carry {100.0 * float(cycle.edge_share):.1f} % of the cycle"
        text += line("edges", "are the ends of the lines that carry" if self.along_lines else share)
        changes = (cycle.changes[cycle.hand_over] - float(cycle.start)) / cycle.pitch
        return text + line("hand-over", ", ".join(f"{at:.4f}" for at in changes) + " pitches into the cycle")

    def _position_lines(self) -> str:
        first, size = self.first, self.first.pinion_roll.size
        picked = np.unique(np.linspace(0, size - 1, INTERVALS + 1).round().astype(int))
        columns = {"pitches": (first.pinion_roll - float(self.cycle.start)) / self.cycle.pitch}
        columns |= {name: getattr(first, name) for name in SHOWN}
        carriers, status = self.carriers, self.status
        return table_lines(
            {name: values[picked] for name, values in columns.items()},
            [status[k] for k in picked],
            {"carried by": [carriers[k] for k in picked]},
        )


def operation_report(
    name: str, design: Design, flank: str, points: int, harmonics: int, film: float
) -> OperationReport:
    """Find the mesh cycle of a single design at `points` positions; `film` in mm."""
    found = operating_ratios(design, flank, (0.0, film), harmonics)
    cycle, ratios = found.cycle, found.ratio.tolist()
    first = cycle.at(float(cycle.start) + cycle.pitch * np.linspace(0.0, 1.0, points))
    doubts = [None if cycle.lost else DOUBTS.get(RatioStatus(int(code))) for code in found.status]
    why = UNKNOWN[FirstStatus(int(cycle.status))] if cycle.lost else ""
    return OperationReport(
        name=name,
        design=design,
        flank=flank,
        cycle=cycle,
        first=first,
        eq16=float(contact_ratio(design, flank)),
        operating=ratios[0],
        film=film,
        within_film=ratios[1],
        reason=f"no first contact of the {flank} teeth: {why}" if why else None,
        doubts=(doubts[0], doubts[1]),
        along_lines=bool(cycle.along_lines),
    )
