"""The paper's statements: what they are judged by, and how verdicts follow from numbers."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from beveloid_geom.analysis.path_measures import SHIFTS, _at, concavity, paths_of, shifts, sweep
from beveloid_geom.analysis.sensitivity import ERRORS, path_sensitivity
from beveloid_geom.cli.commands.statements import statements as command
from beveloid_geom.contact.path import contact_ratio, path_of_contact
from beveloid_geom.design.file import builtin_design
from beveloid_geom.design.model import Errors
from beveloid_geom.studies.modification_statements import _angle_falls, _shorter_first, _turns_over
from beveloid_geom.studies.statement_verdicts import Claim, Statement, Verdict, claim_of, grows
from beveloid_geom.studies.statements import paper_statements

from ..oracle.table1 import table1
from ..symmetry import mirrored

IDS = ["F6", "C1", "C2", "C3", "C4", "R1", "R2", "R3", "R4", "D1", "M1", "M2", "M3", "M4", "M5", "M6"]
FLANKS = ("right", "left")
MODIFIED = (0.001, -0.001)
YES, NO, DEPENDS = Verdict.HOLDS, Verdict.DOES_NOT_HOLD, Verdict.DEPENDS


@cache
def judged(flank: str) -> dict[str, Statement]:
    return {one.id: one for one in paper_statements(table1(), flank)}


def numbers(one: Statement) -> dict[str, Any]:
    return {f"{c.text}: {name}": row for c in one.claims for name, row in c.numbers.items()}


@pytest.mark.parametrize(
    ("flank", "verdicts"),
    [
        ("right", (YES, *(DEPENDS,) * 3, YES, NO, NO, YES, YES, DEPENDS, YES, YES, YES, DEPENDS, YES, YES)),
        ("left", (YES, *(NO,) * 9, NO, NO, NO, NO, DEPENDS, YES)),
    ],
)
def test_verdicts_on_the_papers_pair(flank: str, verdicts: tuple[Verdict, ...]) -> None:
    assert {name: one.verdict for name, one in judged(flank).items()} == dict(zip(IDS, verdicts, strict=True))
    for one in judged(flank).values():
        assert one.flank == flank
        assert one.why.endswith(".")
        assert all(np.isfinite(row).all() for row in numbers(one).values())


def test_lengths_and_angles_of_a_sweep() -> None:
    """Against paths taken one by one, the length by a finer polygon."""
    found = sweep(table1(), "right", (1, 1), 0.0002)
    for k in (0, 5, 20):
        design = table1((float(found.size[k]),) * 2)
        path = path_of_contact(design, "right", 1001)
        for j, (z, r) in enumerate(((path.pinion_z, path.pinion_r), (path.gear_z, path.gear_r))):
            length = np.hypot(np.diff(z), np.diff(r)).sum()
            assert found.paths.length["side view"][j, k] == pytest.approx(length, rel=1e-4)
            assert found.paths.length["on the tooth"][j, k] > length
            angle = math.degrees(math.atan((r[-1] - r[0]) / (z[-1] - z[0])))
            assert found.paths.angle["chord"][j, k] == pytest.approx(angle, abs=1e-9)
            tangent = math.degrees(math.atan((r[501] - r[499]) / (z[501] - z[499])))
            assert found.paths.angle["middle"][j, k] == pytest.approx(tangent, abs=0.05)
            assert found.paths.location["middle"][j, k] == pytest.approx(z[500], abs=1e-9)
            between = 0.5 * (z[0] + z[-1])
            assert found.paths.location["between ends"][j, k] == pytest.approx(between, abs=1e-9)
        assert found.paths.contact_ratio[k] == pytest.approx(float(path.ends.contact_ratio), abs=1e-12)


def test_the_length_on_the_tooth_of_an_unmodified_path_is_that_of_its_line() -> None:
    """Seen from the turning member, a point that runs along the line of action for s moves by the
    involute's arc: the rolled base radius at right angles, and the rest along the face."""
    design = table1()
    path = path_of_contact(design, "right", 20001)
    length = paths_of(design.with_errors(Errors(offset=np.zeros(1))), "right").length["on the tooth"]
    for j, (z, r, roll) in enumerate(
        ((path.pinion_z, path.pinion_r, path.pinion_roll), (path.gear_z, path.gear_r, path.gear_roll))
    ):
        x, y = (path.point[:, 0], path.point[:, 1]) if j == 0 else _in_gear_frame(path.point)
        turned = np.unwrap(np.arctan2(y, x)) - roll
        arc = np.hypot(np.hypot(np.diff(r), 0.5 * (r[1:] + r[:-1]) * np.diff(turned)), np.diff(z)).sum()
        assert length[j, 0] == pytest.approx(arc, rel=1e-5)


