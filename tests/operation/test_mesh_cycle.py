"""Transmission error over mesh cycles: known cases and sums over dense samples."""

from __future__ import annotations

from functools import cache
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    MeshCycle,
    Pair,
    Tool,
    builtin_design,
    contact_ratio,
    first_contact,
    mesh_cycle,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.operation.cycle.cycle_segments import SAMPLES_PER_PITCH
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.status import FirstStatus, Limit
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import Kind, random_designs
from tests.symmetry import scaled


@cache
def cycle_of(parabola: tuple[float, float], flank: str = "right") -> MeshCycle:
    return mesh_cycle(table1(parabola), flank, 12)


@pytest.mark.parametrize("errors", [Errors(), Errors(0.05, radians(-0.003))])
def test_unmodified_ratio_is_that_of_eq_16(flank: str, errors: Errors) -> None:
    design = table1(errors=errors)
    assert abs(operating_ratio(design, flank) - contact_ratio(design, flank)) < 1e-8


def test_unmodified_cycle_has_no_transmission_error() -> None:
    cycle = mesh_cycle(table1(errors=Errors(0.05, radians(-0.003))), "right")
    assert cycle.peak_to_peak < 1e-13
    assert np.abs(cycle.harmonics).max() < 1e-13
    assert cycle.edge_share == 0.0
    assert cycle.hand_over.sum() == 1


def test_rigid_modified_flanks_touch_one_at_a_time() -> None:
    """The contact ratio in operation is 1: each tooth pair is in contact over one pitch of roll."""
    assert operating_ratio(table1((0.0002, 0.0002)), "left") == pytest.approx(1.0, abs=1e-8)


def test_ratio_within_a_thickness() -> None:
    """The contact ratio within a thickness of 3 um equals the counted share of rolls at which a pair has at
    most this clearance."""
    design = table1((0.001, -0.001))
    ratio = float(operating_ratio(design, "right", 0.003))
    # Count the samples of one pair within the thickness.
    pitch = 2.0 * np.pi / 29
    roll = 0.18 + pitch * np.linspace(-2.0, 2.0, 401)
    first, alone = (first_contact(design, "right", roll, pairs=pairs) for pairs in (None, [0]))
    gap = 0.5 * 6.0 * 45 * np.cos(radians(20.0)) * (alone.gear_roll - first.gear_roll)
    assert np.nanmin(gap) > -1e-12
    counted = (gap[:-1] <= 0.003).sum() * 4.0 / 400
    assert ratio == pytest.approx(counted, abs=0.021)
    assert ratio > 2.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parabola", "flank"),
    [((0.001, -0.001), "right"), ((0.0002, 0.0002), "left"), ((-0.0005, -0.0005), "right")],
)
def test_mean_and_harmonics(parabola: tuple[float, float], flank: str) -> None:
    """Mean and harmonics equal dense Gauss quadrature between the changes of the contact."""
    design, cycle = table1(parabola), cycle_of(parabola, flank)
    swing = float(cycle.peak_to_peak)
    ends = float(cycle.start) + np.concatenate(([0.0], cycle.changes - cycle.start, [cycle.pitch]))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    roll = middle[:, None] + half[:, None] * nodes
    curve = first_contact(design, flank, roll.ravel()).transmission_error.reshape(roll.shape)
    mean = ((curve @ weights) * half).sum() / cycle.pitch
    assert abs(mean - float(cycle.mean)) < 1e-10 * swing
    turn = -2j * np.pi * (roll - cycle.start) / cycle.pitch
    waves = [((curve * np.exp(k * turn)) @ weights * half).sum() for k in range(1, 13)]
    assert np.abs(2.0 * np.array(waves) / cycle.pitch - cycle.harmonics).max() < 1e-9 * float(
        cycle.peak_to_peak
    )
    assert 0.99 * swing < np.ptp(curve) <= (1.0 + 1e-9) * swing


def test_changes_are_where_the_contact_changes() -> None:
    """The pair or the edge in contact differs between 1e-8 pitches before and after each change. At a
    hand-over two pairs touch at the same time."""
    design = table1((0.001, -0.001))
    cycle = cycle_of((0.001, -0.001))
    step = 1e-8 * cycle.pitch
    before, after = (first_contact(design, "right", cycle.changes + shift) for shift in (-step, step))
    changed = before.pair != after.pair
    assert np.array_equal(changed, cycle.hand_over)
    assert ((before.limit != after.limit).any(axis=-1) | changed).all()
    hand_over = cycle.changes[cycle.hand_over]
    both = [
        first_contact(design, "right", hand_over, pairs=[pair]).gear_roll
        for pair in (int(before.pair[changed][0]), int(after.pair[changed][0]))
    ]
    assert np.abs(both[0] - both[1]).max() < 1e-11


