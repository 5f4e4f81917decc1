"""The method in one picture: coarse meshes, proximity query, and contact on the exact flanks.

Proximity query: search for the smallest distance of the vertices of one mesh from the other mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.tri import Triangulation

from beveloid_geom import Design, Status, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.report.text import status_words
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from beveloid_geom.shapes.proximity.mesh_contact import MeshContact, mesh_contact
from beveloid_geom.shapes.proximity.mesh_separation import MeshSeparation, mesh_separation
from beveloid_geom.shapes.sheet import Faces

from ...components import annotate
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...components.paths_table import as_large, coefficients, paper_modified, two_digits
from ...rendering import theme
from ...rendering.layout import PanelRows

BAND_COLOURS = ("#08306b", "#2166ac", "#4393c3", "#92c5de", "#c6dfee", "#e3eef6", "#f7f7f7")
"""Colours of the bands of separation, scaled with the module."""
MARKS = {
    "nearest vertices of the meshes": ("o", "white", theme.VERMILLION, 11.0),
    "polished": ("o", theme.VERMILLION, "white", 13.0),
    "path of contact": ("x", theme.INK, theme.INK, 7.0),
}


@dataclass(frozen=True, eq=False)
class MethodFigure:
    """One position of a pair by three methods, or the `reason` for its absence.

    `query` has the separation at the vertices of the pinion's coarse mesh, `faces` its triangles, `triangles`
    the numbers by member, `detail` the exact separation. `exact` (2,) are l and z on the pinion, mm, of the
    path of contact, and `point` (3,) its position. `contacts` has the contact by the meshes alone,
    and the polished one."""

    design: Design
    flank: str
    tolerance: float
    query: MeshSeparation | None = None
    faces: Faces | None = None
    triangles: tuple[int, ...] = ()
    detail: MeshSeparation | None = None
    exact: FloatArray | None = None
    point: FloatArray | None = None
    contacts: tuple[MeshContact, ...] = ()
    reason: str = ""


def compute(design: Design, flank: str = "right") -> MethodFigure:
    """Compute the middle position of the pair with the paper's modification."""
    pair, scale = paper_modified(design), as_large(design)
    # Tolerances of the meshes at module 6 mm: those of the query, and one for the separation in the detail.
    coarse_mm, fine_mm = 0.02, 0.00001
    tolerance = coarse_mm * scale
    try:
        path = path_of_contact(pair, flank, 3)
        if not path.l1.size:
            raise ValueError(f"the {flank} flanks have no path of contact")
        pose = {"pinion_roll": float(path.pinion_roll[1]), "gear_roll": float(path.gear_roll[1])}
        contacts = tuple(
            mesh_contact(pair, flank, tolerance, **pose, polish=polish) for polish in (False, True)
        )
        if any(one.status != Status.SOLVED for one in contacts):
            lines = "; the flanks touch along lines" if is_line_contact(pair, flank).any() else ""
            raise ValueError(f"no contact found from the meshes: {status_words(contacts[-1].status)}{lines}")
        query = mesh_separation(pair, flank, 0, tolerance, **pose, polish=False)
        detail = mesh_separation(pair, flank, 0, fine_mm * scale, **pose, polish=True)
    except ValueError as error:
        return MethodFigure(pair, flank, tolerance, reason=str(error))
    faces = [flank_mesh(member, flank, tolerance).faces for member in pair.members]
    exact = np.array((path.l1[1], path.pinion_z[1]))
    numbers = len(faces[0]), len(faces[1])
    return MethodFigure(
        pair, flank, tolerance, query, faces[0], numbers, detail, exact, path.point[1], contacts
    )


