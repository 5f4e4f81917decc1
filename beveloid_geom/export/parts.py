"""What can be exported: the parts of a pair as surfaces, and a loaded tooth as hexahedra.

Members, flanks and teeth are in the member's own frame, the pair is in S_f, posed in the middle
of the path of contact.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..contact.ellipse import relative_curvature
from ..contact.placing import Frame, MeshingPair
from ..design.model import Design, Member
from ..export import FIELD_FORMATS, MEMBERS
from ..gear.flank import flank_point, tip_parameter, trace_parameter
from ..operation.marking.least_over_roll import least_separation, mating_of
from ..operation.marking.operating_rolls import first_contact_operation
from ..operation.separation import separation
from ..pair.frames import normals_to_fixed, to_fixed
from ..shapes.elements import VolumeMesh
from ..shapes.outline import require_tolerance
from ..shapes.sampling import FlankGrid, grid_faces, sample_flank
from ..shapes.solid import gear_solid, turned
from ..shapes.surface_mesh import gear_mesh
from .fea.abaqus import FIXED_SETS, LoadCase, nearest_node
from .fea.load import ContactPlace, contact_load
from .surfaces import SurfaceMesh, in_fixed, joined

TRIAL = 1e-3
"""Tolerance (mm) at which points are counted, for finer ones: their number goes with its inverse."""
BYTES_PER_POINT = 1100
"""Most memory that building and writing a surface took for each of its points."""
UNKNOWN_MEMORY = 2**33


def memory_limit() -> int:
    """Find how many bytes a surface may take: half of this machine's memory."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):  # not on every system
        return UNKNOWN_MEMORY // 2


def require_memory(points_at: Callable[[float], int], tolerance: float) -> None:
    """Raise ValueError for a tolerance that cannot be meant, and where a surface takes too much memory,
    with the estimate. `points_at` gives its number of points at a tolerance (mm)."""
    require_tolerance(tolerance)
    if tolerance >= TRIAL:
        return
    points = points_at(TRIAL) * TRIAL / tolerance
    size, limit = (count / 2.0**30 for count in (points * BYTES_PER_POINT, memory_limit()))
    if size > limit:
        need = f"about {points:.2g} points and {size:,.0f} GB of memory, the limit here is {limit:,.0f} GB"
        raise ValueError(f"tolerance {tolerance:g} mm is too fine: it takes {need}")


def gear_surface(
    member: Member,
    suffix: str,
    tolerance: float,
    teeth: int | None = None,
    bore_radius: float | None = None,
) -> SurfaceMesh:
    """Mesh a whole gear, or `teeth` neighbouring teeth, as triangles within `tolerance` (mm).

    For a format that holds fields: exact normals, the surfaces apart at their edges, and the cell
    field 'part' (0 ... as `surface_mesh.gear_mesh` names them). For the others: closed, each point there
    once. Raises ValueError as `gear_solid` does, and where memory would not suffice."""
    count = int(member.teeth) if teeth is None else teeth
    require_memory(lambda trial: count * len(gear_solid(member, trial, 1, bore_radius).points), tolerance)
    if suffix in FIELD_FORMATS:
        numbers = None if teeth is None else range(teeth)
        mesh = gear_mesh(member, tolerance, numbers, bore_radius)
        return SurfaceMesh(mesh.points, mesh.faces, {"normals": mesh.normals}, {"part": mesh.part})
    solid = gear_solid(member, tolerance, teeth, bore_radius)
    return SurfaceMesh(solid.points, solid.faces, {}, {"part": solid.part})


def pair_surface(design: Design, pose: MeshingPair, suffix: str, tolerance: float) -> SurfaceMesh:
    """Mesh both gears in S_f, with the cell fields 'member' (0 pinion, 1 gear), 'pinion' and 'gear' (1 on its
    faces, 0 on the other's)."""
    surfaces = []
    for number, (member, frame) in enumerate(zip(design.members, pose.frames, strict=True)):
        surface = gear_surface(member, suffix, tolerance)
        numbers = np.full(len(surface.faces), number)
        own = {name: (numbers == k).astype(int) for k, name in enumerate(MEMBERS)}
        surface = replace(surface, cell_fields={**surface.cell_fields, "member": numbers, **own})
        surfaces.append(in_fixed(surface, frame))
    return joined(surfaces)


