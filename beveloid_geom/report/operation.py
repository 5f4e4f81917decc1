"""Report of `operation`: one mesh cycle of a pair."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..contact.path import contact_ratio
from ..design.ends import limit_words
from ..design.model import Design
from ..findings.backlash import backlash_report, equal_teeth_remarks
from ..findings.diagnostics import NOTE, UNKNOWN, WARNING, Remark, remarks_data
from ..findings.path import first_contact_reason
from ..operation.contact_pattern.motion import first_contact_operation
from ..operation.contact_pattern.pattern import ContactPattern, contact_pattern
from ..operation.first_contact import FirstContact
from ..operation.mesh_cycle import MeshCycle
from ..operation.operating_ratio import operating_ratios
from ..operation.pitch_cycle import PitchCycle, pitch_cycle
from ..status import FirstStatus, Limit, NotComputed, RatioStatus
from ..support.process import NOT_COMPUTED
from .columns import number, table_lines
from .result import Failure, Report, Rows, failure_of, picked, plain
from .text import line, mounted_lines, remark_lines


@dataclass(frozen=True, eq=False)
class OperationReport(Report):
    """One mesh cycle of a flank pair.

    Attributes
    ----------
    cycle : MeshCycle
        Segments of first contacts.
    first : FirstContact
        First contacts at equally spaced rolls.
    eq16, operating, within_film : float
        Contact ratios: of one tooth pair (Eq. 16 of the paper), in operation, and with a clearance up to
        `film`.
    film : float
        Film thickness, mm.
    reason : str or None
        Reason for an unknown cycle.
    doubts : tuple of str or None
        Reasons for unknown values of `operating` and `within_film`.
    along_lines : bool
        Whether the flanks have line contact; first contacts are then points of the lines.
    pitch_cycle : PitchCycle or None
        Transmission error over all pairs of teeth; None if all teeth of each member are equal.
    """

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
    pitch_cycle: PitchCycle | None

    @property
    def status(self) -> list[str]:
        """Names of the statuses of the positions."""
        return list(plain(self.first.status, FirstStatus))

    @property
    def carriers(self) -> list[str]:
        """Surfaces in contact at each position, for files: 'flanks', or edges such as 'gear tip', or 'on
        fillet'."""
        return self._carriers(lambda code: str(Limit(code)))

    @property
    def carriers_in_print(self) -> list[str]:
        """Surfaces in contact at each position, with the printed names of the ends of the face
        (`design.ends`)."""
        return self._carriers(lambda code: limit_words(self.design, code))

    def _carriers(self, name: Callable[[int], str]) -> list[str]:
        """Return the surfaces in contact at each position; `name` converts the code of an edge."""
        words = []
        for codes, on_fillet, status in zip(self.first.limit, self.first.on_fillet, self.status, strict=True):
            edges = " and ".join(name(int(code)) for code in codes if code >= 0)
            text = (edges or "flanks") + (" on fillet" if on_fillet.any() else "")
            text = "a line" if self.along_lines else text
            words.append(text if status == "solved" else status)
        return words

    @property
    def failure(self) -> Failure | None:
        """Failure if the cycle or a contact ratio is unknown, or if the pair cannot be assembled."""
        return failure_of(self.reason, self.design) or self.unknown

    @property
    def unknown(self) -> Failure | None:
        """Failure if the cycle or a contact ratio is unknown."""
        failed = (doubt for doubt in self.doubts if isinstance(doubt, NotComputed))
        ratio = next((NotComputed(f"operating contact ratio: {doubt}") for doubt in failed), None)
        return failure_of(self.reason or ratio)

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Remarks on the cycle: a failed calculation, edge contact, the transmission error of all teeth, and
        edges that the pattern reaches."""
        lead, failure = f"{self.flank} flanks, in operation", self.failure
        if failure is not None and failure.status == NOT_COMPUTED:
            return (Remark(UNKNOWN, f"{lead}: {failure.text}"),)
        if self.reason:
            return ()
        remarks = list(self.edge_remarks)
        if self.pitch_cycle is not None:
            words = self._pitch_words(self.pitch_cycle)
            error = f"{self.flank} flanks, transmission error with the deviations of all teeth"
            remarks.append(Remark(NOTE, f"{error}: {words}"))
        # Without a film, and if the pair cannot be assembled, there is no pattern.
        if self.film > 0.0 and not backlash_report(self.design).jam:
            pattern = f"the contact pattern for a film of {1e3 * self.film:g} um reaches {self.edges_reached}"
            remarks.append(Remark(NOTE, f"{self.flank} flanks: {pattern}"))
        return tuple(remarks)

    @property
    def edge_remarks(self) -> tuple[Remark, ...]:
        """Remark on edge contact in a known cycle; otherwise empty."""
        share = float(self.cycle.edge_share)
        if not share > 0.0 or self.along_lines:
            return ()
        codes = np.unique(self.first.limit[self.first.limit >= 0])
        edges = ", ".join(limit_words(self.design, int(code)) for code in codes)
        where = f" ({edges})" if edges else ""  # few positions may miss the edges
        text = f"edges touch during {100.0 * share:.3g} % of the mesh cycle{where}"
        return (Remark(WARNING, f"{self.flank} flanks, in operation: {text}"),)

    @cached_property
    def pattern(self) -> ContactPattern:
        """Contact pattern for the thickness `film`, which must be larger than 0."""
        operation = first_contact_operation(self.design, self.flank, self.cycle)
        return contact_pattern(self.design, self.flank, self.film, operation=operation)

    @property
    def edges_reached(self) -> str:
        """Printed names of the edges, except roots, that the contact pattern of the film reaches."""
        ends = self.pattern.ends
        reached = (limit for limit in Limit if ends[limit] and limit.limit != "root")
        return ", ".join(limit_words(self.design, limit) for limit in reached) or "no edge"

    @property
    def ratios(self) -> tuple[tuple[float, float], tuple[str | None, str | None]]:
        """Contact ratios in operation, without and within the film, and reasons for unknown ones. Both are
        unknown if the pair cannot be assembled."""
        if backlash_report(self.design).jam:
            return (math.nan, math.nan), ("jammed", "jammed")
        return (self.operating, self.within_film), self.doubts

    @property
    def positions(self) -> dict[str, Any]:
        """Columns of the positions in JSON and CSV."""
        # Quantities of a position.
        fields = ("pinion_roll", "gear_roll", "transmission_error", "pair", "l1", "z1", "l2", "z2")
        return {**picked(self.first, *fields), "carried_by": self.carriers, "status": self.status}

    def values(self) -> dict[str, Any]:
        """Return the cycle, its positions, and the reasons for unknown contact ratios."""
        # Quantities of a cycle with pitch deviations.
        pitch_fields = (
            "pitches",
            "peak_to_peak",
            "pinion_roll",
            "transmission_error",
            "pinion_tooth",
            "gear_tooth",
        )
        ratios = ("operating_contact_ratio", "operating_contact_ratio_within_film")
        values, doubts = self.ratios
        cycle = self.cycle
        return {
            "contact_ratio": self.eq16,
            "film": self.film,
            **dict(zip(ratios, values, strict=True)),
            **picked(cycle, "pitch", "peak_to_peak"),
            "cycle_peak_to_peak": cycle.peak_to_peak,
            "mean": cycle.mean,
            "amplitudes": np.abs(cycle.harmonics),
            **picked(cycle, "edge_share", "changes", "hand_over"),
            **({} if self.pitch_cycle is None else {"pitch_cycle": picked(self.pitch_cycle, *pitch_fields)}),
            "positions": self.positions,
            **remarks_data((*self.remarks, *equal_teeth_remarks(self.design))),
            **{f"{key}_reason": doubt for key, doubt in zip(ratios, doubts, strict=True) if doubt},
        }

    def rows(self) -> Rows:
        """Return the positions."""
        return {**self.positions, "mounted_backlash": backlash_report(self.design).normal}

    def summary(self) -> str:
        """Return some positions of the cycle, contact ratios and transmission error."""
        text = f"Operation of {self.name}, {self.flank} flanks: first contact of all teeth, one mesh cycle\n"
        eq16 = "not known" if math.isnan(self.eq16) else number("contact_ratio", self.eq16)
        mounted = mounted_lines(self.design) + remark_lines(equal_teeth_remarks(self.design))
        if self.reason:
            return text + mounted + line("contact ratio", f"{eq16} of one tooth pair (Eq. 16)")
        text += "\n" + self._position_lines() + "\n" + mounted + remark_lines(self.remarks)
        operating, near = (
            f"{'could not be computed' if isinstance(doubt, NotComputed) else 'not known'} ({doubt})"
            if doubt
            else number("contact_ratio", value)
            for value, doubt in zip(*self.ratios, strict=True)
        )
        near += f" with clearances up to {1e3 * self.film:g} um"
        text += line("contact ratio", f"{eq16} of one tooth pair (Eq. 16), {operating} in operation, {near}")
        cycle = self.cycle
        text += line(
            "transmission error", f"{number('peak_to_peak', cycle.peak_to_peak)} arcsec peak to peak"
        )
        amplitudes = ", ".join(number("peak_to_peak", value) for value in np.abs(cycle.harmonics))
        text += line("amplitudes", f"{amplitudes} arcsec at the mesh frequency and its multiples")
        share = f"during {100.0 * float(cycle.edge_share):.1f} % of the mesh cycle"
        text += line("edge contact", "none before the flanks touch" if self.along_lines else share)
        pair = "number k of the tooth pair in contact: tooth k of the pinion and tooth -k of the gear"
        text += line("pair", f"{pair}; tooth 0 is on the x axis at roll 0, the others follow from x to y")
        if self.along_lines:
            return text + line("hand-over", "none, because several pairs are in contact at the same time")
        changes = (cycle.changes[cycle.hand_over] - float(cycle.start)) / cycle.pitch
        return text + line("hand-over", ", ".join(f"{at:.4f}" for at in changes) + " pitches into the cycle")

    def _pitch_words(self, cycle: PitchCycle) -> str:
        """Return the transmission error with the deviations of all teeth."""
        peak = number("peak_to_peak", cycle.peak_to_peak)
        teeth = [int(np.ravel(x)[np.nanargmax(cycle.transmission_error)]) for x in cycle.teeth]
        where = f"the gear is furthest ahead at pinion tooth {teeth[0]} and gear tooth {teeth[1]}"
        return f"{peak} arcsec peak to peak over {cycle.pitches} pitches; {where}"

    def _position_lines(self) -> str:
        """Return a table of 13 positions."""
        first, size = self.first, self.first.pinion_roll.size
        picked = np.unique(np.linspace(0, size - 1, 13).round().astype(int))
        columns = {"pitches": (first.pinion_roll - float(self.cycle.start)) / self.cycle.pitch}
        columns |= {name: getattr(first, name) for name in ("pinion_roll", "transmission_error", "pair")}
        columns |= {"z1": first.z1, "z2": first.z2}
        carriers, status = self.carriers_in_print, self.status
        return table_lines(
            {name: values[picked] for name, values in columns.items()},
            [status[k] for k in picked],
            {"in contact": [carriers[k] for k in picked]},
        )


def operation_report(
    name: str, design: Design, flank: str, points: int, harmonics: int, film: float
) -> OperationReport:
    """Return the mesh cycle of a single design at `points` positions; `film` in mm.

    Raises ValueError as `pitch_cycle`."""
    deviated = any(member.differs_by_tooth(flank) for member in design.members)
    result = operating_ratios(design, flank, (0.0, film), harmonics)
    cycle, ratios = result.cycle, result.ratio.tolist()
    first = cycle.at(float(cycle.start) + cycle.pitch * np.linspace(0.0, 1.0, points))
    reasons = {
        RatioStatus.NO_FIRST_CONTACT: NotComputed("there is no first contact at some rolls"),
        RatioStatus.NOT_CONVERGED: NotComputed("the clearance of a tooth pair did not converge"),
        RatioStatus.TOO_THICK: "the film reaches beyond the tooth pairs considered: choose a thinner film",
        RatioStatus.UNSTEADY: NotComputed("the rolls at which a tooth pair touches cannot be distinguished"),
    }
    doubts = [None if cycle.lost else reasons.get(RatioStatus(int(code))) for code in result.status]
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
        reason=first_contact_reason(flank, int(cycle.status)) if cycle.lost else None,
        doubts=(doubts[0], doubts[1]),
        along_lines=bool(cycle.along_lines),
        pitch_cycle=None if cycle.lost or not deviated else pitch_cycle(design, flank),
    )
