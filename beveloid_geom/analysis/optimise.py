"""Parabola coefficients of a pair with the smallest shift of the path, or the smallest transmission error.

The objective is the shift of the path on the pinion flank under given assembly errors, or the transmission
error of all teeth under any of them. Constraints are a minimum contact ratio (Eq. 16), a path centred on the
face, bounds of the coefficients a1 (pinion) and a2 (gear), and optional limits on the shift and on the
transmission error of the path. Starting values are the local minima on two grids: an even grid between the
bounds, and a grid of sums and differences of the coefficients whose steps do not depend on the bounds.
SciPy's SLSQP continues from there. The given coefficients are a candidate, too, if they are within the
bounds.

If the sum of the coefficients is positive, the relative curvature of the flanks is negative and their
tangency is not the first contact. Such coefficients are excluded.

Edges. If the path of a tooth pair ends and no other pair is ahead, an edge touches. An aim may exclude
this in the mounting as designed and under each error in both directions. This is no bound on the sum of
the coefficients: on Table 1's right flanks with a1 = 0.001 1/mm, edges touch for sums close to 0, and
again for sums far below 0, where an error moves the largest transmission error towards one end of the
path. The leads at the ends of all these paths (`edge_contact`) are therefore constraints. The candidates
are then checked by the mesh cycles of all teeth, the best one first; the first one without edge contact
is the result. If edges touch for another reason than the end of a path, the optimum may be missed, or
nothing is found; then the message states the share of edge contact at the optimum without this
constraint.

Transmission error. Without edge contact, that of all teeth follows from the path
(`edge_contact.swing_of_all`). Its largest value over the mountings is minimised. Nearly unmodified flanks
have almost no transmission error but the largest shift, so this objective needs a limit on the shift. The
paper judges coefficients by eye (statement D1 in beveloid_geom/validation/README.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray
from ..design.arguments import require_design, require_two_numbers, require_unmodified
from ..design.model import Design
from ..operation.backlash_by_tangency import jammed, tangent_backlash
from ..pair.named_inputs import PRESETS, bound_faults
from ..support.argument import ArgumentError
from ..support.array_repr import short_repr
from ..support.frozen_arrays import cached
from .edge_contact import CycleExtremes, cycle_extremes
from .modification.objectives import (
    Aim as Aim,
    Objectives as Objectives,
    check_aim,
    objectives_of as objectives_of,
)

Vector: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]

COEFFICIENT_UNIT_PER_MM = 1e-3  # 1/mm, so that the coefficients are near 1 in the optimiser
EVEN_GRID_STEPS = 12
"""Number of even steps of the graded search grid, before its steps double; the even search grid between the
bounds has half as many."""
CONSTRAINT_TOLERANCE = 1e-6  # relative to the bound of the constraint


@dataclass(frozen=True, eq=False)
class Optimised:
    """Result of an optimisation.

    Attributes
    ----------
    design : Design
        The optimal design.
    optimum, given : Objectives
        Quantities of the path of the optimal and of the given design.
    optimum_operation, given_operation : CycleExtremes
        Mesh cycles in the mountings of the aim; NaN if the tip rounds of a tool overlap.
    at_limits : tuple of str
        Names of the variables whose value is one of their bounds.
    """

    design: Design
    optimum: Objectives
    given: Objectives
    optimum_operation: CycleExtremes
    given_operation: CycleExtremes
    at_limits: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Optimum(Optimised):
    """Optimal parabola coefficients, 1/mm, and the results of `Optimised`."""

    pinion_parabola: float
    gear_parabola: float

    __repr__ = short_repr


def optimise_parabola(design: Design, aim: Aim, flank: str = "right") -> Optimum:
    """Compute the parabola coefficients that minimise the shift or the transmission error under the
    constraints of an aim.

    Parameters
    ----------
    design : Design
        A single design; its coefficients are compared with the optimum. If they are within the bounds and
        meet the constraints, the optimum is not worse. The optimum has the same coefficient on right and left
        flanks of a member.
    aim : Aim
    flank : {'right', 'left'}

    Returns
    -------
    Optimum

    Raises
    ------
    ValueError
        For a batch; for an aim without errors, with bounds that do not increase, or with lower bounds whose
        sum is not negative; if no coefficients satisfy the constraints, or none of them can be assembled. If
        the aim excludes edge contact, also if edges touch with all coefficients or if the tip rounds of a
        tool overlap.

    References
    ----------
    Method: beveloid_geom/analysis/README.md, Optimum without edge contact.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> aim = bg.Aim(bg.Errors(offset=0.05))
    >>> optimum = bg.optimise_parabola(bg.builtin_design("ni-2017"), aim)
    >>> print(f"{optimum.pinion_parabola:.4f} 1/mm, {optimum.gear_parabola:.4f} 1/mm")
    -0.0020 1/mm, 0.0013 1/mm
    """
    require_design(design)
    require_unmodified(None, "optimisations of parabola coefficients", pinion=design.pinion, gear=design.gear)
    check_aim(design, aim, flank)
    _check_bounds(design, aim)
    if aim.edges:
        candidates, fault = _candidates(design, flank, aim)
        if fault:
            raise ValueError(fault)
        first, second = candidates[0]
    else:
        first, second = _without_edges(design, flank, aim)
    changed = design.with_parabola(float(first), float(second))
    given_coefficients = (np.asarray(member.tool.parabola_of(flank)) for member in design.members)
    return Optimum(
        pinion_parabola=float(first),
        gear_parabola=float(second),
        design=changed,
        optimum=objectives_of(design, flank, aim, first, second),
        given=objectives_of(design, flank, aim, *given_coefficients),
        optimum_operation=operation_of(changed, flank, aim),
        given_operation=operation_of(design, flank, aim),
        at_limits=at_limits(
            {
                "pinion_parabola": (float(first), aim.pinion_parabola),
                "gear_parabola": (float(second), aim.gear_parabola),
            }
        ),
    )


def at_limits(values: Mapping[str, tuple[float, tuple[float, float]]]) -> tuple[str, ...]:
    """Return the names of the values that are one of their bounds, given by name with the bounds."""
    return tuple(
        name
        for name, (value, (low, high)) in values.items()
        if min(value - low, high - value) <= CONSTRAINT_TOLERANCE * (high - low)
    )


def _candidates(design: Design, flank: str, aim: Aim) -> tuple[FloatArray, str]:
    """Return coefficients (n, 2), 1/mm, that satisfy an aim by its paths, the best first; or none and the
    reason."""
    bounds = np.array([aim.pinion_parabola, aim.gear_parabola])
    limits = bounds / COEFFICIENT_UNIT_PER_MM
    starts = _starts(design, flank, aim, limits)
    x = np.hstack((starts, *(_refined(design, flank, aim, limits, start) for start in starts.T)))
    given = np.array([[member.tool.parabola_of(flank)] for member in design.members])
    inside = ((given >= bounds[:, :1]) & (given <= bounds[:, 1:])).all(axis=0)
    # The given coefficients are the first candidate, so that they are the result unless others are better.
    coefficients = np.hstack((given[:, inside], COEFFICIENT_UNIT_PER_MM * x))
    paths = objectives_of(design, flank, aim, *coefficients).without_leads(int(inside.sum()))
    margins = _margins(paths, aim, coefficients / COEFFICIENT_UNIT_PER_MM)
    met = (margins >= -CONSTRAINT_TOLERANCE).all(axis=0) & np.isfinite(paths.shift)
    if not met.any():
        best = float(np.max(paths.contact_ratio, initial=0.0, where=~np.isnan(paths.contact_ratio)))
        swing = f" and {aim.peak_to_peak:.3g} rad of error" if np.isfinite(aim.peak_to_peak) else ""
        swing += f" and a shift of {aim.shift:g} mm" if np.isfinite(aim.shift) else ""
        return coefficients[:, :0].T, (
            f"no coefficients were found with a contact ratio of {aim.contact_ratio:g} within"
            f" {aim.off_centre:g} mm of mid-face{swing}; the largest ratio tried is {best:.3f}:"
            " relax the constraints, or widen the bounds"
        )
    backlash = tangent_backlash(design.with_parabola(*coefficients)).normal
    met &= ~jammed(backlash, float(design.pinion.tool.normal_module))
    if not met.any():
        return coefficients[:, :0].T, (
            "all coefficients that satisfy the constraints leave no backlash"
            f" ({np.nanmax(backlash):.4f} mm at most):"
            " reduce the profile shift, or increase the offset of crossed axes"
        )
    order = np.argsort(np.where(met, paths.goals.max(axis=0), np.inf), kind="stable")[: np.count_nonzero(met)]
    return coefficients[:, order].T, ""


def _without_edges(design: Design, flank: str, aim: Aim) -> FloatArray:
    """Return coefficients (2), 1/mm, that satisfy an aim and have no edge contact in its mountings.

    Raises ValueError if there are none: because of another constraint, an unknown mesh cycle, or edge
    contact."""
    for pair in _candidates(design, flank, aim)[0]:
        if operation_of(design.with_parabola(*pair.tolist()), flank, aim).edge_share == 0.0:
            return np.asarray(pair)
    others, fault = _candidates(design, flank, replace(aim, edges=True, least="shift"))
    if fault:
        raise ValueError(fault)
    best = others[0].tolist()
    share = cycle_extremes(aim.mounted(design.with_parabola(*best)), flank).edge_share
    carried = (
        "a mesh cycle could not be computed"
        if np.isnan(share)
        else f"edges touch during {100.0 * share:.3g} % of a cycle"
    )
    raise ValueError(
        "no coefficients were found without edge contact, as designed and under the errors: with pinion"
        f" {best[0]:.6g}, gear {best[1]:.6g} 1/mm, the optimum without this constraint, {carried}:"
        " reduce the errors, relax the constraints, or widen the bounds"
    )


def operation_of(design: Design, flank: str, aim: Aim) -> CycleExtremes:
    """Return the mesh cycles in the mountings of an aim; NaN if the tip rounds of a tool overlap."""
    try:
        return cycle_extremes(aim.mounted(design), flank)
    except ValueError:  # the fillets of such a tool are not defined
        return CycleExtremes()


def _margins(paths: Objectives, aim: Aim, x: FloatArray) -> FloatArray:
    """Return the margins of all constraints (constraints, ...) at coefficients x (2, ...), in
    COEFFICIENT_UNIT_PER_MM."""
    return np.concatenate((paths.margins(aim), -x.sum(axis=0)[None]))


def _refined(design: Design, flank: str, aim: Aim, limits: FloatArray, start: Vector) -> FloatArray:
    """Return the results (2, 2) of two SLSQP runs, in units of COEFFICIENT_UNIT_PER_MM: one in a box around
    the start, then one within all bounds. In a single run, the first step might leave the valley of the
    start."""
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    @cached(8)  # SLSQP evaluates the constraints several times at the same coefficients
    def paths(first: float, second: float) -> Objectives:
        """Return the results at two coefficients, in units of COEFFICIENT_UNIT_PER_MM."""
        return objectives_of(
            design,
            flank,
            aim,
            np.asarray(COEFFICIENT_UNIT_PER_MM * first),
            np.asarray(COEFFICIENT_UNIT_PER_MM * second),
        )

    def greatest(x: Vector) -> float:
        """Return the largest objective relative to that of the start."""
        return float(x[2])

    def conditions(x: Vector) -> FloatArray:
        objectives = paths(*x[:2].tolist())
        margins = np.append(_margins(objectives, aim, x[:2]), x[2] - objectives.goals / scale)
        return np.asarray(np.nan_to_num(margins, nan=-1.0))

    scale = float(np.nan_to_num(paths(*start.tolist()).goals.max(), nan=1.0)) or 1.0
    reach, ends = 3.0 * _step(design), []
    for box in (np.clip(start[:, None] + (-reach, reach), *limits.T[:, :, None]), limits):
        goal = float(np.nan_to_num(paths(*start.tolist()).goals.max(), nan=scale)) / scale
        result = minimize(
            greatest,
            np.append(start, goal),
            method="SLSQP",
            bounds=Bounds(np.append(box[:, 0], 0.0), np.append(box[:, 1], np.inf)),
            constraints=NonlinearConstraint(conditions, 0.0, np.inf),
            options={"maxiter": 60, "ftol": 1e-8},
        )
        start = np.clip(result.x[:2], box[:, 0], box[:, 1])
        ends.append(start)
    return np.stack(ends, axis=1)


def _step(design: Design) -> float:
    """Return the grid step, 0.001 over the module, in COEFFICIENT_UNIT_PER_MM."""
    return 0.001 / (COEFFICIENT_UNIT_PER_MM * float(design.pinion.tool.normal_module))


def _check_bounds(design: Design, aim: Aim) -> None:
    for name in ("pinion_parabola", "gear_parabola"):
        require_two_numbers(**{f"{name} of the aim": getattr(aim, name)})
        low, high = getattr(aim, name)
        if not -np.inf < low < high < np.inf:
            text = f"must be two finite bounds, the first below the second, got {low}, {high}"
            raise ArgumentError(f"{name} of the aim", text)
    for fault in bound_faults(design, PRESETS["parabola"], (aim.pinion_parabola, aim.gear_parabola)):
        raise fault
    if (total := aim.pinion_parabola[0] + aim.gear_parabola[0]) >= 0.0:
        limit = "the lower bounds of both coefficients must have a negative sum"
        raise ValueError(f"{limit}, got {total:g} 1/mm: reduce one of them")


def _starts(design: Design, flank: str, aim: Aim, limits: FloatArray) -> FloatArray:
    """Return starting coefficients (2, n), in COEFFICIENT_UNIT_PER_MM, the best first.

    They are the local minima of the constraint violation, then of the objective, on two grids: an even one
    between the bounds, and one of sums and differences of the coefficients that is the same for all bounds
    and finer in the sums."""
    first, second = (np.linspace(low, high, EVEN_GRID_STEPS // 2 + 1) for low, high in limits.tolist())
    even = np.meshgrid(first, second, indexing="ij")
    step, most = _step(design), float(np.abs(limits).sum())
    sums, apart = -_graded(0.25 * step, most), 2.0 * _graded(step, 0.5 * most)
    total, apart = np.meshgrid(sums, np.append(-apart[:0:-1], apart), indexing="ij")
    minima = [
        _least_of(design, flank, aim, limits, np.array(x))
        for x in (even, (0.5 * (total + apart), 0.5 * (total - apart)))
    ]
    x, missed, goal = (np.concatenate(rows, axis=-1) for rows in zip(*minima, strict=True))
    near = np.flatnonzero(missed <= max(1.0, float(missed.min(initial=np.inf))))
    return x[:, near[np.lexsort((goal[near], missed[near]))][:4]]


def _least_of(
    design: Design, flank: str, aim: Aim, limits: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the local minima (2, n) of a grid x (2, rows, columns), their constraint violations (n,) and
    largest objectives (n,)."""
    inside = ((x >= limits[:, :1, None]) & (x <= limits[:, 1:, None])).all(axis=0) & (
        x.sum(axis=0) <= CONSTRAINT_TOLERANCE
    )
    missed, goal = np.full((2, *inside.shape), np.inf)
    if not inside.any():
        return x[:, :0, 0], missed[:0, 0], goal[:0, 0]
    shown = objectives_of(design, flank, aim, *(COEFFICIENT_UNIT_PER_MM * x[:, inside]))
    missed[inside] = np.maximum(np.nan_to_num(-shown.margins(aim), nan=np.inf).max(axis=0), 0.0)
    goal[inside] = shown.goals.max(axis=0)
    met = inside & (missed == missed.min())
    backlash = tangent_backlash(design.with_parabola(*(COEFFICIENT_UNIT_PER_MM * x[:, met]))).normal
    missed[met] += jammed(backlash, float(design.pinion.tool.normal_module))
    rank = np.empty(missed.shape)
    rank.flat[np.lexsort((goal.ravel(), missed.ravel()))] = np.arange(rank.size)
    wide, (rows, columns) = np.pad(rank, 1, constant_values=np.inf), rank.shape
    neighbours = [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    least = inside & (rank <= np.min(neighbours, axis=0))
    return x[:, least], missed[least], goal[least]


def _graded(step: float, most: float) -> FloatArray:
    """Return values from 0 to `most`: EVEN_GRID_STEPS even steps, then steps that double with the value."""
    doublings = int(np.log2(max(1.0, most / (EVEN_GRID_STEPS * step)))) + 1
    beyond = [
        2.0**k * n for k in range(doublings) for n in range(EVEN_GRID_STEPS + 2, 2 * EVEN_GRID_STEPS + 1, 2)
    ]
    values = step * np.append(np.arange(EVEN_GRID_STEPS + 1), beyond)
    return values[values <= most]
