"""Contact pattern: where the flanks come closer than the marking compound is thick.

While a tooth pair rolls through the mesh, every point of a flank has its least separation from the
mating flank. The pattern is the region in which it stays below a given thickness; for a pair without
transmission error the least separation is the ease-off of the one flank against the surface that
the other one generates.

The separation is the exact distance to the mating flank (`foot.feet`), counted while the foot
lies on that flank. Along the roll it is sampled, bracketed, and searched for its least value. Where
the foot leaves the mating flank before, the least value is that at the edge, found by halving.

The gear's roll at a pinion roll is given, or that of the first contact of all teeth, edges included
(`first_contact`). The least separation is then positive but for rounding and the interpolation
between rolls, up to 1e-4 mm where edges carry.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .assembly import to_fixed
from .curvature import MARKING_SEPARATION
from .few_lines import few_lines
from .flank import flank_point, root_parameter, tip_parameter, trace_parameter
from .foot import feet
from .inputs import Design, FloatArray, Member
from .operating_rolls import Operation, first_contact_operation, given_operation
from .posing import frames_at
from .solve import Status

POSES_PER_PITCH = 10
"""Poses at which the separation is sampled before it is refined."""
HALVINGS, FINER = 20, 4
"""Steps to the edge of the mating flank; how much finer steps are made where a change is looked for."""
GOLDEN, GOLDEN_STEPS = 0.5 * (np.sqrt(5.0) - 1.0), 12
"""Golden section of the last step between samples: to 2e-5 rad, for kinks of the operation; where there
are none the vertex of a parabola is the standstill to rounding."""
BLOCK = 8192
"""Points taken at a time, so that the arrays stay in the cache."""
TRIAL = (13, 13)
"""Grid on which a tolerance is turned into a density."""
CELLS = ((24, 32), (250, 250))
"""Least and greatest numbers of cells along depth and face. The least resolves the strip along a
flank's root that the mating tip does not reach."""
MAX_POINTS = 1_000_000
ROUNDING = 1e-12
"""Relative: what counts as whole."""
NEAR = 4.0
"""Multiples of the separation up to which the least separation is resolved to a tolerance."""


class PatternStatus(IntEnum):
    """How the separation of one point comes to its least value."""

    STANDSTILL = 0
    """It stands still there."""
    MATE_EDGE = 1
    """The foot reaches an edge of the mating flank there."""
    END_OF_ROLL = 2
    """It still falls at the first or the last pose."""
    NO_MATE = 3
    """The point has no foot on the mating flank at any pose; NaN."""


@dataclass(frozen=True, eq=False)
class MemberPattern:
    """The pattern on one member's flank. Arrays (nl, nz) over depth and face, root and toe first:
    `l`, `z`, mm; `points` (nl, nz, 3), own frame, mm; `least`, the least separation, mm, negative
    for overlap; `pinion_roll` at which it occurs, rad; `marked`, whether it is within the
    separation of the pattern; `status`: codes of `PatternStatus`. `area` of the marked region, mm^2,
    and its share of the active flank, from the root of the least separation, interpolated."""

    __repr__ = few_lines

    l: FloatArray
    z: FloatArray
    points: FloatArray
    least: FloatArray
    pinion_roll: FloatArray
    marked: NDArray[np.bool_]
    status: NDArray[np.int8]
    area: float
    area_share: float


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


