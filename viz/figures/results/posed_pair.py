"""The posed pair as it is exported: closed surfaces of triangles, in mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import Mesh

from ...parts import posed, solved
from ...parts.annotate import Overlay
from ...parts.posed import PosedPair
from ...parts.recipe import Drawing, Recipe, Table
from ...parts.solved import SolvedPath
from ...stage import theme
from ...stage.scene import Camera, Item, Picture, Scene, Size, fit_camera, render

TOLERANCE = 1.0 / 600.0
"""In normal modules, so that teeth of any size look alike: a tenth of a pixel of the close picture on a
page of 1000 x 750."""
EXPORTED = 0.01
"""mm: the tolerance of `beveloid-geom mesh` unless told otherwise."""
VIEW, UP = np.array([-0.5, 0.52, 0.7]), np.array([0.0, -1.0, 0.0])
NEAR = np.array([-0.12, 0.45, 0.88])
CLOSE = 4.6
"""Half the height of the close picture, in normal modules."""
GLASS = 0.45


@dataclass(frozen=True, eq=False)
class PosedFigure:
    """The pair as posed, the meshes of its members in their own frames (None with the reason), and
    the path of contact of the right flanks."""

    pair: PosedPair
    meshes: tuple[tuple[Mesh | None, str], ...]
    path: SolvedPath


def tolerance_of(design: Design) -> float:
    """Say by how much (mm) the meshes of a design may miss the exact surfaces."""
    return TOLERANCE * float(design.pinion.tool.normal_module)


def compute(design: Design) -> PosedFigure:
    """Find both gears to the tolerance, and their path."""
    meshes = tuple(posed.teeth_of(member, tolerance_of(design)) for member in design.members)
    return PosedFigure(posed.pose(design), meshes, solved.solve(design, "right"))


def draw(data: PosedFigure, size: Size) -> Drawing:
    """Draw the pair as a whole, and the teeth in mesh with the triangles' edges."""
    page = theme.new_page(
        size,
        "The posed pair as exported",
        f"Closed surfaces within {tolerance_of(data.pair.design):.3g} mm of the exact ones, "
        + (
            "right flanks in contact in the middle of their path"
            if np.isfinite(data.pair.contact).all()
            else "at nominal rolls: the right flanks share no contact point"
        ),
    )
    counts = "; ".join(
        f"{name} {len(mesh.faces):,} triangles" if mesh else f"{name}: {reason}"
        for name, (mesh, reason) in zip(solved.MEMBERS, data.meshes, strict=True)
    )
    low = theme.caption(
        page,
        f"{counts.capitalize()}. (b) looks at the toes along the teeth in mesh, the gear as if of glass;"
        " black lines are the triangles' edges. Thick lines, drawn over everything: the paths of contact on"
        f" the pinion's right flanks.{_export_note(data.pair.design)}",
    )
    pictures: dict[str, Picture] = {}
    heading = theme.top(page) - theme.inches(page, 0.25)
    for column, (left, width, name) in enumerate(((0.02, 0.42, "the pair"), (0.45, 0.53, "teeth in mesh"))):
        box = theme.place(page, left, low, width, heading - theme.inches(page, 0.1) - low)
        scene = close(data) if column else _whole(data, box.size)
        pictures[name] = render(scene, box.size)
        over = Overlay(theme.show(page, box, pictures[name]), pictures[name])
        page.text(left, heading, f"({'ab'[column]})  {name}", fontsize=theme.HEADING)
        if (pictures[name].image == 255).all():
            theme.say(over.axes, "the right flanks share no contact point to look at", 60)
        if column == 0:
            _label(over, data)
        else:
            _draw_paths(over, data)
    return Drawing(page, pictures)


def _export_note(design: Design) -> str:
    """Say how to export what is drawn, where `mesh` by itself would take another tolerance."""
    tolerance = tolerance_of(design)
    usual = abs(tolerance - EXPORTED) < 1e-9 * EXPORTED
    return "" if usual else f" `mesh` exports this with --tolerance {tolerance:.3g}."


