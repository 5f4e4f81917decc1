"""The pair as it stands in mesh: its flanks touching in the middle of the path of contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..design.model import Design
from ..gear.flank import flank_patch
from ..pair.frames import layout_of, member_frame
from ..pair.mounting import mounting_of
from .path import ContactPath, path_of_contact

Frame: TypeAlias = tuple[FloatArray, FloatArray]
"""Rotation (3, 3) and origin (3,), mm, that carry a member's own frame to S_f."""


@dataclass(frozen=True, eq=False)
class MeshingPair:
    """A single pair in mesh. `roll` (2,), rad, and `position` (2,) along the axes, mm, pinion
    first; `contact` (3,) in S_f, mm; `frames` carry the members' own frames to S_f; `point` (mm)
    and unit `normal` (2, 3): the contact in each member's own frame, on the flank of its tooth 0,
    out of that tooth; `path`: three positions of the path of contact, the pair stands at the second."""

    flank: str
    roll: FloatArray
    position: FloatArray
    contact: FloatArray
    frames: tuple[Frame, Frame]
    point: FloatArray
    normal: FloatArray
    path: ContactPath


def mid_faces(design: Design) -> FloatArray:
    """Give distances (2,) of the mid-faces from the common perpendicular along the axes of a single design,
    axial errors included, mm."""
    axial = np.array([design.errors.pinion_axial, design.errors.gear_axial], dtype=float)
    return np.asarray(mounting_of(design).distance + axial)


def frames_at(design: Design, pinion_roll: ArrayLike, gear_roll: ArrayLike) -> tuple[Frame, Frame]:
    """Give frames of pinion and gear of a single design at rolls (rad), errors included."""
    layout, position = layout_of(design), mid_faces(design)
    first, second = (member_frame(layout, j, r, position[j]) for j, r in enumerate((pinion_roll, gear_roll)))
    return first, second


def meshing_pair(design: Design, flank: str = "right") -> MeshingPair:
    """Give a single pair, errors included, in the middle of its path of contact: midway in pinion roll
    between entering and leaving the flanks (midway where the roll turns back).

    Raises ValueError where the path has no point on the flanks or could not be followed."""
    if design.batch_shape:
        raise ValueError(f"a pose is that of one design, got a batch of the shape {design.batch_shape}")
    path = path_of_contact(design, flank, points=3)
    if not len(path.pinion_roll) or not np.isfinite(path.pinion_roll[1]):
        raise ValueError(f"the {flank} flanks have no path of contact on which the pair could be posed")
    roll = np.array([path.pinion_roll[1], path.gear_roll[1]])
    places = (design.pinion, path.l1[1], path.u1[1]), (design.gear, path.l2[1], path.u2[1])
    own = [flank_patch(member, flank, l, u) for member, l, u in places]
    return MeshingPair(
        flank,
        roll,
        mid_faces(design),
        path.point[1],
        frames_at(design, *roll),
        np.stack([patch.point for patch in own]),
        np.stack([patch.normal for patch in own]),
        path,
    )
