"""Paths of contact as polynomials through exact solutions.

`series_over_l1` solves F(l1, l2) = 0 safely at the Chebyshev points of a window in l1, and fits every
quantity asked for by a polynomial. If the coefficients fall to rounding the series is resolved: its values
anywhere in the window are solutions to rounding. Where they do not, n_x is small in the window or an l1 has
several contacts, and the path is sought in a narrower window, in cells and along its length (`path_search`).

Arrays have one axis of cases in place of the batch shape. The rows of a series are those of
`ROWS`, then the eight limit margins in the order of `Limit`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..gear.rack import rack_normal
from ..pair.frames import common_normal
from ..status import Limit, Status
from ..support.chebyshev import NOISE, Basis, basis_of, resolved, resolved_degree
from .curve_equations import meet_on_curve, onto_curve, units_of
from .equation import (
    Meeting,
    Pairing,
    axial_and_radius,
    contact_normal,
    contact_point,
    gap_tolerance,
    limit_margins,
    meet,
    roll_angles,
    trace_parameters,
)
from .parallel.equation import contact_at_l1
from .roots import SHARES, Roots, Samples, roots_in, samples_of, solve_gear_parameter

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
POINT, NORMAL, LENGTHS = slice(8, 11), slice(14, 17), slice(0, 11)
ROLL, PHASE, HEIGHT = 11, 13, 17
WIDTH = HEIGHT + len(Limit)
"""Rows of quantities, and with the margins."""

COARSE, FINE = basis_of(16), basis_of(20)
LARGEST = 400
"""Highest degree of a series."""
HOPELESS = 1e-12
"""Last coefficient, relative to the first, above which roots are not polished."""
LOOSENED = 16.0
"""Rounding allowed, relative to that of the terms, where no basis brings it down to that: the curve turns
sharply against rounding, or a member has next to no base circle."""
LOOSEST = 1.6e-11
"""Rounding, as a share of a flank's depth, up to which a series may be loosened: 2e-10 mm on Table 1."""
STEEP, NEAR, PASSES = 0.05, 1e-4, 5
"""|n_x| below which a position is solved again with n_x as an unknown; how far, in units of z, that may
move it; passes of Newton."""


@dataclass(frozen=True, eq=False)
class PathSeries:
    """Paths as polynomials of a parameter x in [-1, 1].

    `coefficients` (WIDTH, cases, degree + 1). `middle`, `half` (cases, 1), mm: l1 = middle + half x,
    but NaN where the path is followed by its length and x is no function of l1. `status` (cases):
    SOLVED, or why there is no series."""

    coefficients: FloatArray
    middle: FloatArray
    half: FloatArray
    status: NDArray[np.int8]

    def cases(self, index: NDArray[np.int_]) -> PathSeries:
        """Give the series of the cases `index`."""
        return PathSeries(
            self.coefficients[:, index], self.middle[index], self.half[index], self.status[index]
        )


def by_length(coefficients: FloatArray, status: NDArray[np.int8]) -> PathSeries:
    """Give series whose parameter is no function of l1."""
    void = np.full((len(status), 1), np.nan)
    return PathSeries(coefficients, void, void, status)


def exact_rows(
    pairing: Pairing, l1: FloatArray, roots: Roots | None = None
) -> tuple[FloatArray, NDArray[np.int8]]:
    """Solve at every l1 (cases, positions), mm: the rows (WIDTH, cases, positions), NaN where not solved, and
    the Status of each position; from `roots` if these are at hand."""
    parallel = pairing.parallel
    if parallel.any():
        return _exact_rows_by_axes(pairing, l1, parallel)
    roots = solve_gear_parameter(pairing, l1) if roots is None else roots
    l = np.array((l1, roots.l2))
    met = meet(pairing, l)
    tolerance = gap_tolerance(pairing)
    for _ in range(2):
        if not (np.abs(met.gap) > 2.0 * tolerance).any():
            break
        l[1] -= met.gap / roots.slope
        met = meet(pairing, l)
    # n_x^2 is a difference of terms near 1: for small n_x its rounding reaches F through B w.
    rounding = np.finfo(float).eps * np.abs(met.slope * met.across).sum(axis=0) / met.normal_x**2
    good = np.abs(met.gap) <= 8.0 * (tolerance + rounding)
    rows = _rows_and_settled(pairing, l, met, good)
    status = np.where((roots.status == Status.SOLVED) & ~good, np.int8(Status.NOT_CONVERGED), roots.status)
    undefined = pairing.undefined
    if undefined.any():
        status[undefined] = Status.UNDEFINED
    if status.any():
        rows[:, status != Status.SOLVED] = np.nan
    return rows, status


