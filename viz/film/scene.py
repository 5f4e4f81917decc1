"""Views of a film: the teeth in mesh, and the flank of each member with the moving contacts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.font_manager import findfont
from numpy.typing import NDArray

from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.shapes.surface_mesh import gear_mesh

from ..components import posed
from ..components.paths_table import MEMBERS, ratio_words
from ..components.viewpoint import flank_view
from ..rendering import theme
from ..rendering.scene import MESH_PX, Camera, Item, Size, Surface, Tube, add_items, aim, fit_camera
from .motion import Film, NoFilmError

MESH_WIDTH_FRACTION = 0.62
"""Width of the view of the teeth in mesh, as a fraction of the window."""


class FilmView:
    """One renderer of the window, with a ball for the contact of each tooth pair."""

    def __init__(
        self,
        plotter: Any,
        place: tuple[int, int],
        camera: Camera,
        members: Sequence[Sequence[Item]],
        pairs: int,
    ) -> None:
        """Fill the renderer at a row and column of the window with items of each member, and set its
        camera."""
        plotter.subplot(*place)
        self.renderer = plotter.renderer
        self.actors = [self._added(plotter, items) for items in members]
        ball = Tube(np.zeros((1, 3)), "white", 0.035 * camera.half_height)
        line = Tube(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), theme.BLUE, 0.014 * camera.half_height)
        self.balls = [actor for _ in range(pairs) for actor in self._added(plotter, [ball])]
        self.lines = [actor for _ in range(pairs) for actor in self._added(plotter, [line])]
        aim(plotter, camera)

    def _added(self, plotter: Any, items: Sequence[Item]) -> list[Any]:
        """Add items and return their actors."""
        before = len(self.renderer.actors)
        add_items(plotter, items)
        return list(self.renderer.actors.values())[before:]

    def show(
        self, points: FloatArray, ends: FloatArray, near: NDArray[np.bool_], touching: NDArray[np.bool_]
    ) -> None:
        """Place the balls at points (k, 3), mm: blue if in contact, white if only near. A pair in contact
        along a line has a blue line between its ends (k, 2, 3), mm, instead."""
        along = touching & np.isfinite(ends).all(axis=(1, 2))
        for line, (start, end), visible in zip(self.lines, ends, along, strict=True):
            line.visibility = bool(visible)
            if visible:
                # A frame with z along the line; the tube of unit length is stretched along z only.
                across = np.linalg.svd((end - start)[None])[2][1]
                side = np.cross(end - start, across) / np.linalg.norm(end - start)
                columns = np.column_stack((across, side, end - start, start))
                line.user_matrix = np.vstack((columns, (0.0, 0.0, 0.0, 1.0)))
        for ball, point, visible, full in zip(self.balls, points, near & ~along, touching, strict=True):
            ball.visibility = bool(visible)
            if visible:
                ball.position = point
                ball.prop.color = theme.BLUE if full else "white"
        self.renderer.ResetCameraClippingRange()


def write_film(film: Film, out: Path, size: Size, fps: float, steps: Iterable[int]) -> None:
    """Write a film as GIF or MP4, by the suffix of the file.

    Parameters
    ----------
    film : Film
        Motion over one pitch.
    out : Path
        File to write, .gif or .mp4.
    size : tuple of int
        Width and height, pixels.
    fps : float
        Frames per second.
    steps : iterable of int
        Step of the motion that each frame shows.

    Raises
    ------
    NoFilmError
        If the teeth of a member have no closed surface.
    """
    import pyvista as pv

    header = max(0.12, 75.0 / size[1])  # height of the text, as a fraction of the window
    # A line of text over the teeth in mesh on the left and the two flanks on the right.
    grid: dict[str, Any] = {"shape": (3, 2), "groups": [(0, [0, 1]), ([1, 2], 0)], "border": False}
    grid |= {
        "col_weights": [MESH_WIDTH_FRACTION, 1.0 - MESH_WIDTH_FRACTION],
        "row_weights": [header, 0.5 - 0.5 * header, 0.5 - 0.5 * header],
    }
    plotter: Any = pv.Plotter(off_screen=True, window_size=list(size), lighting="none", **grid)
    try:
        plotter.set_background("white")
        plotter.subplot(0, 0)
        _write(plotter, film_title(film), "upper_left")
        plotter.enable_anti_aliasing("msaa")
        views = [
            _mesh_view(plotter, film, size),
            *(_flank_view(plotter, film, each, size) for each in (0, 1)),
        ]
        if out.suffix == ".gif":
            plotter.open_gif(out, fps=fps, subrectangles=True)
        else:
            first = {"output_params": ["-movflags", "+faststart"]}  # so that it plays while it is loaded
            plotter.open_movie(out, framerate=fps, quality=8, macro_block_size=2, **first)
        for step in steps:
            _move(plotter, film, views, step)
            plotter.write_frame()
    finally:
        plotter.close()


def film_camera(film: Film, size: Size) -> Camera:
    """Return the camera for the teeth in mesh, which shows all contacts of the film."""
    middle = len(film.frames[0][1]) // 2
    frame = film.frames[0][0][middle], film.frames[0][1][middle]
    normal = np.nanmean(film.path.path.normal, axis=0)  # out of the pinion tooth
    return posed.mesh_camera(film.path.design, frame, film.point[film.near], normal, size)


def _mesh_view(plotter: Any, film: Film, size: Size) -> FilmView:
    """Fill the view of the teeth in mesh: pinion with the paths on its teeth, and gear."""
    size = int(MESH_WIDTH_FRACTION * size[0]), size[1]
    camera = film_camera(film, size)
    pinion, gear = (_metal(film, number, camera, size) for number in (0, 1))
    paths = [_path(film, 0, camera, pair) for pair in film.pairs.tolist()]
    return FilmView(plotter, (1, 0), camera, [[pinion, *paths], [gear]], len(film.pairs))


def _flank_view(plotter: Any, film: Film, number: int, size: Size) -> FilmView:
    """Fill the view of the flank of tooth 0 of pinion (0) or gear (1), seen along its normal."""
    flank = flank_view(film.path.design.members[number], film.report.flank, outside=True)
    if flank is None:
        raise NoFilmError(f"{MEMBERS[number]}: the flank does not reach the tip over the full face width")
    size = int((1.0 - MESH_WIDTH_FRACTION) * size[0]), size[1] // 2
    corners = flank.marks @ flank.axes + flank.middle  # from the frame of the picture to that of the member
    camera = fit_camera(corners, -flank.axes[2], flank.axes[1], size, margin=0.12)
    items: list[Item] = [_metal(film, number, camera, size, [0]), _path(film, number, camera, 0)]
    view = FilmView(plotter, (1 + number, 1), camera, [items], len(film.pairs))
    _write(plotter, f"{MEMBERS[number]} flank", "upper_left")
    return view


def _metal(
    film: Film, number: int, camera: Camera, size: Size, teeth: Sequence[int] | None = None
) -> Surface:
    """Return the surface of a member in its frame; without `teeth`, of all teeth in view."""
    member = film.path.design.members[number]
    opacity = 0.3 if number and not teeth else 1.0  # the gear hides the contacts
    try:
        mesh = gear_mesh(member, MESH_PX * camera.mm_per_px(size), teeth or teeth_near(film, number, camera))
    except ValueError as error:
        raise NoFilmError(f"{MEMBERS[number]}: {error}") from None
    skin = posed.teeth_in_mesh(mesh, camera, film.frames[number][0][0, :, 2])
    if teeth:
        skin = skin.where(~skin.is_of("toe", "heel"))
    return Surface(skin.points, skin.faces, skin.normals, theme.METALS[number], opacity, edges=True)


def teeth_near(film: Film, number: int, camera: Camera) -> range | None:
    """Return the numbers of the teeth of a member that can be in view; None for all."""
    member, (rotation, origin) = film.path.design.members[number], film.frames[number]
    teeth, middle = int(member.teeth), len(origin) // 2
    aside = 2 + int(np.ceil(2.0 * camera.half_height / (np.pi * float(member.tool.normal_module))))
    if 2 * aside + 1 >= teeth:
        return None
    x, y, _ = (camera.focal_point - origin[middle]) @ rotation[middle]
    nearest = round(float(np.arctan2(y, x)) * teeth / (2.0 * np.pi))
    return range(nearest - aside, nearest + aside + 1)


def _path(film: Film, number: int, camera: Camera, tooth: int) -> Tube:
    """Return the path of contact on a tooth of pinion (0) or gear (1), in the frame of the member."""
    points = posed.on_tooth(film.path.points[number], film.path.design.members[number], tooth)
    return Tube(points, theme.VERMILLION, 0.012 * camera.half_height)


def _move(plotter: Any, film: Film, views: Sequence[FilmView], step: int) -> None:
    """Move teeth and balls to a step of the motion, and write its numbers."""
    near, touching, points = film.near[:, step], film.touching[:, step], film.point[:, step]
    for number, actors in enumerate(views[0].actors):
        rotation, origin = (part[step] for part in film.frames[number])
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation, origin
        for actor in actors:
            actor.user_matrix = matrix
        views[1 + number].show(film.on_tooth_0(number)[:, step], film.lines[number][:, step], near, touching)
    views[0].show(points, film.line_in_mesh(step), near, touching)
    plotter.subplot(0, 0)
    _write(plotter, readings(film, step), "upper_right")


def _write(plotter: Any, words: str, place: str) -> None:
    """Write text in a corner of the active view, replacing text that is there."""
    size = max(7, round(plotter.window_size[0] / 96.0))
    font = {"font_file": findfont(theme.FONT), "font_size": size, "color": theme.INK}
    plotter.add_text(words, position=place, name=place, **font)


def film_title(film: Film) -> str:
    """Return the title: design, flanks, contact ratios, and the meaning of the balls."""
    name = theme.in_font(film.report.name or "design")
    name = name if len(name) <= 40 else f"{name[:19]}\u2026{name[-20:]}"
    ratios = ratio_words(film.path.ratio, film.report.operating)
    gap_um = 1e3 * MARKING_SEPARATION_MM
    balls = f"blue: contact; white: gap below {gap_um:g} \u00b5m; orange: path of contact"
    return f"{name}, {film.report.flank} flanks: {ratios}\n{balls}"


def readings(film: Film, step: int) -> str:
    """Return the numbers of a step: roll of the pinion, transmission error, tooth pairs, and contact."""
    report = film.report
    error = float(report.first.transmission_error[step])  # from the unmodified pair, as in `operation`
    share = step / film.gap.shape[1]
    return (
        f"pinion roll {360.0 * share / float(film.path.design.pinion.teeth):.2f}\u00b0 = {share:.2f} pitch\n"
        f"transmission error {theme.signed(ARCSEC * error, 2)} arcsec\n"
        f"tooth pairs in contact: {int(film.touching[:, step].sum())}, by {report.carriers_in_print[step]}"
    )
