"""The rolls at which a pair operates: those given, or those of the first contact of all teeth.

A tooth pair's cycle begins before its path of contact and ends after it, as its flanks come close and part
beyond the place where they touch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...contact.path import path_ends
from ...design.field_limits import float64_of
from ...design.model import Design
from ...status import FirstStatus, Status
from ..first_contact import middle_roll, spread
from ..mesh_cycle import MeshCycle, mesh_cycle

RUN_OUT, LEAST_CYCLE = 0.5, 3.0
"""Pitches before and after the path of contact that belong to the cycle; its least length, pitches."""
STEP = 1e-7
"""rad between rolls of which the difference gives a rate."""


class UnknownOperationError(ValueError):
    """The first contact of a pair is not known, whatever is asked of it, for a `reason`."""

    def __init__(self, reason: str, cure: str = "") -> None:
        """Take the reason, and the cure from Python, which the message adds."""
        self.reason = reason
        super().__init__(reason, *[cure] * bool(cure))

    def __str__(self) -> str:
        return ": ".join(self.args)


def unknown_contact(flank: str, code: int, where: str = "") -> str:
    """Say that the first contact of flanks is not known, and why: the `code` of its FirstStatus."""
    status = FirstStatus(code).name.lower().replace("_", " ")
    return f"the first contact of the {flank} flanks is not known{where} ({status})"


@dataclass(frozen=True, eq=False)
class Operation:
    """Gear rolls (rad) as a function of pinion rolls (rad, any shape) over a `span` (rad) of these, smooth
    between `kinks` (n,), rad, as far as they are known."""

    span: tuple[float, float]
    gear_roll: Callable[[FloatArray], FloatArray]
    kinks: FloatArray = field(default_factory=lambda: np.zeros(0))
    exact: Callable[[FloatArray, FloatArray], FloatArray] | None = None

    def motion(self, roll: FloatArray, towards: FloatArray) -> FloatArray:
        """Give the gear's roll (rad) and its rate over the pinion's (2, n) at rolls (n,), rad: the `exact`
        ones, if known, or by differences. At a kink it is the rate on the side `towards` (n,)."""
        if self.exact is not None:
            return self.exact(roll, towards)
        beside = roll + np.minimum(np.maximum(0.25 * (towards - roll), -STEP), STEP)
        here, there = self.gear_roll(np.array((roll, beside)))
        return np.array((here, (there - here) / (beside - roll)))


def given_operation(
    design: Design, pinion_roll: ArrayLike | None, gear_roll: ArrayLike | None
) -> Operation | None:
    """Give the operation through given poses of a single design (n,), rad, in the order of the roll, with an
    even transmission error between them; None without any. Raises ValueError for poses of one member only or
    without an order."""
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
    ratio = float(design.pinion.teeth) / float(design.gear.teeth)
    phase = other + ratio * roll
    span = float(roll[0]), float(roll[-1])
    return Operation(span, lambda rolls: np.interp(rolls, roll, phase) - ratio * rolls, roll[1:-1])


def first_contact_operation(
    design: Design, flank: str, cycle: MeshCycle | None = None, case: int = 0
) -> Operation:
    """Give operating rolls by the first contact of all teeth, over a tooth pair's path of contact and half a
    pitch or the face's spread either way, three pitches at least. `cycle`: the mesh cycle of the design, or
    of a batch of which it is the `case`, if it is known. Raises ValueError where the first contact is not."""
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    ends = path_ends(design, flank)
    start, stop = sorted(ends.pinion_roll.tolist())
    if ends.status != Status.SOLVED:
        start = stop = float(middle_roll(design, flank))
    run_out = max(RUN_OUT, spread(design, flank)) * pitch
    reach = max(run_out, 0.5 * (LEAST_CYCLE * pitch - stop + start))
    start, stop = start - reach, stop + reach
    cycle = mesh_cycle(design, flank, 1) if cycle is None else cycle
    code, first = cycle.status.flat[case], cycle.start.flat[case]
    if code != FirstStatus.SOLVED:
        reason = unknown_contact(flank, int(code), " at some rolls")
        raise UnknownOperationError(reason, "give pinion_roll and gear_roll")
    turns = np.arange(np.floor((start - first) / pitch), np.ceil((stop - first) / pitch))
    changes = cycle.changes.reshape(cycle.start.size, -1)[case]
    kinks = (changes[~np.isnan(changes)] + pitch * turns[:, None]).ravel()
    gear_roll = partial(cycle.gear_roll, case=case)
    kinks = kinks[(kinks > start) & (kinks < stop)]
    return Operation((start, stop), gear_roll, kinks, cycle.motion(case))
