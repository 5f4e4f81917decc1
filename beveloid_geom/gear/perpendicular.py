"""Feet of perpendiculars on a flank.

A point P stands off the flank along a normal n; the normal of a flank point meets the pitch line
when the rack cuts it (Eq. 6), and P lies on that line too. So turn P with the gear into the fixed
frame of generation and give the rack back its slide,

    V(phi) = Rz(-phi) P + r_P phi e_y - p,    W = dV/dphi,

and ask for the foot of V on the rack R = p + l d + a l^2 m + u t at a standstill of the distance:

    (V - l d - a l^2 m).(d + 2 a l m) = 0,    W.(m - 2 a l d) = 0.

These are two equations in l and phi with explicit derivatives, solved by Newton. Without parabola
the second is sin(psi - theta + phi) = r_P n_y / (r S), with r, theta the polar coordinates of P
and S, psi those of the rack's normal: the distance to an involute helicoid is explicit, and a
start for any parabola. u and the signed distance follow as V.t and along n.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Mask
from ..design.model import Member
from ..status import Status
from .flank import highest_parameter, root_parameter, tip_radius, turned as turned
from .rack import Rack, rack_normal, rack_of, rack_point

NEWTON_LIMIT = 30
LAST_STEP = 2e-8
"""Modules along l, and rad times pitch radius, below which a Newton step is the last: it leaves an
error of its square over the radius of curvature."""
EDGE = 2e-10
"""Modules that a foot may lie beyond a limit of the flank and still count as on it."""


@dataclass(frozen=True, eq=False)
class Feet:
    """Feet of perpendiculars on a flank. `l`, `u`, `z` (mm) of the foot, signed `distance` (mm)
    of the point from it, positive out of the tooth, unit `normal` (..., 3) in the member's own frame;
    `margin` (mm): how far the foot lies inside root, tip, toe and heel, negative beyond one;
    `status`: SOLVED, OFF_FLANK (a foot on the extended flank) or NOT_CONVERGED (NaN: no foot found,
    ordinarily because the point lies inside the base cylinder)."""

    l: FloatArray
    u: FloatArray
    z: FloatArray
    distance: FloatArray
    normal: FloatArray
    margin: FloatArray
    status: Codes


def feet(
    member: Member, flank: str, points: ArrayLike, start: tuple[ArrayLike, ArrayLike] | None = None
) -> Feet:
    """Find the feet on the flank of a single member of perpendiculars from `points` (..., 3), mm, in its own
    frame, near its tooth 0. `start`: (l, u) near the feet, mm; without it the unmodified flank's foot.

    The foot is taken on the flank as its parameters extend it; `status` says whether it lies within
    root, tip, toe and heel."""
    rack, last = rack_of(member, flank), LAST_STEP * np.asarray(member.tool.normal_module)
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        l, phi = _unmodified_foot(rack, x, y, z) if start is None else _given_foot(rack, *start)
        done = np.zeros(np.shape(x), dtype=bool)
        for _ in range(NEWTON_LIMIT):
            step_l, step_phi, regular = _newton_step(rack, (x, y, z), l, phi)
            l, phi = l + step_l, phi + step_phi
            done = (np.abs(step_l) <= last) & (np.abs(step_phi) * rack.pitch_radius <= last)
            if np.all(done | ~np.isfinite(l)):
                break
        return _feet(member, rack, (x, y, z), np.where(done & regular, l, np.nan), phi)


def _given_foot(rack: Rack, l: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Find l and generating roll angle phi (Eq. 6) of the flank points (l, u)."""
    l = np.asarray(l, dtype=float)
    n, start = rack_normal(rack, l), rack_point(rack, l)
    slope = n[1] / n[0]
    across = start[1] + u * rack.trace[1] - slope * (start[0] + u * rack.trace[0])
    return l, np.asarray(across / rack.pitch_radius)


