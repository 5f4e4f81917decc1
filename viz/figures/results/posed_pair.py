"""The pair in mesh as exported: closed triangle meshes in contact."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.operation.contact_pattern.pattern import MemberPattern
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.report.pattern import pattern_report
from beveloid_geom.shapes.sampling import default_tolerance
from beveloid_geom.shapes.sheet import grid_faces
from beveloid_geom.shapes.surface_mesh import TriangleMesh, gear_mesh

from ...components import paths_table, posed
from ...components.annotate import Overlay
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.paths_table import SolvedPath
from ...components.posed import PosedPair
from ...rendering import theme
from ...rendering.scene import Camera, Item, Picture, Size, Surface, Tube, fit_camera


@dataclass(frozen=True, eq=False)
class PosedFigure:
    """The pair as posed, the meshes of its members in their frames (None with the reason), the path of
    contact, and the contact pattern on the pinion (None if unknown)."""

    pair: PosedPair
    meshes: tuple[tuple[TriangleMesh | None, str], ...]
    path: SolvedPath
    pattern: MemberPattern | None


def tolerance_of(design: Design) -> float:
    """Return the tolerance of the meshes, mm: the default of `beveloid-geom mesh`."""
    return default_tolerance(design.pinion)  # a tenth of a pixel of the close picture on a page of 1000 x 750


def compute(design: Design, flank: str = "right") -> PosedFigure:
    """Compute the meshes of both gears, and path and pattern."""
    pattern = None
    with suppress(ValueError):
        pattern = pattern_report("", design, flank, MARKING_SEPARATION_MM).result.pinion
    meshes: list[tuple[TriangleMesh | None, str]] = []
    for member in design.members:
        try:
            meshes.append((gear_mesh(member, tolerance_of(design)), ""))
        except ValueError as error:
            meshes.append((None, str(error)))
    return PosedFigure(
        posed.pose(design, flank), tuple(meshes), paths_table.solved_case(design, flank), pattern
    )


def draw(data: PosedFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the complete pair, and the teeth in mesh with paths and patterns."""
    flank = data.path.path.flank
    pose = f"at nominal rolls: the {flank} flanks have no contact point"
    if data.pair.touching:
        pose = f"{flank} flanks in contact in the middle of their path"
    counts = "; ".join(
        f"{name} {len(mesh.faces):,} triangles" if mesh else f"{name}: {reason}"
        for name, (mesh, reason) in zip(paths_table.MEMBERS, data.meshes, strict=True)
    )
    page, low, heading = theme.new_page(
        layout,
        "The pair in mesh as exported",
        f"Closed meshes with a tolerance of {tolerance_of(data.pair.design):.3g} mm, {pose}",
        f"{counts.capitalize()}.{_marks(data)}",
        above=0.25,
        tall=theme.stacked_height(layout, 5.2),
    )
    pictures: dict[str, Picture] = {}
    high = heading - theme.inches(page, 0.1)
    places = theme.pair_of_boxes(page, low, high, ((0.02, 0.42), (0.45, 0.53)), 0.35)
    for letter, place, scene in zip("ab", places, (_pair_view, mesh_view), strict=True):
        name = "the pair" if scene is _pair_view else "teeth in mesh"
        y = place[1] + place[3] + theme.inches(page, 0.1)
        x = max(place[0], 0.4 / layout.width)  # below the title
        page.text(x, y, f"({letter})  {name}", fontsize=theme.HEADING)
        box, drawn = theme.place(page, *place), [mesh for mesh, _ in data.meshes if mesh is not None]
        if not drawn or (scene is mesh_view and not data.pair.touching):
            missing = f"the {flank} flanks have no contact point" if drawn else "no member can be drawn"
            theme.message(theme.overlay(page, box), missing, 60)
            continue
        over = Overlay.drawn(page, box, *scene(data, box.size))
        pictures[name] = over.picture
        if scene is _pair_view:
            _label(over, data)
    return Drawing(page, pictures)


def _marks(data: PosedFigure) -> str:
    """Return the sentences on the marks on the pinion flanks."""
    if not data.pair.touching:
        return ""
    along = "" if line_of_contact(data) is None else ", on the line of contact (black)"
    words = (
        f" (b): {data.path.path.flank} flanks of the pinion, gear transparent. Orange: path of contact of a"
        f" tooth pair. Ball: point of contact{along}."
    )
    if data.pattern is not None:
        band = f"separation below {1e3 * MARKING_SEPARATION_MM:g} \u00b5m"
        words += f" Blue, darker in front of the gear: contact pattern, {band}."
    return words


def _label(over: Overlay, data: PosedFigure) -> None:
    """Label the members that are drawn."""
    pair = data.pair
    for number, (member, frame) in enumerate(zip(pair.design.members, pair.frames, strict=True)):
        if data.meshes[number][0] is None:
            continue
        rims = to_fixed(frame, posed.rings(member)).reshape(-1, 3)
        seen = over.picture.project(rims)
        place = rims[int(np.argmax(seen[:, 1] if number else -seen[:, 1]))]
        over.label(place, paths_table.MEMBERS[number], (0.0, -16.0 if number else 14.0))


