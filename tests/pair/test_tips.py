"""Depth of flanks below the tips: against closed forms, ends of paths and the search for interference."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Member, Pair, Tool, path_certificate, path_of_contact
from beveloid_geom.arrays import FLANKS, FloatArray
from beveloid_geom.gear.flank import base_cylinder, flank_point
from beveloid_geom.gear.flank_limits import root_parameter, tip_radius
from beveloid_geom.pair.frames import Layout, layout_at
from beveloid_geom.pair.generator_angle import closed_normal
from beveloid_geom.pair.tips import TIP_EDGE_POSITIONS, depth_below_tips
from beveloid_geom.pair.zero_backlash import ZeroBacklashLayout, closed_layout
from beveloid_geom.proposal.candidates import candidates_of, within
from beveloid_geom.proposal.closure_equations import pair_at
from beveloid_geom.proposal.merit import design_of
from beveloid_geom.proposal.request import Request
from beveloid_geom.status import Limit, Verdict
from tests.proposal.requests import random_requests
from tests.proposal.test_closure_equations import REQUESTS


def depth_in_pairs(
    request: Request, values: FloatArray, flank: str, places: FloatArray = TIP_EDGE_POSITIONS
) -> FloatArray:
    """Return the depth (2, n) of the flanks of pinion and gear below the tips, in pairs (7, n)."""
    design, closed = pair_at(request.members, values)
    normal_x = closed_normal(closed, flank, design.sense)[0]
    return depth_below_tips(design, axes_of(design, closed), closed.mounting, flank, normal_x, places)


def axes_of(design: Design, closed: ZeroBacklashLayout) -> Layout:
    """Return the layouts of pairs without backlash."""
    return layout_at(closed.offset, design.sense * closed.shaft_angle, design.sense)


def root_radius_at(member: Member, flank: str, z: float) -> float:
    """Return the radius at which the active flank starts in a plane, mm."""
    root = root_parameter(member, "right")
    return float(np.hypot(*flank_point(member, flank, root, z=z)[:2]))


@pytest.mark.parametrize("helix_deg", [0.0, 17.0])
def test_start_of_active_profile_of_cylindrical_gears(helix_deg: float, flank: str) -> None:
    """r_SAP^2 = r_b1^2 + (a sin(a_wt) - sqrt(r_a2^2 - r_b2^2))^2, and the same for the gear."""
    tool = Tool(3.0, radians(20.0))
    members = [
        Member(tool, teeth, hand * radians(helix_deg), 0.0, shift, 30.0)
        for teeth, hand, shift in ((23, 1.0, 0.3), (40, -1.0, 0.1))
    ]
    design = Design(members[0], members[1], Pair(1.0, 0.0))
    angle = np.array([radians(22.0)])
    closed = closed_layout(design, angle)
    normal_x = closed_normal(closed, flank, np.ones(1))[0]
    left = depth_below_tips(design, axes_of(design, closed), closed.mounting, flank, normal_x)
    base = [float(base_cylinder(member, flank).radius) for member in members]
    tip = [float(tip_radius(member, 0.0)) for member in members]
    offset = float(closed.offset[0])
    along = np.sqrt(offset**2 - sum(base) ** 2)
    for j in (0, 1):
        start = np.hypot(base[j], along - np.sqrt(tip[1 - j] ** 2 - base[1 - j] ** 2))
        assert left[j, 0] == pytest.approx(start - root_radius_at(members[j], flank, 0.0), abs=1e-11)


@pytest.mark.parametrize("name", REQUESTS)
def test_depth_at_the_end_of_a_path_limited_by_a_tip(name: str) -> None:
    """Where a tip ends a path, the depth below the tip equals the height of the end of the path above the
    start of the active flank."""
    request, checked = REQUESTS[name], 0
    pairs = candidates_of(request)
    values = pairs[:, within(request, pairs)][:, :4]
    for k in range(values.shape[1]):
        design = design_of(request, values[:, k])
        width = min(float(member.face_width) for member in design.members)
        for flank in FLANKS:
            path = path_of_contact(design, flank, 2)
            for end in range(path.l1.size):
                for j, limit in ((0, Limit.GEAR_TIP), (1, Limit.PINION_TIP)):
                    if path.ends.limit[end] != limit:
                        continue
                    z, radius = (path.pinion_z, path.gear_z), (path.pinion_r, path.gear_r)
                    place = np.array([z[1 - j][end] / width])
                    left = depth_in_pairs(request, values[:, k : k + 1], flank, place)[j, 0]
                    start = root_radius_at(design.members[j], flank, float(z[j][end]))
                    assert left == pytest.approx(radius[j][end] - start, abs=1e-8)
                    checked += 1
    assert checked > 3


@pytest.mark.parametrize("number", [17, 44, 71, 86])
def test_overlapping_tips_reach_deeper_than_the_flank(number: int) -> None:
    """If a pair interferes or has edge contact, its tips reach below the active flank of the mate. Some pairs
    of these requests do."""
    request = list(random_requests(number + 1, seed=1))[number]
    pairs = candidates_of(request)
    values = pairs[:, within(request, pairs)]
    left = np.stack([depth_in_pairs(request, values, flank).min(axis=0) for flank in FLANKS])
    module = request.module
    near = np.argsort(np.abs(left.min(axis=0) + 0.04 * module))[:12]
    cuts = 0
    for k in near:
        design = design_of(request, values[:, k])
        for flank, own in zip(FLANKS, left[:, k], strict=True):
            verdict = path_certificate(path_of_contact(design, flank, 15)).verdict
            if np.isin(verdict, (Verdict.INTERFERENCE, Verdict.EDGE_CONTACT)).any():
                cuts += 1
                assert own < 0.0
    assert cuts
