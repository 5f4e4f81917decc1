"""The 3D pictures of every figure against reference pictures, at a small size.

Only what VTK draws is compared; the page around it depends on fonts. Rendering in software is
the same to the pixel but for old processors, which change some by up to 3 of 255 levels; so
differences up to 8 levels do not count, and the rest is summed in whole pixels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread, imsave
from numpy.typing import NDArray

from beveloid_geom.design.file import builtin_design
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.studies.comparison import Settings
from viz.figures import FIGURES, Figure
from viz.figures.methods import speed_accuracy as fig_speed
from viz.figures.paper.fig_07_to_10_paths import PathFigure
from viz.figures.paper.fig_12_to_15_misalignment import MisalignmentFigure
from viz.figures.results import maps as fig_maps
from viz.figures.results.pattern import BandFigure
from viz.parts.recipe import Drawing, Recipe
from viz.parts.solved import SolvedPath
from viz.stage import theme
from viz.stage.opengl import require_opengl

SNAPSHOTS = Path(__file__).parent / "snapshots"
SIZE = (800, 600)
NOISE_LEVELS = 8
LIMIT = 6.0
"""Whole pixels by which one picture may differ. A path moved by 0.5 mm differs by far more."""
FLAT = {"fig-02", "fig-11", "transmission-error", "sensitivity", "mesh-convergence"}
FLAT |= {"sliding", "speed-accuracy"}
FLAT |= {"map-parabola", "map-mounting", "map-shift"}
SOLID = [figure for figure in FIGURES if figure.name not in FLAT]
Image = NDArray[np.uint8]


@pytest.fixture(scope="module", autouse=True)
def _opengl() -> None:
    require_opengl()


@pytest.fixture(scope="module", autouse=True)
def _short_measurements() -> Iterator[None]:
    """Pages of measurements are drawn from a few of them."""
    few = Settings(tolerances=(0.1, 0.01), xtols=(1e-2, 1e-14), batches=(1, 100), batch=10, run=11, repeat=0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fig_speed, "SETTINGS", few)
        patch.setattr(fig_maps, "STEPS", 7)
        patch.setattr(fig_maps, "FIRST_STEPS", 3)
        yield


def recipe_of(name: str) -> Recipe[Any]:
    return next(figure for figure in FIGURES if figure.name == name).recipe()


@cache
def drawing(name: str) -> Drawing:
    return drawn(name, recipe_of(name).compute(builtin_design()))


def drawn(name: str, data: object) -> Drawing:
    with theme.style():
        return recipe_of(name).draw(data, SIZE)


def sheet(images: list[Image]) -> Image:
    """All pictures of a figure side by side on white."""
    height, width = max(i.shape[0] for i in images), sum(i.shape[1] for i in images)
    board = np.full((height, width, 3), 255, dtype=np.uint8)
    x = 0
    for image in images:
        board[: image.shape[0], x : x + image.shape[1]] = image
        x += image.shape[1]
    return board


def difference(one: Image, other: Image) -> float:
    """Difference of two pictures in whole pixels; infinite if they differ in size."""
    if one.shape != other.shape:
        return float("inf")
    levels = np.abs(one.astype(int) - other.astype(int)).max(axis=-1)
    return float(levels[levels > NOISE_LEVELS].sum() / 255.0)


@pytest.mark.parametrize("figure", SOLID, ids=lambda f: f.name)
def test_snapshot(figure: Figure, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    name = figure.name
    found = sheet([picture.image for picture in drawing(name).pictures.values()])
    stored = SNAPSHOTS / f"{name}.png"
    if request.config.getoption("--reset-snapshots"):
        SNAPSHOTS.mkdir(exist_ok=True)
        imsave(stored, found)
    assert stored.exists(), f"no reference picture for {name}: look at it, then --reset-snapshots"
    reference = (imread(stored)[..., :3] * 255.0 + 0.5).astype(np.uint8)
    error = difference(found, reference)
    if error > LIMIT:
        imsave(tmp_path / f"{name}.png", found)
    assert error <= LIMIT, f"{name} differs by {error:.1f} pixels: see {tmp_path}"


def test_a_moved_contact_line_fails() -> None:
    """The comparison sees a path that is moved by 0.5 mm, in every picture of the figure."""
    data: PathFigure = recipe_of("fig-09").compute(builtin_design())
    other = drawn("fig-09", replace(data, paths=moved(data.paths, 0.5)))
    for key, picture in drawing("fig-09").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key
    data12: MisalignmentFigure = recipe_of("fig-12").compute(builtin_design())
    plain, modified = (moved(paths, 0.5) for paths in data12.paths)
    other = drawn("fig-12", replace(data12, paths=(plain, modified)))
    for key, picture in drawing("fig-12").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key


def test_another_pattern_fails() -> None:
    """The comparison sees a pattern whose least separation is half a micrometre larger."""
    data: BandFigure = recipe_of("pattern").compute(builtin_design())
    columns = []
    for column in data.columns:
        assert column.layers
        first, second = (replace(layer, values=layer.values + 0.5) for layer in column.layers)
        columns.append(replace(column, layers=(first, second)))
    other = drawn("pattern", replace(data, columns=tuple(columns)))
    for key, picture in drawing("pattern").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key


def moved(paths: tuple[SolvedPath, ...], distance: float) -> tuple[SolvedPath, ...]:
    """Paths with every point moved along the tooth trace towards the heel, mm."""

    def one(solved: SolvedPath) -> SolvedPath:
        design, path = solved.design, solved.path
        pinion = flank_point(design.pinion, path.flank, path.l1, path.u1 + distance)
        gear = flank_point(design.gear, path.flank, path.l2, path.u2 + distance)
        return replace(solved, points=(pinion, gear))

    return tuple(one(path) for path in paths)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda f: f.name)
def test_page_is_whole(figure: Figure, tmp_path: Path) -> None:
    """Every page is drawn at the size asked for and is neither blank nor full."""
    with theme.style():
        theme.save_page(drawing(figure.name).page, tmp_path / "page.png")
    image = imread(tmp_path / "page.png")
    assert image.shape[:2] == SIZE[::-1]
    assert 0.01 < (image[..., :3].min(axis=-1) < 0.8).mean() < 0.9
