"""Separation and contact of two flanks by surface proximity queries on sampled meshes.

This is the route by meshes: both flanks are sampled to a tolerance (`sampling`), posed, and the
separation of a vertex is its distance to the closest point on the other flank's triangles. Its
error is of the order of the tolerance in the separation; the contact point, where the separation
is least, is worse: by the square root of tolerance over relative curvature, which in approximate
line contact makes millimetres of a micrometre, and depends on where the vertices happen to lie.
`convergence` charts both.

Hence the polish. A facet's answer starts Newton for the foot on the flank itself (`perpendicular.feet`),
and the vertex of least separation starts Newton for the standstill of the exact separation D,
as a function of the pinion's flank parameters. With the outward unit normals n1 at the point and
n2 at its foot on the gear,

    dD = n2.dR1 = 0,    d2D = dR1.A_2' dR1 + n2.d2R1,

where A_2' maps a step to the change of n2 on the gear's parallel surface through the point. With
n2 = -n1, as holds where D stands still, n2.d2R1 is dn1.dR1; so the steps converge quadratically.
They lead downhill only, off saddles, and what they end at must be a minimum beyond rounding: as the
smaller relative curvature vanishes none is given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Indices
from ..contact.ellipse import normal_rates
from ..contact.path import path_of_contact
from ..contact.placing import Frame, frames_at
from ..design.model import Design, Member
from ..gear.flank import flank_patch, flank_point, highest_parameter, root_parameter, trace_parameter
from ..gear.perpendicular import Feet, feet
from ..pair.frames import normals_to_fixed, to_fixed
from ..status import Status
from ..support.few_lines import few_lines
from .closest_points import closest_on_mesh
from .flank_mesh import FlankMesh, flank_mesh

CONTACT_PASSES = 60
LONGEST_STEP = 0.5
"""Greatest step of the contact search, as a share of the flank's depth along l and of its width, which
counts as the depth at least."""
LAST_STEP, NOISE, CERTAIN = 1e-6, 1e-12, 1e-8
"""Shares of the flank's depth: a step of the contact search below which it is the last, as ordinarily
it leaves an error of its square; separation that is rounding; doubt about the place of a polished
contact above which there is none."""
SLOPE_NOISE = 16.0 * np.finfo(float).eps
"""Slope of the separation that is rounding."""
ALIKE = 4.0
"""Tolerances by which a grid point's separation may be above the least and the contact still be beside
it: either mesh may be off by one, and so may the separation between grid points, once for each."""
ON_RIM = 1e-9
"""Barycentric coordinate below which a closest point counts as on an edge of its triangle."""


@dataclass(frozen=True, eq=False)
class MeshSeparation:
    """Separation of a flank's grid points from the other member's flank at a pose.

    `l` (nl, nz), `z` (nl, nz), mm: the grid points on their own flank; `points` (nl, nz, 3), mm,
    in S_f; `separation` (nl, nz), mm, positive where the flanks are clear of each other;
    `foot_l`, `foot_z` (nl, nz), mm: the closest point on the other flank; `status`: SOLVED,
    OFF_FLANK where the foot leaves the other flank, NOT_CONVERGED; NaN there."""

    __repr__ = few_lines

    l: FloatArray
    z: FloatArray
    points: FloatArray
    separation: FloatArray
    foot_l: FloatArray
    foot_z: FloatArray
    status: Codes


@dataclass(frozen=True, eq=False)
class MeshContact:
    """The point of least separation at a pose. `point` (3,) in S_f, mm, midway between the flanks;
    `separation`, mm; flank parameters `l` and axial coordinates `z` (2,), mm, pinion first;
    `doubt`, mm: how far from there the least separation may lie. By facets that is estimated,
    as far as other grid points are as near within their error: millimetres, or the whole flank;
    polished it is what rounding leaves. `status` as in `MeshSeparation`; NOT_CONVERGED also where the
    separation is no minimum or rounding hides whether it is. NaN where not SOLVED."""

    point: FloatArray
    separation: float
    l: FloatArray
    z: FloatArray
    doubt: float
    status: Status


@dataclass(frozen=True, eq=False)
class Convergence:
    """Errors of the route by meshes at one pose, arrays over `tolerance` (mm).

    `point_error` (mm): distance of the contact point from that of the path of contact;
    `separation_error` (mm): greatest error of the separation over the points of the pinion's
    grid; `faces`: triangles of both flanks. NaN where there is no contact point."""

    tolerance: FloatArray
    point_error: FloatArray
    separation_error: FloatArray
    faces: Indices


def _frames(design: Design, pinion_roll: float, gear_roll: float) -> tuple[Frame, Frame]:
    if design.batch_shape:
        raise ValueError(f"meshes are those of one design, got a batch of the shape {design.batch_shape}")
    frames = frames_at(design, pinion_roll, gear_roll)
    if not all(np.isfinite(part).all() for frame in frames for part in frame):
        why = "a quantity is not a number, or no mounting distances follow from the flanks"
        raise ValueError(f"the design leaves nothing to solve, it cannot be posed: {why}")
    return frames


def _seen_from(frames: tuple[Frame, Frame], member: int, points: FloatArray) -> FloatArray:
    """Carry points (..., 3) of S_f to a member's own frame."""
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
    """Find the separation of the grid points of a `member`'s flank (0 pinion, 1 gear) from the other's flank.

    Both flanks are sampled to `tolerance` (mm). Without `polish` separations and feet are those of
    the other's triangles, else of its flank. Raises ValueError for a batch of designs, for one that
    cannot be posed, and as `sample_flank` does."""
    meshes = [flank_mesh(part, flank, tolerance) for part in design.members]
    frames = _frames(design, pinion_roll, gear_roll)
    own, other = meshes[member].grid, 1 - member
    points = to_fixed(frames[member], own.points)
    seen = _seen_from(frames, other, points).reshape(-1, 3)
    values, status = _facet_feet(meshes[other], seen, tolerance)
    if polish:
        values, status = _polished_feet(design.members[other], flank, seen, values)
    values[:, status != Status.SOLVED] = np.nan
    shape = own.l.shape
    z = np.broadcast_to(own.z, shape)
    distance, foot_l, foot_z = values.reshape(3, *shape)
    return MeshSeparation(own.l, z, points, distance, foot_l, foot_z, status.reshape(shape))


