"""Maps of a design: cells compared with single designs, symmetries, numbers of the paper, and results."""

from __future__ import annotations

from dataclasses import replace
from math import cos, nan, radians, sin
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Modification,
    Pair,
    Status,
    Tool,
    design_map,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.analysis.maps import (
    QUANTITIES,
    DesignMap,
    usual_bounds,
)
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.operation.backlash_by_tangency import tangent_backlash
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.named_inputs import PRESETS, design_at, own_values
from beveloid_geom.report.map import MapReport, cell_words, quadrant_bests
from tests.oracle.table1 import table1

OFFSET = Errors(offset=0.05)
MODIFIED = (0.001, -0.001)
BOUNDS = {"parabola": (-0.0006, 0.0004), "mounting": (-45.0, 30.0), "shift": (-0.2, 0.4)}


def small_map(design: Design, over: str, flank: str = "right", **more: Any) -> DesignMap:
    more = {"first": BOUNDS[over], "second": BOUNDS[over], "steps": 4, "errors": OFFSET, **more}
    return design_map(design, over, flank, **more)


def expected(cell: Design, flank: str) -> dict[str, float]:
    """Return the results of one cell from paths of single designs, with the shift computed here."""
    path = path_of_contact(cell, flank, 17)
    backlash = float(mounting_of(cell).normal_backlash)
    play = float(tangent_backlash(cell).normal)
    if path.l1.size == 0:
        return dict.fromkeys(QUANTITIES, nan) | {"normal_backlash": backlash, "mounted_backlash": play}
    along = np.array([path.pinion_z[9] - path.pinion_z[7], path.l1[9] - path.l1[7]])
    squares = []
    for sign in (1.0, -1.0):
        other = path_of_contact(cell.with_errors(Errors(offset=sign * 0.05)), flank, 17)
        if other.l1.size == 0:
            squares.append(nan)
            continue
        move = np.array([other.pinion_z[8] - path.pinion_z[8], other.l1[8] - path.l1[8]])
        squares.append(((move[0] * along[1] - move[1] * along[0]) / np.hypot(*along)) ** 2)
    z, r = path.pinion_z, path.pinion_r
    return {
        "contact_ratio": float(path.ends.contact_ratio),
        "angle": float(np.arctan((r[-1] - r[0]) / (z[-1] - z[0]))),
        "shift": float(np.sqrt(np.mean(squares))),
        "peak_to_peak": float(np.ptp(path_of_contact(cell, flank, 2001).transmission_error)),
        "centre": float(z[8]),
        "normal_backlash": backlash,
        "mounted_backlash": play,
    }


def assert_cells(found: DesignMap, over: str | tuple[str, str], flank: str, bound: float) -> None:
    """Check that each cell has the results of the single design."""
    for i, j in np.ndindex(found.status.shape):
        cell = design_at(found.design, over, float(found.first[i]), float(found.second[j]))
        wanted = expected(cell, flank)
        assert found.status[i, j] == path_of_contact(cell, flank, 3).ends.status
        for name in QUANTITIES:
            value = getattr(found, name)[i, j]
            rough = {"peak_to_peak": 1e-7}.get(name, bound)  # by a parabola through three of 17 positions
            np.testing.assert_allclose(value, wanted[name], rtol=bound, atol=rough, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("over", list(PRESETS))
def test_cells_equal_single_designs(over: str, flank: str) -> None:
    design = table1() if over == "parabola" else table1(MODIFIED)
    found = small_map(design, over, flank)
    assert found.status.shape == (4, 4)
    assert_cells(found, over, flank, 1e-9)
    lost = found.status == Status.OFF_FLANK
    assert lost.any() or over != "mounting"
    assert (np.isnan(found.contact_ratio) == lost).all()


def test_cells_of_crowned_flanks_equal_single_designs(flank: str) -> None:
    design = table1()
    design = replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=10.0)))
    found = small_map(design, "parabola", flank, first=(-0.0006, 0.0), second=(0.0, 0.0004), steps=2)
    assert_cells(found, "parabola", flank, 1e-8)


