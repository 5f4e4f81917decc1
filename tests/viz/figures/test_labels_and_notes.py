"""Labels, ticks and notes that depend on the design: they fit, and name only what the figure shows."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.patches import Ellipse

from beveloid_geom import Design, builtin_design
from beveloid_geom.shapes.proximity.mesh_convergence import Convergence
from beveloid_geom.validation.near_singular import METHODS, MethodErrors
from beveloid_viz.components import panels
from beveloid_viz.components.charts import _tick
from beveloid_viz.components.map_panel import next_to_unknown
from beveloid_viz.figures.methods import mesh_convergence, stability
from beveloid_viz.figures.methods.speed_accuracy import SpeedAccuracy, draw as draw_speed
from beveloid_viz.figures.paper import fig_06_modification
from beveloid_viz.figures.paper.fig_07_to_10_paths import coefficient_texts
from beveloid_viz.figures.paper.fig_12_to_15_misalignment import _free_corner
from beveloid_viz.figures.results import tolerance_cloud
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size, of_width

from ...symmetry import scaled
from ..pages import page_of, recipe_of, short_measurements
from ..test_print import both_right
from .test_speed_accuracy import data_with

TABLE = builtin_design()


def errors_of_methods(error: float) -> MethodErrors:
    """Return errors of methods of which only the third is large, at two of four shaft angles."""
    above, errors = np.radians([1e-4, 1e-3, 1e-2, 0.1]), np.full((len(METHODS), 4), 1e-9)
    errors[2, :2] = error, 0.5 * error
    reasons = tuple(("",) * 4 for _ in METHODS)
    return MethodErrors(above, np.full(4, 229.0), errors, np.full_like(errors, np.nan), reasons)


def test_wrong_points_have_one_label_and_a_limit_in_proportion_to_the_module() -> None:
    assert stability.wrong_mm(TABLE) == pytest.approx(0.01)
    assert stability.wrong_mm(scaled(TABLE, 20.0 / 6.0)) == pytest.approx(0.01 * 20.0 / 6.0)
    found = errors_of_methods(0.025)
    assert stability.wrong(found, 2, 0.01).tolist() == [0, 1]
    assert stability.wrong(found, 2, 0.03).size == 0
    page, _, _ = theme.new_page(of_width(90.0), "", "", "")
    axes = page.add_axes((0.2, 0.2, 0.7, 0.7))
    stability._errors(axes, found, 0.01)
    assert [text.get_text() for text in axes.texts] == ["wrong by up to 0.025 mm"]


def test_a_method_without_an_answer_is_in_the_note_and_not_in_the_legend() -> None:
    for failed, lost in (("", 0), ("five equations", 1)):
        data: SpeedAccuracy = data_with(lambda: 1.0, failed)
        page = page_of(draw_speed, data)
        (legend,) = page.legends
        assert len(legend.get_texts()) == 5 - lost
        assert page.note.endswith("Without an answer: five equations.") == bool(lost)


@pytest.mark.parametrize("greatest", [0.0172, 0.99, 1.31, 3.46, 4.86, 7.3, 10.4, 486.0, 870.0])
def test_ticks_of_narrow_axes_are_short_and_far_from_zero(greatest: float) -> None:
    tick = _tick(greatest)
    assert 0.7 * greatest < tick <= 1.15 * greatest
    assert len(f"{tick:g}".strip("0.").replace(".", "")) <= 2


def test_cells_next_to_unknown_ones() -> None:
    values = np.zeros((6, 6))
    assert not next_to_unknown(values, 2).any()
    values[0, 0] = np.nan
    assert np.argwhere(next_to_unknown(values, 2)).max() == 2
    assert next_to_unknown(values, 1).sum() == 4


def test_ellipses_stay_in_their_cells() -> None:
    recipe = recipe_of("pattern-errors")
    page = recipe.drawn(recipe.compute(TABLE), of_width(90.0)).page
    count = 0
    for axes in page.axes:
        for ring in axes.patches:
            if isinstance(ring, Ellipse):
                box, cell = ring.get_window_extent(), axes.get_window_extent()
                assert cell.x0 <= box.x0 <= box.x1 <= cell.x1
                count += 1
    assert count == 32  # two of 18 cells are jammed


@pytest.mark.parametrize(("design", "labelled"), [(TABLE, True), (both_right(), False)])
def test_the_note_of_fig_11_names_labelled_dots_only_if_there_are_any(design: Design, labelled: bool) -> None:
    recipe = recipe_of("fig-11")
    with short_measurements():
        page = recipe.drawn(recipe.compute(design), of_width(90.0)).page
    assert ("Labelled dots" in page.note) == labelled


def test_empty_panels_have_no_axes() -> None:
    recipe = recipe_of("mesh-convergence")
    with short_measurements():
        data = recipe.compute(builtin_design("anti-backlash"))
    assert len(data.reasons) == 2
    page = page_of(recipe.draw, data)
    assert not any(axes.axison for axes in page.axes)
    assert page.note == ""


def test_the_factor_of_a_detail_is_in_a_corner_without_paths() -> None:
    image = np.full((60, 120, 3), 180, dtype=np.uint8)
    assert _free_corner(image, 72.0) == (False, False)
    image[:, :40] = np.arange(60, dtype=np.uint8)[:, None, None] * 4
    assert _free_corner(image, 72.0) == (True, False)


def test_deviations_in_fig_6_continue_to_the_base_circle() -> None:
    """The concave flank reaches below the start of the involute flank. There, its deviation continues evenly,
    and inside the base circle there is none."""
    section = fig_06_modification.compute(builtin_design("marine-gearbox")).sections[1]
    steps = np.diff(np.diff(section.deviation) / np.diff(section.radius))[:40]
    assert 0.0 < steps.min() < steps.max() < 3.0 * np.median(steps)
    section = fig_06_modification.compute(both_right()).sections[1]
    assert np.isnan(section.deviation).sum() == 2
    assert np.isnan(section.deviation[:2]).all()


def test_coefficients_with_many_decimals_have_a_common_power_of_ten() -> None:
    assert coefficient_texts([0.0, -0.00005, -0.0001]) == ["0", "\u22120.00005", "\u22120.0001"]
    ten = "\u00b710$^{\u22125}$"
    assert coefficient_texts([0.0, 0.000015, 0.00006]) == ["0", f"+1.5{ten}", f"+6{ten}"]
    assert coefficient_texts([0.0, -7.5e-6, -3e-5]) == ["0", f"\u22120.75{ten}", f"\u22123{ten}"]


def test_errors_in_the_sentence_on_meshes_are_those_at_its_tolerance() -> None:
    """Another tolerance has a larger error of the polished contact, which the sentence does not contain."""
    sizes = mesh_convergence.TOLERANCES
    faces, ones = np.full(len(sizes), 8), np.ones(len(sizes))
    polished = np.where(np.isclose(sizes, 0.001), 2e-13, 4e-12)
    found: dict[tuple[str, bool], tuple[Convergence, ...]] = {
        ("right", polish): (Convergence(sizes, error, error, faces),)
        for polish, error in ((False, ones), (True, polished))
    }
    data = mesh_convergence.ConvergenceFigure(found, {"left": "no contact"})
    assert "right flanks 1\u00a0mm off, polished 2\u00b710$^{\u221213}$" in mesh_convergence.finding(data)


def test_jammed_mountings_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tolerance_cloud, "MOUNTINGS", 64)
    monkeypatch.setattr(tolerance_cloud, "CYCLE_MOUNTINGS", 1)
    for design, some in ((TABLE, False), (scaled(TABLE, 0.05), True)):
        case = tolerance_cloud.case_study("right", "as designed", design, theme.BLUE, 1.0)
        assert case.study is not None
        jammed = np.count_nonzero(case.study.mountings.jammed)
        assert bool(jammed) == some
        assert tolerance_cloud.counts(case).endswith(f", {jammed} jammed" if some else "with a path")


def test_paths_are_thinner_on_narrow_pages() -> None:
    wide, narrow = (
        theme.new_page(layout, "title", "", "")[0] for layout in (of_size((800, 600)), of_width(90.0))
    )
    assert panels.line_points(narrow) < panels.line_points(wide) == panels.LINE_POINTS
