"""Contact pattern: region in which the separation of the flanks is below the thickness of marking compound.

While a tooth pair passes through the mesh, each point of a flank has a minimum separation from the mating
flank. The pattern is the region in which it is below a given thickness. For a pair without transmission
error, the minimum separation is the ease-off of the flank from the surface that the mate generates.

The separation is the exact distance to the mating flank (`gear.closest_point`). It counts while the foot of
the perpendicular lies on that flank. `minimum_separation` computes its minimum over the roll. Grid points and
borders of areas are evaluated only near those samples of the roll at which a coarser grid has local minima.

The motion is given, or it is the motion of the first contact of all teeth, edges included (`mesh_cycle`). In
the latter case, the minimum separation is not negative, apart from rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Codes, FloatArray, Integers, Mask
from ...contact.ellipse import MARKING_SEPARATION_MM
from ...design.arguments import require_numbers, require_single
from ...design.member import Member
from ...design.model import Design
from ...gear.active_flank import place_at
from ...gear.flank import flank_point
from ...status import PatternStatus
from ...support.argument import ArgumentError
from ...support.array_repr import short_repr
from ...support.marked_area import marked_area
from .mating import Mating, mating_of, rounded_up
from .minimum_separation import MinimumSeparation, minimum_separation, separation_samples
from .motion import Operation, first_contact_operation, given_operation

CELLS = ((24, 32), (250, 250))
"""Minimum and maximum number of cells along depth and face. The minimum resolves the strip at the root that
the mating tip does not reach."""
COARSE_CELLS = 12, 16
"""Cells at whose corners the separation is sampled over all rolls."""
RELATIVE_AREA_ERROR = 0.01
"""Default relative error of areas."""


@dataclass(frozen=True, eq=False)
class MemberPattern:
    """Pattern on the flank of one member; arrays (nl, nz) over depth and face, from root and toe.

    Attributes
    ----------
    l, z : ndarray
        Profile coordinate and distance from mid-face, mm.
    points : ndarray, shape (nl, nz, 3)
        In the frame that rotates with the member, mm.
    least : ndarray
        Minimum separation, mm, negative for overlap.
    pinion_roll : ndarray
        Roll at which it occurs, rad.
    marked : ndarray of bool
        Whether it is within the separation of the pattern.
    status : ndarray of int
        Codes of `PatternStatus`.
    area, area_share : float
        Marked area, mm^2, and its fraction of the active flank.
    area_error : float
        Bound on the relative error of both, independent of the grid.
    border : tuple of ndarray, shape (n, 3)
        Closed polygons around the marked area, in the frame that rotates with the member, mm. They are
        refined until the area has the requested error.
    """

    __repr__ = short_repr

    l: FloatArray
    z: FloatArray
    points: FloatArray
    least: FloatArray
    pinion_roll: FloatArray
    marked: Mask
    status: Codes
    area: float
    area_share: float
    area_error: float
    border: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class ContactPattern:
    """Contact pattern of one flank pair on `pinion` and `gear`, for a `separation` (mm), over the pinion
    rolls of `roll_range` (rad)."""

    __repr__ = short_repr

    flank: str
    separation: float
    roll_range: tuple[float, float]
    pinion: MemberPattern
    gear: MemberPattern

    @property
    def ends(self) -> Mask:
        """Edges at which the pattern ends, (8,), in the order of `Limit`: those with a marked grid point."""
        rims = [
            [marked[0], marked[-1], marked[:, 0], marked[:, -1]]
            for marked in (self.pinion.marked, self.gear.marked)
        ]
        return np.array([[rim.any() for rim in of_member] for of_member in rims]).T.reshape(-1)


def contact_pattern(
    design: Design,
    flank: str = "right",
    separation: float = MARKING_SEPARATION_MM,
    *,
    resolution: float | None = None,
    tolerance: float | None = None,
    area_error: float = RELATIVE_AREA_ERROR,
    pinion_roll: ArrayLike | None = None,
    gear_roll: ArrayLike | None = None,
    operation: Operation | None = None,
) -> ContactPattern:
    """Compute the contact pattern: the region in which marking compound is displaced in one tooth engagement.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    separation : float
        Thickness of the compound, mm.
    resolution : float, optional
        Distance of the grid points, mm.
    tolerance : float, optional
        Required error of the minimum separation interpolated between grid points, mm. The number of cells is
        estimated where the minimum is stationary and at most four times the separation. It is limited to 250
        in each direction, so that a small tolerance may not be reached. If neither `resolution` nor
        `tolerance` is given, the tolerance is a twentieth of the separation.
    area_error : float
        Relative error of each area, independent of the grid. `MemberPattern.area_error` is the bound that was
        reached; it is larger only if the refinement of the border had to stop.
    pinion_roll, gear_roll : array_like, shape (n), optional
        Rolls of both members in the order of the roll, rad; between them the transmission error is linear. If
        omitted, the rolls of first contact are used.
    operation : Operation, optional
        Motion of first contact, if known (`first_contact_operation`).

    Returns
    -------
    ContactPattern

    Raises
    ------
    ValueError
        For a batch; for lengths or an area error that are not positive or too small; if rolls are given for
        one member only; or if the first contact is not known.

    References
    ----------
    Definition and method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> pattern = bg.contact_pattern(bg.builtin_design("ni-2017"))
    >>> pattern.pinion.l.shape == pattern.pinion.marked.shape
    True
    """
    _check(design, separation, resolution, tolerance, area_error)
    operation = given_operation(design, pinion_roll, gear_roll) or operation
    operation = operation or first_contact_operation(design, flank)
    patterns = []
    for number, member in enumerate(design.members):
        side = _side_of(member, flank, mating_of(design, flank, number, operation))
        smallest_grid = _sampled_on(side, CELLS[0])
        if resolution is not None:
            cells = _cells_of_size(member, resolution)
        else:
            error = separation / 20.0 if tolerance is None else tolerance
            cells = _cells_within(smallest_grid, error, 4.0 * separation)
        # The area is always computed from the smallest grid: it does not depend on the points of the output.
        grid = smallest_grid if cells == CELLS[0] else _sampled_on(side, cells)
        patterns.append(_member_pattern(side, grid, smallest_grid, separation, area_error))
    return ContactPattern(flank, separation, operation.span, *patterns)


def _check(
    design: Design, separation: float, resolution: float | None, tolerance: float | None, area_error: float
) -> None:
    # Smallest relative error of areas that can be requested.
    min_area_error = 1e-3
    require_single(design)
    require_numbers(separation=separation, resolution=resolution, tolerance=tolerance, area_error=area_error)
    if resolution is not None and tolerance is not None:
        raise ValueError("give resolution or tolerance, not both")
    lengths = {"separation": separation, "resolution": resolution, "tolerance": tolerance}
    for name, length in lengths.items():
        if length is not None and not 0.0 < length < np.inf:
            raise ValueError(f"{name} must be a positive length in mm, got {length:g}")
    if not min_area_error <= area_error < 1.0:
        raise ValueError(f"area_error must be at least {min_area_error:g} and below 1, got {area_error:g}")


@dataclass(frozen=True, eq=False)
class _Side:
    """Flank of a member and its `mating` with the other; `reach` (2, nl, nz): first and last sample near
    which the minimum separation is, on the grid of `COARSE_CELLS`."""

    member: Member
    flank: str
    mating: Mating
    reach: Integers

    def at(self, depth: FloatArray, face: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return l, z (...) and points (..., 3) at fractions of the depth from the root and of the face
        from the toe."""
        l, z, u = place_at(self.member, self.flank, depth, face)
        return l, z, flank_point(self.member, self.flank, l, u)

    def least(self, points: FloatArray, share: FloatArray) -> MinimumSeparation:
        """Return the minimum separations of points (n, 3) at places (n, 2) of the unit square, searched
        near the samples of the corners of the surrounding coarse cells."""
        place, each = share * COARSE_CELLS, np.arange(self.mating.rolls.size)[:, None]
        (i, j), (m, n) = np.floor(place + 1e-9).astype(int).T, np.ceil(place - 1e-9).astype(int).T
        first, last = self.reach[:, (i, i, m, m), (j, n, j, n)]
        near = (each >= first.min(axis=0)) & (each <= last.max(axis=0))
        return minimum_separation(self.mating, points, separation_samples(self.mating, points, near))


