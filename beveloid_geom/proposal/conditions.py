"""The conditions that a pair must meet to close as required, and their roots from many starts at once.

A pair of given teeth and tools is seven numbers: cone angle, helix angle and profile shift of both members,
and the working normal pressure angle a_w. `pair.closing.closed_layout` gives the layout in which it closes,
offset, shaft angle and backlash, in closed form; `pair.crossing` the angle at which generators cross. What is
required of these are equations for as many of the seven, or more; Newton's method finds them from all starts
in step, where more are free by the steps of least length.

Parallel axes close in another way: cones and helix angles of both members cancel, and what is left of the
layout is the offset, the sum of the working radii.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Mask, Quantity
from ..design.model import Design, Member, Pair, unchecked
from ..pair.closing import ClosedLayout, closed_layout
from ..pair.crossing import closed_normal

VARIABLES = (
    *("pinion_cone", "gear_cone", "pinion_helix", "gear_helix", "pinion_shift", "gear_shift"),
    "pressure_angle",
)
"""The seven numbers of a pair, rad and modules."""
PINION_CONE, GEAR_CONE, PINION_HELIX, GEAR_HELIX, PINION_SHIFT, GEAR_SHIFT, PRESSURE = range(7)
STEP = 1e-7
"""Of differences for the derivatives: Newton's steps then gain six digits each, near a root."""
LONGEST = np.array([0.12, 0.12, 0.2, 0.2, 0.6, 0.6, 0.06])
"""Longest step of each of VARIABLES in one go."""
UNITS = np.array([0.05, 0.05, 0.2, 0.2, 0.4, 0.4, 0.05])
"""In which the length of a step is measured, where more is free than is required."""
FARTHEST = np.radians([70.0, 70.0, 80.0, 80.0, 600.0, 600.0, 60.0])
"""Magnitudes beyond which a search has run off."""
MET = 1e-12
"""Misses (modules and rad) below which conditions are met."""
MOST_STEPS = 16


