"""First contacts of all teeth and edge contact in figures of paths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, Errors, builtin_design, first_contact, mesh_cycle, path_certificate
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.status import Verdict
from beveloid_viz.components import panels, paths_table, viewpoint
from beveloid_viz.components.panels import Trace
from beveloid_viz.rendering.polylines import spaced
from beveloid_viz.rendering.scene import Arrow

from ...oracle.table1 import table1
from ..pages import drawn, texts

MODIFIED = table1((0.001, -0.001))


def widths(design: Design, member: int = 0) -> tuple[list[float], paths_table.SolvedPath]:
    """Return the radii of the tubes along the path relative to usual paths."""
    path = paths_table.solved_case(design, "right", touching=True)
    view = viewpoint.flank_view(design.members[member], "right")
    assert view is not None
    items = panels.trace_items(Trace(path.points[member], first=path.first), view, 1.0)
    return [item.radius for item in items if hasattr(item, "radius")], path


def test_only_first_contacts_are_drawn_thick() -> None:
    radii, path = widths(MODIFIED)
    assert path.first is not None
    touches = path_certificate(path.path).verdict == Verdict.FIRST_CONTACT
    np.testing.assert_array_equal(path.first, touches)
    assert 40 < touches.sum() < 50
    assert {1.0, panels.THIN_WIDTH_RATIO} <= set(radii)
    assert widths(table1())[0][0] == 1.0
    assert panels.THIN_WIDTH_RATIO not in widths(table1())[0]


def test_lines_where_edges_touch_lie_on_them() -> None:
    """The tip edge of the gear is in contact. Its lines are drawn on both members."""
    path = paths_table.solved_case(MODIFIED, "right", touching=True)
    assert path.touching is not None
    assert {name for name in path.touching.edges if name} == {"gear tip"}
    lines = path.edge_lines(1)
    assert len(lines) == len(path.edge_lines(0)) >= 1
    for line in lines:
        radius = np.hypot(line[:, 0], line[:, 1])
        np.testing.assert_allclose(radius, tip_radius(MODIFIED.gear, line[:, 2]), rtol=1e-9)
    assert panels.ratios(path) == ("1.816", "1.000")


def test_teeth_touch_on_edges_where_no_path_lies_on_the_flanks() -> None:
    away = table1(errors=Errors(offset=0.0, shaft_angle=np.radians(0.05)))
    path = paths_table.solved_case(away, "right", touching=True)
    assert not path.has_path
    assert path.first is None
    assert path.edge_lines(0)
    assert path.edge_lines(1)


SHORT = builtin_design("anti-backlash").with_parabola(-0.0004, -0.0004)


def test_edge_contact_where_a_path_is_shorter_than_a_pitch() -> None:
    """If a path is shorter than a pitch, edges of toe and heel of the gear are in contact during the
    remainder, which is the share of edge contact of the mesh cycle."""
    path = paths_table.solved_case(SHORT, "right", touching=True)
    assert path.touching is not None
    assert path.between is not None
    assert not any(path.touching.edges)
    on_edge = np.array(path.between.edges) != ""
    assert {name for name in path.between.edges if name} == {"gear toe", "gear heel"}
    rolls = path.between.first.pinion_roll[on_edge]
    cycle = mesh_cycle(SHORT, "right")
    np.testing.assert_allclose(np.ptp(rolls), cycle.edge_share * cycle.pitch, rtol=1e-9)
    half = 0.5 * float(SHORT.gear.face_width)
    assert sorted({float(z) for line in path.edge_lines(1) for z in np.round(line[:, 2], 9)}) == [-half, half]


def edge_starts_at(design: Design, low: float, high: float) -> float:
    """Return the roll between two rolls at which edge contact starts, by search and division in tenths."""
    while high - low > 1e-12:
        rolls = np.linspace(low, high, 11)
        edge = first_contact(design, "right", rolls).limit[:, 0] >= 0
        assert not edge[0]
        assert edge[-1]
        low, high = rolls[int(np.argmax(edge)) - 1 : int(np.argmax(edge)) + 1].tolist()
    return high


def test_edge_contact_is_drawn_to_its_ends() -> None:
    """Edge contact of the next tooth pair lasts from its start, here found by search, until the path of
    this pair starts. The positions of the path alone would leave out more than 1 mm."""
    path = paths_table.solved_case(MODIFIED, "right", touching=True)
    start = edge_starts_at(MODIFIED, 0.16, 0.2)
    first = first_contact(MODIFIED, "right", [start])
    lines = path.edge_lines(1)
    assert len(lines) == 1
    ends = np.sort(lines[0][[0, -1], 2])
    np.testing.assert_allclose(ends, np.sort([first.z2[0], path.points[1][0, 2]]), atol=1e-6)
    sampled = replace(path, between=None).edge_lines(1)
    assert np.ptp(lines[0][:, 2]) - np.ptp(sampled[0][:, 2]) > 1.0


def test_no_tube_turns_back_within_its_own_width() -> None:
    line = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.05, 1.5, 0.0], [0.0, 3.0, 0.0], [0.0, 3.2, 0.0]])
    np.testing.assert_array_equal(spaced(line, 1.0), line[[0, 2, 4]])
    np.testing.assert_array_equal(spaced(line[:2], 1.0), line[:2])
    np.testing.assert_array_equal(spaced(line[:1], 1.0), line[:1])
    np.testing.assert_array_equal(spaced(line, 0.0), line)


def test_a_head_is_large_only_where_all_of_it_is_contact() -> None:
    view = viewpoint.flank_view(MODIFIED.pinion, "right")
    assert view is not None
    points = view.middle + np.linspace(-20.0, 20.0, 101)[:, None] * np.array([0.0, 0.0, 1.0])
    for last, size in ((101, 1.0), (40, 1.0), (1, 0.65), (0, 0.65)):
        first = np.arange(101) >= 101 - last
        head = panels.trace_items(Trace(points, first=first), view, 1.0)[-1]
        assert isinstance(head, Arrow)
        assert np.linalg.norm(head.vector) == pytest.approx(size * 8.0, rel=0.05)


def test_a_ratio_that_is_not_known_is_said_in_words() -> None:
    assert paths_table.ratio_words(1.5, float("nan")) == "ratio 1.500, in operation unknown"


@pytest.mark.parametrize(
    "design",
    [MODIFIED, table1(errors=Errors(shaft_angle=np.radians(0.05))), SHORT],
    ids=("modified", "away", "short"),
)
def test_the_table_holds_what_is_drawn(design: Design) -> None:
    path = paths_table.solved_case(design, "right", touching=True)
    header, body = paths_table.table(("case",), [((1,), path)])
    rows = [dict(zip(header, row, strict=True)) for row in body]
    for member, name in enumerate(paths_table.MEMBERS):
        own = [row for row in rows if row["member"] == name]
        z = np.array([row["edge_z_mm"] for row in own], dtype=float)
        drawn = np.concatenate([line[:, 2] for line in path.edge_lines(member)])
        np.testing.assert_allclose(np.sort(z[np.isfinite(z)]), np.sort(drawn), rtol=1e-12, atol=1e-12)
        first = {row["verdict"] == "FIRST_CONTACT" for row in own}
        assert first == ({True, False} if path.has_path else {False})


def test_jammed_pairs_are_named_in_fig_12() -> None:
    """With an offset error of -0.5 mm the backlash is -0.31 mm, so that the pair cannot be assembled."""
    page, rows = drawn("fig-12", table1(), (1600, 1200))
    for row in rows:
        assert (row["verdict"] == "JAMMED") == (row["offset_error_mm"] == -0.5)
        assert row["verdict"] != "JAMMED" or row["operating_contact_ratio"] == row["edge_that_touches"] == ""
    assert texts(page).count("jammed") == 2  # without and with modification
    assert "or the pair jams (cannot be assembled)" in page.note
    assert len(page.note.split()) <= 60
    path = paths_table.solved_case(table1(errors=Errors(offset=-0.5)), "right", touching=True)
    assert path.first is not None
    assert not path.first.any()
    assert not path.edge_lines(0)
