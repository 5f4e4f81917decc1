"""Modified flanks on nearly parallel axes: what is said to touch nowhere, against all curves as traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, Errors, builtin_design, path_of_contact
from beveloid_geom.contact.equation import pairing_of
from beveloid_geom.contact.parallel import clear
from beveloid_geom.contact.parallel.nearly import nearly_parallel
from beveloid_geom.contact.path_search import _followed
from beveloid_geom.status import Status

PAIR = builtin_design("anti-backlash")
HELICAL = replace(
    PAIR,
    pinion=replace(PAIR.pinion, helix_angle=0.3, cone_angle=0.0),
    gear=replace(PAIR.gear, helix_angle=-0.3, cone_angle=0.0),
    pair=replace(PAIR.pair, offset=75.5),
)


def misaligned(design: Design, count: int, alike: bool) -> Design:
    """Draw parabolas, conjugate ones if `alike`, and errors, of the shaft angle up to 0.5 deg."""
    stream = np.random.default_rng(4)
    first = 4e-3 * stream.uniform(-1.0, 1.0, count)
    second = -first if alike else 4e-3 * stream.uniform(-1.0, 1.0, count)
    angle = np.radians(0.5) * 10.0 ** stream.uniform(-3.0, 0.0, count) * stream.choice([-1.0, 1.0], count)
    offset, axial = 0.05 * stream.standard_normal(count), 0.2 * stream.standard_normal((2, count))
    return design.with_parabola(first, second).with_errors(Errors(offset, angle, *axial))


@pytest.mark.parametrize("design", [PAIR, HELICAL], ids=["straight on cones", "helical"])
@pytest.mark.parametrize("alike", [True, False])
def test_no_traced_curve_is_on_flanks_that_are_clear(design: Design, alike: bool, flank: str) -> None:
    """And so are a good part of those without a path, else between limits of l and tips."""
    cases = misaligned(design, 40, alike)
    pairing = pairing_of(cases, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        told = clear.clear_of_flanks(pairing)
        groups = _followed(pairing.cases(np.flatnonzero(told)))
    assert nearly_parallel(pairing).all()
    without = path_of_contact(cases, flank, 2).ends.status != Status.SOLVED
    assert np.count_nonzero(told) > 0.3 * np.count_nonzero(without)
    assert not (told & ~without).any()
    for group in groups:
        assert not (group.ends.status == Status.SOLVED).any()


def test_lines_lost_to_an_error_of_the_shaft_angle_are_not_traced(
    flank: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Conjugate racks, whose flanks touch along lines without the error."""
    monkeypatch.setattr("beveloid_geom.contact.path_search._crossed", None)
    design = replace(PAIR, gear=replace(PAIR.gear, profile_shift=-0.36)).with_parabola(4e-3, -4e-3)
    angle = np.radians([0.0, 1e-4, -1e-3, 0.01, -0.03, 0.1])
    found = path_of_contact(design.with_errors(Errors(shaft_angle=angle)), flank, 3)
    assert found.ends.status.tolist() == [Status.SOLVED] + 5 * [Status.OFF_FLANK]
