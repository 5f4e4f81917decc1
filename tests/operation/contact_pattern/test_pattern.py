"""Contact patterns compared with dense scans, given motions and brute-force areas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from beveloid_geom import Design, Errors, Member, builtin_design, contact_pattern, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import path_ends
from beveloid_geom.gear.active_flank import place_at
from beveloid_geom.gear.flank import flank_patch, flank_point
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.operation.angular_clearance import angular_clearance, surface_of
from beveloid_geom.operation.contact_pattern.mating import Mating, mating_of
from beveloid_geom.operation.contact_pattern.minimum_separation import minimum_separation, separation_samples
from beveloid_geom.operation.contact_pattern.motion import Operation, first_contact_operation
from beveloid_geom.operation.contact_pattern.pattern import ContactPattern
from beveloid_geom.status import PatternStatus
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.stability.random_designs import random_designs

FLANKS = ("right", "left")
SEPARATION = 0.00635


def conjugate(design: Design, flank: str) -> Operation:
    """Return the motion of a pair without transmission error, from half a pitch before to half a pitch after
    its path of contact."""
    path, pitch = path_of_contact(design, flank, 3), 2.0 * np.pi / 29.0
    span = float(path.pinion_roll.min() - 0.5 * pitch), float(path.pinion_roll.max() + 0.5 * pitch)
    return Operation(span, lambda roll: path.gear_roll[0] + 29.0 / 45.0 * (path.pinion_roll[0] - roll))


def scanned(
    design: Design, flank: str, member: int, l: FloatArray, z: FloatArray, operation: Operation
) -> FloatArray:
    """Return the minimum separation of unmodified flanks by angular clearance at many rolls, refined
    around the minimum."""
    own, other = (surface_of(design.members[j], flank).joint for j in (member, 1 - member))

    def gap(roll: FloatArray) -> FloatArray:
        found = angular_clearance(
            design, flank, member, l[:, None], z[:, None], roll, operation.gear_roll(roll)
        )
        valid = found.inside & (found.other_l >= other) & (l[:, None] >= own)
        return np.asarray(np.where(valid, found.distance, np.inf))

    first, last = operation.span
    rolls = np.broadcast_to(np.linspace(first, last, 201), (len(l), 201))
    for _ in range(5):
        values = gap(rolls)
        at = np.take_along_axis(rolls, values.argmin(axis=1)[:, None], axis=1)
        step = rolls[:, 1:2] - rolls[:, :1]
        rolls = np.clip(at + step * np.linspace(-1.0, 1.0, 21), first, last)
    return np.asarray(values.min(axis=1))


def apart(mating: Mating, points: FloatArray, roll: float) -> FloatArray:
    """Return separations at one roll, infinite where the foot is not on the mating flank."""
    turned = mating.turned(np.array([roll]), mating.operation.gear_roll(np.array([roll])))
    return mating.distance_on_flank(mating.at(points, np.tile(turned, len(points))))


@pytest.mark.parametrize("member", [0, 1])
def test_least_separation_against_a_dense_scan(flank: str, member: int) -> None:
    design = table1((0.0, 0.0), Errors(offset=0.05, pinion_axial=0.2))
    operation, part = conjugate(design, flank), design.members[member]
    depth, face = np.meshgrid((-5.9, -5.2, -3.0, 0.0, 2.5, 5.5), (-0.5, -0.47, -0.2, 0.1, 0.45, 0.5))
    l, z = depth.ravel(), part.face_width * face.ravel()
    points = flank_point(part, flank, l, z=z)
    mating = mating_of(design, flank, member, operation)
    found = minimum_separation(mating, points)
    least, roll, status = found.least, found.roll, found.status
    assert np.array_equal(np.isnan(least), status == PatternStatus.NO_MATE)
    assert np.array_equal(np.isnan(roll), status == PatternStatus.NO_MATE)
    inner, edge = status == PatternStatus.STANDSTILL, status == PatternStatus.MATE_EDGE
    assert inner.sum() > 10
    wanted = scanned(design, flank, member, l, z, operation)
    assert np.abs(least - wanted)[inner].max() < 1e-8
    assert edge.sum() > 5
    dense = np.linspace(*operation.span, 1001)
    wanted = np.min([apart(mating, points[edge], at) for at in dense], axis=0)
    assert (least[edge] < wanted + 1e-9).all()
    assert (wanted - least[edge] < 2e-2).all()


def places(
    design: Design, flank: str, member: int, depth: tuple[float, ...], face: tuple[float, ...]
) -> FloatArray:
    """Return points (n, 3) on a grid between fractions of depth and face."""
    shares = np.meshgrid(*(np.linspace(low, high, int(n)) for low, high, n in (depth, face)))
    own = design.members[member]
    l, _, u = place_at(own, flank, shares[0].ravel(), shares[1].ravel())
    return flank_point(own, flank, l, u)


BETWEEN_SAMPLES = {
    "at a corner of the mate": (
        table1((0.0002, 0.0002), Errors(-0.134, -2e-4, -0.03, 0.12)),
        1,
        (0.07, 0.15, 33),
        (0.965, 0.985, 9),
    ),
    "on the mate twice": (
        builtin_design("awd-transfer").with_parabola(0.0, -0.0005),
        0,
        (0.68, 0.74, 31),
        (0.99, 1.0, 5),
    ),
}


@pytest.mark.parametrize("name", BETWEEN_SAMPLES)
def test_feet_between_samples(name: str) -> None:
    """Points whose foot is on the mate only between sampled rolls have the separation that a calculation at
    many rolls gives."""
    design, member, depth, face = BETWEEN_SAMPLES[name]
    operation, points = first_contact_operation(design, "right"), places(design, "right", member, depth, face)
    mating = mating_of(design, "right", member, operation)
    dense = np.linspace(*operation.span, 2001)
    wanted = np.min([apart(mating, points, at) for at in dense], axis=0)
    unseen = np.isfinite(wanted) & (separation_samples(mating, points).table.min(axis=0) > wanted + 5e-3)
    assert unseen.sum() > 5
    least = minimum_separation(mating, points).least[np.isfinite(wanted)]
    wanted = wanted[np.isfinite(wanted)]
    assert (least < wanted + 1e-9).all()
    assert (wanted - least < 5e-3).all()


def test_feet_next_to_the_ends_of_the_roll() -> None:
    """Feet between samples are also found between the first two or the last two sampled rolls."""
    design, member, depth, face = BETWEEN_SAMPLES["at a corner of the mate"]
    operation, points = first_contact_operation(design, "right"), places(design, "right", member, depth, face)
    mating = mating_of(design, "right", member, operation)
    dense = np.linspace(*operation.span, 2001)
    table = np.array([apart(mating, points, at) for at in dense])
    unseen = np.isfinite(table).any(axis=0) & np.isinf(separation_samples(mating, points).table).all(axis=0)
    assert unseen.any()
    points, place = points[unseen], np.searchsorted(mating.rolls, dense[table[:, unseen].argmin(axis=0)])
    for at in np.unique(place):
        for rolls in (mating.rolls[at - 1 :], mating.rolls[: at + 1]):
            found = minimum_separation(replace(mating, rolls=rolls), points[place == at]).least
            assert (found < table[:, unseen].min(axis=0)[place == at] + 1e-9).all()


@pytest.mark.parametrize("number", [6, 8])
def test_result_is_independent_of_the_samples(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    design, flank = table1((-0.0005, -0.0005)), "right"
    operation = first_contact_operation(design, flank)
    for member in (0, 1):
        points = places(design, flank, member, (0.0, 1.0, 41), (0.0, 1.0, 51))
        wanted = minimum_separation(mating_of(design, flank, member, operation), points)
        with monkeypatch.context() as patched:
            patched.setattr("beveloid_geom.operation.contact_pattern.mating.POSES_PER_PITCH", number)
            found = minimum_separation(mating_of(design, flank, member, operation), points)
        assert np.array_equal(found.status, wanted.status)
        assert np.allclose(found.least, wanted.least, rtol=0.0, atol=1e-9, equal_nan=True)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001), (0.0005, 0.0005)])
def test_samples_selected_from_coarse_grids(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola, Errors(offset=0.05, pinion_axial=0.2))
    found, operation = contact_pattern(design, flank), first_contact_operation(design, flank)
    for member, side in enumerate((found.pinion, found.gear)):
        wanted = minimum_separation(mating_of(design, flank, member, operation), side.points.reshape(-1, 3))
        assert np.array_equal(wanted.status, side.status.ravel())
        assert np.allclose(wanted.least, side.least.ravel(), rtol=0.0, atol=1e-11, equal_nan=True)


def test_accuracy_of_feet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Distances are accurate to 1e-9 mm on a pair for which the omission of the last steps, up to 1e-3
    modules, would change them by 5e-7 mm."""
    design = cases_of(random_designs("usual", 180, seed=77), 2)
    found = contact_pattern(design, "right").gear.least
    monkeypatch.setattr("beveloid_geom.operation.contact_pattern.mating.LAST_STEP_MODULES", 2e-8)
    assert np.nanmax(np.abs(contact_pattern(design, "right").gear.least - found)) < 1e-9


