"""Angular clearance: rotation of the mating member until a point of one member touches its flank.

Seen from the mate, a point of a member moves on a circle about the mate's axis when the mate rotates. In
the mate's frame, the point has a radius r, an axial coordinate z and an angle theta. The mate's surface has
at most one point with this r and z (`gear.tooth_side`), at the angle theta_f. The clearance angle is

    sigma (theta - theta_f),   sigma = +1 on right flanks, -1 on left flanks,

positive for a gap and negative for overlap. The same formula holds for both members.

The distance along the normal is this angle times the moment of the mate's unit normal about its axis.
Without a modification, this moment is |r_P n_y|, with the pitch radius r_P of the mate and the component
n_y of the normal in the frame of generation (`gear.generation`). Without parabola and modification, it is
m_n N cos(alpha) / 2 everywhere on the flank, with the number of teeth N. A rotated involute helicoid is
parallel to itself, so that the distance to the flank and its extension is exact. With a parabola or a
modification, and on a fillet, the distance is correct to first order in the gap.
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
from ..gear.tooth_side import ToothSurface, cut_at, profile_at, surface_of as surface_of
from ..pair.frames import layout_of
from ..pair.mounting import mounting_of
from ..support.array_repr import short_repr

Met: TypeAlias = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Angle (rad), distance (mm), and s, z and r (mm) of the mating member."""


@dataclass(frozen=True, eq=False)
class AxisPositions:
    """Position of both axes, with errors.

    Attributes
    ----------
    offset : ndarray
        Length of the common perpendicular, mm.
    sin, cos : ndarray
        Sine and cosine of the shaft angle.
    position : ndarray, shape (2, ...)
        Coordinates of the mid-faces of pinion and gear along their axes, mm.
    """

    offset: FloatArray
    sin: FloatArray
    cos: FloatArray
    position: FloatArray

    @property
    def versine(self) -> FloatArray:
        """Return 1 - cos, without the rounding of small angles."""
        return np.asarray(2.0 * np.sin(0.5 * np.arctan2(self.sin, self.cos)) ** 2)

    def at(self, index: Integers) -> AxisPositions:
        """Return the positions with the numbers `index` along the last axis, or the only one, (1,)."""
        if self.offset.shape == (1,):
            return self
        return AxisPositions(*(value.take(index, axis=-1) for value in vars(self).values()))


@dataclass(frozen=True, eq=False)
class AngularClearance:
    """Clearance of points of one member from the mate's flank; arrays of the broadcast shape.

    Attributes
    ----------
    angle : ndarray
        Rotation of the mate until it touches the point, rad; negative for overlap.
    distance : ndarray
        The clearance along the normal of the mate's surface, mm.
    other_l : ndarray
        Profile coordinate of the touched point of the mate, mm: the flank parameter above the joint with the
        fillet, the fillet coordinate below.
    other_z, other_r : ndarray
        Distance from mid-face and radius of the touched point, mm.
    inside : ndarray of bool
        Whether the touched point lies within tip cone, toe and heel of the mate, and not below its fillet.

    Notes
    -----
    NaN, and not inside, where flank and fillet of the mate have no point at that radius.
    """

    __repr__ = short_repr

    angle: FloatArray
    distance: FloatArray
    other_l: FloatArray
    other_z: FloatArray
    other_r: FloatArray
    inside: Mask


def axes_of(design: Design) -> AxisPositions:
    """Return the axes and positions of a design.

    Parameters
    ----------
    design : Design
        Pair and errors may be arrays.

    Returns
    -------
    AxisPositions
        Of the batch shape.
    """
    layout, distance = layout_of(design), mounting_of(design).distance
    pinion, gear = distance[0] + design.errors.pinion_axial, distance[1] + design.errors.gear_axial
    position = np.stack(np.broadcast_arrays(pinion, gear))
    offset, cos = np.asarray(layout.offset), np.asarray(layout.cos_angle)
    sin = np.where(layout.parallel, 0.0, layout.sin_angle)  # angles that count as parallel are exactly 0
    return AxisPositions(offset, sin, cos, position)


def seen_by_other(
    axes: AxisPositions, member: int, x: Numbers, y: Numbers, z: Numbers
) -> tuple[Numbers, Numbers, Numbers]:
    """Transform points from the fixed frame of one member to that of the mate.

    Parameters
    ----------
    axes : AxisPositions
    member : int
        Member that the points are given for: 0 pinion, 1 gear. The formula is the same for both
        (`pair.frames`).
    x, y, z : ndarray
        Coordinates in the fixed frame of `member`, z from its mid-face, mm.

    Returns
    -------
    x, y, z : ndarray
        Coordinates in the fixed frame of the mate, z from its mid-face, mm.
    """
    position, other = axes.position[member], axes.position[1 - member]
    ahead = z + position
    # cos (z + p1) - p2, without the rounding of large positions of nearly parallel axes.
    high = z + (position - other - axes.versine * ahead)
    return axes.offset - x, axes.sin * ahead - axes.cos * y, axes.sin * y + high


