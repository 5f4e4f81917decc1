"""Fillet and bottom land, which the tip of the tool cuts.

The tip of the tool is rounded. Round and flank meet with a common tangent, at a height that depends
on the parabola. From this joint the section normal rotates to 90 degrees while the round cuts the
fillet; the flat tip of the tool cuts the bottom land. Both are envelopes of the same sliding rack as
the flank, so that Eq. 6 holds with their points and normals:

    flank        section normal (sin(alpha - tau), sigma cos(alpha - tau))
    fillet       c - rho n(theta), n = (sin(theta), sigma cos(theta)), theta from the joint to pi/2
    bottom land  x_n = -dedendum, n = (1, 0): the root cone

with tan(tau) = 2 a l, and the centre c and the radius rho of the round. The root cone is dedendum /
cos(gamma) below the shifted pitch cone, measured radially.

The paper does not treat them; tool and dedendum are those of the usual basic rack.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, flank_sign
from ..design.member import Member, Tool
from .flank import generated
from .rack import rack_of, reference_radius, section_frame, section_point


@dataclass(frozen=True)
class ToolRound:
    """Rounded tip of the tool next to one flank, in its normal section.

    `joint` (mm) is the flank parameter at which it meets the flank, `angle` (rad) the angle of the section
    normal there; centre (x_n, y_n) and radius in mm.
    """

    joint: float
    angle: float
    centre: tuple[float, float]
    radius: float


def tool_round(tool: Tool, flank: str) -> ToolRound:
    """Return the tip round of a single tool at one flank.

    Raises
    ------
    ValueError
        If the rounds of both flanks overlap, if the flank ends above the round, or if its profile folds
        above the round.
    """
    alpha, module = float(tool.normal_pressure_angle), float(tool.normal_module)
    a, apex = float(tool.parabola_of(flank)), float(tool.parabola_apex) * np.cos(alpha)
    depth, radius = float(tool.dedendum) * module, float(tool.tip_radius) * module
    folds = f"parabola {a:g} 1/mm leaves no space for the tool's tip round: reduce its magnitude"
    # The joint is less than a radius above the tip of the tool: the flank must reach down to depth - radius.
    if not 4.0 * abs(a) * (depth - radius + abs(apex)) * np.sin(alpha) < np.cos(alpha) ** 2:
        raise ValueError(folds)
    depth += apex  # below the apex, from which l is measured
    l = (radius * (1.0 - np.sin(alpha)) - depth) / np.cos(alpha)
    for _ in range(30):
        tau = np.arctan(2.0 * a * l)
        height = l * np.cos(alpha) + a * l * l * np.sin(alpha) + radius * np.sin(alpha - tau)
        turn = 2.0 * a / (1.0 + (2.0 * a * l) ** 2)
        slope = np.cos(alpha) + 2.0 * a * l * np.sin(alpha) - radius * np.cos(alpha - tau) * turn
        step = (radius - depth - height) / slope
        l += step
        if abs(step) < 1e-13 * module:
            break
    else:
        raise ValueError(folds)
    # Tangent condition of round and flank.
    angle = alpha - np.arctan(2.0 * a * l)
    if not 0.0 < angle < 0.5 * np.pi:
        raise ValueError(folds)
    sigma = flank_sign(flank)
    x, y = section_point(tool, flank, np.asarray(l)) + radius * np.array(
        [np.sin(angle), sigma * np.cos(angle)]
    )
    if abs(y) > 0.5 * np.pi * module:
        text = f"tip_radius {float(tool.tip_radius):g} is too large: the tool's tip rounds"
        raise ValueError(f"{text} overlap by {2.0 * abs(y) - np.pi * module:.3g} mm, reduce it")
    return ToolRound(float(l), float(angle), (float(x), float(y)), radius)


def _cut(
    member: Member, flank: str, section: tuple[FloatArray, ...], z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the points and unit normals (..., 3) that points of the tool cut in the planes `z`, mm.

    `section` has x_n, y_n and the unit normal (n_x, n_y) of the points in the normal section of the tool.
    """
    x, y, nx, ny = section
    rack, (origin, along, across) = rack_of(member, flank), section_frame(member)
    normal = _spanned(nx, along) + _spanned(ny, across)
    start = _spanned(np.ones_like(x), origin) + _spanned(x, along) + _spanned(y, across)
    u = (z - start[2]) / rack.trace[2]
    return generated(rack, start + _spanned(u, rack.trace), normal)


def _spanned(lengths: FloatArray, vector: FloatArray) -> FloatArray:
    """Return a vector (3,) multiplied by each of the lengths (...), as components (3, ...)."""
    return np.multiply.outer(vector, lengths)


def fillet_point(member: Member, flank: str, angle: ArrayLike, z: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return points (mm) and unit normals (..., 3) of the fillet below a flank of a single member, in the
    gear frame.

    `angle` is that of the section normal (rad, from the joint to pi/2); `z` are planes in mm from mid-face.
    """
    angle, z = np.broadcast_arrays(np.asarray(angle, dtype=float), np.asarray(z, dtype=float))
    rounding, sigma = tool_round(member.tool, flank), flank_sign(flank)
    sin, cos = np.sin(angle), sigma * np.cos(angle)
    (x, y), radius = rounding.centre, rounding.radius
    return _cut(member, flank, (x - radius * sin, y - radius * cos, sin, cos), z)


def bottom_point(
    member: Member, flank: str, across: ArrayLike, z: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return points (mm) and unit normals (..., 3) of the bottom land next to a flank of a single member, in
    the gear frame.

    `across` is y_n of the tool, mm; `z` are planes in mm from mid-face.
    """
    across, z = np.broadcast_arrays(np.asarray(across, dtype=float), np.asarray(z, dtype=float))
    depth = float(member.tool.dedendum * np.asarray(member.tool.normal_module))
    one = np.ones_like(across)
    return _cut(member, flank, (-depth * one, across, one, 0.0 * one), z)


def root_radius(member: Member, z: ArrayLike) -> FloatArray:
    """Return the radius of the root cone in the plane `z` (mm from mid-face), mm."""
    height = member.profile_shift - member.tool.dedendum / np.cos(member.cone_angle)
    radius = reference_radius(member) + height * np.asarray(member.tool.normal_module)
    return np.asarray(radius + np.asarray(z) * np.tan(member.cone_angle))
