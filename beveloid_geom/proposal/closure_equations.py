"""Equations of pairs that meet the requirements of a request, and their solution from many starts at once.

A pair with given teeth and tools has seven free quantities: cone angle, helix angle and profile shift of both
members, and the working normal pressure angle a_w. `pair.zero_backlash.closed_layout` gives the layout in
which the lines of action of both flanks meet (offset, shaft angle, backlash) in closed form, and
`pair.generator_angle` the angle between the generators of the flanks. Every requirement is one equation.
Newton's method solves them for all starts at the same time. If more quantities are free than there are
equations, the shortest steps are used.

On parallel axes, cone angles and helix angles of both members cancel. The remaining equations are the
backlash and, if it is given, the offset, which is the sum of the working radii.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Mask, Quantity
from ..design.member import Member, unchecked
from ..design.model import Design, Pair
from ..pair.generator_angle import closed_normal
from ..pair.zero_backlash import ZeroBacklashLayout, closed_layout

MAX_STEP = np.array([0.12, 0.12, 0.2, 0.2, 0.6, 0.6, 0.06])
"""Largest Newton step of each `Variable`, rad and modules."""
STEP_SCALE = np.array([0.05, 0.05, 0.2, 0.2, 0.4, 0.4, 0.05])
"""Scales of each `Variable` in the length of a step, if more quantities are free than there are equations."""
MAX_MAGNITUDE = np.radians([70.0, 70.0, 80.0, 80.0, 600.0, 600.0, 60.0])
"""Magnitudes of each `Variable` at which a search is stopped, rad and modules (10.47 for the shifts)."""


class Variable(IntEnum):
    """The seven free quantities of a pair, rad and modules; the last is the working pressure angle."""

    PINION_CONE = 0
    GEAR_CONE = 1
    PINION_HELIX = 2
    GEAR_HELIX = 3
    PINION_SHIFT = 4
    GEAR_SHIFT = 5
    PRESSURE = 6


@dataclass(frozen=True, eq=False)
class Wanted:
    """Requirements on pairs, the same for all or one for each pair (n,).

    Attributes
    ----------
    shaft_angle : float or ndarray
        Magnitude of the shaft angle, rad.
    backlash : float or ndarray
        Normal backlash, modules of the pinion.
    offset : float, ndarray or None
        Offset, modules of the pinion; None if it is free.
    crossing : float, ndarray or None
        Angle between the generators of the drive flanks, rad; None if it is free.
    flank : str
        Drive flanks.
    cone_ratio_given : bool
        Whether the ratio of the cone angles is given (by `ClosureStarts.turn`).
    """

    shaft_angle: Quantity
    backlash: Quantity
    offset: Quantity | None
    crossing: Quantity | None
    flank: str
    cone_ratio_given: bool = False

    @property
    def parallel(self) -> bool:
        """Whether the axes are parallel."""
        return not np.any(self.shaft_angle)

    @property
    def count(self) -> int:
        """Number of equations. On parallel axes, the equations of cone and helix angles are not counted."""
        given = (
            self.offset is not None,
            self.crossing is not None and not self.parallel,
            self.cone_ratio_given,
        )
        return 2 - self.parallel + sum(given)

    def take(self, rows: NDArray[np.intp]) -> Wanted:
        """Return the requirements on some of the pairs."""
        changed: dict[str, Any] = {k: v[rows] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        return replace(self, **changed)


@dataclass(frozen=True, eq=False)
class ClosureStarts:
    """Starts of a search.

    Attributes
    ----------
    values : ndarray
        Each `Variable` (7, n).
    sense : ndarray
        Sense of the shaft angle (n,), 1 or -1.
    side : ndarray
        Sign of the angle between the generators (n,), 1 or -1.
    turn : ndarray
        Direction in the plane of the two cone angles (n,), rad.
    owner : ndarray
        Number of the request (n,).
    """

    values: FloatArray
    sense: FloatArray
    side: FloatArray
    turn: FloatArray
    owner: NDArray[np.intp]

    def take(self, rows: Mask | NDArray[np.intp]) -> ClosureStarts:
        """Return some of the starts."""
        return ClosureStarts(*(value[..., rows] for value in vars(self).values()))


def pair_at(members: tuple[Member, Member], values: FloatArray) -> tuple[Design, ZeroBacklashLayout]:
    """Return pairs and the layouts in which their lines of action meet.

    Parameters
    ----------
    members : tuple of Member
        Tools, teeth and face widths.
    values : ndarray
        Each `Variable` (7, ...).

    Returns
    -------
    Design, ZeroBacklashLayout
        NaN if there is no layout. The layout in the design itself has no meaning.
    """
    made = [
        unchecked(member, cone_angle=values[j], helix_angle=values[2 + j], profile_shift=values[4 + j])
        for j, member in enumerate(members)
    ]
    design = Design(made[0], made[1], Pair(0.0, 0.1))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return design, closed_layout(design, values[Variable.PRESSURE])


def misses(
    members: tuple[Member, Member], wanted: Wanted, starts: ClosureStarts, values: FloatArray
) -> FloatArray:
    """Return the residuals (equations, ..., n) of pairs (7, ..., n), modules and rad."""
    design, layout = pair_at(members, values)
    module = float(members[0].tool.normal_module)
    # The sense of the search is used, because the sense of the design jumps on intersecting axes.
    sense = 1.0 if wanted.parallel else starts.sense * design.sense
    residuals = [layout.normal_backlash / module - wanted.backlash]
    if not wanted.parallel:
        residuals.append(layout.shaft_angle - wanted.shaft_angle)
    if wanted.offset is not None:
        residuals.append(sense * layout.offset / module - wanted.offset)
    if wanted.crossing is not None and not wanted.parallel:
        with np.errstate(invalid="ignore"):
            angle = closed_normal(layout, wanted.flank, starts.sense)[1]
        residuals.append(angle - starts.side * wanted.crossing)
    if wanted.cone_ratio_given:
        cones = (
            np.sin(starts.turn) * values[Variable.PINION_CONE]
            - np.cos(starts.turn) * values[Variable.GEAR_CONE]
        )
        residuals.append(cones)
    return np.stack(residuals)


def roots(
    members: tuple[Member, Member], wanted: Wanted, starts: ClosureStarts, unknown: tuple[int, ...]
) -> ClosureStarts:
    """Return the solutions for all requirements, in the order of their starts.

    Parameters
    ----------
    members : tuple of Member
    wanted : Wanted
    starts : ClosureStarts
    unknown : tuple of int
        Each `Variable` that is changed, at least as many as there are equations.

    Returns
    -------
    ClosureStarts
        Only the starts from which a solution was found, with the values of the solution.
    """
    columns = list(unknown)

    def function(values: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        return misses(members, wanted.take(rows), starts.take(rows), values)

    values, solved = _newton(function, starts.values.copy(), columns)
    return replace(starts, values=values).take(solved)


def _newton(
    function: Callable[[FloatArray, NDArray[np.intp]], FloatArray], values: FloatArray, columns: list[int]
) -> tuple[FloatArray, Mask]:
    """Return the zeros of a function of all values (7, n) after changing `columns`, and the mask (n,) of
    solutions.

    The function has at most len(columns) components. A step to a point at which the function is NaN is
    halved."""
    # Largest residual of a solution, modules and rad.
    residual_tolerance = 1e-12
    count = len(columns)
    good, solved = values.copy(), np.zeros(values.shape[1], bool)
    active = np.arange(values.shape[1])
    # Step of the difference quotients, rad and modules. Near a root, each Newton step then gains six digits.
    difference_step = 1e-7
    max_iterations = 16
    for _ in range(max_iterations):
        if not active.size:
            break
        moved = np.repeat(values[:, None, active], 1 + count, axis=1)
        moved[columns, np.arange(1, 1 + count)] += difference_step
        results = function(moved, active)
        known = np.isfinite(results).all(axis=(0, 1))
        values[:, active[~known]] = 0.5 * (values[:, active[~known]] + good[:, active[~known]])
        rows, residual = active[known], results[:, 0, known]
        good[:, rows] = values[:, rows]
        slopes = np.moveaxis((results[:, 1:, known] - residual[:, None]) / difference_step, -1, 0)
        steps = _steps(slopes, residual, columns)
        values[np.array(columns)[:, None], rows] += steps
        done = np.abs(residual).max(axis=0) < residual_tolerance  # the last step is already added
        solved[rows[done]] = True
        lost = (np.abs(values[:, rows]) > MAX_MAGNITUDE[:, None]).any(axis=0) | np.isnan(steps).any(axis=0)
        active = np.setdiff1d(active, rows[done | lost])
    return values, solved & np.isfinite(values).all(axis=0)


def _steps(slopes: FloatArray, residual: FloatArray, columns: list[int]) -> FloatArray:
    """Return Newton steps (columns, n), limited to MAX_STEP without a change of direction; NaN for singular
    slopes.

    If there are more columns than equations, the shortest step relative to STEP_SCALE is returned."""
    scaled, steps = slopes * STEP_SCALE[columns], np.full((len(columns), residual.shape[1]), np.nan)
    square = scaled if len(residual) == len(columns) else scaled @ scaled.swapaxes(-1, -2)
    regular = np.abs(np.linalg.det(square)) > 0.0
    if regular.any():
        solved = np.linalg.solve(square[regular], -residual.T[regular][..., None])
        if square is not scaled:
            solved = scaled[regular].swapaxes(-1, -2) @ solved
        solved = solved[..., 0].T * STEP_SCALE[columns][:, None]
        steps[:, regular] = solved / np.maximum(
            1.0, np.max(np.abs(solved) / MAX_STEP[columns][:, None], axis=0)
        )
    return steps
