"""Backlash of a pair as mounted and modified: the play of the gear while the pinion is held.

At a roll of the pinion the first contacts of the right flanks stop the gear in one sense, those of
the left flanks in the other (`first_contact`, all teeth, edges and fillets included). The gear's roll
plus N1/N2 times the pinion's, theta, at either stop gives the play along the normal,

    j = (theta_R - theta_L) m_n N2 cos(alpha) / 2,

which for the unmodified pair without errors is the backlash of the layout (`mounting`). From there it
is followed as errors and parabolas move both stops, so that no pitch can be lost on the way. The least
j over a mesh cycle is the backlash: where it is negative the teeth of a gear in mesh would overlap at
that roll, and the pair cannot be put together.

Of several tooth pairs on a side the first to touch counts, so that j has kinks as ridges only: its
least value is at a smooth minimum, which is refined from samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Mask
from ..design.model import Design
from ..pair.frames import layout_of
from ..pair.mounting import half_pitch, mounting_of
from ..status import FirstStatus
from ..support.read_only import kept, restored
from .first_contact import (
    FirstContact,
    contact_normals,
    first_contact,
    middle_roll,
    moved_by_gear,
)

SAMPLES, KEPT = 32, 2
"""Rolls of a mesh cycle at which the play is found, and how many of its minima are refined."""
PASSES, FINER = 3, 4
"""Passes of the refinement, each of which makes the steps so much finer."""
EVEN = 1e-11
"""Modules of play between rolls that are rounding: flatter minima are not refined."""
JAMMED = 2e-5
"""Modules of overlap that are none: of a layout without backlash offset and shaft angle, rounded to four
digits of mm and deg, may make them."""
FLANKS = ("right", "left")


@dataclass(frozen=True, eq=False)
class Backlash:
    """Least normal backlash over a mesh cycle, of the batch shape.

    `normal` (mm): negative where the pair cannot be put together; `pinion_roll` (rad) where it is so
    small; `right` and `left`: the first contacts there, with a last axis of one position. NaN unless
    `status`, codes of `FirstStatus`, is SOLVED: the first that is not among all rolls looked at.
    `jammed`: whether the pair cannot be put together, by negative play at some roll, known at all of
    them or not, or because a tip reaches the other member's bottom land."""

    normal: FloatArray
    pinion_roll: FloatArray
    right: FirstContact
    left: FirstContact
    status: Codes
    jammed: Mask

    __setstate__ = restored


def lever_of(design: Design) -> FloatArray:
    """Give the mm along the normal for a rad of the gear's roll, m_n N2 cos(alpha) / 2."""
    tool = design.gear.tool
    return np.asarray(0.5 * tool.normal_module * np.cos(tool.normal_pressure_angle) * design.gear.teeth)


def play_at(design: Design, pinion_roll: FloatArray) -> tuple[FloatArray, Codes]:
    """Give the play (mm along the normal) at pinion rolls (positions) or (*batch, positions), rad, and codes
    of `FirstStatus`: that of the right flanks unless it is SOLVED, else that of the left ones.

    Members must be single; pair and errors may be arrays. Raises ValueError as `first_contact`."""
    right, left = (first_contact(design, flank, pinion_roll) for flank in FLANKS)
    own = mounting_of(design).normal_backlash[..., None]
    play = own + lever_of(design) * (right.transmission_error - left.transmission_error)
    lost = np.isnan(play)
    if lost.any():  # without a layout or conjugate flanks to count from: the play nearest to none
        pitch = 2.0 * np.pi / float(design.gear.teeth)
        turn = half_pitch(right.gear_roll - left.gear_roll, pitch)
        play = np.where(lost, lever_of(design) * turn, play)
    status = np.where(right.status != FirstStatus.SOLVED, right.status, left.status)
    return play, status.astype(np.int8)


def mounted_backlash(design: Design) -> Backlash:
    """Find the least normal backlash over a mesh cycle, with the design's errors and parabolas.

    Parameters
    ----------
    design : Design
        Members must be single; pair and errors may be arrays.

    Returns
    -------
    Backlash
        mm; negative where the pair cannot be put together. The answer for a design of plain numbers is kept.

    Raises
    ------
    ValueError
        For members of arrays.

    Notes
    -----
    SAMPLES first contacts a flank and case, and 54 more where the play changes over the cycle; its least
    value is right to 1e-6 modules.
    """
    return _backlash(design) if design.batch_shape else _kept_backlash(design)


@kept(16)
def _kept_backlash(design: Design) -> Backlash:
    return _backlash(design)


