"""Fig. 4: the meshing model: axes, pitch point, radii, mounting distances, frames."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beveloid_geom import Design, Errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.frames import layout_of, to_fixed
from beveloid_geom.pair.mounting import Mounting, mounting_of

from ...parts import panels, posed, solved
from ...parts.annotate import Overlay
from ...parts.posed import PosedPair
from ...parts.recipe import Drawing, Recipe, Table, quantities, vector
from ...stage import theme
from ...stage.scene import Item, Tube, fit_camera

CONES = ("#8fb4d4", "#e3bd7c")
INKS = (theme.BLUE, "#8a5a00")
"""Of pinion and gear."""
FARTHEST = 2.5
"""Zero-shift sections farther from mid-face than so many face widths are not drawn."""


MEET = 1e-6
"""mm within which lines of action meet."""
NEAR = 0.01
"""Share of the distance of the members within which two frames are drawn as one."""
ALONG = 0.9
"""Cosine of the angle between two radii from which on they hide each other."""
TABLE = 2.0
"""Inches of the numbers, where they stand under the view."""


@dataclass(frozen=True, eq=False)
class MeshingFigure:
    """The unmodified pair without errors, at roll 0; for pinion and gear (2,): `reference_radius` r_P,
    `shift_distance` b_c (infinite for cylindrical members), mm."""

    pair: PosedPair
    reference_radius: FloatArray
    shift_distance: FloatArray

    @property
    def mounting(self) -> Mounting:
        """Pitch point, working radii and mounting distances."""
        return mounting_of(self.pair.design)

    @property
    def level(self) -> bool:
        """Whether the axes are parallel, and so the common perpendicular one of many."""
        return bool(layout_of(self.pair.design).parallel)

    def together(self, number: int) -> bool:
        """Whether mid-face of a member stands at its foot of the common perpendicular."""
        return bool(abs(self.mounting.distance[number]) < NEAR * self.pair.apart)

    @property
    def found(self) -> bool:
        """Whether there is a pitch point."""
        return bool(np.isfinite(self.mounting.pitch_point).all())

    def in_line(self, number: int) -> bool:
        """Whether the pitch point lies on the side where the own y axis of a member points."""
        _, up, _ = self.pair.frames[number][0].T
        way = self.mounting.pitch_point - self.pair.foot[number]
        return bool(up @ way > ALONG * float(self.mounting.working_radius[number]))

    @property
    def feet(self) -> FloatArray:
        """Points (2, 3) in S_f of the axes on the common perpendicular where that is drawn, mm."""
        return np.asarray(self.pair.foot + self.pair.nearer * self.pair.axis[0])

    @property
    def breaks(self) -> FloatArray:
        """Points (2, 3) in S_f where the axes are broken if they are, mm."""
        return np.asarray(self.pair.foot + (self.pair.position + self.pair.breaks)[:, None] * self.pair.axis)

    @property
    def gear_way(self) -> FloatArray:
        """Unit vector (3,) of the gear's axis as drawn at the common perpendicular, in the sense of its z."""
        if not self.pair.nearer:
            return np.asarray(self.pair.axis[1])
        way = np.sign(self.pair.position[1]) * (self.breaks[1] - self.feet[1])
        return np.asarray(way / np.linalg.norm(way))


def compute(design: Design) -> MeshingFigure:
    """Find the layout of the pair, from its mounting."""
    nominal = replace(design.with_parabola(0.0, 0.0), errors=Errors())
    pair = posed.placed(nominal, np.zeros(2))
    shift = []
    for member in design.members:
        height, slope = member.profile_shift * member.tool.normal_module, np.tan(float(member.cone_angle))
        shift.append(float(height / slope) if slope else np.copysign(np.inf, height) if height else 0.0)
    radii = [float(reference_radius(member)) for member in design.members]
    return MeshingFigure(pair, np.array(radii), np.array(shift))


def _radius(data: MeshingFigure, number: int, z: float) -> float:
    """Give the radius of the reference cone in the plane `z` from mid-face, mm."""
    member = data.pair.design.members[number]
    height = float(member.profile_shift * np.asarray(member.tool.normal_module))
    return float(data.reference_radius[number] + height + z * np.tan(float(member.cone_angle)))


