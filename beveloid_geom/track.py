"""Paths of contact as polynomials through exact solutions.

`track_over_l1` solves F(l1, l2) = 0 safely at the Chebyshev points of a window in l1 that covers the
pinion flank, and fits every quantity asked for by a polynomial. If the coefficients fall to
rounding the track is resolved: its values anywhere in the window are solutions to rounding.
Where they do not, n_x vanishes in the window or an l1 has several contacts, and the path is
followed by its length (`follow`).

Arrays have one axis of cases in place of the batch shape. The rows of a track are those of
`ROWS`, then the eight limit margins in the order of `Limit`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .contact import (
    Limit,
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
from .curve import (
    HIGHEST,
    Basis,
    basis_of,
    resolved_degree,
)
from .inputs import FloatArray
from .solve import Status, solve_gear_parameter

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

COARSE, FINE = basis_of(20), basis_of(HIGHEST)
LARGEST = 400
"""Highest degree of a track."""
WINDOW_MARGIN = 0.02
"""Share of the flank depth by which the window of l1 reaches beyond root and tip."""
STEEP = 128.0
"""Gap tolerances (1e-10 mm on Table 1) up to which a position near n_x = 0 still counts as solved."""


@dataclass(frozen=True, eq=False)
class Track:
    """Paths as polynomials of a parameter x in [-1, 1].

    `coefficients` (WIDTH, cases, degree + 1). `middle`, `half` (cases, 1), mm: l1 = middle + half x,
    but NaN where the path is followed by its length and x is no function of l1. `status` (cases):
    SOLVED, or why there is no track. `elsewhere` (cases): pieces on the flanks of other paths of
    the same case, which cover less roll."""

    coefficients: FloatArray
    middle: FloatArray
    half: FloatArray
    status: NDArray[np.int8]
    elsewhere: NDArray[np.int_]

    def merged(self, other: Track, cases: NDArray[np.int_]) -> Track:
        """This track with those of the `other` in place of its `cases`."""
        sizes = self.coefficients.shape[-1], other.coefficients.shape[-1]
        coefficients = np.zeros((WIDTH, len(self.status), max(sizes)))
        coefficients[..., : sizes[0]] = self.coefficients
        coefficients[:, cases] = 0.0
        coefficients[:, cases, : sizes[1]] = other.coefficients
        middle, half = self.middle.copy(), self.half.copy()
        status, elsewhere = self.status.copy(), self.elsewhere.copy()
        middle[cases], half[cases] = other.middle, other.half
        status[cases], elsewhere[cases] = other.status, other.elsewhere
        return Track(coefficients, middle, half, status, elsewhere)


def exact_rows(pairing: Pairing, l1: FloatArray) -> tuple[FloatArray, NDArray[np.int8]]:
    """Solve at every l1 (cases, positions), mm: the rows (WIDTH, cases, positions), NaN
    where not solved, and the Status of each position."""
    roots = solve_gear_parameter(pairing, l1)
    l = np.array((l1, roots.l2))
    met = meet(pairing, l)
    tolerance = gap_tolerance(pairing)
    for _ in range(2):
        if (np.abs(met.gap) <= 2.0 * tolerance).all():
            break
        l[1] -= met.gap / roots.slope
        met = meet(pairing, l)
    # n_x^2 is a difference of terms near 1: near n_x = 0 its rounding reaches F through B w.
    rounding = np.finfo(float).eps * np.abs(met.slope * met.across).sum(axis=0) / met.normal_x**2
    good = np.abs(met.gap) <= np.minimum(8.0 * (tolerance + rounding), STEEP * tolerance)
    status = np.where((roots.status == Status.SOLVED) & ~good, np.int8(Status.NOT_CONVERGED), roots.status)
    rows = rows_of(pairing, l, met)
    if (status != Status.SOLVED).any():
        rows[:, status != Status.SOLVED] = np.nan
    return rows, status


def rows_of(pairing: Pairing, l: FloatArray, met: Meeting) -> FloatArray:
    """Rows (WIDTH, cases, positions) of contacts at `l` with the terms `met`."""
    z, radius = axial_and_radius(pairing, met)
    roll = roll_angles(pairing, met)
    rows = np.empty((WIDTH, *l.shape[1:]))
    rows[0:2], rows[2:4], rows[4:6], rows[6:8] = l, trace_parameters(pairing, met, z), z, radius
    rows[POINT], rows[NORMAL] = contact_point(met), contact_normal(met)
    rows[ROLL : ROLL + 2] = roll
    rows[PHASE] = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    rows[HEIGHT:] = limit_margins(pairing, l, z, radius)
    return rows


def resolving_degree(pairing: Pairing, coefficients: FloatArray) -> int | None:
    """Degree that gives all rows to rounding, None if these coefficients do not."""
    scale = np.ones(len(coefficients))
    scale[LENGTHS] = scale[HEIGHT:] = pairing.scale.max()
    return resolved_degree(coefficients, scale)


def fitted(pairing: Pairing, rows: FloatArray, basis: Basis) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Coefficients through `rows` at the nodes of a basis, and which cases they resolve."""
    coefficients = basis.coefficients(rows)
    degree = resolving_degree(pairing, coefficients)
    if degree is not None:
        return coefficients[..., : degree + 1], np.ones(rows.shape[1], dtype=bool)
    resolved = np.zeros(rows.shape[1], dtype=bool)
    for case in np.flatnonzero(np.isfinite(rows).all(axis=(0, 2))):
        one = slice(case, case + 1)
        resolved[case] = resolving_degree(pairing.cases(one), coefficients[:, one]) is not None
    return coefficients, resolved


def track_over_l1(pairing: Pairing) -> Track:
    """The track over the pinion's flank, NOT_CONVERGED where l1 does not resolve the path."""
    low, high = pairing.lowest[0], pairing.highest[0]
    middle, half = 0.5 * (low + high), (0.5 + WINDOW_MARGIN) * (high - low)
    track = _over_window(pairing, middle, half, COARSE)
    if not track.status.any():
        return track
    # Where all points are solved, a higher degree may do.
    solved = np.isfinite(track.coefficients).all(axis=(0, 2))
    finer = np.flatnonzero((track.status != Status.SOLVED) & solved)
    if finer.size == 0:
        return track
    return track.merged(_over_window(pairing.cases(finer), middle[finer], half[finer], FINE), finer)


def _over_window(pairing: Pairing, middle: FloatArray, half: FloatArray, basis: Basis) -> Track:
    rows, found = exact_rows(pairing, middle + half * basis.nodes)
    coefficients, resolved = fitted(pairing, rows, basis)
    status = found.max(axis=-1)
    status[(status == Status.SOLVED) & ~resolved] = Status.NOT_CONVERGED
    return Track(coefficients, middle, half, status, np.zeros(status.shape, dtype=int))
