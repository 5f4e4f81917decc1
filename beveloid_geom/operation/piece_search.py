"""Which pieces the curve of first contact consists of: found at even rolls, checked at others.

First contacts at some rolls tell who carries there (`pieces.fitted`). At other rolls, most of them close to
the pieces' ends, the search is asked again: a piece that is late there, or does not meet the next, is divided
and looked at more closely. A case of which the pieces do not agree in the end is NOT_CONVERGED.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..status import FirstStatus
from .first_contact import Found, Grids, Integers, Mesh, found_at
from .least_clearance import FEASIBLE
from .pieces import DEGREE, QUANTITIES, SAMPLES, Pieces, Samples, fitted, held_to, holding, tails_of

MOST = 1000
"""Samples of a case on the average beyond which no piece is divided any more."""
PLACED = np.array((1e-14, 1e-11, 1e-11, 1e-11, 1e-11))
"""What the last coefficients of f, over the lever, and of places, over the tooth depth, may reach while there
are rounds left."""
CHECKS, ROUNDS = np.array((-0.95, 0.1, 1.0)), 8
"""Where in a piece, from -1 to 1, it is checked; how often pieces that fail are divided."""
CLOSER = np.array((-0.8, -0.6, -0.4, -0.2, 0.3, 0.5, 0.7))
"""Where first contacts are looked for besides in pieces that fail."""
CHECKED = 3e-11
"""rad of the gear's roll by which a piece may lie behind a first contact."""
BESIDE = np.array((-1e-3, -1e-5, 1e-5, 1e-3))
"""Pitches from a jump at which first contacts are looked for that have not been seen."""


def _sampled(mesh: Mesh, grids: Grids, case: Integers, roll: FloatArray) -> Samples:
    return Samples(case, roll, np.zeros(case.size, dtype=bool), found_at(mesh.at(case, roll), grids))


def samples_of(mesh: Mesh) -> tuple[Integers, FloatArray]:
    """Cases and rolls (n,), rad, at which first contacts tell the carriers over a pitch from the rolls of a
    mesh on, of which each is a case."""
    share, cases = np.linspace(0.0, 1.0, SAMPLES + 1), mesh.roll.size
    case = np.arange(cases).repeat(share.size)
    return case, mesh.roll[case] + np.tile(mesh.pitch[0] * share, cases)


