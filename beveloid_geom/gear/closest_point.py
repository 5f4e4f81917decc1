"""Closest points on a flank (feet of perpendiculars).

The closest flank point (foot) F of a point P is the one whose normal n passes through P. This normal meets
the pitch line when the rack cuts F (Eq. 6), so that P lies on the same line. Rotate P with the gear into the
fixed frame of generation (rotation Rz(-phi) about z), and subtract the position of the rack (r_P along the
unit vector e_x, -r_P phi along e_y) and its apex p,

    V(phi) = Rz(-phi) P - r_P e_x + r_P phi e_y - p,    W = dV/dphi.

The foot of V on the rack R = p + l d + a l^2 m + u t, at stationary distance, satisfies

    (V - l d - a l^2 m).(d + 2 a l m) = 0,    W.(m - 2 a l d) = 0.

These two equations in l and phi have explicit derivatives and are solved by Newton's method. Without a
parabola the second one is sin(psi - theta + phi) = r_P n_y / (r S), with the polar coordinates r, theta of
P and S, psi of the normal of the rack. The distance to an involute helicoid is therefore explicit, and is
the starting point for any parabola. u and the signed distance follow as the components of V along t and n.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Mask, Quantity
from ..design.arguments import require_unmodified
from ..design.member import Member
from ..status import Status
from .crossing_curve import CrossingCurve
from .flank import turned
from .flank_limits import active_range, tip_radius
from .rack import Rack, rack_normal, rack_of, rack_point
from .tooth_side import (
    ToothSurface,
    cut_at,
    cut_with_bends,
    is_batch,
    surface_of,
    tangents_of,
    undercut_edge,
)

Vector: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Components of points (mm) or vectors in the gear frame."""
Turn: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Generating roll angles phi, rad, their cosines and sines."""
Values: TypeAlias = tuple[FloatArray, ...]

NEWTON_MAX_STEPS = 30


@dataclass(frozen=True, eq=False)
class Feet:
    """Feet of perpendiculars on a flank.

    `l`, `u`, `z` (mm) of the foot; signed `distance` (mm) of the point, positive outside the tooth; unit
    `normal` (..., 3) in the gear frame; `margin` (mm), the distance of the foot from the nearest of root,
    tip, toe and heel, negative beyond it; `status`: SOLVED, OFF_FLANK (the foot is on the extended flank) or
    NOT_CONVERGED (NaN: no foot, usually because the point is inside the base cylinder).
    """

    l: FloatArray
    u: FloatArray
    z: FloatArray
    distance: FloatArray
    normal: FloatArray
    margin: FloatArray
    status: Codes


@dataclass(frozen=True, eq=False)
class FlankSheet:
    """Flank of a member, single or a batch, with its limits.

    Lengths in mm: `root` and `highest` are the bounds of `l`, `tip` is the radius of the tip cone at mid-face
    with its `taper`, `half` is half the face width; `module`; `edge` is the curve on which undercut ends the
    flank; `modified` is the extended surface of a flank with a modification.
    """

    rack: Rack
    root: Quantity
    highest: Quantity
    tip: Quantity
    taper: Quantity
    half: Quantity
    module: Quantity
    edge: CrossingCurve | None = None
    modified: ToothSurface | None = None


@dataclass(frozen=True, eq=False)
class Foot:
    """Feet as in `Feet`, without u. `normal` is given by components, with its `moment` (mm) about the gear
    axis.
    """

    l: FloatArray
    z: FloatArray
    distance: FloatArray
    normal: Vector
    moment: FloatArray
    margin: FloatArray


def sheet_of(member: Member, flank: str) -> FlankSheet:
    """Return a flank with its limits. Raises ModifiedFlanksError for members of arrays with a
    modification."""
    surface = None
    if member.modification(flank) is not None:
        if is_batch(member):
            require_unmodified(flank, "closest points on members of arrays", member=member)
        # The flank extended below its joint with the fillet.
        surface = replace(surface_of(member, flank), joint=-np.inf, crossing=None)
    root, highest = active_range(member, flank)
    return FlankSheet(
        rack=rack_of(member, flank),
        root=root,
        highest=highest,
        tip=tip_radius(member, 0.0),
        taper=np.tan(member.cone_angle),
        half=0.5 * member.face_width,
        module=member.tool.normal_module,
        edge=None if is_batch(member) else undercut_edge(member, flank),
        modified=surface,
    )


def feet(
    member: Member, flank: str, points: ArrayLike, start: tuple[ArrayLike, ArrayLike] | None = None
) -> Feet:
    """Return the closest points on a flank of a single member.

    Parameters
    ----------
    member : Member
        A single member; the flank of its tooth 0 is used.
    flank : {'right', 'left'}
    points : array_like, shape (..., 3)
        Points in the gear frame, mm.
    start : tuple of array_like, optional
        Flank parameters (l, u) near the feet, mm. If omitted, the feet on the unmodified flank.

    Returns
    -------
    Feet
        The feet on the flank extended beyond its limits; `status` states whether they are within root, tip,
        toe and heel.
    """
    # Distance in modules by which a foot may lie beyond a limit of the flank and still count as on it.
    limit_tolerance_modules = 2e-10
    sheet = sheet_of(member, flank)
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        foot = foot_on(sheet, (x, y, z), None if start is None else _given_foot(sheet.rack, *start))
    beyond = foot.margin < -limit_tolerance_modules * np.asarray(sheet.module)
    off = np.where(beyond, np.int8(Status.OFF_FLANK), np.int8(Status.SOLVED))
    status = np.where(np.isnan(foot.l), np.int8(Status.NOT_CONVERGED), off).astype(np.int8)
    normal = np.stack(np.broadcast_arrays(*foot.normal), axis=-1)
    u = (foot.z - rack_point(sheet.rack, foot.l)[2]) / sheet.rack.trace[2]
    return Feet(foot.l, u, foot.z, foot.distance, normal, foot.margin, status)


def foot_on(
    sheet: FlankSheet,
    point: Vector,
    near: tuple[FloatArray, FloatArray] | None = None,
    last_step: float = 2e-8,
) -> Foot:
    """Return the feet of perpendiculars from points, given by components, on a flank.

    `near` is l and phi of the starting point, by default the foot on the unmodified flank. `last_step` is
    the Newton step below which the iteration ends, in modules along l and in rad times pitch radius: the
    error is its square over the radius of curvature. The caller silences NumPy's warnings.
    """
    rack, last = sheet.rack, last_step * np.asarray(sheet.module)
    remaining = _fixed_terms(rack, point[2])
    if near is None:
        turn = _unmodified_turn(rack, *point)
    else:
        l, turn = near[0], (near[1], np.cos(near[1]), np.sin(near[1]))
    slid = _slid(rack, point, turn, remaining)
    if near is None:
        l = slid[0]  # on the unmodified flank the first equation is V.d = l
    l, turn = _settled(rack, point, remaining, l, turn, slid, last)
    foot = _foot(sheet, point, l, turn, _slid(rack, point, turn, remaining))
    return foot if sheet.modified is None else _modified_foot(sheet, sheet.modified, point, foot, last)


def _settled(
    rack: Rack,
    point: Vector,
    remaining: Values,
    l: FloatArray,
    turn: Turn,
    slid: Values,
    last: FloatArray,
    most: int = NEWTON_MAX_STEPS,
) -> tuple[FloatArray, Turn]:
    """Return l and phi of the feet by Newton's method from near values, with `slid` the result of `_slid`
    there and at most `most` steps. l is NaN where there is no foot. The few points that take longer are
    iterated separately.
    """
    # Number of points below which unsolved points are iterated separately.
    separate_points = 8
    # Newton's method; the last few points are iterated separately.
    for count in range(most):
        if count:
            slid = _slid(rack, point, turn, remaining)
        step_l, step_phi, regular = _newton_step(rack, slid, l)
        l, turn = l + step_l, _turned_on(turn, step_phi)
        done = (np.abs(step_l) <= last) & (np.abs(step_phi) * rack.pitch_radius <= last)
        going = ~done & np.isfinite(l)
        number = np.count_nonzero(going)
        if not number:
            break
        if separate_points * number < going.size and count + 1 < most:
            few = point[0][going], point[1][going], point[2][going]
            terms, turned = (
                tuple(row[going] for row in remaining),
                (turn[0][going], turn[1][going], turn[2][going]),
            )
            there = _slid(rack, few, turned, terms)
            part = _settled(rack, few, terms, l[going], turned, there, last, most - count - 1)
            l = np.where(done & regular, l, np.nan)
            l[going] = part[0]
            for row, values in zip(turn, part[1], strict=True):
                row[going] = values
            return l, turn
    return np.where(done & regular, l, np.nan), turn


def _given_foot(rack: Rack, l: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return l and the generating roll angle phi (Eq. 6) of the flank points (l, u)."""
    l = np.asarray(l, dtype=float)
    n, start = rack_normal(rack, l), rack_point(rack, l)
    slope = n[1] / n[0]
    across = start[1] + u * rack.trace[1] - slope * (start[0] + u * rack.trace[0])
    return l, np.asarray(across / rack.pitch_radius)


