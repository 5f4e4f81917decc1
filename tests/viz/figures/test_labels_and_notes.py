"""Labels, ticks and notes that depend on the design: they fit, and name only what the figure shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import Ellipse
from matplotlib.path import Path as Outline
from matplotlib.text import Annotation

from beveloid_geom import Design, Modification, builtin_design
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.proximity.mesh_convergence import Convergence
from beveloid_geom.validation.near_singular import METHODS, MethodErrors
from beveloid_viz.components import panels, posed, viewpoint
from beveloid_viz.components.annotate import Overlay
from beveloid_viz.components.charts import _tick
from beveloid_viz.components.map_panel import next_to_unknown
from beveloid_viz.components.panels import Trace
from beveloid_viz.figures.methods import mesh_convergence, stability
from beveloid_viz.figures.methods.speed_accuracy import draw as draw_speed
from beveloid_viz.figures.paper import fig_01_pair, fig_06_modification
from beveloid_viz.figures.paper.fig_07_to_10_paths import coefficient_texts
from beveloid_viz.figures.paper.fig_12_to_15_misalignment import _free_corner
from beveloid_viz.figures.results import tolerance_cloud
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import PageLayout, of_size, of_width
from beveloid_viz.rendering.scene import Picture, Tube

from ...symmetry import mirrored, scaled
from ..pages import distances, drawn, page_of, recipe_of, short_measurements, texts
from ..test_print import both_right, straight_undercut
from .test_speed_accuracy import data_with

TABLE = builtin_design()
PARALLEL = builtin_design("anti-backlash")


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


@pytest.mark.parametrize("failed", ["", "five equations"])
def test_what_has_no_answer_is_in_the_note_and_not_in_the_legend(failed: str) -> None:
    data, lost = data_with(lambda: 1.0, failed), ("one equation", 1)
    page = page_of(draw_speed, data)
    assert len(page.legends[0].get_texts()) == 5 - bool(failed)
    assert page.note.endswith("Without an answer: five equations.") == bool(failed)
    changed = tuple(
        replace(one, status="5 of 5 positions not solved") if (one.method, one.value) == lost else one
        for one in data.measurements
    )
    note = page_of(draw_speed, replace(data, measurements=changed)).note
    assert note.endswith(f"Without an answer: {failed}{'; ' * bool(failed)}one equation, 1 position.")


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
def test_the_note_of_fig_11_names_only_what_is_drawn(design: Design, labelled: bool) -> None:
    """The note explains labelled dots only if there are any, and missing circles only if some are missing."""
    recipe = recipe_of("fig-11")
    with short_measurements():
        data = recipe.compute(design)
        unknown = {side: np.full_like(ratio, np.nan) for side, ratio in data.ratio.items()}
        notes = [page_of(recipe.draw, one).note for one in (data, replace(data, ratio=unknown))]
    assert ("Labelled dots" in notes[0]) == labelled
    assert ["Without circle" in note for note in notes] == [False, True]


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


def test_names_of_face_ends_in_fig_1_point_at_visible_points() -> None:
    pair, size = posed.pose(both_right(), "right"), (1600, 1200)
    page, _, _ = theme.new_page(of_width(90.0), "", "", "")
    picture = Picture(np.zeros((*size[::-1], 3), dtype=np.uint8), fig_01_pair.camera_of(pair, size), 0)
    over = Overlay(page.add_axes((0.0, 0.0, 1.0, 1.0)), picture)
    for number, member in enumerate(pair.design.members):
        near, far = to_fixed(pair.frames[number], posed.rings(member))
        assert fig_01_pair._visible(over, near, far) is near
        shown = fig_01_pair._visible(over, far, near)
        assert 0 < len(shown) < len(far)
        assert not Outline(picture.project(near)).contains_points(picture.project(shown)).any()


def test_labels_in_fig_1_do_not_point_at_the_other_member() -> None:
    """The front of a small pinion is behind the gear, so that it has no label."""
    page, _ = drawn("fig-01", straight_undercut(), (800, 600))
    labels = [text for axes in page.axes for text in axes.texts if isinstance(text, Annotation)]
    assert [text.get_text() for text in labels].count("front") == 1
    ends = {text.get_text().split("\n")[0]: text.xy for text in labels if "teeth" in text.get_text()}
    backs = sorted(text.xy[0] for text in labels if text.get_text() == "back")
    assert ends["pinion"][0] < backs[0] + 0.1 * (ends["gear"][0] - backs[0])
    assert "Heels" not in page.note


def test_the_note_of_fig_3_names_only_changed_angles() -> None:
    recipe = recipe_of("fig-03")
    note = page_of(recipe.draw, recipe.compute(PARALLEL)).note
    assert "(a) has $\\gamma$ = 15\u00b0 instead of 3\u00b0 for clarity." in note


def test_short_parts_that_are_not_first_contact_have_two_dashes() -> None:
    view = viewpoint.flank_view(TABLE.pinion, "right")
    assert view is not None
    points = view.middle + np.linspace(-20.0, 20.0, 101)[:, None] * np.array([0.0, 0.0, 1.0])
    first = np.ones(101, dtype=bool)
    first[40:46] = False
    items = panels.trace_items(Trace(points, first=first), view, 1.0)
    assert sum(isinstance(item, Tube) and item.radius == panels.THIN_WIDTH_RATIO for item in items) == 2


def test_shifts_have_the_decimals_of_the_error() -> None:
    page, _ = drawn("fig-14", builtin_design("awd-transfer"))
    assert texts(page).count("+0.25") == texts(page).count("\u22120.25") > 2


def test_the_note_on_first_contacts_names_only_what_is_drawn() -> None:
    for name, said in (("fig-08", False), ("fig-12", True)):
        recipe = recipe_of(name)
        note = page_of(recipe.draw, recipe.compute(PARALLEL)).note
        assert ("Not first: another tooth pair" in note) == said
        assert "Contact ratios: one tooth pair" in note


@pytest.mark.parametrize(
    ("design", "drawn_in_black"), [(TABLE, "contact ellipses"), (PARALLEL, "some lines")]
)
def test_the_note_of_the_pattern_names_ellipses_and_lines(design: Design, drawn_in_black: str) -> None:
    note = recipe_of("pattern").compute(design).note.partition("Black: ")[2]
    assert note.startswith(drawn_in_black)
    assert "contact ellipses of this pair" in note


def test_on_parallel_axes_sliding_is_zero_at_the_pitch_line() -> None:
    page, rows = drawn("sliding", PARALLEL)
    assert texts(page).count("pitch line") == 2
    assert page.note.endswith("closest to the pitch line.")
    marks = [line for line in page.axes[0].lines if line.get_linestyle() == ":"]
    one = [row for row in rows if row["flank"] == "right" and row["parabola_pinion_per_mm"] == 0.0]
    roll, specific = (np.array([row[key] for row in one]) for key in ("pinion_roll_rad", "pinion_specific"))
    at = float(np.degrees(np.interp(0.0, specific, roll)))
    assert np.asarray(marks[0].get_xdata())[0] == pytest.approx(at, abs=0.01)


def test_coefficients_with_many_decimals_have_a_common_power_of_ten() -> None:
    assert coefficient_texts([0.0, -0.00005, -0.0001]) == ["0", "\u22120.00005", "\u22120.0001"]
    ten = "\u00b710$^{\u22125}$"
    assert coefficient_texts([0.0, 0.000015, 0.00006]) == ["0", f"+1.5{ten}", f"+6{ten}"]
    assert coefficient_texts([0.0, -7.5e-6, -3e-5]) == ["0", f"\u22120.75{ten}", f"\u22123{ten}"]


def test_errors_in_the_sentence_on_meshes_are_those_at_its_tolerance() -> None:
    """Another tolerance has a larger error of the polished contact, which the sentence does not contain."""
    sizes = mesh_convergence.TOLERANCES_MM
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
    assert panels.half_width_pt(narrow) < panels.half_width_pt(wide) == panels.HALF_WIDTH_PT


@pytest.mark.parametrize(
    "design", [scaled(mirrored(TABLE), 1.0 / 3.0), both_right()], ids=("mirrored", "25/61")
)
@pytest.mark.parametrize("layout", [of_size((1600, 1200)), of_width(90.0)], ids=("wide", "narrow"))
def test_labels_of_radii_are_next_to_their_arrows(design: Design, layout: PageLayout) -> None:
    """In Fig. 4, the name of a radius is nearer to its arrow than to other radii and other arrows of its
    colour."""
    radius_pt = 1.4  # width of the arrows of radii
    recipe = recipe_of("fig-04")
    with theme.style():
        page = recipe.draw(recipe.compute(design), layout).page
    page.draw_without_rendering()
    names = {f"$r_{{{letter}{number}}}$" for letter in "wP" for number in (1, 2)}
    seen = set()
    for axes in page.axes:
        patches = []
        for each in axes.texts:
            if isinstance(each, Annotation) and (patch := each.arrow_patch) and not each.get_text():
                ends = axes.transData.transform([each.xyann, each.xy])
                patches.append((ends, patch.get_linewidth(), to_hex(patch.get_edgecolor())))
        for label in axes.texts:
            if label.get_text() not in names:
                continue
            box = label.get_window_extent()
            middle = np.array((box.x0 + box.x1, box.y0 + box.y1)) / 2.0
            colour = to_hex(label.get_color())
            near = [one for one in patches if one[2] == colour or one[1] == radius_pt]
            nearest = min(near, key=lambda one: distances(middle, one[0])[0])
            assert nearest[1:] == (radius_pt, colour)
            seen.add(label.get_text())
    assert seen == names


def test_figures_12_to_15_name_the_modifications_of_the_design() -> None:
    """The lower row has the paper's parabolas and the modifications of the design."""
    crowned = TABLE.pinion.modified(Modification(helix_crowning_um=10.0))
    for design, own in ((replace(TABLE, pinion=crowned), True), (TABLE, False)):
        page, _ = drawn("fig-12", design)
        assert any("with the design's modifications and $a_1$" in text for text in texts(page)) == own
        assert any("with modification, $a_1$" in text for text in texts(page)) != own


@pytest.mark.parametrize("name", ["transmission-error", "pattern"])
def test_without_curves_there_is_no_legend_or_note(name: str) -> None:
    """The tips of this pair reach the bottom lands, so that there is no first contact."""
    close = replace(TABLE, pair=replace(TABLE.pair, offset=TABLE.pair.offset - 5.0))
    page, _ = drawn(name, close)
    assert page.note == ""
    assert not page.legends
    assert not any(axes.axison for axes in page.axes)