def pieces_of(mesh: Mesh, grids: Grids, found: Found | None = None) -> tuple[Pieces, Integers]:
    """Pieces over a pitch of the pinion from the rolls of a mesh on, of which each is a case, and the status
    of the cases, codes of `FirstStatus`: of the first roll that is not SOLVED. Such a case has no pieces.
    `found`: the first contacts at `samples_of` the mesh, if they are known."""
    case, roll = samples_of(mesh)
    found = found_at(mesh.at(case, roll), grids) if found is None else found
    samples, cases = Samples(case, roll, np.zeros(case.size, dtype=bool), found), mesh.roll.size
    status, done = np.zeros(cases, dtype=np.int64), []
    for count in range(ROUNDS):
        bad = np.flatnonzero(samples.found.status != FirstStatus.SOLVED)[::-1]
        status[samples.case[bad]] = samples.found.status[bad]
        samples = samples.pick(status[samples.case] == FirstStatus.SOLVED)
        if not 0 < samples.case.size <= MOST * cases:
            break
        pieces = fitted(mesh, samples)
        checks, good = _checked(mesh, grids, pieces, count < ROUNDS // 2)
        jumps, samples = _overtaken(mesh, samples, pieces)
        bad = np.union1d(np.flatnonzero(~good.all(axis=1)), np.append(jumps, jumps + 1))
        failed = np.isin(np.arange(cases), pieces.case[bad])
        if failed.any():
            checks = checks.and_also(_between(mesh, grids, samples, pieces, bad, jumps))
        done.append(pieces.pick(~failed[pieces.case]))
        samples = samples.pick(failed[samples.case]).and_also(checks.pick(failed[checks.case]))
    status[samples.case] = np.where(status[samples.case], status[samples.case], FirstStatus.NOT_CONVERGED)
    return _joined(done), status


def _between(
    mesh: Mesh, grids: Grids, samples: Samples, pieces: Pieces, bad: Integers, jumps: Integers
) -> Samples:
    """First contacts at more rolls within the pieces `bad` and beside those at whose end the curve jumps."""
    start, stop = samples.ends(pieces.case[jumps])
    beside = np.clip(pieces.high[jumps, None] + mesh.pitch[0] * BESIDE, start[:, None], stop[:, None])
    case = np.append(pieces.case[bad].repeat(CLOSER.size), pieces.case[jumps].repeat(BESIDE.size))
    return _sampled(mesh, grids, case, np.append(pieces.rolls(CLOSER)[bad], beside))


def _checked(mesh: Mesh, grids: Grids, pieces: Pieces, strict: bool) -> tuple[Samples, NDArray[np.bool_]]:
    """First contacts at other rolls, and whether (n, CHECKS) the pieces are as early there and, if `strict`,
    their places known. A piece may be earlier, within all limits: a search missed its contact, and what it
    found is left out."""
    roll, each = pieces.rolls(CHECKS), np.arange(pieces.case.size)
    checks = _sampled(mesh, grids, pieces.case.repeat(roll.shape[1]), roll.ravel())
    values, bound = pieces.values(each, roll), CHECKED * mesh.lever
    behind = values[0] - checks.found.f.reshape(roll.shape)
    earlier = np.asarray(behind < -bound)
    if earlier.any():
        piece = each.repeat(roll.shape[1])
        there, within = _moved(mesh, checks.case, checks.roll, pieces, piece, values[1:3].reshape(2, -1))
        earlier &= within.reshape(roll.shape)
        earlier &= np.abs(values[0] - there[0].reshape(roll.shape)) <= bound
    sizes = np.array((mesh.lever, *[mesh.own.tip - mesh.own.root] * (QUANTITIES - 1)))
    most = PLACED * sizes if strict else np.full(QUANTITIES, np.inf)
    placed = np.asarray((tails_of(pieces) <= most[:, None]).all(axis=0))
    good = np.asarray(((np.abs(behind) <= bound) | earlier) & placed[:, None])
    checks = replace(checks, cut=~good.ravel())
    return checks.pick(~earlier.ravel()), good


def _moved(
    mesh: Mesh, case: Integers, roll: FloatArray, pieces: Pieces, piece: Integers, place: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Contacts near places (2, n) at rolls that are carried as the pieces: f, s1, z1, s2, z2 (5, n), and
    whether they lie within the limits."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        task = mesh.at(case, roll).task(np.arange(case.size), pieces.pair[piece])
        place, found = held_to(task, place, pieces.limit[:, piece])
        margin = np.where(holding(pieces.limit[:, piece]), 0.0, found.margin)
    values = np.concatenate((found.f[None], place, found.meeting))
    return values, np.asarray((margin >= -FEASIBLE * task.depth).all(axis=0))


def _overtaken(mesh: Mesh, samples: Samples, pieces: Pieces) -> tuple[Integers, Samples]:
    """Pieces at whose end the curve jumps, as a contact between was not seen, or an earlier one missed; and
    the samples, of the pieces behind those that their neighbours are carried by, if these are earlier."""
    inner = np.flatnonzero(pieces.case[1:] == pieces.case[:-1])
    ends = [pieces.values(inner + k, pieces.high[inner, None])[..., 0] for k in (0, 1)]
    jump, found = ends[0][0] - ends[1][0], samples.found
    own = pieces.number(mesh, samples.case, samples.roll)
    for k in np.flatnonzero(np.abs(jump) > CHECKED * mesh.lever):
        early = int(jump[k] > 0.0)
        row = np.flatnonzero(own == inner[k] + 1 - early)
        place = ends[early][1:3, k, None].repeat(row.size, axis=1)
        piece = np.full(row.size, inner[k] + early)
        values, within = _moved(mesh, samples.case[row], samples.roll[row], pieces, piece, place)
        better = np.flatnonzero(within & (values[0] < found.f[row]))
        row, values, piece = row[better], values[:, better], piece[better]
        found.f[row], found.place[:, row], found.meeting[:, row] = values[0], values[1:3], values[3:]
        found.limit[:, row], found.pair[row] = pieces.limit[:, piece], pieces.pair[piece]
    return inner[np.abs(jump) > CHECKED * mesh.lever], samples


def _joined(parts: list[Pieces]) -> Pieces:
    """All of them, in order of case and roll."""
    none, no, rows = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0), dtype=np.int8)
    empty = Pieces(none, no, no, np.zeros((QUANTITIES, 0, DEGREE + 1)), none, rows, rows > 0)
    columns = zip(*(vars(part).values() for part in (empty, *parts)), strict=True)
    pieces = Pieces(*(np.concatenate(column, axis=min(1, column[0].ndim - 1)) for column in columns))
    return pieces.pick(np.lexsort((pieces.low, pieces.case)))
