"""Values of the sliders: design, refusals, command line, errors at both places."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, DesignError, MeshErrors, Modification, builtin_design, from_degrees
from beveloid_geom.pair.misalignment_at_mesh import from_mesh
from beveloid_viz.explore.values import Start, ViewSettings
from tests.cli.running import json_of

RELIEF = "pinion.right.tip_relief_um"
CHANGES: dict[str, Any] = {
    "offset_error": 0.04,
    "shaft_angle_error_deg": -0.003,
    "pinion.right.parabola": 0.0007,
    "pinion.left.parabola": -0.0002,
    "gear.right.helix_crowning_um": 6.0,
    "gear.left.tip_relief_um": 12.0,
    "gear.left.tip_relief_length_mm": 2.0,
}


def test_no_change_is_the_start_to_the_last_bit(modified: Design) -> None:
    start = Start(modified)
    assert start.read({}) == (modified, ViewSettings())
    assert start.read(start.values)[0] == modified
    assert start.changes(start.values) == {}


def test_values_are_those_of_the_inputs_of_the_library(modified: Design) -> None:
    design, _ = Start(modified).read(CHANGES)
    assert design.errors.offset == 0.04
    assert design.errors.shaft_angle == pytest.approx(np.radians(-0.003), rel=1e-15)
    assert [design.pinion.tool.parabola_of(flank) for flank in ("right", "left")] == [0.0007, -0.0002]
    assert design.gear.tool == modified.gear.tool
    assert design.gear.modification_right == Modification(helix_crowning_um=6.0)
    assert design.gear.modification_left == Modification(tip_relief_um=12.0, tip_relief_length_mm=2.0)
    assert design.pinion.modifications == ()


def test_start_with_modification_can_be_taken_back() -> None:
    plain = builtin_design()
    crowned = replace(plain, pinion=plain.pinion.modified(Modification(helix_crowning_um=8.0), "right"))
    start = Start(crowned)
    assert start.values["pinion.right.helix_crowning_um"] == 8.0
    assert start.read({"pinion.right.helix_crowning_um": 0.0})[0] == plain


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("offset_error", 1e4, "must be between"),
        ("offset_error", float("nan"), "must be a finite number"),
        ("offset_error", "0,05", "must be a finite number"),
        ("offset_error", True, "must be a finite number"),
        ("offset_error", 10**400, "must be a finite number"),
        ("shaft_angle_error_deg", 50.0, "must be between"),
        ("pinion.right.parabola", 1.0, "must be between"),
        ("pinion.left.helix_crowning_um", 1e9, "must be between -100000 and 100000 um"),
        ("pinion.left.helix_crowning_um", 99000.0, "must be between -9425 and 9425 um"),
        ("film", -0.1, "must be between 0 and 10 mm"),
        ("torque", 1e13, "must be between 0 and 1e+12 Nm"),
        ("flank", "upper", "must be right or left"),
        ("errors_at", None, "must be perpendicular or mesh"),
        ("cone_angle", 0.0, "is not a control of this pair"),
    ],
)
def test_refused_values_name_the_control_and_the_limit(name: str, value: Any, words: str) -> None:
    with pytest.raises(DesignError) as refusal:
        Start(builtin_design()).read({name: value})
    (fault,) = refusal.value.parts
    assert fault.key == name
    assert words in fault.text


@pytest.mark.parametrize("length", [0.0, -1.0, 90.0])
def test_a_relief_with_a_wrong_length_is_refused(length: float, flank: str) -> None:
    """If both flanks have the same values, the control of the driving flanks is named."""
    start, name = Start(builtin_design()), RELIEF.replace("_um", "_length_mm")
    refused = RELIEF if length == 0.0 else name
    one = {RELIEF: 5.0, name: length}
    both = one | {key.replace("right", "left"): value for key, value in one.items()}
    for values, of in ((one, "right"), ({**both, "flank": flank}, flank)):
        with pytest.raises(DesignError) as refusal:
            start.read(values)
        (fault,) = refusal.value.parts
        assert fault.key == refused.replace("right", of)
        assert fault.text.startswith("needs tip_relief_length_mm" if length == 0.0 else "must be")


def test_a_new_relief_has_a_length() -> None:
    design, _ = Start(builtin_design()).read({RELIEF: 5.0})
    assert design.pinion.modification_right == Modification(tip_relief_um=5.0, tip_relief_length_mm=6.0)


def test_errors_at_the_mesh(modified: Design) -> None:
    start = Start(modified)
    design, _ = start.read({"errors_at": "mesh", "centre_distance": 0.03, "out_of_plane_deg": 0.004})
    expected = from_mesh(modified, from_degrees(MeshErrors, centre_distance=0.03, out_of_plane_deg=0.004))
    assert design.errors == expected
    with pytest.raises(DesignError, match="in_plane_deg must be between -5 and 5 deg"):
        start.read({"errors_at": "mesh", "in_plane_deg": -20.0})


@pytest.mark.parametrize("others", [{}, {"in_plane_deg": 0.01}, {"centre_distance": 0.1, "gear_axial": -0.2}])
@pytest.mark.parametrize("tilt", [1e-4, -0.02, 0.05])
def test_a_tilt_of_parallel_axes_is_refused_by_its_name(tilt: float, others: dict[str, float]) -> None:
    start = Start(builtin_design("anti-backlash"))
    with pytest.raises(DesignError) as refusal:
        start.read({"errors_at": "mesh", "out_of_plane_deg": tilt, **others})
    (fault,) = refusal.value.parts
    assert fault.key == "out_of_plane_deg"
    assert fault.key in start.controls
    assert "makes parallel axes intersect or cross far away from the gears" in fault.text
    start.read({"errors_at": "mesh", "out_of_plane_deg": 0.0, **others})  # the cure of the message


def test_a_tilt_of_parallel_axes_within_the_limits_is_accepted() -> None:
    values = {"errors_at": "mesh", "in_plane_deg": 3.0, "out_of_plane_deg": 1.0}
    design, _ = Start(builtin_design("anti-backlash")).read(values)
    assert design.errors.pinion_axial == pytest.approx(412.4, abs=0.1)


def test_axes_turned_nearly_parallel_by_the_in_plane_error_keep_their_message() -> None:
    """There, a tilt of 0 would not be accepted either."""
    start = Start(builtin_design("awd-transfer"))
    for tilt in (0.01, 0.0):
        with pytest.raises(DesignError, match="the equivalent pinion_axial") as refusal:
            start.read({"errors_at": "mesh", "in_plane_deg": -3.99, "out_of_plane_deg": tilt})
        assert "out_of_plane_deg" not in str(refusal.value)


def test_the_other_place_describes_the_same_mounting(modified: Design) -> None:
    start = Start(modified)
    given = {"offset_error": 0.05, "shaft_angle_error_deg": 0.01, "pinion_axial_error": -0.2}
    before = start.read(given)[0]
    there = given | start.at(given, "mesh") | {"errors_at": "mesh"}
    after = start.read(there)[0]
    for name, value in vars(before.errors).items():
        assert getattr(after.errors, name) == pytest.approx(value, abs=2e-9)
    back = start.at(there, "perpendicular")
    assert [back[name] for name in given] == pytest.approx(list(given.values()), abs=2e-8)


@pytest.mark.parametrize(
    "values", [CHANGES, {"errors_at": "mesh", "centre_distance": 0.03}, {"flank": "left"}]
)
def test_the_command_line_computes_the_same_as_the_file(values: dict[str, Any]) -> None:
    start = Start(builtin_design(), "ni-2017")
    line, reason = start.command(values)
    assert reason == ""
    program, *arguments = shlex.split(line)
    assert program == "beveloid-geom"
    shown = json_of(*arguments)
    design, settings = start.read(values)
    expected = shown["layout"]["errors"]
    assert expected == pytest.approx(vars(design.errors))
    assert settings.flank == arguments[arguments.index("--flank") + 1]


def test_options_given_at_the_start_remain_in_the_command_line(modified: Design) -> None:
    given = {"parabola_pinion": 0.001, "parabola_gear": -0.001}
    start = Start(modified, "ni-2017", given=given)
    line, _ = start.command({"pinion.right.parabola": 0.0005})
    assert "--parabola-pinion=0.001" in line
    assert "--parabola-right-pinion=0.0005" in line
    names = [word.partition("=")[0] for word in shlex.split(line)]
    assert len(names) == len(set(names))


def test_measured_teeth_have_no_controls() -> None:
    plain = builtin_design()
    pitches = Modification(pitch_deviations_um=(0.0,) * 29)
    start = Start(replace(plain, pinion=plain.pinion.modified(pitches, "right")))
    assert not [name for name in start.controls if name.startswith("pinion.right")]
    assert "gear.right.parabola" in start.controls
    with pytest.raises(DesignError, match="is not a control of this pair"):
        start.read({"pinion.right.parabola": 0.001})


def test_sliders_contain_the_start_and_have_round_steps(modified: Design) -> None:
    start = Start(modified)
    for name, control in start.controls.items():
        assert control.low <= start.values[name] <= control.high, name
        assert 100 <= round((control.high - control.low) / control.step) <= 250, name
        assert control.unit
