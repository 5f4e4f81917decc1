"""Built-in designs other than Table 1: no warnings, and numbers in closed form.

The helix angles cancel, and the cone angles add up to the shaft angle (0 on parallel axes). The reference
cones are therefore the pitch cones for any profile shift, which only moves tips and changes tooth
thicknesses.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin, tan
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import (
    DesignError,
    Pair,
    builtin_design,
    path_certificate,
    path_of_contact,
    path_sliding,
    read_design,
)
from beveloid_geom.contact.parallel.lines import contact_lines
from beveloid_geom.design import file
from beveloid_geom.design.file import BUILTINS, builtin_text, parse_design
from beveloid_geom.findings.diagnostics import NOTE, tip_clearances
from beveloid_geom.operation.backlash import mounted_backlash
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.report.check import check_report
from beveloid_geom.status import Limit
from tests.validation.test_intersecting_axes import closed_form

NAMES = ("awd-transfer", "marine-gearbox")
PARALLEL = "anti-backlash"


def test_every_file_is_listed() -> None:
    folder = Path(file.__file__).parent / "designs"
    assert {path.stem for path in folder.glob("*.toml")} == set(BUILTINS) == {"ni-2017", *NAMES, PARALLEL}
    with pytest.raises(
        DesignError,
        match=f"^there is no built-in design 'marine': give one of ni-2017, {', '.join((*NAMES, PARALLEL))}$",
    ):
        builtin_design("marine")


@pytest.mark.parametrize("name", [*NAMES, PARALLEL])
def test_built_in_designs_have_notes_only(name: str) -> None:
    design = builtin_design(name)
    assert design == parse_design(builtin_text(name)) == read_design(name)
    report = check_report(name, design)
    assert [remark for remark in report.remarks if remark.level != NOTE] == []


@pytest.mark.parametrize("name", NAMES)
def test_numbers_in_the_comments(name: str) -> None:
    """The radii, mounting distances and backlash in the comments of the files agree with closed forms."""
    design, text = builtin_design(name), builtin_text(name)
    mounting, deviation = mounting_of(design), layout_deviation(design)
    pinion = design.pinion
    module, shaft = float(pinion.tool.normal_module), float(design.pair.shaft_angle)
    alpha = float(pinion.tool.normal_pressure_angle)
    r1, r2 = (module * float(m.teeth) / (2.0 * cos(float(m.helix_angle))) for m in design.members)
    distance = (r2 + r1 * cos(shaft)) / sin(shaft), (r1 + r2 * cos(shaft)) / sin(shaft)
    shift = sum(float(m.profile_shift) * cos(float(m.cone_angle)) for m in design.members)
    backlash = -2.0 * module * shift * sin(alpha)
    np.testing.assert_allclose(mounting.working_radius, (r1, r2), rtol=1e-11)
    np.testing.assert_allclose(mounting.distance, distance, rtol=1e-11)
    assert deviation.normal_backlash == pytest.approx(backlash, abs=1e-10)
    assert 0.03 < backlash / module < 0.05
    assert f"= {backlash:.3f} mm" in text
    for radius in {r1, r2}:
        assert f"{radius:.4f}" in text
    with_mounting = parse_design(
        text.replace("# pinion_mounting", "pinion_mounting").replace("# gear_m", "gear_m")
    )
    np.testing.assert_allclose(mounting_of(with_mounting).distance, distance, rtol=0.0, atol=1e-6)
    assert (tip_clearances(design) > 0.25 * module).all()
    for member in design.members:
        least = 1.0 - float(member.teeth) * sin(alpha) ** 2 / (2.0 * cos(float(member.helix_angle)) ** 3)
        at_toe = 0.5 * float(member.face_width) * tan(float(member.cone_angle)) / module
        assert float(member.profile_shift) - at_toe > least + 0.3


@pytest.mark.parametrize("name", NAMES)
def test_contact_ratios_in_closed_form(name: str, flank: str) -> None:
    """The ratios agree with a closed form, which is valid with profile shifts too, and in operation."""
    design = builtin_design(name)
    path = path_of_contact(design, flank, 5)
    assert {path.ends.enter, path.ends.leave} == {Limit.GEAR_TIP, Limit.PINION_TIP}
    ratio = float(path.ends.contact_ratio)
    assert ratio == pytest.approx(closed_form(design, flank), abs=1e-11)
    assert path_certificate(path).holds
    assert float(operating_ratio(design, flank)) == pytest.approx(ratio, abs=1e-9)


def test_specific_sliding_of_the_marine_pair_is_balanced() -> None:
    paths = [path_of_contact(builtin_design("marine-gearbox"), side, 21) for side in ("right", "left")]
    least = np.min([path_sliding(path).specific.min(axis=0) for path in paths], axis=0)
    np.testing.assert_allclose(least, (-1.2, -1.2), rtol=0.0, atol=0.05)


def test_numbers_in_the_comments_of_the_anti_backlash_pair() -> None:
    design, text = builtin_design(PARALLEL), builtin_text(PARALLEL)
    deviation, pinion = layout_deviation(design), design.pinion
    module, alpha = float(pinion.tool.normal_module), float(pinion.tool.normal_pressure_angle)
    cone = float(pinion.cone_angle)
    shift = sum(float(m.profile_shift) for m in design.members)
    backlash, rate = -2.0 * module * shift * cos(cone) * sin(alpha), 2.0 * sin(alpha) * sin(cone)
    assert deviation.normal_backlash == pytest.approx(backlash, abs=1e-12)
    away = backlash / rate
    comments = f"= {backlash:.3f} mm", f"= {rate:.4f} mm", f"{away:.3f} mm further", "= 0.47 mm, 0.31 modules"
    for comment in comments:
        assert comment in text
    assert 9.0 * tan(cone) == pytest.approx(0.47, abs=0.005)
    without = replace(design, pair=Pair(design.pair.offset, 0.0, 0.0, away))
    assert float(mounting_of(without).normal_backlash) == pytest.approx(0.0, abs=1e-12)
    assert float(mounted_backlash(design).normal) == pytest.approx(backlash, abs=1e-9)
    assert (tip_clearances(design) > 0.25 * module * cos(cone)).all()
    least = 1.0 - 24.0 * sin(alpha) ** 2 / 2.0
    assert f"undercut would begin at {least:.2f}" in text
    assert float(pinion.profile_shift) - 9.0 * tan(cone) / module > least + 0.3


def test_lines_of_contact_of_the_anti_backlash_pair(flank: str) -> None:
    """A line is as long as the common face divided by the cosine of the base helix angle."""
    design = builtin_design(PARALLEL)
    path = path_of_contact(design, flank, 9)
    lines = contact_lines(path)
    assert float(lines.transverse_ratio) > 1.5
    alpha, cone = float(design.pinion.tool.normal_pressure_angle), float(design.pinion.cone_angle)
    sine = sin(alpha) * sin(cone)  # of the base helix angle
    assert lines.length.max() == pytest.approx(15.0 / np.sqrt(1.0 - sine**2), abs=1e-9)
    pitch = pi * 1.5 * cos(alpha)
    assert float(lines.overlap_ratio) == pytest.approx(15.0 * sine / pitch, abs=1e-12)
    least = path_sliding(path).specific.min(axis=0)
    np.testing.assert_allclose(least, (-1.7, -1.6), rtol=0.0, atol=0.05)
