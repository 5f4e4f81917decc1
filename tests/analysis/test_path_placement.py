"""Two errors that place a path: contact of the result, mirror image, scaling, grids, and backlash."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Modification,
    mounted_backlash,
    path_of_contact,
)
from beveloid_geom.analysis.path_placement import Placement, centred, place_path, search_limits
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.status import PlaceStatus
from tests.oracle.table1 import table1
from tests.symmetry import OTHER, mirrored, scaled

MODIFIED = (0.001, -0.001)


def middle_of(design: Design, flank: str) -> tuple[float, float]:
    """Return z and l1 at mid-roll by interpolation along a dense path."""
    path = path_of_contact(design, flank, 4001)
    roll = 0.5 * (path.ends.pinion_roll[0] + path.ends.pinion_roll[1])
    order = np.argsort(path.pinion_roll)
    z, l = (np.interp(roll, path.pinion_roll[order], row[order]) for row in (path.pinion_z, path.l1))
    return float(z), float(l)


def under(design: Design, found: Placement, k: int) -> Design:
    own = design.errors
    return design.with_errors(
        replace(own, **{name: getattr(own, name) + found.errors[k, j] for j, name in enumerate(found.by)})
    )


CROWNED = replace(table1(), pinion=table1().pinion.modified(Modification(helix_crowning_um=10.0)))


@pytest.mark.parametrize(
    ("pair", "flank"), [(table1(), "right"), (table1(MODIFIED), "left"), (CROWNED, "right")]
)
@pytest.mark.parametrize("by", [("offset", "shaft_angle"), ("pinion_axial", "gear_axial")])
def test_the_result_has_its_middle_at_the_required_position(
    pair: Design, flank: str, by: tuple[str, str]
) -> None:
    design = pair.with_errors(Errors(offset=0.05))
    found = place_path(design, (0.5, 0.52), by, flank)
    assert found.status.tolist() == 2 * [PlaceStatus.REACHED]
    assert found.wanted_l == centred(pair, flank)
    for k, share in enumerate((0.5, 0.52)):
        mounting = under(design, found, k)
        z, l = middle_of(mounting, flank)
        assert (z, l) == pytest.approx((50.0 * (share - 0.5), found.wanted_l), abs=1e-6)
        assert found.normal_backlash[k] == pytest.approx(float(mounted_backlash(mounting).normal), abs=1e-9)
        assert found.contact_ratio[k] == pytest.approx(
            float(path_of_contact(mounting, flank, 2).ends.contact_ratio), rel=1e-9
        )
        assert not found.jammed[k]


@pytest.mark.slow
def test_a_quarter_and_three_quarters_of_the_face_by_shaft_angle_and_offset() -> None:
    """Errors place the path at 25 and 75 % of the face. The right flanks of Table 1 have approximate line
    contact and need some thousandths of a degree of shaft angle, the left flanks three tenths."""
    right, left = (place_path(table1(), (0.25, 0.75), flank=flank) for flank in ("right", "left"))
    for found in (right, left):
        np.testing.assert_allclose(found.z, (-12.5, 12.5), rtol=0.0, atol=1e-6)
    assert np.abs(np.degrees(right.exact[:, 1])).max() < 0.01
    assert np.abs(np.degrees(left.exact[:, 1])).min() > 0.25
    assert right.status.tolist() == [PlaceStatus.OFF_CENTRE, PlaceStatus.REACHED]


def off_of(found: Placement) -> float:
    return float(found.l[0] - found.wanted_l)


@pytest.mark.slow
def test_a_jammed_pair_is_placed_as_close_to_the_centre_as_possible(flank: str) -> None:
    design = table1(MODIFIED)
    found = place_path(design, (0.25,), flank=flank)
    assert found.status[0] == PlaceStatus.OFF_CENTRE
    centre = mounted(design, found.exact[0], found.by)
    assert float(mounted_backlash(centre).normal) < -0.01
    assert middle_of(centre, flank) == pytest.approx((-12.5, found.wanted_l), abs=1e-6)
    assert not mounted_backlash(under(design, found, 0)).jammed
    assert middle_of(under(design, found, 0), flank) == pytest.approx((-12.5, found.l[0]), abs=1e-6)
    for share, status in ((0.95, PlaceStatus.OFF_CENTRE), (1.05, PlaceStatus.REACHED)):
        beside = place_path(design, (0.25,), flank=flank, l=found.wanted_l + share * off_of(found))
        assert beside.status[0] == status


def test_a_second_newton_starts_from_a_grid() -> None:
    """The search that starts from a grid finds the axial positions. A grid of 401 x 401 axial positions,
    refined four times, gave 12.199 and 27.201 mm."""
    found = place_path(table1(), (0.25,), ("pinion_axial", "gear_axial"))
    assert found.status[0] == PlaceStatus.REACHED
    np.testing.assert_allclose(found.errors[0], (12.1991, 27.2011), atol=1e-3)


def test_results_without_convergence_are_nan() -> None:
    """A position that is not reached has the status NOT_CONVERGED, and all its values are NaN. Grids of 301 x
    301 axial positions within the limits, and of 201 x 201 around the best one, do not reach it either."""
    found = place_path(table1(MODIFIED), (0.25, 0.5), ("pinion_axial", "gear_axial"))
    assert found.status.tolist() == [PlaceStatus.NOT_CONVERGED, PlaceStatus.REACHED]
    for name in ("errors", "exact", "z", "l", "distance", "contact_ratio", "normal_backlash"):
        assert np.isnan(getattr(found, name)[0]).all()
        assert np.isfinite(getattr(found, name)[1]).all()


def test_it_is_centred_where_the_path_runs_from_tip_to_tip() -> None:
    for flank in ("right", "left"):
        assert centred(table1(), flank) == pytest.approx(middle_of(table1(), flank)[1], abs=1e-6)
    assert centred(table1((0.0, -0.0005)), "right") == 0.0  # from heel to toe


def test_limits_scale_with_the_pair() -> None:
    names = ("offset", "shaft_angle"), ("pinion_axial", "gear_axial")
    np.testing.assert_allclose(search_limits(table1(), names[0]), (6.0, np.radians(5.0)))
    np.testing.assert_allclose(search_limits(scaled(table1(), 0.5), names[1]), (25.0, 25.0))


def test_a_pair_without_contact_has_no_path() -> None:
    design = table1(errors=Errors(offset=60.0))
    found = place_path(design, (0.5,))
    assert found.status[0] == PlaceStatus.NO_PATH
    assert np.isnan(found.errors).all()


def test_a_position_is_reached_from_a_design_without_a_path() -> None:
    """A shaft-angle error of 0.1 deg moves the path of Table 1 off the flanks. The search that starts from a
    grid finds a mounting with the path at mid-face, and none with the path at 98 % of the face."""
    design = table1(errors=Errors(shaft_angle=np.radians(0.1)))
    found = place_path(design, (0.5, 0.98))
    assert found.status.tolist() == [PlaceStatus.REACHED, PlaceStatus.NOT_CONVERGED]
    assert middle_of(under(design, found, 0), "right") == pytest.approx((0.0, found.wanted_l), abs=1e-6)
    assert np.isnan(found.errors[1]).all()


def test_a_pair_that_jams_at_all_trial_positions_has_no_values() -> None:
    found = place_path(table1(), (0.05,), flank="left")
    assert found.status[0] == PlaceStatus.JAMMED
    assert np.isfinite(found.exact).all()
    assert mounted_backlash(mounted(table1(), found.exact[0], found.by)).jammed
    assert np.isnan(found.errors).all()
    assert np.isnan(found.z).all()
    assert found.jammed[0]


def test_the_position_along_the_face_is_kept_if_the_pair_jams() -> None:
    """The offset error of -0.255 mm that centres the path of the right flanks jams the pair. The result keeps
    the position along the face and has a backlash of nearly zero."""
    found = place_path(table1(), (0.25,))
    assert found.status[0] == PlaceStatus.OFF_CENTRE
    assert found.exact[0, 0] == pytest.approx(-0.2547, abs=1e-3)
    assert found.z[0] == pytest.approx(-12.5, abs=1e-6)
    assert -2e-4 < found.normal_backlash[0] < 2e-3
    assert not found.jammed[0]


def test_mirrored_pairs_have_equal_errors(flank: str) -> None:
    one, two = (
        place_path(design, (0.51, 0.53), ("offset", "shaft_angle"), side)
        for design, side in ((table1(MODIFIED), flank), (mirrored(table1(MODIFIED)), OTHER[flank]))
    )
    np.testing.assert_allclose(two.exact, one.exact, rtol=1e-6, atol=1e-9)
    assert two.wanted_l == pytest.approx(one.wanted_l, abs=1e-9)


def test_lengths_of_a_pair_half_as_large() -> None:
    design = table1(MODIFIED)
    one, two = (place_path(each, (0.5, 0.7)) for each in (design, scaled(design, 0.5)))
    np.testing.assert_allclose(two.errors, one.errors * (0.5, 1.0), rtol=1e-6)
    np.testing.assert_allclose(two.z, 0.5 * one.z, rtol=0.0, atol=1e-6)
