"""Figures of designs of which something cannot be computed: drawn, and the reason in words."""

from __future__ import annotations

import pytest

from beveloid_geom import builtin_design
from beveloid_viz.figures import FIGURES
from beveloid_viz.figures.results import transmission_error as fig_operation
from beveloid_viz.stage import theme
from beveloid_viz.stage.opengl import require_opengl

SIZE = (400, 300)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parabola", "name", "reason"),
    [
        (-0.01, "pattern", "(undercut)"),
        (-0.01, "transmission-error", "a member is undercut"),
        (-0.01, "posed-pair", "undercut from z ="),
        (-0.01, "meshed-tooth", "undercut from z ="),
        (0.01, "separation", "rounds overlap"),
        (0.01, "transmission-error", "rounds overlap"),
        (0.01, "pattern", "rounds overlap"),
        (0.01, "meshed-tooth", "rounds overlap"),
    ],
)
def test_the_reason_is_on_the_page(
    parabola: float, name: str, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    require_opengl()
    monkeypatch.setattr(fig_operation, "CASES", fig_operation.CASES[:1])
    recipe = next(figure for figure in FIGURES if figure.name == name).recipe()
    data = recipe.compute(builtin_design().with_parabola(pinion=parabola))
    with theme.style():
        page = recipe.draw(data, SIZE).page
    words = [text.get_text() for text in (*page.texts, *(t for axes in page.axes for t in axes.texts))]
    assert any(reason in " ".join(text.split()) for text in words), words
    header, rows = recipe.rows(data)
    assert all(len(row) == len(header) for row in rows)


def test_without_contact_no_figure_claims_one() -> None:
    require_opengl()
    design = builtin_design().with_parabola(pinion=0.01, gear=0.01)
    recipe = next(figure for figure in FIGURES if figure.name == "separation").recipe()
    with theme.style():
        page = recipe.draw(recipe.compute(design), SIZE).page
    assert any("three neighbouring tooth pairs; pinion" in text.get_text() for text in page.texts)