def flank_surface(grid: FlankGrid, fields: dict[str, FloatArray]) -> SurfaceMesh:
    """Mesh the active flank of tooth 0 with its exact normals and `fields` on its points."""
    points, normals = grid.points.reshape(-1, 3), grid.normals.reshape(-1, 3)
    flat = {name: values.reshape(-1) for name, values in fields.items()}
    return SurfaceMesh(points, grid_faces(grid.points, grid.normals), {"normals": normals, **flat}, {})


def pattern_field(design: Design, pose: MeshingPair, member: int, grid: FlankGrid) -> FloatArray:
    """Find the least separation (nl, nz), mm, of the flank over the mesh of one tooth pair, as
    `contact_pattern` finds it: below its thickness marking compound is left. NaN without a mate."""
    mating = mating_of(design, pose.flank, member, first_contact_operation(design, pose.flank))
    return least_separation(mating, grid.points.reshape(-1, 3)).least.reshape(grid.l.shape)


def separation_field(design: Design, pose: MeshingPair, member: int, grid: FlankGrid) -> FloatArray:
    """Find the distance (nl, nz), mm, of the other member's flank along its normal, in the middle of the path
    of contact; NaN where it has no flank opposite."""
    found = separation(design, pose.flank, member, grid.l, grid.z, *pose.roll)
    return np.where(found.inside, found.distance, np.nan)


FIELDS: dict[str, Callable[[Design, MeshingPair, int, FlankGrid], FloatArray]] = {
    "separation": separation_field,
    "pattern": pattern_field,
}
"""Fields of a flank by name: of (design, pose, member, grid) an array (nl, nz)."""


def flank_part(
    design: Design, member: int, flank: str, tolerance: float, pose: MeshingPair | None, names: Sequence[str]
) -> SurfaceMesh:
    """Mesh a flank with the named `FIELDS`, which need the `pose`. Raises ValueError as `sample_flank`
    does, and where memory would not suffice."""
    require_memory(lambda trial: sample_flank(design.members[member], flank, trial).l.size, tolerance)
    grid = sample_flank(design.members[member], flank, tolerance)
    fields = {} if pose is None else {name: FIELDS[name](design, pose, member, grid) for name in names}
    return flank_surface(grid, fields)


def contact_case(
    mesh: VolumeMesh, design: Design, pose: MeshingPair, member: int, force: float, tooth: int = 0
) -> LoadCase:
    """Load a flank with the `force` (N) along its inward normal, as the pressure of the contact in the middle
    of the path as it is when this `tooth` has come there; the displacement is observed at the tip edge of
    the tooth's opposite flank, at mid-face.

    Raises ValueError where the mesh has no face there, and where the flanks cut each other beside it."""
    opposite, gear = {"right": "left", "left": "right"}[pose.flank], design.members[member]
    l = tip_parameter(gear, opposite, 0.0)
    edge = flank_point(gear, opposite, l, trace_parameter(gear, opposite, l, 0.0))
    turn = np.array([2.0 * np.pi / float(gear.teeth) * tooth])
    relative = relative_curvature(pose.path)
    axes = relative.direction[1] @ pose.frames[member][0]  # from S_f into the own frame
    vectors = np.stack((pose.point[member], pose.normal[member], edge, *axes))
    point, normal, edge, *axes = turned(vectors, turn)[0]
    place = ContactPlace(point, normal, relative.curvature[1], np.stack(axes))
    own = f"{pose.flank} flank {tooth + 1}"
    load = contact_load(mesh, own if own in mesh.surfaces else f"{pose.flank} flank", place, force)
    held = tuple(name for name in FIXED_SETS if name in mesh.node_sets)  # a whole gear has no sides
    return LoadCase(load, nearest_node(mesh, edge), held)


def placed_volume(
    mesh: VolumeMesh, case: LoadCase | None, frame: Frame
) -> tuple[VolumeMesh, LoadCase | None]:
    """Carry hexahedra and their load from the member's own frame to S_f."""
    placed = replace(mesh, points=to_fixed(frame, mesh.points))
    if case is None:
        return placed, None
    forces, point = normals_to_fixed(frame, case.load.forces), to_fixed(frame, case.load.point)
    return placed, replace(case, load=replace(case.load, forces=forces, point=point))
