"""Pictures of other figures, drawn with meshes from coarse to fine, timed and compared.

Smooth shading hides facets, so what is left of a coarse mesh is seen on outlines. Anti-aliasing has a
few samples a pixel; where one of them changes sides a pixel changes by about thirty levels, however
little the outline moved. Hence single pixels say little. What tells is the mean over the pixels of a
stretch of outline, or of the surfaces beside it: see `worst_place`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.model import Design
from beveloid_geom.shapes.sampling import sample_flank

from ...parts import panels, posed, solved
from ...stage import theme
from ...stage.scene import MESH_PX, Item, Picture, Scene, Size, Surface, render
from ..paper import fig_01_pair as fig_pair
from ..results import posed_pair as fig_posed

FLANK = "right"
STRETCHED = 2.0
"""How much wider than long the flank is drawn, as in Figs. 7 to 10."""
PAGE = (1000, 750)
"""The page, in pixels, on which the pictures would stand as large as here."""
TOLERANCES = (2.0, 0.5, 0.2, 0.1, 0.03)
"""Pixels by which triangles may miss the surfaces; each figure's own takes the place of one near it, or
is added."""
NEAR = 1.1
FINER = 0.25
"""The tolerance of the picture with which the others are compared, as a share of the finest of them."""
NOTICEABLE = 6
"""Levels of 255 that are just noticeable: 2.3 in the lightness of CIELAB (Mahy et al. 1994) are
5.5 to 6.5 levels of a grey between 90 and 240."""
OUTLINE = 4 * NOTICEABLE
"""Levels by which the 3 x 3 pixels around one on an outline differ at least: elsewhere one of four
samples that changes sides is not noticed."""
WINDOW = 32
"""Side, in pixels, of the square over which differences are averaged: about what is looked at at once
(1 degree, at 0.5 m from a screen of 96 pixels an inch)."""
CROP = (64, 36)
"""Height and width, in pixels, of the part of each picture that is shown."""

Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class View:
    """A picture of another figure: its size and scale, the tolerance (pixels) used there, and its
    scene for any tolerance (mm). `build` raises ValueError with the reason where there is nothing to draw."""

    size: Size
    px_per_mm: float
    default: float
    build: Callable[[float], Scene]


@dataclass(frozen=True)
class Difference:
    """How two pictures differ, in levels of 255, pixels by the greatest of their three colours: the
    share that differs at all, the share that does so noticeably, greatest and mean difference, and
    the mean in the worst place."""

    differing_share: float
    noticeable_share: float
    greatest: float
    mean: float
    worst_place: float


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture at one tolerance (mm, and pixels): the triangles of all that is drawn, seconds to sample
    and to render them, the difference from the finest picture, and the part (rows, columns, 3) of it to
    show."""

    tolerance: float
    pixels: float
    triangles: int
    sampling: float
    rendering: float
    difference: Difference
    crop: Image

    @property
    def seconds(self) -> float:
        """To sample and to render."""
        return self.sampling + self.rendering


@dataclass(frozen=True, eq=False)
class Series:
    """The shots of a picture from coarse to fine, the last being the finest, and which of them has the
    figure's own tolerance; or the reason why there are none."""

    name: str
    shots: tuple[Shot, ...] = ()
    default: int = 0
    reason: str = ""


def pair_view(design: Design, size: Size) -> View:
    """The whole pair of Fig. 1."""
    pair = posed.pose(design, FLANK)
    camera = fig_pair.camera_of(pair, size)
    px_per_mm = size[1] / (2.0 * camera.half_height)

    def build(tolerance: float) -> Scene:
        items, remarks = fig_pair.items_of(pair, tolerance)
        if remarks:
            raise ValueError(" ".join(remarks))
        return Scene(items, camera)

    return View(size, px_per_mm, MESH_PX, build)


def flank_view(design: Design, size: Size) -> View:
    """The pinion's flank with the path, as in Figs. 7 to 10, larger."""
    view = panels.flank_view(design.pinion, FLANK, STRETCHED)
    if view is None:
        raise ValueError("the flank ends short of its tip")
    path = solved.solve(design, FLANK)
    px_per_mm = 0.92 * float(np.min(size / view.span))
    radius = panels.LINE_POINTS * PAGE[0] / theme.PAGE_INCHES[0] / 72.0 / px_per_mm
    traces = panels.trace_items(panels.Trace(path.points[0]), view, radius)
    camera = panels.camera_of(view, 0.5 * size[1] / px_per_mm)

    def build(tolerance: float) -> Scene:
        grid = sample_flank(design.pinion, FLANK, tolerance)
        items: list[Item] = [panels.surface(grid, view, theme.STEEL), *traces]
        return Scene(items, camera)

    return View(size, px_per_mm * STRETCHED, panels.OUTLINE_PX, build)


