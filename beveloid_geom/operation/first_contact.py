"""First contact of the flanks as the gear turns towards the pinion, edges and fillets included.

At a given roll of the pinion the least clearance f(s1, z1) (`least_clearance`) over all points within the
limits of both members, on any of the neighbouring teeth, is the first contact. It lies

    on no limit      at a tangency of flanks or fillets
    on one limit     with an edge on the other member's surface
    on two           with a corner, or an edge on an edge.

A coarse scan of the surfaces tells which teeth can matter, a finer one gives starts, and each of
these is followed to its local least. Of all the least counts; if a scanned point lies lower
still, the position is marked NOT_CONVERGED.

It is the contact of the solid teeth as long as tips keep clear of bottom lands (MEETS_BOTTOM is
what they do not). Tip lands and end faces turn in themselves, so that they touch at their edges
first. Flanks are taken up to their tip cone, also those of pointed teeth. The opposite flank is
left out: with less than no backlash it touches before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Integers, Mask
from ..design.field_limits import float64_of
from ..design.model import Design
from ..gear.tooth_side import cut_at, surface_of
from ..status import FirstStatus, Limit
from ..support.few_lines import few_lines
from .least_clearance import FEASIBLE, OVERLAP, Least, Task, least_clearances, repeated
from .mesh import (
    Mesh as Mesh,
    conjugate_phase as conjugate_phase,
    mesh_of as mesh_of,
    middle_roll as middle_roll,
    spread as spread,
)
from .search_starts import TIP_SPARE, Chart, Grid, Scan, beside_fillets, chart_of, grid_of, scan_of, starts_of
from .separation import pitch_shift, pose_of

Grids: TypeAlias = tuple[Grid, Grid, Chart]
Numbered: TypeAlias = tuple[Integers, "Found"]
"""Contacts, and the numbers of the positions at which they are."""

GRIDS = ((1, 5, 5), 36), ((4, 25, 19), 72)
"""Points scanned, coarse and fine: on the fillet, on the flank, along the face, and along the face for
each turn of a tooth round its axis, if that is more."""
SPARE = 0.25
"""Modules by which a tooth may stand further off than the nearest scanned and still be followed."""
TOGETHER = 1.6e-14
"""rad of the gear's roll within which tooth pairs count as touching together."""
IN_STEP = 0.8
"""Share of the overlap looked for that may be found: what is cut off there is the next turn's clearance."""
LOWER = 1e-8
"""Share of the tooth depth by which a scanned point must lie lower to put a result in doubt."""
POSITIONS = 512
"""Positions taken at a time."""


@dataclass(frozen=True, eq=False)
class FirstContact:
    """First contact at given pinion rolls, arrays (*batch, positions), or with a last axis.

    `pinion_roll`, `gear_roll` (rad) of tooth pair 0; `pair`: the tooth pair that touches, of several
    that touch together the one that came into mesh last, but tangencies before edges; `l1`, `l2`
    (mm) profile coordinates, the flank parameters above the joints, on the fillets below
    (`tooth_side`); `z1`, `z2` (mm from mid-face); `point` (..., 3) in S_f, mm; `limit` (..., 2): codes
    of `Limit` of the edges that touch, -1 for none: no edge is a tangency; `on_fillet` (..., 2):
    whether the contact lies on the fillet of pinion and gear; `transmission_error` (rad): gear
    roll plus N1/N2 pinion roll, less that of the unmodified pair without errors; `status`: codes
    of `FirstStatus`. NaN where not solved; `pair` is 0 there."""

    __repr__ = few_lines

    pinion_roll: FloatArray
    gear_roll: FloatArray
    pair: Integers
    l1: FloatArray
    z1: FloatArray
    l2: FloatArray
    z2: FloatArray
    point: FloatArray
    limit: Codes
    on_fillet: Mask
    transmission_error: FloatArray
    status: Codes

    def shaped(self, *shape: int) -> FirstContact:
        """Give the same positions in another shape."""
        last = {"point": (3,), "limit": (2,), "on_fillet": (2,)}
        return FirstContact(**{n: x.reshape(*shape, *last.get(n, ())) for n, x in vars(self).items()})


@dataclass(frozen=True, eq=False)
class Found:
    """First contacts (n,): f, place and meeting (2, n), mm; limits (2, n), tooth pair, status."""

    f: FloatArray
    place: FloatArray
    meeting: FloatArray
    limit: Codes
    pair: Integers
    status: Codes

    def pick(self, index: Integers | Mask) -> Found:
        """Give the contacts `index`."""
        return Found(*(value[..., index] for value in vars(self).values()))


