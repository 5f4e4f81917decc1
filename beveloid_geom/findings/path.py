"""Remarks on a path of contact: reasons for a missing path, sensitivity, edge contact, limits of validity."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..analysis.pressure import NO_LIMIT_REACHED, PathPressure
from ..analysis.sensitivity import Sensitivity, path_sensitivity
from ..analysis.tolerance import USUAL_AT
from ..arrays import FLANK_SIGN, MEMBERS, Codes, FloatArray
from ..contact.flank_pair import is_modified
from ..contact.parallel.lines import is_line_contact
from ..contact.path import ContactPath, path_ends, path_of_contact
from ..contact.rounding import rounding_error
from ..design.ends import limit_names, limit_words
from ..design.model import Design, ErrorsAt
from ..gear.fillet import tool_round
from ..gear.flank_limits import active_range, tip_radius
from ..operation.certificate import Certificate
from ..pair.misalignment import ANGLES, mounted
from ..pair.mounting import mounting_of
from ..status import WHY_NO_FIRST_CONTACT, EllipseStatus, FirstStatus, NotComputed, Status, Verdict
from .diagnostics import NOTE, UNKNOWN, WARNING, Remark
from .units import modulus_remarks

SENSITIVE = ((0.25, WARNING), (0.1, NOTE))
"""Shifts of a path that cause a remark, and the level of the remark. A shift under one usual tolerance is
divided by the size of the flank in the direction of the shift. A path in the middle of the flank leaves it at
one half. One quarter is a warning, because other errors, deflection and the length of the path need the
remaining space."""
ALONG_LINES = "line contact, so that an error of the shaft angle moves the contact to an edge"


def first_contact_reason(flank: str, code: int) -> str:
    """Return the reason for an unknown first contact on these flanks; `code` is its `FirstStatus`.

    The reason is `NotComputed` if the calculation failed."""
    status, teeth = FirstStatus(code), f"first contact of the {flank} teeth"
    if status.reason_type is str:
        return f"no {teeth}: {WHY_NO_FIRST_CONTACT[status]}"
    return NotComputed(f"the {teeth} could not be computed: {WHY_NO_FIRST_CONTACT[status]}")


def batch_reason(words: str, status: Codes) -> str | None:
    """Return the reason `words` if no case of a batch has a path on the flanks, otherwise None.

    `status` contains codes of `Status` of the paths. The reason is `NotComputed` if a calculation failed,
    because that case may have a path."""
    if (status == Status.SOLVED).any():
        return None
    failed = ~np.isin(status, (Status.NO_COMMON_NORMAL, Status.OFF_FLANK))
    return NotComputed(f"{words}: not all could be computed") if failed.any() else words


def reason_of(path: ContactPath) -> str | None:
    """Return the reason why a path has no point on the flanks, `NotComputed` if it could not be computed,
    otherwise None."""
    design = path.design
    status = Status(int(path.ends.status))
    if status == Status.SOLVED:
        return None
    if status == Status.NO_COMMON_NORMAL or bool(np.isnan(mounting_of(design).gap)):
        return f"the {path.flank} flanks have no common normal in this layout: is the shaft angle right?"
    if status != Status.OFF_FLANK:
        words = status.name.lower().replace("_", " ")
        return NotComputed(f"the path of contact on the {path.flank} flanks could not be computed: {words}")
    text = f"the path of contact does not meet the {path.flank} flanks"
    middle = 0.5 * sum(active_range(design.pinion, path.flank))
    extended = path_of_contact(design, path.flank, l1=[float(middle)])
    axial = extended.pinion_z[0], extended.gear_z[0]
    places = [
        (name, float(z), 0.5 * float(member.face_width))
        for name, z, member in zip(MEMBERS, axial, design.members, strict=True)
        if math.isfinite(z)
    ]
    if not places:
        return text
    if all(abs(z) <= half for _, z, half in places):
        return f"{text}: within the faces it lies beyond a tip or root"
    words = " and ".join(
        f"{z:+.4g} mm on the {name} (half face width {half:g} mm)" for name, z, half in places
    )
    return f"{text}: at mid-depth of the pinion flank its position is z = {words}"


def first_contact_fault(design: Design) -> str | None:
    """Return the reason why first contacts cannot be computed: a tip round that does not fit on the tool.
    Otherwise None."""
    for name, member in zip(MEMBERS, design.members, strict=True):
        try:
            for flank in FLANK_SIGN:
                tool_round(member.tool, flank)
        except ValueError as error:
            return NotComputed(f"the first contact could not be computed: {name}: {error}")
    return None


def path_remarks(path: ContactPath) -> Iterator[Remark]:
    """Yield remarks on a path on the flanks of a single design: sensitivity, lost contact, edges, failed
    positions.

    Without a path on the flanks there is no remark; `reason_of` returns the reason."""
    if path.ends.status != Status.SOLVED:
        return
    if is_line_contact(path.design, path.flank):
        modified = is_modified(path.design, path.flank)
        middle = "; the path runs through the points nearest to mid-face" if modified else ""
        remarks = [(NOTE, ALONG_LINES + middle)]
    else:
        remarks = [*_sensitivity_remarks(path), *_loss_remarks(path)]
    for level, text in (*remarks, *_path_remarks(path)):
        yield Remark(level, f"{path.flank} flanks: {text}")


def certificate_remarks(path: ContactPath, certificate: Certificate) -> Iterator[Remark]:
    """Yield remarks on the positions of a path where the tangency of the flanks is not the first contact of
    the teeth."""
    lead, verdict = f"{path.flank} flanks:", certificate.verdict
    codes = certificate.first.limit[verdict == Verdict.EDGE_CONTACT]
    edges = ", ".join(limit_words(path.design, int(code)) for code in np.unique(codes[codes >= 0]))
    interference = "the flanks interfere away from their tangency, or a tip interferes with a fillet"
    texts = {
        Verdict.INTERFERENCE: (WARNING, interference),
        Verdict.EDGE_CONTACT: (WARNING, f"an edge touches earlier ({edges})"),
        Verdict.NEXT_PAIR: (NOTE, "the flanks of a neighbouring tooth pair touch earlier"),
    }
    for code, (level, words) in texts.items():
        mask = verdict == code
        if mask.any():
            depth = -1e3 * float(certificate.separation[mask].min())
            count = f"at {np.count_nonzero(mask)} of {verdict.size} positions"
            yield Remark(level, f"{lead} {count} {words}, by up to {depth:.3g} um")
    if np.isin(verdict, tuple(texts)).any():
        text = "the contact ratio of one tooth pair (Eq. 16) is not the operating contact ratio"
        yield Remark(NOTE, f"{lead} {text}: see `beveloid-geom operation`")
    unknown = certificate.first.status[verdict == Verdict.NOT_SOLVED]
    for status in map(FirstStatus, np.unique(unknown).tolist()):
        level = NOTE if status.reason_type is str else UNKNOWN
        where = f"at {np.count_nonzero(unknown == status)} of {verdict.size} positions"
        reason = WHY_NO_FIRST_CONTACT[status]
        yield Remark(level, f"{lead} {where} it is unknown whether something touches earlier: {reason}")


def usual_shifts(sensitivity: Sensitivity, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shifts of a path under two errors, along the face and perpendicular to the path.

    Parameters
    ----------
    sensitivity : Sensitivity
        Sensitivity of the path; its first two errors are used.
    sizes : ndarray
        Sizes (2,) of the errors, mm and rad.

    Returns
    -------
    face, perpendicular : ndarray
        Magnitudes (..., place, member, error), mm.
    """
    face, square = (
        sizes * np.abs(rates[..., :2]) for rates in (sensitivity.face_shift_by, sensitivity.square_shift_by)
    )
    return face, square


