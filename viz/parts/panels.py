"""Panels that show one flank square on, with paths of contact on it.

A flank is laid flat into the plane of the picture: y towards the heel, x towards the tip or, on right flanks
seen from outside, away from it, and the rest towards the viewer. Nothing is mirrored: on a right flank, with
the heel on top and the tip on the right, as in the paper, one looks at it through the tooth, from its metal
side. A sketch beside the scales says so (`viewpoint`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import Any, TypeAlias, cast

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, sample_flank
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.shapes.sampling import grid_faces

from ..stage import theme
from ..stage.layout import Cells
from ..stage.scene import Arrow, Camera, Item, Picture, Scene, Surface, Tube, render
from ..stage.theme import Box, Page
from . import annotate
from .solved import MEMBERS, SolvedPath, both_ratios
from .viewpoint import FlankView, flank_views, greatest_span, looks_of, scale_bars

LINE_POINTS = 2.6
"""Half the width of a path, in points of the page."""
OUTLINE_PX = 0.03
"""Pixels by which triangles may miss the flank: less than half of one, since root and tip curve
more within the flank, as an outline, than the flank does out of itself."""
INTO_PAGE, UP = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
SOLID: tuple[float, ...] = ()
STRETCH = 2.0
"""How many times as large across as along flanks are drawn side by side."""
LEFT, RIGHT = 0.045, 0.99  # shares of the page's width
CELLS = Cells(left=0.72, right=0.16, across=0.0, down=0.0, most=5, least=0.95)
LABEL, HEADING = 0.27, 0.4
"""Inches over and under a flank, and over a column."""
FLANK_SHARE = 0.88
"""Of the width of a column of flanks, that of the widest."""
Texts: TypeAlias = tuple[float, float]
"""Inches of words under a pinion's and under a gear's flank."""
THIN, SMALL, EDGE = 0.45, 0.65, theme.BLUE
"""Width of a path, and size of its ends, where something else touches earlier, as shares; colour of edges
that touch instead."""
HEAD = 8.0
"""Length of an arrow's head in half widths of a path; one is as large only where all of it is contact."""
LINE = 0.4
"""Width of a line of contact as a share of a path's."""
LINES_DRAWN = (
    " Black lines across a path: the flanks touch along lines, of which these are some; the path crosses"
    " all of them, from the first to the last."
)
DASHED = (5.0, 3.0)
DOTTED = (1.6, 2.4)
"""Lengths of dash and gap in widths of the path."""
WHAT_TOUCHES = (
    "A path is thick where it is the first contact of all teeth, thin and dashed where another tooth pair or"
    " an edge touches earlier; {edges} are where edges touch instead. Ratios: contact ratio of one tooth pair"
    " by Eq.\u00a016, and running, of all teeth without load."
)


@dataclass(frozen=True, eq=False)
class Trace:
    """A path on a flank: `points` (n, 3) in the member's own frame, entering first, of which the `first`
    (n,) are first contacts, None for all; the others are drawn thin. A `bare` one has no ends marked."""

    points: FloatArray
    colour: str = theme.PATH
    dashes: tuple[float, ...] = SOLID
    width: float = 1.0
    lift: float = 0.0
    first: Mask | None = None
    bare: bool = False


def surface(points: FloatArray, normals: FloatArray, view: FlankView, colour: str) -> Surface:
    """Make a grid of points and normals (nl, nz, 3) of a flank, own frame, mm, a lit surface in the frame of
    the picture."""
    faces = grid_faces(points, normals)[:, :: 1 if view.outside else -1]
    placed, turned = view.place(points).reshape(-1, 3), view.turn(normals).reshape(-1, 3)
    return Surface(placed, faces, turned, colour, edges=True)


def dashed(points: FloatArray, pattern: Sequence[float]) -> Iterable[FloatArray]:
    """Give pieces of a polyline (n, 3): dash, gap, dash, ... of the lengths in `pattern`, mm; the whole line
    if that is empty."""
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    if not pattern or along[-1] <= pattern[0]:
        yield points
        return
    for start in np.arange(0.0, along[-1], sum(pattern)):
        end = min(start + pattern[0], along[-1])
        inside = along[(along > start) & (along < end)]
        at = np.concatenate(([start], inside, [end]))
        yield np.stack([np.interp(at, along, column) for column in points.T], axis=-1)


