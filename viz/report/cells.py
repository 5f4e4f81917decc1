"""Cells of a matrix of patterns as SVG: side view of the pinion flank with pattern and ellipse."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from beveloid_geom.analysis.pattern_matrix import PatternCell, PatternMatrix
from beveloid_geom.arrays import FloatArray

from ..components.flattened_flank import BAND_FRACTIONS, boundary_of
from .picture import polygon


def cell_pictures(matrix: PatternMatrix) -> list[str]:
    """Return each cell as an SVG element of class `cell`, '' without a pattern. To scale; the end at -z is
    left, the tip is above. All cells show the same region, which contains the flank and the ellipses."""
    # Coordinates are rounded to whole units.
    units_per_module = 240.0
    # Margin around the flank in modules.
    margin_modules = 0.13
    module = float(matrix.design.pinion.tool.normal_module)
    margin, scale = margin_modules * module, units_per_module / module
    known = [cell for cell in matrix.cells if cell]
    if not known:
        return [""] * len(matrix.cells)
    corners = np.concatenate([_corners(cell) for cell in known])
    low, high = np.nanmin(corners, axis=0) - margin, np.nanmax(corners, axis=0) + margin
    axes = Figure().add_subplot()
    return [
        _picture(axes, cell, matrix.separation, low, high, scale) if cell else "" for cell in matrix.cells
    ]


def size_decimals(module: float) -> int:
    """Return the decimals of the lengths in mm below a cell: a tenth of the module is always resolved."""
    return max(1, 1 - math.floor(math.log10(module)))


def _corners(cell: PatternCell) -> FloatArray:
    """Return points (n, 2) in z and r, mm, whose bounding box contains flank and ellipse of a cell."""
    side, one = cell.pattern.pinion, cell.ellipses[0]
    flank = np.stack((side.z, np.hypot(side.points[..., 0], side.points[..., 1])), axis=-1).reshape(-1, 2)
    along, across = np.cos(one.angle), np.sin(one.angle)
    half = np.hypot((one.major * along, one.major * across), (one.minor * across, one.minor * along))
    middle = np.array((one.z, one.r))
    return np.concatenate((flank, (middle - half, middle + half)))


def _picture(
    axes: Axes, cell: PatternCell, separation: float, low: FloatArray, high: FloatArray, scale: float
) -> str:
    """Return the SVG element of a cell that shows the region between two corners (z, r), mm, with `scale` in
    units per mm."""
    # Radius of the dot in the middle of the ellipse, units.
    dot = 20
    side, one = cell.pattern.pinion, cell.ellipses[0]
    z, r = side.z, np.hypot(side.points[..., 0], side.points[..., 1])
    corner = float(low[0]), float(high[1])
    width, height = np.round(scale * (high - low)).astype(int).tolist()
    pieces = [f'<path class="rim" d="{polygon(boundary_of(z, r), corner, scale)}"/>']
    for lines in _areas(axes, z, r, side.least, separation):
        shape = "".join(polygon(line, corner, scale) for line in lines)
        pieces.append(f'<path class="area" d="{shape}"/>')
    if np.isfinite(one.z):
        x, y = scale * (one.z - corner[0]), scale * (corner[1] - one.r)
        turn = -float(np.degrees(np.nan_to_num(one.angle)))
        size = f'rx="{scale * one.major:.0f}" ry="{scale * one.minor:.0f}"'
        place = f'transform="translate({x:.0f} {y:.0f}) rotate({turn:.2f})"'
        pieces.append(f'<ellipse {size} {place}/><circle r="{dot}" {place}/>')
    body = "".join(pieces)
    return f'<svg class="cell" viewBox="0 0 {width} {height}" aria-hidden="true">{body}</svg>'


def _areas(
    axes: Axes, z: FloatArray, r: FloatArray, least: FloatArray, separation: float
) -> Iterator[list[FloatArray]]:
    """Return the outlines (n, 2), mm, of the areas with separations below each of BAND_FRACTIONS, largest
    area first."""
    root = np.ma.masked_invalid(np.sqrt(np.maximum(least, 0.0)))
    for share in BAND_FRACTIONS[::-1]:
        (area,) = axes.contourf(z, r, root, [-1.0, float(np.sqrt(share * separation))]).get_paths()
        yield [np.asarray(line) for line in area.to_polygons(closed_only=False)]
