"""Different parabolas of right and left flanks, and a moved apex."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Status,
    Tool,
    contact_pattern,
    first_contact,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.arrays import FLANK_SIGN, Flank
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.fillet import fillet_point, tool_round
from beveloid_geom.gear.flank import flank_patch
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


def test_the_limit_of_the_apex_is_the_flank_of_the_tool() -> None:
    member = by_flank(table1(), (6.0, 0.0)).pinion
    assert parabola_limit(member) < parabola_limit(table1().pinion)
    most = parabola_limit(member)
    for sign in (-1.0, 1.0):
        bent = replace(member, tool=replace(member.tool, parabola_right=sign * most))
        assert np.isfinite(active_range(bent, "right")).all()


def test_patterns_use_the_parabola_of_their_flank(flank: str) -> None:
    design = table1()
    both = design.with_parabola(*(own[flank] for own in OWN))
    one, other = (contact_pattern(each, flank).pinion.area for each in (by_flank(design), both))
    assert one == pytest.approx(other, rel=1e-9)


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
