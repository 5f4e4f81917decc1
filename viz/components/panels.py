"""One flank along its normal, with paths of contact.

The flank is projected onto the plane of the picture: y towards +z, x towards the tip (or, on right flanks
seen from outside, away from it), and the remaining direction towards the viewer. Nothing is mirrored: a right
flank with +z at the top and the tip on the right, as in the paper, is seen through the tooth. A sketch next
to the scale bars shows the direction of view (`viewpoint`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from beveloid_geom import Design, sample_flank
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.shapes.sheet import grid_faces

from ..rendering import theme
from ..rendering.polylines import dashed, spaced
from ..rendering.scene import Arrow, Camera, Item, Picture, Scene, Surface, Tube, render
from ..rendering.theme import Page, PageBox
from . import annotate
from .paths_table import SolvedPath, both_ratios
from .viewpoint import FlankView, greatest_span, looks_of, scale_bars

HALF_WIDTH_PT = 2.6
"""Half the width of a path on a wide page, points."""
OUTLINE_PX = 0.03
"""Largest deviation of the triangles of a flank, pixels. Root and tip curve more within the flank than the
flank curves out of its plane."""
SOLID: tuple[float, ...] = ()
FACE_STRETCH = 2.0
"""Magnification from root to tip for flanks that are drawn side by side."""
LABEL_IN = 0.27
"""Inches above and below a flank for labels."""
THIN_WIDTH_RATIO = 0.45
"""Width of the parts of a path that are not first contact, relative to the parts that are. First contact: no
other tooth pair and no edge touches earlier."""
DASHED = (5.0, 3.0)
DOTTED = (1.6, 2.4)
"""Lengths of dash and gap in widths of the path."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Path on a flank. Points that are not first contacts are drawn thin.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Points in the frame of the member, mm, from start to end of contact.
    first : ndarray of bool, shape (n,), optional
        Mask of the first contacts; None for all.
    bare : bool
        True to draw no symbols at the ends.
    dashes : tuple of float
        Lengths of dash and gap in widths of the path.
    width : float
        Factor of the line width.
    lift : float
        Height above the flank, in half widths of the path.
    """

    points: FloatArray
    colour: str = theme.VERMILLION
    dashes: tuple[float, ...] = SOLID
    width: float = 1.0
    lift: float = 0.0
    first: Mask | None = None
    bare: bool = False


def lit_flank(points: FloatArray, normals: FloatArray, view: FlankView, colour: str) -> Surface:
    """Return a grid of points and normals (nl, nz, 3) of a flank as a lit surface in the frame of the
    picture, mm."""
    faces = grid_faces(points, normals)[:, :: 1 if view.outside else -1]
    placed, turned = view.place(points).reshape(-1, 3), view.turn(normals).reshape(-1, 3)
    return Surface(placed, faces, turned, colour, edges=True)


def dashed_circle(points: FloatArray, radius: float) -> Iterable[FloatArray]:
    """Return the dashes of a closed line (n, 3) that is drawn with tubes of a radius, mm."""
    return dashed(points, [length * 2.0 * radius for length in DASHED])


def trace_items(trace: Trace, view: FlankView, radius: float) -> list[Item]:
    """Return a tube with a ball at its start and an arrow head at its end, in front of the flank."""
    # Length of an arrow head in half widths of a path, and factor of the size of ball or arrow head at an end
    # that is not first contact.
    head_length, smaller = 8.0, 0.65
    if len(trace.points) < 2 and not trace.bare:
        return []
    radius *= trace.width
    points = view.place(trace.points) + np.array([0.0, 0.0, (1.0 + trace.lift) * radius])
    if trace.bare:
        return [Tube(spaced(points, radius), trace.colour, radius)]
    first = np.ones(len(points), dtype=bool) if trace.first is None else trace.first
    left = np.linalg.norm(points - points[-1], axis=1)
    enters, leaves = (1.0 if all(end) else smaller for end in (first[:1], first[left < head_length * radius]))
    head = head_length * leaves * radius
    neck = int(np.argmax(left < 0.9 * head))
    vector = points[-1] - points[max(neck - 1, 0)]
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return [Tube(points[:1], trace.colour, 1.8 * radius)]
    body = points[: max(neck, 1) + 1] if left[0] > head else points
    items: list[Item] = []
    cuts = np.flatnonzero(np.diff(first[: len(body)])) + 1
    for start, end in pairwise((0, *cuts.tolist(), len(body))):
        part, thick = body[start : end + 1], radius if first[start] else THIN_WIDTH_RATIO * radius
        pattern = [length * 2.0 * thick for length in trace.dashes or (SOLID if first[start] else DASHED)]
        if pattern and not first[start]:  # at least two dashes on a short part
            length = float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum())
            scale = min(1.0, length / (2.0 * pattern[0] + pattern[1]))
            pattern = [scale * piece for piece in pattern]
        items += [Tube(piece, trace.colour, thick) for piece in dashed(part, pattern)]
    items.append(Tube(points[:1], trace.colour, 1.8 * enters * radius))
    arrow = vector * min(head, float(left[0]) or head) / size
    items.append(Arrow(points[-1] - arrow, arrow, trace.colour, head / 7.0))
    return items


def edge_traces(path: SolvedPath, member: int, look: Trace | None = None) -> list[Trace]:
    """Return the lines of edge contact on pinion (0) or gear (1), with colour, width and lift of `look` if
    given."""
    look = look or Trace(path.points[member], theme.BLUE, lift=1.5)
    return [replace(look, points=line, bare=True) for line in path.edge_lines(member)]


def half_width_pt(page: Page) -> float:
    """Return half the width of a path on a page.

    Parameters
    ----------
    page : Page

    Returns
    -------
    float
        Points; less on narrow pages, where flanks are smaller.
    """
    return HALF_WIDTH_PT if page.layout.wide else 1.5  # smaller flanks


def touching_legend(
    page: Page,
    paths: Sequence[SolvedPath],
    colours: tuple[str, str, str] = (theme.VERMILLION, theme.VERMILLION, theme.BLUE),
) -> list[Line2D]:
    """Return the legend of the parts that some of the paths have: first contact, not first, and edge
    contact."""
    wide = 2.0 * half_width_pt(page)
    looks = (
        ("first contact", wide, (1.0, 0.0), any(path.has_path for path in paths)),
        ("not first", THIN_WIDTH_RATIO * wide, DASHED, _any_not_first(paths)),
        ("edge contact", wide, (1.0, 0.0), any(path.edge_lines(0) or path.edge_lines(1) for path in paths)),
    )
    return [
        Line2D([], [], color=colour, linewidth=width, label=words, dashes=dashes)
        for (words, width, dashes, occurs), colour in zip(looks, colours, strict=True)
        if occurs
    ]


def _any_not_first(paths: Iterable[SolvedPath]) -> bool:
    """Return True if parts of some paths are not first contact."""
    return any(path.has_path and path.first is not None and not path.first.all() for path in paths)


def what_touches(paths: Iterable[SolvedPath]) -> str:
    """Return the sentences of a caption on first contacts and contact ratios."""
    paths = list(paths)
    jammed = any(path.jammed for path in paths)
    not_first = "Not first: another tooth pair or an edge touches earlier"
    not_first += ", or the pair jams (cannot be assembled). " if jammed else ". "
    operation = "" if jammed else " in operation"  # the note has at most 60 words
    ratios = f"Contact ratios: one tooth pair (Eq.\u00a016), all teeth{operation}, without load."
    return (not_first if jammed or _any_not_first(paths) else "") + ratios


def lines_drawn(paths: Iterable[SolvedPath]) -> str:
    """Return the sentence of a caption that explains lines of contact, if there are any."""
    return " Black: some lines of contact." if any(len(path.contact_lines(0)) for path in paths) else ""


@dataclass(frozen=True, eq=False)
class Panel:
    """Flank drawn on a page: axes with the pixels of the picture as coordinates, view, and items drawn."""

    axes: Axes
    picture: Picture
    view: FlankView
    items: Sequence[Item]

    @property
    def page(self) -> Page:
        """Page of the panel."""
        return cast("Page", self.axes.figure)

    def place(self, points: FloatArray) -> FloatArray:
        """Return the pixels (..., 2) of points (..., 3) of the member, mm."""
        return self.picture.project(self.view.place(points))


def draw_flank(
    page: Page,
    box: PageBox,
    design: Design,
    number: int,
    view: FlankView | None,
    traces: Iterable[Trace],
    px_per_mm: float,
    labels_at: float | None = 0.0,
) -> Panel | None:
    """Draw a flank into a box of the page.

    Parameters
    ----------
    page : Page
        Page.
    box : PageBox
        Box for the picture.
    design : Design
        The pair.
    number : int
        Pinion (0) or gear (1).
    view : FlankView or None
        View of the flank; None writes a message instead.
    traces : iterable of Trace
        Paths on the flank.
    px_per_mm : float
        Scale.
    labels_at : float or None
        Position of the labels of root and tip from mid-face (0) to +z (1); None for no labels.

    Returns
    -------
    Panel or None
        None without a flank.
    """
    if view is None:
        theme.message(theme.overlay(page, box), "no drawing: the flank does not reach the tip", 24)
        return None
    try:
        grid = sample_flank(design.members[number], view.flank, OUTLINE_PX / (px_per_mm * view.stretch))
    except ValueError as error:
        reason = str(error).partition(":")[0]  # without the cure
        theme.message(theme.overlay(page, box), f"no drawing: {reason}", 24)
        return None
    items: list[Item] = [lit_flank(grid.points, grid.normals, view, theme.METALS[number])]
    items += path_items(page, traces, view, px_per_mm)
    return show_items(page, box, view, items, px_per_mm, labels_at)


def draw_lines(panel: Panel, path: SolvedPath, member: int) -> None:
    """Draw the lines of contact on pinion (0) or gear (1) over the picture. As tubes in the picture, such
    thin and nearly vertical lines would have steps."""
    for line in path.contact_lines(member):
        look: dict[str, Any] = {"color": theme.INK, "linewidth": 0.4 * 2.0 * half_width_pt(panel.page)}
        panel.axes.plot(*panel.place(line).T, solid_capstyle="butt", **look)


def path_items(page: Page, traces: Iterable[Trace], view: FlankView, px_per_mm: float) -> list[Item]:
    """Return the paths on a flank with the line width of the page."""
    radius = half_width_pt(page) * page.dpi / 72.0 / px_per_mm
    return [item for trace in traces for item in trace_items(trace, view, radius)]


def flank_camera(view: FlankView, half_height: float) -> Camera:
    """Return the camera that shows a flank at the centre. `half_height`: half of the picture height, mm."""
    middle = np.append(view.bounds.mean(axis=0), 0.0)
    return Camera(np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), middle, half_height)


def show_items(
    page: Page,
    box: PageBox,
    view: FlankView,
    items: Sequence[Item],
    px_per_mm: float,
    labels_at: float | None = 0.0,
) -> Panel:
    """Draw items in the frame of a flank view into a box, with labels of the four sides unless `labels_at`
    is None."""
    picture = render(Scene(items, flank_camera(view, 0.5 * box.height / px_per_mm)), box.size)
    axes = theme.show_picture(page, box, picture)
    if labels_at is None:
        return Panel(axes, picture, view, items)
    root, middle, tip = view.marks
    side = 1.0 if tip[1, 0] > root[1, 0] else -1.0
    aligned = ("right", "left")[:: int(side)]
    for text, place, offset, ha, va, rotation in (
        ("root", root[1] + labels_at * (root[2] - root[1]), (-10 * side, 0), aligned[0], "center", 90),
        ("tip", tip[1] + labels_at * (tip[2] - tip[1]), (10 * side, 0), aligned[1], "center", 90),
        (view.ends[1], middle[2], (0, 5), "center", "bottom", 0),
        (view.ends[0], middle[0], (0, -5), "center", "top", 0),
    ):
        style = {"fontsize": theme.SMALL, "color": theme.GREY, "ha": ha, "va": va, "rotation": rotation}
        annotate.text(axes, picture.project(place), text, offset, **style)
    return Panel(axes, picture, view, items)


def shared_scale(page: Page, views: Sequence[FlankView | None], width: float, height: float) -> float:
    """Return the scale, pixels per mm, at which every flank and its text fit into a box of width and height,
    as fractions of the page; also draw the scale bars."""
    box = theme.place(page, 0.0, 0.0, width, height - theme.inches(page, 2.0 * LABEL_IN))
    px_per_mm = float(min(box.size / greatest_span(views)))
    stretch = next((view.stretch for view in views if view), FACE_STRETCH)
    scale_bars(page, px_per_mm, stretch, looks_of(views))
    return px_per_mm


def how_drawn(flank: str, stretch: float, outside: bool = False) -> str:
    """Return the sentence of a caption that describes the views: of 'right', 'left' or 'right and left'
    flanks."""
    seen_from = "from outside" if outside or flank == "left" else "through the tooth"
    return (
        f"View along the normal {seen_from}, {stretch:g} times larger from root to tip. Paths run from ball"
        " to arrow head. "
    )


def ratios(path: SolvedPath) -> tuple[str, str]:
    """Return both contact ratios of a path as text: that of one tooth pair (Eq. 16), and that in
    operation, or "jammed"."""
    if path.jammed:
        return both_ratios(path.ratio, 0.0)[0], "jammed"
    return both_ratios(path.ratio, path.touching.ratio if path.touching else float("nan"))
