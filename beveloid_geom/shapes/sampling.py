"""Structured grids of a surface whose triangles stay within a tolerance of it.

A surface is given by a profile parameter p and the axial coordinate z, both explicit, so that
toe and heel rows are exactly planar and neighbouring surfaces can share their z stations. The
profile runs from a lower to an upper limit that may depend on z; s = 0 ... 1 numbers it.

Over a cell of the size (h_s, h_z) a flat triangle departs from a surface with the second
fundamental form (L, M, N) by at most

    |L h_s^2| / 8 and |N h_z^2| / 8 on the legs,  |L h_s^2 -/+ 2 M h_s h_z + N h_z^2| / 8 on the diagonal,

the upper sign for the diagonal along which s rises while z falls. Hence cells of about
sqrt(8 tolerance / L) by sqrt(8 tolerance / N), stations that share out the roots of L and N
evenly, and that diagonal which follows the surface: on an involute helicoid, which is
developable, the right one costs nothing and the wrong one four times the error. The number of
cells is the least for which this estimate, compared once with the distances measured inside
the triangles of a first grid, keeps the tolerance.

A flank is analytic in (s, z): a product of Chebyshev polynomials through a few hundred exact points
gives points and normals to rounding, and a grid of them is two matrix products. Where the
degree does not suffice, as near a fold of the tool's parabola, the exact formula serves for all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray, Indices, Mask
from ..design.model import Member
from ..gear.flank import generated, root_parameter, tip_parameter
from ..gear.rack import rack_normal, rack_of, rack_point
from ..gear.undercut import require_cut
from ..support.chebyshev import basis_of, polynomials
from ..support.few_lines import few_lines

Faces: TypeAlias = Indices
Place: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Points (mm) and unit normals (..., 3) of a surface at its profile parameter and z."""

MAX_POINTS = 20_000_000
DEGREES = (16, 32, 64)
"""Of a series along s and z, in the order in which they are tried."""
BETWEEN = np.sin(np.pi / 16.0 * (np.arange(-8, 8, 3) + 1.0 / 3.0))
"""Stations, -1 ... 1, at which a series is compared with the exact formula: for all of these degrees
they are a third of the way from node to node."""
ROUNDING = 5e-15
"""What it may depart there, relative to the radius and to 1 for the normals."""
PROBES = (9, 7)
"""Stations along s and z at which the second fundamental form is taken."""
MEASURED_CELLS = 12
"""Along each direction: the cells that are measured."""
LATTICE = 6
"""Steps along each side of a cell, to points at which it is measured."""
EVENNESS = (0.01, 0.5)
"""Shares of the greatest curvature added everywhere: the larger is for surfaces with a line of
inflection, where cells may not grow as its small curvature along one direction alone allows."""
ATTEMPTS = 12
WORST_ESTIMATE = 100.0
"""Ratio of measured to estimated deviation at which a surface counts as folded."""
COARSE = 40
"""Points below which one row less is a saving worth a try: the estimate is rough for large cells."""


