"""Sampled flanks: distance from the exact flank, number of points, edges."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import Member, Modification, sample_flank
from beveloid_geom.arrays import FloatArray, Quantity
from beveloid_geom.gear.active_flank import active_start
from beveloid_geom.gear.flank import flank_patch, flank_point
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter, tip_radius
from beveloid_geom.gear.undercut import undercut_margin
from beveloid_geom.shapes import sampling
from beveloid_geom.shapes.sampling import flank_sheet
from beveloid_geom.shapes.sheet import Sheet, falling_diagonals, grid_faces, grid_of, series_of
from tests.oracle.surface_distance import distance_bound, inside_triangles
from tests.oracle.table1 import table1

PINION, GEAR = table1().members


def with_parabola(member: Member, parabola: Quantity) -> Member:
    return replace(member, tool=replace(member.tool, parabola=parabola))


FLANKS = {
    "pinion-right": (PINION, "right"),
    "pinion-left": (PINION, "left"),
    "gear-right": (GEAR, "right"),
    "gear-left": (GEAR, "left"),
    "concave": (with_parabola(PINION, 0.01), "right"),
    "concave-left": (with_parabola(PINION, 0.01), "left"),
    "convex": (with_parabola(PINION, -0.004), "right"),
    "convex-left": (with_parabola(PINION, -0.006), "left"),
    "convex-gear": (with_parabola(GEAR, -0.008), "left"),
    "cylindrical": (replace(PINION, cone_angle=0.0), "right"),
    "straight": (replace(PINION, helix_angle=0.0), "left"),
    "spur": (replace(PINION, helix_angle=0.0, cone_angle=0.0), "right"),
    "left-hand": (replace(PINION, helix_angle=radians(-25.0)), "right"),
    "steep": (replace(PINION, cone_angle=radians(10.0), face_width=20.0), "left"),
}
all_flanks = pytest.mark.parametrize(("member", "flank"), FLANKS.values(), ids=FLANKS)


@pytest.mark.slow
@all_flanks
@pytest.mark.parametrize("tolerance", [0.05, 0.01, 0.001])
def test_triangles_stay_within_the_tolerance(member: Member, flank: str, tolerance: float) -> None:
    grid = sample_flank(member, flank, tolerance)
    distance = distance_bound(flank_sheet(member, flank), *inside_triangles(grid, grid.l, 25))
    assert distance.max() <= tolerance
    assert distance.max() == pytest.approx(grid.deviation, rel=0.05)


@pytest.mark.parametrize("tolerance", [0.01, 0.001])
def test_undercut_flanks_are_sampled_from_the_fillet_on(tolerance: float) -> None:
    undercut = with_parabola(PINION, -0.01)
    assert undercut_margin(undercut, "right") < 0.0
    grid = sample_flank(undercut, "right", tolerance)
    assert grid.deviation <= tolerance
    distance = distance_bound(flank_sheet(undercut, "right"), *inside_triangles(grid, grid.l, 25))
    # Triangles along the edge of the flank may also lie outside it.
    assert distance.max() <= 2.5 * tolerance
    assert np.quantile(distance, 0.98) <= tolerance
    np.testing.assert_allclose(grid.l[0], active_start(undercut, "right", grid.z), atol=1e-12)


def uniform_deviation(member: Member, flank: str, rows: int, columns: int, falling: bool) -> float:
    """Return the largest distance of a grid evenly spaced in l and z with equal diagonals, along the normal
    at the interpolated parameters."""
    half = 0.5 * float(member.face_width)
    z = np.linspace(-half, half, columns + 1)
    root = root_parameter(member, "right")
    l = root + np.linspace(0.0, 1.0, rows + 1)[:, None] * (tip_parameter(member, flank, z) - root)
    z = np.broadcast_to(z, l.shape)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    corners = [(0, 0), (1, 0), (0, 1)], [(1, 1), (0, 1), (1, 0)]
    if not falling:
        corners = [(1, 0), (1, 1), (0, 0)], [(0, 1), (0, 0), (1, 1)]
    weights = np.array([(a, b, 4 - a - b) for a in range(5) for b in range(5 - a)]) / 4.0
    worst = 0.0
    points = flank_point(member, flank, l, z=z)
    for triangle in corners:
        at = [(i + di, j + dj) for di, dj in triangle]
        mixed_l, mixed_z = (np.tensordot(weights, np.stack([v[c] for c in at]), 1) for v in (l, z))
        flat = np.tensordot(weights, np.stack([points[c] for c in at]), 1)
        patch = flank_patch(member, flank, mixed_l, z=mixed_z)
        worst = max(worst, float(np.abs(np.einsum("...i,...i", flat - patch.point, patch.normal)).max()))
    return worst


def uniform_keeps(member: Member, flank: str, tolerance: float, rows: int, columns: int) -> bool:
    return any(uniform_deviation(member, flank, rows, columns, way) <= tolerance for way in (True, False))


@pytest.mark.parametrize("name", ["pinion-right", "pinion-left", "gear-right", "concave", "convex", "spur"])
@pytest.mark.parametrize("tolerance", [0.05, 0.01])
def test_no_more_points_than_the_best_uniform_grid(name: str, tolerance: float) -> None:
    # At most 1.2 times as many: no uniform grid with fewer than size / 1.2 points keeps the tolerance.
    member, flank = FLANKS[name]
    grid = sample_flank(member, flank, tolerance)
    for rows in range(1, grid.l.size):
        for columns in range(1, grid.l.size):
            if (rows + 1) * (columns + 1) >= grid.l.size / 1.2:
                break
            assert not uniform_keeps(member, flank, tolerance, rows, columns), (rows, columns)
    rows, columns = grid.l.shape
    assert uniform_keeps(member, flank, tolerance, 2 * rows, 2 * columns)


def test_table1_pinion_takes_7_by_5_cells() -> None:
    """The tolerance is used. With the other diagonals an evenly spaced grid deviates more than three times
    as much."""
    grid = sample_flank(PINION, "right", 0.01)
    assert grid.l.shape == (8, 6)
    assert grid.deviation > 0.009
    falling = falling_diagonals(grid.points, grid.normals)
    chosen = bool(falling.any())
    assert falling.all() == chosen
    of_chosen, of_other = (uniform_deviation(PINION, "right", 8, 6, way) for way in (chosen, not chosen))
    assert of_other > 3.0 * of_chosen


@pytest.mark.parametrize("parabola", [-0.005, -0.002, 0.003])
def test_a_small_crowning_of_a_parabolic_flank_changes_no_grid(parabola: float, flank: str) -> None:
    """With a parabola the active profile may start below the joint with the fillet."""
    plain = table1((parabola, parabola)).gear
    crowned = plain.modified(
        Modification(helix_crowning_um=1e-3, tip_relief_um=1e-3, tip_relief_length_mm=1.0)
    )
    grids = [sample_flank(member, flank, 0.002) for member in (plain, crowned)]
    assert grids[0].points.shape == grids[1].points.shape
    assert np.abs(grids[0].points - grids[1].points).max() < 1e-3


def test_points_grow_inversely_with_the_tolerance() -> None:
    tolerances = np.array([1e-2, 1e-3, 1e-4])
    sizes = [sample_flank(PINION, "left", float(tolerance)).l.size for tolerance in tolerances]
    slope = np.polyfit(np.log(tolerances), np.log(sizes), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.1)


@all_flanks
def test_edges_are_exact(member: Member, flank: str) -> None:
    grid = sample_flank(member, flank, 0.02)
    half = 0.5 * float(member.face_width)
    assert np.array_equal(grid.points[:, 0, 2], np.full(grid.l.shape[0], -half))
    assert np.array_equal(grid.points[:, -1, 2], np.full(grid.l.shape[0], half))
    radius = np.hypot(grid.points[-1, :, 0], grid.points[-1, :, 1])
    np.testing.assert_allclose(radius, tip_radius(member, grid.z), rtol=1e-13)
    np.testing.assert_array_equal(grid.l[0], np.full(grid.z.size, root_parameter(member, "right")))


@all_flanks
def test_points_and_normals_are_those_of_the_flank(member: Member, flank: str) -> None:
    grid = sample_flank(member, flank, 0.02)
    patch = flank_patch(member, flank, grid.l, z=grid.z)
    np.testing.assert_allclose(grid.points, patch.point, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(grid.normals, patch.normal, rtol=0.0, atol=1e-14)


def scattered(sheet: Sheet, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return stations s (151,) and z (101,), mm, of a surface, including its ends."""
    random = np.random.default_rng(seed)
    s, z = (np.concatenate(([0.0], np.sort(random.random(count)), [1.0])) for count in (149, 99))
    return s, sheet.half_width * (2.0 * z - 1.0)


