"""Ellipse of a contact pattern.

The ellipse has the centre and the second moments of the marked area in the side view, z along the axis
against the radius r, which `analysis.path_measures` uses for paths as well. Its major axis is the line of
least squares through the area. For an elliptic area, the result is this ellipse. If the area ends at an edge
of the flank, only its marked part is used."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..operation.contact_pattern.pattern import MemberPattern

PARTS_PER_CELL = 8
"""Parts of a grid cell along each direction."""


@dataclass(frozen=True)
class MarkedEllipse:
    """Ellipse of a marked area; NaN without a marked area.

    Attributes
    ----------
    z, r : float
        Centre, mm from mid-face and mm from the axis.
    major, minor : float
        Half axes, mm.
    angle : float
        Angle of the major axis to the axial direction, rad, above -pi/2 up to pi/2; positive if z increases
        with r. NaN for a circle.
    """

    z: float
    r: float
    major: float
    minor: float
    angle: float


def marked_ellipse(side: MemberPattern, separation: float) -> MarkedEllipse:
    """Return the ellipse of the area of a pattern in which the minimum separation is within `separation`.

    The square root of the minimum separation is interpolated between the grid points, as for the area. Cells
    with a corner that has no projection on the mating flank count as unmarked.

    Parameters
    ----------
    side : MemberPattern
        Pattern on one member.
    separation : float
        Thickness of the marking compound, mm.

    Returns
    -------
    MarkedEllipse
        NaN if no cell is marked.
    """
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    root = np.sqrt(np.maximum(side.least, 0.0))
    with np.errstate(invalid="ignore"):
        z, r, root = (_finer(values) for values in (side.z, r, root))
        marked = root <= np.sqrt(separation)
    return ellipse_of(z[marked], r[marked], _amounts(side)[marked])


def ellipse_of(z: FloatArray, r: FloatArray, amount: FloatArray) -> MarkedEllipse:
    """Return the ellipse of points z, r (n), mm, that represent areas `amount` (n), mm^2."""
    # Relative difference of the semi-axes below which the ellipse is a circle.
    circle_tolerance = 1e-9
    if not z.size:
        return MarkedEllipse(*[float("nan")] * 5)
    share = amount / amount.sum()
    # Sums, because the last digit of matrix products depends on the number of threads.
    centre = (share * np.stack((z, r))).sum(axis=-1)
    away = np.stack((z, r)) - centre[:, None]
    (least, greatest), axes = np.linalg.eigh((share * away[:, None] * away).sum(axis=-1))
    # The second moments of a uniform ellipse are a quarter of the squares of its semi-axes.
    minor, major = 2.0 * np.sqrt(np.maximum((least, greatest), 0.0))
    along, up = axes[:, 1] * np.where(axes[0, 1] < 0.0, -1.0, 1.0)
    angle = np.arctan2(up, along) if major - minor > circle_tolerance * major else np.nan
    return MarkedEllipse(*map(float, (*centre, major, minor, np.pi / 2 if angle <= -np.pi / 2 else angle)))


def _finer(grid: FloatArray) -> FloatArray:
    """Return values at the centres of the parts of the cells of a grid (nl, nz), by bilinear
    interpolation."""
    share = (np.arange(PARTS_PER_CELL) + 0.5) / PARTS_PER_CELL
    for axis in (0, 1):
        low, high = np.moveaxis(grid, axis, -1)[..., :-1, None], np.moveaxis(grid, axis, -1)[..., 1:, None]
        fine = (1.0 - share) * low + share * high
        grid = np.moveaxis(fine.reshape(*fine.shape[:-2], -1), -1, axis)
    return grid


def _amounts(side: MemberPattern) -> FloatArray:
    """Return the areas (mm^2) of the parts of the cells in the side view."""
    r = np.hypot(side.points[..., 0], side.points[..., 1])
    along, up = 0.5 * (np.diff(side.z, axis=1)[1:] + np.diff(side.z, axis=1)[:-1]), np.diff(r, axis=0)
    cells = np.abs(along * 0.5 * (up[:, 1:] + up[:, :-1])) / PARTS_PER_CELL**2
    return np.repeat(np.repeat(cells, PARTS_PER_CELL, axis=0), PARTS_PER_CELL, axis=1)
