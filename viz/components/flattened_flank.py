"""Flanks projected onto their mid-plane, with results on them.

The face width is horizontal, the tip is at the top; mm. Right flanks are seen from outside, left flanks
through the tooth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from beveloid_geom import ContactPath, Member, Status
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.parallel.lines import ContactLines
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.operation.contact_pattern.pattern import MemberPattern
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.status import FirstStatus
from beveloid_geom.support.frozen_arrays import cached

from ..rendering import theme
from .annotate import PATH_ARROW
from .paths_table import LINE_COUNT, points_on
from .viewpoint import FlankView, flank_view

BAND_FRACTIONS = (0.25, 0.5, 1.0)
"""Fractions of the thickness of the marking compound at which the shading of a pattern changes. Separation:
distance of the flanks along the normal. Pattern: area whose separation is below this thickness."""
ROLLS_PER_POINT = 8
"""Number of rolls of a mesh cycle per contact point drawn."""


@dataclass(frozen=True, eq=False)
class FlatFlank:
    """Active flank of a member, projected onto the plane perpendicular to the normal at its middle.

    The outline (n, 2) has x from mid-face, and y from the root at mid-face towards the tip, mm.
    """

    member: Member
    flank: str
    view: FlankView
    outline: FloatArray

    def place(self, points: FloatArray) -> FloatArray:
        """Return the coordinates (..., 2) of points (..., 3) in the frame of the member, mm."""
        flat = self.view.place(points)[..., 1::-1]
        return np.asarray(flat - self.view.marks[0, 1, 1::-1] * (0.0, 1.0))

    def at(self, l: FloatArray, z: FloatArray) -> FloatArray:
        """Return the coordinates (..., 2) of flank parameters l in the planes z, mm."""
        return self.place(flank_point(self.member, self.flank, l, z=z))

    @property
    def span(self) -> FloatArray:
        """Width and height, mm."""
        return np.asarray(np.ptp(self.outline, axis=0))


@cached(8)
def flat_flank(member: Member, flank: str) -> FlatFlank | None:
    """Return the projected flank; None if the flank does not reach its tip."""
    view = flank_view(member, flank)
    if view is None:
        return None
    half = 0.5 * float(member.face_width)
    along, up = half * np.linspace(-1.0, 1.0, 25), np.linspace(0.0, 1.0, 9)
    root, tip = active_start(member, flank, along), tip_parameter(member, flank, along)
    ends = [root[k] + up * (tip[k] - root[k]) for k in (-1, 0)]
    l = [root, ends[0], tip[::-1], ends[1][::-1]]
    z = [along, half + 0.0 * up, along[::-1], -half + 0.0 * up]
    flat = FlatFlank(member, flank, view, np.zeros((0, 2)))
    outline = flat.at(np.concatenate(l), np.concatenate(z))
    return FlatFlank(member, flank, view, outline) if np.isfinite(outline).all() else None


def outline(axes: Axes, flat: FlatFlank, scale: float, colour: str, width: float) -> None:
    """Draw the outline with names of its four sides, at `scale` pixels per mm, centred in axes `width` pixels
    wide."""
    low, high = flat.outline.min(axis=0), flat.outline.max(axis=0)
    middle = 0.5 * (low[0] + high[0])
    axes.set_xlim(middle - 0.5 * width / scale, middle + 0.5 * width / scale)
    axes.set_ylim(low[1], high[1])
    axes.add_patch(Polygon(flat.outline, facecolor=colour, alpha=0.22, edgecolor="none", clip_on=False))
    axes.add_patch(Polygon(flat.outline, fill=False, edgecolor=theme.GREY, linewidth=1.0, clip_on=False))
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_position(("outward", 17.0))
    step = theme.round_length(0.26 * (high[0] - low[0]))
    ticks = np.arange(np.ceil(low[0] / step), np.floor(high[0] / step) + 1.0) * step
    axes.set_xticks(ticks, [f"{tick + 0.0:g}".replace("-", "\u2212") for tick in ticks])
    axes.spines["bottom"].set_bounds(ticks[0], ticks[-1])
    axes.set_yticks([])
    axes.tick_params(length=3.0, pad=2.0)
    root, _, tip = flat.view.marks[:, 1]
    back, front = flat.view.ends
    sides = (
        (back, (low[0], 0.5 * (low[1] + high[1])), (-7.0, 0.0), "right", "center"),
        (front, (high[0], 0.5 * (low[1] + high[1])), (7.0, 0.0), "left", "center"),
        ("tip", (tip[1], tip[0] - root[0]), (0.0, 4.0), "center", "bottom"),
        ("root", (root[1], 0.0), (0.0, -3.0), "center", "top"),
        ("mm", (ticks[-1], low[1]), (14.0, -17.0), "left", "top"),
    )
    for word, at, away, ha, va in sides:
        style = {"fontsize": mpl.rcParams["legend.fontsize"], "color": theme.GREY}
        theme.label_point(axes, at, word, away, ha=ha, va=va, **style)


def path(axes: Axes, flat: FlatFlank, contact: ContactPath, number: int, width: float) -> None:
    """Draw the path on pinion (0) or gear (1): a dot at its start, an arrow head at its end."""
    good = contact.status == Status.SOLVED
    points = flat.place(points_on(contact, number))[good]
    if len(points) < 2:
        return
    axes.plot(
        *points.T, color=theme.VERMILLION, linewidth=width, clip_on=False, solid_capstyle="butt", zorder=4
    )
    axes.plot(*points[0], "o", color=theme.VERMILLION, markersize=2.7 * width, clip_on=False, zorder=4)
    arrow = {**PATH_ARROW, "color": theme.VERMILLION, "linewidth": width}
    start = points[max(len(points) - 8, 0)]
    axes.annotate("", tuple(points[-1]), tuple(start), arrowprops=arrow, annotation_clip=False, zorder=4)


def lines(axes: Axes, flat: FlatFlank, contact: ContactLines, number: int) -> None:
    """Draw some of the lines of contact on pinion (0) or gear (1)."""
    l, z = ((contact.l1, contact.pinion_z), (contact.l2, contact.gear_z))[number]
    for one in np.linspace(0, len(l) - 1, LINE_COUNT + 2).astype(int)[1:-1]:
        axes.plot(*flat.at(l[one], z[one]).T, color=theme.INK, linewidth=1.2, zorder=3)


def contacts(axes: Axes, flat: FlatFlank, report: OperationReport, number: int) -> None:
    """Draw the first contacts of all teeth over a mesh cycle: filled on flanks, hollow on edges."""
    first = report.first
    good = (first.status == FirstStatus.SOLVED) & ~first.on_fillet[:, number]
    good &= np.arange(good.size) % ROLLS_PER_POINT == 0
    edge = first.limit[:, 0] >= 0
    l, z = ((first.l1, first.z1), (first.l2, first.z2))[number]
    for chosen, face, size in ((good & ~edge, theme.BLUE, 4.0), (good & edge, "none", 4.6)):
        if chosen.any():
            style: dict[str, Any] = {"mec": theme.BLUE, "mfc": face, "mew": 1.2, "ms": size}
            axes.plot(*flat.at(l[chosen], z[chosen]).T, "o", clip_on=False, zorder=5, **style)


def shade_pattern(axes: Axes, flat: FlatFlank, side: MemberPattern, separation: float) -> None:
    """Shade the area whose separation is below `separation`, mm, in bands at its BAND_FRACTIONS.

    Contours are interpolated in the square root of the separation, which is nearly linear next to the
    path."""
    x, y = np.moveaxis(flat.place(side.points), -1, 0)
    root = np.ma.masked_invalid(np.sqrt(np.maximum(side.least, 0.0)))
    if root.count() == 0 or float(root.min()) > np.sqrt(separation):
        return
    for share in BAND_FRACTIONS:
        levels = [-1.0, float(np.sqrt(share * separation))]
        axes.contourf(x, y, root, levels, colors=[theme.BLUE], alpha=0.16, antialiased=True)


def boundary_of(*grids: FloatArray) -> FloatArray:
    """Return the values on the boundary of grids (rows, columns, ...) of coordinates, as columns (n, ...)."""
    sides = [np.concatenate((grid[:, 0], grid[-1], grid[::-1, -1], grid[0, ::-1])) for grid in grids]
    return np.stack(sides, axis=-1) if len(sides) > 1 else sides[0]


def side_view(axes: Axes, z: FloatArray, r: FloatArray, least: FloatArray, separation: float) -> FloatArray:
    """Shade the area of a flank over z and r, mm, in bands at BAND_FRACTIONS of `separation`; return the
    boundary (n, 2) of the flank. `least`: smallest separation at each point during the mesh; both in mm."""
    # Colours of BAND_FRACTIONS in side views.
    shades = ("#6baed6", "#9ecae1", "#d0e3f2")
    root = np.ma.masked_invalid(np.sqrt(np.maximum(least, 0.0)))
    for share, shade in zip(BAND_FRACTIONS[::-1], shades[::-1], strict=True):
        axes.contourf(z, r, root, [-1.0, float(np.sqrt(share * separation))], colors=[shade])
    boundary = boundary_of(z, r)
    axes.add_patch(Polygon(boundary, fill=False, edgecolor=theme.GREY, linewidth=1.2))
    return boundary
