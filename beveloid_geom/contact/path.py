"""Path of contact of a pair, its contact ratio and the limits at its ends.

The path is a polynomial through exact solutions (`path_polynomial`). For up to 255 positions it is evaluated
at the parameters that give the requested rolls. For more, it is first expanded in the pinion roll between its
ends. The pinion drives, so that its roll increases along the path of right flanks and decreases along the
path of left flanks. The path usually enters at the root side of the pinion and leaves towards its tip.

The contact ratio is Eq. 16: the range of pinion roll over which the flanks of a tooth pair are tangent,
divided by the pitch. If the roll turns back along the path, this range exceeds the roll between the ends, and
the pair is tangent twice at some rolls. The contact ratio describes the geometry of one tooth pair. If the
gear runs ahead towards the ends of the path, as on the right flanks of Table 1 with both parabola
coefficients 0.0002 1/mm, the edge of the next tooth touches first. The ratio in operation is then different
(`operating_ratio`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Integers, gear_sense
from ..design.arguments import require_design
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import Limit, Status
from ..support.array_repr import html_table, short_repr
from .ends import Ends
from .flank_pair import FlankPair, generated_pairing, is_modified
from .path_polynomial import NORMAL, PHASE, POINT, ROW_COUNT, ROWS
from .path_positions import ends_of_groups, middles_of, rows_alone, rows_of_groups
from .path_search import generated_paths
from .surfaces.paths import rows_at_l1, rows_between_ends, surface_ends, surface_paths


@dataclass(frozen=True, eq=False)
class PathEnds:
    """Ends of the path on the flanks.

    The last axis is (enter, leave), after the batch axes: `l1`, `l2` (mm), `pinion_roll` (rad) and `limit`
    (codes of `Limit`, -1 without a path). With the batch shape: `contact_ratio` (Eq. 16), 0 without a path
    and NaN where the path could not be computed; `pieces`, the number of segments of the path on the flanks,
    of which the one with the largest range of roll is used; `status` (codes of `Status`). Contacts with the
    opposite sign of n_x are not searched if the path is one series over l1 on which the magnitude of n_x is
    above 0.05.
    """

    __repr__ = short_repr

    l1: FloatArray
    l2: FloatArray
    pinion_roll: FloatArray
    limit: Codes
    contact_ratio: FloatArray
    pieces: Integers
    status: Codes

    @property
    def enter(self) -> Limit | None:
        """Limit at which a single path enters."""
        return self._single(0)

    @property
    def leave(self) -> Limit | None:
        """Limit at which a single path leaves."""
        return self._single(1)

    def _single(self, end: int) -> Limit | None:
        if self.limit.ndim != 1:
            raise ValueError("enter and leave are defined for a single path: use `limit` for a batch")
        return Limit(self.limit[end]) if self.limit[end] >= 0 else None


@dataclass(frozen=True, eq=False)
class ContactPath:
    """Contacts of one flank pair, arrays (..., positions), or (..., positions, 3).

    Attributes
    ----------
    design : Design
    flank : str
    l1, u1, l2, u2 : ndarray
        Coordinates of the contact on the rack flanks of pinion and gear, mm: l along the profile from the
        apex of the parabola, u along the tooth trace from mid-face.
    pinion_roll, gear_roll : ndarray
        Roll angles, rad.
    point, normal : ndarray
        Contact point (mm) and unit normal out of the pinion tooth, in S_f.
    pinion_z, gear_z : ndarray
        Axial coordinate from mid-face of the member, mm.
    pinion_r, gear_r : ndarray
        Distance from the axis of the member, mm.
    transmission_error : ndarray
        Gear roll plus N1/N2 pinion roll, rad, minus its value at mid-roll of the path on the flanks (the
        middle of the path parameter if the roll turns back; the middle of the given l1 without a path), times
        `gear_sense` (-1 on right flanks, +1 on left flanks). Positive if the gear is ahead.
    status : ndarray
        Codes of `Status`. Values that are not solved are NaN.
    ends : PathEnds

    Notes
    -----
    For a few given l1, `ends` and `transmission_error` are computed when they are first read.
    """

    __repr__ = short_repr
    _repr_html_ = html_table
    _undercut = True  # argument of `path_of_contact`; no field, because it is no result

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
    status: Codes
    ends: PathEnds

    @property
    def contact_ratio(self) -> FloatArray:
        """Contact ratio of one tooth pair (Eq. 16), in the batch shape."""
        return self.ends.contact_ratio

    if not TYPE_CHECKING:  # it would hide misspelt names from the type checker

        def __getattr__(self, name: str) -> Any:
            """Compute ends and transmission error of contacts that were solved one by one."""
            if name not in ("ends", "transmission_error"):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            vars(self).update(_searched(self))
            return vars(self)[name]


def path_of_contact(
    design: Design,
    flank: str = "right",
    points: int = 101,
    *,
    l1: ArrayLike | None = None,
    undercut: bool = True,
) -> ContactPath:
    """Compute the path of contact of a flank pair: Eqs. 15 and 16 of Ni et al. 2017.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape: one call solves all cases.
    flank : {'right', 'left'}
        Flank of both members. The paper does not say which flanks its figures show.
    points : int
        Number of positions, from the exact point where the path enters both flanks to the exact point where
        it leaves them, evenly spaced in pinion roll. Only if the roll turns back along the path, they are
        evenly spaced in l1, or along the chord or the curve of a path that is not a function of l1.
    l1 : array_like, shape (positions) or batch shape and positions, optional
        Replaces `points`: pinion flank parameters of the contacts, mm. They may be outside the limits of the
        flanks, with the status OFF_FLANK.
    undercut : bool
        Whether undercut limits the flanks, and with them the path and its `ends`.

    Returns
    -------
    ContactPath
        Without a path (no contact on the flanks, or a path that could not be computed: `ends.status`), the
        arrays of a single design are empty, and those of a batch have rows of NaN. With `l1`, there is one
        entry for each given value, with its own status, also without a path.

    Raises
    ------
    ValueError
        For an unknown flank, fewer than two points, `l1` of another shape, arrays without elements.

    Notes
    -----
    The paper solves five equations at every position. Here they are reduced to one equation in l1 and l2,
    with the same solution to rounding (`beveloid_geom.contact`). The paper gives no limits of the path. Here
    tip, root, toe and heel of both members limit it.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, path_of_contact
    >>> path = path_of_contact(builtin_design("ni-2017"), "right", 5)
    >>> round(float(path.ends.contact_ratio), 4)
    1.651
    """
    require_design(design)
    if l1 is None:
        require_points(points)
    pairing, shape = _solvable(design, flank, undercut), design.batch_shape
    cases = pairing.branch.shape[0]
    given = None if l1 is None else _by_case(l1, shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        if is_modified(design, flank):  # the one equation does not apply
            paths = surface_paths(design, flank, undercut)
            if given is None:
                table, status = rows_between_ends(paths, cases, np.linspace(0.0, 1.0, points))
            else:
                table, status = rows_at_l1(paths, given)
            ends = surface_ends(paths, cases)
        # Up to 16 given l1 are solved one by one, if each has one contact.
        elif given is not None and given.shape[-1] <= 16 and (alone := rows_alone(pairing, given)):
            return _result(design, flank, *alone, None, undercut)
        else:
            groups = generated_paths(design, flank, undercut)
            table, status = rows_of_groups(groups, points, given, cases)
            if given is not None:  # transmission error relative to mid-roll
                table[PHASE] -= middles_of(groups, given)
            ends = ends_of_groups(groups, cases)
    path_ends = _of_batch(pairing, ends, shape)
    if given is None and not shape and path_ends.status != Status.SOLVED:
        table, status = table[..., :0], status[:, :0]  # a single design without a path
    return _result(design, flank, table, status, path_ends, undercut)


def pairing_of_path(path: ContactPath) -> FlankPair:
    """Return the constants of the generated flanks of a path, limited by undercut only if the path is."""
    return generated_pairing(path.design, path.flank, path._undercut)


def require_points(points: object) -> None:
    """Raise ValueError unless `points` is a valid number of positions along a path."""
    if not isinstance(points, int | np.integer) or isinstance(points, bool) or points < 2:
        raise ValueError(f"points must be a whole number of at least 2, got {points!r}")


def _solvable(design: Design, flank: str, undercut: bool = True) -> FlankPair:
    if 0 in design.batch_shape:
        raise ValueError("the design contains an array without elements: give at least one value")
    return generated_pairing(design, flank, undercut)


def _by_case(l1: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return the requested flank parameters, (cases, positions)."""
    given = np.atleast_1d(float64_of("l1", l1))
    if given.shape[:-1] not in ((), shape):
        batch = f" or {(*shape, 'positions')}" if shape else ""
        raise ValueError(f"l1 must have the shape (positions){batch}, got {given.shape}")
    if given.size == 0 or not np.isfinite(given).all():
        raise ValueError("l1 must contain at least one number, and finite numbers only")
    if not shape:
        return given[None]
    return np.broadcast_to(given, (*shape, given.shape[-1])).reshape(-1, given.shape[-1])


