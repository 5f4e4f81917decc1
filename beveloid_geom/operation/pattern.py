"""Contact pattern: where the flanks come closer than the marking compound is thick.

While a tooth pair rolls through the mesh, every point of a flank has its least separation from the
mating flank. The pattern is the region in which it stays below a given thickness; for a pair without
transmission error the least separation is the ease-off of the one flank against the surface that
the other one generates.

The separation is the exact distance to the mating flank (`perpendicular.feet`), counted while the foot
lies on that flank. Along the roll it is sampled, at the kinks of the operation too; between it is smooth, and
parabolas lead to its least value. Where the foot leaves the mating flank before, the least value is that at
the edge, found by quartering.

The gear's roll at a pinion roll is given, or that of the first contact of all teeth, edges included
(`mesh_cycle`). The least separation is then positive but for rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Integers, Mask
from ..contact.ellipse import MARKING_SEPARATION
from ..contact.placing import frames_at
from ..design.model import Design, Member
from ..gear.flank import flank_point, place_at
from ..gear.perpendicular import feet
from ..pair.frames import to_fixed
from ..status import PatternStatus, Status
from ..support.few_lines import few_lines
from .marked_area import marked_area
from .operating_rolls import Operation, first_contact_operation, given_operation

POSES_PER_PITCH = 10
"""Poses at which the separation is sampled before it is refined."""
QUARTERINGS = 18
"""Steps to the edge of the mating flank."""
GOLDEN, STEPS = 0.5 * (3.0 - np.sqrt(5.0)), 16
"""Share of the longer side of a bracket at which to look where no parabola tells; steps at most."""
BESIDE, LEVEL = 1e-5, 1e-13
"""Share of a bracket within which the place is looked for: the square of it is an error of the value; mm by
which the ends of a bracket may stand above its least value and all be one."""
BLOCK = 8192
"""Points taken at a time, so that the arrays stay in the cache."""
CELLS = ((24, 32), (250, 250))
"""Least and greatest numbers of cells along depth and face. The least resolves the strip along a
flank's root that the mating tip does not reach."""
AREA_ERROR = 0.01
"""Relative error that an area may have unless told otherwise."""
LEAST_AREA_ERROR = 1e-3
"""Least error of areas that may be asked for."""
MAX_POINTS = 1_000_000
ROUNDING = 1e-12
"""Relative: what counts as whole."""
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


Apart: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""Separation (mm) of points (..., 3), own frame, at pinion rolls that broadcast with them; infinite
while the foot is not on the mating flank."""


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
    operation = given_operation(design, pinion_roll, gear_roll) or first_contact_operation(design, flank)
    patterns = []
    rolls = sampled_rolls(design, operation)
    for number, member in enumerate(design.members):
        side = _Side(member, flank, separation_of(design, flank, number, operation), rolls)
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


def separation_of(design: Design, flank: str, member: int, operation: Operation) -> Apart:
    """Give the separation from the mating flank of points of `member` (0 pinion, 1 gear) in operation."""
    other = 1 - member

    def apart(points: FloatArray, roll: FloatArray) -> FloatArray:
        """Give distances (...), mm, infinite while the foot is not on the mating flank."""
        frames = frames_at(design, roll, operation.gear_roll(np.asarray(roll)))
        frame, (rotation, origin) = frames[member], frames[other]
        seen = np.einsum("...ji,...j->...i", rotation, to_fixed(frame, points) - origin)
        found = feet(design.members[other], flank, seen)
        return np.where(found.status == Status.SOLVED, found.distance, np.inf)

    return apart


def sampled_rolls(design: Design, operation: Operation) -> FloatArray:
    """Give pinion rolls (n,), rad, at which the separation is sampled over the cycle, its kinks among
    them."""
    pitches = (operation.span[1] - operation.span[0]) * float(design.pinion.teeth) / (2.0 * np.pi)
    even = np.linspace(*operation.span, max(_whole(POSES_PER_PITCH * pitches) + 1, 3))
    return np.union1d(even, operation.kinks)


@dataclass(frozen=True, eq=False)
class _Side:
    """A member's flank and its separation from the mating one over the cycle's `rolls` (n,), rad."""

    member: Member
    flank: str
    apart: Apart
    rolls: FloatArray

    def at(self, depth: FloatArray, face: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give l, z (...) and points (..., 3) at shares of the depth from the root, of the face from the
        toe."""
        l, z, u = place_at(self.member, self.flank, depth, face)
        return l, z, flank_point(self.member, self.flank, l, u)


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
    depth, face = (np.linspace(0.0, 1.0, count + 1) for count in cells)
    l, z, points = side.at(depth[:, None], face)
    least, roll, status = least_separation(side.apart, points.reshape(-1, 3), side.rolls)
    shape = l.shape
    return _Grid(l, z, points, least.reshape(shape), roll.reshape(shape), status.reshape(shape))


def _cells_of_size(member: Member, resolution: float) -> tuple[int, int]:
    depth = 2.0 * float(member.tool.addendum * np.asarray(member.tool.normal_module))
    cells = _whole(depth / resolution), _whole(float(member.face_width) / resolution)
    if (cells[0] + 1) * (cells[1] + 1) > MAX_POINTS:
        raise ValueError(
            f"resolution {resolution:g} mm is too fine: it takes more than {MAX_POINTS:,} points"
        )
    return cells


