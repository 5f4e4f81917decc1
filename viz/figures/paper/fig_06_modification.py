"""Fig. 6: the pinion's flank without parabola, and with one of either sign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import FlankPatch, flank_patch, root_parameter, tip_parameter, trace_parameter
from beveloid_geom.gear.undercut import regular_start

from ...parts.annotate import Overlay
from ...parts.recipe import Drawing, Recipe, Table, stacked
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import Item, Picture, Tube, fit_camera, grid_surface

FLANK = "right"


class Look(NamedTuple):
    """How the flank of a coefficient is called and drawn: name, colours of metal and of lines, and between
    which shares of half the face width, from the heel, its terrace lies."""

    name: str
    colour: str
    line: str
    ends: tuple[float, float]


LOOKS = {
    -0.01: Look("convex", "#f0b98a", theme.RED, (1.0, 0.36)),
    0.0: Look("involute", "#c4ccd4", theme.BLACK, (0.36, -0.3)),
    0.01: Look("concave", "#8fc3e8", theme.BLUE, (-0.3, -1.0)),
}
"""By the coefficient, 1/mm, in the order of the flanks from the metal outwards."""
CHARTS, CHARTS_TALL = Cells(left=0.85, right=0.25, across=0.85, down=1.0, most=2, least=2.5), 6.6
"""Charts under the flanks, on a narrow page, and inches that they take."""
POINTS = 241
SEEN = 0.25
"""Of the height of the section, the deviation drawn at most: that of the flanks times a round factor."""
VIEW = (0.3, 0.12, 1.0)
"""Where the viewer stands, from the flank: along its normal, to the tip, along the tooth to the heel."""
NOTE = (
    "The flanks are overlaid in true proportions, seen from outside and from the heel; convex and"
    " involute flank run on under those that cover them. The steps, and the profiles at the heel, show"
    " what lies between them. The section is that at mid-face, square to the axis, seen from the heel: thin"
    " lines are the profiles in true proportions, thick ones have {factor:g} times their deviation from the"
    " involute. Deviations are taken at equal radius, along the normal of the involute flank."
)
UNDERCUT = " The {name} flank starts where the tool undercuts it."


@dataclass(frozen=True, eq=False)
class Section:
    """A flank at mid-face: flank parameter `l`, radius, distance from the involute flank (n,), mm;
    `across` and `up` (n,), mm, with the involute's middle on the vertical through the axis. There, too, the
    involute at equal radius, `base` (2, n), and the `way` (2, n) that is 1 mm along its normal in space."""

    l: FloatArray
    radius: FloatArray
    deviation: FloatArray
    across: FloatArray
    up: FloatArray
    base: FloatArray
    way: FloatArray

    def magnified(self, factor: float) -> FloatArray:
        """Give `across` and `up` (2, n), mm, of the profile with its deviation times a factor."""
        return np.asarray(self.base + factor * self.deviation * self.way)


@dataclass(frozen=True, eq=False)
class ModificationFigure:
    """The pinion with each coefficient its flank allows, the sections, and whether the tool
    undercuts a flank."""

    members: dict[float, Member]
    sections: dict[float, Section]
    undercut: dict[float, bool]

    @property
    def factor(self) -> float:
        """Times that deviations are magnified in the section, 1 where there are none."""
        sizes = [float(np.nanmax(np.abs(one.deviation))) for one in self.sections.values()]
        greatest = max(sizes, default=0.0)
        if greatest < 1e-6:
            return 1.0
        return theme.round_length(SEEN * float(np.ptp(self.sections[0.0].radius)) / greatest)


def compute(design: Design) -> ModificationFigure:
    """Find sections at mid-face; a coefficient so strong that the flank ends short of its tip is left out."""
    members = {a: design.with_parabola(a).pinion for a in LOOKS}
    members = {a: member for a, member in members.items() if _reaches_tip(member)}
    if 0.0 not in members:
        return ModificationFigure({}, {}, {})
    sections = {a: _section(member, members[0.0]) for a, member in members.items()}
    undercut = {a: bool(sections[a].l[0] > root_parameter(member) + 1e-6) for a, member in members.items()}
    return ModificationFigure(members, sections, undercut)


def _reaches_tip(member: Member) -> bool:
    half = 0.5 * float(member.face_width)
    return bool(np.isfinite(tip_parameter(member, FLANK, np.array([-half, 0.0, half]))).all())


def _patch(member: Member, share: FloatArray, z: FloatArray) -> tuple[FloatArray, FlankPatch]:
    """Give l and flank points (shares, z) between the start of the flank and its tip."""
    start = regular_start(member, FLANK, z)
    l = start + share[:, None] * (tip_parameter(member, FLANK, z) - start)
    return l, flank_patch(member, FLANK, l, trace_parameter(member, FLANK, l, z + 0.0 * l))


def _section(member: Member, involute: Member) -> Section:
    """Find the profile at mid-face, and how far it is from the involute one."""
    share, middle = np.linspace(0.0, 1.0, POINTS), np.zeros(1)
    l, patch = _patch(member, share, middle)
    _, base = _patch(involute, np.linspace(-0.1, 1.1, POINTS), middle)
    x, y = patch.point[:, 0, 0], patch.point[:, 0, 1]
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    base_x, base_y, _ = base.point[:, 0].T
    base_radius, base_angle = np.hypot(base_x, base_y), np.arctan2(base_y, base_x)
    there = np.interp(radius, base_radius, base_angle)
    # r (theta . n) is the moment of the normal about the axis: constant along an involute.
    moment = base_x * base.normal[:, 0, 1] - base_y * base.normal[:, 0, 0]
    deviation = (angle - there) * np.interp(radius, base_radius, moment)
    middle_angle = base_angle[POINTS // 2]
    normal = np.stack([np.interp(radius, base_radius, base.normal[:, 0, k]) for k in (0, 1)])
    # In the section, a step s along t, the unit vector of n's part there, is s |n_xy| along n.
    way = normal / (normal**2).sum(axis=0)
    (across, up), foot = (_upright(radius, own - middle_angle) for own in (angle, there))
    cos, sin = np.cos(middle_angle), np.sin(middle_angle)
    way = np.array([[sin, -cos], [cos, sin]]) @ way
    return Section(l[:, 0], radius, deviation, across, up, foot, way)


def _upright(radius: FloatArray, angle: FloatArray) -> FloatArray:
    """Give places (2, n), across and up, of a radius and an angle from the vertical, seen from the heel."""
    return np.stack((-radius * np.sin(angle), radius * np.cos(angle)))


def draw(data: ModificationFigure, layout: theme.Layout) -> Drawing:
    """Draw three flanks in one scene; the section and its deviations beside it."""
    cut_short = [LOOKS[a].name for a, short in data.undercut.items() if short]
    page, low, high = theme.new_page(
        layout,
        "Fig. 6   A positive parabola coefficient makes the flank concave, a negative one convex",
        f"{FLANK.capitalize()} flank of the pinion for $a$ = 0 and \u00b10.01 mm$^{{\u22121}}$",
        NOTE.format(factor=data.factor) + "".join(UNDERCUT.format(name=name) for name in cut_short),
        above=0.3,
        tall=6.4 if layout.width > theme.NARROW else 4.6 + CHARTS_TALL,
    )
    if not data.members:
        page.text(0.5, 0.5, "the pinion's flank ends short of its tip: there is nothing to draw", ha="center")
        return Drawing(page, {})
    overlay, section, deviation = _places(page, low, high)
    picture = _overlay(page, data, theme.place(page, *overlay))
    _draw_section(page.add_axes(section), data)
    _draw_deviation(page.add_axes(deviation), data)
    return Drawing(page, {"overlay": picture})


def _places(page: theme.Page, low: float, high: float) -> list[tuple[float, float, float, float]]:
    """Give the boxes, shares of the page, of the flanks, and of both charts beside them, or under them where
    the page is narrow."""
    gap, width = theme.inches(page, 0.95), page.layout.width
    if width > theme.NARROW:
        over, height = theme.inches(page, 0.3), (high - low - 1.6 * gap) / 2.0
        upper = low + height + 1.6 * gap
        flanks = 0.01, low, 0.625, high + over - low
        return [flanks, (0.69, upper, 0.285, height), (0.69, low + 0.6 * gap, 0.285, height)]
    top = low + theme.inches(page, CHARTS_TALL)
    charts = CHARTS.boxes(page.layout, 2, page.get_figheight(), low + 0.6 * gap, top - gap)
    return [(0.01, top, 0.98, high - top), *charts]


def _overlay(page: theme.Page, data: ModificationFigure, box: theme.Box) -> Picture:
    """Draw the flanks of all coefficients as terraces."""
    half = 0.5 * float(data.members[0.0].face_width)
    _, patch = _patch(data.members[0.0], np.linspace(0.0, 1.0, 9), np.linspace(-half, half, 9))
    depth, length = patch.point[8, 4] - patch.point[0, 4], patch.point[4, 8] - patch.point[4, 0]
    parts = patch.normal[4, 4], depth, length
    stand = sum(share * part / np.linalg.norm(part) for share, part in zip(VIEW, parts, strict=True))
    camera = fit_camera(patch.point, -np.asarray(stand), depth, box.size, margin=0.11)
    mm_per_px = camera.mm_per_px(box.size)
    mm_per_point = mm_per_px * page.dpi / 72.0
    items, labels = _terraces(data, 0.25 * mm_per_px, 1.3 * mm_per_point)
    over = Overlay.drawn(page, box, items, camera)
    _label_overlay(over, patch.point, labels)
    bar = theme.round_length(120.0 * mm_per_point)
    theme.scale_bar(over.axes, 0.05 * box.width, 0.9 * box.height, over.picture.px_per_mm, bar)
    return over.picture


def _stations(member: Member, tolerance: float) -> tuple[int, int]:
    """Give cells across the flank and along a third of its face that keep to a tolerance (mm)."""
    half = 0.5 * float(member.face_width)
    _, patch = _patch(member, np.linspace(0.0, 1.0, 9), np.linspace(-half, half, 9))

    def sagitta(points: FloatArray) -> float:
        return float(np.linalg.norm(points[:-2] - 2.0 * points[1:-1] + points[2:], axis=-1).max()) / 8.0

    bent = np.array([sagitta(patch.point), sagitta(patch.point.swapaxes(0, 1))])
    across, along = np.ceil(np.array([8.0, 3.0]) * np.sqrt(bent / tolerance)).astype(int)
    return int(across) + 1, int(along) + 1


def _terraces(
    data: ModificationFigure, tolerance: float, radius: float
) -> tuple[list[Item], dict[float, FloatArray]]:
    """Make each flank on its third of the face, steps between them, and where labels point."""
    half = 0.5 * float(data.members[0.0].face_width)
    cells = np.array([_stations(member, tolerance) for member in data.members.values()]).max(axis=0)
    share = np.linspace(0.0, 1.0, 1 + int(cells[0]))
    items: list[Item] = []
    labels: dict[float, FloatArray] = {}
    below: float | None = None
    for a, member in data.members.items():
        look = LOOKS[a]
        z = half * np.linspace(*look.ends, 1 + int(cells[1]))
        patch = _patch(member, share, z)[1]
        front = patch.point[:, 0]
        items.append(grid_surface(patch.point, patch.normal, look.colour))
        items += [Tube(edge, look.line, radius) for edge in (front, patch.point[0], patch.point[-1])]
        if below is None:
            items += _heel_profiles(data, share, radius)
        else:
            under = _patch(data.members[below], share, z[:1])[1].point[:, 0]
            items.append(grid_surface(np.stack((under, front)), None, look.line))
            items.append(Tube(under, LOOKS[below].line, radius))
        labels[a] = patch.point[-1, patch.point.shape[1] // 3]
        below = a
    return items, labels


def _heel_profiles(data: ModificationFigure, share: FloatArray, radius: float) -> list[Item]:
    """Make the profiles of all flanks in the plane of the heel, and what lies between them."""
    z = np.array([0.5 * float(data.members[0.0].face_width)])
    profiles = {a: _patch(member, share, z)[1].point[:, 0] for a, member in data.members.items()}
    items: list[Item] = [Tube(points, LOOKS[a].line, radius) for a, points in profiles.items()]
    between = {a: np.stack((points, profiles[0.0])) for a, points in profiles.items() if a}
    return items + [grid_surface(grid, None, LOOKS[a].colour, opacity=0.75) for a, grid in between.items()]


def coefficient_name(a: float) -> str:
    """Give the coefficient and shape."""
    value = theme.signed(a, 2) if a else "0"
    return f"$a$ = {value} mm$^{{\u22121}}$: {LOOKS[a].name}"


def _label_overlay(over: Overlay, points: FloatArray, labels: dict[float, FloatArray]) -> None:
    """Name the flanks at the points `labels` (3,), mm, and the sides of the flank whose points (9, 9, 3) are
    given."""
    axes, picture = over.axes, over.picture
    places = {a: picture.project(point) for a, point in labels.items()}
    steps = np.abs(np.diff(list(places.values()), axis=0)) * 72.0 / axes.figure.dpi
    crowded = bool(np.any((steps[:, 0] < 200.0) & (steps[:, 1] < 22.0)))
    for rank, (a, place) in enumerate(places.items()):
        colour = LOOKS[a].line
        style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING, "ha": "left"}
        lead = {"arrowstyle": "-", "color": colour, "linewidth": 1.2, "relpos": (0.1, 0.0)}
        offset = -24, 28 + 21 * rank if crowded else 40
        label = theme.beside(axes, place, coefficient_name(a), offset, arrowprops=lead, **style)
        beyond = label.get_window_extent().x1 - axes.get_window_extent().x1
        label.set_position((offset[0] - max(beyond, 0.0) * 72.0 / axes.figure.dpi, offset[1]))
    for text, point, offset in (
        ("toe", points[4, 0], (-26, 0)),
        ("heel", points[4, -1], (30, 0)),
        ("root", points[0, 4], (0, -24)),
        ("tip", points[-1, -1], (26, 8)),
    ):
        style = {"ha": "center", "va": "center", "color": theme.GREY}
        theme.beside(axes, picture.project(point), text, offset, **style)


def _draw_section(axes: Axes, data: ModificationFigure) -> None:
    """Draw the profiles in true proportions and, thicker, with their deviations magnified."""
    for a, section in reversed(data.sections.items()):
        look, seen = LOOKS[a], section.magnified(data.factor)
        axes.fill(*np.concatenate((section.base, seen[:, ::-1]), axis=1), color=look.line, alpha=0.12, lw=0.0)
        axes.plot(*seen, color=look.line, linewidth=2.4)
        axes.plot(section.across, section.up, color=look.line, linewidth=0.9)
        if a:
            ha, away = ("right", -6.0) if a > 0.0 else ("left", 6.0)
            theme.beside(axes, seen[:, -1], look.name, (away, 0.0), ha=ha, va="center", color=look.line)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"Section, deviation \u00d7 {data.factor:g}", loc="left")
    axes.set(xlabel="across the tooth (mm)", ylabel="from the axis (mm)")
    axes.margins(0.06)
    axes.grid(True)
    for text, x, side in (("space", 0.08, "left"), ("tooth", 0.92, "right")):
        axes.text(x, 0.08, text, transform=axes.transAxes, color=theme.GREY, ha=side)


def _draw_deviation(axes: Axes, data: ModificationFigure) -> None:
    """Draw the distance from the involute flank against the radius."""
    for a, section in data.sections.items():
        colour = LOOKS[a].line
        axes.fill_betweenx(section.radius, 0.0, section.deviation, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(section.deviation, section.radius, color=colour, linewidth=2.5)
    for text, x, side, colour in (
        ("convex:\nmetal\ntaken off", 0.04, "left", LOOKS[-0.01].line),
        ("concave:\nmetal\nleft on", 0.96, "right", LOOKS[0.01].line),
    ):
        axes.text(x, 0.5, text, transform=axes.transAxes, va="center", color=colour, ha=side)
    axes.set_title("Deviation from the involute", loc="left")
    axes.set(xlabel="out of the tooth (mm)", ylabel="radius (mm)")
    axes.margins(0.08)
    axes.grid(True)


def rows(data: ModificationFigure) -> Table:
    """List the sections."""
    header = ("a_per_mm", "l_mm", "r_mm", "deviation_mm", "across_mm", "up_mm")
    magnified = ("factor", "magnified_across_mm", "magnified_up_mm")
    return header + magnified, stacked(
        (a, s.l, s.radius, s.deviation, s.across, s.up, data.factor, *s.magnified(data.factor))
        for a, s in data.sections.items()
    )


RECIPES = {"fig-06": Recipe(compute, draw, rows)}
