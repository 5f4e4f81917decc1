"""Number and stations of the cells of a grid whose triangles stay within a tolerance.

1. Over a cell of the size (h_s, h_z), a flat triangle deviates from a surface with the second fundamental
   form (L, M, N) by at most

       |L h_s^2| / 8 and |N h_z^2| / 8 on the legs,  |L h_s^2 -/+ 2 M h_s h_z + N h_z^2| / 8 on the diagonal,

   with the upper sign for the diagonal along which s increases while z decreases. Cells are therefore about
   sqrt(8 tolerance / L) by sqrt(8 tolerance / N).
2. Stations are placed such that the integrals of sqrt(|L|) along s, and of sqrt(|N|) along z, are the same
   for each cell.
3. The diagonal is the one that follows the surface. On an involute helicoid, which is developable, the
   correct diagonal adds no deviation, and the wrong one makes it four times as large.
4. The number of cells is the smallest one for which the estimate keeps the tolerance. The estimate is scaled
   by the ratio of measured and estimated deviations of a first grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from .sheet import Sheet, falling_diagonals, grid_of

MAX_POINTS = 20_000_000
"""Largest number of points of a surface or a solid."""
CELL_STEPS = 6
"""Number of steps along each side of a cell, to points at which the deviation is measured."""
IN_TRIANGLE = np.array([(i, j) for i in range(5) for j in range(5 - i)]).T / 4.0
"""Points of a triangle with sides 1 along s and z, at which its deviation is estimated."""
RATIOS = np.vander(np.geomspace(1.0 / 16.0, 16.0, 17), 3, increasing=True)
"""Powers 0, 1 and 2 of the ratios of the sides of a cell for which the largest deviation is looked up."""


@dataclass(frozen=True, eq=False)
class Form:
    """Second fundamental form of a surface in stretched coordinates (0 ... 1 along profile and face).

    `factors` (n, 3), mm: factors of 1/ns^2, 1/(ns nz) and 1/nz^2 in each of the n deviations of a cell that
    may be the largest one. `profile` and `face`: s and relative z (0 ... 1) at even steps of the stretched
    coordinates."""

    factors: FloatArray
    profile: FloatArray
    face: FloatArray


def form_of(sheet: Sheet, tolerance: float) -> Form:
    """Return the second fundamental form of a surface, with the stretching that takes the fewest cells."""
    # Numbers of stations along s and z at which the second fundamental form is computed.
    form_stations = (9, 7)
    # Fractions of the largest curvature that are added everywhere. The larger one is for surfaces with
    # a line of inflection, where the small curvature along one direction alone would allow too large
    # cells.
    min_curvature_shares = (0.01, 0.5)
    s = np.linspace(0.0, 1.0, form_stations[0])
    z = sheet.half_width * np.linspace(-1.0, 1.0, form_stations[1])
    grid = grid_of(sheet, s, z)
    by_s, by_z = (
        np.gradient(np.stack((grid.points, grid.normals)), 1.0 / (count - 1), axis=axis, edge_order=2)
        for axis, count in ((1, form_stations[0]), (2, form_stations[1]))
    )
    L = -np.einsum("...i,...i", by_s[0], by_s[1])
    M = -np.einsum("...i,...i", by_s[0], by_z[1])
    N = -np.einsum("...i,...i", by_z[0], by_z[1])
    forms = [_stretched(L, M, N, evenness) for evenness in min_curvature_shares]
    return min(forms, key=lambda form: np.prod(np.add(cells_for(form, tolerance), 1)))


def _stretched(L: FloatArray, M: FloatArray, N: FloatArray, evenness: float) -> Form:
    (profile, stretch_s), (face, stretch_z) = _stretching(L, evenness), _stretching(N.T, evenness)
    stretched = L * stretch_s[:, None] ** 2, M * stretch_s[:, None] * stretch_z, N * stretch_z**2
    return Form(_factors(*(part.reshape(-1, 1) for part in stretched)), profile, face)


def _stretching(curvature: FloatArray, evenness: float) -> tuple[FloatArray, FloatArray]:
    """Return 129 stations between which the integral of the square root of the largest `curvature` (n,
    others) is the same, and the derivative (n,) of the coordinate (0 ... 1) by the stretched coordinate
    (see Form) at the n given points."""
    greatest = np.abs(curvature).max(axis=1)
    density = np.sqrt(greatest + evenness * greatest.max() + 1e-24)
    even, fine = np.linspace(0.0, 1.0, density.size), np.linspace(0.0, 1.0, 129)
    dense = np.interp(fine, even, density)
    share = np.concatenate(([0.0], np.cumsum(0.5 * (dense[1:] + dense[:-1]))))
    share /= share[-1]
    return np.interp(fine, share, fine), dense.mean() / density


def stations(form: Form, ns: int, nz: int, half_width: float) -> tuple[FloatArray, FloatArray]:
    """Return the stations s and z (mm) of a grid of ns x nz cells."""
    even = np.linspace(0.0, 1.0, form.profile.size)
    s = np.interp(np.linspace(0.0, 1.0, ns + 1), even, form.profile)
    return s, half_width * (2.0 * np.interp(np.linspace(0.0, 1.0, nz + 1), even, form.face) - 1.0)


def _factors(L: FloatArray, M: FloatArray, N: FloatArray) -> FloatArray:
    """Return the `factors` (n, 3) of a Form, for those deviations in a cell that may be the largest one. The
    second fundamental form is given as L, M and N (samples, 1).

    The diagonal is the one that follows the surface. In cells of the sizes chosen here, edges along s and z
    deviate by similar amounts, so that the sign of M (L + N) decides."""
    balance = np.abs(L).max() / max(np.abs(N).max(), 1e-300)
    M = np.where(M * (L + balance * N) < 0.0, -M, M)
    s, z = IN_TRIANGLE
    parts = np.broadcast_arrays(0.5 * L * s * (1.0 - s), -M * s * z, 0.5 * N * z * (1.0 - z))
    factors = np.stack([part.ravel() for part in parts])
    # Only deviations that are the largest for some ratio of the sides matter.
    sides = np.concatenate((RATIOS * np.clip(balance, 1e-6, 1e6) ** (0.0, 0.5, 1.0), np.eye(3)))
    return np.asarray(factors.T[np.unique(np.abs(sides @ factors).argmax(axis=1))])


def estimated_deviation(form: Form, ns: float, nz: float) -> float:
    """Return the deviation (mm) of ns x nz cells that the second fundamental form predicts."""
    return float(np.abs(form.factors @ (1.0 / ns**2, 1.0 / (ns * nz), 1.0 / nz**2)).max()) + 1e-300


def cells_for(form: Form, tolerance: float) -> tuple[int, int]:
    """Return the numbers of cells (ns, nz) with the fewest points that keep a tolerance by the estimate.
    Raises ValueError for a tolerance that is not positive or needs too many points."""
    if not 0.0 < tolerance < np.inf:
        raise ValueError(f"tolerance must be a positive length in mm, got {tolerance:g}")
    a, b, _ = np.concatenate((form.factors, -form.factors)).T
    bound = max(tolerance, 1e-50)  # smaller ones cannot be met, and their squares underflow
    least = max(1.0, np.ceil(np.sqrt(a.max() / bound) - 1e-9))
    most = 4.0 * least + np.floor(2.0 * np.sqrt(b.max() / bound)) + 2.0
    counts = np.unique(np.round(np.geomspace(least, most, 60))).astype(float)[:, None]
    across = columns_for(form.factors, counts, bound)
    points = (counts[:, 0] + 1.0) * (across + 1.0)
    best = int(np.argmin(points))
    if points[best] > MAX_POINTS:
        count = f"{points[best]:.2g} points, the limit is {MAX_POINTS:.2g}"
        raise ValueError(f"tolerance {tolerance:g} mm needs {count}: increase the tolerance")
    return int(counts[best, 0]), int(across[best])


def columns_for(factors: FloatArray, rows: FloatArray, tolerance: float) -> FloatArray:
    """Return the smallest numbers of columns (n,) for `rows` (n, 1) that keep a tolerance (mm) by the
    estimate of the `factors` (m, 3) of a Form.

    Each deviation is a quadratic in 1/columns. The longest cell is that at which it first reaches the
    tolerance. If the rows alone exceed the tolerance, the number of columns is very large."""
    a, b, c = np.concatenate((factors, -factors)).T
    left, b = np.maximum(tolerance - a / rows**2, 1e-9 * tolerance), b / rows
    with np.errstate(invalid="ignore"):
        across = np.fmax.reduce((b + np.sqrt(b * b + 4.0 * c * left)) / (2.0 * left), axis=1)
    return np.asarray(np.maximum(np.ceil(across - 1e-9), 1.0))


def measured_deviation(sheet: Sheet, form: Form, ns: int, nz: int) -> float:
    """Return the largest distance (mm), along the normals of a surface, from the triangles of its grid of ns
    x nz cells. It is measured at a lattice of points in up to 12 rows and columns of cells."""
    (rows, s), (columns, z) = (_inside_cells(values) for values in stations(form, ns, nz, sheet.half_width))
    grid, shape = grid_of(sheet, s, z), (rows, CELL_STEPS + 1, columns, CELL_STEPS + 1, 3)
    true, normals = (values.reshape(shape).swapaxes(1, 2) for values in (grid.points, grid.normals))
    ends = np.s_[:, :, ::CELL_STEPS, ::CELL_STEPS]
    corners = (values[ends].swapaxes(1, 2).reshape(2 * rows, 2 * columns, 3) for values in (true, normals))
    falling = falling_diagonals(*corners)[::2, ::2, None, None]
    a, b = np.mgrid[: CELL_STEPS + 1, : CELL_STEPS + 1] / CELL_STEPS
    far = np.where(falling, np.maximum(a + b - 1.0, 0.0), np.minimum(a, b))
    weights = np.stack((1.0 - a - b + far, b - far, a - far, far), axis=-1)
    flat = weights.reshape(rows, columns, -1, 4) @ true[ends].reshape(rows, columns, 4, 3)
    return float(np.abs(np.einsum("...i,...i", flat.reshape(true.shape) - true, normals)).max())


def _inside_cells(stations: FloatArray) -> tuple[int, FloatArray]:
    """Return the number of cells that are measured along one direction, and all stations in them."""
    count = stations.size - 1
    # Largest number of cells along each direction in which the deviation is measured.
    cells = np.unique(np.linspace(0, count - 1, min(count, 12)).round().astype(np.int64))
    start, step = stations[cells, None], (stations[cells + 1] - stations[cells])[:, None]
    return cells.size, (start + step * (np.arange(CELL_STEPS + 1) / CELL_STEPS)).ravel()
