"""Remarks on the layout of a design: whether the gears mesh where it places them, and if not, why not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from ..arrays import FLANKS
from ..contact.path import ContactPath, path_of_contact
from ..design.ends import limit_words
from ..design.model import Design
from ..pair.frames import layout_of
from ..pair.zero_backlash import LayoutDeviation, ZeroBacklashLayout, layout_deviation, zero_backlash_layout
from ..status import NotComputed, Status
from .diagnostics import (
    ERROR,
    NOTE,
    UNKNOWN,
    WARNING,
    Remark,
    clearance_remarks,
    depth_remarks,
    in_order,
    tooth_remarks,
    undercut_path_remarks,
)
from .path import reason_of
from .reach import reach_of, rolling_generator_angle
from .units import unit_remarks

INTERFERENCE_TOLERANCE_MODULES = 1.0 / 6000.0
"""Overlap that is attributed to rounded input, modules of the pinion."""
HELIX_TOLERANCE_RAD = math.radians(0.05)
"""Difference of the shaft angle from that of the layout without backlash, rad, above which the helix angles
are reported as the cause. A backlash of some tenths of a module changes the shaft angle by less."""


def _paths(design: Design, flanks: Iterable[str]) -> list[ContactPath]:
    """Return paths of two positions."""
    return [path_of_contact(design, flank, 2) for flank in flanks]


def meshes(design: Design) -> bool:
    """Return whether the unmodified pair without errors has contact on both flanks."""
    return all(path.ends.status == Status.SOLVED for path in _paths(design.bare(), FLANKS))


def lines_meet(design: Design, deviation: LayoutDeviation) -> bool:
    """Return whether the lines of action of right and left flanks meet within the tolerances."""
    # Difference of the offset from that of the layout in which the lines of action meet, modules of the
    # pinion. The distance of the lines is reported above this value or above the tolerance of the angle.
    offset_tolerance = 1.0 / 60.0
    tolerance = offset_tolerance * float(design.pinion.tool.normal_module)
    # Difference of the shaft angle from that of the layout in which the lines of action meet, rad.
    shaft_angle_tolerance_rad = math.radians(0.01)
    angle_fits = abs(deviation.shaft_angle_difference) <= shaft_angle_tolerance_rad
    return angle_fits and abs(deviation.offset_difference) <= tolerance


def layout_remarks(
    design: Design,
    deviation: LayoutDeviation | None = None,
    flanks: Iterable[str] = FLANKS,
    jam: str | None = None,
    meshing: bool | None = None,
) -> Iterator[Remark]:
    """Yield remarks on the layout of a single design.

    Errors state why there is no contact, why the pair cannot be assembled as mounted, or by how much the
    teeth interfere. Paths of right and left flanks that are displaced along the face are a note, or a warning
    if one of them leaves the face. Without contact there is no pitch point, so that backlash and paths are
    not judged.

    Parameters
    ----------
    design : Design
    deviation : LayoutDeviation, optional
        Result of `layout_deviation`, if it is known.
    flanks : iterable of str
        Flanks whose contact is required.
    jam : str, optional
        Reason why the pair cannot be assembled.
    meshing : bool, optional
        Result of `meshes`, if it is known.

    Yields
    ------
    Remark
    """
    deviation = layout_deviation(design) if deviation is None else deviation
    meshing = meshes(design) if meshing is None else meshing
    misfit = [] if meshing else list(_misfit(design, deviation))
    lost = [path for path in _paths(design, flanks) if path.ends.status != Status.SOLVED]
    if misfit:
        if lost:
            yield Remark(ERROR, f"there is no contact on the {' and '.join(p.flank for p in lost)} flanks")
        yield from (Remark(ERROR, text) for text in misfit)
        return
    for path in lost:
        reason = reason_of(path)
        yield Remark(UNKNOWN if isinstance(reason, NotComputed) else ERROR, str(reason))
    backlash = deviation.normal_backlash
    if jam:
        yield Remark(ERROR, jam)
    elif backlash < -INTERFERENCE_TOLERANCE_MODULES * float(design.pinion.tool.normal_module):
        yield Remark(ERROR, f"the teeth interfere by {-backlash:.4f} mm along the normal")
    if meshing and not lines_meet(design, deviation):
        yield _displacement_remark(design.bare(), deviation.gap)


def _displacement_remark(design: Design, gap: float) -> Remark:
    """Return the remark on lines of action that pass each other at a distance `gap`, mm.

    The common perpendicular of the lines is perpendicular to both normals and therefore along the tooth
    trace in the working pitch plane. The paths are displaced along the teeth; each flank pair meshes without
    transmission error."""
    paths = _paths(design, FLANKS)
    trace = np.cross(*(path.normal[0] for path in paths))
    trace *= gap / np.linalg.norm(trace)
    layout = layout_of(design)
    axes = np.array([(0.0, 0.0, 1.0), (0.0, float(layout.sin_angle), float(layout.cos_angle))])
    first, second = np.abs(axes @ trace)
    text = (
        f"the paths of contact of right and left flanks are displaced along the face by {first:.4g} mm on the"
        f" pinion and {second:.4g} mm on the gear: the lines of action pass each other at {gap:.4g} mm"
    )
    ends = [(path.flank, end) for path in paths for end in (path.ends.enter, path.ends.leave)]
    past = [
        f"{flank} flanks the {limit_words(design, end)}"
        for flank, end in ends
        if end is not None and end.limit in ("toe", "heel")
    ]
    if not past:
        return Remark(NOTE, f"{text}; this does not disturb the mesh of unmodified flanks")
    return Remark(WARNING, f"{text}, and a path leaves the face: {', '.join(past)}")


def _misfit(design: Design, deviation: LayoutDeviation) -> Iterator[str]:
    """Yield reasons for missing contact: gears too far apart, too close, or a shaft angle that does not fit
    the teeth."""
    reach, offset = reach_of(design), float(design.pair.offset)
    given = f"{math.degrees(design.pair.shaft_angle):.6g} deg"
    if offset == 0.0:
        yield from _intersecting_words(design, given)
        yield from deviation.reasons
        return
    if offset > reach.touching:
        at = f"at a shaft angle of {given} their tips meet at an offset of {reach.touching:.5g} mm"
        yield f"the gears are too far apart by {offset - reach.touching:.4g} mm: {at}"
    elif offset < reach.bottoming:
        at = f"at a shaft angle of {given} tips meet bottom lands at an offset of {reach.bottoming:.5g} mm"
        yield f"the gears overlap by {reach.bottoming - offset:.4g} mm: {at}"
    elif math.isnan(reach.rolling_angle):
        angles = " and ".join(f"{math.degrees(member.cone_angle):.4g}" for member in design.members)
        yield f"cones of {angles} deg do not roll on each other at a shaft angle of {given}"
    ideal = ideal_layout(design)
    if ideal is not None and abs(float(ideal.shaft_angle - design.pair.shaft_angle)) > HELIX_TOLERANCE_RAD:
        yield _helix_words(design, ideal)
    yield from deviation.reasons


def _intersecting_words(design: Design, given: str) -> Iterator[str]:
    """Yield the requirements of intersecting axes on helix angles and shaft angle; `given` is the shaft angle
    as text."""
    # Difference of helix and cone angles from those of intersecting axes, rad, above which they are
    # reported as the cause.
    intersecting_angle_tolerance = math.radians(0.5)
    helix, cones = (
        np.array([float(getattr(member, name)) for member in design.members])
        for name in ("helix_angle", "cone_angle")
    )
    if abs(helix.sum()) > intersecting_angle_tolerance:
        angles = " and ".join(f"{angle:+.6g}" for angle in np.degrees(helix))
        yield f"intersecting axes need helix angles that nearly cancel, {angles} deg do not"
    if abs(abs(cones.sum()) - float(design.pair.shaft_angle)) > intersecting_angle_tolerance:
        angles = " and ".join(f"{angle:.4g}" for angle in np.degrees(cones))
        rule = "the shaft angle of intersecting axes is about the sum of the cone angles"
        yield f"{rule}: {angles} deg give {abs(math.degrees(cones.sum())):.4g} deg, not {given}"


def ideal_layout(design: Design) -> ZeroBacklashLayout | None:
    """Return the layout without backlash, None if there is none."""
    try:
        return zero_backlash_layout(design)
    except ValueError:
        return None


def _helix_words(design: Design, ideal: ZeroBacklashLayout) -> str:
    """Return the shaft angle that fits the helix angles, and the sum of helix angles that fits the shaft
    angle."""
    given = math.degrees(design.pair.shaft_angle)
    fitting = math.degrees(rolling_generator_angle(ideal.cone_angle, float(design.pair.shaft_angle)))
    angles = " and ".join(f"{math.degrees(member.helix_angle):+.6g}" for member in design.members)
    total = abs(math.degrees(np.sum(ideal.helix_angle)))
    text = (
        f"for contact on the faces the shaft angle follows from the helix angles: {angles} deg, working helix"
        f" angles {total:.2f} deg in total, give {math.degrees(ideal.shaft_angle):.2f} deg"
    )
    required = f"{text}; for {given:.6g} deg their sum must be {fitting:.2f} deg"
    return text if math.isnan(fitting) else required


def remarks_on(
    design: Design, deviation: LayoutDeviation | None = None, jam: str | None = None
) -> tuple[Remark, ...]:
    """Return remarks on layout and teeth of a single design, the most important first.

    Errors: no contact on a flank, with the reason; teeth that interfere. Unknown: a path that could not be
    computed. Warnings: lengths that are probably in inches, displaced paths of right and left flanks that
    leave the face, tips that run into bottom lands, overlapping tip rounds of the tool, undercut, pointed
    teeth, tips thinner than LEAST_TIP_THICKNESS_MODULES, on parallel axes tips below the mate's active
    flank. Notes: whether undercut ends a path of contact, displaced paths that stay on the face, on other
    axes tips below the mate's active flank, thin tips, a small tip clearance. Raises ValueError for arrays.
    """
    deviation = layout_deviation(design) if deviation is None else deviation
    meshing = meshes(design)
    remarks = [*layout_remarks(design, deviation, jam=jam, meshing=meshing), *unit_remarks(design)]
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        remarks += tooth_remarks(name, member)
    remarks += undercut_path_remarks(design)
    if meshing:
        remarks += [*clearance_remarks(design), *depth_remarks(design.bare())]
    return in_order(remarks)
