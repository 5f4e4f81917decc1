"""Grids of a measuring machine: the exact flank at 60 digits, and measured files read back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Member
from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.gear.undercut import undercut_of
from beveloid_geom.report.result import csv_text
from beveloid_geom.report.workshop.grid import GridOrigin, GridReport
from beveloid_geom.validation.five_equations_mp import MP, precise_flank_surface, zero_shift
from beveloid_geom.workshop.grid import MeasuringGrid, measuring_grid
from beveloid_geom.workshop.measured import MeasuredError, deviations_of, read_deviations
from beveloid_geom.workshop.tooth_data import tooth_data
from tests.members import MEMBERS

NAMED = GridOrigin("mine", "pinion", "10 %")
GRID = measuring_grid(MEMBERS["pinion"])


@pytest.mark.parametrize("name", ["pinion", "gear", "spur", "concave", "convex", "cone 20"])
def test_points_are_on_the_exact_flank(name: str) -> None:
    """Points and normals agree with the equations of the paper at 60 digits, which contain the axial shift of
    the paper instead of the profile shift of the library."""
    member = MEMBERS[name]
    grid, moved = measuring_grid(member, 3, 4, 0.05), zero_shift(member)
    for side, flank in enumerate(FLANK_SIGN):
        surface = precise_flank_surface(member, flank)
        for row, column in np.ndindex(grid.shape):
            l, u = (MP.mpf(float(values[side, row, column])) for values in (grid.l, grid.u))
            point, normal = surface(l, u + moved.u, -moved.turn)
            point = np.array([float(value) for value in (*point[:2], point[2] - moved.height)])
            np.testing.assert_allclose(grid.point[side, row, column], point, rtol=0.0, atol=1e-12)
            expected = [float(value) for value in normal]
            np.testing.assert_allclose(grid.normal[side, row, column], expected, rtol=0.0, atol=1e-14)


def test_normals_point_out_of_the_tooth() -> None:
    """Normals of right flanks have a positive y component, those of left flanks a negative one."""
    assert (GRID.normal[0, ..., 1] > 0.0).all()
    assert (GRID.normal[1, ..., 1] < 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(GRID.normal, axis=-1), 1.0, atol=1e-15)


def test_borders_are_shares_or_mm() -> None:
    member = MEMBERS["gear"]
    share, length = measuring_grid(member, 4, 5, 0.1), measuring_grid(member, 4, 5, border_mm=2.0)
    width = float(member.face_width)
    np.testing.assert_allclose(share.point[..., 2] - width * np.linspace(-0.4, 0.4, 5), 0.0, atol=1e-12)
    np.testing.assert_allclose(length.point[..., 2][..., [0, -1]], np.broadcast_to([-28.0, 28.0], (2, 4, 2)))
    for side, flank in enumerate(FLANK_SIGN):
        tip = tip_parameter(member, flank, length.point[side, 0, :, 2])
        np.testing.assert_allclose(length.l[side, 0], root_parameter(member, "right") + 2.0, atol=1e-12)
        np.testing.assert_allclose(length.l[side, -1], tip - 2.0, atol=1e-10)


def test_the_middle_of_the_tooth_is_where_the_grid_says() -> None:
    assert measuring_grid(replace(MEMBERS["pinion"], helix_angle=0.0)).middle == pytest.approx(0.0, abs=1e-15)
    assert measuring_grid(MEMBERS["spur"]).middle == pytest.approx(0.0, abs=1e-15)
    mirrored = measuring_grid(replace(MEMBERS["pinion"], helix_angle=-MEMBERS["pinion"].helix_angle))
    assert GRID.middle == pytest.approx(-mirrored.middle, abs=1e-15)
    assert abs(GRID.middle) > 1e-5


def test_grids_of_undercut_flanks_begin_above_the_fillet() -> None:
    member = Member(MEMBERS["spur"].tool, 10, 0.0, 0.0, 0.0, 30.0)
    grid = measuring_grid(member, border=0.0)
    for number, flank in enumerate(("right", "left")):
        np.testing.assert_allclose(grid.l[number, 0], undercut_of(member, flank, 9).start, atol=1e-12)
    with pytest.raises(ValueError, match="and removed completely"):
        measuring_grid(Member(MEMBERS["spur"].tool, 8, 0.0, radians(20.0), -0.5, 60.0))


def off_flank(grid: MeasuringGrid) -> FloatArray:
    """Return deviations of some um, different at all points."""
    return 0.004 * np.sin(np.arange(grid.l.size)).reshape(grid.l.shape)


def test_deviations_are_along_the_normal() -> None:
    wanted = off_flank(GRID)
    found = deviations_of(GRID, GRID.point + wanted[..., None] * GRID.normal)
    np.testing.assert_allclose(found.deviation, wanted, atol=1e-12)
    assert found.foot_distance.max() < 1e-10


def test_a_laterally_displaced_probe_causes_no_error() -> None:
    """Points of a grid with a border of 10.05 % instead of 10 %, moved along their normals, have exactly
    these deviations."""
    shifted = measuring_grid(MEMBERS["pinion"], 5, 9, 0.1005)
    wanted = off_flank(GRID)
    found = deviations_of(GRID, shifted.point + wanted[..., None] * shifted.normal)
    np.testing.assert_allclose(found.deviation, wanted, atol=1e-11)
    assert found.foot_distance.max() > 1e-2


def test_thickness_and_datum_are_distinguished() -> None:
    """The deviations of a tooth that is thinner and rotated give its thickness and its rotation
    separately."""
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


def rewritten(change: Callable[[str], str], mark: str = ",") -> Callable[[MeasuringGrid], str]:
    """Return the CSV of the grid with changed cells and separator."""

    def text(grid: MeasuringGrid) -> str:
        header, *rows = csv_of(grid).splitlines()
        cells = [[change(cell) for cell in row.split(",")] for row in rows]
        return "\n".join([header.replace(",", mark), *map(mark.join, cells)])

    return text


def xyz(grid: MeasuringGrid) -> list[list[str]]:
    return [[repr(value) for value in point] for point in grid.point.reshape(-1, 3).tolist()]


def unnamed(mark: str, before: str = "") -> Callable[[MeasuringGrid], str]:
    """Return only the points, after the text `before`, with a separator between x, y and z."""
    return lambda grid: before + "\n".join(mark.join(point) for point in xyz(grid))


def with_comma(cell: str) -> str:
    return cell.replace(".", ",")


def with_exponent(cell: str) -> str:
    return f"{float(cell):.16E}".replace("E", "D") if "." in cell else cell


FORMS |= {
    "decimal commas, semicolons": rewritten(with_comma, ";"),
    "decimal commas, tabs": rewritten(with_comma, "\t"),
    "decimal commas, blanks": lambda grid: with_comma(FORMS["bare"](grid)),
    "decimal commas, quoted": rewritten(lambda cell: f'"{with_comma(cell)}"'),
    "quoted": rewritten(lambda cell: f'"{cell}"'),
    "tabs": unnamed("\t"),
    "commas and tabs": unnamed(",\t"),
    "commas and blanks": unnamed(", "),
    "X [mm]": unnamed(" ", "X [mm] Y [mm] Z [mm]\n"),
    "quoted names": unnamed(";", '"X";"Y";"Z"\n'),
    "x in mm": unnamed(",", "x in mm,y / mm,Z (MM)\n"),
    "sep=": unnamed("|", "sep=|\nx_mm|y_mm|z_mm\n"),
    "title": unnamed(",", "Gear 5, tooth 3 of 29: flank X, 20 deg\n\nx,y,z\n"),
    "title, no names": unnamed(" ", "Measured on 2 machines\n"),
    "exponents": rewritten(with_exponent),
    "minus": rewritten(lambda cell: cell.replace("-", "\u2212")),
    "dash": rewritten(lambda cell: cell.replace("-", "\u2013")),
    "numbered": lambda grid: "\n".join(f"{i + 1} {' '.join(p)}" for i, p in enumerate(xyz(grid))),
    "numbered in tens": lambda grid: "\n".join(f"P{10 * i};{';'.join(p)}" for i, p in enumerate(xyz(grid))),
    "numbered, by name": lambda grid: "\n".join(
        ["Point;X;Y;Z", *(f"{i};{';'.join(p)}" for i, p in enumerate(xyz(grid)))]
    ),
}
ENCODINGS = {
    "utf-8": "mm\u00b2",
    "utf-8-sig": "\u6b6f\u8eca",
    "utf-16": "\u6b6f\u8eca",
    "latin-1": "Pr\u00fcfling, 5 \u00b5m",
}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_comments_may_have_any_usual_encoding(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text(f"# {ENCODINGS[encoding]}\n{csv_of(GRID)}", encoding=encoding)
    assert np.array_equal(read_deviations(path, GRID).point, GRID.point)


@pytest.mark.parametrize("form", FORMS)
def test_files_are_read_back(form: str, tmp_path: Path) -> None:
    path, shifted = tmp_path / "m.txt", off_flank(GRID)
    grid = replace(GRID, point=GRID.point + shifted[..., None] * GRID.normal)
    path.write_text(FORMS[form](grid), encoding="utf-8")
    found = read_deviations(path, GRID)
    np.testing.assert_allclose(found.deviation, shifted, atol=2e-9 if form == "table" else 1e-12)


def scaled(points: list[str], factor: float) -> list[str]:
    return [" ".join(str(factor * float(value)) for value in point.split()) for point in points]


EMPTY = "has no point (x, y and z in mm)"
COMMAS = "do the numbers have decimal commas"
LINE = csv_of(GRID).splitlines()  # the header is line 0
POINTS = FORMS["bare"](GRID).splitlines()
BAD = {
    "a hole": (
        [*LINE[:14], *LINE[15:]],
        "line 15 is (right, row 2, column 6), expected (right, row 2, column 5): a point is missing",
    ),
    "an empty cell": ([*LINE[:3], "right,1,3,,2.0,3.0", *LINE[4:]], f"line 4 {EMPTY}: measure each point"),
    "not a number": ([*LINE[:3], "right,1,3,nan,2.0,3.0", *LINE[4:]], "line 4 has no point"),
    "too few": (POINTS[:-1], "has 89 points, must have 90 of both flanks"),
    "too many": ([*POINTS, POINTS[-1]], "has 91 points, must have 90"),
    "another order": (
        [*POINTS[:45:-1], *POINTS[:46]],
        "has the point of right, row 1, column 1 at the position of left, row 5, column 9: write",
    ),
    "two swapped": (
        [POINTS[1], POINTS[0], *POINTS[2:]],
        "has the point of right, row 1, column 1 at the position of right, row 1",
    ),
    "um": (
        scaled(POINTS, 1e3),
        "has coordinates 1000 times those of the grid: give them in mm, they are probably in um",
    ),
    "inches": (scaled(POINTS, 1.0 / 25.4), "give them in mm, they are probably in inches"),
    "um by name": (
        [csv_of(GRID).replace("x_mm", "x_um")],
        "line 1: x_um must be in mm: convert it and name it x_mm",
    ),
    "no z": ([csv_of(GRID).replace("z_mm", "height")], "line 1 has no column z"),
    "another gear": (
        [csv_of(measuring_grid(MEMBERS["gear"]))],
        "mm from its nominal position, the limit is 3 mm: do design, member, grid and datum",
    ),
    "decimal commas between commas": (
        [",".join(with_comma(cell) for cell in point) for point in xyz(GRID)],
        f"line 1 has only whole numbers: {COMMAS}? write decimal points",
    ),
    "the same with names and places": (
        [rewritten(with_comma)(GRID)],
        f"line 2 has only whole numbers: {COMMAS}?",
    ),
    "thousands": ([unnamed(";")(GRID).replace("92.", "1.092,")], f"line 2 {EMPTY}: {COMMAS}"),
    "um in brackets": ([unnamed(",", "x(um),y(um),z(um)\n")(GRID)], "line 1: x_um must be in mm: convert"),
    "a hole in numbered points": (
        [f"{i} {' '.join(p[: 3 - (i == 4)])}" for i, p in enumerate(xyz(GRID))],
        f"line 5 {EMPTY}: measure each point of the grid",
    ),
    "a hole in the first point": (["right,1,1,,2.0,3.0"], f"line 1 {EMPTY}: measure each point"),
    "nothing": ([], "has 0 points, must have 90"),
    "words": (["a b c"], f"line 1 {EMPTY}"),
}
"""Lines of files, and part of the refusal."""


@pytest.mark.parametrize("fault", BAD)
def test_files_that_do_not_fit_are_rejected(fault: str, tmp_path: Path) -> None:
    lines, words = BAD[fault]
    path = tmp_path / "m.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(MeasuredError) as refusal:
        read_deviations(path, GRID)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "data", [b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", b"\xff\xfe1\x00,", "1 2 3".encode("utf-16-le")]
)
def test_a_binary_file_is_no_table(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_bytes(data)
    with pytest.raises(MeasuredError, match=r"is not a text file|is not UTF-16 text"):
        read_deviations(path, GRID)


def test_the_size_of_files_is_limited(tmp_path: Path) -> None:
    """Endless devices and files of millions of lines are read up to the limit only."""
    path = tmp_path / "m.csv"
    path.write_text("91.9 -2.8 -20.0\n" * 100_000, encoding="utf-8")
    for long in (path, Path("/dev/zero")):
        with pytest.raises(MeasuredError, match="is longer than 1,090,000 bytes: give the table of points"):
            read_deviations(long, GRID)