def _facet_feet(mesh: FlankMesh, seen: FloatArray, tolerance: float) -> tuple[FloatArray, Codes]:
    """Find the signed distance, l and z (3, n) of the closest points on a mesh, and status.

    A foot on the rim is on the flank if it is beside the point by no more than the tolerance."""
    grid, faces = mesh.grid, mesh.faces
    vertices = grid.points.reshape(-1, 3)
    closest, index, weights = closest_on_mesh(vertices, faces, seen)
    on_edge, at_corner = weights < ON_RIM, weights > 1.0 - 2.0 * ON_RIM
    place = np.where(on_edge.any(axis=1), 1 + on_edge.argmax(axis=1), 0)
    place = np.where(at_corner.any(axis=1), 4 + at_corner.argmax(axis=1), place)
    normal = mesh.normals[index, place]
    offset = seen - closest
    height = np.einsum("ni,ni->n", offset, normal)
    aside = np.linalg.norm(offset - height[:, None] * normal, axis=-1)
    z = np.broadcast_to(grid.z, grid.l.shape)
    l, z = (np.einsum("nk,nk->n", weights, v.reshape(-1)[faces[index]]) for v in (grid.l, z))
    # A triangle may have but a corner on the rim.
    corner = at_corner & mesh.border[faces[index]]
    edge = on_edge & mesh.rim[index]
    off = (corner | edge).any(axis=1) & (aside > tolerance)
    distance = np.copysign(np.linalg.norm(offset, axis=-1), height)
    return np.stack((distance, l, z)), np.where(off, Status.OFF_FLANK, Status.SOLVED).astype(np.int8)


def _polished_feet(
    member: Member, flank: str, seen: FloatArray, start: FloatArray
) -> tuple[FloatArray, Codes]:
    """Give the same on the flank itself, by Newton from the feet on the mesh."""
    u = trace_parameter(member, flank, start[1], start[2])
    found = feet(member, flank, seen, (start[1], u))
    return np.stack((found.distance, found.l, found.z)), found.status


def mesh_contact(
    design: Design,
    flank: str,
    tolerance: float = 1e-3,
    *,
    pinion_roll: float,
    gear_roll: float,
    polish: bool = True,
) -> MeshContact:
    """Give the contact at a pose as the least separation of the flanks, sampled to `tolerance` (mm).

    Without `polish` it is found among the vertices of both meshes and the closest points of these on
    the other mesh. With it the exact separation is brought to its standstill from there. A least
    separation on an edge is not a tangency: OFF_FLANK with `polish`.

    Raises ValueError as `mesh_separation` does."""
    pose = {"pinion_roll": float(pinion_roll), "gear_roll": float(gear_roll)}
    rough = _facet_contact(design, flank, tolerance, pose)
    if not polish or rough.status != Status.SOLVED:
        return rough
    return _polished_contact(design, flank, _frames(design, **pose), rough)


