"""Scene of the pair in mesh for viewers (.glb): both gears, paths of contact and patterns.

A glTF 2.0 scene is in metres with y up. The z axis of S_f, the axis of the pinion, becomes y. So that
they are visible, a path is a tube around its points, and a pattern is raised a little from the flank. Their
nodes are children of the node of their gear: a viewer that hides one gear shows the flank of the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..arrays import MEMBERS, FloatArray, Mask
from ..contact.mesh_position import Frame, MeshingPair
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..gear.flank import flank_patch
from ..operation.certificate import path_certificate
from ..operation.contact_pattern.pattern import MemberPattern, contact_pattern
from ..shapes.sheet import grid_faces
from ..status import Status, Verdict
from .parts import gear_surface
from .surfaces import SurfaceMesh, in_fixed

METRES_Y_UP = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""From mm in S_f to the axes of a scene."""


@dataclass(frozen=True, eq=False)
class SceneItem:
    """Node of a scene: `name`, `colour` as #rrggbb, `surface` in S_f (mm), and name of the `parent` node."""

    name: str
    colour: str
    surface: SurfaceMesh
    parent: str | None = None


def pair_scene(
    design: Design,
    position: MeshingPair,
    frames: Sequence[Frame],
    tolerance: float,
    bore_radii: Sequence[float | None] = (None, None),
) -> list[SceneItem]:
    """Return both gears with the path of contact and the pattern on their flanks.

    Parameters
    ----------
    design : Design
        A single design.
    position : MeshingPair
        Position of the pair, which names the flanks that drive.
    frames : sequence of 2 frames
        Positions of pinion and gear in S_f.
    tolerance : float
        Largest distance of the triangles from the exact surfaces, mm.
    bore_radii : sequence of 2 float, optional
        Bore radii of pinion and gear, mm.

    Returns
    -------
    list of SceneItem

    Raises
    ------
    ValueError
        As `gear_surface` and `contact_pattern`.
    """
    gear_colours = ("#b9c4cf", "#d3c3a6")
    flank = position.flank
    pattern = contact_pattern(design, flank)
    path = path_of_contact(design, flank, 33)
    first = path_certificate(path).verdict == Verdict.FIRST_CONTACT
    scene = []
    for number, name in enumerate(MEMBERS):
        gear = gear_surface(design.members[number], ".vtu", tolerance, bore_radius=bore_radii[number])
        items = [SceneItem(name, gear_colours[number], gear), *_path_items(path, first, number)]
        member_pattern = (pattern.pinion, pattern.gear)[number]
        items += _pattern_items(design, flank, number, member_pattern, pattern.separation)
        scene += [replace(one, surface=in_fixed(one.surface, frames[number])) for one in items]
    return scene


def write_glb(items: Sequence[SceneItem], path: Path) -> None:
    """Write a scene as binary glTF 2.0."""
    import trimesh
    from trimesh import visual

    scene, look = cast(Any, trimesh.Scene()), cast(Any, visual)  # trimesh has no types for them
    for item in items:
        surface = item.surface
        normals = surface.point_fields.get("normals")
        mesh = trimesh.Trimesh(
            surface.points @ METRES_Y_UP.T,
            surface.faces,
            vertex_normals=None if normals is None else normals @ (1e3 * METRES_Y_UP.T),
            process=False,
        )
        material = look.material.PBRMaterial(
            name=item.name, baseColorFactor=_linear(item.colour), metallicFactor=0.1, roughnessFactor=0.6
        )
        mesh.visual = look.TextureVisuals(material=material)
        scene.add_geometry(mesh, node_name=item.name, geom_name=item.name, parent_node_name=item.parent)
    path.write_bytes(scene.export(file_type="glb", include_normals=True))


def _linear(colour: str) -> list[float]:
    """Return red, green, blue and alpha of a colour #rrggbb in linear light, as in glTF (IEC 61966-2-1)."""
    screen = np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    light = np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
    return [*light.tolist(), 1.0]


def _path_items(path: ContactPath, first: Mask, number: int) -> Iterator[SceneItem]:
    """Yield tubes along the path on a member's flank, in the frame of the gear.

    The tube is thick where the path is the `first` contact of all teeth, and thin where another contact is
    earlier."""
    # Radius of the tube along a path of contact.
    path_radius_modules = 1.0 / 30.0
    solved, design = path.status == Status.SOLVED, path.design
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[number]
    points = flank_patch(design.members[number], path.flank, l, u).point
    radius = path_radius_modules * float(design.pinion.tool.normal_module)
    steps = solved[:-1] & solved[1:]
    both_first = first[:-1] & first[1:]
    name = f"path of contact on {MEMBERS[number]}"
    for chosen, label, colour, size in (
        (steps & both_first, name, "#d55e00", radius),
        (steps & ~both_first, f"{name}, not the first contact", "#1a1a1a", 0.4 * radius),
    ):
        if chosen.any():
            yield SceneItem(label, colour, _tube(points, chosen, size), MEMBERS[number])


def _tube(points: FloatArray, chosen: Mask, radius: float) -> SurfaceMesh:
    """Return a tube around the chosen steps (n - 1,) of a line (n, 3)."""
    import trimesh

    steps = [
        trimesh.creation.cylinder(radius, sections=12, segment=points[k : k + 2])
        for k in np.flatnonzero(chosen)
    ]
    tube = cast(Any, trimesh.util.concatenate(steps))
    return SurfaceMesh(np.asarray(tube.vertices), np.asarray(tube.faces), {}, {})


def _pattern_items(
    design: Design, flank: str, number: int, pattern: MemberPattern, separation: float
) -> Iterator[SceneItem]:
    """Yield the pattern on a member's flank, in the frame of the gear, if there is one.

    The grid of the pattern over l and z is cut where the square root of the smallest separation equals that
    of the thickness of the marking compound. The cut grid is then mapped to the flank again."""
    from trimesh import intersections

    member = design.members[number]
    least = np.nan_to_num(pattern.least, nan=np.inf)
    margin = np.sqrt(separation) - np.sqrt(np.clip(least, 0.0, 9.0 * separation))
    chart = np.stack((pattern.l, pattern.z, margin), axis=-1)
    patch = flank_patch(member, flank, pattern.l, z=pattern.z)
    faces = grid_faces(pattern.points, patch.normal)
    cut, faces, *_ = cast(Any, intersections).slice_faces_plane(
        chart.reshape(-1, 3), faces, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]
    )
    if not len(faces):
        return
    l, z, _ = cut.T
    patch = flank_patch(member, flank, l, z=z)
    height = float(member.tool.normal_module) / 300.0  # of the pattern over the flank
    points = patch.point + height * patch.normal
    surface = SurfaceMesh(points, np.asarray(faces), {"normals": patch.normal}, {})
    yield SceneItem(f"pattern on {MEMBERS[number]}", "#0072b2", surface, MEMBERS[number])