def contact_ratio(design: Design, flank: str = "right") -> FloatArray:
    """Compute the contact ratio of the flanks of one tooth pair, Eq. 16.

    It is the range of pinion roll of the path, divided by the pitch. If edges touch first, the contact ratio
    in operation is different (`operating_ratios`).

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape.
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        Of the batch shape; 0 without contact on the flanks, NaN where the path could not be computed.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> round(float(bg.contact_ratio(bg.builtin_design("ni-2017"), "left")), 4)
    1.652
    """
    require_design(design)
    return path_ends(design, flank).contact_ratio


def path_ends(design: Design, flank: str = "right") -> PathEnds:
    """Compute the ends of the path of contact and the contact ratio, without the positions between.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape.
    flank : {'right', 'left'}

    Returns
    -------
    PathEnds
    """
    pairing = _solvable(design, flank)
    cases = pairing.branch.shape[0]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        if is_modified(design, flank):
            ends = surface_ends(surface_paths(design, flank), cases)
        else:
            ends = ends_of_groups(generated_paths(design, flank), cases)
    return _of_batch(pairing, ends, design.batch_shape)


def _of_batch(pairing: FlankPair, ends: Ends, shape: tuple[int, ...]) -> PathEnds:
    """Return the ends of all cases in the batch shape, with the contact ratio."""
    status = ends.status
    ratio = ends.span * pairing.teeth[0, :, 0] / (2.0 * np.pi)
    if status.any():
        ratio[(status == Status.OFF_FLANK) | (status == Status.NO_COMMON_NORMAL)] = 0.0
    return PathEnds(
        l1=ends.l[0].reshape(*shape, 2),
        l2=ends.l[1].reshape(*shape, 2),
        pinion_roll=ends.roll.reshape(*shape, 2),
        limit=ends.limit.reshape(*shape, 2),
        contact_ratio=ratio.reshape(shape),
        pieces=ends.pieces.reshape(shape),
        status=status.reshape(shape),
    )


