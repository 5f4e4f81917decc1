"""Maps of a design in detail: backlash, rounding, mountings given, and what counts as a flank."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom.analysis.maps import Over, _flank_share, map_of
from beveloid_geom.contact.path import path_of_contact
from beveloid_geom.design.model import Design, Errors, Member, Pair, Tool
from beveloid_geom.operation.first_contact import FirstContact, first_contact
from beveloid_geom.report.map import MapReport, cell_words, quadrant_bests, ratio_as_given
from beveloid_geom.status import FirstStatus, Status
from tests.analysis.test_maps import MODIFIED, OFFSET, small_map
from tests.oracle.table1 import table1


def test_sums_of_nothing_are_not_hollow() -> None:
    found = map_of(table1(), "parabola", steps=3, errors=OFFSET)
    pinion = np.linspace(0.0, 0.0007, 8)
    fine = replace(found, pinion=pinion, gear=np.linspace(-0.0007, 0.0, 8), status=np.zeros((8, 8), np.int8))
    assert np.add.outer(fine.pinion, fine.gear)[::-1].diagonal().any()  # rounding
    np.testing.assert_array_equal(fine.hollow[::-1], np.triu(np.ones((8, 8)), 1))


def crossed_helical(pressure_deg: float) -> Design:
    """Cylindrical gears of 30 and 20 deg helix that close without backlash."""
    tool = Tool(6.0, radians(pressure_deg), tip_radius=0.2)
    pinion, gear = (Member(tool, n, radians(beta), 0.0, 0.0, 60.0) for n, beta in ((20, 30), (30, 20)))
    offset = 60.0 / cos(radians(30)) + 90.0 / cos(radians(20))
    return Design(pinion, gear, Pair(offset, radians(50.0)))


@pytest.mark.parametrize("over", ["shift", "mounting"])
def test_backlash_is_followed_past_half_a_pitch(over: Over) -> None:
    """Of crossed helical gears -2 m_n sin(alpha) (x1 + x2), whatever the mounting."""
    found = small_map(crossed_helical(30.0), over, pinion=(-1.2, 1.2), gear=(-1.2, 1.2), steps=5)
    wanted = -6.0 * np.add.outer(found.pinion, found.gear) * (over == "shift")
    np.testing.assert_allclose(found.normal_backlash, wanted, atol=1e-9)
    if over == "shift":
        assert np.abs(wanted).max() > 0.5 * np.pi * 6.0 * cos(radians(30.0))
        np.testing.assert_array_equal(found.interferes[found.solved], (wanted < -1e-9)[found.solved])


def test_backlash_of_a_design_at_half_a_pitch_is_followed_to_either_side() -> None:
    design = crossed_helical(30.0)
    design = replace(design, pinion=replace(design.pinion, profile_shift=1.36))
    found = small_map(design, "shift", pinion=(1.0, 1.7), gear=(-0.3, 0.2), steps=3)
    np.testing.assert_allclose(
        found.normal_backlash, -6.0 * np.add.outer(found.pinion, found.gear), atol=1e-9
    )


def test_a_path_may_be_a_single_point() -> None:
    found = small_map(crossed_helical(25.0), "shift", pinion=(0.2, 1.2), gear=(0.8, 1.8), steps=2)
    assert found.contact_ratio[1, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_change_of_mounting_is_an_axial_error() -> None:
    """Also of a design that fixes its mounting distances elsewhere than at the pitch point."""
    fixed = replace(table1(MODIFIED), pair=replace(table1().pair, pinion_mounting=215.0, gear_mounting=208.0))
    found = small_map(fixed, "mounting", pinion=(-4.0, 4.0), gear=(-3.0, 3.0), steps=2)
    for i, j in np.ndindex(2, 2):
        errors = Errors(pinion_axial=float(found.pinion[i]), gear_axial=float(found.gear[j]))
        path = path_of_contact(fixed.with_errors(errors), "right", 3)
        assert found.contact_ratio[i, j] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
        assert found.centre[i, j] == pytest.approx(float(path.pinion_z[1]), abs=1e-9)


def test_fillets_are_no_flanks(monkeypatch: pytest.MonkeyPatch) -> None:
    def on_fillets(*arguments: Any) -> FirstContact:
        found = first_contact(*arguments)
        return replace(found, on_fillet=np.arange(24).reshape(12, 2) < 6)

    monkeypatch.setattr("beveloid_geom.analysis.maps.first_contact", on_fillets)
    assert _flank_share(table1(), "right") == 0.75


def test_a_first_contact_that_is_not_known_leaves_the_share_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*arguments: Any) -> FirstContact:
        found = first_contact(*arguments)
        found.status[3] = FirstStatus.NOT_CONVERGED
        return found

    monkeypatch.setattr("beveloid_geom.analysis.maps.first_contact", unknown)
    assert np.isnan(_flank_share(table1(), "right"))


def test_each_cell_has_its_own_reason() -> None:
    skewed = replace(table1(), pair=replace(table1().pair, shaft_angle=radians(10.0)))
    assert (map_of(skewed, "parabola", steps=2, errors=OFFSET).status == Status.UNDEFINED).all()
    found = small_map(table1(), "mounting")
    assert (found.status == Status.OFF_FLANK).any()
    lost = int((found.solved & np.isnan(found.shift)).sum())
    assert f"in {lost} an error of the shift carries" in cell_words(found) or lost == 0
    few = replace(found, shift=np.where(found.solved, 1.0, np.nan))
    assert "carries the path off" not in cell_words(few)


def test_of_the_angle_the_table_has_the_magnitude() -> None:
    found = map_of(table1(), "parabola", steps=3, errors=OFFSET)
    one, other = (replace(found, angle=sign * found.angle) for sign in (1.0, -1.0))
    assert MapReport("", one).summary() == MapReport("", other).summary()


def test_a_design_reaches_its_own_ratio() -> None:
    """Solved alone or with others, it differs by rounding."""
    for coefficients in ((0.001, -0.0015), (0.0004, -0.0004), (0.0002, -0.0003)):
        design, (first, second) = table1(coefficients), coefficients
        found = map_of(
            design, "parabola", "left", pinion=(0.0, first), gear=(second, 0.0), steps=2, errors=OFFSET
        )
        assert quadrant_bests(found, ratio_as_given(design, "left"))["C3"][0] == 1


def test_faults_that_a_design_has_anyway_are_not_those_of_the_bounds() -> None:
    tool = replace(table1().pinion.tool, tip_radius=1.3)
    design = replace(table1(), pinion=replace(table1().pinion, tool=tool))
    assert map_of(design, "parabola", steps=2, errors=OFFSET).solved.any()
