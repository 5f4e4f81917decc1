"""Optimal coefficients: objective compared with closed forms, optimum compared with brute force."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Aim, Errors, optimise_parabola, path_of_contact
from beveloid_geom.analysis.edge_contact import cycle_extremes, leads_of, swing_of_all
from beveloid_geom.analysis.optimise import Optimum, objectives_of
from beveloid_geom.analysis.tolerance import USUAL
from beveloid_geom.operation.mesh_cycle import mesh_cycle
from beveloid_geom.pair.misalignment import ERROR_NAMES, mounted
from tests.contact.test_root_exclusion import OFF_THE_FLANKS
from tests.oracle.table1 import table1

OFFSET = Aim(Errors(offset=0.05))
C3 = replace(OFFSET, contact_ratio=1.75, pinion_parabola=(0.0, 0.002), gear_parabola=(-0.002, 0.0))
"""The quadrant that the paper recommends."""
FLAT = replace(
    OFFSET,
    contact_ratio=1.7,
    peak_to_peak=math.radians(4.0 / 3600.0),
    pinion_parabola=(-0.0005, 0.0002),
    gear_parabola=(-0.0002, 0.0005),
)

NO_EDGES = Aim(Errors(**{name: getattr(USUAL, name) for name in ERROR_NAMES}), edges=False)
DEEP = replace(
    NO_EDGES, contact_ratio=1.0, off_centre=5.0, pinion_parabola=(-1e-3, -9e-4), gear_parabola=(-1e-3, -9e-4)
)
"""Coefficients with which errors move the path so far that edges are in contact."""


@pytest.fixture(scope="module", params=[C3, FLAT], ids=["quadrant", "small error"])
def solved(request: Any) -> tuple[Aim, Optimum]:
    return request.param, optimise_parabola(table1(), request.param)


def test_shift_of_unmodified_flanks_in_closed_form(flank: str) -> None:
    """The path is straight in (z, l1). An offset error shifts it along z without rotation. An axial error
    of the pinion leaves the line at its place in space, and an axial error of the gear has no effect on
    it."""
    aim = Aim(Errors(offset=0.05, gear_axial=0.2))
    found = objectives_of(table1(), flank, aim, np.zeros(3), np.zeros(3))
    path = path_of_contact(table1(), flank, 3)
    moved = path_of_contact(table1(errors=Errors(offset=0.05)), flank, l1=path.l1[1:2]).pinion_z[0]
    slope = (path.pinion_z[2] - path.pinion_z[0]) / (path.l1[2] - path.l1[0])
    expected = abs(moved - path.pinion_z[1]) / math.hypot(1.0, slope)
    np.testing.assert_allclose(found.shift, expected, rtol=1e-8)
    np.testing.assert_allclose(found.centre, path.pinion_z[1], atol=1e-9)
    np.testing.assert_allclose(found.contact_ratio, path.ends.contact_ratio, rtol=1e-9)
    assert found.peak_to_peak.max() < 1e-12


def test_errors_are_added_to_those_of_the_design_in_both_directions() -> None:
    design = table1((0.0005, -0.0007), Errors(offset=0.03))
    both = objectives_of(
        design, "right", Aim(Errors(offset=0.1, gear_axial=0.5)), *np.array([0.0005, -0.0007])
    )
    parts = []
    path = path_of_contact(design, "right", 201)
    along = np.array([path.pinion_z[101] - path.pinion_z[99], path.l1[101] - path.l1[99]])
    for errors in (Errors(0.13), Errors(-0.07), Errors(0.03, gear_axial=0.5), Errors(0.03, gear_axial=-0.5)):
        other = path_of_contact(design.with_errors(errors), "right", 3)
        move = np.array([other.pinion_z[1] - path.pinion_z[100], other.l1[1] - path.l1[100]])
        parts.append((move[0] * along[1] - move[1] * along[0]) / math.hypot(*along))
    np.testing.assert_allclose(both.shift, math.sqrt(0.5 * np.square(parts).sum()), rtol=2e-4)
    swing = np.ptp(path.transmission_error)
    np.testing.assert_allclose(both.peak_to_peak, swing, rtol=1e-4)


def test_the_optimum_meets_its_aim(solved: tuple[Aim, Optimum]) -> None:
    aim, found = solved
    path = path_of_contact(found.design, "right", 201)
    assert found.design.pinion.tool.parabola == found.pinion_parabola
    assert found.design.gear.tool.parabola == found.gear_parabola
    assert path.ends.contact_ratio > aim.contact_ratio * (1.0 - 2e-6)
    assert abs(path.pinion_z[100]) < aim.off_centre * (1.0 + 2e-6)
    assert np.ptp(path.transmission_error) < aim.peak_to_peak * (1.0 + 1e-4)
    assert aim.pinion_parabola[0] <= found.pinion_parabola <= aim.pinion_parabola[1]
    assert aim.gear_parabola[0] <= found.gear_parabola <= aim.gear_parabola[1]
    assert found.pinion_parabola + found.gear_parabola <= 1e-9
    np.testing.assert_allclose(found.given.contact_ratio, 1.651001, atol=5e-7)
    np.testing.assert_allclose(found.optimum.contact_ratio, path.ends.contact_ratio, rtol=1e-9)
    assert found.optimum.shift < found.given.shift


def test_no_other_coefficients_have_a_smaller_shift(solved: tuple[Aim, Optimum]) -> None:
    aim, found = solved
    sides = (np.linspace(*bounds, 15) for bounds in (aim.pinion_parabola, aim.gear_parabola))
    far = np.array([side.ravel() for side in np.meshgrid(*sides)])
    near = np.array([found.pinion_parabola, found.gear_parabola])[:, None]
    around = near + 2e-5 * np.random.default_rng(0).uniform(-1.0, 1.0, (2, 150))
    x = np.hstack((far[:, far.sum(axis=0) <= 0.0], around))
    inside = (x[0] >= aim.pinion_parabola[0]) & (x[0] <= aim.pinion_parabola[1])
    inside &= (x[1] >= aim.gear_parabola[0]) & (x[1] <= aim.gear_parabola[1]) & (x.sum(axis=0) <= 0.0)
    others = objectives_of(table1(), "right", aim, x[0, inside], x[1, inside])
    met = (others.margins(aim) >= 0.0).all(axis=0)
    assert np.count_nonzero(met) > 10
    assert others.shift[met].min() > found.optimum.shift * (1.0 - 1e-5)


def test_concave_relative_curvature_is_excluded() -> None:
    """A positive sum of the coefficients would reduce the shift, and the objective decreases towards it."""
    aim = Aim(
        Errors(offset=0.05),
        contact_ratio=1.0,
        off_centre=5.0,
        pinion_parabola=(-0.00101, -0.0009),
        gear_parabola=(0.00099, 0.0011),
    )
    found = optimise_parabola(table1(), aim)
    assert found.pinion_parabola + found.gear_parabola <= 1e-9
    sums = np.array([0.0, 0.00005, 0.0001])
    hollow = objectives_of(table1(), "right", aim, -0.001 + sums, np.full(3, 0.001))
    assert (hollow.margins(aim) > 0.0).all()
    assert (np.diff(hollow.shift) < 0.0).all()
    assert hollow.shift[-1] < 0.65 * found.optimum.shift


def test_an_aim_that_a_single_corner_meets() -> None:
    """Only one corner of the bounds satisfies the constraints. Its neighbours have a smaller shift and
    violate the constraints by less than a hundredth."""
    bounds = (-0.0005, -0.00049)
    aim = Aim(Errors(offset=0.05), 1.0, 5.0, math.inf, bounds, bounds)
    corner = objectives_of(table1(), "left", aim, np.array(bounds[1]), np.array(bounds[1]))
    swing = 1.0005 * float(corner.peak_to_peak)
    found = optimise_parabola(table1(), replace(aim, peak_to_peak=swing), "left")
    assert found.optimum.peak_to_peak <= swing * (1.0 + 1e-5)
    assert found.optimum.shift <= corner.shift


def test_the_optimum_is_compared_with_the_given_design() -> None:
    aim = Aim(Errors(offset=0.05), 1.7, 5.0, math.inf, (-0.0005, 0.0), (-0.0005, 0.0))
    found = optimise_parabola(table1((-0.0002, -0.0001)), aim, "left")
    given = objectives_of(table1(), "left", aim, np.array(-0.0002), np.array(-0.0001))
    for name in ("shift", "contact_ratio", "centre", "peak_to_peak"):
        assert getattr(found.given, name) == pytest.approx(float(getattr(given, name)), rel=1e-9)
    assert found.design.pair == table1().pair
    assert found.optimum.shift < found.given.shift


@pytest.mark.parametrize("edges", [True, False])
def test_the_message_contains_the_largest_ratio_tried(edges: bool) -> None:
    bounds = (-0.0002, 0.0)
    aim = Aim(Errors(offset=0.05), 1.9, 5.0, math.inf, bounds, bounds, edges)
    greatest = objectives_of(table1(), "left", aim, np.array(-0.0002), np.array(-0.0002)).contact_ratio
    told = rf"contact ratio of 1\.9 within 5 mm.*the largest ratio tried is {greatest:.3f}: relax"
    with pytest.raises(ValueError, match=f"^no coefficients were found with a {told}"):
        optimise_parabola(table1(), aim, "left")


def test_the_best_of_several_minima_is_found() -> None:
    """There are two minima within the default bounds, and the best coefficients of the grid are near the
    worse one."""
    aim = Aim(Errors(offset=0.05))
    gear = np.linspace(-0.002, 0.002, 33)
    others = objectives_of(table1(), "right", aim, np.full(33, -0.002), gear)
    least = others.shift[(others.margins(aim) >= 0.0).all(axis=0)].min()
    assert optimise_parabola(table1(), aim).optimum.shift < least < 0.1


@pytest.mark.parametrize("edges", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_wider_bounds_do_not_worsen_the_optimum(edges: bool) -> None:
    """Twice the usual bounds give an optimum that is not worse, although the best coefficients are between
    the points of the coarser grid."""
    shifts = []
    for bound in (0.002, 0.004):
        bounds = (-bound, bound)
        aim = replace(NO_EDGES, pinion_parabola=bounds, gear_parabola=bounds, edges=edges)
        shifts.append(float(optimise_parabola(table1(), aim).optimum.shift))
    assert (np.diff(shifts) <= 1e-5).all()
    assert edges == (shifts[1] < 1.0)


# No edges


@pytest.fixture(scope="module", params=[NO_EDGES, replace(NO_EDGES, contact_ratio=1.9)], ids=["1.6", "1.9"])
def without_edges(request: Any) -> tuple[Aim, Optimum]:
    return request.param, optimise_parabola(table1(), request.param)


def test_no_edge_contact_in_any_mounting(without_edges: tuple[Aim, Optimum]) -> None:
    aim, found = without_edges
    mountings = [Errors()]
    mountings += [Errors(**{name: s * getattr(USUAL, name)}) for name in ERROR_NAMES for s in (1.0, -1.0)]
    cycles = [mesh_cycle(found.design.with_errors(errors), "right", 1) for errors in mountings]
    assert [float(cycle.edge_share) for cycle in cycles] == [0.0] * 9
    swings = [float(cycle.peak_to_peak) for cycle in cycles]
    assert found.optimum_operation.edge_share == 0.0
    assert found.optimum_operation.cycle_peak_to_peak == pytest.approx(swings[0], rel=1e-9)
    assert found.optimum_operation.greatest_cycle_peak_to_peak == pytest.approx(max(swings), rel=1e-9)
    assert (found.optimum.margins(aim) >= -1e-6).all()


def test_the_condition_increases_the_shift_and_is_active(without_edges: tuple[Aim, Optimum]) -> None:
    aim, found = without_edges
    free = optimise_parabola(table1(), replace(aim, edges=True))
    assert free.optimum_operation.edge_share > 0.02
    assert free.optimum.shift < found.optimum.shift
    assert found.optimum.leads.min() == pytest.approx(0.0, abs=2e-9)
    lower = table1((found.pinion_parabola - 1e-7, found.gear_parabola - 1e-7))
    assert 0.0 < cycle_extremes(mounted(lower, aim.mountings()), "right").edge_share < 1e-3


def test_all_teeth_are_reported_without_the_condition(solved: tuple[Aim, Optimum]) -> None:
    aim, found = solved
    for design, shown in ((found.design, found.optimum_operation), (table1(), found.given_operation)):
        assert shown == cycle_extremes(mounted(design, aim.mountings()), "right")
    assert found.optimum.leads.shape == (0,)


def agree(design: Any, flank: str, coefficients: Any) -> tuple[int, int]:
    """Check that the leads at the ends of the paths predict edge contact, and return the numbers of mountings
    with and without it."""
    counts = np.zeros(2, dtype=int)
    for pair in coefficients:
        mountings = mounted(design.with_parabola(*pair.tolist()), NO_EDGES.mountings())
        leads, cycle = (
            leads_of(path_of_contact(mountings, flank, 17)).min(axis=0),
            mesh_cycle(mountings, flank, 1),
        )
        np.testing.assert_array_equal(leads > 0.0, cycle.edge_share == 0.0)
        counts += np.count_nonzero(leads <= 0.0), np.count_nonzero(leads > 0.0)
    return int(counts[0]), int(counts[1])


def sums_and_differences(size: int) -> Any:
    total, apart = np.random.default_rng(5).uniform((-0.0012, -0.001), (0.0004, 0.001), (size, 2)).T
    return 0.5 * np.stack((total + apart, total - apart), axis=-1)


def test_leads_predict_edge_contact() -> None:
    """Leads predict edge contact of right flanks, also for sums of the coefficients below -0.0005 1/mm, where
    the share of edge contact does not decrease with the sum."""
    edges, others = agree(table1(), "right", sums_and_differences(6))
    assert min(edges, others) > 5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "flank"),
    [
        *(("Table 1", "right"), ("Table 1", "left"), ("small, 6.5 and 5 deg", "left")),
        *(("helices opposed", "right"), ("helices opposed", "left")),
    ],
)
def test_leads_predict_edge_contact_of_many_pairs(name: str, flank: str) -> None:
    design = OFF_THE_FLANKS.get(name, table1())
    module = float(design.pinion.tool.normal_module)
    edges, others = agree(design, flank, 6.0 / module * sums_and_differences(16))
    assert edges > 5
    assert others > 50 or name == "helices opposed"  # its right flanks are close to line contact


@pytest.mark.slow
def test_no_coefficients_of_a_grid_without_edge_contact_are_better(flank: str) -> None:
    """On the right flanks, all coefficients with a smaller shift that meet the other constraints have edge
    contact. On the left flanks there are no such coefficients."""
    aim = replace(NO_EDGES, pinion_parabola=(-0.0005, 0.0015), gear_parabola=(-0.0015, 0.0005))
    found = optimise_parabola(table1(), aim, flank)
    x = np.array(
        [side.ravel() for side in np.meshgrid(np.linspace(-5e-4, 15e-4, 41), np.linspace(-15e-4, 5e-4, 41))]
    )
    near = np.array([found.pinion_parabola, found.gear_parabola])[:, None]
    around = near + 1e-5 * np.random.default_rng(0).uniform(-1.0, 1.0, (2, 60))
    inside = (around[0] <= 0.0015) & (around[0] >= -0.0005) & (around[1] <= 0.0005) & (around[1] >= -0.0015)
    x = np.hstack((x[:, x.sum(axis=0) <= 1e-12], around[:, inside]))
    paths = objectives_of(table1(), flank, replace(aim, edges=True), *x)
    better = (paths.margins(replace(aim, edges=True)) >= 0.0).all(axis=0)
    better &= paths.shift < found.optimum.shift * (1.0 - 1e-6)
    shares = [
        cycle_extremes(mounted(table1(pair), aim.mountings()), flank).edge_share
        for pair in map(tuple, x[:, better].T.tolist())
    ]
    assert not any(share == 0.0 for share in shares)
    assert len(shares) > 20 or flank == "left"


def test_transmission_error_of_all_teeth_follows_from_the_path(flank: str) -> None:
    for coefficients in ((0.0003, -0.0007), (-0.0002, -0.0002), (0.0015, -0.0018)):
        mountings = mounted(table1(coefficients), NO_EDGES.mountings())
        cycle = mesh_cycle(mountings, flank, 1)
        free = cycle.edge_share == 0.0
        assert free.any()
        found = swing_of_all(path_of_contact(mountings, flank, 17))
        np.testing.assert_allclose(found[free], cycle.peak_to_peak[free], rtol=1e-5)


@pytest.mark.parametrize("shift", [pytest.param(3.0, marks=pytest.mark.slow), 1.45])
def test_no_other_coefficients_have_a_smaller_transmission_error(shift: float) -> None:
    """No coefficients of a grid, or near the optimum, are better: the four with the smallest transmission
    error by their paths have edge contact or a larger error in their mesh cycles."""
    aim = replace(NO_EDGES, shift=shift, least="transmission_error")
    found = optimise_parabola(table1(), aim)
    least = found.optimum_operation.greatest_cycle_peak_to_peak
    assert found.optimum_operation.edge_share == 0.0
    assert found.optimum.shift <= shift * (1.0 + 1e-6)
    assert float(found.optimum.goals.max()) == pytest.approx(least, rel=1e-5)
    total, apart = np.meshgrid(-np.linspace(0.0, 0.0012, 41), np.linspace(-0.004, 0.004, 41))
    near = np.array([found.pinion_parabola, found.gear_parabola])[:, None]
    x = np.array((0.5 * (total + apart), 0.5 * (total - apart))).reshape(2, -1)
    x = np.hstack((x, near + 2e-5 * np.random.default_rng(0).uniform(-1.0, 1.0, (2, 200))))
    x = x[:, (np.abs(x) <= 0.002).all(axis=0)]
    paths = objectives_of(table1(), "right", aim, *x)
    met = (paths.margins(aim) >= 0.0).all(axis=0) & (x.sum(axis=0) <= 0.0)
    assert np.count_nonzero(met) > 10
    order = np.argsort(paths.goals.max(axis=0)[met])[:4]
    for pair in x[:, met][:, order].T.tolist():
        there = cycle_extremes(mounted(table1((pair[0], pair[1])), aim.mountings()), "right")
        assert there.edge_share > 0.0 or there.greatest_cycle_peak_to_peak > least * (1.0 - 1e-5)


def test_edge_contact_with_all_coefficients_is_reported() -> None:
    words = r"no coefficients were found without edge contact.* edges touch during \d+(\.\d+)? % of a cycle"
    with pytest.raises(ValueError, match=words):
        optimise_parabola(table1(), DEEP)


def test_a_tool_without_fillets_has_no_mesh_cycle() -> None:
    """The path of a tool without fillets can be optimised, but its mesh cycle is unknown."""
    design, aim = OFF_THE_FLANKS["pressure angle 25 deg"], replace(OFFSET, contact_ratio=1.0, off_centre=5.0)
    found = optimise_parabola(design, aim, "left")
    assert np.isnan(found.optimum_operation.edge_share)
    with pytest.raises(ValueError, match="the tool's tip rounds overlap"):
        optimise_parabola(design, replace(aim, edges=False), "left")
