"""Contact lines of flanks on parallel axes, and the contact ratios of ISO 21771.

Flanks without parabola and modification that fit each other touch along straight lines in their plane of
action, which move across it with the roll. Teeth without helix and cone touch along lines parallel to the
axes, for any profile. `path_of_contact` crosses these lines from the first to the last; here the ends of each
line are computed.

    eps_alpha = g_alpha / p_bt,   eps_beta = b tan(beta_b) / p_bt,   eps_gamma = eps_alpha + eps_beta

hold for cylindrical gears with the length of path of contact in a transverse section g_alpha, the common face
width b and the transverse base pitch p_bt. With cones the transverse ratio changes along the face: it is
computed in the middle of the common face. eps_beta uses the base helix angle of the flank, which differs
between right and left flanks. The total ratio is computed separately, from the roll between the first and the
last line.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...arrays import Codes, FloatArray, Mask
from ...design.arguments import require_path
from ...design.model import Design
from ...status import Limit, Status
from ...support.array_repr import short_repr
from ..equation import axial_and_radius, edge_margins, limit_margins, roll_angles
from ..flank_pair import FlankPair, generated_pairing, is_modified, pairing_of
from ..path import ContactPath, pairing_of_path, path_of_contact
from ..path_polynomial import POINT, ROW_COUNT, ROWS, rows_of
from ..surfaces.problems import problems_of
from .equation import along_axes, meet_on_parallel
from .modified_lines import (
    LINEAR,
    LineEnds,
    across_the_face,
    has_reliefs_only,
    length_between,
    without_reliefs,
)
from .paths import along_lines, greatest_at, interval, on_lines


@dataclass(frozen=True, eq=False)
class ContactLines:
    """Lines of contact of one flank pair at the rolls of its path.

    Arrays (..., lines): `pinion_roll`, `gear_roll` (rad) and `length` (mm). For both ends, (..., lines, 2):
    `point` (mm, in S_f, with a last axis of 3), `l1, l2, u1, u2, pinion_z, pinion_r, gear_z, gear_r` (mm) as
    in `ContactPath`, and `limit`, the code of the `Limit` that ends the line, also if the line ends where a
    relief of this edge begins. Batch shape: `transverse_ratio` and `overlap_ratio` of the flanks without
    modification, and `total_ratio`, the contact ratio of the path (NaN with a modification). NaN, and limits
    -1, where flanks do not touch along lines.
    """

    __repr__ = short_repr

    design: Design = field(repr=False)
    flank: str
    pinion_roll: FloatArray
    gear_roll: FloatArray
    length: FloatArray
    point: FloatArray
    l1: FloatArray
    l2: FloatArray
    u1: FloatArray
    u2: FloatArray
    pinion_z: FloatArray
    pinion_r: FloatArray
    gear_z: FloatArray
    gear_r: FloatArray
    limit: Codes
    transverse_ratio: FloatArray
    overlap_ratio: FloatArray
    total_ratio: FloatArray


def touches_along_lines(design: Design, flank: str = "right") -> Mask:
    """Return whether flanks without modification have line contact, if they touch at all.

    They have line contact on parallel axes, with the errors of the design, in three cases: without parabolas
    if both members have the same normal and the same direction of the generators (lines of constant l) in the
    plane of action; with teeth parallel to the axes; and with parabolas of one rack (a_1 = -a_2) on reference
    cylinders that touch. The result is False for flanks with a modification; use `is_line_contact` for them.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    ndarray of bool
        Of the batch shape.
    """
    if is_modified(design, flank):
        return np.zeros(design.batch_shape, dtype=bool)
    pairing = pairing_of(design, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return along_lines(pairing).reshape(design.batch_shape)


def is_line_contact(design: Design, flank: str = "right") -> Mask:
    """Return whether flanks touch along lines, with or without modifications.

    Modified flanks do on parallel axes where the modifications do not vary along the lines. Their path of
    contact connects the points of these lines that are nearest to mid-face. It ends where this point leaves
    the flanks, although a part of the next lines may still be on them.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    ndarray of bool
        Of the batch shape.
    """
    if not is_modified(design, flank):
        return touches_along_lines(design, flank)
    pairing = generated_pairing(design, flank)
    result = np.zeros(len(pairing.branch), dtype=bool)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for _, cases, problem in problems_of(design, flank, pairing):
            result[cases] = problem.line_contact
    return result.reshape(design.batch_shape)


def contact_lines(path: ContactPath) -> ContactLines:
    """Compute the lines along which flanks on parallel axes touch, one at each roll of a path.

    Parameters
    ----------
    path : ContactPath
        Path with evenly spaced positions. Undercut limits the lines unless the path has `undercut=False`.

    Returns
    -------
    ContactLines
        NaN where flanks touch in points, or not at all, and on teeth with a helix or a cone for modifications
        other than reliefs and for reliefs together with parabolas. A line ends where a relief begins, except
        for tip and root reliefs of teeth parallel to the axes, which touch along the complete line.

    References
    ----------
    Contact ratios: ISO 21771.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> lines = bg.contact_lines(bg.path_of_contact(bg.builtin_design("anti-backlash"), points=3))
    >>> round(float(lines.total_ratio), 3)
    1.911
    """
    require_path(path)
    if _modified_line_contact(path):
        return _modified_lines(path)
    return _lines_at(path, path.l1, path.pinion_roll)


def carrying_length(path: ContactPath, lines: ContactLines) -> FloatArray:
    """Return the total length of the contact lines of all tooth pairs at each roll of a path.

    Rigid flanks without transmission error touch on all tooth pairs in mesh at the same time. Flanks with a
    transmission error, or on a relief, touch on one tooth pair, and the length is that of its line. This is
    also the length for reliefs together with parabolas, where only the line of this tooth pair is known.

    Parameters
    ----------
    path : ContactPath
    lines : ContactLines
        Lines of this path (`contact_lines`).

    Returns
    -------
    array (..., positions)
        mm; NaN where flanks touch in points, 0 or NaN for a case of a batch without a path.
    """
    if not _modified_line_contact(path):
        every, touches = _lines_of_all_pairs(path)
        return _total_length(every.length, touches)
    # Where a pair with reliefs touches as without them, so do its neighbours. Elsewhere the length is that of
    # its own line, as if this pair touched alone.
    generated = _generated_path(path)
    every, touches = _lines_of_all_pairs(generated)
    unrelieved = without_reliefs(path.design, path.flank, _ends_of(every))
    total = _total_length(np.nan_to_num(unrelieved.length), touches)
    return np.where(_unrelieved(path, generated), total, lines.length)


def _modified_line_contact(path: ContactPath) -> bool:
    """Return whether flanks with a modification touch along lines in some case of a path with positions."""
    modified = path.l1.size > 0 and is_modified(path.design, path.flank)
    return modified and bool(is_line_contact(path.design, path.flank).any())


def _total_length(length: FloatArray, touches: Mask) -> FloatArray:
    """Return the sum of the lengths, mm, of the tooth pairs (..., positions, pairs) that touch."""
    length = np.where(touches, length.reshape(touches.shape), 0.0)
    return np.asarray(length.sum(axis=-1))


def _lines_of_all_pairs(path: ContactPath) -> tuple[ContactLines, Mask]:
    """Return the lines (..., positions * pairs) of neighbouring tooth pairs at each position of a path, and
    which of them touch, (..., positions, pairs)."""
    # Transmission error along a path below which neighbouring tooth pairs touch at the same time.
    conjugate_rad = 1e-10
    ends, shape = path.ends, path.l1.shape
    first, last = np.moveaxis(ends.pinion_roll, -1, 0)[..., None, None]
    conjugate = np.ptp(path.transmission_error, axis=-1)[..., None, None] <= conjugate_rad
    pitch = 2.0 * np.pi / np.asarray(path.design.pinion.teeth)[..., None, None]
    reach = int(np.ceil(np.nanmax(ends.contact_ratio, initial=0.0)))
    pairs = np.arange(-reach, reach + 1)
    share = (path.pinion_roll[..., None] + pairs * pitch - first) / (last - first)
    # Rounding must not drop the line at the first or last roll of the path.
    share = np.where(pairs == 0, np.clip(share, 0.0, 1.0), share)
    touches = (share >= 0.0) & (share <= 1.0) & (conjugate | (pairs == 0))
    share = np.where(touches, share, 0.0)
    # Along the straight path across lines without transmission error, l1 is linear in the roll.
    l1 = ends.l1[..., :1, None] + share * np.diff(ends.l1)[..., None]
    l1 = np.where(pairs == 0, path.l1[..., None], l1)
    roll = np.where(pairs == 0, path.pinion_roll[..., None], first + share * (last - first))
    # The pairs that touch come first; columns in which no pair touches at any position are left out.
    order = np.argsort(~touches, axis=-1, kind="stable")[..., : int(touches.sum(axis=-1).max())]
    touches, l1, roll = (np.take_along_axis(values, order, axis=-1) for values in (touches, l1, roll))
    flat = (*shape[:-1], -1)
    return _lines_at(path, l1.reshape(flat), roll.reshape(flat)), touches


def _generated_path(path: ContactPath) -> ContactPath:
    """Return the contacts of the flanks without modification at the rolls of a path, or at the nearest rolls
    of their own path."""
    design, shape = path.design.without_modifications(), path.design.batch_shape
    if design.batch_shape != shape:  # the amounts of the modifications are a batch
        offset = np.array(np.broadcast_to(design.pair.offset, shape))
        design = replace(design, pair=replace(design.pair, offset=offset))
    ends = path_of_contact(design, path.flank, 2, undercut=path._undercut).ends
    first, last = np.moveaxis(ends.pinion_roll, -1, 0)[..., None]
    share = np.clip((path.pinion_roll - first) / (last - first), 0.0, 1.0)
    # Along the straight path across lines without transmission error, l1 is linear in the roll.
    l1 = np.nan_to_num(ends.l1[..., :1] + share * np.diff(ends.l1))  # 0 without a path: any l1 will do
    return path_of_contact(design, path.flank, l1=l1, undercut=path._undercut)


def _unrelieved(path: ContactPath, generated: ContactPath) -> Mask:
    """Return where flanks touch as without their reliefs; nowhere with parabolas or other modifications."""
    # There both paths have the same rolls. With parabolas, both ends may have them too: these cases are left
    # out. The limit is larger than the effect of the additional crowning of modified flanks.
    largest_difference_rad = 1e-9
    rolls = (path.pinion_roll - generated.pinion_roll, path.gear_roll - generated.gear_roll)
    same = np.abs(rolls).max(axis=0) <= largest_difference_rad
    same &= pairing_of_path(path).without_parabola.reshape(*path.design.batch_shape, 1)
    return np.asarray(same & has_reliefs_only(path.design, path.flank))


def _ends_of(lines: ContactLines) -> LineEnds:
    """Return both ends of lines."""
    return LineEnds(**{name: getattr(lines, name) for name in (*LINEAR, "limit")})


def _modified_lines(path: ContactPath) -> ContactLines:
    """Return the lines of modified flanks (`modified_lines`)."""
    design, flank = path.design, path.flank
    generated, pairing = _generated_path(path), pairing_of_path(path)
    lines = _lines_at(generated, generated.l1, generated.pinion_roll)
    spur = along_axes(pairing).reshape(*design.batch_shape, 1)
    contact = {name: getattr(path, name)[..., None] for name in LINEAR[:-1]}
    contact |= {"point": path.point[..., None, :], "limit": np.full((*path.l1.shape, 1), np.int8(-1))}
    across = without_reliefs(design, flank, across_the_face(pairing, LineEnds(**contact)), profile=False)
    unrelieved = without_reliefs(design, flank, _ends_of(lines))
    touches = is_line_contact(design, flank)[..., None] & (path.status == Status.SOLVED)
    fits = _unrelieved(path, generated)
    values: dict[str, Any] = {}
    for name in (*LINEAR, "limit"):
        spurs, others = getattr(across, name), getattr(unrelieved, name)
        axes = (..., *(None,) * (spurs.ndim - touches.ndim))
        none = np.int8(-1) if name == "limit" else np.nan
        values[name] = np.where((touches & spur)[axes], spurs, np.where((touches & fits)[axes], others, none))
    x, y = values["point"][..., 0], values["point"][..., 1]
    offset = np.asarray(pairing.layout.offset).reshape(*design.batch_shape, 1, 1)
    return replace(
        lines,
        design=design,
        pinion_roll=np.where(touches, path.pinion_roll, np.nan),
        gear_roll=np.where(touches, path.gear_roll, np.nan),
        pinion_r=np.hypot(x, y),
        gear_r=np.hypot(x - offset, y),
        length=length_between(values["point"]),
        total_ratio=np.full(design.batch_shape, np.nan),
        **values,
    )


def _lines_at(path: ContactPath, l1: FloatArray, roll: FloatArray) -> ContactLines:
    """Return the lines of a path at rolls (..., lines), rad, each through the contact at l1, mm."""
    # Quantities of both ends of a line, named as in `ContactPath`.
    end_quantities = ("l1", "l2", "u1", "u2", "pinion_z", "pinion_r", "gear_z", "gear_r")
    pairing, shape = pairing_of_path(path), path.design.batch_shape
    l1 = l1.reshape(len(pairing.branch), -1)
    roll = roll.reshape(l1.shape)
    # NaN for cases that do not touch along lines.
    rows = np.full((ROW_COUNT, *l1.shape, 2), np.nan)
    limit = np.full((*l1.shape, 2), np.int8(-1))
    ratios = np.full((2, len(l1)), np.nan)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        solved = path.ends.status.reshape(-1) == Status.SOLVED
        at = np.flatnonzero(touches_along_lines(path.design, path.flank).reshape(-1) & solved)
        if at.size:
            part = pairing.cases(at)
            result = _line_ends(part, l1[at], roll[at])
            rows[:, at] = result[:ROW_COUNT]
            margins = result[ROW_COUNT:]
            if part.edges:
                margins[:2] = np.minimum(margins[:2], edge_margins(part, result[:2], result[4:6]))
            limit[at] = margins.argmin(axis=0)
            ratios[:, at] = _ratios(part)
    named = {name: rows[row].reshape(*shape, -1, 2) for name, row in ROWS.items()}
    point = np.moveaxis(rows[POINT], 0, -1)
    return ContactLines(
        design=path.design,
        flank=path.flank,
        length=length_between(point).reshape(*shape, -1),
        pinion_roll=named["pinion_roll"][..., 0],
        gear_roll=named["gear_roll"][..., 0],
        point=point.reshape(*shape, -1, 2, 3),
        **{name: named[name] for name in end_quantities},
        limit=limit.reshape(*shape, -1, 2),
        transverse_ratio=ratios[0].reshape(shape),
        overlap_ratio=ratios[1].reshape(shape),
        total_ratio=np.where(np.isnan(ratios[0].reshape(shape)), np.nan, path.ends.contact_ratio),
    )


def _line_ends(pairing: FlankPair, l1: FloatArray, roll: FloatArray) -> FloatArray:
    """Return rows (FULL_ROW_COUNT, cases, lines, 2) of both ends of the lines at `roll` (cases, lines), rad,
    each through the contact at l1, mm; the end nearer to the toe of the pinion first.

    The contacts at one roll have w1 linear in the roll at each l1. The ends are the least and largest l1 at
    which this w1 is within the limits. For teeth parallel to the axes, the roll determines l1.
    """
    # `spare` of `interval` for the lines at the ends of a path, which lie along an edge except for
    # rounding.
    edge_tolerance = 1e-13
    shape, along, lines = l1.shape, along_axes(pairing)[:, None], on_lines(pairing)

    def at_roll(l1: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return w1 at the roll and the first and last w1 within limits, at l1 (cases, lines, samples)."""
        l, met = lines(l1.reshape(shape[0], -1))
        ends = interval(pairing, l, met, edge_tolerance)
        base_roll = roll_angles(pairing, met)[0]
        rate = met.slope[0] / met.moment[0] + 0.0 * base_roll
        base_roll, rate, first, last = (x.reshape(l1.shape) for x in (base_roll, rate, *ends))
        return (roll[..., None] - base_roll) / rate, first, last

    def inside(l1: FloatArray) -> FloatArray:
        w, first, last = at_roll(l1)
        return np.where((first <= w) & (w <= last), l1, np.nan)

    ends = []
    # Extend the line from the given contact to both sides as far as it is inside the limits.
    for sense, bound in ((-1.0, pairing.lowest[0]), (1.0, pairing.highest[0])):
        start = l1[..., None]
        result = greatest_at(inside, start, np.broadcast_to(bound[..., None], start.shape), sense)
        result = np.where(np.isnan(result) | along[..., None], start, result)
        w, first, last = (x[..., 0] for x in at_roll(result))
        w = np.where(along, first if sense < 0.0 else last, np.clip(w, first, last))
        l, _ = lines(result[..., 0])
        ends.append(rows_of(pairing, l, meet_on_parallel(pairing, l, w)))
    rows = np.stack(ends, axis=-1)
    swapped = rows[ROWS["pinion_z"], ..., :1] > rows[ROWS["pinion_z"], ..., 1:]
    return np.where(swapped, rows[..., ::-1], rows)


