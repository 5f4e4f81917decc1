"""Faults of design files: one line each, with key, limit, value and cure."""

import pickle

import numpy as np
import pytest

from beveloid_geom.contact.parallel.lines import touches_along_lines
from beveloid_geom.design.file import DesignError, builtin_text, parse_design

from .table1_file import NUMBER, TABLE_1, faults_in, faults_of, toml

WHOLE = "write it without quotes and decimals, such as 29"
MODULES = "give it in normal modules, not in mm"
LENGTH = "give a positive length in mm"
DISTANCE = "give the distance of the axes in mm, 0 where they intersect"
EXAMPLE = "is missing: `beveloid-geom design` prints a complete example"
BAD = {
    "pinion.helix_angle_deg = '25'": f"must be a number, got '25': {NUMBER}",
    "pair.offset = [229]": f"must be a number, got [229]: {NUMBER}",
    "pair.offset = 0x1" + 300 * "0": f"must be a number, got an integer of 1201 bits: {NUMBER}",
    "pair.offset = nan": "must be a finite number, got nan: give a number such as 1.5",
    "gear.teeth = -inf": "must be a finite number, got -inf: give a number such as 1.5",
    "gear.teeth = 44.5": f"must be a whole number, got 44.5: {WHOLE}",
    "gear.teeth = true": f"must be a whole number, got true: {WHOLE}",
    # outside the range
    "tool.normal_module = -6": f"must be between 0.01 and 100 mm, got -6.0: {LENGTH}",
    "pair.offset = -1e-9": f"must be between 0 and 100000 mm, got -1e-09: {DISTANCE}",
    "tool.addendum = 6": f"must be between 0.1 and 4, got 6.0: {MODULES}",
    "gear.profile_shift = 3.1": f"must be between -3 and 3, got 3.1: {MODULES}",
    "gear.teeth = 0": "must be between 1 and 2000, got 0: a member has at least one tooth",
    "gear.teeth = 3000": "must be between 1 and 2000, got 3000: racks are not supported",
    "gear.helix_angle_deg = -81": "must be between -80 and 80 deg, got -81.0: measure it from the axis, "
        "right hand positive; it is the complement of the lead angle",
    "gear.cone_angle_deg = 46": "must be between -45 and 45 deg, got 46.0: it is half the angle of the "
        "pitch cone, positive if the tooth grows towards +z",
    "pair.shaft_angle_deg = -15": "must be between 0 and 90 deg, got -15.0: give the magnitude, the sense "
        "follows from the helix angles",
    "pair.shaft_angle_deg = 165": "must be between 0 and 90 deg, got 165.0: it is the smaller angle between "
        "the axes, give 180 deg minus this angle",
    "errors.shaft_angle_deg = 15": "must be between -5 and 5 deg, got 15.0: for another layout, change "
        "the shaft angle of the pair",
    "tool.normal_pressure_angle_deg = 0.349": "must be between 5 and 45 deg, got 0.349: was it given in "
        "radians?",
    "tool.normal_module = 0.009": "must be between 0.01 and 100 mm, got 0.009: was it given in inches?",
    "pair.shaft_angle_deg = 0.2618": "must be about 15 deg to fit the other angles, got 0.2618: was it "
        "given in radians?",
    "pinion.helix_angle_deg = 0.436": "must be about 25 deg to fit the other angles, got 0.436: was it "
        "given in radians?",
    # combinations of keys
    "pinion.parabola = -0.03": "must be between -0.0212 and 0.0212 1/mm, got -0.03: a larger coefficient "
        "folds the rack profile, usual values are 0.0001 to 0.01",
    "tool.dedendum = 0.5": (
        "must be at least 0.751 with this tip_radius, got 0.5: it is less than the addendum, 1, usual is 1.25"
    ),
    "tool.tip_radius = 2.28": "must be at most 1.14 at this dedendum, got 2.28: a larger tip round "
        "leaves no flank, the unit is the normal module, not mm",
    "pinion.cone_angle_deg = 40": "must be between -39.1714 and 39.1714 deg at this helix and pressure "
        "angle, got 40.0: the tool cannot generate one of the flanks, increase the pressure angle",
    "pinion.tip_diameter = 100.0": "must be between 195.228 and 242.028 mm, got 100.0: it is the diameter "
        "of the tip cone at mid-face and includes the profile shift",
    "gear.tip_alteration = -0.95": "must leave the tip at least 0.1 modules above the shifted pitch cone, "
        "got -0.95: increase it or the tip diameter, the addendum is 1",
    "gear.normal_module = 5": "cos(normal_pressure_angle_deg) must equal that of [pinion], 5.63815572472 "
        "mm, got 4.69846310393: change module or pressure angle, as meshing teeth need the same base pitch",
    "errors.offset = 229": "must be between -60 and 60 mm (10 modules), got 229.0: it is added to the "
        "offset, it does not replace it",
    # missing, misspelt, misplaced
    "gear.teeth": EXAMPLE,
    "pair": EXAMPLE,
    "errors.ofset = 1": "is unknown: did you mean offset?",
    "pair.Shaft_Angle = 15": "is unknown: did you mean shaft_angle_deg?",
    "pair.x = 1": "is unknown: known are offset, shaft_angle_deg, pinion_mounting, gear_mounting",
    "tool.parabola = 0.001": "does not belong here: move it to [pinion] or [gear]",
    "tool.face_width = 50": "does not belong here: move it to [pinion] or [gear]",
    "foo.offset = 1": "[foo] is unknown: known are [tool], [pinion], [gear], [pair], [errors]",
    "error.offset = 1": "[error] is unknown: did you mean [errors]?",
    "'a\\nb'.offset = 1": "['a\\\\nb'] is unknown: known are [tool], [pinion], [gear], [pair], [errors]",
}  # fmt: skip
"""Change of Table 1, and the message after table and key."""


