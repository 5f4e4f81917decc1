"""A path of contact in words: why there is none, how easily it is lost, and what its numbers do not say."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..analysis.pressure import WHOLE, PathPressure
from ..analysis.sensitivity import Sensitivity, path_sensitivity
from ..analysis.tolerance import USUAL_AT
from ..arrays import FloatArray
from ..contact.parallel.lines import touches_along_lines
from ..contact.path import ContactPath, path_of_contact
from ..contact.rounding import rounding_error
from ..design.model import Design, ErrorsAt
from ..gear.fillet import tool_round
from ..gear.flank import highest_parameter, root_parameter
from ..operation.certificate import Certificate
from ..pair.errors import ANGLES, mounted
from ..pair.mounting import mounting_of
from ..status import EllipseStatus, FirstStatus, Limit, Status, Verdict
from .remarks import NOTE, WARNING, Remark

SENSITIVE = ((0.25, WARNING), (0.1, NOTE))
"""Shift of a path under one usual tolerance, over the size of the flank in the direction of the shift, from
which it is said. A path in the middle of the flank leaves it at one half; half of that is a warning: the
other errors, deflection and the length of the path take the rest."""
ALONG_LINES = "they touch along lines, and an error of the shaft angle puts the contact on an edge"
STILL = 1e-12
"""Step along a path, mm or rad, up to which a quantity stands still."""
ROUNDING_TOLERANCE = 1e-9
"""mm by which rounding may move a contact without a note."""
UNKNOWN = {
    FirstStatus.NO_CONTACT: "no tooth reaches the other member",
    FirstStatus.MEETS_BOTTOM: "a tip reaches the other member's bottom land",
    FirstStatus.UNDERCUT: "a member is undercut",
    FirstStatus.OUT_OF_STEP: "the teeth are too far out of step to tell which of them meet",
    FirstStatus.UNDEFINED: "the inputs leave nothing to search",
    FirstStatus.NOT_CONVERGED: "the search did not converge",
    FirstStatus.SOLVED: "the search missed it",
}
"""Why the first contact at a position is not known; SOLVED is one found, but not as near as the position."""


def reason_of(path: ContactPath) -> str | None:
    """Say why a path has no point on the flanks."""
    design = path.design
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


def first_contact_fault(design: Design) -> str | None:
    """Say why first contacts cannot be found: a tool without a round that fits has no fillets to offer."""
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        try:
            tool_round(member.tool, "right")
        except ValueError as error:
            return f"{name}: {error}"
    return None


def path_remarks(path: ContactPath) -> Iterator[Remark]:
    """Find what to know about a path on the flanks of a single design: how easily contact is lost, what its
    numbers do not say. Without such a path nothing: `reason_of` says why."""
    if path.ends.status != Status.SOLVED:
        return
    lines = bool(touches_along_lines(path.design, path.flank))
    found = [(NOTE, ALONG_LINES)] if lines else [*_sensitivity_remarks(path), *_loss_remarks(path)]
    for level, text in (*found, *_path_remarks(path)):
        yield Remark(level, f"{path.flank} flanks: {text}")


def certificate_remarks(path: ContactPath, certificate: Certificate) -> Iterator[Remark]:
    """Say where on a path something else touches earlier."""
    for level, text in _certificate_remarks(certificate):
        yield Remark(level, f"{path.flank} flanks: {text}")


def usual_shifts(found: Sensitivity, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give how far two errors of these `sizes` (2), the first two of `found`, move a path along the face and
    square to itself (..., place, member, error), mm."""
    face, square = (sizes * np.abs(rates[..., :2]) for rates in (found.face_shift_by, found.square_shift_by))
    return face, square


def usual_sizes(at: ErrorsAt = "perpendicular") -> FloatArray:
    """Give the usual tolerances of the first two errors `at` common perpendicular or mesh, mm and rad."""
    return np.asarray(USUAL_AT[at].values()[:2])


def shares_of_flank(design: Design, found: Sensitivity, sizes: FloatArray) -> FloatArray:
    """Give the same over the size of the flank in the direction of the shift, of the design's batch shape."""
    face, square = usual_shifts(found, sizes)
    depths = [highest_parameter(member) - root_parameter(member) for member in design.members]
    both = [member.face_width for member in design.members], depths
    width, depth = (np.stack(np.broadcast_arrays(*size), axis=-1)[..., None, :, None] for size in both)
    # The flank, face by depth, as wide as it is square to the path: the cosine is that of path and depth.
    cosine = np.divide(square, face, out=np.ones_like(face), where=face > 0.0)
    return np.asarray(square / (width * cosine + depth * np.sqrt(np.maximum(1.0 - cosine**2, 0.0))))


