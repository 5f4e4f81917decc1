"""Limits of single quantities of a design, for design files and for Python.

A design file gives angles in deg, under keys that end in `_deg`; inputs from Python are in rad. Both are
checked by the same function, `checked`, with the same messages. Each message names the quantity, its limit,
the value and the likely cure. Rejected are wrong types, NaN, lengths that are not positive, fractions of a
tooth, and angles that were probably given in the other unit.

Inputs from Python may exceed the limits of a file if results have a status code for such cases, so that they
can be studied:

- a wider range, if the `FieldLimit` has a `least` or a `most`;
- base pitches that differ by the rounding of a few digits (`model.Design`);
- the combinations of several quantities in `design.limits`, such as a parabola that folds the profile.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.frozen_arrays import restored
from .written_numbers import (
    IN_RADIANS,
    MM_PER_INCH,
    RAD_PER_DEGREE,
    number_cure,
    refused as refused,
)

MIN_FLANK_DEPTH_MODULES = 0.5
"""Least depth of the tool flank below its reference line, in modules. Usual profile shifts move the pitch
point by up to about this depth."""


class Fault(NamedTuple):
    """Fault of one key of a design: `table` and `key` of the design file, and the message.

    For inputs from Python the table is ''."""

    table: str
    key: str
    text: str

    def __str__(self) -> str:
        return " ".join(part for part in (self.table and f"[{self.table}]", self.key, self.text) if part)


class DesignError(ValueError):
    """Design that cannot be used; the message has one line for each different fault."""

    def __init__(self, faults: Iterable[Fault | str], source: str = "") -> None:
        """Store the faults.

        Parameters
        ----------
        faults : iterable of Fault or str
            A fault that does not belong to a key is a text.
        source : str
            File or class, printed at the beginning of each line of the message.
        """
        parts = (Fault("", "", fault) if isinstance(fault, str) else fault for fault in faults)
        self.parts = tuple(dict.fromkeys(parts))
        self.source = source
        super().__init__(self.parts, source)

    @property
    def faults(self) -> tuple[str, ...]:
        """The lines of the message, without the source."""
        return tuple(map(str, self.parts))

    def __str__(self) -> str:
        """Return the lines of the message."""
        lead = f"{self.source}: " if self.source else ""
        return "\n".join(lead + fault for fault in self.faults)


class FieldLimit(NamedTuple):
    """Closed range of one quantity in a design file; angles in deg.

    `cure` is the advice for a rejected value. `cures` are pairs (bound, text) in rising order of the bounds;
    the text of the first bound that is not below the value replaces `cure`. `least` and `most` replace the
    range for inputs from Python. `integer` quantities are whole numbers; `optional` ones may be None."""

    low: float
    high: float
    unit: str
    cure: str
    cures: tuple[tuple[float, str], ...] = ()
    least: float | None = None
    most: float | None = None
    integer: bool = False
    optional: bool = False

    def fault(self, value: float, place: str = "") -> str | None:
        """Return the message for a value outside the range, None for a value inside."""
        if self.low <= value <= self.high:
            return None
        unit = f" {self.unit}" if self.unit else ""
        cure = next((text for bound, text in self.cures if value <= bound), self.cure)
        # A value that lies inside the range in another unit was probably given in that unit.
        other = {
            "deg": (1.0 / RAD_PER_DEGREE, IN_RADIANS),
            "rad": (RAD_PER_DEGREE, "was it given in degrees?"),
            "mm": (MM_PER_INCH, "was it given in inches?"),
        }.get(self.unit)
        if other and value * other[0] != 0.0 and self.low <= value * other[0] <= self.high:
            cure = other[1]
        return refused(f"be between {self.low:g} and {self.high:g}{unit}", value, cure, place)

    @property
    def kind(self) -> tuple[str, str]:
        """Description of the required value, and the cure for another one."""
        if self.integer:
            return "a whole number", "write it without quotes and decimals, such as 29"
        return "a number", "write it without quotes, such as 1.5"

    @property
    def from_python(self) -> FieldLimit:
        """The range for inputs from Python, angles in rad."""
        low = self.low if self.least is None else self.least
        high = self.high if self.most is None else self.most
        if self.unit != "deg":
            return self._replace(low=low, high=high)
        cures = tuple((math.radians(bound), text) for bound, text in self.cures)
        return self._replace(low=math.radians(low), high=math.radians(high), unit="rad", cures=cures)


_POSITIVE = "give a positive length in mm"
_MODULES = "give it in normal modules, not in mm"
_LAYOUT = "for another layout, change the shaft angle of the pair"
_AXIAL = "give it in mm, positive towards +z"
_FREE = FieldLimit(-sys.float_info.max, sys.float_info.max, "", "")
_FREE_LENGTH = _FREE._replace(unit="mm")

LIMITS: dict[str, dict[str, FieldLimit]] = {
    "Tool": {
        "normal_module": FieldLimit(0.01, 100, "mm", _POSITIVE, least=1e-6, most=1e6),
        "normal_pressure_angle": FieldLimit(
            5, 45, "deg", "usual tools have 14.5 to 30 deg", ((0.0, "the pressure angle is positive"),)
        ),
        "addendum": FieldLimit(0.1, 4, "", _MODULES, least=0, most=10),
        "dedendum": FieldLimit(MIN_FLANK_DEPTH_MODULES, 4, "", _MODULES, least=0, most=10),
        "tip_radius": FieldLimit(0, 4, "", _MODULES, most=10),
        "parabola": _FREE,
        "parabola_right": _FREE._replace(optional=True),
        "parabola_left": _FREE._replace(optional=True),
        "parabola_apex": _FREE_LENGTH,
    },
    "Member": {
        "teeth": FieldLimit(
            1,
            2000,
            "",
            "racks are not supported",
            ((-1.0, "internal gears are not supported"), (0.0, "a member has at least one tooth")),
            integer=True,
        ),
        "helix_angle": FieldLimit(
            -80,
            80,
            "deg",
            "measure it from the axis, right hand positive; it is the complement of the lead angle",
        ),
        "cone_angle": FieldLimit(
            -45,
            45,
            "deg",
            "it is half the angle of the pitch cone, positive if the tooth grows towards +z",
        ),
        "profile_shift": FieldLimit(-3, 3, "", _MODULES, least=-10, most=10),
        "face_width": FieldLimit(0.01, 1e4, "mm", _POSITIVE, least=1e-9, most=1e9),
        "tip_alteration": FieldLimit(-3, 3, "", _MODULES, least=-10, most=10),
    },
    "Pair": {
        "offset": FieldLimit(
            0, 1e5, "mm", "give the distance of the axes in mm, 0 where they intersect", most=1e9
        ),
        "shaft_angle": FieldLimit(
            0,
            90,
            "deg",
            "it is the smaller angle between the axes, give 180 deg minus this angle",
            ((0.0, "give the magnitude, the sense follows from the helix angles"),),
            least=-180,
            most=180,
        ),
        "pinion_mounting": FieldLimit(-1e5, 1e5, "mm", _AXIAL, least=-1e9, most=1e9, optional=True),
        "gear_mounting": FieldLimit(-1e5, 1e5, "mm", _AXIAL, least=-1e9, most=1e9, optional=True),
    },
    "Errors": {
        "offset": _FREE_LENGTH,
        "shaft_angle": FieldLimit(-5, 5, "deg", _LAYOUT),
        "pinion_axial": FieldLimit(-1000, 1000, "mm", _AXIAL),
        "gear_axial": FieldLimit(-1000, 1000, "mm", _AXIAL),
    },
    "MeshErrors": {
        "centre_distance": _FREE_LENGTH,
        "in_plane": FieldLimit(-5, 5, "deg", _LAYOUT),
        "out_of_plane": FieldLimit(-5, 5, "deg", _LAYOUT),
        "pinion_axial": FieldLimit(-1000, 1000, "mm", _AXIAL),
        "gear_axial": FieldLimit(-1000, 1000, "mm", _AXIAL),
    },
}
"""Limits by class of `design.member` or `design.model`, and by field."""
_FROM_PYTHON = {
    kind: {name: limit.from_python for name, limit in limits.items()} for kind, limits in LIMITS.items()
}


class Input:
    """Base class of the inputs of a design. The quantities of those in `LIMITS` are checked."""

    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError with all faults."""
        kind = type(self).__name__
        if faults := take(_FROM_PYTHON[kind], vars(self)):
            raise DesignError(faults, kind)


