"""What to change about a layout in which gears do not mesh: advice that was tried before it is given.

Of a few changes, one offset, one shaft angle or one helix angle, each is made, rounded as it is
printed, and looked at as `check` looks at any design. Those with an error or a warning are dropped.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..contact.path import path_of_contact
from ..design.model import Design, Pair
from ..operation.certificate import certify
from ..pair.closing import Closing, closing_of
from ..status import Status
from .layout import (
    FLANKS,
    HELIX_TOLERANCE,
    bare,
    crossing_of,
    ideal_layout,
    layout_remarks,
    remarks_on,
)
from .path import certificate_remarks, first_contact_fault, path_remarks
from .remarks import Remark, in_order, quiet, tooth_remarks

POSITIONS = 101
"""Positions of the path at which `check` looks for what touches earlier."""
DIGITS = 7
"""Significant digits of advice: a hundredth of the tolerances of closing on pairs of usual size."""
PASSES = 8
"""Corrections of a helix angle by what its shaft angle misses; each leaves about a tenth of it."""
MOST = 3
"""Pieces of advice on one design."""
NEAR = 1e-9
"""rad by which the shaft angle of a corrected helix angle may miss that asked for."""
MOST_HELIX = math.radians(60.0)
"""Steepest helix angle that is advised."""


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.{DIGITS}g} deg"


def _helix_of(member: str) -> str:
    """Name the change of one member's helix angle."""
    return f"helix angle of the {member}"


@dataclass(frozen=True)
class Advice:
    """A layout that works, mm and rad: with these helix angles, this offset and this shaft angle the pair
    closes, its gears reach each other, and both flanks have contact. `change` names what differs
    from the design as it is."""

    change: str
    offset: float
    shaft_angle: float
    pinion_helix_angle: float
    gear_helix_angle: float

    def words(self) -> str:
        """Say the change with all numbers that go with it."""
        helix = {_helix_of("pinion"): self.pinion_helix_angle, _helix_of("gear"): self.gear_helix_angle}
        angles = {self.change: _deg(helix[self.change])} if self.change in helix else {}
        angles |= {"E": f"{self.offset:.{DIGITS}g} mm", "shaft angle": _deg(self.shaft_angle)}
        numbers = ", ".join(f"{name} = {value}" for name, value in angles.items())
        return f"change the {self.change}: {numbers}"

    def applied_to(self, design: Design) -> Design:
        """Give the design changed so, mounted at its pitch point."""
        pinion = replace(design.pinion, helix_angle=self.pinion_helix_angle)
        gear = replace(design.gear, helix_angle=self.gear_helix_angle)
        return replace(design, pinion=pinion, gear=gear, pair=Pair(self.offset, self.shaft_angle))


def findings_on(design: Design, closing: Closing | None = None, jam: str | None = None) -> tuple[Remark, ...]:
    """Find all that `check` says of a single design: of layout, teeth and paths on both flanks; `jam` says
    why it cannot be assembled as mounted (`findings.backlash`), where that is known."""
    return in_order(found_on(design, closing, jam))


def found_on(design: Design, closing: Closing | None = None, jam: str | None = None) -> Iterator[Remark]:
    """Find the same one after the other, for those whom the first warning is enough."""
    yield from remarks_on(design, closing, jam)
    paths = [path_of_contact(design, flank, POSITIONS) for flank in FLANKS]
    for path in paths:
        yield from path_remarks(path)
    if first_contact_fault(design) is None:
        for path in paths:
            if path.ends.status == Status.SOLVED:
                yield from certificate_remarks(path, certify(path))


