"""What a chart draws stands in its CSV: every curve again from the columns of the table, in their units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from scipy.spatial import cKDTree

from beveloid_geom.arrays import FloatArray
from beveloid_viz.stage.layout import of_size

from .pages import recipe_of, short_measurements
from .test_snapshots import data_of

CHARTS = {
    "fig-06": 5,
    "fig-11": 20,
    "transmission-error": 30,
    "sliding": 14,
    "ease-off": 4,
    "tolerance-cloud": 10,
    "mesh-convergence": 4,
}
"""Charts by name, and how many curves they have at least."""
BARS = {"sensitivity": (150, (0,)), "speed-accuracy": (35, (0, 1))}
"""Charts of bars and marks: how many lines they have at least, and which ways of them are numbers."""
MAPS = {"map-parabola": 5, "map-mounting": 4}
"""Maps, and how many panels of cells they have at least."""
POINTS = 5
"""Of the shortest curve that is looked at."""
UNITS = (1.0, 1e3, 1e6, 100.0, float(np.degrees(3600.0)), float(np.degrees(1.0)))
"""What a column is drawn in: itself, um of mm, urad of rad, percent, arcsec and degrees of rad."""
ONE_WAY = {"transmission-error": 1, "mesh-convergence": 1, "tolerance-cloud": 0}
"""Which way of charts that repeat a curve whole pitches on, or draw it over settings or up to a rank."""
STRIPS = ("M4", "M5", "M6")
"""Statements whose marks stand one over another, at heights that are no numbers."""


@pytest.fixture(scope="module", autouse=True)
def _short_measurements() -> Iterator[None]:
    with short_measurements():
        yield


def charts(name: str) -> Iterator[Axes]:
    """The axes of a figure, but those of pictures, and of wires seen from aside."""
    with np.errstate(all="ignore"):
        page = recipe_of(name).drawn(data_of(name), of_size((800, 600))).page
    return (axes for axes in page.axes if axes.axison)


def curves(name: str, points: int = POINTS) -> Iterator[Line2D]:
    """The curves of a chart of so many points or more in the coordinates of its axes."""
    for axes in charts(name):
        for line in axes.lines:
            if len(np.atleast_1d(line.get_xdata())) >= points and line.get_transform() == axes.transData:
                yield line


def table(name: str) -> tuple[list[str], list[Sequence[object]]]:
    """The header and the rows of a table."""
    header, rows = recipe_of(name).rows(data_of(name))
    return list(header), list(rows)


def columns(header: Sequence[str], rows: Iterable[Sequence[object]]) -> list[FloatArray]:
    """The numbers in each column of a table, without their signs, in order."""
    found: list[list[float]] = [[] for _ in header]
    for row in rows:
        for values, value in zip(found, row, strict=True):
            if isinstance(value, (int, float, np.number)):
                values.append(abs(float(value)))
    return [np.unique(values)[: np.isfinite(np.unique(values)).sum()] for values in found if values]


def stands_in(values: FloatArray, column: FloatArray) -> bool:
    """Whether all values are those of a column, to rounding."""
    at = np.clip(np.searchsorted(column, values), 1, max(len(column) - 1, 1))
    near = np.minimum(abs(column[at - 1] - values), abs(column[np.minimum(at, len(column) - 1)] - values))
    return bool((near <= 1e-9 * values.max(initial=1e-30)).all())


def assert_in_table(found: Sequence[FloatArray], drawn: Iterable[Any]) -> int:
    """Count arrays that are drawn, and assert that each but its zeros stands in a column of the table."""
    every = [unit * column for column in found for unit in UNITS if column.size]
    seen = 0
    for one in drawn:
        values = np.abs(np.ma.filled(np.ma.asarray(one, dtype=float), np.nan).ravel())
        values = values[np.isfinite(values) & (values > 0.0)]
        assert any(stands_in(values, column) for column in every), values[:4]
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


@pytest.mark.parametrize("name", MAPS)
def test_every_cell_is_in_the_table(name: str) -> None:
    meshes = (one for axes in charts(name) for one in axes.collections if isinstance(one, QuadMesh))
    cells = [mesh.get_array() for mesh in meshes if mesh.colorbar is not None]  # not those of the scales
    assert assert_in_table(columns(*table(name)), cells) >= MAPS[name]


def test_every_picture_of_the_board_is_in_the_rows_of_its_statement() -> None:
    header, rows = table("statements")
    ids = dict.fromkeys(str(row[0]) for row in rows)
    for id_, axes in zip(ids, charts("statements"), strict=True):
        found = columns(header, [row for row in rows if row[0] == id_])
        lines = [line.get_data() for line in axes.lines if line.get_transform() == axes.transData]
        ways = (0,) if id_ in STRIPS else (0, 1)
        bars = [patch.get_height() for patch in axes.patches if isinstance(patch, Rectangle)]
        seen = assert_in_table(found, [line[way] for line in lines for way in ways] + bars)
        assert seen >= (8 if id_ in ("F6", "D1") else 4), id_


def test_the_rack_is_redrawn_from_its_table() -> None:
    """The right profile, its mirror image and both of them a pitch on make the curves; what is written beside
    them stands in the table, too."""
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
"""A line of the table of a flank: the error, and the shift under it."""
SAID = {
    "fig-01": (
        r"helix (\S+?)°, cone (\S+?)°",
        tuple(f"{m}_{angle}_angle" for m in ("pinion", "gear") for angle in ("helix", "cone")),
    ),
    "fig-12": (SHIFT, ("pinion_shift_mm", "gear_shift_mm")),
    "fig-13": (SHIFT, ("pinion_shift_mm", "gear_shift_mm")),
    "transmission-error": (
        r"peak to peak (\S+) µrad = \S+ µm\nedges carry (\S+) %; ratio (\S+), running (\S+)",
        ("peak_to_peak_rad", "edge_share", "contact_ratio", "operating_contact_ratio"),
    ),
    "pattern": (r"(\S+) % of the flank, (\S+) mm²", ("area_share", "area_mm2")),
    "separation": (r"pinion roll (\S+)°, gear roll (\S+)°", ("pinion_roll_rad", "gear_roll_rad")),
}
"""What is written beside a picture, and the columns or the quantities that have its numbers."""


@pytest.mark.parametrize("name", SAID)
def test_what_is_written_is_in_the_table(name: str) -> None:
    """Every number, to its digits, in a column that has one of the names."""
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
