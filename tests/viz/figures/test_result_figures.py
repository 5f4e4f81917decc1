"""Figures of results agree with the library at any size of the pair."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from scipy.spatial import cKDTree

from beveloid_geom import (
    Design,
    Errors,
    builtin_design,
    ease_off,
    path_of_contact,
    path_sensitivity,
    path_sliding,
    tolerance_study,
)
from beveloid_geom.analysis.pattern_matrix import pattern_matrix
from beveloid_geom.analysis.tolerance import USUAL
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.pattern import pattern_report
from beveloid_geom.report.result import csv_of
from beveloid_geom.shapes.hexahedral_mesh import face_nodes
from beveloid_viz.components import charts, motion_graph, posed
from beveloid_viz.figures.results import (
    meshed_tooth as fig_meshed,
    pattern as fig_pattern,
    posed_pair as fig_posed,
    sensitivity as fig_sensitivity,
    tolerance_cloud as fig_cloud,
)
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size
from beveloid_viz.rendering.scene import Surface, Tube
from beveloid_viz.rendering.theme import Page

from ...cli.running import rows_of, run, strict_json
from ...symmetry import scaled
from ..pages import drawn, page_of, recipe_of, texts, words

SIZE = (800, 600)
STEPS = np.array((0.1, np.radians(0.01), 0.1, 0.1))


@pytest.fixture(autouse=True)
def _few_mountings(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("MOUNTINGS", 200), ("PATHS_DRAWN", 20), ("CYCLE_MOUNTINGS", 12)):
        monkeypatch.setattr(fig_cloud, name, value)


def test_sensitivity_is_the_librarys() -> None:
    design = builtin_design()
    data = fig_sensitivity.compute(design)
    for case, changed in zip(data, (design, design.with_parabola(0.001, -0.001)), strict=True):
        for flank in ("right", "left"):
            found = path_sensitivity(changed, flank)
            along, square, ratio, swing = (
                charts.changes_under_steps(case.sensitivities, q) for q in charts.QUANTITIES
            )
            for j, member in enumerate(("pinion", "gear")):
                np.testing.assert_array_equal(along[flank, member], found.face_shift_by[1, j] * STEPS)
                np.testing.assert_array_equal(square[flank, member], found.square_shift_by[1, j] * STEPS)
            np.testing.assert_allclose(ratio[flank, ""], 1e3 * found.contact_ratio_by * STEPS, rtol=1e-14)
            np.testing.assert_allclose(swing[flank, ""], ARCSEC * found.peak_to_peak_by * STEPS, rtol=1e-14)
    page, table = drawn("sensitivity", design, SIZE)
    shown = words(page)
    for value in ("+2.54", "\u221210.2", "\u22120.575", "+0.389", "\u221218.9", "0 under every error"):
        assert value in shown
    rows = [list(row.values()) for row in table]
    one = next(row for row in rows if row[:6] == [0.0, 0.0, "left", "face_shift", "gear", "shaft angle"])
    assert one[8] == pytest.approx(0.385224, abs=1e-6)
    assert one[10] == pytest.approx(path_sensitivity(design, "left").face_shift_by[1, 1, 1], rel=1e-12)


@cache
def clouds(flank: str) -> fig_cloud.CloudFigure:
    return fig_cloud.compute(builtin_design(), flank)


@cache
def cloud() -> tuple[Page, list[dict[str, Any]]]:
    """Return the figure of left flanks and its table."""
    recipe, data = recipe_of("tolerance-cloud"), clouds("left")
    header, rows = recipe.rows(data)
    page = page_of(recipe.draw, data, SIZE)
    page.draw_without_rendering()
    return page, [dict(zip(header, row, strict=True)) for row in rows]


def test_clouds_and_counts_are_the_librarys(flank: str) -> None:
    design = builtin_design()
    data = clouds(flank)
    study, drawn = tolerance_study(design, USUAL, flank, 200), data.cases[0].study
    assert drawn is not None
    np.testing.assert_array_equal(drawn.mountings.pinion_z, study.mountings.pinion_z)
    for factor, cloud in zip((5.0, 1.0), data.clouds, strict=True):
        errors = Errors(*(factor * drawn.mountings.errors[3]))
        path = path_of_contact(design.with_errors(errors), flank, 33)
        places = zip(cloud, design.members, (path.l1, path.l2), (path.u1, path.u2), strict=True)
        for points, member, l, u in places:
            np.testing.assert_allclose(points[3], flank_point(member, flank, l, u), rtol=0.0, atol=1e-9)


def test_the_title_of_the_cloud_is_the_range_of_the_middle() -> None:
    """The title contains the range from 1 to 99 % of the positions that `tolerance` computes, divided by the
    face width."""
    found = [float(row["pinion_z_middle_mm"]) for row in rows_of(run(*CLOUD.split(), "--csv"))]
    low, high = np.quantile(found, (0.01, 0.99))
    title = f"move the path over {high - low:.1f} mm, {100.0 * (high - low) / 50.0:.0f} % of the face"
    assert title in words(page_of(fig_cloud.draw, clouds("right"), SIZE))


def test_the_cloud_is_drawn_over_the_flanks() -> None:
    page, table = cloud()
    lines = [c for axes in page.axes for c in axes.collections if isinstance(c, LineCollection)]
    assert len(lines) == 2 * 2
    assert max(len(one.get_paths()) for one in lines) == 20
    legend = [text.get_text() for text in page.legends[0].get_texts()]
    assert "as designed: 200 of 200 with a path" in legend
    assert len(table) == 2 * 200


CLOUD = "tolerance --cases 200 --offset-tolerance 0.05 --shaft-angle-tolerance-deg 0.01"
CLOUD += " --pinion-axial-tolerance 0.1 --gear-axial-tolerance 0.1"


def test_picture_of_tolerances_its_table_and_the_command_agree() -> None:
    page, table = cloud()
    given = f"{CLOUD} --flank left --parabola-pinion 0.001 --parabola-gear -0.001 --operation 12"
    case = [row for row in table if row["parabola_pinion_per_mm"] == 0.001]
    printed = rows_of(run(*given.split(), "--csv"))
    written = csv.DictReader(io.StringIO(csv_of(case[0], (row.values() for row in case))))
    for row, wanted in zip(written, printed, strict=True):
        assert {name: row[name] for name in wanted} == wanted
    found = strict_json(run(*given.split(), "--json").stdout)["operation"]
    counts = words(page).partition("Edges touch in")[2]
    assert f" and {found['edges_carry']} of 12 mountings; patterns" in counts
    assert f" and {found['pattern']['toe_or_heel']} of {found['pattern']['known']} (as designed;" in counts
    assert "20 mountings of the design" in words(page)


@pytest.mark.parametrize(("offset", "lost"), [(0.0, 0), (1.6, 1), (50.0, 2)])
def test_figure_has_the_numbers_or_the_reason(offset: float, lost: int) -> None:
    design = builtin_design().with_errors(Errors(offset=offset))
    page, rows = drawn("sliding", design)
    assert words(page).count("no path on the flanks: the path of contact does not meet") == 2 * lost
    assert texts(page).count("pitch point") == 2 - lost
    known = [row for row in rows if not row["reason"]]
    assert len(rows) - len(known) == 2 * lost
    if offset == 0.0:
        found = path_sliding(path_of_contact(design, "right", 201))
        shown = [row["pinion_specific"] for row in known if row["flank"] == "right"][:201]
        np.testing.assert_array_equal(shown, found.specific[:, 0])


def test_an_ease_off_is_the_librarys() -> None:
    page, rows = drawn("ease-off", builtin_design())
    for flank in ("right", "left"):
        for parabola in ((0.0, 0.0), (0.001, -0.001)):
            design = builtin_design().with_parabola(*parabola)
            own = (flank, parabola[0])
            case = [row for row in rows if (row["flank"], row["parabola_pinion_per_mm"]) == own]
            found = ease_off(design, flank, (29, 41))
            grid = [row["deviation_mm"] for row in case if row["kind"] == "grid"]
            np.testing.assert_array_equal(grid, found.deviation.ravel())
            along = [row["l_mm"] for row in case if row["kind"] == "path"]
            np.testing.assert_array_equal(along, path_of_contact(design, flank, 41).l1)
            assert {row["twist_mm"] for row in case} == {found.second_order.twist}
            for value in found.corners.values():
                assert f"{1e3 * value:+.1f}".replace("-", "\u2212") in words(page)
    assert "crowning +5.22, +0.37" in words(page)


def test_an_ease_off_that_is_not_there_says_why() -> None:
    page, rows = drawn("ease-off", builtin_design().with_errors(Errors(offset=5.0)))
    assert words(page).count("no ease-off: the path of contact does not meet the right flanks") == 2
    assert [row["flank"] for row in rows if row["reason"]] == ["right", "right", "left"]
    page, rows = drawn("ease-off", builtin_design().with_parabola(-0.002, 0.003))
    assert any(np.isnan(row["deviation_mm"]) for row in rows)
    assert "none" in words(page)


@pytest.mark.parametrize("module", [0.05, 50.0])
def test_the_posed_pair_is_as_fine_at_any_module(module: float) -> None:
    usual, other = builtin_design(), scaled(builtin_design(), module / 6.0)
    assert fig_posed.tolerance_of(other) == pytest.approx(fig_posed.tolerance_of(usual) * module / 6.0)
    assert fig_posed.tolerance_of(usual) == pytest.approx(0.01)


def test_a_posed_pair_without_contact_says_why() -> None:
    """A pair without contact is drawn with the reason, but not its teeth in mesh. Members without a surface
    are not drawn."""
    design = builtin_design().with_errors(Errors(offset=50.0))
    data = fig_posed.compute(design)
    page = page_of(fig_posed.draw, data)
    assert words(page).count("the right flanks have no contact point") == 2
    assert "Ball" not in words(page)
    page = page_of(fig_posed.draw, replace(data, meshes=((None, "undercut"), (None, "undercut"))))
    assert words(page).count("no member can be drawn") == 2


def test_marks_of_the_posed_pair_are_on_its_teeth(flank: str) -> None:
    """Path and pattern lie on the flanks of teeth -1, 0, 1; the camera looks at lit flanks, gear on top."""
    data = fig_posed.compute(builtin_design().with_parabola(0.001, -0.001), flank)
    items, camera = fig_posed.mesh_view(data, (400, 300))
    pinion, frame = data.pair.design.pinion, data.pair.frames[0]
    lines = [item for item in items if isinstance(item, Tube) and len(item.points) > 1]
    paths, outlines = ([one for one in lines if one.colour == ink] for ink in (theme.VERMILLION, "white"))
    assert len(paths) == len(outlines) == 3
    for path, outline, tooth in zip(paths, outlines, (-1, 0, 1), strict=True):
        own = (outline.points - frame[1]) @ frame[0]
        back = posed.on_tooth(own, pinion, -tooth)
        np.testing.assert_allclose(back, data.path.points[0], rtol=0.0, atol=1e-9)
        # A path is in front of its outline, at the same place of the picture.
        ahead = (outline.points - path.points) @ camera.axes.T
        np.testing.assert_allclose(ahead[:, :2], 0.0, atol=1e-9)
        assert (np.abs(ahead[:, 2]) + path.radius > outline.radius).all()
        assert outline.radius > path.radius
    ball = next(item for item in items if isinstance(item, Tube) and len(item.points) == 1)
    np.testing.assert_allclose(camera.seen(ball.points)[0], 0.0, atol=camera.half_height)
    patterns = [item for item in items if isinstance(item, Surface) and item.colour == "#2f78b7"]
    assert len(patterns) == 3
    assert data.pattern is not None
    # The pattern consists of the marked points and of points on the border between them and the others.
    own = (patterns[1].points - frame[1]) @ frame[0]
    away, _ = cKDTree(data.pattern.points.reshape(-1, 3)).query(own)
    marked = np.isclose(away, 0.004 * 6.0, rtol=1e-9, atol=0.0)
    assert np.count_nonzero(marked) == np.count_nonzero(data.pattern.marked)
    cell = np.linalg.norm(np.diff(data.pattern.points, axis=1), axis=-1).max()
    assert (away < cell).all()
    normal = np.nanmean(data.path.path.normal, axis=0)
    right, _, back = camera.axes @ normal
    assert right < 0.0 < back  # the flank faces the light on the left, and the viewer
    assert float((data.pair.frames[1][1] - frame[1]) @ camera.axes[1]) > 0.0  # the gear is on top


MODIFIED = builtin_design().with_parabola(0.001, -0.001)


@pytest.fixture(scope="module")
def report() -> OperationReport:
    return operation_report("", MODIFIED, "right", 61, 10, MARKING_SEPARATION_MM)


def test_a_tooth_pair_has_one_text_on_both_members() -> None:
    """Pinion and gear have the same text on a tooth pair, although the smallest distance on a grid differs
    between them."""
    data = fig_pattern.compute_separation(builtin_design("marine-gearbox"))
    for column in data.columns:
        assert column.layers
        smallest = [float(np.nanmin(layer.values)) for layer in column.layers]
        assert smallest[0] != smallest[1]
        assert {layer.under for layer in column.layers} == {"in contact"}


def test_the_figure_of_the_pattern_has_the_commands_points() -> None:
    """The figure of the pattern has the points of the command, also for a module other than that of Table
    1."""
    small = scaled(MODIFIED, 0.5 / 6.0)
    found = pattern_report("", small, "left", MARKING_SEPARATION_MM).result
    layers = fig_pattern.compute_pattern(small).columns[2].layers
    assert layers is not None
    for layer, side in zip(layers, (found.pinion, found.gear), strict=True):
        np.testing.assert_array_equal(layer.l, side.l)
        np.testing.assert_array_equal(layer.values, 1e3 * side.least)


def test_the_error_repeats_and_its_dots_are_hand_overs(report: OperationReport) -> None:
    axes = Figure().add_subplot()
    charts.error_over_rolls(axes, report, 3)
    curve, edges, dots = axes.lines
    share, error = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    assert (share[0], share[-1]) == (0.0, 3.0)
    np.testing.assert_allclose(error[:61], ARCSEC * (report.first.transmission_error - report.cycle.mean))
    np.testing.assert_array_equal(error[:61], error[122:])
    known = np.isfinite(np.asarray(edges.get_ydata(), dtype=float))
    np.testing.assert_array_equal(known[:61], report.first.limit[:, 0] >= 0)
    assert len(np.asarray(dots.get_xdata())) == 3 * np.count_nonzero(report.cycle.hand_over)


def test_what_runs_is_the_first_of_the_tooth_pairs_alone(flank: str) -> None:
    """The curve in operation is the upper envelope of the curves of all tooth pairs, which are displaced by
    whole pitches."""
    graph = motion_graph.motion_graph(operation_report("", MODIFIED, flank, 65, 3, MARKING_SEPARATION_MM))
    first = np.fmax.reduce([graph.alone[k : k + 65] for k in range(0, 128 * motion_graph.REACH_PITCHES, 64)])
    np.testing.assert_allclose(first, graph.report.first.transmission_error, atol=1e-12)
    low, high = graph.limits
    assert low < graph.report.first.transmission_error.min() - graph.mean
    assert (high - low) * graph.pitch_radius >= MARKING_SEPARATION_MM
    assert abs(low) > abs(high)


@pytest.mark.parametrize("design", [MODIFIED, builtin_design("anti-backlash")], ids=["modified", "parallel"])
def test_contacts_of_the_mesh_cycle_give_the_curve_of_one_pair(design: Design, flank: str) -> None:
    """The curve of one pair from contacts of the mesh cycle equals that of separate searches. Parts that it
    lacks are below the chart."""
    report = operation_report("", design, flank, 65, 3, MARKING_SEPARATION_MM)
    graph, whole = motion_graph.motion_graph(report, None), motion_graph.motion_graph(report, 24)
    known = np.isfinite(graph.alone)
    np.testing.assert_array_equal(graph.pitches, whole.pitches)
    np.testing.assert_allclose(graph.alone[known], whole.alone[known], rtol=0.0, atol=1e-13)
    np.testing.assert_array_equal(graph.edge[known], whole.edge[known])
    assert known.sum() > 48
    assert np.nanmax(whole.alone[~known]) < graph.mean + graph.limits[0]


def test_amplitudes_are_the_cycles(report: OperationReport) -> None:
    axes = Figure().add_subplot()
    charts.amplitudes(axes, report)
    heights = [patch.get_height() for patch in axes.patches]  # type: ignore[attr-defined]
    np.testing.assert_allclose(heights, ARCSEC * np.abs(report.cycle.harmonics))


def test_the_spread_is_that_of_the_study() -> None:
    """The curve of the distribution reaches 50 % at the median of the mountings; the line marks the
    design."""
    study = tolerance_study(MODIFIED, USUAL, cases=101)
    axes = Figure().add_subplot()
    charts.distribution(axes, study, "contact_ratio", 1.0, "k")
    ratio = study.mountings.contact_ratio[study.mountings.solved]
    at, share = (np.asarray(part) for part in axes.lines[0].get_data())
    assert np.interp(50.0, share, at) == pytest.approx(float(np.median(ratio)), rel=1e-9)
    assert axes.lines[1].get_xdata() == study.nominal.contact_ratio[0]


def test_patterns_under_errors_are_the_librarys() -> None:
    page, rows = drawn("pattern-errors", MODIFIED)
    shown, found = words(page), pattern_matrix(MODIFIED, flank="right", resolution=0.4)
    own = [row for row in rows if row["flank"] == "right"]
    assert sum(row["status"] == "jammed" for row in own) == 1
    for k, cell in enumerate(found.cells):
        added = found.first[k // 3], found.second[k % 3]
        of_cell = [row for row in own if (row["offset_error_mm"], row["shaft_angle_error_rad"]) == added]
        if cell is None:
            assert [row["status"] for row in of_cell] == ["jammed"]
            continue
        side, one = cell.pattern.pinion, cell.ellipses[0]
        least = np.array([row["least_mm"] for row in of_cell])
        assert np.isin(least[np.isfinite(least)], side.least).all()
        assert least.size > side.least.size / 5
        assert {row["z_mm"] for row in of_cell} >= {-25.0, 25.0}
        assert {row["angle_rad"] for row in of_cell} == {one.angle}
        assert f"{one.major:.1f} \u00d7 {one.minor:.1f}" in shown
        assert f"TE {ARCSEC * found.cycle_peak_to_peak.flat[k]:.2f}\u2033" in shown
    assert shown.count("jammed") == 2
    assert shown.count("E (mm) \u22120.050") == 2
    design = builtin_design()
    mounted = replace(design.pair, pinion_mounting=211.6, gear_mounting=210.2)
    design = replace(design, pinion=replace(design.pinion, profile_shift=-2.0), pair=mounted)
    page, rows = drawn("pattern-errors", design)
    assert words(page).count("undercut") == 9  # the left flanks have no contact at all
    assert {row["status"] for row in rows} == {"undercut", "no_contact"}


@pytest.mark.parametrize("name", ["ni-2017", "anti-backlash"])
def test_words_stand_on_the_surfaces_that_they_name(name: str) -> None:
    """The face nearest to the viewer at a label belongs to the named surface. Every surface has one label."""
    data = fig_meshed.compute(builtin_design(name))
    assert data.mesh
    drawing = fig_meshed.draw(data, of_size((1600, 1200)))
    mesh = data.mesh
    faces = [(key, mesh.points[face_nodes(mesh, own)[:, :4]]) for key, own in mesh.surfaces.items()]
    named = []
    for axes, picture in zip(drawing.page.axes[1::2], drawing.pictures.values(), strict=True):
        for text in axes.texts:
            assert isinstance(text, Annotation)
            found = []
            for key, corners in faces:
                inside = within(picture.project(corners), np.array(text.xy))
                depths = (corners @ picture.camera.axes[2]).max(axis=1)[inside]
                found += [(depth, key) for depth in depths.tolist()]
            assert max(found)[1] == text.get_text()
            named.append(text.get_text())
    assert sorted(named) == sorted(data.mesh.surfaces)


def within(corners: FloatArray, place: FloatArray) -> Mask:
    """Return which of convex polygons (n, corners, 2) contain a point (2,)."""
    side, to = np.roll(corners, -1, axis=1) - corners, place - corners
    turn = side[..., 0] * to[..., 1] - side[..., 1] * to[..., 0]
    return np.asarray((turn >= 0.0).all(axis=1) | (turn <= 0.0).all(axis=1))