def _side_of(member: Member, flank: str, mating: Mating) -> _Side:
    """Return a side, with every other sample computed on the coarse grid."""
    side = _Side(member, flank, mating, np.empty((2, 0, 0), dtype=np.int64))
    depth, face = (np.linspace(0.0, 1.0, n + 1) for n in COARSE_CELLS)
    _, _, points = side.at(depth[:, None], face)
    alternate = replace(mating, rolls=np.append(mating.rolls[:-1:2], mating.rolls[-1]))
    near = separation_samples(alternate, points.reshape(-1, 3)).near
    ends = 2 * near.argmax(axis=0) - 2, 2 * (len(near) - near[::-1].argmax(axis=0))
    reach = np.clip(ends, 0, mating.rolls.size - 1).reshape(2, *points.shape[:2])
    return replace(side, reach=reach)


@dataclass(frozen=True, eq=False)
class _Grid:
    """Arrays of `MemberPattern` that do not depend on the thickness of the compound."""

    l: FloatArray
    z: FloatArray
    points: FloatArray
    least: FloatArray
    pinion_roll: FloatArray
    status: Codes


def _sampled_on(side: _Side, cells: tuple[int, int]) -> _Grid:
    """Return the minimum separations on a grid that is evenly spaced in depth and face."""
    depth, face = (np.linspace(0.0, 1.0, n + 1) for n in cells)
    l, z, points = side.at(depth[:, None], face)
    share = np.stack(np.meshgrid(depth, face, indexing="ij"), axis=-1)
    minimum = side.least(points.reshape(-1, 3), share.reshape(-1, 2))
    least, roll, status = (values.reshape(l.shape) for values in vars(minimum).values())
    return _Grid(l, z, points, least, roll, status)