def _exact_rows_by_axes(
    pairing: Pairing, l1: FloatArray, parallel: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.int8]]:
    """Give the same where some cases have parallel axes: of their contacts that midway between the
    mid-faces."""
    rows, status = np.empty((WIDTH, *l1.shape)), np.full(l1.shape, np.int8(Status.OFF_FLANK))
    crossed, others = np.flatnonzero(~parallel), np.flatnonzero(parallel)
    if crossed.size:
        rows[:, crossed], status[crossed] = exact_rows(pairing.cases(crossed), l1[crossed])
    part = pairing.cases(others)
    l, met, good = contact_at_l1(part, l1[others])
    rows[:, others] = np.where(good, rows_of(part, l, met), np.nan)
    status[others] = np.where(good, np.int8(Status.SOLVED), np.int8(Status.OFF_FLANK))
    status[pairing.undefined] = Status.UNDEFINED
    return rows, status


def _rows_and_settled(pairing: Pairing, l: FloatArray, met: Meeting, good: NDArray[np.bool_]) -> FloatArray:
    """Give rows of contacts at `l` (2, cases, positions). Where |n_x| is under STEEP they are solved again
    with n_x as an unknown, which l2 alone fixes but coarsely, and `good` then says whether that was done."""
    weak = np.abs(met.normal_x) < STEEP
    cases = np.flatnonzero(weak.any(axis=-1))
    if cases.size == 0:
        return rows_of(pairing, l, met)
    part, weak = pairing.cases(cases), weak[cases]
    units, y = units_of(part), np.array((*l, met.normal_x, met.across[0]))[:, cases]
    start = np.moveaxis(y, 0, -1) / units
    z, solved = onto_curve(part, start, np.broadcast_to(np.eye(4)[0], start.shape), units, PASSES)
    solved &= weak & (np.abs(z - start).max(axis=-1) < NEAR)
    y[1:] = np.where(solved, np.moveaxis(z * units, -1, 0)[1:], y[1:])
    good[cases] = np.where(weak, solved, good[cases])
    rows = rows_of(part, y[:2], meet_on_curve(part, y)[1])
    if cases.size < len(good):
        settled, rows = rows, rows_of(pairing, l, met)
        rows[:, cases] = settled
    return rows


def rows_of(pairing: Pairing, l: FloatArray, met: Meeting) -> FloatArray:
    """Give rows (WIDTH, cases, positions) of contacts at `l` with the terms `met`."""
    z, radius = axial_and_radius(pairing, met)
    roll = roll_angles(pairing, met)
    rows = np.empty((WIDTH, *l.shape[1:]))
    rows[0:2], rows[2:4], rows[4:6], rows[6:8] = l, trace_parameters(pairing, met, z), z, radius
    rows[POINT], rows[NORMAL] = contact_point(met), contact_normal(met)
    rows[ROLL : ROLL + 2] = roll
    rows[PHASE] = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    rows[HEIGHT:] = limit_margins(pairing, l, z, radius)
    return rows


