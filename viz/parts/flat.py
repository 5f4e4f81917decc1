"""Flanks laid flat, and what lies on them: along the face to the right, towards the tip upwards, in mm.

Right flanks are then seen from outside, left ones through the tooth.
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
from beveloid_geom.gear.flank import flank_point, root_parameter, tip_parameter, trace_parameter
from beveloid_geom.operation.marking.pattern import MemberPattern
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.status import FirstStatus

from ..stage import theme
from .solved import LINES, points_on
from .viewpoint import FlankView, flank_view

FACE, DEPTH = 25, 9
"""Points along the sides of an outline."""
BANDS = (0.25, 0.5, 1.0)
"""Shares of a pattern's separation at which it is shaded."""
EVERY = 8
"""Of the rolls of a mesh cycle, those whose contact points are drawn."""


@dataclass(frozen=True, eq=False)
class FlatFlank:
    """One active flank of `member`, with its outline (n, 2) in the plane square on to its middle: x from
    mid-face towards the heel, y from the root at mid-face towards the tip, mm."""

    member: Member
    flank: str
    view: FlankView
    outline: FloatArray

    def place(self, points: FloatArray) -> FloatArray:
        """Give points (..., 3) of the member's own frame in the chart (..., 2)."""
        flat = self.view.place(points)[..., 1::-1]
        return np.asarray(flat - self.view.frame[0, 1, 1::-1] * (0.0, 1.0))

    def at(self, l: FloatArray, z: FloatArray) -> FloatArray:
        """Give places (..., 2) of flank parameters l in the planes z, mm."""
        return self.place(
            flank_point(self.member, self.flank, l, trace_parameter(self.member, self.flank, l, z))
        )

    @property
    def span(self) -> FloatArray:
        """Width and height, mm."""
        return np.asarray(np.ptp(self.outline, axis=0))


def flat_flank(member: Member, flank: str) -> FlatFlank | None:
    """Give the flank laid flat; None if it does not reach its tip."""
    view = flank_view(member, flank)
    if view is None:
        return None
    half, root = 0.5 * float(member.face_width), root_parameter(member)
    along, up = half * np.linspace(-1.0, 1.0, FACE), np.linspace(0.0, 1.0, DEPTH)
    tip = tip_parameter(member, flank, along)
    l = [root + 0.0 * along, root + up * (tip[-1] - root), tip[::-1], root + up[::-1] * (tip[0] - root)]
    z = [along, half + 0.0 * up, along[::-1], -half + 0.0 * up]
    flat = FlatFlank(member, flank, view, np.zeros((0, 2)))
    outline = flat.at(np.concatenate(l), np.concatenate(z))
    return FlatFlank(member, flank, view, outline) if np.isfinite(outline).all() else None


def outline(axes: Axes, flat: FlatFlank, scale: float, colour: str, width: float) -> None:
    """Draw the flank's outline, its four sides named, at `scale` pixels a mm, in the middle of axes `width`
    pixels wide."""
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
    root, _, tip = flat.view.frame[:, 1]
    sides = (
        ("toe", (low[0], 0.5 * (low[1] + high[1])), (-7.0, 0.0), "right", "center"),
        ("heel", (high[0], 0.5 * (low[1] + high[1])), (7.0, 0.0), "left", "center"),
        ("tip", (tip[1], tip[0] - root[0]), (0.0, 4.0), "center", "bottom"),
        ("root", (root[1], 0.0), (0.0, -3.0), "center", "top"),
        ("mm", (ticks[-1], low[1]), (14.0, -17.0), "left", "top"),
    )
    for word, at, away, ha, va in sides:
        style = {"fontsize": mpl.rcParams["legend.fontsize"], "color": theme.GREY}
        theme.beside(axes, at, word, away, ha=ha, va=va, **style)


def path(axes: Axes, flat: FlatFlank, found: ContactPath, number: int, width: float) -> None:
    """Draw the path on pinion (0) or gear (1) from its dot to its arrow head."""
    good = found.status == Status.SOLVED
    points = flat.place(points_on(found, number))[good]
    if len(points) < 2:
        return
    axes.plot(*points.T, color=theme.RED, linewidth=width, clip_on=False, solid_capstyle="butt", zorder=4)
    axes.plot(*points[0], "o", color=theme.RED, markersize=2.7 * width, clip_on=False, zorder=4)
    arrow = {"arrowstyle": "-|>,head_width=0.3,head_length=0.6", "color": theme.RED, "linewidth": width}
    arrow |= {"shrinkA": 0.0, "shrinkB": 0.0}
    start = points[max(len(points) - 8, 0)]
    axes.annotate("", tuple(points[-1]), tuple(start), arrowprops=arrow, annotation_clip=False, zorder=4)


def lines(axes: Axes, flat: FlatFlank, found: ContactLines, number: int) -> None:
    """Draw some of the lines of contact on pinion (0) or gear (1)."""
    l, z = ((found.l1, found.pinion_z), (found.l2, found.gear_z))[number]
    for one in np.linspace(0, len(l) - 1, LINES + 2).astype(int)[1:-1]:
        axes.plot(*flat.at(l[one], z[one]).T, color=theme.INK, linewidth=1.2, zorder=3)


def contacts(axes: Axes, flat: FlatFlank, report: OperationReport, number: int) -> None:
    """Draw the points of first contact of all teeth over a mesh cycle: on flanks full, on edges hollow."""
    first = report.first
    good = (first.status == FirstStatus.SOLVED) & ~first.on_fillet[:, number]
    good &= np.arange(good.size) % EVERY == 0
    edge = first.limit[:, 0] >= 0
    l, z = ((first.l1, first.z1), (first.l2, first.z2))[number]
    for chosen, face, size in ((good & ~edge, theme.BLUE, 4.0), (good & edge, "none", 4.6)):
        if chosen.any():
            style: dict[str, Any] = {"mec": theme.BLUE, "mfc": face, "mew": 1.2, "ms": size}
            axes.plot(*flat.at(l[chosen], z[chosen]).T, "o", clip_on=False, zorder=5, **style)


def pattern(axes: Axes, flat: FlatFlank, side: MemberPattern, separation: float) -> None:
    """Shade where the flanks come close, in bands of the separation, on the root of which the area rests."""
    x, y = np.moveaxis(flat.place(side.points), -1, 0)
    root = np.ma.masked_invalid(np.sqrt(np.maximum(side.least, 0.0)))
    if root.count() == 0 or float(root.min()) > np.sqrt(separation):
        return
    for share in BANDS:
        levels = [-1.0, float(np.sqrt(share * separation))]
        axes.contourf(x, y, root, levels, colors=[theme.BLUE], alpha=0.16, antialiased=True)