def _no_contact(status: Status) -> MeshContact:
    pair = np.full(2, np.nan)
    return MeshContact(np.full(3, np.nan), float("nan"), pair, pair, float("nan"), status)


def _facet_contact(design: Design, flank: str, tolerance: float, pose: dict[str, float]) -> MeshContact:
    """Give the vertex of least separation and its closest point on the other mesh."""
    sides = [mesh_separation(design, flank, j, tolerance, **pose, polish=False) for j in (0, 1)]
    least = [np.nanmin(np.append(side.separation, np.inf)) for side in sides]
    member = int(np.argmin(least))
    if least[member] == np.inf:
        return _no_contact(Status.OFF_FLANK)
    side, other = sides[member], 1 - member
    at = np.unravel_index(np.nanargmin(side.separation), side.l.shape)
    l, z = (np.array((own[at], foot[at])) for own, foot in ((side.l, side.foot_l), (side.z, side.foot_z)))
    u = trace_parameter(design.members[other], flank, l[1], z[1])
    foot = to_fixed(_frames(design, **pose)[other], flank_point(design.members[other], flank, l[1], u))
    pinion_first, point = [member, other], 0.5 * (side.points[at] + foot)
    near = [_near_least(each, least[member] + ALIKE * tolerance) for each in sides]
    doubt = float(np.linalg.norm(np.concatenate(near) - point, axis=-1).max())
    return MeshContact(point, float(least[member]), l[pinion_first], z[pinion_first], doubt, Status.SOLVED)


def _near_least(side: MeshSeparation, bound: float) -> FloatArray:
    """Find the grid points (n, 3) of the cells about those points whose separation is within the bound,
    S_f."""
    near = np.pad(side.separation <= bound, 1)  # no NaN is
    rows, columns = near.shape
    beside = [near[i : rows - 2 + i, j : columns - 2 + j] for i in range(3) for j in range(3)]
    return np.asarray(side.points[np.any(beside, axis=0)])


def _polished_contact(
    design: Design, flank: str, frames: tuple[Frame, Frame], rough: MeshContact
) -> MeshContact:
    """Give the least of the exact separation, downhill from a mesh's contact: steps are Newton's where the
    separation is convex, and never lead to a greater one."""
    pinion, reach = design.pinion, 1.0
    depth = float(highest_parameter(pinion) - root_parameter(pinion))
    longest = LONGEST_STEP * np.array((depth, max(depth, pinion.face_width)))
    place = np.array((rough.l[0], trace_parameter(pinion, flank, rough.l[0], rough.z[0])))
    here = _separation_at(design, flank, frames, place)
    for _ in range(CONTACT_PASSES):
        step = here.step(longest, reach)
        there = _separation_at(design, flank, frames, place + step)
        if there.foot.distance <= here.foot.distance + NOISE * depth:
            place, here, reach = place + step, there, min(1.0, 2.0 * reach)
            if np.abs(step).max() <= LAST_STEP * depth:
                break
        else:  # or NaN
            reach *= 0.25
    own = feet(pinion, flank, _seen_from(frames, 0, here.point), tuple(place))
    doubt = float(here.doubt(longest))
    if own.status == Status.OFF_FLANK or here.foot.status == Status.OFF_FLANK:
        return _no_contact(Status.OFF_FLANK)
    if not (doubt <= CERTAIN * depth and own.status == here.foot.status == Status.SOLVED):
        return _no_contact(Status.NOT_CONVERGED)
    middle = here.point - 0.5 * here.foot.distance * normals_to_fixed(frames[1], here.foot.normal)
    pair = (np.array((place[0], here.foot.l)), np.array((own.z, here.foot.z)))
    return MeshContact(middle, float(here.foot.distance), *pair, doubt, Status.SOLVED)


