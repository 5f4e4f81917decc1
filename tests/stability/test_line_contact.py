"""Approximate line contact: the small relative curvature of Table 1's right flanks tends to 0 and changes
sign as both parabola coefficients grow from 0.0002 to 0.001 1/mm.

Where it vanishes, the pinion roll is stationary along the path. On either side there is a contact at the same
roll: on one side a minimum of the separation, on the other a saddle point."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Status,
    first_contact,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import contact_ellipse, relative_curvature
from beveloid_geom.contact.path import path_ends
from beveloid_geom.shapes.proximity.mesh_contact import MeshContact, mesh_contact
from beveloid_geom.status import EllipseStatus, FirstStatus, Verdict
from tests.contact.test_path import five_equation_residual
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import pose_at

TURNING = (0.0004, 0.00045, 0.0005, 0.00055)
"""Coefficients for which the curvature changes its sign on the path."""
COEFFICIENTS = (0.0, 0.0002, 0.0003, 0.00037, *TURNING, 0.00059, 0.0006, 0.0008, 0.001)
FOLDS = (0.00045, 0.0005)
"""Coefficients with a detailed test: the fold is on either side of the middle of the face."""


@lru_cache(maxsize=32)
def concave(a: float) -> Design:
    return table1((a, a))


def even_in_l1(a: float, points: int) -> ContactPath:
    start, stop = path_ends(concave(a)).l1
    return path_of_contact(concave(a), l1=np.linspace(start, stop, points))


def smaller_curvature(a: float, path: ContactPath) -> FloatArray:
    return np.asarray(relative_curvature(path).curvature[..., 0])


@lru_cache(maxsize=32)
def fold(a: float) -> float:
    """Return l1 at which the smaller curvature is zero, by bisection."""
    low, high = path_ends(concave(a)).l1
    sign = smaller_curvature(a, path_of_contact(concave(a), l1=[low]))[0]
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = smaller_curvature(a, path_of_contact(concave(a), l1=[middle]))[0] * sign > 0.0
        low, high = (middle, high) if same else (low, middle)
    return float(0.5 * (low + high))


@pytest.mark.parametrize("a", COEFFICIENTS)
def test_no_jump_along_the_path(a: float) -> None:
    """Steps and their differences between 2001 positions are those between 501 positions divided by 4 and 16;
    a jump would have the same size in both. The tolerance of 0.5 % covers the next order of such a curve;
    differences below 1e-11 mm of l2, 1e-10 mm of the point and 1e-13 rad of the rolls are rounding."""
    coarse, fine = even_in_l1(a, 501), even_in_l1(a, 2001)
    assert (fine.status == Status.SOLVED).all()
    assert five_equation_residual(concave(a), fine) < 1e-11
    for name, noise in (("l2", 1e-11), ("point", 1e-10), ("pinion_roll", 1e-13), ("gear_roll", 1e-13)):
        for order in (1, 2):
            steps = [np.abs(np.diff(getattr(path, name), order, axis=0)) for path in (coarse, fine)]
            greatest = steps[0].max(axis=0) / 4.0**order
            assert (steps[1].max(axis=0) <= 1.005 * greatest + noise).all(), (name, order)


@pytest.mark.parametrize("a", COEFFICIENTS)
def test_the_path_has_the_requested_positions(a: float) -> None:
    """Positions are even in roll where it is monotone, else in l1; they run from limit to limit, and none
    is lost or NaN."""
    path = path_of_contact(concave(a), points=2001)
    turns = a in TURNING
    assert (path.status == Status.SOLVED).all()
    assert path.ends.pieces == 1
    assert five_equation_residual(concave(a), path) < 1e-11
    roll, l1 = np.diff(path.pinion_roll), np.diff(path.l1)
    even, other = (l1, roll) if turns else (roll, l1)
    assert np.ptp(even) < 1e-12 * max(1.0, np.abs(path.l1).max())
    assert (roll.min() < 0.0 < roll.max()) == turns
    assert np.abs(other).max() < 40.0 * np.abs(other).mean()
    assert (l1 > 0.0).all() or (l1 < 0.0).all()
    assert path.ends.contact_ratio == pytest.approx(np.ptp(path.pinion_roll) * 29 / (2 * np.pi), abs=1e-6)


def test_continuous_in_the_coefficient() -> None:
    """The largest steps of ends and ratio over the range are halved with the step of the coefficient.
    Within the range, the roll begins and ceases to turn back, and the ends are exchanged."""
    widest = []
    for count in (201, 401):
        a = np.linspace(0.0, 0.001, count)
        ends = path_ends(table1().with_parabola(a, a))
        assert (ends.status == Status.SOLVED).all()
        assert (ends.pieces == 1).all()
        spread = np.sort(ends.l1, axis=-1)
        widest.append([np.abs(np.diff(spread, axis=0)).max(), np.abs(np.diff(ends.contact_ratio)).max()])
    np.testing.assert_allclose(np.array(widest[0]) / np.array(widest[1]), 2.0, rtol=0.1)


@pytest.mark.parametrize("turn", [(0.00037, 0.0004), (0.00055, 0.0006), (0.00045, 0.0005)])
def test_coefficients_at_which_the_path_changes(turn: tuple[float, float]) -> None:
    """Paths just below and just above a coefficient at which the path changes have equal ends and contact
    ratios. At these coefficients, found by bisection, the roll begins or ceases to turn back, or the ends are
    exchanged."""

    def side(a: float) -> tuple[bool, bool]:
        path = path_of_contact(concave.__wrapped__(a), points=201)
        roll = np.diff(path.pinion_roll)
        return bool(roll.min() < 0.0 < roll.max()), bool(path.l1[0] < path.l1[-1])

    low, high = turn
    first = side(low)
    assert side(high) != first
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if side(middle) == first else (low, middle)
    paths = [path_of_contact(table1((a, a)), points=201) for a in (low, high)]
    for a, path in zip((low, high), paths, strict=True):
        assert (path.status == Status.SOLVED).all()
        assert five_equation_residual(table1((a, a)), path) < 1e-11
    ends = [np.sort(path.ends.l1) for path in paths]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-10)
    assert abs(paths[0].ends.contact_ratio - paths[1].ends.contact_ratio) < 1e-10


@pytest.mark.parametrize("a", TURNING)
def test_the_roll_is_stationary_where_the_curvature_vanishes(a: float) -> None:
    """The two results are independent: the curvature is computed from the flanks, the roll from the path."""
    path = even_in_l1(a, 2001)
    curvature = smaller_curvature(a, path)
    rises = np.gradient(path.pinion_roll, path.l1) > 0.0
    at = int(np.flatnonzero(rises[1:] != rises[:-1])[0])
    (p, q, r), step = path.pinion_roll[at : at + 3], path.l1[1] - path.l1[0]
    still = path.l1[at + 1] + 0.5 * step * (p - r) / (p - 2.0 * q + r)
    assert abs(still - fold(a)) < step**2 * 10.0
    assert np.count_nonzero(np.diff(np.signbit(curvature))) == 1


@pytest.mark.parametrize("a", FOLDS)
def test_two_contacts_at_one_roll(a: float) -> None:
    """Two contacts at one roll, found on both sides of the fold by bisection in l1, satisfy the equations,
    and their gear rolls differ by the transmission errors. Meshes give the contact with positive curvature,
    or none with a status."""
    design, low, high = concave(a), *np.sort(path_ends(concave(a)).l1)
    middle = fold(a)
    near = 0.4 * min(middle - low, high - middle)
    one = path_of_contact(design, l1=[middle - near])
    start, stop = middle, high
    rises = (
        path_of_contact(design, l1=[stop]).pinion_roll[0] > path_of_contact(design, l1=[start]).pinion_roll[0]
    )
    for _ in range(60):
        half = 0.5 * (start + stop)
        above = path_of_contact(design, l1=[half]).pinion_roll[0] > one.pinion_roll[0]
        start, stop = (start, half) if above == rises else (half, stop)
    two = path_of_contact(design, l1=[start])
    assert abs(one.pinion_roll[0] - two.pinion_roll[0]) < 1e-14
    assert abs(one.l1[0] - two.l1[0]) > near
    for path in (one, two):
        assert path.status[0] == Status.SOLVED
        assert five_equation_residual(design, path) < 1e-11
    curvature = [smaller_curvature(a, path)[0] for path in (one, two)]
    assert min(curvature) < -1e-8
    assert max(curvature) > 1e-8
    assert abs(one.gear_roll[0] - two.gear_roll[0]) > 1e-9
    proofs = [path_certificate(path) for path in (one, two)]
    assert abs(proofs[0].first.gear_roll[0] - proofs[1].first.gear_roll[0]) < 1e-14
    for path, kappa, proof in zip((one, two), curvature, proofs, strict=True):
        assert np.sign(proof.curvature[0]) == np.sign(kappa)
        assert proof.separation[0] < -0.01  # edges touch earlier than both
        assert proof.verdict[0] == (Verdict.INTERFERENCE if kappa < 0.0 else Verdict.EDGE_CONTACT)
        found = mesh_contact(design, "right", 0.001, **pose_at(path, 0))
        check_mesh(found, path, kappa)


def check_mesh(found: MeshContact, path: ContactPath, curvature: float) -> None:
    """Check that the result is the contact of the path, another one with a smaller separation, or none."""
    if found.status != Status.SOLVED:
        assert found.status in (Status.OFF_FLANK, Status.NOT_CONVERGED)
        assert np.isnan(found.point).all()
        assert np.isnan((found.separation, found.doubt)).all()
        return
    same = bool(np.linalg.norm(found.point - path.point[0]) <= found.doubt)
    assert same or found.separation < -1e-9
    assert not (same and curvature < 0.0)


@pytest.mark.parametrize("a", FOLDS)
def test_meshes_near_the_fold(a: float) -> None:
    """Towards the fold, the doubt about the position grows with the inverse of the curvature. If rounding
    hides whether there is a minimum, no contact is given; a saddle or a point of inflection is never given.
    """
    design, middle = concave(a), fold(a)
    up = np.sign(smaller_curvature(a, path_of_contact(design, l1=[middle + 0.1]))[0])
    for away in (-0.3, -1e-3, -1e-6, 0.0, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3):
        path = path_of_contact(design, l1=[middle + up * away])
        kappa = smaller_curvature(a, path)[0]
        assert np.sign(kappa) == np.sign(away) or away == 0.0
        check_mesh(mesh_contact(design, "right", 0.001, **pose_at(path, 0)), path, kappa)


@pytest.mark.parametrize("a", COEFFICIENTS)
def test_certificate_and_first_contact_agree(a: float) -> None:
    """There is a verdict at every position, also at the fold; the first contact is earlier than the path
    or on it. Curvatures of the clearance and of the flanks have the same sign."""
    l1 = even_in_l1(a, 15).l1[1:-1]
    if a in TURNING:
        l1 = np.append(l1, fold(a) + np.array((-1e-6, -1e-12, 0.0, 1e-12, 1e-6)))
    path = path_of_contact(concave(a), l1=l1)
    proof, kappa = path_certificate(path), smaller_curvature(a, path)
    first = first_contact(concave(a), "right", path.pinion_roll)
    assert (first.status == FirstStatus.SOLVED).all()
    assert (proof.verdict != Verdict.NOT_SOLVED).all()
    assert np.isfinite(proof.separation).all()
    ahead = path.gear_roll - first.gear_roll  # right flanks: the gear rotates backwards to separate
    assert (ahead > -1e-13).all()
    np.testing.assert_allclose(proof.separation, -ahead * 127.0, rtol=0.02, atol=1e-11)
    clear = np.abs(kappa) > 1e-10
    assert np.array_equal(np.sign(proof.curvature[clear]), np.sign(kappa[clear]))
    cut = proof.verdict == Verdict.INTERFERENCE
    assert (kappa[cut] < 0.0).all()
    assert cut[kappa < -1e-8].all()
    ellipse = contact_ellipse(path)
    assert np.array_equal(
        ellipse.status == EllipseStatus.INTERFERENCE, kappa < -1e-9 * ellipse.curvature[:, 1]
    )
    assert np.isnan(ellipse.semi_axes[ellipse.status != EllipseStatus.ELLIPSE, 0]).all()
