"""Separation of two flanks at a pose: how far the other member turns until a point meets it.

Every point of one member's flank moves, seen from the other member, along a circle about that
member's axis when this one turns. In the other's frame the point has a radius r, an axial
coordinate z and an angle theta. The other's flank has one point at this r in this plane z
(`tooth_side`), at the angle theta_f, and

    sigma (theta - theta_f) = clearance (rad) of the other member at this point,

positive while there is clearance, negative where the point stands in the other's metal. Both
members see each other in the same way, so that one formula does for either.

Along the normal the clearance is this angle times the moment of the other's unit normal about
its axis, |r_P n_y|. Without parabola that is m_n N cos(alpha) / 2 everywhere on the flank, a
turned involute helicoid is its own parallel surface, and the distance is exact, to the flank
and its extension. With a parabola, and on a fillet, it is right to first order in the gap.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, Integers, Mask
from ..design.field_limits import float64_of
from ..design.model import Design
from ..gear.rack import Numbers
from ..gear.tooth_side import Surface, cut_at, profile_at, surface_of as surface_of
from ..pair.frames import layout_of
from ..pair.mounting import mounting_of
from ..support.few_lines import few_lines

Met: TypeAlias = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Angle (rad), distance (mm), and s, z and r (mm) of the other member."""
BLOCK = 8192
"""Points taken at a time, so that the arrays stay in the cache."""
SLACK = 1e-10
"""Share of the tooth depth by which a point may miss a limit and still count as inside."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Axes of the pair with errors: `offset` (mm), sine and cosine of the shaft angle, and
    `position` (2, ...) of the mid-faces along their axes, mm. Single numbers or arrays."""

    offset: FloatArray
    sin: FloatArray
    cos: FloatArray
    position: FloatArray

    def at(self, index: Integers) -> Pose:
        """Give the poses with the numbers `index` along the last axis."""
        return Pose(*(value.take(index, axis=-1) for value in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Separation:
    """Where points of one member meet the other member's flank, arrays of the broadcast shape.

    `angle` (rad): how far the other member turns towards the point until it meets it, negative
    where they overlap. `distance` (mm): the same along the normal of the other's flank.
    `other_l` (mm): profile coordinate of the meeting point on the other member, the flank
    parameter above its joint, on the fillet below; `other_z` (mm from mid-face), `other_r` (mm).
    `inside`: whether it lies within the other member's tip cone, toe and heel and not below its
    fillet. NaN and not inside where the other's flank and fillet have no point at that radius."""

    __repr__ = few_lines

    angle: FloatArray
    distance: FloatArray
    other_l: FloatArray
    other_z: FloatArray
    other_r: FloatArray
    inside: Mask


def pose_of(design: Design) -> Pose:
    """Give axes and positions of a design; pair and errors may be arrays."""
    layout, distance = layout_of(design), mounting_of(design).distance
    pinion, gear = distance[0] + design.errors.pinion_axial, distance[1] + design.errors.gear_axial
    position = np.stack(np.broadcast_arrays(pinion, gear))
    offset, sin, cos = (np.asarray(x) for x in (layout.offset, layout.sin_angle, layout.cos_angle))
    return Pose(offset, sin, cos, position)


def seen_by_other(
    pose: Pose, member: int, x: Numbers, y: Numbers, z: Numbers
) -> tuple[Numbers, Numbers, Numbers]:
    """Give points of a member's fixed frame, z from its mid-face, in the other's fixed frame, z from the
    other's mid-face. The same formula both ways (see `pair.frames`)."""
    z = z + pose.position[member]
    return (
        pose.offset - x,
        pose.sin * z - pose.cos * y,
        pose.sin * y + pose.cos * z - pose.position[1 - member],
    )


def pitch_shift(design: Design, pair: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Give rolls (rad) of pinion and gear from tooth pair 0 to the neighbouring tooth pairs `pair`."""
    turn = 2.0 * np.pi * np.asarray(pair, dtype=float)
    return np.asarray(turn / design.pinion.teeth), np.asarray(-turn / design.gear.teeth)


def separation(
    design: Design,
    flank: str,
    member: int,
    l: ArrayLike,
    z: ArrayLike,
    pinion_roll: ArrayLike,
    gear_roll: ArrayLike,
    pair: ArrayLike = 0,
) -> Separation:
    """Say how far points of a member (0 pinion, 1 gear) are from the other's flank at a pose.

    `l` (mm): profile coordinates of the points, the flank parameter above the joint, on the
    fillet below; `z` (mm from mid-face); the rolls, rad; `pair`: number of the tooth pair, the
    rolls being those of pair 0. All broadcast together, and with the pair and errors of the
    design if these are arrays; the members must be single. The points are taken as they are,
    whether or not they lie within their own limits.

    Raises ValueError for members of arrays."""
    own, other = (surface_of(design.members[j], flank) for j in (member, 1 - member))
    pose, shift = pose_of(design), pitch_shift(design, pair)
    rolls = float64_of("pinion_roll", pinion_roll) + shift[0], float64_of("gear_roll", gear_roll) + shift[1]
    given = np.broadcast_arrays(
        *(float64_of("l", l), float64_of("z", z), rolls[member], rolls[1 - member]),
        *(pose.offset, pose.sin, pose.cos, *pose.position),
    )
    shape = given[0].shape
    flat = [x.reshape(-1) for x in given]
    rows = np.empty((5, flat[0].size))
    with np.errstate(invalid="ignore", divide="ignore"):
        for start in range(0, flat[0].size, BLOCK):
            part = [x[start : start + BLOCK] for x in flat]
            here = Pose(part[4], part[5], part[6], np.stack(part[7:]))
            rows[:, start : start + BLOCK] = _separated(own, other, here, member, *part[:4])
    angle, distance, other_l, other_z, other_r = (row.reshape(shape) for row in rows)
    with np.errstate(invalid="ignore"):
        slack = SLACK * (other.tip - other.root)
        inside = np.abs(other_z) <= other.half_width + slack
        inside &= other_r <= other.tip + other.taper * other_z + slack
    return Separation(angle, distance, other_l, other_z, other_r, inside & ~np.isnan(angle))


def _separated(
    own: Surface,
    other: Surface,
    pose: Pose,
    member: int,
    s: FloatArray,
    z: FloatArray,
    roll: FloatArray,
    other_roll: FloatArray,
) -> Met:
    """Give the angle, distance, and the other's s, z and r, arrays of one axis."""
    point = cut_at(own, s, z)
    turned = point.phi + roll
    cos, sin = np.cos(turned), np.sin(turned)
    x, y, z = seen_by_other(pose, member, cos * point.x - sin * point.y, sin * point.x + cos * point.y, z)
    return met_by(other, x, y, z, other_roll)


def without_turns(angle: FloatArray) -> FloatArray:
    """Give angles (rad) less whole turns, at most half a turn either way."""
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def met_by(surface: Surface, x: FloatArray, y: FloatArray, z: FloatArray, roll: FloatArray) -> Met:
    """Give the clearance (rad) and distance (mm) of points from a `surface` at a `roll`, and its s, z and r
    where they meet; points in the fixed frame of that member, z from mid-face, arrays of one axis."""
    square = x * x + y * y
    s = profile_at(surface, square, z)
    met = cut_at(surface, s, z)
    # Angle between the point and the cut point as one arctangent, small at contact.
    turn = np.arctan2(y * met.x - x * met.y, x * met.x + y * met.y) - met.phi - roll
    angle = surface.sigma * without_turns(turn)
    return angle, angle * np.abs(surface.pitch_radius * met.ny), s, z, np.sqrt(square)
