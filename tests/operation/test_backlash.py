"""Backlash of mounted and modified pairs: sampled rolls, closed forms, symmetry and differences."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Modification,
    Pair,
    Tolerances,
    Tool,
    builtin_design,
    first_contact,
    mounted_backlash,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.analysis.tolerance import drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.operation.backlash import JAM_OVERLAP_MODULES, backlash_by_errors, play_at
from beveloid_geom.operation.backlash_by_tangency import Tangency, tangent_backlash
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.pair.misalignment import ERROR_NAMES, mounted
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import FirstStatus
from tests.edge_pairs import edge_pair
from tests.oracle.table1 import table1
from tests.symmetry import exchanged, mirrored, scaled

WIDE = Tolerances(0.5, radians(0.1), 1.0, 1.0)
NO_PARABOLA = (0.0, 0.0)


def sampled_least(design: Design) -> float:
    """Return the minimum play (mm) of evenly spaced rolls, refined around the minimum."""
    pitch = 2.0 * pi / 29.0
    roll = float(pitch_point_roll(design, "right")) + pitch * (np.arange(200) + 0.4) / 200
    least = roll[sampled(design, roll).argmin()]
    return float(sampled(design, least + pitch * np.linspace(-1.0, 1.0, 61) / 200).min())


def sampled(design: Design, roll: FloatArray) -> FloatArray:
    """Return the play (mm) from the gear rolls, within half a pitch."""
    right, left = (first_contact(design, flank, roll).gear_roll for flank in ("right", "left"))
    pitch = 2.0 * pi / 45.0
    turn = np.remainder(right - left + 0.5 * pitch, pitch) - 0.5 * pitch
    return np.asarray(turn * 0.5 * 6.0 * 45.0 * np.cos(radians(20.0)))


def test_table_1_is_jammed_by_half_a_millimetre() -> None:
    """An offset error of -0.5 mm jams Table 1. The backlash is zero between offset errors of -0.058 and
    -0.060 mm."""
    found = mounted_backlash(table1(errors=Errors(offset=-0.5)))
    assert float(found.normal) == pytest.approx(-0.3130, abs=5e-5)
    assert found.jammed
    assert mounting_of(table1()).normal_backlash == pytest.approx(0.0416, abs=5e-5)
    for offset, jammed in ((0.0, False), (-0.058, False), (-0.060, True)):
        assert bool(mounted_backlash(table1(errors=Errors(offset=offset))).jammed) is jammed


def test_without_errors_it_is_that_of_the_layout() -> None:
    found, own = mounted_backlash(table1()), float(mounting_of(table1()).normal_backlash)
    assert float(found.normal) == pytest.approx(own, abs=6.0 * 3e-14)


@pytest.mark.slow
@pytest.mark.parametrize("errors", [Errors(), Errors(-0.3, radians(0.02), 0.3, -0.4)])
@pytest.mark.parametrize(
    "parabola", [NO_PARABOLA, (0.001, -0.001), (-0.0005, -0.0005), (0.0002, 0.0002), (-0.002, 0.001)]
)
def test_minimum_over_the_cycle(parabola: tuple[float, float], errors: Errors) -> None:
    design = table1(parabola, errors)
    found, least = mounted_backlash(design), sampled_least(design)
    assert found.status == FirstStatus.SOLVED
    assert -1e-9 < least - float(found.normal) < 3e-6
    at, _ = play_at(design, np.array([found.pinion_roll]))
    assert at[0] == pytest.approx(float(found.normal), abs=1e-11)
    own = first_contact(design, "right", at_roll(found.pinion_roll)).gear_roll
    assert found.right.gear_roll == pytest.approx(own, abs=1e-14)


def at_roll(roll: FloatArray) -> FloatArray:
    return np.array([float(roll)])


@pytest.mark.parametrize(
    ("flank", "amount", "change"), [("right", 30.0, -0.015), ("left", -16.0, -0.008), (None, 20.0, -0.02)]
)
def test_helix_slope_of_straight_teeth_takes_half_of_it(
    flank: str | None, amount: float, change: float
) -> None:
    """A helix slope C reduces the backlash by C / 2 on parallel axes, because the tooth is thicker by C / 2
    at one end of the flank. With slopes on both flanks the reductions add up."""
    tool = Tool(normal_module=3.0, normal_pressure_angle=radians(20.0))
    pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, 30.0) for teeth in (25, 40))
    plain = Design(pinion, gear, Pair(97.6, 0.0))
    sloped = replace(plain, pinion=pinion.modified(Modification(helix_slope_um=amount), flank))
    before, after = (float(mounted_backlash(each).normal) for each in (plain, sloped))
    assert after - before == pytest.approx(change, abs=1e-8)


def test_play_above_half_a_pitch() -> None:
    """A play that is larger than half a normal base pitch, 8.86 mm, is computed correctly and increases
    continuously with the offset error."""
    roll = at_roll(pitch_point_roll(table1(errors=Errors(offset=12.0)), "right"))
    (near, far), status = zip(
        *(play_at(table1(errors=Errors(offset=e)), roll) for e in (11.9, 12.0)), strict=True
    )
    assert (np.array(status) == FirstStatus.SOLVED).all()
    assert near[0] > 8.86
    assert 0.0 < far[0] - near[0] < 0.2


def test_mirrored_exchanged_and_scaled() -> None:
    design = table1((-0.0004, 0.0001), Errors(-0.1, radians(0.01), 0.2, -0.3))
    own = float(mounted_backlash(design).normal)
    assert float(mounted_backlash(mirrored(design)).normal) == pytest.approx(own, abs=1e-8)
    assert float(mounted_backlash(exchanged(design)).normal) == pytest.approx(own, abs=6e-6)
    assert float(mounted_backlash(scaled(design, 0.1)).normal) == pytest.approx(0.1 * own, abs=1e-7)


def test_status_of_unknown_backlash() -> None:
    few = table1()
    steep = replace(few.pinion, teeth=8, cone_angle=radians(20.0), profile_shift=-0.5, face_width=60.0)
    mounted = replace(few.pair, pinion_mounting=211.6, gear_mounting=210.2)
    undercut = replace(few, pinion=steep, pair=mounted)
    found = mounted_backlash(undercut)
    assert found.status == FirstStatus.UNDERCUT
    assert np.isnan(found.normal)
    assert not found.jammed
    assert mounted_backlash(mirrored(undercut)).status == FirstStatus.UNDERCUT  # on the left flanks
    deep = mounted_backlash(table1(errors=Errors(offset=-2.5)))
    assert deep.status == FirstStatus.MEETS_BOTTOM
    assert np.isnan(deep.normal)
    assert deep.jammed


@pytest.mark.parametrize("degrees", [1e-2, 3e-3])
def test_edges_alone_stop_flanks_that_share_no_normal(degrees: float) -> None:
    """If only edges touch, on nearly parallel axes, the backlash is close to that of parallel axes at the
    distance that the axes have at the mesh."""
    tool = Tool(3.0, radians(20.0))
    pinion = Member(tool, 25, radians(15.0), radians(3.0), 0.0, 28.0)
    gear = Member(tool, 31, radians(-15.0), radians(-3.0), 0.0, 28.0)
    design = Design(pinion, gear, Pair(87.3, radians(degrees)))
    apart = float(mounting_of(design).distance[0]) * np.sin(radians(degrees))
    parallel = mounted_backlash(replace(design, pair=Pair(float(np.hypot(87.3, apart)), 0.0)))
    found = mounted_backlash(design)
    assert found.status == FirstStatus.SOLVED
    assert 0.4 * degrees < float(parallel.normal - found.normal) < 0.6 * degrees


def test_a_layout_without_backlash_is_not_jammed() -> None:
    """Rounding of the layout to the digits printed by `check` does not jam the pair."""
    layout = zero_backlash_layout(table1())
    offset, turn = round(float(layout.offset), 4), round(float(np.degrees(layout.shaft_angle)), 4)
    pair = Pair(offset, radians(turn), *(round(float(each), 3) for each in layout.mounting))
    design = replace(table1(), pair=pair)
    assert abs(float(mounted_backlash(design).normal)) < JAM_OVERLAP_MODULES * 6.0
    assert not mounted_backlash(design).jammed


@pytest.mark.slow
@pytest.mark.parametrize("errors", [Errors(), Errors(-0.2, radians(0.02), 0.3, -0.4)])
@pytest.mark.parametrize("parabola", [NO_PARABOLA, (0.001, -0.001), (-0.0005, -0.0005), (0.0002, -0.0001)])
def test_derivatives_are_those_of_differences(parabola: tuple[float, float], errors: Errors) -> None:
    """Derivatives agree with central differences of the play at the fixed roll of the minimum."""
    design = table1(parabola, errors)
    roll, rates = at_roll(mounted_backlash(design).pinion_roll), backlash_by_errors(design)
    assert np.isfinite(rates).all()
    for rate, name, step in zip(rates, ERROR_NAMES, (1e-3, 1e-6, 1e-3, 1e-3), strict=True):
        beside = [
            play_at(replace(design, errors=replace(errors, **{name: getattr(errors, name) + way})), roll)[0]
            for way in (step, -step)
        ]
        assert rate == pytest.approx(float((beside[0] - beside[1])[0]) / (2.0 * step), abs=2e-5, rel=1e-8)


@pytest.mark.parametrize("parabola", [NO_PARABOLA, (-0.002, 0.0), (-0.001, -0.001)])
def test_no_edge_stops_flanks_that_touch_along_lines(parabola: tuple[float, float]) -> None:
    """On straight teeth on parallel axes, the ends of a line lie on edges, but are no edge contacts."""
    tool = Tool(4.0, radians(20.0))
    pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, 30.0) for teeth in (23, 37))
    design = Design(pinion, gear, Pair(120.2, 0.0)).with_parabola(*parabola)
    found = mounted_backlash(design)
    assert (np.stack((found.right.limit, found.left.limit)) == -1).all()


@pytest.mark.parametrize(("number", "axial"), [(0, (1.927, 2.438)), (1, (0.933, 0.0))])
def test_derivatives_where_an_edge_stops_an_edge(number: int, axial: tuple[float, float]) -> None:
    """The gear separates perpendicular to both edges; compared with differences of the minimum."""
    design = edge_pair(number)
    own = replace(
        design.errors,
        pinion_axial=float(design.errors.pinion_axial) + axial[0],
        gear_axial=float(design.errors.gear_axial) + axial[1],
    )
    found = mounted_backlash(replace(design, errors=own))
    edges = np.concatenate((found.right.limit, found.left.limit))
    assert ((edges >= 0).all(axis=-1) & (edges[:, 0] % 2 != edges[:, 1] % 2)).any()
    rates = backlash_by_errors(replace(design, errors=own))
    for rate, name, step in zip(rates, ERROR_NAMES, (1e-4, 1e-7, 1e-4, 1e-4), strict=True):
        ways = float(getattr(own, name)) + step * np.array([1.0, -1.0])
        beside = mounted_backlash(replace(design, errors=replace(own, **{name: ways}))).normal
        assert rate == pytest.approx((beside[0] - beside[1]) / (2.0 * step), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("parabola", [(-0.001, 0.0), (-0.001, -0.001), (0.001, -0.002)])
def test_no_derivative_where_both_signs_reduce_the_backlash(
    parabola: tuple[float, float],
) -> None:
    design, step = builtin_design("anti-backlash").with_parabola(*parabola), 1e-7
    angles = Errors(shaft_angle=np.array([-step, 0.0, step]))
    before, own, after = mounted_backlash(replace(design, errors=angles)).normal
    assert after - own == pytest.approx(before - own, rel=1e-3)
    assert (after - own) / step < -1.0
    assert np.isnan(backlash_by_errors(design)).tolist() == [False, True, False, False]
    both = backlash_by_errors(replace(design, errors=Errors(offset=np.array([0.0, 0.1]))))
    np.testing.assert_allclose(both[0], backlash_by_errors(design), rtol=1e-12)
    assert np.isnan(both[1]).tolist() == [False, True, False, False]


@pytest.mark.slow
def test_by_tangency_without_parabolas() -> None:
    """Without parabolas, the backlash by tangency is exact where flanks touch, and a lower bound where edges
    touch."""
    cases = mounted(table1(), drawn_errors(WIDE, 3, 0, 24))
    found, exact = tangent_backlash(cases), mounted_backlash(cases).normal
    touches = found.status == Tangency.TOUCHES
    assert 8 < touches.sum() < 24
    assert np.abs(exact - found.normal)[touches].max() < 6.0 * 3e-14
    assert set(found.status[~touches]) == {Tangency.AT_LEAST}
    assert (exact - found.normal)[~touches].min() > 1e-9
    assert (exact - found.normal)[~touches].max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("parabola", [(-0.0005, -0.0005), (-0.001, 0.0005), (0.0002, -0.0004)])
def test_by_tangency_of_modified_flanks(parabola: tuple[float, float]) -> None:
    cases = mounted(table1(parabola), drawn_errors(WIDE, 3, 0, 24))
    found, exact = tangent_backlash(cases), mounted_backlash(cases).normal
    touches, least = (found.status == code for code in (Tangency.TOUCHES, Tangency.AT_LEAST))
    assert touches.sum() > 5
    assert least.sum() > 5
    assert np.abs(exact - found.normal)[touches].max() < 3e-6
    assert (exact - found.normal)[least].min() > -3e-6


@pytest.mark.parametrize(
    ("pinion", "gear"),
    [
        (Modification(helix_crowning_um=10.0), None),
        (None, Modification(helix_slope_um=5.0, helix_crowning_um=12.0)),
        (
            Modification(helix_crowning_um=8.0, profile_crowning_um=4.0),
            Modification(tip_relief_um=12.0, tip_relief_length_mm=3.0),
        ),
    ],
)
def test_by_tangency_of_crowned_flanks(pinion: Modification | None, gear: Modification | None) -> None:
    design = table1()
    design = replace(design, pinion=design.pinion.modified(pinion), gear=design.gear.modified(gear))
    errors = Tolerances(0.05, radians(0.01), 0.1, 0.1)
    cases = mounted(design, drawn_errors(errors, 3, 0, 8))
    found, exact = tangent_backlash(cases), mounted_backlash(cases).normal
    touches = found.status == Tangency.TOUCHES
    assert touches.sum() >= 4
    np.testing.assert_array_equal(np.isnan(found.normal), found.status == Tangency.UNKNOWN)
    np.testing.assert_allclose(found.normal[touches], exact[touches], rtol=0.0, atol=1e-5)


def test_hollow_flanks_are_no_bound() -> None:
    design = table1()
    hollow = replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=-5.0)))
    found = tangent_backlash(hollow)
    assert found.status in (Tangency.ESTIMATE, Tangency.UNKNOWN)


@pytest.mark.parametrize("parabola", [(0.001, -0.001), (0.0002, 0.0002)])
def test_concave_flanks_are_estimates(parabola: tuple[float, float]) -> None:
    """Edges touch earlier than concave flanks: the result is neither the backlash nor a bound."""
    cases = mounted(table1(parabola), drawn_errors(Tolerances(0.05, radians(0.01), 0.1, 0.1), 3, 0, 8))
    found, exact = tangent_backlash(cases), mounted_backlash(cases).normal
    assert set(found.status) <= {Tangency.ESTIMATE, Tangency.UNKNOWN}
    np.testing.assert_array_equal(np.isnan(found.normal), found.status == Tangency.UNKNOWN)
    known = ~np.isnan(found.normal)
    assert (exact < found.normal)[known].all()


def test_known_ends_of_paths() -> None:
    design = table1(errors=Errors(offset=np.array([-0.1, 0.1])))
    ends = path_of_contact(design, "left", 3).ends
    first, second = tangent_backlash(design), tangent_backlash(design, {"left": ends})
    np.testing.assert_array_equal(first.normal, second.normal)
    np.testing.assert_array_equal(first.status, second.status)


@pytest.mark.parametrize("shaft_angle_deg", [1.0, -2.0])
def test_without_a_path_the_backlash_of_tangency_is_unknown(shaft_angle_deg: float) -> None:
    """A design without a path has the backlash NaN and a status, alone and in a batch; the other case of the
    batch keeps its value."""
    angles = np.radians([shaft_angle_deg, 0.0])
    designs = [table1((0.001, -0.001)).with_errors(Errors(shaft_angle=a)) for a in (*angles, angles)]
    lost, usual, both = (tangent_backlash(design) for design in designs)
    assert np.isnan(lost.normal)
    assert lost.status == both.status[0]
    assert both.normal[1] == pytest.approx(float(usual.normal), abs=1e-12)
    assert np.isnan(both.normal[0])


PARALLEL = builtin_design("anti-backlash")


def test_tangency_on_parallel_axes() -> None:
    """On parallel axes, the backlash by tangency is exact for lines of contact, unknown for axes tilted by an
    error, a lower bound for convex flanks, and an estimate for concave flanks."""
    level, tilted = np.array([0.0, 0.02, -0.02, 0.01]), np.radians([0.0, 0.0, 0.01, -0.005])
    cases = PARALLEL.with_errors(Errors(offset=level, shaft_angle=tilted, gear_axial=0.1))
    exact, found = mounted_backlash(cases).normal, tangent_backlash(cases)
    assert found.status.tolist() == 2 * [Tangency.TOUCHES] + 2 * [Tangency.UNKNOWN]
    np.testing.assert_allclose(found.normal[:2], exact[:2], atol=1e-11)
    assert np.isnan(found.normal[2:]).all()
    assert np.isfinite(exact).all()
    convex = cases.with_parabola(-2e-3, -1e-3)
    exact, found = mounted_backlash(convex).normal, tangent_backlash(convex)
    assert set(found.status.tolist()) <= {Tangency.TOUCHES, Tangency.AT_LEAST}
    assert (found.normal <= exact + 1e-6).all()
    hollow = tangent_backlash(cases.with_parabola(2e-3, 1e-3))
    assert set(hollow.status.tolist()) == {Tangency.ESTIMATE}
