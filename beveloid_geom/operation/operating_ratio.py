"""The operating contact ratio: how many tooth pairs are in contact, edges and fillets included.

A tooth pair is in contact where it is the first of all to touch, or within a given thickness of it,
as of a lubricant film or marking compound. The roll over which one pair is, over the pitch, is
the operating contact ratio. Unmodified pairs have the contact ratio of Eq. 16; modified flanks of
rigid teeth touch in one point at a time and have 1, unless given a thickness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..design.model import Design
from ..status import RatioStatus
from ..support.few_lines import few_lines
from .first_contact import TOGETHER, Mesh, mesh_of, middle_roll
from .least_clearance import OVERLAP
from .mesh_cycle import CHANGE_WIDTH, SAMPLES, Curve, Numbers, curve_at, divided, with_change

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


def operating_ratio(design: Design, flank: str, thickness: float = 0.0) -> FloatArray:
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
    shape, pitch = design.batch_shape, 2.0 * np.pi / int(design.pinion.teeth)
    start = np.broadcast_to(middle_roll(design, flank), shape)
    case = np.arange(start.size)
    mesh, _ = mesh_of(design, flank, np.broadcast_to(start[..., None], (*shape, 1)))
    cycle = curve_at(design, flank, case, start.reshape(-1, 1) + pitch * np.arange(SAMPLES) / SAMPLES)
    lost = np.isnan(cycle.error).any(axis=1)
    ratio = np.full((len(thicknesses), start.size), np.nan)
    status = np.full(ratio.shape, RatioStatus.NO_FIRST_CONTACT, dtype=np.int8)
    if not lost.all():
        share = np.arange(-mesh.reach * SAMPLES, mesh.reach * SAMPLES + 1) / SAMPLES
        again = np.arange(share.size) % SAMPLES  # the curve of all pairs repeats itself
        first = Curve(*(value[:, again] for value in vars(cycle).values()))
        roll = start.reshape(-1, 1) + pitch * share
        useful = [size for size in thicknesses if size < mesh.period * mesh.lever]
        curves = first, _alone(design, flank, mesh, roll, first, max(useful, default=0.0))
        for k, thickness in enumerate(thicknesses):
            ratio[k], status[k] = _ratio(design, flank, mesh, roll, curves, thickness)
        status[:, lost] = RatioStatus.NO_FIRST_CONTACT
    ratio[status != RatioStatus.KNOWN] = np.nan
    shape = (len(thicknesses), *shape)
    return OperatingRatios(ratio.reshape(shape), status.reshape(shape))


def _alone(design: Design, flank: str, mesh: Mesh, roll: FloatArray, first: Curve, thickness: float) -> Curve:
    """Pair 0 alone at rolls (cases, rolls); NaN, as without contact, where it is too far off to matter."""
    case, n = np.arange(len(roll)), roll.shape[1]
    rough = curve_at(design, flank, case, roll[:, ::STRIDE], (0,))
    off = mesh.own.sigma * mesh.lever * (rough.error - first.error[:, ::STRIDE])
    advance = mesh.lever * mesh.pitch[1] * 0.5 * STRIDE / SAMPLES  # to the nearer of two looked at
    near = ((off <= thickness + advance) | rough.doubt).any(axis=0).repeat(STRIDE)
    # The stride before and the one after each of these.
    shifted = np.append(near[STRIDE:], np.zeros(STRIDE, dtype=bool))
    chosen = (near | shifted)[:n]
    chosen[::STRIDE] = True
    found = curve_at(design, flank, case, roll[:, chosen], (0,))
    filled = {}
    for name, value in vars(found).items():
        filled[name] = np.full(roll.shape, np.nan if name == "error" else 0, dtype=value.dtype)
        filled[name][:, chosen] = value
    return Curve(**filled)


def _ratio(
    design: Design, flank: str, mesh: Mesh, roll: FloatArray, curves: tuple[Curve, Curve], thickness: float
) -> tuple[FloatArray, Numbers]:
    """Ratios and their status (cases,), from the `curves` of all pairs and of pair 0 alone at rolls
    (cases, rolls)."""
    pitch, lever = mesh.pitch[0], mesh.own.sigma * mesh.lever

    def touching(first: Curve, alone: Curve) -> Numbers:
        # An edge that a tangency of another pair is ahead of, if only by rounding, does not touch.
        spare = mesh.lever * np.where(alone.edge & ~first.edge, -TOGETHER, TOGETHER)
        return np.asarray(lever * (alone.error - first.error) <= thickness + spare).astype(int)

    def touches(cases: Numbers, rolls: FloatArray) -> Numbers:
        alone = curve_at(design, flank, cases, rolls, (0,))
        return touching(curve_at(design, flank, cases, rolls), alone)

    # Further off than this the same teeth are those of another turn.
    latest = np.nan_to_num(lever * curves[0].error).max(axis=1)
    most = (1.0 - OVERLAP) * mesh.period * mesh.lever - latest
    if (thickness >= most).all():
        return np.full(len(roll), np.nan), np.full(len(roll), RatioStatus.TOO_THICK)
    inside = touching(*curves)
    ends = divided(with_change(np.arange(len(roll)), roll, inside), touches, CHANGE_WIDTH * pitch)
    ratio, balance, wide = np.zeros(len(roll)), np.zeros(len(roll)), np.zeros(len(roll), dtype=bool)
    leaves = touches(ends.case, ends.low[:, None])[:, 0] if ends.case.size else np.zeros(0)
    sign = np.where(leaves, 1.0, -1.0)
    np.add.at(ratio, ends.case, sign * 0.5 * (ends.low + ends.high) / pitch)
    np.add.at(balance, ends.case, sign)
    wide[ends.case[ends.high - ends.low > CHANGE_WIDTH * pitch]] = True
    beyond = (inside[:, [0, -1]] != 0).any(axis=1) | (thickness >= most)
    cases = (
        (curves[1].doubt.any(axis=1), RatioStatus.NOT_CONVERGED),
        (beyond, RatioStatus.TOO_THICK),
        (wide | (balance != 0.0) | ~(ratio >= AT_LEAST), RatioStatus.UNSTEADY),
    )
    found = np.select([where for where, _ in cases], [code for _, code in cases], RatioStatus.KNOWN)
    return ratio, found
