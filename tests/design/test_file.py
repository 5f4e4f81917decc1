"""Design files: accepted keys and encodings, and changes by `override`."""

from math import cos, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Errors, Pair, Tool, builtin_design, read_design
from beveloid_geom.design.file import DesignError, builtin_text, override, parse_design
from beveloid_geom.design.text import design_text
from beveloid_geom.gear.flank_limits import tip_radius

from .table1_file import DESIGN_1, NUMBER, faults_of, toml


def test_builtin_is_table_1() -> None:
    assert builtin_design() == DESIGN_1 == parse_design(builtin_text()) == read_design("ni-2017")
    assert parse_design(toml({})) == DESIGN_1


def test_optional_keys_and_tables() -> None:
    changes: dict[str, object] = {"pair.pinion_mounting": 200, "gear.parabola": -0.001, "errors": None}
    design = parse_design(toml(changes))
    assert design.pair == Pair(229.0, radians(15.0), 200.0, None)
    assert (design.pinion.tool.parabola, design.gear.tool.parabola) == (0.0, -0.001)
    assert design.errors == Errors()
    errors = {"errors.offset": -0.5, "errors.shaft_angle_deg": 0.02, "errors.gear_axial": 1}
    assert parse_design(toml(dict(errors))).errors == Errors(-0.5, radians(0.02), 0.0, 1.0)


def test_member_overrides_the_tool() -> None:
    design = parse_design(toml({"gear.addendum": 0.8, "gear.tip_radius": 0.2, "tool.dedendum": 1.3}))
    assert design.pinion.tool == Tool(6.0, radians(20.0), 1.0, 1.3, 0.38)
    assert design.gear.tool == Tool(6.0, radians(20.0), 0.8, 1.3, 0.2)


def test_keys_of_both_members_may_be_missing_in_the_tool() -> None:
    both: dict[str, object] = {"tool.normal_module": None, "pinion.normal_module": 6, "gear.normal_module": 6}
    assert parse_design(toml(both)) == DESIGN_1
    both.pop("gear.normal_module")
    missing = "[tool] normal_module is missing: `beveloid-geom design` prints a complete example"
    assert faults_of(both) == (missing,)


LEGAL: list[dict[str, object]] = [
    {"pinion.teeth": 1},
    {"gear.teeth": 1000},
    {"pinion.cone_angle_deg": 0, "gear.cone_angle_deg": 0.0},
    {"pinion.cone_angle_deg": 12.0, "gear.cone_angle_deg": 6.5},
    {"pinion.cone_angle_deg": -3.0, "gear.cone_angle_deg": -0.8},
    {"pinion.helix_angle_deg": -25.0, "gear.helix_angle_deg": 10.57},
    {"gear.helix_angle_deg": 10.57, "pair.shaft_angle_deg": 36.0},
    {"pinion.helix_angle_deg": 45, "gear.helix_angle_deg": 45, "pair.shaft_angle_deg": 90},
    {"pair.shaft_angle_deg": 14.84},
    {"pair.shaft_angle_deg": 0.01, "gear.helix_angle_deg": -24.99, "gear.cone_angle_deg": -3.0},
    {"pinion.parabola": 0.01, "gear.parabola": -0.01},
    {"pair.shaft_angle_deg": 90.0, "errors.shaft_angle_deg": 0.02},
    {"gear.normal_module": 6 * 0.9396926207859084 / 0.9063077870366499, "gear.normal_pressure_angle_deg": 25},
]


