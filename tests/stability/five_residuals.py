"""The five equations of Eq. 15 written from Eqs. 1-14 for batches, independent of the library.

Flanks, frames and misalignment are written as in the paper, component by component. Profile shift is a radial
displacement of the rack at mid-face. Nothing of `gear.flank`, `gear.rack`, `pair.frames` or
`contact.equation` is used. Lengths in mm, angles in rad; arrays (..., positions)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beveloid_geom import ContactPath, Design, Member
from beveloid_geom.arrays import FLANK_SIGN, FloatArray, Quantity

Vector = tuple[FloatArray, FloatArray, FloatArray]
Cases = NDArray[np.int_]


class Generated(NamedTuple):
    """One flank at given l: rack point at u = 0, trace and unit normal, all in S_c."""

    point: Vector
    trace: Vector
    normal: Vector
    pitch_radius: FloatArray


def column(value: Quantity) -> FloatArray:
    """Return a quantity of the batch with an additional axis for positions."""
    array = np.asarray(value, dtype=float)
    return array[..., None] if array.ndim else array


def rack_at(member: Member, flank: str, l: FloatArray) -> Generated:
    """Return the rack at flank parameters `l` (..., positions), Eqs. 1-5."""
    tool, sigma = member.tool, FLANK_SIGN[flank]
    m, alpha, apex = map(column, (tool.normal_module, tool.normal_pressure_angle, tool.parabola_apex))
    own = tool.parabola_right if sigma > 0.0 else tool.parabola_left
    a = column(tool.parabola if own is None else own)
    beta, gamma = column(member.helix_angle), column(member.cone_angle)
    sa, ca, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(beta), np.cos(beta)
    sg, cg = np.sin(gamma), np.cos(gamma)

    def to_rack(x: FloatArray, y: FloatArray, z: FloatArray) -> Vector:
        y, z = cb * y + sb * z, cb * z - sb * y  # turned by the helix angle about x
        return cg * x + sg * z, y, cg * z - sg * x  # tilted by the cone angle about y

    x_n = (l + apex) * ca + a * l * l * sa
    y_n = sigma * (a * l * l * ca - (l + apex) * sa + 0.25 * np.pi * m)
    x_c, y_c, z_c = to_rack(x_n, y_n, 0.0 * x_n)
    steep = 2.0 * a * l
    size = np.hypot(1.0, steep)
    normal = to_rack((sa - steep * ca) / size, sigma * (ca + steep * sa) / size, 0.0 * l)
    trace = to_rack(0.0 * l, 0.0 * l, 1.0 + 0.0 * l)
    shift = column(member.profile_shift) * m
    return Generated((x_c + shift, y_c, z_c), trace, normal, m * column(member.teeth) / (2.0 * cb))


def turned(vector: Vector, angle: FloatArray) -> Vector:
    """Return the vector rotated by `angle` about z."""
    sin, cos = np.sin(angle), np.cos(angle)
    return cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1], vector[2]


def flank_at(
    member: Member, flank: str, l: FloatArray, u: FloatArray, roll: FloatArray
) -> tuple[Vector, Vector]:
    """Return point and outward unit normal of a rolled flank in the fixed frame of the member (Eqs. 6,
    12)."""
    rack = rack_at(member, flank, l)
    x, y, z = (p + u * t for p, t in zip(rack.point, rack.trace, strict=True))
    nx, ny, _ = rack.normal
    phi = (nx * y - ny * x) / (nx * rack.pitch_radius)
    point = (rack.pitch_radius + x, y - rack.pitch_radius * phi, z)
    return turned(point, phi + roll), turned(rack.normal, phi + roll)


def shaft_angle(design: Design) -> FloatArray:
    """Return the signed shaft angle with its error."""
    first = column(design.pinion.helix_angle)
    total = first + column(design.gear.helix_angle)
    hand = np.where(np.where(np.abs(total) < 1e-9, first, total) < 0.0, -1.0, 1.0)
    return np.asarray(hand * (column(design.pair.shaft_angle) + column(design.errors.shaft_angle)))


def gear_to_fixed(design: Design, vector: Vector) -> Vector:
    """Return a direction of the fixed frame of the gear in S_f: X2 = -x, Y2 = k2 x X2, Z2 = k2."""
    sin, cos = np.sin(shaft_angle(design)), np.cos(shaft_angle(design))
    return -vector[0], sin * vector[2] - cos * vector[1], cos * vector[2] + sin * vector[1]


def residuals(design: Design, path: ContactPath, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return |R1 - R2| (mm) and |n1 + n2| (rad), (..., positions); `distance` (2, ...) are the mounting
    distances without errors."""
    errors, pair = design.errors, design.pair
    point1, normal1 = flank_at(design.pinion, path.flank, path.l1, path.u1, path.pinion_roll)
    point2, normal2 = flank_at(design.gear, path.flank, path.l2, path.u2, path.gear_roll)
    height1 = column(distance[0]) + column(errors.pinion_axial)
    height2 = column(distance[1]) + column(errors.gear_axial)
    x2, y2, z2 = gear_to_fixed(design, (point2[0], point2[1], point2[2] + height2))
    apart = (
        point1[0] - x2 - column(pair.offset) - column(errors.offset),
        point1[1] - y2,
        point1[2] + height1 - z2,
    )
    sums = [n + m for n, m in zip(normal1, gear_to_fixed(design, normal2), strict=True)]
    return np.sqrt(sum(d * d for d in apart)), np.sqrt(sum(s * s for s in sums))


