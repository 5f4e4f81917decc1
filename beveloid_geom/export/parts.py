"""Parts of a pair as geometry to be written: surfaces of gears, teeth and flanks, and loaded teeth.

Gears, teeth and flanks are in the frame of their gear, the pair is in the fixed frame S_f.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import MEMBERS, FloatArray
from ..contact.ellipse import relative_curvature
from ..contact.mesh_position import Frame, MeshingPair
from ..contact.parallel.lines import contact_lines, is_line_contact
from ..design.member import Member
from ..design.model import Design
from ..export import FIELD_FORMATS
from ..gear.flank import flank_point
from ..gear.flank_limits import tip_parameter
from ..operation.angular_clearance import angular_clearance
from ..operation.contact_pattern.mating import mating_of
from ..operation.contact_pattern.minimum_separation import minimum_separation
from ..operation.contact_pattern.motion import first_contact_operation
from ..pair.frames import normals_to_fixed, to_fixed
from ..shapes.hexahedral_mesh import VolumeMesh
from ..shapes.sampling import FlankGrid, sample_flank
from ..shapes.sheet import grid_faces
from ..shapes.solid import NAMES, gear_solid, rotated_copies
from ..shapes.surface_mesh import gear_mesh
from ..shapes.tooth_boundary import require_tolerance
from .fea.abaqus import FIXED_SETS, LoadCase, nearest_node
from .fea.load import ContactPlace, contact_load
from .surfaces import SurfaceMesh, in_fixed, joined_surfaces

COUNTING_TOLERANCE_MM = 1e-3
"""Tolerance at which the points of a surface are counted. For a finer tolerance, their number is extrapolated
in proportion to 1 / tolerance."""


def memory_limit() -> int:
    """Return the number of bytes that a surface may take: half of the memory of this machine."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):  # not available on every system
        return 2**32


def require_surface_memory(points_at: Callable[[float], int], tolerance: float) -> None:
    """Raise ValueError if a surface takes too much memory at a tolerance (mm), or for an invalid tolerance.

    `points_at` returns the number of points at a tolerance."""
    # Largest measured memory for building and writing a surface, per point.
    bytes_per_point = 1100
    require_tolerance(tolerance)
    if tolerance >= COUNTING_TOLERANCE_MM:
        return
    points = points_at(COUNTING_TOLERANCE_MM) * COUNTING_TOLERANCE_MM / tolerance
    size, limit = (count / 2.0**30 for count in (points * bytes_per_point, memory_limit()))
    if size > limit:
        need = f"about {points:.2g} points and {size:,.0f} GB of memory, the limit here is {limit:,.0f} GB"
        raise ValueError(f"tolerance {tolerance:g} mm needs {need}: increase the tolerance")


def gear_surface(
    member: Member,
    suffix: str,
    tolerance: float,
    teeth: int | None = None,
    bore_radius: float | None = None,
) -> SurfaceMesh:
    """Return a complete gear, or neighbouring teeth of it, as triangles.

    Parameters
    ----------
    member : Member
        A single member.
    suffix : str
        Format to be written. For a format with fields the surface has normals, and its parts do not
        share points. For the other formats it is closed, with each point once.
    tolerance : float
        Largest distance of the triangles from the exact surfaces, mm.
    teeth : int, optional
        Number of teeth; all teeth by default.
    bore_radius : float, optional
        mm; see `gear_solid` for the default.

    Returns
    -------
    SurfaceMesh
        With the cell field 'part'.

    Raises
    ------
    ValueError
        As `gear_solid`, and if the memory is not sufficient.
    """
    count = int(member.teeth) if teeth is None else teeth
    require_surface_memory(
        lambda trial: count * len(gear_solid(member, trial, 1, bore_radius).points), tolerance
    )
    if suffix in FIELD_FORMATS:
        numbers = None if teeth is None else range(teeth)
        mesh = gear_mesh(member, tolerance, numbers, bore_radius)
        return SurfaceMesh(mesh.points, mesh.faces, {"normals": mesh.normals}, {"part": mesh.part}, NAMES)
    solid = gear_solid(member, tolerance, teeth, bore_radius)
    return SurfaceMesh(solid.points, solid.faces, {}, {"part": solid.part}, NAMES)


def pair_surface(
    design: Design,
    frames: Sequence[Frame],
    suffix: str,
    tolerance: float,
    bore_radii: Sequence[float | None] = (None, None),
) -> SurfaceMesh:
    """Return both gears in S_f as triangles.

    Parameters
    ----------
    design : Design
        A single design.
    frames : sequence of 2 frames
        Positions of pinion and gear in S_f.
    suffix, tolerance, bore_radii
        As for `gear_surface`; one bore radius (mm) or None for each member.

    Returns
    -------
    SurfaceMesh
        With the cell fields 'part', 'member' (0 pinion, 1 gear), 'pinion' and 'gear' (1 on the triangles of
        this member, otherwise 0).
    """
    surfaces = []
    for number, (member, frame, bore) in enumerate(zip(design.members, frames, bore_radii, strict=True)):
        surface = gear_surface(member, suffix, tolerance, bore_radius=bore)
        numbers = np.full(len(surface.faces), number)
        flags = {name: (numbers == k).astype(int) for k, name in enumerate(MEMBERS)}
        surface = replace(surface, cell_fields={**surface.cell_fields, "member": numbers, **flags})
        surfaces.append(in_fixed(surface, frame))
    return joined_surfaces(surfaces)