@dataclass(frozen=True, eq=False)
class Wanted:
    """What is required of pairs, of all of them or of each (n,): shaft angle (magnitude, rad), normal
    backlash in modules of the pinion, and, None where they are free, offset in modules and crossing angle on
    the drive `flank`; `along`: whether pinion and gear cone have a given ratio."""

    shaft_angle: Quantity
    backlash: Quantity
    offset: Quantity | None
    crossing: Quantity | None
    flank: str
    along: bool = False

    @property
    def parallel(self) -> bool:
        """Whether the axes are parallel."""
        return not np.any(self.shaft_angle)

    @property
    def count(self) -> int:
        """Number of conditions; of parallel axes without those that cones and helix angles cancel."""
        some = self.offset is not None, self.crossing is not None and not self.parallel, self.along
        return 2 - self.parallel + sum(some)

    def take(self, rows: NDArray[np.intp]) -> Wanted:
        """Give what is required of some of the pairs."""
        changed: dict[str, Any] = {k: v[rows] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        return replace(self, **changed)


@dataclass(frozen=True, eq=False)
class Starts:
    """Starts (7, n) of a search, and what is the same all along it, (n,): the sense in which the axes lean,
    `sense`, that of the crossing, `side`, the direction of the cone angles, `turn` (rad), and the number of
    the request that it is for, `owner`."""

    values: FloatArray
    sense: FloatArray
    side: FloatArray
    turn: FloatArray
    owner: NDArray[np.intp]

    def take(self, rows: Mask | NDArray[np.intp] | list[int]) -> Starts:
        """Give some of them."""
        kept = np.asarray(rows) if len(rows) else np.empty(0, int)
        return Starts(*(value[..., kept] for value in vars(self).values()))


def pair_at(members: tuple[Member, Member], values: FloatArray) -> tuple[Design, ClosedLayout]:
    """Give the pairs of the numbers (7, ...) on the tools, teeth and faces of `members`, and the layouts in
    which they close; NaN where there is none. The design's own layout is of no meaning."""
    made = [
        unchecked(member, cone_angle=values[j], helix_angle=values[2 + j], profile_shift=values[4 + j])
        for j, member in enumerate(members)
    ]
    design = Design(made[0], made[1], Pair(0.0, 0.1))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return design, closed_layout(design, values[PRESSURE])


def misses(members: tuple[Member, Member], wanted: Wanted, starts: Starts, values: FloatArray) -> FloatArray:
    """Find by how much (conditions, ..., n) pairs (7, ..., n) miss what is wanted, in modules and rad."""
    design, layout = pair_at(members, values)
    module = float(members[0].tool.normal_module)
    # In the sense of the search: the design's own jumps where axes intersect.
    sense = 1.0 if wanted.parallel else starts.sense * design.sense
    found = [layout.normal_backlash / module - wanted.backlash]
    if not wanted.parallel:
        found.append(layout.shaft_angle - wanted.shaft_angle)
    if wanted.offset is not None:
        found.append(sense * layout.offset / module - wanted.offset)
    if wanted.crossing is not None and not wanted.parallel:
        with np.errstate(invalid="ignore"):
            angle = closed_normal(layout, wanted.flank, starts.sense)[1]
        found.append(angle - starts.side * wanted.crossing)
    if wanted.along:
        cones = np.sin(starts.turn) * values[PINION_CONE] - np.cos(starts.turn) * values[GEAR_CONE]
        found.append(cones)
    return np.stack(found)


def roots(members: tuple[Member, Member], wanted: Wanted, starts: Starts, unknown: tuple[int, ...]) -> Starts:
    """Find the pairs that meet all that is `wanted`, by changing the `unknown` of VARIABLES, at least as many
    as there are conditions, from all starts; those that are found, in the order of their starts."""
    columns = list(unknown)

    def function(values: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        return misses(members, wanted.take(rows), starts.take(rows), values)

    values, found = _newton(function, starts.values.copy(), columns)
    return replace(starts, values=values).take(found)


def _newton(
    function: Callable[[FloatArray, NDArray[np.intp]], FloatArray], values: FloatArray, columns: list[int]
) -> tuple[FloatArray, Mask]:
    """Change the `columns` of values (7, n) to zeros of a function of all of them, (at most len(columns), n);
    tell where one was found. A step out of where the function is known is halved."""
    count = len(columns)
    good, met = values.copy(), np.zeros(values.shape[1], bool)
    active = np.arange(values.shape[1])
    for _ in range(MOST_STEPS):
        if not active.size:
            break
        moved = np.repeat(values[:, None, active], 1 + count, axis=1)
        moved[columns, np.arange(1, 1 + count)] += STEP
        found = function(moved, active)
        known = np.isfinite(found).all(axis=(0, 1))
        values[:, active[~known]] = 0.5 * (values[:, active[~known]] + good[:, active[~known]])
        rows, residual = active[known], found[:, 0, known]
        good[:, rows] = values[:, rows]
        slopes = np.moveaxis((found[:, 1:, known] - residual[:, None]) / STEP, -1, 0)
        steps = _steps(slopes, residual, columns)
        values[np.array(columns)[:, None], rows] += steps
        done = np.abs(residual).max(axis=0) < MET  # the step just made was the last
        met[rows[done]] = True
        lost = (np.abs(values[:, rows]) > FARTHEST[:, None]).any(axis=0) | np.isnan(steps).any(axis=0)
        active = np.setdiff1d(active, rows[done | lost])
    return values, met & np.isfinite(values).all(axis=0)


def _steps(slopes: FloatArray, residual: FloatArray, columns: list[int]) -> FloatArray:
    """Find Newton's steps (columns, n), the least ones in UNITS where there are several, shortened as a whole
    to the LONGEST of each; NaN where there are none."""
    scaled, steps = slopes * UNITS[columns], np.full((len(columns), residual.shape[1]), np.nan)
    square = scaled if len(residual) == len(columns) else scaled @ scaled.swapaxes(-1, -2)
    regular = np.abs(np.linalg.det(square)) > 0.0
    if regular.any():
        solved = np.linalg.solve(square[regular], -residual.T[regular][..., None])
        if square is not scaled:
            solved = scaled[regular].swapaxes(-1, -2) @ solved
        solved = solved[..., 0].T * UNITS[columns][:, None]
        steps[:, regular] = solved / np.maximum(
            1.0, np.max(np.abs(solved) / LONGEST[columns][:, None], axis=0)
        )
    return steps