def first_contact(
    design: Design, flank: str = "right", pinion_roll: ArrayLike = 0.0, pairs: ArrayLike | None = None
) -> FirstContact:
    """Find what touches first of all teeth at given rolls of the pinion: flanks, edges or fillets.

    Parameters
    ----------
    design : Design
        Members must be single; pair and errors may be arrays.
    flank : {'right', 'left'}
    pinion_roll : array_like, shape (positions) or batch shape and positions
        rad.
    pairs : array_like of int, optional
        Numbers of the tooth pairs looked at; if left out all that can touch. A tooth that winds round
        its axis belongs to one pair on every turn.

    Returns
    -------
    FirstContact

    Raises
    ------
    ValueError
        For members of arrays and for rolls that are not finite or of another shape.
    """
    shape = design.batch_shape
    roll = np.atleast_1d(float64_of("pinion_roll", pinion_roll))
    if not np.isfinite(roll).all():
        raise ValueError("pinion_roll must hold finite numbers")
    if roll.shape[:-1] not in ((), shape):
        raise ValueError(
            f"pinion_roll must have the shape (positions) or {(*shape, 'positions')}, got {roll.shape}"
        )
    roll = np.broadcast_to(roll, (*shape, roll.shape[-1]))
    return first_contact_in(design, flank, *mesh_of(design, flank, roll), roll.shape, pairs)


def first_contact_in(
    design: Design,
    flank: str,
    mesh: Mesh,
    phase: FloatArray,
    shape: tuple[int, ...],
    pairs: ArrayLike | None = None,
) -> FirstContact:
    """Give what `first_contact` does at rolls of this `shape` for which the mesh and its phase are known."""
    grids = grids_of(mesh, design, flank)
    if np.isnan(phase).any():
        mesh = in_step(mesh, np.isnan(phase).reshape(-1, shape[-1]), grids)
    return result_of(mesh, phase, found_at(mesh, grids, pairs), shape)


def grids_of(mesh: Mesh, design: Design, flank: str) -> Grids:
    """Give the points scanned, coarse and fine, and the chart of the gear for them."""
    points = [(*points[:2], max(points[2], int(np.ceil(each * mesh.turns)))) for points, each in GRIDS]
    with np.errstate(invalid="ignore", divide="ignore"):
        coarse, fine = (grid_of(design.pinion, flank, count) for count in points)
        return coarse, fine, chart_of(mesh.other, 0.5 * coarse.cell[0], 0.5 * coarse.cell[1])


def found_at(mesh: Mesh, grids: Grids, pairs: ArrayLike | None = None) -> Found:
    """Give first contacts at all positions of a mesh, of the tooth pairs `pairs` or of all that can touch."""
    return found_with_others(mesh, grids, pairs)[0]


def found_with_others(
    mesh: Mesh, grids: Grids, pairs: ArrayLike | None = None, each: bool = False
) -> tuple[Found, Numbered, Numbered]:
    """Give first contacts at all positions of a mesh; all local least clearances that are not much later; and
    the first contacts of `each` tooth pair that is not much later alone, if asked for, by position."""
    block = max(1, POSITIONS * GRIDS[1][0][2] // grids[1].shape[1])
    every = np.arange(mesh.roll.size)
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = [
            _solved(mesh, every[start : start + block], pairs, grids, each)
            for start in range(0, max(1, every.size), block)
        ]
    first, near, alone = zip(*parts, strict=True)
    return _put_together(first), _numbered(near), _numbered(alone)


def _numbered(parts: tuple[Numbered, ...]) -> Numbered:
    position, found = zip(*parts, strict=True)
    return np.concatenate(position), _put_together(found)


def _put_together(parts: tuple[Found, ...]) -> Found:
    return Found(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))


def in_step(mesh: Mesh, unknown: Mask, grids: Grids) -> Mesh:
    """Give the mesh with a phase where the conjugate one is `unknown` (cases, positions): at the first
    position of a case whose nearest tooth can touch, that of the touch."""
    position = np.flatnonzero(unknown)
    task = replace(mesh.task(position, mesh.nearest[position]), period=2.0 * np.pi)
    f, phase = np.full(unknown.size, np.inf), mesh.phase.copy()
    with np.errstate(invalid="ignore", divide="ignore"):
        f[position] = scan_of(task, grids[1], grids[2]).within
    touches = np.isfinite(f).reshape(unknown.shape)
    first = np.take_along_axis(f.reshape(unknown.shape), touches.argmax(axis=1)[:, None], axis=1)
    added = np.where(unknown & np.isfinite(first), mesh.other.sigma * first / mesh.lever, 0.0)
    return replace(mesh, phase=phase + added.reshape(-1))


