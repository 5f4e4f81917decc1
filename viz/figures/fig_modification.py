"""Fig. 6: the pinion's flank without parabola, and with one of either sign."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.flank import flank_patch, root_parameter, tip_parameter, trace_parameter
from beveloid_geom.inputs import Design, FloatArray, Member
from beveloid_geom.sampling import grid_faces, sample_flank

from .. import theme
from ..recipe import Drawing, Recipe, Table
from ..scene import Item, Picture, Scene, Surface, Tube, fit_camera, render
from ..theme import Page, Size

FLANK = "right"
COEFFICIENTS = (0.01, 0.0, -0.01)
"""1/mm, in the order of the flanks from outside in."""
COLOURS = (theme.SKY, "#c9cdd2", theme.ORANGE)
LINES = (theme.BLUE, theme.BLACK, theme.RED)
NAMES = ("concave", "involute", "convex")
COVERED = (0.34, 0.67, 1.0)
"""Share of the face that each flank covers, from the toe."""
POINTS = 121
LOOK = (-0.5, 0.3, 0.8)
"""Where the viewer stands: along the outward normal (away from the metal), up, to the toe."""
NOTE = (
    "Left: the three flanks overlaid in true proportions, seen from outside and from the toe; the outer ones are cut off"
    " so that those under them show. Right: section at mid-face, square to the pinion's axis; deviations are distances"
    " along the normal of the involute flank, positive where metal is left. A tool with a positive coefficient leaves metal"
    " at root and tip, and the flank is concave; a negative one makes it convex."
)


@dataclass(frozen=True, eq=False)
class Section:
    """A flank at mid-face: flank parameter `l`, radius, distance from the involute flank along
    its normal (n,), mm; `across` and `up` (n,), mm, the profile with the involute one's middle
    on the vertical through the axis."""

    l: FloatArray
    radius: FloatArray
    deviation: FloatArray
    across: FloatArray
    up: FloatArray


@dataclass(frozen=True, eq=False)
class ModificationFigure:
    """The pinion with each coefficient that its flank allows, and the sections."""

    members: dict[float, Member]
    sections: dict[float, Section]


def compute(design: Design) -> ModificationFigure:
    """Sections at mid-face; a coefficient so strong that the flank ends short of its tip is left out."""
    members = {a: design.with_parabola(a).pinion for a in COEFFICIENTS}
    half = 0.5 * float(design.pinion.face_width)
    z = np.array([-half, 0.0, half])
    members = {a: m for a, m in members.items() if np.isfinite(tip_parameter(m, FLANK, z)).all()}
    if 0.0 not in members:
        return ModificationFigure({}, {})
    return ModificationFigure(members, {a: _section(member, members[0.0]) for a, member in members.items()})


def _profile(member: Member, reach: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """l, radius, polar angle and normal (n, 3) at mid-face, `reach` times the depth beyond its ends."""
    low, high = float(root_parameter(member)), float(tip_parameter(member, FLANK, 0.0))
    l = np.linspace(low - reach * (high - low), high + reach * (high - low), POINTS)
    patch = flank_patch(member, FLANK, l, trace_parameter(member, FLANK, l, 0.0))
    x, y = patch.point[:, 0], patch.point[:, 1]
    return l, np.hypot(x, y), np.arctan2(y, x), patch.normal


def _section(member: Member, involute: Member) -> Section:
    l, radius, angle, _ = _profile(member)
    _, base_radius, base_angle, base_normal = _profile(involute, reach=0.1)
    order = np.argsort(base_radius)
    there = np.interp(radius, base_radius[order], base_angle[order])
    normal = np.stack([np.interp(radius, base_radius[order], part[order]) for part in base_normal.T[:2]])
    deviation = radius * (angle - there) * (np.cos(there) * normal[1] - np.sin(there) * normal[0])
    turned = angle - base_angle[POINTS // 2]
    return Section(l, radius, deviation, radius * np.sin(turned), radius * np.cos(turned))


def draw(data: ModificationFigure, size: Size) -> Drawing:
    """Three flanks in one scene; the section and its deviations beside it."""
    page = theme.new_page(
        size,
        "Fig. 6   A positive parabola coefficient makes the flank concave, a negative one convex",
        f"{FLANK.capitalize()} flank of the pinion for $a$ = 0 and \u00b10.01 mm$^{{\u22121}}$",
    )
    low, high = theme.caption(page, NOTE), theme.top(page) - theme.inches(page, 0.1)
    if not data.members:
        page.text(0.5, 0.5, "the pinion's flank ends short of its tip: there is nothing to draw", ha="center")
        return Drawing(page, {})
    picture = _overlay(page, data, low, high)
    gap, left, width = theme.inches(page, 0.95), 0.69, 0.285
    height = (high - low - 1.6 * gap) / 2.0
    _draw_section(page.add_axes((left, low + height + 1.55 * gap, width, height)), data)
    _draw_deviation(page.add_axes((left, low + 0.6 * gap, width, height)), data)
    return Drawing(page, {"overlay": picture})


def _overlay(page: Page, data: ModificationFigure, low: float, high: float) -> Picture:
    box = theme.place(page, 0.015, low, 0.615, high - low)
    first = sample_flank(data.members[0.0], FLANK, 0.2)
    middle = first.normals[first.normals.shape[0] // 2, first.normals.shape[1] // 2]
    radial = first.points.mean(axis=(0, 1)) * (1.0, 1.0, 0.0)
    radial /= np.linalg.norm(radial)
    stand = LOOK[0] * -middle + LOOK[1] * radial + LOOK[2] * np.array([0.0, 0.0, -1.0])
    camera = fit_camera(first.points, -stand, radial, box.size, margin=0.1)
    px_per_mm = box.height / (2.0 * camera.half_height)
    items, labels = _layers(data, 0.25 / px_per_mm, 1.6 * page.dpi / 72.0 / px_per_mm)
    picture = render(Scene(items, camera), box.size)
    axes = theme.show(page, box, picture)
    _label_overlay(axes, picture, first.points, labels)
    length = theme.round_length(150.0 / 1600.0 * page.canvas.get_width_height()[0] / px_per_mm)
    theme.scale_bar(axes, 0.06 * box.width, 0.93 * box.height, px_per_mm, length)
    return picture


def _layers(data: ModificationFigure, tolerance: float, radius: float) -> tuple[list[Item], dict[float, FloatArray]]:
    """Surfaces and their edges, and where on each a label points."""
    items: list[Item] = []
    labels = {}
    begin = 0.0
    for a, colour, line, share in zip(COEFFICIENTS, COLOURS, LINES, COVERED, strict=True):
        if a not in data.members:
            continue
        grid = sample_flank(data.members[a], FLANK, tolerance)
        z = grid.z
        last = int(np.argmin(np.abs(z - (z[0] + share * (z[-1] - z[0])))))
        points, normals = grid.points[:, : last + 1], grid.normals[:, : last + 1]
        faces = grid_faces(points, normals)
        items.append(Surface(points.reshape(-1, 3), faces, normals.reshape(-1, 3), colour))
        for edge in (points[:, 0], points[:, -1], points[0], points[-1]):
            items.append(Tube(edge, line, radius))
        at = int(np.argmin(np.abs(z - (z[0] + 0.5 * (begin + share) * (z[-1] - z[0])))))
        labels[a] = grid.points[-1, at]
        begin = share
    return items, labels


def coefficient_name(a: float) -> str:
    """Coefficient and shape."""
    value = theme.signed(a, 2) if a else "0"
    return f"$a$ = {value} mm$^{{\u22121}}$, {NAMES[COEFFICIENTS.index(a)]}"


def _label_overlay(axes: Axes, picture: Picture, points: FloatArray, labels: dict[float, FloatArray]) -> None:
    style: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": False}
    for a, point in labels.items():
        axes.annotate(
            coefficient_name(a),
            tuple(picture.project(point)),
            xytext=(0, 26),
            color=LINES[COEFFICIENTS.index(a)],
            fontsize=theme.LABEL,
            ha="left",
            arrowprops={"arrowstyle": "-", "color": LINES[COEFFICIENTS.index(a)], "linewidth": 1.0},
            **style,
        )
    rows, columns = points.shape[0] // 2, points.shape[1] // 2
    for text, point, offset in (
        ("toe", points[rows, 0], (-34, 0)),
        ("heel", points[rows, -1], (30, 0)),
        ("root", points[0, columns], (0, -20)),
        ("tip", points[-1, columns], (0, 60)),
    ):
        axes.annotate(
            text, tuple(picture.project(point)), xytext=offset, ha="center", va="center", color=theme.GREY, **style
        )


def _draw_section(axes: Axes, data: ModificationFigure) -> None:
    """The profiles in true proportions."""
    involute = data.sections[0.0]
    metal = -np.sign(involute.across[-1] - involute.across[0]) or 1.0
    for a, section in data.sections.items():
        colour = LINES[COEFFICIENTS.index(a)]
        axes.plot(section.across, section.up, color=colour, linewidth=2.2, label=coefficient_name(a))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("Section at mid-face, true proportions", loc="left")
    axes.set_xlabel("across the tooth (mm)")
    axes.set_ylabel("from the axis (mm)")
    axes.margins(0.05)
    axes.grid(True)
    del metal


def _draw_deviation(axes: Axes, data: ModificationFigure) -> None:
    """Distance from the involute flank against the radius."""
    for a, section in data.sections.items():
        colour = LINES[COEFFICIENTS.index(a)]
        axes.fill_betweenx(section.radius, 0.0, section.deviation, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(section.deviation, section.radius, color=colour, linewidth=2.5)
    axes.set_title("Deviation from the involute flank", loc="left")
    axes.set_xlabel("along the normal (mm)")
    axes.set_ylabel("radius (mm)")
    axes.margins(0.08)
    axes.grid(True)


def rows(data: ModificationFigure) -> Table:
    """The sections."""
    header = ("a_per_mm", "l_mm", "r_mm", "deviation_mm", "across_mm", "up_mm")

    def body() -> Iterator[list[object]]:
        for a, section in data.sections.items():
            columns = (section.l, section.radius, section.deviation, section.across, section.up)
            for values in np.stack(columns, axis=-1).tolist():
                yield [a, *values]

    return header, body()


RECIPES = {"fig-06": Recipe(compute, draw, rows)}