def _in_gear_frame(point: Any) -> tuple[Any, Any]:
    """x and y (n,) in the gear's fixed frame of points (n, 3) in S_f, without errors."""
    angle = math.radians(15.0)
    return 229.0 - point[:, 0], point[:, 2] * math.sin(angle) - point[:, 1] * math.cos(angle)


@pytest.mark.parametrize("flank", FLANKS)
@pytest.mark.parametrize("parabola", [(0.0, 0.0), MODIFIED])
def test_shifts_under_small_errors_are_the_derivatives(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola)
    rates = path_sensitivity(design, flank)
    for k, (error, size) in enumerate(zip(ERRORS, (1e-3, 1e-6, 1e-2, 1e-2), strict=True)):
        found = shifts(design, flank, error, size)
        assert tuple(found) == SHIFTS
        for name, rate in (
            (SHIFTS[0], rates.face_shift_by),
            (SHIFTS[3], rates.square_shift_by),
            (SHIFTS[4], rates.z_by),
        ):
            slope = (found[name][:, 1] - found[name][:, 0]) / (2.0 * size)
            scale = np.abs(rate[1, :, k]).max()
            np.testing.assert_allclose(
                slope, rate[1, :, k], rtol=1e-4, atol=1e-4 * scale, err_msg=f"{error} {name}"
            )


def test_shift_at_equal_radius_and_its_part_square_to_the_path() -> None:
    design, size = table1(MODIFIED), 0.3
    found = shifts(design, "right", "offset", size)
    before = path_of_contact(design, "right", 801)
    after = path_of_contact(design.with_errors(Errors(offset=size)), "right", 801)
    for j, member in enumerate(("pinion", "gear")):
        z, r = getattr(before, f"{member}_z"), getattr(before, f"{member}_r")
        other = getattr(after, f"{member}_r")
        order = np.argsort(other)
        along = np.interp(r[400], other[order], getattr(after, f"{member}_z")[order]) - z[400]
        assert found[SHIFTS[1]][j, 1] == pytest.approx(along, abs=1e-3)
        angle = math.atan2(r[401] - r[399], z[401] - z[399])
        assert found[SHIFTS[2]][j, 1] == pytest.approx(along * abs(math.sin(angle)), rel=1e-3)


@pytest.mark.parametrize("flank", FLANKS)
def test_concavity_follows_the_coefficient(flank: str) -> None:
    """To first order in a, metal is a l^2 off the involute and the curvature 2 a."""
    small, large = (concavity(table1(), flank, size) for size in (1e-5, 1e-4))
    for name, rows in small.items():
        np.testing.assert_allclose(large[name], 10.0 * rows, rtol=2e-2, err_msg=name)
        assert (rows[:, 0] > 0.0).all()
        assert (rows[:, 1] < 0.0).all()
    assert (np.abs(small["curvature of the profile"]) < 2e-5).all()
    assert (np.abs(small["curvature of the profile"]) > 1.4e-5).all()


def test_m4_names_the_known_numbers() -> None:
    row = numbers(judged("right")["M4"])
    along = row["the shift is smaller: pinion, along the face, equal l"]
    assert along == pytest.approx((12.7, 16.5), abs=0.05)
    square = row["the shift is smaller: pinion, square, side view"]
    assert square[1] < square[0]


