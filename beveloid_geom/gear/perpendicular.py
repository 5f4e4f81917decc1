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
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Mask, Quantity
from ..design.model import Member
from ..status import Status
from .flank import active_range, tip_radius
from .rack import Rack, rack_normal, rack_of, rack_point

Vector: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Components of points (mm) or vectors in a member's own frame."""
Turn: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Generating roll angles phi, rad, their cosines and sines."""
Values: TypeAlias = tuple[FloatArray, ...]

NEWTON_LIMIT, FEW = 30, 8
"""Newton steps at most; of how many points one that is not settled yet goes on alone."""
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


@dataclass(frozen=True, eq=False)
class Sheet:
    """A single member's flank as its `rack` cuts it, with its limits, mm: lowest and highest `l`, the tip
    cone's radius at mid-face and `taper`, half the face width; and the module, mm."""

    rack: Rack
    root: Quantity
    highest: Quantity
    tip: Quantity
    taper: Quantity
    half: Quantity
    module: Quantity


@dataclass(frozen=True, eq=False)
class Foot:
    """Feet as in `Feet`, but for u; `normal` by components, and its `moment` (mm) about the member's axis."""

    l: FloatArray
    z: FloatArray
    distance: FloatArray
    normal: Vector
    moment: FloatArray
    margin: FloatArray


def sheet_of(member: Member, flank: str) -> Sheet:
    """Give a flank with its limits."""
    root, highest = active_range(member)
    return Sheet(
        rack=rack_of(member, flank),
        root=root,
        highest=highest,
        tip=tip_radius(member, 0.0),
        taper=np.tan(member.cone_angle),
        half=0.5 * member.face_width,
        module=member.tool.normal_module,
    )


def feet(
    member: Member, flank: str, points: ArrayLike, start: tuple[ArrayLike, ArrayLike] | None = None
) -> Feet:
    """Find the feet on the flank of a single member of perpendiculars from `points` (..., 3), mm, in its own
    frame, near its tooth 0. `start`: (l, u) near the feet, mm; without it the unmodified flank's foot.

    The foot is taken on the flank as its parameters extend it; `status` says whether it lies within
    root, tip, toe and heel."""
    sheet = sheet_of(member, flank)
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        foot = foot_on(sheet, (x, y, z), None if start is None else _given_foot(sheet.rack, *start))
    beyond = foot.margin < -EDGE * np.asarray(sheet.module)
    off = np.where(beyond, np.int8(Status.OFF_FLANK), np.int8(Status.SOLVED))
    status = np.where(np.isnan(foot.l), np.int8(Status.NOT_CONVERGED), off).astype(np.int8)
    normal = np.stack(np.broadcast_arrays(*foot.normal), axis=-1)
    u = (foot.z - rack_point(sheet.rack, foot.l)[2]) / sheet.rack.trace[2]
    return Feet(foot.l, u, foot.z, foot.distance, normal, foot.margin, status)


def foot_on(
    sheet: Sheet,
    point: Vector,
    near: tuple[FloatArray, FloatArray] | None = None,
    last_step: float = LAST_STEP,
) -> Foot:
    """Find the feet on a flank of perpendiculars from points by components; `near`: l and phi to start from,
    else those of the unmodified flank's foot; `last_step` as LAST_STEP. To be called where errors of numbers
    are ignored."""
    rack, last, rest = sheet.rack, last_step * np.asarray(sheet.module), _rest(sheet.rack, point[2])
    if near is None:
        turn = _unmodified_turn(rack, *point)
    else:
        l, turn = near[0], (near[1], np.cos(near[1]), np.sin(near[1]))
    slid = _slid(rack, point, turn, rest)
    if near is None:
        l = slid[0]  # of the unmodified flank's foot: V.d = l
    l, turn = _settled(rack, point, rest, l, turn, slid, last)
    return _foot(sheet, point, l, turn, _slid(rack, point, turn, rest))


def _settled(
    rack: Rack,
    point: Vector,
    rest: Values,
    l: FloatArray,
    turn: Turn,
    slid: Values,
    last: FloatArray,
    most: int = NEWTON_LIMIT,
) -> tuple[FloatArray, Turn]:
    """Find l and phi of the feet from some near by, `slid` being `_slid` there, in so many steps at `most`; l
    is NaN where there is none. The few that take longer go on alone."""
    for count in range(most):
        if count:
            slid = _slid(rack, point, turn, rest)
        step_l, step_phi, regular = _newton_step(rack, slid, l)
        l, turn = l + step_l, _turned_on(turn, step_phi)
        done = (np.abs(step_l) <= last) & (np.abs(step_phi) * rack.pitch_radius <= last)
        going = ~done & np.isfinite(l)
        number = np.count_nonzero(going)
        if not number:
            break
        if FEW * number < going.size and count + 1 < most:
            few = point[0][going], point[1][going], point[2][going]
            own, turned = tuple(row[going] for row in rest), (turn[0][going], turn[1][going], turn[2][going])
            there = _slid(rack, few, turned, own)
            part = _settled(rack, few, own, l[going], turned, there, last, most - count - 1)
            l = np.where(done & regular, l, np.nan)
            l[going] = part[0]
            for row, values in zip(turn, part[1], strict=True):
                row[going] = values
            return l, turn
    return np.where(done & regular, l, np.nan), turn


