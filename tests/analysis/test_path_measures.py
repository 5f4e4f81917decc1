"""Lengths, angles, locations and shifts of paths, as the paper's statements are measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import Errors, Member, path_of_contact, path_sensitivity
from beveloid_geom.analysis.path_measures import (
    SHIFTS,
    added_metal,
    concavity,
    measures_of,
    shifts,
    sweep,
)
from beveloid_geom.gear.flank import flank_point, half_thickness_angle
from beveloid_geom.gear.flank_limits import highest_parameter, root_parameter
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.misalignment import ERROR_NAMES

from ..oracle.table1 import table1

MODIFIED = (0.001, -0.001)


def test_lengths_and_angles_of_a_sweep() -> None:
    """Lengths, angles and locations of a sweep equal those of single paths with 1001 positions."""
    found = sweep(table1(), "right", (1, 1), 0.0002)
    for k in (0, 5, 20):
        design = table1((float(found.size[k]),) * 2)
        path = path_of_contact(design, "right", 1001)
        for j, (z, r) in enumerate(((path.pinion_z, path.pinion_r), (path.gear_z, path.gear_r))):
            length = np.hypot(np.diff(z), np.diff(r)).sum()
            assert found.paths.length["side view"][j, k] == pytest.approx(length, rel=1e-4)
            assert found.paths.length["on the tooth"][j, k] > length
            angle = math.degrees(math.atan((r[-1] - r[0]) / (z[-1] - z[0])))
            assert found.paths.angle["chord"][j, k] == pytest.approx(angle, abs=1e-9)
            tangent = math.degrees(math.atan((r[501] - r[499]) / (z[501] - z[499])))
            assert found.paths.angle["middle"][j, k] == pytest.approx(tangent, abs=0.05)
            assert found.paths.location["middle"][j, k] == pytest.approx(z[500], abs=1e-9)
            between = 0.5 * (z[0] + z[-1])
            assert found.paths.location["between ends"][j, k] == pytest.approx(between, abs=1e-9)
        assert found.paths.contact_ratio[k] == pytest.approx(float(path.ends.contact_ratio), abs=1e-12)


def test_the_length_on_the_tooth_of_an_unmodified_path_is_that_of_its_line() -> None:
    """In the frame of the rotating member, a point that moves along the line of action by s describes an
    involute: its velocity has a component from the rolling base radius, and a component along the face."""
    design = table1()
    path = path_of_contact(design, "right", 20001)
    length = measures_of(design.with_errors(Errors(offset=np.zeros(1))), "right").length["on the tooth"]
    for j, (z, r, roll) in enumerate(
        ((path.pinion_z, path.pinion_r, path.pinion_roll), (path.gear_z, path.gear_r, path.gear_roll))
    ):
        x, y = (path.point[:, 0], path.point[:, 1]) if j == 0 else _in_gear_frame(path.point)
        turned = np.unwrap(np.arctan2(y, x)) - roll
        arc = np.hypot(np.hypot(np.diff(r), 0.5 * (r[1:] + r[:-1]) * np.diff(turned)), np.diff(z)).sum()
        assert length[j, 0] == pytest.approx(arc, rel=1e-5)


def _in_gear_frame(point: Any) -> tuple[Any, Any]:
    """Return x and y (n,) in the gear-fixed frame of points (n, 3) in S_f, without errors."""
    angle = math.radians(15.0)
    return 229.0 - point[:, 0], point[:, 2] * math.sin(angle) - point[:, 1] * math.cos(angle)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), MODIFIED])
def test_shifts_under_small_errors_are_the_derivatives(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola)
    rates = path_sensitivity(design, flank)
    for k, (error, size) in enumerate(zip(ERROR_NAMES, (1e-3, 1e-6, 1e-2, 1e-2), strict=True)):
        found = shifts(design, flank, error, size)
        assert tuple(found) == SHIFTS
        for name, rate in (
            (SHIFTS[0], rates.face_shift_by),
            (SHIFTS[3], rates.square_shift_by),
            (SHIFTS[4], rates.z_by),
        ):
            slope = (found[name][:, 1] - found[name][:, 0]) / (2.0 * size)
            scale = np.abs(rate[1, :, k]).max()
            np.testing.assert_allclose(
                slope, rate[1, :, k], rtol=1e-4, atol=1e-4 * scale, err_msg=f"{error} {name}"
            )


def test_shift_at_equal_radius_and_perpendicular_to_the_path() -> None:
    design, size = table1(MODIFIED), 0.3
    found = shifts(design, "right", "offset", size)
    before = path_of_contact(design, "right", 801)
    after = path_of_contact(design.with_errors(Errors(offset=size)), "right", 801)
    for j, member in enumerate(("pinion", "gear")):
        z, r = getattr(before, f"{member}_z"), getattr(before, f"{member}_r")
        other = getattr(after, f"{member}_r")
        order = np.argsort(other)
        along = np.interp(r[400], other[order], getattr(after, f"{member}_z")[order]) - z[400]
        assert found[SHIFTS[1]][j, 1] == pytest.approx(along, abs=1e-3)
        angle = math.atan2(r[401] - r[399], z[401] - z[399])
        assert found[SHIFTS[2]][j, 1] == pytest.approx(along * abs(math.sin(angle)), rel=1e-3)


def test_concavity_follows_the_coefficient(flank: str) -> None:
    """Additional material and change of the curvature are proportional to a. The curvature changes by 1.4
    a to 2 a."""
    small, large = (concavity(table1(), flank, size) for size in (1e-5, 1e-4))
    for name, rows in small.items():
        np.testing.assert_allclose(large[name], 10.0 * rows, rtol=2e-2, err_msg=name)
        assert (rows[:, 0] > 0.0).all()
        assert (rows[:, 1] < 0.0).all()
    assert (np.abs(small["curvature of the profile"]) < 2e-5).all()
    assert (np.abs(small["curvature of the profile"]) > 1.4e-5).all()


@pytest.mark.parametrize("size", [0.01, -0.01])
def test_metal_is_that_at_equal_radius(flank: str, size: float) -> None:
    """The additional material equals the difference in thickness of both profiles at radii at which both have
    a point. The concave pinion is undercut, and its profile is shorter than the involute at both ends."""
    for plain, bent in zip(table1().members, table1((size, size)).members, strict=True):
        r, added = added_metal(plain, flank, size)
        assert (np.diff(r) > 0.0).all()
        tip = reference_radius(plain) + (plain.profile_shift + plain.tip_height) * 6.0
        assert r[-1] <= tip  # the tooth ends there at mid-face
        for k in range(5, r.size, 190):
            half = [half_thickness_angle(m, flank, at_radius(m, flank, r[k]), 0.0) for m in (plain, bent)]
            assert added[k] == pytest.approx(float(r[k] * (half[1] - half[0])), abs=2e-5)


def at_radius(member: Member, flank: str, r: float) -> float:
    """Return the largest flank parameter at which the profile at mid-face has a radius."""

    def beyond(l: float) -> float:
        x, y, _ = flank_point(member, flank, l, z=0.0)
        return math.hypot(x, y) - r

    high, low = float(highest_parameter(member, "right")), float(root_parameter(member, "right"))
    steps = np.linspace(high, low, 400)
    below = next(l for l in steps if beyond(l) < 0.0)
    return float(brentq(beyond, below, min(below + (high - low) / 399.0, high)))
