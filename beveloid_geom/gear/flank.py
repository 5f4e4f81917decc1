"""The generated flank (Eq. 6), its normal and tangents, and the limits of its active part.

While the rack slides by r_P phi the gear turns by phi; the rack point touches the gear when
its normal meets the pitch line. In the fixed frame of generation that point is

    Q = (r_P + x_c, (n_y / n_x) x_c, z_c),   phi = (y_c - (n_y / n_x) x_c) / r_P,

and turning it by phi about z gives the point in the gear's own frame S_j. For a fixed `l`
the normal is constant and Q runs along a straight line in `u`. Without parabola the flank
is an involute helicoid whose base radius and base helix angle differ between the right and
the left flank of a beveloid gear.

z is axial from mid-face, towards the heel (the thick end for a positive cone angle).

Limits. The paper gives none. Here: the tip cone runs `addendum` modules above the shifted
pitch cone, measured radially; the active profile starts where the tool's tip round meets its
flank, but not below the basic rack's working depth of `addendum` modules; toe and heel are
planes half a face width from mid-face.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, Mask
from ..design.model import Member
from .rack import Rack, parameter_at_height, rack_normal, rack_of, rack_point, rack_tangent, reference_radius

ROUND_SNAP = 1e-4
"""Modules. The customary tip radius 0.38 is the rounded value of 0.37995, so that the round
meets the flank 0.00003 modules above the working depth; closer than this it counts as there."""


@dataclass(frozen=True, eq=False)
class BaseCylinder:
    """Base radius (mm) and base helix angle (rad, the sign of the normal's z component) of
    one unmodified flank; `radius cos(helix_angle)` is `m_n N cos(alpha) / 2` for all flanks."""

    radius: FloatArray
    helix_angle: FloatArray


@dataclass(frozen=True, eq=False)
class FlankPatch:
    """Points, unit normals and tangents of a flank in its own frame, each (..., 3), mm.

    `normal` leaves the tooth. `tangent_l` and `tangent_u` are derivatives by the flank
    parameters. `regularity` is positive on a sound flank, vanishes on an edge of undercut
    and changes sign beyond it."""

    point: FloatArray
    normal: FloatArray
    tangent_l: FloatArray
    tangent_u: FloatArray
    regularity: FloatArray


def base_cylinder(member: Member, flank: str) -> BaseCylinder:
    """Find the base radius and base helix angle of the flank cut without parabola."""
    rack = rack_of(member, flank)
    nx, ny, nz = rack.normal
    radius = rack.pitch_radius * np.abs(ny) / np.hypot(nx, ny)
    return BaseCylinder(np.asarray(radius), np.asarray(np.arcsin(nz)))


def _turn(cos: FloatArray, sin: FloatArray, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    return np.stack(np.broadcast_arrays(cos * x - sin * y, sin * x + cos * y, z), axis=-1)


def turned(phi: FloatArray | float, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Turn vectors given by their components about z by `phi` (rad): (..., 3)."""
    return _turn(np.cos(phi), np.sin(phi), x, y, z)


def trace_parameter(member: Member, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Find `u` (mm) of the flank point with parameter `l` in the plane `z` (mm from mid-face)."""
    rack = rack_of(member, flank)
    z0 = rack_point(rack, np.asarray(l, dtype=float))[2]
    return np.asarray((z - z0) / rack.trace[2])


def flank_point(member: Member, flank: str, l: ArrayLike, u: ArrayLike) -> FloatArray:
    """Find points (..., 3) of a flank in its own frame S_j, mm (Eq. 6)."""
    rack = rack_of(member, flank)
    x, y, z, phi = _generated(rack, np.asarray(l, dtype=float), np.asarray(u, dtype=float))
    return turned(phi, x, y, z)


def _generated(
    rack: Rack, l: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Find Q and the generating roll angle phi of Eq. 6."""
    x0, y0, z0 = rack_point(rack, l)
    tx, ty, tz = rack.trace
    return _envelope(rack, (x0 + u * tx, y0 + u * ty, z0 + u * tz), rack_normal(rack, l))


def _envelope(
    rack: Rack, point: Sequence[FloatArray] | FloatArray, normal: Sequence[FloatArray] | FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Find Q and phi of Eq. 6 for points of the sliding rack with their unit normals, by components."""
    x_c, y_c, z_c = point
    along = normal[1] / normal[0] * x_c
    phi = (y_c - along) / rack.pitch_radius  # Eq. (6), last line
    return rack.pitch_radius + x_c, along, z_c, phi


def generated(
    rack: Rack, point: Sequence[FloatArray] | FloatArray, normal: Sequence[FloatArray] | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find points (mm) and unit normals (..., 3), own frame, which the `rack` cuts (Eq. 6) with any of
    its surface points; these and their unit normals by components in S_c, as `rack_point` has them."""
    x, y, z, phi = _envelope(rack, point, normal)
    cos, sin = np.cos(phi), np.sin(phi)
    return _turn(cos, sin, x, y, z), _turn(cos, sin, *normal)


def flank_patch(member: Member, flank: str, l: ArrayLike, u: ArrayLike) -> FlankPatch:
    """Find points, unit normals and tangents (..., 3) of a flank in its own frame S_j.

    The tangents are analytic: with Q(l, u) and phi(l, u) of Eq. 6, a derivative of the turned
    point is the turned (Q' + phi' k x Q)."""
    rack = rack_of(member, flank)
    l, u = np.broadcast_arrays(np.asarray(l, dtype=float), np.asarray(u, dtype=float))
    x, y, z, phi = _generated(rack, l, u)
    nx, ny, nz = rack_normal(rack, l)
    tx, ty, tz = rack.trace
    dx, dy, dz = rack_tangent(rack, l)
    slope, slope_l = _pitch_slope(rack, l, (nx, ny, nz), (dx, dy, dz))
    x_c = x - rack.pitch_radius
    along_l, along_u = slope_l * x_c + slope * dx, slope * tx
    phi_l = (dy - along_l) / rack.pitch_radius
    phi_u = (ty - along_u) / rack.pitch_radius
    cos, sin = np.cos(phi), np.sin(phi)
    normal = _turn(cos, sin, nx, ny, nz)
    tangent_l = _turn(cos, sin, dx - phi_l * y, along_l + phi_l * x, dz)
    tangent_u = _turn(cos, sin, tx - phi_u * y, along_u + phi_u * x, tz)
    return FlankPatch(
        point=_turn(cos, sin, x, y, z),
        normal=normal,
        tangent_l=tangent_l,
        tangent_u=tangent_u,
        regularity=rack.sigma * np.einsum("...i,...i", normal, np.cross(tangent_u, tangent_l)),
    )


def _pitch_slope(
    rack: Rack,
    l: FloatArray,
    normal: Sequence[FloatArray] | FloatArray,
    tangent: Sequence[FloatArray] | FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """n_y / n_x of the rack at `l` and its derivative by `l`."""
    # The normal turns back along the tangent d: n' = -2 a d / |d|^3, and |d|^2 = 1 + 4 a^2 l^2.
    turn = -2.0 * rack.parabola / (1.0 + (2.0 * rack.parabola * l) ** 2) ** 1.5
    slope = normal[1] / normal[0]
    return slope, turn * (tangent[1] - slope * tangent[0]) / normal[0]


def tip_radius(member: Member, z: ArrayLike) -> FloatArray:
    """Find the radius of the tip cone in the plane `z` (mm from mid-face), mm."""
    tool = member.tool
    height = (member.profile_shift + tool.addendum) * tool.normal_module
    return np.asarray(reference_radius(member) + height + np.asarray(z) * np.tan(member.cone_angle))


def root_parameter(member: Member) -> FloatArray:
    """Find the flank parameter `l` (mm, negative) at which the active profile starts; NaN where the tool
    cannot cut the active flank (see `active_range`)."""
    return active_range(member)[0]


def highest_parameter(member: Member) -> FloatArray:
    """Find the bound of `l` (mm) on the whole active flank: nowhere on the tip cone does a point stand
    higher in the tilted rack than cos(gamma) addenda. NaN as in `root_parameter`."""
    return active_range(member)[1]


def active_range(member: Member) -> tuple[FloatArray, FloatArray]:
    """Find the lowest and highest flank parameter `l` (mm) of the active flanks.

    NaN, both, where the tool cannot cut all of the flank between: where the profile of the rack
    folds, or its generating normal has no radial component out of the tooth on one of the flanks.
    Eq. 6 gives a surface beyond such a place too, but none that the tool leaves."""
    tool = member.tool
    joint = tool.dedendum - tool.tip_radius * (1.0 - np.sin(tool.normal_pressure_angle))
    start = np.where(joint > tool.addendum - ROUND_SNAP, tool.addendum, joint)
    with np.errstate(invalid="ignore", over="ignore"):
        low = parameter_at_height(tool, -start * tool.normal_module)
        high = parameter_at_height(tool, tool.addendum * tool.normal_module * np.cos(member.cone_angle))
        cut = _leans_outwards(member, low) & _leans_outwards(member, high)  # linear in l between
    return np.where(cut, low, np.nan), np.where(cut, high, np.nan)


def _leans_outwards(member: Member, l: FloatArray) -> Mask:
    """Tell whether the rack's normals on both flanks lean out of the tooth at `l`, before the fold:
    tan(alpha - tau) > sin|beta| tan|gamma| with tan(tau) = 2 a l."""
    tool, bend = member.tool, 2.0 * member.tool.parabola * l
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    across = np.abs(np.sin(member.helix_angle) * np.tan(member.cone_angle))
    return np.asarray(sin - bend * cos > (cos + bend * sin) * across)


def tip_parameter(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Find the flank parameter `l` (mm) at which the flank reaches the tip cone in the plane `z`.

    Newton from above with the exact slope of the radius along the line of constant z, kept
    between the start of the active profile and its highest point by halving; NaN where the flank
    does not get there. It is the only such point unless the flank is undercut."""
    z = np.asarray(z, dtype=float)
    rack, target = rack_of(member, flank), tip_radius(member, z)
    lean = rack.trace[0] / rack.trace[2]
    low, high = root_parameter(member) + 0.0 * z, highest_parameter(member) + 0.0 * z
    l = high
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(60):
            # Of Eq. 6 the radius takes only x and y of Q; the roll angle has no part in it.
            (x0, _, z0), tangent = rack_point(rack, l), rack_tangent(rack, l)
            slope, slope_l = _pitch_slope(rack, l, rack_normal(rack, l), tangent)
            x_c, x_l = x0 + (z - z0) * lean, tangent[0] - tangent[2] * lean
            x, y = rack.pitch_radius + x_c, slope * x_c
            radius = np.hypot(x, y)
            missing = target - radius
            low, high = np.where(missing > 0.0, l, low), np.where(missing > 0.0, high, l)
            moved = l + missing * radius / (x * x_l + y * (slope_l * x_c + slope * x_l))
            moved = np.where((moved >= low) & (moved <= high), moved, 0.5 * (low + high))
            step, l = np.abs(moved - l), moved
            if not np.any(step > 1e-13 * target):
                break
    return np.where((step <= 1e-9 * target) & (np.abs(missing) <= 1e-9 * target), l, np.nan)


def place_at(
    member: Member, flank: str, depth: ArrayLike, face: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find l, z and u (mm) at shares of the active depth from the root and of the face from the toe, which
    broadcast, of a single member. Raises ValueError where the flank does not reach its tip cone."""
    root, z = root_parameter(member), float(member.face_width) * (np.asarray(face, dtype=float) - 0.5)
    tip = tip_parameter(member, flank, z)
    if not np.isfinite(tip).all():
        raise ValueError(f"the {flank} flank does not reach its tip cone: reduce the addendum or the shift")
    l = root + np.asarray(depth, dtype=float) * (tip - root)
    z = np.broadcast_to(z, l.shape)
    return l, z, trace_parameter(member, flank, l, z)


def half_thickness_angle(member: Member, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Find the angle (rad) from the tooth's own middle to the flank point (l, z), measured around the
    axis away from the metal: positive while there is tooth between the two flanks.

    The middle is where the rack's section at mid-face has y_n = 0; with a helix it turns
    along the face, equally for both flanks, so only the sum of both flanks' angles at equal
    radius and z is a tooth thickness."""
    rack, u = rack_of(member, flank), trace_parameter(member, flank, l, z)
    x, y, _, phi = _generated(rack, np.asarray(l, dtype=float), u)
    return np.asarray(rack.sigma * (phi + np.arctan2(y, x)))  # whole turns of a long helix kept


def tip_thickness(member: Member, z: ArrayLike) -> FloatArray:
    """Find the transverse thickness (mm, along the circle) of the tooth at the tip cone in the plane
    `z`; negative where the tooth is pointed below its tip cone."""
    angle = sum(
        half_thickness_angle(member, flank, tip_parameter(member, flank, z), z) for flank in ("right", "left")
    )
    return np.asarray(angle * tip_radius(member, z))


def undercut_margin(member: Member, flank: str, points: int = 9) -> FloatArray:
    """Find the least regularity of the active flank, relative to its largest: not positive where the
    active flank is undercut. Taken over the rim of the active flank, where it is least for
    flanks that are sound inside."""
    half = 0.5 * np.asarray(member.face_width, dtype=float)
    half, low, _ = np.broadcast_arrays(half, root_parameter(member), tip_radius(member, 0.0))
    z = np.multiply.outer(np.linspace(-1.0, 1.0, points), half)
    high = tip_parameter(member, flank, z)
    l = np.stack((low + 0.0 * z, 0.5 * (low + high), high))
    regularity = flank_patch(member, flank, l, trace_parameter(member, flank, l, z)).regularity
    return np.asarray(regularity.min(axis=(0, 1)) / np.abs(regularity).max(axis=(0, 1)))
