"""What is asked for: teeth, tool and layout of a pair, what of its members is given, and limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..design.field_limits import LIMITS, Fault, Limit, number_fault, refused
from ..design.limits import in_degrees, outside
from ..design.model import Member, Tool
from ..gear.fillet import tool_round

BACKLASH, MOST_BACKLASH = 0.04, 1.0
"""Modules of backlash if none is given, and at the most."""
FACE = 10.0
"""Modules of face width if none is given."""
NEAR_SUM = 1.35
"""What the sum of the reference cone angles may be over that of the working ones, or under it."""
NEAR_HELIX = 1.05
"""The same of helix angles."""
CANCELLING = math.radians(1.0)
"""Sum of helix angles of members whose axes intersect that profile shift can make of one that vanishes."""
INTERNAL = "internal gears are not covered, both members have teeth outside"


class Bounds(NamedTuple):
    """Least and greatest value."""

    low: float
    high: float


CONES = Bounds(math.radians(-15.0), math.radians(15.0))
HELICES = Bounds(math.radians(-45.0), math.radians(45.0))
SHIFTS = Bounds(-0.5, 0.8)
"""Limits of cone angles, helix angles and profile shifts, if none are given."""


@dataclass(frozen=True)
class Request:
    """A pair that is asked for; mm and rad, shifts in modules, right hand positive.

    `offset` None leaves it free, 0 lets the axes intersect. What of the members is given is one of these:
    `cone_angles`; `crossing`, the angle at which the generators of the drive `flank` cross, with the
    pinion's `helix_angle`; `least_cones`; the whole `gear`, for which the pinion is found, with its tool; on
    axes that intersect the helix angle alone. What is None is found within its limits."""

    module: float
    teeth: tuple[int, int]
    face_widths: tuple[float, float]
    shaft_angle: float
    backlash: float
    offset: float | None = None
    flank: str = "right"
    cone_angles: tuple[float, float] | None = None
    helix_angle: float | None = None
    crossing: float | None = None
    least_cones: bool = False
    shifts: tuple[float, float] | None = None
    gear: Member | None = None
    pressure_angle: float = math.radians(20.0)
    cone_limits: Bounds = CONES
    helix_limits: Bounds = HELICES
    shift_limits: Bounds = SHIFTS

    @property
    def members(self) -> tuple[Member, Member]:
        """Pinion and gear, of which teeth, tool and face are meant."""
        tool = usual_tool(self.module, self.pressure_angle)
        if self.gear is not None:
            tool = replace(self.gear.tool, parabola=0.0)
        sizes = zip(self.teeth, self.face_widths, strict=True)
        pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, face) for teeth, face in sizes)
        return pinion, self.gear or gear


def usual_tool(module: float, pressure_angle: float) -> Tool:
    """Give the usual basic rack, of a smaller tip round where the rounds of both flanks would overlap."""
    tool = Tool(module, pressure_angle)
    sine, cosine = math.sin(pressure_angle), math.cos(pressure_angle)
    whole = (0.25 * math.pi * cosine - float(tool.dedendum) * sine) / (1.0 - sine)  # one arc for both
    return replace(tool, tip_radius=min(float(tool.tip_radius), max(math.floor(100.0 * whole) / 100.0, 0.0)))


_BACKLASH = Limit(
    0.0, MOST_BACKLASH, "modules", ((math.inf, "it is along the normal, usual are 0.02 to 0.1"),)
)
_PRESSURE = Limit(5.0, 32.0, "deg", ((math.inf, "the usual basic rack is pointed, usual are 14.5 to 25"),))
_SHAFT = Limit(
    0.0,
    90.0,
    "deg",
    (
        (0.0, "give its magnitude, 0 is parallel axes"),
        (math.inf, "it is the smaller angle of the two axes, take 180 deg less it"),
    ),
)
_CROSSING = Limit(0.0, 90.0, "deg", ((math.inf, "give its magnitude, 0 is line contact"),))


def faults_of(request: Request) -> tuple[Fault, ...]:
    """Find what cannot be meant: single values first, then what contradicts itself."""
    return tuple(_single_faults(request)) or tuple(_joint_faults(request))


def _single_faults(request: Request) -> Iterator[Fault]:
    """Find values outside their limits, angles in deg."""
    tool, member, pair = LIMITS["Tool"], LIMITS["Member"], LIMITS["Pair"]
    cones, helix = request.cone_angles or (), request.helix_angle
    if text := number_fault(request.module, tool["normal_module"]):  # others are measured by it
        yield Fault("", "module", text)
        return
    checks: list[tuple[str, tuple[float | None, ...], Limit]] = [
        ("pressure_angle_deg", (request.pressure_angle,) if request.gear is None else (), _PRESSURE),
        ("face_widths", request.face_widths, member["face_width"]),
        ("shaft_angle_deg", (request.shaft_angle,), _SHAFT),
        ("offset", (request.offset,), pair["offset"]),
        ("cones_deg", cones, member["cone_angle"]),
        ("helix_deg", (helix,), member["helix_angle"]),
        ("crossing_deg", (request.crossing,), _CROSSING),
        ("shifts", request.shifts or (), member["profile_shift"]),
        ("cone_limits_deg", request.cone_limits, member["cone_angle"]),
        ("helix_limits_deg", request.helix_limits, member["helix_angle"]),
        ("shift_limits", request.shift_limits, member["profile_shift"]),
    ]
    yield from teeth_faults(request.teeth)
    for key, values, limit in checks:
        for value in values:
            given = value if value is None or limit.unit != "deg" else in_degrees(value)
            if given is not None and (text := number_fault(given, limit)):
                yield Fault("", key, text)
    if text := number_fault(request.backlash / request.module, _BACKLASH):
        yield Fault("", "backlash", text)
    for key, (low, high) in (
        ("cone_limits_deg", request.cone_limits),
        ("helix_limits_deg", request.helix_limits),
        ("shift_limits", request.shift_limits),
    ):
        if low > high:
            yield Fault("", key, "must be the least value first, then the greatest")


def teeth_faults(numbers: tuple[int, int]) -> Iterator[Fault]:
    """Find numbers of teeth that no member has."""
    for teeth in numbers:
        if teeth < 0:
            yield Fault("", "teeth", refused("be at least 1", teeth, INTERNAL))
        elif text := number_fault(teeth, LIMITS["Member"]["teeth"]):
            yield Fault("", "teeth", text)


def _joint_faults(request: Request) -> Iterator[Fault]:
    """Find what does not go together."""
    given = [name for name in ("cone_angles", "crossing", "gear") if getattr(request, name) is not None]
    given += ["least_cones"] * request.least_cones
    crossed_gear = set(given) == {"crossing", "gear"}
    alone = not given and request.offset == 0.0 and request.helix_angle is not None
    ways = "--cones-deg, --crossing-deg with --helix-deg, --least-cones or --gear"
    if len(given) != 1 and not crossed_gear and not alone:
        count = "nothing is given of" if not given else "too much is given of"
        yield Fault("", "", f"{count} the members: give one of {ways}")
        return
    if request.shaft_angle == 0.0:
        yield from _parallel_faults(request)
        return
    if request.offset is None and (request.crossing is not None or request.gear is not None):
        yield Fault(
            "", "offset", "is missing: it goes with --crossing-deg and --gear, 0 where axes intersect"
        )
    if request.gear is None and request.crossing is not None and request.helix_angle is None:
        yield Fault("", "helix_deg", "is missing: the pinion's helix angle goes with --crossing-deg")
    if request.gear is not None:
        yield from _gear_faults(request, request.gear)
    elif request.offset == 0.0 and request.crossing is not None:
        text = "does not go with --offset 0: on axes that intersect the helix angle makes it, leave it out"
        yield Fault("", "crossing_deg", text)
    if request.cone_angles is not None:
        yield from _cone_faults(request, request.cone_angles)


def _parallel_faults(request: Request) -> Iterator[Fault]:
    """Find what does not go with parallel axes, on which cones and helix angles of both members cancel."""
    if request.offset == 0.0:
        yield outside("", "offset", "be above 0 where the axes are parallel", 0.0, "or leave it out")
    if request.crossing is not None:
        text = "does not go with --shaft-angle-deg 0: flanks on parallel axes touch along lines, leave it out"
        yield Fault("", "crossing_deg", text)
    cure = "those of members on parallel axes cancel"
    if request.cone_angles is not None and sum(request.cone_angles) != 0.0:
        shown = " ".join(f"{in_degrees(cone):g}" for cone in request.cone_angles)
        yield Fault("", "cones_deg", refused("be opposite where the axes are parallel", shown, cure))
    gear, helix = request.gear, request.helix_angle
    if gear is not None and helix is not None and helix != -gear.helix_angle:
        limit = f"be {-in_degrees(gear.helix_angle):g} deg with this gear"
        yield outside("", "helix_deg", limit, in_degrees(helix), cure)
    if gear is not None:
        yield from _gear_faults(request, gear)


def _gear_faults(request: Request, gear: Member) -> Iterator[Fault]:
    """Find what does not go with a gear that is given whole."""
    for tool in (gear.tool, request.members[0].tool):
        try:
            tool_round(tool, "right")
        except ValueError as error:
            yield Fault("", "gear", f"has a tool that cuts no fillets: {error}")
            return
    if request.teeth[1] != gear.teeth:
        yield outside(
            "", "teeth", f"be {gear.teeth} of the gear, as --gear has", request.teeth[1], "change one"
        )
    if request.shifts is not None:
        yield Fault("", "shifts", "does not go with --gear, which has its own: use --shift-limits")
    if request.helix_angle is None or request.offset is None or request.shaft_angle == 0.0:
        return
    total, own = request.helix_angle + float(gear.helix_angle), -in_degrees(gear.helix_angle)
    if request.offset == 0.0 and abs(total) > CANCELLING:
        cure = "the hands of members whose axes intersect are opposite, their helix angles nearly cancel"
        yield outside(
            "", "helix_deg", f"be about {own:g} deg with this gear", in_degrees(request.helix_angle), cure
        )
    elif request.offset > 0.0 and abs(total) > request.shaft_angle + CANCELLING:
        low, high = (in_degrees(-float(gear.helix_angle) + way * request.shaft_angle) for way in (-1.0, 1.0))
        cure = "helix angles of both together make at most about the shaft angle"
        limit = f"be between {low:g} and {high:g} deg with this gear"
        yield outside("", "helix_deg", limit, in_degrees(request.helix_angle), cure)


def _cone_faults(request: Request, cones: tuple[float, float]) -> Iterator[Fault]:
    """Find cones that do not roll on each other at the shaft angle."""
    shown = " ".join(f"{in_degrees(cone):g}" for cone in cones)
    total, shaft = abs(sum(cones)), request.shaft_angle
    if request.offset == 0.0:
        if not shaft / NEAR_SUM < total < shaft * NEAR_SUM:
            cure = "on axes that intersect they make the shaft angle, leave --offset out for crossed axes"
            yield Fault("", "cones_deg", refused(f"be about {in_degrees(shaft):g} deg together", shown, cure))
        return
    if total > shaft * NEAR_SUM:
        cure = "cones whose sum is above the shaft angle do not roll on each other"
        yield Fault("", "cones_deg", refused(f"be at most {in_degrees(shaft):g} deg together", shown, cure))
        return
    # Reference angles are near the working ones, for which this holds.
    sine, cosine = (math.prod(function(cone) for cone in cones) for function in (math.sin, math.cos))
    needed = math.acos(min(1.0, (math.cos(shaft) + sine) / cosine))
    low, high = request.helix_limits
    reach = max(abs(2.0 * low), abs(2.0 * high))
    if needed > reach * NEAR_HELIX:
        cure = f"helix angles must make {in_degrees(needed):.4g} deg together, or take a smaller shaft angle"
        limit = f"reach to {in_degrees(0.5 * needed):.4g} deg"
        yield Fault("", "helix_limits_deg", refused(limit, f"{in_degrees(low):g} {in_degrees(high):g}", cure))
