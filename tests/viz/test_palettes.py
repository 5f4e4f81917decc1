"""Colours for values are monotonic in grey and agree with the legend; nothing is distinguished by colour
alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Annotation

from beveloid_geom import Design, builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_viz.components import cutter
from beveloid_viz.components.viewpoint import flank_views
from beveloid_viz.figures.paper import fig_02_rack, fig_04_meshing, fig_11_contact_ratio
from beveloid_viz.figures.results import (
    parabola_map,
    pattern as fig_pattern,
    tolerance_cloud,
    transmission_error,
)
from beveloid_viz.figures.results.pattern import BandFigure
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size
from beveloid_viz.rendering.scene import Tube

from .pages import distances

BANDS = [(*colours, bare) for colours in (fig_pattern.BLUES, fig_pattern.HUES) for bare in fig_pattern.BARE]
MAPS = sorted({one.colours for one in parabola_map.QUANTITIES.values() if one.scale != "cyclic"})


def lightness(colours: Sequence[str] | FloatArray) -> FloatArray:
    """Return CIE L* (n,), 0 to 100, from the luminance of linear sRGB (IEC 61966-2-1)."""
    rgb = np.array([to_rgb(colour) for colour in colours])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    luminance = linear @ (0.2126, 0.7152, 0.0722)
    return np.where(luminance > (6 / 29) ** 3, 116.0 * np.cbrt(luminance) - 16.0, luminance * (29 / 3) ** 3)


@pytest.mark.parametrize("colours", BANDS)
def test_bands_grow_lighter_up_to_bare_metal(colours: tuple[str, ...]) -> None:
    assert np.diff(lightness(colours)).min() > 4.0


@pytest.mark.parametrize("name", MAPS)
def test_colours_of_maps_are_monotonic_in_grey(name: str) -> None:
    steps = np.diff(lightness(mpl.colormaps[name](np.linspace(0.0, 1.0, 65))[:, :3]))
    assert steps.min() > 0.0


def test_a_cloud_is_darker_than_metal_and_a_wider_one_lighter() -> None:
    (_, wide, _), (_, narrow, _) = tolerance_cloud.CLOUDS
    assert lightness([wide])[0] > lightness(theme.METALS).max() + 10.0
    assert lightness([narrow])[0] < lightness(theme.METALS).min() - 20.0


def test_bars_and_marks_differ_without_colours() -> None:
    assert len({hatch for _, hatch in transmission_error.LOOKS}) == len(transmission_error.LOOKS)
    assert len({marker for *_, marker in fig_11_contact_ratio.LOOKS.values()}) == 2


def test_working_pitch_circles_are_dashed() -> None:
    """Working pitch circles are drawn as dashes, reference circles as one line each."""
    items = fig_04_meshing._items(fig_04_meshing.compute(builtin_design()), 1.0)
    count = Counter(item.colour for item in items if isinstance(item, Tube))
    assert [count[ink] for ink in fig_04_meshing.LINE_COLOURS] == [1, 1]
    assert count[theme.VERMILLION] > 50


def test_the_radius_of_the_round_ends_on_it() -> None:
    """The arrow of the tip radius begins at the centre of the round and ends on the profile of the tool."""
    data = fig_02_rack.compute(builtin_design())
    with theme.style():
        page = fig_02_rack.draw(data, of_size((1600, 1200))).page
    (axes,) = page.axes
    (cross,) = (line for line in axes.lines if line.get_marker() == "+")
    centre = np.array([np.ravel(cross.get_xdata())[0], np.ravel(cross.get_ydata())[0]])
    arrows = (note for note in axes.texts if isinstance(note, Annotation))
    (tip,) = (note.xy for note in arrows if note.xyann == tuple(centre))
    profile = cutter.profile(data.profiles[0], data.module, 3)
    assert distances(np.array(tip), profile) < 1e-3 * data.module


def striped(data: BandFigure) -> BandFigure:
    """Return a figure with values that increase through all bands from root to tip."""
    columns = []
    for column in data.columns:
        assert column.layers
        layers = []
        for layer in column.layers:
            ramp = np.linspace(0.0, len(data.bands), layer.values.shape[0])
            ends = (*data.bands, 2.0 * data.bands[-1] - data.bands[-2])
            values = np.repeat(
                np.interp(ramp, np.arange(len(ends)), ends)[:, None], layer.values.shape[1], axis=1
            )
            # As if all points were opposite to the mating flank.
            border = None if layer.border is None else np.stack((values, np.ones_like(values)))
            layers.append(replace(layer, values=values, border=border))
        columns.append(replace(column, layers=(layers[0], layers[1])))
    return replace(data, columns=tuple(columns))


@pytest.mark.slow
@pytest.mark.parametrize("compute", [fig_pattern.compute_pattern, fig_pattern.compute_separation])
def test_pixels_of_a_band_are_the_legends(compute: Callable[[Design], BandFigure]) -> None:
    """Pixels in the middle half of each band, away from the path, have the colour of the legend."""
    data = striped(compute(builtin_design()))
    with theme.style():
        drawing = fig_pattern.draw(data, of_size((1600, 1200)))
    legend = next(image for axes in drawing.page.axes for image in axes.images if image.get_cmap().N < 20)
    hues = [round(255.0 * part) for k in range(len(data.colours)) for part in legend.get_cmap()(k)[:3]]
    colours = np.reshape(hues, (-1, 3))
    for k, column in enumerate(data.columns):
        for number, layer in enumerate(column.layers or ()):
            picture = drawing.pictures[f"{('pinion', 'gear')[number]}-{k}"]
            view = flank_views(column.design, column.flank, 4.0, outside=True)[number]
            assert view is not None
            counted = np.interp(layer.values, data.bands, np.arange(len(data.bands)))
            inside = (np.abs(counted % 1.0 - 0.5) < 0.25) & (counted < len(colours))
            inside[:, :2] = inside[:, -2:] = False
            x, y = np.floor(picture.project(view.place(layer.points[inside]))).astype(int).T
            track = picture.project(view.place(layer.trace.points))
            free = distances(np.stack((x, y), axis=-1), track) > 20.0
            own = np.floor(counted[inside]).astype(int)[free]
            assert np.abs(picture.image[y[free], x[free]] - colours[own]).max() <= 2.0
            assert (np.bincount(own, minlength=len(colours)) > 20).all()
