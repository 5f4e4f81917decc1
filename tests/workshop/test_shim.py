"""Axial positions for a backlash: recovered mountings, the closed form, and requirements without solution."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Modification,
    Pair,
    builtin_design,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.operation.backlash import backlash_by_errors, mounted_backlash
from beveloid_geom.pair.mounting import mounting_of, unmodified_backlash
from beveloid_geom.status import ShimStatus
from beveloid_geom.workshop.shim import shim
from tests.edge_pairs import edge_pair
from tests.stability.five_residuals import cases_of, mapped
from tests.stability.random_designs import random_designs

TABLE = builtin_design()
HOUSING = Errors(offset=-0.1, shaft_angle=radians(0.002))


def middle(design: Design, flank: str) -> float:
    """Return z on the pinion at mid-roll, from a dense path."""
    path = path_of_contact(design, flank, 2001)
    roll = 0.5 * (path.pinion_roll[0] + path.pinion_roll[-1])
    order = np.argsort(path.pinion_roll)
    return float(np.interp(roll, path.pinion_roll[order], path.pinion_z[order]))


def crowned() -> Design:
    """Return Table 1 with crowned flanks of the pinion and tip relief on the gear."""
    pinion = TABLE.pinion.modified(Modification(helix_crowning_um=8.0, profile_crowning_um=4.0))
    relief = Modification(tip_relief_um=12.0, tip_relief_length_mm=3.0)
    return replace(TABLE, pinion=pinion, gear=TABLE.gear.modified(relief))


@pytest.mark.parametrize("pair", [TABLE, TABLE.with_parabola(0.001, -0.001), crowned()])
def test_a_mounting_is_recovered(pair: Design, flank: str) -> None:
    """Recover a mounting from its backlash and the position of its path."""
    design = pair.with_errors(HOUSING)
    moved = design.with_errors(replace(HOUSING, pinion_axial=3.1, gear_axial=1.7))
    at = middle(moved, flank) / float(design.pinion.face_width) + 0.5
    found = shim(design, float(mounted_backlash(moved).normal), at, flank)
    assert found.status == ShimStatus.REACHED
    np.testing.assert_allclose(found.axial, (3.1, 1.7), atol=1e-3)
    np.testing.assert_allclose(found.distance, mounting_of(design).distance + found.axial)
    assert found.residual < 1e-9
    errors = replace(HOUSING, pinion_axial=float(found.axial[0]), gear_axial=float(found.axial[1]))
    again = design.with_errors(errors)
    assert float(mounted_backlash(again).normal) == pytest.approx(found.wanted_backlash, abs=1e-9)
    assert middle(again, flank) == pytest.approx(found.wanted_z, abs=2e-5)


def test_the_smallest_movement_is_that_of_the_closed_form() -> None:
    """For unmodified flanks j = j0 + a P + b G, and the smallest movement is along (a, b)."""

    def play(pinion: float, gear: float) -> float:
        errors = replace(HOUSING, pinion_axial=pinion, gear_axial=gear)
        return float(unmodified_backlash(TABLE.with_errors(errors)))

    rates = np.array((play(10.0, 0.0) - play(0.0, 0.0), play(0.0, 10.0) - play(0.0, 0.0))) / 10.0
    found = shim(TABLE.with_errors(HOUSING), 0.1)
    np.testing.assert_allclose(found.axial, (0.1 - play(0.0, 0.0)) * rates / (rates @ rates), atol=1e-9)
    assert play(*found.axial.tolist()) == pytest.approx(0.1, abs=1e-9)
    assert np.isnan(found.wanted_z)


@pytest.mark.slow
def test_with_parabolas_no_movement_is_smaller() -> None:
    """The movement is along the gradient of the backlash, by differences and by exact derivatives, so that no
    smaller movement gives this backlash."""
    design = TABLE.with_parabola(0.001, -0.001).with_errors(HOUSING)
    found, step = shim(design, 0.1), 1.0
    pinion, gear = found.axial[:, None] + step * np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    play = mounted_backlash(design.with_errors(replace(HOUSING, pinion_axial=pinion, gear_axial=gear))).normal
    rates = np.array((play[0] - play[1], play[2] - play[3])) / (2.0 * step)
    assert found.axial[0] * rates[1] == pytest.approx(found.axial[1] * rates[0], rel=2e-3)
    pinion, gear = found.axial.tolist()
    by = backlash_by_errors(design.with_errors(replace(HOUSING, pinion_axial=pinion, gear_axial=gear)))[2:]
    assert pinion * by[1] == pytest.approx(gear * by[0], abs=1e-9)
    assert found.backlash == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize(("number", "backlash"), [(0, 0.2633), (1, 0.04146)])
def test_positions_at_which_an_edge_stops_an_edge_are_found(number: int, backlash: float) -> None:
    """Positions are found for a backlash that the contact of two edges limits. Movements of the same length
    in other directions give less backlash."""
    design = edge_pair(number)
    found = shim(design, backlash)
    assert found.status == ShimStatus.REACHED
    assert found.residual < 1e-9

    def missing(distance: float, angle: float) -> float:
        pinion, gear = distance * np.cos(angle), distance * np.sin(angle)
        errors = replace(
            design.errors,
            pinion_axial=float(design.errors.pinion_axial) + pinion,
            gear_axial=float(design.errors.gear_axial) + gear,
        )
        return float(mounted_backlash(replace(design, errors=errors)).normal) - backlash

    moved, own = float(np.hypot(*found.axial)), float(np.arctan2(*found.axial[::-1]))
    assert abs(missing(moved, own)) < 1e-9
    assert missing(moved, own - 0.05) < -1e-6
    assert missing(moved, own + 0.05) < -1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("case", "backlash"), [(5, 0.22980215864881112), (6, -0.004297284324909164)])
def test_a_backlash_of_another_mounting_is_found(case: int, backlash: float) -> None:
    """The derivatives alone lead to wrong positions. Each backlash is that of another mounting within a face
    width."""
    drawn = mapped(lambda value: np.asarray(value).item(), cases_of(random_designs("usual", 60, 11), case))
    found = shim(drawn, backlash)
    assert found.status == ShimStatus.REACHED
    assert found.residual < 1e-9


def test_a_path_is_searched_if_the_start_has_none() -> None:
    """The result is the same as from the design if the start has no first contact."""
    off = TABLE.with_errors(Errors(pinion_axial=48.0))
    assert path_of_contact(off, "right").ends.contact_ratio == 0.0
    found, near = shim(off, 0.12, 0.5), shim(TABLE, 0.12, 0.5)
    assert found.status == ShimStatus.REACHED
    np.testing.assert_allclose(found.axial, near.axial - np.array((48.0, 0.0)), atol=1e-7)
    np.testing.assert_allclose(found.distance, near.distance, atol=1e-7)


def crossed_helical() -> Design:
    """Return a crossed helical pair."""
    first, second = (
        Member(TABLE.pinion.tool, n, radians(b), 0.0, 0.0, 40.0) for n, b in ((29, 20.0), (45, 10.0))
    )
    layout = zero_backlash_layout(Design(first, second, Pair(220.0, radians(30.0))))
    return Design(first, second, Pair(float(layout.offset) + 0.2, float(layout.shaft_angle)))


@pytest.mark.parametrize(
    ("design", "backlash", "at", "status"),
    [
        (crossed_helical(), 0.1, None, ShimStatus.NO_EFFECT),
        (TABLE.with_errors(Errors(offset=3.0)), 0.1, None, ShimStatus.OUT_OF_REACH),
        (TABLE, 5.0, 0.5, ShimStatus.NOT_FOUND),
        (
            TABLE.with_parabola(0.001, -0.001).with_errors(Errors(offset=0.3, shaft_angle=radians(-0.03))),
            0.12,
            0.5,
            ShimStatus.NO_PATH,
        ),
    ],
)
def test_requirements_without_solution_have_a_status(
    design: Design, backlash: float, at: float | None, status: ShimStatus
) -> None:
    found = shim(design, backlash, at)
    assert found.status == status
    if status == ShimStatus.OUT_OF_REACH:
        assert np.abs(found.axial).max() > found.limit == 50.0
    else:
        assert np.isnan([*found.axial, *found.distance, found.backlash, found.residual]).all()
