"""Structured grids on a surface whose triangles stay within a tolerance.

A surface is given by a profile parameter p and the axial coordinate z. Both are explicit, so that the rows
at toe and heel are exactly plane, and neighbouring surfaces can share their stations in z. The profile runs
from a lower to an upper limit, which may depend on z; s = 0 ... 1 is the relative position between them.

1. Over a cell of the size (h_s, h_z), a flat triangle deviates from a surface with the second fundamental
   form (L, M, N) by at most

       |L h_s^2| / 8 and |N h_z^2| / 8 on the legs,  |L h_s^2 -/+ 2 M h_s h_z + N h_z^2| / 8 on the diagonal,

   with the upper sign for the diagonal along which s increases while z decreases. Cells are therefore about
   sqrt(8 tolerance / L) by sqrt(8 tolerance / N).
2. Stations distribute the square roots of L and N evenly.
3. The diagonal is the one that follows the surface. On an involute helicoid, which is developable, the
   correct diagonal adds no deviation, and the wrong one makes it four times as large.
4. The number of cells is the smallest one for which the estimate keeps the tolerance. The estimate is scaled
   by the ratio of measured and estimated deviations of a first grid.

A flank is analytic in (s, z). A product of Chebyshev polynomials through a few hundred exact points gives
points and normals to rounding, and a grid of them takes two matrix products. If the degree does not suffice,
for example near a fold of the parabola of the tool, the exact formula is used for all points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray, Indices, Mask
from ..design.arguments import require_member
from ..design.member import Member
from ..gear.active_flank import active_start
from ..gear.flank import generated, tip_parameter
from ..gear.rack import rack_normal, rack_of, rack_point
from ..gear.tooth_side import side_points, surface_of
from ..gear.undercut import require_cut
from ..support.array_repr import short_repr
from ..support.chebyshev import basis_of, polynomials
from . import SURFACE_STEPS

Faces: TypeAlias = Indices
Place: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of profile parameter and z that returns points (mm) and unit normals (..., 3) of a surface."""

MAX_POINTS = 20_000_000
CHECK_STATIONS = np.sin(np.pi / 16.0 * (np.arange(-8, 8, 3) + 1.0 / 3.0))
"""Stations -1 ... 1 at which a series is compared with the exact formula. For all degrees they are between
nodes, at one third of their distance."""
MEASURED_CELLS = 12
"""Largest number of cells along each direction in which the deviation is measured."""
CELL_STEPS = 6
"""Number of steps along each side of a cell, to points at which the deviation is measured."""


@dataclass(frozen=True, eq=False)
class Series:
    """Chebyshev coefficients of a surface over s = 0 ... 1 and |z| <= half_width: `place` (2, m, n, 3) of
    points (mm) and normals, and `upper` (n,) of the upper limit of the profile."""

    place: FloatArray
    upper: FloatArray


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface over lower(z) <= p <= upper(z) and |z| <= half_width (mm). Its `series`, if there is one, is
    equal to it within rounding."""

    place: Place
    lower: Callable[[FloatArray], FloatArray]
    upper: Callable[[FloatArray], FloatArray]
    half_width: float
    series: Series | None = None


@dataclass(frozen=True, eq=False)
class SheetGrid:
    """A grid on a surface: `points` (mm) and unit `normals` (ns, nz, 3), profile `parameter` (ns, nz), and
    stations `z` (nz,), mm."""

    points: FloatArray
    normals: FloatArray
    parameter: FloatArray
    z: FloatArray


@dataclass(frozen=True, eq=False)
class FlankGrid:
    """A grid on a flank, in the frame of the gear.

    Attributes
    ----------
    points, normals : array (nl, nz, 3)
        Points, mm, and outward unit normals, from the root to the tip and from -z to +z.
    l : array (nl, nz)
        Flank parameter, mm.
    z : array (nz,)
        Stations along the face, mm.
    deviation : float
        Largest measured distance between triangles and flank, mm.
    """

    __repr__ = short_repr

    points: FloatArray
    normals: FloatArray
    l: FloatArray
    z: FloatArray
    deviation: float


@dataclass(frozen=True, eq=False)
class Form:
    """Second fundamental form of a surface in stretched coordinates (0 ... 1 along profile and face).

    `shapes` (n, 3): factors (mm) of 1/ns^2, 1/(ns nz) and 1/nz^2 in deviations of one cell. `profile` and
    `face`: s and relative z at even steps of the stretched coordinates."""

    shapes: FloatArray
    profile: FloatArray
    face: FloatArray


RATIOS = np.vander(np.geomspace(1.0 / 16.0, 16.0, 17), 3, increasing=True)


def flank_sheet(member: Member, flank: str, to_fillet: bool = False) -> Sheet:
    """Return a flank of a single member as a surface over (l, z) up to the tip cone, in the frame of the
    gear.

    It begins at the start of the active profile, or exactly at the end of the fillet if `to_fillet`. Raises
    ValueError if the tool cannot cut the flank, or if the flank does not reach its tip cone."""
    require_cut(member)
    rack = rack_of(member, flank)
    half = 0.5 * float(member.face_width)
    start = surface_of(member, flank).flank_start if to_fillet else partial(active_start, member, flank)

    def place(l: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and unit normals of the flank."""
        if member.modification(flank) is not None:
            return side_points(surface_of(member, flank), l, z)
        x0, y0, z0 = rack_point(rack, l)
        u = (z - z0) / rack.trace[2]
        return generated(rack, (x0 + u * rack.trace[0], y0 + u * rack.trace[1], z), rack_normal(rack, l))

    sheet = Sheet(place, start, lambda z: tip_parameter(member, flank, z), half)
    series = series_of(sheet)
    if series is None and not np.all(np.isfinite(sheet.upper(half * CHECK_STATIONS))):
        raise ValueError(f"the {flank} flank does not reach its tip cone: reduce the addendum or the shift")
    return replace(sheet, series=series)


