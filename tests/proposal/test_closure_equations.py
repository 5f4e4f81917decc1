"""Solutions of the closure equations: mounted pairs, 60 digits, closed forms, mirror images."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from beveloid_geom import Design, Pair, builtin_design, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.generator_angle import generator_angle_as_mounted
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.proposal.candidates import candidates_of, found_for_each, within
from beveloid_geom.proposal.merit import PairCriteria, criteria_of, design_of, tooth_criteria
from beveloid_geom.proposal.request import Request
from tests.oracle.pitch_point_mp import mounting_mp
from tests.symmetry import scaled

TABLE1 = Request(
    module=6.0,
    teeth=(29, 45),
    face_widths=(50.0, 60.0),
    shaft_angle=radians(15.0),
    backlash=0.0416,
    offset=229.0,
    helix_angle=radians(25.0),
    crossing=radians(2.2957),
    shifts=(0.17, 0.2181),
)
MEETING = replace(TABLE1, offset=0.0, shaft_angle=radians(7.0), crossing=None, helix_angle=radians(15.0))
TABLE_1 = np.array([3.0, 0.8, -10.57])
"""Cone angles and the gear's helix angle, deg."""
REQUESTS = {
    "crossing": TABLE1,
    "left drive": replace(TABLE1, flank="left", crossing=radians(3.0)),
    "cones": replace(TABLE1, offset=None, crossing=None, cone_angles=(radians(3.0), radians(0.8))),
    "cones at an offset": replace(
        TABLE1, offset=231.0, crossing=None, helix_angle=None, cone_angles=(radians(3.0), radians(5.0))
    ),
    "least cones": replace(TABLE1, crossing=None, least_cones=True),
    "intersecting": MEETING,
    "intersecting cones": replace(MEETING, shifts=None, cone_angles=(radians(2.0), radians(5.0))),
    "gear held": replace(
        TABLE1,
        teeth=(24, 61),
        offset=180.0,
        shaft_angle=radians(7.0),
        crossing=None,
        helix_angle=None,
        shifts=None,
        gear=builtin_design("marine-gearbox").gear,
    ),
}
by_request = pytest.mark.parametrize("name", REQUESTS)