def test_the_slope_over_the_roll_is_that_of_the_separation(flank: str) -> None:
    design = table1((0.001, -0.001), Errors(offset=0.05, shaft_angle=1e-5))
    operation, roll = first_contact_operation(design, flank), np.linspace(-0.3, 0.3, 7)
    for member, part in enumerate(design.members):
        mating = mating_of(design, flank, member, operation)
        points = flank_point(part, flank, np.zeros(7), z=3.0)

        def rows(rolls: FloatArray, mating: Mating = mating, points: FloatArray = points) -> FloatArray:
            return mating.at(points, mating.turned(rolls, mating.operation.gear_roll(rolls)))

        slope = mating.slope(rows(roll), operation.motion(roll, roll + 1.0)[1])
        there, back = rows(roll + 1e-6), rows(roll - 1e-6)
        assert np.abs(slope).min() > 0.1
        assert np.abs(slope - 0.5e6 * (there[0] - back[0])).max() < 1e-4


def pattern(design: Design, flank: str) -> ContactPattern:
    return contact_pattern(design, flank, resolution=1.5)


@pytest.mark.slow
@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001), (0.001, 0.001)])
def test_flanks_in_operation_touch_and_do_not_overlap(flank: str, parabola: tuple[float, float]) -> None:
    found = pattern(table1(parabola), flank)
    for side, member in ((found.pinion, 0), (found.gear, 1)):
        assert -1e-9 < np.nanmin(side.least) < 1e-3
        assert np.array_equal(side.marked, side.least <= found.separation)
        assert np.array_equal(np.isnan(side.least), side.status == PatternStatus.NO_MATE)
        patch = flank_patch(table1(parabola).members[member], flank, side.l, z=side.z)
        assert np.abs(patch.point - side.points).max() < 1e-12
        known = np.isfinite(side.pinion_roll)
        assert (side.pinion_roll[known] >= found.roll_range[0]).all()
        assert (side.pinion_roll[known] <= found.roll_range[1]).all()


