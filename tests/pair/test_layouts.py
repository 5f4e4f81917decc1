"""Ordinary and less ordinary layouts: cylindrical members, steep cones, both hands, 90 degrees.

Each pair is laid out without backlash in closed form, which knows nothing of the contact solve;
both flanks must then touch at the pitch point, near mid-face, and satisfy the five equations.
The wrong sign of n_x would put the contact hundreds of mm away.
"""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Member, Tool, path_of_contact
from beveloid_geom.pair.mounting import mounting_of
from tests.contact.test_path import five_equation_residual
from tests.stability.answers import closed
from tests.symmetry import exchanged, mirrored

# teeth, helix and cone angle in deg of pinion and gear
LAYOUTS = {
    "table 1": ((29, 25.0, 3.0), (45, -10.57, 0.8)),
    "cylindrical pinion": ((29, 25.0, 0.0), (45, -10.57, 1.5)),
    "cylindrical gear": ((29, 25.0, 3.0), (45, -10.57, 0.0)),
    "both cylindrical": ((29, 25.0, 0.0), (45, -10.57, 0.0)),
    "steep": ((29, 25.0, 6.0), (45, -10.57, 4.0)),
    "steeper": ((31, 20.0, 9.0), (40, -5.0, 8.0)),
    "same hand": ((25, 15.0, 2.0), (34, 12.0, 1.0)),
    "same hand, steep": ((25, 15.0, 7.0), (34, 12.0, 6.0)),
    "same hand, 90 deg": ((19, 45.0, 1.0), (19, 44.0, 1.0)),
    "straight gear": ((29, 20.0, 3.0), (45, 0.0, 3.0)),
}


def laid_out(name: str) -> Design:
    tool = Tool(6.0, radians(20.0))
    pinion, gear = (
        Member(tool, teeth, radians(helix), radians(cone), shift, 40.0)
        for (teeth, helix, cone), shift in zip(LAYOUTS[name], (0.2, 0.1), strict=True)
    )
    return closed(pinion, gear)


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.0005, -0.0005)])
@pytest.mark.parametrize("name", LAYOUTS)
def test_contact_is_near_the_pitch_point(name: str, parabola: tuple[float, float], flank: str) -> None:
    design = laid_out(name).with_parabola(*parabola)
    for variant, side in (
        (design, flank),
        (exchanged(design), flank),
        (mirrored(design), {"right": "left", "left": "right"}[flank]),
    ):
        path = path_of_contact(variant, side, 21)
        assert path.l1.size == 21
        assert five_equation_residual(variant, path) < 1e-9
        reach = np.linalg.norm(path.point - mounting_of(variant).pitch_point, axis=-1)
        assert reach.min() < 2.0
        assert 0.9 < path.ends.contact_ratio < 2.5
        assert np.ptp(path.transmission_error) < (1e-12 if parabola[0] == 0.0 else 1e-3)


def test_the_negative_branch_is_met() -> None:
    """The steep layouts are here because one of their flanks has n_x < 0."""
    assert any(mounting_of(laid_out(name)).branch.min() < 0.0 for name in LAYOUTS)
