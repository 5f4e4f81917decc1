"""Fig. 6: magnified deviations and their factor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_viz.figures.paper import fig_06_modification as fig
from beveloid_viz.rendering.opengl import require_opengl

from ...symmetry import mirrored, scaled
from ..pages import page_of, words


def polar(points: FloatArray) -> FloatArray:
    """Return radius and angle from the vertical (2, n) of points (2, n)."""
    return np.stack((np.hypot(*points), np.arctan2(-points[0], points[1])))


def test_the_section_is_magnified_by_the_factor_stated() -> None:
    """With a factor of 1, a point of the involute reaches the profile at equal radius; the drawn deviation is
    larger by the factor, perpendicular to the involute."""
    data = fig.compute(builtin_design())
    assert data.factor == 5.0
    for a, section in data.sections.items():
        np.testing.assert_array_equal(section.magnified(0.0), section.base)
        # Turned about the axis, an involute moves by one distance along all of its normals.
        (radius, angle), (own, place) = (polar(points) for points in (section.base, section.magnified(1.0)))
        turn = polar(np.stack((section.across, section.up)))[1] - angle
        inner = (own > radius[0]) & (own < radius[-1])
        assert inner.mean() > 0.9
        off = own * (place - turn - np.interp(own, radius, angle))
        assert np.abs(off[inner]).max() < 2e-4, a
        step, tangent = section.magnified(data.factor) - section.base, np.gradient(section.base, axis=1)
        along = (step * tangent).sum(axis=0) / np.hypot(*tangent)
        assert np.abs(along).max() < 0.02 * max(np.hypot(*step).max(), 1e-9), a
        # The normal leans out of the section by the base helix angle: 1 mm along it is a little more there.
        way = np.hypot(*section.per_mm)
        np.testing.assert_allclose(np.hypot(*step), 5.0 * np.abs(section.deviation) * way, atol=1e-12)
        assert 1.0 <= way.min() <= way.max() < 1.1


@pytest.mark.parametrize(("times", "factor"), [(1.0, 5.0), (0.1, 50.0), (0.0, 1.0)])
def test_the_factor_is_round_and_said(times: float, factor: float) -> None:
    require_opengl()
    data = fig.compute(builtin_design())
    sections = {a: replace(one, deviation=times * one.deviation) for a, one in data.sections.items()}
    page = page_of(fig.draw, replace(data, sections=sections))
    assert f"deviation \u00d7 {factor:g}" in " ".join(axes.get_title(loc="left") for axes in page.axes)
    assert f"thick lines with {factor:g} times their deviation" in words(page)


def test_the_figure_is_the_same_at_any_module() -> None:
    usual, small = (fig.compute(scaled(builtin_design(), times)) for times in (1.0, 0.05))
    assert (usual.coefficient, small.coefficient) == (0.01, 0.2)
    for sign, section in usual.sections.items():
        np.testing.assert_allclose(0.05 * section.deviation, small.sections[sign].deviation, atol=1e-9)


def test_a_left_flank_is_drawn_as_the_right_flank_of_the_mirrored_pair() -> None:
    left, right = (
        fig.compute(design, flank)
        for design, flank in ((builtin_design(), "left"), (mirrored(builtin_design()), "right"))
    )
    assert left.ends == ("heel", "toe")
    for sign, section in right.sections.items():
        for name in ("across", "up", "deviation", "base", "per_mm"):
            mine, other = getattr(left.sections[sign], name), getattr(section, name)
            np.testing.assert_allclose(mine, other, atol=1e-9)


def test_a_flank_that_ends_below_the_tip_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    require_opengl()
    monkeypatch.setattr(fig, "COEFFICIENT_PER_MM", 0.03)
    data = fig.compute(builtin_design())
    missing = sorted(set(fig.LOOKS) - set(data.members))
    assert missing
    for sign in missing:
        assert f"The {fig.LOOKS[sign].name} flank ends below the tip" in words(page_of(fig.draw, data))
