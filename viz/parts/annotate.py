"""Dimension lines, frames and labels laid over a picture at the pixels of points in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike

from beveloid_geom.arrays import FloatArray

from ..stage import theme
from ..stage.scene import Picture

Offset = tuple[float, float]
"""To the right and up, in points of the page."""
HALO = 3.0
SIDEWAYS = 0.5
"""Sine of the slope from upright beyond which words stand beside an arrow, not over it."""
END_ON = 0.12
"""Share of its length below which an axis is seen end on."""


def text(axes: Axes, pixel: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any) -> None:
    """Words at a pixel, with a white rim so that they stay readable on metal."""
    settings = {"fontsize": theme.LABEL, "ha": "center", "va": "center", "color": theme.INK, **style}
    axes.annotate(
        words,
        tuple(np.asarray(pixel, dtype=float)),
        xytext=offset,
        textcoords="offset points",
        annotation_clip=False,
        path_effects=[withStroke(linewidth=HALO, foreground="white")],
        zorder=5,
        **settings,
    )


def label(
    axes: Axes, picture: Picture, point: ArrayLike, words: str, offset: Offset = (0.0, 0.0), **style: Any
) -> None:
    """Words beside a point in space."""
    text(axes, picture.project(point), words, offset, **style)


def note(axes: Axes, picture: Picture, point: ArrayLike, words: str, offset: Offset, **style: Any) -> None:
    """Words beside a point in space, with a thin line that leads to it."""
    settings = {"fontsize": theme.LABEL, "ha": "center", "va": "center", "color": theme.INK, **style}
    axes.annotate(
        words,
        tuple(picture.project(point)),
        xytext=offset,
        textcoords="offset points",
        annotation_clip=False,
        arrowprops={
            "arrowstyle": "-",
            "color": settings["color"],
            "linewidth": 1.0,
            "shrinkA": 2,
            "shrinkB": 1,
        },
        path_effects=[withStroke(linewidth=HALO, foreground="white")],
        zorder=5,
        **settings,
    )


def line(axes: Axes, picture: Picture, points: ArrayLike, **style: Any) -> None:
    """A polyline (n, 3) in space, over everything else."""
    settings = {"color": theme.GREY, "linewidth": 1.2, "zorder": 3, **style}
    axes.plot(*picture.project(points).T, **settings)


def axis_line(axes: Axes, picture: Picture, start: ArrayLike, end: ArrayLike, colour: str) -> None:
    """A centre line, dash-dotted."""
    line(axes, picture, np.stack((start, end)), color=colour, linewidth=1.3, dashes=(12, 3, 2, 3))


def arrow(
    axes: Axes, tail: ArrayLike, head: ArrayLike, colour: str, width: float = 1.8, ends: str = "-|>"
) -> None:
    """An arrow between two pixels."""
    axes.annotate(
        "",
        tuple(np.asarray(head, dtype=float)),
        xytext=tuple(np.asarray(tail, dtype=float)),
        annotation_clip=False,
        zorder=4,
        arrowprops={
            "arrowstyle": ends,
            "color": colour,
            "linewidth": width,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
            "mutation_scale": 7.0 + 5.0 * width,
        },
    )


def dimension(
    axes: Axes,
    picture: Picture,
    start: ArrayLike,
    end: ArrayLike,
    words: str,
    offset: Offset = (0.0, 10.0),
    at: float = 0.5,
    **style: Any,
) -> None:
    """A dimension line between two points in space with its words beside it, `at` a share of it."""
    colour = style.get("color", theme.INK)
    a, b = picture.project(start), picture.project(end)
    arrow(axes, a, b, colour, 1.2, "<|-|>")
    text(axes, a + at * (b - a), words, offset, **style)


def arc(centre: ArrayLike, first: ArrayLike, second: ArrayLike, radius: float, count: int = 33) -> FloatArray:
    """Points (count, 3) of the circle about `centre` from the unit vector `first` to `second`."""
    u, v = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    angle = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
    across = v - (u @ v) * u
    size = np.linalg.norm(across)
    across = across / size if size > 0.0 else across
    turn = np.linspace(0.0, angle, count)[:, None]
    return np.asarray(np.asarray(centre) + radius * (np.cos(turn) * u + np.sin(turn) * across))


def arrow_along(
    axes: Axes, picture: Picture, points: FloatArray, colour: str, width: float = 1.5, both: bool = False
) -> None:
    """A curve (n, 3) in space with an arrow head at its end, or at both ends."""
    pixels = picture.project(points)
    axes.plot(*pixels.T, color=colour, linewidth=width, zorder=3)
    arrow(axes, pixels[-3], pixels[-1], colour, width)
    if both:
        arrow(axes, pixels[2], pixels[0], colour, width)


def triad(
    axes: Axes,
    picture: Picture,
    origin: ArrayLike,
    vectors: ArrayLike,
    length: float,
    names: Sequence[str],
    colour: str,
    title: str = "",
    offset: Offset = (-14.0, -12.0),
) -> None:
    """A frame: arrows `length` mm long from `origin` along the rows of `vectors`, with the `names`
    of its axes in mathematical type; one with an empty name is left out. `title` names the frame
    beside its origin, moved by `offset`."""
    start = picture.project(origin)
    full = length * picture.px_per_mm
    for name, vector in zip(names, np.asarray(vectors, dtype=float), strict=True):
        if not name:
            continue
        tip = picture.project(np.asarray(origin) + length * vector)
        way = tip - start
        seen = float(np.linalg.norm(way))
        if seen < END_ON * full:
            away = float(vector @ picture.camera.axes[2]) < 0.0
            axes.plot(*start, "o", ms=9, mfc="white", mec=colour, mew=1.6, zorder=4)
            axes.plot(*start, "x" if away else ".", ms=5, color=colour, mew=1.2, zorder=5)
            text(axes, start, f"${name}$", (-13.0, 11.0), color=colour)
            continue
        arrow(axes, start, tip, colour, 1.8)
        shift = way / seen * (1.0, -1.0)
        side = "left" if shift[0] > SIDEWAYS else "right" if shift[0] < -SIDEWAYS else "center"
        reach = 5.0 if side != "center" else 12.0
        text(axes, tip, f"${name}$", (reach * shift[0], 11.0 * shift[1]), color=colour, ha=side)
    if title:
        text(axes, start, f"${title}$", offset, color=colour, fontweight="bold", fontsize=theme.HEADING)
