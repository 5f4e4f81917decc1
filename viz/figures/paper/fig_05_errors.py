"""Fig. 5: the four assembly errors in their positive directions, between the frames of the paper."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beveloid_geom import Design, Errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import Frame
from beveloid_geom.design.member import unchecked
from beveloid_geom.pair.frames import layout_of, member_frame, to_fixed
from beveloid_geom.validation.claims import ANGLE_ERROR, AXIAL_ERROR, OFFSET_ERROR

from ...components import annotate, panels, paths_table, posed
from ...components.annotate import Overlay
from ...components.figure_steps import Drawing, Recipe, Table
from ...components.posed import PosedPair
from ...rendering import theme
from ...rendering.layout import PanelRows
from ...rendering.scene import Camera, Item, Picture, Tube, fit_camera


@dataclass(frozen=True)
class ErrorPanel:
    """One error: name of its field, symbol, name, member that moves, and the frames between which the paper
    defines the error."""

    key: str
    symbol: str
    name: str
    member: int
    before: str
    after: str


PANELS = (
    ErrorPanel("offset", "\\Delta e", "offset error", 1, "g", "e"),
    ErrorPanel("shaft_angle", "\\Delta\\delta", "shaft-angle error", 0, "f", "\\delta"),
    ErrorPanel("pinion_axial", "\\Delta d_1", "axial error of the pinion", 0, "q1", "d1"),
    ErrorPanel("gear_axial", "\\Delta d_2", "axial error of the gear", 1, "q2", "d2"),
)


@dataclass(frozen=True, eq=False)
class ErrorFigure:
    """The `pair` without errors, the frames of the paper in S_f by name, and for each panel the error drawn
    (mm or rad) and the frames with this error."""

    pair: PosedPair
    nominal: dict[str, Frame]
    drawn: tuple[float, ...]
    displaced: tuple[dict[str, Frame], ...]

    @property
    def design(self) -> Design:
        """The design without errors."""
        return self.pair.design

    def seen(self, frames: dict[str, Frame]) -> dict[str, Frame]:
        """Return the frames as drawn: a distant common perpendicular is moved to the members, and the pinion
        is turned about it there."""
        nearer = self.pair.nearer * self.pair.axis[0]
        back = self.pair.nearer * frames["\\delta"][0][:, 2]
        moves = dict.fromkeys(("f", "\\delta", "g", "e"), nearer) | dict.fromkeys(("q1", "d1"), nearer - back)
        return {name: (turn, origin + moves.get(name, 0.0)) for name, (turn, origin) in frames.items()}


def paper_frames(design: Design, distance: FloatArray) -> dict[str, Frame]:
    """Return the frames of the paper (Eqs. 9-14) in S_f with the errors of a design, at roll 0.

    Pinion: S_f fixed, S_delta turned by the shaft-angle error, S_q1 at mid-face, S_d1 displaced by the axial
    error. Gear: S_g on the gear axis, S_e displaced by the offset error, S_q2 at mid-face, S_d2 displaced by
    the axial error. `distance` (2,): positions of the mid-faces along the axes, mm. S_delta turns
    the pinion axis, whereas `pair.frames` turns the gear axis; both describe the same pair."""
    plain, errors = layout_of(design, with_errors=False), design.errors
    turn = float(layout_of(design).shaft_angle - plain.shaft_angle)
    cos, sin = np.cos(turn), np.sin(turn)
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]), np.zeros(3)
    fixed = member_frame(plain, 0, 0.0, 0.0), member_frame(plain, 1, 0.0, 0.0)
    offset = fixed[1][0], fixed[1][1] + np.array([float(errors.offset), 0.0, 0.0])
    first, second = _along(tilted, distance[0]), _along(offset, distance[1])
    return {
        "f": fixed[0],
        "\\delta": tilted,
        "q1": first,
        "d1": _along(first, float(errors.pinion_axial)),
        "g": fixed[1],
        "e": offset,
        "q2": second,
        "d2": _along(second, float(errors.gear_axial)),
    }


def _along(frame: Frame, length: float) -> Frame:
    """Return a frame moved along its z axis, mm."""
    return frame[0], frame[1] + length * frame[0][:, 2]


def compute(design: Design) -> ErrorFigure:
    """Compute the frames without and with each error, mounted as without errors."""
    # Displacements drawn: fraction of the distance of the members, and angle.
    fraction, angle_rad = 0.46, np.radians(18.0)
    plain = replace(design, errors=Errors())
    pair = posed.placed(plain, np.zeros(2))
    distance, length = pair.position, fraction * _scale(pair)
    drawn = [angle_rad if panel.key == "shaft_angle" else length for panel in PANELS]
    errors = [unchecked(Errors(), **{panel.key: float(x)}) for panel, x in zip(PANELS, drawn, strict=True)]
    frames = tuple(paper_frames(plain.with_errors(error), distance) for error in errors)
    return ErrorFigure(pair, paper_frames(plain, distance), tuple(drawn), frames)


def _scale(pair: PosedPair) -> float:
    """Return the length (mm) to which displacements and axes of frames are proportional."""
    # Factor of these lengths if the common perpendicular is drawn closer to the members.
    nearer_factor = 1.5
    return nearer_factor * pair.apart if pair.nearer else pair.apart


def draw(data: ErrorFigure, layout: theme.PageLayout) -> Drawing:
    """Draw a panel for each error, all with one direction of view and one scale."""
    cells = PanelRows(left=0.28, right=0.16, across=0.0, down=0.45, most=2, least=4.0)
    # Lengths of the axes of frames as fractions of the distance of the members: usual, and largest, which is
    # used if the panels are in one column.
    usual_fraction, largest_fraction = 0.26, 0.36
    # Fraction of the width of such a panel for its text.
    print_text_fraction = 0.34
    one_column = cells.columns(layout, len(PANELS)) == 1
    if one_column:
        cells = replace(cells, down=0.1)
    page, low, high = theme.new_page(
        layout,
        "Fig. 5   The four assembly errors, in their positive directions",
        "Black and grey: frame and members without error; blue, dashed: displaced by the error (orange)",
        (
            "View as in Fig. 4, exaggerated. $S_e$: $S_g$ moved away from the pinion along the common"
            " perpendicular; $S_\\delta$: $S_f$ turned about it, so that the shaft angle increases;"
            " $S_{q1}$, $S_{q2}$: at mid-face without axial errors; $S_{d1}$, $S_{d2}$: these moved along"
            " their axes towards +z."
        )
        + posed.far_words(data.pair),
        tall=cells.tall(layout, len(PANELS), 5.2),
    )
    pictures = {}
    places = cells.boxes(layout, len(PANELS), page.get_figheight(), low, high)
    title, aside = theme.inches(page, 0.9 if layout.printed else 0.62), 0.0
    if one_column:
        title, aside = 0.0, print_text_fraction
    boxes = [
        theme.place(page, left + aside * width, bottom, (1.0 - aside) * width, height - title)
        for left, bottom, width, height in places
    ]
    fitted = [
        fit_camera(_reach(data, frames, largest_fraction), posed.VIEW, posed.UP, boxes[0].size, 0.04)
        for frames in data.displaced
    ]
    half_height = max(camera.half_height for camera in fitted)
    cameras = [replace(camera, half_height=half_height) for camera in fitted]
    for index, (panel, box, place, camera) in enumerate(zip(PANELS, boxes, places, cameras, strict=True)):
        left, bottom, width, height = place
        corner = left + 0.12 / layout.width, bottom + height - theme.inches(page, 0.05)
        _heading(page, corner, (aside or 0.95) * width, data, index)
        frame_fraction = largest_fraction if one_column else usual_fraction
        pictures[panel.key] = _panel(page, box, data, index, camera, frame_fraction * _scale(data.pair))
    return Drawing(page, pictures)


def _reach(data: ErrorFigure, displaced: dict[str, Frame], frame_fraction: float) -> FloatArray:
    """Return points (n, 3) in S_f that a panel must show, mm: origins, space for their labels, and tip
    circles."""
    frames = [data.seen(frames) for frames in (data.nominal, displaced)]
    members = [
        (member, placed[f"d{j + 1}"]) for placed in frames for j, member in enumerate(data.design.members)
    ]
    rings = [to_fixed(frame, posed.rings(member)).reshape(-1, 3) for member, frame in members]
    arrow_length = 1.6 * frame_fraction * _scale(data.pair)
    origins = [origin for placed in frames for _, origin in placed.values()]
    return np.concatenate(
        (*rings, origins, [data.seen(data.nominal)["g"][1] + arrow_length * data.nominal["g"][0][:, 0]])
    )


def _heading(
    page: theme.Page, corner: tuple[float, float], width: float, data: ErrorFigure, index: int
) -> None:
    """Write letter, name, frames and size of an error below the upper left corner of its panel.

    Lines are at most `width` wide, a fraction of the page."""
    # Errors of Figs. 12 to 15 (mm at the module of Table 1, rad) for comparison with those drawn.
    errors = {"offset": OFFSET_ERROR, "shaft_angle": ANGLE_ERROR}
    panel, drawn = PANELS[index], data.drawn[index]
    typical = errors.get(panel.key, AXIAL_ERROR)
    if panel.key == "shaft_angle":
        size, usual = f"{np.degrees(drawn):.3g}\u00b0", f"{np.degrees(typical):g}\u00b0"
    else:
        typical = paths_table.two_digits(typical * paths_table.as_large(data.design))
        size, usual = f"{drawn:.3g} mm", f"{typical:g} mm"
    words = f"{size}, {drawn / typical:.0f} times {usual}"
    head = f"({'abcd'[index]})  {panel.name} ${panel.symbol}$\u00a0>\u00a00"
    (x, y), pixels = corner, width * page.get_figwidth() * page.dpi
    bold = page.text(x, y, "", fontsize=theme.HEADING, fontweight="bold", va="top")
    theme.wrap_text(bold, head, pixels)
    below = y - theme.inches(page, 0.27 * (1 + bold.get_text().count("\n")))
    between = f"from\u00a0$S_{{{panel.before}}}$ to\u00a0$S_{{{panel.after}}}$"
    quiet = page.text(x, below, "", fontsize=theme.LABEL, color=theme.GREY, va="top")
    theme.wrap_text(quiet, f"{between}; drawn: {words}", pixels)


def _panel(
    page: theme.Page, box: theme.PageBox, data: ErrorFigure, index: int, camera: Camera, length: float
) -> Picture:
    """Draw both members without errors, the displaced one, and frames with axes of a `length` (mm)."""
    bore_shaft_radii = 1e-3
    radius = 0.7 * camera.mm_per_px(box.size) * page.dpi / 72.0
    nominal, moved = data.seen(data.nominal), data.seen(data.displaced[index])
    places = [(0, nominal["d1"], theme.METALS[0]), (1, nominal["d2"], theme.METALS[0])]
    number = PANELS[index].member
    places.append((number, moved[f"d{number + 1}"], "#7fb3d9"))
    items: list[Item] = []
    for which, frame, colour in places:
        member = data.design.members[which]
        items += posed.blank(member, frame, colour, bore_shaft_radii * posed.shaft_radius(member), 0.3)
        rings = [to_fixed(frame, ring) for ring in posed.rings(member)]
        if colour == theme.METALS[0]:
            items += [Tube(ring, theme.GREY, radius) for ring in rings]
        else:
            pieces = (piece for ring in rings for piece in panels.dashed_circle(ring, radius))
            items += [Tube(piece, theme.BLUE, radius) for piece in pieces]
    over = Overlay.drawn(page, box, items, camera)
    _annotate(over, data, index, length)
    return over.picture


def _annotate(over: Overlay, data: ErrorFigure, index: int, length: float) -> None:
    """Draw axes and frames before and after, and the error between them."""
    # Distance of a dimension from the origins, in lengths of the axes of frames.
    dimension_fraction = 0.75
    # Offsets of the labels of frames from their origins, points.
    label_offsets_pt = {
        **{"f": (-16.0, 16.0), "\\delta": (-16.0, -16.0), "q1": (-22.0, 5.0), "d1": (30.0, 3.0)},
        **{"g": (-18.0, -16.0), "e": (22.0, -15.0), "q2": (-22.0, -16.0), "d2": (24.0, -15.0)},
    }
    panel, nominal, moved = PANELS[index], data.seen(data.nominal), data.seen(data.displaced[index])
    over.line(nominal["f"][1], nominal["g"][1], linewidth=0.9)
    for number in (0, 1):
        _axis(over, data, nominal, number, theme.GREY)
    if panel.before in ("g", "f"):
        _axis(over, data, moved, panel.member, theme.BLUE)
    before, after = nominal[panel.before], moved[panel.after]
    tilted = panel.key == "shaft_angle"
    # Both frames share the axis of rotation, or are parallel.
    names = "xyz", ("", "y", "z") if tilted else 3 * (annotate.UNNAMED,)
    looks = (before, theme.INK, panel.before), (after, theme.BLUE, panel.after)
    # The displaced frame would be below the label of an axis in its direction.
    covered = None if tilted else after[1] - before[1]
    for (frame, colour, name), letters in zip(looks, names, strict=True):
        title, offset = f"S_{{{name}}}", label_offsets_pt[name]
        over.triad(frame[1], frame[0].T, length, letters, colour, title, offset, covered)
    style: dict[str, Any] = {"color": theme.VERMILLION, "fontsize": theme.HEADING, "fontweight": "bold"}
    words = f"${panel.symbol}$"
    if tilted:
        arc = annotate.arc(before[1], before[0][:, 2], after[0][:, 2], 2.6 * length)
        over.line(arc[0], before[1], arc[-1], color=theme.VERMILLION, linewidth=0.9)
        over.arrow_along(arc, theme.VERMILLION, 2.2)
        over.label(arc[16], words, (-24.0, 0.0), **style)
        return
    aside = -dimension_fraction * length * before[0][:, 1]
    start, end = before[1] + aside, after[1] + aside
    for origin, foot in ((before[1], start), (after[1], end)):
        over.line(origin, origin + 1.1 * (foot - origin), color=theme.VERMILLION, linewidth=0.9)
    over.arrow(start, end, theme.VERMILLION, 2.4)
    offset = over.clear_offset(start, end, aside, words, fontsize=theme.HEADING, fontweight="bold")
    over.label(0.5 * (start + end), words, offset, **style)


def _axis(over: Overlay, data: ErrorFigure, frames: dict[str, Frame], number: int, colour: str) -> None:
    """Draw the axis of a member from the common perpendicular to a point beyond mid-face towards +z."""
    (rotation, origin), (_, middle) = frames[("\\delta", "e")[number]], frames[f"d{number + 1}"]
    beyond = 0.75 * float(data.design.members[number].face_width)
    at = middle + data.pair.breaks[number] * rotation[:, 2] if data.pair.nearer else None
    over.axis(origin, middle + beyond * rotation[:, 2], colour, at)


def rows(data: ErrorFigure) -> Table:
    """List the errors drawn, and all frames in S_f."""
    vectors = [f"{letter}_{component}" for letter in "xyz" for component in "xyz"]
    places = [f"origin_{component}_mm" for component in "xyz"]
    header = ("error", "drawn_mm", "drawn_rad", "frame", *places, *vectors)
    keys, drawn = ("none", *(panel.key for panel in PANELS)), (0.0, *data.drawn)
    lines = []
    for key, size, frames in zip(keys, drawn, (data.nominal, *data.displaced), strict=True):
        sizes = ("", size) if key == "shaft_angle" else (size, "")
        for name, (rotation, origin) in frames.items():
            numbers = *origin.tolist(), *rotation.T.ravel().tolist()
            lines.append((key, *sizes, f"S_{name.strip(chr(92))}", *numbers))
    return header, lines


RECIPES = {"fig-05": Recipe(compute, draw, rows)}
