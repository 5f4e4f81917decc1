"""A tooth meshed for finite elements, with its named surfaces in colours."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.colors import to_hex

from beveloid_geom import Design, Member, tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.hexahedral_mesh import VolumeMesh, element_shapes, face_nodes, rounded_down

from ...components import annotate
from ...components.annotate import Offset, Overlay
from ...components.figure_steps import Drawing, Recipe, Table
from ...rendering import theme
from ...rendering.layout import PanelRows
from ...rendering.scene import Camera, Paint, Picture, Scene, Size, Surface, fit_camera, render

COLOURS = {
    "right flank": "#e07b54",
    "left flank": "#5b9bd5",
    "right fillet": "#f2c14e",
    "left fillet": "#8fd0e8",
    "tip": "#6fbf8b",
    "bottom": "#b48ac0",
    "toe": "#f6f6f6",
    "heel": "#f6f6f6",
    "bore": "#c87f95",
    "first side": "#c9c2b4",
    "last side": "#c9c2b4",
}


@dataclass(frozen=True, eq=False)
class View:
    """A picture of the tooth: name, direction of view (radial, circumferential, axial), depth shown below the
    tip in tooth depths, and labels of surfaces with their offsets."""

    name: str
    direction: FloatArray
    below: float
    words: dict[str, Offset]


def _views() -> tuple[View, View]:
    """Return the two pictures of the tooth."""
    on = (0.0, 0.0)  # label on the surface
    first = {"tip": (46.0, 34.0), "right flank": on, "right fillet": on, "bottom": (24.0, -36.0)}
    second = {"left flank": on, "left fillet": (-12.0, -40.0), "toe": on, "first side": on, "bore": on}
    first |= {"heel": on, "last side": on}
    return (
        View("right flank, fillet and heel", np.array([-0.5, -0.7, -0.5]), 1.6, first),
        View("left flank, toe, cut side and bore", np.array([0.3, 0.65, 0.7]), np.inf, second),
    )


@dataclass(frozen=True, eq=False)
class MeshedFigure:
    """Mesh of the pinion tooth with the smallest scaled Jacobian of each element, or the reason why there is
    none."""

    member: Member
    mesh: VolumeMesh | None
    quality: FloatArray
    reason: str = ""


def compute(design: Design) -> MeshedFigure:
    """Compute the mesh of the pinion tooth as `beveloid-geom mesh` exports it."""
    try:
        mesh = tooth_hexahedra(design.pinion)
    except ValueError as error:
        return MeshedFigure(design.pinion, None, np.zeros(0), str(error))
    return MeshedFigure(design.pinion, mesh, element_shapes(mesh)[0])


def named_surface(mesh: VolumeMesh, name: str, lines: bool = True) -> Surface:
    """Return one named surface with flat faces, and their edges if `lines`."""
    faces = face_nodes(mesh, mesh.surfaces[name])[:, 3::-1]
    return Surface(mesh.points, faces, None, COLOURS[name], edges=lines, mesh_lines=lines)


def places(
    mesh: VolumeMesh, camera: Camera, size: Size, names: Collection[str]
) -> Iterator[tuple[str, FloatArray]]:
    """Yield for each visible surface of `names` the pixel (2,) in the middle of its visible part.

    Surfaces that are narrower than a pixel are searched in a finer picture."""
    turn = np.linspace(0.0, 2.0 * np.pi, len(COLOURS), endpoint=False)
    circle = np.stack((np.cos(turn), np.sin(turn), np.full_like(turn, -1.0)), axis=-1)
    # Blended pixels differ from all marks.
    marks = dict(zip(COLOURS, np.rint(127.5 + 127.5 * circle).astype(int), strict=True))
    flat, items = np.zeros(len(mesh.points)), []
    for name, mark in marks.items():
        paint = Paint(flat, (to_hex(mark / 255.0),), (-1.0, 1.0))
        items.append(replace(named_surface(mesh, name, lines=False), paint=paint))
    missing = [name for name in marks if name in names]
    for finer in (1, 2):
        image = render(Scene(items, camera), (finer * size[0], finer * size[1])).image
        for name in tuple(missing):
            seen = np.argwhere((image == marks[name]).all(axis=-1))[:, ::-1] / finer
            if seen.size:
                missing.remove(name)
                yield name, seen[np.linalg.norm(seen - seen.mean(axis=0), axis=1).argmin()]
        if not missing:
            return


def draw(data: MeshedFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the tooth from both sides."""
    cells = PanelRows(left=0.32, right=0.32, across=0.32, down=0.6, most=2, least=4.0)
    note = (
        "Lines: edges of the elements, straight between corner nodes. The tooth includes its sector of the"
        " body from the bore to the middle of the adjacent tooth spaces; (b): complete sector. Surfaces"
        " toe and heel: ends at \u2212z and +z."
    )
    mesh, views = data.mesh, _views()
    page, low, high = theme.new_page(
        layout,
        "A tooth of the pinion meshed for finite elements",
        "Hexahedra with 20 nodes, mid-side nodes on the exact surfaces; named surfaces in colours",
        ""
        if mesh is None
        else f"{len(mesh.hexahedra):,} elements, {len(mesh.points):,} nodes; scaled Jacobian of the elements"
        f" {rounded_down(data.quality.min())} to {data.quality.max():.2f}. {note}",
        above=0.35,
        tall=cells.tall(layout, len(views), min(cells.width(layout, len(views)), 5.2)),
    )
    if mesh is None:
        page.text(0.5, 0.5, textwrap.fill(f"no mesh: {data.reason}", 60), ha="center", va="center")
        return Drawing(page, {})
    pictures: dict[str, Picture] = {}
    items = [named_surface(mesh, name) for name in COLOURS]
    radius = np.hypot(*mesh.points[:, :2].T)
    depth = 2.25 * float(data.member.tool.normal_module)
    boxes = cells.boxes(layout, len(views), page.get_figheight(), low, high)
    for letter, view, place in zip("ab", views, boxes, strict=True):
        box = theme.place(page, *place)
        shown = mesh.points[radius > radius.max() - view.below * depth]
        camera = fit_camera(shown, view.direction, (1.0, 0.0, 0.0), box.size, 0.03)
        over = Overlay.drawn(page, box, items, camera)
        for name, pixel in places(mesh, camera, box.size, view.words):
            annotate.note(over.axes, pixel, name, view.words[name])
        pictures[view.name] = over.picture
        left, bottom, _, height = place
        x, y = left + 0.08 / layout.width, bottom + height + theme.inches(page, 0.15)
        page.text(x, y, f"({letter})  {view.name}", fontsize=theme.HEADING)
    return Drawing(page, pictures)


def rows(data: MeshedFigure) -> Table:
    """List the sizes of the named sets."""
    header, mesh = ("set", "element_faces", "nodes"), data.mesh
    if mesh is None:
        return header, []
    return header, [(name, len(faces), len(mesh.node_sets[name])) for name, faces in mesh.surfaces.items()]


RECIPES = {"meshed-tooth": Recipe(compute, draw, rows)}
