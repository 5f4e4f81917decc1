"""The pair in contact as hexahedra: some teeth of both members round the mesh, where they touch first.

Both members stand in S_f at a roll of the pinion, the gear turned until the first of all teeth touches. Of
each an odd number of teeth is meshed, the middle one in contact with the other's middle one: tooth k of the
pinion with tooth K + 1 - k of the gear. Flanks that touch at this roll are divided along the profile so that
ACROSS elements stand across Hertz's ellipse; the teeth beside them are coarse.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray, Indices, Mask
from ...contact.ellipse import relative_curvature
from ...contact.hertz import contact_modulus, hertz_ellipse
from ...contact.placing import Frame, MeshingPair, frames_at
from ...design.model import Design, Member
from ...export import MEMBERS
from ...gear.fillet import tool_round
from ...gear.flank import flank_point, tip_parameter, trace_parameter
from ...operation.first_contact import first_contact
from ...operation.marking.operating_rolls import UnknownOperationError, unknown_contact
from ...pair.frames import to_fixed
from ...shapes.elements import VolumeMesh
from ...shapes.hexahedra import Cells, cells_of, tooth_hexahedra
from ...shapes.solid import turned
from ...status import FirstStatus
from ...support.argument import ArgumentError
from .material import POISSON, YOUNG

ACROSS, MOST_ROWS = 4.0, 120
"""Elements across the ellipse of contact, and along the profile of a flank at most."""
COARSE = Cells(bottom=1, fillet=3, flank=4, tip=4, face=6)
ALONG, MOST_ALONG = 3.0, 16
"""Elements of teeth that do not touch; along the ellipse of contact, and along a face at most."""
BESIDE = 0.05
"""Pitches by which a tooth pair may stand beyond its path and have fine flanks: teeth bend into contact."""
HUB = ("bore", "first side", "last side")
"""Where a member is held by its shaft and by the rest of the gear."""
ELEMENT = "C3D20"
"""With 8-node elements the plane faces miss the flank by tens of micrometres, so that contact would begin too
late and be too soft."""


@dataclass(frozen=True, eq=False)
class PairMesh:
    """Some teeth of both members in S_f, where they touch first at a roll of the pinion.

    `roll` (2,), rad, pinion first; `frames` carry the members' own frames to S_f; `mesh`: of both, the sets
    named 'pinion right flank 1' ..., with the node sets 'pinion hub', 'pinion reference' (one node on the
    axis, of no element) and 'pinion gauge' (one of the hub), and likewise of the gear; `contacts`: surfaces
    of pinion and gear that may touch, by tooth of the pinion; `across`: elements across the ellipse of
    contact."""

    flank: str
    roll: FloatArray
    frames: tuple[Frame, Frame]
    mesh: VolumeMesh
    contacts: tuple[tuple[str, str], ...]
    across: float


def lever_of(design: Design) -> float:
    """Give the lever (mm) about the pinion's axis of the force between unmodified flanks, m_n N cos(alpha)
    / 2, which that of parabolic ones is near."""
    tool = design.pinion.tool
    return float(0.5 * tool.normal_module * design.pinion.teeth * np.cos(tool.normal_pressure_angle))


def rolls_in_mesh(pose: MeshingPair) -> tuple[float, float]:
    """Give the least and the greatest roll (rad) of the pinion at which the flanks of tooth pair 0 touch."""
    ends = pose.path.pinion_roll
    return float(ends.min()), float(ends.max())


def pair_mesh(
    design: Design,
    pose: MeshingPair,
    roll: float | None = None,
    *,
    teeth: int = 3,
    force: float,
    across: float = ACROSS,
    cells: Cells | None = None,
    tolerance: float | None = None,
    bore_radius: float | None = None,
) -> PairMesh:
    """Mesh some teeth of a pair in contact.

    Parameters
    ----------
    design : Design
        A single one.
    pose : MeshingPair
        Of its flanks that drive.
    roll : float, optional
        Of the pinion, rad; the middle of the path of contact unless given.
    teeth : int
        Of each member, odd.
    force : float
        N, of one tooth pair alone, for the size of the elements on the flanks.
    across : float
        Elements across the ellipse under this force, as far as MOST_ROWS allows.
    cells : Cells, optional
        Of the teeth beside; those that touch have other flanks. As coarse as COARSE unless given, finer along
        the face for a short ellipse.
    tolerance : float, optional
        mm, of `cells_of`, in place of `cells`.
    bore_radius : float, optional
        mm, of both members; 0.45 of their root radius unless given.

    Raises
    ------
    ValueError
        For a roll at which the pair does not touch, teeth that the gears have not, an even number of them or
        fewer than touch, a first contact that is not known, and as `tooth_hexahedra`.
    """
    roll = float(pose.roll[0]) if roll is None else roll
    _require_teeth(design, pose, roll, teeth)
    rolls = _rolls_in_contact(design, pose.flank, roll)
    frames = frames_at(design, *rolls)
    length, width = _contact_size(design, pose, force)
    fine = _touching(design, pose, roll, range(-(teeth // 2), teeth // 2 + 1), BESIDE).tolist()
    meshes, steps = [], []
    for member, frame, own in zip(design.members, frames, (fine, fine[::-1]), strict=True):
        beside = _coarse(member, length) if cells is None else cells
        coarse = beside if tolerance is None else cells_of(member, tolerance)
        depth = _depth(member, pose.flank)
        rows = max(coarse.flank, min(int(np.ceil(across * depth / width)), MOST_ROWS))
        each = [replace(coarse, flank=rows) if touches else coarse for touches in own]
        meshes.append(_placed(member, each, bore_radius, frame))
        steps.append(depth / rows)
    contacts = _contacts(pose.flank, teeth)
    return PairMesh(pose.flank, rolls, frames, _both(meshes, frames), contacts, width / max(steps))


def _rolls_in_contact(design: Design, flank: str, roll: float) -> FloatArray:
    """Give rolls (2,), rad, of pinion and gear at the first contact. Raises UnknownOperationError."""
    first = first_contact(design, flank, [roll])
    if first.status[0] != FirstStatus.SOLVED:
        raise UnknownOperationError(unknown_contact(flank, int(first.status[0])))
    return np.array([roll, float(first.gear_roll[0])])


def _contacts(flank: str, teeth: int) -> tuple[tuple[str, str], ...]:
    """Give the names of the surfaces of pinion and gear that may touch, by tooth of the pinion."""
    names = [f"{flank} flank" + (f" {k}" if teeth > 1 else "") for k in range(1, teeth + 1)]
    pinion, gear = ([f"{member} {name}" for name in names] for member in MEMBERS)
    return tuple(zip(pinion, gear[::-1], strict=True))


def _require_teeth(design: Design, pose: MeshingPair, roll: float, teeth: int) -> None:
    """Raise ArgumentError for a roll at which flanks of the middle teeth do not touch, and for `teeth` that
    are not all of those that do."""
    low, high = rolls_in_mesh(pose)
    if not low <= roll <= high:
        limits = f"{np.degrees(low):.4f} and {np.degrees(high):.4f} deg"
        text = f"must be between {limits}, where tooth pair 0 is in mesh, got {np.degrees(roll):.4f}"
        raise ArgumentError("roll_deg", f"{text}: leave it out for the middle")
    most = min(int(member.teeth) for member in design.members)
    if not (0 < teeth <= most and teeth % 2):
        raise ArgumentError("teeth", f"must be an odd number from 1 to {most} for the pair, got {teeth}")
    pairs = np.arange(-most, most + 1)
    touching = np.abs(pairs[_touching(design, pose, roll, pairs)])
    least = 2 * int(touching.max()) + 1
    if teeth < least:
        raise ArgumentError("teeth", f"must be at least {least} for all that touch at this roll, got {teeth}")


def _touching(
    design: Design, pose: MeshingPair, roll: float, pairs: Iterable[int], beside: float = 0.0
) -> Mask:
    """Tell which tooth pairs have flanks that touch at a roll, or so many pitches `beside` it."""
    low, high = rolls_in_mesh(pose)
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    own = roll + pitch * np.asarray(list(pairs))
    return np.asarray((own >= low - beside * pitch) & (own <= high + beside * pitch))


def _contact_size(design: Design, pose: MeshingPair, force: float) -> tuple[float, float]:
    """Give length and width (mm) of the ellipse of contact in the middle of the path; of one longer than the
    faces those of the strip on them (Johnson, Contact Mechanics, 4.2)."""
    least, greatest = relative_curvature(pose.path).curvature[1]
    modulus = contact_modulus(YOUNG, POISSON)
    if not greatest > 0.0:
        raise ValueError(
            f"the flanks do not part beside their contact (relative curvature {greatest:.3g} 1/mm)"
        )
    face = min(float(member.face_width) for member in design.members)
    strip = face, 2.0 * float(np.sqrt(4.0 * force / (np.pi * modulus * face * greatest)))
    length, width = 2.0 * hertz_ellipse(np.array([max(least, 0.0), greatest]), force, modulus).semi_axes
    return (float(length), float(width)) if length < face else strip


def _coarse(member: Member, length: float) -> Cells:
    """Divide teeth beside a contact of that length (mm)."""
    face = int(np.ceil(ALONG * float(member.face_width) / length))
    return replace(COARSE, face=min(max(face, COARSE.face), MOST_ALONG))


def _depth(member: Member, flank: str) -> float:
    """Give the length (mm) of a flank from its fillet to its tip at mid-face."""
    l = np.array([tool_round(member.tool, flank).joint, float(tip_parameter(member, flank, 0.0))])
    return float(
        np.linalg.norm(np.diff(flank_point(member, flank, l, trace_parameter(member, flank, l, 0.0)).T))
    )


def _placed(member: Member, cells: Sequence[Cells], bore_radius: float | None, frame: Frame) -> VolumeMesh:
    """Mesh teeth of a member and turn them so that the middle one is tooth 0, in S_f."""
    mesh = tooth_hexahedra(member, len(cells), ELEMENT, bore_radius=bore_radius, cells=cells)
    back = np.array([-2.0 * np.pi / float(member.teeth) * (len(cells) // 2)])
    return replace(mesh, points=to_fixed(frame, turned(mesh.points, back)[0]))


def _both(meshes: Sequence[VolumeMesh], frames: tuple[Frame, Frame]) -> VolumeMesh:
    """Put both members into one mesh, with the hub, a reference node and a gauge of each."""
    points = [*(mesh.points for mesh in meshes), *(origin[None] for _, origin in frames)]
    start = np.cumsum([0, *(len(own) for own in points)])
    surfaces: dict[str, Indices] = {}
    nodes: dict[str, Indices] = {}
    elements: dict[str, Indices] = {}
    first = 0
    for number, (name, mesh) in enumerate(zip(MEMBERS, meshes, strict=True)):
        surfaces |= {f"{name} {own}": faces + np.array((first, 0)) for own, faces in mesh.surfaces.items()}
        elements |= {f"{name} {own}": cells + first for own, cells in mesh.element_sets.items()}
        elements[f"{name} body"] = np.arange(first, first + len(mesh.hexahedra))
        hub = np.unique(np.concatenate([mesh.node_sets[part] for part in HUB if part in mesh.node_sets]))
        rotation, origin = frames[number]
        radii = np.linalg.norm(np.cross(mesh.points[hub] - origin, rotation[:, 2]), axis=1)
        own_sets = {**mesh.node_sets, "hub": hub, "gauge": hub[[radii.argmax()]]}
        nodes |= {f"{name} {own}": indices + start[number] for own, indices in own_sets.items()}
        nodes[f"{name} reference"] = start[[2 + number]]
        first += len(mesh.hexahedra)
    hexahedra = [mesh.hexahedra + offset for mesh, offset in zip(meshes, start, strict=False)]
    return VolumeMesh(np.concatenate(points), np.concatenate(hexahedra), surfaces, nodes, elements)
