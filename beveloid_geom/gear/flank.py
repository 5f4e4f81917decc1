"""The generated flank (Eq. 6), its normal and tangents, and the limits of its active part.

While the rack slides by r_P phi, the gear rotates by phi. A rack point touches the gear when its
normal meets the pitch line. In the fixed frame of generation this point is

    Q = (r_P + x_c, (n_y / n_x) x_c, z_c),   phi = (y_c - (n_y / n_x) x_c) / r_P,

and its rotation by phi about z gives the flank point in the gear frame S_j. For a fixed `l` the
normal is constant and Q moves along a straight line in `u`. Without a parabola the flank is an
involute helicoid. Its base radius and base helix angle differ between the right and the left
flank of a beveloid gear.

z is the axial coordinate from mid-face; the tooth is larger at +z if the cone angle is positive.

Limits: the paper gives none. Here the tip cone is `addendum + tip_alteration` modules above the
shifted pitch cone, measured radially. The active profile starts at the fillet, where the tip round
of the tool meets its flank; on an undercut member it starts where flank and fillet intersect
(`crossing`). Toe and heel are the planes half a face width from mid-face.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, Mask, flank_sign
from ..design.member import Member
from ..support.frozen_arrays import kept
from .generation import Cut, angle_of, cut_of_rack, rolled, rotated_cut
from .modification import FlankExtent, FlankModification, flank_modification
from .rack import (
    Rack,
    parameter_at_height,
    rack_at,
    rack_normal,
    rack_of,
    rack_point,
    reference_radius,
    turn_rate,
)


@dataclass(frozen=True, eq=False)
class BaseCylinder:
    """Base radius (mm) and base helix angle (rad) of one unmodified flank.

    The helix angle has the sign of the z component of the normal. `radius cos(helix_angle)` equals
    `m_n N cos(alpha) / 2` on all flanks.
    """

    radius: FloatArray
    helix_angle: FloatArray


@dataclass(frozen=True, eq=False)
class FlankPatch:
    """Points, unit normals and tangents of a flank in its gear frame, each (..., 3), mm.

    `normal` points out of the tooth. `tangent_l` and `tangent_u` are the derivatives by the flank
    parameters. `regularity` is positive on a sound flank, vanishes on the edge of regression and is negative
    on the part that folds back. It is not affected by a modification.
    """

    point: FloatArray
    normal: FloatArray
    tangent_l: FloatArray
    tangent_u: FloatArray
    regularity: FloatArray


def base_cylinder(member: Member, flank: str) -> BaseCylinder:
    """Return base radius and base helix angle of a flank without its parabola.

    Parameters
    ----------
    member : Member
        A single member or a batch.
    flank : {'right', 'left'}

    Returns
    -------
    BaseCylinder
        Radius in mm, helix angle in rad.
    """
    rack = rack_of(member, flank)
    nx, ny, nz = rack.normal
    radius = rack.pitch_radius * np.abs(ny) / np.hypot(nx, ny)
    return BaseCylinder(np.asarray(radius), np.asarray(np.arcsin(nz)))


def turned(phi: FloatArray | float, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return vectors (..., 3), given by their components, rotated about z by `phi` (rad)."""
    cos, sin = np.cos(phi), np.sin(phi)
    return np.stack(np.broadcast_arrays(cos * x - sin * y, sin * x + cos * y, z), axis=-1)


