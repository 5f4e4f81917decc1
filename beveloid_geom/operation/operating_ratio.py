"""The operating contact ratio: how many tooth pairs are in contact, edges and fillets included.

A tooth pair is in contact where it is the first of all to touch, or within a given thickness of it,
as of a lubricant film or marking compound. The roll over which one pair is, over the pitch, is
the operating contact ratio. Unmodified pairs have the contact ratio of Eq. 16; modified flanks of
rigid teeth touch in one point at a time and have 1, unless given a thickness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..design.model import Design
from ..status import FirstStatus, RatioStatus
from ..support.few_lines import few_lines
from .first_contact import TOGETHER, Grids, Integers, found_at, grids_of
from .least_clearance import OVERLAP
from .mesh_cycle import MeshCycle, mesh_cycle

Label: TypeAlias = Callable[[Integers, FloatArray], Integers]
"""Labels (n, rolls) of the cases with the numbers (n,) at rolls (n, rolls), rad."""

SAMPLES = 96
"""Rolls of a pitch at which a tooth pair alone is compared with the first to touch."""
DIVISIONS, CHANGE_WIDTH, MOST_CHANGES = 8, 1e-10, 64
"""Parts into which an interval with a change is divided at a time, until it is as narrow as this, in
pitches; changes in a cycle beyond which they are taken for rounding and divided no more."""
STRIDE = 8
"""A tooth pair alone is looked at on every so many of SAMPLES, and on all where it is near enough to come
to touch between. Its clearance is taken to change by no more than the mesh advances; by a third was seen."""
AT_LEAST = 1.0 - 1e-6
"""Operating contact ratio of any pair, less what rounding may take: at every roll some tooth pair touches."""


@dataclass(frozen=True, eq=False)
class OperatingRatios:
    """Operating contact ratios (thicknesses, *batch), NaN where not known, and their `status`, codes of
    `RatioStatus`."""

    __repr__ = few_lines

    ratio: FloatArray
    status: NDArray[np.int8]


def operating_ratio(design: Design, flank: str = "right", thickness: float = 0.0) -> FloatArray:
    """Operating contact ratio of the batch shape: pinion roll over which a tooth pair is the first to
    touch, or its clearance along the normal is within `thickness` (mm) of the first's, over the
    pitch. NaN where it is not known; `operating_ratios` says why.

    Members must be single; pair and errors may be arrays. Raises ValueError for members of arrays
    and a negative thickness."""
    return np.asarray(operating_ratios(design, flank, (thickness,)).ratio[0])


def operating_ratios(design: Design, flank: str, thicknesses: tuple[float, ...]) -> OperatingRatios:
    """`operating_ratio` for several thicknesses (mm) at little more than the cost of one, with its status.

    Raises ValueError as that does."""
    for thickness in thicknesses:
        if not thickness >= 0.0:
            raise ValueError(f"thickness must be at least 0 mm, got {thickness}")
    cycle, shape = mesh_cycle(design, flank, 1), design.batch_shape
    lost, mesh, grids = cycle.lost.reshape(-1), cycle.mesh, grids_of(cycle.mesh, design, flank)
    known = np.flatnonzero(~lost)
    ratio = np.full((len(thicknesses), lost.size), np.nan)
    status = np.full(ratio.shape, RatioStatus.NO_FIRST_CONTACT, dtype=np.int8)
    if known.size:
        share = np.arange(-mesh.reach * SAMPLES, mesh.reach * SAMPLES + 1) / SAMPLES
        roll = mesh.roll[known, None] + mesh.pitch[0] * share
        first = _first(cycle, known, roll)
        useful = [size for size in thicknesses if size < mesh.period * mesh.lever]
        curves = first, _near(cycle, grids, known, roll, first, max(useful, default=0.0))
        for k, thickness in enumerate(thicknesses):
            ratio[k, known], status[k, known] = _ratio(cycle, grids, known, roll, curves, thickness)
    ratio[status != RatioStatus.KNOWN] = np.nan
    shape = (len(thicknesses), *shape)
    return OperatingRatios(ratio.reshape(shape), status.reshape(shape))


@dataclass(frozen=True, eq=False)
class _Curve:
    """Contacts (cases, rolls): f (mm), infinite without one, whether it is an edge, and whether it is in
    doubt what touches, if anything."""

    f: FloatArray
    edge: NDArray[np.bool_]
    doubt: NDArray[np.bool_]


def _first(cycle: MeshCycle, case: Integers, roll: FloatArray) -> _Curve:
    """First contacts of the cases (n,) at rolls (n, rolls), of all tooth pairs."""
    piece, _, values = cycle.located(case.repeat(roll.shape[1]), roll.ravel(), 1)
    edge = cycle.pieces.limit[0, piece] >= 0
    return _Curve(values.reshape(roll.shape), edge.reshape(roll.shape), np.zeros(roll.shape, dtype=bool))


def _alone(cycle: MeshCycle, grids: Grids, case: Integers, roll: FloatArray) -> _Curve:
    """Contacts of tooth pair 0 of the cases (n,) at rolls (n, rolls)."""
    found = found_at(cycle.mesh.at(case.repeat(roll.shape[1]), roll.ravel()), grids, 0)
    f = np.where(found.status == FirstStatus.SOLVED, found.f, np.inf)
    doubt = (found.status != FirstStatus.SOLVED) & (found.status != FirstStatus.NO_CONTACT)
    return _Curve(*(row.reshape(roll.shape) for row in (f, found.limit[0] >= 0, doubt)))


def _near(
    cycle: MeshCycle, grids: Grids, case: Integers, roll: FloatArray, first: _Curve, thickness: float
) -> _Curve:
    """Pair 0 alone; infinite, as without contact, where it is too far off to matter."""
    n, mesh = roll.shape[1], cycle.mesh
    rough = _alone(cycle, grids, case, roll[:, ::STRIDE])
    off = rough.f - first.f[:, ::STRIDE]
    advance = mesh.lever * mesh.pitch[1] * 0.5 * STRIDE / SAMPLES  # to the nearer of two looked at
    near = ((off <= thickness + advance) | rough.doubt).any(axis=0).repeat(STRIDE)
    # The stride before and the one after each of these.
    chosen = (near | np.append(near[STRIDE:], np.zeros(STRIDE, dtype=bool)))[:n]
    chosen[::STRIDE] = False
    found = _alone(cycle, grids, case, roll[:, chosen])
    curve = _Curve(np.full(roll.shape, np.inf), np.zeros(roll.shape, dtype=bool), np.zeros(roll.shape, bool))
    for columns, part in ((slice(None, None, STRIDE), rough), (chosen, found)):
        for name, value in vars(part).items():
            getattr(curve, name)[:, columns] = value
    return curve


def _divided(case: Integers, roll: FloatArray, labels: Integers, label: Label, least: float) -> _Intervals:
    """The intervals between rolls (n, rolls) of the cases over which the labels change, divided until
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
    """Of the intervals between rolls (n, rolls) those whose ends have different labels."""
    row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
    return _Intervals(case[row], roll[row, column], roll[row, column + 1])


def _ratio(
    cycle: MeshCycle,
    grids: Grids,
    case: Integers,
    roll: FloatArray,
    curves: tuple[_Curve, _Curve],
    thickness: float,
) -> tuple[FloatArray, Integers]:
    """Ratios and their status (cases,), from the `curves` of all pairs and of pair 0 alone at rolls
    (cases, rolls)."""
    mesh, cases = cycle.mesh, cycle.mesh.roll.size

    def touching(first: _Curve, alone: _Curve) -> Integers:
        # An edge that a tangency of another pair is ahead of, if only by rounding, does not touch.
        spare = mesh.lever * np.where(alone.edge & ~first.edge, -TOGETHER, TOGETHER)
        return np.asarray(alone.f - first.f <= thickness + spare).astype(int)

    def touches(cases: Integers, rolls: FloatArray) -> Integers:
        return touching(_first(cycle, cases, rolls), _alone(cycle, grids, cases, rolls))

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
