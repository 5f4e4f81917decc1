"""The figure of error and time: labels and page do not depend on the times of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.axes import Axes

from beveloid_geom import builtin_design
from beveloid_geom.validation.comparison import METHODS, Measurement
from beveloid_viz.figures.methods import speed_accuracy as fig_speed
from beveloid_viz.figures.methods.speed_accuracy import SpeedAccuracy
from beveloid_viz.rendering.layout import of_width

from ..pages import page_of, recipe_of, words

NAN = float("nan")
SECONDS = (1e-3, 1e-2, 1e-4, 1e-5, 1e-3)
"""Time per position of each method at its first setting."""
DESIGN = builtin_design().with_parabola(0.001, -0.001)


def data_with(time: Callable[[], float], failed: str = "") -> SpeedAccuracy:
    """Every method, with times that are multiplied by `time()`; one method has failed."""
    found = []
    for row, method in enumerate(METHODS):
        for column, value in enumerate(method.values):
            seconds = SECONDS[row] * 10.0 ** (0.2 * column) * time()
            error, status = (NAN, "no solution") if method.name == failed else (10.0 ** (-6 * row), "solved")
            times = (0.9 * seconds, seconds, 1.2 * seconds)
            found.append(Measurement(method.name, method.setting, value, error, 1e-3 * error, times, status))
    return SpeedAccuracy(DESIGN, "right", tuple(found))


def overprinted(axes: Axes) -> list[str]:
    """Return labels that overlap another label or extend beyond the axes."""
    boxes = {text.get_text(): text.get_window_extent() for text in axes.texts}
    pairs = combinations(boxes, 2)
    found = [f"{one} on {other}" for one, other in pairs if boxes[one].overlaps(boxes[other])]
    room = axes.get_window_extent().padded(1.0)
    return found + [name for name, box in boxes.items() if box.x0 < room.x0 or box.x1 > room.x1]


@pytest.mark.parametrize("width_mm", [90.0, 140.0, 190.0])
def test_page_does_not_depend_on_the_times(width_mm: float) -> None:
    """Runs whose times vary by a factor of 1e9 give a page of the same height."""
    random, recipe = np.random.default_rng(2), recipe_of("speed-accuracy")
    runs = [data_with(lambda: float(10.0 ** random.uniform(-6.0, 3.0))) for _ in range(3)]
    assert len({fig_speed.title(data) for data in runs}) == 2
    pages = [recipe.drawn(data, of_width(width_mm)).page for data in runs]
    assert len({(page.subtitle, page.note) for page in pages}) == 1
    assert np.ptp([page.get_figheight() for page in pages]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("spread", [0.0, 0.3, 1.0])
def test_no_label_is_overprinted(spread: float) -> None:
    random = np.random.default_rng(5)
    data = data_with(lambda: float(10.0 ** random.uniform(-spread, spread)))
    page = page_of(fig_speed.draw, data, (800, 600))
    assert overprinted(page.axes[0]) == []
    assert len(page.axes[0].texts) >= 4


def test_the_finding_compares_exact_methods_only() -> None:
    data = data_with(lambda: 1.0)
    exact = [replace(one, error_mm=1e-12) if "equation" in one.method else one for one in data.measurements]
    coarse = [replace(one, error_mm=1e-3) for one in data.measurements]
    data, inexact = replace(data, measurements=tuple(exact)), replace(data, measurements=tuple(coarse))
    assert fig_speed.title(data).startswith("One equation is as exact")
    # Five equations: 1e-4 s at the loosest xtol. One equation: 1e-5 s, 1.6 times longer at each size.
    times = ["1: 10 times faster", "11: 6.3 times faster", "101: 4 times faster", "100,001: 1 times slower"]
    assert fig_speed.finding(data)[2:] == times
    assert fig_speed.finding(inexact) == []
    assert fig_speed.title(inexact).startswith("Error and time")


def test_a_failed_method_is_in_the_table_and_not_in_the_panel() -> None:
    data = data_with(lambda: 1.0, failed="mesh, polished")
    header, rows = fig_speed.rows(data)
    lost = [row for row in rows if row[list(header).index("status")] == "no solution"]
    assert len(lost) == len(METHODS[1].values)
    page_of(fig_speed.draw, data)
    nothing = SpeedAccuracy(DESIGN, "left", (), "the left flanks have no contact")
    assert "the left flanks have no contact" in words(page_of(fig_speed.draw, nothing))
    assert next(iter(fig_speed.rows(nothing)[1]))[:2] == ("left", "the left flanks have no contact")
