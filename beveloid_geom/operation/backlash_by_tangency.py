"""Backlash of many mountings at once, by where flanks are tangent instead of where teeth first touch.

The play of `backlash` takes some hundred first contacts, that of flanks which go on beyond toe and heel
no more than their two paths of contact: each path says how far the gear's stop on its side lies from that
of the unmodified pair without errors, and of several tooth pairs the first counts. Without parabolas
that is the same all along the path, under any error, and follows in closed form (`mounting`).

Flanks that bend away from each other are tangent no later than their trimmed parts touch, edges included.
The backlash found is then the least that it can be, and the backlash itself where the tangencies lie on
the faces of both sides. Where flanks are hollow against each other along a path, the gear running ahead
towards its ends, edges touch before: what is found is an estimate, on the faces too much. Fillets and bottom
lands are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.parallel.nearly import NEARLY
from ..contact.path import PathEnds, path_ends, path_of_contact
from ..design.model import Design, Errors
from ..pair.frames import layout_of
from ..pair.mounting import half_pitch, mounting_of, unmodified_backlash
from ..status import Status
from .backlash import FLANKS, JAMMED, lever_of
from .first_contact import conjugate_phase

WIDE = 20.0
"""Face widths to which flanks are taken to go on."""
POINTS, SAMPLES = 17, 32
"""Positions of a path, and rolls of a mesh cycle at which the play is found."""
EVEN = 1e-6
"""Share by which the steps of roll along a path may differ: more, and the roll turns back on it."""
HOLLOW = 1e-8
"""Modules of a second difference along a path that do not make it hollow."""


class Tangency(IntEnum):
    """What a backlash by tangency is for the teeth, fillets and bottom lands aside."""

    TOUCHES = 0
    """Theirs: the tangencies lie on the faces of both sides."""
    AT_LEAST = 1
    """The least that theirs can be: beyond a toe or heel the flanks are tangent, the teeth are not."""
    ESTIMATE = 2
    """Near theirs: along a path the flanks are hollow against each other, and edges touch before."""
    UNKNOWN = 3
    """NaN: on a side there is no path between root and tip, or not one at every roll, or none but far beyond
    the teeth."""


@dataclass(frozen=True, eq=False)
class TangentBacklash:
    """Normal backlash (mm) by tangency of flanks that go on beyond toe and heel, of the batch shape, and
    `status`, codes of `Tangency`."""

    normal: FloatArray
    status: Codes


@dataclass(frozen=True, eq=False)
class _Curve:
    """Clearance (mm) of a tooth pair along its path, beyond that of the unmodified pair without errors, at
    POINTS even steps of the pinion's roll: (POINTS, cases). `first` and `step` (cases), rad.
    `beside` (POINTS, cases): mm by which a face is missed, negative on it."""

    first: FloatArray
    step: FloatArray
    clearance: FloatArray
    beside: FloatArray


def jammed(backlash: FloatArray, module: float) -> Mask:
    """Say whether a normal backlash (mm) is too little to put the pair together."""
    return np.asarray(backlash < -JAMMED * module)


def tangent_backlash(design: Design, known: dict[str, PathEnds] | None = None) -> TangentBacklash:
    """Give the least normal backlash over a mesh cycle by tangency, of any batch of designs.

    `known`: ends of paths on the flanks that are known already, by flank. The cost is that of the paths of
    both flanks; where there is no parabola at all those known are spared."""
    if any(np.any(member.tool.parabola) for member in design.members):
        return _modified(design)
    # On parallel axes that errors tilt flanks are tangent with normals along the common perpendicular, far
    # beyond the teeth, whose edges touch.
    edges = layout_of(design.with_errors(Errors())).parallel & ~layout_of(design).parallel
    normal = np.where(edges, np.nan, unmodified_backlash(design))
    ends = [(known or {}).get(flank) or path_ends(design, flank) for flank in FLANKS]
    # Paths that make up more than a pitch together have rolls in common.
    touches = (ends[0].contact_ratio + ends[1].contact_ratio > 1.0) & (ends[0].status == Status.SOLVED)
    touches &= ends[1].status == Status.SOLVED
    return _with_status(normal, touches, np.zeros(normal.shape, dtype=bool))


def _with_status(normal: FloatArray, touches: Mask, hollow: Mask) -> TangentBacklash:
    cases = ((np.isnan(normal), Tangency.UNKNOWN), (hollow, Tangency.ESTIMATE), (touches, Tangency.TOUCHES))
    status = np.select([case for case, _ in cases], [code for _, code in cases], Tangency.AT_LEAST)
    return TangentBacklash(normal, status.astype(np.int8))


def _modified(design: Design) -> TangentBacklash:
    shape = design.batch_shape
    pitch, own, module = (
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
    # On parallel axes a path runs along the face, and does not tell how hollow its flanks are across.
    across = sum(np.asarray(member.tool.parabola) for member in design.members)
    along_face = (across > 0.0) & (np.abs(layout_of(design).sin_angle) <= NEARLY)
    hollow = (np.minimum(*bends) < -HOLLOW * module) | np.broadcast_to(along_face, shape).reshape(-1)
    # From the middle of either path on, so that the mirrored pair is asked at the mirrored rolls.
    parts = [_lowest_from(curve, curves, own, pitch, hollow) for curve in curves]
    lowest, beside = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    best = np.where(np.isnan(lowest), -np.inf, lowest).argmin(axis=0)[None]  # not known at a roll: not at all
    normal, off = (np.take_along_axis(rows, best, axis=0)[0] for rows in (lowest, beside))
    return _with_status(normal.reshape(shape), (off <= 0.0).reshape(shape), hollow.reshape(shape))


def _lowest_from(
    one: _Curve, curves: list[_Curve], own: FloatArray, pitch: FloatArray, hollow: Mask
) -> tuple[FloatArray, FloatArray]:
    """Give the least play (mm) near each of SAMPLES rolls of a mesh cycle, the first in the middle of one
    path, and how far beside the faces: (SAMPLES, cases)."""
    start = one.first + 0.5 * (POINTS - 1) * one.step
    roll = start + np.arange(-1, SAMPLES + 1)[:, None] / SAMPLES * pitch
    sides = [_first_of(curve, roll, pitch) for curve in curves]
    play, beside = own + sides[0][0] + sides[1][0], np.maximum(sides[0][1], sides[1][1])
    slope, bend = 0.5 * (play[2:] - play[:-2]), play[2:] - 2.0 * play[1:-1] + play[:-2]
    with np.errstate(invalid="ignore", divide="ignore"):
        vertex = (bend > 0.0) & (np.abs(slope) < bend) & ~hollow  # hollow curves begin and end with a step
        lowest = play[1:-1] - np.where(vertex, 0.5 * slope * slope / bend, 0.0)
    return lowest, beside[1:-1]


def _curve(design: Design, flank: str) -> _Curve:
    """Give the path of one flank pair as long as root and tip let it be."""
    pinion, gear = (
        replace(member, face_width=WIDE * np.asarray(member.face_width)) for member in design.members
    )
    path = path_of_contact(replace(design, pinion=pinion, gear=gear), flank, POINTS)
    if not path.pinion_roll.size:  # a single design without a path has no positions
        none = np.full((POINTS, int(np.prod(design.batch_shape))), np.nan)
        return _Curve(none[0], none[0], none, none)
    teeth = [np.asarray(member.teeth) for member in design.members]
    phase = path.gear_roll + (teeth[0] / teeth[1])[..., None] * path.pinion_roll
    phase = phase - np.broadcast_to(conjugate_phase(design, flank), design.batch_shape)[..., None]
    pitch, lever = (2.0 * np.pi / teeth[1])[..., None], lever_of(design)[..., None]
    half = (0.5 * np.asarray(member.face_width)[..., None] for member in design.members)
    beside = [np.abs(z) - width for z, width in zip((path.pinion_z, path.gear_z), half, strict=True)]
    rows = path.pinion_roll, flank_sign(flank) * lever * half_pitch(phase, pitch), np.maximum(*beside)
    order = 1 if flank_sign(flank) > 0.0 else -1  # the pinion's roll falls along paths of left flanks
    roll, clearance, beside_both = (row.reshape(-1, POINTS).T[::order].copy() for row in rows)
    step = (roll[-1] - roll[0]) / (POINTS - 1)
    with np.errstate(invalid="ignore"):
        even = (step > 0.0) & (np.abs(np.diff(roll, axis=0) - step).max(axis=0) <= EVEN * step)
    return _Curve(roll[0], np.where(even, step, np.nan), clearance, beside_both)


def _first_of(curve: _Curve, roll: FloatArray, pitch: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the clearance of the first of all tooth pairs at rolls (samples, cases), by cubics, and how far
    beside the faces."""
    into, last = np.remainder(roll - curve.first, pitch), POINTS - 1
    least, beside = np.full(into.shape, np.inf), np.full(into.shape, np.nan)
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
        place = at * at.shape[1] + np.arange(at.shape[1])  # in the rows one after the other
        clearance, off = (
            sum(
                weight * row.take(place + way * at.shape[1])
                for way, weight in zip((-1, 0, 1, 2), weights, strict=True)
            )
            for row in (curve.clearance, curve.beside)
        )
        first = reached & (clearance < least)
        least, beside = np.where(first, clearance, least), np.where(first, off, beside)
    return np.where(np.isinf(least), np.nan, least), beside
