"""The generated flank against closed forms: involute helicoids, spur gears, the shift of the paper."""

from __future__ import annotations

from dataclasses import replace
from math import radians, tan

import numpy as np
import pytest
from hypothesis import given, strategies as st

from beveloid_geom import Member, Tool
from beveloid_geom.gear.flank import flank_patch, flank_point, trace_parameter
from beveloid_geom.gear.flank_limits import highest_parameter, root_parameter, tip_parameter, tip_radius
from beveloid_geom.gear.rack import reference_radius, section_point
from beveloid_geom.gear.undercut import undercut_margin
from tests.oracle.table1 import table1

PAIR = table1()
FLANKS = ("right", "left")


def spur(teeth: int, profile_shift: float = 0.0, module: float = 2.0) -> Member:
    return Member(Tool(module, radians(20.0)), teeth, 0.0, 0.0, profile_shift, 20.0)


def members() -> st.SearchStrategy[Member]:
    angle = st.floats(-0.5, 0.5)
    tool = st.builds(Tool, st.floats(0.5, 10.0), st.floats(0.3, 0.5), parabola=st.floats(-0.003, 0.003))
    return st.builds(
        Member, tool, st.integers(20, 90), angle, st.floats(-0.1, 0.1), st.floats(-0.3, 0.5), st.just(20.0)
    )


@given(members(), st.sampled_from(FLANKS), st.floats(-1.0, 1.0), st.floats(-10.0, 10.0))
def test_normal_is_perpendicular_to_exact_tangents(
    member: Member, flank: str, height: float, u: float
) -> None:
    l = height * member.tool.normal_module
    patch = flank_patch(member, flank, l, u)
    assert np.linalg.norm(patch.normal) == pytest.approx(1.0, abs=1e-14)
    for tangent in (patch.tangent_l, patch.tangent_u):
        assert abs(patch.normal @ tangent) < 1e-13
    step = 1e-4 * member.tool.normal_module
    for tangent, dl, du in ((patch.tangent_l, step, 0.0), (patch.tangent_u, 0.0, step)):
        ahead, behind = (flank_point(member, flank, l + s * dl, u + s * du) for s in (1, -1))
        np.testing.assert_allclose((ahead - behind) / (2 * step), tangent, atol=1e-6)


@pytest.mark.parametrize("member", PAIR.members)
def test_profile_shift_is_the_papers_axial_shift(member: Member, flank: str) -> None:
    """The flank with profile shift equals Eq. 6 without shift, at b_c further along the axis, rotated by b_c
    tan(beta)/(cos(gamma) r_P)."""
    shift = member.profile_shift * member.tool.normal_module / tan(member.cone_angle)
    turn = shift * tan(member.helix_angle) / (np.cos(member.cone_angle) * reference_radius(member))
    l, z = np.linspace(-6, 6, 5), np.linspace(-25, 25, 5)
    plain = replace(member, profile_shift=0.0)
    ours = flank_point(member, flank, l, z=z)
    theirs = flank_point(plain, flank, l, z=z + shift)
    turned = (ours[..., 0] + 1j * ours[..., 1]) * np.exp(1j * turn)
    np.testing.assert_allclose(turned.real, theirs[..., 0], atol=1e-12)
    np.testing.assert_allclose(turned.imag, theirs[..., 1], atol=1e-12)
    np.testing.assert_allclose(ours[..., 2] + shift, theirs[..., 2], atol=1e-12)


@pytest.mark.parametrize(("coefficient", "metal"), [(0.0001, 1.0), (-0.0001, -1.0)])
def test_figure_6_sign_of_the_parabola(flank: str, coefficient: float, metal: float) -> None:
    """a > 0 leaves material at tip and root (a concave tooth), a < 0 removes it (convex)."""
    member = PAIR.pinion
    bent = replace(member, tool=replace(member.tool, parabola=coefficient))
    for l in (-5.0, 5.0):
        patch = flank_patch(member, flank, l, z=0.0)
        moved = flank_point(bent, flank, l, z=0.0) - patch.point
        assert moved @ patch.normal == pytest.approx(metal * 1e-4 * l * l, rel=0.02)  # a l^2
    assert np.allclose(flank_point(bent, flank, 0.0, 1.0), flank_point(member, flank, 0.0, 1.0))


def test_points_are_given_by_the_distance_from_mid_face_or_along_the_trace(flank: str) -> None:
    member, l, z = PAIR.gear, np.linspace(-5.0, 5.0, 4), np.linspace(-20.0, 20.0, 4)
    points = flank_point(member, flank, l, z=z)
    assert np.abs(points[:, 2] - z).max() < 1e-13
    u = trace_parameter(member, flank, l, z)
    assert np.array_equal(points, flank_point(member, flank, l, u))
    assert np.array_equal(points, flank_patch(member, flank, l, z=z).point)
    for places in ({}, {"u": u, "z": z}):
        with pytest.raises(TypeError, match="the flank parameter u or the distance z"):
            flank_point(member, flank, l, **places)


def test_a_large_tool_round_raises_the_start_of_the_flank() -> None:
    tool = Tool(6.0, radians(20.0), tip_radius=0.45)
    member = replace(PAIR.pinion, tool=tool)
    joint = -(1.25 - 0.45 * (1.0 - np.sin(radians(20.0)))) * 6.0
    assert section_point(tool, "right", root_parameter(member, "right"))[0] == pytest.approx(joint, rel=1e-14)


def test_spur_undercut_begins_below_18_teeth(flank: str) -> None:
    """The textbook's limit is 2 / sin(20 deg)^2 = 17.097 teeth without shift."""
    assert undercut_margin(spur(17), flank) < 0.0 < undercut_margin(spur(18), flank)
    needed = 1.0 - 12 * np.sin(radians(20.0)) ** 2 / 2.0
    assert (
        undercut_margin(spur(12, needed - 1e-3), flank)
        < 0.0
        < undercut_margin(spur(12, needed + 1e-3), flank)
    )


def test_the_tip_is_found_on_the_flank_or_not_at_all() -> None:
    """For steep cones and strong parabolas, the tip is found on the flank or is NaN. Newton's method alone
    converges far away from the tooth."""
    rng = np.random.default_rng(1)
    for _ in range(300):
        module, alpha = rng.uniform(0.5, 10.0), np.radians(rng.uniform(14.0, 28.0))
        folds = np.cos(alpha) ** 2 / (4.0 * np.sin(alpha) * 1.25 * module)
        tool = Tool(module, alpha, parabola=rng.uniform(-0.9, 0.9) * folds)
        helix, cone = np.radians(rng.uniform((-45.0, -20.0), (45.0, 20.0))).tolist()
        member = Member(tool, int(rng.integers(12, 80)), helix, cone, rng.uniform(-0.3, 0.6), 8.0 * module)
        z = np.linspace(-4.0, 4.0, 33) * module
        for flank in ("right", "left"):
            l = tip_parameter(member, flank, z)
            found = np.isfinite(l)
            assert (l[found] >= root_parameter(member, "right")).all()
            assert (l[found] <= highest_parameter(member, "right") * (1.0 + 1e-12)).all()
            point = flank_point(member, flank, l, z=z)
            radius, tip = np.hypot(point[..., 0], point[..., 1]), tip_radius(member, z)
            np.testing.assert_allclose(radius[found], tip[found], rtol=1e-12, atol=0)
