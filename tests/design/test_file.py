"""Design files: what they read as, what they refuse, and in which words."""

import pickle
import tomllib
from math import radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from beveloid_geom import Errors, Pair, Tool, builtin_design, read_design
from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.design.file import DesignError, builtin_text, override, parse_design
from tests.oracle.table1 import table1

DESIGN_1 = table1()
TABLE_1: dict[str, dict[str, object]] = tomllib.loads(builtin_text())


def toml(changes: dict[str, object]) -> str:
    """Table 1 with changes: 'table.key' to a TOML value or number, None to leave it out."""
    tables: dict[str, dict[str, object]] = {name: dict(keys) for name, keys in TABLE_1.items()}
    for path, value in changes.items():
        table, _, key = path.partition(".")
        if value is None and not key:
            del tables[table]
        elif value is None:
            del tables[table][key]
        else:
            tables.setdefault(table, {})[key] = value
    return "\n".join(
        f"[{table}]\n" + "\n".join(f"{key} = {value}" for key, value in keys.items())
        for table, keys in tables.items()
    )


def faults_of(changes: dict[str, object]) -> tuple[str, ...]:
    with pytest.raises(DesignError) as caught:
        parse_design(toml(changes))
    return caught.value.faults


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


def test_tool_may_leave_to_the_members_what_both_have() -> None:
    both: dict[str, object] = {"tool.normal_module": None, "pinion.normal_module": 6, "gear.normal_module": 6}
    assert parse_design(toml(both)) == DESIGN_1
    both.pop("gear.normal_module")
    missing = "[tool] normal_module is missing: the built-in design shows all tables and keys"
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
    {"pinion.parabola": 0.01, "gear.parabola": -0.01},
    {"pair.shaft_angle_deg": 90.0, "errors.shaft_angle_deg": 0.02},
    {"gear.normal_module": 6 * 0.9396926207859084 / 0.9063077870366499, "gear.normal_pressure_angle_deg": 25},
]


@pytest.mark.parametrize("changes", LEGAL, ids=str)
def test_ordinary_designs_are_accepted(changes: dict[str, object]) -> None:
    design = parse_design(toml(changes))
    assert design.batch_shape == ()