def _given_foot(rack: Rack, l: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Find l and generating roll angle phi (Eq. 6) of the flank points (l, u)."""
    l = np.asarray(l, dtype=float)
    n, start = rack_normal(rack, l), rack_point(rack, l)
    slope = n[1] / n[0]
    across = start[1] + u * rack.trace[1] - slope * (start[0] + u * rack.trace[0])
    return l, np.asarray(across / rack.pitch_radius)


def _unmodified_turn(rack: Rack, x: FloatArray, y: FloatArray, z: FloatArray) -> Turn:
    """Find phi of the foot on the involute helicoid that the rack's straight flank cuts."""
    nx, ny, _ = rack.normal
    across, radius = np.hypot(nx, ny), np.sqrt(x * x + y * y)
    sine = np.minimum(np.maximum(rack.pitch_radius * ny / across / radius, -1.0), 1.0)
    cosine = np.sqrt(1.0 - sine * sine)
    # phi = theta - psi + arcsin(sine), theta and psi being the angles of (x, y) and of the normal
    u, v = nx * cosine + ny * sine, nx * sine - ny * cosine
    size = across * radius
    cos, sin = (x * u - y * v) / size, (y * u + x * v) / size
    return np.arctan2(sin, cos), cos, sin


def _turned_on(turn: Turn, step: FloatArray) -> Turn:
    """Give turns that are larger by about `step`, rad: by twice the angle whose tangent is half of it, so
    that cosine and sine are rational."""
    (phi, cos, sin), half = turn, 0.5 * step
    square = half * half
    share = 1.0 / (1.0 + square)
    c, s = (1.0 - square) * share, step * share
    return phi + 2.0 * np.arctan(half), cos * c - sin * s, sin * c + cos * s


def _rest(rack: Rack, z: FloatArray) -> Values:
    """Find what V.d and V.m have of the rack and of z, whatever phi."""
    x, y, up = rack.pitch_radius + rack.apex[0], rack.apex[1], z - rack.apex[2]
    return tuple(up * e[2] - (x * e[0] + y * e[1]) for e in (rack.direction, rack.normal))


def _slid(rack: Rack, point: Vector, turn: Turn, rest: Values) -> Values:
    """Find V.d, V.m of the module's text, W.d, W.m and dW/dphi . d, dW/dphi . m."""
    (x, y, _), (phi, cos, sin), r = point, turn, rack.pitch_radius
    fx, fy = cos * x + sin * y, cos * y - sin * x
    slide, wy = r * phi, r - fx
    (dx, dy, _), (mx, my, _) = rack.direction, rack.normal
    d, m = fx * dx + fy * dy, fx * mx + fy * my
    v = d + slide * dy + rest[0], m + slide * my + rest[1]
    return *v, fy * dx + wy * dy, fy * mx + wy * my, -d, -m


def _newton_step(rack: Rack, slid: Values, l: FloatArray) -> tuple[FloatArray, FloatArray, Mask]:
    """Find steps of l (mm) and phi (rad) towards the foot; whether the distance is regular here. Beyond a
    centre of curvature, or on the involute's other branch, the determinant is negative."""
    vd, vm, wd, wm, wd_phi, wm_phi = slid
    double = 2.0 * rack.parabola
    bend = double * l
    standing = vd - l + bend * (vm - 0.5 * bend * l)
    moving = wm - bend * wd
    # Jacobian of (standing, moving) by (l, phi).
    a = double * vm - 1.5 * bend * bend - 1.0
    b = wd + bend * wm
    c = -double * wd
    e = wm_phi - bend * wd_phi
    determinant = a * e - b * c
    step_l, step_phi = b * moving - e * standing, c * standing - a * moving
    return step_l / determinant, step_phi / determinant, (determinant > 0.0) & (a < 0.0)


def _foot(sheet: Sheet, point: Vector, l: FloatArray, turn: Turn, slid: Values) -> Foot:
    rack, (_, cos, sin), (vd, vm, *_) = sheet.rack, turn, slid
    bend = 2.0 * rack.parabola * l
    length = np.sqrt(1.0 + bend * bend)
    distance = (vm - 0.5 * bend * l - bend * (vd - l)) / length
    nx, ny, nz = ((m - bend * d) / length for m, d in zip(rack.normal, rack.direction, strict=True))
    normal = cos * nx - sin * ny, sin * nx + cos * ny, nz
    x, y, z = (value - distance * n for value, n in zip(point, normal, strict=True))
    reach = sheet.tip + sheet.taper * z - np.sqrt(x * x + y * y)
    # A parabola folds back far out, to where radii mean nothing: no tip lies beyond `highest`.
    margin = np.minimum(np.minimum(l - sheet.root, sheet.highest - l), reach)
    margin = np.minimum(margin, sheet.half - np.abs(z))
    return Foot(l, z, distance, normal, rack.pitch_radius * ny, margin)
