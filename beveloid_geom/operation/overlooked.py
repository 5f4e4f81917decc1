"""What samples of a mesh cycle overlook: pieces that are late, and contacts that carry only between samples.

A contact that carries for less than the distance of two samples is one of these, which are followed, or
seen where pieces do not meet:

    a carrier that comes back beside its piece
    a contact that another was ahead of at a sample beside the end of a piece
    the contact on fewer limits than a piece's, as where an edge's becomes a tangency
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..status import FirstStatus
from ..support.chebyshev import basis_of
from .first_contact import Found, Mesh
from .least_clearance import FEASIBLE
from .pieces import QUANTITIES, SAMPLES, Pieces, Samples, held_to, holding, order_of, samples_of, tails_of

Followed: TypeAlias = tuple[Integers, FloatArray, FloatArray, Codes, Integers]
"""Contacts to be followed: case, roll (rad), place near by (2, n), mm, limits (2, n) and tooth pair."""

PLACED = np.array((1e-14, 1e-11, 1e-11, 1e-11, 1e-11))
"""What the last coefficients of f, over the lever, and of places, over the tooth depth, may reach while there
are rounds left."""
CHECKED = 3e-11
"""rad of the gear's roll by which a piece may lie behind a first contact."""
ROLLS = 64
"""Rolls of a pitch at which a carrier may come back."""
RELEASED = basis_of(8).nodes
"""Where in a piece, from -1 to 1, contacts are followed that one of its limits no longer holds back."""
STEPS = 4
"""Newton steps after which a contact that is followed is taken to be none."""
AWAY = 1.0
"""Lengths of a piece beyond its ends at which it is asked whether its carrier comes back."""


def checked(
    mesh: Mesh, pieces: Pieces, piece: Integers, checks: Samples, strict: bool
) -> tuple[Samples, Integers]:
    """Give first contacts `checks` (n,) as samples that cut pieces where the `piece` there (n,) is not as
    early; and which pieces are not or, if `strict`, whose places are not known. A piece may be earlier,
    within all limits: a search missed its contact, and what it found is left out."""
    values, bound = pieces.values_at(piece, checks.roll), CHECKED * mesh.lever
    behind = values[0] - checks.found.f
    good, earlier = np.abs(behind) <= bound, np.asarray(behind < -bound)
    if earlier.any():
        row = np.flatnonzero(earlier)
        carriers = pieces.limit[:, piece[row]], pieces.pair[piece[row]]
        there, within = _followed(mesh, checks.case[row], checks.roll[row], values[1:3, row], *carriers)
        earlier[row] = within & (np.abs(values[0, row] - there[0]) <= bound)
    sizes = np.array((mesh.lever, *[mesh.own.tip - mesh.own.root] * (QUANTITIES - 1)))
    most = PLACED * sizes if strict else np.full(QUANTITIES, np.inf)
    bad = np.asarray((~(tails_of(pieces) <= most[:, None])).any(axis=0))
    bad[piece[~good & ~earlier]] = True
    checks = replace(checks, cut=checks.cut | ~good)
    return checks.pick(~earlier), np.flatnonzero(bad)


def overtaken(mesh: Mesh, samples: Samples, pieces: Pieces) -> tuple[Integers, Integers, Samples]:
    """Give pieces at whose end the curve jumps, as a contact between was not seen; cases in which it jumped
    as an earlier one was missed; and the samples, those of the pieces behind carried as their neighbours if
    these are earlier."""
    inner = _inner(pieces)
    ends = np.stack([pieces.values_at(inner + k, pieces.high[inner]) for k in (0, 1)])
    jump, found = ends[0, 0] - ends[1, 0], samples.found
    jumps = np.flatnonzero(np.abs(jump) > CHECKED * mesh.lever)
    if not jumps.size:
        return jumps, jumps, samples
    early = (jump[jumps] > 0.0).astype(int)
    own = pieces.number(mesh, samples.case, samples.roll)
    which, row = np.nonzero(own == (inner[jumps] + 1 - early)[:, None])
    piece, place = (inner[jumps] + early)[which], ends[early, 1:3, jumps].T[:, which]
    carriers = pieces.limit[:, piece], pieces.pair[piece]
    values, within = _followed(mesh, samples.case[row], samples.roll[row], place, *carriers)
    better = np.flatnonzero(within & (values[0] < found.f[row]))
    better = better[np.argsort(-values[0, better], kind="stable")]  # of two neighbours the earlier comes last
    row, values, piece, which = row[better], values[:, better], piece[better], which[better]
    which = which[values[0] < found.f[row] - CHECKED * mesh.lever]
    found.f[row], found.place[:, row], found.meeting[:, row] = values[0], values[1:3], values[3:]
    found.limit[:, row], found.pair[row] = pieces.limit[:, piece], pieces.pair[piece]
    jumps = inner[jumps]
    return np.delete(jumps, which), pieces.case[jumps[which]], samples