def usual_sizes(at: ErrorsAt = "perpendicular") -> FloatArray:
    """Return the usual tolerances (2,) of the first two errors about the common perpendicular or at the mesh,
    mm and rad."""
    return np.asarray(USUAL_AT[at].values()[:2])


def shares_of_flank(design: Design, sensitivity: Sensitivity, sizes: FloatArray) -> FloatArray:
    """Return the shifts of `usual_shifts` relative to the size of the flank in the direction of the shift."""
    face, square = usual_shifts(sensitivity, sizes)
    depths = [np.subtract(*active_range(member, sensitivity.flank)[::-1]) for member in design.members]
    both = [member.face_width for member in design.members], depths
    width, depth = (np.stack(np.broadcast_arrays(*size), axis=-1)[..., None, :, None] for size in both)
    # Size of the flank, a rectangle of face width and depth, perpendicular to the path. `cosine` is that of
    # the angle between the path and the direction of the depth.
    cosine = np.divide(square, face, out=np.ones_like(face), where=face > 0.0)
    return np.asarray(square / (width * cosine + depth * np.sqrt(np.maximum(1.0 - cosine**2, 0.0))))


def _sensitivity_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Yield a remark if usual tolerances of offset and shaft angle move the path far.

    For errors at the mesh, these are the centre distance and the angle in the plane."""
    design, at = path.design, path.design.errors_at
    sensitivity, sizes = path_sensitivity(design, path.flank, at), usual_sizes(at)
    names = {"perpendicular": ("offset", "shaft angle"), "mesh": ("centre distance", "angle in plane")}[at]
    share, (face, square) = shares_of_flank(design, sensitivity, sizes), usual_shifts(sensitivity, sizes)
    if np.isnan(share).all():
        return
    worst = np.unravel_index(np.nanargmax(share), share.shape)
    level = next((level for least, level in SENSITIVE if share[worst] >= least), None)
    if level is None:
        return
    place, member, _ = worst
    lengthwise = 2.0 * square[worst] > face[worst]
    where = "along the face" if lengthwise else "perpendicular to itself"
    offset, angle = (face if lengthwise else square)[place, member]
    width = float(design.members[member].face_width)
    yield (
        level,
        f"sensitive to errors, because it is close to line contact: {math.degrees(sizes[1]):g} deg of"
        f" {names[1]} shifts the path on the {MEMBERS[member]} by {angle:.3g} mm {where},"
        f" {sizes[0]:g} mm of {names[0]} by {offset:.3g} mm; the face is {width:g} mm wide",
    )


def _loss_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Yield a warning on single errors of the size of a usual tolerance under which contact is lost."""
    design, usual = path.design, USUAL_AT[path.design.errors_at]
    size, names = usual.values(), usual.names
    errors = np.concatenate((np.diag(size), np.diag(-size)))
    if design.pair.shaft_angle > 0.0:
        errors = errors[design.pair.shaft_angle + design.errors.shaft_angle + errors[:, 1] > 0.0]
    status = path_ends(mounted(design, errors, names), path.flank).status
    words = []
    for row in errors[np.isin(status, (Status.OFF_FLANK, Status.NO_COMMON_NORMAL))]:
        column = int(np.flatnonzero(row)[0])
        name, value = names[column], float(row[column])
        size_words = f"{math.degrees(value):+g} deg" if name in ANGLES else f"{value:+g} mm"
        words.append(f"{name.replace('_', ' ')} {size_words}")
    if words:
        yield WARNING, f"contact is lost within usual tolerances, at an error of {' or '.join(words)}"


