"""Modified flanks on nearly parallel axes: cases excluded without a trace, and paths of weak parabolas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, Errors, builtin_design, path_of_contact
from beveloid_geom.contact.flank_pair import pairing_of
from beveloid_geom.contact.parallel import no_contact_bound
from beveloid_geom.contact.parallel.small_angle_paths import nearly_parallel
from beveloid_geom.contact.path_search import _followed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Status
from tests.stability.five_residuals import residuals

PAIR = builtin_design("anti-backlash")
HELICAL = replace(
    PAIR,
    pinion=replace(PAIR.pinion, helix_angle=0.3, cone_angle=0.0),
    gear=replace(PAIR.gear, helix_angle=-0.3, cone_angle=0.0),
    pair=replace(PAIR.pair, offset=75.5),
)


def misaligned(design: Design, count: int, alike: bool) -> Design:
    """Return random parabolas, conjugate ones if `alike`, and errors, of the shaft angle up to 0.5 deg."""
    stream = np.random.default_rng(4)
    first = 4e-3 * stream.uniform(-1.0, 1.0, count)
    second = -first if alike else 4e-3 * stream.uniform(-1.0, 1.0, count)
    angle = np.radians(0.5) * 10.0 ** stream.uniform(-3.0, 0.0, count) * stream.choice([-1.0, 1.0], count)
    offset, axial = 0.05 * stream.standard_normal(count), 0.2 * stream.standard_normal((2, count))
    return design.with_parabola(first, second).with_errors(Errors(offset, angle, *axial))


@pytest.mark.parametrize("design", [PAIR, HELICAL], ids=["straight on cones", "helical"])
@pytest.mark.parametrize("alike", [True, False])
def test_no_traced_curve_is_on_flanks_that_are_clear(design: Design, alike: bool, flank: str) -> None:
    """No case that the bound excludes has a path, traced or not. The bound excludes more than 30 % of the
    cases without a path."""
    cases = misaligned(design, 40, alike)
    pairing = pairing_of(cases, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        told = no_contact_bound.clear_of_flanks(pairing)
        groups = _followed(pairing.cases(np.flatnonzero(told)))
    assert nearly_parallel(pairing).all()
    without = path_of_contact(cases, flank, 2).ends.status != Status.SOLVED
    assert np.count_nonzero(told) > 0.3 * np.count_nonzero(without)
    assert not (told & ~without).any()
    for group in groups:
        assert not (group.ends.status == Status.SOLVED).any()


def test_edge_contact_of_conjugate_racks_is_not_traced(flank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Flanks of conjugate racks touch along lines; under a shaft-angle error their edges touch, and no curve
    is traced."""
    monkeypatch.setattr("beveloid_geom.contact.path_search._crossed", None)
    design = replace(PAIR, gear=replace(PAIR.gear, profile_shift=-0.36)).with_parabola(4e-3, -4e-3)
    angle = np.radians([0.0, 1e-4, -1e-3, 0.01, -0.03, 0.1])
    found = path_of_contact(design.with_errors(Errors(shaft_angle=angle)), flank, 3)
    assert found.ends.status.tolist() == [Status.SOLVED] + 5 * [Status.OFF_FLANK]


@pytest.mark.parametrize("parabola", [(1e-5, 3e-6), (-2e-5, 0.0), (4e-6, -3e-5)])
def test_weak_parabolas_have_a_path_under_a_small_shaft_angle_error(
    parabola: tuple[float, float], flank: str
) -> None:
    """Parabolas and error in proportion have the same l1 and l2 to first order, down to parabolas with which
    rounding moves l1 and l2 by 1e-7 mm.
    """
    weaker = np.array((1.0, 0.1, 0.01, 0.001))
    design = HELICAL.with_parabola(*(coefficient * weaker for coefficient in parabola))
    design = design.with_errors(Errors(shaft_angle=3e-6 * weaker))
    path = path_of_contact(design, flank, 5)
    assert (path.ends.status == Status.SOLVED).all()
    np.testing.assert_allclose(path.l1[1:], path.l1[:-1], atol=2e-3)
    np.testing.assert_allclose(path.l2[1:], path.l2[:-1], atol=2e-3)
    apart, turned = residuals(design, path, mounting_of(design).distance)
    assert apart.max() < 1e-10
    assert turned.max() < 1e-12