NUMBER = "give it like 1.5, without quotes"
WHOLE = "give it like 29, without quotes or decimals"
MODULES = "it counts in normal modules, not in mm"
LENGTH = "give a positive length in mm"
DISTANCE = "give the distance of the axes in mm, 0 where they intersect"
EXAMPLE = "is missing: the built-in design shows all tables and keys"
BAD = {
    "pinion.helix_angle_deg = '25'": f"must be a number, got '25': {NUMBER}",
    "pair.offset = true": f"must be a number, got true: {NUMBER}",
    "pair.offset = [229]": f"must be a number, got [229]: {NUMBER}",
    "pair.offset = 0x1" + 300 * "0": f"must be a number, got an integer of 1201 bits: {NUMBER}",
    "pair.offset = nan": "must be a finite number, got nan: give the value itself",
    "errors.gear_axial = -inf": "must be a finite number, got -inf: give the value itself",
    "gear.parabola = inf": "must be a finite number, got inf: give the value itself",
    "gear.teeth = 44.5": f"must be a whole number, got 44.5: {WHOLE}",
    "gear.teeth = true": f"must be a whole number, got true: {WHOLE}",
    # out of its limits
    "tool.normal_module = -6": f"must be between 0.01 and 100 mm, got -6.0: {LENGTH}",
    "gear.face_width = 0": f"must be between 0.01 and 10000 mm, got 0.0: {LENGTH}",
    "pair.offset = -1e-9": f"must be between 0 and 100000 mm, got -1e-09: {DISTANCE}",
    "tool.addendum = 6": f"must be between 0.1 and 4, got 6.0: {MODULES}",
    "pinion.dedendum = 0.4": f"must be between 0.5 and 4, got 0.4: {MODULES}",
    "tool.tip_radius = -1": f"must be between 0 and 4, got -1.0: {MODULES}",
    "gear.profile_shift = 3.1": f"must be between -3 and 3, got 3.1: {MODULES}",
    "gear.teeth = 0": "must be between 1 and 2000, got 0: a member has at least one tooth",
    "gear.teeth = 3000": "must be between 1 and 2000, got 3000: a rack is not covered by this model",
    "gear.helix_angle_deg = -81": "must be between -80 and 80 deg, got -81.0: measure it from the axis, "
        "right hand positive; the lead angle is 90 deg less it",
    "gear.cone_angle_deg = 46": "must be between -45 and 45 deg, got 46.0: it is half the angle of the "
        "pitch cone, positive if the tooth grows towards the heel at +z",
    "pair.shaft_angle_deg = -15": "must be between 0 and 90 deg, got -15.0: give its magnitude, its sense "
        "follows from the helix angles",
    "pair.shaft_angle_deg = 165": "must be between 0 and 90 deg, got 165.0: it is the smaller angle of "
        "the two axes, take 180 deg less it",
    "errors.shaft_angle_deg = 15": "must be between -5 and 5 deg, got 15.0: change the shaft angle of the "
        "pair if another layout is meant",
    "tool.normal_pressure_angle_deg = 0.349": "must be between 5 and 45 deg, got 0.349: was it given in "
        "radians?",
    "pair.shaft_angle_deg = 0.2618": "must be about 15 deg to fit the other angles, got 0.2618: was it "
        "given in radians?",
    "pinion.helix_angle_deg = 0.436": "must be about 25 deg to fit the other angles, got 0.436: was it "
        "given in radians?",
    # limits that join several keys
    "pinion.parabola = -0.03": "must be between -0.0212 and 0.0212 1/mm, got -0.03: a stronger one folds "
        "the rack profile, usual are 0.0001 to 0.01",
    "tool.tip_radius = 2.28": f"must be at most 1.14 at this dedendum, got 2.28: the round would eat the "
        f"flank; {MODULES}",
    "pinion.cone_angle_deg = 40": "must be between -39.1714 and 39.1714 deg at this helix and pressure "
        "angle, got 40.0: the tool would cut one flank from behind, take a larger pressure angle",
    "pinion.face_width = 9999": "must leave a tip radius at the narrow end of the face above 0 mm, got "
        "-158.999: take a narrower face or a smaller cone",
    "gear.normal_module = 5": "cos(normal_pressure_angle_deg) must equal that of [pinion], 5.63815572472 "
        "mm, got 4.69846310393: teeth that mesh share their base pitch",
    "errors.offset = 229": "must be between -60 and 60 mm, 10 modules, got 229.0: it adds to the offset, it "
        "does not replace it",
    # missing, misspelt, misplaced
    "gear.teeth": EXAMPLE,
    "pair": EXAMPLE,
    "errors.ofset = 1": "is unknown: did you mean offset?",
    "pair.Shaft_Angle = 15": "is unknown: did you mean shaft_angle_deg?",
    "pair.x = 1": "is unknown: there are offset, shaft_angle_deg, pinion_mounting, gear_mounting",
    "tool.parabola = 0.001": "does not belong here: move it to [pinion] or [gear]",
    "tool.face_width = 50": "does not belong here: move it to [pinion] or [gear]",
    "error.offset = 1": "[error] is unknown: did you mean [errors]?",
    "'a\\nb'.offset = 1": "['a\\\\nb'] is unknown: there are [tool], [pinion], [gear], [pair], [errors]",
}  # fmt: skip
"""What is changed in Table 1, and what is said of it behind the table and key."""


@pytest.mark.parametrize(("changed", "said"), BAD.items(), ids=lambda text: text[:40])
def test_each_fault_has_its_line(changed: str, said: str) -> None:
    key, _, value = changed.partition(" = ")
    table, _, name = key.partition(".")
    place = f"[{table}] {name}".rstrip()
    assert faults_of({key: value or None}) == (said if said.startswith("[") else f"{place} {said}",)


def test_a_cone_that_narrows_towards_the_heel_has_its_narrow_end_there() -> None:
    (fault,) = faults_of({"pinion.cone_angle_deg": -3.0, "pinion.face_width": 9999})
    assert fault.startswith("[pinion] face_width must leave a tip radius")
    assert "got -158.999: " in fault


def test_all_faults_come_at_once() -> None:
    changes: dict[str, object] = {
        "tool.normal_pressure_angle_deg": 0.349,
        "tools.x": 1,
        "pinion.teeth": 28.5,
        "pinion.face_width": None,
        "gear.facewidth": 60,
        "gear.face_width": None,
        "gear.profile_shift": "'0.2'",
        "pair.offset": -1,
        "errors.offset": "nan",
    }
    assert faults_of(changes) == (
        "[tools] is unknown: did you mean [tool]?",
        "[tool] normal_pressure_angle_deg must be between 5 and 45 deg, got 0.349: was it given in radians?",
        f"[pinion] teeth must be a whole number, got 28.5: {WHOLE}",
        f"[pinion] face_width {EXAMPLE}",
        f"[gear] profile_shift must be a number, got '0.2': {NUMBER}",
        "[gear] facewidth is unknown: did you mean face_width?",
        f"[pair] offset must be between 0 and 100000 mm, got -1.0: {DISTANCE}",
        "[errors] offset must be a finite number, got nan: give the value itself",
    )