def dashed_circle(points: FloatArray, radius: float) -> Iterable[FloatArray]:
    """Give the dashes of a closed line (n, 3) drawn with tubes of a `radius`, mm."""
    return dashed(points, [length * 2.0 * radius for length in DASHED])


def trace_items(trace: Trace, view: FlankView, radius: float) -> list[Item]:
    """Make a tube, a ball where the path enters, and an arrow head where it leaves; they stand towards the
    viewer, so that none of them is buried in the flank."""
    if len(trace.points) < 2 and not trace.bare:
        return []
    radius *= trace.width
    points = view.place(trace.points) + np.array([0.0, 0.0, (1.0 + trace.lift) * radius])
    if trace.bare:
        return [Tube(apart(points, radius), trace.colour, radius)]
    first = np.ones(len(points), dtype=bool) if trace.first is None else trace.first
    left = np.linalg.norm(points - points[-1], axis=1)
    enters, leaves = (1.0 if all(end) else SMALL for end in (first[:1], first[left < HEAD * radius]))
    head = HEAD * leaves * radius
    neck = int(np.argmax(left < 0.9 * head))
    vector = points[-1] - points[max(neck - 1, 0)]
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return [Tube(points[:1], trace.colour, 1.8 * radius)]
    body = points[: max(neck, 1) + 1] if left[0] > head else points
    items: list[Item] = []
    cuts = np.flatnonzero(np.diff(first[: len(body)])) + 1
    for start, end in pairwise((0, *cuts.tolist(), len(body))):
        thick = radius if first[start] else THIN * radius
        pattern = [length * 2.0 * thick for length in trace.dashes or (SOLID if first[start] else DASHED)]
        items += [Tube(piece, trace.colour, thick) for piece in dashed(body[start : end + 1], pattern)]
    items.append(Tube(points[:1], trace.colour, 1.8 * enters * radius))
    arrow = vector * min(head, float(left[0]) or head) / size
    items.append(Arrow(points[-1] - arrow, arrow, trace.colour, head / 7.0))
    return items


def apart(points: FloatArray, least: float) -> FloatArray:
    """Leave out points (n, 3) of a line nearer than `least`, mm, to the one before, but not the last one: a
    tube that turns back within its own width sticks out."""
    kept = [0]
    for number in range(1, len(points)):
        if np.linalg.norm(points[number] - points[kept[-1]]) >= least:
            kept.append(number)
    kept = kept[:-1] if 0 < kept[-1] < len(points) - 1 else kept
    return points[list(dict.fromkeys((*kept, len(points) - 1)))]


def edge_traces(path: SolvedPath, member: int, look: Trace | None = None) -> list[Trace]:
    """Make the lines on pinion (0) or gear (1) along which edges touch first; as wide, high and coloured as
    `look`, if given."""
    look = look or Trace(path.points[member], EDGE, lift=1.5)
    return [replace(look, points=line, bare=True) for line in path.edge_lines(member)]


def lines_drawn(paths: Iterable[SolvedPath]) -> str:
    """Say in a caption what lines of contact are, where some are drawn."""
    return LINES_DRAWN if any(len(path.contact_lines(0)) for path in paths) else ""


@dataclass(frozen=True, eq=False)
class Panel:
    """A flank as drawn on a page: axes whose coordinates are the pixels of the `picture`, and its view."""

    axes: Axes
    picture: Picture
    view: FlankView

    @property
    def page(self) -> Page:
        """The page it is on."""
        return cast("Page", self.axes.figure)

    def place(self, points: FloatArray) -> FloatArray:
        """Give pixels (..., 2) in the axes of points (..., 3) of the member's own frame, mm."""
        return self.picture.project(self.view.place(points))


def draw_flank(
    page: Page,
    box: Box,
    design: Design,
    number: int,
    flank: str,
    view: FlankView | None,
    traces: Iterable[Trace],
    px_per_mm: float,
    limits: float | None = 0.0,
) -> Panel | None:
    """Draw a flank of pinion (0) or gear (1) into its box at a given scale, and name its `limits`, root and
    tip at a share of the way from mid-face to the heel, or none; a note, and None, where no flank is."""
    if view is None:
        theme.say(theme.overlay(page, box), "no flank: it ends short of its tip", 24)
        return None
    try:
        grid = sample_flank(design.members[number], flank, OUTLINE_PX / (px_per_mm * view.stretch))
    except ValueError:
        theme.say(theme.overlay(page, box), "no flank to draw: is it undercut?", 24)
        return None
    items: list[Item] = [surface(grid.points, grid.normals, view, theme.METALS[number])]
    items += path_items(page, traces, view, px_per_mm)
    return show_items(page, box, view, items, px_per_mm, limits)