def _unmodified_turn(rack: Rack, x: FloatArray, y: FloatArray, z: FloatArray) -> Turn:
    """Return phi of the foot on the involute helicoid that the straight flank of the rack generates."""
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
    """Return roll angles that are increased by 2 atan(`step` / 2), rad.

    This is `step` to second order, and its cosine and sine are rational functions of `step`.
    """
    (phi, cos, sin), half = turn, 0.5 * step
    square = half * half
    share = 1.0 / (1.0 + square)
    c, s = (1.0 - square) * share, step * share
    return phi + 2.0 * np.arctan(half), cos * c - sin * s, sin * c + cos * s


def _fixed_terms(rack: Rack, z: FloatArray) -> Values:
    """Return the parts of V.d and V.m that depend on the rack and on z only."""
    x, y, up = rack.pitch_radius + rack.apex[0], rack.apex[1], z - rack.apex[2]
    return tuple(up * e[2] - (x * e[0] + y * e[1]) for e in (rack.direction, rack.normal))


def _slid(rack: Rack, point: Vector, turn: Turn, remaining: Values) -> Values:
    """Return V.d and V.m of the module docstring, W.d, W.m, dW/dphi . d and dW/dphi . m."""
    (x, y, _), (phi, cos, sin), r = point, turn, rack.pitch_radius
    fx, fy = cos * x + sin * y, cos * y - sin * x
    slide, wy = r * phi, r - fx
    (dx, dy, _), (mx, my, _) = rack.direction, rack.normal
    d, m = fx * dx + fy * dy, fx * mx + fy * my
    v = d + slide * dy + remaining[0], m + slide * my + remaining[1]
    return *v, fy * dx + wy * dy, fy * mx + wy * my, -d, -m