def _whole(number: float) -> int:
    """Give the number rounded up; rounding of a whole one must not make it one more."""
    return int(np.ceil(number - ROUNDING * number))


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
        return excess(least_separation(side.apart, points, side.rolls)[0])

    area, error, whole = marked_area(excess_at, excess(found.least), found.points, area_error)
    return MemberPattern(
        **vars(grid),
        marked=grid.least <= separation,
        area=area,
        area_share=area / whole,
        area_error=error,
    )


def least_separation(
    apart: Apart, points: FloatArray, rolls: FloatArray
) -> tuple[FloatArray, FloatArray, Codes]:
    """Give the least separation (mm), the pinion roll (rad) at which it occurs, and status, each (n,), of
    points (n, 3) over the range of rising `rolls`, between which it is smooth."""
    block = max(1, BLOCK // len(points))
    starts = range(0, len(rolls), block)
    table = np.concatenate([apart(points, rolls[k : k + block, None]) for k in starts])
    best = table.argmin(axis=0)
    least, at = table.min(axis=0), rolls[best]
    status = np.where(np.isinf(least), PatternStatus.NO_MATE, PatternStatus.STANDSTILL).astype(np.int8)
    met = np.flatnonzero(np.isfinite(least))
    points, table, best = points[met], table[:, met], best[met]
    x, y = _brackets(apart, points, table, best, rolls)
    low, high = x[0], x[2]
    small = 1e-3 * (high - low)
    least[met], at[met] = _refined(apart, points, x, y)
    for limit, end, way in ((low, 0, -1), (high, len(rolls) - 1, 1)):
        close = np.abs(at[met] - limit) <= small
        beside = np.clip(best + way, 0, len(rolls) - 1)
        leaves = np.isinf(table[beside, np.arange(len(met))])
        status[met[close & leaves]] = PatternStatus.MATE_EDGE
        status[met[close & (best == end)]] = PatternStatus.END_OF_ROLL
    least[np.isinf(least)], at[status == PatternStatus.NO_MATE] = np.nan, np.nan
    return least, at, status


def _brackets(
    apart: Apart, points: FloatArray, table: FloatArray, best: Integers, rolls: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give rolls (3, n): the best sample and, on either side, the next or where the foot leaves the mating
    flank before; and the separations there (3, n)."""
    around, column = np.clip(best + np.array([[-1], [0], [1]]), 0, len(rolls) - 1), np.arange(len(best))
    x, y = rolls[around], table[around, column]
    way, lost = np.nonzero(np.isinf(y))
    valid, value, step = rolls[best[lost]], y[1, lost], x[way, lost] - rolls[best[lost]]
    for _ in range(QUARTERINGS if lost.size else 0):
        step = 0.25 * step
        gaps = apart(points[lost], valid + step * np.arange(1.0, 4.0)[:, None])
        held = np.logical_and.accumulate(np.isfinite(gaps)).sum(axis=0)
        value = np.where(held > 0, gaps[held - 1, np.arange(lost.size)], value)
        valid = valid + step * held
    x[way, lost], y[way, lost] = valid, value
    return x, y


def _refined(apart: Apart, points: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the least separations and their rolls (n,) inside brackets `x` (3, n) with the separations `y` (3,
    n) by successive parabolas, of which the vertex, lower or not, makes the bracket narrower."""
    left, right = y[0] < y[1], (y[2] < y[1]) & ~(y[0] < y[1])
    # Where an end lies lowest the bracket has it twice.
    x, y = (np.where(left, v[[0, 0, 1]], np.where(right, v[[1, 2, 2]], v)) for v in (x, y))
    beside, going, failed = BESIDE * (x[2] - x[0]), np.arange(len(points)), np.zeros(len(points))
    for _ in range(STEPS):
        (a, b, c), (f, g, h), step = x[:, going], y[:, going], beside[going]
        side = np.where(c - b > b - a, 1.0, -1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            p, q = (b - a) * (g - h), (b - c) * (g - f)
            away = -0.5 * ((b - a) * p - (b - c) * q) / (p - q)
        golden = GOLDEN * np.where(side > 0.0, c - b, a - b)
        away = np.where((away > a - b) & (away < c - b), away, golden)
        # Close by, or where a vertex was none, it is seen beside the least value whether that is one.
        again = np.where(failed[going] > 0.0, c - b, np.where(failed[going] < 0.0, b - a, 0.0)) > 2.0 * step
        side = np.where(again, failed[going], side)
        away = np.where(again | (np.abs(away) < step) | (a == b) | (b == c), side * step, away)
        new = b + away
        gap = apart(points[going], new)
        lower, before = gap < g, away < 0.0
        ends = np.where(
            lower, np.where(before, (a, new, b), (b, new, c)), np.where(before, (new, b, c), (a, b, new))
        )
        gaps = np.where(
            lower, np.where(before, (f, gap, g), (g, gap, h)), np.where(before, (gap, g, h), (f, g, gap))
        )
        x[:, going], y[:, going], failed[going] = ends, gaps, np.where(lower, 0.0, np.sign(away))
        found = (np.diff(ends, axis=0) <= 2.0 * step).all(axis=0)
        going = going[~found & (gaps[[0, 2]].max(axis=0) - gaps[1] > LEVEL)]
        if not going.size:
            break
    return y[1], x[1]
