"""Figures of pairs whose axes intersect far from the members."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import MeshErrors, builtin_design, path_of_contact, path_sensitivity
from beveloid_geom.analysis.tolerance import USUAL_AT
from beveloid_geom.design.file import builtin_text
from beveloid_geom.pair.frames import layout_of
from beveloid_geom.pair.misalignment_at_mesh import from_mesh
from beveloid_viz.components import paths_table, posed
from beveloid_viz.figures.paper import fig_04_meshing, fig_05_errors
from beveloid_viz.figures.paper.fig_12_to_15_misalignment import CASES, compute as misaligned
from beveloid_viz.figures.results import pattern_errors, sensitivity, tolerance_cloud
from beveloid_viz.report.cli import main as render_report
from tests.validation.test_intersecting_axes import DESIGNS, LARGE

from ...cli.running import run
from ..pages import drawn, words
from ..report.report_page import ReportPage

WORDS = {
    "fig-01": "axes at 7°, shortest distance 0 mm, 2162 mm from the members",
    "fig-04": "Offset $E$ = 0 mm, shaft angle $\\delta$ = 7°",
    "fig-05": "drawn: 164 mm, 327 times 0.5 mm",
}


@pytest.mark.parametrize("name", DESIGNS)
def test_pictures_are_scaled_by_the_distance_of_the_members(name: str) -> None:
    pair = posed.pose(DESIGNS[name])
    assert pair.touching
    assert pair.remote
    radii = [float(m.tool.normal_module) * float(m.teeth) / 2.0 for m in DESIGNS[name].members]
    assert 0.8 * sum(radii) < pair.apart < 1.1 * sum(radii)


def test_a_crossed_pair_is_scaled_by_its_offset() -> None:
    pair = posed.pose(builtin_design())
    assert pair.apart == pytest.approx(229.0, abs=1e-9)
    assert not pair.remote


@pytest.mark.slow
@pytest.mark.parametrize("name", WORDS)
def test_the_layout_is_drawn(name: str) -> None:
    page, rows = drawn(name, LARGE)
    assert rows
    assert WORDS[name] in words(page), words(page)
    if name != "fig-01":
        assert ("$E$ = 0" in words(page)) == (name == "fig-04")
        assert "common perpendicular at 2162 mm, drawn at 623 mm" in words(page)


@pytest.mark.parametrize("name", DESIGNS)
def test_a_remote_perpendicular_is_drawn_nearer(name: str) -> None:
    """The common perpendicular is drawn on the pinion axis at the stated distance, and each axis is broken
    between it and the face."""
    data = fig_04_meshing.compute(DESIGNS[name])
    pair, half = data.pair, np.array([0.5 * float(m.face_width) for m in DESIGNS[name].members])
    away = float(np.linalg.norm(data.feet[0] - pair.frames[0][1]))
    np.testing.assert_allclose(np.cross(data.feet[0] - pair.frames[0][1], pair.axis[0]), 0.0, atol=1e-9)
    np.testing.assert_allclose(data.feet[1] - data.feet[0], pair.foot[1] - pair.foot[0], atol=1e-9)
    assert f"at {abs(pair.position[0]):.0f} mm" in posed.far_words(pair)
    assert f"drawn at {away:.0f} mm" in posed.far_words(pair)
    towards = -np.sign(pair.position) * pair.breaks
    assert (towards > half).all()
    assert (towards < away).all()
    shaft_angle = float(layout_of(DESIGNS[name]).shaft_angle)
    assert 0.5 < data.gear_direction @ pair.axis[0] < np.cos(2.0 * shaft_angle)


@pytest.mark.parametrize("name", DESIGNS)
def test_errors_are_as_large_as_said_where_frames_are_drawn_nearer(name: str) -> None:
    """Displacements and rotations have the stated size, although the frames are drawn nearer. Members without
    error and the table keep their positions."""
    data = fig_05_errors.compute(DESIGNS[name])
    nominal = data.seen(data.nominal)
    for own in ("q1", "d1", "q2", "d2"):
        np.testing.assert_array_equal(nominal[own][1], data.nominal[own][1])
    for panel, size, displaced in zip(fig_05_errors.PANELS, data.drawn, data.displaced, strict=True):
        before, after = nominal[panel.before], data.seen(displaced)[panel.after]
        moved = float(np.linalg.norm(after[1] - before[1]))
        turned = float(np.arccos(before[0][:, 2] @ after[0][:, 2]))
        assert (moved, turned)[panel.key == "shaft_angle"] == pytest.approx(size, rel=1e-9)
    tilted = data.seen(data.displaced[1])
    away = [np.linalg.norm(frames["d1"][1] - frames["f"][1]) for frames in (nominal, tilted)]
    assert away[0] == pytest.approx(away[1], rel=1e-12)
    header, rows = fig_05_errors.rows(data)
    first = dict(zip(header, next(iter(rows)), strict=True))
    assert [first[f"origin_{component}_mm"] for component in "xyz"] == [0.0, 0.0, 0.0]


def test_a_perpendicular_at_the_members_stays() -> None:
    data = fig_05_errors.compute(builtin_design())
    for frames in (data.nominal, *data.displaced):
        for own, (_, origin) in data.seen(frames).items():
            np.testing.assert_array_equal(origin, frames[own][1])
    assert posed.far_words(data.pair) == ""


AT_MESH = replace(builtin_design("awd-transfer"), errors_at="mesh")
ERRORS_AT_MESH = {
    **{"centre_distance": "mm", "in_plane": "rad", "out_of_plane": "rad"},
    **{"pinion_axial": "mm", "gear_axial": "mm"},
}


@pytest.mark.parametrize("number", [0, 1])
def test_paths_under_errors_at_the_mesh(number: int) -> None:
    """Figs. 12 and 13 of a design with errors at the mesh show the corresponding error there."""
    case, error = CASES[number], ("centre_distance", "in_plane")[number]
    found = misaligned(case, AT_MESH)
    size = found.case.size
    for path, sign in zip(found.paths[0], (-1.0, 0.0, 1.0), strict=True):
        errors = from_mesh(AT_MESH, MeshErrors(**{error: sign * size}))
        alone = path_of_contact(AT_MESH.with_errors(errors), "right", 3)
        assert float(path.middle(0)[2]) == pytest.approx(float(alone.pinion_z[1]), abs=1e-6)
    assert "at the mesh" in found.case.name
    plain = misaligned(case, replace(AT_MESH, errors_at="perpendicular")).case
    assert (plain.field, plain.name) == (case.field, case.name)


def test_sensitivities_and_clouds_are_of_the_same_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    data = sensitivity.compute(AT_MESH)
    rates = path_sensitivity(AT_MESH, "left", "mesh")
    np.testing.assert_array_equal(data[0].sensitivities[1].face_shift_by, rates.face_shift_by)
    header, rows = sensitivity.rows(data)
    named = {row[header.index("error")] for row in rows}
    assert named == {"centre distance", "in plane", "out of plane", "pinion axial", "gear axial"}
    header, _ = pattern_errors.rows((pattern_errors.Block("left", AT_MESH, None, "nothing runs"),))
    assert header[4:6] == ("centre_distance_error_mm", "in_plane_error_rad")
    remote = replace(AT_MESH, errors_at="perpendicular")
    assert pattern_errors.rows((pattern_errors.Block("left", remote, None, ""),))[0][4:6] == header[4:6]
    near = builtin_design()
    header, _ = pattern_errors.rows((pattern_errors.Block("left", near, None, ""),))
    assert header[4:6] == ("offset_error_mm", "shaft_angle_error_rad")
    monkeypatch.setattr(tolerance_cloud, "MOUNTINGS", 8)
    case = tolerance_cloud.case_study("left", "as designed", AT_MESH, "black", 1.0)
    assert case.study is not None
    assert case.study.tolerances == USUAL_AT["mesh"]
    path = paths_table.solved_case(AT_MESH, "left")
    header, rows = tolerance_cloud.rows(tolerance_cloud.CloudFigure("left", path, (), (case,)))
    assert header[4:9] == [f"{name}_error_{unit}" for name, unit in ERRORS_AT_MESH.items()]
    assert {len(row) for row in rows} == {len(header)}


def page_words(tmp_path: Path, *options: str) -> str:
    """Return the text of the report of a file with errors at the mesh."""
    source, out = tmp_path / "pair.toml", tmp_path / "page.html"
    text = builtin_text("awd-transfer").partition("[errors]")[0]
    source.write_text(text + '[errors]\nat = "mesh"\nin_plane_deg = 0.005\n', encoding="utf-8")
    result = run(source, "--out", out, "--cases", "30", *options, program=render_report)
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    return " ".join(ReportPage(out.read_text(encoding="utf-8")).words.split())


@pytest.mark.slow
def test_the_page_says_which_errors_are_meant(tmp_path: Path) -> None:
    words = page_words(tmp_path)
    assert "the errors are measured at the mesh" in words
    assert "centre distance 0.1 mm in plane 0.01 deg out of plane 0.01 deg pinion axial" in words
    assert "centre distance 0.05 mm, in plane 0.01 °, out of plane 0.01 °, pinion axial 0.1 mm," in words
    assert "pitch point from the common perpendicular mm 1692.34" in words
    assert "errors at the mesh: shaft angle in plane deg 0.005" in words
    given = page_words(tmp_path, "--offset-tolerance", "0.02")
    assert "offset 0.02 mm, shaft angle 0 °, pinion axial 0 mm, gear axial 0 mm, in both directions" in given


def test_what_holds_for_the_papers_pair_is_not_said_of_others() -> None:
    """The note on the shaft-angle error is printed for Table 1 only."""
    for name, said in (("ni-2017", True), ("awd-transfer", False)):
        assert bool(CASES[1].at(builtin_design(name)).note) is said
