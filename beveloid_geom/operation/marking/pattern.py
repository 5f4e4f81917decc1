"""Contact pattern: where the flanks come closer than the marking compound is thick.

While a tooth pair rolls through the mesh, every point of a flank has its least separation from the
mating flank. The pattern is the region in which it stays below a given thickness; for a pair without
transmission error the least separation is the ease-off of the one flank against the surface that
the other one generates.

The separation is the exact distance to the mating flank (`perpendicular.feet`), counted while the foot
lies on that flank, and `least_over_roll` finds its least over the roll. Grids, and borders of areas, are
looked at only near those samples of the roll at which a coarser grid has local least values.

The gear's roll at a pinion roll is given, or that of the first contact of all teeth, edges included
(`mesh_cycle`). The least separation is then positive but for rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Codes, FloatArray, Integers, Mask
from ...contact.ellipse import MARKING_SEPARATION
from ...design.model import Design, Member
from ...gear.flank import flank_point, place_at
from ...status import PatternStatus
from ...support.few_lines import few_lines
from ...support.marked_area import marked_area
from .least_over_roll import LeastSeparation, Mating, least_separation, mating_of, sampled, whole
from .operating_rolls import Operation, first_contact_operation, given_operation

CELLS = ((24, 32), (250, 250))
"""Least and greatest numbers of cells along depth and face. The least resolves the strip along a
flank's root that the mating tip does not reach."""
COARSE = 12, 16
"""Cells on whose corners samples are taken over all rolls."""
AREA_ERROR = 0.01
"""Relative error that an area may have unless told otherwise."""
LEAST_AREA_ERROR = 1e-3
"""Least error of areas that may be asked for."""
MAX_POINTS = 1_000_000
ON_LINE = 1e-9
"""Cells of a grid by which a place may miss a line and still count as on it."""
NEAR = 4.0
"""Multiples of the separation up to which the least separation is resolved to a tolerance."""


@dataclass(frozen=True, eq=False)
class MemberPattern:
    """The pattern on one member's flank. Arrays (nl, nz) over depth and face, root and toe first:
    `l`, `z`, mm; `points` (nl, nz, 3), own frame, mm; `least`, the least separation, mm, negative
    for overlap; `pinion_roll` at which it occurs, rad; `marked`, whether it is within the
    separation of the pattern; `status`: codes of `PatternStatus`. `area` of the marked region, mm^2,
    and its share of the active flank; `area_error`, a bound on the relative error of both, whatever
    the grid."""

    __repr__ = few_lines

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


@dataclass(frozen=True, eq=False)
class ContactPattern:
    """Contact pattern of one flank pair for a `separation`, mm, over pinion rolls from the first
    to the second of `roll_range`, rad."""

    __repr__ = few_lines

    flank: str
    separation: float
    roll_range: tuple[float, float]
    pinion: MemberPattern
    gear: MemberPattern


def contact_pattern(
    design: Design,
    flank: str = "right",
    separation: float = MARKING_SEPARATION,
    *,
    resolution: float | None = None,
    tolerance: float | None = None,
    area_error: float = AREA_ERROR,
    pinion_roll: ArrayLike | None = None,
    gear_roll: ArrayLike | None = None,
    operation: Operation | None = None,
) -> ContactPattern:
    """Find where marking compound is left: the contact pattern over the mesh of one tooth pair.

    Parameters
    ----------
    design : Design
        A single one.
    flank : {'right', 'left'}
    separation : float
        Thickness of the compound, mm.
    resolution, tolerance : float, optional
        Of the grids alone, mm: points about every `resolution`, or so many that the least separation
        interpolated between them is right to about `tolerance` (a twentieth of the separation).
    area_error : float
        Share of itself to which each area is found, apart from the grids. The result's `area_error` is the
        bound that was kept, greater only where `marked_area` had to stop before.
    pinion_roll, gear_roll : array_like, shape (n), optional
        Poses of the pair, rad, in the order of the roll, between which its transmission error is
        interpolated; without them those of first contact.
    operation : Operation, optional
        Those of first contact, if they are known (`first_contact_operation`).

    Returns
    -------
    ContactPattern

    Raises
    ------
    ValueError
        For a batch, lengths or an error of areas that are not positive or too fine, poses of one member
        only, or where the first contact is not known.
    """
    _check(design, separation, resolution, tolerance, area_error)
    operation = given_operation(design, pinion_roll, gear_roll) or operation
    operation = operation or first_contact_operation(design, flank)
    patterns = []
    for number, member in enumerate(design.members):
        side = _side_of(member, flank, mating_of(design, flank, number, operation))
        if resolution is not None:
            grid = _found_on(side, _cells_of_size(member, resolution))
            coarse = any(n - 1 < least for n, least in zip(grid.least.shape, CELLS[0], strict=True))
            found = _found_on(side, CELLS[0]) if coarse else grid
        else:
            grid = found = _within(
                side, separation / 20.0 if tolerance is None else tolerance, NEAR * separation
            )
        patterns.append(_member_pattern(side, grid, found, separation, area_error))
    return ContactPattern(flank, separation, operation.span, *patterns)


def _check(
    design: Design, separation: float, resolution: float | None, tolerance: float | None, area_error: float
) -> None:
    if design.batch_shape:
        raise ValueError(f"a pattern is that of one design, got a batch of the shape {design.batch_shape}")
    if resolution is not None and tolerance is not None:
        raise ValueError("give resolution or tolerance, not both")
    lengths = {"separation": separation, "resolution": resolution, "tolerance": tolerance}
    for name, length in lengths.items():
        if length is not None and not 0.0 < length < np.inf:
            raise ValueError(f"{name} must be a positive length in mm, got {length:g}")
    if not LEAST_AREA_ERROR <= area_error < 1.0:
        raise ValueError(f"area_error must be from {LEAST_AREA_ERROR:g} to under 1, got {area_error:g}")


