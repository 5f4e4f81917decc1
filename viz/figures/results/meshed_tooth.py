"""A tooth meshed for finite elements, its named surfaces in colours."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.patches import Patch

from beveloid_geom import Design, Member, tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.elements import VolumeMesh, element_shapes, face_nodes

from ...parts.annotate import Overlay
from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import Picture, Surface, fit_camera

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
VIEWS = (
    ("right flank, fillet and heel", np.array([-0.5, -0.7, -0.5]), 2.2),
    ("left flank, toe, cut side and bore", np.array([0.3, 0.65, 0.7]), np.inf),
)
"""Directions of sight (radial, along the circumference, axial, at the tooth), and how far below the
tip the picture must show, in tooth depths."""
CELLS = Cells(left=0.32, right=0.32, across=0.32, down=0.6, most=2, least=4.0)
UP = np.array([1.0, 0.0, 0.0])
NOTE = (
    "Lines are the edges of the elements, drawn straight between corner nodes. The tooth carries its part of"
    " the body, from the bore to the middle of the tooth spaces beside it, where the first and the last side"
    " are cut; (a) shows its upper part."
)


@dataclass(frozen=True, eq=False)
class MeshedFigure:
    """The mesh of the pinion's tooth, the least scaled Jacobian of each of its elements; or why
    there is none."""

    member: Member
    mesh: VolumeMesh | None
    quality: FloatArray
    reason: str = ""


def compute(design: Design) -> MeshedFigure:
    """Mesh the pinion's tooth, as `beveloid-geom mesh` exports it."""
    try:
        mesh = tooth_hexahedra(design.pinion)
    except ValueError as error:
        return MeshedFigure(design.pinion, None, np.zeros(0), str(error))
    return MeshedFigure(design.pinion, mesh, element_shapes(mesh)[0])


def surface_of(mesh: VolumeMesh, name: str) -> Surface:
    """Make one named surface, flat faces with their edges."""
    faces = face_nodes(mesh, mesh.surfaces[name])[:, 3::-1]
    return Surface(mesh.points, faces, None, COLOURS[name], mesh_lines=True)


def draw(data: MeshedFigure, layout: theme.Layout) -> Drawing:
    """Draw the tooth from either side."""
    mesh = data.mesh
    page, low, high = theme.new_page(
        layout,
        "A tooth of the pinion meshed for finite elements",
        "Hexahedra with 20 nodes, mid-side nodes on the exact surfaces; the named surfaces in colours",
        ""
        if mesh is None
        else f"{len(mesh.hexahedra):,} elements, {len(mesh.points):,} nodes; scaled Jacobian of the elements"
        f" {data.quality.min():.2f} to {data.quality.max():.2f}. {NOTE}",
        below=0.75,
        above=0.35,
        tall=CELLS.tall(layout, len(VIEWS), min(CELLS.width(layout, len(VIEWS)), 4.8)),
    )
    if mesh is None:
        page.text(0.5, 0.5, textwrap.fill(f"no mesh: {data.reason}", 60), ha="center", va="center")
        return Drawing(page, {})
    pictures: dict[str, Picture] = {}
    items = [surface_of(mesh, name) for name in COLOURS]
    radius = np.hypot(*mesh.points[:, :2].T)
    depth = 2.25 * float(data.member.tool.normal_module)
    places = CELLS.boxes(layout, len(VIEWS), page.get_figheight(), low, high)
    for column, ((name, direction, below), place) in enumerate(zip(VIEWS, places, strict=True)):
        box = theme.place(page, *place)
        shown = mesh.points[radius > radius.max() - below * depth]
        camera = fit_camera(shown, direction, UP, box.size, 0.03)
        pictures[name] = Overlay.drawn(page, box, items, camera).picture
        left, bottom, width, height = place
        x, y = left + 0.5 * width, bottom + height + theme.inches(page, 0.15)
        page.text(x, y, f"({'ab'[column]})  {name}", ha="center", fontsize=theme.HEADING)
    _legend(page, low)
    return Drawing(page, pictures)


def _legend(page: theme.Page, low: float) -> None:
    named: dict[str, str] = {}
    for name, colour in COLOURS.items():
        named[colour] = f"{named[colour]}, {name}" if colour in named else name
    handles = [Patch(facecolor=colour, edgecolor=theme.GREY, label=text) for colour, text in named.items()]
    place: dict[str, Any] = {"loc": "center", "bbox_to_anchor": (0.5, low - theme.inches(page, 0.4))}
    theme.legend(page, handles, 5, fontsize=theme.SMALL, **place)


def rows(data: MeshedFigure) -> Table:
    """List the sizes of the named sets."""
    header, mesh = ("set", "element_faces", "nodes"), data.mesh
    if mesh is None:
        return header, []
    return header, [(name, len(faces), len(mesh.node_sets[name])) for name, faces in mesh.surfaces.items()]


RECIPES = {"meshed-tooth": Recipe(compute, draw, rows)}