def _drawn_shift(data: MeshingFigure, number: int) -> float:
    """Give b_c where it can be drawn, else 0."""
    shift = float(data.shift_distance[number])
    return shift if abs(shift) < FARTHEST * float(data.pair.design.members[number].face_width) else 0.0


def _cone_ends(data: MeshingFigure, number: int) -> tuple[float, float]:
    """Say from where to where along z (mm, from mid-face) a reference cone is drawn."""
    half = 0.5 * float(data.pair.design.members[number].face_width)
    shift = _drawn_shift(data, number)
    return min(-half, -1.15 * shift), max(half, -1.15 * shift)


def _ring(data: MeshingFigure, number: int, radius: float, z: float) -> FloatArray:
    """Give points (n, 3) in S_f of a circle about a member's axis, `z` from mid-face, mm."""
    return to_fixed(data.pair.frames[number], posed.circle(radius, z))


def draw(data: MeshingFigure, layout: theme.Layout) -> Drawing:
    """Draw reference cones, axes and circles in space, with their dimensions."""
    pair = layout_of(data.pair.design)
    offset, angle = float(pair.offset), f"{np.degrees(abs(float(pair.shaft_angle))):g}\u00b0"
    page, low, high = theme.new_page(
        layout,
        f"Fig. 4   Meshing model of the {'crossed ' if data.pair.crossed else ''}beveloid gears",
        f"Offset $E$ = {offset:g} mm, shaft angle $\\delta$ = {angle}; reference cones of pinion"
        " (blue) and gear (brown), working pitch circles (orange, dashed)",
        f"Unmodified pair without errors. {_where_p_is(data)} $S_1$ and $S_2$ stand at mid-face, at roll 0."
        " The paper puts them $b_c$ nearer to the toe, in the"
        " section where the profile shift is zero and the reference cone has the radius $r_P$."
        + posed.far_words(data.pair),
        tall=7.2 if layout.width > theme.NARROW else 4.6 + TABLE,
    )
    narrow = layout.width < theme.NARROW
    under = theme.inches(page, TABLE if narrow else 0.0)  # where the view leaves no corner free
    box = theme.place(page, 0.02, low + under, 0.96, high - low - under)
    reach = [_ring(data, n, _radius(data, n, z), z) for n in (0, 1) for z in _cone_ends(data, n)]
    below = 1.4 * _radius(data, 1, _cone_ends(data, 1)[1])
    feet = np.array([[-0.25 * data.pair.apart, 0.0, 0.0], [offset, below, 0.0]])
    feet = feet + data.pair.nearer * data.pair.axis[0]
    camera = fit_camera(np.concatenate((*reach, feet)), posed.VIEW, posed.UP, box.size, 0.06)
    over = Overlay.drawn(page, box, _items(data, 0.0016 * camera.half_height * 2.0), camera)
    _annotate_layout(over, data)
    if data.found:
        for number in (0, 1):
            _annotate_member(over, data, number)
        style: dict[str, Any] = {"color": theme.RED, "fontsize": theme.TITLE, "fontweight": "bold"}
        over.label(
            data.mounting.pitch_point, "$P$", (20.0, -4.0) if data.in_line(0) else (2.0, 20.0), **style
        )
    corner = 0.03, 0.6 if data.pair.remote else 0.13, 0.24, 0.19
    _table(page, data, (0.03, low, 0.75, 0.9 * under) if narrow else corner)
    return Drawing(page, {"meshing": over.picture})


def _where_p_is(data: MeshingFigure) -> str:
    """Say where the pitch point lies."""
    if data.level:
        return (
            "$P$ stands midway between the mid-faces on the pitch line, in which the planes of action of"
            " right and left flanks meet."
        )
    gap = abs(float(data.mounting.gap))
    passing = f" (here they pass each other at {gap:.3g} mm; $P$ is midway)" if gap > MEET else ""
    return f"$P$ is the point where the lines of action of right and left flanks meet{passing}."


