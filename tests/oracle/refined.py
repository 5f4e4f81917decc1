"""Positions of any method, corrected to the curve of the five equations. The size of the correction is the
error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from beveloid_geom import Design, Status
from beveloid_geom.arrays import Codes, FloatArray
from beveloid_geom.validation.five_equations import nearest_contact
from beveloid_geom.validation.five_equations_curve import Unknown, five_equations_of


@dataclass(frozen=True, eq=False)
class Refined:
    """Positions moved on to the curve of the five equations; arrays of the positions' shape.

    `l1, u1, l2, u2` (mm), `gear_roll, pinion_roll` (rad), `point` (mm) and `normal` (..., 3) in S_f as
    solved. `moved` (mm) and `turned` (rad): the largest change of a flank parameter and of a roll.
    `gap` (mm) and `normal_gap`: largest component of R1 - R2 and of n1 + n2 at the position as given,
    NaN only where it was. `status`: SOLVED, or NOT_CONVERGED with NaN in the rest where no contact is
    found from there."""

    l1: FloatArray
    u1: FloatArray
    l2: FloatArray
    u2: FloatArray
    gear_roll: FloatArray
    pinion_roll: FloatArray
    point: FloatArray
    normal: FloatArray
    moved: FloatArray
    turned: FloatArray
    gap: FloatArray
    normal_gap: FloatArray
    status: Codes


def refine(
    design: Design,
    flank: str,
    l1: ArrayLike,
    u1: ArrayLike,
    l2: ArrayLike,
    u2: ArrayLike,
    gear_roll: ArrayLike,
    pinion_roll: ArrayLike,
) -> Refined:
    """Return the contacts of a single design next to given positions (mm, rad; shapes broadcast), each in the
    plane through the position perpendicular to the curve of contacts.

    A position is therefore not moved along the path, and no quantity is fixed that might turn back along it.
    """
    given = np.stack(np.broadcast_arrays(l1, u1, l2, u2, gear_roll, pinion_roll), axis=-1).astype(float)
    system = five_equations_of(design, flank)
    start = given.reshape(-1, 6)
    found, gaps = np.full_like(start, np.nan), np.full((len(start), 2), np.nan)
    for k in np.flatnonzero(np.isfinite(start).all(axis=-1)):
        gaps[k] = system.misfit(start[k])
        with np.errstate(all="ignore"):
            nearest = nearest_contact(system, start[k] / system.scale)
        if nearest is not None:
            found[k] = nearest * system.scale
    shape, here, change = given.shape[:-1], system.at(found), np.abs(found - start)
    status = np.where(np.isnan(found[:, 0]), Status.NOT_CONVERGED, Status.SOLVED)
    return Refined(
        **{one.name.lower(): found[:, one].reshape(shape) for one in Unknown},
        point=here.point[0].reshape(*shape, 3),
        normal=here.normal[0].reshape(*shape, 3),
        moved=change[:, :4].max(axis=-1).reshape(shape),
        turned=change[:, 4:].max(axis=-1).reshape(shape),
        gap=gaps[:, 0].reshape(shape),
        normal_gap=gaps[:, 1].reshape(shape),
        status=status.astype(np.int8).reshape(shape),
    )