@pytest.mark.parametrize("changes", LEGAL, ids=str)
def test_accepted_designs(changes: dict[str, object]) -> None:
    design = parse_design(toml(changes))
    assert design.batch_shape == ()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (
            None,
            "cannot be read (No such file or directory): give a design file, or a built-in design: ni-2017, "
            "awd-transfer, marine-gearbox, anti-backlash",
        ),
        (b"[tool]\nnormal_module = \n", "is not valid TOML: Invalid value (at line 2, column 17)"),
        (b"x = " + 100_000 * b"[", "is not valid TOML: "),
        (b"x = " + 5_000 * b"9", "is not valid TOML: "),
        (b"\x89PNG\r\n", "is not UTF-8 text (byte 0): is it a design file?"),
        (b"\xff\xfe\x00\xd8", "is not UTF-16 text (byte 2): is it a design file?"),
    ],
    ids=["missing", "syntax", "nested", "digits", "binary", "half of UTF-16"],
)
def test_unreadable_files(tmp_path: Path, content: bytes | None, reason: str) -> None:
    path = tmp_path / "mine.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DesignError) as caught:
        read_design(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: {reason}")
    assert "\n" not in message


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    """Design files in UTF-8 and UTF-16 with CR LF are read; PowerShell writes UTF-16."""
    mark = {"utf-16-le": "\ufeff", "utf-16-be": "\ufeff"}.get(encoding, "")
    path = tmp_path / "mine.toml"
    path.write_bytes((mark + builtin_text().replace("\n", "\r\n")).encode(encoding))
    assert read_design(path) == read_design(str(path)) == DESIGN_1


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no /dev/zero here")
def test_endless_file() -> None:
    with pytest.raises(DesignError, match=r"^/dev/zero: is longer than 1,000,000 bytes"):
        read_design("/dev/zero")


def test_folder(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"cannot be read \(Is a directory\)"):
        read_design(tmp_path)


def test_override() -> None:
    assert override(DESIGN_1) == DESIGN_1
    design = override(DESIGN_1, offset_error=0.5, shaft_angle_error_deg=-0.02, parabola_gear=-0.001)
    assert design.errors == Errors(0.5, radians(-0.02), 0.0, 0.0)
    assert (design.pinion, design.pair) == (DESIGN_1.pinion, DESIGN_1.pair)
    assert design.gear.tool == Tool(6.0, radians(20.0), parabola=-0.001)
    again = override(design, gear_axial_error=np.float64(1.0), pinion_axial_error=-2, offset_error=0)
    assert again.errors == Errors(0.0, radians(-0.02), -2.0, 1.0)


@pytest.mark.parametrize(
    ("values", "faults"),
    [
        (
            {"offset_error": float("nan"), "parabola_pinion": True},
            (
                "offset_error must be a finite number, got nan: give a number such as 1.5",
                f"parabola_pinion must be a number, got true: {NUMBER}",
            ),
        ),
        (
            {"offset_error": -200, "parabola_gear": 0.03},
            (
                "parabola_gear must be between -0.02272 and 0.02272 1/mm, got 0.03: a larger coefficient "
                "folds the rack profile, usual values are 0.0001 to 0.01",
                "offset_error must be between -60 and 60 mm (10 modules), got -200.0: it is added to the "
                "offset, it does not replace it",
            ),
        ),
        (
            {"shaft_angle_error_deg": 6, "pinion_axial_error": 2000.0},
            (
                "shaft_angle_error_deg must be between -5 and 5 deg, got 6.0: for another layout, "
                "change the shaft angle of the pair",
                "pinion_axial_error must be between -1000 and 1000 mm, got 2000.0: give it in mm, positive "
                "towards +z",
            ),
        ),
    ],
)
def test_override_reports_the_argument(values: dict[str, Any], faults: tuple[str, ...]) -> None:
    with pytest.raises(DesignError) as caught:
        override(DESIGN_1, **values)
    assert caught.value.faults == faults
    assert str(caught.value) == "\n".join(faults)


def test_tip_diameter_and_tip_alteration() -> None:
    """d_a = d + 2 m_n (x + h_a + k) at mid-face (ISO 21771)."""
    member = parse_design(toml({"pinion.tip_diameter": 206.0})).pinion
    reference = 6.0 * 29.0 / cos(radians(25.0))
    expected = (206.0 - reference) / 12.0 - 0.17 - 1.0
    assert member.tip_alteration == pytest.approx(expected, abs=1e-13)
    assert 2.0 * float(tip_radius(member, 0.0)) == pytest.approx(206.0, abs=1e-12)
    again = parse_design(toml({"pinion.tip_alteration": member.tip_alteration})).pinion
    assert again == member == parse_design(toml({})).pinion.with_tip_diameter(206.0)
    design = parse_design(toml({"pinion.tip_diameter": 206.0}))
    assert parse_design(design_text(design)) == design
    assert "tip_alteration" not in design_text(parse_design(toml({})))
