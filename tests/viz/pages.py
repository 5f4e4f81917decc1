"""Figures drawn for tests, and the text on their pages."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.validation.comparison import METHODS
from beveloid_viz.components.figure_steps import Drawing, Recipe
from beveloid_viz.figures import FIGURES
from beveloid_viz.figures.methods import (
    mesh_convergence as fig_mesh,
    speed_accuracy as fig_speed,
    stability as fig_stability,
)
from beveloid_viz.figures.paper import fig_11_contact_ratio as fig_ratio
from beveloid_viz.figures.results import parabola_map as fig_map, tolerance_cloud as fig_cloud
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import PageLayout, of_size
from beveloid_viz.rendering.scene import Size
from beveloid_viz.rendering.theme import Page

SMALL = (400, 300)
FEW = tuple(replace(method, values=method.values[:2]) for method in METHODS)
"""Methods with two settings each."""


def recipe_of(name: str) -> Recipe[Any]:
    return next(figure for figure in FIGURES if figure.name == name).recipe()


def page_of(draw: Callable[[Any, PageLayout], Drawing], data: Any, size: Size = SMALL) -> Page:
    with theme.style():
        return draw(data, of_size(size)).page


def drawn(name: str, design: Design, size: Size = SMALL) -> tuple[Page, list[dict[str, Any]]]:
    """Return the page of a figure, and its table as dictionaries."""
    recipe = recipe_of(name)
    data = recipe.compute(design)
    page = page_of(recipe.draw, data, size)
    page.draw_without_rendering()
    header, rows = recipe.rows(data)
    return page, [dict(zip(header, row, strict=True)) for row in rows]


@contextmanager
def short_measurements() -> Iterator[None]:
    """Draw measurements and maps with few values."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fig_speed, "METHODS", FEW)
        patch.setattr(fig_speed, "RUN_COUNT", 1)
        patch.setattr(fig_mesh, "TOLERANCES_MM", np.logspace(-1.0, -2.0, 5))
        patch.setattr(fig_map, "INTERVAL_COUNT", 6)
        patch.setattr(fig_cloud, "CYCLE_MOUNTINGS", 8)
        patch.setattr(fig_ratio, "CYCLE_POINTS", slice(None, None, 40))
        patch.setattr(fig_stability, "ABOVE_DEG", 10.0 ** np.arange(-8.0, -0.9, 2.0))
        patch.setattr(fig_stability, "COMPARED_CELLS", 2)
        yield


def table_in(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def distances(points: FloatArray, line: FloatArray) -> FloatArray:
    """Return the distance of each of the points (n, d) from a polyline (m, d)."""
    way, from_start = np.diff(line, axis=0), np.atleast_2d(points)[:, None] - line[:-1]
    share = np.clip((from_start * way).sum(axis=-1) / np.maximum((way**2).sum(axis=-1), 1e-30), 0.0, 1.0)
    return np.asarray(np.linalg.norm(from_start - share[..., None] * way, axis=-1).min(axis=1))


def words(page: Page) -> str:
    """Return the text on a page and its axes."""
    return " ".join(texts(page))


def texts(page: Page) -> list[str]:
    written = [*page.texts, *(text for axes in page.axes for text in axes.texts)]
    return [" ".join(text.get_text().split()) for text in written]
