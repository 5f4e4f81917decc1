"""Eq. 6: points of a tooth where the sliding rack generates them, with their derivatives.

A rack point (x_c, y_c) in the plane z touches the gear where its normal meets the pitch line. With the slope
k = n_y / n_x of the normal and the reference pitch radius r_P, this point and the roll angle of the gear are

    Q = (r_P + x_c, k x_c),   phi = (y_c - k x_c) / r_P,

and its rotation by phi about z gives the point of the tooth. Surfaces are given over a profile coordinate s
and z. This module is the only place where these formulas and their derivatives are written for points of a
surface; flank, fillet and bottom land use it, for members of single numbers and of arrays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ..arrays import FloatArray
from .modification import turned_normal
from .rack import Numbers, Rack, turn_rate

Plane: TypeAlias = tuple[Any, Any]
"""Components x and y."""


@dataclass(frozen=True, eq=False)
class Cut:
    """Points Q of a surface where the rack generates them, before the rotation by `phi` (rad).

    `x`, `y` (mm), unit normal (`nx`, `ny`, `nz`), and derivatives by s (`_s`) and by z (`_z`). Real or
    complex arrays; at the joint the derivatives are those of the flank.
    """

    x: Numbers
    y: Numbers
    phi: Numbers
    nx: Numbers
    ny: Numbers
    nz: Numbers
    x_s: Numbers
    y_s: Numbers
    phi_s: Numbers
    x_z: Numbers | float
    y_z: Numbers
    phi_z: Numbers

    @property
    def by_s(self) -> tuple[Numbers, Numbers]:
        """Derivative of the point by s, x and y, with that of the rotation by phi. z does not change."""
        return self.x_s - self.phi_s * self.y, self.y_s + self.phi_s * self.x

    @property
    def by_z(self) -> tuple[Numbers, Numbers]:
        """Derivative of the point by z, x and y, with that of the rotation by phi."""
        return self.x_z - self.phi_z * self.y, self.y_z + self.phi_z * self.x

    @property
    def square(self) -> Numbers:
        """r^2, mm^2."""
        return np.asarray(self.x * self.x + self.y * self.y)

    @property
    def square_s(self) -> Numbers:
        """Derivative of r^2 by s, mm."""
        return np.asarray(2.0 * (self.x * self.x_s + self.y * self.y_s))


@dataclass(frozen=True, eq=False)
class Bends:
    """Second derivatives of a `Cut` by s, and by s and z.

    Points are linear in z, and so is phi without a modification: `phi_zz` is None then. Derivatives that do
    not depend on the point may be numbers.
    """

    x_ss: FloatArray | float
    y_ss: FloatArray | float
    phi_ss: FloatArray | float
    y_sz: FloatArray | float
    phi_sz: FloatArray | float
    phi_zz: FloatArray | None = None


def rolled(pitch_radius: Any, slope: Numbers, point: Plane) -> tuple[Numbers, Numbers, Numbers]:
    """Return Q (x and y, mm) and phi (rad) of Eq. 6.

    Parameters
    ----------
    pitch_radius : float or array
        r_P, mm.
    slope : ndarray
        n_y / n_x of the rack.
    point : tuple of ndarray
        x_c and y_c of the rack, mm.
    """
    across = slope * point[0]
    return pitch_radius + point[0], across, (point[1] - across) / pitch_radius


def cut_of_rack(
    pitch_radius: Any, normal: tuple[Any, Any, Any], slope_s: Numbers, point: Plane, by_s: Plane, by_z: Plane
) -> Cut:
    """Return the points that a rack generates, with their derivatives.

    Parameters
    ----------
    pitch_radius : float or array
        r_P, mm.
    normal : tuple of ndarray
        Unit normal of the rack, which does not depend on z.
    slope_s : ndarray
        Derivative of n_y / n_x by s, 1/mm.
    point, by_s, by_z : tuple of ndarray
        x and y of the rack points in their planes, mm, and the derivatives by s at constant z and by z.
    """
    slope = normal[1] / normal[0]
    x, y, phi = rolled(pitch_radius, slope, point)
    y_s, y_z = slope_s * point[0] + slope * by_s[0], slope * by_z[0]
    return Cut(
        x=x,
        y=y,
        phi=phi,
        nx=normal[0],
        ny=normal[1],
        nz=normal[2],
        x_s=by_s[0],
        y_s=y_s,
        phi_s=(by_s[1] - y_s) / pitch_radius,
        x_z=by_z[0],
        y_z=y_z,
        phi_z=(by_z[1] - y_z) / pitch_radius,
    )


def flank_cut(
    rack: Rack, l: FloatArray, section: tuple[FloatArray, FloatArray, FloatArray], z: FloatArray
) -> Cut:
    """Return the generated flank (Eq. 6) at `l` in the planes `z`, with derivatives by both; `section` is the
    result of `rack_at`."""
    normal, point, (dx, dy, dz) = section
    along = rack.trace[0] / rack.trace[2], rack.trace[1] / rack.trace[2]
    u = (z - point[2]) / rack.trace[2]
    x, y = point[0] + u * rack.trace[0], point[1] + u * rack.trace[1]
    slope_l = turn_rate(rack, l) * (dy - normal[1] / normal[0] * dx) / normal[0]
    by_l = dx - dz * along[0], dy - dz * along[1]
    return cut_of_rack(rack.pitch_radius, tuple(normal), slope_l, (x, y), by_l, along)


def rotated_cut(cut: Cut, turn: FloatArray, normals: bool = True) -> Cut:
    """Return points rotated by a modification. `turn` (3, ...) is the rotation (rad) with its derivatives by
    s and z. Without `normals`, the normals of the result are NaN."""
    phi, phi_s, phi_z = cut.phi + turn[0], cut.phi_s + turn[1], cut.phi_z + turn[2]
    unknown = (np.full(1, np.nan),) * 3
    moved = Cut(cut.x, cut.y, phi, *unknown, cut.x_s, cut.y_s, phi_s, cut.x_z, cut.y_z, phi_z)
    if not normals:
        return moved
    nx, ny, nz = turned_normal((cut.nx, cut.ny, cut.nz), moved.by_s, moved.by_z)
    return replace(moved, nx=nx, ny=ny, nz=nz)


def angle_of(cut: Cut) -> FloatArray:
    """Return the angles (rad) of real points about the gear axis, in the gear frame."""
    return np.asarray(cut.phi + np.arctan2(cut.y, cut.x))


def tangents_of(cut: Cut, bends: Bends | None = None) -> FloatArray:
    """Return points before the rotation by phi, with derivatives that include this rotation.

    Parameters
    ----------
    cut : Cut
        Points (n,) of a surface.
    bends : Bends, optional
        Their second derivatives.

    Returns
    -------
    ndarray, shape (3, 2, n) or (6, 2, n)
        x and y, mm, with derivatives by s, z and, with `bends`, s s, s z and z z.
    """
    plane = np.empty((3 if bends is None else 6, 2, cut.x.size))
    plane[0, 0], plane[0, 1] = cut.x, cut.y
    (plane[1, 0], plane[1, 1]), (plane[2, 0], plane[2, 1]) = cut.by_s, cut.by_z
    if bends is not None:
        # Rotation by phi adds phi' times the position, rotated by a quarter turn, to the derivatives.
        (s_x, s_y), (z_x, z_y) = plane[1:3]
        plane[3, 0] = bends.x_ss - bends.phi_ss * cut.y - cut.phi_s * (cut.y_s + s_y)
        plane[3, 1] = bends.y_ss + bends.phi_ss * cut.x + cut.phi_s * (cut.x_s + s_x)
        plane[4, 0] = -bends.phi_sz * cut.y - cut.phi_z * cut.y_s - cut.phi_s * z_y
        plane[4, 1] = bends.y_sz + bends.phi_sz * cut.x + cut.phi_z * cut.x_s + cut.phi_s * z_x
        plane[5, 0], plane[5, 1] = -cut.phi_z * (cut.y_z + z_y), cut.phi_z * (cut.x_z + z_x)
        if bends.phi_zz is not None:
            plane[5, 0] -= bends.phi_zz * cut.y
            plane[5, 1] += bends.phi_zz * cut.x
    return plane
