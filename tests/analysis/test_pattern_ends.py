"""Where patterns end, by points along the edges alone: against whole patterns, and symmetries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design, contact_pattern, mesh_cycle
from beveloid_geom.analysis.pattern_ends import pattern_ends
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.gear.flank import flank_point, place_at
from beveloid_geom.operation.marking.least_over_roll import least_separation, mating_of
from beveloid_geom.operation.marking.operating_rolls import first_contact_operation
from beveloid_geom.pair.errors import mounted
from beveloid_geom.status import FirstStatus, Limit
from tests.oracle.table1 import table1
from tests.symmetry import exchanged, mirrored

THICK = 0.00635
CASES = [  # design, flank, and times the usual tolerances, so that some patterns end there and some do not
    (table1((-0.0005, -0.0005)), "right", 4.0),
    (table1((0.0002, 0.0002)), "right", 3.0),
    (table1((0.001, -0.001)), "left", 8.0),
    (builtin_design("awd-transfer").with_parabola(0.0, -0.0005), "right", 3.0),
    (builtin_design("marine-gearbox").with_parabola(0.001, -0.0012), "left", 8.0),
]


def drawn(times: float, count: int, seed: int) -> FloatArray:
    offset, angle, pinion, gear = (times * USUAL.values()).tolist()
    wide = replace(USUAL, offset=offset, shaft_angle=angle, pinion_axial=pinion, gear_axial=gear)
    return drawn_errors(wide, seed, 0, count)


def ends_of(design: Design, flank: str, separation: float = THICK) -> Mask:
    return pattern_ends(mesh_cycle(design, flank, 1), separation)


def least_along_edges(design: Design, flank: str, count: int = 120) -> FloatArray:
    """Least separations (8,) of many points along the edges, in the order of `Limit`: by perpendiculars, over
    the whole mesh, as whole patterns have them."""
    operation, along = first_contact_operation(design, flank), np.linspace(0.0, 1.0, count)
    low, high = np.zeros(count), np.ones(count)
    depth, face = np.concatenate((low, high, along, along)), np.concatenate((along, along, low, high))
    least = np.empty((4, 2))
    for member, own in enumerate(design.members):
        l, _, u = place_at(own, flank, depth, face)
        points = flank_point(own, flank, l, u)
        found = least_separation(mating_of(design, flank, member, operation), points).least
        least[:, member] = np.nan_to_num(found, nan=np.inf).reshape(4, count).min(axis=1)
    return least.reshape(-1)


def agree(design: Design, flank: str, errors: FloatArray) -> int:
    """Compare with many points, but for edges where the compound is as thick as the least separation, to 5 %;
    count the edges compared of those at which some patterns end and some do not."""
    cycle = mesh_cycle(mounted(design, errors), flank, 1)
    known = cycle.status == FirstStatus.SOLVED
    least = np.array([least_along_edges(mounted(design, own), flank) for own in errors[known]])
    wanted, clear = least <= THICK, (least < 0.95 * THICK) | (least > 1.05 * THICK)
    np.testing.assert_array_equal(pattern_ends(cycle)[known][clear], wanted[clear])
    return int(np.count_nonzero(clear & (wanted.any(axis=0) & ~wanted.all(axis=0))))


@pytest.mark.parametrize(("design", "flank", "times"), CASES[::2])
def test_ends_are_where_compound_is_wiped_off_an_edge(design: Design, flank: str, times: float) -> None:
    agree(design, flank, drawn(times, 3, 1))


@pytest.mark.slow
@pytest.mark.parametrize(("design", "flank", "times"), CASES)
def test_ends_of_many_mountings(design: Design, flank: str, times: float) -> None:
    assert agree(design, flank, drawn(times, 40, 2)) > 30 or design is CASES[2][0]


def test_ends_begin_at_the_least_separation_of_an_edge() -> None:
    """At the pinion's heel it is where another tooth pair takes over. At the other edges, which only compound
    of many hundredths of a millimetre marks, it is where an edge of the mate passes, roughly known."""
    design, flank, _ = CASES[0]
    cycle, least = mesh_cycle(design, flank, 1), least_along_edges(design, flank)
    near = [Limit.PINION_TIP, Limit.GEAR_TIP, Limit.PINION_TOE, Limit.PINION_HEEL]
    for edge in near:
        ends = [pattern_ends(cycle, share * float(least[edge]))[0, edge] for share in (0.95, 1.05)]
        assert ends == [False, True]
    assert np.delete(least, near).min() > 0.06


def test_ends_are_those_of_a_whole_pattern() -> None:
    design = mounted(CASES[0][0], drawn(4.0, 5, 1)[4])
    pattern = contact_pattern(design, "right", resolution=0.5)
    rims = [
        [side.marked[0], side.marked[-1], side.marked[:, 0], side.marked[:, -1]]
        for side in (pattern.pinion, pattern.gear)
    ]
    wanted = np.array([[rim.any() for rim in of_member] for of_member in rims]).T.reshape(-1)
    np.testing.assert_array_equal(ends_of(design, "right")[0], wanted)
    assert 0 < np.count_nonzero(wanted) < 8


def test_the_same_pair_seen_otherwise_has_the_same_ends(flank: str) -> None:
    """Exchanged, pinion and gear change places; mirrored, right and left flanks."""
    mountings = mounted(CASES[0][0], drawn(6.0, 8, 3))
    found = ends_of(mountings, flank)
    swapped = ends_of(exchanged(mountings), flank).reshape(-1, 4, 2)[..., ::-1]
    np.testing.assert_array_equal(swapped.reshape(-1, 8), found)
    other = "left" if flank == "right" else "right"
    np.testing.assert_array_equal(ends_of(mirrored(mountings), other), found)


def test_thick_compound_ends_at_all_tips_and_ends_of_faces() -> None:
    """And thin compound at least where a path ends: gear tip and pinion tip."""
    tips = [Limit.PINION_TIP, Limit.GEAR_TIP]
    faces = [Limit.PINION_TOE, Limit.PINION_HEEL]
    assert ends_of(table1(), "right", 1.0)[0, tips + faces].all()
    thin = ends_of(table1(), "left", 1e-4)[0]
    assert np.flatnonzero(thin).tolist() == tips


def test_without_a_mesh_cycle_there_are_none() -> None:
    mountings = mounted(table1(), np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 400.0, 0.0]]))
    found = ends_of(mountings, "right")
    assert found.any(axis=1).tolist() == [True, False]