def test_expected_edges() -> None:
    """Edges touch at the hand-over of (0.001, -0.001), nearly everywhere for (0.0002, 0.0002), and nowhere
    for the convex pair."""
    cycles = {a: cycle_of(a) for a in ((0.001, -0.001), (0.0002, 0.0002), (-0.0005, -0.0005))}
    shares = [float(cycle.edge_share) for cycle in cycles.values()]
    assert 0.1 < shares[0] < 0.3
    assert shares[1] > 0.95
    assert shares[2] == 0.0
    first = first_contact(table1((0.001, -0.001)), "right", cycles[0.001, -0.001].changes - 1e-4)
    assert Limit.GEAR_TIP in first.limit


def random_rolls(start: float, count: int = 1000) -> FloatArray:
    """Draw rolls over five pitches of the pinion of Table 1."""
    return start + 2.0 * np.pi / 29.0 * np.random.default_rng(3).uniform(-2.0, 3.0, count)


@pytest.mark.slow
@pytest.mark.parametrize("errors", [Errors(), Errors(0.03, 1e-4, 0.1, -0.05)])
def test_first_contacts_at_any_roll(flank: str, errors: Errors) -> None:
    """Transmission error, gear roll, contact and points of both members equal those of searches at 1,000
    rolls."""
    design = table1((0.001, -0.001), errors)
    cycle = mesh_cycle(design, flank)
    roll = random_rolls(float(cycle.start))
    found, wanted = cycle.at(roll.reshape(2, 50, 10)), first_contact(design, flank, roll)
    assert found.gear_roll.shape == (2, 50, 10)
    assert found.point.shape == (2, 50, 10, 3)
    found = found.shaped(roll.size)
    for name, bound in {"transmission_error": 1e-14, "gear_roll": 1e-14, "l1": 1e-9, "z2": 1e-9}.items():
        assert np.abs(getattr(found, name) - getattr(wanted, name)).max() < bound, name
    assert np.abs(found.point - wanted.point).max() < 1e-9
    for name in ("pair", "limit", "on_fillet", "status"):
        assert np.array_equal(getattr(found, name), getattr(wanted, name)), name
    assert np.abs(cycle.gear_roll(roll) - wanted.gear_roll).max() < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["usual", "fitted"])
def test_random_pairs_at_any_roll(kind: Kind) -> None:
    """For 15 random designs of each kind, the cycle is known if every roll has a first contact, and it agrees
    with these."""
    rng, solved, designs = np.random.default_rng(21), 0, random_designs(kind, 15, 21)
    for k in range(15):
        design: Design = cases_of(designs, k)
        flank = str(rng.choice(["right", "left"]))
        try:
            cycle = mesh_cycle(design, flank)
        except ValueError:  # the tool's rounds overlap: there is no fillet
            continue
        roll = float(cycle.start) + cycle.pitch * rng.uniform(-1.0, 2.0, 67)
        wanted = first_contact(design, flank, roll)
        if cycle.lost:
            assert cycle.status in wanted.status or cycle.status == FirstStatus.MEETS_BOTTOM
            continue
        solved += 1
        assert np.abs(cycle.at(roll).gear_roll - wanted.gear_roll).max() < 1e-10
    assert solved >= 4


def test_segment_between_two_samples() -> None:
    """A segment between two samples is found: flanks are in contact over 0.4 % of the cycle, at a hand-over
    from edge to edge."""
    cycle = cycle_of((0.0002, 0.0002))
    flanks = cycle.segments.limit[0] < 0
    assert flanks.sum() == 1
    assert (cycle.segments.high - cycle.segments.low)[flanks][0] == pytest.approx(
        0.004017 * cycle.pitch, rel=1e-3
    )
    assert cycle.pitch / SAMPLES_PER_PITCH > 0.004017 * cycle.pitch
    middle = 0.5 * (cycle.segments.low + cycle.segments.high)
    wanted = first_contact(table1((0.0002, 0.0002)), "right", middle)
    assert np.array_equal(cycle.segments.limit.T, wanted.limit)


def test_positions_of_a_lost_cycle_are_named() -> None:
    design = table1((0.001, -0.001), Errors(offset=-5.0))
    cycle = mesh_cycle(design, "right")
    roll = random_rolls(float(cycle.start), 5)
    assert cycle.status == FirstStatus.MEETS_BOTTOM
    assert np.array_equal(cycle.at(roll).status, first_contact(design, "right", roll).status)