def _items(data: MeshingFigure, radius: float) -> list[Item]:
    """Make the reference cones, and circles and pitch point in lines of a `radius` (mm)."""
    items: list[Item] = []
    for number, frame in enumerate(data.pair.frames):
        low, high = _cone_ends(data, number)
        cone = np.array([[_radius(data, number, z), z] for z in (low, high)])
        items += posed.lathe(cone, frame, CONES[number], opacity=0.38)
    for number in (0, 1):
        for z in _cone_ends(data, number):
            items.append(Tube(_ring(data, number, _radius(data, number, z), z), theme.GREY, 0.5 * radius))
        shift = _drawn_shift(data, number)
        items.append(Tube(_ring(data, number, _radius(data, number, -shift), -shift), INKS[number], radius))
        if data.found:
            z = float(data.mounting.pitch_distance[number] - data.mounting.distance[number])
            working = float(data.mounting.working_radius[number])
            pieces = panels.dashed_circle(_ring(data, number, working, z), 1.2 * radius)
            items += [Tube(piece, theme.RED, 1.2 * radius) for piece in pieces]
    if data.found:
        items.append(Tube(data.mounting.pitch_point[None], theme.RED, 4.5 * radius))
    return items


def _annotate_layout(over: Overlay, data: MeshingFigure) -> None:
    """Draw both axes, offset, shaft angle, and the fixed frames."""
    reach = float(np.nan_to_num(data.mounting.distance).max()) - data.pair.nearer
    if data.level:
        reach = max(reach, 0.5 * data.pair.apart)
    feet, ways = data.feet, data.pair.axis
    length = 0.19 * data.pair.apart
    for number in (0, 1):
        far = float(np.nan_to_num(data.mounting.distance[number])) + _cone_ends(data, number)[1]
        end = data.pair.foot[number] + (far + 0.2 * reach) * ways[number]
        over.axis(feet[number], end, theme.INK, data.breaks[number] if data.pair.nearer else None)
    style: dict[str, Any] = {"color": theme.INK, "fontsize": theme.HEADING, "ha": "right", "va": "top"}
    if data.level:  # beside the working radii, which it would cover
        down = 1.25 * _radius(data, 1, _cone_ends(data, 1)[1])
        ends = feet + np.array([0.0, down, 0.0])
        for foot, end in zip(feet, ends, strict=True):
            over.line(foot, end, color=theme.INK, linewidth=0.9)
        over.dimension(ends[0], ends[1], "$E$", offset=(-4.0, -6.0), **style)
    else:
        if data.pair.foot[1, 0]:
            over.dimension(feet[0], feet[1], "$E$", offset=(-4.0, -6.0), **style)
        else:
            over.label(feet[0], "$E$ = 0", (-9.0, -6.0), **style)
        arc = (0.4 if data.pair.nearer else 0.6) * reach
        over.angle(feet[1], ways[0], data.gear_way, arc, "$\\delta$", (1.25, 0.8), (-5.0, 2.0))
    for number, name in enumerate("f" if data.pair.remote else "fg"):
        if data.together(number):
            continue
        rotation = data.pair.frames[number][0]
        names = tuple(f"{letter}_{name}" for letter in "xyz")
        offset = (-4.0, 15.0) if number == 0 else (16.0, -12.0)
        over.triad(feet[number], rotation.T, length, names, theme.INK, f"S_{name}", offset)


