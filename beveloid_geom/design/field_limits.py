"""Limits of the single quantities of a design: one table for both its doors, files and Python.

A design file gives angles in deg, under keys that end in `_deg`; inputs from Python are in rad. All
that has no meaning is refused at both doors, in the same words, each of which names the quantity, its
limit, the value and the likely cure: wrong types, NaN, lengths that are not positive, parts of a tooth,
angles that must have been meant in the other unit, members of different base pitch.

Python takes more than a file where the solver has a named answer, so that such cases can be studied:

- a quantity whose `Limit` has a `least` or a `most` of its own;
- base pitches that differ by a digit noted too few (`inputs.ROUNDED_PITCH`);
- what else joins several quantities in `design.limits`: a parabola that folds the
  profile, a tip round that eats the flank, a cone too steep for the tool, helix angles that cancel,
  errors greater than the layout bears, angles that do not fit one another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

MIN_FLANK_DEPTH = 0.5  # modules; profile shift moves the pitch point about that far
GREATEST = float(np.finfo(float).max)
IN_RADIANS, IN_DEGREES = "was it given in radians?", "was it given in degrees?"


class Fault(NamedTuple):
    """What is wrong with one key of a design, as a line: [table] key text. From Python the table is ''."""

    table: str
    key: str
    text: str

    def __str__(self) -> str:
        return " ".join(part for part in (self.table and f"[{self.table}]", self.key, self.text) if part)


class DesignError(ValueError):
    """A design that cannot be used; the message has one line for every fault."""

    def __init__(self, faults: Iterable[Fault | str], source: str = "") -> None:
        """`faults` are what is wrong, a text alone where that is no key; `source` (a file, a class) leads
        each line of the message."""
        self.parts = tuple(Fault("", "", fault) if isinstance(fault, str) else fault for fault in faults)
        self.source = source
        super().__init__(self.parts, source)

    @property
    def faults(self) -> tuple[str, ...]:
        """The lines of the message, without its source."""
        return tuple(map(str, self.parts))

    def __str__(self) -> str:
        """The lines of the message."""
        lead = f"{self.source}: " if self.source else ""
        return "\n".join(lead + fault for fault in self.faults)


def shown_value(value: object) -> str:
    """Give a value on one short line, as TOML writes it."""
    if isinstance(value, bool | np.bool_):
        return str(value).lower()
    if isinstance(value, int) and value.bit_length() > 100:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, np.ma.MaskedArray):
        return "a masked array"
    text = " ".join(repr(value.item() if isinstance(value, np.generic) else value).split())
    return text if len(text) <= 40 else text[:37] + "..."


def refused(limit: str, value: object, cure: str, place: str = "") -> str:
    """Give the words for a value outside its limit ('be between ...'); `place` (' at [3]') is where in a
    batch."""
    return f"must {limit}, got {shown_value(value)}{place}: {cure}"


class Limit(NamedTuple):
    """Closed range of one quantity in a design file, angles in deg, and what may be wrong outside: the
    cure offered is the first whose bound is not below the value. From Python the range ends at `least`
    and `most` instead, if these are given."""

    low: float
    high: float
    unit: str
    cures: tuple[tuple[float, str], ...]
    least: float | None = None
    most: float | None = None
    whole: bool = False
    optional: bool = False

    def fault(self, value: float, place: str = "") -> str | None:
        """Give the words for a value outside, None for one within."""
        if self.low <= value <= self.high:
            return None
        unit = f" {self.unit}" if self.unit else ""
        cure = next(text for bound, text in self.cures if value <= bound)
        other = {"deg": (180.0 / math.pi, IN_RADIANS), "rad": (math.pi / 180.0, IN_DEGREES)}.get(self.unit)
        if other and value * other[0] != 0.0 and self.low <= value * other[0] <= self.high:
            cure = other[1]
        return refused(f"be between {self.low:g} and {self.high:g}{unit}", value, cure, place)

    @property
    def from_python(self) -> Limit:
        """The range from Python, angles in rad."""
        low = self.low if self.least is None else self.least
        high = self.high if self.most is None else self.most
        if self.unit != "deg":
            return self._replace(low=low, high=high)
        cures = tuple((math.radians(bound), text) for bound, text in self.cures)
        return self._replace(low=math.radians(low), high=math.radians(high), unit="rad", cures=cures)


NUMBER = "a number", "give it like 1.5, without quotes"
WHOLE = "a whole number", "give it like 29, without quotes or decimals"
FINITE = "a finite number", "give the value itself"
"""What a value must be, and the cure if it is not."""

_ANY = math.inf
_POSITIVE = ((_ANY, "give a positive length in mm"),)
_OFFSET = ((_ANY, "give the distance of the axes in mm, 0 where they intersect"),)
_MODULES = ((_ANY, "it counts in normal modules, not in mm"),)
_PRESSURE = ((0.0, "it is positive on both flanks"), (_ANY, "tools usually have 14.5 to 30 deg"))
_TEETH = (
    (-1.0, "internal gears are not covered"),
    (0.0, "a member has at least one tooth"),
    (_ANY, "a rack is not covered by this model"),
)
_HELIX = ((_ANY, "measure it from the axis, right hand positive; the lead angle is 90 deg less it"),)
_CONE = (
    (_ANY, "it is half the angle of the pitch cone, positive if the tooth grows towards the heel at +z"),
)
_SHAFT = (
    (0.0, "give its magnitude, its sense follows from the helix angles"),
    (_ANY, "it is the smaller angle of the two axes, take 180 deg less it"),
)
_LAYOUT = ((_ANY, "change the shaft angle of the pair if another layout is meant"),)
_AXIAL = ((_ANY, "give it in mm, positive towards the heel"),)
_FREE = Limit(-GREATEST, GREATEST, "", ())

LIMITS: dict[str, dict[str, Limit]] = {
    "Tool": {
        "normal_module": Limit(0.01, 100, "mm", _POSITIVE, least=1e-6, most=1e6),
        "normal_pressure_angle": Limit(5, 45, "deg", _PRESSURE),
        "addendum": Limit(0.1, 4, "", _MODULES, least=0, most=10),
        "dedendum": Limit(MIN_FLANK_DEPTH, 4, "", _MODULES, least=0, most=10),
        "tip_radius": Limit(0, 4, "", _MODULES, most=10),
        "parabola": _FREE,
    },
    "Member": {
        "teeth": Limit(1, 2000, "", _TEETH, whole=True),
        "helix_angle": Limit(-80, 80, "deg", _HELIX),
        "cone_angle": Limit(-45, 45, "deg", _CONE),
        "profile_shift": Limit(-3, 3, "", _MODULES, least=-10, most=10),
        "face_width": Limit(0.01, 1e4, "mm", _POSITIVE, least=1e-9, most=1e9),
    },
    "Pair": {
        "offset": Limit(0, 1e5, "mm", _OFFSET, most=1e9),
        "shaft_angle": Limit(0, 90, "deg", _SHAFT, least=-180, most=180),
        "pinion_mounting": Limit(-1e5, 1e5, "mm", _AXIAL, least=-1e9, most=1e9, optional=True),
        "gear_mounting": Limit(-1e5, 1e5, "mm", _AXIAL, least=-1e9, most=1e9, optional=True),
    },
    "Errors": {
        "offset": _FREE,
        "shaft_angle": Limit(-5, 5, "deg", _LAYOUT),
        "pinion_axial": Limit(-1000, 1000, "mm", _AXIAL),
        "gear_axial": Limit(-1000, 1000, "mm", _AXIAL),
    },
    "MeshErrors": {
        "centre_distance": _FREE,
        "in_plane": Limit(-5, 5, "deg", _LAYOUT),
        "out_of_plane": Limit(-5, 5, "deg", _LAYOUT),
        "pinion_axial": Limit(-1000, 1000, "mm", _AXIAL),
        "gear_axial": Limit(-1000, 1000, "mm", _AXIAL),
    },
}
"""Limits by the class of `design.model` and its fields."""
_FROM_PYTHON = {
    kind: {name: limit.from_python for name, limit in limits.items()} for kind, limits in LIMITS.items()
}


def take(kind: str, values: dict[str, Any]) -> None:
    """Check the quantities of an input of the class `kind` by its LIMITS, and put in their place what is
    calculated with: a float (teeth: an int), or a read-only copy as float64, which nobody can change.

    Raises DesignError with every fault found."""
    faults = []
    for name, limit in _FROM_PYTHON[kind].items():
        value = values[name]
        if type(value) is (int if limit.whole else float) and limit.low <= value <= limit.high:
            continue
        if value is None and limit.optional:
            continue
        found = _taken(value, limit)
        if isinstance(found, str):
            faults.append(Fault("", name, found))
        else:
            values[name] = found
    if faults:
        raise DesignError(faults, kind)


def in_radians(kind: str, values: dict[str, Any]) -> dict[str, Any]:
    """Give inputs of the class `kind` with angles in rad, of which some came in deg as `helix_angle_deg`.

    Raises DesignError for a quantity that is no angle, or that is given twice."""
    limits, found, faults = _FROM_PYTHON[kind], {}, []
    for name, value in values.items():
        plain = name.removesuffix("_deg")
        if plain != name and (plain not in limits or limits[plain].unit != "rad"):
            angles = ", ".join(f"{key}_deg" for key, limit in limits.items() if limit.unit == "rad")
            faults.append(Fault("", name, f"is no angle of {kind}: give one of {angles}"))
        elif plain in found or (plain != name and plain in values):
            faults.append(Fault("", name, "is given twice, in deg and in rad: leave one out"))
        else:
            degrees = plain != name and not isinstance(value, bool | str)
            found[plain] = np.multiply(value, math.pi / 180.0)[()] if degrees else value
    if faults:
        raise DesignError(faults, kind)
    return found


def _taken(value: object, limit: Limit) -> float | NDArray[np.float64] | str:
    """Give a value as it is calculated with, or the words for what is wrong with it."""
    given = _as_float64(value, WHOLE if limit.whole else NUMBER)
    if isinstance(given, str):
        return given
    bad = ~((given >= limit.low) & (given <= limit.high))
    if limit.whole:
        bad |= given % 1.0 != 0.0
    if bad.any():
        index = np.argwhere(bad)[0].tolist()
        return _fault_of(given[tuple(index)].item(), limit, f" at {index}" if index else "")
    if given.ndim:
        given.flags.writeable = False
        return given
    return int(given) if limit.whole else float(given)


def _as_float64(value: object, kind: tuple[str, str]) -> NDArray[np.float64] | str:
    """Give a copy as float64, or the words for what is no number, and no row of numbers."""
    parts = value if isinstance(value, list | tuple) else (value,)
    if any(isinstance(part, np.ma.MaskedArray) for part in parts):
        return refused("be a number or a plain array", value, "fill it, or take the cases that it shows")
    try:
        given = np.asarray(value)
    except ValueError:  # lists of several lengths
        return refused(f"be {kind[0]}", value, kind[1])
    if given.dtype.kind not in "iuf":
        return refused(f"be {kind[0]}", value, kind[1])
    return np.array(given, dtype=np.float64)


def float64_of(name: str, value: object) -> NDArray[np.float64]:
    """Give the argument `name` of a function as float64. Raises ValueError for what is no real number, and no
    row of them."""
    found = _as_float64(value, NUMBER)
    if isinstance(found, str):
        raise ValueError(f"{name} {found}")
    return found


def number_fault(value: object, limit: Limit) -> str | None:
    """Say what is wrong with a value of a design file, None for a number within its limit."""
    name, cure = WHOLE if limit.whole else NUMBER
    if isinstance(value, bool) or not isinstance(value, int if limit.whole else int | float):
        return refused(f"be {name}", value, cure)
    if limit.whole:
        return limit.fault(value)
    if isinstance(value, int) and abs(value) > GREATEST:  # no float holds it
        return refused(f"be {name}", value, cure)
    return _fault_of(float(value), limit, "") or None


def _fault_of(value: float, limit: Limit, place: str) -> str:
    if not math.isfinite(value):
        return refused(f"be {FINITE[0]}", value, FINITE[1], place)
    if limit.whole and not value.is_integer():
        return refused(f"be {WHOLE[0]}", value, WHOLE[1], place)
    return limit.fault(int(value) if limit.whole else value, place) or ""


def base_pitch_fault(
    pitches: tuple[Any, Any], apart: float, suffix: str, table: str, other: str
) -> Fault | None:
    """Find what is wrong with m_n cos(alpha_n), mm, of pinion and gear, if more than a share `apart` of it
    lies between them; `suffix` is that of angles, `table` and `other` name gear and pinion."""
    first, second = pitches
    bad = abs(first - second) > apart * abs(first)
    if not np.any(bad):
        return None
    index = np.argwhere(bad)[0].tolist()
    first, second = (float(np.broadcast_to(pitch, np.shape(bad))[tuple(index)]) for pitch in pitches)
    limit, got = f"equal that of {other}, {first:.12g} mm", float(f"{second:.12g}")
    text = refused(limit, got, "teeth that mesh share their base pitch", f" at {index}" if index else "")
    return Fault(table, f"normal_module cos(normal_pressure_angle{suffix})", text)