@pytest.mark.parametrize(("changed", "message"), BAD.items(), ids=lambda text: text[:40])
def test_message(changed: str, message: str) -> None:
    key, _, value = changed.partition(" = ")
    table, _, name = key.partition(".")
    place = f"[{table}] {name}".rstrip()
    assert faults_of({key: value or None}) == (message if message.startswith("[") else f"{place} {message}",)


def test_negative_cone_angle_and_wide_face() -> None:
    assert faults_of({"pinion.cone_angle_deg": -3.0, "pinion.face_width": 9999}) == (
        "[pinion] face_width must leave a radius of the tip cone above 0 mm at the small end of the face, got"
        " -158.999: use a narrower face or a smaller cone angle",
    )


def test_all_faults_are_reported_together() -> None:
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
        "[errors] offset must be a finite number, got nan: give a number such as 1.5",
    )


def test_combined_limits_are_reported_with_others() -> None:
    folded, text = faults_of({"gear.parabola": 0.5, "pair.offset": "'far'"})
    assert folded.startswith("[gear] parabola must be between -0.02272 and 0.02272 1/mm, got 0.5: ")
    assert text == f"[pair] offset must be a number, got 'far': {NUMBER}"


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


def test_cone_angles_of_intersecting_axes_in_radians() -> None:
    """Cone angles in radians are recognised: those of the marine gearbox are 2 and 5 deg, and the shaft angle
    is 7 deg."""
    text = builtin_text("marine-gearbox")
    for degrees in (2.0, 5.0):
        text = text.replace(f"cone_angle_deg = {degrees}", f"cone_angle_deg = {np.radians(degrees):.4f}")
    assert faults_in(text) == tuple(
        f"[{name}] cone_angle_deg must be about {fitting} deg to fit the other angles, got {given}: was it "
        "given in radians?"
        for name, fitting, given in (("pinion", 2, 0.0349), ("gear", 5, 0.0873))
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("teeth = 29", "teeth does not belong here: move it to [pinion] or [gear]"),
        ("module = 6", "module is unknown: known are [tool], [pinion], [gear], [pair], [errors]"),
        ("gear = 3", "[gear] must be a table, got 3: write the line [gear] above its keys"),
    ],
)
def test_keys_outside_the_tables(text: str, fault: str) -> None:
    table = text.split()[0]
    rest = toml({table: None} if table in TABLE_1 else {})
    assert faults_in(f"{text}\n{rest}") == (fault,)


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