def advice_on(design: Design) -> tuple[Advice, ...]:
    """Find changes of a layout that does not close or has no contact, the nearest first; none where all is
    well or where nothing that was tried helps. Raises ValueError for arrays."""
    plain = bare(design)
    if quiet(layout_remarks(plain)):
        return ()
    known = {remark for name in ("pinion", "gear") for remark in tooth_remarks(name, getattr(plain, name))}
    found: list[Advice] = []
    for change, candidate in _candidates(plain):
        advice = _rounded(change, candidate)
        tried = advice.applied_to(plain)
        known_layout = tried in [other.applied_to(plain) for other in found]
        if not known_layout and quiet(r for r in found_on(tried) if r not in known):
            found.append(advice)
        if len(found) == MOST:
            break
    return tuple(found)


def _candidates(design: Design) -> Iterator[tuple[str, Design]]:
    """Give changed designs with what changes: where the shaft angle is that of the helix angles, the layout;
    else a helix angle first, as the shaft angle is what was wanted."""
    ideal = ideal_layout(design)
    if ideal is None:
        return
    wanted = float(design.pair.shaft_angle)
    turned = abs(float(ideal.shaft_angle) - wanted) > HELIX_TOLERANCE
    if design.pair.offset == 0.0 != ideal.offset:
        yield from _with_helix(design, (0.0,))
    if turned:
        yield from _with_helix(design)
    elif design.pair.pinion_mounting is not None or design.pair.gear_mounting is not None:
        yield "mounting distances to those of the pitch point", design
    offset, angle = float(ideal.offset), float(ideal.shaft_angle)
    near = closing_of(replace(design, pair=Pair(max(offset, 0.0), wanted)))
    if not turned and near.offset >= 0.0:
        yield "offset", replace(design, pair=Pair(near.offset, wanted))
    near = closing_of(replace(design, pair=Pair(design.pair.offset, angle)))
    if not math.isnan(near.shaft_angle):
        yield "shaft angle", replace(design, pair=Pair(design.pair.offset, near.shaft_angle))
    if offset >= 0.0:
        yield "offset and shaft angle", replace(design, pair=Pair(offset, angle))


def _with_helix(design: Design, hands: tuple[float, ...] = (1.0, -1.0)) -> Iterator[tuple[str, Design]]:
    """Give designs with one helix angle changed, the gear's, the pinion's, each to the nearer of `hands`, as
    in `_fitted`."""
    for name in ("gear", "pinion"):
        fitting = [found for hand in hands if (found := _fitted(design, name, hand)) is not None]
        before = float(getattr(design, name).helix_angle)
        changes = [abs(float(getattr(found, name).helix_angle) - before) for found in fitting]
        if changes:
            yield _helix_of(name), fitting[int(np.argmin(changes))]


def _fitted(design: Design, name: str, hand: float) -> Design | None:
    """Find the design without backlash with that helix angle of the member `name` which fits the design's own
    shaft angle, the sum of the helix angles having the sign `hand`; 0: with which the axes intersect."""
    wanted, changed = float(design.pair.shaft_angle), design
    for _ in range(PASSES):
        ideal = ideal_layout(changed)
        if ideal is None:
            return None
        crossing = crossing_of(ideal.cone_angle, wanted) if hand else 0.0
        missing = hand * crossing - float(np.sum(ideal.helix_angle))
        helix = float(getattr(changed, name).helix_angle)
        if abs(missing) < NEAR:
            layout = (max(float(ideal.offset), 0.0), wanted) if hand else (0.0, float(ideal.shaft_angle))
            return replace(changed, pair=Pair(*layout))
        if not abs(helix + missing) < MOST_HELIX:
            return None
        changed = replace(changed, **{name: replace(getattr(changed, name), helix_angle=helix + missing)})
    return None


def _rounded(change: str, design: Design) -> Advice:
    """Make advice to take a design, in the digits in which it is printed."""
    angles = (design.pair.shaft_angle, design.pinion.helix_angle, design.gear.helix_angle)
    rounded = (math.radians(float(f"{math.degrees(angle):.{DIGITS}g}")) for angle in angles)
    return Advice(change, float(f"{design.pair.offset:.{DIGITS}g}"), *rounded)
