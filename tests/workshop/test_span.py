"""Spans over teeth: two parallel planes in contact with the flanks, and members without a span."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians

import numpy as np
import pytest
from scipy.optimize import root

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.status import SpanStatus
from beveloid_geom.workshop.span import span_measurement
from tests.members import MEMBERS

ALPHA = radians(20.0)
GEARS = [
    (24, 0.0, 0.0),
    (17, 0.0, 0.35),
    (31, 28.0, -0.1),
    (40, -12.0, 0.3),
    (60, 30.0, 0.0),
    (12, 20.0, 0.5),
]


def made(teeth: int, helix_deg: float, shift: float, width: float = 120.0) -> Member:
    return Member(Tool(4.0, ALPHA), teeth, radians(helix_deg), 0.0, shift, width)


@pytest.mark.parametrize(("teeth", "helix_deg", "shift"), GEARS)
@pytest.mark.parametrize("place", [-1.0, 0.5])
def test_distance_of_parallel_planes_on_both_flanks(
    teeth: int, helix_deg: float, shift: float, place: float
) -> None:
    """Search the plane on a left flank that is parallel to the plane on the right flank at l = `place`."""
    member = made(teeth, helix_deg, shift)
    found = span_measurement(member)
    right = flank_patch(member, "right", place, z=1.0)
    turn = 2.0 * pi / teeth * (1 - found.teeth)  # the left flank of the last tooth of the span
    cosine, sine = np.cos(turn), np.sin(turn)
    turned = np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))

    def left(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        patch = flank_patch(member, "left", at[0], z=at[1])
        return turned @ patch.point, turned @ patch.normal

    def missing(at: FloatArray) -> FloatArray:
        """Return the components in which the second contact deviates from the common normal of the first
        one."""
        point, normal = left(at)
        return np.cross(point - right.point, right.normal)[:2] + (normal + right.normal)[:2]

    start = np.array((-place, 1.0 + float(found.dimension[0]) * right.normal[2]))
    at = root(missing, start, tol=1e-13).x
    point, normal = left(at)
    assert normal == pytest.approx(-right.normal, abs=1e-7)
    assert abs((point - right.point) @ right.normal) == pytest.approx(float(found.dimension[0]), abs=1e-7)


def test_allowances_of_the_thickness() -> None:
    found = span_measurement(made(31, 28.0, 0.1), 4, (0.0, -0.05, -0.1))
    assert np.diff(found.dimension) == pytest.approx(-0.05 * cos(ALPHA), abs=1e-12)


@pytest.mark.parametrize(
    ("member", "teeth", "status"),
    [
        (MEMBERS["pinion"], None, SpanStatus.CONE),
        (replace(made(24, 0.0, 0.0), tool=Tool(4.0, ALPHA, parabola=1e-3)), None, SpanStatus.PARABOLA),
        (made(24, 0.0, 0.0), 6, SpanStatus.OFF_FLANK),
        (made(24, 0.0, 0.0), 1, SpanStatus.OFF_FLANK),
        (made(40, 30.0, 0.0, 20.0), None, SpanStatus.FACE_TOO_NARROW),
    ],
)
def test_members_without_a_span_have_a_status(member: Member, teeth: int | None, status: SpanStatus) -> None:
    found = span_measurement(member, teeth)
    assert found.status.tolist() == [status]
    assert np.isnan(found.dimension).all()
