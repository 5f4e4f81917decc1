"""Figures of a pair on parallel axes with line contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.contact.parallel.lines import contact_lines
from beveloid_geom.report.operation import operation_report
from beveloid_geom.validation.claims import CLAIM_PARABOLAS_PER_MM
from beveloid_viz.components import motion_graph, paths_table
from beveloid_viz.figures.paper import fig_11_contact_ratio as ratios
from beveloid_viz.figures.results import posed_pair, sensitivity, tolerance_cloud

from .pages import drawn, words

PAIR = builtin_design("anti-backlash")
WORDS = {
    "fig-01": "The beveloid gear pair in mesh",
    "fig-04": "midway between the mid-faces on the pitch line",
    "fig-08": "Black: some lines of contact",
    "ease-off": "zero within rounding",
    "posed-pair": "on the line of contact (black)",
}


@pytest.mark.parametrize("name", WORDS)
def test_what_figures_say_of_lines(name: str) -> None:
    said = words(drawn(name, PAIR)[0])
    assert WORDS[name] in said, said
    assert "crossed" not in said.partition("Roll angles")[0]


@pytest.mark.parametrize("member", [0, 1])
def test_the_path_crosses_the_lines_drawn(member: int, flank: str) -> None:
    """Each drawn line contains a point of the path and has the length that the library computes."""
    lines = paths_table.solved_case(PAIR, flank).contact_lines(member)
    path = path_of_contact(PAIR, flank, paths_table.LINE_COUNT + 2)
    points = paths_table.points_on(path, member)[1:-1]
    way = lines[:, 1] - lines[:, 0]
    length = np.linalg.norm(way, axis=-1)
    np.testing.assert_allclose(length, contact_lines(path).length[1:-1], atol=1e-9)
    off = np.linalg.norm(np.cross(points - lines[:, 0], way), axis=-1) / length
    assert off.max() < 1e-9


def test_the_posed_pair_touches_along_a_line() -> None:
    """The line passes through the contact point from toe to heel."""
    data = posed_pair.compute(PAIR)
    line = posed_pair.line_of_contact(data)
    assert line is not None
    way = line[1] - line[0]
    assert np.linalg.norm(np.cross(data.pair.contact - line[0], way)) < 1e-9 * np.linalg.norm(way)
    assert np.ptp(line[:, 2]) == pytest.approx(float(PAIR.gear.face_width))
    bent = replace(data, path=paths_table.solved_case(PAIR.with_parabola(-1e-3, -1e-3), "right"))
    assert posed_pair.line_of_contact(bent) is None


def test_lines_of_contact_are_lines_of_the_page() -> None:
    """The lines of contact are drawn as straight lines on the flanks of both members."""
    page, _ = drawn("fig-08", PAIR)
    black = [line for axes in page.axes for line in axes.lines if line.get_solid_capstyle() == "butt"]
    drawn_lines = [np.column_stack(line.get_data()) for line in black]
    ends = [np.ptp(points, axis=0) for points in drawn_lines if points.shape == (2, 2)]
    upright = [reach for reach in ends if 0.0 < reach[0] < 0.05 * reach[1]]
    assert len(upright) >= 2 * paths_table.LINE_COUNT - 2


def test_the_modification_leaves_a_path_on_the_flanks() -> None:
    """Flanks that touch in points have no lines of contact."""
    bent = paths_table.paper_modified(PAIR)
    assert not len(paths_table.solved_case(bent, "right").contact_lines(0))
    assert paths_table.parabolas(bent, "right") == (-0.004, -0.004)
    assert paths_table.solved_case(bent, "right").has_path
    assert not len(paths_table.solved_case(builtin_design(), "right").contact_lines(1))
    crossed = paths_table.paper_modified(builtin_design())
    assert paths_table.parabolas(crossed, "right") == CLAIM_PARABOLAS_PER_MM


def test_lines_are_in_contact_and_not_their_ends() -> None:
    report = operation_report("", PAIR, "right", 13, 3, 0.00635)
    assert report.cycle.edge_share == 0.0
    graph = motion_graph.motion_graph(report)
    assert "contact along lines" in motion_graph.graph_text(graph)
    assert not graph.edge[np.abs(graph.alone) < 1e-12].any()
    assert graph.edge.any()  # a tooth pair alone, beyond its lines


def test_sensitivities_say_what_is_missing() -> None:
    plain, bent = sensitivity.compute(PAIR)
    assert plain.remarks == "both flanks: line contact"
    assert bent.remarks == "both flanks: path along the face"


def test_clouds_are_of_convex_flanks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cloud shows convex flanks, because line contact has no path under shaft-angle errors; the caption
    states this."""
    monkeypatch.setattr(tolerance_cloud, "MOUNTINGS", 8)
    monkeypatch.setattr(tolerance_cloud, "CYCLE_MOUNTINGS", 1)
    side = tolerance_cloud.compute(PAIR)
    assert side.cases[0].study is None
    assert side.nominal.design == side.cases[1].design
    assert all(np.isfinite(cloud[0]).all() for cloud in side.clouds[1:])
    assert "shaft-angle errors leave contact on edges only" in tolerance_cloud.counts(side.cases[0])


def test_no_edges_without_coefficients(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ratios, "CYCLE_POINTS", slice(0, 161, 160))
    data = ratios.compute(PAIR)
    assert data.lines
    for flank in ("right", "left"):
        assert (data.edges[flank][:, 0] == 0.0).all()
        np.testing.assert_allclose(data.ratio[flank][:, 0], 1.911, atol=1e-3)
