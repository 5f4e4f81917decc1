"""Amounts of modification with the smallest shift of the path, or the smallest transmission error.

Objectives and constraints are those of an `Aim` (`analysis.optimise`), without its bounds of parabola
coefficients. The variables are amounts of modification (slopes, crownings, twists, and reliefs whose length
is given) of both members on the driving flanks. Each is scaled by its bounds to x from 0 to 1. Starting
values are the best points of a Halton sequence within the bounds. SciPy's SLSQP continues from there, with
derivatives by differences of 0.001, because paths of modified flanks have more rounding than those of
generated flanks. All designs of a sequence or a difference are one batch.

The candidates include the given amounts if they are within the bounds. They are then checked by the mesh
cycles of all teeth in all mountings, the best one first.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import MEMBERS, FloatArray
from ...design.arguments import require_two_numbers
from ...design.member import MODIFICATIONS
from ...design.model import Design
from ...design.modification import AMOUNT, Modification, kinds_of, length_of
from ...design.written_numbers import shown_value
from ...operation.backlash_by_tangency import jammed, tangent_backlash
from ...pair.named_inputs import Bounds
from ...support.argument import ArgumentError
from ...support.array_repr import short_repr
from ..optimise import CONSTRAINT_TOLERANCE, Optimised, Vector, at_limits, operation_of
from .objectives import Aim, Objectives, check_aim, objectives_of_designs


@dataclass(frozen=True, eq=False)
class AmountsOptimum(Optimised):
    """Optimal amounts of modification, um by names such as `pinion.helix_crowning_um`, and the results of
    `Optimised`."""

    amounts: dict[str, float]

    __repr__ = short_repr


def optimise_amounts(
    design: Design, aim: Aim, bounds: Mapping[str, Bounds], flank: str = "right"
) -> AmountsOptimum:
    """Compute the amounts of modification that minimise the shift or the transmission error of an aim.

    Parameters
    ----------
    design : Design
        A single design. The result also contains the values for the design as given. If its amounts are
        within the bounds and meet the constraints, the optimum is not worse. Its parabolas and all other
        amounts are not changed.
    aim : Aim
        The bounds of the parabola coefficients are not used.
    bounds : mapping
        Lower and upper bound, um, of each amount to optimise, by names such as `pinion.helix_crowning_um`:
        slopes, crownings, twist, and reliefs whose length is given in the design.
    flank : {'right', 'left'}
        Driving flank. The modification of the other flank is kept.

    Returns
    -------
    AmountsOptimum

    Raises
    ------
    ValueError
        For a batch; for an aim without errors; for unknown names, reliefs without a length, bounds that do
        not increase or exceed the limits of amounts, and more than 6 amounts; if no amounts satisfy the
        constraints, or none of them can be assembled. If the aim excludes edge contact, also if edges touch
        with all amounts found.

    References
    ----------
    Modifications: ISO 21771; method: beveloid_geom/analysis/README.md, Amounts of modification.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> aim = bg.Aim(bg.Errors(shaft_angle=1e-4), contact_ratio=1.5)
    >>> bounds = {"pinion.helix_crowning_um": (0.0, 20.0)}
    >>> optimum = bg.optimise_amounts(bg.builtin_design("ni-2017"), aim, bounds)
    >>> optimum.at_limits
    ('pinion.helix_crowning_um',)
    """
    check_aim(design, aim, flank)
    _check_amounts(design, flank, bounds)
    search = _AmountSearch(design, aim, flank, tuple(bounds), np.array([*bounds.values()], dtype=float).T)
    amounts = search.result()
    changed = with_amounts(design, flank, amounts)
    return AmountsOptimum(
        design=changed,
        optimum=objectives_of_designs(changed, flank, aim),
        given=objectives_of_designs(design, flank, aim),
        optimum_operation=operation_of(changed, flank, aim),
        given_operation=operation_of(design, flank, aim),
        at_limits=at_limits({name: (amounts[name], bounds[name]) for name in bounds}),
        amounts=amounts,
    )


def with_amounts(design: Design, flank: str, amounts: Mapping[str, float | FloatArray]) -> Design:
    """Return the design with other amounts, um or arrays of um by name, on one flank."""
    field = MODIFICATIONS[flank]
    for member in MEMBERS:
        member_amounts = {
            name.partition(".")[2]: value for name, value in amounts.items() if name.startswith(member)
        }
        if member_amounts:
            given = getattr(design, member)
            changed = replace(getattr(given, field) or Modification(), **member_amounts)
            design = replace(design, **{member: replace(given, **{field: changed})})
    return design


def amount_of(design: Design, flank: str, name: str) -> float:
    """Return an amount of a design, um, by a name such as `pinion.helix_crowning_um`."""
    member, _, key = name.partition(".")
    given = getattr(design, member).modification(flank)
    return 0.0 if given is None else float(getattr(given, key))


@dataclass(frozen=True, eq=False)
class _AmountSearch:
    """Search for the amounts `names` between the rows of `limits` (2, n), um."""

    design: Design
    aim: Aim
    flank: str
    names: tuple[str, ...]
    limits: FloatArray

    def amounts(self, x: FloatArray) -> dict[str, FloatArray]:
        """Return the amounts (...), um, at x (n, ...)."""
        low, high = self.limits.reshape(2, -1, *[1] * (x.ndim - 1))
        return dict(zip(self.names, low + (high - low) * x, strict=True))

    def at(self, x: FloatArray) -> Objectives:
        """Return the objectives (...) at x (n, ...)."""
        return self._objectives(self.amounts(x))

    def _objectives(self, amounts: Mapping[str, FloatArray]) -> Objectives:
        """Return the objectives (...) for amounts (...), um by name."""
        return objectives_of_designs(with_amounts(self.design, self.flank, amounts), self.flank, self.aim)

    def _given(self) -> FloatArray:
        """Return the amounts (n, 1), um, of the design; (n, 0) if they are outside the limits."""
        given = np.array([[amount_of(self.design, self.flank, name)] for name in self.names])
        low, high = self.limits[:, :, None]
        return given[:, ((given >= low) & (given <= high)).all(axis=0)]

    def result(self) -> dict[str, float]:
        """Return the best amounts that satisfy the aim. Raises ValueError if there are none."""
        from scipy.stats.qmc import Halton

        count = len(self.names)
        points_per_variable, starts_count = 16, 3
        x = Halton(count, scramble=False).random(1 + points_per_variable * count).T
        starts = x[:, self._order(self.at(x))[:starts_count]]
        x = np.hstack((starts, *(self._refined(start)[:, None] for start in starts.T)))
        # The given amounts are the first candidate, so that they are the result unless others are better.
        given, trials = self._given(), self.amounts(x)
        candidates = {name: np.append(one, trials[name]) for one, name in zip(given, self.names, strict=True)}
        objectives = self._objectives(candidates).without_leads(given.shape[1])
        order = self._order(objectives)
        met = self._violation(objectives) <= CONSTRAINT_TOLERANCE
        if not met.any():
            raise ValueError(self._reason(objectives))
        module = float(self.design.pinion.tool.normal_module)
        for k in order[met[order]]:
            amounts = {name: float(values[k]) for name, values in candidates.items()}
            design = with_amounts(self.design, self.flank, amounts)
            if jammed(tangent_backlash(design).normal, module):
                continue
            if self.aim.edges or operation_of(design, self.flank, self.aim).edge_share == 0.0:
                return amounts
        reason = "leave no backlash" if self.aim.edges else "leave no backlash or cause edge contact"
        found_amounts = "all amounts that satisfy the constraints"
        raise ValueError(f"{found_amounts} {reason}: reduce the errors, or widen the bounds")

    def _violation(self, objectives: Objectives) -> FloatArray:
        """Return the largest violation (...) of the constraints, relative to their bounds."""
        worst = np.nan_to_num(-objectives.margins(self.aim), nan=np.inf).max(axis=0)
        return np.where(np.isfinite(objectives.shift), np.maximum(worst, 0.0), np.inf)

    def _order(self, objectives: Objectives) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Return the indices of candidates (k,), the best first."""
        missed = self._violation(objectives)
        missed = np.where(missed <= CONSTRAINT_TOLERANCE, 0.0, missed)
        return np.lexsort((np.nan_to_num(objectives.goals.max(axis=0), nan=np.inf), missed))

    def _reason(self, objectives: Objectives) -> str:
        """Return the message if no candidate satisfies the constraints, with the nearest one."""
        k, aim = self._order(objectives)[0], self.aim
        if not np.isfinite(objectives.shift[k]):
            return "no amounts were found with a path under all errors: reduce the errors"
        margins = objectives.margins(aim)[:, k]
        # Margin and words of each constraint; both signs of the distance from mid-face are one constraint.
        ratio, centre = f"{objectives.contact_ratio[k]:.3f}", f"{abs(objectives.centre[k]):.3g} mm"
        swing, shift = f"{objectives.peak_to_peak[k]:.3g} rad", f"{objectives.shift[k]:.3g} mm"
        constraints = [
            (margins[0], f"the contact ratio is {ratio}, less than {aim.contact_ratio:g}"),
            (
                margins[1:3].min(),
                f"the middle of the path is {centre} from mid-face, more than {aim.off_centre:g} mm",
            ),
            (
                margins[3],
                f"the transmission error is {swing}, more than {aim.peak_to_peak:.3g} rad",
            ),
            (margins[4], f"the shift is {shift}, more than {aim.shift:g} mm"),
            (
                margins[5:].min(initial=np.inf),
                "an edge touches, because no other tooth pair is ahead at an end of the path",
            ),
        ]
        return (
            f"no amounts were found that meet the constraints; for the nearest, {min(constraints)[1]}:"
            " relax the constraints, or widen the bounds"
        )

    def _refined(self, start: Vector) -> FloatArray:
        """Return the result x (n) of SLSQP from a start. The last variable is a bound of all objectives,
        relative to the largest one of the start."""
        from scipy.optimize import Bounds as Box, NonlinearConstraint, minimize

        count, given = start.size, self.at(start).goals
        goals, scale = len(given), float(np.nan_to_num(given.max(), nan=1.0)) or 1.0

        def rows(x: FloatArray) -> FloatArray:
            """Return the margins and the negative objectives / scale (rows, k) at x (n, k)."""
            objectives = self.at(x)
            values = np.concatenate((objectives.margins(self.aim), -objectives.goals / scale))
            return np.asarray(np.nan_to_num(values, nan=-1.0))

        def conditions(x: Vector) -> FloatArray:
            """Return the margins, and the common bound x[count] minus each objective / scale."""
            values = rows(x[:count, None])[:, 0]
            return values + np.where(np.arange(values.size) >= values.size - goals, x[count], 0.0)

        def slopes(x: Vector) -> FloatArray:
            """Return the derivatives of the conditions by differences."""
            step = np.where(x[:count] < 0.5, 1e-3, -1e-3)  # into the bounds
            values = rows(x[:count, None] + np.hstack((np.zeros((count, 1)), np.diag(step))))
            by_goal = np.where(np.arange(len(values)) >= len(values) - goals, 1.0, 0.0)
            return np.column_stack(((values[:, 1:] - values[:, :1]) / step, by_goal))

        def greatest(x: Vector) -> float:
            return float(x[count])

        def greatest_slope(x: Vector) -> Vector:
            return np.append(np.zeros(count), 1.0)

        result = minimize(
            greatest,
            np.append(start, 1.0),
            jac=greatest_slope,
            method="SLSQP",
            bounds=Box(np.zeros(count + 1), np.append(np.ones(count), np.inf)),
            constraints=NonlinearConstraint(conditions, 0.0, np.inf, jac=slopes),
            options={"maxiter": 40, "ftol": 1e-9},
        )
        return np.clip(result.x[:count], 0.0, 1.0)


