"""Inputs of a design by name: their values, and designs with other values.

An input is named as in INPUTS. PRESETS are the usual pairs of inputs: the parabola coefficients, changes of
the mounting distances, and the profile shift coefficients of both members."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from operator import attrgetter
from typing import Any, TypeAlias

from ..arrays import Quantity
from ..design.field_limits import DesignError
from ..design.limits import member_faults
from ..design.member import unchecked
from ..design.model import Design
from ..support.argument import ArgumentError
from .mounting import mounting_of

Bounds: TypeAlias = tuple[float, float]
Inputs: TypeAlias = tuple[str, str]
INPUTS: dict[str, tuple[str, str]] = {
    f"{name}_{member}": (f"{member}.{attribute}", unit)
    for member in ("pinion", "gear")
    for name, attribute, unit in (
        ("parabola", "tool.parabola", "1/mm"),
        ("parabola_apex", "tool.parabola_apex", "mm"),
        ("profile_shift", "profile_shift", ""),
        ("helix_angle", "helix_angle", "rad"),
        ("cone_angle", "cone_angle", "rad"),
        ("face_width", "face_width", "mm"),
        ("tip_alteration", "tip_alteration", ""),
    )
} | {
    "pinion_mounting_change": ("pair.pinion_mounting", "mm"),
    "gear_mounting_change": ("pair.gear_mounting", "mm"),
    "offset": ("pair.offset", "mm"),
    "shaft_angle": ("pair.shaft_angle", "rad"),
}
"""Attribute of the design and unit of each input; coefficients without unit are in normal modules. Mounting
distances are given as changes."""
PRESETS: dict[str, Inputs] = {
    "parabola": ("parabola_pinion", "parabola_gear"),
    "mounting": ("pinion_mounting_change", "gear_mounting_change"),
    "shift": ("profile_shift_pinion", "profile_shift_gear"),
}


def inputs_of(over: str | Inputs) -> Inputs:
    """Return the names of two inputs, given by a preset or by both names. Raises ArgumentError for others."""
    first, second = PRESETS.get(over, ("", "")) if isinstance(over, str) else over
    if first == second or not {first, second} <= set(INPUTS):
        presets, names = ", ".join(PRESETS), ", ".join(INPUTS)
        shown = over if isinstance(over, str) else ",".join(over)
        text = f"must be one of {presets}, or two different inputs of {names}, got {shown!r}"
        raise ArgumentError("over", text)
    return first, second


def own_values(design: Design, over: str | Inputs, flank: str = "right") -> tuple[float, float]:
    """Return the values of both inputs of a single design, its position on a map (`analysis.maps`).

    Parameters
    ----------
    design : Design
        A single design.
    over : str or Inputs
        Names of two inputs.
    flank : {'right', 'left'}
        Flank of parabola coefficients.

    Returns
    -------
    tuple of float
        mm, rad, 1/mm or modules, see INPUTS.
    """
    names = inputs_of(over)
    first, second = (_own_value(design, name, flank) for name in names)
    return first, second


def _own_value(design: Design, name: str, flank: str) -> float:
    """Return the value of an input in a single design."""
    if name.endswith("mounting_change"):
        return 0.0
    part, _, attribute = INPUTS[name][0].partition(".")
    if attribute == "tool.parabola":
        return float(getattr(design, part).tool.parabola_of(flank))
    return float(attrgetter(attribute)(getattr(design, part)))


def design_at(design: Design, over: str | Inputs, first: Quantity, second: Quantity) -> Design:
    """Return a design with other values of two inputs.

    Parameters
    ----------
    design : Design
        A single design.
    over : str or Inputs
        Names of two inputs.
    first, second : float or ndarray
        Values in mm, rad, 1/mm or modules, see INPUTS; arrays broadcast.

    Returns
    -------
    Design
    """
    for name, value in zip(inputs_of(over), (first, second), strict=True):
        if name.endswith("mounting_change"):
            # Both distances are fixed, so that the change of one does not move the other member.
            one, other = mounting_of(design).distance  # NaN without a layout
            one, other = (one + value, other) if name.startswith("pinion") else (one, other + value)
            design = replace(design, pair=unchecked(design.pair, pinion_mounting=one, gear_mounting=other))
        else:
            design = _replaced(design, INPUTS[name][0], value)
    return design


def _replaced(part: Any, attribute: str, value: Quantity) -> Any:
    """Return a dataclass with another value of an attribute such as 'pinion.tool.parabola'; a parabola
    coefficient is set on both flanks."""
    if attribute == "parabola":
        return part.with_parabola(value)
    name, _, inner = attribute.partition(".")
    return replace(part, **{name: _replaced(getattr(part, name), inner, value) if inner else value})


def bounds_argument(name: str) -> str:
    """Return the argument of an `ArgumentError` for the bounds of an input."""
    return f"bounds of {name}"


def bound_faults(design: Design, over: Inputs, bounds: tuple[Bounds, ...]) -> Iterator[ArgumentError]:
    """Yield the faults of bounds outside the limits of their input, and the faults that members have at the
    bounds but not in the design."""
    for name, limits in zip(over, bounds, strict=True):
        argument = bounds_argument(name)
        if name.startswith("profile_shift") and max(map(abs, limits)) > 3.0:
            yield ArgumentError(argument, f"must be between -3 and 3, got {limits[0]:g}, {limits[1]:g}")
        attribute = INPUTS[name][0]
        part = attribute.partition(".")[0]
        # A change of a mounting distance has no limits.
        for bound in () if name.endswith("mounting_change") else limits:
            try:
                changed = getattr(_replaced(design, attribute, float(bound)), part)
            except DesignError as error:
                yield from (ArgumentError(argument, fault.text) for fault in error.parts)
                continue
            if part in ("pinion", "gear"):
                known = {str(fault) for fault in member_faults(part, getattr(design, part))}
                faults = (text for text in map(str, member_faults(part, changed)) if text not in known)
                yield from (ArgumentError(argument, f"cannot be used: {text}") for text in faults)
