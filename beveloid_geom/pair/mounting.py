"""Where the members stand: pitch point, mounting distances, working radii, backlash.

Without parabola the normal of a flank is the same in all its points. The common normal of a
flank pair is then fixed in space and the contact runs along one straight line, the line of
action, tangent to both base cylinders. It depends on offset, shaft angle and flanks alone,
not on the axial positions. The pitch point P lies where the lines of the right and of the
left flanks meet; its axial coordinates are the mounting distances d_w1, d_w2, its distances
from the axes the working radii r_w1, r_w2 (Fig. 4). Real designs are rounded and the lines
pass each other: P is the middle of their closest approach, the gap is reported.

The x component n_x of a common normal is known up to its sign, which belongs to the design:
positive on both flanks of ordinary pairs, negative on one flank where steep cones carry the
pitch point far off the common perpendicular, and where the axes intersect. The two normals are
sin(a_w) N +/- cos(a_w) b with N the normal of the working pitch plane, out of the pinion. P
lies along N from the pinion's axis and against it from the gear's: with the radii p_1, p_2 from the axes
to P, and its axial coordinates z_1, z_2,

    (p_1 - p_2).N = E N_x - z_1 N.k1 + z_2 N.k2 > 0.

Without cones that is N_x > 0; where the axes intersect the false signs put P beyond their common point.
Of the signs that allow this, those that bring the two lines closer are right.

On parallel axes unmodified flanks touch along lines in planes of action that all pass through one pitch line:
what P is along the axes is free. It lies midway between the mid-faces, which stand against each other
unless mounting distances are given; then but their difference matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray, Quantity
from ..design.model import Design, Errors, Member, Pair
from ..gear.rack import rack_of
from ..support.read_only import kept, restored
from .frames import Layout, layout_by_case, layout_of, normal_of_unmodified


@dataclass(frozen=True, eq=False)
class Mounting:
    """Layout of the unmodified pair without errors; arrays of the design's batch shape.

    `distance` (2, ...): mid-face of pinion and gear along their axes, given by the design or
    taken from the pitch point; `working_radius` (2, ...); `pitch_distance` (2, ...): axial
    coordinates of the pitch point; `pitch_point` (..., 3) in S_f; `gap`: least distance of
    the two lines of action; `normal_backlash`: clearance along the normal, reduced to half a
    pitch either way, negative for interference; all mm. `branch` (2, ...): sign of n_x on
    the right and on the left flank. NaN where the pair has no common normal."""

    distance: FloatArray
    working_radius: FloatArray
    pitch_distance: FloatArray
    pitch_point: FloatArray
    gap: FloatArray
    normal_backlash: FloatArray
    branch: FloatArray

    __setstate__ = restored


@dataclass(frozen=True, eq=False)
class _Action:
    """Line of action of an unmodified flank pair, points `foot + t normal` (..., 3), and its
    constant `phase`, the gear's roll plus N1/N2 times the pinion's (rad), at given mounting."""

    foot: FloatArray
    normal: FloatArray
    phase: FloatArray


def across_action(
    layout: Layout, axial: FloatArray, square: FloatArray, normal_y: FloatArray, moment: FloatArray
) -> FloatArray:
    """Find `n_x w_j` (2, ...): where the line of action crosses the members' planes of action.

    A contact normal n lies in the plane of action of member j, parallel to k_j and n at the
    distance g_j / S_j from the axis, with g_j = r_P n_y (`moment`) and S_j = sqrt(1 - v_j^2)
    (`square`). w_j is the coordinate in that plane along (k_j - v_j n_j) / S_j, from the foot
    of the common perpendicular. (R x n).k1 = g1 and ((R - E i) x n).k2 = -g2 together give

        n_x w_1 = -[S_1 (g_2 - E n_y2) + g_1 K / S_1] / sin d,   K = cos d + v_1 v_2.

    The same with 1 and 2 exchanged gives w_2. Rounding enters either by E / (n_x sin d), which
    near n_x = 0 or d = 0 would part the points of the two members; w_2 is therefore taken from
    w_1, as the point of the pinion seen from the gear:

        n_x w_2 = [K n_x w_1 / S_1 - n_x^2 (E v_2 + g_1 sin d / S_1^2)] / S_2.

    The products stay regular where n_x vanishes."""
    seen = moment[1] - layout.offset * normal_y[1]
    shared = layout.cos_angle + axial[0] * axial[1]
    x_squared = 1.0 - axial[0] * axial[0] - normal_y[0] * normal_y[0]
    first = -(square[0] * seen + moment[0] / square[0] * shared) / layout.sin_angle
    return np.array((first, across_of_gear(layout, axial, square, moment, first, x_squared)))


def across_of_gear(
    layout: Layout, axial: FloatArray, square: FloatArray, moment: FloatArray, first: Any, normal_x: Any
) -> Any:
    """Find w_2 from w_1 (`first`) and n_x; n_x w_2 from n_x w_1 and n_x^2: see `across_action`."""
    shared = layout.cos_angle + axial[0] * axial[1]
    side = layout.offset * axial[1] + moment[0] / (square[0] * square[0]) * layout.sin_angle
    return (shared / square[0] * first - normal_x * side) / square[1]


def _action(layout: Layout, members: Member, flank: str, sign: float, distance: FloatArray) -> _Action:
    rack = rack_of(members, flank)
    nx, ny, v = rack.normal
    x0, y0, z0 = rack.apex
    moment, square = rack.pitch_radius * ny, np.sqrt(1.0 - v * v)
    normal = normal_of_unmodified(layout, v, moment)
    fx, fy = sign * np.sqrt(normal.x_squared), normal.y
    w = across_action(layout, v, square, fy, moment)[0] / fx
    # Foot: w along (k1 - v1 n) / S1 and g1/S1 along (n x k1) / S1.
    reach, arm = w * v[0] / square[0], moment[0] / square[0] ** 2
    foot = (arm * fy[0] - reach * fx, -arm * fx - reach * fy[0], w * square[0])
    turned = np.arctan2(fy * nx - fx * ny, fx * nx + fy * ny)
    drawn = nx * (rack.pitch_radius + x0) + ny * y0 + v * (z0 + distance)
    phase = (
        turned[1] + moment[0] / moment[1] * turned[0] + (layout.offset * fx - drawn[0] - drawn[1]) / moment[1]
    )
    return _Action(np.stack(foot, axis=-1), np.stack(np.broadcast_arrays(fx, fy[0], v[0]), axis=-1), phase)


def _closest(first: _Action, second: _Action) -> tuple[FloatArray, FloatArray]:
    """Find the middle (..., 3) and signed length of the common perpendicular of two lines of action."""
    across = np.cross(first.normal, second.normal)
    size = np.linalg.norm(across, axis=-1)
    between = second.foot - first.foot
    s = np.einsum("...i,...i", np.cross(between, second.normal), across) / size**2
    t = np.einsum("...i,...i", np.cross(between, first.normal), across) / size**2
    middle = 0.5 * (first.foot + s[..., None] * first.normal + second.foot + t[..., None] * second.normal)
    return middle, np.einsum("...i,...i", between, across) / size


LEAST_PRESSURE = 0.25
"""Share of the sine of the tool's pressure angle that the working one must have. Lines of action with
opposite signs of n_x are nearly parallel for small cone angles: they pass close by each other, but not at
a pitch point."""
SIGNS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0))
"""Signs of n_x on the right and the left flank that can occur."""


def _along_axes(layout: Layout, point: FloatArray) -> FloatArray:
    """Find the axial coordinates (2, ...) of points (..., 3) of S_f, mm."""
    return np.stack([point[..., 2], layout.sin_angle * point[..., 1] + layout.cos_angle * point[..., 2]])


def _pitch_point(layout: Layout, members: Member) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find the pitch point (cases, 1, 3), gap (cases, 1) and branches (2, cases, 1)."""
    none = np.zeros_like(members.helix_angle)
    pairs = [
        (_action(layout, members, "right", r, none), _action(layout, members, "left", s, none))
        for r, s in SIGNS
    ]
    points, gaps = zip(*(_closest(*pair) for pair in pairs), strict=True)
    sums = [pair[0].normal + pair[1].normal for pair in pairs]  # 2 sin(a_w) N
    axial = rack_of(members, "right").normal[2] + rack_of(members, "left").normal[2]
    pitches = [_along_axes(layout, point) for point in points]
    least = 2.0 * LEAST_PRESSURE * np.sin(np.asarray(members.tool.normal_pressure_angle)[0])
    cost = [
        np.where(
            # Radius of the pinion less that of the gear, along N; false also of NaN.
            (layout.offset * total[..., 0] - np.sum(place * axial, axis=0) > 0.0)
            & (np.linalg.norm(total, axis=-1) > least),
            np.abs(gap),
            np.inf,
        )
        for total, gap, place in zip(sums, gaps, pitches, strict=True)
    ]
    best = np.argmin(cost, axis=0)
    gap = np.take_along_axis(np.stack(gaps), best[None], axis=0)[0]
    point = np.take_along_axis(np.stack(points), best[None, ..., None], axis=0)[0]
    return point, gap, np.moveaxis(np.array(SIGNS)[best], -1, 0)


