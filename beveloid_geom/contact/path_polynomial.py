"""Paths of contact as polynomials through exact solutions.

`series_over_l1` solves F(l1, l2) = 0 with safeguards at the Chebyshev points of a window in l1 and fits every
quantity by a polynomial. If the coefficients decrease to rounding, the series is resolved: its values
anywhere in the window are solutions to rounding. Otherwise n_x is small in the window, or an l1 has several
contacts; the path is then searched in a narrower window, in cells and along its length (`path_search`).

Arrays have one axis of cases in place of the batch shape. The rows of a series are those of `ROWS`, followed
by the eight limit margins in the order of `Limit`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask, Quantity
from ..gear.rack import rack_normal
from ..pair.frames import common_normal
from ..status import Limit, Status
from ..support.chebyshev import RELATIVE_NOISE, Basis, resolved, resolved_degree
from .curves.curve_equations import meet_on_curve, onto_curve, units_of
from .equation import (
    ContactTerms,
    axial_and_radius,
    contact_normal,
    contact_point,
    gap_tolerance,
    limit_margins,
    meet,
    roll_angles,
    trace_parameters,
)
from .flank_pair import FlankPair
from .parallel.equation import contact_at_l1
from .root_samples import SAMPLE_POSITIONS, RootSamples, root_samples
from .roots import Roots, roots_in, solve_gear_parameter

ROWS = {
    "l1": 0,
    "l2": 1,
    "u1": 2,
    "u2": 3,
    "pinion_z": 4,
    "gear_z": 5,
    "pinion_r": 6,
    "gear_r": 7,
    "pinion_roll": 11,
    "gear_roll": 12,
    "transmission_error": 13,
}
POINT, NORMAL = slice(8, 11), slice(14, 17)
ROLL, PHASE = 11, 13
"""Rows of the pinion roll, and of the phase: gear roll plus N1/N2 pinion roll, rad."""
ROW_COUNT = 17
"""Number of rows without the margins, which begin at this row."""
FULL_ROW_COUNT = ROW_COUNT + len(Limit)
"""Number of rows with the margins."""

MAX_DEGREE = 400
"""Highest degree of a series."""
MAX_ROUNDING_DEPTHS = 1.6e-11
"""Largest rounding error of lengths, relative to the flank depth, that is accepted if the tolerance of a
series is enlarged (`rounding_scale`): 2e-10 mm on Table 1.
"""
SMALL_NORMAL_X = 0.05
"""|n_x| below which a position is solved again with n_x as an unknown."""
POLISHING_STEPS = 5
"""Maximum number of Newton steps from a good approximation."""


@dataclass(frozen=True, eq=False)
class PathSeries:
    """Paths as polynomials of a parameter x in [-1, 1].

    `coefficients` (FULL_ROW_COUNT, cases, degree + 1). `middle`, `half` (cases, 1), mm: l1 = middle + half x.
    They are NaN if x is another parameter: w1, or the position along a chord or along the polynomial through
    traced points (`curves.curve_series`). `status` (cases): SOLVED, or the reason why there is no series.
    """

    coefficients: FloatArray
    middle: FloatArray
    half: FloatArray
    status: Codes

    def cases(self, index: Integers) -> PathSeries:
        """Return the series of the cases `index`."""
        return PathSeries(
            self.coefficients[:, index], self.middle[index], self.half[index], self.status[index]
        )


def not_over_l1(coefficients: FloatArray, status: Codes) -> PathSeries:
    """Return series whose parameter is not a linear function of l1."""
    void = np.full((len(status), 1), np.nan)
    return PathSeries(coefficients, void, void, status)


def exact_rows(pairing: FlankPair, l1: FloatArray, roots: Roots | None = None) -> tuple[FloatArray, Codes]:
    """Return the rows (FULL_ROW_COUNT, cases, positions) at every l1 (cases, positions), mm, and the Status
    of each position.

    NaN where not solved. `roots` are used if they are known.
    """
    parallel = pairing.parallel
    if parallel.any():
        return _exact_rows_by_axes(pairing, l1, parallel)
    roots = solve_gear_parameter(pairing, l1) if roots is None else roots
    l = np.array((l1, roots.l2))
    met = meet(pairing, l) if roots.met is None else roots.met
    tolerance = gap_tolerance(pairing)
    # Polish the roots to rounding.
    for _ in range(2):
        if not (np.abs(met.gap) > 2.0 * tolerance).any():
            break
        l[1] -= met.gap / roots.slope
        met = meet(pairing, l)
    good = np.abs(met.gap) <= 8.0 * tolerance
    if not good.all():
        # n_x^2 is a difference of terms near 1. For small n_x its rounding error enters F through B w.
        rounding = sys.float_info.epsilon * np.abs(met.slope * met.across).sum(axis=0) / met.normal_x**2
        good = np.abs(met.gap) <= 8.0 * (tolerance + rounding)
    rows = _rows_and_settled(pairing, l, met, good)
    status = roots.status.copy()
    if not good.all():
        status[~good & (status == Status.SOLVED)] = Status.NOT_CONVERGED
    if pairing.undefined.any():
        status[pairing.undefined] = Status.UNDEFINED
    if status.any():
        rows[:, status != Status.SOLVED] = np.nan
    return rows, status


def _exact_rows_by_axes(pairing: FlankPair, l1: FloatArray, parallel: Mask) -> tuple[FloatArray, Codes]:
    """Return the result of `exact_rows` if some cases have parallel axes: their contacts midway between the
    mid-faces.
    """
    rows, status = np.empty((FULL_ROW_COUNT, *l1.shape)), np.full(l1.shape, np.int8(Status.OFF_FLANK))
    crossed, others = np.flatnonzero(~parallel), np.flatnonzero(parallel)
    if crossed.size:
        rows[:, crossed], status[crossed] = exact_rows(pairing.cases(crossed), l1[crossed])
    part = pairing.cases(others)
    l, met, good = contact_at_l1(part, l1[others])
    rows[:, others] = np.where(good, rows_of(part, l, met), np.nan)
    status[others] = np.where(good, np.int8(Status.SOLVED), np.int8(Status.OFF_FLANK))
    status[pairing.undefined] = Status.UNDEFINED
    return rows, status


def _rows_and_settled(pairing: FlankPair, l: FloatArray, met: ContactTerms, good: Mask) -> FloatArray:
    """Return rows of contacts at `l` (2, cases, positions).

    Where |n_x| is below SMALL_NORMAL_X, l2 determines n_x only with large rounding errors. These contacts are
    solved again with n_x as an unknown, and `good` then states whether this succeeded.
    """
    weak = np.abs(met.normal_x) < SMALL_NORMAL_X
    if not weak.any():
        return rows_of(pairing, l, met)
    cases = np.flatnonzero(weak.any(axis=-1))
    part, weak = pairing.cases(cases), weak[cases]
    # Newton's method in l2, n_x and w1 at constant l1.
    units, y = units_of(part), np.array((*l, met.normal_x, met.across[0]))[:, cases]
    start = np.moveaxis(y, 0, -1) / units
    z, solved = onto_curve(part, start, np.broadcast_to(np.eye(4)[0], start.shape), units, POLISHING_STEPS)
    # Largest change in this step, in units of z.
    max_correction = 1e-4
    solved &= weak & (np.abs(z - start).max(axis=-1) < max_correction)
    y[1:] = np.where(solved, np.moveaxis(z * units, -1, 0)[1:], y[1:])
    good[cases] = np.where(weak, solved, good[cases])
    rows = rows_of(part, y[:2], meet_on_curve(part, y)[1])
    if cases.size < len(good):
        settled, rows = rows, rows_of(pairing, l, met)
        rows[:, cases] = settled
    return rows


def rows_of(pairing: FlankPair, l: FloatArray, met: ContactTerms) -> FloatArray:
    """Return rows (FULL_ROW_COUNT, cases, positions) of contacts at `l` with the terms `met`."""
    z, radius = axial_and_radius(pairing, met)
    roll = roll_angles(pairing, met)
    rows = np.empty((FULL_ROW_COUNT, *l.shape[1:]))
    rows[0:2], rows[2:4], rows[4:6], rows[6:8] = l, trace_parameters(pairing, met, z), z, radius
    rows[POINT], rows[NORMAL] = contact_point(met), contact_normal(met)
    rows[ROLL : ROLL + 2] = roll
    rows[PHASE] = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    rows[ROW_COUNT:] = limit_margins(pairing, l, z, radius)
    return rows


def rounding_scale(
    pairing: FlankPair, loosened: Quantity = 1.0, loosest: float = MAX_ROUNDING_DEPTHS
) -> FloatArray:
    """Return the sizes (FULL_ROW_COUNT, cases) to which the rounding errors of the rows are proportional.

    `loosened` (a number or (cases,)) is the factor by which the rounding error of a series exceeds the
    rounding error of the terms of the equations. The sizes of lengths are multiplied by it, but the enlarged
    rounding error of a length is at most the fraction `loosest` of the flank depth. The size of a roll is
    that of a length divided by the pitch radius, and at least 1."""
    size = pairing.scale[:, 0]
    scale = np.ones((FULL_ROW_COUNT, len(size)))
    if np.any(np.asarray(loosened) > 1.0):
        depth = (pairing.highest - pairing.lowest).min(axis=0)[:, 0]
        size = np.maximum(size, np.minimum(loosened * size, loosest / RELATIVE_NOISE * depth))
        scale[[ROLL, ROLL + 1, PHASE]] = np.maximum(
            1.0, size / np.asarray(pairing.rack.pitch_radius).min(axis=0)[:, 0]
        )
        scale[NORMAL] = loosened
    scale[:ROLL] = scale[ROW_COUNT:] = size  # lengths
    return scale


def fitted_series(
    pairing: FlankPair,
    rows: FloatArray,
    basis: Basis,
    loosened: Quantity = 1.0,
    loosest: float = MAX_ROUNDING_DEPTHS,
) -> tuple[FloatArray, Mask]:
    """Return coefficients through `rows` at the nodes of a basis, and which cases they resolve."""
    coefficients, scale = basis.coefficients(rows), rounding_scale(pairing, loosened, loosest)
    degree = resolved_degree(coefficients, scale)
    if degree is not None:
        return coefficients[..., : degree + 1], np.ones(rows.shape[1], dtype=bool)
    return coefficients, resolved(coefficients, scale)


def between(known: FloatArray, new: FloatArray) -> FloatArray:
    """Return values (..., nodes) at all nodes of a degree: the `known` ones at the nodes of half the degree,
    and the `new` ones at the nodes between."""
    if known.shape[-1] == 0:
        return new
    values = np.empty((*new.shape[:-1], known.shape[-1] + new.shape[-1]))
    values[..., ::2], values[..., 1::2] = known, new
    return values


def series_over_l1(
    pairing: FlankPair, low: FloatArray, high: FloatArray, basis: Basis, one_curve: bool = False
) -> tuple[PathSeries, RootSamples]:
    """Return series over l1, by roots in a window from `low` to `high` in l1 and l2 (2, cases, 1), mm, and
    the samples of F.

    The status is NOT_CONVERGED if an l1 has no root in the window or two on the flanks, or if `basis` does
    not resolve the path. `one_curve`: the window is known to contain a single curve, so that fewer samples
    suffice.
    """
    (middle, _), (half, _) = 0.5 * (low + high), 0.5 * (high - low)
    l1 = middle + half * basis.nodes
    samples = root_samples(
        pairing, l1, np.array((low[1], high[1])), SAMPLE_POSITIONS[::2] if one_curve else SAMPLE_POSITIONS
    )
    samples = samples.of_main_direction() if one_curve else samples
    # Roots beyond root or tip of the gear are not on the flanks and are used only if there is no other.
    samples = samples.preferring(pairing.lowest[1], pairing.highest[1])
    status = np.full(len(l1), np.int8(Status.NOT_CONVERGED))
    status[pairing.undefined] = Status.UNDEFINED
    # Cases without a root at each node, and cases that cannot converge, are not solved.
    tried = samples.change.any(axis=0).all(axis=-1) & ~pairing.undefined
    # Number of cases up to which polishing is cheaper than the prediction.
    if len(l1) > 4 and not pairing.without_parabola.all():
        tried &= ~_hopeless(pairing, np.array((l1, samples.of_main_direction().rough())), basis)
    at, part, subset = np.flatnonzero(tried), pairing, samples
    if at.size < len(l1):
        part, l1, subset = pairing.cases(at), l1[at], samples.cases(at)
    rows, result = exact_rows(part, l1, roots_in(part, l1, subset, POLISHING_STEPS))
    coefficients, good = fitted_series(part, rows, basis)
    status[at[~result.any(axis=-1) & good]] = Status.SOLVED
    if at.size < len(status):
        of_all = np.full((FULL_ROW_COUNT, len(status), coefficients.shape[-1]), np.nan)
        of_all[:, at] = coefficients
        coefficients = of_all
    return PathSeries(coefficients, middle, half, status), samples


def _hopeless(pairing: FlankPair, l: FloatArray, basis: Basis) -> Mask:
    """Return for which cases, approximately at l (2, cases, positions), mm, n_x changes too much for this
    degree.

    The Chebyshev coefficients of the square root of a straight line with its zero at `zero`, outside [-1, 1],
    decrease by the factor `rate` from one to the next.
    """
    x_squared = common_normal(pairing.layout, rack_normal(pairing.rack, l)[2]).x_squared
    # n_x^2 is nearly linear in l1; its zero follows from the extreme values in the window.
    share = np.maximum(x_squared.min(axis=-1) / x_squared.max(axis=-1), 0.0)
    zero = (1.0 + share) / (1.0 - share)
    rate = zero + np.sqrt(zero * zero - 1.0)
    # Predicted last coefficient, relative to the first, above which the case is not solved with this basis.
    predicted_limit = 1e-12
    return np.asarray(rate ** (1.0 - basis.nodes.size) > predicted_limit)
