"""Surfaces over a profile parameter and the axial coordinate, and structured grids on them.

A surface is given by a profile parameter p and the axial coordinate z. Both are explicit, so that the rows
at toe and heel are exactly plane, and neighbouring surfaces can share their stations in z. The profile runs
from a lower to an upper limit, which may depend on z; s = 0 ... 1 is the relative position between them.

Surfaces cut by a tool are analytic in (s, z). A product of Chebyshev polynomials through a few hundred exact
points gives points and normals to rounding, and a grid of them takes two matrix products. If the degree does
not suffice, for example near a fold of the parabola of the tool, the exact formula is used for all points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray, Indices, Mask
from ..support.chebyshev import basis_of, polynomials

Faces: TypeAlias = Indices
Place: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of profile parameter and z that returns points (mm) and unit normals (..., 3) of a surface."""
CHECK_STATIONS = np.sin(np.pi / 16.0 * (np.arange(-8, 8, 3) + 1.0 / 3.0))
"""Stations -1 ... 1 at which a series is compared with the exact formula. For all degrees they are between
nodes, at one third of their distance."""


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


def series_of(sheet: Sheet) -> Series | None:
    """Return a series through exact points of a surface, or None if it deviates from others by more than
    rounding."""
    # Degrees of a series along s and z, in the order in which they are tried.
    series_degrees = (16, 32, 64)
    # Largest deviation at these stations, relative to the radius for points, and absolute for normals.
    series_tolerance = 5e-15
    for degree in series_degrees:
        basis = basis_of(degree)
        # One grid for both sets of stations, because the upper limit takes most of the time.
        nodes, check = slice(degree + 1), slice(degree + 1, None)
        stations = np.append(basis.nodes, CHECK_STATIONS)
        s, z = 0.5 * (stations + 1.0), sheet.half_width * stations
        grid = grid_of(sheet, s, z)
        values = np.stack((grid.points, grid.normals))[:, nodes, nodes].transpose(0, 3, 1, 2)
        corner = values[..., :1, :1]  # subtracted so that rounding is relative to the size of the flank
        place = (basis.fit.T @ (values - corner) @ basis.fit).transpose(0, 2, 3, 1).copy()
        place[:, 0, 0] += corner[..., 0, 0]
        series = Series(place, basis.coefficients(grid.parameter[degree, nodes]))
        trial = grid_of(replace(sheet, series=series), s[check], z[check])
        size = np.abs(grid.points[check, check]).max()
        sizes = {"points": size, "normals": 1.0, "parameter": size}
        deviation = {
            name: np.abs(getattr(trial, name) - getattr(grid, name)[check, check]).max() for name in sizes
        }
        if all(deviation[name] <= series_tolerance * sizes[name] for name in sizes):
            return series
    return None


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