def _solved(
    mesh: Mesh, positions: Integers, pairs: ArrayLike | None, grids: Grids, each: bool
) -> tuple[Found, Numbered, Numbered]:
    """Give what `found_with_others` does for a block of positions."""
    near = mesh.near if pairs is None else np.atleast_1d(pairs)
    position, pair = (x.ravel() for x in np.meshgrid(positions, near, indexing="ij"))
    if pairs is None:
        pair = pair + mesh.nearest[position]
    rough = scan_of(mesh.task(position, pair), grids[0], grids[2], pairs is None)
    first, count = positions[:1].sum(), positions.size
    best, bottom = np.full(count, np.inf), np.zeros(count, dtype=bool)
    np.minimum.at(best, position - first, rough.within)
    kept = np.flatnonzero(rough.f.min(axis=1) <= best[position - first] + SPARE * mesh.module)
    position, pair = position[kept], pair[kept]
    task, group = mesh.task(position, pair), position - first
    scan = scan_of(task, grids[1], grids[2], pairs is None)
    np.minimum.at(best, group, scan.within)
    bottom[group[scan.bottom]] = True
    own = np.minimum(rough.within[kept], scan.within)
    known = own if each else best[group]
    known = np.where(bottom[group], -np.inf, known)  # nothing is searched for there
    least, row, periods, distinct = _searched(task, scan, grids[1], known, mesh.module)
    turned = pair[row] - mesh.again * periods
    found = _chosen(mesh, positions, least, group[row], turned, best, bottom)
    local, solved = least.pick(distinct), np.full(distinct.size, FirstStatus.SOLVED, dtype=np.int8)
    others = Found(local.f, local.place, local.meeting, local.limit, turned[distinct], solved)
    if not each:
        return found, (position[row[distinct]], others), (position[:0], others.pick(distinct[:0]))
    lone = np.flatnonzero(periods == 0)
    alone = _chosen(mesh, position, least.pick(lone), row[lone], pair[row[lone]], own, scan.bottom)
    return found, (position[row[distinct]], others), (position, alone)


def _searched(
    task: Task, scan: Scan, grid: Grid, known: FloatArray, module: float
) -> tuple[Least, Integers, Integers, Integers]:
    """Give local least clearances of tooth pairs that a scan leads to, given the least f `known` of each; the
    number of the pair, and after how many of its periods; and which of them are not much later than the least
    known and within the limits, each place once."""
    starts = starts_of(task, scan, grid, known, module)
    row, periods, task = starts.row, starts.periods, task.pick(starts.row).later(starts.periods)
    owner = row + periods * scan.bottom.size
    least = least_clearances(task, starts.place, starts.box, owner)
    close = np.flatnonzero(least.converged & (least.f <= known[row] + TIP_SPARE * module))
    places = np.concatenate((row[None, close], np.rint(1e6 / grid.cell[0] * least.place[:, close])))
    close = close[~repeated(places)]
    more = beside_fillets(task.pick(close), least.place[:, close], grid)
    if more.row.size:
        again = close[more.row]
        least = least.and_also(least_clearances(task.pick(again), more.place, more.box, owner[again]))
        row, periods = np.append(row, row[again]), np.append(periods, periods[again])
        close = np.append(close, np.arange(row.size - again.size, row.size))
    on = least.converged & (least.outside <= FEASIBLE * task.depth)
    return least, row, periods, close[on[close]]


def _chosen(
    mesh: Mesh,
    positions: Integers,
    least: Least,
    group: Integers,
    pair: Integers,
    scanned: FloatArray,
    bottom: Mask,
) -> Found:
    """Give the least of the local results of each `group`, and what is to be thought of it, given their
    `positions` and the least scanned."""
    depth, n = mesh.own.tip - mesh.own.root, positions.size
    on = least.outside <= FEASIBLE * depth
    f = np.where(on & least.converged, least.f, np.inf)
    lowest, lost = np.full(n, np.inf), np.full(n, np.inf)
    np.minimum.at(lowest, group, f)
    np.minimum.at(lost, group, np.where(on & ~least.converged, least.f, np.inf))
    # Of tooth pairs that touch together rounding must not choose, but tangencies come before edges,
    # then the pair that came into mesh last.
    behind = ~(f <= lowest[group] + TOGETHER * mesh.lever)
    order = np.lexsort((f, mesh.own.sigma * pair, least.limit[0] >= 0, behind, group))
    found, first = np.unique(group[order], return_index=True)
    index = np.full(n, -1)  # the last column, which stands for nothing found
    index[found] = order[first]
    f = np.append(f, np.inf)[index]
    limit = np.append(least.limit, np.full((2, 1), np.int8(-1)), axis=1)[:, index]
    doubt = np.minimum(lost, scanned) < f - LOWER * depth
    rooted = ((limit == Limit.PINION_ROOT) | (limit == Limit.GEAR_ROOT)).any(axis=0)
    most = IN_STEP * OVERLAP * mesh.period * mesh.lever
    cases = (
        (~mesh.defined[positions], FirstStatus.UNDEFINED),
        (np.full(f.shape, mesh.own.undercut or mesh.other.undercut), FirstStatus.UNDERCUT),
        (bottom | rooted, FirstStatus.MEETS_BOTTOM),
        (np.minimum(f, scanned) < -most, FirstStatus.OUT_OF_STEP),
        (doubt, FirstStatus.NOT_CONVERGED),
        (np.isinf(f), FirstStatus.NO_CONTACT),
    )
    status = np.select([case for case, _ in cases], [code for _, code in cases], FirstStatus.SOLVED)
    bad, nothing = status != FirstStatus.SOLVED, np.full((2, 1), np.nan)
    return Found(
        f=np.where(bad, np.nan, f),
        place=np.where(bad, np.nan, np.append(least.place, nothing, axis=1)[:, index]),
        meeting=np.where(bad, np.nan, np.append(least.meeting, nothing, axis=1)[:, index]),
        limit=np.where(bad, np.int8(-1), limit),
        pair=np.where(bad, 0, np.append(pair, 0)[index]),
        status=status.astype(np.int8),
    )


