"""Built-in designs besides Table 1, whose axes intersect: no warnings, and their numbers in closed form.

Their helix angles cancel and their cone angles add up to the shaft angle, so that each closes with its
reference cones as pitch cones, whatever the profile shift: that moves tips and thins teeth.
"""

from __future__ import annotations

from math import cos, pi, sin, tan
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import DesignError, builtin_design, certify, path_of_contact, sliding_of
from beveloid_geom.design import file
from beveloid_geom.design.file import BUILTINS, builtin_text, parse_design, read_design
from beveloid_geom.findings.remarks import NOTE, tip_clearances
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.closing import closing_of
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.closing import closing_report
from beveloid_geom.status import Limit, Status
from tests.oracle.sixty_digits import off_by
from tests.validation.test_intersecting_axes import closed_form

NAMES = ("awd-transfer", "marine-gearbox")


def test_every_file_is_listed() -> None:
    folder = Path(file.__file__).parent / "designs"
    assert {path.stem for path in folder.glob("*.toml")} == set(BUILTINS) == {"ni-2017", *NAMES}
    with pytest.raises(DesignError, match=f"there are ni-2017, {', '.join(NAMES)}$"):
        builtin_design("marine")


@pytest.mark.parametrize("name", NAMES)
def test_each_reads_and_has_nothing_above_a_note(name: str) -> None:
    design = builtin_design(name)
    assert design == parse_design(builtin_text(name)) == read_design(name)
    report = closing_report(name, design)
    assert [remark for remark in report.remarks if remark.level != NOTE] == []


@pytest.mark.parametrize("name", NAMES)
def test_what_its_comments_say(name: str) -> None:
    """Radii, mounting distances and backlash from the numbers of the file alone."""
    design, text = builtin_design(name), builtin_text(name)
    mounting, closing = mounting_of(design), closing_of(design)
    pinion = design.pinion
    module, shaft = float(pinion.tool.normal_module), float(design.pair.shaft_angle)
    alpha = float(pinion.tool.normal_pressure_angle)
    r1, r2 = (module * float(m.teeth) / (2.0 * cos(float(m.helix_angle))) for m in design.members)
    distance = (r2 + r1 * cos(shaft)) / sin(shaft), (r1 + r2 * cos(shaft)) / sin(shaft)
    shift = sum(float(m.profile_shift) * cos(float(m.cone_angle)) for m in design.members)
    backlash = -2.0 * module * shift * sin(alpha)
    np.testing.assert_allclose(mounting.working_radius, (r1, r2), rtol=1e-11)
    np.testing.assert_allclose(mounting.distance, distance, rtol=1e-11)
    assert closing.gap < 1e-10
    assert closing.offset_difference == closing.shaft_angle_difference == 0.0
    assert closing.normal_backlash == pytest.approx(backlash, abs=1e-10)
    assert 0.03 < backlash / module < 0.05
    assert f"= {backlash:.3f} mm" in text
    for radius in {r1, r2}:
        assert f"{radius:.4f}" in text
    written = parse_design(text.replace("# pinion_mounting", "pinion_mounting").replace("# gear_m", "gear_m"))
    np.testing.assert_allclose(mounting_of(written).distance, distance, rtol=0.0, atol=1e-6)
    assert (tip_clearances(design) > 0.25 * module).all()
    for member in design.members:
        least = 1.0 - float(member.teeth) * sin(alpha) ** 2 / (2.0 * cos(float(member.helix_angle)) ** 3)
        at_toe = 0.5 * float(member.face_width) * tan(float(member.cone_angle)) / module
        assert float(member.profile_shift) - at_toe > least + 0.3


@pytest.mark.parametrize("name", NAMES)
def test_contact_ratios_in_closed_form(name: str, flank: str) -> None:
    design = builtin_design(name)
    path = path_of_contact(design, flank, 5)
    assert {path.ends.enter, path.ends.leave} == {Limit.GEAR_TIP, Limit.PINION_TIP}
    ratio = float(path.ends.contact_ratio)
    assert ratio == pytest.approx(closed_form(design, flank), abs=1e-11)
    assert ratio > 1.4
    assert certify(path).holds
    assert float(operating_ratio(design, flank)) == pytest.approx(ratio, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_sixty_digits(name: str, flank: str) -> None:
    """Ends of the path by the five equations; between them the roll, over the pitch, is the contact ratio."""
    design = builtin_design(name)
    path = path_of_contact(design, flank, 3)
    assert path.ends.status == Status.SOLVED
    for k in range(3):
        apart, turned = off_by(path, k, "l1")
        assert apart < 1e-11
        assert turned < 1e-13
    roll = abs(float(path.pinion_roll[-1] - path.pinion_roll[0]))
    ratio = roll * float(design.pinion.teeth) / (2.0 * pi)
    assert ratio == pytest.approx(closed_form(design, flank), abs=1e-11)


def test_specific_sliding_of_the_marine_pair_is_balanced() -> None:
    paths = [path_of_contact(builtin_design("marine-gearbox"), side, 21) for side in ("right", "left")]
    least = np.min([sliding_of(path).specific.min(axis=0) for path in paths], axis=0)
    np.testing.assert_allclose(least, (-1.2, -1.2), rtol=0.0, atol=0.05)
