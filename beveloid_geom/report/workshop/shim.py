"""The axial positions that give a backlash, and put the path where it is wanted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...design.model import Design
from ...status import ShimStatus
from ...workshop.shim import Shim, shim
from ..result import Rows
from ..words import head_data, line, mounted_lines, name_in_files

MEMBERS = ("pinion", "gear")
WHY = {
    ShimStatus.NO_EFFECT: "axial positions do not change the backlash: neither member has a cone",
    ShimStatus.NO_PATH: "at no axial positions tried has the pair a path on these flanks",
    ShimStatus.NOT_FOUND: "no axial positions were found that give what is wanted, along which first contacts"
    " and the path stay known",
}


@dataclass(frozen=True, eq=False)
class ShimReport:
    """The axial positions `found`, and, where a place of the path is wanted, `least`, those of the backlash
    alone."""

    name: str
    found: Shim
    least: Shim | None

    @property
    def reason(self) -> str | None:
        """Why there are none, None if there are."""
        found = self.found
        if found.status == ShimStatus.OUT_OF_REACH:
            pinion, gear = found.axial
            moved = f"moves the pinion by {pinion:+.3f} and the gear by {gear:+.3f} mm"
            return f"it {moved}, more than the lesser face width, {found.limit:g} mm"
        return WHY.get(found.status)

    @property
    def failure(self) -> str | None:
        """Why there is nothing."""
        return f"No shims: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give the positions, what they are for, and what the pair has there; mm and rad."""
        data = {
            **head_data(self.name, self.found.design, self.found.flank),
            "wanted_backlash": self.found.wanted_backlash,
            "wanted_z": self.found.wanted_z,
            "limit": self.found.limit,
            "shim": _numbers(self.found),
            "by_backlash_alone": None if self.least is None else _numbers(self.least),
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the positions, a member a row."""
        return {"member": MEMBERS, "axial": self.found.axial, "mounting": self.found.distance}

    def summary(self) -> str:
        """Write the positions, what the pair has there, and why there are none."""
        found = self.found
        text = f"Shims of {self.name}: axial positions for a normal backlash of {found.wanted_backlash:g} mm"
        if not math.isnan(found.wanted_z):
            text += f",\nmiddle of the path at z = {found.wanted_z:g} mm on the pinion, {found.flank} flanks"
        text += "\n\n" + mounted_lines(found.design)
        if not math.isnan(found.residual):
            text += _lines(found)
        if self.reason:
            text += line("none", self.reason)
            if self.least is not None and not math.isnan(self.least.residual):
                text += line("backlash alone", "is there with the least moves:") + _lines(self.least)
        return text + line("positions", "moves from the mounting above, positive towards the heel")


def _numbers(found: Shim) -> dict[str, Any]:
    """Give the entries of JSON."""
    names = ("backlash", "z", "contact_ratio", "residual")
    return {
        "status": name_in_files(found.status),
        **{f"{name}_axial": value for name, value in zip(MEMBERS, found.axial, strict=True)},
        **{f"{name}_mounting": value for name, value in zip(MEMBERS, found.distance, strict=True)},
        **{name: getattr(found, name) for name in names},
    }


def _lines(found: Shim) -> str:
    """Write the positions and what the pair has there."""
    moves = zip(MEMBERS, found.axial, found.distance, ("dw1", "dw2"), strict=True)
    text = "".join(
        line(f"move the {name}", f"{move:+z.6f} mm, to {letters} = {distance:.6f} mm")
        for name, move, distance, letters in moves
    )
    path = (
        f"middle of the path at z = {found.z:z.4f} mm on the pinion, contact ratio {found.contact_ratio:.4f}"
    )
    path = "no path on these flanks" if math.isnan(found.z) else path
    return text + line("there", f"backlash {found.backlash:.9f} mm; {found.flank} flanks: {path}")


def shim_report(name: str, design: Design, backlash: float, at: float | None, flank: str) -> ShimReport:
    """Find axial positions of a single design; where there are none for the place wanted, those of the
    backlash alone, too. Arguments and ValueError as of `shim`."""
    found = shim(design, backlash, at, flank)
    alone = at is not None and found.status != ShimStatus.REACHED
    return ShimReport(name, found, shim(design, backlash, None, flank) if alone else None)