Approach: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""Separation (mm) of points (..., 3), own frame, at pinion rolls that broadcast with them; infinite
while the foot is not on the mating flank."""


def contact_pattern(
    design: Design,
    flank: str = "right",
    separation: float = MARKING_SEPARATION,
    *,
    resolution: float | None = None,
    tolerance: float | None = None,
    pinion_roll: ArrayLike | None = None,
    gear_roll: ArrayLike | None = None,
) -> ContactPattern:
    """Contact pattern of a single design for a `separation` in mm, over the mesh of one tooth pair.

    The grids have points about every `resolution` (mm), or so many that the least separation
    interpolated between them is right to about `tolerance` (mm; a twentieth of the separation unless
    told otherwise). `pinion_roll` and `gear_roll` (n,), rad: poses of the pair, in the order of the
    roll, between which its transmission error is interpolated; without them see the module's text.

    Raises ValueError for a batch of designs, lengths that are not positive or too fine, poses of one
    member only, or where the first contact is not known."""
    _check(design, separation, resolution, tolerance)
    operation = given_operation(design, pinion_roll, gear_roll) or first_contact_operation(design, flank)
    patterns = []
    for member in (0, 1):
        approach = approach_of(design, flank, member, operation)
        rolls = sampled_rolls(design, operation)
        if resolution is not None:
            cells = _cells_of_size(design.members[member], resolution)
        else:
            fine = separation / 20.0 if tolerance is None else tolerance
            cells = _cells_within(design.members[member], flank, approach, rolls, fine, NEAR * separation)
        patterns.append(_member_pattern(design.members[member], flank, approach, rolls, cells, separation))
    span = float(operation.roll[0]), float(operation.roll[-1])
    return ContactPattern(flank, separation, span, *patterns)


def _check(design: Design, separation: float, resolution: float | None, tolerance: float | None) -> None:
    if design.batch_shape:
        raise ValueError(f"a pattern is that of one design, got a batch of the shape {design.batch_shape}")
    if resolution is not None and tolerance is not None:
        raise ValueError("give resolution or tolerance, not both")
    lengths = {"separation": separation, "resolution": resolution, "tolerance": tolerance}
    for name, length in lengths.items():
        if length is not None and not 0.0 < length < np.inf:
            raise ValueError(f"{name} must be a positive length in mm, got {length:g}")


def approach_of(design: Design, flank: str, member: int, operation: Operation) -> Approach:
    """Separation from the mating flank of points of `member` (0 pinion, 1 gear) in operation."""
    other = 1 - member

    def approach(points: FloatArray, roll: FloatArray) -> FloatArray:
        frames = frames_at(design, roll, operation.gear_roll(design, roll))
        frame, (rotation, origin) = frames[member], frames[other]
        seen = np.einsum("...ji,...j->...i", rotation, to_fixed(frame, points) - origin)
        found = feet(design.members[other], flank, seen)
        return np.where(found.status == Status.SOLVED, found.distance, np.inf)

    return approach


def sampled_rolls(design: Design, operation: Operation) -> FloatArray:
    """Pinion rolls (n,), rad, at which the separation is sampled over the cycle."""
    span = operation.roll[-1] - operation.roll[0]
    count = _whole(POSES_PER_PITCH * span * float(design.pinion.teeth) / (2.0 * np.pi)) + 1
    return np.linspace(operation.roll[0], operation.roll[-1], max(count, 3))


def _grid(member: Member, flank: str, cells: tuple[int, int]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """l, z (nl, nz) and points (nl, nz, 3) of a grid evenly spaced in depth and face."""
    half, root = 0.5 * float(member.face_width), root_parameter(member)
    z = np.linspace(-half, half, cells[1] + 1)
    share = np.linspace(0.0, 1.0, cells[0] + 1)[:, None]
    tip = tip_parameter(member, flank, z)
    if not np.isfinite(tip).all():
        raise ValueError(f"the {flank} flank does not reach its tip cone: reduce the addendum or the shift")
    l = root + share * (tip - root)
    z = np.broadcast_to(z, l.shape)
    return l, z, flank_point(member, flank, l, trace_parameter(member, flank, l, z))


def _cells_of_size(member: Member, resolution: float) -> tuple[int, int]:
    depth = 2.0 * float(member.tool.addendum * np.asarray(member.tool.normal_module))
    cells = _whole(depth / resolution), _whole(float(member.face_width) / resolution)
    if (cells[0] + 1) * (cells[1] + 1) > MAX_POINTS:
        raise ValueError(
            f"resolution {resolution:g} mm is too fine: it takes more than {MAX_POINTS:,} points"
        )
    return cells


def _whole(number: float) -> int:
    """The number rounded up; rounding of a whole one must not make it one more."""
    return int(np.ceil(number - ROUNDING * number))


def _cells_within(
    member: Member, flank: str, approach: Approach, rolls: FloatArray, tolerance: float, highest: float
) -> tuple[int, int]:
    """Cells for which an interpolated least separation is off by about `tolerance`, half of it from
    either direction, judged by second differences where it is a standstill, at most `highest`."""
    _, _, points = _grid(member, flank, TRIAL)
    least, _, status = least_separation(approach, points.reshape(-1, 3), rolls)
    table = np.where((status == PatternStatus.STANDSTILL) & (least <= highest), least, np.nan)
    table, counts = table.reshape(points.shape[:2]), []
    for axis in (0, 1):
        values = np.moveaxis(table, axis, 0)
        bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
        bend = bend[np.isfinite(bend)]
        count = TRIAL[axis] * np.sqrt(bend.max(initial=0.0) / (8.0 * 0.5 * tolerance))
        counts.append(int(np.clip(np.ceil(count), CELLS[0][axis], CELLS[1][axis])))
    return counts[0], counts[1]


def _member_pattern(
    member: Member,
    flank: str,
    approach: Approach,
    rolls: FloatArray,
    cells: tuple[int, int],
    separation: float,
) -> MemberPattern:
    l, z, points = _grid(member, flank, cells)
    found, roll, status = least_separation(approach, points.reshape(-1, 3), rolls)
    least = found.reshape(l.shape)
    area, whole = _marked_area(points, least, separation)
    return MemberPattern(
        l=l,
        z=z,
        points=points,
        least=least,
        pinion_roll=roll.reshape(l.shape),
        marked=least <= separation,
        status=status.reshape(l.shape),
        area=area,
        area_share=area / whole,
    )


def least_separation(
    approach: Approach, points: FloatArray, rolls: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.int8]]:
    """Least separation (mm), the pinion roll (rad) at which it occurs, and status, each (n,), of
    points (n, 3) over the range of evenly spaced `rolls`."""
    block = max(1, BLOCK // len(points))
    starts = range(0, len(rolls), block)
    table = np.concatenate([approach(points, rolls[k : k + block, None]) for k in starts])
    best = table.argmin(axis=0)
    least, at = table.min(axis=0), rolls[best]
    status = np.where(np.isinf(least), PatternStatus.NO_MATE, PatternStatus.STANDSTILL).astype(np.int8)
    met = np.flatnonzero(np.isfinite(least))
    points, table, best = points[met], table[:, met], best[met]
    low, high = (_side(approach, points, table, best, rolls, way) for way in (-1, 1))
    least[met], at[met] = _refined(approach, points, (low, at[met], high), least[met])
    small = 1e-3 * (rolls[1] - rolls[0])
    for limit, end, way in ((low, 0, -1), (high, len(rolls) - 1, 1)):
        close = np.abs(at[met] - limit) <= small
        beside = np.clip(best + way, 0, len(rolls) - 1)
        leaves = np.isinf(table[beside, np.arange(len(met))])
        status[met[close & leaves]] = PatternStatus.MATE_EDGE
        status[met[close & (best == end)]] = PatternStatus.END_OF_ROLL
    least[np.isinf(least)], at[status == PatternStatus.NO_MATE] = np.nan, np.nan
    return least, at, status


def _side(
    approach: Approach,
    points: FloatArray,
    table: FloatArray,
    best: NDArray[np.int_],
    rolls: FloatArray,
    way: int,
) -> FloatArray:
    """Rolls (n,) next to the best sample on one side, or where the foot leaves the mating flank before."""
    beside = np.clip(best + way, 0, len(rolls) - 1)
    inner, outer = rolls[best], rolls[beside]
    lost = np.flatnonzero(np.isinf(table[beside, np.arange(len(best))]))
    valid, beyond = inner[lost], outer[lost]
    for _ in range(HALVINGS if lost.size else 0):
        middle = 0.5 * (valid + beyond)
        held = np.isfinite(approach(points[lost], middle))
        valid, beyond = np.where(held, middle, valid), np.where(held, beyond, middle)
    outer[lost] = valid
    return outer


def _refined(
    approach: Approach,
    points: FloatArray,
    bracket: tuple[FloatArray, FloatArray, FloatArray],
    value: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Least separation and its roll inside a bracket (low, best sample, high): sampled once more, as
    the operation may have kinks, then by golden section."""
    low, centre, high = bracket
    x = np.concatenate((centre[None], low + (high - low) * np.linspace(0.0, 1.0, 2 * FINER + 1)[:, None]))
    y = np.concatenate((value[None], approach(points, x[1:])))
    value, centre = _least_of(y, x)
    step = (high - low) / (2 * FINER)
    left, right = np.maximum(centre - step, low), np.minimum(centre + step, high)
    inner = np.stack((right - GOLDEN * (right - left), left + GOLDEN * (right - left)))
    gaps = approach(points, inner)
    for _ in range(GOLDEN_STEPS):
        falls = gaps[0] > gaps[1]
        left, right = np.where(falls, inner[0], left), np.where(falls, right, inner[1])
        added = np.where(falls, left + GOLDEN * (right - left), right - GOLDEN * (right - left))
        gap = approach(points, added)
        inner = np.where(falls, (inner[1], added), (added, inner[0]))
        gaps = np.where(falls, (gaps[1], gap), (gap, gaps[0]))
    value, centre = _least_of(np.vstack((value, gaps)), np.vstack((centre, inner)))
    step = right - left
    before, after = (approach(points, np.clip(centre + way * step, low, high)) for way in (-1.0, 1.0))
    with np.errstate(invalid="ignore", divide="ignore"):  # flat, or beyond an edge of the mating flank
        away = 0.5 * step * (before - after) / (before - 2.0 * value + after)
    vertex = np.clip(centre + np.where(np.abs(away) <= step, away, 0.0), low, high)
    return _least_of(np.stack((value, approach(points, vertex))), np.stack((centre, vertex)))


