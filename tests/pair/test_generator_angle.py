"""The angle between the generators, against generators computed from points of the flanks."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Pair, builtin_design, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.pair.frames import layout_of, member_frame, normals_to_fixed
from beveloid_geom.pair.generator_angle import closed_normal, generator_angle_as_mounted
from beveloid_geom.pair.mounting import mounting_of
from tests.pair.test_zero_backlash import DESIGNS, without_backlash

FLANKS = ("right", "left")


def generators(design: Design, flank: str) -> list[FloatArray]:
    """Return the directions in S_f, in the middle of the path, in which the normals of both flanks are
    constant.
    """
    path = path_of_contact(design, flank, 3)
    layout, distance = layout_of(design), mounting_of(design).distance
    found = []
    for j, (member, l, u, roll) in enumerate(
        zip(
            design.members,
            (path.l1[1], path.l2[1]),
            (path.u1[1], path.u2[1]),
            (path.pinion_roll[1], path.gear_roll[1]),
            strict=True,
        )
    ):
        step = 1e-4
        by_l, by_u = (
            (
                flank_patch(member, flank, l + a, u + b).normal
                - flank_patch(member, flank, l - a, u - b).normal
            )
            for a, b in ((step, 0.0), (0.0, step))
        )
        patch = flank_patch(member, flank, l, u)
        # The flank is developable, so that both derivatives are parallel.
        along = patch.tangent_l * (by_l @ by_u) - patch.tangent_u * (by_l @ by_l)
        frame = member_frame(layout, j, roll, distance[j])
        found.append(normals_to_fixed(frame, along / np.linalg.norm(along)))
    return found


@pytest.mark.parametrize("name", ["table 1", "left hand", "steep cones", "thin end outside", "two tools"])
def test_angle_between_generators_from_flank_points(name: str, flank: str) -> None:
    layout, design = without_backlash(DESIGNS[name])
    first, second = generators(design, flank)
    between = float(np.linalg.norm(np.cross(first, second)))
    assert between > 1e-3
    assert abs(np.sin(generator_angle_as_mounted(design, flank))) == pytest.approx(between, abs=1e-7)
    _, angle = closed_normal(layout, flank, design.sense)
    assert float(angle) == pytest.approx(float(generator_angle_as_mounted(design, flank)), abs=1e-9)


def test_table_1() -> None:
    angles = [degrees(generator_angle_as_mounted(builtin_design(), flank)) for flank in FLANKS]
    assert angles == pytest.approx([2.2957, 9.3266], abs=5e-5)


def test_crossed_helical_gears_in_closed_form() -> None:
    """n_x is sin(a_w) on both flanks. The sine of the angle follows from n_x and the axial components of the
    normals, cos(a_w) sin(b_w)."""
    layout, design = without_backlash(DESIGNS["cylindrical"])
    for flank in FLANKS:
        normal_x, angle = closed_normal(layout, flank, design.sense)
        assert float(normal_x) == pytest.approx(float(np.sin(layout.pressure_angle)), abs=1e-12)
        base = [np.cos(layout.pressure_angle) * np.sin(b) for b in layout.helix_angle]
        expected = (
            float(normal_x) * np.sin(layout.shaft_angle) / np.sqrt(np.prod([1.0 - b * b for b in base]))
        )
        assert np.sin(float(angle)) == pytest.approx(float(expected), abs=1e-12)


def test_without_a_common_normal_there_is_none() -> None:
    lost = replace(builtin_design(), pair=Pair(229.0, radians(5.0)))
    assert np.isnan(generator_angle_as_mounted(lost, "right"))


def test_generators_on_parallel_axes_do_not_cross() -> None:
    tilted = builtin_design("anti-backlash").with_errors(Errors(shaft_angle=radians(0.01)))
    for flank in FLANKS:
        assert generator_angle_as_mounted(tilted, flank) == 0.0
    unlike = replace(tilted, gear=replace(tilted.gear, cone_angle=radians(-4.0)))
    assert np.isnan(generator_angle_as_mounted(unlike, "right"))