ALL_BUT_FOLDED = FLANKS | {
    "undercut": (with_parabola(PINION, -0.02), "right"),
    "few teeth": (replace(PINION, teeth=6), "left"),
    "wide": (replace(PINION, cone_angle=0.0, helix_angle=radians(30.0), face_width=200.0), "left"),
}


@pytest.mark.parametrize(("member", "flank"), ALL_BUT_FOLDED.values(), ids=ALL_BUT_FOLDED)
def test_series_is_the_exact_formula(member: Member, flank: str) -> None:
    sheet = flank_sheet(member, flank)
    assert sheet.series is not None
    s, z = scattered(sheet)
    grid, exact = grid_of(sheet, s, z), grid_of(replace(sheet, series=None), s, z)
    np.testing.assert_allclose(grid.points, exact.points, rtol=0.0, atol=5e-13)
    np.testing.assert_allclose(grid.parameter, exact.parameter, rtol=0.0, atol=5e-13)
    np.testing.assert_allclose(grid.normals, exact.normals, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(grid.normals, axis=-1), 1.0, rtol=0.0, atol=4e-15)
    np.testing.assert_array_equal(grid.points[..., 2], np.broadcast_to(z, exact.parameter.shape))
    np.testing.assert_array_equal(grid.parameter[0], exact.parameter[0])