def draw(data: MethodFigure, layout: theme.PageLayout) -> Drawing:
    """Draw the flank with the query, and the detail with the distances."""
    cells = PanelRows(left=1.2, right=0.4, across=1.4, down=1.5, most=2, least=3.6)
    numbers = " + ".join(map(str, data.triangles))
    meshes = f". Meshes within {data.tolerance:.2g} mm: {numbers} triangles" if numbers else ""
    page, low, high = theme.new_page(
        layout,
        finding(data),
        f"{data.flank.capitalize()} flanks, {coefficients(data.design)}, one position" + meshes,
        (
            "(a) Proximity query: distance of the vertices of the pinion flank (colours) from the gear mesh."
            " (b) Separation of the exact flanks. Polished: by Newton's method from the nearest vertices. A"
            " query finds tangencies only, a search of all teeth also edge contact."
        )
        if data.triangles
        else "",
        below=0.75,
        above=1.15,
        tall=cells.tall(layout, 2, 3.4),
    )
    first, second = theme.panels(page, cells, 2, low, high)
    first.set_title("(a)  Proximity query", loc="left", pad=10.0)
    second.set_title("(b)  Detail: the polished contact", loc="left", pad=10.0)
    for axes in (first, second):
        axes.set(xlabel="z (mm)", ylabel="flank parameter l (mm)")
    if data.query is None or data.detail is None or data.exact is None:
        for axes in (first, second):
            axes.set_axis_off()
            theme.message(axes, data.reason)
        return Drawing(page, {})
    scale = as_large(data.design)
    _separation(first, data.query, scale, data.faces)
    _separation(second, data.detail, scale)
    window = _window(data)
    second.set(xlim=window[1], ylim=window[0])
    (bottom, top), (left, right) = window
    first.add_patch(Rectangle((left, bottom), right - left, top - bottom, fill=False, ec=theme.INK, lw=1.6))
    for axes in (first, second):
        for name, (l, z) in points(data).items():
            mark, face, edge, size = MARKS[name]
            axes.plot(z, l, mark, mfc=face, mec=edge, ms=size, mew=2.0)
    _distance(second, data)
    entries = [
        Line2D([], [], ls="", marker=mark, mfc=face, mec=edge, ms=size, mew=2.0, label=name)
        for name, (mark, face, edge, size) in MARKS.items()
    ]
    theme.legend(page, [*entries, *_bands(scale)], 6, left=0.02, below=1.35)
    return Drawing(page, {})


def points(data: MethodFigure) -> dict[str, FloatArray]:
    """Return l and z of the three points on the pinion, mm, in the order of MARKS."""
    assert data.exact is not None
    contacts = [np.array((one.l[0], one.z[0])) for one in data.contacts]
    return dict(zip(MARKS, (*contacts, data.exact), strict=True))


def _window(data: MethodFigure) -> FloatArray:
    """Return the limits (2, 2) of the detail in l and z, mm."""
    # Free space around the points in the detail, as a fraction of their distance.
    margin = 0.45
    # Smallest distance of the points in l and in z for the detail, as a fraction of the flank.
    least_share = 0.1
    assert data.query is not None
    both = np.stack(list(points(data).values()))
    low, high = both.min(axis=0), both.max(axis=0)
    flank = np.array((np.ptp(data.query.l), np.ptp(data.query.z)))
    half = (0.5 + margin) * np.maximum(high - low, least_share * flank)
    middle = 0.5 * (low + high)
    return np.stack((middle - half, middle + half), axis=-1)


def _limits_um(scale: float) -> list[float]:
    """Return the limits of the bands of separation at a module, um, with two digits."""
    bands_um = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 1e9)
    return [two_digits(scale * band) for band in bands_um]


def _separation(axes: Axes, side: MeshSeparation, scale: float, faces: Faces | None = None) -> None:
    """Draw the separation in bands over z and l, and the edges of given triangles."""
    colours, bands = ListedColormap(list(BAND_COLOURS)), _limits_um(scale)
    known = np.isfinite(side.separation)
    values = np.where(known, 1e3 * np.maximum(side.separation, 0.0), bands[-2] + scale)
    mesh = Triangulation(side.z.ravel(), side.l.ravel(), faces)
    axes.tricontourf(mesh, values.ravel(), bands, cmap=colours, norm=BoundaryNorm(bands, colours.N))
    if faces is not None:
        axes.triplot(mesh, color=theme.GREY, linewidth=0.5)
    axes.autoscale(tight=True)