def test_limits_that_join_keys_are_reported_beside_others() -> None:
    folded, wordy = faults_of({"gear.parabola": 0.5, "pair.offset": "'far'"})
    assert folded.startswith("[gear] parabola must be between -0.02272 and 0.02272 1/mm, got 0.5: ")
    assert wordy == f"[pair] offset must be a number, got 'far': {NUMBER}"


@pytest.mark.parametrize(
    ("changes", "blamed"),
    [
        ({"pinion.helix_angle_deg": 0.436, "gear.helix_angle_deg": -0.1845}, ["pinion", "gear"]),
        ({"gear.helix_angle_deg": -0.1845}, ["gear"]),
    ],
)
def test_helix_angles_in_radians(changes: dict[str, object], blamed: list[str]) -> None:
    faults = faults_of(changes)
    assert [fault.split("]")[0][1:] for fault in faults] == blamed
    assert all("helix_angle_deg" in f and f.endswith("was it given in radians?") for f in faults)


def test_shaft_angle_of_a_steep_pair_in_radians() -> None:
    changes = {"pinion.helix_angle_deg": 45, "gear.helix_angle_deg": 15, "pair.shaft_angle_deg": 1.0472}
    assert faults_of(dict(changes)) == (
        "[pair] shaft_angle_deg must be about 60 deg to fit the other angles, got 1.0472: was it given in "
        "radians?",
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("teeth = 29", "teeth does not belong here: move it to [pinion] or [gear]"),
        ("module = 6", "module is unknown: there are [tool], [pinion], [gear], [pair], [errors]"),
        ("gear = 3", "[gear] must be a table, got 3: write [gear] above its keys"),
    ],
)
def test_keys_outside_the_tables(text: str, fault: str) -> None:
    table = text.split()[0]
    rest = toml({table: None} if table in TABLE_1 else {})
    with pytest.raises(DesignError) as caught:
        parse_design(f"{text}\n{rest}")
    assert caught.value.faults == (fault,)


def test_empty_file_names_what_is_missing() -> None:
    with pytest.raises(DesignError) as caught:
        parse_design("", "empty.toml")
    missing = ["[pinion]", "[gear]", "[pair]", "[tool] normal_module", "[tool] normal_pressure_angle_deg"]
    assert str(caught.value) == "\n".join(f"empty.toml: {name} {EXAMPLE}" for name in missing)


def test_message_names_the_file_on_each_line_and_survives_pickling() -> None:
    with pytest.raises(DesignError) as caught:
        parse_design(toml({"pinion.teeth": 0, "gear.teeth": 0}), "mine.toml")
    assert [line.split("]")[0] for line in str(caught.value).splitlines()] == [
        "mine.toml: [pinion",
        "mine.toml: [gear",
    ]
    copy = pickle.loads(pickle.dumps(caught.value))
    for name in ("faults", "source"):
        assert getattr(copy, name) == getattr(caught.value, name)
    assert str(copy) == str(caught.value)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (
            None,
            "cannot be read (No such file or directory): name a TOML file, or a built-in design: ni-2017, "
            "awd-transfer, marine-gearbox, anti-backlash",
        ),
        (b"[tool]\nnormal_module = \n", "is not valid TOML: Invalid value (at line 2, column 17)"),
        (b"x = " + 100_000 * b"[", "is not valid TOML: "),
        (b"x = " + 5_000 * b"9", "is not valid TOML: "),
        (b"\x89PNG\r\n", "is not UTF-8 text (byte 0): is it a design file?"),
        (b"\xff\xfe\x00\xd8", "is not UTF-16 text (byte 2): is it a design file?"),
        (b"#" * 1_000_001, "is longer than 1,000,000 bytes: is it a design file?"),
    ],
    ids=["missing", "syntax", "nested", "digits", "binary", "half of UTF-16", "too long"],
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
def test_text_as_systems_write_it(tmp_path: Path, encoding: str) -> None:
    """PowerShell's `>` writes UTF-16 and CR LF."""
    mark = {"utf-16-le": "\ufeff", "utf-16-be": "\ufeff"}.get(encoding, "")
    path = tmp_path / "mine.toml"
    path.write_bytes((mark + builtin_text().replace("\n", "\r\n")).encode(encoding))
    assert read_design(path) == read_design(str(path)) == DESIGN_1


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no /dev/zero here")
def test_a_file_without_end_is_no_design() -> None:
    with pytest.raises(DesignError, match=r"^/dev/zero: is longer than 1,000,000 bytes"):
        read_design("/dev/zero")


def test_a_folder_is_no_design(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"cannot be read \(Is a directory\)"):
        read_design(tmp_path)


def test_unknown_builtin() -> None:
    with pytest.raises(DesignError, match=r"^there is no built-in design 'x': there are ni-2017, "):
        builtin_text("x")


