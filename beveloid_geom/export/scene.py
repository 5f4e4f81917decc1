"""The pair in mesh as a scene to look at, .glb: both gears, and on the flanks that drive paths and patterns.

glTF 2.0 has metres and y up: S_f's z, the pinion's axis, points up there. What lies on a flank is raised a
little from it, to be seen. Nodes are named for what they show, and hang below their gear: a viewer that hides
one gear shows the other's flank.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..arrays import FloatArray, Mask
from ..contact.path import ContactPath, path_of_contact
from ..contact.placing import MeshingPair
from ..design.model import Design
from ..export import MEMBERS
from ..gear.flank import flank_patch, trace_parameter
from ..operation.certificate import certify
from ..operation.marking.pattern import MemberPattern, contact_pattern
from ..shapes.sampling import grid_faces
from ..status import Status, Verdict
from .parts import gear_surface
from .surfaces import SurfaceMesh, in_fixed

METRES_Y_UP = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""From mm of S_f to a scene's axes."""
GEARS, FIRST, LATER, MARKED = ("#b9c4cf", "#d3c3a6"), "#d55e00", "#1a1a1a", "#0072b2"
"""Colours of pinion and gear, of a path where it is the first contact and where not, of a pattern."""
RADIUS, THIN, RAISED = 1.0 / 30.0, 0.4, 1.0 / 300.0
"""Modules: of a path's tube; thinner by this share where it is no contact; of a pattern over its flank."""
PATH_POINTS, SECTIONS = 33, 12


@dataclass(frozen=True, eq=False)
class Piece:
    """One node of a scene: its `name`, its `colour` as #rrggbb, its surface in S_f, mm, and the name of the
    gear `of` which it is a part, with which viewers hide it."""

    name: str
    colour: str
    surface: SurfaceMesh
    of: str | None = None


def pair_pieces(design: Design, pose: MeshingPair, tolerance: float) -> list[Piece]:
    """Make both gears within `tolerance` (mm), and the path and the pattern of the flanks of a `pose` on
    pinion and gear. Raises ValueError as `gear_surface` and `contact_pattern` do."""
    pattern = contact_pattern(design, pose.flank)
    path = path_of_contact(design, pose.flank, PATH_POINTS)
    first = certify(path).verdict == Verdict.FIRST_CONTACT
    pieces = []
    for number, name in enumerate(MEMBERS):
        gear = gear_surface(design.members[number], ".vtu", tolerance)
        own = [Piece(name, GEARS[number], gear), *_path(path, first, number)]
        marked = _marked(
            design, pose.flank, number, (pattern.pinion, pattern.gear)[number], pattern.separation
        )
        own += [] if marked is None else [marked]
        pieces += [replace(one, surface=in_fixed(one.surface, pose.frames[number])) for one in own]
    return pieces


def write_glb(pieces: Sequence[Piece], path: Path) -> None:
    """Write the scene as binary glTF 2.0."""
    import trimesh
    from trimesh import visual

    scene, look = cast(Any, trimesh.Scene()), cast(Any, visual)  # trimesh has no types for them
    for piece in pieces:
        surface = piece.surface
        normals = surface.point_fields.get("normals")
        mesh = trimesh.Trimesh(
            surface.points @ METRES_Y_UP.T,
            surface.faces,
            vertex_normals=None if normals is None else normals @ (1e3 * METRES_Y_UP.T),
            process=False,
        )
        material = look.material.PBRMaterial(
            name=piece.name, baseColorFactor=_linear(piece.colour), metallicFactor=0.1, roughnessFactor=0.6
        )
        mesh.visual = look.TextureVisuals(material=material)
        scene.add_geometry(mesh, node_name=piece.name, geom_name=piece.name, parent_node_name=piece.of)
    scene.export(str(path), file_type="glb", include_normals=True)


def _linear(colour: str) -> list[float]:
    """Give red, green, blue, 1 as glTF counts them, in shares of light, of a colour as screens do (IEC
    61966-2-1)."""
    screen = np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    light = np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
    return [*light.tolist(), 1.0]


def _path(path: ContactPath, first: Mask, number: int) -> Iterator[Piece]:
    """Make tubes along the path on a member's flank, in its own frame: where it is the `first` contact of all
    teeth, and, thinner, where something else touches earlier."""
    solved, design = path.status == Status.SOLVED, path.design
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[number]
    points = flank_patch(design.members[number], path.flank, l, u).point
    radius = RADIUS * float(design.pinion.tool.normal_module)
    ends = solved[:-1] & solved[1:]
    both = first[:-1] & first[1:]
    name = f"path of contact on {MEMBERS[number]}"
    for wanted, own, colour, size in (
        (ends & both, name, FIRST, radius),
        (ends & ~both, f"{name}, not the first contact", LATER, THIN * radius),
    ):
        if wanted.any():
            yield Piece(own, colour, _tube(points, wanted, size), MEMBERS[number])


def _tube(points: FloatArray, wanted: Mask, radius: float) -> SurfaceMesh:
    """Make a tube round those steps (n - 1,) of a line (n, 3) that are `wanted`."""
    import trimesh

    steps = [
        trimesh.creation.cylinder(radius, sections=SECTIONS, segment=points[k : k + 2])
        for k in np.flatnonzero(wanted)
    ]
    tube = cast(Any, trimesh.util.concatenate(steps))
    return SurfaceMesh(np.asarray(tube.vertices), np.asarray(tube.faces), {}, {})


def _marked(
    design: Design, flank: str, number: int, pattern: MemberPattern, separation: float
) -> Piece | None:
    """Make the marked part of a member's flank, in its own frame: its grid over l and z, cut where the root
    of the least separation passes that of the compound, and laid onto the flank again. None where nothing
    is marked."""
    from trimesh import intersections

    member = design.members[number]
    least = np.nan_to_num(pattern.least, nan=np.inf)
    under = np.sqrt(separation) - np.sqrt(np.clip(least, 0.0, 9.0 * separation))
    chart = np.stack((pattern.l, pattern.z, under), axis=-1)
    patch = flank_patch(member, flank, pattern.l, trace_parameter(member, flank, pattern.l, pattern.z))
    faces = grid_faces(pattern.points, patch.normal)
    cut, faces, *_ = cast(Any, intersections).slice_faces_plane(
        chart.reshape(-1, 3), faces, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]
    )
    if not len(faces):
        return None
    l, z, _ = cut.T
    patch = flank_patch(member, flank, l, trace_parameter(member, flank, l, z))
    points = patch.point + RAISED * float(member.tool.normal_module) * patch.normal
    surface = SurfaceMesh(points, np.asarray(faces), {"normals": patch.normal}, {})
    return Piece(f"pattern on {MEMBERS[number]}", MARKED, surface, MEMBERS[number])
