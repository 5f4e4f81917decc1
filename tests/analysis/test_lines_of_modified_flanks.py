"""Lines of contact of modified flanks on parallel axes, and the pressures along them.

The reference follows from ISO 21771. In the plane of action, a contact has the distances rho_1 and rho_2 from
the base tangent points of pinion and gear, whose sum is constant. Each line is divided into short pieces, and
the middle of each piece is compared with the limits of the flanks and the beginnings of the reliefs.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Load,
    Member,
    Modification,
    Pair,
    Tool,
    builtin_design,
    path_of_contact,
    path_pressure,
)
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.contact.ellipse import relative_curvature
from beveloid_geom.contact.hertz import contact_modulus
from beveloid_geom.contact.parallel.lines import contact_lines
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter
from beveloid_geom.status import Limit

WIDTH, PIECES = 24.0, 20000
TIPS: tuple[dict[str, Any], dict[str, Any]] = (
    {"tip_relief_um": 20.0, "tip_relief_length_mm": 1.2},
    {"tip_relief_um": 15.0, "tip_relief_length_mm": 0.8},
)
ENDS = (
    {"heel_relief_um": 15.0, "heel_relief_length_mm": 7.0},
    {"toe_relief_um": 10.0, "toe_relief_length_mm": 3.0},
)
ALL = TIPS[0] | ENDS[1], TIPS[1] | ENDS[0]


def pair_with(helix: float, amounts: tuple[dict[str, Any], dict[str, Any]]) -> Design:
    """Return a pair on parallel axes, module 3, 25 and 40 teeth, with these modifications of both flanks."""
    tool, angles = Tool(3.0, radians(20.0)), (helix, -helix)
    pinion, gear = (
        Member(tool, teeth, angle, 0.0, 0.0, WIDTH).modified(Modification(**given))
        for teeth, angle, given in zip((25, 40), angles, amounts, strict=True)
    )
    return Design(pinion, gear, Pair(1.5 * 65 / cos(helix) + 0.2, 0.0, 0.0, 0.0))


def not_relieved(member: Member, flank: str, base: float, distance: FloatArray, z: FloatArray) -> Mask:
    """Return which points at a distance (mm) from the tangent point are on the flank and not relieved."""
    given: Any
    given, l = member.modification(flank), np.linspace(-6.0, 6.0, 4001)
    radius = np.hypot(*flank_point(member, flank, l, z=0.0).T[:2])
    tip = 1.5 * float(member.teeth) / cos(float(member.helix_angle)) + 3.0
    at, top = (np.interp(r, radius, l) for r in (np.hypot(base, distance), tip))
    result = (distance > 0.0) & (at <= top + 1e-9)
    if given.tip_relief_um:
        result &= at <= top - given.tip_relief_length_mm
    if given.heel_relief_um:
        result &= z <= 0.5 * WIDTH - given.heel_relief_length_mm
    if given.toe_relief_um:
        result &= z >= given.toe_relief_length_mm - 0.5 * WIDTH
    return result


@pytest.mark.parametrize("helix", [0.0, 0.15, -0.4])
@pytest.mark.parametrize("amounts", [TIPS, ENDS, ALL], ids=["tips", "ends", "all"])
def test_lines_without_their_reliefs(
    helix: float, amounts: tuple[dict[str, Any], dict[str, Any]], flank: str
) -> None:
    """Ends and length of the lines, total length of all tooth pairs, and pressure p0^2 = q E* kappa / pi with
    kappa = cos(beta_b) (1 / rho_1 + 1 / rho_2)."""
    design = pair_with(helix, amounts)
    path = path_of_contact(design, flank, 15)
    lines, found = contact_lines(path), path_pressure(path, Load(force=1e3))
    transverse, base_helix = (
        np.arctan(tan(radians(20.0)) / cos(helix)),
        np.arcsin(sin(helix) * cos(radians(20.0))),
    )
    base = [1.5 * teeth / cos(helix) * cos(transverse) for teeth in (25, 40)]
    between = float(design.pair.offset) * sin(np.arccos(sum(base) / float(design.pair.offset)))
    z = WIDTH * ((np.arange(PIECES) + 0.5) / PIECES - 0.5)
    piece = WIDTH / PIECES / cos(base_helix)
    lean = tan(base_helix) if flank == "right" else -tan(base_helix)
    conjugate = np.abs(path.transmission_error - np.max(path.transmission_error)) < 1e-9
    assert conjugate.sum() >= 8
    for k in np.flatnonzero(conjugate):
        # A line of the plane of action: rho_1 changes with z by the base helix angle.
        own = sqrt(path.pinion_r[k] ** 2 - base[0] ** 2) + lean * (z - path.pinion_z[k])
        total, length = 0.0, 0.0
        for pair in range(-4, 5):
            first = own + pair * 2.0 * pi * base[0] / 25
            on = np.ones(PIECES, dtype=bool)
            for member, radius, distance in zip(design.members, base, (first, between - first), strict=True):
                on &= not_relieved(member, flank, radius, distance, z)
            total += piece * on.sum()
            if pair == 0 and on.any():
                length, ends = piece * on.sum(), (z[on].min(), z[on].max())
                curvature = cos(base_helix) * (1.0 / first + 1.0 / (between - first))[on].max()
        if length < 0.01:  # the path ends where the last line has become a point
            assert not lines.length[k] > 0.02
            continue
        assert lines.length[k] == pytest.approx(length, abs=5e-3)
        assert lines.pinion_z[k] == pytest.approx(ends, abs=3e-3)
        inside = np.abs(lines.pinion_z[k]) < 0.5 * WIDTH - 0.01
        if amounts == TIPS:
            assert np.isin(lines.limit[k, inside], (Limit.PINION_TIP, Limit.GEAR_TIP)).all()
        assert found.total_length[k] == pytest.approx(total, abs=2e-2)
        pressure = sqrt(1e3 / found.total_length[k] * contact_modulus(206000.0, 0.3) * curvature / pi)
        assert found.pressure[k] == pytest.approx(pressure, rel=1e-4)


def test_teeth_parallel_to_the_axes_touch_along_the_complete_line_on_a_crowned_profile(flank: str) -> None:
    """With a transmission error one tooth pair carries the load. A heel relief shortens its line."""
    crowned = {"profile_crowning_um": 4.0}
    design = pair_with(0.0, (crowned, crowned | ENDS[0]))
    path = path_of_contact(design, flank, 9)
    lines, found = contact_lines(path), path_pressure(path, Load(torque_nm=100.0))
    assert np.ptp(path.transmission_error) > 1e-6
    np.testing.assert_allclose(lines.length, WIDTH - 7.0, atol=1e-12)
    np.testing.assert_allclose(found.total_length, lines.length)
    assert (lines.limit == (Limit.PINION_TOE, Limit.GEAR_HEEL)).all()
    pinion = lines.l1, lines.u1, lines.pinion_r, lines.pinion_z
    gear = lines.l2, lines.u2, lines.gear_r, lines.gear_z
    for member, (l, u, radius, z) in zip(design.members, (pinion, gear), strict=True):
        points = flank_point(member, flank, l, u)
        np.testing.assert_allclose(np.hypot(points[..., 0], points[..., 1]), radius, atol=1e-9)
        np.testing.assert_allclose(points[..., 2], z, atol=1e-12)
    np.testing.assert_allclose(found.curvature[:, 1], relative_curvature(path).curvature[:, 1], rtol=1e-9)


def test_batches_equal_single_designs(flank: str) -> None:
    design = pair_with(0.15, TIPS)
    amounts = np.array([0.0, 5.0, 20.0])
    given = Modification(**TIPS[0])
    batch = replace(design, pinion=design.pinion.modified(replace(given, tip_relief_um=amounts)))
    together = path_pressure(path_of_contact(batch, flank, 7), Load(force=1e3))
    for k, amount in enumerate(amounts.tolist()):
        single = replace(design, pinion=design.pinion.modified(replace(given, tip_relief_um=amount)))
        alone = path_pressure(path_of_contact(single, flank, 7), Load(force=1e3))
        for name in ("pressure", "semi_axes", "total_length", "status"):
            np.testing.assert_allclose(
                getattr(together, name)[k], getattr(alone, name), rtol=1e-7, err_msg=name
            )


@pytest.mark.parametrize("helix", [0.0, 0.15])
@pytest.mark.parametrize("amounts", [TIPS, ({}, {})], ids=["tips", "unmodified"])
def test_pairs_without_a_path_have_no_pressure(
    helix: float, amounts: tuple[dict[str, Any], dict[str, Any]]
) -> None:
    """A single design without contact has empty arrays; with given l1, and in a batch, the values are NaN."""
    design = pair_with(helix, amounts)
    apart = design.with_errors(Errors(offset=20.0))
    path = path_of_contact(apart, "right", 5)
    assert contact_lines(path).length.shape == path_pressure(path, Load(force=1e3)).pressure.shape == (0,)
    given = path_of_contact(apart, "right", l1=[0.0, 0.1])
    assert np.isnan(path_pressure(given, Load(force=1e3)).pressure).all()
    assert np.isnan(contact_lines(given).length).all()
    errors = Errors(shaft_angle=np.array([0.0, 1e-3]))
    found = path_pressure(path_of_contact(design.with_errors(errors), "right", 5), Load(force=1e3)).pressure
    assert np.isfinite(found[0, :-1]).all()
    tilted = path_of_contact(design.with_errors(Errors(shaft_angle=1e-3)), "right", 5)
    alone = path_pressure(tilted, Load(force=1e3)).pressure  # empty without a path
    np.testing.assert_allclose(found[1], alone if alone.size else np.full(5, np.nan), rtol=1e-7)


def test_crossed_axes_have_no_lines(flank: str) -> None:
    design = builtin_design()
    relieved = replace(design, pinion=design.pinion.modified(Modification(**TIPS[0])))
    assert np.isnan(contact_lines(path_of_contact(relieved, flank, 5)).length).all()


def test_reliefs_with_parabolas_of_one_rack_have_no_lines(flank: str) -> None:
    """Parabolas of opposite sign on reference cylinders that touch have line contact, along curves on the
    tools. With reliefs the ends of these lines are not computed."""
    design = pair_with(0.15, TIPS)
    design = replace(design, pair=replace(design.pair, offset=1.5 * 65 / cos(0.15))).with_parabola(
        2e-3, -2e-3
    )
    path = path_of_contact(design, flank, 7)
    assert (path.status == 0).all()
    assert np.isnan(contact_lines(path).length).all()
    assert np.isnan(path_pressure(path, Load(force=1e3)).total_length).all()


def test_spur_teeth_with_reliefs_and_parabolas_of_one_rack_carry_with_the_line_of_one_pair(
    flank: str,
) -> None:
    """At the ends of the path, the rolls are those without reliefs. The length does not jump there."""
    design = pair_with(0.0, ({"tip_relief_um": 10.0, "tip_relief_length_mm": 0.3}, {}))
    design = replace(design, pair=replace(design.pair, offset=1.5 * 65)).with_parabola(5e-4, -5e-4)
    path = path_of_contact(design, flank, 9)
    lines = contact_lines(path)
    assert np.isfinite(lines.length).all()
    assert np.array_equal(path_pressure(path, Load(force=1e3)).total_length, lines.length)


def test_a_crowned_profile_carries_alone_where_its_depth_is_zero(flank: str) -> None:
    """In the middle of a crowned profile both flanks touch as without crowning; their neighbours do not."""
    tool = Tool(3.0, radians(20.0), addendum=1.3, dedendum=1.5, tip_radius=0.2)
    pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, WIDTH) for teeth in (50, 80))
    design = Design(pinion, gear, Pair(195.2, 0.0, 0.0, 0.0))
    middle = 0.5 * float(root_parameter(pinion, flank) + tip_parameter(pinion, flank, 0.0))
    plain = path_pressure(path_of_contact(design, flank, l1=[middle]), Load(force=1e3))
    assert plain.total_length[0] == pytest.approx(2.0 * WIDTH)
    crowned = replace(design, pinion=pinion.modified(Modification(profile_crowning_um=5.0)))
    found = path_pressure(path_of_contact(crowned, flank, l1=[middle]), Load(force=1e3))
    assert found.total_length[0] == pytest.approx(WIDTH)