def _backlash(design: Design) -> Backlash:
    shape, pitch = design.batch_shape, 2.0 * np.pi / int(design.pinion.teeth)
    even = EVEN * float(design.pinion.tool.normal_module)
    start = np.broadcast_to(middle_roll(design, FLANKS[0]), shape)[..., None]
    roll = start + pitch * np.arange(SAMPLES) / SAMPLES
    play, status = play_at(design, roll)
    known = np.where(np.isnan(play), np.inf, play)
    beside = np.stack([np.roll(known, way, axis=-1) for way in (1, 0, -1)])
    minima = np.where(known <= beside.min(axis=0), known, np.inf)
    # Of minima equal but for rounding the first is taken.
    level = np.where(minima <= minima.min(axis=-1, keepdims=True) + even, -np.inf, minima)
    best = np.argsort(level, axis=-1, kind="stable")[..., :KEPT]
    at = np.take_along_axis(roll, best, axis=-1)
    values, step = np.take_along_axis(beside, best[None], axis=-1), pitch / SAMPLES
    for _ in range(PASSES):
        if not (values.max(axis=0) > values[1] + even).any():
            break
        at, values = _finer(design, at, values, step)
        step /= FINER
    pick = np.where(values[1] <= values[1].min(axis=-1, keepdims=True) + even, 0, 1).argmin(axis=-1)
    at, least = (np.take_along_axis(x, pick[..., None], axis=-1) for x in (at, values[1]))
    return _result(design, at, least[..., 0], status)


def _finer(design: Design, at: FloatArray, values: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Give minima (*batch, k) between finer steps, and the play (3, *batch, k) about them, from that at steps
    of roll `step`: at even finer steps, moved so that one meets the vertex of the parabola."""
    with np.errstate(invalid="ignore", divide="ignore"):  # flat, or not known beside
        away = 0.5 * step * (values[0] - values[2]) / (values[0] - 2.0 * values[1] + values[2])
    vertex = at + np.where(np.abs(away) <= 0.5 * step, away, 0.0)
    roll = vertex[..., None] + step * np.arange(-FINER, FINER + 1) / FINER
    play, _ = play_at(design, roll.reshape(*at.shape[:-1], -1))
    play = np.where(np.isnan(play), np.inf, play).reshape(roll.shape)
    best = np.clip(play.argmin(axis=-1), 1, 2 * FINER - 1)[..., None]
    around = np.stack([np.take_along_axis(play, best + way, axis=-1)[..., 0] for way in (-1, 0, 1)])
    return np.take_along_axis(roll, best, axis=-1)[..., 0], around


def _result(design: Design, roll: FloatArray, least: FloatArray, status: Codes) -> Backlash:
    """Give the backlash from the least play known, at rolls (*batch, 1), and the status of all samples."""
    first_fault = np.take_along_axis(
        status, (status != FirstStatus.SOLVED).argmax(axis=-1)[..., None], axis=-1
    )
    jammed = least < -JAMMED * float(design.pinion.tool.normal_module)
    jammed |= (status == FirstStatus.MEETS_BOTTOM).any(axis=-1)
    known = first_fault[..., 0] == FirstStatus.SOLVED
    right, left = (first_contact(design, flank, roll) for flank in FLANKS)
    return Backlash(
        normal=np.where(known, least, np.nan),
        pinion_roll=np.where(known, roll[..., 0], np.nan),
        right=right,
        left=left,
        status=first_fault[..., 0],
        jammed=np.asarray(jammed),
    )


def backlash_by_errors(design: Design) -> FloatArray:
    """Give derivatives (*batch, 4) of the least normal backlash by the assembly errors, under those that the
    design has: by offset, shaft angle, pinion's and gear's axial error; mm per mm, mm per rad.

    At its least the play stands still over the roll, so that its change is that at a held roll: an error
    moves the gear's point of contact by v against the pinion's, and the gear gives way by the turn for
    which both stay in contact, n.(v + turn k2 x r) = 0 with the normal n there. Exact; NaN where the
    backlash is not known, and where it is an edge on an edge that stops the gear."""
    found = mounted_backlash(design)
    right, left = (_turn_by_errors(design, flank, getattr(found, flank)) for flank in FLANKS)
    known = (found.status == FirstStatus.SOLVED)[..., None]
    return np.where(known, lever_of(design) * (right - left), np.nan)


def _turn_by_errors(design: Design, flank: str, first: FirstContact) -> FloatArray:
    """Give the turn of the gear (*batch, 4), rad, by which first contacts (*batch, 1) follow each error; NaN
    where edges of both members touch."""
    edge, of_gear = first.limit >= 0, first.limit % 2 == 1
    both = edge.all(axis=-1) & (of_gear[..., 0] != of_gear[..., 1])
    normal = np.where(both[..., None], np.nan, contact_normals(design, flank, first))[..., 0, :]
    turned = moved_by_gear(design, first.point)[..., 0, :]
    _, y, z = np.moveaxis(first.point[..., 0, :], -1, 0)
    layout, zero, one = layout_of(design), np.zeros_like(z), np.ones_like(z)
    sin, cos, sense = one * layout.sin_angle, one * layout.cos_angle, layout.sense
    moved = ((one, zero, zero), (zero, sense * z, -sense * y), (zero, zero, -one), (zero, sin, cos))
    along = np.stack([(normal * np.stack(v, axis=-1)).sum(axis=-1) for v in moved], axis=-1)
    return np.asarray(-along / (normal * turned).sum(axis=-1, keepdims=True))