def _sensitivity_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Find how far usual tolerances of offset and shaft angle, or of centre distance and the angle in plane,
    move the path, where that is far."""
    design, at = path.design, path.design.errors_at
    found, sizes = path_sensitivity(design, path.flank, at), usual_sizes(at)
    what = {"perpendicular": ("offset", "shaft angle"), "mesh": ("centre distance", "angle in plane")}[at]
    share, (face, square) = shares_of_flank(design, found, sizes), usual_shifts(found, sizes)
    if np.isnan(share).all():
        return
    worst = np.unravel_index(np.nanargmax(share), share.shape)
    level = next((level for least, level in SENSITIVE if share[worst] >= least), None)
    if level is None:
        return
    place, member, _ = worst
    lengthwise = 2.0 * square[worst] > face[worst]
    where = "along its face" if lengthwise else "square to itself"
    offset, angle = (face if lengthwise else square)[place, member]
    width = float(design.members[member].face_width)
    yield (
        level,
        f"sensitive to errors, as flanks close to line contact are: {math.degrees(sizes[1]):g} deg of"
        f" {what[1]} shifts the path on the {('pinion', 'gear')[member]} by {angle:.3g} mm {where},"
        f" {sizes[0]:g} mm of {what[0]} by {offset:.3g} mm; the face is {width:g} mm wide",
    )


def _loss_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Find single errors of the size of a usual tolerance under which no contact is left."""
    design, usual = path.design, USUAL_AT[path.design.errors_at]
    size, names = usual.values(), usual.names
    errors = np.concatenate((np.diag(size), np.diag(-size)))
    if design.pair.shaft_angle > 0.0:
        errors = errors[design.pair.shaft_angle + design.errors.shaft_angle + errors[:, 1] > 0.0]
    status = path_of_contact(mounted(design, errors, names), path.flank, 2).ends.status
    words = []
    for row in errors[np.isin(status, (Status.OFF_FLANK, Status.NO_COMMON_NORMAL))]:
        column = int(np.flatnonzero(row)[0])
        name, value = names[column], float(row[column])
        size_words = f"{math.degrees(value):+g} deg" if name in ANGLES else f"{value:+g} mm"
        words.append(f"{name.replace('_', ' ')} {size_words}")
    if words:
        yield WARNING, f"contact is lost within usual tolerances, at an error of {' or '.join(words)}"


def _path_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Say what a contact ratio and a path do not say."""
    missing = int(np.count_nonzero(path.status != Status.SOLVED))
    if missing:
        yield WARNING, f"{missing} of {path.status.size} positions are not solved"
    if path.ends.contact_ratio < 1.0:
        yield WARNING, "the contact ratio is below 1: one tooth pair leaves before the next one enters"
    if path.ends.pieces > 1:
        pieces = f"the path lies on the flanks in {int(path.ends.pieces)} pieces"
        yield NOTE, f"{pieces}: this is the one that covers most roll, the contact ratio is its own"
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
        if steps.size and steps.min() < -STILL and steps.max() > STILL:
            yield NOTE, words
    if path.normal.size and path.normal[:, 0].min() < 0.0 < path.normal[:, 0].max():
        where = "at one place of the path the common normal is square to the common perpendicular (n_x = 0)"
        yield NOTE, f"{where}: small errors of mounting move the contact far there"
    moved = rounding_error(path).max(initial=0.0)
    if moved > ROUNDING_TOLERANCE:
        words = f"rounding of the inputs alone moves the contact by about {moved:.1g} mm"
        yield NOTE, f"{words}, errors of mounting far more"


def _certificate_remarks(certificate: Certificate) -> Iterator[tuple[str, str]]:
    """Say where the tangency of the flanks is not the contact of the teeth."""
    verdict, all_positions = certificate.verdict, certificate.verdict.size
    codes = certificate.first.limit[verdict == Verdict.EDGE_CONTACT]
    edges = ", ".join(str(Limit(int(code))) for code in np.unique(codes[codes >= 0]))
    cut = "the flanks cut into each other beside their tangency, or a tip into a fillet"
    said = {
        Verdict.INTERFERENCE: (WARNING, cut),
        Verdict.EDGE_CONTACT: (WARNING, f"an edge touches earlier ({edges})"),
        Verdict.NEXT_PAIR: (NOTE, "the flanks of a neighbouring tooth pair touch earlier"),
    }
    for code, (level, words) in said.items():
        found = verdict == code
        if found.any():
            depth = -1e3 * float(certificate.separation[found].min())
            count = f"at {np.count_nonzero(found)} of {all_positions} positions"
            yield level, f"{count} {words}, by up to {depth:.3g} um"
    if np.isin(verdict, tuple(said)).any():
        yield NOTE, "the contact ratio, Eq. 16, is not an operating one: see `beveloid-geom operation`"
    unknown = certificate.first.status[verdict == Verdict.NOT_SOLVED]
    for status in np.unique(unknown):
        count = f"at {np.count_nonzero(unknown == status)} of {all_positions} positions"
        yield (
            NOTE,
            f"{count} it is not known whether something touches earlier: {UNKNOWN[FirstStatus(int(status))]}",
        )


def pressure_remarks(found: PathPressure) -> Iterator[Remark]:
    """Say where the ellipses of a single path are not what Hertz's theory is of, of lines once for all."""
    if touches_along_lines(found.path.design, found.path.flank):
        yield Remark(NOTE, "flanks that touch along lines have no ellipse: no pressure")
        return
    count, lead = found.status.size, f"{found.path.flank} flanks: at"
    past = found.reaches != WHOLE
    if past.any():
        limits = ", ".join(str(Limit(int(code))) for code in np.unique(found.reaches[past]))
        text = (
            f"{lead} {np.count_nonzero(past)} of {count} positions the ellipse ends beyond an edge of a flank"
        )
        yield Remark(NOTE, f"{text} ({limits}): less metal carries the load, at a greater pressure")
    said = {
        EllipseStatus.LINE_CONTACT: "the flanks touch along a line to rounding",
        EllipseStatus.INTERFERENCE: "the flanks cut each other beside the contact",
    }
    for code, words in said.items():
        if lost := np.count_nonzero(found.status == code):
            yield Remark(WARNING, f"{lead} {lost} of {count} positions {words}: no ellipse, no pressure")