def test_jammed_cells_are_not_sound() -> None:
    """Under an offset error, the layout has backlash but the mounted pair has none: its cells are jammed and
    not sound."""
    found = design_map(table1(errors=Errors(offset=-0.1)), "shift", steps=3, errors=OFFSET)
    assert (found.mounted_backlash < found.normal_backlash).all()
    assert (found.jammed & ~found.interferes).any()
    assert not (found.sound & found.jammed).any()


def test_the_papers_numbers() -> None:
    """Cells of a map have the known contact ratios of Table 1 without and with the modification of Figs. 12
    to 15. The cells are divided evenly into the four cases of the paper."""
    found = design_map(table1(), "parabola", steps=5, errors=OFFSET)
    np.testing.assert_allclose(found.first, [-0.002, -0.001, 0.0, 0.001, 0.002], atol=1e-18)
    assert found.contact_ratio[2, 2] == pytest.approx(1.651001, abs=5e-7)
    assert found.contact_ratio[3, 1] == pytest.approx(1.816308, abs=5e-7)
    assert found.peak_to_peak[2, 2] < 1e-13
    assert float(found.normal_backlash[0, 0]) == pytest.approx(0.0416, abs=5e-5)
    assert own_values(table1(), "parabola") == (0.0, 0.0)
    assert list(found.hollow.sum(axis=1)) == [0, 1, 2, 3, 4]
    assert {name: int(cells.sum()) for name, cells in found.quadrants().items()} == dict.fromkeys(
        ("C1", "C2", "C3", "C4"), 4
    )
    assert found.quadrants()["C3"][4, 0]


def test_shift_holds_the_layout_and_changes_the_backlash() -> None:
    """Over the profile shift, a map keeps the layout. Without parabolas the path is the same line; a larger
    shift reduces the backlash."""
    found = small_map(table1(), "shift", flank="left")
    assert np.ptp(found.shift) < 1e-9
    assert (np.diff(found.normal_backlash, axis=0) < 0.0).all()
    np.testing.assert_array_equal(found.interferes, found.normal_backlash < 0.0)
    np.testing.assert_array_equal(found.sound, found.solved & ~found.interferes)
    cell = design_at(table1(), "shift", 0.3, 0.4)
    assert (cell.pinion.profile_shift, cell.gear.profile_shift) == (0.3, 0.4)
    np.testing.assert_allclose(mounting_of(cell).distance, mounting_of(table1()).distance, atol=1e-9)


def test_mounting_moves_the_flanks_under_the_path() -> None:
    found = small_map(table1(), "mounting", first=(-5.0, 5.0), second=(-5.0, 5.0), steps=3)
    slope = (found.centre[2, 1] - found.centre[0, 1]) / 10.0
    assert -1.0 <= slope < -0.9  # the position in space is constant, except for the change of the ends
    cell = design_at(table1(), "mounting", 5.0, 0.0)
    assert cell.pair.pinion_mounting == pytest.approx(float(mounting_of(table1()).distance[0]) + 5.0)


def test_cells_in_operation_have_their_mesh_cycle() -> None:
    done: list[int] = []
    found = design_map(table1(), "parabola", steps=3, errors=OFFSET, operation=True, progress=done.append)
    assert done == [1] * 9
    for i, j in np.ndindex(3, 3):
        cycle = mesh_cycle(table1((float(found.first[i]), float(found.second[j]))), "right")
        assert found.edge_share[i, j] == pytest.approx(float(cycle.edge_share), abs=1e-9)
        assert found.cycle_peak_to_peak[i, j] == pytest.approx(float(cycle.peak_to_peak), abs=1e-10)
    assert np.isfinite(found.edge_share).all()
    assert found.edge_share[2, 2] > 0.5 > found.edge_share[0, 0] > found.edge_share[1, 0] == 0.0


def test_best_cells_of_quadrants_are_sound_and_reach_the_ratio() -> None:
    near = (-0.001, 0.001)
    found = design_map(table1(), "parabola", first=near, second=near, steps=9, errors=OFFSET)
    for ratio in (1.6, 0.5):
        bests = quadrant_bests(found, ratio)
        assert np.isnan(bests["C1"][1])
        for name, cells in found.quadrants().items():
            good = cells & ~found.hollow & (found.contact_ratio >= ratio)
            assert bests[name][0] == good.sum()
            assert bests[name][1] == found.shift[good].min(initial=np.inf) or name == "C1"


