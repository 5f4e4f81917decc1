"""Sign of the transmission error: positive where the gear is ahead, on both flanks."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design, first_contact, mesh_cycle, path_of_contact
from beveloid_geom.arrays import gear_sense
from beveloid_geom.pair.frames import layout_of
from tests.oracle.table1 import table1
from tests.stability.parallel_pairs import pair_of

DESIGNS = {
    "crossed": table1(),
    "intersecting": builtin_design("awd-transfer"),
    "crossed, marine": builtin_design("marine-gearbox"),
    "parallel, conical": builtin_design("anti-backlash"),
    "parallel, spur": pair_of(6.0, (29, 45), 0.0, 222.05),
}


def crowned(name: str) -> Design:
    """Return a pair with both members convex, by 0.0002 1/mm at the module of Table 1."""
    design = DESIGNS[name]
    a = -0.0002 * 6.0 / float(design.pinion.tool.normal_module)
    return design.with_parabola(a, a)


@pytest.mark.parametrize("name", DESIGNS)
def test_positive_error_moves_the_gear_away_from_the_pinion(name: str, flank: str) -> None:
    """With n out of the pinion's tooth, the driving pinion moves its flank along n. A gear that is ahead
    moves its flank along n as well, away from the pinion."""
    path = path_of_contact(crowned(name), flank, 9)
    layout = layout_of(path.design)
    k1, k2 = np.array((0.0, 0.0, 1.0)), np.array((0.0, float(layout.sin_angle), float(layout.cos_angle)))
    arm = path.point - (float(layout.offset), 0.0, 0.0)
    drives = np.sign(path.pinion_roll[-1] - path.pinion_roll[0])
    assert (drives * np.einsum("ni,ni->n", path.normal, np.cross(k1, path.point)) > 0.0).all()
    assert (gear_sense(flank) * np.einsum("ni,ni->n", path.normal, np.cross(k2, arm)) > 0.0).all()


@pytest.mark.parametrize("name", ["crossed", "intersecting", "crossed, marine", "parallel, spur"])
def test_the_curve_of_a_crowned_pair_has_a_maximum_on_both_flanks(name: str, flank: str) -> None:
    """The transmission error, computed from the rolls, has one maximum along the path: the gear lags at both
    ends. Helical teeth on parallel axes are left out, because they touch at one l1 with a constant ratio."""
    path = path_of_contact(crowned(name), flank, 51)
    ratio = float(path.design.pinion.teeth) / float(path.design.gear.teeth)
    sense = -np.sign(path.pinion_roll[-1] - path.pinion_roll[0])
    ahead = sense * (path.gear_roll + ratio * path.pinion_roll)
    np.testing.assert_allclose(path.transmission_error, ahead - ahead[25], rtol=0.0, atol=1e-13)
    top = int(path.transmission_error.argmax())
    assert 0 < top < 50
    assert (np.diff(path.transmission_error)[:top] > 0.0).all()
    assert (np.diff(path.transmission_error)[top:] < 0.0).all()


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize("parabola", [(-0.0002, -0.0002), (0.001, -0.001), (0.0003, 0.0002)])
def test_the_pair_furthest_ahead_is_in_contact(name: str, parabola: tuple[float, float], flank: str) -> None:
    """The curve in operation is the upper envelope of all tooth pairs, for convex and concave flanks, with
    edges."""
    scale = 6.0 / float(DESIGNS[name].pinion.tool.normal_module)
    design = DESIGNS[name].with_parabola(*(scale * a for a in parabola))
    cycle = mesh_cycle(design, flank, 2)
    roll = float(cycle.start) + cycle.pitch * (np.arange(8) + 0.3) / 8.0
    runs = first_contact(design, flank, roll)
    pairs = range(int(runs.pair.min()) - 2, int(runs.pair.max()) + 3)
    alone = np.array([first_contact(design, flank, roll, [k]).transmission_error for k in pairs])
    np.testing.assert_allclose(np.fmax.reduce(alone), runs.transmission_error, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(cycle.at(roll).transmission_error, runs.transmission_error, atol=1e-11)
    mean = first_contact(design, flank, cycle.start + cycle.pitch * np.arange(96) / 96.0)
    swing = float(cycle.peak_to_peak)
    assert float(cycle.mean) == pytest.approx(mean.transmission_error.mean(), abs=2e-3 * swing + 1e-13)
