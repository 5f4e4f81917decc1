"""The dimension over two balls in opposite tooth spaces, at any place along the face.

The centre of a ball lies at the distance of its radius from the right flank of one tooth and from the left
flank of the next. In the plane z of the centre these are two equations in its radius r and angle theta; the
distances are those of feet on the flanks, whose slopes are the normals there, so that Newton's method needs
no more. A beveloid's space has no plane of symmetry, and the ball touches its two flanks at different radii
and on different sides of the plane z. With parabola as without: a foot is exact on either.

On cylindrical gears these are DIN 21773 Eqs. (30), (31), (35) and (36),

    inv(alpha_K) = D_M / (N m_n cos(alpha_n)) - eta + inv(alpha_t),  d_K = d_b / cos(alpha_K),  M = d_K + D_M,

or d_K cos(pi / 2N) + D_M where N is odd.

On a cone a ball does not rest by itself at a place along the face: M belongs to the z of its centre, to be
held by a stop. At toe and heel it is a ball's radius inside the face, so that it touches on the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FLANK_SIGN, Codes, FloatArray
from ..design.model import Member
from ..gear.fillet import root_radius
from ..gear.flank import flank_point, tip_radius, trace_parameter
from ..gear.perpendicular import Feet, feet
from ..gear.rack import reference_radius
from ..gear.undercut import undercut_of
from ..status import BallStatus, Status
from ..support.few_lines import few_lines
from .tooth_data import turn_of

SIZES = np.array(
    (
        *(0.17, 0.195, 0.22, 0.25, 0.29, 0.335, 0.39, 0.455, 0.53, 0.62, 0.725, 0.895, 1.0, 1.1, 1.25, 1.4),
        *(1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0, 4.25, 4.5, 5.0, 5.25, 5.5, 6.0, 6.5),
        *(7.0, 7.5, 8.0, 9.0, 10.0, 10.5, 11.0, 12.0, 14.0, 15.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 30.0),
        *(35.0, 40.0, 45.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0),
    )
)
"""Usual diameters of measuring balls, mm, and on from 50 mm even ones."""
MIDDLE, SPREAD = 2.5, 1.5
"""Modules of diameter within which a ball is recommended: from 1 to 4."""
STEPS = 20
"""Newton steps to the centre; 4 to 6 are needed."""
CLOSE = 1e-11
"""Share of a ball's radius to which it touches both flanks."""


@dataclass(frozen=True, eq=False)
class Balls:
    """Dimension over two balls of the `diameter`, mm, on teeth whose normal thickness is changed by the
    `change` (k,), with centres in the planes `z` (n,).

    `dimension` (k, n); `radius` (k, n) and `angle` (k, n) of a centre, the space being that between the right
    flank of tooth 0 and the left one of the next; of the points of contact with right and left flank
    `contact_z` and `contact_radius` (2, k, n); `status` (k, n), codes of `BallStatus`: what is not MEASURED
    is NaN, all but the centre where that was found. mm and rad."""

    __repr__ = few_lines

    diameter: float
    z: FloatArray
    change: FloatArray
    dimension: FloatArray
    radius: FloatArray
    angle: FloatArray
    contact_z: FloatArray
    contact_radius: FloatArray
    status: Codes


def balls_at(member: Member, diameter: float, z: ArrayLike, change: ArrayLike = 0.0) -> Balls:
    """Find the dimension over two balls of a single member.

    Parameters
    ----------
    member : Member
    diameter : float
        Of a ball, mm.
    z : float or array (n,)
        Planes of the centres, mm from mid-face.
    change : float or array (k,)
        By how much the normal thickness differs from that of the design, mm.

    Returns
    -------
    Balls

    Raises
    ------
    ValueError
        For a diameter that is not positive, a member that its tool cannot cut, and overlapping tool rounds.
    """
    if not 0.0 < diameter < np.inf:
        raise ValueError(f"the diameter of a ball must be positive, got {diameter:g} mm")
    z, change = (np.atleast_1d(np.asarray(given, dtype=float)) for given in (z, change))
    centre, pair = _centres(member, diameter, np.broadcast_to(z, (change.size, z.size)), change[:, None])
    return _judged(member, diameter, z, change, centre, pair)