def test_a_map_over_offset_and_shaft_angle() -> None:
    """Cells equal single designs, and their backlash follows from the layout. There are no default bounds."""
    layout, first = ("offset", "shaft_angle"), (228.95, 229.05)
    second = (radians(14.99), radians(15.01))
    found = design_map(table1(MODIFIED), layout, steps=3, errors=OFFSET, first=first, second=second)
    assert_cells(found, layout, "right", 1e-9)
    assert design_at(found.design, layout, 228.95, second[1]).pair == Pair(228.95, second[1])
    assert MapReport("Table 1", found.design, found).rows()["shaft_angle"][1] == pytest.approx(radians(15.0))
    assert "over the offset and shaft_angle" in MapReport("Table 1", found.design, found).summary()
    with pytest.raises(ValueError, match="bounds of shaft_angle must be given"):
        design_map(table1(), layout, first=first)


def test_usual_bounds_include_the_design() -> None:
    low, high = usual_bounds(table1((0.004, 0.0)), "parabola")[0]
    assert low == -0.004
    assert high == 0.004
    steep = replace(table1().pinion, helix_angle=radians(35.0), cone_angle=radians(30.0))
    assert usual_bounds(replace(table1(), pinion=steep), "parabola")[0][1] == parabola_limit(steep) < 0.001
    np.testing.assert_allclose(usual_bounds(table1(), "shift"), [(-0.13, 0.47), (-0.0819, 0.5181)])


def test_cells_with_the_sum_0_are_not_hollow() -> None:
    found = design_map(table1(), "parabola", steps=3, errors=OFFSET)
    pinion = np.linspace(0.0, 0.0007, 8)
    fine = replace(found, first=pinion, second=np.linspace(-0.0007, 0.0, 8), status=np.zeros((8, 8), np.int8))
    assert np.add.outer(fine.first, fine.second)[::-1].diagonal().any()  # rounding
    np.testing.assert_array_equal(fine.hollow[::-1], np.triu(np.ones((8, 8)), 1))


def crossed_helical(pressure_deg: float) -> Design:
    """Return cylindrical gears with helix angles of 30 and 20 deg without backlash."""
    tool = Tool(6.0, radians(pressure_deg), tip_radius=0.2)
    pinion, gear = (Member(tool, n, radians(beta), 0.0, 0.0, 60.0) for n, beta in ((20, 30), (30, 20)))
    offset = 60.0 / cos(radians(30)) + 90.0 / cos(radians(20))
    return Design(pinion, gear, Pair(offset, radians(50.0)))


@pytest.mark.parametrize("over", ["shift", "mounting"])
def test_backlash_is_continuous_beyond_half_a_pitch(over: str) -> None:
    """The backlash of crossed helical gears is -2 m_n sin(alpha) (x1 + x2) for any mounting."""
    found = small_map(crossed_helical(30.0), over, first=(-1.2, 1.2), second=(-1.2, 1.2), steps=5)
    wanted = -6.0 * np.add.outer(found.first, found.second) * (over == "shift")
    np.testing.assert_allclose(found.normal_backlash, wanted, atol=1e-9)
    if over == "shift":
        assert np.abs(wanted).max() > 0.5 * np.pi * 6.0 * cos(radians(30.0))
        np.testing.assert_array_equal(found.interferes[found.solved], (wanted < -1e-9)[found.solved])


def test_backlash_at_half_a_pitch_is_continued_in_both_directions() -> None:
    design = crossed_helical(30.0)
    design = replace(design, pinion=replace(design.pinion, profile_shift=1.36))
    found = small_map(design, "shift", first=(1.0, 1.7), second=(-0.3, 0.2), steps=3)
    np.testing.assert_allclose(
        found.normal_backlash, -6.0 * np.add.outer(found.first, found.second), atol=1e-9
    )