def _on_parallel_axes(
    layout: Layout, members: Member, given: list[FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the same on parallel axes; NaN where they have no common normal. All planes of action pass through
    the pitch line, which parts the offset as N1 to N2. The point on it lies midway between the mid-faces
    where these are `given` (cases, 1), else at z = 0."""
    lost = np.zeros(layout.parallel.shape)
    for flank in ("right", "left"):
        rack = rack_of(members, flank)
        normal = normal_of_unmodified(layout, rack.normal[2], rack.pitch_radius * rack.normal[1])
        lost = lost + np.where(normal.x_squared > 0.0, 0.0, np.nan)
    first, second = np.asarray(members.teeth)
    middle = sum(given) / len(given) if given else 0.0
    point = np.stack(np.broadcast_arrays(layout.offset * first / (first + second), lost, middle), axis=-1)
    return point + lost[..., None], lost, np.ones((2, *lost.shape))


def _backlash(layout: Layout, members: Member, branch: FloatArray, distance: FloatArray) -> FloatArray:
    """Find the normal backlash (cases, 1), reduced to half a pitch either way, mm."""
    right, left = (
        _action(layout, members, flank, sign, distance).phase
        for flank, sign in zip(("right", "left"), branch, strict=True)
    )
    tool, teeth = members.tool, np.asarray(members.teeth)[1]
    lever = 0.5 * np.asarray(tool.normal_module)[1] * teeth * np.cos(tool.normal_pressure_angle)[1]
    return np.asarray(lever * half_pitch(right - left, 2.0 * np.pi / teeth))


def half_pitch(value: Quantity, pitch: Quantity) -> FloatArray:
    """Give a value less whole pitches, within half a pitch either way."""
    return np.asarray(np.remainder(value + 0.5 * pitch, pitch) - 0.5 * pitch)


def unmodified_backlash(design: Design) -> FloatArray:
    """Find the normal backlash (mm, batch shape) of the flanks without parabolas, endless along depth and
    face, with the errors of the design: followed from that of the layout, half a pitch at the most. NaN
    where a side has no common normal."""
    mounting, shape = mounting_of(design), design.batch_shape
    plain = design.with_parabola(0.0, 0.0)
    members, errors = plain.stacked_members(), plain.errors
    layout, branch = layout_by_case(layout_of(plain), shape), np.empty((2, *shape))
    moved = np.empty((2, *shape))
    branch[0], branch[1] = mounting.branch[0], mounting.branch[1]
    moved[0], moved[1] = mounting.distance[0] + errors.pinion_axial, mounting.distance[1] + errors.gear_axial
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        found = _backlash(layout, members, branch.reshape(2, -1, 1), moved.reshape(2, -1, 1)).reshape(shape)
    tool, own = design.gear.tool, mounting.normal_backlash
    pitch = np.pi * tool.normal_module * np.cos(tool.normal_pressure_angle)
    return np.asarray(own + half_pitch(found - own, pitch))


def _mounting(design: Design) -> Mounting:
    design = design.with_parabola(0.0, 0.0)
    members, shape = design.stacked_members(), design.batch_shape
    layout = layout_by_case(layout_of(design), shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        given = {
            member: np.broadcast_to(distance, shape).reshape(-1, 1)
            for member, distance in enumerate((design.pair.pinion_mounting, design.pair.gear_mounting))
            if distance is not None
        }
        point, gap, branch = _pitch_point(layout, members)
        if (parallel := layout.parallel).any():
            own = _on_parallel_axes(layout, members, list(given.values()))
            point = np.where(parallel[..., None], own[0], point)
            gap, branch = np.where(parallel, own[1], gap), np.where(parallel, own[2], branch)
        x, y, z = np.moveaxis(point, -1, 0)
        sin, cos = layout.sin_angle, layout.cos_angle
        pitch = _along_axes(layout, point)
        radius = np.stack([np.hypot(x, y), np.hypot(x - layout.offset, cos * y - sin * z)])
        distance = pitch.copy()
        for member, value in given.items():
            distance[member] = value
        backlash = _backlash(layout, members, branch, distance)
    return Mounting(
        distance=distance.reshape(2, *shape),
        working_radius=radius.reshape(2, *shape),
        pitch_distance=pitch.reshape(2, *shape),
        pitch_point=point.reshape(*shape, 3),
        gap=gap.reshape(shape),
        normal_backlash=backlash.reshape(shape),
        branch=branch.reshape(2, *shape),
    )


@kept(64)
def _kept_mounting(pinion: Member, gear: Member, pair: Pair) -> Mounting:
    return _mounting(Design(pinion, gear, pair))


def mounting_of(design: Design) -> Mounting:
    """Give the mounting of a design, from its unmodified flanks and without its errors.

    Array quantities broadcast. The answer for a design of plain numbers is kept, as it is
    asked for by every path computed on it."""
    if design.batch_shape and (bare := design.with_errors(Errors())).batch_shape:
        return _mounting(bare)
    return _kept_mounting(design.pinion, design.gear, design.pair)