PARALLEL: dict[str, object] = {
    "pair.shaft_angle_deg": 0,
    "gear.helix_angle_deg": -25,
    "gear.cone_angle_deg": -3,
}


ON_PARALLEL_AXES = {
    "helix_angle_deg = 25": "must be -25.0 deg, opposite to that of [pinion], got 25.0: on parallel axes the "
        "members must have opposite hands",
    "helix_angle_deg = -24.9": "must be -25.0 deg, opposite to that of [pinion], got -24.9: on parallel axes "
        "base helix angles must be opposite",
    "cone_angle_deg = 3": "must be -3.0 deg, opposite to that of [pinion], got 3.0: on parallel axes the "
        "cone angles must be opposite",
}  # fmt: skip
"""Change of the gear, and the message after the key."""


@pytest.mark.parametrize(("changed", "message"), ON_PARALLEL_AXES.items())
def test_angles_of_parallel_axes_must_be_opposite(changed: str, message: str) -> None:
    parse_design(toml(PARALLEL))
    key, _, value = changed.partition(" = ")
    assert faults_of({**PARALLEL, f"gear.{key}": value}) == (f"[gear] {key} {message}",)


def test_pressure_angles_on_parallel_axes() -> None:
    """With two pressure angles and one base pitch, only unmodified cylindrical gears are accepted."""
    module = 6.0 * np.cos(np.radians(20.0)) / np.cos(np.radians(22.0))
    tool = {"gear.normal_module": module, "gear.normal_pressure_angle_deg": 22.0}
    spur = {"pinion.cone_angle_deg": 0, "gear.cone_angle_deg": 0, "pinion.helix_angle_deg": 0}
    spur |= {"gear.helix_angle_deg": 0, "pair.shaft_angle_deg": 0}
    design = parse_design(toml({**spur, **tool}))
    assert touches_along_lines(design).all()
    (fault,) = faults_of({**PARALLEL, **tool})
    assert fault.startswith("[gear] normal_pressure_angle_deg must equal that of [pinion], 20.0 deg, got 22")


LENGTHS = "tool.normal_module", "gear.face_width", "pair.offset"
ANGLES = "pinion.helix_angle_deg", "errors.shaft_angle_deg"
UNITS = {
    **dict.fromkeys(LENGTHS, ("0.5 in", "mm", 12.7)),
    **dict.fromkeys(ANGLES, ("0.25 rad", "deg", np.degrees(0.25))),
}


@pytest.mark.parametrize("quoted", [True, False])
@pytest.mark.parametrize("path", [*UNITS, "tool.addendum", "gear.parabola"])
def test_decimal_commas_and_units_are_recognised(path: str, quoted: bool) -> None:
    """The message contains the number to give. Without quotes the file is not valid TOML."""
    table, key = path.split(".")
    texts = [("1,5", "write it with a decimal point, 1.5")]
    if path in UNITS:
        written, unit, size = UNITS[path]
        texts.append((written, f"give it in {unit} without a unit, {size:.10g}"))
    for written, cure in texts:
        faults = faults_of({path: f"'{written}'" if quoted else written})
        assert faults == (f"[{table}] {key} must be a number, got '{written}': {cure}",)


def test_unknown_units() -> None:
    (fault,) = faults_of({"pair.offset": "229 ft"})
    assert fault.startswith("is not valid TOML: ")


def test_tip_diameter_and_tip_alteration() -> None:
    assert faults_of({"pinion.tip_diameter": 206.0, "pinion.tip_alteration": 0.1}) == (
        "[pinion] tip_diameter is given together with tip_alteration: remove one of them",
    )
