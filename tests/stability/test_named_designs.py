"""Designs that a random search found difficult, by numbers (`named_designs.toml`), with the former failure.

Each is solved now and is compared with the five equations at 60 digits, and with an independent search for
contacts that the path might omit."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import ContactPath, Status, contact_ratio, path_of_contact
from beveloid_geom.contact.path import path_ends
from beveloid_geom.pair.mounting import mounting_of
from tests.oracle.sixty_digits import exact_at
from tests.symmetry import exchanged

from .answers import assert_no_path, path_without_undercut, solved_path, without_undercut
from .five_residuals import batch_of_one, joined, margins, off_path, residuals, search
from .named_designs import LOST, OTHER, SECOND_PATH

UNDERCUT = ("next to n_x = 0",)
"""Lost designs whose path lies where undercut has removed the flank: solved without undercut."""


def path_of(name: str, points: int) -> ContactPath:
    """Return the path of a lost design."""
    case = LOST[name]
    if name not in UNDERCUT:
        return path_of_contact(case.design, case.flank, points)
    assert path_ends(case.design, case.flank).status == Status.OFF_FLANK
    return path_without_undercut(case.design, case.flank, points)


@pytest.mark.parametrize("name", LOST)
def test_is_solved(name: str) -> None:
    case, path = LOST[name], path_of(name, 21)
    assert path.ends.status == Status.SOLVED
    apart, crossed = residuals(case.design, path, mounting_of(case.design).distance)
    assert apart.max() <= 1e-9
    assert crossed.max() <= 1e-12
    assert margins(case.design, path).min() >= -1e-9


@pytest.mark.parametrize("name", LOST)
def test_agrees_with_60_digits(name: str) -> None:
    path = path_of(name, 7)
    for k in (1, 4):
        # A path across the face in 0.0001 rad of roll: l1 determines a contact there, but the roll does not.
        true = exact_at(path, k, "l1" if path.ends.contact_ratio < 0.01 else "phi1")
        np.testing.assert_allclose(path.point[k], np.array(true.point, dtype=float), rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(path.normal[k], np.array(true.normal, dtype=float), rtol=0.0, atol=1e-12)
        rolls = path.pinion_roll[k], path.gear_roll[k]
        np.testing.assert_allclose((float(true.phi1), float(true.phi2)), rolls, rtol=0.0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", LOST)
def test_no_contact_is_missing(name: str) -> None:
    """A search by independent code finds contacts on the flanks, and all of them are on the path."""
    case = LOST[name]
    design = batch_of_one(case.design)
    distance = mounting_of(design).distance
    with without_undercut():
        path = path_of_contact(design, case.flank, 401)
    module = float(case.design.pinion.tool.normal_module)
    found = joined([search(design, case.flank, distance, 96, turned) for turned in (False, True)])
    found = found.beyond(1e-6 * module)
    if path.ends.pieces[0] == 1:
        assert off_path(path, found).max(initial=0.0) <= 2e-3 * module
    if path.ends.contact_ratio[0] > 0.1:
        assert found.case.size > 0


@pytest.mark.parametrize("name", SECOND_PATH)
def test_a_second_path_of_the_other_sign_is_counted(name: str) -> None:
    """The path with the largest range of roll is used, the other one counts as a segment."""
    case = SECOND_PATH[name]
    design = batch_of_one(case.design)
    distance = mounting_of(design).distance
    with without_undercut():
        path = path_of_contact(design, case.flank, 401)
    found = joined([search(design, case.flank, distance, 96, turned) for turned in (False, True)])
    assert path.ends.status[0] == Status.SOLVED
    assert path.ends.pieces[0] == 2
    assert off_path(path, found).max() > 0.01 * float(case.design.pinion.tool.normal_module)


def test_without_a_layout_there_are_no_values(flank: str) -> None:
    design = OTHER["no layout"].design
    assert_no_path(design, flank, Status.UNDEFINED)
    assert np.isnan(contact_ratio(design, flank))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "l1"), [("across a narrow face", 2.15928085), ("lost outside", -3.15)])
def test_a_lost_path_is_not_reported_as_missing(name: str, l1: float) -> None:
    """Single positions lie on the flanks: their path may be lost, but it is not reported as missing."""
    design = OTHER[name].design
    assert path_of_contact(design, "left", l1=[l1]).status[0] == Status.SOLVED
    for pair in (design, exchanged(design)):
        assert path_ends(pair, "left").status in (Status.NOT_CONVERGED, Status.SOLVED)


def test_the_other_sign_of_n_x_is_searched() -> None:
    design = OTHER["the other sign of n_x"].design
    path = solved_path(design, points=5)
    assert (np.sign(path.normal[:, 0]) == -mounting_of(design).branch[0]).all()
    assert margins(design, path).min() > -1e-9
