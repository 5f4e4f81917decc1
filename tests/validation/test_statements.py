"""The paper's statements: criteria of the claims, and verdicts derived from them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Errors, contact_ratio
from beveloid_geom.analysis.path_measures import measures_of
from beveloid_geom.validation.claims import angle_falls, shorter_first, turns_over
from beveloid_geom.validation.statement_verdicts import Claim, Statement, StatementVerdict
from beveloid_geom.validation.statements import is_table1, paper_statements

from ..oracle.table1 import table1
from ..symmetry import mirrored

IDS = ["F6", "C1", "C2", "C3", "C4", "R1", "R2", "R3", "R4", "D1", "M1", "M2", "M3", "M4", "M5", "M6"]
YES, NO, DEPENDS = StatementVerdict.HOLDS, StatementVerdict.DOES_NOT_HOLD, StatementVerdict.DEPENDS


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
def test_verdicts_on_the_papers_pair(flank: str, verdicts: tuple[StatementVerdict, ...]) -> None:
    assert {name: one.verdict for name, one in judged(flank).items()} == dict(zip(IDS, verdicts, strict=True))
    for one in judged(flank).values():
        assert one.flank == flank
        assert one.why.endswith(".")
        assert all(np.isfinite(row).all() for row in numbers(one).values())


def test_whose_statements_they_are() -> None:
    design = table1()
    assert is_table1(design.with_parabola(0.001, -0.001).with_errors(Errors(offset=0.1)))
    assert not is_table1(replace(design, pair=replace(design.pair, offset=229.1)))


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


def test_another_design_has_other_verdicts() -> None:
    """On a narrow face, where toe and heel end the paths, C3, D1 and R3 have other verdicts."""
    narrow = replace(table1(), pinion=replace(table1().pinion, face_width=24.0))
    other = {one.id: one for one in paper_statements(narrow, "right")}
    changed = {name for name in IDS if other[name].verdict != judged("right")[name].verdict}
    assert {"C3", "D1", "R3"} <= changed


def test_without_paths_nothing_is_known() -> None:
    design = replace(table1(), pair=replace(table1().pair, pinion_mounting=400.0))
    for one in paper_statements(design, "right"):
        assert one.verdict == (StatementVerdict.HOLDS if one.id == "F6" else StatementVerdict.NOT_KNOWN), (
            one.id
        )
        assert "nan" not in one.why
    with pytest.raises(ValueError, match="single designs"):
        paper_statements(table1(errors=Errors(np.zeros(2))))
    with pytest.raises(ValueError, match="flank must be"):
        paper_statements(table1(), "upper")


def test_verdict_of_claims() -> None:
    def claim(*holds: bool | None) -> Claim:
        return Claim("text", {}, {str(k): value for k, value in enumerate(holds)})

    def verdict(*claims: Claim) -> StatementVerdict:
        return Statement("X", "right", "", "", "", claims, "").verdict

    assert claim(True, None, True).verdict == YES
    assert claim(False, None).verdict == NO
    assert claim(False, True).verdict == DEPENDS
    assert claim(None, None).verdict == StatementVerdict.NOT_KNOWN
    assert verdict(claim(True), claim(True)) == YES
    assert verdict(claim(True), claim(True, False)) == DEPENDS
    assert verdict(claim(True, False), claim(False)) == NO
    assert verdict(claim(True), claim(None)) == StatementVerdict.NOT_KNOWN


def test_tests_of_rows() -> None:
    assert turns_over(np.array((-40.0, -70.0, 85.0, 30.0)))
    assert not turns_over(np.array((-40.0, -20.0, 10.0)))  # through the axial direction
    assert not turns_over(np.array((-40.0, -70.0, -30.0)))
    assert not turns_over(np.array((40.0, 60.0, 80.0)))
    assert angle_falls(np.array((-40.0, -20.0, -10.0)))
    assert not angle_falls(np.array((-40.0, -20.0, 10.0)))
    assert shorter_first(np.array((3.0, 2.0, 2.5)))
    assert not shorter_first(np.array((3.0, 2.0, 1.0)))
    assert not shorter_first(np.array((3.0, 2.0, 4.0, 3.5)))


def test_coefficients_of_the_other_sign() -> None:
    """With the sign reversed, a statement on positive coefficients is measured with negative coefficients,
    and has the numbers of the opposite case."""
    other = {one.id: one for one in paper_statements(table1(), "right", sign=-1)}
    length = "the path gets longer: pinion, on the tooth"
    np.testing.assert_array_equal(numbers(other["C1"])[length], numbers(judged("right")["C2"])[length])
    ratio = "it rises clearly: Eq. 16 without toe and heel"
    mirrored_ratio = numbers(judged("right")["R4"])["it falls clearly: Eq. 16 without toe and heel"]
    np.testing.assert_array_equal(numbers(other["R3"])[ratio], mirrored_ratio)
    assert other["F6"].verdict == StatementVerdict.DOES_NOT_HOLD
    after = float(
        measures_of(table1().with_parabola(np.array((-0.001,)), 0.001), "right").length["side view"][0, 0]
    )
    assert numbers(other["M3"])["it is longer: pinion, side view"][1] == pytest.approx(after, abs=1e-9)
    both = (numbers(of["M4"])["the shift is smaller: gear, at mid-roll"] for of in (judged("right"), other))
    assert not np.array_equal(*both)


def test_r2_says_what_its_first_claim_rests_on() -> None:
    half = float(contact_ratio(table1((-0.0001, -0.0001)), "right"))
    assert f"Eq. 16 at 0.0001 1/mm: {half:.4g}" in judged("right")["R2"].why
