"""Crossed helical gears, the limit of cone angle zero, in closed form.

Without cone angles the flanks are ordinary involute helicoids. The contact runs along a line perpendicular to
both tooth traces, and the tip circles limit the path of contact. Its length divided by the normal base pitch
is the contact ratio (Litvin and Fuentes, Gear Geometry and Applied Theory, chapter on crossed helical gears;
signs of DIN 868)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import acos, asin, atan, cos, degrees, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Tool,
    mounted_backlash,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.operation.backlash_by_tangency import tangent_backlash
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import closed_layout, layout_deviation
from beveloid_geom.status import Limit

MODULE, ALPHA = 6.0, radians(20.0)


def closed_form(teeth: tuple[int, int], helix: tuple[float, float]) -> tuple[float, float]:
    """Return offset and contact ratio of two cylindrical gears without profile shift at their reference
    pitch point."""
    pair = Shifted(MODULE, ALPHA, teeth, helix, (0.0, 0.0))
    return pair.layout(ALPHA)[0], pair.contact_ratio(ALPHA)


def test_table_1_without_cones_has_the_contact_ratio_1_7279() -> None:
    assert closed_form((29, 45), (radians(25.0), radians(-10.57)))[1] == pytest.approx(1.7279, abs=5e-5)


@dataclass(frozen=True)
class Shifted:
    """Crossed helical gears with profile shift, at a working normal pressure angle; mm and rad."""

    module: float
    alpha: float
    teeth: tuple[int, int]
    helix: tuple[float, float]
    shift: tuple[float, float]

    def design(self, offset: float, shaft_angle: float) -> Design:
        tool = Tool(self.module, self.alpha)
        members = zip(self.teeth, self.helix, self.shift, strict=True)
        pinion, gear = (Member(tool, n, beta, 0.0, x, 400.0) for n, beta, x in members)
        return Design(pinion, gear, Pair(offset, shaft_angle, 0.0, 0.0))

    def working(self, aw: float) -> list[tuple[float, float, float]]:
        """Helix angle, radius and transverse pressure angle of both working pitch cylinders."""
        found = []
        for n, beta in zip(self.teeth, self.helix, strict=True):
            beta_w = asin(sin(beta) * cos(self.alpha) / cos(aw))
            base = self.module * n / (2 * cos(beta)) * cos(atan(tan(self.alpha) / cos(beta)))
            transverse = atan(tan(aw) / cos(beta_w))
            found.append((beta_w, base / cos(transverse), transverse))
        return found

    def backlash(self, aw: float) -> float:
        total = -2 * tan(self.alpha) * sum(self.shift)
        for n, beta, (_, _, transverse) in zip(self.teeth, self.helix, self.working(aw), strict=True):
            total += n * (involute(transverse) - involute(atan(tan(self.alpha) / cos(beta))))
        return total * self.module * cos(self.alpha)

    def without_backlash(self) -> float:
        steepest = cos(self.alpha) * max(abs(sin(beta)) for beta in self.helix)  # there b_w is 90 deg
        return float(brentq(self.backlash, 0.02, acos(steepest) - 1e-9, xtol=1e-15))

    def layout(self, aw: float) -> tuple[float, float]:
        """Offset and signed shaft angle."""
        (beta_1, r_1, _), (beta_2, r_2, _) = self.working(aw)
        return r_1 + r_2, beta_1 + beta_2

    def contact_ratio(self, aw: float) -> float:
        length = 0.0
        for n, beta, x, (_, r, transverse) in zip(
            self.teeth, self.helix, self.shift, self.working(aw), strict=True
        ):
            tip = self.module * (n / (2 * cos(beta)) + 1.0 + x)
            reach = sqrt(tip**2 - (r * cos(transverse)) ** 2) - r * sin(transverse)
            length += reach / cos(asin(sin(beta) * cos(self.alpha)))
        return length / (pi * self.module * cos(self.alpha))


def involute(angle: float) -> float:
    return tan(angle) - angle


def drawn_pair(seed: int) -> Shifted:
    """Return crossed helical gears of either hand without undercut, with axes at 5 deg or more."""
    random = np.random.default_rng(seed)
    while True:
        helix = np.radians(random.uniform(-50.0, 50.0, 2))
        if abs(helix.sum()) > 0.1:
            break
    module, alpha = random.uniform(0.5, 8.0), radians(random.uniform(17.0, 25.0))
    teeth, shift = random.integers(24, 80, 2), random.uniform(-0.15, 0.5, 2)
    return Shifted(module, alpha, (int(teeth[0]), int(teeth[1])), (*helix.tolist(),), (*shift.tolist(),))


@pytest.mark.parametrize("seed", range(12))
def test_layout_without_backlash(seed: int) -> None:
    """The layout follows from the gears, and there is no backlash in this layout."""
    pair = drawn_pair(seed)
    aw = pair.without_backlash()
    offset, shaft_angle = pair.layout(aw)
    design = pair.design(offset, abs(shaft_angle))
    found = zero_backlash_layout(design)
    assert float(found.pressure_angle) == pytest.approx(aw, abs=1e-12)
    assert float(found.offset) == pytest.approx(offset, rel=1e-12)
    assert float(found.shaft_angle) == pytest.approx(abs(shaft_angle), abs=1e-12)
    working = pair.working(aw)
    np.testing.assert_allclose(found.helix_angle, [row[0] for row in working], atol=1e-12)
    np.testing.assert_allclose(found.working_radius, [row[1] for row in working], rtol=1e-12)
    mounting = mounting_of(design)
    assert abs(mounting.gap) < 1e-9 * offset
    assert abs(mounting.normal_backlash) < 1e-11 * offset
    np.testing.assert_allclose(mounting.working_radius, found.working_radius, rtol=1e-9)
    closing = layout_deviation(design)
    assert abs(closing.offset_difference) < 1e-9 * offset
    assert abs(closing.shaft_angle_difference) < 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_backlash_of_wider_layouts(seed: int) -> None:
    pair = drawn_pair(seed)
    aw = pair.without_backlash() + radians(0.4)
    offset, shaft_angle = pair.layout(aw)
    design = pair.design(offset, abs(shaft_angle))
    backlash = pair.backlash(aw)
    assert backlash > 0.0
    assert float(closed_layout(design, np.asarray(aw)).normal_backlash) == pytest.approx(backlash, rel=1e-10)
    assert float(mounting_of(design).normal_backlash) == pytest.approx(backlash, rel=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_path_and_contact_ratio_with_profile_shift(seed: int, flank: str) -> None:
    """The path is a straight line through the pitch point along n = sin(a_w) N +- cos(a_w) b, with N along
    the common perpendicular and b perpendicular to the tooth trace; both tips limit it."""
    pair = drawn_pair(seed)
    aw = pair.without_backlash()
    offset, shaft_angle = pair.layout(aw)
    path = path_of_contact(pair.design(offset, abs(shaft_angle)), flank, points=9)
    (helix, radius, _), _ = pair.working(aw)
    side = {"right": 1.0, "left": -1.0}[flank] * cos(aw)
    normal = np.array([sin(aw), side * cos(helix), -side * sin(helix)])
    np.testing.assert_allclose(path.normal, np.tile(normal, (9, 1)), atol=1e-11)
    off = np.cross(path.point - np.array([radius, 0.0, 0.0]), normal)
    assert np.abs(off).max() < 1e-9 * offset
    assert {path.ends.enter, path.ends.leave} == {Limit.GEAR_TIP, Limit.PINION_TIP}
    assert float(path.ends.contact_ratio) == pytest.approx(pair.contact_ratio(aw), rel=1e-10)


def test_the_exact_layout_of_khk_screw_gears() -> None:
    """The handbook's own formulas, which replace each gear by a spur gear of N / cos^3(b) teeth, print
    67.19253 mm, 22.93379 and 51.10248 deg (KHK, Gear Technical Reference, screw gears)."""
    pair = Shifted(3.0, ALPHA, (15, 24), (radians(20.0), radians(30.0)), (0.4, 0.2))
    layout = zero_backlash_layout(pair.design(67.0, 0.9))
    exact = float(layout.offset), degrees(layout.pressure_angle), degrees(layout.shaft_angle)
    assert exact == pytest.approx((67.19306, 22.91258, 51.09151), abs=5.1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_backlash_under_an_offset_error(seed: int) -> None:
    """Under an offset error that leads to another layout in closed form, the backlash is that of the closed
    form."""
    pair = drawn_pair(seed)
    aw = pair.without_backlash()
    for turn in (0.3, -0.02):
        offset, shaft_angle = pair.layout(aw + radians(turn))
        rough = pair.design(offset - 0.05 * pair.module, abs(shaft_angle))
        pinion, gear = (
            replace(member, tool=replace(member.tool, tip_radius=0.2)) for member in rough.members
        )
        design = Design(pinion, gear, rough.pair, Errors(offset=0.05 * pair.module))
        wanted = pair.backlash(aw + radians(turn))
        found = mounted_backlash(design)
        assert float(tangent_backlash(design).normal) == pytest.approx(wanted, abs=1e-9 * offset)
        assert float(found.normal) == pytest.approx(wanted, abs=1e-9 * offset)
        assert bool(found.jammed) is (wanted < 0.0)
