"""A request in words: as the options of `beveloid-geom propose`, and a refusal as one line."""

from __future__ import annotations

import math
import shlex
from dataclasses import fields, replace

from ..design.model import Design
from ..pair.mounting import mounting_of
from .request import BACKLASH, Request, usual_tool

DEG = math.degrees(1.0)
OPTIONS: dict[str, tuple[str, float]] = {
    "module": ("--module", 1.0),
    "teeth": ("--teeth", 1.0),
    "pressure_angle": ("--pressure-angle-deg", DEG),
    "face_widths": ("--face-widths", 1.0),
    "shaft_angle": ("--shaft-angle-deg", DEG),
    "offset": ("--offset", 1.0),
    "backlash": ("--backlash", 1.0),
    "cone_angles": ("--cones-deg", DEG),
    "helix_angle": ("--helix-deg", DEG),
    "crossing": ("--crossing-deg", DEG),
    "shifts": ("--shifts", 1.0),
    "cone_limits": ("--cone-limits-deg", DEG),
    "helix_limits": ("--helix-limits-deg", DEG),
    "shift_limits": ("--shift-limits", 1.0),
}
"""The option of a field, and what its value is multiplied by."""
DIGITS = 6
USUAL = 0.2
"""Modules of backlash up to which that of a design is asked for."""


def options_of(request: Request, gear: str = "") -> dict[str, str]:
    """Give the options that ask for this, with their values as they are typed; `gear` is the file of a gear
    that is given. Those that have their default are left out."""
    defaults = {field.name: field.default for field in fields(Request)}
    found: dict[str, str] = {}
    for name, (option, factor) in OPTIONS.items():
        value = getattr(request, name)
        if value is not None and value != defaults[name]:
            listed = value if isinstance(value, tuple) else (value,)
            found[option] = " ".join(f"{one * factor:.{DIGITS}g}" for one in listed)
    if request.flank != defaults["flank"]:
        found["--flank"] = request.flank
    if request.least_cones:
        found["--least-cones"] = ""
    if request.gear is not None:
        found["--gear"] = shlex.quote(gear)
    return found


def command_of(request: Request, gear: str = "") -> str:
    """Give the command line that asks for this."""
    words = (f"{option} {value}".rstrip() for option, value in options_of(request, gear).items())
    return " ".join(("beveloid-geom propose", *words))


def refusal(request: Request, reason: str, nearest: Request | None) -> str:
    """Say in a line why there is no proposal, and the nearest request for which there is one."""
    if nearest is None:
        return f"{reason}; no other limits or numbers were found that help"
    given, changed = options_of(request), options_of(nearest)
    words = [f"{option} {value}".rstrip() for option, value in changed.items() if given.get(option) != value]
    less = [option for option in given if option not in changed]
    parts = " ".join(words), f"without {' and '.join(less)}" if less else ""
    return f"{reason}; the nearest that works: {' '.join(part for part in parts if part)}"


def requests_like(design: Design) -> tuple[Request, ...]:
    """Give requests for a pair like a single design that does not close: with its layout, shifts and the
    pinion's helix angle, cones as they must be; with its shaft angle and cones, the rest as it must be. None
    for members of different tools."""
    pinion, gear = design.members
    tool, module = pinion.tool, float(pinion.tool.normal_module)
    if replace(tool, parabola=0.0) != usual_tool(module, float(tool.normal_pressure_angle)):
        return ()
    if replace(tool, parabola=0.0) != replace(gear.tool, parabola=0.0):
        return ()
    backlash = float(mounting_of(design).normal_backlash)
    shared = Request(
        module=module,
        teeth=(int(pinion.teeth), int(gear.teeth)),
        face_widths=(float(pinion.face_width), float(gear.face_width)),
        shaft_angle=float(design.pair.shaft_angle),
        backlash=float(f"{backlash:.2g}") if 0.0 < backlash < USUAL * module else BACKLASH * module,
        pressure_angle=float(tool.normal_pressure_angle),
    )
    laid_out = replace(
        shared,
        offset=float(design.pair.offset),
        helix_angle=float(pinion.helix_angle),
        shifts=(float(pinion.profile_shift), float(gear.profile_shift)),
        least_cones=True,
    )
    return laid_out, replace(shared, cone_angles=(float(pinion.cone_angle), float(gear.cone_angle)))
