"""Paths that no single flank parameter describes, traced by their length, against the five equations.

The oracle is the system of the paper at 60 digits (`validation.five_equations_mp`), solved at the roll of
the position, or at its l1 where the roll turns back.
"""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Status, contact_ratio, path_of_contact
from beveloid_geom.arrays import COMPLEX_STEP
from beveloid_geom.contact.curves.curve_equations import linearised, meet_on_curve, units_of
from beveloid_geom.contact.flank_pair import pairing_of
from beveloid_geom.contact.path import path_ends
from beveloid_geom.contact.path_polynomial import PathSeries
from beveloid_geom.contact.path_search import paths_on_flanks
from tests.contact.test_path import five_equation_residual
from tests.oracle.sixty_digits import exact_at, off_by
from tests.oracle.table1 import table1
from tests.stability.five_residuals import margins
from tests.stability.named_designs import CROSSING
from tests.symmetry import exchanged

TURNING = {
    "a -0.002/-0.002": table1((-0.002, -0.002), Errors(offset=-6.0, shaft_angle=radians(-0.08))),
    "a -0.0022/-0.0017": table1((-0.0022, -0.0017), Errors(offset=-6.1, shaft_angle=radians(-0.12))),
    "a -0.01/0.01": table1((-0.01, 0.01)),
}
"""Pairs on which l1 turns back on the flanks."""
LOST = CROSSING | TURNING
both = pytest.mark.parametrize("design", LOST.values(), ids=LOST)


def series_found(design: Design) -> PathSeries:
    with np.errstate(invalid="ignore", divide="ignore"):
        (group,) = paths_on_flanks(pairing_of(design, "right"))
    return group.series


@both
def test_followed_paths_agree_with_the_five_equations(design: Design) -> None:
    path = path_of_contact(design, points=9)
    assert path.ends.status == Status.SOLVED
    assert np.isnan(series_found(design).half).all()  # it was traced
    assert five_equation_residual(design, path) < 1e-11
    for k in range(9):
        rate = np.abs(np.gradient(path.pinion_roll))[k], np.abs(np.gradient(path.l1))[k]
        fixed = "phi1" if rate[0] > 1e-3 * rate[1] else "l1"
        assert off_by(path, k, fixed)[0] < 1e-9
    inside = margins(design, path)
    assert inside.min() > -1e-9
    assert np.abs(inside.min(axis=0)[[0, -1]]).max() < 1e-9  # both ends are on a limit


@pytest.mark.parametrize("design", CROSSING.values(), ids=CROSSING)
def test_the_normal_crosses(design: Design) -> None:
    path = path_of_contact(design, points=401)
    n_x = path.normal[:, 0]
    assert n_x.min() < -0.001
    assert n_x.max() > 0.001
    steps = np.linalg.norm(np.diff(path.point, axis=0), axis=-1)
    assert steps.max() < 1.3 * steps.mean()  # no jump where the branches of n_x join
    assert np.unwrap(path.pinion_roll).tolist() == path.pinion_roll.tolist()


@pytest.mark.parametrize("design", TURNING.values(), ids=TURNING)
def test_l1_turns_back_and_one_l1_has_two_contacts(design: Design) -> None:
    path = path_of_contact(design, points=401)
    steps = np.diff(path.l1)
    assert steps.min() < 0.0 < steps.max()
    ends, extreme = np.sort(path.l1[[0, -1]]), (path.l1.min(), path.l1.max())
    low = ends[0] - extreme[0] > extreme[1] - ends[1]
    twice = np.linspace(extreme[0], ends[0], 9) if low else np.linspace(ends[1], extreme[1], 9)
    at = path_of_contact(design, l1=twice[1:-1])
    assert (at.status == Status.SEVERAL_CONTACTS).all()
    assert np.isnan(at.point).all()
    once = path_of_contact(design, l1=np.linspace(ends[0], ends[1], 9)[1:-1])
    assert (once.status == Status.SOLVED).all()
    assert five_equation_residual(design, once) < 1e-10


@both
def test_members_exchanged_give_the_same_path(design: Design) -> None:
    here, there = path_ends(design), path_ends(exchanged(design))
    assert there.status == Status.SOLVED
    np.testing.assert_allclose(np.sort(here.l1), np.sort(there.l2), atol=1e-10)
    np.testing.assert_allclose(np.sort(here.l2), np.sort(there.l1), atol=1e-10)


def test_a_batch_mixes_both_kinds() -> None:
    offsets = np.array([0.0, -6.0, 0.1, -6.0, 2000.0])
    shaft = np.radians([0.0, -0.08, 0.0, -0.1, 0.0])
    batch = table1((-0.002, -0.002), Errors(offset=offsets, shaft_angle=shaft))
    path = path_of_contact(batch, points=11)
    l1 = np.linspace(-4.2, -4.12, 11)
    at = path_of_contact(batch, l1=l1)
    for k in range(4):
        single = table1((-0.002, -0.002), Errors(offset=float(offsets[k]), shaft_angle=float(shaft[k])))
        alone, given = path_of_contact(single, points=11), path_of_contact(single, l1=l1)
        np.testing.assert_allclose(path.point[k], alone.point, atol=1e-10)
        np.testing.assert_allclose(path.transmission_error[k], alone.transmission_error, atol=1e-12)
        assert at.status[k].tolist() == given.status.tolist()
        np.testing.assert_allclose(at.l2[k], given.l2, atol=1e-10)
    assert path.ends.status[4] in (Status.OFF_FLANK, Status.NO_COMMON_NORMAL)
    assert contact_ratio(batch)[4] == 0.0


