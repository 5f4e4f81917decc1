"""Errors of contact by meshes, as a function of the tolerance to which the flanks are sampled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray, Indices
from ...contact.path import path_of_contact
from ...design.model import Design
from ...gear.closest_point import feet
from ...status import Status
from .flank_mesh import flank_mesh
from .mesh_contact import mesh_contact
from .mesh_separation import frames_of, in_frame_of, mesh_separation


@dataclass(frozen=True, eq=False)
class Convergence:
    """Errors of contact by meshes at one pose.

    Attributes
    ----------
    tolerance : array (n,)
        mm.
    point_error : array (n,)
        Distance of the contact point from that of the path of contact, mm; NaN without contact point.
    separation_error : array (n,)
        Largest error of the separation at the grid points of the pinion, mm.
    faces : array (n,)
        Number of triangles of both flanks.
    """

    tolerance: FloatArray
    point_error: FloatArray
    separation_error: FloatArray
    faces: Indices


def convergence(
    design: Design,
    flank: str,
    tolerances: ArrayLike,
    polish: bool = True,
    *,
    share: float = 0.5,
) -> Convergence:
    """Return errors of contact by meshes at one pose of the path of contact.

    The references are the contact of `path_of_contact` and the distance from the exact flank.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    tolerances : array (n,)
        Sampling tolerances, mm.
    polish : bool
        As in `mesh_contact`.
    share : float
        Position of the pose along the path, 0 ... 1.

    Returns
    -------
    Convergence

    Raises
    ------
    ValueError
        If the path has no contact on the flanks, if no vertex is opposite the other flank, and as
        `mesh_separation`.
    """
    path = path_of_contact(design, flank, 3)
    if not len(path.l1):
        raise ValueError(f"the {flank} flanks have no contact: the contact of meshes cannot be compared")
    l1 = path.ends.l1[0] + share * (path.ends.l1[1] - path.ends.l1[0])
    path = path_of_contact(design, flank, l1=[l1])
    pose = {"pinion_roll": float(path.pinion_roll[0]), "gear_roll": float(path.gear_roll[0])}
    frames, rows = frames_of(design, **pose), []
    tolerance = np.atleast_1d(np.asarray(tolerances, dtype=float))
    for size in tolerance.tolist():
        contact = mesh_contact(design, flank, size, **pose, polish=polish)
        side = mesh_separation(design, flank, 0, size, **pose, polish=polish)
        exact = feet(design.gear, flank, in_frame_of(frames, 1, side.points))
        error = np.abs(side.separation - exact.distance)[exact.status == Status.SOLVED]
        if not error.size:
            opposite = f"no vertex of the mesh is opposite the other {flank} flank"
            raise ValueError(f"{opposite} at a tolerance of {size:g} mm: reduce the tolerance")
        faces = sum(len(flank_mesh(member, flank, size).faces) for member in design.members)
        rows.append((np.linalg.norm(contact.point - path.point[0]), np.nanmax(error), faces))
    point_error, separation_error, faces = np.array(rows).T
    return Convergence(tolerance, point_error, separation_error, faces.astype(np.int64))
