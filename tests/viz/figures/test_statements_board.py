"""The board of the paper's statements: its verdicts are the command's, its pictures the library's numbers."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.axes import Axes

from beveloid_geom import Errors, builtin_design, contact_ratio, path_of_contact
from beveloid_geom.analysis.path_measures import concavity, in_side_view, shifts
from beveloid_geom.cli.commands.errors.statements import statements as command
from beveloid_geom.studies.claims import AXIAL_ERROR
from beveloid_viz.stage.theme import Page

from ..pages import drawn, texts, words

TABLE = builtin_design()
MODIFIED = TABLE.with_parabola(0.001, -0.001)
MARKS = {
    "holds": "\u2713",
    "depends on the measure": "\u25d0",
    "does not hold": "\u2717",
    "not known": "?",
}
IDS = ["F6", "C1", "C2", "C3", "C4", "R1", "R2", "R3", "R4", "D1", "M1", "M2", "M3", "M4", "M5", "M6"]


@cache
def board() -> tuple[Page, list[dict[str, Any]]]:
    return drawn("statements", MODIFIED.with_errors(Errors(offset=0.1)), (1600, 1200))


def panel(id_: str) -> Axes:
    return board()[0].axes[IDS.index(id_)]


def rows_of(id_: str, **given: object) -> list[dict[str, Any]]:
    found = [row for row in board()[1] if row["statement"] == id_]
    return [row for row in found if all(row[name] == value for name, value in given.items())]


def column(rows: list[dict[str, Any]], name: str) -> Any:
    return np.array([row[name] for row in rows], dtype=float)


def curve(axes: Axes, number: int) -> Any:
    return np.array(axes.lines[number].get_data(), dtype=float)


def test_verdicts_are_those_of_the_command() -> None:
    done = CliRunner().invoke(command, ["ni-2017", "--flank", "right", "--json"])
    assert done.exit_code == 0, done.output
    judged = json.loads(done.stdout)
    assert [one["id"] for one in judged] == IDS
    shown = [text.replace("\u00a0", " ") for text in texts(board()[0])]
    for one in judged:
        at = shown.index(one["id"])
        assert shown[at + 1] == f"{MARKS[one['verdict']]} {one['verdict']}"
        assert {row["verdict"] for row in rows_of(one["id"])} == {one["verdict"]}
        claims = rows_of(one["id"], kind="claim")
        assert [row["claim"] for row in claims] == list(one["values"])
        for row, found in zip(claims, one["values"].values(), strict=True):
            answers = list(found["holds"].values())
            counted = (row["ways_in_which_it_holds"], row["ways_known"])
            assert counted == (answers.count(True), len(answers))
            assert shown[at + 2].count(MARKS[row["claim_verdict"]]) >= 1
            assert ("{} of {}".format(*counted) in shown[at + 2]) == (0 < counted[0] < counted[1])
    assert "9 hold, 5 depend on the measure, 2 do not hold" in words(board()[0])


@pytest.mark.parametrize(
    ("id_", "signs"), [("R1", (1, 1)), ("R2", (-1, -1)), ("R3", (1, -1)), ("R4", (-1, 1))]
)
def test_ratios_are_those_of_eq_16(id_: str, signs: tuple[int, int]) -> None:
    rows = rows_of(id_, kind="Eq. 16")
    a1, a2 = column(rows, "parabola_pinion_per_mm"), column(rows, "parabola_gear_per_mm")
    np.testing.assert_array_equal(a1 * signs[0], a2 * signs[1])
    assert abs(a1[-1]) == (0.0002 if signs[0] == signs[1] else 0.002)
    ratio = contact_ratio(TABLE.with_parabola(a1, a2), "right")
    np.testing.assert_allclose(curve(panel(id_), 0), (a1, ratio), rtol=1e-12)
    np.testing.assert_array_equal(curve(panel(id_), 0)[1], column(rows, "contact_ratio"))


@pytest.mark.parametrize("id_", ["C1", "C2", "C3", "C4", "M1", "M2", "M3"])
def test_paths_are_the_librarys(id_: str) -> None:
    """In the order of the rows, each with the coefficients and errors that stand beside it."""
    paths = [line for line in panel(id_).lines if len(np.asarray(line.get_xdata())) == 201]
    rows = rows_of(id_, kind="path")
    assert len(rows) == 201 * len(paths)
    assert len(paths) == {"C": 5, "M": 2 if id_ == "M3" else 3}[id_[0]]
    for k, line in enumerate(paths):
        own = rows[201 * k : 201 * (k + 1)]
        first = {name: value or 0.0 for name, value in own[0].items()}
        design = TABLE.with_parabola(first["parabola_pinion_per_mm"], first["parabola_gear_per_mm"])
        errors = Errors(first["offset_error_mm"], first["shaft_angle_error_rad"])
        path = path_of_contact(design.with_errors(errors), "right", 201)
        z, r = np.array(line.get_data())
        np.testing.assert_allclose((z, r), (path.pinion_z, path.pinion_r), atol=1e-9)
        np.testing.assert_array_equal((z, r), (column(own, "z_mm"), column(own, "r_mm")))
        if id_ == "M3":
            length = float(in_side_view(path)[0][0])
            assert first["length_mm"] == pytest.approx(length, rel=1e-9)
            assert f"{length:.4g}" in words(board()[0])


def test_the_outline_is_the_flank() -> None:
    for name, low, high in (("root", 90.0, 94.0), ("tip", 100.0, 106.0)):
        rows = rows_of("M1", kind=name)
        z, r = column(rows, "z_mm"), column(rows, "r_mm")
        assert (z[0], z[-1]) == (-25.0, 25.0)
        assert (low < r).all() and (r < high).all()  # noqa: PT018
        assert (np.diff(r) > 0.0).all()


def test_metal_is_that_of_concavity() -> None:
    metal = concavity(TABLE, "right", 0.01)["metal near root and tip"][0]
    rows = rows_of("F6", kind="near root and tip")
    added = column(rows, "added_metal_mm").reshape(2, 2)
    assert (added[0].min(), added[1].max()) == tuple(metal)
    assert column(rows, "parabola_pinion_per_mm").tolist() == [0.01, 0.01, -0.01, -0.01]
    dots = [curve(panel("F6"), number) for number in (1, 3)]
    np.testing.assert_array_equal([r_and_metal[1] for r_and_metal in dots], added)


@pytest.mark.parametrize(
    ("id_", "error", "size"), [("M4", "offset", 0.5), ("M5", "shaft_angle", np.radians(0.015))]
)
def test_quotients_are_those_of_the_shifts(id_: str, error: str, size: float) -> None:
    before, after = (shifts(design, "right", error, float(size)) for design in (TABLE, MODIFIED))
    drawn_at = [float(np.asarray(line.get_xdata())[0]) for line in panel(id_).lines]
    for j, member in enumerate(("pinion", "gear")):
        rows = {row["way"]: row["modified_over_unmodified"] for row in rows_of(id_, kind=member)}
        assert len(rows) == 7
        for way, row in before.items():
            quotient = np.abs(after[way][j]).mean() / np.abs(row[j]).mean()
            assert rows[f"{member}, {way}"] == pytest.approx(float(quotient), rel=1e-12)
        assert set(rows.values()) <= set(drawn_at)


def test_changes_are_those_of_axial_errors() -> None:
    moved = shifts(TABLE, "right", "gear_axial", AXIAL_ERROR)["at mid-roll"][0]
    row = next(row for row in rows_of("M6") if row["way"] == "pinion, at mid-roll, unmodified, gear axial")
    assert row["change_share"] == pytest.approx(float(np.abs(moved).max()) / 50.0, rel=1e-12)
    marks = [float(np.asarray(line.get_xdata())[0]) for line in panel("M6").lines]
    assert 100.0 * row["change_share"] in marks
    assert {r["limit_share"] for r in rows_of("M6") if r["kind"] != "claim"} == {0.02, 0.01}


def test_turns_are_shares_of_the_most() -> None:
    bars = [patch.get_height() for patch in panel("D1").patches]  # type: ignore[attr-defined]
    rows = [row for row in rows_of("D1") if row["kind"] != "claim"]
    assert [row["sweep"] for row in rows] == 2 * ["C1", "C4", "C2", "C3"]
    assert bars == [row["share_of_most"] for row in rows]
    total = column(rows[:4], "turn_deg")
    assert total == pytest.approx((121.4, 108.7, 31.84, 23.68), abs=0.05)
    by = column(rows[4:], "turn_by_coefficient_deg_mm")
    np.testing.assert_allclose(by, total / (0.0002, 0.002, 0.0002, 0.002), rtol=1e-12)
    np.testing.assert_allclose(bars, [*total / total.max(), *by / by.max()], rtol=1e-12)


def test_another_pair_is_named_as_such() -> None:
    assert "Right flanks of the paper's pair" in words(board()[0])
    page, rows = drawn("statements", replace(TABLE, pair=replace(TABLE.pair, offset=0.04)))
    assert "Right flanks of this pair, not the paper's: 1 hold, 15 are not known" in words(page)
    assert {row["verdict"] for row in rows} == {"holds", "not known"}
