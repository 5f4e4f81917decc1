"""Flanks as grids of points and normals whose triangles stay within a tolerance.

`sheet` has surfaces and grids on them, `grid_cells` the number and the stations of the cells.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..design.arguments import require_member, require_numbers
from ..design.member import Member
from ..gear.active_flank import active_start_by_z
from ..gear.flank_limits import tip_parameter
from ..gear.tooth_side import flank_surface, side_points, surface_of
from ..gear.undercut import CURE, require_cut, undercut_margin
from ..support.array_repr import short_repr
from . import MODULE_PER_TOLERANCE
from .grid_cells import cells_for, estimated_deviation, form_of, measured_deviation, stations
from .sheet import CHECK_STATIONS, Sheet, grid_of, series_of


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


def flank_sheet(member: Member, flank: str, to_fillet: bool = False) -> Sheet:
    """Return a flank of a single member as a surface over (l, z) up to the tip cone, in the frame of the
    gear.

    It begins at the start of the active profile, or exactly at the end of the fillet if `to_fillet`. With a
    parabola the start may be slightly below the end of the fillet: the flank is continued there. Raises
    ValueError if the tool cannot cut the flank, or if the flank does not reach its tip cone."""
    require_cut(member)
    half, surface = 0.5 * float(member.face_width), flank_surface(member, flank)
    start = surface_of(member, flank).flank_start if to_fillet else active_start_by_z(member, flank)
    sheet = Sheet(
        lambda l, z: side_points(surface, l, z), start, lambda z: tip_parameter(member, flank, z), half
    )
    series = series_of(sheet)
    checked = half * np.concatenate((CHECK_STATIONS, (-1.0, 1.0)))
    if series is None and not np.all(np.isfinite(sheet.upper(checked))):
        raise ValueError(
            f"the {flank} flank does not reach its tip cone: reduce the addendum or profile shift"
        )
    return replace(sheet, series=series)


def default_tolerance(member: Member) -> float:
    """Return the default tolerance of surfaces, mm: the normal module / MODULE_PER_TOLERANCE."""
    return float(member.tool.normal_module) / MODULE_PER_TOLERANCE


def sample_flank(member: Member, flank: str, tolerance: float | None = None) -> FlankGrid:
    """Return a grid on a flank, from the start of its active profile to the tip cone and from toe to heel.

    Parameters
    ----------
    member : Member
        A single member.
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

    References
    ----------
    Points: Eq. (6) of Ni et al. 2017; spacing: beveloid_geom/shapes/README.md.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, sample_flank
    >>> grid = sample_flank(builtin_design().pinion, "right", tolerance=0.01)
    >>> grid.points.shape, grid.deviation < 0.01
    ((8, 6, 3), True)
    """
    require_member(member)
    require_numbers(tolerance=tolerance)
    # Largest number of grids that are tried.
    max_attempts = 12
    # Largest ratio of measured and estimated deviation. With a larger one the flank may be folded and cannot
    # be sampled.
    max_estimate_ratio = 100.0
    # Smaller grids are tried with one row less, because the estimate is rough for large cells.
    small_grid_points = 40
    tolerance = default_tolerance(member) if tolerance is None else tolerance
    sheet = flank_sheet(member, flank)
    form = form_of(sheet, tolerance)
    scale = 1.0
    for attempt in range(max_attempts):
        cells = cells_for(form, tolerance / scale)
        deviation = measured_deviation(sheet, form, *cells)
        ratio = deviation / estimated_deviation(form, *cells)
        if deviation <= tolerance and (attempt > 0 or ratio > 0.9):
            break
        scale = ratio if attempt == 0 else max(1.05 * scale, ratio)
        if scale > max_estimate_ratio:
            raise ValueError(_refusal(member, flank, tolerance))
    else:
        raise ValueError(_refusal(member, flank, tolerance))
    if (cells[0] + 1) * (cells[1] + 1) < small_grid_points:
        for fewer in ((cells[0] - 1, cells[1]), (cells[0], cells[1] - 1)):
            coarser = measured_deviation(sheet, form, *fewer) if min(fewer) else np.inf
            if coarser <= tolerance:
                cells, deviation = fewer, coarser
                break
    grid = grid_of(sheet, *stations(form, *cells, sheet.half_width))
    return FlankGrid(grid.points, grid.normals, grid.parameter, grid.z, deviation)


def _refusal(member: Member, flank: str, tolerance: float) -> str:
    """Return the reason why a flank cannot be sampled to a tolerance, mm."""
    if float(undercut_margin(member, flank)) <= 0.0:
        return f"the {flank} flank is undercut: {CURE}"
    return f"the {flank} flank cannot be sampled to {tolerance:g} mm: increase the tolerance"
