"""Fig. 1: the pair in mesh, with shafts and axes, and a section through the contact point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from beveloid_geom import Design, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import gear_mesh

from ...parts import annotate, posed, solved
from ...parts.annotate import Overlay
from ...parts.posed import PosedPair
from ...parts.recipe import Drawing, Recipe, Table, quantities, vector
from ...stage import theme
from ...stage.scene import MESH_PX, Camera, Item, Size, cut, fit_camera

FACES = ("#c9d3dc", "#e4d7bd")
"""Toe and heel, a little lighter than the teeth."""
SECTION_TALL = 3.6
"""Inches for the section, on a page so narrow that it stands under the pair."""
SECTION_SHARES = 0.25, 0.31
"""Width and height of the section on a wider page, shares of it."""
SECTION_MODULES = 3.2
"""Half the width of the section shown, in normal modules."""
SECTION_TOLERANCE = 0.003
"""Of the section, in normal modules: less than a pixel."""


@dataclass(frozen=True, eq=False)
class PairFigure:
    """The pair as posed, and where its flanks touch both members cut by one plane through the contact point:
    outlines (n, 3) in S_f of each; what is to the right and upwards (2, 3), the common normal downwards."""

    pair: PosedPair
    flank: str
    axes: FloatArray
    sections: tuple[list[FloatArray], ...]


def compute(design: Design, flank: str = "right") -> PairFigure:
    """Find the pair with its flanks touching in the middle of their path."""
    pair = posed.pose(design, flank)
    if not pair.touching:
        return PairFigure(pair, flank, np.full((2, 3), np.nan), ())
    normal = path_of_contact(design, flank, 3).normal[1]
    along = pair.axis.sum(axis=0)
    along -= (along @ normal) * normal
    along /= np.linalg.norm(along)
    sections = []
    for member, frame in zip(design.members, pair.frames, strict=True):
        try:
            mesh = gear_mesh(
                member,
                SECTION_TOLERANCE * float(member.tool.normal_module),
                bore_radius=posed.shaft_radius(member),
            )
        except ValueError:
            break
        sections.append(cut(posed.surface(mesh, frame, ""), pair.contact, along))
    return PairFigure(pair, flank, np.stack((np.cross(normal, along), -normal)), tuple(sections))


def _ends(pair: PosedPair) -> FloatArray:
    """Say where each shaft starts and ends along its axis, (2, 2) mm from the common perpendicular."""
    half = 0.5 * np.array([float(member.face_width) for member in pair.design.members])
    over = 0.2 * pair.apart
    return np.stack((pair.position - half - over, pair.position + half + over), axis=-1)


def camera_of(pair: PosedPair, size: Size) -> Camera:
    """Make the camera that shows the whole pair in a picture of this size; of a pair without its common
    perpendicular turned so that it is largest there."""
    reach, turn = posed.reach(pair, feet=not pair.remote), posed.turn_about_axis(0.5 * np.pi)
    usual = fit_camera(reach, posed.VIEW, posed.UP, size, 0.06)
    if not pair.remote:
        return usual
    turned = fit_camera(reach, turn @ posed.VIEW, turn @ posed.UP, size, 0.06)
    return min(usual, turned, key=lambda camera: camera.half_height)


def items_of(pair: PosedPair, tolerance: float) -> tuple[list[Item], list[str]]:
    """Make gears to a tolerance (mm) and shafts, and remarks on what could not be drawn."""
    items: list[Item] = []
    remarks = []
    lengths = _ends(pair) - pair.position[:, None]
    for number, (member, frame) in enumerate(zip(pair.design.members, pair.frames, strict=True)):
        bore = posed.shaft_radius(member)
        gear, reason = posed.gear_items(member, frame, tolerance, (theme.METALS[number], FACES[number]), bore)
        if reason:
            remarks.append(f"The {solved.MEMBERS[number]} is drawn without teeth: {reason}.")
        items += [*gear, *posed.shaft(frame, bore, *lengths[number].tolist())]
    return items, remarks


def draw(data: PairFigure, layout: theme.Layout) -> Drawing:
    """Draw both gears on their shafts, and the section through the contact point."""
    pair = data.pair
    page, _, high = theme.new_page(
        layout,
        f"Fig. 1   The {'crossed ' if pair.crossed else ''}beveloid gear pair in mesh",
        f"Whole gears on their shafts, posed with the {data.flank} flanks in contact: {_layout_words(pair)}",
        "",
        tall=6.6 if layout.width > theme.NARROW else 4.4 + SECTION_TALL,
    )
    low = theme.inches(page, 0.72 if not layout.printed else theme.AROUND)
    if layout.width > theme.NARROW:
        box = theme.place(page, 0.14, low, 0.83, high - low)
    else:
        over = low + theme.inches(page, SECTION_TALL)
        box = theme.place(page, 0.02, over, 0.96, high - over)
    camera = camera_of(pair, box.size)
    items, remarks = items_of(pair, MESH_PX * camera.mm_per_px(box.size))
    pose = (
        f"Rolls are those in the middle of the {data.flank} flanks' path of contact, the pinion drives. "
        if pair.touching
        else f"The {data.flank} flanks share no contact point as mounted; the rolls are nominal ones. "
    )
    theme.caption(page, pose + "Heels are the ends at +z, to which a tooth grows. " + " ".join(remarks))
    view = Overlay.drawn(page, box, items, camera)
    _draw_axes(view, pair)
    room = annotate.Room(view.axes)
    if pair.touching and len(data.sections) == 2:
        corner = _free_corner(page, room)
        if layout.width < theme.NARROW:
            corner = theme.place(page, 0.25, low, 0.5, theme.inches(page, SECTION_TALL - 0.8))
        room.take(corner)
        _draw_section(page, corner, data)
    _name(view, room, pair, layout.width < theme.NARROW)
    return Drawing(page, {"pair": view.picture})


def _layout_words(pair: PosedPair) -> str:
    """Say what is drawn of the layout, or its numbers where it is not."""
    if not pair.remote:
        return "offset $E$ between the axes, shaft angle $\\delta$"
    away = abs(float(pair.position[0]))
    nearest = f"{pair.foot[1, 0]:g} mm apart where nearest, {away:.0f} mm from here"
    return f"axes at {_degrees(pair):.4g}\u00b0, {nearest}"


def _draw_axes(over: Overlay, pair: PosedPair) -> None:
    """Draw axes, and offset and shaft angle if they are near."""
    ends = _ends(pair)
    low, high = np.minimum(0.0, 1.02 * ends[:, 0]), ends[:, 1] + 0.1 * pair.apart
    if pair.remote:
        low = ends[:, 0] - 0.1 * pair.apart
    for foot, axis, first, last in zip(pair.foot, pair.axis, low, high, strict=True):
        over.axis(foot + first * axis, foot + last * axis, theme.INK)
    if not pair.remote:
        _annotate_layout(over, pair, 0.65 * abs(float(ends[1, 0])))


def _name(over: Overlay, room: annotate.Room, pair: PosedPair, narrow: bool) -> None:
    """Name members, toes and heels where there is room; in more lines where the page is narrow."""
    right, up, _ = over.picture.camera.axes
    for number, member in enumerate(pair.design.members):
        toe, heel = to_fixed(pair.frames[number], posed.rings(member))
        kind = _kind(pair, number).replace(", ", "\n" if narrow else ", ")
        for ring, words, way, offset in (
            (toe, "toe", 0.3 * up - right, (-24.0, 6.0)),
            (heel, "heel", up, (-4.0, 22.0)),
            (heel, kind, right + up, (26.0, 30.0)),
        ):
            near = ring[np.argsort(-(ring @ way))]
            room.note(over.picture.project(near), over.picture.project(ring[:-1].mean(axis=0)), words, offset)


def _degrees(pair: PosedPair) -> float:
    return float(np.degrees(np.arccos(np.clip(pair.axis[0] @ pair.axis[1], -1.0, 1.0))))


def _annotate_layout(over: Overlay, pair: PosedPair, reach: float) -> None:
    """Draw offset, and shaft angle at a `reach` (mm) from it."""
    words = f"$E$ = {pair.foot[1, 0]:g} mm"
    style: dict[str, Any] = {"color": theme.BLUE, "fontsize": theme.HEADING, "ha": "right", "va": "top"}
    over.dimension(pair.foot[0], pair.foot[1], words, (-4.0, -6.0), at=0.6, **style)
    words = f"$\\delta$ = {_degrees(pair):.4g}\u00b0"
    over.angle(pair.foot[1], pair.axis[0], pair.axis[1], reach, words, (1.2, 0.75), (-6.0, 2.0))


def _kind(pair: PosedPair, member: int) -> str:
    one = pair.design.members[member]
    angle, cone = float(np.degrees(one.helix_angle)), float(np.degrees(one.cone_angle))
    hand = "right hand" if angle > 0.0 else "left hand" if angle < 0.0 else "straight"
    angles = f"helix {angle:g}\u00b0, cone {cone:g}\u00b0".replace("-", "\u2212")
    return f"{solved.MEMBERS[member]}\n{int(one.teeth)} teeth, {hand}\n{angles}"


def _free_corner(page: theme.Page, room: annotate.Room) -> theme.Box:
    """Find the box for the section: in the corner of the page where it hides least, a little smaller where
    that is less."""
    width, height = SECTION_SHARES
    sizes = [(size * width, size * height) for size in (1.0, 0.9, 0.8)]
    boxes = [
        theme.place(page, x, y, across, up)
        for across, up in sizes
        for x in (0.026, 0.974 - across)
        for y in (0.085, 0.86 - up)
    ]
    return min(boxes, key=room.hides)


def _draw_section(page: theme.Page, box: theme.Box, data: PairFigure) -> None:
    """Draw both members cut by one plane, the common normal out of the pinion downwards."""
    pair = data.pair
    axes = theme.overlay(page, box)
    half = SECTION_MODULES * float(pair.design.pinion.tool.normal_module)
    for found, colour in zip(data.sections, theme.METALS, strict=True):
        for outline in found:
            seen = data.axes @ (outline - pair.contact).T
            axes.fill(*seen, facecolor=colour, edgecolor=theme.INK, linewidth=1.4)
    axes.annotate("", (0.0, -0.55 * half), (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": theme.RED})
    axes.plot(0.0, 0.0, "o", ms=8, color=theme.RED)
    high = half * box.height / box.width
    axes.set_axis_on()
    axes.set(xlim=(-half, half), ylim=(-high, high), xticks=[], yticks=[])
    axes.spines[:].set(visible=True, color=theme.GREY, linewidth=1.0)
    axes.set_title("Section that holds the common normal", fontsize=theme.SMALL)
    annotate.text(axes, (-0.75 * half, 0.1 * high), "pinion")
    annotate.text(axes, (0.75 * half, -0.1 * high), "gear")
    annotate.text(axes, (0.0, 0.0), "contact", (0.0, 18.0), color=theme.RED, fontsize=theme.SMALL)
    length = theme.round_length(0.6 * half)
    axes.plot([0.9 * half - length, 0.9 * half], 2 * [-0.9 * high], color=theme.INK, linewidth=3.0)
    middle = 0.9 * half - 0.5 * length, -0.9 * high
    annotate.text(axes, middle, f"{length:g} mm", (0.0, 9.0), fontsize=theme.SMALL)


def rows(data: PairFigure) -> Table:
    """List layout, members and pose."""
    pair, members = data.pair, data.pair.design.members
    named = (
        ("teeth", "1", [member.teeth for member in members]),
        ("helix_angle", "rad", [member.helix_angle for member in members]),
        ("cone_angle", "rad", [member.cone_angle for member in members]),
        ("mounting", "mm", pair.position),
        ("roll", "rad", pair.roll),
    )
    return quantities(
        ("offset", "mm", pair.foot[1, 0]),
        ("shaft_angle", "rad", float(np.arccos(np.clip(pair.axis[0] @ pair.axis[1], -1.0, 1.0)))),
        *(
            (f"{m}_{name}", unit, float(v[k]))
            for k, m in enumerate(solved.MEMBERS)
            for name, unit, v in named
        ),
        *vector("contact_{}_f", "mm", pair.contact),
    )


RECIPES = {"fig-01": Recipe(compute, draw, rows)}
