"""Views of flanks, and the sketch that explains them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.text import Annotation

from beveloid_geom import builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_viz.components import viewpoint

from .pages import drawn, texts


def at_mid_face(number: int, flank: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points at mid-depth and tip, and the outward normal at mid-depth, (3,) each."""
    member, z = builtin_design().members[number], np.zeros(1)
    tip = float(tip_parameter(member, flank, z)[0])
    l = np.array([[0.0], [tip]])
    patch = flank_patch(member, flank, l, z=z)
    return patch.point[0, 0], patch.point[1, 0], patch.normal[0, 0]


@pytest.mark.parametrize("outside", [False, True])
@pytest.mark.parametrize("number", [0, 1])
def test_views_are_what_they_are_called(number: int, flank: str, outside: bool) -> None:
    """The heel is at the top and nothing is mirrored. As in the paper, the tip is on the right and right
    flanks are seen through the tooth; other views are from outside."""
    middle, tip, normal = at_mid_face(number, flank)
    view = viewpoint.flank_view(builtin_design().members[number], flank, outside=outside)
    assert view is not None
    assert np.linalg.det(view.axes) == pytest.approx(1.0)
    assert view.axes[1, 2] > 0.5
    assert view.outside == (outside or flank == "left")
    assert (view.axes[2] @ normal > 0.9) == view.outside
    assert ((tip - middle) @ view.axes[0] > 0.0) == (flank == "left" or not outside)
    assert view.marks[2, 1, 0] * view.marks[0, 1, 0] < 0.0


@pytest.mark.parametrize("number", [0, 1])
def test_right_flanks_are_on_the_right_from_the_toe(number: int) -> None:
    """In a view along z with the tooth upright, the right flank is on the right."""
    right, left = (at_mid_face(number, flank)[0] for flank in ("right", "left"))
    up = right + left
    assert np.cross((0.0, 0.0, 1.0), up) @ (right - left) > 0.0


@pytest.mark.parametrize(
    ("looks", "words", "eyes"),
    [
        ([("right", False)], "right flanks through the tooth", [-1]),
        ([("left", True)], "left flanks from outside", [-1]),
        ([("right", True)], "right flanks from outside", [1]),
        ([("right", True), ("left", True)], "flanks from outside", [1, -1]),
        ([("right", False), ("left", True)], "right through the tooth, left from outside", [-1, -1]),
    ],
)
def test_the_sketch_has_an_eye_where_one_looks_from(
    looks: list[viewpoint.Look], words: str, eyes: list[int]
) -> None:
    axes = Axes(Figure(), (0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 220.0), ylim=(100.0, 0.0))
    viewpoint.sketch(axes, looks, 100.0)
    pupils: list[Any] = [patch for patch in axes.patches if isinstance(patch, Ellipse)]
    assert [np.sign(pupil.get_center()[0] - 110.0) for pupil in pupils] == eyes
    notes: list[Any] = [text for text in axes.texts if isinstance(text, Annotation)]
    assert [text.get_text() for text in notes if text.get_text()] == [words]
    arrows = [text for text in notes if not text.get_text()]
    for (flank, outside), eye, arrow in zip(looks, eyes, arrows, strict=True):
        head, tail = arrow.xy[0] - 110.0, arrow.get_position()[0] - 110.0
        side = 1.0 if flank == "right" else -1.0
        assert eye * tail > 0.0
        assert side * head > 0.0
        metal = 100.0 * 0.2  # half the width of the tooth at half its depth
        assert (side * head > metal) == outside


@pytest.mark.slow
@pytest.mark.parametrize(("name", "details"), [("fig-12", 0), ("fig-14", 4)])
def test_paths_that_are_close_together_have_a_detail(name: str, details: int) -> None:
    """Each detail shows the path without error in its middle, magnified, and its frame is on the flank."""
    page, _ = drawn(name, builtin_design(), (800, 600))
    assert texts(page).count("\u00d7 5") == details
    frames = [patch for axes in page.axes for patch in axes.patches if isinstance(patch, Rectangle)]
    sizes = np.array([patch.get_bbox().size for patch in frames]).reshape(-1, 2, 2)
    np.testing.assert_allclose(sizes[:, 1] + 2.0, 5.0 * sizes[:, 0])
    assert len(sizes) == details
    assert {"not first", "edge contact"} <= {text.get_text() for text in page.legends[0].get_texts()}
    assert "shift mm" in texts(page)