@dataclass(frozen=True, eq=False)
class _Local:
    """The exact separation at a point (3,) of the pinion's flank, S_f, mm: its `foot` on the gear, `slope`
    (2,) and `bend` (2, 2) by the flank parameters (l, u), and the `metric` (2, 2) of these."""

    point: FloatArray
    foot: Feet
    slope: FloatArray
    bend: FloatArray
    metric: FloatArray

    def step(self, longest: FloatArray, reach: float) -> FloatArray:
        """Find the step (2,) downhill: Newton's along each direction of curvature that is positive, as
        long for a negative one, and no longer than the `reach` share of `longest` (2,), mm."""
        if not np.isfinite(self.bend).all():
            return np.full(2, np.nan)
        curvature, directions = np.linalg.eigh(self.bend * np.outer(longest, longest))
        share = -(directions.T @ (self.slope * longest)) / np.maximum(np.abs(curvature), 1e-300)
        return np.asarray(longest * (directions @ np.clip(share, -reach, reach)))

    def doubt(self, longest: FloatArray) -> float:
        """Say how far (mm) the least separation may be from here: the Newton step that is left, and the
        slope's rounding over the least curvature. Infinite where the separation is not convex."""
        if not np.isfinite(self.bend).all():
            return float("inf")
        root = np.linalg.inv(np.linalg.cholesky(self.metric))
        curvature = np.linalg.eigvalsh(root @ self.bend @ root.T)[0]
        left = np.abs(self.step(longest, 1.0)).max()
        return float(max(left, SLOPE_NOISE / curvature)) if curvature > 0.0 else float("inf")


def _separation_at(design: Design, flank: str, frames: tuple[Frame, Frame], place: FloatArray) -> _Local:
    """Give the separation from the gear's flank at the place (l, u) of the pinion's."""
    l, u = place
    own = flank_patch(design.pinion, flank, l, u)
    point = to_fixed(frames[0], own.point)
    foot = feet(design.gear, flank, _seen_from(frames, 1, point))
    met = flank_patch(design.gear, flank, foot.l, foot.u)
    steps, turns, other_steps, other_turns = (
        np.stack([normals_to_fixed(frame, vector) for vector in pair], axis=-1)
        for frame, pair in (
            (frames[0], (own.tangent_l, own.tangent_u)),
            (frames[0], normal_rates(design.pinion, flank, l, u)),
            (frames[1], (met.tangent_l, met.tangent_u)),
            (frames[1], normal_rates(design.gear, flank, foot.l, foot.u)),
        )
    )
    slope = steps.T @ normals_to_fixed(frames[1], foot.normal)
    parallel = other_steps + foot.distance * other_turns
    across = np.linalg.solve(parallel.T @ parallel, parallel.T @ steps)
    bend = steps.T @ (other_turns @ across + turns)
    return _Local(point, foot, slope, 0.5 * (bend + bend.T), steps.T @ steps)


def convergence(
    design: Design,
    flank: str,
    tolerances: ArrayLike,
    polish: bool = True,
    *,
    share: float = 0.5,
) -> Convergence:
    """Find errors of the route by meshes for sampling `tolerances` (n,), mm, at one pose of the path of
    contact.

    `share` (0 ... 1): how far the pose is along the path, in pinion roll. The reference is the contact of
    `path_of_contact` and the distance to the flank itself. Raises ValueError where the path has
    no contact on the flanks, and as `mesh_separation` does."""
    path = path_of_contact(design, flank, 3)
    if not len(path.l1):
        raise ValueError(f"the {flank} flanks have no contact with which to compare that of the meshes")
    l1 = path.ends.l1[0] + share * (path.ends.l1[1] - path.ends.l1[0])
    path = path_of_contact(design, flank, l1=[l1])
    pose = {"pinion_roll": float(path.pinion_roll[0]), "gear_roll": float(path.gear_roll[0])}
    frames, rows = _frames(design, **pose), []
    tolerance = np.atleast_1d(np.asarray(tolerances, dtype=float))
    for size in tolerance.tolist():
        contact = mesh_contact(design, flank, size, **pose, polish=polish)
        side = mesh_separation(design, flank, 0, size, **pose, polish=polish)
        exact = feet(design.gear, flank, _seen_from(frames, 1, side.points))
        error = np.abs(side.separation - exact.distance)[exact.status == Status.SOLVED]
        faces = sum(len(flank_mesh(member, flank, size).faces) for member in design.members)
        rows.append((np.linalg.norm(contact.point - path.point[0]), np.nanmax(error), faces))
    point_error, separation_error, faces = np.array(rows).T
    return Convergence(tolerance, point_error, separation_error, faces.astype(np.int64))