def rounding_scale(pairing: Pairing, loosened: float = 1.0) -> FloatArray:
    """Give sizes (WIDTH, cases) to which the rounding of the rows relates.

    `loosened` is for series whose rounding is more than that of the sizes of their terms: it lets lengths
    be less exact by this factor, as long as that is below LOOSEST, and rolls by as much at the pitch
    radius."""
    size = pairing.scale[:, 0]
    scale = np.ones((WIDTH, len(size)))
    if loosened > 1.0:
        depth = (pairing.highest - pairing.lowest).min(axis=0)[:, 0]
        size = np.maximum(size, np.minimum(loosened * size, LOOSEST / NOISE * depth))
        scale[[ROLL, ROLL + 1, PHASE]] = np.maximum(
            1.0, size / np.asarray(pairing.rack.pitch_radius).min(axis=0)[:, 0]
        )
        scale[NORMAL] = loosened
    scale[LENGTHS] = scale[HEIGHT:] = size
    return scale


def fitted(
    pairing: Pairing, rows: FloatArray, basis: Basis, loosened: float = 1.0
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give coefficients through `rows` at the nodes of a basis, and which cases they resolve."""
    coefficients, scale = basis.coefficients(rows), rounding_scale(pairing, loosened)
    degree = resolved_degree(coefficients, scale)
    if degree is not None:
        return coefficients[..., : degree + 1], np.ones(rows.shape[1], dtype=bool)
    return coefficients, resolved(coefficients, scale)


def between(known: FloatArray, new: FloatArray) -> FloatArray:
    """Give values (..., nodes) at the nodes of a degree, out of those at half the degree and those
    between."""
    if known.shape[-1] == 0:
        return new
    values = np.empty((*new.shape[:-1], known.shape[-1] + new.shape[-1]))
    values[..., ::2], values[..., 1::2] = known, new
    return values


def series_over_l1(
    pairing: Pairing, low: FloatArray, high: FloatArray, basis: Basis, one_curve: bool = False
) -> tuple[PathSeries, Samples]:
    """Give series over l1, by roots in a window from `low` to `high` in l1 and l2 (2, cases, 1), mm:
    NOT_CONVERGED where some l1 has none there, or two on the flanks, or `basis` does not resolve the path.
    And the samples, fewer of them where it is known that there is but `one_curve`."""
    (middle, _), (half, _) = 0.5 * (low + high), 0.5 * (high - low)
    l1 = middle + half * basis.nodes
    samples = samples_of(pairing, l1, np.array((low[1], high[1])), SHARES[::2] if one_curve else SHARES)
    samples = samples.one_way() if one_curve else samples
    status = np.full(len(l1), np.int8(Status.NOT_CONVERGED))
    status[pairing.undefined] = Status.UNDEFINED
    tried = samples.change.any(axis=0).all(axis=-1) & (status != Status.UNDEFINED)
    if np.any(pairing.rack.parabola):
        tried &= ~_hopeless(pairing, np.array((l1, samples.one_way().rough())), basis)
    at, part, some = np.flatnonzero(tried), pairing, samples
    if at.size < len(l1):
        part, l1, some = pairing.cases(at), l1[at], samples.cases(at)
    rows, found = exact_rows(part, l1, roots_in(part, l1, some, PASSES))
    coefficients, good = fitted(part, rows, basis)
    status[at[(found == Status.SOLVED).all(axis=-1) & good]] = Status.SOLVED
    if at.size < len(status):
        of_some, coefficients = coefficients, np.full((WIDTH, len(status), coefficients.shape[-1]), np.nan)
        coefficients[:, at] = of_some
    return PathSeries(coefficients, middle, half, status), samples


def _hopeless(pairing: Pairing, l: FloatArray, basis: Basis) -> NDArray[np.bool_]:
    """Say of which cases, roughly at l (2, cases, positions), mm, n_x changes too much for this degree: the
    root of a straight line that crosses zero at `zero`, beyond [-1, 1], has Chebyshev coefficients that fall
    by the factor `rate` from each to the next."""
    x_squared = common_normal(pairing.layout, rack_normal(pairing.rack, l)[2]).x_squared
    share = np.maximum(x_squared.min(axis=-1) / x_squared.max(axis=-1), 0.0)
    zero = (1.0 + share) / (1.0 - share)
    rate = zero + np.sqrt(zero * zero - 1.0)
    return np.asarray(rate ** (1.0 - basis.nodes.size) > HOPELESS)
