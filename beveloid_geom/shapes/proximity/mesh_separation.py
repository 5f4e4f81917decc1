"""Separation of two flanks by proximity queries on sampled meshes.

Both flanks are sampled to a tolerance (`sampling`) and placed at a pose, which is a roll of each member. The
separation of a vertex is its
distance from the closest point on the triangles of the other flank. Its error is of the order of the
tolerance. The closest point on a triangle is the start of Newton's method for the foot on the exact flank
(`closest_point.feet`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Codes, FloatArray
from ...contact.mesh_position import Frame, frames_at
from ...design.arguments import require_single
from ...design.member import Member
from ...design.model import Design
from ...gear.closest_point import feet
from ...gear.flank import trace_parameter
from ...pair.frames import to_fixed
from ...status import Status
from ...support.array_repr import short_repr
from .closest_points import closest_on_mesh
from .flank_mesh import FlankMesh, flank_mesh


@dataclass(frozen=True, eq=False)
class MeshSeparation:
    """Separation of the grid points of a flank from the flank of the other member at a pose.

    Attributes
    ----------
    l, z : array (nl, nz)
        Flank parameter and axial coordinate of the grid points, mm.
    points : array (nl, nz, 3)
        Grid points in S_f, mm.
    separation : array (nl, nz)
        mm, positive if there is a gap.
    foot_l, foot_z : array (nl, nz)
        Flank parameter and axial coordinate of the closest point on the other flank, mm.
    status : array (nl, nz)
        SOLVED, OFF_FLANK if the foot is outside the other flank, or NOT_CONVERGED. Values are NaN unless
        SOLVED.
    """

    __repr__ = short_repr

    l: FloatArray
    z: FloatArray
    points: FloatArray
    separation: FloatArray
    foot_l: FloatArray
    foot_z: FloatArray
    status: Codes


def frames_of(design: Design, pinion_roll: float, gear_roll: float) -> tuple[Frame, Frame]:
    """Return the frames of both members of a single design at a pose. Raises ValueError for a batch, and for
    a design without mounting distances."""
    require_single(design)
    frames = frames_at(design, pinion_roll, gear_roll)
    if not all(np.isfinite(part).all() for frame in frames for part in frame):
        why = "an input or a roll is NaN, or the flanks define no mounting distances"
        raise ValueError(f"the pair cannot be positioned: {why}; give mounting distances")
    return frames


def in_frame_of(frames: tuple[Frame, Frame], member: int, points: FloatArray) -> FloatArray:
    """Return points (..., 3) of S_f in the frame of a member."""
    rotation, origin = frames[member]
    return np.asarray((points - origin) @ rotation)


def mesh_separation(
    design: Design,
    flank: str,
    member: int,
    tolerance: float = 1e-3,
    *,
    pinion_roll: float,
    gear_roll: float,
    polish: bool = True,
) -> MeshSeparation:
    """Return the separation of the grid points of a flank from the mating flank.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    member : int
        Member with the grid points: 0 pinion, 1 gear.
    tolerance : float
        Tolerance to which both flanks are sampled, mm.
    pinion_roll, gear_roll : float
        rad.
    polish : bool
        Whether separations and feet are those of the exact flank. Otherwise they are those of its triangles.

    Returns
    -------
    MeshSeparation

    Raises
    ------
    ValueError
        For a batch of designs, a design without mounting distances, and as `sample_flank`.
    """
    meshes = [flank_mesh(part, flank, tolerance) for part in design.members]
    frames = frames_of(design, pinion_roll, gear_roll)
    grid, other = meshes[member].grid, 1 - member
    points = to_fixed(frames[member], grid.points)
    seen = in_frame_of(frames, other, points).reshape(-1, 3)
    values, status = _facet_feet(meshes[other], seen, tolerance)
    if polish:
        values, status = _polished_feet(design.members[other], flank, seen, values)
    values[:, status != Status.SOLVED] = np.nan
    shape = grid.l.shape
    z = np.broadcast_to(grid.z, shape)
    distance, foot_l, foot_z = values.reshape(3, *shape)
    return MeshSeparation(grid.l, z, points, distance, foot_l, foot_z, status.reshape(shape))


def _facet_feet(mesh: FlankMesh, seen: FloatArray, tolerance: float) -> tuple[FloatArray, Codes]:
    """Return the signed distance, l and z (3, n) of the closest points on a mesh, and their status.

    A foot on the rim is accepted if the distance of the point from the normal through the foot is at most the
    tolerance."""
    # Barycentric coordinate below which a closest point is on an edge of its triangle.
    edge_coordinate = 1e-9
    grid, faces = mesh.grid, mesh.faces
    vertices = grid.points.reshape(-1, 3)
    closest, index, weights = closest_on_mesh(vertices, faces, seen)
    on_edge, at_corner = weights < edge_coordinate, weights > 1.0 - 2.0 * edge_coordinate
    place = np.where(on_edge.any(axis=1), 1 + on_edge.argmax(axis=1), 0)
    place = np.where(at_corner.any(axis=1), 4 + at_corner.argmax(axis=1), place)
    normal = mesh.normals[index, place]
    offset = seen - closest
    height = np.einsum("ni,ni->n", offset, normal)
    lateral = np.linalg.norm(offset - height[:, None] * normal, axis=-1)
    z = np.broadcast_to(grid.z, grid.l.shape)
    l, z = (np.einsum("nk,nk->n", weights, v.reshape(-1)[faces[index]]) for v in (grid.l, z))
    # A triangle may have only a corner on the rim.
    corner = at_corner & mesh.border[faces[index]]
    edge = on_edge & mesh.rim[index]
    off = (corner | edge).any(axis=1) & (lateral > tolerance)
    distance = np.copysign(np.linalg.norm(offset, axis=-1), height)
    return np.stack((distance, l, z)), np.where(off, Status.OFF_FLANK, Status.SOLVED).astype(np.int8)


def _polished_feet(
    member: Member, flank: str, seen: FloatArray, start: FloatArray
) -> tuple[FloatArray, Codes]:
    """Return distance, l and z (3, n) of the feet on the exact flank, by Newton's method from those on the
    mesh."""
    u = trace_parameter(member, flank, start[1], start[2])
    exact_feet = feet(member, flank, seen, (start[1], u))
    return np.stack((exact_feet.distance, exact_feet.l, exact_feet.z)), exact_feet.status
