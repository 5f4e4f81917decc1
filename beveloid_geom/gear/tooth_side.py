"""The side of a tooth, flank and fillet, and its points at a given radius.

The points are those of `tooth_surface`, over the profile coordinate s and the axial coordinate z. s
follows from r^2 in closed form (without parabola) or by Newton's method. On an undercut tooth the flank
ends where it intersects the fillet (`crossing`), and the radius of the intersection decides on which of
the two a point lies. Searches that step across this edge state on which side they are, so that their
surface is smooth. `surface_of` is the flank with its fillet, `flank_surface` the flank continued without it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, Mask
from ..design.member import Member
from ..support.frozen_arrays import cached
from .crossing import crossing_of, fillet_profile
from .crossing_curve import END as END, RADIUS as RADIUS, START as START, CrossingCurve
from .fillet import fillet_point, tool_round
from .flank import is_batch as is_batch, modification_of, turned
from .flank_limits import active_range, highest_parameter, may_fold, tip_radius
from .generation import Bends as Bends, Cut as Cut, angle_of as angle_of, tangents_of as tangents_of
from .rack import rack_of
from .tooth_surface import (
    ToothSurface as ToothSurface,
    cut_at as cut_at,
    cut_with_bends as cut_with_bends,
    cut_with_normal_rate as cut_with_normal_rate,
    generated_bends as generated_bends,
    generated_cut as generated_cut,
    turn_rows as turn_rows,
)


@cached(64)
def flank_surface(member: Member, flank: str) -> ToothSurface:
    """Return the `flank` ('right' or 'left') of a single member without its fillet: the surface continues
    below the joint with the fillet, and beyond an edge of undercut."""
    rack = rack_of(member, flank)
    trace, d, m = rack.trace[:2] / rack.trace[2], rack.direction, rack.normal
    return ToothSurface(
        sigma=rack.sigma,
        parabola=float(rack.parabola),
        pitch_radius=float(rack.pitch_radius),
        apex=rack.apex[:2] - rack.apex[2] * trace,
        along=d[:2] - d[2] * trace,
        out=m[:2] - m[2] * trace,
        trace=trace,
        direction=d,
        normal=m,
        twist=float(d[0] * m[1] - d[1] * m[0]),
        highest=float(highest_parameter(member, flank)),
        tip=float(tip_radius(member, 0.0)),
        taper=float(np.tan(member.cone_angle)),
        half_width=0.5 * float(member.face_width),
        modification=modification_of(member, flank),
    )


def _surface(member: Member, flank: str) -> ToothSurface:
    # Modules: least length of the profile coordinate for one rad of the fillet.
    least_fillet_scale_modules = 0.1
    without_fillet, rounding = flank_surface(member, flank), tool_round(member.tool, flank)
    a, joint, radius = without_fillet.parabola, rounding.joint, rounding.radius
    turn = float(np.arctan(2.0 * a * joint))
    scale = max(radius, least_fillet_scale_modules * float(member.tool.normal_module))
    surface = replace(
        without_fillet,
        joint=joint,
        bottom=joint - scale * (0.5 * np.pi - rounding.angle),
        turn=turn,
        centre=(joint - radius * np.sin(turn), a * joint**2 + radius * np.cos(turn)),
        radius=radius,
        scale=scale,
        modification=None,
    )
    low = surface.bottom
    s = np.append(low + (joint - low) * np.linspace(0.02, 1.0, 25), np.linspace(joint, surface.highest, 25))
    z = surface.half_width * np.linspace(-1.0, 1.0, 9)[:, None]
    rises = bool((cut_at(surface, s, z).square_s > 0.0).all())
    root = cut_at(surface, np.array([low, low]), np.array([0.0, 1.0])).x
    surface = replace(surface, root=float(root[0]), root_taper=float(root[1] - root[0]))
    if not rises and not np.isnan(surface.highest):
        crossing, lost = crossing_of(surface)
        surface = replace(surface, crossing=crossing, lost=lost)
    return replace(surface, modification=without_fillet.modification)


_cached_surface = cached(64)(_surface)


def surface_of(member: Member, flank: str) -> ToothSurface:
    """Return the `flank` ('right' or 'left') of a single member with its fillet as one surface.

    Raises
    ------
    ValueError
        For a member of arrays, and as in `fillet.tool_round`.
    """
    if is_batch(member):
        raise ValueError("members must have single numbers: only pair and errors may contain arrays")
    return _cached_surface(member, flank)


def side_points(surface: ToothSurface, s: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (mm) and outward unit normals (..., 3) of a surface, in the gear frame, at profile
    coordinates `s` in the planes `z`, mm."""
    s, z = np.broadcast_arrays(s, z)
    cut = cut_at(surface, s.ravel(), z.ravel())
    x, y, height = (np.array(rows) for rows in ((cut.x, cut.nx), (cut.y, cut.ny), (z.ravel(), cut.nz)))
    points, normals = turned(cut.phi, x, y, height).reshape(2, *s.shape, 3)
    return points, normals


