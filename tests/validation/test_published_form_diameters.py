"""Undercut and shortened tips against published numbers.

- STplus 11.1F, the cylindrical gear program of FVA (FZG, TU Munich): listings in a public student repository
  (tkuhn39/semesterthesis). Form diameters hold at the generating profile shift x_E, as listed.
- Brauer, Mech. Mach. Theory 37 (2002) 127-141: straight conical involute gears in closed form.
- ISO 21771: contact ratios of gears with different addenda, in closed form.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan, pi, radians, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Tool,
    contact_ratio,
    mounted_backlash,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.status import FirstStatus, Limit
from beveloid_geom.workshop.tooth_data import tooth_data
from tests.oracle.tooth import CutTooth
from tests.stability.answers import closed
from tests.stability.parallel_pairs import ratios_of_iso

ALPHA = radians(20.0)
STPLUS: dict[str, dict[str, Any]] = {
    "FZG type C": {
        "module": 4.5, "teeth": (16, 24), "face": 14.0, "offset": 91.5,
        "shift": (0.1818, 0.1714), "generating": (0.1559, 0.1454), "tip": (82.45, 118.35),
        "tool": (1.39, 0.25),
        "form": (67.685, 101.847), "active": (68.249, 104.001), "ratio": 1.436,
    },
    "12 teeth, undercut": {
        "module": 2.0, "teeth": (12, 40), "face": 20.0, "offset": 52.0,
        "shift": (0.0, 0.0), "generating": (-0.0446, -0.0584), "tip": (28.0, 83.166), "tool": (1.25, 0.25),
        "form": (22.651, 76.467), "active": (22.651, 77.533), "ratio": 1.226,
    },
    "17 teeth, shift -0.8": {
        "module": 4.0, "teeth": (17, 60), "face": 20.0, "offset": 153.183,
        "shift": (-0.8, 0.6), "generating": (-0.8292, 0.5605), "tip": (69.6, 246.892), "tool": (1.25, 0.25),
        "form": (64.467, 236.083), "active": (64.467, 237.009), "ratio": 0.807,
    },
}  # fmt: skip


def stplus(name: str, shift: str) -> Design:
    """Return the pair with the nominal profile shift ('shift') or with the generating profile shift
    ('generating')."""
    case = STPLUS[name]
    dedendum, rounded = case["tool"]
    tool = Tool(case["module"], ALPHA, dedendum=dedendum, tip_radius=rounded)
    members = [
        Member(tool, teeth, 0.0, 0.0, x, case["face"]).with_tip_diameter(tip)
        for teeth, x, tip in zip(case["teeth"], case[shift], case["tip"], strict=True)
    ]
    return Design(members[0], members[1], Pair(case["offset"], 0.0))


def swept(member: Member, z: float = 0.0) -> float:
    """Return the diameter at which round and flank of the tool cut equally deep, from the motion of the
    tool."""
    tooth, plane = CutTooth(member, 1.0), np.array([z])

    def polar(w: float) -> tuple[float, float]:
        radius, angle = tooth.polar(np.array([w]), plane)
        return float(radius[0]), float(angle[0])

    def apart(w: float) -> float:
        radius, angle = polar(w)
        return angle - polar(brentq(lambda on_round: polar(on_round)[0] - radius, 0.0, 1.0))[1]

    cusp = float(tooth.lowest(plane)[0])
    most = cusp + 0.98 * (cusp - 1.0)  # as high as the round's top, on the other branch
    return 2.0 * polar(brentq(apart, cusp, most, xtol=1e-14))[0]


def where_the_round_begins(member: Member) -> float:
    """Return the diameter of a sound spur flank that the end of the straight flank of the tool cuts (ISO
    21771)."""
    tool, radius = member.tool, 0.5 * member.tool.normal_module * member.teeth
    depth = tool.dedendum - tool.tip_radius * (1.0 - sin(ALPHA)) - member.profile_shift
    return float(
        2.0 * np.hypot(radius * np.cos(ALPHA), radius * sin(ALPHA) - depth * tool.normal_module / sin(ALPHA))
    )


@pytest.mark.parametrize("name", STPLUS)
def test_stplus(name: str, flank: str) -> None:
    """Form diameters, starts of active profiles and contact ratios agree with the listings of STplus. STplus
    searches for form diameters; they are within 7 um of the tool's motion (undercut pinions) and of a closed
    form (sound gears)."""
    case, design = STPLUS[name], stplus(name, "generating")
    exact = swept(design.pinion), where_the_round_begins(design.gear)
    for member, form, tip, by_hand in zip(design.members, case["form"], case["tip"], exact, strict=True):
        data = tooth_data(member)
        assert data.form_diameter == pytest.approx(by_hand, abs=1e-9)
        assert data.form_diameter == pytest.approx(form, abs=7e-3)
        assert data.tip_diameter == pytest.approx(tip, abs=1e-9)
    path = path_of_contact(design, flank, 2)
    assert 2.0 * path.pinion_r.min() == pytest.approx(case["active"][0], abs=2e-3)
    assert 2.0 * path.gear_r.min() == pytest.approx(case["active"][1], abs=1e-3)
    assert float(path.ends.contact_ratio) == pytest.approx(case["ratio"], abs=1.2e-3)


def test_fzg_c_in_operation() -> None:
    """The tips end the path above the undercut: every position is a first contact, and the ratio is that of
    the tip diameters (ISO 21771)."""
    design = replace(stplus("FZG type C", "shift"), pair=Pair(91.7, 0.0))
    ratio = ratios_of_iso(design)[0]
    assert ratio == pytest.approx(1.396954, abs=1e-6)
    assert float(contact_ratio(design)) == pytest.approx(ratio, abs=1e-9)
    assert float(operating_ratio(design)) == pytest.approx(ratio, abs=1e-9)
    assert path_certificate(path_of_contact(design, "right", 101)).holds
    play = mounted_backlash(design)
    assert play.status == FirstStatus.SOLVED
    assert float(play.normal) == pytest.approx(0.153591, abs=1e-6)


def test_undercut_ends_the_path_of_twelve_teeth() -> None:
    """The contact ratio is that of a path which undercut ends. Without undercut, the tip of the mate would
    reach below the base circle, and the ratio would be 1.405."""
    design = stplus("12 teeth, undercut", "generating")
    path = path_of_contact(design, "right", 41)
    assert path.ends.enter == Limit.PINION_ROOT
    form, base = 0.5 * swept(design.pinion), 12.0 * np.cos(ALPHA)
    tip = [sqrt(0.25 * d * d - (m * np.cos(ALPHA)) ** 2) for d, m in ((28.0, 12.0), (83.166, 40.0))]
    below = 52.0 * sin(ALPHA) - tip[1]
    assert below < sqrt(form * form - base * base)  # where the mate's tip would begin
    ratio = (tip[0] - sqrt(form * form - base * base)) / (2.0 * pi * np.cos(ALPHA))
    assert float(path.ends.contact_ratio) == pytest.approx(ratio, abs=1e-9)
    assert path_certificate(path).holds
    assert float(operating_ratio(design)) == pytest.approx(ratio, abs=1e-9)


def test_backlash_of_brauers_pair_over_an_axial_shift() -> None:
    """23/23 teeth, profile shift -0.3 at the toe and 1.0 at the heel, on parallel axes."""
    cone = atan(1.3 * 4.0 / 15.0)
    members = [Member(Tool(4.0, ALPHA), 23, 0.0, sense * cone, 0.35, 15.0) for sense in (1.0, -1.0)]
    design = closed(*members)
    assert float(design.pair.offset) == pytest.approx(94.531833, abs=1e-6)
    play = mounted_backlash(design.with_errors(Errors(pinion_axial=1.0)))
    assert float(play.normal) == pytest.approx(0.224053, abs=1e-6)


@pytest.mark.parametrize(("addenda", "ratio"), [((1.2, 0.8), 1.62106), ((0.8, 1.2), 1.65656)])
@pytest.mark.parametrize("by", ["tool", "blank"])
def test_the_flank_reaches_down_to_the_fillet_for_any_tip(
    addenda: tuple[float, float], ratio: float, by: str
) -> None:
    """30/45 teeth, module 3, tool dedendum 1.45: changed by the addendum of the tool and by the tip
    alteration."""
    members = []
    for teeth, shift, height in zip((30, 45), (0.2, 0.0), addenda, strict=True):
        tool = Tool(3.0, ALPHA, height if by == "tool" else 1.0, 1.45, 0.2)
        members.append(Member(tool, teeth, 0.0, 0.0, shift, 20.0, 0.0 if by == "tool" else height - 1.0))
    design = closed(*members)
    expected = ratios_of_iso(design)[0]
    assert expected == pytest.approx(ratio, abs=6e-6)
    assert float(contact_ratio(design)) == pytest.approx(expected, abs=1e-9)
    assert float(operating_ratio(design)) == pytest.approx(expected, abs=1e-9)
