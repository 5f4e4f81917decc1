"""Figures that draw the layout, of pairs whose axes intersect far from the members."""

from __future__ import annotations

import pytest

from beveloid_geom import builtin_design
from beveloid_viz.parts import posed
from beveloid_viz.stage.opengl import require_opengl
from tests.validation.test_intersecting_axes import DESIGNS, LARGE

from .pages import drawn, words

WORDS = {
    "fig-01": "axes at 7°, 0 mm apart where nearest, 2162 mm from here",
    "fig-04": "Offset $E$ = 0 mm, shaft angle $\\delta$ = 7°",
    "fig-05": "drawn: 109 mm, 218 times 0.5 mm",
}


@pytest.mark.parametrize("name", DESIGNS)
def test_pictures_are_scaled_by_the_distance_of_the_members(name: str) -> None:
    pair = posed.pose(DESIGNS[name])
    assert pair.touching
    assert pair.remote
    radii = [float(m.tool.normal_module) * float(m.teeth) / 2.0 for m in DESIGNS[name].members]
    assert 0.8 * sum(radii) < pair.apart < 1.1 * sum(radii)


def test_a_crossed_pair_is_scaled_by_its_offset() -> None:
    pair = posed.pose(builtin_design())
    assert pair.apart == pytest.approx(229.0, abs=1e-9)
    assert not pair.remote


@pytest.mark.slow
@pytest.mark.parametrize("name", WORDS)
def test_the_layout_is_drawn(name: str) -> None:
    require_opengl()
    page, rows = drawn(name, LARGE)
    assert rows
    assert WORDS[name] in words(page), words(page)