def test_contact_ratios_are_those_of_eq_16() -> None:
    row = numbers(judged("left")["R3"])["it rises clearly: Eq. 16"]
    assert row[-1] == pytest.approx(float(contact_ratio(table1((0.002, -0.002)), "left")), abs=1e-12)
    free = numbers(judged("right")["R2"])["it rises clearly beyond: Eq. 16 without toe and heel"]
    clipped = numbers(judged("right")["R2"])["it rises clearly beyond: Eq. 16"]
    assert (free >= clipped - 1e-12).all()
    assert free[-1] > clipped[-1]
    assert free[:8] == pytest.approx(clipped[:8], abs=1e-12)


@pytest.mark.parametrize("flank", FLANKS)
def test_mirror_image(flank: str) -> None:
    """The left flanks of the mirrored pair are the right flanks of the pair."""
    other = {"right": "left", "left": "right"}[flank]
    for one in paper_statements(mirrored(table1()), other):
        ours = judged(flank)[one.id]
        assert one.verdict == ours.verdict, one.id
        for name, row in numbers(ours).items():
            np.testing.assert_allclose(
                numbers(one)[name], row, rtol=1e-7, atol=1e-7, err_msg=f"{one.id} {name}"
            )


def test_the_designs_own_modification_and_errors_are_set_aside() -> None:
    design = table1((0.0003, 0.0002), Errors(0.1, 1e-4, 0.2, 0.3))
    for one in paper_statements(design, "right"):
        for name, row in numbers(judged("right")[one.id]).items():
            np.testing.assert_array_equal(numbers(one)[name], row)


def test_another_design_has_other_numbers() -> None:
    design = replace(table1(), pinion=replace(table1().pinion, profile_shift=0.1))
    for one in paper_statements(design, "right"):
        same = [
            np.array_equal(numbers(judged("right")[one.id])[name], row) for name, row in numbers(one).items()
        ]
        assert not all(same) or one.id == "D1", one.id


def test_another_design_has_other_verdicts() -> None:
    """On a narrow face toe and heel end the paths."""
    narrow = replace(table1(), pinion=replace(table1().pinion, face_width=24.0))
    other = {one.id: one for one in paper_statements(narrow, "right")}
    changed = {name for name in IDS if other[name].verdict != judged("right")[name].verdict}
    assert {"C3", "D1", "R3"} <= changed


def test_without_paths_nothing_is_known() -> None:
    design = replace(table1(), pair=replace(table1().pair, pinion_mounting=400.0))
    for one in paper_statements(design, "right"):
        assert one.verdict == (Verdict.HOLDS if one.id == "F6" else Verdict.NOT_KNOWN), one.id
        assert "nan" not in one.why
    with pytest.raises(ValueError, match="single designs"):
        paper_statements(table1(errors=Errors(np.zeros(2))))
    with pytest.raises(ValueError, match="flank must be"):
        paper_statements(table1(), "upper")


def test_verdict_of_claims() -> None:
    def claim(*holds: bool | None) -> Claim:
        return Claim("text", {}, {str(k): value for k, value in enumerate(holds)})

    def verdict(*claims: Claim) -> Verdict:
        return Statement("X", "right", "", "", claims, "").verdict

    assert claim(True, None, True).verdict == YES
    assert claim(False, None).verdict == NO
    assert claim(False, True).verdict == DEPENDS
    assert claim(None, None).verdict == Verdict.NOT_KNOWN
    assert verdict(claim(True), claim(True)) == YES
    assert verdict(claim(True), claim(True, False)) == DEPENDS
    assert verdict(claim(True, False), claim(False)) == NO
    assert verdict(claim(True), claim(None)) == Verdict.NOT_KNOWN


def test_tests_of_rows() -> None:
    assert _turns_over(np.array((-40.0, -70.0, 85.0, 30.0)))
    assert not _turns_over(np.array((-40.0, -20.0, 10.0)))  # through the axial direction
    assert not _turns_over(np.array((-40.0, -70.0, -30.0)))
    assert not _turns_over(np.array((40.0, 60.0, 80.0)))
    assert _angle_falls(np.array((-40.0, -20.0, -10.0)))
    assert not _angle_falls(np.array((-40.0, -20.0, 10.0)))
    assert _shorter_first(np.array((3.0, 2.0, 2.5)))
    assert not _shorter_first(np.array((3.0, 2.0, 1.0)))
    assert not _shorter_first(np.array((3.0, 2.0, 4.0, 3.5)))
    found = claim_of("x", {"a": np.array(((1.0, 2.0), (2.0, np.nan)))}, ("", grows))
    assert found.holds == {"pinion, a": True, "gear, a": None}


