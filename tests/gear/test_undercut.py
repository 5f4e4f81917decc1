"""Undercut and pointed teeth against handbook formulas and the sweep of the tool."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FloatArray
from beveloid_geom.design.member import unchecked
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.gear.flank_limits import root_parameter
from beveloid_geom.gear.rack import rack_of
from beveloid_geom.gear.undercut import (
    pointed_part,
    regular_start,
    require_flanks,
    undercut_of,
    undercut_text,
)
from tests.oracle.table1 import table1
from tests.oracle.tool_sweep import clearance_of_round

PINION, GEAR = table1().members
FEW = Member(Tool(6.0, radians(20.0)), 12, radians(6.0), radians(5.0), 0.2, 40.0)
SPUR = Member(Tool(6.0, radians(20.0)), 10, 0.0, 0.0, 0.0, 20.0)
CONVEX = replace(PINION, tool=replace(PINION.tool, parabola=-0.01))
UNDERCUT = {
    "spur": SPUR,
    "almost sharp tool": replace(SPUR, tool=replace(SPUR.tool, tip_radius=0.02)),
    "beveloid": FEW,
    "left-hand": replace(FEW, helix_angle=-FEW.helix_angle),
    "convex": CONVEX,
    "concave": replace(FEW, tool=replace(FEW.tool, parabola=0.002)),
}
undercut_members = pytest.mark.parametrize("member", UNDERCUT.values(), ids=UNDERCUT)


@pytest.mark.parametrize("alpha_deg", [14.5, 20.0, 25.0])
@pytest.mark.parametrize("tip_radius", [0.0, 0.3])
@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_spur_gears_are_undercut_below_the_handbooks_number_of_teeth(
    flank: str, alpha_deg: float, tip_radius: float, shift: float
) -> None:
    alpha = radians(alpha_deg)
    height = 1.25 - tip_radius * (1.0 - sin(alpha))
    limit = 2.0 * (height - shift) / sin(alpha) ** 2
    member = Member(Tool(2.0, alpha, tip_radius=tip_radius), 20, 0.0, 0.0, shift, 10.0)
    for teeth, expected in ((limit * 0.9999, True), (limit * 1.0001, False)):  # parts of a tooth
        assert undercut_of(unchecked(member, teeth=teeth), flank, 2).undercut is expected


@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_undercut_of_an_involute_ends_where_the_joint_meets_the_base_cylinder(
    flank: str, hand: float
) -> None:
    """The contact point of the joint is r_P sin^2 of the transverse pressure angle below the pitch line;
    its height is linear along the trace."""
    member = replace(FEW, helix_angle=hand * FEW.helix_angle)
    rack, found = rack_of(member, flank), undercut_of(member, flank, 5)
    nx, ny, _ = rack.normal
    below = -float(rack.pitch_radius) * nx**2 / (nx**2 + ny**2)
    start = rack.apex + found.joint * rack.direction
    u = (below - start[0]) / rack.trace[0]
    assert found.limits == pytest.approx((-20.0, start[2] + u * rack.trace[2]), abs=1e-5)
    assert found.worst == 0


def test_an_involute_is_regular_from_its_base_cylinder_on(flank: str) -> None:
    """The base cylinder is where the flank folds back; with more teeth the flank is regular from its root
    on."""
    z = np.array([-10.0, 0.0, 10.0])
    l = regular_start(SPUR, flank, z)
    points = flank_point(SPUR, flank, l, z=z)
    base = 0.5 * 6.0 * 10.0 * cos(radians(20.0))
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), base, atol=1e-6)
    many = unchecked(SPUR, teeth=30)
    np.testing.assert_allclose(
        regular_start(many, flank, z), root_parameter(many, flank), rtol=0.0, atol=1e-12
    )


def on_flank(member: Member, flank: str, l: float, z: float) -> FloatArray:
    return flank_point(member, flank, l, z=z)


@undercut_members
def test_the_flank_starts_where_the_round_ceases_to_cut_it(member: Member, flank: str) -> None:
    found = undercut_of(member, flank, 5)
    assert found.undercut
    for i in range(5):
        if found.lost[i] > 0.1:
            l = found.start[i] + np.array([-0.02, 0.02, 0.5])
            points = np.stack([on_flank(member, flank, float(value), float(found.z[i])) for value in l])
            clearance = clearance_of_round(member, flank, points)
            assert clearance[0] < 0.0
            assert (clearance[1:] > 0.0).all()


@pytest.mark.parametrize("name", ["spur", "almost sharp tool", "beveloid"])
def test_the_neck_is_tangent_to_the_tool_round(name: str) -> None:
    """A line at the distance `neck` behind the radial line through the start of the flank is just touched by
    the tool round: a line 0.003 mm nearer is cut, one 0.003 mm further away is not."""
    member = UNDERCUT[name]
    found = undercut_of(member, "right", 5)
    x, y, z = on_flank(member, "right", float(found.start[0]), float(found.z[0]))
    radius = np.linspace(np.hypot(x, y) - 3.0, np.hypot(x, y), 301)[:-10]
    for more, cut in ((-0.003, True), (0.003, False)):
        angle = np.arctan2(y, x) - (found.neck[0] + more) / radius
        line = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.full_like(radius, z)), axis=-1)
        assert bool((clearance_of_round(member, "right", line) < 0.0).any()) is cut
    assert found.neck[0] > 0.1


def test_table_1_is_sound_and_convex_its_pinion_is_undercut() -> None:
    for member in (PINION, GEAR, replace(GEAR, tool=CONVEX.tool)):
        require_flanks(member)
        for flank in ("right", "left"):
            assert not undercut_of(member, flank).undercut
    assert undercut_of(CONVEX, "right").undercut
    require_flanks(CONVEX)
    nothing = replace(FEW, teeth=8, cone_angle=radians(20.0), profile_shift=-0.5, face_width=60.0)
    with pytest.raises(ValueError, match=r"undercut .* removed completely"):
        require_flanks(nothing)


def test_slight_undercut_loses_1_5_times_the_folded_length() -> None:
    """Near its cusp the involute is y = +/- x^(3/2) in scaled units, where x grows with the square of l.

    The tool edge at x0 on the folded part continues along the tangent there and meets the other part where
    2 t^(3/2) + 3 t = 1, t = x/x0 = 1/4: at half the distance from the cusp in l.
    """
    alpha, less = radians(20.0), 1e-3
    limit = 1.25 - 0.38 * (1.0 - sin(alpha)) - 5.0 * sin(alpha) ** 2
    lost = undercut_of(replace(SPUR, profile_shift=limit - less), "right", 3).lost
    np.testing.assert_allclose(lost, 1.5 * 6.0 * less / cos(alpha), rtol=0.002)


def test_a_flank_can_be_lost_altogether() -> None:
    stub = replace(SPUR, teeth=5, tool=replace(SPUR.tool, addendum=0.2, tip_radius=0.0), profile_shift=-0.5)
    found = undercut_of(stub, "right", 3)
    assert np.isnan(found.start).all()
    assert np.isinf(found.lost).all()
    assert undercut_text(found) == "along the complete face, and removed completely at z = -10 mm"


def test_pointed_part_is_where_the_involutes_meet() -> None:
    """The pointed part of a spur beveloid begins where the involutes of both flanks meet. Shift and tip
    increase along the face; the thickness follows from the involute function."""
    gamma, alpha, module, teeth, shift = radians(8.0), radians(20.0), 3.0, 14, 0.5
    member = Member(Tool(module, alpha), teeth, 0.0, gamma, shift, 30.0)
    transverse, pitch = np.arctan(tan(alpha) * cos(gamma)), 0.5 * module * teeth

    def involute(angle: float) -> float:
        return tan(angle) - angle

    def thickness(z: float) -> float:
        rise = shift * module + z * tan(gamma)
        tip = pitch + rise + module
        at_tip = np.arccos(pitch * cos(transverse) / tip)
        half = (0.25 * pi * module + rise * tan(transverse)) / pitch
        return 2.0 * tip * float(half + involute(float(transverse)) - involute(float(at_tip)))

    assert pointed_part(member) == pytest.approx((brentq(thickness, -15.0, 15.0), 15.0), abs=1e-5)
    assert np.isnan(pointed_part(PINION)).all()
