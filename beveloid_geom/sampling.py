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
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from .flank import generated, root_parameter, tip_parameter
from .inputs import FloatArray, Member
from .rack import rack_normal, rack_of, rack_point

Faces: TypeAlias = NDArray[np.int64]
Place: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Points (mm) and unit normals (..., 3) of a surface at its profile parameter and z."""

MAX_POINTS = 20_000_000
PROBES = (9, 7)
"""Stations along s and z at which the second fundamental form is taken."""
MEASURED_CELLS = 12
"""Along each direction: the cells that are measured."""
EVENNESS = (0.01, 0.5)
"""Shares of the greatest curvature added everywhere: the larger is for surfaces with a line of
inflection, where cells may not grow as its small curvature along one direction alone allows."""
ATTEMPTS = 12
WORST_ESTIMATE = 100.0
"""Ratio of measured to estimated deviation at which a surface counts as folded."""
COARSE = 40
"""Points below which one row less is a saving worth a try: the estimate is rough for large cells."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface over lower(z) <= p <= upper(z) and |z| <= half_width (mm)."""

    place: Place
    lower: Callable[[FloatArray], FloatArray]
    upper: Callable[[FloatArray], FloatArray]
    half_width: float


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

    points: FloatArray
    normals: FloatArray
    l: FloatArray
    z: FloatArray
    deviation: float


@dataclass(frozen=True, eq=False)
class Form:
    """Second fundamental form (L, M, N) of a surface by stretched coordinates (0 ... 1 along
    profile and face), each (samples,), mm, and the stretching: s and z at even steps."""

    coefficients: FloatArray
    profile: FloatArray
    face: FloatArray


def _inside_triangle(order: int) -> FloatArray:
    """Barycentric points (n, 3) evenly over a triangle, without its corners."""
    i, j = (index.ravel() for index in np.mgrid[: order + 1, : order + 1])
    weights = np.stack((order - i - j, i, j), axis=-1)[i + j <= order]
    return np.asarray(weights[weights.max(axis=1) < order] / order)


INSIDE = _inside_triangle(6)