def flank_triangles(grid: FlankGrid, fields: Mapping[str, FloatArray] | None = None) -> SurfaceMesh:
    """Return a sampled flank as triangles with its exact normals and `fields` (nl, nz) on its points."""
    points, normals = grid.points.reshape(-1, 3), grid.normals.reshape(-1, 3)
    flat = {name: values.reshape(-1) for name, values in (fields or {}).items()}
    return SurfaceMesh(points, grid_faces(grid.points, grid.normals), {"normals": normals, **flat}, {})


def pattern_field(design: Design, pose: MeshingPair, member: int, grid: FlankGrid) -> FloatArray:
    """Return the smallest separation (nl, nz), mm, of a flank while one tooth pair rolls through the mesh.

    `contact_pattern` defines this separation. Marking compound that is thicker is removed there. NaN where
    the mating flank is never opposite."""
    mating = mating_of(design, pose.flank, member, first_contact_operation(design, pose.flank))
    return minimum_separation(mating, grid.points.reshape(-1, 3)).least.reshape(grid.l.shape)


def separation_field(design: Design, pose: MeshingPair, member: int, grid: FlankGrid) -> FloatArray:
    """Return the distance (nl, nz), mm, of the mating flank along the normal, in the middle of the path.

    NaN where no mating flank is opposite."""
    gaps = angular_clearance(design, pose.flank, member, grid.l, grid.z, *pose.roll)
    return np.where(gaps.inside, gaps.distance, np.nan)


def flank_part(
    design: Design, member: int, flank: str, tolerance: float, pose: MeshingPair | None, names: Sequence[str]
) -> SurfaceMesh:
    """Return the active flank of tooth 0 of member 0 or 1 as triangles, with the named fields.

    Fields need the `pose`. Raises ValueError as `sample_flank`, and if the memory is not sufficient."""
    require_surface_memory(lambda trial: sample_flank(design.members[member], flank, trial).l.size, tolerance)
    grid = sample_flank(design.members[member], flank, tolerance)
    # Functions of design, pose, member number and grid.
    field_functions: dict[str, Callable[[Design, MeshingPair, int, FlankGrid], FloatArray]] = {
        "separation": separation_field,
        "pattern": pattern_field,
    }
    fields = (
        {} if pose is None else {name: field_functions[name](design, pose, member, grid) for name in names}
    )
    return flank_triangles(grid, fields)


def contact_case(
    mesh: VolumeMesh, design: Design, pose: MeshingPair, member: int, force: float, tooth: int = 0
) -> LoadCase:
    """Return the load case of a flank in contact, in the middle of its path of contact.

    Parameters
    ----------
    mesh : VolumeMesh
        Teeth of the member, in the frame of the gear.
    design : Design
        A single design.
    pose : MeshingPair
        Position of the pair, which names the flank.
    member : int
        0 for the pinion, 1 for the gear.
    force : float
        Force along the inward normal of the flank, N. It acts as Hertz's pressure on the contact ellipse. If
        the flanks touch along a line, the pressure is constant along the line of contact at this roll.
    tooth : int
        Loaded tooth, from 0.

    Returns
    -------
    LoadCase
        The observed node is at mid-face on the tip edge of the opposite flank of the loaded tooth.

    Raises
    ------
    ValueError
        If the mesh has no face at the contact, or the flanks intersect next to it.
    """
    opposite, gear = {"right": "left", "left": "right"}[pose.flank], design.members[member]
    l = tip_parameter(gear, opposite, 0.0)
    edge = flank_point(gear, opposite, l, z=0.0)
    turn = np.array([2.0 * np.pi / float(gear.teeth) * tooth])
    (rotation, origin), path = pose.frames[member], pose.path
    relative, contact, length = relative_curvature(path), pose.point[member], None
    if is_line_contact(design, pose.flank):
        lines = contact_lines(path)
        if np.isfinite(lines.length[1]):  # not on a relief
            contact, length = (lines.point[1].mean(axis=0) - origin) @ rotation, float(lines.length[1])
    axes = relative.direction[1] @ rotation  # from S_f to the frame of the gear
    vectors = np.stack((contact, pose.normal[member], edge, *axes))
    point, normal, edge, *axes = rotated_copies(vectors, turn)[0]
    place = ContactPlace(point, normal, relative.curvature[1], np.stack(axes), length)
    surface = f"{pose.flank} flank {tooth + 1}"  # the surfaces of a single tooth have no number
    load = contact_load(mesh, surface if surface in mesh.surfaces else f"{pose.flank} flank", place, force)
    fixed = tuple(name for name in FIXED_SETS if name in mesh.node_sets)  # a complete gear has no cut sides
    return LoadCase(load, nearest_node(mesh, edge), fixed)


def placed_volume(
    mesh: VolumeMesh, case: LoadCase | None, frame: Frame
) -> tuple[VolumeMesh, LoadCase | None]:
    """Return hexahedra and their load, given in the frame of the gear, in S_f."""
    placed = replace(mesh, points=to_fixed(frame, mesh.points))
    if case is None:
        return placed, None
    forces, point = normals_to_fixed(frame, case.load.forces), to_fixed(frame, case.load.point)
    return placed, replace(case, load=replace(case.load, forces=forces, point=point))
