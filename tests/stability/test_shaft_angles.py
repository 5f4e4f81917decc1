"""Shaft angles: down to the fold at which the common normal vanishes and beyond, to 0, and of the
other sign; equal and opposite hands."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import cos, degrees, radians, sin

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Pair,
    Status,
    contact_ratio,
    path_of_contact,
    zero_backlash_layout,
)
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.gear.rack import rack_of
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import closing_offset, layout_deviation
from tests.oracle.sixty_digits import exact_at
from tests.oracle.table1 import table1
from tests.symmetry import exchanged, mirrored

from .answers import (
    FLANKS,
    assert_no_path,
    at_shaft_angle,
    changed,
    check,
    closed,
    held,
    solved_path,
)

PINION, GEAR = table1().members
PLAIN = changed(PINION, cone_angle=0.0), changed(GEAR, cone_angle=0.0)
ABOVE = [0.1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13]
"""deg"""


def fold() -> float:
    """Return the shaft angle (deg) below which the right flanks of Table 1 have no common normal: at this
    angle the normal lies in the plane of both axes, and its angles to the axes add up."""
    v1, v2 = (float(rack_of(member, "right").normal[2]) for member in (PINION, GEAR))
    return degrees(np.arccos(v1) - np.arccos(-v2))


def folding(above: float) -> Design:
    """Return Table 1 at a shaft angle that is `above` (deg) the fold, at the offset without a gap of the
    lines of action."""
    design = at_shaft_angle(table1(), fold() + above)
    return held(replace(design, pair=replace(design.pair, offset=closing_offset(design))))


def test_paths_down_to_the_fold() -> None:
    """If the lines of action meet, paths remain on the flanks. n_x decreases to 1e-7 and below."""
    ratios = []
    for above in ABOVE:
        path = solved_path(folding(above))
        assert np.abs(path.normal[:, 0]).max() < 0.4 * np.sqrt(above)
        ratios.append(float(path.ends.contact_ratio))
    assert np.diff(ratios).max() < 0.0
    assert abs(ratios[-1] - ratios[-3]) < 1e-3


@pytest.mark.parametrize("above", [1e-2, 1e-6])
def test_sixty_digits_agree_near_the_fold(above: float) -> None:
    """The error of the point is rounding divided by n_x^2, that of n_x rounding divided by n_x."""
    ours = path_of_contact(folding(above), points=3)
    true = exact_at(ours, 1, "l1")
    normal_x = abs(float(ours.normal[1, 0]))
    apart = max(abs(float(a) - b) for a, b in zip(true.point, ours.point[1], strict=True))
    assert apart < 1e-12 / normal_x**2
    assert abs(float(true.normal[0]) - ours.normal[1, 0]) < 1e-15 / normal_x


@pytest.mark.parametrize("below", [1e-12, 1e-9, 1e-3, 1.0, 10.0])
def test_beyond_the_fold_the_right_flank_has_a_status(below: float) -> None:
    """Below the smallest shaft angle, the right flanks have a status: with computed mounting distances and
    with those of Table 1. The left flanks remain in contact."""
    for design, status in ((table1(), Status.UNDEFINED), (held(table1()), Status.NO_COMMON_NORMAL)):
        past = at_shaft_angle(design, fold() - below)
        assert_no_path(past, "right", status)
        assert np.isnan(path_of_contact(past, l1=[0.0]).point).all()
    if below < 0.1:
        at = at_shaft_angle(held(table1()), fold())
        left, before = (solved_path(design, "left") for design in (past, at))
        assert abs(left.ends.contact_ratio - before.ends.contact_ratio) < 0.2 * below + 1e-12
    reason = f"the flanks have no common normal at a shaft angle of {fold() - below:.6g} deg"
    assert reason in layout_deviation(at_shaft_angle(table1(), fold() - below)).reasons[0]


def test_shaft_angle_errors_on_both_sides_of_the_fold_are_distinguished() -> None:
    over = np.array([0.16, 1e-3, 1e-9, -1e-9, -1e-3, -1.0])
    design = table1(errors=Errors(shaft_angle=np.radians(fold() + over - 15.0)))
    path = path_of_contact(design, points=5)
    check(design, path)
    expected = np.where(over > 0.0, Status.OFF_FLANK, Status.NO_COMMON_NORMAL)
    expected[0] = Status.SOLVED
    np.testing.assert_array_equal(path.ends.status, expected)
    np.testing.assert_array_equal(path.ends.contact_ratio == 0.0, over < 0.1)


@pytest.mark.parametrize("total", [14.0, 5.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4])
def test_nearly_parallel_axes_satisfy_the_five_equations(total: float) -> None:
    """Crossed helical gears whose helix angles have the sum `total` deg, also below the 0.5 deg of design
    files. The pitch point loses digits with the square of the angle, the contact loses none."""
    gear = changed(PLAIN[1], helix_angle=radians(total) - float(PLAIN[0].helix_angle))
    free = closed(PLAIN[0], gear)
    layout = zero_backlash_layout(free)
    assert float(layout.offset) == pytest.approx(float(layout.working_radius.sum()), abs=1e-12)
    gap = abs(float(mounting_of(free).gap))
    assert gap < 1e-9 / total**2
    design = replace(free, pair=replace(free.pair, pinion_mounting=0.0, gear_mounting=0.0))
    ratios = [float(solved_path(design, flank).ends.contact_ratio) for flank in FLANKS]
    assert ratios[0] == pytest.approx(ratios[1], abs=1e-9 + 1e-2 * gap)
    assert 1.6 < ratios[0] < 1.7


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-17, 1e-12])
def test_parallel_axes_of_opposite_hands(angle: float) -> None:
    gear = changed(PLAIN[1], helix_angle=-float(PLAIN[0].helix_angle))
    design = Design(PLAIN[0], gear, Pair(249.0, radians(angle)))
    for flank in FLANKS:
        ratio = float(solved_path(design, flank).ends.contact_ratio)
        parallel = solved_path(replace(design, pair=Pair(249.0, 0.0)), flank)
        assert ratio == pytest.approx(float(parallel.ends.contact_ratio), abs=1e-12)
        assert ratio > 2.0


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-17, 1e-12])
@pytest.mark.parametrize("total", [1e-3, 14.43])
def test_parallel_axes_of_other_helix_angles_have_no_values(angle: float, total: float) -> None:
    gear = changed(PLAIN[1], helix_angle=radians(total) - float(PLAIN[0].helix_angle))
    for mounting in ((None, None), (0.0, 0.0)):
        design = Design(PLAIN[0], gear, Pair(244.0, radians(angle), *mounting))
        for flank in FLANKS:
            # Without mounting distances there is no layout either.
            assert_no_path(
                design, flank, Status.UNDEFINED if mounting[0] is None else Status.NO_COMMON_NORMAL
            )
        assert len(layout_deviation(design).reasons) >= 1
        assert all(remark.text for remark in remarks_on(design))


def test_a_negative_shaft_angle_inclines_the_axes_in_the_other_sense() -> None:
    """With a negative shaft angle, the lines of action meet in no layout and no contact is on the flanks. The
    mirrored pair has the same result."""
    for design in (at_shaft_angle(table1(), -15.0), at_shaft_angle(mirrored(table1()), -15.0)):
        for flank in FLANKS:
            assert_no_path(design, flank, Status.OFF_FLANK)
        closing = layout_deviation(design)
        assert np.isnan(closing.offset)
        assert closing.reasons == (
            "the lines of action do not meet at a shaft angle of -15 deg, whatever the offset",
        )


def right_angled(helix1: float, helix2: float, cone1: float, cone2: float) -> Design:
    """Return a pair without backlash whose axes cross at 90 deg; the helix angle of the gear is adjusted."""
    pinion = changed(PINION, helix_angle=radians(helix1), cone_angle=radians(cone1))

    def gear_with(helix: float) -> Design:
        return closed(pinion, changed(GEAR, helix_angle=radians(helix), cone_angle=radians(cone2)))

    def over(helix: float) -> float:
        return float(gear_with(helix).pair.shaft_angle) - 0.5 * np.pi

    found = gear_with(brentq(over, 0.9 * helix2, 1.1 * helix2, xtol=1e-14))
    return replace(found, pair=replace(found.pair, shaft_angle=0.5 * np.pi))


@pytest.mark.parametrize("signs", list(product((1.0, -1.0), repeat=2)))
@pytest.mark.parametrize("helix", [(25.0, 10.57), (20.0, 20.0), (30.0, 12.0)])
def test_hands_equal_and_opposite(helix: tuple[float, float], signs: tuple[float, float]) -> None:
    """All four combinations of hands: the pair is in contact, and so are its mirror image and the pair
    with exchanged members, with equal results."""
    beta = signs[0] * radians(helix[0]), signs[1] * radians(helix[1])
    pinion, gear = (
        changed(m, helix_angle=b, cone_angle=radians(1.0)) for m, b in zip((PINION, GEAR), beta, strict=True)
    )
    design = closed(pinion, gear)
    for flank, other in (FLANKS, FLANKS[::-1]):
        path = solved_path(design, flank)
        image = solved_path(mirrored(design), other)
        np.testing.assert_allclose(image.point * (1.0, -1.0, 1.0), path.point, rtol=0.0, atol=1e-9)
        assert float(contact_ratio(exchanged(design), flank)) > 0.0
    assert (float(design.pair.offset) > 0.0) is (abs(sum(beta)) > 1e-9)
    fitting = cos(radians(1.0)) ** 2 * cos(sum(beta)) - sin(radians(1.0)) ** 2
    assert float(design.pair.shaft_angle) == pytest.approx(np.arccos(fitting), abs=radians(1.0))
