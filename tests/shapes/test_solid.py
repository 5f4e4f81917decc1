"""Closed solids: topology, shape and number of triangles, distance from the exact surfaces, volume."""

from __future__ import annotations

from dataclasses import replace
from math import acos, ceil, pi, radians
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq

from beveloid_geom import Member, gear_solid
from beveloid_geom.arrays import FloatArray, Indices
from beveloid_geom.gear.fillet import root_radius
from beveloid_geom.gear.flank import tip_thickness
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.shapes.section import SIDES
from beveloid_geom.shapes.solid import NAMES, Solid, rotated_copies
from beveloid_geom.shapes.tooth_boundary import cut_sheets, outline_grids
from tests.members import GEAR, OTHERS as MEMBERS, PINION, SPUR
from tests.oracle.surface_distance import distance_bound, inside_triangles
from tests.oracle.tooth_volume import exact_volume

angles: Any = trimesh.triangles.angles

all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)


def smallest_angle_deg(solid: Solid) -> float:
    return float(np.degrees(angles(solid.points[solid.faces])).min())


def assert_closed(solid: Solid, holes: int) -> None:
    """Check that each edge is in two faces, once in each direction, that all points are used, and that the
    solid has the given number of holes."""
    mesh = solid.to_trimesh()
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert mesh.euler_number == 2 - 2 * holes
    assert mesh.body_count == 1
    np.testing.assert_array_equal(np.unique(solid.faces), np.arange(len(solid.points)))


def test_default_tolerance_and_names_in_trimesh() -> None:
    solid = gear_solid(PINION, teeth=2)
    np.testing.assert_array_equal(solid.points, gear_solid(PINION, 0.01, 2).points)
    mesh = solid.to_trimesh()
    np.testing.assert_array_equal(mesh.vertices, solid.points)
    np.testing.assert_array_equal(mesh.faces, solid.faces)
    named = np.array(mesh.metadata["names"])[mesh.face_attributes["part"]]
    # The heel is the end face at +z of a pinion with a positive cone angle.
    heel = mesh.triangles_center[named == "heel"]
    np.testing.assert_allclose(heel[:, 2], 0.5 * float(PINION.face_width))


@pytest.mark.parametrize("name", ["pinion", "left-hand", "cylindrical", "spur", "narrow", "sharp tool"])
def test_one_tooth_and_two_are_closed(name: str) -> None:
    member = MEMBERS[name]
    one, two = (gear_solid(member, 0.05, teeth) for teeth in (1, 2))
    assert_closed(one, 0)
    assert_closed(two, 0)
    assert two.to_trimesh().volume == pytest.approx(2.0 * one.to_trimesh().volume, rel=1e-12)
    assert np.array_equal(np.unique(one.part), np.arange(len(NAMES)))


@pytest.mark.parametrize("name", ["gear", "left-hand", "cylindrical", "spur"])
def test_complete_gears_are_closed(name: str) -> None:
    member = MEMBERS[name]
    whole, some = gear_solid(member, 0.05), gear_solid(member, 0.05, int(member.teeth))
    assert_closed(whole, 1)
    assert_closed(some, 1)
    np.testing.assert_array_equal(some.faces, whole.faces)
    assert not np.isin(whole.part, [NAMES.index(side) for side in SIDES]).any()
    assert whole.to_trimesh().volume == pytest.approx(some.to_trimesh().volume, rel=1e-12)


FINE = ("pinion", "convex", "spur", "spur cone", "steep", "steep helix", "few teeth")
SLIVER_CASES = [(name, tolerance) for name in MEMBERS for tolerance in (0.1, 0.01)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "tolerance"), SLIVER_CASES + [(name, 0.001) for name in FINE])
def test_no_triangle_is_a_sliver(name: str, tolerance: float) -> None:
    solid = gear_solid(MEMBERS[name], tolerance, 1)
    assert smallest_angle_deg(solid) > 1.0


