"""Limits of paths and of contact lines by undercut."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Member, Pair, Tool, contact_lines, path_of_contact
from beveloid_geom.gear.active_flank import active_start
from tests.stability.answers import closed, without_undercut
from tests.stability.five_residuals import batch_of_one


@pytest.mark.parametrize(("helix_deg", "cone_deg"), [(0.0, 0.0), (10.0, 0.0), (0.0, 3.0)])
def test_contact_lines_of_a_path_without_limits_by_undercut(
    helix_deg: float, cone_deg: float, flank: str
) -> None:
    """Undercut does not limit the lines of such a path either. They pass through its contacts, and on
    cylinders its contact ratio is the sum of both parts."""
    tool, helix, cone = Tool(2.0, radians(20.0)), radians(helix_deg), radians(cone_deg)
    pinion = Member(tool, 10, helix, cone, 0.0, 20.0)
    gear = Member(tool, 30, -helix, -cone, 0.0, 20.0)
    design = Design(pinion, gear, Pair(40.0 / cos(helix), 0.0))
    path = path_of_contact(design, flank, 9, undercut=False)
    assert path.contact_ratio > path_of_contact(design, flank, 9).contact_ratio + 0.1
    lines = contact_lines(path)
    assert (lines.length[1:-1] > 0.1).all()
    assert (lines.l1.min(axis=-1) <= path.l1 + 1e-9).all()
    assert (lines.l1.max(axis=-1) >= path.l1 - 1e-9).all()
    if cone == 0.0:
        parts = float(lines.transverse_ratio + lines.overlap_ratio)
        assert parts == pytest.approx(float(path.contact_ratio), abs=1e-9)
    with without_undercut():
        whole = contact_lines(path_of_contact(batch_of_one(design), flank, 9))
    np.testing.assert_allclose(whole.point[0], lines.point, atol=1e-9)
    few = path_of_contact(design, flank, l1=path.l1[2:7], undercut=False)
    np.testing.assert_allclose(contact_lines(few).length, lines.length[2:7], atol=1e-6)


def test_part_with_the_largest_range_of_roll_between_edges_of_undercut() -> None:
    """Undercut of both members removes the middle of this path. The part with the larger range of roll has
    the smaller range of l1, the parameter of its series."""
    tools = [Tool(2.0, radians(20.0), parabola=parabola) for parabola in (0.00072, 0.00382)]
    pinion = Member(tools[0], 9, radians(28.8146), radians(3.95216), -0.1656, 33.87967)
    gear = Member(tools[1], 15, radians(-21.12072), radians(-8.81663), -0.19173, 23.578)
    errors = Errors(offset=0.50554, shaft_angle=radians(0.09103))
    design = closed(pinion, gear).with_errors(errors)
    path = path_of_contact(design, "left", 3)
    whole = path_of_contact(design, "left", 20001, undercut=False)
    above = [
        l >= active_start(member, "left", z)
        for member, l, z in (
            (pinion, whole.l1, whole.pinion_z),
            (gear, whole.l2, whole.gear_z),
        )
    ]
    changes = np.flatnonzero(np.diff(np.logical_and(*above), prepend=False, append=False)).reshape(-1, 2)
    rolls, l1 = (np.abs(np.diff(values[changes - [0, 1]]))[:, 0] for values in (whole.pinion_roll, whole.l1))
    assert path.ends.pieces == len(changes) == 2
    assert rolls.argmax() != l1.argmax()
    assert path.contact_ratio == pytest.approx(9 * rolls.max() / (2.0 * np.pi), abs=2e-4)
