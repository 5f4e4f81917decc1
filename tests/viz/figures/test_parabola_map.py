"""The map over sum and difference of the parabola coefficients."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from beveloid_geom import Errors, builtin_design, contact_ratio, mesh_cycle
from beveloid_viz.components.map_extremes import Extreme, least_shift
from beveloid_viz.components.map_panel import between_cells, widest_gap
from beveloid_viz.figures.results import parabola_map
from beveloid_viz.figures.results.parabola_map import ParabolaMap

from ..pages import page_of, words

TABLE = builtin_design()


@cache
def small_map() -> ParabolaMap:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parabola_map, "INTERVAL_COUNT", 4)
        return parabola_map.compute(TABLE)


def test_cells_are_those_of_single_designs() -> None:
    data = small_map()
    pinion, gear = data.coefficients
    for at in ((0, 1), (2, 3), (4, 0)):
        design = TABLE.with_parabola(float(pinion[at]), float(gear[at]))
        assert data.quantities["contact_ratio"][at] == pytest.approx(float(contact_ratio(design)), abs=1e-9)
        cycle = mesh_cycle(design, "right")
        assert data.quantities["edge_share"][at] == pytest.approx(float(cycle.edge_share), abs=1e-9)
    np.testing.assert_allclose(pinion + gear, np.broadcast_to(data.total, pinion.shape), atol=1e-18)
    np.testing.assert_allclose((pinion - gear)[:, 0], data.difference, atol=1e-18)


def test_extremes_are_better_than_fine_sweeps() -> None:
    """The largest contact ratio is at least that of a fine sweep along a1 = a2, 2.2255 as in Fig. 11(b). The
    smallest shift is below that of every cell."""
    data = small_map()
    equal = np.linspace(-0.0003, 0.0, 301)
    along = np.asarray(contact_ratio(TABLE.with_parabola(equal, equal)))
    assert along.max() == pytest.approx(2.2255, abs=1e-3)
    assert along.max() <= data.most_ratio.value < along.max() + 0.01
    usable = (data.quantities["contact_ratio"] >= data.ratio) & (data.total <= 0.0)
    usable &= np.maximum(*np.abs(data.coefficients)) <= 0.002
    assert data.least_shift.value < data.quantities["shift"][usable].min()
    assert data.least_shift.value == pytest.approx(1.149, abs=1e-3)


def test_the_finding_and_the_errors_are_on_the_page() -> None:
    page = page_of(parabola_map.draw, small_map(), (800, 600))
    text = words(page)
    assert "contact ratio up to 2.23 in the map, smallest shift at a ratio of 1.65 or more: 1.15 mm" in text
    assert "under offset \u00b10.05 mm, shaft angle \u00b10.01 deg" in text
    assert [text.get_text() for text in page.axes[1].texts].count("in CSV only") == 1  # above sum 0 in (b)
    (legend,) = page.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names[-1] == "negative relative curvature (sum above 0)"
    assert names[:3] == ["design", "largest ratio", "smallest shift"]


def test_an_extreme_outside_the_map_is_not_drawn() -> None:
    """An extreme outside the map has no mark and no entry in the legend, and the subtitle states that it is
    outside."""
    data = small_map()
    outside = replace(data, least_shift=replace(data.least_shift, pinion=-0.002, gear=-0.002))
    assert data.shows(data.least_shift)
    total, difference = float(data.total[0]), float(data.difference[0])
    assert data.shows(Extreme(0.5 * (total + difference), 0.5 * (total - difference), 1.0))
    page = page_of(parabola_map.draw, outside, (800, 600))
    assert "1.15 mm, outside the map" in words(page)
    (legend,) = page.legends
    assert "smallest shift" not in [text.get_text() for text in legend.get_texts()]
    assert not [line for axes in page.axes for line in axes.lines if line.get_marker() == "s"]


def test_values_between_cells() -> None:
    """Linear between cells, the short way for angles, and unknown where the nearest cell is unknown."""
    plane = between_cells(np.add.outer(np.arange(3.0), 10.0 * np.arange(2.0)))
    np.testing.assert_allclose(plane, np.add.outer(np.linspace(0, 2, 17), np.linspace(0, 10, 9)), atol=1e-12)
    angles = between_cells(np.array([[80.0, -80.0], [80.0, -80.0]]), 180.0)[0]
    np.testing.assert_allclose(angles % 180.0, np.linspace(80.0, 100.0, 9), atol=0.2)
    partly = between_cells(np.array([[1.0, np.nan], [1.0, np.nan]]))[0]
    np.testing.assert_array_equal(np.isnan(partly), [False] * 4 + [np.isnan(partly[4])] + [True] * 4)
    np.testing.assert_array_equal(partly[:4], 1.0)


def test_the_widest_gap_of_angles() -> None:
    assert widest_gap(np.array([-20.0, 10.0, 40.0]), 180.0) == pytest.approx((100.0, 120.0))
    assert widest_gap(np.array([60.0, 100.0]), 180.0) == pytest.approx((170.0, 140.0))


@pytest.mark.parametrize(("errors", "known"), [(Errors(0.01), True), (Errors(0.0, 1e-5), False)])
def test_lines_of_contact_have_the_largest_ratio(errors: Errors, known: bool) -> None:
    """On parallel axes other coefficients have smaller ratios, so that only the given ones are left. Under a
    shaft-angle error, they have no path."""
    design = builtin_design("anti-backlash")
    ratio = float(contact_ratio(design))
    assert float(contact_ratio(design.with_parabola(-1e-3, -1e-3))) < ratio
    found = least_shift(design, "right", errors, ratio, ratio, 4e-3)
    if known:
        assert (found.pinion, found.gear) == (0.0, 0.0)
        assert 0.0 < found.value < 0.01
    else:
        assert np.isnan([found.pinion, found.gear, found.value]).all()
