"""Remarks on a design in order of importance, and the remarks on its teeth.

Remarks on the layout are in `layout`, remarks on a path of contact in `path`, and remarks on random mountings
in `report.tolerance`. Commands and pages sort their remarks with `in_order`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from ..contact.path import path_ends
from ..design.ends import end_names
from ..design.member import Member
from ..design.model import Design
from ..gear.fillet import root_radius
from ..gear.flank import tip_thickness
from ..gear.flank_limits import tip_radius
from ..gear.tooth_side import undercut_edge
from ..gear.undercut import CURE, cut_fault, pointed_part, undercut_margin, undercut_of, undercut_text
from ..pair.frames import layout_of, member_frame, to_fixed
from ..pair.mounting import mounting_of
from ..pair.tips import depth_below_tips_as_mounted
from ..status import Limit

ERROR, UNKNOWN, WARNING, NOTE = "error", "unknown", "warning", "note"
LEVELS = (ERROR, UNKNOWN, WARNING, NOTE)
"""Levels of remarks, the most important first. An error: the pair does not work. Unknown: a calculation
failed, so that the pair cannot be judged. A warning: the pair may fail in use. A note: information."""
LEAST_TIP_THICKNESS_MODULES = 0.1
"""Tip thickness below which a tip may chip, modules: a warning."""


class Remark(NamedTuple):
    """Remark on a design; `level` is one of LEVELS."""

    level: str
    text: str


def in_order(remarks: Iterable[Remark]) -> tuple[Remark, ...]:
    """Return each remark once, sorted by level; remarks of one level keep their order."""
    return tuple(sorted(dict.fromkeys(remarks), key=lambda remark: LEVELS.index(remark.level)))


def quiet(remarks: Iterable[Remark]) -> bool:
    """Return whether all remarks are notes."""
    return all(remark.level == NOTE for remark in remarks)


def remarks_data(remarks: Iterable[Remark]) -> dict[str, list[str]]:
    """Return the entries of JSON: texts under 'errors', 'unknowns', 'warnings' and 'notes'."""
    texts: dict[str, list[str]] = {f"{level}s": [] for level in LEVELS}
    for remark in remarks:
        texts[f"{remark.level}s"].append(remark.text)
    return texts


def tip_clearances(design: Design) -> FloatArray:
    """Return the least distances of the tip cones of pinion and gear from the root cone of the mate.

    Parameters
    ----------
    design : Design
        Single design; its errors are ignored.

    Returns
    -------
    ndarray
        Distances (2,), mm, accurate to about 0.001 mm. NaN if the faces are not opposite each other or the
        mounting is unknown.
    """
    layout, distance = layout_of(design, with_errors=False), mounting_of(design).distance
    frames = [member_frame(layout, j, 0.0, distance[j]) for j in (0, 1)]
    turn, share = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721)[:, None], np.linspace(-0.5, 0.5, 65)
    least = np.full(2, np.nan)
    for j, (member, mate) in enumerate((design.members, design.members[::-1])):
        z = share * float(member.face_width)
        radius = tip_radius(member, z)
        tip = np.stack(np.broadcast_arrays(radius * np.cos(turn), radius * np.sin(turn), z), axis=-1)
        rotation, origin = frames[1 - j]
        x, y, along = np.moveaxis((to_fixed(frames[j], tip) - origin) @ rotation, -1, 0)
        gap = (np.hypot(x, y) - root_radius(mate, along)) * np.cos(float(mate.cone_angle))
        opposite = np.abs(along) <= 0.5 * float(mate.face_width)
        least[j] = gap[opposite].min() if opposite.any() else np.nan
    return least


def clearance_remarks(design: Design) -> Iterator[Remark]:
    """Yield remarks on tips that overlap the bottom lands of the mate or have a small clearance."""
    # Tip clearance that a mounting error or a deflection may remove, modules.
    small_clearance = 0.1
    for name, mate, member, clearance in zip(
        ("pinion", "gear"), ("gear", "pinion"), design.members, tip_clearances(design), strict=True
    ):
        module = float(member.tool.normal_module)
        if clearance <= 0.0:
            text = f"the tips of the {name} overlap the bottom lands of the {mate} by {-clearance:.3g} mm"
            yield Remark(WARNING, text)
        elif clearance < small_clearance * module:
            size = f"{clearance:.3g} mm, {clearance / module:.2g} modules"
            yield Remark(NOTE, f"the tip clearance of the {name} is small: {size}")


def depth_remarks(design: Design) -> Iterator[Remark]:
    """Yield remarks on tips that reach below the active flanks of the mate.

    `design` is a single pair without modifications and errors. On parallel axes, in line contact, the tips
    meet the fillet: a warning. In point contact the flanks are separated away from the path, so that such
    tips usually touch nothing: a note. The certificate of the path shows whether they touch."""
    level = NOTE if design.pair.shaft_angle > 0.0 else WARNING
    margin = np.minimum(*(depth_below_tips_as_mounted(design, flank) for flank in FLANK_SIGN))
    for mate, member, depth in zip(("gear", "pinion"), ("pinion", "gear"), -margin, strict=True):
        if 0.0 < depth < math.inf:
            below = f"up to {depth:.3g} mm below the active flank of the {member} (form diameter)"
            yield Remark(level, f"the tips of the {mate} reach {below}")


def _undercut_remarks(name: str, member: Member) -> Iterator[Remark]:
    """Yield warnings on undercut flanks and on fillets that cannot be cut."""
    for flank in ("right", "left"):
        text = f"the {flank} flank of the {name} is undercut"
        try:
            undercut = undercut_of(member, flank)
        except ValueError as error:
            if flank == "right":
                yield Remark(WARNING, f"the fillets of the {name} cannot be cut: {error}")
            if not float(undercut_margin(member, flank)) > 0.0:
                yield Remark(WARNING, f"{text}: {CURE}")
            continue
        if undercut.undercut:
            yield Remark(WARNING, f"{text} {undercut_text(undercut)}: {CURE}")


def undercut_path_remarks(design: Design) -> Iterator[Remark]:
    """Yield notes on whether undercut ends the paths of contact of a single design."""
    names = ("pinion", "gear")
    edged = [
        (flank, j) for flank in ("right", "left") for j in (0, 1) if undercut_edge(design.members[j], flank)
    ]
    ends = {flank: path_ends(design, flank).limit.tolist() for flank, _ in edged}
    for flank, j in edged:
        if (Limit.PINION_ROOT, Limit.GEAR_ROOT)[j] in ends[flank]:
            text = f"the path of contact of the {flank} flanks ends at the undercut of the {names[j]}"
        elif max(ends[flank]) >= 0:
            reached = f"ends before it reaches the undercut of the {names[j]}"
            text = f"the path of contact of the {flank} flanks {reached}"
        else:
            continue
        yield Remark(NOTE, text)


def tooth_remarks(name: str, member: Member) -> Iterator[Remark]:
    """Yield warnings on flanks that cannot be cut, undercut, pointed teeth and tips thinner than
    LEAST_TIP_THICKNESS_MODULES of the member `name`, and notes on other thin tips."""
    # Tip thickness below which a case-hardened tip may be hardened through, modules: a note.
    thin_tip = 0.2
    if fault := cut_fault(member):
        yield Remark(WARNING, f"the flanks of the {name} cannot be cut: {fault}")
        return
    yield from _undercut_remarks(name, member)
    module, pointed = float(member.tool.normal_module), pointed_part(member)
    back, front = end_names(member)
    half = 0.5 * float(member.face_width)
    if pointed == (-half, half):
        text = f"the tooth of the {name} is pointed along the complete face"
        yield Remark(WARNING, f"{text}: reduce the profile shift or the addendum")
        return
    for end, z, part in ((front, 0.5, "from {0:.4g} mm on"), (back, -0.5, "up to {1:.4g} mm")):
        thickness = float(tip_thickness(member, z * float(member.face_width)))
        if math.isnan(thickness):
            yield Remark(WARNING, f"the flanks of the {name} do not reach its tip cone at the {end}")
        elif thickness <= 0.0:
            text = f"the tooth of the {name} is pointed at the {end}, {part.format(*pointed)}"
            yield Remark(WARNING, f"{text}: reduce the profile shift or the addendum")
        elif thickness < thin_tip * module:
            at = f"{thickness:.3g} mm, {thickness / module:.2g} modules, at the {end}"
            level = NOTE if thickness >= LEAST_TIP_THICKNESS_MODULES * module else WARNING
            yield Remark(level, f"the tooth tip of the {name} is thin: {at}")