@dataclass(frozen=True, eq=False)
class Series:
    """Chebyshev coefficients of a surface over s = 0 ... 1 and |z| <= half_width: `place` (2, m, n, 3)
    of points (mm) and normals, `upper` (n,) of the upper limit of the profile."""

    place: FloatArray
    upper: FloatArray


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface over lower(z) <= p <= upper(z) and |z| <= half_width (mm); `series`, if there is
    one, gives the same to rounding."""

    place: Place
    lower: Callable[[FloatArray], FloatArray]
    upper: Callable[[FloatArray], FloatArray]
    half_width: float
    series: Series | None = None


@dataclass(frozen=True, eq=False)
class SheetGrid:
    """A sampled surface: `points` (mm), unit `normals` (ns, nz, 3), profile parameter
    `parameter` (ns, nz), stations `z` (nz,), mm."""

    points: FloatArray
    normals: FloatArray
    parameter: FloatArray
    z: FloatArray


@dataclass(frozen=True, eq=False)
class FlankGrid:
    """A sampled flank in its own frame: `points` (mm) and unit `normals` out of the tooth
    (nl, nz, 3), root first; flank parameter `l` (nl, nz) and stations `z` (nz,), mm, toe
    first; `deviation`, the greatest distance (mm) measured between triangles and flank."""

    __repr__ = few_lines

    points: FloatArray
    normals: FloatArray
    l: FloatArray
    z: FloatArray
    deviation: float


@dataclass(frozen=True, eq=False)
class Form:
    """Second fundamental form of a surface by stretched coordinates (0 ... 1 along profile and
    face), as `shapes` (n, 3): deviations (mm) of one cell, factors of 1/ns^2, 1/(ns nz) and 1/nz^2.
    The stretching: s (`profile`) and z (`face`) at even steps."""

    shapes: FloatArray
    profile: FloatArray
    face: FloatArray


IN_TRIANGLE = np.array([(i, j) for i in range(5) for j in range(5 - i)]).T / 4.0
RATIOS = np.vander(np.geomspace(1.0 / 16.0, 16.0, 17), 3, increasing=True)


def flank_sheet(member: Member, flank: str, start: float | None = None) -> Sheet:
    """Give a flank of a single member as a surface over (l, z), own frame, from `start` (l, mm) or
    else from the start of its active profile to the tip cone.

    Raises ValueError if the tool cannot cut the flank or the flank does not reach its tip cone."""
    require_cut(member)
    rack = rack_of(member, flank)
    half = 0.5 * float(member.face_width)
    root = root_parameter(member) if start is None else np.asarray(start)

    def place(l: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        x0, y0, z0 = rack_point(rack, l)
        u = (z - z0) / rack.trace[2]
        return generated(rack, (x0 + u * rack.trace[0], y0 + u * rack.trace[1], z), rack_normal(rack, l))

    sheet = Sheet(place, lambda z: root + 0.0 * z, lambda z: tip_parameter(member, flank, z), half)
    series = series_of(sheet)
    if series is None and not np.all(np.isfinite(sheet.upper(half * BETWEEN))):
        raise ValueError(f"the {flank} flank does not reach its tip cone: reduce the addendum or the shift")
    return replace(sheet, series=series)


def series_of(sheet: Sheet) -> Series | None:
    """Find series through exact points of a surface, None if it departs from others by more than rounding."""
    s, z = 0.5 * (BETWEEN + 1.0), sheet.half_width * BETWEEN
    exact = grid_of(sheet, s, z)
    sizes = {"points": np.abs(exact.points).max(), "normals": 1.0, "parameter": np.abs(exact.points).max()}
    for degree in DEGREES:
        basis = basis_of(degree)
        grid = grid_of(sheet, 0.5 * (basis.nodes + 1.0), sheet.half_width * basis.nodes)
        values = np.stack((grid.points, grid.normals)).transpose(0, 3, 1, 2)
        corner = values[..., :1, :1]  # taken off, lest rounding is that of the radius
        place = (basis.fit.T @ (values - corner) @ basis.fit).transpose(0, 2, 3, 1).copy()
        place[:, 0, 0] += corner[..., 0, 0]
        series = Series(place, basis.coefficients(grid.parameter[-1]))
        found = grid_of(replace(sheet, series=series), s, z)
        apart = {name: np.abs(getattr(found, name) - getattr(exact, name)).max() for name in sizes}
        if all(apart[name] <= ROUNDING * size for name, size in sizes.items()):
            return series
    return None


def sample_flank(member: Member, flank: str, tolerance: float) -> FlankGrid:
    """Sample the active flank, from the start of its active profile to the tip cone and from toe to heel.

    Parameters
    ----------
    member : Member
        A single one.
    flank : {'right', 'left'}
    tolerance : float
        Greatest distance of the triangles of `grid_faces` from the flank, mm, along its normals. An undercut
        flank folds back at an edge, across which triangles may be about twice as far from its nearest point.

    Returns
    -------
    FlankGrid

    Raises
    ------
    ValueError
        If that is not possible, as of some undercut flanks.
    """
    sheet = flank_sheet(member, flank)
    form = form_of(sheet, tolerance)
    refusal = f"the {flank} flank cannot be sampled to {tolerance:g} mm: is it undercut?"
    scale = 1.0
    for attempt in range(ATTEMPTS):
        cells = cells_for(form, tolerance / scale)
        deviation = measured_deviation(sheet, form, *cells)
        ratio = deviation / estimated_deviation(form, *cells)
        if deviation <= tolerance and (attempt > 0 or ratio > 0.9):
            break
        scale = ratio if attempt == 0 else max(1.05 * scale, ratio)
        if scale > WORST_ESTIMATE:
            raise ValueError(refusal)
    else:
        raise ValueError(refusal)
    if (cells[0] + 1) * (cells[1] + 1) < COARSE:
        for fewer in ((cells[0] - 1, cells[1]), (cells[0], cells[1] - 1)):
            coarser = measured_deviation(sheet, form, *fewer) if min(fewer) else np.inf
            if coarser <= tolerance:
                cells, deviation = fewer, coarser
                break
    grid = grid_of(sheet, *stations(form, *cells, sheet.half_width))
    return FlankGrid(grid.points, grid.normals, grid.parameter, grid.z, deviation)


def form_of(sheet: Sheet, tolerance: float) -> Form:
    """Find the second fundamental form of a surface, stretched in the way that suits `tolerance` best."""
    s, z = np.linspace(0.0, 1.0, PROBES[0]), np.linspace(-1.0, 1.0, PROBES[1]) * sheet.half_width
    grid = grid_of(sheet, s, z)
    by_s, by_z = (
        np.gradient(np.stack((grid.points, grid.normals)), 1.0 / (count - 1), axis=axis, edge_order=2)
        for axis, count in ((1, PROBES[0]), (2, PROBES[1]))
    )
    L = -np.einsum("...i,...i", by_s[0], by_s[1])
    M = -np.einsum("...i,...i", by_s[0], by_z[1])
    N = -np.einsum("...i,...i", by_z[0], by_z[1])
    forms = [_stretched(L, M, N, evenness) for evenness in EVENNESS]
    return min(forms, key=lambda form: np.prod(np.add(cells_for(form, tolerance), 1)))


def _stretched(L: FloatArray, M: FloatArray, N: FloatArray, evenness: float) -> Form:
    (profile, stretch_s), (face, stretch_z) = _stretching(L, evenness), _stretching(N.T, evenness)
    stretched = L * stretch_s[:, None] ** 2, M * stretch_s[:, None] * stretch_z, N * stretch_z**2
    return Form(_shapes(*(part.reshape(-1, 1) for part in stretched)), profile, face)


def _stretching(curvature: FloatArray, evenness: float) -> tuple[FloatArray, FloatArray]:
    """Find stations that share out the root of the greatest curvature (n, others) evenly, at 129 even
    steps, and how far the first coordinate moves there for a step of the even one, (n,)."""
    greatest = np.abs(curvature).max(axis=1)
    density = np.sqrt(greatest + evenness * greatest.max() + 1e-24)
    even, fine = np.linspace(0.0, 1.0, density.size), np.linspace(0.0, 1.0, 129)
    dense = np.interp(fine, even, density)
    share = np.concatenate(([0.0], np.cumsum(0.5 * (dense[1:] + dense[:-1]))))
    share /= share[-1]
    return np.interp(fine, share, fine), dense.mean() / density


def stations(form: Form, ns: int, nz: int, half_width: float) -> tuple[FloatArray, FloatArray]:
    """Find stations s and z (mm) of a grid of ns x nz cells."""
    even = np.linspace(0.0, 1.0, form.profile.size)
    s = np.interp(np.linspace(0.0, 1.0, ns + 1), even, form.profile)
    return s, half_width * (2.0 * np.interp(np.linspace(0.0, 1.0, nz + 1), even, form.face) - 1.0)


def grid_of(sheet: Sheet, s: FloatArray, z: FloatArray) -> SheetGrid:
    """Give the surface at stations s (ns,) of its profile and z (nz,), mm."""
    lower, series = sheet.lower(z), sheet.series
    if series is None:
        parameter = lower + s[:, None] * (sheet.upper(z) - lower)
        points, normals = sheet.place(parameter, np.broadcast_to(z, parameter.shape))
        return SheetGrid(points, normals, parameter, z)
    _, m, n, _ = series.place.shape
    by_s, by_z = polynomials(2.0 * s - 1.0, m - 1), polynomials(z / sheet.half_width, n - 1)
    rows = by_z.T @ series.place
    rows[0, :, :, 2] = 0.0
    rows[0, 0, :, 2] = z  # planes z stay exactly plane
    points, normals = (by_s.T @ rows.reshape(2, m, -1)).reshape(2, s.size, z.size, 3)
    parameter = np.multiply.outer(s, series.upper @ by_z - lower)
    parameter += lower
    return SheetGrid(points, normals, parameter, z)


def _shapes(L: FloatArray, M: FloatArray, N: FloatArray) -> FloatArray:
    """Find the estimated deviations (n, 3) of one cell, for a second fundamental form (samples, 1), that may
    be the greatest. The diagonal suits L, M and N: for cells as chosen here all edges along
    s and z count about the same, so that the sign of M (L + N) decides."""
    balance = np.abs(L).max() / max(np.abs(N).max(), 1e-300)
    M = np.where(M * (L + balance * N) < 0.0, -M, M)
    s, z = IN_TRIANGLE
    parts = np.broadcast_arrays(0.5 * L * s * (1.0 - s), -M * s * z, 0.5 * N * z * (1.0 - z))
    shapes = np.stack([part.ravel() for part in parts])
    # Only those matter that are the greatest for some ratio of the cells' sides.
    sides = np.concatenate((RATIOS * np.clip(balance, 1e-6, 1e6) ** (0.0, 0.5, 1.0), np.eye(3)))
    return np.asarray(shapes.T[np.unique(np.abs(sides @ shapes).argmax(axis=1))])


def estimated_deviation(form: Form, ns: float, nz: float) -> float:
    """Find the distance (mm) that the second fundamental form foretells for ns x nz cells."""
    return float(np.abs(form.shapes @ (1.0 / ns**2, 1.0 / (ns * nz), 1.0 / nz**2)).max()) + 1e-300


def cells_for(form: Form, tolerance: float) -> tuple[int, int]:
    """Find the cheapest numbers of cells (ns, nz) that the estimate allows.

    Raises ValueError for a tolerance that is not positive or takes too many points."""
    if not 0.0 < tolerance < np.inf:
        raise ValueError(f"tolerance must be a positive length in mm, got {tolerance:g}")
    a, b, _ = np.concatenate((form.shapes, -form.shapes)).T
    bound = max(tolerance, 1e-50)  # below it is out of reach, and out of range when squared
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
    """Find the fewest columns (n,) with `rows` (n, 1) that the estimate by the `shapes` (m, 3) of a Form
    allows for a tolerance (mm): at each place the deviation is a quadratic in 1/columns, and where it first
    reaches the tolerance is the longest cell. Columns are very many where the rows alone miss it."""
    a, b, c = np.concatenate((shapes, -shapes)).T
    left, b = np.maximum(tolerance - a / rows**2, 1e-9 * tolerance), b / rows
    with np.errstate(invalid="ignore"):
        across = np.fmax.reduce((b + np.sqrt(b * b + 4.0 * c * left)) / (2.0 * left), axis=1)
    return np.asarray(np.maximum(np.ceil(across - 1e-9), 1.0))


def falling_diagonals(points: FloatArray, normals: FloatArray) -> Mask:
    """For each cell of a grid (ns, nz, 3): whether its diagonal runs from (i + 1, j) to
    (i, j + 1), the one that departs least from the surface; else from (i, j) to (i + 1, j + 1)."""
    corner, along, across = points[:-1, :-1], points[1:, :-1], points[:-1, 1:]
    far, middle = points[1:, 1:], normals[:-1, :-1] + normals[1:, 1:]
    mixed = np.einsum("...i,...i", far - along - across + corner, middle)
    bent = np.einsum("...i,...i", along - corner, normals[:-1, :-1] - normals[1:, :-1])
    bent = bent + np.einsum("...i,...i", across - corner, normals[:-1, :-1] - normals[:-1, 1:])
    return np.asarray(mixed * bent >= 0.0)


def grid_faces(points: FloatArray, normals: FloatArray) -> Faces:
    """Make triangles (m, 3) of a grid of points and normals (ns, nz, 3), as indices of its points in
    row-major order. They wind so that they face along the normals; each cell is cut along
    the diagonal that departs least from the surface."""
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
    """Find the greatest distance (mm) from the surface, along its normals, found at a lattice of points
    inside the triangles of its grid of ns x nz cells, in up to `MEASURED_CELLS` rows and
    columns of cells."""
    (rows, s), (columns, z) = (_inside_cells(values) for values in stations(form, ns, nz, sheet.half_width))
    grid, shape = grid_of(sheet, s, z), (rows, LATTICE + 1, columns, LATTICE + 1, 3)
    true, normals = (values.reshape(shape).swapaxes(1, 2) for values in (grid.points, grid.normals))
    ends = np.s_[:, :, ::LATTICE, ::LATTICE]
    corners = (values[ends].swapaxes(1, 2).reshape(2 * rows, 2 * columns, 3) for values in (true, normals))
    falling = falling_diagonals(*corners)[::2, ::2, None, None]
    a, b = np.mgrid[: LATTICE + 1, : LATTICE + 1] / LATTICE
    far = np.where(falling, np.maximum(a + b - 1.0, 0.0), np.minimum(a, b))
    weights = np.stack((1.0 - a - b + far, b - far, a - far, far), axis=-1)
    flat = weights.reshape(rows, columns, -1, 4) @ true[ends].reshape(rows, columns, 4, 3)
    return float(np.abs(np.einsum("...i,...i", flat.reshape(true.shape) - true, normals)).max())


def _inside_cells(stations: FloatArray) -> tuple[int, FloatArray]:
    """Number of the cells that are measured along one direction, and all stations inside them."""
    count = stations.size - 1
    cells = np.unique(np.linspace(0, count - 1, min(count, MEASURED_CELLS)).round().astype(np.int64))
    start, step = stations[cells, None], (stations[cells + 1] - stations[cells])[:, None]
    return cells.size, (start + step * (np.arange(LATTICE + 1) / LATTICE)).ravel()
