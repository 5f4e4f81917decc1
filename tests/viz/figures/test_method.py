"""The figure of the method has the contacts of the library, or the reason for their absence."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Design, Errors, builtin_design, path_of_contact
from beveloid_viz.figures.results import method as fig_method

from ...symmetry import scaled
from ..pages import drawn, words
from ..test_print import both_right, straight_undercut

TABLE = builtin_design()


@pytest.mark.parametrize("module", [6.0, 0.5])
def test_the_query_finds_a_vertex_and_the_polish_the_path(module: float) -> None:
    data = fig_method.compute(scaled(TABLE, module / 6.0))
    vertex, polished, exact = fig_method.points(data).values()
    assert data.query is not None
    assert data.point is not None
    gap = np.nanmin(data.query.separation)
    assert data.contacts[0].separation <= gap
    assert np.abs(polished - exact).max() < 1e-7 * module
    assert np.linalg.norm(vertex - exact) > module
    path = path_of_contact(data.design, "right", 3)
    np.testing.assert_array_equal(data.point, path.point[1])
    assert sum(data.triangles) == 60


@pytest.mark.parametrize("design", [TABLE, both_right()], ids=["table1", "both_right"])
def test_texts_of_the_detail_are_apart_and_in_their_panel(design: Design) -> None:
    page, _ = drawn("method", design, (1600, 1200))
    detail = page.axes[1]
    one, other = (text.get_window_extent() for text in detail.texts)
    assert not one.overlaps(other)
    for box in (one, other):
        assert detail.bbox.x0 < box.x0 < box.x1 < detail.bbox.x1
        assert detail.bbox.y0 < box.y0 < box.y1 < detail.bbox.y1


def test_the_page_has_the_errors_or_the_reason() -> None:
    page, rows = drawn("method", TABLE)
    assert "to 11 mm, a polish on the exact flanks to" in words(page)
    assert "\u00b710$^{\u221212}$ mm" in words(page)
    assert [row["point"] for row in rows][:4] == [*fig_method.MARKS, "vertex"]
    page, rows = drawn("method", TABLE.with_errors(Errors(offset=20.0)))
    assert words(page).count("the right flanks have no path of contact") == 2
    assert rows[0]["status"] == "the right flanks have no path of contact"


def test_without_a_contact_from_the_meshes_the_page_says_why() -> None:
    """Straight cylindrical flanks touch along lines, on which the search does not converge."""
    page, rows = drawn("method", straight_undercut())
    reason = "no contact found from the meshes: not converged; the flanks touch along lines"
    assert words(page).count(reason) == 2
    assert rows[0]["status"] == reason
    assert page.note == ""
    assert "Meshes within" not in page.subtitle
    assert not any(axes.axison for axes in page.axes)
