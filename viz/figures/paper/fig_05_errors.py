"""Fig. 5: the four assembly errors and their positive directions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beveloid_geom import Design, Errors
from beveloid_geom.design.model import unchecked

from ...parts import annotate, posed, solved
from ...parts.annotate import Overlay
from ...parts.posed import PosedPair
from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.layout import Cells
from ...stage.scene import MESH_PX, Item, Picture, fit_camera

STILL = theme.STEEL
MOVED = "#e8a04c"
FACES = {STILL: "#d3dce4", MOVED: "#f3c48a"}
DRAWN_SHARE = 0.16
"""Displacements drawn, as a share of the offset."""
DRAWN_ANGLE = np.radians(9.0)
TYPICAL = {"offset": 0.5, "shaft_angle": np.radians(0.01), "pinion_axial": 0.5, "gear_axial": 0.5}
"""Sizes of the errors in Figs. 12 to 15 (mm, rad) with which the drawn ones are compared."""


@dataclass(frozen=True)
class Panel:
    """One error: its key among the errors, letter, name, which member moves, and the direction of
    view in S_f with what is upwards there."""

    key: str
    symbol: str
    name: str
    member: int
    view: tuple[float, float, float]
    up: tuple[float, float, float]


CELLS = Cells(left=0.16, right=0.16, across=0.0, down=0.0, most=2, least=4.5)
FROM_TOE, FROM_SIDE, FROM_HEEL = (-0.22, 0.3, 0.92), (-0.93, 0.28, 0.25), (-0.52, -0.5, -0.66)
PANELS = (
    Panel("offset", "\\Delta e", "offset error", 1, FROM_TOE, (0.0, -1.0, 0.0)),
    Panel("shaft_angle", "\\Delta\\delta", "shaft-angle error", 1, FROM_SIDE, (0.0, -1.0, 0.0)),
    Panel("pinion_axial", "\\Delta d_1", "axial error of the pinion", 0, FROM_HEEL, (0.0, 1.0, 0.0)),
    Panel("gear_axial", "\\Delta d_2", "axial error of the gear", 1, FROM_HEEL, (0.0, 1.0, 0.0)),
)


@dataclass(frozen=True, eq=False)
class ErrorFigure:
    """The pair without errors, and for each panel the error drawn (mm or rad) and the pair with it."""

    nominal: PosedPair
    drawn: tuple[float, ...]
    displaced: tuple[PosedPair, ...]


def compute(design: Design) -> ErrorFigure:
    """Find poses without and with each error; rolls are those of the pair without errors."""
    plain = replace(design, errors=Errors())
    nominal = posed.pose(plain)
    length = DRAWN_SHARE * float(plain.pair.offset)
    drawn = [DRAWN_ANGLE if panel.key == "shaft_angle" else length for panel in PANELS]
    errors = [unchecked(Errors(), **{panel.key: float(x)}) for panel, x in zip(PANELS, drawn, strict=True)]
    return ErrorFigure(nominal, tuple(drawn), tuple(posed.displaced(nominal, error) for error in errors))


def draw(data: ErrorFigure, layout: theme.Layout) -> Drawing:
    """Draw a panel for each error: the nominal pose grey and translucent, the displaced one orange."""
    page, low, high = theme.new_page(
        layout,
        "Fig. 5   The four assembly errors, in their positive directions",
        "Grey and translucent: where the member belongs; orange: displaced, much exaggerated",
        "Errors are taken from the pair as mounted, seen from the pinion: the pinion's axis stays, offset and"
        " shaft-angle errors move the gear's; axial errors move a member along its own axis towards its heel."
        " The paper lays the shaft-angle error on the pinion's side, which is the same pair. (c) and (d)"
        " are seen from the heels.",
        tall=CELLS.tall(layout, len(PANELS), 4.2),
    )
    pictures = {}
    places = CELLS.boxes(layout, len(PANELS), page.get_figheight(), low, high)
    for index, (panel, (left, bottom, width, height)) in enumerate(zip(PANELS, places, strict=True)):
        title = theme.inches(page, 0.62)
        box = theme.place(page, left, bottom, width, height - title)
        _heading(page, left + 0.24 / layout.width, bottom + height - theme.inches(page, 0.05), data, index)
        pictures[panel.key] = _panel(page, box, data, index)
    return Drawing(page, pictures)


def _heading(page: theme.Page, x: float, y: float, data: ErrorFigure, index: int) -> None:
    """Write letter, name and size of the error of a panel, below a place x, y of the page."""
    panel, drawn = PANELS[index], data.drawn[index]
    times = drawn / TYPICAL[panel.key]
    if panel.key == "shaft_angle":
        words = f"{np.degrees(drawn):.3g}\u00b0, {times:.3g} times {np.degrees(TYPICAL[panel.key]):g}\u00b0"
    else:
        words = f"{drawn:.3g} mm, {times:.3g} times {TYPICAL[panel.key]:g} mm"
    head = f"({'abcd'[index]})  {panel.name} ${panel.symbol}$ > 0"
    page.text(x, y, head, fontsize=theme.HEADING, fontweight="bold", va="top")
    below = y - theme.inches(page, 0.27)
    page.text(x, below, f"drawn: {words}", fontsize=theme.LABEL, color=theme.GREY, va="top")


def _gear(pair: PosedPair, number: int, colour: str, tolerance: float) -> list[Item]:
    """Make a member on its shaft with its teeth, or as a blank where they cannot be drawn."""
    member, frame = pair.design.members[number], pair.frames[number]
    bore = posed.shaft_radius(member)
    over = 0.5 * float(member.face_width) + 0.3 * bore
    gear, _ = posed.gear_items(member, frame, tolerance, (colour, FACES[colour]), bore)
    return [*gear, *posed.shaft(frame, bore, -over, over)]


def _panel(page: theme.Page, box: theme.Box, data: ErrorFigure, index: int) -> Picture:
    """Draw the pair with one error, and where the member belongs."""
    panel, nominal, moved = PANELS[index], data.nominal, data.displaced[index]
    camera = fit_camera(posed.reach(nominal, moved), panel.view, panel.up, box.size, 0.05)
    tolerance = MESH_PX * camera.mm_per_px(box.size)
    member = nominal.design.members[panel.member]
    # Shorter by a little, so that its ends do not fall into those of the displaced member.
    short = replace(member, face_width=0.98 * float(member.face_width))
    radius, frame = posed.shaft_radius(member), nominal.frames[panel.member]
    ghost = posed.blank(short, frame, "#8c96a0", radius, opacity=0.3)
    items: list[Item] = [
        *_gear(nominal, 1 - panel.member, STILL, tolerance),
        *_gear(moved, panel.member, MOVED, tolerance),
        *ghost,
    ]
    over = Overlay.drawn(page, box, items, camera)
    _annotate(over, data, index)
    return over.picture


def _annotate(over: Overlay, data: ErrorFigure, index: int) -> None:
    """Draw axes before and after, and the error between them."""
    panel, nominal, moved = PANELS[index], data.nominal, data.displaced[index]
    still, number = 1 - panel.member, panel.member
    _axis(over, nominal, still, theme.INK)
    _axis(over, nominal, number, theme.GREY)
    if panel.key != f"{solved.MEMBERS[number]}_axial":
        _axis(over, moved, number, theme.RED)
    style: dict[str, Any] = {"color": theme.RED, "fontsize": theme.HEADING, "fontweight": "bold"}
    words = f"${panel.symbol}$"
    if panel.key == "shaft_angle":
        reach = 0.42 * float(nominal.position[1])
        arc = annotate.arc(nominal.foot[1], nominal.axis[1], moved.axis[1], reach)
        over.arrow_along(arc, theme.RED, 2.2)
        over.label(arc[16], words, (-22.0, 0.0), **style)
        return
    start, end = (pair.foot[number] for pair in (nominal, moved))
    if panel.key != "offset":
        tip = np.hypot(*posed.rings(nominal.design.members[number]).T[:2]).max()
        out = np.array([1.15 if number else -1.15, 0.0, 0.0]) * tip
        centres = [pair.foot[number] + pair.position[number] * pair.axis[number] for pair in (nominal, moved)]
        start, end = (centre + out for centre in centres)
        for centre in centres:
            over.line(centre, centre + 1.05 * out, linewidth=0.9)
    over.arrow(start, end, theme.RED, 2.4)
    over.label(0.5 * (start + end), words, (0.0, -16.0), **style)


def _axis(over: Overlay, pair: PosedPair, number: int, colour: str) -> None:
    """Draw the axis of a member from the common perpendicular to beyond its heel."""
    foot, way = pair.foot[number], pair.axis[number]
    far = float(pair.position[number]) + 1.1 * float(pair.design.members[number].face_width)
    over.axis(foot, foot + far * way, colour)


def rows(data: ErrorFigure) -> Table:
    """List the errors drawn, and the frames of the displaced members in S_f."""
    vectors = [f"{letter}_{component}" for letter in "xyz" for component in "xyz"]
    header = ("error", "drawn_mm_or_rad", "member", "origin_x_mm", "origin_y_mm", "origin_z_mm", *vectors)

    keys = ["none", *(panel.key for panel in PANELS)]
    poses = zip(keys, (0.0, *data.drawn), (data.nominal, *data.displaced), strict=True)
    return header, [
        (key, size, name, *origin.tolist(), *rotation.T.ravel().tolist())
        for key, size, pair in poses
        for name, (rotation, origin) in zip(solved.MEMBERS, pair.frames, strict=True)
    ]


RECIPES = {"fig-05": Recipe(compute, draw, rows)}
