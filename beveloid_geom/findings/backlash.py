"""Backlash of a pair as mounted and modified, as text and for JSON."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..arrays import FLANKS
from ..design.ends import limit_names
from ..design.model import Design
from ..operation.backlash import Backlash, mounted_backlash
from ..operation.first_contact import FirstContact
from ..pair.mounting import unmodified_backlash
from ..status import WHY_NO_FIRST_CONTACT, FirstStatus, Limit
from .diagnostics import NOTE, UNKNOWN, Remark
from .path import first_contact_fault


@dataclass(frozen=True, eq=False)
class BacklashReport:
    """Backlash of a single design as mounted.

    Attributes
    ----------
    design : Design
    backlash : Backlash or None
        Backlash from first contacts; None if first contacts cannot be computed.
    fault : str or None
        Reason why first contacts cannot be computed.
    unmodified : float
        Normal backlash of the flanks without parabolas, with the errors of the design, mm.
    """

    design: Design
    backlash: Backlash | None
    fault: str | None
    unmodified: float

    @property
    def normal(self) -> float:
        """Smallest normal backlash over a mesh cycle, mm; NaN if unknown."""
        return math.nan if self.backlash is None else float(self.backlash.normal)

    @property
    def unknown(self) -> str | None:
        """Reason for an unknown backlash, None if it is known."""
        if self.backlash is None or self.backlash.status == FirstStatus.SOLVED:
            return self.fault
        return WHY_NO_FIRST_CONTACT[FirstStatus(int(self.backlash.status))]

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Remark if the backlash could not be computed, so that the pair may jam; otherwise empty."""
        if (
            self.backlash is None
            or FirstStatus(int(self.backlash.status)).reason_type is str
            or not self.unknown
        ):
            return ()
        return (Remark(UNKNOWN, f"the backlash as mounted could not be computed: {self.unknown}"),)

    @property
    def jam(self) -> str | None:
        """Reason why the pair cannot be assembled, None if it can or if this is unknown."""
        if self.backlash is None or not self.backlash.jammed:
            return None
        words = "the pair cannot be assembled"
        interfere = "the flanks of one side interfere while those of the other side touch"
        if not self.unknown:
            size = f"the normal backlash is {self.normal:#.4g} mm as mounted"
            return f"{words}: {interfere}, {size}"
        reasons = [self.unknown] if self.backlash.status == FirstStatus.MEETS_BOTTOM else []
        if self.unmodified < 0.0 or not reasons:
            reasons.append(interfere)
        return f"{words}: {', and '.join(reasons)}"

    @property
    def line(self) -> str:
        """Text on the backlash for one line of a report."""
        if self.unknown:
            return f"not known: {self.unknown}"
        assert self.backlash is not None  # it is known
        at = f"smallest at a pinion roll of {math.degrees(float(self.backlash.pinion_roll)):z.4f} deg"
        right, left = (_contact(self.design, getattr(self.backlash, flank)) for flank in FLANKS)
        touching = f"right and left flanks touch {right}"
        if right != left:
            touching = f"right flanks touch {right} and left flanks touch {left}"
        return f"{self.normal:z.6f} mm with errors and modifications, {at}, where {touching}"


def _contact(design: Design, first: FirstContact) -> str:
    """Return the surfaces that touch in a first contact at one position."""
    names = (limit_names(design, code) for code in _edges(first))
    edges = " and ".join(f"the {member}'s {limit}" for member, limit in names)
    places = [f"at {edges}"] * bool(edges) + ["in a fillet"] * bool(first.on_fillet.any())
    return " ".join(places) or "without edge contact"


def _edges(first: FirstContact) -> list[int]:
    """Return the codes of the edges in a first contact at one position."""
    return [int(code) for code in first.limit.ravel() if code >= 0]


def equal_teeth_remarks(design: Design) -> tuple[Remark, ...]:
    """Return a note if the teeth of a member differ: the backlash is that of equal teeth; otherwise empty."""
    if not any(member.differs_by_tooth(flank) for member in design.members for flank in FLANKS):
        return ()
    text = "the backlash as mounted ignores pitch deviations and uses the mean of measured teeth"
    return (Remark(NOTE, f"{text}: thicker single teeth can jam even if it is positive"),)


def backlash_report(design: Design) -> BacklashReport:
    """Return the backlash of a single design with its errors and modifications."""
    fault = first_contact_fault(design)
    backlash = None if fault else mounted_backlash(design)
    return BacklashReport(design, backlash, fault, float(unmodified_backlash(design)))


def backlash_data(design: Design) -> dict[str, Any]:
    """Return the entries of JSON: smallest backlash, its roll angle, and the surfaces in contact on both
    sides; mm and rad."""
    report = backlash_report(design)
    data: dict[str, Any] = {"normal": report.normal}
    if report.unknown:
        data["reason"] = report.unknown
    elif report.backlash is not None:
        data["pinion_roll"] = report.backlash.pinion_roll
        for flank in FLANKS:
            first: FirstContact = getattr(report.backlash, flank)
            edges = [{"member": Limit(code).member, "limit": Limit(code).limit} for code in _edges(first)]
            data[flank] = {"pair": first.pair[0], "edges": edges, "on_fillet": bool(first.on_fillet.any())}
    return {"mounted_backlash": data, "jammed": report.jam is not None}