def take(limits: Mapping[str, FieldLimit], values: dict[str, Any]) -> list[Fault]:
    """Replace the quantities of an input by the values for the calculation, and return the faults of others.

    Parameters
    ----------
    limits : mapping
        Limits of the quantities by name.
    values : dict
        Quantities by name; replaced in place by a float (teeth: an int) or a read-only float64 copy.

    Returns
    -------
    list of Fault
    """
    faults = []
    for name, limit in limits.items():
        value = values[name]
        if type(value) is (int if limit.integer else float) and limit.low <= value <= limit.high:
            continue
        if value is None and limit.optional:
            continue
        result = checked(value, limit)
        if isinstance(result, str):
            faults.append(Fault("", name, result))
        else:
            values[name] = result
    return faults


def in_radians(kind: str, values: dict[str, Any]) -> dict[str, Any]:
    """Return the inputs of a class with all angles in rad; angles in deg have names such as
    `helix_angle_deg`.

    Raises DesignError for a name with `_deg` that is not an angle, and for an angle that is given twice."""
    limits, faults = _FROM_PYTHON[kind], []
    converted: dict[str, Any] = {}
    for name, value in values.items():
        plain = name.removesuffix("_deg")
        if plain != name and (plain not in limits or limits[plain].unit != "rad"):
            angles = ", ".join(f"{key}_deg" for key, limit in limits.items() if limit.unit == "rad")
            faults.append(Fault("", name, f"is not an angle of {kind}: give one of {angles}"))
        elif plain in converted or (plain != name and plain in values):
            faults.append(Fault("", name, "is given twice, in deg and in rad: leave one out"))
        else:
            degrees = plain != name and not isinstance(value, bool | str)
            converted[plain] = np.multiply(value, math.pi / 180.0)[()] if degrees else value
    if faults:
        raise DesignError(faults, kind)
    return converted


