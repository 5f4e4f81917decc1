"""First contact by bisection, with flanks and fillets computed here from the section of the tool."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import radians

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Member,
    first_contact,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.operation.certificate import OVERLAP_TOLERANCE_MODULES
from beveloid_geom.operation.engagement import engagement_of, pitch_point_roll
from beveloid_geom.operation.search.local_clearance import hessian, local_at
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import FirstStatus, Limit, Verdict
from tests.operation.test_first_contact import EDGES
from tests.oracle.bracketed import EPSILON, roots_between
from tests.oracle.table1 import table1
from tests.stability.answers import changed, closed
from tests.stability.five_residuals import cases_of
from tests.stability.named_designs import HARD, Named
from tests.stability.random_designs import random_designs

BOTH = ("right", "left")
AMOUNTS = (
    *("helix_slope_um", "helix_crowning_um", "profile_slope_um", "profile_crowning_um", "twist_um"),
    *("tip_relief_um", "root_relief_um", "heel_relief_um", "toe_relief_um"),
)
"""Amounts of a modification."""
CLOSE = {(0.0, 0.0): -1.2, (0.003, -0.003): -0.9, (0.005, 0.003): -0.9}
"""Parabolas and offset errors for which tips touch fillets."""


@dataclass(frozen=True)
class Tooth:
    """Flank with its fillet. Profile coordinate w: 0 to 1 along the fillet, then flank parameter in mm."""

    member: Member
    sign: float

    @cached_property
    def joint(self) -> float:
        """Return the flank parameter of the joint with the fillet."""
        tool = self.member.tool
        alpha, a, m = tool.normal_pressure_angle, tool.parabola, float(tool.normal_module)

        def apart(l: float) -> float:
            up = l * np.cos(alpha) + a * l * l * np.sin(alpha) + tool.dedendum * m
            return float(up - tool.tip_radius * m * (1.0 - np.sin(alpha - np.arctan(2.0 * a * l))))

        return float(brentq(apart, -1.5 * m, -0.3 * m, xtol=1e-15))

    def _section(self, w: FloatArray) -> tuple[FloatArray, ...]:
        """Return points of the tool's normal section and the angles of their normals."""
        tool = self.member.tool
        alpha, a, m = tool.normal_pressure_angle, tool.parabola, tool.normal_module

        def flank(l: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            x = l * np.cos(alpha) + a * l * l * np.sin(alpha)
            y = a * l * l * np.cos(alpha) - l * np.sin(alpha) + 0.25 * np.pi * m
            return x, y, alpha - np.arctan(2.0 * a * l)

        x, y, angle = flank(self.joint + np.maximum(w - 1.0, 0.0))
        x0, y0, angle0 = flank(np.asarray(self.joint))
        radius, turned = tool.tip_radius * m, 0.5 * np.pi + (angle0 - 0.5 * np.pi) * np.minimum(w, 1.0)
        x_round = x0 + radius * (np.sin(angle0) - np.sin(turned))
        y_round = y0 + radius * (np.cos(angle0) - np.cos(turned))
        low = w < 1.0
        return np.where(low, x_round, x), np.where(low, y_round, y), np.where(low, turned, angle)

    @cached_property
    def _placed(self) -> FloatArray:
        """Return the rotation of the tool by helix and cone angle."""
        beta, gamma = self.member.helix_angle, self.member.cone_angle
        turn = np.array([[1, 0, 0], [0, np.cos(beta), np.sin(beta)], [0, -np.sin(beta), np.cos(beta)]])
        tilt = np.array([[np.cos(gamma), 0, np.sin(gamma)], [0, 1, 0], [-np.sin(gamma), 0, np.cos(gamma)]])
        return np.asarray(tilt @ turn)

    def _in_plane(self, w: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return points of the tool in the planes z, and the slopes of their normals."""
        x, y, angle = self._section(w)
        turned, zero = self._placed, 0.0 * x
        point = np.tensordot(turned, np.stack((x, self.sign * y, zero)), 1)
        normal = np.tensordot(turned[:2], np.stack((np.sin(angle), self.sign * np.cos(angle), zero)), 1)
        along = (z - point[2]) / turned[2, 2]
        shift = self.member.profile_shift * self.member.tool.normal_module
        return point[0] + along * turned[0, 2] + shift, point[1] + along * turned[1, 2], normal[1] / normal[0]

    @property
    def _pitch_radius(self) -> FloatArray:
        return 0.5 * self.member.tool.normal_module * self.member.teeth / np.cos(self.member.helix_angle)

    def radius(self, w: FloatArray, z: FloatArray) -> FloatArray:
        """Return the distance from the axis in the planes z."""
        x, _, slope = self._in_plane(w, z)
        return np.hypot(self._pitch_radius + x, slope * x)

    def polar(self, w: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return radius and angle about the axis in the planes z (Eqs. 4-6)."""
        (x, y, slope), pitch_radius = self._in_plane(w, z), self._pitch_radius
        phi = (y - slope * x) / pitch_radius
        generated = phi + np.arctan2(slope * x, pitch_radius + x)
        return np.hypot(pitch_radius + x, slope * x), generated - self.sign * self._removed(w, z)

    def _removed(self, w: FloatArray, z: FloatArray) -> FloatArray:
        """Return the rotation by the modification: depth over base radius."""
        member = self.member
        given = member.modification_right if self.sign > 0.0 else member.modification_left
        if given is None:
            return 0.0 * (w + z)
        amounts = {name: 1e-3 * getattr(given, name) for name in AMOUNTS}
        tool, half, m = member.tool, 0.5 * float(member.face_width), float(member.tool.normal_module)
        alpha, beta, gamma = tool.normal_pressure_angle, member.helix_angle, member.cone_angle
        start, top = _ends(replace(self, member=member.modified(None)))
        l = self.joint + np.maximum(w - 1.0, 0.0)
        lam, zeta = 2.0 * (l - start) / (top - start) - 1.0, z / half

        def relief(name: str, beyond: FloatArray) -> FloatArray:
            """Return the depth of a relief whose edge is passed by `beyond` mm."""
            length = getattr(given, f"{name}_relief_length_mm")
            if length is None:
                return 0.0 * beyond
            share = np.maximum(1.0 + beyond / length, 0.0)
            return np.asarray(amounts[f"{name}_relief_um"] * share**2)

        removed = amounts["helix_slope_um"] * zeta / 2.0 + amounts["helix_crowning_um"] * zeta**2
        removed = removed + amounts["profile_slope_um"] * lam / 2.0 + amounts["profile_crowning_um"] * lam**2
        removed = removed + amounts["twist_um"] * lam * zeta / 4.0
        removed = removed + relief("tip", l - top) + relief("root", start - l)
        removed = removed + relief("heel", z - half) + relief("toe", -half - z)
        # Base radius: r_b cos(beta_b) = m N cos(alpha) / 2, with the axial part of the normal sin(beta_b).
        axial = -np.sin(alpha) * np.sin(gamma) - self.sign * np.cos(alpha) * np.sin(beta) * np.cos(gamma)
        base = 0.5 * m * member.teeth * np.cos(alpha) / np.sqrt(1.0 - axial**2)
        if given.deviations is None:
            return np.asarray(removed / base)
        flank = "right" if self.sign > 0.0 else "left"
        excess = 1e-3 * given.deviations.shape(flank)(l, z)[0]
        return np.asarray(removed / base - excess / (0.5 * m * member.teeth * np.cos(alpha)))

    def tip(self, z: FloatArray) -> FloatArray:
        """Return the radius of the tip cone."""
        tool, member = self.member.tool, self.member
        radius = 0.5 * tool.normal_module * member.teeth / np.cos(member.helix_angle)
        radius += (member.profile_shift + tool.addendum) * tool.normal_module
        return np.asarray(radius + z * np.tan(member.cone_angle))

    def profile(self, radius: FloatArray, z: FloatArray) -> FloatArray:
        """Return w at a radius; NaN without a point."""
        low = np.zeros_like(radius)
        high = np.full_like(radius, 1.0 + 2.4 * float(self.member.tool.normal_module))
        return roots_between(lambda w: self.radius(w, z) - radius, low, high, EPSILON * radius)


@cache
def _ends(plain: Tooth) -> tuple[float, float]:
    """Return the flank parameters at the start of the active flank and at the tip, both at mid-face."""
    tool, zero = plain.member.tool, np.zeros(1)
    alpha, m = tool.normal_pressure_angle, float(tool.normal_module)
    top = plain.joint + float(plain.profile(plain.tip(zero), zero)[0]) - 1.0
    # The height at which the round of a tool without parabola ends; the usual one is rounded to one addendum.
    depth = float(tool.dedendum - tool.tip_radius * (1.0 - np.sin(alpha)))
    depth = float(tool.addendum) if abs(depth - float(tool.addendum)) < 1e-4 else depth

    def above(l: float) -> float:
        return float(l * np.cos(alpha) + tool.parabola * l * l * np.sin(alpha) + depth * m)

    return float(brentq(above, -2.0 * m, -0.3 * m, xtol=1e-15)), top


def coordinate(tooth: Tooth, flank: str, s: FloatArray) -> FloatArray:
    """Return w of a profile coordinate of the package."""
    surface = surface_of(tooth.member, flank)
    below = (s - surface.bottom) / (surface.joint - surface.bottom)
    return np.where(s < surface.joint, below, 1.0 + s - surface.joint)


def clearance(
    design: Design, flank: str, w: FloatArray, z: FloatArray, rolls: tuple[float, float]
) -> FloatArray:
    """Return the rotation (rad) of the gear until it touches points (w, z) of the pinion, infinite without
    a point within its limits."""
    sign = 1.0 if flank == "right" else -1.0
    pinion, gear = (Tooth(member, sign) for member in design.members)
    errors, distance = design.errors, mounting_of(design).distance
    hand = np.sign(design.pinion.helix_angle + design.gear.helix_angle) or np.sign(design.pinion.helix_angle)
    angle = hand * (design.pair.shaft_angle + errors.shaft_angle)
    radius, theta = pinion.polar(w, z)
    theta = theta + rolls[0]
    place = (
        radius * np.cos(theta) - design.pair.offset - errors.offset,
        radius * np.sin(theta),
        z + distance[0] + errors.pinion_axial,
    )
    # The gear's axis (0, sin, cos), and k2 x (-x).
    x, y = -place[0], np.sin(angle) * place[2] - np.cos(angle) * place[1]
    z = np.sin(angle) * place[1] + np.cos(angle) * place[2] - distance[1] - errors.gear_axial
    reach = np.hypot(x, y)
    slack = max(1e-9, 2.5e-10 * float(gear.member.tool.normal_module))
    inside = (np.abs(z) <= 0.5 * gear.member.face_width + slack) & (reach <= gear.tip(z) + slack)
    gap = np.full(reach.shape, np.inf)
    met = gear.profile(reach[inside], z[inside])
    turn = np.arctan2(y, x)[inside] - gear.polar(met, z[inside])[1] - rolls[1]
    gap[inside] = sign * (np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi)
    return np.where(np.isnan(gap), np.inf, gap)


def deep_design() -> Design:
    """Return Table 1 with teeth so high that tips reach into fillets."""
    return closed(*(changed(member, addendum=1.2) for member in table1().members))


CASES = {
    "unmodified": table1(),
    "its toe": table1((0.0, 0.0), Errors(shaft_angle=radians(0.1))),
    "offset": table1((0.001, -0.001), Errors(0.3)),
    "nearer": table1((0.001, -0.001), Errors(-0.3, pinion_axial=1.0)),
    "concave": table1((0.0002, 0.0002)),
    "concave, turned": table1((0.0002, 0.0002), Errors(shaft_angle=radians(-0.1))),
    "convex": table1((-0.0005, -0.0005), Errors(gear_axial=-1.0)),
    "deep": deep_design(),
    **EDGES,
    **{f"tip on a fillet, {a}": table1(a, Errors(e)) for a, e in CLOSE.items()},
}


def assert_first(design: Design, flank: str, roll: FloatArray, rows: tuple[int, int, int]) -> float:
    """Check that the contact touches and that no point of the pinion touches earlier, on a grid with
    `rows` points along fillet, flank and face. Return the largest minimum clearance."""
    first = first_contact(design, flank, roll)
    assert (first.status == FirstStatus.SOLVED).all()
    pinion = Tooth(design.pinion, 1.0 if flank == "right" else -1.0)
    pitch = [2.0 * np.pi / float(member.teeth) for member in design.members]
    z = 0.5 * float(design.pinion.face_width) * np.linspace(-1.0, 1.0, rows[2])
    top = pinion.profile(pinion.tip(z), z)
    low, share = np.linspace(0.02, 0.999, rows[0])[:, None] + 0.0 * z, np.linspace(0.0, 1.0, rows[1])[:, None]
    w = np.concatenate((low, 1.0 + share * (top - 1.0)))
    least = []
    for k, at in enumerate(first.pair.tolist()):
        own = coordinate(pinion, flank, first.l1[k : k + 1])
        turned = [
            (float(roll[k]) + pair * pitch[0], float(first.gear_roll[k]) - pair * pitch[1])
            for pair in range(at - 1, at + 2)
        ]
        assert abs(float(clearance(design, flank, own, first.z1[k : k + 1], turned[1])[0])) < 1e-11
        least.append(min(clearance(design, flank, w, z + 0.0 * w, rolls).min() for rolls in turned))
    assert min(least) > -1e-12
    return float(max(least))


@pytest.mark.parametrize("name", CASES)
def test_first_contact_by_bisection(name: str, flank: str) -> None:
    design, rng = CASES[name], np.random.default_rng(len(name))
    roll = 2.0 * np.pi / float(design.pinion.teeth) * rng.uniform(0.0, 1.0, 2)
    assert assert_first(design, flank, pitch_point_roll(design, flank) + roll, (8, 30, 25)) < 3e-3


@pytest.mark.parametrize("case", HARD.values(), ids=HARD)
def test_contacts_between_coarse_scan_points(case: Named) -> None:
    assert_first(case.design, case.flank, np.array([case.roll]), (60, 80, 41))


def test_slight_overlap_is_not_certified() -> None:
    """Nearly unmodified flanks are not certified where the next pair is earlier by less than a micrometre."""
    design = table1((-1e-5, -1e-5))
    proof = path_certificate(path_of_contact(design, "left", 31))
    slight = (proof.separation < -OVERLAP_TOLERANCE_MODULES) & (proof.separation > -6e-4)
    assert slight.sum() > 10
    assert (proof.verdict[slight] == Verdict.NEXT_PAIR).all()


def test_last_entering_pair_is_reported(flank: str) -> None:
    """The pinion drives: the entering pair touches at the root of the pinion, the other one at its tip."""
    design, pitch = table1(), 2.0 * np.pi / 29.0
    path = path_of_contact(design, flank, 41)
    sign = 1.0 if flank == "right" else -1.0
    since = np.abs(path.pinion_roll - path.pinion_roll[0]) / pitch
    together = since > 1.05
    first = first_contact(design, flank, path.pinion_roll)
    assert together.sum() > 10
    assert (first.pair[together] == -sign).all()
    assert (first.l1[together] < path.l1[together] - 3.0).all()
    assert (first.pair[(since > 0.01) & (since < 0.95)] == 0).all()


def test_derivatives_of_approach_and_margins() -> None:
    """First and second derivatives of the clearance and of the margins equal central differences, on flank
    and fillet."""
    design = table1((0.001, -0.0005), Errors(0.2, radians(0.01), 0.3, -0.4))
    roll = np.full(1, float(pitch_point_roll(design, "right")))
    mesh, _ = engagement_of(design, "right", roll)
    place = np.array([[0.5, 3.0, -4.0, mesh.pinion.joint - 0.4], [2.0, -8.0, 10.0, -3.0]])
    task = mesh.task(np.zeros(4, dtype=int), np.zeros(4, dtype=int))
    here, step = local_at(task, *place), 1e-5
    for axis in (0, 1):
        shift = step * np.eye(2)[axis][:, None]
        above, below = local_at(task, *(place + shift)), local_at(task, *(place - shift))

        def rate(high: FloatArray, low: FloatArray) -> FloatArray:
            return (high - low) / (2.0 * step)

        known = np.isfinite(here.f)
        assert known.sum() >= 3
        assert np.abs(rate(above.f, below.f) - here.slope[axis])[known].max() < 1e-7
        assert np.abs(rate(above.slope, below.slope) - hessian(here.bend)[axis])[:, known].max() < 1e-7
        margin = rate(above.margin, below.margin) - here.rate[:, axis]
        assert np.abs(margin)[:, known].max() < 1e-7
        curve = rate(above.rate, below.rate) - hessian(here.curve)[:, axis]
        assert np.abs(curve)[..., known].max() < 1e-7
    assert len(here.margin) == len(Limit)


@pytest.mark.slow
def test_random_pairs_by_bisection() -> None:
    """Random usual pairs, on both members. Undercut members are tested in
    `test_first_contact_of_undercut_teeth`, since the teeth here are not cut at the intersection of
    flank and fillet."""
    designs, counts = random_designs("usual", 100, seed=2017), dict.fromkeys(FirstStatus, 0)
    for number in range(100):
        design: Design = cases_of(designs, number)
        flank, share = BOTH[number % 2], np.random.default_rng(number).uniform(-0.5, 0.5, 1)
        try:
            roll = pitch_point_roll(design, flank) + 2.0 * np.pi / float(design.pinion.teeth) * share
        except ValueError:  # the tool's rounds overlap: no fillet
            continue
        first = first_contact(design, flank, roll)
        counts[FirstStatus(int(first.status[0]))] += 1
        sound = all(surface_of(member, flank).crossing is None for member in design.members)
        if sound and first.status[0] == FirstStatus.SOLVED:
            assert_first(design, flank, roll, (8, 30, 25))
            met = angular_clearance(design, flank, 0, first.l1, first.z1, roll, first.gear_roll, first.pair)
            assert met.inside.all()
            assert abs(float(met.other_l[0] - first.l2[0])) < 1e-7
    print(counts)
    assert counts[FirstStatus.SOLVED] > 50
    assert counts[FirstStatus.NOT_CONVERGED] == counts[FirstStatus.NO_CONTACT] == 0