def own_margins(member: Member, flank: str, l: FloatArray, u: FloatArray) -> FloatArray:
    """Return how far (mm) flank points lie inside root (in l), tip, toe and heel, (4, ..., positions).

    The root is the joint with the fillet. Undercut, which may end the flank above it, does not count."""
    tool = member.tool
    m, added = column(tool.normal_module), column(tool.addendum) + column(member.tip_alteration)
    (x, y, z), _ = flank_at(member, flank, l, u, np.zeros_like(l))
    joint = tool.dedendum - tool.tip_radius * (1.0 - np.sin(tool.normal_pressure_angle))
    # A tip radius of 0.38 modules is rounded: its joint lies at the depth of the addendum.
    depth = np.where(np.abs(joint - tool.addendum) < 1e-4, tool.addendum, joint)
    root = at_height(member, -tool.normal_module * depth)
    pitch_radius = m * column(member.teeth) / (2.0 * np.cos(column(member.helix_angle)))
    tip = pitch_radius + (column(member.profile_shift) + added) * m + z * np.tan(column(member.cone_angle))
    half = 0.5 * column(member.face_width)
    return np.stack(np.broadcast_arrays(l - root, tip - np.hypot(x, y), z + half, half - z))


def margins(design: Design, path: ContactPath) -> FloatArray:
    """Return the margins (8, ..., positions) to the limits, in the order of `Limit`."""
    pinion = own_margins(design.pinion, path.flank, path.l1, path.u1)
    gear = own_margins(design.gear, path.flank, path.l2, path.u2)
    return np.stack((pinion, gear), axis=1).reshape(8, *path.l1.shape)


class Lines(NamedTuple):
    """Lines on which flanks of given l1, l2 with one common normal could touch: distance of the two straight
    generators (mm, signed; 0 at a contact), and u1, u2 at their closest points."""

    height: FloatArray
    u1: FloatArray
    u2: FloatArray


