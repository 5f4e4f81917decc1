"""Fig. 6: what is magnified, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import builtin_design
from beveloid_viz.figures.paper import fig_06_modification as fig
from beveloid_viz.stage.opengl import require_opengl

from .pages import drawn, words


def test_the_section_is_magnified_by_the_factor_stated() -> None:
    """With its deviation once, the involute becomes the profile, but for what is of second order; the drawn
    profile stands off the involute by factor times as much, square to it."""
    data = fig.compute(builtin_design())
    assert data.factor == 5.0
    for a, section in data.sections.items():
        true, once = np.stack((section.across, section.up)), section.magnified(1.0)
        np.testing.assert_array_equal(section.magnified(0.0), section.base)
        off = np.linalg.norm(once[:, 5:-5, None] - true[:, None], axis=0).min(axis=1)
        assert off.max() < 0.1 * max(np.abs(section.deviation).max(), 1e-9), a
        step, tangent = section.magnified(data.factor) - section.base, np.gradient(section.base, axis=1)
        along = (step * tangent).sum(axis=0) / np.hypot(*tangent)
        assert np.abs(along).max() < 0.02 * max(np.hypot(*step).max(), 1e-9), a
        # The normal leans out of the section by the base helix angle: 1 mm along it is a little more there.
        way = np.hypot(*section.way)
        np.testing.assert_allclose(np.hypot(*step), 5.0 * np.abs(section.deviation) * way, atol=1e-12)
        assert 1.0 <= way.min() <= way.max() < 1.1


@pytest.mark.parametrize(("size", "factor"), [(1e-3, 50.0), (0.01, 5.0)])
def test_the_factor_is_round_and_said(monkeypatch: pytest.MonkeyPatch, size: float, factor: float) -> None:
    require_opengl()
    looks = {-size: fig.LOOKS[-0.01], 0.0: fig.LOOKS[0.0], size: fig.LOOKS[0.01]}
    monkeypatch.setattr(fig, "LOOKS", looks)
    page, rows = drawn("fig-06", builtin_design())
    assert {row["factor"] for row in rows} == {factor}
    assert f"deviation \u00d7 {factor:g}" in " ".join(axes.get_title(loc="left") for axes in page.axes)
    assert f"have {factor:g} times their deviation" in words(page)
