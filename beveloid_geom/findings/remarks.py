"""What is to be known about a design, what matters most first; and what there is to say of its teeth.

Remarks on the layout are in `layout`, those on a path of contact in `path`, those on mountings drawn at
random in `report.tolerance`. Every command and page that has them puts them in order with `in_order`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..design.model import Design, Member
from ..gear.fillet import root_radius
from ..gear.flank import root_parameter, tip_radius, tip_thickness, undercut_margin
from ..gear.undercut import CURE, cut_fault, pointed_part, undercut_of, words_of
from ..pair.frames import layout_of, member_frame, to_fixed
from ..pair.mounting import mounting_of

ERROR, WARNING, NOTE = "error", "warning", "note"
LEVELS = (ERROR, WARNING, NOTE)
"""An error: the pair does not work at all; a warning: it may fail in use; a note: good to know."""
THIN_TIP = 0.2
"""Tip thickness in modules below which a tooth is apt to be hardened through or to chip."""
SMALL_CLEARANCE = 0.1
"""Tip clearance in modules below which a mounting error or a deflection may use it up."""


class Remark(NamedTuple):
    """What is to be known about a design: `level` is one of LEVELS."""

    level: str
    text: str


def in_order(remarks: Iterable[Remark]) -> tuple[Remark, ...]:
    """Give each remark once, by level; those of one level in the order in which they came."""
    return tuple(sorted(dict.fromkeys(remarks), key=lambda remark: LEVELS.index(remark.level)))


def quiet(remarks: Iterable[Remark]) -> bool:
    """Tell whether there is neither error nor warning."""
    return all(remark.level == NOTE for remark in remarks)


def remarks_data(remarks: Iterable[Remark]) -> dict[str, list[str]]:
    """Give entries of JSON: texts under 'errors', 'warnings' and 'notes'."""
    found: dict[str, list[str]] = {f"{level}s": [] for level in LEVELS}
    for remark in remarks:
        found[f"{remark.level}s"].append(remark.text)
    return found


def tip_clearances(design: Design) -> FloatArray:
    """Find the least distances (2,), mm, of the tip cones of pinion and gear from the root cone of the
    other member, of a single design as mounted, without errors; to about 0.001 mm. NaN where the
    faces do not stand beside each other or the mounting is not known."""
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
        beside = np.abs(along) <= 0.5 * float(mate.face_width)
        least[j] = gap[beside].min() if beside.any() else np.nan
    return least


def clearance_remarks(design: Design) -> Iterator[Remark]:
    """Find tips that run into bottom lands, or nearly."""
    for name, mate, member, clearance in zip(
        ("pinion", "gear"), ("gear", "pinion"), design.members, tip_clearances(design), strict=True
    ):
        module = float(member.tool.normal_module)
        if clearance <= 0.0:
            text = f"the tips of the {name} run {-clearance:.3g} mm into the bottom lands of the {mate}"
            yield Remark(WARNING, text)
        elif clearance < SMALL_CLEARANCE * module:
            size = f"{clearance:.3g} mm, {clearance / module:.2g} modules"
            yield Remark(NOTE, f"the tip clearance of the {name} is small: {size}")


def _undercut_remarks(name: str, member: Member) -> Iterator[Remark]:
    for flank in ("right", "left"):
        text = f"the {flank} flank of the {name} is undercut"
        try:
            found = undercut_of(member, flank)
        except ValueError as error:
            if flank == "right":
                yield Remark(WARNING, f"the fillets of the {name} cannot be cut: {error}")
            if not float(undercut_margin(member, flank)) > 0.0:
                yield Remark(WARNING, f"{text}: {CURE}")
            continue
        if found.undercut:
            active = not np.all(found.start <= float(root_parameter(member)))
            level, where = (WARNING, "") if active else (NOTE, " below its active part")
            yield Remark(level, f"{text}{where} {words_of(found)}: {CURE}")


def tooth_remarks(name: str, member: Member) -> Iterator[Remark]:
    """Find flanks that cannot be cut or are undercut, pointed teeth and thin tips of the member `name`."""
    if fault := cut_fault(member):
        yield Remark(WARNING, f"the flanks of the {name} cannot be cut: {fault}")
        return
    yield from _undercut_remarks(name, member)
    module, pointed = float(member.tool.normal_module), pointed_part(member)
    for end, z, part in (("heel", 0.5, "from {0:.4g} mm on"), ("toe", -0.5, "up to {1:.4g} mm")):
        thickness = float(tip_thickness(member, z * float(member.face_width)))
        if math.isnan(thickness):
            yield Remark(WARNING, f"the flanks of the {name} do not reach its tip cone at the {end}")
        elif thickness <= 0.0:
            text = f"the tooth of the {name} is pointed at the {end}, {part.format(*pointed)}"
            yield Remark(WARNING, f"{text}: take less profile shift or a lower addendum")
        elif thickness < THIN_TIP * module:
            at = f"{thickness:.3g} mm, {thickness / module:.2g} modules, at the {end}"
            yield Remark(NOTE, f"the tooth tip of the {name} is thin: {at}")