def draw_lines(panel: Panel, path: SolvedPath, member: int) -> None:
    """Draw the lines of contact on pinion (0) or gear (1), if flanks touch along lines, over the picture: so
    thin a tube, all but upright, is drawn in steps."""
    for line in path.contact_lines(member):
        look: dict[str, Any] = {"color": theme.INK, "linewidth": LINE * 2.0 * LINE_POINTS}
        panel.axes.plot(*panel.place(line).T, solid_capstyle="butt", **look)


def path_items(page: Page, traces: Iterable[Trace], view: FlankView, px_per_mm: float) -> list[Item]:
    """Make the paths on a flank, as wide on the page as everywhere."""
    radius = LINE_POINTS * page.dpi / 72.0 / px_per_mm
    return [item for trace in traces for item in trace_items(trace, view, radius)]


def camera_of(view: FlankView, half_height: float) -> Camera:
    """Look square on to a flank, the flank in the middle of the picture; half of its height in mm."""
    return Camera(INTO_PAGE, UP, np.append(view.bounds.mean(axis=0), 0.0), half_height)


def show_items(
    page: Page, box: Box, view: FlankView, items: Sequence[Item], px_per_mm: float, limits: float | None = 0.0
) -> Panel:
    """Draw what stands in the frame of a flank's picture into a box, the flank in its middle, and write root,
    tip, toe and heel around it unless `limits` is None."""
    picture = render(Scene(items, camera_of(view, 0.5 * box.height / px_per_mm)), box.size)
    axes = theme.show(page, box, picture)
    if limits is None:
        return Panel(axes, picture, view)
    root, middle, tip = view.frame
    way = 1.0 if tip[1, 0] > root[1, 0] else -1.0
    aligned = ("right", "left")[:: int(way)]
    for text, place, offset, ha, va, rotation in (
        ("root", root[1] + limits * (root[2] - root[1]), (-10 * way, 0), aligned[0], "center", 90),
        ("tip", tip[1] + limits * (tip[2] - tip[1]), (10 * way, 0), aligned[1], "center", 90),
        ("heel", middle[2], (0, 5), "center", "bottom", 0),
        ("toe", middle[0], (0, -5), "center", "top", 0),
    ):
        style = {"fontsize": theme.SMALL, "color": theme.GREY, "ha": ha, "va": va, "rotation": rotation}
        annotate.text(axes, picture.project(place), text, offset, **style)
    return Panel(axes, picture, view)


@dataclass(frozen=True, eq=False)
class Cell:
    """Where a flank stands among others: in the `row` of pinions (0) or gears (1) and a `column`, its box,
    view and scale, where its `limits` are named if they are, as `draw_flank` takes it, and the place (2,) of
    words under it, shares of the page, that are at most `width` pixels wide."""

    row: int
    column: int
    box: Box
    view: FlankView | None
    px_per_mm: float
    limits: float | None
    under: tuple[float, float]
    width: float

    def say(self, page: Page, words: str) -> None:
        """Write words under the flank."""
        style: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": theme.SMALL, "linespacing": 1.3}
        theme.fill(page.text(*self.under, "", **style), words, self.width)


def flanks_tall(layout: theme.Layout, count: int, text: Texts, stretch: float = STRETCH) -> float:
    """Give the inches in print that `flank_rows` of so many columns take."""
    width = CELLS.width(layout, count)
    words = HEADING + sum(text) + 4.0 * LABEL
    flank = min(3.0 * width / stretch, 3.6)
    return CELLS.tall(layout, count, words + 2.0 * flank)


def texts(layout: theme.Layout, count: int, text: Texts) -> Texts:
    """Give the inches of words under flanks, which break where a column is narrow, `text` where it is not."""
    width = CELLS.width(layout, count)
    more = 1.0 if width > 2.8 else 1.35 if width > 2.2 else 1.8
    return more * text[0], more * text[1]


