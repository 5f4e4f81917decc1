"""The rack cutter as something to look at: its profile, and a block of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.fillet import tool_round
from beveloid_geom.gear.rack import parameter_at_height, rack_of, section_point

from ..stage.scene import Surface, grid_surface

TOP = 1.25
"""Depth of the tool's spaces above its pitch line, in addenda."""


@dataclass(frozen=True, eq=False)
class SectionFrame:
    """The frame S_n of a rack at its gear: `origin` (3,) and unit vectors along x_n, y_n and
    z_n, the tooth trace, rows of `axes` (3, 3), in S_c; mm."""

    origin: FloatArray
    axes: FloatArray


def fitting(tool: Tool) -> Tool:
    """Make the tool with a tip round, and if need be a tip, that fits between its flanks."""
    for depth in (1.0, 0.8, 0.6, 0.4):
        for share in np.linspace(1.0, 0.0, 21):
            fitted = replace(tool, tip_radius=share * tool.tip_radius, dedendum=depth * tool.dedendum)
            try:
                tool_round(fitted, "right")
            except ValueError:
                continue
            return fitted
    return replace(tool, tip_radius=0.0, dedendum=0.2)


def half_profile(tool: Tool) -> FloatArray:
    """Give (x_n, y_n) (n, 2) from the middle of the tool's tip over round and right flank to the middle of
    its space, mm."""
    module, rounding = float(tool.normal_module), tool_round(tool, "right")
    height = module * float(tool.addendum) * TOP
    crossing = 0.25 * np.pi * module / np.sin(float(tool.normal_pressure_angle))
    top = min(float(parameter_at_height(tool, height)), 0.97 * crossing)
    turn = np.linspace(0.5 * np.pi, rounding.angle, 25)
    arc = np.asarray(rounding.centre) - rounding.radius * np.stack((np.sin(turn), np.cos(turn)), axis=-1)
    flank = section_point(tool, "right", np.linspace(rounding.joint, top, 61))
    middle = np.array([[arc[0, 0], 0.5 * np.pi * module]])
    return np.concatenate((middle, arc, flank, [[flank[-1, 0], 0.0]]))


def profile(half: FloatArray, module: float, spaces: int) -> FloatArray:
    """Give (y_n, x_n) (n, 2) over an odd number of spaces, the middle one around y_n = 0, from +y_n on."""
    x, y = half.T
    right = np.stack((y, x), axis=-1)
    one = np.concatenate((right, (right * (-1.0, 1.0))[::-1][1:]))
    steps = np.pi * module * np.arange(spaces // 2, -(spaces // 2) - 1, -1)
    return np.concatenate([one + np.array([step, 0.0]) for step in steps])


def section_frame(member: Member) -> SectionFrame:
    """Say where the rack's normal section at mid-face stands, at roll 0."""
    rack, alpha = rack_of(member, "right"), float(member.tool.normal_pressure_angle)
    along = np.cos(alpha) * rack.direction + np.sin(alpha) * rack.normal
    across = np.cos(alpha) * rack.normal - np.sin(alpha) * rack.direction
    origin = rack.apex - 0.25 * np.pi * float(member.tool.normal_module) * across
    return SectionFrame(origin, np.stack((along, across, rack.trace)))


def block(
    outline: FloatArray, back: float, frame: SectionFrame, ends: tuple[FloatArray, FloatArray], colour: str
) -> list[Surface]:
    """Make a block of the rack below the height `back` (mm). `outline` (n, 2) is its profile (y_n, x_n);
    `ends` are two planes (nx, ny, nz, distance) in S_c between which it reaches along z_n."""
    top = np.stack((outline[:, 0], np.full(len(outline), back)), axis=-1)
    rows = np.stack((outline, top))
    section = frame.origin + rows[..., 1:] * frame.axes[0] + rows[..., :1] * frame.axes[1]
    lengths = [(plane[3] - section @ plane[:3]) / (frame.axes[2] @ plane[:3]) for plane in ends]
    solid = np.stack([section + u[..., None] * frame.axes[2] for u in lengths])  # (ends, heights, n, 3)
    sides = solid[:, 0], solid[:, 1], solid[:, :, 0], solid[:, :, -1], solid[0], solid[1]
    return [grid_surface(side, None, colour) for side in sides]