def _newton_step(rack: Rack, slid: Values, l: FloatArray) -> tuple[FloatArray, FloatArray, Mask]:
    """Return the Newton steps of l (mm) and phi (rad), and whether the distance is regular.

    Beyond a centre of curvature, or on the other branch of the involute, the determinant is negative.
    """
    vd, vm, wd, wm, wd_phi, wm_phi = slid
    double = 2.0 * rack.parabola
    bend = double * l
    standing = vd - l + bend * (vm - 0.5 * bend * l)
    moving = wm - bend * wd
    # Jacobian of both equations by (l, phi).
    a = double * vm - 1.5 * bend * bend - 1.0
    b = wd + bend * wm
    c = -double * wd
    e = wm_phi - bend * wd_phi
    determinant = a * e - b * c
    step_l, step_phi = b * moving - e * standing, c * standing - a * moving
    return step_l / determinant, step_phi / determinant, (determinant > 0.0) & (a < 0.0)


def _foot(sheet: FlankSheet, point: Vector, l: FloatArray, turn: Turn, slid: Values) -> Foot:
    rack, (_, cos, sin), (vd, vm, *_) = sheet.rack, turn, slid
    bend = 2.0 * rack.parabola * l
    length = np.sqrt(1.0 + bend * bend)
    distance = (vm - 0.5 * bend * l - bend * (vd - l)) / length
    nx, ny, nz = ((m - bend * d) / length for m, d in zip(rack.normal, rack.direction, strict=True))
    normal = cos * nx - sin * ny, sin * nx + cos * ny, nz
    x, y, z = (value - distance * n for value, n in zip(point, normal, strict=True))
    margin = _margin(sheet, l, z, x * x + y * y)
    return Foot(l, z, distance, normal, rack.pitch_radius * ny, margin)