def flank_rows(
    page: Page,
    columns: Sequence[tuple[str, Design, str]],
    low: float,
    high: float,
    text: Texts,
    draw: Callable[[Cell], Picture | None],
    outside: bool = False,
    stretch: float = STRETCH,
    share: float = FLANK_SHARE,
) -> dict[str, Picture]:
    """Draw a row of pinion flanks over a row of gear flanks, all to one scale, between two heights (shares of
    the page), by calling `draw` for each, in the paper's view or from `outside`. `columns` are headings,
    designs and flanks; `text` inches are left for words under a pinion's and a gear's flank, and the widest
    takes a `share` of a column's width. Where a page is
    too narrow, further columns follow under the first. In a row the first flank of each side names its
    limits. The pictures by member and column."""
    seen = (flank_views(design, flank, stretch, outside) for _, design, flank in columns)
    views = list(zip(*seen, strict=True))
    spans = np.stack([greatest_span(row) for row in views])
    beside = CELLS.columns(page.layout, len(columns))
    under = np.array([theme.inches(page, length) for length in text])
    page_width, page_height = page.canvas.get_width_height()
    starts, block = theme.rows(low, high, -(-len(columns) // beside))
    width = (RIGHT - LEFT) / beside
    around = under + theme.inches(page, 2.0 * LABEL)
    room = (block - theme.inches(page, HEADING) - around.sum()) * page_height
    px_per_mm = float(min(room / spans[:, 1].sum(), share * width * page_width / spans[:, 0].max()))
    spare = 0.5 * (room - px_per_mm * float(spans[:, 1].sum())) / page_height
    scale_bars(page, px_per_mm, stretch, looks_of(chain(*views)))
    heights = around + spare + px_per_mm * spans[:, 1] / page_height
    pictures: dict[str, Picture] = {}
    for column, (heading, _, _) in enumerate(columns):
        group, place = divmod(column, beside)
        top = starts[group] + block - theme.inches(page, HEADING)
        x = LEFT + place * width
        name = page.text(x + 0.5 * width, top + theme.inches(page, 0.3), "", fontsize=theme.LABEL)
        name.set(ha="center", va="top" if page.layout.height else "bottom")
        theme.fill(name, heading, 0.9 * width * page_width)
        for row, (member, bottom) in enumerate(zip(MEMBERS, top - np.cumsum(heights), strict=True)):
            y, height = float(bottom + under[row]), float(heights[row] - under[row])
            if place == 0:
                style: dict[str, Any] = {"rotation": 90, "va": "center", "fontsize": theme.HEADING}
                page.text(0.012, bottom + 0.5 * (heights[row] + under[row]), member.capitalize(), **style)
            box = theme.place(page, x + 0.01 * width, y, 0.98 * width, height)
            same = range(group * beside, column)
            told = any(columns[k][2] == columns[column][2] and views[row][k] is not None for k in same)
            under_it = (x + 0.5 * width, y), 0.97 * width * page_width
            picture = draw(
                Cell(row, column, box, views[row][column], px_per_mm, None if told else 0.0, *under_it)
            )
            if picture is not None:
                pictures[f"{member}-{column}"] = picture
    return pictures


def shared_scale(
    page: Page, views: Sequence[Sequence[FlankView | None]], width: float, height: float
) -> float:
    """Give the pixels a mm at which every flank, with words over and under it, has room in a box of that
    width and height, shares of the page, and draw the scale."""
    room = theme.place(page, 0.0, 0.0, width, height - theme.inches(page, 2.0 * LABEL))
    px_per_mm = float(min(room.size / greatest_span(chain(*views))))
    stretch = next((view.stretch for view in chain(*views) if view), STRETCH)
    scale_bars(page, px_per_mm, stretch, looks_of(chain(*views)))
    return px_per_mm


def how_drawn(flank: str, stretch: float, outside: bool = False) -> str:
    """Say in a caption how flanks are drawn: "right", "left" or "right and left" ones; as the paper does, or
    all from `outside`."""
    way = "from outside" if outside or flank == "left" else "through the tooth, from its metal side"
    return (
        f"Flanks are seen square on {way}, {stretch:g} times as large across as along; the sketch shows the"
        " tooth from its toe. A path enters at the ball and leaves at the arrow head. "
    )


def ratios(path: SolvedPath) -> tuple[str, str]:
    """Give both contact ratios of a path, that of Eq. 16 and that in operation."""
    return both_ratios(path.ratio, path.touching.ratio if path.touching else float("nan"))