def series_of(sheet: Sheet) -> Series | None:
    """Return a series through exact points of a surface, or None if it deviates from others by more than
    rounding."""
    # Degrees of a series along s and z, in the order in which they are tried.
    series_degrees = (16, 32, 64)
    # Largest deviation at these stations, relative to the radius for points, and absolute for normals.
    series_tolerance = 5e-15
    s, z = 0.5 * (CHECK_STATIONS + 1.0), sheet.half_width * CHECK_STATIONS
    exact = grid_of(sheet, s, z)
    sizes = {"points": np.abs(exact.points).max(), "normals": 1.0, "parameter": np.abs(exact.points).max()}
    for degree in series_degrees:
        basis = basis_of(degree)
        grid = grid_of(sheet, 0.5 * (basis.nodes + 1.0), sheet.half_width * basis.nodes)
        values = np.stack((grid.points, grid.normals)).transpose(0, 3, 1, 2)
        corner = values[..., :1, :1]  # subtracted so that rounding is relative to the size of the flank
        place = (basis.fit.T @ (values - corner) @ basis.fit).transpose(0, 2, 3, 1).copy()
        place[:, 0, 0] += corner[..., 0, 0]
        series = Series(place, basis.coefficients(grid.parameter[-1]))
        trial = grid_of(replace(sheet, series=series), s, z)
        deviation = {name: np.abs(getattr(trial, name) - getattr(exact, name)).max() for name in sizes}
        if all(deviation[name] <= series_tolerance * size for name, size in sizes.items()):
            return series
    return None


def default_tolerance(member: Member) -> float:
    """Return the default tolerance of surfaces, mm: the normal module / SURFACE_STEPS."""
    return float(member.tool.normal_module) / SURFACE_STEPS