def _cells_of_size(member: Member, resolution: float) -> tuple[int, int]:
    max_points = 1_000_000
    depth = 2.0 * float(member.tip_height * np.asarray(member.tool.normal_module))
    face = float(member.face_width)
    cells = rounded_up(depth / resolution), rounded_up(face / resolution)
    if (cells[0] + 1) * (cells[1] + 1) > max_points:
        # (depth / x + 2) (face / x + 2) = max_points, with the cells rounded up
        half, number = depth + face, max_points - 4
        least = (half + math.sqrt(half**2 + number * depth * face)) / number
        text = f"{resolution:g} mm needs more than {max_points:,} points"
        raise ArgumentError("resolution", f"{text}: give at least {1.005 * least:.3g} mm")
    return cells


def _cells_within(grid: _Grid, tolerance: float, highest: float) -> tuple[int, int]:
    """Return the cells of a grid on which the interpolated minimum separation has an error of about
    `tolerance`, half of it from each direction, estimated from second differences of the smallest grid where
    the minimum is stationary and at most `highest`."""
    counts = []
    table = np.where((grid.status == PatternStatus.STANDSTILL) & (grid.least <= highest), grid.least, np.nan)
    for axis in (0, 1):
        values = np.moveaxis(table, axis, 0)
        bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
        bend = bend[np.isfinite(bend)]
        count = CELLS[0][axis] * np.sqrt(bend.max(initial=0.0) / (8.0 * 0.5 * tolerance))
        counts.append(int(np.clip(np.ceil(count), CELLS[0][axis], CELLS[1][axis])))
    return counts[0], counts[1]


def _member_pattern(
    side: _Side, grid: _Grid, smallest_grid: _Grid, separation: float, area_error: float
) -> MemberPattern:
    """Return the pattern on a `grid`, with the area from the `smallest_grid`. The border is interpolated in
    the square root of the minimum separation, which is nearly linear next to the path of contact and
    past the reach of the mating edge."""

    def excess(least: FloatArray) -> FloatArray:
        return np.where(np.isnan(least), np.inf, np.sqrt(np.maximum(least, 0.0)) - np.sqrt(separation))

    def excess_at(share: FloatArray) -> FloatArray:
        *_, points = side.at(*share.T)
        return excess(side.least(points, share).least)

    marked = marked_area(excess_at, excess(smallest_grid.least), smallest_grid.points, area_error)
    return MemberPattern(
        **vars(grid),
        marked=grid.least <= separation,
        area=marked.area,
        area_share=marked.area / marked.total,
        area_error=marked.error,
        border=tuple(side.at(*polygon.T)[2] for polygon in marked.border),
    )