def contact_normals(design: Design, flank: str, first: FirstContact) -> FloatArray:
    """Give unit normals (*batch, positions, 3) in S_f, out of the gear's tooth, along which first contacts
    part: those of the gear's surface, or of the pinion's where it is edges of the gear that touch."""
    pose, turns, own = pose_of(design), pitch_shift(design, first.pair), []
    places = (first.pinion_roll, first.l1, first.z1), (first.gear_roll, first.l2, first.z2)
    for member, turn, (roll, l, z) in zip(design.members, turns, places, strict=True):
        with np.errstate(invalid="ignore"):
            cut = cut_at(surface_of(member, flank), l, z)
        cos, sin = np.cos(cut.phi + roll + turn), np.sin(cut.phi + roll + turn)
        own.append((cos * cut.nx - sin * cut.ny, sin * cut.nx + cos * cut.ny, cut.nz))
    (px, py, pz), (gx, gy, gz) = own
    sin, cos, limit = pose.sin[..., None], pose.cos[..., None], first.limit
    of_gear = (limit[..., 0] >= 0) & ((limit < 0) | (limit % 2 == 1)).all(axis=-1)
    both = zip((-px, -py, -pz), (-gx, sin * gz - cos * gy, sin * gy + cos * gz), strict=True)
    return np.stack([np.where(of_gear, pinion, gear) for pinion, gear in both], axis=-1)


def moved_by_gear(design: Design, point: FloatArray) -> FloatArray:
    """Give the rates (*batch, positions, 3), mm/rad, at which points of the gear in S_f move as it turns."""
    pose = pose_of(design)
    offset, sin, cos = (value[..., None] for value in (pose.offset, pose.sin, pose.cos))
    x, y, z = np.moveaxis(point, -1, 0)
    return np.stack((sin * z - cos * y, cos * (x - offset), -sin * (x - offset)), axis=-1)


def result_of(mesh: Mesh, phase: FloatArray, found: Found, shape: tuple[int, ...]) -> FirstContact:
    """Give first contacts at the positions of a mesh, of which `phase` is NaN where it is not conjugate."""
    (l1, z1), (l2, z2) = found.place, found.meeting
    with np.errstate(invalid="ignore"):
        cut = cut_at(mesh.own, l1, z1)
        turned = cut.phi + mesh.roll + found.pair * mesh.pitch[0]
    cos, sin = np.cos(turned), np.sin(turned)
    point = (cos * cut.x - sin * cut.y, sin * cut.x + cos * cut.y, z1 + mesh.pose.position[0])
    ahead = mesh.other.sigma * found.f / mesh.lever
    rows = {"l1": l1, "z1": z1, "l2": l2, "z2": z2, "pair": found.pair, "status": found.status}
    rows |= {
        "pinion_roll": mesh.roll,
        "gear_roll": mesh.phase - mesh.pitch[1] / mesh.pitch[0] * mesh.roll + ahead,
        "transmission_error": ahead + mesh.phase - phase,
    }
    fillets = np.stack((l1 < mesh.own.joint, l2 < mesh.other.joint), axis=-1)
    return FirstContact(
        point=np.stack(point, axis=-1).reshape(*shape, 3),
        limit=found.limit.T.reshape(*shape, 2),
        on_fillet=fillets.reshape(*shape, 2),
        **{name: value.reshape(shape) for name, value in rows.items()},
    )
