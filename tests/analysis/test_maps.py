"""Maps of a design: cells against single designs, symmetries, the paper's numbers, and their figures."""

from __future__ import annotations

from dataclasses import replace
from math import cos, nan, radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Status,
    Tool,
    map_of,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.analysis.maps import (
    FIGURES,
    OVER,
    DesignMap,
    Over,
    design_at,
    own_values,
    usual_bounds,
)
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.operation.backlash_by_tangency import tangent_backlash
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.map import MapReport, cell_words, quadrant_bests, ratio_as_given
from beveloid_viz.figures.results import maps as fig_maps
from beveloid_viz.stage import theme
from tests.oracle.table1 import table1
from tests.viz.pages import page_of

OFFSET = Errors(offset=0.05)
MODIFIED = (0.001, -0.001)
BOUNDS = {"parabola": (-0.0006, 0.0004), "mounting": (-45.0, 30.0), "shift": (-0.2, 0.4)}


def small_map(design: Design, over: Over, flank: str = "right", **more: Any) -> DesignMap:
    more = {"pinion": BOUNDS[over], "gear": BOUNDS[over], "steps": 4, "errors": OFFSET, **more}
    return map_of(design, over, flank, **more)


def expected(cell: Design, flank: str) -> dict[str, float]:
    """Figures of one cell by paths of single designs; the shift by hand."""
    path = path_of_contact(cell, flank, 17)
    backlash = float(mounting_of(cell).normal_backlash)
    play = float(tangent_backlash(cell).normal)
    if path.l1.size == 0:
        return dict.fromkeys(FIGURES, nan) | {"normal_backlash": backlash, "mounted_backlash": play}
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


@pytest.mark.slow
@pytest.mark.parametrize("over", OVER)
def test_cells_are_those_of_single_designs(over: Over, flank: str) -> None:
    design = table1() if over == "parabola" else table1(MODIFIED)
    found = small_map(design, over, flank)
    assert found.status.shape == (4, 4)
    for i, j in np.ndindex(4, 4):
        cell = design_at(design, over, float(found.pinion[i]), float(found.gear[j]))
        wanted = expected(cell, flank)
        assert found.status[i, j] == path_of_contact(cell, flank, 3).ends.status
        for name in FIGURES:
            value = getattr(found, name)[i, j]
            rough = {"peak_to_peak": 1e-7}.get(name, 1e-9)  # by a parabola through three of 17 positions
            np.testing.assert_allclose(value, wanted[name], rtol=1e-9, atol=rough, err_msg=name)
    lost = found.status == Status.OFF_FLANK
    assert lost.any() or over != "mounting"
    assert (np.isnan(found.contact_ratio) == lost).all()


def test_jammed_cells_are_not_sound() -> None:
    """With an offset error the layout has backlash and the pair none."""
    found = map_of(table1(errors=Errors(offset=-0.1)), "shift", steps=3, errors=OFFSET)
    assert (found.mounted_backlash < found.normal_backlash).all()
    assert (found.jammed & ~found.interferes).any()
    assert not (found.sound & found.jammed).any()


def test_the_papers_numbers() -> None:
    """To both ends of its Figs. 9 to 11, and half-way there the modified pair of its Figs. 12 to 15."""
    found = map_of(table1(), "parabola", steps=5, errors=OFFSET)
    np.testing.assert_allclose(found.pinion, [-0.002, -0.001, 0.0, 0.001, 0.002], atol=1e-18)
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
    """Without parabolas the path is the same line; the more the shift, the less the backlash."""
    found = small_map(table1(), "shift", flank="left")
    assert np.ptp(found.shift) < 1e-9
    assert (np.diff(found.normal_backlash, axis=0) < 0.0).all()
    np.testing.assert_array_equal(found.interferes, found.normal_backlash < 0.0)
    np.testing.assert_array_equal(found.sound, found.solved & ~found.interferes)
    cell = design_at(table1(), "shift", 0.3, 0.4)
    assert (cell.pinion.profile_shift, cell.gear.profile_shift) == (0.3, 0.4)
    np.testing.assert_allclose(mounting_of(cell).distance, mounting_of(table1()).distance, atol=1e-9)


def test_mounting_moves_the_flanks_under_the_path() -> None:
    found = small_map(table1(), "mounting", pinion=(-5.0, 5.0), gear=(-5.0, 5.0), steps=3)
    slope = (found.centre[2, 1] - found.centre[0, 1]) / 10.0
    assert -1.0 <= slope < -0.9  # the place in space is kept, but for the change of the ends
    cell = design_at(table1(), "mounting", 5.0, 0.0)
    assert cell.pair.pinion_mounting == pytest.approx(float(mounting_of(table1()).distance[0]) + 5.0)


