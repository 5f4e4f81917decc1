"""The figure `sliding`: its numbers are the library's."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Errors, builtin_design, path_of_contact, sliding_of
from beveloid_viz.figures.results.sliding import RECIPES
from beveloid_viz.stage import theme


@pytest.mark.parametrize(("offset", "lost"), [(0.0, 0), (1.6, 1), (50.0, 2)])
def test_figure_has_the_numbers_or_the_reason(offset: float, lost: int) -> None:
    recipe, design = RECIPES["sliding"], builtin_design().with_errors(Errors(offset=offset))
    data = recipe.compute(design)
    with theme.style():
        page = recipe.draw(data, (400, 300)).page
    words = [" ".join(text.get_text().split()) for axes in page.axes for text in axes.texts]
    assert sum(text.startswith("no contact: the path of contact does not meet") for text in words) == 2 * lost
    assert sum(text == "pitch point" for text in words) == 2 - lost
    header, body = recipe.rows(data)
    rows = [dict(zip(header, row, strict=True)) for row in body]
    drawn = [row for row in rows if not row["reason"]]
    assert len(rows) - len(drawn) == 2 * lost
    if offset == 0.0:
        found = sliding_of(path_of_contact(design, "right", 201))
        shown = [row["pinion_specific"] for row in drawn if row["flank"] == "right"][:201]
        np.testing.assert_array_equal(shown, found.specific[:, 0])