def test_positions_are_at_the_given_l1() -> None:
    l1 = np.linspace(-5.0, 5.0, 37)
    for design in (table1((0.001, -0.001)), table1((-0.01, 0.01))):
        assert path_of_contact(design, l1=l1).l1.tolist() == l1.tolist()


@pytest.mark.parametrize("design", [table1((0.001, -0.001)), *CROSSING.values()])
def test_derivatives_are_those_of_a_complex_step(design: Design) -> None:
    pairing, rng = pairing_of(design, "right"), np.random.default_rng(0)
    units = units_of(pairing)
    depth = pairing.highest - pairing.lowest
    l = pairing.lowest + depth * rng.uniform(0.0, 1.0, (2, 1, 20))
    y = np.array((*l, rng.uniform(-0.2, 0.2, (1, 20)), rng.uniform(-10.0, 10.0, (1, 20))))
    z = np.moveaxis(y, 0, -1) / units
    _, jacobian = linearised(pairing, z, units)
    for k in range(4):
        moved = np.moveaxis((z + COMPLEX_STEP * 1j * np.eye(4)[k]) * units, -1, 0)
        exact = np.moveaxis(meet_on_curve(pairing, moved)[0].imag, 0, -1) / COMPLEX_STEP
        np.testing.assert_allclose(jacobian[..., k], exact, rtol=1e-12, atol=1e-15)


def test_a_curve_is_not_left_for_another_far_from_the_faces() -> None:
    """Long steps once changed to another curve, so that the segment on the flanks was counted twice."""
    design = CROSSING["4.15/2.03 deg"].with_parabola(0.0012891466317091031, 0.000607238206935391)
    assert path_ends(design).pieces == 1
    assert path_ends(exchanged(design)).pieces == 1


@pytest.mark.parametrize("a", [0.00045, 0.0005])
def test_contact_ratio_where_the_roll_turns_back_at_60_digits(a: float) -> None:
    """Eq. 16 is the range of roll of the path by the five equations; its ends are closer together."""
    path = path_of_contact(table1((a, a)), points=401)
    turn = int(path.pinion_roll.argmin() if path.pinion_roll.argmin() % 400 else path.pinion_roll.argmax())
    rolls = [float(exact_at(path, k, "l1").phi1) for k in (0, turn - 1, turn, turn + 1, 400)]
    before, middle, after = rolls[1:4]  # extremum of the parabola through three positions
    extreme = middle - 0.125 * (after - before) ** 2 / (before - 2.0 * middle + after)
    pitch, ends = 2.0 * np.pi / 29, (rolls[0], rolls[-1])
    ratio = (max(*ends, extreme) - min(*ends, extreme)) / pitch
    assert path.ends.contact_ratio == pytest.approx(ratio, abs=1e-8)
    assert abs(ends[1] - ends[0]) / pitch < 0.8 * ratio


@pytest.mark.parametrize("a", [0.0004, 0.00045, 0.0005, 0.00055])
def test_transmission_error_has_one_reference(a: float) -> None:
    path = path_of_contact(table1((a, a)))
    again = path_of_contact(table1((a, a)), l1=path.l1)
    np.testing.assert_allclose(again.transmission_error, path.transmission_error, atol=1e-12)


FROM_AFAR = [
    ((-0.0025, -0.0007), -7.0, -0.09, -2.9473),
    ((-0.0023, -0.0008), -9.0, -0.06, -5.1517),
    ((-0.0011, -0.0010), -9.3, -0.13, -5.5744),
    ((-0.0022, -0.0017), -6.1, -0.12, -2.8432),
    ((0.0, 0.0), 1.2335, 0.0, 4.65),
]
"""Parabolas, errors of offset and shaft angle (mm, deg), and l1 of a contact on the flanks."""


@pytest.mark.parametrize(("parabola", "offset", "shaft_deg", "l1"), FROM_AFAR)
def test_contact_on_the_flanks_is_never_lost(
    parabola: tuple[float, float], offset: float, shaft_deg: float, l1: float
) -> None:
    design = table1(parabola, Errors(offset=offset, shaft_angle=radians(shaft_deg)))
    at = path_of_contact(design, l1=[l1])
    assert at.status[0] == Status.SOLVED
    assert five_equation_residual(design, at) < 1e-10
    assert margins(design, at).min() > 0.0
    assert path_ends(design).status not in (Status.OFF_FLANK, Status.NO_COMMON_NORMAL)
    assert contact_ratio(design) != 0.0


def test_two_roots_between_two_samples_are_not_a_missing_normal() -> None:
    """Both contacts of l1 = -1.0417, with n_x of 0.14 and 0.10, are found, although both roots lie between
    two samples. They are also found with the members exchanged."""
    design = table1((0.0089, -0.0091), Errors(offset=-0.4, shaft_angle=radians(-0.07)))
    l2 = np.array([0.4338, 0.2431, -1.4578, -2.3864])
    other = path_of_contact(exchanged(design), l1=l2)
    assert (other.status == Status.SOLVED).all()
    assert five_equation_residual(exchanged(design), other) < 1e-9
    path = path_of_contact(design, l1=other.l2)
    assert np.isin(path.status, (Status.SOLVED, Status.SEVERAL_CONTACTS)).all()
