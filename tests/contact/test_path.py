"""Paths of contact: exact ends, even rolls, both methods, and contacts at given l1."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Status,
    contact_ratio,
    path_of_contact,
)
from beveloid_geom.arrays import Flank
from beveloid_geom.contact.path import path_ends
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.pair.frames import layout_of, member_frame, normals_to_fixed, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Limit
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of, margins
from tests.stability.random_designs import Kind, random_designs

FLANKS = ("right", "left")
CASES = [(0.0, 0.0), *((a, -a) for a in (0.001, -0.002)), *((a, a) for a in (0.001, 0.0002, -0.0002, -0.002))]
NUMBERS = (
    *("l1", "u1", "l2", "u2", "pinion_roll", "gear_roll", "point", "normal"),
    *("pinion_z", "pinion_r", "gear_z", "gear_r", "transmission_error"),
)


def five_equation_residual(design: Design, path: ContactPath) -> float:
    """Return the largest residual of Eq. 15, mm and 1, from flanks and frames alone."""
    layout, mounting, worst = layout_of(design), mounting_of(design).distance, 0.0
    errors = (design.errors.pinion_axial, design.errors.gear_axial)
    for j, (member, l, u, roll) in enumerate(
        zip(
            design.members,
            (path.l1, path.l2),
            (path.u1, path.u2),
            (path.pinion_roll, path.gear_roll),
            strict=True,
        )
    ):
        patch = flank_patch(member, path.flank, l, u)
        frame = member_frame(layout, j, roll, mounting[j] + errors[j])
        normal = normals_to_fixed(frame, patch.normal) * (1 - 2 * j)
        worst = max(worst, np.abs(to_fixed(frame, patch.point) - path.point).max(initial=0.0))
        worst = max(worst, np.abs(normal - path.normal).max(initial=0.0))
        x, y, z = np.moveaxis(patch.point, -1, 0)
        own_z, own_r = ((path.pinion_z, path.pinion_r), (path.gear_z, path.gear_r))[j]
        worst = max(
            worst, np.abs(z - own_z).max(initial=0.0), np.abs(np.hypot(x, y) - own_r).max(initial=0.0)
        )
    return float(worst)


@pytest.mark.parametrize("parabola", CASES)
def test_ends_are_exact_and_rolls_even(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola)
    path = path_of_contact(design, flank, 41)
    inside = margins(design, path)
    assert inside.min() > -1e-11
    for end, position in ((path.ends.enter, 0), (path.ends.leave, -1)):
        assert end is not None
        assert abs(inside[end, position]) < 1e-11
    steps = np.diff(path.pinion_roll)
    np.testing.assert_allclose(steps, steps.mean(), atol=1e-13)
    assert (steps > 0.0).all() == (flank == "right")
    span = abs(path.pinion_roll[-1] - path.pinion_roll[0])
    assert path.contact_ratio == pytest.approx(span * 29 / (2 * np.pi), rel=1e-13)


@pytest.mark.parametrize(
    ("flank", "parabola", "expected"),
    [
        ("right", (0.0, 0.0), 1.651001),
        ("left", (0.0, 0.0), 1.652028),
        ("right", (0.001, -0.001), 1.816308),
    ],
)
def test_contact_ratios_of_table_1(flank: str, parabola: tuple[float, float], expected: float) -> None:
    assert contact_ratio(table1(parabola), flank) == pytest.approx(expected, abs=1e-6)
    ends = path_ends(table1(parabola), flank)
    assert (ends.enter, ends.leave) == (Limit.GEAR_TIP, Limit.PINION_TIP)


@settings(max_examples=40, deadline=None)
@given(
    st.floats(-1.0, 1.0),
    st.floats(-5e-4, 5e-4),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.sampled_from(FLANKS),
)
def test_unmodified_flanks_transmit_exactly(e: float, d: float, a1: float, a2: float, flank: str) -> None:
    """Involute helicoids rotate at a constant ratio under every misalignment."""
    path = path_of_contact(table1(errors=Errors(e, d, a1, a2)), flank, 21)
    assert np.abs(path.transmission_error).max(initial=0.0) < 1e-12


@pytest.mark.parametrize("parabola", [*((a, -a) for a in (0.0, 1e-14, -1e-14, 1e-9, 1e-3)), (2e-4, 2e-4)])
def test_both_methods_agree(flank: str, parabola: tuple[float, float]) -> None:
    design = table1(parabola, Errors(0.2, 1e-4, 0.3, 0.1))
    ours, reference = path_of_contact(design, flank, 9), path_of_contact_five_equations(design, flank, 9)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(ours, name), getattr(reference, name), atol=2e-11, err_msg=name)
    np.testing.assert_array_equal(ours.ends.limit, reference.ends.limit)
    assert ours.ends.contact_ratio == pytest.approx(reference.ends.contact_ratio, abs=1e-12)


def test_given_parameters_lie_on_the_path_and_are_not_clipped() -> None:
    design = table1((0.001, -0.001))
    path = path_of_contact(design, points=21)
    given_l1 = path_of_contact(design, l1=path.l1)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(given_l1, name), getattr(path, name), atol=1e-11, err_msg=name)
    beyond = path_of_contact(design, l1=np.array([-8.0, -6.3, 0.0, 6.0, 8.0]))
    assert beyond.status.tolist() == [Status.OFF_FLANK] * 2 + [Status.SOLVED] + [Status.OFF_FLANK] * 2
    assert np.isfinite(beyond.point).all()
    assert five_equation_residual(design, beyond) < 2e-11


def test_a_single_l1_and_the_ends_of_a_batch() -> None:
    assert path_of_contact(table1(), l1=0.0).l1.shape == (1,)
    with pytest.raises(ValueError, match="single path"):
        _ = path_ends(table1(errors=Errors(offset=np.zeros(2)))).enter


@pytest.mark.parametrize("kind", ["usual", "strained", "touching", "intersecting"])
def test_a_few_l1_have_the_contacts_of_many(kind: Kind, flank: Flank) -> None:
    """Contacts at a few given l1, which are solved one by one, equal those of a call with many l1. Ends and
    transmission error are computed when they are first read."""
    designs, near = random_designs(kind, 12, 5, flank), 0
    for k in range(12):
        one = cases_of(designs, slice(k, k + 1))
        asked = float(one.pinion.tool.normal_module[0]) * np.linspace(-0.9, 0.9, 19)
        few, unread = (path_of_contact(one, flank, l1=asked[4:9]) for _ in range(2))
        many, unread = path_of_contact(one, flank, l1=asked), pickle.loads(pickle.dumps(unread))
        np.testing.assert_array_equal(few.status, many.status[:, 4:9])
        on = few.status == Status.SOLVED
        near += int(np.count_nonzero(on))
        # Without a path the transmission error is relative to the middle of the given l1.
        for name in NUMBERS if few.ends.status == Status.SOLVED else NUMBERS[:-1]:
            found, given = getattr(few, name), getattr(many, name)[:, 4:9]
            np.testing.assert_allclose(found[on], given[on], rtol=0.0, atol=1e-8)
            np.testing.assert_array_equal(getattr(unread, name), found)
        for name, value in vars(many.ends).items():
            np.testing.assert_array_equal(getattr(few.ends, name), value)
    assert near > 5
