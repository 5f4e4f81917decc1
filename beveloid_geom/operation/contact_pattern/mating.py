"""Motion of one member relative to the mating flank, and the distance of its points from this flank."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...design.model import Design
from ...gear.closest_point import FlankSheet, foot_on, sheet_of
from ...support.frozen_arrays import read_only
from ..angular_clearance import AxisPositions, axes_of, seen_by_other
from .motion import Operation

POSES_PER_PITCH = 10
"""Poses per pitch at which the separation is sampled."""
LAST_STEP_MODULES = 1e-4
"""Newton step (modules) towards a foot of a perpendicular below which the step is the last. The remaining
error of the foot is of the order of the square of this step, divided by a radius of curvature. The distance
is stationary at the foot, so that the error of the distance is smaller still: 1e-9 mm."""
DISTANCE, MARGIN = 0, 1
"""Rows of the state of a point at a pose: distance from the mating flank and margin of the foot within it,
mm. Rows 2 and 3 are the derivatives of the distance by the rolls of the member and of the mate, mm/rad."""


@dataclass(frozen=True, eq=False)
class Mating:
    """Motion `operation` of `member` (0 pinion, 1 gear) relative to the mate's flank `sheet`.

    `rolls` (k,): sampled pinion rolls, rad. They include the known kinks of the motion."""

    member: int
    sheet: FlankSheet
    axes: AxisPositions
    operation: Operation
    rolls: FloatArray

    def at(self, points: FloatArray, turned: FloatArray) -> FloatArray:
        """Return the rows (4, n) of points (n, 3), in the frame of their member, at poses `turned` (4, n)."""
        # Points of one block, so that the arrays stay in the cache.
        points_per_block = 4096
        rows = np.empty((4, len(points)))
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            for first in range(0, len(points), points_per_block):
                part = slice(first, first + points_per_block)
                rows[:, part] = self._rows(points[part].T.copy(), turned[:, part])
        return rows

    def distance_on_flank(self, rows: FloatArray) -> FloatArray:
        """Return the distances (n,) of rows (4, n), infinite where the foot is not on the mating flank."""
        return np.where(rows[MARGIN] >= 0.0, rows[DISTANCE], np.inf)

    def turned(self, roll: FloatArray, gear_roll: FloatArray) -> FloatArray:
        """Return the poses at rolls of pinion and gear (n,), rad: cosine and sine of the rolls of the
        member and of the mate, (4, n)."""
        both = roll, gear_roll
        moving, mate = both[self.member], both[1 - self.member]
        return np.array((np.cos(moving), np.sin(moving), np.cos(mate), np.sin(mate)))

    @cached_property
    def poses(self) -> FloatArray:
        """Return the poses at the sampled rolls, (4, k)."""
        return read_only(self.turned(self.rolls, self.operation.gear_roll(self.rolls)))

    def _rows(self, points: FloatArray, turned: FloatArray) -> tuple[FloatArray, ...]:
        # Distance past an edge of the mating flank up to which a foot counts as on it. Equal faces
        # on parallel axes have common ends, where a foot is on the mating flank only at the instant
        # of contact.
        edge_tolerance_modules = 1e-6
        (x, y, z), (cos, sin, mate_cos, mate_sin), axes = points, turned, self.axes
        x, y = cos * x - sin * y, sin * x + cos * y
        seen, moves = seen_by_other(axes, self.member, x, y, z), (y, -axes.cos * x, axes.sin * x)
        (x, y, z), (u, v, w) = (
            (mate_cos * a + mate_sin * b, mate_cos * b - mate_sin * a, c) for a, b, c in (seen, moves)
        )
        foot = foot_on(self.sheet, (x, y, z), last_step=LAST_STEP_MODULES)
        margin = foot.margin + edge_tolerance_modules * np.asarray(self.sheet.module)
        nx, ny, nz = foot.normal
        return foot.distance, margin, u * nx + v * ny + w * nz, -foot.moment

    def slope(self, rows: FloatArray, gear_rate: FloatArray) -> FloatArray:
        """Return df/droll (n,), mm per rad of pinion roll, from rows (4, n) and the rate of the gear."""
        moving, mate = (1.0, gear_rate) if self.member == 0 else (gear_rate, 1.0)
        return np.asarray(moving * rows[2] + mate * rows[3])


def mating_of(design: Design, flank: str, member: int, operation: Operation) -> Mating:
    """Return the motion of a member relative to the mating flank.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    member : int
        0 pinion, 1 gear.
    operation : Operation

    Returns
    -------
    Mating
    """
    sheet = sheet_of(design.members[1 - member], flank)
    return Mating(member, sheet, axes_of(design), operation, sampled_rolls(design, operation))


def sampled_rolls(design: Design, operation: Operation) -> FloatArray:
    """Return the pinion rolls at which the separation is sampled.

    Parameters
    ----------
    design : Design
    operation : Operation

    Returns
    -------
    ndarray, shape (n,)
        rad; evenly spaced over the motion, and its kinks.
    """
    pitches = (operation.span[1] - operation.span[0]) * float(design.pinion.teeth) / (2.0 * np.pi)
    even = np.linspace(*operation.span, max(rounded_up(POSES_PER_PITCH * pitches) + 1, 3))
    return np.union1d(even, operation.kinks)


def rounded_up(number: float) -> int:
    """Round a number up, with a tolerance for rounding errors.

    Parameters
    ----------
    number : float

    Returns
    -------
    int
    """
    return int(np.ceil(number - 1e-12 * number))
