"""Dimensions for drawings: ISO 21771 and DIN 21773 for cylindrical gears, brute force for others."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

from beveloid_geom import Member, Tool, builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.operation.backlash import lever_of, mounted_backlash
from beveloid_geom.operation.first_contact import first_contact
from beveloid_geom.workshop.tooth_data import backlash_change, tooth_data
from tests.members import MEMBERS

ALPHA, MODULE = radians(20.0), 4.0
TOOL = Tool(MODULE, ALPHA)
CYLINDRICAL = [(24, 0.0, 0.0), (17, 0.0, 0.35), (31, 28.0, -0.1), (40, -12.0, 0.3), (90, 41.0, 0.0)]


@pytest.mark.parametrize(("teeth", "helix_deg", "x"), CYLINDRICAL)
def test_cylindrical_gears_agree_with_the_standards(teeth: int, helix_deg: float, x: float) -> None:
    """ISO 21771: d_a, d_f, d_b, s_n, d_Ff of a hob; DIN 21773 (2), (5): the chord on the V-cylinder."""
    beta, alpha_t = radians(helix_deg), atan(tan(ALPHA) / cos(radians(helix_deg)))
    d = teeth * MODULE / cos(beta)
    found = tooth_data(Member(TOOL, teeth, beta, 0.0, x, 30.0))
    base, thickness = d * cos(alpha_t), MODULE * (pi / 2 + 2 * x * tan(ALPHA))
    depth = (1.25 - 0.38 * (1 - sin(ALPHA)) - x) * MODULE  # of the straight part below the pitch line
    form = sqrt((d * sin(alpha_t) - 2 * depth / sin(alpha_t)) ** 2 + base**2)
    v = d + 2 * x * MODULE
    helix_v = atan(tan(beta) * v / d)
    alpha_v = np.arccos(base / v)
    angle = thickness / cos(beta) / d + tan(alpha_t) - alpha_t - tan(alpha_v) + alpha_v
    normal_v = v * angle * cos(helix_v)
    psi = normal_v * cos(helix_v) / v
    expected = {
        "tip_diameter": d + 2 * (x + 1) * MODULE,
        "root_diameter": d + 2 * (x - 1.25) * MODULE,
        "form_diameter": form,
        "base_diameter": base,
        "reference_diameter": d,
        "normal_thickness": thickness,
        "chord_diameter": v,
        "chordal_thickness": hypot(normal_v * sin(helix_v), v * sin(psi)),
        "chordal_height": 0.5 * d + (x + 1) * MODULE - 0.5 * v * cos(psi),
        "infeed": 0.0,
        "swivel": beta,
    }
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("cone_deg", [2.0, 8.0, -5.0])
def test_the_thickness_of_a_spur_beveloid_grows_linearly(cone_deg: float) -> None:
    """The thickness grows by 2 tan(alpha_t) tan(gamma) per mm; alpha_t is the pressure angle in the plane
    z."""
    gamma = radians(cone_deg)
    found = tooth_data(Member(TOOL, 36, 0.0, gamma, 0.1, 30.0))
    rate = 2 * (tan(ALPHA) * cos(gamma)) * tan(gamma)
    np.testing.assert_allclose(np.diff(found.normal_thickness[0]) / 15.0, rate, atol=1e-12)
    middle = MODULE * (pi / 2 + 0.2 * tan(ALPHA) * cos(gamma))
    assert found.normal_thickness[0, 1] == pytest.approx(middle, abs=1e-12)
    np.testing.assert_allclose(np.diff(found.root_diameter) / 30.0, found.infeed, atol=1e-12)


def brute_chord(member: Member, radius: float, z: float) -> tuple[float, float]:
    """Return thickness and chord on a cylinder, perpendicular to the middle of the tooth, from curves of
    points."""
    slope = radius * tan(member.helix_angle) * cos(member.cone_angle)
    slope /= 0.5 * float(member.tool.normal_module * member.teeth) / cos(member.helix_angle)
    beta = atan(slope)
    curves = {flank: trace_on(member, flank, radius, z) for flank in ("right", "left")}
    middle = 0.5 * sum(np.interp(z, *curve) for curve in curves.values())
    ends = []
    for curve in curves.values():
        beside, angle = curve
        along = (angle - middle) * radius * sin(beta) + (beside - z) * cos(beta)  # along the tooth's middle
        ends.append((np.interp(0.0, along, beside), np.interp(0.0, along, angle)))
    (z1, a1), (z2, a2) = ends
    return hypot(radius * (a1 - a2), z1 - z2), hypot(2 * radius * sin(0.5 * (a1 - a2)), z1 - z2)


def trace_on(member: Member, flank: str, radius: float, z: float) -> tuple[FloatArray, FloatArray]:
    """Return z and angle of points of a flank on a cylinder, by bisection in l."""
    beside = z + np.linspace(-4.0, 4.0, 4001)
    low, high = np.full(beside.shape, -9.0), np.full(beside.shape, 9.0)
    for _ in range(60):
        l = 0.5 * (low + high)
        point = flank_point(member, flank, l, z=beside)
        above = np.hypot(point[:, 0], point[:, 1]) > radius
        low, high = np.where(above, low, l), np.where(above, l, high)
    return beside, np.arctan2(point[:, 1], point[:, 0])


@pytest.mark.parametrize("name", ["pinion", "gear", "concave", "convex", "cone 20"])
def test_chords_of_beveloids_agree_with_a_caliper(name: str) -> None:
    member = MEMBERS[name]
    found = tooth_data(member)
    for k, z in enumerate(found.z):
        _, chord = brute_chord(member, 0.5 * float(found.chord_diameter[k]), float(z))
        assert found.chordal_thickness[0, k] == pytest.approx(chord, abs=2e-6)
    thickness, _ = brute_chord(member, 0.5 * found.reference_diameter, 0.0)
    assert found.normal_thickness[0, 1] == pytest.approx(thickness, abs=2e-6)


def test_form_diameters_are_above_undercut() -> None:
    """Flanks of an undercut spur gear begin above the base circle, where the fillet intersects them."""
    few = Member(TOOL, 11, 0.0, 0.0, 0.0, 30.0)
    sound = tooth_data(replace(few, profile_shift=0.5))
    cut = tooth_data(few)
    assert (cut.form_diameter > cut.base_diameter[:, None] + 0.1).all()
    assert (sound.form_diameter < cut.form_diameter + 2.0 * 0.5 * MODULE).all()
    l = tip_parameter(few, "right", 0.0)
    assert (cut.form_diameter < 2.0 * np.hypot(*flank_point(few, "right", l, 0.0)[:2])).all()


def test_mirrored_members_have_the_same_dimensions() -> None:
    first = MEMBERS["pinion"]
    one, other = tooth_data(first), tooth_data(replace(first, helix_angle=-first.helix_angle))
    for name, value in vars(one).items():
        turned = np.flip(value, axis=0) if name in ("form_diameter", "base_diameter") else value
        sign = -1.0 if name == "swivel" else 1.0
        np.testing.assert_allclose(getattr(other, name), sign * np.asarray(turned), rtol=1e-13, atol=1e-13)


def test_thickness_changes_the_backlash() -> None:
    """The change of the backlash by an allowance equals that of first contacts of rotated flanks: exactly
    without parabolas, approximately with them."""
    thinner = np.array([-0.06, -0.09])
    for parabola, close in ((0.0, 1e-11), (0.001, 2e-5)):
        design = builtin_design().with_parabola(parabola, -parabola)
        teeth = np.array([float(member.teeth) for member in design.members])
        turn = thinner / (float(design.pinion.tool.normal_module) * teeth)
        roll = float(mounted_backlash(design).pinion_roll) + np.linspace(0.0, 2.0 * pi / teeth[0], 97)
        # The flanks of a thinner tooth are those of the design, turned: a member's roll and its own turn.
        right = first_contact(design, "right", roll + turn[0]).gear_roll - turn[1]
        left = first_contact(design, "left", roll - turn[0]).gear_roll + turn[1]
        plain = first_contact(design, "right", roll).gear_roll - first_contact(design, "left", roll).gear_roll
        moved = float(lever_of(design)) * (np.min(right - left) - np.min(plain))
        assert float(backlash_change(design, *thinner)) == pytest.approx(moved, abs=close)
        assert moved > 0.1
