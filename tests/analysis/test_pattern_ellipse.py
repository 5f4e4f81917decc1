"""Ellipses of marked areas: closed forms, other grids, the mirror image."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import contact_pattern
from beveloid_geom.analysis.pattern_ellipse import MarkedEllipse, ellipse_of, marked_ellipse
from beveloid_geom.arrays import FloatArray
from beveloid_geom.operation.contact_pattern.pattern import MemberPattern
from tests.oracle.table1 import table1
from tests.symmetry import mirrored

SEPARATION = 0.00635


def in_axes_of(one: MarkedEllipse, z: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distances along the axes of an ellipse, divided by its semi-axes."""
    cos, sin = np.cos(one.angle), np.sin(one.angle)
    away = z - one.z, r - one.r
    return (cos * away[0] + sin * away[1]) / one.major, (cos * away[1] - sin * away[0]) / one.minor


def flat_pattern(one: MarkedEllipse, cells: tuple[int, int]) -> MemberPattern:
    """Return the pattern on a plane flank of 50 x 12 mm, on which the smallest separation is a paraboloid."""
    r, z = np.meshgrid(
        np.linspace(91.0, 103.0, cells[0] + 1), np.linspace(-25.0, 25.0, cells[1] + 1), indexing="ij"
    )
    x, y = in_axes_of(one, z, r)
    least = SEPARATION * (x * x + y * y)
    points = np.stack((0.6 * r, 0.8 * r, z), axis=-1)
    none = np.zeros(least.shape)
    return MemberPattern(
        none, z, points, least, none, least <= SEPARATION, none.astype(np.int8), 0.0, 0.0, 0.0, ()
    )


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.2, np.pi / 2])
@pytest.mark.parametrize(("cells", "off"), [((12, 50), 1.5e-2), ((60, 250), 7e-4)])
def test_a_marked_ellipse_is_reproduced(angle: float, cells: tuple[int, int], off: float) -> None:
    wanted = MarkedEllipse(1.3, 97.0, 5.5, 3.0, angle)
    found = marked_ellipse(flat_pattern(wanted, cells), SEPARATION)
    for name, size in (("z", 5.5), ("r", 3.0), ("major", 5.5), ("minor", 3.0), ("angle", 1.0)):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), abs=off * size), name


def test_a_rectangle() -> None:
    """The second moments are the squares of the sides divided by 12. They rotate with the rectangle."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-8.0, 8.0, 801), np.linspace(-2.0, 2.0, 801)))
    z, r = np.cos(0.3) * x - np.sin(0.3) * y + 5.0, np.sin(0.3) * x + np.cos(0.3) * y + 40.0
    found = ellipse_of(z, r, np.ones_like(z))
    wanted = (5.0, 40.0, 16.0 / np.sqrt(3.0), 4.0 / np.sqrt(3.0), 0.3)
    np.testing.assert_allclose(list(vars(found).values()), wanted, rtol=4e-3)


def test_patterns_without_axes() -> None:
    empty = marked_ellipse(flat_pattern(MarkedEllipse(90.0, 0.0, 1.0, 1.0, 0.0), (12, 50)), SEPARATION)
    assert np.isnan(list(vars(empty).values())).all()
    turn = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    circle = ellipse_of(np.cos(turn), np.sin(turn), np.ones(8))
    assert np.isnan(circle.angle)
    assert circle.major == pytest.approx(np.sqrt(2.0))


def test_ellipses_on_real_flanks(flank: str) -> None:
    """Ellipses agree with sums over the points of a grid that is four times finer, and the mirror image has
    the same ellipse."""
    design = table1((0.001, -0.001))
    coarse, fine = (contact_pattern(design, flank, resolution=size) for size in (0.4, 0.1))
    other = contact_pattern(mirrored(design), {"right": "left", "left": "right"}[flank], resolution=0.4)
    for side, dense, mirror in (
        (coarse.pinion, fine.pinion, other.pinion),
        (coarse.gear, fine.gear, other.gear),
    ):
        found, again = (marked_ellipse(one, SEPARATION) for one in (side, mirror))
        np.testing.assert_allclose(list(vars(again).values()), list(vars(found).values()), rtol=1e-6)
        r = np.hypot(dense.points[..., 0], dense.points[..., 1])
        height = np.gradient(r, axis=0)[dense.marked]
        plain = ellipse_of(dense.z[dense.marked], r[dense.marked], height)
        assert found.z == pytest.approx(plain.z, abs=0.1)
        assert found.r == pytest.approx(plain.r, abs=0.05)
        assert found.major == pytest.approx(plain.major, rel=0.01)
        assert found.minor == pytest.approx(plain.minor, rel=0.01)
        assert found.angle == pytest.approx(plain.angle, abs=0.01)
