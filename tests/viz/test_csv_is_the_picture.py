"""The CSV of a chart contains every value that the chart shows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.lines import Line2D
from matplotlib.text import Text
from scipy.spatial import cKDTree

from beveloid_geom.arrays import FloatArray
from beveloid_viz.rendering.layout import of_size

from .pages import recipe_of, short_measurements
from .test_snapshots import data_of

CHARTS = {
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


@pytest.fixture(scope="module", autouse=True)
def _short_measurements() -> Iterator[None]:
    with short_measurements():
        yield


def charts(name: str) -> Iterator[Axes]:
    """Yield the axes of a figure, without pictures and wire surfaces."""
    with np.errstate(all="ignore"):
        page = recipe_of(name).drawn(data_of(name), of_size((800, 600))).page
    return (axes for axes in page.axes if axes.axison)


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


@pytest.mark.parametrize("name", CHARTS)
def test_every_curve_is_in_the_table(name: str) -> None:
    ways = [ONE_WAY[name]] if name in ONE_WAY else [0, 1]
    drawn = (line.get_data()[way] for line in curves(name) for way in ways)
    assert assert_in_table(columns(*table(name)), drawn) >= len(ways) * CHARTS[name]


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
    page = recipe_of("fig-02").drawn(data_of("fig-02"), of_size((800, 600))).page
    drawn = [np.array(line.get_data()) for line in page.axes[0].lines]
    for name, curve in zip(("parabolic", "straight"), (c.T for c in drawn if c.size > 200), strict=True):
        x, y = np.array([row[-2:] for row in rows if row[0] == name], dtype=float).T
        halves = [
            np.stack((side * y + pitch, x), axis=-1)
            for side in (-1, 1)
            for pitch in 2.0 * y[0] * np.arange(-1, 2)
        ]
        places = np.concatenate(halves)
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
    page = recipe_of(name).drawn(data_of(name), of_size((800, 600))).page
    words = "\n".join([page.subtitle, *(text.get_text() for text in page.findobj(Text))])
    found = [
        number
        for said in re.findall(pattern, words)
        for number in ([said] if isinstance(said, str) else said)
    ]
    assert len(found) >= len(names)
    for number in found:
        size = abs(float(number.replace("\u2212", "-")))
        digits = number.partition(".")[2]
        assert np.nanmin(np.abs(every - size)) <= 0.5001 * 10.0 ** -len(digits), number
