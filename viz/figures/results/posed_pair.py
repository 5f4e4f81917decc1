"""The posed pair as exported: closed triangle meshes in contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import Mesh, gear_mesh

from ...components import annotate, paths_table, posed
from ...components.annotate import Overlay
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.paths_table import SolvedPath
from ...components.posed import PosedPair
from ...rendering import theme
from ...rendering.scene import Camera, Item, Picture, Size, fit_camera

TOLERANCE_MODULES = 1.0 / 600.0
"""Mesh tolerance in normal modules: a tenth of a pixel of the close picture on a page of 1000 x 750."""
EXPORT_TOLERANCE_MM = 0.01
"""Default tolerance of `beveloid-geom mesh`, mm."""
CLOSE_VIEW_DIRECTION = np.array([-0.12, 0.45, 0.88])
CLOSE_HALF_HEIGHT_MODULES = 4.6
"""Half the height of the close picture, in normal modules."""
GEAR_OPACITY = 0.45
LINE_NOTE = "; black: line of contact"


@dataclass(frozen=True, eq=False)
class PosedFigure:
    """The pair as posed, the meshes of its members in their frames (None with the reason), and the path of
    contact."""

    pair: PosedPair
    meshes: tuple[tuple[Mesh | None, str], ...]
    path: SolvedPath


def tolerance_of(design: Design) -> float:
    """Return the tolerance of the meshes, mm."""
    return TOLERANCE_MODULES * float(design.pinion.tool.normal_module)


def compute(design: Design, flank: str = "right") -> PosedFigure:
    """Compute the meshes of both gears, and their path."""
    meshes: list[tuple[Mesh | None, str]] = []
    for member in design.members:
        try:
            meshes.append((gear_mesh(member, tolerance_of(design)), ""))
        except ValueError as error:
            meshes.append((None, str(error)))
    return PosedFigure(posed.pose(design, flank), tuple(meshes), paths_table.solve(design, flank))


def draw(data: PosedFigure, layout: theme.Layout) -> Drawing:
    """Draw the complete pair, and the teeth in mesh with the edges of the triangles."""
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
        "The posed pair as exported",
        f"Closed meshes with a tolerance of {tolerance_of(data.pair.design):.3g} mm, {pose}",
        f"{counts.capitalize()}. (b): view along the teeth from \u2212z, gear transparent, thin lines: edges"
        f" of the triangles. Thick lines on top: paths of contact on the {flank} flanks of the pinion"
        f"{LINE_NOTE if line_of_contact(data) is not None else ''}."
        f"{_export_note(data.pair.design)}",
        above=0.25,
        tall=theme.stacked_height(layout, 5.2),
    )
    pictures: dict[str, Picture] = {}
    high = heading - theme.inches(page, 0.1)
    places = theme.pair_of_boxes(page, low, high, ((0.02, 0.42), (0.45, 0.53)), 0.35)
    for column, (place, name) in enumerate(zip(places, ("the pair", "teeth in mesh"), strict=True)):
        box = theme.place(page, *place)
        over = Overlay.drawn(page, box, *(close(data) if column else _whole(data, box.size)))
        pictures[name] = over.picture
        y = place[1] + place[3] + theme.inches(page, 0.1)
        page.text(place[0], y, f"({'ab'[column]})  {name}", fontsize=theme.HEADING)
        if (over.picture.image == 255).all():
            theme.message(over.axes, f"the {flank} flanks have no contact point", 60)
        if column == 0:
            _label(over, data)
        else:
            _draw_paths(over, data)
    return Drawing(page, pictures)


def _export_note(design: Design) -> str:
    """Return the sentence with the option --tolerance if it differs from the default."""
    tolerance = tolerance_of(design)
    usual = abs(tolerance - EXPORT_TOLERANCE_MM) < 1e-9 * EXPORT_TOLERANCE_MM
    return "" if usual else f" `mesh` exports this with --tolerance {tolerance:.3g}."


def _label(over: Overlay, data: PosedFigure) -> None:
    """Label the members that are drawn."""
    pair = data.pair
    for number, (member, frame) in enumerate(zip(pair.design.members, pair.frames, strict=True)):
        if data.meshes[number][0] is None:
            continue
        heel = to_fixed(frame, posed.rings(member))[1]
        seen = over.picture.project(heel)
        place = heel[int(np.argmax(seen[:, 1] if number else -seen[:, 1]))]
        offset = (0.0, -14.0 if number else 14.0)
        over.label(place, paths_table.MEMBERS[number], offset)


def _draw_paths(over: Overlay, data: PosedFigure) -> None:
    """Draw the paths on top, because the flanks in contact are seen from behind."""
    for line in paths_on_teeth(data):
        over.line(line, color=theme.PATH, linewidth=3.0, path_effects=annotate.rim(3.0))
    if data.pair.touching:
        touched = line_of_contact(data)
        if touched is not None:
            over.line(touched, color=theme.INK, linewidth=3.0)
        over.line(data.pair.contact, marker="o", ms=11.0, mfc=theme.PATH, mec="white", mew=1.5, zorder=5)
        note = "point of contact" if touched is None else "line of contact"
        over.note(data.pair.contact, note, (60.0, -70.0), color=theme.INK)


def _whole(data: PosedFigure, size: Size) -> tuple[Sequence[Item], Camera]:
    parts = zip(data.meshes, data.pair.frames, theme.METALS, strict=True)
    items = [
        posed.placed_surface(mesh, frame, colour) for (mesh, _), frame, colour in parts if mesh is not None
    ]
    return items, fit_camera(posed.reach(data.pair, feet=False), posed.VIEW, posed.UP, size, 0.06)


def close(data: PosedFigure) -> tuple[Sequence[Item], Camera]:
    """Return the teeth in mesh and the camera, which looks along the teeth from the toe."""
    pair = data.pair
    module = float(pair.design.pinion.tool.normal_module)
    middle = pair.contact if pair.touching else pair.foot.mean(axis=0)
    camera = Camera(CLOSE_VIEW_DIRECTION, posed.UP, middle, CLOSE_HALF_HEIGHT_MODULES * module)
    items: list[Item] = []
    for number, ((mesh, _), frame) in enumerate(zip(data.meshes, pair.frames, strict=True)):
        if mesh is None:
            continue
        near = (
            np.linalg.norm(to_fixed(frame, mesh.points) - middle, axis=1)
            < 3.0 * CLOSE_HALF_HEIGHT_MODULES * module
        )
        shown = mesh.where(near[mesh.faces].any(axis=1))
        drawn = posed.placed_surface(shown, frame, theme.METALS[number], GEAR_OPACITY if number else 1.0)
        items.append(replace(drawn, mesh_lines=number == 0))
    return items, camera


def paths_on_teeth(data: PosedFigure) -> list[FloatArray]:
    """Return paths (n, 3) in S_f on the pinion teeth -1, 0, 1, mm."""
    points, member = data.path.points[0], data.pair.design.pinion
    teeth = (-1, 0, 1) if data.path.found else ()
    return [to_fixed(data.pair.frames[0], posed.on_tooth(points, member, tooth)) for tooth in teeth]


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
