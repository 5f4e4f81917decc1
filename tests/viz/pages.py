"""Figures drawn for tests, and the words on their pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design
from beveloid_geom.studies.comparison import Settings
from beveloid_viz.figures import FIGURES
from beveloid_viz.figures.methods import mesh_convergence as fig_mesh, speed_accuracy as fig_speed
from beveloid_viz.figures.results import maps as fig_maps
from beveloid_viz.parts.recipe import Drawing, Recipe
from beveloid_viz.stage import theme
from beveloid_viz.stage.layout import Layout, of_size
from beveloid_viz.stage.scene import Size
from beveloid_viz.stage.theme import Page

SMALL = (400, 300)
FEW = Settings(
    tolerances=(0.1, 0.01),
    xtols=(1e-2, 1e-14),
    batches=(1, 100),
    batch=10,
    run=11,
    repeat=0,
    grids=(8, 16),
)
"""Of the comparison of methods."""


def recipe_of(name: str) -> Recipe[Any]:
    return next(figure for figure in FIGURES if figure.name == name).recipe()


def page_of(draw: Callable[[Any, Layout], Drawing], data: Any, size: Size = SMALL) -> Page:
    with theme.style():
        return draw(data, of_size(size)).page


def drawn(name: str, design: Design, size: Size = SMALL) -> tuple[Page, list[dict[str, Any]]]:
    """A figure's page, and its table by the header."""
    recipe = recipe_of(name)
    data = recipe.compute(design)
    page = page_of(recipe.draw, data, size)
    page.draw_without_rendering()
    header, rows = recipe.rows(data)
    return page, [dict(zip(header, row, strict=True)) for row in rows]


@contextmanager
def short_measurements() -> Iterator[None]:
    """Draw pages of measurements, and maps, from a few of them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fig_speed, "SETTINGS", FEW)
        patch.setattr(fig_mesh, "TOLERANCES", np.logspace(-1.0, -2.0, 5))
        patch.setattr(fig_maps, "STEPS", 7)
        patch.setattr(fig_maps, "STEPS_IN_OPERATION", 7)
        yield


def words(page: Page) -> str:
    """All that is written on a page and its axes."""
    return " ".join(texts(page))


def texts(page: Page) -> list[str]:
    written = [*page.texts, *(text for axes in page.axes for text in axes.texts)]
    return [" ".join(text.get_text().split()) for text in written]
