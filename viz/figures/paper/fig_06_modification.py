"""Fig. 6: flank of the pinion without parabola, and with a positive and a negative coefficient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, Member
from beveloid_geom.arrays import FloatArray, flank_sign
from beveloid_geom.design.ends import end_names
from beveloid_geom.gear.flank import FlankPatch, flank_patch
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.gear.undercut import regular_start

from ...components import paths_table
from ...components.annotate import Overlay
from ...components.figure_steps import Drawing, Recipe, Table, rows_of_cases
from ...rendering import theme
from ...rendering.layout import PanelRows
from ...rendering.scene import Item, Picture, Tube, fit_camera, grid_surface


class FlankStyle(NamedTuple):
    """Style of a flank: name, colours of metal and lines, and the part of the face on which it is drawn, in
    half face widths towards the viewer."""

    name: str
    colour: str
    line: str
    ends: tuple[float, float]


LOOKS = {
    -1: FlankStyle("convex", "#f0b98a", theme.VERMILLION, (1.0, 0.36)),
    0: FlankStyle("involute", "#c4ccd4", theme.INK, (0.36, -0.3)),
    1: FlankStyle("concave", "#8fc3e8", theme.BLUE, (-0.3, -1.0)),
}
"""Styles by sign of the coefficient, in the order of the flanks from the metal outwards."""
COEFFICIENT_PER_MM = 0.01
"""Size of the coefficients at the module of Table 1."""


@dataclass(frozen=True, eq=False)
class FlankSection:
    """Flank at mid-face.

    `l`, `radius` and `deviation` from the involute flank (n,), mm; `across` and `up` (n,), mm, with the
    middle of the involute on the vertical through the axis. `base` (2, n): involute at equal radius, mm;
    `per_mm` (2, n): displacement in the section, mm, for 1 mm of deviation along the normal."""

    l: FloatArray
    radius: FloatArray
    deviation: FloatArray
    across: FloatArray
    up: FloatArray
    base: FloatArray
    per_mm: FloatArray

    def magnified(self, factor: float) -> FloatArray:
        """Return `across` and `up` (2, n), mm, of the profile with its deviation times a factor."""
        return np.asarray(self.base + factor * self.deviation * self.per_mm)


@dataclass(frozen=True, eq=False)
class ModificationFigure:
    """The pinion with the coefficients +-`coefficient` (1/mm) and 0 that its flank allows, its sections, and
    whether a flank is undercut, by sign of the coefficient."""

    flank: str
    coefficient: float
    members: dict[int, Member]
    sections: dict[int, FlankSection]
    undercut: dict[int, bool]

    @property
    def half(self) -> float:
        """Distance of the end of the face that is nearer to the viewer from mid-face along z, mm.

        Right flanks are seen from +z and left flanks from -z, so that all face to the left, to the light."""
        return float(0.5 * flank_sign(self.flank) * float(self.members[0].face_width))

    @property
    def ends(self) -> tuple[str, str]:
        """Printed names of the far and the near end of the face."""
        first, last = end_names(self.members[0]) if self.members else ("", "")
        return (first, last) if self.flank == "right" else (last, first)

    @property
    def factor(self) -> float:
        """Factor of the deviations in the section; 1 without deviations."""
        # Largest deviation drawn as a fraction of the height of the section; deviations have a
        # round factor.
        largest_deviation_fraction = 0.25
        sizes = [float(np.nanmax(np.abs(one.deviation))) for one in self.sections.values()]
        greatest = max(sizes, default=0.0)
        if greatest < 1e-6:
            return 1.0
        height = float(np.ptp(self.sections[0].radius))
        return theme.round_length(largest_deviation_fraction * height / greatest)


def compute(design: Design, flank: str = "right") -> ModificationFigure:
    """Compute the sections at mid-face, without coefficients for which the flank ends below its tip."""
    size = paths_table.two_digits(COEFFICIENT_PER_MM / paths_table.as_large(design))
    members = {sign: design.with_parabola(sign * size).pinion for sign in LOOKS}
    members = {sign: member for sign, member in members.items() if _reaches_tip(member, flank)}
    if 0 not in members:
        return ModificationFigure(flank, size, {}, {}, {})
    sections = {sign: _section(member, members[0], flank) for sign, member in members.items()}
    undercut = {
        sign: bool(sections[sign].l[0] > root_parameter(member, flank) + 1e-6)
        for sign, member in members.items()
    }
    return ModificationFigure(flank, size, members, sections, undercut)


def _reaches_tip(member: Member, flank: str) -> bool:
    half = 0.5 * float(member.face_width)
    return bool(np.isfinite(tip_parameter(member, flank, np.array([-half, 0.0, half]))).all())


def _patch(member: Member, flank: str, share: FloatArray, z: FloatArray) -> tuple[FloatArray, FlankPatch]:
    """Return l and points (fractions, z) between the start of the flank and its tip."""
    start = regular_start(member, flank, z)
    l = start + share[:, None] * (tip_parameter(member, flank, z) - start)
    return l, flank_patch(member, flank, l, z=z + 0.0 * l)


def _section(member: Member, involute: Member, flank: str) -> FlankSection:
    """Compute the profile at mid-face and its deviation from the involute; NaN inside the base circle."""
    points = 241
    share, middle = np.linspace(0.0, 1.0, points), np.zeros(1)
    l, patch = _patch(member, flank, share, middle)
    base_point, base_normal = _involute(involute, flank, points)
    x, y = patch.point[:, 0, 0], patch.point[:, 0, 1]
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    base_x, base_y = base_point
    base_radius, base_angle = np.hypot(base_x, base_y), np.arctan2(base_y, base_x)
    base_at_radius = np.interp(radius, base_radius, base_angle, left=np.nan)
    # r (theta . n) is the moment of the normal about the axis: constant along an involute.
    moment = base_x * base_normal[1] - base_y * base_normal[0]
    deviation = (angle - base_at_radius) * np.interp(radius, base_radius, moment)
    middle_angle = base_angle[-1 - points // 2]
    normal = np.stack([np.interp(radius, base_radius, values) for values in base_normal])
    # A displacement s in the section along the projection of the normal n is s |n_xy| along n.
    per_mm = normal / (normal**2).sum(axis=0)
    side = flank_sign(flank)
    across, up = _upright(radius, side * (angle - middle_angle))
    foot = _upright(radius, side * (base_at_radius - middle_angle))
    cos, sin = np.cos(middle_angle), np.sin(middle_angle)
    per_mm = np.array([[side * sin, -side * cos], [cos, sin]]) @ per_mm
    return FlankSection(l[:, 0], radius, deviation, across, up, foot, per_mm)


def _involute(member: Member, flank: str, points: int) -> tuple[FloatArray, FloatArray]:
    """Return points and normals (2, n) of the involute at mid-face, from its base circle beyond its tip."""
    share = np.concatenate([np.linspace(-1.0, -0.1, points, endpoint=False), np.linspace(-0.1, 1.1, points)])
    _, patch = _patch(member, flank, share, np.zeros(1))
    point, normal = patch.point[:, 0, :2].T, patch.normal[:, 0, :2].T
    start = int(np.hypot(*point).argmin())  # the involute turns back at its base circle
    return point[:, start:], normal[:, start:]


def _upright(radius: FloatArray, angle: FloatArray) -> FloatArray:
    """Return coordinates (2, n), across and up, from radius and angle to the vertical; tooth on the right."""
    return np.stack((-radius * np.sin(angle), radius * np.cos(angle)))


def draw(data: ModificationFigure, layout: theme.PageLayout) -> Drawing:
    """Draw three flanks in one picture, and the section with its deviations."""
    note = (
        "Flanks overlaid in true proportions, from outside and from the {end}. Section at mid-face,"
        " perpendicular to the axis: thin lines in true proportions, thick lines with {factor:g} times their"
        " deviation from the involute, which is measured at equal radius along the normal of the involute"
        " flank."
    )
    charts_height_in = 6.6  # on a narrow page
    undercut = " The {name} flank starts where the tool undercuts it."
    missing = " The {name} flank ends below the tip and is not drawn."
    remarks = [undercut.format(name=LOOKS[sign].name) for sign, short in data.undercut.items() if short]
    remarks += [missing.format(name=look.name) for sign, look in LOOKS.items() if sign not in data.members]
    page, low, high = theme.new_page(
        layout,
        "Fig. 6   A positive parabola coefficient makes the flank concave, a negative one convex",
        f"{data.flank.capitalize()} flank of the pinion for $a$ = 0 and \u00b1{data.coefficient:g}"
        " mm$^{\u22121}$",
        note.format(factor=data.factor, end=data.ends[1]) + "".join(remarks),
        above=0.3,
        tall=6.4 if layout.wide else 4.6 + charts_height_in,
    )
    if not data.members:
        page.text(0.5, 0.5, "the pinion's flank ends short of its tip: there is nothing to draw", ha="center")
        return Drawing(page, {})
    overlay, section, deviation = _places(page, low, high, charts_height_in)
    picture = _overlay(page, data, theme.place(page, *overlay))
    _draw_section(page.add_axes(section), data)
    _draw_deviation(page.add_axes(deviation), data)
    return Drawing(page, {"overlay": picture})


def _places(
    page: theme.Page, low: float, high: float, charts_height_in: float
) -> list[tuple[float, float, float, float]]:
    """Return the boxes (fractions of the page) of the flanks and of both charts next to or below them."""
    cells = PanelRows(left=0.85, right=0.25, across=0.85, down=1.0, most=2, least=2.5)
    gap = theme.inches(page, 0.95)
    if page.layout.wide:
        over, height = theme.inches(page, 0.3), (high - low - 1.6 * gap) / 2.0
        upper = low + height + 1.6 * gap
        flanks = 0.01, low, 0.625, high + over - low
        return [flanks, (0.69, upper, 0.285, height), (0.69, low + 0.6 * gap, 0.285, height)]
    top = low + theme.inches(page, charts_height_in)
    charts = cells.boxes(page.layout, 2, page.get_figheight(), low + 0.6 * gap, top - gap)
    return [(0.01, top, 0.98, high - top), *charts]


def _overlay(page: theme.Page, data: ModificationFigure, box: theme.PageBox) -> Picture:
    """Draw the flanks of all coefficients as steps along the face."""
    # Direction of the viewer: along the normal, to the tip, along the tooth.
    view_direction = (0.3, 0.12, 1.0)
    z = np.linspace(-data.half, data.half, 9)
    _, patch = _patch(data.members[0], data.flank, np.linspace(0.0, 1.0, 9), z)
    depth, length = patch.point[8, 4] - patch.point[0, 4], patch.point[4, 8] - patch.point[4, 0]
    parts = patch.normal[4, 4], depth, length
    shares = zip(view_direction, parts, strict=True)
    towards_viewer = sum(share * part / np.linalg.norm(part) for share, part in shares)
    camera = fit_camera(patch.point, -np.asarray(towards_viewer), depth, box.size, margin=0.11)
    mm_per_px = camera.mm_per_px(box.size)
    mm_per_point = mm_per_px * page.dpi / 72.0
    items, labels = _terraces(data, 0.25 * mm_per_px, 1.3 * mm_per_point, camera.axes[2])
    over = Overlay.drawn(page, box, items, camera)
    _label_overlay(over, patch.point, labels, data)
    bar = theme.round_length(120.0 * mm_per_point)
    theme.scale_bar(over.axes, 0.05 * box.width, 0.9 * box.height, over.picture.px_per_mm, bar)
    return over.picture


def _stations(member: Member, flank: str, tolerance: float) -> tuple[int, int]:
    """Return the numbers of cells across the flank and along a third of the face for a tolerance (mm)."""
    half = 0.5 * float(member.face_width)
    _, patch = _patch(member, flank, np.linspace(0.0, 1.0, 9), np.linspace(-half, half, 9))

    def sagitta(points: FloatArray) -> float:
        return float(np.linalg.norm(points[:-2] - 2.0 * points[1:-1] + points[2:], axis=-1).max()) / 8.0

    bent = np.array([sagitta(patch.point), sagitta(patch.point.swapaxes(0, 1))])
    across, along = np.ceil(np.array([8.0, 3.0]) * np.sqrt(bent / tolerance)).astype(int)
    return int(across) + 1, int(along) + 1


def _terraces(
    data: ModificationFigure, tolerance: float, radius: float, viewer: FloatArray
) -> tuple[list[Item], dict[int, FloatArray]]:
    """Return each flank on a third of the face with the steps between them, and its points at the tip (n, 3),
    from the viewer.

    `viewer` (3,) is the direction to the viewer. Flanks touch in the middle of their depth, so that their
    lines are moved towards the viewer, each by more than the one before; their place in the picture does not
    change."""
    half, flank = data.half, data.flank
    cells = np.array([_stations(member, flank, tolerance) for member in data.members.values()]).max(axis=0)
    share = np.linspace(0.0, 1.0, 1 + int(cells[0]))
    items: list[Item] = []
    labels: dict[int, FloatArray] = {}

    def lines(sign: int, *edges: FloatArray) -> None:
        """Add the lines (n, 3) of a flank."""
        lift = 2.0 * (1 + list(LOOKS).index(sign)) * radius * viewer
        items.extend(Tube(edge + lift, LOOKS[sign].line, radius) for edge in edges)

    below: int | None = None
    for sign, member in data.members.items():
        look = LOOKS[sign]
        z = half * np.linspace(*look.ends, 1 + int(cells[1]))
        patch = _patch(member, flank, share, z)[1]
        front = patch.point[:, 0]
        items.append(grid_surface(patch.point, patch.normal, look.colour))
        lines(sign, front, patch.point[0], patch.point[-1])
        if below is not None:
            under = _patch(data.members[below], flank, share, z[:1])[1].point[:, 0]
            items.append(grid_surface(np.stack((under, front)), None, look.line))
            lines(below, under)
        labels[sign] = patch.point[-1]
        below = sign
    involute = _patch(data.members[0], flank, share, np.array([half]))[1].point[:, 0]
    for sign, member in data.members.items():
        points = _patch(member, flank, share, np.array([half]))[1].point[:, 0]
        lines(sign, points)
        if sign:
            both = np.stack((points, involute))
            items.append(grid_surface(both, None, LOOKS[sign].colour, opacity=0.75))
    return items, labels


def coefficient_name(a: float, name: str) -> str:
    """Return the coefficient and the shape as text."""
    value = f"{a:+g}".replace("-", "\u2212") if a else "0"
    return f"$a$ = {value} mm$^{{\u22121}}$: {name}"


def _label_overlay(
    over: Overlay, points: FloatArray, labels: dict[int, FloatArray], data: ModificationFigure
) -> None:
    """Label the flanks at their points `labels` (n, 3), mm, along the tip, and the sides of the flank with
    points (9, 9, 3)."""
    axes, picture = over.axes, over.picture
    tips = [picture.project(points) for points in labels.values()]
    steps = np.abs(np.diff([tip[len(tip) // 3] for tip in tips], axis=0)) * 72.0 / axes.figure.dpi
    crowded = bool(np.any((steps[:, 0] < 200.0) & (steps[:, 1] < 22.0)))
    before = np.inf  # left end of the label before, pixels
    for rank, (sign, tip) in enumerate(zip(labels, tips, strict=True)):
        place = tip[len(tip) // 3]
        if axes.transData.transform(place)[0] > before:  # the leader would cross this label
            place = tip[2 * len(tip) // 3]
        colour, words = LOOKS[sign].line, coefficient_name(sign * data.coefficient, LOOKS[sign].name)
        style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING, "ha": "left"}
        lead = {"arrowstyle": "-", "color": colour, "linewidth": 1.2, "relpos": (0.1, 0.0)}
        offset = -24, 28 + 21 * rank if crowded else 40
        label = theme.label_point(axes, place, words, offset, arrowprops=lead, **style)
        beyond = max(label.get_window_extent().x1 - axes.get_window_extent().x1, 0.0)
        # The label is moved along the tip, which rises to the left.
        rise = max(float((tip[0] - tip[-1])[1] / (tip[0] - tip[-1])[0]), 0.0)
        back = beyond * 72.0 / axes.figure.dpi
        label.set_position((offset[0] - back, offset[1] + rise * back))
        before = label.get_window_extent().x0
    for text, point, offset in (
        (data.ends[0], points[4, 0], (-26, 0)),
        (data.ends[1], points[4, -1], (30, 0)),
        ("root", points[0, 4], (0, -24)),
        ("tip", points[-1, -1], (26, 8)),
    ):
        style = {"ha": "center", "va": "center", "color": theme.GREY}
        theme.label_point(axes, picture.project(point), text, offset, **style)


def _draw_section(axes: Axes, data: ModificationFigure) -> None:
    """Draw the profiles in true proportions and, thick, with magnified deviations."""
    for a, section in reversed(data.sections.items()):
        look, seen = LOOKS[a], section.magnified(data.factor)
        around = np.concatenate((section.base, seen[:, ::-1]), axis=1)
        around = around[:, np.isfinite(around).all(axis=0)]
        axes.fill(*around, color=look.line, alpha=0.12, lw=0.0)
        axes.plot(*seen, color=look.line, linewidth=2.4)
        axes.plot(section.across, section.up, color=look.line, linewidth=0.9)
        if a:
            ha, away = ("right", -6.0) if a > 0.0 else ("left", 6.0)
            theme.label_point(axes, seen[:, -1], look.name, (away, 0.0), ha=ha, va="center", color=look.line)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"Section, deviation \u00d7 {data.factor:g}", loc="left")
    axes.set(xlabel="across the tooth (mm)", ylabel="from the axis (mm)")
    axes.margins(0.06)
    axes.grid(True)
    for text, x, side in (("space", 0.08, "left"), ("tooth", 0.92, "right")):
        axes.text(x, 0.08, text, transform=axes.transAxes, color=theme.GREY, ha=side)


def _draw_deviation(axes: Axes, data: ModificationFigure) -> None:
    """Draw the deviation from the involute flank against the radius."""
    for a, section in data.sections.items():
        colour = LOOKS[a].line
        axes.fill_betweenx(section.radius, 0.0, section.deviation, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(section.deviation, section.radius, color=colour, linewidth=2.5)
    for text, x, side, colour in (
        ("convex:\nmetal\ntaken off", 0.04, "left", LOOKS[-1].line),
        ("concave:\nmetal\nleft on", 0.96, "right", LOOKS[1].line),
    ):
        axes.text(x, 0.5, text, transform=axes.transAxes, va="center", color=colour, ha=side)
    axes.set_title("Deviation from the involute", loc="left")
    axes.set(xlabel="out of the tooth (mm)", ylabel="radius (mm)")
    axes.margins(0.08)
    axes.grid(True)


def rows(data: ModificationFigure) -> Table:
    """List the points of the sections."""
    header = ("a_per_mm", "l_mm", "r_mm", "deviation_mm", "across_mm", "up_mm")
    magnified = ("factor", "magnified_across_mm", "magnified_up_mm")
    cases = []
    for sign, one in data.sections.items():
        drawn = data.factor, *one.magnified(data.factor)
        cases.append((sign * data.coefficient, one.l, one.radius, one.deviation, one.across, one.up, *drawn))
    return header + magnified, rows_of_cases(cases)


RECIPES = {"fig-06": Recipe(compute, draw, rows)}
