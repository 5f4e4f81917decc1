"""The rolls at which a pair operates, to be interpolated: given ones, or those of the first contact.

A tooth pair's cycle begins before its path of contact and ends after it, as its flanks come close
and part beyond the place where they touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..contact.path import path_ends
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import FirstStatus, Status
from .first_contact import first_contact, middle_roll, spread

RUN_OUT, LEAST_CYCLE = 0.5, 3.0
"""Pitches before and after the path of contact that belong to the cycle; its least length, pitches."""
ROLLS, PASSES = 32, 2
"""Rolls over a pitch at which the first contact is found, and how often their steps are made finer
where its carrier changes; most of the time goes there. Linear between, the separation is right
to some 2e-6 mm where flanks carry and 1e-4 mm where edges do."""
FINER = 4
"""How much finer steps are made where a change is looked for."""


class UnknownOperationError(ValueError):
    """At some rolls the first contact of a pair is not known, whatever is asked of it, for a `reason`."""

    def __init__(self, reason: str) -> None:
        """Take the reason; the message adds the cure from Python."""
        self.reason = reason
        super().__init__(reason)

    def __str__(self) -> str:
        return f"{self.reason}: give pinion_roll and gear_roll"


@dataclass(frozen=True, eq=False)
class Operation:
    """Gear roll plus N1/N2 times the pinion's, `phase` (n,), rad, at rising pinion rolls `roll` (n,)."""

    roll: FloatArray
    phase: FloatArray

    def gear_roll(self, design: Design, roll: FloatArray) -> FloatArray:
        """Gear rolls (rad) at pinion rolls, by interpolation."""
        return np.interp(roll, self.roll, self.phase) - _ratio(design) * roll


def given_operation(
    design: Design, pinion_roll: ArrayLike | None, gear_roll: ArrayLike | None
) -> Operation | None:
    """The operation through given poses of a single design (n,), rad, in the order of the roll; None
    without any. Raises ValueError for poses of one member only or without an order."""
    if pinion_roll is None and gear_roll is None:
        return None
    if pinion_roll is None or gear_roll is None:
        raise ValueError("poses need the rolls of both members: give pinion_roll and gear_roll")
    roll, other = float64_of("pinion_roll", pinion_roll), float64_of("gear_roll", gear_roll)
    if roll.ndim != 1 or roll.shape != other.shape or roll.size < 2:
        raise ValueError(
            f"rolls must be two arrays (n,) of two poses or more, got {roll.shape}, {other.shape}"
        )
    if not np.isfinite(roll + other).all():
        raise ValueError("rolls must be finite: leave out poses without an answer")
    if roll[0] > roll[-1]:
        roll, other = roll[::-1], other[::-1]
    if not (np.diff(roll) > 0.0).all():
        raise ValueError("pinion_roll must rise or fall from pose to pose")
    return Operation(roll, other + _ratio(design) * roll)


def _ratio(design: Design) -> float:
    return float(design.pinion.teeth) / float(design.gear.teeth)


def first_contact_operation(design: Design, flank: str) -> Operation:
    """Operating rolls by the first contact of all teeth, over a tooth pair's path of contact and
    half a pitch or the face's spread either way, three pitches at least. Raises ValueError where the first
    contact is not known."""
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    ends = path_ends(design, flank)
    start, stop = sorted(ends.pinion_roll.tolist())
    if ends.status != Status.SOLVED:
        start = stop = float(middle_roll(design, flank))
    run_out = max(RUN_OUT, spread(design, flank)) * pitch
    reach = max(run_out, 0.5 * (LEAST_CYCLE * pitch - stop + start))
    start, stop = start - reach, stop + reach
    known, phase = _resolved_phase(design, flank, start, pitch)
    repeated = (known + pitch * np.arange(np.ceil((stop - start) / pitch))[:, None]).ravel()
    roll = np.append(np.sort(repeated[repeated < stop]), stop)
    return Operation(roll, np.interp(roll, known, phase, period=pitch))


def _resolved_phase(design: Design, flank: str, start: float, pitch: float) -> tuple[FloatArray, FloatArray]:
    """Rolls over a pitch, denser where the carrier of the first contact changes, and the phase there."""
    added, step, rows = start + pitch * np.arange(ROLLS) / ROLLS, pitch / ROLLS, np.empty((6, 0))
    for _ in range(PASSES + 1):
        first = first_contact(design, flank, added)
        phase = first.gear_roll + _ratio(design) * added
        rows = np.hstack((rows, np.vstack((added, phase, first.pair, first.limit.T, first.status))))
        rows = rows[:, np.argsort(rows[0])]
        beyond = np.append(rows[0, 1:], rows[0, 0] + pitch) - rows[0]
        following = np.roll(rows[2:5], -1, axis=1)
        following[0, -1] -= 1.0  # a pitch later the same contact is that of the pair before
        changes = (rows[2:5] != following).any(axis=0) & (beyond > 0.5 * step)
        added = (rows[0, changes, None] + np.outer(beyond[changes], np.arange(1, FINER) / FINER)).ravel()
        step = step / FINER
        if not added.size:
            break
    unknown = rows[5, rows[5] != FirstStatus.SOLVED]
    if unknown.size:
        status = FirstStatus(int(unknown[0])).name.lower().replace("_", " ")
        raise UnknownOperationError(
            f"the first contact of the {flank} flanks is not known at {unknown.size} of {len(rows[0])} rolls"
            f" ({status})"
        )
    return rows[0], rows[1]
