"""A path of contact in words: why there is none, and what its numbers do not say."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from .certificate import Certificate, Verdict
from .closing import INTERFERENCE_TOLERANCE, OFFSET_TOLERANCE, closing_offset
from .conditioning import rounding_error
from .contact import Limit
from .first_contact import FirstStatus
from .flank import highest_parameter, root_parameter
from .inputs import Design
from .mounting import mounting_of
from .path import ContactPath, path_of_contact
from .solve import Status

ROUNDING_TOLERANCE = 1e-9
"""mm by which rounding may move a contact without a note."""
UNKNOWN = {
    FirstStatus.NO_CONTACT: "no tooth reaches the other member",
    FirstStatus.MEETS_BOTTOM: "a tip reaches the other member's bottom land",
    FirstStatus.UNDERCUT: "a member is undercut",
    FirstStatus.SOLVED: "the search missed it",
}
"""Why the first contact at a position is not known; SOLVED is one found, but not as near as the position."""


def reason_of(design: Design, path: ContactPath) -> str | None:
    """Why a path has no point on the flanks."""
    status = Status(int(path.ends.status))
    if status == Status.SOLVED:
        return None
    if status == Status.NO_COMMON_NORMAL or bool(np.isnan(mounting_of(design).gap)):
        return f"the {path.flank} flanks have no common normal in this layout: is the shaft angle right?"
    if status != Status.OFF_FLANK:
        words = status.name.lower().replace("_", " ")
        return f"the path of contact on the {path.flank} flanks could not be followed: {words}"
    text = f"the path of contact does not meet the {path.flank} flanks"
    middle = 0.5 * (root_parameter(design.pinion) + highest_parameter(design.pinion))
    beyond = path_of_contact(design, path.flank, l1=[float(middle)])
    where = [
        f"{axial[0]:+.4g} mm on the {member} (half face width {0.5 * float(teeth.face_width):g} mm)"
        for member, axial, teeth in (
            ("pinion", beyond.pinion_z, design.pinion),
            ("gear", beyond.gear_z, design.gear),
        )
        if math.isfinite(axial[0])
    ]
    return f"{text}: at mid-depth of the pinion it runs at z = {' and '.join(where)}" if where else text


def notes_of(design: Design, path: ContactPath, certificate: Certificate | None) -> tuple[str, ...]:
    """What to know about a path that lies on the flanks, a line each."""
    notes = []
    difference = closing_offset(design) - float(design.pair.offset)
    module = float(design.pinion.tool.normal_module)
    if abs(difference) > OFFSET_TOLERANCE * module:
        closes = f"the lines of action would meet at an offset of {difference:+.3g} mm from the design's"
        notes.append(f"the design does not close, {closes}: see `beveloid-geom check`")
    backlash = float(mounting_of(design).normal_backlash)
    if backlash < -INTERFERENCE_TOLERANCE * module:
        notes.append(f"the normal backlash is {backlash:.4f} mm: the other flanks interfere")
    if path.ends.pieces > 1:
        pieces = f"the path lies on the flanks in {int(path.ends.pieces)} pieces"
        notes.append(f"{pieces}: this is the one that covers most roll, the contact ratio is its own")
    if 0.0 < path.ends.contact_ratio < 1.0:
        notes.append("the contact ratio is below 1: one tooth pair leaves before the next one enters")
    for values, words in (
        (
            path.pinion_roll,
            (
                "the roll turns back along the path: the flanks are tangent twice at some rolls,"
                " and the contact ratio is that of all rolls it reaches"
            ),
        ),
        (path.l1, "l1 turns back along the path: at some l1 the pinion's flank has two contacts"),
    ):
        steps = np.diff(values)
        if steps.size and steps.min() < 0.0 < steps.max():
            notes.append(words)
    if path.normal.size and path.normal[:, 0].min() < 0.0 < path.normal[:, 0].max():
        where = "at one place of the path the common normal is square to the common perpendicular (n_x = 0)"
        notes.append(f"{where}: small errors of mounting move the contact far there")
    moved = rounding_error(design, path).max(initial=0.0)
    if moved > ROUNDING_TOLERANCE:
        words = f"rounding of the inputs alone moves the contact by about {moved:.1g} mm"
        notes.append(f"{words}, errors of mounting far more")
    missing = int(np.count_nonzero(path.status != Status.SOLVED))
    if missing:
        notes.append(f"{missing} of {path.status.size} positions are not solved")
    return (*notes, *(_certificate_notes(certificate) if certificate is not None else ()))


def _certificate_notes(certificate: Certificate) -> Iterator[str]:
    """Where the tangency of the flanks is not the contact of the teeth."""
    verdict, all_positions = certificate.verdict, certificate.verdict.size
    said = {
        Verdict.NEXT_PAIR: "the flanks of a neighbouring tooth pair touch earlier",
        Verdict.EDGE_CONTACT: f"an edge touches earlier ({_edges_of(certificate)})",
        Verdict.INTERFERENCE: "the flanks cut into each other beside their tangency, or a tip into a fillet",
    }
    for code, words in said.items():
        found = verdict == code
        if found.any():
            depth = -1e3 * float(certificate.separation[found].min())
            count = f"at {np.count_nonzero(found)} of {all_positions} positions"
            yield f"{count} {words}, by up to {depth:.3g} um"
    if np.isin(verdict, tuple(said)).any():
        yield "the contact ratio, Eq. 16, is not an operating one: see `beveloid-geom operation`"
    unknown = certificate.first.status[verdict == Verdict.NOT_SOLVED]
    for status in np.unique(unknown):
        name = FirstStatus(int(status))
        words = UNKNOWN.get(name, name.name.lower().replace("_", " "))
        count = f"at {np.count_nonzero(unknown == status)} of {all_positions} positions"
        yield f"{count} it is not known whether something touches earlier: {words}"


def _edges_of(certificate: Certificate) -> str:
    """Names of the edges that touch earlier."""
    codes = certificate.first.limit[certificate.verdict == Verdict.EDGE_CONTACT]
    return ", ".join(str(Limit(int(code))) for code in np.unique(codes[codes >= 0]))