def flank_sheet(member: Member, flank: str, start: float | None = None) -> Sheet:
    """A flank of a single member as a surface over (l, z), own frame, from `start` (l, mm) or
    else from the start of its active profile to the tip cone.

    Raises ValueError if the flank does not reach its tip cone."""
    rack = rack_of(member, flank)
    half = 0.5 * float(member.face_width)
    root = root_parameter(member) if start is None else np.asarray(start)
    if not np.all(np.isfinite(tip_parameter(member, flank, np.linspace(-half, half, 5)))):
        raise ValueError(f"the {flank} flank does not reach its tip cone: reduce the addendum or the shift")

    def place(l: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        x0, y0, z0 = rack_point(rack, l)
        u = (z - z0) / rack.trace[2]
        return generated(rack, (x0 + u * rack.trace[0], y0 + u * rack.trace[1], z), rack_normal(rack, l))

    return Sheet(place, lambda z: root + 0.0 * z, lambda z: tip_parameter(member, flank, z), half)


def sample_flank(member: Member, flank: str, tolerance: float) -> FlankGrid:
    """The active flank of a single member, from the start of its active profile to the tip
    cone and from toe to heel, sampled so that the triangles of `grid_faces` stay within
    `tolerance` (mm) of it. Raises ValueError if that is not possible.

    Distances are taken along the normals. An undercut flank folds back at an edge, across which
    triangles may be about twice as far from the nearest point of it."""
    sheet = flank_sheet(member, flank)
    form = form_of(sheet, tolerance)
    refusal = f"the {flank} flank cannot be sampled to {tolerance:g} mm: is it undercut?"
    scale = 1.0
    for attempt in range(ATTEMPTS):
        cells = cells_for(form, tolerance / scale)
        grid, deviation = _measured(sheet, form, cells)
        ratio = deviation / estimated_deviation(form, *cells)
        if deviation <= tolerance and (attempt > 0 or ratio > 0.9):
            break
        scale = ratio if attempt == 0 else max(1.05 * scale, ratio)
        if scale > WORST_ESTIMATE:
            raise ValueError(refusal)
    else:
        raise ValueError(refusal)
    if grid.parameter.size < COARSE:
        for fewer in ((cells[0] - 1, cells[1]), (cells[0], cells[1] - 1)):
            coarser = _measured(sheet, form, fewer) if min(fewer) else (grid, np.inf)
            if coarser[1] <= tolerance:
                grid, deviation = coarser
                break
    return FlankGrid(grid.points, grid.normals, grid.parameter, grid.z, deviation)


def _measured(sheet: Sheet, form: Form, cells: tuple[int, int]) -> tuple[SheetGrid, float]:
    grid = grid_of(sheet, *stations(form, *cells, sheet.half_width))
    return grid, measured_deviation(sheet, grid)


def form_of(sheet: Sheet, tolerance: float) -> Form:
    """Second fundamental form of a surface, stretched in the way that suits `tolerance` best."""
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
    return Form(np.stack([part.ravel() for part in stretched]), profile, face)


def _stretching(curvature: FloatArray, evenness: float) -> tuple[FloatArray, FloatArray]:
    """Stations that share out the root of the greatest curvature (n, others) evenly, at 129 even
    steps, and how far the first coordinate moves there for a step of the even one, (n,)."""
    greatest = np.abs(curvature).max(axis=1)
    density = np.sqrt(greatest + evenness * greatest.max() + 1e-24)
    even, fine = np.linspace(0.0, 1.0, density.size), np.linspace(0.0, 1.0, 129)
    dense = np.interp(fine, even, density)
    share = np.concatenate(([0.0], np.cumsum(0.5 * (dense[1:] + dense[:-1]))))
    share /= share[-1]
    return np.interp(fine, share, fine), dense.mean() / density


def stations(form: Form, ns: int, nz: int, half_width: float) -> tuple[FloatArray, FloatArray]:
    """Stations s and z (mm) of a grid of ns x nz cells."""
    even = np.linspace(0.0, 1.0, form.profile.size)
    s = np.interp(np.linspace(0.0, 1.0, ns + 1), even, form.profile)
    return s, half_width * (2.0 * np.interp(np.linspace(0.0, 1.0, nz + 1), even, form.face) - 1.0)


def grid_of(sheet: Sheet, s: FloatArray, z: FloatArray) -> SheetGrid:
    """The surface at stations s (ns,) of its profile and z (nz,), mm."""
    lower, upper = sheet.lower(z), sheet.upper(z)
    parameter = lower + s[:, None] * (upper - lower)
    points, normals = sheet.place(parameter, np.broadcast_to(z, parameter.shape))
    return SheetGrid(points, normals, parameter, z)


def _shapes(form: Form) -> FloatArray:
    """Estimated deviations (n, 3) of one cell: factors of 1/ns^2, 1/(ns nz) and 1/nz^2."""
    L, M, N = form.coefficients[:, None]
    s, z = INSIDE[:, 1:2], INSIDE[:, 2:]
    parts = np.broadcast_arrays(0.5 * L * s * (1.0 - s), -M * s * z, 0.5 * N * z * (1.0 - z))
    return np.stack([part.ravel() for part in parts], axis=-1)


def _turned_shapes(form: Form) -> FloatArray:
    """The same with the diagonal that suits L, M and N: for cells as chosen here all
    edges along s and z count about the same, so that the sign of M (L + N) decides."""
    L, M, N = form.coefficients
    balance = np.abs(L).max() / max(np.abs(N).max(), 1e-300)
    sign = np.where(M * (L + balance * N) < 0.0, -1.0, 1.0)
    return _shapes(Form(np.stack((L, sign * M, N)), form.profile, form.face))


def estimated_deviation(form: Form, ns: int, nz: int) -> float:
    """Distance (mm) that the second fundamental form foretells for ns x nz cells."""
    return float(np.abs(_turned_shapes(form) @ (1.0 / ns**2, 1.0 / (ns * nz), 1.0 / nz**2)).max()) + 1e-300


def cells_for(form: Form, tolerance: float) -> tuple[int, int]:
    """The cheapest numbers of cells (ns, nz) that the estimate allows.

    For every ns the deviation at each place is a quadratic in 1/nz; the least of the roots
    where one reaches the tolerance is the longest cell. Raises ValueError for a tolerance that
    is not positive or takes too many points."""
    if not 0.0 < tolerance < np.inf:
        raise ValueError(f"tolerance must be a positive length in mm, got {tolerance:g}")
    a, b, c = _turned_shapes(form).T
    least = max(1, int(np.ceil(np.sqrt(np.abs(a).max() / tolerance) - 1e-9)))
    most = 4 * least + int(2.0 * np.sqrt(np.abs(b).max() / tolerance)) + 2
    counts = np.unique(np.round(np.geomspace(least, most, 60)))[:, None]
    step = np.full(counts.shape[0], 1.0)
    for bound in (tolerance, -tolerance):
        step = np.minimum(step, _first_root(a / counts**2 - bound, b / counts, c).min(axis=1))
    across = np.ceil(1.0 / step - 1e-9)
    points = (counts[:, 0] + 1.0) * (across + 1.0)
    best = int(np.argmin(points))
    if points[best] > MAX_POINTS:
        count = f"{points[best]:.2g} points, the limit is {MAX_POINTS:.2g}"
        raise ValueError(f"tolerance {tolerance:g} mm is too fine: it takes {count}")
    return int(counts[best, 0]), int(across[best])


def _first_root(constant: FloatArray, slope: FloatArray, square: FloatArray) -> FloatArray:
    """Least positive root of constant + slope x + square x^2, infinity where there is none."""
    with np.errstate(all="ignore"):
        root = np.sqrt(slope * slope - 4.0 * square * constant)
        half = -0.5 * (slope + np.copysign(root, slope))
        roots = np.stack((half / square, constant / half))
    return np.asarray(np.where(roots > 0.0, roots, np.inf).min(axis=0))


def falling_diagonals(points: FloatArray, normals: FloatArray) -> NDArray[np.bool_]:
    """For each cell of a grid (ns, nz, 3): whether its diagonal runs from (i + 1, j) to
    (i, j + 1), the one that departs least from the surface; else from (i, j) to (i + 1, j + 1)."""
    corner, along, across = points[:-1, :-1], points[1:, :-1], points[:-1, 1:]
    far, middle = points[1:, 1:], normals[:-1, :-1] + normals[1:, 1:]
    mixed = np.einsum("...i,...i", far - along - across + corner, middle)
    bent = np.einsum("...i,...i", along - corner, normals[:-1, :-1] - normals[1:, :-1])
    bent = bent + np.einsum("...i,...i", across - corner, normals[:-1, :-1] - normals[:-1, 1:])
    return np.asarray(mixed * bent >= 0.0)


def _triangles(points: FloatArray, normals: FloatArray) -> Faces:
    """Triangles (ns, nz, 2, 3) of a grid's cells as indices of its points, s to z turning left."""
    ns, nz = points.shape[:2]
    index = np.arange(ns * nz).reshape(ns, nz)
    corner, along, across, far = index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]
    falling = np.stack((corner, along, across, far, across, along), axis=-1)
    rising = np.stack((along, far, corner, across, corner, far), axis=-1)
    chosen = np.where(falling_diagonals(points, normals)[..., None], falling, rising)
    return chosen.reshape(ns - 1, nz - 1, 2, 3)


