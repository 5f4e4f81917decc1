"""70,000 random pairs and misalignments: every result is correct, and every missing result has a reason."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from beveloid_geom import ContactPath, Design, Status, path_of_contact
from beveloid_geom.arrays import Flank, FloatArray, gear_sense
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.gear.flank_limits import highest_parameter, root_parameter
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.mounting import mounting_of

from .answers import without_undercut
from .five_residuals import cases_of, column, joined, margins, residuals, search
from .random_designs import KINDS, Kind, parabola_limits, random_designs

SIZES: dict[Kind, int] = {
    "usual": 12600,
    "fitted": 800,
    "strained": 800,
    "touching": 400,
    "wild": 400,
    "intersecting": 20000,
}
"""Designs of each kind; each is solved on both flanks."""
LOST: dict[Kind, float] = {
    **dict.fromkeys(KINDS, 0.0025),
    **{"usual": 1e-4, "touching": 0.05, "intersecting": 1e-4},
}
"""Share of each kind whose path may be lost, with a status."""
BLOCK, POSITIONS, SEARCHED = 512, 5, 100
"""Designs at a time, positions on a path, and "no contact" results of a kind and flank that are searched."""
FLANKS: tuple[Flank, Flank] = ("right", "left")
NO_CONTACT = (Status.NO_COMMON_NORMAL, Status.OFF_FLANK)
UNKNOWN = (Status.NOT_CONVERGED, Status.SEVERAL_CONTACTS)


def blocks(kind: Kind, flank: Flank) -> list[Design]:
    whole = random_designs(kind, SIZES[kind], seed=2017, flank=flank)
    return [cases_of(whole, slice(k, k + BLOCK)) for k in range(0, SIZES[kind], BLOCK)]


def at_ends(path: ContactPath, room: FloatArray) -> FloatArray:
    """Return the margin (mm) to the limit that is reported to end the path, (cases, 2)."""
    row = np.maximum(path.ends.limit, 0)
    case = np.arange(len(row))
    return np.stack((room[row[:, 0], case, 0], room[row[:, 1], case, -1]), axis=-1)


def numbers_of(path: ContactPath) -> FloatArray:
    """Return all numbers of the paths, with one axis after that of the cases."""
    arrays = [value for value in vars(path).values() if isinstance(value, np.ndarray)]
    ends = [path.ends.l1, path.ends.l2, path.ends.pinion_roll]
    return np.concatenate([part.reshape(len(path.status), -1) for part in (*arrays, *ends)], axis=-1)


def check(design: Design, path: ContactPath) -> None:
    """Check all values of one result, for a batch."""
    status, ratio = path.ends.status, path.ends.contact_ratio
    assert np.isin(status, [int(code) for code in Status]).all()
    assert (path.status == status[:, None]).all()
    distance = mounting_of(design).distance
    none, solved = np.isin(status, NO_CONTACT), status == Status.SOLVED
    assert (ratio[none] == 0.0).all()
    assert np.isnan(ratio[~none & ~solved]).all()
    np.testing.assert_array_equal(status == Status.UNDEFINED, np.isnan(distance).any(axis=0))
    assert np.isnan(path.point[~solved]).all()
    assert (path.ends.limit[~solved] == -1).all()
    if not solved.any():
        return
    design, path = cases_of(design, solved), cases_of(path, solved)
    assert np.isfinite(numbers_of(path)).all()
    assert (path.ends.contact_ratio > 0.0).all()
    apart, crossed = residuals(design, path, distance[:, solved])
    assert apart.max() <= 1e-9
    # A mounting distance, rounded, over the radius of a pinion of one tooth: 1e-12 rad where the apex is far.
    radius = np.minimum(*(np.asarray(reference_radius(member)) for member in design.members))
    turned = np.finfo(float).eps * np.abs(distance[:, solved]).max(axis=0) / radius
    assert (crossed <= 1e-12 + turned[:, None]).all()
    room = margins(design, path)
    assert room.min() >= -1e-9
    assert np.abs(at_ends(path, room)).max() <= 1e-9
    ratio = column(design.pinion.teeth) / column(design.gear.teeth)
    ahead = gear_sense(path.flank) * path.transmission_error
    middle = path.gear_roll + ratio * path.pinion_roll - ahead
    size = np.maximum(1.0, np.abs(path.gear_roll).max(axis=-1))
    assert (np.ptp(middle, axis=-1) <= 1e-12 * size).all()


def assert_none_is_missed(design: Design, flank: Flank) -> None:
    """Check that an independent search finds no contact on the flanks if no contact is reported."""
    distance = mounting_of(design).distance
    for start in range(0, distance.shape[1], 16):
        part = slice(start, start + 16)
        for turned in (False, True):
            found = search(cases_of(design, part), flank, distance[:, part], 24, turned)
            assert found.margin.max(initial=-1.0) <= 1e-9
    if distance.shape[1]:  # nor do single positions
        low, high = (column(bound(design.pinion, "right")) for bound in (root_parameter, highest_parameter))
        at = path_of_contact(design, flank, l1=low + (high - low) * np.linspace(0.0, 1.0, 17))
        assert (at.status != Status.SOLVED).all()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_random_designs(kind: Kind, flank: Flank) -> None:
    found: Counter[str] = Counter()
    searched = 0
    for design in blocks(kind, flank):
        with without_undercut():
            path = path_of_contact(design, flank, POSITIONS)
            check(design, path)
            none = np.flatnonzero(np.isin(path.ends.status, NO_CONTACT))[: SEARCHED - searched]
            assert_none_is_missed(cases_of(design, none), flank)
        found.update(Status(code).name for code in path.ends.status)
        searched += len(none)
    print(f"\n{kind:13s}{flank:6s}", dict(found), "searched", searched)
    assert sum(found.values()) == SIZES[kind]
    assert sum(found[code.name] for code in UNKNOWN) <= LOST[kind] * SIZES[kind]


def test_there_are_70_000() -> None:
    assert len(FLANKS) * sum(SIZES.values()) == 70_000


def test_the_search_finds_contacts(flank: Flank) -> None:
    """The search finds a contact of nearly every pair that was placed at one, so that the comparison can
    fail."""
    design = random_designs("touching", 100, seed=4, flank=flank)
    distance = mounting_of(design).distance
    found = joined([search(design, flank, distance, turned=turned) for turned in (False, True)])
    assert len(np.unique(found.case[found.margin > 0.0])) >= 90


@pytest.mark.parametrize("kind", KINDS)
def test_a_batch_equals_its_single_designs(kind: Kind) -> None:
    design = random_designs(kind, 12, seed=3)
    batch = path_of_contact(design, "right", 3)
    for case in range(12):
        single = path_of_contact(cases_of(design, case), "right", 3)
        assert single.ends.status == batch.ends.status[case]
        np.testing.assert_allclose(
            single.ends.contact_ratio, batch.ends.contact_ratio[case], rtol=0.0, atol=1e-9
        )
        if single.ends.status == Status.SOLVED:
            np.testing.assert_allclose(single.point, batch.point[case], atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_parabola_limits_are_those_of_a_design_file(kind: Kind) -> None:
    members = random_designs(kind, 20, seed=8).members
    for member in members:
        limits = parabola_limits(member)
        single = [parabola_limit(cases_of(member, case)) for case in range(20)]
        np.testing.assert_allclose(limits, single, rtol=1e-12)
