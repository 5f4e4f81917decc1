"""Dimension over two balls in opposite tooth spaces, anywhere along the face.

The centre of a ball is at the distance of the ball radius from the right flank of one tooth and from the left
flank of the next one. In the plane z of the centre, these are two equations for its radius r and angle
theta. The distances are those of the feet on the flanks, and their derivatives are the normals there, so
that Newton's method needs nothing else. The tooth space of a beveloid has no plane of symmetry: the ball
touches its two flanks at different radii and on different sides of the plane z. The method is exact with and
without parabolas.

For cylindrical gears, the dimension M over balls of the diameter D_M follows from the diameter d_K on which
their centres lie, the transverse pressure angle alpha_K there, and the half angle eta of a tooth space on the
reference cylinder. The equations are (30), (31), (35) and (36) of DIN 21773,

    inv(alpha_K) = D_M / (N m_n cos(alpha_n)) - eta + inv(alpha_t),  d_K = d_b / cos(alpha_K),  M = d_K + D_M,

or d_K cos(pi / 2N) + D_M if N is odd.

Rolls (pins) touch the flanks of cylindrical gears at the same points as balls, so that their axes are at the
same distance from the axis of the gear. For spur gears, the dimension over rolls is that over balls. For
helical gears, two parallel planes touch the rolls where these are opposite to each other, so that M = d_K +
D_M also if N is odd. In the tooth space of a cone, a roll tilts: there is no dimension between parallel
planes.

On a cone a ball needs a stop along the face: M belongs to the z of its centre. At toe and heel, the centre
is one ball radius inside the face, so that the ball touches the flanks on the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FLANK_SIGN, Codes, FloatArray, Mask
from ..design.arguments import require_member, require_numbers
from ..design.field_limits import float64_of
from ..design.member import Member
from ..gear.closest_point import Feet, feet
from ..gear.fillet import root_radius
from ..gear.flank import base_cylinder, flank_point
from ..gear.flank_limits import tip_radius
from ..gear.rack import reference_radius
from ..gear.undercut import undercut_of
from ..status import BallStatus, Status
from ..support.array_repr import short_repr
from .tooth_data import middle_angle, turn_of

BALL_DIAMETERS_MM = np.array(
    (
        *(0.17, 0.195, 0.22, 0.25, 0.29, 0.335, 0.39, 0.455, 0.53, 0.62, 0.725, 0.895, 1.0, 1.1, 1.25, 1.4),
        *(1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0, 4.25, 4.5, 5.0, 5.25, 5.5, 6.0, 6.5),
        *(7.0, 7.5, 8.0, 9.0, 10.0, 10.5, 11.0, 12.0, 14.0, 15.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 30.0),
        *(35.0, 40.0, 45.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0),
    )
)
"""Usual diameters of measuring balls, with steps of 10 and 20 mm above 50 mm."""


@dataclass(frozen=True, eq=False)
class Balls:
    """Dimension over two balls. Lengths in mm, angles in rad.

    Attributes
    ----------
    diameter : float
        Diameter of the balls.
    z : array (n,)
        Planes of their centres.
    change : array (k,)
        Changes of the normal thickness.
    dimension : array (k, n)
        NaN unless MEASURED.
    over_rolls : array (k, n)
        Dimension over two rolls of the same diameter; NaN on cones.
    radius, angle : array (k, n)
        Centre of the ball between the right flank of tooth 0 and the left flank of the next tooth.
    contact_z, contact_radius : array (2, k, n)
        Points of contact with right and left flank.
    status : array (k, n)
        Codes of `BallStatus`.
    """

    __repr__ = short_repr

    diameter: float
    z: FloatArray
    change: FloatArray
    dimension: FloatArray
    over_rolls: FloatArray
    radius: FloatArray
    angle: FloatArray
    contact_z: FloatArray
    contact_radius: FloatArray
    status: Codes


def ball_dimensions(member: Member, diameter: float, z: ArrayLike, change: ArrayLike = 0.0) -> Balls:
    """Compute the dimension over two balls of a single member.

    Parameters
    ----------
    member : Member
    diameter : float
        Diameter of the balls, mm.
    z : float or array (n,)
        Planes of the centres, mm from mid-face.
    change : float or array (k,)
        Change of the normal thickness from that of the design, mm; negative for a thinner tooth.

    Returns
    -------
    Balls

    Raises
    ------
    ValueError
        For a diameter that is not positive, a member that its tool cannot cut, and tip rounds of the tool
        that overlap.

    References
    ----------
    Cylindrical gears: Eqs. (30), (31), (35) and (36) of DIN 21773.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> balls = bg.ball_dimensions(bg.builtin_design("ni-2017").pinion, diameter=10.0, z=0.0)
    >>> print(f"{balls.dimension[0, 0]:.3f} mm")
    206.709 mm
    """
    require_member(member)
    require_numbers(diameter=diameter)
    if not 0.0 < diameter < np.inf:
        raise ValueError(f"the diameter of a ball must be positive, got {diameter:g} mm")
    z, change = np.atleast_1d(float64_of("z", z), float64_of("change", change))
    centre, pair = _centres(member, diameter, np.broadcast_to(z, (change.size, z.size)), change[:, None])
    return _judged(member, diameter, z, change, centre, pair)


def recommended_ball(member: Member) -> float:
    """Return the smallest usual diameter of a ball that touches on or above the shifted reference cone.

    The centre of the ball is at mid-face. The mean radius of its contacts with both flanks must be at least
    the radius of the cone. Diameters from 1 to 4 modules are tried.

    Parameters
    ----------
    member : Member
        A single member.

    Returns
    -------
    float
        mm; NaN if there is none.
    """
    # Smallest and largest diameter of a recommended ball.
    recommended_modules = (1.0, 4.0)
    module = float(member.tool.normal_module)
    ratio = BALL_DIAMETERS_MM / module
    sizes = BALL_DIAMETERS_MM[(ratio >= recommended_modules[0]) & (ratio <= recommended_modules[1])]
    radius = tip_radius(member, 0.0) - float(member.tip_height) * module
    for size in sizes.tolist():
        balls = ball_dimensions(member, size, 0.0)
        if balls.contact_radius.mean() >= radius and balls.status[0, 0] == BallStatus.MEASURED:
            return float(size)
    return float("nan")


def ball_planes(member: Member, diameter: float) -> FloatArray:
    """Return the planes (3,), mm, of balls at toe, middle and heel: one ball radius inside the face."""
    inside = max(0.5 * (float(member.face_width) - diameter), 0.0)
    return inside * np.array([-1.0, 0.0, 1.0])


def _centres(
    member: Member, diameter: float, z: FloatArray, change: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], list[Feet]]:
    """Return radius and angle (k, n) of the centres, and the feet on right and left flanks.

    Newton's method with a line search: a step is halved if it leads to a point without feet, such as inside a
    base cylinder, or increases the residual. On steep cones the feet lie several mm away from the plane z, so
    that the first full Newton steps can leave the teeth."""
    # Largest number of steps, including halved ones; 4 to 8 are usual.
    max_newton_steps = 60
    pitch, thicker = 2.0 * np.pi / float(member.teeth), turn_of(member, change)
    turns = thicker, pitch - thicker  # angles of the two flanks from those of tooth 0

    def feet_at(radius: FloatArray, angle: FloatArray) -> tuple[list[Feet], FloatArray]:
        """Return feet, and the distances (2, k, n) less the radius of the ball, inf without a foot."""
        both = [
            feet(member, flank, _points(radius, angle - turn, z))
            for flank, turn in zip(FLANK_SIGN, turns, strict=True)
        ]
        off = np.array([foot.distance - 0.5 * diameter for foot in both])
        return both, np.where(np.isfinite(off).all(axis=0), off, np.inf)

    # Start in the middle of a space on the tips, outside both base cylinders: both flanks have feet there.
    base = max(float(base_cylinder(member, flank).radius) for flank in FLANK_SIGN)
    outside = base + 0.05 * float(member.tool.normal_module)
    radius = np.maximum(tip_radius(member, z), outside) + 0.0 * change
    slope = np.tan(member.helix_angle) * np.cos(member.cone_angle) / reference_radius(member)
    angle = 0.5 * pitch + middle_angle(member) + z * slope + 0.0 * change
    pair, off = feet_at(radius, angle)
    share = np.ones_like(radius)
    for _ in range(max_newton_steps):
        step_r, step_t = _newton_step(pair, off, radius, [angle - turn for turn in turns])
        size = np.abs(step_r) + radius * np.abs(step_t)
        if not np.any(share * size > 1e-14 * radius):
            break
        trial, trial_off = feet_at(radius + share * step_r, angle + share * step_t)
        nearer = np.abs(trial_off).max(axis=0) < np.abs(off).max(axis=0)
        radius = np.where(nearer, radius + share * step_r, radius)
        angle = np.where(nearer, angle + share * step_t, angle)
        off = np.where(nearer, trial_off, off)
        pair = [_picked(nearer, new, old) for new, old in zip(trial, pair, strict=True)]
        share = np.where(nearer, 1.0, 0.5 * share)
    return (radius, angle), pair


def _picked(which: Mask, new: Feet, old: Feet) -> Feet:
    """Return the `new` feet where `which` (k, n) is true, otherwise the `old` ones."""
    pairs = ((getattr(new, name), value) for name, value in vars(old).items())
    return Feet(*(np.where(which.reshape(which.shape + (1,) * (b.ndim - 2)), a, b) for a, b in pairs))


def _newton_step(
    pair: list[Feet], off: FloatArray, radius: FloatArray, angles: list[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return Newton's steps (k, n) of radius, mm, and angle, rad; 0 where a flank has no foot."""
    (a, b), (c, d) = (_slopes(foot, radius, angle) for foot, angle in zip(pair, angles, strict=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        det = a * d - b * c
        steps = np.array(((b * off[1] - d * off[0]) / det, (c * off[0] - a * off[1]) / det))
    steps = np.where(np.isfinite(steps).all(axis=0), steps, 0.0)
    return steps[0], steps[1]


def _points(radius: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=-1)


def _slopes(foot: Feet, radius: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of the distance from a flank by radius and angle of the point."""
    nx, ny, _ = np.moveaxis(foot.normal, -1, 0)
    cos, sin = np.cos(angle), np.sin(angle)
    return nx * cos + ny * sin, radius * (ny * cos - nx * sin)


def _judged(
    member: Member,
    diameter: float,
    z: FloatArray,
    change: FloatArray,
    centre: tuple[FloatArray, FloatArray],
    pair: list[Feet],
) -> Balls:
    """Return the dimensions of balls at their centres, and their status."""
    # Largest deviation of the distances from the ball radius, relative to it.
    contact_tolerance = 1e-11
    (radius, angle), half, teeth = centre, 0.5 * diameter, int(member.teeth)
    off, contact_radius = np.zeros(radius.shape, dtype=bool), np.empty((2, *radius.shape))
    for side, (flank, foot) in enumerate(zip(FLANK_SIGN, pair, strict=True)):
        contact_radius[side] = np.hypot(*flank_point(member, flank, foot.l, foot.u)[..., :2].T).T
        cut = undercut_of(member, flank)
        off |= (foot.status != Status.SOLVED) | ~(foot.l >= np.interp(foot.z, cut.z, cut.start))
    lost = np.any([~(np.abs(foot.distance - half) <= contact_tolerance * half) for foot in pair], axis=0)
    deep = radius + half <= tip_radius(member, z)
    bottom = (radius - root_radius(member, z)) * np.cos(member.cone_angle) < half
    # With an odd number of teeth, balls are half a pitch from opposite positions.
    odd = np.cos(0.5 * np.pi / teeth) if teeth % 2 else 1.0
    across = 2.0 * radius * odd
    # Rolls extend along helical spaces: planes touch them where they are opposite to each other.
    along = 2.0 * radius * (odd if float(member.helix_angle) == 0.0 else 1.0)
    cylindrical = float(member.cone_angle) == 0.0
    # The first case that applies gives the status.
    cases = lost, bottom, off, deep
    codes = BallStatus.NOT_FOUND, BallStatus.ON_BOTTOM, BallStatus.OFF_FLANK, BallStatus.BELOW_TIP
    status = np.select(cases, codes, BallStatus.MEASURED).astype(np.int8)
    measured = status == BallStatus.MEASURED
    dimension = np.where(measured, across + diameter, np.nan)
    over_rolls = np.where(measured & cylindrical, along + diameter, np.nan)
    contact_z = np.array([foot.z for foot in pair])
    return Balls(diameter, z, change, dimension, over_rolls, radius, angle, contact_z, contact_radius, status)
