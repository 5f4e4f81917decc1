"""The ellipse nearest to what marking compound leaves on a flank.

It has the centre and the second moments of the marked area in the side view, z along the axis (toe to heel)
against the radius r, in which paths are measured, too (`analysis.path_measures`). Its major axis is the line
of least squares through the area; a marked ellipse is its own. Of an area that ends at an edge of the flank
only what is marked counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..operation.marking.pattern import MemberPattern

FINER = 8
"""Parts into which a cell of a pattern's grid is divided either way."""
ROUND = 1e-9
"""Share by which the half axes differ at least, for the major one to have a direction."""


@dataclass(frozen=True)
class MarkedEllipse:
    """Centre `z`, mm from mid-face towards the heel, and `r`, mm from the axis; half axes `major`, `minor`,
    mm; `angle` (rad, above -pi/2, up to pi/2) of the major axis to the axial direction, positive if z rises
    with r. NaN where nothing is marked, the angle also of a circle."""

    z: float
    r: float
    major: float
    minor: float
    angle: float


def marked_ellipse(side: MemberPattern, separation: float) -> MarkedEllipse:
    """Find the ellipse of the area of a pattern where the least separation is within `separation`, mm.

    The root of the least separation is interpolated between the points of the grid, as for the area; cells
    at a corner of which there is no foot on the mate count as bare."""
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    root = np.sqrt(np.maximum(side.least, 0.0))
    with np.errstate(invalid="ignore"):
        z, r, root = (_finer(values) for values in (side.z, r, root))
        marked = root <= np.sqrt(separation)
    return ellipse_of(z[marked], r[marked], _amounts(side)[marked])


def ellipse_of(z: FloatArray, r: FloatArray, amount: FloatArray) -> MarkedEllipse:
    """Find the ellipse of points z, r (n), mm, that stand for an area `amount` (n), mm^2."""
    if not z.size:
        return MarkedEllipse(*[float("nan")] * 5)
    share = amount / amount.sum()
    # Sums, not products of matrices, the last digit of which depends on the machine's threads.
    centre = (share * np.stack((z, r))).sum(axis=-1)
    away = np.stack((z, r)) - centre[:, None]
    (least, greatest), ways = np.linalg.eigh((share * away[:, None] * away).sum(axis=-1))
    # A uniform ellipse has a quarter of the squares of its half axes as second moments.
    minor, major = 2.0 * np.sqrt(np.maximum((least, greatest), 0.0))
    along, up = ways[:, 1] * np.where(ways[0, 1] < 0.0, -1.0, 1.0)
    angle = np.arctan2(up, along) if major - minor > ROUND * major else np.nan
    return MarkedEllipse(*map(float, (*centre, major, minor, np.pi / 2 if angle <= -np.pi / 2 else angle)))


def _finer(grid: FloatArray) -> FloatArray:
    """Give values in the middles of the parts of the cells of a grid (nl, nz), linear between its points."""
    share = (np.arange(FINER) + 0.5) / FINER
    for axis in (0, 1):
        low, high = np.moveaxis(grid, axis, -1)[..., :-1, None], np.moveaxis(grid, axis, -1)[..., 1:, None]
        fine = (1.0 - share) * low + share * high
        grid = np.moveaxis(fine.reshape(*fine.shape[:-2], -1), -1, axis)
    return grid


def _amounts(side: MemberPattern) -> FloatArray:
    """Give the areas (mm^2) in the side view of the parts of the cells."""
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    along, up = 0.5 * (np.diff(side.z, axis=1)[1:] + np.diff(side.z, axis=1)[:-1]), np.diff(r, axis=0)
    cells = np.abs(along * 0.5 * (up[:, 1:] + up[:, :-1])) / FINER**2
    return np.repeat(np.repeat(cells, FINER, axis=0), FINER, axis=1)
