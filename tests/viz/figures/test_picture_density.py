"""Mesh density of pictures: finer meshes than those of the figures are not visible, coarser ones are.

Smooth shading hides facets, so coarse meshes are visible on outlines. A single anti-aliasing sample changes a
pixel by about thirty levels, even for a small displacement. The mean over the pixels of an outline in a
window is therefore compared."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from beveloid_geom import builtin_design, sample_flank
from beveloid_viz.components import panels, posed, viewpoint
from beveloid_viz.figures.paper import fig_01_pair as fig_pair
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.scene import MESH_PX, Scene, render

NOTICEABLE = 6
"""Just noticeable difference, levels of 255: 2.3 in the lightness of CIELAB (Mahy et al. 1994) is 5.5 to 6.5
levels of a grey between 90 and 240."""
WINDOW = 32
"""Side of the square over which differences are averaged, pixels: 1 degree at 0.5 m from a screen of 96
pixels per inch."""
FINEST = 0.4
"""Tolerance of the reference picture as a fraction of the tolerance of the figures."""
STRETCHED = 2.0
"""Magnification from root to tip as in Figs. 7 to 10."""


def worst_place(image: NDArray[Any], finest: NDArray[Any]) -> float:
    """Return the largest mean difference (levels) of pixels on outlines in a window."""
    whole = finest.astype(int)
    span = maximum_filter(whole, (3, 3, 1)) - minimum_filter(whole, (3, 3, 1))
    on_outline = span.max(axis=-1) > 4 * NOTICEABLE
    levels = np.where(on_outline, np.abs(image.astype(int) - whole).max(axis=-1), 0).astype(float)
    share, total = (uniform_filter(x.astype(float), WINDOW, mode="constant") for x in (on_outline, levels))
    stretch = on_outline & (share * WINDOW > 1.0 - 1e-9)
    return float((total[stretch] / share[stretch]).max())


def pair_at(size: tuple[int, int], pixels: float) -> Scene:
    """Return the pair of Fig. 1 with a tolerance in pixels."""
    pair = posed.pose(builtin_design())
    camera = fig_pair.camera_of(pair, size)
    items, _ = fig_pair.items_of(pair, pixels * 2.0 * camera.half_height / size[1])
    return Scene(items, camera)


def flank_at(size: tuple[int, int], pixels: float) -> Scene:
    """Return a flank as in Figs. 7 to 10, larger."""
    member = builtin_design().pinion
    view = viewpoint.flank_view(member, "right", STRETCHED)
    assert view is not None
    px_per_mm = 0.92 * float(np.min(size / view.span))
    grid = sample_flank(member, "right", pixels / (px_per_mm * STRETCHED))
    surface = panels.lit_flank(grid.points, grid.normals, view, theme.METALS[0])
    return Scene([surface], panels.flank_camera(view, 0.5 * size[1] / px_per_mm))


@pytest.mark.parametrize(
    ("scene_at", "size", "default"),
    [(pair_at, (830, 632), MESH_PX), (flank_at, (240, 360), panels.OUTLINE_PX)],
)
def test_a_finer_mesh_is_not_seen(
    scene_at: Callable[[tuple[int, int], float], Scene], size: tuple[int, int], default: float
) -> None:
    at = partial(scene_at, size)
    finest, usual, coarse = (render(at(share * default), size).image for share in (FINEST, 1.0, 20.0))
    print(worst_place(usual, finest), worst_place(coarse, finest))
    assert worst_place(usual, finest) < NOTICEABLE
    assert worst_place(coarse, finest) > NOTICEABLE