def test_override_changes_only_what_is_given() -> None:
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
                "offset_error must be a finite number, got nan: give the value itself",
                f"parabola_pinion must be a number, got true: {NUMBER}",
            ),
        ),
        (
            {"offset_error": -200, "parabola_gear": 0.03},
            (
                "parabola_gear must be between -0.02272 and 0.02272 1/mm, got 0.03: a stronger one folds the "
                "rack profile, usual are 0.0001 to 0.01",
                "offset_error must be between -60 and 60 mm, 10 modules, got -200.0: it adds to the offset, "
                "it does not replace it",
            ),
        ),
        (
            {"shaft_angle_error_deg": 6, "pinion_axial_error": 2000.0},
            (
                "shaft_angle_error_deg must be between -5 and 5 deg, got 6.0: change the shaft angle "
                "of the pair if another layout is meant",
                "pinion_axial_error must be between -1000 and 1000 mm, got 2000.0: give it in mm, positive "
                "towards the heel",
            ),
        ),
    ],
)
def test_override_names_the_argument(values: dict[str, float], faults: tuple[str, ...]) -> None:
    with pytest.raises(DesignError) as caught:
        override(DESIGN_1, **values)
    assert caught.value.faults == faults
    assert str(caught.value) == "\n".join(faults)


@settings(deadline=None, max_examples=40)
@given(
    module=st.floats(0.5, 20.0),
    shift=st.floats(-1.0, 1.0),
    pinion_helix=st.floats(5.0, 40.0),
    gear_helix=st.floats(-4.0, 40.0),
    offset=st.floats(10.0, 900.0),
)
def test_numbers_arrive_to_the_last_digit(
    module: float, shift: float, pinion_helix: float, gear_helix: float, offset: float
) -> None:
    changes: dict[str, object] = {
        "tool.normal_module": module,
        "pinion.profile_shift": shift,
        "pinion.helix_angle_deg": pinion_helix,
        "gear.helix_angle_deg": gear_helix,
        "pair.offset": offset,
        "pair.shaft_angle_deg": max(1.0, abs(pinion_helix + gear_helix)),
    }
    design = parse_design(toml(changes))
    assert design.pinion.tool.normal_module == design.gear.tool.normal_module == module
    assert (design.pinion.profile_shift, design.pair.offset) == (shift, offset)
    assert design.pinion.helix_angle == radians(pinion_helix)
    assert design.gear.helix_angle == radians(gear_helix)


PARALLEL: dict[str, object] = {
    "pair.shaft_angle_deg": 0,
    "gear.helix_angle_deg": -25,
    "gear.cone_angle_deg": -3,
}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"gear.helix_angle_deg": 25},
            "[gear] helix_angle_deg must be -25.0 deg, opposite to that of [pinion], got 25.0: teeth of equal"
            " hands cross each other on parallel axes",
        ),
        (
            {"gear.helix_angle_deg": -24.9},
            "[gear] helix_angle_deg must be -25.0 deg, opposite to that of [pinion], got -24.9: on parallel"
            " axes base helix angles must be opposite",
        ),
        (
            {"gear.cone_angle_deg": 3},
            "[gear] cone_angle_deg must be -3.0 deg, opposite to that of [pinion], got 3.0: on parallel axes"
            " one tooth must taper as the space of the other",
        ),
    ],
)
def test_members_that_do_not_fit_on_parallel_axes(changed: dict[str, float], said: str) -> None:
    parse_design(toml(PARALLEL))
    assert faults_of({**PARALLEL, **changed}) == (said,)


def test_pressure_angles_on_parallel_axes() -> None:
    """One base pitch by tools of two pressure angles: cylinders mesh, cones and helical parabolas do not."""
    module = 6.0 * np.cos(np.radians(20.0)) / np.cos(np.radians(22.0))
    tool = {"gear.normal_module": module, "gear.normal_pressure_angle_deg": 22.0}
    spur = {"pinion.cone_angle_deg": 0, "gear.cone_angle_deg": 0, "pinion.helix_angle_deg": 0}
    spur |= {"gear.helix_angle_deg": 0, "pair.shaft_angle_deg": 0}
    design = parse_design(toml({**spur, **tool}))
    assert touches_along_lines(design).all()
    (fault,) = faults_of({**PARALLEL, **tool})
    assert fault.startswith("[gear] normal_pressure_angle_deg must equal that of [pinion], 20.0 deg, got 22")


@pytest.mark.parametrize("degrees", [0.01, 0.3, 0.49])
def test_small_shaft_angles_are_read(degrees: float) -> None:
    small = {"pinion.helix_angle_deg": 15, "gear.helix_angle_deg": degrees - 15, "gear.cone_angle_deg": 0}
    design = parse_design(toml({**small, "pinion.cone_angle_deg": 0, "pair.shaft_angle_deg": degrees}))
    assert float(design.pair.shaft_angle) == pytest.approx(np.radians(degrees))