@pytest.mark.parametrize("share", [0.02, 0.97])
def test_a_small_or_a_large_bore_causes_no_slivers(share: float) -> None:
    for member in (SPUR, PINION):
        solid = gear_solid(member, 0.05, 1, share * float(root_radius(member, -25.0)))
        assert smallest_angle_deg(solid) > 1.0
        assert_closed(solid, 0)


@pytest.mark.slow
@all_members
def test_triangles_stay_within_the_tolerance(member: Member) -> None:
    sheets = cut_sheets(member)
    for name, grid in outline_grids(sheets, 0.01).items():
        assert distance_bound(sheets[name], *inside_triangles(grid, grid.parameter, 3)).max() <= 0.01, name


def test_the_grids_are_those_of_the_solid() -> None:
    """The corners of flanks and fillets of a solid are the points of their grids."""
    solid, grids = gear_solid(GEAR, 0.01, 1), outline_grids(cut_sheets(GEAR), 0.01)
    for name in ("left flank", "right flank", "left fillet", "right fillet"):
        corners = solid.points[np.unique(solid.faces[solid.part == NAMES.index(name)])]
        expected = grids[name].points.reshape(-1, 3)
        for points in (corners, expected):
            points[...] = points[np.lexsort(np.round(points, 6).T)]
        np.testing.assert_allclose(corners, expected, atol=1e-9)


@all_members
def test_surfaces_have_their_positions(member: Member) -> None:
    solid, half = gear_solid(member, 0.02, 2, 20.0), 0.5 * float(member.face_width)

    def of(name: str) -> FloatArray:
        return np.asarray(solid.points[np.unique(solid.faces[solid.part == NAMES.index(name)])])

    np.testing.assert_array_equal(of("toe")[:, 2], -half)
    np.testing.assert_array_equal(of("heel")[:, 2], half)
    np.testing.assert_allclose(np.hypot(*of("bore")[:, :2].T), 20.0, rtol=1e-12)
    tip = of("tip")
    np.testing.assert_allclose(np.hypot(*tip[:, :2].T), tip_radius(member, tip[:, 2]), rtol=1e-12)
    first, last = (of(name) for name in SIDES)
    shifted = rotated_copies(first, np.array([4.0 * pi / float(member.teeth)]))[0]
    for points in (shifted, last):
        points[...] = points[np.lexsort(np.round(points, 5).T)]
    np.testing.assert_allclose(shifted, last, atol=1e-9)


@pytest.mark.parametrize("name", [*MEMBERS, "300 teeth"])
@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_flat_and_round_faces_have_few_triangles(name: str, tolerance: float) -> None:
    """End faces with n points on the rim have n - 2 triangles or more. The bore has the fewest possible
    chords."""
    member = MEMBERS.get(name, replace(PINION, teeth=300))
    solid, pitch = gear_solid(member, tolerance, 1, 25.0), 2.0 * pi / float(member.teeth)

    def triangles(name: str) -> Indices:
        return np.asarray(solid.faces[solid.part == NAMES.index(name)])

    for end in ("toe", "heel"):
        others = solid.faces[solid.part != NAMES.index(end)]
        rim = np.intersect1d(triangles(end), others)
        assert len(triangles(end)) < 1.25 * len(rim)
    bored = np.intersect1d(triangles("bore"), triangles("toe"))
    assert len(bored) == 1 + ceil(pitch / (2.0 * acos(1.0 - tolerance / 25.0)))


def test_the_bore_is_round_to_the_tolerance() -> None:
    solid = gear_solid(Member(PINION.tool, 12, 0.1, 0.02, 0.6, 20.0), 0.001, 1, 28.0)
    bore = solid.faces[solid.part == NAMES.index("bore")]
    middles = solid.points[bore[:, :2]].mean(axis=1)
    assert np.hypot(*middles[:, :2].T).min() > 28.0 - 0.001


