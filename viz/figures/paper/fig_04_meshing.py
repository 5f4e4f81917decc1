"""Fig. 4: meshing model with axes, pitch point, radii, mounting distances and frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beveloid_geom import Design, Errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.frames import layout_of, to_fixed
from beveloid_geom.pair.mounting import Mounting, mounting_of

from ...components import panels, paths_table, posed
from ...components.annotate import UNNAMED, Overlay
from ...components.figure_steps import Drawing, Recipe, Table, quantities, vector
from ...components.free_space import FreeSpace
from ...components.posed import PosedPair
from ...rendering import theme
from ...rendering.scene import Item, Tube, fit_camera

LINE_COLOURS = (theme.BLUE, "#8a5a00")
"""Line colours of pinion and gear."""


@dataclass(frozen=True, eq=False)
class MeshingFigure:
    """The unmodified pair without errors at roll 0.

    For pinion and gear (2,), mm: `reference_radius` r_P, and `shift_distance` b_c from the section without
    profile shift to mid-face (infinite for cylindrical members with profile shift, 0 without)."""

    pair: PosedPair
    reference_radius: FloatArray
    shift_distance: FloatArray

    @property
    def mounting(self) -> Mounting:
        """Pitch point, working radii and mounting distances."""
        return mounting_of(self.pair.design)

    def together(self, number: int) -> bool:
        """Return whether mid-face of a member is at its foot of the common perpendicular."""
        return self.is_short(float(self.mounting.distance[number]))

    def is_short(self, length: float) -> bool:
        """Return whether frames at a distance (mm) are drawn as one."""
        return bool(abs(length) < 0.01 * self.pair.apart)

    def parallel_frame(self, number: int) -> bool:
        """Return whether the fixed frame with the axes of the frame of a member is drawn as well."""
        return not self.together(number) and not (number == 1 and self.pair.remote)

    @property
    def has_pitch_point(self) -> bool:
        """Whether there is a pitch point."""
        return bool(np.isfinite(self.mounting.pitch_point).all())

    def in_line(self, number: int) -> bool:
        """Return whether the radius to the pitch point has nearly the direction of the y axis of a member, so
        that the arrows of both hide each other."""
        # Cosine of the angle between two radii above which they hide each other.
        hiding_cosine = 0.9
        _, up, _ = self.pair.frames[number][0].T
        radius = self.mounting.pitch_point - self.pair.foot[number]
        return bool(up @ radius > hiding_cosine * float(self.mounting.working_radius[number]))

    @property
    def feet(self) -> FloatArray:
        """Feet (2, 3) of the common perpendicular in S_f as drawn, mm."""
        return np.asarray(self.pair.foot + self.pair.nearer * self.pair.axis[0])

    @property
    def breaks(self) -> FloatArray:
        """Points (2, 3) in S_f at which the axes are broken, mm."""
        return np.asarray(self.pair.foot + (self.pair.position + self.pair.breaks)[:, None] * self.pair.axis)

    @property
    def gear_direction(self) -> FloatArray:
        """Unit vector (3,) of the gear axis as drawn at the common perpendicular, in the direction of its
        z."""
        if not self.pair.nearer:
            return np.asarray(self.pair.axis[1])
        direction = np.sign(self.pair.position[1]) * (self.breaks[1] - self.feet[1])
        return np.asarray(direction / np.linalg.norm(direction))


def compute(design: Design) -> MeshingFigure:
    """Compute the layout of the pair from its mounting."""
    nominal = replace(design.unmodified(), errors=Errors())
    pair = posed.placed(nominal, np.zeros(2))
    shift = []
    for member in design.members:
        height, slope = member.profile_shift * member.tool.normal_module, np.tan(float(member.cone_angle))
        shift.append(float(height / slope) if slope else np.copysign(np.inf, height) if height else 0.0)
    radii = [float(reference_radius(member)) for member in design.members]
    return MeshingFigure(pair, np.array(radii), np.array(shift))


def _radius(data: MeshingFigure, number: int, z: float) -> float:
    """Return the radius of the reference cone at a distance `z` from mid-face, mm."""
    member = data.pair.design.members[number]
    height = float(member.profile_shift * np.asarray(member.tool.normal_module))
    return float(data.reference_radius[number] + height + z * np.tan(float(member.cone_angle)))


def _drawn_shift(data: MeshingFigure, number: int) -> float:
    """Return b_c if it is drawn, else 0, mm."""
    # Sections without profile shift are drawn up to this distance from mid-face, in face widths.
    largest_shift_face_widths = 2.5
    shift, face = float(data.shift_distance[number]), float(data.pair.design.members[number].face_width)
    return shift if abs(shift) < largest_shift_face_widths * face else 0.0


def _cone_ends(data: MeshingFigure, number: int) -> tuple[float, float]:
    """Return the ends of the reference cone as drawn, z in mm from mid-face."""
    half = 0.5 * float(data.pair.design.members[number].face_width)
    shift = _drawn_shift(data, number)
    return min(-half, -1.15 * shift), max(half, -1.15 * shift)


def _ring(data: MeshingFigure, number: int, radius: float, z: float) -> FloatArray:
    """Return points (n, 3) in S_f of a circle about the axis of a member at `z` from mid-face, mm."""
    return to_fixed(data.pair.frames[number], posed.circle(radius, z))


def draw(data: MeshingFigure, layout: theme.PageLayout) -> Drawing:
    """Draw reference cones, axes and circles with their dimensions."""
    narrow = not layout.wide
    small_pinion = bool(data.reference_radius[0] < 0.35 * data.pair.apart)  # too small for its symbols
    detailed = narrow and small_pinion and data.has_pitch_point
    # Heights of the picture and, on a narrow page, of the detail of a small pinion and the table, inches.
    heights = (4.3, 3.0, 1.9) if detailed else (4.6, 0.0, 2.0) if narrow else (7.2, 0.0, 0.0)
    # A narrow page has no space for the names of axes that are parallel to those of a fixed frame.
    unnamed = [n for n in (0, 1) if narrow and data.parallel_frame(n) and not (detailed and n == 0)]
    pair = layout_of(data.pair.design)
    offset, angle = float(pair.offset), f"{np.degrees(abs(float(pair.shaft_angle))):g}\u00b0"
    page, low, high = theme.new_page(
        layout,
        f"Fig. 4   Meshing model of the {'crossed ' if data.pair.crossed else ''}beveloid gears",
        f"Offset $E$ = {offset:g} mm, shaft angle $\\delta$ = {angle}; reference cones of pinion"
        " (blue) and gear (brown), working pitch circles (orange, dashed)",
        f"Unmodified pair. {_where_p_is(data)} $d_w$: axial distance of $P$ from the common perpendicular"
        " (commands: dw1, dw2 of mid-face). $S_1$, $S_2$: at mid-face; in the paper at $b_c$ from it,"
        " with zero profile shift and the radius $r_P$." + _axes_words(unnamed) + posed.far_words(data.pair),
        tall=sum(heights),
    )
    table, detail = theme.inches(page, heights[2]), theme.inches(page, heights[1])
    box = theme.place(page, 0.02, low + table + detail, 0.96, high - low - table - detail)
    reach = [_ring(data, n, _radius(data, n, z), z) for n in (0, 1) for z in _cone_ends(data, n)]
    below = 1.4 * _radius(data, 1, _cone_ends(data, 1)[1])
    feet = np.array([[-0.25 * data.pair.apart, 0.0, 0.0], [offset, below, 0.0]])
    feet = feet + data.pair.nearer * data.pair.axis[0]
    if data.has_pitch_point and not data.together(0):
        reach.append(data.feet[:1] + _out(data)[0])
    if _drawn_shift(data, 1):
        side = np.array([1.6 * _radius(data, 1, _cone_ends(data, 1)[1]), 0.0, 0.0])
        reach.append(data.pair.foot[1:] + data.mounting.distance[1] * data.pair.axis[1] + side)
    camera = fit_camera(np.concatenate((*reach, feet)), posed.VIEW, posed.UP, box.size, 0.06)
    over = Overlay.drawn(page, box, _items(data, 0.0016 * camera.half_height * 2.0), camera)
    pictures = {"meshing": over.picture}
    _annotate_layout(over, data)
    if data.has_pitch_point:
        for number in (0, 1):
            _annotate_distance(over, data, number)
        _annotate_member(over, data, 1, named=1 not in unnamed)
        closer = over
        if detailed:
            place = theme.place(page, 0.02, low + table, 0.96, detail - theme.inches(page, 0.1))
            closer = _detail(page, place, data)
            pictures["pinion"] = closer.picture
            middle = data.pair.foot[0] + data.mounting.distance[0] * data.pair.axis[0]
            over.label(middle, "$S_1$", (-10.0, 10.0), color=LINE_COLOURS[0], fontsize=theme.HEADING)
        _annotate_member(closer, data, 0, named=0 not in unnamed)
        style: dict[str, Any] = {"color": theme.VERMILLION, "fontsize": theme.TITLE, "fontweight": "bold"}
        label_offset = (
            (20.0, -4.0) if data.in_line(0) else (14.0, -18.0) if data.together(0) else (12.0, 20.0)
        )
        closer.label(data.mounting.pitch_point, "$P$", label_offset, **style)
    _table(page, data, (0.03, low, 0.75, 0.9 * table) if narrow else _free_corner(page, over, data))
    return Drawing(page, pictures)


def _free_corner(page: theme.Page, over: Overlay, data: MeshingFigure) -> tuple[float, float, float, float]:
    """Return the place of the table on a wide page: the corner where it hides least of the picture."""
    free_space = FreeSpace(over.axes)
    bottoms = (0.6, 0.13) if data.pair.remote else (0.13, 0.6)
    corners = [(left, bottom, 0.24, 0.19) for bottom in bottoms for left in (0.03, 0.73)]
    return min(corners, key=lambda corner: free_space.hides(theme.place(page, *corner)))


def _detail(page: theme.Page, box: theme.PageBox, data: MeshingFigure) -> Overlay:
    """Draw the pinion magnified, and name it."""
    ends = [(z, _radius(data, 0, z)) for z in _cone_ends(data, 0)]
    reach = [_ring(data, 0, 1.2 * radius, z) for z, radius in ends]
    camera = fit_camera(np.concatenate(reach), posed.VIEW, posed.UP, box.size, 0.02)
    over = Overlay.drawn(page, box, _items(data, 0.0032 * camera.half_height), camera)
    over.axes.text(
        0.02, 0.98, "pinion,\nmagnified", transform=over.axes.transAxes, va="top", fontsize=theme.LABEL
    )
    return over


def _where_p_is(data: MeshingFigure) -> str:
    """Return the sentence that defines the pitch point."""
    # Largest distance of lines of action that meet, mm.
    meeting_distance_mm = 1e-6
    if data.pair.parallel:
        return (
            "$P$ is midway between the mid-faces on the pitch line, the intersection of the planes of action."
        )
    gap = abs(float(data.mounting.gap))
    passing = f" ({gap:.3g} mm apart here, $P$ midway)" if gap > meeting_distance_mm else ""
    return f"$P$: intersection of the lines of action of right and left flanks{passing}."


def _axes_words(unnamed: Sequence[int]) -> str:
    """Return the sentence on the axes of the members that have no names; empty if all have names."""
    pairs = [f"$S_{'12'[number]}$ to $S_{'fg'[number]}$" for number in unnamed]
    return f" Axes without names are parallel: {', '.join(pairs)}." if pairs else ""


def _items(data: MeshingFigure, radius: float) -> list[Item]:
    """Return the reference cones, and circles and pitch point as lines of a `radius` (mm)."""
    cone_colours = ("#8fb4d4", "#e3bd7c")
    items: list[Item] = []
    for number, frame in enumerate(data.pair.frames):
        low, high = _cone_ends(data, number)
        cone = np.array([[_radius(data, number, z), z] for z in (low, high)])
        items += posed.lathe(cone, frame, cone_colours[number], opacity=0.38)
        for z in (low, high):
            items.append(Tube(_ring(data, number, _radius(data, number, z), z), theme.GREY, 0.5 * radius))
        shift = _drawn_shift(data, number)
        ring = _ring(data, number, _radius(data, number, -shift), -shift)
        items.append(Tube(ring, LINE_COLOURS[number], radius))
        if data.has_pitch_point:
            z = float(data.mounting.pitch_distance[number] - data.mounting.distance[number])
            working = float(data.mounting.working_radius[number])
            pieces = panels.dashed_circle(_ring(data, number, working, z), 1.2 * radius)
            items += [Tube(piece, theme.VERMILLION, 1.2 * radius) for piece in pieces]
    if data.has_pitch_point:
        items.append(Tube(data.mounting.pitch_point[None], theme.VERMILLION, 4.5 * radius))
    return items


def _annotate_layout(over: Overlay, data: MeshingFigure) -> None:
    """Draw both axes, offset, shaft angle, and the fixed frames."""
    reach = float(np.nan_to_num(data.mounting.distance).max()) - data.pair.nearer
    if data.pair.parallel:
        reach = max(reach, 0.5 * data.pair.apart)
    feet, directions = data.feet, data.pair.axis
    length = 0.19 * data.pair.apart
    for number in (0, 1):
        far = float(np.nan_to_num(data.mounting.distance[number])) + _cone_ends(data, number)[1]
        end = data.pair.foot[number] + (far + 0.2 * reach) * directions[number]
        over.axis(feet[number], end, theme.INK, data.breaks[number] if data.pair.nearer else None)
    style: dict[str, Any] = {"color": theme.INK, "fontsize": theme.HEADING, "ha": "right", "va": "top"}
    if data.pair.parallel:  # the dimension of the offset would cover the working radii
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
        over.angle(feet[1], directions[0], data.gear_direction, arc, "$\\delta$", (1.25, 0.8), (-5.0, 2.0))
    for number, name in enumerate("fg"):
        if not data.parallel_frame(number):
            continue
        rotation = data.pair.frames[number][0]
        names = tuple(f"{letter}_{name}" for letter in "xyz")
        offset = (-4.0, 15.0) if number == 0 else (16.0, -12.0)
        over.triad(feet[number], rotation.T, length, names, theme.INK, f"S_{name}", offset)


def _out(data: MeshingFigure) -> FloatArray:
    """Return the vectors (2, 3) from the axes to the dimensions of the distances d_w, mm."""
    pinion, gear = (_radius(data, number, _cone_ends(data, number)[1]) for number in (0, 1))
    # The label of b_c is between the pinion and its d_w.
    return np.array([[-1.08 * pinion - 0.17 * data.pair.apart, 0.0, 0.0], [0.0, 1.36 * gear, 0.0]])


def _annotate_distance(over: Overlay, data: MeshingFigure, number: int) -> None:
    """Draw the distance d_w of the pitch point from the common perpendicular along the axis of one member: of
    the pinion on its far side, of the gear below it."""
    start, out, colour = data.feet[number], _out(data)[number], LINE_COLOURS[number]
    pitch = data.pair.foot[number] + data.mounting.pitch_distance[number] * data.pair.axis[number]
    style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING}
    if not data.is_short(float(data.mounting.pitch_distance[number])):
        for end in (start, pitch):
            over.line(end, end + 1.03 * out, color=colour, linewidth=0.9)
        name = f"$d_{{w{number + 1}}}$"
        offset = over.clear_offset(start + out, pitch + out, out, name, fontsize=theme.HEADING)
        over.dimension(start + out, pitch + out, name, offset, at=0.45, **style)
        if data.pair.nearer:
            over.broken(0.4 * start + 0.6 * pitch + out, pitch + out, colour)


def _annotate_member(over: Overlay, data: MeshingFigure, number: int, named: bool) -> None:
    """Draw b_c, radii and frame of one member, the axes of the frame with names if `named`."""
    foot, axis = data.pair.foot[number], data.pair.axis[number]
    colour, index = LINE_COLOURS[number], number + 1
    mounting = data.mounting
    middle, pitch = foot + mounting.distance[number] * axis, foot + mounting.pitch_distance[number] * axis
    style: dict[str, Any] = {"color": colour, "fontsize": theme.HEADING}
    near = np.array([(-1.08, 1.4)[number] * _radius(data, number, _cone_ends(data, number)[1]), 0.0, 0.0])
    shift = _drawn_shift(data, number)
    zero = middle - shift * axis
    if shift:
        for end in (zero, middle):
            over.line(end, end + 1.03 * near, color=colour, linewidth=0.9)
        name = f"$b_{{c{index}}}$"
        offset = over.clear_offset(zero + near, middle + near, near, name, fontsize=theme.HEADING)
        over.dimension(zero + near, middle + near, name, offset, **style)
    to_pitch, name = mounting.pitch_point - pitch, f"$r_{{w{index}}}$"
    over.arrow(pitch, mounting.pitch_point, theme.VERMILLION, 1.4)
    turn = data.pair.frames[number][0] @ np.array([0.0, 1.0, 0.0])
    # Another direction if the working radius has this one, or if the y axis of the frame is so close that
    # their labels could be exchanged.
    least_distance_pt = 16.0
    if data.in_line(number) or (shift and over.apart(zero, middle, turn) < least_distance_pt):
        turn = data.pair.frames[number][0] @ -np.sqrt([0.5, 0.5, 0.0])
    rim = zero + _radius(data, number, -shift) * turn
    over.arrow(zero, rim, colour, 1.4)
    # Each label is at the first place that is clear of the other radius.
    sides = [
        over.clear_offset(pitch, mounting.pitch_point, arrow, name, fontsize=theme.HEADING)
        for arrow in ((-axis, axis) if number == 0 else (axis, -axis))
    ]
    places = [(pitch + share * to_pitch, offset) for offset in sides for share in (0.66, 0.85, 0.3)]
    over.label_clear_of((zero, rim), name, places, color=theme.VERMILLION, fontsize=theme.HEADING)
    places = [(zero + share * (rim - zero), (right, 0.0)) for share in (0.6, 0.3) for right in (16.0, -16.0)]
    over.label_clear_of((pitch, mounting.pitch_point), f"$r_{{P{index}}}$", places, **style)
    also = f" = {{}}_{'fg'[number]}" if data.together(number) else ""
    names = tuple(f"{letter}_{index}{also.format(letter)}" if named else UNNAMED for letter in "xyz")
    length, offset = 0.17 * data.pair.apart, ((-14.0, 12.0), (14.0, -16.0))[number]
    title = f"S_{index}{also.format('S')}"
    over.triad(middle, data.pair.frames[number][0].T, length, names, colour, title, offset, to_pitch)


def _table(page: theme.Page, data: MeshingFigure, place: tuple[float, float, float, float]) -> None:
    """Draw the table in a part of the page: left, bottom, width and height as fractions."""
    rows_of = (
        ("$d_w$", data.mounting.pitch_distance),
        ("$b_c$", data.shift_distance),
        ("$r_w$", data.mounting.working_radius),
        ("$r_P$", data.reference_radius),
    )
    axes = theme.overlay(page, theme.place(page, *place))
    axes.set(xlim=(0.0, 1.0), ylim=(5.2, -0.6))
    style: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": theme.LABEL}
    for x, words, colour in ((0.62, "pinion", LINE_COLOURS[0]), (1.0, "gear", LINE_COLOURS[1])):
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
        *(
            (f"{m}_{name}", "mm", v[k])
            for k, m in enumerate(paths_table.MEMBERS)
            for name, v in named.items()
        ),
        *vector("pitch_point_{}_f", "mm", data.mounting.pitch_point),
        ("gap_of_lines_of_action", "mm", float(data.mounting.gap)),
    )


RECIPES = {"fig-04": Recipe(compute, draw, rows)}
