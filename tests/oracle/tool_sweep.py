"""Material that the tip round of the tool removes from a gear, by brute force: the rack is rotated by beta
about x and then tilted by gamma about y."""

from __future__ import annotations

import numpy as np

from beveloid_geom import Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.fillet import tool_round
from beveloid_geom.gear.rack import reference_radius


def distance_from_round(member: Member, flank: str, point: FloatArray, roll: FloatArray) -> FloatArray:
    """Return the distance (mm) of gear points (..., 3) from the axis of the tip round of the sliding tool,
    at rolls that broadcast with (...)."""
    beta, gamma, radius = float(member.helix_angle), float(member.cone_angle), float(reference_radius(member))
    x = np.cos(roll) * point[..., 0] + np.sin(roll) * point[..., 1] - radius
    y = np.cos(roll) * point[..., 1] - np.sin(roll) * point[..., 0] + radius * roll
    x = x - float(member.profile_shift * member.tool.normal_module)
    height = np.cos(gamma) * x - np.sin(gamma) * point[..., 2]
    along = np.sin(gamma) * x + np.cos(gamma) * point[..., 2]
    across = np.cos(beta) * y - np.sin(beta) * along
    centre = tool_round(member.tool, flank).centre
    return np.asarray(np.hypot(height - centre[0], across - centre[1]))


def clearance_of_round(member: Member, flank: str, points: FloatArray) -> FloatArray:
    """Return the distance (n,), mm, of points (n, 3) from the round over all rolls; negative where the
    round removes them."""
    roll, half = np.zeros((len(points), 1)), 1.2
    for _ in range(3):
        rolls = roll + np.linspace(-half, half, 1201)
        distance = distance_from_round(member, flank, points[:, None], rolls)
        roll = np.take_along_axis(rolls, distance.argmin(axis=1)[:, None], axis=1)
        half /= 400.0
    return np.asarray(distance.min(axis=1) - tool_round(member.tool, flank).radius)
