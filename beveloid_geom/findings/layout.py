"""Whether gears mesh where a design lays them out, and if not, why not.

Offset and shaft angle of a pair are not free. Pitch cones of half angles g_1, g_2 that roll on each
other lie against a common plane, in which their generators cross at an angle s,

    cos(d) = cos(g_1) cos(g_2) cos(s) - sin(g_1) sin(g_2),
    E = (r_1 cos(g_2) + r_2 cos(g_1)) sin(s) / sin(d),

and s is the sum of the working helix angles: where teeth run along each other the shaft angle d follows from
that sum. With the radii of the tips, or of tip and root, the same gives the offsets at which tips
just meet, or meet bottom lands.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FLANK_SIGN, Quantity
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design, Errors
from ..gear.fillet import root_radius
from ..gear.flank import tip_radius
from ..pair.closing import ClosedLayout, Closing, closing_of, zero_backlash_layout
from ..status import Status
from .path import reason_of
from .remarks import ERROR, WARNING, Remark, clearance_remarks, in_order, tooth_remarks

FLANKS = tuple(FLANK_SIGN)
OFFSET_TOLERANCE = 1.0 / 60.0
SHAFT_ANGLE_TOLERANCE = math.radians(0.01)
"""Differences (modules of the pinion, rad) beyond which a design does not count as closed."""
INTERFERENCE_TOLERANCE = 1.0 / 6000.0
"""Overlap (modules of the pinion) that rounded input explains."""
HELIX_TOLERANCE = math.radians(0.05)
"""Difference (rad) of the shaft angle from that of the gears without backlash beyond which the helix
angles are the cause: backlash of some tenths of a module changes it by less."""
UNLIKE = math.radians(0.5)
"""Difference (rad) of helix and cone angles from those of axes that intersect beyond which they are the
cause."""
ROUNDING = 1e-12
"""Difference from 1 of the cosine of that angle that rounding leaves where axes intersect."""
ENDS = 2
"""Positions of a path of which nothing but its status is asked."""


@dataclass(frozen=True)
class Reach:
    """Offsets (mm) at the design's shaft angle below which tips reach each other (`touching`) and
    a tip reaches the other's bottom land (`bottoming`), mid-faces against each other; `crossing`
    (rad): the angle at which the generators of the pitch cones cross. NaN where the cones have
    no common plane."""

    touching: float
    bottoming: float
    crossing: float


def crossing_of(cone_angles: Iterable[Quantity], shaft_angle: float) -> float:
    """Give the angle s (rad) at which generators of rolling cones cross, NaN without a common plane."""
    one, other = (float(angle) for angle in cone_angles)
    cosine = (math.cos(shaft_angle) + math.sin(one) * math.sin(other)) / (math.cos(one) * math.cos(other))
    if abs(cosine - 1.0) < ROUNDING:
        return 0.0
    return math.acos(cosine) if abs(cosine) <= 1.0 else math.nan


def reach_of(design: Design) -> Reach:
    """Find the offsets at which the gears of a single design reach each other, without errors."""
    pinion, gear = design.members
    shaft_angle = float(design.pair.shaft_angle)
    crossing = crossing_of((pinion.cone_angle, gear.cone_angle), shaft_angle)
    factor = math.sin(crossing) / math.sin(shaft_angle) if shaft_angle > 0.0 else math.nan

    def offset(pinion_radius: float, gear_radius: float) -> float:
        return factor * (
            pinion_radius * math.cos(gear.cone_angle) + gear_radius * math.cos(pinion.cone_angle)
        )

    tips = [float(tip_radius(member, 0.0)) for member in design.members]
    roots = [float(root_radius(member, 0.0)) for member in design.members]
    bottoming = max(offset(tips[0], roots[1]), offset(roots[0], tips[1]))
    return Reach(offset(*tips), bottoming, crossing)


def bare(design: Design) -> Design:
    """Give the design with unmodified flanks and without errors."""
    return replace(design.with_parabola(0.0, 0.0), errors=Errors())


def _paths(design: Design, flanks: Iterable[str]) -> list[ContactPath]:
    return [path_of_contact(design, flank, ENDS) for flank in flanks]


def meshes(design: Design) -> bool:
    """Tell whether the unmodified pair without errors has contact on both flanks."""
    return all(path.ends.status == Status.SOLVED for path in _paths(bare(design), FLANKS))


def closes(design: Design, closing: Closing) -> bool:
    """Tell whether both lines of action meet within the tolerances."""
    near = OFFSET_TOLERANCE * float(design.pinion.tool.normal_module)
    turned = abs(closing.shaft_angle_difference) <= SHAFT_ANGLE_TOLERANCE
    return turned and abs(closing.offset_difference) <= near


def layout_remarks(
    design: Design,
    closing: Closing | None = None,
    flanks: Iterable[str] = FLANKS,
    jam: str | None = None,
    meshing: bool | None = None,
) -> Iterator[Remark]:
    """Say why there is no contact on these flanks of a single design; why it cannot be assembled as mounted
    (`jam`), or else teeth that interfere in the layout; a layout that does not close. Where gears cannot
    mesh as laid out there is no pitch point for the other two to hold at. `meshing`: what `meshes` says,
    where that is known."""
    closing = closing_of(design) if closing is None else closing
    meshing = meshes(design) if meshing is None else meshing
    misfit = [] if meshing else list(_misfit(design, closing))
    lost = [path for path in _paths(design, flanks) if path.ends.status != Status.SOLVED]
    if misfit:
        if lost:
            yield Remark(ERROR, f"there is no contact on the {' and '.join(p.flank for p in lost)} flanks")
        yield from (Remark(ERROR, text) for text in misfit)
        return
    yield from (Remark(ERROR, str(reason_of(path))) for path in lost)
    backlash = closing.normal_backlash
    if jam:
        yield Remark(ERROR, jam)
    elif backlash < -INTERFERENCE_TOLERANCE * float(design.pinion.tool.normal_module):
        yield Remark(ERROR, f"the teeth interfere by {-backlash:.4f} mm along the normal")
    if not closes(design, closing):
        apart = f"the lines of action of right and left flanks are {closing.gap:.4g} mm apart"
        yield Remark(WARNING, f"the design does not close: {apart} where they should meet")


def _misfit(design: Design, closing: Closing) -> Iterator[str]:
    """Say why gears do not mesh as laid out: too far apart, too close, at another angle than their teeth."""
    reach, offset = reach_of(design), float(design.pair.offset)
    given = f"{math.degrees(design.pair.shaft_angle):.6g} deg"
    if offset == 0.0:
        yield from _intersecting_words(design, given)
        yield from closing.reasons
        return
    if offset > reach.touching:
        at = f"at a shaft angle of {given} their tips meet at an offset of {reach.touching:.5g} mm"
        yield f"the gears do not reach each other, by {offset - reach.touching:.4g} mm: {at}"
    elif offset < reach.bottoming:
        at = f"at a shaft angle of {given} tips meet bottom lands at an offset of {reach.bottoming:.5g} mm"
        yield f"the gears run into each other by {reach.bottoming - offset:.4g} mm: {at}"
    elif math.isnan(reach.crossing):
        angles = " and ".join(f"{math.degrees(member.cone_angle):.4g}" for member in design.members)
        yield f"cones of {angles} deg do not roll on each other at a shaft angle of {given}"
    ideal = ideal_layout(design)
    if ideal is not None and abs(float(ideal.shaft_angle - design.pair.shaft_angle)) > HELIX_TOLERANCE:
        yield _helix_words(design, ideal)
    yield from closing.reasons


def _intersecting_words(design: Design, given: str) -> Iterator[str]:
    """Say what helix angles and what shaft angle, `given` in words, axes that intersect ask for."""
    helix, cones = (
        np.array([float(getattr(member, name)) for member in design.members])
        for name in ("helix_angle", "cone_angle")
    )
    if abs(helix.sum()) > UNLIKE:
        angles = " and ".join(f"{angle:+.6g}" for angle in np.degrees(helix))
        yield f"axes that intersect need helix angles that nearly cancel, {angles} deg do not"
    if abs(abs(cones.sum()) - float(design.pair.shaft_angle)) > UNLIKE:
        angles = " and ".join(f"{angle:.4g}" for angle in np.degrees(cones))
        rule = "the shaft angle of axes that intersect is about the sum of the cone angles"
        yield f"{rule}: {angles} deg give {abs(math.degrees(cones.sum())):.4g} deg, not {given}"


def ideal_layout(design: Design) -> ClosedLayout | None:
    """Find the layout without backlash, None where there is none."""
    try:
        return zero_backlash_layout(design)
    except ValueError:
        return None


def _helix_words(design: Design, ideal: ClosedLayout) -> str:
    """Say what shaft angle the helix angles give, and what sum of them would give that of the design."""
    given = math.degrees(design.pair.shaft_angle)
    fitting = math.degrees(crossing_of(ideal.cone_angle, float(design.pair.shaft_angle)))
    angles = " and ".join(f"{math.degrees(member.helix_angle):+.6g}" for member in design.members)
    total = abs(math.degrees(np.sum(ideal.helix_angle)))
    text = (
        f"the shaft angle follows from the helix angles: {angles} deg, in work {total:.2f} deg together,"
        f" give {math.degrees(ideal.shaft_angle):.2f} deg"
    )
    wanted = f"{text}; for {given:.6g} deg they must make {fitting:.2f} deg together"
    return text if math.isnan(fitting) else wanted


def remarks_on(design: Design, closing: Closing | None = None, jam: str | None = None) -> tuple[Remark, ...]:
    """Find what is to be known of layout and teeth of a single design, what matters most first.

    Errors: no contact on a flank, and why; teeth that interfere. Warnings: the design does not close (by more
    than OFFSET_TOLERANCE or SHAFT_ANGLE_TOLERANCE), tips run into bottom lands, the tool's rounds
    overlap, an active flank is undercut, a tooth is pointed. Notes: undercut below the active flank,
    a thin tooth tip, a small tip clearance. Raises ValueError for arrays."""
    closing = closing_of(design) if closing is None else closing
    meshing = meshes(design)
    found = list(layout_remarks(design, closing, jam=jam, meshing=meshing))
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        found += tooth_remarks(name, member)
    if meshing:
        found += clearance_remarks(design)
    return in_order(found)
