"""Limits of a design that join several of its keys, and the faults they report.

Limits of single keys belong to the table of `field_limits`. Here, of the finished inputs of a file:

- the generating normal must lean outwards on both flanks, tan(alpha) > sin|beta| tan|gamma|;
  where its radial component vanishes the generating roll of Eq. 6 is infinite;
- so must it all along a parabolic flank, whose profile must not fold either;
- the tool must keep a flank between its tip round and the point where its flanks meet;
- on parallel axes the members must be made for each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from .field_limits import (
    IN_RADIANS,
    LIMITS,
    MIN_FLANK_DEPTH,
    Fault,
    base_pitch_fault,
    refused,
)
from .model import MATCH, PARALLEL, Errors, Member, MeshErrors, Pair

SAME_PITCH = 1e-9
"""Share by which base pitches in a file may differ."""
MOST_OFFSET_ERROR = 10.0
"""Modules, whole depths of teeth several times, by which the offset of a file may err."""
NORMAL_MARGIN = math.radians(1.0)  # local pressure angle above a vanishing radial normal
MAX_LOCAL_PRESSURE_ANGLE = math.radians(60.0)  # the rack profile folds at 90 deg


def in_degrees(angle: Any) -> float:
    """Give degrees for a message, free of the rounding of the way to rad and back."""
    return float(f"{math.degrees(angle):.6g}")


def outside(table: str, key: str, limit: str, value: object, cure: str) -> Fault:
    """Refuse a key whose value is outside its limit ('be between ...')."""
    return Fault(table, key, refused(limit, value, cure))


def parabola_limit(member: Member) -> float:
    """Find the largest magnitude of the parabola coefficient (1/mm) that `member` can be cut with.

    Over the height h = max(addendum, dedendum) m_n either side of the tool's reference line
    the local pressure angle alpha - tau, tan(tau) = 2 a l, must stay 1 deg above the angle at
    which the generating normal of a flank loses its radial component, atan(sin|beta|
    tan|gamma|), and below 60 deg. With l = tan(tau)/(2 a), x_n = l cos(alpha) +
    a l^2 sin(alpha) = h gives a = tan(tau) (cos(alpha) + tan(tau) sin(alpha)/2)/(2 h). A change
    of sign of a, l and x_n together changes nothing: one limit for concave and convex. Not
    positive where the cone is too steep for any tool of this pressure angle."""
    tool = member.tool
    alpha = float(tool.normal_pressure_angle)
    height = float(tool.normal_module) * max(float(tool.addendum), float(tool.dedendum))
    lowest = math.atan(abs(math.sin(member.helix_angle) * math.tan(member.cone_angle))) + NORMAL_MARGIN
    low, high = (
        bend * (math.cos(alpha) + 0.5 * bend * math.sin(alpha)) / (2.0 * height)
        for bend in (math.tan(alpha - lowest), math.tan(alpha - MAX_LOCAL_PRESSURE_ANGLE))
    )
    return min(low, -high)


def member_faults(name: str, member: Member) -> Iterator[Fault]:
    """Find what joins several keys of one member, each within its own limits."""
    tool, alpha = member.tool, float(member.tool.normal_pressure_angle)
    most = parabola_limit(member)
    if most <= 0.0:
        steepest = in_degrees(math.atan(math.tan(alpha - NORMAL_MARGIN) / abs(math.sin(member.helix_angle))))
        limit = f"be between -{steepest} and {steepest} deg at this helix and pressure angle"
        cure = "the tool would cut one flank from behind, take a larger pressure angle"
        yield outside(name, "cone_angle_deg", limit, in_degrees(member.cone_angle), cure)
    elif abs(float(tool.parabola)) > most:
        cure = "a stronger one folds the rack profile, usual are 0.0001 to 0.01"
        yield outside(name, "parabola", f"be between -{most:.4g} and {most:.4g} 1/mm", tool.parabola, cure)

    largest = (float(tool.dedendum) - MIN_FLANK_DEPTH) / (1.0 - math.sin(alpha))
    if float(tool.tip_radius) > largest:
        cure = "the round would eat the flank; it counts in normal modules, not in mm"
        yield outside(name, "tip_radius", f"be at most {largest:.4g} at this dedendum", tool.tip_radius, cure)
    tip = 0.5 * member.teeth / math.cos(member.helix_angle) + member.profile_shift + tool.addendum
    taper = 0.5 * member.face_width * abs(math.tan(member.cone_angle))
    if (radius := float(tool.normal_module * tip - taper)) <= 0.0:
        limit = "leave a tip radius at the narrow end of the face above 0 mm"
        yield outside(
            name, "face_width", limit, float(f"{radius:.6g}"), "take a narrower face or a smaller cone"
        )


def mesh_faults(pinion: Member, gear: Member) -> Iterator[Fault]:
    """Find what keeps two members from running together."""
    first, second = (m.tool.normal_module * math.cos(m.tool.normal_pressure_angle) for m in (pinion, gear))
    if fault := base_pitch_fault((first, second), SAME_PITCH, "_deg", "gear", "[pinion]"):
        yield fault


def offset_error_faults(pinion: Member, errors: Errors) -> Iterator[Fault]:
    """Refuse an error of the offset that takes the teeth far out of each other."""
    yield from _distance_faults("offset", pinion, errors.offset, "it adds to the offset")


def _distance_faults(key: str, pinion: Member, error: Any, cure: str) -> Iterator[Fault]:
    if abs(float(error)) > (most := MOST_OFFSET_ERROR * float(pinion.tool.normal_module)):
        limit = f"be between -{most:g} and {most:g} mm, {MOST_OFFSET_ERROR:g} modules"
        yield outside("errors", key, limit, error, f"{cure}, it does not replace it")


def parallel_faults(pinion: Member, gear: Member, pair: Pair) -> Iterator[Fault]:
    """Refuse members that do not fit each other on parallel axes.

    Flanks share a normal there only if the axial components of theirs are opposite, so that base helix angles
    are, on right and left flanks: sin(alpha) sin(gamma) and cos(alpha) sin(beta) cos(gamma) of both members
    must cancel. Where their pressure angles differ they then touch along cylinders alone, and unmodified."""
    if abs(math.sin(pair.shaft_angle)) > PARALLEL:
        return
    alphas, cones, helices = (
        tuple(float(getattr(part, name)) for part in parts)
        for parts, name in (
            ((pinion.tool, gear.tool), "normal_pressure_angle"),
            ((pinion, gear), "cone_angle"),
            ((pinion, gear), "helix_angle"),
        )
    )
    bent = any(float(member.tool.parabola) != 0.0 for member in (pinion, gear)) and any(helices)
    if abs(alphas[0] - alphas[1]) > MATCH and (any(cones) or bent):
        cure = (
            "on parallel axes cones, and helical teeth with parabolas, are cut by tools of one pressure angle"
        )
        limit = f"equal that of [pinion], {in_degrees(alphas[0])} deg"
        yield outside("gear", "normal_pressure_angle_deg", limit, in_degrees(alphas[1]), cure)
        return
    cone = -math.asin(math.sin(alphas[0]) * math.sin(cones[0]) / math.sin(alphas[1]))
    lean = math.cos(alphas[0]) * math.sin(helices[0]) * math.cos(cones[0])
    helix = -math.asin(lean / (math.cos(alphas[1]) * math.cos(cone)))
    fits = (
        ("helix_angle_deg", helix, helices[1], "on parallel axes base helix angles must be opposite"),
        ("cone_angle_deg", cone, cones[1], "on parallel axes one tooth must taper as the space of the other"),
    )
    for key, wanted, given, cure in fits:
        if abs(wanted - given) > MATCH:
            limit = f"be {in_degrees(wanted)} deg, opposite to that of [pinion]"
            if key == "helix_angle_deg" and wanted * given < 0.0:
                cure = "teeth of equal hands cross each other on parallel axes"
            yield outside("gear", key, limit, in_degrees(given), cure)


def given_at_mesh_faults(pinion: Member, pair: Pair, errors: MeshErrors) -> Iterator[Fault]:
    """Refuse errors at the mesh that take the teeth far out of each other, or turn axes past parallel."""
    cure = "it adds to the centre distance"
    yield from _distance_faults("centre_distance", pinion, errors.centre_distance, cure)
    shaft = float(pair.shaft_angle)
    if shaft > 0.0 and float(errors.in_plane) < -shaft:
        cure = "past parallel axes they would have another common perpendicular"
        yield outside(
            "errors",
            "in_plane_deg",
            f"be at least {-in_degrees(shaft)} deg",
            in_degrees(errors.in_plane),
            cure,
        )


def mesh_error_faults(pinion: Member, errors: Errors) -> Iterator[Fault]:
    """Refuse errors given at the mesh that come to more about the common perpendicular, where they are
    `errors`, than these may be."""
    given = vars(errors)
    if any(math.isnan(value) for value in given.values()):
        nowhere = 'cannot be "mesh": the flanks have no common normal, and the pair no mesh point'
        yield Fault("errors", "at", nowhere)
        return
    faults = [*offset_error_faults(pinion, errors)]
    for name, limit in LIMITS["Errors"].items():
        angle = limit.unit == "deg"
        value = in_degrees(given[name]) if angle else float(f"{given[name]:.6g}")
        if text := limit.fault(value):
            faults.append(Fault("errors", f"{name}_deg" if angle else name, text))
    for fault in faults:
        key = f'at = "mesh" comes to {fault.key} about the common perpendicular, which'
        yield Fault("errors", key, fault.text)


def radian_faults(pinion: Member, gear: Member, pair: Pair) -> Iterator[Fault]:
    """Refuse angles within their limits that fit together only if some were given in rad."""
    keys = ("pinion", "helix_angle_deg"), ("gear", "helix_angle_deg"), ("pair", "shaft_angle_deg")
    given = float(pinion.helix_angle), float(gear.helix_angle), float(pair.shaft_angle)
    scale, cones = 180.0 / math.pi, (float(pinion.cone_angle), float(gear.cone_angle))
    readings = (1, 1, 1), (1, 1, scale), (scale, scale, 1), (scale, 1, 1), (1, scale, 1)
    for factors in readings:
        first, second, shaft = (angle * factor for angle, factor in zip(given, factors, strict=True))
        # Shaft angle that fits the reference cones and tooth traces; working ones are near them.
        cosine = math.cos(cones[0]) * math.cos(cones[1]) * math.cos(first + second)
        fitting = math.acos(min(1.0, cosine - math.sin(cones[0]) * math.sin(cones[1])))
        tolerance = 0.2 if factors == readings[0] else 0.1
        if max(abs(first), abs(second), shaft) < 1.6 and abs(shaft - fitting) < tolerance * fitting:
            for (table, key), angle, factor in zip(keys, given, factors, strict=True):
                if factor > 1.0:
                    limit = f"be about {math.degrees(angle * factor):.3g} deg to fit the other angles"
                    yield outside(table, key, limit, in_degrees(angle), IN_RADIANS)
            return