def found(request: Request, most: int = 8) -> list[Design]:
    """Return some of the pairs within the limits."""
    pairs = candidates_of(request)
    values = pairs[:, within(request, pairs)]
    return [design_of(request, values[:, k]) for k in range(0, values.shape[1], 1 + values.shape[1] // most)]


@by_request
def test_solutions_meet_the_request(name: str) -> None:
    request = REQUESTS[name]
    designs = found(request)
    assert designs
    for design in designs:
        closing = layout_deviation(design)
        assert abs(closing.offset_difference) < 1e-9
        assert abs(closing.shaft_angle_difference) < 1e-12
        assert closing.normal_backlash == pytest.approx(request.backlash, abs=1e-10)
        assert float(design.pair.shaft_angle) == request.shaft_angle
        assert request.offset in (None, design.pair.offset)
        if request.crossing is not None:
            angle = abs(float(generator_angle_as_mounted(design, request.flank)))
            assert angle == pytest.approx(request.crossing, abs=1e-9)


def test_given_quantities_are_kept() -> None:
    for design in found(TABLE1):
        assert float(design.pinion.helix_angle) == TABLE1.helix_angle
        assert tuple(member.profile_shift for member in design.members) == TABLE1.shifts
    for design in found(REQUESTS["gear held"]):
        assert design.gear == builtin_design("marine-gearbox").gear


@pytest.mark.slow
@pytest.mark.parametrize("name", ["crossing", "gear held"])
def test_lines_of_action_meet_at_60_digits(name: str) -> None:
    for design in found(REQUESTS[name], 2)[:2]:
        assert mounting_mp(design).gap < 1e-9


def like_table_1(request: Request) -> list[float]:
    """Return cone angles and helix angle of the gear of the pair that is nearest to Table 1, deg."""
    nearest = min(found(request), key=lambda design: abs(degrees(design.pinion.cone_angle) - 3.0))
    pinion, gear = nearest.members
    return [degrees(angle) for angle in (pinion.cone_angle, gear.cone_angle, gear.helix_angle)]


def test_table_1_is_recovered() -> None:
    """At 229 mm without backlash, the cone angles agree within 0.1 deg and the helix angle within 0.03 deg.

    The backlash of Table 1, 0.0416 mm, belongs to lines of action that pass each other; it changes the cones
    by 0.1 deg."""
    assert np.abs(like_table_1(replace(TABLE1, backlash=0.0)) - TABLE_1).max() < 0.1
    assert like_table_1(replace(TABLE1, backlash=0.0)) == pytest.approx([2.9854, 0.7686, -10.5528], abs=1e-4)
    assert like_table_1(TABLE1) == pytest.approx([2.8793, 0.8974, -10.5610], abs=1e-4)


def test_table_1_is_recovered_to_rounding() -> None:
    """At 229.0751 mm, with the backlash there, Table 1 is a solution.

    A change of the offset by 1 mm changes the cone of the pinion by 4.5 deg, a change of the backlash by 1 mm
    by 2.5 deg."""
    design = builtin_design()
    closed = replace(design, pair=Pair(layout_deviation(design).offset, design.pair.shaft_angle))
    crossing, closing = float(generator_angle_as_mounted(closed, "right")), layout_deviation(closed)
    request = replace(
        TABLE1, offset=float(closed.pair.offset), backlash=closing.normal_backlash, crossing=crossing
    )
    np.testing.assert_allclose(like_table_1(request), TABLE_1, rtol=0, atol=1e-9)


def test_several_requests_in_one_search() -> None:
    """Requests with different offsets, angles and backlash have the same solutions as in separate
    searches."""
    requests = [replace(TABLE1, offset=229.0 + k, shaft_angle=radians(15.0 - 0.2 * k)) for k in range(4)]
    pairs, owner = found_for_each(requests)
    for k, request in enumerate(requests):
        alone = candidates_of(request)
        both = [pairs[:, owner == k], alone]
        assert all(values.size for values in both)
        for column in both[0].T:
            assert np.abs(alone - column[:, None]).max(axis=0).min() < 1e-6


PARALLEL = replace(
    REQUESTS["cones"],
    shaft_angle=0.0,
    helix_angle=None,
    cone_angles=(radians(3.0), radians(-3.0)),
    shifts=None,
)


@pytest.mark.parametrize("offset", [None, 231.0])
def test_parallel_axes_in_closed_form(offset: float | None) -> None:
    """Cone and helix angles are opposite. Distance and backlash are those of cylindrical gears with the same
    shifts:

    inv(a_wt) = inv(a_t) + (2 (x_1 + x_2) m_n tan(a_n) + j_n/cos(a_n))/(m_t (N_1 + N_2))."""
    request = replace(PARALLEL, offset=offset, cone_angles=(0.0, 0.0))
    designs = found(request)
    assert designs
    for design in designs:
        pinion, gear = design.members
        assert (pinion.cone_angle, gear.helix_angle) == (-gear.cone_angle, -pinion.helix_angle)
        assert float(design.pair.shaft_angle) == 0.0
        normal, beta = request.pressure_angle, float(pinion.helix_angle)
        transverse = np.arctan(np.tan(normal) / np.cos(beta))
        reach = 0.5 * request.module * sum(request.teeth) / np.cos(beta)
        working = np.arccos(reach * np.cos(transverse) / float(design.pair.offset))
        thicker = 2.0 * request.module * (pinion.profile_shift + gear.profile_shift) * np.tan(normal)
        wide = (thicker + request.backlash / np.cos(normal)) / (2.0 * reach * np.cos(beta))
        difference = np.tan(working) - working - np.tan(transverse) + transverse
        assert difference == pytest.approx(wide, abs=1e-12)


def test_criteria_of_parallel_axes() -> None:
    pairs = candidates_of(PARALLEL)
    criteria = all_criteria(PARALLEL, pairs)
    for k in np.flatnonzero(criteria.possible)[:4]:
        design = design_of(PARALLEL, pairs[:, k])
        for j, flank in enumerate(("right", "left")):
            path = path_of_contact(design, flank, 3)
            assert criteria.normal_x[j, k] == pytest.approx(path.normal[1, 0], abs=1e-9)
            assert criteria.contact_ratio[j, k] == pytest.approx(float(path.ends.contact_ratio), abs=1e-9)
            assert criteria.crossing[j, k] == pytest.approx(0.0, abs=1e-12)


@by_request
def test_mirrored_request(name: str) -> None:
    """If both hands and the flanks of a request are exchanged, each pair is replaced by its mirror image."""
    request = REQUESTS[name]
    other = replace(
        request,
        flank={"right": "left", "left": "right"}[request.flank],
        helix_angle=None if request.helix_angle is None else -request.helix_angle,
        gear=None if request.gear is None else replace(request.gear, helix_angle=-request.gear.helix_angle),
    )
    image = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    images, own = candidates_of(other) * image[:, None], candidates_of(request)
    assert own.shape == images.shape
    for column in own.T:
        assert np.abs(images - column[:, None]).max(axis=0).min() < 1e-6


@by_request
def test_similarity_in_the_module(name: str) -> None:
    request = REQUESTS[name]
    assert request.gear is None or request.module == 6.0
    larger = replace(
        request,
        module=2.5 * request.module,
        face_widths=(2.5 * request.face_widths[0], 2.5 * request.face_widths[1]),
        backlash=2.5 * request.backlash,
        offset=request.offset and 2.5 * request.offset,
        gear=request.gear and scaled(builtin_design("marine-gearbox"), 2.5).gear,
    )
    np.testing.assert_allclose(candidates_of(larger), candidates_of(request), rtol=0, atol=1e-9)


def all_criteria(request: Request, values: FloatArray) -> PairCriteria:
    """Return the criteria of pairs in the layout of the request."""
    return criteria_of(request, values, tooth_criteria(request, values))


def test_criteria_of_a_batch_and_of_single_pairs() -> None:
    """A batch has the criteria of single pairs, with contact ratio and n_x of the path."""
    request = TABLE1
    pairs = candidates_of(request)
    criteria = all_criteria(request, pairs)
    for k in range(pairs.shape[1]):
        one = all_criteria(request, pairs[:, [k]])
        for name, values in vars(one).items():
            np.testing.assert_allclose(
                values[..., 0], getattr(criteria, name)[..., k], rtol=1e-9, err_msg=name
            )
