"""Crossed helical gears, the limit of cone angle zero, in closed form.

Without cone angles the flanks are ordinary involute helicoids. The contact runs along a line
square to both tooth traces, and the tip circles cut from it the path of contact; its length over
the normal base pitch is the contact ratio (Litvin and Fuentes, Gear Geometry and Applied
Theory, chapter on crossed helical gears; DIN 868 sense of signs).
"""

from __future__ import annotations

from math import acos, asin, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

from beveloid_geom.inputs import Design, Errors, Member, Pair, Tool
from beveloid_geom.mounting import mounting_of
from beveloid_geom.path import contact_ratio, path_of_contact

MODULE, ALPHA = 6.0, radians(20.0)


def member(teeth: int, helix: float, shift: float = 0.0) -> Member:
    return Member(Tool(MODULE, ALPHA), teeth, helix, 0.0, shift, 400.0)


def closed_form(teeth: tuple[int, int], helix: tuple[float, float]) -> tuple[float, float]:
    """Offset and contact ratio of two cylindrical gears without shift at their reference pitch
    point: reach = (sqrt(r_a^2 - r_b^2) - r sin(alpha_t)) / cos(beta_b) on each side."""
    length = 0.0
    for n, beta in zip(teeth, helix, strict=True):
        r = MODULE * n / (2 * cos(beta))
        alpha_t = np.arctan(tan(ALPHA) / cos(beta))
        base = r * cos(alpha_t)
        base_helix = asin(sin(beta) * cos(ALPHA))
        length += (sqrt((r + MODULE) ** 2 - base**2) - r * sin(alpha_t)) / cos(base_helix)
    offset = sum(MODULE * n / (2 * cos(beta)) for n, beta in zip(teeth, helix, strict=True))
    return offset, length / (pi * MODULE * cos(ALPHA))


@pytest.mark.parametrize("flank", ["right", "left"])
@pytest.mark.parametrize(
    ("teeth", "helix_deg"),
    [
        ((29, 45), (25.0, -10.57)),
        ((15, 24), (20.0, 30.0)),
        ((20, 20), (45.0, 45.0)),
        ((40, 23), (-30.0, 12.0)),
    ],
)
def test_contact_ratio(teeth: tuple[int, int], helix_deg: tuple[float, float], flank: str) -> None:
    helix = (radians(helix_deg[0]), radians(helix_deg[1]))
    offset, ratio = closed_form(teeth, helix)
    pair = Pair(offset, abs(sum(helix)), 0.0, 0.0)
    design = Design(member(teeth[0], helix[0]), member(teeth[1], helix[1]), pair)
    assert contact_ratio(design, flank) == pytest.approx(ratio, rel=1e-12)
    mounting = mounting_of(design)
    assert abs(mounting.gap) < 1e-9
    assert mounting.normal_backlash == pytest.approx(0.0, abs=1e-9)
    assert mounting.distance == pytest.approx([0.0, 0.0], abs=1e-9)


def test_table_1_without_cones_has_the_contact_ratio_1_7279() -> None:
    assert closed_form((29, 45), (radians(25.0), radians(-10.57)))[1] == pytest.approx(1.7279, abs=5e-5)


def test_khk_screw_gears_with_profile_shift() -> None:
    """Handbook case (KHK): m_n 3, z 15/24, helix 20/30 deg, x 0.4/0.2. Without backlash the
    centre distance is 67.19306 mm, the working normal pressure angle 22.91258 deg and the
    shaft angle 51.09151 deg; the handbook's own approximate formulas give 67.19253, 22.93379
    and 51.10248."""
    tool = Tool(3.0, ALPHA)
    pinion, gear = (
        Member(tool, n, radians(beta), 0.0, x, 60.0) for n, beta, x in ((15, 20.0, 0.4), (24, 30.0, 0.2))
    )
    design = Design(pinion, gear, Pair(67.19306, radians(51.09151), 0.0, 0.0))
    mounting = mounting_of(design)
    assert mounting.normal_backlash == pytest.approx(0.0, abs=2e-5)
    assert abs(mounting.gap) < 1e-3
    normals = [path_of_contact(design, flank, 2).normal[0] for flank in ("right", "left")]
    between = acos(float(-normals[0] @ normals[1]))
    assert np.degrees(between) / 2 == pytest.approx(22.91258, abs=1e-4)


def test_axial_errors_do_not_move_the_path_of_cylindrical_gears_in_space() -> None:
    helix = (radians(25.0), radians(-10.57))
    offset, _ = closed_form((29, 45), helix)
    pinion, gear = member(29, helix[0]), member(45, helix[1])
    pair = Pair(offset, abs(sum(helix)), 0.0, 0.0)
    plain = path_of_contact(Design(pinion, gear, pair), points=5)
    moved = path_of_contact(Design(pinion, gear, pair, Errors(pinion_axial=3.0, gear_axial=-2.0)), points=5)
    np.testing.assert_allclose(moved.point, plain.point, atol=1e-10)
    np.testing.assert_allclose(moved.pinion_z, plain.pinion_z - 3.0, atol=1e-10)