@pytest.mark.parametrize("tolerance", [0.05, 0.005])
def test_exact_formula_serves_where_the_series_does_not(tolerance: float) -> None:
    # Undercut begins within the face, so that the edge of the flank has a kink there.
    folded = with_parabola(PINION, -0.01)
    assert flank_sheet(folded, "right").series is None
    grid = sample_flank(folded, "right", tolerance)
    patch = flank_patch(folded, "right", grid.l, z=grid.z)
    np.testing.assert_allclose(grid.points, patch.point, rtol=0.0, atol=1e-12)
    assert grid.deviation <= tolerance
    np.testing.assert_array_equal(grid.points[:, 0, 2], np.full(grid.l.shape[0], grid.z[0]))


@pytest.mark.parametrize(("wave", "resolved"), [(10.0, True), (40.0, True), (90.0, False)])
def test_series_is_taken_only_if_it_resolves_the_surface(wave: float, resolved: bool) -> None:
    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        points = np.stack((p, 0.01 * np.sin(wave * (p + 0.1 * z)), z), axis=-1)
        return points, np.broadcast_to((0.0, 1.0, 0.0), points.shape)

    sheet = Sheet(place, lambda z: -0.5 + 0.0 * z, lambda z: 0.5 + 0.0 * z, 1.0)
    assert (series_of(sheet) is not None) == resolved


@all_flanks
def test_faces_wind_along_the_normals(member: Member, flank: str) -> None:
    grid = sample_flank(member, flank, 0.02)
    faces = grid_faces(grid.points, grid.normals)
    assert len(faces) == 2 * (grid.l.shape[0] - 1) * (grid.l.shape[1] - 1)
    assert np.array_equal(np.unique(faces), np.arange(grid.l.size))
    a, b, c = grid.points.reshape(-1, 3)[faces.T]
    facing = np.einsum("ni,ni->n", np.cross(b - a, c - a), grid.normals.reshape(-1, 3)[faces[:, 0]])
    assert facing.min() > 0.0


@pytest.mark.parametrize("tolerance", [1e-8, 1e-11, 1e-300, 5e-324])
def test_a_tolerance_too_fine_is_refused_with_the_number_of_points(tolerance: float) -> None:
    tracemalloc.start()
    message = rf"tolerance {tolerance:g} mm needs .* points, the limit is .*: increase"
    try:
        with pytest.raises(ValueError, match=message):
            sample_flank(PINION, "right", tolerance)
        assert tracemalloc.get_traced_memory()[1] < 3e6  # bytes; rejected before the grid is built
    finally:
        tracemalloc.stop()


def test_undercut_margin_of_a_batch_is_that_of_its_members() -> None:
    teeth = np.array([[12.0], [16.0], [30.0]])
    parabolas = np.array([0.0, -0.01])
    batch = undercut_margin(with_parabola(replace(PINION, teeth=teeth), parabolas), "left")
    assert batch.shape == (3, 2)
    for at in np.ndindex(3, 2):
        single = with_parabola(replace(PINION, teeth=float(teeth[at[0], 0])), float(parabolas[at[1]]))
        assert undercut_margin(single, "left") == pytest.approx(batch[at], abs=1e-13)


def test_flank_that_ends_below_its_tip_cone_at_one_end() -> None:
    """The tip lies beyond the flank in the last 0.15 mm at the heel only."""
    member = replace(PINION, teeth=30, cone_angle=radians(-16.0), helix_angle=radians(37.0))
    member = replace(member, profile_shift=-0.7, face_width=137.4)
    with pytest.raises(ValueError, match="the right flank does not reach its tip cone"):
        sample_flank(member, "right", 0.01)


def test_only_undercut_flanks_are_called_undercut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sampling, "measured_deviation", lambda *_: 1.0)
    with pytest.raises(ValueError, match=r"^the right flank is undercut: use more teeth"):
        sample_flank(with_parabola(PINION, -0.01), "right", 0.01)
    with pytest.raises(ValueError, match=r"cannot be sampled to 0\.01 mm: increase the tolerance"):
        sample_flank(PINION, "right", 0.01)
