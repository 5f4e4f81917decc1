"""Modified spur gears on parallel axes, in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    FirstStatus,
    Limit,
    Member,
    Modification,
    Pair,
    Tool,
    contact_pattern,
    from_degrees,
    mesh_cycle,
)
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.operation.angular_clearance import angular_clearance

WIDTH = 30.0


def spur_pair(pinion: Modification | None = None, gear: Modification | None = None) -> Design:
    """Return 25/40 teeth with a module of 3 mm and backlash."""
    tool = from_degrees(Tool, normal_module=3.0, normal_pressure_angle_deg=20.0)
    members = [Member(tool, teeth, 0.0, 0.0, 0.0, WIDTH) for teeth in (25, 40)]
    return Design(members[0].modified(pinion), members[1].modified(gear), Pair(97.6, 0.0))


def test_helix_slope_leaves_a_gap_at_one_end(flank: str) -> None:
    """A positive slope removes material at +z and leaves it at -z: the edge at -z is in contact, and the
    gap at +z is the slope."""
    design = spur_pair(Modification(helix_slope_um=12.0))
    cycle = mesh_cycle(design, flank)
    assert cycle.status == FirstStatus.SOLVED
    assert cycle.peak_to_peak < 1e-12
    assert cycle.edge_share > 1.0 - 1e-9
    first = cycle.at(cycle.start + cycle.pitch * np.array((0.2, 0.7)))
    assert np.isin(first.limit, (Limit.PINION_TOE, Limit.GEAR_TOE)).any(axis=-1).all()
    assert np.abs(first.z1 + 0.5 * WIDTH).max() < 1e-9
    ends = np.array((-0.5, 0.0, 0.5)) * WIDTH
    gap = angular_clearance(
        design, flank, 0, first.l1[0], ends, first.pinion_roll[0], first.gear_roll[0], first.pair[0]
    ).distance
    assert np.abs(gap - (0.0, 0.006, 0.012)).max() < 1e-5


@pytest.mark.parametrize("crowning", [5.0, 20.0])
def test_length_of_the_pattern_of_a_crowned_gear(crowning: float, flank: str) -> None:
    """A film s marks the length b sqrt(s / C) of a flank with the crowning C."""
    film = 0.002
    design = spur_pair(gear=Modification(helix_crowning_um=crowning))
    cycle = mesh_cycle(design, flank)
    assert cycle.peak_to_peak < 1e-12
    assert cycle.edge_share == 0.0
    pattern = contact_pattern(design, flank, film).pinion
    row = pattern.least.shape[0] // 2
    root, z = np.sqrt(np.maximum(pattern.least[row], 0.0)), pattern.z[row]
    length = 2.0 * float(np.interp(np.sqrt(film), root[z >= 0.0], z[z >= 0.0]))
    expected = WIDTH * np.sqrt(1e3 * film / crowning)
    assert abs(length - expected) < 0.003 * expected


def test_small_crowning_continues_the_unmodified_pair(flank: str) -> None:
    """Line contact becomes point contact; the roll of the gear and the transmission error are continuous."""
    plain = mesh_cycle(spur_pair(), flank)
    roll = plain.start + plain.pitch * np.array((0.1, 0.6))
    for crowning in (1e-1, 1e-3, 1e-6):
        cycle = mesh_cycle(spur_pair(Modification(helix_crowning_um=crowning)), flank)
        assert cycle.status == FirstStatus.SOLVED
        assert cycle.peak_to_peak < 1e-12
        assert np.abs(cycle.at(roll).gear_roll - plain.at(roll).gear_roll).max() < 1e-12


@pytest.mark.parametrize("crowning", [8.0, 0.8])
def test_profile_crowning_is_the_transmission_error(crowning: float, flank: str) -> None:
    """The gear lags by C lam^2 / r_b2 at the point of contact. The contact moves to a neighbouring point,
    which changes this by terms of the second order in C."""
    design = spur_pair(gear=Modification(profile_crowning_um=crowning))
    cycle = mesh_cycle(design, flank)
    first = cycle.at(cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 7))
    low = float(root_parameter(design.gear, flank))
    high = float(tip_parameter(design.gear, flank, 0.0))
    lam = 2.0 * (first.l2 - low) / (high - low) - 1.0
    assert (np.abs(lam) < 0.95).sum() > 3
    lag = -first.transmission_error * 0.5 * 3.0 * 40 * np.cos(np.radians(20.0))
    off = np.abs(lag - 1e-3 * crowning * lam**2)[np.abs(lam) < 0.95]
    assert off.max() < 5e-5 * (crowning / 8.0) ** 2
