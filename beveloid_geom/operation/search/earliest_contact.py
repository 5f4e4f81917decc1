"""Earliest contact of all tooth pairs at given pinion rolls: scan, search and selection.

A coarse scan selects the tooth pairs that can touch first. A finer scan gives starting points, and a search
from each of them gives the local minima of the clearance. The smallest minimum over all tooth pairs is the
first contact. If a scanned point is lower still, the position is marked NOT_CONVERGED."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Codes, FloatArray, Integers, Mask
from ...contact.surfaces.problems import with_line_crowning
from ...design.model import Design
from ...status import FirstStatus, Limit
from ...support.array_records import joined
from ..engagement import Engagement
from .clearance_scan import Chart, Grid, Scan, chart_of, scan_grid, scan_of
from .local_clearance import local_at
from .minimum_clearance import ON_LIMIT_DEPTHS, LocalMinima, minimum_clearances, repeated
from .search_starts import TIP_START_MODULES, near_fillets, starts_of, tip_edge_starts
from .search_task import OVERLAP_PERIODS, Task
from .undercut_edges import across_edges

Grids: TypeAlias = tuple[Grid, Grid, Chart]
"""Coarse and fine scan points of the pinion, and the chart of the gear."""
Numbered: TypeAlias = tuple[Integers, "Found"]
"""Numbers of positions, and contacts at these positions."""

GRID_POINTS = ((1, 5, 5), 36), ((4, 25, 19), 72)
"""Scan points, coarse and fine: on the fillet, on the flank, along the face, and along the face for each turn
of a tooth round its axis, if this gives more."""
SAME_ROLL_RAD = 1.6e-14
"""Difference of the gear roll within which tooth pairs touch at the same time."""


@dataclass(frozen=True, eq=False)
class Found:
    """First contacts (n,).

    Attributes
    ----------
    f : ndarray, shape (n,)
        Clearance from the conjugate gear roll, mm.
    place, meeting : ndarray, shape (2, n)
        s1 and z1 on the pinion, s2 and z2 on the gear, mm.
    limit : ndarray of int, shape (2, n)
        Codes of `Limit` of the touching edges, -1 for none.
    pair, status : ndarray of int, shape (n,)
        Tooth pair, and code of `FirstStatus`.
    """

    f: FloatArray
    place: FloatArray
    meeting: FloatArray
    limit: Codes
    pair: Integers
    status: Codes

    def pick(self, index: Integers | Mask) -> Found:
        """Return the contacts `index`."""
        return Found(*(value[..., index] for value in vars(self).values()))


def grids_of(engagement: Engagement, design: Design, flank: str) -> Grids:
    """Return the scan points and the chart of a pair.

    Parameters
    ----------
    engagement : Engagement
    design : Design
        With single members.
    flank : {'right', 'left'}

    Returns
    -------
    Grids
    """
    # Measured flanks may have waves.
    measured_grid_points = GRID_POINTS[0], ((4, 49, 37), 72)
    points = [
        (*points[:2], max(points[2], int(np.ceil(each * engagement.turns))))
        for points, each in (measured_grid_points if design.measured else GRID_POINTS)
    ]
    pinion = with_line_crowning(design, flank)[0].pinion  # that of the engagement
    with np.errstate(invalid="ignore", divide="ignore"):
        coarse, fine = (scan_grid(pinion, flank, count) for count in points)
        return coarse, fine, chart_of(engagement.gear, 0.5 * coarse.cell[0], 0.5 * coarse.cell[1])


def found_at(engagement: Engagement, grids: Grids, pairs: ArrayLike | None = None) -> Found:
    """Compute the first contacts at all positions.

    Parameters
    ----------
    engagement : Engagement
        Positions (n,).
    grids : Grids
    pairs : array_like of int, optional
        Tooth pairs that are searched. If omitted, all that can touch.

    Returns
    -------
    Found
        First contacts (n,).
    """
    return found_with_others(engagement, grids, pairs)[0]


def found_with_others(
    engagement: Engagement, grids: Grids, pairs: ArrayLike | None = None, each: bool = False
) -> tuple[Found, Numbered, Numbered]:
    """Compute first contacts and the other contacts that are not much later.

    Parameters
    ----------
    engagement : Engagement
        Positions (n,).
    grids : Grids
    pairs : array_like of int, optional
        Tooth pairs that are searched. If omitted, all that can touch.
    each : bool
        Whether the first contact of each tooth pair alone is returned as well.

    Returns
    -------
    first : Found
        First contacts (n,).
    near : Numbered
        Local minima at most TIP_START_MODULES above the smallest scanned f of all tooth pairs (with `each`:
        of their own tooth pair), with their positions.
    alone : Numbered
        First contacts of single tooth pairs, with their positions; empty unless `each`.
    """
    # Positions solved together.
    positions_per_block = 512
    block = max(1, positions_per_block * GRID_POINTS[1][0][2] // grids[1].shape[1])
    every = np.arange(engagement.roll.size)
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = [
            _solved(engagement, every[start : start + block], pairs, grids, each)
            for start in range(0, max(1, every.size), block)
        ]
    first, near, alone = zip(*parts, strict=True)
    return joined(first), _numbered(near), _numbered(alone)


def _numbered(parts: tuple[Numbered, ...]) -> Numbered:
    position, contacts = zip(*parts, strict=True)
    return np.concatenate(position), joined(contacts)


def in_step(engagement: Engagement, unknown: Mask, grids: Grids) -> Engagement:
    """Return the engagement with a reference phase where there is no conjugate phase.

    Parameters
    ----------
    engagement : Engagement
    unknown : ndarray of bool, shape (cases, positions)
        Positions without conjugate phase. They get the phase of the contact at the first position of their
        case whose nearest tooth can touch.
    grids : Grids

    Returns
    -------
    Engagement
    """
    position = np.flatnonzero(unknown)
    task = replace(engagement.task(position, engagement.nearest[position]), period=2.0 * np.pi)
    f, phase = np.full(unknown.size, np.inf), engagement.phase.copy()
    with np.errstate(invalid="ignore", divide="ignore"):
        f[position] = scan_of(task, grids[1], grids[2]).within
    touches = np.isfinite(f).reshape(unknown.shape)
    first = np.take_along_axis(f.reshape(unknown.shape), touches.argmax(axis=1)[:, None], axis=1)
    added = np.where(unknown & np.isfinite(first), engagement.gear.sigma * first / engagement.lever, 0.0)
    return replace(engagement, phase=phase + added.reshape(-1))


def _solved(
    engagement: Engagement, positions: Integers, pairs: ArrayLike | None, grids: Grids, each: bool
) -> tuple[Found, Numbered, Numbered]:
    """Return the results of `found_with_others` for one block of positions."""
    # Clearance above the smallest scanned one up to which a tooth pair is searched.
    pair_spare_modules = 0.25
    near = engagement.near if pairs is None else np.atleast_1d(pairs)
    position, pair = (x.ravel() for x in np.meshgrid(positions, near, indexing="ij"))
    if pairs is None:
        pair = pair + engagement.nearest[position]
    rough = scan_of(engagement.task(position, pair), grids[0], grids[2], pairs is None)
    first, count = positions[:1].sum(), positions.size
    best, bottom = np.full(count, np.inf), np.zeros(count, dtype=bool)
    np.minimum.at(best, position - first, rough.within)
    # Continue with the pairs that are not much later than the first.
    latest = best[position - first] + pair_spare_modules * engagement.module
    candidates = np.flatnonzero(rough.f.min(axis=1) <= latest)
    position, pair = position[candidates], pair[candidates]
    task, group = engagement.task(position, pair), position - first
    scan = scan_of(task, grids[1], grids[2], pairs is None)
    np.minimum.at(best, group, scan.within)
    line = _lines_at(task)
    np.minimum.at(best, group, line)
    bottom[group[scan.bottom]] = True
    of_pair = np.minimum(np.minimum(rough.within[candidates], scan.within), line)
    known = of_pair if each else best[group]
    known = np.where(bottom[group], -np.inf, known)  # tips on bottom lands: no search
    least, row, periods, distinct = _searched(task, scan, grids[1], known, engagement.module, line)
    turned = pair[row] - engagement.again * periods
    contacts = _chosen(engagement, positions, least, group[row], turned, best, bottom)
    local, solved = least.pick(distinct), np.full(distinct.size, FirstStatus.SOLVED, dtype=np.int8)
    others = Found(local.f, local.place, local.meeting, local.limit, turned[distinct], solved)
    if not each:
        return contacts, (position[row[distinct]], others), (position[:0], others.pick(distinct[:0]))
    lone = np.flatnonzero(periods == 0)
    alone = _chosen(engagement, position, least.pick(lone), row[lone], pair[row[lone]], of_pair, scan.bottom)
    return contacts, (position[row[distinct]], others), (position, alone)


def _lines_at(task: Task) -> FloatArray:
    """Return f (n,), mm, of the tooth pairs that touch along a line at this roll; infinite for the others."""
    if task.line is None:
        return np.full(task.roll.size, np.inf)
    f, _, _, share = task.line
    return np.where((share >= -1e-12) & (share <= 1.0 + 1e-12), f, np.inf)


def _with_lines(
    task: Task, line: FloatArray, least: LocalMinima, row: Integers, periods: Integers
) -> tuple[LocalMinima, Integers, Integers]:
    """Return the local minima with one point for each tooth pair that touches along a line at f = `line`
    (tasks,). Other points of the line, and its ends on edges, must not become earlier contacts by
    rounding."""
    touching = np.flatnonzero(np.isfinite(line))
    if task.line is None or not touching.size:
        return least, row, periods
    flat = task.line[0, row]
    level = np.abs(least.f - flat) <= 1e-12 * task.lever
    least.f[level] = flat[level]
    least.outside[level & np.isfinite(line[row])] = np.inf
    here = task.pick(touching)
    place = task.line[1:3, touching]
    points = LocalMinima(
        place=place,
        f=line[touching],
        meeting=local_at(here, *place).meeting,
        limit=np.full(place.shape, -1, dtype=np.int8),
        outside=np.zeros(touching.size),
        converged=np.ones(touching.size, dtype=bool),
    )
    none = np.zeros_like(touching)
    return joined((least, points)), np.append(row, touching), np.append(periods, none)


def _searched(
    task: Task, scan: Scan, grid: Grid, known: FloatArray, module: float, line: FloatArray
) -> tuple[LocalMinima, Integers, Integers, Integers]:
    """Return the local minima of tooth pairs; the number of the pair and the periods of each; and the
    numbers of the distinct minima that lie within the limits and are not much later than the smallest
    `known` f (tasks,). Flanks that touch along a `line` (tasks,) touch nowhere earlier, so that only
    the neighbourhood of the fillets is searched there."""
    starts = starts_of(task, scan, grid, known, module)
    if np.isfinite(line).any():
        starts = starts.pick(np.flatnonzero(np.isinf(line[starts.row]) | near_fillets(task, starts, grid)))
    pairs, row, periods = task, starts.row, starts.periods
    task = task.pick(row).later(periods)
    owner = row + periods * scan.bottom.size
    least = minimum_clearances(task.with_fillets_at(starts.place), starts.place, starts.box, owner)
    # Minima close to a fillet: start again from tip edges on the fillet.
    close = np.flatnonzero(least.converged & (least.f <= known[row] + TIP_START_MODULES * module))
    places = np.concatenate((row[None, close], np.rint(1e6 / grid.cell[0] * least.place[:, close])))
    close = close[~repeated(places)]
    more = tip_edge_starts(task.pick(close), least.place[:, close], grid)
    if more.row.size:
        again = close[more.row]
        near = task.pick(again).with_fillets_at(more.place)
        least = joined((least, minimum_clearances(near, more.place, more.box, owner[again])))
        row, periods = np.append(row, row[again]), np.append(periods, periods[again])
        close = np.append(close, np.arange(row.size - again.size, row.size))
    if pairs.edged:  # undercut
        count = row.size
        least, origin = across_edges(pairs.pick(row).later(periods), least, 0.25 * np.array(grid.cell))
        row, periods = row[origin], periods[origin]
        beyond = np.arange(count, row.size)
        early = least.f[beyond] <= known[row[beyond]] + TIP_START_MODULES * module
        close = np.append(close, beyond[least.converged[beyond] & early])
    on = least.converged & (least.outside <= ON_LIMIT_DEPTHS * task.depth)
    return *_with_lines(pairs, line, least, row, periods), close[on[close]]


def _chosen(
    engagement: Engagement,
    positions: Integers,
    least: LocalMinima,
    group: Integers,
    pair: Integers,
    scanned: FloatArray,
    bottom: Mask,
) -> Found:
    """Return the smallest local minimum of each `group` and its status, from the `positions` and the
    smallest scanned f."""
    depth, n = engagement.pinion.tip - engagement.pinion.root, positions.size
    on = least.outside <= ON_LIMIT_DEPTHS * depth
    f = np.where(on & least.converged, least.f, np.inf)
    lowest, lost = np.full(n, np.inf), np.full(n, np.inf)
    np.minimum.at(lowest, group, f)
    np.minimum.at(lost, group, np.where(on & ~least.converged, least.f, np.inf))
    # Among contacts at the same time, prefer tangencies to edges, then the pair that came into mesh last, so
    # that rounding does not decide.
    behind = ~(f <= lowest[group] + SAME_ROLL_RAD * engagement.lever)
    order = np.lexsort((f, engagement.pinion.sigma * pair, least.limit[0] >= 0, behind, group))
    groups, first = np.unique(group[order], return_index=True)
    index = np.full(n, -1)  # the appended last column: no contact
    index[groups] = order[first]
    f = np.append(f, np.inf)[index]
    limit = np.append(least.limit, np.full((2, 1), np.int8(-1)), axis=1)[:, index]
    doubt = np.minimum(lost, scanned) < f - 1e-8 * depth
    no_place = np.full((2, 1), np.nan)
    place, meeting = (np.append(row, no_place, axis=1)[:, index] for row in (least.place, least.meeting))
    # The root limit below the joint is the bottom land; above, it is the undercut edge.
    rooted = (limit == Limit.PINION_ROOT).any(axis=0) & (place[0] < engagement.pinion.joint)
    rooted |= (limit == Limit.GEAR_ROOT).any(axis=0) & (meeting[0] < engagement.gear.joint)
    # Beyond, the next turn may be counted.
    most = 0.8 * OVERLAP_PERIODS * engagement.period * engagement.lever
    cases = (
        (~engagement.defined[positions], FirstStatus.UNDEFINED),
        (np.full(f.shape, engagement.pinion.lost or engagement.gear.lost), FirstStatus.UNDERCUT),
        (bottom | rooted, FirstStatus.MEETS_BOTTOM),
        (np.minimum(f, scanned) < -most, FirstStatus.OUT_OF_STEP),
        (doubt, FirstStatus.NOT_CONVERGED),
        (np.isinf(f), FirstStatus.NO_CONTACT),
    )
    status = np.full(f.shape, FirstStatus.SOLVED)
    for case, code in reversed(cases):  # the first that applies
        status[case] = code
    bad = status != FirstStatus.SOLVED
    return Found(
        f=np.where(bad, np.nan, f),
        place=np.where(bad, np.nan, place),
        meeting=np.where(bad, np.nan, meeting),
        limit=np.where(bad, np.int8(-1), limit),
        pair=np.where(bad, 0, np.append(pair, 0)[index]),
        status=status.astype(np.int8),
    )
