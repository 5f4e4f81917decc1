"""Frames, pitch point, mounting and backlash: Table 1 against 60 digits and symmetry, and other layouts.

The other layouts are computed without backlash in closed form, independently of the contact solver. Both
flanks must touch at the pitch point, near mid-face, and satisfy the five equations. The wrong sign of n_x
would move the contact by hundreds of mm.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from numpy.typing import NDArray

from beveloid_geom import Design, Errors, Member, Pair, Tool, path_of_contact
from beveloid_geom.pair.frames import common_normal, layout_of, member_frame, normals_to_fixed, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from tests.contact.test_path import five_equation_residual
from tests.oracle.pitch_point_mp import mounting_mp
from tests.oracle.table1 import table1
from tests.stability.answers import closed
from tests.symmetry import exchanged, mirrored, scaled


def test_table_1() -> None:
    mounting = mounting_of(table1())
    assert abs(mounting.gap) == pytest.approx(2.210908, abs=1e-6)
    assert mounting.normal_backlash == pytest.approx(0.0415892, abs=1e-7)


def test_agrees_with_60_digits() -> None:
    exact, ours = mounting_mp(table1()), mounting_of(table1())
    assert ours.distance == pytest.approx([float(exact.dw1), float(exact.dw2)], abs=1e-10)
    assert ours.working_radius == pytest.approx([float(exact.rw1), float(exact.rw2)], abs=1e-10)
    np.testing.assert_allclose(ours.pitch_point, [float(x) for x in exact.pitch_point], atol=1e-10)


def test_neither_errors_nor_parabola_move_the_mounting() -> None:
    plain = mounting_of(table1())
    other = mounting_of(table1((0.001, -0.001), Errors(0.5, 0.001, 1.0, -1.0)))
    assert np.array_equal(plain.distance, other.distance)
    assert np.array_equal(plain.normal_backlash, other.normal_backlash)


def test_given_mounting_distances_are_used() -> None:
    design = replace(table1(), pair=Pair(229.0, table1().pair.shaft_angle, 200.0))
    mounting = mounting_of(design)
    assert mounting.distance == pytest.approx([200.0, 210.211869], abs=1e-6)
    assert mounting.pitch_distance == pytest.approx([211.594669, 210.211869], abs=1e-6)


def test_exchange_mirror_and_scale() -> None:
    design = table1()
    plain, swapped = mounting_of(design), mounting_of(exchanged(design))
    np.testing.assert_allclose(swapped.distance, plain.distance[::-1], rtol=1e-13)
    np.testing.assert_allclose(swapped.working_radius, plain.working_radius[::-1], rtol=1e-13)
    assert swapped.normal_backlash == pytest.approx(plain.normal_backlash, abs=1e-12)
    mirror, big = mounting_of(mirrored(design)), mounting_of(scaled(design, 10.0))
    np.testing.assert_allclose(mirror.distance, plain.distance, rtol=1e-13)
    np.testing.assert_allclose(big.distance, 10.0 * plain.distance, rtol=1e-12)
    assert mirror.normal_backlash == pytest.approx(plain.normal_backlash, abs=1e-12)
    assert big.normal_backlash == pytest.approx(10.0 * plain.normal_backlash, abs=1e-11)


def frames(design: Design) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    return [member_frame(layout_of(design), j, 0.3, 200.0) for j in (0, 1)]


def test_frames_are_right_handed_and_on_their_axes() -> None:
    design = table1(errors=Errors(offset=0.5, shaft_angle=0.01))
    angle = np.radians(15.0) + 0.01
    for rotation, _ in frames(design):
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
    on_axis = np.array([0.0, 0.0, 10.0])
    np.testing.assert_allclose(to_fixed(frames(design)[0], on_axis), [0.0, 0.0, 210.0])
    expected = [229.5, 210.0 * np.sin(angle), 210.0 * np.cos(angle)]
    np.testing.assert_allclose(to_fixed(frames(design)[1], on_axis), expected)


def test_a_positive_roll_is_about_the_axis_of_the_member() -> None:
    layout = layout_of(table1())
    for j in (0, 1):
        turned, straight = (member_frame(layout, j, roll, 0.0)[0] for roll in (0.2, 0.0))
        axis = straight[:, 2]
        spin = turned @ straight.T
        assert np.trace(spin) == pytest.approx(1.0 + 2.0 * np.cos(0.2))
        np.testing.assert_allclose(spin @ axis, axis, atol=1e-15)
        assert np.cross(straight[:, 0], spin @ straight[:, 0]) @ axis == pytest.approx(np.sin(0.2))


@pytest.mark.parametrize("degrees", [15.0, -15.0, 90.0, 1e-5])
def test_common_normal_has_the_given_axial_components(degrees: float) -> None:
    design = replace(table1(), pair=Pair(229.0, np.radians(degrees)))
    layout = layout_of(design)
    turn = np.radians(degrees)
    v = np.array([-0.4, 0.4 + 0.3 * np.sin(turn)])
    normal = common_normal(layout, v)
    n = np.array([np.sqrt(normal.x_squared), normal.y[0], v[0]])
    assert n @ n == pytest.approx(1.0, abs=1e-12)
    assert n @ [0.0, np.sin(turn), np.cos(turn)] == pytest.approx(-v[1], abs=1e-12)
    y2 = np.array([0.0, -np.cos(turn), np.sin(turn)])  # k2 x (-x)
    assert -n @ y2 == pytest.approx(normal.y[1], abs=1e-9)
    assert np.allclose(normals_to_fixed(member_frame(layout, 1, 0.0, 0.0), np.eye(3)[1]), y2)


# teeth, helix and cone angle in deg of pinion and gear
LAYOUTS = {
    "table 1": ((29, 25.0, 3.0), (45, -10.57, 0.8)),
    "cylindrical pinion": ((29, 25.0, 0.0), (45, -10.57, 1.5)),
    "cylindrical gear": ((29, 25.0, 3.0), (45, -10.57, 0.0)),
    "both cylindrical": ((29, 25.0, 0.0), (45, -10.57, 0.0)),
    "steep": ((29, 25.0, 6.0), (45, -10.57, 4.0)),
    "steeper": ((31, 20.0, 9.0), (40, -5.0, 8.0)),
    "same hand": ((25, 15.0, 2.0), (34, 12.0, 1.0)),
    "same hand, steep": ((25, 15.0, 7.0), (34, 12.0, 6.0)),
    "same hand, 90 deg": ((19, 45.0, 1.0), (19, 44.0, 1.0)),
    "straight gear": ((29, 20.0, 3.0), (45, 0.0, 3.0)),
}


def laid_out(name: str) -> Design:
    tool = Tool(6.0, radians(20.0))
    pinion, gear = (
        Member(tool, teeth, radians(helix), radians(cone), shift, 40.0)
        for (teeth, helix, cone), shift in zip(LAYOUTS[name], (0.2, 0.1), strict=True)
    )
    return closed(pinion, gear)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.0005, -0.0005)])
@pytest.mark.parametrize("name", LAYOUTS)
def test_contact_is_near_the_pitch_point(name: str, parabola: tuple[float, float], flank: str) -> None:
    design = laid_out(name).with_parabola(*parabola)
    for variant, side in (
        (design, flank),
        (exchanged(design), flank),
        (mirrored(design), {"right": "left", "left": "right"}[flank]),
    ):
        path = path_of_contact(variant, side, 21)
        assert path.l1.size == 21
        assert five_equation_residual(variant, path) < 1e-9
        reach = np.linalg.norm(path.point - mounting_of(variant).pitch_point, axis=-1)
        assert reach.min() < 2.0
        assert 0.9 < path.ends.contact_ratio < 2.5
        assert np.ptp(path.transmission_error) < (1e-12 if parabola[0] == 0.0 else 1e-3)


def test_a_layout_with_negative_n_x_is_included() -> None:
    """One flank of the steep layouts has n_x < 0."""
    assert any(mounting_of(laid_out(name)).branch.min() < 0.0 for name in LAYOUTS)