def recommended_ball(member: Member) -> float:
    """Give the least usual diameter (mm) of a ball that touches a single member's flanks at mid-face on the
    shifted reference cone or above it, in the mean of both; NaN if none does."""
    module = float(member.tool.normal_module)
    sizes = SIZES[np.abs(SIZES / module - MIDDLE) <= SPREAD]
    radius = tip_radius(member, 0.0) - float(member.tool.addendum) * module
    for size in sizes.tolist():
        found = balls_at(member, size, 0.0)
        if found.contact_radius.mean() >= radius and found.status[0, 0] == BallStatus.MEASURED:
            return float(size)
    return float("nan")


def ball_planes(member: Member, diameter: float) -> FloatArray:
    """Give the planes (3,), mm, of balls at toe, middle and heel: a ball's radius inside the face."""
    inside = max(0.5 * (float(member.face_width) - diameter), 0.0)
    return inside * np.array([-1.0, 0.0, 1.0])


def _centres(
    member: Member, diameter: float, z: FloatArray, change: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], list[Feet]]:
    """Find radius and angle (k, n) of the centres, and the feet on right and left flanks."""
    pitch, more = 2.0 * np.pi / float(member.teeth), turn_of(member, change)
    starts = [(np.zeros_like(z), trace_parameter(member, flank, 0.0, z)) for flank in FLANK_SIGN]
    turns = more, pitch - more  # of the flanks that hold the ball, from those of tooth 0
    radius = tip_radius(member, z) - 0.5 * float(member.tool.normal_module)
    slope = np.tan(member.helix_angle) * np.cos(member.cone_angle) / reference_radius(member)
    angle = 0.5 * pitch + z * slope
    for _ in range(STEPS):
        pair = [
            feet(member, flank, _points(radius, angle - turn, z), start)
            for flank, turn, start in zip(FLANK_SIGN, turns, starts, strict=True)
        ]
        off = [foot.distance - 0.5 * diameter for foot in pair]
        slopes = [_slopes(foot, radius, angle - turn) for foot, turn in zip(pair, turns, strict=True)]
        (a, b), (c, d) = slopes
        det = a * d - b * c
        step_r, step_t = (b * off[1] - d * off[0]) / det, (c * off[0] - a * off[1]) / det
        if not np.any(np.abs(step_r) + radius * np.abs(step_t) > 1e-14 * radius):
            break
        radius, angle = radius + step_r, angle + step_t
    return (radius, angle), pair


def _points(radius: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=-1)


def _slopes(foot: Feet, radius: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give derivatives of the distance from a flank by radius and angle of the point."""
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
    """Say what a ball at its centre is good for."""
    (radius, angle), half, teeth = centre, 0.5 * diameter, int(member.teeth)
    off, contact_radius = np.zeros(radius.shape, dtype=bool), np.empty((2, *radius.shape))
    for side, (flank, foot) in enumerate(zip(FLANK_SIGN, pair, strict=True)):
        contact_radius[side] = np.hypot(*flank_point(member, flank, foot.l, foot.u)[..., :2].T).T
        cut = undercut_of(member, flank)
        off |= (foot.status != Status.SOLVED) | ~(foot.l >= np.interp(foot.z, cut.z, cut.start))
    lost = np.any([~(np.abs(foot.distance - half) <= CLOSE * half) for foot in pair], axis=0)
    deep = radius + half <= tip_radius(member, z)
    bottom = (radius - root_radius(member, z)) * np.cos(member.cone_angle) < half
    across = 2.0 * radius * (np.cos(0.5 * np.pi / teeth) if teeth % 2 else 1.0)
    cases = lost, bottom, off, deep
    codes = BallStatus.NOT_FOUND, BallStatus.ON_BOTTOM, BallStatus.OFF_FLANK, BallStatus.BELOW_TIP
    status = np.select(cases, codes, BallStatus.MEASURED).astype(np.int8)
    dimension = np.where(status == BallStatus.MEASURED, across + diameter, np.nan)
    contact_z = np.array([foot.z for foot in pair])
    return Balls(diameter, z, change, dimension, radius, angle, contact_z, contact_radius, status)
