"""Contact of two triangle meshes of flanks: the point of smallest separation at given rolls (a pose).

1. The vertex of two sampled meshes with the smallest separation (`mesh_separation`) has an error of the
   square root of the tolerance over the relative curvature. In approximate line contact this is millimetres
   for a tolerance of a micrometre, and it depends on the positions of the vertices. `mesh_convergence`
   computes this error.
2. This vertex is the start of Newton's method for the point where the exact separation D, as a function of
   the flank parameters of the pinion, is stationary. With the point R1 on the pinion, its outward unit
   normal n1, and the outward unit normal n2 at its foot on the gear,

       dD = n2.dR1 = 0,    d2D = dR1.A_2' dR1 + n2.d2R1,

   where A_2' maps a step to the change of n2 on the parallel surface of the gear through the point. Where D
   is stationary, n2 = -n1 holds and n2.d2R1 is dn1.dR1, so that the steps converge quadratically. Steps lead
   downhill only, so that they leave saddle points. The result is accepted only if the uncertainty of its
   position (`doubt`) is at most 1e-8 of the flank depth. If the smaller relative curvature vanishes, there
   is no result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...contact.mesh_position import Frame
from ...contact.surfaces.second_order import modified_normal_rates
from ...design.member import Member
from ...design.model import Design
from ...gear.closest_point import Feet, feet
from ...gear.flank import flank_patch, flank_point, normal_rates, trace_parameter
from ...gear.flank_limits import highest_parameter, root_parameter
from ...pair.frames import normals_to_fixed, to_fixed
from ...status import Status
from .mesh_separation import MeshSeparation, frames_of, in_frame_of, mesh_separation


@dataclass(frozen=True, eq=False)
class MeshContact:
    """The point of smallest separation at a pose.

    Attributes
    ----------
    point : array (3,)
        Middle between the flanks, in S_f, mm.
    separation : float
        mm.
    l, z : array (2,)
        Flank parameters and axial coordinates on pinion and gear, mm.
    doubt : float
        Uncertainty of the position, mm. Without `polish` it is the largest distance from `point` to the grid
        points whose separation equals the smallest one within the error of the meshes: millimetres, or the
        length of the flank. With `polish` it is the effect of rounding.
    status : Status
        As in `MeshSeparation`. NOT_CONVERGED also if the position of the minimum is uncertain. Values are
        NaN unless SOLVED.
    """

    point: FloatArray
    separation: float
    l: FloatArray
    z: FloatArray
    doubt: float
    status: Status


def mesh_contact(
    design: Design,
    flank: str,
    tolerance: float = 1e-3,
    *,
    pinion_roll: float,
    gear_roll: float,
    polish: bool = True,
) -> MeshContact:
    """Return the contact of two meshes at a pose: the point of smallest separation of the flanks.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    tolerance : float
        Tolerance to which both flanks are sampled, mm.
    pinion_roll, gear_roll : float
        rad.
    polish : bool
        Whether the contact is computed on the exact flanks, from the contact of the meshes. Otherwise it is
        a vertex of one mesh and its closest point on the other.

    Returns
    -------
    MeshContact
        With `polish`, the status is OFF_FLANK if the separation is smallest on an edge of a flank: the flanks
        are not tangent there.

    Raises
    ------
    ValueError
        As `mesh_separation`.
    """
    pose = {"pinion_roll": float(pinion_roll), "gear_roll": float(gear_roll)}
    rough = _facet_contact(design, flank, tolerance, pose)
    if not polish or rough.status != Status.SOLVED:
        return rough
    return _polished_contact(design, flank, frames_of(design, **pose), rough)


def _no_contact(status: Status) -> MeshContact:
    pair = np.full(2, np.nan)
    return MeshContact(np.full(3, np.nan), float("nan"), pair, pair, float("nan"), status)


def _facet_contact(design: Design, flank: str, tolerance: float, pose: dict[str, float]) -> MeshContact:
    """Return the vertex of smallest separation and its closest point on the other mesh."""
    # The contact may be next to grid points whose separation is larger than the smallest one by this
    # number of tolerances: one for each mesh, and one for the separation between the grid points of
    # each.
    near_tolerances = 4.0
    sides = [mesh_separation(design, flank, j, tolerance, **pose, polish=False) for j in (0, 1)]
    least = [np.nanmin(np.append(side.separation, np.inf)) for side in sides]
    member = int(np.argmin(least))
    if least[member] == np.inf:
        return _no_contact(Status.OFF_FLANK)
    side, other = sides[member], 1 - member
    at = np.unravel_index(np.nanargmin(side.separation), side.l.shape)
    l, z = (np.array((grid[at], foot[at])) for grid, foot in ((side.l, side.foot_l), (side.z, side.foot_z)))
    foot = to_fixed(frames_of(design, **pose)[other], flank_point(design.members[other], flank, l[1], z=z[1]))
    pinion_first, point = [member, other], 0.5 * (side.points[at] + foot)
    near = [_near_least(each, least[member] + near_tolerances * tolerance) for each in sides]
    doubt = float(np.linalg.norm(np.concatenate(near) - point, axis=-1).max())
    return MeshContact(point, float(least[member]), l[pinion_first], z[pinion_first], doubt, Status.SOLVED)


def _near_least(side: MeshSeparation, bound: float) -> FloatArray:
    """Return the grid points (n, 3) in S_f of the cells around points whose separation is within the
    bound."""
    near = np.pad(side.separation <= bound, 1)  # False for NaN
    rows, columns = near.shape
    neighbours = [near[i : rows - 2 + i, j : columns - 2 + j] for i in range(3) for j in range(3)]
    return np.asarray(side.points[np.any(neighbours, axis=0)])


def _polished_contact(
    design: Design, flank: str, frames: tuple[Frame, Frame], rough: MeshContact
) -> MeshContact:
    """Return the minimum of the exact separation, downhill from a contact of meshes. Steps are those of
    Newton's method where the separation is convex, and never increase it."""
    max_contact_steps = 60
    # Largest step of the contact search over the depth of the flank along l, and over the larger of
    # face width and depth along the face.
    max_step_ratio = 0.5
    # Step over the depth of the flank that ends the search. It usually leaves an error of its square.
    last_step_ratio = 1e-6
    # Rounding of the separation over the depth of the flank.
    separation_rounding = 1e-12
    # Largest uncertainty of the position of a polished contact over the depth of the flank.
    max_doubt_ratio = 1e-8
    pinion, reach = design.pinion, 1.0
    depth = float(highest_parameter(pinion, flank) - root_parameter(pinion, flank))
    longest = max_step_ratio * np.array((depth, max(depth, pinion.face_width)))
    place = np.array((rough.l[0], trace_parameter(pinion, flank, rough.l[0], rough.z[0])))
    here = _separation_at(design, flank, frames, place)
    for _ in range(max_contact_steps):
        step = here.step(longest, reach)
        there = _separation_at(design, flank, frames, place + step)
        if there.foot.distance <= here.foot.distance + separation_rounding * depth:
            place, here, reach = place + step, there, min(1.0, 2.0 * reach)
            if np.abs(step).max() <= last_step_ratio * depth:
                break
        else:  # larger, or NaN beyond the flank: try a shorter step
            reach *= 0.25
    pinion_foot = feet(pinion, flank, in_frame_of(frames, 0, here.point), tuple(place))
    doubt = float(here.doubt(longest))
    if pinion_foot.status == Status.OFF_FLANK or here.foot.status == Status.OFF_FLANK:
        return _no_contact(Status.OFF_FLANK)
    if not (doubt <= max_doubt_ratio * depth and pinion_foot.status == here.foot.status == Status.SOLVED):
        return _no_contact(Status.NOT_CONVERGED)
    middle = here.point - 0.5 * here.foot.distance * normals_to_fixed(frames[1], here.foot.normal)
    pair = (np.array((place[0], here.foot.l)), np.array((pinion_foot.z, here.foot.z)))
    return MeshContact(middle, float(here.foot.distance), *pair, doubt, Status.SOLVED)


