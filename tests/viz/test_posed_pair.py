"""The figure of the posed pair, of any size and without teeth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import builtin_design
from beveloid_viz.figures.results import posed_pair as fig_posed
from beveloid_viz.parts import posed, solved
from beveloid_viz.stage import theme
from beveloid_viz.stage.opengl import require_opengl

from ..symmetry import scaled
from .pages import words


@pytest.mark.parametrize("module", [0.05, 50.0])
def test_the_posed_pair_is_as_fine_at_any_module(module: float) -> None:
    usual, other = builtin_design(), scaled(builtin_design(), module / 6.0)
    assert fig_posed.tolerance_of(other) == pytest.approx(fig_posed.tolerance_of(usual) * module / 6.0)
    assert fig_posed.tolerance_of(usual) == pytest.approx(fig_posed.EXPORTED)
    assert fig_posed._export_note(usual) == ""
    assert f"--tolerance {module / 600.0:.3g}" in fig_posed._export_note(other)


def test_an_empty_picture_of_the_posed_pair_says_why() -> None:
    """The pinion cannot be drawn, and of the gear there is nothing where its teeth would be in mesh."""
    require_opengl()
    design = builtin_design()
    astray = replace(posed.pose(design), contact=np.array([0.0, 0.0, 1e4]))
    data = fig_posed.PosedFigure(
        astray, ((None, "undercut"), (None, "undercut")), solved.solve(design, "right")
    )
    with theme.style():
        page = fig_posed.draw(data, (400, 300)).page
    assert words(page).count("no contact point to look at") == 2
