"""The generated flank (Eq. 6), its normal and tangents.

While the rack slides by r_P phi, the gear rotates by phi. A rack point touches the gear when its
normal meets the pitch line. In the fixed frame of generation this point is

    Q = (r_P + x_c, (n_y / n_x) x_c, z_c),   phi = (y_c - (n_y / n_x) x_c) / r_P,

and its rotation by phi about z gives the flank point in the gear frame S_j. For a fixed `l` the
normal is constant and Q moves along a straight line in `u`. Without a parabola the flank is an
involute helicoid. Its base radius and base helix angle differ between the right and the left
flank of a beveloid gear.

z is the axial coordinate from mid-face; the tooth is larger at +z if the cone angle is positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, flank_sign
from ..design.member import Member
from ..support.frozen_arrays import cached
from .flank_limits import root_parameter, tip_parameter, tip_radius
from .generation import angle_of, flank_cut, rolled, rotated_cut
from .modification import FlankExtent, FlankModification, flank_modification
from .rack import (
    Rack,
    rack_at,
    rack_normal,
    rack_of,
    rack_point,
    turn_rate,
)


@dataclass(frozen=True, eq=False)
class BaseCylinder:
    """Base radius (mm) and base helix angle (rad) of one unmodified flank.

    The helix angle has the sign of the z component of the normal: with a right-hand helix it is negative on
    right flanks and positive on left flanks (unless a steep cone changes it). `radius cos(helix_angle)`
    equals `m_n N cos(alpha) / 2` on all flanks.
    """

    radius: FloatArray
    helix_angle: FloatArray


@dataclass(frozen=True, eq=False)
class FlankPatch:
    """Points (mm), unit normals and tangents of a flank in its gear frame, each (..., 3).

    `normal` points out of the tooth. `tangent_l` and `tangent_u` are the derivatives by the flank
    parameters, without unit. `regularity` (...), without unit, is positive on a sound flank, vanishes on the
    edge of regression and is negative on the part that folds back. It is not affected by a modification.
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
    cut = flank_cut(rack, l, section, height)
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
    cut = flank_cut(rack, l, section, section[1][2] + u * rack.trace[2])
    phi_u = rack.trace[2] * cut.phi_z
    phi_l = cut.phi_s + section[2][2] * cut.phi_z
    bent_x, bent_y, bent_z = turn_rate(rack, l) * section[2]
    by_l = turned(cut.phi, bent_x - phi_l * cut.ny, bent_y + phi_l * cut.nx, bent_z)
    return by_l, turned(cut.phi, -phi_u * cut.ny, phi_u * cut.nx, 0.0 * cut.phi)


def modification_of(member: Member, flank: str) -> FlankModification | None:
    """Return the modification of a flank, None for a flank without one.

    Undercut does not move the beginning of the flank from which the coordinate lam is counted.
    """
    if member.modification(flank) is None:
        return None
    return (_modification if is_batch(member) else _cached_modification)(member, flank)


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


_cached_modification = cached(64)(_modification)


def is_batch(member: Member) -> bool:
    """Return whether any quantity of a member, its tool or its modifications is an array."""
    return any(isinstance(value, np.ndarray) and value.ndim for value in member.quantities())


def half_thickness_angle(member: Member, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Return the angle (rad) about the gear axis from the x axis of the gear frame to the flank point (l, z).

    It is positive in the direction from the tooth to the space on this side: the rotation about +z times +1
    on right and -1 on left flanks. At mid-face the x axis passes through the middle of the tooth, the point
    of the rack section with y_n = 0. In other planes a helix rotates both flanks by the same angle.
    Therefore only the sum of the angles of both flanks at equal radius and z is a tooth thickness.
    """
    rack, l = rack_of(member, flank), np.asarray(l, dtype=float)
    z = np.asarray(z, dtype=float)
    angle = angle_of(flank_cut(rack, l, rack_at(rack, l), z))
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