def _annotate_member(over: Overlay, data: MeshingFigure, number: int) -> None:
    """Draw mounting distance, b_c, radii and own frame of one member."""
    start, foot, way = data.feet[number], data.pair.foot[number], data.pair.axis[number]
    colour, index = INKS[number], number + 1
    mounting = data.mounting
    middle, pitch = foot + mounting.distance[number] * way, foot + mounting.pitch_distance[number] * way
    style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING}
    radius = _radius(data, number, _cone_ends(data, number)[1])
    # The pinion is measured on its far side, the gear below and on its far side.
    out, near = radius * np.array((((-1.22, 0, 0), (-1.08, 0, 0)), ((0, 1.36, 0), (1.4, 0, 0)))[number])
    offsets = (((-16.0, 8.0), (-14.0, -12.0)), ((0.0, -14.0), (8.0, -14.0)))[number]
    if float(abs(mounting.pitch_distance[number])) > NEAR * data.pair.apart:
        for end in (start, pitch):
            over.line(end, end + 1.03 * out, color=colour, linewidth=0.9)
        over.dimension(start + out, pitch + out, f"$d_{{w{index}}}$", offsets[0], at=0.45, **style)
        if data.pair.nearer:
            over.broken(0.4 * start + 0.6 * pitch + out, pitch + out, colour)
    shift = _drawn_shift(data, number)
    zero = middle - shift * way
    if shift:
        for end in (zero, middle):
            over.line(end, end + 1.03 * near, color=colour, linewidth=0.9)
        over.dimension(zero + near, middle + near, f"$b_{{c{index}}}$", offsets[1], **style)
    working = {"color": theme.RED, "fontsize": theme.HEADING}
    over.arrow(pitch, mounting.pitch_point, theme.RED, 1.4)
    beside = pitch + 0.66 * (mounting.pitch_point - pitch)
    below = (-12.0, -11.0) if number == 0 else (4.0, 13.0)
    over.label(beside, f"$r_{{w{index}}}$", below, **working)
    turn = data.pair.frames[number][0] @ np.array([0.0, 1.0, 0.0])
    if data.in_line(number):  # r_w is there
        turn = data.pair.frames[number][0] @ -np.sqrt([0.5, 0.5, 0.0])
    rim = zero + _radius(data, number, -shift) * turn
    over.arrow(zero, rim, colour, 1.4)
    over.label(zero + 0.6 * (rim - zero), f"$r_{{P{index}}}$", (16.0, 0.0), **style)
    also = f" = {{}}_{'fg'[number]}" if data.together(number) else ""
    names = tuple(f"{letter}_{index}{also.format(letter)}" for letter in "xyz")
    length = 0.17 * data.pair.apart
    over.triad(
        middle,
        data.pair.frames[number][0].T,
        length,
        names,
        colour,
        f"S_{index}{also.format('S')}",
        ((-14.0, 12.0), (14.0, -16.0))[number],
    )


def _table(page: theme.Page, data: MeshingFigure, place: tuple[float, float, float, float]) -> None:
    """Draw the numbers in a part of the page: left, bottom, width and height as shares."""
    rows_of = (
        ("$d_w$", data.mounting.pitch_distance),
        ("$b_c$", data.shift_distance),
        ("$r_w$", data.mounting.working_radius),
        ("$r_P$", data.reference_radius),
    )
    axes = theme.overlay(page, theme.place(page, *place))
    axes.set(xlim=(0.0, 1.0), ylim=(5.2, -0.6))
    style: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": theme.LABEL}
    for x, words, colour in ((0.62, "pinion", INKS[0]), (1.0, "gear", INKS[1])):
        axes.text(x, 0.0, words, color=colour, fontweight="bold", **style)
    axes.plot([0.0, 1.0], [0.55, 0.55], color=theme.GREY, linewidth=1.0)
    for line, (name, values) in enumerate(rows_of, start=1):
        axes.text(0.0, line + 0.1, f"{name}, mm", va="center", fontsize=theme.LABEL)
        for x, value in zip((0.62, 1.0), values, strict=True):
            words = (
                f"{value:.3f}".replace("-", "\u2212")
                if np.isfinite(value)
                else "none"
                if np.isnan(value)
                else "\u221e"
            )
            axes.text(x, line + 0.1, words, **style)


def rows(data: MeshingFigure) -> Table:
    """List layout, mounting and radii."""
    named = {
        "pitch_distance_dw": data.mounting.pitch_distance,
        "mid_face_distance": data.mounting.distance,
        "shift_distance_bc": data.shift_distance,
        "working_radius": data.mounting.working_radius,
        "reference_radius": data.reference_radius,
    }
    layout = layout_of(data.pair.design)
    return quantities(
        ("offset", "mm", float(layout.offset)),
        ("shaft_angle", "rad", float(layout.shaft_angle)),
        *((f"{m}_{name}", "mm", v[k]) for k, m in enumerate(solved.MEMBERS) for name, v in named.items()),
        *vector("pitch_point_{}_f", "mm", data.mounting.pitch_point),
        ("gap_of_lines_of_action", "mm", float(data.mounting.gap)),
    )


RECIPES = {"fig-04": Recipe(compute, draw, rows)}
