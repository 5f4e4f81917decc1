"""Requests as command lines of `beveloid-geom propose`, and refusals as text."""

from __future__ import annotations

import math
import shlex
from dataclasses import fields, replace

from ..design.model import Design
from ..pair.mounting import mounting_of
from .request import DEFAULT_BACKLASH_MODULES, Request, usual_tool


def options_of(request: Request, gear: str = "") -> dict[str, str]:
    """Return the options of a request with their values; defaults are omitted. `gear` is the file of a given
    gear."""
    defaults = {field.name: field.default for field in fields(Request)}
    options: dict[str, str] = {}
    deg = math.degrees(1.0)
    # Option of each field, and the factor to its unit.
    known: dict[str, tuple[str, float]] = {
        "module": ("--module", 1.0),
        "teeth": ("--teeth", 1.0),
        "pressure_angle": ("--pressure-angle-deg", deg),
        "face_widths": ("--face-widths", 1.0),
        "shaft_angle": ("--shaft-angle-deg", deg),
        "offset": ("--offset", 1.0),
        "backlash": ("--backlash", 1.0),
        "cone_angles": ("--cones-deg", deg),
        "helix_angle": ("--helix-deg", deg),
        "crossing": ("--crossing-deg", deg),
        "shifts": ("--shifts", 1.0),
        "cone_limits": ("--cone-limits-deg", deg),
        "helix_limits": ("--helix-limits-deg", deg),
        "shift_limits": ("--shift-limits", 1.0),
    }
    for name, (option, factor) in known.items():
        value = getattr(request, name)
        if value is not None and value != defaults[name]:
            listed = value if isinstance(value, tuple) else (value,)
            options[option] = " ".join(f"{number * factor:.6g}" for number in listed)
    if request.flank != defaults["flank"]:
        options["--flank"] = request.flank
    if request.least_cones:
        options["--least-cones"] = ""
    if request.gear is not None:
        options["--gear"] = shlex.quote(gear)
    return options


def command_of(request: Request, gear: str = "") -> str:
    """Return the command line of a request."""
    words = (f"{option} {value}".rstrip() for option, value in options_of(request, gear).items())
    return " ".join(("beveloid-geom propose", *words))


def refusal(request: Request, reason: str, nearest: Request | None) -> str:
    """Return the reason why there is no proposal, and the nearest request that has one, in one line."""
    if nearest is None:
        return f"{reason}; no change of limits or numbers was found that leads to a pair"
    given, changed = options_of(request), options_of(nearest)
    words = [f"{option} {value}".rstrip() for option, value in changed.items() if given.get(option) != value]
    removed = [option for option in given if option not in changed]
    parts = " ".join(words), f"without {' and '.join(removed)}" if removed else ""
    return f"{reason}; the nearest request with a solution: {' '.join(part for part in parts if part)}"


def requests_like(design: Design) -> tuple[Request, ...]:
    """Return requests for a pair similar to a single design without contact.

    The first keeps layout, shifts and the helix angle of the pinion, the second the shaft angle and the
    cones; all other quantities are free. The result is empty unless both members have the same usual tool."""
    # Largest backlash of a design that is used in a request; for larger ones the usual backlash is
    # used.
    max_backlash_modules = 0.2
    pinion, gear = design.members
    tool, module = pinion.tool, float(pinion.tool.normal_module)
    if tool.straight() != usual_tool(module, float(tool.normal_pressure_angle)):
        return ()
    if tool.straight() != gear.tool.straight():
        return ()
    backlash = float(mounting_of(design).normal_backlash)
    shared = Request(
        module=module,
        teeth=(int(pinion.teeth), int(gear.teeth)),
        face_widths=(float(pinion.face_width), float(gear.face_width)),
        shaft_angle=float(design.pair.shaft_angle),
        backlash=float(f"{backlash:.2g}")
        if 0.0 < backlash < max_backlash_modules * module
        else DEFAULT_BACKLASH_MODULES * module,
        pressure_angle=float(tool.normal_pressure_angle),
    )
    same_layout = replace(
        shared,
        offset=float(design.pair.offset),
        helix_angle=float(pinion.helix_angle),
        shifts=(float(pinion.profile_shift), float(gear.profile_shift)),
        least_cones=True,
    )
    return same_layout, replace(shared, cone_angles=(float(pinion.cone_angle), float(gear.cone_angle)))
