"""Inputs from Python: accepted types, stored values, messages for faults."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from math import nan, radians
from typing import Any, TypeVar

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    DesignError,
    Errors,
    Member,
    MeshErrors,
    Pair,
    Tool,
    first_contact,
    from_degrees,
    path_of_contact,
)
from beveloid_geom.design.field_limits import LIMITS
from beveloid_geom.operation.angular_clearance import angular_clearance
from tests.oracle.table1 import table1

T = TypeVar("T")

TABLE = table1()
PINION = TABLE.pinion
TOOL = PINION.tool
KINDS: dict[str, Any] = {
    **{"Tool": TOOL, "Member": PINION, "Pair": TABLE.pair},
    **{"Errors": TABLE.errors, "MeshErrors": MeshErrors()},
}


def changed(given: T, name: str, value: Any) -> T:
    return replace(given, **{name: value})  # type: ignore[type-var]


@pytest.mark.parametrize(
    "value", [np.float32(6.5), np.float16(6.5), np.longdouble(6.5), np.array(6.5), np.array(6.5, np.float32)]
)
def test_numbers_become_floats(value: Any) -> None:
    tool = replace(TOOL, normal_module=value)
    assert type(tool.normal_module) is float
    assert tool == replace(TOOL, normal_module=6.5)
    assert hash(tool) == hash(replace(TOOL, normal_module=6.5))


@pytest.mark.parametrize("value", [29, 29.0, np.int8(29), np.float32(29.0), np.array(29)])
def test_teeth_become_an_int(value: Any) -> None:
    member = replace(PINION, teeth=value)
    assert type(member.teeth) is int
    assert member == PINION


@pytest.mark.parametrize(
    "value", [[0.5, 0.25], (0.5, 0.25), *(np.array([0.5, 0.25], kind) for kind in ("f8", ">f8", "f4", "f2"))]
)
def test_arrays_are_copied_and_read_only(value: Any) -> None:
    errors = Errors(offset=value)
    stored = errors.offset
    assert isinstance(stored, np.ndarray)
    assert stored.dtype == np.dtype(np.float64)
    np.testing.assert_array_equal(stored, [0.5, 0.25])
    if isinstance(value, np.ndarray):
        value[0] = 9.0
        assert stored[0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        stored[0] = 9.0
    assert TABLE.with_errors(errors).batch_shape == (2,)


NUMBER = "write it without quotes, such as 1.5"
WHOLE = "write it without quotes and decimals, such as 29"
DEGREES = "was it given in degrees?"
PLAIN, UNMASK = "must be a number or a plain array", "fill or remove the masked values"
ROUND = "must be between -3.14159 and 3.14159 rad"
BAD: list[tuple[str, str, object, str]] = [
    # not a number
    ("Member", "teeth", 29.5, f"teeth must be a whole number, got 29.5: {WHOLE}"),
    ("Pair", "offset", np.True_, f"offset must be a number, got true: {NUMBER}"),
    ("Pair", "offset", None, f"offset must be a number, got None: {NUMBER}"),
    ("Pair", "offset", np.array([1j]), f"offset must be a number, got array([0.+1.j]): {NUMBER}"),
    ("Pair", "offset", 10**400, f"offset must be a number, got an integer of 1329 bits: {NUMBER}"),
    ("Pair", "offset", ["229"], f"offset must be a number, got ['229']: {NUMBER}"),
    ("Pair", "offset", [[1.0], [1.0, 2.0]], f"offset must be a number, got [[1.0], [1.0, 2.0]]: {NUMBER}"),
    ("Pair", "gear_mounting", "far", f"gear_mounting must be a number, got 'far': {NUMBER}"),
    ("Tool", "parabola", nan, "parabola must be a finite number, got nan: give a number such as 1.5"),
    ("Errors", "offset", np.ma.array([0.1, 0.2], mask=[False, True]), f"offset {PLAIN}, got a masked array: "
     f"{UNMASK}"),
    ("Errors", "offset", [0.1, np.ma.masked], f"offset {PLAIN}, got [0.1, masked]: {UNMASK}"),
    # wider ranges than in files, and angles in degrees
    ("Tool", "normal_module", -6, "normal_module must be between 1e-06 and 1e+06 mm, got -6.0: give a "
     "positive length in mm"),
    ("Pair", "shaft_angle", 15.0, f"shaft_angle {ROUND}, got 15.0: {DEGREES}"),
    ("Member", "helix_angle", -25, "helix_angle must be between -1.39626 and 1.39626 rad, got -25.0: "
     f"{DEGREES}"),
    ("Errors", "shaft_angle", 15.0, "shaft_angle must be between -0.0872665 and 0.0872665 rad, got 15.0: "
     "for another layout, change the shaft angle of the pair"),
    # in a batch
    ("Errors", "offset", [0.0, nan], "offset must be a finite number, got nan at [1]: give a number such as "
     "1.5"),
    ("Member", "teeth", np.array([[29, 30], [31.5, 32]]), "teeth must be a whole number, got 31.5 at [1, 0]: "
     f"{WHOLE}"),
    ("Pair", "shaft_angle", [0.2, 0.3, 15.0], f"shaft_angle {ROUND}, got 15.0 at [2]: {DEGREES}"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name", "value", "message"), BAD, ids=lambda v: str(v)[:30])
def test_message(kind: str, name: str, value: object, message: str) -> None:
    with pytest.raises(DesignError) as caught:
        replace(KINDS[kind], **{name: value})
    assert str(caught.value) == f"{kind}: {message}"


def test_all_faults_are_reported_together() -> None:
    with pytest.raises(ValueError, match=r"^Member: teeth must be .*\nMember: helix_angle must be .*$"):
        Member(TOOL, 0, 25.0, 0.05, 0.0, 50.0)


OTHER: dict[str, tuple[Callable[[], object], str]] = {
    "modules in a batch": (
        lambda: replace(TABLE, pinion=replace(PINION, tool=changed(TOOL, "normal_module", [6.0, 5.0]))),
        "Design: gear normal_module cos(normal_pressure_angle) must equal that of the pinion, 4.69846310393 "
        "mm, got 5.63815572472 at [1]: change module or pressure angle, as meshing teeth need the same base "
        "pitch",
    ),
    "no errors": (
        lambda: replace(TABLE, errors=None),  # type: ignore[arg-type]
        "Design: errors must be of the class Errors, got None: create it with Errors(...)",
    ),
}


@pytest.mark.parametrize(("make", "message"), OTHER.values(), ids=OTHER)
def test_objects_that_do_not_fit_each_other(make: Callable[[], object], message: str) -> None:
    with pytest.raises(DesignError) as caught:
        make()
    assert str(caught.value) == message


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind in LIMITS for name in LIMITS[kind]])
def test_python_accepts_the_limits_of_files(kind: str, name: str) -> None:
    """Python accepts both ends of the range of each quantity of a design file, with angles in rad."""
    limit = LIMITS[kind][name]
    for end in (limit.low, limit.high):
        value = radians(end) if limit.unit == "deg" else end
        assert getattr(replace(KINDS[kind], **{name: value}), name) == value


def test_inputs_with_a_named_status_are_accepted() -> None:
    """Python accepts inputs for which results have a status: parallel axes, shaft angles out of range,
    folding parabolas, steep cones, large offsets."""
    for pair in (Pair(229.0, 0.0), Pair(229.0, -0.26), Pair(229.0, 1.7), Pair(9e4, 0.26)):
        assert replace(TABLE, pair=pair).batch_shape == ()
    assert TABLE.with_parabola(-0.5, 10.0).with_errors(Errors(offset=500.0)).batch_shape == ()
    assert isinstance(replace(PINION, cone_angle=radians(45.0), helix_angle=radians(80.0)), Member)
    assert isinstance(Design(PINION, replace(PINION, tool=Tool(6.0, radians(20.0))), TABLE.pair), Design)


ARGUMENTS: dict[str, Callable[[Any], object]] = {
    "l1": lambda x: path_of_contact(TABLE, l1=x),
    "pinion_roll": lambda x: first_contact(TABLE, "right", x),
    "gear_roll": lambda x: angular_clearance(TABLE, "right", 0, 0.0, 0.0, 0.1, x),
    "z": lambda x: angular_clearance(TABLE, "right", 0, 0.0, x, 0.1, 0.1),
}


@pytest.mark.parametrize(("name", "call"), ARGUMENTS.items(), ids=ARGUMENTS)
def test_arguments_must_be_numbers(name: str, call: Callable[[Any], object]) -> None:
    """Text and masked arrays are rejected."""
    for value, shown in ((["0.1"], "['0.1']"), ([True], "[True]"), ([0.1j], "[0.1j]")):
        with pytest.raises(ValueError) as caught:  # noqa: PT011
            call(value)
        assert str(caught.value) == f"{name} must be a number, got {shown}: {NUMBER}"
    with pytest.raises(ValueError, match=f"^{name} {PLAIN}, got a masked array: {UNMASK}$"):
        call(np.ma.array([0.1, 0.2], mask=[True, False]))


BATCH = TABLE.with_errors(Errors(offset=np.array([0.0, 0.1])))


@pytest.mark.parametrize("made", [lambda x: pickle.loads(pickle.dumps(x)), deepcopy], ids=["pickle", "copy"])
@pytest.mark.parametrize("design", [TABLE, BATCH], ids=["single", "batch"])
def test_copies_are_equal_and_read_only(design: Design, made: Callable[[Design], Design]) -> None:
    assert design.batch_shape == made(design).batch_shape
    again = made(design)
    assert again == design
    assert again is not design
    if design is BATCH:
        with pytest.raises(ValueError, match="read-only"):
            again.errors.offset[0] = 1.0  # type: ignore[index]


def test_equal_designs() -> None:
    """Designs are compared by value. Designs of plain numbers are hashable."""
    assert table1() == TABLE
    assert hash(table1()) == hash(TABLE)
    assert table1((0.001, 0.0)) != TABLE
    assert TABLE.with_errors(Errors(offset=np.array([0.0, 0.1]))) == BATCH
    assert TABLE.with_errors(Errors(offset=np.array([0.0, 0.2]))) != BATCH
    assert TABLE.with_errors(Errors(offset=np.array([0.0, 0.1, 0.0]))) != BATCH
    assert TABLE != BATCH
    assert TABLE != "a design"
    with pytest.raises(TypeError, match="unhashable"):
        hash(BATCH)


def test_degrees_can_be_given() -> None:
    """Angles can be given in degrees as numbers and arrays, as in a design file."""
    turned = from_degrees(Pair, offset=200.0, shaft_angle_deg=[10.0, 20.0])
    np.testing.assert_allclose(turned.shaft_angle, np.radians([10.0, 20.0]), rtol=1e-15)
    assert not np.asarray(turned.shaft_angle).flags.writeable
    assert from_degrees(Errors, shaft_angle_deg=0.5, offset=0.1) == Errors(0.1, radians(0.5))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"offset_deg": 1.0}, "offset_deg is not an angle of Errors: give one of shaft_angle_deg"),
        ({"shaft_angle_deg": 1.0, "shaft_angle": 0.1}, "shaft_angle_deg is given twice, in deg and in rad"),
        ({"shaft_angle_deg": "wide"}, "shaft_angle must be a number"),
    ],
)
def test_degrees_are_accepted_for_angles_only(values: dict[str, Any], message: str) -> None:
    with pytest.raises(DesignError, match=re.escape(message)):
        from_degrees(Errors, **values)
