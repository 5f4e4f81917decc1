"""Every figure is compared with reference pictures at a small size (renderings of VTK, and the page) and with
its CSV.

Software rendering differs by up to 3 of 255 levels on old processors. Differences up to 8 levels are ignored,
and the others are summed in whole pixels. Pages are compared without text, which depends on fonts, and
without pictures. Measured times and rounding errors are replaced by fixed numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray
from PIL import Image as Pillow
from scipy.spatial import cKDTree

from beveloid_geom import builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.shapes.proximity.mesh_convergence import Convergence
from beveloid_geom.validation.comparison import Measurement
from beveloid_geom.validation.near_singular import MethodErrors
from beveloid_viz.components.figure_steps import Drawing
from beveloid_viz.components.paths_table import SolvedPath
from beveloid_viz.figures import FIGURES, Figure
from beveloid_viz.figures.paper.fig_07_to_10_paths import PathFigure
from beveloid_viz.figures.results.pattern import BandFigure
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size
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
            for key, poses in data.convergence.items()
        }
        return replace(data, convergence=found)
    return data


def measured(number: int, one: Measurement) -> Measurement:
    """Replace times and errors by values that do not depend on the machine."""
    time = 1e-6 * 1.7**number
    return replace(one, seconds=(0.8 * time, time, 1.5 * time), error_mm=10.0 ** -(number % 13))


def stepped(found: MethodErrors) -> MethodErrors:
    """Replace the errors, which are rounding errors, by fixed steps. All methods except the first and the
    last have no value at the first shaft angle."""
    error = 10.0 ** -(np.arange(found.error.shape[1]) + 0.5 * np.arange(found.error.shape[0])[:, None])
    error[1:-1, 0] = np.nan
    return replace(found, error=error, stated=np.where(np.isfinite(found.stated), 30.0 * error, np.nan))


def even(found: Convergence, size: float) -> Convergence:
    """Replace the errors of the polished mesh, which are rounding errors, by a smooth function of the
    tolerance."""
    point, apart = (size * error * found.tolerance**0.1 for error in (1e-10, 1e-13))
    return replace(found, point_error=point, separation_error=apart)


@cache
def drawing(name: str) -> Drawing:
    return drawn(name, data_of(name))


def drawn(name: str, data: object) -> Drawing:
    return recipe_of(name).drawn(data, of_size(SIZE))


def pixels(page: Page) -> Image:
    with theme.style():
        canvas: Any = page.canvas
        canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


@cache
def bare_page(name: str) -> Page:
    """Return the page of a figure without text, legends and pictures of VTK."""
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


@pytest.mark.parametrize("name", [figure.name for figure in FIGURES])
def test_notes_are_short(name: str) -> None:
    assert len(drawing(name).page.note.split()) <= 60


@pytest.mark.parametrize("name", CHARTS)
def test_a_moved_curve_fails(name: str) -> None:
    """The comparison fails if any long line of a chart is moved by one pixel."""
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
    """The comparison fails in every picture of the figure if a path is moved by 0.5 mm."""
    data: PathFigure = data_of("fig-09")
    other = drawn("fig-09", replace(data, paths=moved(data.paths, 0.5)))
    for key, picture in drawing("fig-09").pictures.items():
        assert difference(picture.image, other.pictures[key].image) > 2.0 * LIMIT, key


def test_another_pattern_fails() -> None:
    """The comparison fails if the separation of a pattern is larger by half a micrometre."""
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

    found = []
    for solved in paths:
        design, path = solved.design, solved.path
        pinion = flank_point(design.pinion, path.flank, path.l1, path.u1 + distance)
        gear = flank_point(design.gear, path.flank, path.l2, path.u2 + distance)
        found.append(replace(solved, points=(pinion, gear)))
    return tuple(found)


# The CSV of a chart contains every value that the chart shows.

CURVES = {
    "fig-06": 5,
    "fig-11": 20,
    "transmission-error": 30,
    "modifications": 12,
    "sliding": 14,
    "ease-off": 4,
    "tolerance-cloud": 3,
    "mesh-convergence": 4,
}
"""Charts, and their smallest numbers of curves."""
BARS = {"sensitivity": (150, (0,)), "speed-accuracy": (5, (0, 1))}
"""Charts of bars and marks: smallest number of lines, and the axes that show values."""
POINTS = 5
"""Smallest number of points of a curve that is compared."""
UNITS = (1.0, 1e3, 1e6, 100.0, float(np.degrees(3600.0)), float(np.degrees(1.0)))
"""Factors from a column to the chart: 1, um, urad, percent, arcsec and degrees."""
ONE_WAY = {"transmission-error": 1, "modifications": 1, "mesh-convergence": 1, "tolerance-cloud": 0}
"""Axis that is compared for charts with repeated curves or with settings and ranks on the other axis."""


def charts(name: str) -> Iterator[Axes]:
    """Return the axes of a figure, without pictures and wire surfaces."""
    return (axes for axes in drawing(name).page.axes if axes.axison)


def curves(name: str, points: int = POINTS) -> Iterator[Line2D]:
    """Yield the curves of a chart with at least `points` points."""
    for axes in charts(name):
        for line in axes.lines:
            if len(np.atleast_1d(line.get_xdata())) >= points and line.get_transform() == axes.transData:
                yield line


def table(name: str) -> tuple[list[str], list[Sequence[object]]]:
    """Return header and rows of a table."""
    header, rows = recipe_of(name).rows(data_of(name))
    return list(header), list(rows)


def columns(header: Sequence[str], rows: Iterable[Sequence[object]]) -> list[FloatArray]:
    """Return the sorted magnitudes in each column of a table."""
    found: list[list[float]] = [[] for _ in header]
    for row in rows:
        for values, value in zip(found, row, strict=True):
            if isinstance(value, (int, float, np.number)):
                values.append(abs(float(value)))
    return [np.unique(values)[: np.isfinite(np.unique(values)).sum()] for values in found if values]


def is_in_a_column(values: FloatArray, column: FloatArray) -> bool:
    """Return whether all values are in a column, within rounding."""
    at = np.clip(np.searchsorted(column, values), 1, max(len(column) - 1, 1))
    near = np.minimum(abs(column[at - 1] - values), abs(column[np.minimum(at, len(column) - 1)] - values))
    return bool((near <= 1e-9 * values.max(initial=1e-30)).all())


def assert_in_table(found: Sequence[FloatArray], drawn: Iterable[Any]) -> int:
    """Return the number of arrays drawn, and assert that the values of each are in one column."""
    every = [unit * column for column in found for unit in UNITS if column.size]
    seen = 0
    for one in drawn:
        values = np.abs(np.ma.filled(np.ma.asarray(one, dtype=float), np.nan).ravel())
        values = values[np.isfinite(values) & (values > 0.0)]
        assert any(is_in_a_column(values, column) for column in every), values[:4]
        seen += 1
    return seen


@pytest.mark.parametrize("name", CURVES)
def test_every_curve_is_in_the_table(name: str) -> None:
    ways = [ONE_WAY[name]] if name in ONE_WAY else [0, 1]
    drawn = (line.get_data()[way] for line in curves(name) for way in ways)
    assert assert_in_table(columns(*table(name)), drawn) >= len(ways) * CURVES[name]


@pytest.mark.parametrize("name", BARS)
def test_every_bar_is_in_the_table(name: str) -> None:
    least, ways = BARS[name]
    drawn = (line.get_data()[way] for line in curves(name, 1) for way in ways)
    assert assert_in_table(columns(*table(name)), drawn) >= len(ways) * least


def test_every_cell_is_in_the_table() -> None:
    """Every eighth value of the picture in each direction is that of a cell; the others are interpolated."""
    name = "map-parabola"
    cells = []
    for axes in charts(name):
        drawn = (one.get_array() for one in axes.collections if isinstance(one, QuadMesh) and one.colorbar)
        for values in drawn:  # not those of the colour scales
            assert values is not None
            # Angles of 90 to 180 deg are negative angles in the table.
            angle = "angle" in axes.get_title("left")
            cells.append(np.where(angle & (values > 90.0), values - 180.0, values)[::8, ::8])
    assert assert_in_table(columns(*table(name)), cells) >= 5


def test_the_rack_is_redrawn_from_its_table() -> None:
    """The curves consist of the right profile, its mirror image and both shifted by a pitch; the printed
    numbers are in the table."""
    header, rows = table("fig-02")
    page = drawing("fig-02").page
    drawn = [np.array(line.get_data()) for line in page.axes[0].lines]
    for name, curve in zip(("parabolic", "straight"), (c.T for c in drawn if c.size > 200), strict=True):
        x, y = np.array([row[-2:] for row in rows if row[0] == name], dtype=float).T
        places = np.concatenate(
            [np.stack((side * y + 2.0 * k * y[0], x), axis=-1) for side in (-1, 1) for k in (-1, 0, 1)]
        )
        for one, other in ((curve, places), (places, curve)):
            assert np.max(cKDTree(one).query(other)[0]) < 1e-9, name
    words = " ".join([page.subtitle, *(text.get_text() for text in page.axes[0].texts)])
    numbers = [float(number) for number in re.findall(r"(?<![\w{/^\u2212])\d[\d.]*", words)]
    every = np.concatenate([unit * column for column in columns(header, rows) for unit in UNITS])
    assert len(numbers) == 7
    for number in numbers:
        assert abs(every - number).min() < 1e-3 * number + 1e-12, number


SHIFT = r"(?m)^[+\u2212]0\.\d+\n([+\u2212]?\d+\.\d)$"
"""Line in the table of a flank: the error, and the shift below it."""
SAID = {
    "fig-01": (
        r"helix (\S+?)°, cone (\S+?)°",
        tuple(f"{m}_{angle}_angle" for m in ("pinion", "gear") for angle in ("helix", "cone")),
    ),
    "fig-12": (SHIFT, ("pinion_shift_mm", "gear_shift_mm")),
    "fig-13": (SHIFT, ("pinion_shift_mm", "gear_shift_mm")),
    "transmission-error": (
        r"peak to peak (\S+) arcsec = \S+ µm\nedge contact (\S+) %; ratio (\S+), in operation (\S+)",
        ("peak_to_peak_rad", "edge_share", "contact_ratio", "operating_contact_ratio"),
    ),
    "pattern": (r"(\S+)\s% of the flank, (\S+)\smm²", ("area_share", "area_mm2")),
    "separation": (r"pinion roll (\S+)°, gear roll (\S+)°", ("pinion_roll_rad", "gear_roll_rad")),
}
"""Text next to a picture, and the columns or quantities with its numbers."""


@pytest.mark.parametrize("name", SAID)
def test_what_is_written_is_in_the_table(name: str) -> None:
    """Every printed number is in one of the columns, to its digits."""
    pattern, names = SAID[name]
    header, rows = table(name)
    if header[0] == "quantity":
        known = [row[2] for row in rows if row[0] in names]
    else:
        known = [row[header.index(column)] for column in names for row in rows]
    every = np.concatenate([unit * np.abs(np.array(known, dtype=float)) for unit in UNITS])
    page = drawing(name).page
    words = "\n".join([page.subtitle, *(text.get_text() for text in page.findobj(Text))])
    found = [number for said in re.finditer(pattern, words) for number in said.groups()]
    assert len(found) >= len(names)
    for number in found:
        size = abs(float(number.replace("\u2212", "-")))
        digits = number.partition(".")[2]
        assert np.nanmin(np.abs(every - size)) <= 0.5001 * 10.0 ** -len(digits), number
