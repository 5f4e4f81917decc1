"""Parabola coefficients near 0, and so large that the rack profile folds."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import Status, contact_ratio, first_contact, gear_solid, path_of_contact, sample_flank
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.design.limits import parabola_limit
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.gear.flank import flank_point, tip_thickness
from beveloid_geom.gear.flank_limits import active_range, highest_parameter, root_parameter
from beveloid_geom.gear.rack import rack_normal, rack_of, section_point
from beveloid_geom.gear.undercut import undercut_of
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.oracle.table1 import table1

from .answers import FLANKS, assert_no_path, changed, check, checked_path, solved_path

SHARES = {"both": (1.0, -1.0), "pinion": (1.0, 0.0), "gear": (0.0, 1.0), "same": (1.0, 1.0)}
shares = pytest.mark.parametrize("share", SHARES.values(), ids=SHARES)
STRONG = [0.0285, -0.0285, 0.05, -0.05, 0.2, -0.2, 10.0, -10.0, 1e6, 1e200, -1e200]
"""1/mm: coefficients that the tool of Table 1's pinion cannot generate."""


@shares
def test_transmission_error_and_shift_are_proportional_near_zero(
    share: tuple[float, float], flank: str
) -> None:
    """The ratios to the coefficient are equal from 1e-10 to 1e-6 1/mm and for both signs."""
    zero = solved_path(table1(), flank)

    def per_coefficient(a: float) -> tuple[FloatArray, FloatArray]:
        path = solved_path(table1((share[0] * a, share[1] * a)), flank)
        return path.transmission_error / a, (path.point - zero.point) / a

    error, shift = per_coefficient(1e-7)
    assert np.abs(error).max() > 1e-3
    assert np.abs(shift).max() > 500.0
    for a in (1e-6, -1e-6, -1e-7, 1e-8, -1e-8, 1e-9, -1e-9, 1e-10, -1e-10):
        rounding = 2e-14 / abs(a)
        found, moved = per_coefficient(a)
        assert np.abs(found - error).max() < 3e-3 * np.abs(error).max() + rounding
        assert np.abs(moved - shift).max() < 3e-3 * np.abs(shift).max() + 1e3 * rounding


def test_the_active_flank_is_the_part_that_the_tool_can_cut() -> None:
    """`active_range` compared with the rack: profile and normals are sampled between the heights."""
    steep = changed(table1().pinion, cone_angle=radians(20.0), helix_angle=radians(40.0))
    for member in (*table1().members, steep):
        for a in np.linspace(-0.12, 0.12, 49):
            bent = changed(member, parabola=float(a))
            heights = np.array([-1.0, np.cos(member.cone_angle)]) * 6.0
            l = np.linspace(-9.0, 9.0, 6001)
            x = section_point(bent.tool, "right", l)[:, 0]
            middle = l.size // 2
            rise = np.diff(x) > 0.0
            last = middle + int(np.argmin(rise[middle:])) if not rise[middle:].all() else l.size - 1
            first = middle - int(np.argmin(rise[:middle][::-1])) if not rise[:middle].all() else 0
            reaches = bool(x[first] <= heights[0] and x[last] >= heights[1])
            used = l[first : last + 1][
                (x[first : last + 1] >= heights[0]) & (x[first : last + 1] <= heights[1])
            ]
            radial = min(float(rack_normal(rack_of(bent, flank), used)[0].min()) for flank in FLANKS)
            if abs(radial) > 2e-3:  # otherwise the result depends on the sampling
                assert np.isfinite(active_range(bent, "right")).all() == (reaches and radial > 0.0)


@pytest.mark.parametrize("a", STRONG)
@pytest.mark.parametrize("gear", [0.0, 0.001])
def test_a_flank_that_cannot_be_cut_has_no_values(a: float, gear: float) -> None:
    design = table1((a, gear))
    assert not abs(a) <= parabola_limit(design.pinion)
    for flank in FLANKS:
        assert_no_path(design, flank, Status.UNDEFINED)
        assert np.isnan(path_of_contact(design, flank, l1=[-1.0, 0.0, 1.0]).point).all()
    member = design.pinion
    assert np.isnan([root_parameter(member, "right"), highest_parameter(member, "right")]).all()
    assert np.isnan(tip_thickness(member, np.zeros(3))).all()


@pytest.mark.parametrize("a", STRONG)
def test_a_flank_that_cannot_be_cut_is_rejected_by_all_functions(a: float) -> None:
    design, line = table1((a, 0.0)), "cannot be cut: "
    member = design.pinion
    for refused in (
        lambda: gear_solid(member, 0.1),
        lambda: undercut_of(member, "right"),
        lambda: sample_flank(member, "right", 0.01),
        lambda: mesh_contact(design, "right", 0.01, pinion_roll=0.0, gear_roll=0.0),
    ):
        with pytest.raises(ValueError, match=f"^the flanks {line}parabola must be between .*$"):
            refused()
    assert path_of_contact_five_equations(design, "right", 5).ends.status == Status.UNDEFINED
    if a == -0.0285:  # the section of the tool is valid, but not its normal after the tilt by the cone angle
        assert np.isnan(first_contact(design, "right", np.zeros(2)).gear_roll).all()
    else:
        with pytest.raises(ValueError, match=r"leaves no space for the tool's tip round|rounds overlap"):
            first_contact(design, "right", np.zeros(1))
    with pytest.raises(ValueError, match="no path of contact"):
        meshing_pair(design)
    texts = [remark.text for remark in remarks_on(design) if line in remark.text]
    assert len(texts) == 1
    assert texts[0].startswith(f"the flanks of the pinion {line}")
    assert "parabola must be between -0.0212 and 0.0212 1/mm" in texts[0]


def test_strong_coefficients_in_a_batch_do_not_affect_other_cases() -> None:
    strong = np.array([0.001, *STRONG, -0.001, 0.0])
    design = table1().with_parabola(strong, 0.0)
    batch = path_of_contact(design, points=11)
    check(design, batch)
    lost = np.isnan(batch.ends.contact_ratio)
    np.testing.assert_array_equal(lost, [abs(a) != 0.001 and a != 0.0 for a in strong])
    np.testing.assert_array_equal(np.isnan(batch.point).all(axis=(1, 2)), lost)
    for case in np.flatnonzero(~lost):
        single = contact_ratio(table1((float(strong[case]), 0.0)))
        assert batch.ends.contact_ratio[case] == pytest.approx(single, abs=1e-12)


@pytest.mark.parametrize("a", [0.0211, -0.0211, 0.028, -0.028])
def test_results_just_before_the_fold_are_correct(a: float, flank: str) -> None:
    """Beyond the limit of design files a flank may still be cut: its contacts are then correct."""
    design = table1((a, 0.0))
    path = checked_path(design, flank)
    assert np.isfinite(active_range(design.pinion, flank)).all()
    assert (path.status == Status.SOLVED).all()


def test_a_cone_too_steep_for_the_tool_has_no_values() -> None:
    steep = changed(table1().pinion, cone_angle=radians(40.0), helix_angle=radians(60.0), face_width=10.0)
    design = replace(table1(), pinion=steep)
    for flank in FLANKS:
        assert_no_path(design, flank, Status.UNDEFINED)
    for refused in (
        lambda: undercut_of(steep, "left"),
        lambda: sample_flank(steep, "right", 0.1),
        lambda: gear_solid(steep, 0.1),
    ):
        with pytest.raises(ValueError, match=r"cannot be cut: cone_angle_deg must be between -21\.6825 and"):
            refused()
    point = flank_point(steep, "right", 0.0, 0.0)
    assert np.isfinite(point).all()