@dataclass(frozen=True, eq=False)
class _Side:
    """A member's flank and its `mating` with the other; `reach` (2, nl, nz): the first and the last of the
    samples near which the least separation is on the grid of `COARSE` cells."""

    member: Member
    flank: str
    mating: Mating
    reach: Integers

    def at(self, depth: FloatArray, face: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give l, z (...) and points (..., 3) at shares of the depth from the root, of the face from the
        toe."""
        l, z, u = place_at(self.member, self.flank, depth, face)
        return l, z, flank_point(self.member, self.flank, l, u)

    def least(self, points: FloatArray, share: FloatArray) -> LeastSeparation:
        """Give the least separations of points (n, 3) at places (n, 2) of the unit square, looked for from
        the first to the last of the samples that the corners of the coarse cells around them reach."""
        place, each = share * COARSE, np.arange(self.mating.rolls.size)[:, None]
        (i, j), (m, n) = np.floor(place + ON_LINE).astype(int).T, np.ceil(place - ON_LINE).astype(int).T
        first, last = self.reach[:, (i, i, m, m), (j, n, j, n)]
        near = (each >= first.min(axis=0)) & (each <= last.max(axis=0))
        return least_separation(self.mating, points, near)


def _side_of(member: Member, flank: str, mating: Mating) -> _Side:
    """Give a side, having looked at every other sample on the coarse grid."""
    side = _Side(member, flank, mating, np.empty((2, 0, 0), dtype=np.int64))
    depth, face = (np.linspace(0.0, 1.0, n + 1) for n in COARSE)
    _, _, points = side.at(depth[:, None], face)
    some = replace(mating, rolls=np.append(mating.rolls[:-1:2], mating.rolls[-1]))
    near = sampled(some, points.reshape(-1, 3)).near
    ends = 2 * near.argmax(axis=0) - 2, 2 * (len(near) - near[::-1].argmax(axis=0))
    reach = np.clip(ends, 0, mating.rolls.size - 1).reshape(2, *points.shape[:2])
    return replace(side, reach=reach)


@dataclass(frozen=True, eq=False)
class _Grid:
    """The arrays of `MemberPattern` that do not depend on the thickness of the marking compound."""

    l: FloatArray
    z: FloatArray
    points: FloatArray
    least: FloatArray
    pinion_roll: FloatArray
    status: Codes


def _found_on(side: _Side, cells: tuple[int, int]) -> _Grid:
    """Give the least separations on a grid evenly spaced in depth and face."""
    depth, face = (np.linspace(0.0, 1.0, n + 1) for n in cells)
    l, z, points = side.at(depth[:, None], face)
    share = np.stack(np.meshgrid(depth, face, indexing="ij"), axis=-1)
    found = side.least(points.reshape(-1, 3), share.reshape(-1, 2))
    shape = l.shape
    return _Grid(
        l, z, points, found.least.reshape(shape), found.roll.reshape(shape), found.status.reshape(shape)
    )


def _cells_of_size(member: Member, resolution: float) -> tuple[int, int]:
    depth = 2.0 * float(member.tool.addendum * np.asarray(member.tool.normal_module))
    cells = whole(depth / resolution), whole(float(member.face_width) / resolution)
    if (cells[0] + 1) * (cells[1] + 1) > MAX_POINTS:
        raise ValueError(
            f"resolution {resolution:g} mm is too fine: it takes more than {MAX_POINTS:,} points"
        )
    return cells


def _within(side: _Side, tolerance: float, highest: float) -> _Grid:
    """Give a grid on which an interpolated least separation is off by about `tolerance`, half of it from
    either direction, judged by second differences where it is a standstill, at most `highest`."""
    grid, counts = _found_on(side, CELLS[0]), []
    table = np.where((grid.status == PatternStatus.STANDSTILL) & (grid.least <= highest), grid.least, np.nan)
    for axis in (0, 1):
        values = np.moveaxis(table, axis, 0)
        bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
        bend = bend[np.isfinite(bend)]
        count = CELLS[0][axis] * np.sqrt(bend.max(initial=0.0) / (8.0 * 0.5 * tolerance))
        counts.append(int(np.clip(np.ceil(count), CELLS[0][axis], CELLS[1][axis])))
    cells = counts[0], counts[1]
    return grid if cells == CELLS[0] else _found_on(side, cells)


def _member_pattern(
    side: _Side, grid: _Grid, found: _Grid, separation: float, area_error: float
) -> MemberPattern:
    """Give the pattern on a `grid`, its area from the grid `found`: by the root of the least separation,
    which grows about evenly both beside the path of contact and beyond the reach of the mating edge."""

    def excess(least: FloatArray) -> FloatArray:
        return np.where(np.isnan(least), np.inf, np.sqrt(np.maximum(least, 0.0)) - np.sqrt(separation))

    def excess_at(share: FloatArray) -> FloatArray:
        *_, points = side.at(*share.T)
        return excess(side.least(points, share).least)

    area, error, whole = marked_area(excess_at, excess(found.least), found.points, area_error)
    return MemberPattern(
        **vars(grid),
        marked=grid.least <= separation,
        area=area,
        area_share=area / whole,
        area_error=error,
    )
