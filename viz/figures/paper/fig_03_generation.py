"""Fig. 3: frames of the rack cutter and the gear during generation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beveloid_geom import Design, Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.rack import reference_radius

from ...components import annotate, cutter, posed
from ...components.annotate import Overlay
from ...components.cutter import SectionFrame
from ...components.figure_steps import Drawing, Recipe, Table, quantities, vector
from ...rendering import theme
from ...rendering.scene import MESH_PX, Item, Picture, Surface, fit_camera

CUTTER_AXES_PITCH_RADII = 0.2
"""Length of the axes of S_c in panel (b), in pitch radii."""
GEAR_VIEW = np.array([0.22, 0.3, 0.92])
"""Direction to the viewer of panel (b)."""
FRAME_COLOURS = {"n": theme.INK, "P": theme.BLUE, "c": theme.GREEN, "b": theme.INK, "j": theme.VERMILLION}


@dataclass(frozen=True, eq=False)
class GenerationFigure:
    """Generation of a member.

    `drawn`: the member with the angles of panel (a). `profile` (n, 2): profile of the rack over five spaces,
    mm. `frames`: frames of the normal section of `drawn` and of `member`. `reference_radius`: radius r_P of
    the pitch circle of the generation, mm. `roll`: rad."""

    member: Member
    drawn: Member
    profile: FloatArray
    frames: tuple[SectionFrame, SectionFrame]
    reference_radius: float
    roll: float

    @property
    def slide(self) -> float:
        """Displacement of the rack, r_P phi, mm."""
        return self.reference_radius * self.roll

    @property
    def module(self) -> float:
        """Normal module, mm."""
        return float(self.member.tool.normal_module)

    @property
    def back(self) -> float:
        """Height of the back of the rack above its pitch line, mm."""
        return float(self.profile[:, 1].max()) + 0.9 * self.module

    @property
    def dimension_height(self) -> float:
        """Height of the dimension of the slide above the pitch line, mm, clear of rack and label of x_c."""
        x, y, z = GEAR_VIEW
        far_end_rise = x * z / (y * y + z * z) * float(self.member.face_width)
        rack_top = self.back + far_end_rise + 0.4 * self.module
        return float(max(rack_top, CUTTER_AXES_PITCH_RADII * self.reference_radius + 1.6 * self.module))


def compute(design: Design) -> GenerationFigure:
    """Compute the frames of the generation of the pinion."""
    # Smallest helix and cone angle in panel (a), rad, so that its frames can be distinguished.
    smallest_rad = np.radians((18.0, 15.0))
    # Roll in panel (b), in pitches of the gear.
    roll_pitches = 0.9
    member = design.pinion
    tool = cutter.fitting(member.tool)
    right, left = (cutter.half_profile(tool, flank) for flank in ("right", "left"))
    given = np.array((member.helix_angle, member.cone_angle), dtype=float)
    larger = np.copysign(np.maximum(np.abs(given), smallest_rad), given)
    helix, cone = np.where(given == 0.0, 0.0, larger).tolist()
    drawn = replace(member, helix_angle=helix, cone_angle=cone, profile_shift=0.0)
    return GenerationFigure(
        member=member,
        drawn=drawn,
        profile=cutter.profile(right, float(tool.normal_module), 5, left),
        frames=(cutter.cutter_frame(drawn), cutter.cutter_frame(member)),
        reference_radius=float(reference_radius(member)),
        roll=roll_pitches * 2.0 * np.pi / float(member.teeth),
    )


def draw(data: GenerationFigure, layout: theme.PageLayout) -> Drawing:
    """Draw panel (a): the rack and its frames, and panel (b): rack and gear at a roll."""
    angles = [np.degrees([float(m.helix_angle), float(m.cone_angle)]) for m in (data.member, data.drawn)]
    text = (
        "(b): pinion in true proportions. $S_b$ is fixed, $S_c$ moves with the rack and $S_j$ turns with the"
        " gear, by $-\\varphi$ about $z_b$; their origins are at mid-face and drawn at the end at +z."
    )
    changed = [
        (symbol, *(f"{angle:.4g}\u00b0".replace("-", "\u2212") for angle in (drawn, true)))
        for symbol, true, drawn in zip(("$\\beta$", "$\\gamma$"), *angles, strict=True)
        if drawn != true
    ]
    if changed:
        has = " and ".join(f"{symbol} = {drawn}" for symbol, drawn, _ in changed)
        text += f" (a) has {has} instead of {' and '.join(true for *_, true in changed)} for clarity."
    page, low, high = theme.new_page(
        layout,
        "Fig. 3   Frames of the generation by a rack cutter",
        "(a) normal section $S_n$, turned by the helix angle $\\beta$ to $S_P$ and by the cone angle"
        " $\\gamma$ to $S_c$;  (b) the rack moves while the gear rolls",
        text,
        above=0.35,
        tall=theme.stacked_height(layout, 5.6),
    )
    pictures = {}
    places = theme.pair_of_boxes(page, low, high, ((0.01, 0.46), (0.48, 0.51)), 0.35)
    for name, place, panel in zip("ab", places, (_rack_panel, _gear_panel), strict=True):
        x, y = place[0] + 0.24 / layout.width, place[1] + place[3]
        page.text(x, y, f"({name})", fontsize=theme.HEADING, fontweight="bold", va="bottom")
        pictures[name] = panel(page, theme.place(page, *place), data)
    return Drawing(page, pictures)


def _rack_panel(page: theme.Page, box: theme.PageBox, data: GenerationFigure) -> Picture:
    """Draw the rack with its normal section in front, its pitch plane, and S_n, S_P, S_c."""
    frame, module = data.frames[0], data.module
    length = 4.6 * module
    start = frame.axes[2]
    ends = (np.append(start, -length), np.append(start, 0.0))
    inner = data.profile[np.abs(data.profile[:, 0]) < 1.01 * np.pi * module]
    items: list[Item] = [*cutter.rack_block(inner, data.back, frame, ends)]
    corners = _plane_corners(data, length)
    items.append(Surface(corners, np.array([[0, 1, 2, 3]]), None, "#56b4e9", opacity=0.45))
    back = np.array([0.5, -0.3, 0.81])
    reach = np.concatenate([np.asarray(item.points) for item in items if isinstance(item, Surface)])
    # Labels take more of a narrow page, that of y_c most.
    axes = np.diag((6.6, 6.6 if page.layout.wide else 7.8, 6.6))
    reach = np.concatenate((reach, frame.axes * 4.8 * module, axes * module))
    over = Overlay.drawn(page, box, items, fit_camera(reach, -back, (1.0, 0.0, 0.0), box.size, 0.09))
    _annotate_rack(over, data, corners[3])
    return over.picture


def _plane_corners(data: GenerationFigure, length: float) -> FloatArray:
    """Return the corners (4, 3) of the pitch plane of the rack around the frames."""
    slope = np.array([np.sin(float(data.drawn.cone_angle)), 0.0, np.cos(float(data.drawn.cone_angle))])
    across, deep = np.array([0.0, 1.25 * np.pi * data.module, 0.0]), 0.95 * length * slope
    return np.stack((-across - deep, across - deep, across + deep, -across + deep))


def _annotate_rack(over: Overlay, data: GenerationFigure, corner: FloatArray) -> None:
    """Draw S_n, S_P and S_c, the angles between them, and the name of the pitch plane at its corner."""
    frame, module = data.frames[0], data.module
    sin, cos = np.sin(float(data.drawn.cone_angle)), np.cos(float(data.drawn.cone_angle))
    tilted = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    slope = tilted[2]
    # Axes that coincide without a cone or a helix angle share an arrow and a label.
    flat, straight = sin == 0.0, float(data.drawn.helix_angle) == 0.0
    x_c, x_n = ("x_c = x_P = x_n", "") if flat else ("x_c", "x_n = x_P")
    z_c, z_p = ("z_c = z_P", "") if flat else ("z_c", "z_P")
    if straight:
        z_c, z_p = (f"{z} = z_n" if "z_P" in z else z for z in (z_c, z_p))
    frames = (
        ("c", np.eye(3), 6.3, (x_c, "y_c = y_P", z_c)),
        ("P", tilted, 5.2, ("", "", z_p)),
        ("n", frame.axes, 4.4, (x_n and annotate.UNNAMED, "y_n", "" if straight else "z_n")),
    )
    for name, vectors, length, names in frames:
        over.triad(np.zeros(3), vectors, length * module, names, FRAME_COLOURS[name])
    if x_n:  # its label is on the side of the arrow away from x_c
        tips = np.stack((frame.axes[0], np.eye(3)[0])) * 4.4 * module
        away = float(np.sign(np.subtract(*over.picture.project(tips))[0])) or 1.0
        over.label(tips[0], f"${x_n}$", (7.0 * away, 4.0), ha="left" if away > 0.0 else "right")
    label = frame.origin + module * (0.2 * frame.axes[0] - 1.57 * frame.axes[1])
    over.label(label, "rack\ncutter")
    over.note(corner, "pitch plane of the rack", (30.0, -28.0))
    wide = over.axes.get_window_extent().width > 6.5 * over.axes.figure.dpi
    for first, second, radius, words, colour in (
        (slope, frame.axes[2], 3.4, "$\\beta$", theme.BLUE),
        ((0.0, 0.0, 1.0), slope, 4.6, "$\\gamma$", theme.GREEN),
    ):
        curve = annotate.arc(np.zeros(3), first, second, radius * module)
        if np.linalg.norm(curve[-1] - curve[0]) > 0.05 * module:
            over.arrow_along(curve, colour)
            outward = (0.6 if wide else 0.9) * module * curve[16] / np.linalg.norm(curve[16])
            over.label(curve[16] + outward, words, color=colour, fontsize=theme.HEADING)


def _gear_panel(page: theme.Page, box: theme.PageBox, data: GenerationFigure) -> Picture:
    """Draw in S_b the gear turned by -phi and the rack displaced by -r_P phi."""
    teeth_drawn = 7
    member, half = data.member, 0.5 * float(data.member.face_width)
    origin = np.array([data.reference_radius, -data.slide, 0.0])
    frame = SectionFrame(origin + data.frames[1].origin, data.frames[1].axes)
    plane = np.array([0.0, 0.0, 1.0])
    ends = (np.append(plane, -half), np.append(plane, half))
    inner = data.profile[np.abs(data.profile[:, 0]) < 2.0 * np.pi * data.module]
    items: list[Item] = [*cutter.rack_block(inner, data.back, frame, ends)]
    reach = [np.asarray(item.points) for item in items if isinstance(item, Surface)]
    count = min(teeth_drawn, int(member.teeth))
    side = np.linspace(-1.0, 1.0, 9) * np.pi * count / float(member.teeth)
    rim = (data.reference_radius + data.module) * np.stack((np.cos(side), np.sin(side), 0.0 * side), axis=-1)
    above = np.array([[data.reference_radius + data.dimension_height + data.module, 0.0, half]])
    shown = np.concatenate((*reach, rim + half * plane, rim - half * plane, above, np.zeros((1, 3))))
    camera = fit_camera(shown, -GEAR_VIEW, (1.0, 0.0, 0.0), box.size, 0.07)
    items += _gear_items(data, count, MESH_PX * camera.mm_per_px(box.size))
    over = Overlay.drawn(page, box, items, camera)
    _annotate_gear(over, data)
    return over.picture


def _gear_items(data: GenerationFigure, count: int, tolerance: float) -> list[Item]:
    """Return some teeth near the rack, or a blank if teeth cannot be drawn."""
    face_colour = "#d3dce4"
    frame = posed.turn_about_axis(-data.roll), np.zeros(3)
    first = round(data.roll * float(data.member.teeth) / (2.0 * np.pi)) - count // 2
    bore = 0.1 * data.reference_radius
    teeth = range(first, first + count)
    return [*posed.gear_items(data.member, frame, tolerance, (theme.METALS[0], face_colour), bore, teeth)[0]]


def _annotate_gear(over: Overlay, data: GenerationFigure) -> None:
    """Draw pitch circle and pitch line, S_b, S_j and S_c, roll and displacement."""
    radius, roll = data.reference_radius, data.roll
    place = np.array([0.0, 0.0, 0.5 * float(data.member.face_width)])
    turned = posed.turn_about_axis(roll)
    length = 0.33 * radius
    x, y = np.eye(3)[:2]
    pitch = place + radius * x
    slid = pitch - data.slide * y
    side = np.linspace(-0.28, 0.28, 41) - 0.5 * roll
    rim = place + radius * np.stack((np.cos(side), np.sin(side), 0.0 * side), axis=-1)
    over.line(rim, color=theme.INK, linewidth=1.4, dashes=(12, 3, 2, 3))
    line = np.stack((slid + 2.4 * np.pi * data.module * y, slid - 2.4 * np.pi * data.module * y))
    rimmed: dict[str, Any] = {"linewidth": 1.4, "path_effects": annotate.rim(1.4)}
    over.line(line, color=FRAME_COLOURS["c"], dashes=(12, 3, 2, 3), **rimmed)
    over.dimension(place, pitch, f"$r_P$ = {radius:.5g} mm", (-8.0, 0.0), at=0.62, ha="right")
    over.line(place, place + radius * turned[0], color=theme.VERMILLION, **rimmed)
    curve = annotate.arc(place, x, turned[0], 0.55 * radius)
    over.arrow_along(curve, theme.VERMILLION)
    over.label(curve[16], "$\\varphi$", (0.0, 12.0), color=theme.VERMILLION, fontsize=theme.HEADING)
    over.triad(place, np.eye(3), length, ("x_b", "y_b", "z_b = z_j"), FRAME_COLOURS["b"], "S_b")
    over.triad(place, turned, length, ("x_j", "y_j", ""), FRAME_COLOURS["j"], "S_j", (18.0, 20.0))
    names = ("x_c", "y_c", "z_c")
    over.triad(
        slid, np.eye(3), CUTTER_AXES_PITCH_RADII * radius, names, FRAME_COLOURS["c"], "S_c", (20.0, 12.0)
    )
    above = data.dimension_height * x
    for end in (pitch, slid):
        over.line(end, end + 1.05 * above, color=theme.BLUE, linewidth=1.0)
    words = f"$r_P\\varphi$ = {data.slide:.4g} mm"
    style: dict[str, Any] = {"color": theme.BLUE, "fontsize": theme.HEADING}
    over.dimension(pitch + above, slid + above, words, (0.0, 14.0), **style)


def rows(data: GenerationFigure) -> Table:
    """List the frames and the numbers of both panels."""
    axes = zip("xyz", data.frames[1].axes, strict=True)
    return quantities(
        ("helix_angle", "rad", float(data.member.helix_angle)),
        ("cone_angle", "rad", float(data.member.cone_angle)),
        ("helix_angle_drawn_in_a", "rad", float(data.drawn.helix_angle)),
        ("cone_angle_drawn_in_a", "rad", float(data.drawn.cone_angle)),
        ("pitch_radius", "mm", data.reference_radius),
        ("roll_in_b", "rad", data.roll),
        ("slide_in_b", "mm", data.slide),
        *(line for letter, axis in axes for line in vector(f"{letter}_n_along_{{}}_c", "1", axis)),
    )


RECIPES = {"fig-03": Recipe(compute, draw, rows)}