def end_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Yield warnings if a path ends at an end of the face or at the start of an active flank.

    Line contact always reaches the ends of the face, which is not reported."""
    lines, design = bool(is_line_contact(path.design, path.flank)), path.design
    for limit, k in ((path.ends.enter, 0), (path.ends.leave, -1)):
        if limit is None:
            continue
        if limit.limit in ("toe", "heel") and not lines:
            name, end = limit_names(design, limit)
            yield WARNING, f"the contact reaches the {name}'s {end}: the path ends at this edge"
        if limit.limit == "root":
            # At the end of the path, the tip of the mate reaches beyond the point of contact by `over`.
            mate = "gear" if limit.member == "pinion" else "pinion"
            z, radius = (getattr(path, f"{mate}_{name}")[k] for name in "zr")
            over = float(tip_radius(getattr(design, mate), z) - radius)
            below = (
                f"the tips of the {mate} reach below the active flank of the {limit.member} (form diameter)"
            )
            yield WARNING, f"{below}: on the {mate} the path ends {over:.3g} mm below its tips"


def _path_remarks(path: ContactPath) -> Iterator[tuple[str, str]]:
    """Yield remarks that contact ratio and positions do not show."""
    # Step against the direction of a path that is attributed to rounding, mm or rad.
    monotone_tolerance = 1e-12
    # Displacement of a contact by rounding that needs no note.
    rounding_tolerance_mm = 1e-9
    yield from end_remarks(path)
    missing = int(np.count_nonzero(path.status != Status.SOLVED))
    if missing:
        yield UNKNOWN, f"{missing} of {path.status.size} positions could not be computed"
    if path.ends.contact_ratio < 1.0:
        yield WARNING, "the contact ratio is below 1: one tooth pair leaves before the next one enters"
    if path.ends.pieces > 1:
        segments = f"the path has {int(path.ends.pieces)} segments on the flanks"
        yield NOTE, f"{segments}: positions and contact ratio are those of the longest one in roll"
    roll_words = (
        "the roll turns back along the path: the flanks are tangent twice at some rolls, and the contact"
        " ratio covers all rolls of the path"
    )
    l1_words = (
        "l1 turns back along the path: the pinion flank has two contacts at some l1, the position along its"
        " tool flank"
    )
    for values, words in ((path.pinion_roll, roll_words), (path.l1, l1_words)):
        steps = np.diff(values)
        if steps.size and steps.min() < -monotone_tolerance and steps.max() > monotone_tolerance:
            yield NOTE, words
    if path.normal.size and path.normal[:, 0].min() < 0.0 < path.normal[:, 0].max():
        where = "at one place of the path the common normal and the common perpendicular form a right angle"
        yield NOTE, f"{where} (n_x = 0): small mounting errors move the contact far there"
    moved = rounding_error(path).max(initial=0.0)
    if moved > rounding_tolerance_mm:
        words = f"rounding of the inputs moves the contact by about {moved:.1g} mm"
        yield NOTE, f"{words}; mounting errors move it much further"


def pressure_remarks(hertz: PathPressure) -> Iterator[Remark]:
    """Yield remarks on an unusual Young's modulus, and on the positions where the theory of Hertz does not
    apply, or on the load distribution of line contact."""
    yield from modulus_remarks(hertz.load.young)
    if is_line_contact(hertz.path.design, hertz.path.flank):
        shared = (
            "the load is distributed evenly over all lines in contact at the same roll, as for rigid teeth"
        )
        yield Remark(NOTE, f"{shared}; the pressure is the maximum along the line of the tooth pair")
        return
    count, lead = hertz.status.size, f"{hertz.path.flank} flanks: at"
    past = hertz.reaches != NO_LIMIT_REACHED
    if past.any():
        limits = ", ".join(
            limit_words(hertz.path.design, int(code)) for code in np.unique(hertz.reaches[past])
        )
        text = (
            f"{lead} {np.count_nonzero(past)} of {count} positions the ellipse ends beyond an edge of a flank"
        )
        yield Remark(NOTE, f"{text} ({limits}): the area is smaller, and the pressure higher")
    texts = {
        EllipseStatus.LINE_CONTACT: "the flanks have line contact within rounding",
        EllipseStatus.INTERFERENCE: "the flanks interfere next to the contact",
    }
    for code, words in texts.items():
        if number := np.count_nonzero(hertz.status == code):
            yield Remark(WARNING, f"{lead} {number} of {count} positions {words}: no ellipse, no pressure")