def _result(
    design: Design, flank: str, table: FloatArray, status: Codes, ends: PathEnds | None, undercut: bool
) -> ContactPath:
    """Return the path with these rows (ROW_COUNT, cases, positions).

    Without `ends`, ends and transmission error are computed later, with or without limits by `undercut`.
    """
    shape = design.batch_shape
    table, status = table.reshape(ROW_COUNT, *shape, -1), status.reshape(*shape, -1)
    last = (*range(1, table.ndim), 0)
    vectors = {"point": table[POINT].transpose(last), "normal": table[NORMAL].transpose(last)}
    rows = {name: table[row] for name, row in ROWS.items()}
    if ends is not None:
        rows["transmission_error"] = gear_sense(flank) * rows["transmission_error"]
        path = ContactPath(design=design, flank=flank, status=status, ends=ends, **rows, **vectors)
    else:
        del rows["transmission_error"]
        path = object.__new__(ContactPath)
        vars(path).update(design=design, flank=flank, status=status, **rows, **vectors)
    vars(path)["_undercut"] = undercut
    return path


def _searched(path: ContactPath) -> dict[str, Any]:
    """Return ends and transmission error of contacts that were solved one by one."""
    pairing = pairing_of_path(path)
    shape = path.l1.shape
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        groups = generated_paths(path.design, path.flank, path._undercut)
        middle = middles_of(groups, path.l1.reshape(-1, shape[-1])).reshape(*shape[:-1], 1)
    ratio = (pairing.teeth[0] / pairing.teeth[1] + 0.0 * middle.reshape(-1, 1)).reshape(middle.shape)
    error = gear_sense(path.flank) * (path.gear_roll + ratio * path.pinion_roll - middle)
    ends = _of_batch(pairing, ends_of_groups(groups, pairing.branch.shape[0]), shape[:-1])
    return {"ends": ends, "transmission_error": error}
