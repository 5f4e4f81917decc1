"""Limit of the parabola coefficient, compared with the rack surface."""

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from beveloid_geom import Member, Tool
from beveloid_geom.design.limits import parabola_limit


@settings(deadline=None, max_examples=60)
@given(
    alpha=st.floats(8.0, 40.0),
    helix=st.floats(-60.0, 60.0),
    cone=st.floats(-8.0, 8.0),
    module=st.floats(0.1, 20.0),
)
def test_parabola_limit_against_the_rack_surface(
    alpha: float, helix: float, cone: float, module: float
) -> None:
    """The normals follow from numerical derivatives of Eqs. 2-4."""
    tool = Tool(module, radians(alpha))
    member = Member(tool, 20, radians(helix), radians(cone), 0.0, 10.0)
    limit = parabola_limit(member)
    beta, gamma = member.helix_angle, member.cone_angle
    tilt = np.array([[cos(gamma), 0, sin(gamma)], [0, 1, 0], [-sin(gamma), 0, cos(gamma)]])
    turn = np.array([[1, 0, 0], [0, cos(beta), sin(beta)], [0, -sin(beta), cos(beta)]])
    if limit <= 0.0:
        assert radians(alpha) <= np.arctan(abs(sin(beta) * np.tan(gamma))) + radians(1.0)
        return

    def angles_of(coefficient: float) -> tuple[float, float, float]:
        """Return the least radial component of the normal, and the least and largest local pressure
        angle, deg."""
        l = np.linspace(-4.0 * module, 4.0 * module, 80_001)
        x = l * cos(radians(alpha)) + coefficient * l**2 * sin(radians(alpha))
        y = coefficient * l**2 * cos(radians(alpha)) - l * sin(radians(alpha))
        dx, dy = np.gradient(x, l), np.gradient(y, l)
        middle = len(l) // 2
        low = middle - np.argmax(x[middle::-1] < -1.25 * module)
        high = middle + np.argmax(x[middle:] > 1.25 * module)
        active = slice(low + 1, high)
        local = np.arctan2(-dy[active], dx[active])
        radial = []
        for sigma in (1.0, -1.0):
            section = np.stack((np.sin(local), sigma * np.cos(local), np.zeros_like(local)))
            radial.append((tilt @ turn @ section)[0].min())
        return min(radial), np.degrees(local.min()), np.degrees(local.max())

    radial, lowest, highest = angles_of(limit)
    assert radial > 0.0
    margin = np.degrees(np.arctan(abs(sin(beta) * np.tan(gamma)))) + 1.0
    assert lowest == pytest.approx(margin, abs=0.02) or highest == pytest.approx(60.0, abs=0.02)
    assert lowest > margin - 0.02
    assert highest < 60.02
    assert angles_of(-limit)[1:] == pytest.approx((lowest, highest), abs=0.02)
