"""The large picture of a film: the teeth in mesh, seen along them, the gear as if of glass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import Mesh, gear_mesh

from ..parts import posed
from ..parts.solved import MEMBERS
from ..stage import theme
from ..stage.scene import MESH_PX, Camera, Picture, Scene, Size, Surface, fit_camera, render_moving
from .motion import Film, Motion, NoFilmError

LEAST = 3.0
"""Least half height of the picture, in normal modules."""
MARGIN = 0.06
"""Share of the picture kept free around all contacts of the film."""
ASIDE, ABOVE = 0.3, 0.15
"""How far the eye stands off the line along the tooth: towards the pinion's flank, and towards the gear."""
GEARWARDS = np.array([1.0, 0.0, 0.0])
"""From the pinion's axis to the gear's."""
GLASS = 0.3
WHOLE = 1e-5
"""mm within which points of neighbouring parts of a tooth are one."""


def looks_from(film: Film) -> FloatArray:
    """Give the unit vector (3,) in S_f along the teeth to the end, heel or toe, from which the pinion's
    flanks in contact face left, where the light comes from."""
    along = np.cross(GEARWARDS, _normal(film))
    return np.asarray(along / np.linalg.norm(along))


def _normal(film: Film) -> FloatArray:
    """Give the normal (3,) out of the pinion's tooth, in S_f, over the path of contact."""
    return np.asarray(np.nanmean(film.path.path.normal, axis=0))


def camera_of(film: Film, size: Size) -> Camera:
    """Make the camera that shows all contacts of the film, with the gear on top."""
    motion = film.motion
    towards = looks_from(film) + ASIDE * _normal(film) + ABOVE * GEARWARDS
    camera = fit_camera(motion.point[motion.near], -towards, GEARWARDS, size, MARGIN)
    least = LEAST * float(motion.design.pinion.tool.normal_module)
    return replace(camera, half_height=max(camera.half_height, least))


def pictures(film: Film, size: Size) -> Iterator[Picture]:
    """Draw the teeth at every position of the film. Raises NoFilmError for teeth that cannot be made."""
    motion, camera = film.motion, camera_of(film, size)
    tolerance = MESH_PX * camera.mm_per_px(size)
    items, far = [], "toe" if looks_from(film)[2] > 0.0 else "heel"
    for number, member in enumerate(motion.design.members):
        try:
            mesh = gear_mesh(member, tolerance, teeth_near(motion, number, camera))
        except ValueError as error:
            raise NoFilmError(f"{MEMBERS[number]}: {error}") from None
        colour, opacity = theme.METALS[number], (1.0, GLASS)[number]
        skin = mesh.where(~mesh.is_of("bore", far, "first side", "last side"))
        items.append(Surface(skin.points, skin.faces, skin.normals, colour, opacity))
        items.append(outline(mesh))
    first, second = (list(zip(*frame, strict=True)) for frame in motion.frames)
    poses = ((one, one, other, other) for one, other in zip(first, second, strict=True))  # skin and outline
    return render_moving(Scene(items, camera), size, poses)


def teeth_near(motion: Motion, number: int, camera: Camera) -> range | None:
    """Give numbers of a member's teeth of which the last never come into the picture; None for all."""
    member, (rotation, origin) = motion.design.members[number], motion.frames[number]
    teeth, middle = int(member.teeth), len(motion.share) // 2
    aside = 2 + int(np.ceil(2.0 * camera.half_height / (np.pi * float(member.tool.normal_module))))
    if 2 * aside + 1 >= teeth:
        return None
    x, y, _ = (camera.focal_point - origin[middle]) @ rotation[middle]
    nearest = round(float(np.arctan2(y, x)) * teeth / (2.0 * np.pi))
    return range(nearest - aside, nearest + aside + 1)


def outline(mesh: Mesh) -> Surface:
    """Make only the sharp edges of a mesh: a surface that is not seen itself."""
    rounded = np.round(mesh.points / WHOLE)
    _, index, joined = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return Surface(mesh.points[index], joined.reshape(-1)[mesh.faces], None, opacity=0.0, edges=True)


def paths_on_teeth(film: Film, step: int) -> FloatArray:
    """Give the path of contact on the pinion tooth of every pair, points (pairs, n, 3) in S_f, mm, at one
    position."""
    rotation, origin = (part[step] for part in film.motion.frames[0])
    points, member, pairs = film.path.points[0], film.motion.design.pinion, film.motion.pairs.tolist()
    return np.stack([to_fixed((rotation, origin), posed.on_tooth(points, member, pair)) for pair in pairs])
