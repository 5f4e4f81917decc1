"""The pair at rolls of the pinion: surfaces and poses, and which tooth pairs can matter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..contact.equation import pairing_of
from ..contact.path_polynomial import PHASE, exact_rows
from ..design.model import Design, Errors
from ..gear.tooth_side import Surface, angle_of, cut_at, surface_of
from ..pair.mounting import mounting_of
from ..support.read_only import kept
from .least_clearance import Task
from .separation import Pose, pose_of

FAR = 0.5
"""Tip radii by which a pitch point may miss the tip cylinder and still tell where the teeth mesh."""
REACH = 2
"""Tooth pairs looked at on either side, beside those among which a face with a helix spreads."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Both surfaces; by position (n,) the pose, the pinion's roll, the gear's conjugate `phase`
    (rad) and the tooth pair `nearest` to the pitch point; `pitch` (rad) of pinion and gear; the
    gear's `lever` (mm), the module, and how many tooth pairs can matter on either side, `reach`. After
    the gear's turn by `period` (rad) the same two teeth can meet again, as tooth pair `again` further on.
    `defined` (n,): whether all but the phase is known. Where each position begins a curve, `span` is how many
    pitches of the pinion that is long."""

    own: Surface
    other: Surface
    pose: Pose
    roll: FloatArray
    phase: FloatArray
    nearest: Integers
    pitch: tuple[float, float]
    lever: float
    module: float
    reach: int
    period: float
    again: int
    defined: Mask
    span: float = 1.0

    @property
    def turns(self) -> float:
        """Turns of a tooth of the pinion round its axis along the face."""
        return abs(float(self.own.trace[1])) * self.own.half_width / (np.pi * self.own.pitch_radius)

    @property
    def near(self) -> Integers:
        """Give tooth pairs that can matter, from the nearest on: every tooth of the pinion once."""
        teeth = round(2.0 * np.pi / self.pitch[0])
        every = np.arange(-self.reach, self.reach + 1)
        return every if every.size <= teeth else np.arange(teeth) - teeth // 2

    def task(self, position: Integers, pair: Integers) -> Task:
        """Give tooth pairs `pair` at the positions with these numbers, each (n,)."""
        roll = self.roll[position] + pair * self.pitch[0]
        start = self.phase[position] - self.pitch[1] / self.pitch[0] * roll
        return Task(self.own, self.other, self.lever, self.pose.at(position), roll, start, self.period)

    def at(self, position: Integers, roll: FloatArray) -> Mesh:
        """Give other rolls (n,), rad, of the pairs at the positions with these numbers (n,)."""
        turned = np.rint((roll - self.roll[position]) / self.pitch[0]).astype(int)
        return replace(
            self,
            pose=self.pose.at(position),
            roll=roll,
            phase=self.phase[position],
            nearest=self.nearest[position] - turned,
            defined=self.defined[position],
        )


def conjugate_phase(design: Design, flank: str) -> FloatArray:
    """Give the gear roll plus N1/N2 pinion roll (rad) of the unmodified pair without errors: the same in all
    its contacts. NaN without a common normal."""
    plain = Design(design.pinion, design.gear, design.pair, Errors()).with_parabola(0.0, 0.0)
    return _conjugate_phase(plain, flank) if plain.batch_shape else _kept_phase(plain, flank)


def _conjugate_phase(plain: Design, flank: str) -> FloatArray:
    pairing = pairing_of(plain, flank)
    with np.errstate(invalid="ignore", divide="ignore"):
        rows, _ = exact_rows(pairing, np.zeros((pairing.branch.shape[0], 1)))
    return rows[PHASE, :, 0].reshape(plain.batch_shape)


_kept_phase = kept(16)(_conjugate_phase)


def middle_roll(design: Design, flank: str) -> FloatArray:
    """Give the roll (rad) at which the pinion's flank of tooth 0 passes the pitch point, of the batch shape.
    Where that is far from the teeth, as between nearly parallel axes, it passes where the gear is nearest."""
    mounting, surface, pose = mounting_of(design), surface_of(design.pinion, flank), pose_of(design)
    x, y = (mounting.pitch_point[..., k] for k in (0, 1))
    far = ~((x > 0.0) & (np.abs(np.hypot(x, y) - surface.tip) < FAR * surface.tip))
    across = np.nan_to_num(pose.position[0] * pose.sin * pose.cos)  # of the gear's axis, beside the offset
    x, y = np.where(far, np.nan_to_num(pose.offset), x), np.where(far, across, y)
    z = _pitch_height(design, surface)
    return np.asarray(np.arctan2(y, x) - angle_of(cut_at(surface, np.zeros_like(z), z)))


def _pitch_height(design: Design, surface: Surface) -> FloatArray:
    """Give z (mm) of the pitch point on the pinion, or of the end of its face beyond which it lies."""
    mounting = mounting_of(design)
    z = np.nan_to_num(mounting.pitch_distance[0] - mounting.distance[0])
    return np.asarray(np.clip(z, -surface.half_width, surface.half_width))


def spread(design: Design, flank: str) -> float:
    """Give the greatest number of pitches, over a batch, by which the tooth trace on the pinion's pitch
    cylinder departs on its face from the pitch point: so far from it teeth can touch by overlap."""
    surface = surface_of(design.pinion, flank)
    length = surface.half_width + np.abs(_pitch_height(design, surface)).max()
    turn = length * np.abs(surface.trace[1]) / surface.pitch_radius
    return float(turn * float(design.pinion.teeth) / (2.0 * np.pi))


def mesh_of(
    design: Design, flank: str, roll: FloatArray, middle: FloatArray | None = None
) -> tuple[Mesh, FloatArray]:
    """Give the mesh at all positions, and its phase by position. `middle`: the `middle_roll`, if known."""
    own, other = (surface_of(member, flank) for member in design.members)
    phase = np.broadcast_to(conjugate_phase(design, flank)[..., None], roll.shape).reshape(-1)
    pose = pose_of(design)
    by_position = [
        np.broadcast_to(value[..., None], roll.shape).reshape(-1)
        for value in (pose.offset, pose.sin, pose.cos, *pose.position)
    ]
    tool, teeth = design.gear.tool, [int(member.teeth) for member in design.members]
    lever = 0.5 * float(tool.normal_module) * teeth[1] * np.cos(float(tool.normal_pressure_angle))
    middle = middle_roll(design, flank) if middle is None else middle
    middle = np.broadcast_to(middle[..., None], roll.shape).reshape(-1)
    pitch = (2.0 * np.pi / teeth[0], 2.0 * np.pi / teeth[1])
    mesh = Mesh(
        own=own,
        other=other,
        pose=Pose(by_position[0], by_position[1], by_position[2], np.stack(by_position[3:])),
        roll=roll.reshape(-1),
        phase=np.nan_to_num(phase),
        nearest=np.rint((middle - roll.reshape(-1)) / pitch[0]).astype(int),
        pitch=pitch,
        lever=lever,
        module=float(tool.normal_module),
        reach=REACH + int(np.ceil(spread(design, flank))),
        period=min(teeth) * pitch[1],
        again=teeth[0] if teeth[0] < teeth[1] else 0,
        defined=np.isfinite(sum(by_position) + own.highest + other.highest),
    )
    return mesh, phase
