"""Motion of a pair: given poses, or the gear roll of the first contact of all teeth.

The motion of a tooth pair begins before its path of contact and ends after it, because flanks approach and
separate beyond the positions at which they touch."""

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
from ...status import WHY_NO_FIRST_CONTACT, FirstStatus, Status
from ..engagement import pitch_point_roll, spread
from ..mesh_cycle import MeshCycle, mesh_cycle

ROLL_DIFFERENCE_RAD = 1e-7
"""Difference of rolls from which a rate is computed."""


class UnknownOperationError(ValueError):
    """The first contact of a pair is not known; `reason` is `NotComputed` if the calculation failed."""

    def __init__(self, reason: str, cure: str = "") -> None:
        """Store the reason and the `cure`, advice for users of Python that is appended to the message."""
        self.reason = reason
        super().__init__(reason, *[cure] * bool(cure))

    def __str__(self) -> str:
        return ": ".join(self.args)


def unknown_contact(flank: str, code: int, where: str = "") -> str:
    """Return the reason why the first contact of a flank is not known.

    Parameters
    ----------
    flank : {'right', 'left'}
    code : int
        Code of its `FirstStatus`.
    where : str
        Where the first contact is not known, with a leading space: " at some rolls".

    Returns
    -------
    str
        Of the class `NotComputed` if the calculation failed.
    """
    status = FirstStatus(code)
    text = f"the first contact of the {flank} flanks is not known{where}: {WHY_NO_FIRST_CONTACT[status]}"
    return status.reason_type(text)


@dataclass(frozen=True, eq=False)
class Operation:
    """Gear roll as a function of the pinion roll.

    Attributes
    ----------
    span : tuple of float
        First and last pinion roll, rad.
    gear_roll : callable
        Gear rolls (rad) at pinion rolls (rad) of any shape.
    kinks : ndarray, shape (n,)
        Known kinks: pinion rolls at which the rate of the gear may jump, rad. On measured flanks, the motion
        of first contact may have more kinks (`MeshCycle.changes`).
    exact : callable, optional
        Function with the same result as `motion`, without finite differences.
    """

    span: tuple[float, float]
    gear_roll: Callable[[FloatArray], FloatArray]
    kinks: FloatArray = field(default_factory=lambda: np.zeros(0))
    exact: Callable[[FloatArray, FloatArray], FloatArray] | None = None

    def motion(self, roll: FloatArray, towards: FloatArray) -> FloatArray:
        """Return the gear roll (rad) and its rate over the pinion roll, (2, n), at rolls (n,), rad. At a
        kink, the rate is that on the side of the rolls `towards` (n,)."""
        if self.exact is not None:
            return self.exact(roll, towards)
        next_to = roll + np.clip(0.25 * (towards - roll), -ROLL_DIFFERENCE_RAD, ROLL_DIFFERENCE_RAD)
        here, there = self.gear_roll(np.array((roll, next_to)))
        return np.array((here, (there - here) / (next_to - roll)))


def given_operation(
    design: Design, pinion_roll: ArrayLike | None, gear_roll: ArrayLike | None
) -> Operation | None:
    """Return the motion through given poses, with a linear transmission error between them.

    Parameters
    ----------
    design : Design
        A single design.
    pinion_roll, gear_roll : array_like, shape (n,), or None
        Poses in the order of the roll, rad.

    Returns
    -------
    Operation or None
        None without poses.

    Raises
    ------
    ValueError
        For poses of one member only, or not in order.
    """
    if pinion_roll is None and gear_roll is None:
        return None
    if pinion_roll is None or gear_roll is None:
        raise ValueError("poses need the rolls of both members: give pinion_roll and gear_roll")
    roll, other = float64_of("pinion_roll", pinion_roll), float64_of("gear_roll", gear_roll)
    if roll.ndim != 1 or roll.shape != other.shape or roll.size < 2:
        limit = "have the same shape (n,) with n >= 2"
        raise ValueError(f"pinion_roll and gear_roll must {limit}, got {roll.shape}, {other.shape}")
    if not np.isfinite(roll + other).all():
        raise ValueError("pinion_roll and gear_roll must be finite: leave out poses without a result")
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
    """Return the motion of first contact of all teeth.

    It covers the path of contact of a tooth pair and half a pitch, or the overlap of helical teeth, on either
    side, and at least three pitches.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    cycle : MeshCycle, optional
        Mesh cycle of the design, or of a batch that contains it, if known.
    case : int
        Number of the design in the batch.

    Returns
    -------
    Operation

    Raises
    ------
    UnknownOperationError
        If the first contact is not known.
    """
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    # A modification changes the place of the path, but hardly the rolls at which teeth come near each other.
    ends = path_ends(design.without_modifications(), flank)
    start, stop = sorted(ends.pinion_roll.tolist())
    if ends.status != Status.SOLVED:
        start = stop = float(pitch_point_roll(design, flank))
    run_out = max(0.5, spread(design, flank)) * pitch
    reach = max(run_out, 0.5 * (3.0 * pitch - stop + start))
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