def _least_of(values: FloatArray, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least of the values (k, n) along the first axis, and its place."""
    pick = values.argmin(axis=0)[None]
    return np.take_along_axis(values, pick, axis=0)[0], np.take_along_axis(places, pick, axis=0)[0]


def _marked_area(points: FloatArray, least: FloatArray, separation: float) -> tuple[float, float]:
    """Area (mm^2) within the separation, and the whole area. Inside the triangles of a grid the root of
    the least separation is taken to be linear: it grows with the square of the distance both from
    the path of contact and beyond the reach of the mating edge.

    Triangles with a corner that never meets the mating flank count as not marked."""
    index = np.arange(least.size).reshape(least.shape)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]
    corners = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (d, c, b))])
    p, q, r = np.moveaxis(points.reshape(-1, 3)[corners], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=-1)
    limit, root = np.sqrt(separation), np.sqrt(np.maximum(least.ravel(), 0.0))
    low, middle, high = np.sort(root[corners], axis=-1).T
    with np.errstate(invalid="ignore", divide="ignore"):
        first = (limit - low) ** 2 / ((middle - low) * (high - low))
        last = 1.0 - (high - limit) ** 2 / ((high - low) * (high - middle))
        share = np.where(limit < middle, first, np.where(limit < high, last, 1.0))
        share = np.where((limit <= low) | np.isnan(high), 0.0, share)
    return float(area @ share), float(area.sum())