def test_cells_in_operation_have_their_mesh_cycle() -> None:
    done: list[int] = []
    found = map_of(table1(), "parabola", steps=3, errors=OFFSET, operation=True, progress=done.append)
    assert done == [1] * 9
    for i, j in np.ndindex(3, 3):
        cycle = mesh_cycle(table1((float(found.pinion[i]), float(found.gear[j]))), "right")
        assert found.edge_share[i, j] == pytest.approx(float(cycle.edge_share), abs=1e-9)
        assert found.cycle_peak_to_peak[i, j] == pytest.approx(float(cycle.peak_to_peak), abs=1e-10)
    assert np.isfinite(found.edge_share).all()
    assert found.edge_share[2, 2] > 0.5 > found.edge_share[0, 0] > found.edge_share[1, 0] == 0.0


def test_cells_whose_rounds_overlap_are_not_known_in_operation(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*arguments: Any) -> None:
        raise ValueError("rounds overlap")

    monkeypatch.setattr("beveloid_geom.analysis.maps.mesh_cycle", refused)
    found = map_of(table1(), "parabola", steps=2, errors=OFFSET, operation=True)
    assert found.solved.all()
    assert np.isnan([found.edge_share, found.cycle_peak_to_peak]).all()
    assert "edge_share" not in MapReport("Table 1", found).rows()


def test_bests_of_quadrants_are_sound_cells_that_reach_the_ratio() -> None:
    near = (-0.001, 0.001)
    found = map_of(table1(), "parabola", pinion=near, gear=near, steps=9, errors=OFFSET)
    for ratio in (1.6, 0.5):
        bests = quadrant_bests(found, ratio)
        assert np.isnan(bests["C1"][1])
        for name, cells in found.quadrants().items():
            good = cells & ~found.hollow & (found.contact_ratio >= ratio)
            assert bests[name][0] == good.sum()
            assert bests[name][1] == found.shift[good].min(initial=np.inf) or name == "C1"


def test_blocks_and_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[int] = []
    whole = small_map(table1(), "mounting")
    monkeypatch.setattr("beveloid_geom.analysis.maps.CELLS", 5)
    parts = small_map(table1(), "mounting", progress=done.append)
    assert done == [5, 5, 5, 1]
    for name in FIGURES:
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), atol=1e-9)


@pytest.mark.parametrize(
    ("over", "changes", "words"),
    [
        ("colour", {}, "over must be one of parabola, mounting, shift"),
        ("parabola", {"steps": 1}, "steps must be 2 to 201, a whole number, got 1"),
        ("parabola", {"steps": 2.5}, "steps must be 2 to 201, a whole number, got 2.5"),
        ("mounting", {"pinion": (-1.7e308, 1.7e308)}, "bounds of the pinion must be two finite values"),
        ("parabola", {"pinion": (0.0, 0.0)}, "bounds of the pinion must be two finite values that rise"),
        ("mounting", {"gear": (0.0, nan)}, "bounds of the gear must be two finite values that rise"),
        ("parabola", {"gear": (-0.1, 0.0)}, r"\[gear\] parabola must be between"),
        ("shift", {"gear": (0.0, 4.0)}, "profile shift of the gear must be between -3 and 3"),
        ("shift", {"errors": Errors()}, "one of them not 0"),
        ("shift", {"errors": Errors(offset=300.0)}, "error of offset must be less than 60 on this pair"),
    ],
)
def test_wrong_maps_are_refused(over: Any, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        map_of(table1(), over, **changes)


def test_a_batch_is_refused() -> None:
    with pytest.raises(ValueError, match="single design"):
        map_of(table1((np.zeros(2), 0.0)), "parabola")  # type: ignore[arg-type]


def test_usual_bounds_hold_the_design() -> None:
    low, high = usual_bounds(table1((0.004, 0.0)), "parabola")[0]
    assert low == -0.004
    assert high == 0.004
    steep = replace(table1().pinion, helix_angle=radians(35.0), cone_angle=radians(30.0))
    assert usual_bounds(replace(table1(), pinion=steep), "parabola")[0][1] == parabola_limit(steep) < 0.001
    np.testing.assert_allclose(usual_bounds(table1(), "shift"), [(-0.13, 0.47), (-0.0819, 0.5181)])


def test_marks_are_where_they_belong(monkeypatch: pytest.MonkeyPatch) -> None:
    """The recommended quadrant is framed: pinion's coefficient positive, gear's negative."""
    monkeypatch.setattr(fig_maps, "STEPS_IN_OPERATION", 5)
    data = fig_maps.compute("parabola", table1())
    page = page_of(fig_maps.draw, data, (800, 600))
    note = " ".join(" ".join(text.get_text() for text in page.texts).split())
    assert "under offset \u00b10.05 mm, shaft angle \u00b10.01 deg" in note
    assert "(f) is the share of a mesh cycle that edges carry" in note
    assert "the least shift is " in note
    (legend,) = page.legends
    assert [text.get_text() for text in legend.get_texts()][-1] == "hollow against each other"
    for axes in page.axes[:6]:
        frames = [line for line in axes.lines if line.get_color() == theme.RED]
        (frame,) = frames
        x, y = np.asarray(frame.get_xdata(), dtype=float), np.asarray(frame.get_ydata(), dtype=float)
        assert (x.min(), x.max()) == (0.0, 0.002)
        assert (y.min(), y.max()) == (-0.002, 0.0)


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