def earlier(mesh: Mesh, pieces: Pieces, near: Samples) -> Samples:
    """Give contacts that are earlier than the pieces at the same roll, of `near` all found at samples."""
    parts = _beside(mesh, pieces), _near_ends(mesh, pieces, near), _on_fewer_limits(pieces)
    case, roll, pair = (np.concatenate([part[k] for part in parts]) for k in (0, 1, 4))
    place, limit = (np.concatenate([part[k] for part in parts], axis=1) for k in (2, 3))
    values, within = _followed(mesh, case, roll, place, limit, pair)
    there = pieces.values_at(pieces.number(mesh, case, roll), roll, 1)[0]
    row = np.flatnonzero(within & (values[0] < there - CHECKED * mesh.lever))
    values, solved = values[:, row], np.full(row.size, FirstStatus.SOLVED, dtype=np.int8)
    found = Found(values[0], values[1:3], values[3:], limit[:, row], pair[row], solved)
    return samples_of(case[row], roll[row], found)


def _beside(mesh: Mesh, pieces: Pieces) -> Followed:
    """Give the carriers of pieces beside these."""
    piece = np.arange(pieces.case.size).repeat(ROLLS)
    roll = mesh.roll[pieces.case[piece]] + mesh.pitch[0] * np.tile(np.arange(ROLLS) / ROLLS, pieces.case.size)
    away = np.maximum(pieces.low[piece] - roll, roll - pieces.high[piece])
    beside = (away > 0.0) & (away < AWAY * (pieces.high - pieces.low)[piece])
    piece, roll, ends = piece[beside], roll[beside], pieces.rolls(np.array((-1.0, 0.0, 1.0)))
    first, middle, last = pieces.values(np.arange(pieces.case.size), ends)[1:3, piece].transpose(2, 0, 1)
    way = (roll - ends[piece, 1]) / (ends[piece, 2] - ends[piece, 1])  # on along a parabola
    place = middle + 0.5 * way * (last - first + way * (first - 2.0 * middle + last))
    return pieces.case[piece], roll, place, pieces.limit[:, piece], pieces.pair[piece]


def _near_ends(mesh: Mesh, pieces: Pieces, near: Samples) -> Followed:
    """Give contacts `near` samples at the ends of pieces next before and after, no further than the next
    sample."""
    inner = _inner(pieces)
    ends = order_of(mesh, pieces.case[inner], pieces.high[inner])
    after = np.searchsorted(ends, order_of(mesh, near.case, near.roll))
    row, nearest = np.tile(np.arange(near.case.size), 2), np.append(after - 1, after)
    known = (nearest >= 0) & (nearest < inner.size)
    row, end = row[known], inner[nearest[known]]
    away = np.abs(pieces.high[end] - near.roll[row])
    close = (near.case[row] == pieces.case[end]) & (away <= mesh.pitch[0] / SAMPLES)
    row, found = row[close], near.found
    return near.case[row], pieces.high[end[close]], found.place[:, row], found.limit[:, row], found.pair[row]


def _on_fewer_limits(pieces: Pieces) -> Followed:
    """Give the contacts with one limit less along pieces."""
    every, roll = np.arange(pieces.case.size), pieces.rolls(RELEASED)
    piece, place = every.repeat(RELEASED.size), pieces.values(every, roll)[1:3].reshape(2, -1)
    first, second = pieces.limit[:, piece]
    less = np.array(((second, first), np.full((2, piece.size), -1, dtype=np.int8)))
    which, row = np.nonzero((first >= 0, second >= 0))
    piece = piece[row]
    return pieces.case[piece], roll.ravel()[row], place[:, row], less[:, which, row], pieces.pair[piece]


def _inner(pieces: Pieces) -> Integers:
    """Give the pieces that another one of the same case follows."""
    return np.flatnonzero(pieces.case[1:] == pieces.case[:-1])


def _followed(
    mesh: Mesh, case: Integers, roll: FloatArray, place: FloatArray, limit: Codes, pair: Integers
) -> tuple[FloatArray, Mask]:
    """Give contacts of tooth pairs (n,) near places (2, n) at rolls, held to the limits (2, n): f, s1, z1,
    s2, z2 (5, n), and whether they lie within the others."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        task = mesh.at(case, roll).task(np.arange(case.size), pair)
        values = held_to(task, place, limit, STEPS)
        margin = np.where(holding(limit), 0.0, values[QUANTITIES:])
    return values[:QUANTITIES], np.asarray((margin >= -FEASIBLE * task.depth).all(axis=0))