def grid_faces(points: FloatArray, normals: FloatArray) -> Faces:
    """Triangles (m, 3) of a grid of points and normals (ns, nz, 3), as indices of its points in
    row-major order. They wind so that they face along the normals; each cell is cut along
    the diagonal that departs least from the surface."""
    faces = _triangles(points, normals).reshape(-1, 3)
    a, b, c = points.reshape(-1, 3)[faces.T]
    facing = np.einsum("ni,ni->", np.cross(b - a, c - a), normals.reshape(-1, 3)[faces[:, 0]])
    return faces if facing >= 0.0 else faces[:, ::-1]


def measured_deviation(sheet: Sheet, grid: SheetGrid) -> float:
    """Greatest distance (mm) from the surface found at many points inside the grid's triangles,
    in up to `MEASURED_CELLS` rows and columns of cells."""
    triangles = _triangles(grid.points, grid.normals)
    rows, columns = (_spread(count) for count in triangles.shape[:2])
    corners = triangles[np.ix_(rows, columns)].reshape(-1, 3)
    z = np.broadcast_to(grid.z, grid.parameter.shape)
    p, z = (INSIDE @ values.reshape(-1)[corners].T for values in (grid.parameter, z))
    flat = np.einsum("kc,mci->kmi", INSIDE, grid.points.reshape(-1, 3)[corners])
    points, normals = sheet.place(p, z)
    return float(np.abs(np.einsum("...i,...i", flat - points, normals)).max())


def _spread(count: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, count - 1, min(count, MEASURED_CELLS)).round().astype(np.int64))
