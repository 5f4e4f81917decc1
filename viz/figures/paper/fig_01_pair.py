"""Fig. 1: the pair in mesh with shafts and axes, and a section through the contact point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.path import Path as Outline

from beveloid_geom import Design, path_of_contact
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.design.ends import end_names
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import gear_mesh

from ...components import annotate, paths_table, posed
from ...components.annotate import Overlay
from ...components.figure_steps import Drawing, Recipe, Table, quantities, vector
from ...components.free_space import FreeSpace
from ...components.posed import PosedPair
from ...rendering import theme
from ...rendering.polylines import dashed
from ...rendering.scene import MESH_PX, Camera, Item, Size, Tube, cut, fit_camera


@dataclass(frozen=True, eq=False)
class PairFigure:
    """The pair as posed, and its section through the contact point.

    `sections`: outlines (n, 3) in S_f of both members, cut by a plane that contains the common normal. `axes`
    (2, 3): directions to the right and upwards in the section; the common normal points downwards."""

    pair: PosedPair
    flank: str
    axes: FloatArray
    sections: tuple[list[FloatArray], ...]


def compute(design: Design, flank: str = "right") -> PairFigure:
    """Compute the pair with its flanks in contact in the middle of the path."""
    # Mesh tolerance of the section, in normal modules; less than a pixel.
    section_tolerance_modules = 0.003
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
            tolerance = section_tolerance_modules * float(member.tool.normal_module)
            mesh = gear_mesh(member, tolerance, bore_radius=posed.shaft_radius(member))
        except ValueError:
            break
        sections.append(cut(posed.placed_surface(mesh, frame, ""), pair.contact, along))
    return PairFigure(pair, flank, np.stack((np.cross(normal, along), -normal)), tuple(sections))


def _ends(pair: PosedPair) -> FloatArray:
    """Return the ends of each shaft along its axis, (2, 2), mm from the common perpendicular."""
    half, over = pair.half_widths, 0.2 * pair.apart
    return np.stack((pair.position - half - over, pair.position + half + over), axis=-1)


def camera_of(pair: PosedPair, size: Size) -> Camera:
    """Return the camera that shows the complete pair in a picture of this size.

    If the common perpendicular is far away and not drawn, the pair may be turned, so that it is shown
    larger."""
    # Viewing direction in S_f, for which the common perpendicular of Table 1 ends next to the gear.
    view = np.array([-0.62, 0.46, 0.6])
    reach, turn = posed.reach(pair, feet=False), posed.turn_about_axis(0.5 * np.pi)
    if not pair.remote:
        reach = np.concatenate((reach, _feet(pair)))
    usual = fit_camera(reach, view, posed.UP, size, 0.06, perspective=True)
    if not pair.remote:
        return usual
    turned = fit_camera(reach, turn @ view, turn @ posed.UP, size, 0.06, perspective=True)
    return min(usual, turned, key=lambda camera: camera.half_height)


def items_of(pair: PosedPair, tolerance: float) -> tuple[list[Item], list[str]]:
    """Return gears within a tolerance (mm) and shafts, and remarks on members that cannot be drawn."""
    # Colours of the end faces of pinion and gear.
    face_colours = ("#c9d3dc", "#e4d7bd")
    items: list[Item] = []
    remarks = []
    lengths = _ends(pair) - pair.position[:, None]
    for number, (member, frame) in enumerate(zip(pair.design.members, pair.frames, strict=True)):
        bore = posed.shaft_radius(member)
        colours = theme.METALS[number], face_colours[number]
        gear, reason = posed.gear_items(member, frame, tolerance, colours, bore)
        if reason:
            remarks.append(f"The {paths_table.MEMBERS[number]} is drawn without teeth: {reason}.")
        items += [*gear, *posed.shaft(frame, bore, *lengths[number].tolist())]
    return items, remarks


def draw(data: PairFigure, layout: theme.PageLayout) -> Drawing:
    """Draw both gears on their shafts, and the section through the contact point."""
    # Half the width of the axes, points.
    axis_half_width_pt = 0.65
    # Height of the section below the pair on a narrow page, inches.
    section_height_in = 3.6
    pair = data.pair
    page, _, high = theme.new_page(
        layout,
        f"Fig. 1   The {'crossed ' if pair.crossed else ''}beveloid gear pair in mesh",
        f"The {data.flank} flanks are in contact; {_layout_words(pair)}",
        "",
        tall=6.6 if layout.wide else 4.4 + section_height_in,
    )
    low = theme.inches(page, 0.72 if not layout.printed else theme.UNUSED_SPACE_IN)
    if layout.wide:
        box = theme.place(page, 0.14, low, 0.83, high - low)
    else:
        over = low + theme.inches(page, section_height_in)
        box = theme.place(page, 0.02, over, 0.96, high - over)
    camera = camera_of(pair, box.size)
    items, remarks = items_of(pair, MESH_PX * camera.mm_per_px(box.size))
    pose = (
        f"Drawn at the middle of the path of contact of the {data.flank} flanks. The pinion drives."
        " Perspective; the scale bar holds at the contact. Arrow in the section: normal of the pinion flank. "
        if pair.touching
        else f"The {data.flank} flanks have no contact point in this mounting; roll angles are nominal. "
    )
    theme.caption(page, pose + _ends_words(pair.design) + " ".join(remarks))
    items += _axis_items(pair, axis_half_width_pt * camera.mm_per_px(box.size) * page.dpi / 72.0)
    view = Overlay.drawn(page, box, items, camera)
    if not pair.remote:
        _annotate_layout(view, pair, 0.65 * abs(float(_ends(pair)[1, 0])))
    _draw_scale(view, box, pair)
    free_space = FreeSpace(view.axes)
    if pair.touching and len(data.sections) == 2:
        corner = _free_corner(page, free_space)
        if not layout.wide:
            corner = theme.place(page, 0.25, low, 0.5, theme.inches(page, section_height_in - 0.8))
        free_space.take(corner)
        _draw_section(page, corner, data)
    _name(view, free_space, pair, not layout.wide)
    return Drawing(page, {"pair": view.picture})


def _ends_words(design: Design) -> str:
    """Return sentences that explain the names of the ends of the faces."""
    cylindrical = [end_names(member) == ("back", "front") for member in design.members]
    words = "" if all(cylindrical) else "Heels are the large ends of teeth. "
    if any(cylindrical):
        words += "Cylindrical gears have their front at +z. "
    return words


def _layout_words(pair: PosedPair) -> str:
    """Return the text on the layout, with the symbols of offset and shaft angle if they are drawn."""
    offset = f"offset $E$ = {pair.foot[1, 0]:.4g}\u00a0mm"
    if pair.parallel:
        return f"{offset}, parallel axes"
    if not pair.remote:
        return f"{offset}, shaft angle $\\delta$ = {_degrees(pair):.4g}\u00b0"
    away = abs(float(pair.position[0]))
    nearest = f"shortest distance {pair.foot[1, 0]:g}\u00a0mm, {away:.0f}\u00a0mm from the members"
    return f"axes at {_degrees(pair):.4g}\u00b0, {nearest}"


def _feet(pair: PosedPair) -> FloatArray:
    """Return the ends (2, 3) of the common perpendicular, mm; on parallel axes in front of the shafts."""
    ahead = float(_ends(pair).min()) - 0.1 * pair.apart if pair.parallel else 0.0
    return pair.foot + ahead * pair.axis


def _axis_items(pair: PosedPair, radius: float) -> list[Item]:
    """Return the axes as dash-dotted tubes of a radius, mm, so that solid parts hide them."""
    ends = _ends(pair)
    low, high = ends[:, 0] - 0.1 * pair.apart, ends[:, 1] + 0.1 * pair.apart
    if not pair.remote:
        low = np.minimum(low, ((_feet(pair) - pair.foot) * pair.axis).sum(axis=1))
    pattern = [2.0 * radius * length for length in annotate.CENTRE_LINE["dashes"]]
    return [
        Tube(piece, theme.INK, radius)
        for foot, axis, first, last in zip(pair.foot, pair.axis, low, high, strict=True)
        for piece in dashed(np.stack((foot + first * axis, foot + last * axis)), pattern)
    ]


def _draw_scale(over: Overlay, box: theme.PageBox, pair: PosedPair) -> None:
    """Draw a scale bar at the lower right, for the depth of the contact."""
    camera = over.picture.camera
    at = pair.contact if pair.touching else camera.focal_point
    ends = over.picture.project(np.stack((at, at + camera.axes[0])))
    px_per_mm = float(ends[1, 0] - ends[0, 0])
    length = theme.round_length(0.12 * box.width / px_per_mm)
    theme.scale_bar(over.axes, 0.98 * box.width - length * px_per_mm, 0.96 * box.height, px_per_mm, length)


def _name(over: Overlay, free_space: FreeSpace, pair: PosedPair, narrow: bool) -> None:
    """Label members and ends of faces where there is space, in more lines on a narrow page."""
    right, up, _ = over.picture.camera.axes
    rings = [to_fixed(*both) for both in zip(pair.frames, map(posed.rings, pair.design.members), strict=True)]
    for number, member in enumerate(pair.design.members):
        (back, front), names = rings[number], end_names(member)
        seen_back, seen_front = (
            points[~_covered(over, points, rings[1 - number])]
            for points in (_visible(over, back, front), _visible(over, front, back))
        )
        kind = _kind(pair, number).replace(", ", "\n" if narrow else ", ")
        for ring, points, words, direction, offset in (
            (back, seen_back, names[0], 0.3 * up - right, (-24.0, 6.0)),
            (front, seen_front, names[1], up, (-4.0, 22.0)),
            (front, seen_front if len(seen_front) else seen_back, kind, right + up, (26.0, 30.0)),
        ):
            if not len(points):  # this end is behind the other member
                continue
            near = points[np.argsort(-(points @ direction))]
            middle = over.picture.project(ring[:-1].mean(axis=0))
            free_space.note(over.picture.project(near), middle, words, offset)


def _visible(over: Overlay, ring: FloatArray, other: FloatArray) -> FloatArray:
    """Return the points of the tip circle at one end of a gear that are clear of the other end in the
    picture; all points of the end that is closer to the viewer."""
    # Smallest distance from the outline of the other end, as a fraction of the largest one.
    clear_share = 0.25
    if (ring.mean(axis=0) - other.mean(axis=0)) @ over.picture.camera.direction <= 0.0:
        return ring
    points, outline = over.picture.project(ring), over.picture.project(other)
    distance = np.linalg.norm(points[:, None] - outline, axis=-1).min(axis=1)
    distance[Outline(outline).contains_points(points)] = 0.0
    return np.asarray(ring[distance >= clear_share * distance.max()])


def _covered(over: Overlay, points: FloatArray, ends: FloatArray) -> Mask:
    """Return a mask of the points (n, 3) behind one of the `ends` (2, m, 3) of the other member."""
    camera = over.picture.camera
    viewer = camera.focal_point + camera.distance * camera.axes[2]
    covered = np.zeros(len(points), dtype=bool)
    for ring in ends:
        middle = ring[:-1].mean(axis=0)
        normal = np.cross(ring[0] - middle, ring[len(ring) // 4] - middle)
        depth, height = (viewer - points) @ normal, (middle - points) @ normal
        share = height / np.where(depth == 0.0, np.inf, depth)  # of the line to the viewer, up to the end
        at = points + share[:, None] * (viewer - points)
        radius = np.linalg.norm(ring[0] - middle)
        covered |= (share > 0.0) & (share < 1.0) & (np.linalg.norm(at - middle, axis=1) < radius)
    return covered


def _degrees(pair: PosedPair) -> float:
    return float(np.degrees(np.arccos(np.clip(pair.axis[0] @ pair.axis[1], -1.0, 1.0))))


def _annotate_layout(over: Overlay, pair: PosedPair, reach: float) -> None:
    """Draw the offset, and the shaft angle, if it is not zero, at a distance `reach` (mm) from it."""
    feet = _feet(pair)
    style: dict[str, Any] = {"color": theme.BLUE, "fontsize": theme.HEADING, "ha": "right", "va": "top"}
    over.dimension(feet[0], feet[1], "$E$", (-4.0, -6.0), at=0.6, **style)
    if pair.parallel:
        return
    over.angle(pair.foot[1], pair.axis[0], pair.axis[1], reach, "$\\delta$", (1.2, 0.75), (-6.0, 2.0))


def _kind(pair: PosedPair, member: int) -> str:
    one = pair.design.members[member]
    angle, cone = float(np.degrees(one.helix_angle)), float(np.degrees(one.cone_angle))
    hand = "right hand" if angle > 0.0 else "left hand" if angle < 0.0 else "straight"
    angles = f"helix {angle:g}\u00b0, cone {cone:g}\u00b0".replace("-", "\u2212")
    return f"{paths_table.MEMBERS[member]}\n{int(one.teeth)} teeth, {hand}\n{angles}"


def _free_corner(page: theme.Page, free_space: FreeSpace) -> theme.PageBox:
    """Return the box of the section: the corner and size that hide least of the picture."""
    # Width and height of the section on a wide page, as fractions of the page.
    width, height = 0.25, 0.31
    sizes = [(size * width, size * height) for size in (1.0, 0.9, 0.8)]
    boxes = [
        theme.place(page, x, y, across, up)
        for across, up in sizes
        for x in (0.026, 0.974 - across)
        for y in (0.085, 0.86 - up)
    ]
    return min(boxes, key=free_space.hides)


def _draw_section(page: theme.Page, box: theme.PageBox, data: PairFigure) -> None:
    """Draw the section of both members; the common normal of the pinion points downwards."""
    # Half the width of the section, in normal modules.
    section_half_width_modules = 3.2
    pair = data.pair
    axes = theme.overlay(page, box)
    half = section_half_width_modules * float(pair.design.pinion.tool.normal_module)
    for outlines, colour in zip(data.sections, theme.METALS, strict=True):
        for outline in outlines:
            seen = data.axes @ (outline - pair.contact).T
            axes.fill(*seen, facecolor=colour, edgecolor=theme.INK, linewidth=1.4)
    axes.annotate(
        "", (0.0, -0.55 * half), (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": theme.VERMILLION}
    )
    axes.plot(0.0, 0.0, "o", ms=8, color=theme.VERMILLION)
    high = half * box.height / box.width
    axes.set_axis_on()
    axes.set(xlim=(-half, half), ylim=(-high, high), xticks=[], yticks=[])
    axes.spines[:].set(visible=True, color=theme.GREY, linewidth=1.0)
    axes.set_title("Section through the common normal", fontsize=theme.SMALL)
    annotate.text(axes, (-0.75 * half, 0.1 * high), "pinion")
    annotate.text(axes, (0.75 * half, -0.1 * high), "gear")
    annotate.text(axes, (0.0, 0.0), "contact", (0.0, 18.0), fontsize=theme.SMALL)
    length = theme.round_length(0.6 * half)
    axes.plot([0.9 * half - length, 0.9 * half], 2 * [-0.9 * high], color=theme.INK, linewidth=3.0)
    middle = 0.9 * half - 0.5 * length, -0.9 * high
    annotate.text(axes, middle, f"{length:g} mm", (0.0, 9.0), fontsize=theme.SMALL)


def rows(data: PairFigure) -> Table:
    """List layout, members and rolls."""
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
            for k, m in enumerate(paths_table.MEMBERS)
            for name, unit, v in named
        ),
        *vector("contact_{}_f", "mm", pair.contact),
    )


RECIPES = {"fig-01": Recipe(compute, draw, rows)}
