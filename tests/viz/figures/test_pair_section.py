"""Fig. 1: the section of both members contains the common normal, and text and section do not cover the
gears."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.design.ends import end_names
from beveloid_viz.figures.paper import fig_01_pair as fig_pair
from beveloid_viz.rendering.layout import PageLayout, of_size

from ...oracle.table1 import table1
from ..pages import distances
from ..test_print import in_print


def test_one_plane_cuts_both_members_and_they_touch_in_one_place() -> None:
    design = table1()
    data = fig_pair.compute(design)
    normal = path_of_contact(design, "right", 3).normal[1]
    np.testing.assert_allclose(data.axes @ normal, [0.0, -1.0], atol=1e-12)
    flat = []
    for found in data.sections:
        outline = max(found, key=len) - data.pair.contact
        np.testing.assert_array_equal(outline[0], outline[-1])
        np.testing.assert_allclose(outline @ np.cross(*data.axes), 0.0, atol=1e-4)
        flat.append(outline @ data.axes.T)
    for own, other in (flat, flat[::-1]):
        near = own[np.linalg.norm(own, axis=1) < 20.0]
        assert len(near) > 50
        inside = near[Path(other).contains_points(near)]
        assert (distances(inside, other) < 0.05).all()  # accuracy of the meshes
        assert np.linalg.norm(near, axis=1).min() < 1.0


@pytest.mark.parametrize("layout", [of_size((800, 600)), in_print(90.0)], ids=["page", "90 mm"])
@pytest.mark.parametrize("name", ["ni-2017", "awd-transfer", "marine-gearbox", "anti-backlash"])
def test_words_and_section_hide_no_gear(name: str, layout: PageLayout) -> None:
    """Labels and section are on a white background, and each end of a face is labelled once."""
    drawing = fig_pair.RECIPES["fig-01"].drawn(fig_pair.compute(builtin_design(name)), layout)
    image = drawing.pictures["pair"].image[::-1]
    _, over, section = drawing.page.axes
    corner = over.get_window_extent().min

    def hidden(box: Bbox) -> int:
        (left, low), (right, high) = np.maximum(np.rint(box.get_points() - corner).astype(int), 0)
        return int((image[low:high, left:right] < 255).any(axis=-1).sum())

    named = [text for text in over.texts if text.get_text() and "$" not in text.get_text()]
    words = [text.get_text().split("\n")[0] for text in named]
    ends = [end for member in builtin_design(name).members for end in end_names(member)]
    assert sorted(word for word in words if not word.endswith(" mm")) == sorted(["gear", "pinion", *ends])
    assert [text.get_text() for text in named if hidden(Text.get_window_extent(text))] == []
    assert hidden(section.get_window_extent()) == 0