@dataclass(frozen=True, eq=False)
class _Local:
    """The exact separation at a `point` (3,) of the pinion in S_f, mm: its `foot` on the gear, first
    derivatives `slope` (2,) and second derivatives `bend` (2, 2) by the flank parameters (l, u), and their
    `metric`."""

    point: FloatArray
    foot: Feet
    slope: FloatArray
    bend: FloatArray
    metric: FloatArray

    def step(self, longest: FloatArray, reach: float) -> FloatArray:
        """Return the step (2,) downhill: that of Newton's method along each principal direction of positive
        curvature, of the same length for negative curvature, and limited to `reach` times `longest` (2,),
        mm."""
        if not np.isfinite(self.bend).all():
            return np.full(2, np.nan)
        curvature, directions = np.linalg.eigh(self.bend * np.outer(longest, longest))
        share = -(directions.T @ (self.slope * longest)) / np.maximum(np.abs(curvature), 1e-300)
        return np.asarray(longest * (directions @ np.clip(share, -reach, reach)))

    def doubt(self, longest: FloatArray) -> float:
        """Return the possible distance (mm) of the minimum: the larger of the remaining Newton step and the
        rounding of the slope over the smallest curvature. Infinite where the separation is not convex."""
        if not np.isfinite(self.bend).all():
            return float("inf")
        root = np.linalg.inv(np.linalg.cholesky(self.metric))
        curvature = np.linalg.eigvalsh(root @ self.bend @ root.T)[0]
        remaining = np.abs(self.step(longest, 1.0)).max()
        # Rounding of the slope of the separation.
        slope_rounding = 16.0 * np.finfo(float).eps
        return float(max(remaining, slope_rounding / curvature)) if curvature > 0.0 else float("inf")


def _separation_at(design: Design, flank: str, frames: tuple[Frame, Frame], place: FloatArray) -> _Local:
    """Return the separation from the flank of the gear at (l, u) of the pinion."""
    l, u = place
    pinion_patch = flank_patch(design.pinion, flank, l, u)
    point = to_fixed(frames[0], pinion_patch.point)
    foot = feet(design.gear, flank, in_frame_of(frames, 1, point))
    met = flank_patch(design.gear, flank, foot.l, foot.u)
    steps, turns, other_steps, other_turns = (
        np.stack([normals_to_fixed(frame, vector) for vector in pair], axis=-1)
        for frame, pair in (
            (frames[0], (pinion_patch.tangent_l, pinion_patch.tangent_u)),
            (frames[0], _normal_rates(design.pinion, flank, l, u)),
            (frames[1], (met.tangent_l, met.tangent_u)),
            (frames[1], _normal_rates(design.gear, flank, foot.l, foot.u)),
        )
    )
    slope = steps.T @ normals_to_fixed(frames[1], foot.normal)
    parallel = other_steps + foot.distance * other_turns
    across = np.linalg.solve(parallel.T @ parallel, parallel.T @ steps)
    bend = steps.T @ (other_turns @ across + turns)
    return _Local(point, foot, slope, 0.5 * (bend + bend.T), steps.T @ steps)


def _normal_rates(member: Member, flank: str, l: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives (3,) of the unit normal by l and u. Near line contact, most of the relative
    curvature along the lines is that of the modification."""
    modified = member.modification(flank) is not None
    return (modified_normal_rates if modified else normal_rates)(member, flank, l, u)