def sample_flank(member: Member, flank: str, tolerance: float | None = None) -> FlankGrid:
    """Return a grid on a flank, from the start of its active profile to the tip cone and from toe to heel.

    Parameters
    ----------
    member : Member
        A single one.
    flank : {'right', 'left'}
    tolerance : float, optional
        Largest distance of the triangles of `grid_faces` from the flank along its normals, mm. By default
        1/600 of the normal module, as for the command `mesh`.

    Returns
    -------
    FlankGrid

    Raises
    ------
    ValueError
        If the tolerance cannot be met, for example because undercut removes the flank at one end.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, sample_flank
    >>> grid = sample_flank(builtin_design().pinion, "right", tolerance=0.01)
    >>> grid.points.shape, grid.deviation < 0.01
    ((8, 6, 3), True)
    """
    require_member(member)
    # Largest number of grids that are tried.
    max_attempts = 12
    # Ratio of measured and estimated deviation from which on a surface is called folded.
    max_estimate_ratio = 100.0
    # Smaller grids are tried with one row less, because the estimate is rough for large cells.
    small_grid_points = 40
    tolerance = default_tolerance(member) if tolerance is None else tolerance
    sheet = flank_sheet(member, flank)
    form = form_of(sheet, tolerance)
    refusal = f"the {flank} flank cannot be sampled to {tolerance:g} mm: is it undercut?"
    scale = 1.0
    for attempt in range(max_attempts):
        cells = cells_for(form, tolerance / scale)
        deviation = measured_deviation(sheet, form, *cells)
        ratio = deviation / estimated_deviation(form, *cells)
        if deviation <= tolerance and (attempt > 0 or ratio > 0.9):
            break
        scale = ratio if attempt == 0 else max(1.05 * scale, ratio)
        if scale > max_estimate_ratio:
            raise ValueError(refusal)
    else:
        raise ValueError(refusal)
    if (cells[0] + 1) * (cells[1] + 1) < small_grid_points:
        for fewer in ((cells[0] - 1, cells[1]), (cells[0], cells[1] - 1)):
            coarser = measured_deviation(sheet, form, *fewer) if min(fewer) else np.inf
            if coarser <= tolerance:
                cells, deviation = fewer, coarser
                break
    grid = grid_of(sheet, *stations(form, *cells, sheet.half_width))
    return FlankGrid(grid.points, grid.normals, grid.parameter, grid.z, deviation)


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
    return Form(_shapes(*(part.reshape(-1, 1) for part in stretched)), profile, face)


def _stretching(curvature: FloatArray, evenness: float) -> tuple[FloatArray, FloatArray]:
    """Return 129 stations that distribute the square root of the largest curvature (n, others) evenly, and
    the derivative (n,) of the first coordinate by the even one at the given points."""
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


def grid_of(sheet: Sheet, s: FloatArray, z: FloatArray) -> SheetGrid:
    """Return the surface at stations s (ns,) of its profile and z (nz,), mm."""
    lower, series = sheet.lower(z), sheet.series
    if series is None:
        parameter = lower + s[:, None] * (sheet.upper(z) - lower)
        points, normals = sheet.place(parameter, np.broadcast_to(z, parameter.shape))
        return SheetGrid(points, normals, parameter, z)
    _, m, n, _ = series.place.shape
    by_s, by_z = polynomials(2.0 * s - 1.0, m - 1), polynomials(z / sheet.half_width, n - 1)
    rows = by_z.T @ series.place
    rows[0, :, :, 2] = 0.0
    rows[0, 0, :, 2] = z  # planes z are exactly plane
    points, normals = (by_s.T @ rows.reshape(2, m, -1)).reshape(2, s.size, z.size, 3)
    parameter = np.multiply.outer(s, series.upper @ by_z - lower)
    parameter += lower
    return SheetGrid(points, normals, parameter, z)


def _shapes(L: FloatArray, M: FloatArray, N: FloatArray) -> FloatArray:
    """Return the estimated deviations (n, 3) of one cell that may be the largest, for a second fundamental
    form (samples, 1).

    The diagonal is the one that follows the surface. In cells of the sizes chosen here, edges along s and z
    deviate by similar amounts, so that the sign of M (L + N) decides."""
    balance = np.abs(L).max() / max(np.abs(N).max(), 1e-300)
    M = np.where(M * (L + balance * N) < 0.0, -M, M)
    in_triangle = np.array([(i, j) for i in range(5) for j in range(5 - i)]).T / 4.0
    s, z = in_triangle
    parts = np.broadcast_arrays(0.5 * L * s * (1.0 - s), -M * s * z, 0.5 * N * z * (1.0 - z))
    shapes = np.stack([part.ravel() for part in parts])
    # Only deviations that are the largest for some ratio of the sides matter.
    sides = np.concatenate((RATIOS * np.clip(balance, 1e-6, 1e6) ** (0.0, 0.5, 1.0), np.eye(3)))
    return np.asarray(shapes.T[np.unique(np.abs(sides @ shapes).argmax(axis=1))])


def estimated_deviation(form: Form, ns: float, nz: float) -> float:
    """Return the deviation (mm) of ns x nz cells that the second fundamental form predicts."""
    return float(np.abs(form.shapes @ (1.0 / ns**2, 1.0 / (ns * nz), 1.0 / nz**2)).max()) + 1e-300


