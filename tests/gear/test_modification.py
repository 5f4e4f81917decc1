"""Flank points with modifications."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Member, Modification, Tool, path_of_contact
from beveloid_geom.arrays import FloatArray, Quantity, flank_sign
from beveloid_geom.design.arguments import ModifiedFlanksError
from beveloid_geom.design.modification import kind
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.fillet import fillet_point, tool_round
from beveloid_geom.gear.flank import base_cylinder, flank_patch, flank_point, half_thickness_angle
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.gear.tooth_side import cut_at, fillet_points, side_points, surface_of
from beveloid_geom.shapes.sampling import flank_sheet
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.oracle.table1 import table1

ALL = Modification(
    helix_slope_um=7.0,
    helix_crowning_um=10.0,
    profile_slope_um=-4.0,
    profile_crowning_um=9.0,
    twist_um=12.0,
    tip_relief_um=20.0,
    tip_relief_length_mm=4.0,
    root_relief_um=15.0,
    root_relief_length_mm=3.0,
    heel_relief_um=12.0,
    heel_relief_length_mm=15.0,
    toe_relief_um=11.0,
    toe_relief_length_mm=9.0,
)


def depth(member: Member, flank: str, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return the depth (mm) along the base tangent from the rotation of the flank points."""
    plain = member.modified(None)
    points = [flank_point(one, flank, l, z=z) for one in (plain, member)]
    (x0, y0, z0), (x1, y1, z1) = (np.moveaxis(point, -1, 0) for point in points)
    assert np.abs(np.hypot(x0, y0) - np.hypot(x1, y1)).max() < 1e-12
    assert np.abs(z0 - z1).max() < 1e-12
    turn = np.arctan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1)
    return np.asarray(-flank_sign(flank) * turn * base_cylinder(member, flank).radius)


@pytest.mark.parametrize("number", [0, 1])
def test_depths_at_the_corners(number: int, flank: str) -> None:
    """Depths at the corners and in the middle of the flank follow the definitions of ISO 21771."""
    member = table1().members[number]
    half = 0.5 * float(member.face_width)
    low, high = float(root_parameter(member, flank)), float(tip_parameter(member, flank, 0.0))
    l, z = np.meshgrid((low, 0.5 * (low + high), high), (-half, 0.0, half), indexing="ij")
    lam, zeta = np.meshgrid((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), indexing="ij")
    none, length = 0.0 * lam, 0.25 * (high - low)
    cases = {
        "helix_slope": (0.5 * zeta, {}),
        "helix_crowning": (zeta**2, {}),
        "profile_slope": (0.5 * lam, {}),
        "profile_crowning": (lam**2, {}),
        "twist": (0.25 * lam * zeta, {}),
        "tip_relief": (none + (lam > 0.0), {"tip_relief_length_mm": length}),
        "root_relief": (none + (lam < 0.0), {"root_relief_length_mm": length}),
        "heel_relief": (none + (zeta > 0.0), {"heel_relief_length_mm": 5.0}),
        "toe_relief": (none + (zeta < 0.0), {"toe_relief_length_mm": 5.0}),
    }
    for name, (shape, lengths) in cases.items():
        amounts: dict[str, Any] = {f"{name}_um": 30.0, **lengths}
        found = depth(member.modified(Modification(**amounts)), flank, l, z)
        assert np.abs(found - 0.03 * shape).max() < 1e-12, name
    # A relief begins without a kink: half of the length, a quarter of the amount.
    relieved = member.modified(Modification(tip_relief_um=30.0, tip_relief_length_mm=length))
    assert abs(depth(relieved, flank, np.array(high - 0.5 * length), np.array(3.0)) - 0.0075) < 1e-12
    # Positive amounts make the tooth thinner.
    thinner = half_thickness_angle(relieved, flank, high, 0.0) - half_thickness_angle(
        member, flank, high, 0.0
    )
    assert abs(thinner * base_cylinder(member, flank).radius + 0.03) < 1e-12


