"""Pitch point, mounting distances, working radii and backlash of a pair.

Without a parabola the rack generates all points of a flank with the same normal. The axial component of the
normal of the flank and its moment about the axis are therefore constant. The common normal of a flank pair
is then fixed in space, and the contact moves along one straight line, the line of action, tangent to both
base cylinders. It depends on offset, shaft angle and flanks only, not on the axial positions. The pitch
point P is the intersection of the lines of action of right and left flanks. Its axial coordinates are the
mounting distances d_w1, d_w2, and its distances from the axes the working radii r_w1, r_w2 (Fig. 4). If the
numbers of a design are rounded, the lines pass each other at a distance. P is then the middle of their
closest approach, and this gap is reported.

n_x, the component of a common normal along the common perpendicular, is known up to its sign, which is a
property of the design: positive on both flanks of ordinary pairs, negative on one flank if steep cones move
the pitch point far off the common perpendicular, and if the axes intersect. The two normals are sin(a_w) N
+/- cos(a_w) b, with the working normal pressure angle a_w. N is the normal of the working pitch plane, out
of the pinion; b lies in this plane, perpendicular to the tooth trace. P lies in the direction N from the
pinion axis and in the direction -N from the gear axis. With the radii p_1, p_2 from the axes to P and the
axial coordinates z_1, z_2 of P,

    (p_1 - p_2).N = E N_x - z_1 N.k1 + z_2 N.k2 > 0.

Without cones this is N_x > 0; if the axes intersect, wrong signs place P beyond their common point. Among
the signs that satisfy this condition, those with the smaller gap are correct.

On parallel axes unmodified flanks touch along lines in planes of action that all pass through one pitch
line, so that the position of P along the axes is free. P is midway between the mid-faces, which face each
other unless mounting distances are given. Only the difference of given mounting distances matters then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray, Quantity
from ..design.member import Member
from ..design.model import Design, Pair
from ..gear.rack import Rack, rack_of
from ..support.frozen_arrays import cached, restored
from .frames import CommonNormal, Layout, common_normal, layout_by_case, normal_of_unmodified


@dataclass(frozen=True, eq=False)
class Mounting:
    """Layout of the unmodified pair without errors; arrays of the batch shape of the design.

    `distance` (2, ...): position of the mid-faces of pinion and gear along their axes, given by the design or
    computed from the pitch point; `working_radius` (2, ...); `pitch_distance` (2, ...): axial coordinates of
    the pitch point; `pitch_point` (..., 3) in S_f; `gap`: least distance from the line of action of the right
    flanks to that of the left flanks, positive along n_right x n_left; `normal_backlash`: clearance along the
    normal, reduced to plus/minus half a pitch, negative for interference; all in mm. `branch`
    (2, ...): sign of n_x on the right and on the left flank. NaN where the pair has no common normal.
    """

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
    """Line of action of an unmodified flank pair.

    Its points are `foot + t normal` (..., 3). `phase` is the constant gear roll plus N1/N2 times the pinion
    roll (rad) at given mounting distances.
    """

    foot: FloatArray
    normal: FloatArray
    phase: FloatArray


def across_action(
    layout: Layout, axial: FloatArray, square: FloatArray, normal: CommonNormal, moment: FloatArray
) -> FloatArray:
    """Return `n_x w_j` (2, ...), which locates the line of action in the planes of action of both members.

    A contact normal n lies in the plane of action of member j. This plane is parallel to k_j and n, at the
    distance g_j / S_j from the axis, with g_j = r_P n_y (`moment`) and S_j = sqrt(1 - v_j^2) (`square`). w_j
    is the coordinate in this plane along (k_j - v_j n_j) / S_j, from the foot of the common perpendicular.
    With a point R of the line of action, the unit vector i along the common perpendicular and the outward
    normals n_1 = n, n_2 = -n, (R x n).k1 = g1 and ((R - E i) x n).k2 = -g2 give

        n_x w_1 = -[S_1 (g_2 - E n_y2) + g_1 K / S_1] / sin d,   K = cos d + v_1 v_2.

    Exchanging 1 and 2 gives w_2. Rounding enters both with the factor E / (n_x sin d), which would separate
    the points of the two members near n_x = 0 or d = 0. Therefore w_2 is computed from w_1, as the point of
    the pinion seen from the gear:

        n_x w_2 = [K n_x w_1 / S_1 - n_x^2 (E v_2 + g_1 sin d / S_1^2)] / S_2.

    The products are regular where n_x vanishes.
    """
    seen = moment[1] - layout.offset * normal.y[1]
    shared = layout.cos_angle + axial[0] * axial[1]
    first = -(square[0] * seen + moment[0] / square[0] * shared) / layout.sin_angle
    return np.array((first, across_of_gear(layout, axial, square, moment, first, normal.x_squared)))


def across_of_gear(
    layout: Layout, axial: FloatArray, square: FloatArray, moment: FloatArray, first: Any, normal_x: Any
) -> Any:
    """Return w_2 from w_1 (`first`) and n_x, or n_x w_2 from n_x w_1 and n_x^2; see `across_action`."""
    shared = layout.cos_angle + axial[0] * axial[1]
    side = layout.offset * axial[1] + moment[0] / (square[0] * square[0]) * layout.sin_angle
    return (shared / square[0] * first - normal_x * side) / square[1]


def normal_of_flanks(
    layout: Layout, members: Sequence[Member], flank: str
) -> tuple[CommonNormal, FloatArray]:
    """Return the common normal of the unmodified flanks of pinion and gear, as by `normal_of_unmodified`, and
    the axial components (2, ...) of their normals.
    """
    racks = [rack_of(member, flank) for member in members]
    axial = np.array([rack.normal[2] for rack in racks])
    moment = np.array([rack.pitch_radius * rack.normal[1] for rack in racks])
    return normal_of_unmodified(layout, axial, moment), axial


def _action(layout: Layout, members: Member, flank: str, sign: float, distance: FloatArray) -> _Action:
    rack = rack_of(members, flank)
    _, ny, v = rack.normal
    moment, square = rack.pitch_radius * ny, np.sqrt(1.0 - v * v)
    normal = normal_of_unmodified(layout, v, moment)
    fx, fy = sign * np.sqrt(normal.x_squared), normal.y
    w = across_action(layout, v, square, normal, moment)[0] / fx
    # Foot of the line: w along (k1 - v1 n) / S1 and g1/S1 along (n x k1) / S1.
    reach, arm = w * v[0] / square[0], moment[0] / square[0] ** 2
    foot = (arm * fy[0] - reach * fx, -arm * fx - reach * fy[0], w * square[0])
    phase = _phase(layout, rack, fx, fy, distance)
    return _Action(np.stack(foot, axis=-1), np.stack(np.broadcast_arrays(fx, fy[0], v[0]), axis=-1), phase)


def _phase(
    layout: Layout, rack: Rack, normal_x: FloatArray, normal_y: FloatArray, distance: FloatArray
) -> FloatArray:
    """Return the gear roll plus N1/N2 times the pinion roll (rad) of a pair with this common normal, of which
    only the direction (n_x, n_y) is used.
    """
    (nx, ny, v), (x0, y0, z0) = rack.normal, rack.apex
    moment = rack.pitch_radius * ny
    turned = np.arctan2(normal_y * nx - normal_x * ny, normal_x * nx + normal_y * ny)
    drawn = nx * (rack.pitch_radius + x0) + ny * y0 + v * (z0 + distance)
    lever = (layout.offset * normal_x - drawn[0] - drawn[1]) / moment[1]
    return np.asarray(turned[1] + moment[0] / moment[1] * turned[0] + lever)


def limit_phase(design: Design, flank: str) -> FloatArray:
    """Return the phase of an unmodified pair whose flanks have no common normal.

    n_x, the x component of the common normal, is set to its limit 0, so that the phase is continuous where
    the common normal ceases to exist.

    Parameters
    ----------
    design : Design
        Parabolas and errors are ignored.
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        Gear roll plus N1/N2 times the pinion roll, rad, of the batch shape. NaN without mounting distances.
    """
    plain = design.bare()
    mounting, shape = mounting_of(plain), plain.batch_shape
    members, layout = plain.stacked_members(), layout_by_case(plain)
    rack = rack_of(members, flank)
    distance = np.empty((2, *shape))
    distance[0], distance[1] = mounting.distance
    branch = np.broadcast_to(mounting.branch[0 if flank == "right" else 1], shape).reshape(-1, 1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        normal = common_normal(layout, rack.normal[2])
        normal_x = branch * np.sqrt(np.maximum(normal.x_squared, 0.0))
        normal_y = np.where(normal.x_squared > 0.0, normal.y, np.sign(normal.y))
        return _phase(layout, rack, normal_x, normal_y, distance.reshape(2, -1, 1)).reshape(shape)


def _closest(first: _Action, second: _Action) -> tuple[FloatArray, FloatArray]:
    """Return the middle (..., 3) and the signed length of the common perpendicular of two lines of action."""
    across = np.cross(first.normal, second.normal)
    size = np.linalg.norm(across, axis=-1)
    between = second.foot - first.foot
    s = np.einsum("...i,...i", np.cross(between, second.normal), across) / size**2
    t = np.einsum("...i,...i", np.cross(between, first.normal), across) / size**2
    middle = 0.5 * (first.foot + s[..., None] * first.normal + second.foot + t[..., None] * second.normal)
    return middle, np.einsum("...i,...i", between, across) / size


def _along_axes(layout: Layout, point: FloatArray) -> FloatArray:
    """Return the axial coordinates (2, ...) of points (..., 3) of S_f, mm."""
    return np.stack([point[..., 2], layout.sin_angle * point[..., 1] + layout.cos_angle * point[..., 2]])


def _pitch_point(layout: Layout, members: Member) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the pitch point (cases, 1, 3), gap (cases, 1) and signs of n_x (2, cases, 1)."""
    # Lower limit of the sine of the working pressure angle, relative to that of the tool. For small
    # cone angles, lines of action with opposite signs of n_x are nearly parallel: they pass each other
    # closely, but not at a pitch point.
    least_pressure_ratio = 0.25
    # Possible signs of n_x on the right and the left flank.
    normal_x_signs = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0))
    # Lines of action for all possible signs of n_x, and the middle of their closest approach.
    none = np.zeros_like(members.helix_angle)
    pairs = [
        (_action(layout, members, "right", r, none), _action(layout, members, "left", s, none))
        for r, s in normal_x_signs
    ]
    points, gaps = zip(*(_closest(*pair) for pair in pairs), strict=True)
    sums = [pair[0].normal + pair[1].normal for pair in pairs]  # 2 sin(a_w) N
    axial = rack_of(members, "right").normal[2] + rack_of(members, "left").normal[2]
    pitches = [_along_axes(layout, point) for point in points]
    least = 2.0 * least_pressure_ratio * np.sin(np.asarray(members.tool.normal_pressure_angle)[0])
    # The condition of the module docstring; among the remaining signs the smallest gap.
    cost = [
        np.where(
            # (p_1 - p_2).N > 0, and false for NaN.
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
    return point, gap, np.moveaxis(np.array(normal_x_signs)[best], -1, 0)


def _on_parallel_axes(
    layout: Layout, members: Member, given: list[FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return pitch point, gap and signs of n_x on parallel axes; NaN without a common normal.

    All planes of action pass through the pitch line, which divides the offset in the ratio N1 to N2. The
    point on it is midway between the mid-faces if these are `given` (cases, 1), else at z = 0.
    """
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
    """Return the normal backlash (cases, 1), reduced to plus/minus half a pitch, mm."""
    right, left = (
        _action(layout, members, flank, sign, distance).phase
        for flank, sign in zip(("right", "left"), branch, strict=True)
    )
    tool, teeth = members.tool, np.asarray(members.teeth)[1]
    lever = 0.5 * np.asarray(tool.normal_module)[1] * teeth * np.cos(tool.normal_pressure_angle)[1]
    return np.asarray(lever * within_half_pitch(right - left, 2.0 * np.pi / teeth))


def within_half_pitch(value: Quantity, pitch: Quantity) -> FloatArray:
    """Return a value reduced by multiples of the pitch to plus/minus half a pitch."""
    return np.asarray(np.remainder(value + 0.5 * pitch, pitch) - 0.5 * pitch)


def unmodified_backlash(design: Design) -> FloatArray:
    """Return the normal backlash of the unmodified flanks, with the errors of the design.

    Parabolas and modifications are removed. The flanks are extended beyond tip, root, toe and heel.

    Parameters
    ----------
    design : Design

    Returns
    -------
    ndarray
        mm, of the batch shape. It differs from the backlash of the layout by at most half a pitch. NaN where
        one side has no common normal.
    """
    mounting, shape = mounting_of(design), design.batch_shape
    plain = design.unmodified()
    members, errors = plain.stacked_members(), plain.errors
    layout, branch = layout_by_case(plain), np.empty((2, *shape))
    moved = np.empty((2, *shape))
    branch[0], branch[1] = mounting.branch[0], mounting.branch[1]
    moved[0], moved[1] = mounting.distance[0] + errors.pinion_axial, mounting.distance[1] + errors.gear_axial
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        result = _backlash(layout, members, branch.reshape(2, -1, 1), moved.reshape(2, -1, 1)).reshape(shape)
    # Follow the backlash of the layout continuously, not modulo a pitch.
    tool, layout_backlash = design.gear.tool, mounting.normal_backlash
    pitch = np.pi * tool.normal_module * np.cos(tool.normal_pressure_angle)
    return np.asarray(layout_backlash + within_half_pitch(result - layout_backlash, pitch))


def _mounting(design: Design) -> Mounting:
    """Return the mounting of an unmodified design."""
    members, shape = design.stacked_members(), design.batch_shape
    layout = layout_by_case(design)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # Mounting distances of the design replace those of the pitch point.
        given = {
            member: np.broadcast_to(distance, shape).reshape(-1, 1)
            for member, distance in enumerate((design.pair.pinion_mounting, design.pair.gear_mounting))
            if distance is not None
        }
        point, gap, branch = _pitch_point(layout, members)
        if (parallel := layout.parallel).any():
            on_parallel = _on_parallel_axes(layout, members, list(given.values()))
            point = np.where(parallel[..., None], on_parallel[0], point)
            gap, branch = np.where(parallel, on_parallel[1], gap), np.where(parallel, on_parallel[2], branch)
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


@cached(64)
def _cached_mounting(pinion: Member, gear: Member, pair: Pair) -> Mounting:
    # Designs that differ in their modifications share the mounting of the unmodified one.
    plain = Design(pinion, gear, pair).unmodified()
    if plain.members == (pinion, gear):
        return _mounting(plain)
    return _cached_mounting(*plain.members, pair)


def mounting_of(design: Design) -> Mounting:
    """Return the mounting of a design, computed from its unmodified flanks and without its errors.

    Parameters
    ----------
    design : Design
        Array quantities broadcast. Results of single designs are cached.

    Returns
    -------
    Mounting
    """
    if design.batch_shape and (design := design.bare()).batch_shape:
        return _mounting(design)
    return _cached_mounting(design.pinion, design.gear, design.pair)