def _ratios(pairing: FlankPair) -> FloatArray:
    """Return the transverse contact ratio in the middle of the common face, and the overlap ratio, (2,
    cases).
    """
    low = (pairing.position - pairing.half_width).max(axis=0)
    high = (pairing.position + pairing.half_width).min(axis=0)
    pitch, lines = 2.0 * np.pi / pairing.teeth[0], on_lines(pairing)

    def roll(l1: FloatArray) -> FloatArray:
        """Return the pinion roll of contacts at l1 in the section, NaN beyond root and tip."""
        l, met = lines(l1)
        v, square = met.normal[2, 0], met.square[0]
        axial, rate = v * met.along[0] + square * met.across[0], v * met.slope[0] + square
        met = meet_on_parallel(pairing, l, (0.5 * (low + high) - axial) / rate)
        z, radius = axial_and_radius(pairing, met)
        depth = limit_margins(pairing, l, z, radius)[: Limit.PINION_TOE].min(axis=0)
        if pairing.edges:
            depth = np.minimum(depth, edge_margins(pairing, l, z).min(axis=0))
        return np.where(depth >= 0.0, roll_angles(pairing, met)[0], np.nan)

    ends = [roll(greatest_at(roll, pairing.lowest[0], pairing.highest[0], sense)) for sense in (-1.0, 1.0)]
    normal = pairing.rack.normal
    lean = np.abs(normal[2, 0] / (np.asarray(pairing.rack.pitch_radius)[0] * normal[1, 0]))
    return np.array(((ends[1] - ends[0]) / pitch, (high - low) * lean / pitch))[..., 0]