def area_by_l_and_z(member: Member, flank: str, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return the area of the flank for 1 mm of l and 1 mm of z."""
    patch = flank_patch(member, flank, l, z=z)
    along = patch.tangent_l - patch.tangent_u * (patch.tangent_l[..., 2:] / patch.tangent_u[..., 2:])
    return np.asarray(np.linalg.norm(np.cross(along, patch.tangent_u / patch.tangent_u[..., 2:]), axis=-1))


def whole_area(member: Member, flank: str) -> float:
    """Return the area of the active flank by Gauss quadrature over the tangents."""
    node, weight = np.polynomial.legendre.leggauss(12)
    half = 0.5 * float(member.face_width)
    z, low = half * node, float(root_parameter(member, "right"))
    high = tip_parameter(member, flank, z)
    size = area_by_l_and_z(member, flank, low + 0.5 * (node[:, None] + 1.0) * (high - low), z)
    return float((size * weight[:, None] * weight * 0.5 * (high - low) * half).sum())


def test_areas_follow_the_separation() -> None:
    """Marked fractions increase with the separation. At 0.2 mm the complete flank of the pinion is marked."""
    design = table1()
    sides = [contact_pattern(design, "right", s, resolution=1.5).pinion for s in (1e-4, 0.00635, 0.2)]
    shares = [side.area_share for side in sides]
    assert 0.0 < shares[0] < shares[1] < 1.0
    assert shares[2] == pytest.approx(1.0, abs=1e-12)
    assert sides[2].area == pytest.approx(whole_area(design.pinion, "right"), rel=1e-3)
    assert sides[1].area == pytest.approx(sides[2].area * shares[1], rel=1e-12)


def scanned_share(design: Design, flank: str, member: int, separation: float, lines: int) -> float:
    """Return the marked fraction of a flank by brute force: `lines` across the depth with 200 points each,
    interpolated crossings, weights from tangents."""
    part, operation = design.members[member], first_contact_operation(design, flank)
    z = float(part.face_width) * ((np.arange(lines) + 0.5) / lines - 0.5)
    root, tip = root_parameter(part, flank), tip_parameter(part, flank, z)
    l = root + np.linspace(0.0, 1.0, 200)[:, None] * (tip - root)
    size = area_by_l_and_z(part, flank, l, z) * (tip - root)
    mating = mating_of(design, flank, member, operation)
    blocks = np.array_split(flank_point(part, flank, l, z=z).reshape(-1, 3), 4)
    least = np.concatenate([minimum_separation(mating, block).least for block in blocks])
    root_of = np.where(np.isnan(least), 1e3, np.sqrt(np.maximum(least, 0.0))).reshape(l.shape)
    first, second = np.sqrt(separation) - root_of[:-1], np.sqrt(separation) - root_of[1:]
    inside = np.maximum(first, 0.0) + np.maximum(second, 0.0)
    part_inside = inside / np.maximum(np.abs(first) + np.abs(second), 1e-30)
    weight = 0.5 * (size[:-1] + size[1:])
    return float((weight * part_inside).sum() / weight.sum())


AREAS = {
    "large, cut by edges": (table1(), "right", 1, SEPARATION, 80),
    "strips along two edges": (table1((0.001, 0.001)), "right", 0, SEPARATION, 80),
    "strips along two edges, gear": (table1((0.001, 0.001)), "right", 1, SEPARATION, 80),
    "carried to the heel": (table1(errors=Errors(shaft_angle=-0.002)), "right", 1, SEPARATION, 160),
    "thin compound": (table1((0.001, -0.001)), "right", 0, 1e-3, 80),
    "narrow strip": (table1(), "left", 1, 3e-4, 80),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", AREAS)
def test_areas_are_within_their_bound(name: str) -> None:
    """Areas of the default grid and of a coarse grid differ from brute force, which is accurate to 0.3 %, by
    less than their bound."""
    design, flank, member, separation, lines = AREAS[name]
    wanted = scanned_share(design, flank, member, separation, lines)
    for resolution in (None, 10.0):
        found = contact_pattern(design, flank, separation, resolution=resolution)
        side = (found.pinion, found.gear)[member]
        assert side.area_error <= 0.01
        assert abs(side.area_share / wanted - 1.0) <= side.area_error + 0.003


@pytest.mark.parametrize("separation", [SEPARATION, 5e-4])
def test_area_and_border_do_not_depend_on_the_grid(flank: str, separation: float) -> None:
    """The border of the default grid separates the marked points of a fine grid from the others. Points
    nearer to it than 0.2 mm are not compared: the area has an error of 1 %."""
    design = table1((0.001, -0.001))
    coarse, fine = (contact_pattern(design, flank, separation, resolution=r) for r in (None, 0.4))
    for one, other in ((coarse.pinion, fine.pinion), (coarse.gear, fine.gear)):
        assert (one.area, one.area_share) == (other.area, other.area_share)
        points, border = side_view(other.points).reshape(-1, 2), [side_view(each) for each in one.border]
        inside = np.sum([Outline(ring).contains_points(points) for ring in border], axis=0) % 2 == 1
        near = np.linalg.norm(points[:, None] - along_sides(border), axis=-1).min(axis=1) < 0.2
        assert np.array_equal(inside[~near], other.marked.ravel()[~near])
        assert near.mean() < 0.3


def side_view(points: FloatArray) -> FloatArray:
    """Return z and radius (..., 2) of points (..., 3), mm."""
    return np.stack((points[..., 2], np.hypot(points[..., 0], points[..., 1])), axis=-1)


def along_sides(polygons: list[FloatArray]) -> FloatArray:
    """Return points (n, 2) on the sides of polygons."""
    ends = [(ring, np.roll(ring, -1, axis=0)) for ring in polygons]
    return np.concatenate([a + share * (b - a) for a, b in ends for share in np.linspace(0.0, 1.0, 20)])


def test_smaller_area_error() -> None:
    sides = [contact_pattern(table1(), "right", area_error=error).gear for error in (0.05, 0.002)]
    assert sides[1].area_error <= 0.002 < sides[0].area_error <= 0.05
    assert sides[0].area == pytest.approx(sides[1].area, rel=sides[0].area_error + 0.002)
    assert np.array_equal(sides[0].least, sides[1].least, equal_nan=True)


def test_density_follows_from_a_tolerance() -> None:
    """The error of the interpolated minimum separation halfway between points is about the tolerance, for
    a motion without kinks."""
    design, counts = table1(), []
    for tolerance in (5e-5, 2e-5):
        side = contact_pattern(design, "left", tolerance=tolerance).pinion
        counts.append(side.l.size)
        part = (side.status == PatternStatus.STANDSTILL) & (side.least < SEPARATION)
        bends = []
        for axis in (0, 1):
            rows, near = np.moveaxis(side.least, axis, 0), np.moveaxis(part, axis, 0)
            bend = np.abs(rows[:-2] - 2.0 * rows[1:-1] + rows[2:])[near[:-2] & near[1:-1] & near[2:]]
            bends.append(bend.max() / 8.0)
        assert 0.2 * tolerance < sum(bends) < 1.5 * tolerance
    assert counts[1] > 1.5 * counts[0]


def test_given_poses() -> None:
    design = table1()
    operation = conjugate(design, "left")
    roll = np.linspace(*operation.span, 40)
    gear_roll = operation.gear_roll(roll)
    wanted = pattern(design, "left")
    for order in (1, -1):
        found = contact_pattern(
            design,
            "left",
            resolution=1.5,
            pinion_roll=roll[::order],
            gear_roll=gear_roll[::order],
        )
        inner = found.pinion.status == PatternStatus.STANDSTILL
        assert np.abs(found.pinion.least - wanted.pinion.least)[inner].max() < 1e-8
    ends = path_ends(design, "left").pinion_roll
    middle = np.flatnonzero(np.abs(roll - ends.mean()) < 0.02)
    short = contact_pattern(
        design, "left", resolution=1.5, pinion_roll=roll[middle], gear_roll=gear_roll[middle]
    )
    cut = short.pinion.status == PatternStatus.END_OF_ROLL
    assert cut.sum() > 0.5 * cut.size
    assert (short.pinion.least[cut] > wanted.pinion.least[cut]).all()
    assert short.pinion.area < 0.5 * wanted.pinion.area


def test_edges_are_marked_where_the_path_is_off_the_flanks() -> None:
    """If the contact is moved off the toe, only the edge there is marked."""
    design = table1((0.0, 0.0), Errors(shaft_angle=0.0015))
    assert np.isnan(path_ends(design, "right").pinion_roll).all()
    found = pattern(design, "right").pinion
    assert -1e-9 < np.nanmin(found.least) < 1e-3
    assert found.marked.any()
    assert (found.status[found.marked] == PatternStatus.MATE_EDGE).any() or (
        np.abs(found.z[found.marked]).max() > 24.0
    )


def test_patterns_are_of_single_designs_with_a_known_first_contact() -> None:
    with pytest.raises(ValueError, match="a single design"):
        contact_pattern(table1((0.0, 0.0), Errors(offset=np.zeros(2))))
    with pytest.raises(ValueError, match=r"first contact .* at some rolls: a tip reaches the other"):
        contact_pattern(table1((0.0, 0.0), Errors(offset=-2.5)))
