"""Positions of the gears of a pair in the fixed frame S_f, for files of the pair and of its parts."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..contact.mesh_position import Frame, MeshingPair, frames_at
from ..design.model import Design
from ..gear.flank_limits import tip_radius
from ..operation.contact_pattern.motion import UnknownOperationError, unknown_contact
from ..operation.first_contact import first_contact
from ..status import FirstStatus


def rolls_at_first_contact(design: Design, flank: str, roll: float) -> FloatArray:
    """Return the rolls (2,), rad, of pinion and gear for which the first of all teeth touches.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
        Flanks that drive.
    roll : float
        Roll of the pinion, rad.

    Raises
    ------
    UnknownOperationError
        If the first contact at this roll is not known.
    """
    first = first_contact(design, flank, [roll])
    if first.status[0] != FirstStatus.SOLVED:
        raise UnknownOperationError(unknown_contact(flank, int(first.status[0])))
    return np.array([roll, float(first.gear_roll[0])])


def frames_at_roll(design: Design, position: MeshingPair, roll: float | None) -> tuple[Frame, Frame]:
    """Return the frames of pinion and gear in S_f at a roll (rad) of the pinion, where the teeth touch first.

    Without a roll, the flanks touch in the middle of their path of contact, as in `position`."""
    if roll is None:
        return position.frames
    return frames_at(design, *rolls_at_first_contact(design, position.flank, roll))


def near_origin(design: Design, position: MeshingPair) -> FloatArray:
    """Return the origin (3,), mm in S_f, for coordinates in single precision.

    This is the origin of S_f, except for gears that are more than ten times their size away from it, because
    their axes intersect at a small angle. Their coordinates would lose digits, so that the contact point, in
    whole mm, is their origin."""
    size = max(2.0 * float(tip_radius(m, 0.0)) + float(m.face_width) for m in design.members)
    far = np.linalg.norm(position.contact) > 10.0 * size
    return np.round(position.contact) if far else np.zeros(3)