def test_refusals() -> None:
    for roll, text in ((np.nan, "finite"), (["a"], "must be a number")):
        with pytest.raises(ValueError, match=text):
            cycle_of((0.001, -0.001)).at(roll)
    with pytest.raises(ValueError, match="begins with"):
        mesh_cycle(table1(errors=Errors(offset=np.zeros(2))), "right").at(np.zeros(3))


def test_missed_contact_is_found_by_denser_samples() -> None:
    """With the usual number of samples, the segments of this pair do not meet; with more samples, the cycle
    agrees with single first contacts."""
    design = cases_of(random_designs("usual", 210, seed=1313), 159)
    cycle = mesh_cycle(design)
    assert cycle.status == FirstStatus.SOLVED
    roll = cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 9)
    np.testing.assert_allclose(
        cycle.gear_roll(roll), first_contact(design, "right", roll).gear_roll, atol=1e-10
    )


def assert_first(design: Design) -> None:
    cycle = mesh_cycle(design)
    about = cycle.segments.high[:-1, None] + cycle.pitch * np.array((-1e-2, -1e-3, 0.0, 1e-3, 1e-2))
    roll = np.append(about, cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 65))
    behind = cycle.at(roll).gear_roll - first_contact(design, "right", roll).gear_roll
    assert np.abs(behind).max() < 1e-12


def test_later_contacts_at_samples_are_followed() -> None:
    """Flanks that touch between two edge contacts for less than the distance of two samples are found,
    although they are not the first contact at any sample."""
    design = builtin_design("marine-gearbox").with_parabola(6.78106451408372e-05, 0.0003270561767875328)
    assert_first(design.with_errors(Errors(offset=-0.1471690267892778, gear_axial=0.042074846841796174)))


@pytest.mark.parametrize("case", [1, 2])
def test_contacts_leave_a_limit_between_samples(case: int) -> None:
    """Changes between samples are found: an edge contact becomes a tangency, or the contact of a corner
    becomes one of an edge and then of another edge."""
    assert_first(cases_of(random_designs("touching", 10, seed=5), case))


def test_a_pair_that_is_first_only_between_samples() -> None:
    """An edge of another tooth pair that is ahead over 2 % of the cycle, by 4 nm, and at no sample, is
    found."""
    members = [
        Member(Tool(3.0, radians(20.0), parabola=parabola), teeth, radians(helix), radians(cone), shift, face)
        for parabola, teeth, helix, cone, shift, face in (
            (8.244026113414195e-06, 37, 8.724858235801605, 2.6152657228762215, 0.3, 40.00703093745587),
            (1.973326417234675e-06, 66, 0.1621362444708764, 2.8002058986589624, 0.2, 21.634091419095654),
        )
    ]
    errors = Errors(0.21065302203343203, radians(0.01854868947225452), 0.25109913138472006, 0.0)
    layout = Pair(136.86265079142373, radians(10.292554196013343))
    design = Design(members[0], members[1], layout, errors)
    cycle = mesh_cycle(design, "right")
    roll = float(cycle.start) + cycle.pitch * np.linspace(0.38, 0.41, 31)
    first, found = first_contact(design, "right", roll), cycle.at(roll)
    assert (first.pair == -1).sum() > 10
    np.testing.assert_allclose(found.gear_roll, first.gear_roll, atol=1e-11)


def test_long_segments_are_divided_until_their_polynomials_converge() -> None:
    """An edge contact that lasts over two thirds of a pitch is divided into several polynomials. A single
    polynomial has an error of 5e-7 mm."""
    cycle = mesh_cycle(builtin_design("marine-gearbox").with_parabola(0.002, 0.002))
    roll = cycle.start + cycle.pitch * np.array((0.2, 0.3, 0.55, 0.6))
    single, places = first_contact(cycle.design, "right", roll), cycle.at(roll)
    for name in ("l1", "z1", "l2", "z2"):
        assert np.abs(getattr(single, name) - getattr(places, name)).max() < 1e-9, name


def test_start_of_the_cycle_does_not_depend_on_rounding(flank: str) -> None:
    """Similar pairs on intersecting axes have equal starts of the cycle, although rounding determines the
    sign of x of their pitch points."""
    design = builtin_design("marine-gearbox").with_errors(Errors(offset=0.1))
    starts = [float(pitch_point_roll(scaled(design, factor), flank)) for factor in (1.0, 3.0, 7.0)]
    assert starts == pytest.approx([starts[0]] * 3, abs=1e-12)