def _label(over: Overlay, data: PosedFigure) -> None:
    pair = data.pair
    for number, (member, frame) in enumerate(zip(pair.design.members, pair.frames, strict=True)):
        if data.meshes[number][0] is None:
            continue
        heel = to_fixed(frame, posed.rings(member))[1]
        seen = over.picture.project(heel)
        place = heel[int(np.argmax(seen[:, 1] if number else -seen[:, 1]))]
        offset = (0.0, -14.0 if number else 14.0)
        over.label(place, solved.MEMBERS[number], offset)


def _draw_paths(over: Overlay, data: PosedFigure) -> None:
    """Draw the paths over everything: the flanks in contact are seen from behind."""
    for line in paths_on_teeth(data):
        over.line(line, color=theme.PATH, linewidth=3.0)
    if np.isfinite(data.pair.contact).all():
        over.line(data.pair.contact, marker="o", ms=11.0, mfc=theme.PATH, mec="white", mew=1.5, zorder=5)
        note = "point of contact"
        over.note(data.pair.contact, note, (60.0, -70.0), color=theme.INK)


def _whole(data: PosedFigure, size: Size) -> Scene:
    found = zip(data.meshes, data.pair.frames, theme.METALS, strict=True)
    items = [posed.surface(mesh, frame, colour) for (mesh, _), frame, colour in found if mesh is not None]
    return Scene(items, fit_camera(posed.reach(data.pair, feet=False), VIEW, UP, size, 0.06))


def close(data: PosedFigure) -> Scene:
    """Make the teeth in mesh, seen at the toes along the teeth."""
    pair = data.pair
    module = float(pair.design.pinion.tool.normal_module)
    middle = pair.contact if np.isfinite(pair.contact).all() else pair.foot.mean(axis=0)
    camera = Camera(NEAR, UP, middle, CLOSE * module)
    items: list[Item] = []
    for number, ((mesh, _), frame) in enumerate(zip(data.meshes, pair.frames, strict=True)):
        if mesh is None:
            continue
        near = _near(mesh, to_fixed(frame, mesh.points), middle, 3.0 * CLOSE * module)
        colour, opacity = ((theme.STEEL, 1.0), (theme.BRONZE, GLASS))[number]
        surface = posed.surface(near, frame, colour, opacity)
        items.append(surface if number else posed.with_lines(surface))
    return Scene(items, camera)


def _near(mesh: Mesh, points: FloatArray, middle: FloatArray, reach: float) -> Mesh:
    """Give the faces that come near a point."""
    close = np.linalg.norm(points - middle, axis=1) < reach
    return mesh.where(close[mesh.faces].any(axis=1))


def paths_on_teeth(data: PosedFigure) -> list[FloatArray]:
    """Give paths (n, 3) in S_f on the pinion's teeth -1, 0, 1, mm."""
    points, member = data.path.points[0], data.pair.design.pinion
    teeth = (-1, 0, 1) if data.path.found else ()
    return [to_fixed(data.pair.frames[0], posed.on_tooth(points, member, tooth)) for tooth in teeth]


def rows(data: PosedFigure) -> Table:
    """List frames of the members, and sizes of their meshes."""
    header = (
        "member",
        "points",
        "triangles",
        "roll_rad",
        *(f"rotation_{i}{j}" for i in "xyz" for j in "xyz"),
    )

    def body() -> Iterator[list[object]]:
        for number, (mesh, _) in enumerate(data.meshes):
            rotation, origin = data.pair.frames[number]
            sizes = [len(mesh.points), len(mesh.faces)] if mesh else [0, 0]
            numbers = [*rotation.ravel().tolist(), *origin.tolist()]
            yield [solved.MEMBERS[number], *sizes, float(data.pair.roll[number]), *numbers]

    return (*header, "origin_x_mm", "origin_y_mm", "origin_z_mm"), body()


RECIPES = {"posed-pair": Recipe(compute, draw, rows)}
