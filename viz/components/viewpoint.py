"""Views of flanks along their normal, with scale bars and a sketch of the viewing direction."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, Polygon

from beveloid_geom import Design, Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.ends import end_names
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.gear.flank_limits import tip_parameter

from ..rendering import theme
from ..rendering.theme import Page

Look = tuple[str, bool]
"""A flank, 'right' or 'left', and True if it is seen from outside."""

NOTE_CHARACTERS = 120
"""Characters per line of the note, with space for scale bars and sketch on its right."""


@dataclass(frozen=True, eq=False)
class FlankView:
    """View of a flank along the normal at its middle.

    Attributes
    ----------
    axes : ndarray, shape (3, 3)
        Axes of the picture in the frame of the member, as rows: to the right, towards +z, towards the viewer.
    middle : ndarray, shape (3,)
        Point at the centre of the picture, mm.
    stretch : float
        Magnification from root to tip, relative to the direction of the face width.
    flank : str
        'right' or 'left'.
    outside : bool
        True if the flank is seen from outside, False if through the tooth.
    bounds : ndarray, shape (2, 2)
        Smallest and largest x and y, mm, stretched.
    marks : ndarray, shape (3, 3, 3)
        Points at root, mid-depth and tip (axis 0), at -z, mid-face and +z (axis 1), in the frame of the
        picture, mm.
    ends : tuple of str
        Printed names of the ends of the face at -z and +z.
    """

    axes: FloatArray
    middle: FloatArray
    stretch: float
    flank: str
    outside: bool
    bounds: FloatArray
    marks: FloatArray
    ends: tuple[str, str]

    @property
    def span(self) -> FloatArray:
        """Width and height of the flank as drawn, mm, stretched."""
        return np.asarray(self.bounds[1] - self.bounds[0])

    def place(self, points: FloatArray) -> FloatArray:
        """Return points (..., 3) of the member in the frame of the picture, mm."""
        return np.asarray((points - self.middle) @ self.axes.T * (self.stretch, 1.0, 1.0))

    def turn(self, normals: FloatArray) -> FloatArray:
        """Return outward normals (..., 3) of the member in the frame of the picture. They are reversed if the
        flank is seen through the tooth, so that they point towards the viewer."""
        return np.asarray(normals @ self.axes.T * (1.0 if self.outside else -1.0))


def flank_view(member: Member, flank: str, stretch: float = 1.0, outside: bool = False) -> FlankView | None:
    """Return the view of a flank.

    Parameters
    ----------
    member : Member
        Gear.
    flank : {'right', 'left'}
        Flank.
    stretch : float
        Magnification from root to tip, relative to the direction of the face width.
    outside : bool
        True to look from outside. Otherwise the view has the tip on the right, as in the paper.

    Returns
    -------
    FlankView or None
        None if the flank does not reach its tip.
    """
    half = 0.5 * float(member.face_width)
    z = np.array([-half, 0.0, half])
    tip = tip_parameter(member, flank, z)
    if not np.isfinite(tip).all():
        return None
    share = np.linspace(0.0, 1.0, 9)[:, None]
    root = active_start(member, flank, z)
    l = root + share * (tip - root)
    patch = flank_patch(member, flank, l, z=z)
    normal = patch.normal[4, 1]
    up = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    outside = outside or bool(right @ (patch.point[-1, 1] - patch.point[0, 1]) > 0.0)
    side = 1.0 if outside else -1.0
    axes = np.stack((side * right, up, side * normal))
    view = FlankView(
        *(axes, patch.point[4, 1], stretch, flank, outside, np.zeros((2, 2)), patch.point[::4]),
        end_names(member),
    )
    seen = view.place(patch.point)
    bounds = np.stack((seen.min(axis=(0, 1)), seen.max(axis=(0, 1))))[:, :2]
    return replace(view, bounds=bounds, marks=seen[::4])


def flank_views(design: Design, flank: str, stretch: float, outside: bool = False) -> list[FlankView | None]:
    """Return the views of pinion and gear."""
    return [flank_view(member, flank, stretch, outside) for member in design.members]


def looks_of(views: Iterable[FlankView | None]) -> list[Look]:
    """Return each flank and direction of view once."""
    return list(dict.fromkeys((view.flank, view.outside) for view in views if view is not None))


def greatest_span(views: Iterable[FlankView | None]) -> FloatArray:
    """Return the largest width and height of flanks as drawn, mm; 1 mm without flanks."""
    spans = [view.span for view in views if view is not None]
    return np.max(spans, axis=0) if spans else np.ones(2)


def scale_bars(page: Page, px_per_mm: float, stretch: float, looks: Sequence[Look] = ()) -> None:
    """Draw scale bars along and across the flanks at the lower right of the page, with the sketch of the
    viewing direction."""
    width, height = page.canvas.get_width_height()
    high, inch = theme.inches(page, 1.0), theme.inches(page, 1.0) * height / width
    foot = 0.0 if page.layout.printed else theme.inches(page, 0.15)
    length = theme.round_length(1.3 * inch * width / (px_per_mm * stretch))
    across, along = length * px_per_mm * stretch, length * px_per_mm
    box = theme.place(page, 1.0 - 1.75 * inch, foot, 1.4 * inch, high)
    axes = theme.overlay(page, box)
    x, y = 0.0, 0.68 * box.height
    axes.plot([x, x, x + across], [y - along, y, y], color=theme.INK, linewidth=2.5, clip_on=False)
    for at, direction, offset, ha, va in (
        ((x, y - 0.5 * along), "along", (-6, 0), "right", "center"),
        ((x + 0.5 * across, y), "across", (0, -5), "center", "top"),
    ):
        theme.label_point(axes, at, f"{length:g} mm {direction}", offset, ha=ha, va=va, fontsize=theme.SMALL)
    if looks:
        box = theme.place(page, 1.0 - 5.15 * inch, foot, 2.2 * inch, high)
        sketch(theme.overlay(page, box), looks, box.height)


def sketch(axes: Axes, looks: Sequence[Look], inch: float) -> None:
    """Draw the section of a tooth with an eye and an arrow for each flank that is shown.

    The tooth is seen from -z, so that right flanks are on the right.

    Parameters
    ----------
    axes : Axes
        Axes with pixels as coordinates, from the upper left corner.
    looks : sequence of tuple
        Flanks shown, and True for a view from outside.
    inch : float
        Pixels per inch.
    """
    # Inches: half width of the tooth at tip and root, its depth, and the rim below.
    half_tip, half_root, depth, rim = 0.13, 0.27, 0.56, 0.14
    half_middle = 0.5 * (half_tip + half_root)
    # Inches: half width of the eye, and its distance from the middle of the tooth.
    eye_half, eye_at = 0.15, 0.86
    middle = np.array([0.5 * abs(float(np.subtract(*axes.get_xlim()))), 0.68 * inch])

    def at(points: FloatArray) -> FloatArray:
        """Return pixels (n, 2) of points (n, 2), inches to the right of the middle of the tooth and above its
        root."""
        return np.asarray(middle + inch * points * (1.0, -1.0))

    right = np.array([[half_tip, depth], [half_middle, 0.5 * depth], [half_root, 0.0]])
    below = np.array([[2.0 * half_root, 0.0], [2.0 * half_root, -rim]])
    outline = np.concatenate((right, below))
    outline = np.concatenate((outline, outline[::-1] * (-1.0, 1.0)))
    axes.add_patch(Polygon(at(outline), facecolor=theme.PALE, edgecolor="none", clip_on=False))
    top = outline[[0, 1, 2, 3, -4, -3, -2, -1, 0]]
    axes.plot(*at(top).T, color=theme.GREY, linewidth=1.0, clip_on=False)
    for flank, outside in looks:
        side = 1.0 if flank == "right" else -1.0
        axes.plot(*at(right * (side, 1.0)).T, color=theme.INK, linewidth=3.2, clip_on=False)
        eye = side if outside else -side
        start = np.array([eye * (eye_at - 1.3 * eye_half), 0.5 * depth])
        end = np.array([side * (half_middle + (0.04 if outside else -0.04)), 0.5 * depth])
        _eye(axes, at(np.array([[eye * eye_at, 0.5 * depth]]))[0], eye_half * inch)
        line: dict[str, Any] = {"arrowstyle": "-|>", "color": theme.INK, "linewidth": 1.4}
        line |= {"shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 12.0}
        ends = at(np.stack((end, start)))
        axes.annotate("", tuple(ends[0]), tuple(ends[1]), annotation_clip=False, arrowprops=line)
    foot = at(np.array([[0.0, -rim]]))[0]
    theme.label_point(axes, foot, _words(looks), (0, -3), ha="center", va="top", fontsize=theme.SMALL)


def _eye(axes: Axes, at: FloatArray, half: float) -> None:
    """Draw an eye at a point (2,) with half its width, pixels."""
    along = np.linspace(-1.0, 1.0, 31)
    lid = 0.55 * half * (1.0 - along**2)
    for side in (-1.0, 1.0):
        points = at + np.stack((half * along, side * lid), axis=-1)
        axes.plot(*points.T, color=theme.INK, linewidth=1.3, clip_on=False)
    pupil = Ellipse((float(at[0]), float(at[1])), 0.8 * half, 0.8 * half, color=theme.INK, clip_on=False)
    axes.add_patch(pupil)


def _words(looks: Sequence[Look]) -> str:
    """Return the direction of view as text."""
    sides = {outside for _, outside in looks}
    if len(sides) > 1:
        return ", ".join(f"{flank} {_seen(outside)}" for flank, outside in looks)
    flank = f"{looks[0][0]} flanks" if len(looks) == 1 else "flanks"
    return f"{flank} {_seen(sides.pop())}"


def _seen(outside: bool) -> str:
    """Return where a flank is seen from, in the words of the captions (`panels.how_drawn`)."""
    return "from outside" if outside else "through the tooth"
