"""Fig. 1: the pair in mesh, with shafts and axes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom.assembly import to_fixed
from beveloid_geom.inputs import Design, FloatArray

from .. import theme
from ..recipe import Drawing, Recipe, Table
from ..scene import Camera, Item, Picture, Scene, Tube, fit_camera, render
from . import annotate, posed
from .posed import PosedPair

COLOURS = (theme.STEEL, theme.BRONZE)
SHAFT = "#8d959d"
CLOSE_UP = 4.2
"""Half the height of the close-up in normal modules."""


def compute(design: Design) -> PosedPair:
    """The pair with its right flanks touching in the middle of their path."""
    return posed.pose(design)


def _ends(pair: PosedPair) -> FloatArray:
    """Where each shaft starts and ends along its axis, (2, 2) mm from the common perpendicular."""
    half = 0.5 * np.array([float(member.face_width) for member in pair.design.members])
    over = 0.2 * float(pair.foot[1, 0])
    return np.stack((pair.position - half - over, pair.position + half + over), axis=-1)


def _reach(pair: PosedPair) -> FloatArray:
    """Points (n, 3) in S_f that the picture must show."""
    tips = [
        to_fixed(frame, posed.rings(member)).reshape(-1, 3)
        for frame, member in zip(pair.frames, pair.design.members, strict=True)
    ]
    ends = pair.foot[:, None] + _ends(pair)[..., None] * pair.axis[:, None]
    return np.concatenate((*tips, ends.reshape(-1, 3)))


def _items(pair: PosedPair, px_per_mm: float, shafts: bool) -> tuple[list[Item], list[str]]:
    """Gears and shafts, and remarks on what could not be drawn."""
    items: list[Item] = []
    remarks = []
    for member, name, frame, colour, position, ends in zip(
        pair.design.members, posed.NAMES, pair.frames, COLOURS, pair.position, _ends(pair), strict=True
    ):
        bore = posed.shaft_radius(member)
        mesh, reason = posed.teeth_of(member, 0.35 / px_per_mm, bore_radius=bore)
        if mesh is None:
            remarks.append(f"The {name} is drawn without teeth: {reason}.")
            items += posed.blank(member, frame, colour, bore)
        else:
            items.append(posed.surface(mesh, frame, colour))
        if shafts:
            items += posed.shaft(frame, bore, *(ends - position), SHAFT)
    return items, remarks


def draw(data: PosedPair, size: theme.Size) -> Drawing:
    """Both gears on their shafts, and a close-up of the teeth in contact."""
    design = data.design
    degrees = np.degrees(design.pair.shaft_angle + design.errors.shaft_angle)
    page = theme.new_page(
        size,
        "Fig. 1   The crossed beveloid gear pair in mesh",
        f"Offset E = {data.foot[1, 0]:g} mm, shaft angle \u03b4 = {degrees:g}\u00b0;"
        f" pinion {_kind(data, 0)}, gear {_kind(data, 1)}",
    )
    touching = np.isfinite(data.contact).all()
    pose = (
        "Rolls are those of the middle of the right flanks' path of contact: the flanks touch in one point."
        if touching
        else "The right flanks share no contact point with these errors; the rolls are nominal ones."
    )
    box = theme.place(page, 0.0, 0.045, 1.0, theme.top(page) - 0.045)
    camera = fit_camera(_reach(data), (0.2, 0.5 * data.hand, 0.84), (0.0, -data.hand, 0.0), box.size, 0.05)
    px_per_mm = box.height / (2.0 * camera.half_height)
    items, remarks = _items(data, px_per_mm, True)
    theme.caption(page, " ".join((pose, *remarks)))
    picture = render(Scene(items, camera), box.size)
    _annotate(theme.show(page, box, picture), picture, data)
    return Drawing(page, {"pair": picture})


def _kind(pair: PosedPair, member: int) -> str:
    one = pair.design.members[member]
    angle = float(np.degrees(one.helix_angle))
    hand = "straight" if angle == 0.0 else f"{abs(angle):g}\u00b0 {'right' if angle > 0.0 else 'left'} hand"
    return f"{int(one.teeth)} teeth, {hand}, cone {np.degrees(one.cone_angle):g}\u00b0"


def _annotate(axes: Axes, picture: Picture, pair: PosedPair) -> None:
    """Axes, offset, shaft angle, toe and heel."""
    ends = np.stack((np.minimum(0.0, 1.02 * _ends(pair)[:, 0]), _ends(pair)[:, 1] + 12.0), axis=-1)
    for foot, axis, (low, high) in zip(pair.foot, pair.axis, ends, strict=True):
        annotate.axis_line(axes, picture, foot + low * axis, foot + high * axis, theme.INK)
    offset = f"$E$ = {pair.foot[1, 0]:g} mm"
    annotate.dimension(axes, picture, *pair.foot, offset, (0.0, -14.0), color=theme.BLUE, fontsize=theme.HEADING)
    _shaft_angle(axes, picture, pair)
    for number, member in enumerate(pair.design.members):
        name = posed.NAMES[number]
        for ring, end in zip(posed.rings(member), ("toe", "heel"), strict=True):
            seen = to_fixed(pair.frames[number], ring)
            highest = seen[np.argmax(seen @ picture.camera.axes[1])]
            annotate.note(axes, picture, highest, end, (-26.0 if end == "heel" else 30.0, 22.0))
        annotate.label(axes, picture, pair.foot[number] + pair.position[number] * pair.axis[number], name)


def _shaft_angle(axes: Axes, picture: Picture, pair: PosedPair) -> None:
    """The gear axis against a parallel to the pinion axis through its foot."""
    reach = 0.62 * _ends(pair)[1, 0]
    foot, (first, second) = pair.foot[1], pair.axis
    annotate.line(axes, picture, np.stack((foot, foot + 1.15 * reach * first)), color=theme.RED, linestyle="--")
    arc = annotate.arc(foot, first, second, reach)
    annotate.arrow_along(axes, picture, arc, theme.RED)
    degrees = np.degrees(pair.design.pair.shaft_angle + pair.design.errors.shaft_angle)
    annotate.label(
        axes, picture, arc[16], f"$\\delta$ = {degrees:g}\u00b0", (-34.0, 0.0), color=theme.RED, fontsize=theme.HEADING
    )


def rows(data: PosedPair) -> Table:
    """Layout and pose."""

    def lines() -> Iterator[tuple[str, str, float]]:
        yield "offset", "mm", float(data.foot[1, 0])

    return ("quantity", "unit", "value"), lines()


RECIPES = {"fig-01": Recipe(compute, draw, rows)}
