"""Ease-off: 0 for conjugate flanks; brute force along the normal, parabolas, transmission error, pattern."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians

import numpy as np
import pytest
from scipy.optimize import minimize_scalar, root

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Status,
    Tool,
    contact_pattern,
    ease_off,
    path_of_contact,
)
from beveloid_geom.analysis.ease_off import ease_off_at, second_order_of
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import frames_at, meshing_pair
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.flank import flank_patch, flank_point, trace_parameter
from beveloid_geom.pair.frames import layout_of, normals_to_fixed, to_fixed
from beveloid_geom.status import PatternStatus
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.stability.named_designs import CROSSING
from tests.stability.random_designs import random_designs

MODIFIED = (0.001, -0.001)


def helical(shaft_angle: float, helix: float, shifts: tuple[float, float] = (0.0, 0.0)) -> Design:
    """Return two helical gears (module 4, 20 deg) on nearly parallel axes."""
    tool = Tool(4.0, radians(20.0))
    helices = shaft_angle / 2.0 + helix, shaft_angle / 2.0 - helix
    pinion, gear = (
        Member(tool, n, beta, 0.0, x, 30.0) for n, beta, x in zip((23, 37), helices, shifts, strict=True)
    )
    offset = 2.0 * 23 / cos(helices[0]) + 2.0 * 37 / cos(helices[1])
    return Design(pinion, gear, Pair(offset, shaft_angle, 0.0, 0.0))


@pytest.mark.parametrize("helix", [0.0, radians(15.0), radians(-25.0)])
@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.2, -0.2)])
def test_conjugate_flanks_have_no_ease_off(flank: str, helix: float, shifts: tuple[float, float]) -> None:
    """In the limit of parallel axes, helical gears touch along lines and the ease-off is 0 everywhere. Before
    the limit it is proportional to the square of the shaft angle."""
    found = ease_off(helical(1e-6, helix, shifts), flank)
    assert (found.status == Status.SOLVED).all()
    assert np.abs(found.deviation).max() < 1e-11
    far, near = (ease_off(helical(angle, helix, shifts), flank).deviation for angle in (1e-3, 1e-4))
    assert np.abs(far / 100.0 - near).max() < 0.01 * near.max()


def test_it_vanishes_along_the_path_of_unmodified_flanks(flank: str) -> None:
    """The ease-off is 0 along the path in every mounting, because the transmission error of unmodified flanks
    is 0."""
    for errors in (Errors(), Errors(0.1, 1e-4, 0.3, -0.2)):
        path = path_of_contact(table1(errors=errors), flank, 21)
        assert np.abs(ease_off_at(path.design, flank, path.l1, path.pinion_z)).max() < 1e-12
        found = ease_off(path.design, flank)
        assert found.deviation.min() > -1e-12
        assert (found.status == Status.SOLVED).all()


def least_along_the_normal(design: Design, flank: str, l: float, z: float) -> float:
    """Return the minimum of the distance along the pinion normal over a fine grid of rolls, refined between
    neighbours. The minimum nearest to 0 is returned, because the untrimmed surface returns far
    from the mesh. At each roll, SciPy intersects the ray with the gear flank, starting from the previous
    roll. NaN without a minimum."""
    pose, u = meshing_pair(design, flank), trace_parameter(design.pinion, flank, l, z)
    patch = flank_patch(design.pinion, flank, l, u)
    ratio = -float(design.pinion.teeth) / float(design.gear.teeth)

    def cut(roll: float, start: FloatArray) -> FloatArray:
        pinion, gear = frames_at(design, roll, pose.roll[1] + ratio * (roll - pose.roll[0]))
        foot, ray = to_fixed(pinion, patch.point), normals_to_fixed(pinion, patch.normal)

        def miss(x: FloatArray) -> FloatArray:
            mate = to_fixed(gear, flank_point(design.gear, flank, x[1], x[2]))
            return np.asarray(foot + x[0] * ray - mate)

        found = root(miss, start, tol=1e-13)
        return np.asarray(found.x if np.abs(found.fun).max() < 1e-10 else np.full(3, np.inf))

    path, rolls = pose.path, pose.roll[0] + np.linspace(-0.4, 0.4, 161)
    opposite = path.l2[1] + path.l1[1] - l, path.u2[1] + z - path.pinion_z[1]
    cuts = np.full((161, 3), np.inf)
    cuts[80] = cut(rolls[80], np.array([0.0, *opposite]))
    for way in (range(81, 161), range(79, -1, -1)):
        for k in way:
            before = cuts[k - way.step]
            cuts[k] = cut(rolls[k], before) if np.isfinite(before).all() else np.inf
    gaps = cuts[:, 0]
    least = 1 + np.flatnonzero((gaps[1:-1] <= gaps[:-2]) & (gaps[1:-1] <= gaps[2:]) & np.isfinite(gaps[1:-1]))
    if not least.size:
        return np.nan
    best = int(least[np.abs(gaps[least]).argmin()])

    def distance(roll: float) -> float:
        return float(cut(roll, cuts[best])[0])

    ends = float(rolls[best - 1]), float(rolls[best + 1])
    finest = minimize_scalar(distance, bounds=ends, method="bounded", options={"xatol": 1e-10})
    return float(finest.fun)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), MODIFIED, (-0.002, 0.003)])
def test_against_brute_force(flank: str, parabola: tuple[float, float]) -> None:
    """The ease-off equals the smallest distance along the normal. The concave gear of the last pair generates
    no conjugate surface at one point of the right pinion flank, at its root."""
    design = table1(parabola, Errors(offset=0.05))
    found = ease_off(design, flank, (3, 5))
    for i, j in ((0, 0), (0, 4), (1, 1), (2, 0), (2, 4)):
        expected = least_along_the_normal(design, flank, found.l[i, j], found.z[i, j])
        assert found.deviation[i, j] == pytest.approx(expected, abs=1e-10, nan_ok=True)
    assert np.array_equal(np.isnan(found.deviation), found.status == Status.NOT_CONVERGED)
    assert found.deviation.size - np.isfinite(found.deviation).sum() == (
        parabola[0] < -0.001 and flank == "right"
    )


def test_along_the_path_it_is_the_transmission_error(flank: str) -> None:
    """Along the path, the ease-off equals minus the transmission error times its lever, to first order:
    where the gear is ahead, flanks would overlap at the constant ratio. With half the parabolas the
    residual is a quarter or less."""
    left = []
    for share in (1.0, 0.5):
        path = path_of_contact(table1((0.001 * share, -0.001 * share)), flank, 11)
        layout = layout_of(path.design)
        axis = np.array((0.0, float(layout.sin_angle), float(layout.cos_angle)))
        arm = np.cross(axis, path.point - (float(layout.offset), 0.0, 0.0))
        lever = np.einsum("ni,ni->n", path.normal, arm)
        own = ease_off_at(path.design, flank, path.l1, path.pinion_z)
        assert np.abs(own).max() > 5e-4 * share
        left.append(np.abs(own + path.transmission_error * np.abs(lever)).max())
        assert abs(own[5]) < 1e-6  # the square of the slope of the transmission error
    assert left[0] < 2e-6
    assert left[1] < 0.26 * left[0]


def test_line_contact_and_point_contact_are_distinguished() -> None:
    """The right flanks of Table 1 have approximate line contact. A surface of second order fits the
    ease-off with a residual of 0.1 um, because no tip edge of the mate limits it."""
    right, left = (ease_off(table1(), flank).second_order for flank in ("right", "left"))
    assert right.rest == pytest.approx(0.0887e-3, abs=1e-7)
    assert left.rest == pytest.approx(0.3291e-3, abs=1e-7)
    assert right.face_crowning == pytest.approx(5.226e-3, abs=2e-6)
    assert left.face_crowning > 14.0 * right.face_crowning
    assert left.twist < 0.0 < right.twist


def test_the_mate_is_not_trimmed(flank: str) -> None:
    """Face width and addendum of the mate do not change the ease-off if there is a path: without parabola
    the phase is the same."""
    design = table1()
    gear = replace(design.gear, face_width=20.0, tool=replace(design.gear.tool, addendum=0.7))
    less = ease_off(replace(design, gear=gear), flank)
    np.testing.assert_allclose(less.deviation, ease_off(design, flank).deviation, rtol=0, atol=1e-12)


def test_second_order_reproduces_its_surface() -> None:
    y, x = np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 9)
    grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
    wanted = (1.0, -2.0, 3.0, 4.0, -5.0, 6.0)
    terms = (grid_x**0, grid_x, grid_y, grid_x**2 - 1.0 / 3.0, grid_y**2 - 1.0 / 3.0, grid_x * grid_y)
    surface = np.sum([c * term + 0.0 * grid_x for c, term in zip(wanted, terms, strict=True)], axis=0)
    found = second_order_of(y, x, surface)
    names = ("mean", "face_slope", "profile_slope", "face_crowning", "profile_crowning", "twist")
    assert [getattr(found, name) for name in names] == pytest.approx(wanted, abs=1e-13)
    assert found.rest < 1e-13
    surface[0, 0] = np.nan
    assert second_order_of(y, x, surface).twist == pytest.approx(6.0, abs=1e-13)
    assert np.isnan(second_order_of(y, x, np.full((5, 9), np.nan)).mean)


@pytest.mark.parametrize("design", CROSSING.values(), ids=CROSSING)
def test_paths_across_n_x_0(design: Design) -> None:
    found = ease_off(design, "right", (5, 5))
    solved = found.status == Status.SOLVED
    assert np.array_equal(solved, np.isfinite(found.deviation))
    assert solved.any()
    for i, j in np.argwhere(solved)[::6]:
        expected = least_along_the_normal(design, "right", found.l[i, j], found.z[i, j])
        assert found.deviation[i, j] == pytest.approx(expected, abs=1e-8)


def test_random_pairs_have_a_smooth_ease_off() -> None:
    """Pairs with usual dimensions and errors, also with few teeth. No point belongs to another branch of a
    flank. All points are solved except some near undercut or beyond the involute of the mate."""
    designs, known = random_designs("usual", 40, 11), []
    for k in range(40):
        design: Design = cases_of(designs, k)
        for side in ("right", "left"):
            if path_of_contact(design, side, 2).ends.status == Status.SOLVED:
                share = ease_off(design, side, (7, 9)).deviation / float(design.pinion.tool.normal_module)
                bends = [np.abs(np.diff(share, 2, axis=axis)) for axis in (0, 1)]
                assert max(np.nanmax(bend, initial=0.0) for bend in bends) < 0.15
                known.append(np.isfinite(share).mean())
    assert np.mean(known) > 0.97


def test_points_of_nan_have_no_ease_off() -> None:
    assert np.isnan(ease_off_at(table1(), "right", [np.nan, 0.0], 0.0)).tolist() == [True, False]


def test_it_is_the_minimum_separation_of_a_pattern(flank: str) -> None:
    """The separation is computed from feet on the mating flank and parabolas over the roll. Both agree to
    second order in the slope."""
    side = contact_pattern(table1(), flank, resolution=2.0).pinion
    stands = side.status == PatternStatus.STANDSTILL
    assert np.count_nonzero(stands) > 50
    own = ease_off_at(table1(), flank, side.l[stands], side.z[stands])
    longer = own - side.least[stands]  # than the perpendicular
    assert longer.min() > -1e-8
    assert (longer < 1e-4 * own + 1e-8).all()


def test_normal_deviation_by_a_parabola_of_the_pinion(flank: str) -> None:
    """The change equals the distance of the parabolic flank from the straight one at its feet, minus this
    distance in the middle, where the gear is rotated into contact again. The difference is of the order
    a^2, and of the order of the tilt 2 a l of the normal times the slope of the ease-off (below 0.01
    here)."""
    pose, found, left = meshing_pair(table1(), flank), ease_off(table1(), flank, (7, 7)), []
    for a in (1e-4, 1e-5):
        bent, u = table1((a, 0.0)), trace_parameter(table1((a, 0.0)).pinion, flank, found.l, found.z)
        foot = feet(table1().pinion, flank, flank_point(bent.pinion, flank, found.l, u))
        own = ease_off_at(bent, flank, found.l, found.z) - ease_off_at(table1(), flank, foot.l, foot.z)
        assert np.abs(foot.distance).max() > 35.0 * a
        left.append(np.abs(own + foot.distance - a * pose.path.l1[1] ** 2).max())
        tilt = 2.0 * a * np.abs(found.l).max() * 0.01 * found.deviation.max()
        assert left[-1] < 700.0 * a * a + 2.0 * tilt
    assert left[1] < (0.012 if flank == "right" else 0.12) * left[0]


def test_normal_deviation_by_a_parabola_of_the_gear(flank: str) -> None:
    """The change is a l2^2 at the conjugate point, minus its value in the middle, up to terms of the order
    a^2."""
    design, left = table1(), []
    pose, found = meshing_pair(design, flank), ease_off(design, flank, (7, 7))
    patch = flank_patch(design.pinion, flank, found.l, z=found.z)
    roll, ratio = found.pinion_roll, -float(design.pinion.teeth) / float(design.gear.teeth)
    pinion, (turn, origin) = frames_at(design, roll, pose.roll[1] + ratio * (roll - pose.roll[0]))
    met = to_fixed(pinion, patch.point + found.deviation[..., None] * patch.normal) - origin
    on_gear = feet(design.gear, flank, np.einsum("...ji,...j->...i", turn, met))
    assert np.abs(on_gear.distance).max() < 1e-12
    for a in (1e-4, 1e-5):
        own = ease_off_at(table1((0.0, a)), flank, found.l, found.z) - found.deviation
        height = a * (on_gear.l**2 - pose.path.l2[1] ** 2)
        assert np.abs(height).max() > 35.0 * a
        left.append(np.abs(own + height).max())
    assert left[0] < 3e-5
    assert left[1] < 0.012 * left[0]


def test_gears_without_a_path_are_not_placed() -> None:
    with pytest.raises(ValueError, match="no path of contact, so that the gears cannot be placed"):
        meshing_pair(table1(errors=Errors(offset=60.0)), "right")