@pytest.mark.parametrize("name", ["pinion", "gear", "steep helix", "few teeth"])
@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_cut_sides_hold_the_tolerance(name: str, tolerance: float) -> None:
    """Points on the triangles of a cut side are within the tolerance of the radial line through the middle of
    the tooth space."""
    solid, bottom = gear_solid(MEMBERS[name], tolerance, 1), cut_sheets(MEMBERS[name])["left bottom"]
    faces = solid.faces[solid.part == NAMES.index(SIDES[0])]
    weights = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4.0
    x, y, z = (weights @ solid.points[faces]).reshape(-1, 3).T
    middle = bottom.place(bottom.lower(z), z)[0]
    away = (middle[:, 0] * y - middle[:, 1] * x) / np.hypot(middle[:, 0], middle[:, 1])
    assert np.abs(away).max() <= tolerance


@pytest.mark.parametrize("name", ["pinion", "gear", "spur", "convex", "steep helix", "few teeth"])
def test_volume_is_that_of_the_exact_surfaces(name: str) -> None:
    """The volume of one tooth tends to that of the exact surfaces. Complete gears are multiples of it, as
    tested above."""
    member, errors = MEMBERS[name], []
    exact = exact_volume(member, 1, 20.0)
    for tolerance in (0.01, 0.001):
        errors.append(abs(gear_solid(member, tolerance, 1, 20.0).to_trimesh().volume / exact - 1.0))
    assert errors[1] < 1e-5
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"teeth": 9, "profile_shift": 0.9}, r"the tooth is pointed at z = 25 mm, its flanks cross"),
        (
            {"teeth": 8, "cone_angle": radians(20.0), "profile_shift": -0.5, "face_width": 60.0},
            r"the right flank is undercut from z = -30 to 22.49 mm, and removed completely at z = -30 mm",
        ),
        (
            {"tool": replace(PINION.tool, parabola=0.01)},
            "tip_radius 0.38 is too large: the tool's tip rounds",
        ),
    ],
)
def test_invalid_teeth_are_rejected(changed: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        gear_solid(replace(PINION, **changed), 0.05)  # type: ignore[arg-type]


def test_a_pointed_tip_is_rejected() -> None:
    def member(shift: float) -> Member:
        return Member(PINION.tool, 12, 0.1, 0.0, shift, 20.0)

    shift = brentq(lambda shift: float(tip_thickness(member(shift), 0.0)) - 0.06, 0.6, 0.9)
    message = r"is pointed at z = .*: its tip is 0.06 mm thick, it must be at least"
    with pytest.raises(ValueError, match=message):
        gear_solid(member(shift + 1e-6), 0.1, 1)
    for tolerance in (0.1, 0.01):
        solid = gear_solid(member(shift - 1e-6), tolerance, 1)
        assert smallest_angle_deg(solid) > 1.0


def test_a_bore_may_be_at_the_limits_that_messages_show() -> None:
    for bore in (1.76387, 87.5934):
        solid = gear_solid(PINION, 0.05, 1, bore)
        assert smallest_angle_deg(solid) > 1.0
        assert len(solid.faces) < 15_000


def test_a_fillet_that_vanishes_at_one_end_is_rejected() -> None:
    """A fillet that nearly vanishes at the heel is rejected, because cells that fit the toe are slivers at
    the heel, and good cells would take 11 million triangles."""
    tool = replace(PINION.tool, normal_module=9.36, normal_pressure_angle=radians(30.0), tip_radius=0.0)
    member = Member(tool, 58, radians(33.0), radians(7.1), 0.0, 93.6)
    with pytest.raises(ValueError, match=r"fillet is only 0.178 mm wide at z = 46.8 mm.* increase the tip"):
        gear_solid(member, 0.0187)
    round_ = replace(member, tool=replace(tool, tip_radius=0.05))
    assert len(gear_solid(round_, 0.0187, 1).faces) < 25_000


def test_too_fine_a_tolerance_is_rejected() -> None:
    message = r"tolerance 4e-06 mm for 29 teeth needs about 2.\de\+07 points and \d(\.\d)? GB of"
    with pytest.raises(ValueError, match=message):
        gear_solid(PINION, 4e-6)
