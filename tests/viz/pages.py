"""Figures drawn for tests, and the words on their pages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from beveloid_geom import Design
from beveloid_viz.figures import FIGURES
from beveloid_viz.parts.recipe import Drawing, Recipe
from beveloid_viz.stage import theme
from beveloid_viz.stage.layout import Layout, of_size
from beveloid_viz.stage.scene import Size
from beveloid_viz.stage.theme import Page

SMALL = (400, 300)


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


def words(page: Page) -> str:
    """All that is written on a page and its axes."""
    return " ".join(texts(page))


def texts(page: Page) -> list[str]:
    written = [*page.texts, *(text for axes in page.axes for text in axes.texts)]
    return [" ".join(text.get_text().split()) for text in written]
