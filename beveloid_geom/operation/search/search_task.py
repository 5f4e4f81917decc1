"""Tooth pairs at pinion rolls whose clearance is evaluated, and points of the pinion seen by the gear."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.tooth_side import Bends, Cut, ToothSurface, cut_at, tangents_of
from ..angular_clearance import AxisPositions

OVERLAP_PERIODS = 0.25
"""A pinion tooth forms a tooth pair again after one period (`Task.period`). The clearance is searched over
one period: this fraction of it as overlap (negative), the remainder as clearance."""


@dataclass(frozen=True, eq=False)
class Task:
    """Tooth pairs (n,) whose clearance is evaluated, with their pinion rolls and axes.

    Attributes
    ----------
    pinion, gear : ToothSurface
        Tooth surfaces of pinion and gear.
    lever : float
        Clearance along the normal per rad of gear roll, g of `local_clearance`, mm.
    axes : AxisPositions
        (n,), or (1,) if they are the same for all tooth pairs.
    roll, start : ndarray, shape (n,)
        Pinion roll, and reference roll T0 of the gear, rad.
    period : float
        Rotation of the gear after which a pinion tooth forms a tooth pair again, rad (`Engagement.period`).
    line : ndarray, shape (4, n), optional
        For flanks that touch along lines: f on the line, s1 and z1 of the path of contact across the lines
        (mm), and the position along this path, from 0 (the tooth pair comes into mesh) to 1. NaN for point
        contact.
    fillet : ndarray of bool, shape (2, n), optional
        For undercut teeth: whether contacts are sought on the fillet of pinion and gear instead of the flank.
    reliefs : tuple of ndarray of bool, shape (reliefs, n), optional
        Which reliefs of pinion and gear apply, also beyond their beginning. If omitted, those that have
        begun.
    """

    pinion: ToothSurface
    gear: ToothSurface
    lever: float
    axes: AxisPositions
    roll: FloatArray
    start: FloatArray
    period: float = 2.0 * np.pi
    line: FloatArray | None = None
    fillet: Mask | None = None
    reliefs: tuple[Mask, Mask] | None = None

    @property
    def edged(self) -> bool:
        """Return whether undercut ends a flank of either member at an edge."""
        return self.pinion.crossing is not None or self.gear.crossing is not None

    @property
    def depth(self) -> float:
        """Return the tooth depth of the pinion, mm, the unit of small lengths."""
        return self.pinion.tip - self.pinion.root

    def pick(self, index: Integers) -> Task:
        """Return the tasks `index`."""
        pinion, gear, lever, axes, roll, start, period, line, fillet, reliefs = vars(self).values()
        line = None if line is None else line.take(index, axis=1)
        fillet = None if fillet is None else fillet[:, index]
        reliefs = None if reliefs is None else tuple(rows[:, index] for rows in reliefs)
        turns = roll.take(index), start.take(index)
        return Task(pinion, gear, lever, axes.at(index), *turns, period, line, fillet, reliefs)

    def with_fillets_at(self, place: FloatArray) -> Task:
        """Return the tasks with `fillet` set for the places (2, n): flank or fillet of undercut teeth."""
        if not self.edged:
            return self
        s, z = place
        x, y, high = seen_by_gear(self, z, cut_at(self.pinion, s, z))[:, 0]
        fillet = np.zeros((2, z.size), dtype=bool)
        fillet[0] = self.pinion.on_fillet(s, z)
        if self.gear.crossing is not None:
            fillet[1] = x * x + y * y < self.gear.crossing.radius(high) ** 2
        return replace(self, fillet=fillet)

    @property
    def earliest(self) -> float:
        """Return the smallest clearance angle of a search over one period, rad; negative for overlap."""
        return -OVERLAP_PERIODS * self.period

    def counted(self, angle: FloatArray) -> FloatArray:
        """Return angles (rad) of plus or minus half a turn, with one turn added to those below
        -pi - `earliest`."""
        least = -np.pi - self.earliest
        return np.where(angle < least, angle + 2.0 * np.pi, angle)

    def later(self, periods: Integers) -> Task:
        """Return the tasks with the reference roll moved on by a number of `periods` (n,)."""
        return replace(self, start=self.start + self.period * periods)


def seen_by_gear(task: Task, z: FloatArray, cut: Cut, bends: Bends | None = None) -> FloatArray:
    """Return the pinion's points in the gear's frame, with derivatives.

    Parameters
    ----------
    task : Task
    z : ndarray, shape (n,)
        Distances from the pinion's mid-face, mm.
    cut : Cut
        Points of the pinion's surface.
    bends : Bends, optional
        Their second derivatives.

    Returns
    -------
    ndarray, shape (3, 3, n) or (3, 6, n)
        x, y and z2, mm, with derivatives by s1, z1 and, with `bends`, s1 s1, s1 z1 and z1 z1.
    """
    axes, turned = task.axes, cut.phi + task.roll
    x, y = tangents_of(cut, bends).swapaxes(0, 1)
    # Rotate by the pinion roll, then transform to the gear's frame (`seen_by_other`).
    cos, sin = np.cos(turned), np.sin(turned)
    across = sin * x + cos * y
    seen = np.empty((3, *x.shape))
    np.subtract(sin * y, cos * x, out=seen[0])
    np.multiply(-axes.cos, across, out=seen[1])
    np.multiply(axes.sin, across, out=seen[2])
    seen[0, 0] += axes.offset  # only the points themselves, and z, are shifted
    ahead = z + axes.position[0]
    seen[1, 0] += axes.sin * ahead
    # As in `seen_by_other`, without the rounding of large positions.
    seen[2, 0] += z + (axes.position[0] - axes.position[1] - axes.versine * ahead)
    seen[1, 2] += axes.sin
    seen[2, 2] += axes.cos
    return seen