def _unmodified_foot(
    rack: Rack, x: FloatArray, y: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find l and phi of the foot on the involute helicoid that the rack's straight flank cuts."""
    nx, ny, _ = rack.normal
    sine = rack.pitch_radius * ny / (np.hypot(x, y) * np.hypot(nx, ny))
    theta = np.arctan2(ny, nx) - np.arcsin(np.clip(sine, -1.0, 1.0))
    turn = np.arctan2(y, x) - theta
    phi = np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi
    return _slid(rack, (x, y, z), phi)[0], phi


def _slid(
    rack: Rack, point: tuple[FloatArray, FloatArray, FloatArray], phi: FloatArray
) -> tuple[FloatArray, ...]:
    """Find V.d, V.m, V.t of the module's text, with W.d, W.m and dW/dphi . d, dW/dphi . m."""
    x, y, z = point
    cos, sin = np.cos(phi), np.sin(phi)
    fx, fy = cos * x + sin * y, cos * y - sin * x
    wy, slide = rack.pitch_radius - fx, rack.pitch_radius * phi
    vx, vy, vz = fx - rack.pitch_radius - rack.apex[0], fy + slide - rack.apex[1], z - rack.apex[2]
    d, m, t = rack.direction, rack.normal, rack.trace
    return (
        *(vx * e[0] + vy * e[1] + vz * e[2] for e in (d, m, t)),
        *(fy * e[0] + wy * e[1] for e in (d, m)),
        *(-fx * e[0] - fy * e[1] for e in (d, m)),
    )


def _newton_step(
    rack: Rack, point: tuple[FloatArray, FloatArray, FloatArray], l: FloatArray, phi: FloatArray
) -> tuple[FloatArray, FloatArray, Mask]:
    """Find steps of l (mm) and phi (rad) towards the foot; whether the distance is regular here. Beyond a
    centre of curvature, or on the involute's other branch, the determinant is negative."""
    vd, vm, _, wd, wm, wd_phi, wm_phi = _slid(rack, point, phi)
    bend = 2.0 * rack.parabola * l
    standing = vd - l + bend * (vm - 0.5 * bend * l)
    moving = wm - bend * wd
    # Jacobian of (standing, moving) by (l, phi).
    a = -1.0 + 2.0 * rack.parabola * vm - 1.5 * bend * bend
    b = wd + bend * wm
    c = -2.0 * rack.parabola * wd
    e = wm_phi - bend * wd_phi
    determinant = a * e - b * c
    step_l, step_phi = b * moving - e * standing, c * standing - a * moving
    return step_l / determinant, step_phi / determinant, (determinant > 0.0) & (a < 0.0)


def _feet(
    member: Member,
    rack: Rack,
    point: tuple[FloatArray, FloatArray, FloatArray],
    l: FloatArray,
    phi: FloatArray,
) -> Feet:
    vd, vm, u, *_ = _slid(rack, point, phi)
    bend = 2.0 * rack.parabola * l
    length = np.sqrt(1.0 + bend * bend)
    distance = (vm - 0.5 * bend * l - bend * (vd - l)) / length
    normal = turned(phi, *rack_normal(rack, l))
    u = np.where(np.isnan(l), np.nan, u)
    x, y, z = (value - distance * normal[..., axis] for axis, value in enumerate(point))
    half = 0.5 * np.asarray(member.face_width)
    reach = tip_radius(member, z) - np.hypot(x, y)
    # A parabola folds back far out, to where radii mean nothing: no tip lies beyond `highest`.
    inside = (l - root_parameter(member), highest_parameter(member) - l, reach, half + z, half - z)
    margin = np.stack(np.broadcast_arrays(*inside)).min(axis=0)
    beyond = margin < -EDGE * np.asarray(member.tool.normal_module)
    off = np.where(beyond, np.int8(Status.OFF_FLANK), np.int8(Status.SOLVED))
    status = np.where(np.isnan(l), np.int8(Status.NOT_CONVERGED), off).astype(np.int8)
    return Feet(l, u, z, distance, normal, margin, status)
