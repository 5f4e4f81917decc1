"""Rack cutter for pictures: its profile, and a solid block."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FLANK_SIGN, FloatArray, flank_sign
from beveloid_geom.gear import rack
from beveloid_geom.gear.fillet import tool_round

from ..rendering.scene import Surface, grid_surface

SPACE_DEPTH_ADDENDA = 1.25
"""Height of the bottom of the tool spaces above the pitch line of the tool, divided by its addendum."""


@dataclass(frozen=True, eq=False)
class SectionFrame:
    """Frame S_n of the normal section of a rack, in the frame S_c of the rack.

    S_c is fixed to the rack cutter and slides with it along y_c while the gear rolls (Fig. 3).

    Attributes
    ----------
    origin : ndarray, shape (3,)
        Origin in S_c, mm.
    axes : ndarray, shape (3, 3)
        Unit vectors along x_n, y_n and z_n (tooth trace) in S_c, as rows.
    """

    origin: FloatArray
    axes: FloatArray


def fitting(tool: Tool) -> Tool:
    """Return the tool with its tip radius, and if necessary its dedendum, reduced until the tip round fits
    between the flanks. If no trial fits: tip radius 0 and dedendum 0.2 modules."""
    for depth in (1.0, 0.8, 0.6, 0.4):
        for share in np.linspace(1.0, 0.0, 21):
            fitted = replace(tool, tip_radius=share * tool.tip_radius, dedendum=depth * tool.dedendum)
            try:
                for flank in FLANK_SIGN:
                    tool_round(fitted, flank)
            except ValueError:
                continue
            return fitted
    return replace(tool, tip_radius=0.0, dedendum=0.2)


def half_profile(tool: Tool, flank: str = "right") -> FloatArray:
    """Return points (n, 2), x_n and the magnitude of y_n, mm, from the middle of the tip over round and flank
    to the middle of the space."""
    module, rounding = float(tool.normal_module), tool_round(tool, flank)
    height = module * float(tool.addendum) * SPACE_DEPTH_ADDENDA
    crossing = 0.25 * np.pi * module / np.sin(float(tool.normal_pressure_angle))
    # The parameter is measured from the apex of the parabola.
    farthest = 0.97 * crossing - float(tool.parabola_apex)
    top = min(float(rack.parameter_at_height(tool, flank, height)), farthest)
    turn, mirror = np.linspace(0.5 * np.pi, rounding.angle, 25), np.array((1.0, flank_sign(flank)))
    centre = np.asarray(rounding.centre) * mirror
    arc = centre - rounding.radius * np.stack((np.sin(turn), np.cos(turn)), axis=-1)
    side = rack.section_point(tool, flank, np.linspace(rounding.joint, top, 61)) * mirror
    middle = np.array([[arc[0, 0], 0.5 * np.pi * module]])
    return np.concatenate((middle, arc, side, [[side[-1, 0], 0.0]]))


def profile(half: FloatArray, module: float, spaces: int, left: FloatArray | None = None) -> FloatArray:
    """Return points (n, 2), (y_n, x_n), over an odd number of spaces, from +y_n; the middle space is at y_n =
    0. `half` is the half profile with the right flank, `left` that with the left flank, by default its mirror
    image."""
    x, y = half.T
    other_x, other_y = (half if left is None else left).T
    right, mirrored = np.stack((y, x), axis=-1), np.stack((-other_y, other_x), axis=-1)
    one = np.concatenate((right, mirrored[::-1][1:]))
    steps = np.pi * module * np.arange(spaces // 2, -(spaces // 2) - 1, -1)
    return np.concatenate([one + np.array([step, 0.0]) for step in steps])


def cutter_frame(member: Member) -> SectionFrame:
    """Return the frame of the normal section of the rack at mid-face and roll 0."""
    origin, along, across = rack.section_frame(member)
    return SectionFrame(origin, np.stack((along, across, rack.rack_of(member, "right").trace)))


def rack_block(
    outline: FloatArray, back: float, frame: SectionFrame, ends: tuple[FloatArray, FloatArray]
) -> list[Surface]:
    """Return a solid block of the rack.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        Profile (y_n, x_n), mm.
    back : float
        Height of the rear face, mm.
    frame : SectionFrame
        Frame of the profile.
    ends : tuple of ndarray
        Two planes (nx, ny, nz, distance) in S_c that limit the block along z_n.
    """
    top = np.stack((outline[:, 0], np.full(len(outline), back)), axis=-1)
    rows = np.stack((outline, top))
    section = frame.origin + rows[..., 1:] * frame.axes[0] + rows[..., :1] * frame.axes[1]
    lengths = [(plane[3] - section @ plane[:3]) / (frame.axes[2] @ plane[:3]) for plane in ends]
    solid = np.stack([section + u[..., None] * frame.axes[2] for u in lengths])  # (ends, heights, n, 3)
    sides = solid[:, 0], solid[:, 1], solid[:, :, 0], solid[:, :, -1], solid[0], solid[1]
    return [grid_surface(side, None, "#f2cf99") for side in sides]