def teeth_view(design: Design, size: Size) -> View:
    """The teeth in mesh of the posed pair, without the lines that show its triangles."""
    none = tuple((None, "") for _ in posed.NAMES)
    data = fig_posed.PosedFigure(posed.pose(design, FLANK), none, solved.solve(design, FLANK))
    if not np.isfinite(data.pair.contact).all():
        raise ValueError("the flanks share no contact point to look at")

    def build(tolerance: float) -> Scene:
        meshes = tuple(posed.teeth_of(member, tolerance) for member in design.members)
        reasons = [f"{name}: {why}" for name, (_, why) in zip(posed.NAMES, meshes, strict=True) if why]
        if reasons:
            raise ValueError("; ".join(reasons))
        scene = fig_posed.close(replace(data, meshes=meshes))
        return replace(scene, items=[_without_lines(item) for item in scene.items])

    px_per_mm = size[1] / (2.0 * fig_posed.close(data).camera.half_height)
    return View(size, px_per_mm, fig_posed.tolerance_of(design) * px_per_mm, build)


def _without_lines(item: Item) -> Item:
    return replace(item, mesh_lines=False) if isinstance(item, Surface) else item


VIEWS: dict[str, tuple[Callable[[Design, Size], View], Size]] = {
    "pair (Fig. 1)": (pair_view, (830, 632)),
    "flank (Figs. 7 to 10)": (flank_view, (240, 360)),
    "teeth in mesh (posed pair)": (teeth_view, (420, 562)),
}


def measure(name: str, view: View, tolerances: Sequence[float] = TOLERANCES) -> Series:
    """Draw a picture at these tolerances (pixels) and at its own. Raises ValueError as `build` does."""
    others = (pixels for pixels in tolerances if not 1.0 / NEAR < pixels / view.default < NEAR)
    wanted = sorted((view.default, *others), reverse=True)
    wanted.append(FINER * wanted[-1])
    render(view.build(wanted[0] / view.px_per_mm), (64, 64))  # what is loaded once is not timed
    taken = [_take(view, pixels / view.px_per_mm) for pixels in wanted]
    reference = taken[-1][0].image
    on_outline = outlines(reference)
    window = _worst_window(taken[0][0].image, reference)
    shots = tuple(
        Shot(
            pixels / view.px_per_mm,
            pixels,
            picture.triangles,
            sampling,
            rendering,
            compare(picture.image, reference, on_outline),
            picture.image[window],
        )
        for pixels, (picture, sampling, rendering) in zip(wanted, taken, strict=True)
    )
    return Series(name, shots, wanted.index(view.default))


def _take(view: View, tolerance: float) -> tuple[Picture, float, float]:
    """The picture, and the seconds to sample and to render it."""
    start = time.perf_counter()
    scene = view.build(tolerance)
    sampled = time.perf_counter()
    picture = render(scene, view.size)
    return picture, sampled - start, time.perf_counter() - sampled


def levels_between(image: Image, reference: Image) -> FloatArray:
    """Differences (rows, columns) of two pictures, levels of 255."""
    return np.asarray(np.abs(image.astype(float) - reference).max(axis=-1))


def compare(image: Image, reference: Image, on_outline: NDArray[np.bool_]) -> Difference:
    """How a picture differs from a finer one, of which some pixels are `on_outline`."""
    levels = levels_between(image, reference)
    return Difference(
        float((levels > 0).mean()),
        float((levels > NOTICEABLE).mean()),
        float(levels.max()),
        float(levels.mean()),
        worst_place(levels, on_outline),
    )


def outlines(image: Image) -> NDArray[np.bool_]:
    """The pixels (rows, columns) on outlines."""
    from scipy.ndimage import maximum_filter, minimum_filter

    whole = image.astype(int)
    span = maximum_filter(whole, (3, 3, 1)) - minimum_filter(whole, (3, 3, 1))
    return np.asarray(span.max(axis=-1) > OUTLINE)


def worst_place(levels: FloatArray, on_outline: NDArray[np.bool_]) -> float:
    """The greatest mean difference within a window: over its pixels on outlines, or over the rest.
    Fewer pixels than the window's side are no stretch of outline."""
    from scipy.ndimage import uniform_filter

    worst = 0.0
    for wanted in (on_outline, ~on_outline):
        share = uniform_filter(wanted.astype(float), WINDOW, mode="constant")
        total = uniform_filter(np.where(wanted, levels, 0.0), WINDOW, mode="constant")
        enough = wanted & (share * WINDOW > 1.0 - 1e-9)
        if enough.any():
            worst = max(worst, float((total[enough] / share[enough]).max()))
    return worst


def _worst_window(image: Image, reference: Image) -> tuple[slice, slice]:
    """The part of a picture that differs most."""
    from scipy.ndimage import uniform_filter

    blurred = uniform_filter(levels_between(image, reference), CROP)
    place = np.unravel_index(int(blurred.argmax()), blurred.shape)
    starts = [
        int(np.clip(at - size // 2, 0, max(whole - size, 0)))
        for at, size, whole in zip(place, CROP, blurred.shape, strict=True)
    ]
    return slice(starts[0], starts[0] + CROP[0]), slice(starts[1], starts[1] + CROP[1])