def _margin(sheet: FlankSheet, l: FloatArray, z: FloatArray, square: FloatArray) -> FloatArray:
    """Return the distances (mm) of points with r^2 = `square` from the nearest limit, negative beyond it."""
    reach = sheet.tip + sheet.taper * z - np.sqrt(square)
    # A parabola folds back far outside; the tip limit applies up to `highest` only.
    margin = np.minimum(np.minimum(l - sheet.root, sheet.highest - l), reach)
    margin = np.minimum(margin, sheet.half - np.abs(z))
    return margin if sheet.edge is None else np.minimum(margin, l - sheet.edge.start(z))


def _modified_foot(
    sheet: FlankSheet, surface: ToothSurface, point: Vector, near: Foot, last: FloatArray
) -> Foot:
    """Return the feet on a modified `surface`, by Newton's method from the feet on the generated flank.

    With the vector D from the surface point S(l, z) to P, D.S_l = D.S_z = 0.
    """
    shape = near.l.shape
    px, py, pz = (np.broadcast_to(value, shape).ravel() for value in point)
    l: FloatArray = near.l.ravel()
    z: FloatArray = near.z.ravel()
    for _ in range(NEWTON_MAX_STEPS):
        cut, bends = cut_with_bends(surface, l, z)
        x, y = tangents_of(cut, bends).swapaxes(0, 1)
        cos, sin = np.cos(cut.phi), np.sin(cut.phi)
        dx, dy, dz = cos * px + sin * py - x[0], cos * py - sin * px - y[0], pz - z
        falls = dx * x[1] + dy * y[1], dx * x[2] + dy * y[2] + dz
        a = x[1] * x[1] + y[1] * y[1] - dx * x[3] - dy * y[3]
        b = x[1] * x[2] + y[1] * y[2] - dx * x[4] - dy * y[4]
        c = x[2] * x[2] + y[2] * y[2] + 1.0 - dx * x[5] - dy * y[5]
        determinant = a * c - b * b
        step_l = (c * falls[0] - b * falls[1]) / determinant
        step_z = (a * falls[1] - b * falls[0]) / determinant
        l, z = l + step_l, z + step_z
        size = np.maximum(np.abs(step_l), np.abs(step_z))
        if not (size > last).any():
            break
    l = np.where((size <= last) & (determinant > 0.0), l, np.nan)
    cut = cut_at(surface, l, z)
    normal = turned(cut.phi, cut.nx, cut.ny, cut.nz)
    foot = turned(cut.phi, cut.x, cut.y, z)
    distance = ((np.stack((px, py, pz), axis=-1) - foot) * normal).sum(axis=-1)
    nx, ny, nz = (normal[:, k].reshape(shape) for k in range(3))
    moment, margin = cut.x * cut.ny - cut.y * cut.nx, _margin(sheet, l, z, cut.square)
    return Foot(
        l=l.reshape(shape),
        z=z.reshape(shape),
        distance=distance.reshape(shape),
        normal=(nx, ny, nz),
        moment=np.asarray(moment).reshape(shape),
        margin=margin.reshape(shape),
    )