def common_normal(first: Generated, second: Generated, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return n_x squared (negative where there is none) and n_y of the common normal in S_f."""
    v1, v2 = first.normal[2], second.normal[2]
    n_y = -(v2 + v1 * np.cos(angle)) / np.sin(angle)
    return np.asarray(1.0 - v1 * v1 - n_y * n_y), np.asarray(n_y)


def generators(
    design: Design, flank: str, l1: FloatArray, l2: FloatArray, sign: float, distance: FloatArray
) -> Lines:
    """Return the generators of both members in S_f under the common normal of `l1` and `l2`.

    `sign` is that of the x component of the normal. All flank points of one l with a given normal lie on a
    straight line. Two lines meet where the triple product with their distance vanishes."""
    d, errors = shaft_angle(design), design.errors
    first, second = rack_at(design.pinion, flank, l1), rack_at(design.gear, flank, l2)
    squared, n_y = common_normal(first, second, d)
    n_x, v1 = sign * np.sqrt(squared), first.normal[2]
    # The gear's normal is -n, seen in its own fixed frame.
    n_y2 = -(np.sin(d) * v1 - np.cos(d) * n_y)
    lines = []
    for rack, fixed in ((first, (n_x, n_y)), (second, (n_x, n_y2))):
        angle = np.arctan2(fixed[1], fixed[0]) - np.arctan2(rack.normal[1], rack.normal[0])
        lean = rack.normal[1] / rack.normal[0]
        x, _, z = rack.point
        tx, _, tz = rack.trace
        foot = turned((rack.pitch_radius + x, lean * x, z), angle)
        lines.append((foot, turned((tx, lean * tx, tz), angle)))
    (p, along_p), (q, along_q) = lines
    height1 = column(distance[0]) + column(errors.pinion_axial)
    height2 = column(distance[1]) + column(errors.gear_axial)
    p = (p[0], p[1], p[2] + height1)
    q, along_q = gear_to_fixed(design, (q[0], q[1], q[2] + height2)), gear_to_fixed(design, along_q)
    between = (q[0] + column(design.pair.offset) + column(errors.offset) - p[0], q[1] - p[1], q[2] - p[2])
    square = _cross(along_p, along_q)
    size = _dot(square, square)
    return Lines(
        _dot(between, square) / np.sqrt(size),
        _dot(_cross(between, along_q), square) / size,
        _dot(_cross(between, along_p), square) / size,
    )


def _dot(a: Vector, b: Vector) -> FloatArray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


class Found(NamedTuple):
    """Contacts found by a search, one row each: case, flank parameters, sign of the x component of the common
    normal, and smallest margin (mm) to the limits of both flanks."""

    case: Cases
    l1: FloatArray
    l2: FloatArray
    sign: FloatArray
    margin: FloatArray

    def beyond(self, margin: float) -> Found:
        """Return the contacts further inside the flanks than `margin` (mm)."""
        kept = self.margin > margin
        return Found(*(column[kept] for column in self))  # type: ignore[arg-type]


PASSES, PRUNED = 45, 10
"""Number of bisections of an interval, and number after which a root far off the flanks is left out."""


def at_height(member: Member, height: Quantity) -> FloatArray:
    """Return l at which the tool flank of the batch has x_n = `height` (mm), (..., 1)."""
    alpha, a = column(member.tool.normal_pressure_angle), column(member.tool.parabola)
    # x_n = l cos(alpha) + a l^2 sin(alpha): the root that stays finite without parabola.
    root = np.sqrt(np.cos(alpha) ** 2 + 4.0 * a * np.sin(alpha) * column(height))
    return np.asarray(2.0 * column(height) / (np.cos(alpha) + root))


def flank_grid(member: Member, points: int) -> FloatArray:
    """Return l over the complete active flank, ends included, (..., points)."""
    tool = member.tool
    low = at_height(member, -tool.normal_module * np.asarray(tool.addendum))
    high = at_height(member, tool.normal_module * np.asarray(tool.addendum))
    return np.asarray(low + (high - low) * np.linspace(0.0, 1.0, points))


def search(design: Design, flank: str, distance: FloatArray, points: int = 32, turned: bool = False) -> Found:
    """Return the contacts on a grid of l1, for both signs of n_x, with l2 by sign change and bisection.

    `turned` searches on a grid of l2 instead. Contacts further than half a module outside the flanks are
    omitted. Array designs of one batch axis only."""
    first, second = (flank_grid(member, points) for member in design.members)
    l1 = np.repeat(first, points, axis=-1) if not turned else np.tile(first, (1, points))
    l2 = np.tile(second, (1, points)) if not turned else np.repeat(second, points, axis=-1)
    grid = np.stack((l1, l2)).reshape(2, -1, points, points)
    moving = grid[0 if turned else 1]
    parts = []
    for sign in (1.0, -1.0):
        scan = Scan(design, flank, distance, sign, turned)
        with np.errstate(all="ignore"):
            height = generators(design, flank, l1, l2, sign, distance).height.reshape(grid.shape[1:])
        real = np.isfinite(height)
        case, row, cell = np.nonzero(height[..., :-1] * height[..., 1:] < 0.0)
        fixed = grid[1 if turned else 0][case, row, cell]
        bounds = [(moving[case, row, cell + k], height[case, row, cell + k]) for k in (0, 1)]
        parts.append(_refined(scan, case, fixed, bounds))
        # Between the last node with a common normal and the place where it vanishes.
        case, row, cell = np.nonzero(real[..., :-1] != real[..., 1:])
        ahead = real[case, row, cell + 1].astype(int)
        fixed = grid[1 if turned else 0][case, row, cell]
        good, bad = moving[case, row, cell + ahead], moving[case, row, cell + 1 - ahead]
        edge, at_edge = _edge(scan, case, fixed, good, bad)
        start = height[case, row, cell + ahead]
        crossed = np.flatnonzero(start * at_edge < 0.0)
        bounds = [(good[crossed], start[crossed]), (edge[crossed], at_edge[crossed])]
        parts.append(_refined(scan, case[crossed], fixed[crossed], bounds))
    return joined(parts)


class Scan(NamedTuple):
    """Variables of a search: one flank and one sign of n_x, with l2 varied at fixed l1, or the reverse if
    `turned`."""

    design: Design
    flank: str
    distance: FloatArray
    sign: float
    turned: bool

    def both(self, moving: FloatArray, fixed: FloatArray) -> tuple[FloatArray, FloatArray]:
        return (moving[:, None], fixed[:, None]) if self.turned else (fixed[:, None], moving[:, None])

    def lines(self, case: Cases, moving: FloatArray, fixed: FloatArray) -> Lines:
        part = cases_of(self.design, case)
        with np.errstate(all="ignore"):
            return generators(part, self.flank, *self.both(moving, fixed), self.sign, self.distance[:, case])


def joined(parts: list[Found]) -> Found:
    """Return the contacts of several searches."""
    return Found(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _edge(
    scan: Scan, case: Cases, fixed: FloatArray, good: FloatArray, bad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the last position with a common normal between a `good` and a `bad` one, and the
    distance there."""
    part = cases_of(scan.design, case)
    for _ in range(50):
        middle = 0.5 * (good + bad)
        l1, l2 = scan.both(middle, fixed)
        racks = rack_at(part.pinion, scan.flank, l1), rack_at(part.gear, scan.flank, l2)
        real = common_normal(*racks, shaft_angle(part))[0][:, 0] > 0.0
        good, bad = np.where(real, middle, good), np.where(real, bad, middle)
    return good, scan.lines(case, good, fixed).height[:, 0]


def _refined(
    scan: Scan, case: Cases, fixed: FloatArray, bounds: list[tuple[FloatArray, FloatArray]]
) -> Found:
    """Return the roots between `bounds` (position and distance), by bisection from the secant."""
    (low, f_low), (high, f_high) = bounds
    guess = low - f_low * (high - low) / (f_high - f_low)
    module = np.broadcast_to(scan.design.pinion.tool.normal_module, scan.distance.shape[1:])
    for step in range(PASSES):
        lines, (l1, l2) = scan.lines(case, guess, fixed), scan.both(guess, fixed)
        height = lines.height[:, 0]
        if step in (PRUNED, PASSES - 1):
            pinion, gear = cases_of(scan.design, case).members
            with np.errstate(all="ignore"):
                each = (
                    own_margins(pinion, scan.flank, l1, lines.u1),
                    own_margins(gear, scan.flank, l2, lines.u2),
                )
            margin = np.concatenate(each).min(axis=0)[:, 0]
            near = margin > (-0.5 * module[case] if step == PRUNED else -np.inf)
            values = (case, fixed, low, high, f_low, guess, margin, height)
            case, fixed, low, high, f_low, guess, margin, height = (value[near] for value in values)
        if step == PASSES - 1:
            break
        above = np.signbit(height) == np.signbit(f_low)
        low, high = np.where(above, guess, low), np.where(above, high, guess)
        guess = 0.5 * (low + high)
    l1, l2 = (guess, fixed) if scan.turned else (fixed, guess)
    return Found(case, l1, l2, np.full(case.shape, scan.sign), margin)


def mapped(change: Callable[..., Any], *parts: Any) -> Any:
    """Return a dataclass whose numbers are computed by `change` from those of `parts`."""
    values = {}
    for item in fields(parts[0]):
        column = [getattr(part, item.name) for part in parts]
        if hasattr(column[0], "__dataclass_fields__"):
            values[item.name] = mapped(change, *column)
        else:
            kept = column[0] is None or isinstance(column[0], str)
            values[item.name] = column[0] if kept else change(*column)
    return type(parts[0])(**values)


def cases_of(part: Any, index: Any) -> Any:
    """Return the cases `index` of an array design of one batch axis, or of any of its parts."""
    return mapped(lambda value: value[index] if np.ndim(value) else value, part)


def batch_of_one(part: Any) -> Any:
    """Return a single design, or any of its parts, as a batch of one."""
    return mapped(lambda value: np.array([value], dtype=float), part)


def off_path(path: ContactPath, found: Found) -> FloatArray:
    """Return the distance (mm) of contacts from the paths (cases, positions) in the plane of l1 and l2."""
    across = np.stack((path.l1, path.l2), axis=-1)[found.case]
    steps = np.diff(across, axis=1)
    seen = np.stack((found.l1, found.l2), axis=-1)[:, None] - across[:, :-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.einsum("ijk,ijk->ij", seen, steps) / np.einsum("ijk,ijk->ij", steps, steps)
    rest = seen - np.clip(np.nan_to_num(share), 0.0, 1.0)[..., None] * steps
    return np.asarray(np.linalg.norm(rest, axis=-1).min(axis=-1))
