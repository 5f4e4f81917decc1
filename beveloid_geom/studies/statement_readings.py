"""Whether the paper's statements hold under another reading of what it leaves open.

Where the calculation contradicts a statement, the reason may lie in what the paper does not say: how the
pair is mounted, where the flanks end, which way a coefficient counts. Each reading changes one of these
and leaves the rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..design.model import Design, Errors, Member, Pair
from ..pair.closing import closing_of, zero_backlash_layout
from ..pair.mounting import mounting_of
from .statement_verdicts import Statement, Verdict
from .statements import paper_statements

FACES, DEPTH = 6.0, 0.1
"""Times the face width; modules of addendum and dedendum."""
ALONG = (0.2, 0.45)
"""Pinion face widths along the axes: a path in the middle of Table 1's faces stays between toe and heel
by the first, and runs off by the second."""


@dataclass(frozen=True)
class Reading:
    """A reading of the paper by the `name` of what it changes: its design, sign of the coefficients."""

    name: str
    design: Design
    sign: int = 1


def readings_of(design: Design) -> tuple[Reading, ...]:
    """Give the design as it is, without its errors, and with one thing changed at a time."""
    design = replace(design, errors=Errors())
    found = [
        Reading("as given", design),
        Reading("coefficients of the other sign", design, -1),
        Reading(f"faces {FACES:g} times as wide", _members(design, _wider)),
        Reading(f"teeth {DEPTH:g} modules lower", _members(design, lambda m: _deeper(m, -DEPTH))),
        Reading(f"teeth {DEPTH:g} modules higher", _members(design, lambda m: _deeper(m, DEPTH))),
        Reading("no profile shift", _members(design, lambda m: replace(m, profile_shift=0.0))),
    ]
    for share in ALONG:
        step = share * float(design.pinion.face_width)
        for word, sign in (("heels", 1.0), ("toes", -1.0)):
            found.append(Reading(f"mounted {step:g} mm to the {word}", _mounted(design, sign * step)))
    return (*found, *_closed(design))


def _closed(design: Design) -> list[Reading]:
    """Find layouts in which the lines of action meet, those there are."""
    found, closing = [], closing_of(design)
    if closing.offset >= 0.0:
        pair = replace(design.pair, offset=closing.offset)
        found.append(
            Reading(f"lines of action meet: E = {closing.offset:.4f} mm", replace(design, pair=pair))
        )
    if math.isfinite(closing.shaft_angle):
        name = f"lines of action meet: d = {math.degrees(closing.shaft_angle):.4f} deg"
        pair = replace(design.pair, shaft_angle=closing.shaft_angle)
        found.append(Reading(name, replace(design, pair=pair)))
    try:
        ideal = zero_backlash_layout(design)
    except ValueError:
        return found
    if float(ideal.offset) < 0.0:
        return found
    pinion, gear = ideal.mounting.tolist()
    pair = Pair(float(ideal.offset), float(ideal.shaft_angle), pinion, gear)
    return [*found, Reading("no backlash, all of the layout follows", replace(design, pair=pair))]


def statements_by_reading(design: Design, flank: str = "right") -> dict[str, dict[str, Statement]]:
    """Judge the statements, by their ids, under each reading by its name."""
    return {
        one.name: {s.id: s for s in paper_statements(one.design, flank, sign=one.sign)}
        for one in readings_of(design)
    }


def verdicts_by_reading(design: Design, flank: str = "right") -> dict[str, dict[str, Verdict]]:
    """Find verdicts by the ids of the statements, under each reading by its name."""
    return {
        name: {id_: one.verdict for id_, one in found.items()}
        for name, found in statements_by_reading(design, flank).items()
    }


def _members(design: Design, change: Callable[[Member], Member]) -> Design:
    return replace(design, pinion=change(design.pinion), gear=change(design.gear))


def _wider(member: Member) -> Member:
    return replace(member, face_width=FACES * member.face_width)


def _deeper(member: Member, by: float) -> Member:
    tool = member.tool
    return replace(member, tool=replace(tool, addendum=tool.addendum + by, dedendum=tool.dedendum + by))


def _mounted(design: Design, by: float) -> Design:
    """Move both members along their axes, mm."""
    pinion, gear = (float(value) + by for value in mounting_of(design).distance)
    return replace(design, pair=replace(design.pair, pinion_mounting=pinion, gear_mounting=gear))
