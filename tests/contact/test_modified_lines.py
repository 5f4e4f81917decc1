"""Modified flanks that touch along lines: spur and helical pairs on parallel axes with reliefs.

The path of contact connects the points of the lines that are nearest to mid-face."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import (
    Design,
    Errors,
    Limit,
    Status,
    contact_ratio,
    first_contact,
    mesh_cycle,
    path_of_contact,
    path_sensitivity,
)
from beveloid_geom.contact.parallel.lines import is_line_contact
from beveloid_geom.findings.path import path_remarks
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.sensitivity import sensitivity_report
from tests.contact.test_modified_path import modified
from tests.oracle.modified_flank import residuals
from tests.oracle.tooth import least_turn
from tests.stability.parallel_pairs import HELICAL, pair_of, parallel_pairs

SPUR = pair_of(2.0, (20, 35), 0.0, 55.1)
TIP = {"tip_relief_um": 10.0, "tip_relief_length_mm": 1.0}
HEEL = {"heel_relief_um": 10.0, "heel_relief_length_mm": 4.0}


@pytest.mark.parametrize(
    ("pinion", "gear"),
    [
        (TIP, None),
        (TIP, TIP),
        ({"profile_crowning_um": 5.0}, None),
        (HEEL, TIP),
        ({"profile_slope_um": 8.0}, TIP),
    ],
)
def test_spur_pairs_fulfil_the_five_equations(
    flank: str, pinion: dict[str, Any], gear: dict[str, Any] | None
) -> None:
    """The five equations are those of independent code; contact is at mid-face and ends at both tips."""
    design = modified(SPUR, pinion, gear)
    path = path_of_contact(design, flank, 41)
    assert path.ends.status == Status.SOLVED
    apart, turned = residuals(design, path, np.asarray(mounting_of(design).distance))
    assert apart < 1e-10
    assert turned < 1e-12
    assert np.abs(path.pinion_z).max() < 1e-6
    ends = {path.ends.enter, path.ends.leave}
    assert ends == {Limit.GEAR_TIP, Limit.PINION_TIP}
    assert is_line_contact(design, flank)


def test_unmodified_part_of_a_spur_pair_has_the_unmodified_path(flank: str) -> None:
    """Where neither flank is relieved, the contacts are those of the unmodified pair. With relief the contact
    reaches the tip of the pinion later, so that the contact ratio is larger."""
    design, plain = modified(SPUR, TIP), path_of_contact(SPUR, flank, 41)
    low = plain.l1[plain.l1 < plain.l1.max() - 1.05]
    path = path_of_contact(design, flank, l1=low)
    for name in ("pinion_roll", "gear_roll", "l2"):
        np.testing.assert_allclose(
            getattr(path, name), getattr(plain, name)[: low.size], atol=1e-9, rtol=0.0, err_msg=name
        )
    assert contact_ratio(design, flank) > contact_ratio(SPUR, flank)


def test_operation_of_a_spur_pair_with_tip_relief(flank: str) -> None:
    """The unrelieved parts of both flanks cover one pitch: no transmission error and no edge contact."""
    cycle = mesh_cycle(modified(SPUR, {**TIP, "tip_relief_length_mm": 0.5}), flank)
    assert not cycle.lost
    assert cycle.edge_share == 0.0
    assert cycle.peak_to_peak < 1e-8


RELIEVED = {
    "the path turns by 87 deg": (
        pair_of(1.676, (33, 55), 3.04, 73.59, (-0.0866, -0.1007), (5.704, 11.31)),
        {},
        {"tip_relief_um": 17.04, "tip_relief_length_mm": 1.597},
    ),
    "Newton's steps go back and forth": (
        pair_of(7.319, (45, 113), -30.96, 673.0, (-0.148, -0.077), (108.8, 80.67)),
        {"root_relief_um": 3.55, "root_relief_length_mm": 2.66},
        {"root_relief_um": 11.6, "root_relief_length_mm": 1.4, "toe_relief_um": 16.2}
        | {"toe_relief_length_mm": 15.1, "tip_relief_um": 3.35, "tip_relief_length_mm": 1.75},
    ),
    "tip reliefs of both members overlap": (
        pair_of(3.399, (37, 61), 13.27, 173.2, (0.375, 0.221), (35.19, 46.76)),
        {"tip_relief_um": 11.7, "tip_relief_length_mm": 3.08},
        {"tip_relief_um": 3.16, "tip_relief_length_mm": 1.81, "toe_relief_um": 14.7}
        | {"toe_relief_length_mm": 6.27, "heel_relief_um": 14.0, "heel_relief_length_mm": 7.35},
    ),
    "little is left between the reliefs": (
        pair_of(2.432, (41, 54), -18.55, 122.3, (0.1, 0.1), (30.87, 18.33)),
        {"tip_relief_um": 18.4, "tip_relief_length_mm": 1.19, "root_relief_um": 6.6}
        | {"root_relief_length_mm": 1.38, "toe_relief_um": 8.65, "toe_relief_length_mm": 4.99},
        {"heel_relief_um": 17.3, "heel_relief_length_mm": 4.83}
        | {"toe_relief_um": 19.6, "toe_relief_length_mm": 4.95},
    ),
    "nearly spur teeth, 0.2 deg": (pair_of(2.0, (20, 35), 0.2, 55.1), TIP, TIP),
    "nearly spur teeth, 0.05 deg": (pair_of(2.0, (20, 35), 0.05, 55.1), TIP | HEEL, TIP),
    "nearly spur teeth, 0.001 deg": (pair_of(2.0, (20, 35), -0.001, 55.1), TIP, HEEL),
    "reliefs of pinion and gear begin next to each other, 17 teeth": (
        pair_of(4.342, (17, 88), 24.51, 252.2, (-0.02339, 0.3834), (56.9, 52.13)),
        {"tip_relief_um": 12.86, "tip_relief_length_mm": 4.124, "root_relief_um": 13.6}
        | {"root_relief_length_mm": 1.332, "heel_relief_um": 9.378, "heel_relief_length_mm": 7.086},
        {"tip_relief_um": 11.75, "tip_relief_length_mm": 3.492, "root_relief_um": 3.182}
        | {"root_relief_length_mm": 2.54, "toe_relief_um": 10.37, "toe_relief_length_mm": 7.259},
    ),
    "reliefs of pinion and gear begin next to each other, 32 teeth": (
        pair_of(2.663, (32, 81), 12.31, 154.7, (-0.0641, 0.3025), (18.48, 19.27)),
        {"tip_relief_um": 3.665, "tip_relief_length_mm": 2.232, "root_relief_um": 16.69}
        | {"root_relief_length_mm": 1.552},
        {"tip_relief_um": 18.2, "tip_relief_length_mm": 2.473, "root_relief_um": 14.77}
        | {"root_relief_length_mm": 1.555, "toe_relief_um": 14.09, "toe_relief_length_mm": 5.138},
    ),
    "reliefs of pinion and gear begin next to each other, 22 teeth": (
        pair_of(1.689, (22, 53), 27.01, 71.81, (0.03238, 0.3893), (23.47, 23.53)),
        {"tip_relief_um": 15.53, "tip_relief_length_mm": 1.361, "root_relief_um": 17.42}
        | {"root_relief_length_mm": 0.5899, "heel_relief_um": 7.023, "heel_relief_length_mm": 3.327}
        | {"toe_relief_um": 4.9, "toe_relief_length_mm": 1.847},
        {"tip_relief_um": 4.843, "tip_relief_length_mm": 1.606, "root_relief_um": 16.05}
        | {"root_relief_length_mm": 0.7567, "heel_relief_um": 12.15, "heel_relief_length_mm": 2.137},
    ),
    "Newton's steps go back and forth at single positions": (
        pair_of(1.508, (43, 50), 30.303, 82.359, (0.37075, 0.38974), (14.598, 16.006)),
        {"root_relief_um": 5.2689, "root_relief_length_mm": 0.48868, "heel_relief_um": 8.9109}
        | {"heel_relief_length_mm": 2.4285, "toe_relief_um": 8.4185, "toe_relief_length_mm": 2.0652},
        {"tip_relief_um": 16.496, "tip_relief_length_mm": 0.76607, "root_relief_um": 14.984}
        | {"root_relief_length_mm": 0.4389, "toe_relief_um": 6.4136, "toe_relief_length_mm": 1.7156},
    ),
    "the last position is rounded beyond the end": (
        pair_of(4.6772, (28, 28), 26.549, 148.44, (0.34335, 0.082781), (43.655, 41.113)),
        {"root_relief_um": 9.7709, "root_relief_length_mm": 1.1955, "heel_relief_um": 3.8203}
        | {"heel_relief_length_mm": 6.5515, "toe_relief_um": 10.609, "toe_relief_length_mm": 5.6308},
        {"root_relief_um": 19.683, "root_relief_length_mm": 0.95471, "heel_relief_um": 7.7914}
        | {"heel_relief_length_mm": 7.7378, "toe_relief_um": 14.825, "toe_relief_length_mm": 5.3384},
    ),
}
"""Helical pairs by their difficulty, with modifications of pinion and gear."""


@pytest.mark.parametrize(("pair", "pinion", "gear"), RELIEVED.values(), ids=RELIEVED.keys())
def test_paths_of_relieved_helical_pairs(
    flank: str, pair: Design, pinion: dict[str, Any], gear: dict[str, Any]
) -> None:
    """Every position of the path is known and fulfils the five equations of independent code, up to the
    additional crowning of the pinion."""
    design = modified(pair, pinion, gear)
    path = path_of_contact(design, flank, 101)
    assert path.ends.status == Status.SOLVED
    assert (path.status == Status.SOLVED).all()
    apart, turned = residuals(design, path, np.asarray(mounting_of(design).distance))
    assert apart < 2e-7
    assert turned < 2e-8
    # The first contacts of this pair of teeth at the same rolls are on the path.
    first = first_contact(design, flank, path.pinion_roll, pairs=[0])
    np.testing.assert_allclose(first.gear_roll, path.gear_roll, atol=1e-12, rtol=0.0)


def test_relieved_helical_pairs_have_the_limit_of_small_crownings(flank: str) -> None:
    """Crownings of 10, 5 and 2.5 nm, extrapolated, give the contact ratio of line contact."""
    design = modified(HELICAL, TIP)
    ratios = [
        float(contact_ratio(modified(HELICAL, {**TIP, "helix_crowning_um": amount}), flank))
        for amount in (0.01, 0.005, 0.0025)
    ]
    steps = np.diff(ratios)
    limit = ratios[-1] + steps[1] / (steps[0] / steps[1] - 1.0)
    assert contact_ratio(design, flank) == pytest.approx(limit, abs=2e-6)


@pytest.mark.parametrize(
    ("design", "lines"),
    [
        (modified(SPUR, {"helix_crowning_um": 5.0}), False),
        (modified(SPUR, {"twist_um": 5.0}), False),
        (modified(HELICAL, {"profile_crowning_um": 5.0}), False),
        (modified(HELICAL, TIP), True),
        (modified(replace(SPUR, errors=Errors(shaft_angle=1e-4)), TIP), False),
        (SPUR, True),
    ],
)
def test_which_flanks_touch_along_lines(design: Design, lines: bool) -> None:
    assert bool(is_line_contact(design)) == lines


@pytest.mark.parametrize("width", [0.3, 0.03, 0.001, -0.01, -0.1])
def test_tip_reliefs_that_leave_a_narrow_strip(width: float, flank: str) -> None:
    """Tip reliefs of both members leave a strip of this width (mm along l) without relief, or overlap by it.
    The flanks touch along lines if there is a strip, and nothing touches earlier."""
    free, tips = (
        path_of_contact(HELICAL, flank, 1001),
        [tip_parameter(m, flank, 0.0) for m in HELICAL.members],
    )
    order = free.l2.argsort()

    def strip(length: float) -> float:
        """Return the width between the beginnings of both reliefs."""
        return float(tips[0] - length - np.interp(tips[1] - length, free.l2[order], free.l1[order]))

    length = brentq(lambda length: strip(length) - width, 1.0, 3.5)
    relief = {"tip_relief_um": 10.0, "tip_relief_length_mm": length}
    design = modified(HELICAL, relief, relief)
    assert bool(is_line_contact(design, flank)) == (width > 0.0)
    assert (path_of_contact(design, flank, 41).status == Status.SOLVED).all()
    cycle = mesh_cycle(design, flank)
    assert not cycle.lost
    rolls = float(cycle.start) + cycle.pitch * np.array((0.1, 0.45, 0.8))
    first, lever = first_contact(design, flank, rolls), cycle.engagement.lever
    assert np.abs(first.gear_roll - cycle.at(rolls).gear_roll).max() * lever < 1e-9
    pitch = [2.0 * np.pi / float(member.teeth) for member in design.members]
    for roll, gear_roll, pair in zip(rolls, first.gear_roll, first.pair, strict=True):
        turned = float(roll + pair * pitch[0]), float(gear_roll - pair * pitch[1])
        # The clearance by independent code is zero up to the crowning for flanks that touch along lines.
        assert abs(least_turn(design, flank, turned, (65, 33))) * lever < 1e-8 * 3.0


def test_helix_slope_leaves_contact_at_an_edge_only() -> None:
    path = path_of_contact(modified(SPUR, {"helix_slope_um": 5.0}))
    assert path.ends.status == Status.OFF_FLANK


def test_line_contact_is_reported_and_has_no_derivatives() -> None:
    design = modified(SPUR, TIP)
    found = path_sensitivity(design)
    assert np.isnan(found.face_shift_by).all()
    texts = [remark.text for remark in path_remarks(path_of_contact(design))]
    assert any("line contact" in text and "mid-face" in text for text in texts)
    assert not any("rounding" in text for text in texts)


@pytest.mark.slow
def test_relieved_parallel_pairs_have_a_path_and_a_mesh_cycle() -> None:
    """Random spur and helical pairs with reliefs of both members."""
    rng, counts = np.random.default_rng(3), {"spur": [0, 0, 0], "helical": [0, 0, 0]}
    for design in parallel_pairs(40, 21):
        module, amounts = float(design.pinion.tool.normal_module), []
        for member in design.members:
            face, made = float(member.face_width), dict[str, Any]()
            for name, reach in (("tip", 0.5 * module), ("root", 0.3 * module), ("heel", 0.2 * face)):
                made[f"{name}_relief_um"] = float(rng.uniform(2.0, 20.0))
                made[f"{name}_relief_length_mm"] = float(reach * rng.uniform(0.2, 1.0))
            amounts.append(made)
        try:
            relieved = modified(design, *amounts)
        except ValueError:  # a relief is longer than the flank
            continue
        count = counts["spur" if design.pinion.helix_angle == 0.0 else "helical"]
        count[0] += 1
        count[1] += path_of_contact(relieved, points=5).ends.status == Status.SOLVED
        count[2] += not mesh_cycle(relieved).lost
    assert counts["spur"][0] == counts["spur"][1] == counts["spur"][2] > 5
    number, paths, cycles = counts["helical"]
    assert paths == cycles == number > 10


def test_first_contact_of_a_spur_pair_is_at_mid_face() -> None:
    first = first_contact(modified(SPUR, TIP), pinion_roll=np.linspace(-0.05, 0.05, 5))
    assert np.abs(first.z1).max() < 0.5


def test_an_unknown_transmission_error_of_a_sensitivity_is_printed_in_words() -> None:
    """On these cones with twist and reliefs, the roll turns back along the path."""
    design = pair_of(1.0, (12, 56), 0.0, 34.794, (0.5, 0.3), (10.0, 10.0), cone_deg=-1.87)
    pinion = {"profile_crowning_um": -8.35, "twist_um": -10.67, **TIP, "tip_relief_length_mm": 0.394}
    pinion |= {"tip_relief_um": 14.9, "heel_relief_um": 22.0, "heel_relief_length_mm": 0.328}
    tool = design.pinion.tool.with_parabola(0.001166)
    bent = replace(design, pinion=replace(design.pinion, tool=tool))
    text = sensitivity_report("x", modified(bent, pinion, {"helix_slope_um": -10.11}), "right").summary()
    assert "transmission error not known" in text
    assert "nan" not in text


def test_mesh_cycle_in_which_no_tooth_pair_is_later_than_the_first() -> None:
    *_, design = parallel_pairs(4, 21)
    pinion = {"tip_relief_um": 17.7, "tip_relief_length_mm": 2.8, "heel_relief_um": 13.0}
    pinion |= {"heel_relief_length_mm": 3.62, "toe_relief_um": 15.4, "toe_relief_length_mm": 8.12}
    gear = {"root_relief_um": 17.3, "root_relief_length_mm": 1.34}
    assert not mesh_cycle(modified(design, pinion, gear), "left").lost
