"""The operating contact ratio: how many tooth pairs are in contact, edges and fillets included.

A tooth pair is in contact where it is the first of all to touch, or within a given thickness of it,
as of a lubricant film or marking compound. The roll over which one pair is, over the pitch, is
the operating contact ratio. Unmodified pairs have the contact ratio of Eq. 16; modified flanks of
rigid teeth touch in one point at a time and have 1, unless given a thickness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..contact.path import contact_ratio
from ..design.model import Design
from ..status import FirstStatus, RatioStatus
from ..support.few_lines import few_lines
from .first_contact import TOGETHER, Found, Grids, Mesh, found_at
from .least_clearance import OVERLAP
from .mesh_cycle import MeshCycle, conjugate_lines, cycle_and_pairs, in_order
from .overlooked import CHECKED
from .pieces import SAMPLES as STEPS, Pieces, Samples, fitted, samples_of

Label: TypeAlias = Callable[[Integers, FloatArray], Integers]
"""Labels (n, rolls) of the cases with the numbers (n,) at rolls (n, rolls), rad."""

SAMPLES = 96
"""Rolls of a pitch at which a tooth pair alone is compared with the first to touch."""
DIVISIONS, CHANGE_WIDTH, MOST_CHANGES = 64, 1e-10, 64
"""Parts into which an interval with a change is divided at a time, until it is as narrow as this, in
pitches; changes in a cycle beyond which they are taken for rounding and divided no more."""
ASIDE = 1e-3
"""Modules beyond the thickness up to which a tooth pair alone is followed."""
GAP = 1.5
"""Steps between the samples of a tooth pair alone beyond which there are none between."""
ASTRAY = 0.1
"""Share of the room between a tooth pair alone and a thickness that its pieces may miss each other by: where
a carrier between them was not seen, it is not much earlier."""
ROUNDS, BETWEEN = 5, np.array((0.1, 0.3, 0.45, 0.6, 0.8, 0.95))
"""How often pieces of a tooth pair alone are fitted; shares of the way between two samples at which it is
searched for where its pieces do not meet."""
AT_LEAST = 1.0 - 1e-6
"""Operating contact ratio of any pair, less what rounding may take: at every roll some tooth pair touches."""


@dataclass(frozen=True, eq=False)
class OperatingRatios:
    """Operating contact ratios (thicknesses, *batch), NaN where not known, and their `status`, codes of
    `RatioStatus`; the `cycle` that they are of."""

    __repr__ = few_lines

    ratio: FloatArray
    status: Codes
    cycle: MeshCycle


def operating_ratio(design: Design, flank: str = "right", thickness: float = 0.0) -> FloatArray:
    """Give the operating contact ratio of the batch shape: pinion roll over which a tooth pair is the first
    to touch, or its clearance along the normal is within `thickness` (mm) of the first's, over the pitch. NaN
    where it is not known; `operating_ratios` says why.

    Members must be single; pair and errors may be arrays. Raises ValueError for members of arrays
    and a negative thickness."""
    return np.asarray(operating_ratios(design, flank, (thickness,)).ratio[0])


def operating_ratios(
    design: Design, flank: str, thicknesses: tuple[float, ...], harmonics: int = 1
) -> OperatingRatios:
    """Give `operating_ratio` for several thicknesses (mm) at little more than the cost of one, with its
    status, and the mesh cycle with so many harmonics.

    Raises ValueError as `operating_ratio` and `mesh_cycle` do."""
    for thickness in thicknesses:
        if not thickness >= 0.0:
            raise ValueError(f"thickness must be at least 0 mm, got {thickness}")
    cycle, grids, samples, each = cycle_and_pairs(design, flank, harmonics)
    shape, alone = design.batch_shape, _of_one_pair(cycle.mesh, samples, *each)
    lost, mesh = cycle.lost.reshape(-1), cycle.mesh
    ratio = np.full((len(thicknesses), lost.size), np.nan)
    status = np.full(ratio.shape, RatioStatus.NO_FIRST_CONTACT, dtype=np.int8)
    lines = np.flatnonzero(conjugate_lines(design, flank).reshape(-1) & ~lost)
    eq16 = contact_ratio(design, flank).reshape(-1) if lines.size else np.empty(0)
    useful = [size for size in thicknesses if size < mesh.period * mesh.lever]
    pieces, followed = _pieces_alone(cycle, grids, alone, np.array(useful or [0.0]))
    share = np.arange(-mesh.reach * SAMPLES, mesh.reach * SAMPLES + 1) / SAMPLES
    for contacts in (partial(_alone, cycle, pieces), partial(_searched, cycle, grids)):
        known = np.flatnonzero(followed & ~lost)
        if known.size:
            roll = mesh.roll[known, None] + mesh.pitch[0] * share
            curves = _first(cycle, known, roll), contacts(known, roll)
            for k, thickness in enumerate(thicknesses):
                ratio[k, known], status[k, known] = _ratio(cycle, contacts, known, roll, curves, thickness)
                if thickness == 0.0 and lines.size:  # which of them is first is a matter of rounding
                    ratio[k, lines], status[k, lines] = eq16[lines], RatioStatus.KNOWN
        # By search those that the pieces do not tell.
        followed = ~followed | (status == RatioStatus.UNSTEADY).any(axis=0)
    ratio[status != RatioStatus.KNOWN] = np.nan
    shape = (len(thicknesses), *shape)
    return OperatingRatios(ratio.reshape(shape), status.reshape(shape), cycle)


@dataclass(frozen=True, eq=False)
class _Curve:
    """Contacts (cases, rolls): f (mm), infinite without one, whether it is an edge, and whether it is in
    doubt what touches, if anything."""

    f: FloatArray
    edge: Mask
    doubt: Mask


Contacts: TypeAlias = Callable[[Integers, FloatArray], _Curve]
"""Contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls)."""


def _first(cycle: MeshCycle, case: Integers, roll: FloatArray) -> _Curve:
    """Give first contacts of the cases (n,) at rolls (n, rolls), of all tooth pairs."""
    piece, _, values = cycle.located(case.repeat(roll.shape[1]), roll.ravel(), 1)
    edge = cycle.pieces.limit[0, piece] >= 0
    return _Curve(values.reshape(roll.shape), edge.reshape(roll.shape), np.zeros(roll.shape, dtype=bool))


def _first_and_whose(cycle: MeshCycle, case: Integers, roll: FloatArray) -> tuple[FloatArray, Mask]:
    """Give f (mm) of the first contacts of the cases at rolls, (n,), and where they are those of tooth pair
    0."""
    piece, turns, values = cycle.located(case, roll, 1)
    return values[0], np.asarray(cycle.pieces.pair[piece] == turns)


def _of_one_pair(mesh: Mesh, samples: Samples, position: Integers, found: Found) -> Samples:
    """Give contacts of tooth pair 0 alone, in order of case and roll, from those of each pair near at samples
    of a cycle: pair k at a roll is pair 0 k pitches on; each is known once."""
    turned = samples.roll[position] + found.pair * mesh.pitch[0]
    # The last roll of a cycle is the first one of the next tooth pair.
    once = np.flatnonzero((position % (STEPS + 1) < STEPS) & (found.status == FirstStatus.SOLVED))
    order = once[np.lexsort((turned[once], samples.case[position[once]]))]
    rows = {name: value[..., order] for name, value in vars(found).items()}
    alone = Found(**rows | {"pair": np.zeros(order.size, dtype=np.int64)})
    return samples_of(samples.case[position[order]], turned[order], alone)


def _pieces_alone(
    cycle: MeshCycle, grids: Grids, samples: Samples, thicknesses: FloatArray
) -> tuple[Pieces, Mask]:
    """Give pieces of tooth pair 0 alone through its samples, and in which cases they are sure to tell where
    it is within each of the `thicknesses` (mm) of the first: they agree with the samples, meet wherever that
    matters, and end further off than the greatest. Where they do not meet they are divided."""
    mesh, lost = cycle.mesh, cycle.lost.reshape(-1)
    thickness = float(thicknesses.max())
    samples = samples.pick(np.flatnonzero(~lost[samples.case]))
    off = samples.found.f - _first(cycle, samples.case, samples.roll[:, None]).f[:, 0]
    # As far as it may touch and one sample on.
    near = np.pad(off <= thickness + ASIDE * mesh.module, 1)
    chosen = np.flatnonzero(near[1:-1] | near[2:] | near[:-2])
    samples, off = samples.pick(chosen), off[chosen]
    # Where every tooth is near, one is near on more than one turn, which a scan does not tell apart.
    many = mesh.near.size > 2 * mesh.reach
    followed, case = (np.bincount(samples.case, minlength=lost.size) > 0) & many, samples.case
    samples, ends = _in_runs(mesh, samples)
    followed[case[ends[off[ends] <= thickness + TOGETHER * mesh.lever]]] = False
    # Each run is a case of its own to what fits the pieces.
    case, parts = case[ends[0]], [cycle.pieces.pick(np.zeros(0, dtype=np.int64))]
    runs = replace(mesh.at(case, samples.roll[ends[0]]), span=2.0 * mesh.reach + 2.0)
    for count in range(ROUNDS):
        samples = samples.pick(np.flatnonzero(followed[case[samples.case]]))
        if not samples.case.size:
            break
        pieces = fitted(runs, samples)
        run, roll = _in_doubt(cycle, (runs, case), samples, pieces, thicknesses)
        failed = np.isin(np.arange(case.size), run)
        parts.append(pieces.pick(np.flatnonzero(~failed[pieces.case])))
        samples = samples.pick(np.flatnonzero(failed[samples.case]))
        if count == ROUNDS - 1:
            followed[case[failed]] = False
        elif run.size:
            found = found_at(runs.at(run, roll), grids, 0)
            followed[case[run[found.status != FirstStatus.SOLVED]]] = False
            samples = samples.and_also(samples_of(run, roll, found))
    pieces = in_order([replace(part, case=case[part.case]) for part in parts])
    return pieces.pick(followed[pieces.case]), followed


def _in_doubt(
    cycle: MeshCycle, runs: tuple[Mesh, Integers], samples: Samples, pieces: Pieces, thicknesses: FloatArray
) -> tuple[Integers, FloatArray]:
    """Give rolls (n,), rad, at which more contacts of a tooth pair alone are wanted, and the numbers of their
    runs: where the pieces do not agree with the samples, and between the samples about ends where they do not
    meet. `runs`: as a mesh, and the cases they are of."""
    (mesh, case), bound = runs, CHECKED * cycle.mesh.lever
    own = pieces.number(mesh, samples.case, samples.roll)
    behind = np.abs(pieces.values_at(own, samples.roll, 1)[0] - samples.found.f)
    inner = np.flatnonzero(pieces.case[1:] == pieces.case[:-1])
    ends = np.array([pieces.values_at(inner + k, pieces.high[inner], 1)[0] for k in (0, 1)])
    run, at, jump = pieces.case[inner], pieces.high[inner], np.abs(ends[1] - ends[0])
    # Where it is the first itself the cycle has it; elsewhere a jump matters near a thickness.
    first, ours = _first_and_whose(cycle, case[run], at)
    room = np.abs(ends.min(axis=0) - first - thicknesses[:, None]).min(axis=0)
    apart = ~((jump <= bound) | ours | (jump < ASTRAY * room))
    run, at, late = run[apart], at[apart, None], np.unique(own[~(behind <= bound)])
    same = samples.case == run[:, None]
    low = np.where(same & (samples.roll <= at), samples.roll, -np.inf).max(axis=1, initial=-np.inf)
    high = np.where(same & (samples.roll >= at), samples.roll, np.inf).min(axis=1, initial=np.inf)
    about = low[:, None] + (high - low)[:, None] * BETWEEN
    more = np.append(about, pieces.rolls(2.0 * BETWEEN - 1.0)[late])
    return np.append(run, pieces.case[late]).repeat(BETWEEN.size), more


def _in_runs(mesh: Mesh, samples: Samples) -> tuple[Samples, Integers]:
    """Give the samples with the numbers of the runs to which they belong, without gaps between, as their
    cases; and the first and the last of each run (2, runs)."""
    apart = np.diff(samples.roll) > GAP * mesh.pitch[0] / STEPS
    begins = np.append(samples.case[:1] >= 0, apart | (np.diff(samples.case) != 0))
    first = np.flatnonzero(begins)
    ends = np.stack((first, np.append(first[1:], samples.case.size)[: first.size] - 1))
    return replace(samples, case=np.cumsum(begins) - 1), ends


def _alone(cycle: MeshCycle, pieces: Pieces, case: Integers, roll: FloatArray) -> _Curve:
    """Give contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), by its pieces."""
    mesh, span = cycle.mesh, 4.0 * cycle.mesh.reach
    early = replace(mesh, roll=mesh.roll - 0.5 * span * mesh.pitch[0], span=span)
    case, turned = case.repeat(roll.shape[1]), roll.ravel()
    piece = pieces.number(early, case, turned)
    on = (pieces.case[piece] == case) & (pieces.low[piece] <= turned) & (turned <= pieces.high[piece])
    f = np.full(turned.size, np.inf)
    f[on] = pieces.values_at(piece[on], turned[on], 1)[0]
    first, ours = _first_and_whose(cycle, case, turned)
    f[on & ours] = first[on & ours]
    edge, doubt = on & (pieces.limit[0, piece] >= 0), np.zeros(turned.size, dtype=bool)
    return _Curve(*(row.reshape(roll.shape) for row in (f, edge, doubt)))


def _searched(cycle: MeshCycle, grids: Grids, case: Integers, roll: FloatArray) -> _Curve:
    """Give contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls), searched for."""
    found = found_at(cycle.mesh.at(case.repeat(roll.shape[1]), roll.ravel()), grids, 0)
    f = np.where(found.status == FirstStatus.SOLVED, found.f, np.inf)
    doubt = (found.status != FirstStatus.SOLVED) & (found.status != FirstStatus.NO_CONTACT)
    return _Curve(*(row.reshape(roll.shape) for row in (f, found.limit[0] >= 0, doubt)))


def _divided(case: Integers, roll: FloatArray, labels: Integers, label: Label, least: float) -> _Intervals:
    """Give the intervals between rolls (n, rolls) of the cases over which the labels change, divided until
    narrower than `least` at equal steps, of which every part with a change goes on."""
    share = np.linspace(0.0, 1.0, DIVISIONS + 1)
    found = _with_change(case, roll, labels)
    limit = MOST_CHANGES * max(1, np.unique(found.case).size)
    while 0 < found.case.size <= limit and float((found.high - found.low).max()) > least:
        roll = found.low[:, None] + (found.high - found.low)[:, None] * share
        found = _with_change(found.case, roll, label(found.case, roll))
    return found


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals of roll (n,), rad, of the cases with these numbers."""

    case: Integers
    low: FloatArray
    high: FloatArray


