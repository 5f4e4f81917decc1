"""Report of `shim`: axial positions for a given backlash and place of the path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...arrays import MEMBERS
from ...design.model import Design
from ...status import ShimStatus
from ...support.process import NO_CONTACT, NOT_COMPUTED
from ...workshop.shim import Shim, shim
from ..result import Failure, ResultReport, Rows, by_member, picked
from ..text import line, mounted_lines


@dataclass(frozen=True, eq=False)
class ShimReport(ResultReport[Shim]):
    """Axial positions of a single design.

    `result` contains the positions for backlash and place of the path. If they do not exist, `least` contains
    the positions for the backlash alone."""

    least: Shim | None

    @property
    def reason(self) -> str | None:
        """Reason for missing shims, None if there are shims."""
        result = self.result
        if result.status == ShimStatus.OUT_OF_REACH:
            pinion, gear = result.axial
            moved = f"moves the pinion by {pinion:+.3f} and the gear by {gear:+.3f} mm"
            return f"the solution {moved}, more than the smaller face width, {result.limit:g} mm"
        reasons = {
            ShimStatus.NO_EFFECT: "axial positions do not change the backlash: both members are cylindrical",
            ShimStatus.NO_PATH: "the pair has no path on these flanks at any axial position that was tried",
            ShimStatus.NOT_FOUND: "no axial positions were found that satisfy the requirements; the search"
            " stops where a first contact or the path is unknown",
        }
        return reasons.get(result.status)

    @property
    def failure(self) -> Failure | None:
        """Failure if there are no shims: exit status 4 if the search failed (NOT_FOUND), otherwise 1.

        NOT_FOUND does not tell a failed calculation from requirements without a solution."""
        status = NOT_COMPUTED if self.result.status == ShimStatus.NOT_FOUND else NO_CONTACT
        return Failure(f"No shims: {self.reason}", status) if self.reason else None

    def values(self) -> dict[str, Any]:
        """Return the axial positions and the results at these positions; mm and rad."""
        return {
            **picked(self.result, "wanted_backlash", "wanted_z", "limit"),
            "shim": _numbers(self.result),
            "by_backlash_alone": None if self.least is None else _numbers(self.least),
        }

    def rows(self) -> Rows:
        """Return the positions, one row for each member."""
        return {"member": MEMBERS, "axial": self.result.axial, "mounting": self.result.distance}

    def summary(self) -> str:
        """Return the positions and the results there, or the reason why there are none."""
        result = self.result
        text = f"Shims of {self.name}: axial positions for a normal backlash of {result.wanted_backlash:g} mm"
        if not math.isnan(result.wanted_z):
            text += (
                f",\nmiddle of the path at z = {result.wanted_z:g} mm on the pinion, {result.flank} flanks"
            )
        text += "\n\n" + mounted_lines(result.design)
        if not math.isnan(result.residual):
            text += _lines(result)
        if self.reason:
            text += line("no shims", self.reason)
            if self.least is not None and not math.isnan(self.least.residual):
                text += line(
                    "backlash alone", "smallest displacements without a required position of the path:"
                ) + _lines(self.least)
        return text + line(
            "displacements", "from the mounting distances of the layout above, positive towards +z"
        )


def _numbers(result: Shim) -> dict[str, Any]:
    """Return the entries of JSON."""
    return {
        **picked(result, "status"),
        **by_member("axial", result.axial),
        **by_member("mounting", result.distance),
        **picked(result, "backlash", "z", "contact_ratio", "residual"),
    }


def _lines(result: Shim) -> str:
    """Return the lines on the positions and the results there."""
    displacements = zip(MEMBERS, result.axial, result.distance, ("dw1", "dw2"), strict=True)
    text = "".join(
        line(f"move the {name}", f"{move:+z.6f} mm, to {letters} = {distance:z.6f} mm")
        for name, move, distance, letters in displacements
    )
    ratio = f"contact ratio {result.contact_ratio:.4f}"
    path = f"middle of the path at z = {result.z:z.4f} mm on the pinion, {ratio}"
    path = "no path on these flanks" if math.isnan(result.z) else path
    return text + line("after the move", f"backlash {result.backlash:.9f} mm; {result.flank} flanks: {path}")


def shim_report(name: str, design: Design, backlash: float, at: float | None, flank: str) -> ShimReport:
    """Return the axial positions of a single design; arguments and ValueError as in `shim`."""
    result = shim(design, backlash, at, flank)
    alone = at is not None and result.status != ShimStatus.REACHED
    return ShimReport(name, design, result, shim(design, backlash, None, flank) if alone else None)
