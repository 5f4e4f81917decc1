"""Panels that show one flank square on, with paths of contact on it.

A flank is laid flat into the plane of the picture: x towards the tip, y towards the heel, and
the rest towards the viewer. Nothing is mirrored: on a right flank, with the heel on top and
the tip on the right, one looks at it through the tooth, from its metal side.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Member
from beveloid_geom.gear.flank import flank_patch, root_parameter, tip_parameter, trace_parameter
from beveloid_geom.shapes.sampling import FlankGrid, grid_faces, sample_flank

from ..stage import theme
from ..stage.scene import Arrow, Camera, Item, Picture, Scene, Surface, Tube, render
from ..stage.theme import Box, Page

LINE_POINTS = 2.6
"""Half the width of a path, in points of the page."""
OUTLINE_PX = 0.03
"""Pixels by which triangles may miss the flank: less than half of one, since root and tip curve
more within the flank, as an outline, than the flank does out of itself."""
INTO_PAGE, UP = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
SOLID: tuple[float, ...] = ()
DASHED = (5.0, 3.0)
DOTTED = (1.6, 2.4)
"""Lengths of dash and gap in widths of the path."""


@dataclass(frozen=True, eq=False)
class FlankView:
    """Axes of the picture (rows: to the tip, to the heel, to the viewer) in a member's own
    frame, the point in the middle, and how much wider than long the flank is drawn.

    `bounds` (2, 2): least and greatest x and y, mm, stretched; `frame` (3, 3, 3): points at
    root, mid-depth, tip by toe, mid-face, heel there."""

    axes: FloatArray
    middle: FloatArray
    stretch: float
    outside: bool
    bounds: FloatArray
    frame: FloatArray

    @property
    def span(self) -> FloatArray:
        """Width and height of the flank as drawn, mm, stretched."""
        return np.asarray(self.bounds[1] - self.bounds[0])

    def place(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) of the own frame in the frame of the picture, mm."""
        return np.asarray((points - self.middle) @ self.axes.T * (self.stretch, 1.0, 1.0))

    def turn(self, normals: FloatArray) -> FloatArray:
        """Outward normals (..., 3) as seen from the viewer's side."""
        return np.asarray(normals @ self.axes.T * (1.0 if self.outside else -1.0))


@dataclass(frozen=True, eq=False)
class Trace:
    """A path on a flank: `points` (n, 3) in the member's own frame, entering first."""

    points: FloatArray
    colour: str = theme.PATH
    dashes: tuple[float, ...] = SOLID
    width: float = 1.0
    lift: float = 0.0


def flank_view(member: Member, flank: str, stretch: float = 1.0) -> FlankView | None:
    """Square on to the middle of the active flank; None if that does not reach its tip."""
    half = 0.5 * float(member.face_width)
    z = np.array([-half, 0.0, half])
    tip = tip_parameter(member, flank, z)
    if not np.isfinite(tip).all():
        return None
    share = np.linspace(0.0, 1.0, 9)[:, None]
    l = root_parameter(member) + share * (tip - root_parameter(member))
    patch = flank_patch(member, flank, l, trace_parameter(member, flank, l, z))
    normal = patch.normal[4, 1]
    up = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    outside = bool(right @ (patch.point[-1, 1] - patch.point[0, 1]) > 0.0)
    side = 1.0 if outside else -1.0
    axes = np.stack((side * right, up, side * normal))
    view = FlankView(axes, patch.point[4, 1], stretch, outside, np.zeros((2, 2)), patch.point[::4])
    seen = view.place(patch.point)
    bounds = np.stack((seen.min(axis=(0, 1)), seen.max(axis=(0, 1))))[:, :2]
    return replace(view, bounds=bounds, frame=seen[::4])


def surface(grid: FlankGrid, view: FlankView, colour: str) -> Surface:
    """The flank as a lit surface in the frame of the picture."""
    faces = grid_faces(grid.points, grid.normals)[:, :: 1 if view.outside else -1]
    points, normals = view.place(grid.points), view.turn(grid.normals)
    return Surface(points.reshape(-1, 3), faces, normals.reshape(-1, 3), colour, edges=True)


def dashed(points: FloatArray, pattern: Sequence[float]) -> Iterable[FloatArray]:
    """Pieces of a polyline (n, 3): dash, gap, dash, ... of the lengths in `pattern`, mm; the
    whole line if that is empty."""
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    if not pattern or along[-1] <= pattern[0]:
        yield points
        return
    for start in np.arange(0.0, along[-1], sum(pattern)):
        end = min(start + pattern[0], along[-1])
        inside = along[(along > start) & (along < end)]
        at = np.concatenate(([start], inside, [end]))
        yield np.stack([np.interp(at, along, column) for column in points.T], axis=-1)


def trace_items(trace: Trace, view: FlankView, radius: float) -> list[Item]:
    """Tube, a ball where the path enters, and an arrow head where it leaves; they stand
    towards the viewer, so that none of them is buried in the flank."""
    if len(trace.points) < 2:
        return []
    radius *= trace.width
    points = view.place(trace.points) + np.array([0.0, 0.0, (1.0 + trace.lift) * radius])
    head = 8.0 * radius
    left = np.linalg.norm(points - points[-1], axis=1)
    neck = int(np.argmax(left < 0.9 * head))
    vector = points[-1] - points[max(neck - 1, 0)]
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return [Tube(points[:1], trace.colour, 1.8 * radius)]
    body = points[: max(neck, 1) + 1] if left[0] > head else points
    pattern = [length * 2.0 * radius for length in trace.dashes]
    items: list[Item] = [Tube(piece, trace.colour, radius) for piece in dashed(body, pattern)]
    items.append(Tube(points[:1], trace.colour, 1.8 * radius))
    arrow = vector * min(head, float(left[0]) or head) / size
    items.append(Arrow(points[-1] - arrow, arrow, trace.colour, head / 7.0))
    return items


