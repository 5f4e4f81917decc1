"""Second-order geometry of the flanks: against closed forms, identities of surfaces and brute force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from beveloid_geom import ContactPath, Design, Status, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import (
    RelativeCurvature,
    contact_ellipse,
    curvature_ellipse,
    relative_curvature,
)
from beveloid_geom.contact.flank_pair import pairing_of
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.flank import base_cylinder, flank_patch, flank_point, normal_rates, trace_parameter
from beveloid_geom.pair.frames import layout_of, member_frame, to_fixed
from beveloid_geom.status import EllipseStatus
from tests.oracle.table1 import table1

PARABOLAS = ((0.0, 0.0), (0.001, -0.001), (-0.003, 0.005))
L, Z = (grid.ravel() for grid in np.meshgrid(np.linspace(-5.5, 5.5, 7), np.linspace(-20.0, 20.0, 5)))


@pytest.mark.parametrize("parabola", PARABOLAS)
def test_normal_rates_are_those_of_the_normal(flank: str, parabola: tuple[float, float]) -> None:
    for member in table1(parabola).members:
        u, h = trace_parameter(member, flank, L, Z), 1e-4
        by_l, by_u = normal_rates(member, flank, L, u)
        for rate, l_step, u_step in ((by_l, h, 0.0), (by_u, 0.0, h)):
            near, far = (
                flank_patch(member, flank, L + k * l_step, u + k * u_step).normal
                - flank_patch(member, flank, L - k * l_step, u - k * u_step).normal
                for k in (1.0, 2.0)
            )
            assert np.abs(rate - (8.0 * near - far) / (12.0 * h)).max() < 1e-11
        patch = flank_patch(member, flank, L, u)
        crossed = [
            np.einsum("ni,ni->n", *pair) for pair in ((by_l, patch.tangent_u), (by_u, patch.tangent_l))
        ]
        assert np.abs(crossed[0] - crossed[1]).max() < 1e-14


def test_radius_of_curvature_of_an_involute_helicoid(flank: str) -> None:
    """rho = sqrt(r^2 - r_b^2) / cos(beta_b) across the generators; along them the surface is straight."""
    for member in table1().members:
        u, base = trace_parameter(member, flank, L, Z), base_cylinder(member, flank)
        patch, rates = flank_patch(member, flank, L, u), normal_rates(member, flank, L, u)
        steps = np.stack((patch.tangent_l, patch.tangent_u), axis=-1)
        form = np.swapaxes(steps, 1, 2) @ np.stack(rates, axis=-1)
        curvature = np.linalg.eigvals(np.linalg.solve(np.swapaxes(steps, 1, 2) @ steps, form)).real
        reach = np.sqrt(patch.point[:, 0] ** 2 + patch.point[:, 1] ** 2 - base.radius**2)
        assert np.abs(curvature.max(axis=-1) * reach / np.cos(base.helix_angle) - 1.0).max() < 1e-11
        assert np.abs(curvature.min(axis=-1)).max() < 1e-15


@pytest.mark.parametrize("parabola", PARABOLAS)
def test_feet_of_offset_points(flank: str, parabola: tuple[float, float]) -> None:
    offset = np.linspace(-1.5, 4.0, L.size)
    for member in table1(parabola).members:
        u = trace_parameter(member, flank, L, Z)
        patch = flank_patch(member, flank, L, u)
        for start in (None, (L + 0.5, u - 1.0)):
            found = feet(member, flank, patch.point + offset[:, None] * patch.normal, start)
            assert np.abs(found.l - L).max() < 1e-12
            assert np.abs(found.u - u).max() < 1e-12
            assert np.abs(found.z - Z).max() < 1e-12
            assert np.abs(found.distance - offset).max() < 1e-12
            assert np.abs(found.normal - patch.normal).max() < 1e-13


@pytest.mark.parametrize(
    ("l", "z", "inside"),
    [(0.0, 10.0, True), (-6.6, 0.0, False), (6.9, 0.0, False), (0.0, -25.1, False), (0.0, 25.1, False)],
)
def test_feet_beyond_the_limits_have_a_status(l: float, z: float, inside: bool) -> None:
    member = table1().pinion
    patch = flank_patch(member, "right", l, z=z)
    found = feet(member, "right", patch.point + 0.3 * patch.normal)
    assert found.status == (Status.SOLVED if inside else Status.OFF_FLANK)
    assert (found.margin > 0.0) == inside
    assert abs(found.distance - 0.3) < 1e-12
    if abs(z) > 25.0:
        assert abs(found.margin - (25.0 - abs(z))) < 1e-12


def test_no_foot_inside_the_base_cylinder() -> None:
    member = table1().pinion
    radius = float(base_cylinder(member, "right").radius)
    found = feet(member, "right", np.array([[radius - 2.0, 1.0, 0.0], [radius + 3.0, 0.0, 0.0]]))
    assert found.status[0] == Status.NOT_CONVERGED
    assert np.isnan([found.l[0], found.u[0], found.z[0], found.distance[0], found.margin[0]]).all()
    assert found.status[1] != Status.NOT_CONVERGED


@pytest.mark.parametrize("parabola", [*PARABOLAS, (0.02, -0.01)])
def test_every_foot_is_a_nearest_point(parabola: tuple[float, float]) -> None:
    """For points around the base cylinder, each foot is on the flank and nearer than the flank points around
    it."""
    member, random = table1(parabola).gear, np.random.default_rng(5)
    radius = float(base_cylinder(member, "right").radius) + random.uniform(-2.0, 4.0, 3000)
    angle, z = random.uniform(-0.3, 0.3, 3000), random.uniform(-40.0, 40.0, 3000)
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=-1)
    found = feet(member, "right", points)
    solved = found.status == Status.SOLVED
    assert solved.sum() > 40
    foot = flank_point(member, "right", found.l[solved], found.u[solved])
    error = foot + found.distance[solved, None] * found.normal[solved] - points[solved]
    assert np.abs(error).max() < 1e-11
    assert np.abs(found.l[solved]).max() < 7.0
    apart = np.abs(found.distance[solved])
    assert apart.max() < 60.0
    l, u = found.l[solved], found.u[solved]
    for turn in np.linspace(0.0, 2.0 * np.pi, 12):
        beside = flank_point(member, "right", l + 0.05 * np.cos(turn), u + 0.1 * np.sin(turn))
        assert (np.linalg.norm(points[solved] - beside, axis=-1) > apart - 1e-7).all()


@pytest.mark.parametrize(("flank", "degrees"), [("right", 2.3), ("left", 9.3)])
def test_generators_cross_at_the_known_angle(flank: str, degrees: float) -> None:
    """Unmodified flanks are developable: det(A_1 + A_2) = kappa_1 kappa_2 sin^2(angle)."""
    design = table1()
    path = path_of_contact(design, flank, 7)
    curvature = relative_curvature(path).curvature
    angle = float(layout_of(design).shaft_angle)
    axial = path.normal[:, 2], path.normal[:, 1] * np.sin(angle) + path.normal[:, 2] * np.cos(angle)
    own = []
    for member, radius in ((design.pinion, path.pinion_r), (design.gear, path.gear_r)):
        base = base_cylinder(member, flank)
        own.append(np.cos(base.helix_angle) / np.sqrt(radius**2 - base.radius**2))
    sine = path.normal[:, 0] * np.sin(angle) / np.sqrt((1.0 - axial[0] ** 2) * (1.0 - axial[1] ** 2))
    assert np.abs(np.degrees(np.arcsin(sine)) - degrees).max() < 0.05
    assert curvature.prod(axis=-1) == pytest.approx(own[0] * own[1] * sine**2, rel=1e-9)
    assert curvature.sum(axis=-1) == pytest.approx(own[0] + own[1], rel=1e-12)


def _height(
    design: Design, path: ContactPath, member: int, aside: FloatArray, basis: FloatArray
) -> FloatArray:
    """Return the height of flank points `aside` (n, 2) from the contact over the common tangent plane."""
    pairing = pairing_of(design, path.flank)
    roll, l, u = ((path.pinion_roll, path.l1, path.u1), (path.gear_roll, path.l2, path.u2))[member]
    frame = member_frame(layout_of(design), member, roll[0], pairing.position[member, 0, 0])
    heights = []
    for target in aside:

        def offset(x: FloatArray) -> FloatArray:
            point = flank_point(design.members[member], path.flank, x[0], x[1])
            return np.asarray(to_fixed(frame, point) - path.point[0])

        def miss(x: FloatArray, target: FloatArray = target) -> FloatArray:
            return np.asarray(basis @ offset(x) - target)

        found = least_squares(miss, (l[0], u[0]), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        heights.append(path.normal[0] @ offset(found.x))
    return np.array(heights)


@pytest.mark.parametrize("parabola", PARABOLAS[:2])
def test_curvature_is_that_of_the_separation(flank: str, parabola: tuple[float, float]) -> None:
    """The mean of opposite points cancels the third order; steps are small compared with 1/kappa."""
    design = table1(parabola)
    path = path_of_contact(design, flank, l1=[0.5])
    relative = relative_curvature(path)
    basis, step = relative.direction[0], np.array((3.0, 0.3))
    assert np.abs(basis @ path.normal[0]).max() < 1e-14
    aside = np.concatenate((np.diag(step), -np.diag(step)))
    gap = _height(design, path, 1, aside, basis) - _height(design, path, 0, aside, basis)
    assert (gap[:2] + gap[2:]) / step**2 == pytest.approx(relative.curvature[0], rel=2e-3)
    ellipse = contact_ellipse(path)
    tips = np.array(((0.1 * ellipse.semi_axes[0, 0], 0.1 * ellipse.semi_axes[0, 1]), (0.0, 0.0)))
    tips[1] = tips[0] * (1.0, -1.0)
    tips = np.concatenate((tips, -tips))
    gap = _height(design, path, 1, tips, basis) - _height(design, path, 0, tips, basis)
    assert 0.5 * (gap[:2] + gap[2:]) == pytest.approx(2.0 * 0.01 * 0.00635, rel=5e-3)


def test_curvatures_without_an_ellipse_have_a_status() -> None:
    """A line contact, a saddle, two surfaces that overlap all around, and a position without contact have
    their status."""
    curvature = np.array([[0.0, 0.05], [-0.01, 0.05], [-0.05, -0.01], [np.nan, np.nan], [0.01, 0.05]])
    found = curvature_ellipse(RelativeCurvature(curvature, np.zeros((5, 2, 3))), 0.01)
    wanted = [EllipseStatus.LINE_CONTACT, EllipseStatus.INTERFERENCE, EllipseStatus.INTERFERENCE]
    assert found.status.tolist() == [*wanted, EllipseStatus.NO_CONTACT, EllipseStatus.ELLIPSE]
    known = np.isfinite(found.semi_axes)
    assert known.tolist() == [[False, True], [False, True], [False, False], [False, False], [True, True]]
    assert found.semi_axes[0, 1] == pytest.approx(np.sqrt(0.4))
    for separation in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="separation must be a positive length"):
            contact_ellipse(path_of_contact(table1(), "left", 3), separation)
