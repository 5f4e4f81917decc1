"""Every figure is compared with reference pictures at a small size: renderings of VTK, and the page.

Software rendering differs by up to 3 of 255 levels on old processors. Differences up to 8 levels are ignored,
and the others are summed in whole pixels. Pages are compared without text, which depends on fonts, and
without pictures. Measured times and rounding errors are replaced by fixed numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray
from PIL import Image as Pillow

from beveloid_geom import builtin_design
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.shapes.proximity.mesh_convergence import Convergence
from beveloid_geom.validation.comparison import Measurement
from beveloid_geom.validation.near_singular import MethodErrors
from beveloid_viz.components.figure_steps import Drawing
from beveloid_viz.components.paths_table import SolvedPath
from beveloid_viz.figures import FIGURES, Figure
from beveloid_viz.figures.paper.fig_07_to_10_paths import PathFigure
from beveloid_viz.figures.paper.fig_12_to_15_misalignment import MisalignmentFigure
from beveloid_viz.figures.results.pattern import BandFigure
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size
from beveloid_viz.rendering.opengl import require_opengl
from beveloid_viz.rendering.theme import Page

from .pages import recipe_of, short_measurements

SNAPSHOTS = Path(__file__).parent / "snapshots"
SIZE = (800, 600)
NOISE_LEVELS = 8
LIMIT = 6.0
"""Largest difference of a picture, whole pixels. A path moved by 0.5 mm differs by far more."""
FLAT = {"fig-02", "fig-11", "transmission-error", "modifications", "sensitivity", "mesh-convergence"}
FLAT |= {"sliding", "speed-accuracy", "ease-off", "pattern-errors", "map-parabola", "stability", "method"}
SOLID = [figure for figure in FIGURES if figure.name not in FLAT]
WITHOUT_CURVES = {"meshed-tooth"}
"""Pages without curves."""
CHARTS = ["fig-02", "transmission-error", "ease-off"]
Image = NDArray[np.uint8]


@pytest.fixture(scope="module", autouse=True)
def _opengl() -> None:
    require_opengl()


@pytest.fixture(scope="module", autouse=True)
def _short_measurements() -> Iterator[None]:
    with short_measurements():
        yield


@cache
def data_of(name: str) -> Any:
    data = recipe_of(name).compute(builtin_design())
    if name == "speed-accuracy":
        return replace(data, measurements=tuple(map(measured, count(), data.measurements)))
    if name == "stability":
        return replace(data, errors=stepped(data.errors))
    if name == "mesh-convergence":
        found = {
            key: tuple(even(one, 1.0 + k) for k, one in enumerate(poses)) if key[1] else poses
            for key, poses in data.found.items()
        }
        return replace(data, found=found)
    return data


def measured(number: int, one: Measurement) -> Measurement:
    """Replace times and errors by values that do not depend on the machine."""
    time = 1e-6 * 1.7**number
    return replace(one, seconds=(0.8 * time, time, 1.5 * time), error_mm=10.0 ** -(number % 13))


def stepped(found: MethodErrors) -> MethodErrors:
    """Replace errors, which are rounding errors, by steps; all methods but the last lack the first one."""
    error = 10.0 ** -(np.arange(found.error.shape[1]) + 0.5 * np.arange(found.error.shape[0])[:, None])
    error[1:-1, 0] = np.nan
    return replace(found, error=error, stated=np.where(np.isfinite(found.stated), 30.0 * error, np.nan))


def even(found: Convergence, size: float) -> Convergence:
    """Replace errors of the polished mesh, which are rounding errors."""
    point, apart = (size * error * found.tolerance**0.1 for error in (1e-10, 1e-13))
    return replace(found, point_error=point, separation_error=apart)


@cache
def drawing(name: str) -> Drawing:
    return drawn(name, data_of(name))


def drawn(name: str, data: object) -> Drawing:
    return recipe_of(name).drawn(data, of_size(SIZE))


@cache
def page_of(name: str) -> Image:
    """Return the complete page of a figure, before its text is hidden."""
    return pixels(drawing(name).page)


def pixels(page: Page) -> Image:
    with theme.style():
        canvas: Any = page.canvas
        canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


@cache
def bare_page(name: str) -> Page:
    """Return the page of a figure without text, legends and pictures of VTK."""
    page_of(name)
    page = drawing(name).page
    legends = [*page.legends, *filter(None, (axes.get_legend() for axes in page.axes))]
    texts = [text for text in page.findobj(Text) if isinstance(text, Text) and text.get_text()]
    for artist in (*legends, *texts, *(i for axes in page.axes if axes.zorder < 0 for i in axes.images)):
        artist.set_visible(False)
    for axes in page.axes:
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(NullFormatter())
            axis.set_minor_formatter(NullFormatter())
    return page


def sheet(images: list[Image]) -> Image:
    """Return all pictures of a figure next to each other on white."""
    height, width = max(i.shape[0] for i in images), sum(i.shape[1] for i in images)
    board = np.full((height, width, 3), 255, dtype=np.uint8)
    x = 0
    for image in images:
        board[: image.shape[0], x : x + image.shape[1]] = image
        x += image.shape[1]
    return board


def difference(one: Image, other: Image) -> float:
    """Return the difference of two pictures, whole pixels; infinite for different sizes."""
    if one.shape != other.shape:
        return float("inf")
    levels = np.abs(one.astype(int) - other.astype(int)).max(axis=-1)
    return float(levels[levels > NOISE_LEVELS].sum() / 255.0)


def compare(found: Image, name: str, request: pytest.FixtureRequest, folder: Path) -> None:
    stored = SNAPSHOTS / f"{name}.png"
    if request.config.getoption("--reset-snapshots"):
        SNAPSHOTS.mkdir(exist_ok=True)
        Pillow.fromarray(found).save(stored, optimize=True)
    assert stored.exists(), f"no reference picture for {name}: look at it, then --reset-snapshots"
    error = difference(found, np.asarray(Pillow.open(stored).convert("RGB")))
    if error > LIMIT:
        Pillow.fromarray(found).save(folder / f"{name}.png")
    assert error <= LIMIT, f"{name} differs by {error:.1f} pixels: see {folder}"


@pytest.mark.parametrize("figure", SOLID, ids=lambda f: f.name)
def test_snapshot(figure: Figure, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    pictures = [picture.image for picture in drawing(figure.name).pictures.values()]
    compare(sheet(pictures), figure.name, request, tmp_path)


@pytest.mark.parametrize("name", [f.name for f in FIGURES if f.name not in WITHOUT_CURVES])
def test_snapshot_of_the_page(name: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    found = Pillow.fromarray(pixels(bare_page(name)))
    found = found.reduce(2) if name.startswith("map-") else found  # or they would be large files
    compare(np.asarray(found), f"{name}-page", request, tmp_path)


@pytest.mark.parametrize("name", CHARTS)
def test_a_moved_curve_fails(name: str) -> None:
    """Every long line of a chart that is moved by one pixel fails the comparison."""
    page, seen = bare_page(name), 0
    before = pixels(page)
    for line in (line for axes in page.axes for line in axes.lines):
        own = line.get_transform()
        way = own.transform_path(line.get_path()).get_extents()
        if not 40.0 < way.width < np.inf or not line.get_visible():
            continue
        line.set_transform(own + Affine2D().translate(0.0, 1.0))
        assert difference(pixels(page), before) > 1.5 * LIMIT, (name, line)
        line.set_transform(own)
        seen += 1
    assert seen > 1
    assert difference(pixels(page), before) == 0.0


def test_a_moved_contact_line_fails() -> None:
    """A path that is moved by 0.5 mm fails in every picture of the figure."""
    data: PathFigure = data_of("fig-09")
    other = drawn("fig-09", replace(data, paths=moved(data.paths, 0.5)))
    for key, picture in drawing("fig-09").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key
    data12: MisalignmentFigure = data_of("fig-12")
    plain, modified = (moved(paths, 0.5) for paths in data12.paths)
    other = drawn("fig-12", replace(data12, paths=(plain, modified)))
    for key, picture in drawing("fig-12").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key


def test_another_pattern_fails() -> None:
    """A pattern with a separation larger by half a micrometre fails."""
    data: BandFigure = data_of("pattern")
    columns = []
    for column in data.columns:
        assert column.layers
        first, second = (replace(layer, values=layer.values + 0.5) for layer in column.layers)
        columns.append(replace(column, layers=(first, second)))
    other = drawn("pattern", replace(data, columns=tuple(columns)))
    for key, picture in drawing("pattern").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key


def moved(paths: tuple[SolvedPath, ...], distance: float) -> tuple[SolvedPath, ...]:
    """Return paths with every point moved along the tooth trace towards the heel, mm."""

    def one(solved: SolvedPath) -> SolvedPath:
        design, path = solved.design, solved.path
        pinion = flank_point(design.pinion, path.flank, path.l1, path.u1 + distance)
        gear = flank_point(design.gear, path.flank, path.l2, path.u2 + distance)
        return replace(solved, points=(pinion, gear))

    return tuple(one(path) for path in paths)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda f: f.name)
def test_page_is_whole(figure: Figure) -> None:
    """Every page has the requested size and is neither blank nor full."""
    image = page_of(figure.name)
    assert image.shape[:2] == SIZE[::-1]
    assert 0.01 < (image.min(axis=-1) < 204).mean() < 0.9
