"""Certificates of paths of contact: known cases of Table 1 and independent searches."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Errors, builtin_design, path_certificate, path_of_contact
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.status import Limit, Verdict
from tests.oracle.table1 import table1
from tests.symmetry import mirrored


@pytest.mark.parametrize("errors", [Errors(), Errors(-0.05, radians(0.002), 0.1, 0.1)])
def test_unmodified_paths_are_certified(flank: str, errors: Errors) -> None:
    design = table1(errors=errors)
    proof = path_certificate(path_of_contact(design, flank, 41))
    assert proof.holds
    assert np.abs(proof.separation).max() < 1e-11
    assert (proof.curvature > 1e-5).all()


def test_both_slightly_concave_edges_touch() -> None:
    """With 0.0002 1/mm on both members, edges at the tips touch earlier at 97 % of the positions of the right
    flanks, by up to ten micrometres."""
    design = table1((0.0002, 0.0002))
    proof = path_certificate(path_of_contact(design, "right", 101))
    edges = proof.verdict == Verdict.EDGE_CONTACT
    assert edges.mean() > 0.97
    assert set(proof.first.limit[edges].ravel()) == {-1, Limit.PINION_TIP, Limit.GEAR_TIP}
    assert -0.012 < proof.separation.min() < -0.009
    assert (proof.curvature > 0.0).all()


@pytest.mark.parametrize("coefficient", [0.0006, 0.001])
def test_both_concave_flanks_interpenetrate(coefficient: float) -> None:
    """Flanks that are concave by 0.0006 1/mm and more interfere at every position: the path of the right
    flanks consists of saddle points, and l1 decreases along it."""
    design = table1((coefficient, coefficient))
    path = path_of_contact(design, "right", 21)
    proof = path_certificate(path)
    assert path.l1[0] > path.l1[-1]
    assert (proof.verdict == Verdict.INTERFERENCE).all()
    assert (proof.curvature < 0.0).all()
    assert (proof.separation < -0.03).all()


def test_convex_flanks_hand_over(flank: str) -> None:
    """Convex flanks touch first in the middle of their path. At its ends, the flanks of the next pair touch
    earlier."""
    design = table1((-0.0005, -0.0005))
    proof = path_certificate(path_of_contact(design, flank, 41))
    assert set(proof.verdict) == {Verdict.FIRST_CONTACT, Verdict.NEXT_PAIR}
    assert proof.verdict[20] == Verdict.FIRST_CONTACT
    assert proof.verdict[0] == proof.verdict[-1] == Verdict.NEXT_PAIR
    assert set(proof.first.pair[[0, -1]]) == {-1, 1}
    assert not proof.holds


@pytest.mark.parametrize("parabola", [(0.001, -0.001), (0.0003, 0.0003)])
def test_separation_is_the_minimum(parabola: tuple[float, float], flank: str) -> None:
    """No point of a grid over seven teeth has a smaller clearance than the reported point."""
    design = table1(parabola)
    path = path_of_contact(design, flank, 4)
    proof = path_certificate(path)
    first, gear = proof.first, surface_of(design.gear, flank)
    # Distance along the normal of the touched surface: the pinion's where an edge of the gear touches.
    by_gear = (first.limit[:, 0] >= 0) & (first.limit[:, 0] % 2 == 1)
    rolls = path.pinion_roll, path.gear_roll, first.pair
    on_gear = angular_clearance(design, flank, 0, first.l1, first.z1, *rolls).distance
    on_pinion = angular_clearance(design, flank, 1, first.l2, first.z2, *rolls).distance
    apart = np.abs(np.where(by_gear, on_pinion, on_gear) - proof.separation)
    # Rotating the pinion instead of the gear agrees to first order in the clearance.
    assert (apart < 1e-7 + np.where(by_gear, 2e-4 * np.abs(proof.separation), 0.0)).all()
    z = gear.half_width * np.linspace(-1.0, 1.0, 31)
    s = (
        gear.bottom
        + (tip_parameter(design.gear, flank, z) - gear.bottom) * np.linspace(0.01, 1.0, 41)[:, None]
    )
    pairs = np.arange(-3, 4)[:, None, None]
    for k in range(4):
        met = angular_clearance(
            design, flank, 1, s, z + 0.0 * s, path.pinion_roll[k], path.gear_roll[k], pairs
        )
        least = np.where(met.inside, met.distance, np.inf).min()
        assert proof.separation[k] - 1e-7 < least < proof.separation[k] + 0.01


def test_overlap_of_an_edge_with_an_edge_is_negative(flank: str) -> None:
    """The teeth overlap at all positions, also where an edge of the pinion touches an edge of the gear. The
    normal of this contact is perpendicular to both edges; its sense does not affect the result."""
    design = builtin_design("awd-transfer").with_errors(Errors(offset=0.0952, shaft_angle=-0.00042))
    proof = path_certificate(path_of_contact(design if flank == "left" else mirrored(design), flank, 7))
    assert list(proof.first.limit[5]) == [Limit.GEAR_HEEL, Limit.PINION_TIP]
    assert (proof.separation < -0.06).all()
    assert (proof.verdict == Verdict.INTERFERENCE).all()


def test_batches_and_positions_without_a_path() -> None:
    design = table1((0.001, -0.001), Errors(offset=np.array([-0.3, 0.3, 9.0])))
    path = path_of_contact(design, "right", 11)
    proof = path_certificate(path)
    assert proof.verdict.shape == (3, 11)
    lost = proof.verdict == Verdict.NOT_SOLVED
    assert np.array_equal(lost, path.status != 0)
    assert lost[2].all()
    assert np.isnan(proof.separation[lost]).all()
    given = path_of_contact(table1(), "right", l1=[-8.0, 0.0, 8.0])
    verdict = path_certificate(given).verdict
    assert list(verdict) == [Verdict.NOT_SOLVED, Verdict.FIRST_CONTACT, Verdict.NOT_SOLVED]