@pytest.mark.parametrize("parabola", [0.0, 0.001])
def test_normals_and_all_representations_agree(parabola: float, flank: str) -> None:
    """Normals agree with central differences. `flank_patch`, `tooth_surface`, sheets and closest points give
    the same modified flank."""
    plain = table1((parabola, 0.0)).pinion
    member, rng = plain.modified(ALL), np.random.default_rng(2)
    l, z = rng.uniform(-5.9, 6.0, 200), rng.uniform(-25.0, 25.0, 200)
    patch = flank_patch(member, flank, l, z=z)
    surface, step = surface_of(member, flank), 1e-5
    points, normals = side_points(surface, l, z)
    assert np.abs(patch.point - points).max() < 1e-12
    assert np.abs(patch.normal - normals).max() < 1e-13
    assert np.abs(flank_sheet(member, flank).place(l, z)[0] - points).max() < 1e-12
    for a, b in ((step, 0.0), (0.0, step)):
        tangent = side_points(surface, l + a, z + b)[0] - side_points(surface, l - a, z - b)[0]
        assert np.abs((tangent * normals).sum(axis=-1)).max() < 1e-8 * step * 10.0
    nominal = flank_patch(plain, flank, l, z=z)
    assert ((nominal.normal * patch.normal).sum(axis=-1) > 0.999).all()
    assert np.array_equal(nominal.regularity, patch.regularity)
    single = flank_patch(member, flank, l[0], z=z[0])
    assert np.abs(single.point - patch.point[0]).max() < 1e-13
    assert np.abs(single.normal - patch.normal[0]).max() < 1e-14
    away = rng.uniform(-1.0, 1.0, 200)
    foot = feet(member, flank, points + away[:, None] * normals)
    assert np.abs(foot.l - l).max() < 1e-11
    assert np.abs(foot.z - z).max() < 1e-11
    assert np.abs(foot.distance - away).max() < 1e-12


def test_flank_and_fillet_meet(flank: str) -> None:
    """Modified flank and fillet meet at the joint of a sound tooth, and at the intersection of an undercut
    one."""
    few = Member(Tool(6.0, np.radians(20.0)), 14, 0.1, np.radians(3.0), 0.0, 30.0)
    for member in (table1().pinion.modified(ALL), few.modified(ALL)):
        surface, z = surface_of(member, flank), np.linspace(-14.0, 14.0, 9)
        upper = side_points(surface, surface.flank_start(z), z)[0]
        lower = side_points(surface, surface.fillet_end(z) - 1e-12, z)[0]
        assert np.abs(upper - lower).max() < 2e-11
        # The fillet is rotated rigidly in each plane.
        angle = np.linspace(tool_round(member.tool, flank).angle + 1e-9, 1.5, 5)[:, None] + 0.0 * z
        moved = fillet_points(member, flank, angle, z + 0.0 * angle)[0]
        before = fillet_point(member.modified(None), flank, angle, z + 0.0 * angle)[0]
        turn = np.arctan2(moved[..., 1], moved[..., 0]) - np.arctan2(before[..., 1], before[..., 0])
        assert np.ptp(turn, axis=0).max() < 1e-13
    assert surface_of(few, flank).crossing is not None


def test_modifications_belong_to_their_side(flank: str) -> None:
    design = table1()
    other = "left" if flank == "right" else "right"
    given = replace(design, gear=design.gear.modified(ALL, other))
    assert np.array_equal(path_of_contact(given, flank).l1, path_of_contact(design, flank).l1)
    assert not np.array_equal(path_of_contact(given, other).l1, path_of_contact(design, other).l1)
    with pytest.raises(ModifiedFlanksError, match=r"remove \[gear.modification\]"):
        path_of_contact_five_equations(given, other)


def test_helix_crowning_needs_no_tip_at_mid_face(flank: str) -> None:
    """With this profile shift the flank does not reach its tip cone, so that the profile has no extent."""
    pinion = replace(table1().pinion, profile_shift=-2.5)
    assert np.isnan(tip_parameter(pinion, flank, 0.0))
    l, z = np.array((0.0, 1.0)), np.array((3.0, -9.0))
    plain, crowned = (
        flank_point(member, flank, l, z)
        for member in (pinion, pinion.modified(Modification(helix_crowning_um=10.0)))
    )
    assert 0.0 < np.linalg.norm(crowned - plain, axis=-1).max() < 0.01


def _bias(lam: Any, zeta: Any) -> tuple[Any, ...]:
    u, v = 1.0 + lam, 1.0 + zeta
    return u * u * v, 2.0 * u * v, u * u, 2.0 * v, 2.0 * u, 0.0


@dataclass(frozen=True)
class Biased(Modification):
    """A modification with a further kind of amount, which needs one function and one field."""

    bias_um: Quantity = field(default=0.0, metadata=kind(_bias))


def test_a_new_kind_is_one_function_and_one_row(flank: str) -> None:
    member = table1().pinion.modified(Biased(bias_um=5.0, helix_slope_um=2.0))
    low, high = float(root_parameter(member, flank)), float(tip_parameter(member, flank, 0.0))
    found = depth(member, flank, np.array((low, high)), np.array((25.0, 25.0)))
    assert np.abs(found - (0.001, 0.041)).max() < 1e-12
    surface, l, z = surface_of(member, flank), np.array((1.0, -2.0)), np.array((3.0, -9.0))
    step = 1e-4
    for name, change in (("phi_s", (step, 0.0)), ("phi_z", (0.0, step))):
        above, below = (cut_at(surface, l + k * change[0], z + k * change[1]).phi for k in (1.0, -1.0))
        assert np.abs((above - below) / (2.0 * step) - getattr(cut_at(surface, l, z), name)).max() < 1e-10