def cells_for(form: Form, tolerance: float) -> tuple[int, int]:
    """Return the numbers of cells (ns, nz) with the fewest points that keep a tolerance by the estimate.
    Raises ValueError for a tolerance that is not positive or needs too many points."""
    if not 0.0 < tolerance < np.inf:
        raise ValueError(f"tolerance must be a positive length in mm, got {tolerance:g}")
    a, b, _ = np.concatenate((form.shapes, -form.shapes)).T
    bound = max(tolerance, 1e-50)  # smaller ones cannot be met, and their squares underflow
    least = max(1.0, np.ceil(np.sqrt(a.max() / bound) - 1e-9))
    most = 4.0 * least + np.floor(2.0 * np.sqrt(b.max() / bound)) + 2.0
    counts = np.unique(np.round(np.geomspace(least, most, 60))).astype(float)[:, None]
    across = columns_for(form.shapes, counts, bound)
    points = (counts[:, 0] + 1.0) * (across + 1.0)
    best = int(np.argmin(points))
    if points[best] > MAX_POINTS:
        count = f"{points[best]:.2g} points, the limit is {MAX_POINTS:.2g}"
        raise ValueError(f"tolerance {tolerance:g} mm is too fine: it takes {count}")
    return int(counts[best, 0]), int(across[best])


def columns_for(shapes: FloatArray, rows: FloatArray, tolerance: float) -> FloatArray:
    """Return the smallest numbers of columns (n,) for `rows` (n, 1) that keep a tolerance (mm) by the
    estimate of the `shapes` (m, 3) of a Form.

    Each deviation is a quadratic in 1/columns. The longest cell is that at which it first reaches the
    tolerance. If the rows alone exceed the tolerance, the number of columns is very large."""
    a, b, c = np.concatenate((shapes, -shapes)).T
    left, b = np.maximum(tolerance - a / rows**2, 1e-9 * tolerance), b / rows
    with np.errstate(invalid="ignore"):
        across = np.fmax.reduce((b + np.sqrt(b * b + 4.0 * c * left)) / (2.0 * left), axis=1)
    return np.asarray(np.maximum(np.ceil(across - 1e-9), 1.0))


def falling_diagonals(points: FloatArray, normals: FloatArray) -> Mask:
    """Return for each cell of a grid (ns, nz, 3) whether the diagonal that deviates least from the surface
    runs from (i + 1, j) to (i, j + 1), and not from (i, j) to (i + 1, j + 1)."""
    corner, along, across = points[:-1, :-1], points[1:, :-1], points[:-1, 1:]
    far, middle = points[1:, 1:], normals[:-1, :-1] + normals[1:, 1:]
    mixed = np.einsum("...i,...i", far - along - across + corner, middle)
    bent = np.einsum("...i,...i", along - corner, normals[:-1, :-1] - normals[1:, :-1])
    bent = bent + np.einsum("...i,...i", across - corner, normals[:-1, :-1] - normals[:-1, 1:])
    return np.asarray(mixed * bent >= 0.0)


def grid_faces(points: FloatArray, normals: FloatArray) -> Faces:
    """Return triangles (m, 3) of a grid of points and normals (ns, nz, 3), as indices of its points in
    row-major order. They face along the normals. Each cell is divided along the diagonal that deviates least
    from the surface."""
    ns, nz = points.shape[:2]
    index = np.arange(ns * nz).reshape(ns, nz)
    corner, along, across, far = index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]
    falling = np.stack((corner, along, across, far, across, along), axis=-1)
    rising = np.stack((along, far, corner, across, corner, far), axis=-1)
    faces = np.where(falling_diagonals(points, normals)[..., None], falling, rising).reshape(-1, 3)
    a, b, c = points.reshape(-1, 3)[faces.T]
    facing = np.einsum("ni,ni->", np.cross(b - a, c - a), normals.reshape(-1, 3)[faces[:, 0]])
    return faces if facing >= 0.0 else faces[:, ::-1]


def measured_deviation(sheet: Sheet, form: Form, ns: int, nz: int) -> float:
    """Return the largest distance (mm), along the normals of a surface, from the triangles of its grid of ns
    x nz cells. It is measured at a lattice of points in up to MEASURED_CELLS rows and columns of cells."""
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
    cells = np.unique(np.linspace(0, count - 1, min(count, MEASURED_CELLS)).round().astype(np.int64))
    start, step = stations[cells, None], (stations[cells + 1] - stations[cells])[:, None]
    return cells.size, (start + step * (np.arange(CELL_STEPS + 1) / CELL_STEPS)).ravel()
