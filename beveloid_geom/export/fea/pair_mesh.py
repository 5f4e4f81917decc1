"""Hexahedral mesh of the pair in contact: some teeth of both members, in the position of their first contact.

Both members are in S_f. The pinion has a given roll, and the gear is turned until the first of all teeth
touches. An odd number K of teeth is meshed of each member. The middle teeth are in contact with each other;
tooth k of the pinion meets tooth K + 1 - k of the gear. Flanks that touch at this roll are divided along the
profile according to the width of Hertz's contact ellipse. All other surfaces have a coarse mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import MEMBERS, FloatArray, Indices, Mask
from ...contact.ellipse import relative_curvature
from ...contact.hertz import contact_modulus, hertz_ellipse
from ...contact.mesh_position import Frame, MeshingPair, frames_at
from ...design.member import Member
from ...design.model import Design
from ...gear.fillet import tool_round
from ...gear.flank import flank_point
from ...gear.flank_limits import tip_parameter
from ...pair.frames import to_fixed
from ...shapes.element_sizes import Cells, cells_of, edge_deviation
from ...shapes.hexahedra import tooth_hexahedra
from ...shapes.hexahedral_mesh import VolumeMesh
from ...shapes.solid import rotated_copies
from ...support.argument import ArgumentError
from ..positions import rolls_at_first_contact
from .abaqus import FIXED_SETS
from .material import POISSON_RATIO, YOUNG_MPA

ELEMENT = "C3D20"
"""Type of all elements. Elements with 8 nodes have straight edges, which miss the flank by tens of
micrometres: the flanks would touch too late and the contact would be too soft."""


@dataclass(frozen=True, eq=False)
class PairMesh:
    """Some teeth of both members in S_f, in the position of their first contact.

    Attributes
    ----------
    flank : {'right', 'left'}
        Flanks in contact.
    roll : array (2,)
        Rolls of pinion and gear, rad.
    frames : tuple of 2 frames
        Positions of the members in S_f.
    mesh : VolumeMesh
        Both members. Sets have the name of the member before that of the tooth: 'pinion right flank 1'. The
        node sets 'pinion hub', 'pinion reference' (a node on the axis that belongs to no element) and 'pinion
        gauge' (a node of the hub) serve for supports and output, and likewise for the gear.
    contacts : tuple of pairs of str
        Surfaces of pinion and gear that may touch, in the order of the pinion's teeth.
    across, along : float
        Numbers of elements across and along the contact ellipse.
    stiffness : float
        Contact stiffness, N/mm^3.
    """

    flank: str
    roll: FloatArray
    frames: tuple[Frame, Frame]
    mesh: VolumeMesh
    contacts: tuple[tuple[str, str], ...]
    across: float
    along: float
    stiffness: float


def force_lever(design: Design) -> float:
    """Return the lever arm (mm) about the pinion's axis of the force between unmodified flanks.

    It is m_n N cos(alpha_n) / 2, and nearly the same for modified flanks."""
    tool = design.pinion.tool
    return float(0.5 * tool.normal_module * design.pinion.teeth * np.cos(tool.normal_pressure_angle))


def rolls_in_mesh(pose: MeshingPair) -> tuple[float, float]:
    """Return the smallest and the largest pinion roll (rad) at which the flanks of tooth pair 0 touch."""
    ends = pose.path.pinion_roll
    return float(ends.min()), float(ends.max())


def pair_mesh(
    design: Design,
    pose: MeshingPair,
    roll: float | None = None,
    *,
    teeth: int = 3,
    force: float,
    across: float = 4.0,
    cells: Cells | None = None,
    tolerance: float | None = None,
    bore_radii: tuple[float | None, float | None] = (None, None),
) -> PairMesh:
    """Return a mesh of some teeth of a pair in contact.

    Parameters
    ----------
    design : Design
        A single design.
    pose : MeshingPair
        Position of the pair with the flanks that drive.
    roll : float, optional
        Roll of the pinion, rad; by default, in the middle of the path of contact.
    teeth : int
        Number of teeth of each member, odd.
    force : float
        Force on one tooth pair, N. It sets the size of the elements on the flanks and the contact stiffness.
    across : float
        Elements across the contact ellipse under this force; at most 120 along the profile of a flank.
    cells : Cells, optional
        Numbers of elements except for flanks in contact. The default is a coarse mesh, with more elements
        along the face for a short ellipse.
    tolerance : float, optional
        Largest distance of straight edges from the surfaces, mm. If the default numbers exceed it, the
        numbers of `cells_of` are used.
    bore_radii : tuple of 2 float, optional
        Bore radius of each member, mm; see `tooth_hexahedra` for the default.

    Returns
    -------
    PairMesh

    Raises
    ------
    ArgumentError
        If the pair does not touch at this roll, or the number of teeth is even, larger than that of a gear or
        smaller than the number of teeth in contact.
    UnknownOperationError
        If the first contact is not known.
    ValueError
        As `tooth_hexahedra`.
    """
    # Smallest number of elements along the contact ellipse.
    elements_along = 3.0
    # Number of rows of elements that the ellipse, which is inclined to them, crosses within the length
    # of one element. If it crosses many, an element does not resolve the pressure.
    max_rows_crossed = 2.5
    # Tooth pairs at most this far beyond their path have fine flanks, because teeth bend into contact.
    near_contact_pitches = 0.05
    # Contact stiffness times half the width of the contact ellipse over the contact modulus E*. It
    # gives similar pairs of all sizes the same relative error; the largest pressure is reduced by up to
    # 8 %.
    stiffness_factor = 4.0
    roll = float(pose.roll[0]) if roll is None else roll
    _require_teeth(design, pose, roll, teeth)
    rolls = rolls_at_first_contact(design, pose.flank, roll)
    frames = frames_at(design, *rolls)
    length, width = _contact_size(design, pose, force)
    pairs = range(-(teeth // 2), teeth // 2 + 1)
    fine = _touching(design, pose, roll, pairs, near_contact_pitches).tolist()
    meshes, steps, along = [], [], []
    for number, fine_teeth in enumerate((fine, fine[::-1])):
        member, frame, bore = design.members[number], frames[number], bore_radii[number]
        slope = _inclination(member, pose, number)
        longest = min(length / elements_along, max_rows_crossed * width / across / max(slope, 1e-9))
        coarse = _coarse_cells(member, longest, tolerance) if cells is None else cells
        along.append(length * coarse.face / float(member.face_width))
        depth = _flank_depth(member, pose.flank)
        rows = max(coarse.flank, min(int(np.ceil(across * depth / width)), 120))
        each = [replace(coarse, flank=rows) if touches else coarse for touches in fine_teeth]
        meshes.append(_placed(member, each, bore, frame))
        steps.append(depth / rows)
    stiffness = stiffness_factor * contact_modulus(YOUNG_MPA, POISSON_RATIO) / (0.5 * width)
    mesh, contacts = _joined(meshes, frames), _contacts(pose.flank, teeth)
    return PairMesh(pose.flank, rolls, frames, mesh, contacts, width / max(steps), min(along), stiffness)


def _contacts(flank: str, teeth: int) -> tuple[tuple[str, str], ...]:
    """Return the names of the surfaces of pinion and gear that may touch, by tooth of the pinion."""
    names = [f"{flank} flank" + (f" {k}" if teeth > 1 else "") for k in range(1, teeth + 1)]
    pinion, gear = ([f"{member} {name}" for name in names] for member in MEMBERS)
    return tuple(zip(pinion, gear[::-1], strict=True))


def _require_teeth(design: Design, pose: MeshingPair, roll: float, teeth: int) -> None:
    """Raise ArgumentError for a roll without contact of the middle teeth or an invalid number of teeth."""
    low, high = rolls_in_mesh(pose)
    if not low <= roll <= high:
        limits = f"{np.degrees(low):.4f} and {np.degrees(high):.4f} deg"
        text = f"must be between {limits}, where tooth pair 0 is in mesh, got {np.degrees(roll):.4f}"
        raise ArgumentError("roll_deg", f"{text}: omit it for the middle of the path")
    largest = min(int(member.teeth) for member in design.members)
    if not (0 < teeth <= largest and teeth % 2):
        raise ArgumentError("teeth", f"must be an odd number from 1 to {largest} for the pair, got {teeth}")
    pairs = np.arange(-largest, largest + 1)
    touching = np.abs(pairs[_touching(design, pose, roll, pairs)])
    smallest = 2 * int(touching.max()) + 1
    if teeth < smallest:
        text = f"must be at least {smallest} to include all teeth that touch at this roll, got {teeth}"
        raise ArgumentError("teeth", text)


def _touching(
    design: Design, pose: MeshingPair, roll: float, pairs: Iterable[int], margin: float = 0.0
) -> Mask:
    """Return which tooth pairs have flanks in contact at a roll, or within a margin (pitches) of it."""
    low, high = rolls_in_mesh(pose)
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    rolls = roll + pitch * np.asarray(list(pairs))
    return np.asarray((rolls >= low - margin * pitch) & (rolls <= high + margin * pitch))


def _contact_size(design: Design, pose: MeshingPair, force: float) -> tuple[float, float]:
    """Return length and width (mm) of the contact ellipse in the middle of the path.

    If the ellipse is longer than the narrower face, it is replaced by Hertz's strip over this face (Johnson,
    Contact Mechanics, 4.2)."""
    smallest, largest = relative_curvature(pose.path).curvature[1]
    modulus = contact_modulus(YOUNG_MPA, POISSON_RATIO)
    if not largest > 0.0:
        raise ValueError(
            f"the flanks penetrate next to their contact (relative curvature {largest:.3g} 1/mm)"
            ": use smaller parabola coefficients"
        )
    face = min(float(member.face_width) for member in design.members)
    strip = face, 2.0 * float(np.sqrt(4.0 * force / (np.pi * modulus * face * largest)))
    curvature = np.array([max(smallest, 0.0), largest])
    length, width = 2.0 * hertz_ellipse(curvature, force, modulus).semi_axes
    return (float(length), float(width)) if length < face else strip


def _inclination(member: Member, pose: MeshingPair, number: int) -> float:
    """Return the tangent of the angle between the contact ellipse and the rows of elements on a flank.

    A row has a constant share of the profile between fillet and tip. Its direction at the contact is a
    difference along the face."""
    z = float(pose.point[number][2]) + 1e-3 * float(member.tool.normal_module) * np.array((-1.0, 0.0, 1.0))
    low, tip = tool_round(member.tool, pose.flank).joint, tip_parameter(member, pose.flank, z)
    l = low + ((pose.path.l1, pose.path.l2)[number][1] - low) / (tip[1] - low) * (tip - low)
    points = flank_point(member, pose.flank, l, z=z)
    row = (points[2] - points[0]) / np.linalg.norm(points[2] - points[0])
    ellipse = relative_curvature(pose.path).direction[1][0] @ pose.frames[number][0]
    return float(np.linalg.norm(np.cross(row, ellipse)) / abs(row @ ellipse))


def _coarse_cells(member: Member, element_length: float, tolerance: float | None) -> Cells:
    """Return the numbers of elements of a tooth, with elements of at most a length (mm) along the face.

    The default numbers are kept with a tolerance (mm) that they meet: a coarse tolerance must not give a
    finer mesh than none."""
    # Largest number of elements along the face.
    max_face_elements = 24
    face = int(np.ceil(float(member.face_width) / element_length))
    coarse = Cells(bottom=1, fillet=3, flank=4, tip=4, face=min(max(face, 6), max_face_elements))
    if tolerance is None or edge_deviation(member, coarse) <= tolerance:
        return coarse
    return cells_of(member, tolerance)


def _flank_depth(member: Member, flank: str) -> float:
    """Return the length (mm) of a flank from its fillet to its tip at mid-face."""
    l = np.array([tool_round(member.tool, flank).joint, float(tip_parameter(member, flank, 0.0))])
    ends = flank_point(member, flank, l, z=0.0)
    return float(np.linalg.norm(np.diff(ends.T)))


def _placed(member: Member, cells: Sequence[Cells], bore_radius: float | None, frame: Frame) -> VolumeMesh:
    """Return teeth of a member in S_f, turned so that the middle one is tooth 0."""
    mesh = tooth_hexahedra(member, len(cells), ELEMENT, bore_radius=bore_radius, cells=cells)
    turn = np.array([-2.0 * np.pi / float(member.teeth) * (len(cells) // 2)])
    return replace(mesh, points=to_fixed(frame, rotated_copies(mesh.points, turn)[0]))


def _joined(meshes: Sequence[VolumeMesh], frames: tuple[Frame, Frame]) -> VolumeMesh:
    """Return both members as one mesh, with the hub, the reference node and the gauge node of each."""
    points = [*(mesh.points for mesh in meshes), *(origin[None] for _, origin in frames)]
    start = np.cumsum([0, *(len(block) for block in points)])
    surfaces: dict[str, Indices] = {}
    nodes: dict[str, Indices] = {}
    elements: dict[str, Indices] = {}
    first = 0
    for number, (member, mesh) in enumerate(zip(MEMBERS, meshes, strict=True)):
        surfaces |= {
            f"{member} {name}": faces + np.array((first, 0)) for name, faces in mesh.surfaces.items()
        }
        elements |= {f"{member} {name}": cells + first for name, cells in mesh.element_sets.items()}
        elements[f"{member} body"] = np.arange(first, first + len(mesh.hexahedra))
        hub = np.unique(
            np.concatenate([mesh.node_sets[part] for part in FIXED_SETS if part in mesh.node_sets])
        )
        # The node farthest from the axis measures the rotation of the hub best.
        rotation, origin = frames[number]
        radii = np.linalg.norm(np.cross(mesh.points[hub] - origin, rotation[:, 2]), axis=1)
        sets = {**mesh.node_sets, "hub": hub, "gauge": hub[[radii.argmax()]]}
        nodes |= {f"{member} {name}": indices + start[number] for name, indices in sets.items()}
        nodes[f"{member} reference"] = start[[2 + number]]
        first += len(mesh.hexahedra)
    hexahedra = [mesh.hexahedra + offset for mesh, offset in zip(meshes, start, strict=False)]
    return VolumeMesh(np.concatenate(points), np.concatenate(hexahedra), surfaces, nodes, elements)