def draw_flank(
    page: Page,
    box: Box,
    member: Member,
    flank: str,
    view: FlankView | None,
    traces: Iterable[Trace],
    px_per_mm: float,
    colour: str,
) -> tuple[Axes, Picture] | None:
    """Draw one flank into its box at a given scale; a note, and None, where there is no flank."""
    if view is None:
        _write_instead(page, box, "no flank: it ends short of its tip")
        return None
    try:
        grid = sample_flank(member, flank, OUTLINE_PX / (px_per_mm * view.stretch))
    except ValueError:
        _write_instead(page, box, "no flank to draw: is it undercut?")
        return None
    items: list[Item] = [surface(grid, view, colour), *path_items(page, traces, view, px_per_mm)]
    return show_items(page, box, view, items, px_per_mm)


def path_items(page: Page, traces: Iterable[Trace], view: FlankView, px_per_mm: float) -> list[Item]:
    """The paths on a flank, as wide on the page as everywhere."""
    radius = LINE_POINTS * page.dpi / 72.0 / px_per_mm
    return [item for trace in traces for item in trace_items(trace, view, radius)]


def camera_of(view: FlankView, half_height: float) -> Camera:
    """Square on to a flank, the flank in the middle of the picture; half of its height in mm."""
    return Camera(INTO_PAGE, UP, np.append(view.bounds.mean(axis=0), 0.0), half_height)


def show_items(
    page: Page, box: Box, view: FlankView, items: Sequence[Item], px_per_mm: float
) -> tuple[Axes, Picture]:
    """Draw what stands in the frame of a flank's picture into a box, the flank in its middle."""
    picture = render(Scene(items, camera_of(view, 0.5 * box.height / px_per_mm)), box.size)
    return theme.show(page, box, picture), picture


def _write_instead(page: Page, box: Box, text: str) -> None:
    axes = theme.overlay(page, box)
    axes.text(0.5, 0.5, textwrap.fill(text, 24), transform=axes.transAxes, ha="center", va="center")


def label_limits(axes: Axes, picture: Picture, view: FlankView, share: float = 0.0) -> None:
    """Write root, tip, toe and heel around a flank; root and tip at a share of the way from
    mid-face to the heel."""
    root, middle, tip = view.frame
    sides = (
        ("root", root[1] + share * (root[2] - root[1]), (-10, 0), "right", "center", 90),
        ("tip", tip[1] + share * (tip[2] - tip[1]), (10, 0), "left", "center", 90),
        ("heel", middle[2], (0, 5), "center", "bottom", 0),
        ("toe", middle[0], (0, -5), "center", "top", 0),
    )
    for text, place, offset, ha, va, rotation in sides:
        axes.annotate(
            text,
            tuple(picture.project(place)),
            xytext=offset,
            textcoords="offset points",
            ha=ha,
            va=va,
            rotation=rotation,
            fontsize=theme.SMALL,
            color=theme.GREY,
            annotation_clip=False,
        )


def how_drawn(flank: str, stretch: float) -> str:
    """The part of a caption that says how flanks are drawn."""
    side = "through the tooth, from its metal side" if flank == "right" else "from outside"
    stretched = f"{stretch:g} times as large across as along" if stretch != 1.0 else "in true proportions"
    return (
        f"Flanks are seen square on {side}, so that root is left, tip right and heel on top"
        f" without mirroring, and drawn {stretched}. A path enters at the ball and leaves at the arrow head. "
    )


def scale_bars(page: Page, px_per_mm: float, stretch: float) -> None:
    """Scale along and across the flanks, at the lower right of the page."""
    width, height = page.canvas.get_width_height()
    high, inch = theme.inches(page, 1.0), theme.inches(page, 1.0) * height / width
    length = theme.round_length(1.3 * inch * width / (px_per_mm * stretch))
    across, along = length * px_per_mm * stretch, length * px_per_mm
    box = theme.place(page, 1.0 - 1.75 * inch, theme.inches(page, 0.15), 1.4 * inch, high)
    axes = theme.overlay(page, box)
    x, y = 0.0, 0.68 * box.height
    axes.plot([x, x, x + across], [y - along, y, y], color=theme.INK, linewidth=2.5, clip_on=False)
    style: dict[str, Any] = {"fontsize": theme.SMALL, "annotation_clip": False, "textcoords": "offset points"}
    ways = ("", "") if stretch == 1.0 else (" along", " across")
    texts = [f"{length:g} mm{way}" for way in ways]
    axes.annotate(texts[0], (x, y - 0.5 * along), xytext=(-6, 0), ha="right", va="center", **style)
    axes.annotate(texts[1], (x + 0.5 * across, y), xytext=(0, -5), ha="center", va="top", **style)


def greatest_span(views: Iterable[FlankView | None]) -> FloatArray:
    """Greatest width and height (mm, as drawn) of flanks; 1 mm if there are none."""
    spans = [view.span for view in views if view is not None]
    return np.max(spans, axis=0) if spans else np.ones(2)


def chord_angle(points: FloatArray, view: FlankView) -> float:
    """Angle (deg) between the chord of a path and the axial direction, in the flank's plane;
    positive if the path runs to the heel on its way to the tip, else negative."""
    across, along, _ = (points[-1] - points[0]) @ view.axes.T
    return float(np.degrees(np.arctan2(np.abs(across), np.abs(along))) * np.copysign(1.0, across * along))


def path_length(points: FloatArray) -> float:
    """Length of a polyline (n, 3), mm."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