def test_values_on_a_curve_are_taken_on_its_monotone_stretch() -> None:
    row = np.array((0.0, 1.0, 2.0, 1.5, 1.0))
    z = np.arange(5.0)
    assert _at(row, z, 1.5, 0) == pytest.approx(1.5)
    assert _at(row, z, 1.5, 3) == pytest.approx(3.0)
    assert math.isnan(_at(row, z, 2.5, 0))
    assert math.isnan(_at(row, z, 0.5, 3))
    assert math.isnan(_at(np.array((np.nan, 1.0, 2.0)), np.arange(3.0), 1.5, 0))


def run(*arguments: str) -> Result:
    return CliRunner().invoke(command, list(arguments))


def test_json_is_the_librarys() -> None:
    result = run("--json")
    assert (result.exit_code, result.stderr) == (0, "")
    data = json.loads(result.stdout)
    assert [one["id"] for one in data] == IDS * 2
    assert [one["flank"] for one in data] == ["right"] * 16 + ["left"] * 16
    for one in data:
        ours = {s.id: s for s in paper_statements_of_builtin(one["flank"])}[one["id"]]
        assert set(one) == {"id", "flank", "statement", "verdict", "measure", "values", "why"}
        assert one["verdict"] == ours.verdict.value
        assert one["why"] == ours.why
        for claim in ours.claims:
            for name, row in claim.numbers.items():
                assert one["values"][claim.text]["numbers"][name] == row.tolist()


@cache
def paper_statements_of_builtin(flank: str) -> tuple[Statement, ...]:
    return paper_statements(builtin_design(), flank)


def test_table_is_readable() -> None:
    result = run("--flank", "left")
    assert result.exit_code == 0
    assert max(len(row) for row in result.stdout.splitlines()) <= 100
    assert "right flanks" not in result.stdout
    heads = [
        row.split(maxsplit=1) for row in result.stdout.splitlines() if row[2:4] in IDS and row[:2] == "  "
    ]
    assert [id_ for id_, _ in heads] == IDS
    for id_, verdict in heads:
        assert verdict == judged("left")[id_].verdict.value


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    result = run(str(tmp_path / "none.toml"))
    assert result.exit_code == 2
    assert "none.toml" in result.stderr


def test_coefficients_of_the_other_sign() -> None:
    """What the paper says of both positive is then measured on both negative."""
    other = {one.id: one for one in paper_statements(table1(), "right", sign=-1)}
    length = "the path gets longer: pinion, on the tooth"
    np.testing.assert_array_equal(numbers(other["C1"])[length], numbers(judged("right")["C2"])[length])
    ratio = "it rises clearly: Eq. 16 without toe and heel"
    mirrored_ratio = numbers(judged("right")["R4"])["it falls clearly: Eq. 16 without toe and heel"]
    np.testing.assert_array_equal(numbers(other["R3"])[ratio], mirrored_ratio)
    assert other["F6"].verdict == Verdict.DOES_NOT_HOLD
    after = float(
        paths_of(table1().with_parabola(np.array((-0.001,)), 0.001), "right").length["side view"][0, 0]
    )
    assert numbers(other["M3"])["it is longer: pinion, side view"][1] == pytest.approx(after, abs=1e-9)
    assert not np.array_equal(
        *(numbers(s)["the shift is smaller: gear, at mid-roll"] for s in m4_of_both(other))
    )


def test_r2_says_what_its_first_claim_rests_on() -> None:
    half = float(contact_ratio(table1((-0.0001, -0.0001)), "right"))
    assert f"by Eq. 16 {half:.4g} at 0.0001 1/mm" in judged("right")["R2"].why


def m4_of_both(other: dict[str, Statement]) -> tuple[Statement, Statement]:
    return judged("right")["M4"], other["M4"]