def test_a_path_may_be_a_single_point() -> None:
    design = crossed_helical(25.0)
    # The round of the tool begins one addendum deep, where the mate's tip just reaches.
    tool = replace(design.pinion.tool, tip_radius=0.25 / (1.0 - sin(radians(25.0))))
    design = replace(design, pinion=replace(design.pinion, tool=tool), gear=replace(design.gear, tool=tool))
    found = small_map(design, "shift", first=(0.2, 1.2), second=(0.8, 1.8), steps=2)
    assert found.contact_ratio[1, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_change_of_mounting_is_an_axial_error() -> None:
    """This also holds for a design whose given mounting distances are not those of the pitch point."""
    fixed = replace(table1(MODIFIED), pair=replace(table1().pair, pinion_mounting=215.0, gear_mounting=208.0))
    found = small_map(fixed, "mounting", first=(-4.0, 4.0), second=(-3.0, 3.0), steps=2)
    for i, j in np.ndindex(2, 2):
        errors = Errors(pinion_axial=float(found.first[i]), gear_axial=float(found.second[j]))
        path = path_of_contact(fixed.with_errors(errors), "right", 3)
        assert found.contact_ratio[i, j] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
        assert found.centre[i, j] == pytest.approx(float(path.pinion_z[1]), abs=1e-9)


def test_each_cell_has_its_own_reason() -> None:
    skewed = replace(table1(), pair=replace(table1().pair, shaft_angle=radians(10.0)))
    assert (design_map(skewed, "parabola", steps=2, errors=OFFSET).status == Status.UNDEFINED).all()
    found = small_map(table1(), "mounting")
    assert (found.status == Status.OFF_FLANK).any()
    lost = int((found.solved & np.isnan(found.shift)).sum())
    assert f"in {lost} an error moves the path off" in cell_words(found) or lost == 0
    few = replace(found, shift=np.where(found.solved, 1.0, np.nan))
    assert "moves the path off" not in cell_words(few)


def test_the_table_has_the_magnitude_of_the_angle() -> None:
    found = design_map(table1(), "parabola", steps=3, errors=OFFSET)
    one, other = (replace(found, angle=sign * found.angle) for sign in (1.0, -1.0))
    assert MapReport("", one.design, one).summary() == MapReport("", one.design, other).summary()


def test_a_design_reaches_its_own_ratio() -> None:
    """The cell with the coefficients of the design counts as one with at least the contact ratio of the
    design, although the ratio differs by rounding if it is solved in a batch."""
    for coefficients in ((0.001, -0.0015), (0.0004, -0.0004), (0.0002, -0.0003)):
        design, (first, second) = table1(coefficients), coefficients
        found = design_map(
            design, "parabola", "left", first=(0.0, first), second=(second, 0.0), steps=2, errors=OFFSET
        )
        assert (
            quadrant_bests(found, float(path_of_contact(design, "left", 2).ends.contact_ratio))["C3"][0] == 1
        )


def test_faults_that_a_design_has_anyway_are_not_those_of_the_bounds() -> None:
    tool = replace(table1().pinion.tool, tip_radius=1.3)
    design = replace(table1(), pinion=replace(table1().pinion, tool=tool))
    assert design_map(design, "parabola", steps=2, errors=OFFSET).solved.any()


def test_maps_set_both_flanks_and_move_the_apex() -> None:
    pinion = table1().pinion
    tool = replace(pinion.tool, parabola_right=0.001, parabola_left=-0.001)
    design = replace(table1(), pinion=replace(pinion, tool=tool))
    assert own_values(design, "parabola", "left") == (-0.001, 0.0)
    changed = design_at(design, "parabola", 0.0005, 0.0).pinion.tool
    assert (changed.parabola_of("right"), changed.parabola_of("left")) == (0.0005, 0.0005)
    moved = design_at(design, ("parabola_apex_pinion", "offset"), 1.5, 229.0)
    assert moved.pinion.tool == replace(tool, parabola_apex=1.5)
    assert usual_bounds(design, ("parabola_apex_pinion", "parabola_apex_gear"))[0] == (-6.0, 6.0)
