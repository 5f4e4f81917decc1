"""Requests for a pair: teeth, tool, layout, given quantities of the members, limits; and their faults."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ..arrays import FLANK_SIGN
from ..design.arguments import require_numbers, require_two_numbers
from ..design.field_limits import LIMITS, Fault, FieldLimit, number_fault
from ..design.limits import in_degrees, outside
from ..design.member import Member, Tool
from ..design.written_numbers import refused
from ..gear.fillet import tool_round

DEFAULT_BACKLASH_MODULES = 0.04
"""Default normal backlash, modules."""


class Bounds(NamedTuple):
    """Lower and upper limit."""

    low: float
    high: float


@dataclass(frozen=True)
class Request:
    """Requirements on a pair.

    Exactly one of these is given: `cone_angles`; `crossing` with `helix_angle`; `least_cones`; `gear`, with
    or without `crossing`; or, on intersecting axes, `helix_angle` alone. Quantities that are None are
    computed within their limits.

    Attributes
    ----------
    module : float
        Normal module, mm.
    teeth : tuple of int
        Numbers of teeth of pinion and gear. All tuples are for pinion and gear.
    face_widths : tuple of float
        Face widths, mm.
    shaft_angle : float
        Magnitude of the shaft angle, rad.
    backlash : float
        Normal backlash, mm.
    offset : float or None
        Offset, mm; 0 for intersecting axes.
    flank : str
        Drive flanks.
    cone_angles : tuple of float or None
        Cone angles, rad.
    helix_angle : float or None
        Helix angle of the pinion, rad, right hand positive.
    crossing : float or None
        Crossing angle of the generators of the drive flanks, rad, not of the axes; 0 is line contact.
    least_cones : bool
        Whether the larger cone angle is minimised.
    shifts : tuple of float or None
        Profile shift coefficients.
    gear : Member or None
        Given gear; the pinion has the same tool.
    pressure_angle : float
        Normal pressure angle, rad.
    cone_limits, helix_limits, shift_limits : Bounds
        Limits of computed quantities, rad and modules.
    """

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
    cone_limits: Bounds = field(default=Bounds(math.radians(-15.0), math.radians(15.0)))
    helix_limits: Bounds = field(default=Bounds(math.radians(-45.0), math.radians(45.0)))
    shift_limits: Bounds = field(default=Bounds(-0.5, 0.8))

    @property
    def members(self) -> tuple[Member, Member]:
        """Pinion and gear with the given teeth, tool and face widths."""
        tool = usual_tool(self.module, self.pressure_angle)
        if self.gear is not None:
            tool = self.gear.tool.straight()
        sizes = zip(self.teeth, self.face_widths, strict=True)
        pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, face) for teeth, face in sizes)
        return pinion, self.gear or gear


def usual_tool(module: float, pressure_angle: float) -> Tool:
    """Return the usual basic rack; its tip radius is reduced if the rounds of both flanks would overlap."""
    tool = Tool(module, pressure_angle)
    sine, cosine = math.sin(pressure_angle), math.cos(pressure_angle)
    # The rounds of both flanks form a single arc.
    full_round = (0.25 * math.pi * cosine - float(tool.dedendum) * sine) / (1.0 - sine)
    largest = max(math.floor(100.0 * full_round) / 100.0, 0.0)
    return replace(tool, tip_radius=min(float(tool.tip_radius), largest))


def faults_of(request: Request) -> tuple[Fault, ...]:
    """Return the faults of a request: values outside their limits, or else contradictions.

    Parameters
    ----------
    request : Request

    Returns
    -------
    tuple of Fault
        Empty for a valid request.

    Raises
    ------
    TypeError
        For values that are not numbers.
    """
    values = vars(request)
    two = ("teeth", "face_widths", "cone_angles", "shifts", "cone_limits", "helix_limits", "shift_limits")
    require_two_numbers(**{name: values[name] for name in two})
    one = ("module", "shaft_angle", "backlash", "offset", "helix_angle", "crossing", "pressure_angle")
    require_numbers(**{name: values[name] for name in one})
    return tuple(_single_faults(request)) or tuple(_joint_faults(request))


def _single_faults(request: Request) -> Iterator[Fault]:
    """Yield values outside their limits, angles in deg."""
    tool, member, pair = LIMITS["Tool"], LIMITS["Member"], LIMITS["Pair"]
    cones, helix = request.cone_angles or (), request.helix_angle
    if text := number_fault(request.module, tool["normal_module"]):  # limits of other lengths depend on it
        yield Fault("", "module", text)
        return
    pressure = FieldLimit(5.0, 32.0, "deg", "usual are 14.5 to 25; at more than 32 the basic rack is pointed")
    smaller = "it is the smaller angle between the axes, give 180 deg minus this angle"
    shaft = FieldLimit(0.0, 90.0, "deg", smaller, ((0.0, "give its magnitude, 0 is parallel axes"),))
    crossing = FieldLimit(0.0, 90.0, "deg", "give its magnitude, 0 is line contact")
    usual = "it is the normal backlash, usual values are {:g} to {:g} mm"
    usual = usual.format(0.02 * request.module, 0.1 * request.module)
    checks: list[tuple[str, tuple[float | None, ...], FieldLimit]] = [
        ("pressure_angle_deg", (request.pressure_angle,) if request.gear is None else (), pressure),
        ("face_widths", request.face_widths, member["face_width"]),
        ("shaft_angle_deg", (request.shaft_angle,), shaft),
        ("offset", (request.offset,), pair["offset"]),
        ("backlash", (request.backlash,), FieldLimit(0.0, request.module, "mm", usual)),
        ("cones_deg", cones, member["cone_angle"]),
        ("helix_deg", (helix,), member["helix_angle"]),
        ("crossing_deg", (request.crossing,), crossing),
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
    limits = {"cone_limits": request.cone_limits, "helix_limits": request.helix_limits}
    in_deg = {f"{key}_deg": tuple(map(in_degrees, values)) for key, values in limits.items()}
    for key, (low, high) in (in_deg | {"shift_limits": request.shift_limits}).items():
        if low > high:
            yield Fault("", key, f"must have the lower limit first, got {low:g} {high:g}: exchange them")


def teeth_faults(numbers: tuple[int, int]) -> Iterator[Fault]:
    """Yield faults of numbers of teeth."""
    internal = "internal gears are not supported"
    for teeth in numbers:
        if teeth < 0:
            yield Fault("", "teeth", refused("be at least 1", teeth, internal))
        elif text := number_fault(teeth, LIMITS["Member"]["teeth"]):
            yield Fault("", "teeth", text)


def _joint_faults(request: Request) -> Iterator[Fault]:
    """Yield contradictions between given quantities."""
    given = [name for name in ("cone_angles", "crossing", "gear") if getattr(request, name) is not None]
    given += ["least_cones"] * request.least_cones
    crossed_gear = set(given) == {"crossing", "gear"}
    alone = not given and request.offset == 0.0 and request.helix_angle is not None
    ways = "--cones-deg, --crossing-deg with --helix-deg, --least-cones or --gear"
    if len(given) != 1 and not crossed_gear and not alone:
        count = "no quantity" if not given else "more than one kind of quantity"
        yield Fault("", "", f"{count} of the members is given: give one of {ways}")
        return
    if request.shaft_angle == 0.0:
        yield from _parallel_faults(request)
        return
    if request.offset is None and (request.crossing is not None or request.gear is not None):
        text = "is missing: --crossing-deg and --gear need it, 0 for intersecting axes"
        yield Fault("", "offset", text)
    if request.gear is None and request.crossing is not None and request.helix_angle is None:
        yield Fault("", "helix_deg", "is missing: --crossing-deg needs the helix angle of the pinion")
    if request.gear is not None:
        yield from _gear_faults(request, request.gear)
    elif request.offset == 0.0 and request.crossing is not None:
        text = "cannot be given with --offset 0: on intersecting axes it follows from the helix angle"
        yield Fault("", "crossing_deg", text)
    if request.cone_angles is not None:
        yield from _cone_faults(request, request.cone_angles)


def _parallel_faults(request: Request) -> Iterator[Fault]:
    """Yield contradictions on parallel axes, where cone and helix angles of both members cancel."""
    if request.offset == 0.0:
        yield outside("", "offset", "be above 0 on parallel axes", 0.0, "or leave it out")
    if request.crossing is not None:
        text = "cannot be given with --shaft-angle-deg 0: flanks on parallel axes have line contact"
        yield Fault("", "crossing_deg", text)
    cure = "on parallel axes the angles of both members cancel"
    if request.cone_angles is not None and sum(request.cone_angles) != 0.0:
        shown = " ".join(f"{in_degrees(cone):g}" for cone in request.cone_angles)
        yield Fault("", "cones_deg", refused("be opposite on parallel axes", shown, cure))
    gear, helix = request.gear, request.helix_angle
    if gear is not None and helix is not None and helix != -gear.helix_angle:
        limit = f"be {-in_degrees(gear.helix_angle):g} deg with this gear"
        yield outside("", "helix_deg", limit, in_degrees(helix), cure)
    if gear is not None:
        yield from _gear_faults(request, gear)


def _gear_faults(request: Request, gear: Member) -> Iterator[Fault]:
    """Yield contradictions with a given gear."""
    # Largest sum of the reference helix angles on intersecting axes, rad; the working helix angles
    # cancel.
    helix_sum_tolerance = math.radians(1.0)
    for tool in (gear.tool, request.members[0].tool):
        try:
            for flank in FLANK_SIGN:
                tool_round(tool, flank)
        except ValueError as error:
            yield Fault("", "gear", f"has a tool without a fillet: {error}")
            return
    if request.teeth[1] != gear.teeth:
        yield outside("", "teeth", f"be {gear.teeth} for the gear of --gear", request.teeth[1], "change one")
    if request.shifts is not None:
        yield Fault("", "shifts", "cannot be given with --gear, which has a shift: use --shift-limits")
    if request.helix_angle is None or request.offset is None or request.shaft_angle == 0.0:
        return
    total, fitting = request.helix_angle + float(gear.helix_angle), -in_degrees(gear.helix_angle)
    if request.offset == 0.0 and abs(total) > helix_sum_tolerance:
        cure = "on intersecting axes the hands are opposite and the helix angles nearly cancel"
        limit = f"be about {fitting:g} deg with this gear"
        yield outside("", "helix_deg", limit, in_degrees(request.helix_angle), cure)
    elif request.offset > 0.0 and abs(total) > request.shaft_angle + helix_sum_tolerance:
        low, high = (in_degrees(-float(gear.helix_angle) + s * request.shaft_angle) for s in (-1.0, 1.0))
        cure = "the sum of both helix angles is at most about the shaft angle"
        limit = f"be between {low:g} and {high:g} deg with this gear"
        yield outside("", "helix_deg", limit, in_degrees(request.helix_angle), cure)


def _cone_faults(request: Request, cones: tuple[float, float]) -> Iterator[Fault]:
    """Yield faults of cones that do not roll on each other at the shaft angle."""
    # Largest ratio of the sums of reference and working cone angles, and of its inverse.
    cone_sum_factor = 1.35
    # Largest ratio of the sums of reference and working helix angles.
    helix_sum_factor = 1.05
    shown = " ".join(f"{in_degrees(cone):g}" for cone in cones)
    total, shaft = abs(sum(cones)), request.shaft_angle
    if request.offset == 0.0:
        if not shaft / cone_sum_factor < total < shaft * cone_sum_factor:
            cure = "on intersecting axes their sum is the shaft angle, leave --offset out for crossed axes"
            yield Fault(
                "", "cones_deg", refused(f"have a sum of about {in_degrees(shaft):g} deg", shown, cure)
            )
        return
    if total > shaft * cone_sum_factor:
        cure = "cones whose sum is above the shaft angle do not roll on each other"
        yield Fault("", "cones_deg", refused(f"have a sum of at most {in_degrees(shaft):g} deg", shown, cure))
        return
    # The equation holds for the working angles, which are close to the reference angles.
    sine, cosine = (math.prod(function(cone) for cone in cones) for function in (math.sin, math.cos))
    needed = math.acos(min(1.0, (math.cos(shaft) + sine) / cosine))
    low, high = request.helix_limits
    reach = max(abs(2.0 * low), abs(2.0 * high))
    if needed > reach * helix_sum_factor:
        cure = f"the helix angles need a sum of {in_degrees(needed):.4g} deg, or choose a smaller shaft angle"
        limit = f"reach to {in_degrees(0.5 * needed):.4g} deg"
        yield Fault("", "helix_limits_deg", refused(limit, f"{in_degrees(low):g} {in_degrees(high):g}", cure))
