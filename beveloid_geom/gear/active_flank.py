"""Start of the active flank of a member, and points at given fractions of its depth and face width."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..design.member import Member
from .flank import trace_parameter
from .flank_limits import root_parameter, tip_parameter
from .tooth_side import is_batch, undercut_edge


def active_start(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Return the flank parameter at which an active flank starts.

    Parameters
    ----------
    member : Member
        Undercut is taken into account for single members.
    flank : {'right', 'left'}
    z : array_like
        Planes, mm from mid-face.

    Returns
    -------
    ndarray
        mm, of the shape of `z` broadcast with the member: the end of the fillet, or on an undercut flank its
        intersection with the fillet.
    """
    return active_start_by_z(member, flank)(np.asarray(z, dtype=float))


def active_start_by_z(member: Member, flank: str) -> Callable[[FloatArray], FloatArray]:
    """Return `active_start` of one flank as a function of the planes z (mm)."""
    # Start from the end of the fillet; undercut raises it for single members.
    root = root_parameter(member, flank)
    curve = None if is_batch(member) else undercut_edge(member, flank)
    if curve is None:
        return lambda z: root + 0.0 * z
    return lambda z: np.maximum(root + 0.0 * z, curve.start(z))


def place_at(
    member: Member, flank: str, depth: ArrayLike, face: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points at given fractions of the active depth from the root and of the face from the toe.

    Parameters
    ----------
    member : Member
        A single member.
    flank : {'right', 'left'}
    depth, face : array_like
        Fractions, which broadcast.

    Returns
    -------
    tuple of ndarray
        l, z and u, mm.

    Raises
    ------
    ValueError
        If the flank does not reach its tip cone.
    """
    z = float(member.face_width) * (np.asarray(face, dtype=float) - 0.5)
    root, tip = active_start(member, flank, z), tip_parameter(member, flank, z)
    if not np.isfinite(tip).all():
        cure = "reduce the addendum or the profile shift"
        raise ValueError(f"the {flank} flank does not reach its tip cone: {cure}")
    l = root + np.asarray(depth, dtype=float) * (tip - root)
    z = np.broadcast_to(z, l.shape)
    return l, z, trace_parameter(member, flank, l, z)
