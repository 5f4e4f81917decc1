"""Different parabolas of right and left flanks, and a moved apex."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Member,
    Pair,
    Status,
    Tool,
    first_contact,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.arrays import FLANK_SIGN, Flank
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.fillet import fillet_point, tool_round
from beveloid_geom.gear.flank import base_cylinder, flank_patch
from beveloid_geom.gear.flank_limits import active_range
from beveloid_geom.gear.rack import parameter_at_height, section_point
from beveloid_geom.gear.tooth_side import cut_at, profile_at, surface_of
from tests.oracle.sixty_digits import off_by
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import random_designs

NUMBERS = ("l1", "u1", "l2", "u2", "pinion_roll", "gear_roll", "point", "normal", "transmission_error")
OWN = {"right": 0.001, "left": -0.0006}, {"right": -0.0008, "left": -0.0004}
"""Coefficients of pinion and gear, 1/mm."""


def with_tools(design: Design, *values: dict[str, Any]) -> Design:
    """Return the design with other values of the tools of pinion and gear."""
    pinion, gear = (
        replace(member, tool=replace(member.tool, **changes))
        for member, changes in zip(design.members, values, strict=True)
    )
    return replace(design, pinion=pinion, gear=gear)


def by_flank(design: Design, apex: tuple[float, float] = (0.0, 0.0)) -> Design:
    """Return the design with the coefficients OWN."""
    return with_tools(
        design,
        *(
            {"parabola_right": own["right"], "parabola_left": own["left"], "parabola_apex": l0}
            for own, l0 in zip(OWN, apex, strict=True)
        ),
    )


def assert_same_path(one: ContactPath, other: ContactPath, bound: float) -> None:
    """Check that all numbers of two paths differ by at most `bound`, mm and rad."""
    assert (one.ends.status, *one.ends.limit) == (other.ends.status, *other.ends.limit)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=0.0, atol=bound)


def test_each_flank_has_the_path_of_its_own_coefficient(flank: str) -> None:
    design = table1(errors=Errors(offset=0.02, shaft_angle=1e-4))
    both = design.with_parabola(*(own[flank] for own in OWN))
    one, other = path_of_contact(by_flank(design), flank, 41), path_of_contact(both, flank, 41)
    assert one.ends.status == Status.SOLVED
    assert_same_path(one, other, 1e-12)
    changed = path_of_contact(design.with_parabola(*(own["left"] for own in OWN)), "right", 41)
    assert np.abs(changed.point - path_of_contact(by_flank(design), "right", 41).point).max() > 0.1


def test_equal_coefficients_give_the_results_of_both_flanks_bit_by_bit(flank: str) -> None:
    design = table1((0.001, -0.001))
    equal = with_tools(
        design,
        {"parabola": 9.0, "parabola_right": 0.001, "parabola_left": 0.001},
        {"parabola": 9.0, "parabola_right": -0.001, "parabola_left": -0.001, "parabola_apex": 0.0},
    )
    paths = [path_of_contact(each, flank, 21) for each in (design, equal)]
    for name in NUMBERS:
        np.testing.assert_array_equal(getattr(paths[0], name), getattr(paths[1], name))
    cycles = [mesh_cycle(each, flank, 2) for each in (design, equal)]
    assert cycles[0].peak_to_peak == cycles[1].peak_to_peak
    one, other = (first_contact(each, flank, [0.0, 0.1]).gear_roll for each in (design, equal))
    np.testing.assert_array_equal(one, other)


def test_the_profile_is_a_parabola_about_the_apex(flank: str) -> None:
    tool = Tool(
        6.0, radians(20.0), parabola=0.5, parabola_right=0.004, parabola_left=-0.003, parabola_apex=2.0
    )
    l = np.linspace(-7.0, 5.0, 9)
    x, y = section_point(tool, flank, l).T
    # Along the straight flank from the reference line, and along its outward normal.
    sigma, (sin, cosine) = FLANK_SIGN[flank], (np.sin(radians(20.0)), np.cos(radians(20.0)))
    across = sigma * y - 0.25 * pi * 6.0
    np.testing.assert_allclose(x * cosine - across * sin, l + 2.0, atol=1e-14)
    coefficient = 0.004 if flank == "right" else -0.003
    np.testing.assert_allclose(x * sin + across * cosine, coefficient * l**2, atol=1e-14)
    at = parameter_at_height(tool, flank, 3.0)
    assert section_point(tool, flank, at)[0] == pytest.approx(3.0, abs=1e-14)


def test_without_a_coefficient_the_apex_changes_nothing(flank: str) -> None:
    design = table1(errors=Errors(offset=0.03))
    moved = with_tools(design, {"parabola_apex": 3.0}, {"parabola_apex": -2.0})
    one, other = path_of_contact(design, flank, 21), path_of_contact(moved, flank, 21)
    np.testing.assert_allclose(other.l1 + 3.0, one.l1, atol=1e-11)
    np.testing.assert_allclose(other.l2 - 2.0, one.l2, atol=1e-11)
    np.testing.assert_allclose(other.point, one.point, atol=1e-11)
    np.testing.assert_allclose(other.gear_roll, one.gear_roll, atol=1e-13)
    first, second = (first_contact(each, flank, [0.0, 0.1]).gear_roll for each in (design, moved))
    np.testing.assert_allclose(first, second, atol=1e-12)
    assert mesh_cycle(moved, flank, 1).peak_to_peak == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("apex", [0.0, 3.0, -2.5])
def test_flank_surface_and_fillet_have_the_same_points(flank: str, apex: float) -> None:
    member = by_flank(table1(), (apex, apex)).pinion
    surface, z = surface_of(member, flank), np.array([-20.0, 0.0, 20.0])
    assert surface.parabola == OWN[0][flank]
    low, high = (float(end) for end in active_range(member, flank))
    assert surface.joint == pytest.approx(low, abs=0.06)
    for l in (low + 0.1, 0.5 * (low + high), high - 0.1):
        patch = flank_patch(member, flank, np.full(3, l), z=z)
        cut = cut_at(surface, np.full(3, l), z)
        np.testing.assert_allclose(np.hypot(*patch.point[:, :2].T) ** 2, cut.square, rtol=1e-13)
        np.testing.assert_allclose(profile_at(surface, cut.square, z), l, atol=1e-9)
        found = feet(member, flank, patch.point + 0.01 * patch.normal)
        np.testing.assert_allclose(found.distance, 0.01, atol=1e-12)
        np.testing.assert_allclose(found.l, l, atol=1e-9)
    rounding = tool_round(member.tool, flank)
    point, normal = fillet_point(member, flank, rounding.angle, z)
    joint = np.full(3, rounding.joint)
    patch = flank_patch(member, flank, joint, z=z)
    np.testing.assert_allclose(point, patch.point, atol=1e-11)
    np.testing.assert_allclose(normal, patch.normal, atol=1e-12)


def test_batches_equal_single_designs(flank: str) -> None:
    rng = np.random.default_rng(31)
    values = [
        {
            name: rng.uniform(-size, size, 4)
            for name, size in (("parabola_right", 1e-3), ("parabola_left", 1e-3), ("parabola_apex", 3.0))
        }
        for _ in range(2)
    ]
    batch = path_of_contact(with_tools(table1(), *values), flank, 5)
    assert batch.l1.shape == (4, 5)
    for k in range(4):
        one = with_tools(
            table1(), *({name: float(rows[k]) for name, rows in each.items()} for each in values)
        )
        np.testing.assert_allclose(batch.point[k], path_of_contact(one, flank, 5).point, atol=1e-10)
    mixed = path_of_contact(
        with_tools(table1(), {"parabola_right": values[0]["parabola_right"]}, {}), "left", 5
    )
    np.testing.assert_allclose(
        mixed.point, np.broadcast_to(path_of_contact(table1(), "left", 5).point, (4, 5, 3)), atol=1e-10
    )


def spur_pair(parabola: float, apex: float) -> Design:
    """Return spur gears on parallel axes; only the gear has parabolas."""
    tool = Tool(4.0, radians(20.0))
    pinion = Member(tool, 24, 0.0, 0.0, 0.1, 20.0)
    bent = replace(tool, parabola_right=parabola, parabola_left=0.0, parabola_apex=apex)
    gear = Member(bent, 37, 0.0, 0.0, -0.1, 20.0)
    return Design(pinion, gear, Pair(122.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("apex", [0.0, 1.5, -2.0])
def test_transmission_error_of_a_spur_gear(apex: float) -> None:
    """The transmission error times r_b2 is the deviation a (l - l0)^2 of the gear, up to terms in a^2."""
    worst = []
    for a in (-1e-4, -5e-5):
        path = path_of_contact(spur_pair(a, apex), "right", 41)
        assert path.ends.status == Status.SOLVED
        base = float(base_cylinder(path.design.gear, "right").radius)
        assert base == pytest.approx(74.0 * cos(radians(20.0)))
        plain = path_of_contact(spur_pair(0.0, apex), "right", 41)
        ratio = 24.0 / 37.0
        phase = path.gear_roll + ratio * path.pinion_roll
        unmodified = plain.gear_roll + ratio * plain.pinion_roll
        error = (phase - unmodified[0]) * base
        np.testing.assert_allclose(unmodified, unmodified[0], atol=1e-14)
        deviation = np.abs(a) * path.l2**2
        sense = np.sign((error * deviation).sum())
        assert deviation.max() > 3e-4
        worst.append(np.abs(sense * error - deviation).max())
    assert worst[1] < 3e-6
    assert worst[1] == pytest.approx(0.25 * worst[0], rel=0.05)


def test_the_limit_of_the_apex_is_the_flank_of_the_tool() -> None:
    member = by_flank(table1(), (6.0, 0.0)).pinion
    assert parabola_limit(member) < parabola_limit(table1().pinion)
    most = parabola_limit(member)
    for sign in (-1.0, 1.0):
        bent = replace(member, tool=replace(member.tool, parabola_right=sign * most))
        assert np.isfinite(active_range(bent, "right")).all()


def random_tools(design: Design, rng: np.random.Generator) -> Design:
    """Return a batch with random coefficients of both flanks and a random apex on the tool."""
    changes = []
    for member in design.members:
        module = np.asarray(member.tool.normal_module)
        size = module.size
        own = {
            name: rng.uniform(-0.004, 0.004, size) / module for name in ("parabola_right", "parabola_left")
        }
        changes.append(own | {"parabola_apex": rng.uniform(-0.9, 0.9, size) * module})
    return with_tools(design, *changes)


@pytest.mark.slow
def test_five_equations_at_sixty_digits_on_random_designs(flank: Flank) -> None:
    designs = random_tools(random_designs("usual", 260, seed=31, flank=flank), np.random.default_rng(31))
    path = path_of_contact(designs, flank, 3)
    solved = np.flatnonzero(path.ends.status == Status.SOLVED)[:200]
    assert solved.size == 200
    apart = np.empty((200, 2))
    for row, k in enumerate(solved.tolist()):
        one: ContactPath = cases_of(path, k)
        apart[row] = off_by(one, 1)
    # Near line contact (n_x about 0.1 and below), rounding moves the contact further.
    assert apart[:, 0].max() < 5e-11
    assert np.count_nonzero(apart[:, 0] < 1e-11) >= 198
    assert apart[:, 1].max() < 1e-12
