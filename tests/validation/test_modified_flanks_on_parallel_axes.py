"""Modified flanks on parallel axes: points that move along the face, and lines of conjugate parabolas."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, tan

import numpy as np
import pytest

from beveloid_geom import (
    Errors,
    Pair,
    path_of_contact,
)
from beveloid_geom.contact.parallel.lines import contact_lines, touches_along_lines
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Status
from tests.stability.five_residuals import residuals
from tests.validation.test_parallel_axes import ANGLES, CONVEX, CYLINDRICAL, pair

MODIFIED = [name for name in ANGLES if name != "spur"]


@pytest.mark.parametrize("name", MODIFIED)
@pytest.mark.parametrize("parabola", [CONVEX, (-1e-3, 0.0), (0.0, -1e-3), (2e-3, -1e-3)])
def test_a_point_moves_along_the_face(name: str, parabola: tuple[float, float], flank: str) -> None:
    """l1 and l2 are constant with a1 l1 = a2 l2; five equations; overlap ratio of cylindrical gears."""
    design = pair(*ANGLES[name], parabola).with_errors(Errors(offset=0.02, gear_axial=0.4))
    path = path_of_contact(design, flank, 5)
    assert path.ends.status == Status.SOLVED
    assert not bool(touches_along_lines(design, flank))
    apart, turned = residuals(design, path, mounting_of(design).distance)
    assert apart.max() < 1e-11
    assert turned.max() < 1e-13
    assert np.ptp(path.l1) < 1e-14
    np.testing.assert_allclose(parabola[0] * path.l1, parabola[1] * path.l2, atol=1e-15)
    assert np.abs(path.transmission_error).max() < 1e-14
    if name in CYLINDRICAL:
        width = min(
            0.5 * float(m.face_width) + s * 0.4 for m, s in zip(design.members, (0.0, 1.0), strict=True)
        )
        width += min(
            0.5 * float(m.face_width) - s * 0.4 for m, s in zip(design.members, (0.0, 1.0), strict=True)
        )
        turn = width * abs(tan(float(design.pinion.helix_angle)))
        radius = 1.5 * 25 / cos(float(design.pinion.helix_angle))
        assert float(path.ends.contact_ratio) == pytest.approx(turn / radius * 25 / (2.0 * pi), abs=1e-12)


def test_conjugate_parabolas_touch_along_lines(flank: str) -> None:
    """a1 = -a2 on reference cylinders that touch: both racks are equal, and every l2 = -l1 is a contact."""
    design = pair(15.0, 3.0, (1e-3, -1e-3), shift=(0.1, -0.1))
    design = replace(design, pair=Pair(1.5 * 56 / cos(radians(15.0)), 0.0))
    path = path_of_contact(design, flank, 7)
    assert bool(touches_along_lines(design, flank))
    apart, turned = residuals(design, path, mounting_of(design).distance)
    assert (apart.max(), turned.max()) < (1e-11, 1e-13)
    np.testing.assert_allclose(path.l2, -path.l1, atol=1e-12)
    assert np.abs(path.transmission_error).max() < 1e-13
    elsewhere = path_of_contact(replace(design, pair=Pair(design.pair.offset + 0.1, 0.0)), flank)
    assert elsewhere.ends.status == Status.OFF_FLANK


def test_spur_teeth_with_parabolas(flank: str) -> None:
    """Lines along the axes, with the path of the transverse section by its five equations."""
    design = pair(0.0, 0.0, CONVEX)
    path = path_of_contact(design, flank, 11)
    apart, turned = residuals(design, path, mounting_of(design).distance)
    assert (apart.max(), turned.max()) < (1e-11, 1e-13)
    lines = contact_lines(path)
    np.testing.assert_allclose(lines.length, 28.0, atol=1e-9)
    assert float(lines.overlap_ratio) == 0.0
    assert float(lines.transverse_ratio) == pytest.approx(float(lines.total_ratio), abs=1e-12)
    assert np.abs(path.transmission_error).max() > 1e-6


@pytest.mark.parametrize("name", MODIFIED)
@pytest.mark.parametrize("parabola", [CONVEX, (-1e-3, 0.0)])
def test_the_limit_of_crossed_axes(name: str, parabola: tuple[float, float], flank: str) -> None:
    """Point contacts tend linearly to those of parallel axes, for both senses of the shaft angle, and
    satisfy the five equations."""
    design = pair(*ANGLES[name], parabola)
    limit = path_of_contact(design, flank, 3)
    rates = []
    for degrees in (1e-3, 1e-6, -1e-6, -1e-3):
        near = design.with_errors(Errors(shaft_angle=radians(degrees)))
        path = path_of_contact(near, flank, 3)
        assert path.ends.status == Status.SOLVED
        apart, turned = residuals(near, path, mounting_of(near).distance)
        assert (apart.max(), turned.max()) < (1e-10, 1e-12)
        rates.append((path.point - limit.point) / degrees)
    scale = np.abs(rates[1]).max()
    assert np.abs(rates[1]).max() > 1.0
    for k in (0, 2, 3):
        np.testing.assert_allclose(rates[k], rates[1], atol=0.02 * scale)
    nominal = path_of_contact(
        replace(design, pair=Pair(design.pair.offset, radians(1e-6), 0.0, 0.0)), flank, 3
    )
    np.testing.assert_allclose(nominal.point - limit.point, rates[1] * 1e-6, atol=1e-7)
