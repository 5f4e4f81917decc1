"""Path of contact of a pair, its contact ratio and the limits that end it.

A path is followed as a polynomial through exact solutions (`path_polynomial`), expanded in the pinion's
roll between its ends, and evaluated where it is asked for. Pinion drives, so that its roll
rises along the path of right flanks and falls along that of left flanks: ordinarily the path
enters at the pinion's root side and leaves towards its tip.

The contact ratio is Eq. 16: the pinion roll over which a tooth pair is tangent on its flanks, greatest
less least roll of its path, over a pitch. Where the roll turns back along the path that is more than the
roll between the ends: the pair is tangent twice at some rolls. It speaks of the geometry of one tooth
pair. Where the gear runs ahead towards the ends of the path, as on the right flanks of Table 1 with both
parabola coefficients positive, the edge of the next tooth touches first and the ratio at which the pair
operates is another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import Limit, Status
from ..support.chebyshev import basis_of, evaluate, resolved_degree
from ..support.few_lines import few_lines, html_table
from .ends import Ends, at_shares, shares_at_l1
from .equation import Pairing, gap_tolerance, pairing_of
from .path_polynomial import HEIGHT, NORMAL, PHASE, POINT, ROWS, PathSeries, exact_rows, rounding_scale
from .path_search import Group, paths_on_flanks

DENSE, MANY = basis_of(40), 256
"""A path of MANY positions or more is expanded in roll before it is evaluated."""
POSITIONS_PER_BLOCK, SAFE_PER_BLOCK = 8192, 2048
"""Sizes at which the arrays of a block stay in the cache; a safe solve takes many samples."""
ROUNDING = 64.0
"""Limits count as met within this many gap tolerances."""


@dataclass(frozen=True, eq=False)
class PathEnds:
    """Ends of the path on the flanks; last axis (enter, leave), before it the batch axes.

    `l1`, `l2` (mm), `pinion_roll` (rad), `limit` (codes of `Limit`, -1 without a path);
    `contact_ratio` (Eq. 16: greatest less least pinion roll of the path, over a pitch; 0 without a path,
    NaN where the path could not be followed), `pieces` (in how many the path lies on the
    flanks; that which covers most roll is taken; where l1 resolves the path, one with the other sign of n_x
    is not looked for) and `status` (codes of `Status`)
    have the batch shape."""

    __repr__ = few_lines

    l1: FloatArray
    l2: FloatArray
    pinion_roll: FloatArray
    limit: NDArray[np.int8]
    contact_ratio: FloatArray
    pieces: NDArray[np.int_]
    status: NDArray[np.int8]

    @property
    def enter(self) -> Limit | None:
        """Give the limit at which a single path enters."""
        return self._single(0)

    @property
    def leave(self) -> Limit | None:
        """Give the limit at which a single path leaves."""
        return self._single(1)

    def _single(self, end: int) -> Limit | None:
        if self.limit.ndim != 1:
            raise ValueError("enter and leave name the ends of one path; read `limit` for a batch")
        return Limit(self.limit[end]) if self.limit[end] >= 0 else None


@dataclass(frozen=True, eq=False)
class ContactPath:
    """Contacts of one flank pair of a `design`, arrays `(*batch, positions)`, or `(*batch, positions, 3)`.

    `l1, u1, l2, u2` flank parameters, mm; `pinion_roll, gear_roll`, rad; `point` (mm) and
    `normal` (out of the pinion's tooth) in S_f; `pinion_z, gear_z` (mm) from mid-face, which
    moves with the member, towards the heel; `pinion_r, gear_r` (mm) from the member's axis;
    `transmission_error`: gear roll plus N1/N2 pinion roll less its value at mid-roll of the path
    on the flanks (midway where the roll turns back; without such a path, the middle of the l1
    asked for), rad; `status`: codes of `Status`. NaN where not solved."""

    __repr__ = few_lines
    _repr_html_ = html_table

    design: Design = field(repr=False)
    flank: str
    l1: FloatArray
    u1: FloatArray
    l2: FloatArray
    u2: FloatArray
    pinion_roll: FloatArray
    gear_roll: FloatArray
    point: FloatArray
    normal: FloatArray
    pinion_z: FloatArray
    pinion_r: FloatArray
    gear_z: FloatArray
    gear_r: FloatArray
    transmission_error: FloatArray
    status: NDArray[np.int8]
    ends: PathEnds


def path_of_contact(
    design: Design, flank: str = "right", points: int = 101, *, l1: ArrayLike | None = None
) -> ContactPath:
    """Find the path of contact of a flank pair: Eqs. 15 and 16 of Ni et al. 2017.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape: one call solves all cases.
    flank : {'right', 'left'}
        Of both members; the paper's figures are of right flanks.
    points : int
        Positions from the exact point where the path enters both flanks to that where it leaves them, both
        included, evenly spaced in pinion roll (where the roll turns back along the path, evenly in l1, or
        where that does not resolve it along its chord, or the curve).
    l1 : array_like, shape (positions) or batch shape and positions, optional
        In place of `points`: the contacts at these pinion flank parameters, mm, unclipped; those outside
        the limits have the status OFF_FLANK.

    Returns
    -------
    ContactPath
        Without contact on the flanks a single design gives empty arrays, a batch rows of NaN.

    Raises
    ------
    ValueError
        For an unknown flank, fewer than two points, `l1` of another shape, arrays without elements.

    Notes
    -----
    The paper solves five equations at every position; here they are reduced to one in l1 and l2, the
    same to rounding (`beveloid_geom.contact`). It clips paths at no limits that it names; here they end at
    tip, root, toe and heel of both members.
    """
    if l1 is None:
        require_points(points)
    pairing, shape = _solvable(design, flank), design.batch_shape
    cases = pairing.branch.shape[0]
    given = None if l1 is None else _by_case(l1, shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        groups = paths_on_flanks(pairing)
        parts = [
            _on_path(group, points) if given is None else _at_given(group, given[group.cases])
            for group in groups
        ]
    path_ends = _path_ends(pairing, groups, shape)
    table, status = parts[0]
    if len(parts) > 1:
        table = np.empty((HEIGHT, cases, table.shape[-1]))
        status = np.empty(table.shape[1:], dtype=np.int8)
        for group, (rows, codes) in zip(groups, parts, strict=True):
            table[:, group.cases], status[group.cases] = rows, codes
    if given is None and not shape and path_ends.status != Status.SOLVED:
        table, status = table[..., :0], status[:, :0]
    return _result(design, flank, table, status, path_ends)


def path_blocks(
    design: Design, flank: str = "right", points: int = 101, *, positions_per_block: int = 65536
) -> Iterator[ContactPath]:
    """Give the positions of `path_of_contact` of a single design, block by block and in order, so that memory
    does not grow with their number. The `ends` of every block are those of the path.

    Raises ValueError for a batch: give it in slices of its cases."""
    if design.batch_shape:
        raise ValueError("path_blocks takes single designs; call path_of_contact on slices of a batch")
    require_points(points)
    if positions_per_block < 1:
        raise ValueError(f"positions_per_block must be at least 1, got {positions_per_block}")
    return _blocks(design, flank, points, positions_per_block)


def _blocks(design: Design, flank: str, points: int, size: int) -> Iterator[ContactPath]:
    pairing = _solvable(design, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        (group,) = paths_on_flanks(pairing)
        way = _way_of(group)
    limits = _path_ends(pairing, [group], ())
    found = points if limits.status == Status.SOLVED else 0
    for start in range(0, max(found, 1), size):
        index = np.arange(start, min(start + size, found))
        share = np.where(index == points - 1, 1.0, index * (2.0 / (points - 1)) - 1.0)  # as np.linspace
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            table = way.rows(share)
        status = np.broadcast_to(group.ends.status[:, None], table.shape[1:])
        yield _result(design, flank, table, status, limits)


def require_points(points: object) -> None:
    """Raise ValueError unless `points` is a number of positions along a path."""
    if not isinstance(points, int | np.integer) or isinstance(points, bool) or points < 2:
        raise ValueError(f"points must be at least 2, a whole number, got {points!r}")


def _solvable(design: Design, flank: str) -> Pairing:
    if 0 in design.batch_shape:
        raise ValueError("the design holds an array without elements: there is nothing to solve")
    return pairing_of(design, flank)


def _by_case(l1: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Give the flank parameters asked for, (cases, positions)."""
    given = np.atleast_1d(float64_of("l1", l1))
    if given.shape[:-1] not in ((), shape):
        batch = f" or {(*shape, 'positions')}" if shape else ""
        raise ValueError(f"l1 must have the shape (positions){batch}, got {given.shape}")
    if given.size == 0 or not np.isfinite(given).all():
        raise ValueError("l1 must hold finite numbers, at least one")
    return np.broadcast_to(given, (*shape, given.shape[-1])).reshape(-1, given.shape[-1])


def contact_ratio(design: Design, flank: str = "right") -> FloatArray:
    """Find the contact ratio of one tooth pair's flanks, Eq. 16.

    It is the greatest less the least pinion roll of the path, over a pitch, and not the ratio at which the
    pair runs where edges touch first: `operating_ratio` has that.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape.
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        Of the batch shape; 0 where there is no contact on the flanks, NaN where the path could not be
        followed.
    """
    return path_ends(design, flank).contact_ratio


def path_ends(design: Design, flank: str = "right") -> PathEnds:
    """Give ends of the path of contact and the contact ratio, without the positions between."""
    pairing = _solvable(design, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return _path_ends(pairing, paths_on_flanks(pairing), design.batch_shape)


def _path_ends(pairing: Pairing, groups: list[Group], shape: tuple[int, ...]) -> PathEnds:
    cases = pairing.branch.shape[0]
    l, roll, limit = np.empty((2, cases, 2)), np.empty((cases, 2)), np.empty((cases, 2), dtype=np.int8)
    span, pieces = np.empty(cases), np.empty(cases, dtype=int)
    status = np.empty(cases, dtype=np.int8)
    for group in groups:
        own, ends = group.cases, group.ends
        l[:, own], roll[own], limit[own] = ends.l, ends.roll, ends.limit
        span[own], pieces[own], status[own] = ends.span, ends.pieces, ends.status
    ratio = span * pairing.teeth[0, :, 0] / (2.0 * np.pi)
    ratio = np.where((status == Status.OFF_FLANK) | (status == Status.NO_COMMON_NORMAL), 0.0, ratio)
    return PathEnds(
        l1=l[0].reshape(*shape, 2),
        l2=l[1].reshape(*shape, 2),
        pinion_roll=roll.reshape(*shape, 2),
        limit=limit.reshape(*shape, 2),
        contact_ratio=ratio.reshape(shape),
        pieces=pieces.reshape(shape),
        status=status.reshape(shape),
    )


def _result(
    design: Design, flank: str, table: FloatArray, status: NDArray[np.int8], ends: PathEnds
) -> ContactPath:
    shape = design.batch_shape
    table, status = table.reshape(HEIGHT, *shape, -1), status.reshape(*shape, -1)
    last = (*range(1, table.ndim), 0)
    vectors = {"point": table[POINT].transpose(last), "normal": table[NORMAL].transpose(last)}
    rows = {name: table[row] for name, row in ROWS.items()}
    return ContactPath(design=design, flank=flank, status=status, ends=ends, **rows, **vectors)


@dataclass(frozen=True, eq=False)
class _Way:
    """A path from enter to leave: rows as polynomials of the share of the way in [-1, 1], or, where
    `by_roll` is False, of the parameter of the series; PHASE less its value in the `middle`."""

    coefficients: FloatArray
    by_roll: bool
    series: PathSeries
    ends: Ends
    middle: FloatArray

    def rows(self, share: FloatArray) -> FloatArray:
        """Give rows (HEIGHT, cases, positions) at shares of the way."""
        values = _by_blocks(
            self.coefficients, share if self.by_roll else at_shares(self.series, self.ends, share)
        )
        values[PHASE] -= self.middle
        return values


def _way_of(group: Group) -> _Way:
    """Give the way along the paths, expanded in roll where that resolves them."""
    series, ends, rows = group.series, group.ends, group.series.coefficients[:HEIGHT]
    values = evaluate(rows, at_shares(series, ends, DENSE.nodes))
    middle, by_roll = values[PHASE, :, DENSE.nodes.size // 2, None], DENSE.coefficients(values)
    solved = ends.status == Status.SOLVED
    degree = resolved_degree(by_roll[:, solved], rounding_scale(group.pairing)[:HEIGHT, solved])
    if degree is None:
        return _Way(rows, False, series, ends, middle)
    return _Way(by_roll[..., : degree + 1], True, series, ends, middle)


def _on_path(group: Group, points: int) -> tuple[FloatArray, NDArray[np.int8]]:
    """Give rows and status at positions evenly spaced from enter to leave."""
    share, series, ends = np.linspace(-1.0, 1.0, points), group.series, group.ends
    if points < MANY:
        values = evaluate(series.coefficients[:HEIGHT], at_shares(series, ends, np.append(share, 0.0)))
        values, middle = values[..., :-1], values[PHASE, :, -1:].copy()
        values[PHASE] -= middle
    else:
        values = _way_of(group).rows(share)
    return values, np.broadcast_to(ends.status[:, None], values.shape[1:])


def _at_given(group: Group, l1: FloatArray) -> tuple[FloatArray, NDArray[np.int8]]:
    """Give rows and status at given l1: from the series, beyond its window solved one by one."""
    pairing, series, ends = group.pairing, group.series, group.ends
    x, several = shares_at_l1(series, ends, l1)
    values = _by_blocks(series.coefficients, x)
    status = np.where(several, np.int8(Status.SEVERAL_CONTACTS), np.int8(Status.SOLVED))
    beyond = ~((np.abs(x) <= 1.0) & (series.status == Status.SOLVED)[:, None] | several)
    found = np.flatnonzero(beyond.any(axis=0))
    size = max(1, SAFE_PER_BLOCK // len(l1))
    for part in (found[start : start + size] for start in range(0, found.size, size)):
        rows, known = exact_rows(pairing, l1[:, part])
        values[..., part] = np.where(beyond[:, part], rows, values[..., part])
        status[:, part] = np.where(beyond[:, part], known, status[:, part])
    values[0] = l1
    off = values[HEIGHT:].min(axis=0) < -ROUNDING * gap_tolerance(pairing)
    status[off & (status == Status.SOLVED)] = Status.OFF_FLANK
    middle = evaluate(series.coefficients[PHASE : PHASE + 1], at_shares(series, ends, np.zeros(1)))[0]
    if np.isnan(middle).any():  # no path on the flanks: the middle of what was asked for
        between = 0.5 * (l1.min(axis=-1, keepdims=True) + l1.max(axis=-1, keepdims=True))
        middle = np.where(np.isnan(middle), exact_rows(pairing, between)[0][PHASE], middle)
    values[PHASE] -= middle
    return values[:HEIGHT], status


def _by_blocks(coefficients: FloatArray, parameter: FloatArray) -> FloatArray:
    """Give values (rows, cases, positions), a block of positions at a time to stay in the cache."""
    cases, positions = coefficients.shape[1], parameter.shape[-1]
    size = max(1, POSITIONS_PER_BLOCK // cases)
    values = np.empty((len(coefficients), cases, positions))
    for start in range(0, positions, size):
        block = slice(start, start + size)
        values[..., block] = evaluate(coefficients, parameter[..., block])
    return values