def pitch_shift(design: Design, pair: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the angles that are added to the rolls of tooth pair 0 to obtain the rolls of other tooth pairs.

    Tooth pair k consists of pinion tooth k and gear tooth -k, counted in the direction of positive rotation.

    Parameters
    ----------
    design : Design
    pair : array_like of int
        Numbers of the tooth pairs.

    Returns
    -------
    pinion, gear : ndarray
        Angles of pinion and gear, rad.
    """
    turn = 2.0 * np.pi * np.asarray(pair, dtype=float)
    return np.asarray(turn / design.pinion.teeth), np.asarray(-turn / design.gear.teeth)


def angular_clearance(
    design: Design,
    flank: str,
    member: int,
    l: ArrayLike,
    z: ArrayLike,
    pinion_roll: ArrayLike,
    gear_roll: ArrayLike,
    pair: ArrayLike = 0,
) -> AngularClearance:
    """Compute the clearance of points of a member from the mate's flank at given rolls of both members.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.
    flank : {'right', 'left'}
    member : int
        Member of the points: 0 pinion, 1 gear.
    l, z : array_like
        Profile coordinates and distances from mid-face of the points, mm. Points outside the limits of the
        member are accepted.
    pinion_roll, gear_roll : array_like
        Rolls of tooth pair 0, rad.
    pair : array_like of int
        Number of the tooth pair.

    Returns
    -------
    AngularClearance
        Arrays of the broadcast shape of all arguments, pair and errors.

    Raises
    ------
    ValueError
        If a field of a member is an array.
    """
    # Points of one block, so that the arrays stay in the cache.
    points_per_block = 8192
    surface, mate = (surface_of(design.members[j], flank) for j in (member, 1 - member))
    axes, shift = axes_of(design), pitch_shift(design, pair)
    rolls = float64_of("pinion_roll", pinion_roll) + shift[0], float64_of("gear_roll", gear_roll) + shift[1]
    arguments = np.broadcast_arrays(
        *(float64_of("l", l), float64_of("z", z), rolls[member], rolls[1 - member]),
        *(axes.offset, axes.sin, axes.cos, *axes.position),
    )
    shape = arguments[0].shape
    flat = [x.reshape(-1) for x in arguments]
    rows = np.empty((5, flat[0].size))
    with np.errstate(invalid="ignore", divide="ignore"):
        for start in range(0, flat[0].size, points_per_block):
            part = [x[start : start + points_per_block] for x in flat]
            here = AxisPositions(part[4], part[5], part[6], np.stack(part[7:]))
            rows[:, start : start + points_per_block] = _separated(surface, mate, here, member, *part[:4])
    angle, distance, other_l, other_z, other_r = (row.reshape(shape) for row in rows)
    with np.errstate(invalid="ignore"):
        slack = 1e-10 * (mate.tip - mate.root)  # rounding at the limits
        inside = np.abs(other_z) <= mate.half_width + slack
        inside &= other_r <= mate.tip + mate.taper * other_z + slack
    return AngularClearance(angle, distance, other_l, other_z, other_r, inside & ~np.isnan(angle))


def _separated(
    surface: ToothSurface,
    mate: ToothSurface,
    axes: AxisPositions,
    member: int,
    s: FloatArray,
    z: FloatArray,
    roll: FloatArray,
    other_roll: FloatArray,
) -> Met:
    """Return angle and distance, and s, z and r of the touched points, arrays of one axis."""
    point = cut_at(surface, s, z)
    turned = point.phi + roll
    cos, sin = np.cos(turned), np.sin(turned)
    x, y, z = seen_by_other(axes, member, cos * point.x - sin * point.y, sin * point.x + cos * point.y, z)
    return met_by(mate, x, y, z, other_roll)


def without_turns(angle: FloatArray) -> FloatArray:
    """Return angles reduced by full turns.

    Parameters
    ----------
    angle : ndarray
        rad.

    Returns
    -------
    ndarray
        rad, between minus half a turn and half a turn.
    """
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def met_by(surface: ToothSurface, x: FloatArray, y: FloatArray, z: FloatArray, roll: FloatArray) -> Met:
    """Compute the clearance of points from a surface.

    Parameters
    ----------
    surface : ToothSurface
    x, y, z : ndarray, shape (n,)
        Points in the fixed frame of the member of the surface, z from its mid-face, mm.
    roll : ndarray, shape (n,)
        Roll of this member, rad.

    Returns
    -------
    angle, distance, s, z, r : ndarray, shape (n,)
        Clearance angle (rad), distance along the normal (mm), and the touched point of the surface, mm.
    """
    square = x * x + y * y
    s = profile_at(surface, square, z)
    met = cut_at(surface, s, z)
    # One arctangent of both angles: it is exact to rounding where the difference is small, near contact.
    turn = np.arctan2(y * met.x - x * met.y, x * met.x + y * met.y) - met.phi - roll
    angle = surface.sigma * without_turns(turn)
    moment = surface.pitch_radius * met.ny
    if surface.modification is not None:
        moment = met.x * met.ny - met.y * met.nx
    return angle, angle * np.abs(moment), s, z, np.sqrt(square)
