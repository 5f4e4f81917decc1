"""First contact of modified teeth, against sampling with formulas of the tests."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    FirstStatus,
    Modification,
    Status,
    first_contact,
    measuring_grid,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.engagement import engagement_of, pitch_point_roll
from beveloid_geom.operation.search.local_clearance import clearance_at, hessian, local_at
from beveloid_geom.workshop.measured import deviations_of
from tests.operation.test_first_contact_by_bisection import BOTH, assert_first
from tests.oracle.table1 import table1
from tests.oracle.tooth import least_turn
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import random_designs


def random_modification(rng: np.random.Generator, design: Design) -> Modification:
    """Return amounts of up to a few per cent of a module, each kind with a chance of one half."""
    module, width = float(design.pinion.tool.normal_module), float(design.pinion.face_width)
    values: dict[str, Any] = {}
    for name in ("helix_slope", "helix_crowning", "profile_slope", "profile_crowning", "twist"):
        if rng.random() < 0.5:
            values[f"{name}_um"] = float(rng.uniform(-2.0, 5.0) * module)
    for name, longest in (("tip", module), ("root", module), ("heel", 0.6 * width), ("toe", 0.6 * width)):
        if rng.random() < 0.5:
            values[f"{name}_relief_um"] = float(rng.uniform(0.0, 8.0) * module)
            values[f"{name}_relief_length_mm"] = float(rng.uniform(0.1, 1.0) * longest)
    return Modification(**values)


def modified(rng: np.random.Generator, design: Design) -> Design:
    """Return a design with random modifications of all four flanks."""
    pinion, gear = (
        member.modified(random_modification(rng, design), "right").modified(
            random_modification(rng, design), "left"
        )
        for member in design.members
    )
    return replace(design, pinion=pinion, gear=gear)


def assert_earliest(design: Design, flank: str, roll: float, count: tuple[int, int] = (33, 25)) -> None:
    """Check that the contact touches and that no point of these teeth touches earlier by 1e-9 mm."""
    first = first_contact(design, flank, roll)
    at, pitch = int(first.pair[0]), [2.0 * np.pi / float(member.teeth) for member in design.members]
    lever = 0.5 * float(design.gear.teeth) * float(design.gear.tool.normal_module)
    rolls = roll + at * pitch[0], float(first.gear_roll[0]) - at * pitch[1]
    least = least_turn(design, flank, rolls, count) * lever
    assert least > -1e-9
    # On edges, the narrowed grid does not reach the corner of the allowed points.
    assert least < 1e-9 or first.limit.max() >= 0


@pytest.mark.parametrize("number", range(3))
def test_table_1_with_random_modifications(number: int, flank: str) -> None:
    rng = np.random.default_rng(number)
    errors = Errors(*(rng.uniform(-1.0, 1.0, 4) * (0.2, radians(0.02), 0.3, 0.3)).tolist())
    design = modified(rng, table1((0.0005 * (number % 2), 0.0), errors))
    roll = pitch_point_roll(design, flank) + 2.0 * np.pi / 29.0 * rng.uniform(0.0, 1.0, 2)
    assert_first(design, flank, roll, (8, 30, 25))
    assert_earliest(design, flank, float(roll[0]))


def test_mesh_cycle_agrees_with_single_first_contacts(flank: str) -> None:
    """The mesh cycle agrees with single first contacts between its samples, also where contacts pass the
    beginning of a relief. Segments end there, so that their polynomials are exact."""
    rng = np.random.default_rng(8)
    cycle = mesh_cycle(modified(rng, table1((0.0, 0.0), Errors(0.05))), flank)
    roll = cycle.start + cycle.pitch * rng.uniform(0.0, 1.0, 9)
    single = first_contact(cycle.design, flank, roll)
    assert np.abs(single.transmission_error - cycle.at(roll).transmission_error).max() < 1e-15
    assert cycle.segments.case.size < 8


def with_scatter(seed: int, amount: float) -> Design:
    """Return Table 1 with measured points that scatter by `amount` (um) on all flanks."""
    rng, members = np.random.default_rng(seed), []
    for member in table1().members:
        grid = measuring_grid(member, 5, 9, 0.1)
        point = grid.point + 1e-3 * rng.normal(0.0, amount, grid.l.shape)[..., None] * grid.normal
        members.append(member.modified(Modification(deviations=deviations_of(grid, point).on_flanks)))
    return replace(table1(), pinion=members[0], gear=members[1])


@pytest.mark.parametrize(("seed", "amount"), [(2, 0.5), pytest.param(0, 3.0, marks=pytest.mark.slow)])
def test_mesh_cycles_of_measured_flanks_with_scatter(seed: int, amount: float) -> None:
    """Mesh cycles of flanks with waves agree with single first contacts. One tooth pair touches at several
    places, and the first of them changes between samples."""
    design = with_scatter(seed, amount)
    cycle = mesh_cycle(design, "right")
    assert cycle.status == FirstStatus.SOLVED
    roll = cycle.start + cycle.pitch * np.random.default_rng(seed).uniform(0.0, 1.0, 12)
    single = first_contact(design, "right", roll)
    assert np.abs(single.transmission_error - cycle.at(roll).transmission_error).max() < 1e-10
    # One place takes over from another one of the same kind: the contact jumps, its clearance does not.
    segments = cycle.segments
    same = (segments.pair[1:] == segments.pair[:-1]) & (segments.limit[:, 1:] == segments.limit[:, :-1]).all(
        0
    )
    ends = [segments.values_at(np.arange(same.size) + k, segments.high[:-1]) for k in (0, 1)]
    assert np.abs(ends[1][2] - ends[0][2])[same].max() > 1.0
    assert np.abs(ends[1][0] - ends[0][0]).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("amount", [0.5, 1.0])
def test_first_contacts_of_measured_flanks_with_scatter(amount: float, flank: str) -> None:
    """First contacts agree with narrowed grids and with formulas of the tests. Only the spline of the
    deviations is shared code."""
    design = with_scatter(1, amount)
    roll = pitch_point_roll(design, flank) + 2.0 * np.pi / 29.0 * np.random.default_rng(3).uniform(0.0, 1.0)
    assert_earliest(design, flank, float(roll), (49, 61))


def test_table_1_with_helix_crowning() -> None:
    """Transmission errors of `operation` on the paper's pair with 5, 10 and 20 um on the pinion. At 13 rolls,
    a search that shares no code gave 0.091, 0.129 and 0.163 arcsec; the extremes between the rolls are a
    little further apart. Shifts along the face for 0.01 deg: -3.82 and +3.88 mm at 10 um."""
    design, second = table1(), np.radians(1.0 / 3600.0)
    for amount, expected in ((5.0, 0.091), (10.0, 0.129), (20.0, 0.163)):
        crowned = replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=amount)))
        cycle = mesh_cycle(crowned, "right")
        assert cycle.edge_share == 0.0
        assert expected < cycle.peak_to_peak / second < 1.05 * expected
        # 0.1 pitches after the roll at which l1 = 0.
        roll = path_of_contact(design, "right", l1=[0.0]).pinion_roll + 0.1 * cycle.pitch
        z = [
            float(first_contact(crowned.with_errors(Errors(shaft_angle=radians(error))), "right", roll).z1[0])
            for error in (0.0, 0.01, -0.01)
        ]
        shifts = {5.0: (-5.35, 5.51), 10.0: (-3.82, 3.88), 20.0: (-2.43, 2.44)}[amount]
        assert np.abs(np.array(z[1:]) - z[0] - shifts).max() < 0.011


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_random_pairs(part: int) -> None:
    """First contacts of random usual pairs with modifications. Pairs are without undercut, because the teeth
    of the tests are not cut at the intersection of flank and fillet."""
    designs, solved = random_designs("usual", 240, seed=31), 0
    for number in range(part, 240, 4):
        rng, flank = np.random.default_rng(number), BOTH[number % 2]
        try:
            design = modified(rng, cases_of(designs, number))
            if any(surface_of(member, flank).crossing for member in design.members):
                continue
            roll = pitch_point_roll(design, flank)
        except ValueError:  # the tool's rounds overlap: no fillet
            continue
        roll = roll + 2.0 * np.pi / float(design.pinion.teeth) * rng.uniform(-0.5, 0.5, 1)
        if first_contact(design, flank, roll).status[0] != FirstStatus.SOLVED:
            continue
        assert_first(design, flank, roll, (8, 30, 25))
        assert_earliest(design, flank, float(roll[0]))
        solved += 1
    assert solved > 25


def test_tangent_flanks_that_face_the_same_way_are_no_contact() -> None:
    """The search for the paths of these pairs meets tangencies with equal normals, as if one tooth were in
    the other. If they counted as contacts, all these paths would be known to lie off the flanks. Rounding,
    which differs between processors, decides about single ones."""
    designs, right, unknown = random_designs("wild", 240, seed=31), (18, 32, 76, 89), 0
    for case in (*right, 50, 56, 60, 71):
        flank = "right" if case in right else "left"
        design = modified(np.random.default_rng(case), cases_of(designs, case))
        unknown += int(path_of_contact(design, flank, 11).ends.status) == Status.NOT_CONVERGED
    assert unknown >= 4


def test_derivatives_of_clearance_and_limits() -> None:
    """Derivatives of clearance and margins equal central differences on flank and fillet, on both sides of
    the beginning of reliefs."""
    rng = np.random.default_rng(4)
    design = modified(rng, table1((0.001, -0.0005), Errors(0.2, radians(0.01), 0.3, -0.4)))
    amounts: dict[str, Any] = {
        **{f"{name}_um": 9.0 for name in ("helix_slope", "helix_crowning", "profile_slope", "twist")},
        **{f"{name}_relief_um": 25.0 for name in ("tip", "root", "heel", "toe")},
        **{f"{name}_relief_length_mm": 4.0 for name in ("tip", "root")},
        **{f"{name}_relief_length_mm": 20.0 for name in ("heel", "toe")},
    }
    kinds = Modification(profile_crowning_um=12.0, **amounts)
    design = replace(design, pinion=design.pinion.modified(kinds), gear=design.gear.modified(kinds))
    for flank in ("right", "left"):
        mesh, _ = engagement_of(design, flank, np.full(1, float(pitch_point_roll(design, flank))))
        places = rng.uniform((-9.0, -24.0), (7.0, 24.0), (200, 2)).T
        task = mesh.task(np.zeros(200, dtype=int), np.zeros(200, dtype=int))
        here, step = local_at(task, *places), 1e-5
        f, slope, _ = clearance_at(task, *places)
        known = np.isfinite(here.f)
        assert known.sum() > 100
        assert np.abs(f - here.f)[known].max() < 1e-13
        assert np.abs(slope - here.slope)[:, known].max() < 1e-13
        for axis in (0, 1):
            shift = step * np.eye(2)[axis][:, None]
            above, below = local_at(task, *(places + shift)), local_at(task, *(places - shift))
            rate = (above.f - below.f) / (2.0 * step) - here.slope[axis]
            bend = (above.slope - below.slope) / (2.0 * step) - hessian(here.bend)[axis]
            margin = (above.margin - below.margin) / (2.0 * step) - here.rate[:, axis]
            curve = (above.rate - below.rate) / (2.0 * step) - hessian(here.curve)[:, axis]
            # Places within a step of the joint or of the beginning of a relief have no second derivative.
            assert np.quantile(np.abs(rate[known]), 0.97) < 1e-7
            assert np.quantile(np.abs(bend[:, known]), 0.97) < 1e-7
            assert np.abs(margin[:, known]).max() < 1e-7
            assert np.abs(curve[..., known]).max() < 1e-7
            meeting = (above.meeting - below.meeting) / (2.0 * step) - here.meeting_rate[:, axis]
            assert np.quantile(np.abs(meeting[:, known]), 0.97) < 1e-7
            # The Taylor series after a small step.
            after = here.after(np.broadcast_to(shift, places.shape))
            assert np.quantile(np.abs(after.f - above.f)[known], 0.97) < 1e-13
            assert np.abs(after.margin - above.margin)[:, known].max() < 1e-12
            assert np.quantile(np.abs(after.meeting - above.meeting)[:, known], 0.97) < 1e-9