def _with_change(case: Integers, roll: FloatArray, labels: Integers) -> _Intervals:
    """Say of the intervals between rolls (n, rolls) those whose ends have different labels."""
    row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
    return _Intervals(case[row], roll[row, column], roll[row, column + 1])


def _ratio(
    cycle: MeshCycle,
    alone: Contacts,
    case: Integers,
    roll: FloatArray,
    curves: tuple[_Curve, _Curve],
    thickness: float,
) -> tuple[FloatArray, Integers]:
    """Give ratios and their status (cases,), from the `curves` of all pairs and of pair 0 alone at rolls
    (cases, rolls), which `alone` gives at others."""
    mesh, cases = cycle.mesh, cycle.mesh.roll.size

    def touching(first: _Curve, own: _Curve) -> Integers:
        # An edge that a tangency of another pair is ahead of, if only by rounding, does not touch.
        spare = mesh.lever * np.where(own.edge & ~first.edge, -TOGETHER, TOGETHER)
        return np.asarray(own.f - first.f <= thickness + spare).astype(int)

    def touches(cases: Integers, rolls: FloatArray) -> Integers:
        return touching(_first(cycle, cases, rolls), alone(cases, rolls))

    # Further off than this the same teeth are those of another turn.
    most = (1.0 - OVERLAP) * mesh.period * mesh.lever - np.maximum(curves[0].f, 0.0).max(axis=1)
    if (thickness >= most).all():
        return np.full(case.size, np.nan), np.full(case.size, RatioStatus.TOO_THICK)
    inside, width = touching(*curves), CHANGE_WIDTH * mesh.pitch[0]
    ends = _divided(case, roll, inside, touches, width)
    ratio, balance, wide = np.zeros(cases), np.zeros(cases), np.zeros(cases, dtype=bool)
    leaves = touches(ends.case, ends.low[:, None])[:, 0] if ends.case.size else np.zeros(0)
    sign = np.where(leaves, 1.0, -1.0)
    middle = 0.5 * (ends.low + ends.high) - mesh.roll[ends.case]
    np.add.at(ratio, ends.case, sign * middle / mesh.pitch[0])
    np.add.at(balance, ends.case, sign)
    wide[ends.case[ends.high - ends.low > width]] = True
    ratio, balance, wide = ratio[case], balance[case], wide[case]
    beyond = (inside[:, [0, -1]] != 0).any(axis=1) | (thickness >= most)
    faults = (
        (curves[1].doubt.any(axis=1), RatioStatus.NOT_CONVERGED),
        (beyond, RatioStatus.TOO_THICK),
        (wide | (balance != 0.0) | ~(ratio >= AT_LEAST), RatioStatus.UNSTEADY),
    )
    found = np.select([where for where, _ in faults], [code for _, code in faults], RatioStatus.KNOWN)
    return ratio, found
