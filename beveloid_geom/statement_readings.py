"""Whether the paper's statements hold under another reading of what it leaves open.

Where the calculation contradicts a statement, the reason may lie in what the paper does not say: how the
pair is mounted, where the flanks end, which way a coefficient counts. Each reading changes one of these
and leaves the rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from .closing import closing_of
from .inputs import Design, Errors, Member
from .mounting import mounting_of
from .statement_verdicts import Verdict
from .statements import paper_statements

FACES, DEPTH, ALONG = 6.0, 0.1, 0.2
"""Times the face width; modules of addendum and dedendum; pinion face widths along the axes."""


@dataclass(frozen=True)
class Reading:
    """A reading of the paper by the `name` of what it changes: its design, sign of the coefficients."""

    name: str
    design: Design
    sign: int = 1


def readings_of(design: Design) -> tuple[Reading, ...]:
    """The design as it is, without its errors, and with one thing changed at a time."""
    design = replace(design, errors=Errors())
    found = [
        Reading("as given", design),
        Reading("coefficients of the other sign", design, -1),
        Reading(f"faces {FACES:g} times as wide", _members(design, _wider)),
        Reading(f"teeth {DEPTH:g} modules lower", _members(design, lambda m: _deeper(m, -DEPTH))),
        Reading(f"teeth {DEPTH:g} modules higher", _members(design, lambda m: _deeper(m, DEPTH))),
        Reading("no profile shift", _members(design, lambda m: replace(m, profile_shift=0.0))),
    ]
    step = ALONG * float(design.pinion.face_width)
    for word, sign in (("heels", 1.0), ("toes", -1.0)):
        found.append(Reading(f"mounted {step:g} mm to the {word}", _mounted(design, sign * step)))
    offset = closing_of(design).offset
    if math.isfinite(offset):
        closed = replace(design, pair=replace(design.pair, offset=offset))
        found.append(Reading(f"lines of action meet: E = {offset:.4f} mm", closed))
    return tuple(found)


def verdicts_by_reading(design: Design, flank: str = "right") -> dict[str, dict[str, Verdict]]:
    """Verdicts by the ids of the statements, under each reading by its name."""
    return {
        one.name: {s.id: s.verdict for s in paper_statements(one.design, flank, sign=one.sign)}
        for one in readings_of(design)
    }


def _members(design: Design, change: Callable[[Member], Member]) -> Design:
    return replace(design, pinion=change(design.pinion), gear=change(design.gear))


def _wider(member: Member) -> Member:
    return replace(member, face_width=FACES * member.face_width)


def _deeper(member: Member, by: float) -> Member:
    tool = member.tool
    return replace(member, tool=replace(tool, addendum=tool.addendum + by, dedendum=tool.dedendum + by))


def _mounted(design: Design, by: float) -> Design:
    """Both members moved along their axes, mm."""
    pinion, gear = (float(value) + by for value in mounting_of(design).distance)
    return replace(design, pair=replace(design.pair, pinion_mounting=pinion, gear_mounting=gear))