def _check_amounts(design: Design, flank: str, bounds: Mapping[str, Bounds]) -> None:
    """Raise ValueError for unknown names, reliefs without a length, bounds that do not increase, or too many
    of them."""
    max_variables = 6
    if not isinstance(bounds, Mapping):
        raise TypeError(f"bounds must be a dictionary of two numbers by amount, got {shown_value(bounds)}")
    require_two_numbers(**{f"bounds of {name}": two for name, two in bounds.items()})
    if not 0 < len(bounds) <= max_variables:
        raise ValueError(f"bounds must have 1 to {max_variables} amounts, got {len(bounds)}")
    kinds = kinds_of()
    known = [f"{member}.{name}" for member in MEMBERS for name in kinds]
    for name, (low, high) in bounds.items():
        if name not in known:
            raise ArgumentError(name, f"is not an amount that can vary: known are {', '.join(known)}")
        member, _, amount = name.partition(".")
        given = getattr(getattr(design, member), MODIFICATIONS[flank])
        if kinds[amount].has_length and getattr(given, length_of(amount), None) is None:
            cure = f"write {amount} = 0.0 and {length_of(amount)} in [{member}.modification]"
            raise ArgumentError(name, f"can vary only if its length is given: {cure}")
        if not AMOUNT.low <= low < high <= AMOUNT.high:
            limit = f"be two numbers, lower one first, between {AMOUNT.low:g} and {AMOUNT.high:g} um"
            raise ArgumentError(f"bounds of {name}", f"must {limit}, got {low:g}, {high:g}")