def trace_parameter(member: Member, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Return `u` (mm) of the flank point with parameter `l` in the plane `z` (mm from mid-face)."""
    rack = rack_of(member, flank)
    z0 = rack_point(rack, np.asarray(l, dtype=float))[2]
    return np.asarray((z - z0) / rack.trace[2])


def flank_point(
    member: Member, flank: str, l: ArrayLike, u: ArrayLike | None = None, *, z: ArrayLike | None = None
) -> FloatArray:
    """Return points of a flank (Eq. 6).

    Parameters
    ----------
    member : Member
    flank : {'right', 'left'}
    l, u : array_like
        Flank parameters, mm.
    z : array_like, optional
        Distance from mid-face, mm, in place of `u`.

    Returns
    -------
    ndarray, shape (..., 3)
        Points in the gear frame S_j, mm.

    Raises
    ------
    TypeError
        Unless exactly one of `u` and `z` is given.
    """
    rack, modification = rack_of(member, flank), modification_of(member, flank)
    l = np.asarray(l, dtype=float)
    x, y, height = _moved(rack, rack_point(rack, l), _trace_or_plane(member, flank, l, u, z))
    nx, ny, _ = rack_normal(rack, l)
    x, y, phi = rolled(rack.pitch_radius, ny / nx, (x, y))
    return turned(phi if modification is None else phi + modification.turn(l, height), x, y, height)


def _trace_or_plane(
    member: Member, flank: str, l: ArrayLike, u: ArrayLike | None, z: ArrayLike | None
) -> FloatArray:
    """Return `u` (mm) if it is given, otherwise that of the points in the planes `z` (mm)."""
    if u is not None and z is None:
        return np.asarray(u, dtype=float)
    if z is not None and u is None:
        return trace_parameter(member, flank, l, z)
    raise TypeError("u or z must be given, not both: the flank parameter u or the distance z from mid-face")


def _moved(rack: Rack, point: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the components of points of the rack, moved by `u` (mm) along the trace."""
    (x, y, z), (tx, ty, tz) = point, rack.trace
    return x + u * tx, y + u * ty, z + u * tz


def generated(
    rack: Rack, point: Sequence[FloatArray] | FloatArray, normal: Sequence[FloatArray] | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the points (mm) and unit normals (..., 3), in the gear frame, that `rack` generates (Eq. 6) with
    the given points of its surface and their unit normals, by components in S_c as in `rack_point`.
    """
    x, y, phi = rolled(rack.pitch_radius, normal[1] / normal[0], (point[0], point[1]))
    return turned(phi, x, y, point[2]), turned(phi, *normal)


def flank_patch(
    member: Member, flank: str, l: ArrayLike, u: ArrayLike | None = None, *, z: ArrayLike | None = None
) -> FlankPatch:
    """Return points, unit normals and tangents of a flank. The tangents are analytic.

    Parameters
    ----------
    member : Member
    flank : {'right', 'left'}
    l, u : array_like
        Flank parameters, mm.
    z : array_like, optional
        Distance from mid-face, mm, in place of `u`.

    Returns
    -------
    FlankPatch
        Arrays (..., 3) in the gear frame S_j, mm.

    Raises
    ------
    TypeError
        Unless exactly one of `u` and `z` is given.
    """
    rack, modification = rack_of(member, flank), modification_of(member, flank)
    l, u = np.broadcast_arrays(np.asarray(l, dtype=float), _trace_or_plane(member, flank, l, u, z))
    section = rack_at(rack, l)
    height = section[1][2] + u * rack.trace[2]
    cut = _cut_at(rack, l, section, height)
    # n . (second x first), which the rotation by phi does not change.
    (x_l, y_l), (x_z, y_z) = cut.by_s, cut.by_z
    regularity = rack.trace[2] * (cut.ny * x_l - cut.nx * y_l + cut.nz * (x_z * y_l - y_z * x_l))
    if modification is not None:
        cut = rotated_cut(cut, modification.rows(l, height)[:3])
        (x_l, y_l), (x_z, y_z) = cut.by_s, cut.by_z
    # Along l at constant u, z changes with the tangent of the rack.
    z_l, z_u = section[2][2], rack.trace[2]
    return FlankPatch(
        point=turned(cut.phi, cut.x, cut.y, height),
        normal=turned(cut.phi, cut.nx, cut.ny, cut.nz),
        tangent_l=turned(cut.phi, x_l + z_l * x_z, y_l + z_l * y_z, z_l),
        tangent_u=turned(cut.phi, z_u * x_z, z_u * y_z, z_u),
        regularity=np.asarray(rack.sigma * regularity),
    )


def normal_rates(member: Member, flank: str, l: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return derivatives (..., 3), 1/mm, of the unit normal of a flank by its parameters l and u (mm), in the
    gear frame. They are analytic, as the tangents of `flank_patch`.

    A `Modification` is not included. On modified flanks the derivatives are approximate and serve for Newton
    steps only.
    """
    rack = rack_of(member, flank)
    l, u = np.broadcast_arrays(np.asarray(l, dtype=float), np.asarray(u, dtype=float))
    section = rack_at(rack, l)
    cut = _cut_at(rack, l, section, section[1][2] + u * rack.trace[2])
    phi_u = rack.trace[2] * cut.phi_z
    phi_l = cut.phi_s + section[2][2] * cut.phi_z
    bent_x, bent_y, bent_z = turn_rate(rack, l) * section[2]
    by_l = turned(cut.phi, bent_x - phi_l * cut.ny, bent_y + phi_l * cut.nx, bent_z)
    return by_l, turned(cut.phi, -phi_u * cut.ny, phi_u * cut.nx, 0.0 * cut.phi)


def _cut_at(
    rack: Rack, l: FloatArray, section: tuple[FloatArray, FloatArray, FloatArray], z: FloatArray
) -> Cut:
    """Return the generated flank (Eq. 6) at `l` in the planes `z`, with derivatives by both; `section` is the
    result of `rack_at`."""
    normal, point, (dx, dy, dz) = section
    x, y, _ = _moved(rack, point, (z - point[2]) / rack.trace[2])
    along = rack.trace[0] / rack.trace[2], rack.trace[1] / rack.trace[2]
    slope_l = turn_rate(rack, l) * (dy - normal[1] / normal[0] * dx) / normal[0]
    by_l = dx - dz * along[0], dy - dz * along[1]
    return cut_of_rack(rack.pitch_radius, tuple(normal), slope_l, (x, y), by_l, along)


def modification_of(member: Member, flank: str) -> FlankModification | None:
    """Return the modification of a flank, None for a flank without one.

    Undercut does not move the beginning of the flank from which the coordinate lam is counted.
    """
    if member.modification(flank) is None:
        return None
    return (_modification if is_batch(member) else _kept_modification)(member, flank)


def _modification(member: Member, flank: str) -> FlankModification:
    given = member.modification(flank)
    assert given is not None
    base = base_cylinder(member, flank)
    extent = FlankExtent(
        start=root_parameter(member, flank),
        tip=tip_parameter(member, flank, 0.0),
        half=0.5 * member.face_width,
        base_radius=base.radius,
        lever=base.radius * np.cos(base.helix_angle),
        flank=flank,
        sigma=flank_sign(flank),
    )
    return flank_modification(given, extent)


_kept_modification = kept(64)(_modification)


def is_batch(member: Member) -> bool:
    """Return whether any quantity of a member, its tool or its modifications is an array."""
    return any(np.ndim(value) for value in member.quantities())


def tip_radius(member: Member, z: ArrayLike) -> FloatArray:
    """Return the radius of the tip cone in the plane `z` (mm from mid-face), mm."""
    tool = member.tool
    height = (member.profile_shift + member.tip_height) * tool.normal_module
    return np.asarray(reference_radius(member) + height + np.asarray(z) * np.tan(member.cone_angle))


def root_parameter(member: Member, flank: str) -> FloatArray:
    """Return the flank parameter `l` (mm) at which the active profile of a flank starts.

    NaN if the tool cannot cut the active flank (see `active_range`).
    """
    return active_range(member, flank)[0]


def highest_parameter(member: Member, flank: str) -> FloatArray:
    """Return an upper bound of `l` (mm) on an active flank.

    In the tilted rack, no point of the tip cone is higher than cos(gamma) times its height. NaN as in
    `root_parameter`.
    """
    return active_range(member, flank)[1]


def active_range(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest flank parameter of an active flank.

    Both are NaN if the tool cannot cut the flank between them: if the profile of the rack folds, or if the
    generating normal of this flank or of its mirror image has no radial component out of the tooth. Eq. 6
    gives a surface beyond such a place, but the tool does not produce it.

    Parameters
    ----------
    member : Member
        A single member or a batch.
    flank : {'right', 'left'}

    Returns
    -------
    lowest, highest : ndarray
        `l`, mm, batch shape.
    """
    tool = member.tool
    joint = tool.dedendum - tool.tip_radius * (1.0 - np.sin(tool.normal_pressure_angle))
    # The usual tip radius 0.38 is the rounded value of 0.37995, so that the round meets the flank 0.00003
    # modules above the depth of one addendum. If the distance is small, the active profile starts there.
    round_snap_modules = 1e-4
    start = np.where(np.abs(joint - tool.addendum) < round_snap_modules, tool.addendum, joint)
    with np.errstate(invalid="ignore", over="ignore"):
        low = parameter_at_height(tool, flank, -start * tool.normal_module)
        tip = member.tip_height * tool.normal_module * np.cos(member.cone_angle)
        high = parameter_at_height(tool, flank, tip)
        # The condition is linear in l, so that both ends decide.
        cut = _leans_outwards(member, flank, low) & _leans_outwards(member, flank, high)
    return np.where(cut, low, np.nan), np.where(cut, high, np.nan)


def _leans_outwards(member: Member, flank: str, l: FloatArray) -> Mask:
    """Return whether the normals of the rack lean out of the tooth at `l` of a flank and of its mirror image,
    before the fold.

    The condition is tan(alpha - tau) > sin|beta| tan|gamma| with tan(tau) = 2 a l.
    """
    tool, bend = member.tool, 2.0 * member.tool.parabola_of(flank) * l
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    across = np.abs(np.sin(member.helix_angle) * np.tan(member.cone_angle))
    return np.asarray(sin - bend * cos > (cos + bend * sin) * across)


def tip_parameter(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Return the flank parameter `l` (mm) at which the flank reaches the tip cone in the plane `z`.

    Newton's method from above, with the exact slope of the radius along the line of constant z, is kept
    by bisection between the start of the active profile and its highest point. NaN if the flank does not
    reach the tip cone. The solution is unique unless the flank is undercut.
    """
    z = np.asarray(z, dtype=float)
    rack, target = rack_of(member, flank), tip_radius(member, z)
    low, high = (end + 0.0 * z for end in active_range(member, flank))
    l = high
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(60):
            cut = _cut_at(rack, l, rack_at(rack, l), z)
            radius = np.sqrt(cut.square)
            # Newton step of the radius; bisect if it leaves the bracket.
            missing = target - radius
            low, high = np.where(missing > 0.0, l, low), np.where(missing > 0.0, high, l)
            moved = l + 2.0 * missing * radius / cut.square_s
            moved = np.where((moved >= low) & (moved <= high), moved, 0.5 * (low + high))
            step, l = np.abs(moved - l), moved
            if not np.any(step > 1e-13 * target):
                break
    return np.where((step <= 1e-9 * target) & (np.abs(missing) <= 1e-9 * target), l, np.nan)


def half_thickness_angle(member: Member, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Return the angle (rad) from the middle of the tooth to the flank point (l, z).

    It is measured around the axis away from the material and is positive where the tooth has thickness
    between its flanks. The middle is the point of the rack section at mid-face with y_n = 0. With a helix
    angle it rotates along the face, equally for both flanks, so that only the sum of the angles of both
    flanks at equal radius and z is a tooth thickness.
    """
    rack, l = rack_of(member, flank), np.asarray(l, dtype=float)
    z = np.asarray(z, dtype=float)
    angle = angle_of(_cut_at(rack, l, rack_at(rack, l), z))
    if (modification := modification_of(member, flank)) is not None:
        angle = angle + modification.turn(l, z)
    return np.asarray(rack.sigma * angle)  # a long helix keeps its full turns


def tip_thickness(member: Member, z: ArrayLike) -> FloatArray:
    """Return the transverse thickness (mm, along the circle) of the tooth at the tip cone in the plane `z`.

    It is negative where the tooth is pointed below its tip cone.
    """
    angle = sum(
        half_thickness_angle(member, flank, tip_parameter(member, flank, z), z) for flank in ("right", "left")
    )
    return np.asarray(angle * tip_radius(member, z))


def may_fold(member: Member, rack: Rack, low: FloatArray, high: FloatArray) -> Mask:
    """Return whether flanks may fold back at toe or heel. If False, they certainly do not.

    For each l the regularity is linear in z, so that toe and heel suffice. Samples begin slightly below the
    start of the active profile, because a parabola moves the joint with the fillet.

    Parameters
    ----------
    member : Member
        A single member, or members stacked as in `stacked`.
    rack : Rack
        The rack of the flanks.
    low, high : ndarray
        Ends of the active profile, mm of l (`active_range`).

    Returns
    -------
    ndarray of bool
        Shape of the member without its last axis.
    """
    # Modules below the start of the active profile, and number of samples along a parabolic profile, in the
    # check for folds.
    below_joint_modules, fold_samples = 0.02, 25
    low = low - below_joint_modules * np.asarray(member.tool.normal_module)
    z = np.multiply.outer((-0.5, 0.5), member.face_width * np.ones(1))
    if not np.any(rack.parabola):  # the regularity rises with l, so that the joint decides
        return np.asarray(~(_radial_slope(rack, low, z) > 0.0).all(axis=(0, -1)))
    # The slope is smooth in l. It has no zero if it exceeds its second differences at five points.
    slope = _radial_slope(rack, low + (high - low) * np.linspace(0.0, 1.0, 5), z)
    bend = np.abs(np.diff(slope, 2, axis=-1)).max(axis=-1, keepdims=True)
    folds = np.asarray(~(slope > bend).all(axis=(0, -1)))
    if folds.any():
        at = (slice(None), np.flatnonzero(folds.any(axis=0))) if folds.ndim else ()
        l = low[at] + (high - low)[at] * np.linspace(0.0, 1.0, fold_samples)
        folds[at] = ~(_radial_slope(rack.pick(at), l, z[(slice(None), *at)]) > 0.0).all(axis=(0, -1))
    return folds


def _radial_slope(rack: Rack, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return half of d(r^2)/dl at flank parameters `l` in the planes `z`, both mm; its sign is that of the
    regularity of the flank."""
    return 0.5 * _cut_at(rack, l, rack_at(rack, l), z).square_s
