"""Cells of a matrix of patterns as SVG: side view of the pinion flank with pattern and ellipse."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from beveloid_geom.analysis.pattern_matrix import PatternCell, PatternMatrix
from beveloid_geom.arrays import FloatArray

from ..components.flattened_flank import BANDS
from .picture import polygon

UNITS = 40.0
"""Units of a picture per mm; coordinates are rounded to whole units."""
MARGIN = 0.8
"""Margin around the flank, mm."""


def cell_pictures(matrix: PatternMatrix) -> list[str]:
    """Return each cell as an SVG element of class `cell`, '' without a pattern. To scale; the end at -z is
    left, the tip is above."""
    axes = Figure().add_subplot()
    return [_picture(axes, cell, matrix.separation) if cell else "" for cell in matrix.cells]


def _picture(axes: Axes, cell: PatternCell, separation: float) -> str:
    side, one = cell.pattern.pinion, cell.ellipses[0]
    z, r = side.z, np.hypot(side.points[..., 0], side.points[..., 1])
    corner = float(z.min()) - MARGIN, float(r.max()) + MARGIN
    width, height = np.round(UNITS * (np.array((np.ptp(z), np.ptp(r))) + 2.0 * MARGIN)).astype(int).tolist()
    rim = [np.concatenate((g[:, 0], g[-1], g[::-1, -1], g[0, ::-1])) for g in (z, r)]
    pieces = [f'<path class="rim" d="{polygon(np.stack(rim, axis=-1), corner, UNITS)}"/>']
    for lines in _areas(axes, z, r, side.least, separation):
        shape = "".join(polygon(line, corner, UNITS) for line in lines)
        pieces.append(f'<path class="area" d="{shape}"/>')
    if np.isfinite(one.z):
        x, y = UNITS * (one.z - corner[0]), UNITS * (corner[1] - one.r)
        turn = -float(np.degrees(np.nan_to_num(one.angle)))
        size = f'rx="{UNITS * one.major:.0f}" ry="{UNITS * one.minor:.0f}"'
        place = f'transform="translate({x:.0f} {y:.0f}) rotate({turn:.2f})"'
        pieces.append(f'<ellipse {size} {place}/><circle r="{0.5 * UNITS:.0f}" {place}/>')
    body = "".join(pieces)
    return f'<svg class="cell" viewBox="0 0 {width} {height}" aria-hidden="true">{body}</svg>'


def _areas(
    axes: Axes, z: FloatArray, r: FloatArray, least: FloatArray, separation: float
) -> Iterator[list[FloatArray]]:
    """Return the outlines (n, 2), mm, of the areas with separations below each of BANDS, largest area
    first."""
    root = np.ma.masked_invalid(np.sqrt(np.maximum(least, 0.0)))
    for share in BANDS[::-1]:
        (area,) = axes.contourf(z, r, root, [-1.0, float(np.sqrt(share * separation))]).get_paths()
        yield [np.asarray(line) for line in area.to_polygons(closed_only=False)]
