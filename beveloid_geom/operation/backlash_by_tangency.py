"""Backlash of many mountings from the tangency of flanks, instead of first contacts.

The play of `backlash` takes some hundred first contacts. For flanks that are extended past toe and heel, it
follows from their two paths of contact: each path gives the limit of the gear on its side relative to the
unmodified pair without errors, and the first of several tooth pairs counts. Without parabolas and
modifications, the play is constant along the path under any error, and follows in closed form
(`pair.mounting`).

If the flanks curve away from each other, the extended flanks touch before the real teeth with their edges,
or at the same roll of the gear. The result is then a lower bound of the backlash. It is the backlash itself
where the tangencies of both sides lie on the faces. Where the flanks are concave against each other along a
path (the gear is ahead towards the ends of the path), edges touch earlier: the result is an estimate, and
too large. Fillets and bottom lands are not considered: if a tip of the pair without errors comes near a
fillet (`pair.tips`), the result is an estimate as well, since the fillet may leave less backlash.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from ..arrays import FLANKS, Codes, FloatArray, Mask, flank_sign
from ..contact.ellipse import relative_curvature
from ..contact.flank_pair import is_modified, may_be_undercut
from ..contact.parallel.small_angle_paths import NEARLY_PARALLEL_SINE
from ..contact.path import ContactPath, PathEnds, path_ends, path_of_contact
from ..design.member import Member
from ..design.model import Design, Errors, Pair
from ..pair.frames import layout_of
from ..pair.mounting import mounting_of, unmodified_backlash, within_half_pitch
from ..pair.tips import CLEAR_DEPTH_MODULES, depth_below_tips_as_mounted
from ..status import Limit, Status
from ..support.frozen_arrays import cached
from .backlash import JAM_OVERLAP_MODULES, lever_of
from .engagement import conjugate_phase

PATH_POINTS = 17
"""Positions of a path at which the play is computed on flanks without a `Modification`."""


class Tangency(IntEnum):
    """Relation of a backlash by tangency to that of the teeth, without fillets and bottom lands."""

    TOUCHES = 0
    """The backlash of the teeth: the tangencies lie on the faces of both sides."""
    AT_LEAST = 1
    """A lower bound: past a toe or heel, the extended flanks are tangent but the teeth are not."""
    ESTIMATE = 2
    """An estimate; the backlash may be smaller. The flanks are concave against each other along a path, so
    that edges touch earlier, or a tip comes near a fillet."""
    UNKNOWN = 3
    """The backlash is NaN. On at least one side, no tangency lies between root and tip, or there is none at
    some rolls, or the tangencies are far from the teeth."""


@dataclass(frozen=True, eq=False)
class TangentBacklash:
    """Normal backlash (mm) by tangency of flanks that are extended past toe and heel, of the batch shape,
    and `status`, codes of `Tangency`."""

    normal: FloatArray
    status: Codes


@dataclass(frozen=True, eq=False)
class _Curve:
    """Clearance (mm) of a tooth pair along its path relative to the unmodified pair without errors, (points,
    cases).

    The pinion rolls are evenly spaced from `first` by `step` (cases), rad. `past_face` (points, cases):
    distance past the end of a face, mm, negative on the face. `hollow` (cases): whether flanks with a
    `Modification` have negative relative curvature somewhere, so that edges touch earlier."""

    first: FloatArray
    step: FloatArray
    clearance: FloatArray
    past_face: FloatArray
    hollow: Mask


def jammed(backlash: FloatArray, module: float) -> Mask:
    """Return whether a normal backlash is too small to assemble the pair.

    Parameters
    ----------
    backlash : ndarray
        mm.
    module : float
        Normal module, mm.

    Returns
    -------
    ndarray of bool
    """
    return np.asarray(backlash < -JAM_OVERLAP_MODULES * module)


def tangent_backlash(design: Design, known: dict[str, PathEnds] | None = None) -> TangentBacklash:
    """Compute the minimum normal backlash by tangency, for any batch of designs.

    Parameters
    ----------
    design : Design
    known : dict of str to PathEnds, optional
        Ends of paths that are already known, by flank. They are used if no member has a parabola or a
        modification.

    Returns
    -------
    TangentBacklash
        Its computation takes about as long as that of the paths of both flanks.
    """
    if design.has_parabola or any(is_modified(design, flank) for flank in FLANKS):
        return _modified(design)
    # Parallel axes tilted by errors: the flanks are tangent only far from the teeth, where the normals are
    # along the common perpendicular. The edges of the teeth touch instead.
    edges = layout_of(design.with_errors(Errors())).parallel & ~layout_of(design).parallel
    normal = np.where(edges, np.nan, unmodified_backlash(design))
    ends = [(known or {}).get(flank) or path_ends(design, flank) for flank in FLANKS]
    # If both contact ratios add up to more than 1, there are rolls at which both sides are tangent.
    touches = (ends[0].contact_ratio + ends[1].contact_ratio > 1.0) & (ends[0].status == Status.SOLVED)
    touches &= ends[1].status == Status.SOLVED
    return _with_status(normal, touches, np.broadcast_to(_near_fillets(design), normal.shape))


def _near_fillets(design: Design) -> bool:
    """Return whether a tip comes near a fillet on either side, without errors; False for arrays of members
    or layouts."""
    plain = design.bare()
    return not plain.batch_shape and _cached_near_fillets(plain.pinion, plain.gear, plain.pair)


@cached(64)
def _cached_near_fillets(pinion: Member, gear: Member, pair: Pair) -> bool:
    """Return `_near_fillets` of a single design, which batches of errors share."""
    design = Design(pinion, gear, pair)
    left = np.minimum(*(depth_below_tips_as_mounted(design, flank) for flank in FLANKS))
    return bool((left < CLEAR_DEPTH_MODULES * float(pinion.tool.normal_module)).any())


def _with_status(normal: FloatArray, touches: Mask, less: Mask) -> TangentBacklash:
    """Return the backlash with its status; `less` where the teeth may have less backlash."""
    cases = ((np.isnan(normal), Tangency.UNKNOWN), (less, Tangency.ESTIMATE), (touches, Tangency.TOUCHES))
    status = np.select([case for case, _ in cases], [code for _, code in cases], Tangency.AT_LEAST)
    return TangentBacklash(normal, status.astype(np.int8))


def _modified(design: Design) -> TangentBacklash:
    shape = design.batch_shape
    pitch, layout_play, module = (
        np.broadcast_to(value, shape).reshape(-1)
        for value in (
            2.0 * np.pi / np.asarray(design.pinion.teeth),
            mounting_of(design).normal_backlash,
            design.pinion.tool.normal_module,
        )
    )
    curves = [_curve(design, flank) for flank in FLANKS]
    with np.errstate(invalid="ignore"):
        bends = [np.diff(curve.clearance, n=2, axis=0).min(axis=0) for curve in curves]
    # On parallel axes, a path runs along the face and does not show the relative curvature along the profile.
    first, second = (sum(np.asarray(m.tool.parabola_of(flank)) for m in design.members) for flank in FLANKS)
    along_face = np.abs(layout_of(design).sin_angle) <= NEARLY_PARALLEL_SINE
    along_face = along_face & (np.maximum(first, second) > 0.0)
    concave = (np.minimum(*bends) < -1e-8 * module) | np.broadcast_to(along_face, shape).reshape(-1)
    concave |= curves[0].hollow | curves[1].hollow
    # Start from the middle of either path, so that the mirrored pair is evaluated at the mirrored rolls.
    with_modification = any(is_modified(design, flank) for flank in FLANKS)
    # Rolls of a mesh cycle at which the play is computed. With a `Modification`, the clearance has steps in
    # its second derivative where reliefs begin, so that its minimum is taken from the samples alone.
    samples = 128 if with_modification else 32
    steps = concave | with_modification
    parts = [_lowest_from(curve, curves, layout_play, pitch, steps, samples) for curve in curves]
    lowest, past_face = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    best = np.where(np.isnan(lowest), -np.inf, lowest).argmin(axis=0)[None]  # unknown at one roll: unknown
    normal, off = (np.take_along_axis(rows, best, axis=0)[0] for rows in (lowest, past_face))
    less = concave.reshape(shape) | _near_fillets(design)
    return _with_status(normal.reshape(shape), (off <= 0.0).reshape(shape), less)


def _lowest_from(
    one: _Curve, curves: list[_Curve], layout_play: FloatArray, pitch: FloatArray, steps: Mask, samples: int
) -> tuple[FloatArray, FloatArray]:
    """Return the minimum play (mm) near each of several rolls of a mesh cycle, from the middle of a path on,
    and the distance past the faces: (samples, cases). `steps`: whether the play is not smooth."""
    start = one.first + 0.5 * (len(one.clearance) - 1) * one.step
    roll = start + np.arange(-1, samples + 1)[:, None] / samples * pitch
    sides = [_first_of(curve, roll, pitch) for curve in curves]
    play, past_face = layout_play + sides[0][0] + sides[1][0], np.maximum(sides[0][1], sides[1][1])
    slope, bend = 0.5 * (play[2:] - play[:-2]), play[2:] - 2.0 * play[1:-1] + play[:-2]
    with np.errstate(invalid="ignore", divide="ignore"):
        vertex = (bend > 0.0) & (np.abs(slope) < bend) & ~steps  # concave curves begin and end with a step
        lowest = play[1:-1] - np.where(vertex, 0.5 * slope * slope / bend, 0.0)
    return lowest, past_face[1:-1]


def _tangencies(design: Design, flank: str) -> ContactPath:
    """Return the path of one flank pair at evenly spaced rolls, limited by root and tip only.

    A `Modification` is defined on the face: its path ends at toe and heel as well."""
    # Face widths to which flanks are extended.
    extended_face_widths = 20.0
    if is_modified(design, flank):
        return path_of_contact(design, flank, 33)
    pinion, gear = (
        replace(member, face_width=extended_face_widths * np.asarray(member.face_width))
        for member in design.members
    )
    # Ignore undercut of the extended flanks if the real flanks are not undercut.
    undercut = may_be_undercut(design, flank)
    return path_of_contact(replace(design, pinion=pinion, gear=gear), flank, PATH_POINTS, undercut=undercut)


def _curve(design: Design, flank: str) -> _Curve:
    """Return the path of one flank pair as a curve. It is NaN if the path ends at toe or heel, beyond which
    the edges of the teeth touch."""
    face_ends = (Limit.PINION_TOE, Limit.PINION_HEEL, Limit.GEAR_TOE, Limit.GEAR_HEEL)
    path, hollow = _tangencies(design, flank), np.zeros(int(np.prod(design.batch_shape)), dtype=bool)
    if not path.pinion_roll.size:  # single designs without a path have no positions
        none = np.full((PATH_POINTS, hollow.size), np.nan)
        return _Curve(none[0], none[0], none, none, hollow)
    if is_modified(design, flank):
        curvature = relative_curvature(path).curvature[..., 0]
        hollow = np.asarray((curvature < 0.0).any(axis=-1).reshape(-1))
    teeth = [np.asarray(member.teeth) for member in design.members]
    phase = path.gear_roll + (teeth[0] / teeth[1])[..., None] * path.pinion_roll
    phase = phase - np.broadcast_to(conjugate_phase(design, flank), design.batch_shape)[..., None]
    pitch, lever = (2.0 * np.pi / teeth[1])[..., None], lever_of(design)[..., None]
    half = (0.5 * np.asarray(member.face_width)[..., None] for member in design.members)
    past_face = [np.abs(z) - width for z, width in zip((path.pinion_z, path.gear_z), half, strict=True)]
    clearance = flank_sign(flank) * lever * within_half_pitch(phase, pitch)
    rows = path.pinion_roll, clearance, np.maximum(*past_face)
    order = 1 if flank_sign(flank) > 0.0 else -1  # the pinion's roll falls along paths of left flanks
    points = path.pinion_roll.shape[-1]
    roll, clearance, past_faces = (row.reshape(-1, points).T[::order].copy() for row in rows)
    # Uneven steps: the roll reverses along the path, which is then not used.
    step = (roll[-1] - roll[0]) / (points - 1)
    with np.errstate(invalid="ignore"):
        even = (step > 0.0) & (np.abs(np.diff(roll, axis=0) - step).max(axis=0) <= 1e-6 * step)
    even &= ~np.isin(path.ends.limit, face_ends).any(axis=-1).reshape(-1)
    return _Curve(roll[0], np.where(even, step, np.nan), clearance, past_faces, hollow)


def _first_of(curve: _Curve, roll: FloatArray, pitch: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the clearance of the first of all tooth pairs at rolls (samples, cases), by cubic
    interpolation, and the distance past the faces."""
    into, last = np.remainder(roll - curve.first, pitch), len(curve.clearance) - 1
    least, past_face = np.full(into.shape, np.inf), np.full(into.shape, np.nan)
    pairs = np.nan_to_num(last * curve.step / pitch).max(initial=0.0)
    for k in range(int(pairs) + 1):
        with np.errstate(invalid="ignore"):
            t = (into + k * pitch) / curve.step
            reached = t <= last
        at = np.clip(np.where(reached, t, 0.0).astype(int), 1, last - 2)
        x = t - at
        weights = (
            -x * (x - 1.0) * (x - 2.0) / 6.0,
            0.5 * (x + 1.0) * (x - 1.0) * (x - 2.0),
            -0.5 * (x + 1.0) * x * (x - 2.0),
            x * (x + 1.0) * (x - 1.0) / 6.0,
        )
        # Index of the four nodes into the flattened rows.
        place = at * at.shape[1] + np.arange(at.shape[1])
        nodes = [(place + node * at.shape[1], w) for node, w in zip((-1, 0, 1, 2), weights, strict=True)]
        clearance, off = (
            sum(weight * row.take(node) for node, weight in nodes)
            for row in (curve.clearance, curve.past_face)
        )
        first = reached & (clearance < least)
        least, past_face = np.where(first, clearance, least), np.where(first, off, past_face)
    return np.where(np.isinf(least), np.nan, least), past_face
