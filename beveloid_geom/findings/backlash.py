"""The backlash of a pair as mounted and modified in words and numbers, as all reports have it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..design.model import Design
from ..operation.backlash import FLANKS, Backlash, mounted_backlash
from ..operation.first_contact import FirstContact
from ..pair.mounting import unmodified_backlash
from ..status import FirstStatus, Limit
from .path import UNKNOWN, first_contact_fault


@dataclass(frozen=True, eq=False)
class BacklashReport:
    """The backlash `found` of a single design, None where `fault` says why no first contact can be, and that
    of its unmodified flanks `by_tangency`, mm."""

    found: Backlash | None
    fault: str | None
    by_tangency: float

    @property
    def normal(self) -> float:
        """Least normal backlash (mm) over a mesh cycle, NaN where that is not known."""
        return math.nan if self.found is None else float(self.found.normal)

    @property
    def unknown(self) -> str | None:
        """Why the backlash is not known, None if it is."""
        if self.found is None or self.found.status == FirstStatus.SOLVED:
            return self.fault
        return UNKNOWN[FirstStatus(int(self.found.status))]

    @property
    def jam(self) -> str | None:
        """Why the pair cannot be put together, None if nothing is known against it."""
        if self.found is None or not self.found.jammed:
            return None
        words = "the pair cannot be assembled"
        if not self.unknown:
            size = f"the normal backlash is {self.normal:#.4g} mm as mounted"
            return f"{words}: the other flanks interfere, {size}"
        reasons = [self.unknown] if self.found.status == FirstStatus.MEETS_BOTTOM else []
        if self.by_tangency < 0.0 or not reasons:
            reasons.append("the other flanks interfere")
        return f"{words}: {', '.join(reasons)}"

    @property
    def line(self) -> str:
        """A line of a table without its label."""
        if self.unknown:
            return f"not known: {self.unknown}"
        assert self.found is not None  # it is known
        at = f"least at a pinion roll of {math.degrees(float(self.found.pinion_roll)):.4f} deg"
        stops = ", ".join(f"on the {flank} {_stop(getattr(self.found, flank))}" for flank in FLANKS)
        return f"{self.normal:z.6f} mm with errors and parabolas, {at}: {stops}"


def _stop(first: FirstContact) -> str:
    """Say what stops the gear in a first contact of one position."""
    edges = " and ".join(
        f"the {Limit(int(code)).member}'s {Limit(int(code)).limit}" for code in _edges(first)
    )
    fillet = " in a fillet" if first.on_fillet.any() else ""
    return (f"stopped by {edges}" if edges else "flank on flank") + fillet


def _edges(first: FirstContact) -> list[int]:
    return [int(code) for code in first.limit.ravel() if code >= 0]


def backlash_report(design: Design) -> BacklashReport:
    """Find the backlash of a single design, with its errors and parabolas."""
    fault = first_contact_fault(design)
    found = None if fault else mounted_backlash(design)
    return BacklashReport(found, fault, float(unmodified_backlash(design)))


def backlash_data(design: Design) -> dict[str, Any]:
    """Give JSON: what is least, where, and what stops the gear there on either side; mm and rad."""
    report = backlash_report(design)
    data: dict[str, Any] = {"normal": report.normal}
    if report.unknown:
        data["reason"] = report.unknown
    elif report.found is not None:
        data["pinion_roll"] = report.found.pinion_roll
        for flank in FLANKS:
            first: FirstContact = getattr(report.found, flank)
            edges = [{"member": Limit(code).member, "limit": Limit(code).limit} for code in _edges(first)]
            data[flank] = {"pair": first.pair[0], "edges": edges, "on_fillet": bool(first.on_fillet.any())}
    return {"mounted_backlash": data, "jammed": report.jam is not None}