def _pair_view(data: PosedFigure, size: Size) -> tuple[Sequence[Item], Camera]:
    parts = zip(data.meshes, data.pair.frames, theme.METALS, strict=True)
    items = [
        posed.placed_surface(mesh, frame, colour, edges=True)
        for (mesh, _), frame, colour in parts
        if mesh is not None
    ]
    reach = posed.reach(data.pair, feet=False)
    return items, fit_camera(reach, posed.VIEW, posed.UP, size, 0.06, perspective=True)


def mesh_view(data: PosedFigure, size: Size) -> tuple[Sequence[Item], Camera]:
    """Return the teeth in mesh with paths, pattern and point of contact, and the camera."""
    gear_opacity = 0.3
    # Smallest half height of the close picture, in normal modules.
    half_height_modules = 4.0
    # Radius of a path as a fraction of half the height of the close picture.
    tube_share = 0.008
    pair, paths = data.pair, on_teeth(data, data.path.points[0])
    points, normal = np.concatenate(paths), np.nanmean(data.path.path.normal, axis=0)
    camera = posed.mesh_camera(pair.design, pair.frames[0], points, normal, size, half_height_modules)
    radius = tube_share * camera.half_height
    # A wider white tube behind each path is its outline. The path is moved towards the viewer by twice its
    # width, so that the outline does not cover it where the path runs along the line of sight.
    ahead = -4.0 * radius * camera.direction
    items: list[Item] = [Tube(line + ahead, theme.VERMILLION, radius) for line in paths]
    items += [Tube(line, "white", 1.8 * radius) for line in paths]
    items.append(Tube(pair.contact[None] + ahead, theme.INK, 3.0 * radius))
    line = line_of_contact(data)
    if line is not None:
        items.append(Tube(line, theme.INK, radius))
    items += _pattern(data)
    seen = np.hypot(1.0, size[0] / size[1]) * camera.half_height
    for number, ((mesh, _), frame) in enumerate(zip(data.meshes, pair.frames, strict=True)):
        if mesh is None:
            continue
        shown = posed.teeth_in_mesh(mesh, camera, frame[0][:, 2])
        away = (to_fixed(frame, shown.points) - camera.focal_point) @ camera.axes[:2].T
        near = np.linalg.norm(away, axis=1) < 1.5 * seen
        shown = shown.where(near[shown.faces].any(axis=1))
        colour, opacity = theme.METALS[number], gear_opacity if number else 1.0
        items.append(posed.placed_surface(shown, frame, colour, opacity, edges=True))
    return items, camera


def _pattern(data: PosedFigure) -> list[Surface]:
    """Return the contact pattern on each of the teeth, slightly above the flank, cut at its border."""
    import pyvista as pv  # takes half a second to import

    side, member, flank = data.pattern, data.pair.design.pinion, data.path.path.flank
    if side is None:
        return []
    normals = flank_patch(member, flank, side.l, z=side.z).normal
    lift = 0.004 * float(member.tool.normal_module)
    faces: Any = grid_faces(side.points, normals)
    # Points without a separation are as far above the limit as the limit is above zero.
    above = np.where(
        side.marked, np.minimum(side.least, MARKING_SEPARATION_MM), np.fmax(side.least, MARKING_SEPARATION_MM)
    )
    above = np.where(np.isfinite(side.least), above, 2.0 * MARKING_SEPARATION_MM)
    surface = pv.PolyData.from_regular_faces((side.points + lift * normals).reshape(-1, 3), faces)
    surface.point_data["separation"] = above.ravel()
    marked = surface.clip_scalar(scalars="separation", value=MARKING_SEPARATION_MM).triangulate()
    if not marked.n_cells:
        return []
    return [
        Surface(points, marked.regular_faces, None, "#2f78b7")
        for points in on_teeth(data, np.asarray(marked.points, dtype=float))
    ]


def on_teeth(data: PosedFigure, points: FloatArray) -> list[FloatArray]:
    """Return points (n, 3) of tooth 0 of the pinion on teeth -1, 0 and 1 in S_f, mm."""
    member, frame = data.pair.design.pinion, data.pair.frames[0]
    return [to_fixed(frame, posed.on_tooth(points, member, tooth)) for tooth in (-1, 0, 1)]


def line_of_contact(data: PosedFigure) -> FloatArray | None:
    """Return both ends (2, 3) in S_f, mm, of the line of contact on parallel axes; None for point contact."""
    lines = data.path.contact_lines(0)
    return to_fixed(data.pair.frames[0], lines[len(lines) // 2]) if len(lines) else None


def rows(data: PosedFigure) -> Table:
    """List frames of the members and sizes of their meshes."""
    frame = (*(f"rotation_{i}{j}" for i in "xyz" for j in "xyz"), *(f"origin_{i}_mm" for i in "xyz"))
    lines = []
    for number, (mesh, _) in enumerate(data.meshes):
        rotation, origin = data.pair.frames[number]
        sizes = (len(mesh.points), len(mesh.faces)) if mesh else (0, 0)
        numbers = [float(data.pair.roll[number]), *rotation.ravel().tolist(), *origin.tolist()]
        lines.append((paths_table.MEMBERS[number], *sizes, *numbers))
    return ("member", "points", "triangles", "roll_rad", *frame), lines


RECIPES = {"posed-pair": Recipe(compute, draw, rows)}