def checked(value: object, limit: FieldLimit) -> float | NDArray[np.float64] | str:
    """Return a value for the calculation: a float, an int, or a read-only float64 copy of an array.

    If the value is not a number or outside its limit, return the message instead."""
    kind = limit.kind
    if isinstance(value, str) and (cure := number_cure(value, limit.unit)):
        kind = kind[0], cure
    given = _as_float64(value, kind)
    if isinstance(given, str):
        return given
    bad = ~((given >= limit.low) & (given <= limit.high))
    if limit.integer:
        bad |= given != np.rint(given)
    if bad.any():
        index = np.argwhere(bad)[0].tolist()
        return _outside_range(given[tuple(index)].item(), limit, f" at {index}" if index else "")
    if given.ndim:
        given.flags.writeable = False
        return given
    return int(given) if limit.integer else float(given)


def number_fault(value: object, limit: FieldLimit) -> str | None:
    """Return the message for a value of a design file or an option, None for a number within its limit."""
    if isinstance(value, list):  # files have no arrays
        kind, cure = limit.kind
        return refused(f"be {kind}", value, cure)
    result = checked(value, limit)
    return result if isinstance(result, str) else None


def _as_float64(value: object, kind: tuple[str, str]) -> NDArray[np.float64] | str:
    """Return a float64 copy, or the message for a value that is neither a number nor an array of numbers."""
    parts = value if isinstance(value, list | tuple) else (value,)
    if any(isinstance(part, np.ma.MaskedArray) for part in parts):
        return refused("be a number or a plain array", value, "fill or remove the masked values")
    try:
        given = np.asarray(value)
    except ValueError:  # lists of different lengths
        return refused(f"be {kind[0]}", value, kind[1])
    if given.dtype.kind not in "iuf":
        return refused(f"be {kind[0]}", value, kind[1])
    return np.array(given, dtype=np.float64)


def float64_of(name: str, value: object) -> NDArray[np.float64]:
    """Return the argument `name` of a function as float64.

    Raises ValueError for a value that is neither a real number nor an array of real numbers."""
    array = _as_float64(value, _FREE.kind)
    if isinstance(array, str):
        raise ValueError(f"{name} {array}")
    return array


def _outside_range(value: float, limit: FieldLimit, place: str) -> str:
    """Return the message for a number that is not finite, not whole, or outside the range."""
    # Required kind of value, and the cure for another one.
    finite = "a finite number", "give a number such as 1.5"
    if not math.isfinite(value):
        return refused(f"be {finite[0]}", value, finite[1], place)
    if limit.integer and not value.is_integer():
        return refused(f"be {limit.kind[0]}", value, limit.kind[1], place)
    return limit.fault(int(value) if limit.integer else value, place) or ""


def base_pitch_fault(
    pitches: tuple[Any, Any], tolerance: float, suffix: str, table: str, other: str
) -> Fault | None:
    """Return the fault of base pitches that differ by more than a relative `tolerance`, otherwise None.

    Parameters
    ----------
    pitches : tuple
        m_n cos(alpha_n) of pinion and gear, mm.
    tolerance : float
        Relative tolerance.
    suffix : str
        Suffix of angles in the message, '_deg' or ''.
    table, other : str
        Names of gear and pinion in the message.
    """
    first, second = pitches
    bad = abs(first - second) > tolerance * abs(first)
    if not np.any(bad):
        return None
    index = np.argwhere(bad)[0].tolist()
    first, second = (float(np.broadcast_to(pitch, np.shape(bad))[tuple(index)]) for pitch in pitches)
    limit, value = f"equal that of {other}, {first:.12g} mm", float(f"{second:.12g}")
    cure = "change module or pressure angle, as meshing teeth need the same base pitch"
    text = refused(limit, value, cure, f" at {index}" if index else "")
    return Fault(table, f"normal_module cos(normal_pressure_angle{suffix})", text)


def require_classes(owner: object, **kinds: type) -> None:
    """Raise DesignError if a field of `owner` is not an object of the class given for it."""
    faults = [
        f"{name} {refused(f'be of the class {kind.__name__}', value, f'create it with {kind.__name__}(...)')}"
        for name, kind in kinds.items()
        if not isinstance(value := getattr(owner, name), kind)
    ]
    if faults:
        raise DesignError(faults, type(owner).__name__)