def _distance(axes: Axes, data: MethodFigure) -> None:
    """Draw the distance of the nearest vertices from the contact, and write both errors."""
    assert data.point is not None
    (alone, polished), point = data.contacts, data.point
    (l, z), _, (l0, z0) = points(data).values()
    line: dict[str, Any] = {"color": theme.VERMILLION, "linewidth": 1.6, "path_effects": annotate.rim(1.6)}
    axes.plot((z, z0), (l, l0), "--", zorder=1.5, **line)
    off = [float(np.linalg.norm(one.point - point)) for one in (alone, polished)]
    ends = axes.transData.transform(((z, l), (z0, l0)))
    length = float(np.linalg.norm(ends[1] - ends[0]))
    along = (ends[1] - ends[0]) / length if length > 0.0 else np.array((0.0, 1.0))
    across = np.array((-along[1], along[0])) * (1.0 if along[1] > 0.0 else -1.0)  # to the left
    # Both texts are on the outer side of the line and its end, and do not leave the panel.
    right, up = (14.0 * across).tolist()
    va = "center" if abs(up) < 6.0 else "bottom" if up > 0.0 else "top"
    annotate.text(axes, (0.5 * (z + z0), 0.5 * (l + l0)), f"{off[0]:.2g} mm", (right, up), ha="right", va=va)
    ha = "center" if abs(along[0]) < 0.4 else "right" if along[0] > 0.0 else "left"
    over = (20.0 * float(np.sign(along[0])) if ha != "center" else 0.0), 12.0 if along[1] > 0.0 else -12.0
    va = "bottom" if along[1] > 0.0 else "top"
    annotate.text(axes, (z0, l0), f"polished: {annotate.power_of_ten(off[1])} mm", over, ha=ha, va=va)


def _bands(scale: float) -> list[Patch]:
    """Return the entries of the legend for the bands of separation."""
    bands = [f"{band:g}" for band in _limits_um(scale)[:-1]]
    texts = [f"{one} to {other} \u00b5m" for one, other in pairwise(bands)]
    return [
        Patch(facecolor=colour, edgecolor=theme.GREY, linewidth=0.5, label=text)
        for colour, text in zip(BAND_COLOURS, [*texts, f"above {bands[-1]} \u00b5m"], strict=True)
    ]


def finding(data: MethodFigure) -> str:
    """Return the title with the errors of the meshes alone and polished."""
    if data.point is None:
        return "Contact by meshes, and by the exact flanks"
    alone, polished = (float(np.linalg.norm(one.point - data.point)) for one in data.contacts)
    return (
        f"Coarse meshes find the contact to {alone:.2g} mm, a polish on the exact flanks to"
        f" {annotate.power_of_ten(polished)} mm"
    )


def rows(data: MethodFigure) -> Table:
    """List the three points, then the vertices of the coarse mesh."""
    header = ("flank", "status", "point", "l_mm", "z_mm", "separation_um")

    def cases() -> Rows:
        """Yield the columns of each kind of point."""
        if data.query is None:
            yield data.flank, data.reason, "", *3 * [float("nan")]
            return
        separations = [*(1e3 * one.separation for one in data.contacts), 0.0]
        for (name, (l, z)), separation in zip(points(data).items(), separations, strict=True):
            yield data.flank, "solved", name, float(l), float(z), float(separation)
        side = data.query
        status = [Status(int(code)).name.lower() for code in side.status.ravel()]
        yield data.flank, status, "vertex", side.l.ravel(), side.z.ravel(), 1e3 * side.separation.ravel()

    return header, rows_of_cases(cases())


RECIPES = {"method": Recipe(compute, draw, rows)}