def fillet_points(
    member: Member, flank: str, angle: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the result of `fillet.fillet_point`, on a modified flank with its rotation."""
    if member.modification(flank) is None:
        return fillet_point(member, flank, angle, z)
    surface = surface_of(member, flank)
    return side_points(
        surface, surface.joint - surface.scale * (angle - tool_round(member.tool, flank).angle), z
    )


def profile_at(
    surface: ToothSurface, square: FloatArray, z: FloatArray, fillet: Mask | None = None
) -> FloatArray:
    """Return the profile coordinate s (mm) of the points with r^2 = `square` (mm^2) in the planes `z`.

    Parameters
    ----------
    surface : ToothSurface
    square, z : ndarray, shape (n,)
        The caller silences NumPy's warnings.
    fillet : ndarray of bool, shape (n,), optional
        For undercut teeth: whether the point is searched on the fillet or on the flank, both of which are
        continued slightly beyond their intersection. If omitted, on the one that is part of the tooth.

    Returns
    -------
    ndarray, shape (n,)
        NaN where the surface has no such point.
    """
    # Fraction of the flank lost to undercut by which the flank is continued below its intersection with
    # the fillet.
    flank_continuation = 0.3
    if surface.crossing is None:
        s = _flank_profile(surface, square, z, surface.joint)
        above = s >= surface.joint
        if not above.all():
            low = np.flatnonzero(~above & ~np.isnan(square + z))
            s[low] = fillet_profile(surface, square[low], z[low], np.full(low.size, surface.joint))
        return s
    curve, undercut = surface.crossing.rows(z), surface.crossing.undercut(z)
    start = np.where(undercut, curve[START, 0], surface.joint)
    s = _flank_profile(surface, square, z, start - flank_continuation * (start - surface.joint))
    if fillet is None:
        below = np.where(undercut, square < curve[RADIUS, 0] ** 2, ~(s >= surface.joint))
    else:  # in sound planes the flank continues as fillet
        below = np.where(undercut, fillet, ~(s >= surface.joint))
    low = np.flatnonzero(below & ~np.isnan(square + z))
    s[np.flatnonzero(~below & undercut & ~(s >= surface.joint))] = np.nan
    if low.size:
        top = np.where(undercut, np.maximum(curve[END, 0], surface.joint), surface.joint)
        s[low] = fillet_profile(surface, square[low], z[low], top[low])
    return s


def _flank_profile(
    surface: ToothSurface, square: FloatArray, z: FloatArray, least: FloatArray | float
) -> FloatArray:
    """Return s on the flank; with a parabola, above `least` (mm)."""
    s = _straight_profile(surface, square, z)
    return s if surface.parabola == 0.0 else _bent_profile(surface, s, square, z, least)


def _straight_profile(
    surface: ToothSurface, square: FloatArray, z: FloatArray, near: FloatArray | float = 0.0
) -> FloatArray:
    """Return s on the flank without parabola, where r^2 is quadratic in x_c. NaN below the base cylinder.

    With a parabola, an approximation: the normal and the chord of the rack from its apex are those at the
    profile coordinate `near`, mm."""
    (dx, dy), (mx, my) = surface.direction[:2], surface.normal[:2]
    a, r = surface.parabola, surface.pitch_radius
    turn = 2.0 * a * near
    slope = (my - turn * dy) / (mx - turn * dx)
    spread = 1.0 + slope * slope
    excess = square - r * r
    # Root above the base cylinder, without cancellation near the pitch cylinder.
    x_c = excess / (r + np.sqrt(r * r + spread * excess))
    along = surface.along[0] + a * near * surface.out[0]
    return np.asarray((x_c - surface.apex[0] - z * surface.trace[0]) / along)


def _bent_profile(
    surface: ToothSurface, s: FloatArray, square: FloatArray, z: FloatArray, low: FloatArray | float
) -> FloatArray:
    """Return s by Newton's method from `s` on the straight flank; NaN where it is below `low` (mm)."""
    newton_max_steps = 14
    # Newton step, relative to the pitch radius, below which the iteration ends: the error is its square
    # over a radius.
    last_step_radii = 1e-9
    high = 2.0 * surface.highest - surface.joint  # infinite without a fillet
    last = last_step_radii * surface.pitch_radius
    s = _straight_profile(surface, square, z, s)
    s = np.where(np.isnan(s), low, np.minimum(np.maximum(s, low), high))
    a, bend = surface.parabola, 2.0 * surface.parabola
    (dx, dy), (mx, my), r = surface.direction[:2], surface.normal[:2], surface.pitch_radius
    start = surface.apex[0] + z * surface.trace[0]
    for _ in range(newton_max_steps):
        turn = bend * s
        nx, ny = mx - turn * dx, my - turn * dy  # not of unit length: only their ratio is used
        # r^2 of the point of Eq. 6 and its derivative by s.
        slope = ny / nx
        x_c = start + s * (surface.along[0] + a * s * surface.out[0])
        x_s = surface.along[0] + turn * surface.out[0]
        y = slope * x_c
        y_s = bend * surface.twist / (nx * nx) * x_c + slope * x_s
        x = r + x_c
        step = 0.5 * (x * x + y * y - square) / (x * x_s + y * y_s)
        following = s - step
        s = np.minimum(np.maximum(following, low), high)
        if not (np.abs(step) > last)[s == following].any():
            break
    return np.where((np.abs(step) <= last) & (following >= low), following, np.nan)


@cached(64)
def undercut_edge(member: Member, flank: str) -> CrossingCurve | None:
    """Return the curve on which undercut ends a flank of a single member.

    None for a sound flank, for a flank that undercut removes completely in a part of the face, and for a tool
    whose rounds overlap.
    """
    if not may_fold(member, rack_of(member, flank), *active_range(member, flank)):
        return None
    try:
        return surface_of(member, flank).crossing
    except ValueError:  # the rounds of the tool overlap
        return None
