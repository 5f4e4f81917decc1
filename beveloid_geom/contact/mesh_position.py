"""The pair in mesh position: its flanks touch in the middle of the path of contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..design.arguments import require_single
from ..design.model import Design
from ..gear.flank import flank_patch
from ..pair.frames import layout_of, member_frame
from ..pair.mounting import mounting_of
from .path import ContactPath, path_of_contact

Frame: TypeAlias = tuple[FloatArray, FloatArray]
"""Rotation (3, 3) and origin (3,), mm, that transform from the frame of a member to S_f."""


@dataclass(frozen=True, eq=False)
class MeshingPair:
    """A single pair in mesh.

    Pinion first: `roll` (2,), rad, and `position` (2,) along the axes, mm; `frames` transform from the frames
    of the members to S_f; `point` (mm) and unit `normal` (2, 3) of the contact in the frame of each member,
    on the flank of its tooth 0, out of this tooth. `contact` (3,) in S_f, mm; `path`: three positions of the
    path of contact, of which the second is the mesh position.
    """

    flank: str
    roll: FloatArray
    position: FloatArray
    contact: FloatArray
    frames: tuple[Frame, Frame]
    point: FloatArray
    normal: FloatArray
    path: ContactPath


def mid_faces(design: Design) -> FloatArray:
    """Return distances (2,), mm, of the mid-faces from the common perpendicular along the axes of a single
    design, with axial errors.
    """
    axial = np.array([design.errors.pinion_axial, design.errors.gear_axial], dtype=float)
    return np.asarray(mounting_of(design).distance + axial)


def frames_at(design: Design, pinion_roll: ArrayLike, gear_roll: ArrayLike) -> tuple[Frame, Frame]:
    """Return the frames of pinion and gear of a single design at given rolls, with errors.

    Parameters
    ----------
    design : Design
        A single design.
    pinion_roll, gear_roll : array_like
        Rolls, rad.

    Returns
    -------
    tuple of Frame
        Frames of pinion and gear in S_f.
    """
    layout, position = layout_of(design), mid_faces(design)
    first, second = (member_frame(layout, j, r, position[j]) for j, r in enumerate((pinion_roll, gear_roll)))
    return first, second


def meshing_pair(design: Design, flank: str = "right") -> MeshingPair:
    """Return a single pair, with errors, in the middle of its path of contact.

    The middle is at half the pinion roll between entering and leaving the flanks, or at the middle of the
    path parameter if the roll turns back.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}

    Returns
    -------
    MeshingPair

    Raises
    ------
    ValueError
        For a batch, and if the path has no point on the flanks or could not be computed.
    """
    require_single(design)
    path = path_of_contact(design, flank, points=3)
    if not len(path.pinion_roll) or not np.isfinite(path.pinion_roll[1]):
        raise ValueError(f"the {flank} flanks have no path of contact, so that the gears cannot be placed")
    # The second of three positions is at mid-roll.
    roll = np.array([path.pinion_roll[1], path.gear_roll[1]])
    places = (design.pinion, path.l1[1], path.u1[1]), (design.gear, path.l2[1], path.u2[1])
    patches = [flank_patch(member, flank, l, u) for member, l, u in places]
    return MeshingPair(
        flank,
        roll,
        mid_faces(design),
        path.point[1],
        frames_at(design, *roll),
        np.stack([patch.point for patch in patches]),
        np.stack([patch.normal for patch in patches]),
        path,
    )
