"""Doubtful cases found by a random search: no wrong number, no false "no contact"."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Errors, Status, contact_ratio, path_of_contact
from beveloid_geom.contact.path import path_ends
from tests.contact.test_path import five_equation_residual
from tests.oracle.sixty_digits import exact_at
from tests.oracle.table1 import table1
from tests.stability.five_residuals import margins
from tests.symmetry import exchanged


@pytest.mark.parametrize("a", [0.00045, 0.0005])
def test_contact_ratio_where_the_roll_turns_back_at_60_digits(a: float) -> None:
    """Eq. 16 is greatest less least roll of the path, by the five equations; its ends are nearer together."""
    path = path_of_contact(table1((a, a)), points=401)
    turn = int(path.pinion_roll.argmin() if path.pinion_roll.argmin() % 400 else path.pinion_roll.argmax())
    rolls = [float(exact_at(path, k, "l1").phi1) for k in (0, turn - 1, turn, turn + 1, 400)]
    before, middle, after = rolls[1:4]  # the extreme of the parabola through three positions
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
def test_contact_on_the_flanks_is_never_called_none(
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
    """n_x is 0.14 and 0.10 at the two contacts of l1 = -1.0417; the members exchanged find them."""
    design = table1((0.0089, -0.0091), Errors(offset=-0.4, shaft_angle=radians(-0.07)))
    l2 = np.array([0.4338, 0.2431, -1.4578, -2.3864])
    other = path_of_contact(exchanged(design), l1=l2)
    assert (other.status == Status.SOLVED).all()
    assert five_equation_residual(exchanged(design), other) < 1e-9
    path = path_of_contact(design, l1=other.l2)
    assert np.isin(path.status, (Status.SOLVED, Status.SEVERAL_CONTACTS)).all()
