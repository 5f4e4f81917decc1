"""Grids of a measuring machine: the exact flank at 60 digits, and measured files read back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Member
from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.gear.flank import root_parameter, tip_parameter
from beveloid_geom.reference.five_equations_mp import MP, flank_surface, zero_shift
from beveloid_geom.report.result import csv_text
from beveloid_geom.report.workshop.grid import GridReport, Named
from beveloid_geom.workshop.grid import MeasuringGrid, measuring_grid
from beveloid_geom.workshop.measured import MeasuredError, deviations_of, read_deviations
from beveloid_geom.workshop.tooth_data import tooth_data
from tests.members import MEMBERS

NAMED = Named("mine", "pinion", "10 %")
GRID = measuring_grid(MEMBERS["pinion"])


@pytest.mark.parametrize("name", ["pinion", "gear", "spur", "concave", "convex", "cone 20"])
def test_points_are_on_the_exact_flank(name: str) -> None:
    """The paper's own equations at 60 digits, without this library's profile shift."""
    member = MEMBERS[name]
    grid, moved = measuring_grid(member, 3, 4, 0.05), zero_shift(member)
    for side, flank in enumerate(FLANK_SIGN):
        surface = flank_surface(member, flank)
        for row, column in np.ndindex(grid.shape):
            l, u = (MP.mpf(float(values[side, row, column])) for values in (grid.l, grid.u))
            point, normal = surface(l, u + moved.u, -moved.turn)
            point = np.array([float(value) for value in (*point[:2], point[2] - moved.height)])
            np.testing.assert_allclose(grid.point[side, row, column], point, rtol=0.0, atol=1e-12)
            np.testing.assert_allclose(
                grid.normal[side, row, column], [float(value) for value in normal], rtol=0.0, atol=1e-14
            )


def test_normals_leave_the_tooth() -> None:
    """Of the right flank from x to y, of the left one back, and both away from the axis."""
    assert (GRID.normal[0, ..., 1] > 0.0).all()
    assert (GRID.normal[1, ..., 1] < 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(GRID.normal, axis=-1), 1.0, atol=1e-15)


def test_borders_are_shares_or_mm() -> None:
    member = MEMBERS["gear"]
    share, length = measuring_grid(member, 4, 5, 0.1), measuring_grid(member, 4, 5, border_mm=2.0)
    width = float(member.face_width)
    np.testing.assert_allclose(
        share.point[..., 2], width * np.broadcast_to([-0.4, -0.2, 0, 0.2, 0.4], (2, 4, 5)), atol=1e-12
    )
    np.testing.assert_allclose(length.point[..., 2][..., [0, -1]], np.broadcast_to([-28.0, 28.0], (2, 4, 2)))
    for side, flank in enumerate(FLANK_SIGN):
        tip = tip_parameter(member, flank, length.point[side, 0, :, 2])
        np.testing.assert_allclose(length.l[side, 0], root_parameter(member) + 2.0, atol=1e-12)
        np.testing.assert_allclose(length.l[side, -1], tip - 2.0, atol=1e-10)


def test_the_middle_of_the_tooth_is_where_the_grid_says() -> None:
    assert measuring_grid(replace(MEMBERS["pinion"], helix_angle=0.0)).middle == pytest.approx(0.0, abs=1e-15)
    assert measuring_grid(MEMBERS["spur"]).middle == pytest.approx(0.0, abs=1e-15)
    mirrored = measuring_grid(replace(MEMBERS["pinion"], helix_angle=-MEMBERS["pinion"].helix_angle))
    assert GRID.middle == pytest.approx(-mirrored.middle, abs=1e-15)
    assert abs(GRID.middle) > 1e-5


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"rows": 1}, "rows must be between 2 and 999, got 1"),
        ({"columns": 1000}, "columns must be between 2 and 999, got 1000"),
        ({"border": 0.5}, "border must be at least 0 and below 50 %, got 50 %"),
        ({"border": -0.1}, "border must be at least 0"),
        ({"border_mm": 25.0}, "below 25 mm, half of the face's 50 mm, got 25 mm"),
        ({"border_mm": 7.0}, "half of the flank's"),
        ({"border_mm": float("nan")}, "border must be"),
    ],
)
def test_grids_that_cannot_be_are_refused(given: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        measuring_grid(MEMBERS["pinion"], **given)  # type: ignore[arg-type]


def test_undercut_flanks_have_no_grid() -> None:
    with pytest.raises(ValueError, match="undercut"):
        measuring_grid(Member(MEMBERS["spur"].tool, 10, 0.0, 0.0, 0.0, 30.0))


def off_flank(grid: MeasuringGrid) -> FloatArray:
    """Deviations of some um, different at all points."""
    return 0.004 * np.sin(np.arange(grid.l.size)).reshape(grid.l.shape)


def test_deviations_are_along_the_normal() -> None:
    wanted = off_flank(GRID)
    found = deviations_of(GRID, GRID.point + wanted[..., None] * GRID.normal)
    np.testing.assert_allclose(found.deviation, wanted, atol=1e-12)
    assert found.beside.max() < 1e-10


def test_a_probe_beside_its_place_measures_the_flank_there() -> None:
    """Points of a finer grid, off the flank along their own normals."""
    fine = measuring_grid(MEMBERS["pinion"], 5, 9, 0.1005)
    wanted = off_flank(GRID)
    found = deviations_of(GRID, fine.point + wanted[..., None] * fine.normal)
    np.testing.assert_allclose(found.deviation, wanted, atol=1e-11)
    assert found.beside.max() > 1e-2


def test_another_thickness_and_another_datum_are_told_apart() -> None:
    """A tooth that is thinner and turned: its flanks turned, as those of allowances are."""
    member, thinner, turn = MEMBERS["gear"], -0.03, 2e-5
    grid = measuring_grid(replace(member, tool=replace(member.tool, parabola=0.0)))
    own = thinner / (float(member.tool.normal_module) * float(member.teeth))
    points = grid.point.copy()
    for side, sign in enumerate(FLANK_SIGN.values()):
        cos, sin = np.cos(turn + sign * own), np.sin(turn + sign * own)
        points[side, ..., :2] = grid.point[side, ..., :2] @ np.array([[cos, sin], [-sin, cos]])
    found = deviations_of(grid, points)
    assert found.thickness == pytest.approx(thinner, abs=1e-12)
    assert found.turn == pytest.approx(turn, abs=1e-13)
    changed = tooth_data(grid.member, (0.0, thinner)).normal_thickness
    assert np.diff(changed[:, 1])[0] == pytest.approx(found.thickness, rel=1e-3)
    assert [one.rest for one in found.second_order] == pytest.approx([0.0, 0.0], abs=1e-12)


def csv_of(grid: MeasuringGrid) -> str:
    return csv_text(GridReport(NAMED, grid).rows())


FORMS: dict[str, Callable[[MeasuringGrid], str]] = {
    "csv": csv_of,
    "semicolons": lambda grid: csv_of(grid).replace(",", ";"),
    "table": lambda grid: GridReport(NAMED, grid).summary(),
    "bare": lambda grid: "\n".join(" ".join(map(repr, p)) for p in grid.point.reshape(-1, 3).tolist()),
    "mark": lambda grid: "\ufeff" + csv_of(grid),
}


@pytest.mark.parametrize("form", FORMS)
def test_files_are_read_back(form: str, tmp_path: Path) -> None:
    path, shifted = tmp_path / "m.txt", off_flank(GRID)
    grid = replace(GRID, point=GRID.point + shifted[..., None] * GRID.normal)
    path.write_text(FORMS[form](grid), encoding="utf-8")
    found = read_deviations(path, GRID)
    np.testing.assert_allclose(found.deviation, shifted, atol=2e-9 if form == "table" else 1e-12)


def lines(change: Callable[[list[str]], list[str]]) -> str:
    """The CSV of the grid with its lines changed, the header at 0."""
    return "\n".join(change(csv_of(GRID).splitlines()))


def without_names(change: Callable[[list[str]], list[str]]) -> str:
    """Points alone, changed."""
    return "\n".join(change(FORMS["bare"](GRID).splitlines()))


BAD = {
    "a hole": (
        lines(lambda own: own[:14] + own[15:]),
        "line 15 is right, row 2, column 6 where right, row 2, column 5 is due: a point is missing",
    ),
    "an empty cell": (
        lines(lambda own: [*own[:3], "right,1,3,,2.0,3.0", *own[4:]]),
        "line 4 has no place, x, y and z in mm: a hole in the grid",
    ),
    "not a number": (lines(lambda own: [*own[:3], "right,1,3,nan,2.0,3.0", *own[4:]]), "line 4 has no place"),
    "too few": (without_names(lambda own: own[:-1]), "has 89 points in place of 90 of both flanks"),
    "too many": (without_names(lambda own: [*own, own[-1]]), "has 91 points in place of 90"),
    "another order": (
        without_names(lambda own: [*own[:45:-1], *own[:46]]),
        "has the point of right, row 1, column 1 at left, row 5, column 9: take the points in the grid's",
    ),
    "two swapped": (
        without_names(lambda own: [own[1], own[0], *own[2:]]),
        "has the point of right, row 1, column 1 at right, row 1, column 2",
    ),
    "um": (
        without_names(lambda own: [" ".join(str(1e3 * float(v)) for v in one.split()) for one in own]),
        "has coordinates 1000 times those of the grid: were they given in um? mm are read",
    ),
    "inches": (
        without_names(lambda own: [" ".join(str(float(v) / 25.4) for v in one.split()) for one in own]),
        "were they given in inches",
    ),
    "um by name": (csv_of(GRID).replace("x_mm", "x_um"), "line 1: x_um must be in mm, as x_mm: convert it"),
    "no z": (csv_of(GRID).replace("z_mm", "height"), "line 1 names no column z"),
    "another gear": (
        csv_of(measuring_grid(MEMBERS["gear"])),
        "mm away from its place: is it this design, member, grid and datum",
    ),
    "nothing": ("", "has 0 points in place of 90"),
    "words": ("a b c\n", "line 1 has no place, x, y and z"),
}


@pytest.mark.parametrize("fault", BAD)
def test_files_that_do_not_fit_are_refused(fault: str, tmp_path: Path) -> None:
    text, words = BAD[fault]
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MeasuredError) as refusal:
        read_deviations(path, GRID)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_binary_file_is_no_table(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(MeasuredError, match="is no text"):
        read_deviations(path, GRID)
